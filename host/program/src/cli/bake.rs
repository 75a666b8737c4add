//! `relievo bake`.

use super::limits::PixelArguments;
use super::parse_margin;
use super::progress::Bar;
use super::{Arguments, say};
use clap::Args;
use clap::CommandFactory;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::error::ErrorKind;
use relievo::shape_map::{
    DEFAULT_RASTER, Encoding, LARGEST_RASTER, Lettering, Pattern, PatternOptions, SMALLEST_RASTER,
    ShapeMap, Storage, bake,
};
use relievo::{Error, Files};
use std::path::PathBuf;
use std::time::Instant;

#[derive(Args)]
pub struct BakeArguments {
    /// Pattern: an image or an SVG drawing, whose dark parts are extruded
    #[arg(required_unless_present = "text", conflicts_with = "text")]
    pattern: Option<PathBuf>,
    /// Pattern: these letters
    #[arg(long)]
    text: Option<String>,
    /// Font of --text, a .ttf or .otf file [default: built in]
    #[arg(long, value_name = "FILE", conflicts_with = "pattern")]
    font: Option<PathBuf>,
    /// Margin around --text, in line heights
    #[arg(long, value_name = "F", conflicts_with = "pattern", default_value_t = Lettering::DEFAULT_MARGIN, value_parser = parse_margin)]
    margin: f64,
    /// Pixels of the longer side of an SVG drawing or --text [default: 512]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(i64::from(SMALLEST_RASTER)..=i64::from(LARGEST_RASTER)))]
    raster: Option<u32>,
    /// Output: a .png file, or .exr for r32f
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Storage of the distances
    #[arg(long, value_parser = formats(), default_value_t = Storage::R16)]
    format: Storage,
    /// rgba8 only: fraction (above 0, up to 1) of the largest distance that the 8 bits cover;
    /// larger ones saturate [default: 1]
    #[arg(long, value_name = "F")]
    scale: Option<f32>,
    /// Pixels with a luma below this are pattern
    #[arg(long, default_value_t = 128, value_parser = clap::value_parser!(u8).range(1..))]
    threshold: u8,
    /// Extrude the light pixels
    #[arg(long)]
    invert: bool,
    #[command(flatten)]
    pixels: PixelArguments,
}

pub fn run(arguments: &BakeArguments) -> anyhow::Result<()> {
    let encoding = encoding(arguments).unwrap_or_else(|error| error.exit());
    let output = &arguments.output;
    // Checked before the work, and again by `save`.
    encoding
        .storage()
        .check_extension(output)
        .map_err(Error::from)?;
    let options = PatternOptions {
        threshold: arguments.threshold,
        invert: arguments.invert,
        max_pixels: arguments.pixels.max_pixels,
        raster: arguments.raster.unwrap_or(DEFAULT_RASTER),
    };
    if let (Some(path), Some(_)) = (&arguments.pattern, arguments.raster)
        && !Pattern::is_drawing(&Files::Disk, path).map_err(Error::from)?
    {
        anyhow::bail!(
            "{} has its own pixels, and --raster is for SVG files and --text; leave it out",
            path.display()
        );
    }
    let pattern = match (&arguments.pattern, &arguments.text) {
        (Some(path), _) => Pattern::load(path, &options),
        (None, text) => {
            let lettering = Lettering {
                // Clap requires one of the two.
                text: text.clone().unwrap_or_default(),
                font: arguments.font.clone(),
                margin: arguments.margin,
            };
            Pattern::from_text(&lettering, &Files::Disk, &options)
        }
    };
    let pattern = pattern.map_err(Error::from)?;
    let start = Instant::now();
    let map = {
        let bar = Bar::new();
        bake(&pattern, encoding, &|fraction| {
            bar.show("distances".to_string(), fraction);
        })
    };
    let seconds = start.elapsed().as_secs_f64();
    map.save(output)?;
    say(format_args!(
        "{}: {}, baked in {seconds:.3} s",
        output.display(),
        describe(&map)
    ))
}

/// Parses the value of `--format`.
pub(super) fn formats() -> impl TypedValueParser<Value = Storage> {
    let values = Storage::ALL
        .iter()
        .map(|storage| PossibleValue::new(storage.name()).help(storage.summary()));
    PossibleValuesParser::new(values)
        .try_map(|name| Storage::from_name(&name).ok_or("not a storage form"))
}

/// Returns the storage and scale, or a usage error.
fn encoding(arguments: &BakeArguments) -> Result<Encoding, clap::Error> {
    let wrong = |kind, message: String| Arguments::command().error(kind, message);
    let storage = arguments.format;
    match arguments.scale {
        None => Ok(storage.into()),
        Some(scale) if storage == Storage::Rgba8 => Encoding::rgba8(scale)
            .map_err(|error| wrong(ErrorKind::ValueValidation, format!("--scale: {error}"))),
        Some(_) => Err(wrong(
            ErrorKind::ArgumentConflict,
            "--scale is for --format rgba8; leave it out".to_string(),
        )),
    }
}

/// Describes a map in one line.
pub(super) fn describe(map: &ShapeMap) -> String {
    let storage = map.storage();
    let mut text = format!(
        "{} × {} texels as {storage} ({} bits), {} bytes, distances from {} to {} texels",
        map.width(),
        map.height(),
        storage.bits(),
        size_of_val(map.words()),
        map.min_distance(),
        map.max_distance(),
    );
    if map.step() > 0.0 {
        text += &format!(" in steps of {}", map.step());
    }
    if map.saturated() {
        text += " (farther ones saturate)";
    }
    text
}

#[cfg(test)]
mod tests {
    use super::super::Command;
    use super::*;
    use clap::Parser;

    fn parse(options: &str) -> Result<Encoding, clap::Error> {
        let line = format!("relievo bake pattern.png -o map.png {options}");
        let arguments = Arguments::try_parse_from(line.split_whitespace())?;
        let Command::Bake(arguments) = arguments.command else {
            unreachable!("the line says bake");
        };
        encoding(&arguments)
    }

    #[test]
    fn formats() {
        for (options, encoding) in [
            ("", Storage::R16.into()),
            ("--format r8", Storage::R8.into()),
            ("--format r16", Storage::R16.into()),
            ("--format r32f", Storage::R32F.into()),
            ("--format rgba8", Storage::Rgba8.into()),
            (
                "--format rgba8 --scale 0.25",
                Encoding::rgba8(0.25).unwrap(),
            ),
        ] {
            assert_eq!(parse(options).unwrap(), encoding, "{options}");
        }
    }

    #[test]
    fn what_does_not_fit_is_wrong_usage() {
        for (options, part) in [
            ("--bits 8", "unexpected argument"),
            ("--scale 0.5", "--format rgba8"),
            ("--format r32f --scale 1", "--format rgba8"),
            ("--format rgba8 --scale 0", "up to 1"),
            ("--format rgba8 --scale nan", "up to 1"),
            ("--format rgba8 --scale much", "--scale"),
            ("--format r9", "r32f"),
        ] {
            let error = parse(options).unwrap_err();
            assert_eq!(error.exit_code(), 2, "{options}");
            assert!(error.to_string().contains(part), "{options}: {error}");
        }
    }

    #[test]
    fn descriptions() {
        let pattern = Pattern::from_fn(16, 8, |x, _| x == 0).unwrap();
        let describe = |encoding: Encoding| describe(&bake(&pattern, encoding, &|_| ()));
        let text = describe(Storage::R32F.into());
        assert_eq!(
            text,
            "16 × 8 texels as r32f (32 bits), 512 bytes, distances from -0.5 to 7.5 texels"
        );
        let text = describe(Encoding::rgba8(0.5).unwrap());
        assert!(text.contains("as rgba8 (32 bits)"), "{text}");
        assert!(text.contains("in steps of 0.0156"), "{text}");
        assert!(text.contains("saturate"), "{text}");
    }
}
