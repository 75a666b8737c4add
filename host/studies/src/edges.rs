//! Error and cost of smooth edges, beside those of more samples.

use crate::bench::Summary;
use crate::perceptual::difference;
use relievo::Error;
use relievo::picture::Picture;
use relievo::prepare::PreparedScene;
use relievo::render::{ColorWords, CpuRenderer, RenderError, Renderer};
use relievo::scene::Development;
use std::time::Instant;

/// Samples per pixel side of the reference.
pub const REFERENCE: u32 = 16;
/// The variants: samples per pixel side, and whether edges are smooth.
pub const VARIANTS: [(u32, bool); 4] = [(1, false), (1, true), (2, false), (2, true)];

/// Error and cost of a variant.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Mean FLIP difference from 256 samples a pixel.
    pub flip: f64,
    /// What is left of `flip` if each pixel that shows more than one class has the colour of 256 samples: the
    /// error within surfaces.
    pub inside: f64,
    /// The FLIP difference if each class has its exact share of a pixel, in the colour of the nearest sample that shows
    /// it; that of 256 samples if no sample beside the pixel does.
    pub covered: f64,
    /// Root of the mean squared difference from these, of 255.
    pub rmse: f64,
    /// Time of a frame over that of the first variant in the same round, on the CPU and the GPU.
    pub ratios: [Option<Summary>; 2],
}

/// Measures all variants of a scene, prepared without and with smooth edges. `gpu` has a renderer
/// of each, to be timed, too.
///
/// # Errors
/// [`Error`] if a renderer fails; the reference needs 12 KB a pixel.
pub fn measure(
    scenes: [&PreparedScene; 2],
    gpu: Option<[&mut dyn Renderer; 2]>,
    frames: u32,
    progress: &dyn Fn(&str, f64),
) -> Result<[Row; 4], Error> {
    let [plain, smooth] = scenes;
    progress("reference", 0.0);
    let all = CpuRenderer::new(plain).color(&plain.frame_with_samples(REFERENCE))?;
    let reference = Picture::develop(&all, REFERENCE, &plain.development)?;
    let divided = divided(&all, REFERENCE);
    let [mut cpu, mut smooth_cpu] = [plain, smooth].map(CpuRenderer::new);
    let mut covered = [0.0; 2];
    let mut renderers: Vec<[&mut dyn Renderer; 2]> = vec![[&mut cpu, &mut smooth_cpu]];
    renderers.extend(gpu.map(|[plain, smooth]| [plain as &mut dyn Renderer, smooth]));
    let mut times = [(); 2].map(|()| [(); 4].map(|()| Vec::new()));
    let mut pictures = Vec::new();
    for round in 0..=frames {
        progress("frames", f64::from(round) / f64::from(frames + 1));
        for (variant, (factor, is_smooth)) in VARIANTS.into_iter().enumerate() {
            let which = usize::from(is_smooth);
            let frame = plain.frame_with_samples(factor);
            for (index, pair) in renderers.iter_mut().enumerate() {
                let start = Instant::now();
                let words = pair[which].color(&frame)?;
                if round > 0 {
                    times[index][variant].push(start.elapsed().as_secs_f64());
                } else if index == 0 {
                    // The first round warms up, and shows the errors.
                    pictures.push(Picture::develop(&words, factor, &plain.development)?);
                    if !is_smooth {
                        let picture = with_coverage(&all, &words, &plain.development)?;
                        covered[factor as usize - 1] = difference(&reference, &picture);
                    }
                }
            }
        }
    }
    Ok(std::array::from_fn(|variant| Row {
        flip: difference(&reference, &pictures[variant]),
        inside: difference(
            &reference,
            &replaced(&pictures[variant], &reference, &divided),
        ),
        covered: covered[VARIANTS[variant].0 as usize - 1],
        rmse: rmse(&reference, &pictures[variant]),
        ratios: [0, 1].map(|at| Summary::of_ratios(&times[at][variant], &times[at][0])),
    }))
}

/// Returns whether each pixel shows more than one class in its `factor`² samples.
fn divided(words: &ColorWords, factor: u32) -> Vec<bool> {
    let [width, height] = [words.width, words.height].map(|side| side / factor);
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (factor * x, factor * y)));
    let is_divided = |(x, y)| {
        let class = |sample| words.pixel(x + sample % factor, y + sample / factor)[3];
        (1..factor * factor).any(|sample| class(sample) != class(0))
    };
    pixels.map(is_divided).collect()
}

/// Returns the picture in which each of the samples in `words` has the colour of the nearest one of the fewer `samples`
/// that shows its class, among the one that it lies in and those around that, if there is one.
pub(crate) fn with_coverage(
    words: &ColorWords,
    samples: &ColorWords,
    development: &Development,
) -> Result<Picture, RenderError> {
    let [width, height] = [words.width, words.height].map(|side| side / REFERENCE);
    let scale = words.width / samples.width;
    let nearest = |x: u32, y: u32| {
        let own = words.pixel(x, y);
        // How far the sample at `step` from the one that it lies in is, in half widths of one in `words`.
        let way = |at: u32, step: i32| {
            (step * scale as i32 + scale as i32 / 2) * 2 - (at % scale) as i32 * 2 - 1
        };
        let steps = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy)));
        let beside = steps.filter_map(|(dx, dy)| {
            let x = (x / scale)
                .checked_add_signed(dx)
                .filter(|x| *x < samples.width)?;
            let y = (y / scale)
                .checked_add_signed(dy)
                .filter(|y| *y < samples.height)?;
            Some((dx, dy, samples.pixel(x, y)))
        });
        let alike = beside.filter(|(.., sample)| sample[3] == own[3]);
        let found = alike.min_by_key(|(dx, dy, _)| match (dx, dy) {
            (0, 0) => 0,
            _ => way(x, *dx).pow(2) + way(y, *dy).pow(2),
        });
        found.map_or(own, |(.., sample)| sample)
    };
    let mut picture = Picture {
        width,
        height,
        bytes: Vec::new(),
    };
    // A row at a time: all samples take much memory.
    for row in 0..height {
        let lines = REFERENCE * row..REFERENCE * (row + 1);
        let places = lines.flat_map(|y| (0..words.width).map(move |x| (x, y)));
        let row = ColorWords {
            width: words.width,
            height: REFERENCE,
            words: places.map(|(x, y)| nearest(x, y)).collect(),
        };
        picture
            .bytes
            .extend(Picture::develop(&row, REFERENCE, development)?.bytes);
    }
    Ok(picture)
}

/// Returns `picture` with the colours of `reference` in the pixels that are `divided`.
fn replaced(picture: &Picture, reference: &Picture, divided: &[bool]) -> Picture {
    let mut replaced = picture.clone();
    let channels = picture.channels();
    let pixels = replaced.bytes.chunks_exact_mut(channels);
    let pixels = pixels.zip(reference.bytes.chunks_exact(channels));
    for ((pixel, right), _) in pixels.zip(divided).filter(|(_, divided)| **divided) {
        pixel.copy_from_slice(right);
    }
    replaced
}

/// Returns the root of the mean squared difference, of 255.
fn rmse(reference: &Picture, picture: &Picture) -> f64 {
    let pairs = reference.bytes.iter().zip(&picture.bytes);
    let sum: f64 = pairs
        .map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2))
        .sum();
    (sum / reference.bytes.len().max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use relievo::prepare::prepare;
    use relievo::scene::Scene;
    use relievo::{Files, Limits};
    use std::path::Path;

    #[test]
    fn smooth_edges_are_nearer_to_many_samples() {
        let quad = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
        let prepared = [false, true].map(|is_smooth| {
            let files = Files::memory([("quad.obj".into(), quad.as_bytes().into())]);
            let text = format!(
                "[image]\nsize = [96, 72]\nsmooth_edges = {is_smooth}\n\
                 [camera]\neye = [0.6, 0.4, 1]\ntarget = [0.5, 0.5, 0]\nfov = 40\n\
                 [environment]\n[[light]]\ndirection = [1, 2, 3]\n\
                 [[object]]\nmesh = \"quad.obj\"\nshape = {{ text = \"Ra\" }}\n\
                 projection = \"planar-z\"\ndepth = 0.05\n"
            );
            let scene = Scene::parse_with(&text, Path::new(""), &Limits::default(), files).unwrap();
            prepare(&scene, &|_| ()).unwrap()
        });
        let [plain, smooth] = &prepared;
        let rows = measure([plain, smooth], None, 1, &|_, _| ()).unwrap();
        let [one, smooth, four, both] = rows.map(|row| row.rmse);
        assert!(smooth < 0.5 * one, "{one} {smooth}");
        assert!(both < 0.6 * four, "{four} {both}");
        // Nearly all of the error lies at edges.
        assert!(
            rows.iter().all(|row| row.inside < 0.5 * row.flip),
            "{rows:?}"
        );
        // Exact coverage leaves more than that, but less than four samples.
        let covered = rows.map(|row| row.covered);
        assert!(
            covered[0] > rows[0].inside && covered[0] < rows[2].flip,
            "{rows:?}"
        );
        assert!(covered[0] == covered[1] && covered[2] == covered[3]);
        assert!(
            rows.iter()
                .all(|row| row.ratios[0].is_some() && row.ratios[1].is_none())
        );
    }
}
