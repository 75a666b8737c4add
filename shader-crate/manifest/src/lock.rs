//! The locked dependencies of a package.

use crate::error::ManifestError;
use crate::files::{read_toml, wrong};
use crate::packages::Packages;
use std::collections::BTreeSet;
use std::path::Path;

/// Returns a line for each package that the package in `folder` needs, direct and indirect,
/// itself included: name, version, checksum. What only tests need is not among them.
pub fn locked(packages: &Packages, folder: &Path) -> Result<Vec<String>, ManifestError> {
    let root = &packages.needed[folder];
    let path = root.workspace.join("Cargo.lock");
    if !path.exists() {
        return Err(wrong(
            &path,
            "there is no such file; write it with `cargo generate-lockfile`",
        ));
    }
    let lock = read_toml(&path)?;
    let all: Vec<&toml::Table> = lock
        .get("package")
        .and_then(toml::Value::as_array)
        .into_iter()
        .flatten()
        .filter_map(toml::Value::as_table)
        .collect();
    let mut waiting = vec![root.name.clone()];
    let mut seen = BTreeSet::new();
    let mut lines = BTreeSet::new();
    while let Some(wanted) = waiting.pop() {
        if !seen.insert(wanted.clone()) {
            continue;
        }
        let package = find(&all, &wanted).ok_or_else(|| {
            wrong(
                &path,
                format!("no package '{wanted}'; renew the file with `cargo metadata`"),
            )
        })?;
        let name = text(package, "name");
        lines.insert(format!(
            "{name} {} {} {}",
            text(package, "version"),
            text(package, "checksum"),
            // Of a git dependency: the commit.
            text(package, "source")
        ));
        // The lock file lists what tests need, too, of a package in a folder.
        let local = packages
            .needed
            .values()
            .find(|local| local.name == name && text(package, "source").is_empty());
        let below = package.get("dependencies").and_then(toml::Value::as_array);
        for entry in below.into_iter().flatten().filter_map(toml::Value::as_str) {
            let dependency = entry.split(' ').next().unwrap_or_default();
            if local.is_none_or(|local| local.needs.contains(dependency)) {
                waiting.push(entry.to_string());
            }
        }
    }
    Ok(lines.into_iter().collect())
}

/// Finds an entry: "name", "name version" or "name version (source)", as far as needed for
/// it to be the only one.
fn find<'a>(all: &[&'a toml::Table], entry: &str) -> Option<&'a toml::Table> {
    let mut parts = entry.split(' ');
    let name = parts.next()?;
    let version = parts.next();
    let source = parts.next().map(|part| part.trim_matches(['(', ')']));
    all.iter().copied().find(|package| {
        text(package, "name") == name
            && version.is_none_or(|version| text(package, "version") == version)
            && source.is_none_or(|source| text(package, "source") == source)
    })
}

fn text<'a>(package: &'a toml::Table, key: &str) -> &'a str {
    package
        .get(key)
        .and_then(toml::Value::as_str)
        .unwrap_or_default()
}
