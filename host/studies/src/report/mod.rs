//! What a device does with the shaders: words that differ, times, registers.
//!
//! Nothing in a report is private: no file names, no names of users or machines.

mod page;

use crate::bench::{Backend, Clock, Method, ROWS, Summary, Timed, measure};
use relievo::Error;
use relievo::prepare::{PreparedScene, prepare};
use relievo::render::RenderError;
use relievo::render::gpu::{Adapter, Choice, EntryPoints, Extent, Shaders};
use relievo::scene::{Scene, Tier};
use relievo::verify::kernels::{KERNELS, record};
use relievo::verify::{AdapterReport, Tested};
use relievo_bitwise::{Plan, Recorded};
use relievo_compiled::{Driver, Shader, Texts};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;
use std::time::Instant;

/// Seed of the inputs.
const SEED: u64 = 1;
/// Size of the pictures that are compared, pixels.
const COMPARED: [u32; 2] = [400, 300];
/// Tiers of the report.
const TIERS: [Tier; 4] = [Tier::Planar, Tier::Fast, Tier::Accurate, Tier::Paper];
/// A scene of each report: the torus of the assets.
const SCENE: &str = "scenes/torus.toml";

/// How much is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Effort {
    /// Size of the pictures that are timed, pixels.
    pub size: [u32; 2],
    /// Timed frames, after one to warm up.
    pub frames: u32,
    /// Inputs of each function.
    pub inputs: u64,
}

impl Effort {
    /// Returns the effort for an adapter: less for a software driver.
    pub fn of(adapter: &Adapter) -> Effort {
        let (size, frames) = if adapter.is_software() {
            ([400, 300], 3)
        } else {
            ([800, 600], 15)
        };
        Effort {
            size,
            frames,
            inputs: 65_536,
        }
    }
}

/// The report of one device.
#[derive(Clone, Debug, Serialize)]
pub struct DeviceReport {
    /// Version of Relievo.
    pub relievo: &'static str,
    /// Operating system and architecture.
    pub system: String,
    /// Frames that are timed, inputs that are compared.
    pub effort: Effort,
    /// Adapter, canaries, words that differ.
    pub words: AdapterReport,
    /// Times of the tiers.
    pub tiers: Vec<TierTime>,
    /// The paper's Table 1.
    pub table1: Vec<Table1Time>,
    /// What the driver's compiler made of the shaders of the tiers.
    pub compiled: Vec<CompiledShader>,
    /// Why `compiled` is empty.
    pub not_compiled: Option<String>,
    /// Time that the report took, seconds.
    pub seconds: f64,
}

/// Time of a frame of the torus.
#[derive(Clone, Debug, Serialize)]
pub struct TierTime {
    /// The tier.
    pub tier: &'static str,
    /// The shaders.
    pub shaders: &'static str,
    /// Median time, milliseconds.
    pub milliseconds: f64,
    /// Source of the time.
    pub clock: Clock,
}

/// A time of Table 1.
#[derive(Clone, Debug, Serialize)]
pub struct Table1Time {
    /// The shaders.
    pub shaders: &'static str,
    /// The shape map.
    pub map: &'static str,
    /// The method.
    pub method: String,
    /// Median time, milliseconds.
    pub milliseconds: f64,
    /// Speed as a multiple of curved relief mapping's, the median of the rounds.
    pub speed_to_curved_relief: f64,
}

/// What the driver's compiler made of a shader.
#[derive(Clone, Debug, Serialize)]
pub struct CompiledShader {
    /// The tier.
    pub tier: &'static str,
    /// The shaders.
    pub shaders: &'static str,
    /// The driver's statistics of the fragment shader, by its names.
    pub statistics: BTreeMap<String, u64>,
}

/// Measures `adapter`. `assets` holds this project's meshes, patterns and scenes.
///
/// # Errors
/// [`Error`] if an asset cannot be read, or the device fails.
pub fn report(
    adapter: Adapter,
    effort: Effort,
    assets: &Path,
    progress: &dyn Fn(String, f64),
) -> Result<DeviceReport, Error> {
    let start = Instant::now();
    let scenes = TIERS
        .iter()
        .map(|tier| scene(*tier, COMPARED, assets))
        .collect::<Result<Vec<_>, Error>>()?;
    let mut tested = Tested::new(adapter, &Shaders::ALL)?;
    let mut recorded = Recorded::new();
    for (scene, tier) in scenes.iter().zip(TIERS) {
        record(scene, &mut recorded)?;
        let name = format!("torus, {} tier", tier.name());
        let show = |what| progress(what, 0.02);
        Tested::pictures(std::slice::from_mut(&mut tested), scene, &name, &show)?;
    }
    let plan = Plan {
        inputs: effort.inputs,
        seed: SEED,
        recorded: &recorded,
    };
    let names: Vec<&str> = KERNELS.iter().map(|kernel| kernel.name).collect();
    tested.functions(&names, &plan, &|what, _| progress(what, 0.1))?;

    progress("times of the tiers".to_string(), 0.3);
    // Those that the program takes, and those that are made for speed.
    let trusted = Choice::Trusted.on(&tested.adapter.open()?)?;
    let timed: Vec<Shaders> = [trusted, Shaders::Fast]
        .into_iter()
        .filter(|shaders| tested.shaders.contains(shaders))
        .collect();
    let adapter = &tested.adapter;
    let tiers = tier_times(adapter, &timed, effort, assets)?;
    let table1 = table1(adapter, &timed, effort, assets, progress)?;
    let (compiled, not_compiled) = match compiled(adapter, &timed, &scenes) {
        Ok(compiled) => (compiled, None),
        Err(why) => (Vec::new(), Some(why)),
    };
    // Where no words are promised, their number is enough.
    for module in tested
        .report
        .modules
        .iter_mut()
        .filter(|module| !module.promises)
    {
        let kernels = module.kernels.iter_mut().map(|kernel| &mut kernel.found);
        let pictures = module.pictures.iter_mut();
        let pictures = pictures.flat_map(|picture| [&mut picture.color, &mut picture.geometry]);
        kernels
            .chain(pictures)
            .for_each(|counts| counts.first.clear());
    }
    Ok(DeviceReport {
        relievo: env!("CARGO_PKG_VERSION"),
        system: format!("{}, {}", std::env::consts::OS, std::env::consts::ARCH),
        effort,
        words: tested.report,
        tiers,
        table1,
        compiled,
        not_compiled,
        seconds: start.elapsed().as_secs_f64(),
    })
}

/// Returns the torus in `tier`.
fn scene(tier: Tier, size: [u32; 2], assets: &Path) -> Result<PreparedScene, Error> {
    let mut scene = Scene::load(&assets.join(SCENE))?;
    scene.size = size;
    scene.supersampling = 1;
    for object in &mut scene.objects {
        *object = object.clone().tier(tier);
    }
    prepare(&scene, &|_| ())
}

fn tier_times(
    adapter: &Adapter,
    shaders: &[Shaders],
    effort: Effort,
    assets: &Path,
) -> Result<Vec<TierTime>, Error> {
    let scenes = TIERS
        .iter()
        .map(|tier| scene(*tier, effort.size, assets))
        .collect::<Result<Vec<_>, Error>>()?;
    let mut renderers = Vec::new();
    for (scene, tier) in scenes.iter().zip(TIERS) {
        for &shaders in shaders {
            let timed = Timed::new(scene, &Backend::Gpu(adapter, shaders))?;
            renderers.push((scene, tier, shaders, timed, Vec::new(), Clock::Wall));
        }
    }
    for round in 0..=effort.frames {
        for (scene, _, _, timed, times, clock) in &mut renderers {
            let (time, read_from) = timed.time(&scene.frame)?;
            *clock = read_from;
            if round > 0 {
                times.push(time);
            }
        }
    }
    let times = renderers.into_iter();
    Ok(times
        .map(|(_, tier, shaders, _, times, clock)| TierTime {
            tier: tier.name(),
            shaders: shaders.describe(),
            milliseconds: Summary::of(&times).map_or(0.0, |summary| summary.median),
            clock,
        })
        .collect())
}

fn table1(
    adapter: &Adapter,
    shaders: &[Shaders],
    effort: Effort,
    assets: &Path,
    progress: &dyn Fn(String, f64),
) -> Result<Vec<Table1Time>, Error> {
    let backends: Vec<Backend<'_>> = shaders
        .iter()
        .map(|shaders| Backend::Gpu(adapter, *shaders))
        .collect();
    let show =
        |what: String, fraction: f64| progress(format!("Table 1: {what}"), 0.4 + 0.5 * fraction);
    let table = measure(&backends, effort.size, effort.frames, assets, &show)?;
    let mut times = Vec::new();
    for (run, shaders) in table.runs.iter().zip(shaders) {
        for (number, (row, cells)) in ROWS.iter().zip(&run.rows).enumerate() {
            for cell in cells {
                let speed = run.speed(number, cell.method, Method::CURVED_RELIEF);
                let time = Summary::of(&cell.milliseconds);
                let median = |summary: Option<Summary>| summary.map_or(0.0, |it| it.median);
                times.push(Table1Time {
                    shaders: shaders.describe(),
                    map: row.pattern,
                    method: cell.method.to_string(),
                    milliseconds: median(time),
                    speed_to_curved_relief: median(speed),
                });
            }
        }
    }
    Ok(times)
}

/// Compiles the shaders of the tiers with the driver of `adapter`, or says why it does not
/// tell what it makes of them.
fn compiled(
    adapter: &Adapter,
    shaders: &[Shaders],
    scenes: &[PreparedScene],
) -> Result<Vec<CompiledShader>, String> {
    if !adapter.takes_spirv() {
        return Err("only Vulkan drivers tell".to_string());
    }
    let info = adapter.info();
    let driver =
        Driver::open_device(info.vendor, info.device).map_err(|error| error.to_string())?;
    let mut all = Vec::new();
    for (scene, tier) in scenes.iter().zip(TIERS) {
        let entry_points = EntryPoints::of(&scene.objects[0].parameters, Extent::Needed);
        for shaders in shaders {
            let module = shaders
                .module()
                .map_err(|error: RenderError| error.to_string())?;
            let shader = |name: &str| {
                let words = module.spirv(name).ok_or(format!("no entry point {name}"))?;
                let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
                Shader::read(&bytes).map_err(|error| error.to_string())
            };
            let (vertex, fragment) = (shader("place")?, shader(entry_points.color)?);
            // SAFETY: the modules are built in, and the builder has validated them.
            let made = unsafe { driver.compile(&[&vertex, &fragment], Texts::None) };
            let made = made.map_err(|error| error.to_string())?;
            let fragment = made.into_iter().find(|made| made.stage == fragment.stage);
            all.extend(fragment.map(|made| CompiledShader {
                tier: tier.name(),
                shaders: shaders.describe(),
                statistics: made.statistics,
            }));
        }
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use relievo::render::gpu::choose;

    #[test]
    fn gpu_a_report_is_whole_and_tells_nothing_private() {
        let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets");
        let assets = assets.canonicalize().unwrap();
        let effort = Effort {
            size: [40, 30],
            frames: 1,
            inputs: 1000,
        };
        let adapter = choose(None).unwrap();
        let report = report(adapter, effort, &assets, &|_, _| ()).unwrap();
        assert!(report.words.exact && report.words.modules.len() >= 3);
        for module in &report.words.modules {
            assert_eq!(module.pictures.len(), TIERS.len());
            assert!(module.kernels.len() > 30);
            assert_eq!(module.promises, module.different == 0, "{}", module.shaders);
        }
        assert_eq!(report.tiers.len(), 2 * TIERS.len());
        assert_eq!(report.table1.len(), 2 * ROWS.len() * Method::ALL.len());
        assert!(report.tiers.iter().all(|time| time.milliseconds > 0.0));
        let is_told = report.compiled.len() == 2 * TIERS.len();
        assert_eq!(is_told, report.not_compiled.is_none());
        let json = serde_json::to_string(&report).unwrap();
        let page = report.to_string();
        for text in [&json, &page] {
            for private in [
                assets.to_str().unwrap(),
                "assets",
                ".toml",
                "/home",
                "/root",
            ] {
                assert!(!text.contains(private), "{private}");
            }
        }
        assert!(page.contains("0 of "), "{page}");
    }
}
