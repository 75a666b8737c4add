//! Traces the true carved surface (section 7), and measures the errors of a
//! rendering against it.
//!
//! An oracle shares no marching code with the renderers, only the definition of
//! the pattern's edge: the zero set of the bilinear interpolation of the shape map.
//!
//! ```
//! use glam::DVec3;
//! use relievo::oracle::{MeshOracle, Truth};
//! use relievo::prepare::prepare;
//! use relievo::render::{CpuRenderer, Renderer};
//! use relievo::scene::Scene;
//! use relievo::{Files, Limits};
//! use std::path::Path;
//!
//! let quad = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
//! let files = Files::memory([("quad.obj".into(), quad.as_bytes().into())]);
//! let text = r#"
//! image.size = [40, 30]
//! [[object]]
//! mesh = "quad.obj"
//! shape = { text = "A" }
//! projection = "planar-z"
//! tier = "accurate"
//! "#;
//! let scene = Scene::parse_with(text, Path::new(""), &Limits::default(), files)?;
//! let prepared = prepare(&scene, &|_| ())?;
//! let eye = DVec3::from(prepared.camera.eye);
//! let truth = Truth::of(&MeshOracle::new(&prepared), eye, &prepared.frame);
//! let words = CpuRenderer::new(&prepared).geometry(&prepared.frame)?;
//! assert!(truth.compare(&words).silhouette_iou > 0.9);
//! # Ok::<(), relievo::Error>(())
//! ```

mod analytic;
mod displacement;
mod ellipsoid;
mod flat;
mod known;
mod mesh;
mod prism_search;
mod report;
mod saddle;
mod shape;
mod sphere;
mod torus;
pub mod wide;

pub use analytic::AnalyticOracle;
pub use displacement::{Displacements, RADII, SHARE};
pub use ellipsoid::Ellipsoid;
pub use flat::{Cylinder, Plane};
pub use known::{KNOWN, UnknownShape};
pub use mesh::{MeshOracle, PrismSample};
pub use report::SceneReport;
pub use saddle::Saddle;
pub use shape::{Foot, Metric, Shape};
pub use sphere::Sphere;
pub use torus::Torus;

use crate::picture::Picture;
use crate::render::GeometryWords;
use crate::scene::Color;
use glam::DVec3;
use rayon::prelude::*;
use relievo_shared::layout::Frame;
use relievo_shared::normals::{CLASS_CAP, CLASS_FLOOR, CLASS_MISS};

/// Traces rays through the true surface.
pub trait Oracle: Sync {
    /// Returns the first hit of the ray from `eye` (world units) along the unit
    /// vector `direction`.
    fn trace(&self, eye: DVec3, direction: DVec3) -> Sample;
}

/// Several objects, each with its own oracle; traces the nearest hit of all.
pub struct Nearest<'a>(pub Vec<Box<dyn Oracle + 'a>>);

impl Oracle for Nearest<'_> {
    fn trace(&self, eye: DVec3, direction: DVec3) -> Sample {
        self.0
            .iter()
            .map(|oracle| oracle.trace(eye, direction))
            .filter(|sample| sample.is_hit())
            .min_by(|a, b| a.t.total_cmp(&b.t))
            .unwrap_or(Sample::MISS)
    }
}

/// The true first hit of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// `CLASS_MISS`, `CLASS_CAP`, `CLASS_WALL` for a side of any slope, or `CLASS_FLOOR`.
    pub class: u32,
    /// Distance from the eye, world units; 0 for a miss.
    pub t: f64,
}

impl Sample {
    /// A ray without a hit.
    pub const MISS: Sample = Sample {
        class: CLASS_MISS,
        t: 0.0,
    };

    /// Returns whether the ray hits anything.
    pub fn is_hit(self) -> bool {
        self.class != CLASS_MISS
    }
}

/// The true hits of all rays of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Truth {
    /// Width, pixels.
    pub width: usize,
    /// Height, pixels.
    pub height: usize,
    /// One sample per pixel, rows from the top.
    pub samples: Vec<Sample>,
}

/// Comparison of a pixel of a rendering with the truth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// A miss in both.
    Nothing,
    /// A hit of the same class.
    Same,
    /// A hit of another class.
    OtherClass,
    /// A miss where the truth has a hit, at most one pixel inside its outline.
    Hole,
    /// A miss where the truth has a hit, more than one pixel inside its outline.
    InteriorHole,
    /// A hit where the truth has a miss.
    Extra,
}

/// Classes of [`Accuracy::confusion`]; an oracle does not distinguish bevels from
/// walls.
pub const CLASS_NAMES: [&str; 4] = ["miss", "cap", "side", "floor"];

/// Returns the index of `class` in [`CLASS_NAMES`].
fn class_index(class: u32) -> usize {
    match class {
        CLASS_MISS => 0,
        CLASS_CAP => 1,
        CLASS_FLOOR => 3,
        _ => 2,
    }
}

/// Agreement of a rendering with an oracle.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Accuracy {
    /// Pixels hit in both, over pixels hit in either; 1 if there are none.
    pub silhouette_iou: f64,
    /// Pixels that only the oracle hits.
    pub holes: usize,
    /// Holes more than one pixel inside the oracle's outline.
    pub interior_holes: usize,
    /// Pixels that only the rendering hits.
    pub extra: usize,
    /// Root mean square error of t where both hit, world units.
    pub distance_rmse: f64,
    /// 0.99 quantile of the error of t where both hit, world units.
    pub distance_p99: f64,
    /// Share of the pixels hit in both whose class differs.
    pub class_errors: f64,
    /// Number of pixels by class of the oracle (row) and of the rendering (column),
    /// in the order of [`CLASS_NAMES`].
    pub confusion: [[usize; 4]; 4],
}

impl Truth {
    /// Traces each ray of `frame`, seen from `eye` (world units).
    pub fn of(oracle: &dyn Oracle, eye: DVec3, frame: &Frame) -> Truth {
        let [width, height] = frame.size.map(|side| side as usize);
        let samples = (0..width * height)
            .into_par_iter()
            .map(|i| oracle.trace(eye, ray(frame, i % width, i / width)))
            .collect();
        Truth {
            width,
            height,
            samples,
        }
    }

    /// Compares each pixel of a rendering of the same frame with the truth.
    ///
    /// # Panics
    /// If `words` and the truth differ in size.
    pub fn verdicts(&self, words: &GeometryWords) -> Vec<Verdict> {
        assert_eq!(
            (self.width, self.height),
            (words.width as usize, words.height as usize)
        );
        self.samples
            .iter()
            .enumerate()
            .map(|(i, sample)| {
                let [there, found] = [sample.class, words.class(i)].map(class_index);
                match (there != 0, found != 0) {
                    (false, false) => Verdict::Nothing,
                    (false, true) => Verdict::Extra,
                    (true, false) if self.is_interior(i) => Verdict::InteriorHole,
                    (true, false) => Verdict::Hole,
                    (true, true) if there == found => Verdict::Same,
                    (true, true) => Verdict::OtherClass,
                }
            })
            .collect()
    }

    /// Measures the agreement of a rendering of the same frame.
    ///
    /// # Panics
    /// If `words` and the truth differ in size.
    pub fn compare(&self, words: &GeometryWords) -> Accuracy {
        let verdicts = self.verdicts(words);
        let count = |wanted| verdicts.iter().filter(|found| **found == wanted).count();
        let [same, other, edge_holes, interior_holes, extra] = [
            Verdict::Same,
            Verdict::OtherClass,
            Verdict::Hole,
            Verdict::InteriorHole,
            Verdict::Extra,
        ]
        .map(count);
        let holes = edge_holes + interior_holes;
        let mut errors: Vec<f64> = (0..verdicts.len())
            .filter(|&i| matches!(verdicts[i], Verdict::Same | Verdict::OtherClass))
            .map(|i| (self.samples[i].t - f64::from(words.t(i))).abs())
            .collect();
        errors.sort_by(f64::total_cmp);
        let squares: f64 = errors.iter().map(|error| error * error).sum();
        let mut confusion = [[0; 4]; 4];
        for (i, sample) in self.samples.iter().enumerate() {
            confusion[class_index(sample.class)][class_index(words.class(i))] += 1;
        }
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
            distance_rmse: (squares / both.max(1) as f64).sqrt(),
            distance_p99: errors.get(errors.len() * 99 / 100).copied().unwrap_or(0.0),
            class_errors: other as f64 / both.max(1) as f64,
            confusion,
        }
    }

    /// Draws the differences of `words` from the truth: holes red, interior holes
    /// purple, extra pixels blue, another class yellow, and agreement in greys by
    /// class.
    ///
    /// # Panics
    /// If `words` and the truth differ in size.
    pub fn picture(&self, words: &GeometryWords) -> Picture {
        let bytes = self
            .verdicts(words)
            .into_iter()
            .zip(&self.samples)
            .flat_map(|(verdict, sample)| color_of(verdict, *sample).0)
            .map(|channel| (255.0 * channel).round() as u8)
            .collect();
        Picture {
            width: words.width,
            height: words.height,
            bytes,
        }
    }

    /// Returns whether pixel `i` and its eight neighbours are hit.
    fn is_interior(&self, i: usize) -> bool {
        let (x, y) = (i % self.width, i / self.width);
        (1..self.width.saturating_sub(1)).contains(&x)
            && (1..self.height.saturating_sub(1)).contains(&y)
            && (y - 1..=y + 1)
                .all(|y| (x - 1..=x + 1).all(|x| self.samples[y * self.width + x].is_hit()))
    }
}

fn color_of(verdict: Verdict, sample: Sample) -> Color {
    Color::from_hex(match verdict {
        Verdict::Hole => 0xd4_1f26,
        Verdict::InteriorHole => 0x8a_1fb4,
        Verdict::Extra => 0x1f_5fd4,
        Verdict::OtherClass => 0xf0_b400,
        Verdict::Nothing | Verdict::Same => match sample.class {
            CLASS_MISS => 0xff_ffff,
            CLASS_CAP => 0xd6_d9dd,
            CLASS_FLOOR => 0x9a_a1a9,
            _ => 0xb8_bdc4,
        },
    })
}

/// Returns the unit direction through the centre of pixel (`x`, `y`) of `frame`.
fn ray(frame: &Frame, x: usize, y: usize) -> DVec3 {
    let wide = |v: [f32; 3]| DVec3::from(v.map(f64::from));
    let raw =
        wide(frame.ray_first) + wide(frame.ray_right) * x as f64 + wide(frame.ray_down) * y as f64;
    raw.normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use relievo_shared::normals::CLASS_BEVEL;

    struct Always(Sample);

    impl Oracle for Always {
        fn trace(&self, _: DVec3, _: DVec3) -> Sample {
            self.0
        }
    }

    #[test]
    fn the_nearest_of_several_objects_is_met() {
        let at = |class, t| Box::new(Always(Sample { class, t })) as Box<dyn Oracle>;
        let miss = || Box::new(Always(Sample::MISS)) as Box<dyn Oracle>;
        let trace = |oracles| Nearest(oracles).trace(DVec3::ZERO, DVec3::X);
        let near = trace(vec![at(CLASS_CAP, 3.0), miss(), at(CLASS_FLOOR, 2.0)]);
        assert_eq!((near.class, near.t), (CLASS_FLOOR, 2.0));
        assert_eq!(trace(vec![miss(), miss()]), Sample::MISS);
    }

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
        let right = truth.compare(&words);
        assert_eq!((right.silhouette_iou, right.class_errors), (1.0, 0.0));
        assert_eq!((right.holes, right.extra, right.distance_p99), (0, 0, 0.0));

        words.surface[0][0] = CLASS_MISS;
        words.surface[5][0] = CLASS_MISS;
        words.surface[3][0] = CLASS_FLOOR;
        words.surface[8][0] = CLASS_BEVEL;
        words.place[8][0] = 2.5f32.to_bits();
        let wrong = truth.compare(&words);
        assert_eq!(wrong.holes, 2);
        assert_eq!(wrong.interior_holes, 1);
        assert_eq!(wrong.extra, 1);
        assert_eq!(wrong.silhouette_iou, 10.0 / 13.0);
        assert_eq!(wrong.class_errors, 0.1);
        assert_eq!(wrong.distance_p99, 0.5);
        // Ten pixels are hit in both; one of them is off by a half.
        assert_eq!(wrong.distance_rmse, (0.25f64 / 10.0).sqrt());
        let none = [0; 4];
        assert_eq!(wrong.confusion, [[3, 0, 0, 1], [2, 9, 1, 0], none, none]);

        let pixel = |i: usize| truth.picture(&words).bytes[3 * i..3 * i + 3].to_vec();
        let colors = [0, 5, 3, 8, 1, 7].map(pixel);
        for (i, color) in colors.iter().enumerate() {
            assert!(!colors[..i].contains(color), "{colors:?}");
        }
    }
}
