//! The shape map: signed distance to the pattern, from stored codes.

use crate::arithmetic::{div, floor, floor_to_int, max};
use crate::layout::Object;
use crate::{Real, Vec2};

/// Where the codes of a map lie: a storage buffer, a slice.
pub trait Texels {
    /// The 32-bit word number `index`.
    fn word(&self, index: u32) -> u32;
}

impl Texels for [u32] {
    #[inline]
    fn word(&self, index: u32) -> u32 {
        self[index as usize]
    }
}

/// How to read a map: its size and its code.
#[derive(Clone, Copy, Debug)]
pub struct ShapeMap {
    /// Width and height, texels.
    pub size: Vec2,
    last_x: i32,
    last_y: i32,
    /// Texels per step of the code.
    pub step: Real,
    bias: i32,
    packing: u32,
    lane_mask: u32,
    lane_shift: u32,
    code_mask: u32,
}

impl ShapeMap {
    /// The map of `object`.
    #[inline]
    pub fn new(object: &Object) -> ShapeMap {
        let packing = object.map_packing;
        let code_bits = 32 >> packing;
        ShapeMap {
            size: Vec2::new(object.map_size[0], object.map_size[1]),
            last_x: object.map_size[0] as i32 - 1,
            last_y: object.map_size[1] as i32 - 1,
            step: object.map_step,
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

    /// The stored distance of one texel, in texels; `x` and `y` inside the map.
    #[inline]
    fn texel<T: Texels + ?Sized>(&self, texels: &T, x: i32, y: i32) -> Real {
        let index = (y * (self.last_x + 1) + x) as u32;
        let word = texels.word(index >> self.packing);
        let code = (word >> ((index & self.lane_mask) << self.lane_shift)) & self.code_mask;
        (code as i32 - self.bias) as Real * self.step
    }

    /// The signed distance at `uv` (repeats), in texels: positive outside the
    /// pattern. Bilinear between the four nearest texel centres, by hand, since
    /// a hardware filter may keep as few as 8 bits of the fractions.
    #[inline]
    pub fn distance<T: Texels + ?Sized>(&self, texels: &T, uv: Vec2) -> Real {
        let x = (uv.x - floor(uv.x)) * self.size.x - 0.5;
        let y = (uv.y - floor(uv.y)) * self.size.y - 0.5;
        let (left, top) = (floor_to_int(x), floor_to_int(y));
        let (fx, fy) = (x - left as Real, y - top as Real);
        let (x0, x1) = neighbours(left, self.last_x);
        let (y0, y1) = neighbours(top, self.last_y);
        let d00 = self.texel(texels, x0, y0);
        let d10 = self.texel(texels, x1, y0);
        let d01 = self.texel(texels, x0, y1);
        let d11 = self.texel(texels, x1, y1);
        let upper = d00 + (d10 - d00) * fx;
        let lower = d01 + (d11 - d01) * fx;
        upper + (lower - upper) * fy
    }

    /// The gradient of the distance at `uv`, texels per texel, by central
    /// differences over [`GRADIENT_REACH`] texels on each side: the bilinear
    /// surface itself has a crease at every texel, and the outline of a binary
    /// pattern is a staircase.
    #[inline]
    pub fn gradient<T: Texels + ?Sized>(&self, texels: &T, uv: Vec2) -> Vec2 {
        let dx = Vec2::new(div(GRADIENT_REACH, self.size.x), 0.0);
        let dy = Vec2::new(0.0, div(GRADIENT_REACH, self.size.y));
        Vec2::new(
            self.distance(texels, uv + dx) - self.distance(texels, uv - dx),
            self.distance(texels, uv + dy) - self.distance(texels, uv - dy),
        ) * (0.5 / GRADIENT_REACH)
    }
}

/// Half the span of the differences that make a gradient, texels: a power of two.
pub const GRADIENT_REACH: Real = 2.0;

/// The texel `i` and the next one, wrapped into 0…`last`; `i` is −1…`last`
/// (the clamp keeps a NaN of the caller inside the map).
#[inline]
fn neighbours(i: i32, last: i32) -> (i32, i32) {
    let first = if i < 0 || i > last { last } else { i };
    let second = if first == last { 0 } else { first + 1 };
    (first, second)
}

/// A displacement, in texels, within which the interpolated distance cannot
/// sink from `distance` to `radius` (section 3).
#[derive(Clone, Copy, Debug)]
pub struct SafeStep {
    /// 1 / (the steepest slope of the interpolated field): its share of the gap is safe.
    pub lipschitz: Real,
    /// The gap less this is safe too.
    pub margin: Real,
}

impl SafeStep {
    /// The bounds of a map whose code has steps of `step` texels.
    ///
    /// Bilinear interpolation of 1-Lipschitz samples is √2-Lipschitz, and
    /// rounding down to steps adds a step to the difference of two samples. By
    /// Jensen's inequality a point with the interpolated distance f is at least
    /// √((f + ½)² − ½) − ½ − √½ from the pattern's edge; that is no less than
    /// f − 0.8365 for f ≥ 1.5, which needs no root in the loop.
    #[inline]
    pub fn new(step: Real) -> SafeStep {
        SafeStep {
            lipschitz: div(SQRT_HALF, 1.0 + step),
            margin: 0.8365 + step,
        }
    }

    /// The safe displacement for a fixed radius, texels, ≥ 0.
    #[inline]
    pub fn at_fixed_radius(&self, distance: Real, radius: Real) -> Real {
        let gap = distance - radius;
        let near = gap * self.lipschitz;
        let far = if distance >= 1.5 {
            gap - self.margin
        } else {
            0.0
        };
        max(max(near, far), 0.0)
    }
}

/// √½, as a literal: a cast from f64 would need 64-bit floats in the shader.
#[allow(clippy::excessive_precision, clippy::approx_constant)]
const SQRT_HALF: Real = 0.707_106_781_186_547_5;
