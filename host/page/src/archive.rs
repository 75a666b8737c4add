//! ZIP archives for downloads.

use relievo::export::ExportedFile;
use std::io::{Cursor, Write};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// Returns a ZIP archive with a folder of these files, uncompressed.
pub fn pack(folder: &str, files: &[ExportedFile]) -> Result<Vec<u8>, String> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
    for file in files {
        archive
            .start_file(format!("{folder}/{}", file.name), options)
            .map_err(|error| error.to_string())?;
        archive
            .write_all(&file.bytes)
            .map_err(|error| error.to_string())?;
    }
    let packed = archive.finish().map_err(|error| error.to_string())?;
    Ok(packed.into_inner())
}
