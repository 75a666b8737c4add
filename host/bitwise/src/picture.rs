//! Draws pictures with a module's vertex and fragment shaders, and returns their words.

use crate::{Device, DeviceError, Module, interface};

/// What a fragment shader writes to location 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pixels {
    /// A `Vec4`.
    Floats,
    /// A `UVec4`.
    Words,
}

/// A picture of triangles that read all they need from storage buffers.
#[derive(Clone, Copy, Debug)]
pub struct Picture<'a> {
    /// Name of the vertex shader.
    pub vertex: &'a str,
    /// Name of the fragment shader.
    pub fragment: &'a str,
    /// What the fragment shader writes.
    pub pixels: Pixels,
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Number of vertices: 3 of a triangle that covers the picture.
    pub vertices: u32,
    /// Words of the storage buffers, bindings 0, 1, … of group 0.
    pub buffers: &'a [&'a [u32]],
}

impl Picture<'_> {
    /// Draws the picture. Returns four words a pixel, in rows from the top. Pixels that no
    /// triangle covers are 0. Buffers must be as long as the shaders read, which is not
    /// checked.
    ///
    /// # Errors
    /// [`DeviceError::Picture`] if the shaders have other stages, buffers or outputs,
    /// [`DeviceError::Limit`] if the picture or a buffer is larger than the device takes,
    /// those of [`Module::load`], [`DeviceError::Device`] if the device fails.
    pub fn draw(&self, device: &Device, module: &Module) -> Result<Vec<u32>, DeviceError> {
        self.check(module)?;
        self.check_limits(device)?;
        let [width, height] = self.size;
        let shaders = [
            module.load(device, self.vertex)?,
            module.load(device, self.fragment)?,
        ];
        // Rows in a buffer start at multiples of 256 bytes.
        let pitch = (16 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let bytes = u64::from(pitch) * u64::from(height);
        let read_back = device.attempt(|| {
            let texture = self.texture(device);
            let read_back = device.wgpu().create_buffer(&wgpu::BufferDescriptor {
                label: Some("picture"),
                size: bytes,
                usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
                mapped_at_creation: false,
            });
            let mut encoder = device.wgpu().create_command_encoder(&Default::default());
            self.encode(device, module, &shaders, &texture, &mut encoder);
            encoder.copy_texture_to_buffer(
                texture.as_image_copy(),
                wgpu::TexelCopyBufferInfo {
                    buffer: &read_back,
                    layout: wgpu::TexelCopyBufferLayout {
                        offset: 0,
                        bytes_per_row: Some(pitch),
                        rows_per_image: None,
                    },
                },
                texture.size(),
            );
            device.queue().submit([encoder.finish()]);
            Ok::<_, DeviceError>(read_back)
        })?;
        device.read(&read_back, bytes, |bytes| {
            let rows = bytes.chunks_exact(pitch as usize);
            rows.flat_map(|row| row[..16 * width as usize].as_chunks().0)
                .map(|&word| u32::from_ne_bytes(word))
                .collect()
        })
    }

    /// Checks that the shaders are those of the picture: drivers crash if they are not.
    fn check(&self, module: &Module) -> Result<(), DeviceError> {
        let wrong = |message: String| {
            Err(DeviceError::Picture {
                fragment: self.fragment.to_string(),
                message,
            })
        };
        if self.size.contains(&0) || self.buffers.iter().any(|words| words.is_empty()) {
            return wrong("give it at least one pixel, and each buffer a word".to_string());
        }
        let stages = [
            (self.vertex, interface::VERTEX, "a vertex"),
            (self.fragment, interface::FRAGMENT, "a fragment"),
        ];
        for (name, model, what) in stages {
            let (Some(entry_point), Some(words)) = (module.entry_point(name), module.spirv(name))
            else {
                let known: Vec<&str> = module.entry_points().map(|e| e.name.as_str()).collect();
                return wrong(format!(
                    "the module has no entry point {name:?}, but {}",
                    known.join(", ")
                ));
            };
            let interface = interface::of(&words, &entry_point.name);
            if interface.model != Some(model) {
                return wrong(format!("{name:?} is not {what} shader; name one"));
            }
            if interface.bindings as usize > self.buffers.len() {
                return wrong(format!(
                    "{name:?} reads {} buffers, and there are {}; give all of them",
                    interface.bindings,
                    self.buffers.len()
                ));
            }
            let floats = self.pixels == Pixels::Floats;
            if model == interface::FRAGMENT && interface.writes_floats != Some(floats) {
                return wrong(format!(
                    "{name:?} does not write {} to location 0; choose the other Pixels, or write that",
                    if floats { "a Vec4" } else { "a UVec4" }
                ));
            }
        }
        Ok(())
    }

    fn check_limits(&self, device: &Device) -> Result<(), DeviceError> {
        let limits = device.wgpu().limits();
        let longest = self.size[0].max(self.size[1]);
        let largest = self
            .buffers
            .iter()
            .map(|words| 4 * words.len() as u64)
            .max();
        let checks = [
            (
                "the side of a picture (pixels)",
                longest.into(),
                limits.max_texture_dimension_2d.into(),
            ),
            (
                "a buffer (bytes)",
                largest.unwrap_or(0),
                device.largest_storage(),
            ),
        ];
        let too_large = checks.into_iter().find(|(_, needed, limit)| needed > limit);
        too_large.map_or(Ok(()), |(what, needed, limit)| {
            Err(DeviceError::Limit {
                adapter: device.describe().to_string(),
                what: what.to_string(),
                needed,
                limit,
            })
        })
    }

    fn format(&self) -> wgpu::TextureFormat {
        match self.pixels {
            Pixels::Floats => wgpu::TextureFormat::Rgba32Float,
            Pixels::Words => wgpu::TextureFormat::Rgba32Uint,
        }
    }

    fn texture(&self, device: &Device) -> wgpu::Texture {
        let [width, height] = self.size;
        device.wgpu().create_texture(&wgpu::TextureDescriptor {
            label: Some("picture"),
            size: wgpu::Extent3d {
                width,
                height,
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: self.format(),
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        })
    }

    /// Encodes the pass that draws into `texture`.
    fn encode(
        &self,
        device: &Device,
        module: &Module,
        shaders: &[wgpu::ShaderModule; 2],
        texture: &wgpu::Texture,
        encoder: &mut wgpu::CommandEncoder,
    ) {
        use wgpu::util::DeviceExt;
        let wgpu = device.wgpu();
        let bindings: Vec<_> = (0..self.buffers.len() as u32)
            .map(|binding| wgpu::BindGroupLayoutEntry {
                binding,
                visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
                ty: wgpu::BindingType::Buffer {
                    ty: wgpu::BufferBindingType::Storage { read_only: true },
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
                count: None,
            })
            .collect();
        let bindings = wgpu.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("picture"),
            entries: &bindings,
        });
        let buffers: Vec<_> = self
            .buffers
            .iter()
            .map(|words| {
                wgpu.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                    label: Some("picture"),
                    contents: bytemuck::cast_slice(words),
                    usage: wgpu::BufferUsages::STORAGE,
                })
            })
            .collect();
        let entries: Vec<_> = (0..)
            .zip(&buffers)
            .map(|(binding, buffer)| wgpu::BindGroupEntry {
                binding,
                resource: buffer.as_entire_binding(),
            })
            .collect();
        let group = wgpu.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("picture"),
            layout: &bindings,
            entries: &entries,
        });
        let layout = wgpu.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("picture"),
            bind_group_layouts: &[Some(&bindings)],
            immediate_size: 0,
        });
        // The path of an entry point, where its function lies in a module.
        let name = |name| module.entry_point(name).map(|found| found.name.as_str());
        let pipeline = wgpu.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("picture"),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &shaders[0],
                entry_point: name(self.vertex),
                compilation_options: Default::default(),
                buffers: &[],
            },
            fragment: Some(wgpu::FragmentState {
                module: &shaders[1],
                entry_point: name(self.fragment),
                compilation_options: Default::default(),
                targets: &[Some(self.format().into())],
            }),
            primitive: Default::default(),
            depth_stencil: None,
            multisample: Default::default(),
            multiview_mask: None,
            cache: None,
        });
        let view = texture.create_view(&Default::default());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("picture"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
            })],
            ..Default::default()
        });
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.draw(0..self.vertices, 0..1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{adapters, testing};

    const SOURCE: &str = "
        @group(0) @binding(0) var<storage, read> numbers: array<u32>;

        @vertex fn cover(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {
            return vec4(f32(i32(i & 1u) * 4 - 1), f32(i32(i >> 1u) * 4 - 1), 0.0, 1.0);
        }

        @fragment fn words(@builtin(position) at: vec4<f32>) -> @location(0) vec4<u32> {
            return vec4(u32(at.x), u32(at.y), numbers[u32(at.x)], 7u);
        }

        @fragment fn floats(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
            return vec4(at.xy, bitcast<f32>(numbers[u32(at.x)]), 0.5);
        }
    ";

    #[test]
    fn gpu_pictures_come_back_from_the_top_row_on() {
        let spirv = testing::bytes(&testing::spirv(SOURCE));
        let numbers: Vec<u32> = (0..17).map(|x| 1.0e-3_f32.to_bits() + x).collect();
        // SAFETY: naga has validated it, and `numbers` is as wide as the picture.
        let untouched = unsafe { Module::untouched(&[&spirv]) }.expect("a module");
        let portable = Module::portable(&[&spirv]).expect("a module");
        let mut picture = Picture {
            vertex: "cover",
            fragment: "words",
            pixels: Pixels::Words,
            size: [17, 5],
            vertices: 3,
            buffers: &[&numbers],
        };
        for adapter in adapters() {
            let device = adapter.open().expect("a device");
            let routes = [&portable, &untouched];
            for module in &routes[..if device.takes_spirv() { 2 } else { 1 }] {
                picture.fragment = "words";
                picture.pixels = Pixels::Words;
                let words = picture.draw(&device, module).expect("a picture");
                let expected: Vec<u32> = (0..5)
                    .flat_map(|y| (0..17).flat_map(move |x| [x, y, 1.0e-3_f32.to_bits() + x, 7]))
                    .collect();
                assert_eq!(words, expected);
                picture.fragment = "floats";
                picture.pixels = Pixels::Floats;
                let words = picture.draw(&device, module).expect("a picture");
                let last = [
                    16.5_f32.to_bits(),
                    4.5_f32.to_bits(),
                    numbers[16],
                    0.5_f32.to_bits(),
                ];
                assert_eq!(words[words.len() - 4..], last);
            }
        }
    }

    #[test]
    fn pictures_of_other_shaders_are_refused() {
        let spirv = testing::bytes(&testing::spirv(SOURCE));
        let module = Module::portable(&[&spirv]).expect("a module");
        let right = Picture {
            vertex: "cover",
            fragment: "words",
            pixels: Pixels::Words,
            size: [4, 4],
            vertices: 3,
            buffers: &[&[0; 4]],
        };
        assert!(right.check(&module).is_ok());
        let refused = |picture: Picture| picture.check(&module).unwrap_err().to_string();
        for (picture, words) in [
            (
                Picture {
                    vertex: "words",
                    ..right
                },
                "is not a vertex shader",
            ),
            (
                Picture {
                    fragment: "cover",
                    ..right
                },
                "is not a fragment shader",
            ),
            (
                Picture {
                    fragment: "none",
                    ..right
                },
                "but cover, words, floats",
            ),
            (
                Picture {
                    fragment: "floats",
                    ..right
                },
                "does not write a UVec4",
            ),
            (
                Picture {
                    buffers: &[],
                    ..right
                },
                "reads 1 buffers, and there are 0",
            ),
            (
                Picture {
                    buffers: &[&[]],
                    ..right
                },
                "at least one pixel",
            ),
            (
                Picture {
                    size: [0, 4],
                    ..right
                },
                "at least one pixel",
            ),
        ] {
            let message = refused(picture);
            assert!(message.contains(words), "{message}");
        }
    }

    #[test]
    fn gpu_a_picture_that_is_too_large_is_refused() {
        let spirv = testing::bytes(&testing::spirv(SOURCE));
        let module = Module::portable(&[&spirv]).expect("a module");
        let picture = Picture {
            vertex: "cover",
            fragment: "words",
            pixels: Pixels::Words,
            size: [1, 1 << 30],
            vertices: 3,
            buffers: &[&[0]],
        };
        for adapter in adapters() {
            let device = adapter.open().expect("a device");
            let error = picture.draw(&device, &module).unwrap_err();
            assert!(matches!(error, DeviceError::Limit { .. }), "{error}");
        }
    }
}
