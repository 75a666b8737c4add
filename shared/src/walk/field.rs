//! Input and result of the search of one ray.

use crate::layout::{Object, PrismData};
use crate::march::March;
use crate::shape_map::Texels;
use crate::{Real, Vec3};

/// Storage of the prisms of an object: a storage buffer, a slice.
pub trait PrismList {
    /// Returns the prism over triangle `index`.
    fn prism(&self, index: u32) -> &PrismData;
}

impl PrismList for [PrismData] {
    #[inline]
    fn prism(&self, index: u32) -> &PrismData {
        &self[index as usize]
    }
}

impl PrismList for &[PrismData] {
    #[inline]
    fn prism(&self, index: u32) -> &PrismData {
        &self[index as usize]
    }
}

/// Result of a ray's search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// The hit; its `s` is the distance from the ray's origin, object units. The other
    /// fields are meaningless for a miss.
    pub march: March,
    /// Index of the prism of the hit.
    pub prism: u32,
    /// (w1, w2, δ) there.
    pub x: Vec3,
    /// Number of prisms that the ray crossed.
    pub prisms: u32,
}

/// Everything that is the same for all rays of an object.
#[derive(Clone, Copy)]
pub struct Field<'a, S: PrismList + ?Sized, T: Texels + ?Sized> {
    /// The prisms.
    pub prisms: &'a S,
    /// Their object, with its extrusion and its pattern.
    pub object: &'a Object,
    /// Largest distance between the searched and the true ray, per unit of the ray's
    /// length.
    pub tolerance: Real,
    /// Largest distance before the solid at which the search may end, texels per unit of
    /// the ray's length: the object's, but 0 for shadow rays.
    pub slack: Real,
    /// The pattern's texels.
    pub texels: &'a T,
    /// Number of bisections after the linear search: the object's, but 0 for shadow rays.
    pub binary_steps: u32,
}
