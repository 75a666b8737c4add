//! The prisms of whole meshes.

use std::f64::consts::{PI, TAU};
use std::fmt::Write;
use std::path::Path;

use glam::{DVec2, Vec3Swizzles};

use super::super::{MeshOptions, orient};
use super::*;

fn asset(name: &str) -> Mesh {
    let path = format!("{}/../assets/meshes/{name}.obj", env!("CARGO_MANIFEST_DIR"));
    Mesh::load(Path::new(&path), &MeshOptions::default()).unwrap()
}

fn parse(text: &str) -> Mesh {
    Mesh::parse(text, Path::new("test.obj"), &MeshOptions::default()).unwrap()
}

/// Creates a mesh from positions and triangles; `normal` returns the normal of a
/// corner from the triangle's index and the position.
fn mesh(
    positions: &[DVec3],
    triangles: &[[usize; 3]],
    normal: impl Fn(usize, DVec3) -> DVec3,
) -> Mesh {
    let mut text = String::new();
    for p in positions {
        writeln!(text, "v {} {} {}\nvt {} {}", p.x, p.y, p.z, p.x, p.y).unwrap();
    }
    for (index, corners) in triangles.iter().enumerate() {
        let mut face = String::from("f");
        for (i, corner) in corners.iter().enumerate() {
            let n = normal(index, positions[*corner]);
            writeln!(text, "vn {} {} {}", n.x, n.y, n.z).unwrap();
            let number = corner + 1;
            write!(face, " {number}/{number}/{}", 3 * index + i + 1).unwrap();
        }
        writeln!(text, "{face}").unwrap();
    }
    parse(&text)
}

/// A sphere of radius 1 with `2 count` slices and `count` stacks, its poles cut off.
fn sphere(count: usize) -> Mesh {
    let columns = 2 * count;
    let mut positions = Vec::new();
    for row in 0..=count {
        for column in 0..columns {
            let (sin, cos) = (TAU * column as f64 / columns as f64).sin_cos();
            let (rise, run) = (0.8 * PI * (row as f64 / count as f64 - 0.5)).sin_cos();
            positions.push(DVec3::new(run * sin, rise, run * cos));
        }
    }
    let mut triangles = Vec::new();
    for row in 0..count {
        for column in 0..columns {
            let index = |dx: usize, dy: usize| (row + dy) * columns + (column + dx) % columns;
            triangles.push([index(0, 0), index(1, 0), index(1, 1)]);
            triangles.push([index(0, 0), index(1, 1), index(0, 1)]);
        }
    }
    mesh(&positions, &triangles, |_, position| position)
}

/// The cube with the corners ±1; its edges are hard unless `smooth`.
fn cube(smooth: bool) -> Mesh {
    let (positions, triangles) = orient::tests::cube(1.0, DVec3::ZERO);
    let triangles: Vec<_> = triangles
        .iter()
        .map(|triangle| triangle.map(|vertex| vertex as usize))
        .collect();
    mesh(&positions, &triangles, |index, position| {
        let axis = index / 4;
        let face = DVec3::AXES[axis] * position[axis];
        if smooth { position } else { face }
    })
}

/// A cylinder around z with radius 1 and height 1, with caps and hard rims.
fn capped_cylinder() -> Mesh {
    let count = 24;
    let mut positions = vec![DVec3::ZERO, DVec3::Z];
    for i in 0..count {
        let (sin, cos) = (TAU * i as f64 / count as f64).sin_cos();
        positions.extend([DVec3::new(cos, sin, 0.0), DVec3::new(cos, sin, 1.0)]);
    }
    let mut triangles = Vec::new();
    for i in 0..count {
        let [a, b] = [i, (i + 1) % count].map(|i| 2 + 2 * i);
        triangles.extend([
            [0, b, a],
            [1, a + 1, b + 1],
            [a, b, b + 1],
            [a, b + 1, a + 1],
        ]);
    }
    mesh(&positions, &triangles, |index, position| match index % 4 {
        0 => -DVec3::Z,
        1 => DVec3::Z,
        _ => position.with_z(0.0),
    })
}

/// Evenly distributed weights and fractions of a depth.
fn samples(count: usize) -> impl Iterator<Item = (DVec2, f64)> {
    (1..=count).map(|i| {
        let [a, b, c] = [0.8191725, 0.6710436, 0.5497005].map(|x| (i as f64 * x).fract());
        let w = DVec2::new(a, b);
        (if a + b > 1.0 { DVec2::ONE - w } else { w }, c)
    })
}

/// F at the depth d.
fn point(prism: &MeshPrism, w: DVec2, d: f64) -> DVec3 {
    prism.anchor + prism.surface().at(w) - d * prism.normal().at(w)
}

/// On the side opposite to a corner, `share` of the way to its end.
fn on_side(opposite: usize, share: f64) -> DVec2 {
    let corners = quadratic::WHOLE;
    corners[(opposite + 1) % 3].lerp(corners[(opposite + 2) % 3], share)
}

/// Side `opposite` of prism number `index`, and the neighbour's side there.
fn links(prisms: &[MeshPrism]) -> impl Iterator<Item = [(usize, usize); 2]> {
    let sides = (0..prisms.len()).flat_map(|index| [0, 1, 2].map(|opposite| (index, opposite)));
    sides.filter_map(|(index, opposite)| {
        let link = prisms[index].neighbours[opposite];
        let other = ((link >> 2) as usize, (link & 3) as usize);
        (link != NO_NEIGHBOUR).then_some([(index, opposite), other])
    })
}

/// Checks that links are symmetric; returns the numbers of linked and of free
/// sides.
fn count_links(prisms: &[MeshPrism]) -> (usize, usize) {
    for [(index, opposite), (other, its_opposite)] in links(prisms) {
        let back = prisms[other].neighbours[its_opposite];
        assert_eq!(back as usize, 4 * index + opposite);
        for share in [0.0, 1.0] {
            let here = point(&prisms[index], on_side(opposite, share), 0.0);
            let there = point(&prisms[other], on_side(its_opposite, 1.0 - share), 0.0);
            assert!(here.distance(there) < 1e-12);
        }
    }
    let count = links(prisms).count();
    (count, 3 * prisms.len() - count)
}

/// Returns the largest gap between neighbours on their common side to `depth`.
fn widest_gap(prisms: &[MeshPrism], depth: f64) -> f64 {
    let mut widest: f64 = 0.0;
    for [(index, opposite), (other, its_opposite)] in links(prisms) {
        for (w, fraction) in samples(8) {
            let here = point(&prisms[index], on_side(opposite, w.x), depth * fraction);
            let there = point(
                &prisms[other],
                on_side(its_opposite, 1.0 - w.x),
                depth * fraction,
            );
            widest = widest.max(here.distance(there));
        }
    }
    widest
}

#[test]
fn a_sphere_is_met_to_third_order() {
    let errors = |count| {
        let prisms = sphere(count).prisms();
        let (mut surface, mut facet): (f64, f64) = (0.0, 0.0);
        for prism in &prisms {
            let [a, b, c] = prism.corners();
            for (w, _) in samples(30) {
                let on_facet = prism.anchor + a + w.x * (b - a) + w.y * (c - a);
                facet = facet.max((on_facet.length() - 1.0).abs());
                surface = surface.max((point(prism, w, 0.0).length() - 1.0).abs());
            }
            for opposite in 0..3 {
                let normal = prism.normal().at(on_side(opposite, 0.5));
                assert!((normal.length() - 1.0).abs() < 1e-12);
            }
        }
        (surface, facet)
    };
    let (coarse, fine) = (errors(16), errors(32));
    assert!(coarse.0 > 7.0 * fine.0, "{coarse:?} {fine:?}");
    // The triangles are of second order only.
    assert!(coarse.1 < 5.0 * fine.1, "{coarse:?} {fine:?}");
}

#[test]
fn a_cube_with_hard_edges_has_flat_floors() {
    let flat = |mesh: &Mesh| {
        let mut worst: f64 = 0.0;
        for prism in mesh.prisms() {
            let n = prism.area_normal().normalize();
            for (w, fraction) in samples(20) {
                worst = worst.max((point(&prism, w, fraction).dot(n) - (1.0 - fraction)).abs());
            }
        }
        worst
    };
    let hard = cube(false);
    assert!(flat(&hard) < 1e-12);
    assert!(flat(&cube(true)) > 0.1);
    let prisms = hard.prisms();
    assert_eq!(count_links(&prisms), (36, 0));
    for (prism, triangle) in prisms.iter().zip(&hard.triangles) {
        // The mitre of a corner of this cube is its position.
        assert!(prism.normal[0].distance(prism.anchor) < 1e-12);
        let n = triangle.corners[0].normal;
        assert!(prism.corner_normals.iter().all(|corner| *corner == n));
        let depth = prism.largest_depth();
        assert!((0.96..0.97).contains(&depth), "{depth}");
    }
}

#[test]
fn neighbours_are_found_on_both_sides() {
    let torus = asset("torus").prisms();
    assert_eq!(count_links(&torus), (3 * torus.len(), 0));
    // Two by two squares.
    let plane = asset("plane").prisms();
    assert_eq!(count_links(&plane), (16, 8));
    assert_eq!(plane[0].largest_depth(), f64::INFINITY);
    assert_eq!(count_links(&capped_cylinder().prisms()).1, 0);
}

#[test]
fn there_are_no_neighbours_where_the_surface_is_none() {
    let up = |_: usize, _: DVec3| DVec3::Y;
    let positions = [
        DVec3::ZERO,
        DVec3::X,
        DVec3::new(0.5, 0.2, 1.0),
        DVec3::new(0.5, 0.0, -1.0),
        DVec3::new(0.5, 1.0, -0.2),
    ];
    let pair = mesh(&positions, &[[0, 2, 1], [0, 1, 3]], up);
    assert_eq!(count_links(&pair.prisms()), (2, 4));
    let mut turned = pair.clone();
    turned.triangles[1].corners.swap(0, 1);
    assert_eq!(count_links(&turned.prisms()), (0, 6));
    let fin = mesh(&positions, &[[0, 2, 1], [0, 1, 3], [0, 1, 4]], up);
    assert_eq!(count_links(&fin.prisms()), (0, 9));
    // A sheet with two sides: its floors lie on either side of it.
    let sheet = mesh(&positions, &[[0, 2, 1], [0, 1, 2]], |index, _| {
        DVec3::Y * (1.0 - 2.0 * index as f64)
    });
    let prisms = sheet.prisms();
    assert_eq!(count_links(&prisms), (0, 6));
    assert_eq!(prisms[0].normal[0], DVec3::Y);
    assert_eq!(prisms[1].normal[0], -DVec3::Y);
    // Two triangles with the same corners, closed.
    let bag = mesh(&positions, &[[0, 2, 1], [0, 1, 2]], |index, position| {
        DVec3::Y * (0.9 - 1.8 * index as f64) + 0.5 * (position - DVec3::new(0.5, 0.0, 0.3))
    });
    assert_eq!(count_links(&bag.prisms()), (6, 0));
}

#[test]
fn neighbours_meet_on_their_common_side() {
    for mesh in [asset("torus"), asset("blob"), capped_cylinder(), cube(true)] {
        let prisms = mesh.prisms();
        let gap = widest_gap(&prisms, 0.3);
        assert!(gap < 1e-13, "{gap:e}");
        // Bit for bit the same E and G, where they are coefficients.
        let mut compared = 0;
        for [(index, opposite), (other, its_opposite)] in links(&prisms) {
            let [one, two] = [(index, opposite), (other, its_opposite)].map(|(i, side)| {
                (side > 0).then(|| {
                    let power = [4, 2][side - 1];
                    (prisms[i].surface[power], prisms[i].normal[power + 1])
                })
            });
            if let (Some(one), Some(two)) = (one, two) {
                assert_eq!(one, two);
                compared += 1;
            }
        }
        assert!(compared > 0);
    }
    // Counterexample: with separate normals for every face the rim has gaps.
    let mesh = capped_cylinder();
    let welded = mesh.prisms();
    let mut unwelded = mesh.clone();
    for (index, triangle) in (0..).zip(&mut unwelded.triangles) {
        for (i, corner) in (0..).zip(&mut triangle.corners) {
            corner.position_index = 3 * index + i;
        }
    }
    let mut apart = unwelded.prisms();
    for (prism, welded) in apart.iter_mut().zip(&welded) {
        prism.neighbours = welded.neighbours;
    }
    assert!(widest_gap(&apart, 0.3) > 0.1);
}

#[test]
fn prisms_do_not_depend_on_the_order_of_triangles() {
    let mesh = asset("blob");
    let prisms = mesh.prisms();
    let mut reversed = mesh.clone();
    reversed.triangles.reverse();
    let again = reversed.prisms();
    for (prism, other) in prisms.iter().zip(again.iter().rev()) {
        assert_eq!(prism.anchor, other.anchor);
        for (a, b) in prism.surface.iter().zip(&other.surface) {
            assert!(a.distance(*b) < 1e-15);
        }
    }
    assert_eq!(prisms, mesh.prisms());
}

/// Returns the determinant at the depth d, relative to the flat prism's.
fn determinant(prism: &MeshPrism, w: DVec2, d: f64) -> f64 {
    let (surface, normal) = (prism.surface(), prism.normal());
    let ([s1, s2], [n1, n2]) = (surface.slopes(w), normal.slopes(w));
    (s1 - d * n1).cross(s2 - d * n2).dot(normal.at(w)) / prism.area_normal().length()
}

#[test]
fn prisms_fold_right_below_their_largest_depth() {
    for mesh in [
        asset("torus"),
        asset("sphere"),
        asset("blob"),
        asset("saddle"),
        asset("ellipsoid"),
        capped_cylinder(),
        cube(false),
        cube(true),
    ] {
        let mut folding = 0;
        for prism in mesh.prisms() {
            let depth = prism.largest_depth();
            assert!(prism.safe_depth() <= depth * (1.0 + 1e-12));
            if depth.is_infinite() {
                continue;
            }
            assert!(depth > 0.0);
            folding += 1;
            let corners = quadratic::WHOLE.map(|w| (w, 0.5));
            let least = |to: f64| {
                samples(500)
                    .chain(corners)
                    .map(|(w, _)| determinant(&prism, w, to))
                    .fold(f64::INFINITY, f64::min)
            };
            for (w, fraction) in samples(100) {
                assert!(determinant(&prism, w, depth * fraction) > FOLDED);
            }
            assert!(least(0.9999 * depth) > FOLDED, "{depth}");
            assert!(
                least(1.03 * depth) < FOLDED,
                "{depth} {}",
                least(1.03 * depth)
            );
        }
        assert!(folding > 0);
    }
}

#[test]
fn the_largest_depth_is_the_least_radius_of_curvature() {
    let least = |mesh: &Mesh| {
        let prisms = mesh.prisms();
        let depths = prisms.iter().map(MeshPrism::largest_depth);
        depths.fold(f64::INFINITY, f64::min)
    };
    let torus = least(&asset("torus"));
    assert!((0.38..0.42).contains(&torus), "{torus}");
    // Both curvatures: the determinant is (1 − d)².
    let sphere = least(&asset("sphere"));
    assert!((0.94..1.0).contains(&sphere), "{sphere}");
    // A surface that is folded itself.
    let mut folded = asset("torus").prisms()[0];
    folded.normal = folded.normal.map(|n| -n);
    assert_eq!(folded.largest_depth(), 0.0);
}

/// Asserts that no prism of a mesh's shell folds, and that they meet.
fn assert_unfolded(mesh: &Mesh, depth: f64) -> Shell {
    let shell = mesh.shell(depth);
    for (index, prism) in shell.prisms.iter().enumerate() {
        assert!(
            prism
                .shares
                .iter()
                .all(|share| *share > 0.0 && *share <= 1.0)
        );
        assert!(prism.largest_depth() > shell.depth, "triangle {index}");
        assert!(prism.normal.iter().all(|n| n.is_finite()));
    }
    assert!(shell.depth <= depth);
    let gap = widest_gap(&shell.prisms, shell.depth);
    assert!(gap < 1e-12 * mesh.bounds.diagonal(), "{gap:e}");
    shell
}

#[test]
fn where_nothing_limits_the_depth_the_shell_is_the_prisms() {
    for (mesh, depth) in [
        (asset("torus"), 0.17),
        (asset("blob"), 0.08),
        (asset("plane"), 10.0),
        (asset("saddle"), 0.1),
        (cube(false), 0.4),
    ] {
        let shell = assert_unfolded(&mesh, depth);
        assert_eq!(shell.prisms, mesh.prisms());
        assert_eq!((shell.local_depth, shell.depth), (None, depth));
    }
}

#[test]
fn the_local_depth_ends_where_prisms_would_fold() {
    // 45 % of the tube's radius of 0.4.
    let torus = asset("torus");
    for depth in [0.45, 1.0, 100.0] {
        let shell = assert_unfolded(&torus, depth);
        let LocalDepth {
            share,
            least,
            median,
        } = shell.local_depth.unwrap();
        assert!((share - 1.0).abs() < 1e-12, "{share}");
        assert!((0.178..0.182).contains(&least), "{least}");
        assert!((0.178..0.182).contains(&median), "{median}");
        assert_eq!(count_links(&shell.prisms).1, 0);
    }
}

/// A square plate from z = 0 to `thickness`, with `count` squares along each side.
fn plate(count: usize, thickness: f64) -> Mesh {
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    let side = count + 1;
    for layer in 0..2 {
        for i in 0..side * side {
            let [x, y] = [i % side, i / side].map(|at| at as f64 / count as f64);
            positions.push(DVec3::new(x, y, thickness * layer as f64));
        }
    }
    let top = side * side;
    let mut quad = |a: usize, b: usize, c: usize, d: usize| {
        triangles.extend([[a, b, c], [a, c, d]]);
    };
    for i in 0..count * count {
        let at = i % count + i / count * side;
        quad(top + at, top + at + 1, top + at + side + 1, top + at + side);
        quad(at, at + side, at + side + 1, at + 1);
    }
    for i in 0..count {
        let rims = [
            [i, i + 1],
            [count * side + i + 1, count * side + i],
            [(i + 1) * side, i * side],
            [i * side + count, (i + 1) * side + count],
        ];
        for [a, b] in rims {
            quad(a, b, top + b, top + a);
        }
    }
    mesh(&positions, &triangles, |index, _| {
        let faces = 4 * count * count;
        if index >= faces {
            let [a, b, c] = triangles[index].map(|i| positions[i]);
            (b - a).cross(c - a)
        } else if index % 4 < 2 {
            DVec3::Z
        } else {
            -DVec3::Z
        }
    })
}

#[test]
fn opposite_floors_meet_in_the_middle() {
    let plate = plate(8, 0.1);
    let shell = assert_unfolded(&plate, 0.3);
    let mut met: f64 = 0.0;
    for (prism, triangle) in shell.prisms.iter().zip(&plate.triangles) {
        let up = triangle.corners[0].normal.z;
        for (w, _) in samples(9).filter(|_| up.abs() > 0.5) {
            let floor = point(prism, w, shell.depth).z;
            let past = up * (0.05 - floor);
            assert!(past < 1e-12, "{past:e}");
            met = met.max(floor.min(0.1 - floor));
        }
    }
    assert!((met - 0.05).abs() < 1e-12, "{met}");
    // A thicker one has all of the depth, but triangles at the rim fold where they
    // are as deep as wide.
    assert_eq!(self::plate(2, 1.0).shell(0.3).local_depth, None);
    assert!(self::plate(8, 1.0).shell(0.3).local_depth.is_some());
}

#[test]
fn no_mesh_is_too_bad_for_a_shell() {
    let noise = |seed: f64| {
        move |position: DVec3| {
            let mix = |v: DVec3| (43758.5453 * (v.dot(DVec3::new(12.9, 78.2, seed))).sin()).fract();
            DVec3::new(mix(position), mix(position.zxy()), mix(position.yzx()))
        }
    };
    // A rough sphere, and one with normals in any direction.
    let mut rough = sphere(24);
    for triangle in &mut rough.triangles {
        for corner in &mut triangle.corners {
            let position = corner.position;
            corner.position += 0.1 * noise(3.0)(position);
        }
    }
    let mut random = sphere(12);
    for triangle in &mut random.triangles {
        for corner in &mut triangle.corners {
            corner.normal = (noise(5.0)(corner.position) + 0.01).normalize();
        }
    }
    // Two cubes that share an edge, and two that share a corner.
    let two_cubes = |shift: DVec3| {
        let one = cube(false);
        let mut both = one.clone();
        for mut triangle in one.triangles.iter().copied() {
            for corner in &mut triangle.corners {
                corner.position += shift;
                let known = one.triangles.iter().flat_map(|triangle| triangle.corners);
                let same = known
                    .filter(|other| other.position == corner.position)
                    .map(|other| other.position_index)
                    .next();
                corner.position_index = same.unwrap_or(corner.position_index + 8);
            }
            both.triangles.push(triangle);
        }
        both
    };
    let by_edge = two_cubes(DVec3::new(2.0, 2.0, 0.0));
    let by_corner = two_cubes(DVec3::splat(2.0));
    for mesh in [&rough, &random, &by_edge, &by_corner] {
        for depth in [0.01, 0.3, 5.0] {
            assert_unfolded(mesh, depth);
        }
    }
    assert!(rough.shell(5.0).local_depth.is_some());
}

#[test]
fn the_local_depth_changes_slowly() {
    // A plate that is thin at one place only.
    let mut dented = plate(16, 1.0);
    let is_dent = |p: DVec3| p.z > 0.5 && p.distance(DVec3::new(0.5, 0.5, 1.0)) < 1e-9;
    for triangle in &mut dented.triangles {
        for corner in &mut triangle.corners {
            if is_dent(corner.position) {
                corner.position.z = 0.02;
            }
        }
    }
    let shell = assert_unfolded(&dented, 0.05);
    let reduced = shell.local_depth.unwrap();
    assert!(reduced.share < 0.1 && reduced.least < 0.011, "{reduced:?}");
    for (prism, triangle) in shell.prisms.iter().zip(&dented.triangles) {
        let depth = |i: usize| shell.depth * prism.normal().at(quadratic::WHOLE[i]).length();
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            let [p, q] = [a, b].map(|i| triangle.corners[i].position);
            let is_flat = |p: DVec3| {
                p.z.min(1.0 - p.z) < 1e-9 && p.x.min(1.0 - p.x).min(p.y.min(1.0 - p.y)) > 0.01
            };
            // N is longer at the rim and in the dent.
            if is_flat(p) && is_flat(q) && !is_dent(p) {
                let change = (depth(a) - depth(b)).abs();
                assert!(change <= 0.26 * p.distance(q), "{change} {p} {q}");
            }
        }
    }
}
