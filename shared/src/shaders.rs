//! The list of searches: which model draws which tiers, and by which shaders.
//!
//! The shader entry points, the host's table of modules, the CPU renderer's
//! dispatch and the names of tiers follow from `for_each_search!`.

use crate::layout::SEARCH_RELIEF;

/// Calls the macro `$with`, after the tokens `$before`, with every search:
///
/// ```text
/// SEARCH_ constant: model over facets given FACT draws color shadow geometry surface hit
///     tiers { /// doc
///             Name TIER_ constant "name" steps bisections; … }
///     special { facts => model over facets through words draws color shadow geometry surface hit; … }
/// ```
///
/// `color`, `shadow` (colour with self-shadows), `geometry` and `surface` (the G-buffer)
/// are fragment entry points for any object of the search; `hit` is the entry point that exports
/// turn into a function. If FACT is given, it must hold for the object.
/// Those of `special` contain only the code for objects for which the
/// `facts` hold (see [`facts`](crate::facts)), most facts first. Those `through Stacked` draw
/// [stacks](crate::stack), which no others can. Callers import the
/// names that they use: constants of `layout` and `facts`, models of `model`.
#[macro_export]
macro_rules! for_each_search {
    ($with:ident $($before:tt)*) => {
        $with! { $($before)*
            SEARCH_EXTRUSION: Quadric over Triangle
                draws color_extrusion color_extrusion_shadow geometry_extrusion surface_extrusion hit_extrusion
                tiers {
                    /// Flat: extrusion mapping without silhouettes.
                    Planar TIER_PLANAR "planar" 96 8;
                    /// Along the local quadric, with facet depth.
                    Fast TIER_FAST "fast" 96 8;
                }
                special {
                    LAYERED => Quadric over Triangle through Stacked
                        draws color_layers color_layers_shadow geometry_layers surface_layers hit_layers;
                    PLANAR | UPRIGHT | CODES => Flat over PlanarTriangle
                        draws color_planar color_planar_shadow geometry_planar surface_planar hit_planar;
                    PLANAR | STRAIGHT | CODES => Flat over PlanarTriangle
                        draws color_planar_growing color_planar_growing_shadow geometry_planar_growing surface_planar_growing hit_planar_growing;
                    CURVED | UPRIGHT | CODES => Quadric over Triangle
                        draws color_curved color_curved_shadow geometry_curved surface_curved hit_curved;
                    CURVED | STRAIGHT | CODES => Quadric over Triangle
                        draws color_curved_growing color_curved_growing_shadow geometry_curved_growing surface_curved_growing hit_curved_growing;
                    STRAIGHT => Quadric over Triangle
                        draws color_straight color_straight_shadow geometry_straight surface_straight hit_straight;
                }
            SEARCH_RELIEF: Relief over Triangle given STRAIGHT
                draws color_relief color_relief_shadow geometry_relief surface_relief hit_relief
                tiers {}
                special {}
            SEARCH_PAPER: Paper over Triangle given STRAIGHT
                draws color_paper color_paper_shadow geometry_paper surface_paper hit_paper
                tiers {
                    /// The paper's algorithms as printed, mistakes included.
                    Paper TIER_PAPER "paper" 25 5;
                }
                special {}
            SEARCH_PRISMS: Prisms over PrismData
                draws color_prisms color_prisms_shadow geometry_prisms surface_prisms hit_prisms
                tiers {
                    /// From prism to prism through the shell: no holes.
                    Accurate TIER_ACCURATE "accurate" 256 10;
                }
                special {
                    LAYERED => Prisms over PrismData through Stacked
                        draws color_prisms_layers color_prisms_layers_shadow geometry_prisms_layers surface_prisms_layers hit_prisms_layers;
                    STRAIGHT => Prisms over PrismData
                        draws color_prisms_straight color_prisms_straight_shadow geometry_prisms_straight surface_prisms_straight hit_prisms_straight;
                }
        }
    };
}

/// Calls the macro `$with`, after the tokens `$before`, with the facets that shaders
/// read, the compute entry point that finds an outline around each, and the vertex entry
/// point that does so for itself, for engines that draw in one pass: `Type outlines vertex;`
#[macro_export]
macro_rules! for_each_facet {
    ($with:ident $($before:tt)*) => {
        $with! { $($before)*
            Triangle outlines vertex;
            PlanarTriangle outlines_planar vertex_planar;
            PrismData outlines_prisms vertex_prisms;
        }
    };
}

/// A tier: a row of [`TIERS`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TierRow {
    /// Its `TIER_` constant.
    pub tier: u32,
    /// The `SEARCH_` constant that draws it.
    pub search: u32,
    /// Its name in scene files.
    pub name: &'static str,
    /// Steps of the linear search, and bisections after it, by default.
    pub effort: (u32, u32),
}

macro_rules! tier_rows {
    ($($search:ident: $model:ident over $facet:ident $(given $given:ident)?
        draws $color:ident $shadow:ident $geometry:ident $surface:ident $hit:ident
        tiers { $($(#[$doc:meta])* $tier:ident $code:ident $name:literal $steps:literal $bisections:literal;)* }
        special { $($special:tt)* })*) => {
        /// Every tier, in the order of the list.
        pub const TIERS: &[TierRow] = &[$($(TierRow {
            tier: crate::layout::$code,
            search: crate::layout::$search,
            name: $name,
            effort: ($steps, $bisections),
        },)*)*];
    };
}
for_each_search!(tier_rows);

/// The `SEARCH_` constant of a `TIER_` constant, or of relief mapping if
/// `is_relief`.
///
/// ```
/// use relievo_shared::layout::{SEARCH_PRISMS, SEARCH_RELIEF, TIER_ACCURATE, TIER_FAST};
/// use relievo_shared::shaders::search_of;
///
/// assert_eq!(search_of(TIER_ACCURATE, false), SEARCH_PRISMS);
/// assert_eq!(search_of(TIER_FAST, true), SEARCH_RELIEF);
/// ```
pub fn search_of(tier: u32, is_relief: bool) -> u32 {
    let row = TIERS.iter().find(|row| row.tier == tier);
    match row {
        Some(row) if !is_relief => row.search,
        _ => SEARCH_RELIEF,
    }
}
