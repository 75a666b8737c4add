//! Triangle meshes with shared positions and separate texture coordinates.

use std::fmt::Write;

use glam::{DVec2, DVec3};

/// One corner of a triangle: 0-based indices into the mesh's tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Corner {
    /// Index of the position and of its normal.
    pub vertex: usize,
    /// Index of the texture coordinate.
    pub uv: usize,
}

/// A triangle mesh with smooth normals.
///
/// Positions at a texture seam are not duplicated, only their texture coordinates.
/// So the surface is closed without welding.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// Name of the object and of its file, without extension.
    pub name: &'static str,
    /// Description in one line.
    pub description: &'static str,
    /// Positions in object units.
    pub positions: Vec<DVec3>,
    /// Outward unit normals, one per position.
    pub normals: Vec<DVec3>,
    /// Texture coordinates in repeats, each in [0, 1]; v points up in the image.
    pub uvs: Vec<DVec2>,
    /// Triangles, counter-clockwise seen from outside.
    pub triangles: Vec<[Corner; 3]>,
}

impl Mesh {
    /// Returns the mesh as a Wavefront OBJ file, with eight decimals and `\n` line
    /// ends.
    pub fn to_obj(&self) -> String {
        let mut lines = vec![
            format!(
                "# {} ({} triangles)",
                self.description,
                self.triangles.len()
            ),
            "# Made by `cargo run -p relievo-assets`".to_owned(),
            format!("o {}", self.name),
        ];
        lines.extend(self.positions.iter().map(|p| record("v", &p.to_array())));
        lines.extend(self.uvs.iter().map(|uv| record("vt", &uv.to_array())));
        lines.extend(self.normals.iter().map(|n| record("vn", &n.to_array())));
        for triangle in &self.triangles {
            let mut line = "f".to_owned();
            for corner in triangle {
                let (vertex, uv) = (corner.vertex + 1, corner.uv + 1);
                write!(line, " {vertex}/{uv}/{vertex}").expect("a String takes any text");
            }
            lines.push(line);
        }
        lines.push(String::new());
        lines.join("\n")
    }
}

/// Formats one line of numbers with eight decimals.
pub fn record(keyword: &str, numbers: &[f64]) -> String {
    let mut line = keyword.to_owned();
    for number in numbers {
        // Adding +0 turns −0 into 0, so that the sign of rounding errors is not in
        // the file.
        let rounded = (number * 1e8).round() / 1e8 + 0.0;
        write!(line, " {rounded:.8}").expect("a String takes any text");
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn obj_lists_tables_and_one_based_faces() {
        let corner = |index| Corner {
            vertex: index,
            uv: index,
        };
        let mesh = Mesh {
            name: "one",
            description: "One triangle",
            positions: vec![DVec3::new(-1e-17, 0.5, 1.0), DVec3::X, DVec3::Y],
            normals: vec![DVec3::Z; 3],
            uvs: vec![DVec2::ZERO, DVec2::X, DVec2::ONE],
            triangles: vec![[corner(0), corner(1), corner(2)]],
        };
        let expected = "\
# One triangle (1 triangles)
# Made by `cargo run -p relievo-assets`
o one
v 0.00000000 0.50000000 1.00000000
v 1.00000000 0.00000000 0.00000000
v 0.00000000 1.00000000 0.00000000
vt 0.00000000 0.00000000
vt 1.00000000 0.00000000
vt 1.00000000 1.00000000
vn 0.00000000 0.00000000 1.00000000
vn 0.00000000 0.00000000 1.00000000
vn 0.00000000 0.00000000 1.00000000
f 1/1/1 2/2/2 3/3/3
";
        assert_eq!(mesh.to_obj(), expected);
    }
}
