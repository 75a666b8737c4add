//! The pattern: the pixels of an image that are extruded (sections 1 and 3 of
//! docs/algorithm.md).
//!
//! ```
//! use relievo::shape_map::pattern::{Pattern, PatternOptions};
//! use std::path::Path;
//!
//! // One black and one white pixel, as an image file in memory.
//! let image = b"P2 2 1 255\n0 255\n";
//! let pattern = Pattern::from_bytes(image, Path::new("two.pgm"), &PatternOptions::default())?;
//! assert_eq!(pattern.solid(), [true, false]);
//! # Ok::<(), relievo::shape_map::ShapeMapError>(())
//! ```

use super::drawing::{draw, is_drawing};
use super::error::ShapeMapError;
use super::input::{Input, check_size, decoded_bytes, open, open_within};
use super::limits::{DEFAULT_MAX_PIXELS, MAX_PIXELS};
use super::raster::DEFAULT_RASTER;
use crate::Files;
use image::{DynamicImage, ImageDecoder, ImageReader, Limits};
use std::io::Cursor;
use std::path::Path;

/// Options for thresholding an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PatternOptions {
    /// Pixels whose luma, rounded to 8 bits, is below this value are pattern
    /// (0…255; default 128).
    pub threshold: u8,
    /// Whether the bright pixels are the pattern instead (default false).
    pub invert: bool,
    /// Maximum number of pixels, checked before decoding (default
    /// [`DEFAULT_MAX_PIXELS`]; values above [`MAX_PIXELS`] are reduced to it).
    pub max_pixels: u64,
    /// Pixels on the longer side of a rasterised SVG file or text (default
    /// [`DEFAULT_RASTER`]). Images keep their size.
    pub raster: u32,
}

impl Default for PatternOptions {
    fn default() -> Self {
        Self {
            threshold: 128,
            invert: false,
            max_pixels: DEFAULT_MAX_PIXELS,
            raster: DEFAULT_RASTER,
        }
    }
}

/// A binary image of at least one pixel that repeats in both directions. Its solid
/// pixels are extruded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pattern {
    width: u32,
    height: u32,
    solid: Vec<bool>,
}

impl Pattern {
    /// Loads an image and thresholds it. Fully transparent pixels are never
    /// pattern, inverted or not.
    ///
    /// The format is detected from the content, or from the extension if the
    /// content has no signature (TGA). Of an animation the first frame is used.
    /// An SVG file is rendered on white.
    ///
    /// # Errors
    /// A file that cannot be read, is not an image, or has no pixels or too many.
    pub fn load(path: impl AsRef<Path>, options: &PatternOptions) -> Result<Self, ShapeMapError> {
        Self::load_from(&Files::Disk, path.as_ref(), options)
    }

    /// Like [`Pattern::load`], from `files`.
    ///
    /// # Errors
    /// As for [`Pattern::load`].
    pub fn load_from(
        files: &Files,
        path: &Path,
        options: &PatternOptions,
    ) -> Result<Self, ShapeMapError> {
        Self::read(
            &mut open_within(files, path, options.max_pixels)?,
            path,
            options,
        )
    }

    /// Like [`Pattern::load`], from the bytes of a file; `path` is named in errors
    /// and its extension is used as there.
    ///
    /// # Errors
    /// As for [`Pattern::load`].
    pub fn from_bytes(
        bytes: &[u8],
        path: &Path,
        options: &PatternOptions,
    ) -> Result<Self, ShapeMapError> {
        Self::read(&mut Cursor::new(bytes), path, options)
    }

    /// Returns whether a file is an SVG drawing, which has no pixels of its own.
    ///
    /// # Errors
    /// A file that cannot be opened or read.
    pub fn is_drawing(files: &Files, path: &Path) -> Result<bool, ShapeMapError> {
        is_drawing(&mut open(files, path)?, path)
    }

    fn read(
        input: &mut dyn Input,
        path: &Path,
        options: &PatternOptions,
    ) -> Result<Self, ShapeMapError> {
        let image = if is_drawing(input, path)? {
            draw(input, path, options.raster, options.max_pixels)?.into()
        } else {
            decode_image(input, path, options.max_pixels)?
        };
        Ok(Self::threshold(image, options))
    }

    /// Thresholds `image`.
    pub(super) fn threshold(image: DynamicImage, options: &PatternOptions) -> Self {
        let (width, height) = (image.width(), image.height());
        let solid = image
            .into_luma_alpha8()
            .pixels()
            .map(|pixel| {
                let [luma, alpha] = pixel.0;
                alpha > 0 && (luma < options.threshold) != options.invert
            })
            .collect();
        Self {
            width,
            height,
            solid,
        }
    }

    /// Draws an SVG document on white and thresholds it; its longer side has
    /// [`raster`](PatternOptions::raster) pixels.
    ///
    /// # Errors
    /// [`ShapeMapError::Drawing`] for an invalid document,
    /// [`ShapeMapError::TooLarge`].
    ///
    /// # Examples
    /// ```
    /// use relievo::shape_map::{Pattern, PatternOptions};
    ///
    /// let svg = "<svg xmlns='http://www.w3.org/2000/svg' width='2' height='1'>
    ///     <circle cx='1' cy='0.5' r='0.4'/></svg>";
    /// let options = PatternOptions { raster: 64, ..PatternOptions::default() };
    /// let pattern = Pattern::from_svg(svg, &options)?;
    /// assert_eq!((pattern.width(), pattern.height()), (64, 32));
    /// assert!(pattern.is_solid(32, 16) && !pattern.is_solid(0, 0));
    /// # Ok::<(), relievo::shape_map::ShapeMapError>(())
    /// ```
    pub fn from_svg(svg: &str, options: &PatternOptions) -> Result<Self, ShapeMapError> {
        let path = Path::new("the SVG document");
        let image = draw(svg.as_bytes(), path, options.raster, options.max_pixels)?;
        Ok(Self::threshold(image.into(), options))
    }

    /// Creates a pattern from its pixels, row by row from the top left: true
    /// where the pixel is extruded.
    ///
    /// # Errors
    /// [`ShapeMapError::InvalidSize`] for no pixels or more than [`MAX_PIXELS`],
    /// [`ShapeMapError::PixelCount`] unless there are `width` · `height` of them.
    ///
    /// # Examples
    /// ```
    /// use relievo::shape_map::Pattern;
    ///
    /// let pattern = Pattern::from_pixels(3, 1, [true, false, false])?;
    /// assert!(pattern.is_solid(0, 0) && !pattern.is_solid(1, 0));
    /// # Ok::<(), relievo::shape_map::ShapeMapError>(())
    /// ```
    pub fn from_pixels(
        width: u32,
        height: u32,
        solid: impl Into<Vec<bool>>,
    ) -> Result<Self, ShapeMapError> {
        let solid = solid.into();
        if solid.len() as u64 != checked_count(width, height)? {
            return Err(ShapeMapError::PixelCount {
                width,
                height,
                count: solid.len(),
            });
        }
        Ok(Self {
            width,
            height,
            solid,
        })
    }

    /// Creates a pattern of `width` × `height` pixels from a function that
    /// tells whether the pixel at (x, y) is extruded. It is called row by row,
    /// from the top left.
    ///
    /// # Errors
    /// [`ShapeMapError::InvalidSize`] for no pixels or more than [`MAX_PIXELS`].
    ///
    /// # Examples
    /// ```
    /// use relievo::shape_map::Pattern;
    ///
    /// let disc = Pattern::from_fn(64, 64, |x, y| {
    ///     (f64::from(x) - 31.5).hypot(f64::from(y) - 31.5) < 20.0
    /// })?;
    /// assert!(disc.is_solid(32, 32) && !disc.is_solid(0, 0));
    /// # Ok::<(), relievo::shape_map::ShapeMapError>(())
    /// ```
    pub fn from_fn(
        width: u32,
        height: u32,
        mut solid: impl FnMut(u32, u32) -> bool,
    ) -> Result<Self, ShapeMapError> {
        let mut pixels = Vec::with_capacity(checked_count(width, height)? as usize);
        for y in 0..height {
            pixels.extend((0..width).map(|x| solid(x, y)));
        }
        Ok(Self {
            width,
            height,
            solid: pixels,
        })
    }

    /// Returns a pattern of the same size with the pixels `solid`.
    pub(super) fn with_solid(&self, solid: Vec<bool>) -> Self {
        debug_assert_eq!(solid.len(), self.solid.len());
        Self { solid, ..*self }
    }

    /// Returns the width in pixels, at least 1.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Returns the height in pixels, at least 1.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Returns all pixels, row by row: true where the pixel is pattern.
    pub fn solid(&self) -> &[bool] {
        &self.solid
    }

    /// Returns whether a pixel is pattern; coordinates wrap around.
    pub fn is_solid(&self, x: u32, y: u32) -> bool {
        let (x, y) = ((x % self.width) as usize, (y % self.height) as usize);
        self.solid[y * self.width as usize + x]
    }
}

/// Returns the number of pixels, if a pattern may have this size.
fn checked_count(width: u32, height: u32) -> Result<u64, ShapeMapError> {
    let count = u64::from(width) * u64::from(height);
    if count == 0 || count > MAX_PIXELS {
        return Err(ShapeMapError::InvalidSize { width, height });
    }
    Ok(count)
}

/// Decodes an image after checking its size.
pub(super) fn decode_image(
    input: &mut dyn Input,
    path: &Path,
    max_pixels: u64,
) -> Result<DynamicImage, ShapeMapError> {
    let read_error = |source| ShapeMapError::Read {
        path: path.to_path_buf(),
        source,
    };
    let decode_error = |source| ShapeMapError::DecodeImage {
        path: path.to_path_buf(),
        source: Box::new(source),
    };
    // The PNG decoder reads up to the pixels before it returns the size, and takes
    // its limits before that.
    let header = png::Decoder::new(&mut *input)
        .read_header_info()
        .map_or([0; 2], |header| [header.width, header.height]);
    if header != [0; 2] {
        check_size(path, header[0], header[1], max_pixels)?;
    }
    input.rewind().map_err(read_error)?;

    let mut reader = ImageReader::new(input);
    if let Ok(format) = image::ImageFormat::from_path(path) {
        reader.set_format(format);
    }
    let mut reader = reader.with_guessed_format().map_err(read_error)?;
    reader.limits(memory(header));
    let mut decoder = reader.into_decoder().map_err(decode_error)?;
    let (width, height) = decoder.dimensions();
    check_size(path, width, height, max_pixels)?;
    decoder
        .set_limits(memory([width, height]))
        .map_err(decode_error)?;
    DynamicImage::from_decoder(decoder).map_err(decode_error)
}

/// Returns the memory limit of the decoder for an image of this size.
fn memory([width, height]: [u32; 2]) -> Limits {
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(decoded_bytes(u64::from(width) * u64::from(height)));
    limits
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{GrayImage, ImageFormat, Luma, LumaA, Rgb, RgbImage};
    use std::error::Error;
    use std::fs;

    fn load(path: &Path) -> Result<Pattern, ShapeMapError> {
        Pattern::load(path, &PatternOptions::default())
    }

    fn options(threshold: u8, invert: bool) -> PatternOptions {
        PatternOptions {
            threshold,
            invert,
            ..PatternOptions::default()
        }
    }

    #[test]
    fn threshold_and_inversion() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("ramp.png");
        GrayImage::from_fn(4, 1, |x, _| Luma([[0, 127, 128, 255][x as usize]]))
            .save(&path)
            .unwrap();
        let solid = |options| Pattern::load(&path, &options).unwrap().solid;
        assert_eq!(solid(options(128, false)), [true, true, false, false]);
        assert_eq!(solid(options(128, true)), [false, false, true, true]);
        assert_eq!(solid(options(0, false)), [false; 4]);
        assert_eq!(solid(options(255, false)), [true, true, true, false]);
    }

    #[test]
    fn transparent_pixels_are_never_pattern() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("alpha.png");
        let pixels = [[0, 0], [0, 1], [255, 0], [255, 255]];
        image::GrayAlphaImage::from_fn(4, 1, |x, _| LumaA(pixels[x as usize]))
            .save(&path)
            .unwrap();
        let solid = |options| Pattern::load(&path, &options).unwrap().solid;
        assert_eq!(solid(options(128, false)), [false, true, false, false]);
        assert_eq!(solid(options(128, true)), [false, false, false, true]);
    }

    #[test]
    fn every_lossless_format_loads_the_same_pattern_whatever_its_extension() {
        let folder = tempfile::tempdir().unwrap();
        let wanted = Pattern::from_fn(13, 7, |x, y| (x * 5 + y * 3) % 4 == 0).unwrap();
        let image = RgbImage::from_fn(13, 7, |x, y| {
            Rgb([if wanted.is_solid(x, y) { 10 } else { 240 }; 3])
        });
        for (format, name) in [
            (ImageFormat::Png, "png.jpg"),
            (ImageFormat::Bmp, "bmp.png"),
            (ImageFormat::Gif, "gif"),
            (ImageFormat::Tiff, "tiff.txt"),
            (ImageFormat::WebP, "webp.webp"),
            (ImageFormat::Pnm, "pnm.bin"),
            (ImageFormat::Qoi, "qoi"),
            (ImageFormat::Tga, "no_signature.tga"),
        ] {
            let path = folder.path().join(name);
            image.save_with_format(&path, format).unwrap();
            assert_eq!(load(&path).unwrap(), wanted, "{name}");
        }
    }

    #[test]
    fn sixteen_bit_and_one_bit_images() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("deep.png");
        image::ImageBuffer::<Luma<u16>, _>::from_raw(2, 1, vec![0x7f00u16, 0x8100])
            .unwrap()
            .save(&path)
            .unwrap();
        assert_eq!(load(&path).unwrap().solid, [true, false]);
        let path = folder.path().join("bits.pbm");
        fs::write(&path, "P1 2 1\n1 0\n").unwrap(); // 1 is black
        assert_eq!(load(&path).unwrap().solid, [true, false]);
    }

    /// Returns the signature and header of a gray PNG.
    fn png_header(width: u32, height: u32) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, width, height);
        encoder.set_color(png::ColorType::Grayscale);
        encoder.set_depth(png::BitDepth::Eight);
        drop(encoder.write_header().unwrap());
        bytes
    }

    #[test]
    fn a_huge_image_is_refused_by_its_header() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("huge.png");
        for (width, height) in [(60_000, 60_000), (0x7fff_ffff, 1)] {
            fs::write(&path, png_header(width, height)).unwrap();
            let message = load(&path).unwrap_err().to_string();
            for part in ["huge.png", "268435456", "raise the limit"] {
                assert!(message.contains(part), "{message}");
            }
            assert!(
                message.contains(&format!("{width} × {height}")),
                "{message}"
            );
        }
        // Other formats have the size before the pixels.
        fs::write(&path, "P5 60000 60000 255\n").unwrap();
        assert!(matches!(
            load(&path),
            Err(ShapeMapError::TooLarge { width: 60_000, .. })
        ));
    }

    #[test]
    fn the_limit_is_inclusive_and_cannot_be_raised_without_end() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("small.png");
        GrayImage::new(4, 3).save(&path).unwrap();
        let with_limit = |max_pixels| PatternOptions {
            max_pixels,
            ..PatternOptions::default()
        };
        assert!(Pattern::load(&path, &with_limit(12)).is_ok());
        assert!(matches!(
            Pattern::load(&path, &with_limit(11)),
            Err(ShapeMapError::TooLarge { max_pixels: 11, .. })
        ));
        fs::write(&path, png_header(60_000, 60_000)).unwrap();
        let error = Pattern::load(&path, &with_limit(u64::MAX)).unwrap_err();
        assert!(!error.to_string().contains("raise"), "{error}");
    }

    #[test]
    fn files_that_are_no_image_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let text = folder.path().join("text.png");
        fs::write(&text, "not an image at all").unwrap();
        let nothing = folder.path().join("nothing");
        fs::write(&nothing, "").unwrap();
        let flat = folder.path().join("flat.pgm");
        fs::write(&flat, "P5 0 5 255\n").unwrap();
        let truncated = folder.path().join("truncated.png");
        fs::write(&truncated, png_header(8, 8)).unwrap();
        let missing = folder.path().join("missing.png");
        for path in [
            text.as_path(),
            &nothing,
            &flat,
            &truncated,
            &missing,
            folder.path(),
        ] {
            let error = load(path).unwrap_err();
            let name = path.display().to_string();
            assert!(error.to_string().contains(&name), "{error}");
        }
        assert!(matches!(
            load(&text),
            Err(ShapeMapError::DecodeImage { .. })
        ));
        assert!(matches!(load(&missing), Err(ShapeMapError::Read { .. })));
        assert!(load(&missing).unwrap_err().source().is_some());
        assert!(matches!(
            load(folder.path()),
            Err(ShapeMapError::Directory { .. })
        ));
    }

    #[test]
    fn sizes_that_cannot_be_made() {
        for (width, height) in [(0, 0), (0, 5), (5, 0), (u32::MAX, u32::MAX)] {
            let error = Pattern::from_fn(width, height, |_, _| true).unwrap_err();
            assert!(matches!(error, ShapeMapError::InvalidSize { .. }));
        }
        let error = Pattern::from_pixels(2, 2, [true; 3]).unwrap_err();
        let message = error.to_string();
        assert!(
            message.contains("2 × 2") && message.contains("3 pixels"),
            "{message}"
        );
    }
}
