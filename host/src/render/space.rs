//! The facets that share a space, and a hierarchy over them.

use crate::hierarchy;
use crate::prepare::PreparedObject;
use glam::{Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use relievo_shared::layout::{Frame, PrismData};
use relievo_shared::prism::{cap_hull, is_open, normal_hull};

/// Bound of the relative rounding errors of a box test and of a hit.
pub(super) const ROUNDING: f32 = 1e-5;

/// The facets of one or more objects in the same space, and a hierarchy over them.
pub(super) struct Space<'a> {
    objects: Vec<(u32, &'a PreparedObject)>,
    pub bvh: Bvh2,
    /// Object and facet of each leaf of the hierarchy, in its order.
    pub leaves: Vec<[u32; 2]>,
    /// Maximum distance of an eye from the origin that the boxes are wide enough for.
    reach: f32,
    /// Maximum distance by which a ray may meet what a box holds before the box,
    /// object units; infinite if it is not known.
    early: f32,
    /// The largest radius of a ball around a prism, object units.
    radius: f32,
}

impl<'a> Space<'a> {
    /// Builds the hierarchy over all facets of `objects`, which have these indices, for eyes
    /// within `reach`.
    pub fn new(objects: Vec<(u32, &'a PreparedObject)>, reach: f32) -> Space<'a> {
        let (bvh, leaves) = build(&objects, reach);
        let (early, radius) = (earliest_entry(&objects), largest_radius(&objects));
        Space {
            objects,
            bvh,
            leaves,
            reach,
            early,
            radius,
        }
    }

    /// Makes the boxes wide enough for an eye at this distance from the origin. Returns
    /// whether they were not.
    pub fn reach_for(&mut self, distance: f32) -> bool {
        let is_beyond = distance > self.reach;
        if is_beyond {
            self.reach = 2.0 * distance;
            (self.bvh, self.leaves) = build(&self.objects, self.reach);
        }
        is_beyond
    }

    /// Returns the distance by which a ray may meet a facet before its box.
    pub fn slack(&self) -> f32 {
        self.early + self.rounding()
    }

    /// Returns a bound of the rounding errors of a box test.
    pub fn rounding(&self) -> f32 {
        ROUNDING * self.reach
    }

    /// Calls `visit` with all facets whose shell may contain the eye of `frame`, and with
    /// some others. The shells are at most `depth` deep.
    pub fn around_eye(&self, frame: &Frame, depth: f32, mut visit: impl FnMut([u32; 2])) {
        let mut pending = Vec::from_iter((!self.bvh.nodes.is_empty()).then_some(0));
        while let Some(index) = pending.pop() {
            let node = &self.bvh.nodes[index as usize];
            // A ball around a prism contains its box.
            let bounds = node.aabb();
            let is_near =
                may_hold_eye(frame, bounds, depth) || is_within(frame, bounds, 2.0 * self.radius);
            if !is_near {
                continue;
            }
            let first = node.first_index;
            if node.is_leaf() {
                let leaves = first as usize..(first + node.prim_count) as usize;
                self.leaves[leaves].iter().copied().for_each(&mut visit);
            } else {
                pending.extend([first, first + 1]);
            }
        }
    }

    /// Returns the box around all facets.
    pub fn bounds(&self) -> Aabb {
        self.bvh
            .nodes
            .first()
            .map_or(Aabb::default(), |root| *root.aabb())
    }
}

/// Returns the boxes around the facets of `object`, through which rays enter them.
fn facet_bounds(object: &PreparedObject) -> impl Iterator<Item = (Vec3, Vec3)> + '_ {
    let depth = object.parameters.depth;
    let prisms: &[PrismData] = if object.has_prisms() {
        &object.prisms
    } else {
        &[]
    };
    let triangles = if object.has_prisms() {
        &[]
    } else {
        object.triangles.as_slice()
    };
    let triangles = triangles.iter().map(|triangle| {
        let [a, b, c] = triangle.corners.map(|corner| Vec3::from(corner.position));
        (a.min(b).min(c), a.max(b).max(c))
    });
    let prisms = prisms.iter().map(move |prism| prism_bounds(prism, depth));
    triangles.chain(prisms)
}

/// Returns the box around the facets of `object`.
#[cfg(feature = "gpu")]
pub(super) fn object_bounds(object: &PreparedObject) -> Aabb {
    let boxes = facet_bounds(object);
    let (low, high) = boxes.fold(
        (Vec3::INFINITY, Vec3::NEG_INFINITY),
        |(low, high), (min, max)| (low.min(min), high.max(max)),
    );
    Aabb::new(low.into(), high.into())
}

/// Returns whether facets within `bounds` may be in the picture of `frame`.
#[cfg(feature = "gpu")]
pub(super) fn may_be_seen(frame: &Frame, bounds: &Aabb) -> bool {
    let [right, up, forward] = [frame.right, frame.up, frame.forward].map(Vec3::from);
    // A margin of two pixels.
    let [across, down] = frame.size.map(|side| forward * (1.0 + 4.0 / side));
    let low = Vec3::from(bounds.min) - Vec3::from(frame.eye);
    let high = Vec3::from(bounds.max) - Vec3::from(frame.eye);
    // Inwards.
    let normals = [
        across + right,
        across - right,
        down + up,
        down - up,
        forward,
    ];
    let furthest = |normal: Vec3| (normal * low).max(normal * high).element_sum();
    normals.into_iter().all(|normal| furthest(normal) >= 0.0)
}

/// Returns whether the eye of `frame` may lie in the shell over a facet within `bounds`, if
/// the shell is of this `depth`.
pub(super) fn may_hold_eye(frame: &Frame, bounds: &Aabb, depth: f32) -> bool {
    // A shell is at most so far from its box as the box is large: prisms overhang, and
    // triangles bulge.
    let diagonal = Vec3::from(bounds.diagonal()).length();
    is_within(frame, bounds, 2.0 * (diagonal + 2.0 * depth + frame.near))
}

/// Returns whether the eye of `frame` is within `margin` around `bounds`.
fn is_within(frame: &Frame, bounds: &Aabb, margin: f32) -> bool {
    let eye = Vec3A::from(frame.eye);
    (eye.cmpge(bounds.min - margin) & eye.cmple(bounds.max + margin)).all()
}

/// Returns the maximum distance by which a ray may enter a shell before the box of what it
/// enters through, object units. Rays that enter through triangles do so where the quadric
/// of the surface is, which has no bound.
fn earliest_entry(objects: &[(u32, &PreparedObject)]) -> f32 {
    let entries = objects.iter().map(|(_, object)| {
        if !object.has_prisms() {
            return f32::INFINITY;
        }
        // Rays may enter up to 0.01, in weights, beyond the sides: well below a tenth of the
        // radius.
        let radii = object.prisms.iter().map(|prism| 0.1 * prism.radius);
        radii.fold(0.0, f32::max)
    });
    entries.fold(0.0, f32::max)
}

/// Returns the largest radius of a ball around a prism of `objects`, object units.
fn largest_radius(objects: &[(u32, &PreparedObject)]) -> f32 {
    let with_prisms = objects.iter().filter(|(_, object)| object.has_prisms());
    let radii = with_prisms.flat_map(|(_, object)| object.prisms.iter().map(|prism| prism.radius));
    radii.fold(0.0, f32::max)
}

/// Builds the hierarchy over all facets of `objects`, and returns it with the object and
/// facet of each leaf. The boxes are wider than the facets by more than the rounding errors
/// of the box test and of the triangle test for an eye within `reach`, so that the shared
/// triangle test alone decides.
fn build(objects: &[(u32, &PreparedObject)], reach: f32) -> (Bvh2, Vec<[u32; 2]>) {
    let count = objects
        .iter()
        .map(|(_, object)| object.triangles.len())
        .sum();
    let mut leaves = Vec::with_capacity(count);
    let mut boxes = Vec::with_capacity(count);
    for (index, object) in objects {
        for (facet, (low, high)) in (0..).zip(facet_bounds(object)) {
            let largest = low.abs().max(high.abs()).max_element().max(reach);
            let margin = Vec3::splat(4e-6 * largest);
            boxes.push(Aabb::new((low - margin).into(), (high + margin).into()));
            leaves.push([*index, facet]);
        }
    }
    let bvh = hierarchy::build(&boxes);
    let leaves = bvh
        .primitive_indices
        .iter()
        .map(|&index| leaves[index as usize])
        .collect();
    (bvh, leaves)
}

/// Returns the bounding box of the faces through which a ray may enter a prism
/// from outside.
fn prism_bounds(data: &PrismData, depth: f32) -> (Vec3, Vec3) {
    let cap = cap_hull(data);
    let mut low = cap.into_iter().fold(cap[0], Vec3::min);
    let mut high = cap.into_iter().fold(cap[0], Vec3::max);
    if is_open(data) {
        for (point, normal) in cap.into_iter().zip(normal_hull(data)) {
            let floor = point - normal * depth;
            low = low.min(floor);
            high = high.max(floor);
        }
    }
    // Rays may enter slightly beyond the sides.
    let margin = Vec3::splat(1e-3 * (high - low).max_element());
    let anchor = Vec3::from(data.anchor);
    (anchor + low - margin, anchor + high + margin)
}
