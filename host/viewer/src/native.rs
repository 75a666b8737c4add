//! The viewer in a desktop window.

use super::Viewer;
use super::dropped::Arrived;
use super::platform::Platform;
use super::probe::Probe;
use eframe::egui::{self, vec2};
use eframe::egui_wgpu::{WgpuConfiguration, WgpuSetup, WgpuSetupCreateNew};
use relievo::Error;
use relievo::export::{ExportedFile, contents};
use relievo::file::{write_bytes, write_folder};
use relievo::render::RenderError;
use relievo::scene::Scene;
use relievo_bitwise::descriptor;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use web_time::Instant;

/// Window options.
#[derive(Clone, Debug)]
pub struct Options {
    /// Folder for saved pictures and scenes.
    pub folder: PathBuf,
    /// Substring of the wanted adapter's name.
    pub adapter: Option<String>,
    /// Width and height of the window, points.
    pub size: [f32; 2],
    /// File that receives the window's state as JSON whenever it changes.
    pub probe: Option<PathBuf>,
}

/// Opens a window on `scene` and returns when it is closed.
///
/// # Errors
/// No window can be opened, or no adapter fits.
pub fn run(scene: Scene, options: &Options) -> Result<(), Error> {
    let started = Instant::now();
    let mut setup = WgpuSetupCreateNew::without_display_handle();
    setup.instance_descriptor = wgpu::InstanceDescriptor {
        backends: wgpu::Backends::PRIMARY,
        // Validation only on request, also in debug builds.
        flags: wgpu::InstanceFlags::empty().with_env(),
        ..wgpu::InstanceDescriptor::new_without_display_handle_from_env()
    };
    setup.device_descriptor = Arc::new(descriptor);
    if let Some(wanted) = options.adapter.clone() {
        setup.native_adapter_selector =
            Some(Arc::new(move |all, surface| choose(all, surface, &wanted)));
    }
    let title = format!("Relievo: {}", scene.path.display());
    let native = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_title(title)
            .with_app_id("relievo")
            .with_inner_size(vec2(options.size[0], options.size[1]))
            .with_min_inner_size(vec2(480.0, 320.0)),
        renderer: eframe::Renderer::Wgpu,
        wgpu_options: WgpuConfiguration {
            wgpu_setup: WgpuSetup::CreateNew(setup),
            ..Default::default()
        },
        dithering: false,
        ..Default::default()
    };
    let desktop = Desktop {
        folder: options.folder.clone(),
        probe: options.probe.clone(),
    };
    // Keeps our own error; eframe only passes its text on.
    let fault = Arc::new(Mutex::new(None));
    let told = fault.clone();
    let opened = eframe::run_native(
        "relievo",
        native,
        Box::new(
            move |context| match Viewer::new(context, scene, Box::new(desktop), started) {
                Ok(viewer) => Ok(Box::new(viewer)),
                Err(error) => {
                    let message = error.to_string();
                    *told.lock().unwrap_or_else(PoisonError::into_inner) = Some(error);
                    Err(message.into())
                }
            },
        ),
    );
    if let Some(error) = fault.lock().unwrap_or_else(PoisonError::into_inner).take() {
        return Err(error);
    }
    opened.map_err(|error| {
        Error::from(RenderError::Window {
            message: error.to_string(),
        })
    })
}

/// Returns the first adapter that can draw on `surface` and has `wanted` in its
/// name or driver.
fn choose(
    all: &[wgpu::Adapter],
    surface: Option<&wgpu::Surface<'_>>,
    wanted: &str,
) -> Result<wgpu::Adapter, String> {
    let describe = |adapter: &wgpu::Adapter| {
        let info = adapter.get_info();
        format!("{} ({:?}, {})", info.name, info.backend, info.driver)
    };
    let usable = |adapter: &&wgpu::Adapter| {
        surface.is_none_or(|surface| adapter.is_surface_supported(surface))
            && describe(adapter)
                .to_lowercase()
                .contains(&wanted.to_lowercase())
    };
    all.iter().find(usable).cloned().ok_or_else(|| {
        let names: Vec<String> = all.iter().map(describe).collect();
        format!(
            "no adapter that can draw on a window has {wanted:?} in its name; there are: {}",
            names.join("; ")
        )
    })
}

/// Saves files to a folder.
struct Desktop {
    folder: PathBuf,
    probe: Option<PathBuf>,
}

impl Platform for Desktop {
    fn save_file(&mut self, name: &str, bytes: &[u8]) -> Result<String, String> {
        let path = self.folder.join(name);
        write_bytes(&path, bytes).map_err(|error| error.to_string())?;
        Ok(path.display().to_string())
    }

    fn save_folder(&mut self, name: &str, files: &[ExportedFile]) -> Result<String, String> {
        let folder = self.folder.join(name);
        write_folder(&folder, contents(files)).map_err(|error| error.to_string())?;
        Ok(folder.display().to_string())
    }

    fn choose(&mut self, _arrived: &Arrived) -> bool {
        false
    }

    fn folder(&self) -> &Path {
        &self.folder
    }

    fn listens(&self) -> bool {
        self.probe.is_some()
    }

    fn tell(&mut self, probe: &Probe) {
        let Some(path) = &self.probe else { return };
        let told = serde_json::to_vec_pretty(probe)
            .map_err(|error| error.to_string())
            .and_then(|json| write_bytes(path, &json).map_err(|error| error.to_string()));
        if let Err(problem) = told {
            log::warn!("{problem}");
            // Warn once only.
            self.probe = None;
        }
    }
}
