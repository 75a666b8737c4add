//! `cargo relievo build`: runs the builder, which needs rust-gpu's nightly.

use crate::place::{ProjectArgument, checkout};
use anyhow::{Context, Result, bail};
use relievo_shader_manifest::{COMPONENTS, INSTALL, NIGHTLY, Project};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};

/// The variable with the folder for what cargo builds of the builder.
const BUILDER_TARGET: &str = "RELIEVO_BUILDER_TARGET";

#[derive(clap::Args)]
pub struct Arguments {
    #[command(flatten)]
    project: ProjectArgument,
    /// Write nothing, and fail if the modules are not what the sources give.
    #[arg(long)]
    check: bool,
}

pub fn run(arguments: &Arguments) -> Result<ExitCode> {
    let project = arguments.project.load()?;
    require_nightly()?;
    let builder_target = builder_target(&|name| std::env::var_os(name))?;
    if !is_built(&builder_target) {
        eprintln!("rust-gpu is compiled first, which takes about ten minutes, once");
    }
    replace(&mut builder(
        &project,
        &checkout()?,
        &builder_target,
        &target_folder(&project)?,
        arguments.check,
    ))
}

/// Returns whether the builder was compiled before.
fn is_built(builder_target: &Path) -> bool {
    let suffix = std::env::consts::EXE_SUFFIX;
    let program = format!("release/relievo-shader-builder{suffix}");
    builder_target.join(program).exists()
}

/// Returns the command that runs the builder.
fn builder(
    project: &Project,
    checkout: &Path,
    builder_target: &Path,
    target_folder: &Path,
    check: bool,
) -> Command {
    let mut command = Command::new("cargo");
    command
        .arg(format!("+{NIGHTLY}"))
        .args(["run", "--release", "--locked"])
        .args(is_built(builder_target).then_some("--quiet"))
        .arg("--manifest-path")
        .arg(checkout.join("shader-crate/builder/Cargo.toml"))
        .arg("--")
        .arg("--manifest-path")
        .arg(&project.manifest_path)
        .arg("--target-folder")
        .arg(target_folder)
        .args(check.then_some("--check"))
        .env("CARGO_TARGET_DIR", builder_target);
    command
}

/// Fails if rust-gpu's nightly is not installed.
fn require_nightly() -> Result<()> {
    let rustup = |arguments: &[&str]| {
        let mut command = Command::new("rustup");
        let output = command.args(arguments).stderr(Stdio::null()).output();
        output.context("cannot run rustup, which rust-gpu needs for its nightly: https://rustup.rs")
    };
    let installed = rustup(&["component", "list", "--installed", "--toolchain", NIGHTLY])?;
    let is_complete = if installed.status.success() {
        has_components(&String::from_utf8_lossy(&installed.stdout))
    } else {
        // A toolchain that rustup did not install itself has no list.
        rustup(&["run", NIGHTLY, "rustc", "--version"])?
            .status
            .success()
    };
    if !is_complete {
        bail!(
            "the shaders need {NIGHTLY} with {}: {INSTALL}",
            COMPONENTS.join(", ")
        );
    }
    Ok(())
}

/// Returns whether rustup's list of components has those that the builder needs.
fn has_components(list: &str) -> bool {
    let has = |component: &str| list.lines().any(|line| line.starts_with(component));
    COMPONENTS.into_iter().all(has)
}

/// Returns the folder for what cargo builds of the builder: the same for all projects.
fn builder_target(variable: &dyn Fn(&str) -> Option<OsString>) -> Result<PathBuf> {
    let folder = |name: &str| {
        variable(name)
            .filter(|value| !value.is_empty())
            .map(PathBuf::from)
    };
    if let Some(folder) = folder(BUILDER_TARGET) {
        return Ok(std::path::absolute(folder)?);
    }
    let cache = if cfg!(windows) {
        folder("LOCALAPPDATA")
    } else {
        // A relative path there is invalid by its specification.
        let cache = folder("XDG_CACHE_HOME").filter(|path| path.is_absolute());
        cache.or_else(|| folder("HOME").map(|home| home.join(".cache")))
    };
    let cache = cache.with_context(|| {
        format!("there is no folder for caches; name one for the builder in {BUILDER_TARGET}")
    })?;
    Ok(cache.join("relievo/builder"))
}

/// Returns the folder for what cargo builds of the shaders, one for each project: cargo names
/// what it builds of a shader crate by the crate only.
fn target_folder(project: &Project) -> Result<PathBuf> {
    let target = relievo_shader_manifest::target_folder(project)?;
    Ok(target.join("relievo"))
}

/// Runs a command in the place of this program, so that a signal stops both.
#[cfg(unix)]
fn replace(command: &mut Command) -> Result<ExitCode> {
    use std::os::unix::process::CommandExt;
    Err(command.exec()).context("cannot run cargo")
}

/// Runs a command. Ctrl-C reaches both programs.
#[cfg(not(unix))]
fn replace(command: &mut Command) -> Result<ExitCode> {
    Ok(crate::place::code(
        command.status().context("cannot run cargo")?,
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn target(variables: &[(&str, &str)]) -> Option<PathBuf> {
        let value = |name: &str| {
            let found = variables.iter().find(|(known, _)| *known == name);
            found.map(|(_, value)| OsString::from(value))
        };
        builder_target(&value).ok()
    }

    #[cfg(unix)]
    #[test]
    fn the_builder_is_kept_in_the_users_cache() {
        let home = ("HOME", "/home/me");
        let cache = ("XDG_CACHE_HOME", "/cache");
        let own = (BUILDER_TARGET, "/own");
        let is = |variables: &[_], expected: &str| {
            assert_eq!(target(variables).unwrap(), Path::new(expected));
        };
        is(&[home], "/home/me/.cache/relievo/builder");
        is(&[home, cache], "/cache/relievo/builder");
        is(
            &[home, ("XDG_CACHE_HOME", "relative")],
            "/home/me/.cache/relievo/builder",
        );
        is(&[home, cache, own], "/own");
        is(
            &[home, (BUILDER_TARGET, "")],
            "/home/me/.cache/relievo/builder",
        );
        assert_eq!(target(&[]), None);
    }

    #[test]
    fn the_builder_gets_the_project() {
        let checkout = checkout().unwrap();
        let project = Project::load(&checkout.join("Cargo.toml")).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let command = builder(&project, &checkout, folder.path(), Path::new("own"), true);
        let arguments: Vec<&str> = command.get_args().filter_map(|a| a.to_str()).collect();
        let split = arguments.iter().position(|a| *a == "--").unwrap();
        let (cargo, rest) = arguments.split_at(split);
        assert_eq!(cargo[0], "+nightly-2026-08-15");
        // Ten minutes without a word would be long.
        assert!(
            !cargo.contains(&"--quiet") && cargo.contains(&"--locked"),
            "{cargo:?}"
        );
        let path = project.manifest_path.to_str().unwrap();
        assert_eq!(
            rest[1..],
            ["--manifest-path", path, "--target-folder", "own", "--check"]
        );
    }

    #[test]
    fn all_components_are_needed() {
        let list = "cargo-x86_64-unknown-linux-gnu\nllvm-tools-x86_64-unknown-linux-gnu\nrust-src\nrustc-dev-x86_64-unknown-linux-gnu\n";
        assert!(has_components(list));
        for component in COMPONENTS {
            assert!(
                !has_components(&list.replace(component, "other")),
                "{component}"
            );
        }
        for component in COMPONENTS {
            assert!(INSTALL.contains(&format!("-c {component}")), "{component}");
        }
        assert!(INSTALL.contains(NIGHTLY));
    }

    #[test]
    fn the_nightly_is_that_of_the_builder() {
        let file = checkout()
            .unwrap()
            .join("shader-crate/builder/rust-toolchain.toml");
        let text = std::fs::read_to_string(file).unwrap();
        assert!(text.contains(&format!("\"{NIGHTLY}\"")), "{text}");
    }
}
