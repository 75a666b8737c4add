//! Runs the compute shaders of a module on a device.
//!
//! ```
//! use relievo_bitwise::{Module, Runner, adapters};
//! use relievo_kernel::{Domain, Kernel, Kind, table};
//!
//! const LENGTH: Domain = Domain::new("length", Kind::Magnitude { low: 1e-9, high: 1e9 });
//! const KERNELS: &[Kernel] = table! {
//!     double(f32: LENGTH) -> f32 = |x: f32| x + x;
//! };
//!
//! # fn compiled() -> Result<Vec<u8>, Box<dyn std::error::Error>> {
//! #     let module = naga::front::wgsl::parse_str(
//! #         "@group(0) @binding(0) var<storage, read> inputs: array<f32>;
//! #         @group(0) @binding(1) var<storage, read_write> outputs: array<f32>;
//! #         @compute @workgroup_size(64)
//! #         fn double(@builtin(global_invocation_id) id: vec3<u32>) {
//! #             outputs[id.x] = inputs[id.x] + inputs[id.x];
//! #         }",
//! #     )?;
//! #     let flags = naga::valid::ValidationFlags::all();
//! #     let capabilities = naga::valid::Capabilities::empty();
//! #     let info = naga::valid::Validator::new(flags, capabilities).validate(&module)?;
//! #     let words = naga::back::spv::write_vec(&module, &info, &Default::default(), None)?;
//! #     Ok(words.iter().flat_map(|word| word.to_le_bytes()).collect())
//! # }
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let spirv = compiled()?;
//! let module = Module::portable(&[&spirv])?;
//! for adapter in adapters() {
//!     let mut runner = Runner::new(&adapter.open()?, &module)?;
//!     let words = runner.run(&KERNELS[0], &[3_f32.to_bits()])?;
//!     assert_eq!(words, [6_f32.to_bits()]);
//! }
//! # Ok(())
//! # }
//! ```

use crate::{Device, DeviceError, Module};
use relievo_kernel::{Kernel, WORKGROUP};
use std::collections::BTreeMap;

/// Initial value of every word of a result: a NaN that no arithmetic produces, so
/// that a word that is not written is a difference.
const UNWRITTEN: u32 = 0xffee_d1ff;

/// Runs kernels as compute shaders. Keeps pipelines and buffers between runs.
pub struct Runner {
    device: Device,
    module: Module,
    bindings: wgpu::BindGroupLayout,
    layout: wgpu::PipelineLayout,
    pipelines: BTreeMap<&'static str, wgpu::ComputePipeline>,
    buffers: Option<Buffers>,
}

/// Buffers for the words of one dispatch.
struct Buffers {
    input_bytes: u64,
    output_bytes: u64,
    input: wgpu::Buffer,
    /// [`UNWRITTEN`], as long as the output.
    unwritten: wgpu::Buffer,
    output: wgpu::Buffer,
    read_back: wgpu::Buffer,
}

/// A submitted dispatch.
#[must_use = "the results are lost unless they are collected"]
pub struct Pending<'a> {
    device: &'a Device,
    read_back: &'a wgpu::Buffer,
    bytes: u64,
}

impl Runner {
    /// Makes a runner for the entry points of `module`. Each is loaded on `device`
    /// at its first run.
    ///
    /// # Errors
    /// [`DeviceError::Device`] if the device fails.
    pub fn new(device: &Device, module: &Module) -> Result<Runner, DeviceError> {
        let (bindings, layout) = device.attempt(|| {
            let entries = [true, false].map(|read_only| wgpu::BindGroupLayoutEntry {
                binding: if read_only { 0 } else { 1 },
                visibility: wgpu::ShaderStages::COMPUTE,
                ty: wgpu::BindingType::Buffer {
                    ty: wgpu::BufferBindingType::Storage { read_only },
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
                count: None,
            });
            let bindings =
                device
                    .wgpu()
                    .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                        label: Some("bitwise"),
                        entries: &entries,
                    });
            let layout = device
                .wgpu()
                .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                    label: Some("bitwise"),
                    bind_group_layouts: &[Some(&bindings)],
                    immediate_size: 0,
                });
            Ok::<_, DeviceError>((bindings, layout))
        })?;
        Ok(Runner {
            device: device.clone(),
            module: module.clone(),
            bindings,
            layout,
            pipelines: BTreeMap::new(),
            buffers: None,
        })
    }

    /// Returns the device that kernels run on.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// Returns the module with the kernels.
    pub fn module(&self) -> &Module {
        &self.module
    }

    /// Returns the largest number of inputs of `kernel` in one dispatch, a multiple
    /// of [`WORKGROUP`].
    ///
    /// # Errors
    /// [`DeviceError::Kernel`] if the kernel has no arguments or no result,
    /// [`DeviceError::Limit`] if one workgroup exceeds the device's limits.
    pub fn capacity(&self, kernel: &Kernel) -> Result<usize, DeviceError> {
        let widest = u64::from(kernel.input_words.max(kernel.output_words));
        if kernel.input_words == 0 || kernel.output_words == 0 {
            return Err(DeviceError::Kernel {
                kernel: kernel.name,
                message: "it has no arguments or no result; give it both".to_string(),
            });
        }
        let largest = self.device.largest_storage();
        let group_bytes = 4 * widest * u64::from(WORKGROUP);
        let groups = (largest / group_bytes).min(u64::from(
            self.device
                .wgpu()
                .limits()
                .max_compute_workgroups_per_dimension
                .min(65_535),
        ));
        if groups == 0 {
            return Err(DeviceError::Limit {
                adapter: self.device.describe().to_string(),
                what: format!("a workgroup of kernel {:?} (bytes)", kernel.name),
                needed: group_bytes,
                limit: largest,
            });
        }
        Ok(groups as usize * WORKGROUP as usize)
    }

    /// Runs `kernel` on all `inputs`, of `input_words` words each, and returns
    /// `output_words` words for each.
    ///
    /// # Errors
    /// Those of [`Runner::submit`], without the limit on the number of inputs, and
    /// of [`Pending::collect`].
    pub fn run(&mut self, kernel: &Kernel, inputs: &[u32]) -> Result<Vec<u32>, DeviceError> {
        let dispatch = self.capacity(kernel)? * kernel.input_words as usize;
        let mut all = Vec::new();
        let mut words = Vec::new();
        for part in inputs.chunks(dispatch) {
            self.submit(kernel, part)?.collect(&mut words)?;
            all.extend_from_slice(&words);
        }
        Ok(all)
    }

    /// Starts `kernel` on at most [`Runner::capacity`] inputs and returns without
    /// waiting for the device.
    ///
    /// # Errors
    /// [`DeviceError::Kernel`] if the last input is incomplete, there is none, or the
    /// module has no such compute shader,
    /// [`DeviceError::Limit`] if there are too many inputs,
    /// [`DeviceError::Device`] if the device fails.
    pub fn submit(&mut self, kernel: &Kernel, inputs: &[u32]) -> Result<Pending<'_>, DeviceError> {
        let capacity = self.capacity(kernel)?;
        let input_words = kernel.input_words as usize;
        let count = inputs.len() / input_words;
        if count == 0 || !inputs.len().is_multiple_of(input_words) {
            return Err(DeviceError::Kernel {
                kernel: kernel.name,
                message: format!(
                    "{} words are not one or more inputs of {input_words} words; give whole ones",
                    inputs.len()
                ),
            });
        }
        if count > capacity {
            return Err(DeviceError::Limit {
                adapter: self.device.describe().to_string(),
                what: format!("a dispatch of kernel {:?} (inputs)", kernel.name),
                needed: count as u64,
                limit: capacity as u64,
            });
        }
        let padded = count.next_multiple_of(WORKGROUP as usize);
        // The last workgroup is filled with the last input, which is in the domain.
        let padding = inputs[inputs.len() - input_words..].repeat(padded - count);
        let bytes = |words: u32| 4 * u64::from(words) * padded as u64;
        let (input_bytes, output_bytes) = (bytes(kernel.input_words), bytes(kernel.output_words));

        let pipeline = self.pipeline(kernel.name)?;
        let device = self.device.clone();
        let buffers = device.attempt(|| {
            let kept = self.buffers.take().filter(|buffers| {
                buffers.input_bytes >= input_bytes && buffers.output_bytes >= output_bytes
            });
            let buffers = match kept {
                Some(buffers) => buffers,
                None => Buffers::new(&self.device, input_bytes, output_bytes),
            };
            let queue = self.device.queue();
            queue.write_buffer(&buffers.input, 0, bytemuck::cast_slice(inputs));
            if !padding.is_empty() {
                let end = 4 * inputs.len() as u64;
                queue.write_buffer(&buffers.input, end, bytemuck::cast_slice(&padding));
            }
            // The shader's arrays have the length of this dispatch, not the buffer's.
            let part = |buffer, bytes| {
                wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                    buffer,
                    offset: 0,
                    size: wgpu::BufferSize::new(bytes),
                })
            };
            let group = self
                .device
                .wgpu()
                .create_bind_group(&wgpu::BindGroupDescriptor {
                    label: Some(kernel.name),
                    layout: &self.bindings,
                    entries: &[
                        wgpu::BindGroupEntry {
                            binding: 0,
                            resource: part(&buffers.input, input_bytes),
                        },
                        wgpu::BindGroupEntry {
                            binding: 1,
                            resource: part(&buffers.output, output_bytes),
                        },
                    ],
                });
            let mut encoder = self
                .device
                .wgpu()
                .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            encoder.copy_buffer_to_buffer(&buffers.unwritten, 0, &buffers.output, 0, output_bytes);
            {
                let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                    label: Some(kernel.name),
                    timestamp_writes: None,
                });
                pass.set_pipeline(&pipeline);
                pass.set_bind_group(0, &group, &[]);
                pass.dispatch_workgroups((padded / WORKGROUP as usize) as u32, 1, 1);
            }
            encoder.copy_buffer_to_buffer(&buffers.output, 0, &buffers.read_back, 0, output_bytes);
            queue.submit([encoder.finish()]);
            Ok::<_, DeviceError>(buffers)
        })?;
        let buffers = self.buffers.insert(buffers);
        Ok(Pending {
            device: &self.device,
            read_back: &buffers.read_back,
            bytes: 4 * u64::from(kernel.output_words) * count as u64,
        })
    }

    fn pipeline(&mut self, name: &'static str) -> Result<wgpu::ComputePipeline, DeviceError> {
        if let Some(pipeline) = self.pipelines.get(name) {
            return Ok(pipeline.clone());
        }
        let refused = |message: String| DeviceError::Kernel {
            kernel: name,
            message,
        };
        let entry_point = self.module.entry_point(name).ok_or_else(|| {
            refused("the module has no such entry point; make the function and the modules around it public, and compile it again".to_string())
        })?;
        if entry_point.workgroup != Some([WORKGROUP, 1, 1]) {
            return Err(refused(format!(
                "its entry point's workgroup is {:?}; make it #[spirv(compute(threads({WORKGROUP})))]",
                entry_point.workgroup
            )));
        }
        let shader = self.module.load(&self.device, name)?;
        let pipeline = self.device.attempt(|| {
            let descriptor = wgpu::ComputePipelineDescriptor {
                label: Some(name),
                layout: Some(&self.layout),
                module: &shader,
                entry_point: Some(&entry_point.name),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            };
            Ok::<_, DeviceError>(self.device.wgpu().create_compute_pipeline(&descriptor))
        })?;
        self.pipelines.insert(name, pipeline.clone());
        Ok(pipeline)
    }
}

impl Buffers {
    fn new(device: &Device, input_bytes: u64, output_bytes: u64) -> Buffers {
        use wgpu::BufferUsages as Usage;
        let buffer = |label, size, usage| {
            device.wgpu().create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage,
                mapped_at_creation: false,
            })
        };
        let unwritten = buffer("unwritten", output_bytes, Usage::COPY_DST | Usage::COPY_SRC);
        let pattern = vec![UNWRITTEN; output_bytes as usize / 4];
        device
            .queue()
            .write_buffer(&unwritten, 0, bytemuck::cast_slice(&pattern));
        Buffers {
            input_bytes,
            output_bytes,
            input: buffer("input", input_bytes, Usage::STORAGE | Usage::COPY_DST),
            unwritten,
            output: buffer(
                "output",
                output_bytes,
                Usage::STORAGE | Usage::COPY_DST | Usage::COPY_SRC,
            ),
            read_back: buffer("read back", output_bytes, Usage::COPY_DST | Usage::MAP_READ),
        }
    }
}

impl Pending<'_> {
    /// Waits for the device and replaces the contents of `words` by the results.
    ///
    /// # Errors
    /// [`DeviceError::Device`] if the device fails.
    pub fn collect(self, words: &mut Vec<u32>) -> Result<(), DeviceError> {
        words.clear();
        self.device.read(self.read_back, self.bytes, |bytes| {
            words.extend(
                bytes
                    .as_chunks()
                    .0
                    .iter()
                    .map(|&word| u32::from_ne_bytes(word)),
            );
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{self, SILENT, TABLE, runners};
    use relievo_kernel::{Argument, Domain};

    #[test]
    fn gpu_any_number_of_inputs_comes_back_in_order() {
        let scale = &TABLE[2];
        for mut runner in runners() {
            // Buffers grow and are reused for fewer inputs; the last workgroup is
            // padded.
            for count in [1, 63, 64, 65, 100_003, 5, 4096] {
                let inputs: Vec<u32> = (0..count).map(|n| (n as f32).to_bits()).collect();
                let words = runner.run(scale, &inputs).expect("a run");
                let mut expected = vec![0; inputs.len()];
                (scale.run)(&inputs, &mut expected);
                assert_eq!(words, expected, "{count}");
            }
            assert!(runner.run(scale, &[]).expect("nothing").is_empty());
        }
    }

    #[test]
    fn gpu_more_inputs_than_a_dispatch_takes_are_split() {
        let scale = &TABLE[2];
        let mut runner = runners().remove(0);
        let capacity = runner.capacity(scale).expect("some");
        assert!(capacity <= 65_535 * 64 && capacity.is_multiple_of(64));
        let inputs: Vec<u32> = (0..capacity as u32 + 70)
            .map(|n| ((n % 9973) as f32).to_bits())
            .collect();
        let words = runner.run(scale, &inputs).expect("a run");
        let mut expected = vec![0; inputs.len()];
        (scale.run)(&inputs, &mut expected);
        assert!(words == expected);
        let error = runner.submit(scale, &inputs).err().expect("too many");
        assert!(matches!(error, DeviceError::Limit { .. }), "{error}");
    }

    #[test]
    fn gpu_words_that_the_shader_does_not_write_are_marked() {
        for mut runner in runners() {
            // Results of an earlier run must not remain in the buffer.
            runner.run(&TABLE[2], &[7; 64]).expect("a run");
            let words = runner.run(&SILENT[0], &[7; 64]).expect("a run");
            assert_eq!(words, [UNWRITTEN; 64]);
        }
    }

    #[test]
    fn gpu_a_kernel_that_does_not_match_is_rejected_by_name() {
        const WORD: &[Argument] = &[Argument::new(1, Domain::integer("word", 0, 1))];
        let kernel = |name, input_words, output_words| Kernel {
            name,
            arguments: WORD,
            input_words,
            output_words,
            run: |_, _| {},
        };
        for mut runner in runners() {
            let mut refused = |kernel: Kernel, words: usize| {
                let error = runner.run(&kernel, &vec![0; words]).unwrap_err();
                assert!(error.to_string().contains(kernel.name), "{error}");
                error.to_string()
            };
            assert!(refused(kernel("missing", 1, 1), 1).contains("no such entry point"));
            assert!(refused(kernel("narrow", 1, 1), 1).contains("[32, 1, 1]"));
            assert!(refused(kernel("scale", 0, 1), 1).contains("no arguments"));
            assert!(refused(kernel("scale", 2, 1), 3).contains("3 words"));
            assert!(refused(kernel("scale", 1, u32::MAX), 1).contains("limit"));
            let scaled = runner.run(&TABLE[2], &[0]).expect("it still works");
            assert_eq!(scaled, [0]);
        }
    }

    #[test]
    fn gpu_a_module_that_naga_rejects_is_an_error() {
        let mut bytes = testing::shader();
        // Cut off the end of the last function.
        bytes.truncate(bytes.len() - 8);
        let module = Module::portable(&[&bytes]).expect("what comes before is whole");
        let all = crate::adapters();
        assert!(!all.is_empty(), "no adapter on this machine");
        for adapter in all {
            let device = adapter.open().expect("a device");
            let mut runner = Runner::new(&device, &module).expect("nothing is loaded yet");
            let error = runner.run(&TABLE[2], &[0]).unwrap_err();
            assert!(matches!(error, DeviceError::Module { .. }), "{error}");
        }
    }
}
