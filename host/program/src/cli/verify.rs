//! `relievo verify`.

use super::job::{Estimate, Part, Piece, Place, PlanArguments, Work};
use super::limits::LimitArguments;
use super::parse_size;
use super::progress::Bar;
use super::say;
use super::session::{Loaded, inputs, load};
use anyhow::bail;
use clap::{Args, ValueEnum};
use relievo::Error;
use relievo::prepare::PreparedScene;
use relievo::render::RenderError;
use relievo::render::gpu::{Shaders, adapters, choose};
use relievo::scene::Scene;
use relievo::verify::kernels::{KERNELS, record};
use relievo::verify::matrix::for_each_variant;
use relievo::verify::{Report, Tested};
use relievo_bitwise::{Plan, Recorded};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Instant;

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

#[derive(Args, Clone)]
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
    pub(super) plan: PlanArguments,
    #[command(flatten)]
    limits: LimitArguments,
}

/// Seed of the kernels' inputs.
const SEED: u64 = 1;

/// `relievo verify`: its units are the scenes, and then the functions.
pub struct Verification {
    arguments: VerifyArguments,
    /// Names of the functions to compare.
    functions: Vec<&'static str>,
}

impl Verification {
    /// Checks the arguments.
    pub fn new(arguments: VerifyArguments) -> anyhow::Result<Verification> {
        if arguments.scenes.is_empty() && arguments.inputs == 0 {
            bail!("nothing to compare; name a scene, or ask for functions with --inputs N");
        }
        let names = KERNELS.iter().map(|kernel| kernel.name);
        let wanted = names
            .clone()
            .filter(|name| name.contains(&arguments.functions));
        let functions: Vec<&str> = wanted.collect();
        if functions.is_empty() {
            bail!(
                "--functions {}: no such function; there are {}",
                arguments.functions,
                names.collect::<Vec<_>>().join(", ")
            );
        }
        Ok(Verification {
            functions: if arguments.inputs > 0 {
                functions
            } else {
                Vec::new()
            },
            arguments,
        })
    }

    fn load(&self, path: &Path) -> Result<Loaded, Error> {
        let VerifyArguments { size, limits, .. } = &self.arguments;
        load(path, *size, &limits.limits())
    }

    /// Compares the units of `range`, with `inputs` for each function.
    fn compare(&self, range: Range<usize>, inputs: u64) -> anyhow::Result<Report> {
        let VerifyArguments { scenes, matrix, .. } = &self.arguments;
        let bar = Bar::new();
        let mut tested = tested(&self.arguments)?;
        let mut recorded = Recorded::new();
        let has_functions = range.end > scenes.len();
        for (index, path) in scenes.iter().enumerate() {
            let is_own = range.contains(&index);
            if !is_own && !has_functions {
                continue;
            }
            let mut loaded = self.load(path)?;
            record(&loaded.prepared, &mut recorded).map_err(Error::from)?;
            if !is_own {
                continue;
            }
            let name = path.display().to_string();
            if *matrix {
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
        let plan = Plan {
            inputs,
            seed: SEED,
            recorded: &recorded,
        };
        let own = |index: usize| index.saturating_sub(scenes.len());
        let functions = &self.functions[own(range.start)..own(range.end)];
        for tested in tested.iter_mut().filter(|_| !functions.is_empty()) {
            tested
                .functions(functions, &plan, &|what, done| bar.show(what, done))
                .map_err(Error::from)?;
        }
        Ok(Report {
            adapters: tested.into_iter().map(|tested| tested.report).collect(),
        })
    }
}

/// Number of inputs that the time of a function is estimated from.
const TRIAL_INPUTS: u64 = 4096;

impl Work for Verification {
    fn unit(&self) -> &'static str {
        "comparison"
    }

    fn count(&self) -> usize {
        self.arguments.scenes.len() + self.functions.len()
    }

    fn inputs(&self) -> anyhow::Result<Vec<PathBuf>> {
        let mut all = Vec::new();
        for path in &self.arguments.scenes {
            let scene = Scene::load_within(path, &self.arguments.limits.limits());
            all.extend(inputs(&scene.map_err(Error::from)?));
        }
        Ok(all)
    }

    fn estimate(&self) -> anyhow::Result<Estimate> {
        fn seconds<T>(work: impl FnOnce() -> anyhow::Result<T>) -> anyhow::Result<f64> {
            let start = Instant::now();
            work()?;
            Ok(start.elapsed().as_secs_f64())
        }
        let scenes = self.arguments.scenes.len();
        let mut units = Vec::new();
        if let Some(first) = self.arguments.scenes.first() {
            // A picture of the first scene; there are as many of the others.
            let one = Verification {
                arguments: VerifyArguments {
                    matrix: false,
                    ..self.arguments.clone()
                },
                functions: Vec::new(),
            };
            let picture = seconds(|| one.compare(0..1, 0))?;
            let mut pictures = 1;
            if self.arguments.matrix {
                pictures = 0;
                let mut count = |_: &PreparedScene, _: &str| -> Result<(), RenderError> {
                    pictures += 1;
                    Ok(())
                };
                let mut loaded = self.load(first)?;
                for_each_variant(&mut loaded.prepared, &mut count).map_err(Error::from)?;
            }
            for path in &self.arguments.scenes {
                let load = seconds(|| Ok(self.load(path)?))?;
                units.push(load + f64::from(pictures) * picture);
            }
        }
        let trial = TRIAL_INPUTS.min(self.arguments.inputs);
        let mut setup = 0.0;
        if !self.functions.is_empty() {
            // A function with hardly any input is nothing but setting up.
            setup = seconds(|| self.compare(scenes..scenes + 1, 1))?;
            let all = seconds(|| self.compare(scenes..self.count(), trial))? - setup;
            let times = self.arguments.inputs as f64 / trial.max(1) as f64;
            let each = (all * times).max(0.0) / self.functions.len() as f64;
            units.extend(vec![each; self.functions.len()]);
        }
        Ok(Estimate {
            setup,
            units,
            ..Estimate::default()
        })
    }

    fn work(&self, piece: &Piece, _: Option<&Place<'_>>) -> anyhow::Result<Part> {
        let report = self.compare(piece.units(), self.arguments.inputs)?;
        Ok(Part {
            result: serde_json::to_value(report)?,
            ..Part::default()
        })
    }

    fn merge(&self, parts: Vec<Part>) -> anyhow::Result<()> {
        let mut report = Report::default();
        for (part, number) in parts.into_iter().zip(1..) {
            let of_part: Report = serde_json::from_value(part.result)?;
            report.join(of_part).map_err(|problem| {
                anyhow::anyhow!("piece {number} {problem}; plan with --adapter, and send all pieces to such machines")
            })?;
        }
        if self.arguments.json {
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
