//! Rays in the shell: paths, prisms and searches.

use super::Function;
use super::sample::{
    SIDE, Sample, descending, disc, disc_object, either_sign, error, magnitude, signed, unit,
    vector_error,
};
use fastrand::Rng;
use glam::{Vec2, Vec3};
use relievo::oracle::wide::{wide_object, wide_prism, wide_surface};
use relievo_shared as single;
use relievo_shared::layout::{PrismData, TIER_FAST};
use relievo_shared::path::Path as _;
use relievo_shared::surface::Surface;
use relievo_shared_f64 as double;
use relievo_shared_f64::path::Path as _;
use std::sync::LazyLock;

pub(super) static LIST: &[Function] = &[
    Function {
        name: "path: end",
        over: "V_z",
        relative_to: "the end",
        exponents: [-40, 0],
        stride: 8,
        bound: DOUBLE_ROOT,
        others: 1e-4,
        sample: |rng, v_z| over_slope(rng, v_z, Part::End),
    },
    Function {
        name: "path: depth fraction",
        over: "V_z",
        relative_to: "1",
        exponents: [-40, 0],
        stride: 8,
        bound: 2e-6,
        others: 1e-4,
        sample: |rng, v_z| over_slope(rng, v_z, Part::DepthFraction),
    },
    Function {
        name: "path: texture coordinates",
        over: "V_z",
        relative_to: "how far they run",
        exponents: [-40, 0],
        stride: 8,
        bound: 3e-7,
        others: 1e-4,
        sample: |rng, v_z| over_slope(rng, v_z, Part::TextureCoordinates),
    },
    Function {
        name: "path: end",
        over: "|q| S_z",
        relative_to: "the end",
        exponents: [-60, 12],
        stride: 12,
        bound: DOUBLE_ROOT,
        others: 1e-4,
        sample: |rng, bend| over_curvature(rng, bend, Part::End),
    },
    Function {
        name: "path: depth fraction",
        over: "|q| S_z",
        relative_to: "1",
        exponents: [-60, 12],
        stride: 12,
        bound: 2e-6,
        others: 1e-4,
        sample: |rng, bend| over_curvature(rng, bend, Part::DepthFraction),
    },
    Function {
        name: "path: entry",
        over: "δ0 / S_z",
        relative_to: "the entry",
        exponents: [-32, 0],
        stride: 8,
        bound: DOUBLE_ROOT,
        others: 1e-4,
        sample: over_facet_depth,
    },
    Function {
        name: "march: where the disc is met",
        over: "V_z",
        relative_to: "1 texel of 32",
        exponents: [-20, 0],
        stride: 4,
        bound: 5e-3,
        others: 1e-3,
        sample: |rng, v_z| search(rng, v_z, Way::March),
    },
    Function {
        name: "relief: where the disc is met",
        over: "V_z",
        relative_to: "1 texel of 32",
        exponents: [-20, 0],
        stride: 4,
        bound: 5e-3,
        others: 2e-3,
        sample: |rng, v_z| search(rng, v_z, Way::Relief),
    },
    Function {
        name: "paper: where the disc is met",
        over: "V_z",
        relative_to: "1 texel of 32",
        exponents: [-20, 0],
        stride: 4,
        bound: 0.5,
        // Its own formulas lose all digits along the surface.
        others: 0.1,
        sample: |rng, v_z| search(rng, v_z, Way::Paper),
    },
    Function {
        name: "prism: parameters of a point",
        over: "the depth in triangles",
        relative_to: "1",
        exponents: [-20, 0],
        stride: 4,
        bound: 1e-6,
        others: 0.0,
        sample: prism,
    },
    Function {
        name: "prism: motion of a ray",
        over: "the depth in triangles",
        relative_to: "the speed, and the acceleration beside it",
        exponents: [-9, 0],
        stride: 3,
        bound: 1e-5,
        others: 0.0,
        sample: motion,
    },
    Function {
        name: "walk: where the disc is met",
        over: "V_z at the cap",
        relative_to: "1 texel of 32",
        exponents: [-12, 0],
        stride: 3,
        bound: 0.5,
        others: 5e-3,
        sample: walk,
    },
];

/// Tolerance at distance 1.
const TOLERANCE: f32 = 1.0 / 1024.0;

/// √2⁻²⁴: where a ray is nearly tangent to floor or cap, the two roots nearly
/// coincide, and rounding the discriminant moves them by its square root.
const DOUBLE_ROOT: f64 = 2.441_406_25e-4;

static DISC: LazyLock<Vec<u32>> = LazyLock::new(disc);

/// Results of a path.
#[derive(Clone, Copy)]
enum Part {
    End,
    DepthFraction,
    TextureCoordinates,
}

/// A ray over a quadric.
struct Ray {
    surface: Surface,
    direction: Vec3,
    depth: f32,
}

impl Ray {
    /// Creates a descending ray of slope `v_z` over a surface with curvature
    /// `bend` = q S_z along the ray, and at most as much across it.
    fn new(rng: &mut Rng, v_z: f64, bend: f64, facet_depth: f64) -> Ray {
        let depth = magnitude(rng, 1e-3, 1.0);
        let direction = descending(rng, v_z);
        let wide = direction.as_dvec3();
        let along = wide.truncate().normalize_or(glam::DVec2::X);
        let across = along.perp();
        let tangential = wide.truncate().length_squared().max(1e-6);
        let q = bend / depth / tangential;
        let other = q * signed(rng);
        // q along ⊗ along + other across ⊗ across.
        let quadric = [
            q * along.x * along.x + other * across.x * across.x,
            2.0 * (q * along.x * along.y + other * across.x * across.y),
            q * along.y * along.y + other * across.y * across.y,
        ];
        Ray {
            surface: single::path::test_surface(
                quadric.map(|x| x as f32),
                (facet_depth * depth) as f32,
            ),
            direction,
            depth: depth as f32,
        }
    }

    fn paths(&self) -> (single::path::QuadraticPath, double::path::QuadraticPath) {
        (
            single::path::QuadraticPath::new(
                &self.surface,
                self.direction,
                1.0,
                self.depth,
                TIER_FAST,
            ),
            double::path::QuadraticPath::new(
                &wide_surface(&self.surface),
                self.direction.as_dvec3(),
                1.0,
                f64::from(self.depth),
                TIER_FAST,
            ),
        )
    }

    fn compare(&self, part: Part) -> Sample {
        let (found, expected) = self.paths();
        if !found.enters && !expected.enters {
            return Sample::Unfit;
        }
        if found.enters != expected.enters || found.ends_on_floor() != expected.ends_on_floor() {
            return Sample::Other;
        }
        if matches!(part, Part::End) {
            return match expected.end() {
                0.0 => Sample::Error(f64::from(found.end().abs())),
                end => Sample::Error(error(found.end(), end, end)),
            };
        }
        let at = |share: f32| {
            let s = found.end() * share;
            let wide = f64::from(s);
            match part {
                Part::DepthFraction => {
                    error(found.depth_fraction(s), expected.depth_fraction(wide), 1.0)
                }
                _ => {
                    let apart = (found.uv(s).as_dvec2() - expected.uv(wide)).length();
                    apart / (expected.uv(wide).length() + wide).max(1e-30)
                }
            }
        };
        Sample::Error(at(0.3).max(at(0.7)).max(at(1.0)))
    }
}

fn over_slope(rng: &mut Rng, v_z: f64, part: Part) -> Sample {
    let size = [0.0, magnitude(rng, 1e-6, 0.1)][rng.usize(..2)];
    let bend = either_sign(rng, size);
    Ray::new(rng, v_z, bend, 0.0).compare(part)
}

fn over_curvature(rng: &mut Rng, bend: f64, part: Part) -> Sample {
    let v_z = magnitude(rng, 1e-3, 1.0);
    let bend = either_sign(rng, bend);
    Ray::new(rng, v_z, bend, 0.0).compare(part)
}

fn over_facet_depth(rng: &mut Rng, facet_depth: f64) -> Sample {
    let v_z = magnitude(rng, 0.05, 1.0);
    let size = magnitude(rng, 1e-6, 0.1);
    let bend = either_sign(rng, size);
    let facet_depth = either_sign(rng, facet_depth);
    let (found, expected) = Ray::new(rng, v_z, bend, facet_depth).paths();
    if found.enters != expected.enters {
        return Sample::Other;
    }
    if !found.enters || expected.entry_from_facet == 0.0 {
        return Sample::Unfit;
    }
    let entry = expected.entry_from_facet;
    Sample::Error(error(found.entry_from_facet, entry, entry.abs()))
}

/// Results of two searches.
struct Ends {
    ends: [u32; 2],
    /// Distance between the hits, texels.
    apart: f64,
}

impl Ends {
    /// Whether both hit the same column, or neither hits.
    fn compare(self) -> Sample {
        if self.ends[0] != self.ends[1] || self.apart > 0.5 {
            Sample::Other
        } else {
            Sample::Error(self.apart)
        }
    }
}

/// Searches along a path.
#[derive(Clone, Copy)]
enum Way {
    March,
    Relief,
    Paper,
}

fn search(rng: &mut Rng, v_z: f64, way: Way) -> Sample {
    let size = magnitude(rng, 1e-3, 0.1);
    let bend = either_sign(rng, size);
    let mut ray = Ray::new(rng, v_z, bend, 0.0);
    ray.surface.uv = Vec2::new(rng.f32(), rng.f32());
    let object = disc_object(ray.depth);
    let wide = wide_object(&object);
    let (path, wide_path) = ray.paths();
    let (steps, bisections) = (object.linear_steps, object.binary_steps);
    let profile = single::profile::Profile::new(&object);
    let wide_profile = double::profile::Profile::new(&wide);
    let map = single::shape_map::ShapeMap::new(&object);
    let wide_map = double::shape_map::ShapeMap::new(&wide);
    let texels = &DISC[..];
    let (found, expected) = match way {
        Way::March => {
            let effort = single::march::Limits {
                linear_steps: steps,
                binary_steps: bisections,
                slack: 0.0,
            };
            let wide_effort = double::march::Limits {
                linear_steps: steps,
                binary_steps: bisections,
                slack: 0.0,
            };
            (
                single::march::march(&path, &profile, &map, texels, &effort),
                double::march::march(&wide_path, &wide_profile, &wide_map, texels, &wide_effort),
            )
        }
        Way::Relief => (
            single::model::relief::search(&path, &profile, &map, texels, steps, bisections),
            double::model::relief::search(
                &wide_path,
                &wide_profile,
                &wide_map,
                texels,
                steps,
                bisections,
            ),
        ),
        Way::Paper => (
            single::model::paper::search(&object, &map, texels, &ray.surface, ray.direction),
            double::model::paper::search(
                &wide,
                &wide_map,
                texels,
                &wide_surface(&ray.surface),
                ray.direction.as_dvec3(),
            ),
        ),
    };
    Ends {
        ends: [found.end, expected.end],
        apart: (found.uv.as_dvec2() - expected.uv).length() * f64::from(SIDE),
    }
    .compare()
}

/// Motion of a ray in a prism.
fn motion(rng: &mut Rng, depth: f64) -> Sample {
    let data = single::kernels::prism_data(unit(rng).as_vec3(), unit(rng).as_vec3());
    let depth = depth as f32;
    let first = rng.f32();
    let x = Vec3::new(first, rng.f32() * (1.0 - first), rng.f32());
    let direction = unit(rng).as_vec3();
    let prism = single::prism::Prism::new(&data, depth);
    let wide = double::prism::Prism::new(&wide_prism(&data), f64::from(depth));
    let jacobian = prism.jacobian(x);
    let wide_jacobian = wide.jacobian(x.as_dvec3());
    if jacobian.regular != wide_jacobian.regular {
        return Sample::Other;
    }
    if !jacobian.regular {
        return Sample::Unfit;
    }
    let found = prism.motion(x, &jacobian, direction);
    let expected = wide.motion(x.as_dvec3(), &wide_jacobian, direction.as_dvec3());
    let speed = expected.velocity.length();
    let turn = expected.acceleration.length();
    // Over a distance of one depth.
    let velocity = vector_error(found.velocity, expected.velocity, speed);
    Sample::Error(velocity.max(vector_error(
        found.acceleration,
        expected.acceleration,
        turn + speed,
    )))
}

fn prism(rng: &mut Rng, depth: f64) -> Sample {
    let data = single::kernels::prism_data(unit(rng).as_vec3(), unit(rng).as_vec3());
    let depth = depth as f32;
    let first = rng.f32();
    let x = Vec3::new(first, rng.f32() * (1.0 - first), rng.f32());
    let prism = single::prism::Prism::new(&data, depth);
    let wide = double::prism::Prism::new(&wide_prism(&data), f64::from(depth));
    let target = prism.point(x);
    let start = Vec3::new(0.25, 0.25, 0.5);
    let (found, _) = prism.solve(target, start, 8);
    let (expected, _) = wide.solve(target.as_dvec3(), start.as_dvec3(), 8);
    // Depth is a fraction: its rounding is relative to the depth.
    let apart = (found.as_dvec3() - expected).abs();
    Sample::Error(apart.x.max(apart.y).max(apart.z * f64::from(depth)))
}

/// A prism with open sides.
struct Alone<S>(S);

impl single::walk::PrismList for Alone<PrismData> {
    fn prism(&self, _: u32) -> &PrismData {
        &self.0
    }
}

impl double::walk::PrismList for Alone<double::layout::PrismData> {
    fn prism(&self, _: u32) -> &double::layout::PrismData {
        &self.0
    }
}

fn walk(rng: &mut Rng, v_z: f64) -> Sample {
    let data = single::kernels::prism_data(unit(rng).as_vec3(), unit(rng).as_vec3());
    let object = disc_object(magnitude(rng, 0.01, 0.25) as f32);
    let wide = wide_object(&object);
    let direction = descending(rng, v_z);
    let first = 0.1 + 0.6 * rng.f32();
    let prism = single::prism::Prism::new(&data, object.depth);
    let target = prism.point(Vec3::new(first, 0.1 + (0.8 - first) * rng.f32(), 0.0));
    let eye = target - direction * 4.0;
    let found = single::walk::search(
        &single::walk::Field {
            prisms: &Alone(data),
            object: &object,
            tolerance: TOLERANCE,
            slack: 0.0,
            texels: &DISC[..],
            binary_steps: object.binary_steps,
        },
        0,
        eye,
        direction,
    );
    let expected = double::walk::search(
        &double::walk::Field {
            prisms: &Alone(wide_prism(&data)),
            object: &wide,
            tolerance: f64::from(TOLERANCE),
            slack: 0.0,
            texels: &DISC[..],
            binary_steps: object.binary_steps,
        },
        0,
        eye.as_dvec3(),
        direction.as_dvec3(),
    );
    let (found, expected) = (found.march, expected.march);
    Ends {
        ends: [found.end, expected.end],
        apart: (found.uv.as_dvec2() - expected.uv).length() * f64::from(SIDE),
    }
    .compare()
}
