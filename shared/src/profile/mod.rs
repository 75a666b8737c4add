//! How the pattern grows with the depth: its radius r(δ). Only this folder knows
//! how r(δ) follows from bevel and chamfer.
//!
//! Every profile grows inside the same box (section 2): r is e at the cap, does not
//! fall with δ, and is e + b c from δ = c on. A profile is one file that implements
//! [`Growth`], one line in `Profile::ask`, and one line in the list of
//! [`techniques`](crate::techniques), which names it in scenes.

pub mod rounded;
pub mod stepped;
pub mod straight;

use crate::Real;
use crate::arithmetic::{div, max};
use crate::layout::Object;
use straight::Straight;

/// The shape of r(δ) between the cap and δ = c.
pub trait Growth {
    /// Its number in [`Object::profile`]: 0, 1, …
    const NUMBER: u32;

    /// Returns r(δ), texels.
    fn radius(profile: &Profile, depth_fraction: Real) -> Real;

    /// Returns dr/dδ where r grows, texels; [`STEEP`] if r jumps there.
    fn slope(profile: &Profile, depth_fraction: Real) -> Real;

    /// Returns the smallest δ at which a point `distance` texels from the pattern is
    /// solid; 1 where it never is.
    fn depth_of(profile: &Profile, distance: Real) -> Real;

    /// Returns a distance to the solid, texels, of a point `distance` texels from the
    /// pattern: not positive inside, positive outside.
    ///
    /// It must change by at most 1 per texel of `distance` and by at most b per unit of
    /// δ, and must not grow with δ. Replace the default if r is steeper than b anywhere:
    /// the march would step over the solid.
    #[inline]
    fn gap(profile: &Profile, distance: Real, depth_fraction: Real) -> Real {
        distance - Self::radius(profile, depth_fraction)
    }

    /// Returns whether a point on the side of the solid is on its growing part, which
    /// has the colour of bevels, and not on an upright wall.
    #[inline]
    fn is_growing(profile: &Profile, _distance: Real, depth_fraction: Real) -> bool {
        depth_fraction < profile.chamfer
    }
}

/// Slope that stands for an infinite one, texels: a side with this slope faces the way
/// that the surface faces.
pub const STEEP: Real = 1e6;

/// Number of objects with [layers](crate::stack), each of which has a profile of its own.
pub const LAYERED: u32 = u32::MAX;

/// Returns `x` as the bits of an f32.
#[inline]
#[allow(clippy::unnecessary_cast)] // Real may be f64.
pub(crate) fn bits(x: Real) -> u32 {
    (x as f32).to_bits()
}

/// Number of the straight profile.
pub const STRAIGHT: u32 = Straight::NUMBER;

/// The profile of an object, in texels of its map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Profile {
    /// [`Growth::NUMBER`] of its shape.
    number: u32,
    /// e, texels.
    extension: Real,
    /// b, texels per unit of δ, ≥ 0.
    bevel: Real,
    /// c, 0…1.
    chamfer: Real,
    /// 1 / b, or 0 without a bevel.
    inverse_bevel: Real,
    /// Number n of its parts, ≥ 1, if it has parts.
    parts: Real,
    /// b c / n, texels.
    part_width: Real,
    /// n / (b c), or 0 without a bevel.
    inverse_part_width: Real,
    /// Whether the radius depends on δ at all.
    pub grows: bool,
}

/// A function of profiles of any shape.
trait Question {
    type Answer;
    fn of<G: Growth>(self, profile: &Profile) -> Self::Answer;
}

impl Profile {
    /// Answers `question` for the profile's shape.
    #[inline]
    fn ask<Q: Question>(&self, question: Q) -> Q::Answer {
        match self.number {
            rounded::Rounded::NUMBER => question.of::<rounded::Rounded>(self),
            stepped::Stepped::NUMBER => question.of::<stepped::Stepped>(self),
            _ => question.of::<Straight>(self),
        }
    }

    /// Returns the profile of the [complete](Object::complete) `object`, from width units to
    /// texels.
    #[inline]
    pub fn new(object: &Object) -> Profile {
        let quotients = &object.quotients;
        Profile {
            number: object.profile,
            extension: object.extension * object.map_size[0],
            bevel: object.bevel * object.map_size[0],
            chamfer: object.chamfer,
            inverse_bevel: quotients.inverse_bevel,
            parts: parts(object),
            part_width: quotients.part_width,
            inverse_part_width: quotients.inverse_part_width,
            // Read from the object, since specialised shaders know it when compiled.
            grows: grows(object),
        }
    }

    /// Number of its [`words`](Profile::words).
    pub const WORDS: usize = 8;

    /// Returns it as words, for records of a [`stack`](crate::stack).
    pub fn words(&self) -> [u32; Profile::WORDS] {
        [
            self.number,
            bits(self.extension),
            bits(self.bevel),
            bits(self.chamfer),
            bits(self.inverse_bevel),
            bits(self.parts),
            bits(self.part_width),
            bits(self.inverse_part_width),
        ]
    }

    /// Returns the profile whose [`words`](Profile::words) `word` reads.
    #[inline]
    pub fn from_words(word: impl Fn(u32) -> u32) -> Profile {
        let number = |i: u32| f32::from_bits(word(i)) as Real;
        let bevel = number(2);
        Profile {
            number: word(0),
            extension: number(1),
            bevel,
            chamfer: number(3),
            inverse_bevel: number(4),
            parts: number(5),
            part_width: number(6),
            inverse_part_width: number(7),
            grows: bevel != 0.0,
        }
    }

    /// Returns the number of its parts, or of the layers of a [`stack`](crate::stack).
    #[inline]
    pub fn parts(&self) -> u32 {
        self.parts as u32
    }

    /// Returns whether it is the straight profile.
    #[inline]
    pub fn is_straight(&self) -> bool {
        self.number == STRAIGHT
    }

    /// Returns the δ over which the radius grows by `texels` at the slope b; 0 without a
    /// bevel.
    #[inline]
    pub fn depth_of_growth(&self, texels: Real) -> Real {
        texels * self.inverse_bevel
    }

    /// Returns the largest radius at any depth, e + b c, texels.
    #[inline]
    pub fn largest_radius(&self) -> Real {
        self.extension + self.bevel * self.chamfer
    }

    /// Returns the most by which the gap changes per unit of δ, texels.
    #[inline]
    pub fn largest_slope(&self) -> Real {
        self.bevel
    }

    /// Returns r(δ), texels.
    #[inline]
    pub fn radius(&self, depth_fraction: Real) -> Real {
        self.ask(Radius { depth_fraction })
    }

    /// Returns dr/dδ where r grows, texels; [`STEEP`] if r jumps there.
    #[inline]
    pub fn slope(&self, depth_fraction: Real) -> Real {
        self.ask(Slope { depth_fraction })
    }

    /// Returns the smallest δ at which a point `distance` texels from the pattern is
    /// solid; 1 where it never is.
    #[inline]
    pub fn depth_of(&self, distance: Real) -> Real {
        self.ask(Depth { distance })
    }

    /// Returns a distance to the solid, see [`Growth::gap`].
    #[inline]
    pub fn gap(&self, distance: Real, depth_fraction: Real) -> Real {
        self.ask(Gap {
            distance,
            depth_fraction,
        })
    }

    /// Returns a distance to the solid of a profile that does not grow.
    #[inline]
    pub fn upright_gap(&self, distance: Real) -> Real {
        distance - self.extension
    }

    /// Returns whether a point on the side of the solid is on its growing part.
    /// `distance` computes the point's distance to the pattern, texels.
    #[inline]
    pub fn is_growing(&self, depth_fraction: Real, distance: impl FnOnce() -> Real) -> bool {
        self.grows
            && self.ask(IsGrowing {
                distance,
                depth_fraction,
            })
    }
}

/// [`Growth::radius`].
struct Radius {
    depth_fraction: Real,
}

impl Question for Radius {
    type Answer = Real;
    #[inline]
    fn of<G: Growth>(self, profile: &Profile) -> Real {
        G::radius(profile, self.depth_fraction)
    }
}

/// [`Growth::slope`].
struct Slope {
    depth_fraction: Real,
}

impl Question for Slope {
    type Answer = Real;
    #[inline]
    fn of<G: Growth>(self, profile: &Profile) -> Real {
        G::slope(profile, self.depth_fraction)
    }
}

/// [`Growth::depth_of`].
struct Depth {
    distance: Real,
}

impl Question for Depth {
    type Answer = Real;
    #[inline]
    fn of<G: Growth>(self, profile: &Profile) -> Real {
        G::depth_of(profile, self.distance)
    }
}

/// [`Growth::gap`].
struct Gap {
    distance: Real,
    depth_fraction: Real,
}

impl Question for Gap {
    type Answer = Real;
    #[inline]
    fn of<G: Growth>(self, profile: &Profile) -> Real {
        G::gap(profile, self.distance, self.depth_fraction)
    }
}

/// [`Growth::is_growing`].
struct IsGrowing<F> {
    distance: F,
    depth_fraction: Real,
}

impl<F: FnOnce() -> Real> Question for IsGrowing<F> {
    type Answer = bool;
    #[inline]
    fn of<G: Growth>(self, profile: &Profile) -> bool {
        G::is_growing(profile, (self.distance)(), self.depth_fraction)
    }
}

/// Returns the number of parts of the profile of `object`, ≥ 1.
#[inline]
fn parts(object: &Object) -> Real {
    max(object.parts as i32 as Real, 1.0)
}

/// Sets the quotients of `object` that profiles use.
#[inline]
pub(crate) fn set_quotients(object: &mut Object) {
    let bevel = object.bevel * object.map_size[0];
    let part_width = div(bevel * object.chamfer, parts(object));
    let inverse = |x: Real| if x > 1e-12 { div(1.0, x) } else { 0.0 };
    object.quotients.inverse_bevel = inverse(bevel);
    object.quotients.part_width = part_width;
    object.quotients.inverse_part_width = inverse(part_width);
}

/// Returns whether the pattern of `object` grows with the depth.
#[inline]
pub fn grows(object: &Object) -> bool {
    object.bevel != 0.0
}

/// Returns how far the pattern of `object` grows from cap to floor, widths and heights of the map.
pub fn growth(object: &Object) -> [Real; 2] {
    let [width, height] = object.map_size;
    let along_u = object.bevel * object.chamfer;
    [along_u, div(along_u * width, height)]
}

/// Returns δ at which a bevel, a fillet or terraces end; 0 without them.
pub fn rim(object: &Object) -> Real {
    if object.profile != LAYERED && grows(object) {
        object.chamfer
    } else {
        0.0
    }
}

/// Returns whether the pattern of `object` grows along at least half of a side.
pub fn grows_mostly(object: &Object) -> bool {
    object.bevel > 0.0 && object.chamfer >= 0.5
}

/// Lets the compiler know that the pattern of `object` does not grow with the depth.
#[inline]
pub fn know_upright(object: &mut Object) {
    object.bevel = 0.0;
    object.quotients.inverse_bevel = 0.0;
}

/// Lets the compiler know that `object` is a [`stack`](crate::stack) of layers, whose growth is
/// that of its layers.
#[inline]
pub fn know_layered(object: &mut Object) {
    object.profile = LAYERED;
    object.extension = 0.0;
    object.chamfer = 0.0;
    object.quotients.part_width = 0.0;
    object.quotients.inverse_part_width = 0.0;
}

/// Lets the compiler know that the profile of `object` is straight.
#[inline]
pub fn know_straight(object: &mut Object) {
    object.profile = STRAIGHT;
}

#[cfg(test)]
#[allow(clippy::disallowed_methods)] // References are computed by the standard library.
pub(crate) mod tests;
