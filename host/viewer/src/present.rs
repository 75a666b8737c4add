//! Render pass from words to the screen, `present.wgsl`.

use super::display::{Scale, Show};
use relievo::scene::{Development, Tone};
use relievo::tone::Developer;

/// Format of the screen: sRGB, eight bits per channel.
const SCREEN_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// Display settings of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// Quantity shown.
    pub show: Show,
    /// Fraction of the width for the first scene, 0…1; the second has the rest.
    pub split: f32,
    /// Ranges that map to full brightness.
    pub scale: Scale,
    /// How colours are developed.
    pub development: Development,
}

/// Texture that egui shows.
pub(super) struct Screen {
    pub size: [u32; 2],
    pub view: wgpu::TextureView,
}

impl Screen {
    pub fn new(device: &wgpu::Device, size: [u32; 2]) -> Screen {
        let [width, height] = size;
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("screen"),
            size: wgpu::Extent3d {
                width,
                height,
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: SCREEN_FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT
                | wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        Screen {
            size,
            view: texture.create_view(&Default::default()),
        }
    }
}

/// Pipelines of the pass.
pub(super) struct Present {
    pipeline: wgpu::RenderPipeline,
    bindings: wgpu::BindGroupLayout,
    uniform: wgpu::Buffer,
}

impl Present {
    pub fn new(device: &wgpu::Device) -> Present {
        let module = device.create_shader_module(wgpu::include_wgsl!("present.wgsl"));
        let texture = |binding| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty: wgpu::BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Uint,
                view_dimension: wgpu::TextureViewDimension::D2,
                multisampled: false,
            },
            count: None,
        };
        let uniform = wgpu::BindGroupLayoutEntry {
            binding: 0,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Uniform,
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        };
        let bindings = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("present"),
            entries: &[uniform, texture(1), texture(2), texture(3), texture(4)],
        });
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("present"),
            bind_group_layouts: &[Some(&bindings)],
            immediate_size: 0,
        });
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("present"),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("whole"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: None,
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("shown"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(SCREEN_FORMAT.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        Present {
            pipeline,
            bindings,
            uniform: device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("present"),
                size: 32,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }),
        }
    }

    /// Draws `split` columns of the left words, then the right words.
    #[expect(clippy::too_many_arguments)]
    pub fn record(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        screen: &wgpu::TextureView,
        words: [&[Option<&wgpu::TextureView>; 2]; 2],
        look: &Look,
        split: u32,
    ) {
        let [near, far] = look.scale.distances.map(f32::to_bits);
        let steps = look.scale.steps.to_bits();
        let gain = Developer::new(&look.development).gain.to_bits();
        let is_agx = u32::from(look.development.tone == Tone::Agx);
        let uniform = [look.show.code(), split, near, far, steps, gain, is_agx, 0];
        queue.write_buffer(&self.uniform, 0, bytemuck::bytes_of(&uniform));
        let [left, right] = words;
        // Colour output has one target; an unused binding still needs a
        // texture.
        let [Some(left_0), Some(right_0)] = [left[0], right[0]] else {
            return;
        };
        let views = [
            left_0,
            left[1].unwrap_or(left_0),
            right_0,
            right[1].unwrap_or(right_0),
        ];
        let mut entries = vec![wgpu::BindGroupEntry {
            binding: 0,
            resource: self.uniform.as_entire_binding(),
        }];
        entries.extend(
            (1..)
                .zip(views)
                .map(|(binding, view)| wgpu::BindGroupEntry {
                    binding,
                    resource: wgpu::BindingResource::TextureView(view),
                }),
        );
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("present"),
            layout: &self.bindings,
            entries: &entries,
        });
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("present"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: screen,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: None,
            timestamp_writes: None,
            occlusion_query_set: None,
            multiview_mask: None,
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.draw(0..3, 0..1);
    }
}
