//! Tests the whole preparation on shapes of known curvature.

use std::f64::consts::{FRAC_PI_4, PI, TAU};
use std::fmt::Write;
use std::path::Path;

use glam::{DQuat, DVec2, DVec3};
use proptest::prelude::*;

use super::*;

/// A point of a parametric surface: position and normal.
type SurfacePoint = (DVec3, DVec3);

/// Returns a grid of quads over the unit square as OBJ text. `point` returns the
/// surface at (column, row), `uv` the texture coordinates.
fn grid(
    columns: usize,
    rows: usize,
    point: impl Fn(usize, usize) -> SurfacePoint,
    uv: impl Fn(f64, f64) -> DVec2,
) -> String {
    let mut text = String::new();
    for row in 0..=rows {
        for column in 0..=columns {
            let (position, normal) = point(column, row);
            let uv = uv(column as f64 / columns as f64, row as f64 / rows as f64);
            writeln!(text, "v {} {} {}", position.x, position.y, position.z).unwrap();
            writeln!(text, "vn {} {} {}", normal.x, normal.y, normal.z).unwrap();
            writeln!(text, "vt {} {}", uv.x, uv.y).unwrap();
        }
    }
    for row in 0..rows {
        for column in 0..columns {
            let index = |dx: usize, dy: usize| 1 + (row + dy) * (columns + 1) + column + dx;
            let [a, b, c, d] = [index(0, 0), index(1, 0), index(1, 1), index(0, 1)];
            writeln!(text, "f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c} {d}/{d}/{d}").unwrap();
        }
    }
    text
}

fn options() -> MeshOptions {
    MeshOptions::default()
}

fn parse(text: &str, options: &MeshOptions) -> Mesh {
    Mesh::parse(text, Path::new("test.obj"), options).unwrap()
}

fn corners(mesh: &Mesh) -> impl Iterator<Item = &MeshCorner> {
    mesh.triangles.iter().flat_map(|triangle| &triangle.corners)
}

/// Replaces every corner of a face by `keep` of its indices.
fn strip_corners(text: &str, keep: impl Fn(&[&str]) -> String) -> String {
    let mut stripped = String::new();
    for line in text.lines() {
        if let Some(face) = line.strip_prefix("f ") {
            let corners: Vec<String> = face
                .split(' ')
                .map(|corner| keep(&corner.split('/').collect::<Vec<_>>()))
                .collect();
            writeln!(stripped, "f {}", corners.join(" ")).unwrap();
        } else {
            writeln!(stripped, "{line}").unwrap();
        }
    }
    stripped
}

const SPHERE_RADIUS: f64 = 2.0;

/// Returns a UV sphere with u to the east and v up.
fn sphere() -> String {
    let (columns, rows) = (48, 24);
    let point = |column: usize, row: usize| {
        let (sin, cos) = (TAU * (column % columns) as f64 / columns as f64).sin_cos();
        let (rise, run) = (PI * (row as f64 / rows as f64 - 0.5)).sin_cos();
        let run = if row == 0 || row == rows { 0.0 } else { run };
        let normal = DVec3::new(run * sin, rise, run * cos);
        (SPHERE_RADIUS * normal, normal)
    };
    grid(columns, rows, point, |u, v| DVec2::new(2.0 * u, v))
}

/// Returns an open cylinder about y, with arc length and height as texture
/// coordinates.
fn cylinder(radius: f64, uv: impl Fn(f64, f64) -> DVec2) -> String {
    let (columns, rows, height) = (32, 4, 3.0);
    let point = |column: usize, row: usize| {
        let (sin, cos) = (TAU * (column % columns) as f64 / columns as f64).sin_cos();
        let normal = DVec3::new(sin, 0.0, cos);
        (
            radius * normal + height * row as f64 / rows as f64 * DVec3::Y,
            normal,
        )
    };
    grid(columns, rows, point, |u, v| {
        uv(TAU * radius * u, height * v)
    })
}

fn rotated(angle: f64) -> impl Fn(f64, f64) -> DVec2 {
    move |u, v| DVec2::from_angle(angle).rotate(DVec2::new(u, v))
}

/// Returns q, half the normal curvature, in a direction in space.
fn evaluate(corner: &MeshCorner, direction: DVec3) -> f64 {
    corner.quadric.evaluate(
        direction.dot(corner.tangent),
        direction.dot(corner.bitangent()),
    )
}

/// Asserts the invariants of every mesh.
fn assert_sound(mesh: &Mesh) {
    for triangle in &mesh.triangles {
        for corner in &triangle.corners {
            for gradient in [corner.gradient_u, corner.gradient_v] {
                assert!(gradient.is_finite());
                assert!(gradient.dot(corner.normal).abs() < 1e-9 * gradient.length().max(1.0));
            }
            assert!((corner.normal.length() - 1.0).abs() < 1e-12);
            assert!((corner.tangent.length() - 1.0).abs() < 1e-12);
            assert!(corner.tangent.dot(corner.normal).abs() < 1e-12);
            assert!(corner.handedness.abs() == 1.0);
            let Quadric { xx, xy, yy } = corner.quadric;
            assert!(xx.is_finite() && xy.is_finite() && yy.is_finite());
        }
    }
}

#[test]
fn a_sphere_curves_by_its_radius_at_poles_too() {
    let mesh = parse(&sphere(), &options());
    assert_sound(&mesh);
    assert_eq!(
        mesh.report.skipped_degenerate,
        2 * 48,
        "the quads at the poles are triangles"
    );
    assert_eq!(mesh.position_count, 48 * 23 + 2);
    let expected = 0.5 / SPHERE_RADIUS;
    for Quadric { xx, xy, yy } in corners(&mesh).map(|corner| corner.quadric) {
        assert!((xx / expected - 1.0).abs() < 0.02, "{xx}");
        assert!((yy / expected - 1.0).abs() < 0.02, "{yy}");
        assert!((xy / expected).abs() < 0.02, "{xy}");
    }
    assert!((mesh.report.smallest_curvature * SPHERE_RADIUS - 1.0).abs() < 0.02);
    assert!((mesh.report.largest_curvature * SPHERE_RADIUS - 1.0).abs() < 0.02);
}

#[test]
fn without_smooth_tangents_only_the_frames_differ() {
    let smooth = parse(&sphere(), &options());
    let rough = parse(
        &sphere(),
        &MeshOptions {
            smooth_tangents: false,
            ..options()
        },
    );
    assert_ne!(smooth, rough);
    for (a, b) in corners(&smooth).zip(corners(&rough)) {
        assert!((b.tangent.length() - 1.0).abs() < 1e-12 && b.tangent.dot(b.normal).abs() < 1e-12);
        let curvatures = [a, b].map(|corner| corner.quadric.principal_curvatures());
        for (a, b) in curvatures[0].into_iter().zip(curvatures[1]) {
            assert!((a - b).abs() < 1e-9, "{a} {b}");
        }
        let same = MeshCorner {
            tangent: a.tangent,
            handedness: a.handedness,
            quadric: a.quadric,
            ..*b
        };
        assert_eq!(*a, same);
    }
}

#[test]
fn computed_normals_are_close_to_a_sphere_s() {
    for keep_zero in [false, true] {
        // Without normals, or with zero normals.
        let text = if keep_zero {
            sphere()
                .lines()
                .map(|line| {
                    if line.starts_with("vn") {
                        "vn 0 0 0\n".into()
                    } else {
                        format!("{line}\n")
                    }
                })
                .collect()
        } else {
            strip_corners(&sphere(), |corner| corner[..2].join("/"))
        };
        let mesh = parse(&text, &options());
        assert!(mesh.report.computed_normals);
        for corner in corners(&mesh) {
            assert!(corner.normal.dot(corner.position.normalize()) > 0.9999);
        }
        assert!((mesh.report.smallest_curvature * SPHERE_RADIUS - 1.0).abs() < 0.05);
        assert!((mesh.report.largest_curvature * SPHERE_RADIUS - 1.0).abs() < 0.05);
    }
    assert!(!parse(&sphere(), &options()).report.computed_normals);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// Curvature scales as 1/length; UVs and frames do not change.
    #[test]
    fn the_scale_changes_nothing_but_the_unit(exponent in -3.0..3.0_f64) {
        let scale = 10_f64.powf(exponent);
        let text = sphere();
        let (base, scaled) = (parse(&text, &options()), parse(&text, &MeshOptions { scale, ..options() }));
        prop_assert_eq!(base.triangles.len(), scaled.triangles.len());
        for (a, b) in corners(&base).zip(corners(&scaled)) {
            let tolerance = 1e-6 * 0.5 / SPHERE_RADIUS;
            prop_assert!((a.quadric.xx - scale * b.quadric.xx).abs() < tolerance);
            prop_assert!((a.quadric.xy - scale * b.quadric.xy).abs() < tolerance);
            prop_assert!((a.quadric.yy - scale * b.quadric.yy).abs() < tolerance);
        }
    }

    /// ∇u and ∇v reproduce the texture coordinates along the edges.
    #[test]
    fn gradients_reproduce_the_texture_coordinates(
        positions in prop::array::uniform3(prop::array::uniform3(-10.0..10.0_f64)),
        uvs in prop::array::uniform3(prop::array::uniform2(-3.0..3.0_f64)),
    ) {
        let [a, b, c] = positions.map(DVec3::from_array);
        let uv = uvs.map(DVec2::from_array);
        prop_assume!((b - a).cross(c - a).length() > 1.0 && (uv[1] - uv[0]).perp_dot(uv[2] - uv[0]).abs() > 0.1);
        let mut text = String::new();
        for (position, uv) in [a, b, c].iter().zip(uv) {
            writeln!(text, "v {} {} {}\nvt {} {}", position.x, position.y, position.z, uv.x, uv.y).unwrap();
        }
        let mesh = parse(&format!("{text}f 1/1 2/2 3/3\n"), &options());
        // One triangle with computed normals: its corners' normals are its own.
        let corner = &mesh.triangles[0].corners[0];
        for (position, expected) in [(b, uv[1] - uv[0]), (c, uv[2] - uv[0])] {
            let along = DVec2::new(corner.gradient_u.dot(position - a), corner.gradient_v.dot(position - a));
            prop_assert!((along - expected).length() < 1e-9);
        }
        let normal = (b - a).cross(c - a).normalize();
        prop_assert!(corner.gradient_u.dot(normal).abs() < 1e-9 * corner.gradient_u.length().max(1.0));
        prop_assert!(corner.bitangent().dot(corner.gradient_v) > 0.0);
        prop_assert!(corner.tangent.dot(corner.gradient_u) > 0.0);
    }
}

/// Faces of the cube with the corners ±1: normal, and two axes that turn
/// counter-clockwise about it.
fn cube() -> String {
    let mut text = String::new();
    let mut vertex = 0;
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let normal = DVec3::AXES[axis] * sign;
            let (across, up) = (
                DVec3::AXES[(axis + 1) % 3] * sign,
                DVec3::AXES[(axis + 2) % 3],
            );
            writeln!(text, "vn {} {} {}", normal.x, normal.y, normal.z).unwrap();
            let mut face = String::from("f");
            for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                let position = normal + x * across + y * up;
                writeln!(
                    text,
                    "v {} {} {}\nvt {} {}",
                    position.x,
                    position.y,
                    position.z,
                    0.5 + x / 2.0,
                    0.5 + y / 2.0
                )
                .unwrap();
                vertex += 1;
                write!(face, " {vertex}/{vertex}/-1").unwrap();
            }
            writeln!(text, "{face}").unwrap();
        }
    }
    text
}

#[test]
fn a_cube_with_hard_edges_is_flat() {
    let mesh = parse(&cube(), &options());
    assert_sound(&mesh);
    assert_eq!((mesh.triangles.len(), mesh.position_count), (12, 8));
    assert!(corners(&mesh).all(|corner| corner.quadric == Quadric::default()));
    assert_eq!(mesh.report.reversed_triangles, 0);
    // Without normals, edges sharper than the crease angle are hard.
    let without_normals = strip_corners(&cube(), |corner| corner[..2].join("/"));
    let within = |crease_angle| {
        let options = MeshOptions {
            crease_angle,
            ..options()
        };
        parse(&without_normals, &options)
    };
    for crease_angle in [60.0, 0.0, 89.9] {
        let hard = within(crease_angle);
        for (computed, given) in corners(&hard).zip(corners(&mesh)) {
            assert!(computed.normal.distance(given.normal) < 1e-12);
        }
    }
    assert_eq!(parse(&without_normals, &options()), within(60.0));
    let smooth = within(90.0);
    assert!(smooth.report.smallest_curvature > 0.1);
    for corner in corners(&smooth) {
        assert!(
            corner.normal.dot(corner.position.normalize()) > 1.0 - 1e-12,
            "weighted by angle"
        );
    }
}

#[test]
fn caps_do_not_bend_the_side_of_a_cylinder() {
    let radius = 0.7;
    let mut text = cylinder(radius, DVec2::new);
    // A cap around a new centre: the first 33 vertices are the lower rim.
    writeln!(text, "v 0 0 0\nvn 0 -1 0\nvt 0 0").unwrap();
    for column in 1..=32 {
        writeln!(
            text,
            "f -1/-1/-1 {}/{}/-1 {column}/{column}/-1",
            column + 1,
            column + 1
        )
        .unwrap();
    }
    let mesh = parse(&text, &options());
    assert_sound(&mesh);
    for corner in corners(&mesh) {
        let [low, high] = corner.quadric.principal_curvatures();
        let expected = if corner.normal.y.abs() < 0.5 {
            1.0 / radius
        } else {
            0.0
        };
        assert!(
            low.abs() < 1e-3 / radius && (high - expected).abs() < 0.02 / radius,
            "{low} {high}"
        );
    }
}

#[test]
fn a_cylinder_is_flat_along_its_axis_in_any_frame() {
    let radius = 1.5;
    for angle in [0.0, FRAC_PI_4, 1.0] {
        let mesh = parse(&cylinder(radius, rotated(angle)), &options());
        assert_sound(&mesh);
        for corner in corners(&mesh) {
            let around = DVec3::Y.cross(corner.normal);
            assert!(
                evaluate(corner, DVec3::Y).abs() < 1e-3 / radius,
                "{}",
                evaluate(corner, DVec3::Y)
            );
            assert!((evaluate(corner, around) * 2.0 * radius - 1.0).abs() < 0.02);
            assert!(
                (corner.tangent.dot(around) - angle.cos()).abs() < 0.01,
                "{angle}: {}",
                corner.tangent.dot(around)
            );
        }
    }
}

#[test]
fn mirrored_texture_coordinates_turn_the_frame_and_not_the_surface() {
    let (plain, mirrored) = (rotated(0.4), rotated(0.4));
    let mesh = parse(&cylinder(1.0, plain), &options());
    let mirror = parse(
        &cylinder(1.0, move |u, v| mirrored(u, v) * DVec2::new(-1.0, 1.0)),
        &options(),
    );
    assert!(corners(&mesh).all(|corner| corner.handedness == 1.0));
    assert!(corners(&mirror).all(|corner| corner.handedness == -1.0));
    for (a, b) in mesh.triangles.iter().zip(&mirror.triangles) {
        for (a, b) in a.corners.iter().zip(&b.corners) {
            for direction in [DVec3::X, DVec3::Y, DVec3::new(1.0, 2.0, -0.5)] {
                let in_plane =
                    |corner: &MeshCorner| direction - direction.dot(corner.normal) * corner.normal;
                assert!((evaluate(a, in_plane(a)) - evaluate(b, in_plane(b))).abs() < 1e-9);
            }
        }
        for triangle in [a, b] {
            for corner in &triangle.corners {
                assert!(corner.bitangent().dot(corner.gradient_v) > 0.0);
                assert!(corner.tangent.dot(corner.gradient_u) > 0.0);
            }
        }
    }
}

/// Returns the mean error of q over all corners and directions of a jittered torus
/// whose frames are rotated by 30°, relative to the mean magnitude of q.
fn torus_error(exact_normals: bool) -> f64 {
    let (columns, rows, major, minor) = (52_usize, 26_usize, 1.0, 0.4);
    // Jitter of up to a quarter of a cell, equal on both sides of a seam.
    let jitter = |column: usize, row: usize, salt: u64| {
        let mut state = (column as u64 * 8191 + row as u64) * 2 + salt + 1;
        for _ in 0..3 {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            state ^= state >> 29;
        }
        ((state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5) * 0.5
    };
    let point = |column: usize, row: usize| {
        let (column, row) = (column % columns, row % rows);
        let around = TAU * (column as f64 + jitter(column, row, 0)) / columns as f64;
        let tube = TAU * (row as f64 + jitter(column, row, 1)) / rows as f64;
        let outward = DVec3::new(around.sin(), 0.0, around.cos());
        let normal = tube.cos() * outward + tube.sin() * DVec3::Y;
        (major * outward + minor * normal, normal)
    };
    let turn = rotated(PI / 6.0);
    let mut text = grid(columns, rows, point, |u, v| {
        turn(TAU * major * u, TAU * minor * v)
    });
    if !exact_normals {
        text = strip_corners(&text, |corner| corner[..2].join("/"));
    }
    let mesh = parse(&text, &options());
    assert_sound(&mesh);
    let (mut error, mut magnitude) = (0.0, 0.0);
    for corner in corners(&mesh) {
        let outward = (corner.position * DVec3::new(1.0, 0.0, 1.0)).normalize();
        let normal = (corner.position - major * outward) / minor;
        let around = DVec3::Y.cross(outward);
        let tube = around.cross(normal);
        let ring_curvature = normal.dot(outward) / (major + minor * normal.dot(outward));
        for step in 0..16 {
            let (sin, cos) = (PI * f64::from(step) / 16.0).sin_cos();
            let direction = cos * corner.tangent + sin * corner.bitangent();
            let exact = 0.5
                * (ring_curvature * direction.dot(around).powi(2)
                    + direction.dot(tube).powi(2) / minor);
            error += (evaluate(corner, direction) - exact).abs();
            magnitude += exact.abs();
        }
    }
    error / magnitude
}

#[test]
fn a_jittered_torus_in_turned_frames_is_fitted_within_a_few_percent() {
    let (exact, computed) = (torus_error(true), torus_error(false));
    println!(
        "mean error of q: {:.2} % with exact normals, {:.2} % with computed ones",
        100.0 * exact,
        100.0 * computed
    );
    assert!(exact < 0.06, "{exact}");
    assert!(computed < 0.12, "{computed}");
}

#[test]
fn reversed_winding_is_turned_to_the_normals() {
    let reversed: String = sphere()
        .lines()
        .map(|line| match line.strip_prefix("f ") {
            Some(face) => format!(
                "f {}\n",
                face.split(' ').rev().collect::<Vec<_>>().join(" ")
            ),
            None => format!("{line}\n"),
        })
        .collect();
    let mesh = parse(&reversed, &options());
    assert_eq!(mesh.report.reversed_triangles, mesh.triangles.len());
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.corners.map(|corner| corner.position);
        assert!((b - a).cross(c - a).dot(triangle.corners[0].normal) > 0.0);
    }
    assert!((mesh.report.smallest_curvature * SPHERE_RADIUS - 1.0).abs() < 0.02);
}

#[test]
fn the_transform_scales_then_turns_then_moves() {
    let moved = MeshOptions {
        scale: 2.0,
        rotation: DQuat::from_rotation_z(PI / 2.0) * 3.0,
        translation: DVec3::new(10.0, 0.0, 0.0),
        ..options()
    };
    let text =
        "v 0 0 0\nv 1 0 0\nv 0 0 -1\nvt 0 0\nvt 1 0\nvt 0 1\nvn 0 7 0\nf 1/1/1 2/2/1 3/3/1\n";
    let mesh = parse(text, &moved);
    let triangle = &mesh.triangles[0];
    let expected = [
        DVec3::new(10.0, 0.0, 0.0),
        DVec3::new(10.0, 2.0, 0.0),
        DVec3::new(10.0, 0.0, -2.0),
    ];
    for (corner, expected) in triangle.corners.iter().zip(expected) {
        assert!(corner.position.distance(expected) < 1e-12);
        assert!(corner.normal.distance(DVec3::NEG_X) < 1e-12);
        assert!(corner.tangent.distance(DVec3::Y) < 1e-6);
        assert!(corner.bitangent().distance(DVec3::NEG_Z) < 1e-6);
        assert!(corner.gradient_u.distance(DVec3::new(0.0, 0.5, 0.0)) < 1e-12);
        assert!(corner.gradient_v.distance(DVec3::new(0.0, 0.0, -0.5)) < 1e-12);
    }
    assert!(mesh.bounds.min.distance(DVec3::new(10.0, 0.0, -2.0)) < 1e-12);
}

#[test]
fn projections_stand_in_for_texture_coordinates() {
    let text = strip_corners(&sphere(), |corner| format!("{}//{}", corner[0], corner[2]));
    let error = Mesh::parse(&text, Path::new("bare.obj"), &options()).unwrap_err();
    assert!(matches!(error, MeshError::MissingTextureCoordinates { .. }));
    let message = error.to_string();
    for part in [
        "bare.obj",
        "`projection = \"spherical\"`",
        "\"planar-x\", \"planar-y\", \"planar-z\", \"cylindrical\"",
    ] {
        assert!(message.contains(part), "{message}");
    }
    for projection in Projection::ALL {
        let with = MeshOptions {
            projection: Some(projection),
            ..options()
        };
        let mesh = parse(&text, &with);
        assert_sound(&mesh);
        assert!(mesh.report.projected_uvs);
        assert_eq!(mesh, parse(&sphere(), &with), "the file's own are replaced");
        let is_round = matches!(projection, Projection::Cylindrical | Projection::Spherical);
        if is_round {
            assert!(
                corners(&mesh).all(|corner| corner.handedness == 1.0),
                "no triangle runs backwards"
            );
        }
    }
}

#[test]
fn borders_and_lone_triangles_stay_finite() {
    let patch = |column: usize, row: usize| {
        let normal = DVec3::new(0.1 * column as f64, 0.1 * row as f64, 1.0).normalize();
        (normal, normal)
    };
    for (columns, rows) in [(1, 1), (5, 1), (4, 4)] {
        let mesh = parse(&grid(columns, rows, patch, DVec2::new), &options());
        assert_sound(&mesh);
        for corner in corners(&mesh) {
            let [low, high] = corner.quadric.principal_curvatures();
            assert!(
                (low - 1.0).abs() < 0.05 && (high - 1.0).abs() < 0.05,
                "{low} {high}"
            );
        }
    }
}

#[test]
fn a_vertex_without_a_fit_takes_its_neighbours_mean() {
    // The apex sees its ring edge-on: no neighbour's normal agrees with its own.
    let mut text = cylinder(1.0, DVec2::new);
    writeln!(text, "v 0 9 0\nvn 0 1 0\nvt 0 0").unwrap();
    let rim = 4 * 33;
    for column in 1..=32 {
        let (a, b) = (rim + column, rim + column + 1);
        writeln!(text, "f {a}/{a}/{a} {b}/{b}/{b} -1/-1/-1").unwrap();
    }
    let mesh = parse(&text, &options());
    assert_sound(&mesh);
    // The mean over all directions around the axis is isotropic.
    for apex in corners(&mesh).filter(|corner| corner.position.y > 8.0) {
        let [low, high] = apex.quadric.principal_curvatures();
        assert!(low > 0.1 && (high - low).abs() < 1e-6, "{low} {high}");
    }
}

#[test]
fn flawed_triangles_do_no_harm() {
    // Non-manifold: three faces on one edge, one of them twice, one with its
    // winding reversed; then degenerate ones and texture coordinates without
    // an area.
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 -1 0.5\nv 0 0 1\nv 2 0 0\nvt 0 0\nvt 1 0\nvt 0 1\n\
                f 1/1 2/2 3/3\nf 1/1 2/2 3/3\nf 2/2 1/1 4/3\nf 2/1 1/1 5/1\n\
                f 1/1 2/2 6/3\nf 1/1 1/2 2/3\nf 3/3 2/2 1/1\n";
    let mesh = parse(text, &options());
    assert_sound(&mesh);
    assert_eq!(mesh.report.skipped_degenerate, 2);
    assert_eq!(mesh.triangles[3].corners[0].gradient_u, DVec3::ZERO);

    let error = Mesh::parse(
        "v 0 0 0\nv 1 0 0\nvt 0 0\nf 1/1 2/1 1/1\n",
        Path::new("x.obj"),
        &options(),
    )
    .unwrap_err();
    assert!(matches!(error, MeshError::AllDegenerate { skipped: 1, .. }));
    let error = Mesh::parse(
        "v 1 1 1\nvt 0 0\nf 1/1 1/1 1/1\n",
        Path::new("x.obj"),
        &options(),
    )
    .unwrap_err();
    assert!(matches!(error, MeshError::AllDegenerate { skipped: 1, .. }));
}

#[test]
fn triangles_too_thin_for_f32_get_a_frame() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1e-8 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n";
    let mesh = parse(text, &options());
    assert_sound(&mesh);
    assert!(mesh.triangles[0].corners[0].tangent.distance(DVec3::X) < 1e-12);
    assert_eq!(mesh.triangles[0].corners[0].handedness, 1.0);
}

#[test]
fn a_vertex_with_very_many_faces_is_no_obstacle() {
    let count = 20_000;
    let mut text = String::from("v 0 0 0\nvt 0.5 0.5\n");
    for step in 0..count {
        let (sin, cos) = (TAU * f64::from(step) / f64::from(count)).sin_cos();
        writeln!(
            text,
            "v {cos} {sin} 0\nvt {} {}",
            0.5 + 0.5 * cos,
            0.5 + 0.5 * sin
        )
        .unwrap();
    }
    for step in 0..count {
        let (a, b) = (2 + step, 2 + (step + 1) % count);
        writeln!(text, "f 1/1 {a}/{a} {b}/{b}").unwrap();
    }
    let mesh = parse(&text, &options());
    assert_sound(&mesh);
    assert!(
        corners(&mesh)
            .all(|corner| corner.tangent.distance(DVec3::X) < 1e-6 && corner.handedness == 1.0)
    );
}

#[test]
fn unusable_transforms_are_refused() {
    let fails =
        |options: MeshOptions| Mesh::parse(&cube(), Path::new("cube.obj"), &options).unwrap_err();
    for scale in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(
            fails(MeshOptions { scale, ..options() }),
            MeshError::InvalidTransform { .. }
        ));
    }
    let rotation = DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0);
    assert!(matches!(
        fails(MeshOptions {
            rotation,
            ..options()
        }),
        MeshError::InvalidTransform { .. }
    ));
    let translation = DVec3::new(0.0, f64::NAN, 0.0);
    assert!(matches!(
        fails(MeshOptions {
            translation,
            ..options()
        }),
        MeshError::InvalidTransform { .. }
    ));
    for (scale, reach) in [(1e-200, 0.0), (1e200, 0.0), (1.0, 1e13)] {
        let translation = DVec3::splat(reach);
        let error = fails(MeshOptions {
            scale,
            translation,
            ..options()
        });
        assert!(matches!(error, MeshError::SizeOutOfRange { .. }), "{error}");
    }
    assert!(matches!(
        fails(MeshOptions {
            triangle_limit: 11,
            ..options()
        }),
        MeshError::TooManyTriangles { .. }
    ));
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let text = strip_corners(&sphere(), |corner| corner[..2].join("/"));
    let with_threads = |count| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(count)
            .build()
            .unwrap();
        pool.install(|| parse(&text, &options()))
    };
    assert_eq!(with_threads(1), with_threads(5));
}

/// On a torus the averaged gradients are more accurate than those of single
/// triangles, and corners at one position agree, also across the seam.
#[test]
fn corner_gradients_are_smooth_and_right() {
    let torus = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets/meshes/torus.obj");
    let mesh = Mesh::load(&torus, &MeshOptions::default()).unwrap();
    let (major, minor) = (1.0, 0.4);
    let mut worst: f64 = 0.0;
    let mut shared = std::collections::BTreeMap::new();
    for corner in corners(&mesh) {
        let p = corner.position;
        let radius = p.x.hypot(p.z);
        // u turns from +z towards +x; v rises from the outer equator.
        let along_u = DVec3::new(p.z, 0.0, -p.x) / radius;
        let along_v = corner.normal.cross(along_u);
        let true_u = along_u / (std::f64::consts::TAU * radius);
        let true_v = along_v / (std::f64::consts::TAU * minor);
        worst = worst
            .max(corner.gradient_u.distance(true_u) / true_u.length())
            .max(corner.gradient_v.distance(true_v) / true_v.length());
        assert!(radius <= major + minor + 1e-6);
        let known = shared
            .entry(corner.position_index)
            .or_insert(corner.gradient_u);
        assert!(known.distance(corner.gradient_u) < 1e-9);
    }
    assert!(worst < 0.04, "{worst}");
}

/// At a pole u has another direction in every triangle: each corner keeps its own.
#[test]
fn a_pole_keeps_the_gradients_of_its_triangles() {
    let sphere =
        std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets/meshes/sphere.obj");
    let mesh = Mesh::load(&sphere, &MeshOptions::default()).unwrap();
    let pole: Vec<&MeshCorner> = corners(&mesh)
        .filter(|corner| corner.position.y > 1.0 - 1e-9)
        .collect();
    assert_eq!(pole.len(), 32);
    let mean = pole.iter().map(|corner| corner.gradient_u).sum::<DVec3>() / 32.0;
    let length = pole[0].gradient_u.length();
    assert!(
        mean.length() < 1e-3 * length,
        "they cancel: the mean would be none"
    );
    assert!(
        pole.iter()
            .all(|corner| corner.gradient_u.length() > 0.9 * length)
    );
}
