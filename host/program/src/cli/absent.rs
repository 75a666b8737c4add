//! Commands of a feature that this build lacks.

use super::Arguments;
use clap::error::ErrorKind;
use clap::{Args, CommandFactory};
use std::ffi::OsString;

/// Accepts any arguments of a missing command.
#[derive(Args)]
#[command(disable_help_flag = true)]
pub struct Absent {
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
    arguments: Vec<OsString>,
}

impl Absent {
    /// Exits with an error that names the command line which builds `command`.
    pub fn refuse(&self, command: &str, feature: &str) -> ! {
        let arguments: Vec<_> = self.arguments.iter().map(|a| a.to_string_lossy()).collect();
        let message = format!(
            "this build leaves out `{command}`; with it: cargo run --release --features {feature} -- {command} {}",
            arguments.join(" ")
        );
        Arguments::command()
            .error(ErrorKind::InvalidSubcommand, message.trim_end())
            .exit();
    }
}
