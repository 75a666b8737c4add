//! Writing files whole or not at all.

use crate::Error;
use std::io::{BufWriter, Write};
use std::path::Path;

/// Writes `path` by way of a temporary file beside it, renamed when `write`
/// has succeeded. Folders that are missing are made.
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
    let file = builder.tempfile_in(folder).map_err(failed)?;
    let mut writer = BufWriter::new(file.as_file());
    write(&mut writer)?;
    writer.flush().map_err(failed)?;
    drop(writer);
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
