//! Compiles a variant of a shader crate.

use crate::packages::Packages;
use crate::refusal::Refusals;
use crate::rust_gpu::{self, Modules};
use crate::shader_crate::{ShaderCrate, Variant};
use crate::{arms, exact, loops, words};
use anyhow::{Context, Result};

/// Compiles a variant.
///
/// # Errors
///
/// If rust-gpu does not compile the crate, or with [`Refusals`] if it is not exact.
pub fn compile(shaders: &ShaderCrate, variant: Variant) -> Result<Modules> {
    finish(shaders, variant, rust_gpu::run(shaders, variant)?)
}

/// Finishes the `modules` that rust-gpu has made: makes them exact, and checks them.
///
/// # Errors
///
/// [`Refusals`] if they are not exact.
pub fn finish(shaders: &ShaderCrate, variant: Variant, modules: Modules) -> Result<Modules> {
    let mut modules = modules;
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
