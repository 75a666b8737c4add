//! Pictures of materials, as words.

use super::super::memo::Memo;
use crate::Error;
use crate::Files;
use crate::limits::Account;
use crate::scene::Scene;
use crate::shape_map::load_picture;
use crate::srgb;
use image::{DynamicImage, Rgba32FImage};
use relievo_shared::shading::Image;
use relievo_shared::shading::image::halved;
use std::path::{Path, PathBuf};

/// Bytes per texel: two words, the smaller levels, and while it is read.
pub(super) const TEXEL: u64 = 40;

/// How the numbers of a picture are meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    /// Colours, sRGB.
    Color,
    /// Numbers, or vectors.
    Linear,
}

/// A picture and its smaller levels.
pub(super) struct Levels {
    /// Their sizes. The first word is the first of `words`.
    image: Image,
    words: Vec<u32>,
}

impl Levels {
    /// Appends them to `words`. Returns where they are.
    pub(super) fn append(&self, words: &mut Vec<u32>) -> Image {
        let first = words.len() as u32;
        words.extend(&self.words);
        Image {
            first,
            ..self.image
        }
    }

    /// Returns the number of texels of the first level.
    pub(super) fn texels(&self) -> u64 {
        u64::from(self.image.width) * u64::from(self.image.height)
    }
}

/// The pictures of a scene; each is appended once.
pub(super) struct Pictures<'a> {
    scene: &'a Scene,
    baked: &'a mut Memo<(PathBuf, Encoding), Levels>,
    appended: Vec<(PathBuf, Encoding, Image)>,
}

impl<'a> Pictures<'a> {
    /// Returns no pictures. Those that are asked for are taken from `baked`, and kept there.
    pub(super) fn new(
        scene: &'a Scene,
        baked: &'a mut Memo<(PathBuf, Encoding), Levels>,
    ) -> Pictures<'a> {
        Pictures {
            scene,
            baked,
            appended: Vec::new(),
        }
    }

    /// Returns the picture of a file, whose words are appended to `words` when it is first asked
    /// for.
    pub(super) fn load(
        &mut self,
        path: &Path,
        encoding: Encoding,
        words: &mut Vec<u32>,
        account: &mut Account<'_>,
    ) -> Result<Image, Error> {
        self.load_from(&self.scene.files, path, encoding, words, account)
    }

    /// As [`Pictures::load`], for files that the scene does not name: the paths have to differ
    /// from theirs.
    pub(super) fn load_from(
        &mut self,
        files: &Files,
        path: &Path,
        encoding: Encoding,
        words: &mut Vec<u32>,
        account: &mut Account<'_>,
    ) -> Result<Image, Error> {
        let mut appended = self.appended.iter();
        if let Some((_, _, image)) =
            appended.find(|(other, meant, _)| other == path && *meant == encoding)
        {
            return Ok(*image);
        }
        let key = (path.to_path_buf(), encoding);
        let levels = match self.baked.get(&key) {
            Some(levels) => {
                account.take(path.display(), levels.texels(), TEXEL)?;
                levels
            }
            None => {
                let max_pixels = self.scene.limits.pixels.min(account.left(TEXEL));
                let picture = load_picture(files, path, max_pixels)?;
                let pixels = u64::from(picture.width()) * u64::from(picture.height());
                account.take(path.display(), pixels, TEXEL)?;
                self.baked.insert(key, levels(linear(picture, encoding)))
            }
        };
        let image = levels.append(words);
        self.appended.push((path.to_path_buf(), encoding, image));
        Ok(image)
    }
}

/// Returns the linear numbers of `picture`.
pub(super) fn linear(picture: DynamicImage, encoding: Encoding) -> Rgba32FImage {
    let has_light = matches!(
        picture,
        DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_)
    );
    let mut pixels = picture.into_rgba32f();
    // Pictures of floats are linear already.
    if encoding == Encoding::Color && !has_light {
        for pixel in pixels.pixels_mut() {
            for channel in &mut pixel.0[..3] {
                *channel = srgb::linear(f64::from(*channel)) as f32;
            }
        }
    }
    pixels
}

/// Returns the next level of `picture`, whose texels are the means of the areas that they cover. The
/// filters of the library limit light to 1, and reach beyond the edges, where pictures repeat.
pub(super) fn halve(picture: &Rgba32FImage) -> Rgba32FImage {
    let (width, height) = picture.dimensions();
    let (columns, rows) = (halved(width), halved(height));
    // Up to three texels along each axis, with their shares.
    let covered = |index: u32, count: u32, size: u32| {
        let scale = f64::from(size) / f64::from(count);
        let (start, end) = (f64::from(index) * scale, f64::from(index + 1) * scale);
        let last = (end.ceil() as u32).min(size);
        (start as u32..last).map(move |texel| {
            let (low, high) = (f64::from(texel), f64::from(texel + 1));
            (texel, ((high.min(end) - low.max(start)) / scale) as f32)
        })
    };
    Rgba32FImage::from_fn(columns, rows, |x, y| {
        let mut sum = [0.0; 4];
        for (row, down) in covered(y, rows, height) {
            for (column, across) in covered(x, columns, width) {
                let texel = picture.get_pixel(column, row).0;
                for (sum, part) in sum.iter_mut().zip(texel) {
                    *sum += part * across * down;
                }
            }
        }
        image::Rgba(sum)
    })
}

/// Returns `picture` and its smaller levels.
pub(super) fn levels(mut picture: Rgba32FImage) -> Levels {
    let mut words = Vec::new();
    let mut image = Image {
        first: 0,
        width: picture.width(),
        height: picture.height(),
        levels: 0,
    };
    loop {
        for pixel in picture.pixels() {
            let [r, g, b, a] = pixel
                .0
                .map(|x| (x.clamp(0.0, 1.0) * 65_535.0).round() as u32);
            words.extend([r | g << 16, b | a << 16]);
        }
        image.levels += 1;
        let (width, height) = picture.dimensions();
        if width == 1 && height == 1 {
            return Levels { image, words };
        }
        picture = halve(&picture);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_level_keeps_the_mean() {
        for (width, height) in [(4, 4), (5, 3), (7, 1), (1, 6)] {
            let picture = Rgba32FImage::from_fn(width, height, |x, y| {
                image::Rgba([x as f32, y as f32, (x * y) as f32, 1.0])
            });
            let mean = |picture: &Rgba32FImage| {
                let sum = picture.pixels().fold([0.0; 4], |sum, pixel| {
                    [0, 1, 2, 3].map(|i| sum[i] + pixel.0[i])
                });
                sum.map(|sum| sum / picture.pixels().len() as f32)
            };
            let smaller = halve(&picture);
            assert_eq!(smaller.dimensions(), (halved(width), halved(height)));
            let (before, after) = (mean(&picture), mean(&smaller));
            assert!(
                before.iter().zip(after).all(|(a, b)| (a - b).abs() < 1e-4),
                "{before:?} {after:?}"
            );
        }
    }
}
