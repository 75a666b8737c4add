//! Hits in a [`stack`](crate::stack) of layers: which layer is hit, its normal, its materials, and what
//! stands around.

#[cfg(not(feature = "double"))]
use crate::arithmetic::max;
use crate::arithmetic::{kept3, normalize_or};
use crate::layout::Object;
use crate::march::{END_CAP, END_FLOOR, END_MISS, March};
use crate::model::Hit;
use crate::normals::{CLASS_BEVEL, CLASS_CAP, CLASS_FLOOR, CLASS_MISS, CLASS_WALL, HitSurface};
#[cfg(not(feature = "double"))]
use crate::openness::{hidden, openness};
use crate::profile::Profile;
use crate::shape_map::{ShapeMap, Texels};
#[cfg(not(feature = "double"))]
use crate::stack::Layer;
use crate::stack::{COLORS, FINISH, Stack};
#[cfg(not(feature = "double"))]
use crate::{FAR, Vec2};
use crate::{Real, Vec3};

/// Returns the class of the point where the march ended, and its layer; at the floor, the layer that
/// stands nearest.
#[inline]
pub fn class_of<T: Texels + ?Sized>(march: &March, object: &Object, texels: &T) -> (u32, u32) {
    if march.end == END_MISS || (march.end == END_FLOOR && object.cut_out != 0) {
        return (CLASS_MISS, 0);
    }
    let map = ShapeMap::new(object);
    let stack = Stack::new(&Profile::new(object), &map);
    let (layer, is_face, is_growing) = stack.nearest(texels, march.uv, march.depth_fraction);
    let class = if march.end == END_FLOOR {
        CLASS_FLOOR
    } else if march.end == END_CAP || is_face {
        CLASS_CAP
    } else if is_growing {
        CLASS_BEVEL
    } else {
        CLASS_WALL
    };
    (class, layer)
}

/// Returns the unit normal at `hit` as if its class were `class`, where `surface` is the smooth surface.
#[inline]
pub fn normal_at<S: HitSurface, T: Texels + ?Sized>(
    class: u32,
    object: &Object,
    texels: &T,
    surface: &S,
    hit: &Hit,
) -> Vec3 {
    let map = ShapeMap::new(object);
    let stack = Stack::new(&Profile::new(object), &map);
    let layer = stack.layer(texels, hit.layer);
    let smooth = surface.normal();
    if class == CLASS_CAP {
        // An underside is nearer to the bottom.
        let is_under = layer.bottom < 1.0 && 2.0 * hit.depth_fraction > layer.top + layer.bottom;
        return if is_under { -smooth } else { smooth };
    }
    if class == CLASS_FLOOR {
        return smooth;
    }
    let slope = map.of_layer(hit.layer).gradient(texels, hit.uv) * map.size;
    let is_sloped = class == CLASS_BEVEL && layer.profile.grows;
    let growth = layer.profile.slope(layer.own(hit.depth_fraction)) * layer.inverse_extent;
    normalize_or(kept3(surface.side(slope, is_sloped, growth)), smooth)
}

/// Returns `object` with the colours of the layer of `hit`.
#[inline]
pub fn colored<T: Texels + ?Sized>(object: &Object, texels: &T, hit: &Hit) -> Object {
    let map = ShapeMap::new(object);
    let stack = Stack::new(&Profile::new(object), &map);
    let place = stack.place(hit.layer) + COLORS as u32;
    let number = |i: u32| f32::from_bits(texels.word(place + i)) as Real;
    let color = |i: u32| [number(i), number(i + 1), number(i + 2)];
    Object {
        cap_color: color(0),
        wall_color: color(3),
        bevel_color: color(6),
        ..*object
    }
}

/// Returns the number of the materials of `hit`, counted from the object's. The floor is the object's
/// own.
#[inline]
pub fn finish<T: Texels + ?Sized>(object: &Object, texels: &T, hit: &Hit) -> u32 {
    if hit.class == CLASS_FLOOR {
        return 0;
    }
    let map = ShapeMap::new(object);
    let stack = Stack::new(&Profile::new(object), &map);
    texels.word(stack.place(hit.layer) + FINISH as u32)
}

/// What smooth edges and [`openness`](crate::openness) know of a hit in a stack.
#[cfg(not(feature = "double"))]
#[derive(Clone, Copy)]
pub struct Around {
    /// The hit with its δ counted from the top of its layer, or to the bottom where the layer hangs; a
    /// cap at the foot of another layer is that layer's floor.
    pub hit: Hit,
    /// −1 where the layer hangs, else 1.
    pub up: Real,
    /// Distance to the outline of that layer, less its radius, texels.
    pub distance: Real,
    /// The gradient of that layer's map there, texels per texel.
    pub gradient: Vec2,
    /// Share of the sky that is seen, 0…1.
    pub openness: Real,
}

/// Returns the surroundings of `hit`; `density` is |∇u|, repeats per object unit.
#[cfg(not(feature = "double"))]
#[inline]
pub fn around<T: Texels + ?Sized>(object: &Object, texels: &T, hit: &Hit, density: Real) -> Around {
    let map = ShapeMap::new(object);
    let stack = Stack::new(&Profile::new(object), &map);
    let own = stack.layer(texels, hit.layer);
    let is_cap = hit.class == CLASS_CAP;
    // The nearest layer that stands higher than a cap.
    let mut foot = FAR;
    let mut higher = hit.layer;
    let mut top = own.top;
    let see = |index, layer: &Layer, _, (beside, _): (Real, Real)| {
        if is_cap && layer.top < own.top && layer.bottom >= own.top && beside < foot {
            foot = beside;
            higher = index;
            top = layer.top;
        }
    };
    stack.each(texels, hit.uv, hit.depth_fraction, see);
    let own_distance = map.of_layer(hit.layer).distance(texels, hit.uv);
    let (outline, _) = own.faces(stack.slope, own_distance, hit.depth_fraction);
    let is_foot = foot < -outline;
    let nearest = if is_foot { higher } else { hit.layer };
    let gradient = map.of_layer(nearest).gradient(texels, hit.uv);
    let seen = Hit {
        class: if is_foot { CLASS_FLOOR } else { hit.class },
        depth_fraction: hit.depth_fraction - own.top,
        ..*hit
    };
    let openness = if is_cap {
        let scale = max(density * map.size.x, 1e-6);
        let height = max((own.top - top) * object.depth * scale, 0.0);
        1.0 - if foot < FAR {
            hidden(foot, height)
        } else {
            0.0
        }
    } else {
        let map = map.of_layer(hit.layer);
        openness(object, &map, texels, &seen, outline, gradient, density)
    };
    // A cap knows where a side begins.
    let is_hanging = !is_cap && own.bottom < 1.0;
    Around {
        hit: Hit {
            depth_fraction: if is_hanging {
                own.bottom - hit.depth_fraction
            } else {
                seen.depth_fraction
            },
            ..seen
        },
        up: if is_hanging { -1.0 } else { 1.0 },
        distance: if is_foot { foot } else { outline },
        gradient,
        openness,
    }
}

#[cfg(test)]
#[allow(clippy::disallowed_methods)] // References are computed in f64, by the standard library.
mod tests;
