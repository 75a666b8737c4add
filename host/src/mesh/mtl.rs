//! Material libraries of OBJ files (`.mtl`), read with `tobj`.
//!
//! Materials of Phong become metallic-roughness: Kd is the base colour and Ns gives the
//! roughness, unless the statements of the PBR extension (Pr, Pm, map_Pr, map_Pm, norm) say
//! more.

use std::borrow::Cow;
use std::collections::HashMap;
use std::io::ErrorKind;
use std::path::Path;

use super::encoding;
use super::error::MeshError;
use super::material::{MeshMaterial, MeshMaterials, Placed};
use super::scan::{Scan, scan};
use crate::{Files, srgb};

/// Returns the materials of the OBJ file `text` in the order of
/// [`Mesh::materials`](super::Mesh::materials). Libraries and pictures are read from `files`,
/// relative to the folder of `path`.
///
/// # Errors
///
/// [`MeshError::Invalid`] with the library, and its line if it is malformed, and
/// [`MeshError::TooLarge`].
pub(super) fn materials(
    files: &Files,
    text: &str,
    path: &Path,
    byte_limit: u64,
) -> Result<MeshMaterials, MeshError> {
    let scan = scan(text, path, usize::MAX, &[])?;
    let mut reader = Reader {
        files,
        path,
        byte_limit,
        left: byte_limit.saturating_sub(text.len() as u64),
        found: MeshMaterials::default(),
    };
    let libraries = reader.libraries(&scan)?;
    // Of two materials with one name, the first one counts.
    let names = libraries.iter().rev();
    let defined: HashMap<String, &tobj::Material> = names
        .map(|material| (words(&material.name), material))
        .collect();
    for name in &scan.materials {
        let material = match defined.get(name) {
            Some(material) => reader.material(material)?,
            None => {
                if !name.is_empty() {
                    let problem = format!(
                        "the material {name:?} is in none of its {} .mtl files; drawn white",
                        scan.libraries.len()
                    );
                    reader.found.problems.push(problem);
                }
                MeshMaterial {
                    name: name.clone(),
                    ..MeshMaterial::default()
                }
            }
        };
        reader.found.materials.push(material);
    }
    Ok(reader.found)
}

/// Parses a library.
///
/// # Errors
///
/// The first line that is malformed, and what is wrong with it.
fn parse(text: &str) -> Result<Vec<tobj::Material>, (usize, String)> {
    let mut statements = String::with_capacity(text.len());
    for (index, line) in text.lines().enumerate() {
        statements += &statement(line).map_err(|problem| (index + 1, problem))?;
        statements.push('\n');
    }
    let parsed = tobj::load_mtl_buf(&mut statements.as_bytes());
    let (materials, _) = parsed.map_err(|error| {
        // Each line is a statement of its own.
        let is_wrong = |line: &str| tobj::load_mtl_buf(&mut line.as_bytes()).is_err();
        let wrong = statements.lines().position(is_wrong);
        (wrong.map_or(1, |index| index + 1), error.to_string())
    })?;
    Ok(materials)
}

/// Returns a statement as `tobj` expects it, without comment. `tobj` panics where a colour has not
/// three numbers.
fn statement(line: &str) -> Result<Cow<'_, str>, String> {
    let mut words = line.split_whitespace();
    let keyword = words.next().unwrap_or_default();
    // Names may have a # in them.
    let words: Vec<&str> = words.take_while(|word| !word.starts_with('#')).collect();
    let number = |text: &str| match text.parse::<f32>() {
        Ok(_) => Ok(()),
        Err(_) => Err(format!("`{text}` is not a number")),
    };
    match (keyword, &words[..]) {
        (keyword, _) if keyword.starts_with('#') => Ok("".into()),
        // Curves and CIE coordinates are for other programs.
        ("Ka" | "Kd" | "Ks" | "Ke", ["spectral" | "xyz", ..]) => Ok("".into()),
        ("Ka" | "Kd" | "Ks" | "Ke", [grey]) => Ok(format!("{keyword} {grey} {grey} {grey}").into()),
        ("Ka" | "Kd" | "Ks" | "Ke", [red, green, blue, ..]) => {
            Ok(format!("{keyword} {red} {green} {blue}").into())
        }
        ("Ka" | "Kd" | "Ks" | "Ke", numbers) => Err(format!(
            "`{keyword}` has {} numbers; expected 3, or 1",
            numbers.len()
        )),
        // Opaque where it is seen from the side.
        ("d", ["-halo", opacity, ..]) => Ok(format!("d {opacity}").into()),
        ("Pr" | "Pm" | "Tr", [value, ..]) => number(value).map(|()| line.into()),
        ("Pr" | "Pm" | "Tr", []) => Err(format!("`{keyword}` has no number")),
        ("newmtl", []) => Err("`newmtl` has no name".to_string()),
        _ => Ok(format!("{keyword} {}", words.join(" ")).into()),
    }
}

/// Returns `name` with single spaces, as the scan has it.
fn words(name: &str) -> String {
    name.split_whitespace().collect::<Vec<_>>().join(" ")
}

struct Reader<'a> {
    files: &'a Files,
    path: &'a Path,
    byte_limit: u64,
    /// Bytes that may still be read.
    left: u64,
    found: MeshMaterials,
}

impl Reader<'_> {
    /// Reads the materials of all libraries.
    fn libraries(&mut self, scan: &Scan) -> Result<Vec<tobj::Material>, MeshError> {
        let mut defined = Vec::new();
        if scan.materials.is_empty() {
            return Ok(defined);
        }
        for (index, (line, name)) in scan.libraries.iter().enumerate() {
            let mut before = scan.libraries[..index].iter();
            if before.any(|(_, other)| other == name) {
                continue;
            }
            let failure = |problem: String| MeshError::Invalid {
                path: self.path.to_owned(),
                problem: format!("its materials `{name}`, which line {line} names, {problem}"),
            };
            let bytes = match self.read(name) {
                Ok(bytes) => bytes,
                Err(Unread::TooLarge) => return Err(self.too_large()),
                Err(Unread::Because(problem)) => {
                    return Err(failure(format!(
                        "cannot be read: {problem}; put the file there, or name materials of the scene in place of `@mesh`"
                    )));
                }
            };
            let text = encoding::text(&bytes).ok_or_else(|| {
                failure("are not text; export the mesh again with its .mtl file".to_string())
            })?;
            defined.extend(parse(&text).map_err(|(line, problem)| {
                failure(format!(
                    "cannot be parsed in line {line}: {problem}; correct it"
                ))
            })?);
        }
        Ok(defined)
    }

    fn material(&mut self, read: &tobj::Material) -> Result<MeshMaterial, MeshError> {
        let parameter = |name: &str| read.unknown_param.get(name).map(String::as_str);
        let number = |name: &str| parameter(name)?.parse::<f32>().ok();
        let picture = read.diffuse_texture.as_deref().map(Texture::parse);
        let color = match read.diffuse {
            // Exporters write black where a picture stands in for the colour.
            Some(color) if picture.is_none() || color != [0.0; 3] => color,
            _ => [1.0; 3],
        };
        let mut material = MeshMaterial {
            name: words(&read.name),
            base_color: color.map(|channel| srgb::linear(channel) as f32),
            metallic: number("Pm").unwrap_or(0.0),
            emission: read
                .emissive
                .map_or([0.0; 3], |color| color.map(|light| light as f32)),
            ..MeshMaterial::default()
        };
        material.roughness = number("Pr").unwrap_or_else(|| match read.shininess {
            // The exponent of microfacets of this α.
            Some(exponent) => (2.0 / (exponent.max(0.0) + 2.0)).powf(0.25) as f32,
            None => material.roughness,
        });
        // All pictures of a material lie alike.
        let mut placed = None;
        if let Some(picture) = &picture {
            material.base_color_picture = self.picture(picture, &read.name, &mut placed)?;
        }
        let normal = ["norm", "map_Kn"].into_iter().find_map(parameter);
        if let Some(picture) = normal.map(Texture::parse) {
            material.normal_scale = picture.bump;
            material.normal_picture = self.picture(&picture, &read.name, &mut placed)?;
        }
        if let Some(picture) = parameter("map_Ke").map(Texture::parse) {
            material.emission_picture = self.picture(&picture, &read.name, &mut placed)?;
            // Without its picture nothing says where it glows.
            if material.emission_picture.is_none() {
                material.emission = [0.0; 3];
            } else if material.emission == [0.0; 3] {
                material.emission = [1.0; 3];
            }
        }
        let Placed {
            scale,
            offset: [right, up],
        } = placed.unwrap_or(Placed::PLAIN);
        material.tiles = scale;
        // Ours begins at the upper end, and rows run down.
        material.offset = [right, -up];
        let is_transparent = read.dissolve.is_some_and(|opacity| opacity < 1.0)
            || number("Tr").is_some_and(|transparency| transparency > 0.0)
            || read.dissolve_texture.is_some();
        let mut unused = vec![];
        for (is_there, what) in [
            (is_transparent, "transparency (d, Tr, map_d)"),
            (read.normal_texture.is_some(), "heights (map_Bump)"),
            (
                read.specular_texture.is_some(),
                "pictures of highlights (map_Ks)",
            ),
            (
                read.shininess_texture.is_some(),
                "pictures of shininess (map_Ns)",
            ),
        ] {
            if is_there {
                unused.push(what.to_string());
            }
        }
        let used = ["Pr", "Pm", "Tr", "map_Ke", "norm", "map_Kn"];
        let others = read.unknown_param.keys();
        unused.extend(
            others
                .filter(|name| !used.contains(&name.as_str()))
                .cloned(),
        );
        for what in unused {
            self.found.leave(&material.name, what);
        }
        Ok(material)
    }

    /// Returns the index of a picture; `None` where it cannot be read. The first one of a
    /// `material` says how all others lie: their scale and offset.
    fn picture(
        &mut self,
        texture: &Texture,
        material: &str,
        placed: &mut Option<Placed>,
    ) -> Result<Option<usize>, MeshError> {
        let name = &texture.file;
        if name.is_empty() {
            let problem =
                format!("a picture of the material {material:?} has no file name; drawn without");
            self.found.problems.push(problem);
            return Ok(None);
        }
        let index = match self.found.known(name) {
            Some(index) => index,
            None => match self.read(name) {
                Ok(bytes) => self.found.add(name.clone(), bytes),
                Err(Unread::TooLarge) => return Err(self.too_large()),
                Err(Unread::Because(problem)) => {
                    let problem = format!(
                        "cannot read its picture `{name}`: {problem}; put it beside the mesh; drawn without"
                    );
                    self.found.problems.push(problem);
                    return Ok(None);
                }
            },
        };
        let at = Placed {
            scale: texture.scale,
            offset: texture.offset,
        };
        if !self.found.can_place(at, material, placed) {
            return Ok(None);
        }
        for option in &texture.unused {
            self.found.leave(material, format!("{option} of pictures"));
        }
        Ok(Some(index))
    }

    /// Reads a file beside the mesh.
    fn read(&mut self, name: &str) -> Result<Vec<u8>, Unread> {
        let folder = self.path.parent().unwrap_or(Path::new(""));
        // Windows has other separators.
        let file = folder.join(name.replace('\\', "/"));
        self.files.check(&file).map_err(Unread::Because)?;
        match self.files.read(&file, self.left) {
            Ok(bytes) => {
                self.left = self.left.saturating_sub(bytes.len() as u64);
                Ok(bytes.into_owned())
            }
            Err(error) if error.kind() == ErrorKind::FileTooLarge => Err(Unread::TooLarge),
            Err(error) => Err(Unread::Because(error.to_string())),
        }
    }

    fn too_large(&self) -> MeshError {
        MeshError::TooLarge {
            path: self.path.to_owned(),
            limit: self.byte_limit,
        }
    }
}

/// Why a file is not read.
enum Unread {
    TooLarge,
    Because(String),
}

/// The arguments of a statement that names a picture.
#[derive(Debug, PartialEq)]
struct Texture {
    file: String,
    /// Option `-s`: repeats per repeat of the texture coordinates.
    scale: [f32; 2],
    /// Option `-o`: offset, to the right and up.
    offset: [f32; 2],
    /// Option `-bm`: factor of slopes.
    bump: f32,
    /// Further options.
    unused: Vec<String>,
}

impl Texture {
    fn parse(arguments: &str) -> Texture {
        let mut texture = Texture {
            file: String::new(),
            scale: [1.0; 2],
            offset: [0.0; 2],
            bump: 1.0,
            unused: Vec::new(),
        };
        let mut words = arguments.split_whitespace().peekable();
        while let Some(option) = words.next_if(|word| word.starts_with('-')) {
            let mut numbers: Vec<f32> = Vec::new();
            // At most as many as the option may have: a file name may be a number, too.
            let most = match option {
                "-s" | "-o" | "-t" => 3,
                "-mm" => 2,
                "-bm" | "-boost" | "-texres" => 1,
                _ => 0,
            };
            while numbers.len() < most
                && let Some(number) = words.next_if(|word| word.parse::<f32>().is_ok())
            {
                numbers.extend(number.parse::<f32>());
            }
            let first = numbers.first().copied();
            match option {
                "-s" => texture.scale = [0, 1].map(|i| numbers.get(i).copied().unwrap_or(1.0)),
                "-o" => texture.offset = [0, 1].map(|i| numbers.get(i).copied().unwrap_or(0.0)),
                "-bm" => texture.bump = first.unwrap_or(1.0),
                _ => {
                    texture.unused.push(option.to_string());
                    if most == 0 {
                        // `on`, `off`, or the name of a channel.
                        words.next();
                    }
                }
            }
        }
        texture.file = words.collect::<Vec<_>>().join(" ");
        texture
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIANGLE: &str = "mtllib a b.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n";

    fn load(faces: &str, library: &str) -> Result<MeshMaterials, MeshError> {
        let files = Files::memory([
            ("folder/a b.mtl".into(), library.as_bytes().into()),
            ("folder/wood.png".into(), b"wood".as_slice().into()),
        ]);
        let text = format!("{TRIANGLE}{faces}");
        materials(&files, &text, Path::new("folder/a.obj"), 1000)
    }

    #[test]
    fn materials_come_in_the_order_of_their_use() {
        let library = "\u{feff}newmtl  red  paint # dry\nKd 1 0 0\nNs 0\nnewmtl oak\nKd 0 0 0\nmap_Kd -s 2 3 1 -o 0.5 0.25 wood.png # new\nPr 0.25\nPm 1\nKe 0 2 0\nd -halo 0.5\nnewmtl none\nKa 1\nKs spectral a.rfl\n";
        let faces =
            "f 1 2 3\nusemtl oak\nf 1 2 3\nusemtl red paint\nf 1 2 3\nusemtl gone\nf 1 2 3\n";
        let found = load(faces, library).unwrap();
        let names: Vec<&str> = found.materials.iter().map(|found| &*found.name).collect();
        assert_eq!(names, ["", "oak", "red paint", "gone"]);
        let [_, oak, red, _] = &found.materials[..] else {
            unreachable!()
        };
        assert_eq!((red.base_color, red.roughness), ([1.0, 0.0, 0.0], 1.0));
        // The picture, not black.
        assert_eq!(
            (oak.base_color, oak.base_color_picture),
            ([1.0; 3], Some(0))
        );
        assert_eq!(
            (oak.tiles, oak.offset, oak.roughness, oak.metallic),
            ([2.0, 3.0], [0.5, -0.25], 0.25, 1.0)
        );
        assert_eq!(oak.emission, [0.0, 2.0, 0.0]);
        assert_eq!(found.pictures, [("wood.png".to_string(), b"wood".to_vec())]);
        assert_eq!(found.unused.len(), 1);
        assert_eq!(
            found.problems,
            ["the material \"gone\" is in none of its 1 .mtl files; drawn white"]
        );
    }

    #[test]
    fn a_missing_picture_is_told_and_a_missing_library_refused() {
        let faces = "usemtl oak\nf 1 2 3\n";
        let found = load(faces, "newmtl oak\nmap_Kd ..\\x.png\n").unwrap();
        assert_eq!(found.materials[0].base_color_picture, None);
        assert!(found.problems[0].contains("x.png"), "{:?}", found.problems);
        let error = load("mtllib c.mtl\nusemtl oak\nf 1 2 3\n", "").unwrap_err();
        let message = error.to_string();
        assert!(message.contains("`c.mtl`, which line 5 names"), "{message}");
        // What nobody uses need not exist.
        assert!(
            load("mtllib c.mtl\nf 1 2 3\n", "")
                .unwrap()
                .materials
                .is_empty()
        );
    }

    #[test]
    fn a_malformed_library_is_told_with_its_line() {
        for statement in [
            "Kd 1 x 0", "Kd 1 2", "Pr x", "Tr", "Ns", "illum x", "newmtl", "map_Kd",
        ] {
            let library = format!("newmtl oak\n# comment\n{statement}\n");
            let message = load("usemtl oak\nf 1 2 3\n", &library)
                .unwrap_err()
                .to_string();
            assert!(message.contains("`a b.mtl`"), "{message}");
            assert!(message.contains("line 3: "), "{statement}: {message}");
        }
    }

    #[test]
    fn options_of_pictures() {
        let parse = |text| Texture::parse(text);
        assert_eq!(parse("a b.png").file, "a b.png");
        let all = parse("-blendu on -o 1 2 -s 4 -mm 0 1 -bm 0.5 -clamp on a.png");
        assert_eq!(
            (&*all.file, all.scale, all.bump),
            ("a.png", [4.0, 1.0], 0.5)
        );
        assert_eq!(all.offset, [1.0, 2.0]);
        assert_eq!(all.unused, ["-blendu", "-mm", "-clamp"]);
        assert_eq!(parse("-s 1 1 1 2.png").file, "2.png");
        assert_eq!(parse("-s").file, "");
    }

    proptest::proptest! {
        #[test]
        fn no_library_panics(text in "(((newmtl|Kd|Ns|map_Kd|norm|Pr|d|bump)( [-0-9.a-z/\\\\]{0,5}){0,4})\n){0,8}") {
            let _ = load("usemtl a\nf 1 2 3\n", &text);
        }
    }
}
