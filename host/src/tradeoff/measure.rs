//! One variant: what it costs, and how wrong it is.

use super::judge::Judge;
use super::variant::Variant;
use crate::Error;
use crate::bench::{Clock, Summary, Timed};
use crate::picture::Picture;
use crate::prepare::PreparedScene;
use crate::render::gpu::{EntryPoints, Extent, Memory, Pictures};
use relievo_shared::layout::Frame;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// Rounds go on while the quartiles of the ratios lie further apart than this
/// share of their median: one slow round must not put a variant on the front.
const SPREAD: f64 = 0.05;
/// They end after so many times the rounds asked for.
const MOST_ROUNDS: u32 = 4;

/// How far what is hit is from the oracle's truth, one ray a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// Pixels hit in both, over pixels hit in either.
    pub silhouette_iou: f64,
    /// Pixels that should be hit and are not.
    pub holes: u64,
    /// Those more than one pixel inside the outline.
    pub interior_holes: u64,
    /// Pixels that are hit and should not be.
    pub extra: u64,
    /// 99th percentile of the error of t, world units, where both hit.
    pub distance_p99: f64,
    /// Share of the pixels hit in both whose class differs, 0…1.
    pub class_errors: f64,
    /// How far beside its place a pixel shows what it shows, pixels: 99 % of
    /// them are nearer. Infinite above 8.
    #[serde(with = "infinite")]
    pub error_px: f64,
    /// Share of the pixels that are more than half a pixel beside their place, 0…1.
    pub misplaced: f64,
}

/// What a variant costs, and how wrong it is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measurement {
    /// Milliseconds of a frame, one per round.
    pub milliseconds: Vec<f64>,
    /// The same of the reference, in the same rounds.
    pub reference_milliseconds: Vec<f64>,
    /// What the times are read from.
    pub clock: Clock,
    /// Steps of the linear search, mean over the rays that hit.
    pub steps_per_ray: f64,
    /// Bytes of GPU memory; `None` for the CPU.
    pub gpu_bytes: Option<u64>,
    /// Instructions of the shaders that draw colours, each counted once; `None`
    /// for the CPU.
    pub instructions: Option<u64>,
    /// Errors of what is hit.
    pub errors: Errors,
    /// How different the picture looks from the true one, 0…1; `None` where
    /// there is no true one.
    pub flip: Option<f64>,
}

impl Measurement {
    /// The time as a multiple of the reference's, within rounds.
    pub fn time_ratio(&self) -> Option<Summary> {
        Summary::of_ratios(&self.milliseconds, &self.reference_milliseconds)
    }
}

/// Infinity as null: JSON has no number for it.
mod infinite {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub fn serialize<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
        value.is_finite().then_some(*value).serialize(serializer)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
        Ok(Option::deserialize(deserializer)?.unwrap_or(f64::INFINITY))
    }
}

/// Pictures that were judged before, by what makes their words.
#[derive(Default)]
pub struct Known {
    geometries: BTreeMap<String, (f64, Errors)>,
    flips: BTreeMap<String, Option<f64>>,
}

impl Known {
    /// Keeps what `measured` says of `variant`, whose words are those of `source`.
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

/// What a variant is timed in turn with.
pub struct Reference<'a> {
    /// What draws it.
    pub timed: Timed<'a>,
    /// What is drawn.
    pub frame: Frame,
}

/// Measures `variant`, which is `scene` drawn by `timed`, in `rounds` rounds in
/// turn with `reference` after one to warm up, and in more while the machine is
/// not quiet; `source` names the words of the
/// renderer, as in `known`.
///
/// # Errors
/// [`Error::Render`] where the device fails.
#[expect(clippy::too_many_arguments, reason = "each is another thing")]
pub fn measure(
    variant: &Variant,
    scene: &PreparedScene,
    timed: &mut Timed<'_>,
    reference: &mut Reference<'_>,
    rounds: u32,
    judge: &Judge<'_>,
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
            (steps, judge.errors(&words))
        }
    };
    let flip = match known.flip(variant, source) {
        Some(known) => known,
        None => {
            let words = timed.renderer().color(&frame)?;
            judge.flip(&Picture::develop(&words, factor)?)
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

/// Instructions of the shaders that draw the colours of `scene`.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn infinity_survives_json() {
        for error_px in [0.0, 0.35, f64::INFINITY] {
            let errors = Errors {
                silhouette_iou: 1.0,
                holes: 1,
                interior_holes: 0,
                extra: 2,
                distance_p99: 0.01,
                class_errors: 0.5,
                error_px,
                misplaced: 0.1,
            };
            let text = serde_json::to_string(&errors).unwrap();
            assert_eq!(serde_json::from_str::<Errors>(&text).unwrap(), errors);
        }
    }
}
