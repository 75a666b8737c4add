//! Cost and error of one variant.

use super::ground_truth::{Errors, GroundTruth};
use super::variant::Variant;
use crate::bench::{Clock, Summary, Timed};
use relievo::Error;
use relievo::picture::Picture;
use relievo::prepare::PreparedScene;
use relievo::render::gpu::{EntryPoints, Extent, Memory, Pictures};
use relievo::scene::Development;
use relievo_shared::layout::Frame;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// Rounds continue while the interquartile range of the time ratios exceeds
/// this fraction of their median, so that a slow round cannot put a variant on
/// the front.
const SPREAD: f64 = 0.05;
/// Maximum number of rounds, as a multiple of those requested.
const MOST_ROUNDS: u32 = 4;

/// Cost and error of a variant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measurement {
    /// Frame times, milliseconds, one per round.
    pub milliseconds: Vec<f64>,
    /// Frame times of the reference in the same rounds, milliseconds.
    pub reference_milliseconds: Vec<f64>,
    /// Source of the times.
    pub clock: Clock,
    /// Linear search steps, mean over the rays that hit.
    pub steps_per_ray: f64,
    /// GPU memory, bytes; `None` for the CPU.
    pub gpu_bytes: Option<u64>,
    /// Static instruction count of the colour shaders; `None` for the CPU.
    pub instructions: Option<u64>,
    /// Errors of hits.
    pub errors: Errors,
    /// FLIP difference from the reference picture, 0…1; `None` without one.
    pub flip: Option<f64>,
}

impl Measurement {
    /// Returns the time as a multiple of the reference's, within rounds.
    pub fn time_ratio(&self) -> Option<Summary> {
        Summary::of_ratios(&self.milliseconds, &self.reference_milliseconds)
    }
}

/// Results of earlier variants that render the same words.
#[derive(Default)]
pub struct Known {
    geometries: BTreeMap<String, (f64, Errors)>,
    flips: BTreeMap<String, Option<f64>>,
}

impl Known {
    /// Records `measured` of `variant`, whose words come from `source`.
    pub fn add(&mut self, variant: &Variant, source: &str, measured: &Measurement) {
        let geometry = (measured.steps_per_ray, measured.errors);
        self.geometries
            .insert(format!("{} {source}", variant.geometry_key()), geometry);
        let picture = format!("{} {source}", variant.picture_key());
        self.flips.insert(picture, measured.flip);
    }

    fn geometry(&self, variant: &Variant, source: &str) -> Option<(f64, Errors)> {
        let key = format!("{} {source}", variant.geometry_key());
        self.geometries.get(&key).copied()
    }

    fn flip(&self, variant: &Variant, source: &str) -> Option<Option<f64>> {
        let key = format!("{} {source}", variant.picture_key());
        self.flips.get(&key).copied()
    }
}

/// Reference that variants are timed against.
pub struct Reference<'a> {
    /// Renderer.
    pub timed: Timed<'a>,
    /// Frame to draw.
    pub frame: Frame,
}

/// Measures `variant`, which is `scene` drawn by `timed`, against `reference`
/// in alternating rounds: one to warm up, then `rounds`, and more while the
/// times vary. `source` names the origin of the renderer's words, as in
/// `known`.
///
/// # Errors
/// [`Error::Render`] if the device fails.
#[expect(clippy::too_many_arguments, reason = "each is another thing")]
pub fn measure(
    variant: &Variant,
    scene: &PreparedScene,
    timed: &mut Timed<'_>,
    reference: &mut Reference<'_>,
    rounds: u32,
    truth: &GroundTruth<'_>,
    known: &Known,
    source: &str,
) -> Result<Measurement, Error> {
    let factor = scene.supersampling;
    let frame = scene.frame_with_samples(factor);
    let (steps_per_ray, errors) = match known.geometry(variant, source) {
        Some(known) => known,
        None => {
            let words = timed.renderer().geometry(&scene.frame)?;
            let (_, steps) = words.coverage();
            (steps, truth.errors(&words))
        }
    };
    let flip = match known.flip(variant, source) {
        Some(known) => known,
        None => {
            let words = timed.renderer().color(&frame)?;
            truth.flip(&Picture::develop(&words, factor, &Development::default())?)
        }
    };
    let (mut milliseconds, mut reference_milliseconds) = (Vec::new(), Vec::new());
    let mut clock = Clock::Wall;
    for round in 0..=MOST_ROUNDS * rounds {
        let is_settled =
            Summary::of_ratios(&milliseconds, &reference_milliseconds).is_some_and(|ratio| {
                ratio.upper_quartile - ratio.lower_quartile < SPREAD * ratio.median
            });
        if round > rounds && is_settled {
            break;
        }
        let (reference_time, _) = reference.timed.time(&reference.frame)?;
        let (time, read_from) = timed.time(&frame)?;
        clock = read_from;
        if round > 0 {
            milliseconds.push(time);
            reference_milliseconds.push(reference_time);
        }
    }
    Ok(Measurement {
        milliseconds,
        reference_milliseconds,
        clock,
        steps_per_ray,
        gpu_bytes: variant
            .rendering
            .shaders()
            .map(|_| Memory::of(scene, Extent::Needed, Pictures::Color).total()),
        instructions: instructions(variant, scene)?,
        errors,
        flip,
    })
}

/// Counts the instructions of the shaders that draw the colours of `scene`.
fn instructions(variant: &Variant, scene: &PreparedScene) -> Result<Option<u64>, Error> {
    let Some(shaders) = variant.rendering.shaders() else {
        return Ok(None);
    };
    let module = shaders.module()?;
    let objects = scene.objects.iter();
    let used: BTreeSet<&str> = objects
        .map(|object| EntryPoints::of(&object.parameters, Extent::Needed).color)
        .collect();
    let counts = used.iter().filter_map(|name| module.instructions(name));
    Ok(Some(counts.sum::<usize>() as u64))
}
