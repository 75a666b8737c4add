//! The contents of buffers: in the binary chunk, as data URLs, or in other files.

use std::borrow::Cow;
use std::io::ErrorKind;
use std::path::Path;

use data_url::DataUrl;
use gltf::Document;
use gltf::buffer::{Source, View};

use super::parts::Part;
use super::problem::Problem;
use crate::Files;

/// The contents of the buffers that primitives use.
pub(super) struct Buffers<'a>(Vec<Option<Cow<'a, [u8]>>>);

pub(super) enum BufferError {
    Problem(Problem),
    TooLarge,
}

impl<T: Into<Problem>> From<T> for BufferError {
    fn from(problem: T) -> BufferError {
        BufferError::Problem(problem.into())
    }
}

impl<'a> Buffers<'a> {
    /// Reads the buffers of `parts`, at most `limit` bytes in total.
    pub fn load(
        document: &Document,
        parts: &[Part<'_>],
        files: &'a Files,
        path: &Path,
        blob: Option<&'a [u8]>,
        mut limit: u64,
    ) -> Result<Buffers<'a>, BufferError> {
        let mut is_read = vec![false; document.buffers().len()];
        for accessor in parts.iter().flat_map(Part::accessors) {
            let sparse = accessor.sparse();
            let sparse = sparse.map(|sparse| [sparse.indices().view(), sparse.values().view()]);
            for view in sparse.into_iter().flatten().chain(accessor.view()) {
                is_read[view.buffer().index()] = true;
            }
        }
        let mut contents = Vec::with_capacity(is_read.len());
        for (buffer, is_read) in document.buffers().zip(is_read) {
            if !is_read {
                contents.push(None);
                continue;
            }
            let index = buffer.index();
            let mut content = match buffer.source() {
                Source::Bin => Cow::Borrowed(blob.filter(|_| index == 0).ok_or_else(|| {
                    format!("buffer {index} has no content; export it with its buffers")
                })?),
                Source::Uri(uri) if is_data(uri) => Cow::Owned(inline(uri, index, limit)?),
                Source::Uri(uri) => external(files, path, uri, limit)?,
            };
            let length = buffer.length();
            if content.len() < length {
                return Err(format!(
                    "buffer {index} has {} bytes and should have {length}; export it again",
                    content.len()
                )
                .into());
            }
            match &mut content {
                Cow::Borrowed(bytes) => *bytes = &bytes[..length],
                Cow::Owned(bytes) => bytes.truncate(length),
            }
            // The binary chunk has been counted with the file.
            if !matches!(buffer.source(), Source::Bin) {
                limit = limit.saturating_sub(content.len() as u64);
            }
            contents.push(Some(content));
        }
        Ok(Buffers(contents))
    }

    /// Returns the bytes of a view.
    pub fn view(&self, view: &View<'_>) -> Result<&[u8], Problem> {
        let content = self.0.get(view.buffer().index());
        let content = content.and_then(|content| content.as_deref());
        let end = view.offset().checked_add(view.length());
        end.and_then(|end| content?.get(view.offset()..end))
            .ok_or_else(|| {
                format!(
                    "buffer view {} extends beyond its buffer; export it again",
                    view.index()
                )
                .into()
            })
    }
}

fn is_data(uri: &str) -> bool {
    uri.get(..5)
        .is_some_and(|start| start.eq_ignore_ascii_case("data:"))
}

/// Decodes the data URL of a buffer.
fn inline(uri: &str, index: usize, limit: u64) -> Result<Vec<u8>, BufferError> {
    let damaged = || Problem(format!("buffer {index} is damaged base64; export it again"));
    let url = DataUrl::process(uri).map_err(|_| damaged())?;
    let mut bytes = Vec::new();
    let mut is_too_large = false;
    let result = url.decode(|piece| {
        is_too_large = (bytes.len() + piece.len()) as u64 > limit;
        if is_too_large {
            return Err(());
        }
        bytes.extend_from_slice(piece);
        Ok(())
    });
    match result {
        _ if is_too_large => Err(BufferError::TooLarge),
        Ok(_) => Ok(bytes),
        Err(_) => Err(damaged().into()),
    }
}

/// Reads a buffer from a file of its own.
fn external<'a>(
    files: &'a Files,
    path: &Path,
    uri: &str,
    limit: u64,
) -> Result<Cow<'a, [u8]>, BufferError> {
    let has_scheme = uri
        .split_once(':')
        .is_some_and(|(scheme, _)| !scheme.contains('/'));
    let name = decoded(uri).filter(|name| !has_scheme && !name.is_empty());
    let name = name.ok_or_else(|| {
        let shown: String = uri.chars().take(80).collect();
        format!("its buffer {shown:?} is not a file name; export the mesh with its buffers beside it or in it")
    })?;
    let buffer = path.parent().unwrap_or(Path::new("")).join(name);
    files
        .check(&buffer)
        .map_err(|problem| format!("its buffer {problem}"))?;
    files.read(&buffer, limit).map_err(|source| {
        if source.kind() == ErrorKind::FileTooLarge {
            return BufferError::TooLarge;
        }
        let buffer = buffer.display();
        format!("cannot read its buffer `{buffer}`: {source}; put it there, or export the mesh as .glb, which is one file")
            .into()
    })
}

/// Decodes the percent-encoding of `uri`, if the result is UTF-8.
fn decoded(uri: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let [first, tail @ ..] = rest {
        let hex = tail.get(..2).filter(|_| *first == b'%');
        let hex = hex.and_then(|hex| std::str::from_utf8(hex).ok());
        match hex.and_then(|hex| u8::from_str_radix(hex, 16).ok()) {
            Some(byte) => {
                bytes.push(byte);
                rest = &tail[2..];
            }
            None => {
                bytes.push(*first);
                rest = tail;
            }
        }
    }
    String::from_utf8(bytes).ok()
}
