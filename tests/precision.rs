//! The f32 arithmetic against the same sources compiled in f64, with the same
//! inputs: results may differ by rounding only.
//!
//! The domain is well conditioned: triangles of a sphere that span some
//! degrees, seen from a few radii away, not from the side. Every comparison
//! must detect a perturbation of 1e-3 of the f64 inputs.

use relievo::oracle::wide::{wide_frame, wide_object, wide_surface, wide_triangle};
use relievo_shared as single;
use relievo_shared::model::Model as _;
use relievo_shared_f64 as double;
use relievo_shared_f64::model::Model as _;
use relievo_tests::Random;
use single::path::Path as _;
use std::collections::BTreeMap;

type Triangle = single::layout::Triangle;
type Object = single::layout::Object;
type Frame = single::layout::Frame;

/// Compared quantities and their largest differences, relative to the size of
/// the values: about four times the largest measured.
const BOUNDS: [(&str, f64); 14] = [
    ("facet: distance", 1.5e-6),
    ("facet: weights", 1.6e-5),
    ("surface: normal, tangent, bitangent", 1e-6),
    ("surface: quadric, uv, gradients", 7e-7),
    ("surface: facet depth", 2.5e-7),
    ("path: entry, slope, bend, end", 3e-5),
    ("path: texture coordinates", 5e-7),
    ("path: depth fraction", 1e-6),
    ("shape map: distance", 1.5e-7),
    ("shape map: gradient", 2.5e-6),
    ("traced ray: distance", 8e-6),
    ("traced ray: depth fraction", 2.5e-4),
    ("traced ray: normal", 6e-5),
    ("traced ray: colour", 1.5e-5),
];
/// The model of the traced rays, in f32 and in f64.
type Single = single::model::Quadric;
type Double = double::model::Quadric;
/// Largest fraction of traced rays that hit another part of the pattern,
/// because they pass its edge by less than a rounding error.
const STRAYS: f64 = 2e-3;

/// A frame, an object with its map, a triangle, and a ray that meets it.
struct Case {
    frame: Frame,
    object: Object,
    words: Vec<u32>,
    triangle: Triangle,
    direction: single::Vec3,
}

/// Texels per code step of the map, and the code of distance 0.
const STEP: f32 = 1.0 / 256.0;
const BIAS: u32 = 1 << 15;

/// A disc in 32 × 32 texels, in closed form, as 16-bit codes.
fn disc() -> Vec<u32> {
    let code = |i: u32| {
        let (x, y) = (f64::from(i % 32) - 15.5, f64::from(i / 32) - 15.5);
        let steps = ((x.hypot(y) - 9.3) / f64::from(STEP)).floor();
        (steps + f64::from(BIAS)) as u32
    };
    (0..32 * 16)
        .map(|i| code(2 * i) | code(2 * i + 1) << 16)
        .collect()
}

impl Case {
    fn random(random: &mut Random) -> Case {
        let radius = random.within(0.5, 2.0);
        let narrow = |v: glam::DVec3| v.as_vec3().to_array();
        let centre = random.vector(1.0).normalize();
        let tangent = centre.any_orthonormal_vector();
        let bitangent = centre.cross(tangent);
        let spread = random.within(0.05, 0.2);
        let turn = random.within(0.0, std::f64::consts::TAU);
        let offset = random.vector(0.5);
        let corner = |i: usize| {
            let angle = turn + i as f64 * std::f64::consts::TAU / 3.0;
            let (x, y) = (spread * angle.cos(), spread * angle.sin());
            let normal = (centre + tangent * x + bitangent * y).normalize();
            let flat = |v: glam::DVec3| v - normal * normal.dot(v);
            single::layout::Corner {
                position: narrow(normal * radius),
                normal: narrow(normal),
                tangent: narrow(flat(tangent).normalize()),
                uv: [(x * 4.0 + offset.x) as f32, (y * 4.0 + offset.y) as f32],
                quadric: [0.5 / radius as f32, 0.0, 0.5 / radius as f32],
                gradient_u: narrow(flat(tangent) * (4.0 / radius)),
                gradient_v: narrow(flat(bitangent) * (4.0 / radius)),
            }
        };
        let triangle = Triangle {
            corners: [corner(0), corner(1), corner(2)],
            handedness: 1.0,
            depth_reductions: 0,
        };
        let weights = [
            random.within(0.1, 1.0),
            random.within(0.1, 1.0),
            random.within(0.1, 1.0),
        ];
        let sum: f64 = weights.iter().sum();
        let target: glam::DVec3 = (0..3)
            .map(|i| glam::Vec3::from(triangle.corners[i].position).as_dvec3() * weights[i] / sum)
            .sum();
        let eye = centre * radius
            + (centre + random.vector(0.5)).normalize() * radius * random.within(1.0, 4.0);
        let forward = (target - eye).normalize();
        let kind = random.within(0.0, 4.0) as u32;
        Case {
            frame: Frame {
                eye: narrow(eye),
                near: 1e-3,
                forward: narrow(forward),
                light_direction: narrow((centre + random.vector(0.5)).normalize()),
                light_color: [1.0, 0.9, 0.8],
                ambient: [0.2, 0.25, 0.3],
                size: [640.0, 480.0],
                ..Frame::default()
            },
            object: Object {
                map_size: [32.0, 32.0],
                map_step: STEP,
                map_quantum: STEP,
                map_reach: 2.0,
                depth: (random.within(0.02, 0.1) * radius) as f32,
                extension: if kind == 1 { 0.04 } else { 0.0 },
                bevel: if kind >= 2 { 0.12 } else { 0.0 },
                chamfer: if kind == 3 { 0.4 } else { 1.0 },
                specular: 0.3,
                tolerance: 0.02,
                slack: 0.0,
                cap_color: [0.8, 0.7, 0.6],
                wall_color: [0.5, 0.6, 0.7],
                bevel_color: [0.4, 0.8, 0.5],
                floor_color: [0.2, 0.2, 0.3],
                number: 1,
                shininess: 20,
                tier: single::layout::TIER_FAST,
                cut_out: 0,
                linear_steps: 400,
                binary_steps: 20,
                map_bias: BIAS,
                map_packing: 1,
                map_format: single::layout::FORMAT_CODES,
                search: single::layout::SEARCH_EXTRUSION,
                ..Object::default()
            }
            .complete(),
            words: disc(),
            triangle,
            direction: forward.as_vec3(),
        }
    }
}

/// The largest difference of each comparison.
#[derive(Default)]
struct Worst {
    differences: BTreeMap<&'static str, f64>,
    /// Traced rays by the class they hit.
    classes: [u32; 5],
    traced: u32,
    strays: u32,
}

impl Worst {
    /// Records |found − expected| relative to `scale`.
    fn note(&mut self, name: &'static str, found: f32, expected: f64, scale: f64) {
        let difference = (f64::from(found) - expected).abs() / scale;
        let worst = self.differences.entry(name).or_default();
        // NaN counts as the largest.
        if difference.is_nan() || difference > *worst {
            *worst = if difference.is_nan() {
                f64::INFINITY
            } else {
                difference
            };
        }
    }

    /// Records all components, relative to the length of `expected`, and to at
    /// least `least`.
    fn note_all<const N: usize>(
        &mut self,
        name: &'static str,
        found: [f32; N],
        expected: [f64; N],
        least: f64,
    ) {
        let length = expected.iter().map(|x| x * x).sum::<f64>().sqrt();
        for i in 0..N {
            self.note(name, found[i], expected[i], length.max(least));
        }
    }
}

/// Evaluates both sides of `count` random cases, with f64 inputs perturbed by
/// `perturbation`, relative.
fn worst_differences(count: u32, perturbation: f64) -> Worst {
    let mut random = Random(1);
    let mut worst = Worst::default();
    let grown = 1.0 + perturbation;
    for _ in 0..count {
        let case = Case::random(&mut random);
        let Case {
            frame,
            object,
            triangle,
            ..
        } = &case;
        let texels = &case.words[..];
        let mut wide_frame = wide_frame(frame);
        let mut wide_object = wide_object(object);
        let mut wide_triangle = wide_triangle(triangle);
        let wide_direction = case.direction.as_dvec3();
        wide_frame.eye[0] *= grown;
        wide_frame.light_color[0] *= grown;
        wide_object.map_step *= grown;
        for corner in &mut wide_triangle.corners {
            corner.normal[0] *= grown;
            corner.uv[0] *= grown;
        }

        // Each function alone: f64 starts from f32's inputs.
        let ray = single::model::Ray {
            frame,
            object,
            direction: case.direction,
        };
        let wide_ray = double::model::Ray {
            frame: &wide_frame,
            object: &wide_object,
            direction: wide_direction,
        };
        let facet = single::model::over_triangle::meet(&ray, triangle);
        let wide_facet = double::model::over_triangle::meet(&wide_ray, &wide_triangle);
        assert!(facet.hit && wide_facet.hit);
        worst.note("facet: distance", facet.t, wide_facet.t, wide_facet.t);
        worst.note_all(
            "facet: weights",
            facet.weights.to_array(),
            wide_facet.weights.to_array(),
            1.0,
        );

        let surface = single::surface::interpolate(triangle, &facet);
        let same_facet = double::facet::FacetHit {
            hit: true,
            t: f64::from(facet.t),
            weights: facet.weights.as_dvec3(),
            normal: facet.normal.as_dvec3(),
        };
        let reference = double::surface::interpolate(&wide_triangle, &same_facet);
        for (found, expected) in [
            (surface.normal, reference.normal),
            (surface.tangent, reference.tangent),
            (surface.bitangent, reference.bitangent),
        ] {
            let name = "surface: normal, tangent, bitangent";
            worst.note_all(name, found.to_array(), expected.to_array(), 1.0);
        }
        for (found, expected) in [
            (surface.quadric, reference.quadric),
            (surface.uv.extend(0.0), reference.uv.extend(0.0)),
            (surface.gradient_u, reference.gradient_u),
            (surface.gradient_v, reference.gradient_v),
        ] {
            let name = "surface: quadric, uv, gradients";
            worst.note_all(name, found.to_array(), expected.to_array(), 1.0);
        }
        // The depth is a difference of products as large as the facet's side.
        let side = glam::Vec3::from(triangle.corners[0].position)
            .distance(glam::Vec3::from(triangle.corners[1].position));
        worst.note(
            "surface: facet depth",
            surface.facet_depth,
            reference.facet_depth,
            f64::from(side),
        );

        let path = single::path::QuadraticPath::new(
            &surface,
            case.direction,
            facet.t,
            object.depth,
            object.tier,
        );
        let mut same_surface = wide_surface(&surface);
        same_surface.facet_depth *= grown;
        same_surface.quadric *= grown;
        same_surface.uv *= grown;
        let reference = double::path::QuadraticPath::new(
            &same_surface,
            wide_direction,
            f64::from(facet.t),
            wide_object.depth,
            object.tier,
        );
        for (found, expected, scale) in [
            (path.entry_t, reference.entry_t, reference.entry_t),
            (path.slope, reference.slope, 1.0),
            (path.bend, reference.bend, reference.bend),
            (
                path.end(),
                double::path::Path::end(&reference),
                wide_object.depth,
            ),
        ] {
            worst.note("path: entry, slope, bend, end", found, expected, scale);
        }
        assert_eq!(
            path.ends_on_floor(),
            double::path::Path::ends_on_floor(&reference)
        );
        for fraction in [0.0, 0.3, 0.7, 1.0] {
            let s = path.end() * fraction;
            let wide_s = f64::from(s);
            let expected = double::path::Path::uv(&reference, wide_s);
            let name = "path: texture coordinates";
            worst.note_all(name, path.uv(s).to_array(), expected.to_array(), 1.0);
            let expected = double::path::Path::depth_fraction(&reference, wide_s);
            let name = "path: depth fraction";
            worst.note(name, path.depth_fraction(s), expected, 1.0);
        }

        let map = single::shape_map::ShapeMap::new(object);
        let wide_map = double::shape_map::ShapeMap::new(&wide_object);
        let uv = path.uv(0.5 * path.end());
        let found = map.distance(texels, uv);
        let expected = wide_map.distance(texels, uv.as_dvec2());
        // In texels: the map is 32 of them.
        worst.note("shape map: distance", found, expected, 32.0);
        let found = map.gradient(texels, uv).to_array();
        let expected = wide_map.gradient(texels, uv.as_dvec2()).to_array();
        worst.note_all("shape map: gradient", found, expected, 1.0);

        // The whole ray: each side continues with its own values.
        let exit = single::exit::Exit {
            t: facet.t + 3.0 * object.depth,
            slope: 0.5,
            facet_depth: 0.1 * surface.facet_depth,
            uv: path.uv(3.0 * object.depth),
            depth: object.depth,
        };
        // Every other ray has an exit.
        let words = if worst.traced % 2 == 0 {
            exit.words(object.number)
        } else {
            glam::UVec4::ZERO
        };
        let (enters, entry) =
            Single::enter(&ray, triangle, &facet, &single::exit::KnownExit(words));
        let (wide_enters, wide_entry) = Double::enter(
            &wide_ray,
            &wide_triangle,
            &wide_facet,
            &double::exit::KnownExit(words),
        );
        if !enters || !wide_enters {
            assert_eq!(enters, wide_enters);
            continue;
        }
        let traced = single::trace::trace::<Single, _, _>(&ray, triangle, texels, &entry);
        let wide_traced =
            double::trace::trace::<Double, _, _>(&wide_ray, &wide_triangle, texels, &wide_entry);
        let (hit, reference) = (traced.hit, wide_traced.hit);
        worst.traced += 1;
        let apart = (f64::from(traced.place) - wide_traced.place).abs();
        if hit.class != reference.class || apart > 0.02 * wide_object.depth {
            worst.strays += 1;
            continue;
        }
        worst.classes[hit.class as usize] += 1;
        if hit.class == single::normals::CLASS_MISS {
            continue;
        }
        worst.note("traced ray: distance", hit.t, reference.t, reference.t);
        worst.note(
            "traced ray: depth fraction",
            hit.depth_fraction,
            reference.depth_fraction,
            1.0,
        );
        let normals =
            single::trace::normals::<Single, _, _>(&ray, triangle, texels, &entry, &traced);
        let wide_normals = double::trace::normals::<Double, _, _>(
            &wide_ray,
            &wide_triangle,
            texels,
            &wide_entry,
            &wide_traced,
        );
        worst.note_all(
            "traced ray: normal",
            normals.carved.to_array(),
            wide_normals.carved.to_array(),
            1.0,
        );
        let color =
            single::trace::color::<false, Single, _, _>(&ray, triangle, texels, &entry, &traced);
        let expected = double::trace::color::<false, Double, _, _>(
            &wide_ray,
            &wide_triangle,
            texels,
            &wide_entry,
            &wide_traced,
        );
        worst.note_all(
            "traced ray: colour",
            color.to_array(),
            expected.to_array(),
            1.0,
        );
    }
    worst
}

fn report(worst: &Worst) -> String {
    let mut text = format!(
        "{} of {} traced rays stray, {:?} by class\n",
        worst.strays, worst.traced, worst.classes
    );
    for (name, bound) in BOUNDS {
        text += &format!("{:9.2e} of {bound:.1e}  {name}\n", worst.differences[name]);
    }
    text
}

#[test]
fn f32_differs_from_f64_by_rounding_only() {
    let worst = worst_differences(20_000, 0.0);
    let text = report(&worst);
    println!("{text}");
    assert_eq!(worst.differences.len(), BOUNDS.len());
    // All of caps, walls, bevels and floors occur.
    assert!(worst.classes[1..].iter().all(|&n| n > 500), "{text}");
    for (name, bound) in BOUNDS {
        assert!(worst.differences[name] <= bound, "{name}:\n{text}");
    }
    assert!(
        f64::from(worst.strays) <= STRAYS * f64::from(worst.traced),
        "{text}"
    );
}

#[test]
fn every_comparison_sees_a_perturbed_input() {
    let worst = worst_differences(2_000, 1e-3);
    let text = report(&worst);
    println!("{text}");
    for (name, bound) in BOUNDS {
        assert!(worst.differences[name] > 4.0 * bound, "{name}:\n{text}");
    }
}
