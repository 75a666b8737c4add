//! Patterns so far away that nothing but their [mean](crate::shading::mean) is seen: no ray is marched
//! through them.

use crate::arithmetic::min;
use crate::layout::{Object, vec3};
use crate::model::{Model, Ray};
use crate::{Real, Vec3};

/// Extension of a pattern that covers everything, width units. The square of it is not large for an f32.
const EVERYWHERE: Real = 1e6;

/// Returns whether a pixel is so wide at distance `t` along `ray`, object units, that it shows the mean of
/// the pattern only ([`Object::mean_from`]). It never is for models whose search finds where rays enter.
#[inline]
pub fn is_far<M: Model<Over>, Over>(ray: &Ray<'_>, t: Real) -> bool {
    let Ray {
        frame,
        object,
        direction,
    } = *ray;
    let square = |side: Vec3| side.dot(side);
    let pixel = min(square(vec3(frame.ray_right)), square(vec3(frame.ray_down)));
    // No surface has a pixel that is narrower than one across the ray.
    let cosine = direction.dot(vec3(frame.forward));
    let width = t * cosine * cosine;
    let from = object.mean_from;
    M::FINDS_ENTRY && from > 0.0 && width * width * pixel > from * from
}

/// Returns the object that `ray` meets at `entry`: one without gaps if it is far.
#[inline]
pub fn seen<M: Model<Over>, Over>(ray: &Ray<'_>, _: &Over, entry: &M::Entry) -> Object {
    let mut object = *ray.object;
    if is_far::<M, Over>(ray, M::entry_t(entry)) {
        object.extension = EVERYWHERE;
    }
    object
}

#[cfg(test)]
#[allow(clippy::disallowed_methods)] // Never compiled for a device.
mod tests {
    use super::*;
    use crate::camera::pixel_ray;
    use crate::camera::tests::looking_down_z;
    use crate::layout::{PrismData, Triangle};
    use crate::model::prisms::Home;
    use crate::model::{Flat, Prisms};

    #[test]
    fn an_object_is_far_where_its_pixels_are_wide() {
        let frame = looking_down_z();
        let width = vec3(frame.ray_right).length();
        let is_far = |mean_from, x, t| {
            let object = Object {
                mean_from,
                ..Object::default()
            };
            let direction = pixel_ray(&frame, x, 2);
            let ray = Ray {
                frame: &frame,
                object: &object,
                direction,
            };
            assert!(!super::is_far::<Prisms, Home<&[PrismData]>>(&ray, t));
            super::is_far::<Flat, Triangle>(&ray, t)
        };
        // Once by the cosine to the depth, and once across the ray.
        for x in [0, 4] {
            let cosine = pixel_ray(&frame, x, 2).dot(vec3(frame.forward));
            let from = 10.0 * width * cosine * cosine;
            assert!(is_far(0.999 * from, x, 10.0) && !is_far(1.001 * from, x, 10.0));
        }
        // Not asked for, at the eye, behind it, and where squares are too large for an f32.
        assert!(!is_far(0.0, 4, 1e9));
        assert!(!is_far(1.0, 4, 0.0));
        assert!(!is_far(1e-10, 4, -1e-20));
        assert!(is_far(1.0, 4, 1e30));
    }
}
