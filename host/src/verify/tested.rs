//! Compares words on one adapter.
//!
//! ```no_run
//! use relievo::prepare::prepare;
//! use relievo::render::gpu::{Shaders, choose};
//! use relievo::scene::Scene;
//! use relievo::verify::Tested;
//!
//! let scene = Scene::load("assets/scenes/torus.toml".as_ref())?;
//! let prepared = prepare(&scene, &|_| ())?;
//! let mut tested = Tested::new(choose(None)?, &[Shaders::Exact])?;
//! Tested::pictures(std::slice::from_mut(&mut tested), &prepared, "torus", &|_| ())?;
//! assert_eq!(tested.report.modules[0].different, 0);
//! # Ok::<(), relievo::Error>(())
//! ```

use super::kernels::KERNELS;
use super::{AdapterReport, ModuleReport, compare};
use crate::prepare::PreparedScene;
use crate::render::gpu::{Adapter, Choice, Shaders, signature};
use crate::render::{CpuRenderer, GpuRenderer, RenderError, Renderer};
use relievo_bitwise::{Plan, Runner, compare_kernel};

/// An adapter, the shaders to compare on it, and the results.
pub struct Tested {
    /// The adapter.
    pub adapter: Adapter,
    /// The shaders: those that the adapter takes.
    pub shaders: Vec<Shaders>,
    /// The results; a module for each of `shaders`.
    pub report: AdapterReport,
}

impl Tested {
    /// Tries the canaries of `adapter`, and keeps those of the `wanted` shaders that it takes.
    ///
    /// # Errors
    /// [`RenderError::Device`] if the device fails.
    pub fn new(adapter: Adapter, wanted: &[Shaders]) -> Result<Tested, RenderError> {
        let signature = if adapter.takes_spirv() {
            Some(signature(&adapter.open()?)?)
        } else {
            None
        };
        let fuses = signature
            .as_ref()
            .is_some_and(|signature| Shaders::Fused.suit(signature));
        let possible = wanted.iter().copied();
        let shaders: Vec<Shaders> = possible
            .filter(|shaders| adapter.takes_spirv() || !shaders.is_untouched())
            .filter(|&shaders| shaders != Shaders::Fused || fuses)
            .collect();
        let mut report = AdapterReport::new(&adapter, signature.as_ref());
        report.modules = shaders.iter().copied().map(ModuleReport::new).collect();
        Ok(Tested {
            adapter,
            shaders,
            report,
        })
    }

    /// Compares the pictures of `scene`, called `name`, on every adapter with every module.
    ///
    /// # Errors
    /// [`RenderError`] if a picture cannot be drawn.
    pub fn pictures(
        all: &mut [Tested],
        scene: &PreparedScene,
        name: &str,
        progress: &dyn Fn(String),
    ) -> Result<(), RenderError> {
        let frame = &scene.frame;
        let mut cpu = CpuRenderer::new(scene);
        let cpu_color = cpu.color(frame)?;
        let cpu_geometry = cpu.geometry(frame)?;
        for tested in all {
            let modules = tested.shaders.iter().zip(&mut tested.report.modules);
            for (&shaders, module) in modules {
                progress(format!("{name}, {}", shaders.describe()));
                let choice = Choice::These(shaders);
                let mut gpu = GpuRenderer::new(scene, &tested.adapter, choice)?;
                let color = gpu.color(frame)?;
                let geometry = gpu.geometry(frame)?;
                let agreement = compare([&color, &cpu_color], [&geometry, &cpu_geometry]);
                module.add_picture(name.to_string(), &agreement);
            }
        }
        Ok(())
    }

    /// Compares the functions of these names with every module.
    ///
    /// # Errors
    /// [`RenderError::Device`] if the device fails.
    pub fn functions(
        &mut self,
        names: &[&str],
        plan: &Plan<'_>,
        progress: &dyn Fn(String, f64),
    ) -> Result<(), RenderError> {
        let device = self.adapter.open()?;
        for (&shaders, module) in self.shaders.iter().zip(&mut self.report.modules) {
            let kernels = shaders.kernels()?;
            let mut runner = Runner::new(&device, &kernels)?;
            for kernel in KERNELS.iter().filter(|kernel| names.contains(&kernel.name)) {
                let progress = |done: u64| {
                    let what = format!("{}, {}", kernel.name, shaders.describe());
                    progress(what, done as f64 / plan.inputs as f64);
                };
                let tally = compare_kernel(&mut runner, kernel, plan, &progress)?;
                module.add_kernel(kernel.name, &tally);
            }
        }
        Ok(())
    }
}
