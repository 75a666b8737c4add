//! From pixels to triangles and the surface over them.

use super::Function;
use super::sample::{Sample, either_sign, error, magnitude, signed, unit, vector_error};
use fastrand::Rng;
use glam::DVec3;
use relievo::oracle::wide::{wide_frame, wide_triangle};
use relievo_shared as single;
use relievo_shared::layout::{Corner, Frame, Triangle, UPRIGHT_AXES};
use relievo_shared_f64 as double;

pub(super) static LIST: &[Function] = &[
    Function {
        name: "camera: pixel_ray",
        over: "the field of view, by the tangent of its half",
        relative_to: "the angle of a pixel of 1024",
        exponents: [-14, 8],
        stride: 4,
        bound: 0.5,
        others: 0.0,
        sample: pixel_ray,
    },
    Function {
        name: "camera: reversed_depth",
        over: "the distance in near planes",
        relative_to: "the depth",
        exponents: [0, 40],
        stride: 10,
        bound: 1e-6,
        others: 0.0,
        sample: reversed_depth,
    },
    Function {
        name: "outline: bounding_rectangle",
        over: "the distance in triangles",
        relative_to: "a pixel of 1024",
        exponents: [1, 21],
        stride: 4,
        bound: 1e-3,
        others: 0.0,
        sample: rectangle,
    },
    Function {
        name: "facet: distance",
        over: "the distance in triangles",
        relative_to: "the distance",
        exponents: [-4, 20],
        stride: 4,
        bound: 3e-5,
        others: 0.0,
        sample: facet_distance,
    },
    Function {
        name: "facet: weights",
        over: "the distance in triangles",
        relative_to: "1, and to the distance in triangles beyond",
        exponents: [-4, 20],
        stride: 4,
        bound: 1e-5,
        others: 0.0,
        sample: facet_weights,
    },
    Function {
        name: "facet: weights of slivers",
        over: "a triangle's height in its length",
        relative_to: "1, and to what its height adds",
        exponents: [-20, 0],
        stride: 4,
        bound: 1e-5,
        others: 0.0,
        sample: sliver_weights,
    },
    Function {
        name: "facet: distance at grazing angles",
        over: "the sine of the angle to the facet",
        relative_to: "the distance, and to what the angle adds",
        exponents: [-20, 0],
        stride: 4,
        bound: 1e-5,
        others: 0.0,
        sample: grazing_distance,
    },
    Function {
        name: "surface: normal",
        over: "the angle between the corners' normals",
        relative_to: "1",
        exponents: [-20, 0],
        stride: 4,
        bound: 5e-7,
        others: 0.0,
        sample: |rng, angle| curved(rng, angle, Part::Normal),
    },
    Function {
        name: "surface: facet depth",
        over: "the angle between the corners' normals",
        relative_to: "the triangle's side",
        exponents: [-20, 0],
        stride: 4,
        bound: 2e-7,
        others: 0.0,
        sample: |rng, angle| curved(rng, angle, Part::FacetDepth),
    },
    Function {
        name: "surface: quadric, uv and gradients",
        over: "the angle between the corners' normals",
        relative_to: "their size",
        exponents: [-20, 0],
        stride: 4,
        bound: 1e-6,
        others: 0.0,
        sample: |rng, angle| curved(rng, angle, Part::Linear),
    },
    Function {
        name: "surface: uv_bend",
        over: "the angle between the corners' normals",
        relative_to: "the gradients, over the triangle's side",
        exponents: [-20, 0],
        stride: 4,
        bound: 1e-6,
        others: 0.0,
        sample: |rng, angle| curved(rng, angle, Part::Bend),
    },
];

/// A camera that looks along −z.
fn frame(tangent: f64) -> Frame {
    let side = 1024.0;
    let step = (2.0 * tangent / side) as f32;
    Frame {
        near: 1.0,
        right: [(1.0 / tangent) as f32, 0.0, 0.0],
        up: [0.0, (1.0 / tangent) as f32, 0.0],
        forward: [0.0, 0.0, -1.0],
        ray_first: [-tangent as f32, tangent as f32, -1.0],
        ray_right: [step, 0.0, 0.0],
        ray_down: [0.0, -step, 0.0],
        size: [side as f32; 2],
        unit: 1.0,
        axes: UPRIGHT_AXES,
        ..Frame::default()
    }
}

fn pixel_ray(rng: &mut Rng, tangent: f64) -> Sample {
    let frame = frame(tangent);
    let (x, y) = (rng.u32(..1024), rng.u32(..1024));
    let found = single::camera::pixel_ray(&frame, x, y);
    let expected = double::camera::pixel_ray(&wide_frame(&frame), x, y);
    // The angle between neighbouring pixels there.
    let next = double::camera::pixel_ray(&wide_frame(&frame), x + 1, y);
    Sample::Error(vector_error(found, expected, (next - expected).length()))
}

fn reversed_depth(rng: &mut Rng, distance: f64) -> Sample {
    let frame = frame(1.0);
    let direction = single::camera::pixel_ray(&frame, rng.u32(..1024), rng.u32(..1024));
    let t = distance as f32;
    let found = single::camera::reversed_depth(&frame, direction, t);
    let wide =
        double::camera::reversed_depth(&wide_frame(&frame), direction.as_dvec3(), f64::from(t));
    Sample::Error(error(found, wide, wide))
}

/// Returns a triangle with corners at unit distance around `centre` in the
/// plane with `normal`.
fn flat_triangle(rng: &mut Rng, centre: DVec3, normal: DVec3, height: f64) -> Triangle {
    let tangent = normal.any_orthonormal_vector();
    let bitangent = normal.cross(tangent);
    let turn = std::f64::consts::TAU * rng.f64();
    let (along, across) = (
        tangent * turn.cos() + bitangent * turn.sin(),
        bitangent * turn.cos() - tangent * turn.sin(),
    );
    let corner = |x: f64, y: f64| Corner {
        position: (centre + along * x + across * (y * height))
            .as_vec3()
            .to_array(),
        ..Corner::default()
    };
    let third = signed(rng);
    Triangle {
        corners: [corner(-1.0, -0.5), corner(1.0, -0.5), corner(third, 0.5)],
        handedness: 1.0,
        depth_reductions: 0,
    }
}

/// Returns a ray from `eye` to a point well inside `triangle`.
fn aim(rng: &mut Rng, eye: DVec3, triangle: &Triangle) -> DVec3 {
    let shares: [f64; 3] = std::array::from_fn(|_| 0.1 + rng.f64());
    let sum: f64 = shares.iter().sum();
    let target: DVec3 = triangle
        .corners
        .iter()
        .zip(shares)
        .map(|(corner, share)| DVec3::from(corner.position.map(f64::from)) * (share / sum))
        .sum();
    (target - eye).normalize()
}

/// Hits in f32 and f64.
fn meet(
    rng: &mut Rng,
    eye: DVec3,
    triangle: &Triangle,
) -> Option<(single::facet::FacetHit, double::facet::FacetHit)> {
    let eye = eye.as_vec3();
    let direction = aim(rng, eye.as_dvec3(), triangle).as_vec3();
    let wide_triangle = wide_triangle(triangle);
    let found = single::facet::intersect(eye, direction, triangle);
    let expected = double::facet::intersect(eye.as_dvec3(), direction.as_dvec3(), &wide_triangle);
    (found.hit && expected.hit).then_some((found, expected))
}

/// Returns a triangle seen from `distance`, at an angle whose sine is at least
/// this.
fn seen(
    rng: &mut Rng,
    distance: f64,
    height: f64,
    sine: [f64; 2],
) -> Option<(single::facet::FacetHit, double::facet::FacetHit)> {
    let normal = unit(rng);
    let triangle = flat_triangle(rng, DVec3::ZERO, normal, height);
    let slope = magnitude(rng, sine[0], sine[1]);
    let tangent = normal.any_orthonormal_vector();
    let turn = std::f64::consts::TAU * rng.f64();
    let around = tangent * turn.cos() + normal.cross(tangent) * turn.sin();
    let eye = (normal * slope + around * (1.0 - slope * slope).sqrt()) * distance;
    meet(rng, eye, &triangle)
}

/// Applies `error` if both sides hit.
fn compare(
    met: Option<(single::facet::FacetHit, double::facet::FacetHit)>,
    error: impl Fn(&single::facet::FacetHit, &double::facet::FacetHit) -> f64,
) -> Sample {
    met.map_or(Sample::Unfit, |(found, expected)| {
        Sample::Error(error(&found, &expected))
    })
}

fn facet_distance(rng: &mut Rng, distance: f64) -> Sample {
    compare(seen(rng, distance, 1.0, [0.3, 1.0]), |found, expected| {
        error(found.t, expected.t, expected.t.abs())
    })
}

fn facet_weights(rng: &mut Rng, distance: f64) -> Sample {
    compare(seen(rng, distance, 1.0, [0.3, 1.0]), |found, expected| {
        vector_error(found.weights, expected.weights, distance.max(1.0))
    })
}

fn sliver_weights(rng: &mut Rng, height: f64) -> Sample {
    compare(seen(rng, 3.0, height, [0.3, 1.0]), |found, expected| {
        vector_error(found.weights, expected.weights, 1.0 / height)
    })
}

fn grazing_distance(rng: &mut Rng, sine: f64) -> Sample {
    compare(seen(rng, 3.0, 1.0, [sine, sine]), |found, expected| {
        error(found.t, expected.t, expected.t.abs() / sine)
    })
}

fn rectangle(rng: &mut Rng, distance: f64) -> Sample {
    let frame = frame(1.0);
    let middle = DVec3::new(signed(rng) * 0.8, signed(rng) * 0.8, -1.0) * distance;
    let normal = -middle.normalize();
    let triangle = flat_triangle(rng, middle, normal, 1.0);
    let frame = Frame {
        near: 0.5 * distance as f32,
        ..frame
    };
    let found = single::outline::bounding_rectangle(&frame, &triangle);
    let expected =
        double::outline::bounding_rectangle(&wide_frame(&frame), &wide_triangle(&triangle));
    let pixel = 2.0 / 1024.0;
    let apart = [
        found.low.as_dvec2() - expected.low,
        found.high.as_dvec2() - expected.high,
    ];
    Sample::Error(apart[0].length().max(apart[1].length()) / pixel)
}

/// Results of [`single::surface::interpolate`].
enum Part {
    Normal,
    FacetDepth,
    Linear,
    Bend,
}

/// Interpolates over a triangle of a sphere.
fn curved(rng: &mut Rng, angle: f64, part: Part) -> Sample {
    let centre = unit(rng);
    let tangent = centre.any_orthonormal_vector();
    let bitangent = centre.cross(tangent);
    // The side is 1; the radius follows from the angle.
    let radius = 1.0 / angle;
    let size = magnitude(rng, 0.1, 10.0);
    let size = either_sign(rng, size);
    let corners: [Corner; 3] = std::array::from_fn(|i| {
        let turn = (i as f64 + rng.f64() * 0.5) * std::f64::consts::TAU / 3.0;
        let (x, y) = (0.5 * angle * turn.cos(), 0.5 * angle * turn.sin());
        let normal = (centre + tangent * x + bitangent * y).normalize();
        let flat = |v: DVec3| v - normal * normal.dot(v);
        Corner {
            position: ((normal - centre) * radius).as_vec3().to_array(),
            normal: normal.as_vec3().to_array(),
            tangent: flat(tangent).normalize().as_vec3().to_array(),
            uv: [signed(rng) as f32, signed(rng) as f32],
            quadric: [0.5 * angle as f32 * size as f32, 0.0, 0.5 * angle as f32],
            gradient_u: (flat(tangent) * size).as_vec3().to_array(),
            gradient_v: (flat(bitangent) * size).as_vec3().to_array(),
        }
    });
    let triangle = Triangle {
        corners,
        handedness: 1.0,
        depth_reductions: 0,
    };
    let eye = centre * 3.0;
    let Some((facet, _)) = meet(rng, eye, &triangle) else {
        return Sample::Unfit;
    };
    let found = single::surface::interpolate(&triangle, &facet);
    let same_facet = double::facet::FacetHit {
        hit: true,
        t: f64::from(facet.t),
        weights: facet.weights.as_dvec3(),
        normal: facet.normal.as_dvec3(),
    };
    let expected = double::surface::interpolate(&wide_triangle(&triangle), &same_facet);
    Sample::Error(match part {
        Part::Normal => vector_error(found.normal, expected.normal, 1.0),
        Part::FacetDepth => error(found.facet_depth, expected.facet_depth, 1.0),
        Part::Bend => {
            let direction = unit(rng).as_vec3();
            let found = single::surface::uv_bend(&triangle, found.normal, direction);
            let wide_normal = single::surface::interpolate(&triangle, &facet)
                .normal
                .as_dvec3();
            let expected = double::surface::uv_bend(
                &wide_triangle(&triangle),
                wide_normal,
                direction.as_dvec3(),
            );
            (found.as_dvec2() - expected).length() / size.abs()
        }
        Part::Linear => {
            let size = size.abs();
            let uv = (found.uv.as_dvec2() - expected.uv).length();
            vector_error(found.gradient_u, expected.gradient_u, size)
                .max(vector_error(found.gradient_v, expected.gradient_v, size))
                .max(vector_error(
                    found.quadric,
                    expected.quadric,
                    angle * size.max(1.0),
                ))
                .max(uv)
        }
    })
}
