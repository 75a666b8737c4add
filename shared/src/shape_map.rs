//! The shape map: the signed distance to the pattern, from stored codes.

use crate::arithmetic::{div, floor, floor_to_int, max};
use crate::layout::{FORMAT_CODES, FORMAT_FLOAT, FORMAT_PAPER, Object, vec2};
use crate::profile::Profile;
use crate::{Real, Vec2};

/// Storage of the codes of a map: a storage buffer, a slice.
pub trait Texels {
    /// Whether the words are those of a [`stack`](crate::stack) of layers.
    const IS_STACK: bool = false;

    /// Returns the 32-bit word `index`.
    fn word(&self, index: u32) -> u32;
}

impl Texels for [u32] {
    #[inline]
    fn word(&self, index: u32) -> u32 {
        self[index as usize]
    }
}

impl<T: Texels + ?Sized> Texels for &T {
    const IS_STACK: bool = T::IS_STACK;

    #[inline]
    fn word(&self, index: u32) -> u32 {
        (**self).word(index)
    }
}

/// Size and encoding of a map.
#[derive(Clone, Copy, Debug)]
pub struct ShapeMap {
    /// Width and height, texels.
    pub size: Vec2,
    last_x: i32,
    last_y: i32,
    /// Number of its first texel.
    first: i32,
    /// Step lengths that cannot skip the pattern.
    pub safe: SafeStep,
    gradient_offset: Vec2,
    gradient_scale: Real,
    step: Real,
    format: u32,
    bias: i32,
    packing: u32,
    lane_mask: u32,
    lane_shift: u32,
    code_mask: u32,
}

/// The four texels around a point, and the fractions between them.
#[derive(Clone, Copy)]
struct Taps {
    x0: i32,
    x1: i32,
    y0: i32,
    y1: i32,
    fx: Real,
    fy: Real,
}

impl Taps {
    /// Interpolates the four texels' values bilinearly.
    #[inline]
    fn mix(&self, v00: Real, v10: Real, v01: Real, v11: Real) -> Real {
        let upper = v00 + (v10 - v00) * self.fx;
        let lower = v01 + (v11 - v01) * self.fx;
        upper + (lower - upper) * self.fy
    }
}

impl ShapeMap {
    /// Returns the map of the [complete](Object::complete) `object`.
    #[inline]
    pub fn new(object: &Object) -> ShapeMap {
        let packing = object.map_packing;
        let code_bits = 32 >> packing;
        ShapeMap {
            size: Vec2::new(object.map_size[0], object.map_size[1]),
            last_x: object.map_size[0] as i32 - 1,
            last_y: object.map_size[1] as i32 - 1,
            first: 0,
            safe: SafeStep {
                steepest: SQRT_2 * (1.0 + object.map_quantum),
                margin: MARGIN + object.map_quantum,
            },
            gradient_offset: vec2(object.quotients.gradient_offset),
            gradient_scale: object.quotients.gradient_scale,
            step: object.map_step,
            format: object.map_format,
            bias: object.map_bias as i32,
            packing,
            lane_mask: (1 << packing) - 1,
            lane_shift: 5 - packing,
            code_mask: if code_bits == 32 {
                0xffff_ffff
            } else {
                (1 << code_bits) - 1
            },
        }
    }

    /// Returns the map of layer `index` of a stack.
    #[inline]
    pub fn of_layer(&self, index: u32) -> ShapeMap {
        ShapeMap {
            first: index as i32 * self.texels(),
            ..*self
        }
    }

    /// Returns the number of words that hold the maps of `count` layers.
    #[inline]
    pub fn words(&self, count: u32) -> u32 {
        (count * self.texels() as u32 + self.lane_mask) >> self.packing
    }

    /// Returns the number of texels.
    #[inline]
    fn texels(&self) -> i32 {
        (self.last_x + 1) * (self.last_y + 1)
    }

    /// Returns the stored code of one texel; `x` and `y` inside the map.
    #[inline]
    fn code<T: Texels + ?Sized>(&self, texels: &T, x: i32, y: i32) -> u32 {
        let index = (self.first + y * (self.last_x + 1) + x) as u32;
        let word = texels.word(index >> self.packing);
        (word >> ((index & self.lane_mask) << self.lane_shift)) & self.code_mask
    }

    /// Returns the stored distance of one texel, texels; `x` and `y` inside the map.
    #[inline]
    fn texel<T: Texels + ?Sized>(&self, texels: &T, x: i32, y: i32) -> Real {
        let code = self.code(texels, x, y);
        if self.format == FORMAT_CODES {
            (code as i32 - self.bias) as Real * self.step
        } else if self.format == FORMAT_FLOAT {
            f32::from_bits(code) as Real
        } else if code >> 24 == 0 {
            // The paper's form has no distances inside the pattern.
            -0.5
        } else {
            // B is the distance to the centre of the nearest pattern pixel, at least
            // one texel.
            max(((code >> 16) & 255) as i32 as Real * self.step - 0.5, 0.5)
        }
    }

    /// Returns the normal stored in the paper's form, components −1…1.
    #[inline]
    fn stored_normal<T: Texels + ?Sized>(&self, texels: &T, x: i32, y: i32) -> Vec2 {
        const STEP: Real = 2.0 / 255.0;
        let code = self.code(texels, x, y);
        Vec2::new(
            (code & 255) as i32 as Real - 127.5,
            ((code >> 8) & 255) as i32 as Real - 127.5,
        ) * STEP
    }

    /// Returns the four texels around `uv` (repeats) and the fractions between them.
    #[inline]
    fn taps(&self, uv: Vec2) -> Taps {
        let x = (uv.x - floor(uv.x)) * self.size.x - 0.5;
        let y = (uv.y - floor(uv.y)) * self.size.y - 0.5;
        let (left, top) = (floor_to_int(x), floor_to_int(y));
        let (x0, x1) = neighbours(left, self.last_x);
        let (y0, y1) = neighbours(top, self.last_y);
        Taps {
            x0,
            x1,
            y0,
            y1,
            fx: x - left as Real,
            fy: y - top as Real,
        }
    }

    /// Returns the signed distance at `uv` (repeats), texels: positive outside the
    /// pattern. Bilinear between the four nearest texel centres, in code, since a
    /// hardware filter may use as few as 8 bits of the fractions.
    #[inline]
    pub fn distance<T: Texels + ?Sized>(&self, texels: &T, uv: Vec2) -> Real {
        let taps = self.taps(uv);
        let d00 = self.texel(texels, taps.x0, taps.y0);
        let d10 = self.texel(texels, taps.x1, taps.y0);
        let d01 = self.texel(texels, taps.x0, taps.y1);
        let d11 = self.texel(texels, taps.x1, taps.y1);
        taps.mix(d00, d10, d01, d11)
    }

    /// Returns the depth map of relief mapping at `uv`: the depth fraction at which the
    /// pattern grown by `profile` becomes solid, bilinear between texels like a depth
    /// texture.
    #[inline]
    pub fn relief_depth<T: Texels + ?Sized>(
        &self,
        texels: &T,
        profile: &Profile,
        uv: Vec2,
    ) -> Real {
        let taps = self.taps(uv);
        let d00 = profile.depth_of(self.texel(texels, taps.x0, taps.y0));
        let d10 = profile.depth_of(self.texel(texels, taps.x1, taps.y0));
        let d01 = profile.depth_of(self.texel(texels, taps.x0, taps.y1));
        let d11 = profile.depth_of(self.texel(texels, taps.x1, taps.y1));
        taps.mix(d00, d10, d01, d11)
    }

    /// Returns the gradient of the distance at `uv`, texels per texel, by central
    /// differences over the object's `map_reach` on each side: the bilinear surface
    /// has a crease at every texel, and the outline of a binary pattern is a staircase.
    ///
    /// The paper's form stores normals instead, since its distances are too coarse.
    #[inline]
    pub fn gradient<T: Texels + ?Sized>(&self, texels: &T, uv: Vec2) -> Vec2 {
        if self.format == FORMAT_PAPER {
            let taps = self.taps(uv);
            let n00 = self.stored_normal(texels, taps.x0, taps.y0);
            let n10 = self.stored_normal(texels, taps.x1, taps.y0);
            let n01 = self.stored_normal(texels, taps.x0, taps.y1);
            let n11 = self.stored_normal(texels, taps.x1, taps.y1);
            return Vec2::new(
                taps.mix(n00.x, n10.x, n01.x, n11.x),
                taps.mix(n00.y, n10.y, n01.y, n11.y),
            );
        }
        let mut before = 0.0;
        let mut along_u = 0.0;
        let mut along_v = 0.0;
        // Right, left, below and above: a loop, since four calls would inline
        // `distance` four times.
        let mut side = 0;
        while side < 4 {
            let offset = if side < 2 {
                Vec2::new(self.gradient_offset.x, 0.0)
            } else {
                Vec2::new(0.0, self.gradient_offset.y)
            };
            let is_first = side & 1 == 0;
            let distance = self.distance(texels, if is_first { uv + offset } else { uv - offset });
            if is_first {
                before = distance;
            } else if side == 1 {
                along_u = before - distance;
            } else {
                along_v = before - distance;
            }
            side += 1;
        }
        Vec2::new(along_u, along_v) * self.gradient_scale
    }
}

/// Returns the texel `i` and the next one, wrapped into 0…`last`; `i` is −1…`last`.
/// The comparison with `last` keeps a NaN of the caller inside the map.
#[inline]
fn neighbours(i: i32, last: i32) -> (i32, i32) {
    let first = if i < 0 || i > last { last } else { i };
    let second = if first == last { 0 } else { first + 1 };
    (first, second)
}

/// Bounds of the displacement, texels, within which the interpolated distance cannot
/// fall to a radius (section 3).
///
/// Bilinear interpolation of 1-Lipschitz samples is √2-Lipschitz, and rounding down to
/// steps adds a step to the difference of two samples. By Jensen's inequality a point with
/// the interpolated distance f is at least √((f + ½)² − ½) − ½ − √½ from the pattern's
/// edge; that is no less than f − 0.8365 for f ≥ 1.5, which needs no root in the loop.
#[derive(Clone, Copy, Debug)]
pub struct SafeStep {
    /// Largest slope of the interpolated field: the gap over it is safe.
    pub steepest: Real,
    /// The gap less this is safe, too, for distances from 1.5 texels on.
    pub margin: Real,
}

/// [`SafeStep::margin`] of a map that stores true distances, texels.
const MARGIN: Real = 0.8365;

/// Sets the quotients of `object` that its map uses.
#[inline]
pub(crate) fn set_quotients(object: &mut Object) {
    let [width, height] = object.map_size;
    let reach = object.map_reach;
    object.quotients.gradient_offset = [div(reach, width), div(reach, height)];
    object.quotients.gradient_scale = div(0.5, reach);
}

/// √2, as a literal: a cast from f64 would need 64-bit floats in the shader.
#[allow(clippy::excessive_precision, clippy::approx_constant)]
const SQRT_2: Real = 1.414_213_562_373_095_1;

#[cfg(test)]
#[allow(clippy::disallowed_methods)] // References are computed in f64, by the standard library.
pub(crate) mod tests;
