//! The sources of `relievo-shared` compiled in f64, as the reference for the error of
//! its f32 arithmetic. Modules and functions are those of `relievo-shared`; its
//! documentation describes them.
//!
//! ```
//! use relievo_shared_f64::arithmetic::div;
//!
//! let third: relievo_shared_f64::Real = div(1.0, 3.0);
//! assert_eq!(third, 1.0_f64 / 3.0);
//! ```
#![no_std]
#![forbid(unsafe_code)]

// The unit tests in these files belong to `relievo-shared`.
#[cfg(not(test))]
include!(concat!(env!("OUT_DIR"), "/src/lib.rs"));
