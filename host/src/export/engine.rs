//! What an engine needs to find hits on an object, in memory.

use super::{ExportError, Interface, MapForm, map_bytes, write_function};
use crate::prepare::PreparedObject;
use crate::shaders::{EntryPoints, Extent, Facets, facet_bytes};
use relievo_shared::layout::Object;
use std::borrow::Cow;

/// The function that finds what a ray hits on an object, and the buffers that it reads:
/// [`Output::Hit`](super::Output::Hit) without files.
///
/// ```
/// use relievo::export::{EngineHit, Interface};
/// use relievo::prepare::prepare;
/// use relievo::scene::Scene;
/// use std::path::Path;
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let scene = Scene::load(Path::new("../assets/scenes/plane.toml"))?;
/// let prepared = prepare(&scene, &|_| ())?;
/// let hit = EngineHit::of(&prepared.objects[0]);
/// let interface = Interface { group: 3, first_binding: 100, ..Interface::default() };
/// assert!(hit.wgsl(&interface)?.contains("fn relievo_hit("));
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Copy)]
pub struct EngineHit<'a> {
    object: &'a PreparedObject,
    entry_points: EntryPoints,
}

impl<'a> EngineHit<'a> {
    /// Selects the shader that is specialised for `object`.
    pub fn of(object: &'a PreparedObject) -> EngineHit<'a> {
        EngineHit {
            object,
            entry_points: EntryPoints::of(&object.parameters, Extent::Needed),
        }
    }

    /// Returns the name of the compiled shader. Objects with the same one share the function.
    pub fn shader(&self) -> &'static str {
        self.entry_points.hit
    }

    /// Returns the type of the facets that the function reads.
    pub fn facets(&self) -> Facets {
        self.entry_points.facets
    }

    /// Returns the function in WGSL, which takes any group and binding. It reads the buffers of
    /// the object, the facets and the map, at the three bindings after
    /// [`Interface::first_binding`].
    ///
    /// # Errors
    /// [`ExportError`] if the prefix is no name, or the shader cannot be translated.
    pub fn wgsl(&self, interface: &Interface) -> Result<String, ExportError> {
        interface.check_prefix()?;
        write_function(self.object, self.entry_points, interface)
    }

    /// Returns the contents of the buffers: the object, the facets and the map, as
    /// [`MapForm::Buffer`].
    pub fn buffers(&self) -> [Cow<'a, [u8]>; 3] {
        let parameters = parameters(self.object);
        [
            bytemuck::bytes_of(&parameters).to_vec().into(),
            facet_bytes(self.object, self.entry_points.facets),
            bytemuck::cast_slice(self.object.map.words()).into(),
        ]
    }

    /// Returns the contents of the texture with the map, as [`MapForm::Texture`].
    ///
    /// # Errors
    /// [`ExportError::Map`] if a texture does not hold it.
    pub fn map_texture(&self) -> Result<Vec<u8>, ExportError> {
        map_bytes(self.object, MapForm::Texture)
    }
}

/// Returns the parameters of `object` with its number in the scene, which its hits tell.
pub(super) fn parameters(object: &PreparedObject) -> Object {
    Object {
        finish: object.number as u32,
        ..object.parameters
    }
}
