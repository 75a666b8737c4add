//! Pixels inside one surface, where no edge is sought: most pixels of most pictures.

use super::pixel::STEP;
use super::step_of;
use crate::arithmetic::{abs, div, kept, kept3, max, min, sqrt};
use crate::camera::through;
use crate::gbuffer::{self, Hits, from_octahedral};
use crate::layout::{Frame, vec3};
use crate::{Real, Vec3};
use glam::IVec2;

/// Returns whether no edge is near pixel `at`: those beside it are misses as it is, or hit the same part of an
/// object, far from its edge, and the tangent plane at each of the two leads to the other. Costs little: only the
/// normal of the pixel is decoded.
#[inline]
pub(super) fn is_inside<H: Hits + ?Sized>(frame: &Frame, hits: &H, at: IVec2) -> bool {
    let (place, surface) = hits.words(at.x as u32, at.y as u32);
    let normal = from_octahedral(surface.y);
    let pixel = pixel_width(frame);
    let size = IVec2::new(frame.size[0] as i32, frame.size[1] as i32);
    let ray = through(frame, at.x as Real, at.y as Real);
    let inverse = div(1.0, sqrt(ray.dot(ray)));
    let depth = f32::from_bits(place.x) * inverse;
    let facing = -kept(normal.dot(ray));
    let mut is_inside = gbuffer::is_miss(surface) || gbuffer::is_far_from_edge(surface);
    let mut which = 0;
    while is_inside && which < 4 {
        let next = at + step_of(which);
        if next.x >= 0 && next.y >= 0 && next.x < size.x && next.y < size.y {
            let (other_place, other_surface) = hits.words(next.x as u32, next.y as u32);
            let other_ray = through(frame, next.x as Real, next.y as Real);
            // A step of Newton's method from the inverse length of the ray beside it.
            let square = kept(other_ray.dot(other_ray) * inverse * inverse);
            let other_depth = f32::from_bits(other_place.x) * inverse * (1.5 - 0.5 * square);
            let way = kept3(other_ray * other_depth - ray * depth);
            // How far each hit is from the plane of the other, and how that faces its ray, at worst. Both height
            // and slack are 0 for misses.
            let turn = gbuffer::largest_turn(surface.y, other_surface.y);
            let height = abs(kept(normal.dot(way))) + turn * size_of(way);
            let faces = min(facing, -kept(normal.dot(other_ray))) - turn * size_of(other_ray);
            let slack = max(STEP * pixel * min(depth, other_depth) * faces, 0.0);
            is_inside = gbuffer::is_same_part(surface, other_surface) && height <= slack;
        }
        which += 1;
    }
    is_inside
}

/// Returns the shorter side of a pixel at distance 1.
#[inline]
fn pixel_width(frame: &Frame) -> Real {
    let (right, down) = (vec3(frame.ray_right), vec3(frame.ray_down));
    sqrt(min(right.dot(right), down.dot(down)))
}

/// Returns no less than the length of `v`.
#[inline]
fn size_of(v: Vec3) -> Real {
    abs(v.x) + abs(v.y) + abs(v.z)
}
