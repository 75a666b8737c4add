//! Loads meshes: from a file, bytes, text, or data made in code.

use std::borrow::Cow;
use std::io::ErrorKind;
use std::path::Path;

use super::bounds::Bounds;
use super::data::MeshData;
use super::error::MeshError;
use super::material::{MeshMaterial, MeshMaterials};
use super::options::MeshOptions;
use super::prepare;
use super::raw::RawMesh;
use super::source::MeshSource;
use super::triangles::Mesh;
use super::{encoding, gltf, mtl, obj};
use crate::Files;

impl Mesh {
    /// Loads the Wavefront OBJ or glTF 2.0 file at `path` and prepares it. The
    /// format is detected from the content, else from the extension. Objects,
    /// groups and the nodes of glTF's default scene are merged, or those with the
    /// materials in [`MeshOptions::parts`].
    ///
    /// # Errors
    ///
    /// Any [`MeshError`].
    pub fn load(path: &Path, options: &MeshOptions) -> Result<Self, MeshError> {
        let source = read(&Files::Disk, path, options)?;
        prepare::prepare(&source, path, options)
    }

    /// Prepares a mesh made in code.
    ///
    /// # Errors
    ///
    /// Any [`MeshError`] but those of reading a file.
    pub fn from_data(data: &MeshData, options: &MeshOptions) -> Result<Self, MeshError> {
        let source = data.source(options)?;
        prepare::prepare(&source, Path::new(&data.name), options)
    }

    /// Loads `source` from `files` and prepares it if `is_wanted` accepts its
    /// bounding box; returns the bounding box alone otherwise.
    ///
    /// # Errors
    ///
    /// Any [`MeshError`].
    pub fn load_if(
        files: &Files,
        source: &MeshSource,
        options: &MeshOptions,
        is_wanted: &dyn Fn(&Bounds) -> bool,
    ) -> Result<Result<Self, Bounds>, MeshError> {
        let (path, source) = match source {
            MeshSource::File(path) => (path.as_path(), read(files, path, options)?),
            MeshSource::Data(data) => (Path::new(&data.name), data.source(options)?),
        };
        let bounds = prepare::bounds(&source, path, options)?;
        // How far a raised surface reaches is not known before.
        if options.raise > 0.0 || is_wanted(&bounds) {
            prepare::prepare(&source, path, options).map(Ok)
        } else {
            Ok(Err(bounds))
        }
    }

    /// Prepares a mesh from the bytes of an OBJ or glTF file. `path` is named
    /// in errors and its extension is used as in [`Mesh::load`]; further files
    /// that a glTF file names are read from `files`.
    ///
    /// # Errors
    ///
    /// Any [`MeshError`] but those of reading the file.
    pub fn from_bytes(
        files: &Files,
        bytes: &[u8],
        path: &Path,
        options: &MeshOptions,
    ) -> Result<Self, MeshError> {
        let source = decode(files, bytes, path, options)?;
        prepare::prepare(&source, path, options)
    }

    /// Prepares a mesh from the text of an OBJ file; `path` is named in errors
    /// only.
    ///
    /// # Errors
    ///
    /// Any [`MeshError`] but those of reading the file.
    ///
    /// # Examples
    ///
    /// ```
    /// use relievo::mesh::{Mesh, MeshOptions, Projection};
    /// use std::path::Path;
    ///
    /// let options = MeshOptions {
    ///     projection: Some(Projection::PlanarZ),
    ///     ..MeshOptions::default()
    /// };
    /// let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    /// let mesh = Mesh::parse(text, Path::new("triangle.obj"), &options)?;
    /// assert_eq!(mesh.triangles[0].corners[1].uv.to_array(), [1.0, 0.0]);
    /// # Ok::<(), relievo::mesh::MeshError>(())
    /// ```
    pub fn parse(text: &str, path: &Path, options: &MeshOptions) -> Result<Self, MeshError> {
        let source = obj::parse(text, path, options)?;
        prepare::prepare(&source, path, options)
    }
}

impl MeshMaterials {
    /// Reads the materials of `source` from `files`, with their pictures at most `byte_limit`
    /// bytes. None if its triangles have no materials.
    ///
    /// # Errors
    ///
    /// Any [`MeshError`] of a file that cannot be read. A picture that cannot be read is one of
    /// the [`problems`](Self::problems).
    pub fn load(
        files: &Files,
        source: &MeshSource,
        byte_limit: u64,
    ) -> Result<MeshMaterials, MeshError> {
        let MeshSource::File(path) = source else {
            return Ok(MeshMaterials::default());
        };
        let bytes = read_bytes(files, path, byte_limit)?;
        let mut found = match Format::of(&bytes, path)? {
            Format::Gltf => gltf::materials(files, &bytes, path, byte_limit),
            Format::Obj(text) => mtl::materials(files, &text, path, byte_limit),
        }?;
        found.materials.iter_mut().for_each(MeshMaterial::limit);
        Ok(found)
    }
}

/// Reads the OBJ or glTF file at `path`.
///
/// # Errors
///
/// Those of [`read_bytes`] and [`decode`].
fn read(files: &Files, path: &Path, options: &MeshOptions) -> Result<RawMesh, MeshError> {
    let bytes = read_bytes(files, path, options.byte_limit)?;
    decode(files, &bytes, path, options)
}

/// Reads the bytes of the file at `path`, at most `limit`.
///
/// # Errors
///
/// [`MeshError::Read`], [`MeshError::IsDirectory`] and [`MeshError::TooLarge`].
fn read_bytes<'a>(files: &'a Files, path: &Path, limit: u64) -> Result<Cow<'a, [u8]>, MeshError> {
    if files.is_folder(path) {
        return Err(MeshError::IsDirectory {
            path: path.to_owned(),
        });
    }
    files.read(path, limit).map_err(|source| {
        let path = path.to_owned();
        if source.kind() == ErrorKind::FileTooLarge {
            MeshError::TooLarge { path, limit }
        } else {
            MeshError::Read { path, source }
        }
    })
}

/// The format of a mesh file.
enum Format<'a> {
    /// glTF 2.0, text or binary.
    Gltf,
    /// Wavefront OBJ, with its text.
    Obj(Cow<'a, str>),
}

impl Format<'_> {
    /// Returns the format of a file, by its bytes or its extension.
    ///
    /// # Errors
    ///
    /// [`MeshError::NotText`].
    fn of<'a>(bytes: &'a [u8], path: &Path) -> Result<Format<'a>, MeshError> {
        if gltf::is_gltf(bytes, path) {
            return Ok(Format::Gltf);
        }
        let text = encoding::text(bytes).ok_or_else(|| MeshError::NotText {
            path: path.to_owned(),
        })?;
        Ok(Format::Obj(text))
    }
}

/// Parses the bytes of an OBJ or glTF file.
///
/// # Errors
///
/// Those of [`Format::of`], [`obj::parse`] and [`gltf::parse`].
fn decode(
    files: &Files,
    bytes: &[u8],
    path: &Path,
    options: &MeshOptions,
) -> Result<RawMesh, MeshError> {
    match Format::of(bytes, path)? {
        Format::Gltf => gltf::parse(files, bytes, path, options),
        Format::Obj(text) => obj::parse(&text, path, options),
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn errors_name_the_unreadable_file() {
        let folder = tempfile::tempdir().unwrap();
        let read = |path: &Path, byte_limit| {
            let options = MeshOptions {
                byte_limit,
                ..MeshOptions::default()
            };
            super::read(&Files::Disk, path, &options)
        };
        let error = |path: &Path| read(path, 1000).expect_err("unreadable");
        assert!(matches!(
            error(folder.path()),
            MeshError::IsDirectory { .. }
        ));
        let missing = error(&folder.path().join("missing.obj"));
        assert!(
            matches!(missing, MeshError::Read { .. })
                && missing.to_string().contains("missing.obj")
        );
        let binary = folder.path().join("binary.obj");
        fs::write(&binary, b"v 0 0 0\n\0\n").unwrap();
        assert!(matches!(error(&binary), MeshError::NotText { .. }));
        let good = folder.path().join("good.obj");
        fs::write(&good, "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n").unwrap();
        let length = fs::metadata(&good).unwrap().len();
        assert_eq!(read(&good, length).unwrap().triangles.len(), 1);
        let error = read(&good, length - 1).unwrap_err();
        assert!(matches!(error, MeshError::TooLarge { .. }), "{error}");
        assert!(error.to_string().contains("good.obj"), "{error}");
    }
}
