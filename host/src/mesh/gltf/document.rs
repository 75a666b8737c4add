//! The JSON description and the binary chunk of a file.

use std::path::Path;

use gltf::json::Root;
use gltf::json::validation::{Checked, Error as Fault, Validate};
use gltf::{Document, Semantic};

use super::super::error::MeshError;
use super::problem::Problem;
use super::{draco, meshopt};

/// First bytes of a binary file.
pub(super) const MAGIC: &[u8] = b"glTF";

/// Name prefixes of extensions that do not affect positions, or that need no
/// special treatment.
const HARMLESS: [&str; 8] = [
    "KHR_materials_",
    "KHR_texture_",
    "KHR_lights_",
    "KHR_animation_",
    "KHR_xmp",
    "KHR_mesh_quantization",
    "EXT_texture_",
    "MSFT_texture_",
];

/// Bytes that an object of the JSON description may take in memory. Files with
/// more objects than the byte limit allows are refused before parsing.
const OBJECT_BYTES: u64 = 512;

/// Bytes of objects that are always allowed.
const FREE: u64 = 1 << 20;

/// Bytes in memory that the caller counts for each byte of a file.
const COUNTED: u64 = 4;

/// Returns the description and the binary chunk of the file at `path`.
///
/// # Errors
///
/// [`MeshError::Invalid`] and [`MeshError::TooLarge`].
pub(super) fn open<'a>(
    bytes: &'a [u8],
    path: &Path,
    byte_limit: u64,
) -> Result<(Document, Option<&'a [u8]>), MeshError> {
    let failure = |Problem(problem)| MeshError::Invalid {
        path: path.to_owned(),
        problem,
    };
    let (json, blob) = split(bytes).map_err(failure)?;
    let objects = json.iter().filter(|byte| **byte == b'{').count() as u64;
    if objects.saturating_mul(OBJECT_BYTES) / COUNTED > byte_limit.max(FREE) {
        return Err(MeshError::TooLarge {
            path: path.to_owned(),
            limit: byte_limit,
        });
    }
    Ok((document(json).map_err(failure)?, blob))
}

/// Splits a file into the JSON description and the binary chunk.
fn split(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), Problem> {
    let Some(rest) = bytes.strip_prefix(MAGIC) else {
        return Ok((bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes), None));
    };
    let cut = || Problem::from("is cut off or damaged; export it again as glTF 2.0");
    let word = |at: usize| -> Result<u32, Problem> {
        let word = rest.get(at..at + 4).and_then(|word| word.try_into().ok());
        word.map(u32::from_le_bytes).ok_or_else(cut)
    };
    let version = word(0)?;
    if version != 2 {
        return Err(format!("is binary glTF {version}; export it again as glTF 2.0").into());
    }
    let mut chunks = rest.get(8..).ok_or_else(cut)?;
    let mut chunk = |wanted: &[u8]| -> Result<Option<&[u8]>, Problem> {
        if chunks.len() < 8 {
            return Ok(None);
        }
        let (header, body) = chunks.split_at(8);
        let length = u32::from_le_bytes([header[0], header[1], header[2], header[3]]);
        let content = body.get(..length as usize).ok_or_else(cut)?;
        if header[4..] != *wanted {
            return Ok(None);
        }
        chunks = &body[content.len()..];
        Ok(Some(content))
    };
    let json = chunk(b"JSON")?.ok_or_else(cut)?;
    Ok((json, chunk(b"BIN\0")?))
}

/// Parses the description and checks what the `gltf` crate relies on.
fn document(json: &[u8]) -> Result<Document, Problem> {
    let mut root = Root::from_slice(json)
        .map_err(|error| format!("is not a glTF 2.0 file ({error}); export it again"))?;
    let is_decoded = |name: &str| name == draco::NAME || meshopt::NAMES.contains(&name);
    if let Some(name) = root
        .extensions_required
        .iter()
        .find(|name| !is_decoded(name) && !HARMLESS.iter().any(|it| name.starts_with(it)))
    {
        return Err(format!(
            "needs the extension {name:?}, with which it cannot be read; export it without"
        )
        .into());
    }
    // The remaining ones do not affect positions, or are decoded.
    root.extensions_required.clear();
    // The crate's validation assumes that these are in range.
    let positions = Checked::Valid(Semantic::Positions);
    let primitives = root.meshes.iter().flat_map(|mesh| &mesh.primitives);
    for index in primitives.filter_map(|primitive| primitive.attributes.get(&positions)) {
        if index.value() >= root.accessors.len() {
            let problem = format!(
                "uses accessor {}, but has {}; export it again",
                index.value(),
                root.accessors.len()
            );
            return Err(problem.into());
        }
    }
    let mut first = None;
    root.validate(&root, gltf::json::Path::new, &mut |place, fault| {
        let place = place().to_string();
        // Bounds of positions are not used, and accessors without a view are zeros.
        let may_miss = [".min", ".max", ".bufferView"];
        let may_miss = may_miss.iter().any(|end| place.ends_with(end));
        if !(may_miss && fault == Fault::Missing) {
            first.get_or_insert((place, fault));
        }
    });
    match first {
        None => Ok(Document::from_json_without_validation(root)),
        Some((place, fault)) => Err(format!(
            "is not valid glTF: {place}: {fault}; repair it, or export it again"
        )
        .into()),
    }
}
