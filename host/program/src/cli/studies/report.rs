//! `relievo report`.

use super::bench::about_assets;
use crate::cli::progress::Bar;
use crate::cli::say;
use clap::Args;
use relievo::Error;
use relievo::file::write_bytes;
use relievo::render::gpu::{adapters, choose};
use relievo_studies::report::{Effort, report};
use std::path::PathBuf;

#[derive(Args)]
pub struct ReportArguments {
    /// Write report.md and report.json into this folder
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Use the adapter whose name contains this (see info)
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// Report on every adapter of this machine, each in up to five minutes
    #[arg(long, conflicts_with = "adapter")]
    all_adapters: bool,
    /// Folder with this project's meshes, patterns and scenes
    #[arg(long, value_name = "DIR", default_value = "assets")]
    assets: PathBuf,
}

/// `relievo report`.
pub fn run(arguments: &ReportArguments) -> anyhow::Result<()> {
    let wanted = match adapters() {
        all if arguments.all_adapters && !all.is_empty() => all,
        // Fails with a message that says what is missing.
        _ => vec![choose(arguments.adapter.as_deref()).map_err(Error::from)?],
    };
    let mut reports = Vec::new();
    {
        let bar = Bar::new();
        for adapter in wanted {
            let (name, effort) = (adapter.name(), Effort::of(&adapter));
            let progress = |what: String, done: f64| bar.show(format!("{name}: {what}"), done);
            let made = report(adapter, effort, &arguments.assets, &progress);
            reports.push(made.map_err(|error| about_assets(error, &arguments.assets))?);
        }
    }
    let mut page = "# What devices do with Relievo's shaders\n\nMade by `relievo report`; all \
         results are also in [report.json](report.json).\n"
        .to_string();
    for report in &reports {
        page += &format!("\n{report}");
    }
    let json = serde_json::to_string_pretty(&reports)?;
    for (name, content) in [("report.md", &page), ("report.json", &json)] {
        let path = arguments.output.join(name);
        write_bytes(&path, content.as_bytes()).map_err(Error::from)?;
        say(format_args!("{}", path.display()))?;
    }
    Ok(())
}
