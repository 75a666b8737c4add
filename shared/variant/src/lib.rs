//! The files of relievo-shared with every float operation replaceable: what
//! would break the exactness, on purpose.
//!
//! The build script reads the sources and writes them again with functions in
//! place of the operators `+ − × ÷`, of `libm::sqrtf` and of glam's products of
//! vectors. What these functions do is chosen at run time, for the calling
//! thread: see [`Mode`]. There are two trees of modules: [`native`], as
//! relievo-shared is compiled for the CPU, and [`corrected`], as it is compiled
//! for the exact shaders, with its feature of that name. Their structs are
//! laid out as relievo-shared's: convert with `bytemuck::cast`.
//!
//! ```text
//! with_mode(Mode::Fused, || native::fragment::meet(&frame, &object, &triangle, direction))
//! let (hit, findings) = audited(|| native::fragment::meet(&frame, &object, &triangle, direction));
//! ```
#![forbid(unsafe_code)]
// This crate replaces operations that the shared mathematics must not call.
#![allow(clippy::disallowed_methods)]

mod audit;
mod mode;
pub mod operations;
mod scalar;

pub use audit::{Finding, Problem, audited};
pub use mode::{Mode, with_mode};

/// Where an operation stands in the sources: "path.rs:97".
pub type Site = &'static str;

include!(concat!(env!("OUT_DIR"), "/trees.rs"));

#[cfg(test)]
mod tests {
    use super::*;

    /// Roots and quotients that are others than the CPU's where the estimates
    /// are off by `ulps`.
    fn wrong(ulps: u8) -> [usize; 2] {
        let numbers = (0..2000).map(|i| 1.5 + i as f32 / 5000.0);
        with_mode(Mode::DivisionOff(ulps), || {
            let mut wrong = [0; 2];
            for x in numbers {
                wrong[0] += usize::from(corrected::arithmetic::sqrt(x) != x.sqrt());
                wrong[1] += usize::from(native::arithmetic::div(x, 0.7) != x / 0.7);
            }
            wrong
        })
    }

    #[test]
    fn estimates_are_made_good_up_to_a_point() {
        let [roots, quotients] = wrong(8);
        assert!(roots == 0 && quotients > 1500, "{roots} {quotients}");
        let [roots, _] = wrong(255);
        assert!(roots > 500, "{roots}");
    }

    /// A number of 24 digits as one of f32 in 1…2.
    fn mantissa(digits: u64) -> f32 {
        assert!((1 << 23..1 << 24).contains(&digits));
        digits as f32 / (1 << 23) as f32
    }

    /// Nearly a number of 24 digits: here an estimate's last digit decides about
    /// the integer part of the residual's quotient, too.
    #[test]
    fn quotients_next_to_a_number_are_right_from_any_estimate() {
        let mut cases = 0;
        with_mode(Mode::DivisionOff(8), || {
            for i in 0..20_000 {
                let b: u64 = ((1 << 23) + 419 * i) | 1;
                for rest in (0..12).chain(b - 12..b) {
                    // rest / 2^23 and rest / 2^24 modulo b.
                    let halved = |x: u64| (x + b * (x & 1)) / 2;
                    let above = (0..23).fold(rest, |x, _| halved(x));
                    let below = halved(above);
                    for a in [above + b, below] {
                        if !(1 << 23..1 << 24).contains(&a) {
                            continue;
                        }
                        cases += 1;
                        let (a, b) = (mantissa(a), mantissa(b));
                        assert_eq!(corrected::arithmetic::div(a, b), a / b, "{a:?} / {b:?}");
                    }
                }
            }
        });
        assert!(cases > 200_000, "{cases}");
    }

    #[test]
    fn roots_next_to_a_number_are_right_from_any_estimate() {
        let mut cases = 0;
        with_mode(Mode::DivisionOff(8), || {
            for root in 1_u64 << 23..1 << 24 {
                // Of 47 digits: an even power of two; of 48: an odd one.
                let shift = 23 + ((root * root) >> 47);
                let above = root * root + 12;
                let (digits, rest) = (above >> shift, above & ((1 << shift) - 1));
                if rest > 24 || digits >= 1 << 24 {
                    continue;
                }
                cases += 1;
                let x = mantissa(digits) * (1 << (shift - 23)) as f32;
                assert_eq!(corrected::arithmetic::sqrt(x), x.sqrt(), "√{x:?}");
            }
        });
        assert!(cases > 300, "{cases}");
    }
}
