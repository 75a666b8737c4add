//! Writes the meshes, the patterns and the pictures of materials of `assets/`.
//!
//! `cargo run -p relievo-assets [-- OUT_DIR]` writes `OUT_DIR/meshes/*.obj`, the materials of one,
//! `OUT_DIR/patterns/*.png`, `OUT_DIR/materials/*.png` and `OUT_DIR/environments/*.hdr`; without `OUT_DIR` it updates the committed files. The
//! output is deterministic.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};

mod buildings;
mod glyphs;
mod materials;
mod mesh;
mod patterns;
mod sdf;
mod shapes;

/// A file to write.
struct Asset {
    /// Path relative to the output directory.
    path: String,
    /// Content of the file.
    bytes: Vec<u8>,
}

/// Returns all files.
///
/// # Errors
///
/// If a pattern cannot be encoded as PNG.
fn generate() -> Result<Vec<Asset>> {
    let mut assets = Vec::new();
    for mesh in shapes::all() {
        assets.push(Asset {
            path: format!("meshes/{}.obj", mesh.name),
            bytes: mesh.to_obj().into_bytes(),
        });
    }
    for (name, text) in buildings::all() {
        assets.push(Asset {
            path: format!("meshes/{name}.obj"),
            bytes: text.into_bytes(),
        });
    }
    assets.push(Asset {
        path: "meshes/buildings.mtl".to_owned(),
        bytes: buildings::LIBRARY.as_bytes().to_vec(),
    });
    for pattern in patterns::all() {
        assets.push(Asset {
            path: format!("patterns/{}.png", pattern.name),
            bytes: pattern.to_png()?,
        });
    }
    for picture in materials::all()? {
        assets.push(Asset {
            path: picture.path.to_string(),
            bytes: picture.bytes,
        });
    }
    Ok(assets)
}

/// Returns the assets folder that contains this generator.
fn default_directory() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn write(directory: &Path) -> Result<()> {
    for asset in generate()? {
        let path = directory.join(&asset.path);
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder).with_context(|| {
                format!(
                    "cannot create the folder {}; give another OUT_DIR",
                    folder.display()
                )
            })?;
        }
        fs::write(&path, &asset.bytes)
            .with_context(|| format!("cannot write {}; give another OUT_DIR", path.display()))?;
        println!("{} ({} bytes)", asset.path, asset.bytes.len());
    }
    Ok(())
}

fn main() -> Result<()> {
    let mut arguments = std::env::args_os().skip(1);
    let directory = arguments
        .next()
        .map_or_else(default_directory, PathBuf::from);
    // There are no options: an argument like one is not a folder.
    if directory.to_string_lossy().starts_with('-') || arguments.next().is_some() {
        bail!("usage: cargo run -p relievo-assets [-- OUT_DIR]");
    }
    write(&directory)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_runs_make_the_same_bytes() {
        let (first, second) = (generate().unwrap(), generate().unwrap());
        assert_eq!(first.len(), 26);
        for (a, b) in first.iter().zip(&second) {
            assert_eq!(a.path, b.path);
            assert!(a.bytes == b.bytes, "{} differs between two runs", a.path);
        }
    }

    /// Compares meshes by line, so that a checkout with CRLF passes, and patterns by
    /// pixel, so that the PNG encoder does not matter.
    #[test]
    fn committed_files_are_what_the_generator_makes() {
        let advice = "run `cargo run -p relievo-assets` and commit the result";
        for asset in generate().unwrap() {
            let path = default_directory().join(&asset.path);
            let committed =
                fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}; {advice}", asset.path));
            if asset.path.starts_with("meshes/") {
                let made = String::from_utf8(asset.bytes).unwrap();
                let committed = String::from_utf8(committed).unwrap();
                for (number, (a, b)) in made.lines().zip(committed.lines()).enumerate() {
                    assert_eq!(a, b, "{}, line {}; {advice}", asset.path, number + 1);
                }
                assert_eq!(
                    made.lines().count(),
                    committed.lines().count(),
                    "{}: number of lines; {advice}",
                    asset.path
                );
            } else {
                let made = image::load_from_memory(&asset.bytes).unwrap();
                let committed = image::load_from_memory(&committed).unwrap();
                assert!(made == committed, "{} differs; {advice}", asset.path);
            }
        }
    }
}
