//! The files of a project's shader folder: the modules of its shader crates, and their
//! manifest.

use crate::compile::finish;
use crate::rust_gpu::{self, Modules, RUST_GPU, TARGET, rustc_version};
use crate::shader_crate::{FUSED, ShaderCrate, Variant};
use anyhow::{Context, Result, bail};
use cargo_metadata::MetadataCommand;
use relievo_shader_manifest::{
    self as manifest, MANIFEST_FILE, Manifest, Module, Project, Toolchain, VERSION, digest,
    source_digests,
};
use std::collections::{BTreeMap, BTreeSet};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Bytes of files by their names in the shader folder.
pub type Files = BTreeMap<String, Vec<u8>>;

/// Compiles every file of a project's shader folder. What cargo builds goes to
/// `target_folder`.
///
/// # Errors
///
/// If a crate does not compile or is not exact, or cargo cannot read the project.
pub fn compile(project: &Project, target_folder: &Path) -> Result<Files> {
    let mut files = Files::new();
    let mut modules = BTreeMap::new();
    let mut folders = BTreeMap::new();
    let variants = variants(project)?;
    // Before minutes of compilation.
    let sources = source_digests(project)?;
    let rustc = rustc_version()?;
    for (shaders, variant, compiled) in compile_variants(project, variants, target_folder)? {
        let folder = format!("{}_{}", shaders.name, variant.name());
        for (entry_point, words) in compiled {
            let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
            let file = format!("{folder}/{}.spv", file_stem(&entry_point)?);
            // On some systems, the same in upper and lower case are one file.
            if let Some(other) = files.keys().find(|f| f.eq_ignore_ascii_case(&file)) {
                bail!(
                    "{file} and {other} would be one file on some systems; rename an entry point"
                );
            }
            modules.insert(
                file.clone(),
                Module {
                    sha256: digest(&bytes),
                    bytes: bytes.len() as u64,
                },
            );
            files.insert(file, bytes);
        }
        folders.insert(folder, format!("{}: {}", shaders.about, variant.describe()));
    }
    if source_digests(project)? != sources {
        bail!("the sources changed during the compilation; build again");
    }
    let manifest = Manifest {
        toolchain: Toolchain {
            rustc,
            rust_gpu: RUST_GPU.to_string(),
            builder: VERSION.to_string(),
            target: TARGET.to_string(),
        },
        folders,
        modules,
        sources,
    };
    files.insert(MANIFEST_FILE.to_string(), manifest.to_text().into_bytes());
    Ok(files)
}

/// Compiles the variants of each crate. While rust-gpu compiles one, a thread finishes the
/// modules of the one before.
fn compile_variants<'a>(
    project: &'a Project,
    variants: Vec<Vec<Variant>>,
    target_folder: &Path,
) -> Result<Vec<(&'a manifest::ShaderCrate, Variant, Modules)>> {
    std::thread::scope(|scope| {
        let mut threads = Vec::new();
        for (shaders, variants) in project.crates.iter().zip(variants) {
            let shader_crate = ShaderCrate {
                folder: shaders.folder.clone(),
                features: Vec::new(),
                target_folder: target_folder.to_path_buf(),
            };
            for variant in variants {
                let modules = rust_gpu::run(&shader_crate, variant)
                    .with_context(|| format!("the shader crate {}", shaders.name))?;
                let shader_crate = shader_crate.clone();
                let thread = scope.spawn(move || finish(&shader_crate, variant, modules));
                threads.push((shaders, variant, thread));
            }
        }
        let finished = threads.into_iter().map(|(shaders, variant, thread)| {
            let result = thread.join();
            let modules = result
                .unwrap_or_else(|panic| std::panic::resume_unwind(panic))
                .with_context(|| format!("the shader crate {}", shaders.name))?;
            Ok((shaders, variant, modules))
        });
        finished.collect()
    })
}

/// Returns the variants of each crate. Cargo brings the lock files up to date, too: their
/// digests are taken before it compiles.
fn variants(project: &Project) -> Result<Vec<Vec<Variant>>> {
    let of = |shaders: &manifest::ShaderCrate| {
        let manifest_path = shaders.folder.join("Cargo.toml");
        let metadata = MetadataCommand::new()
            .manifest_path(&manifest_path)
            .exec()
            .with_context(|| format!("cargo metadata of {}", shaders.path))?;
        let mut packages = metadata.packages.iter();
        let package = packages.find(|package| package.manifest_path == manifest_path);
        let is_fused = package.is_some_and(|package| package.features.contains_key(FUSED));
        let mut variants = vec![Variant::Fast, Variant::Exact];
        variants.extend(is_fused.then_some(Variant::Fused));
        Ok(variants)
    };
    project.crates.iter().map(of).collect()
}

/// Returns the file name of an entry point, without extension. A function in a module has
/// `::` in its name, which not every file system takes.
fn file_stem(entry_point: &str) -> Result<String> {
    let stem = entry_point.replace("::", ".");
    if stem.is_empty() || stem.contains(['/', '\\', ':']) {
        bail!("the entry point {entry_point:?} cannot be the name of a file; rename it");
    }
    Ok(stem)
}

/// Returns the names of the files in the shader folder that are not as in `files`, and of
/// modules that are not in `files`.
///
/// # Errors
///
/// If a folder cannot be read.
pub fn differences(project: &Project, files: &Files) -> Result<Vec<String>> {
    let folder = project.shader_folder();
    let is_other =
        |name: &str, bytes| std::fs::read(folder.join(name)).ok().as_ref() != Some(bytes);
    let changed = files
        .iter()
        .filter(|(name, bytes)| is_other(name, bytes))
        .map(|(name, _)| name.clone());
    let others = others(project, files)?;
    let others = others.iter().map(|path| {
        let below = path.strip_prefix(&folder).unwrap_or(path);
        below.display().to_string()
    });
    Ok(changed.chain(others).collect())
}

/// Writes `files` to the shader folder, and removes the modules of entry points and crates
/// that no longer exist.
///
/// # Errors
///
/// If a file cannot be written or removed.
pub fn write(project: &Project, files: &Files) -> Result<()> {
    let folder = project.shader_folder();
    let others = others(project, files)?;
    for (name, bytes) in files {
        let path = folder.join(name);
        std::fs::create_dir_all(path.parent().context("a file has a folder")?)?;
        write_whole(&path, bytes)?;
    }
    for path in others {
        std::fs::remove_file(&path)?;
        // Only an empty folder is removed.
        let _ = path.parent().map(std::fs::remove_dir);
    }
    Ok(())
}

/// Returns the modules that are not in `files`: beside them, or made for the last manifest.
fn others(project: &Project, files: &Files) -> Result<BTreeSet<PathBuf>> {
    let folder = project.shader_folder();
    let made: BTreeSet<PathBuf> = files.keys().map(|name| folder.join(name)).collect();
    let mut found = BTreeSet::new();
    let folders: BTreeSet<&Path> = made.iter().filter_map(|path| path.parent()).collect();
    for folder in folders.into_iter().filter(|folder| folder.is_dir()) {
        for entry in std::fs::read_dir(folder)? {
            found.insert(entry?.path());
        }
    }
    // An unreadable manifest names no modules.
    if let Ok(last) = Manifest::load(project) {
        let paths = last.modules.keys().map(|name| folder.join(name));
        found.extend(paths.filter(|path| path.is_file()));
    }
    let is_module = |path: &PathBuf| path.extension().is_some_and(|extension| extension == "spv");
    found.retain(|path| is_module(path) && !made.contains(path));
    Ok(found)
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

#[cfg(test)]
mod tests {
    use super::*;

    fn project(root: &Path) -> Project {
        Project {
            manifest_path: root.join("Cargo.toml"),
            root: root.to_path_buf(),
            shaders: "shaders".to_string(),
            also: Vec::new(),
            crates: Vec::new(),
            section: String::new(),
        }
    }

    /// A manifest that lists `modules`, and the modules themselves.
    fn made(modules: &[&str]) -> Files {
        let module = Module {
            sha256: digest(b"words"),
            bytes: 5,
        };
        let manifest = Manifest {
            toolchain: Toolchain {
                rustc: String::new(),
                rust_gpu: String::new(),
                builder: String::new(),
                target: String::new(),
            },
            folders: BTreeMap::new(),
            modules: modules
                .iter()
                .map(|name| (name.to_string(), module.clone()))
                .collect(),
            sources: BTreeMap::new(),
        };
        let mut files: Files = modules
            .iter()
            .map(|name| (name.to_string(), b"words".to_vec()))
            .collect();
        files.insert(MANIFEST_FILE.to_string(), manifest.to_text().into_bytes());
        files
    }

    #[test]
    fn names_of_files_have_no_colons() {
        assert_eq!(
            file_stem("light::kernels::sum").unwrap(),
            "light.kernels.sum"
        );
        for name in ["", "a/b", "a:b", "a\\b"] {
            assert!(file_stem(name).is_err(), "{name}");
        }
    }

    #[test]
    fn what_no_longer_exists_is_removed() {
        let root = tempfile::tempdir().unwrap();
        let project = project(root.path());
        let first = made(&["a_fast/one.spv", "a_fast/two.spv", "b_fast/one.spv"]);
        write(&project, &first).unwrap();
        assert!(differences(&project, &first).unwrap().is_empty());
        // Not the builder's.
        let own = root.path().join("shaders/a_fast/notes.txt");
        std::fs::write(&own, "").unwrap();

        let second = made(&["a_fast/one.spv"]);
        assert_eq!(
            differences(&project, &second).unwrap(),
            [MANIFEST_FILE, "a_fast/two.spv", "b_fast/one.spv"]
        );
        write(&project, &second).unwrap();
        assert!(differences(&project, &second).unwrap().is_empty());
        assert!(own.exists() && !root.path().join("shaders/b_fast").exists());

        std::fs::write(root.path().join("shaders/a_fast/one.spv"), "words?").unwrap();
        assert_eq!(differences(&project, &second).unwrap(), ["a_fast/one.spv"]);
    }
}
