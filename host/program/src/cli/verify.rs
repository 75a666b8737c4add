//! `relievo verify`.

use super::limits::LimitArguments;
use super::parse_size;
use super::progress::Bar;
use super::say;
use super::session::load;
use anyhow::bail;
use clap::{Args, ValueEnum};
use relievo::Error;
use relievo::prepare::PreparedScene;
use relievo::render::gpu::{Adapter, Choice, Shaders, adapters, choose, signature};
use relievo::render::{CpuRenderer, GpuRenderer, Renderer};
use relievo::verify::kernels::{KERNELS, record};
use relievo::verify::matrix::for_each_variant;
use relievo::verify::{AdapterReport, ModuleReport, Report, compare};
use relievo_bitwise::{Plan, Recorded, Runner, Signature, compare_kernel};
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

/// An adapter, the shaders to compare, and the results.
struct Tested {
    adapter: Adapter,
    shaders: Vec<Shaders>,
    report: AdapterReport,
}

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
                compare_pictures(scene, &format!("{name} ({variant})"), &mut tested, &bar)
            })?;
        } else {
            compare_pictures(&loaded.prepared, &name, &mut tested, &bar)?;
        }
    }
    if arguments.inputs > 0 {
        compare_kernels(arguments, &recorded, &mut tested, &bar)?;
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
    let mut tested = Vec::new();
    for adapter in wanted {
        let signature = if adapter.takes_spirv() {
            let device = adapter.open().map_err(Error::from)?;
            Some(signature(&device).map_err(Error::from)?)
        } else {
            None
        };
        let shaders = shaders(arguments.shaders, &adapter, signature.as_ref())?;
        let mut report = AdapterReport::new(&adapter, signature.as_ref());
        report.modules = shaders.iter().copied().map(ModuleReport::new).collect();
        tested.push(Tested {
            adapter,
            shaders,
            report,
        });
    }
    Ok(tested)
}

/// Compares the pictures of `scene` on every adapter with every module.
fn compare_pictures(
    scene: &PreparedScene,
    name: &str,
    tested: &mut [Tested],
    bar: &Bar,
) -> anyhow::Result<()> {
    let frame = &scene.frame;
    let mut cpu = CpuRenderer::new(scene);
    let cpu_color = cpu.color(frame).map_err(Error::from)?;
    let cpu_geometry = cpu.geometry(frame).map_err(Error::from)?;
    for Tested {
        adapter,
        shaders,
        report,
    } in tested
    {
        for (&shaders, module) in shaders.iter().zip(&mut report.modules) {
            bar.show(format!("{name}, {}", shaders.describe()), 0.0);
            let mut gpu =
                GpuRenderer::new(scene, adapter, Choice::These(shaders)).map_err(Error::from)?;
            let color = gpu.color(frame).map_err(Error::from)?;
            let geometry = gpu.geometry(frame).map_err(Error::from)?;
            let agreement = compare([&color, &cpu_color], [&geometry, &cpu_geometry]);
            module.add_picture(name.to_string(), &agreement);
        }
    }
    Ok(())
}

/// Compares each requested function on every adapter with every module.
fn compare_kernels(
    arguments: &VerifyArguments,
    recorded: &Recorded,
    tested: &mut [Tested],
    bar: &Bar,
) -> anyhow::Result<()> {
    let inputs = arguments.inputs;
    let plan = Plan {
        inputs,
        seed: SEED,
        recorded,
    };
    for Tested {
        adapter,
        shaders,
        report,
    } in tested
    {
        let device = adapter.open().map_err(Error::from)?;
        for (&shaders, module) in shaders.iter().zip(&mut report.modules) {
            let kernels = shaders.kernels().map_err(Error::from)?;
            let mut runner = Runner::new(&device, &kernels).map_err(Error::from)?;
            for kernel in KERNELS {
                if !kernel.name.contains(&arguments.functions) {
                    continue;
                }
                let progress = |done: u64| {
                    bar.show(
                        format!("{}, {}", kernel.name, shaders.describe()),
                        done as f64 / inputs as f64,
                    );
                };
                let tally =
                    compare_kernel(&mut runner, kernel, &plan, &progress).map_err(Error::from)?;
                module.add_kernel(kernel.name, &tally);
            }
        }
    }
    Ok(())
}

/// Returns the shaders to compare: the requested ones, or all that the adapter supports.
fn shaders(
    choice: ShaderChoice,
    adapter: &Adapter,
    signature: Option<&Signature>,
) -> anyhow::Result<Vec<Shaders>> {
    let wanted = match choice {
        ShaderChoice::All => Shaders::ALL.to_vec(),
        ShaderChoice::Exact => vec![Shaders::Exact, Shaders::Fused],
        ShaderChoice::Fast => vec![Shaders::Fast],
        ShaderChoice::Portable => vec![Shaders::Portable],
    };
    let fuses = signature.is_some_and(|signature| Shaders::Fused.suit(signature));
    let possible: Vec<Shaders> = wanted
        .into_iter()
        .filter(|shaders| adapter.takes_spirv() || !shaders.is_untouched())
        .filter(|&shaders| shaders != Shaders::Fused || fuses)
        .collect();
    if possible.is_empty() {
        bail!(
            "{} does not take SPIR-V untouched, which these shaders need; use --shaders portable",
            adapter.describe()
        );
    }
    Ok(possible)
}
