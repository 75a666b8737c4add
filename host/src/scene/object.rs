//! Objects of a scene: a mesh, a pattern, and how one is wrapped around the other.

use super::carving::{DEFAULT_THRESHOLD, Extrusion, Material};
use super::{Finish, Instances, Layer, Search, Shape, Tier};
use crate::mesh::{DEFAULT_CREASE_ANGLE, MeshSource, Projection};
use crate::shape_map::Storage;
use std::path::{Path, PathBuf};

/// Default tolerance of the accurate tier, pixels.
const DEFAULT_TOLERANCE: f64 = 0.02;

/// How the shape map of a plain pattern is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "transfer", derive(serde::Deserialize, serde::Serialize))]
pub struct MapOptions {
    /// Form of a texel.
    pub storage: Storage,
    /// Pixels of the pattern along each side of a texel; a power of two.
    pub reduction: u32,
}

impl MapOptions {
    /// Floats, one texel a pixel.
    pub const FINEST: MapOptions = MapOptions {
        storage: Storage::R32F,
        reduction: 1,
    };
}

impl Default for MapOptions {
    /// 16 bits, one texel a pixel.
    fn default() -> MapOptions {
        MapOptions {
            storage: Storage::R16,
            reduction: 1,
        }
    }
}

/// An object: a mesh with a pattern wrapped around it. The ranges of the fields
/// are those of the keys in [`super::keys`].
#[derive(Clone, Debug, PartialEq)]
pub struct SceneObject {
    /// Name in messages; by default the name of the mesh file.
    pub name: String,
    /// The mesh.
    pub mesh: MeshSource,
    /// Names of the materials of the mesh file whose triangles are drawn; all if there are none.
    pub parts: Vec<String>,
    /// The pattern.
    pub shape: Shape,
    /// Pixels of the longer side of a pattern that is a drawing or text; `None`
    /// is [`DEFAULT_RASTER`](crate::shape_map::DEFAULT_RASTER).
    pub raster: Option<u32>,
    /// How the pattern is stored; must be the default for a baked shape map.
    pub map: MapOptions,
    /// Repeats of the pattern along u and v.
    pub repeat: [f64; 2],
    /// Depth S_z of the floor, world units; `None` is 4 % of the mesh's diagonal.
    pub depth: Option<f64>,
    /// Parameters of the extrusion.
    pub extrusion: Extrusion,
    /// How hits are searched for.
    pub search: Search,
    /// Largest error, pixels: the planner chooses tier, tolerance, slack, steps
    /// and map. `None` keeps the values given here.
    pub budget: Option<f64>,
    /// Model of the surface.
    pub tier: Tier,
    /// Largest distance between a ray and its approximation in the accurate
    /// tier, pixels.
    pub tolerance: f64,
    /// Distance before the hit at which a search may end, pixels.
    pub slack: f64,
    /// Largest number of steps of the linear search.
    pub steps: u32,
    /// Largest number of bisections after it.
    pub bisections: u32,
    /// Whether columns rise from the mesh in place of being cut into it; needs a `depth`.
    pub raised: bool,
    /// Whether there is no floor.
    pub cut_out: bool,
    /// Whether columns cast shadows on the object they stand on.
    pub self_shadow: bool,
    /// Texture coordinates in place of the mesh's own.
    pub projection: Option<Projection>,
    /// Largest angle between two triangles whose edge is smooth where the mesh has
    /// no normals, degrees.
    pub crease_angle: f64,
    /// Luma below which a pixel is pattern.
    pub threshold: u8,
    /// Whether the light pixels are the pattern.
    pub invert: bool,
    /// Which part of the pattern's pieces is kept, of how many ([`Pattern::pieces`](crate::shape_map::Pattern::pieces)).
    pub pieces: Option<[u32; 2]>,
    /// Colours and gloss.
    pub material: Material,
    /// Materials of the scene in place of the colours.
    pub finish: Finish,
    /// Further patterns, at most [`MOST_LAYERS`](super::MOST_LAYERS).
    pub layers: Vec<Layer>,
    /// Uniform scale, before rotation.
    pub scale: f64,
    /// Rotation about x, then y, then z, degrees.
    pub rotate: [f64; 3],
    /// Translation, last, world units.
    pub translate: [f64; 3],
    /// Copies of the object, placed after its own transform; `None` draws it once.
    pub instances: Option<Instances>,
}

impl Default for SceneObject {
    /// An object without a mesh and a shape, which have to be set.
    fn default() -> SceneObject {
        let tier = Tier::default();
        let (steps, bisections) = tier.default_effort();
        SceneObject {
            name: "object".to_string(),
            mesh: MeshSource::File(PathBuf::new()),
            parts: Vec::new(),
            shape: Shape::File(PathBuf::new()),
            raster: None,
            map: MapOptions::default(),
            repeat: [1.0; 2],
            depth: None,
            extrusion: Extrusion::default(),
            search: Search::default(),
            budget: None,
            tier,
            tolerance: DEFAULT_TOLERANCE,
            slack: 0.0,
            steps,
            bisections,
            raised: false,
            cut_out: false,
            self_shadow: false,
            projection: None,
            crease_angle: DEFAULT_CREASE_ANGLE,
            threshold: DEFAULT_THRESHOLD,
            invert: false,
            pieces: None,
            material: Material::default(),
            finish: Finish::default(),
            layers: Vec::new(),
            scale: 1.0,
            rotate: [0.0; 3],
            translate: [0.0; 3],
            instances: None,
        }
    }
}

impl SceneObject {
    /// Returns the paths of all files that the object names.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        self.named_files().map(|(_, path)| path)
    }

    /// Returns the key and the path of all files that the object names.
    pub(super) fn named_files(&self) -> impl Iterator<Item = (String, &Path)> {
        let mesh = self.mesh.file().map(|path| ("mesh".to_string(), path));
        let instances = match &self.instances {
            Some(Instances::File(path)) => Some(("instances".to_string(), path.as_path())),
            _ => None,
        };
        let shape = |prefix: String, shape| {
            let (key, path) = Shape::named_file(shape)?;
            Some((format!("{prefix}{key}"), path))
        };
        let layers = (1..).zip(&self.layers);
        let layers =
            layers.filter_map(move |(number, layer)| shape(layer_prefix(number), &layer.shape));
        mesh.into_iter()
            .chain(shape(String::new(), &self.shape))
            .chain(layers)
            .chain(instances)
    }

    /// As [`SceneObject::named_files`], for other paths to be set.
    pub(super) fn files_mut(&mut self) -> Vec<(String, &mut PathBuf)> {
        let mut files = Vec::new();
        if let MeshSource::File(path) = &mut self.mesh {
            files.push(("mesh".to_string(), path));
        }
        let layers = (1..).zip(&mut self.layers);
        let layers = layers.map(|(number, layer)| (layer_prefix(number), &mut layer.shape));
        for (prefix, shape) in std::iter::once((String::new(), &mut self.shape)).chain(layers) {
            let file = shape.named_file_mut();
            files.extend(file.map(|(key, path)| (format!("{prefix}{key}"), path)));
        }
        if let Some(Instances::File(path)) = &mut self.instances {
            files.push(("instances".to_string(), path));
        }
        files
    }

    /// Returns the name of an object that is given none.
    pub(super) fn default_name(&self) -> String {
        match self.mesh.label() {
            name if name.is_empty() => "object".to_string(),
            name => name,
        }
    }

    /// Returns whether a surface of it or of its layers has the materials of the mesh file.
    pub(crate) fn is_of_mesh(&self) -> bool {
        let mut layers = self.layers.iter();
        self.finish.is_of_mesh() || layers.any(|layer| layer.finish.is_of_mesh())
    }

    /// Returns a layer of which a file says nothing: it has the object's materials.
    pub(super) fn default_layer(&self) -> Layer {
        Layer {
            material: self.material,
            finish: self.finish.clone(),
            ..Layer::default()
        }
    }

    /// Returns the default number of steps and bisections for tier and search.
    pub(super) fn default_effort(&self) -> (u32, u32) {
        match self.search {
            Search::Relief => Tier::Paper.default_effort(),
            Search::Extrusion => self.tier.default_effort(),
        }
    }

    /// Sets steps and bisections to their defaults.
    pub(super) fn set_default_effort(&mut self) {
        (self.steps, self.bisections) = self.default_effort();
    }

    /// Returns the `SEARCH_` constant of the shared layouts.
    pub fn search_code(&self) -> u32 {
        relievo_shared::shaders::search_of(self.tier.code(), self.search == Search::Relief)
    }
}

/// Returns what precedes the keys of the layer `number`, from 1, in messages.
pub(super) fn layer_prefix(number: usize) -> String {
    format!("layer {number}: ")
}
