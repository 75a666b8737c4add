//! The accurate tier's search (section 6): a ray through curved prisms.
//!
//! A ray enters the shell through the smooth surface from outside, through a side at
//! which the surface ends, or at the eye if that lies in the shell. [`search`] finds
//! the entry in one prism and follows the ray from there, from prism to prism, until it
//! hits something or leaves the shell. So each triangle handles the rays that enter
//! through it, wherever they end, and no ray is followed twice.
//!
//! The march runs along pieces of parabolas in (u, v, δ), while the fast tier has one
//! parabola. Newton's method makes each piece exact to second order at its start; it
//! ends before the third order exceeds [`Field::tolerance`].

//!
//! `entry` finds where a ray enters, `traversal` follows it from there, and `step`
//! decides how far the second order is exact enough for both.

mod entry;
mod field;
mod step;
mod traversal;

pub use field::{Field, Found, PrismList};

use crate::arithmetic::max;
use crate::layout::vec3;
use crate::march::{END_MISS, March};
use crate::prism::{Prism, is_near};
use crate::shape_map::Texels;
use crate::{Vec2, Vec3};
use entry::{Start, hull_of};
use step::{ROUNDS, THRESHOLD, Traveller};

/// Maximum number of times that a ray enters through one prism.
const ENTRIES: u32 = 3;

/// Searches for the first hit on the ray from `eye` along the unit vector `direction`
/// that enters the shell through prism `home`.
#[inline]
pub fn search<S: PrismList + ?Sized, T: Texels + ?Sized>(
    field: &Field<'_, S, T>,
    home: u32,
    eye: Vec3,
    direction: Vec3,
) -> Found {
    let data = field.prisms.prism(home);
    let origin = eye - vec3(data.anchor);
    let nothing = Found {
        march: March {
            end: END_MISS,
            s: 0.0,
            uv: Vec2::ZERO,
            depth_fraction: 0.0,
            steps: 0,
        },
        prism: home,
        x: Vec3::ZERO,
        prisms: 0,
    };
    let hull = hull_of(data, origin, direction);
    let may_hold_eye = is_near(data, origin);
    if hull.1 <= 0.0 && !may_hold_eye {
        return nothing;
    }
    let mut found = nothing;
    let mut start = Start::new(0.0);
    let mut looks_at_eye = may_hold_eye;
    let mut entries = 0;
    let mut restarts = 0;
    let mut over = false;
    while !over {
        let ray = Traveller::new(home, origin, direction, Vec3::ZERO);
        let entrance = field.seek(ray, data, hull, looks_at_eye, start, restarts);
        looks_at_eye = false;
        if entrance.found {
            // A hit at once is on the cap, but not from inside a column, through an
            // open side or on the way up.
            let state = &entrance.at.state;
            let on_cap = !entrance.in_shell && state.x.z <= THRESHOLD && state.velocity.z > 0.0;
            let (ended, left) = field.follow(entrance.at, entrance.enter, on_cap);
            found = ended;
            // After leaving a valley the ray may enter again.
            start = Start::new(max(left + entrance.enter - hull.0, 0.0));
            entries += 1;
            restarts = 0;
            over = found.march.end != END_MISS || hull.1 <= start.t || entries >= ENTRIES;
        } else {
            found = nothing;
            start = entrance.again;
            restarts += 1;
            over = !entrance.lost;
        }
    }
    found
}

/// Returns whether a ray along the unit vector `direction` leaves the shell without a
/// hit. It starts in the shell, displaced by `offset` in space from the parameters `x`
/// of prism `home`.
#[inline]
pub fn leaves<S: PrismList + ?Sized, T: Texels + ?Sized>(
    field: &Field<'_, S, T>,
    home: u32,
    x: Vec3,
    offset: Vec3,
    direction: Vec3,
) -> bool {
    let prism = Prism::new(field.prisms.prism(home), field.object.depth);
    let origin = prism.point(x) + offset;
    let mut at = Traveller::new(home, origin, direction, x);
    at.go(&prism, 0.0, x, ROUNDS);
    let (found, _) = field.follow(at, 0.0, false);
    found.march.end == END_MISS
}

#[cfg(test)]
#[allow(clippy::disallowed_methods)] // Never compiled for a device.
mod tests;
