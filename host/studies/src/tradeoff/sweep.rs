//! Measurement of the missing variants of a shard.

use super::grid::{Grid, part, reference, variants};
use super::ground_truth::{Finest, GroundTruth};
use super::measure::{Known, Reference, measure};
use super::record::{Header, Outcome, Record, Store};
use super::subject::Subject;
use super::variant::{Class, Rendering, Settings, Variant};
use crate::bench::{Backend, Timed};
use relievo::Error;
use relievo::prepare::{PreparedScene, prepare};
use relievo::render::RenderError;
use relievo::render::gpu::{Adapter, signature};
use std::collections::BTreeMap;

/// Receives a message and the fraction done.
pub type Progress<'a> = &'a dyn Fn(String, f64);

/// Renderers of a sweep.
pub struct Devices<'a> {
    /// GPU, if any, in addition to the CPU.
    pub adapter: Option<&'a Adapter>,
}

impl Devices<'_> {
    /// Returns the renderings: the CPU if `with_cpu`, and the shaders that the
    /// adapter supports.
    pub fn renderings(&self, with_cpu: bool) -> Vec<Rendering> {
        let mut renderings = Vec::new();
        if with_cpu {
            renderings.push(Rendering::Cpu);
        }
        match self.adapter {
            Some(adapter) if adapter.takes_spirv() => {
                renderings.extend([Rendering::GpuExact, Rendering::GpuFast]);
            }
            Some(_) => renderings.push(Rendering::GpuPortable),
            None => {}
        }
        renderings
    }

    fn backend(&self, rendering: Rendering) -> Backend<'_> {
        match (self.adapter, rendering.shaders()) {
            (Some(adapter), Some(shaders)) => Backend::Gpu(adapter, shaders),
            _ => Backend::Cpu,
        }
    }

    /// Returns whether the exact shaders match the CPU bit for bit.
    fn is_exact(&self) -> Result<bool, Error> {
        match self.adapter {
            Some(adapter) if adapter.takes_spirv() => {
                let device = adapter.open()?;
                Ok(signature(&device)?.is_exact())
            }
            _ => Ok(false),
        }
    }
}

/// Measures the variants of the header's shard that `store` lacks and appends
/// them; returns their number. Each is timed in turn with one reference of its
/// class, which makes runs and machines comparable.
///
/// # Errors
/// [`Error`] if a file is missing or a device fails; `store` keeps what was
/// measured. A variant that cannot be drawn is recorded as left out, with the
/// reason.
pub fn sweep(
    subject: &Subject,
    header: &Header,
    devices: &Devices<'_>,
    store: &mut Store,
    progress: Progress<'_>,
) -> Result<usize, Error> {
    let own = own_variants(subject, header);
    let missing: Vec<&Variant> = own
        .iter()
        .filter(|variant| !store.has(&variant.key()))
        .collect();
    if missing.is_empty() {
        return Ok(0);
    }
    let start = 1.0 - missing.len() as f64 / own.len() as f64;
    progress("preparing the truth".to_string(), start);
    let finest = Finest::new(subject)?;
    let truth = GroundTruth::new(&finest)?;

    progress("preparing the reference".to_string(), start);
    let reference_scene = prepare(&subject.with(&reference(subject)), &|_| ())?;
    let mut references: BTreeMap<Class, Reference<'_>> = BTreeMap::new();
    for &rendering in &header.renderings {
        if let std::collections::btree_map::Entry::Vacant(place) =
            references.entry(rendering.class())
        {
            place.insert(Reference {
                timed: Timed::new(&reference_scene, &devices.backend(rendering))?,
                frame: reference_scene.frame,
            });
        }
    }

    let is_exact = devices.is_exact()?;
    let source = |rendering: Rendering| match rendering {
        Rendering::Cpu => "exact",
        Rendering::GpuExact if is_exact => "exact",
        other => other.name(),
    };
    let mut known = known(&own, store, source);
    let mut prepared: Option<(Settings, Result<PreparedScene, String>)> = None;
    for (number, &variant) in missing.iter().enumerate() {
        let key = variant.key();
        let done = (own.len() - missing.len() + number) as f64;
        progress(key.clone(), done / own.len() as f64);
        // Renderers of the same settings follow each other.
        if prepared
            .as_ref()
            .is_none_or(|(settings, _)| *settings != variant.settings)
        {
            prepared = Some((variant.settings, prepare_variant(subject, variant)?));
        }
        let outcome = match &prepared {
            Some((_, Err(reason))) => Outcome::LeftOut(reason.clone()),
            Some((_, Ok(scene))) => {
                let Some(reference) = references.get_mut(&variant.rendering.class()) else {
                    continue;
                };
                match Timed::new(scene, &devices.backend(variant.rendering)) {
                    Err(error @ RenderError::Limit { .. }) => Outcome::LeftOut(error.to_string()),
                    Err(error) => return Err(error.into()),
                    Ok(mut timed) => {
                        let source = source(variant.rendering);
                        let measured = measure(
                            variant,
                            scene,
                            &mut timed,
                            reference,
                            header.frames,
                            &truth,
                            &known,
                            source,
                        )?;
                        known.add(variant, source, &measured);
                        Outcome::Measured(Box::new(measured))
                    }
                }
            }
            None => continue,
        };
        store.add(Record { key, outcome })?;
    }
    Ok(missing.len())
}

/// Returns the variants of the header's shard.
pub(super) fn own_variants(subject: &Subject, header: &Header) -> Vec<Variant> {
    part(&all_variants(subject, header), header.shard)
}

/// Returns the variants of all shards.
pub(super) fn all_variants(subject: &Subject, header: &Header) -> Vec<Variant> {
    let grid: Grid = header.grid;
    variants(subject, grid, &header.renderings)
}

/// Prepares the scene of `variant`, or returns why it cannot be drawn.
fn prepare_variant(
    subject: &Subject,
    variant: &Variant,
) -> Result<Result<PreparedScene, String>, Error> {
    match prepare(&subject.with(&variant.settings), &|_| ()) {
        Ok(scene) => Ok(Ok(scene)),
        Err(Error::Object { name, problem, .. }) => Ok(Err(format!("object {name:?}: {problem}"))),
        Err(error) => Err(error),
    }
}

/// Collects the known results of `own` variants from `store`.
fn known(own: &[Variant], store: &Store, source: impl Fn(Rendering) -> &'static str) -> Known {
    let mut known = Known::default();
    for record in &store.records {
        let variant = own.iter().find(|variant| variant.key() == record.key);
        if let (Some(variant), Outcome::Measured(measured)) = (variant, &record.outcome) {
            known.add(variant, source(variant.rendering), measured);
        }
    }
    known
}
