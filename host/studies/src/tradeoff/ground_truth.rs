//! Ground truth of a subject, and the errors of pictures against it.

use super::Subject;
use super::grid::finest;
use super::remembered::Remembered;
use crate::perceptual::difference;
use glam::DVec3;
use relievo::Error;
use relievo::oracle::{MeshOracle, Truth};
use relievo::picture::Picture;
use relievo::prepare::{PreparedScene, prepare};
use relievo::render::{CpuRenderer, GeometryWords, Renderer};
use relievo::scene::{Development, Search, Tier};
use serde::{Deserialize, Serialize};

/// Errors are clamped to this, pixels.
const LARGEST_ERROR: f64 = 8.0;
/// Pixels with a larger error, in pixels, count as misplaced.
const MISPLACED: f64 = 0.5;

/// Errors of hits against the oracle, one ray per pixel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// Intersection over union of the hit pixels.
    pub silhouette_iou: f64,
    /// Pixels missed that should be hit.
    pub holes: u64,
    /// Holes more than one pixel inside the outline.
    pub interior_holes: u64,
    /// Pixels hit that should not be.
    pub extra: u64,
    /// 99th percentile of the error of t, world units, over pixels hit in both.
    pub distance_p99: f64,
    /// Fraction of the pixels hit in both whose class differs, 0…1.
    pub class_errors: f64,
    /// 99th percentile of the per-pixel error, pixels; infinite above 8.
    #[serde(with = "infinite")]
    pub error_px: f64,
    /// Fraction of the pixels with an error above half a pixel, 0…1.
    pub misplaced: f64,
}

/// Serializes infinity as null, because JSON has no number for it.
mod infinite {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub fn serialize<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
        value.is_finite().then_some(*value).serialize(serializer)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
        Ok(Option::deserialize(deserializer)?.unwrap_or(f64::INFINITY))
    }
}

/// A subject prepared with the finest settings.
pub struct Finest {
    scene: PreparedScene,
    /// Reason why the accurate tier cannot draw it, if so.
    pub refused: Option<String>,
}

impl Finest {
    /// Prepares `subject`. If its depth is too little for the accurate tier, only the
    /// oracle's prisms are available.
    ///
    /// # Errors
    /// [`Error`] if no tier can draw it.
    pub fn new(subject: &Subject) -> Result<Finest, Error> {
        let mut scene = subject.with(&finest(subject));
        for object in &mut scene.objects {
            object.search = Search::Extrusion;
        }
        match prepare(&scene, &|_| ()) {
            Ok(scene) => Ok(Finest {
                scene,
                refused: None,
            }),
            Err(error @ Error::Object { .. }) => {
                for object in &mut scene.objects {
                    object.tier = Tier::Fast;
                }
                Ok(Finest {
                    scene: prepare(&scene, &|_| ())?,
                    refused: Some(error.to_string()),
                })
            }
            Err(error) => Err(error),
        }
    }
}

/// Ground truth of a subject.
pub struct GroundTruth<'a> {
    oracle: Remembered<MeshOracle<'a>>,
    scene: &'a PreparedScene,
    truth: Truth,
    /// `None` if the accurate tier cannot draw it.
    picture: Option<Picture>,
}

impl<'a> GroundTruth<'a> {
    /// Traces and draws the truth, which is slow.
    ///
    /// # Errors
    /// [`Error`] if memory runs out.
    pub fn new(finest: &'a Finest) -> Result<GroundTruth<'a>, Error> {
        let scene = &finest.scene;
        let oracle = Remembered::new(MeshOracle::new(scene));
        let picture = match finest.refused {
            None => {
                let factor = scene.supersampling;
                let words = CpuRenderer::new(scene).color(&scene.frame_with_samples(factor))?;
                Some(Picture::develop(&words, factor, &Development::default())?)
            }
            Some(_) => None,
        };
        Ok(GroundTruth {
            truth: Truth::of(&oracle, DVec3::from(scene.camera.eye), &scene.frame),
            oracle,
            scene,
            picture,
        })
    }

    /// Returns the errors of hits, one ray per pixel.
    pub fn errors(&self, words: &GeometryWords) -> Errors {
        let accuracy = self.truth.compare(words);
        let displacements = self.truth.displacements(
            &self.oracle,
            DVec3::from(self.scene.camera.eye),
            &self.scene.frame,
            words,
            LARGEST_ERROR,
        );
        Errors {
            silhouette_iou: accuracy.silhouette_iou,
            holes: accuracy.holes as u64,
            interior_holes: accuracy.interior_holes as u64,
            extra: accuracy.extra as u64,
            distance_p99: accuracy.distance_p99,
            class_errors: accuracy.class_errors,
            error_px: displacements.error_px(),
            misplaced: displacements.share_above(MISPLACED),
        }
    }

    /// Returns the FLIP difference of `picture`, 0…1; `None` without a
    /// reference picture.
    pub fn flip(&self, picture: &Picture) -> Option<f64> {
        let reference = self.picture.as_ref()?;
        Some(difference(reference, picture))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn infinity_survives_json() {
        for error_px in [0.0, 0.35, f64::INFINITY] {
            let errors = Errors {
                silhouette_iou: 1.0,
                holes: 1,
                interior_holes: 0,
                extra: 2,
                distance_p99: 0.01,
                class_errors: 0.5,
                error_px,
                misplaced: 0.1,
            };
            let text = serde_json::to_string(&errors).unwrap();
            assert_eq!(serde_json::from_str::<Errors>(&text).unwrap(), errors);
        }
    }
}
