//! The objects with a placement, for the renderer on the CPU: those that share facets share
//! a hierarchy, and one more finds the objects.

use super::space::Space;
use crate::hierarchy;
use crate::mesh::Bounds;
use crate::prepare::{PreparedObject, PreparedScene};
use glam::Vec3;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use rayon::prelude::*;
use relievo_shared::layout::Frame;

/// The objects with a placement, in spaces of their own.
pub(super) struct Placed<'a> {
    spaces: Vec<Space<'a>>,
    /// Index of the space of each object of the scene, placed or not; empty if none is.
    space_of: Vec<u32>,
    /// The frame in the space of each object of the scene; empty if none is placed.
    frames: Vec<Frame>,
    /// A hierarchy over the placed objects, in world space.
    pub bvh: Bvh2,
    /// Indices of the placed objects.
    pub objects: Vec<u32>,
}

impl<'a> Placed<'a> {
    /// Builds the hierarchies over the facets of the objects of `scene` with a placement.
    pub fn new(scene: &'a PreparedScene) -> Placed<'a> {
        let mut placed = Placed {
            spaces: Vec::new(),
            space_of: Vec::new(),
            frames: Vec::new(),
            bvh: Bvh2::default(),
            objects: Vec::new(),
        };
        if scene
            .objects
            .iter()
            .all(|object| object.placement.is_none())
        {
            return placed;
        }
        // The first object of each space, and the reach of the eyes in it.
        let mut firsts: Vec<(u32, &PreparedObject, f32)> = Vec::new();
        for (i, object) in (0..).zip(&scene.objects) {
            let mut space = 0;
            if object.placement.is_some() {
                // Objects that share facets follow each other, or are few.
                let shares =
                    |(_, first, _): &(u32, &PreparedObject, f32)| first.shares_facets(object);
                space = firsts.iter().rposition(shares).unwrap_or_else(|| {
                    firsts.push((i, object, 0.0));
                    firsts.len() - 1
                });
                let eye = Vec3::from(object.frame(&scene.frame).eye);
                let reach = &mut firsts[space].2;
                *reach = reach.max(2.0 * eye.abs().max_element());
                placed.objects.push(i);
            }
            placed.space_of.push(space as u32);
        }
        let spaces = firsts.into_iter();
        placed.spaces = spaces
            .map(|(i, object, reach)| Space::new(vec![(i, object)], reach))
            .collect();
        placed
    }

    /// Returns the space of placed object `object`.
    pub fn space(&self, object: u32) -> &Space<'a> {
        &self.spaces[self.space_of[object as usize] as usize]
    }

    /// Returns `frame` in the space of `object`.
    pub fn frame<'f>(&'f self, frame: &'f Frame, object: u32) -> &'f Frame {
        self.frames.get(object as usize).unwrap_or(frame)
    }

    /// Computes the frames of the objects, and makes the boxes wide enough for the eye of
    /// `frame`.
    pub fn reach_for(&mut self, scene: &PreparedScene, frame: &Frame) {
        if self.objects.is_empty() {
            return;
        }
        let objects = scene.objects.par_iter();
        objects
            .map(|object| *object.frame(frame))
            .collect_into_vec(&mut self.frames);
        let mut reaches = vec![0.0; self.spaces.len()];
        for &object in &self.objects {
            let eye = Vec3::from(self.frames[object as usize].eye);
            let reach: &mut f32 = &mut reaches[self.space_of[object as usize] as usize];
            *reach = reach.max(eye.abs().max_element());
        }
        let mut grew = self.bvh.nodes.is_empty();
        for (space, reach) in self.spaces.iter_mut().zip(reaches) {
            grew |= space.reach_for(reach);
        }
        if grew {
            self.build(scene, frame);
        }
    }

    /// Builds the hierarchy over the placed objects.
    fn build(&mut self, scene: &PreparedScene, frame: &Frame) {
        let boxes = self.objects.iter().map(|&index| {
            let own = self.space(index).bounds();
            let own = Bounds {
                min: Vec3::from(own.min).as_dvec3(),
                max: Vec3::from(own.max).as_dvec3(),
            };
            let placement = &scene.objects[index as usize].placement;
            let around = placement
                .as_ref()
                .map_or(own, |placement| placement.bounds(&own));
            let (low, high) = (around.min.as_vec3(), around.max.as_vec3());
            let reach = 2.0 * Vec3::from(frame.eye).abs().max_element();
            let margin = 4e-6 * low.abs().max(high.abs()).max_element().max(reach);
            Aabb::new((low - margin).into(), (high + margin).into())
        });
        self.bvh = hierarchy::build(&boxes.collect::<Vec<_>>());
        // In the order of the leaves.
        let leaves = self.bvh.primitive_indices.iter();
        self.objects = leaves.map(|&leaf| self.objects[leaf as usize]).collect();
    }
}
