//! A Vulkan driver that forwards every call to another driver and fails on
//! request. It simulates a lost GPU, one out of memory and one that hangs.
//!
//! Three environment variables control it. `FAULTY_DRIVER_LIBRARY` is the file
//! of the driver behind it. `FAULTY_DRIVER_FAULT` is the fault (`lost`,
//! `memory`, `refused` or `hang`; none if unset). `FAULTY_DRIVER_CALL` is the
//! number, from 1, of the first call to fail, counting the calls that can fail
//! in this way; later ones fail as well. It reports a discrete GPU, so that
//! programs that prefer those choose it.

#![allow(non_snake_case, reason = "Vulkan's names")]

use ash::vk;
use std::ffi::{CStr, c_char, c_void};
use std::mem::transmute;
use std::sync::LazyLock;
use std::sync::atomic::{AtomicBool, AtomicPtr, AtomicU64, Ordering};
use std::thread;

/// Kinds of failure.
const LOST: u32 = 1;
const MEMORY: u32 = 2;
/// Of shaders.
const REFUSED: u32 = 4;
/// Work is accepted and never finishes.
const HANG: u32 = 8;
/// Waiting for all work, which never ends if the device hangs.
const IDLE: u32 = 16;

/// The fault, and the first call that fails.
static FAULT: LazyLock<(u32, u64)> = LazyLock::new(|| {
    let setting = |name: &str| std::env::var(name).unwrap_or_default();
    let fault = match setting("FAULTY_DRIVER_FAULT").as_str() {
        "" => 0,
        "lost" => LOST,
        "memory" => MEMORY,
        "refused" => REFUSED,
        "hang" => HANG,
        other => panic!("FAULTY_DRIVER_FAULT is {other:?}"),
    };
    let call = setting("FAULTY_DRIVER_CALL").parse().unwrap_or(1);
    (fault, call)
});

/// Number of calls so far that can fail in this way.
static CALLS: AtomicU64 = AtomicU64::new(0);

/// Whether the device hangs: submitted work never finishes.
static HANGS: AtomicBool = AtomicBool::new(false);

/// Returns the failure of a call that can fail in these ways, if it must fail.
fn failure(ways: u32) -> Option<vk::Result> {
    if ways & IDLE != 0 && HANGS.load(Ordering::SeqCst) {
        loop {
            thread::park();
        }
    }
    let (fault, first) = *FAULT;
    if ways & fault == 0 || CALLS.fetch_add(1, Ordering::SeqCst) + 1 < first {
        return None;
    }
    Some(match fault {
        LOST => {
            stop();
            vk::Result::ERROR_DEVICE_LOST
        }
        MEMORY => vk::Result::ERROR_OUT_OF_DEVICE_MEMORY,
        REFUSED => vk::Result::ERROR_INVALID_SHADER_NV,
        _ => {
            HANGS.store(true, Ordering::SeqCst);
            vk::Result::SUCCESS
        }
    })
}

/// Waits for the real device, because a lost one does no more work.
fn stop() {
    let (device, wait) = (
        DEVICE.load(Ordering::SeqCst),
        vkDeviceWaitIdle::REAL.load(Ordering::SeqCst),
    );
    if device != 0 && !wait.is_null() {
        // SAFETY: the driver returned it for this name and device, and wgpu
        // uses its queue under a lock.
        let _ = unsafe { transmute::<*mut (), vkDeviceWaitIdle::Type>(wait)(device) };
    }
}

/// The last device created.
static DEVICE: AtomicU64 = AtomicU64::new(0);

type Function = unsafe extern "system" fn();
type GetProc = unsafe extern "system" fn(u64, *const c_char) -> Option<Function>;

/// The real driver.
static DRIVER: LazyLock<libloading::Library> = LazyLock::new(|| {
    let path = std::env::var_os("FAULTY_DRIVER_LIBRARY").expect("FAULTY_DRIVER_LIBRARY is set");
    // SAFETY: it is a Vulkan driver, which the loader would load too.
    unsafe { libloading::Library::new(path) }.expect("FAULTY_DRIVER_LIBRARY is a library")
});

/// Returns an exported function of the real driver.
///
/// # Safety
/// `T` must be its type.
unsafe fn exported<T: Copy>(name: &CStr) -> Option<T> {
    unsafe { DRIVER.get::<T>(name.to_bytes_with_nul()) }
        .ok()
        .map(|found| *found)
}

/// Calls that can fail, their failures, and the functions that replace them.
/// All return a `VkResult`.
macro_rules! failing {
    ($($ways:expr => $name:ident $(| $alias:literal)? ($($argument:ident: $type:ty),*);)*) => {
        /// Replaces the driver's function `real` of this name.
        fn stand_in(name: &CStr, real: Function) -> Function {
            match name.to_str() {
                $(Ok(stringify!($name) $(| $alias)?) => {
                    $name::REAL.store(real as *mut (), Ordering::SeqCst);
                    // SAFETY: who asks for this name calls it as what it is.
                    unsafe { transmute::<$name::Type, Function>($name::call as $name::Type) }
                })*
                _ => real,
            }
        }
        $(mod $name {
            use super::*;
            pub static REAL: AtomicPtr<()> = AtomicPtr::new(std::ptr::null_mut());
            pub type Type = unsafe extern "system" fn($($type),*) -> vk::Result;
            pub unsafe extern "system" fn call($($argument: $type),*) -> vk::Result {
                if let Some(result) = failure($ways) {
                    return result;
                }
                // SAFETY: the driver returned it for this name.
                unsafe {
                    transmute::<*mut (), Type>(REAL.load(Ordering::SeqCst))($($argument),*)
                }
            }
        })*
    };
}

/// A handle, which the API defines as a pointer or a number.
type Handle = u64;
type Pointer = *const c_void;

failing! {
    MEMORY => vkAllocateMemory(device: Handle, info: Pointer, allocator: Pointer, out: Pointer);
    MEMORY => vkMapMemory(
        device: Handle, memory: Handle, offset: u64, size: u64, flags: u32, out: Pointer);
    MEMORY => vkBindBufferMemory(device: Handle, buffer: Handle, memory: Handle, offset: u64);
    MEMORY => vkBindImageMemory(device: Handle, image: Handle, memory: Handle, offset: u64);
    MEMORY => vkCreateBuffer(device: Handle, info: Pointer, allocator: Pointer, out: Pointer);
    MEMORY => vkCreateImage(device: Handle, info: Pointer, allocator: Pointer, out: Pointer);
    MEMORY => vkCreateImageView(device: Handle, info: Pointer, allocator: Pointer, out: Pointer);
    MEMORY => vkCreateRenderPass(device: Handle, info: Pointer, allocator: Pointer, out: Pointer);
    MEMORY => vkCreateFramebuffer(device: Handle, info: Pointer, allocator: Pointer, out: Pointer);
    MEMORY => vkCreatePipelineLayout(
        device: Handle, info: Pointer, allocator: Pointer, out: Pointer);
    MEMORY => vkCreateDescriptorSetLayout(
        device: Handle, info: Pointer, allocator: Pointer, out: Pointer);
    MEMORY => vkCreateDescriptorPool(
        device: Handle, info: Pointer, allocator: Pointer, out: Pointer);
    MEMORY => vkAllocateDescriptorSets(device: Handle, info: Pointer, out: Pointer);
    MEMORY => vkCreateQueryPool(device: Handle, info: Pointer, allocator: Pointer, out: Pointer);
    MEMORY => vkCreateSemaphore(device: Handle, info: Pointer, allocator: Pointer, out: Pointer);
    MEMORY => vkCreateFence(device: Handle, info: Pointer, allocator: Pointer, out: Pointer);
    MEMORY => vkCreateCommandPool(device: Handle, info: Pointer, allocator: Pointer, out: Pointer);
    MEMORY => vkAllocateCommandBuffers(device: Handle, info: Pointer, out: Pointer);
    MEMORY => vkBeginCommandBuffer(buffer: Handle, info: Pointer);
    MEMORY => vkEndCommandBuffer(buffer: Handle);
    MEMORY | REFUSED => vkCreateShaderModule(
        device: Handle, info: Pointer, allocator: Pointer, out: Pointer);
    MEMORY | REFUSED => vkCreateGraphicsPipelines(
        device: Handle, cache: Handle, count: u32, infos: Pointer, allocator: Pointer,
        out: Pointer);
    MEMORY | REFUSED => vkCreateComputePipelines(
        device: Handle, cache: Handle, count: u32, infos: Pointer, allocator: Pointer,
        out: Pointer);
    MEMORY | LOST | HANG => vkQueueSubmit(queue: Handle, count: u32, submits: Pointer, fence: Handle);
    LOST | IDLE => vkQueueWaitIdle(queue: Handle);
    LOST | IDLE => vkDeviceWaitIdle(device: Handle);
    LOST => vkGetFenceStatus(device: Handle, fence: Handle);
    LOST => vkGetSemaphoreCounterValue | "vkGetSemaphoreCounterValueKHR" (
        device: Handle, semaphore: Handle, out: Pointer);
    LOST => vkWaitForFences(
        device: Handle, count: u32, fences: Pointer, all: u32, timeout: u64);
    LOST => vkWaitSemaphores | "vkWaitSemaphoresKHR" (
        device: Handle, info: Pointer, timeout: u64);
}

/// Lookup functions of the real driver, for instances and devices.
static INSTANCE_PROC: LazyLock<GetProc> = LazyLock::new(|| {
    // SAFETY: the loader's interface gives it this type.
    unsafe { exported(c"vk_icdGetInstanceProcAddr") }.expect("the library is a Vulkan driver")
});
static DEVICE_PROC: AtomicPtr<()> = AtomicPtr::new(std::ptr::null_mut());

/// Negotiates the version of the interface between loader and driver.
///
/// # Safety
/// For the Vulkan loader only.
#[unsafe(no_mangle)]
pub unsafe extern "system" fn vk_icdNegotiateLoaderICDInterfaceVersion(
    version: *mut u32,
) -> vk::Result {
    type Negotiate = unsafe extern "system" fn(*mut u32) -> vk::Result;
    // SAFETY: the loader's interface gives it this type.
    match unsafe { exported::<Negotiate>(c"vk_icdNegotiateLoaderICDInterfaceVersion") } {
        // SAFETY: forwarded unchanged.
        Some(negotiate) => unsafe { negotiate(version) },
        None => vk::Result::ERROR_INCOMPATIBLE_DRIVER,
    }
}

/// Functions of instances.
///
/// # Safety
/// For the Vulkan loader only.
#[unsafe(no_mangle)]
pub unsafe extern "system" fn vk_icdGetInstanceProcAddr(
    instance: Handle,
    name: *const c_char,
) -> Option<Function> {
    // SAFETY: forwarded unchanged, and the name is valid.
    let (real, name) = unsafe { (INSTANCE_PROC(instance, name)?, CStr::from_ptr(name)) };
    Some(match name.to_bytes() {
        b"vkGetDeviceProcAddr" => {
            DEVICE_PROC.store(real as *mut (), Ordering::SeqCst);
            // SAFETY: who asks for this name calls it as what it is.
            unsafe { transmute::<GetProc, Function>(device_proc as GetProc) }
        }
        b"vkGetPhysicalDeviceProperties" => {
            PROPERTIES.store(real as *mut (), Ordering::SeqCst);
            // SAFETY: as above.
            unsafe { transmute::<Properties, Function>(properties as Properties) }
        }
        b"vkGetPhysicalDeviceProperties2" | b"vkGetPhysicalDeviceProperties2KHR" => {
            PROPERTIES_2.store(real as *mut (), Ordering::SeqCst);
            // SAFETY: as above.
            unsafe { transmute::<Properties2, Function>(properties_2 as Properties2) }
        }
        _ => stand_in(name, real),
    })
}

/// Functions of physical devices.
///
/// # Safety
/// For the Vulkan loader only.
#[unsafe(no_mangle)]
pub unsafe extern "system" fn vk_icdGetPhysicalDeviceProcAddr(
    instance: Handle,
    name: *const c_char,
) -> Option<Function> {
    // SAFETY: the loader's interface gives it this type.
    let get = unsafe { exported::<GetProc>(c"vk_icdGetPhysicalDeviceProcAddr") }?;
    // SAFETY: forwarded unchanged.
    unsafe {
        get(instance, name)?;
        vk_icdGetInstanceProcAddr(instance, name)
    }
}

unsafe extern "system" fn device_proc(device: Handle, name: *const c_char) -> Option<Function> {
    DEVICE.store(device, Ordering::SeqCst);
    // SAFETY: the driver returned it for this name, and the name is valid.
    unsafe {
        let get = transmute::<*mut (), GetProc>(DEVICE_PROC.load(Ordering::SeqCst));
        Some(stand_in(CStr::from_ptr(name), get(device, name)?))
    }
}

type Properties = unsafe extern "system" fn(Handle, *mut vk::PhysicalDeviceProperties);
type Properties2 = unsafe extern "system" fn(Handle, *mut vk::PhysicalDeviceProperties2<'static>);
static PROPERTIES: AtomicPtr<()> = AtomicPtr::new(std::ptr::null_mut());
static PROPERTIES_2: AtomicPtr<()> = AtomicPtr::new(std::ptr::null_mut());

unsafe extern "system" fn properties(device: Handle, out: *mut vk::PhysicalDeviceProperties) {
    // SAFETY: the driver returned it for this name, and fills the structure.
    unsafe {
        transmute::<*mut (), Properties>(PROPERTIES.load(Ordering::SeqCst))(device, out);
        (*out).device_type = vk::PhysicalDeviceType::DISCRETE_GPU;
    }
}

unsafe extern "system" fn properties_2(
    device: Handle,
    out: *mut vk::PhysicalDeviceProperties2<'static>,
) {
    // SAFETY: as above.
    unsafe {
        transmute::<*mut (), Properties2>(PROPERTIES_2.load(Ordering::SeqCst))(device, out);
        (*out).properties.device_type = vk::PhysicalDeviceType::DISCRETE_GPU;
    }
}
