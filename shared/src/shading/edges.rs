//! Smooth edges: which shares of a pixel belong to its neighbours, and to a side between them
//! that none of them shows.
//!
//! The surfaces that two neighbours hit end somewhere between the centres of their pixels: at the
//! [edge](crate::edge) that one of them knows; else where their tangent planes meet; else, if one
//! hides the other, where the nearer one turns away from the eye.
//!
//! A pixel is divided along one axis, that along which less of it is its own: an edge that
//! crosses both meets the other one at a flatter angle.

use super::Tables;
use super::material::finish_of;
use crate::arithmetic::{abs, clamp, div, kept, kept3, max, min, normalize_or, sqrt};
use crate::camera::through;
use crate::gbuffer::{Hits, MeshFrame, Sample};
use crate::layout::{Frame, vec3};
use crate::normals::{CLASS_CAP, CLASS_FLOOR, CLASS_MISS};
use crate::{Real, Vec2, Vec3};
use glam::IVec2;

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
    /// Where the neighbour is.
    step: IVec2,
    ends: Ends,
}

/// A pixel with what it hits.
#[derive(Clone, Copy)]
struct Pixel {
    /// Direction of its ray, whose part along the view axis is 1.
    ray: Vec3,
    hit: Sample,
    /// Distance along the view axis.
    depth: Real,
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
/// Place of an edge that is beyond the other centre.
const BEYOND: Real = 2.0;
/// Step in depth that makes an edge, widths of a pixel.
const STEP: Real = 0.3;
/// Steps of a share in its code.
const SHARES: Real = 510.0;
/// Places of the codes of `before` and `after` above the class, and the flag `is_down`.
const BEFORE: u32 = 8;
const AFTER: u32 = 16;
const IS_DOWN: u32 = 1 << 24;

impl Pixel {
    // As the functions of `Hits`.
    #[inline(always)]
    fn new<H: Hits + ?Sized>(frame: &Frame, hits: &H, at: IVec2) -> Pixel {
        let within = |x: i32, size: Real| {
            let last = size as i32 - 1;
            let x = if x < last { x } else { last };
            if x > 0 { x } else { 0 }
        };
        let (x, y) = (within(at.x, frame.size[0]), within(at.y, frame.size[1]));
        let hit = hits.sample(x as u32, y as u32);
        let ray = through(frame, x as Real, y as Real);
        Pixel {
            ray,
            hit,
            depth: max(div(hit.t, sqrt(ray.dot(ray))), 1e-18),
        }
    }

    #[inline]
    fn is_hit(&self) -> bool {
        self.hit.class != CLASS_MISS
    }

    /// Returns the normal's part along the ray, which points against it.
    #[inline]
    fn facing(&self) -> Real {
        min(kept(self.hit.normal.dot(self.ray)), -1e-3)
    }

    /// Returns 1 / distance along the view axis, and its change on the tangent plane where the
    /// ray changes by `along`: both are even on planes.
    #[inline]
    fn inverse(&self, along: Vec3) -> (Real, Real) {
        let inverse = div(1.0, self.depth);
        let rate = div(kept(self.hit.normal.dot(along)), self.facing());
        (inverse, kept(rate * inverse))
    }

    /// Returns how far above the tangent plane that is which `other` hits.
    #[inline]
    fn height_of(&self, other: &Pixel) -> Real {
        let way = kept3(other.ray * other.depth - self.ray * self.depth);
        kept(self.hit.normal.dot(way))
    }

    /// Returns whether the tangent plane leads to what `other` hits, where a pixel is `pixel`
    /// wide at distance 1.
    #[inline]
    fn leads_to(&self, other: &Pixel, pixel: Real) -> bool {
        abs(self.height_of(other)) < STEP * pixel * self.depth * -self.facing()
    }

    /// Returns how far the edge is that the hit knows, pixels along `step`.
    #[inline]
    fn known_end(&self, step: Vec2) -> Real {
        let edge = self.hit.edge;
        let rate = kept(edge.direction.dot(step));
        if self.is_hit() && edge.is_near && edge.distance < rate {
            div(edge.distance, rate)
        } else {
            BEYOND
        }
    }

    /// Returns how far it is to where the surface turns away from the eye, pixels away from
    /// `inner`: the square of the cosine between normal and ray falls evenly.
    #[inline]
    fn horizon(&self, inner: &Pixel) -> Real {
        let square = |pixel: &Pixel| {
            let facing = pixel.facing();
            kept(div(facing * facing, pixel.ray.dot(pixel.ray)))
        };
        let (own, before) = (square(self), square(inner));
        let is_same = inner.hit.class == self.hit.class && inner.hit.finish == self.hit.finish;
        if is_same && before > 2.0 * own {
            div(own, before - own)
        } else {
            BEYOND
        }
    }
}

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
    let known = own.known_end(as_vec(step));
    let known_other = 1.0 - other.known_end(as_vec(-step));
    let mut is_own_nearer = own.is_hit();
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
            // A cap hides what is behind its edge.
            if class == CLASS_CAP && other_class == CLASS_FLOOR && end <= 1.0 {
                begin = max(end, begin);
            } else if class == CLASS_FLOOR && other_class == CLASS_CAP && begin >= 0.0 {
                end = min(end, begin);
            } else if is_even(class) && end <= 1.0 {
                begin = end;
            } else if is_even(other_class) && begin >= 0.0 {
                end = begin;
            } else {
                end = BEYOND;
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
        if (first < 0.0) != (last < 0.0) {
            return Ends::meeting(clamp(div(first, first - last), 0.0, 1.0));
        }
        is_own_nearer = first > 0.0;
    }
    let (nearer, before) = if is_own_nearer {
        (*own, at - step)
    } else {
        (*other, at + step + step)
    };
    let horizon = nearer.horizon(&Pixel::new(frame, hits, before));
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
    let own = Pixel::new(frame, hits, at);
    let nothing = Division {
        is_down: false,
        before: 0.0,
        after: 0.0,
        between: 0.0,
        side: Between {
            step: IVec2::ZERO,
            ends: NONE,
        },
    };
    let mut found = nothing;
    let mut axis = nothing;
    let mut most = 0.0;
    let mut widest = 0.0;
    // Left, right, above and below.
    let mut which = 0;
    while which < 4 {
        let is_second = which & 1 == 1;
        let is_down = which >= 2;
        let sign = if is_second { 1 } else { -1 };
        let step = if is_down {
            IVec2::new(0, sign)
        } else {
            IVec2::new(sign, 0)
        };
        if !is_second {
            axis = Division { is_down, ..nothing };
            widest = 0.0;
        }
        let next = at + step;
        let size = IVec2::new(frame.size[0] as i32, frame.size[1] as i32);
        if next.x >= 0 && next.y >= 0 && next.x < size.x && next.y < size.y {
            let other = Pixel::new(frame, hits, next);
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
                axis.side = Between { step, ends };
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
    let Between { step, ends } = division.side;
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
    let is_own_cap = own.hit.class == CLASS_CAP;
    let cap = if is_own_cap { own } else { other };
    // The outline lies on the cap's plane, and on the picture across the way to it.
    let to_edge = cap.hit.edge.direction;
    let across = vec3(frame.ray_down) * to_edge.x - vec3(frame.ray_right) * to_edge.y;
    let on_cap = across - cap.ray * div(kept(cap.hit.normal.dot(across)), cap.facing());
    let outline = normalize_or(kept3(on_cap), cap.hit.tangent);
    let smooth = cap.hit.normal;
    let upright = normalize_or(kept3(outline.cross(smooth)), smooth);
    // Its front is seen.
    let upright = if kept(upright.dot(ray)) > 0.0 {
        -upright
    } else {
        upright
    };
    let finish = tables.finish(finish_of(&cap.hit));
    let density = tables.facet(finish.first_facet + cap.hit.facet).density[0];
    let lean = div(finish.growth, max(density * finish.depth, 1e-12));
    let normal = normalize_or(kept3(upright + smooth * lean), upright);
    let mesh = MeshFrame {
        normal: smooth,
        along_u: cap.hit.tangent,
        is_mirrored: cap.hit.is_mirrored,
    };
    let is_along_v = abs(outline.dot(mesh.along_u)) < abs(outline.dot(mesh.along_v()));
    let floor_openness = min(own.hit.openness, other.hit.openness);
    let hit = Sample {
        class: finish.side,
        t: depth * length,
        depth_fraction: 0.5,
        normal,
        // A wall sees half of what its foot does, and the floor's half.
        openness: 0.25 + 0.25 * floor_openness,
        ..cap.hit
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
