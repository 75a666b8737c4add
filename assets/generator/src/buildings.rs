//! Buildings whose faces have materials: OBJ files with their library.

use std::fmt::Write;

use glam::{DVec2, DVec3, dvec2, dvec3};

use crate::mesh::record;

/// The library.
pub const LIBRARY: &str = "\
# The materials of the buildings
# Made by `cargo run -p relievo-assets`
newmtl brick
Kd 0.66 0.30 0.22
Ns 20
newmtl roof
Kd 0.36 0.30 0.30
Pr 0.75
newmtl stone
Kd 0.86 0.83 0.78
map_Kd ../materials/stone.png
norm ../materials/stone_normal.png
Pr 0.9
newmtl wood
Kd 0.90 0.88 0.82
Pr 0.5
newmtl window
Kd 0.92 0.92 0.90
Pr 0.35
newmtl door
Kd 0.12 0.30 0.27
Pr 0.3
";

/// Width and height of a repeat of bricks, metres.
const BRICKS: DVec2 = dvec2(0.9, 0.6);
/// Width and height of a repeat of shingles, metres.
const SHINGLES: DVec2 = dvec2(1.0, 1.0);
/// Half the width and half the depth of the walls, and the height of the eaves, metres.
const WALLS: DVec3 = dvec3(3.0, 2.8, 2.0);
/// Height of the ridge, metres.
const RIDGE: f64 = 4.6;
/// How far windows and door are set back, metres.
const REVEAL: f64 = 0.16;

/// A polygon with its texture coordinates, counter-clockwise seen from outside.
struct Face {
    material: &'static str,
    corners: Vec<(DVec3, DVec2)>,
}

/// A building.
struct Building {
    name: &'static str,
    description: &'static str,
    faces: Vec<Face>,
}

/// Returns the name and the OBJ file of each building.
pub fn all() -> [(&'static str, String); 2] {
    [house(), facade()].map(|building| (building.name, building.into_obj()))
}

impl Building {
    fn into_obj(mut self) -> String {
        let mut text = format!(
            "# {}\n# Made by `cargo run -p relievo-assets`\nmtllib buildings.mtl\no {}\n",
            self.description, self.name
        );
        // Faces of a material together.
        self.faces.sort_by_key(|face| face.material);
        let (mut material, mut count) = ("", 0);
        for face in &self.faces {
            if face.material != material {
                material = face.material;
                writeln!(text, "usemtl {material}").expect("a String takes any text");
            }
            let [a, b, c] = [0, 1, 2].map(|corner| face.corners[corner].0);
            let normal = (b - a).cross(c - a).normalize();
            let mut statement = "f".to_owned();
            for (position, uv) in &face.corners {
                count += 1;
                let lines = [
                    record("v", &position.to_array()),
                    record("vt", &uv.to_array()),
                    record("vn", &normal.to_array()),
                ];
                text.push_str(&(lines.join("\n") + "\n"));
                write!(statement, " {count}/{count}/{count}").expect("a String takes any text");
            }
            text.push_str(&(statement + "\n"));
        }
        text
    }
}

fn house() -> Building {
    let mut faces = Vec::new();
    walls(&mut faces);
    roof(&mut faces);
    chimney(&mut faces);
    let base = dvec3(WALLS.x + 0.04, 0.0, WALLS.z + 0.04);
    let low = dvec3(-base.x, -0.3, -base.z);
    block(&mut faces, "stone", low, base, DVec2::ONE);
    Building {
        name: "house",
        description: "House with gables, 6 × 4 metres, the front towards +z",
        faces,
    }
}

/// A front of three storeys on a box, for streets.
fn facade() -> Building {
    const SIZE: DVec3 = dvec3(7.2, 9.6, 5.0);
    let mut faces = Vec::new();
    let corner = dvec3(-0.5 * SIZE.x, 0.0, 0.5 * SIZE.z);
    let [across, up, inward] = [DVec3::X, DVec3::Y, -DVec3::Z];
    let windows = [1, 3, 5].into_iter();
    let openings = windows.flat_map(|column| {
        let rows = [[1, 3], [4, 5], [6, 7]].into_iter();
        rows.map(move |rows| match (column, rows) {
            (3, [1, 3]) => ([3, 4], [0, 2], "door"),
            _ => ([column, column + 1], rows, "window"),
        })
    });
    Wall {
        corner,
        across,
        offset: 0.0,
        columns: &[0.0, 0.8, 1.8, 3.1, 4.1, 5.4, 6.4, SIZE.x],
        rows: &[0.0, 0.9, 2.4, 2.5, 4.1, 5.7, 7.3, 8.9, SIZE.y],
        openings: &openings.collect::<Vec<_>>(),
    }
    .add(&mut faces);
    let (wide, high, deep) = (across * SIZE.x, up * SIZE.y, inward * SIZE.z);
    for (corner, sides) in [
        (corner + wide, [deep, high]),
        (corner + wide + deep, [-wide, high]),
        (corner + deep, [-deep, high]),
    ] {
        rectangle(&mut faces, "brick", corner, sides, (DVec2::ZERO, BRICKS));
    }
    // Base, string course and cornice: height, thickness, and how far they stand out.
    for [height, thickness, out] in [[-0.3, 0.3, 0.04], [3.3, 0.16, 0.06], [SIZE.y, 0.3, 0.22]] {
        let low = corner + deep - dvec3(out, -height, out);
        let top = corner + wide + dvec3(out, height + thickness, out);
        block(&mut faces, "stone", low, top, DVec2::ONE);
    }
    Building {
        name: "facade",
        description: "Building of three storeys, 7.2 × 5 metres, the front towards +z",
        faces,
    }
}

/// Adds a rectangle from `corner` along `across` and `up`, with a repeat per `size` metres from
/// `origin`.
fn rectangle(
    faces: &mut Vec<Face>,
    material: &'static str,
    corner: DVec3,
    [across, up]: [DVec3; 2],
    (origin, size): (DVec2, DVec2),
) {
    let extent = dvec2(across.length(), up.length());
    let corners = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y].map(|at| {
        let position = corner + across * at.x + up * at.y;
        (position, (origin + at * extent) / size)
    });
    faces.push(Face {
        material,
        corners: corners.into(),
    });
}

/// Adds the sides of a box between two corners, with a repeat per `size` metres.
fn block(faces: &mut Vec<Face>, material: &'static str, low: DVec3, high: DVec3, size: DVec2) {
    let extent = high - low;
    let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| axis * axis.dot(extent));
    let mut along = 0.0;
    for (corner, across) in [(low + z, x), (low + z + x, -z), (low + x, -x), (low, z)] {
        let origin = dvec2(along, low.y);
        rectangle(faces, material, corner, [across, y], (origin, size));
        along += across.length();
    }
    rectangle(faces, material, low + y + z, [x, -z], (DVec2::ZERO, size));
    rectangle(faces, material, low, [x, z], (DVec2::ZERO, size));
}

/// An upright wall with openings.
struct Wall<'a> {
    /// Lower left corner, seen from outside.
    corner: DVec3,
    /// Unit direction from left to right.
    across: DVec3,
    /// Where the bricks are, so that they go on around the corners.
    offset: f64,
    /// Borders of its columns and rows, metres from the corner.
    columns: &'a [f64],
    rows: &'a [f64],
    /// Columns and rows of its openings, and their material.
    openings: &'a [([usize; 2], [usize; 2], &'static str)],
}

impl Wall<'_> {
    fn add(&self, faces: &mut Vec<Face>) {
        let outward = self.across.cross(DVec3::Y);
        let at = |x: f64, y: f64| self.corner + self.across * x + DVec3::Y * y;
        let bricks = |x: f64, y: f64| dvec2(self.offset + x, y) / BRICKS;
        let is_open = |column: usize, row: usize| {
            let mut openings = self.openings.iter();
            openings.any(|([left, right], [bottom, top], _)| {
                (*left..*right).contains(&column) && (*bottom..*top).contains(&row)
            })
        };
        for column in 0..self.columns.len() - 1 {
            for row in 0..self.rows.len() - 1 {
                if is_open(column, row) {
                    continue;
                }
                let [left, right] = [self.columns[column], self.columns[column + 1]];
                let [bottom, top] = [self.rows[row], self.rows[row + 1]];
                let corners = [[left, bottom], [right, bottom], [right, top], [left, top]];
                let corners = corners.map(|[x, y]| (at(x, y), bricks(x, y)));
                faces.push(Face {
                    material: "brick",
                    corners: corners.into(),
                });
            }
        }
        for ([left, right], [bottom, top], material) in self.openings {
            let [left, right] = [self.columns[*left], self.columns[*right]];
            let [bottom, top] = [self.rows[*bottom], self.rows[*top]];
            let inward = -outward * REVEAL;
            let size = dvec2(right - left, top - bottom);
            let (across, up) = (self.across * size.x, DVec3::Y * size.y);
            // The jambs, and what is between them.
            let jamb = |x: f64, y: f64| (dvec2(self.offset + x, y), BRICKS);
            let sides = [
                (at(left, bottom), [inward, up], jamb(left, bottom)),
                (
                    at(right, bottom) + inward,
                    [-inward, up],
                    jamb(right - REVEAL, bottom),
                ),
                (at(left, bottom), [across, inward], jamb(left, bottom)),
                (at(left, top) + inward, [across, -inward], jamb(left, top)),
            ];
            for (corner, sides, bricks) in sides {
                rectangle(faces, "brick", corner, sides, bricks);
            }
            let pane = (DVec2::ZERO, size);
            rectangle(
                faces,
                material,
                at(left, bottom) + inward,
                [across, up],
                pane,
            );
            // A sill below a window, a step before a door.
            let [out, deep] = if bottom > 0.0 {
                [0.1, 0.08]
            } else {
                [0.5, 0.3]
            };
            let ends = [
                at(left - 0.08, bottom - deep) + inward,
                at(right + 0.08, bottom) + outward * out,
            ];
            let (low, high) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
            block(faces, "stone", low, high, DVec2::ONE);
        }
    }
}

fn walls(faces: &mut Vec<Face>) {
    let DVec3 { x, y, z } = WALLS;
    let rows = [0.0, 0.9, 2.1, 2.2, y];
    Wall {
        corner: dvec3(-x, 0.0, z),
        across: DVec3::X,
        offset: 0.0,
        columns: &[0.0, 0.6, 1.8, 2.5, 3.5, 4.2, 5.4, 6.0],
        rows: &rows,
        openings: &[
            ([1, 2], [1, 3], "window"),
            ([5, 6], [1, 3], "window"),
            ([3, 4], [0, 2], "door"),
        ],
    }
    .add(faces);
    let side = [0.0, 1.4, 2.0, 2.6, 4.0];
    for (sign, offset, openings) in [
        (1.0, 6.0, &[([1, 3], [1, 3], "window")][..]),
        (-1.0, 16.0, &[][..]),
    ] {
        let wall = Wall {
            corner: dvec3(sign * x, 0.0, sign * z),
            across: dvec3(0.0, 0.0, -sign),
            offset,
            columns: &side,
            rows: &rows,
            openings,
        };
        wall.add(faces);
        // The gable, up to the ridge.
        for pair in side.windows(2) {
            let corners = [(pair[0], y), (pair[1], y), (z, RIDGE)];
            let corners = corners.map(|(along, up)| {
                let position = wall.corner + wall.across * along + DVec3::Y * up;
                (position, dvec2(offset + along, up) / BRICKS)
            });
            faces.push(Face {
                material: "brick",
                corners: corners.into(),
            });
        }
    }
    Wall {
        corner: dvec3(x, 0.0, -z),
        across: -DVec3::X,
        offset: 10.0,
        columns: &[0.0, 6.0],
        rows: &[0.0, y],
        openings: &[],
    }
    .add(faces);
}

/// Two slopes with overhanging eaves and verges.
fn roof(faces: &mut Vec<Face>) {
    let half = WALLS.x + 0.3;
    for sign in [1.0, -1.0] {
        // From the ridge down to the eaves, which hang over.
        let down = dvec3(0.0, WALLS.y - RIDGE, sign * WALLS.z) * 1.2;
        let along = dvec3(2.0 * sign * half, 0.0, 0.0);
        let outward = down.cross(along).normalize() * 0.14;
        let ridge = dvec3(-sign * half, RIDGE, 0.0) + outward;
        // At the ridge the slopes meet.
        let ridge = ridge - down * (outward.z / down.z);
        let eaves = ridge + down;
        let shingles = (DVec2::ZERO, SHINGLES);
        rectangle(faces, "roof", eaves, [along, -down], shingles);
        let plain = (DVec2::ZERO, DVec2::ONE);
        rectangle(faces, "wood", eaves - outward, [along, outward], plain);
        rectangle(faces, "wood", ridge - outward, [along, down], plain);
        rectangle(faces, "wood", ridge - outward, [down, outward], plain);
        let other = eaves + along - outward;
        rectangle(faces, "wood", other, [-down, outward], plain);
    }
}

fn chimney(faces: &mut Vec<Face>) {
    let (low, high) = (dvec3(1.2, 3.3, -1.0), dvec3(1.9, 5.1, -0.4));
    block(faces, "brick", low, high, BRICKS);
    let rim = dvec3(0.06, 0.0, 0.06);
    let top = dvec3(high.x, high.y + 0.1, high.z);
    block(
        faces,
        "stone",
        dvec3(low.x, high.y, low.z) - rim,
        top + rim,
        DVec2::ONE,
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_have_the_materials_of_the_library() {
        let [(_, house), (_, facade)] = all();
        let used = |text: &str| -> Vec<String> {
            let lines = text.lines();
            let names = lines.filter_map(|line| line.strip_prefix("usemtl "));
            names.map(str::to_owned).collect()
        };
        let house = used(&house);
        assert_eq!(house, ["brick", "door", "roof", "stone", "window", "wood"]);
        assert_eq!(used(&facade), ["brick", "door", "stone", "window"]);
        for name in house {
            assert!(LIBRARY.contains(&format!("newmtl {name}\n")), "{name}");
        }
    }

    #[test]
    fn the_front_looks_to_the_front() {
        let mut faces = Vec::new();
        walls(&mut faces);
        let door = faces.iter().find(|face| face.material == "door").unwrap();
        let [a, b, c] = [0, 1, 2].map(|corner| door.corners[corner].0);
        assert!((b - a).cross(c - a).normalize().distance(DVec3::Z) < 1e-12);
        assert!((a.z - (WALLS.z - REVEAL)).abs() < 1e-12);
        assert_eq!(
            [door.corners[0].1, door.corners[2].1],
            [DVec2::ZERO, DVec2::ONE]
        );
    }
}
