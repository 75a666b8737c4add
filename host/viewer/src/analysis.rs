//! Analyses of a picture: its errors against the oracle, and the local depth.

use glam::DVec3;
use relievo::oracle::{MeshOracle, Truth};
use relievo::overlay::local_depth_picture;
use relievo::picture::Picture;
use relievo::prepare::PreparedScene;
use relievo::render::{CpuRenderer, RenderError, Renderer};
use relievo::scene::Camera;
use relievo_shared::layout::Frame;
use serde::{Deserialize, Serialize};

/// Quantity that is computed once the picture rests.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Analysis {
    /// Errors against the oracle.
    Errors,
    /// Where the local depth is less than the object's.
    LocalDepth,
}

impl Analysis {
    /// All variants, in menu order.
    pub const ALL: [Analysis; 2] = [Analysis::Errors, Analysis::LocalDepth];

    /// Returns the name shown to the user.
    pub fn name(self) -> &'static str {
        match self {
            Analysis::Errors => "error against the oracle",
            Analysis::LocalDepth => "reduced depth",
        }
    }

    /// Longer side of the picture, pixels: tracing a ray by the oracle takes a hundred
    /// times longer.
    fn longer_side(self) -> u32 {
        match self {
            Analysis::Errors => 320,
            Analysis::LocalDepth => 960,
        }
    }

    /// Returns the size of the picture for the size of a scene.
    pub fn size(self, scene: [u32; 2]) -> [u32; 2] {
        let longer = scene[0].max(scene[1]).max(1);
        scene.map(|side| (side * self.longer_side().min(longer) / longer).max(1))
    }
}

/// Result of an analysis.
pub struct Analysed {
    /// Picture of the errors, as `relievo accuracy` draws it, or of the local depth, as
    /// `relievo info --local-depth` does.
    pub picture: Picture,
    /// Summary in one line.
    pub text: String,
}

impl Analysed {
    /// Analyses the picture of `scene` in `frame`.
    ///
    /// # Errors
    /// [`RenderError::Memory`] if memory runs out.
    pub fn new(
        analysis: Analysis,
        scene: &PreparedScene,
        camera: &Camera,
        frame: &Frame,
    ) -> Result<Analysed, RenderError> {
        match analysis {
            Analysis::Errors => Analysed::errors(scene, camera, frame),
            Analysis::LocalDepth => Analysed::local_depth(scene, frame),
        }
    }

    /// Compares the picture of `scene` with its mesh as curved prisms.
    fn errors(
        scene: &PreparedScene,
        camera: &Camera,
        frame: &Frame,
    ) -> Result<Analysed, RenderError> {
        let words = CpuRenderer::new(scene).geometry(frame)?;
        let oracle = MeshOracle::new(scene);
        let truth = Truth::of(&oracle, DVec3::from(camera.eye), frame);
        let accuracy = truth.compare(&words);
        Ok(Analysed {
            picture: truth.picture(&words),
            text: format!(
                "silhouette {:.5}, interior holes {}, extra pixels {}, distance {:.2e} (99 % of the pixels), other classes {:.3} %",
                accuracy.silhouette_iou,
                accuracy.interior_holes,
                accuracy.extra,
                accuracy.distance_p99,
                100.0 * accuracy.class_errors
            ),
        })
    }

    fn local_depth(scene: &PreparedScene, frame: &Frame) -> Result<Analysed, RenderError> {
        let reduced: Vec<String> = scene
            .objects
            .iter()
            .filter_map(|object| {
                let local_depth = object.local_depth?;
                Some(format!("{}: {local_depth}", object.name))
            })
            .collect();
        let text = if reduced.is_empty() {
            "the depth is reduced nowhere".to_string()
        } else {
            reduced.join("; ")
        };
        Ok(Analysed {
            picture: local_depth_picture(scene, frame)?,
            text,
        })
    }
}
