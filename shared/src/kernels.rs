//! Functions of this crate whose results on GPU and CPU are compared: a line each in
//! [`for_each_kernel`](crate::for_each_kernel).
//!
//! Functions of an object, a frame or a map are wrapped into functions of plain numbers.
//! Maps are noise: every texel is a hash of its index.
//!
//! ```
//! use relievo_kernel::{Kernel, table};
//! use relievo_shared::kernels::*;
//! use relievo_shared::{arithmetic, for_each_kernel, kernels};
//!
//! const KERNELS: &[Kernel] = for_each_kernel!(table);
//! assert_eq!(KERNELS[0].name, "exact_div");
//! ```

mod noise;
mod words;

use crate::arithmetic::{clamp, normalize_or, sqrt};
use crate::camera::{pixel_ray, reversed_depth};
use crate::facet::{self, FacetHit};
pub use crate::layout::Corner;
use crate::layout::{
    FORMAT_FLOAT, FORMAT_PAPER, Frame, NO_NEIGHBOUR, Object, PrismData, Slab, TIER_FAST,
    TIER_PLANAR, Triangle,
};
use crate::light::shade;
pub use crate::march::March;
use crate::march::{Limits, march};
use crate::model::{paper, relief};
use crate::normals::{SmoothSurface, normal_at};
use crate::outline::bounding_rectangle;
use crate::path::{Path, QuadraticPath};
use crate::prism::Prism;
use crate::profile::Profile;
use crate::shadow::{self, ShadowPoint};
use crate::shape_map::ShapeMap;
pub use crate::surface::Surface;
use crate::surface::{interpolate, uv_bend};
use crate::techniques::PROFILES;
use crate::walk::{self, Field, PrismList};
pub use crate::{Vec2, Vec3};
pub use glam::{Mat3, Mat4, Vec4};
use noise::{FloatNoise, Noise, noise_object};
pub use relievo_kernel::domain::{ANY, FRACTION, NUMBER};
use relievo_kernel::{Domain, Kind};
pub use words::PathWords;

/// Numbers of the value contract but 0.
pub const DIVISOR: Domain = Domain::new(
    "number",
    Kind::NonZero {
        low: crate::arithmetic::SMALLEST,
        high: 1.152_921_5e18,
    },
);

/// Products of two numbers of the value contract.
pub const SQUARE: Domain = Domain::new(
    "square",
    Kind::Magnitude {
        low: crate::arithmetic::SMALLEST * crate::arithmetic::SMALLEST,
        high: 1.152_921_5e18 * 1.152_921_5e18,
    },
);

/// Positions, object units.
pub const POSITION: Domain = Domain::range("position", -8.0, 8.0);
/// Unit vectors.
pub const DIRECTION: Domain = Domain::new("direction", Kind::UnitVector);
/// Distances along a ray, object units.
pub const DISTANCE: Domain = Domain::range("distance", 0.0, 64.0);
/// Texture coordinates, repeats.
pub const UV: Domain = Domain::range("uv", -4.0, 4.0);
/// Gradients of texture coordinates, repeats per object unit.
pub const GRADIENT: Domain = Domain::range("gradient", -16.0, 16.0);
/// Coefficients of a quadric, 1 / object units.
pub const CURVATURE: Domain = Domain::range("curvature", -4.0, 4.0);
/// Depth of the shell, object units.
pub const DEPTH: Domain = Domain::range("depth", 0.0078125, 2.0);
/// Depth of the facet below the surface, object units.
pub const FACET_DEPTH: Domain = Domain::range("facet depth", -0.25, 0.25);
/// Extensions and bevels, width units.
pub const WIDTH: Domain = Domain::range("width", 0.0, 0.5);
/// Distances in a map, texels.
pub const TEXELS: Domain = Domain::range("texels", -16.0, 64.0);
/// Exponents of highlights.
pub const EXPONENT: Domain = Domain::integer("exponent", 0, 127);
/// Pixel coordinates.
pub const PIXEL: Domain = Domain::integer("pixel", 0, 16_383);
/// Numbers for noise, formats and other choices.
pub const CHOICE: Domain = Domain::integer("choice", 0, u32::MAX);

pub use relievo_exact as exact;

/// Calls the macro `$with` with every kernel, a line each:
/// name(type: domain, …) -> type = function;
///
/// Callers import `relievo_shared::{arithmetic, kernels}` and all of
/// `relievo_shared::kernels`.
#[macro_export]
macro_rules! for_each_kernel {
    ($with:ident) => {
        $with! {
            exact_div(f32: ANY, f32: ANY) -> f32 = kernels::exact::div;
            exact_sqrt(f32: ANY) -> f32 = kernels::any_root;
            exact_recip_sqrt(f32: ANY) -> f32 = kernels::exact::recip_sqrt;
            exact_exp(f32: ANY) -> f32 = kernels::exact::exp;
            exact_exp2(f32: ANY) -> f32 = kernels::exact::exp2;
            exact_log(f32: ANY) -> f32 = kernels::exact::log;
            exact_log2(f32: ANY) -> f32 = kernels::exact::log2;
            exact_pow(f32: ANY, f32: ANY) -> f32 = kernels::exact::pow;
            exact_sin(f32: ANY) -> f32 = kernels::exact::sin;
            exact_cos(f32: ANY) -> f32 = kernels::exact::cos;
            exact_tan(f32: ANY) -> f32 = kernels::exact::tan;
            exact_asin(f32: ANY) -> f32 = kernels::exact::asin;
            exact_acos(f32: ANY) -> f32 = kernels::exact::acos;
            exact_atan(f32: ANY) -> f32 = kernels::exact::atan;
            exact_atan2(f32: ANY, f32: ANY) -> f32 = kernels::exact::atan2;
            exact_whole(f32: ANY) -> [f32; 5] = kernels::whole;
            exact_length(Vec4: NUMBER, Vec3: NUMBER) -> (f32, Vec4, Vec3) = kernels::lengths;
            exact_product(Mat4: POSITION, Mat3: POSITION, Vec4: POSITION) -> (Vec4, Mat3) = kernels::products;
            divide(f32: NUMBER, f32: DIVISOR) -> f32 = arithmetic::div;
            root(f32: SQUARE) -> f32 = kernels::root;
            floor(f32: NUMBER) -> f32 = arithmetic::floor;
            limit(f32: NUMBER, f32: NUMBER, f32: NUMBER) -> f32 = kernels::limit;
            power(f32: FRACTION, u32: EXPONENT) -> f32 = arithmetic::power;
            unit(Vec3: POSITION, Vec3: DIRECTION) -> Vec3 = kernels::unit;
            ray(Vec3: DIRECTION, Vec3: DIRECTION, Vec3: DIRECTION, u32: PIXEL, u32: PIXEL) -> Vec3 = kernels::ray;
            depth(Vec3: DIRECTION, Vec3: DIRECTION, f32: DISTANCE, f32: DEPTH) -> f32 = kernels::depth;
            rectangle(Vec3: POSITION, Vec3: POSITION, Vec3: POSITION, Vec3: POSITION) -> (Vec2, Vec2) = kernels::rectangle;
            facet(Vec3: POSITION, Vec3: DIRECTION, Vec3: POSITION, Vec3: POSITION, Vec3: POSITION) -> (bool, f32, Vec3, Vec3) = kernels::facet;
            surface(Corner: CURVATURE, Corner: CURVATURE, Corner: CURVATURE, Vec3: FRACTION, Vec3: DIRECTION) -> Surface = kernels::surface;
            path(Surface: CURVATURE, Vec3: DIRECTION, f32: DISTANCE, f32: DEPTH, u32: CHOICE, f32: FRACTION) -> (PathWords, Vec2, f32, Vec3) = kernels::path;
            path_over_quadric(Vec3: CURVATURE, f32: FACET_DEPTH, Vec3: DIRECTION, f32: DISTANCE, f32: DEPTH, f32: FRACTION) -> (PathWords, Vec2, f32, Vec3) = kernels::path_over_quadric;
            profile(u32: CHOICE, f32: WIDTH, f32: WIDTH, f32: FRACTION, f32: FRACTION, f32: TEXELS) -> (Vec3, Vec3) = kernels::profile;
            map(u32: CHOICE, Vec2: UV) -> (f32, Vec2) = kernels::map;
            search(u32: CHOICE, Vec3: CURVATURE, Vec2: UV, Vec3: DIRECTION, f32: DEPTH, Vec2: WIDTH, f32: FRACTION) -> March = kernels::search;
            search_relief(u32: CHOICE, Vec3: CURVATURE, Vec2: UV, Vec3: DIRECTION, f32: DEPTH, Vec2: WIDTH, f32: FRACTION) -> March = kernels::search_relief;
            search_paper(u32: CHOICE, Vec3: CURVATURE, Vec2: UV, Vec3: DIRECTION, f32: DEPTH, Vec2: WIDTH, f32: FRACTION) -> March = kernels::search_paper;
            normal(u32: CHOICE, Surface: CURVATURE, Vec3: DIRECTION, Vec2: UV, f32: DEPTH, f32: WIDTH, f32: FRACTION) -> Vec3 = kernels::normal;
            prism(Vec3: CURVATURE, Vec3: CURVATURE, Vec3: FRACTION, Vec3: DIRECTION, f32: DEPTH) -> (Vec3, Vec3, Vec3, f32) = kernels::prism;
            search_prism(u32: CHOICE, Vec3: CURVATURE, Vec3: CURVATURE, Vec3: FRACTION, Vec3: DIRECTION, f32: DEPTH, Vec2: WIDTH) -> (March, Vec3) = kernels::search_prism;
            lit(u32: CHOICE, Vec3: CURVATURE, Vec2: UV, Vec3: DIRECTION, Vec3: DIRECTION, f32: FRACTION, f32: DEPTH) -> bool = kernels::lit;
            light(Vec3: DIRECTION, Vec3: DIRECTION, Vec3: DIRECTION, Vec3: FRACTION, Vec3: FRACTION, f32: FRACTION, u32: EXPONENT) -> Vec3 = kernels::light;
        }
    };
}

/// `x` rounded to whole numbers in all ways, and its fraction.
pub fn whole(x: f32) -> [f32; 5] {
    use exact::{ceil, floor, fract, round, trunc};
    [trunc(x), floor(x), ceil(x), round(x), fract(x)]
}

/// The distance between two vectors, and both normalised.
pub fn lengths(a: Vec4, b: Vec3) -> (f32, Vec4, Vec3) {
    let a3 = Vec3::new(a.x, a.y, a.z);
    (
        exact::distance(a3, b),
        exact::normalize_or(a, Vec4::W),
        normalize_or(b, Vec3::Z),
    )
}

/// Products of matrices, as glam has them.
pub fn products(a: Mat4, b: Mat3, v: Vec4) -> (Vec4, Mat3) {
    (a * v, b * b)
}

/// [`clamp`] under a name that is not a banned method.
pub fn limit(x: f32, low: f32, high: f32) -> f32 {
    clamp(x, low, high)
}

/// [`exact::sqrt`], likewise.
pub fn any_root(x: f32) -> f32 {
    exact::sqrt(x)
}

/// [`sqrt`], likewise.
pub fn root(x: f32) -> f32 {
    sqrt(x)
}

/// [`normalize_or`], likewise.
pub fn unit(v: Vec3, fallback: Vec3) -> Vec3 {
    normalize_or(v, fallback)
}

/// Direction of the ray through pixel (x, y).
pub fn ray(first: Vec3, right: Vec3, down: Vec3, x: u32, y: u32) -> Vec3 {
    let frame = Frame {
        ray_first: array(first),
        // The size of a pixel.
        ray_right: array(right * 0.000_976_562_5),
        ray_down: array(down * 0.000_976_562_5),
        forward: array(first),
        ..Frame::default()
    };
    pixel_ray(&frame, x, y)
}

/// Reversed depth at distance `t`.
pub fn depth(direction: Vec3, forward: Vec3, t: f32, near: f32) -> f32 {
    let frame = Frame {
        near,
        forward: array(forward),
        ..Frame::default()
    };
    reversed_depth(&frame, direction, t)
}

fn triangle(a: Vec3, b: Vec3, c: Vec3) -> Triangle {
    let mut triangle = Triangle {
        handedness: 1.0,
        ..Triangle::default()
    };
    triangle.corners[0].position = array(a);
    triangle.corners[1].position = array(b);
    triangle.corners[2].position = array(c);
    triangle
}

/// The rectangle of pixels around a triangle, seen from `eye` along −z.
pub fn rectangle(eye: Vec3, a: Vec3, b: Vec3, c: Vec3) -> (Vec2, Vec2) {
    let frame = Frame {
        eye: array(eye),
        near: 0.0625,
        right: [1.5, 0.0, 0.0],
        up: [0.0, 2.0, 0.0],
        forward: [0.0, 0.0, -1.0],
        size: [800.0, 600.0],
        ..Frame::default()
    };
    let found = bounding_rectangle(&frame, &triangle(a, b, c));
    (found.low, found.high)
}

/// Intersection of a ray with a triangle: hit or not, t, barycentrics and normal.
pub fn facet(eye: Vec3, direction: Vec3, a: Vec3, b: Vec3, c: Vec3) -> (bool, f32, Vec3, Vec3) {
    let found = facet::intersect(eye, direction, &triangle(a, b, c));
    (found.hit, found.t, found.weights, found.normal)
}

/// The smooth surface over a point of a triangle, for a ray.
pub fn surface(a: Corner, b: Corner, c: Corner, weights: Vec3, direction: Vec3) -> Surface {
    let triangle = Triangle {
        corners: [a, b, c],
        handedness: 1.0,
        depth_reductions: 0,
    };
    let hit = FacetHit {
        hit: true,
        t: 1.0,
        weights,
        normal: Vec3::Z,
    };
    let surface = interpolate(&triangle, &hit);
    Surface {
        uv_bend: uv_bend(&triangle, surface.normal, direction),
        ..surface
    }
}

/// A path over any surface, and its point and normal at a share of its length.
pub fn path(
    surface: Surface,
    direction: Vec3,
    facet_t: f32,
    depth: f32,
    choice: u32,
    share: f32,
) -> (PathWords, Vec2, f32, Vec3) {
    let tier = if choice & 1 == 0 {
        TIER_PLANAR
    } else {
        TIER_FAST
    };
    let path = QuadraticPath::new(&surface, direction, facet_t, depth, tier);
    let s = path.start() + (path.end() - path.start()) * share;
    let normal = path.surface_normal(&surface, direction, s);
    (PathWords(path), path.uv(s), path.depth_fraction(s), normal)
}

/// A surface whose tangent frame is the coordinate axes.
fn upright_surface(quadric: Vec3, uv: Vec2, facet_depth: f32) -> Surface {
    Surface {
        normal: Vec3::Z,
        tangent: Vec3::X,
        bitangent: Vec3::Y,
        quadric,
        uv,
        gradient_u: Vec3::X,
        gradient_v: Vec3::Y,
        uv_bend: Vec2::ZERO,
        facet_depth,
    }
}

/// A path over a quadric patch.
pub fn path_over_quadric(
    quadric: Vec3,
    facet_depth: f32,
    direction: Vec3,
    facet_t: f32,
    depth: f32,
    share: f32,
) -> (PathWords, Vec2, f32, Vec3) {
    let surface = upright_surface(quadric, Vec2::ZERO, facet_depth);
    path(surface, direction, facet_t, depth, TIER_FAST, share)
}

/// One of the profiles.
fn kind(choice: u32) -> u32 {
    ((choice & 0xff) * PROFILES) >> 8
}

/// A profile's radius and slope at a depth, and its largest radius; its depth at a
/// distance, the gap there, and whether it grows there.
pub fn profile(
    choice: u32,
    extension: f32,
    bevel: f32,
    chamfer: f32,
    depth_fraction: f32,
    distance: f32,
) -> (Vec3, Vec3) {
    let profile = Profile::new(
        &Object {
            map_size: [128.0, 64.0],
            extension,
            bevel,
            chamfer,
            profile: kind(choice),
            parts: 1 + ((choice >> 8) & 7),
            ..Object::default()
        }
        .complete(),
    );
    let grows = profile.is_growing(depth_fraction, || distance);
    (
        Vec3::new(
            profile.radius(depth_fraction),
            profile.slope(depth_fraction),
            profile.largest_radius(),
        ),
        Vec3::new(
            profile.depth_of(distance),
            profile.gap(distance, depth_fraction),
            if grows { 1.0 } else { 0.0 },
        ),
    )
}

/// Distance and gradient of a map of noise, in each form of storage.
pub fn map(choice: u32, uv: Vec2) -> (f32, Vec2) {
    let mut object = noise_object(choice);
    let noise = Noise(choice);
    let form = choice & 3;
    if form == 2 {
        object.map_packing = 0;
        object.map_format = FORMAT_FLOAT;
        let map = ShapeMap::new(&object);
        let noise = FloatNoise(noise);
        return (map.distance(&noise, uv), map.gradient(&noise, uv));
    }
    if form == 3 {
        object.map_packing = 0;
        object.map_format = FORMAT_PAPER;
    }
    let map = ShapeMap::new(&object);
    (map.distance(&noise, uv), map.gradient(&noise, uv))
}

/// An object of noise with a profile.
fn solid(choice: u32, depth: f32, widths: Vec2, chamfer: f32) -> Object {
    Object {
        depth,
        // Of the order of a texel.
        extension: widths.x * 0.0625,
        bevel: widths.y * 0.25,
        chamfer,
        profile: kind(choice >> 16),
        parts: 1 + ((choice >> 24) & 7),
        ..noise_object(choice & !2)
    }
    .complete()
}

/// Distance before the solid at which a search may end, texels: 0 for half of the
/// choices.
fn slack(choice: u32) -> f32 {
    if choice & 0x1000 == 0 { 0.0 } else { 0.75 }
}

/// A march through noise.
pub fn search(
    choice: u32,
    quadric: Vec3,
    uv: Vec2,
    direction: Vec3,
    depth: f32,
    widths: Vec2,
    chamfer: f32,
) -> March {
    let object = solid(choice, depth, widths, chamfer);
    let surface = upright_surface(quadric, uv, 0.0);
    let path = QuadraticPath::new(&surface, direction, 1.0, depth, TIER_FAST);
    march(
        &path,
        &Profile::new(&object),
        &ShapeMap::new(&object),
        &Noise(choice),
        &Limits {
            linear_steps: object.linear_steps,
            binary_steps: object.binary_steps,
            slack: slack(choice),
        },
    )
}

/// Relief mapping through noise.
pub fn search_relief(
    choice: u32,
    quadric: Vec3,
    uv: Vec2,
    direction: Vec3,
    depth: f32,
    widths: Vec2,
    chamfer: f32,
) -> March {
    let object = solid(choice, depth, widths, chamfer);
    let surface = upright_surface(quadric, uv, 0.0);
    let path = QuadraticPath::new(&surface, direction, 1.0, depth, TIER_FAST);
    relief::search(
        &path,
        &Profile::new(&object),
        &ShapeMap::new(&object),
        &Noise(choice),
        object.linear_steps,
        object.binary_steps,
    )
}

/// The paper's search through noise.
pub fn search_paper(
    choice: u32,
    quadric: Vec3,
    uv: Vec2,
    direction: Vec3,
    depth: f32,
    widths: Vec2,
    chamfer: f32,
) -> March {
    let object = solid(choice, depth, widths, chamfer);
    let surface = upright_surface(quadric, uv, 0.0);
    let map = ShapeMap::new(&object);
    paper::search(&object, &map, &Noise(choice), &surface, direction)
}

/// A prism over the triangle (0, 0, 0), (1, 0, 0), (0, 1, 0), curved by `bend`, with
/// normals that diverge by `fan`.
#[inline]
pub fn prism_data(bend: Vec3, fan: Vec3) -> PrismData {
    let (bend, fan) = (bend * 0.0625, fan * 0.0625);
    let slab = |axis: Vec3, low: f32, high: f32| Slab {
        axis: array(axis),
        low,
        high,
    };
    let zero = [0.0, 0.0, 0.0];
    PrismData {
        surface: [
            array(Vec3::X),
            array(Vec3::Y),
            array(Vec3::Z * -bend.x),
            array(Vec3::Z * bend.y),
            array(Vec3::Z * -bend.z),
        ],
        normal: [
            array(Vec3::Z),
            array(Vec3::new(fan.x, fan.y, 0.0)),
            array(Vec3::new(-fan.y, fan.z, 0.0)),
            zero,
            zero,
            zero,
        ],
        corner_normals: [array(Vec3::Z), array(Vec3::Z), array(Vec3::Z)],
        uv: [[0.0, 0.0], [1.0, 0.25], [0.0, 1.0]],
        facet: array(Vec3::Z),
        least_determinant: 0.000_976_562_5,
        spread: 1.0,
        slabs: [
            slab(Vec3::Z, -3.0, 1.0),
            slab(Vec3::new(0.6, 0.8, 0.0), -1.5, 2.0),
            slab(Vec3::X, -1.0, 2.0),
            slab(Vec3::Y, -1.0, 2.0),
        ],
        centre: [0.5, 0.5, -1.0],
        radius: 3.0,
        inverse_altitude: 1.5,
        neighbours: [NO_NEIGHBOUR, NO_NEIGHBOUR, NO_NEIGHBOUR],
        ..PrismData::default()
    }
}

/// Parameters in the triangle from two fractions and a depth fraction.
#[inline]
fn inside(shares: Vec3) -> Vec3 {
    Vec3::new(shares.x, shares.y * (1.0 - shares.x), shares.z)
}

/// A prism's parameters, found from their point, and their motion.
pub fn prism(
    bend: Vec3,
    fan: Vec3,
    shares: Vec3,
    direction: Vec3,
    depth: f32,
) -> (Vec3, Vec3, Vec3, f32) {
    let prism = Prism::new(&prism_data(bend, fan), depth);
    let target = prism.point(inside(shares));
    let (x, jacobian) = prism.solve(target, Vec3::new(0.25, 0.25, 0.5), 6);
    let state = prism.motion(x, &jacobian, direction);
    (
        state.x,
        state.velocity,
        state.acceleration,
        state.third_order,
    )
}

/// A single prism, its sides open.
struct Alone(PrismData);

impl PrismList for Alone {
    #[inline]
    fn prism(&self, _index: u32) -> &PrismData {
        &self.0
    }
}

/// The search of a ray towards a point of a prism, through noise.
pub fn search_prism(
    choice: u32,
    bend: Vec3,
    fan: Vec3,
    shares: Vec3,
    direction: Vec3,
    depth: f32,
    widths: Vec2,
) -> (March, Vec3) {
    let object = solid(choice, depth, widths, 1.0);
    let prisms = Alone(prism_data(bend, fan));
    let target = Prism::new(&prisms.0, depth).point(inside(shares));
    let field = Field {
        prisms: &prisms,
        object: &object,
        tolerance: 0.000_976_562_5,
        slack: 0.25 * slack(choice),
        texels: &Noise(choice),
        binary_steps: object.binary_steps,
    };
    let found = walk::search(&field, 0, target - direction * 4.0, direction);
    (found.march, found.x)
}

/// The normal of a hit of any class.
pub fn normal(
    choice: u32,
    surface: Surface,
    smooth: Vec3,
    uv: Vec2,
    depth: f32,
    bevel: f32,
    depth_fraction: f32,
) -> Vec3 {
    let object = solid(choice, depth, Vec2::new(0.0, bevel), 1.0);
    let map = ShapeMap::new(&object);
    let class = 1 + ((choice >> 8) & 3);
    let surface = SmoothSurface {
        surface,
        normal: smooth,
        depth,
    };
    normal_at(
        class,
        &object,
        &map,
        &Noise(choice),
        &surface,
        uv,
        depth_fraction,
    )
}

/// Whether the light reaches a point among columns of noise.
pub fn lit(
    choice: u32,
    quadric: Vec3,
    uv: Vec2,
    normal: Vec3,
    to_light: Vec3,
    depth_fraction: f32,
    depth: f32,
) -> bool {
    let object = solid(choice, depth, Vec2::new(0.0, 0.25), 1.0);
    let point = ShadowPoint {
        class: 1 + ((choice >> 8) & 3),
        uv,
        depth_fraction,
        depth,
        normal,
        surface_normal: Vec3::Z,
    };
    shadow::lit(
        &object,
        &ShapeMap::new(&object),
        &Noise(choice),
        &upright_surface(quadric, uv, 0.0),
        true,
        &point,
        to_light,
    )
}

/// Light from a surface.
pub fn light(
    normal: Vec3,
    direction: Vec3,
    to_light: Vec3,
    albedo: Vec3,
    light: Vec3,
    specular: f32,
    shininess: u32,
) -> Vec3 {
    let frame = Frame {
        light_direction: array(to_light),
        light_color: array(light),
        ambient: array(light * 0.25),
        ..Frame::default()
    };
    let object = Object {
        wall_color: array(albedo),
        specular,
        shininess,
        ..Object::default()
    };
    shade(
        &frame,
        &object,
        crate::normals::CLASS_WALL,
        normal,
        direction,
        true,
    )
}

fn array(v: Vec3) -> [f32; 3] {
    [v.x, v.y, v.z]
}
