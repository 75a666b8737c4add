//! The renderer on a GPU, through wgpu, without a window.

mod shaders;
mod timestamps;

pub use relievo_bitwise::{Adapter, Module, Signature, adapters, choose};
pub use shaders::{Choice, Shaders, canaries, signature};

use super::{ColorWords, GeometryWords, RenderError, Renderer, allocate, background_words};
use crate::prepare::{PreparedObject, PreparedScene};
use relievo_bitwise::Device;
use relievo_shared::layout::Frame;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::mem::size_of;
use std::time::{Duration, Instant};
use timestamps::Timestamps;

/// Bits of f32 in, bits of f32 out: nothing is filtered, blended or rounded.
const TARGET_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Uint;
const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Renders one scene on a GPU. Buffers and pipelines are made once; a frame
/// writes its camera and draws.
pub struct GpuRenderer {
    description: String,
    device: Device,
    frame_buffer: wgpu::Buffer,
    objects: Vec<GpuObject>,
    pipelines: Pipelines,
    background: wgpu::Color,
    targets: Option<Targets>,
    /// `None` where the adapter has no clock of its own.
    timestamps: Option<Timestamps>,
}

/// How long a frame took.
#[derive(Clone, Copy, Debug)]
pub struct FrameTime {
    /// From recording the commands to the end of waiting, by this machine's clock.
    pub wall: Duration,
    /// The render pass alone, by the device's clock; `None` where it has none.
    pub pass: Option<Duration>,
}

struct GpuObject {
    bindings: wgpu::BindGroup,
    vertices: u32,
    vertex_entry_point: &'static str,
    color_entry_point: &'static str,
    geometry_entry_point: &'static str,
}

/// Pipelines, made when they are first needed; objects that need the same
/// entry points share one.
struct Pipelines {
    module: Module,
    vertices: BTreeMap<&'static str, wgpu::ShaderModule>,
    layout: wgpu::PipelineLayout,
    made: BTreeMap<&'static str, wgpu::RenderPipeline>,
}

impl Pipelines {
    /// Makes the pipeline of a fragment shader that writes `targets` targets,
    /// and of the vertex shader that goes with it, unless it is there.
    fn make(
        &mut self,
        device: &Device,
        vertex: &'static str,
        fragment: &'static str,
        targets: usize,
    ) -> Result<(), RenderError> {
        if self.made.contains_key(fragment) {
            return Ok(());
        }
        let placed = match self.vertices.entry(vertex) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(place) => place.insert(self.module.load(device, vertex)?),
        };
        let modules = [
            (&*placed, vertex),
            (&self.module.load(device, fragment)?, fragment),
        ];
        let pipeline = make_pipeline(device.wgpu(), &self.layout, modules, targets);
        self.made.insert(fragment, pipeline);
        Ok(())
    }
}

/// What is drawn to and read back from, kept while the size stays.
struct Targets {
    width: u32,
    height: u32,
    /// Bytes of a row in the read-back buffers, as the API wants it aligned.
    stride: u32,
    words: [wgpu::Texture; 2],
    views: [wgpu::TextureView; 2],
    depth: wgpu::TextureView,
    read_back: [wgpu::Buffer; 2],
}

impl GpuRenderer {
    /// Puts `scene` on the device of `adapter`, with the shaders of `choice`.
    ///
    /// # Errors
    /// [`RenderError::Device`], or [`RenderError::Limit`] where the scene does not fit.
    pub fn new(
        scene: &PreparedScene,
        adapter: &Adapter,
        choice: Choice,
    ) -> Result<GpuRenderer, RenderError> {
        let device = adapter.open()?;
        let shaders = choice.on(&device)?;
        GpuRenderer::on(scene, device, &shaders.module()?, shaders.describe())
    }

    /// As [`GpuRenderer::new`], with a module of one's own that has the entry
    /// points and bindings of ours; `name` is what a person calls it.
    ///
    /// # Errors
    /// As [`GpuRenderer::new`].
    pub fn with_module(
        scene: &PreparedScene,
        adapter: &Adapter,
        module: &Module,
        name: &str,
    ) -> Result<GpuRenderer, RenderError> {
        GpuRenderer::on(scene, adapter.open()?, module, name)
    }

    fn on(
        scene: &PreparedScene,
        opened: Device,
        module: &Module,
        name: &str,
    ) -> Result<GpuRenderer, RenderError> {
        let description = format!("{}, {name}", opened.describe());
        let guarded = opened.guard();
        let (device, queue) = (opened.wgpu(), opened.queue());
        let largest = opened.largest_storage();
        for object in &scene.objects {
            let sizes = [
                ("triangles", surface_bytes(object).len()),
                ("the shape map", std::mem::size_of_val(object.map.words())),
            ];
            for (what, bytes) in sizes {
                if bytes as u64 > largest {
                    return Err(RenderError::Limit {
                        adapter: description,
                        what: format!("object {:?}: a buffer of {what} (bytes)", object.name),
                        needed: bytes as u64,
                        limit: largest,
                    });
                }
            }
        }

        let layout = bind_group_layout(device);
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("relievo"),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let mut pipelines = Pipelines {
            vertices: BTreeMap::new(),
            module: module.clone(),
            layout: pipeline_layout,
            made: BTreeMap::new(),
        };

        let storage = |label: &str, bytes: &[u8]| {
            let buffer = device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: (bytes.len() as u64).max(4),
                usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            queue.write_buffer(&buffer, 0, bytes);
            buffer
        };
        let frame_buffer = storage("frame", bytemuck::bytes_of(&scene.frame));
        // Objects with the same map share its buffer.
        let mut maps: Vec<(*const u32, wgpu::Buffer)> = Vec::new();
        let mut objects = Vec::with_capacity(scene.objects.len());
        for object in &scene.objects {
            let words = object.map.words();
            let known = maps.iter().find(|(start, _)| *start == words.as_ptr());
            let map = match known {
                Some((_, buffer)) => buffer.clone(),
                None => {
                    let buffer = storage("shape map", bytemuck::cast_slice(words));
                    maps.push((words.as_ptr(), buffer.clone()));
                    buffer
                }
            };
            let parameters = storage("object", bytemuck::bytes_of(&object.parameters));
            let triangles = storage("triangles", surface_bytes(object));
            let buffers = [&frame_buffer, &parameters, &triangles, &map];
            let entries: Vec<_> = (0..)
                .zip(buffers)
                .map(|(binding, buffer)| wgpu::BindGroupEntry {
                    binding,
                    resource: buffer.as_entire_binding(),
                })
                .collect();
            let bindings = device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some(&object.name),
                layout: &layout,
                entries: &entries,
            });
            let vertex_entry_point = shaders::vertex_entry_point(&object.parameters);
            let color_entry_point = shaders::color_entry_point(&object.parameters);
            pipelines.make(&opened, vertex_entry_point, color_entry_point, 1)?;
            objects.push(GpuObject {
                bindings,
                vertices: 6 * object.triangles.len() as u32,
                vertex_entry_point,
                color_entry_point,
                geometry_entry_point: shaders::geometry_entry_point(&object.parameters),
            });
        }
        let has_clock = device.features().contains(wgpu::Features::TIMESTAMP_QUERY);
        let timestamps = has_clock.then(|| Timestamps::new(device, queue.get_timestamp_period()));
        guarded.finish()?;

        let [r, g, b, a] = background_words(scene).map(f64::from);
        Ok(GpuRenderer {
            description,
            device: opened,
            frame_buffer,
            objects,
            pipelines,
            background: wgpu::Color { r, g, b, a },
            targets: None,
            timestamps,
        })
    }

    /// Draws `frame`, waits for the device and says how long it took; nothing
    /// is read back.
    ///
    /// # Errors
    /// As [`Renderer::color`].
    pub fn time_color(&mut self, frame: &Frame) -> Result<FrameTime, RenderError> {
        let start = Instant::now();
        self.draw(frame, false, false)?;
        let wall = start.elapsed();
        let pass = match &self.timestamps {
            Some(timestamps) => {
                let buffer = timestamps.buffer();
                Some(
                    self.device
                        .read(buffer, buffer.size(), |bytes| timestamps.duration(bytes))?,
                )
            }
            None => None,
        };
        Ok(FrameTime { wall, pass })
    }

    fn draw(&mut self, frame: &Frame, geometry: bool, read_back: bool) -> Result<(), RenderError> {
        let guarded = self.device.guard();
        let device = self.device.wgpu();
        if geometry {
            for object in &self.objects {
                let (vertex, fragment) = (object.vertex_entry_point, object.geometry_entry_point);
                self.pipelines.make(&self.device, vertex, fragment, 2)?;
            }
        }
        let [width, height] = frame.size.map(|side| side as u32);
        let kept = self
            .targets
            .take()
            .filter(|targets| (targets.width, targets.height) == (width, height));
        let targets = match kept {
            Some(targets) => targets,
            None => Targets::new(device, &self.description, width, height)?,
        };
        self.device
            .queue()
            .write_buffer(&self.frame_buffer, 0, bytemuck::bytes_of(frame));
        // Only measurements read nothing back.
        let timestamps = self.timestamps.as_ref().filter(|_| !read_back);
        let count = if geometry { 2 } else { 1 };
        let clear = if geometry {
            wgpu::Color::TRANSPARENT
        } else {
            self.background
        };
        let attachments = targets.views.each_ref().map(|view| {
            Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(clear),
                    store: wgpu::StoreOp::Store,
                },
            })
        });
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("relievo"),
                color_attachments: &attachments[..count],
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: &targets.depth,
                    depth_ops: Some(wgpu::Operations {
                        load: wgpu::LoadOp::Clear(0.0),
                        store: wgpu::StoreOp::Discard,
                    }),
                    stencil_ops: None,
                }),
                timestamp_writes: timestamps.map(Timestamps::writes),
                occlusion_query_set: None,
                multiview_mask: None,
            });
            for object in &self.objects {
                let entry_point = if geometry {
                    object.geometry_entry_point
                } else {
                    object.color_entry_point
                };
                pass.set_pipeline(&self.pipelines.made[entry_point]);
                pass.set_bind_group(0, &object.bindings, &[]);
                pass.draw(0..object.vertices, 0..1);
            }
        }
        if read_back {
            for (texture, buffer) in targets.words[..count].iter().zip(&targets.read_back) {
                encoder.copy_texture_to_buffer(
                    texture.as_image_copy(),
                    wgpu::TexelCopyBufferInfo {
                        buffer,
                        layout: wgpu::TexelCopyBufferLayout {
                            offset: 0,
                            bytes_per_row: Some(targets.stride),
                            rows_per_image: Some(height),
                        },
                    },
                    texture.size(),
                );
            }
        }
        if let Some(timestamps) = timestamps {
            timestamps.resolve(&mut encoder);
        }
        self.device.queue().submit([encoder.finish()]);
        self.device.wait()?;
        guarded.finish()?;
        self.targets = Some(targets);
        Ok(())
    }

    /// The words of read-back buffer `index`, without the rows' padding.
    fn read(&self, index: usize) -> Result<Vec<[u32; 4]>, RenderError> {
        let targets = self
            .targets
            .as_ref()
            .ok_or_else(|| self.device.failed("nothing was drawn"))?;
        let count = targets.width as usize * targets.height as usize;
        let mut words = allocate("the picture", count, [0; 4])?;
        let buffer = &targets.read_back[index];
        self.device.read(buffer, buffer.size(), |bytes| {
            let row_bytes = targets.width as usize * size_of::<[u32; 4]>();
            let rows = bytes.chunks(targets.stride as usize);
            for (pixels, row) in words.chunks_mut(targets.width as usize).zip(rows) {
                bytemuck::cast_slice_mut(pixels).copy_from_slice(&row[..row_bytes]);
            }
        })?;
        Ok(words)
    }
}

impl Renderer for GpuRenderer {
    fn name(&self) -> String {
        self.description.clone()
    }

    fn color(&mut self, frame: &Frame) -> Result<ColorWords, RenderError> {
        self.draw(frame, false, true)?;
        Ok(ColorWords {
            width: frame.size[0] as u32,
            height: frame.size[1] as u32,
            words: self.read(0)?,
        })
    }

    fn geometry(&mut self, frame: &Frame) -> Result<GeometryWords, RenderError> {
        self.draw(frame, true, true)?;
        Ok(GeometryWords {
            width: frame.size[0] as u32,
            height: frame.size[1] as u32,
            place: self.read(0)?,
            surface: self.read(1)?,
        })
    }
}

impl Targets {
    fn new(
        device: &wgpu::Device,
        description: &str,
        width: u32,
        height: u32,
    ) -> Result<Targets, RenderError> {
        let limits = device.limits();
        let too_large = |what: &str, needed: u64, limit: u64| RenderError::Limit {
            adapter: description.to_string(),
            what: format!("a picture of {width} × {height} samples: {what}"),
            needed,
            limit,
        };
        let side = u64::from(width.max(height));
        let largest_side = u64::from(limits.max_texture_dimension_2d);
        if side > largest_side {
            return Err(too_large("its longer side (pixels)", side, largest_side));
        }
        let row_bytes = width * size_of::<[u32; 4]>() as u32;
        let stride = row_bytes.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let bytes = u64::from(stride) * u64::from(height);
        if bytes > limits.max_buffer_size {
            return Err(too_large(
                "its buffer (bytes)",
                bytes,
                limits.max_buffer_size,
            ));
        }
        let texture = |format, usage| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: Some("target"),
                size: wgpu::Extent3d {
                    width,
                    height,
                    depth_or_array_layers: 1,
                },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage,
                view_formats: &[],
            })
        };
        let words = || {
            texture(
                TARGET_FORMAT,
                wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            )
        };
        let read_back = || {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("read back"),
                size: bytes,
                usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
                mapped_at_creation: false,
            })
        };
        let words = [words(), words()];
        let view =
            |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
        Ok(Targets {
            width,
            height,
            stride,
            views: words.each_ref().map(view),
            words,
            depth: texture(DEPTH_FORMAT, wgpu::TextureUsages::RENDER_ATTACHMENT)
                .create_view(&wgpu::TextureViewDescriptor::default()),
            read_back: [read_back(), read_back()],
        })
    }
}

/// What the shaders of `object` read of its surface: triangles, or prisms.
fn surface_bytes(object: &PreparedObject) -> &[u8] {
    if object.has_prisms() {
        bytemuck::cast_slice(&object.shells)
    } else {
        bytemuck::cast_slice(&object.triangles)
    }
}

/// Four read-only storage buffers: frame, object, triangles or prisms, texels.
fn bind_group_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let entries: Vec<_> = (0..4)
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
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("relievo"),
        entries: &entries,
    })
}

fn make_pipeline(
    device: &wgpu::Device,
    layout: &wgpu::PipelineLayout,
    [vertex, fragment]: [(&wgpu::ShaderModule, &str); 2],
    targets: usize,
) -> wgpu::RenderPipeline {
    let target = Some(wgpu::ColorTargetState {
        format: TARGET_FORMAT,
        blend: None,
        write_mask: wgpu::ColorWrites::ALL,
    });
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(fragment.1),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module: vertex.0,
            entry_point: Some(vertex.1),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH_FORMAT,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Greater),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: fragment.0,
            entry_point: Some(fragment.1),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &vec![target; targets],
        }),
        multiview_mask: None,
        cache: None,
    })
}
