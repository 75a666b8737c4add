//! The shape map as a texture, for engines that read textures rather than buffers in fragment
//! shaders.

/// How shaders read the shape map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MapForm {
    /// As a storage buffer of 32-bit words.
    #[default]
    Buffer,
    /// As a 2D texture of the format r32uint with rows of [`MapForm::WIDTH`] words, of
    /// [`Output::Hit`](super::Output::Hit) only.
    Texture,
}

/// log₂ of [`MapForm::WIDTH`].
const SHIFT: u32 = 12;

impl MapForm {
    /// Width of a texture, texels: every device of WebGPU and Vulkan takes it.
    pub const WIDTH: u32 = 1 << SHIFT;
    /// Largest height that every device of WebGPU takes.
    const HIGHEST: usize = 8192;

    /// Returns the name for programs.
    pub(super) fn name(self) -> &'static str {
        match self {
            MapForm::Buffer => "read-only-storage",
            MapForm::Texture => "texture",
        }
    }

    /// Returns the height of the texture with so many words.
    pub(super) fn height(words: usize) -> usize {
        words.div_ceil(MapForm::WIDTH as usize)
    }

    /// Returns whether a map of so many words fits.
    pub(super) fn takes(self, words: usize) -> bool {
        self == MapForm::Buffer || MapForm::height(words) <= MapForm::HIGHEST
    }

    /// Returns the bytes of the words of a map: of a texture whole rows, the last one filled with
    /// zeros.
    pub(super) fn bytes(self, words: &[u32]) -> Vec<u8> {
        let mut bytes = bytemuck::cast_slice(words).to_vec();
        if self == MapForm::Texture {
            bytes.resize(
                MapForm::height(words.len()) * 4 * MapForm::WIDTH as usize,
                0,
            );
        }
        bytes
    }
}

/// Names in shaders.
pub(super) struct Names {
    /// Of the map.
    pub(super) map: String,
    /// Of the type of its buffer.
    pub(super) data: String,
    /// Of the function that reads a word of a texture.
    pub(super) word: String,
}

/// Returns the WGSL `text` with the map as a texture in place of a buffer.
///
/// # Errors
/// A message if it reads the map in another way than word by word.
pub(super) fn as_texture(text: &str, names: &Names) -> Result<String, String> {
    let Names { map, data, word } = names;
    let unknown = || "its shape map is declared in another way".to_string();
    // The type of the buffer is of no other use.
    let (before, rest) = text
        .split_once(&format!("struct {data} {{"))
        .ok_or_else(unknown)?;
    let (_, after) = rest.split_once("}\n\n").ok_or_else(unknown)?;
    let text = format!("{before}{after}");
    let declared = format!("var<storage> {map}: {data};");
    let (before, after) = text.split_once(&declared).ok_or_else(unknown)?;
    let last = MapForm::WIDTH - 1;
    let function = format!(
        "\n\n// Returns word `index` of the shape map.\nfn {word}(index: u32) -> u32 {{\n    return textureLoad({map}, vec2<u32>(index & {last}u, index >> {SHIFT}u), 0).x;\n}}"
    );
    let after = with_calls(after, &format!("{map}.at["), &format!("{word}("))
        .filter(|after| !after.contains(&format!("{map}.")) && !after.contains(data.as_str()))
        .ok_or("it reads its shape map in another way")?;
    Ok(format!(
        "{before}var {map}: texture_2d<u32>;{function}{after}"
    ))
}

/// Returns `text` with calls that start with `call` in place of indices that start with `index`;
/// none if brackets do not match.
fn with_calls(text: &str, index: &str, call: &str) -> Option<String> {
    let mut found = String::new();
    // Indices within an index are behind its start.
    let mut open = Vec::new();
    let mut depth = 0;
    let mut rest = text;
    while let Some(next) = rest.chars().next() {
        if let Some(inside) = rest.strip_prefix(index) {
            found += call;
            open.push(depth);
            depth += 1;
            rest = inside;
            continue;
        }
        match next {
            '[' => depth += 1,
            ']' => {
                depth -= 1;
                if open.last() == Some(&depth) {
                    open.pop();
                    found.push(')');
                    rest = &rest[1..];
                    continue;
                }
            }
            _ => (),
        }
        found.push(next);
        rest = &rest[next.len_utf8()..];
    }
    open.is_empty().then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_become_calls() {
        let calls = |text| with_calls(text, "map.at[", "word(");
        let cases = [
            ("a[map.at[(i >> 2u)]] + b[1]", "a[word((i >> 2u))] + b[1]"),
            ("map.at[c[map.at[d[0]]]]", "word(c[word(d[0])])"),
            ("other.at[1]", "other.at[1]"),
        ];
        for (text, wanted) in cases {
            assert_eq!(calls(text).as_deref(), Some(wanted));
        }
        assert_eq!(calls("map.at[1"), None);
    }

    #[test]
    fn textures_have_whole_rows() {
        let words: Vec<u32> = (0..MapForm::WIDTH + 1).collect();
        let bytes = MapForm::Texture.bytes(&words);
        assert_eq!(bytes.len(), 2 * 4 * MapForm::WIDTH as usize);
        assert_eq!(bytes[..4 * words.len()], MapForm::Buffer.bytes(&words));
        assert!(MapForm::Texture.takes(1 << 25) && !MapForm::Texture.takes((1 << 25) + 1));
        assert!(MapForm::Buffer.takes(usize::MAX));
    }

    #[test]
    fn what_is_no_map_is_refused() {
        let names = Names {
            map: "map".to_string(),
            data: "Words".to_string(),
            word: "word".to_string(),
        };
        let with = |rest: &str| as_texture(&format!("struct Words {{\n}}\n\n{rest}"), &names);
        assert!(as_texture("", &names).is_err());
        assert!(with("var<storage> map: Other;").is_err());
        assert!(with("var<storage> map: Words;\nfn f() { g(map.at); }").is_err());
        assert!(with("var<storage> map: Words;\nfn f() { g(map.at[0]); }").is_ok());
    }
}
