//! How wide pixels are from which on the mean of a pattern is all that they show, for
//! [`relievo_shared::far`].

use super::pictures::halve;
use image::Rgba32FImage;
use relievo_shared::shading::FacetMaterial;
use relievo_shared::shading::mean::MOST;

/// How many times such a pixel is as wide as a groove, or as the pattern is deep.
const WIDER: f32 = 2.0;
/// Width of the narrowest pixel that is looked up in a level, texels of that level: 1 / 0.7, as in
/// [`relievo_shared::shading::image`].
const LEVEL: f32 = 1.43;

/// Returns the width of a pixel from which on a pattern is seen as its mean only, wherever the pixel is:
/// texels of `chart`, the first level of the pattern's chart, in which gaps have the mean width `gap`. It is
/// infinite for a pattern without an outline.
pub(super) fn from(chart: &Rgba32FImage, gap: f32) -> f32 {
    let mut widths = vec![widest(chart)];
    let mut level = chart.clone();
    while level.width() * level.height() > 1 {
        level = halve(&level);
        widths.push(widest(&level));
    }
    // From the coarsest level to finer ones, while their pixels are wide enough for the grooves in them.
    let (mut least, mut most) = (f32::INFINITY, 0.0_f32);
    for (level, width) in widths.iter().enumerate().rev() {
        most = most.max(WIDER * width);
        if most >= least {
            break;
        }
        least = match level {
            0 => most,
            level => most.max(LEVEL * (level as f32).exp2()),
        };
    }
    least.max(gap)
}

/// Returns the width of the widest groove in a level of a chart, texels of its first level.
fn widest(level: &Rgba32FImage) -> f32 {
    let widths = level.pixels().map(|texel| {
        let [cap, xx, yy, xy] = texel.0;
        let slanted = (0.5 * (xx - yy)).hypot(xy - 0.5);
        // What runs across the grooves that are there most.
        let outline = MOST * (0.5 * (xx + yy) + slanted);
        match outline > 1e-6 {
            true => 2.0 * (1.0 - cap) / outline,
            false => f32::INFINITY,
        }
    });
    widths.fold(0.0, f32::max)
}

/// Returns [`Object::mean_from`](relievo_shared::layout::Object::mean_from) of an object of this `depth` on
/// `facets`, where a pixel of `from` texels of a chart of `size` shows only the mean.
pub(super) fn mean_from(from: f32, size: [u32; 2], depth: f32, facets: &[FacetMaterial]) -> f32 {
    // Texels per object unit where they are widest.
    let densities = facets
        .iter()
        .flat_map(|facet| [0, 1].map(|axis| facet.density[axis] * size[axis] as f32));
    let least = densities
        .filter(|density| *density > 0.0)
        .fold(f32::INFINITY, f32::min);
    let width = (from / least).max(WIDER * depth);
    match width.is_finite() && least.is_finite() {
        true => width,
        false => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::Rgba;

    /// A chart of square texels with this share of cap and outline along x, in texels per texel.
    fn chart(size: u32, texel: impl Fn(u32, u32) -> [f32; 2]) -> Rgba32FImage {
        Rgba32FImage::from_fn(size, size, |x, y| {
            let [cap, outline] = texel(x, y);
            Rgba([cap, outline / MOST, 0.0, 0.5])
        })
    }

    #[test]
    fn even_stripes_are_far_where_a_pixel_is_twice_as_wide_as_they_are() {
        // Two edges in 4 texels, half of them cap: grooves of 2.
        let stripes = chart(16, |_, _| [0.5, 0.5]);
        assert!((from(&stripes, 2.0) - 4.0).abs() < 1e-3);
        assert_eq!(from(&stripes, 5.0), 5.0);
    }

    #[test]
    fn a_pattern_with_an_empty_part_is_far_where_a_pixel_is_as_wide_as_that() {
        let half = chart(16, |x, _| if x < 8 { [0.5, 1.0] } else { [1.0, 0.0] });
        // The last level is the first without a texel that has no outline.
        assert!((from(&half, 1.0) - LEVEL * 16.0).abs() < 1e-3);
        let empty = chart(16, |_, _| [1.0, 0.0]);
        assert_eq!(from(&empty, 1.0), f32::INFINITY);
    }

    #[test]
    fn the_widest_texels_and_the_depth_count() {
        let facet = |u, v| FacetMaterial {
            density: [u, v],
            ..FacetMaterial::default()
        };
        let facets = [facet(2.0, 3.0), facet(4.0, 0.0)];
        // 8 texels a repeat, 16 an object unit at least.
        assert_eq!(mean_from(4.0, [8, 8], 0.01, &facets), 0.25);
        assert_eq!(mean_from(4.0, [8, 8], 0.5, &facets), 1.0);
        assert_eq!(mean_from(f32::INFINITY, [8, 8], 0.5, &facets), 0.0);
        assert_eq!(mean_from(4.0, [8, 8], 0.5, &[facet(0.0, 0.0)]), 0.0);
        assert_eq!(mean_from(4.0, [8, 8], 0.5, &[]), 0.0);
    }
}
