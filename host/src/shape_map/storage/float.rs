//! Signed distances as 32-bit floats.

use super::form::{Coding, File, Form, Valid, pack};
use rayon::prelude::*;
use relievo_shared::layout::FORMAT_FLOAT;

pub(super) const R32F: Form = Form {
    name: "r32f",
    summary: "32-bit floating-point signed distances (OpenEXR)",
    bits: 32,
    map_bits: Some(32),
    larger: "r32f",
    shader_format: FORMAT_FLOAT,
    file: File::Exr,
    encode: |field, _| {
        let coding = Coding {
            bias: 0,
            step: 0.0,
            scale: 1.0,
            saturated: false,
        };
        (coding, pack(32, field.values(), f32::to_bits))
    },
    decode: |_, texel| f32::from_bits(texel),
    range,
    normal: |_| None,
    check: |coding| Valid {
        bias: coding.bias == 0,
        step: coding.step == 0.0,
        scale: coding.scale == 1.0,
        saturated: !coding.saturated,
    },
    check_texel: Some(check_texel),
};

/// Returns the lowest and the highest stored distance.
fn range(_: Coding, words: &[u32]) -> (f32, f32) {
    words
        .par_iter()
        .map(|&word| (f32::from_bits(word), f32::from_bits(word)))
        .reduce(
            || (f32::INFINITY, f32::NEG_INFINITY),
            |a, b| (a.0.min(b.0), a.1.max(b.1)),
        )
}

/// Checks the range of every distance field. NaN fails.
fn check_texel(texel: u32, diagonal: f32) -> Result<(), String> {
    let distance = f32::from_bits(texel);
    if (0.5..=diagonal).contains(&distance.abs()) {
        Ok(())
    } else {
        Err(format!(
            "distance {distance}, but its magnitude must be 0.5 to {diagonal}"
        ))
    }
}
