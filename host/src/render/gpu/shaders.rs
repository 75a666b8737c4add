//! Selects compiled shaders: the modules, those that are exact on a device, and the
//! entry points that draw an object.

use crate::render::RenderError;
use relievo_bitwise::{Canary, Device, Module, Runner, Signature};
use relievo_kernel::canary::MEANINGS;
use relievo_kernel::{Kernel, for_each_canary, table};
use relievo_shared::facts::{CODES, CURVED, PLANAR, STRAIGHT, UPRIGHT, facts};
use relievo_shared::layout::{
    Object, PlanarTriangle, PrismData, SEARCH_EXTRUSION, SEARCH_PAPER, SEARCH_PRISMS,
    SEARCH_RELIEF, Triangle,
};
use relievo_shared::{for_each_facet, for_each_search};
use std::sync::LazyLock;

/// The modules of one folder of `assets/shaders`, one for each of the entry points.
macro_rules! files {
    ($folder:literal: $($entry_point:ident)*) => {
        &[$(const { relievo_shaders::module(concat!($folder, "/", stringify!($entry_point))) }),*]
    };
}

/// The shaders of the renderer in a folder, and `more`.
macro_rules! renderer {
    ($folder:literal [$($more:ident)*]
        $($search:ident: $model:ident over $facet:ident $(given $given:ident)?
        draws $color:ident $shadow:ident $geometry:ident $surface:ident $hit:ident
        tiers { $($tiers:tt)* }
        special { $($facts:expr => $special:ident over $special_facet:ident
            draws $special_color:ident $special_shadow:ident $special_geometry:ident $special_surface:ident $special_hit:ident;)* })*) => {
        files!($folder: place outlines outlines_planar outlines_prisms outlines_exits exits
            screen shade shade_edges
            $($more)*
            $($color $shadow $geometry $surface
                $($special_color $special_shadow $special_geometry $special_surface)*)*)
    };
}

/// The shaders that exports turn into functions.
#[cfg(not(target_arch = "wasm32"))]
macro_rules! hits {
    ($($search:ident: $model:ident over $facet:ident $(given $given:ident)?
        draws $color:ident $shadow:ident $geometry:ident $surface:ident $hit:ident
        tiers { $($tiers:tt)* }
        special { $($facts:expr => $special:ident over $special_facet:ident
            draws $special_color:ident $special_shadow:ident $special_geometry:ident $special_surface:ident $special_hit:ident;)* })*) => {
        files!("relievo_fast": $($hit $($special_hit)*)*)
    };
}

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

type Files = &'static [&'static [u8]];
#[cfg(not(target_arch = "wasm32"))]
static EXACT: Files = for_each_search!(renderer "relievo_exact" []);
#[cfg(not(target_arch = "wasm32"))]
static FUSED: Files = for_each_search!(renderer "relievo_fused" []);
// With the vertex shaders of exports.
static FAST: Files = for_each_search!(renderer "relievo_fast" [vertex vertex_planar vertex_prisms]);
#[cfg(not(target_arch = "wasm32"))]
static HITS: Files = for_each_search!(hits);
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
static HITS: Files = &[];
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

    /// The shaders that exports turn into functions, for every backend of wgpu.
    ///
    /// # Errors
    /// As [`Shaders::module`].
    pub(crate) fn hits() -> Result<Module, RenderError> {
        Ok(Module::portable(HITS)?)
    }

    fn choose(self, (exact, fused, fast): (Files, Files, Files)) -> Result<Module, RenderError> {
        // SAFETY: the builder has validated the modules, and `shared` keeps
        // its indices within the buffers that the host binds.
        Ok(unsafe {
            match self {
                Shaders::Exact => Module::untouched(exact)?,
                Shaders::Fused => Module::untouched(fused)?,
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
        tracing::warn!(
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

/// Features that an object's shaders contain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// As few as possible: the most specialised shaders that draw the object.
    Needed,
    /// Everything that any object with the same search may need. The words are
    /// the same.
    Everything,
}

/// Type of the facets that shaders read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Facets {
    /// [`Triangle`]s.
    Triangles,
    /// [`PlanarTriangle`]s.
    PlanarTriangles,
    /// [`PrismData`]s.
    Prisms,
}

/// The [`Facets`] of a layout.
macro_rules! facets {
    (Triangle) => {
        Facets::Triangles
    };
    (PlanarTriangle) => {
        Facets::PlanarTriangles
    };
    (PrismData) => {
        Facets::Prisms
    };
}

impl Facets {
    /// Bytes of one.
    pub fn bytes(self) -> usize {
        match self {
            Facets::Triangles => size_of::<Triangle>(),
            Facets::PlanarTriangles => size_of::<PlanarTriangle>(),
            Facets::Prisms => size_of::<PrismData>(),
        }
    }

    /// The compute shader that finds their outlines, and the vertex shader of exports.
    fn shaders(self) -> [&'static str; 2] {
        macro_rules! shaders {
            ($($facet:ident $outlines:ident $vertex:ident;)*) => {
                match self {
                    $(facets!($facet) => [stringify!($outlines), stringify!($vertex)],)*
                }
            };
        }
        for_each_facet!(shaders)
    }
}

/// The shaders that draw an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EntryPoints {
    /// Type of the facets that they read.
    pub facets: Facets,
    /// Compute shader that finds the outlines of the facets, which the vertex shader `place` draws.
    pub outlines: &'static str,
    /// Vertex shader that does both at once, in exports.
    pub vertex: &'static str,
    /// Draws its colours.
    pub color: &'static str,
    /// Draws its geometry.
    pub geometry: &'static str,
    /// Draws its part of the G-buffer.
    pub surface: &'static str,
    /// Finds what a ray hits, in exports.
    pub hit: &'static str,
    /// Whether both ask for the exits of rays, a picture that must be bound.
    pub asks_for_exits: bool,
}

/// The specialization constant that is 1 in shaders of copies that are drawn at once.
pub(super) const HAS_COPIES: u32 = 0;

/// The vertex shader that places outlines.
pub(super) const PLACE: &str = "place";
/// The fragment shader that writes exits, and the compute shader of their outlines.
pub(super) const EXITS: [&str; 2] = ["exits", "outlines_exits"];

/// The vertex shader that covers the picture.
pub(super) const SCREEN: &str = "screen";

/// Returns the fragment shader that shades the G-buffer.
pub(crate) fn shade_of(has_smooth_edges: bool) -> &'static str {
    match has_smooth_edges {
        true => "shade_edges",
        false => "shade",
    }
}

/// Whether a model asks for exits.
macro_rules! asks_for_exits {
    (Quadric) => {
        true
    };
    ($model:ident) => {
        false
    };
}

/// The fragment shaders of a search, and what must be true of an object that
/// they draw (`relievo_shared::facts`).
struct Special {
    search: u32,
    facts: u32,
    facets: Facets,
    color: &'static str,
    shadow: &'static str,
    geometry: &'static str,
    surface: &'static str,
    hit: &'static str,
    asks_for_exits: bool,
}

/// A [`Special`] for each pair of a search and facts, most facts first.
macro_rules! special {
    ($($search:ident: $model:ident over $facet:ident $(given $given:ident)?
        draws $color:ident $shadow:ident $geometry:ident $surface:ident $hit:ident
        tiers { $($tiers:tt)* }
        special { $($facts:expr => $special:ident over $special_facet:ident
            draws $special_color:ident $special_shadow:ident $special_geometry:ident $special_surface:ident $special_hit:ident;)* })*) => {
        &[$(
            $(Special {
                search: $search,
                facts: $facts,
                facets: facets!($special_facet),
                color: stringify!($special_color),
                shadow: stringify!($special_shadow),
                geometry: stringify!($special_geometry),
                surface: stringify!($special_surface),
                hit: stringify!($special_hit),
                asks_for_exits: asks_for_exits!($special),
            },)*
            Special {
                search: $search,
                facts: 0 $(| $given)?,
                facets: facets!($facet),
                color: stringify!($color),
                shadow: stringify!($shadow),
                geometry: stringify!($geometry),
                surface: stringify!($surface),
                hit: stringify!($hit),
                asks_for_exits: asks_for_exits!($model),
            },
        )*]
    };
}

static SPECIAL: &[Special] = for_each_search!(special);

impl EntryPoints {
    /// Returns the shaders for an object with these parameters.
    pub fn of(object: &Object, extent: Extent) -> EntryPoints {
        let facts = facts(object);
        let mut all = SPECIAL
            .iter()
            .filter(|special| special.search == object.search && special.facts & !facts == 0);
        let special = match extent {
            Extent::Needed => all.next(),
            Extent::Everything => all.next_back(),
        }
        .expect("each search has shaders for all of its objects");
        let [outlines, vertex] = special.facets.shaders();
        EntryPoints {
            facets: special.facets,
            outlines,
            vertex,
            color: if object.self_shadow == 0 {
                special.color
            } else {
                special.shadow
            },
            geometry: special.geometry,
            surface: special.surface,
            hit: special.hit,
            asks_for_exits: special.asks_for_exits,
        }
    }

    /// Returns whether the exits of `object`, which they draw, are written.
    pub(super) fn writes_exits(&self, object: &Object) -> bool {
        self.asks_for_exits && object.number != 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
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
