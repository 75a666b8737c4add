//! A Vulkan driver that hands every call on to another one, and fails when it
//! is told to: what a lost GPU, one without memory and one that hangs do can be
//! seen on a machine with none of them.
//!
//! Three environment variables tell it: `FAULTY_DRIVER_LIBRARY` is the file of
//! the driver behind it, `FAULTY_DRIVER_FAULT` the fault (`lost`, `memory`,
//! `refused` or `hang`; none without it), and `FAULTY_DRIVER_CALL` the number
//! from 1 of the first call that fails, of those that can fail in this way;
//! every later one fails as well. It calls itself a discrete GPU, so that a
//! program that prefers those takes it.

#![allow(non_snake_case, reason = "Vulkan's names")]

use ash::vk;
use std::ffi::{CStr, c_char, c_void};
use std::mem::transmute;
use std::sync::LazyLock;
use std::sync::atomic::{AtomicBool, AtomicPtr, AtomicU64, Ordering};
use std::thread;

/// How a call may fail.
const LOST: u32 = 1;
const MEMORY: u32 = 2;
/// Of shaders.
const REFUSED: u32 = 4;
/// Work is taken and never done.
const HANG: u32 = 8;
/// Waiting for all work, which has no end where the device hangs.
const IDLE: u32 = 16;

/// The fault to make, and from which call on.
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

/// Calls so far that could have failed as wanted.
static CALLS: AtomicU64 = AtomicU64::new(0);

/// Whether the device hangs: what it was given will never be done.
static HANGS: AtomicBool = AtomicBool::new(false);

/// The failure of a call that can fail in these ways, where it is to fail.
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

/// Waits for the device behind: one that is lost works no more.
fn stop() {
    let (device, wait) = (
        DEVICE.load(Ordering::SeqCst),
        vkDeviceWaitIdle::REAL.load(Ordering::SeqCst),
    );
    if device != 0 && !wait.is_null() {
        // SAFETY: the driver gave it out under this name, for this device, and
        // wgpu uses its queue under a lock.
        let _ = unsafe { transmute::<*mut (), vkDeviceWaitIdle::Type>(wait)(device) };
    }
}

/// The device that was made last.
static DEVICE: AtomicU64 = AtomicU64::new(0);

type Function = unsafe extern "system" fn();
type GetProc = unsafe extern "system" fn(u64, *const c_char) -> Option<Function>;

/// The driver behind this one.
static DRIVER: LazyLock<libloading::Library> = LazyLock::new(|| {
    let path = std::env::var_os("FAULTY_DRIVER_LIBRARY").expect("FAULTY_DRIVER_LIBRARY is set");
    // SAFETY: it is a Vulkan driver, which the loader would load as well.
    unsafe { libloading::Library::new(path) }.expect("FAULTY_DRIVER_LIBRARY is a library")
});

/// An exported function of the driver behind.
///
/// # Safety
/// `T` must be its type.
unsafe fn exported<T: Copy>(name: &CStr) -> Option<T> {
    unsafe { DRIVER.get::<T>(name.to_bytes_with_nul()) }
        .ok()
        .map(|found| *found)
}

/// Calls that may fail, each with the ways in which it may, and what stands in
/// for them: all of them return a `VkResult`.
macro_rules! failing {
    ($($ways:expr => $name:ident $(| $alias:literal)? ($($argument:ident: $type:ty),*);)*) => {
        /// The function that stands in for the driver's `real` of this name.
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
                // SAFETY: the driver gave it out under this name.
                unsafe {
                    transmute::<*mut (), Type>(REAL.load(Ordering::SeqCst))($($argument),*)
                }
            }
        })*
    };
}

/// A handle, whether the API makes it a pointer or a number.
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

/// Where the driver behind finds the functions of instances and of devices.
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
        // SAFETY: handed on as it came.
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
    // SAFETY: handed on as they came, and the name is one.
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
    // SAFETY: handed on as they came.
    unsafe {
        get(instance, name)?;
        vk_icdGetInstanceProcAddr(instance, name)
    }
}

unsafe extern "system" fn device_proc(device: Handle, name: *const c_char) -> Option<Function> {
    DEVICE.store(device, Ordering::SeqCst);
    // SAFETY: the driver gave it out under this name, and the name is one.
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
    // SAFETY: the driver gave it out under this name, and fills what it is given.
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
