//! The picture's entry points. Storage buffer 0: the view, and the size of the picture.

use crate::view::{View, color};
use glam::{UVec2, Vec4};
use relievo_kernel::{buffers::load, screen};
use spirv_std::spirv;

/// Covers the picture.
#[spirv(vertex)]
pub fn cover(#[spirv(vertex_index)] vertex: u32, #[spirv(position)] position: &mut Vec4) {
    *position = screen::cover(vertex);
}

/// Computes a pixel.
#[spirv(fragment)]
pub fn landscape(
    #[spirv(frag_coord)] at: Vec4,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] words: &[u32],
    output: &mut Vec4,
) {
    // SAFETY: the buffer has the words of both.
    let (view, size): (View, UVec2) = unsafe { load(words) };
    *output = color(screen::pixel(at), size, &view);
}
