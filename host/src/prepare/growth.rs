//! Growth of a pattern with the depth: as parameters, and whether the map suffices for it.

use crate::scene::{Extrusion, Shape};
use crate::shape_map::{ShapeMap, Storage};
use rayon::prelude::*;
use relievo_shared::layout::Object;
use relievo_shared::profile::{Profile, know_upright};

/// Sets the growth of `parameters` to that of `extrusion`.
pub(super) fn grow(parameters: &mut Object, extrusion: &Extrusion) {
    parameters.extension = extrusion.extension as f32;
    parameters.bevel = extrusion.bevel as f32;
    parameters.chamfer = extrusion.chamfer as f32;
    parameters.profile = extrusion.profile;
    parameters.parts = extrusion.parts;
    *parameters = parameters.complete();
}

/// Checks that the distances that `map` stores suffice for the profile of `object`, and
/// removes the growth of an empty pattern.
///
/// # Errors
/// A text that says what is too large and how to change it.
pub(super) fn check_growth(
    object: &mut Object,
    shape: &Shape,
    map: &ShapeMap,
) -> Result<(), String> {
    let width = f64::from(map.width());
    let profile = Profile::new(object);
    let [smallest, largest] = [profile.radius(0.0), profile.largest_radius()].map(f64::from);
    // Upper bound of the distance to the pattern in a map that repeats.
    let furthest = 0.5 * width.hypot(f64::from(map.height()));
    if largest >= furthest {
        // The pattern covers everything, unless it is empty.
        let is_empty = (0..map.height())
            .into_par_iter()
            .all(|y| (0..map.width()).all(|x| map.decode(x, y) > 0.0));
        if is_empty {
            object.extension = 0.0;
            know_upright(object);
            *object = object.complete();
        }
        return Ok(());
    }
    let better = format!("bake the map with --format {}", map.storage().larger());
    if map.saturated() && largest >= f64::from(map.max_distance()) {
        return Err(format!(
            "the pattern grows by e + b·c = {:.4} widths, but {} holds distances up to {:.4} widths only; make extension or bevel smaller, or {better}",
            largest / width,
            shape,
            f64::from(map.max_distance()) / width,
        ));
    }
    let has_bottom = map.saturated() || map.storage() == Storage::Rgba8;
    if has_bottom && smallest <= f64::from(map.min_distance()) {
        return Err(format!(
            "the pattern shrinks by {:.4} widths, but {} holds distances down to {:.4} widths inside it only; make extension larger, or {better}",
            -smallest / width,
            shape,
            f64::from(map.min_distance()) / width,
        ));
    }
    Ok(())
}
