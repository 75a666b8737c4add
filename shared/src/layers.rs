//! Layers: a stack of extrusions, each with its own pattern, depth range and profile, which one
//! march searches at once (section 2).
//!
//! The words of a stack are the texels of its layers, one after the other, all of the same size and
//! form, and then a record of [`RECORD`] words for each layer. The first layer has the object's own
//! pattern. [`Object::profile`] is [`LAYERED`], and [`Object::parts`] the number of layers. The
//! object's bevel is the slope in which depths are measured: texels per unit of δ, once in texels,
//! no less than any layer's. Its extension and its chamfer are 0.

use crate::arithmetic::{clamp, kept3, max, min, normalize_or};
use crate::layout::Object;
use crate::march::{END_CAP, END_FLOOR, END_MISS, March};
use crate::model::Hit;
use crate::normals::{CLASS_BEVEL, CLASS_CAP, CLASS_FLOOR, CLASS_MISS, CLASS_WALL, HitSurface};
#[cfg(not(feature = "double"))]
use crate::openness::{hidden, openness};
use crate::profile::Profile;
use crate::shape_map::{ShapeMap, Texels};
use crate::trace::word;
use crate::{FAR, Real, Vec2, Vec3};

/// [`Object::profile`] of a stack.
pub const LAYERED: u32 = u32::MAX;
/// Words of a layer's record: `top`, `bottom` and 1 / (`bottom` − `top`); its materials; its colours;
/// its profile.
pub const RECORD: usize = PROFILE + Profile::WORDS;
/// Place of the number of its materials in a record, counted from the object's.
const FINISH: usize = 3;
/// Place of the colours of cap, wall and bevel.
const COLORS: usize = 4;
/// Place of the profile.
const PROFILE: usize = COLORS + 9;

/// The words of a stack.
pub struct Stacked<T>(pub T);

impl<T: Texels> Texels for Stacked<T> {
    const IS_STACK: bool = true;

    #[inline]
    fn word(&self, index: u32) -> u32 {
        self.0.word(index)
    }
}

/// One layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layer {
    /// δ of its caps, 0…1.
    pub top: Real,
    /// δ where it ends, `top`…1.
    pub bottom: Real,
    /// 1 / (`bottom` − `top`).
    pub inverse_extent: Real,
    /// Its growth, from δ = 0 at `top` to 1 at `bottom`.
    pub profile: Profile,
}

impl Layer {
    /// Returns its record, where `colors` are those of cap, wall and bevel, linear RGB, and `finish` is
    /// the number of its materials less that of its object.
    pub fn record(&self, finish: u32, colors: [[f32; 3]; 3]) -> [u32; RECORD] {
        let mut record = [0; RECORD];
        let numbers = [self.top, self.bottom, self.inverse_extent];
        let mut i = 0;
        while i < RECORD {
            record[i] = if i < FINISH {
                word(numbers[i])
            } else if i == FINISH {
                finish
            } else if i < PROFILE {
                colors[(i - COLORS) / 3][(i - COLORS) % 3].to_bits()
            } else {
                self.profile.words()[i - PROFILE]
            };
            i += 1;
        }
        record
    }

    /// Returns its own δ, 0…1.
    #[inline]
    fn own(&self, depth_fraction: Real) -> Real {
        clamp((depth_fraction - self.top) * self.inverse_extent, 0.0, 1.0)
    }

    /// Returns how far its side is from a point `distance` texels from its pattern, and how far its
    /// caps or undersides are if they are further, in texels: `slope` a unit of δ. The larger
    /// one is a distance to the layer. It is at most 0 inside.
    #[inline]
    fn faces(&self, slope: Real, distance: Real, depth_fraction: Real) -> (Real, Real) {
        let beside = if self.profile.grows {
            self.profile.gap(distance, self.own(depth_fraction))
        } else {
            self.profile.upright_gap(distance)
        };
        // Nothing is above the shell, or below the floor.
        let above = if self.top > 0.0 {
            slope * (self.top - depth_fraction)
        } else {
            beside
        };
        let below = if self.bottom < 1.0 {
            slope * (depth_fraction - self.bottom)
        } else {
            beside
        };
        (beside, max(above, below))
    }
}

/// A stack of layers.
#[derive(Clone, Copy)]
pub struct Stack<'a> {
    map: &'a ShapeMap,
    /// Texels per unit of δ.
    slope: Real,
    /// Number of layers.
    count: u32,
    /// Place of the first record.
    records: u32,
}

impl<'a> Stack<'a> {
    /// Returns the stack of an object with this `profile` and this `map`.
    #[inline]
    pub fn new(profile: &Profile, map: &'a ShapeMap) -> Stack<'a> {
        let count = profile.parts();
        Stack {
            map,
            slope: profile.largest_slope(),
            count,
            records: map.words(count),
        }
    }

    /// Returns the place of the record of layer `index`.
    #[inline]
    fn place(&self, index: u32) -> u32 {
        self.records + index * RECORD as u32
    }

    /// Returns layer `index`.
    #[inline]
    fn layer<T: Texels + ?Sized>(&self, texels: &T, index: u32) -> Layer {
        let place = self.place(index);
        let number = |i: u32| f32::from_bits(texels.word(place + i)) as Real;
        Layer {
            top: number(0),
            bottom: number(1),
            inverse_extent: number(2),
            profile: Profile::from_words(|i| texels.word(place + PROFILE as u32 + i)),
        }
    }

    /// Returns two distances from a point to the stack, texels: one that does not shrink with
    /// δ, and the nearest.
    #[inline]
    pub fn gaps<T: Texels + ?Sized>(
        &self,
        texels: &T,
        uv: Vec2,
        depth_fraction: Real,
    ) -> (Real, Real) {
        let mut clear = FAR;
        let mut gap = FAR;
        let mut index = 0;
        while index < self.count {
            let layer = self.layer(texels, index);
            let distance = self.map.of_layer(index).distance(texels, uv);
            let (beside, above) = layer.faces(self.slope, distance, depth_fraction);
            clear = min(clear, distance - max(layer.profile.largest_radius(), 0.0));
            gap = min(gap, max(beside, above));
            index += 1;
        }
        (clear, gap)
    }

    /// Returns the layer that is nearest to a point, and the class of its face there.
    #[inline]
    fn nearest<T: Texels + ?Sized>(
        &self,
        texels: &T,
        uv: Vec2,
        depth_fraction: Real,
    ) -> (u32, u32) {
        let mut least = FAR;
        let mut nearest = 0;
        let mut class = CLASS_WALL;
        let mut index = 0;
        while index < self.count {
            let layer = self.layer(texels, index);
            let distance = self.map.of_layer(index).distance(texels, uv);
            let (beside, above) = layer.faces(self.slope, distance, depth_fraction);
            let gap = max(beside, above);
            if gap < least {
                least = gap;
                nearest = index;
                class = if above > beside {
                    CLASS_CAP
                } else if layer
                    .profile
                    .is_growing(layer.own(depth_fraction), || distance)
                {
                    CLASS_BEVEL
                } else {
                    CLASS_WALL
                };
            }
            index += 1;
        }
        (nearest, class)
    }
}

/// Returns the class of the point where the march ended, and its layer; at the floor, the layer that
/// stands nearest.
#[inline]
pub fn class_of<T: Texels + ?Sized>(march: &March, object: &Object, texels: &T) -> (u32, u32) {
    if march.end == END_MISS || (march.end == END_FLOOR && object.cut_out != 0) {
        return (CLASS_MISS, 0);
    }
    let map = ShapeMap::new(object);
    let stack = Stack::new(&Profile::new(object), &map);
    let (layer, class) = stack.nearest(texels, march.uv, march.depth_fraction);
    if march.end == END_CAP {
        (CLASS_CAP, layer)
    } else if march.end == END_FLOOR {
        (CLASS_FLOOR, layer)
    } else {
        (class, layer)
    }
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
    let mut index = 0;
    while index < stack.count {
        let layer = stack.layer(texels, index);
        let distance = map.of_layer(index).distance(texels, hit.uv);
        let (beside, _) = layer.faces(stack.slope, distance, hit.depth_fraction);
        if is_cap && layer.top < own.top && layer.bottom >= own.top && beside < foot {
            foot = beside;
            higher = index;
            top = layer.top;
        }
        index += 1;
    }
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
