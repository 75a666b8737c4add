//! The command `cargo relievo`: builds, checks and exports the shaders of a project.

mod build;
mod check;
mod export;
mod new;
mod place;

use clap::{Parser, Subcommand};
use std::process::ExitCode;

/// What cargo calls: `cargo-relievo relievo …`.
#[derive(Parser)]
#[command(name = "cargo", bin_name = "cargo")]
enum Cargo {
    Relievo(Relievo),
}

/// Shaders in Rust, with the same bits on GPU and CPU.
#[derive(clap::Args)]
#[command(version)]
struct Relievo {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Compile the shaders with rust-gpu, and write the modules and their manifest.
    Build(build::Arguments),
    /// Check that the modules are those of the sources, then run the project's tests.
    Check(check::Arguments),
    /// Translate the fast modules to other shading languages.
    Export(export::Arguments),
    /// Make a project with a shader and its test.
    New(new::Arguments),
}

fn main() -> ExitCode {
    let Cargo::Relievo(arguments) = Cargo::parse();
    let result = match arguments.command {
        Command::Build(arguments) => build::run(&arguments),
        Command::Check(arguments) => check::run(&arguments),
        Command::Export(arguments) => export::run(&arguments),
        Command::New(arguments) => new::run(&arguments),
    };
    match result {
        Ok(code) => code,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}
