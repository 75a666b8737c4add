//! What a carved surface really looks like, where a closed form says it
//! (section 7 of the algorithm), and how far a rendering is from it.
//!
//! An oracle shares no marching code with the renderers, only the definition of
//! the pattern's edge: the zero set of the bilinear interpolation of the shape map.

mod torus;

pub use torus::TorusOracle;

use crate::render::GeometryWords;
use relievo_shared::normals::{CLASS_BEVEL, CLASS_MISS, CLASS_WALL};

/// What a ray really meets first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// `CLASS_MISS`, `CLASS_CAP`, `CLASS_WALL` for a side of any slope, or `CLASS_FLOOR`.
    pub class: u32,
    /// Distance from the eye, object units; 0 for a miss.
    pub t: f64,
}

impl Sample {
    /// A ray that meets nothing.
    pub const MISS: Sample = Sample {
        class: CLASS_MISS,
        t: 0.0,
    };

    /// Whether the ray meets anything.
    pub fn is_hit(self) -> bool {
        self.class != CLASS_MISS
    }
}

/// What every ray of a frame really meets.
#[derive(Clone, Debug, PartialEq)]
pub struct Truth {
    /// Width, pixels.
    pub width: usize,
    /// Height, pixels.
    pub height: usize,
    /// One sample a pixel, rows from the top.
    pub samples: Vec<Sample>,
}

/// How a pixel of a rendering compares with the truth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Nothing is there, and nothing was found.
    Nothing,
    /// The right class of surface was found.
    Same,
    /// Another class of surface was found.
    OtherClass,
    /// Something is there and was not found.
    Hole,
    /// Nothing is there, and something was found.
    Extra,
}

/// How well a rendering agrees with an oracle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Accuracy {
    /// Pixels hit in both, over pixels hit in either; 1 where there are none.
    pub silhouette_iou: f64,
    /// Pixels that the oracle hits and the rendering misses.
    pub holes: usize,
    /// Those more than one pixel inside the oracle's outline.
    pub interior_holes: usize,
    /// Pixels that the rendering hits and the oracle misses.
    pub extra: usize,
    /// 99th percentile of the error of t, object units, where both hit.
    pub distance_p99: f64,
    /// Share of the pixels hit in both whose class differs.
    pub class_errors: f64,
}

impl Truth {
    /// Compares each pixel of a rendering of the same frame with the truth.
    ///
    /// # Panics
    /// If `words` have another size.
    pub fn verdicts(&self, words: &GeometryWords) -> Vec<Verdict> {
        assert_eq!(
            (self.width, self.height),
            (words.width as usize, words.height as usize)
        );
        // The oracle does not tell bevels from walls.
        let side = |class| {
            if class == CLASS_BEVEL {
                CLASS_WALL
            } else {
                class
            }
        };
        self.samples
            .iter()
            .enumerate()
            .map(|(i, sample)| {
                let found = side(words.class(i));
                match (sample.is_hit(), found != CLASS_MISS) {
                    (false, false) => Verdict::Nothing,
                    (false, true) => Verdict::Extra,
                    (true, false) => Verdict::Hole,
                    (true, true) if sample.class == found => Verdict::Same,
                    (true, true) => Verdict::OtherClass,
                }
            })
            .collect()
    }

    /// Sums up how well a rendering of the same frame agrees.
    ///
    /// # Panics
    /// If `words` have another size.
    pub fn judge(&self, words: &GeometryWords) -> Accuracy {
        let verdicts = self.verdicts(words);
        let count = |wanted| verdicts.iter().filter(|found| **found == wanted).count();
        let [same, other, holes, extra] = [
            Verdict::Same,
            Verdict::OtherClass,
            Verdict::Hole,
            Verdict::Extra,
        ]
        .map(count);
        let interior_holes = (0..verdicts.len())
            .filter(|&i| verdicts[i] == Verdict::Hole && self.is_interior(i))
            .count();
        let mut errors: Vec<f64> = (0..verdicts.len())
            .filter(|&i| matches!(verdicts[i], Verdict::Same | Verdict::OtherClass))
            .map(|i| (self.samples[i].t - f64::from(f32::from_bits(words.place[i][0]))).abs())
            .collect();
        errors.sort_by(f64::total_cmp);
        let both = same + other;
        let either = both + holes + extra;
        Accuracy {
            silhouette_iou: if either == 0 {
                1.0
            } else {
                both as f64 / either as f64
            },
            holes,
            interior_holes,
            extra,
            distance_p99: errors.get(errors.len() * 99 / 100).copied().unwrap_or(0.0),
            class_errors: other as f64 / both.max(1) as f64,
        }
    }

    /// Whether pixel `i` and its eight neighbours are hit.
    fn is_interior(&self, i: usize) -> bool {
        let (x, y) = (i % self.width, i / self.width);
        (1..self.width.saturating_sub(1)).contains(&x)
            && (1..self.height.saturating_sub(1)).contains(&y)
            && (y - 1..=y + 1)
                .all(|y| (x - 1..=x + 1).all(|x| self.samples[y * self.width + x].is_hit()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use relievo_shared::normals::{CLASS_CAP, CLASS_FLOOR};

    /// A 4 × 4 picture that is hit everywhere but in its last column.
    #[test]
    fn each_kind_of_error_is_counted() {
        let samples = (0..16)
            .map(|i| match i % 4 {
                3 => Sample::MISS,
                _ => Sample {
                    class: CLASS_CAP,
                    t: 2.0,
                },
            })
            .collect();
        let truth = Truth {
            width: 4,
            height: 4,
            samples,
        };
        let mut words = GeometryWords {
            width: 4,
            height: 4,
            place: vec![[2.0f32.to_bits(), 0, 0, 0]; 16],
            surface: (0..16)
                .map(|i| [if i % 4 == 3 { 0 } else { CLASS_CAP | 7 << 8 }, 0, 0, 0])
                .collect(),
        };
        let right = truth.judge(&words);
        assert_eq!((right.silhouette_iou, right.class_errors), (1.0, 0.0));
        assert_eq!((right.holes, right.extra, right.distance_p99), (0, 0, 0.0));

        words.surface[0][0] = CLASS_MISS;
        words.surface[5][0] = CLASS_MISS;
        words.surface[3][0] = CLASS_FLOOR;
        words.surface[8][0] = CLASS_BEVEL;
        words.place[8][0] = 2.5f32.to_bits();
        let wrong = truth.judge(&words);
        assert_eq!(wrong.holes, 2);
        assert_eq!(wrong.interior_holes, 1);
        assert_eq!(wrong.extra, 1);
        assert_eq!(wrong.silhouette_iou, 10.0 / 13.0);
        assert_eq!(wrong.class_errors, 0.1);
        assert_eq!(wrong.distance_p99, 0.5);
    }
}
