//! The compiled shaders: which modules there are, which of them a device can be
//! trusted with, and which entry point draws what.

use crate::render::RenderError;
use relievo_bitwise::{Canary, Device, Module, Runner, Signature};
use relievo_kernel::canary::{self, MEANINGS};
use relievo_kernel::{Kernel, for_each_canary, table};
use relievo_shared::Vec3;
use relievo_shared::for_each_kernel;
use relievo_shared::layout::{Object, SEARCH_PAPER, SEARCH_PRISMS, SEARCH_RELIEF};
use std::sync::LazyLock;

/// The files of one folder of `assets/shaders` (see the manifest there), one for
/// each of the entry points.
macro_rules! files {
    ($folder:literal: $($entry_point:ident)*) => {
        &[$(include_bytes!(concat!(
            "../../../../assets/shaders/",
            $folder,
            "/",
            stringify!($entry_point),
            ".spv"
        ))),*]
    };
}

macro_rules! renderer {
    ($folder:literal) => {
        files!($folder: vertex vertex_prisms
            color_extrusion color_extrusion_shadow
            color_relief color_relief_shadow
            color_paper color_paper_shadow
            color_prisms color_prisms_shadow
            geometry_extrusion geometry_relief geometry_paper geometry_prisms)
    };
}

/// The exact and the fast file of each kernel of a list.
macro_rules! kernel_files {
    ($($name:ident($($arguments:tt)*) -> $result:ty = $function:expr;)*) => {
        (
            files!("kernels_exact": $($name)*),
            files!("kernels_fast": $($name)*),
        )
    };
}

type Files = &'static [&'static [u8]];
static EXACT: Files = renderer!("relievo_exact");
static FAST: Files = renderer!("relievo_fast");
static KERNELS: (Files, Files) = for_each_kernel!(kernel_files);
static CANARY_KERNELS: (Files, Files) = for_each_canary!(kernel_files);

/// The shader that places an object's triangles, or its prisms.
pub(super) fn vertex_entry_point(object: &Object) -> &'static str {
    match object.search {
        SEARCH_PRISMS => "vertex_prisms",
        _ => "vertex",
    }
}

/// Every canary, with its meaning.
static CANARIES: LazyLock<Vec<Canary>> = LazyLock::new(|| {
    const LIST: &[Kernel] = for_each_canary!(table);
    LIST.iter()
        .zip(MEANINGS)
        .map(|(&kernel, meaning)| Canary {
            kernel,
            required: meaning.required,
            tells: meaning.tells,
        })
        .collect()
});

/// Which module is used, and how it reaches the driver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shaders {
    /// The exact module, untouched: the CPU's words. Vulkan only.
    Exact,
    /// The freely optimised module, untouched. Vulkan only.
    Fast,
    /// The freely optimised module through naga, which every backend of wgpu takes.
    Portable,
}

impl Shaders {
    /// Every one.
    pub const ALL: [Shaders; 3] = [Shaders::Exact, Shaders::Fast, Shaders::Portable];

    /// What a person calls it.
    pub fn describe(self) -> &'static str {
        match self {
            Shaders::Exact => "exact shaders",
            Shaders::Fast => "fast shaders",
            Shaders::Portable => "portable shaders",
        }
    }

    /// Whether the driver must take SPIR-V untouched.
    pub fn is_untouched(self) -> bool {
        self != Shaders::Portable
    }

    /// The renderer's module.
    ///
    /// # Errors
    /// [`RenderError::Device`] where a file built in is no module.
    pub fn module(self) -> Result<Module, RenderError> {
        self.choose((EXACT, FAST))
    }

    /// The module of the functions that are compared one by one.
    ///
    /// # Errors
    /// As [`Shaders::module`].
    pub fn kernels(self) -> Result<Module, RenderError> {
        self.choose(KERNELS)
    }

    fn choose(self, (exact, fast): (Files, Files)) -> Result<Module, RenderError> {
        // SAFETY: the builder has validated the modules, and `shared` keeps
        // its indices within the buffers that the host binds.
        Ok(unsafe {
            match self {
                Shaders::Exact => Module::untouched(exact)?,
                Shaders::Fast => Module::untouched(fast)?,
                Shaders::Portable => Module::portable(fast)?,
            }
        })
    }
}

/// How to choose the shaders.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Choice {
    /// The exact ones where the device passes the canaries, else the fast or
    /// the portable ones.
    Trusted,
    /// These.
    These(Shaders),
}

impl Choice {
    /// The shaders for `device`.
    pub(super) fn on(self, device: &Device) -> Result<Shaders, RenderError> {
        match self {
            Choice::These(shaders) => Ok(shaders),
            Choice::Trusted if !device.takes_spirv() => Ok(Shaders::Portable),
            Choice::Trusted => Ok(trusted(device.describe(), &signature(device)?)),
        }
    }
}

/// The shaders for a device of this name and signature that takes SPIR-V.
fn trusted(device: &str, signature: &Signature) -> Shaders {
    if signature.is_exact() {
        Shaders::Exact
    } else {
        tracing::warn!(
            "{device} is not exact, its words may differ from the CPU's, and the fast shaders are used: {}",
            signature.describe()
        );
        Shaders::Fast
    }
}

/// What is asked of a device before it is trusted with the exact shaders.
pub fn canaries() -> &'static [Canary] {
    &CANARIES
}

/// Runs the canaries, with the exact module, on `device`.
///
/// # Errors
/// [`RenderError::Device`] where it takes no SPIR-V or fails.
pub fn signature(device: &Device) -> Result<Signature, RenderError> {
    let module = Shaders::Exact.choose(CANARY_KERNELS)?;
    let mut runner = Runner::new(device, &module)?;
    Ok(Signature::take(&mut runner, &CANARIES)?)
}

/// The shader that draws the colours of an object with these parameters.
pub(super) fn color_entry_point(object: &Object) -> &'static str {
    match (object.search, object.self_shadow != 0) {
        (SEARCH_PAPER, false) => "color_paper",
        (SEARCH_PAPER, true) => "color_paper_shadow",
        (SEARCH_RELIEF, false) => "color_relief",
        (SEARCH_RELIEF, true) => "color_relief_shadow",
        (SEARCH_PRISMS, false) => "color_prisms",
        (SEARCH_PRISMS, true) => "color_prisms_shadow",
        (_, false) => "color_extrusion",
        (_, true) => "color_extrusion_shadow",
    }
}

/// The shader that draws the geometry of an object with these parameters.
pub(super) fn geometry_entry_point(object: &Object) -> &'static str {
    match object.search {
        SEARCH_PAPER => "geometry_paper",
        SEARCH_RELIEF => "geometry_relief",
        SEARCH_PRISMS => "geometry_prisms",
        _ => "geometry_extrusion",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use relievo_bitwise::Told;

    #[test]
    fn every_canary_has_its_meaning() {
        for (canary, meaning) in CANARIES.iter().zip(MEANINGS) {
            assert_eq!(canary.kernel.name, meaning.name);
        }
        assert_eq!(CANARIES.len(), MEANINGS.len());
    }

    #[test]
    fn a_device_that_fails_a_required_canary_gets_the_fast_shaders() {
        let signature = |different: &str| Signature {
            told: MEANINGS
                .iter()
                .map(|meaning| Told {
                    name: meaning.name,
                    required: meaning.required,
                    tells: meaning.tells,
                    words: 100,
                    different: if meaning.name == different { 3 } else { 0 },
                })
                .collect(),
        };
        assert_eq!(trusted("a device", &signature("")), Shaders::Exact);
        assert_eq!(trusted("a device", &signature("denormal")), Shaders::Exact);
        assert_eq!(
            trusted("a device", &signature("multiply_add")),
            Shaders::Fast
        );
    }
}
