//! Buffer views with EXT_meshopt_compression or KHR_meshopt_compression, which `draco-gltf`
//! decodes.

use draco_gltf::meshopt::decode_buffer_view;
use draco_gltf::{MeshoptFilter, MeshoptMode};
use gltf::buffer::View;
use gltf::json::Value;

use super::problem::{BufferError, Problem, whole_number};

/// Names of the extension.
pub(super) const NAMES: [&str; 2] = ["KHR_meshopt_compression", "EXT_meshopt_compression"];

/// Where the compressed content of a buffer view lies, and how it is decoded.
pub(super) struct CompressedView {
    /// Index of the buffer.
    pub buffer: usize,
    offset: usize,
    length: usize,
    stride: usize,
    count: usize,
    mode: MeshoptMode,
    filter: MeshoptFilter,
}

impl CompressedView {
    /// Returns that of `view`; `None` if it is not compressed.
    pub fn of(view: &View<'_>) -> Result<Option<CompressedView>, Problem> {
        let values = NAMES.iter().map(|name| (name, view.extension_value(name)));
        let Some((name, object)) = values
            .filter_map(|(name, value)| Some((name, value?)))
            .next()
        else {
            return Ok(None);
        };
        let index = view.index();
        let problem =
            |what: String| format!("buffer view {index}, {name}: {what}; export it again");
        let wanted = |key| {
            whole_number(object, key).ok_or_else(|| problem(format!("{key} is not a whole number")))
        };
        let text = |key| object.get(key).and_then(Value::as_str);
        let mode = MeshoptMode::from_name(text("mode").unwrap_or_default());
        let filter = MeshoptFilter::from_name(text("filter").unwrap_or("NONE"));
        Ok(Some(CompressedView {
            buffer: wanted("buffer")?,
            offset: whole_number(object, "byteOffset").unwrap_or(0),
            length: wanted("byteLength")?,
            stride: wanted("byteStride")?,
            count: wanted("count")?,
            mode: mode.map_err(|error| problem(error.to_string()))?,
            filter: filter.map_err(|error| problem(error.to_string()))?,
        }))
    }

    /// Returns the content of the view, whose buffer is `buffer`, if it has at most `limit` bytes.
    pub fn decode(&self, buffer: &[u8], limit: u64) -> Result<Vec<u8>, BufferError> {
        let end = self.offset.checked_add(self.length);
        let source = end.and_then(|end| buffer.get(self.offset..end));
        let source =
            source.ok_or("a compressed buffer view extends beyond its buffer; export it again")?;
        let size = self.count.saturating_mul(self.stride);
        if size as u64 > limit {
            return Err(BufferError::TooLarge);
        }
        let mut content = vec![0; size];
        let Self { mode, filter, .. } = *self;
        decode_buffer_view(&mut content, source, mode, filter, self.count, self.stride).map_err(
            |error| format!("a buffer view cannot be decompressed ({error}); export it again"),
        )?;
        Ok(content)
    }
}
