//! The grooves of a pattern whose parts are smaller than a pixel: what an eye sees of them, and a light
//! reaches.

use super::super::layout::Finish;
use super::super::lights::Incoming;
use super::super::pattern::{gap, growth_across};
use crate::arithmetic::{abs, clamp, div, kept, max, min, normalize_or, sqrt};
use crate::gbuffer::{MeshFrame, Sample};
use crate::layout::vec2;
use crate::openness;
use crate::{FAR, Real, Vec2, Vec3};
use glam::Vec4;

/// Largest xx or yy of a texel of the chart, and twice the largest xy: what is larger is cut off.
pub const MOST: Real = 1.5;
/// Least cosine between the mesh and the direction to the eye or to a light.
pub(super) const LEAST_COSINE: Real = 0.02;
/// Least outline per area, and least share of an area.
const LEAST: Real = 1e-4;
/// How much of what both families hide is hidden twice: all in square holes, nothing around
/// square parts.
const BOTH: Real = 0.75;
/// Mean of |cos| over all directions.
const EVEN: Real = core::f32::consts::FRAC_2_PI;
/// Cosine and sine of how far two directions are from that to the eye, which have the mean square of the
/// cosine of all sides of a round groove that are seen: 2 / 3.
const EVEN_SIDE: (Real, Real) = (0.816_496_6, 0.577_350_3);

/// The pattern around a pixel as two families of straight grooves. Lengths are world units.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pattern {
    /// Unit normal of the outlines of the first family, along growing u and v on the mesh; that of
    /// the second one is across.
    first: Vec2,
    /// How much the families differ: 0 where the outline runs in all directions alike, 1 where
    /// all of it is of the first family.
    order: Real,
    /// Width of the grooves of each family, if those of the other one take no place.
    pub(super) width: Vec2,
}

/// The grooves at a pixel. Two-dimensional vectors lie on the mesh, across those of each family.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grooves {
    /// Unit normal of the mesh, world axes.
    pub(super) normal: Vec3,
    /// Unit direction across the grooves of the first family.
    first: Vec3,
    /// See [`Pattern`].
    order: Real,
    width: Vec2,
    depth: Real,
    /// How far sides of each family grow towards the middle of a groove.
    growth: Vec2,
    /// Width of a groove from side to side.
    gap: Real,
    /// How far a ray may go across grooves of each family, from side to side.
    longest: Vec2,
}

impl Pattern {
    /// What takes the place of a pattern that is not seen.
    pub(super) const NONE: Pattern = Pattern {
        first: Vec2::X,
        order: 0.0,
        width: Vec2::ONE,
    };

    /// Returns that of a texel of the chart, of which `texels` are a world unit along u and v. `order` is
    /// that of the whole pattern, if its families run along u and v.
    #[inline]
    pub(super) fn new(texel: Vec4, texels: Vec2, order: Real) -> Pattern {
        let xx = texel.y * MOST * texels.x;
        let yy = texel.z * MOST * texels.y;
        let xy = (texel.w - 0.5) * MOST * sqrt(texels.x * texels.y);
        // The eigenvectors, of the matrix over its trace.
        let outline = xx + yy;
        let inverse = div(1.0, max(outline, 1e-12));
        let difference = 0.5 * (xx - yy) * inverse;
        let mixed = xy * inverse;
        let half_order = min(sqrt(difference * difference + mixed * mixed), 0.5);
        let cosine = if order == 0.0 {
            clamp(div(difference, max(half_order, 1e-6)), -1.0, 1.0)
        } else if difference < 0.0 {
            -1.0
        } else {
            1.0
        };
        let second = sqrt(max(0.5 - 0.5 * cosine, 0.0));
        let groove = max(1.0 - texel.x, LEAST);
        // Each family has some outline, so that its grooves have a width.
        let width = |share: Real| div(2.0 * groove, max(share, LEAST) * outline + 1e-12);
        Pattern {
            first: Vec2::new(
                sqrt(max(0.5 + 0.5 * cosine, 0.0)),
                if mixed < 0.0 { -second } else { second },
            ),
            order: max(2.0 * half_order, order),
            width: Vec2::new(width(0.5 + half_order), width(0.5 - half_order)),
        }
    }
}

impl Grooves {
    /// Returns those of `pattern` of `finish` on `mesh`, where an object unit is `unit` world units, and
    /// `rate` repeats are one.
    #[inline]
    pub(super) fn new(
        finish: &Finish,
        mesh: &MeshFrame,
        unit: Real,
        rate: Vec2,
        pattern: &Pattern,
    ) -> Grooves {
        let Pattern {
            first,
            order,
            width,
        } = *pattern;
        let way = vec2(finish.chart.way);
        let way = Vec2::new(
            div(way.x, max(rate.x, 1e-12)),
            div(way.y, max(rate.y, 1e-12)),
        );
        Grooves {
            normal: mesh.normal,
            first: mesh.along_u * first.x + mesh.along_v() * first.y,
            order,
            width,
            depth: finish.depth * unit,
            growth: Vec2::new(
                growth_across(finish, rate, first.x),
                growth_across(finish, rate, first.y),
            ),
            gap: max(gap(finish, rate), 1e-12),
            longest: if finish.chart.order == 0.0 {
                Vec2::splat(FAR)
            } else if first.x > 0.5 {
                way
            } else {
                Vec2::new(way.y, way.x)
            },
        }
    }

    /// Returns how far the ray along `direction` goes along the mesh per unit of depth.
    #[inline]
    fn along(&self, direction: Vec3) -> Vec2 {
        let inverse = div(1.0, max(-kept(self.normal.dot(direction)), LEAST_COSINE));
        let second = self.normal.cross(self.first);
        let along = Vec2::new(kept(self.first.dot(direction)), kept(second.dot(direction)));
        along * inverse
    }

    /// Returns how far a ray that goes `along` the mesh per unit of depth is shifted by the depth,
    /// across the grooves of each family.
    #[inline]
    fn shift(&self, along: Vec2) -> Vec2 {
        let even = EVEN * (1.0 - self.order) * sqrt(kept(along.dot(along)));
        let across = |along: Real| (even + self.order * abs(along)) * self.depth;
        Vec2::new(across(along.x), across(along.y))
    }

    /// Returns down to which part of the depth sides of one family reach: they meet there if they lean
    /// enough.
    #[inline]
    pub(super) fn deepest(&self, is_second: bool) -> Real {
        let growth = of_family(self.growth, is_second);
        min(div(self.gap, max(2.0 * growth, 1e-12)), 1.0)
    }

    /// Returns how much of a `shift` across the grooves of each family lies before the opposite foot.
    #[inline]
    fn within(&self, shift: Vec2) -> Vec2 {
        let within =
            |shift: Real, longest: Real, growth: Real| min(shift, max(longest - growth, 0.0));
        Vec2::new(
            within(shift.x, self.longest.x, self.growth.x),
            within(shift.y, self.longest.y, self.growth.y),
        )
    }

    /// Returns the share of a floor that is left where the grooves of either family hide these shares of
    /// it. Some is hidden twice, unless each family hides its own grooves only.
    #[inline]
    pub(super) fn left(&self, first: Real, second: Real) -> Real {
        let [first, second] = [min(first, 1.0), min(second, 1.0)];
        let most = div(self.longest.x, self.width.x) + div(self.longest.y, self.width.y);
        let both = BOTH * clamp(most - 1.0, 0.0, 1.0);
        max(1.0 - first - second + both * first * second, 0.0)
    }

    /// Returns how wide both sides of a groove of each family are, as seen along `direction`.
    #[inline]
    pub(super) fn sides(&self, direction: Vec3) -> Vec2 {
        let shift = self.shift(self.along(direction));
        let width = |shift: Real, growth: Real| growth + max(growth, shift);
        let shift = self.within(shift);
        Vec2::new(width(shift.x, self.growth.x), width(shift.y, self.growth.y))
    }

    /// Returns the share of what is seen of the sides of each family along `direction` that faces away
    /// from the eye: something, if they lean back by more than it looks from the side.
    #[inline]
    pub(super) fn away(&self, direction: Vec3) -> Vec2 {
        let shift = self.shift(self.along(direction));
        let away =
            |shift: Real, growth: Real| div(max(growth - shift, 0.0), max(2.0 * growth, 1e-12));
        Vec2::new(away(shift.x, self.growth.x), away(shift.y, self.growth.y))
    }

    /// Returns the sides of one family that face the eye, which looks along `direction`, or away from
    /// it, at the place `half_way` down.
    #[inline]
    pub(super) fn side(
        &self,
        direction: Vec3,
        is_second: bool,
        is_away: bool,
        mesh: &MeshFrame,
        half_way: &Sample,
        class: u32,
    ) -> Sample {
        let (gap, depth) = (self.gap, self.depth);
        let along = self.along(direction);
        let length = sqrt(kept(along.dot(along)));
        let towards = -along * div(1.0, max(length, 1e-12));
        let faces = if is_second { towards.y } else { towards.x };
        let sign = if faces < 0.0 { -1.0 } else { 1.0 };
        // What runs in all directions faces the eye from both sides.
        let beside = Vec2::new(-towards.y, towards.x);
        let beside = if of_family(beside, is_second) * sign < 0.0 {
            -beside
        } else {
            beside
        };
        let own = sign * self.order;
        let even = (towards * EVEN_SIDE.0 + beside * EVEN_SIDE.1) * (1.0 - self.order);
        let facing = if is_second {
            Vec2::new(even.x, even.y + own)
        } else {
            Vec2::new(even.x + own, even.y)
        };
        let facing = if is_away { -facing } else { facing };
        let second = self.normal.cross(self.first);
        let upright = normalize_or(self.first * facing.x + second * facing.y, self.first);
        let lean = div(of_family(self.growth, is_second), max(depth, 1e-12));
        let normal = normalize_or(upright + self.normal * lean, upright);
        let is_along_v = abs(upright.dot(mesh.along_u)) > abs(upright.dot(mesh.along_v()));
        let deep = depth * self.deepest(is_second);
        let sky = 0.5 - 0.5 * div(deep, sqrt(gap * gap + deep * deep) + gap);
        let side = Sample {
            class,
            normal,
            openness: openness::of_side(class, sky),
            ..*half_way
        };
        side.along_outline(mesh, self.normal.cross(upright), is_along_v)
    }

    /// Returns the share of the sky that the floor sees, 0…1: on average from foot to foot, where the
    /// walls are as far apart as at the cap.
    #[inline]
    pub(super) fn floor_openness(&self) -> Real {
        let open = |width: Real, growth: Real| {
            let near = min(growth, 0.5 * width);
            let far = width - near;
            let square = self.depth * self.depth;
            let slants = sqrt(near * near + square) + sqrt(far * far + square);
            div(width, max(slants, 1e-12))
        };
        open(self.width.x, self.growth.x) * open(self.width.y, self.growth.y)
    }

    /// Returns the share of what is seen of the floor or of the sides of one family along `direction`
    /// that `incoming` light reaches, where shadows are looked up at this distance above surfaces.
    #[inline]
    pub(super) fn lit(
        &self,
        direction: Vec3,
        is_floor: bool,
        is_second: bool,
        incoming: &Incoming,
        lift: Real,
    ) -> Real {
        let eye = self.along(direction);
        let light = self.along(-incoming.direction);
        let (seen, lit) = (self.shift(eye), self.shift(light));
        if is_floor {
            // How much of the shadow lies where the eye does not see: all of it if both look from
            // the same side.
            let lengths = sqrt(kept(eye.dot(eye)) * kept(light.dot(light)));
            let even = clamp(div(kept(eye.dot(light)), max(lengths, 1e-12)), 0.0, 1.0);
            let shallower = max(1.0 - div(lift, max(self.depth, 1e-12)), 0.0);
            let (seen, lit) = (self.within(seen), self.within(lit * shallower));
            let hidden = |eye: Real, light: Real, seen: Real, lit: Real, is_second: bool| {
                let growth = of_family(self.growth, is_second);
                let width = of_family(self.width, is_second);
                let is_same = (eye < 0.0) == (light < 0.0);
                let same = even + self.order * (if is_same { 1.0 } else { 0.0 } - even);
                let foot = div(1.0, max(width - 2.0 * growth, 1e-12));
                let seen = max(seen - growth, 0.0);
                let lit = max(lit - growth, 0.0);
                let apart = seen + lit;
                let both = apart + (max(seen, lit) - apart) * same;
                Vec2::new(seen * foot, both * foot)
            };
            let first = hidden(eye.x, light.x, seen.x, lit.x, false);
            let second = hidden(eye.y, light.y, seen.y, lit.y, true);
            let seen = max(self.left(first.x, second.x), 1e-6);
            min(div(self.left(first.y, second.y), seen), 1.0)
        } else {
            let (seen, lit) = (of_family(seen, is_second), of_family(lit, is_second));
            let growth = of_family(self.growth, is_second);
            let deepest = self.deepest(is_second);
            // Shadows are looked up above the side: this far along the mesh, and by this part of the
            // depth, from which on there are none.
            let slant = sqrt(self.depth * self.depth + growth * growth);
            let scaled = div(lift, max(slant, 1e-12));
            let aside = scaled * self.depth;
            let up = div(scaled * growth, max(self.depth, 1e-12));
            // Down to which part of the depth, in straight grooves and in round ones.
            let deep = |gap: Real, shift: Real| min(div(gap, max(shift + growth, 1e-12)), deepest);
            let reached = deep(max(self.gap - aside + lit * up, 0.0), lit);
            let reached = max(reached, min(up, deepest));
            let straight = min(div(reached, deep(self.gap, seen)), 1.0);
            let lit = lit * max(1.0 - up, 0.0);
            let round = div(2.0 * self.gap + seen, 2.0 * self.gap + seen + lit);
            round + (straight - round) * self.order
        }
    }
}

/// Returns what `of_both` says of one family.
#[inline]
pub(super) fn of_family(of_both: Vec2, is_second: bool) -> Real {
    if is_second { of_both.y } else { of_both.x }
}
