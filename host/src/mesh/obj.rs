//! Wavefront OBJ files, read with `tobj`.

use std::collections::HashMap;
use std::path::Path;

use glam::{DVec2, DVec3};

use super::error::MeshError;
use super::options::MeshOptions;
use super::raw::{Corner, RawMesh};
use super::scan::scan;

/// Parses the text of an OBJ file; `path` is named in errors only.
///
/// Normals are dropped unless every corner has one; so are texture coordinates.
///
/// # Errors
///
/// [`MeshError::Statement`] with the line of the error,
/// [`MeshError::NoFaces`], [`MeshError::TooManyTriangles`] and
/// [`MeshError::Parse`].
pub(super) fn parse(text: &str, path: &Path, options: &MeshOptions) -> Result<RawMesh, MeshError> {
    let scan = scan(text, path, options.limit(), &options.parts)?;
    // With a single index, positions would be duplicated at seams.
    let load_options = tobj::LoadOptions {
        triangulate: true,
        ignore_points: true,
        ignore_lines: true,
        single_index: false,
    };
    let no_materials = |_: &Path| Ok((Vec::new(), HashMap::new()));
    let (models, _) =
        tobj::load_obj_buf(&mut scan.geometry.as_bytes(), &load_options, no_materials).map_err(
            |source| MeshError::Parse {
                path: path.to_owned(),
                source,
            },
        )?;
    // The scan keeps no statement that starts another model.
    let mesh = models
        .into_iter()
        .next()
        .map(|model| model.mesh)
        .ok_or_else(|| MeshError::NoFaces {
            path: path.to_owned(),
        })?;

    // tobj fills a missing index with the one before it, so such streams are
    // dropped.
    let has_normals = scan.face_without_normals.is_none();
    let has_uvs = scan.face_without_uvs.is_none();
    let triangles = (0..mesh.indices.len() / 3)
        .map(|triangle| {
            std::array::from_fn(|corner| {
                let index = 3 * triangle + corner;
                Corner {
                    position: mesh.indices[index],
                    normal: has_normals.then(|| mesh.normal_indices[index]),
                    uv: has_uvs.then(|| mesh.texcoord_indices[index]),
                }
            })
        })
        .collect();
    Ok(RawMesh {
        positions: vectors(&mesh.positions),
        normals: if has_normals {
            vectors(&mesh.normals)
        } else {
            Vec::new()
        },
        uvs: if has_uvs {
            mesh.texcoords
                .chunks_exact(2)
                .map(DVec2::from_slice)
                .collect()
        } else {
            Vec::new()
        },
        triangles,
        materials: scan.materials,
        material_of: scan.material_of,
        face_without_uvs: scan.face_without_uvs.map(|line| format!("at line {line}")),
    })
}

/// Converts groups of three numbers to vectors.
fn vectors(numbers: &[f64]) -> Vec<DVec3> {
    numbers.chunks_exact(3).map(DVec3::from_slice).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMIT: usize = 100;

    fn parse(text: &str) -> Result<RawMesh, MeshError> {
        let options = MeshOptions {
            triangle_limit: LIMIT,
            ..MeshOptions::default()
        };
        super::parse(text, Path::new("test.obj"), &options)
    }

    /// Returns the message of the error for `text`.
    fn message(text: &str) -> String {
        parse(text).expect_err("the text is wrong").to_string()
    }

    const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

    /// Returns the positions of the corners of all triangles.
    fn positions(mesh: &RawMesh) -> Vec<[f64; 3]> {
        mesh.triangles
            .iter()
            .flatten()
            .map(|corner| mesh.positions[corner.position as usize].to_array())
            .collect()
    }

    #[test]
    fn quads_polygons_and_negative_indices_make_the_same_fan() {
        let quad = parse(&format!("{SQUARE}f 1 2 3 4\n")).unwrap();
        let triangles = parse(&format!("{SQUARE}f 1 2 3\nf 1 3 4\n")).unwrap();
        let negative = parse(&format!("{SQUARE}f -4 -3 -2 -1\n")).unwrap();
        assert_eq!(quad.triangles.len(), 2);
        assert_eq!(positions(&quad), positions(&triangles));
        assert_eq!(positions(&quad), positions(&negative));

        let pentagon = parse(&format!("{SQUARE}v 0 0.5 0\nf 1 2 3 4 5\n")).unwrap();
        assert_eq!(pentagon.triangles.len(), 3);
    }

    #[test]
    fn streams_keep_their_own_indices() {
        let mesh = parse(
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.5 0.5\nvt 0 0\nvt 1 0 0\nvn 0 0 1\nvn 0 0 2\nf 1/3/2 2/2/1 3/1/1\n",
        )
        .unwrap();
        let uvs = mesh.triangles[0].map(|corner| mesh.uvs[corner.uv.unwrap() as usize].to_array());
        let normals =
            mesh.triangles[0].map(|corner| mesh.normals[corner.normal.unwrap() as usize].z);
        assert_eq!(uvs, [[1.0, 0.0], [0.0, 0.0], [0.5, 0.5]]);
        assert_eq!(normals, [2.0, 1.0, 1.0]);
    }

    #[test]
    fn objects_groups_and_materials_are_one_mesh() {
        let mesh = parse(&format!(
            "mtllib missing.mtl\no one\n{SQUARE}usemtl\nf 1 2 3\ng two\nusemtl gold\ns 1\nv 0 0 5\nf 5 1 2\n"
        ))
        .unwrap();
        assert_eq!(mesh.triangles.len(), 2);
        assert_eq!(mesh.materials, ["", "gold"]);
        assert_eq!(
            mesh.positions.len(),
            4,
            "vertex 4 is not used, vertices 1 and 2 are shared"
        );
    }

    #[test]
    fn triangles_have_the_materials_before_them() {
        let text = format!(
            "{SQUARE}vt 0 0\nf 1 2 3\nusemtl  my  gold\nusemtl oak\nf 1/1 2/1 3/1 4/1\nusemtl my gold\nf 1 2 3\nusemtl oak\nf 1/1 2/1 3/1\n"
        );
        let mesh = parse(&text).unwrap();
        assert_eq!(mesh.materials, ["", "oak", "my gold"]);
        assert_eq!(mesh.material_of, [0, 1, 1, 2, 1]);
        assert!(mesh.uvs.is_empty());

        let parts = |parts: &[&str]| {
            let options = MeshOptions {
                parts: parts.iter().map(|part| part.to_string()).collect(),
                ..MeshOptions::default()
            };
            super::parse(&text, Path::new("test.obj"), &options)
        };
        let oak = parts(&["oak"]).unwrap();
        assert_eq!(
            (&oak.material_of[..], oak.triangles.len()),
            (&[1, 1, 1][..], 3)
        );
        // Texture coordinates that other parts lack do not matter.
        assert!(!oak.uvs.is_empty() && oak.face_without_uvs.is_none());
        assert_eq!(parts(&["", "my gold"]).unwrap().material_of, [0, 2]);
        let message = parts(&["tin"]).unwrap_err().to_string();
        let told = r#"`test.obj`: has no part "tin"; its parts are "", "oak", "my gold""#;
        assert!(message.contains(told), "{message}");
    }

    #[test]
    fn what_makes_no_triangle_is_ignored() {
        let mesh = parse(&format!(
            "\u{feff}# a comment\n{SQUARE}p 1\nl 1 2 3\nf 1\nf 1 2\nf\nf 1 2 3\n"
        ))
        .unwrap();
        assert_eq!(mesh.triangles.len(), 1);
    }

    #[test]
    fn comments_continued_lines_weights_and_colours_are_read() {
        let mesh = parse(
            "v 0 0 0 # origin\r\nv 2 0 0 2\nv 1 1 0 0.5 0.5 0.5\nv 0 1 \\\n0\nf 1 2 \\\n3 4 # quad\n",
        )
        .unwrap();
        assert_eq!(mesh.positions[1], DVec3::X, "divided by the weight");
        assert_eq!(mesh.positions[3], DVec3::Y);
        assert_eq!(mesh.triangles.len(), 2);
    }

    #[test]
    fn partial_streams_are_dropped() {
        let mesh = parse(&format!(
            "{SQUARE}vt 0 0\nvn 0 0 1\nf 1/1/1 2/1/1 3/1/1\nf 1/1/1 3/1/1 4\n"
        ))
        .unwrap();
        assert!(mesh.uvs.is_empty() && mesh.normals.is_empty());
        assert_eq!(mesh.face_without_uvs.as_deref(), Some("at line 8"));
        assert!(
            mesh.triangles
                .iter()
                .flatten()
                .all(|corner| corner.uv.is_none() && corner.normal.is_none())
        );
    }

    #[test]
    fn mistakes_are_told_with_file_and_line() {
        for (statement, told) in [
            ("v 0 0", "vertex 5 has 2 numbers; expected 3"),
            ("v 0 0 0 1 1", "vertex 5 has 5 numbers"),
            ("v 0 x 0", "`x` in vertex 5 is not a number"),
            ("v 0 nan 0", "vertex 5 is not finite"),
            ("v inf 0 0", "vertex 5 is not finite"),
            ("v 1e999 0 0", "vertex 5 is not finite"),
            ("v 1e13 0 0", "vertex 5 is too large"),
            ("v 1 0 0 0", "vertex 5 has the weight 0"),
            ("vt 0.5", "texture coordinate 1 has 1 numbers; expected 2"),
            ("vt 0 NaN", "texture coordinate 1 is not finite"),
            ("vn 0 1", "normal 1 has 2 numbers; expected 3"),
            ("f 1 2 0", "the face names vertex 0"),
            ("f 1 2 9", "the face names vertex 9, but the file has 4"),
            (
                "f 1 2 -5",
                "the face names vertex -5, but only 4 come before it",
            ),
            (
                "f 1/1 2/1 3/1",
                "the face names texture coordinate 1, but the file has 0",
            ),
            (
                "f 1//7 2//7 3//7",
                "the face names normal 7, but the file has 0",
            ),
            ("f 1 2 4294967297", "the face names vertex 4294967297"),
            (
                "f 1 2 9223372036854775807",
                "the face names vertex 9223372036854775807",
            ),
            (
                "f 1 2 -9223372036854775808",
                "the face names vertex -9223372036854775808",
            ),
            ("f 1 2 99999999999999999999", "is not a face corner"),
            ("f 1 2 /3", "`/3` is not a face corner"),
            ("f 1/1/1/1 2 3", "is not a face corner"),
            ("f a b c", "`a` is not a face corner"),
        ] {
            let message = message(&format!("{SQUARE}{statement}\nf 1 2 3\n"));
            assert!(message.contains("`test.obj`, line 5: "), "{message}");
            assert!(message.contains(told), "{statement}: {message}");
        }
    }

    #[test]
    fn faces_may_come_before_their_vertices() {
        assert_eq!(
            parse(&format!("f 1 2 3\n{SQUARE}"))
                .unwrap()
                .triangles
                .len(),
            1
        );
    }

    #[test]
    fn a_file_without_faces_or_with_too_many_is_refused() {
        for text in ["", "# nothing\n", SQUARE] {
            assert!(matches!(parse(text), Err(MeshError::NoFaces { .. })));
        }
        let many = format!("{SQUARE}{}", "f 1 2 3\n".repeat(LIMIT + 1));
        assert!(matches!(
            parse(&many),
            Err(MeshError::TooManyTriangles {
                count: 101,
                limit: LIMIT,
                ..
            })
        ));
    }

    proptest::proptest! {
        #[test]
        fn no_text_panics(text in "(((v|vt|vn|f|l|g|usemtl|mtllib)( [-0-9./e#\\\\]{0,6}){0,5}\n){0,12})") {
            let _ = parse(&text);
        }
    }
}
