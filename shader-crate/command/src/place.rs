//! Where the project and the checkout of Relievo are.

use anyhow::Result;
use relievo_shader_manifest::Project;
use std::path::PathBuf;
use std::process::ExitStatus;

/// The folder of the checkout that this program was built from, if it is still there.
pub fn checkout() -> Result<PathBuf> {
    let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    folder.canonicalize().map_err(|error| {
        anyhow::anyhow!(
            "{}: {error}; this program needs the checkout of Relievo that it was built from: install it again from where that is now",
            folder.display()
        )
    })
}

/// The project of an argument `--manifest-path`.
#[derive(Clone, Debug, clap::Args)]
pub struct ProjectArgument {
    /// The Cargo.toml with [package.metadata.relievo] or [workspace.metadata.relievo]; by
    /// default the first one here or above.
    #[arg(long, value_name = "PATH")]
    manifest_path: Option<PathBuf>,
}

impl ProjectArgument {
    /// Reads the project.
    pub fn load(&self) -> Result<Project> {
        Ok(match &self.manifest_path {
            Some(path) => Project::load(path)?,
            None => Project::find(&std::env::current_dir()?)?,
        })
    }
}

/// Returns the exit code of a program as one of this program.
pub fn code(status: ExitStatus) -> std::process::ExitCode {
    let code = status.code().and_then(|code| u8::try_from(code).ok());
    code.unwrap_or(1).into()
}
