//! Arithmetic, profiles, shape maps, normals and light.

use super::Function;
use super::sample::{
    SIDE, Sample, descending, disc, disc_object, either_sign, error, magnitude, signed, unit,
    vector_error,
};
use fastrand::Rng;
use glam::{DVec2, Vec2, Vec3};
use relievo::oracle::wide::{wide_frame, wide_object, wide_surface};
use relievo_shared as single;
use relievo_shared::layout::{Frame, Object};
use relievo_shared::normals::{CLASS_BEVEL, CLASS_FLOOR, CLASS_WALL};
use relievo_shared_f64 as double;
use std::sync::LazyLock;

pub(super) static LIST: &[Function] = &[
    Function {
        name: "arithmetic: div (against exact arithmetic)",
        over: "the quotient",
        relative_to: "the quotient",
        exponents: [-60, 60],
        stride: 20,
        bound: HALF_UNIT,
        others: 0.0,
        sample: divide,
    },
    Function {
        name: "arithmetic: sqrt (against exact arithmetic)",
        over: "the operand",
        relative_to: "the root",
        exponents: [-60, 60],
        stride: 20,
        bound: HALF_UNIT,
        others: 0.0,
        sample: root,
    },
    Function {
        name: "arithmetic: floor",
        over: "the operand",
        relative_to: "1",
        exponents: [-24, 30],
        stride: 9,
        bound: 0.0,
        others: 0.0,
        sample: floor,
    },
    Function {
        name: "arithmetic: normalize_or",
        over: "the vector's length",
        relative_to: "1",
        exponents: [-49, 60],
        stride: 22,
        bound: 2e-7,
        others: 0.0,
        sample: normalize,
    },
    Function {
        name: "arithmetic: power",
        over: "the exponent",
        relative_to: "the power",
        exponents: [0, 7],
        stride: 1,
        bound: 1e-5,
        others: 0.0,
        sample: power,
    },
    Function {
        name: "profile: radius",
        over: "the bevel, texels",
        relative_to: "the radius",
        exponents: [-20, 20],
        stride: 10,
        bound: 3e-7,
        others: 0.0,
        sample: radius,
    },
    Function {
        name: "shape_map: distance, at a slope of 1 at most",
        over: "the texture coordinates, repeats",
        relative_to: "1 texel of 32",
        exponents: [-10, 30],
        stride: 5,
        bound: 1e-5,
        others: 0.0,
        sample: map_distance,
    },
    Function {
        name: "shape_map: gradient",
        over: "the texture coordinates, repeats",
        relative_to: "1",
        exponents: [-10, 2],
        stride: 3,
        bound: 1e-5,
        others: 0.0,
        sample: map_gradient,
    },
    Function {
        name: "normals: normal_at of a bevel",
        over: "the bevel's growth, texels in a depth",
        relative_to: "1",
        exponents: [-20, 12],
        stride: 8,
        bound: 1e-6,
        others: 0.0,
        sample: bevel_normal,
    },
    Function {
        name: "light: shade",
        over: "the shininess",
        relative_to: "the colour",
        exponents: [0, 7],
        stride: 1,
        bound: 2e-5,
        others: 0.0,
        sample: light,
    },
    Function {
        name: "shadow: lit",
        over: "the light's slope",
        relative_to: "no error: the share of other answers",
        exponents: [-12, 0],
        stride: 3,
        bound: 0.0,
        others: 2e-3,
        sample: shadow,
    },
];

/// Half a unit in the last place, relative: the error of correct rounding.
const HALF_UNIT: f64 = 1.0 / (1u64 << 24) as f64;

static DISC: LazyLock<Vec<u32>> = LazyLock::new(disc);

fn divide(rng: &mut Rng, quotient: f64) -> Sample {
    // Both operands stay within the value contract.
    let room = 60.0 - quotient.log2().abs().min(59.0);
    let scale = (room * (rng.f64() - 0.5)).exp2();
    let b = either_sign(rng, scale / quotient.sqrt()) as f32;
    let a = (f64::from(b) * quotient) as f32;
    let found = f64::from(single::arithmetic::div(a, b));
    // Products of two f32 are exact in f64, and so is the difference of nearly
    // equal numbers.
    let (a, b) = (f64::from(a), f64::from(b));
    Sample::Error(((found * b - a) / a).abs())
}

fn root(_: &mut Rng, x: f64) -> Sample {
    let x = x as f32;
    let found = f64::from(single::arithmetic::sqrt(x));
    let x = f64::from(x);
    // r² − x is exact; r + √x is nearly 2 r.
    Sample::Error(((found * found - x) / (found * (found + x.sqrt()))).abs())
}

fn floor(rng: &mut Rng, x: f64) -> Sample {
    let x = either_sign(rng, x) as f32;
    Sample::Error(error(
        single::arithmetic::floor(x),
        f64::from(x).floor(),
        1.0,
    ))
}

fn normalize(rng: &mut Rng, length: f64) -> Sample {
    let v = (unit(rng) * length).as_vec3();
    let found = single::arithmetic::normalize_or(v, Vec3::Z);
    Sample::Error(vector_error(found, v.as_dvec3().normalize(), 1.0))
}

fn power(rng: &mut Rng, exponent: f64) -> Sample {
    let (x, exponent) = (rng.f32(), exponent as u32);
    let expected = f64::from(x).powi(exponent as i32);
    let least = f64::from(single::arithmetic::SMALLEST);
    let found = single::arithmetic::power(x, exponent);
    // Values below the smallest number may become 0.
    if expected <= least {
        let excess = f64::from(found) - expected;
        return Sample::Error(excess.max(0.0) / expected.max(least));
    }
    Sample::Error(error(found, expected, expected))
}

fn radius(rng: &mut Rng, bevel: f64) -> Sample {
    let object = Object {
        map_size: [SIDE as f32; 2],
        extension: rng.f32(),
        bevel: bevel as f32 / SIDE as f32,
        chamfer: rng.f32(),
        ..Object::default()
    }
    .complete();
    let depth_fraction = rng.f32();
    let found = single::profile::Profile::new(&object).radius(depth_fraction);
    let expected =
        double::profile::Profile::new(&wide_object(&object)).radius(f64::from(depth_fraction));
    Sample::Error(error(found, expected, expected))
}

fn any_uv(rng: &mut Rng, size: f64) -> Vec2 {
    let other = size * signed(rng);
    DVec2::new(either_sign(rng, size), other).as_vec2()
}

fn map_distance(rng: &mut Rng, size: f64) -> Sample {
    let (object, uv) = (disc_object(1.0), any_uv(rng, size));
    let found = single::shape_map::ShapeMap::new(&object).distance(&DISC[..], uv);
    let map = double::shape_map::ShapeMap::new(&wide_object(&object));
    Sample::Error(error(found, map.distance(&DISC[..], uv.as_dvec2()), 1.0))
}

fn map_gradient(rng: &mut Rng, size: f64) -> Sample {
    let (object, uv) = (disc_object(1.0), any_uv(rng, size));
    let found = single::shape_map::ShapeMap::new(&object).gradient(&DISC[..], uv);
    let map = double::shape_map::ShapeMap::new(&wide_object(&object));
    let expected = map.gradient(&DISC[..], uv.as_dvec2());
    Sample::Error((found.as_dvec2() - expected).length())
}

fn bevel_normal(rng: &mut Rng, growth: f64) -> Sample {
    let object = Object {
        bevel: growth as f32 / SIDE as f32,
        ..disc_object(magnitude(rng, 1e-3, 1.0) as f32)
    }
    .complete();
    // Near the outline, not at the disc's centre.
    let angle = std::f64::consts::TAU * rng.f64();
    let uv = (DVec2::splat(0.5) + DVec2::from_angle(angle) * (9.3 / f64::from(SIDE))).as_vec2();
    let surface = single::path::test_surface([0.1, 0.2, -0.1], 0.0);
    let smooth = descending(rng, 0.9) * -1.0;
    let class = if rng.bool() { CLASS_WALL } else { CLASS_BEVEL };
    let map = single::shape_map::ShapeMap::new(&object);
    let at = single::normals::SmoothSurface {
        surface,
        normal: smooth,
        depth: object.depth,
    };
    let found = single::normals::normal_at(class, &object, &map, &DISC[..], &at, uv, 0.5);
    let wide = wide_object(&object);
    let wide_at = double::normals::SmoothSurface {
        surface: wide_surface(&surface),
        normal: smooth.as_dvec3(),
        depth: wide.depth,
    };
    let expected = double::normals::normal_at(
        class,
        &wide,
        &double::shape_map::ShapeMap::new(&wide),
        &DISC[..],
        &wide_at,
        uv.as_dvec2(),
        0.5,
    );
    Sample::Error(vector_error(found, expected, 1.0))
}

fn light(rng: &mut Rng, shininess: f64) -> Sample {
    let frame = Frame {
        light_direction: unit(rng).as_vec3().to_array(),
        light_color: [1.0, 0.9, 0.8],
        ambient: [0.1, 0.15, 0.2],
        ..Frame::default()
    };
    let object = Object {
        wall_color: [rng.f32(), rng.f32(), rng.f32()],
        specular: rng.f32(),
        shininess: shininess as u32,
        ..Object::default()
    };
    let (normal, direction) = (unit(rng).as_vec3(), unit(rng).as_vec3());
    let found = single::light::shade(&frame, &object, CLASS_WALL, normal, direction, true);
    let expected = double::light::shade(
        &wide_frame(&frame),
        &wide_object(&object),
        CLASS_WALL,
        normal.as_dvec3(),
        direction.as_dvec3(),
        true,
    );
    Sample::Error(vector_error(found, expected, expected.length().max(1e-3)))
}

fn shadow(rng: &mut Rng, slope: f64) -> Sample {
    let object = disc_object(magnitude(rng, 0.01, 0.2) as f32);
    let quadric = [0.0, 0.3, -0.3][rng.usize(..3)];
    let surface = single::path::test_surface([quadric, 0.0, quadric], 0.0);
    let to_light = descending(rng, -slope);
    let (uv, depth_fraction) = (Vec2::new(rng.f32(), rng.f32()), rng.f32());
    let point = single::shadow::ShadowPoint {
        class: CLASS_FLOOR,
        uv,
        depth_fraction,
        depth: object.depth,
        normal: Vec3::Z,
        surface_normal: Vec3::Z,
    };
    let map = single::shape_map::ShapeMap::new(&object);
    let found = single::shadow::lit(&object, &map, &DISC[..], &surface, true, &point, to_light);
    let wide = wide_object(&object);
    let wide_point = double::shadow::ShadowPoint {
        class: CLASS_FLOOR,
        uv: uv.as_dvec2(),
        depth_fraction: f64::from(depth_fraction),
        depth: wide.depth,
        normal: glam::DVec3::Z,
        surface_normal: glam::DVec3::Z,
    };
    let expected = double::shadow::lit(
        &wide,
        &double::shape_map::ShapeMap::new(&wide),
        &DISC[..],
        &wide_surface(&surface),
        true,
        &wide_point,
        to_light.as_dvec3(),
    );
    if found == expected {
        Sample::Error(0.0)
    } else {
        Sample::Other
    }
}
