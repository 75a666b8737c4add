//! Reading regular files only, and writing files and folders whole or not at all.

use crate::Error;
use crate::files::too_large;
use std::fs::File;
use std::io::{BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Opens `path` for reading. Anything but a regular file is an error: a pipe or
/// a device might never end, or never begin.
///
/// # Errors
/// What the system says, or that `path` is no regular file.
pub fn open_regular(path: &Path) -> std::io::Result<File> {
    // Asked first: it is opening that waits for a pipe's other end.
    if std::fs::metadata(path)?.is_file() {
        File::open(path)
    } else {
        Err(std::io::Error::other(
            "it is a folder, a pipe or a device; name a regular file",
        ))
    }
}

/// Reads a regular file of at most `limit` bytes.
///
/// # Errors
/// As [`open_regular`]; [`std::io::ErrorKind::FileTooLarge`] before a larger file is read.
pub fn read_regular(path: &Path, limit: u64) -> std::io::Result<Vec<u8>> {
    let file = open_regular(path)?;
    let length = file.metadata()?.len();
    let mut bytes = Vec::new();
    if length <= limit {
        bytes.try_reserve_exact(length as usize)?;
        // It may grow while it is read.
        file.take(limit.saturating_add(1)).read_to_end(&mut bytes)?;
    }
    if length.max(bytes.len() as u64) > limit {
        return Err(too_large(limit));
    }
    Ok(bytes)
}

/// The temporary files and folders that are being written.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn unfinished() -> MutexGuard<'static, Vec<PathBuf>> {
    // A list of paths is whole whoever panicked.
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Stands for a temporary file or folder in [`UNFINISHED`].
struct Registered(PathBuf);

impl Drop for Registered {
    fn drop(&mut self) {
        unfinished().retain(|path| *path != self.0);
    }
}

/// Removes the temporary files and folders of this process and then calls `end`, which ends
/// it: for a program that is told to stop. Files that are complete stay.
pub fn abandon(end: impl FnOnce()) {
    // Held to the end: nothing is renamed or begun after this.
    let paths = unfinished();
    for path in paths.iter() {
        // There is nobody left to tell.
        let _ = if path.is_dir() {
            std::fs::remove_dir_all(path)
        } else {
            std::fs::remove_file(path)
        };
    }
    end();
}

/// Writes `path` by way of a temporary file beside it, renamed when `write`
/// has succeeded. Folders that are missing are made. Anything but a regular
/// file that is there already is an error: it would be replaced.
///
/// # Errors
/// [`Error::Write`], or what `write` returns.
pub fn write_whole(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<&std::fs::File>) -> Result<(), Error>,
) -> Result<(), Error> {
    let failed = |source| Error::Write {
        path: path.to_path_buf(),
        source,
    };
    if path.is_dir() {
        return Err(failed(std::io::Error::other(
            "it is a folder; name a file in it",
        )));
    }
    if path.exists() && !path.is_file() {
        return Err(failed(std::io::Error::other(
            "it is a pipe or a device; name a regular file",
        )));
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
        // As an ordinary new file; the umask is applied to it.
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    // Dropped after the file, which is removed if it was not renamed.
    let _registered;
    let file = {
        // Not begun while the program ends.
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

/// Writes `bytes` to `path`, as [`write_whole`] does.
///
/// # Errors
/// [`Error::Write`].
pub fn write_bytes(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    write_whole(path, |file| {
        file.write_all(bytes).map_err(|source| Error::Write {
            path: path.to_path_buf(),
            source,
        })
    })
}

/// Writes files into `folder`, each with its place there (with `/` between the
/// parts): into a temporary folder first, which is renamed when it is complete.
/// Where `folder` is there already, they are moved into it one by one then, in
/// place of files of the same names, and what else it holds stays.
///
/// # Errors
/// [`Error::Write`].
pub fn write_folder<'a>(
    folder: &Path,
    files: impl Iterator<Item = (&'a str, &'a [u8])> + Clone,
) -> Result<(), Error> {
    let failed = |path: &Path| {
        let path = path.to_path_buf();
        |source| Error::Write { path, source }
    };
    let refuse = |path: &Path, problem: &str| failed(path)(std::io::Error::other(problem));
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
        // As an ordinary new folder; the umask is applied to it.
        builder.permissions(std::fs::Permissions::from_mode(0o777));
    }
    // Dropped after the folder, which is removed if it was not renamed.
    let _registered;
    let made = {
        // Not begun while the program ends.
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
        // It has another name now, and is not to be removed.
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
                    return Err(Error::Encode {
                        path: path.clone(),
                        message: "no".into(),
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
        let message = write_whole(folder.path(), |_| Ok(()))
            .unwrap_err()
            .to_string();
        assert!(message.contains("folder"), "{message}");
    }
}
