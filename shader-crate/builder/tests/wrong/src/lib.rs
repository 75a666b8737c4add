//! Programs that are not exact, one in each file and behind each feature. The builder's
//! tests compile one at a time and compare its answer with a file of `../messages`.
#![cfg_attr(target_arch = "spirv", no_std)]

/// Declares the module of each program.
macro_rules! programs {
    ($($name:ident $feature:literal)*) => {
        $(#[cfg(feature = $feature)] pub mod $name;)*
    };
}

programs! {
    array "array"
    buffer "buffer"
    clamp "clamp"
    constants "constants"
    division "division"
    division_of_vectors "division_of_vectors"
    double "double"
    exponential "exponential"
    fused "fused"
    integer_division "integer_division"
    length "length"
    minimum "minimum"
    native "native"
    object "object"
    panic "panic"
    power "power"
    recursion "recursion"
    remainder "remainder"
    right "right"
    same_place "same_place"
    sine "sine"
    unwrap "unwrap"
    wide "wide"
}

/// Arguments, then results, in a storage buffer.
pub type Words = [f32; 12];
