//! What lies between two neighbouring pixels, and none of them shows: a side, a floor, a whole gap, or a cap.

use super::super::Tables;
use super::super::material::finish_of;
use super::super::pattern::growth;
use super::ends::has_side;
use super::pixel::{Pixel, width_below};
use super::{Division, as_vec, ray_step, step_of};
use crate::arithmetic::{abs, div, kept, kept3, max, min, normalize_or, sqrt};
use crate::gbuffer::{Hits, MeshFrame, Sample, is_side};
use crate::layout::Frame;
use crate::normals::{CLASS_CAP, CLASS_FLOOR, CLASS_WALL};
use crate::openness::{self, hidden};
use crate::{Real, Vec3};
use glam::IVec2;

/// Least cosine between a cap and the direction to the eye, of what lies below it.
const LEAST_FACING: Real = 0.02;

/// A part of a pixel that lies between it and a neighbour.
#[derive(Clone, Copy, Debug)]
pub struct Part {
    /// Whether the neighbour is the one to the right or below.
    pub is_after: bool,
    /// Whether it is the floor, rather than a side or a cap.
    pub is_floor: bool,
}

/// Returns a part of what `division` has found between pixel (`x`, `y`) and a neighbour: its share of the pixel, the
/// direction towards the middle of what lies between, and what is there.
#[inline]
pub fn between<T: Tables + ?Sized, H: Hits + ?Sized>(
    tables: &T,
    frame: &Frame,
    hits: &H,
    (x, y): (u32, u32),
    division: &Division,
    part: Part,
) -> (Real, Vec3, Sample) {
    let Part { is_after, is_floor } = part;
    let ends = if is_after {
        division.after
    } else {
        division.before
    };
    let step = step_of(division.first + u32::from(is_after));
    let at = IVec2::new(x as i32, y as i32);
    let own = Pixel::new(frame, hits, at);
    let other = Pixel::new(frame, hits, at + step);
    let is_gap = own.hit.class == CLASS_CAP && other.hit.class == CLASS_CAP;
    // The cap beyond a side that hides the rest, or a floor between two sides.
    let is_own_cap = own.leads_to_cap(as_vec(step));
    let is_cap = own.hit.class != CLASS_CAP
        && other.hit.class != CLASS_CAP
        && (is_own_cap || other.leads_to_cap(as_vec(-step)));
    let is_level = is_cap || is_side(own.hit.class) && is_side(other.hit.class);
    // A cap, above what lies between, or a floor, below it.
    let mut is_own = if is_level {
        is_own_cap || !is_cap
    } else {
        is_gap || has_side(own.hit.class, other.hit.class)
    };
    let (mut even, beyond, towards) = if is_own {
        (own, other, as_vec(step))
    } else {
        (other, own, as_vec(-step))
    };
    if is_level {
        let at = if is_own { at } else { at + step };
        let mesh = hits.mesh(at.x as u32, at.y as u32);
        even = even.level(tables, &mesh, is_cap);
    }
    let is_above = even.hit.class == CLASS_CAP;
    if !is_level && even.known_end(tables, towards) > 1.0 {
        // It knows another edge only. The opposite one is parallel.
        let edge = beyond.hit.edge;
        let sign = if is_gap { -1.0 } else { 1.0 };
        even.hit.edge.direction = edge.direction * sign;
        even.hit.edge.distance = edge.distance;
    }
    // Whether it is more than one side.
    let is_deep =
        is_level || is_above && beyond.hit.class != CLASS_FLOOR && !beyond.leads_to_cap(-towards);
    // The share of floor in what lies within the pixel: sides are at the ends.
    let mut floor = if is_level && !is_above { 1.0 } else { 0.0 };
    if is_deep && !is_level {
        let rim = tables.finish(finish_of(&even.hit)).rim;
        let (aside, down) = even.side(tables, frame);
        let near = even.along(towards, width_below(aside, down, rim));
        // Of an opposite side that is hit, all that is not hidden has been hit.
        let far = if is_gap {
            even.along(towards, width_below(aside, -down, rim))
        } else {
            0.0
        };
        let (first, second) = if is_own { (near, far) } else { (far, near) };
        let last = min(ends.other, 0.5);
        let begin = min(ends.own + first, last);
        let end = max(min(ends.other - second, last), begin);
        floor = div(end - begin, max(last - ends.own, 1e-6));
        if is_gap && last - end > begin - ends.own {
            // Most of the side within the pixel is the opposite one.
            let to_edge = -even.hit.edge.direction;
            is_own = false;
            even = other;
            even.hit.edge.direction = to_edge;
        }
    }
    let finish = tables.finish(finish_of(&even.hit));
    let depth = finish.depth * even.hit.unit;
    let smooth = even.hit.normal;
    let outward = even.outward(frame);
    // Where the ray goes through the plane of the cap or the floor.
    let along = ray_step(frame, step);
    let (inverse, slope) = even.inverse(along);
    let first = if is_own { 0.0 } else { 1.0 };
    let on_plane = |place: Real| {
        let inverse = max(inverse + slope * (place - first), 0.5 * inverse);
        (own.ray + along * place) * div(1.0, inverse)
    };
    let middle = on_plane(0.5 * (ends.own + ends.other));
    let length = sqrt(middle.dot(middle));
    let direction = middle * div(1.0, length);
    let facing = max(-kept(smooth.dot(direction)), LEAST_FACING);
    let depth_fraction = if is_floor {
        1.0
    } else if is_level {
        0.0
    } else if is_above {
        0.5
    } else {
        0.5 + 0.5 * finish.rim
    };
    let below = depth_fraction - if is_above { 0.0 } else { 1.0 };
    let t = length + div(below * depth, facing);
    let mut floor_openness = if is_above {
        beyond.hit.openness
    } else {
        even.hit.openness
    };
    if is_deep {
        // All of the gap, not only what is seen of it.
        let seen = abs(kept(outward.dot(on_plane(ends.other) - on_plane(ends.own))));
        let width = max(seen, even.gap_width(tables));
        floor_openness = 1.0 - 2.0 * hidden(0.5 * width, depth);
    }
    let share = ends.between() * if is_floor { floor } else { 1.0 - floor };
    if is_floor || is_level {
        let hit = Sample {
            t,
            depth_fraction,
            openness: if is_floor { floor_openness } else { 1.0 },
            ..even.hit
        };
        let class = if is_floor { CLASS_FLOOR } else { CLASS_CAP };
        return (share, direction, Sample { class, ..hit });
    }
    // The wall above a floor faces it.
    let (class, upright, lean) = if is_above {
        let growth = growth(tables, finish, &even.hit, outward);
        (finish.side, outward, div(growth, max(finish.depth, 1e-12)))
    } else {
        (CLASS_WALL, -outward, 0.0)
    };
    let normal = normalize_or(kept3(upright + smooth * lean), upright);
    let mesh = MeshFrame {
        normal: smooth,
        along_u: even.hit.tangent,
        is_mirrored: even.hit.is_mirrored,
    };
    let outline = smooth.cross(upright);
    let is_along_v = abs(outline.dot(mesh.along_u)) < abs(outline.dot(mesh.along_v()));
    // Of the sky, a side sees half of what the floor does.
    let sky = 0.5 * floor_openness;
    let hit = Sample {
        class,
        t,
        depth_fraction,
        normal,
        openness: openness::of_side(class, sky),
        ..even.hit
    }
    .along_outline(&mesh, outline, is_along_v);
    (share, direction, hit)
}
