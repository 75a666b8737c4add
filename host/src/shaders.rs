//! The compiled shaders: their files, and the entry points that draw an object.

use crate::prepare::PreparedObject;
use relievo_shared::facts::{CODES, CURVED, LAYERED, PLANAR, STRAIGHT, UPRIGHT, facts};
use relievo_shared::layout::{
    Object, PlanarTriangle, PrismData, SEARCH_EXTRUSION, SEARCH_PAPER, SEARCH_PRISMS,
    SEARCH_RELIEF, Triangle,
};
use relievo_shared::{for_each_facet, for_each_search};
use relievo_translate::constants;
use std::borrow::Cow;

/// The modules of one folder of `assets/shaders`, one for each of the entry points.
macro_rules! files {
    ($folder:literal: $($entry_point:ident)*) => {
        &[$((
            stringify!($entry_point),
            const { relievo_shaders::module(concat!($folder, "/", stringify!($entry_point))) },
        )),*]
    };
}

/// The shaders of the renderer in a folder, and `more`.
macro_rules! renderer {
    ($folder:literal [$($more:ident)*]
        $($search:ident: $model:ident over $facet:ident $(given $given:ident)?
        draws $color:ident $shadow:ident $geometry:ident $surface:ident $hit:ident
        tiers { $($tiers:tt)* }
        special { $($facts:expr => $special:ident over $special_facet:ident $(through $words:ident)?
            draws $special_color:ident $special_shadow:ident $special_geometry:ident $special_surface:ident $special_hit:ident;)* })*) => {
        files!($folder: place outlines outlines_planar outlines_prisms outlines_exits exits
            screen shade mean shade_edges
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
        special { $($facts:expr => $special:ident over $special_facet:ident $(through $words:ident)?
            draws $special_color:ident $special_shadow:ident $special_geometry:ident $special_surface:ident $special_hit:ident;)* })*) => {
        files!("relievo_fast": $($hit $($special_hit)*)*)
    };
}

#[cfg(all(feature = "gpu", not(target_arch = "wasm32")))]
pub(crate) use {files, renderer};

/// Compiled modules: the entry point of each, and its bytes.
pub(crate) type Files = &'static [(&'static str, &'static [u8])];
/// The freely optimised shaders of the renderer, with the vertex shaders of exports.
pub(crate) static FAST: Files =
    for_each_search!(renderer "relievo_fast" [vertex vertex_planar vertex_prisms]);
/// The shaders that exports turn into functions.
#[cfg(not(target_arch = "wasm32"))]
pub(crate) static HITS: Files = for_each_search!(hits);
/// Modules that browsers do not need are left out there.
#[cfg(target_arch = "wasm32")]
pub(crate) static HITS: Files = &[];

/// Returns the words of the module with an entry point, whose specialization constants have their
/// own values; `None` if it is not built in.
pub(crate) fn words(files: Files, entry_point: &str) -> Option<Vec<u32>> {
    let (_, bytes) = files.iter().find(|(name, _)| *name == entry_point)?;
    let (words, _) = bytes.as_chunks::<4>();
    let words: Vec<u32> = words.iter().copied().map(u32::from_le_bytes).collect();
    Some(constants::set(&words, &[]).into_owned())
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
pub(crate) struct Special {
    search: u32,
    facts: u32,
    facets: Facets,
    pub(crate) color: &'static str,
    pub(crate) shadow: &'static str,
    pub(crate) geometry: &'static str,
    pub(crate) surface: &'static str,
    hit: &'static str,
    asks_for_exits: bool,
}

/// A [`Special`] for each pair of a search and facts, most facts first.
macro_rules! special {
    ($($search:ident: $model:ident over $facet:ident $(given $given:ident)?
        draws $color:ident $shadow:ident $geometry:ident $surface:ident $hit:ident
        tiers { $($tiers:tt)* }
        special { $($facts:expr => $special:ident over $special_facet:ident $(through $words:ident)?
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

pub(crate) static SPECIAL: &[Special] = for_each_search!(special);

impl EntryPoints {
    /// Returns the shaders for an object with these parameters.
    pub fn of(object: &Object, extent: Extent) -> EntryPoints {
        let facts = facts(object);
        let mut all = SPECIAL.iter().filter(|special| {
            special.search == object.search
                && special.facts & !facts == 0
                && special.facts & LAYERED == facts & LAYERED
        });
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
    #[cfg(feature = "gpu")]
    pub(crate) fn writes_exits(&self, object: &Object) -> bool {
        self.asks_for_exits && object.number != 0
    }
}

/// Returns the facets of `object` as the bytes that shaders read.
pub(crate) fn facet_bytes(object: &PreparedObject, facets: Facets) -> Cow<'_, [u8]> {
    match facets {
        Facets::Triangles => bytemuck::cast_slice(&object.triangles).into(),
        Facets::PlanarTriangles => {
            let planar: Vec<PlanarTriangle> =
                object.triangles.iter().map(PlanarTriangle::from).collect();
            bytemuck::cast_slice::<_, u8>(&planar).to_vec().into()
        }
        Facets::Prisms => bytemuck::cast_slice(&object.prisms).into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_function_is_there() {
        for special in SPECIAL {
            let words = words(HITS, special.hit).expect(special.hit);
            assert!(words.len() > 500, "{}", special.hit);
        }
    }
}
