//! Models of the surface: what each tier knows about it.
//!
//! [`Model`] is the interface of a tier to [`trace`](crate::trace). Each
//! implementation is one file, and one entry of
//! [`for_each_search`](crate::for_each_search).
//!
//! ```text
//! flat      planar tier: the flat facet
//! quadric   fast tier: the local quadric
//! relief    relief mapping, on the paths of both
//! paper     the paper's algorithms as printed
//! prisms    accurate tier: from curved prism to curved prism
//! ```
//!
//! `over_triangle` holds what all but the last share: the triangle that a ray meets, and
//! the point where it enters the shell.

pub mod flat;
pub mod over_triangle;
pub mod paper;
pub mod prisms;
pub mod quadric;
pub mod relief;

pub use flat::Flat;
pub use paper::Paper;
pub use prisms::Prisms;
pub use quadric::Quadric;
pub use relief::Relief;

use crate::exit::Exits;
use crate::layout::{Frame, Object};
use crate::march::March;
use crate::normals::HitSurface;
use crate::shape_map::Texels;
use crate::{Real, Vec2, Vec3};

/// The ray of one pixel, and the object that it is traced through.
#[derive(Clone, Copy)]
pub struct Ray<'a> {
    /// Camera, picture and light.
    pub frame: &'a Frame,
    /// The object's parameters.
    pub object: &'a Object,
    /// Unit direction from the eye.
    pub direction: Vec3,
}

/// A surface model, drawn over facets of type `Over`: triangles, or a prism among
/// its neighbours.
///
/// A pixel calls `meet`, `enter` and `search` in this order, and stops where one
/// of them fails. The models are types without values, so that a shader contains
/// the code of one only.
pub trait Model<Over> {
    /// Result of [`Model::meet`].
    type Meeting: Copy;
    /// Result of [`Model::enter`].
    type Entry: Copy;
    /// Where a hit lies, in the model's terms.
    type Place: Place;
    /// The smooth surface at a hit.
    type Surface: HitSurface;

    /// Returns whether the ray may enter the shell over this facet, by the cheapest
    /// test; always true where only the search can tell.
    fn meet(ray: &Ray<'_>, over: &Over) -> (bool, Self::Meeting);

    /// Returns whether the ray enters the shell over this facet, and how. `exits` is
    /// asked only where the model cannot tell where the ray leaves.
    fn enter<X: Exits>(
        ray: &Ray<'_>,
        over: &Over,
        meeting: &Self::Meeting,
        exits: &X,
    ) -> (bool, Self::Entry);

    /// Whether [`Model::enter`] finds where the ray enters, not [`Model::search`].
    const FINDS_ENTRY: bool = true;

    /// A lower bound of the distance of every hit from the eye, object units.
    fn entry_t(entry: &Self::Entry) -> Real;

    /// Searches the shell for the first hit.
    fn search<T: Texels + ?Sized>(
        ray: &Ray<'_>,
        over: &Over,
        texels: &T,
        entry: &Self::Entry,
    ) -> Found<Self::Place>;

    /// The smooth surface at a hit.
    fn surface(
        ray: &Ray<'_>,
        over: &Over,
        entry: &Self::Entry,
        place: &Self::Place,
    ) -> Self::Surface;

    /// Whether the columns of the same object let the light reach a hit.
    fn lit<T: Texels + ?Sized>(
        ray: &Ray<'_>,
        over: &Over,
        texels: &T,
        hit: &Traced<Self::Place>,
        surface: &Self::Surface,
        normals: &Normals,
    ) -> bool;
}

/// Where a hit lies, in a model's terms.
pub trait Place: Copy {
    /// Returns the facet that the hit lies in, where `drawn` is the one that was drawn.
    fn facet(&self, drawn: u32) -> u32;

    /// Returns the number of prisms that the ray went through.
    fn prisms(&self) -> u32;
}

/// Result of [`Model::search`].
#[derive(Clone, Copy, Debug)]
pub struct Found<P> {
    /// How and where the search ended.
    pub march: March,
    /// Distance from the eye, object units.
    pub t: Real,
    /// The place in the model's terms; meaningless for a miss.
    pub place: P,
}

/// The hit of one ray, the same for every model.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// Surface class, one of the `CLASS_` constants; the rest is meaningless for a miss.
    pub class: u32,
    /// Reversed depth, see [`reversed_depth`](crate::camera::reversed_depth): larger is nearer.
    pub depth: Real,
    /// Distance from the eye, object units.
    pub t: Real,
    /// Texture coordinates, 0…1 within one repeat.
    pub uv: Vec2,
    /// Which repeat of the pattern that is, whole numbers, counted as the facet's texture
    /// coordinates are.
    pub repeat: Vec2,
    /// δ, 0…1.
    pub depth_fraction: Real,
    /// Steps of the linear search.
    pub steps: u32,
    /// Which layer of a [`stack`](crate::stack) was hit; at the floor, which stands
    /// nearest.
    pub layer: u32,
}

/// A [`Hit`] with its place in the model's terms.
#[derive(Clone, Copy, Debug)]
pub struct Traced<P> {
    /// The hit.
    pub hit: Hit,
    /// Its place.
    pub place: P,
}

/// The two normals at a hit.
#[derive(Clone, Copy, Debug)]
pub struct Normals {
    /// Unit normal of the carved surface, which is lit.
    pub carved: Vec3,
    /// Unit normal of the smooth surface.
    pub smooth: Vec3,
}
