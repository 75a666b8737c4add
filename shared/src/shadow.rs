//! Self-shadows: a second march from the hit towards the light, through the same
//! shell.

use crate::arithmetic::{div, kept3, max, normalize_or, sqrt};
use crate::layout::Object;
use crate::march::{END_MISS, Limits, march};
use crate::normals::CLASS_CAP;
use crate::path::Path;
use crate::profile::Profile;
use crate::shape_map::{ShapeMap, Texels};
use crate::surface::Surface;
use crate::{Real, Vec2, Vec3};

/// Distance of a shadow ray's start from the surface, texels: more than the error of the
/// hit and the staircase of the pattern's outline.
pub const CLEARANCE: Real = 1.5;

/// δ below which a cap of a stack is the mesh's surface; the hit there is rounded.
const CAP: Real = 1e-3;

/// Returns the direction away from a wall whose unit normal is `side`, orthogonal to the unit
/// normal `smooth` of the surface; zero if `side` is that normal, as a floor's is.
#[inline]
pub fn away(side: Vec3, smooth: Vec3) -> Vec3 {
    let part = kept3(side - smooth * smooth.dot(side));
    // The rest of equal normals is rounding, which points anywhere.
    if part.dot(part) > 1e-6 {
        normalize_or(part, Vec3::ZERO)
    } else {
        Vec3::ZERO
    }
}

/// A ray from a point inside the shell towards the light.
struct LightPath {
    uv: Vec2,
    velocity: Vec2,
    depth_fraction: Real,
    slope: Real,
    bend: Real,
    inverse_depth: Real,
    end: Real,
    depth_rate: Real,
}

impl Path for LightPath {
    #[inline]
    fn uv(&self, s: Real) -> Vec2 {
        self.uv + self.velocity * s
    }

    #[inline]
    fn depth_fraction(&self, s: Real) -> Real {
        self.depth_fraction + s * (self.slope - self.bend * s) * self.inverse_depth
    }

    #[inline]
    fn uv_rates(&self) -> (Vec2, Vec2) {
        (self.velocity, self.velocity)
    }

    #[inline]
    fn is_even(&self) -> bool {
        true
    }

    #[inline]
    fn depth_rate(&self) -> Real {
        self.depth_rate
    }

    #[inline]
    fn start(&self) -> Real {
        0.0
    }

    #[inline]
    fn end(&self) -> Real {
        self.end
    }

    #[inline]
    fn ends_on_floor(&self) -> bool {
        false
    }
}

/// A point of the carved surface.
#[derive(Clone, Copy)]
pub struct ShadowPoint {
    /// Surface class.
    pub class: u32,
    /// Texture coordinates, repeats.
    pub uv: Vec2,
    /// δ.
    pub depth_fraction: Real,
    /// The local depth of the shell, object units.
    pub depth: Real,
    /// Unit normal of the carved surface.
    pub normal: Vec3,
    /// Unit normal of the smooth surface.
    pub surface_normal: Vec3,
}

/// Returns whether light from above reaches every point at `depth_fraction` of this `class`:
/// nothing stands on the cap, but on those of a [`stack`](crate::stack).
#[inline]
pub fn is_above<T: Texels + ?Sized>(class: u32, depth_fraction: Real) -> bool {
    class == CLASS_CAP && (!T::IS_STACK || depth_fraction < CAP)
}

/// Returns whether the columns around `point` let the light in direction `to_light`
/// reach it; the smooth surface is a quadric if `is_curved`.
#[inline]
pub fn lit<T: Texels + ?Sized>(
    object: &Object,
    map: &ShapeMap,
    texels: &T,
    surface: &Surface,
    is_curved: bool,
    point: &ShadowPoint,
    to_light: Vec3,
) -> bool {
    if is_above::<T>(point.class, point.depth_fraction) {
        return true;
    }
    let slope = -to_light.dot(point.surface_normal);
    if slope >= 0.0 {
        return false;
    }
    let x = to_light.dot(surface.tangent);
    let y = to_light.dot(surface.bitangent);
    let quadric = surface.quadric;
    let bend = if is_curved {
        quadric.x * x * x + quadric.y * x * y + quadric.z * y * y
    } else {
        0.0
    };
    // Start beside the wall.
    let sideways = away(point.normal, point.surface_normal);
    let uv_sideways = Vec2::new(
        sideways.dot(surface.gradient_u),
        sideways.dot(surface.gradient_v),
    );
    let texels_sideways = uv_sideways * map.size;
    let length = sqrt(texels_sideways.dot(texels_sideways));
    let off = if length > 1e-12 {
        uv_sideways * div(CLEARANCE, length)
    } else {
        Vec2::ZERO
    };
    // Start above the cap of a layer.
    let profile = Profile::new(object);
    let depth_fraction = if T::IS_STACK {
        max(
            point.depth_fraction - profile.depth_of_growth(CLEARANCE),
            0.0,
        )
    } else {
        point.depth_fraction
    };
    let height = depth_fraction * point.depth;
    // A valley that bends up faster than the ray shadows it.
    let radicand = slope * slope + 4.0 * bend * height;
    if radicand < 0.0 {
        return false;
    }
    let inverse_depth = div(1.0, point.depth);
    let end = div(2.0 * height, max(sqrt(radicand) - slope, 1e-12));
    let path = LightPath {
        uv: point.uv + off,
        velocity: Vec2::new(
            to_light.dot(surface.gradient_u),
            to_light.dot(surface.gradient_v),
        ),
        depth_fraction,
        slope,
        bend,
        inverse_depth,
        end,
        // The ray rises: a pattern only gets thinner, but a layer may hang above.
        depth_rate: if T::IS_STACK {
            max(-slope, 2.0 * bend * end - slope) * inverse_depth
        } else {
            0.0
        },
    };
    let found = march(
        &path,
        &profile,
        map,
        texels,
        &Limits {
            linear_steps: object.linear_steps,
            binary_steps: 0,
            slack: 0.0,
        },
    );
    found.end == END_MISS
}
