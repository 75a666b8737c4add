//! Uploads a prepared scene to a device, and records its drawing.

use super::content::Content;
use super::pipelines::Pipelines;
use super::shaders::{EntryPoints, Extent, Facets};
use super::targets::Targets;
use super::timestamps::Timestamps;
use crate::prepare::{Placement, PreparedObject, PreparedScene};
use crate::render::space::{may_be_seen, may_hold_eye, object_bounds};
use crate::render::{RenderError, background_words};
use obvhs::aabb::Aabb;
use rayon::prelude::*;
use relievo_shared::layout::{Frame, Object, PlanarTriangle};
use std::borrow::Cow;
use std::cell::Cell;
use std::mem::size_of;
use std::num::NonZero;

/// The buffers of one scene, drawn by the pipelines that it was made for.
pub struct GpuScene {
    /// The frame in world space, and those in the spaces of the objects that are drawn.
    frames: wgpu::Buffer,
    facets: Vec<GpuFacets>,
    objects: Vec<GpuObject>,
    /// The frame of each object in its space; `None` where it lies outside the picture.
    seen: Vec<Option<Frame>>,
    background: wgpu::Color,
    bytes: u64,
}

/// Bytes from one frame or object in a buffer to the next: every device takes this offset.
pub(super) const STRIDE: usize = 256;
const _: () = assert!(size_of::<Frame>() <= STRIDE && size_of::<Object>() <= STRIDE);

/// Facets, and how they are drawn.
struct GpuFacets {
    bindings: wgpu::BindGroup,
    vertices: u32,
    entry_points: EntryPoints,
    /// Whether their exits are written.
    has_exits: bool,
    /// The box around them, object space.
    bounds: Aabb,
    depth: f32,
}

/// An object: facets in a place.
struct GpuObject {
    /// Index of its facets.
    facets: u32,
    placement: Option<Placement>,
    /// Its frame and its parameters in their buffers, bytes.
    offsets: [u32; 2],
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
        let placed = scene.objects.iter();
        let placed = placed.filter(|object| object.placement.is_some()).count();
        let frames = storage("frames", &vec![0; STRIDE * (1 + placed)]);
        // Objects with the same map share its buffer.
        let mut maps: Vec<(*const u32, wgpu::Buffer)> = Vec::new();
        let mut facets = Vec::new();
        let mut objects = Vec::with_capacity(scene.objects.len());
        for shared in sharing(&scene.objects) {
            let object = &scene.objects[shared[0]];
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
            let entry_points = EntryPoints::of(&object.parameters, extent);
            let has_exits = entry_points.asks_for_exits && object.parameters.number != 0;
            // Those that share facets differ by the number of their exits only.
            let own_parameters = if has_exits { shared.len() } else { 1 };
            let mut parameters = vec![0; own_parameters * STRIDE];
            for (bytes, index) in parameters.chunks_exact_mut(STRIDE).zip(&shared) {
                let own = bytemuck::bytes_of(&scene.objects[*index].parameters);
                bytes[..own.len()].copy_from_slice(own);
            }
            let parameters = storage("objects", &parameters);
            let buffer = storage("facets", &facet_bytes(object, entry_points.facets));
            let one = |buffer, size: usize| {
                wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                    buffer,
                    offset: 0,
                    size: NonZero::new(size as u64),
                })
            };
            let resources = [
                one(&frames, size_of::<Frame>()),
                one(&parameters, size_of::<Object>()),
                buffer.as_entire_binding(),
                map.as_entire_binding(),
            ];
            let entries: Vec<_> = (0..)
                .zip(resources)
                .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
                .collect();
            let bindings = device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some(&object.name),
                layout: pipelines.bindings(),
                entries: &entries,
            });
            pipelines.make(&entry_points, Content::Color)?;
            if has_exits {
                pipelines.make_exits()?;
            }
            for (place, index) in shared.iter().enumerate() {
                let own = place.min(own_parameters - 1);
                let placed = GpuObject {
                    facets: facets.len() as u32,
                    placement: scene.objects[*index].placement,
                    offsets: [0, (own * STRIDE) as u32],
                };
                objects.push((*index, placed));
            }
            facets.push(GpuFacets {
                bindings,
                vertices: 6 * object.triangles.len() as u32,
                entry_points,
                has_exits,
                bounds: object_bounds(object),
                depth: object.parameters.depth,
            });
        }
        // In drawing order.
        objects.sort_unstable_by_key(|(index, _)| *index);
        let mut objects: Vec<GpuObject> = objects.into_iter().map(|(_, object)| object).collect();
        let placed = objects
            .iter_mut()
            .filter(|object| object.placement.is_some());
        for (place, object) in (1..).zip(placed) {
            object.offsets[0] = (place * STRIDE) as u32;
        }
        let [r, g, b, a] = background_words(scene).map(f64::from);
        Ok(GpuScene {
            frames,
            facets,
            seen: Vec::with_capacity(objects.len()),
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
        for facets in &self.facets {
            pipelines.make(&facets.entry_points, content)?;
            if facets.has_exits {
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
        let mut facets = self.facets.iter();
        if facets.any(|facets| facets.entry_points.asks_for_exits) {
            let is_written = self.facets.iter().any(|facets| facets.has_exits);
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
        let has_exits = self.facets.iter().any(|facets| facets.has_exits);
        let (true, Some(exits)) = (has_exits, targets.exits()) else {
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
        for (object, facets) in self.seen().filter(|(_, facets)| facets.has_exits) {
            pass.set_bind_group(0, &facets.bindings, &object.offsets);
            pass.draw(0..facets.vertices, 0..1);
        }
        true
    }

    /// The objects that may be seen in the last frame that was set, and their facets.
    fn seen(&self) -> impl Iterator<Item = (&GpuObject, &GpuFacets)> {
        let objects = self.objects.iter().zip(&self.seen);
        let seen = objects.filter(|(_, frame)| frame.is_some());
        seen.map(|(object, _)| (object, &self.facets[object.facets as usize]))
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
        let mut last = None;
        for (object, facets) in self.seen() {
            if last != Some(object.facets) {
                pass.set_pipeline(pipelines.get(&facets.entry_points, content));
                last = Some(object.facets);
            }
            pass.set_bind_group(0, &facets.bindings, &object.offsets);
            pass.draw(0..facets.vertices, 0..1);
        }
    }

    /// Sets the camera and the light of the pictures that are recorded after this.
    pub fn set_frame(&mut self, queue: &wgpu::Queue, frame: &Frame) {
        let facets = &self.facets;
        let own = self.objects.par_iter().map(|object| {
            let own = match &object.placement {
                Some(placement) => placement.frame(frame),
                None => *frame,
            };
            let GpuFacets { bounds, depth, .. } = &facets[object.facets as usize];
            let is_seen = may_be_seen(&own, bounds) || may_hold_eye(&own, bounds, *depth);
            is_seen.then_some(own)
        });
        own.collect_into_vec(&mut self.seen);
        queue.write_buffer(&self.frames, 0, bytemuck::bytes_of(frame));
        let Some(size) = NonZero::new(self.frames.size() - STRIDE as u64) else {
            return;
        };
        let Some(mut bytes) = queue.write_buffer_with(&self.frames, STRIDE as u64, size) else {
            return;
        };
        let objects = self.objects.iter().zip(&self.seen);
        for (object, frame) in objects.filter(|(object, _)| object.placement.is_some()) {
            if let Some(frame) = frame {
                let start = object.offsets[0] as usize - STRIDE;
                let place = start..start + size_of::<Frame>();
                bytes
                    .slice(place)
                    .copy_from_slice(bytemuck::bytes_of(frame));
            }
        }
    }
}

/// Returns the indices of `objects` by the facets that they share, the first ones first.
pub(super) fn sharing(objects: &[PreparedObject]) -> Vec<Vec<usize>> {
    let mut shared: Vec<Vec<usize>> = Vec::new();
    for (index, object) in objects.iter().enumerate() {
        let known = shared
            .iter_mut()
            .rev()
            .find(|known| object.placement.is_some() && objects[known[0]].shares_facets(object));
        match known {
            Some(known) => known.push(index),
            None => shared.push(vec![index]),
        }
    }
    shared
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
