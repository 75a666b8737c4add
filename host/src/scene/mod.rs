//! The scene: what is to be drawn, as the user wrote it, checked.
//!
//! A scene is a TOML file ([`Scene::load`]); every key but an object's `mesh`
//! and `shape` has a default. Paths are relative to the scene file. They name what
//! is read; no key names a file that is written.

mod color;
mod file;
mod shape;
mod write;

pub use crate::shape_map::Lettering;
pub use color::Color;
pub use shape::Shape;

use crate::mesh::Projection;
use crate::shape_map::Storage;
use crate::{Files, Limits};
use std::path::{Path, PathBuf};

/// Largest width or height of a picture, pixels: coordinates stay exact and
/// pictures stay in memory.
pub const LARGEST_PICTURE_SIDE: u32 = 16_384;
/// Largest number of steps of the linear search.
pub const LARGEST_STEPS: u32 = 65_536;

/// Least error that may be asked for, pixels.
pub const LEAST_BUDGET: f64 = 0.01;
/// Largest error that may be asked for, pixels.
pub const LARGEST_BUDGET: f64 = 100.0;

const DEFAULT_SIZE: [u32; 2] = [800, 600];
const DEFAULT_BACKGROUND: Color = Color::from_hex(0xe9edf2);
const DEFAULT_FIELD_OF_VIEW: f64 = 45.0;
const DEFAULT_UP: [f64; 3] = [0.0, 1.0, 0.0];
/// The accurate tier's tolerance, pixels.
pub const DEFAULT_TOLERANCE: f64 = 0.02;
const DEFAULT_THRESHOLD: u8 = 128;

/// What is wrong with a scene file.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// The file could not be read.
    #[error("cannot read the scene file {path}: {source}; check the path and its permissions")]
    Read {
        /// The scene file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The path names something else than a text file of a sensible size.
    #[error("{path} is not a scene file: {problem}")]
    NotAScene {
        /// What was to be the scene file.
        path: PathBuf,
        /// What is wrong, and what would be right.
        problem: String,
    },
    /// The file is not TOML, or has unknown keys or values of a wrong type.
    #[error("{path}: {message}")]
    Syntax {
        /// The scene file.
        path: PathBuf,
        /// Line, column, the text there and what is wrong.
        message: String,
    },
    /// A value is out of its range.
    #[error("{path}, line {line}, column {column}: {key} {problem}")]
    Value {
        /// The scene file.
        path: PathBuf,
        /// Line of the value, from 1.
        line: usize,
        /// Column of the value, from 1.
        column: usize,
        /// The key, with the tables it lies in.
        key: String,
        /// What is wrong, and what would be right.
        problem: String,
    },
}

/// A scene, checked: every number is finite and in its range.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The file it came from.
    pub path: PathBuf,
    /// The file's text, kept for the pictures' metadata.
    pub text: String,
    /// Width and height of the picture, pixels.
    pub size: [u32; 2],
    /// Samples per pixel side: 1, or 2 for 4× supersampling.
    pub supersampling: u32,
    /// What is seen where nothing is.
    pub background: Color,
    /// The camera; `None` looks at the whole scene from its front, right and above.
    pub camera: Option<Camera>,
    /// Vertical field of view, degrees.
    pub field_of_view: f64,
    /// The light.
    pub light: Light,
    /// What is drawn, in the order of the file.
    pub objects: Vec<SceneObject>,
    /// What may be loaded for it.
    pub limits: Limits,
    /// Where that is read from.
    pub files: Files,
}

/// Where the eye is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// The eye, world units.
    pub eye: [f64; 3],
    /// The point in the picture's centre.
    pub target: [f64; 3],
    /// Roughly up.
    pub up: [f64; 3],
}

/// One directional light and an ambient one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Towards the light; of any length.
    pub direction: [f64; 3],
    /// Colour of the directional light.
    pub color: Color,
    /// Its factor.
    pub intensity: f64,
    /// Colour of the ambient light.
    pub ambient: Color,
}

impl Default for Light {
    /// From the upper right.
    fn default() -> Light {
        Light {
            direction: [0.5, 0.8, 0.6],
            color: Color::from_hex(0xfff6e8),
            intensity: 1.0,
            ambient: Color::from_hex(0x5a6470),
        }
    }
}

/// The four extrusions, with their parameters (section 2 of the algorithm).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extrusion {
    /// e, width units.
    pub extension: f64,
    /// b, width units per unit of δ.
    pub bevel: f64,
    /// c, 0…1.
    pub chamfer: f64,
}

/// How the surface is modelled along a ray: what accuracy is bought.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Tier {
    /// Flat: extrusion mapping without silhouettes.
    Planar,
    /// Along the local quadric, with facet depth.
    Fast,
    /// The paper's algorithms as printed, mistakes included.
    Paper,
    /// From prism to prism through the shell: no holes.
    Accurate,
}

impl Tier {
    /// Every tier.
    pub const ALL: [Tier; 4] = [Tier::Planar, Tier::Fast, Tier::Paper, Tier::Accurate];

    /// What scenes call it.
    pub fn name(self) -> &'static str {
        match self {
            Tier::Planar => "planar",
            Tier::Fast => "fast",
            Tier::Paper => "paper",
            Tier::Accurate => "accurate",
        }
    }

    /// Steps of the linear search and bisections after it where a scene says
    /// nothing.
    pub fn default_effort(self) -> (u32, u32) {
        match self {
            Tier::Planar | Tier::Fast => (96, 8),
            // The paper's own numbers.
            Tier::Paper => (25, 5),
            // Each piece of a ray takes a step of its own, and steps that run
            // out would be seen.
            Tier::Accurate => (256, 10),
        }
    }

    /// The number of the tier in the shared layouts.
    pub fn code(self) -> u32 {
        match self {
            Tier::Planar => relievo_shared::layout::TIER_PLANAR,
            Tier::Fast => relievo_shared::layout::TIER_FAST,
            Tier::Paper => relievo_shared::layout::TIER_PAPER,
            Tier::Accurate => relievo_shared::layout::TIER_ACCURATE,
        }
    }
}

/// How the first hit on a ray is searched for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Search {
    /// By steps through the distance map that cannot skip the pattern.
    Extrusion,
    /// Relief mapping: by equal steps through a depth map of the same pattern.
    Relief,
}

/// How a plain pattern becomes a shape map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct MapOptions {
    /// The form of its texels.
    pub storage: Storage,
    /// So many texels along each side become one; a power of two.
    pub reduction: u32,
}

impl MapOptions {
    /// Without steps or bounds, as many texels as the pattern has pixels.
    pub const FINEST: MapOptions = MapOptions {
        storage: Storage::R32F,
        reduction: 1,
    };
}

impl Default for MapOptions {
    /// 16 bits a texel, as many texels as the pattern has pixels.
    fn default() -> MapOptions {
        MapOptions {
            storage: Storage::R16,
            reduction: 1,
        }
    }
}

/// Colours and gloss of an object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// The mesh surface on the pattern.
    pub cap: Color,
    /// The upright sides.
    pub wall: Color,
    /// Bevels and chamfers.
    pub bevel: Color,
    /// The ground between the columns.
    pub floor: Color,
    /// Strength of the highlight, 0…1.
    pub specular: f64,
    /// Exponent of the highlight, 1…127.
    pub shininess: u32,
}

impl Default for Material {
    fn default() -> Material {
        Material {
            cap: Color::from_hex(0xd8b45c),
            wall: Color::from_hex(0xb0502e),
            bevel: Color::from_hex(0xe8cf94),
            floor: Color::from_hex(0x3d5a73),
            specular: 0.25,
            shininess: 40,
        }
    }
}

/// One object: a mesh, and a pattern wrapped around it.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneObject {
    /// The object's name: as given, or the mesh file's.
    pub name: String,
    /// The mesh, an OBJ or glTF file.
    pub mesh: PathBuf,
    /// The pattern.
    pub shape: Shape,
    /// Pixels of the pattern's longer side, for a drawing or text; `None` is
    /// [`DEFAULT_RASTER`](crate::shape_map::DEFAULT_RASTER).
    pub raster: Option<u32>,
    /// How the pattern is stored; the default for a baked shape map, which is
    /// taken as it is.
    pub map: MapOptions,
    /// Repeats of the pattern along u and v.
    pub repeat: [f64; 2],
    /// S_z, world units; `None` is 4 % of the mesh's diagonal.
    pub depth: Option<f64>,
    /// In the accurate tier, less depth where the surface bends too much for
    /// that one, in place of an error.
    pub clamp_depth: bool,
    /// The technique's parameters.
    pub extrusion: Extrusion,
    /// How hits are searched for.
    pub search: Search,
    /// How wrong the picture may be, pixels: the planner chooses tier,
    /// tolerance, steps and map. `None` takes them as they stand here.
    pub budget: Option<f64>,
    /// The model of the surface.
    pub tier: Tier,
    /// How far beside its place a ray may be searched in the accurate tier, pixels.
    pub tolerance: f64,
    /// How far before its place a search may end, pixels.
    pub slack: f64,
    /// Largest number of steps of the linear search.
    pub steps: u32,
    /// Bisections after it.
    pub bisections: u32,
    /// No floor.
    pub cut_out: bool,
    /// Columns throw shadows on the object they stand on.
    pub self_shadow: bool,
    /// Texture coordinates for a mesh that has none.
    pub projection: Option<Projection>,
    /// A pixel is pattern where its luma is below this.
    pub threshold: u8,
    /// The light pixels are the pattern.
    pub invert: bool,
    /// Colours.
    pub material: Material,
    /// Uniform scale, before rotation.
    pub scale: f64,
    /// Rotation about x, then y, then z, degrees.
    pub rotate: [f64; 3],
    /// Translation, last.
    pub translate: [f64; 3],
}

impl SceneObject {
    /// Every file that it names.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        std::iter::once(self.mesh.as_path()).chain(self.shape.file())
    }

    /// Gives parameters that its tier or search has no meaning for, and its
    /// effort, the values that a scene file without them has: after another tier
    /// or search was chosen.
    pub fn tidy(&mut self) {
        let is_relief = self.search == Search::Relief;
        if is_relief {
            self.tier = Tier::Fast;
            self.budget = None;
        }
        if self.tier != Tier::Accurate {
            self.clamp_depth = false;
            self.tolerance = DEFAULT_TOLERANCE;
        }
        if self.tier == Tier::Paper || is_relief {
            self.slack = 0.0;
        }
        if self.tier == Tier::Paper {
            self.extrusion.extension = self.extrusion.extension.max(0.0);
        }
        let effort = if is_relief { Tier::Paper } else { self.tier };
        (self.steps, self.bisections) = effort.default_effort();
    }

    /// The number of the search in the shared layouts.
    pub fn search_code(&self) -> u32 {
        use relievo_shared::layout::{
            SEARCH_EXTRUSION, SEARCH_PAPER, SEARCH_PRISMS, SEARCH_RELIEF,
        };
        match (self.search, self.tier) {
            (Search::Relief, _) => SEARCH_RELIEF,
            (Search::Extrusion, Tier::Paper) => SEARCH_PAPER,
            (Search::Extrusion, Tier::Accurate) => SEARCH_PRISMS,
            (Search::Extrusion, Tier::Planar | Tier::Fast) => SEARCH_EXTRUSION,
        }
    }
}

impl Scene {
    /// Reads and checks a scene file that may read any other file. One that
    /// is not trusted is given [`Limits::default`] by [`Scene::load_within`].
    ///
    /// # Errors
    /// [`SceneError`] with the file, the line and what to do.
    pub fn load(path: &Path) -> Result<Scene, SceneError> {
        file::load(path, &Limits::trusting())
    }

    /// Reads and checks a scene file within `limits`, which are kept when the
    /// scene is prepared as well.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn load_within(path: &Path, limits: &Limits) -> Result<Scene, SceneError> {
        file::load(path, limits)
    }

    /// Gives every object that a search of ours is run on this budget, pixels,
    /// in place of its tier, steps and map.
    pub fn set_budget(&mut self, budget: Option<f64>) {
        if budget.is_some() {
            for object in &mut self.objects {
                if object.search == Search::Extrusion {
                    object.budget = budget;
                    object.tier = Tier::Fast;
                    object.map = MapOptions::default();
                    object.tolerance = DEFAULT_TOLERANCE;
                    object.clamp_depth = false;
                    object.slack = 0.0;
                    (object.steps, object.bisections) = Tier::Fast.default_effort();
                }
            }
        }
    }

    /// The text of a scene file that, read in `folder`, is this scene, but for
    /// its path, its text and its limits. Files are named as seen from `folder`
    /// where there is a way, as the text of their paths has it. Keys of which
    /// the default is meant are left out.
    ///
    /// What no scene file says is lost: names that are not Unicode, and what a
    /// budget decides where an object has one.
    pub fn to_toml(&self, folder: &Path) -> String {
        write::to_toml(self, folder)
    }

    /// Reads a scene from `text`; `path` is for messages and relative paths.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn parse(text: &str, path: &Path) -> Result<Scene, SceneError> {
        file::parse(text, path, &Limits::trusting(), Files::Disk)
    }

    /// As [`Scene::parse`], within `limits`, of `files`: those of
    /// [`Files::Memory`] are named as if its root were that of `path`, and the
    /// disk is not read, now or when the scene is prepared. [`Files::Disk`] is
    /// narrowed to the scene's folder unless the limits allow more.
    ///
    /// # Errors
    /// As [`Scene::load`]; for files in memory, also where one is missing.
    pub fn parse_with(
        text: &str,
        path: &Path,
        limits: &Limits,
        files: Files,
    ) -> Result<Scene, SceneError> {
        file::parse(text, path, limits, files)
    }
}
