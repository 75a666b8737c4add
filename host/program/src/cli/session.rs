//! Loading scenes and choosing renderers, for all commands.

use super::progress::Bar;
use super::{Backend, say};
use relievo::budget::{Plan, PlannedScene, Promise, plan, plan_view};
use relievo::prepare::{PreparedScene, Step};
use relievo::render::gpu::{Choice, adapters, choose};
use relievo::render::{CpuRenderer, FallbackRenderer, GpuRenderer, RenderError, Renderer};
use relievo::scene::Scene;
use relievo::{Error, Limits};
use std::path::{Path, PathBuf};

/// A scene before and after preparation.
pub struct Loaded {
    /// Scene as read, with the requested size.
    pub scene: Scene,
    /// Scene to render.
    pub prepared: PreparedScene,
    /// The plans of its objects.
    pub plans: Vec<Option<Plan>>,
}

/// Loads the scene at `path` and its files.
pub fn load(path: &Path, size: Option<[u32; 2]>, limits: &Limits) -> Result<Loaded, Error> {
    load_with(path, size, limits, |_| ())
}

/// Like [`load`], after applying `change` to the scene.
pub fn load_with(
    path: &Path,
    size: Option<[u32; 2]>,
    limits: &Limits,
    change: impl FnOnce(&mut Scene),
) -> Result<Loaded, Error> {
    load_by(path, size, limits, change, plan)
}

/// Like [`load_with`], without the objects outside the picture.
pub fn load_view(
    path: &Path,
    size: Option<[u32; 2]>,
    limits: &Limits,
    change: impl FnOnce(&mut Scene),
) -> Result<Loaded, Error> {
    load_by(path, size, limits, change, plan_view)
}

fn load_by(
    path: &Path,
    size: Option<[u32; 2]>,
    limits: &Limits,
    change: impl FnOnce(&mut Scene),
    plan: impl FnOnce(&Scene, &(dyn Fn(Step) + Sync)) -> Result<PlannedScene, Error>,
) -> Result<Loaded, Error> {
    let mut scene = Scene::load_within(path, limits)?;
    change(&mut scene);
    if let Some(size) = size {
        scene.size = size;
    }
    let bar = Bar::new();
    let PlannedScene {
        scene: prepared,
        plans,
    } = plan(&scene, &|step| bar.step(&step))?;
    log::info!(
        "{}: {} triangles in {} objects, prepared in {:.3} s",
        path.display(),
        prepared.triangle_count(),
        prepared.objects.len(),
        prepared.preparation.as_secs_f64()
    );
    Ok(Loaded {
        scene,
        prepared,
        plans,
    })
}

/// Returns the existing input files of `scene`, including itself.
pub fn inputs(scene: &Scene) -> Vec<PathBuf> {
    let all = std::iter::once(scene.path.clone()).chain(scene.named_files());
    all.filter_map(|path| path.canonicalize().ok()).collect()
}

/// Refuses the output at `path` if it is an input of `scene`.
pub fn refuse_input(scene: &Scene, path: &Path) -> anyhow::Result<()> {
    let is_input = |path| inputs(scene).contains(&path);
    if path.canonicalize().is_ok_and(is_input) {
        anyhow::bail!(
            "{} is a file that the scene reads; choose another name for the output",
            path.display()
        );
    }
    Ok(())
}

/// Prints how objects with a budget are drawn, and warns if a budget may not be
/// kept.
pub fn say_plans(loaded: &Loaded) -> anyhow::Result<()> {
    for (object, plan) in loaded.prepared.objects.iter().zip(&loaded.plans) {
        if let Some(plan) = plan {
            say(format_args!("object {:?}, {plan}", object.name))?;
            if let Promise::Doubtful(reason) = &plan.promise {
                log::warn!(
                    "object {:?}: an error within {} px cannot be promised: {reason}",
                    object.name,
                    plan.budget
                );
            }
        }
    }
    Ok(())
}

/// Returns the requested renderer, and one line that names it and the reason.
pub fn choose_renderer<'a>(
    backend: Backend,
    adapter: Option<&str>,
    scene: &'a PreparedScene,
    plans: &[Option<Plan>],
) -> Result<(Box<dyn Renderer + 'a>, String), RenderError> {
    let cpu = |why: &str| -> (Box<dyn Renderer + 'a>, String) {
        let renderer = CpuRenderer::new(scene);
        let line = format!("{}: {why}", renderer.name());
        (Box::new(renderer), line)
    };
    // An error budget does not require the CPU's exact words.
    let shaders = if !plans.is_empty() && plans.iter().all(Option::is_some) {
        Choice::Fastest
    } else {
        Choice::Trusted
    };
    // A named adapter selects the GPU.
    if backend == Backend::Gpu || (backend == Backend::Auto && adapter.is_some()) {
        let found = choose(adapter)?;
        let renderer = GpuRenderer::new(scene, &found, shaders)?;
        let line = format!("{}: as requested", renderer.name());
        return Ok((Box::new(renderer), line));
    }
    if backend == Backend::Cpu {
        return Ok(cpu("as requested"));
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
                log::warn!("the GPU cannot render this; the CPU does instead: {error}");
                Ok(cpu("the GPU cannot render this"))
            }
        },
    }
}
