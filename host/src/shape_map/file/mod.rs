//! Baked shape maps in files: PNG or OpenEXR, by their
//! [storage](super::Storage::extension).
//!
//! The parameters for decoding are JSON in a text chunk (tEXt) of the PNG or a
//! text attribute of the OpenEXR file, with the name `relievo-shape-map`.
//!
//! ```
//! use relievo::shape_map::{Pattern, ShapeMap, Storage, bake};
//! use std::path::Path;
//!
//! let pattern = Pattern::from_fn(8, 8, |x, _| x < 4).unwrap();
//! let map = bake(&pattern, Storage::R32F, &|_| ());
//! let bytes = map.to_bytes().unwrap();
//! assert_eq!(ShapeMap::from_bytes(&bytes, Path::new("map.exr"), 64).unwrap(), map);
//! ```

mod description;
mod exr;
mod png;

use super::error::ShapeMapError;
use super::input::{Input, beginning, open, open_within};
use super::limits::DEFAULT_MAX_PIXELS;
use super::map::ShapeMap;
use super::storage::File;
use crate::file::write_whole;
use crate::{Error, Files};
use ::exr::meta::magic_number;
use std::io::{Cursor, Seek, Write};
use std::path::Path;

impl ShapeMap {
    /// Saves the map, which [`ShapeMap::load`] reads unchanged. Missing folders are
    /// created, and the file appears only when it is complete.
    ///
    /// # Errors
    /// [`ShapeMapError::WrongExtension`] for an extension that does not fit the
    /// storage; [`Error::Write`] and [`Error::Encode`] if the file cannot be
    /// written.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        let path = path.as_ref();
        self.storage().check_extension(path)?;
        write_whole(path, |output| self.write(path, output))
    }

    /// Returns the bytes of the file that [`ShapeMap::save`] writes.
    ///
    /// # Errors
    /// [`Error::Encode`].
    pub fn to_bytes(&self) -> Result<Vec<u8>, Error> {
        let mut bytes = Cursor::new(Vec::new());
        // Named in errors only.
        let path = Path::new("the shape map");
        self.write(path, &mut bytes)?;
        Ok(bytes.into_inner())
    }

    fn write(&self, path: &Path, output: impl Write + Seek) -> Result<(), Error> {
        match self.storage().form().file {
            File::Png(color, depth) => png::write(self, color, depth, path, output),
            File::Exr => exr::write(self, path, output),
        }
    }

    /// Loads a baked map of at most [`DEFAULT_MAX_PIXELS`] texels.
    ///
    /// # Errors
    /// As for [`ShapeMap::load_within`].
    pub fn load(path: impl AsRef<Path>) -> Result<Self, ShapeMapError> {
        Self::load_within(path, DEFAULT_MAX_PIXELS)
    }

    /// Loads a baked map of at most `max_pixels` texels
    /// ([`MAX_PIXELS`](super::MAX_PIXELS) at most). The format is detected from
    /// the content; the size is checked before any pixel is read.
    ///
    /// # Errors
    /// [`ShapeMapError::Read`], [`ShapeMapError::TooLarge`],
    /// [`ShapeMapError::DecodeShapeMap`] for another format or a damaged file,
    /// [`ShapeMapError::NotAShapeMap`] without a description, and
    /// [`ShapeMapError::InvalidShapeMap`] if it is invalid or does not fit the
    /// pixels.
    pub fn load_within(path: impl AsRef<Path>, max_pixels: u64) -> Result<Self, ShapeMapError> {
        Self::load_from(&Files::Disk, path.as_ref(), max_pixels)
    }

    /// Like [`ShapeMap::load_within`], from `files`.
    ///
    /// # Errors
    /// As for [`ShapeMap::load_within`].
    pub fn load_from(files: &Files, path: &Path, max_pixels: u64) -> Result<Self, ShapeMapError> {
        Self::read(&mut open_within(files, path, max_pixels)?, path, max_pixels)
    }

    /// Like [`ShapeMap::load_within`], from the bytes of a file; `path` is named in
    /// errors only.
    ///
    /// # Errors
    /// As for [`ShapeMap::load_within`].
    pub fn from_bytes(bytes: &[u8], path: &Path, max_pixels: u64) -> Result<Self, ShapeMapError> {
        Self::read(&mut Cursor::new(bytes), path, max_pixels)
    }

    fn read(input: &mut dyn Input, path: &Path, max_pixels: u64) -> Result<Self, ShapeMapError> {
        let map = if is_exr(input, path)? {
            exr::read(input, path, max_pixels)
        } else {
            png::read(input, path, max_pixels)
        }?;
        map.check_texels()
            .map_err(|reason| ShapeMapError::InvalidShapeMap {
                path: path.to_path_buf(),
                reason,
            })?;
        Ok(map)
    }

    /// Returns whether a file is a PNG or OpenEXR file with a description. The
    /// pixels are not read.
    ///
    /// # Errors
    /// A file that cannot be opened or read.
    pub fn is_shape_map(path: impl AsRef<Path>) -> Result<bool, ShapeMapError> {
        Self::is_shape_map_of(&Files::Disk, path.as_ref())
    }

    /// Like [`ShapeMap::is_shape_map`], from `files`.
    ///
    /// # Errors
    /// As for [`ShapeMap::is_shape_map`].
    pub fn is_shape_map_of(files: &Files, path: &Path) -> Result<bool, ShapeMapError> {
        let mut input = open(files, path)?;
        Ok(if is_exr(&mut input, path)? {
            exr::is_described(&mut input)
        } else {
            png::is_described(&mut input)
        })
    }
}

/// Returns whether a file starts with the signature of OpenEXR, and rewinds it.
fn is_exr(input: &mut dyn Input, path: &Path) -> Result<bool, ShapeMapError> {
    let start = beginning(input, path, magic_number::BYTES.len() as u64)?;
    Ok(start == magic_number::BYTES)
}

#[cfg(test)]
mod tests;
