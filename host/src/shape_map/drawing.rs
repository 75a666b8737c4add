//! SVG drawings as patterns.

use super::error::ShapeMapError;
use super::fonts::add_built_in;
use super::input::{Input, beginning, check_size};
use super::raster::{paint, sides};
use image::RgbaImage;
use resvg::tiny_skia::Transform;
use resvg::usvg::roxmltree::{Document, ParsingOptions};
use resvg::usvg::{ImageHrefResolver, Options, Tree};
use std::io::Read;
use std::path::Path;
use std::sync::Mutex;

/// Maximum size of an SVG file, in bytes.
const LARGEST_FILE: u64 = 16 << 20;
/// Maximum number of XML nodes: elements, texts and comments.
const MOST_NODES: u32 = 400_000;
/// Maximum nesting of elements: rendering uses stack and memory for each level.
const DEEPEST: usize = 128;
/// Maximum number of bytes that entities may expand to.
const LARGEST_EXPANSION: usize = 4 << 20;

/// First bytes of SVG files. No image format starts with them.
const BEGINNINGS: [&[u8]; 4] = [b"<?xml", b"<svg", b"<!--", b"<!DOCTYPE"];

/// Returns whether a file is an SVG drawing, by its extension or its first
/// bytes, and rewinds `input`.
pub(super) fn is_drawing(input: &mut dyn Input, path: &Path) -> Result<bool, ShapeMapError> {
    if path.extension().is_some_and(|extension| {
        extension.eq_ignore_ascii_case("svg") || extension.eq_ignore_ascii_case("svgz")
    }) {
        return Ok(true);
    }
    let start = beginning(input, path, 256)?;
    let start = start.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&start);
    let start = start.trim_ascii_start();
    Ok(BEGINNINGS
        .iter()
        .any(|beginning| start.starts_with(beginning)))
}

/// Renders the SVG file in `input` on white, with `raster` pixels on its longer
/// side. `path` is named in errors only.
pub(super) fn draw(
    input: impl Read,
    path: &Path,
    raster: u32,
    max_pixels: u64,
) -> Result<RgbaImage, ShapeMapError> {
    let mut bytes = Vec::new();
    input
        .take(LARGEST_FILE + 1)
        .read_to_end(&mut bytes)
        .map_err(|source| ShapeMapError::Read {
            path: path.to_path_buf(),
            source,
        })?;
    let wrong = |problem: String| ShapeMapError::Drawing {
        path: path.to_path_buf(),
        problem,
    };
    if bytes.len() as u64 > LARGEST_FILE {
        let problem = format!("it has more than {LARGEST_FILE} bytes; simplify it");
        return Err(wrong(problem));
    }
    if bytes.starts_with(b"\x1f\x8b") {
        return Err(wrong(
            "it is compressed; unpack it, as with gunzip".to_string(),
        ));
    }
    let text = std::str::from_utf8(&bytes)
        .map_err(|_| wrong("it is not UTF-8 text; save it as UTF-8".to_string()))?;
    let tree = parse(text).map_err(wrong)?;
    let size = tree.size();
    let (width, height) = (f64::from(size.width()), f64::from(size.height()));
    let sides = sides([width, height], raster);
    check_size(path, sides[0], sides[1], max_pixels)?;
    let scale = [f64::from(sides[0]) / width, f64::from(sides[1]) / height];
    let transform = Transform::from_scale(scale[0] as f32, scale[1] as f32);
    paint(&tree, sides, transform).map_err(wrong)
}

/// Parses an SVG document. References to other files are refused.
fn parse(text: &str) -> Result<Tree, String> {
    check_entities(text)?;
    let options = ParsingOptions {
        // Drawing programs write entities.
        allow_dtd: true,
        nodes_limit: MOST_NODES,
        ..ParsingOptions::default()
    };
    let document = Document::parse_with_options(text, options)
        .map_err(|error| format!("it is not SVG ({error}); export it again"))?;
    let mut depth = 0_usize;
    let mut node = document.root();
    loop {
        if depth > DEEPEST {
            return Err(format!(
                "its elements are nested more than {DEEPEST} deep; simplify it"
            ));
        }
        // Its cost is a number in the file, without a limit.
        if node.is_element() && node.tag_name().name() == "feTurbulence" {
            return Err(
                "it has a filter of noise (feTurbulence); draw the pattern without".to_string(),
            );
        }
        node = match node.first_child() {
            Some(child) => {
                depth += 1;
                child
            }
            None => {
                let mut last = node;
                loop {
                    if let Some(next) = last.next_sibling() {
                        break next;
                    }
                    match last.parent() {
                        Some(parent) if depth > 0 => {
                            depth -= 1;
                            last = parent;
                        }
                        _ => return convert(&document),
                    }
                }
            }
        };
    }
}

/// Builds the render tree. Embedded and linked images are refused.
fn convert(document: &Document<'_>) -> Result<Tree, String> {
    let image: Mutex<Option<String>> = Mutex::new(None);
    let refuse = |name: &str| {
        if let Ok(mut image) = image.lock() {
            image.get_or_insert(name.chars().take(80).collect());
        }
        None
    };
    let mut options = Options {
        image_href_resolver: ImageHrefResolver {
            resolve_data: Box::new(|kind, _, _| refuse(kind)),
            resolve_string: Box::new(|name, _| refuse(name)),
        },
        ..Options::default()
    };
    add_built_in(options.fontdb_mut());
    let tree = Tree::from_xmltree(document, &options);
    drop(options);
    if let Some(name) = image.into_inner().ok().flatten() {
        return Err(format!(
            "it contains the image {name:?}; trace it, or give the pattern as a PNG"
        ));
    }
    tree.map_err(|error| format!("{error}; export it again, with a width and a height"))
}

/// Refuses entities that would expand to more than [`LARGEST_EXPANSION`] bytes.
fn check_entities(text: &str) -> Result<(), String> {
    let mut longest = 0;
    for declaration in text.split("<!ENTITY").skip(1) {
        let quote = declaration.find(['"', '\'']);
        let value = quote.and_then(|start| {
            let mark = &declaration[start..start + 1];
            declaration[start + 1..].split(mark).next()
        });
        let value = value.unwrap_or_default();
        if value.contains('&') {
            return Err("it has entities within entities; write them out".to_string());
        }
        longest = longest.max(value.len());
    }
    if longest.saturating_mul(text.matches('&').count()) > LARGEST_EXPANSION {
        return Err("its entities stand for too much text; write them out".to_string());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::{Pattern, PatternOptions};
    use crate::Files;
    use std::path::Path;
    use std::sync::Arc;

    fn load(name: &str, text: &str, options: &PatternOptions) -> Result<Pattern, String> {
        let files = Files::memory([(name.into(), Arc::from(text.as_bytes()))]);
        Pattern::load_from(&files, Path::new(name), options).map_err(|error| error.to_string())
    }

    fn with_raster(raster: u32) -> PatternOptions {
        PatternOptions {
            raster,
            ..PatternOptions::default()
        }
    }

    const OPEN: &str = "<svg xmlns='http://www.w3.org/2000/svg'";

    #[test]
    fn dark_areas_are_the_pattern() {
        let text = format!(
            "{OPEN} width='40mm' height='20mm' viewBox='0 0 4 2'><rect width='2' height='1'/><rect x='3' width='1' height='2' fill='#ddd'/></svg>"
        );
        // By its name, and by its content.
        for name in ["a.svg", "a.SVG", "a"] {
            let pattern = load(name, &text, &with_raster(64)).unwrap();
            assert_eq!([pattern.width(), pattern.height()], [64, 32]);
            for (x, y, is_solid) in [(5, 5, true), (31, 15, true), (33, 5, false), (5, 17, false)] {
                assert_eq!(pattern.is_solid(x, y), is_solid, "{x}, {y}");
            }
            assert!(!pattern.is_solid(60, 20));
        }
        let light = PatternOptions {
            threshold: 240,
            ..with_raster(64)
        };
        assert!(load("a.svg", &text, &light).unwrap().is_solid(60, 20));
        let default = load("a.svg", &text, &PatternOptions::default()).unwrap();
        assert_eq!(default.width(), 512);
        let inverted = PatternOptions {
            invert: true,
            ..with_raster(64)
        };
        assert!(load("a.svg", &text, &inverted).unwrap().is_solid(33, 5));
    }

    #[test]
    fn drawings_without_a_size_have_that_of_what_is_in_them() {
        for (size, sides) in [
            ("", [16, 8]),
            ("viewBox='0 0 30 10'", [16, 5]),
            ("width='1' height='100000'", [1, 16]),
            ("width='1e9' height='1e9'", [16, 16]),
        ] {
            let text = format!("{OPEN} {size}><rect width='20' height='10'/></svg>");
            let pattern = load("a.svg", &text, &with_raster(16)).unwrap();
            assert_eq!([pattern.width(), pattern.height()], sides, "{size}");
        }
    }

    #[test]
    fn letters_are_drawn_with_the_font_that_is_built_in() {
        let text = format!(
            "{OPEN} width='40' height='20'><text x='2' y='16' font-family='Arial'>Hé</text></svg>"
        );
        let pattern = load("a.svg", &text, &with_raster(64)).unwrap();
        assert!(pattern.solid().iter().filter(|solid| **solid).count() > 20);
    }

    #[test]
    fn what_is_not_drawn_is_told() {
        let whole = |content: &str| format!("{OPEN} width='4' height='2'>{content}</svg>");
        let deep = |levels: usize| whole(&("<g>".repeat(levels) + &"</g>".repeat(levels)));
        let laugh = "<!DOCTYPE svg [<!ENTITY a 'ha'><!ENTITY b '&a;&a;'>]>";
        let long = format!("<!DOCTYPE svg [<!ENTITY a \"{}\">]>", "x".repeat(100_000));
        for (text, part) in [
            (String::new(), "not SVG"),
            ("<svg".to_string(), "not SVG"),
            ("<a/>".to_string(), "export it again"),
            (
                whole("<image href='/etc/passwd' width='1' height='1'/>"),
                "/etc/passwd",
            ),
            (
                whole("<image href='x.svg' width='1' height='1'/>"),
                "as a PNG",
            ),
            (
                whole("<image href='data:image/png;base64,AAAA' width='1' height='1'/>"),
                "image/png",
            ),
            (
                whole("<filter id='f'><feTurbulence numOctaves='4000000000'/></filter>"),
                "noise",
            ),
            (deep(200), "128 deep"),
            (deep(300_000), "deep"),
            (whole(&"<g/>".repeat(500_000)), "nodes"),
            (
                format!("{laugh}{}", whole("&b;")),
                "entities within entities",
            ),
            (
                format!("{long}{}", whole(&"&a;".repeat(100))),
                "too much text",
            ),
            ("\u{1f}\u{8b}".to_string(), "not SVG"),
        ] {
            let error = load("a.svg", &text, &with_raster(16)).unwrap_err();
            let start: String = text.chars().take(100).collect();
            assert!(
                error.contains(part) && error.contains("a.svg"),
                "{start}: {error}"
            );
        }
        // What programs for drawing write.
        let plain = "<!DOCTYPE svg [<!ENTITY ns 'http://www.w3.org/2000/svg'>]><svg xmlns='&ns;' width='4' height='2'/>";
        assert!(load("a.svg", plain, &with_raster(16)).is_ok());
        assert!(load("a.svg", &deep(100), &with_raster(16)).is_ok());
        let limited = PatternOptions {
            max_pixels: 127,
            ..with_raster(16)
        };
        let error = load("a.svg", &deep(1), &limited).unwrap_err();
        assert!(error.contains("16 × 8"), "{error}");
    }

    /// Found by fuzzing: an assertion of the rasteriser, in builds that have them.
    #[test]
    fn shapes_beyond_all_bounds_are_an_error_at_most() {
        let text = format!(
            "{OPEN} width='40' height='20'><defs><clipPath id='c'><circle cx='62' r='11111111111111111111111111111111111118'/></clipPath></defs><rect width='20' height='20' clip-path='url(#c)'/></svg>"
        );
        if let Err(message) = load("far.svg", &text, &with_raster(40)) {
            for part in ["far.svg", "the rasteriser gave up", "keep its shapes near"] {
                assert!(message.contains(part), "{part:?} in {message}");
            }
        }
    }

    #[test]
    fn uses_of_uses_end() {
        let mut text =
            format!("{OPEN} width='4' height='2'><defs><g id='a0'><path d='M0 0L1 1 1 0'/></g>");
        for level in 1..40 {
            let use_ = format!("<use href='#a{}'/>", level - 1);
            text += &format!("<g id='a{level}'>{}</g>", use_.repeat(10));
        }
        text += "</defs><use href='#a39'/></svg>";
        assert!(load("a.svg", &text, &with_raster(16)).is_err());
        let loops = format!("{OPEN} width='4' height='2'><g id='a'><use href='#a'/></g></svg>");
        assert!(load("a.svg", &loops, &with_raster(16)).is_ok());
    }
}
