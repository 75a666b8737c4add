//! Measures an object carved per pixel beside the same object as plain triangles.

use super::carve::{Carving, contours};
use super::raster::Raster;
use super::trace::Tracer;
use crate::bench::{Summary, fitting};
use glam::DVec3;
use relievo::Error;
use relievo::oracle::{MeshOracle, Truth};
use relievo::prepare::{PreparedScene, prepare};
use relievo::render::gpu::{Adapter, Choice, Extent, Memory, Pictures};
use relievo::render::{CpuRenderer, GeometryWords, GpuRenderer, RenderError, Renderer};
use relievo::scene::{Scene, SceneError, Search, Tier};
use std::time::Instant;

/// Error of the triangles, pixels, and tolerance of the accurate tier.
pub const ERROR_PX: f64 = 0.5;
/// Tolerances of the triangles that are tried until their error is [`ERROR_PX`], pixels. Those
/// of the outlines and of the curvature add up, or both are far less than allowed.
const TOLERANCES: [f64; 10] = [8.0, 4.0, 2.0, 1.4, 1.0, 0.7, 0.5, 0.25, 0.12, 0.06];
/// Errors above this are infinite, pixels.
const LARGEST_ERROR: f64 = 8.0;

/// A way to draw the object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Plain triangles.
    Triangles,
    /// The fast tier.
    Fast,
    /// The accurate tier.
    Accurate,
}

impl Method {
    /// All of them, in the order of the tables.
    pub const ALL: [Method; 3] = [Method::Triangles, Method::Fast, Method::Accurate];

    /// Returns its name.
    pub fn name(self) -> &'static str {
        match self {
            Method::Triangles => "triangles",
            Method::Fast => "fast tier",
            Method::Accurate => "accurate tier",
        }
    }
}

/// What varies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setting {
    /// Repeats of the pattern along u and v.
    pub repeat: u32,
    /// Distance from the eye to its target, in those of the scene.
    pub distance: f64,
    /// Width and height of the picture, in those of the scene.
    pub scale: f64,
}

/// Measurements of one method.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    /// The method.
    pub method: Method,
    /// 0.99 quantile of the per-pixel error against the oracle, pixels.
    pub error_px: f64,
    /// Number of triangles that are drawn.
    pub triangles: usize,
    /// Bytes of the buffers on a GPU, without pictures.
    pub bytes: u64,
    /// Time from the scene file to a CPU renderer, milliseconds.
    pub preparation: f64,
    /// Median time of a frame on the CPU, milliseconds.
    pub cpu: f64,
    /// Median time of a frame on the GPU, milliseconds; `None` where it does not fit, or
    /// without a GPU.
    pub gpu: Option<f64>,
}

/// Measurements with one setting.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The setting.
    pub setting: Setting,
    /// Width and height of the picture, pixels.
    pub size: [u32; 2],
    /// One for each of [`Method::ALL`].
    pub cells: Vec<Cell>,
}

/// Why a scene was not measured.
#[derive(Debug, thiserror::Error)]
pub enum GeometryError {
    /// It cannot be made of plain triangles here.
    #[error("{0}")]
    Unsuitable(String),
    /// It cannot be prepared or drawn.
    #[error(transparent)]
    Relievo(#[from] Error),
}

impl From<RenderError> for GeometryError {
    fn from(error: RenderError) -> Self {
        GeometryError::Relievo(error.into())
    }
}

impl From<SceneError> for GeometryError {
    fn from(error: SceneError) -> Self {
        GeometryError::Relievo(error.into())
    }
}

/// Returns the settings to measure: the repeats up to `most`, then distances and sizes at
/// `middle` repeats.
pub fn settings(most: u32, middle: u32) -> Vec<Setting> {
    let setting = |repeat, distance, scale| Setting {
        repeat,
        distance,
        scale,
    };
    let repeats = (0..)
        .map(|step| 1 << (2 * step))
        .take_while(|repeat| *repeat <= most);
    let mut all: Vec<Setting> = repeats.map(|repeat| setting(repeat, 1.0, 1.0)).collect();
    if !all.contains(&setting(middle, 1.0, 1.0)) {
        all.push(setting(middle, 1.0, 1.0));
    }
    all.extend([2.0, 4.0, 8.0].map(|distance| setting(middle, distance, 1.0)));
    all.extend([0.25, 0.5, 2.0].map(|scale| setting(middle, 1.0, scale)));
    all
}

/// Checks that the walls of `scene` are straight, which those of plain triangles are.
///
/// # Errors
/// [`GeometryError::Unsuitable`] with what to change.
pub fn check(scene: &Scene) -> Result<(), GeometryError> {
    let unsuitable = |what: &str| {
        let path = scene.path.display();
        Err(GeometryError::Unsuitable(format!("{path}: {what}")))
    };
    let [object] = &scene.objects[..] else {
        return unsuitable("give it exactly one [[object]]; more are not compared with triangles");
    };
    if object.extrusion.bevel > 0.0 || object.search == Search::Relief {
        return unsuitable("write technique = \"basic\"; the triangles have upright walls");
    }
    if !object.layers.is_empty() {
        return unsuitable("leave out the layers; one pattern is compared with triangles");
    }
    if object.cut_out {
        return unsuitable("leave out cut_out; the backs of triangles would be seen through it");
    }
    if object.instances.is_some() {
        return unsuitable("leave out instances; one object is compared with triangles");
    }
    Ok(())
}

/// Returns `scene` with `setting`, in `tier`.
fn vary(scene: &Scene, setting: &Setting, tier: Tier) -> Result<Scene, GeometryError> {
    let mut scene = scene.clone();
    scene.size = scene
        .size
        .map(|side| ((f64::from(side) * setting.scale).round() as u32).max(1));
    scene.supersampling = 1;
    if setting.distance != 1.0 {
        let mut camera = match &scene.camera {
            Some(camera) => *camera,
            None => prepare(&scene, &|_| ())?.camera,
        };
        let [eye, target] = [camera.eye, camera.target].map(DVec3::from);
        camera.eye = (target + (eye - target) * setting.distance).to_array();
        scene.camera = Some(camera);
    }
    for object in &mut scene.objects {
        *object = object
            .clone()
            .tier(tier)
            .repeat(setting.repeat, setting.repeat);
        object.budget = None;
        object.self_shadow = false;
        if tier == Tier::Accurate {
            object.tolerance = ERROR_PX;
        }
    }
    scene.check()?;
    Ok(scene)
}

/// The truth of a setting.
struct Reference<'a> {
    oracle: MeshOracle<'a>,
    truth: Truth,
    scene: &'a PreparedScene,
}

impl<'a> Reference<'a> {
    fn new(scene: &'a PreparedScene) -> Reference<'a> {
        let oracle = MeshOracle::new(scene);
        let truth = Truth::of(&oracle, DVec3::from(scene.camera.eye), &scene.frame);
        Reference {
            oracle,
            truth,
            scene,
        }
    }

    fn error_px(&self, words: &GeometryWords) -> f64 {
        let eye = DVec3::from(self.scene.camera.eye);
        let frame = &self.scene.frame;
        let errors = self
            .truth
            .displacements(&self.oracle, eye, frame, words, LARGEST_ERROR);
        errors.error_px()
    }
}

fn milliseconds(start: Instant) -> f64 {
    1e3 * start.elapsed().as_secs_f64()
}

/// Returns the width of a pixel at the nearest point of the object, world units.
fn pixel(scene: &PreparedScene) -> f64 {
    let eye = DVec3::from(scene.camera.eye);
    let bounds = &scene.bounds;
    let nearest = eye.clamp(bounds.min, bounds.max).distance(eye);
    let width = DVec3::from(scene.frame.ray_right.map(f64::from)).length();
    width * nearest.max(1e-3 * bounds.diagonal())
}

/// Carves ever finer until the error is [`ERROR_PX`]; returns the triangles, their error and
/// the time of tracing the outlines and of the last carving, milliseconds.
fn refine(scene: &PreparedScene, reference: &Reference<'_>) -> (Carving, f64, f64) {
    let pixel = pixel(scene);
    let object = &scene.objects[0];
    let start = Instant::now();
    let outlines = contours(object);
    let tracing_time = milliseconds(start);
    let mut tried = TOLERANCES.into_iter().map(|tolerance| {
        let start = Instant::now();
        let carving = Carving::new(scene, &outlines, tolerance * pixel);
        let time = tracing_time + milliseconds(start);
        let words = Tracer::new(&carving, &object.parameters).geometry(&scene.frame);
        let error = reference.error_px(&words);
        (carving, error, time)
    });
    let mut last = tried.next().expect("there is a tolerance");
    while last.1 > ERROR_PX
        && let Some(finer) = tried.next()
    {
        last = finer;
    }
    last
}

/// Measures `scene` with `setting`, `frames` times in turn.
///
/// # Errors
/// [`GeometryError`] if it cannot be prepared or drawn.
pub fn measure(
    scene: &Scene,
    setting: &Setting,
    adapter: Option<&Adapter>,
    frames: u32,
    progress: &dyn Fn(&str),
) -> Result<Row, GeometryError> {
    progress("preparing");
    let [fast, accurate] = [Tier::Fast, Tier::Accurate]
        .map(|tier| prepare(&vary(scene, setting, tier)?, &|_| ()).map_err(GeometryError::from));
    let (fast, accurate) = (fast?, accurate?);
    progress("tracing the truth");
    let reference = Reference::new(&accurate);
    progress("carving triangles");
    let (carving, error_px, carving_time) = refine(&accurate, &reference);
    let object = &accurate.objects[0].parameters;

    let start = Instant::now();
    let tracer = Tracer::new(&carving, object);
    let preparation = milliseconds(start) + carving_time;
    let mut raster = fitting(adapter.map(|adapter| Raster::new(&carving, object, adapter)))?;
    let mut cells = vec![Cell {
        method: Method::Triangles,
        error_px,
        triangles: carving.triangles(),
        bytes: carving.bytes(),
        preparation: preparation + 1e3 * accurate.preparation.as_secs_f64(),
        cpu: 0.0,
        gpu: None,
    }];
    let mut ours = Vec::new();
    for (method, scene) in [(Method::Fast, &fast), (Method::Accurate, &accurate)] {
        progress(method.name());
        let start = Instant::now();
        let mut cpu = CpuRenderer::new(scene);
        let preparation = milliseconds(start) + 1e3 * scene.preparation.as_secs_f64();
        let gpu = adapter.map(|adapter| GpuRenderer::new(scene, adapter, Choice::Trusted));
        cells.push(Cell {
            method,
            error_px: reference.error_px(&cpu.geometry(&scene.frame)?),
            triangles: scene.triangle_count(),
            bytes: Memory::of(scene, Extent::Needed, Pictures::Color).scene(),
            preparation,
            cpu: 0.0,
            gpu: None,
        });
        ours.push((scene, cpu, fitting(gpu)?));
    }

    let mut times = vec![[Vec::new(), Vec::new()]; cells.len()];
    for round in 0..=frames {
        progress(&format!("frame {round} of {frames}"));
        let mut note = |cell: usize, device: usize, time: f64| {
            if round > 0 {
                times[cell][device].push(time);
            }
        };
        let start = Instant::now();
        tracer.color(&accurate.frame);
        note(0, 0, milliseconds(start));
        if let Some(raster) = &mut raster {
            note(0, 1, 1e3 * raster.time(&accurate.frame)?.as_secs_f64());
        }
        for (cell, (scene, cpu, gpu)) in (1..).zip(&mut ours) {
            let start = Instant::now();
            cpu.color(&scene.frame)?;
            note(cell, 0, milliseconds(start));
            if let Some(gpu) = gpu {
                note(
                    cell,
                    1,
                    1e3 * gpu.time_color(&scene.frame)?.wall.as_secs_f64(),
                );
            }
        }
    }
    for (cell, [cpu, gpu]) in cells.iter_mut().zip(&times) {
        let median = |times: &[f64]| Summary::of(times).map(|summary| summary.median);
        cell.cpu = median(cpu).unwrap_or(0.0);
        cell.gpu = median(gpu);
    }
    Ok(Row {
        setting: *setting,
        size: accurate.size,
        cells,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use relievo::render::gpu::choose;
    use std::path::{Path, PathBuf};

    /// A scene of one object of the assets.
    fn scene(mesh: &str, pattern: &str, keys: &str) -> Scene {
        let text = format!(
            "[image]\nsize = [120, 90]\n[camera]\neye = [0.6, 2.0, 3.4]\nfov = 38.0\n[[object]]\n\
             mesh = '../meshes/{mesh}.obj'\nshape = '../patterns/{pattern}.png'\ndepth = 0.1\n{keys}\n"
        );
        let assets = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../assets/scenes/a.toml");
        Scene::parse(&text, &assets).unwrap()
    }

    fn setting(repeat: u32) -> Setting {
        Setting {
            repeat,
            distance: 1.0,
            scale: 1.0,
        }
    }

    #[test]
    fn triangles_are_where_the_oracle_is() {
        let cases = [
            ("torus", "letters", "extension = 0.01", 6),
            ("blob", "lattice", "", 1),
        ];
        for (mesh, pattern, keys, repeat) in cases {
            let scene = scene(mesh, pattern, keys);
            check(&scene).unwrap();
            let row = measure(&scene, &setting(repeat), None, 1, &|_| ()).unwrap();
            let [triangles, fast, accurate] = &row.cells[..] else {
                panic!("{row:?}");
            };
            assert!(triangles.error_px <= ERROR_PX, "{mesh}: {row:?}");
            assert!(accurate.error_px <= ERROR_PX, "{mesh}: {row:?}");
            assert!(triangles.triangles > fast.triangles, "{mesh}: {row:?}");
            assert!(
                row.cells
                    .iter()
                    .all(|cell| cell.cpu > 0.0 && cell.gpu.is_none())
            );
        }
    }

    #[test]
    fn gpu_triangles_are_those_of_the_cpu() {
        let adapter = choose(None).unwrap();
        let scene = vary(&scene("torus", "discs", ""), &setting(8), Tier::Accurate).unwrap();
        let prepared = prepare(&scene, &|_| ()).unwrap();
        let object = &prepared.objects[0].parameters;
        let carving = Carving::new(&prepared, &contours(&prepared.objects[0]), 0.002);
        let cpu = Tracer::new(&carving, object).color(&prepared.frame);
        let mut raster = Raster::new(&carving, object, &adapter).unwrap();
        let gpu = raster.color(&prepared.frame).unwrap();
        let mut classes = 0;
        let mut colors = 0;
        for (cpu, gpu) in cpu.words.iter().zip(&gpu.words) {
            classes += usize::from(cpu[3] != gpu[3]);
            let differs = |i: usize| (f32::from_bits(cpu[i]) - f32::from_bits(gpu[i])).abs() > 0.01;
            colors += usize::from(cpu[3] == gpu[3] && (0..3).any(differs));
        }
        // Edges between pixels.
        let pixels = cpu.words.len();
        assert!(
            classes < pixels / 200 && colors < pixels / 200,
            "{classes}, {colors}"
        );
        assert!(cpu.words.iter().filter(|word| word[3] != 0).count() > pixels / 5);
        assert!(raster.time(&prepared.frame).unwrap().as_nanos() > 0);
    }

    #[test]
    fn what_triangles_cannot_show_is_refused() {
        let refused = |scene: &Scene| check(scene).unwrap_err().to_string();
        let beveled = scene("plane", "discs", "technique = 'beveled'");
        assert!(
            refused(&beveled).contains("technique = \"basic\""),
            "{}",
            refused(&beveled)
        );
        let relief = scene("plane", "discs", "technique = 'relief'");
        assert!(refused(&relief).contains("technique = \"basic\""));
        let copies = scene(
            "plane",
            "discs",
            "instances = { count = [2, 1, 1], spacing = [3.0, 0.0, 0.0] }",
        );
        assert!(refused(&copies).contains("leave out instances"));
        let cut_out = scene("plane", "discs", "cut_out = true");
        assert!(refused(&cut_out).contains("leave out cut_out"));
        let mut two = scene("plane", "discs", "");
        two.objects.push(two.objects[0].clone());
        assert!(refused(&two).contains("exactly one"));
        assert!(refused(&two).starts_with(&two.path.display().to_string()));
        two.objects.clear();
        assert!(check(&two).is_err());
        assert!(Path::new(&two.path).ends_with("a.toml"));
    }

    #[test]
    fn every_setting_has_its_repeats() {
        let all = settings(256, 16);
        let repeats: Vec<u32> = all[..5].iter().map(|setting| setting.repeat).collect();
        assert_eq!(repeats, [1, 4, 16, 64, 256]);
        assert_eq!(all.len(), 11);
        assert!(all[5..].iter().all(|setting| setting.repeat == 16));
        // The middle is measured once even where it is beyond the most.
        assert_eq!(settings(4, 16).len(), 9);
    }
}
