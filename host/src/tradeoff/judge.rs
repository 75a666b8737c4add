//! The truth of a subject, and how far pictures are from it.

use super::Subject;
use super::grid::finest;
use super::measure::Errors;
use super::perceptual::difference;
use super::remembered::Remembered;
use crate::Error;
use crate::oracle::{MeshOracle, Truth};
use crate::picture::Picture;
use crate::prepare::{PreparedScene, prepare};
use crate::render::{CpuRenderer, GeometryWords, Renderer};
use crate::scene::{Search, Tier};
use glam::DVec3;

/// Errors above this are not told apart, pixels.
const LARGEST_ERROR: f64 = 8.0;
/// A pixel that is further from its place, in pixels, looks misplaced.
const MISPLACED: f64 = 0.5;

/// A subject drawn as finely as possible.
pub struct Finest {
    scene: PreparedScene,
    /// Why it cannot be drawn in the accurate tier, if so.
    pub folded: Option<String>,
}

impl Finest {
    /// Of `subject`; where its surface bends too much for the accurate tier,
    /// only with prisms for the oracle.
    ///
    /// # Errors
    /// [`Error`] where it cannot be drawn in any tier.
    pub fn new(subject: &Subject) -> Result<Finest, Error> {
        let mut scene = finest(subject).apply(subject);
        for object in &mut scene.objects {
            object.search = Search::Extrusion;
        }
        match prepare(&scene, &|_| ()) {
            Ok(scene) => Ok(Finest {
                scene,
                folded: None,
            }),
            Err(error @ Error::Object { .. }) => {
                for object in &mut scene.objects {
                    object.tier = Tier::Fast;
                }
                Ok(Finest {
                    scene: prepare(&scene, &|_| ())?,
                    folded: Some(error.to_string()),
                })
            }
            Err(error) => Err(error),
        }
    }

    /// The depth of each object, world units.
    pub fn depths(&self) -> impl Iterator<Item = f64> {
        let objects = self.scene.objects.iter();
        objects.map(|object| f64::from(object.parameters.depth))
    }
}

/// The truth of a subject.
pub struct Judge<'a> {
    oracle: Remembered<MeshOracle<'a>>,
    scene: &'a PreparedScene,
    truth: Truth,
    /// `None` where the surface bends too much for the accurate tier.
    picture: Option<Picture>,
}

impl<'a> Judge<'a> {
    /// Traces and draws the truth, which takes a while.
    ///
    /// # Errors
    /// [`Error`] where there is not enough memory.
    pub fn new(finest: &'a Finest) -> Result<Judge<'a>, Error> {
        let scene = &finest.scene;
        let oracle = Remembered::new(MeshOracle::new(scene));
        let picture = match finest.folded {
            None => {
                let factor = scene.supersampling;
                let words = CpuRenderer::new(scene).color(&scene.frame_with_samples(factor))?;
                Some(Picture::develop(&words, factor)?)
            }
            Some(_) => None,
        };
        Ok(Judge {
            truth: Truth::of(&oracle, DVec3::from(scene.camera.eye), &scene.frame),
            oracle,
            scene,
            picture,
        })
    }

    /// How far what is hit is from what is there, one ray a pixel.
    pub fn errors(&self, words: &GeometryWords) -> Errors {
        let accuracy = self.truth.judge(words);
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

    /// How different `picture` looks, 0…1; `None` where there is no true one.
    pub fn flip(&self, picture: &Picture) -> Option<f64> {
        let reference = self.picture.as_ref()?;
        Some(difference(reference, picture))
    }
}
