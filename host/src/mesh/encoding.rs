//! The encodings of OBJ files: UTF-8, UTF-16 and Latin-1.

use std::borrow::Cow;

/// Decodes the bytes of an OBJ file: UTF-16 with a byte order mark, else UTF-8,
/// else Latin-1. Returns `None` for bytes with a zero, which no text has.
///
/// Statements are ASCII. What another encoding changes is comments and names.
pub(super) fn text(bytes: &[u8]) -> Option<Cow<'_, str>> {
    let utf16 = |from_bytes: fn([u8; 2]) -> u16| {
        let units = bytes[2..].chunks_exact(2);
        let units = units.map(|unit| from_bytes([unit[0], unit[1]]));
        let characters = char::decode_utf16(units);
        characters
            .map(|character| character.unwrap_or(char::REPLACEMENT_CHARACTER))
            .collect::<String>()
    };
    let text: Cow<'_, str> = match bytes {
        [0xfe, 0xff, ..] => utf16(u16::from_be_bytes).into(),
        [0xff, 0xfe, ..] => utf16(u16::from_le_bytes).into(),
        _ => match std::str::from_utf8(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)) {
            Ok(text) => text.into(),
            Err(_) => bytes.iter().map(|byte| char::from(*byte)).collect(),
        },
    };
    (!text.contains('\0')).then_some(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "# é 𝄞\nv 0 0 1\n";

    #[test]
    fn every_encoding_is_read() {
        assert_eq!(text(TEXT.as_bytes()).unwrap(), TEXT);
        let marked = || std::iter::once(0xfeff).chain(TEXT.encode_utf16());
        let big: Vec<u8> = marked().flat_map(u16::to_be_bytes).collect();
        let little: Vec<u8> = marked().flat_map(u16::to_le_bytes).collect();
        for bytes in [&big, &little] {
            assert_eq!(text(bytes).unwrap(), TEXT);
            // Half a unit at the end, and a surrogate without its other half.
            assert_eq!(text(&bytes[..bytes.len() - 1]).unwrap(), TEXT.trim_end());
            assert!(text(&bytes[..12]).unwrap().ends_with('\u{fffd}'));
        }
        assert_eq!(text(b"# \xe9\nv 0 0 1\n").unwrap(), "# é\nv 0 0 1\n");
        assert_eq!(text(b"").unwrap(), "");
        assert_eq!(text(b"\xff\xfe").unwrap(), "");
    }

    #[test]
    fn bytes_that_are_no_text_are_refused() {
        assert_eq!(text(b"\x89PNG\r\n\0\0"), None);
        assert_eq!(text(b"\xff\xfev\0\0\0"), None);
    }
}
