//! Smooth edges: which shares of a pixel belong to its neighbours, and to sides, floor and cap between
//! them that none of them shows.
//!
//! The surfaces that two neighbours hit end somewhere between the centres of their pixels: at the
//! [edge](crate::edge) that one of them knows; else where their tangent planes meet, unless they are one
//! surface that curves; else where their stairs on the picture tell. On a side, what is known of its edge at
//! the cap tells where its bevel or its wall ends, too, and where the opposite cap begins; on a cap, where
//! the side below its edge ends; on a floor, where the wall above its edge ends. Between two sides is floor,
//! and between a side and what is hidden beyond its edge is cap.
//!
//! A pixel is divided along one axis, that along which less of it is its own: an edge that
//! crosses both meets the other one at a flatter angle.

mod between;
mod code;
mod ends;
mod inside;
pub(super) mod pixel;
mod stairs;

pub use between::{Part, between};
pub use code::{Shares, from_code, light_in, light_words, lights_of};

use super::Tables;
use crate::arithmetic::{div, max};
use crate::gbuffer::Hits;
use crate::layout::{Frame, vec3};
use crate::normals::{CLASS_BEVEL, CLASS_FLOOR};
use crate::{Real, Vec2, Vec3};
use ends::{Ends, NONE, UNKNOWN, ends};
use glam::IVec2;
use inside::is_inside;
use pixel::Pixel;

/// How a pixel is divided along one axis; the rest is its own.
#[derive(Clone, Copy, Debug)]
pub struct Division {
    /// Its first neighbour ([`step_of`]): 0, to the left, or 2, above. A number, since a GPU keeps flags in registers
    /// that are scarcer.
    first: u32,
    /// Where it and the neighbour to the left or above end.
    before: Ends,
    /// Where it and the one to the right or below end.
    after: Ends,
}

/// A pixel that is all its own.
const WHOLE: Division = Division {
    first: 0,
    before: NONE,
    after: NONE,
};

/// Returns how pixel (`x`, `y`) of `frame` is divided.
#[inline]
pub fn division<T: Tables + ?Sized, H: Hits + ?Sized>(
    tables: &T,
    frame: &Frame,
    hits: &H,
    x: u32,
    y: u32,
) -> Division {
    let at = IVec2::new(x as i32, y as i32);
    if is_inside(frame, hits, at) {
        WHOLE
    } else {
        at_edges(tables, frame, hits, at)
    }
}

/// Returns how pixel `at` is divided by the edges around it.
#[inline]
fn at_edges<T: Tables + ?Sized, H: Hits + ?Sized>(
    tables: &T,
    frame: &Frame,
    hits: &H,
    at: IVec2,
) -> Division {
    let mut own = Pixel::new(frame, hits, at);
    // Here, and not where the neighbours are compared: there it would take registers.
    own.side_width = own.width_of_side(tables, frame);
    let size = IVec2::new(frame.size[0] as i32, frame.size[1] as i32);
    // A bit for each neighbour.
    let mut unknown = 0;
    let mut found = WHOLE;
    let mut axis = WHOLE;
    let mut which = 0;
    while which < 4 {
        let is_second = which & 1 == 1;
        let step = step_of(which);
        if !is_second {
            axis = Division {
                first: which,
                ..WHOLE
            };
        }
        let next = at + step;
        if next.x >= 0 && next.y >= 0 && next.x < size.x && next.y < size.y {
            let mut other = Pixel::new(frame, hits, next);
            if own.hit.class == CLASS_FLOOR || own.hit.class == CLASS_BEVEL {
                other.side_width = other.width_of_side(tables, frame);
            }
            let ends = ends(tables, frame, hits, at, &own, &other, step);
            if ends.own == UNKNOWN && ends.other == UNKNOWN {
                unknown |= 1 << which;
            }
            if is_second {
                axis.after = ends;
            } else {
                axis.before = ends;
            }
        }
        if is_second && axis.others() > found.others() {
            found = axis;
        }
        which += 1;
    }
    if found.others() > 0.0 {
        unknown = 0;
    }
    which = 0;
    while unknown != 0 {
        let is_second = which & 1 == 1;
        if !is_second {
            axis = Division {
                first: which,
                ..WHOLE
            };
        }
        if unknown & 1 == 1 {
            let share = stairs::share(frame, hits, at, step_of(which));
            let ends = Ends::meeting(0.5 - share);
            if is_second {
                axis.after = ends;
            } else {
                axis.before = ends;
            }
            if axis.others() > found.others() {
                found = axis;
            }
        }
        unknown >>= 1;
        which += 1;
    }
    found
}

/// Returns the way to neighbour 0 to 3, which are to the left and right, above and below.
#[inline]
fn step_of(which: u32) -> IVec2 {
    let sign = if which & 1 == 1 { 1 } else { -1 };
    if which >= 2 {
        IVec2::new(0, sign)
    } else {
        IVec2::new(sign, 0)
    }
}

#[inline]
fn as_vec(step: IVec2) -> Vec2 {
    Vec2::new(step.x as Real, step.y as Real)
}

/// Returns the change of the ray along `step`.
#[inline]
fn ray_step(frame: &Frame, step: IVec2) -> Vec3 {
    let step = as_vec(step);
    vec3(frame.ray_right) * step.x + vec3(frame.ray_down) * step.y
}

impl Division {
    /// Returns the shares of the neighbours, and of what lies between.
    #[inline]
    pub fn shares(&self) -> Shares {
        let (before, after) = (self.before.beyond(), self.after.beyond());
        let [first, second] = self.between();
        Shares {
            is_down: self.first != 0,
            before,
            after,
            between: div(first + second, max(1.0 - before - after, 1e-3)),
        }
    }

    /// Returns the shares of what lies between it and the neighbours before and after it and that none of them
    /// shows, 0…½.
    #[inline]
    pub fn between(&self) -> [Real; 2] {
        [self.before.between(), self.after.between()]
    }

    /// Returns the share that is not its own. Added up each time: kept, it would take a register.
    #[inline]
    fn others(&self) -> Real {
        let [before, after] = self.between();
        self.before.beyond() + self.after.beyond() + before + after
    }
}

#[cfg(test)]
#[allow(clippy::disallowed_methods)] // Never compiled for a device.
mod tests;
