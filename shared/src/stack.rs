//! Stacks of layers: several extrusions, each with its own pattern, depth range and profile, which one
//! march searches at once (section 2).
//!
//! The words of a stack are the texels of its layers, one after the other, all of the same size and
//! form, and then a record of [`RECORD`] words for each layer. The first layer has the object's own
//! pattern. [`Object::profile`] is [`LAYERED`], and [`Object::parts`] the number of layers. The
//! object's bevel is the slope in which depths are measured: texels per unit of δ, once in texels,
//! no less than any layer's. Its extension and its chamfer are 0.
//!
//! [`Object::profile`]: crate::layout::Object::profile
//! [`Object::parts`]: crate::layout::Object::parts
//! [`LAYERED`]: crate::profile::LAYERED

use crate::arithmetic::{clamp, max, min};
use crate::profile::{Profile, bits};
use crate::shape_map::{ShapeMap, Texels};
use crate::{FAR, Real, Vec2};

/// Words of a layer's record: `top`, `bottom` and 1 / (`bottom` − `top`); its materials; its colours;
/// its profile.
pub const RECORD: usize = PROFILE + Profile::WORDS;
/// Place of the number of its materials in a record, counted from the object's.
pub const FINISH: usize = 3;
/// Place of the colours of cap, wall and bevel.
pub const COLORS: usize = 4;
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
    /// Returns its record, where `colors` are the linear RGB of cap, wall and bevel, and `finish` is
    /// the number of its materials less that of its object.
    pub fn record(&self, finish: u32, colors: [f32; 9]) -> [u32; RECORD] {
        let mut record = [0; RECORD];
        let numbers = [self.top, self.bottom, self.inverse_extent];
        let mut i = 0;
        while i < RECORD {
            record[i] = if i < FINISH {
                bits(numbers[i])
            } else if i == FINISH {
                finish
            } else if i < PROFILE {
                colors[i - COLORS].to_bits()
            } else {
                self.profile.words()[i - PROFILE]
            };
            i += 1;
        }
        record
    }

    /// Returns its own δ, 0…1.
    #[inline]
    pub fn own(&self, depth_fraction: Real) -> Real {
        clamp((depth_fraction - self.top) * self.inverse_extent, 0.0, 1.0)
    }

    /// Returns how far its side is from a point `distance` texels from its pattern, and how far its
    /// caps or undersides are if they are further, in texels: `slope` a unit of δ. The larger
    /// one is a distance to the layer. It is at most 0 inside.
    #[inline]
    pub fn faces(&self, slope: Real, distance: Real, depth_fraction: Real) -> (Real, Real) {
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
    pub slope: Real,
    /// Number of layers.
    pub count: u32,
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
    pub fn place(&self, index: u32) -> u32 {
        self.records + index * RECORD as u32
    }

    /// Returns layer `index`.
    #[inline]
    pub fn layer<T: Texels + ?Sized>(&self, texels: &T, index: u32) -> Layer {
        let place = self.place(index);
        let number = |i: u32| f32::from_bits(texels.word(place + i)) as Real;
        Layer {
            top: number(0),
            bottom: number(1),
            inverse_extent: number(2),
            profile: Profile::from_words(|i| texels.word(place + PROFILE as u32 + i)),
        }
    }

    /// Calls `see` with each layer of the stack around a point: its index, itself, the distance to
    /// its pattern in texels, and its [`Layer::faces`].
    #[inline]
    pub fn each<T: Texels + ?Sized>(
        &self,
        texels: &T,
        uv: Vec2,
        depth_fraction: Real,
        mut see: impl FnMut(u32, &Layer, Real, (Real, Real)),
    ) {
        let mut index = 0;
        while index < self.count {
            let layer = self.layer(texels, index);
            let distance = self.map.of_layer(index).distance(texels, uv);
            let faces = layer.faces(self.slope, distance, depth_fraction);
            see(index, &layer, distance, faces);
            index += 1;
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
        let see = |_, layer: &Layer, distance: Real, (beside, above): (Real, Real)| {
            clear = min(clear, distance - max(layer.profile.largest_radius(), 0.0));
            gap = min(gap, max(beside, above));
        };
        self.each(texels, uv, depth_fraction, see);
        (clear, gap)
    }

    /// Returns the layer that is nearest to a point, whether its nearest face is a cap or an
    /// underside, and whether it is on the growing part of its side if not.
    #[inline]
    pub fn nearest<T: Texels + ?Sized>(
        &self,
        texels: &T,
        uv: Vec2,
        depth_fraction: Real,
    ) -> (u32, bool, bool) {
        let mut least = FAR;
        let mut nearest = 0;
        let mut is_face = false;
        let mut is_growing = false;
        let see = |index, layer: &Layer, distance, (beside, above)| {
            let gap = max(beside, above);
            if gap < least {
                least = gap;
                nearest = index;
                is_face = above > beside;
                let own = layer.own(depth_fraction);
                is_growing = layer.profile.is_growing(own, || distance);
            }
        };
        self.each(texels, uv, depth_fraction, see);
        (nearest, is_face, is_growing)
    }
}
