//! The functions of relievo-exact with broken operations: what is seen, and what is made
//! good.

use glam::Vec2;
use relievo_shared_variant::{Mode, corrected, native, with_mode};

type Function = fn(f32, f32) -> f32;

/// A function, and itself with replaceable operations, of the CPU and of exact shaders.
struct Twin {
    name: &'static str,
    right: Function,
    native: Function,
    corrected: Function,
    /// Whether it shows that products and sums are fused.
    fuses: bool,
    /// Whether it shows that the device's quotients and roots are off.
    divides: bool,
}

macro_rules! twins {
    ($($name:ident($($argument:ident),*) $fuses:literal $divides:literal;)*) => {
        [$(Twin {
            name: stringify!($name),
            right: |x, y| { let _ = y; relievo_exact::$name($(twins!(@ $argument x y)),*) },
            native: |x, y| { let _ = y; native::exact::$name($(twins!(@ $argument x y)),*) },
            corrected: |x, y| { let _ = y; corrected::exact::$name($(twins!(@ $argument x y)),*) },
            fuses: $fuses,
            divides: $divides,
        }),*]
    };
    (@ both $x:ident $y:ident) => { Vec2::new($x, $y) };
    (@ first $x:ident $y:ident) => { $x };
    (@ second $x:ident $y:ident) => { $y };
}

const TWINS: [Twin; 21] = twins! {
    div(first, second) false true;
    sqrt(first) false true;
    recip_sqrt(first) false true;
    exp(first) true false;
    exp2(first) true false;
    log(first) true false;
    log2(first) true false;
    pow(first, second) true false;
    sin(first) true false;
    cos(first) true false;
    tan(first) true true;
    asin(first) true true;
    acos(first) true true;
    atan(first) true true;
    atan2(first, second) true true;
    trunc(first) false false;
    floor(first) false false;
    ceil(first) false false;
    round(first) false false;
    fract(first) false false;
    length(both) true true;
};

const INPUTS: u32 = 100_000;

/// The argument `i`: of any bits, of a moderate magnitude, or in −1…1.
fn argument(i: u32) -> f32 {
    let bits = i.wrapping_mul(0x9e37_79b1);
    f32::from_bits(match i % 3 {
        0 => bits,
        1 => bits & 0x807f_ffff | (120 + (bits >> 8) % 14) << 23,
        _ => bits & 0x80ff_ffff | 0x3e80_0000,
    })
}

/// Returns how many results of `function` differ from those of `right`.
fn different(right: Function, function: Function, mode: Mode) -> usize {
    with_mode(mode, || {
        let pairs = (0..INPUTS).map(|i| (argument(i), argument(i ^ 0x5555)));
        let words = |x: f32| if x == 0.0 { 0 } else { x.to_bits() };
        pairs
            .filter(|&(x, y)| words(right(x, y)) != words(function(x, y)))
            .count()
    })
}

/// Calls `check` with what each function gives in `mode`: different results on the CPU
/// and in exact shaders.
fn in_mode(mode: Mode, check: impl Fn(&Twin, usize, usize)) {
    for twin in &TWINS {
        let native = different(twin.right, twin.native, mode);
        check(twin, native, different(twin.right, twin.corrected, mode));
    }
}

#[test]
fn the_same_operations_give_the_same_results() {
    in_mode(Mode::Exact, |twin, native, corrected| {
        assert_eq!((native, corrected), (0, 0), "{}", twin.name);
    });
}

#[test]
fn fused_operations_are_seen() {
    in_mode(Mode::Fused, |twin, native, corrected| {
        let seen = native > 0 && corrected > 0;
        assert_eq!(seen, twin.fuses, "{}: {native}, {corrected}", twin.name);
    });
}

#[test]
fn another_rounding_is_seen() {
    in_mode(Mode::TowardZero, |twin, native, corrected| {
        let rounds = twin.fuses || twin.name == "fract";
        let seen = native > 0 && corrected > 0;
        // The corrected quotient and root come from whole numbers.
        let seen = seen || (twin.divides && native > 0);
        assert_eq!(
            seen,
            rounds || twin.divides,
            "{}: {native}, {corrected}",
            twin.name
        );
    });
}

#[test]
fn estimates_of_quotients_and_roots_are_made_good() {
    in_mode(Mode::DivisionOff(8), |twin, native, corrected| {
        assert_eq!(corrected, 0, "{}", twin.name);
        assert_eq!(native > 0, twin.divides, "{}: {native}", twin.name);
    });
}

#[test]
fn flushed_numbers_change_nothing() {
    in_mode(Mode::FlushToZero, |twin, native, corrected| {
        assert_eq!((native, corrected), (0, 0), "{}", twin.name);
    });
}
