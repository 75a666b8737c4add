//! Reads regular files only, and writes files and folders whole or not at all.
//!
//! ```
//! use relievo::file::{read_regular, write_bytes};
//!
//! let folder = tempfile::tempdir()?;
//! let path = folder.path().join("new/a.txt");
//! write_bytes(&path, b"text")?;
//! assert_eq!(read_regular(&path, 100)?, b"text");
//! assert!(read_regular(&path, 3).is_err());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, BufWriter, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Error of writing a file or folder.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {path}: {source}")]
pub struct WriteError {
    /// The file or folder.
    pub path: PathBuf,
    /// Error of the system.
    pub source: io::Error,
}

/// Files that are read, once somebody wants to know.
static READ: Mutex<Option<BTreeSet<PathBuf>>> = Mutex::new(None);

/// Returns the regular files that this process has opened for reading since the last call. The first
/// call returns none, and begins.
pub fn files_read() -> BTreeSet<PathBuf> {
    let mut read = READ.lock().unwrap_or_else(PoisonError::into_inner);
    read.replace(BTreeSet::new()).unwrap_or_default()
}

/// Opens a regular file for reading. Pipes and devices are errors: reading them
/// may never end, and opening them may block.
///
/// # Errors
/// Error of the system, or that `path` is not a regular file.
pub fn open_regular(path: &Path) -> io::Result<File> {
    // Checked first: opening a pipe waits for its other end.
    if std::fs::metadata(path)?.is_file() {
        if let Some(read) = &mut *READ.lock().unwrap_or_else(PoisonError::into_inner) {
            read.insert(path.to_path_buf());
        }
        File::open(path)
    } else {
        Err(io::Error::other(
            "it is a folder, a pipe or a device; name a regular file",
        ))
    }
}

/// Reads a regular file of at most `limit` bytes.
///
/// # Errors
/// As [`open_regular`]; [`ErrorKind::FileTooLarge`] before a larger file is read.
pub fn read_regular(path: &Path, limit: u64) -> io::Result<Vec<u8>> {
    let file = open_regular(path)?;
    let length = file.metadata()?.len();
    let mut bytes = Vec::new();
    if length <= limit {
        bytes.try_reserve_exact(length as usize)?;
        // The file may grow while it is read.
        file.take(limit.saturating_add(1)).read_to_end(&mut bytes)?;
    }
    if length.max(bytes.len() as u64) > limit {
        return Err(too_large(limit));
    }
    Ok(bytes)
}

/// Returns the error for a file of more than `limit` bytes.
pub(crate) fn too_large(limit: u64) -> io::Error {
    io::Error::new(
        ErrorKind::FileTooLarge,
        format!("it has more than {limit} bytes; make it smaller, or raise the limit"),
    )
}

/// Temporary files and folders that are being written.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn unfinished() -> MutexGuard<'static, Vec<PathBuf>> {
    // A panic elsewhere leaves the list valid.
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Keeps a temporary file or folder in [`UNFINISHED`].
struct Registered(PathBuf);

impl Drop for Registered {
    fn drop(&mut self) {
        unfinished().retain(|path| *path != self.0);
    }
}

/// Removes the temporary files and folders of this process, then calls `end`,
/// which ends it. For programs that are told to stop. Complete files stay.
pub fn abandon(end: impl FnOnce()) {
    // Locked to the end: nothing is renamed or begun after this.
    let paths = unfinished();
    for path in paths.iter() {
        // The program ends: errors cannot be reported.
        let _ = if path.is_dir() {
            std::fs::remove_dir_all(path)
        } else {
            std::fs::remove_file(path)
        };
    }
    end();
}

/// Writes a file: into a temporary file beside `path`, which is renamed when
/// `write` has succeeded. Missing folders are created. Anything but a regular
/// file at `path` is an error.
///
/// # Errors
/// [`WriteError`], or the error of `write`.
pub fn write_whole<E: From<WriteError>>(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<&File>) -> Result<(), E>,
) -> Result<(), E> {
    let failed = |source| WriteError {
        path: path.to_path_buf(),
        source,
    };
    if path.is_dir() {
        return Err(failed(io::Error::other("it is a folder; name a file in it")).into());
    }
    if path.exists() && !path.is_file() {
        let problem = "it is a pipe or a device; name a regular file";
        return Err(failed(io::Error::other(problem)).into());
    }
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    std::fs::create_dir_all(folder).map_err(failed)?;
    let mut builder = tempfile::Builder::new();
    builder.prefix(".relievo-").suffix(".part");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // Permissions of an ordinary new file; the umask is applied.
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    // Dropped after the file, which is removed unless it was renamed.
    let _registered;
    let file = {
        // Nothing is begun while the program ends.
        let mut paths = unfinished();
        let file = builder.tempfile_in(folder).map_err(failed)?;
        paths.push(file.path().to_path_buf());
        _registered = Registered(file.path().to_path_buf());
        file
    };
    let mut writer = BufWriter::new(file.as_file());
    write(&mut writer)?;
    writer.flush().map_err(failed)?;
    drop(writer);
    let _paths = unfinished();
    file.persist(path).map_err(|error| failed(error.error))?;
    Ok(())
}

/// Writes a file as [`write_whole`] does.
///
/// # Errors
/// [`WriteError`].
pub fn write_bytes(path: &Path, bytes: &[u8]) -> Result<(), WriteError> {
    write_whole(path, |file| {
        file.write_all(bytes).map_err(|source| WriteError {
            path: path.to_path_buf(),
            source,
        })
    })
}

/// Writes files into `folder`; `files` are their paths in it, with `/` between
/// the parts, and their bytes. They are written to a temporary folder, which is
/// renamed when it is complete. If `folder` exists, they are moved into it one by
/// one instead; other files in it stay.
///
/// # Errors
/// [`WriteError`].
pub fn write_folder<'a>(
    folder: &Path,
    files: impl Iterator<Item = (&'a str, &'a [u8])> + Clone,
) -> Result<(), WriteError> {
    let failed = |path: &Path| {
        let path = path.to_path_buf();
        |source| WriteError { path, source }
    };
    let refuse = |path: &Path, problem: &str| failed(path)(io::Error::other(problem));
    let is_there = folder.exists();
    if is_there && !folder.is_dir() {
        return Err(refuse(folder, "it is no folder; choose another name"));
    }
    for (name, _) in files.clone() {
        let path = folder.join(name);
        if path.exists() && !path.is_file() {
            return Err(refuse(
                &path,
                "it is a folder, a pipe or a device; choose another folder for the output",
            ));
        }
    }
    let beside = match folder.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let around = if is_there { folder } else { beside };
    std::fs::create_dir_all(around).map_err(failed(around))?;
    let mut builder = tempfile::Builder::new();
    builder.prefix(".relievo-").suffix(".part");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // Permissions of an ordinary new folder; the umask is applied.
        builder.permissions(std::fs::Permissions::from_mode(0o777));
    }
    // Dropped after the folder, which is removed unless it was renamed.
    let _registered;
    let made = {
        // Nothing is begun while the program ends.
        let mut paths = unfinished();
        let made = builder.tempdir_in(around).map_err(failed(folder))?;
        paths.push(made.path().to_path_buf());
        _registered = Registered(made.path().to_path_buf());
        made
    };
    let make_parent = |path: &Path| match path.parent() {
        Some(parent) => std::fs::create_dir_all(parent),
        None => Ok(()),
    };
    for (name, bytes) in files.clone() {
        let path = made.path().join(name);
        make_parent(&path)
            .and_then(|()| std::fs::write(&path, bytes))
            .map_err(failed(&folder.join(name)))?;
    }
    let _paths = unfinished();
    if !is_there {
        std::fs::rename(made.path(), folder).map_err(failed(folder))?;
        // Renamed: it must not be removed.
        let _ = made.keep();
        return Ok(());
    }
    for (name, _) in files {
        let path = folder.join(name);
        make_parent(&path)
            .and_then(|()| std::fs::rename(made.path().join(name), &path))
            .map_err(failed(&path))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("new/picture.png");
        let put = |bytes: &'static [u8], fail: bool| {
            write_whole(&path, |file| {
                file.write_all(bytes).unwrap();
                if fail {
                    return Err(WriteError {
                        path: path.clone(),
                        source: io::Error::other("no"),
                    });
                }
                Ok(())
            })
        };
        put(b"first", false).unwrap();
        assert!(put(b"second", true).is_err());
        assert_eq!(std::fs::read(&path).unwrap(), b"first");
        assert_eq!(
            std::fs::read_dir(path.parent().unwrap()).unwrap().count(),
            1
        );
    }

    #[test]
    fn a_folder_is_no_file() {
        let folder = tempfile::tempdir().unwrap();
        let message = write_bytes(folder.path(), b"").unwrap_err().to_string();
        assert!(message.contains("folder"), "{message}");
    }
}
