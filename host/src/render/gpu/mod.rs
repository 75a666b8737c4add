//! The renderer on a GPU, through wgpu, without a window.

mod memory;
mod shaders;
mod timestamps;

pub use memory::{Memory, Pictures};
pub use relievo_bitwise::{Adapter, Device, Module, Signature, TIME_LIMIT, adapters, choose};
pub use shaders::{Choice, EntryPoints, Extent, Facets, Shaders, canaries, signature};

use super::{ColorWords, GeometryWords, RenderError, Renderer, allocate, background_words};
use crate::prepare::{PreparedObject, PreparedScene};
use relievo_shared::layout::{Frame, PlanarTriangle};
use std::borrow::Cow;
use std::cell::Cell;
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
    /// Bytes of the scene's buffers.
    scene_bytes: u64,
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
    entry_points: EntryPoints,
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
        let pipeline = device.attempt(|| {
            let pipeline = make_pipeline(device.wgpu(), &self.layout, modules, targets);
            Ok::<_, RenderError>(pipeline)
        })?;
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
    /// Made for as many as were drawn to at once: two for geometry.
    colors: Vec<Target>,
    depth: wgpu::TextureView,
}

/// One of them.
struct Target {
    texture: wgpu::Texture,
    view: wgpu::TextureView,
    /// Made when it is first read.
    read_back: Option<wgpu::Buffer>,
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
        GpuRenderer::with_extent(scene, adapter, choice, Extent::Needed)
    }

    /// As [`GpuRenderer::new`], with shaders that hold as much as `extent` says.
    ///
    /// # Errors
    /// As [`GpuRenderer::new`].
    pub fn with_extent(
        scene: &PreparedScene,
        adapter: &Adapter,
        choice: Choice,
        extent: Extent,
    ) -> Result<GpuRenderer, RenderError> {
        let device = adapter.open()?;
        let shaders = choice.on(&device)?;
        let module = shaders.module()?;
        GpuRenderer::on(scene, device, &module, shaders.describe(), extent)
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
        GpuRenderer::on(scene, adapter.open()?, module, name, Extent::Needed)
    }

    fn on(
        scene: &PreparedScene,
        opened: Device,
        module: &Module,
        name: &str,
        extent: Extent,
    ) -> Result<GpuRenderer, RenderError> {
        let device = opened.clone();
        device.attempt(|| GpuRenderer::put(scene, opened, module, name, extent))
    }

    /// What [`GpuRenderer::on`] does where nothing fails.
    fn put(
        scene: &PreparedScene,
        opened: Device,
        module: &Module,
        name: &str,
        extent: Extent,
    ) -> Result<GpuRenderer, RenderError> {
        let description = format!("{}, {name}", opened.describe());
        let (device, queue) = (opened.wgpu(), opened.queue());
        let largest = opened.largest_storage();
        for object in &scene.objects {
            let facets = EntryPoints::of(&object.parameters, extent).facets;
            let sizes = [
                ("triangles", object.triangles.len() * facets.bytes()),
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

        let scene_bytes = Cell::new(0);
        let storage = |label: &str, bytes: &[u8]| {
            let size = (bytes.len() as u64).max(4);
            scene_bytes.set(scene_bytes.get() + size);
            let buffer = device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
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
            let entry_points = EntryPoints::of(&object.parameters, extent);
            let facets = storage("facets", &facet_bytes(object, entry_points.facets));
            let buffers = [&frame_buffer, &parameters, &facets, &map];
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
            pipelines.make(&opened, entry_points.vertex, entry_points.color, 1)?;
            objects.push(GpuObject {
                bindings,
                vertices: 6 * object.triangles.len() as u32,
                entry_points,
            });
        }
        let has_clock = device.features().contains(wgpu::Features::TIMESTAMP_QUERY);
        let timestamps = has_clock.then(|| Timestamps::new(device, queue.get_timestamp_period()));

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
            scene_bytes: scene_bytes.get(),
        })
    }

    /// The device that it draws on. Who loses it ([`Device::wgpu`] has
    /// `destroy`) makes every later frame an error.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// Bytes of the device that the scene's buffers and the last pictures take,
    /// as [`Memory::of`] foresees.
    pub fn bytes(&self) -> u64 {
        self.scene_bytes + self.targets.as_ref().map_or(0, Targets::bytes)
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
        let device = self.device.clone();
        let drawn = device.attempt(|| self.submit(frame, geometry, read_back));
        if drawn.is_err() {
            // Perhaps the device had no memory for them.
            self.targets = None;
        }
        drawn
    }

    /// Draws, and waits for the device.
    fn submit(
        &mut self,
        frame: &Frame,
        geometry: bool,
        read_back: bool,
    ) -> Result<(), RenderError> {
        let device = self.device.wgpu();
        if geometry {
            for object in &self.objects {
                let EntryPoints {
                    vertex, geometry, ..
                } = object.entry_points;
                self.pipelines.make(&self.device, vertex, geometry, 2)?;
            }
        }
        let [width, height] = frame.size.map(|side| side as u32);
        let kept = self
            .targets
            .take()
            .filter(|targets| (targets.width, targets.height) == (width, height));
        let mut targets = match kept {
            Some(targets) => targets,
            None => Targets::new(device, &self.description, width, height)?,
        };
        let count = if geometry { 2 } else { 1 };
        targets.make(device, count, read_back);
        self.device
            .queue()
            .write_buffer(&self.frame_buffer, 0, bytemuck::bytes_of(frame));
        // Only measurements read nothing back.
        let timestamps = self.timestamps.as_ref().filter(|_| !read_back);
        let clear = if geometry {
            wgpu::Color::TRANSPARENT
        } else {
            self.background
        };
        let attachment = |index: usize| {
            let target = targets.colors.get(index)?;
            Some(wgpu::RenderPassColorAttachment {
                view: &target.view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(clear),
                    store: wgpu::StoreOp::Store,
                },
            })
        };
        let attachments = [attachment(0), attachment(1)];
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
                    object.entry_points.geometry
                } else {
                    object.entry_points.color
                };
                pass.set_pipeline(&self.pipelines.made[entry_point]);
                pass.set_bind_group(0, &object.bindings, &[]);
                pass.draw(0..object.vertices, 0..1);
            }
        }
        if read_back {
            for target in &targets.colors[..count] {
                let Some(buffer) = &target.read_back else {
                    continue;
                };
                encoder.copy_texture_to_buffer(
                    target.texture.as_image_copy(),
                    wgpu::TexelCopyBufferInfo {
                        buffer,
                        layout: wgpu::TexelCopyBufferLayout {
                            offset: 0,
                            bytes_per_row: Some(targets.stride),
                            rows_per_image: Some(height),
                        },
                    },
                    target.texture.size(),
                );
            }
        }
        if let Some(timestamps) = timestamps {
            timestamps.resolve(&mut encoder);
        }
        self.device.queue().submit([encoder.finish()]);
        self.device.wait()?;
        self.targets = Some(targets);
        Ok(())
    }

    /// The words of read-back buffer `index`, without the rows' padding.
    fn read(&self, index: usize) -> Result<Vec<[u32; 4]>, RenderError> {
        let nothing = || self.device.failed("nothing was drawn");
        let targets = self.targets.as_ref().ok_or_else(nothing)?;
        let count = targets.width as usize * targets.height as usize;
        let mut words = allocate("the picture", count, [0; 4])?;
        let target = targets.colors.get(index).ok_or_else(nothing)?;
        let buffer = target.read_back.as_ref().ok_or_else(nothing)?;
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
        let stride = memory::row_stride(u64::from(width));
        let bytes = stride * u64::from(height);
        if bytes > limits.max_buffer_size {
            return Err(too_large(
                "its buffer (bytes)",
                bytes,
                limits.max_buffer_size,
            ));
        }
        let depth = texture(
            device,
            [width, height],
            DEPTH_FORMAT,
            wgpu::TextureUsages::RENDER_ATTACHMENT,
        );
        Ok(Targets {
            width,
            height,
            stride: stride as u32,
            colors: Vec::new(),
            depth: depth.create_view(&wgpu::TextureViewDescriptor::default()),
        })
    }

    /// Makes what is missing of `count` targets, to be read back or not.
    fn make(&mut self, device: &wgpu::Device, count: usize, read_back: bool) {
        while self.colors.len() < count {
            let texture = texture(
                device,
                [self.width, self.height],
                TARGET_FORMAT,
                wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            );
            self.colors.push(Target {
                view: texture.create_view(&wgpu::TextureViewDescriptor::default()),
                texture,
                read_back: None,
            });
        }
        if !read_back {
            return;
        }
        for target in &mut self.colors[..count] {
            if target.read_back.is_none() {
                target.read_back = Some(device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some("read back"),
                    size: u64::from(self.stride) * u64::from(self.height),
                    usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
                    mapped_at_creation: false,
                }));
            }
        }
    }

    /// Bytes of the device that these take.
    fn bytes(&self) -> u64 {
        let pixels = u64::from(self.width) * u64::from(self.height);
        let read: u64 = self
            .colors
            .iter()
            .filter_map(|target| target.read_back.as_ref())
            .map(wgpu::Buffer::size)
            .sum();
        pixels * (self.colors.len() as u64 * memory::WORDS + memory::DEPTH) + read
    }
}

/// A texture to draw to.
fn texture(
    device: &wgpu::Device,
    [width, height]: [u32; 2],
    format: wgpu::TextureFormat,
    usage: wgpu::TextureUsages,
) -> wgpu::Texture {
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
}

/// The surface of `object` as shaders read it.
pub(crate) fn facet_bytes(object: &PreparedObject, facets: Facets) -> Cow<'_, [u8]> {
    match facets {
        Facets::Triangles => bytemuck::cast_slice(&object.triangles).into(),
        Facets::PlanarTriangles => {
            let planar: Vec<PlanarTriangle> =
                object.triangles.iter().map(PlanarTriangle::from).collect();
            bytemuck::cast_slice::<_, u8>(&planar).to_vec().into()
        }
        Facets::Prisms => bytemuck::cast_slice(&object.shells).into(),
    }
}

/// Four read-only storage buffers: frame, object, facets, texels.
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
