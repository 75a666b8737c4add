//! Round trips, and files that are damaged or do not fit.

use super::super::{Encoding, Pattern, PatternOptions, Storage, bake};
use super::description::{KEYWORD, parse};
use super::*;
use ::exr::meta::attribute::{AttributeValue, Text};
use ::exr::prelude::{
    AnyChannel, AnyChannels, Encoding as Compression, FlatSamples, Image, Layer, LayerAttributes,
    WritableImage, f16,
};
use ::png::{BitDepth, ColorType};
use std::fs::{self, File};
use std::path::PathBuf;

fn pattern(width: u32, height: u32) -> Pattern {
    Pattern::from_fn(width, height, |x, y| (x / 3 + y / 5) % 4 == 0).unwrap()
}

fn map(width: u32, height: u32, encoding: impl Into<Encoding>) -> ShapeMap {
    bake(&pattern(width, height), encoding, &|_| ())
}

fn name(storage: Storage) -> String {
    format!("map.{}", storage.extension())
}

/// A PNG of 2 × 2 pixels, all of whose bytes are `byte`, with `text` as its
/// description.
fn write_png(path: &Path, (color, depth): (ColorType, BitDepth), byte: u8, text: Option<&str>) {
    let mut encoder = ::png::Encoder::new(File::create(path).unwrap(), 2, 2);
    encoder.set_color(color);
    encoder.set_depth(depth);
    if let Some(text) = text {
        encoder
            .add_text_chunk(KEYWORD.to_string(), text.to_string())
            .unwrap();
    }
    let mut writer = encoder.write_header().unwrap();
    let bytes = 4 * color.samples() * depth as usize / 8;
    writer.write_image_data(&vec![byte; bytes]).unwrap();
}

/// An OpenEXR file of 2 × 2 pixels.
fn write_exr(path: &Path, channels: &[(&str, FlatSamples)], how: Compression, text: Option<&str>) {
    let mut attributes = LayerAttributes::default();
    if let Some(text) = text {
        let text = AttributeValue::Text(Text::from(text));
        attributes.other.insert(Text::from(KEYWORD), text);
    }
    let list = channels
        .iter()
        .map(|(name, samples)| AnyChannel::new(*name, samples.clone()))
        .collect();
    let layer = Layer::new((2, 2), attributes, how, AnyChannels::sort(list));
    Image::from_layer(layer).write().to_file(path).unwrap();
}

/// The reason why a file is no valid shape map.
fn reason(path: &Path) -> String {
    let error = ShapeMap::load(path).unwrap_err();
    assert!(
        matches!(error, ShapeMapError::InvalidShapeMap { .. }),
        "{error:?}"
    );
    let message = error.to_string();
    assert!(message.contains(&path.display().to_string()), "{message}");
    assert!(message.contains("bake it again"), "{message}");
    message
}

#[test]
fn round_trip() {
    let folder = tempfile::tempdir().unwrap();
    let path = |storage| folder.path().join(name(storage));
    for &storage in Storage::ALL {
        for (width, height) in [(1, 1), (7, 5), (33, 2), (1, 41), (300, 1), (64, 64)] {
            let path = path(storage);
            let map = map(width, height, storage);
            map.save(&path).unwrap();
            assert!(ShapeMap::is_shape_map(&path).unwrap());
            assert_eq!(ShapeMap::load(&path).unwrap(), map);
        }
        // Every class of patterns.
        for solid in [false, true] {
            let pattern = Pattern::from_fn(9, 7, |_, _| solid).unwrap();
            let map = bake(&pattern, storage, &|_| ());
            map.save(path(storage)).unwrap();
            assert_eq!(ShapeMap::load(path(storage)).unwrap(), map);
        }
    }
    // Nothing but the two files, saved over and over, is left.
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
}

#[test]
fn a_saturated_map_stays_so() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.png");
    let pattern = Pattern::from_fn(400, 400, |x, y| x + y == 0).unwrap();
    for encoding in [Storage::R8.into(), Encoding::rgba8(0.3).unwrap()] {
        let map = bake(&pattern, encoding, &|_| ());
        map.save(&path).unwrap();
        assert!(map.saturated());
        assert_eq!(ShapeMap::load(&path).unwrap(), map);
    }
}

#[test]
fn the_papers_form_is_a_picture_with_its_four_channels() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.png");
    let map = map(30, 20, Storage::Rgba8);
    map.save(&path).unwrap();
    let picture = image::open(&path).unwrap().into_rgba8();
    for (x, y, pixel) in picture.enumerate_pixels() {
        assert_eq!(u32::from_le_bytes(pixel.0), map.texel(x, y));
    }
    assert!(picture.pixels().any(|pixel| pixel.0[3] == 0));
    assert!(picture.pixels().any(|pixel| pixel.0[3] == 255));
}

#[test]
fn a_map_is_saved_to_the_same_bytes_each_time() {
    let folder = tempfile::tempdir().unwrap();
    for &storage in Storage::ALL {
        let path = folder.path().join(name(storage));
        let map = map(200, 150, storage);
        let bytes = [(); 3].map(|()| {
            map.save(&path).unwrap();
            fs::read(&path).unwrap()
        });
        assert!(bytes[0] == bytes[1] && bytes[0] == bytes[2], "{storage}");
    }
}

#[cfg(unix)]
#[test]
fn the_file_can_be_read_by_others() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.png");
    map(4, 4, Storage::R8).save(&path).unwrap();
    let plain = folder.path().join("plain");
    fs::write(&plain, "").unwrap();
    let mode = |path: &PathBuf| fs::metadata(path).unwrap().permissions().mode();
    assert_eq!(mode(&path), mode(&plain));
}

#[test]
fn what_cannot_be_saved() {
    let folder = tempfile::tempdir().unwrap();
    for &storage in Storage::ALL {
        let map = map(4, 4, storage);
        let other = if storage == Storage::R32F {
            "png"
        } else {
            "exr"
        };
        let error = map.save(folder.path().join("map").with_extension(other));
        assert!(matches!(
            error,
            Err(Error::ShapeMap(ShapeMapError::WrongExtension { .. }))
        ));
    }
    let path = folder.path().join("folder.png");
    fs::create_dir(&path).unwrap();
    let error = map(4, 4, Storage::R8).save(&path).unwrap_err();
    assert!(matches!(error, Error::Write { .. }));
    assert!(error.to_string().contains(&path.display().to_string()));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn plain_images_are_not_shape_maps() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plain.png");
    let gray = (ColorType::Grayscale, BitDepth::Eight);
    write_png(&path, gray, 0, None);
    let plain = folder.path().join("plain.exr");
    let ones = FlatSamples::F32(vec![1.0; 4]);
    write_exr(
        &plain,
        &[("distance", ones)],
        Compression::UNCOMPRESSED,
        None,
    );
    for path in [&path, &plain] {
        assert!(!ShapeMap::is_shape_map(path).unwrap());
        assert!(matches!(
            ShapeMap::load(path),
            Err(ShapeMapError::NotAShapeMap { .. })
        ));
    }
    assert!(Pattern::load(&path, &PatternOptions::default()).is_ok());
    for text in [&b""[..], b"no PNG", &magic_number::BYTES] {
        fs::write(&path, text).unwrap();
        assert!(!ShapeMap::is_shape_map(&path).unwrap());
        assert!(matches!(
            ShapeMap::load(&path),
            Err(ShapeMapError::DecodeShapeMap { .. })
        ));
    }
    fs::remove_file(&path).unwrap();
    assert!(matches!(
        ShapeMap::is_shape_map(&path),
        Err(ShapeMapError::Read { .. })
    ));
    assert!(matches!(
        ShapeMap::is_shape_map(folder.path()),
        Err(ShapeMapError::Directory { .. })
    ));
}

fn json(
    version: u32,
    storage: &str,
    bias: &str,
    step: &str,
    scale: &str,
    saturated: bool,
) -> String {
    format!(
        r#"{{"version":{version},"storage":"{storage}","bias":{bias},"step":{step},"scale":{scale},"saturated":{saturated}}}"#
    )
}

#[test]
fn descriptions_are_checked() {
    let good = json(1, "r8", "255", "0.25", "1", false);
    assert_eq!(parse(&good).unwrap().1.bias, 255);
    assert!(parse(&json(1, "rgba8", "0", "0.25", "0.5", true)).is_ok());
    assert!(parse(&json(1, "r32f", "0", "0", "1", false)).is_ok());

    let of = |storage, bias, step, scale| json(1, storage, bias, step, scale, false);
    for (text, reason) in [
        (json(2, "r8", "0", "1", "1", false), "version 2"),
        (r#"{"version":3}"#.into(), "version 3"),
        ("{".into(), "unreadable"),
        (r#"{"version":1}"#.into(), "unreadable"),
        (of("r9", "0", "1", "1"), "unreadable"),
        (of("bits8", "0", "1", "1"), "unreadable"),
        (of("r8", "-1", "1", "1"), "unreadable"),
        (of("r8", "256", "1", "1"), "bias 256"),
        (of("r16", "65536", "1", "1"), "bias 65536"),
        (of("rgba8", "1", "1", "1"), "bias 1"),
        (of("r32f", "1", "0", "1"), "bias 1"),
        (of("r8", "0", "0.3", "1"), "step 0.3"),
        (of("r8", "0", "-1", "1"), "step -1"),
        (of("r8", "0", "0", "1"), "step 0"),
        (of("r8", "0", "1e39", "1"), "step inf"),
        (of("r32f", "0", "1", "1"), "step 1"),
        (of("rgba8", "0", "0", "1"), "step 0"),
        (of("rgba8", "0", "-0.5", "1"), "step -0.5"),
        (of("rgba8", "0", "1e39", "1"), "step inf"),
        (of("rgba8", "0", "0.3", "1"), "step 0.3"),
        (of("r16", "0", "1", "0.5"), "scale 0.5"),
        (of("rgba8", "0", "1", "0"), "scale 0"),
        (of("rgba8", "0", "1", "1.5"), "scale 1.5"),
        (of("rgba8", "0", "1", "0.5"), "saturated = false"),
        (json(1, "r32f", "0", "0", "1", true), "saturated = true"),
    ] {
        let message = parse(&text).unwrap_err();
        assert!(message.contains(reason), "{text}: {message}");
    }
}

#[test]
fn pngs_are_checked_against_their_description() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.png");
    let gray = (ColorType::Grayscale, BitDepth::Eight);
    let rgba = (ColorType::Rgba, BitDepth::Eight);
    let r8 = json(1, "r8", "255", "0.25", "1", false);
    write_png(&path, gray, 0, Some(&r8));
    let map = ShapeMap::load(&path).unwrap();
    assert_eq!((map.decode(0, 0), map.step()), (-63.75, 0.25));
    let rgba8 = json(1, "rgba8", "0", "0.25", "1", false);
    write_png(&path, rgba, 255, Some(&rgba8));
    assert_eq!(ShapeMap::load(&path).unwrap().decode(1, 1), 63.25);

    let r16 = json(1, "r16", "0", "1", "1", false);
    let r32f = json(1, "r32f", "0", "0", "1", false);
    let deep = (ColorType::Grayscale, BitDepth::Sixteen);
    let rgb = (ColorType::Rgb, BitDepth::Eight);
    for (pixels, byte, text, part) in [
        (gray, 0, &r16, "do not hold r16"),
        (gray, 0, &r32f, "do not hold r32f"),
        (gray, 0, &rgba8, "do not hold rgba8"),
        (rgb, 0, &r8, "Rgb pixels"),
        (deep, 0, &r8, "Sixteen"),
        (rgba, 7, &rgba8, "alpha of 7"),
        (gray, 0, &"{".to_string(), "unreadable"),
    ] {
        write_png(&path, pixels, byte, Some(text));
        assert!(ShapeMap::is_shape_map(&path).unwrap());
        let message = reason(&path);
        assert!(message.contains(part), "{message}");
    }
}

#[test]
fn openexr_files_are_checked_against_their_description() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.exr");
    let r32f = json(1, "r32f", "0", "0", "1", false);
    let floats = |value| FlatSamples::F32(vec![1.0, -0.5, 2.5, value]);
    let plain = Compression::UNCOMPRESSED;
    write_exr(&path, &[("distance", floats(-2.5))], plain, Some(&r32f));
    let map = ShapeMap::load(&path).unwrap();
    assert_eq!([map.decode(0, 1), map.decode(1, 1)], [2.5, -2.5]);

    let half = FlatSamples::F16(vec![f16::from_f32(1.0); 4]);
    let r16 = json(1, "r16", "0", "1", "1", false);
    let one = |value| vec![("distance", floats(value))];
    let lossy = Compression {
        compression: ::exr::compression::Compression::PXR24,
        ..Compression::SMALL_LOSSLESS
    };
    for (channels, how, text, part) in [
        (one(1.0), plain, &r16, "does not hold r16"),
        (one(1.0), plain, &"{".to_string(), "unreadable"),
        (vec![("Y", floats(1.0))], plain, &r32f, "not one channel"),
        (vec![("distance", half)], plain, &r32f, "32-bit floats"),
        (
            vec![("distance", floats(1.0)), ("other", floats(1.0))],
            plain,
            &r32f,
            "not one channel",
        ),
        (one(1.0), lossy, &r32f, "with loss"),
        (one(1.0), Compression::FAST_LOSSLESS, &r32f, "scan lines"),
        (one(f32::NAN), plain, &r32f, "NaN"),
        (one(f32::NEG_INFINITY), plain, &r32f, "-inf"),
        (one(2.9), plain, &r32f, "distance 2.9"),
        (one(0.25), plain, &r32f, "distance 0.25"),
    ] {
        write_exr(&path, &channels, how, Some(text));
        assert!(ShapeMap::is_shape_map(&path).unwrap());
        let message = reason(&path);
        assert!(message.contains(part), "{message}");
    }
}

#[test]
fn cut_and_large_files_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    for &storage in Storage::ALL {
        let path = folder.path().join(name(storage));
        map(64, 64, storage).save(&path).unwrap();
        assert!(matches!(
            ShapeMap::load_within(&path, 64 * 64 - 1),
            Err(ShapeMapError::TooLarge { width: 64, .. })
        ));
        assert!(ShapeMap::load_within(&path, 64 * 64).is_ok());
        let bytes = fs::read(&path).unwrap();
        for length in [0, 7, 20, 60, 300, bytes.len() / 2, bytes.len() - 1] {
            fs::write(&path, &bytes[..length]).unwrap();
            assert!(ShapeMap::load(&path).is_err(), "{storage} cut to {length}");
        }
    }
}

#[test]
fn damaged_files_are_no_panic() {
    let folder = tempfile::tempdir().unwrap();
    for &storage in Storage::ALL {
        let path = folder.path().join(name(storage));
        map(40, 23, storage).save(&path).unwrap();
        let bytes = fs::read(&path).unwrap();
        let mut refused = 0;
        for index in (0..bytes.len().min(700)).step_by(3) {
            let mut damaged = bytes.clone();
            damaged[index] ^= 1 << (index % 8);
            fs::write(&path, damaged).unwrap();
            refused += u32::from(ShapeMap::load(&path).is_err());
            ShapeMap::is_shape_map(&path).unwrap();
        }
        assert!(refused > 30, "{storage}: {refused}");
    }
}
