//! The contents of buffers and pictures: in the binary chunk, as data URLs, or in other files.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::Path;

use data_url::DataUrl;
use gltf::Document;
use gltf::buffer::{Source, View};

use super::meshopt::CompressedView;
use super::problem::{BufferError, Problem};
use crate::Files;

/// The contents of the buffers that are used.
pub(super) struct Buffers<'a> {
    contents: Vec<Option<Cow<'a, [u8]>>>,
    /// Those of compressed views, by index.
    decoded: BTreeMap<usize, Vec<u8>>,
    /// How many bytes more may be read or decoded.
    pub left: u64,
}

impl<'a> Buffers<'a> {
    /// Reads the buffers that `views` show, and decodes compressed views: at most `limit` bytes in
    /// total.
    pub fn load<'v>(
        document: &Document,
        views: impl Iterator<Item = View<'v>>,
        files: &'a Files,
        path: &Path,
        blob: Option<&'a [u8]>,
        mut limit: u64,
    ) -> Result<Buffers<'a>, BufferError> {
        let mut is_read = vec![false; document.buffers().len()];
        let mut compressed = BTreeMap::new();
        for view in views {
            let buffer = match CompressedView::of(&view)? {
                None => view.buffer().index(),
                Some(content) => {
                    let buffer = content.buffer;
                    compressed.insert(view.index(), content);
                    buffer
                }
            };
            let is_read = is_read.get_mut(buffer);
            *is_read.ok_or_else(|| format!("has no buffer {buffer}; export it again"))? = true;
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
                Source::Uri(uri) => content(files, path, uri, Kind::Buffer(index), limit)?,
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
        let mut decoded = BTreeMap::new();
        for (index, view) in compressed {
            let content = contents[view.buffer].as_deref().unwrap_or_default();
            let content = view.decode(content, limit)?;
            limit -= content.len() as u64;
            decoded.insert(index, content);
        }
        Ok(Buffers {
            contents,
            decoded,
            left: limit,
        })
    }

    /// Returns the bytes of a view.
    pub fn view(&self, view: &View<'_>) -> Result<&[u8], Problem> {
        if let Some(content) = self.decoded.get(&view.index()) {
            return Ok(content);
        }
        let content = self.contents.get(view.buffer().index());
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

/// What an address leads to.
#[derive(Clone, Copy)]
pub(super) enum Kind {
    /// The buffer of this number.
    Buffer(usize),
    /// The image of this number.
    Image(usize),
}

impl Kind {
    fn noun(self) -> &'static str {
        match self {
            Kind::Buffer(_) => "buffer",
            Kind::Image(_) => "image",
        }
    }
}

/// Returns what `uri` leads to: a data URL, or a file beside the one at `path`.
pub(super) fn content<'a>(
    files: &'a Files,
    path: &Path,
    uri: &str,
    kind: Kind,
    limit: u64,
) -> Result<Cow<'a, [u8]>, BufferError> {
    let start = uri.get(..5);
    match start.is_some_and(|start| start.eq_ignore_ascii_case("data:")) {
        true => inline(uri, kind, limit).map(Cow::Owned),
        false => external(files, path, uri, kind, limit),
    }
}

/// Decodes a data URL.
fn inline(uri: &str, kind: Kind, limit: u64) -> Result<Vec<u8>, BufferError> {
    let damaged = || {
        let (Kind::Buffer(index) | Kind::Image(index)) = kind;
        let noun = kind.noun();
        Problem(format!("{noun} {index} is damaged base64; export it again"))
    };
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

/// Reads a file of its own.
fn external<'a>(
    files: &'a Files,
    path: &Path,
    uri: &str,
    kind: Kind,
    limit: u64,
) -> Result<Cow<'a, [u8]>, BufferError> {
    let has_scheme = uri
        .split_once(':')
        .is_some_and(|(scheme, _)| !scheme.contains('/'));
    let noun = kind.noun();
    let name = decoded(uri).filter(|name| !has_scheme && !name.is_empty());
    let name = name.ok_or_else(|| {
        let shown: String = uri.chars().take(80).collect();
        format!("its {noun} {shown:?} is not a file name; export the mesh with its {noun}s beside it or in it")
    })?;
    let file = path.parent().unwrap_or(Path::new("")).join(name);
    files
        .check(&file)
        .map_err(|problem| format!("its {noun} {problem}"))?;
    files.read(&file, limit).map_err(|source| {
        if source.kind() == ErrorKind::FileTooLarge {
            return BufferError::TooLarge;
        }
        let file = file.display();
        format!("cannot read its {noun} `{file}`: {source}; put it there, or export the mesh as .glb, which is one file")
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
