//! A triangle that covers a picture, for fragment shaders that compute each pixel.

use glam::{UVec2, Vec4};

/// Returns the position of a vertex, 0 to 2, of a triangle that covers the picture.
///
/// ```
/// use relievo_kernel::{glam::Vec4, screen::cover};
///
/// assert_eq!(cover(0), Vec4::new(-1.0, -1.0, 0.0, 1.0));
/// assert_eq!(cover(1), Vec4::new(3.0, -1.0, 0.0, 1.0));
/// assert_eq!(cover(2), Vec4::new(-1.0, 3.0, 0.0, 1.0));
/// ```
pub fn cover(vertex: u32) -> Vec4 {
    let at = |far: bool| if far { 3.0 } else { -1.0 };
    Vec4::new(at(vertex == 1), at(vertex == 2), 0.0, 1.0)
}

/// Returns the pixel of a fragment, counted from the top left. Its centre, which
/// `frag_coord` is, lies at halves.
pub fn pixel(frag_coord: Vec4) -> UVec2 {
    UVec2::new(frag_coord.x as u32, frag_coord.y as u32)
}
