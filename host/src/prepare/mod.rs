//! Prepares a scene: loads its files and computes the plain data that renderers
//! read.
//!
//! Positions are moved so that the centre of all objects is the origin, in f64,
//! before they are rounded to f32: a scene far from the origin keeps its digits.
//!
//! Objects with an error budget (`error_px`) are prepared by
//! [`crate::budget::plan`].
//!
//! ```
//! use relievo::prepare::prepare;
//! use relievo::scene::Scene;
//! use relievo::{Files, Limits};
//! use std::path::Path;
//!
//! let quad = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
//! let files = Files::memory([("quad.obj".into(), quad.as_bytes().into())]);
//! let text = r#"
//! [[object]]
//! mesh = "quad.obj"
//! shape = { text = "A" }
//! projection = "planar-z"
//! "#;
//! let scene = Scene::parse_with(text, Path::new(""), &Limits::default(), files)?;
//! let prepared = prepare(&scene, &|_| ())?;
//! assert_eq!(prepared.triangle_count(), 2);
//! # Ok::<(), relievo::Error>(())
//! ```

mod camera;
mod exits;
mod growth;
mod layers;
mod lighting;
mod lit;
mod load;
mod memo;
mod meshes;
mod object;
mod placement;
mod places;
mod prepared;
mod shapes;
mod shells;
mod sources;
mod step;
#[cfg(test)]
pub(crate) mod tests;
#[cfg(feature = "transfer")]
pub mod transfer;

pub use camera::{View, finer, unlit_frame};
pub use layers::PreparedLayer;
pub use lit::PreparedLighting;
pub use load::Assets;
pub(crate) use load::LoadedScene;
pub use placement::Placement;
pub use prepared::{PreparedObject, PreparedScene};
pub use step::Step;

use crate::Error;
use crate::scene::Scene;

/// Loads and prepares everything that `scene` names. `progress` may be called
/// from any thread.
///
/// # Errors
/// [`Error`] for the first object whose files or parameters cannot be used, and
/// for an object with an error budget, which [`crate::budget::plan`] prepares.
pub fn prepare(scene: &Scene, progress: &(dyn Fn(Step) + Sync)) -> Result<PreparedScene, Error> {
    prepare_with(scene, &mut Assets::default(), progress)
}

/// Like [`prepare`], reusing unchanged `assets`. Afterwards `assets` are those
/// of `scene`; after an error they may be empty.
///
/// Files are identified by path: a change of their content is not noticed.
///
/// # Errors
/// As [`prepare`].
pub fn prepare_with(
    scene: &Scene,
    assets: &mut Assets,
    progress: &(dyn Fn(Step) + Sync),
) -> Result<PreparedScene, Error> {
    refuse_budgets(scene)?;
    let mut loaded = LoadedScene::load(scene, assets, progress)?;
    let prepared = loaded.prepare()?;
    *assets = loaded.into_assets();
    Ok(prepared)
}

/// Like [`prepare`], for the picture of the scene's own camera only: meshes
/// outside the picture are read for their extent and not prepared. The picture
/// is the same.
///
/// # Errors
/// As [`prepare`], except for errors in preparing what is outside the picture.
pub fn prepare_view(
    scene: &Scene,
    progress: &(dyn Fn(Step) + Sync),
) -> Result<PreparedScene, Error> {
    refuse_budgets(scene)?;
    LoadedScene::load_view(scene, progress)?.prepare()
}

fn refuse_budgets(scene: &Scene) -> Result<(), Error> {
    match scene.objects.iter().find(|object| object.budget.is_some()) {
        None => Ok(()),
        Some(object) => Err(Error::Object {
            scene: scene.path.clone(),
            name: object.name.clone(),
            problem: "error_px needs a plan; call relievo::budget::plan in place of prepare"
                .to_string(),
        }),
    }
}
