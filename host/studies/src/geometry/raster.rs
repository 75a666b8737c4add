//! Draws a [`Carving`] on a GPU: indexed triangles and a depth buffer, as any engine would.

use super::carve::{Carving, Vertex};
use bytemuck::{Pod, Zeroable};
use glam::{Mat4, Vec3};
use relievo::render::gpu::{Adapter, Device};
use relievo::render::{ColorWords, RenderError};
use relievo_shared::layout::{Frame, Object};
use relievo_shared::light::albedo;
use std::time::{Duration, Instant};

/// Format of the picture: as wide as the words of the extrusions' pictures.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;
const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Draws triangles on a GPU.
pub struct Raster {
    device: Device,
    pipeline: wgpu::RenderPipeline,
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    count: u32,
    uniforms: wgpu::Buffer,
    group: wgpu::BindGroup,
    object: Object,
    targets: Option<Targets>,
}

/// What a picture is drawn into.
struct Targets {
    size: [u32; 2],
    color: wgpu::Texture,
    depth: wgpu::Texture,
}

/// `Uniforms` of `raster.wgsl`.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Uniforms {
    clip: [[f32; 4]; 4],
    eye: [f32; 4],
    to_light: [f32; 4],
    light: [f32; 4],
    ambient: [f32; 4],
    gloss: [f32; 4],
    colors: [[f32; 4]; 8],
}

impl Uniforms {
    fn new(frame: &Frame, object: &Object) -> Uniforms {
        let wide = |[x, y, z]: [f32; 3]| [x, y, z, 0.0];
        let [right, up, forward] = [frame.right, frame.up, frame.forward].map(Vec3::from);
        let turn = Mat4::from_cols(
            Vec3::new(right.x, up.x, 0.0).extend(forward.x),
            Vec3::new(right.y, up.y, 0.0).extend(forward.y),
            Vec3::new(right.z, up.z, 0.0).extend(forward.z),
            Vec3::new(0.0, 0.0, frame.near).extend(0.0),
        );
        let color = |class| albedo(object, class).extend(0.0).to_array();
        Uniforms {
            clip: (turn * Mat4::from_translation(-Vec3::from(frame.eye))).to_cols_array_2d(),
            eye: wide(frame.eye),
            to_light: wide(frame.light_direction),
            light: wide(frame.light_color),
            ambient: wide(frame.ambient),
            gloss: [object.specular, object.shininess as f32, 0.0, 0.0],
            colors: [0, 1, 2, 3, 4, 5, 6, 7].map(color),
        }
    }
}

impl Raster {
    /// Uploads `carving`, whose colours are those of `object`.
    ///
    /// # Errors
    /// [`RenderError`] if the device fails or a buffer does not fit.
    pub fn new(
        carving: &Carving,
        object: &Object,
        adapter: &Adapter,
    ) -> Result<Raster, RenderError> {
        let device = adapter.open()?;
        let bytes = carving.bytes();
        let limit = device.wgpu().limits().max_buffer_size;
        if bytes > limit {
            return Err(RenderError::Limit {
                adapter: device.describe().to_string(),
                what: "the carving as triangles (bytes)".to_string(),
                needed: bytes,
                limit,
            });
        }
        device
            .clone()
            .attempt(|| Ok(Raster::put(carving, object, device)))
    }

    fn put(carving: &Carving, object: &Object, device: Device) -> Raster {
        let wgpu = device.wgpu();
        let buffer = |label, bytes: &[u8], usage| {
            // A buffer is never empty.
            let buffer = wgpu.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: bytes.len().max(4) as u64,
                usage: usage | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            device.queue().write_buffer(&buffer, 0, bytes);
            buffer
        };
        let vertices = bytemuck::cast_slice(&carving.vertices);
        let vertices = buffer("vertices", vertices, wgpu::BufferUsages::VERTEX);
        let indices = bytemuck::cast_slice(&carving.indices);
        let indices = buffer("indices", indices, wgpu::BufferUsages::INDEX);
        let zeros = [0; size_of::<Uniforms>()];
        let uniforms = buffer("uniforms", &zeros, wgpu::BufferUsages::UNIFORM);
        let shader = wgpu.create_shader_module(wgpu::include_wgsl!("raster.wgsl"));
        let pipeline = wgpu.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("triangles"),
            layout: None,
            vertex: wgpu::VertexState {
                module: &shader,
                entry_point: Some("vertex"),
                compilation_options: Default::default(),
                buffers: &[Some(wgpu::VertexBufferLayout {
                    array_stride: size_of::<Vertex>() as u64,
                    step_mode: wgpu::VertexStepMode::Vertex,
                    attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Uint32],
                })],
            },
            primitive: wgpu::PrimitiveState {
                cull_mode: Some(wgpu::Face::Back),
                ..Default::default()
            },
            depth_stencil: Some(wgpu::DepthStencilState {
                format: DEPTH,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::Greater),
                stencil: Default::default(),
                bias: Default::default(),
            }),
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module: &shader,
                entry_point: Some("fragment"),
                compilation_options: Default::default(),
                targets: &[Some(FORMAT.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        let group = wgpu.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: uniforms.as_entire_binding(),
            }],
        });
        Raster {
            count: carving.indices.len() as u32,
            object: *object,
            targets: None,
            device,
            pipeline,
            vertices,
            indices,
            uniforms,
            group,
        }
    }

    /// Draws `frame`, waits for the device, and returns the time; nothing is read back.
    ///
    /// # Errors
    /// [`RenderError`] if the device fails.
    pub fn time(&mut self, frame: &Frame) -> Result<Duration, RenderError> {
        let device = self.device.clone();
        let start = Instant::now();
        device.attempt(|| {
            let encoder = self.record(frame);
            device.queue().submit([encoder.finish()]);
            device.wait()
        })?;
        Ok(start.elapsed())
    }

    /// Draws the colours of `frame`.
    ///
    /// # Errors
    /// [`RenderError`] if the device fails.
    pub fn color(&mut self, frame: &Frame) -> Result<ColorWords, RenderError> {
        let device = self.device.clone();
        let [width, height] = frame.size.map(|side| side as u32);
        let pitch = (16 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let bytes = u64::from(pitch * height);
        let buffer = device.attempt(|| {
            let buffer = device.wgpu().create_buffer(&wgpu::BufferDescriptor {
                label: Some("picture"),
                size: bytes,
                usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
                mapped_at_creation: false,
            });
            let mut encoder = self.record(frame);
            if let Some(Targets { color, .. }) = &self.targets {
                let layout = wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(pitch),
                    rows_per_image: None,
                };
                let copy = wgpu::TexelCopyBufferInfo {
                    buffer: &buffer,
                    layout,
                };
                encoder.copy_texture_to_buffer(color.as_image_copy(), copy, color.size());
            }
            device.queue().submit([encoder.finish()]);
            Ok::<_, RenderError>(buffer)
        })?;
        let words = device.read(&buffer, bytes, |bytes| {
            let rows = bytes.chunks_exact(pitch as usize);
            let pixels = rows.flat_map(|row| row[..16 * width as usize].chunks_exact(16));
            let pixels = pixels.map(|pixel| {
                let [r, g, b, class]: [f32; 4] = bytemuck::pod_read_unaligned(pixel);
                [r.to_bits(), g.to_bits(), b.to_bits(), class as u32]
            });
            pixels.collect()
        })?;
        Ok(ColorWords {
            width,
            height,
            words,
        })
    }

    /// Records a frame into targets of its size.
    fn record(&mut self, frame: &Frame) -> wgpu::CommandEncoder {
        let wgpu = self.device.wgpu();
        let size = frame.size.map(|side| side as u32);
        let kept = self.targets.take().filter(|targets| targets.size == size);
        let targets = &*self
            .targets
            .insert(kept.unwrap_or_else(|| Targets::new(wgpu, size)));
        let uniforms = Uniforms::new(frame, &self.object);
        let queue = self.device.queue();
        queue.write_buffer(&self.uniforms, 0, bytemuck::bytes_of(&uniforms));
        let mut encoder = wgpu.create_command_encoder(&Default::default());
        let [color, depth] = [&targets.color, &targets.depth]
            .map(|texture| texture.create_view(&Default::default()));
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("triangles"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &color,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &depth,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Discard,
                }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.group, &[]);
        pass.set_vertex_buffer(0, self.vertices.slice(..));
        pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint32);
        pass.draw_indexed(0..self.count, 0, 0..1);
        drop(pass);
        encoder
    }
}

impl Targets {
    fn new(device: &wgpu::Device, size: [u32; 2]) -> Targets {
        let texture = |format, usage| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: None,
                size: wgpu::Extent3d {
                    width: size[0],
                    height: size[1],
                    depth_or_array_layers: 1,
                },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: usage | wgpu::TextureUsages::RENDER_ATTACHMENT,
                view_formats: &[],
            })
        };
        Targets {
            size,
            color: texture(FORMAT, wgpu::TextureUsages::COPY_SRC),
            depth: texture(DEPTH, wgpu::TextureUsages::empty()),
        }
    }
}
