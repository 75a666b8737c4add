//! The error of every function against correct rounding.
//!
//! `cargo test --release -p relievo-exact --test bounds -- --ignored --nocapture` tries
//! every f32, and 10⁹ pairs for functions of two arguments; it prints the table of
//! `docs/exact.md`.
#![allow(clippy::disallowed_methods)] // The standard library's f64 is the reference.

use relievo_exact::*;
use std::thread;

/// A function of one argument, and the same in f64.
struct One {
    name: &'static str,
    function: fn(f32) -> f32,
    reference: fn(f64) -> f64,
    bound: f64,
}

/// A function of two arguments, and the same in f64.
struct Two {
    name: &'static str,
    function: fn(f32, f32) -> f32,
    reference: fn(f64, f64) -> f64,
    bound: f64,
}

/// Rounded correctly, whatever the reference's last digit.
const CORRECT: f64 = 0.500_001;

const fn one(
    name: &'static str,
    function: fn(f32) -> f32,
    reference: fn(f64) -> f64,
    bound: f64,
) -> One {
    One {
        name,
        function,
        reference,
        bound,
    }
}

const ONES: [One; 18] = [
    one("sqrt", sqrt, |x| x.max(0.0).sqrt(), CORRECT),
    // The sign of the larger zero is not specified.
    one(
        "recip_sqrt",
        recip_sqrt,
        |x| 1.0 / x.max(0.0).sqrt().abs(),
        1.0,
    ),
    one("exp", exp, f64::exp, 1.0),
    one("exp2", exp2, f64::exp2, 1.0),
    one("log", log, |x| x.max(0.0).ln(), 1.0),
    one("log2", log2, |x| x.max(0.0).log2(), 1.0),
    one("sin", sin, f64::sin, 1.0),
    one("cos", cos, f64::cos, 1.0),
    one("tan", tan, f64::tan, 1.0),
    one("asin", asin, |x| x.clamp(-1.0, 1.0).asin(), 1.0),
    one("acos", acos, |x| x.clamp(-1.0, 1.0).acos(), 1.0),
    one("atan", atan, f64::atan, 1.0),
    one("trunc", trunc, f64::trunc, CORRECT),
    one("floor", floor, f64::floor, CORRECT),
    one("ceil", ceil, f64::ceil, CORRECT),
    one("round", round, f64::round, CORRECT),
    one(
        "fract",
        fract,
        |x| (x - x.floor()).min(1.0 - 2.0_f64.powi(-24)),
        CORRECT,
    ),
    one(
        "x^2.4",
        |x| pow(x, 2.4),
        |x| x.max(0.0).powf(f64::from(2.4_f32)),
        2.0,
    ),
];

const TWOS: [Two; 3] = [
    Two {
        name: "div",
        function: div,
        reference: |a, b| if a == 0.0 { 0.0 } else { a / b },
        bound: CORRECT,
    },
    Two {
        name: "atan2",
        function: atan2,
        // The sign of a zero has no meaning.
        reference: |y, x| (y + 0.0).atan2(x + 0.0),
        bound: 2.0,
    },
    Two {
        name: "pow",
        function: pow,
        reference: |x, y| x.max(0.0).powf(y),
        bound: 2.0,
    },
];

/// The largest error, ULP, and the arguments where it is.
#[derive(Clone, Copy, Debug, Default)]
struct Worst {
    error: f64,
    at: [f32; 2],
}

impl Worst {
    fn or(self, other: Worst) -> Worst {
        if other.error > self.error {
            other
        } else {
            self
        }
    }

    /// Adds a result, and what it should be.
    fn add(&mut self, at: [f32; 2], found: f32, exact: f64) {
        assert!(found == 0.0 || found.is_normal(), "{at:?}: {found:e}");
        let error = error(found, exact);
        if error > self.error {
            *self = Worst { error, at };
        }
    }
}

/// Returns the error of `found`, in units in the last place of the f32 below `exact`.
fn error(found: f32, exact: f64) -> f64 {
    let largest = f64::from(f32::MAX);
    // Results that are not normal numbers saturate; a result just above may be one of them.
    if exact.abs() < f64::from(f32::MIN_POSITIVE) {
        let smallest = found == 0.0 || found.abs() == f32::MIN_POSITIVE && exact != 0.0;
        return if smallest { 0.0 } else { f64::INFINITY };
    }
    if exact.abs() > largest {
        return if found == f32::MAX.copysign(exact as f32) {
            0.0
        } else {
            f64::INFINITY
        };
    }
    let exponent = (exact.abs().to_bits() >> 52) as i32 - 1023;
    let unit = f64::from_bits(((exponent - 23 + 1023) as u64) << 52);
    (f64::from(found) - exact).abs() / unit
}

/// Returns the worst of the numbers with every `stride`-th pattern of bits, those of all
/// classes included.
fn worst_of_one(function: &One, stride: u64) -> Worst {
    let parts = thread::available_parallelism().map_or(1, usize::from) as u64;
    let part = |part: u64| {
        let mut worst = Worst::default();
        let mut bits = part * stride;
        while bits <= u64::from(u32::MAX) {
            let x = f32::from_bits(bits as u32);
            if x.is_finite() {
                let exact = (function.reference)(f64::from(finite(x)));
                worst.add([x, 0.0], (function.function)(x), exact);
            }
            bits += parts * stride;
        }
        worst
    };
    thread::scope(|scope| {
        let threads: Vec<_> = (0..parts).map(|i| scope.spawn(move || part(i))).collect();
        let worst = threads.into_iter().map(|thread| thread.join().unwrap());
        worst.fold(Worst::default(), Worst::or)
    })
}

/// Returns the worst of `count` pairs: of any bits, of moderate magnitudes, and near 1.
fn worst_of_two(function: &Two, count: u64) -> Worst {
    let parts = thread::available_parallelism().map_or(1, usize::from) as u64;
    let part = |part: u64| {
        let mut random = fastrand::Rng::with_seed(part);
        let mut worst = Worst::default();
        for i in 0..count / parts {
            let [a, b] = [(); 2].map(|_| {
                let bits = random.u32(..);
                match i % 4 {
                    0 => f32::from_bits(bits),
                    1 => f32::from_bits(bits & 0x807f_ffff | (120 + random.u32(..14)) << 23),
                    2 => 1.0 + (bits as i32) as f32 * f32::powi(2.0, -(random.i32(32..55))),
                    _ => f32::from_bits(bits & 0x80ff_ffff | 0x3f00_0000),
                }
            });
            if a.is_finite() && b.is_finite() {
                let exact = (function.reference)(f64::from(finite(a)), f64::from(finite(b)));
                worst.add([a, b], (function.function)(a, b), exact);
            }
        }
        worst
    };
    thread::scope(|scope| {
        let threads: Vec<_> = (0..parts).map(|i| scope.spawn(move || part(i))).collect();
        let worst = threads.into_iter().map(|thread| thread.join().unwrap());
        worst.fold(Worst::default(), Worst::or)
    })
}

/// Tries all functions, prints a table, and requires the bounds.
fn check(stride: u64, pairs: u64) {
    let mut broken = Vec::new();
    let mut row = |name: &str, worst: Worst, bound: f64| {
        println!(
            "| `{name}` | {:.4} | {:e}, {:e} |",
            worst.error, worst.at[0], worst.at[1]
        );
        if worst.error > bound {
            broken.push(format!("{name}: {worst:?}"));
        }
    };
    for function in &ONES {
        row(
            function.name,
            worst_of_one(function, stride),
            function.bound,
        );
    }
    for function in &TWOS {
        row(function.name, worst_of_two(function, pairs), function.bound);
    }
    assert!(broken.is_empty(), "{broken:#?}");
}

#[test]
fn errors_are_within_their_bounds() {
    // Coprime to powers of two, so that all digits change.
    check(4093, 1_000_000);
}

#[test]
#[ignore = "minutes: every f32"]
fn errors_of_all_numbers_are_within_their_bounds() {
    check(1, 1_000_000_000);
}

#[test]
fn an_error_is_seen() {
    assert!(error(1.000_000_1, 1.0) > 0.99);
    assert!(error(f32::MAX, 1e38).is_finite() && error(f32::MAX, 1e38) > 1e6);
    assert_eq!(error(0.0, 1e-20), 1e-20 / 2.0_f64.powi(-90));
}
