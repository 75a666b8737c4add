//! Compiles `shader-crate` to SPIR-V with rust-gpu and writes the modules and
//! their manifest to `assets/shaders`:
//!
//! ```text
//! cargo +nightly-2026-08-15 run --release --manifest-path shader-crate/builder/Cargo.toml
//! ```
//!
//! With `-- --check` it writes nothing, and fails if the committed files differ from the
//! output.

use anyhow::{Context, Result, bail};
use relievo_shader_builder::compile::compile as compile_shaders;
use relievo_shader_builder::rust_gpu::{RUST_GPU, TARGET, rustc_version};
use relievo_shader_builder::shader_crate::{ShaderCrate, Variant};
use relievo_shader_manifest::{
    MANIFEST_FILE, Manifest, Module, SHADER_FOLDER, Toolchain, digest, source_digests,
};
use std::collections::{BTreeMap, BTreeSet};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

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

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<()> {
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
    // Beside the builder's own target folder: both are worth caching.
    let target_folder = std::env::current_exe()?
        .ancestors()
        .nth(2)
        .context("the program lies in a target folder")?
        .join("spirv");
    for shaders in &CRATES {
        let shader_crate = ShaderCrate {
            folder: root.join(shaders.folder),
            features: Vec::new(),
            target_folder: target_folder.clone(),
        };
        for variant in [Variant::Fast, Variant::Exact] {
            let folder = format!("{}_{}", shaders.name, variant.name());
            let compiled =
                compile_shaders(&shader_crate, variant).with_context(|| shaders.folder)?;
            for (entry_point, words) in compiled {
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
