//! One pixel of one curved prism, from the ray to the colour: the accurate
//! tier's counterpart of [`crate::fragment`].

use crate::arithmetic::{div, floor, kept, kept3, normalize_or, sqrt};
use crate::camera::reversed_depth;
use crate::contract::{check, check2, check3};
use crate::fragment::{Hit, Normals};
use crate::layout::{Frame, Object, vec3};
use crate::light;
use crate::normals::{CLASS_BEVEL, CLASS_CAP, CLASS_MISS, CLASS_WALL, class_of};
use crate::prism::{Prism, PrismFrame};
use crate::profile::Profile;
use crate::shadow::CLEARANCE;
use crate::shape_map::{ShapeMap, Texels};
use crate::walk::{self, Field, Shells};
use crate::{Real, Vec2, Vec3};

/// What was found on a ray that comes in through one prism.
#[derive(Clone, Copy, Debug)]
pub struct ShellHit {
    /// The hit; its `s` is `t`.
    pub hit: Hit,
    /// Number of the prism in which it lies.
    pub prism: u32,
    /// (w1, w2, δ) there.
    pub x: Vec3,
    /// Prisms that the ray went through.
    pub prisms: u32,
}

/// The tolerance of `object` at distance 1, object units.
#[inline]
fn blur(frame: &Frame, object: &Object) -> Real {
    let pixel = vec3(frame.ray_right);
    object.tolerance * sqrt(pixel.dot(pixel))
}

/// Searches the shell of `object` for the first hit of a ray that comes into it
/// through prism number `home`. A hit in front of the near plane is a miss.
#[inline]
pub fn trace<S: Shells + ?Sized, T: Texels + ?Sized>(
    frame: &Frame,
    object: &Object,
    shells: &S,
    texels: &T,
    direction: Vec3,
    home: u32,
) -> ShellHit {
    let field = Field {
        shells,
        depth: object.depth,
        blur: blur(frame, object),
        slack: object.slack,
        profile: &Profile::new(object),
        map: &ShapeMap::new(object),
        texels,
        linear_steps: object.linear_steps,
        binary_steps: object.binary_steps,
    };
    let found = walk::search(&field, home, vec3(frame.eye), direction);
    let class = class_of(&found.march, object);
    let t = found.march.s;
    let depth = reversed_depth(frame, direction, t);
    let uv = found.march.uv;
    if class != CLASS_MISS {
        check(t);
        check2(uv);
        check(found.march.depth_fraction);
    }
    ShellHit {
        hit: Hit {
            class: if depth > 1.0 { CLASS_MISS } else { class },
            depth,
            t,
            s: t,
            uv: Vec2::new(uv.x - floor(uv.x), uv.y - floor(uv.y)),
            depth_fraction: found.march.depth_fraction,
            steps: found.march.steps,
        },
        prism: found.prism,
        x: found.x,
        prisms: found.prisms,
    }
}

/// The surface around `hit`.
#[inline]
fn frame_at<S: Shells + ?Sized>(object: &Object, shells: &S, hit: &ShellHit) -> PrismFrame {
    Prism::new(shells.shell(hit.prism), object.depth).frame(hit.x)
}

/// The normals at `hit`, where the surface is `surface`.
///
/// Sides follow the gradient in space of g = D − e − b δ (section 9), with the
/// gradients of u, v and δ in the prism as it is.
#[inline]
fn normals_on<T: Texels + ?Sized>(
    object: &Object,
    texels: &T,
    surface: &PrismFrame,
    hit: &Hit,
) -> Normals {
    let smooth = surface.normal;
    let mut carved = smooth;
    if hit.class == CLASS_WALL || hit.class == CLASS_BEVEL {
        let map = ShapeMap::new(object);
        let slope = map.gradient(texels, hit.uv) * map.size;
        let mut gradient = surface.gradient_u * slope.x + surface.gradient_v * slope.y;
        if hit.class == CLASS_BEVEL {
            gradient -= surface.jacobian.gradient_depth * (object.bevel * map.size.x);
        }
        carved = normalize_or(gradient, smooth);
    }
    check3(carved);
    Normals { carved, smooth }
}

/// The normals at `hit`.
#[inline]
pub fn normals<S: Shells + ?Sized, T: Texels + ?Sized>(
    object: &Object,
    shells: &S,
    texels: &T,
    hit: &ShellHit,
) -> Normals {
    normals_on(object, texels, &frame_at(object, shells, hit), &hit.hit)
}

/// Whether the light in direction `to_light` reaches `hit`, as far as the
/// columns of the same object around it are concerned.
#[inline]
#[allow(clippy::too_many_arguments)] // What the walk needs, and what is known of the hit.
fn lit<S: Shells + ?Sized, T: Texels + ?Sized>(
    frame: &Frame,
    object: &Object,
    shells: &S,
    texels: &T,
    surface: &PrismFrame,
    normals: &Normals,
    hit: &ShellHit,
) -> bool {
    let to_light = vec3(frame.light_direction);
    // Nothing stands on the cap.
    if hit.hit.class == CLASS_CAP {
        return true;
    }
    if to_light.dot(normals.smooth) <= 0.0 {
        return false;
    }
    let map = ShapeMap::new(object);
    // Off the wall, along the part of its normal that lies in the map.
    let sideways = normalize_or(
        kept3(normals.carved - normals.smooth * normals.smooth.dot(normals.carved)),
        Vec3::ZERO,
    );
    let rate = Vec2::new(
        kept(sideways.dot(kept3(surface.gradient_u))),
        kept(sideways.dot(kept3(surface.gradient_v))),
    ) * map.size;
    let speed = sqrt(rate.dot(rate));
    let offset = if speed > 1e-12 {
        sideways * div(CLEARANCE, speed)
    } else {
        Vec3::ZERO
    };
    let field = Field {
        shells,
        depth: object.depth,
        blur: blur(frame, object),
        slack: 0.0,
        profile: &Profile::new(object),
        map: &map,
        texels,
        linear_steps: object.linear_steps,
        binary_steps: 0,
    };
    walk::leaves(&field, hit.prism, hit.x, offset, to_light)
}

/// Linear RGB of `hit`, with self-shadows if `SHADOW`.
#[inline]
pub fn color<const SHADOW: bool, S: Shells + ?Sized, T: Texels + ?Sized>(
    frame: &Frame,
    object: &Object,
    shells: &S,
    texels: &T,
    direction: Vec3,
    hit: &ShellHit,
) -> Vec3 {
    let surface = frame_at(object, shells, hit);
    let normals = normals_on(object, texels, &surface, &hit.hit);
    let lit = !SHADOW || lit(frame, object, shells, texels, &surface, &normals, hit);
    let color = light::shade(frame, object, hit.hit.class, normals.carved, direction, lit);
    check3(color);
    color
}
