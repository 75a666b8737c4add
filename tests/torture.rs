//! Meshes made to be hard to carve: slivers, cuts, noise, a thin plate, one side, and cubes
//! that share an edge.

use std::collections::HashMap;
use std::f64::consts::TAU;

use crate::real::{VIEWS, compare};
use glam::{DVec3, Vec3Swizzles};
use relievo::mesh::{MeshData, Projection};
use relievo::prepare::Assets;
use relievo::scene::{Scene, SceneObject, Tier};
use relievo_tests::asset;

/// The corners of the six tetrahedra of a cube; bits are x, y, z.
const TETRAHEDRA: [[usize; 4]; 6] = [
    [0, 1, 3, 7],
    [0, 3, 2, 7],
    [0, 2, 6, 7],
    [0, 6, 4, 7],
    [0, 4, 5, 7],
    [0, 5, 1, 7],
];

/// Returns the surface f = 0 of the body f < 0 within the cube from −1 to 1, by marching
/// tetrahedra over `cells`³ cubes. Triangles are slivers where it passes near a grid point.
fn marched(name: &str, cells: usize, f: impl Fn(DVec3) -> f64) -> MeshData {
    let point = |i: [usize; 3]| DVec3::from(i.map(|i| 2.06 * (i as f64 / cells as f64 - 0.5)));
    let number = |i: [usize; 3]| (i[0] * (cells + 1) + i[1]) * (cells + 1) + i[2];
    let mut vertices: HashMap<[usize; 2], u32> = HashMap::new();
    let mut positions: Vec<[f64; 3]> = Vec::new();
    let mut triangles = Vec::new();
    for cell in 0..cells.pow(3) {
        let first = [cell / (cells * cells), cell / cells % cells, cell % cells];
        for tetrahedron in TETRAHEDRA {
            let corners = tetrahedron.map(|bits| {
                let i = [0, 1, 2].map(|axis| first[axis] + (bits >> axis & 1));
                (number(i), point(i), f(point(i)))
            });
            let (inside, outside): (Vec<_>, Vec<_>) =
                corners.into_iter().partition(|(_, _, value)| *value < 0.0);
            let mut between = |i: usize, o: usize| {
                let ((a, from, fa), (b, to, fb)) = (inside[i], outside[o]);
                *vertices.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                    positions.push(from.lerp(to, fa / (fa - fb)).to_array());
                    positions.len() as u32 - 1
                })
            };
            let polygon = match inside.len() {
                1 => vec![between(0, 0), between(0, 1), between(0, 2)],
                2 => vec![between(0, 0), between(0, 1), between(1, 1), between(1, 0)],
                3 => vec![between(0, 0), between(1, 0), between(2, 0)],
                _ => continue,
            };
            for i in 2..polygon.len() {
                let [a, b, c] = [polygon[0], polygon[i - 1], polygon[i]];
                let [p, q, r] = [a, b, c].map(|v| DVec3::from(positions[v as usize]));
                let is_out = (q - p).cross(r - p).dot(outside[0].1 - inside[0].1) > 0.0;
                triangles.push(if is_out { [a, b, c] } else { [a, c, b] });
            }
        }
    }
    MeshData::new(name, positions, triangles)
}

/// Returns the triangles of a grid of `columns` × `rows` quads over vertices in rows of
/// `stride`.
fn grid(first: u32, columns: u32, rows: u32, stride: u32) -> Vec<[u32; 3]> {
    let quads = (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row)));
    quads
        .flat_map(|(column, row)| {
            let a = first + row * stride + column;
            let [b, c, d] = [a + 1, a + stride + 1, a + stride];
            [[a, b, c], [a, c, d]]
        })
        .collect()
}

/// A labyrinth cut by a ball.
fn gyroid() -> MeshData {
    marched("gyroid", 28, |p| {
        let q = 5.0 * p;
        let gyroid = q.x.sin() * q.y.cos() + q.y.sin() * q.z.cos() + q.z.sin() * q.x.cos();
        (0.15 * gyroid).max(p.length() - 0.95)
    })
}

/// A box with two bores and a slot, whose edges the grid cuts off.
fn cuts() -> MeshData {
    marched("cuts", 26, |p| {
        let body = (p.abs() - DVec3::new(0.8, 0.6, 0.7)).max_element();
        let bores = (0.35 - p.truncate().length()).max(0.25 - p.yz().length());
        let slot = -(p - DVec3::new(0.5, 0.6, 0.0))
            .abs()
            .dot(DVec3::new(0.9, 0.3, 0.0))
            + 0.2;
        body.max(bores).max(slot)
    })
}

/// A ball whose vertices are moved by up to 8 % of the radius.
fn noise() -> MeshData {
    let mut random = fastrand::Rng::with_seed(1);
    let ball = marched("noise", 16, |p| p.length() - 0.8);
    let moved = ball.positions.iter().map(|position| {
        let p = DVec3::from(*position);
        (p * (1.0 + 0.16 * (random.f64() - 0.5))).to_array()
    });
    MeshData::new("noise", moved.collect::<Vec<_>>(), ball.triangles)
}

/// A closed plate of 2 × 2 × 0.03, less thick than deep.
fn plate() -> MeshData {
    let side = |z: f64| {
        (0..81).map(move |i| {
            [
                0.25 * f64::from(i % 9) - 1.0,
                0.25 * f64::from(i / 9) - 1.0,
                z,
            ]
        })
    };
    let mut triangles = grid(81, 8, 8, 9);
    triangles.extend(grid(0, 8, 8, 9).iter().map(|[a, b, c]| [*a, *c, *b]));
    // Around the rim, counter-clockwise.
    let rim: Vec<u32> = (0..8)
        .chain((0..8).map(|i| 8 + 9 * i))
        .chain((1..9).rev().map(|i| 72 + i))
        .chain((1..9).rev().map(|i| 9 * i))
        .collect();
    for (i, &a) in rim.iter().enumerate() {
        let b = rim[(i + 1) % rim.len()];
        triangles.extend([[a, b, b + 81], [a, b + 81, a + 81]]);
    }
    MeshData::new(
        "plate",
        side(-0.015).chain(side(0.015)).collect::<Vec<_>>(),
        triangles,
    )
}

/// A Möbius band: a sheet that no orientation fits.
fn band() -> MeshData {
    let around = 48;
    let positions = (0..around * 7).map(|i| {
        let angle = TAU * f64::from(i / 7) / f64::from(around);
        let across = (f64::from(i % 7) / 3.0 - 1.0) * 0.35;
        let radius = 1.0 + across * (0.5 * angle).cos();
        [
            radius * angle.cos(),
            across * (0.5 * angle).sin(),
            radius * angle.sin(),
        ]
    });
    let mut triangles = grid(0, 6, around - 1, 7);
    let last = 7 * (around - 1);
    for i in 0..6 {
        // The last row meets the first one turned round.
        let [a, b, c, d] = [last + i, last + i + 1, 5 - i, 6 - i];
        triangles.extend([[a, b, c], [a, c, d]]);
    }
    MeshData::new("band", positions.collect::<Vec<_>>(), triangles)
}

/// Two cubes that share an edge, where four sides meet.
fn cubes() -> MeshData {
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    for centre in [DVec3::new(-0.5, -0.5, 0.0), DVec3::new(0.5, 0.5, 0.0)] {
        for axis in 0..3 {
            for sign in [-1.0, 1.0] {
                let first = positions.len() as u32;
                for i in 0..25 {
                    let [u, v] = [i % 5, i / 5].map(|i| 0.25 * f64::from(i) - 0.5);
                    let mut p = [0.0; 3];
                    p[axis] = 0.5 * sign;
                    p[(axis + 1) % 3] = u;
                    p[(axis + 2) % 3] = v;
                    positions.push((centre + DVec3::from(p)).to_array());
                }
                let turned = |[a, b, c]: [u32; 3]| if sign > 0.0 { [a, b, c] } else { [a, c, b] };
                triangles.extend(grid(first, 4, 4, 5).into_iter().map(turned));
            }
        }
    }
    MeshData::new("cubes", positions, triangles)
}

/// The accurate tier against the mesh oracle, from three sides.
#[test]
fn tortures_are_carved_whole() {
    let mut broken = Vec::new();
    for mesh in [gyroid(), cuts(), noise(), plate(), band(), cubes()] {
        for rotate in VIEWS {
            let scene_of = |tier: Tier| {
                let object = SceneObject::new(mesh.clone(), asset("patterns/discs.png"))
                    .repeat(12, 8)
                    .projection(Projection::Spherical)
                    .rotate(rotate)
                    .tier(tier);
                Scene::default().size(400, 300).object(object)
            };
            let ([fast, accurate], [pixels, lost]) = compare(scene_of, &mut Assets::default());
            println!(
                "{} {rotate:?}, {} triangles: accurate {:.4} / {}, extra {}; fast {:.4} / {}, inner misses {lost} of {pixels}",
                mesh.name,
                mesh.triangles.len(),
                accurate.silhouette_iou,
                accurate.interior_holes,
                accurate.extra,
                fast.silhouette_iou,
                fast.interior_holes,
            );
            if accurate.silhouette_iou < 0.999 || accurate.interior_holes > 0 {
                broken.push(format!("{} {rotate:?}: {accurate:?}", mesh.name));
            }
        }
    }
    assert!(broken.is_empty(), "{broken:#?}");
}
