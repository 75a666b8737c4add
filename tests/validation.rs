//! Vulkan's validation layer reports nothing for any scene, and does report
//! errors.
//!
//! wgpu enables the layer in builds with debug assertions, and elsewhere if
//! WGPU_VALIDATION=1 is set. WGPU_GPU_BASED_VALIDATION=1 checks shaders while
//! they run. Synchronization is always checked.
//!
//! With the environment variable RELIEVO_LONG=1 every gallery scene is drawn,
//! instead of every eleventh, and every technique with all shaders, instead of
//! the exact ones.

use log::{LevelFilter, Log, Metadata, Record};
use relievo::prepare::{PreparedScene, prepare};
use relievo::render::gpu::{Adapter, Choice, Shaders};
use relievo::render::{GpuRenderer, Renderer};
use relievo::scene::Scene;
use relievo::verify::matrix::for_each_variant;
use relievo_bitwise::DeviceError;
use relievo_bitwise::wgpu::{self, InstanceFlags};
use relievo_tests::{asset, coarsen_shadows, every_adapter, is_long, root, scenes};
use std::borrow::Cow;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;

/// wgpu's log, which receives the layer's messages.
struct Listener {
    complaints: Mutex<Vec<String>>,
    has_layer: Mutex<bool>,
}

static LISTENER: Listener = Listener {
    complaints: Mutex::new(Vec::new()),
    has_layer: Mutex::new(true),
};

impl Log for Listener {
    fn enabled(&self, metadata: &Metadata) -> bool {
        metadata.target().starts_with("wgpu_hal::vulkan")
    }

    fn log(&self, record: &Record) {
        if !self.enabled(record.metadata()) {
            return;
        }
        let text = record.args().to_string();
        if text.contains("unable to find layer") {
            *self.has_layer.lock().unwrap() = false;
        }
        if record.level() <= log::Level::Warn {
            self.complaints.lock().unwrap().push(text);
        }
    }

    fn flush(&self) {}
}

/// Messages since the last call.
fn complaints() -> Vec<String> {
    std::mem::take(&mut *LISTENER.complaints.lock().unwrap())
}

fn prepared(path: &Path) -> PreparedScene {
    let mut scene = Scene::load(path).unwrap();
    scene.size = [16, 12];
    coarsen_shadows(&mut scene);
    prepare(&scene, &|_| ()).unwrap()
}

/// Draws every output.
fn draw(scene: &PreparedScene, adapter: &Adapter, shaders: Shaders) {
    let mut gpu = GpuRenderer::new(scene, adapter, Choice::These(shaders)).unwrap();
    gpu.color(&scene.frame).unwrap();
    gpu.geometry(&scene.frame).unwrap();
    gpu.color(&scene.frame_with_samples(2)).unwrap();
    gpu.time_color(&scene.frame).unwrap();
}

/// The layer's messages about a module with a misplaced capability.
fn what_a_wrong_module_makes_it_say(adapter: &Adapter) -> Vec<String> {
    let bytes = std::fs::read(asset("shaders/relievo_exact/place.spv")).unwrap();
    let mut words: Vec<u32> = bytemuck::pod_collect_to_vec(&bytes);
    // OpCapability Shader.
    words.extend([2 << 16 | 17, 1]);
    let device = adapter.open().unwrap();
    let _ = complaints();
    let entry_point = wgpu::PassthroughShaderEntryPoint {
        name: Cow::Borrowed("place"),
        workgroup_size: (1, 1, 1),
    };
    let descriptor = wgpu::ShaderModuleDescriptorPassthrough {
        entry_points: vec![entry_point].into(),
        spirv: Some(Cow::Owned(words)),
        ..Default::default()
    };
    device
        .attempt(|| {
            // SAFETY: a driver reads a module only when a pipeline is created
            // from it.
            let _ = unsafe { device.wgpu().create_shader_module_passthrough(descriptor) };
            Ok::<_, DeviceError>(())
        })
        .unwrap();
    complaints()
}

/// The layer caches which modules it has checked and is silent on those, so
/// this runs with its own cache.
#[test]
fn gpu_the_validation_layer_is_silent() {
    let memory = tempfile::tempdir().unwrap();
    let status = Command::new(std::env::current_exe().unwrap())
        .args(["what_the_layer_says", "--exact", "--ignored", "--nocapture"])
        .env("XDG_CACHE_HOME", memory.path())
        .status()
        .unwrap();
    assert!(status.success());
}

#[test]
#[ignore = "gpu_the_validation_layer_is_silent runs it"]
fn what_the_layer_says() {
    log::set_logger(&LISTENER).unwrap();
    log::set_max_level(LevelFilter::Debug);
    let all = every_adapter();
    if !InstanceFlags::from_env_or_default().contains(InstanceFlags::VALIDATION) {
        eprintln!("LEFT OUT: this build does not ask for validation; set WGPU_VALIDATION=1");
        return;
    }
    if !*LISTENER.has_layer.lock().unwrap() {
        eprintln!("LEFT OUT: no validation layer; install vulkan-validationlayers");
        return;
    }
    let adapters: Vec<Adapter> = all.into_iter().filter(Adapter::takes_spirv).collect();
    let mut pictures = 0;
    for adapter in &adapters {
        // Silence means nothing unless an error is reported.
        let said = what_a_wrong_module_makes_it_say(adapter);
        assert!(
            said.iter().any(|text| text.contains("Capability")),
            "{said:?}"
        );
    }

    let gallery = std::fs::read_dir(root().join("docs/gallery/scenes")).unwrap();
    let mut gallery: Vec<PathBuf> = gallery.map(|entry| entry.unwrap().path()).collect();
    gallery.sort();
    let (step, modules): (usize, &[Shaders]) = match is_long() {
        true => (1, &Shaders::ALL),
        false => (11, &[Shaders::Exact]),
    };
    let paths = scenes()
        .into_iter()
        .chain(gallery.into_iter().step_by(step));
    for path in paths {
        let mut scene = prepared(&path);
        for adapter in &adapters {
            draw(&scene, adapter, Shaders::Exact);
            pictures += 4;
        }
        if path == asset("scenes/together.toml") {
            for_each_variant(&mut scene, |scene, _| {
                for adapter in &adapters {
                    for &shaders in modules {
                        draw(scene, adapter, shaders);
                        pictures += 4;
                    }
                }
                Ok::<(), ()>(())
            })
            .unwrap();
        }
        let said = complaints();
        assert!(said.is_empty(), "{}: {said:#?}", path.display());
    }
    // Functions of the canaries, as compute shaders.
    for adapter in &adapters {
        relievo::render::gpu::signature(&adapter.open().unwrap()).unwrap();
    }
    let said = complaints();
    assert!(said.is_empty(), "{said:#?}");
    eprintln!("{pictures} pictures on {} adapters", adapters.len());
}
