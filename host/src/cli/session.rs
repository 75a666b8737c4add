//! What the commands have in common: loading a scene, choosing a renderer.

use super::progress::Bar;
use super::{Backend, Measured, say};
use relievo::budget::Promise;
use relievo::prepare::{PreparedScene, Step, prepare, prepare_view};
use relievo::render::gpu::{Adapter, Choice, adapters, choose};
use relievo::render::{CpuRenderer, FallbackRenderer, GpuRenderer, RenderError, Renderer};
use relievo::scene::{Scene, SceneObject};
use relievo::{Error, Limits};
use std::path::{Path, PathBuf};

/// A scene and what it loaded.
pub struct Loaded {
    /// The scene as written, with the size asked for.
    pub scene: Scene,
    /// The scene as rendered.
    pub prepared: PreparedScene,
}

/// Loads the scene at `path` and everything that it names.
pub fn load(path: &Path, size: Option<[u32; 2]>, limits: &Limits) -> Result<Loaded, Error> {
    load_with(path, size, limits, |_| ())
}

/// As [`load`], with the scene changed first.
pub fn load_with(
    path: &Path,
    size: Option<[u32; 2]>,
    limits: &Limits,
    change: impl FnOnce(&mut Scene),
) -> Result<Loaded, Error> {
    load_by(path, size, limits, change, prepare)
}

/// As [`load_with`], without the objects that are not in the picture.
pub fn load_view(
    path: &Path,
    size: Option<[u32; 2]>,
    limits: &Limits,
    change: impl FnOnce(&mut Scene),
) -> Result<Loaded, Error> {
    load_by(path, size, limits, change, prepare_view)
}

fn load_by(
    path: &Path,
    size: Option<[u32; 2]>,
    limits: &Limits,
    change: impl FnOnce(&mut Scene),
    prepare: impl FnOnce(&Scene, &(dyn Fn(Step) + Sync)) -> Result<PreparedScene, Error>,
) -> Result<Loaded, Error> {
    let mut scene = Scene::load_within(path, limits)?;
    change(&mut scene);
    if let Some(size) = size {
        scene.size = size;
    }
    let bar = Bar::new();
    let prepared = prepare(&scene, &|step| bar.step(&step))?;
    tracing::info!(
        "{}: {} triangles in {} objects, prepared in {:.3} s",
        path.display(),
        prepared.triangle_count(),
        prepared.objects.len(),
        prepared.preparation.as_secs_f64()
    );
    Ok(Loaded { scene, prepared })
}

/// The files that `scene` reads, itself among them, as far as they are there.
pub fn inputs(scene: &Scene) -> Vec<PathBuf> {
    let named = scene.objects.iter().flat_map(SceneObject::files);
    let all = std::iter::once(scene.path.as_path()).chain(named);
    all.filter_map(|path| path.canonicalize().ok()).collect()
}

/// The adapter that is measured with: the one with `wanted` in its name, or any.
/// There must be one if it is named, or nothing else is measured.
pub fn measured_adapter(
    measured: Measured,
    wanted: Option<&str>,
) -> Result<Option<Adapter>, Error> {
    if measured == Measured::Cpu {
        return Ok(None);
    }
    match choose(wanted) {
        Ok(found) => Ok(Some(found)),
        Err(error) if measured == Measured::Gpu || wanted.is_some() => Err(error.into()),
        Err(_) => Ok(None),
    }
}

/// Says how the objects with a budget are drawn; what is not promised, as a
/// warning.
pub fn say_plans(scene: &PreparedScene) -> anyhow::Result<()> {
    for object in &scene.objects {
        if let Some(plan) = &object.plan {
            say(format_args!("object {:?}, {plan}", object.name))?;
            if let Promise::Doubtful(reason) = &plan.promise {
                tracing::warn!(
                    "object {:?}: an error within {} px cannot be promised: {reason}",
                    object.name,
                    plan.budget
                );
            }
        }
    }
    Ok(())
}

/// The renderer asked for, and one line on which and why.
pub fn choose_renderer<'a>(
    backend: Backend,
    adapter: Option<&str>,
    scene: &'a PreparedScene,
) -> Result<(Box<dyn Renderer + 'a>, String), RenderError> {
    let cpu = |why: &str| -> (Box<dyn Renderer + 'a>, String) {
        let renderer = CpuRenderer::new(scene);
        let line = format!("{}: {why}", renderer.name());
        (Box::new(renderer), line)
    };
    // Who says how wrong a picture may be does not ask for the CPU's words.
    let is_planned = scene.objects.iter().all(|object| object.plan.is_some());
    let shaders = if is_planned && !scene.objects.is_empty() {
        Choice::Fastest
    } else {
        Choice::Trusted
    };
    // A named adapter is wanted, whatever the backend says.
    if backend == Backend::Gpu || (backend == Backend::Auto && adapter.is_some()) {
        let found = choose(adapter)?;
        let renderer = GpuRenderer::new(scene, &found, shaders)?;
        let line = format!("{}: as asked", renderer.name());
        return Ok((Box::new(renderer), line));
    }
    if backend == Backend::Cpu {
        return Ok(cpu("as asked"));
    }
    let all = adapters();
    match all.first() {
        None => Ok(cpu("this machine has no GPU adapter")),
        Some(found) if found.is_software() => Ok(cpu(&format!(
            "the only adapter, {}, is a software driver",
            found.name()
        ))),
        Some(found) => match GpuRenderer::new(scene, found, shaders) {
            Ok(renderer) => {
                let line = format!("{}: this machine's GPU", renderer.name());
                Ok((Box::new(FallbackRenderer::new(scene, renderer)), line))
            }
            Err(error @ RenderError::TimeLimit { .. }) => Err(error),
            Err(error) => {
                tracing::warn!("the GPU cannot render this, and the CPU does instead: {error}");
                Ok(cpu("the GPU cannot render this"))
            }
        },
    }
}
