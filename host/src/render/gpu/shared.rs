//! Which objects share buffers, and how far apart theirs lie in them.

use crate::prepare::PreparedObject;
use relievo_shared::layout::Frame;
use std::mem::size_of;

/// Alignment of the frames and of the outlines of a run in their buffers, bytes: every device takes this
/// offset.
pub(super) const STRIDE: usize = 256;
const _: () = assert!(size_of::<Frame>() <= STRIDE);

/// Returns the indices of `objects` by the facets that they share, the first ones first.
pub(super) fn sharing(objects: &[PreparedObject]) -> Vec<Vec<usize>> {
    let mut shared: Vec<Vec<usize>> = Vec::new();
    for (index, object) in objects.iter().enumerate() {
        let known = shared
            .iter_mut()
            .rev()
            .find(|known| object.placement.is_some() && objects[known[0]].shares_facets(object));
        match known {
            Some(known) => known.push(index),
            None => shared.push(vec![index]),
        }
    }
    shared
}
