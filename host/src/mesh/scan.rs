//! Checks the text of an OBJ file before `tobj` parses it: reports the line of an
//! error, which `tobj` does not, and keeps only the statements with geometry.

use std::collections::HashMap;
use std::path::Path;

use super::error::MeshError;
use super::raw::{LARGEST_NUMBER, check_parts, is_wanted};

/// Maximum length of a quoted word in a message, in characters.
const QUOTED_CHARACTERS: usize = 40;

/// The result of scanning a file.
#[derive(Debug)]
pub(super) struct Scan {
    /// The `v`, `vt`, `vn` and `f` statements, one per line, without comments,
    /// continued lines, points, lines and vertex colours. Groups and materials
    /// are dropped too, as they would split the mesh.
    pub geometry: String,
    /// Names of the materials that faces have, in the order of their first use; `""` for
    /// faces before the first `usemtl`. Empty if no face has a material.
    pub materials: Vec<String>,
    /// Index of the material of each triangle; empty if there are none.
    pub material_of: Vec<u32>,
    /// Files of materials, and the lines that name them.
    pub libraries: Vec<(usize, String)>,
    /// Line of the first face with a corner without texture coordinates.
    pub face_without_uvs: Option<usize>,
    /// Line of the first face with a corner without a normal.
    pub face_without_normals: Option<usize>,
}

/// Checks the statements of `text` and collects those with geometry. Of the faces it
/// collects those whose materials are among `parts`; all if there are none.
///
/// # Errors
///
/// [`MeshError::Statement`] with the line of the first invalid, infinite or NaN
/// number or invalid index, [`MeshError::TooManyTriangles`],
/// [`MeshError::NoFaces`], and [`MeshError::Invalid`] for a part that does not exist.
pub(super) fn scan(
    text: &str,
    path: &Path,
    triangle_limit: usize,
    parts: &[String],
) -> Result<Scan, MeshError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut scan = Scan {
        geometry: String::with_capacity(text.len()),
        materials: Vec::new(),
        material_of: Vec::new(),
        libraries: Vec::new(),
        face_without_uvs: None,
        face_without_normals: None,
    };
    let mut elements = [
        Elements::new("vertex"),
        Elements::new("texture coordinate"),
        Elements::new("normal"),
    ];
    let mut triangles = 0_usize;
    let mut index_of: HashMap<String, u32> = HashMap::new();
    // Its name, and its index once a face has it.
    let mut material = (String::new(), None);
    for (line, words) in statements(text) {
        let failure = |problem| MeshError::Statement {
            path: path.to_owned(),
            line,
            problem,
        };
        let (keyword, arguments) = (words[0], &words[1..]);
        let kept = match keyword {
            "v" => {
                elements[0].count += 1;
                vertex(arguments, elements[0].count).map_err(failure)?
            }
            "vt" => {
                elements[1].count += 1;
                numbers("texture coordinate", arguments, 2, elements[1].count).map_err(failure)?
            }
            "vn" => {
                elements[2].count += 1;
                numbers("normal", arguments, 3, elements[2].count).map_err(failure)?
            }
            // Faces with fewer corners are points or lines.
            "f" if arguments.len() >= 3 => {
                let count = triangles + arguments.len() - 2;
                let is_wanted = is_wanted(parts, &material.0);
                if is_wanted && count > triangle_limit {
                    let path = path.to_owned();
                    return Err(MeshError::TooManyTriangles {
                        path,
                        count,
                        limit: triangle_limit,
                    });
                }
                for corner in arguments {
                    let present = check_corner(corner, line, &mut elements).map_err(failure)?;
                    if !is_wanted {
                        continue;
                    }
                    if !present[1] {
                        scan.face_without_uvs.get_or_insert(line);
                    }
                    if !present[2] {
                        scan.face_without_normals.get_or_insert(line);
                    }
                }
                let index = *material.1.get_or_insert_with(|| {
                    let next = scan.materials.len() as u32;
                    *index_of
                        .entry(material.0.clone())
                        .or_insert_with_key(|name| {
                            scan.materials.push(name.clone());
                            next
                        })
                });
                if !is_wanted {
                    continue;
                }
                triangles = count;
                // As many as the fan has.
                scan.material_of.resize(triangles, index);
                arguments
            }
            "usemtl" => {
                material = (arguments.join(" "), None);
                continue;
            }
            "mtllib" => {
                let names = file_names(arguments);
                scan.libraries.extend(names.map(|name| (line, name)));
                continue;
            }
            _ => continue,
        };
        scan.geometry.push_str(keyword);
        for word in kept {
            scan.geometry.push(' ');
            scan.geometry.push_str(word);
        }
        scan.geometry.push('\n');
    }
    // Checked last, as a face may precede the elements that it names.
    for stream in &elements {
        if stream.largest_index > stream.count {
            let problem = format!(
                "the face names {} {}, but the file has {}",
                stream.name, stream.largest_index, stream.count
            );
            return Err(MeshError::Statement {
                path: path.to_owned(),
                line: stream.largest_index_line,
                problem,
            });
        }
    }
    if scan.materials == [""] {
        scan.materials.clear();
        scan.material_of.clear();
    }
    if !scan.materials.is_empty() || triangles > 0 {
        check_parts(parts, &scan.materials).map_err(|problem| MeshError::Invalid {
            path: path.to_owned(),
            problem,
        })?;
    }
    if triangles == 0 {
        return Err(MeshError::NoFaces {
            path: path.to_owned(),
        });
    }
    Ok(scan)
}

/// One stream of elements (`v`, `vt` or `vn`) and the indices of faces into it.
struct Elements {
    name: &'static str,
    count: usize,
    largest_index: usize,
    largest_index_line: usize,
}

impl Elements {
    fn new(name: &'static str) -> Self {
        Self {
            name,
            count: 0,
            largest_index: 0,
            largest_index_line: 0,
        }
    }
}

/// Returns the words of each statement and the line where it starts. Drops
/// comments and joins lines that end in a backslash.
fn statements(text: &str) -> impl Iterator<Item = (usize, Vec<&str>)> {
    let mut lines = text.lines().enumerate();
    std::iter::from_fn(move || {
        loop {
            let (index, mut rest) = lines.next()?;
            let mut words = Vec::new();
            loop {
                let statement = rest.split('#').next().unwrap_or_default().trim_end();
                let continued = statement.strip_suffix('\\');
                words.extend(continued.unwrap_or(statement).split_whitespace());
                match continued.and_then(|_| lines.next()) {
                    Some((_, next)) => rest = next,
                    None => break,
                }
            }
            if !words.is_empty() {
                return Some((index + 1, words));
            }
        }
    })
}

/// Returns the names of files in `words`; names with spaces have to end in `.mtl`.
fn file_names<'a>(words: &'a [&str]) -> impl Iterator<Item = String> + 'a {
    let is_end = |word: &&str| word.to_ascii_lowercase().ends_with(".mtl");
    let names = words.split_inclusive(is_end);
    names.map(|words| words.join(" "))
}

/// Checks a `v` statement and returns its coordinates and weight without
/// colours.
fn vertex<'a, 'b>(arguments: &'b [&'a str], ordinal: usize) -> Result<&'b [&'a str], String> {
    match arguments.len() {
        4 => {
            let kept = numbers("vertex", arguments, 4, ordinal)?;
            if kept[3].parse() == Ok(0.0) {
                return Err(format!(
                    "vertex {ordinal} has the weight 0; give it the weight 1 or none"
                ));
            }
            Ok(kept)
        }
        5 => Err(format!(
            "vertex {ordinal} has 5 numbers; expected 3, or 6 with a colour"
        )),
        _ => numbers("vertex", arguments, 3, ordinal),
    }
}

/// Checks that the first `count` arguments are finite numbers and returns
/// them. `ordinal` is the number of the element, from 1.
fn numbers<'a, 'b>(
    name: &str,
    arguments: &'b [&'a str],
    count: usize,
    ordinal: usize,
) -> Result<&'b [&'a str], String> {
    let Some(kept) = arguments.get(..count) else {
        return Err(format!(
            "{name} {ordinal} has {} numbers; expected {count}",
            arguments.len()
        ));
    };
    for word in kept {
        match word.parse::<f64>() {
            Err(_) => {
                return Err(format!(
                    "`{}` in {name} {ordinal} is not a number",
                    quoted(word)
                ));
            }
            Ok(number) if !number.is_finite() => {
                return Err(format!(
                    "{name} {ordinal} is not finite (`{}`); repair the mesh",
                    quoted(word)
                ));
            }
            Ok(number) if number.abs() > LARGEST_NUMBER => {
                return Err(format!(
                    "{name} {ordinal} is too large (`{}`); the limit is 1e12",
                    quoted(word)
                ));
            }
            Ok(_) => {}
        }
    }
    Ok(kept)
}

/// Checks one corner of a face, `position/uv/normal`, and returns which of the
/// three are present.
fn check_corner(
    corner: &str,
    line: usize,
    elements: &mut [Elements; 3],
) -> Result<[bool; 3], String> {
    let malformed = || {
        format!(
            "`{}` is not a face corner; expected `v`, `v/vt`, `v//vn` or `v/vt/vn`",
            quoted(corner)
        )
    };
    let mut present = [false; 3];
    for (slot, word) in corner.split('/').enumerate() {
        let stream = elements.get_mut(slot).ok_or_else(malformed)?;
        if word.is_empty() {
            continue;
        }
        let index: i64 = word.parse().map_err(|_| malformed())?;
        let name = stream.name;
        if index == 0 {
            return Err(format!("the face names {name} 0; OBJ counts from 1"));
        }
        let magnitude = usize::try_from(index.unsigned_abs()).map_err(|_| malformed())?;
        if index < 0 && magnitude > stream.count {
            let count = stream.count;
            return Err(format!(
                "the face names {name} {index}, but only {count} come before it"
            ));
        }
        if index > 0 && magnitude > stream.largest_index {
            stream.largest_index = magnitude;
            stream.largest_index_line = line;
        }
        present[slot] = true;
    }
    if present[0] {
        Ok(present)
    } else {
        Err(malformed())
    }
}

/// Shortens a word for a message.
fn quoted(word: &str) -> String {
    word.chars().take(QUOTED_CHARACTERS).collect()
}
