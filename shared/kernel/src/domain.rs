//! Sets of values that are tried as arguments.

/// Values of an argument: of each of its scalars, unless the kind says otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Domain {
    /// Meaning of the number; values recorded under this name are tried, too.
    pub name: &'static str,
    /// The values.
    pub kind: Kind,
}

/// A set of values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// Zero, or of either sign and of a magnitude in `low..=high`, 0 < low.
    Magnitude {
        /// Smallest magnitude that is not zero.
        low: f32,
        /// The largest.
        high: f32,
    },
    /// Of either sign and of a magnitude in `low..=high`, never zero.
    NonZero {
        /// The smallest magnitude.
        low: f32,
        /// The largest.
        high: f32,
    },
    /// From `low` to `high`, both included; no magnitudes below 2⁻²⁰ but
    /// zero, so that products of several are normal numbers.
    Range {
        /// The smallest.
        low: f32,
        /// The largest.
        high: f32,
    },
    /// Three scalars: a vector of length 1, but for rounding; no magnitudes
    /// below 2⁻²⁰ but zero.
    UnitVector,
    /// Any bits. Of a function of one word, input i is i times an odd number: 2³² inputs
    /// are every word, once.
    Bits,
    /// A whole number from `low` to `high`, both included, as u32.
    Integer {
        /// The smallest.
        low: u32,
        /// The largest.
        high: u32,
    },
}

impl Domain {
    /// Returns a domain.
    pub const fn new(name: &'static str, kind: Kind) -> Domain {
        Domain { name, kind }
    }

    /// Returns the numbers from `low` to `high`.
    pub const fn range(name: &'static str, low: f32, high: f32) -> Domain {
        Domain::new(name, Kind::Range { low, high })
    }

    /// Returns the whole numbers from `low` to `high`.
    pub const fn integer(name: &'static str, low: u32, high: u32) -> Domain {
        Domain::new(name, Kind::Integer { low, high })
    }
}

/// Numbers that exact functions take without losing one: 0 and magnitudes in 2⁻⁶⁰…2⁶⁰.
pub const NUMBER: Domain = Domain::new(
    "number",
    Kind::Magnitude {
        low: 1.0 / 1_152_921_504_606_846_976.0,
        high: 1_152_921_504_606_846_976.0,
    },
);
/// Any f32: infinities, NaN and denormal numbers, too.
pub const ANY: Domain = Domain::new("any", Kind::Bits);
/// Unit vectors.
pub const UNIT: Domain = Domain::new("unit vector", Kind::UnitVector);
/// Fractions, 0 to 1.
pub const FRACTION: Domain = Domain::range("fraction", 0.0, 1.0);
/// Any u32 or i32.
pub const INTEGER: Domain = Domain::integer("integer", 0, u32::MAX);
/// True or false.
pub const TRUTH: Domain = Domain::integer("truth", 0, 1);
