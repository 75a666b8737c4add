//! The description of a storage form: everything that the rest of the crate
//! needs to know about it.

use super::super::distance::DistanceField;
use serde::{Deserialize, Serialize};

/// A storage form. Each is one constant in a file of its own, and one line in
/// the list of [`Storage`](super::Storage).
pub(crate) struct Form {
    /// Name in files and on the command line.
    pub name: &'static str,
    /// One line for the help of the command line.
    pub summary: &'static str,
    /// Bits of a texel: 8, 16 or 32.
    pub bits: u32,
    /// The value of a scene's `map_bits` that selects the form; `None` if only
    /// baking does.
    pub map_bits: Option<u32>,
    /// Name of a form to suggest where this one holds too few distances.
    pub larger: &'static str,
    /// The decoder in the shared code: `FORMAT_` of `relievo_shared::layout`.
    pub shader_format: u32,
    /// The file that holds the texels.
    pub file: File,
    /// Encodes a field with the scale f of equation (5); returns the packed
    /// texels.
    pub encode: fn(&DistanceField, f32) -> (Coding, Vec<u32>),
    /// Decodes the signed distance of a texel, in texels (of length).
    pub decode: fn(Coding, u32) -> f32,
    /// Returns the lowest and the highest distance that the packed texels can
    /// hold.
    pub range: fn(Coding, &[u32]) -> (f32, f32),
    /// Decodes the normal of a texel, where the form holds one.
    pub normal: fn(u32) -> Option<[f32; 2]>,
    /// Checks the parameters of a file.
    pub check: fn(&Coding) -> Valid,
    /// Checks a texel of a file, given the length of the map's diagonal in
    /// texels; `None` if every texel is valid.
    pub check_texel: Option<TexelCheck>,
}

/// Checks a texel of a file, given the length of the map's diagonal in texels.
pub(crate) type TexelCheck = fn(u32, f32) -> Result<(), String>;

/// The file that holds a form.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum File {
    /// A PNG file. The first sample is in the lowest bits of a texel.
    Png(png::ColorType, png::BitDepth),
    /// An OpenEXR file with one channel of f32, the bits of the texel.
    Exr,
}

/// The parameters that turn texels into distances, as in the description in a
/// file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Coding {
    /// Fixed-point codes: the code of distance 0. Otherwise 0.
    pub bias: u32,
    /// Texels (of length) per unit of the code or of the blue channel; 0 for
    /// floats.
    pub step: f32,
    /// f of equation (5), where it applies. Otherwise 1.
    pub scale: f32,
    /// Whether distances are out of range.
    pub saturated: bool,
}

/// Which parameters of a [`Coding`] are valid.
pub(crate) struct Valid {
    pub bias: bool,
    pub step: bool,
    pub scale: bool,
    pub saturated: bool,
}

/// The largest code of `bits` bits.
pub(crate) const fn largest_code(bits: u32) -> u32 {
    u32::MAX >> (32 - bits)
}

/// Packs `source`, one item per texel, into words; `texel` returns the bits of a
/// texel. The first texel of a word takes the lowest bits.
pub(crate) fn pack<T: Copy + Sync>(
    bits: u32,
    source: &[T],
    texel: impl Fn(T) -> u32 + Sync,
) -> Vec<u32> {
    use rayon::prelude::*;
    source
        .par_chunks((32 / bits) as usize)
        .map(|texels| {
            // `checked_shl`, as a texel of 32 bits is shifted by the full width.
            texels.iter().rev().fold(0u32, |word, &item| {
                word.checked_shl(bits).unwrap_or(0) | texel(item)
            })
        })
        .collect()
}
