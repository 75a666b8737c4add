//! Rasterizes charts with embedded fonts, so that they look the same on every
//! machine.

use epaint_default_fonts::{HACK_REGULAR, UBUNTU_LIGHT};
use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree};

/// Picture pixels per SVG pixel.
const SCALE: f32 = 2.0;

/// Renders `svg` as a PNG file.
///
/// # Errors
/// The drawing library's message.
pub fn png(svg: &str) -> Result<Vec<u8>, String> {
    let mut options = Options::default();
    let fonts = options.fontdb_mut();
    fonts.load_font_data(UBUNTU_LIGHT.to_vec());
    fonts.load_font_data(HACK_REGULAR.to_vec());
    fonts.set_sans_serif_family("Ubuntu");
    fonts.set_monospace_family("Hack");
    let tree = Tree::from_str(svg, &options).map_err(|error| error.to_string())?;
    let size = tree.size().to_int_size();
    let [width, height] = [size.width(), size.height()].map(|side| (side as f32 * SCALE) as u32);
    let mut picture = Pixmap::new(width, height)
        .ok_or_else(|| format!("a picture of {width} × {height} pixels does not fit"))?;
    resvg::render(
        &tree,
        Transform::from_scale(SCALE, SCALE),
        &mut picture.as_mut(),
    );
    picture.encode_png().map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::super::report::tests::report;
    use super::*;

    #[test]
    fn the_picture_shows_marks_and_text() {
        let svg = report().to_svg().unwrap();
        let bytes = png(&svg).unwrap();
        let picture = image::load_from_memory(&bytes).unwrap().into_rgb8();
        assert_eq!(picture.width(), 2840);
        let count = |wanted: [u8; 3]| picture.pixels().filter(|pixel| pixel.0 == wanted).count();
        // Fronts, dominated points and white.
        assert!(count([192, 30, 60]) > 500);
        assert!(count([178, 178, 178]) > 500);
        let all = picture.width() as usize * picture.height() as usize;
        assert!(count([255; 3]) > all / 2);
        // Names on the right would be missing without fonts.
        let names = picture
            .enumerate_pixels()
            .filter(|(x, _, pixel)| *x > 1700 && pixel.0 != [255; 3]);
        assert!(names.count() > 10_000);
    }

    #[test]
    fn what_is_no_svg_is_an_error() {
        assert!(png("<svg").is_err());
    }
}
