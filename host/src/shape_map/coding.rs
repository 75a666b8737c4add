//! How a signed distance becomes a texel, and back.
//!
//! Source: algorithm.md, section 3.

use super::Storage;
use serde::{Deserialize, Serialize};

/// What turns texels into distances; the fields are those of the description
/// in a file, and each storage gives a meaning to some of them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Coding {
    pub(super) storage: Storage,
    /// R8, R16: the code that stands for distance 0. Else 0.
    pub(super) bias: u32,
    /// Texels (of length) per unit of the code, or of Rgba8's blue channel. R32F: 0.
    pub(super) step: f32,
    /// Rgba8: f of equation (5). Else 1.
    pub(super) scale: f32,
    /// Whether values were out of range.
    pub(super) saturated: bool,
}

/// Bits of an Rgba8 step's significand, of f32's 24: the other 8 are left to the
/// blue channel, so that their product is exact.
const STEP_BITS: u32 = 16;

impl Coding {
    /// The coding for distances in `min`…`max` (texels).
    pub(super) fn choose(storage: Storage, scale: f32, min: f32, max: f32) -> Self {
        match storage {
            Storage::R8 => Self::choose_codes(storage, 0.5, min, max),
            Storage::R16 => Self::choose_codes(storage, 1.0 / 32.0, min, max),
            Storage::R32F => Self {
                storage,
                bias: 0,
                step: 0.0,
                scale: 1.0,
                saturated: false,
            },
            Storage::Rgba8 => Self {
                storage,
                bias: 0,
                step: rgba8_step(scale, f64::from(max)),
                scale,
                saturated: scale < 1.0,
            },
        }
    }

    /// The finest fixed-point codes that hold all of `min`…`max`, or else the
    /// coarsest allowed, with at most half of the codes under zero.
    fn choose_codes(storage: Storage, coarsest_step: f64, min: f32, max: f32) -> Self {
        let mut step = 1.0 / 256.0;
        loop {
            // Conversion to an integer turns negative counts into 0.
            let below = -(f64::from(min) / step).floor() as u64;
            let above = (f64::from(max) / step).floor() as u64;
            let fits = below + above < 1 << storage.bits();
            if fits || step >= coarsest_step {
                let half = 1 << (storage.bits() - 1);
                return Self {
                    storage,
                    bias: if fits { below } else { below.min(half) } as u32,
                    step: step as f32,
                    scale: 1.0,
                    saturated: !fits,
                };
            }
            step *= 2.0;
        }
    }

    /// The fixed-point code of a distance: rounded down, and saturated.
    pub(super) fn encode_code(self, distance: f32) -> u32 {
        let units = (f64::from(distance) / f64::from(self.step)).floor();
        let largest = f64::from(largest_code(self.storage));
        (units + f64::from(self.bias)).clamp(0.0, largest) as u32
    }

    /// Rgba8's blue channel for a distance to the nearest centre of the
    /// pattern: rounded down, and saturated.
    pub(super) fn encode_blue(self, pattern_distance: f64) -> u32 {
        (pattern_distance / f64::from(self.step)).min(255.0) as u32
    }

    /// The signed distance that a texel stands for.
    pub(super) fn decode(self, texel: u32) -> f32 {
        match self.storage {
            Storage::R8 | Storage::R16 => {
                (i64::from(texel) - i64::from(self.bias)) as f32 * self.step
            }
            Storage::R32F => f32::from_bits(texel),
            Storage::Rgba8 => match texel.to_le_bytes() {
                [_, _, _, 0] => -0.5,
                // What is not pattern is at least a texel away from its centres.
                [_, _, blue, _] => (f32::from(blue) * self.step - 0.5).max(0.5),
            },
        }
    }

    /// Checks what was read from a file.
    pub(super) fn check(&self) -> Result<(), String> {
        let Self {
            storage,
            bias,
            step,
            scale,
            saturated,
        } = *self;
        // Within these bounds every distance is a normal number.
        let significand = step.to_bits() & ((1 << (f32::MANTISSA_DIGITS - 1)) - 1);
        let fits = match storage {
            Storage::R8 | Storage::R16 => {
                significand == 0 && (1.0 / 65536.0..=65536.0).contains(&step)
            }
            Storage::R32F => step == 0.0,
            Storage::Rgba8 => {
                let spare = f32::MANTISSA_DIGITS - STEP_BITS;
                significand.trailing_zeros() >= spare
                    && (f32::MIN_POSITIVE..=65536.0).contains(&step)
            }
        };
        if !fits {
            return Err(format!("step {step} does not fit {storage}"));
        }
        let largest_bias = match storage {
            Storage::R8 | Storage::R16 => largest_code(storage),
            Storage::R32F | Storage::Rgba8 => 0,
        };
        if bias > largest_bias {
            return Err(format!("bias {bias} does not fit {storage}"));
        }
        let fits = match storage {
            Storage::Rgba8 => scale > 0.0 && scale <= 1.0,
            Storage::R8 | Storage::R16 | Storage::R32F => scale == 1.0,
        };
        if !fits {
            return Err(format!("scale {scale} does not fit {storage}"));
        }
        let fits = match storage {
            Storage::Rgba8 => saturated == (scale < 1.0),
            Storage::R32F => !saturated,
            Storage::R8 | Storage::R16 => true,
        };
        if !fits {
            return Err(format!("saturated = {saturated} does not fit {storage}"));
        }
        Ok(())
    }
}

/// The largest fixed-point code.
pub(super) const fn largest_code(storage: Storage) -> u32 {
    u32::MAX >> (32 - storage.bits())
}

/// f · max(EDT) / 255, rounded down to [`STEP_BITS`] bits: the product with an
/// 8-bit integer is exact in f32, fused or not, and the largest distance gets
/// the code 255. A full pattern has no distances; its step is 1.
fn rgba8_step(scale: f32, largest_distance: f64) -> f32 {
    if largest_distance <= 0.0 {
        return 1.0;
    }
    let exact = f64::from(scale) * largest_distance / 255.0;
    let dropped = f64::MANTISSA_DIGITS - STEP_BITS;
    let rounded = f64::from_bits(exact.to_bits() >> dropped << dropped);
    (rounded as f32).max(f32::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_step_is_the_finest_that_fits() {
        let step = |storage, min, max| Coding::choose(storage, 1.0, min, max).step;
        // 256 codes: −128…127 of 2⁻⁸ just fit.
        assert_eq!(step(Storage::R8, -0.5, 0.499), 1.0 / 256.0);
        assert_eq!(step(Storage::R8, -0.5, 0.5), 1.0 / 128.0);
        assert_eq!(step(Storage::R16, -100.0, 155.9), 1.0 / 256.0);
        assert_eq!(step(Storage::R16, -100.0, 156.0), 1.0 / 128.0);
        assert_eq!(step(Storage::R16, -0.5, 5000.0), 1.0 / 32.0);
        assert_eq!(step(Storage::R32F, -0.5, 5000.0), 0.0);
    }

    #[test]
    fn the_papers_step_is_the_scaled_largest_distance_over_255() {
        for scale in [1.0, 0.7, 0.01, f32::MIN_POSITIVE] {
            for largest in [1.0, 2f64.sqrt(), 255.0, 181.02, 30_000.3] {
                let step = rgba8_step(scale, largest);
                let exact = f64::from(scale) * largest / 255.0;
                let ratio = f64::from(step) / exact;
                assert!(step.is_normal());
                if scale > 0.001 {
                    assert!(ratio <= 1.0 && ratio > 1.0 - 1.0 / 32768.0, "{ratio}");
                }
                let coding = Coding::choose(Storage::Rgba8, scale, -0.5, largest as f32);
                assert_eq!(coding.encode_blue(largest), 255);
                assert_eq!(coding.check(), Ok(()));
                for blue in [1u8, 77, 171, 255] {
                    let product = f64::from(blue) * f64::from(step);
                    assert_eq!(f64::from(f32::from(blue) * step), product);
                }
            }
        }
        assert_eq!(rgba8_step(0.5, 0.0), 1.0);
    }
}
