//! Quotients of an object's parameters, computed once for all of its pixels.

use crate::layout::Object;
use crate::{profile, shape_map};

impl Object {
    /// Returns the object with its [`quotients`](Object::quotients) computed from its
    /// other fields. Renderers read only complete objects.
    ///
    /// ```
    /// use relievo_shared::layout::Object;
    ///
    /// let object = Object {
    ///     map_size: [64.0, 32.0],
    ///     map_reach: 2.0,
    ///     ..Object::default()
    /// };
    /// assert_eq!(object.complete().quotients.gradient_offset, [0.03125, 0.0625]);
    /// ```
    #[must_use]
    #[inline]
    pub fn complete(mut self) -> Object {
        shape_map::set_quotients(&mut self);
        profile::set_quotients(&mut self);
        self
    }
}
