use super::*;
use crate::layout::{FORMAT_CODES, Object, TIER_FAST};
use crate::path::{QuadraticPath, test_surface};
use crate::shape_map::tests::{FORMS, Random, Sample, cell_borders, least_value};
use crate::surface::Surface;
use crate::techniques::PROFILES;
use crate::{Vec2, Vec3};
use std::f64::consts::TAU;

/// Rounding, texels: texture coordinates up to 8 on maps of up to 40 texels
/// are wrong by a few 8 · 2⁻²⁴ · 40 = 2e-5, and the field rises by at most
/// 2.1 per texel.
const ROUNDING: f64 = 2e-4;

/// Straight in the texture and of second order in depth, without a cap: a
/// path whose minima are found in closed form.
#[derive(Clone, Copy, Debug)]
struct TestPath {
    uv: Vec2,
    velocity: Vec2,
    slope: Real,
    bend: Real,
    depth: Real,
    start: Real,
    end: Real,
    ends_on_floor: bool,
}

impl TestPath {
    /// Of a ray along `direction` over a quadric that bends it by `bend`.
    fn new(surface: &Surface, direction: Vec3, bend: Real, facet_t: Real, depth: Real) -> Self {
        let slope = max(-direction.z, 0.0);
        let radicand = slope * slope - 4.0 * bend * depth;
        let sum = slope + sqrt(max(radicand, 0.0));
        let ends_on_floor = radicand >= 0.0 && sum > 0.0;
        TestPath {
            uv: surface.uv,
            velocity: Vec2::new(
                direction.dot(surface.gradient_u),
                direction.dot(surface.gradient_v),
            ),
            slope,
            bend,
            depth,
            start: max(-facet_t, 0.0),
            end: if ends_on_floor {
                2.0 * depth / sum
            } else if bend > 0.0 {
                slope / bend
            } else {
                0.0
            },
            ends_on_floor,
        }
    }
}

impl Path for TestPath {
    fn uv(&self, s: Real) -> Vec2 {
        self.uv + self.velocity * s
    }
    fn depth_fraction(&self, s: Real) -> Real {
        s * (self.slope - self.bend * s) / self.depth
    }
    fn uv_rates(&self) -> (Vec2, Vec2) {
        (self.velocity, self.velocity)
    }
    fn is_even(&self) -> bool {
        true
    }
    fn depth_rate(&self) -> Real {
        max(self.slope, self.slope - 2.0 * self.bend * self.end) / self.depth
    }
    fn start(&self) -> Real {
        self.start
    }
    fn end(&self) -> Real {
        self.end
    }
    fn ends_on_floor(&self) -> bool {
        self.ends_on_floor
    }
}

/// A path over a map with a profile, and what they are in f64.
struct Scene {
    sample: Sample,
    profile: Profile,
    path: TestPath,
    depth: f64,
    /// How far before the solid the march may end, texels.
    slack: f32,
}

impl Scene {
    /// Flat or bent, into the surface or along it, with one of the four extrusions.
    fn random(random: &mut Random, mut sample: Sample) -> Scene {
        let width = f64::from(sample.object.map_size[0]);
        let depth = random.magnitude(1e-2, 1e2);
        // Texels that a grown column may spread by.
        let spread = |random: &mut Random| random.magnitude(0.05, 20.0) / width;
        let extension = random.choose(&[0.0, 0.0, 1.0, -0.2]) * spread(random);
        let bevel = random.choose(&[0.0, 1.0, 1.0]) * spread(random);
        let below = random.within(0.05, 0.95);
        let chamfer = random.choose(&[1.0, below]);
        sample.object = Object {
            extension: extension as f32,
            bevel: bevel as f32,
            chamfer: chamfer as f32,
            ..sample.object
        }
        .complete();
        let q = random.choose(&[0.0, 0.02, 0.2, 2.0]) * random.within(-1.0, 1.0) / depth;
        let z = random.choose(&[0.02, 0.3, 1.0]) * random.within(-0.2, 1.0);
        let angle = random.within(0.0, TAU);
        let tangential = (1.0 - z * z).sqrt();
        // Repeats of the map per depth of the shell.
        let scale = random.magnitude(0.01, 3.0) / depth;
        let gradient = |random: &mut Random| {
            Vec3::new(
                (scale * random.within(-1.0, 1.0)) as f32,
                (scale * random.within(-1.0, 1.0)) as f32,
                0.0,
            )
        };
        let surface = Surface {
            uv: Vec2::new(
                random.within(0.0, 1.0) as f32,
                random.within(0.0, 1.0) as f32,
            ),
            gradient_u: gradient(random),
            gradient_v: gradient(random),
            ..test_surface([0.0; 3], 0.0)
        };
        let direction = Vec3::new(
            (tangential * angle.cos()) as f32,
            (tangential * angle.sin()) as f32,
            -z as f32,
        );
        // Sometimes the eye is inside the shell.
        let facet_t = random.choose(&[3.0, 1.0, 0.0, -0.3]) * depth;
        let bend = (q * tangential * tangential) as f32;
        let path = TestPath::new(&surface, direction, bend, facet_t as f32, depth as f32);
        Scene {
            profile: Profile::new(&sample.object),
            sample,
            path,
            depth: f64::from(depth as f32),
            slack: (random.choose(&[0.0, 0.0, 1.0]) * random.magnitude(0.01, 5.0)) as f32,
        }
    }

    /// Whether f32 can hold the texture coordinates that it leads through.
    fn in_range(&self) -> bool {
        self.path.start() < self.path.end()
            && self.path.uv(0.0).abs().max_element() < 8.0
            && self.path.uv(self.path.end()).abs().max_element() < 8.0
    }

    fn march(&self, linear_steps: u32, binary_steps: u32) -> March {
        let map = self.sample.map();
        march(
            &self.path,
            &self.profile,
            &map,
            &self.sample.words[..],
            &Limits {
                linear_steps,
                binary_steps,
                slack: self.slack,
            },
        )
    }

    fn uv(&self, s: f64) -> [f64; 2] {
        let (uv, velocity) = (self.path.uv, self.path.velocity);
        [
            f64::from(uv.x) + f64::from(velocity.x) * s,
            f64::from(uv.y) + f64::from(velocity.y) * s,
        ]
    }

    fn depth_fraction(&self, s: f64) -> f64 {
        s * (f64::from(self.path.slope) - f64::from(self.path.bend) * s) / self.depth
    }

    /// g of section 2, texels.
    fn gap(&self, s: f64) -> f64 {
        let [x, y] = self.sample.texel_of(self.uv(s));
        let object = &self.sample.object;
        let [extension, bevel] =
            [object.extension, object.bevel].map(|widths| f64::from(widths * object.map_size[0]));
        let grown = self
            .depth_fraction(s)
            .clamp(0.0, 1.0)
            .min(f64::from(object.chamfer));
        self.sample.at(x, y) - extension - bevel * grown
    }

    /// The least g between the start and `end`.
    fn least_gap(&self, end: f64) -> f64 {
        let start = f64::from(self.path.start());
        let [from, to] = [start, end].map(|s| self.sample.texel_of(self.uv(s)));
        let mut borders: Vec<f64> = cell_borders(from, [to[0] - from[0], to[1] - from[1]])
            .iter()
            .map(|fraction| start + fraction * (end - start))
            .collect();
        // The growth stops where δ = c, and δ itself is clamped to 0 and 1.
        let (slope, bend) = (f64::from(self.path.slope), f64::from(self.path.bend));
        for level in [0.0, f64::from(self.sample.object.chamfer), 1.0] {
            let root = (slope * slope - 4.0 * bend * level * self.depth)
                .max(0.0)
                .sqrt();
            borders.push(2.0 * level * self.depth / (slope + root));
            borders.push((slope + root) / (2.0 * bend));
        }
        borders.retain(|s| *s >= start && *s <= end);
        borders.sort_by(f64::total_cmp);
        least_value(&borders, |s| self.gap(s))
    }
}

/// What a crowd of random marches did wrong, in texels.
#[derive(Debug, Default)]
struct Errors {
    /// Marches of each kind of end.
    ends: [u32; 4],
    /// How deep in the solid a march has been before it ended.
    passed_through: f64,
    /// How far over the tolerance a reported hit lay off the solid.
    off_the_solid: f64,
    /// The scene of the worst of these.
    worst: String,
}

fn errors(seed: u64, count: u32, change: impl Fn(&mut Scene)) -> Errors {
    let mut random = Random(seed);
    let mut errors = Errors::default();
    let mut sample = Sample::random(&mut random);
    for number in 0..count {
        // The plain distance transform takes longer than a march.
        if number % 50 == 0 {
            sample = Sample::random(&mut random);
        }
        let mut scene = Scene::random(&mut random, sample.clone());
        if !scene.in_range() {
            continue;
        }
        change(&mut scene);
        // No march can be longer: each step is at least as safe as TOLERANCE is.
        let found = scene.march(1_000_000, random.whole(0, 12));
        assert!(found.steps < 1_000_000);
        assert!(found.s >= scene.path.start() && found.s <= scene.path.end());
        assert_eq!(found.uv, scene.path.uv(found.s));
        errors.ends[found.end as usize] += 1;
        let s = f64::from(found.s);
        let start = f64::from(scene.path.start());
        let gap = scene.gap(s);
        let off = match found.end {
            END_CAP => gap,
            END_SIDE if found.steps == 0 => gap,
            END_SIDE => gap - f64::from(TOLERANCE.max(scene.slack)),
            _ => 0.0,
        };
        let passed = if found.steps == 0 {
            0.0
        } else {
            -scene.least_gap(s)
        };
        if off > errors.off_the_solid.max(ROUNDING) || passed > errors.passed_through.max(ROUNDING)
        {
            errors.worst = format!(
                "{found:?} g = {gap} {:?} {:?} {} × {} in format {} with steps of {}",
                scene.path,
                scene.profile,
                scene.sample.width,
                scene.sample.height,
                scene.sample.object.map_format,
                scene.sample.object.map_step
            );
        }
        errors.off_the_solid = errors.off_the_solid.max(off);
        errors.passed_through = errors.passed_through.max(passed);

        assert_eq!(
            found.end == END_CAP,
            found.steps == 0 && start == 0.0 && gap <= ROUNDING
        );
        assert_eq!(
            found.end == END_FLOOR,
            found.end != END_MISS
                && found.s == scene.path.end()
                && scene.path.ends_on_floor()
                && found.depth_fraction == 1.0
        );
        if found.end == END_SIDE || found.end == END_CAP {
            let expected = scene.depth_fraction(s).clamp(0.0, 1.0);
            assert!((f64::from(found.depth_fraction) - expected).abs() < 1e-5);
        }
    }
    errors
}

/// The first point of the solid is never passed, and no hit is reported
/// before the ray is as near as [`TOLERANCE`] or the slack: g is minimised
/// exactly, from one cell of the map to the next.
#[test]
fn the_first_hit_is_found() {
    let errors = errors(1, 100_000, |_| ());
    println!("{errors:?}");
    assert!(errors.ends.iter().all(|&count| count > 1_000), "{errors:?}");
    assert!(errors.passed_through <= ROUNDING, "{errors:?}");
    assert!(errors.off_the_solid <= ROUNDING, "{errors:?}");
}

/// The check above sees a march that strides through the solid: here over
/// maps three times as steep as distances are.
#[test]
fn a_steeper_field_would_be_passed_through() {
    let errors = errors(2, 10_000, |scene| {
        if scene.sample.object.map_format == FORMAT_CODES {
            scene.sample.steepen(3.0);
        }
    });
    assert!(errors.passed_through > 100.0 * ROUNDING, "{errors:?}");
}

/// A path that is bent in the texture, too, passes nothing either: here no
/// sample before the hit lies in the solid.
#[test]
fn a_bent_path_passes_nothing() {
    let mut random = Random(3);
    let (mut sides, mut bent) = (0, 0);
    for _ in 0..10_000 {
        let sample = Sample::random(&mut random);
        let scale = random.magnitude(0.05, 2.0);
        let mut number = || (scale * random.within(-1.0, 1.0)) as f32;
        let surface = Surface {
            uv: Vec2::new(number(), number()),
            gradient_u: Vec3::new(number(), number(), 0.0),
            gradient_v: Vec3::new(number(), number(), 0.0),
            uv_bend: Vec2::new(number(), number()),
            ..test_surface([number(), number(), number()], 0.0)
        };
        let z = random.within(0.05, 1.0);
        let angle = random.within(0.0, TAU);
        let tangential = (1.0 - z * z).sqrt();
        let direction = Vec3::new(
            (tangential * angle.cos()) as f32,
            (tangential * angle.sin()) as f32,
            -z as f32,
        );
        let path = QuadraticPath::new(&surface, direction, 1.0, 0.3, TIER_FAST);
        let object = Object {
            bevel: (random.magnitude(0.05, 5.0) / f64::from(sample.object.map_size[0])) as f32,
            chamfer: random.within(0.05, 1.0) as f32,
            profile: random.whole(0, PROFILES - 1),
            parts: random.whole(1, 5),
            ..sample.object
        }
        .complete();
        let profile = Profile::new(&object);
        let found = march(
            &path,
            &profile,
            &sample.map(),
            &sample.words[..],
            &Limits {
                linear_steps: 10_000,
                binary_steps: 10,
                slack: 0.0,
            },
        );
        if found.end == END_CAP {
            continue;
        }
        sides += u32::from(found.end == END_SIDE);
        bent += u32::from(path.uv_bend.length() * path.end() > 0.2 * path.velocity.length());
        for i in 1..200 {
            let s = f64::from(found.s) * f64::from(i) / 200.0;
            let uv = path.uv(s as f32);
            let [x, y] = sample.texel_of([uv.x, uv.y].map(f64::from));
            let radius = profile.radius(clamp(path.depth_fraction(s as f32), 0.0, 1.0));
            let gap = sample.at(x, y) - f64::from(radius);
            // The hit is refined to one texel in a hundred or so.
            assert!(gap >= -2e-3, "{gap} {i} {found:?} {path:?}");
        }
    }
    println!("{sides} sides, {bent} bent");
    assert!(sides > 1_000 && bent > 1_000, "{sides} {bent}");
}

/// Columns of 8 texels in a map of 16 (the rows are alike): u = 0…½ is pattern.
fn columns() -> Sample {
    let pattern: Vec<bool> = (0..16 * 4).map(|i| i % 16 < 8).collect();
    Sample::of_pattern(16, &pattern, FORMS[0])
}

/// A ray in the plane of x and z over a flat or bent surface, 1 deep, one
/// repeat per unit, that meets the facet at u = `u` with slope `v_z`.
fn ray(u: f32, v_z: f32, quadric: f32, facet_t: f32) -> QuadraticPath {
    let surface = Surface {
        uv: Vec2::new(u, 0.5),
        ..test_surface([quadric, 0.0, 0.0], 0.0)
    };
    let v_x = (1.0 - v_z * v_z).sqrt();
    QuadraticPath::new(&surface, Vec3::new(v_x, 0.0, -v_z), facet_t, 1.0, TIER_FAST)
}

fn march_columns(path: &QuadraticPath, linear_steps: u32) -> March {
    let sample = columns();
    let profile = Profile::new(&sample.object);
    march(
        path,
        &profile,
        &sample.map(),
        &sample.words[..],
        &Limits {
            linear_steps,
            binary_steps: 10,
            slack: 0.0,
        },
    )
}

#[test]
fn the_kinds_of_end() {
    // On the pattern: the cap, at once.
    let cap = march_columns(&ray(0.25, 0.6, 0.0, 1.0), 100);
    assert_eq!((cap.end, cap.s, cap.steps), (END_CAP, 0.0, 0));
    assert_eq!(cap.depth_fraction, 0.0);
    // Between the columns: the wall at u = 1, 0.8 along for every unit of s.
    let side = march_columns(&ray(0.6, 0.6, 0.0, 1.0), 100);
    assert_eq!(side.end, END_SIDE);
    assert!((side.s - 0.5).abs() < 2e-3, "{side:?}");
    assert!((side.depth_fraction - 0.3).abs() < 2e-3, "{side:?}");
    // Steeper: the floor, 1 / 0.98 along the ray.
    let floor = march_columns(&ray(0.6, 0.98, 0.0, 1.0), 100);
    assert_eq!((floor.end, floor.depth_fraction), (END_FLOOR, 1.0));
    assert!((floor.s - 1.0 / 0.98).abs() < 1e-6);
    // Straight down: the floor in one step.
    let down = march_columns(&ray(0.75, 1.0, 0.0, 1.0), 100);
    assert_eq!((down.end, down.s, down.steps), (END_FLOOR, 1.0, 1));
    // Over a surface that falls away fast: out again before the next column.
    let miss = march_columns(&ray(0.6, 0.3, 3.0, 1.0), 100);
    assert_eq!((miss.end, miss.depth_fraction), (END_MISS, 0.0));
    assert!((miss.s - 0.3 / (3.0 * 0.91 + 0.25 * 0.09)).abs() < 1e-6);
    // The same surface would have a floor at this depth, but behind the exit.
    assert!(miss.s < 0.4);
}

#[test]
fn steps_that_run_out_are_a_hit() {
    let path = ray(0.6, 0.6, 0.0, 1.0);
    let none = march_columns(&path, 0);
    assert_eq!((none.end, none.s, none.steps), (END_SIDE, 0.0, 0));
    let one = march_columns(&path, 1);
    assert_eq!((one.end, one.steps), (END_SIDE, 1));
    assert!(one.s > 0.0 && one.s < 0.5);
    assert_eq!(one.depth_fraction, path.depth_fraction(one.s));
}

#[test]
fn the_eye_inside_the_shell() {
    // 0.3 units before the eye the ray came through the cap, on the pattern…
    let inside = march_columns(&ray(0.25, 0.6, 0.0, -0.3), 100);
    assert_eq!((inside.end, inside.s, inside.steps), (END_SIDE, 0.3, 0));
    assert!((inside.depth_fraction - 0.18).abs() < 1e-6);
    // …or beside it: the first wall before the eye counts, not one behind it.
    let before = march_columns(&ray(0.4, 0.6, 0.0, -0.3), 100);
    assert_eq!(before.end, END_SIDE);
    assert!((before.s - 0.75).abs() < 2e-3, "{before:?}");
    // Below the floor there is nothing to search.
    let below = march_columns(&ray(0.6, 0.6, 0.0, -2.5), 100);
    assert_eq!((below.end, below.steps), (END_FLOOR, 0));
}
