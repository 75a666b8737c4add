//! Digests of what decides the modules of a project.

use crate::error::ManifestError;
use crate::files::{canonical, entries, read, read_toml, wrong};
use crate::inherited::{inherited, of_workspace};
use crate::lock::locked;
use crate::manifest::digest;
use crate::packages::{Package, Packages};
use crate::project::Project;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Returns digests of all that decides the modules of a project, by name.
///
/// Sources are those of the shader crates and of their path dependencies: `Cargo.toml`, the
/// build script, and the `.rs` files of the library. A file in the project has its path from
/// the project's root as name. A file elsewhere has the name of its package and the path
/// from there, so that no name depends on the machine. Further names are parts of files:
/// what packages inherit, the locked dependencies, and the project's own section.
///
/// # Errors
/// [`ManifestError`] if a file cannot be read, or cargo cannot read a package.
pub fn source_digests(project: &Project) -> Result<BTreeMap<String, String>, ManifestError> {
    let packages = Packages::of(
        project
            .crates
            .iter()
            .map(|shaders| shaders.folder.as_path()),
    )?;
    let mut files = BTreeMap::new();
    for package in packages.needed.values() {
        let mut paths = BTreeSet::from([package.folder.join("Cargo.toml")]);
        paths.extend(package.build_script.clone());
        for folder in source_folders(package) {
            collect(&folder, &mut paths)?;
        }
        for path in paths {
            let name = name(project, package, &path);
            if let Some(other) = files
                .insert(name.clone(), path.clone())
                .filter(|o| *o != path)
            {
                let message = format!(
                    "it and {} would both be listed as {name}; rename a package",
                    other.display()
                );
                return Err(wrong(&path, message));
            }
        }
    }
    for path in &project.also {
        let mut paths = BTreeSet::new();
        collect(&project.root.join(path), &mut paths)?;
        for path in paths {
            files.insert(below(&project.root, &path), path);
        }
    }

    let mut digests = BTreeMap::new();
    for (name, path) in files {
        let digest = if path.ends_with("Cargo.toml") {
            digest(decisive(&read_toml(&path)?).as_bytes())
        } else {
            // git may write other line ends.
            digest(&without_carriage_returns(read(&path)?))
        };
        digests.insert(name, digest);
    }
    let mut part = |name: String, text: &str| digests.insert(name, digest(text.as_bytes()));
    part("Cargo.toml: metadata.relievo".to_string(), &project.section);
    for package in packages.needed.values() {
        let text = inherited(package)?;
        if !text.is_empty() {
            part(format!("{}: what it inherits", package.name), &text);
        }
    }
    for shaders in &project.crates {
        let package = &packages.needed[&shaders.folder];
        let lines = locked(&packages, &shaders.folder)?;
        part(
            format!("{}: locked dependencies", package.name),
            &lines.join("\n"),
        );
        let text = of_workspace(&package.workspace)?;
        part(
            format!("{}: profile, resolver and patches", package.name),
            &text,
        );
    }
    Ok(digests)
}

/// Returns the parts of a package's `Cargo.toml` that decide its code: not what only tests
/// need, and not where its dependencies lie.
fn decisive(manifest: &toml::Table) -> String {
    let mut parts = toml::Table::new();
    let mut package = manifest.get("package").cloned();
    if let Some(package) = package.as_mut().and_then(toml::Value::as_table_mut) {
        package.retain(|key, _| ["name", "edition", "version", "build", "links"].contains(&key));
    }
    parts.extend(package.map(|package| ("package".to_string(), package)));
    for key in [
        "lib",
        "features",
        "dependencies",
        "build-dependencies",
        "target",
    ] {
        parts.extend(
            manifest
                .get(key)
                .map(|part| (key.to_string(), part.clone())),
        );
    }
    remove_paths(&mut parts);
    canonical(&toml::Value::Table(parts))
}

/// Removes what only tests need, and the paths of dependencies.
fn remove_paths(table: &mut toml::Table) {
    table.remove("dev-dependencies");
    for key in ["dependencies", "build-dependencies"] {
        let dependencies = table.get_mut(key).and_then(toml::Value::as_table_mut);
        for (_, dependency) in dependencies.into_iter().flatten() {
            if let Some(dependency) = dependency.as_table_mut() {
                dependency.remove("path");
            }
        }
    }
    let targets = table.get_mut("target").and_then(toml::Value::as_table_mut);
    for (_, target) in targets.into_iter().flatten() {
        target.as_table_mut().into_iter().for_each(remove_paths);
    }
}

fn without_carriage_returns(mut bytes: Vec<u8>) -> Vec<u8> {
    bytes.retain(|&byte| byte != b'\r');
    bytes
}

/// Returns the folders of a package's sources: `src`, and that of its library if it lies
/// elsewhere.
fn source_folders(package: &Package) -> Vec<PathBuf> {
    let src = package.folder.join("src");
    let library = package.library.as_ref().and_then(|file| file.parent());
    let elsewhere = library.filter(|folder| !folder.starts_with(&src));
    let src = Some(src).filter(|src| src.is_dir());
    src.into_iter()
        .chain(elsewhere.map(PathBuf::from))
        .collect()
}

/// Adds the file `path`, or the `.rs` files below the folder `path`.
fn collect(path: &Path, files: &mut BTreeSet<PathBuf>) -> Result<(), ManifestError> {
    if !path.is_dir() {
        files.insert(path.to_path_buf());
        return Ok(());
    }
    for entry in entries(path)? {
        let name = entry.file_name().unwrap_or_default().to_string_lossy();
        // A folder with a Cargo.toml is another package.
        let is_folder = entry.is_dir()
            && name != "target"
            && !name.starts_with('.')
            && !entry.join("Cargo.toml").exists();
        // Unit tests do not decide the modules.
        let is_source = name.ends_with(".rs") && name != "tests.rs" && !entry.is_dir();
        if is_folder || is_source {
            collect(&entry, files)?;
        }
    }
    Ok(())
}

/// Returns the name of a package's file.
fn name(project: &Project, package: &Package, path: &Path) -> String {
    if path.starts_with(&project.root) {
        below(&project.root, path)
    } else {
        format!("{}/{}", package.name, below(&package.folder, path))
    }
}

/// Returns a path from a folder, with '/' on every system.
fn below(folder: &Path, path: &Path) -> String {
    let path = path.strip_prefix(folder).unwrap_or(path);
    let parts: Vec<_> = path.iter().map(|part| part.to_string_lossy()).collect();
    parts.join("/")
}
