//! Baked shape maps on disk: a grayscale PNG of the stored integers, 8 or 16
//! bits deep, and a text chunk that says how to decode them.

use super::input::{DEFAULT_MAX_PIXELS, MAX_PIXELS, check_size, open};
use super::storage::Quantization;
use super::{ShapeMap, ShapeMapError, Storage};
use png::{BitDepth, ColorType};
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// Keyword of the text chunk (tEXt).
const KEYWORD: &str = "relievo-shape-map";
/// Version of the text chunk's content.
const VERSION: u32 = 1;

/// Content of the text chunk, as JSON.
#[derive(Serialize, Deserialize)]
struct Description {
    version: u32,
    storage: Storage,
    bias: u32,
    step: f32,
    saturated: bool,
}

impl Description {
    fn new(quantization: Quantization) -> Self {
        let Quantization {
            storage,
            bias,
            step,
            saturated,
        } = quantization;
        Self {
            version: VERSION,
            storage,
            bias,
            step,
            saturated,
        }
    }

    /// Parses and checks a description against the pixels it comes with.
    fn parse(text: &str, pixels: (ColorType, BitDepth)) -> Result<Quantization, String> {
        // The version comes first: a later one may have other keys.
        #[derive(Deserialize)]
        struct Version {
            version: u32,
        }
        let unreadable = |error: serde_json::Error| format!("unreadable description: {error}");
        let Version { version } = serde_json::from_str(text).map_err(unreadable)?;
        if version != VERSION {
            return Err(format!("version {version}, where {VERSION} is known"));
        }
        let Self {
            version: _,
            storage,
            bias,
            step,
            saturated,
        } = serde_json::from_str(text).map_err(unreadable)?;
        if png_depth(storage).map(|depth| (ColorType::Grayscale, depth)) != Some(pixels) {
            return Err(format!(
                "{:?} pixels of depth {:?} do not hold {storage:?}",
                pixels.0, pixels.1
            ));
        }
        if bias > storage.max_texel(0) {
            return Err(format!("bias {bias} is out of range"));
        }
        // Within these bounds every distance is a normal number.
        let is_power_of_two = step.to_bits() & ((1 << (f32::MANTISSA_DIGITS - 1)) - 1) == 0;
        if !is_power_of_two || !(1.0 / 65536.0..=65536.0).contains(&step) {
            return Err(format!("step {step} is not a power of two in 2⁻¹⁶…2¹⁶"));
        }
        Ok(Quantization {
            storage,
            bias,
            step,
            saturated,
        })
    }
}

/// The depth of the PNG for a storage, if there is one.
fn png_depth(storage: Storage) -> Option<BitDepth> {
    match storage {
        Storage::Bits8 => Some(BitDepth::Eight),
        Storage::Bits16 => Some(BitDepth::Sixteen),
        Storage::Bits32 => None,
    }
}

impl ShapeMap {
    /// Saves the map as a grayscale PNG that [`ShapeMap::load_png`] reads back
    /// unchanged. The file appears under its name only once it is complete.
    ///
    /// # Errors
    /// [`ShapeMapError::StorageNotInPng`] for 32-bit storage;
    /// [`ShapeMapError::Write`] where the file cannot be written.
    pub fn save_png(&self, path: impl AsRef<Path>) -> Result<(), ShapeMapError> {
        let path = path.as_ref();
        let Some(depth) = png_depth(self.storage()) else {
            return Err(ShapeMapError::StorageNotInPng {
                path: path.to_path_buf(),
            });
        };
        self.write_png(path, depth)
            .map_err(|source| ShapeMapError::Write {
                path: path.to_path_buf(),
                source,
            })
    }

    fn write_png(&self, path: &Path, depth: BitDepth) -> io::Result<()> {
        let folder = match path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        let mut builder = tempfile::Builder::new();
        // Temporary files are private by default; a map is like any other output.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o644));
        let mut file = builder.tempfile_in(folder)?;

        let mut output = BufWriter::new(file.as_file_mut());
        let mut encoder = png::Encoder::new(&mut output, self.width(), self.height());
        encoder.set_color(ColorType::Grayscale);
        encoder.set_depth(depth);
        let description = serde_json::to_string(&Description::new(self.quantization()))?;
        encoder.add_text_chunk(KEYWORD.to_string(), description)?;
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&self.big_endian_texels())?;
        writer.finish()?;
        output.flush()?;
        drop(output);
        file.persist(path)?;
        Ok(())
    }

    /// Texels of 8 or 16 bits in the order of a PNG.
    fn big_endian_texels(&self) -> Vec<u8> {
        let bytes = self.storage().bits() as usize / 8;
        let count = self.width() as usize * self.height() as usize;
        let mut texels = Vec::with_capacity(count * bytes);
        for index in 0..count {
            texels.extend_from_slice(&self.texel_at(index).to_be_bytes()[4 - bytes..]);
        }
        texels
    }

    /// Loads a baked map of at most [`DEFAULT_MAX_PIXELS`] texels.
    ///
    /// # Errors
    /// As for [`ShapeMap::load_png_within`].
    pub fn load_png(path: impl AsRef<Path>) -> Result<Self, ShapeMapError> {
        Self::load_png_within(path, DEFAULT_MAX_PIXELS)
    }

    /// Loads a baked map of at most `max_pixels` texels ([`MAX_PIXELS`] at most).
    ///
    /// # Errors
    /// A file that cannot be read, is no PNG or damaged
    /// ([`ShapeMapError::DecodeShapeMap`]), is too large, has no description
    /// ([`ShapeMapError::NotAShapeMap`]) or one that is not valid
    /// ([`ShapeMapError::InvalidShapeMap`]).
    pub fn load_png_within(path: impl AsRef<Path>, max_pixels: u64) -> Result<Self, ShapeMapError> {
        let path = path.as_ref();
        let decode_error = |source| ShapeMapError::DecodeShapeMap {
            path: path.to_path_buf(),
            source,
        };
        let mut decoder = decoder(path)?;
        let header = decoder.read_header_info().map_err(decode_error)?;
        let (width, height) = (header.width, header.height);
        check_size(path, width, height, max_pixels)?;

        let mut reader = decoder.read_info().map_err(decode_error)?;
        let Some(text) = description(reader.info()) else {
            return Err(ShapeMapError::NotAShapeMap {
                path: path.to_path_buf(),
            });
        };
        let pixels = (reader.info().color_type, reader.info().bit_depth);
        let quantization =
            Description::parse(text, pixels).map_err(|reason| ShapeMapError::InvalidShapeMap {
                path: path.to_path_buf(),
                reason,
            })?;
        // The size has been checked, so there always is a buffer size.
        let mut bytes = vec![0; reader.output_buffer_size().unwrap_or_default()];
        reader.next_frame(&mut bytes).map_err(decode_error)?;
        // Reads on to the end, so that a cut file is noticed.
        reader.finish().map_err(decode_error)?;
        Ok(match quantization.storage {
            Storage::Bits8 => Self::pack(width, height, quantization, &bytes, u32::from),
            Storage::Bits16 | Storage::Bits32 => {
                let (texels, _) = bytes.as_chunks();
                Self::pack(width, height, quantization, texels, |texel| {
                    u16::from_be_bytes(texel).into()
                })
            }
        })
    }

    /// Tells a baked map from a plain image, by the description in the file. The
    /// pixels are not read, and a file that is no PNG is not a shape map.
    ///
    /// # Errors
    /// A file that cannot be opened.
    pub fn is_shape_map(path: impl AsRef<Path>) -> Result<bool, ShapeMapError> {
        let reader = decoder(path.as_ref())?.read_info();
        Ok(reader.is_ok_and(|reader| description(reader.info()).is_some()))
    }
}

fn decoder(path: &Path) -> Result<png::Decoder<io::BufReader<File>>, ShapeMapError> {
    // The limit is on what the decoder sets aside for chunks and for one row.
    let bytes = 2 * MAX_PIXELS as usize + (64 << 20);
    let limits = png::Limits { bytes };
    Ok(png::Decoder::new_with_limits(open(path)?, limits))
}

fn description<'a>(info: &'a png::Info<'_>) -> Option<&'a str> {
    let chunks = &info.uncompressed_latin1_text;
    let chunk = chunks.iter().find(|chunk| chunk.keyword == KEYWORD)?;
    Some(&chunk.text)
}

#[cfg(test)]
mod tests {
    use super::super::{Pattern, PatternOptions, bake};
    use super::*;
    use std::fs;
    use std::path::PathBuf;

    fn map(width: u32, height: u32, storage: Storage) -> ShapeMap {
        let pattern = Pattern::from_fn(width, height, |x, y| (x / 3 + y / 5) % 4 == 0).unwrap();
        bake(&pattern, storage, &|_| ())
    }

    /// A PNG of 2 × 2 pixels, with `text` as its description.
    fn write(path: &Path, color: ColorType, depth: BitDepth, text: Option<&str>) {
        let mut encoder = png::Encoder::new(File::create(path).unwrap(), 2, 2);
        encoder.set_color(color);
        encoder.set_depth(depth);
        if let Some(text) = text {
            encoder
                .add_text_chunk(KEYWORD.to_string(), text.to_string())
                .unwrap();
        }
        let mut writer = encoder.write_header().unwrap();
        let bytes = 4 * color.samples() * depth as usize / 8;
        writer.write_image_data(&vec![0; bytes]).unwrap();
    }

    #[test]
    fn round_trip() {
        let folder = tempfile::tempdir().unwrap();
        for storage in [Storage::Bits8, Storage::Bits16] {
            for (width, height) in [(1, 1), (7, 5), (33, 2), (1, 41), (300, 1), (64, 64)] {
                let path = folder.path().join("map.png");
                let map = map(width, height, storage);
                map.save_png(&path).unwrap();
                assert!(ShapeMap::is_shape_map(&path).unwrap());
                assert_eq!(ShapeMap::load_png(&path).unwrap(), map);
            }
        }
        // Nothing but the one file, saved over and over, is left.
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_saturated_map_stays_so() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("map.png");
        let pattern = Pattern::from_fn(400, 400, |x, y| x + y == 0).unwrap();
        let map = bake(&pattern, Storage::Bits8, &|_| ());
        map.save_png(&path).unwrap();
        assert!(map.saturated());
        assert_eq!(ShapeMap::load_png(&path).unwrap(), map);
    }

    #[cfg(unix)]
    #[test]
    fn the_file_can_be_read_by_others() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("map.png");
        map(4, 4, Storage::Bits8).save_png(&path).unwrap();
        // What an ordinary new file gets, but for the executable bits.
        let plain = folder.path().join("plain");
        fs::write(&plain, "").unwrap();
        let mode = |path: &PathBuf| fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&path), mode(&plain) & !0o022);
    }

    #[test]
    fn what_cannot_be_saved() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("map.png");
        let error = map(4, 4, Storage::Bits32).save_png(&path).unwrap_err();
        assert!(error.to_string().contains("16-bit"), "{error}");
        let nowhere = folder.path().join("no/such/folder/map.png");
        let map = map(4, 4, Storage::Bits8);
        for path in [&nowhere, folder.path()] {
            let error = map.save_png(path).unwrap_err();
            assert!(matches!(error, ShapeMapError::Write { .. }));
            assert!(error.to_string().contains(&path.display().to_string()));
        }
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn plain_images_are_not_shape_maps() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plain.png");
        write(&path, ColorType::Grayscale, BitDepth::Eight, None);
        assert!(!ShapeMap::is_shape_map(&path).unwrap());
        assert!(matches!(
            ShapeMap::load_png(&path),
            Err(ShapeMapError::NotAShapeMap { .. })
        ));
        assert!(Pattern::load(&path, &PatternOptions::default()).is_ok());
        fs::write(&path, "no PNG").unwrap();
        assert!(!ShapeMap::is_shape_map(&path).unwrap());
        assert!(matches!(
            ShapeMap::load_png(&path),
            Err(ShapeMapError::DecodeShapeMap { .. })
        ));
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

    #[test]
    fn descriptions_are_checked() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("map.png");
        let text = |version: u32, storage: &str, bias: &str, step: &str| {
            format!(
                r#"{{"version":{version},"storage":"{storage}","bias":{bias},"step":{step},"saturated":false}}"#
            )
        };
        let good = text(1, "bits8", "255", "0.25");
        write(&path, ColorType::Grayscale, BitDepth::Eight, Some(&good));
        let map = ShapeMap::load_png(&path).unwrap();
        assert_eq!((map.decode(0, 0), map.step()), (-63.75, 0.25));

        let gray = ColorType::Grayscale;
        for (color, depth, text, reason) in [
            (
                gray,
                BitDepth::Eight,
                text(2, "bits8", "0", "1"),
                "version 2",
            ),
            (
                gray,
                BitDepth::Eight,
                r#"{"version":3}"#.into(),
                "version 3",
            ),
            (gray, BitDepth::Eight, "{".into(), "unreadable"),
            (
                gray,
                BitDepth::Eight,
                r#"{"version":1}"#.into(),
                "unreadable",
            ),
            (
                gray,
                BitDepth::Eight,
                text(1, "bits9", "0", "1"),
                "unreadable",
            ),
            (
                gray,
                BitDepth::Eight,
                text(1, "bits8", "-1", "1"),
                "unreadable",
            ),
            (
                gray,
                BitDepth::Eight,
                text(1, "bits8", "256", "1"),
                "bias 256",
            ),
            (
                gray,
                BitDepth::Eight,
                text(1, "bits8", "0", "0.3"),
                "step 0.3",
            ),
            (
                gray,
                BitDepth::Eight,
                text(1, "bits8", "0", "-1"),
                "step -1",
            ),
            (gray, BitDepth::Eight, text(1, "bits8", "0", "0"), "step 0"),
            (
                gray,
                BitDepth::Eight,
                text(1, "bits8", "0", "1e39"),
                "step inf",
            ),
            (gray, BitDepth::Eight, text(1, "bits16", "0", "1"), "Bits16"),
            (gray, BitDepth::Eight, text(1, "bits32", "0", "1"), "Bits32"),
            (ColorType::Rgb, BitDepth::Eight, good.clone(), "Rgb"),
            (gray, BitDepth::Sixteen, good.clone(), "Sixteen"),
        ] {
            write(&path, color, depth, Some(&text));
            let error = ShapeMap::load_png(&path).unwrap_err();
            assert!(matches!(error, ShapeMapError::InvalidShapeMap { .. }));
            let message = error.to_string();
            assert!(message.contains(reason), "{message}");
            assert!(message.contains("map.png"), "{message}");
        }
    }

    #[test]
    fn cut_and_large_files_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("map.png");
        map(64, 64, Storage::Bits16).save_png(&path).unwrap();
        assert!(matches!(
            ShapeMap::load_png_within(&path, 64 * 64 - 1),
            Err(ShapeMapError::TooLarge { width: 64, .. })
        ));
        assert!(ShapeMap::load_png_within(&path, 64 * 64).is_ok());
        let bytes = fs::read(&path).unwrap();
        for length in [0, 7, 20, 60, bytes.len() / 2, bytes.len() - 1] {
            fs::write(&path, &bytes[..length]).unwrap();
            assert!(ShapeMap::load_png(&path).is_err(), "cut to {length}");
        }
    }
}
