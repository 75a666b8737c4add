//! What objects and their layers have in common.

use super::keys::{Key, LAYER, LAYER_MATERIAL, MATERIAL, OBJECT};
use super::{Layer, SceneObject, Search, Shape, Technique};

/// An object or a layer: a pattern, a technique and materials, under the same keys.
pub(super) trait Carving: Sized + 'static {
    /// Returns its keys.
    fn keys() -> &'static [Key<Self>];

    /// Returns the keys of its table `material`.
    fn material_keys() -> &'static [Key<Self>];

    /// Returns whether it may have this technique.
    fn allows(technique: Technique) -> bool;

    /// Returns its technique.
    fn carved_by(&self) -> Technique;

    /// Sets its technique, and what depends on it to its defaults.
    fn carve_by(&mut self, technique: Technique);

    /// Returns its pattern.
    fn shape(&self) -> &Shape;

    /// Sets its pattern.
    fn set_shape(&mut self, shape: Shape);
}

macro_rules! carving {
    ($owner:ty, $keys:ident, $material_keys:ident, $allows:expr) => {
        impl Carving for $owner {
            fn keys() -> &'static [Key<Self>] {
                $keys
            }
            fn material_keys() -> &'static [Key<Self>] {
                $material_keys
            }
            fn allows(technique: Technique) -> bool {
                $allows(technique)
            }
            fn carved_by(&self) -> Technique {
                self.technique()
            }
            fn carve_by(&mut self, technique: Technique) {
                self.set_technique(technique);
            }
            fn shape(&self) -> &Shape {
                &self.shape
            }
            fn set_shape(&mut self, shape: Shape) {
                self.shape = shape;
            }
        }
    };
}

carving!(SceneObject, OBJECT, MATERIAL, |_| true);
carving!(Layer, LAYER, LAYER_MATERIAL, |technique: Technique| {
    technique.search() == Search::Extrusion
});
