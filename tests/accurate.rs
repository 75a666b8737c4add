//! The accurate tier against its oracle, an independent f64 search of every
//! prism, for views of all kinds and all meshes.
//!
//! A pixel is wrong unless the oracle agrees on its ray: a miss, or a hit at
//! the same distance. Two kinds of disagreement are excused. A ray may pass an
//! edge so closely that rounding decides; then the oracle must give the
//! renderer's answer for a ray moved by at most a hundredth of a pixel. And the
//! oracle, which searches each prism alone, also finds hits of rays that enter
//! the shell through the floor, which the renderer does not follow; then the
//! first hit reached from outside counts.
//!
//! With the environment variable RELIEVO_LONG=1 each mesh is seen from 200
//! places instead of a few.

use glam::DVec3;
use rayon::prelude::*;
use relievo::oracle::wide::{wide_frame, wide_object, wide_prism};
use relievo::oracle::{AnalyticOracle, MeshOracle, Oracle, Sample, Truth};
use relievo::prepare::{PreparedObject, PreparedScene, prepare, unlit_frame};
use relievo::render::{CpuRenderer, GeometryWords, Renderer};
use relievo::scene::{Scene, Technique, Tier};
use relievo_shared::layout::{Frame, NO_NEIGHBOUR};
use relievo_shared::normals::{CLASS_BEVEL, CLASS_CAP, CLASS_FLOOR, CLASS_MISS, CLASS_WALL};
use relievo_shared::profile;
use relievo_shared_f64 as double;
use relievo_tests::{Random, asset, is_long};
use std::f64::consts::TAU;
use std::fmt::{self, Write};
use std::ops::AddAssign;
use std::path::Path;
use std::sync::Arc;

/// Scene files and their assets in a temporary folder.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Folder {
        let folder = tempfile::tempdir().unwrap();
        for name in ["discs", "hexagons", "letters"] {
            let file = format!("{name}.png");
            std::fs::copy(asset("patterns").join(&file), folder.path().join(&file)).unwrap();
        }
        Folder(folder)
    }

    fn mesh(&self, name: &str, text: &str) {
        std::fs::write(self.0.path().join(format!("{name}.obj")), text).unwrap();
    }

    fn prepare(&self, text: &str) -> PreparedScene {
        prepared(text, &self.0.path().join("scene.toml"))
    }
}

fn prepared(text: &str, path: &Path) -> PreparedScene {
    let scene = Scene::parse(text, path).unwrap_or_else(|error| panic!("{error}"));
    prepare(&scene, &|_| ()).unwrap_or_else(|error| panic!("{error}"))
}

/// Search steps: the default number runs out along the surface, which the
/// renderer counts as a hit and the oracle does not.
const STEPS: u32 = 1000;

/// One object of the accurate tier, 0.08 deep, with the lines `more`.
fn object(mesh: &str, pattern: &str, repeat: [f64; 2], more: &str) -> String {
    format!(
        "[[object]]\nmesh = \"{mesh}.obj\"\nshape = \"{pattern}.png\"\nrepeat = {repeat:?}\ndepth = 0.08\ntier = \"accurate\"\nsteps = {STEPS}\ntolerance = 0.002\n{more}\n"
    )
}

/// The same for a mesh and a pattern in `assets/`.
fn asset_scene(mesh: &str, pattern: &str, repeat: [f64; 2], more: &str) -> PreparedScene {
    let mesh = format!("../meshes/{mesh}");
    let pattern = format!("../patterns/{pattern}");
    prepared(
        &object(&mesh, &pattern, repeat, more),
        &asset("scenes/test.toml"),
    )
}

/// A camera, relative to the scene's origin.
#[derive(Clone, Copy, Debug)]
struct Viewpoint {
    eye: DVec3,
    forward: DVec3,
    /// Vertical field of view, degrees.
    fov: f64,
}

impl Viewpoint {
    fn towards(eye: DVec3, target: DVec3, fov: f64) -> Viewpoint {
        Viewpoint {
            eye,
            forward: (target - eye).normalize(),
            fov,
        }
    }

    fn frame(&self, size: [u32; 2]) -> Frame {
        let forward = self.forward.normalize();
        let up = forward.any_orthonormal_vector();
        Frame {
            near: 1e-6,
            ..unlit_frame(self.eye, forward, up, self.fov, size)
        }
    }
}

/// Counts of the pixels of some pictures.
#[derive(Clone, Copy, Debug, Default)]
struct Count {
    pixels: usize,
    hits: usize,
    /// Rays that the oracle follows through the floor.
    from_behind: usize,
    /// Rays so near to the floor that f32 places them on it.
    at_floor: usize,
    /// Decided by rounding.
    excused: usize,
    /// Rays that start in a column: what the near plane cuts is no hit.
    in_front: usize,
    /// Rays that ran out of steps, which counts as a hit.
    ran_out: usize,
    /// Rays in the plane of a flat cap, where either answer is right (section
    /// 10: on the pattern, the cap is hit).
    along_cap: usize,
    /// Another class at the same place.
    other_class: usize,
    holes: usize,
    extra: usize,
    misplaced: usize,
}

impl Count {
    fn wrong(&self) -> usize {
        self.holes + self.extra + self.misplaced
    }

    /// Excuses are rare.
    fn assert_excuses(&self, most_excused: f64) {
        let share = |count: usize| count as f64 / self.pixels as f64;
        assert!(share(self.excused) <= most_excused, "{self}");
        assert!(share(self.at_floor) <= MOST_AT_FLOOR, "{self}");
        assert!(share(self.ran_out) <= MOST_OUT_OF_STEPS, "{self}");
        assert!(share(self.other_class) <= most_excused, "{self}");
    }
}

impl AddAssign for Count {
    fn add_assign(&mut self, other: Count) {
        self.pixels += other.pixels;
        self.hits += other.hits;
        self.from_behind += other.from_behind;
        self.at_floor += other.at_floor;
        self.excused += other.excused;
        self.in_front += other.in_front;
        self.ran_out += other.ran_out;
        self.along_cap += other.along_cap;
        self.other_class += other.other_class;
        self.holes += other.holes;
        self.extra += other.extra;
        self.misplaced += other.misplaced;
    }
}

impl fmt::Display for Count {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} pixels, {} hit; {} excused, {} near the floor, {} in a column, {} out of steps, {} of another class, {} from behind, {} along a cap; wrong: {} holes, {} extra, {} misplaced",
            self.pixels,
            self.hits,
            self.excused,
            self.at_floor,
            self.in_front,
            self.ran_out,
            self.other_class,
            self.from_behind,
            self.along_cap,
            self.holes,
            self.extra,
            self.misplaced
        )
    }
}

/// A ray, relative to the scene's origin.
#[derive(Clone, Copy)]
struct Ray {
    eye: DVec3,
    direction: DVec3,
}

impl Ray {
    /// Through the point (`x`, `y`) of the picture, in pixels.
    fn through(frame: &double::layout::Frame, x: f64, y: f64) -> Ray {
        let raw = DVec3::from(frame.ray_first)
            + DVec3::from(frame.ray_right) * x
            + DVec3::from(frame.ray_down) * y;
        Ray {
            eye: DVec3::from(frame.eye),
            direction: raw.normalize(),
        }
    }

    fn at(&self, t: f64) -> DVec3 {
        self.eye + self.direction * t
    }

    /// Parameters where the ray is in the ball around `centre`.
    fn in_ball(&self, centre: DVec3, radius: f64) -> Option<(f64, f64)> {
        let middle = (centre - self.eye).dot(self.direction);
        let apart = self.at(middle).distance_squared(centre);
        let half = (radius * radius - apart).sqrt();
        (apart < radius * radius && middle + half > 0.0)
            .then_some(((middle - half).max(0.0), middle + half))
    }
}

/// Largest relative difference of distances, in addition to an absolute one,
/// for the same hit.
const SAME_SHARE: f64 = 1e-3;
const SAME: f64 = 1e-4;

/// Whether `sample` matches a rendered hit: `class` at `t`.
fn agrees(sample: Sample, class: u32, t: f64) -> bool {
    if sample.is_hit() && class != CLASS_MISS {
        (sample.t - t).abs() <= SAME + SAME_SHARE * sample.t
    } else {
        sample.is_hit() == (class != CLASS_MISS)
    }
}

/// Largest displacement of a ray to find the rendered answer, pixels.
const EXCUSE: [f64; 3] = [0.01, 0.004, 0.001];

/// Whether `trace` gives the rendered answer for a ray near pixel (`x`, `y`).
fn is_excused(
    frame: &double::layout::Frame,
    (x, y): (f64, f64),
    trace: impl Fn(Ray) -> Sample,
    class: u32,
    t: f64,
) -> bool {
    (0..8 * EXCUSE.len()).any(|i| {
        let (sin, cos) = (i as f64 * TAU / 8.0).sin_cos();
        let r = EXCUSE[i / 8];
        let ray = Ray::through(frame, x + r * cos, y + r * sin);
        agrees(trace(ray), class, t)
    })
}

/// Step along the ray, as a fraction of the depth.
const LOOK: f64 = 0.08 / 64.0;

/// In f32, δ from 1 − 2e-4 on is the floor (section 6); with a margin for
/// rounding.
const NEARLY_FLOOR: f64 = 1.0 - 2.5e-4;

/// The oracle of one scene.
struct Checker<'a> {
    scene: &'a PreparedScene,
    oracle: MeshOracle<'a>,
    prisms: Vec<(double::layout::PrismData, double::prism::Prism)>,
}

impl<'a> Checker<'a> {
    fn new(scene: &'a PreparedScene) -> Checker<'a> {
        let mut prisms = Vec::new();
        for object in &scene.objects {
            let depth = f64::from(object.parameters.depth);
            let all = object.prisms.iter().map(wide_prism);
            prisms.extend(all.map(|data| (data, double::prism::Prism::new(&data, depth))));
        }
        Checker {
            scene,
            oracle: MeshOracle::new(scene),
            prisms,
        }
    }

    fn trace(&self, ray: Ray) -> Sample {
        self.oracle
            .trace(ray.eye + self.scene.origin, ray.direction)
    }

    /// δ at `point` in each of the prisms `near` over whose triangle it lies.
    fn depths(&self, near: &[usize], point: DVec3) -> Vec<f64> {
        let depth_in = |&i: &usize| {
            let (data, prism) = &self.prisms[i];
            let target = point - prism.anchor;
            if !double::prism::is_near(data, target) {
                return None;
            }
            let centre = DVec3::new(1.0 / 3.0, 1.0 / 3.0, 0.5);
            let (x, _) = prism.solve(target, centre, 12);
            let inset = x.x.min(x.y).min(1.0 - x.x - x.y);
            let solved = prism.point(x).distance(target) < 1e-9;
            (solved && inset > -1e-7).then_some(x.z)
        };
        near.iter().filter_map(depth_in).collect()
    }

    /// Whether the ray is in the shell just before `t`, having entered through
    /// the floor.
    fn came_through_floor(&self, near: &[usize], ray: Ray, t: f64) -> bool {
        let mut t = t + 0.01 * LOOK;
        let mut last: Option<(f64, f64)> = None;
        while t > 0.0 {
            let expected = last.map_or(0.5, |(depth, change)| depth + change);
            let depths = self.depths(near, ray.at(t));
            let nearest = depths
                .into_iter()
                .min_by(|a, b| (a - expected).abs().total_cmp(&(b - expected).abs()));
            match (nearest, last) {
                // The hit itself is on the floor; the first sample is behind
                // it.
                (Some(depth), None) if depth < 1.0005 => last = Some((depth, 0.0)),
                (Some(depth), _) if depth >= 1.0 => return true,
                (Some(depth), _) if depth <= 0.0 => return false,
                (Some(depth), None) => last = Some((depth, 0.0)),
                (Some(depth), Some((before, _))) => last = Some((depth, depth - before)),
                // Left through a side where the surface ends, or through the
                // floor.
                (None, _) => return expected > 1.0,
            }
            t -= LOOK;
        }
        false
    }

    /// The first hit of a ray that enters the shell from outside or starts in
    /// it.
    fn met_from_outside(&self, ray: Ray) -> Sample {
        let ways: Vec<(usize, (f64, f64))> = (0..self.prisms.len())
            .filter_map(|i| {
                let (data, prism) = &self.prisms[i];
                let centre = prism.anchor + DVec3::from(data.centre);
                Some((i, ray.in_ball(centre, data.radius)?))
            })
            .collect();
        let near: Vec<usize> = ways.iter().map(|(i, _)| *i).collect();
        let end = ways.iter().map(|(_, way)| way.1).fold(0.0, f64::max);
        let mut was_inside = true;
        let mut t = 0.0;
        let mut starts = vec![0.0];
        while t < end {
            let here: Vec<usize> = ways
                .iter()
                .filter(|(_, way)| way.0 <= t && t <= way.1)
                .map(|(i, _)| *i)
                .collect();
            let inside = self
                .depths(&here, ray.at(t))
                .into_iter()
                .any(|depth| (0.0..1.0).contains(&depth));
            if inside && !was_inside {
                starts.push(t - LOOK);
            }
            was_inside = inside;
            t += LOOK;
        }
        for start in starts {
            let sample = self.trace(Ray {
                eye: ray.at(start),
                ..ray
            });
            let t = start + sample.t;
            if sample.is_hit() && !self.came_through_floor(&near, ray, t) {
                return Sample { t, ..sample };
            }
        }
        Sample::MISS
    }

    /// Whether the rendered answer, `class` at `t`, is a hit of the floor
    /// before `truth`, where the ray is too near to the floor for f32 to tell.
    fn met_floor_before(&self, ray: Ray, truth: Sample, class: u32, t: f64) -> bool {
        let all: Vec<usize> = (0..self.prisms.len()).collect();
        let is_near = |t: f64| {
            let depths = self.depths(&all, ray.at(t));
            depths
                .into_iter()
                .any(|depth| (NEARLY_FLOOR..1.0001).contains(&depth))
        };
        let cut_out = |object: &PreparedObject| object.parameters.cut_out != 0;
        if !truth.is_hit() {
            false
        } else if class == CLASS_FLOOR {
            t < truth.t && is_near(t)
        } else {
            // Without a floor it is a miss.
            class == CLASS_MISS
                && self.scene.objects.iter().any(cut_out)
                && (0..64).any(|i| is_near(truth.t - 0.25 * LOOK * f64::from(i)))
        }
    }

    /// Compares each pixel of a rendering with the oracle.
    fn check(&self, frame: &Frame, words: &GeometryWords, label: &str) -> Count {
        let wide = wide_frame(frame);
        let width = words.width as usize;
        let check_pixel = |i: usize| {
            let place = ((i % width) as f64, (i / width) as f64);
            let ray = Ray::through(&wide, place.0, place.1);
            let truth = self.trace(ray);
            let class = words.class(i);
            let t = f64::from(f32::from_bits(words.place[i][0]));
            let mut count = Count {
                pixels: 1,
                hits: usize::from(truth.is_hit()),
                ..Count::default()
            };
            if agrees(truth, class, t) {
                let class = if class == CLASS_BEVEL {
                    CLASS_WALL
                } else {
                    class
                };
                count.other_class = usize::from(class != truth.class);
            } else if truth.is_hit() && truth.t < 2.0 * wide.near {
                count.in_front = 1;
            } else if class == CLASS_CAP && runs_along(ray, words.surface[i]) {
                count.along_cap = 1;
            } else if words.steps(i) >= STEPS {
                count.ran_out = 1;
            } else if agrees(self.met_from_outside(ray), class, t) {
                count.from_behind = 1;
            } else if self.met_floor_before(ray, self.met_from_outside(ray), class, t) {
                count.at_floor = 1;
            } else if is_excused(&wide, place, |ray| self.met_from_outside(ray), class, t) {
                count.excused = 1;
            } else {
                println!(
                    "{label}: pixel {place:?}, eye {:?}, direction {:?}: there is {truth:?}, from outside {:?}, found was class {class} at {t}, δ {} after {} steps",
                    ray.eye.to_array(),
                    ray.direction.to_array(),
                    self.met_from_outside(ray),
                    f32::from_bits(words.place[i][3]),
                    words.steps(i),
                );
                match (truth.is_hit(), class != CLASS_MISS) {
                    (true, false) => count.holes = 1,
                    (false, true) => count.extra = 1,
                    _ => count.misplaced = 1,
                }
            }
            count
        };
        (0..words.place.len())
            .into_par_iter()
            .map(check_pixel)
            .reduce(Count::default, |mut a, b| {
                a += b;
                a
            })
    }

    /// Renders `views` and compares them.
    fn see(&self, label: &str, views: &[Viewpoint], size: [u32; 2]) -> Count {
        let mut renderer = CpuRenderer::new(self.scene);
        let mut total = Count::default();
        for view in views {
            let frame = view.frame(size);
            let words = renderer.geometry(&frame).unwrap();
            total += self.check(&frame, &words, label);
        }
        total
    }

    /// A random point in the shell, the normal there, and whether it is clearly
    /// outside the columns.
    fn point_in_shell(&self, random: &mut Random, depth: f64) -> (DVec3, DVec3, bool) {
        let object = &self.scene.objects[0];
        let parameters = wide_object(&object.parameters);
        let index = random.bits() as usize % self.prisms.len();
        let (_, prism) = &self.prisms[index];
        let (a, b) = (random.within(0.0, 1.0), random.within(0.0, 1.0));
        let (a, b) = if a + b > 1.0 {
            (1.0 - a, 1.0 - b)
        } else {
            (a, b)
        };
        let place = prism.anchor + prism.point(DVec3::new(a, b, depth));
        let map = double::shape_map::ShapeMap::new(&parameters);
        let distance = map.distance(object.map.words(), prism.uv(a, b));
        let radius = double::profile::Profile::new(&parameters).radius(depth);
        (
            place,
            prism.normal(a, b).normalize(),
            distance > radius + 0.5,
        )
    }

    /// A view of one of four kinds: from around, along the surface, close up,
    /// and from between the columns.
    fn random_view(&self, random: &mut Random, kind: usize) -> Viewpoint {
        let fov = random.within(30.0, 80.0);
        if kind == 0 {
            let eye = random.direction() * random.magnitude(1.8, 8.0);
            let target = random.direction() * random.within(0.0, 0.8);
            return Viewpoint::towards(eye, target, fov);
        }
        loop {
            let depth = if kind == 3 {
                random.within(0.0, 1.0)
            } else {
                0.0
            };
            let (place, normal, is_free) = self.point_in_shell(random, depth);
            let tangent = normal.cross(random.direction()).normalize();
            let (height, forward) = match kind {
                1 => (
                    random.magnitude(1e-3, 0.05),
                    tangent + normal * random.within(-0.2, 0.2),
                ),
                2 => (
                    random.magnitude(0.02, 0.4),
                    tangent * random.within(0.0, 1.5) - normal,
                ),
                _ => (0.0, tangent + normal * random.within(-1.0, 1.0)),
            };
            if kind != 3 || is_free {
                return Viewpoint {
                    eye: place + normal * height,
                    forward,
                    fov,
                };
            }
        }
    }
}

/// Largest fractions of pixels decided by rounding, placed on the floor by f32,
/// or out of steps: about three times those measured over 200 views of each
/// mesh.
const MOST_EXCUSED: f64 = 5e-4;
const MOST_AT_FLOOR: f64 = 1e-2;
const MOST_OUT_OF_STEPS: f64 = 1e-4;

/// Where eyes lie in the planes of triangles, whole rows of pixels graze them.
const MOST_EXCUSED_IN_PLANES: f64 = 0.05;

const KINDS: [&str; 4] = ["around", "along", "close", "inside"];
const MESHES: [(&str, [f64; 2]); 6] = [
    ("torus", [24.0, 10.0]),
    ("sphere", [16.0, 8.0]),
    ("cylinder", [16.0, 8.0]),
    ("ellipsoid", [20.0, 9.0]),
    ("saddle", [6.0, 6.0]),
    ("blob", [6.0, 5.0]),
];
const TECHNIQUES: [&str; 4] = [
    "",
    "extension = 0.04",
    "bevel = 0.1",
    "bevel = 0.08\nchamfer = 0.4",
];

#[test]
fn random_views_have_no_holes() {
    let long = is_long();
    let views = if long { 200 } else { 24 };
    let mut random = Random(1);
    let mut seen = Vec::new();
    for (mesh, usual_repeat) in MESHES {
        let mut totals = [Count::default(); 4];
        for i in 0..views / 4 {
            let pattern = ["discs", "hexagons", "letters"][i % 3];
            let factor = random.magnitude(0.3, 1.5);
            // Sometimes the pattern is cut at the seam.
            let whole = random.choose(&[true, true, true, false]);
            let repeat = usual_repeat.map(|repeat| {
                let repeat = repeat * factor;
                if whole { repeat.round() } else { repeat }
            });
            let technique = random.choose(&TECHNIQUES);
            let cut_out = random.choose(&[true, false, false, false]);
            let more = format!("{technique}\ncut_out = {cut_out}");
            let scene = asset_scene(mesh, pattern, repeat, &more);
            let checker = Checker::new(&scene);
            for (kind, total) in totals.iter_mut().enumerate() {
                let view = checker.random_view(&mut random, kind);
                let label = format!("{mesh}, {pattern}, {repeat:?}, {more:?}, {view:?}");
                *total += checker.see(&label, &[view], [64, 48]);
            }
        }
        for (kind, total) in KINDS.iter().zip(totals) {
            println!("{mesh}, {kind}: {total}");
            assert_eq!(total.holes, 0, "{total}");
            // Nearly tangential rays that seem to enter: 4 in 3.7 million.
            seen.push((total, MOST_EXCUSED, usize::from(long)));
        }
    }
    assert_nothing_wrong(&seen);
}

/// The profiles that [`random_views_have_no_holes`] leaves out.
#[test]
fn other_profiles_have_no_holes() {
    let mut random = Random(2);
    let mut seen = Vec::new();
    let techniques = Technique::ALL.into_iter();
    for technique in techniques.filter(|t| t.default_extrusion().profile != profile::STRAIGHT) {
        let mut totals = [Count::default(); 4];
        for (mesh, repeat) in MESHES {
            let more = format!("technique = {:?}", technique.name());
            let scene = asset_scene(mesh, "letters", repeat, &more);
            let checker = Checker::new(&scene);
            for (kind, total) in totals.iter_mut().enumerate() {
                let view = checker.random_view(&mut random, kind);
                let label = format!("{mesh}, {more}, {view:?}");
                *total += checker.see(&label, &[view], [64, 48]);
            }
        }
        for (kind, total) in KINDS.iter().zip(totals) {
            println!("{}, {kind}: {total}", technique.name());
            assert_eq!(total.holes, 0, "{total}");
            seen.push((total, MOST_EXCUSED, 0));
        }
    }
    assert!(seen.len() >= 2 * KINDS.len());
    assert_nothing_wrong(&seen);
}

/// How much an ideal choice per triangle between the fast and the accurate tier
/// could leave to the fast one: pixels, and blocks of the size of a triangle.
#[test]
fn most_pixels_but_not_most_triangles_need_no_prisms() {
    const SIZE: [usize; 2] = [800, 600];
    const BLOCK: usize = 8;
    let pictures = [Tier::Fast, Tier::Accurate].map(|tier| {
        let object = object("../meshes/torus", "../patterns/discs", [24.0, 10.0], "");
        let text = format!("[camera]\neye = [0.0, 2.3, 3.4]\nfov = 38.0\n{object}");
        let mut scene = Scene::parse(&text, &asset("scenes/test.toml")).unwrap();
        scene.size = SIZE.map(|side| side as u32);
        scene.objects[0].tier = tier;
        let scene = prepare(&scene, &|_| ()).unwrap();
        let geometry = CpuRenderer::new(&scene).geometry(&scene.frame).unwrap();
        let pixel = DVec3::from(scene.frame.ray_right.map(f64::from)).length();
        (geometry, pixel)
    });
    let [(fast, _), (accurate, pixel)] = &pictures;
    // Error of a pixel, pixels along the ray.
    let error = |i: usize| {
        let [wrong, right] = [fast, accurate].map(|picture| {
            let t = f64::from(f32::from_bits(picture.place[i][0]));
            (picture.surface[i][0] & 0xff, t)
        });
        if wrong.0 != right.0 {
            f64::INFINITY
        } else if right.0 == CLASS_MISS {
            0.0
        } else {
            (wrong.1 - right.1).abs() / (right.1 * pixel)
        }
    };
    let is_hit = |i: usize| accurate.surface[i][0] & 0xff != CLASS_MISS;
    let [width, height] = SIZE;
    for tolerance in [0.1, 0.25, 0.5, 1.0, 2.0] {
        let (mut hits, mut right) = (0, 0);
        for i in (0..width * height).filter(|&i| is_hit(i)) {
            hits += 1;
            right += u32::from(error(i) <= tolerance);
        }
        let (mut blocks, mut right_blocks) = (0, 0);
        for corner in (0..height / BLOCK).flat_map(|y| (0..width / BLOCK).map(move |x| [x, y])) {
            let [x, y] = corner.map(|at| BLOCK * at);
            let pixels = || (0..BLOCK * BLOCK).map(|i| (y + i / BLOCK) * width + x + i % BLOCK);
            if pixels().any(is_hit) {
                blocks += 1;
                right_blocks += u32::from(pixels().all(|i| error(i) <= tolerance));
            }
        }
        let share = f64::from(right) / f64::from(hits);
        let share_of_blocks = f64::from(right_blocks) / f64::from(blocks);
        println!(
            "within {tolerance} pixels: {share:.3} of the pixels, {share_of_blocks:.3} of the blocks"
        );
        assert!(share_of_blocks < share && share < 1.0);
        assert!(tolerance < 1.0 || (share > 0.9 && share_of_blocks < 0.7));
    }
}

/// Prisms that do not know their neighbours are detected.
#[test]
fn a_torn_shell_has_holes() {
    let mut scene = asset_scene("torus", "discs", [24.0, 10.0], "");
    for data in Arc::make_mut(&mut scene.objects[0].prisms) {
        data.neighbours[0] = NO_NEIGHBOUR;
    }
    let view = Viewpoint::towards(DVec3::new(0.0, 2.3, 3.4), DVec3::ZERO, 38.0);
    let words = CpuRenderer::new(&scene)
        .geometry(&view.frame([64, 48]))
        .unwrap();
    let whole = asset_scene("torus", "discs", [24.0, 10.0], "");
    let count = Checker::new(&whole).check(&view.frame([64, 48]), &words, "torn");
    println!("torn: {count}");
    assert!(count.holes > 10, "{count}");
}

/// The renderer's own search in f64.
struct DoubleWalk<'a> {
    frame: double::layout::Frame,
    object: double::layout::Object,
    prisms: Vec<double::layout::PrismData>,
    texels: &'a [u32],
}

impl<'a> DoubleWalk<'a> {
    fn new(scene: &'a PreparedScene, frame: &Frame) -> DoubleWalk<'a> {
        let object = &scene.objects[0];
        DoubleWalk {
            frame: wide_frame(frame),
            object: wide_object(&object.parameters),
            prisms: object.prisms.iter().map(wide_prism).collect(),
            texels: object.map.words(),
        }
    }

    /// The nearest of all hits, from any side.
    fn trace(&self, ray: Ray) -> Sample {
        let is_near = |data: &double::layout::PrismData| {
            let centre = DVec3::from(data.anchor) + DVec3::from(data.centre);
            ray.in_ball(centre, data.radius).is_some()
        };
        let search = |home| {
            let ray = double::model::Ray {
                frame: &self.frame,
                object: &self.object,
                direction: ray.direction,
            };
            let home = double::model::prisms::Home {
                prisms: self.prisms.as_slice(),
                index: home,
            };
            double::trace::trace::<double::model::Prisms, _, _>(&ray, &home, self.texels, &()).hit
        };
        (0..)
            .zip(&self.prisms)
            .filter(|(_, data)| is_near(data))
            .map(|(home, _)| search(home))
            .map(|hit| Sample {
                class: hit.class,
                t: hit.t,
            })
            .filter(|sample| sample.is_hit())
            .min_by(|a, b| a.t.total_cmp(&b.t))
            .unwrap_or(Sample::MISS)
    }
}

/// Geometry words of `samples`.
fn words_of(samples: &[Sample], [width, height]: [u32; 2]) -> GeometryWords {
    GeometryWords {
        width,
        height,
        place: samples
            .iter()
            .map(|sample| [(sample.t as f32).to_bits(), 0, 0, 0])
            .collect(),
        surface: samples
            .iter()
            .map(|sample| [sample.class, 0, 0, 0])
            .collect(),
    }
}

#[test]
fn single_precision_agrees_with_double() {
    let size = [160, 120];
    let cases = [
        ("torus", "discs", [24.0, 10.0], [0.0, 2.3, 3.4], ""),
        (
            "torus",
            "letters",
            [9.0, 4.0],
            [1.3, 0.5, 0.6],
            "bevel = 0.08",
        ),
        ("sphere", "hexagons", [16.0, 8.0], [0.6, 0.9, 3.4], ""),
        ("cylinder", "discs", [16.0, 8.0], [3.4, 0.0, 3.4], ""),
        (
            "saddle",
            "hexagons",
            [6.0, 6.0],
            [1.6, 2.2, 2.2],
            "extension = 0.04",
        ),
        ("blob", "letters", [6.0, 5.0], [1.6, 1.3, 2.9], ""),
    ];
    let mut apart = 0;
    for (mesh, pattern, repeat, eye, more) in cases {
        let scene = asset_scene(mesh, pattern, repeat, more);
        let view = Viewpoint::towards(DVec3::from(eye), DVec3::ZERO, 38.0);
        let frame = view.frame(size);
        let single = CpuRenderer::new(&scene).geometry(&frame).unwrap();
        let walk = DoubleWalk::new(&scene, &frame);
        let wide = wide_frame(&frame);
        let place = |i: usize| ((i % size[0] as usize) as f64, (i / size[0] as usize) as f64);
        let samples: Vec<Sample> = (0..single.place.len())
            .into_par_iter()
            .map(|i| walk.trace(Ray::through(&wide, place(i).0, place(i).1)))
            .collect();
        let (mut excused, mut other_class) = (0, 0);
        for (i, sample) in samples.iter().enumerate() {
            let (class, t) = (
                single.class(i),
                f64::from(f32::from_bits(single.place[i][0])),
            );
            if agrees(*sample, class, t) {
                other_class += usize::from(class != sample.class);
            } else if is_excused(&wide, place(i), |ray| walk.trace(ray), class, t) {
                excused += 1;
            } else {
                println!(
                    "{mesh}: pixel {:?} of {view:?}: {sample:?} in f64, class {class} at {t} in f32",
                    place(i)
                );
                apart += 1;
            }
        }
        let eye = DVec3::from(wide.eye) + scene.origin;
        let truth = Truth::of(&MeshOracle::new(&scene), eye, &frame);
        let [single, double] =
            [single, words_of(&samples, size)].map(|words| truth.compare(&words));
        println!(
            "{mesh}, {pattern}: {excused} excused, {other_class} of another class; against the oracle IoU {:.6} in f32 and {:.6} in f64, {} and {} interior holes",
            single.silhouette_iou,
            double.silhouette_iou,
            single.interior_holes,
            double.interior_holes
        );
        assert!((single.silhouette_iou - double.silhouette_iou).abs() < 1e-4);
        assert!(single.interior_holes <= double.interior_holes);
        assert!(excused <= 2 && other_class <= 4, "{excused} {other_class}");
    }
    assert_eq!(apart, 0);
}

/// A corner of a mesh of these tests: position, texture coordinates, normal.
type Corner = (DVec3, [f64; 2], DVec3);

/// Writes triangles as an OBJ file; the program welds equal positions.
fn obj(triangles: &[[Corner; 3]]) -> String {
    let mut text = String::new();
    for (i, (p, uv, n)) in triangles.iter().flatten().enumerate() {
        writeln!(text, "v {} {} {}", p.x, p.y, p.z).unwrap();
        writeln!(text, "vt {} {}", uv[0], uv[1]).unwrap();
        writeln!(text, "vn {} {} {}", n.x, n.y, n.z).unwrap();
        if i % 3 == 2 {
            let corner = |i: usize| format!("{i}/{i}/{i}");
            let [a, b, c] = [i - 1, i, i + 1].map(corner);
            writeln!(text, "f {a} {b} {c}").unwrap();
        }
    }
    text
}

/// The two triangles of a quadrangle.
fn halves([a, b, c, d]: [Corner; 4]) -> [[Corner; 3]; 2] {
    [[a, b, c], [a, c, d]]
}

/// A cube of side 2 with hard edges; every face has the whole texture.
fn cube() -> Vec<[Corner; 3]> {
    let mut triangles = Vec::new();
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let n = DVec3::AXES[axis] * sign;
            let (x, y) = (
                DVec3::AXES[(axis + 1) % 3] * sign,
                DVec3::AXES[(axis + 2) % 3],
            );
            let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
                .map(|(u, v)| (n + x * (2.0 * u - 1.0) + y * (2.0 * v - 1.0), [u, v], n));
            triangles.extend(halves(corners));
        }
    }
    triangles
}

/// A cylinder around y with radius 1 and height 1, with caps and hard rims.
fn capped_cylinder() -> Vec<[Corner; 3]> {
    let count = 24;
    let mut triangles = Vec::new();
    for i in 0..count {
        let at = |i: usize, y: f64| {
            let u = i as f64 / count as f64;
            let (sin, cos) = (TAU * (i % count) as f64 / count as f64).sin_cos();
            let out = DVec3::new(cos, 0.0, -sin);
            ((out + DVec3::Y * y), [u, y + 0.5], out)
        };
        let [a, b, c, d] = [at(i, -0.5), at(i + 1, -0.5), at(i + 1, 0.5), at(i, 0.5)];
        triangles.extend(halves([a, b, c, d]));
        let lid = |(p, ..): Corner, n: DVec3| (p, [0.5 + 0.5 * p.x, 0.5 + 0.5 * p.z], n);
        let middle = |y: f64| DVec3::Y * y;
        let top = [(middle(0.5), [0.0; 2], DVec3::Y), d, c];
        let bottom = [(middle(-0.5), [0.0; 2], DVec3::Y), b, a];
        triangles.push(top.map(|corner| lid(corner, DVec3::Y)));
        triangles.push(bottom.map(|corner| lid(corner, -DVec3::Y)));
    }
    triangles
}

/// A bent sheet of 4 × 4 squares. `uv` gives texture coordinates from the
/// square's column and the place in the sheet.
fn sheet(uv: impl Fn(usize, [f64; 2]) -> [f64; 2]) -> Vec<[Corner; 3]> {
    let mut triangles = Vec::new();
    for column in 0..4 {
        for row in 0..4 {
            let corners = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(i, j)| {
                let [u, v] = [column + i, row + j].map(|x| x as f64 / 4.0);
                let (x, z) = (2.0 * u - 1.0, 1.0 - 2.0 * v);
                let normal = DVec3::new(-0.6 * x, 1.0, 0.3 * z).normalize();
                let place = DVec3::new(x, 0.3 * x * x - 0.15 * z * z, z);
                (place, uv(column, [u, v]), normal)
            });
            triangles.extend(halves(corners));
        }
    }
    triangles
}

/// Three triangles at one edge: a sheet of two with a fin on it.
fn fin() -> Vec<[Corner; 3]> {
    let p = [
        DVec3::new(-1.0, 0.0, 0.0),
        DVec3::new(1.0, 0.0, 0.0),
        DVec3::new(0.0, 0.2, 1.2),
        DVec3::new(0.0, 0.0, -1.2),
        DVec3::new(0.0, 1.2, -0.3),
    ];
    [[0, 2, 1], [0, 1, 3], [0, 1, 4]]
        .map(|triangle| {
            let [a, b, c] = triangle.map(|i| p[i]);
            let normal = (b - a).cross(c - a).normalize();
            [a, b, c].map(|p| (p, [0.5 * p.x, 0.5 * (p.z + p.y)], normal))
        })
        .to_vec()
}

impl Checker<'_> {
    /// Views of special places: over corners of triangles, along their edges,
    /// and in their planes.
    fn special_views(&self, count: usize) -> Vec<Viewpoint> {
        let stride = self.prisms.len().div_ceil(count);
        let mut views = Vec::new();
        for (data, prism) in self.prisms.iter().step_by(stride) {
            let hull = double::prism::cap_hull(data);
            let [a, b, c] = [hull[0], hull[1], hull[2]].map(|p| prism.anchor + p);
            let normal = DVec3::from(data.facet);
            let fov = 40.0;
            views.extend([
                Viewpoint::towards(a + 0.5 * DVec3::from(data.corner_normals[0]), a, fov),
                Viewpoint::towards(a + 0.3 * normal, a, fov),
                Viewpoint::towards(a + (a - b).normalize(), a, fov),
                Viewpoint::towards(a + (a - b).normalize() + 0.05 * normal, a, fov),
                Viewpoint::towards(a + (a - 0.5 * (b + c)).normalize(), c, fov),
                Viewpoint::towards(0.5 * (a + b) + 0.02 * normal, b, fov),
            ]);
        }
        views
    }
}

/// Whether the ray runs in the plane of the cap it hit, by the pixel's normal.
fn runs_along(ray: Ray, surface: [u32; 4]) -> bool {
    let [x, y, z] = [1, 2, 3].map(|i| f64::from(f32::from_bits(surface[i])));
    ray.direction.dot(DVec3::new(x, y, z)).abs() < 1e-6
}

/// Counts, the largest excused fraction, and the number of known wrong pixels.
type Seen = (Count, f64, usize);

/// Maximum number of known wrong rays per scene, from around and from special
/// places: a nearly tangential ray beside a hard rim, and one that leaves a
/// valley through the cap, which the second-order model sees too late. None is
/// on a smooth closed mesh.
const KNOWN_FROM_AROUND: usize = 2;
const KNOWN_FROM_SPECIAL_PLACES: usize = 6;

/// Asserts that only known rays are wrong and excuses are rare.
fn assert_nothing_wrong(seen: &[Seen]) {
    for (count, most_excused, known) in seen {
        assert!(count.wrong() <= *known, "{count}");
        assert!(count.hits > 1000, "{count}");
        count.assert_excuses(*most_excused);
    }
}

/// Renders a scene from around.
fn see_from_around(name: &str, checker: &Checker) -> Seen {
    let mut random = Random(5);
    let count = if is_long() { 24 } else { 8 };
    let views: Vec<Viewpoint> = (0..count)
        .map(|_| checker.random_view(&mut random, 0))
        .collect();
    let count = checker.see(name, &views, [64, 48]);
    println!("{name}, from around: {count}");
    (count, MOST_EXCUSED, KNOWN_FROM_AROUND)
}

/// Renders a scene from special places. The centre of a picture with odd sides
/// is the centre of a pixel.
fn see_from_special_places(name: &str, checker: &Checker) -> Seen {
    let triangles = if is_long() { 8 } else { 3 };
    let count = checker.see(name, &checker.special_views(triangles), [33, 25]);
    println!("{name}, from special places: {count}");
    (count, MOST_EXCUSED_IN_PLANES, KNOWN_FROM_SPECIAL_PLACES)
}

#[test]
fn borders_seams_and_hard_edges_have_no_holes() {
    let folder = Folder::new();
    let whole = |_: usize, uv: [f64; 2]| uv;
    let mirrored = |column: usize, [u, v]: [f64; 2]| [if column < 2 { u } else { 1.0 - u }, v];
    let seam = |column: usize, [u, v]: [f64; 2]| [if column < 2 { u } else { u + 0.37 }, v];
    let mut seen = Vec::new();
    for (name, triangles) in [
        ("cube", cube()),
        ("capped", capped_cylinder()),
        ("sheet", sheet(whole)),
        ("mirrored", sheet(mirrored)),
        ("seam", sheet(seam)),
        ("fin", fin()),
    ] {
        folder.mesh(name, &obj(&triangles));
        for (pattern, more) in [
            ("discs", ""),
            ("letters", "bevel = 0.05"),
            ("hexagons", "cut_out = true"),
        ] {
            let scene = folder.prepare(&object(name, pattern, [5.0, 4.0], more));
            let checker = Checker::new(&scene);
            let label = format!("{name}, {pattern}, {more:?}");
            seen.push(see_from_around(&label, &checker));
            // Within the fin the prisms overlap, and the oracle does not know
            // which one the ray is in.
            if name != "fin" {
                seen.push(see_from_special_places(&label, &checker));
            }
        }
    }
    for more in ["", "extension = 0.04", "cut_out = true"] {
        let scene = asset_scene("plane", "discs", [5.0, 5.0], more);
        let checker = Checker::new(&scene);
        let label = format!("plane, {more:?}");
        seen.push(see_from_around(&label, &checker));
        seen.push(see_from_special_places(&label, &checker));
    }
    assert_nothing_wrong(&seen);
}

/// The nearest of two objects wins, also where they overlap.
#[test]
fn objects_that_intersect_hide_each_other() {
    let ring = object("../meshes/torus", "../patterns/discs", [24.0, 10.0], "");
    let ball = object(
        "../meshes/sphere",
        "../patterns/letters",
        [8.0, 4.0],
        "scale = 0.8\ntranslate = [0.6, 0.1, 0.0]\nbevel = 0.05",
    );
    let scene = prepared(&format!("{ring}{ball}"), &asset("scenes/test.toml"));
    let (count, most_excused, _) = see_from_around("ring and ball", &Checker::new(&scene));
    assert_nothing_wrong(&[(count, most_excused, 0)]);
}

/// Errors of the accurate tier against closed forms: the rest is due to the
/// mesh, because the mesh oracle has it too.
#[test]
fn closed_forms_are_met_up_to_the_mesh() {
    for (mesh, repeat, eye, least) in [
        ("torus", [24.0, 10.0], [0.0, 2.3, 3.4], 0.9985),
        ("sphere", [16.0, 8.0], [0.6, 0.9, 3.4], 0.9985),
        ("cylinder", [16.0, 8.0], [3.4, 0.0, 3.4], 0.9995),
    ] {
        let text = object(
            &format!("../meshes/{mesh}"),
            "../patterns/discs",
            repeat,
            "",
        );
        let text =
            format!("[image]\nsize = [240, 180]\n[camera]\neye = {eye:?}\nfov = 38.0\n{text}");
        let scene = Scene::parse(&text, &asset("scenes/test.toml")).unwrap();
        let prepared = prepare(&scene, &|_| ()).unwrap();
        let frame = &prepared.frame;
        let eye = DVec3::from(frame.eye.map(f64::from)) + prepared.origin;
        let closed = AnalyticOracle::find(&scene.objects[0], &prepared.objects[0]).unwrap();
        let closed = Truth::of(&closed, eye, frame);
        let checker = Checker::new(&prepared);
        let words = CpuRenderer::new(&prepared).geometry(frame).unwrap();
        let count = checker.check(frame, &words, mesh);
        let best = words_of(
            &Truth::of(&checker.oracle, eye, frame).samples,
            prepared.size,
        );
        let [found, best] = [words, best].map(|words| closed.compare(&words));
        println!(
            "{mesh}: IoU {:.5}, {} interior holes; the oracle of the mesh {:.5}, {}; {count}",
            found.silhouette_iou, found.interior_holes, best.silhouette_iou, best.interior_holes
        );
        assert!(found.silhouette_iou >= least, "{mesh}: {found:?}");
        assert!(found.interior_holes <= best.interior_holes + count.excused);
        assert_eq!(count.wrong(), 0);
    }
}

/// A floor pixel that is dark among lit ones is no shadow: rays towards the light started
/// below the floor.
#[test]
fn floors_have_no_dark_specks() {
    for tier in ["fast", "accurate"] {
        for profile in ["", "technique = 'beveled'\nbevel = 0.05\n"] {
            let text = format!(
                "[[object]]\nmesh = '../meshes/torus.obj'\nshape = '../patterns/discs.png'\nrepeat = [24, 10]\ndepth = 0.1\ntier = '{tier}'\nself_shadow = true\n{profile}"
            );
            let mut scene = prepared(&text, &asset("scenes/test.toml"));
            let classes = CpuRenderer::new(&scene).geometry(&scene.frame).unwrap();
            let shadowed = CpuRenderer::new(&scene).color(&scene.frame).unwrap();
            scene.objects[0].parameters.self_shadow = 0;
            let plain = CpuRenderer::new(&scene).color(&scene.frame).unwrap();
            let [width, height] = scene.size.map(|side| side as usize);
            let is_floor = |i: usize| classes.class(i) == CLASS_FLOOR;
            let is_dark = |i: usize| shadowed.words[i] != plain.words[i];
            let (mut floors, mut dark, mut specks) = (0, 0, 0);
            for i in (1..height - 1).flat_map(|y| (1..width - 1).map(move |x| y * width + x)) {
                let beside = [i - width, i - 1, i + 1, i + width];
                if is_floor(i) && beside.into_iter().all(is_floor) {
                    floors += 1;
                    dark += usize::from(is_dark(i));
                    let lit = beside.into_iter().filter(|&other| !is_dark(other)).count();
                    specks += usize::from(is_dark(i) && lit > 2);
                }
            }
            println!("{tier} {profile:?}: {floors} floor pixels, {dark} dark, {specks} specks");
            assert!(floors > 1_000 && dark > 50, "{floors} {dark}");
            assert!(1_000 * specks <= floors, "{specks} of {floors}");
        }
    }
}
