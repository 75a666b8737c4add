//! Helpers of the cross-crate tests.

mod random;

pub use random::Random;

use relievo::prepare::PreparedScene;
use relievo::render::GpuRenderer;
use relievo::render::gpu::{Adapter, Choice, Shaders, adapters};
use relievo::scene::Scene;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// The repository's root.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .expect("tests/ lies in the repository")
        .to_path_buf()
}

/// A file of `assets/`.
pub fn asset(path: &str) -> PathBuf {
    root().join("assets").join(path)
}

/// Every scene of `assets/scenes`, sorted.
///
/// # Panics
/// If there are none.
pub fn scenes() -> Vec<PathBuf> {
    let mut scenes: Vec<PathBuf> = std::fs::read_dir(asset("scenes"))
        .expect("assets/scenes is a folder")
        .map(|entry| entry.expect("a folder can be listed").path())
        .filter(|path| {
            path.extension()
                .is_some_and(|extension| extension == "toml")
        })
        .collect();
    scenes.sort();
    assert!(!scenes.is_empty());
    scenes
}

/// Makes the shadow maps of `scene` small: software drivers draw millions of texels for
/// minutes.
pub fn coarsen_shadows(scene: &mut Scene) {
    for light in &mut scene.lights {
        light.shadow_size = 128;
    }
}

/// Every GPU adapter of this machine.
///
/// # Panics
/// If there are none.
pub fn every_adapter() -> Vec<Adapter> {
    let all = adapters();
    assert!(
        !all.is_empty(),
        "no GPU adapter: install a Vulkan driver (tests/run does it where it may)"
    );
    all
}

/// Renderers, one for each adapter and each kind of shaders: a driver compiles a shader once for all
/// scenes. Each keeps its last scene on the device.
#[derive(Default)]
pub struct Renderers(Vec<(String, Shaders, GpuRenderer)>);

impl Renderers {
    /// Returns the renderer of `adapter` with `shaders`, for `scene`.
    ///
    /// # Panics
    /// If it cannot be made.
    pub fn show(
        &mut self,
        scene: &PreparedScene,
        adapter: &Adapter,
        shaders: Shaders,
    ) -> &mut GpuRenderer {
        let name = adapter.describe();
        let is_it = |(on, with, _): &(String, Shaders, _)| *on == name && *with == shaders;
        let index = match self.0.iter().position(is_it) {
            Some(index) => {
                self.0[index].2.set_scene(scene).unwrap();
                index
            }
            None => {
                let choice = Choice::These(shaders);
                let renderer = GpuRenderer::new(scene, adapter, choice).unwrap();
                self.0.push((name, shaders, renderer));
                self.0.len() - 1
            }
        };
        &mut self.0[index].2
    }
}

/// Whether long tests are requested: RELIEVO_LONG=1.
pub fn is_long() -> bool {
    std::env::var_os("RELIEVO_LONG").is_some_and(|value| value == "1")
}

/// Reports that a tool is not installed.
///
/// # Panics
/// If RELIEVO_TOOLS=required.
#[track_caller]
pub fn lacking(what: &str) {
    let required = std::env::var_os("RELIEVO_TOOLS").is_some_and(|value| value == "required");
    assert!(!required, "{what} is not here, and RELIEVO_TOOLS=required");
    eprintln!("NOT TESTED: {what} is not here; install it, or set RELIEVO_TOOLS=required to fail");
}

/// The program, built with the profile of this test and in its target folder:
/// cargo names a binary only to tests of its own package.
pub fn program() -> &'static Path {
    static PROGRAM: OnceLock<PathBuf> = OnceLock::new();
    PROGRAM.get_or_init(|| {
        let name = format!("relievo{}", std::env::consts::EXE_SUFFIX);
        built(&[&AS_IN_TESTS[..], &["--bin", "relievo"]].concat(), &name)
    })
}

/// The example that uses the library, built likewise.
pub fn library_example() -> PathBuf {
    let name = format!("examples/library{}", std::env::consts::EXE_SUFFIX);
    built(
        &[&AS_IN_TESTS[..], &["--example", "library"]].concat(),
        &name,
    )
}

/// The example that draws an export with wgpu alone, built likewise.
pub fn plain_wgpu() -> PathBuf {
    let name = format!("plain-wgpu{}", std::env::consts::EXE_SUFFIX);
    built(
        &[&AS_IN_TESTS[..], &["--bin", "plain-wgpu"]].concat(),
        &name,
    )
}

/// The page's builder, built likewise.
pub fn page_builder() -> PathBuf {
    let name = format!("relievo-page-builder{}", std::env::consts::EXE_SUFFIX);
    built(
        &[&AS_IN_TESTS[..], &["--bin", "relievo-page-builder"]].concat(),
        &name,
    )
}

/// The Vulkan driver of `faulty-driver`, built likewise.
pub fn faulty_driver() -> &'static Path {
    static DRIVER: OnceLock<PathBuf> = OnceLock::new();
    DRIVER.get_or_init(|| {
        use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
        let name = format!("{DLL_PREFIX}relievo_faulty_driver{DLL_SUFFIX}");
        built(&["--package", "relievo-faulty-driver"], &name)
    })
}

/// With a test and the whole workspace, dependencies have the features that they
/// have in a run of all tests: they are not built a second time.
const AS_IN_TESTS: [&str; 4] = ["--workspace", "--all-features", "--test", "thorough"];

/// The file `name` that `cargo build` makes with these arguments.
///
/// # Panics
/// If it cannot be built.
fn built(arguments: &[&str], name: &str) -> PathBuf {
    // <target>/<profile>/deps/<test>-<hash>
    let test = std::env::current_exe().expect("a test has a path");
    let folder = test.ancestors().nth(2).expect("it lies in deps");
    let profile = match folder.file_name().and_then(|name| name.to_str()) {
        Some("debug") => "dev",
        Some(other) => other,
        None => panic!("{} has no name", folder.display()),
    };
    let mut cargo = Command::new(env!("CARGO"));
    // The variables that cargo sets for this test would make build scripts that
    // read them run again.
    for (name, _) in std::env::vars_os() {
        let of_package = ["CARGO_PKG_", "CARGO_MANIFEST_", "CARGO_BIN_"];
        if of_package
            .iter()
            .any(|start| name.to_string_lossy().starts_with(start))
        {
            cargo.env_remove(name);
        }
    }
    let built = cargo
        .args(["build", "--quiet", "--profile", profile, "--target-dir"])
        .arg(folder.parent().expect("a profile's folder lies in target"))
        .args(arguments)
        .current_dir(root())
        .status()
        .expect("cargo runs");
    assert!(built.success());
    folder.join(name)
}
