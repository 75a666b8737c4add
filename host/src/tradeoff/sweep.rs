//! Measuring what is missing of a shard.

use super::grid::{Grid, part, reference, variants};
use super::judge::{Finest, Judge};
use super::measure::{Known, Reference, measure};
use super::record::{Header, Outcome, Record, Store};
use super::subject::Subject;
use super::variant::{Class, Rendering, Settings, Variant};
use crate::Error;
use crate::bench::{Backend, Timed};
use crate::prepare::{PreparedScene, prepare};
use crate::render::RenderError;
use crate::render::gpu::{Adapter, signature};
use std::collections::BTreeMap;

/// Told what is done, and the fraction of it.
pub type Progress<'a> = &'a dyn Fn(String, f64);

/// What a sweep renders with.
pub struct Devices<'a> {
    /// The GPU, if any, beside the CPU.
    pub adapter: Option<&'a Adapter>,
}

impl Devices<'_> {
    /// What it renders with: the CPU if `with_cpu`, and whatever the adapter takes.
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

    /// Whether the exact shaders give the CPU's words.
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

/// Measures the variants of the header's shard that `store` has not, and adds
/// each to it; returns how many there were. Each is timed in turn with one
/// reference of its class, so that those of other runs and machines can be
/// compared with it.
///
/// # Errors
/// [`Error`] where a file is missing, or a device fails; what is in `store`
/// stays. A variant that cannot be drawn is none: it is left out, with the reason.
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
    let subject = at_depths(subject, &finest);
    let judge = Judge::new(&finest)?;

    progress("preparing the reference".to_string(), start);
    let reference_scene = prepare(&reference(&subject).apply(&subject), &|_| ())?;
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
        // The renderers of the same settings come one after the other.
        if prepared
            .as_ref()
            .is_none_or(|(settings, _)| *settings != variant.settings)
        {
            prepared = Some((variant.settings, prepare_variant(&subject, variant)?));
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
                            &judge,
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

/// The variants of the header's shard.
pub(super) fn own_variants(subject: &Subject, header: &Header) -> Vec<Variant> {
    part(&all_variants(subject, header), header.shard)
}

/// The variants of all shards.
pub(super) fn all_variants(subject: &Subject, header: &Header) -> Vec<Variant> {
    let grid: Grid = header.grid;
    variants(subject, grid, &header.renderings)
}

/// The subject with the depth of the truth where the accurate tier clamps it:
/// every tier draws the same.
fn at_depths(subject: &Subject, finest: &Finest) -> Subject {
    let mut subject = subject.clone();
    if finest.folded.is_none() {
        for (object, depth) in subject.scene.objects.iter_mut().zip(finest.depths()) {
            if object.clamp_depth {
                object.depth = Some(depth);
            }
        }
    }
    subject
}

/// The scene of `variant`, or why there is none.
fn prepare_variant(
    subject: &Subject,
    variant: &Variant,
) -> Result<Result<PreparedScene, String>, Error> {
    match prepare(&variant.settings.apply(subject), &|_| ()) {
        Ok(scene) => Ok(Ok(scene)),
        Err(Error::Object { name, problem, .. }) => Ok(Err(format!("object {name:?}: {problem}"))),
        Err(error) => Err(error),
    }
}

/// What the records of `store` say of the pictures of `own`.
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
