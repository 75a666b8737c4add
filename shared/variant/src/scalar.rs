//! The operations on f32, in each mode.

use crate::Site;
use crate::audit;
use crate::mode::{Mode, Setting, setting};

/// An operation with two operands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operation {
    /// a + b
    Add,
    /// a − b
    Subtract,
    /// a · b
    Multiply,
    /// a / b
    Divide,
}

/// A product and the sum around it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sum {
    /// a · b + c
    Plus,
    /// a · b − c
    Minus,
    /// c − a · b
    From,
}

/// `operation` on `a` and `b`.
#[inline]
pub fn binary(operation: Operation, a: f32, b: f32, site: Site) -> f32 {
    binary_in(setting(), operation, a, b, site)
}

/// [`binary`] in a thread with this `setting`.
#[inline]
fn binary_in(setting: Setting, operation: Operation, a: f32, b: f32, site: Site) -> f32 {
    let result = match setting.mode {
        Mode::Exact | Mode::Fused => plain(operation, a, b),
        Mode::FlushToZero => flushed(plain(operation, flushed(a), flushed(b))),
        Mode::DivisionOff(ulps) if operation == Operation::Divide => {
            moved(a / b, ulps, a.to_bits(), b.to_bits())
        }
        Mode::DivisionOff(_) => plain(operation, a, b),
        Mode::TowardZero => toward_zero(operation, a, b),
    };
    if setting.is_audited {
        let (name, is_narrow) = match operation {
            Operation::Add => ("add", false),
            Operation::Subtract => ("subtract", false),
            Operation::Multiply => ("multiply", false),
            Operation::Divide => ("divide", true),
        };
        audit::look(name, &[a, b], result, is_narrow, site);
    }
    result
}

/// `a · b` and `c` summed up, fused where the mode says so.
#[inline]
pub fn multiply_add(sum: Sum, a: f32, b: f32, c: f32, site: Site) -> f32 {
    let setting = setting();
    if setting.mode == Mode::Fused {
        return match sum {
            Sum::Plus => a.mul_add(b, c),
            Sum::Minus => a.mul_add(b, -c),
            Sum::From => (-a).mul_add(b, c),
        };
    }
    let binary = |operation, a, b| binary_in(setting, operation, a, b, site);
    let product = binary(Operation::Multiply, a, b);
    match sum {
        Sum::Plus => binary(Operation::Add, product, c),
        Sum::Minus => binary(Operation::Subtract, product, c),
        Sum::From => binary(Operation::Subtract, c, product),
    }
}

/// √x.
#[inline]
pub fn sqrt(x: f32, site: Site) -> f32 {
    let setting = setting();
    let result = match setting.mode {
        Mode::Exact | Mode::Fused => x.sqrt(),
        Mode::FlushToZero => flushed(flushed(x).sqrt()),
        Mode::DivisionOff(ulps) => moved(x.sqrt(), ulps, x.to_bits(), 0),
        // In f64 the root is exact to more than twice the digits, so that it
        // is not rounded up to a number of f32.
        Mode::TowardZero => truncated(f64::from(x).sqrt(), 0.0),
    };
    if setting.is_audited {
        audit::look("sqrt", &[x], result, true, site);
    }
    result
}

#[inline]
fn plain(operation: Operation, a: f32, b: f32) -> f32 {
    match operation {
        Operation::Add => a + b,
        Operation::Subtract => a - b,
        Operation::Multiply => a * b,
        Operation::Divide => a / b,
    }
}

/// `x`, or the zero of its sign where it is denormal.
#[inline]
fn flushed(x: f32) -> f32 {
    if x.is_subnormal() {
        f32::from_bits(x.to_bits() & 0x8000_0000)
    } else {
        x
    }
}

/// `result` off by up to `ulps` representable numbers, which ones the operands' bits say.
#[inline]
fn moved(result: f32, ulps: u8, a: u32, b: u32) -> f32 {
    if !result.is_normal() {
        return result;
    }
    // The mixing function of splitmix64.
    let z = (u64::from(a) << 32 | u64::from(b)).wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    let z = z ^ (z >> 31);
    let choices = 2 * u64::from(ulps) + 1;
    let offset = (z % choices) as i32 - i32::from(ulps);
    f32::from_bits(result.to_bits().wrapping_add_signed(offset))
}

#[inline]
fn toward_zero(operation: Operation, a: f32, b: f32) -> f32 {
    let (x, y) = (f64::from(a), f64::from(b));
    match operation {
        Operation::Add => truncated_sum(x, y),
        Operation::Subtract => truncated_sum(x, -y),
        // 48 digits fit.
        Operation::Multiply => truncated(x * y, 0.0),
        // As for roots.
        Operation::Divide => truncated(x / y, 0.0),
    }
}

/// `x + y` rounded towards zero to f32.
#[inline]
fn truncated_sum(x: f64, y: f64) -> f32 {
    let sum = x + y;
    // What the sum in f64 has lost (Knuth's TwoSum).
    let of_y = sum - x;
    let rest = (x - (sum - of_y)) + (y - of_y);
    truncated(sum, rest)
}

/// `x + rest` rounded towards zero to f32, where `rest` is too small for f64 to show in `x`.
#[inline]
fn truncated(x: f64, rest: f64) -> f32 {
    let nearest = x as f32;
    let wide = f64::from(nearest);
    let is_beyond = wide.abs() > x.abs() || (wide == x && rest * x.signum() < 0.0);
    if is_beyond && nearest.is_finite() && nearest != 0.0 {
        // The next number towards zero: magnitudes and bits are in the same order.
        f32::from_bits(nearest.to_bits() - 1)
    } else if nearest.is_infinite() && x.is_finite() {
        f32::MAX.copysign(nearest)
    } else {
        nearest
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Problem, audited, with_mode};
    use Operation::{Add, Divide, Multiply, Subtract};

    #[test]
    fn fused_operations_round_once() {
        let x = 1.0 + f32::EPSILON;
        let square = x * x;
        let rest = f32::EPSILON * f32::EPSILON;
        let of = |sum, c| multiply_add(sum, x, x, c, "here");
        assert_eq!(of(Sum::Minus, square), 0.0);
        with_mode(Mode::Fused, || {
            assert_eq!(of(Sum::Minus, square), rest);
            assert_eq!(of(Sum::Plus, -square), rest);
            assert_eq!(of(Sum::From, square), -rest);
        });
        assert_eq!(of(Sum::Plus, 1.0), square + 1.0);
        assert_eq!(of(Sum::From, 5.0), 5.0 - square);
    }

    #[test]
    fn denormals_become_zeros_of_their_sign() {
        let small = f32::MIN_POSITIVE;
        assert_eq!(binary(Multiply, small, 0.5, "here"), 0.5 * small);
        with_mode(Mode::FlushToZero, || {
            assert_eq!(binary(Multiply, small, -0.5, "here").to_bits(), 1 << 31);
            assert_eq!(binary(Add, 0.5 * small, small, "here"), small);
            assert_eq!(sqrt(0.5 * small, "here"), 0.0);
            assert_eq!(binary(Subtract, 1.5 * small, 0.25, "here"), -0.25);
        });
    }

    #[test]
    fn divisions_are_off_by_all_that_is_allowed_and_no_more() {
        for ulps in [0, 3, 8] {
            let mut offsets = [Vec::new(), Vec::new()];
            for i in 1..2000 {
                let x = 1.0 + i as f32 / 4096.0;
                let found = with_mode(Mode::DivisionOff(ulps), || {
                    assert_eq!(binary(Multiply, x, x, "here"), x * x);
                    [binary(Divide, x, 1.4, "here"), sqrt(x, "here")]
                });
                for (i, right) in [x / 1.4, x.sqrt()].into_iter().enumerate() {
                    offsets[i].push(found[i].to_bits() as i32 - right.to_bits() as i32);
                }
            }
            for offsets in offsets {
                let bound = i32::from(ulps);
                assert_eq!(offsets.iter().min(), Some(&-bound));
                assert_eq!(offsets.iter().max(), Some(&bound));
            }
        }
    }

    #[test]
    fn results_are_cut_towards_zero() {
        let below_one = 1.0 - 0.5 * f32::EPSILON;
        let of = |operation, a, b| with_mode(Mode::TowardZero, || binary(operation, a, b, "here"));
        assert_eq!(of(Subtract, 1.0, 1e-30), below_one);
        assert_eq!(of(Add, -1.0, 1e-30), -below_one);
        assert_eq!(of(Add, 1.0, 1e-30), 1.0);
        assert_eq!(of(Add, 1.0, 0.99 * f32::EPSILON), 1.0);
        assert_eq!(of(Divide, 2.0, 3.0).to_bits(), (2.0f32 / 3.0).to_bits() - 1);
        assert_eq!(of(Divide, 1.0, 4.0), 0.25);
        assert_eq!(of(Multiply, f32::MAX, -2.0), -f32::MAX);
        assert_eq!(of(Subtract, 2.0, 2.0), 0.0);
        let root = with_mode(Mode::TowardZero, || sqrt(3.0, "here"));
        assert!(f64::from(root) < 3.0f64.sqrt() && root.next_up() >= 3.0f32.sqrt());
    }

    #[test]
    fn the_audit_counts_what_leaves_the_range() {
        let (result, findings) = audited(|| {
            binary(Add, 1e30, 1.0, "fine");
            binary(Multiply, 1e-30, 1e-10, "denormal");
            binary(Multiply, 1e-30, 0.0, "zero");
            crate::audit::called_at("caller", || {
                binary(Divide, 1.0, 0.0, "infinite");
                binary(Divide, 2.0, 0.0, "infinite");
                binary(Divide, 0.0, 0.0, "infinite");
            });
            binary(Divide, 1.0, 1e-18, "fine");
            binary(Divide, 1e19, 1e18, "range");
            sqrt(-1.0, "root")
        });
        assert!(result.is_nan());
        let found: Vec<_> = findings
            .iter()
            .map(|finding| (finding.site, finding.caller, finding.problem, finding.count))
            .collect();
        let caller = Some("caller");
        assert_eq!(
            found,
            [
                ("denormal", None, Problem::Denormal, 1),
                ("infinite", caller, Problem::NotANumber, 1),
                ("infinite", caller, Problem::Infinite, 2),
                ("range", None, Problem::OutOfRange, 1),
                ("root", None, Problem::NotANumber, 1),
            ]
        );
        assert_eq!(findings[2].example, "divide [1.0, 0.0] = inf");
        binary(Divide, 1.0, 0.0, "outside");
        assert!(audited(|| ()).1.is_empty());
    }
}
