//! A Vulkan driver as a compiler.

use crate::spirv::{Binding, Shader, Stage, Target};
use crate::{Allowed, Error, assembly};
use ash::khr::pipeline_executable_properties;
use ash::vk;
use std::collections::BTreeMap;
use std::ffi::c_char;

/// What a driver made of a shader.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Executable {
    /// Its stage.
    pub stage: Stage,
    /// The driver's statistics, by the driver's names.
    pub statistics: BTreeMap<String, u64>,
    /// The driver's forms of it, such as its assembly: names and texts.
    pub texts: Vec<(String, String)>,
}

/// Whether the driver keeps its forms of a shader, which takes longer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Texts {
    /// It does not.
    None,
    /// It does.
    All,
}

/// A driver that compiles.
pub struct Driver {
    device: ash::Device,
    executables: pipeline_executable_properties::Device,
    name: String,
    // Dropped after the device, which lives in it.
    _instance: Instance,
}

struct Instance {
    raw: ash::Instance,
    // The library must stay.
    _entry: ash::Entry,
}

impl Drop for Instance {
    fn drop(&mut self) {
        // SAFETY: nothing that was made from it is left: `Driver` destroys its device before.
        unsafe { self.raw.destroy_instance(None) };
    }
}

impl Drop for Driver {
    fn drop(&mut self) {
        // SAFETY: what is made on it is destroyed in the function that makes it.
        unsafe { self.device.destroy_device(None) };
    }
}

/// Names the call that failed.
fn failed(call: &'static str) -> impl Fn(vk::Result) -> Error {
    move |result| Error::Vulkan(call, result)
}

impl Driver {
    /// Opens the first device that the environment of this process allows.
    ///
    /// # Errors
    /// [`Error::Loader`] or [`Error::NoDevice`] where Vulkan or a driver is not installed,
    /// [`Error::Vulkan`] if the driver has no executable properties.
    pub fn open() -> Result<Driver, Error> {
        Driver::open_where(|_| true)
    }

    /// Opens the device with these numbers of vendor and device.
    ///
    /// # Errors
    /// As [`Driver::open`].
    pub fn open_device(vendor: u32, device: u32) -> Result<Driver, Error> {
        Driver::open_where(|found| (found.vendor_id, found.device_id) == (vendor, device))
    }

    fn open_where(
        is_wanted: impl Fn(&vk::PhysicalDeviceProperties) -> bool,
    ) -> Result<Driver, Error> {
        // SAFETY: the library of this name is Vulkan's loader.
        let entry = unsafe { ash::Entry::load() }?;
        let application = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_3);
        let info = vk::InstanceCreateInfo::default().application_info(&application);
        // SAFETY: the structures are valid.
        let raw = unsafe { entry.create_instance(&info, None) }.map_err(|result| match result {
            vk::Result::ERROR_INCOMPATIBLE_DRIVER => Error::NoDevice,
            other => Error::Vulkan("vkCreateInstance", other),
        })?;
        let instance = Instance { raw, _entry: entry };
        // SAFETY: the instance is alive.
        let devices = unsafe { instance.raw.enumerate_physical_devices() }
            .map_err(failed("vkEnumeratePhysicalDevices"))?;
        let wanted = |physical: &vk::PhysicalDevice| {
            // SAFETY: the device is of this instance.
            is_wanted(&unsafe { instance.raw.get_physical_device_properties(*physical) })
        };
        let physical = devices.into_iter().find(wanted).ok_or(Error::NoDevice)?;
        let name = name(&instance.raw, physical);
        let device = device(&instance.raw, physical)?;
        Ok(Driver {
            executables: pipeline_executable_properties::Device::new(&instance.raw, &device),
            device,
            name,
            _instance: instance,
        })
    }

    /// Returns the driver's name and version.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Compiles a compute shader, or a vertex and a fragment shader that draw together, with
    /// a depth picture.
    ///
    /// # Safety
    /// The modules must be valid by the Vulkan specification, as spirv-val checks.
    ///
    /// # Errors
    /// [`Error::Module`] if the stages are neither, [`Error::Vulkan`] if the driver refuses
    /// them.
    pub unsafe fn compile(
        &self,
        shaders: &[&Shader],
        texts: Texts,
    ) -> Result<Vec<Executable>, Error> {
        let mut made = Made::new(&self.device);
        made.lay_out(shaders)?;
        for shader in shaders {
            made.load(shader)?;
        }
        let stages: Vec<_> = shaders
            .iter()
            .zip(&made.modules)
            .map(|(shader, &module)| {
                vk::PipelineShaderStageCreateInfo::default()
                    .stage(flag(shader.stage))
                    .module(module)
                    .name(&shader.name)
            })
            .collect();
        let kept = match texts {
            Texts::None => vk::PipelineCreateFlags::empty(),
            Texts::All => vk::PipelineCreateFlags::CAPTURE_INTERNAL_REPRESENTATIONS_KHR,
        };
        let flags = kept | vk::PipelineCreateFlags::CAPTURE_STATISTICS_KHR;
        match shaders {
            [only] if only.stage == Stage::Compute => made.compute(stages[0], flags)?,
            [vertex, fragment]
                if (vertex.stage, fragment.stage) == (Stage::Vertex, Stage::Fragment) =>
            {
                made.graphics(&stages, flags, &fragment.targets)?;
            }
            _ => {
                return Err(Error::Module(
                    "neither a compute shader nor a vertex and a fragment shader".to_string(),
                ));
            }
        }
        self.read(made.pipeline, texts)
    }

    /// Reads what the driver says of a pipeline.
    fn read(&self, pipeline: vk::Pipeline, texts: Texts) -> Result<Vec<Executable>, Error> {
        let info = vk::PipelineInfoKHR::default().pipeline(pipeline);
        // SAFETY: the pipeline is alive and of this device.
        let all = unsafe { self.executables.get_pipeline_executable_properties(&info) }
            .map_err(failed("vkGetPipelineExecutablePropertiesKHR"))?;
        let mut found = Vec::new();
        for (index, properties) in (0..).zip(&all) {
            let stages = [Stage::Vertex, Stage::Fragment, Stage::Compute];
            let is_it = |stage: &Stage| properties.stages.contains(flag(*stage));
            let Some(stage) = stages.into_iter().find(is_it) else {
                continue;
            };
            let info = vk::PipelineExecutableInfoKHR::default()
                .pipeline(pipeline)
                .executable_index(index);
            found.push(Executable {
                stage,
                statistics: self.statistics(&info)?,
                texts: match texts {
                    Texts::None => Vec::new(),
                    Texts::All => self.texts(&info)?,
                },
            });
        }
        Ok(found)
    }

    fn statistics(
        &self,
        info: &vk::PipelineExecutableInfoKHR<'_>,
    ) -> Result<BTreeMap<String, u64>, Error> {
        // SAFETY: its pipeline is alive, and was made with statistics.
        let all = unsafe { self.executables.get_pipeline_executable_statistics(info) }
            .map_err(failed("vkGetPipelineExecutableStatisticsKHR"))?;
        let whole = all
            .iter()
            .filter(|one| one.format == vk::PipelineExecutableStatisticFormatKHR::UINT64);
        Ok(whole
            // SAFETY: the format says that the union holds this member.
            .map(|one| (text(&one.name), unsafe { one.value.u64 }))
            .collect())
    }

    fn texts(
        &self,
        info: &vk::PipelineExecutableInfoKHR<'_>,
    ) -> Result<Vec<(String, String)>, Error> {
        let call = "vkGetPipelineExecutableInternalRepresentationsKHR";
        let functions = &self.executables;
        // SAFETY: its pipeline is alive, and was made with its representations.
        let mut all = unsafe { functions.get_pipeline_executable_internal_representations(info) }
            .map_err(failed(call))?;
        // The first call told the sizes.
        let mut bytes: Vec<Vec<u8>> = all.iter().map(|one| vec![0; one.data_size]).collect();
        for (one, bytes) in all.iter_mut().zip(&mut bytes) {
            one.p_data = bytes.as_mut_ptr().cast();
        }
        let mut count = all.len() as u32;
        // SAFETY: `all` has `count` structures, each with room for the size that it says.
        unsafe {
            (functions
                .fp()
                .get_pipeline_executable_internal_representations_khr)(
                self.device.handle(),
                info,
                &mut count,
                all.as_mut_ptr(),
            )
        }
        .result()
        .map_err(failed(call))?;
        let texts = all.iter().zip(bytes).map(|(one, bytes)| {
            let end = bytes.iter().position(|&byte| byte == 0);
            let bytes = &bytes[..end.unwrap_or(bytes.len())];
            (text(&one.name), String::from_utf8_lossy(bytes).into_owned())
        });
        Ok(texts.collect())
    }
}

impl Executable {
    /// Returns a statistic by the driver's name; `None` if the driver has none of this name.
    pub fn statistic(&self, name: &str) -> Option<u64> {
        self.statistics.get(name).copied()
    }

    /// Returns one of the driver's forms of it by name; `None` if the driver has not kept it.
    pub fn text(&self, name: &str) -> Option<&str> {
        let mut texts = self.texts.iter();
        let found = texts.find(|(known, _)| known == name);
        found.map(|(_, text)| text.as_str())
    }

    /// Returns what Mesa's compiler for AMD has made inexact: the faults of its assembly
    /// ([`assembly::faults`]), and the sums and products that it was free to rewrite before
    /// ([`assembly::free`]); `None` if the driver has not kept both forms.
    pub fn faults(&self, allowed: &Allowed) -> Option<Vec<String>> {
        let mut found = assembly::faults(self.text("Assembly")?, allowed);
        found.extend(assembly::free(self.text("ACO IR")?));
        Some(found)
    }
}

/// A text that Vulkan ends with a 0.
fn text(characters: &[c_char]) -> String {
    let bytes = characters.iter().map(|&character| character as u8);
    let bytes: Vec<u8> = bytes.take_while(|&byte| byte != 0).collect();
    String::from_utf8_lossy(&bytes).into_owned()
}

fn flag(stage: Stage) -> vk::ShaderStageFlags {
    match stage {
        Stage::Vertex => vk::ShaderStageFlags::VERTEX,
        Stage::Fragment => vk::ShaderStageFlags::FRAGMENT,
        Stage::Compute => vk::ShaderStageFlags::COMPUTE,
    }
}

/// The driver's version, as "Mesa 22.3.6".
fn name(instance: &ash::Instance, physical: vk::PhysicalDevice) -> String {
    let mut driver = vk::PhysicalDeviceDriverProperties::default();
    let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut driver);
    // SAFETY: the device is of this instance.
    unsafe { instance.get_physical_device_properties2(physical, &mut properties) };
    text(&driver.driver_info)
}

fn device(instance: &ash::Instance, physical: vk::PhysicalDevice) -> Result<ash::Device, Error> {
    let extensions = [pipeline_executable_properties::NAME.as_ptr()];
    let queues = [vk::DeviceQueueCreateInfo::default().queue_priorities(&[1.0])];
    let mut executables = vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR::default()
        .pipeline_executable_info(true);
    // rust-gpu's modules declare this model.
    let mut memory = vk::PhysicalDeviceVulkan12Features::default().vulkan_memory_model(true);
    let mut rendering = vk::PhysicalDeviceVulkan13Features::default().dynamic_rendering(true);
    let buffers = vk::PhysicalDeviceFeatures::default()
        // As wgpu does.
        .robust_buffer_access(true)
        .fragment_stores_and_atomics(true)
        .vertex_pipeline_stores_and_atomics(true);
    let info = vk::DeviceCreateInfo::default()
        .queue_create_infos(&queues)
        .enabled_extension_names(&extensions)
        .enabled_features(&buffers)
        .push_next(&mut executables)
        .push_next(&mut memory)
        .push_next(&mut rendering);
    // SAFETY: the structures are valid, and the device is of this instance.
    unsafe { instance.create_device(physical, &info, None) }.map_err(failed("vkCreateDevice"))
}

/// What is made to compile once, and destroyed after it.
struct Made<'a> {
    device: &'a ash::Device,
    modules: Vec<vk::ShaderModule>,
    sets: Vec<vk::DescriptorSetLayout>,
    layout: vk::PipelineLayout,
    pipeline: vk::Pipeline,
}

impl Drop for Made<'_> {
    fn drop(&mut self) {
        // SAFETY: all are of this device, and nothing was submitted to it. Vulkan ignores
        // those that were not made.
        unsafe {
            self.device.destroy_pipeline(self.pipeline, None);
            self.device.destroy_pipeline_layout(self.layout, None);
            for &set in &self.sets {
                self.device.destroy_descriptor_set_layout(set, None);
            }
            for &module in &self.modules {
                self.device.destroy_shader_module(module, None);
            }
        }
    }
}

impl<'a> Made<'a> {
    fn new(device: &'a ash::Device) -> Made<'a> {
        Made {
            device,
            modules: Vec::new(),
            sets: Vec::new(),
            layout: vk::PipelineLayout::null(),
            pipeline: vk::Pipeline::null(),
        }
    }

    /// Makes the layout of the resources of all shaders.
    fn lay_out(&mut self, shaders: &[&Shader]) -> Result<(), Error> {
        let mut sets: BTreeMap<u32, BTreeMap<u32, Binding>> = BTreeMap::new();
        for (&(set, binding), &kind) in shaders.iter().flat_map(|shader| &shader.bindings) {
            sets.entry(set).or_default().insert(binding, kind);
        }
        let count = sets.keys().next_back().map_or(0, |last| last + 1);
        for number in 0..count {
            let bindings: Vec<_> = sets
                .get(&number)
                .into_iter()
                .flatten()
                .map(|(&binding, &kind)| {
                    vk::DescriptorSetLayoutBinding::default()
                        .binding(binding)
                        .descriptor_type(descriptor(kind))
                        .descriptor_count(1)
                        .stage_flags(vk::ShaderStageFlags::ALL)
                })
                .collect();
            let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
            // SAFETY: the structures are valid.
            let set = unsafe { self.device.create_descriptor_set_layout(&info, None) }
                .map_err(failed("vkCreateDescriptorSetLayout"))?;
            self.sets.push(set);
        }
        let info = vk::PipelineLayoutCreateInfo::default().set_layouts(&self.sets);
        // SAFETY: the sets are of this device.
        self.layout = unsafe { self.device.create_pipeline_layout(&info, None) }
            .map_err(failed("vkCreatePipelineLayout"))?;
        Ok(())
    }

    fn load(&mut self, shader: &Shader) -> Result<(), Error> {
        let info = vk::ShaderModuleCreateInfo::default().code(&shader.words);
        // SAFETY: required of the caller of `Driver::compile`.
        let module = unsafe { self.device.create_shader_module(&info, None) }
            .map_err(failed("vkCreateShaderModule"))?;
        self.modules.push(module);
        Ok(())
    }

    fn compute(
        &mut self,
        stage: vk::PipelineShaderStageCreateInfo<'_>,
        flags: vk::PipelineCreateFlags,
    ) -> Result<(), Error> {
        let info = vk::ComputePipelineCreateInfo::default()
            .flags(flags)
            .stage(stage)
            .layout(self.layout);
        let cache = vk::PipelineCache::null();
        // SAFETY: the module and the layout are of this device.
        let made = unsafe { self.device.create_compute_pipelines(cache, &[info], None) };
        self.keep(made, "vkCreateComputePipelines")
    }

    fn graphics(
        &mut self,
        stages: &[vk::PipelineShaderStageCreateInfo<'_>],
        flags: vk::PipelineCreateFlags,
        targets: &BTreeMap<u32, Target>,
    ) -> Result<(), Error> {
        let count = targets.keys().next_back().map_or(0, |last| last + 1);
        let formats: Vec<_> = (0..count)
            .map(|location| targets.get(&location).map_or(vk::Format::UNDEFINED, format))
            .collect();
        let written = vk::PipelineColorBlendAttachmentState::default()
            .color_write_mask(vk::ColorComponentFlags::RGBA);
        let written = vec![written; formats.len()];
        let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&written);
        let mut rendering = vk::PipelineRenderingCreateInfo::default()
            .color_attachment_formats(&formats)
            .depth_attachment_format(vk::Format::D32_SFLOAT);
        let inputs = vk::PipelineVertexInputStateCreateInfo::default();
        let assembly = vk::PipelineInputAssemblyStateCreateInfo::default()
            .topology(vk::PrimitiveTopology::TRIANGLE_LIST);
        let size = vk::Extent2D {
            width: 800,
            height: 600,
        };
        let ports = [vk::Viewport {
            width: size.width as f32,
            height: size.height as f32,
            max_depth: 1.0,
            ..vk::Viewport::default()
        }];
        let scissors = [size.into()];
        let view = vk::PipelineViewportStateCreateInfo::default()
            .viewports(&ports)
            .scissors(&scissors);
        let raster = vk::PipelineRasterizationStateCreateInfo::default().line_width(1.0);
        let samples = vk::PipelineMultisampleStateCreateInfo::default()
            .rasterization_samples(vk::SampleCountFlags::TYPE_1);
        let depth = vk::PipelineDepthStencilStateCreateInfo::default()
            .depth_test_enable(true)
            .depth_write_enable(true)
            .depth_compare_op(vk::CompareOp::LESS);
        let info = vk::GraphicsPipelineCreateInfo::default()
            .push_next(&mut rendering)
            .flags(flags)
            .stages(stages)
            .vertex_input_state(&inputs)
            .input_assembly_state(&assembly)
            .viewport_state(&view)
            .rasterization_state(&raster)
            .multisample_state(&samples)
            .depth_stencil_state(&depth)
            .color_blend_state(&blend)
            .layout(self.layout);
        let cache = vk::PipelineCache::null();
        // SAFETY: the modules and the layout are of this device.
        let made = unsafe { self.device.create_graphics_pipelines(cache, &[info], None) };
        self.keep(made, "vkCreateGraphicsPipelines")
    }

    fn keep(
        &mut self,
        made: Result<Vec<vk::Pipeline>, (Vec<vk::Pipeline>, vk::Result)>,
        call: &'static str,
    ) -> Result<(), Error> {
        let (pipelines, result) = match made {
            Ok(pipelines) => (pipelines, Ok(())),
            Err((pipelines, result)) => (pipelines, Err(Error::Vulkan(call, result))),
        };
        if let Some(&pipeline) = pipelines.first() {
            self.pipeline = pipeline;
        }
        result
    }
}

fn descriptor(kind: Binding) -> vk::DescriptorType {
    match kind {
        Binding::StorageBuffer => vk::DescriptorType::STORAGE_BUFFER,
        Binding::UniformBuffer => vk::DescriptorType::UNIFORM_BUFFER,
        Binding::SampledImage => vk::DescriptorType::SAMPLED_IMAGE,
        Binding::StorageImage => vk::DescriptorType::STORAGE_IMAGE,
        Binding::Sampler => vk::DescriptorType::SAMPLER,
        Binding::SampledImageAndSampler => vk::DescriptorType::COMBINED_IMAGE_SAMPLER,
    }
}

fn format(target: &Target) -> vk::Format {
    match target {
        Target::Float => vk::Format::R32G32B32A32_SFLOAT,
        Target::Signed => vk::Format::R32G32B32A32_SINT,
        Target::Unsigned => vk::Format::R32G32B32A32_UINT,
    }
}
