//! Layers: further patterns of an object.

use super::carving::{DEFAULT_THRESHOLD, Extrusion, Material};
use super::{Finish, Shape};
use std::path::PathBuf;

/// Largest number of layers of an object.
pub const MOST_LAYERS: usize = 7;

/// A further pattern of an object: an extrusion within a part of the depth. Repeats, raster and
/// storage of the map are the object's.
///
/// ```
/// use relievo::scene::{Layer, Scene, SceneObject, Technique};
///
/// let frames = Layer::new("frames.svg").top(0.4).with_technique(Technique::Beveled);
/// let object = SceneObject::new("facade.obj", "wall.svg").with_layer(frames);
/// Scene::default().object(object).check()?;
/// # Ok::<(), relievo::scene::SceneError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// The pattern.
    pub shape: Shape,
    /// Luma below which a pixel is pattern.
    pub threshold: u8,
    /// Whether the light pixels are the pattern.
    pub invert: bool,
    /// Which part of the pattern's pieces is kept, of how many.
    pub pieces: Option<[u32; 2]>,
    /// δ of its caps, 0…1.
    pub top: f64,
    /// δ where it ends, above `top`, at most 1, where the floor is.
    pub bottom: f64,
    /// Growth; its δ runs from 0 at `top` to 1 at `bottom`.
    pub extrusion: Extrusion,
    /// Colours. Floor and gloss are the object's.
    pub material: Material,
    /// Materials of the scene in place of the colours.
    pub finish: Finish,
}

impl Default for Layer {
    /// A layer of the whole depth without a shape, which has to be set.
    fn default() -> Layer {
        Layer {
            shape: Shape::File(PathBuf::new()),
            threshold: DEFAULT_THRESHOLD,
            invert: false,
            pieces: None,
            top: 0.0,
            bottom: 1.0,
            extrusion: Extrusion::default(),
            material: Material::default(),
            finish: Finish::default(),
        }
    }
}
