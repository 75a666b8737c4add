//! One pixel of one facet, from the ray to the colour, for every model of the
//! surface: what fragment shaders and the CPU renderer call.

use crate::arithmetic::floor;
use crate::camera::reversed_depth;
use crate::contract::{check, check2, check3};
use crate::layers;
use crate::layout::{Frame, Object, vec3};
use crate::light;
use crate::model::{Hit, Model, Normals, Ray, Traced};
use crate::normals::{CLASS_MISS, HitSurface, class_of, normal_at};
use crate::shape_map::{ShapeMap, Texels};
use crate::{Real, Vec2, Vec3};
use glam::UVec4;

/// Searches the shell behind `entry` for the first hit. A hit in front of the near
/// plane is a miss.
#[inline]
pub fn trace<M: Model<Over>, Over, T: Texels + ?Sized>(
    ray: &Ray<'_>,
    over: &Over,
    texels: &T,
    entry: &M::Entry,
) -> Traced<M::Place> {
    let found = M::search(ray, over, texels, entry);
    let march = found.march;
    let (class, layer) = if T::IS_STACK {
        layers::class_of(&march, ray.object, texels)
    } else {
        let distance = || ShapeMap::new(ray.object).distance(texels, march.uv);
        (class_of(&march, ray.object, distance), 0)
    };
    let depth = reversed_depth(ray.frame, ray.direction, found.t);
    let repeat = Vec2::new(floor(march.uv.x), floor(march.uv.y));
    if class != CLASS_MISS {
        check(found.t);
        check2(march.uv);
        check(march.depth_fraction);
    }
    Traced {
        hit: Hit {
            class: if depth > 1.0 { CLASS_MISS } else { class },
            depth,
            t: found.t,
            uv: march.uv - repeat,
            repeat,
            depth_fraction: march.depth_fraction,
            steps: march.steps,
            layer,
        },
        place: found.place,
    }
}

/// The normals at a hit on `surface`.
#[inline]
pub(crate) fn normals_on<S: HitSurface, T: Texels + ?Sized>(
    ray: &Ray<'_>,
    texels: &T,
    hit: &Hit,
    surface: &S,
) -> Normals {
    let carved = if T::IS_STACK {
        layers::normal_at(hit.class, ray.object, texels, surface, hit)
    } else {
        normal_at(
            hit.class,
            ray.object,
            &ShapeMap::new(ray.object),
            texels,
            surface,
            hit.uv,
            hit.depth_fraction,
        )
    };
    check3(carved);
    Normals {
        carved,
        smooth: surface.normal(),
    }
}

/// The normals at a hit.
#[inline]
pub fn normals<M: Model<Over>, Over, T: Texels + ?Sized>(
    ray: &Ray<'_>,
    over: &Over,
    texels: &T,
    entry: &M::Entry,
    traced: &Traced<M::Place>,
) -> Normals {
    let surface = M::surface(ray, over, entry, &traced.place);
    normals_on(ray, texels, &traced.hit, &surface)
}

/// Linear RGB of a hit, with self-shadows if `SHADOW`.
#[inline]
pub fn color<const SHADOW: bool, M: Model<Over>, Over, T: Texels + ?Sized>(
    ray: &Ray<'_>,
    over: &Over,
    texels: &T,
    entry: &M::Entry,
    traced: &Traced<M::Place>,
) -> Vec3 {
    let class = traced.hit.class;
    let surface = M::surface(ray, over, entry, &traced.place);
    let normals = normals_on(ray, texels, &traced.hit, &surface);
    let lit = !SHADOW || M::lit(ray, over, texels, traced, &surface, &normals);
    let shade = |object: &Object| {
        light::shade(ray.frame, object, class, normals.carved, ray.direction, lit)
    };
    let color = if T::IS_STACK {
        shade(&layers::colored(ray.object, texels, &traced.hit))
    } else {
        shade(ray.object)
    };
    check3(color);
    color
}

/// Float bits, with −0 normalised to +0.
#[inline]
#[allow(clippy::unnecessary_cast)] // Real may be f64.
pub fn word(x: Real) -> u32 {
    let x = x as f32;
    if x == 0.0 { 0 } else { x.to_bits() }
}

/// The words of a pixel in colour pictures: linear RGB as the bits of three f32, and the
/// class.
#[inline]
pub fn color_words(rgb: Vec3, hit: &Hit) -> UVec4 {
    UVec4::new(word(rgb.x), word(rgb.y), word(rgb.z), hit.class)
}

/// The words of a pixel in geometry pictures: (t, u, v, δ), and (class + 256 · steps, N).
/// t is in world units, and the unit normal N in world axes.
#[inline]
pub fn geometry_words(frame: &Frame, hit: &Hit, normal: Vec3) -> (UVec4, UVec4) {
    let [x, y, z] = frame.axes;
    let normal = vec3(x) * normal.x + vec3(y) * normal.y + vec3(z) * normal.z;
    (
        UVec4::new(
            word(hit.t * frame.unit),
            word(hit.uv.x),
            word(hit.uv.y),
            word(hit.depth_fraction),
        ),
        UVec4::new(
            hit.class | (hit.steps << 8),
            word(normal.x),
            word(normal.y),
            word(normal.z),
        ),
    )
}
