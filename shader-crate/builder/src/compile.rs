//! Compiles a variant of a shader crate.

use crate::packages::Packages;
use crate::refusal::Refusals;
use crate::shader_crate::{ShaderCrate, Variant};
use crate::{arms, exact, loops, rust_gpu, words};
use anyhow::{Context, Result};
use std::collections::BTreeMap;

/// Compiles a variant. Returns the words of one module for each entry point, since
/// drivers read the whole module for every pipeline.
///
/// # Errors
///
/// If rust-gpu does not compile the crate, or with [`Refusals`] if it is not exact.
pub fn compile(shaders: &ShaderCrate, variant: Variant) -> Result<BTreeMap<String, Vec<u32>>> {
    let mut modules = rust_gpu::run(shaders, variant)?;
    if variant != Variant::Fast {
        let packages = Packages::of(&shaders.folder)?;
        let mut refusals = Refusals::default();
        for (entry_point, words) in &mut modules {
            *words = exact::make(entry_point, words, &packages, &mut refusals)
                .with_context(|| format!("the {} module of {entry_point}", variant.name()))?;
        }
        refusals.into_result()?;
    }
    for (entry_point, words) in &mut modules {
        *words = loops::leave_at_head(&arms::remove_empty(words)?)?;
        words::validate(words)
            .with_context(|| format!("the {} module of {entry_point}", variant.name()))?;
    }
    Ok(modules)
}
