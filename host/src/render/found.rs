//! Hits of any model of the surface: the list of searches, for the CPU renderer.

use crate::prepare::PreparedObject;
use glam::{UVec4, Vec3};
use relievo_shared::camera::reversed_depth;
use relievo_shared::exit::Exits;
use relievo_shared::layout::{
    PrismData, SEARCH_EXTRUSION, SEARCH_PAPER, SEARCH_PRISMS, SEARCH_RELIEF, Triangle,
};
use relievo_shared::model::prisms::Home;
use relievo_shared::model::{Hit, Model, Paper, Place, Prisms, Quadric, Ray, Relief, Traced};
use relievo_shared::profile::LAYERED;
use relievo_shared::shape_map::Texels;
use relievo_shared::stack::Stacked;
use relievo_shared::{far, for_each_search, gbuffer, trace};

/// A type of facets that models are drawn over.
pub(super) trait Facet {
    /// A facet as models take it.
    type Over<'a>;
    /// Calls `run` with facet `index` of `object`.
    fn over<R>(object: &PreparedObject, index: u32, run: impl FnOnce(&Self::Over<'_>) -> R) -> R;
}

impl Facet for Triangle {
    type Over<'a> = Triangle;

    #[inline]
    fn over<R>(object: &PreparedObject, index: u32, run: impl FnOnce(&Triangle) -> R) -> R {
        run(&object.triangles[index as usize])
    }
}

impl Facet for PrismData {
    type Over<'a> = Home<&'a [PrismData]>;

    #[inline]
    fn over<R>(
        object: &PreparedObject,
        index: u32,
        run: impl FnOnce(&Home<&[PrismData]>) -> R,
    ) -> R {
        run(&Home {
            prisms: &object.prisms,
            index,
        })
    }
}

/// Traces the ray over one facet, unless its hit must be behind the depth `best`. If `means` are shown, it does
/// not march where only the mean of the pattern is seen.
#[inline]
fn find<M: Model<Over>, Over, T: Texels + ?Sized>(
    ray: &Ray<'_>,
    over: &Over,
    texels: &T,
    best: f32,
    exits: &impl Exits,
    means: bool,
) -> Option<(M::Entry, Traced<M::Place>)> {
    let (meets, meeting) = M::meet(ray, over);
    if !meets {
        return None;
    }
    let (enters, entry) = M::enter(ray, over, &meeting, exits);
    let t = M::entry_t(&entry);
    // Nothing behind the entry can be nearer than the entry.
    if !enters || reversed_depth(ray.frame, ray.direction, t) < best {
        return None;
    }
    let object;
    let seen = match means && far::is_far::<M, _>(ray, t) {
        true => {
            object = far::seen::<M, _>(ray, over, &entry);
            &object
        }
        false => ray.object,
    };
    let ray = &Ray {
        object: seen,
        ..*ray
    };
    let traced = trace::trace::<M, _, _>(ray, over, texels, &entry);
    Some((entry, traced))
}

/// One type for the hits of all models of the list.
macro_rules! found {
    ($($search:ident: $model:ident over $facet:ident $(given $given:ident)?
        draws $color:ident $shadow:ident $geometry:ident $surface:ident $hit:ident
        tiers { $($tiers:tt)* }
        special { $($facts:expr => $special:ident over $special_facet:ident $(through $words:ident)?
            draws $special_color:ident $special_shadow:ident $special_geometry:ident $special_surface:ident $special_hit:ident;)* })*) => {
        /// A hit with the data to shade it.
        #[derive(Clone, Copy)]
        pub(super) enum Found {
            $($model(
                <$model as Model<<$facet as Facet>::Over<'static>>>::Entry,
                Traced<<$model as Model<<$facet as Facet>::Over<'static>>>::Place>,
            ),)*
        }

        impl Found {
            /// Traces the ray over facet `index` of `object`, unless its hit must be
            /// behind the depth `best`. See [`find`] for `means`.
            // Called for every facet on a ray, most of which it misses.
            #[inline(always)]
            pub(super) fn new(
                ray: &Ray<'_>,
                object: &PreparedObject,
                index: u32,
                best: f32,
                exits: &impl Exits,
                means: bool,
            ) -> Option<Found> {
                let texels = object.map.words();
                if is_stack(ray) {
                    return Found::in_stack(ray, object, index, best, exits, means);
                }
                match ray.object.search {
                    $($search => <$facet as Facet>::over(object, index, |over| {
                        let (entry, traced) = find::<$model, _, _>(ray, over, texels, best, exits, means)?;
                        Some(Found::$model(entry, traced))
                    }),)*
                    other => unreachable!("search {other}"),
                }
            }

            /// [`Found::new`] in a stack of layers.
            #[inline(never)]
            fn in_stack(
                ray: &Ray<'_>,
                object: &PreparedObject,
                index: u32,
                best: f32,
                exits: &impl Exits,
                means: bool,
            ) -> Option<Found> {
                let texels = object.map.words();
                match ray.object.search {
                    $($($($search => <$special_facet as Facet>::over(object, index, |over| {
                        let (entry, traced) =
                            find::<$special, _, _>(ray, over, &$words(texels), best, exits, means)?;
                        Some(Found::$special(entry, traced))
                    }),)?)*)*
                    other => unreachable!("search {other}"),
                }
            }

            /// Returns the part of the hit that all models share.
            pub(super) fn hit(&self) -> &Hit {
                match self {
                    $(Found::$model(_, traced) => &traced.hit,)*
                }
            }

            /// Number of prisms that the ray crossed.
            pub(super) fn prisms(&self) -> u32 {
                match self {
                    $(Found::$model(_, traced) => traced.place.prisms(),)*
                }
            }

            /// The unit normal that is lit.
            pub(super) fn normal(&self, ray: &Ray<'_>, object: &PreparedObject, index: u32) -> Vec3 {
                let texels = object.map.words();
                match self {
                    $($($(Found::$special(entry, traced) if is_stack(ray) => {
                        <$special_facet as Facet>::over(object, index, |over| {
                            let texels = &$words(texels);
                            trace::normals::<$special, _, _>(ray, over, texels, entry, traced).carved
                        })
                    })?)*)*
                    $(Found::$model(entry, traced) => <$facet as Facet>::over(object, index, |over| {
                        trace::normals::<$model, _, _>(ray, over, texels, entry, traced).carved
                    }),)*
                }
            }

            /// The words of the G-buffer; facet `index` was drawn.
            pub(super) fn surface(
                &self,
                ray: &Ray<'_>,
                object: &PreparedObject,
                index: u32,
            ) -> (UVec4, UVec4) {
                let texels = object.map.words();
                match self {
                    $($($(Found::$special(entry, traced) if is_stack(ray) => {
                        <$special_facet as Facet>::over(object, index, |over| {
                            let texels = &$words(texels);
                            gbuffer::words::<$special, _, _>(ray, over, texels, entry, traced, index)
                        })
                    })?)*)*
                    $(Found::$model(entry, traced) => <$facet as Facet>::over(object, index, |over| {
                        gbuffer::words::<$model, _, _>(ray, over, texels, entry, traced, index)
                    }),)*
                }
            }

            /// Linear RGB.
            pub(super) fn color(&self, ray: &Ray<'_>, object: &PreparedObject, index: u32) -> Vec3 {
                let texels = object.map.words();
                match self {
                    $($($(Found::$special(entry, traced) if is_stack(ray) => {
                        <$special_facet as Facet>::over(object, index, |over| {
                            color::<$special, _, _>(ray, over, &$words(texels), entry, traced)
                        })
                    })?)*)*
                    $(Found::$model(entry, traced) => <$facet as Facet>::over(object, index, |over| {
                        color::<$model, _, _>(ray, over, texels, entry, traced)
                    }),)*
                }
            }
        }
    };
}

for_each_search!(found);

/// Whether the object of a ray is a stack of layers.
fn is_stack(ray: &Ray<'_>) -> bool {
    ray.object.profile == LAYERED
}

/// Linear RGB of a hit.
fn color<M: Model<Over>, Over, T: Texels + ?Sized>(
    ray: &Ray<'_>,
    over: &Over,
    texels: &T,
    entry: &M::Entry,
    traced: &Traced<M::Place>,
) -> Vec3 {
    if ray.object.self_shadow != 0 {
        trace::color::<true, M, _, _>(ray, over, texels, entry, traced)
    } else {
        trace::color::<false, M, _, _>(ray, over, texels, entry, traced)
    }
}
