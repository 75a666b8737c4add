//! Selects modules of compiled shaders: those that are exact on a device.

use crate::render::RenderError;
use crate::shaders::{FAST, Files};
#[cfg(not(target_arch = "wasm32"))]
use crate::shaders::{files, renderer};
use relievo_bitwise::{Canary, Device, Module, Runner, Signature};
use relievo_kernel::canary::MEANINGS;
use relievo_kernel::{Kernel, for_each_canary, table};
#[cfg(not(target_arch = "wasm32"))]
use relievo_shared::for_each_search;
use std::sync::LazyLock;

/// The exact, the fused and the fast file of each kernel of a list.
#[cfg(not(target_arch = "wasm32"))]
macro_rules! kernel_files {
    ($($name:ident($($arguments:tt)*) -> $result:ty = $function:expr;)*) => {
        (
            files!("kernels_exact": $($name)*),
            files!("kernels_fused": $($name)*),
            files!("kernels_fast": $($name)*),
        )
    };
}

#[cfg(not(target_arch = "wasm32"))]
static EXACT: Files = for_each_search!(renderer "relievo_exact" []);
#[cfg(not(target_arch = "wasm32"))]
static FUSED: Files = for_each_search!(renderer "relievo_fused" []);
#[cfg(not(target_arch = "wasm32"))]
static KERNELS: (Files, Files, Files) = relievo_shared::for_each_kernel!(kernel_files);
#[cfg(not(target_arch = "wasm32"))]
static CANARY_KERNELS: (Files, Files, Files) = for_each_canary!(kernel_files);

// Browsers do not take SPIR-V unchanged: modules for Vulkan only are left out there.
#[cfg(target_arch = "wasm32")]
static EXACT: Files = &[];
#[cfg(target_arch = "wasm32")]
static FUSED: Files = &[];
#[cfg(target_arch = "wasm32")]
static KERNELS: (Files, Files, Files) = (&[], &[], &[]);
#[cfg(target_arch = "wasm32")]
static CANARY_KERNELS: (Files, Files, Files) = (&[], &[], &[]);

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
    /// The same with fewer instructions, for devices that fuse sums: the canary `fused`
    /// tells. Vulkan only.
    Fused,
    /// The freely optimised module, untouched. Vulkan only.
    Fast,
    /// The freely optimised module through naga, which every backend of wgpu takes.
    Portable,
}

impl Shaders {
    /// Every one.
    pub const ALL: [Shaders; 4] = [
        Shaders::Exact,
        Shaders::Fused,
        Shaders::Fast,
        Shaders::Portable,
    ];

    /// Returns the name shown to users.
    pub fn describe(self) -> &'static str {
        match self {
            Shaders::Exact => "exact shaders",
            Shaders::Fused => "exact shaders with fused sums",
            Shaders::Fast => "fast shaders",
            Shaders::Portable => "portable shaders",
        }
    }

    /// Whether the driver must take SPIR-V untouched.
    pub fn is_untouched(self) -> bool {
        self != Shaders::Portable
    }

    /// Whether its words must be the CPU's.
    pub fn is_exact(self) -> bool {
        matches!(self, Shaders::Exact | Shaders::Fused)
    }

    /// Whether a device with this signature can give the results that the shaders promise.
    pub fn suit(self, signature: &Signature) -> bool {
        match self {
            Shaders::Exact => signature.is_exact(),
            Shaders::Fused => signature.is_exact() && signature.passes("fused"),
            Shaders::Fast | Shaders::Portable => true,
        }
    }

    /// The renderer's module.
    ///
    /// # Errors
    /// [`RenderError::Device`] if a built-in file is not a SPIR-V module.
    pub fn module(self) -> Result<Module, RenderError> {
        self.choose((EXACT, FUSED, FAST))
    }

    /// The module of the functions that are compared one by one.
    ///
    /// # Errors
    /// As [`Shaders::module`].
    pub fn kernels(self) -> Result<Module, RenderError> {
        self.choose(KERNELS)
    }

    fn choose(self, (exact, fused, fast): (Files, Files, Files)) -> Result<Module, RenderError> {
        let bytes = |files: Files| files.iter().map(|(_, bytes)| *bytes).collect::<Vec<_>>();
        // SAFETY: the builder has validated the modules, and `shared` keeps
        // its indices within the buffers that the host binds.
        Ok(unsafe {
            match self {
                Shaders::Exact => Module::untouched(&bytes(exact))?,
                Shaders::Fused => Module::untouched(&bytes(fused))?,
                Shaders::Fast => Module::untouched(&bytes(fast))?,
                Shaders::Portable => Module::portable(&bytes(fast))?,
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
    /// The fast ones, or the portable ones where the device takes no SPIR-V:
    /// for pictures that need not be the CPU's word for word.
    Fastest,
    /// These.
    These(Shaders),
}

impl Choice {
    /// The shaders for `device`.
    ///
    /// # Errors
    /// [`RenderError::Device`] where it fails at the canaries.
    pub fn on(self, device: &Device) -> Result<Shaders, RenderError> {
        match self {
            Choice::These(shaders) => Ok(shaders),
            Choice::Trusted | Choice::Fastest if !device.takes_spirv() => Ok(Shaders::Portable),
            Choice::Fastest => Ok(Shaders::Fast),
            Choice::Trusted => Ok(trusted(device.describe(), &signature(device)?)),
        }
    }
}

/// The shaders for a device of this name and signature that takes SPIR-V.
fn trusted(device: &str, signature: &Signature) -> Shaders {
    if Shaders::Fused.suit(signature) {
        Shaders::Fused
    } else if Shaders::Exact.suit(signature) {
        Shaders::Exact
    } else {
        log::warn!(
            "{device} is not exact, its words may differ from the CPU's, and the fast shaders are used: {}",
            signature.describe()
        );
        Shaders::Fast
    }
}

/// Returns the canaries that decide whether a device gets the exact shaders.
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

/// The specialization constant that is 1 in shaders of copies that are drawn at once.
pub(super) const HAS_COPIES: u32 = 0;

/// The vertex shader that places outlines.
pub(super) const PLACE: &str = "place";
/// The fragment shader that writes exits, and the compute shader of their outlines.
pub(super) const EXITS: [&str; 2] = ["exits", "outlines_exits"];

/// The vertex shader that covers the picture.
pub(super) const SCREEN: &str = "screen";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shaders::SPECIAL;
    use naga::valid::{Capabilities, ValidationFlags, Validator};
    use naga::{Block, Statement};
    use relievo_bitwise::Told;
    use relievo_translate::portable;

    #[test]
    fn every_canary_has_its_meaning() {
        for (canary, meaning) in CANARIES.iter().zip(MEANINGS) {
            assert_eq!(canary.kernel.name, meaning.name);
        }
        assert_eq!(CANARIES.len(), MEANINGS.len());
    }

    #[test]
    fn every_special_shader_is_there() {
        for shaders in [Shaders::Exact, Shaders::Fused, Shaders::Fast] {
            let module = shaders.module().unwrap();
            for special in SPECIAL {
                for name in [
                    special.color,
                    special.shadow,
                    special.geometry,
                    special.surface,
                ] {
                    assert!(module.instructions(name) > Some(500), "{name}");
                }
            }
        }
    }

    /// Loops in a block that end in something naga writes wrongly.
    fn tails(block: &Block) -> usize {
        let count = |statement: &Statement| match statement {
            Statement::Block(inner) => tails(inner),
            Statement::If { accept, reject, .. } => tails(accept) + tails(reject),
            Statement::Switch { cases, .. } => cases.iter().map(|case| tails(&case.body)).sum(),
            Statement::Loop {
                body,
                continuing,
                break_if,
            } => {
                let own = break_if.is_some() || !continuing.is_empty();
                usize::from(own) + tails(body) + tails(continuing)
            }
            _ => 0,
        };
        block.iter().map(count).sum()
    }

    /// The loops of [`tails`] in everything of a module.
    fn all_tails(module: &naga::Module) -> usize {
        let functions = module.functions.iter().map(|(_, function)| function);
        let entry_points = module.entry_points.iter().map(|entry| &entry.function);
        let bodies = functions.chain(entry_points).map(|function| &function.body);
        bodies.map(tails).sum()
    }

    #[test]
    fn portable_shaders_have_no_loops_that_naga_writes_wrongly() {
        let modules = [Shaders::Portable.module(), Shaders::Portable.kernels()];
        for module in modules.map(|module| module.unwrap()) {
            let mut before = 0;
            for entry_point in module.entry_points() {
                let name = &entry_point.name;
                let words = module.spirv(name).unwrap();
                before += all_tails(&portable::read(&words).unwrap());
                let given = module.translated(name).unwrap();
                assert_eq!(all_tails(&given), 0, "{name}");
                // Nothing that is optional in WebGPU.
                let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
                let valid = validator.validate(&given);
                assert!(valid.is_ok(), "{name}: {valid:?}");
            }
            println!("{before} loops rewritten");
            assert!(before > 0);
        }
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
        assert_eq!(trusted("a device", &signature("")), Shaders::Fused);
        assert_eq!(trusted("a device", &signature("fused")), Shaders::Exact);
        assert_eq!(trusted("a device", &signature("denormal")), Shaders::Fused);
        assert_eq!(
            trusted("a device", &signature("multiply_add")),
            Shaders::Fast
        );
    }
}
