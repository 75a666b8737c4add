//! The meshes: torus, sphere, cylinder, plane, ellipsoid, saddle, a smooth
//! organic shape, and things that are turned on a lathe.
//!
//! y is up. Seen from outside, u increases to the right and v upwards, so that
//! ∂p/∂u × ∂p/∂v points outwards and images are not mirrored.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use crate::mesh::{Corner, Mesh};

/// Returns all meshes.
pub fn all() -> Vec<Mesh> {
    vec![
        torus(),
        sphere(),
        cylinder(),
        plane(),
        ellipsoid(),
        saddle(),
        blob(),
        vase(),
        ring(),
        lamp(),
    ]
}

/// A point of a surface: position and outward unit normal.
type SurfacePoint = (DVec3, DVec3);

/// A surface over a grid of quads in uv.
struct Grid {
    name: &'static str,
    description: &'static str,
    /// Quads along u and along v.
    quads: (usize, usize),
    /// Whether the surface is closed along u (u = 1 is u = 0) and along v.
    closed: (bool, bool),
}

impl Grid {
    /// Samples `surface` at the corners of the quads; two triangles per quad.
    fn mesh(&self, surface: impl Fn(DVec2) -> SurfacePoint) -> Mesh {
        let (columns, rows) = self.quads;
        let vertex_columns = columns + usize::from(!self.closed.0);
        let vertex_rows = rows + usize::from(!self.closed.1);
        let uv = |column: usize, row: usize| {
            DVec2::new(column as f64 / columns as f64, row as f64 / rows as f64)
        };
        let (positions, normals) = (0..vertex_rows)
            .flat_map(|row| (0..vertex_columns).map(move |column| uv(column, row)))
            .map(surface)
            .unzip();
        let uvs = (0..=rows)
            .flat_map(|row| (0..=columns).map(move |column| uv(column, row)))
            .collect();
        let corner = |column: usize, row: usize| Corner {
            vertex: row % vertex_rows * vertex_columns + column % vertex_columns,
            uv: row * (columns + 1) + column,
        };
        let mut triangles = Vec::with_capacity(2 * columns * rows);
        for row in 0..rows {
            for column in 0..columns {
                let low = corner(column, row);
                let high = corner(column + 1, row + 1);
                triangles.push([low, corner(column + 1, row), high]);
                triangles.push([low, high, corner(column, row + 1)]);
            }
        }
        Mesh {
            name: self.name,
            description: self.description,
            positions,
            normals,
            uvs,
            triangles,
        }
    }
}

/// Returns the unit vector at `angle` (radians) around the y axis, from +z towards
/// +x.
fn around_y(angle: f64) -> DVec3 {
    DVec3::new(angle.sin(), 0.0, angle.cos())
}

/// Returns the direction with longitude 2πu and latitude π(v − ½).
fn spherical(uv: DVec2) -> DVec3 {
    let latitude = PI * (uv.y - 0.5);
    around_y(TAU * uv.x) * latitude.cos() + DVec3::Y * latitude.sin()
}

/// Returns a torus around the y axis; u increases around the major circle, v around
/// the minor one, from the outer equator upwards.
fn torus() -> Mesh {
    const MAJOR_RADIUS: f64 = 1.0;
    const MINOR_RADIUS: f64 = 0.4;
    Grid {
        name: "torus",
        description: "Torus around the y axis, major radius 1, minor radius 0.4",
        quads: (39, 26),
        closed: (true, true),
    }
    .mesh(|uv| {
        let outwards = around_y(TAU * uv.x);
        let (sin, cos) = (TAU * uv.y).sin_cos();
        let normal = outwards * cos + DVec3::Y * sin;
        (outwards * MAJOR_RADIUS + normal * MINOR_RADIUS, normal)
    })
}

/// Returns a cylinder without caps around the y axis, from y = −1.5 (v = 0) to 1.5.
fn cylinder() -> Mesh {
    const HEIGHT: f64 = 3.0;
    Grid {
        name: "cylinder",
        description: "Open cylinder around the y axis, radius 1, height 3",
        quads: (48, 4),
        closed: (true, false),
    }
    .mesh(|uv| {
        let normal = around_y(TAU * uv.x);
        (normal + DVec3::Y * (HEIGHT * (uv.y - 0.5)), normal)
    })
}

/// Returns a square in the xz plane; u increases along +x, v along −z.
fn plane() -> Mesh {
    const SIDE: f64 = 2.0;
    Grid {
        name: "plane",
        description: "Square of side 2 in the plane y = 0, normal +y",
        quads: (2, 2),
        closed: (false, false),
    }
    .mesh(|uv| {
        let offset = (uv - 0.5) * SIDE;
        (DVec3::new(offset.x, 0.0, -offset.y), DVec3::Y)
    })
}

/// Returns a star-shaped surface around the origin with `slices` of longitude and
/// `stacks` of latitude. The outermost stacks are triangles; at a pole each has its
/// own texture coordinate, in the middle of its slice.
fn star_shaped(
    name: &'static str,
    description: &'static str,
    (slices, stacks): (usize, usize),
    surface: impl Fn(DVec3) -> SurfacePoint,
) -> Mesh {
    // The ring vertices are `inner` quads apart; the poles follow them.
    let inner = stacks - 2;
    let mut mesh = Grid {
        name,
        description,
        quads: (slices, inner),
        closed: (true, false),
    }
    .mesh(|uv| {
        let v = (uv.y * inner as f64 + 1.0) / stacks as f64;
        surface(spherical(DVec2::new(uv.x, v)))
    });
    for uv in &mut mesh.uvs {
        uv.y = (uv.y * inner as f64 + 1.0) / stacks as f64;
    }
    for (pole, v, ring) in [(-DVec3::Y, 0.0, 0), (DVec3::Y, 1.0, inner)] {
        let (position, normal) = surface(pole);
        let vertex = mesh.positions.len();
        mesh.positions.push(position);
        mesh.normals.push(normal);
        for slice in 0..slices {
            let tip = Corner {
                vertex,
                uv: mesh.uvs.len(),
            };
            mesh.uvs
                .push(DVec2::new((slice as f64 + 0.5) / slices as f64, v));
            let on_ring = |column: usize| Corner {
                vertex: ring * slices + column % slices,
                uv: ring * (slices + 1) + column,
            };
            let (left, right) = (on_ring(slice), on_ring(slice + 1));
            mesh.triangles.push(if ring == 0 {
                [right, left, tip]
            } else {
                [left, right, tip]
            });
        }
    }
    mesh
}

/// Returns the unit sphere; u is the longitude from +z towards +x, v the latitude
/// from −y.
fn sphere() -> Mesh {
    star_shaped(
        "sphere",
        "UV sphere, radius 1, 32 slices, 20 stacks",
        (32, 20),
        |direction| (direction, direction),
    )
}

/// Returns a smooth curve through `points` at `share` of its length; `is_closed` leads from the
/// last one back to the first one.
fn along(points: &[DVec2], is_closed: bool, share: f64) -> DVec2 {
    const STEPS: usize = 64;
    let count = points.len();
    let point = |index: isize| match is_closed {
        true => points[index.rem_euclid(count as isize) as usize],
        false => points[index.clamp(0, count as isize - 1) as usize],
    };
    // Catmull and Rom's curve.
    let at = |step: usize| {
        let (first, t) = (step / STEPS, (step % STEPS) as f64 / STEPS as f64);
        let [a, b, c, d] = [-1, 0, 1, 2].map(|offset| point(first as isize + offset));
        let cubic = 2.0 * b
            + (c - a) * t
            + (2.0 * a - 5.0 * b + 4.0 * c - d) * t * t
            + (3.0 * (b - c) + d - a) * t * t * t;
        0.5 * cubic
    };
    let steps = STEPS * if is_closed { count } else { count - 1 };
    let lengths: Vec<f64> = (0..steps)
        .map(|step| at(step).distance(at(step + 1)))
        .collect();
    let mut left = share.clamp(0.0, 1.0) * lengths.iter().sum::<f64>();
    for (step, length) in lengths.iter().enumerate() {
        if left <= *length {
            return at(step).lerp(at(step + 1), left / length);
        }
        left -= length;
    }
    at(steps)
}

/// Returns a surface of revolution around the y axis. `profile` are radii and heights, with the
/// outside to the right; v follows their length.
fn turned(
    name: &'static str,
    description: &'static str,
    quads: (usize, usize),
    profile: &[DVec2],
    is_closed: bool,
) -> Mesh {
    Grid {
        name,
        description,
        quads,
        closed: (true, is_closed),
    }
    .mesh(|uv| {
        const STEP: f64 = 1e-3;
        let at = |v: f64| match is_closed {
            true => along(profile, true, v.rem_euclid(1.0)),
            false => along(profile, false, v),
        };
        let (here, tangent) = (at(uv.y), at(uv.y + STEP) - at(uv.y - STEP));
        let outward = around_y(TAU * uv.x);
        let normal = outward * tangent.y - DVec3::Y * tangent.x;
        (outward * here.x + DVec3::Y * here.y, normal.normalize())
    })
}

/// Returns points from pairs of radius and height.
fn points<const N: usize>(pairs: [[f64; 2]; N]) -> [DVec2; N] {
    pairs.map(DVec2::from)
}

/// Returns a vase on the ground with a narrow neck, whose inside is seen to the bottom of the
/// neck.
fn vase() -> Mesh {
    let profile = points([
        [0.02, 0.0],
        [0.34, 0.0],
        [0.40, 0.05],
        [0.56, 0.40],
        [0.70, 0.90],
        [0.58, 1.40],
        [0.33, 1.75],
        [0.26, 2.00],
        [0.33, 2.22],
        [0.40, 2.30],
        [0.34, 2.32],
        [0.24, 2.16],
        [0.20, 1.95],
        [0.02, 1.85],
    ]);
    let description = "Vase around the y axis, radius 0.7, height 2.3";
    turned("vase", description, (48, 56), &profile, false)
}

/// Returns a finger ring around the y axis, whose texture runs around its outside (v from about ¼
/// to ¾) and its inside.
fn ring() -> Mesh {
    let profile = points([
        [0.91, 0.0],
        [0.93, -0.3],
        [1.0, -0.34],
        [1.07, -0.2],
        [1.1, 0.0],
        [1.07, 0.2],
        [1.0, 0.34],
        [0.93, 0.3],
    ]);
    let description = "Ring around the y axis, radius 1.1, width 0.7";
    turned("ring", description, (72, 24), &profile, true)
}

/// Returns the shade of a lamp: outside with v from 0 to ½, inside back with v from ½ to 1, so
/// that holes of a pattern that is even in v meet.
fn lamp() -> Mesh {
    /// Thickness of the sheet.
    const SHEET: f64 = 0.03;
    const HALF: [[f64; 2]; 5] = [
        [0.42, 0.0],
        [0.62, 0.3],
        [0.68, 0.62],
        [0.56, 0.98],
        [0.30, 1.2],
    ];
    let outside = points(HALF);
    Grid {
        name: "lamp",
        description: "Shade of a lamp around the y axis, radius 0.7, height 1.2",
        quads: (48, 40),
        closed: (true, true),
    }
    .mesh(|uv| {
        const STEP: f64 = 1e-3;
        // Inside, the way back.
        let (share, side) = match uv.y < 0.5 {
            true => (2.0 * uv.y, 1.0),
            false => (2.0 - 2.0 * uv.y, -1.0),
        };
        let at = |share: f64| along(&outside, false, share);
        let (low, high) = ((share - STEP).max(0.0), (share + STEP).min(1.0));
        let tangent = (at(high) - at(low)).normalize();
        let outward = DVec2::new(tangent.y, -tangent.x);
        let here = at(share) + outward * (0.5 * SHEET * side);
        let direction = around_y(TAU * uv.x);
        let normal = direction * outward.x + DVec3::Y * outward.y;
        (direction * here.x + DVec3::Y * here.y, normal * side)
    })
}

/// Semi-axes of the ellipsoid along x, y and z.
const ELLIPSOID_AXES: DVec3 = DVec3::new(1.2, 0.8, 1.0);

/// Returns the unit sphere, scaled along the axes with its texture.
fn ellipsoid() -> Mesh {
    star_shaped(
        "ellipsoid",
        "Ellipsoid, half axes 1.2, 0.8, 1, 40 slices, 24 stacks",
        (40, 24),
        |direction| {
            (
                direction * ELLIPSOID_AXES,
                (direction / ELLIPSOID_AXES).normalize(),
            )
        },
    )
}

/// Factor of x² − z² in the saddle's height.
const SADDLE_RISE: f64 = 0.3;

/// Returns the surface y = 0.3 (x² − z²) over a square; u increases along +x, v
/// along −z.
fn saddle() -> Mesh {
    const SIDE: f64 = 2.0;
    Grid {
        name: "saddle",
        description: "Saddle y = 0.3 (x² − z²) over a square of side 2",
        quads: (24, 24),
        closed: (false, false),
    }
    .mesh(|uv| {
        let offset = (uv - 0.5) * SIDE;
        let (x, z) = (offset.x, -offset.y);
        let normal = DVec3::new(-2.0 * SADDLE_RISE * x, 1.0, 2.0 * SADDLE_RISE * z);
        (
            DVec3::new(x, SADDLE_RISE * (x * x - z * z), z),
            normal.normalize(),
        )
    })
}

/// Radius of the blob without its lobes.
const BLOB_RADIUS: f64 = 0.9;

/// Lobes of the blob: amplitude (object units), wave vector (radians per unit
/// of direction) and phase (radians). The first two make the sphere a pear.
const BLOB_LOBES: [(f64, DVec3, f64); 5] = [
    (-0.14, DVec3::new(0.0, 2.2, 0.0), PI / 2.0),
    (-0.10, DVec3::new(0.0, 3.0, 0.0), 0.0),
    (0.065, DVec3::new(3.0, 1.2, 0.8), 0.4),
    (0.055, DVec3::new(-1.0, 1.5, 3.2), 1.9),
    (0.045, DVec3::new(2.4, -2.0, -2.6), 4.1),
];

/// Returns the blob in a unit direction. The surface is |p| = r(p/|p|), so its normal is
/// along the gradient d − (∇r − (∇r·d) d)/|p| of |p| − r(p/|p|).
fn blob_surface(direction: DVec3) -> SurfacePoint {
    let mut radius = BLOB_RADIUS;
    let mut gradient = DVec3::ZERO;
    for (amplitude, wave, phase) in BLOB_LOBES {
        let (sin, cos) = (wave.dot(direction) + phase).sin_cos();
        radius += amplitude * sin;
        gradient += wave * (amplitude * cos);
    }
    let tangential = gradient - direction * gradient.dot(direction);
    let normal = (direction - tangential / radius).normalize();
    (direction * radius, normal)
}

/// Returns a pear with gentle bumps: a sphere whose radius is a sum of sines.
fn blob() -> Mesh {
    star_shaped(
        "blob",
        "Smooth organic shape: a sphere with sine lobes, 72 slices, 48 stacks",
        (72, 48),
        blob_surface,
    )
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use super::*;

    fn point(mesh: &Mesh, corner: Corner) -> DVec3 {
        mesh.positions[corner.vertex]
    }

    /// Edges by welded position, with the texture coordinates at both ends for each
    /// triangle along the edge.
    fn edges(mesh: &Mesh) -> HashMap<(usize, usize), Vec<(DVec2, DVec2)>> {
        // Welded by value, to detect duplicated positions.
        let mut first = HashMap::new();
        let welded: Vec<usize> = mesh
            .positions
            .iter()
            .enumerate()
            .map(|(index, p)| {
                let key = p.to_array().map(|x| (x * 1e7).round() as i64);
                *first.entry(key).or_insert(index)
            })
            .collect();
        assert_eq!(first.len(), mesh.positions.len(), "{}: doubled", mesh.name);
        let mut edges: HashMap<_, Vec<_>> = HashMap::new();
        for t in &mesh.triangles {
            for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                edges
                    .entry((welded[a.vertex], welded[b.vertex]))
                    .or_default()
                    .push((mesh.uvs[a.uv], mesh.uvs[b.uv]));
            }
        }
        edges
    }

    #[test]
    fn counts_are_as_designed() {
        // (name, triangles, positions, texture coordinates)
        let expected = [
            ("torus", 2028, 39 * 26, 40 * 27),
            ("sphere", 1216, 32 * 19 + 2, 33 * 19 + 64),
            ("cylinder", 384, 48 * 5, 49 * 5),
            ("plane", 8, 9, 9),
            ("ellipsoid", 1840, 40 * 23 + 2, 41 * 23 + 80),
            ("saddle", 1152, 25 * 25, 25 * 25),
            ("blob", 6768, 72 * 47 + 2, 73 * 47 + 144),
            ("vase", 5376, 48 * 57, 49 * 57),
            ("ring", 3456, 72 * 24, 73 * 25),
            ("lamp", 3840, 48 * 40, 49 * 41),
        ];
        let meshes = all();
        assert_eq!(meshes.len(), expected.len());
        for (mesh, expected) in meshes.iter().zip(expected) {
            let counts = (
                mesh.name,
                mesh.triangles.len(),
                mesh.positions.len(),
                mesh.uvs.len(),
            );
            assert_eq!(counts, expected);
            assert_eq!(mesh.normals.len(), mesh.positions.len());
        }
    }

    #[test]
    fn each_edge_runs_once_each_way_or_lies_on_a_border() {
        for mesh in all() {
            let borders = match mesh.name {
                "cylinder" => 2 * 48,
                "plane" => 8,
                "saddle" => 4 * 24,
                "vase" => 2 * 48,
                _ => 0,
            };
            let edges = edges(&mesh);
            let mut open = 0;
            for (&(a, b), uses) in &edges {
                assert_eq!(uses.len(), 1, "{}: edge {a}-{b}", mesh.name);
                open += usize::from(!edges.contains_key(&(b, a)));
            }
            assert_eq!(open, borders, "{}", mesh.name);
        }
    }

    #[test]
    fn texture_joins_at_seams_up_to_whole_repeats() {
        for mesh in all() {
            let edges = edges(&mesh);
            for (&(a, b), uses) in &edges {
                let Some(others) = edges.get(&(b, a)) else {
                    continue;
                };
                let ((uv_a, uv_b), (other_b, other_a)) = (uses[0], others[0]);
                for (this, other) in [(uv_a, other_a), (uv_b, other_b)] {
                    let pole = ["sphere", "ellipsoid", "blob"].contains(&mesh.name)
                        && [0.0, 1.0].contains(&this.y);
                    let jump = this - other;
                    assert!(
                        pole || jump.distance(jump.round()) < 1e-12,
                        "{}: {this} against {other}",
                        mesh.name
                    );
                }
            }
        }
    }

    #[test]
    fn texture_coordinates_are_in_range_and_not_mirrored() {
        for mesh in all() {
            let unit = DVec2::ZERO..=DVec2::ONE;
            for uv in &mesh.uvs {
                assert!(uv.clamp(*unit.start(), *unit.end()) == *uv, "{uv}");
            }
            for t in &mesh.triangles {
                let [a, b, c] = t.map(|corner| mesh.uvs[corner.uv]);
                let area = (b - a).perp_dot(c - a);
                assert!(area > 0.0, "{}: area {area} in uv", mesh.name);
                // No triangle wraps around across the image.
                let size = a.max(b).max(c) - a.min(b).min(c);
                assert!(size.max_element() <= 0.5, "{}: {size}", mesh.name);
            }
        }
    }

    #[test]
    fn normals_are_unit_and_faces_look_the_same_way() {
        for mesh in all() {
            for normal in &mesh.normals {
                assert!((normal.length() - 1.0).abs() < 1e-12);
            }
            let least = match mesh.name {
                // Rims that are as narrow as a triangle is wide.
                "vase" | "ring" => 0.0,
                // Across its rims, where outside and inside meet.
                "lamp" => continue,
                _ => 0.95,
            };
            for t in &mesh.triangles {
                let [a, b, c] = t.map(|corner| point(&mesh, corner));
                let face = (b - a).cross(c - a).normalize();
                for corner in t {
                    let agreement = face.dot(mesh.normals[corner.vertex]);
                    assert!(agreement > least, "{}: {agreement}", mesh.name);
                }
            }
        }
    }

    /// Computes the volume by the divergence theorem: positive only if faces point
    /// outwards.
    #[test]
    fn closed_meshes_enclose_the_volume_they_should() {
        // (name, smallest and largest volume); exact: 2π²·0.4² = 3.158, 4π/3 = 4.189, 0.96 · 4π/3 = 4.021.
        for (name, least, greatest) in [
            ("torus", 3.08, 3.158),
            ("sphere", 4.10, 4.189),
            ("ellipsoid", 3.95, 4.022),
            ("blob", 2.6, 2.9),
            ("ring", 0.55, 0.70),
            ("lamp", 0.10, 0.16),
        ] {
            let mesh = all().into_iter().find(|mesh| mesh.name == name).unwrap();
            let volume: f64 = mesh
                .triangles
                .iter()
                .map(|t| {
                    let [a, b, c] = t.map(|corner| point(&mesh, corner));
                    a.dot(b.cross(c)) / 6.0
                })
                .sum();
            assert!((least..greatest).contains(&volume), "{name}: {volume}");
        }
    }

    #[test]
    fn vertices_lie_on_the_exact_surfaces() {
        for mesh in all() {
            for (p, n) in mesh.positions.iter().zip(&mesh.normals) {
                let axial = DVec3::new(p.x, 0.0, p.z);
                let (on_surface, normal) = match mesh.name {
                    "torus" => {
                        let tube = *p - axial.normalize();
                        (tube.length() - 0.4, tube / 0.4)
                    }
                    "sphere" => (p.length() - 1.0, *p),
                    "cylinder" => ((axial.length() - 1.0).max(p.y.abs() - 1.5), axial),
                    "ellipsoid" => {
                        let unit = *p / ELLIPSOID_AXES;
                        let outwards = unit / ELLIPSOID_AXES;
                        (unit.length() - 1.0, outwards.normalize())
                    }
                    "saddle" => {
                        let height = SADDLE_RISE * (p.x * p.x - p.z * p.z);
                        let slope = DVec3::new(-p.x, 0.0, p.z) * (2.0 * SADDLE_RISE);
                        (p.y - height, (DVec3::Y + slope).normalize())
                    }
                    "plane" => (p.y.abs().max(p.abs().max_element() - 1.0), DVec3::Y),
                    _ => continue,
                };
                assert!(on_surface.abs() < 1e-12, "{}: {p}", mesh.name);
                assert!(normal.abs_diff_eq(*n, 1e-12), "{}: {n}", mesh.name);
            }
        }
    }

    /// Returns the largest curvature of the blob in any direction at `direction`, and
    /// the largest cosine between its normal and its tangents, both by central
    /// differences.
    fn blob_differences(direction: DVec3) -> (f64, f64) {
        const STEP: f64 = 1e-5;
        let (t, b) = direction.any_orthonormal_pair();
        let difference = |along: DVec3| {
            let (p1, n1) = blob_surface((direction + along * STEP).normalize());
            let (p0, n0) = blob_surface((direction - along * STEP).normalize());
            ((p1 - p0) / (2.0 * STEP), (n1 - n0) / (2.0 * STEP))
        };
        let ((pt, nt), (pb, nb)) = (difference(t), difference(b));
        let normal = blob_surface(direction).1;
        let skew = normal
            .dot(pt.normalize())
            .abs()
            .max(normal.dot(pb.normalize()).abs());
        let mut curvature = 0.0_f64;
        for step in 0..36 {
            let (sin, cos) = (PI * f64::from(step) / 36.0).sin_cos();
            let (p, n) = (pt * cos + pb * sin, nt * cos + nb * sin);
            curvature = curvature.max((p.dot(n) / p.length_squared()).abs());
        }
        (curvature, skew)
    }

    #[test]
    fn blob_is_smooth_with_exact_normals_and_gentle_curvature() {
        let mut greatest = 0.0_f64;
        for direction in sphere().positions {
            let (curvature, skew) = blob_differences(direction);
            assert!(skew < 1e-8, "normal is off by {skew} at {direction}");
            greatest = greatest.max(curvature);
        }
        assert!(
            greatest < 1.0 / 0.25,
            "radius of curvature {}",
            greatest.recip()
        );
    }

    #[test]
    fn blob_has_a_size_of_about_two() {
        let positions = blob().positions;
        let low = positions.iter().fold(DVec3::INFINITY, |low, p| low.min(*p));
        let high = positions
            .iter()
            .fold(DVec3::NEG_INFINITY, |high, p| high.max(*p));
        let size = high - low;
        assert!((1.7..2.3).contains(&size.max_element()), "{size}");
        assert!(size.min_element() > 1.2, "{size}");
    }
}
