//! Scenes: read from TOML files or made in code, and checked.
//!
//! A scene file has one key for each field ([`keys`] is the table of them, and
//! docs/scene.md the reference); all but an object's `mesh` and `shape` have
//! defaults. Paths are relative to the scene file. Scene files name files to
//! read, never files to write.
//!
//! ```
//! use relievo::mesh::MeshData;
//! use relievo::scene::{Scene, SceneObject, Shape, Technique};
//! use std::path::Path;
//!
//! // From the text of a file.
//! let text = "[[object]]\nmesh = 'torus.obj'\nshape = 'discs.png'\nrepeat = [12, 6]\ndepth = 0.08\n";
//! let scene = Scene::parse(text, Path::new("scene.toml"))?;
//! assert_eq!(scene.objects[0].repeat, [12.0, 6.0]);
//!
//! // In code, with a mesh and a pattern in memory.
//! let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
//! let square = MeshData::new("square", corners.map(|[x, y]| [x, y, 0.0]), [[0, 1, 2], [0, 2, 3]])
//!     .with_uvs(corners);
//! let object = SceneObject::new(square, Shape::text("ABC"))
//!     .with_technique(Technique::Chamfered)
//!     .depth(0.08)
//!     .repeat(3, 1);
//! Scene::default().size(320, 240).object(object).check()?;
//! # Ok::<(), relievo::scene::SceneError>(())
//! ```

mod animation;
mod builder;
mod carving;
mod check;
mod color;
mod development;
mod error;
mod instances;
mod key;
pub mod keys;
mod layer;
mod lighting;
mod model;
mod object;
mod object_keys;
mod physical;
mod read;
pub mod reference;
mod shape;
mod technique;
mod tidy;
mod tier;
mod track;
mod value;
mod write;

pub use crate::mesh::MeshSource;
pub use crate::shape_map::Lettering;
pub use carving::{Extrusion, Material};
pub use color::Color;
pub use development::{Development, Tone};
pub use error::SceneError;
pub(crate) use instances::rotation;
pub use instances::{Grid, Instance, Instances};
pub use keys::{BUDGETS, FRAME_RATES, LARGEST_PICTURE_SIDE};
pub use layer::{Layer, MOST_LAYERS};
pub use lighting::{Environment, LightKind, LightSource};
pub use model::{Camera, Light, Scene};
pub use object::{MapOptions, SceneObject};
pub use physical::{Coordinates, Finish, PhysicalMaterial};
pub use shape::Shape;
pub use technique::Technique;
pub use tier::{Search, Tier};
pub use track::{Interpolation, Track};
