//! The curved prism over a triangle (section 6): the accurate tier's shell.
//!
//! A point of the prism is F(w1, w2, δ) = S(w) − S_z δ N(w), with S and N of
//! degree two in the weights of the second and third corner. Along a ray the
//! parameters x = (w1, w2, δ) run on one curve, as long as det ∂F/∂x keeps its
//! sign. The search follows that curve through a hull of the prism: at each
//! point Newton's method gives x, and ∂F/∂x and F's second derivatives give x′
//! and x″ along the ray. From these follow the distances to all faces of the
//! prism, so that entries and exits come in order, however many there are.

use crate::arithmetic::{abs, clamp, div, max, min, normalize_or, sqrt};
use crate::layout::{Triangle, vec2, vec3};
use crate::march::{END_CAP, END_FLOOR, END_MISS, END_SIDE, March, TOLERANCE};
use crate::profile::Profile;
use crate::shape_map::{SafeStep, ShapeMap, Texels};
use crate::{FAR, Real, Vec2, Vec3};

/// How far a weight or δ may lie outside its range and still belong to the
/// prism: neighbours overlap by more than rounding errors.
#[cfg(not(feature = "double"))]
pub const OVERLAP: Real = 2e-5;
/// How far a weight or δ may lie outside its range and still belong to the
/// prism: neighbours overlap by more than rounding errors.
#[cfg(feature = "double")]
pub const OVERLAP: Real = 1e-10;

/// From this δ on a point lies on the floor.
const FLOOR: Real = 1.0 - 10.0 * OVERLAP;

/// A hit less deep than this where the ray comes into a prism is on the cap,
/// also if it comes in through a side.
const CAP: Real = 1e-3;

/// The map counts as folded where its determinant is less than this share of
/// the flat prism's.
const FOLDED: Real = 1e-3;

/// A polynomial of degree two in w1 and w2, with values in space.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Quadratic {
    constant: Vec3,
    first: Vec3,
    second: Vec3,
    first_first: Vec3,
    first_second: Vec3,
    second_second: Vec3,
}

impl Quadratic {
    /// Σ w_i a_i + Σ w_i w_j e_ij, with w0 = 1 − w1 − w2.
    #[inline]
    fn new(a: [Vec3; 3], e01: Vec3, e12: Vec3, e20: Vec3) -> Quadratic {
        Quadratic {
            constant: a[0],
            first: a[1] - a[0] + e01,
            second: a[2] - a[0] + e20,
            first_first: -e01,
            first_second: e12 - e01 - e20,
            second_second: -e20,
        }
    }

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

    /// The second derivative in the direction (v1, v2), the same everywhere.
    #[inline]
    fn bend(&self, v1: Real, v2: Real) -> Vec3 {
        (self.first_first * (v1 * v1)
            + self.first_second * (v1 * v2)
            + self.second_second * (v2 * v2))
            * 2.0
    }
}

/// The shell of one triangle between the cap and the floor.
///
/// Positions are relative to the triangle's first corner, to save digits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prism {
    /// The triangle's first corner, object units.
    pub anchor: Vec3,
    surface: Quadratic,
    normal: Quadratic,
    depth: Real,
    uv: Vec2,
    uv_first: Vec2,
    uv_second: Vec2,
    /// The facet's normal, twice the facet's area long.
    facet: Vec3,
}

/// Where a ray is in the parameters of a prism: x, and the ray's distance t.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// (w1, w2, δ).
    pub x: Vec3,
    /// The derivative of x by t, 1 / object units.
    pub velocity: Vec3,
    /// The second derivative of x by t.
    pub acceleration: Vec3,
}

/// ∂F/∂x and its inverse.
#[derive(Clone, Copy, Debug, PartialEq)]
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

impl Jacobian {
    /// (w1, w2, δ) by which F changes by `displacement`, in first order.
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
    /// Unit normal N(w) of the smooth surface.
    pub normal: Vec3,
    /// ∂F/∂w there, and the gradients of w and δ.
    pub jacobian: Jacobian,
    /// ∇u in space, repeats per object unit.
    pub gradient_u: Vec3,
    /// ∇v in space, repeats per object unit.
    pub gradient_v: Vec3,
}

/// A ray's search of one prism.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrismHit {
    /// How it ended; its `s` is t, the distance from the eye. The rest is
    /// meaningless for a miss.
    pub march: March,
    /// (w1, w2, δ) at the hit.
    pub x: Vec3,
    /// Whether the curve could not be followed: the map folds, or steps ran out
    /// outside the prism.
    pub lost: bool,
}

/// E_ij of section 6.
#[inline]
fn bulge(p: Vec3, q: Vec3, p_normal: Vec3, q_normal: Vec3) -> Vec3 {
    let edge = q - p;
    (p_normal * edge.dot(p_normal) - q_normal * edge.dot(q_normal)) * -0.5
}

/// G_ij of section 6: N has length 1 at the edge's midpoint.
#[inline]
fn fanning(p_normal: Vec3, q_normal: Vec3) -> Vec3 {
    let middle = (p_normal + q_normal) * 0.5;
    // Normals that point apart by more than 150° make no prism.
    let length = sqrt(max(middle.dot(middle), 0.0625));
    middle * (4.0 * (div(1.0, length) - 1.0))
}

impl Prism {
    /// The prism of `triangle`, `depth` = S_z > 0 object units deep. Neighbours
    /// join where the corners at one position have one normal.
    #[inline]
    pub fn new(triangle: &Triangle, depth: Real) -> Prism {
        let [a, b, c] = &triangle.corners;
        let anchor = vec3(a.position);
        let (pa, pb, pc) = (
            Vec3::ZERO,
            vec3(b.position) - anchor,
            vec3(c.position) - anchor,
        );
        let (na, nb, nc) = (vec3(a.normal), vec3(b.normal), vec3(c.normal));
        let uv = vec2(a.uv);
        Prism {
            anchor,
            surface: Quadratic::new(
                [pa, pb, pc],
                bulge(pa, pb, na, nb),
                bulge(pb, pc, nb, nc),
                bulge(pc, pa, nc, na),
            ),
            normal: Quadratic::new(
                [na, nb, nc],
                fanning(na, nb),
                fanning(nb, nc),
                fanning(nc, na),
            ),
            depth,
            uv,
            uv_first: vec2(b.uv) - uv,
            uv_second: vec2(c.uv) - uv,
            facet: pb.cross(pc),
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

    /// ∂F/∂x.
    #[inline]
    pub fn jacobian(&self, x: Vec3) -> Jacobian {
        let deep = self.depth * x.z;
        let a = self.surface.along_first(x.x, x.y) - self.normal.along_first(x.x, x.y) * deep;
        let b = self.surface.along_second(x.x, x.y) - self.normal.along_second(x.x, x.y) * deep;
        let c = self.normal.at(x.x, x.y) * -self.depth;
        let ab = a.cross(b);
        // δ grows inward: the determinant of a prism that is not folded is negative.
        let determinant = -ab.dot(c);
        let facet = sqrt(self.facet.dot(self.facet));
        let regular = determinant > FOLDED * self.depth * facet;
        let inverse = if regular { -div(1.0, determinant) } else { 0.0 };
        Jacobian {
            along_first: a,
            along_second: b,
            along_depth: c,
            gradient_first: b.cross(c) * inverse,
            gradient_second: c.cross(a) * inverse,
            gradient_depth: ab * inverse,
            regular,
        }
    }

    /// The surface at the parameters `x` of a hit.
    #[inline]
    pub fn frame(&self, x: Vec3) -> PrismFrame {
        let jacobian = self.jacobian(x);
        let facet = normalize_or(self.facet, Vec3::Z);
        PrismFrame {
            normal: normalize_or(self.normal.at(x.x, x.y), facet),
            gradient_u: jacobian.gradient_first * self.uv_first.x
                + jacobian.gradient_second * self.uv_second.x,
            gradient_v: jacobian.gradient_first * self.uv_first.y
                + jacobian.gradient_second * self.uv_second.y,
            jacobian,
        }
    }

    /// The points whose convex hull holds the prism, relative to the anchor:
    /// the Bézier points of cap and floor.
    #[inline]
    pub fn hull(&self) -> [Vec3; 12] {
        let [a, b, c, ab, bc, ca] = bezier(&self.surface);
        let [na, nb, nc, nab, nbc, nca] = bezier(&self.normal);
        let d = self.depth;
        [
            a,
            b,
            c,
            ab,
            bc,
            ca,
            a - na * d,
            b - nb * d,
            c - nc * d,
            ab - nab * d,
            bc - nbc * d,
            ca - nca * d,
        ]
    }

    /// The corners of an axis-aligned box that holds the prism, relative to the anchor.
    #[inline]
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let hull = self.hull();
        let (x0, x1) = extent(&hull, Vec3::X);
        let (y0, y1) = extent(&hull, Vec3::Y);
        let (z0, z1) = extent(&hull, Vec3::Z);
        (Vec3::new(x0, y0, z0), Vec3::new(x1, y1, z1))
    }

    /// Distances at which the ray from `origin` (relative to the anchor) comes
    /// into a tight hull of the prism and leaves it: the slabs along the facet's
    /// normal and across its edges. The first is larger where it misses.
    #[inline]
    fn clip(&self, origin: Vec3, direction: Vec3) -> (Real, Real) {
        let hull = self.hull();
        let (b, c) = (hull[1], hull[2]);
        let mut range = (0.0, FAR);
        range = slab(range, &hull, self.facet, origin, direction);
        range = slab(range, &hull, self.facet.cross(b), origin, direction);
        range = slab(range, &hull, self.facet.cross(c - b), origin, direction);
        slab(range, &hull, self.facet.cross(-c), origin, direction)
    }

    /// Newton's method for F(x) = `target`, from `x`.
    #[inline]
    fn solve(&self, target: Vec3, x: Vec3, rounds: u32) -> (Vec3, Jacobian) {
        let mut x = x;
        let mut jacobian = self.jacobian(x);
        let mut rest = rounds;
        while rest > 0 && jacobian.regular {
            let change = jacobian.solve(target - self.point(x));
            x += change;
            jacobian = self.jacobian(x);
            let size = abs(change.x) + abs(change.y) + abs(change.z);
            rest = if size < CONVERGED { 0 } else { rest - 1 };
        }
        (x, jacobian)
    }

    /// How x moves along the ray at `x`.
    #[inline]
    fn motion(&self, x: Vec3, jacobian: &Jacobian, direction: Vec3) -> State {
        let velocity = jacobian.solve(direction);
        let v = (velocity.x, velocity.y);
        let turn =
            self.normal.along_first(x.x, x.y) * v.0 + self.normal.along_second(x.x, x.y) * v.1;
        let bend = self.surface.bend(v.0, v.1)
            - (self.normal.bend(v.0, v.1) * x.z + turn * (2.0 * velocity.z)) * self.depth;
        State {
            x,
            velocity,
            acceleration: -jacobian.solve(bend),
        }
    }
}

/// Newton's method stops after a change as small as this: the next one would be
/// about its square.
#[cfg(not(feature = "double"))]
const CONVERGED: Real = 1e-4;
#[cfg(feature = "double")]
const CONVERGED: Real = 1e-8;

/// Rounds of Newton's method, at most: where the ray comes into the hull, and
/// from one step to the next.
const FIRST_ROUNDS: u32 = 12;
const ROUNDS: u32 = 4;

/// Steps outside the prism, at most: before it and between exit and entry.
const OUTSIDE_STEPS: u32 = 32;

/// The longest step outside, as a share of the way through the hull.
const STRIDE: Real = 0.2;

/// By how much of a weight, or of δ, the second order may be wrong from end to
/// end of a prism, and by which share of its own bend.
const DOUBT: Real = 0.05;

/// Bisections between the last point outside and the first one inside, where
/// that is further inside than [`DEEP`].
const ENTRY_BISECTIONS: u32 = 12;
const DEEP: Real = 1e-4;

/// The six Bézier points of a polynomial: corners, then edges 01, 12, 20.
#[inline]
fn bezier(q: &Quadratic) -> [Vec3; 6] {
    let a = q.constant;
    let b = a + q.first + q.first_first;
    let c = a + q.second + q.second_second;
    [
        a,
        b,
        c,
        a + q.first * 0.5,
        a + (q.first + q.second + q.first_second) * 0.5,
        a + q.second * 0.5,
    ]
}

/// The least and the largest p · `axis`.
#[inline]
fn extent(points: &[Vec3; 12], axis: Vec3) -> (Real, Real) {
    let mut low = FAR;
    let mut high = -FAR;
    let mut i = 0;
    while i < 12 {
        let at = points[i].dot(axis);
        low = min(low, at);
        high = max(high, at);
        i += 1;
    }
    (low, high)
}

/// `range`, clipped to where the ray is between the extremes of `points` along
/// `axis`, with a margin for rounding.
#[inline]
fn slab(
    range: (Real, Real),
    points: &[Vec3; 12],
    axis: Vec3,
    origin: Vec3,
    direction: Vec3,
) -> (Real, Real) {
    let (low, high) = extent(points, axis);
    let margin = 1e-3 * (high - low);
    let (low, high) = (low - margin, high + margin);
    let at = origin.dot(axis);
    let speed = direction.dot(axis);
    if abs(speed) * FAR <= high - low {
        // Parallel to the slab: in it for ever, or never.
        return if at >= low && at <= high {
            range
        } else {
            (1.0, 0.0)
        };
    }
    let to_low = div(low - at, speed);
    let to_high = div(high - at, speed);
    (
        max(range.0, min(to_low, to_high)),
        min(range.1, max(to_low, to_high)),
    )
}

/// When c + v h + ½ a h² comes up through 0, h > 0; for c ≤ 0, or c about 0 and
/// v < 0. [`FAR`] if never.
#[inline]
fn rise(c: Real, v: Real, a: Real) -> Real {
    let radicand = v * v - 2.0 * a * c;
    let root = sqrt(radicand);
    if radicand < 0.0 {
        FAR
    } else if v > 0.0 {
        div(-2.0 * c, v + root)
    } else if a > 0.0 {
        div(root - v, a)
    } else {
        FAR
    }
}

/// When the ray satisfies c ≥ 0 again: 0 where it does, and [`FAR`] if it
/// clearly does not within the time `rest`.
///
/// Terms of third order are left out, so that a near miss is no miss: it is
/// looked at again after `stride`, as is anything further away.
#[inline]
fn until_within(c: Real, v: Real, a: Real, rest: Real, stride: Real) -> Real {
    if c >= OVERLAP || (c >= -OVERLAP && v >= 0.0) {
        return 0.0;
    }
    let end = c + (v + 0.5 * a * rest) * rest;
    // Where the curve turns back, if it does so in time.
    let turns = v > 0.0 && v + a * rest < 0.0;
    let highest = if turns {
        c - 0.5 * v * div(v, a)
    } else {
        max(c, end)
    };
    let doubt = DOUBT * (1.0 + abs(a) * rest * rest);
    if highest < -doubt {
        FAR
    } else {
        min(rise(min(c, 0.0), v, a), stride)
    }
}

/// When the ray, which satisfies c ≥ 0, leaves.
#[inline]
fn until_without(c: Real, v: Real, a: Real) -> Real {
    rise(-max(c, 0.0), -v, -a)
}

impl State {
    /// Time until all conditions on the weights and on the cap hold; `rest` is
    /// the time left, `stride` the longest answer but [`FAR`].
    #[inline]
    fn until_inside(&self, rest: Real, stride: Real) -> Real {
        let (x, v, a) = (self.x, self.velocity, self.acceleration);
        let w0 = until_within(1.0 - x.x - x.y, -v.x - v.y, -a.x - a.y, rest, stride);
        let w1 = until_within(x.x, v.x, a.x, rest, stride);
        let w2 = until_within(x.y, v.y, a.y, rest, stride);
        let cap = until_within(x.z, v.z, a.z, rest, stride);
        max(max(w0, w1), max(w2, cap))
    }

    /// How far inside the nearest of the sides and the cap.
    #[inline]
    fn inset(&self) -> Real {
        min(
            min(1.0 - self.x.x - self.x.y, self.x.x),
            min(self.x.y, self.x.z),
        )
    }

    /// Time until a side, the cap or the floor is reached from inside.
    #[inline]
    fn until_outside(&self) -> Real {
        let (x, v, a) = (self.x, self.velocity, self.acceleration);
        let w0 = until_without(1.0 - x.x - x.y, -v.x - v.y, -a.x - a.y);
        let w1 = until_without(x.x, v.x, a.x);
        let w2 = until_without(x.y, v.y, a.y);
        let depth = min(
            until_without(x.z, v.z, a.z),
            until_without(1.0 - x.z, -v.z, -a.z),
        );
        min(min(w0, w1), min(w2, depth))
    }

    /// x after the time `h`, in second order.
    #[inline]
    fn predicted(&self, h: Real) -> Vec3 {
        self.x + (self.velocity + self.acceleration * (0.5 * h)) * h
    }
}

/// The ray, the prism and the pattern of one search.
struct Search<'a, T: Texels + ?Sized> {
    prism: &'a Prism,
    profile: &'a Profile,
    map: &'a ShapeMap,
    texels: &'a T,
    safe: SafeStep,
    /// Where the ray comes into the hull, relative to the anchor; times count from there.
    origin: Vec3,
    direction: Vec3,
}

impl<T: Texels + ?Sized> Search<'_, T> {
    /// Where the ray is at `t`, near the parameters `guess`.
    #[inline]
    fn at(&self, t: Real, guess: Vec3, rounds: u32) -> (State, bool) {
        let target = self.origin + self.direction * t;
        let (x, jacobian) = self.prism.solve(target, guess, rounds);
        (
            self.prism.motion(x, &jacobian, self.direction),
            jacobian.regular,
        )
    }

    /// The first point inside between `outside` and `inside`, where the ray has
    /// the state `state`, and its time.
    #[inline]
    fn entry(&self, state: State, outside: Real, inside: Real) -> (State, Real) {
        let (mut state, mut outside, mut inside) = (state, outside, inside);
        let mut rest = ENTRY_BISECTIONS;
        while rest > 0 {
            let middle = 0.5 * (outside + inside);
            let (candidate, regular) = self.at(middle, state.predicted(middle - inside), ROUNDS);
            if regular && candidate.inset() >= -OVERLAP {
                state = candidate;
                inside = middle;
            } else {
                outside = middle;
            }
            rest -= 1;
        }
        (state, inside)
    }

    /// Distance to the pattern and its radius there, texels.
    #[inline]
    fn distance_and_radius(&self, x: Vec3) -> (Real, Real) {
        (
            self.map.distance(self.texels, self.prism.uv(x.x, x.y)),
            self.profile.radius(clamp(x.z, 0.0, 1.0)),
        )
    }

    /// A time within which the pattern cannot be met, if x keeps to its second
    /// order, and at most `longest`.
    ///
    /// The bounds are those of the straight march, with the texels per object
    /// unit and the growth of the radius at their largest within `longest`.
    #[inline]
    fn safe_time(&self, state: &State, distance: Real, radius: Real, longest: Real) -> Real {
        let gap = distance - radius;
        let near = gap * self.safe.lipschitz;
        let (far, flat) = if distance >= 1.5 {
            let margin = self.safe.margin;
            (
                gap - margin,
                distance - self.profile.largest_radius() - margin,
            )
        } else {
            (0.0, 0.0)
        };
        let speed = self.texels(state.velocity);
        let acceleration = self.texels(state.acceleration);
        let reach = max(max(near, far), flat);
        let h = min(longest, div(reach, max(speed, 1e-18)));
        let speed = speed + acceleration * h;
        let down = max(state.velocity.z + abs(state.acceleration.z) * h, 0.0);
        let growth = self.profile.bevel * down;
        let step = max(
            max(
                div(near, max(speed + self.safe.lipschitz * growth, 1e-18)),
                div(far, max(speed + growth, 1e-18)),
            ),
            div(flat, max(speed, 1e-18)),
        );
        min(step, h)
    }

    /// The length in texels of a change of x.
    #[inline]
    fn texels(&self, change: Vec3) -> Real {
        let uv = self.prism.uv_first * change.x + self.prism.uv_second * change.y;
        let texels = uv * self.map.size;
        sqrt(texels.dot(texels))
    }
}

/// Searches `prism` for the first hit on the ray from `eye` along the unit
/// vector `direction`,.
///
/// The floor is solid below: a ray that comes in through a side at δ > 1 and
/// goes down meets the floor there. One that comes up from below the floor
/// meets nothing in this prism, as triangles are seen from their front only.
#[inline]
#[allow(clippy::too_many_arguments)] // The parameters of the march, and the ray.
pub fn search<T: Texels + ?Sized>(
    prism: &Prism,
    profile: &Profile,
    map: &ShapeMap,
    texels: &T,
    eye: Vec3,
    direction: Vec3,
    linear_steps: u32,
    binary_steps: u32,
) -> PrismHit {
    let mut found = PrismHit {
        march: March {
            end: END_MISS,
            s: 0.0,
            uv: Vec2::ZERO,
            depth_fraction: 0.0,
            steps: 0,
        },
        x: Vec3::ZERO,
        lost: false,
    };
    let from_eye = eye - prism.anchor;
    let (enter, leave) = prism.clip(from_eye, direction);
    if enter >= leave {
        return found;
    }
    let span = leave - enter;
    let search = Search {
        prism,
        profile,
        map,
        texels,
        safe: SafeStep::new(map.quantum),
        origin: from_eye + direction * enter,
        direction,
    };
    let third: Real = 1.0 / 3.0;
    let (mut state, mut regular) = search.at(0.0, Vec3::new(third, third, 0.5), FIRST_ROUNDS);
    let mut t = 0.0;
    let mut before = 0.0;
    let mut outside_steps = 0;
    let mut steps = 0;
    // Whether the last point was inside: a hit is bracketed by it.
    let mut inside = false;
    let mut met = false;
    let mut first = false;
    let mut over = false;
    // Steps this short make no progress.
    let least = span * OVERLAP;
    while !over {
        let mut h = 0.0;
        if !regular {
            found.lost = true;
            over = true;
        } else {
            let wait = state.until_inside(span - t, STRIDE * span);
            if wait > 0.0 {
                inside = false;
                outside_steps += 1;
                h = max(wait, least);
                found.lost = outside_steps > OUTSIDE_STEPS;
                over = found.lost || t + h > span;
            } else {
                first = !inside;
                inside = true;
                if first && t > 0.0 && state.inset() > DEEP {
                    (state, t) = search.entry(state, before, t);
                }
                if state.x.z >= FLOOR {
                    // From below, it is no hit.
                    met = !first || state.velocity.z >= 0.0;
                    over = true;
                } else {
                    let (distance, radius) = search.distance_and_radius(state.x);
                    let tolerance = if first { 0.0 } else { TOLERANCE };
                    met = distance - radius <= tolerance || steps >= linear_steps;
                    over = met;
                    if !met {
                        steps += 1;
                        let longest = max(min(state.until_outside(), span - t), least);
                        h = search.safe_time(&state, distance, radius, longest);
                        over = t >= span;
                    }
                }
            }
        }
        if !over {
            before = t;
            let guess = state.predicted(h);
            t = min(t + h, span);
            (state, regular) = search.at(t, guess, ROUNDS);
        }
    }
    found.march.steps = steps;
    if !met {
        return found;
    }

    let in_eye = first && enter <= 0.0 && t <= 0.0;
    let at_cap = first && !in_eye && state.x.z <= CAP;
    let mut bisections = if first { 0 } else { binary_steps };
    while bisections > 0 {
        let middle = 0.5 * (before + t);
        let (candidate, regular) = search.at(middle, state.predicted(middle - t), ROUNDS);
        let (distance, radius) = search.distance_and_radius(candidate.x);
        if regular && (distance - radius <= TOLERANCE || candidate.x.z >= FLOOR) {
            t = middle;
            state = candidate;
        } else {
            before = middle;
        }
        bisections -= 1;
    }
    let x = state.x;
    found.x = x;
    found.march.s = enter + t;
    found.march.uv = prism.uv(x.x, x.y);
    found.march.depth_fraction = clamp(x.z, 0.0, 1.0);
    found.march.end = if x.z >= FLOOR {
        END_FLOOR
    } else if at_cap {
        END_CAP
    } else {
        END_SIDE
    };
    found
}

#[cfg(test)]
#[allow(clippy::disallowed_methods)] // References may use the standard library.
mod tests {
    use super::*;
    use crate::layout::{Corner, FORMAT_FLOAT, Object};
    use crate::shape_map::tests::Random;

    fn vector(random: &mut Random, size: f64) -> Vec3 {
        let mut next = || random.within(-size, size) as Real;
        Vec3::new(next(), next(), next())
    }

    fn corner(position: Vec3, normal: Vec3) -> Corner {
        Corner {
            position: position.to_array(),
            normal: normal.normalize().to_array(),
            uv: [position.x, position.y],
            ..Corner::default()
        }
    }

    /// About the unit triangle, with normals within 30° of its own.
    fn corners(random: &mut Random) -> [Corner; 3] {
        [Vec3::ZERO, Vec3::X, Vec3::Y].map(|place| {
            let position = place + vector(random, 0.2) + Vec3::new(3.0, -2.0, 1.0);
            corner(position, Vec3::Z + vector(random, 0.3))
        })
    }

    fn triangle(corners: [Corner; 3]) -> Triangle {
        Triangle {
            corners,
            handedness: 1.0,
        }
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

    /// By how much random points of random prisms lie outside the hull's slabs
    /// and box, at most; only `count` points of the hull are used.
    fn worst_protrusion(count: usize) -> Real {
        let mut random = Random(11);
        let mut worst: Real = 0.0;
        for _ in 0..300 {
            let prism = Prism::new(&triangle(corners(&mut random)), 0.3);
            let whole = prism.hull();
            let hull: [Vec3; 12] = core::array::from_fn(|i| whole[i % count]);
            let axis = vector(&mut random, 1.0).normalize();
            for _ in 0..100 {
                let p = prism.point(parameters(&mut random));
                for axis in [axis, prism.facet, Vec3::X, Vec3::Y, Vec3::Z] {
                    let (low, high) = extent(&hull, axis);
                    worst = worst.max(low - p.dot(axis)).max(p.dot(axis) - high);
                }
            }
        }
        worst
    }

    #[test]
    fn the_hull_holds_the_prism() {
        assert!(worst_protrusion(12) < 1e-6);
        // The cap alone does not.
        assert!(worst_protrusion(6) > 0.1);
    }

    #[test]
    fn neighbours_share_their_side() {
        let mut random = Random(12);
        let [a, b, c] = corners(&mut random);
        let other = corner(Vec3::new(4.0, -1.0, 1.1), Vec3::new(0.2, 0.3, 1.0));
        let one = Prism::new(&triangle([a, b, c]), 0.2);
        let two = Prism::new(&triangle([c, b, other]), 0.2);
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
            let prism = Prism::new(&triangle(corners(&mut random)), 0.3);
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
            let second_order = (state.predicted(h) - moved).length();
            assert!(
                second_order < 0.1 * first_order + 1e-5,
                "{second_order} {first_order}"
            );
        }
    }

    /// A flat prism over the triangle (0, 0), (1, 0), (0, 1), with one column:
    /// texels 0 and 1 of 4 along u.
    fn flat(eye: Vec3, direction: Vec3) -> PrismHit {
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y].map(|p| corner(p, Vec3::Z));
        let object = Object {
            map_size: [4.0, 1.0],
            map_step: 1.0,
            map_format: FORMAT_FLOAT,
            map_reach: 1.0,
            depth: 0.5,
            ..Object::default()
        };
        let texels = [-0.5f32, -0.5, 0.5, 0.5].map(f32::to_bits);
        search(
            &Prism::new(&triangle(corners), 0.5),
            &Profile::new(&object),
            &ShapeMap::new(&object),
            &texels[..],
            eye,
            direction.normalize(),
            1000,
            24,
        )
    }

    #[test]
    fn cap_wall_and_floor_of_a_flat_prism_are_found() {
        let down = |x| flat(Vec3::new(x, 0.1, 2.0), -Vec3::Z).march;
        let cap = down(0.25);
        assert_eq!(cap.end, END_CAP);
        assert!((cap.s - 2.0).abs() < 1e-4, "{cap:?}");
        let floor = down(0.75);
        assert_eq!(floor.end, END_FLOOR);
        assert!((floor.s - 2.5).abs() < 2e-4, "{floor:?}");
        assert_eq!(down(1.5).end, END_MISS);
        // In over the floor, against the column's side at u = ½.
        let eye = Vec3::new(0.8, 0.1, 0.2);
        let wall = flat(eye, Vec3::new(-1.0, 0.0, -1.0)).march;
        assert_eq!(wall.end, END_SIDE);
        assert!((wall.uv.x - 0.5).abs() < 1e-2, "{wall:?}");
        assert!((wall.depth_fraction - 0.2).abs() < 2e-2, "{wall:?}");
        // From within the shell, and away from it.
        let inside = flat(Vec3::new(0.7, 0.1, -0.1), -Vec3::X);
        assert_eq!(inside.march.end, END_SIDE);
        assert!((inside.march.s - 0.2).abs() < 1e-2, "{inside:?}");
        assert_eq!(flat(Vec3::new(0.7, 0.1, -0.1), Vec3::Z).march.end, END_MISS);
        // Through a side below the floor: down it is the floor, up it is nothing.
        let below = Vec3::new(0.7, -1e-3, -0.50005);
        assert_eq!(flat(below, Vec3::new(0.0, 1.0, -1e-3)).march.end, END_FLOOR);
        assert_eq!(flat(below, Vec3::new(0.0, 1.0, 1e-2)).march.end, END_MISS);
    }
}
