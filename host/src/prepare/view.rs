//! The camera and the light of a frame.

use super::narrow;
use crate::mesh::Bounds;
use crate::scene::{Camera, Scene};
use glam::DVec3;
use relievo_shared::layout::Frame;

/// A view of everything from its front, right and above.
pub(super) fn default_camera(bounds: &Bounds, scene: &Scene) -> Camera {
    let centre = bounds.centre();
    let radius = (0.5 * bounds.diagonal()).max(1e-12);
    let half = 0.5 * scene.field_of_view.to_radians();
    let aspect = f64::from(scene.size[0]) / f64::from(scene.size[1]);
    let narrower = half.tan().min(half.tan() * aspect).atan();
    let eye = centre + DVec3::new(0.55, 0.75, 1.0).normalize() * (radius / narrower.sin());
    Camera {
        eye: eye.to_array(),
        target: centre.to_array(),
        up: [0.0, 1.0, 0.0],
    }
}

/// The frame of `scene`, one sample per pixel.
pub(super) fn frame(
    scene: &Scene,
    camera: &Camera,
    origin: DVec3,
    bounds: &Bounds,
    size: [u32; 2],
) -> Frame {
    let eye = DVec3::from(camera.eye);
    let reach = eye.distance(bounds.centre()) + bounds.diagonal();
    let light = &scene.light;
    Frame {
        near: (1e-5 * reach).max(1e-12) as f32,
        light_direction: narrow(DVec3::from(light.direction).normalize()),
        light_color: light.color.linear().map(|c| c * light.intensity as f32),
        ambient: light.ambient.linear(),
        ..unlit_frame(
            eye - origin,
            DVec3::from(camera.target) - eye,
            DVec3::from(camera.up),
            scene.field_of_view,
            size,
        )
    }
}

/// A frame seen from `eye`, relative to the scene's origin, along `forward` of
/// any length; `up` is not along it. `field_of_view` is the vertical one in
/// degrees, `size` in pixels. It has no light yet, and no near plane.
pub fn unlit_frame(
    eye: DVec3,
    forward: DVec3,
    up: DVec3,
    field_of_view: f64,
    size: [u32; 2],
) -> Frame {
    let forward = forward.normalize();
    let right = forward.cross(up).normalize();
    let up = right.cross(forward);
    let [width, height] = size.map(f64::from);
    let tan_y = (0.5 * field_of_view.to_radians()).tan();
    let tan_x = tan_y * width / height;
    let ray_right = right * (2.0 * tan_x / width);
    let ray_down = up * (-2.0 * tan_y / height);
    let corner = forward - right * tan_x + up * tan_y;
    Frame {
        eye: narrow(eye),
        right: narrow(right / tan_x),
        up: narrow(up / tan_y),
        forward: narrow(forward),
        ray_first: narrow(corner + 0.5 * (ray_right + ray_down)),
        ray_right: narrow(ray_right),
        ray_down: narrow(ray_down),
        size: [width as f32, height as f32],
        ..Frame::default()
    }
}
