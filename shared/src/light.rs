//! Lighting: ambient light, and one directional light with a diffuse and a specular part
//! (Blinn–Phong). Linear RGB throughout.

use crate::Vec3;
use crate::arithmetic::{max, normalize_or, power};
use crate::layout::{Frame, Object, vec3};
use crate::normals::{CLASS_BEVEL, CLASS_CAP, CLASS_FLOOR};
use crate::profile::grows;

/// Returns the material's colour for a surface class, linear RGB.
#[inline]
pub fn albedo(object: &Object, class: u32) -> Vec3 {
    if class == CLASS_CAP {
        vec3(object.cap_color)
    } else if class == CLASS_BEVEL && grows(object) {
        vec3(object.bevel_color)
    } else if class == CLASS_FLOOR {
        vec3(object.floor_color)
    } else {
        vec3(object.wall_color)
    }
}

/// Returns the light that leaves a point with unit `normal` against the ray's
/// `direction`, linear RGB; only the ambient part if it is not `lit`.
#[inline]
pub fn shade(
    frame: &Frame,
    object: &Object,
    class: u32,
    normal: Vec3,
    direction: Vec3,
    lit: bool,
) -> Vec3 {
    let to_light = vec3(frame.light_direction);
    let light = vec3(frame.light_color);
    let cosine = if lit {
        max(normal.dot(to_light), 0.0)
    } else {
        0.0
    };
    let half_way = normalize_or(to_light - direction, normal);
    let highlight = if cosine > 0.0 {
        object.specular * power(max(normal.dot(half_way), 0.0), object.shininess)
    } else {
        0.0
    };
    albedo(object, class) * (vec3(frame.ambient) + light * cosine) + light * highlight
}

#[cfg(test)]
#[allow(clippy::disallowed_methods)] // Never compiled for a device.
mod tests {
    use super::*;
    use crate::normals::CLASS_WALL;
    use proptest::prelude::*;

    fn scene() -> (Frame, Object) {
        let frame = Frame {
            light_direction: [0.0, 0.0, 1.0],
            light_color: [1.0, 2.0, 3.0],
            ambient: [0.1, 0.2, 0.3],
            ..Frame::default()
        };
        let object = Object {
            cap_color: [0.1, 0.2, 0.3],
            wall_color: [0.4, 0.5, 0.6],
            bevel_color: [0.7, 0.8, 0.9],
            floor_color: [1.0, 0.9, 0.8],
            bevel: 0.1,
            specular: 0.5,
            shininess: 127,
            ..Object::default()
        };
        (frame, object)
    }

    #[test]
    fn each_class_has_its_colour() {
        let (_, object) = scene();
        assert_eq!(albedo(&object, CLASS_CAP), vec3(object.cap_color));
        assert_eq!(albedo(&object, CLASS_WALL), vec3(object.wall_color));
        assert_eq!(albedo(&object, CLASS_BEVEL), vec3(object.bevel_color));
        assert_eq!(albedo(&object, CLASS_FLOOR), vec3(object.floor_color));
    }

    #[test]
    fn a_surface_that_faces_the_light_and_the_eye() {
        let (frame, object) = scene();
        let found = shade(&frame, &object, CLASS_CAP, Vec3::Z, Vec3::NEG_Z, true);
        let expected = Vec3::new(0.1 * 1.1 + 0.5, 0.2 * 2.2 + 1.0, 0.3 * 3.3 + 1.5);
        assert!((found - expected).length() < 1e-6, "{found}");
    }

    #[test]
    fn the_highlight_follows_blinn_and_phong() {
        let (frame, mut object) = scene();
        object.shininess = 10;
        // Half-way between light and eye lies 30° from the normal; the cosine of the light is 1.
        let direction = -Vec3::new(0.75f32.sqrt(), 0.0, 0.5);
        let found = shade(&frame, &object, CLASS_WALL, Vec3::Z, direction, true);
        let highlight = 0.5 * 0.75f32.powi(5);
        let expected =
            Vec3::new(0.4 * 1.1, 0.5 * 2.2, 0.6 * 3.3) + Vec3::new(1.0, 2.0, 3.0) * highlight;
        assert!((found - expected).length() < 1e-5, "{found} {expected}");
    }

    proptest! {
        #[test]
        fn facing_away_is_ambient_only(
            normal in (-1.0f32..1.0, -1.0f32..1.0, -1.0f32..0.0),
            direction in (-1.0f32..1.0, -1.0f32..1.0, -1.0f32..1.0),
        ) {
            let (frame, object) = scene();
            let normal = normalize_or(Vec3::new(normal.0, normal.1, normal.2), Vec3::NEG_Z);
            let direction = normalize_or(Vec3::new(direction.0, direction.1, direction.2), Vec3::X);
            let found = shade(&frame, &object, CLASS_WALL, normal, direction, true);
            prop_assert_eq!(found, vec3(object.wall_color) * vec3(frame.ambient));
        }

        #[test]
        fn light_is_finite_and_bounded(
            normal in (-1.0f32..1.0, -1.0f32..1.0, -1.0f32..1.0),
            direction in (-1.0f32..1.0, -1.0f32..1.0, -1.0f32..1.0),
            shininess in 1u32..128,
        ) {
            let (frame, mut object) = scene();
            object.shininess = shininess;
            let normal = normalize_or(Vec3::new(normal.0, normal.1, normal.2), Vec3::Z);
            // Also exactly along the light: no half-way vector.
            for direction in [
                normalize_or(Vec3::new(direction.0, direction.1, direction.2), Vec3::X),
                Vec3::Z,
            ] {
                let found = shade(&frame, &object, CLASS_FLOOR, normal, direction, true);
                let shadow = shade(&frame, &object, CLASS_FLOOR, normal, direction, false);
                let ambient = vec3(object.floor_color) * vec3(frame.ambient);
                let most = ambient + vec3(frame.light_color) * (1.0 + object.specular);
                prop_assert_eq!(shadow, ambient);
                prop_assert!(found.cmpge(ambient).all(), "{found}");
                prop_assert!(found.cmple(most * 1.001).all(), "{found}");
            }
        }
    }
}
