//! Develops a renderer's words into an sRGB picture, and writes PNG files.
//!
//! ```
//! use relievo::picture::Picture;
//! use relievo::render::ColorWords;
//! use relievo::scene::Development;
//!
//! let white = [1.0_f32.to_bits(), 1.0_f32.to_bits(), 1.0_f32.to_bits(), 0];
//! let words = ColorWords { width: 2, height: 2, words: vec![white; 4] };
//! // One pixel of four samples.
//! let picture = Picture::develop(&words, 2, &Development::default())?;
//! assert_eq!(picture.bytes, [255; 3]);
//! assert!(picture.png(&[])?.starts_with(b"\x89PNG"));
//! # Ok::<(), relievo::Error>(())
//! ```

use crate::Error;
use crate::file::write_whole;
use crate::render::{ColorWords, RenderError, allocate};
use crate::scene::{Development, FRAME_RATES};
use crate::tone::Developer;
use rayon::prelude::*;
use relievo_shared::normals::CLASS_MISS;
use std::array;
use std::io::Write;
use std::path::Path;

/// A finished picture: 8-bit sRGB, rows from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// Red, green and blue of each pixel, and alpha if the background is transparent.
    pub bytes: Vec<u8>,
}

impl Picture {
    /// Develops each sample of `words`, averages `factor`² of them, and encodes as sRGB.
    ///
    /// # Errors
    /// [`RenderError::Memory`] if the memory does not suffice.
    ///
    /// # Panics
    /// If the sides of `words` are not multiples of `factor`.
    pub fn develop(
        words: &ColorWords,
        factor: u32,
        development: &Development,
    ) -> Result<Picture, RenderError> {
        assert!(words.width.is_multiple_of(factor) && words.height.is_multiple_of(factor));
        let (width, height) = (words.width / factor, words.height / factor);
        let developer = Developer::new(development);
        let channels = if development.is_transparent { 4 } else { 3 };
        let row = channels * width as usize;
        let mut bytes = allocate("the picture", row * height as usize, 0)?;
        bytes.par_chunks_mut(row).enumerate().for_each(|(y, row)| {
            for (x, pixel) in row.chunks_exact_mut(channels).enumerate() {
                let mut sum = [0.0f32; 3];
                let mut hits = 0.0;
                for sample in 0..factor * factor {
                    let sx = x as u32 * factor + sample % factor;
                    let sy = y as u32 * factor + sample / factor;
                    words.parts(sx, sy, |light, class, share| {
                        let is_hit = class != CLASS_MISS;
                        if is_hit {
                            hits += share;
                        }
                        if is_hit || !development.is_transparent {
                            let part = developer.part(light, class);
                            sum = array::from_fn(|i| sum[i] + part[i] * share);
                        }
                    });
                }
                let samples = (factor * factor) as f32;
                let coverage = hits / samples;
                let weight = match development.is_transparent {
                    true if hits > 0.0 => 1.0 / hits,
                    _ => 1.0 / samples,
                };
                for (byte, total) in pixel.iter_mut().zip(sum) {
                    *byte = srgb_byte(total * weight);
                }
                if let Some(alpha) = pixel.get_mut(3) {
                    *alpha = (255.0 * coverage + 0.5) as u8;
                }
            }
        });
        Ok(Picture {
            width,
            height,
            bytes,
        })
    }

    /// Returns the channels of a pixel: 3, or 4 with alpha.
    pub fn channels(&self) -> usize {
        match self.width as usize * self.height as usize {
            0 => 3,
            pixels => self.bytes.len() / pixels,
        }
    }

    /// Writes the picture as PNG, with `comments` as text chunks (keyword, text).
    ///
    /// # Errors
    /// [`Error::Write`] or [`Error::Encode`].
    pub fn save_png(&self, path: &Path, comments: &[(&str, &str)]) -> Result<(), Error> {
        write_whole(path, |file| self.encode(file, path, comments))
    }

    /// Encodes the picture as [`Picture::save_png`] does.
    ///
    /// # Errors
    /// [`Error::Encode`].
    pub fn png(&self, comments: &[(&str, &str)]) -> Result<Vec<u8>, Error> {
        let mut bytes = Vec::new();
        self.encode(&mut bytes, Path::new("the picture"), comments)?;
        Ok(bytes)
    }

    /// Writes pictures of one size as an animated PNG that repeats for ever, with
    /// `frames_per_second` rounded to four digits, and `comments` as [`Picture::save_png`] does.
    ///
    /// # Errors
    /// [`Error::Write`] or [`Error::Encode`].
    ///
    /// # Panics
    /// If there are no pictures, their sizes differ, or the rate is not one of
    /// [`FRAME_RATES`].
    pub fn save_animation(
        pictures: &[Picture],
        frames_per_second: f64,
        path: &Path,
        comments: &[(&str, &str)],
    ) -> Result<(), Error> {
        let first = &pictures[0];
        let (slowest, fastest) = FRAME_RATES;
        assert!((slowest..=fastest).contains(&frames_per_second));
        let is_even = |picture: &Picture| {
            (picture.width, picture.height, picture.channels())
                == (first.width, first.height, first.channels())
        };
        assert!(pictures.iter().all(is_even));
        let encode = encoding_error(path);
        write_whole(path, |file| {
            let mut encoder = first.encoder(file, comments).map_err(&encode)?;
            encoder
                .set_animated(pictures.len() as u32, 0)
                .map_err(&encode)?;
            // A delay of two whole numbers below 65536.
            let (mut numerator, mut denominator) = (1000.0, 1000.0 * frames_per_second);
            while denominator > f64::from(u16::MAX) {
                (numerator, denominator) = (numerator / 10.0, denominator / 10.0);
            }
            encoder
                .set_frame_delay(numerator as u16, denominator.round() as u16)
                .map_err(&encode)?;
            let mut writer = encoder.write_header().map_err(&encode)?;
            for picture in pictures {
                writer.write_image_data(&picture.bytes).map_err(&encode)?;
            }
            writer.finish().map_err(&encode)
        })
    }

    fn encode(
        &self,
        file: impl Write,
        path: &Path,
        comments: &[(&str, &str)],
    ) -> Result<(), Error> {
        let encode = encoding_error(path);
        let encoder = self.encoder(file, comments).map_err(&encode)?;
        let mut writer = encoder.write_header().map_err(&encode)?;
        writer.write_image_data(&self.bytes).map_err(&encode)?;
        writer.finish().map_err(&encode)
    }

    fn encoder<W: Write>(
        &self,
        file: W,
        comments: &[(&str, &str)],
    ) -> Result<png::Encoder<'static, W>, png::EncodingError> {
        let mut encoder = png::Encoder::new(file, self.width, self.height);
        encoder.set_color(match self.channels() {
            4 => png::ColorType::Rgba,
            _ => png::ColorType::Rgb,
        });
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        for (keyword, text) in comments {
            encoder.add_itxt_chunk((*keyword).to_string(), (*text).to_string())?;
        }
        Ok(encoder)
    }
}

/// Returns the conversion of the encoder's errors for the file at `path`.
fn encoding_error(path: &Path) -> impl Fn(png::EncodingError) -> Error + '_ {
    move |error| match error {
        png::EncodingError::IoError(source) => Error::Write {
            path: path.to_path_buf(),
            source,
        },
        other => Error::Encode {
            path: path.to_path_buf(),
            message: other.to_string(),
        },
    }
}

/// Converts a linear channel to sRGB, 0…1.
pub fn srgb(linear: f32) -> f32 {
    let x = linear.clamp(0.0, 1.0);
    if x <= 0.003_130_8 {
        12.92 * x
    } else {
        1.055 * x.powf(1.0 / 2.4) - 0.055
    }
}

/// Converts a linear channel to an sRGB byte; 0 for NaN.
fn srgb_byte(linear: f32) -> u8 {
    (srgb(linear) * 255.0 + 0.5) as u8
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Tone;
    use relievo_shared::Vec3;
    use relievo_shared::shading::edges::{Shares, light_words};

    #[test]
    fn bytes_survive_the_way_to_linear_light_and_back() {
        for byte in 0..=255u32 {
            let linear = crate::scene::Color::from_hex(byte << 16).linear()[0];
            assert_eq!(u32::from(srgb_byte(linear)), byte);
        }
        assert_eq!(srgb_byte(f32::NAN), 0);
        assert_eq!(srgb_byte(f32::INFINITY), 255);
    }

    #[test]
    fn samples_are_averaged_in_linear_light() {
        let words = |c: f32| [c.to_bits(), c.to_bits(), c.to_bits(), 1];
        let buffer = ColorWords {
            width: 2,
            height: 2,
            words: vec![words(0.0), words(1.0), words(1.0), words(0.0)],
        };
        let picture = Picture::develop(&buffer, 2, &Development::default()).unwrap();
        assert_eq!((picture.width, picture.height), (1, 1));
        assert_eq!(picture.bytes, [188; 3]);
    }

    #[test]
    fn shares_of_neighbours_are_blended_after_the_tone_curve() {
        // Half of the second pixel is the first one's, which is very bright, and a quarter of it
        // the third one's, which is background.
        let words = |c: f32, class: u32| [c.to_bits(), c.to_bits(), c.to_bits(), class];
        let divided = 1 | 255 << 8 | 128 << 16;
        let buffer = ColorWords {
            width: 3,
            height: 1,
            words: vec![words(100.0, 1), words(0.0, divided), words(0.0, CLASS_MISS)],
        };
        let development = |is_transparent| Development {
            tone: Tone::Agx,
            is_transparent,
            ..Development::default()
        };
        let opaque = Picture::develop(&buffer, 1, &development(false)).unwrap();
        assert!((187..=189).contains(&opaque.bytes[3]), "{:?}", opaque.bytes);
        let clear = Picture::develop(&buffer, 1, &development(true)).unwrap();
        // Two thirds of what is hit are white.
        assert_eq!(clear.bytes[7], 191);
        assert!((210..=214).contains(&clear.bytes[4]), "{:?}", clear.bytes);
        // Rows.
        let down = ColorWords {
            width: 1,
            height: 3,
            words: vec![
                words(1.0, 1),
                words(0.0, 1 | 255 << 8 | 1 << 24),
                words(0.0, 1),
            ],
        };
        let picture = Picture::develop(&down, 1, &Development::default()).unwrap();
        assert_eq!(picture.bytes[3..6], [188; 3]);
    }

    #[test]
    fn what_lies_between_is_blended_after_the_tone_curve_and_not_given_to_neighbours() {
        let shares = Shares {
            is_down: false,
            before: 0.0,
            after: 0.0,
            between: 0.5,
        };
        // Half of the first pixel is very bright; half of the second one is the first one's.
        let code = shares.code(1);
        let first = light_words(Vec3::ZERO, Vec3::splat(1000.0), code);
        let buffer = ColorWords {
            width: 2,
            height: 1,
            words: vec![[first.x, first.y, first.z, code], [0, 0, 0, 1 | 255 << 8]],
        };
        let development = Development {
            tone: Tone::Agx,
            ..Development::default()
        };
        let picture = Picture::develop(&buffer, 1, &development).unwrap();
        assert!((187..=189).contains(&picture.bytes[0]), "{picture:?}");
        assert_eq!(picture.bytes[3..], [0; 3]);
        assert_eq!(buffer.rgb(0, 0), [0.0; 3]);
    }

    #[test]
    fn the_background_is_not_exposed_and_may_be_transparent() {
        let words = |c: f32, class| [c.to_bits(), c.to_bits(), c.to_bits(), class];
        let buffer = ColorWords {
            width: 4,
            height: 2,
            words: [words(0.25, 1), words(1.0, CLASS_MISS)].repeat(4),
        };
        let development = |is_transparent| Development {
            exposure: 1.0,
            is_transparent,
            ..Development::default()
        };
        let opaque = Picture::develop(&buffer, 1, &development(false)).unwrap();
        assert_eq!(opaque.bytes[..6], [188, 188, 188, 255, 255, 255]);
        // The colour of a pixel is that of its hits.
        let half = Picture::develop(&buffer, 2, &development(true)).unwrap();
        assert_eq!(half.bytes, [188, 188, 188, 128].repeat(2));
        assert_eq!((half.width, half.height, half.channels()), (2, 1, 4));
        let one = Picture::develop(&buffer, 1, &development(true)).unwrap();
        assert_eq!(one.bytes[..8], [188, 188, 188, 255, 0, 0, 0, 0]);
        assert!(one.png(&[]).is_ok());
    }
}
