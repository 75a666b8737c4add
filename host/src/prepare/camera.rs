//! The camera and the light of a frame.

use crate::mesh::Bounds;
use crate::scene::{Camera, Scene};
use glam::DVec3;
use relievo_shared::layout::{Frame, UPRIGHT_AXES};

/// From where and in which light a prepared scene is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The camera, world units.
    pub camera: Camera,
    /// Camera, light and picture size, one sample per pixel.
    pub frame: Frame,
}

/// Returns the camera of `scene`, whose meshes are in `bounds`.
pub(super) fn camera_of(scene: &Scene, bounds: &Bounds) -> Camera {
    let chosen = || default_camera(bounds, scene).orbited(scene.orbit);
    scene.own_camera().unwrap_or_else(chosen)
}

/// Returns a camera that sees everything, from the front, right and above.
fn default_camera(bounds: &Bounds, scene: &Scene) -> Camera {
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

/// Computes the frame of `scene` seen by `camera`, one sample per pixel.
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

/// Computes the rays of a frame, without light and near plane.
///
/// `eye` is relative to the scene's origin; `forward` has any length, and `up`
/// is not parallel to it. `field_of_view` is vertical, in degrees; `size` is in
/// pixels.
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
        unit: 1.0,
        axes: UPRIGHT_AXES,
        ..Frame::default()
    }
}

/// Returns `frame` with `factor` samples per pixel side.
pub fn finer(frame: &Frame, factor: u32) -> Frame {
    let inverse = 1.0 / f64::from(factor);
    let (right, down) = (wide(frame.ray_right), wide(frame.ray_down));
    // The first sample's centre is nearer to the pixel's corner.
    let first = wide(frame.ray_first) + (right + down) * (0.5 * inverse - 0.5);
    Frame {
        ray_first: narrow(first),
        ray_right: narrow(right * inverse),
        ray_down: narrow(down * inverse),
        size: frame.size.map(|side| side * factor as f32),
        ..*frame
    }
}

/// Components below this share of a vector's largest are rounding errors (2⁻⁴⁰).
const ROUNDING_ERROR: f64 = 9.094_947_017_729_282e-13;

/// Rounds to f32. Rounding errors of f64 become 0: their products would be below
/// the range in which all devices agree (docs/exactness.md).
pub(super) fn narrow(v: DVec3) -> [f32; 3] {
    let least = ROUNDING_ERROR * v.abs().max_element();
    v.to_array()
        .map(|x| if x.abs() < least { 0.0 } else { x as f32 })
}

/// Widens to f64.
pub(super) fn wide(v: [f32; 3]) -> DVec3 {
    DVec3::from(v.map(f64::from))
}

/// How far a smooth surface may bulge out of its mesh, as a share of the mesh's
/// diagonal.
const BULGE: f64 = 0.1;

/// Returns whether a mesh with these `bounds` may be visible to `camera`, which
/// is not so if it lies entirely behind one side of the view frustum.
pub(super) fn sees(scene: &Scene, camera: &Camera, bounds: &Bounds) -> bool {
    let eye = DVec3::from(camera.eye);
    let forward = (DVec3::from(camera.target) - eye).normalize();
    let right = forward.cross(DVec3::from(camera.up)).normalize();
    let up = right.cross(forward);
    let [width, height] = scene.size.map(f64::from);
    let tan_y = (0.5 * scene.field_of_view.to_radians()).tan();
    let tan_x = tan_y * width / height;
    // Distances grow inwards.
    let sides = [
        forward,
        forward * tan_x + right,
        forward * tan_x - right,
        forward * tan_y + up,
        forward * tan_y - up,
    ];
    let depths = scene.objects.iter().filter_map(|object| object.depth);
    let margin = BULGE * bounds.diagonal() + depths.fold(0.0, f64::max);
    let half = DVec3::splat(margin) + 0.5 * (bounds.max - bounds.min);
    let centre = bounds.centre() - eye;
    sides
        .iter()
        .all(|side| side.dot(centre) + side.abs().dot(half) >= 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn rounding_errors_become_zero() {
        assert_eq!(narrow(DVec3::new(1e-33, -1.0, 2e-16)), [0.0, -1.0, 0.0]);
        assert_eq!(narrow(DVec3::new(1e-9, 0.1, 5.0)), [1e-9, 0.1, 5.0]);
        assert_eq!(narrow(DVec3::splat(1e-30)), [1e-30; 3]);
        assert_eq!(narrow(DVec3::ZERO), [0.0; 3]);
    }

    #[test]
    fn what_lies_behind_a_side_is_not_seen() {
        let text = "[image]\nsize = [200, 100]\n[camera]\neye = [0, 0, 10]\nfov = 60\n[[object]]\nmesh = 'a'\nshape = 'b'\n";
        let scene = Scene::parse(text, Path::new("a.toml")).unwrap();
        let camera = scene.camera.unwrap();
        let sees = |x: f64, y: f64, z: f64| {
            let centre = DVec3::new(x, y, z);
            let bounds = Bounds {
                min: centre - 0.5,
                max: centre + 0.5,
            };
            sees(&scene, &camera, &bounds)
        };
        assert!(sees(0.0, 0.0, 0.0));
        // Half a picture is 5.8 high and 11.5 wide at the origin.
        assert!(sees(0.0, 6.0, 0.0) && !sees(0.0, 8.0, 0.0) && !sees(0.0, -8.0, 0.0));
        assert!(sees(12.0, 0.0, 0.0) && !sees(14.0, 0.0, 0.0) && !sees(-14.0, 0.0, 0.0));
        assert!(sees(0.0, 0.0, 10.2) && !sees(0.0, 0.0, 12.0));
        // Around the eye.
        assert!(sees(0.0, 0.0, 9.9));
    }
}
