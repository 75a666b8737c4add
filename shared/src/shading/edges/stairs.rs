//! Edges that no hit knows, such as the border of a flat mesh. On the picture they are stairs: the
//! line through the middles of their risers is taken for the edge (Reshetov, "Morphological
//! antialiasing", 2009). Where they make an arc, it is where the surface turns away from the eye.

use super::pixel::Pixel;
use crate::Real;
use crate::arithmetic::{abs, div, max};
use crate::gbuffer::{Hits, Sample};
use crate::layout::Frame;
use crate::normals::CLASS_MISS;
use glam::IVec2;

/// Largest distance of a riser, pixels.
const REACH: i32 = 16;

/// What tells pixels on both sides of an edge apart.
#[derive(Clone, Copy)]
struct Side {
    /// Index of the finish and one; 0 of a miss.
    object: u32,
    /// 1 / t; 0 of a miss.
    inverse: Real,
}

impl Side {
    #[inline(always)]
    fn new<H: Hits + ?Sized>(hits: &H, at: IVec2) -> Side {
        let (place, surface) = hits.words(at.x as u32, at.y as u32);
        let hit = Sample::on_mesh(place, surface);
        if hit.class == CLASS_MISS {
            Side {
                object: 0,
                inverse: 0.0,
            }
        } else {
            Side {
                object: hit.finish + 1,
                inverse: div(1.0, max(hit.t, 1e-18)),
            }
        }
    }

    /// Returns whether a pixel is on this side, rather than on the `opposite` one.
    #[inline]
    fn has(&self, pixel: &Side, opposite: &Side) -> bool {
        let is_own = pixel.object == self.object;
        if is_own != (pixel.object == opposite.object) {
            is_own
        } else {
            abs(pixel.inverse - self.inverse) < abs(pixel.inverse - opposite.inverse)
        }
    }
}

/// Returns the share of the neighbour along `step` in pixel `at` of `frame`, 0…½, where the edge between
/// both is not known.
#[inline]
pub(super) fn share<H: Hits + ?Sized>(frame: &Frame, hits: &H, at: IVec2, step: IVec2) -> Real {
    let size = IVec2::new(frame.size[0] as i32, frame.size[1] as i32);
    let own = Side::new(hits, at);
    let other = Side::new(hits, at + step);
    let is_inside = |p: IVec2| p.x >= 0 && p.y >= 0 && p.x < size.x && p.y < size.y;
    // Distances of the nearer riser and of both together, and how far the edge moves towards the other
    // pixel up to the middle of the nearer one and of both together.
    let (mut nearest, mut both) = (REACH as Real, 0.0);
    let (mut shift, mut shifts) = (0.0, 0.0);
    let mut which = 0;
    while which < 2 {
        let across = IVec2::new(step.y, step.x);
        let way = if which == 0 { across } else { -across };
        let mut next = at;
        let mut pixels = 0;
        let mut rise = 0.0;
        let mut is_even = true;
        while is_even && pixels < REACH {
            pixels += 1;
            next += way;
            is_even = is_inside(next) && is_inside(next + step);
            if is_even {
                let is_own = own.has(&Side::new(hits, next), &other);
                let is_other = other.has(&Side::new(hits, next + step), &own);
                is_even = is_own && is_other;
                if is_own != is_other {
                    rise = if is_own { 0.5 } else { -0.5 };
                }
            }
        }
        let distance = pixels as Real - 0.5;
        both += distance;
        shifts += rise;
        if distance < nearest {
            nearest = distance;
            shift = rise;
        }
        which += 1;
    }
    if abs(shifts) > 0.5 {
        // Both on one side.
        return max(0.5 - horizon(frame, hits, at, step), 0.0);
    }
    // The line leads from the riser to the middle between both.
    max(-shift * (1.0 - 2.0 * div(nearest, both)), 0.0)
}

/// Returns where the nearer one of what pixel `at` of `frame` and its neighbour along `step` hit turns away
/// from the eye, pixels along `step`; ½ if that is not between them.
#[inline]
fn horizon<H: Hits + ?Sized>(frame: &Frame, hits: &H, at: IVec2, step: IVec2) -> Real {
    let own = Pixel::new(frame, hits, at);
    let other = Pixel::new(frame, hits, at + step);
    let is_own = own.is_hit() && (!other.is_hit() || own.depth < other.depth);
    let (nearer, before) = if is_own {
        (own, at - step)
    } else {
        (other, at + step + step)
    };
    let place = nearer.horizon(&Pixel::new(frame, hits, before));
    if place > 1.0 {
        0.5
    } else if is_own {
        place
    } else {
        1.0 - place
    }
}
