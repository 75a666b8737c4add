//! How wrong a picture is: the oracle's verdict.

use crate::oracle::{MeshOracle, Truth};
use crate::picture::Picture;
use crate::prepare::PreparedScene;
use crate::render::{CpuRenderer, RenderError, Renderer};
use crate::scene::Camera;
use glam::DVec3;
use relievo_shared::layout::Frame;

/// The longer side of a picture that is judged, pixels: a ray of the oracle
/// takes a hundred times as long as one of ours.
const LONGER_SIDE: u32 = 320;

/// The size of the judged picture of a scene.
pub fn size(scene: [u32; 2]) -> [u32; 2] {
    let longer = scene[0].max(scene[1]).max(1);
    scene.map(|side| (side * LONGER_SIDE.min(longer) / longer).max(1))
}

/// What the oracle says of a picture.
pub struct Judgement {
    /// Its errors, as `relievo accuracy` draws them.
    pub picture: Picture,
    /// The figures, in a line.
    pub text: String,
}

impl Judgement {
    /// Of the picture of `scene` in `frame`, against its mesh as curved prisms.
    ///
    /// # Errors
    /// [`RenderError::Memory`].
    pub fn of(
        scene: &PreparedScene,
        camera: &Camera,
        frame: &Frame,
    ) -> Result<Judgement, RenderError> {
        let words = CpuRenderer::new(scene).geometry(frame)?;
        let oracle = MeshOracle::new(scene);
        let truth = Truth::of(&oracle, DVec3::from(camera.eye), frame);
        let accuracy = truth.judge(&words);
        Ok(Judgement {
            picture: truth.picture(&words),
            text: format!(
                "silhouette {:.5}, interior holes {}, extra pixels {}, distance {:.2e} (99 of 100), other classes {:.3} %",
                accuracy.silhouette_iou,
                accuracy.interior_holes,
                accuracy.extra,
                accuracy.distance_p99,
                100.0 * accuracy.class_errors
            ),
        })
    }
}
