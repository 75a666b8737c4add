//! What packages get from the `Cargo.toml` of their workspace.

use crate::error::ManifestError;
use crate::files::{canonical, read_toml};
use crate::packages::Package;
use std::path::Path;

/// Returns what a package inherits that decides its code: its edition and dependencies.
/// Empty if it inherits nothing.
pub fn inherited(package: &Package) -> Result<String, ManifestError> {
    let own = read_toml(&package.folder.join("Cargo.toml"))?;
    let root = read_toml(&package.workspace.join("Cargo.toml"))?;
    let workspace = root.get("workspace");
    let mut lines = Vec::new();

    if own
        .get("package")
        .and_then(|own| own.get("edition"))
        .is_some_and(is_inherited)
    {
        let package = workspace.and_then(|workspace| workspace.get("package"));
        let edition = package.and_then(|package| package.get("edition"));
        lines.push(format!("edition {}", shown(edition)));
    }
    let dependencies = workspace.and_then(|workspace| workspace.get("dependencies"));
    let targets = own.get("target").and_then(toml::Value::as_table);
    let targets = targets
        .into_iter()
        .flatten()
        .filter_map(|(_, target)| target.as_table());
    for table in std::iter::once(&own).chain(targets) {
        for kind in ["dependencies", "build-dependencies"] {
            let named = table.get(kind).and_then(toml::Value::as_table);
            for (name, value) in named.into_iter().flatten() {
                if is_inherited(value) {
                    let inherited = dependencies.and_then(|all| all.get(name));
                    lines.push(format!("{name} {}", shown(inherited)));
                }
            }
        }
    }
    lines.sort();
    lines.dedup();
    Ok(lines.join("\n"))
}

/// Returns the parts of the `Cargo.toml` of a workspace that decide how its packages are
/// compiled.
pub fn of_workspace(root: &Path) -> Result<String, ManifestError> {
    let manifest = read_toml(&root.join("Cargo.toml"))?;
    let release = manifest.get("profile").and_then(|all| all.get("release"));
    let resolver = ["workspace", "package"]
        .into_iter()
        .find_map(|part| manifest.get(part)?.get("resolver"));
    Ok(format!(
        "profile {}\nresolver {}\npatch {}",
        shown(release),
        shown(resolver),
        shown(manifest.get("patch"))
    ))
}

fn is_inherited(value: &toml::Value) -> bool {
    value.get("workspace").and_then(toml::Value::as_bool) == Some(true)
}

fn shown(value: Option<&toml::Value>) -> String {
    value.map_or_else(|| "none".to_string(), canonical)
}
