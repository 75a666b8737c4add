//! Scenes as text for the fragment of a page's address.
//!
//! The text is base64url of zlib-compressed parts: the scene file, and the files that it
//! names and that pages do not have. A part is its name, a zero byte, the number of its
//! bytes (32 bits, little-endian), and its bytes.

use base64::Engine;
use base64::engine::general_purpose::URL_SAFE_NO_PAD;
use miniz_oxide::deflate::compress_to_vec_zlib;
use miniz_oxide::inflate::decompress_to_vec_zlib_with_limit;
use relievo::Files;
use relievo::files::normal;
use relievo::scene::Scene;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Start of the fragment.
const KEY: &str = "scene=";
/// Largest number of characters of a fragment: longer addresses are cut off on their way.
const LONGEST: usize = 32_000;
/// Largest number of bytes of all parts.
const LARGEST: usize = 4 << 20;
/// Effort of the compression, 0…10.
const LEVEL: u8 = 9;

/// Returns the fragment, without `#`, for `scene`. Files that are in `known` are left out.
///
/// # Errors
/// A message for the user if it is too long.
pub fn encode(scene: &Scene, known: &Files) -> Result<String, String> {
    let mut parts = Vec::new();
    append(&mut parts, "", scene.to_toml(Path::new("")).as_bytes());
    let mut carried = Vec::new();
    for path in scene.named_files() {
        let path = normal(&path);
        if known.check(&path).is_ok() || carried.iter().any(|(name, _)| *name == path) {
            continue;
        }
        let bytes = scene.files.read(&path, LARGEST as u64);
        let bytes = bytes.map_err(|error| format!("{}: {error}", path.display()))?;
        append(&mut parts, &path.to_string_lossy(), &bytes);
        carried.push((path, bytes.len()));
    }
    let packed = compress_to_vec_zlib(&parts, LEVEL);
    let fragment = format!("{KEY}{}", URL_SAFE_NO_PAD.encode(packed));
    if fragment.len() > LONGEST {
        carried.sort_by_key(|(_, length)| std::cmp::Reverse(*length));
        let files = carried.iter().map(|(path, length)| {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            format!("{name} ({length} bytes)")
        });
        let files: Vec<String> = files.collect();
        let what = match files.is_empty() {
            true => "its text".to_string(),
            false => format!("its files {}", files.join(", ")),
        };
        return Err(format!(
            "a link cannot carry this scene: it would have {} characters, and at most {LONGEST} arrive everywhere; {what} would have to be smaller; use Save scene and send the archive",
            fragment.len()
        ));
    }
    Ok(fragment)
}

/// Reads the scene of a fragment, with or without `#`; `None` if it has none. Limits, and
/// the files that are left out, are those of `known`.
///
/// # Errors
/// A message for the user.
pub fn decode(fragment: &str, known: &Scene) -> Option<Result<Scene, String>> {
    let fragment = fragment.strip_prefix('#').unwrap_or(fragment);
    let text = fragment.strip_prefix(KEY)?;
    Some(read(text, known).map_err(|problem| {
        format!("The scene in the address cannot be shown: {problem}. This is the built-in scene.")
    }))
}

fn read(text: &str, known: &Scene) -> Result<Scene, String> {
    let broken = "it is cut off or changed; copy the whole link again";
    if text.len() > LONGEST {
        return Err(format!(
            "it has {} characters, more than {LONGEST}",
            text.len()
        ));
    }
    let packed = URL_SAFE_NO_PAD.decode(text).map_err(|_| broken)?;
    let parts =
        decompress_to_vec_zlib_with_limit(&packed, LARGEST).map_err(|_| broken.to_string())?;
    let mut rest = parts.as_slice();
    let (_, scene) = take(&mut rest).ok_or(broken)?;
    let scene = std::str::from_utf8(scene).map_err(|_| broken)?;
    let mut files = match &known.files {
        Files::Memory(files) => files.as_ref().clone(),
        Files::Disk | Files::Below(_) => Default::default(),
    };
    while !rest.is_empty() {
        let (name, bytes) = take(&mut rest).ok_or(broken)?;
        files.entry(normal(&name)).or_insert(Arc::from(bytes));
    }
    let files = Files::Memory(Arc::new(files));
    Scene::parse_with(scene, Path::new("link.toml"), &known.limits, files)
        .map_err(|error| error.to_string())
}

/// Appends a part.
fn append(parts: &mut Vec<u8>, name: &str, bytes: &[u8]) {
    parts.extend(name.bytes());
    parts.push(0);
    parts.extend((bytes.len() as u32).to_le_bytes());
    parts.extend(bytes);
}

/// Takes the name and the bytes of the next part; `None` if it is not whole.
fn take<'a>(rest: &mut &'a [u8]) -> Option<(PathBuf, &'a [u8])> {
    let end = rest.iter().position(|byte| *byte == 0)?;
    let name = std::str::from_utf8(&rest[..end]).ok()?;
    let (length, after) = rest[end + 1..].split_first_chunk::<4>()?;
    let (bytes, after) = after.split_at_checked(u32::from_le_bytes(*length) as usize)?;
    *rest = after;
    Some((name.into(), bytes))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use relievo::Limits;
    use relievo::scene::{Camera, Shape};

    fn known() -> Scene {
        let files = ["meshes/a.obj", "patterns/a.png"].map(|name| (name.into(), Arc::from([7; 9])));
        let text = "[[object]]\nmesh = 'meshes/a.obj'\nshape = 'patterns/a.png'\n";
        let path = Path::new("a.toml");
        Scene::parse_with(text, path, &Limits::default(), Files::memory(files)).unwrap()
    }

    /// The known scene with a pattern of these bytes.
    fn dropped(bytes: &[u8]) -> Scene {
        let mut scene = known();
        let Files::Memory(files) = &mut scene.files else {
            panic!("they are in memory");
        };
        let name = PathBuf::from("dropped/Ä b.png");
        Arc::make_mut(files).insert(name.clone(), bytes.into());
        scene.objects[0].shape = Shape::File(name);
        scene
    }

    fn again(fragment: &str) -> Result<Scene, String> {
        decode(fragment, &known()).expect("there is a scene")
    }

    #[test]
    fn a_link_gives_back_the_scene_and_its_files() {
        let known = known();
        let mut drawn = known.clone();
        drawn.objects[0].shape = Shape::svg("<svg>\n\"é\"</svg>");
        drawn.objects[0].depth = Some(0.125);
        drawn.camera = Some(Camera::new([1.0, 2.0, 3.5], [0.0; 3]));
        for scene in [known.clone(), drawn, dropped(&[0, 1, 255])] {
            let fragment = encode(&scene, &known.files).unwrap();
            assert!(
                fragment.bytes().all(|byte| byte.is_ascii_graphic()),
                "{fragment}"
            );
            let read = again(&format!("#{fragment}")).unwrap();
            assert_eq!(read.objects, scene.objects);
            assert_eq!((read.camera, read.files), (scene.camera, scene.files));
        }
        assert!(decode("", &known).is_none() && decode("#other", &known).is_none());
    }

    #[test]
    fn what_does_not_fit_is_named() {
        let mut state = 1_u32;
        let noise: Vec<u8> = std::iter::repeat_with(|| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8
        })
        .take(40_000)
        .collect();
        let problem = encode(&dropped(&noise), &known().files).unwrap_err();
        for part in ["Ä b.png (40000 bytes)", "32000", "Save scene"] {
            assert!(problem.contains(part), "{problem}");
        }
        assert!(encode(&dropped(&noise[..20_000]), &known().files).is_ok());
    }

    #[test]
    fn a_broken_fragment_is_an_error_that_says_so() {
        let fragment = encode(&dropped(&[1, 2, 3]), &known().files).unwrap();
        for cut in KEY.len()..fragment.len() {
            let problem = again(&fragment[..cut]).unwrap_err();
            assert!(problem.contains("copy the whole link again"), "{problem}");
        }
        let other = |text: &str| {
            let mut parts = Vec::new();
            append(&mut parts, "", text.as_bytes());
            let packed = URL_SAFE_NO_PAD.encode(compress_to_vec_zlib(&parts, LEVEL));
            again(&format!("{KEY}{packed}")).unwrap_err()
        };
        let missing = other("[[object]]\nmesh = 'meshes/a.obj'\nshape = 'other.png'\n");
        assert!(missing.contains("other.png"), "{missing}");
        let wrong = other("[[object]]\nmesh = 'meshes/a.obj'\nshap = 'patterns/a.png'\n");
        assert!(wrong.contains("did you mean shape"), "{wrong}");
        let long = again(&format!("{KEY}{}", "A".repeat(LONGEST + 1))).unwrap_err();
        assert!(long.contains("more than 32000"), "{long}");
    }

    /// Whether the text after the key is an error.
    fn is_refused(packed: &str) -> bool {
        again(&format!("{KEY}{packed}")).is_err()
    }

    proptest! {
        #[test]
        fn any_text_is_an_error(
            text in "[A-Za-z0-9_-]{0,200}",
            bytes in prop::collection::vec(any::<u8>(), 0..60),
        ) {
            prop_assert!(is_refused(&text));
            prop_assert!(is_refused(&URL_SAFE_NO_PAD.encode(compress_to_vec_zlib(&bytes, LEVEL))));
        }
    }
}
