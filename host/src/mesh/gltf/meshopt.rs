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
    /// Index of the view.
    index: usize,
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
        let mut values = NAMES.iter().filter_map(|name| view.extension_value(name));
        let Some(object) = values.next() else {
            return Ok(None);
        };
        let index = view.index();
        let found = CompressedView::read(object, index);
        found
            .map(Some)
            .map_err(|Problem(problem)| located(index, &problem))
    }

    /// Returns what the extension's `object` says of view `index`.
    fn read(object: &Value, index: usize) -> Result<CompressedView, Problem> {
        let wanted = |key| -> Result<usize, Problem> {
            Ok(whole_number(object, key)?.ok_or_else(|| format!("{key} is missing"))?)
        };
        let text = |key, default| match object.get(key) {
            None => Ok(default),
            Some(value) => value
                .as_str()
                .ok_or_else(|| format!("{key} is {value}, no text")),
        };
        let mode = MeshoptMode::from_name(text("mode", "")?);
        let filter = MeshoptFilter::from_name(text("filter", "NONE")?);
        Ok(CompressedView {
            buffer: wanted("buffer")?,
            index,
            offset: whole_number(object, "byteOffset")?.unwrap_or(0),
            length: wanted("byteLength")?,
            stride: wanted("byteStride")?,
            count: wanted("count")?,
            mode: mode.map_err(|error| error.to_string())?,
            filter: filter.map_err(|error| error.to_string())?,
        })
    }

    /// Returns the content of the view, whose buffer is `buffer`, if it has at most `limit` bytes.
    pub fn decode(&self, buffer: &[u8], limit: u64) -> Result<Vec<u8>, BufferError> {
        let end = self.offset.checked_add(self.length);
        let source = end.and_then(|end| buffer.get(self.offset..end));
        let source = source.ok_or_else(|| located(self.index, "it extends beyond its buffer"))?;
        let size = self.count.saturating_mul(self.stride);
        if size as u64 > limit {
            return Err(BufferError::TooLarge);
        }
        let mut content = vec![0; size];
        let Self { mode, filter, .. } = *self;
        decode_buffer_view(&mut content, source, mode, filter, self.count, self.stride).map_err(
            |error| located(self.index, &format!("it cannot be decompressed ({error})")),
        )?;
        Ok(content)
    }
}

/// Returns the problem of compressed view `index`.
fn located(index: usize, problem: &str) -> Problem {
    format!("compressed buffer view {index}: {problem}; export it again").into()
}
