//! Uploads a prepared scene to a device, and records its drawing.

use super::content::Content;
use super::pipelines::Pipelines;
use super::shaders::{EntryPoints, Extent, Facets};
use super::targets::Targets;
use super::timestamps::Timestamps;
use crate::prepare::{PreparedObject, PreparedScene};
use crate::render::{RenderError, background_words};
use relievo_shared::layout::{Frame, PlanarTriangle};
use std::borrow::Cow;
use std::cell::Cell;

/// The buffers of one scene, drawn by the pipelines that it was made for.
pub struct GpuScene {
    frame: wgpu::Buffer,
    objects: Vec<GpuObject>,
    background: wgpu::Color,
    bytes: u64,
}

struct GpuObject {
    bindings: wgpu::BindGroup,
    vertices: u32,
    entry_points: EntryPoints,
    /// Whether its exits are written.
    has_exits: bool,
}

impl GpuScene {
    /// Uploads `scene` to the device of `pipelines`, and makes the pipelines of its
    /// colours, with shaders of this `extent`. `description` names the device in
    /// errors.
    ///
    /// # Errors
    /// [`RenderError::Limit`] if the scene is too large, [`RenderError::Device`] if
    /// the device refuses its shaders.
    pub fn new(
        scene: &PreparedScene,
        pipelines: &mut Pipelines,
        extent: Extent,
        description: &str,
    ) -> Result<GpuScene, RenderError> {
        let opened = pipelines.device().clone();
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
                        adapter: description.to_string(),
                        what: format!("object {:?}: a buffer of {what} (bytes)", object.name),
                        needed: bytes as u64,
                        limit: largest,
                    });
                }
            }
        }

        let total = Cell::new(0);
        let storage = |label: &str, bytes: &[u8]| {
            let size = (bytes.len() as u64).max(4);
            total.set(total.get() + size);
            let buffer = device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            queue.write_buffer(&buffer, 0, bytes);
            buffer
        };
        let frame = storage("frame", bytemuck::bytes_of(&scene.frame));
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
            let buffers = [&frame, &parameters, &facets, &map];
            let entries: Vec<_> = (0..)
                .zip(buffers)
                .map(|(binding, buffer)| wgpu::BindGroupEntry {
                    binding,
                    resource: buffer.as_entire_binding(),
                })
                .collect();
            let bindings = device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some(&object.name),
                layout: pipelines.bindings(),
                entries: &entries,
            });
            pipelines.make(&entry_points, Content::Color)?;
            let has_exits = entry_points.asks_for_exits && object.parameters.number != 0;
            if has_exits {
                pipelines.make_exits()?;
            }
            objects.push(GpuObject {
                bindings,
                vertices: 6 * object.triangles.len() as u32,
                entry_points,
                has_exits,
            });
        }
        let [r, g, b, a] = background_words(scene).map(f64::from);
        Ok(GpuScene {
            frame,
            objects,
            background: wgpu::Color { r, g, b, a },
            bytes: total.get(),
        })
    }

    /// Returns the bytes of its buffers on the device.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Makes the pipelines that pictures of `content` need.
    ///
    /// # Errors
    /// [`RenderError::Device`] if the device refuses its shaders.
    pub fn make(&self, pipelines: &mut Pipelines, content: Content) -> Result<(), RenderError> {
        for object in &self.objects {
            pipelines.make(&object.entry_points, content)?;
            if object.has_exits {
                pipelines.make_exits()?;
            }
        }
        Ok(())
    }

    /// Makes the targets that pictures of `content` of this scene lack, and their
    /// read-back buffers if `read_back`.
    pub fn make_targets(
        &self,
        pipelines: &Pipelines,
        targets: &mut Targets,
        content: Content,
        read_back: bool,
    ) {
        targets.make(pipelines.device(), content, read_back);
        let mut objects = self.objects.iter();
        if objects.any(|object| object.entry_points.asks_for_exits) {
            let is_written = self.objects.iter().any(|object| object.has_exits);
            targets.make_exits(pipelines, is_written);
        }
    }

    /// Records the drawing of the exits, if any object has some. Returns whether it did.
    fn record_exits(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        pipelines: &Pipelines,
        targets: &Targets,
        timestamps: Option<&Timestamps>,
    ) -> bool {
        let mut objects = self
            .objects
            .iter()
            .filter(|object| object.has_exits)
            .peekable();
        let (Some(_), Some(exits)) = (objects.peek(), targets.exits()) else {
            return false;
        };
        let attachment = wgpu::RenderPassColorAttachment {
            view: &exits.view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                store: wgpu::StoreOp::Store,
            },
        };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("exits"),
            color_attachments: &[Some(attachment)],
            depth_stencil_attachment: Some(depth_attachment(targets)),
            timestamp_writes: timestamps.map(|timestamps| timestamps.writes(true, false)),
            occlusion_query_set: None,
            multiview_mask: None,
        });
        pass.set_pipeline(pipelines.exits());
        for object in objects {
            pass.set_bind_group(0, &object.bindings, &[]);
            pass.draw(0..object.vertices, 0..1);
        }
        true
    }

    /// Records the drawing to `targets`. Pipelines and targets must be made for
    /// `content`.
    pub fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        pipelines: &Pipelines,
        targets: &Targets,
        content: Content,
        timestamps: Option<&Timestamps>,
    ) {
        let clear = match content {
            Content::Color => self.background,
            Content::Geometry => wgpu::Color::TRANSPARENT,
        };
        let attachment = |index: usize| {
            Some(wgpu::RenderPassColorAttachment {
                view: targets.view(index)?,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(clear),
                    store: wgpu::StoreOp::Store,
                },
            })
        };
        let attachments = [attachment(0), attachment(1)];
        let has_exits = self.record_exits(encoder, pipelines, targets, timestamps);
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("relievo"),
            color_attachments: &attachments[..content.targets()],
            depth_stencil_attachment: Some(depth_attachment(targets)),
            timestamp_writes: timestamps.map(|timestamps| timestamps.writes(!has_exits, true)),
            occlusion_query_set: None,
            multiview_mask: None,
        });
        if let Some(exits) = targets.exits() {
            pass.set_bind_group(1, &exits.bindings, &[]);
        }
        for object in &self.objects {
            pass.set_pipeline(pipelines.get(&object.entry_points, content));
            pass.set_bind_group(0, &object.bindings, &[]);
            pass.draw(0..object.vertices, 0..1);
        }
    }

    /// The camera and the light of the pictures that are submitted after this.
    pub fn set_frame(&self, queue: &wgpu::Queue, frame: &Frame) {
        queue.write_buffer(&self.frame, 0, bytemuck::bytes_of(frame));
    }
}

/// The depth buffer of a pass, cleared before and discarded after it.
fn depth_attachment(targets: &Targets) -> wgpu::RenderPassDepthStencilAttachment<'_> {
    wgpu::RenderPassDepthStencilAttachment {
        view: targets.depth(),
        depth_ops: Some(wgpu::Operations {
            load: wgpu::LoadOp::Clear(0.0),
            store: wgpu::StoreOp::Discard,
        }),
        stencil_ops: None,
    }
}

/// Returns the facets of `object` as the bytes that shaders read.
pub(crate) fn facet_bytes(object: &PreparedObject, facets: Facets) -> Cow<'_, [u8]> {
    match facets {
        Facets::Triangles => bytemuck::cast_slice(&object.triangles).into(),
        Facets::PlanarTriangles => {
            let planar: Vec<PlanarTriangle> =
                object.triangles.iter().map(PlanarTriangle::from).collect();
            bytemuck::cast_slice::<_, u8>(&planar).to_vec().into()
        }
        Facets::Prisms => bytemuck::cast_slice(&object.prisms).into(),
    }
}
