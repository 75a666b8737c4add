//! Compiles `shader-crate` to SPIR-V with rust-gpu and writes the modules and
//! their manifest to `assets/shaders`:
//!
//! ```text
//! cargo +nightly-2026-08-15 run --release --manifest-path shader-crate/builder/Cargo.toml
//! ```
//!
//! With `-- --check` it writes nothing, and fails if the committed files differ from the
//! output.

mod arms;
mod exact;
mod words;

use anyhow::{Context, Result, bail};
use relievo_shader_manifest::{
    MANIFEST_FILE, Manifest, Module, SHADER_FOLDER, Toolchain, digest, source_digests,
};
use spirv_builder::{SpirvBuilder, SpirvMetadata};
use std::collections::{BTreeMap, BTreeSet};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The nightly that rust-gpu 0.11.0 is a backend of; as in `rust-toolchain.toml`.
const NIGHTLY: &str = "nightly-2026-08-15";
const RUST_GPU: &str = "0.11.0";
const TARGET: &str = "spirv-unknown-vulkan1.1";
/// The crates, their folders, and the names of their modules.
const CRATES: [Shaders; 2] = [
    Shaders {
        folder: "shader-crate",
        what: "the renderer",
        name: "relievo",
    },
    Shaders {
        folder: "shader-crate/kernels",
        what: "functions to compare",
        name: "kernels",
    },
];

/// A shader crate.
struct Shaders {
    folder: &'static str,
    what: &'static str,
    /// Prefix of the folders of its modules.
    name: &'static str,
}

fn main() -> Result<()> {
    let check = match std::env::args().skip(1).collect::<Vec<_>>().as_slice() {
        [] => false,
        [flag] if flag == "--check" => true,
        other => bail!("unknown arguments {other:?}; the only one is --check"),
    };
    let builder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let root = builder
        .join("../..")
        .canonicalize()
        .context("the builder must run where it was built")?;
    let files = compile(&root)?;
    let folder = root.join(SHADER_FOLDER);
    if check {
        let mut wrong = Vec::new();
        for (name, bytes) in &files {
            if std::fs::read(folder.join(name)).ok().as_ref() != Some(bytes) {
                wrong.push(name.as_str());
            }
        }
        if !wrong.is_empty() {
            bail!(
                "not what the sources give: {}; run the builder without --check and commit {SHADER_FOLDER}",
                wrong.join(", ")
            );
        }
        println!(
            "{} files in {SHADER_FOLDER} are what the sources give",
            files.len()
        );
    } else {
        for (name, bytes) in &files {
            let path = folder.join(name);
            std::fs::create_dir_all(path.parent().context("a file has a folder")?)?;
            write_whole(&path, bytes)?;
        }
        remove_others(&folder, &files)?;
        let bytes: usize = files.values().map(Vec::len).sum();
        println!("{SHADER_FOLDER}: {} files, {bytes} bytes", files.len());
    }
    Ok(())
}

/// Compiles every file of the shader folder, by name.
fn compile(root: &Path) -> Result<BTreeMap<String, Vec<u8>>> {
    let mut files = BTreeMap::new();
    let mut modules = BTreeMap::new();
    let mut folders = BTreeMap::new();
    for shaders in &CRATES {
        for variant in [Variant::Fast, Variant::Exact] {
            let folder = format!("{}_{}", shaders.name, variant.name());
            for (entry_point, mut words) in run_rust_gpu(root, shaders, variant)? {
                if let Variant::Exact = variant {
                    words = exact::make(&words)
                        .with_context(|| format!("the exact module of {entry_point}"))?;
                }
                let words = arms::remove_empty(&words)?;
                words::validate(&words)
                    .with_context(|| format!("the {} module of {entry_point}", variant.name()))?;
                let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
                let file = format!("{folder}/{entry_point}.spv");
                modules.insert(
                    file.clone(),
                    Module {
                        sha256: digest(&bytes),
                        bytes: bytes.len() as u64,
                    },
                );
                files.insert(file, bytes);
            }
            folders.insert(folder, format!("{}: {}", shaders.what, variant.describe()));
        }
    }
    let manifest = Manifest {
        toolchain: Toolchain {
            rustc: rustc_version()?,
            rust_gpu: RUST_GPU.to_string(),
            target: TARGET.to_string(),
        },
        folders,
        modules,
        sources: source_digests(root)?,
    };
    files.insert(MANIFEST_FILE.to_string(), manifest.to_text().into_bytes());
    Ok(files)
}

/// The two ways to compile a shader crate.
#[derive(Clone, Copy)]
enum Variant {
    Fast,
    Exact,
}

impl Variant {
    fn name(self) -> &'static str {
        match self {
            Variant::Fast => "fast",
            Variant::Exact => "exact",
        }
    }

    /// Describes how it is made.
    fn describe(self) -> &'static str {
        match self {
            // For any backend, through naga too.
            Variant::Fast => "optimised freely by spirv-opt",
            // Gives the CPU's words; passed to the driver untouched.
            Variant::Exact => {
                "division and square root corrected, every float operation NoContraction, then optimised; opcodes from an allow-list"
            }
        }
    }
}

/// Compiles a shader crate; returns the words of one module for each entry point, since
/// drivers read the whole module for every pipeline.
fn run_rust_gpu(
    root: &Path,
    shaders: &Shaders,
    variant: Variant,
) -> Result<BTreeMap<String, Vec<u32>>> {
    // Beside the builder's own target folder: both are worth caching.
    let target_folder = std::env::current_exe()?
        .ancestors()
        .nth(2)
        .context("the program lies in a target folder")?
        .join("spirv")
        .join(variant.name());
    let mut spirv = SpirvBuilder::new(root.join(shaders.folder), TARGET)
        .deny_warnings(true)
        .multimodule(true)
        .spirv_metadata(SpirvMetadata::None)
        .target_dir_path(target_folder);
    spirv.toolchain_overwrite = Some(NIGHTLY.to_string());
    if let Variant::Exact = variant {
        // The exact module is optimised after it is decorated.
        spirv.extra_args = vec!["--no-spirv-opt".to_string()];
        spirv = spirv.shader_crate_features(["corrected".to_string()]);
    }
    let result = spirv
        .build()
        .with_context(|| format!("rust-gpu did not compile {}", shaders.folder))?;
    let mut modules = BTreeMap::new();
    for (entry_point, path) in result.module.unwrap_multi() {
        let words = std::fs::read(path)?
            .chunks_exact(4)
            .map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]]))
            .collect();
        modules.insert(entry_point.clone(), words);
    }
    Ok(modules)
}

/// Removes the modules of entry points that no longer exist.
fn remove_others(folder: &Path, files: &BTreeMap<String, Vec<u8>>) -> Result<()> {
    let made: BTreeSet<PathBuf> = files.keys().map(|name| folder.join(name)).collect();
    let folders: BTreeSet<&Path> = made.iter().filter_map(|path| path.parent()).collect();
    for folder in folders {
        for entry in std::fs::read_dir(folder)? {
            let path = entry?.path();
            let is_module = path.extension().is_some_and(|extension| extension == "spv");
            if is_module && !made.contains(&path) {
                std::fs::remove_file(&path)?;
            }
        }
    }
    Ok(())
}

fn rustc_version() -> Result<String> {
    let output = Command::new("rustc")
        .arg(format!("+{NIGHTLY}"))
        .arg("--version")
        .output()
        .context("cannot run rustc through rustup")?;
    if !output.status.success() {
        bail!(
            "{NIGHTLY} is not installed: rustup toolchain install {NIGHTLY} --profile minimal -c rust-src -c rustc-dev -c llvm-tools"
        );
    }
    Ok(String::from_utf8(output.stdout)?.trim().to_string())
}

/// Writes beside `path` and renames, so that readers never see a partial file.
fn write_whole(path: &PathBuf, bytes: &[u8]) -> Result<()> {
    let folder = path.parent().context("a file has a folder")?;
    let mut file = tempfile::NamedTempFile::new_in(folder)?;
    file.write_all(bytes)?;
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        file.as_file()
            .set_permissions(std::fs::Permissions::from_mode(0o644))?;
    }
    file.persist(path)?;
    Ok(())
}
