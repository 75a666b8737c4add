//! `relievo verify`.

use super::limits::LimitArguments;
use super::parse_size;
use super::progress::Bar;
use super::say;
use super::session::load;
use anyhow::bail;
use clap::{Args, ValueEnum};
use relievo::Error;
use relievo::render::gpu::{Shaders, adapters, choose};
use relievo::verify::kernels::{KERNELS, record};
use relievo::verify::matrix::for_each_variant;
use relievo::verify::{Report, Tested};
use relievo_bitwise::{Plan, Recorded};
use std::path::PathBuf;

/// Compiled shaders.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ShaderChoice {
    /// All that the adapter supports
    All,
    /// Those that match the CPU bit for bit
    Exact,
    /// Those with all optimizations
    Fast,
    /// The fast ones, translated by naga
    Portable,
}

#[derive(Args)]
pub struct VerifyArguments {
    /// Scenes to compare pictures of
    scenes: Vec<PathBuf>,
    /// Use the adapter whose name contains this (see info)
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// Use every adapter of this machine
    #[arg(long, conflicts_with = "adapter")]
    all_adapters: bool,
    /// Compare each scene in every tier with every technique
    #[arg(long)]
    matrix: bool,
    /// Number of inputs for each function of the shared mathematics
    #[arg(long, value_name = "N", default_value_t = 65_536)]
    inputs: u64,
    /// Compare only the functions whose names contain this
    #[arg(
        long,
        value_name = "PART",
        default_value = "",
        hide_default_value = true
    )]
    functions: String,
    /// Print the report as JSON
    #[arg(long)]
    json: bool,
    /// Size of the pictures instead of the scenes'
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    size: Option<[u32; 2]>,
    /// Shaders to compare; a difference in the exact ones is an error (exit code 1)
    #[arg(long, value_enum, default_value_t = ShaderChoice::All)]
    shaders: ShaderChoice,
    #[command(flatten)]
    limits: LimitArguments,
}

/// Seed of the kernels' inputs.
const SEED: u64 = 1;

pub fn run(arguments: &VerifyArguments) -> anyhow::Result<()> {
    if arguments.scenes.is_empty() && arguments.inputs == 0 {
        bail!("nothing to compare; name a scene, or ask for functions with --inputs N");
    }
    let names: Vec<&str> = KERNELS.iter().map(|kernel| kernel.name).collect();
    if !names.iter().any(|name| name.contains(&arguments.functions)) {
        bail!(
            "--functions {}: no such function; there are {}",
            arguments.functions,
            names.join(", ")
        );
    }
    let bar = Bar::new();
    let mut tested = tested(arguments)?;
    let mut recorded = Recorded::new();
    for path in &arguments.scenes {
        let mut loaded = load(path, arguments.size, &arguments.limits.limits())?;
        record(&loaded.prepared, &mut recorded).map_err(Error::from)?;
        let name = path.display().to_string();
        if arguments.matrix {
            for_each_variant(&mut loaded.prepared, |scene, variant| {
                let name = format!("{name} ({variant})");
                Tested::pictures(&mut tested, scene, &name, &|what| bar.show(what, 0.0))
            })
            .map_err(Error::from)?;
        } else {
            Tested::pictures(&mut tested, &loaded.prepared, &name, &|what| {
                bar.show(what, 0.0);
            })
            .map_err(Error::from)?;
        }
    }
    if arguments.inputs > 0 {
        let plan = Plan {
            inputs: arguments.inputs,
            seed: SEED,
            recorded: &recorded,
        };
        for tested in &mut tested {
            tested
                .functions(&arguments.functions, &plan, &|what, done| {
                    bar.show(what, done)
                })
                .map_err(Error::from)?;
        }
    }
    drop(bar);

    let report = Report {
        adapters: tested.into_iter().map(|tested| tested.report).collect(),
    };
    if arguments.json {
        say(format_args!("{}", serde_json::to_string_pretty(&report)?))?;
    } else {
        say(format_args!("{}", report.to_string().trim_end()))?;
    }
    let broken = report.broken();
    if !broken.is_empty() {
        bail!(
            "the exact shaders differ from the CPU on {}",
            broken.join(", ")
        );
    }
    Ok(())
}

/// Returns the requested adapters with their signatures.
fn tested(arguments: &VerifyArguments) -> anyhow::Result<Vec<Tested>> {
    let wanted = if arguments.all_adapters {
        let all = adapters();
        if all.is_empty() {
            // Fails with a message that says what is missing.
            choose(None).map_err(Error::from)?;
        }
        all
    } else {
        vec![choose(arguments.adapter.as_deref()).map_err(Error::from)?]
    };
    let shaders = match arguments.shaders {
        ShaderChoice::All => Shaders::ALL.to_vec(),
        ShaderChoice::Exact => vec![Shaders::Exact, Shaders::Fused],
        ShaderChoice::Fast => vec![Shaders::Fast],
        ShaderChoice::Portable => vec![Shaders::Portable],
    };
    let mut all = Vec::new();
    for adapter in wanted {
        let tested = Tested::new(adapter, &shaders).map_err(Error::from)?;
        if tested.shaders.is_empty() {
            bail!(
                "{} does not take SPIR-V untouched, which these shaders need; use --shaders portable",
                tested.adapter.describe()
            );
        }
        all.push(tested);
    }
    Ok(all)
}
