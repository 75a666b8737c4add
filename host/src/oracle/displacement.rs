//! Measures the errors of a picture in pixels: the displacement of each pixel.
//!
//! The error of a pixel is the smallest r such that the truth shows the pixel's
//! class and distance somewhere within r pixels of its centre. An edge drawn
//! half a pixel off has errors of half a pixel; a hole in a column has an error
//! of the distance to the nearest true hole.

use super::{Oracle, Sample, Truth, class_index};
use crate::render::GeometryWords;
use glam::DVec3;
use rayon::prelude::*;
use relievo_shared::layout::Frame;

/// Radii that are measured, pixels.
pub const RADII: [f64; 14] = [
    0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0,
];

/// Number of directions traced around a pixel.
const DIRECTIONS: usize = 16;

/// Quantile of the per-pixel error that is reported as `error_px`.
pub const SHARE: f64 = 0.99;

/// Allowed difference of the distance at the same class, in widths of a pixel at
/// the hit, beyond the range of the true distances around the pixel.
const DEPTH_MARGIN: f64 = 1.0;

/// Maximum number of wrong pixels to sample.
const MANY: usize = 1000;
/// Number of wrong pixels to sample first.
const FEW: usize = 200;
/// A share above this multiple of the allowed one is not measured more exactly.
const HOPELESS: f64 = 4.0;

/// The errors of a picture, in pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct Displacements {
    /// One for each pixel hit in the picture or the truth, ascending: 0, one of
    /// [`RADII`], the largest radius requested, or infinity.
    sorted: Vec<f64>,
}

impl Displacements {
    /// Returns the [`SHARE`] quantile of the errors, pixels; 0 without hits,
    /// infinity beyond the largest radius requested.
    pub fn error_px(&self) -> f64 {
        let kept = (SHARE * self.sorted.len() as f64).ceil() as usize;
        match kept.checked_sub(1) {
            Some(index) => self.sorted[index],
            None => 0.0,
        }
    }

    /// Returns the share of the pixels whose error exceeds `limit` pixels.
    pub fn share_above(&self, limit: f64) -> f64 {
        let right = self.sorted.partition_point(|error| *error <= limit);
        (self.sorted.len() - right) as f64 / self.sorted.len().max(1) as f64
    }

    /// Returns the number of pixels hit in the picture or the truth.
    pub fn pixels(&self) -> usize {
        self.sorted.len()
    }
}

impl Truth {
    /// Measures the errors of `words`, a picture of `frame` seen from `eye` (world
    /// units), whose truth from `oracle` this is. Errors above `largest` pixels
    /// are infinite. Of more than 1,000 wrong pixels a sample is measured.
    ///
    /// # Panics
    /// If `words` have another size.
    pub fn displacements(
        &self,
        oracle: &dyn Oracle,
        eye: DVec3,
        frame: &Frame,
        words: &GeometryWords,
        largest: f64,
    ) -> Displacements {
        let surroundings = Surroundings::new(self, oracle, eye, frame, 1.0);
        let smaller = RADII.into_iter().filter(|radius| *radius < largest);
        let radii: Vec<f64> = smaller.chain([largest]).collect();
        let shown = self.shown(words);
        let doubtful = surroundings.doubtful(&shown);
        let mut sorted = vec![0.0; shown.len() - doubtful.len()];
        let stand_for = doubtful.len().div_ceil(MANY).max(1);
        let errors: Vec<f64> = doubtful
            .par_iter()
            .step_by(stand_for)
            .map(|(i, shown)| surroundings.displacement(*i, *shown, &radii))
            .collect();
        sorted.extend((0..doubtful.len()).map(|number| errors[number / stand_for]));
        sorted.sort_by(f64::total_cmp);
        Displacements { sorted }
    }

    /// Returns the number of pixels hit in the picture or the truth, and the share
    /// of them whose error exceeds `limit` pixels.
    ///
    /// As [`Truth::displacements`], but `frame` has one ray every `stride` pixels,
    /// and a share far above [`SHARE`]'s allowance is an estimate.
    ///
    /// # Panics
    /// If `words` have another size.
    pub fn share_above(
        &self,
        oracle: &dyn Oracle,
        eye: DVec3,
        frame: &Frame,
        stride: f64,
        words: &GeometryWords,
        limit: f64,
    ) -> (usize, f64) {
        let surroundings = Surroundings::new(self, oracle, eye, frame, stride);
        let mut radii: Vec<f64> = std::iter::successors(Some(limit), |radius| Some(0.5 * radius))
            .take_while(|radius| *radius >= RADII[0])
            .collect();
        radii.reverse();
        let shown = self.shown(words);
        let pixels = shown.len();
        let doubtful = surroundings.doubtful(&shown);
        let wrong = |doubtful: &[(usize, Sample)], step: usize| {
            let some = doubtful.par_iter().step_by(step);
            let wrong = some
                .filter(|(i, shown)| surroundings.displacement(*i, *shown, &radii).is_infinite());
            wrong.count()
        };
        let share = |count: usize| count as f64 / pixels.max(1) as f64;
        // A sample decides whether all of them are worth measuring.
        let step = (doubtful.len() / FEW).max(1);
        let estimate = share(step * wrong(&doubtful, step)).min(1.0);
        if step == 1 || estimate > HOPELESS * (1.0 - SHARE) {
            (pixels, estimate)
        } else {
            (pixels, share(wrong(&doubtful, 1)))
        }
    }

    /// Returns the pixels hit in the picture or the truth, with the picture's hit.
    fn shown(&self, words: &GeometryWords) -> Vec<(usize, Sample)> {
        assert_eq!(
            (self.width, self.height),
            (words.width as usize, words.height as usize)
        );
        (0..self.samples.len())
            .map(|i| {
                let t = f64::from(words.t(i));
                let class = words.class(i);
                (i, Sample { class, t })
            })
            .filter(|(i, shown)| self.samples[*i].is_hit() || shown.is_hit())
            .collect()
    }
}

/// The truth in and around the pixels of a frame.
struct Surroundings<'a> {
    truth: &'a Truth,
    oracle: &'a dyn Oracle,
    eye: DVec3,
    frame: &'a Frame,
    stride: f64,
    /// Width of a pixel at distance 1.
    pixel: f64,
}

impl<'a> Surroundings<'a> {
    fn new(
        truth: &'a Truth,
        oracle: &'a dyn Oracle,
        eye: DVec3,
        frame: &'a Frame,
        stride: f64,
    ) -> Surroundings<'a> {
        let pixel = DVec3::from(frame.ray_right.map(f64::from)).length() / stride;
        Surroundings {
            truth,
            oracle,
            eye,
            frame,
            stride,
            pixel,
        }
    }

    /// Returns the pixels that differ from the truth at their centre.
    fn doubtful(&self, shown: &[(usize, Sample)]) -> Vec<(usize, Sample)> {
        let is_doubtful = |(i, shown): &&(usize, Sample)| self.displacement(*i, *shown, &[]) > 0.0;
        shown.par_iter().filter(is_doubtful).copied().collect()
    }

    /// See [`displacement`].
    fn displacement(&self, i: usize, shown: Sample, radii: &[f64]) -> f64 {
        let width = self.truth.width;
        let around = |radius: f64, direction: usize| {
            let angle = std::f64::consts::TAU * direction as f64 / DIRECTIONS as f64;
            let radius = radius / self.stride;
            let x = (i % width) as f64 + radius * angle.cos();
            let y = (i / width) as f64 + radius * angle.sin();
            self.oracle.trace(self.eye, ray_at(self.frame, x, y))
        };
        displacement(self.truth.samples[i], shown, self.pixel, radii, around)
    }
}

/// Returns the smallest of `radii` within which the truth, `there` at the centre
/// and `around` it, shows what is `shown`; `pixel` is the width of a pixel at
/// distance 1.
fn displacement(
    there: Sample,
    shown: Sample,
    pixel: f64,
    radii: &[f64],
    around: impl Fn(f64, usize) -> Sample,
) -> f64 {
    let class = class_index(shown.class);
    // Range of the distances at which the truth shows that class.
    let mut range = (f64::INFINITY, f64::NEG_INFINITY);
    let mut look = |sample: Sample, radius: f64| {
        if class_index(sample.class) != class {
            return false;
        }
        range = (range.0.min(sample.t), range.1.max(sample.t));
        let margin = DEPTH_MARGIN * radius * pixel * shown.t;
        !shown.is_hit() || (range.0 - margin <= shown.t && shown.t <= range.1 + margin)
    };
    if look(there, RADII[0]) {
        return 0.0;
    }
    for &radius in radii {
        // All directions, since the range is that of the whole circle.
        let mut is_shown = false;
        for direction in 0..DIRECTIONS {
            is_shown |= look(around(radius, direction), radius);
        }
        if is_shown {
            return radius;
        }
    }
    f64::INFINITY
}

/// Returns the unit direction through the point (`x`, `y`) of `frame`, pixels from
/// the centre of the first.
fn ray_at(frame: &Frame, x: f64, y: f64) -> DVec3 {
    let wide = |v: [f32; 3]| DVec3::from(v.map(f64::from));
    let raw = wide(frame.ray_first) + wide(frame.ray_right) * x + wide(frame.ray_down) * y;
    raw.normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use relievo_shared::normals::{CLASS_CAP, CLASS_FLOOR, CLASS_MISS, CLASS_WALL};

    /// A cap at distance 2 left of x = 0.5, seen along −z, pixels of width 1/10;
    /// a floor at distance 3 right of it, up to x = 1.
    struct Step;

    impl Oracle for Step {
        fn trace(&self, _: DVec3, direction: DVec3) -> Sample {
            let x = -direction.x / direction.z;
            let [class, t] = if x < 0.5 {
                [CLASS_CAP, 2]
            } else if x < 1.0 {
                [CLASS_FLOOR, 3]
            } else {
                [CLASS_MISS, 0]
            };
            let t = f64::from(t) * (1.0 + x * x).sqrt();
            Sample { class, t }
        }
    }

    fn frame() -> Frame {
        Frame {
            ray_first: [0.05, 0.0, -1.0],
            ray_right: [0.1, 0.0, 0.0],
            ray_down: [0.0, -0.1, 0.0],
            size: [12.0, 1.0],
            ..Frame::default()
        }
    }

    fn judged(change: impl Fn(&mut GeometryWords)) -> Displacements {
        let frame = frame();
        let truth = Truth::of(&Step, DVec3::ZERO, &frame);
        let mut words = GeometryWords {
            width: 12,
            height: 1,
            place: truth
                .samples
                .iter()
                .map(|sample| [(sample.t as f32).to_bits(), 0, 0, 0])
                .collect(),
            surface: truth
                .samples
                .iter()
                .map(|sample| [sample.class, 0, 0, 0])
                .collect(),
        };
        change(&mut words);
        truth.displacements(&Step, DVec3::ZERO, &frame, &words, 8.0)
    }

    #[test]
    fn what_is_right_has_no_error() {
        let right = judged(|_| ());
        assert_eq!(right.pixels(), 10);
        assert_eq!((right.error_px(), right.share_above(0.0)), (0.0, 0.0));
    }

    #[test]
    fn an_error_is_the_way_to_where_it_would_be_right() {
        // The cap reaches one pixel further: its edge is half a pixel from the
        // pixel's centre.
        let further = judged(|words| {
            words.surface[5][0] = CLASS_CAP;
            words.place[5][0] = (2.0f32 * 1.0f32.hypot(0.55)).to_bits();
        });
        assert_eq!(further.error_px(), 0.75);
        assert_eq!(further.share_above(0.5), 0.1);
        // Two pixels beyond it.
        let beyond = judged(|words| words.surface[11][0] = CLASS_FLOOR);
        assert!(beyond.error_px() >= 1.5, "{beyond:?}");
        // What is nowhere.
        let nowhere = judged(|words| words.surface[2][0] = CLASS_WALL);
        assert_eq!(nowhere.error_px(), f64::INFINITY);
        // The right class at a distance that it nowhere has.
        let nearer = judged(|words| words.place[2][0] = 1.0f32.to_bits());
        assert_eq!(nearer.error_px(), f64::INFINITY);
        let hole = judged(|words| words.surface[0][0] = CLASS_MISS);
        assert_eq!(hole.error_px(), f64::INFINITY);
    }
}
