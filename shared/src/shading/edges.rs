//! Smooth edges: which shares of a pixel belong to its neighbours, and to a side between them
//! that none of them shows.
//!
//! The surfaces that two neighbours hit end somewhere between the centres of their pixels: at the
//! [edge](crate::edge) that one of them knows; else where their tangent planes meet, unless they are one
//! surface that curves; else, if one hides the other, where the nearer one turns away from the eye. On a side, what is known of its edge
//! at the cap tells where its bevel or its wall ends, too; and on a cap, where the side below its edge
//! ends.
//!
//! A pixel is divided along one axis, that along which less of it is its own: an edge that
//! crosses both meets the other one at a flatter angle.

pub(super) mod pixel;

use super::Tables;
use super::material::finish_of;
use crate::arithmetic::{abs, clamp, div, kept3, max, min, normalize_or, sqrt};
use crate::gbuffer::{Hits, MeshFrame, Sample};
use crate::layout::{Frame, vec3};
use crate::normals::{CLASS_CAP, CLASS_FLOOR};
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
    /// Share of sides that no pixel shows, 0…1.
    pub between: Real,
    /// The wider one of them, if that is not 0.
    side: Between,
}

/// A side between a pixel and a neighbour.
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
}

/// Where there is no edge before the other centre.
const NONE: Ends = Ends {
    own: 1.0,
    other: 1.0,
};
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
                let is_at_end = if is_even(class) {
                    end <= 1.0
                } else {
                    begin < 0.0
                };
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
    // Where it is not known, between the pixels.
    Ends::meeting(if abs(end - 0.5) <= 0.5 { end } else { 0.5 })
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
        side: Between {
            which: 0,
            ends: NONE,
        },
    };
    let mut found = nothing;
    let mut axis = nothing;
    let mut most = 0.0;
    let mut widest = 0.0;
    let mut which = 0;
    while which < 4 {
        let is_second = which & 1 == 1;
        let is_down = which >= 2;
        let step = step_of(which);
        if !is_second {
            axis = Division { is_down, ..nothing };
            widest = 0.0;
        }
        let next = at + step;
        let size = IVec2::new(frame.size[0] as i32, frame.size[1] as i32);
        if next.x >= 0 && next.y >= 0 && next.x < size.x && next.y < size.y {
            let mut other = Pixel::new(frame, hits, next);
            if own.hit.class == CLASS_FLOOR {
                other.side_width = other.width_of_side(tables, frame);
            }
            let ends = ends(tables, frame, hits, at, &own, &other, step);
            let share = max(0.5 - ends.other, 0.0);
            if is_second {
                axis.after = share;
            } else {
                axis.before = share;
            }
            let width = max(0.5 - ends.own, 0.0) - share;
            axis.between += width;
            if width > widest {
                widest = width;
                axis.side = Between { which, ends };
            }
        }
        let others = axis.before + axis.after + axis.between;
        if is_second && others > most {
            most = others;
            found = axis;
        }
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

/// Returns the side that `division` has found in pixel (`x`, `y`), between the cap and the floor
/// of two pixels: the direction towards its middle, and what is there.
#[inline]
pub fn side<T: Tables + ?Sized, H: Hits + ?Sized>(
    tables: &T,
    frame: &Frame,
    hits: &H,
    x: u32,
    y: u32,
    division: &Division,
) -> (Vec3, Sample) {
    let Between { which, ends } = division.side;
    let step = step_of(which);
    let at = IVec2::new(x as i32, y as i32);
    let own = Pixel::new(frame, hits, at);
    let other = Pixel::new(frame, hits, at + step);
    let along = ray_step(frame, step);
    let (inverse, slope) = own.inverse(along);
    let (other_inverse, other_slope) = other.inverse(along);
    let first = max(inverse + slope * ends.own, 0.5 * inverse);
    let last = max(
        other_inverse - other_slope * (1.0 - ends.other),
        0.5 * other_inverse,
    );
    let depth = 0.5 * (div(1.0, first) + div(1.0, last));
    let ray = own.ray + along * (0.5 * (ends.own + ends.other));
    let length = sqrt(ray.dot(ray));
    let even = if own.hit.class == CLASS_CAP {
        own
    } else {
        other
    };
    let smooth = even.hit.normal;
    let upright = even.outward(frame);
    let finish = tables.finish(finish_of(&even.hit));
    let growth = growth(tables, finish, &even.hit, upright);
    let lean = div(growth, max(finish.depth, 1e-12));
    let normal = normalize_or(kept3(upright + smooth * lean), upright);
    let mesh = MeshFrame {
        normal: smooth,
        along_u: even.hit.tangent,
        is_mirrored: even.hit.is_mirrored,
    };
    let outline = smooth.cross(upright);
    let is_along_v = abs(outline.dot(mesh.along_u)) < abs(outline.dot(mesh.along_v()));
    let floor_openness = min(own.hit.openness, other.hit.openness);
    let hit = Sample {
        class: finish.side,
        t: depth * length,
        depth_fraction: 0.5,
        normal,
        // A wall sees half of what its foot does, and the floor's half.
        openness: 0.25 + 0.25 * floor_openness,
        ..even.hit
    }
    .along_outline(&mesh, outline, is_along_v);
    (ray * div(1.0, length), hit)
}

impl Division {
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
