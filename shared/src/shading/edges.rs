//! Smooth edges: which shares of a pixel belong to its neighbours, and to sides and floor between them
//! that none of them shows.
//!
//! The surfaces that two neighbours hit end somewhere between the centres of their pixels: at the
//! [edge](crate::edge) that one of them knows; else where their tangent planes meet, unless they are one
//! surface that curves; else, if one hides the other, where the nearer one turns away from the eye; else
//! where their stairs on the picture tell. On a side, what is known of its edge at the cap tells where
//! its bevel or its wall ends, too; and on a cap, where the side below its edge ends.
//!
//! A pixel is divided along one axis, that along which less of it is its own: an edge that
//! crosses both meets the other one at a flatter angle.

pub(super) mod pixel;
mod stairs;

use super::Tables;
use super::material::finish_of;
use crate::arithmetic::{abs, clamp, div, kept, kept3, max, min, normalize_or, sqrt};
use crate::gbuffer::{Hits, MeshFrame, Sample};
use crate::layout::{Frame, vec3};
use crate::normals::{CLASS_BEVEL, CLASS_CAP, CLASS_FLOOR};
use crate::openness::hidden;
use crate::{Real, Vec2, Vec3};
use glam::IVec2;
use pixel::{Pixel, STEP, growth};

/// How a pixel is divided; the rest is its own.
#[derive(Clone, Copy, Debug)]
pub struct Division {
    /// Whether its neighbours are those above and below, rather than to the left and right.
    pub is_down: bool,
    /// Share of the neighbour to the left or above, 0…½.
    pub before: Real,
    /// Share of the one to the right or below, 0…½.
    pub after: Real,
    /// Share of sides and floor that no pixel shows, 0…1.
    pub between: Real,
    /// The wider one of those places, if that is not 0.
    groove: Between,
}

/// What lies between a pixel and a neighbour.
#[derive(Clone, Copy, Debug)]
struct Between {
    /// Which neighbour: see [`step_of`].
    which: u32,
    ends: Ends,
}

/// Where two surfaces end, pixels from the centre of one towards that of the other.
#[derive(Clone, Copy, Debug)]
struct Ends {
    /// End of the one.
    own: Real,
    /// Begin of the other, no less than that.
    other: Real,
}

impl Ends {
    /// Returns the ends of surfaces that meet.
    #[inline]
    fn meeting(at: Real) -> Ends {
        Ends { own: at, other: at }
    }

    /// Returns the share of what lies between in the pixel of the one.
    #[inline]
    fn between(&self) -> Real {
        max(0.5 - self.own, 0.0) - max(0.5 - self.other, 0.0)
    }
}

/// Where there is no edge before the other centre.
const NONE: Ends = Ends {
    own: 1.0,
    other: 1.0,
};
/// Place of an edge that no hit knows, between the pixels.
const UNKNOWN: Real = 0.5;
/// Least cosine between a cap and the direction to the eye, of what lies below it.
const LEAST_FACING: Real = 0.02;
/// Steps of a share in its code.
const SHARES: Real = 510.0;
/// Places of the codes of `before` and `after` above the class, and the flag `is_down`.
const BEFORE: u32 = 8;
const AFTER: u32 = 16;
const IS_DOWN: u32 = 1 << 24;

/// Returns whether `other` may be where the carving goes on beyond the edge of `even`, a cap or a
/// floor: below the one, above the other, and by no more than its depth.
#[inline]
fn goes_on<T: Tables + ?Sized>(tables: &T, even: &Pixel, other: &Pixel, pixel: Real) -> bool {
    let depth = tables.finish(finish_of(&even.hit)).depth * even.hit.unit;
    let height = even.height_of(other);
    let beyond = if even.hit.class == CLASS_CAP {
        -height
    } else {
        height
    };
    let slack = STEP * depth + pixel * even.depth;
    beyond > -slack && beyond < depth + slack
}

/// Returns where the surfaces of `own`, pixel `at`, and of `other`, its neighbour along `step`,
/// end.
#[inline]
fn ends<T: Tables + ?Sized, H: Hits + ?Sized>(
    tables: &T,
    frame: &Frame,
    hits: &H,
    at: IVec2,
    own: &Pixel,
    other: &Pixel,
    step: IVec2,
) -> Ends {
    let along = ray_step(frame, step);
    if !own.is_hit() && !other.is_hit() {
        return NONE;
    }
    let known = own.known_end(tables, as_vec(step));
    let known_other = 1.0 - other.known_end(tables, as_vec(-step));
    let mut is_own_nearer = own.is_hit();
    // Where their tangent planes meet, if they do.
    let (mut is_meeting, mut meeting) = (false, 0.0);
    if own.is_hit() && other.is_hit() {
        let (class, other_class) = (own.hit.class, other.hit.class);
        let pixel = sqrt(along.dot(along));
        let is_even = |class: u32| class == CLASS_CAP || class == CLASS_FLOOR;
        let is_one = own.hit.finish == other.hit.finish && class != other_class;
        // By value: a GPU does not choose between references.
        let (even, beyond) = if is_even(class) {
            (*own, *other)
        } else {
            (*other, *own)
        };
        if is_one && is_even(even.hit.class) && goes_on(tables, &even, &beyond, pixel) {
            let (mut end, mut begin) = (known, known_other);
            if is_even(beyond.hit.class) {
                let is_own_cap = class == CLASS_CAP;
                let width = if is_own_cap {
                    own.along(as_vec(step), own.side_width)
                } else {
                    other.along(as_vec(-step), other.side_width)
                };
                // A cap and the side below its edge hide what is behind them. Where they would hide the
                // floor that is seen, the outline is not straight.
                if is_own_cap {
                    let side = if end + width <= 1.0 { width } else { 0.0 };
                    begin = if end <= 1.0 {
                        max(end + side, begin)
                    } else {
                        begin
                    };
                    end = min(end, begin);
                } else {
                    let side = if begin >= width { width } else { 0.0 };
                    end = if begin >= 0.0 {
                        min(begin - side, end)
                    } else {
                        end
                    };
                    begin = max(end, begin);
                }
            } else {
                // They meet where the one that is even knows its edge, else where the side does.
                let is_own_even = is_even(class);
                let (is_known, is_other_known) = (end <= 1.0, begin >= 0.0);
                let is_at_end = if is_own_even {
                    is_known
                } else {
                    !is_other_known
                };
                let to_side = if is_own_even { 1.0 } else { -1.0 };
                let away = kept(beyond.hit.edge.direction.dot(as_vec(step))) * to_side;
                let is_opposite = even.hit.class == CLASS_CAP && away >= 0.0;
                // Between a cap and the side below the opposite one is floor, unless the cap hides it.
                if is_opposite && is_known && is_other_known && end < begin {
                    return Ends {
                        own: end,
                        other: begin,
                    };
                }
                if is_at_end {
                    begin = end;
                } else {
                    end = begin;
                }
            }
            if end <= 1.0 && begin >= 0.0 {
                return Ends {
                    own: end,
                    other: begin,
                };
            }
        }
        if own.leads_to(other, pixel) && other.leads_to(own, pixel) {
            return NONE;
        }
        let (inverse, slope) = own.inverse(along);
        let (other_inverse, other_slope) = other.inverse(along);
        let first = inverse - (other_inverse - other_slope);
        let last = inverse + slope - other_inverse;
        is_meeting = (first < 0.0) != (last < 0.0);
        if is_meeting {
            meeting = clamp(div(first, first - last), 0.0, 1.0);
            is_own_nearer = own.depth < other.depth;
        } else {
            is_own_nearer = first > 0.0;
        }
    }
    let (nearer, farther, before) = if is_own_nearer {
        (*own, *other, at - step)
    } else {
        (*other, *own, at + step + step)
    };
    let before = Pixel::new(frame, hits, before);
    if is_meeting {
        return if nearer.curves(&before, &farther) {
            NONE
        } else {
            Ends::meeting(meeting)
        };
    }
    let horizon = nearer.horizon(&before);
    let end = if is_own_nearer {
        min(known, horizon)
    } else {
        max(known_other, 1.0 - horizon)
    };
    Ends::meeting(if abs(end - 0.5) <= 0.5 { end } else { UNKNOWN })
}

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
    let mut own = Pixel::new(frame, hits, at);
    // Here, and not where the neighbours are compared: there it would take registers.
    own.side_width = own.width_of_side(tables, frame);
    let nothing = Division {
        is_down: false,
        before: 0.0,
        after: 0.0,
        between: 0.0,
        groove: Between {
            which: 0,
            ends: NONE,
        },
    };
    let size = IVec2::new(frame.size[0] as i32, frame.size[1] as i32);
    // A bit for each neighbour.
    let mut unknown = 0;
    let mut found = nothing;
    let mut axis = nothing;
    let mut which = 0;
    while which < 4 {
        let is_second = which & 1 == 1;
        let is_down = which >= 2;
        let step = step_of(which);
        if !is_second {
            axis = Division { is_down, ..nothing };
        }
        let next = at + step;
        if next.x >= 0 && next.y >= 0 && next.x < size.x && next.y < size.y {
            let mut other = Pixel::new(frame, hits, next);
            if own.hit.class == CLASS_FLOOR {
                other.side_width = other.width_of_side(tables, frame);
            }
            let ends = ends(tables, frame, hits, at, &own, &other, step);
            if ends.own == UNKNOWN && ends.other == UNKNOWN {
                unknown |= 1 << which;
            }
            let share = max(0.5 - ends.other, 0.0);
            if is_second {
                axis.after = share;
            } else {
                axis.before = share;
            }
            axis.between += ends.between();
            if ends.between() > axis.groove.ends.between() {
                axis.groove = Between { which, ends };
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
                is_down: which >= 2,
                ..nothing
            };
        }
        if unknown & 1 == 1 {
            let share = stairs::share(hits, size, at, step_of(which));
            if is_second {
                axis.after = share;
            } else {
                axis.before = share;
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

/// Returns what `division` has found between pixel (`x`, `y`) and a neighbour, one of which hits a cap:
/// the floor or a side. It is the share of what lies between, 0…1, the direction towards its middle, and what
/// is there.
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
    let is_own = own.hit.class == CLASS_CAP;
    let (cap, beyond) = if is_own { (own, other) } else { (other, own) };
    let finish = tables.finish(finish_of(&cap.hit));
    let depth = finish.depth * cap.hit.unit;
    let smooth = cap.hit.normal;
    let upright = cap.outward(frame);
    // Where the ray goes through the plane of the cap.
    let along = ray_step(frame, step);
    let (inverse, slope) = cap.inverse(along);
    let first = if is_own { 0.0 } else { 1.0 };
    let on_cap = |place: Real| {
        let inverse = max(inverse + slope * (place - first), 0.5 * inverse);
        (own.ray + along * place) * div(1.0, inverse)
    };
    let middle = on_cap(0.5 * (ends.own + ends.other));
    let length = sqrt(middle.dot(middle));
    let direction = middle * div(1.0, length);
    let depth_fraction = if is_floor { 1.0 } else { 0.5 };
    let facing = max(-kept(smooth.dot(direction)), LEAST_FACING);
    let t = length + div(depth_fraction * depth, facing);
    let (mut floor, mut floor_openness) = (0.0, beyond.hit.openness);
    if beyond.hit.class != CLASS_FLOOR {
        // Of the opposite side, all that is not hidden has been hit.
        let towards = as_vec(if is_own { step } else { -step });
        let side = cap.along(towards, cap.width_of_side(tables, frame));
        floor = max(1.0 - div(side, max(ends.other - ends.own, 1e-6)), 0.0);
        let width = abs(kept(upright.dot(on_cap(ends.other) - on_cap(ends.own))));
        floor_openness = 1.0 - 2.0 * hidden(0.5 * width, depth);
    }
    if is_floor {
        let hit = Sample {
            class: CLASS_FLOOR,
            t,
            depth_fraction,
            openness: floor_openness,
            ..cap.hit
        };
        return (floor, direction, hit);
    }
    let growth = growth(tables, finish, &cap.hit, upright);
    let lean = div(growth, max(finish.depth, 1e-12));
    let normal = normalize_or(kept3(upright + smooth * lean), upright);
    let mesh = MeshFrame {
        normal: smooth,
        along_u: cap.hit.tangent,
        is_mirrored: cap.hit.is_mirrored,
    };
    let outline = smooth.cross(upright);
    let is_along_v = abs(outline.dot(mesh.along_u)) < abs(outline.dot(mesh.along_v()));
    // As in `openness`: of the sky, a side sees half of what the floor does.
    let ground = if finish.side == CLASS_BEVEL {
        0.5
    } else {
        0.25
    };
    let hit = Sample {
        class: finish.side,
        t,
        depth_fraction,
        normal,
        openness: ground + 0.25 * floor_openness,
        ..cap.hit
    }
    .along_outline(&mesh, outline, is_along_v);
    (1.0 - floor, direction, hit)
}

impl Division {
    /// Returns the share that is not its own. Added up each time: kept, it would take a register.
    #[inline]
    fn others(&self) -> Real {
        self.before + self.after + self.between
    }

    /// Returns the class word of a pixel: the class, and the shares of the neighbours.
    #[inline]
    pub fn code(&self, class: u32) -> u32 {
        let Division {
            is_down,
            before,
            after,
            ..
        } = *self;
        let shares = Shares {
            is_down,
            before,
            after,
        };
        shares.code(class)
    }
}

/// The shares of neighbours in the class word of a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shares {
    /// See [`Division::is_down`].
    pub is_down: bool,
    /// See [`Division::before`].
    pub before: Real,
    /// See [`Division::after`].
    pub after: Real,
}

impl Shares {
    /// Returns the class word of a pixel with these shares.
    #[inline]
    pub fn code(&self, class: u32) -> u32 {
        let share = |x: Real| (clamp(x, 0.0, 0.5) * SHARES + 0.5) as u32;
        let axis = if self.is_down { IS_DOWN } else { 0 };
        class | share(self.before) << BEFORE | share(self.after) << AFTER | axis
    }
}

/// Returns the class in a class word, and the shares of the neighbours.
#[inline]
pub fn from_code(word: u32) -> (u32, Shares) {
    const SHARE: Real = 1.0 / 510.0;
    let share = |place: u32| ((word >> place) & 0xff) as i32 as Real * SHARE;
    let shares = Shares {
        is_down: word & IS_DOWN != 0,
        before: share(BEFORE),
        after: share(AFTER),
    };
    (word & 0xff, shares)
}

#[cfg(test)]
#[allow(clippy::disallowed_methods)] // Never compiled for a device.
mod tests;
