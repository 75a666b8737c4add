//! Uploads a prepared scene to a device, and records its drawing.

use super::content::{Content, Drawing};
use super::lit::GpuLighting;
use super::outlines::{
    Outlines, Run, Runs, bound_frame_bytes, frame_buffer_bytes, padded, workgroups,
};
use super::pipelines::Pipelines;
use super::shared::{STRIDE, sharing};
use super::targets::Targets;
use super::timestamps::Timestamps;
use crate::prepare::{Placement, PreparedScene};
use crate::render::space::{may_be_seen, may_hold_eye, object_bounds};
use crate::render::{RenderError, background_words};
use crate::shaders::{EntryPoints, Extent, facet_bytes};
use obvhs::aabb::Aabb;
use rayon::prelude::*;
use relievo_shared::layout::Frame;
use std::cell::Cell;
use std::mem::size_of;
use std::num::NonZero;

/// The buffers of one scene, drawn by the pipelines that it was made for.
pub struct GpuScene {
    /// The frame in world space, and those in the spaces of the objects that are drawn.
    frames: wgpu::Buffer,
    facets: Vec<GpuFacets>,
    objects: Vec<GpuObject>,
    /// The frame of each object in its space, and where it is in `frames`; `None` where the object
    /// lies outside the picture.
    seen: Vec<Option<(Frame, u32)>>,
    runs: Runs,
    outlines: Outlines,
    lighting: Option<GpuLighting>,
    background: wgpu::Color,
    bytes: u64,
}

/// Facets, and how they are drawn.
struct GpuFacets {
    bindings: wgpu::BindGroup,
    count: u32,
    entry_points: EntryPoints,
    /// Whether their exits are written.
    has_exits: bool,
    /// Whether copies of them are drawn.
    has_copies: bool,
    /// The box around them, object space.
    bounds: Aabb,
    depth: f32,
}

/// An object: facets in a place.
struct GpuObject {
    /// Index of its facets.
    facets: u32,
    placement: Option<Placement>,
    /// [`Frame::number`].
    number: u32,
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
                (
                    "triangles",
                    padded(object.triangles.len() as u64) as usize * facets.bytes(),
                ),
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
        let with_room = |label: &str, room: u64, bytes: &[u8]| {
            let size = room.max(4);
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
        let storage = |label: &str, bytes: &[u8]| with_room(label, bytes.len() as u64, bytes);
        let shared = sharing(&scene.objects);
        let frames = with_room("frames", frame_buffer_bytes(&scene.objects, &shared), &[]);
        // Objects with the same map share its buffer.
        let mut maps: Vec<(*const u32, wgpu::Buffer)> = Vec::new();
        let mut facets = Vec::new();
        let mut objects = Vec::with_capacity(scene.objects.len());
        for shared in shared {
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
            let has_exits = entry_points.writes_exits(&object.parameters);
            let parameters = storage("object", bytemuck::bytes_of(&object.parameters));
            let room = padded(object.triangles.len() as u64) * entry_points.facets.bytes() as u64;
            let buffer = with_room("facets", room, &facet_bytes(object, entry_points.facets));
            let count = object.triangles.len() as u64;
            let resources = [
                wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                    buffer: &frames,
                    offset: 0,
                    size: NonZero::new(bound_frame_bytes(shared.len() as u64, count)),
                }),
                parameters.as_entire_binding(),
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
            let drawing = Content::Color.drawing(scene.lighting.is_some());
            let has_copies = shared.len() > 1;
            pipelines.make(&entry_points, drawing, has_copies)?;
            if has_exits {
                pipelines.make_exits(has_copies)?;
            }
            for index in shared {
                let own = &scene.objects[index];
                // Those that share facets differ by the number of their exits only.
                let number = own.parameters.number.wrapping_sub(object.parameters.number);
                let placed = GpuObject {
                    facets: facets.len() as u32,
                    placement: own.placement,
                    number,
                };
                objects.push((index, placed));
            }
            facets.push(GpuFacets {
                bindings,
                count: count as u32,
                entry_points,
                has_exits,
                has_copies,
                bounds: object_bounds(object),
                depth: object.parameters.depth,
            });
        }
        // In drawing order.
        objects.sort_unstable_by_key(|(index, _)| *index);
        let objects: Vec<GpuObject> = objects.into_iter().map(|(_, object)| object).collect();
        let [r, g, b, a] = background_words(scene).map(f64::from);
        let counts = scene
            .objects
            .iter()
            .map(|object| object.triangles.len() as u64);
        let outlines = Outlines::new(pipelines, counts);
        total.set(total.get() + outlines.bytes());
        let lighting = match &scene.lighting {
            None => None,
            Some(lighting) => {
                let bytes: u64 = lighting.buffer_bytes().iter().sum();
                total.set(total.get() + bytes);
                let made = GpuLighting::new(lighting, pipelines, &frames, description)?;
                Some(made)
            }
        };
        let mut made = GpuScene {
            outlines,
            lighting,
            frames,
            facets,
            runs: Runs::default(),
            seen: Vec::with_capacity(objects.len()),
            objects,
            background: wgpu::Color { r, g, b, a },
            bytes: total.get(),
        };
        made.cast_shadows(pipelines)?;
        Ok(made)
    }

    /// Draws the shadow maps of all lights.
    fn cast_shadows(&mut self, pipelines: &mut Pipelines) -> Result<(), RenderError> {
        let Some(lighting) = self.lighting.take() else {
            return Ok(());
        };
        let opened = pipelines.device().clone();
        let mut kept: Option<Targets> = None;
        for (index, frame) in lighting.frames().iter().enumerate() {
            self.make_drawing(pipelines, Drawing::Depth)?;
            let size = frame.size.map(|side| side as u32);
            let mut targets = match kept.take().filter(|kept| kept.size() == size) {
                Some(targets) => targets,
                None => Targets::with_depth(&opened, size, true)?,
            };
            self.make_exits(pipelines, &mut targets);
            self.set_frame(opened.queue(), frame);
            let descriptor = wgpu::CommandEncoderDescriptor::default();
            let mut encoder = opened.wgpu().create_command_encoder(&descriptor);
            self.record_objects(
                &mut encoder,
                pipelines,
                &targets,
                Drawing::Depth,
                [None, None],
            );
            lighting.record_shadow(&mut encoder, &targets, index);
            opened.queue().submit([encoder.finish()]);
            kept = Some(targets);
        }
        self.lighting = Some(lighting);
        Ok(())
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
        self.make_drawing(pipelines, content.drawing(self.lighting.is_some()))
    }

    fn make_drawing(&self, pipelines: &mut Pipelines, drawing: Drawing) -> Result<(), RenderError> {
        for facets in &self.facets {
            pipelines.make(&facets.entry_points, drawing, facets.has_copies)?;
            if facets.has_exits {
                pipelines.make_exits(facets.has_copies)?;
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
        targets.make(pipelines.device(), content.drawing(false), read_back);
        match &self.lighting {
            Some(lighting) if content == Content::Color => {
                for pass in lighting.passes() {
                    targets.make_pass(pipelines, *pass);
                }
            }
            _ => (),
        }
        self.make_exits(pipelines, targets);
    }

    /// Makes the picture of exits, if an object asks for it.
    fn make_exits(&self, pipelines: &Pipelines, targets: &mut Targets) {
        let mut facets = self.facets.iter();
        if facets.any(|facets| facets.entry_points.asks_for_exits) {
            let is_written = self.facets.iter().any(|facets| facets.has_exits);
            targets.make_exits(pipelines, is_written);
        }
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
        let drawing = content.drawing(self.lighting.is_some());
        match &self.lighting {
            Some(lighting) if drawing == Drawing::Surface => {
                let clocks = [timestamps, None];
                self.record_objects(encoder, pipelines, targets, drawing, clocks);
                lighting.record(encoder, pipelines, targets, timestamps);
            }
            _ => self.record_objects(encoder, pipelines, targets, drawing, [timestamps; 2]),
        }
    }

    /// Records the drawing of all objects, whose begin and end `clocks` take.
    fn record_objects(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        pipelines: &Pipelines,
        targets: &Targets,
        drawing: Drawing,
        [begin, end]: [Option<&Timestamps>; 2],
    ) {
        let batches = self.runs.batches();
        let has_exits = self.facets.iter().any(|facets| facets.has_exits);
        let exits = targets.exits().filter(|_| has_exits);
        if let Some(exits) = exits {
            let views = [Some((&exits.view, wgpu::Color::TRANSPARENT))];
            for batch in 0..batches {
                let clock = begin.filter(|_| batch == 0).map(Timestamps::begin);
                self.record_outlines(encoder, pipelines, batch, true, clock);
                let mut pass = begin_pass(encoder, targets, &views, batch, batches, None);
                for run in self.runs.batch(batch) {
                    let facets = &self.facets[run.facets as usize];
                    if facets.has_exits {
                        pass.set_pipeline(pipelines.exits(facets.has_copies));
                        self.draw(&mut pass, run);
                    }
                }
            }
        }
        let clear = match drawing {
            Drawing::Color => self.background,
            Drawing::Geometry | Drawing::Surface | Drawing::Depth => wgpu::Color::TRANSPARENT,
        };
        let views = drawing.targets();
        let views: Vec<_> = views
            .map(|index| Some((targets.view(index)?, clear)))
            .collect();
        for batch in 0..batches {
            let is_first = batch == 0 && exits.is_none();
            let clock = begin.filter(|_| is_first).map(Timestamps::begin);
            self.record_outlines(encoder, pipelines, batch, false, clock);
            let is_last = batch + 1 == batches;
            let clock = end.filter(|_| is_last).map(Timestamps::end);
            let mut pass = begin_pass(encoder, targets, &views, batch, batches, clock);
            if let Some(exits) = targets.exits() {
                pass.set_bind_group(1, &exits.bindings, &[]);
            }
            let mut last = None;
            for run in self.runs.batch(batch) {
                if last != Some(run.facets) {
                    let facets = &self.facets[run.facets as usize];
                    let pipeline = pipelines.get(&facets.entry_points, drawing, facets.has_copies);
                    pass.set_pipeline(pipeline);
                    last = Some(run.facets);
                }
                self.draw(&mut pass, run);
            }
        }
    }

    /// Records the search for the outlines of the facets of a batch, or of the exits
    /// through them.
    fn record_outlines(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        pipelines: &Pipelines,
        batch: usize,
        of_exits: bool,
        timestamp_writes: Option<wgpu::ComputePassTimestampWrites<'_>>,
    ) {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("outlines"),
            timestamp_writes,
        });
        let mut last = None;
        for run in self.runs.batch(batch) {
            let facets = &self.facets[run.facets as usize];
            if of_exits && !facets.has_exits {
                continue;
            }
            if last != Some(run.facets) {
                let entry_points = &facets.entry_points;
                pass.set_pipeline(pipelines.outlines(entry_points, of_exits, facets.has_copies));
                last = Some(run.facets);
            }
            pass.set_bind_group(0, &facets.bindings, &[run.frames]);
            pass.set_bind_group(1, self.outlines.written(), &[run.outlines]);
            let [groups, rows] = workgroups(u64::from(facets.count) * u64::from(run.copies));
            pass.dispatch_workgroups(groups, rows, 1);
        }
    }

    /// Draws the outlines of `run`.
    fn draw(&self, pass: &mut wgpu::RenderPass<'_>, run: &Run) {
        let facets = &self.facets[run.facets as usize];
        pass.set_bind_group(0, &facets.bindings, &[run.frames]);
        pass.set_bind_group(2, self.outlines.read(), &[run.outlines]);
        pass.draw(0..3 * facets.count * run.copies, 0..1);
    }

    /// Sets the camera and the light of the pictures that are recorded after this.
    pub fn set_frame(&mut self, queue: &wgpu::Queue, frame: &Frame) {
        let facets = &self.facets;
        let own = self.objects.par_iter().map(|object| {
            let own = match &object.placement {
                Some(placement) => Frame {
                    number: object.number,
                    ..placement.frame(frame)
                },
                None => *frame,
            };
            let GpuFacets { bounds, depth, .. } = &facets[object.facets as usize];
            let is_seen = may_be_seen(&own, bounds) || may_hold_eye(&own, bounds, *depth);
            is_seen.then_some((own, 0))
        });
        own.collect_into_vec(&mut self.seen);
        self.runs.clear();
        for (object, seen) in self.objects.iter().zip(&mut self.seen) {
            if let Some((_, place)) = seen {
                let is_placed = object.placement.is_some();
                let count = facets[object.facets as usize].count.into();
                let sizes = self.outlines.sizes();
                *place = self.runs.add(object.facets, count, is_placed, sizes);
            }
        }
        queue.write_buffer(&self.frames, 0, bytemuck::bytes_of(frame));
        let Some(size) = NonZero::new(self.runs.frame_bytes() - STRIDE as u64) else {
            return;
        };
        let Some(mut bytes) = queue.write_buffer_with(&self.frames, STRIDE as u64, size) else {
            return;
        };
        for (frame, place) in self.seen.iter().flatten().filter(|(_, place)| *place > 0) {
            let start = *place as usize - STRIDE;
            let place = start..start + size_of::<Frame>();
            bytes
                .slice(place)
                .copy_from_slice(bytemuck::bytes_of(frame));
        }
    }
}

/// Begins the render pass of batch `batch` of `batches` to `views`, which are cleared before
/// the first one, as the depth buffer is.
fn begin_pass<'encoder>(
    encoder: &'encoder mut wgpu::CommandEncoder,
    targets: &Targets,
    views: &[Option<(&wgpu::TextureView, wgpu::Color)>],
    batch: usize,
    batches: usize,
    timestamp_writes: Option<wgpu::RenderPassTimestampWrites<'_>>,
) -> wgpu::RenderPass<'encoder> {
    let (is_first, is_last) = (batch == 0, batch + 1 == batches);
    let load = |color| match is_first {
        true => wgpu::LoadOp::Clear(color),
        false => wgpu::LoadOp::Load,
    };
    let attachments = views.iter().map(|view| {
        let (view, color) = (*view)?;
        Some(wgpu::RenderPassColorAttachment {
            view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load: load(color),
                store: wgpu::StoreOp::Store,
            },
        })
    });
    let attachments: Vec<_> = attachments.collect();
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("relievo"),
        color_attachments: &attachments,
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: targets.depth(),
            depth_ops: Some(wgpu::Operations {
                load: if is_first {
                    wgpu::LoadOp::Clear(0.0)
                } else {
                    wgpu::LoadOp::Load
                },
                store: if is_last && targets.kept_depth().is_none() {
                    wgpu::StoreOp::Discard
                } else {
                    wgpu::StoreOp::Store
                },
            }),
            stencil_ops: None,
        }),
        timestamp_writes,
        occlusion_query_set: None,
        multiview_mask: None,
    })
}
