//! The curved prism over a triangle (section 6), which the accurate tier traces.
//!
//! A point of the prism is F(w1, w2, δ) = S(w) − S_z δ N(w), with S and N of degree two
//! in the barycentrics of the second and third corner. Along a ray the parameters
//! x = (w1, w2, δ) follow one curve while det ∂F/∂x keeps its sign. Newton's method
//! gives x at a point of the ray; the first and second derivatives of F give x′ and x″.

use crate::arithmetic::{abs, div, kept3, max, normalize_or};
use crate::layout::{NO_NEIGHBOUR, PrismData, vec2, vec3};
use crate::{Real, Vec2, Vec3};

/// A polynomial of degree two in w1 and w2, with values in space.
///
/// Aligned as naga requires of structs with vectors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(align(16))]
struct Quadratic {
    constant: Vec3,
    first: Vec3,
    second: Vec3,
    first_first: Vec3,
    first_second: Vec3,
    second_second: Vec3,
}

impl Quadratic {
    #[inline]
    fn at(&self, w1: Real, w2: Real) -> Vec3 {
        self.constant
            + (self.first + self.first_first * w1 + self.first_second * w2) * w1
            + (self.second + self.second_second * w2) * w2
    }

    /// Derivative with respect to w1.
    #[inline]
    fn along_first(&self, w1: Real, w2: Real) -> Vec3 {
        self.first + self.first_first * (2.0 * w1) + self.first_second * w2
    }

    /// Derivative with respect to w2.
    #[inline]
    fn along_second(&self, w1: Real, w2: Real) -> Vec3 {
        self.second + self.second_second * (2.0 * w2) + self.first_second * w1
    }

    /// Returns the second derivative in the directions `p` and `q`, of which it uses the
    /// weights; it is constant.
    #[inline]
    fn bend(&self, p: Vec3, q: Vec3) -> Vec3 {
        self.first_first * (2.0 * p.x * q.x)
            + self.first_second * (p.x * q.y + p.y * q.x)
            + self.second_second * (2.0 * p.y * q.y)
    }
}

/// The prism over one triangle, between the cap and the floor.
///
/// Positions are relative to the triangle's first corner, to save digits.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(16))]
pub struct Prism {
    /// The triangle's first corner, object units.
    pub anchor: Vec3,
    surface: Quadratic,
    normal: Quadratic,
    corner_normals: [Vec3; 3],
    depth: Real,
    least_determinant: Real,
    uv: Vec2,
    uv_first: Vec2,
    uv_second: Vec2,
}

/// The motion of a ray in the parameters of a prism, by the distance t.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(16))]
pub struct State {
    /// (w1, w2, δ).
    pub x: Vec3,
    /// The derivative of x by t, 1 / object units.
    pub velocity: Vec3,
    /// The second derivative of x by t.
    pub acceleration: Vec3,
    /// Error of x to second order: a displacement of this many object units per cube of
    /// the time.
    pub third_order: Real,
}

/// ∂F/∂x and its inverse.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(16))]
pub struct Jacobian {
    /// ∂F/∂w1, object units.
    pub along_first: Vec3,
    /// ∂F/∂w2, object units.
    pub along_second: Vec3,
    /// ∂F/∂δ = −S_z N, object units.
    pub along_depth: Vec3,
    /// Gradient of w1 in space, 1 / object units.
    pub gradient_first: Vec3,
    /// Gradient of w2 in space, 1 / object units.
    pub gradient_second: Vec3,
    /// Gradient of δ in space, 1 / object units.
    pub gradient_depth: Vec3,
    /// Whether the map can be inverted here, with the facet's orientation.
    pub regular: bool,
}

/// The Jacobian of a folded prism.
const NOT_REGULAR: Jacobian = Jacobian {
    along_first: Vec3::ZERO,
    along_second: Vec3::ZERO,
    along_depth: Vec3::ZERO,
    gradient_first: Vec3::ZERO,
    gradient_second: Vec3::ZERO,
    gradient_depth: Vec3::ZERO,
    regular: false,
};

impl Jacobian {
    /// Returns the change of (w1, w2, δ) for a `displacement` of F, to first order.
    #[inline]
    pub fn solve(&self, displacement: Vec3) -> Vec3 {
        Vec3::new(
            self.gradient_first.dot(displacement),
            self.gradient_second.dot(displacement),
            self.gradient_depth.dot(displacement),
        )
    }
}

/// The surface at a hit, for shading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrismFrame {
    /// Unit normal of the smooth surface, pointing out: the corners', interpolated.
    pub normal: Vec3,
    /// ∂F/∂x there, and the gradients of w and δ.
    pub jacobian: Jacobian,
    /// ∇u in space, repeats per object unit.
    pub gradient_u: Vec3,
    /// ∇v in space, repeats per object unit.
    pub gradient_v: Vec3,
}

impl Prism {
    /// Returns the prism of `data`, `depth` = S_z > 0 object units deep.
    #[inline]
    pub fn new(data: &PrismData, depth: Real) -> Prism {
        let [first, second, first_first, first_second, second_second] = &data.surface;
        let [
            n,
            n_first,
            n_second,
            n_first_first,
            n_first_second,
            n_second_second,
        ] = &data.normal;
        Prism {
            anchor: vec3(data.anchor),
            surface: Quadratic {
                constant: Vec3::ZERO,
                first: vec3(*first),
                second: vec3(*second),
                first_first: vec3(*first_first),
                first_second: vec3(*first_second),
                second_second: vec3(*second_second),
            },
            normal: Quadratic {
                constant: vec3(*n),
                first: vec3(*n_first),
                second: vec3(*n_second),
                first_first: vec3(*n_first_first),
                first_second: vec3(*n_first_second),
                second_second: vec3(*n_second_second),
            },
            corner_normals: [
                vec3(data.corner_normals[0]),
                vec3(data.corner_normals[1]),
                vec3(data.corner_normals[2]),
            ],
            depth,
            least_determinant: data.least_determinant,
            uv: vec2(data.uv[0]),
            uv_first: vec2(data.uv[1]),
            uv_second: vec2(data.uv[2]),
        }
    }

    /// S(w): the smooth surface, object units, relative to the anchor.
    #[inline]
    pub fn surface(&self, w1: Real, w2: Real) -> Vec3 {
        self.surface.at(w1, w2)
    }

    /// N(w): the direction out of the surface, of about unit length.
    #[inline]
    pub fn normal(&self, w1: Real, w2: Real) -> Vec3 {
        self.normal.at(w1, w2)
    }

    /// F(x): the point at (w1, w2, δ), object units, relative to the anchor.
    #[inline]
    pub fn point(&self, x: Vec3) -> Vec3 {
        self.surface.at(x.x, x.y) - self.normal.at(x.x, x.y) * (self.depth * x.z)
    }

    /// Texture coordinates at (w1, w2), repeats.
    #[inline]
    pub fn uv(&self, w1: Real, w2: Real) -> Vec2 {
        self.uv + self.uv_first * w1 + self.uv_second * w2
    }

    /// Returns the change of the texture coordinates for a change of x, repeats.
    #[inline]
    pub fn uv_change(&self, change: Vec3) -> Vec2 {
        self.uv_first * change.x + self.uv_second * change.y
    }

    /// ∂F/∂x.
    #[inline]
    pub fn jacobian(&self, x: Vec3) -> Jacobian {
        let deep = self.depth * x.z;
        let a = self.surface.along_first(x.x, x.y) - self.normal.along_first(x.x, x.y) * deep;
        let b = self.surface.along_second(x.x, x.y) - self.normal.along_second(x.x, x.y) * deep;
        let c = self.normal.at(x.x, x.y) * -self.depth;
        let (a, b, c) = (kept3(a), kept3(b), kept3(c));
        let ab = a.cross(b);
        // δ grows inward: the determinant is negative unless the prism is folded.
        let determinant = -ab.dot(c);
        let regular = determinant > self.least_determinant;
        let inverse = if regular { -div(1.0, determinant) } else { 0.0 };
        Jacobian {
            along_first: a,
            along_second: b,
            along_depth: c,
            gradient_first: kept3(b.cross(c) * inverse),
            gradient_second: kept3(c.cross(a) * inverse),
            gradient_depth: kept3(ab * inverse),
            regular,
        }
    }

    /// The surface at the parameters `x` of a hit.
    #[inline]
    pub fn frame(&self, x: Vec3) -> PrismFrame {
        let jacobian = self.jacobian(x);
        let [a, b, c] = self.corner_normals;
        let depth_gradient = normalize_or(-jacobian.gradient_depth, Vec3::Z);
        PrismFrame {
            normal: normalize_or(
                kept3(a * (1.0 - x.x - x.y) + b * x.x + c * x.y),
                depth_gradient,
            ),
            gradient_u: jacobian.gradient_first * self.uv_first.x
                + jacobian.gradient_second * self.uv_second.x,
            gradient_v: jacobian.gradient_first * self.uv_first.y
                + jacobian.gradient_second * self.uv_second.y,
            jacobian,
        }
    }

    /// Solves F(x) = `target` by Newton's method, from `x`, in at most `rounds` iterations.
    /// Returns ∂F/∂x at the start of the last one, which is near enough.
    #[inline]
    pub fn solve(&self, target: Vec3, x: Vec3, rounds: u32) -> (Vec3, Jacobian) {
        let mut x = x;
        let mut jacobian = NOT_REGULAR;
        let mut rest = rounds;
        while rest > 0 {
            jacobian = self.jacobian(x);
            rest -= 1;
            if jacobian.regular {
                let change = jacobian.solve(target - self.point(x));
                x += change;
                let size = abs(change.x) + abs(change.y) + abs(change.z);
                rest = if size < CONVERGED { 0 } else { rest };
            } else {
                rest = 0;
            }
        }
        (x, jacobian)
    }

    /// The second derivative of F at `x` in the directions `p` and `q`.
    #[inline]
    fn bend(&self, x: Vec3, p: Vec3, q: Vec3) -> Vec3 {
        let turn = kept3(self.normal_change(x, p) * self.depth) * q.z
            + kept3(self.normal_change(x, q) * self.depth) * p.z;
        let bend = kept3(self.normal.bend(p, q) * self.depth) * x.z;
        kept3(self.surface.bend(p, q) - (bend + turn))
    }

    /// Returns the change of N for a change of x.
    #[inline]
    fn normal_change(&self, x: Vec3, change: Vec3) -> Vec3 {
        self.normal.along_first(x.x, x.y) * change.x + self.normal.along_second(x.x, x.y) * change.y
    }

    /// Returns the motion along the ray at `x`.
    ///
    /// F(x(t)) is a straight line: F′ x″ = −F″(x′, x′), and F′ x‴ = −3 F″(x′, x″) −
    /// F‴(x′, x′, x′), where only −S_z δ N has a third derivative. Numbers so small that a
    /// device may flush them are set to 0.
    #[inline]
    pub fn motion(&self, x: Vec3, jacobian: &Jacobian, direction: Vec3) -> State {
        let velocity = kept3(jacobian.solve(direction));
        let acceleration = kept3(-jacobian.solve(self.bend(x, velocity, velocity)));
        let third = kept3(
            self.bend(x, velocity, acceleration)
                - self.normal.bend(velocity, velocity) * (self.depth * velocity.z),
        );
        State {
            x: kept3(x),
            velocity,
            acceleration,
            third_order: 0.5 * max(abs(third.x), max(abs(third.y), abs(third.z))),
        }
    }
}

/// Returns whether a point relative to the anchor may lie in the prism of `data`.
#[inline]
pub fn is_near(data: &PrismData, point: Vec3) -> bool {
    let from_centre = point - vec3(data.centre);
    from_centre.dot(from_centre) <= data.radius * data.radius
}

/// Returns whether the surface ends at a side of the prism of `data`.
#[inline]
pub fn is_open(data: &PrismData) -> bool {
    let [a, b, c] = data.neighbours;
    a == NO_NEIGHBOUR || b == NO_NEIGHBOUR || c == NO_NEIGHBOUR
}

/// Returns the control points of a polynomial of degree two over a triangle, whose convex
/// hull contains its values, from its coefficients of 1, w1, w2, w1², w1 w2, w2².
#[inline]
fn control_points(a: [Vec3; 6]) -> [Vec3; 6] {
    [
        a[0],
        a[0] + a[1] + a[3],
        a[0] + a[2] + a[5],
        a[0] + a[1] * 0.5,
        a[0] + (a[1] + a[2] + a[4]) * 0.5,
        a[0] + a[2] * 0.5,
    ]
}

/// Returns points whose convex hull contains the cap of `data`, relative to the anchor.
#[inline]
pub fn cap_hull(data: &PrismData) -> [Vec3; 6] {
    let [first, second, first_first, first_second, second_second] = &data.surface;
    control_points([
        Vec3::ZERO,
        vec3(*first),
        vec3(*second),
        vec3(*first_first),
        vec3(*first_second),
        vec3(*second_second),
    ])
}

/// Returns vectors whose convex hull contains N. The points of [`cap_hull`] minus S_z times
/// these have a hull that contains the floor.
#[inline]
pub fn normal_hull(data: &PrismData) -> [Vec3; 6] {
    let [
        constant,
        first,
        second,
        first_first,
        first_second,
        second_second,
    ] = &data.normal;
    control_points([
        vec3(*constant),
        vec3(*first),
        vec3(*second),
        vec3(*first_first),
        vec3(*first_second),
        vec3(*second_second),
    ])
}

/// Newton's method stops after a change as small as this. The remaining error is about its
/// square times the prism's bend.
#[cfg(not(feature = "double"))]
const CONVERGED: Real = 2e-3;
/// Newton's method stops after a change as small as this. The remaining error is about its
/// square times the prism's bend.
#[cfg(feature = "double")]
const CONVERGED: Real = 1e-6;

#[cfg(test)]
#[allow(clippy::disallowed_methods)] // Never compiled for a device.
pub(crate) mod tests {
    use super::*;
    use crate::layout::Slab;
    use crate::shape_map::tests::Random;

    /// A corner: position, unit normal, texture coordinates.
    pub(crate) type TestCorner = (Vec3, Vec3, Vec2);

    /// Section 6's prism over a triangle, the sides open.
    pub(crate) fn test_prism(corners: [TestCorner; 3], depth: Real) -> PrismData {
        let [p, n] = [corners.map(|c| c.0), corners.map(|c| c.1)];
        let uv = corners.map(|c| c.2);
        let polynomial = |a: [Vec3; 3], edge: &dyn Fn(usize, usize) -> Vec3| {
            let (e01, e12, e20) = (edge(0, 1), edge(1, 2), edge(2, 0));
            [
                a[0],
                a[1] - a[0] + e01,
                a[2] - a[0] + e20,
                -e01,
                e12 - e01 - e20,
                -e20,
            ]
            .map(|v| v.to_array())
        };
        let bulge = |i: usize, j: usize| {
            let edge = p[j] - p[i];
            (n[i] * edge.dot(n[i]) - n[j] * edge.dot(n[j])) * -0.5
        };
        let fanning = |i: usize, j: usize| {
            let h = (n[i] + n[j]) * 0.5;
            h * (4.0 * (1.0 / h.length() - 1.0))
        };
        let surface = polynomial(p.map(|q| q - p[0]), &bulge);
        let facet = (p[1] - p[0]).cross(p[2] - p[0]);
        let mut data = PrismData {
            anchor: p[0].to_array(),
            surface: core::array::from_fn(|i| surface[i + 1]),
            normal: polynomial(n, &fanning),
            corner_normals: n.map(|v| v.to_array()),
            uv: [uv[0], uv[1] - uv[0], uv[2] - uv[0]].map(|v| v.to_array()),
            facet: facet.normalize().to_array(),
            least_determinant: 1e-3 * depth * facet.length(),
            spread: 1.0,
            inverse_altitude: 1.0,
            neighbours: [NO_NEIGHBOUR; 3],
            ..PrismData::default()
        };
        let (cap, down) = (cap_hull(&data), normal_hull(&data));
        let points: [Vec3; 12] =
            core::array::from_fn(|i| cap[i % 6] - down[i % 6] * if i < 6 { 0.0 } else { depth });
        data.slabs = [Vec3::X, Vec3::Y, Vec3::Z, facet.normalize()].map(|axis| {
            let along = points.map(|point| point.dot(axis));
            let low = along.into_iter().fold(1e9, Real::min) - 1e-2;
            let high = along.into_iter().fold(-1e9, Real::max) + 1e-2;
            let scale = 1.0 / (high - low);
            Slab {
                axis: (axis * scale).to_array(),
                low: low * scale,
                high: high * scale,
            }
        });
        let centre = points.into_iter().fold(Vec3::ZERO, |sum, p| sum + p) * (1.0 / 12.0);
        let furthest = points.map(|point| (point - centre).length());
        data.centre = centre.to_array();
        data.radius = furthest.into_iter().fold(0.0, Real::max) + 1e-2;
        data
    }

    fn vector(random: &mut Random, size: f64) -> Vec3 {
        let mut next = || random.within(-size, size) as Real;
        Vec3::new(next(), next(), next())
    }

    /// About the unit triangle, with normals within 30° of its own.
    fn corners(random: &mut Random) -> [TestCorner; 3] {
        [Vec3::ZERO, Vec3::X, Vec3::Y].map(|place| {
            let position = place + vector(random, 0.2) + Vec3::new(3.0, -2.0, 1.0);
            let normal = (Vec3::Z + vector(random, 0.3)).normalize();
            (position, normal, Vec2::new(position.x, position.y))
        })
    }

    fn parameters(random: &mut Random) -> Vec3 {
        let (a, b) = (random.within(0.0, 1.0), random.within(0.0, 1.0));
        let (a, b) = if a + b > 1.0 {
            (1.0 - a, 1.0 - b)
        } else {
            (a, b)
        };
        Vec3::new(a as Real, b as Real, random.within(0.0, 1.0) as Real)
    }

    /// By how much points of random prisms lie beyond the points of their hull,
    /// at most, along random axes; the floor's only if `floor`.
    fn worst_protrusion(floor: bool) -> Real {
        let mut random = Random(11);
        let mut worst: Real = 0.0;
        for _ in 0..300 {
            let data = test_prism(corners(&mut random), 0.3);
            let prism = Prism::new(&data, 0.3);
            let cap = cap_hull(&data);
            let down = normal_hull(&data);
            let axis = vector(&mut random, 1.0).normalize();
            let deep = if floor { 0.3 } else { 0.0 };
            let highest = (0..6)
                .map(|i| cap[i].dot(axis).max((cap[i] - down[i] * deep).dot(axis)))
                .fold(Real::MIN, Real::max);
            for _ in 0..100 {
                let p = prism.point(parameters(&mut random));
                worst = worst.max(p.dot(axis) - highest);
            }
        }
        worst
    }

    #[test]
    fn the_hull_holds_the_prism() {
        assert!(worst_protrusion(true) < 1e-6);
        // The cap alone does not.
        assert!(worst_protrusion(false) > 0.1);
    }

    #[test]
    fn neighbours_share_their_side() {
        let mut random = Random(12);
        let [a, b, c] = corners(&mut random);
        let normal = Vec3::new(0.2, 0.3, 1.0).normalize();
        let other = (Vec3::new(4.0, -1.0, 1.1), normal, Vec2::ZERO);
        let one = Prism::new(&test_prism([a, b, c], 0.2), 0.2);
        let two = Prism::new(&test_prism([c, b, other], 0.2), 0.2);
        for i in 0..=10 {
            let (w, deep) = (0.1 * i as Real, 0.05 * i as Real);
            // From b to c.
            let p = one.point(Vec3::new(1.0 - w, w, deep)) + one.anchor;
            let q = two.point(Vec3::new(1.0 - w, 0.0, deep)) + two.anchor;
            assert!((p - q).length() < 1e-6, "{p} {q}");
            // At the edge's middle N has length 1.
            if i == 5 {
                assert!((one.normal(0.5, 0.5).length() - 1.0).abs() < 1e-6);
            }
        }
        let apart = two.point(Vec3::new(0.3, 0.3, 0.1)) + two.anchor;
        assert!((apart - one.anchor - one.point(Vec3::new(0.3, 0.3, 0.1))).length() > 0.1);
    }

    #[test]
    fn derivatives_are_those_of_the_point() {
        let mut random = Random(13);
        for _ in 0..200 {
            let prism = Prism::new(&test_prism(corners(&mut random), 0.3), 0.3);
            let x = parameters(&mut random);
            let jacobian = prism.jacobian(x);
            assert!(jacobian.regular);
            let h = 1e-2;
            for (axis, column) in [
                (Vec3::X, jacobian.along_first),
                (Vec3::Y, jacobian.along_second),
                (Vec3::Z, jacobian.along_depth),
            ] {
                let slope = (prism.point(x + axis * h) - prism.point(x - axis * h)) * (0.5 / h);
                assert!((slope - column).length() < 1e-4, "{slope} {column}");
                assert!((jacobian.solve(column) - axis).length() < 1e-4);
            }
            // The ray's motion, by Newton's method a little way on.
            let direction = vector(&mut random, 1.0).normalize();
            let state = prism.motion(x, &jacobian, direction);
            let there = prism.point(x) + direction * h;
            let (moved, _) = prism.solve(there, x, 10);
            let first_order = (x + state.velocity * h - moved).length();
            let second = state.x + (state.velocity + state.acceleration * (0.5 * h)) * h;
            let second_order = (second - moved).length();
            assert!(
                second_order < 0.1 * first_order + 1e-5,
                "{second_order} {first_order}"
            );
            // The error of the second order, over a longer way.
            let h = 0.1;
            let second = state.x + (state.velocity + state.acceleration * (0.5 * h)) * h;
            let error = (prism.point(second) - prism.point(x) - direction * h).length();
            let told = state.third_order * h * h * h;
            assert!(error < 2.5 * told + 1e-4, "{error} {told}");
        }
    }
}
