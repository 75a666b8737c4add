//! Errors of a picture against the oracle.

use glam::DVec3;
use relievo::oracle::{MeshOracle, Truth};
use relievo::picture::Picture;
use relievo::prepare::PreparedScene;
use relievo::render::{CpuRenderer, RenderError, Renderer};
use relievo::scene::Camera;
use relievo_shared::layout::Frame;

/// Longer side of a compared picture, pixels: tracing a ray by the oracle takes
/// a hundred times longer.
const LONGER_SIDE: u32 = 320;

/// Returns the size of the compared picture for the size of a scene.
pub fn size(scene: [u32; 2]) -> [u32; 2] {
    let longer = scene[0].max(scene[1]).max(1);
    scene.map(|side| (side * LONGER_SIDE.min(longer) / longer).max(1))
}

/// Errors of a picture.
pub struct ErrorPicture {
    /// Picture of the errors, as `relievo accuracy` draws it.
    pub picture: Picture,
    /// Summary in one line.
    pub text: String,
}

impl ErrorPicture {
    /// Compares the picture of `scene` in `frame` with its mesh as curved prisms.
    ///
    /// # Errors
    /// [`RenderError::Memory`] if memory runs out.
    pub fn of(
        scene: &PreparedScene,
        camera: &Camera,
        frame: &Frame,
    ) -> Result<ErrorPicture, RenderError> {
        let words = CpuRenderer::new(scene).geometry(frame)?;
        let oracle = MeshOracle::new(scene);
        let truth = Truth::of(&oracle, DVec3::from(camera.eye), frame);
        let accuracy = truth.compare(&words);
        Ok(ErrorPicture {
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
}
