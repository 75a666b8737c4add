//! `cargo relievo check`: are the modules those of the sources, and do the tests pass?

use crate::place::{ProjectArgument, code};
use anyhow::{Context, Result};
use relievo_shader_manifest::{Project, changes};
use std::ffi::OsString;
use std::process::{Command, ExitCode};

/// The variable that makes tests without a graphics adapter fail.
const ADAPTER: &str = "RELIEVO_ADAPTER";

#[derive(clap::Args)]
pub struct Arguments {
    #[command(flatten)]
    project: ProjectArgument,
    /// Leave out what needs a graphics adapter if there is none. By default its tests fail.
    #[arg(long)]
    without_adapter: bool,
    /// Arguments for `cargo test`.
    #[arg(last = true, value_name = "ARGUMENTS")]
    rest: Vec<OsString>,
}

pub fn run(arguments: &Arguments) -> Result<ExitCode> {
    let project = arguments.project.load()?;
    let changes = changes(&project)?;
    if !changes.is_empty() {
        eprintln!("{}", changes.join("\n"));
        anyhow::bail!(
            "the compiled shaders are out of date; build them with `cargo relievo build`"
        );
    }
    println!("the compiled shaders are those of the sources");
    let status = tests(&project, arguments)
        .status()
        .context("cannot run cargo")?;
    Ok(code(status))
}

/// Returns the command that runs the project's tests.
fn tests(project: &Project, arguments: &Arguments) -> Command {
    // The cargo that has called this program.
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    command
        .args(["test", "--manifest-path"])
        .arg(&project.manifest_path)
        .args(&arguments.rest);
    if arguments.without_adapter {
        command.env_remove(ADAPTER);
    } else {
        command.env(ADAPTER, "required");
    }
    command
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        arguments: Arguments,
    }

    /// Returns the arguments of cargo, but for the project, and what the adapter's variable
    /// is set to.
    fn command(line: &[&str]) -> (Vec<String>, Option<Option<String>>) {
        let line = Line::parse_from([&["check"], line].concat());
        let folder = crate::place::checkout().unwrap();
        let project = Project::load(&folder.join("Cargo.toml")).unwrap();
        let command = super::tests(&project, &line.arguments);
        let text = |text: &std::ffi::OsStr| text.to_string_lossy().into_owned();
        let variable = command.get_envs().find(|(name, _)| *name == ADAPTER);
        (
            command
                .get_args()
                .map(text)
                .filter(|a| !a.contains("Cargo.toml"))
                .collect(),
            variable.map(|(_, value)| value.map(text)),
        )
    }

    #[test]
    fn tests_get_the_rest_of_the_arguments_and_need_an_adapter() {
        let (arguments, adapter) = command(&["--", "--release", "one", "--", "--nocapture"]);
        assert_eq!(
            arguments,
            [
                "test",
                "--manifest-path",
                "--release",
                "one",
                "--",
                "--nocapture"
            ]
        );
        assert_eq!(adapter, Some(Some("required".to_string())));
        let (arguments, adapter) = command(&["--without-adapter"]);
        assert_eq!(arguments, ["test", "--manifest-path"]);
        assert_eq!(adapter, Some(None));
    }
}
