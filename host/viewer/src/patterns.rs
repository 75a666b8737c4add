//! Patterns to choose from: those that need no file, and files beside the present one.

use relievo::Files;
use relievo::scene::Shape;
use std::path::{Path, PathBuf};

/// Names and SVG documents of the patterns that need no file.
pub const DRAWINGS: [(&str, &str); 8] = [
    ("bricks", include_str!("../patterns/bricks.svg")),
    ("discs", include_str!("../patterns/discs.svg")),
    ("hexagons", include_str!("../patterns/hexagons.svg")),
    ("lattice", include_str!("../patterns/lattice.svg")),
    ("panes", include_str!("../patterns/panes.svg")),
    ("perforation", include_str!("../patterns/perforation.svg")),
    ("shingles", include_str!("../patterns/shingles.svg")),
    ("stripes", include_str!("../patterns/stripes.svg")),
];

/// Endings of the files that are patterns.
pub const ENDINGS: [&str; 13] = [
    "bmp", "gif", "jpeg", "jpg", "pbm", "pgm", "png", "ppm", "svg", "tga", "tif", "tiff", "webp",
];

/// Largest number of files.
const MOST_FILES: usize = 60;

/// A pattern and its name.
#[derive(Clone, PartialEq)]
pub struct Choice {
    /// The name, that of a file with its ending.
    pub name: String,
    /// The pattern.
    pub shape: Shape,
}

/// Returns whether a file has one of `endings`.
pub fn has_ending(path: &Path, endings: &[&str]) -> bool {
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    endings.contains(&ending.to_lowercase().as_str())
}

/// Returns the patterns in `folder` of the disk, or all in memory, sorted by name, after
/// those that need no file.
pub fn choices(files: &Files, folder: Option<&Path>) -> Vec<Choice> {
    let mut paths: Vec<PathBuf> = match (files, folder) {
        (Files::Memory(files), _) => files.keys().cloned().collect(),
        (_, Some(folder)) => {
            let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
            entries.map(|entry| entry.path()).collect()
        }
        (_, None) => Vec::new(),
    };
    paths.retain(|path| has_ending(path, &ENDINGS));
    paths.sort();
    paths.truncate(MOST_FILES);
    let drawings = DRAWINGS.iter().map(|(name, document)| Choice {
        name: (*name).to_string(),
        shape: Shape::svg(document),
    });
    let paths = paths.into_iter().map(|path| Choice {
        name: path
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned(),
        shape: Shape::File(path),
    });
    drawings.chain(paths).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_listed_after_the_drawings_and_what_is_no_picture_is_not() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["b.PNG", "a.svg", "mesh.obj", "notes"] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        let all = choices(&Files::Disk, Some(folder.path()));
        let names: Vec<&str> = all.iter().map(|choice| choice.name.as_str()).collect();
        assert_eq!(names[..2], ["bricks", "discs"]);
        assert_eq!(names[DRAWINGS.len()..], ["a.svg", "b.PNG"]);
        assert_eq!(
            all.last().unwrap().shape,
            Shape::File(folder.path().join("b.PNG"))
        );
        let memory = Files::memory([
            ("patterns/c.png".into(), b"".as_slice().into()),
            ("meshes/d.obj".into(), b"".as_slice().into()),
        ]);
        let all = choices(&memory, None);
        assert_eq!(all.last().unwrap().name, "c.png");
        assert_eq!(all.len(), DRAWINGS.len() + 1);
    }
}
