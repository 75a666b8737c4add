//! A plain light model: ambient, and one directional light with a diffuse and
//! a specular part (Blinn–Phong). Linear RGB throughout.

use crate::Vec3;
use crate::arithmetic::{max, normalize_or, power};
use crate::layout::{Frame, Object, vec3};
use crate::normals::{CLASS_BEVEL, CLASS_CAP, CLASS_FLOOR};

/// The material's colour for a surface class.
#[inline]
pub fn albedo(object: &Object, class: u32) -> Vec3 {
    if class == CLASS_CAP {
        vec3(object.cap_color)
    } else if class == CLASS_BEVEL {
        vec3(object.bevel_color)
    } else if class == CLASS_FLOOR {
        vec3(object.floor_color)
    } else {
        vec3(object.wall_color)
    }
}

/// Light that leaves a point with unit `normal` against the ray's `direction`.
#[inline]
pub fn shade(frame: &Frame, object: &Object, class: u32, normal: Vec3, direction: Vec3) -> Vec3 {
    let to_light = vec3(frame.light_direction);
    let light = vec3(frame.light_color);
    let cosine = max(normal.dot(to_light), 0.0);
    let half_way = normalize_or(to_light - direction, normal);
    let highlight = if cosine > 0.0 {
        object.specular * power(max(normal.dot(half_way), 0.0), object.shininess)
    } else {
        0.0
    };
    albedo(object, class) * (vec3(frame.ambient) + light * cosine) + light * highlight
}
