//! From the light of a scene to linear colours of a screen.

use crate::render::ColorWords;
use crate::scene::{Development, Tone};
use glam::{Mat3, Vec3};
use relievo_shared::normals::CLASS_MISS;
use std::array;

/// Linear sRGB to linear Rec. 2020, and back (ITU-R BT.2407).
const TO_WIDE: Mat3 = Mat3::from_cols_array(&[
    0.6274, 0.0691, 0.0164, 0.3293, 0.9195, 0.0880, 0.0433, 0.0113, 0.8956,
]);
const FROM_WIDE: Mat3 = Mat3::from_cols_array(&[
    1.6605, -0.1246, -0.0182, -0.5876, 1.1329, -0.1006, -0.0728, -0.0083, 1.1187,
]);
/// AgX's inset into the gamut, and its outset.
#[rustfmt::skip]
const INSET: Mat3 = Mat3::from_cols_array(&[
    0.856_627_15, 0.137_318_97, 0.111_898_21,
    0.095_121_24, 0.761_242, 0.076_799_42,
    0.048_251_606, 0.101_439_04, 0.811_302_37,
]);
#[rustfmt::skip]
const OUTSET: Mat3 = Mat3::from_cols_array(&[
    1.127_100_6, -0.141_329_76, -0.141_329_76,
    -0.110_606_64, 1.157_823_7, -0.110_606_64,
    -0.016_493_939, -0.016_493_939, 1.251_936_4,
]);
/// Darkest and brightest light that AgX tells apart: 10 stops below a grey of 18 %, and 6.5 above,
/// as logarithms to base 2.
const RANGE: [f32; 2] = [-12.47393, 4.026069];

/// Shoulder of AgX, fitted: light that is mixed before the curve, each part weighted by
/// 1 / (1 + shoulder × sum of its channels), is about as bright as light that is mixed after it.
const AGX_SHOULDER: f32 = 0.5;

/// Develops the pixels of one picture.
///
/// ```
/// use relievo::scene::{Development, Tone};
/// use relievo::tone::Developer;
///
/// let agx = Development { tone: Tone::Agx, exposure: 1.0, ..Development::default() };
/// let [grey, ..] = Developer::new(&agx).shown([0.09; 3]);
/// assert!((grey - 0.18).abs() < 0.04);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Developer {
    /// Factor of the exposure.
    pub gain: f32,
    tone: Tone,
}

impl Developer {
    /// Creates the developer of pictures with this exposure and tone curve.
    pub fn new(development: &Development) -> Developer {
        Developer {
            gain: development.exposure.exp2() as f32,
            tone: development.tone,
        }
    }

    /// Returns how fast the curve flattens: see [`Lighting`](relievo_shared::shading::Lighting).
    pub fn shoulder(&self) -> f32 {
        match self.tone {
            Tone::Clip => 0.0,
            Tone::Agx => AGX_SHOULDER * self.gain,
        }
    }

    /// Returns the colour that the screen shows for `light`, both linear sRGB.
    pub fn shown(&self, light: [f32; 3]) -> [f32; 3] {
        let light = light.map(|channel| channel * self.gain);
        match self.tone {
            Tone::Clip => light,
            Tone::Agx => agx(light.into()).to_array(),
        }
    }

    /// Returns the colour that the screen shows for the `light` of a surface class, both linear
    /// sRGB. The background keeps its colour.
    pub fn part(&self, light: [f32; 3], class: u32) -> [f32; 3] {
        match class {
            CLASS_MISS => light,
            _ => self.shown(light),
        }
    }

    /// Returns the colour that the screen shows for a pixel of `words`, linear sRGB.
    pub fn pixel(&self, words: &ColorWords, x: u32, y: u32) -> [f32; 3] {
        let mut color = [0.0; 3];
        words.parts(x, y, |light, class, share| {
            let part = self.part(light, class);
            color = array::from_fn(|i| color[i] + part[i] * share);
        });
        color
    }
}

/// AgX, with the polynomial of Benjamin Wrensch ("Minimal AgX Implementation", 2024) for its
/// curve, whose mean square error is 4e-6.
fn agx(light: Vec3) -> Vec3 {
    let [low, high] = RANGE;
    let inset = INSET * (TO_WIDE * light);
    let stops = inset
        .to_array()
        .map(|x| (x.max(1e-10).log2() - low) / (high - low));
    let curve = |x: f32| {
        let x = x.clamp(0.0, 1.0);
        let (x2, x4) = (x * x, x * x * x * x);
        15.5 * x4 * x2 - 40.14 * x4 * x + 31.96 * x4 - 6.868 * x2 * x + 0.4298 * x2 + 0.1191 * x
            - 0.00232
    };
    let outset = OUTSET * Vec3::from(stops.map(curve));
    let linear = outset.to_array().map(|x| x.max(0.0).powf(2.2));
    (FROM_WIDE * Vec3::from(linear)).clamp(Vec3::ZERO, Vec3::ONE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::srgb;

    const AGX: Development = Development {
        exposure: 0.0,
        tone: Tone::Agx,
        is_transparent: false,
    };

    #[test]
    fn agx_keeps_greys_grey_rises_and_ends_at_white() {
        let mut before = -1.0;
        for stop in -12..=8 {
            let [r, g, b] = Developer::new(&AGX).shown([0.18 * (stop as f32).exp2(); 3]);
            assert!((r - g).abs() < 0.01 && (g - b).abs() < 0.01, "{r} {g} {b}");
            assert!(g >= before - 1e-4, "{stop}: {g} {before}");
            before = g;
        }
        assert!(before > 0.9, "{before}");
        // Middle grey is half way on the screen.
        let middle = srgb(Developer::new(&AGX).shown([0.18; 3])[1]);
        assert!((0.4..0.55).contains(&middle), "{middle}");
        // Very bright red fades to white, which a cut-off leaves red.
        let [r, g, _] = Developer::new(&AGX).shown([100.0, 0.0, 0.0]);
        assert!(r > 0.8 && g > 0.3, "{r} {g}");
        for odd in [f32::NAN, f32::INFINITY, -1.0] {
            let all = Developer::new(&AGX).shown([odd; 3]);
            assert!(
                all.iter().all(|x| (0.0..=1.0).contains(x)),
                "{odd}: {all:?}"
            );
        }
    }

    #[test]
    fn light_mixes_before_agx_as_after_it() {
        // Two lights on surfaces of a few colours, in shares of tenths.
        let colors = [
            [0.8, 0.8, 0.8],
            [0.4, 0.12, 0.08],
            [0.1, 0.3, 0.1],
            [0.05, 0.1, 0.5],
        ];
        let lights = [0.02, 0.05, 0.1, 0.25, 0.5, 1.0, 2.0];
        let mean_error = |exposure: f64, is_weighted: bool| {
            let developer = Developer::new(&Development { exposure, ..AGX });
            let shoulder = if is_weighted {
                developer.shoulder()
            } else {
                0.0
            };
            let (mut sum, mut count) = (0.0, 0.0);
            let pairs = (0..lights.len()).flat_map(|i| (0..i).map(move |j| (lights[j], lights[i])));
            let cases = pairs.flat_map(|(dark, bright)| colors.map(|color| (color, dark, bright)));
            for (color, dark, bright) in cases {
                for tenth in 1..10 {
                    let share = 0.1 * tenth as f32;
                    let parts = [(dark, 1.0 - share), (bright, share)];
                    let (mut before, mut after, mut total) = ([0.0; 3], [0.0; 3], 0.0);
                    for (light, share) in parts {
                        let rgb = color.map(|x| x * light);
                        let weight = share / (1.0 + shoulder * rgb.iter().sum::<f32>());
                        before = array::from_fn(|i| before[i] + rgb[i] * weight);
                        let shown = developer.shown(rgb);
                        after = array::from_fn(|i| after[i] + shown[i] * share);
                        total += weight;
                    }
                    let before = developer.shown(before.map(|x| x / total));
                    for (before, after) in before.into_iter().zip(after) {
                        sum += srgb(before) - srgb(after);
                        count += 1.0;
                    }
                }
            }
            sum / count
        };
        for exposure in [-1.0, 0.0, 1.0, 2.0] {
            let [plain, weighted] = [false, true].map(|is| mean_error(exposure, is));
            // A step of 8 bits is 0.004. In dark pictures there is little to correct.
            assert!(weighted.abs() < 0.006, "{exposure}: {weighted}");
            if exposure >= 0.0 {
                assert!(
                    weighted.abs() < 0.3 * plain,
                    "{exposure}: {plain} {weighted}"
                );
            }
        }
        assert_eq!(Developer::new(&Development::default()).shoulder(), 0.0);
    }

    #[test]
    fn a_stop_doubles_the_light() {
        let exposed = Development {
            exposure: 1.0,
            ..Development::default()
        };
        assert_eq!(
            Developer::new(&exposed).shown([0.25, 0.5, 1.5]),
            [0.5, 1.0, 3.0]
        );
        assert_eq!(
            Developer::new(&Development::default()).shown([0.3, 0.5, 1.5]),
            [0.3, 0.5, 1.5]
        );
    }
}
