//! What lies between two neighbouring pixels, and none of them shows: a side, a floor, or a whole gap.

use super::super::Tables;
use super::super::material::finish_of;
use super::super::pattern::growth;
use super::ends::has_side;
use super::pixel::{Pixel, width_below};
use super::{Between, Division, as_vec, ray_step, step_of};
use crate::arithmetic::{abs, div, kept, kept3, max, normalize_or, sqrt};
use crate::gbuffer::{Hits, MeshFrame, Sample};
use crate::layout::Frame;
use crate::normals::{CLASS_CAP, CLASS_FLOOR, CLASS_WALL};
use crate::openness::{self, hidden};
use crate::{Real, Vec3};
use glam::IVec2;

/// Least cosine between a cap and the direction to the eye, of what lies below it.
const LEAST_FACING: Real = 0.02;

/// Returns what `division` has found between pixel (`x`, `y`) and a neighbour, one of which hits a cap or
/// a floor: the floor or a side. It is the share of what lies between, 0…1, the direction towards its
/// middle, and what is there.
#[inline]
pub fn between<T: Tables + ?Sized, H: Hits + ?Sized>(
    tables: &T,
    frame: &Frame,
    hits: &H,
    (x, y): (u32, u32),
    division: &Division,
    is_floor: bool,
) -> (Real, Vec3, Sample) {
    let Between { which, ends } = division.groove;
    let step = step_of(which);
    let at = IVec2::new(x as i32, y as i32);
    let own = Pixel::new(frame, hits, at);
    let other = Pixel::new(frame, hits, at + step);
    // A cap, above what lies between, or a floor, below it. Of two caps, the farther one shows its side.
    let is_gap = own.hit.class == CLASS_CAP && other.hit.class == CLASS_CAP;
    let is_own = if is_gap {
        own.depth >= other.depth
    } else {
        has_side(own.hit.class, other.hit.class)
    };
    let (mut even, beyond, towards) = if is_own {
        (own, other, as_vec(step))
    } else {
        (other, own, as_vec(-step))
    };
    let is_above = even.hit.class == CLASS_CAP;
    if is_above && even.known_end(tables, towards) > 1.0 {
        // It knows another edge only. The opposite one is parallel.
        let edge = beyond.hit.edge;
        let sign = if is_gap { -1.0 } else { 1.0 };
        even.hit.edge.direction = edge.direction * sign;
        even.hit.edge.distance = edge.distance;
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
    } else if is_above {
        0.5
    } else {
        0.5 + 0.5 * finish.rim
    };
    let below = depth_fraction - if is_above { 0.0 } else { 1.0 };
    let t = length + div(below * depth, facing);
    let (mut floor, mut floor_openness) = (0.0, beyond.hit.openness);
    if !is_above {
        floor_openness = even.hit.openness;
    } else if beyond.hit.class != CLASS_FLOOR {
        let (aside, down) = even.side(tables, frame);
        let side = if is_gap {
            // Both sides, unless they hide each other.
            2.0 * aside + abs(down) * (1.0 - finish.rim)
        } else {
            // Of an opposite side that is hit, all that is not hidden has been hit.
            width_below(aside, down, finish.rim)
        };
        let side = even.along(towards, side);
        floor = max(1.0 - div(side, max(ends.other - ends.own, 1e-6)), 0.0);
        // All of the gap, not only what is seen of it.
        let seen = abs(kept(outward.dot(on_plane(ends.other) - on_plane(ends.own))));
        let width = max(seen, even.gap_width(tables));
        floor_openness = 1.0 - 2.0 * hidden(0.5 * width, depth);
    }
    if is_floor {
        let hit = Sample {
            class: CLASS_FLOOR,
            t,
            depth_fraction,
            openness: floor_openness,
            ..even.hit
        };
        return (floor, direction, hit);
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
    (1.0 - floor, direction, hit)
}
