//! What the user types, what the program says, and with which exit code.

mod accuracy;
mod bake;
mod bench;
mod bounds;
mod budget;
mod explain;
mod export;
mod gallery;
mod info;
mod interrupt;
mod limits;
mod progress;
mod render;
mod session;
mod tradeoff;
mod verify;
mod view;

use anyhow::Context;
use clap::error::ErrorKind;
use clap::{Args, CommandFactory, Parser, Subcommand, ValueEnum};
use limits::{LimitArguments, PixelArguments};
use relievo::shape_map::{LARGEST_RASTER, Lettering, SMALLEST_RASTER};
use relievo::tradeoff::Shard;
use std::fmt;
use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;
use tracing::Level;

/// Carve patterns into meshes, outline included, without one extra triangle.
#[derive(Parser)]
#[command(
    name = "relievo",
    version,
    after_help = "Exit codes: 0 done, 1 the input is at fault, 2 wrong usage, 3 the machine (no adapter, out of memory, disk full)."
)]
pub struct Arguments {
    #[command(subcommand)]
    command: Command,
    /// Say more: -v what is done, -vv with details
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    verbose: u8,
}

#[derive(Subcommand)]
enum Command {
    /// Draw a scene
    Render(RenderArguments),
    /// Open a window on a scene: turn it, and change every parameter under a slider
    View(ViewArguments),
    /// Turn a pattern into a shape map (its distances, in a file) that scenes can use
    Bake(BakeArguments),
    /// Show what a scene loads, and the adapters of this machine
    Info(InfoArguments),
    /// Say what scenes need of the model and what not, with instructions and bytes
    Explain(ExplainArguments),
    /// Compare the GPU's words with the CPU's: functions one by one, and pictures of scenes
    Verify(VerifyArguments),
    /// Say how far the pictures of scenes are from the truth: holes, extra pixels, distances
    Accuracy(AccuracyArguments),
    /// Measure by how much each function of the mathematics, in f32, is wrong, as tables
    Bounds(BoundsArguments),
    /// Measure how long frames take
    #[command(subcommand)]
    Bench(BenchCommand),
    /// Draw a scene in many variants, and say what each choice costs and what it buys
    Tradeoff(TradeoffArguments),
    /// Draw the paper's figures, with the paper's algorithms beside ours, as a page
    Gallery(GalleryArguments),
    /// Write an object's shaders in other languages, and what they read, for another program
    Export(ExportArguments),
}

/// Which renderer to use.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Backend {
    /// A GPU if there is one, else the CPU
    Auto,
    /// A GPU, or a software driver if there is nothing else
    Gpu,
    /// The CPU
    Cpu,
}

/// Which compiled shaders to use.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ShaderChoice {
    /// All that the adapter takes
    All,
    /// Those that give the CPU's words
    Exact,
    /// Those that are optimised freely
    Fast,
    /// The latter, through naga
    Portable,
}

#[derive(Args)]
struct RenderArguments {
    /// The scene, a TOML file
    scene: PathBuf,
    /// The picture [default: the scene's name with .png, in this folder]
    #[arg(short, long, value_name = "OUT.png")]
    output: Option<PathBuf>,
    /// What renders
    #[arg(long, value_enum, default_value_t = Backend::Auto)]
    backend: Backend,
    /// Take the adapter with this in its name (see info)
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// Size of the picture, in place of the scene's
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    size: Option<[u32; 2]>,
    /// Write what was hit as well: t, u, v, delta, class, N
    #[arg(long, value_name = "OUT.exr")]
    aov: Option<PathBuf>,
    /// How wrong the picture may be, such as 0.5px, in place of tier, steps and map: the
    /// cheapest way to be no worse is looked for
    #[arg(long, value_name = "PX", value_parser = parse_budget)]
    budget: Option<f64>,
    #[command(flatten)]
    limits: LimitArguments,
}

#[derive(Args)]
struct ViewArguments {
    /// The scene, a TOML file
    scene: PathBuf,
    /// The folder for pictures and scenes that are saved [default: the scene's]
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Take the adapter with this in its name (see info)
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// Size of the window, points
    #[arg(long, value_name = "WxH", value_parser = parse_size, default_value = "1200x760")]
    window: [u32; 2],
    /// Keep telling this file, as JSON, what is on the window: for tests
    #[arg(long, value_name = "FILE.json", hide = true)]
    probe: Option<PathBuf>,
    #[command(flatten)]
    limits: LimitArguments,
}

/// How a baked texel is stored.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// 8-bit signed distances (PNG)
    R8,
    /// 16-bit signed distances (PNG)
    R16,
    /// 32-bit floating-point signed distances (OpenEXR)
    R32f,
    /// The paper's shape map: normal, distance and shape, 8 bits each (PNG)
    Rgba8,
}

#[derive(Args)]
struct BakeArguments {
    /// The pattern: an image or an SVG drawing, of which what is dark is extruded
    #[arg(required_unless_present = "text", conflicts_with = "text")]
    pattern: Option<PathBuf>,
    /// The pattern: these letters
    #[arg(long)]
    text: Option<String>,
    /// The font of --text, a .ttf or .otf file [default: one that is built in]
    #[arg(long, value_name = "FILE", conflicts_with = "pattern")]
    font: Option<PathBuf>,
    /// What is left free around --text, in line heights
    #[arg(long, value_name = "F", conflicts_with = "pattern", default_value_t = Lettering::DEFAULT_MARGIN, value_parser = parse_margin)]
    margin: f64,
    /// Pixels of the longer side, for an SVG drawing or --text [default: 512]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(i64::from(SMALLEST_RASTER)..=i64::from(LARGEST_RASTER)))]
    raster: Option<u32>,
    /// The shape map: a .png file, or .exr for r32f
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// How distances are stored
    #[arg(long, value_enum, default_value_t = Format::R16)]
    format: Format,
    /// Short for --format r8 or r16
    #[arg(long, value_parser = ["8", "16"], conflicts_with = "format")]
    bits: Option<String>,
    /// rgba8 only: the share of the largest distance (above 0, up to 1) that
    /// the 8 bits cover; farther ones saturate [default: 1]
    #[arg(long, value_name = "F")]
    scale: Option<f32>,
    /// A pixel is pattern where its luma is below this
    #[arg(long, default_value_t = 128, value_parser = clap::value_parser!(u8).range(1..))]
    threshold: u8,
    /// Extrude the light pixels
    #[arg(long)]
    invert: bool,
    #[command(flatten)]
    pixels: PixelArguments,
}

#[derive(Args)]
struct InfoArguments {
    /// The scene; without it only the adapters are shown
    scene: Option<PathBuf>,
    #[command(flatten)]
    limits: LimitArguments,
}

#[derive(Args)]
struct ExplainArguments {
    /// The scenes
    #[arg(required = true)]
    scenes: Vec<PathBuf>,
    /// How wrong the picture may be, such as 0.5px, in place of tier, steps and map
    #[arg(long, value_name = "PX", value_parser = parse_budget)]
    budget: Option<f64>,
    /// Size of the picture, in place of the scene's
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    size: Option<[u32; 2]>,
    #[command(flatten)]
    limits: LimitArguments,
}

#[derive(Args)]
struct VerifyArguments {
    /// The scenes whose pictures are compared
    scenes: Vec<PathBuf>,
    /// Take the adapter with this in its name (see info)
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// Take every adapter of this machine
    #[arg(long, conflicts_with = "adapter")]
    all_adapters: bool,
    /// Compare each scene in every tier with every technique
    #[arg(long)]
    matrix: bool,
    /// Compare each function of the shared mathematics on this many inputs
    #[arg(long, value_name = "N", default_value_t = 65_536)]
    inputs: u64,
    /// Print the report as JSON
    #[arg(long)]
    json: bool,
    /// Size of the pictures, in place of the scenes'
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    size: Option<[u32; 2]>,
    /// Which shaders to compare; differences of the exact ones are an error (exit code 1)
    #[arg(long, value_enum, default_value_t = ShaderChoice::All)]
    shaders: ShaderChoice,
    #[command(flatten)]
    limits: LimitArguments,
}

/// What knows the truth.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Against {
    /// The closed form of the surface that the mesh approximates
    Analytic,
    /// The mesh itself as curved prisms, in double precision
    Mesh,
}

#[derive(Args)]
struct AccuracyArguments {
    /// The scenes
    #[arg(required = true)]
    scenes: Vec<PathBuf>,
    /// What knows the truth
    #[arg(long, value_enum, default_value_t = Against::Analytic)]
    against: Against,
    /// Write accuracy.json, and for each scene a picture of its errors, into this folder:
    /// holes red, inside the outline purple, extra pixels blue, another kind of surface yellow
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Size of the pictures, in place of the scenes'
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    size: Option<[u32; 2]>,
    /// What renders
    #[arg(long, value_enum, default_value_t = Backend::Auto)]
    backend: Backend,
    #[command(flatten)]
    limits: LimitArguments,
}

#[derive(Subcommand)]
enum BenchCommand {
    /// Time one frame of scenes on CPU and GPU, in turn
    Scene(BenchSceneArguments),
    /// Time the exact shaders beside the fast ones, in every tier, in turn
    Exactness(BenchSceneArguments),
    /// Time the shaders that hold what a scene needs beside those that hold everything, in turn
    Specialization(BenchSceneArguments),
    /// Measure how budgets are kept on random scenes, and what that costs
    Budget(BenchBudgetArguments),
    /// Measure the paper's Table 1: extrusion against relief mapping, planar and curved
    Table1(BenchTable1Arguments),
}

#[derive(Args)]
struct BenchSceneArguments {
    /// The scenes
    #[arg(required = true)]
    scenes: Vec<PathBuf>,
    /// Take the adapter with this in its name (see info)
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// Size of the picture, in place of the scene's
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    size: Option<[u32; 2]>,
    /// Frames timed with each renderer, after one to warm up
    #[arg(long, default_value_t = 9, value_parser = clap::value_parser!(u32).range(1..100_000))]
    frames: u32,
    #[command(flatten)]
    limits: LimitArguments,
}

/// What the table is measured on.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Measured {
    /// A GPU, or a software driver if there is nothing else
    Gpu,
    /// The CPU
    Cpu,
    /// The CPU, and a GPU if there is one
    Both,
}

#[derive(Args)]
struct BenchBudgetArguments {
    /// Random scenes
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u64).range(1..1_000_000))]
    scenes: u64,
    /// Which series of random scenes; the model is fitted to series 1
    #[arg(long, value_name = "K", default_value_t = 2)]
    series: u64,
    /// Size of the pictures
    #[arg(long, value_name = "WxH", default_value = "200x150", value_parser = parse_size)]
    size: [u32; 2],
    /// Print the model that fits these scenes, in place of the rest
    #[arg(long)]
    fit: bool,
    /// Time every plan beside a sweep of variants as well
    #[arg(long, conflicts_with = "fit")]
    cost: bool,
    /// Frames timed of each variant, after one to warm up
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..100_000))]
    frames: u32,
    /// What is timed
    #[arg(long, value_enum, default_value_t = Measured::Both)]
    backend: Measured,
    /// Take the adapter with this in its name (see info)
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// The folder with this project's meshes and patterns
    #[arg(long, value_name = "DIR", default_value = "assets")]
    assets: PathBuf,
}

#[derive(Args)]
struct BenchTable1Arguments {
    /// Write table1.csv, table1.svg and table1.md into this folder
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Frames timed of each method on each shape map, after one to warm up
    #[arg(long, default_value_t = 15, value_parser = clap::value_parser!(u32).range(1..100_000))]
    frames: u32,
    /// What is measured
    #[arg(long, value_enum, default_value_t = Measured::Both)]
    backend: Measured,
    /// Take the adapter with this in its name (see info)
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// Size of the pictures
    #[arg(long, value_name = "WxH", default_value = "800x600", value_parser = parse_size)]
    size: [u32; 2],
    /// The folder with this project's meshes and patterns
    #[arg(long, value_name = "DIR", default_value = "assets")]
    assets: PathBuf,
}

#[derive(Args)]
struct BoundsArguments {
    /// Write the tables to this file, as Markdown [default: to standard output]
    #[arg(short, long, value_name = "OUT.md")]
    output: Option<PathBuf>,
    /// Inputs for each row of a table
    #[arg(long, value_name = "N", default_value_t = 20_000, value_parser = clap::value_parser!(u32).range(1..=100_000_000))]
    inputs: u32,
}

#[derive(Args)]
#[command(
    after_help = "Each variant is on the disk as soon as it is measured: the same command goes on after an interruption.\nOn several machines: --shard 1/8 … --shard 8/8 with one folder, then --merge."
)]
struct TradeoffArguments {
    /// The scene
    scene: PathBuf,
    /// Write measurements, tradeoff.csv, pareto.svg, pareto.png and tradeoff.md into this
    /// folder
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Measure a dozen settings in place of all
    #[arg(long)]
    quick: bool,
    /// Frames timed of each variant, in turn with one reference, after one to warm up; up to
    /// four times as many where times vary
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..100_000))]
    frames: u32,
    /// What is measured
    #[arg(long, value_enum, default_value_t = Measured::Both)]
    backend: Measured,
    /// Take the adapter with this in its name (see info)
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// Size of the pictures, in place of the scene's
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    size: Option<[u32; 2]>,
    /// Measure this part of the variants only, such as 2/8, and write no report
    #[arg(long, value_name = "I/N", value_parser = tradeoff::parse_shard)]
    shard: Option<Shard>,
    /// Measure nothing, join the parts that are in the folder, and write the report
    #[arg(long, conflicts_with_all = ["shard", "restart", "quick", "frames", "backend", "adapter", "size"])]
    merge: bool,
    /// Forget what the folder holds of this shard, and of sweeps in another number of shards,
    /// and measure anew
    #[arg(long)]
    restart: bool,
    #[command(flatten)]
    limits: LimitArguments,
}

#[derive(Args)]
struct GalleryArguments {
    /// Write index.html, index.md, pictures and scenes into this folder
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Size of the pictures
    #[arg(long, value_name = "WxH", default_value = "400x300", value_parser = parse_size)]
    size: [u32; 2],
    /// What renders
    #[arg(long, value_enum, default_value_t = Backend::Auto)]
    backend: Backend,
    /// The folder with this project's meshes and patterns [default: the checkout's]
    #[arg(long, value_name = "DIR")]
    assets: Option<PathBuf>,
}

/// A language for GPUs.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Language {
    /// Vulkan's
    Spirv,
    /// WebGPU's
    Wgsl,
    /// OpenGL's, version 4.50
    Glsl,
    /// Direct3D's, shader model 5.1
    Hlsl,
    /// Metal's, version 2.0
    Msl,
}

/// What exported fragment shaders write.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Written {
    /// Linear RGB and an alpha of 1, as floats
    Color,
    /// The bits of linear RGB and the class, as whole numbers; the SPIR-V is our own, untouched
    Words,
}

#[derive(Args)]
#[command(
    after_help = "One object is written into DIR, several into folders of their own in it, such as DIR/1-torus.\nWhat is bound where stands in README.md there, and for programs in layout.json (docs/export.md)."
)]
struct ExportArguments {
    /// The scene, a TOML file
    scene: PathBuf,
    /// Write shaders, buffers, mesh, shape map and their description into this folder
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// The languages of the shaders [default: all]
    #[arg(long, value_enum, value_name = "LIST", value_delimiter = ',')]
    target: Vec<Language>,
    /// The object of this name only
    #[arg(long, value_name = "NAME")]
    object: Option<String>,
    /// What the fragment shaders write
    #[arg(long = "write", value_enum, value_name = "WHAT", default_value_t = Written::Color)]
    write: Written,
    /// Size of the picture, in place of the scene's
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    size: Option<[u32; 2]>,
    #[command(flatten)]
    limits: LimitArguments,
}

/// Runs the command and says what went wrong.
pub fn run(arguments: Arguments) -> ExitCode {
    let level = match arguments.verbose {
        0 => Level::WARN,
        1 => Level::INFO,
        _ => Level::DEBUG,
    };
    tracing_subscriber::fmt()
        .with_max_level(level)
        .with_writer(std::io::stderr)
        .without_time()
        .with_target(false)
        .init();
    interrupt::watch();
    let result = match arguments.command {
        Command::View(arguments) => view::run(&arguments),
        Command::Render(arguments) => {
            if arguments.backend == Backend::Cpu && arguments.adapter.is_some() {
                refuse_adapter();
            }
            render::run(&arguments)
        }
        Command::Bake(arguments) => bake::run(&arguments),
        Command::Info(arguments) => info::run(&arguments),
        Command::Explain(arguments) => explain::run(&arguments),
        Command::Verify(arguments) => verify::run(&arguments),
        Command::Accuracy(arguments) => accuracy::run(&arguments),
        Command::Bounds(arguments) => bounds::run(&arguments),
        Command::Bench(BenchCommand::Scene(arguments)) => bench::scenes(&arguments),
        Command::Bench(BenchCommand::Exactness(arguments)) => bench::exactness(&arguments),
        Command::Bench(BenchCommand::Specialization(arguments)) => {
            bench::specialization(&arguments)
        }
        Command::Bench(BenchCommand::Budget(arguments)) => {
            if arguments.backend == Measured::Cpu && arguments.adapter.is_some() {
                refuse_adapter();
            }
            budget::run(&arguments)
        }
        Command::Bench(BenchCommand::Table1(arguments)) => {
            if arguments.backend == Measured::Cpu && arguments.adapter.is_some() {
                refuse_adapter();
            }
            bench::table1(&arguments)
        }
        Command::Tradeoff(arguments) => {
            if arguments.backend == Measured::Cpu && arguments.adapter.is_some() {
                refuse_adapter();
            }
            tradeoff::run(&arguments)
        }
        Command::Gallery(arguments) => gallery::run(&arguments),
        Command::Export(arguments) => export::run(&arguments),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // Nobody may be listening; the exit code tells as well.
            let _ = writeln!(io::stderr(), "error: {}", describe(&error));
            let machine = error
                .downcast_ref::<relievo::Error>()
                .is_some_and(relievo::Error::is_machine);
            ExitCode::from(if machine { 3 } else { 1 })
        }
    }
}

/// Ends the program: an adapter was named for the CPU.
fn refuse_adapter() -> ! {
    let message = "--adapter names a GPU; leave it out, or leave out --backend cpu";
    Arguments::command()
        .error(ErrorKind::ArgumentConflict, message)
        .exit();
}

/// The error with its causes, less those that it tells itself.
fn describe(error: &anyhow::Error) -> String {
    let mut text = error.to_string();
    for cause in error.chain().skip(1).map(ToString::to_string) {
        if !text.contains(&cause) {
            text = format!("{text}: {cause}");
        }
    }
    text
}

/// Writes a line to standard output. A reader that has gone away, as in
/// `relievo info | head -1`, wants no more of it and is no error.
fn say(line: fmt::Arguments<'_>) -> anyhow::Result<()> {
    match writeln!(io::stdout(), "{line}") {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        result => result.context("cannot write to standard output"),
    }
}

/// `800x600` → [800, 600].
fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let limit = relievo::scene::LARGEST_PICTURE_SIDE;
    let side = |text: &str| {
        text.parse()
            .ok()
            .filter(|side| (1..=limit).contains(side))
            .ok_or_else(|| {
                format!("a size is WIDTHxHEIGHT, such as 800x600, each from 1 to {limit}")
            })
    };
    let (width, height) = text.split_once(['x', 'X']).unwrap_or((text, ""));
    Ok([side(width)?, side(height)?])
}

/// Line heights.
fn parse_margin(text: &str) -> Result<f64, String> {
    let margin = text.parse().ok();
    margin
        .filter(|margin| (0.0..=10.0).contains(margin))
        .ok_or_else(|| "a margin is a number of line heights from 0 to 10, such as 0.2".to_string())
}

/// `0.5px` or `0.5` → 0.5.
fn parse_budget(text: &str) -> Result<f64, String> {
    let (least, largest) = (relievo::scene::LEAST_BUDGET, relievo::scene::LARGEST_BUDGET);
    let number = text.strip_suffix("px").unwrap_or(text).trim();
    let budget = number.parse().ok();
    budget
        .filter(|budget| (least..=largest).contains(budget))
        .ok_or_else(|| {
            format!("a budget is a number of pixels from {least} to {largest}, such as 0.5px")
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        Arguments::command().debug_assert();
    }

    #[test]
    fn budgets() {
        assert_eq!(parse_budget("0.5px"), Ok(0.5));
        assert_eq!(parse_budget("2"), Ok(2.0));
        for bad in ["", "px", "0", "-1px", "nan", "1000px", "0.5 pt"] {
            assert!(parse_budget(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn sizes() {
        assert_eq!(parse_size("800x600"), Ok([800, 600]));
        for bad in ["", "800", "0x600", "800x", "800x-1", "99999x1", "axb"] {
            assert!(parse_size(bad).is_err(), "{bad}");
        }
    }
}
