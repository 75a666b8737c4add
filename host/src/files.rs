//! Sources of files: the disk, one folder of it, or memory.
//!
//! ```
//! use relievo::Files;
//! use std::path::Path;
//!
//! let files = Files::memory([("meshes/a.obj".into(), b"v 0 0 0".as_slice().into())]);
//! assert_eq!(*files.read(Path::new("./meshes/a.obj"), 100)?, *b"v 0 0 0");
//! assert!(files.check(Path::new("b.obj")).is_err());
//! # Ok::<(), std::io::Error>(())
//! ```

use crate::file::{open_regular, read_regular, too_large};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Cursor, ErrorKind, Read, Seek, SeekFrom};
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

/// Name of the folder of scenes that may read their parent folder.
const SCENES: &str = "scenes";

/// Maximum number of file names in a message.
const LISTED: usize = 12;

/// The files that may be read.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Files {
    /// Every file of the disk.
    #[default]
    Disk,
    /// Files in this folder and below; the path is absolute, without symbolic
    /// links.
    Below(PathBuf),
    /// Files in memory by their [`normal`] paths; see [`Files::memory`]. The disk
    /// is not read.
    Memory(Arc<BTreeMap<PathBuf, Arc<[u8]>>>),
}

impl Files {
    /// Creates files in memory from their paths and bytes.
    pub fn memory(files: impl IntoIterator<Item = (PathBuf, Arc<[u8]>)>) -> Files {
        let files = files.into_iter();
        Files::Memory(Arc::new(
            files.map(|(name, bytes)| (normal(&name), bytes)).collect(),
        ))
    }

    /// Returns the files that a scene in `folder` may read: those in it, or in its
    /// parent folder if it is called `scenes`.
    ///
    /// # Errors
    /// Error of the system if `folder` cannot be resolved.
    pub fn of_scene(folder: &Path) -> io::Result<Files> {
        let folder = if folder == Path::new("") {
            Path::new(".")
        } else {
            folder
        };
        let folder = folder.canonicalize()?;
        Ok(Files::Below(match folder.parent() {
            Some(around) if folder.ends_with(SCENES) => around.to_path_buf(),
            _ => folder,
        }))
    }

    /// Checks that `path` may be read. A file on the disk need not exist.
    ///
    /// # Errors
    /// The reason and the remedy.
    pub fn check(&self, path: &Path) -> Result<(), String> {
        match self {
            Files::Disk => Ok(()),
            Files::Below(root) => {
                let real = path.canonicalize().unwrap_or_else(|_| without_dots(path));
                if real.starts_with(root) {
                    return Ok(());
                }
                Err(format!(
                    "names {}, which is outside of {}; move the file there, or let the scene read any file with --allow-outside",
                    real.display(),
                    root.display()
                ))
            }
            Files::Memory(files) => {
                let name = normal(path);
                if files.contains_key(&name) {
                    return Ok(());
                }
                Err(format!(
                    "names {}, which is not among the files at hand; add it, or name one of {}",
                    name.display(),
                    listed(files)
                ))
            }
        }
    }

    /// Opens a regular file.
    ///
    /// # Errors
    /// Error of the system, or that `path` is not a regular file or may not be
    /// read.
    pub(crate) fn open(&self, path: &Path) -> io::Result<Opened> {
        if let Files::Memory(files) = self {
            let bytes = files
                .get(&normal(path))
                .ok_or_else(|| missing(files))?
                .clone();
            return Ok(Opened {
                length: bytes.len() as u64,
                source: Source::Memory(Cursor::new(bytes)),
            });
        }
        self.allow(path)?;
        let file = open_regular(path)?;
        Ok(Opened {
            length: file.metadata()?.len(),
            source: Source::Disk(BufReader::new(file)),
        })
    }

    /// Reads a regular file of at most `limit` bytes.
    ///
    /// # Errors
    /// As `Files::open`; [`ErrorKind::FileTooLarge`] before a larger file is read.
    pub fn read(&self, path: &Path, limit: u64) -> io::Result<Cow<'_, [u8]>> {
        let Files::Memory(files) = self else {
            self.allow(path)?;
            return read_regular(path, limit).map(Cow::Owned);
        };
        let bytes = files.get(&normal(path)).ok_or_else(|| missing(files))?;
        if bytes.len() as u64 > limit {
            return Err(too_large(limit));
        }
        Ok(Cow::Borrowed(bytes))
    }

    /// Returns whether `path` is a folder on the disk.
    pub(crate) fn is_folder(&self, path: &Path) -> bool {
        !matches!(self, Files::Memory(_)) && path.is_dir()
    }

    /// Checks a path that is about to be read, as [`Files::check`].
    fn allow(&self, path: &Path) -> io::Result<()> {
        self.check(path)
            .map_err(|problem| io::Error::new(ErrorKind::PermissionDenied, format!("it {problem}")))
    }
}

/// Returns the error for a missing file in memory.
fn missing(files: &BTreeMap<PathBuf, Arc<[u8]>>) -> io::Error {
    io::Error::new(
        ErrorKind::NotFound,
        format!("there is no such file among {}", listed(files)),
    )
}

/// Lists the first names of `files`.
fn listed(files: &BTreeMap<PathBuf, Arc<[u8]>>) -> String {
    if files.is_empty() {
        return "none at all".to_string();
    }
    let names = files.keys().take(LISTED);
    let mut text = names
        .map(|name| name.display().to_string())
        .collect::<Vec<_>>()
        .join(", ");
    if files.len() > LISTED {
        text += &format!(" and {} more", files.len() - LISTED);
    }
    text
}

/// Returns `path` without `.`, `..` and root. Links are not resolved, and `..` stops
/// at the first folder.
pub fn normal(path: &Path) -> PathBuf {
    let mut parts = PathBuf::new();
    for component in path.components() {
        match component {
            Component::ParentDir => {
                parts.pop();
            }
            Component::Normal(part) => parts.push(part),
            Component::CurDir | Component::RootDir | Component::Prefix(_) => {}
        }
    }
    parts
}

/// Returns the path of `to` relative to the folder `from`, with `/` between folders;
/// `to` itself if there is none, as between drives. Both paths are absolute, without
/// links and `..`.
pub fn relative(from: &Path, to: &Path) -> String {
    let shared = from
        .components()
        .zip(to.components())
        .take_while(|(a, b)| a == b)
        .count();
    if shared == 0 {
        return to.to_string_lossy().into_owned();
    }
    let up = from.components().skip(shared).map(|_| Component::ParentDir);
    let way: PathBuf = up.chain(to.components().skip(shared)).collect();
    if way.as_os_str().is_empty() {
        return ".".to_string();
    }
    let names: Vec<_> = way
        .iter()
        .map(|name| name.to_string_lossy().into_owned())
        .collect();
    names.join("/")
}

/// An open file.
pub(crate) struct Opened {
    /// Length, bytes.
    pub(crate) length: u64,
    source: Source,
}

enum Source {
    Disk(BufReader<File>),
    Memory(Cursor<Arc<[u8]>>),
}

impl Read for Opened {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match &mut self.source {
            Source::Disk(file) => file.read(buffer),
            Source::Memory(bytes) => bytes.read(buffer),
        }
    }
}

impl BufRead for Opened {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        match &mut self.source {
            Source::Disk(file) => file.fill_buf(),
            Source::Memory(bytes) => bytes.fill_buf(),
        }
    }

    fn consume(&mut self, count: usize) {
        match &mut self.source {
            Source::Disk(file) => file.consume(count),
            Source::Memory(bytes) => bytes.consume(count),
        }
    }
}

impl Seek for Opened {
    fn seek(&mut self, place: SeekFrom) -> io::Result<u64> {
        match &mut self.source {
            Source::Disk(file) => file.seek(place),
            Source::Memory(bytes) => bytes.seek(place),
        }
    }
}

/// Returns the absolute path of a missing file, with links resolved as far as folders
/// exist.
fn without_dots(path: &Path) -> PathBuf {
    let mut real = PathBuf::new();
    let absolute = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    for component in absolute.components() {
        match component {
            Component::ParentDir => {
                real.pop();
            }
            Component::CurDir => {}
            part => {
                real.push(part);
                // A link decides where the next `..` leads.
                real = real.canonicalize().unwrap_or(real);
            }
        }
    }
    real
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn a_scene_reads_its_folder_and_what_is_below() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir_all(at("project/meshes")).unwrap();
        fs::create_dir_all(at("project/scenes/more")).unwrap();
        fs::create_dir_all(at("project2")).unwrap();
        for file in ["a", "project/a", "project/meshes/a", "project2/a"] {
            fs::write(at(file), "").unwrap();
        }
        let may = |scenes: &str, path: &str| {
            let folder = at(scenes);
            Files::of_scene(&folder)
                .unwrap()
                .check(&folder.join(path))
                .is_ok()
        };
        // Also of files that are not there: the error is that they are missing.
        for path in [
            "a",
            "./a",
            "meshes/a",
            "meshes/../a",
            "none",
            "no/ne",
            "no/../ne",
        ] {
            assert!(may("project", path), "{path}");
        }
        for path in [
            "../a",
            "../none",
            "..",
            "meshes/../../a",
            "no/../../none",
            "../project2/a",
        ] {
            assert!(!may("project", path), "{path}");
        }
        assert!(may("project/scenes", "../meshes/a"));
        assert!(!may("project/scenes", "../../a"));
        assert!(!may("project/scenes", "../../project2/a"));
        assert!(!may("project/scenes/more", "../../meshes/a"));
        let absolute = at("project/a").display().to_string();
        assert!(may("project", &absolute) && !may("project2", &absolute));
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        let project = folder.path().join("project");
        fs::create_dir_all(project.join("meshes")).unwrap();
        fs::write(folder.path().join("secret"), "").unwrap();
        symlink(folder.path(), project.join("out")).unwrap();
        symlink("../secret", project.join("file")).unwrap();
        symlink("meshes", project.join("within")).unwrap();
        let reach = Files::of_scene(&project).unwrap();
        for path in ["out/secret", "file", "out/none", "out/project/../none"] {
            let problem = reach.check(&project.join(path)).unwrap_err();
            assert!(problem.contains("--allow-outside"), "{problem}");
        }
        for path in ["within/a", "out/project/a"] {
            assert!(reach.check(&project.join(path)).is_ok(), "{path}");
        }
    }

    #[test]
    fn names_in_memory_are_what_their_text_says() {
        let bytes = |text: &str| Arc::from(text.as_bytes());
        let files = Files::memory([
            ("./meshes/a.obj".into(), bytes("a")),
            ("scenes/../b".into(), bytes("bb")),
        ]);
        for path in [
            "meshes/a.obj",
            "scenes/../meshes/a.obj",
            "/meshes/./a.obj",
            "../meshes/a.obj",
        ] {
            assert_eq!(*files.read(Path::new(path), 1).unwrap(), *b"a", "{path}");
            assert!(files.check(Path::new(path)).is_ok());
        }
        let mut text = String::new();
        let mut opened = files.open(Path::new("b")).unwrap();
        opened.read_to_string(&mut text).unwrap();
        assert_eq!((opened.length, text.as_str()), (2, "bb"));
        let error = files.read(Path::new("b"), 1).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::FileTooLarge);
        // This file is on the disk.
        let missing = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml");
        let error = files.read(&missing, 9).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::NotFound);
        for problem in [error.to_string(), files.check(&missing).unwrap_err()] {
            assert!(problem.contains("b, meshes/a.obj"), "{problem}");
        }
        assert!(!files.is_folder(Path::new(".")));
    }

    #[test]
    fn what_is_outside_is_not_opened() {
        let folder = tempfile::tempdir().unwrap();
        let project = folder.path().join("project");
        fs::create_dir_all(&project).unwrap();
        fs::write(folder.path().join("secret"), "x").unwrap();
        fs::write(project.join("open"), "x").unwrap();
        let files = Files::of_scene(&project).unwrap();
        assert!(files.read(&project.join("open"), 1).is_ok());
        let error = files.read(&project.join("../secret"), 1).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::PermissionDenied);
        assert!(error.to_string().contains("--allow-outside"), "{error}");
        assert!(files.open(&folder.path().join("secret")).is_err());
        assert!(Files::Disk.read(&folder.path().join("secret"), 1).is_ok());
    }

    #[test]
    fn ways_between_folders() {
        let way = |from: &str, to: &str| relative(Path::new(from), Path::new(to));
        assert_eq!(way("/a/b/scenes", "/a/assets"), "../../assets");
        assert_eq!(way("/a/scenes", "/a/scenes/assets"), "assets");
        assert_eq!(way("/a", "/a"), ".");
        assert_eq!(way("/tmp/x", "/a"), "../../a");
    }
}
