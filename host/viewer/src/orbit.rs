//! Camera motion: pure functions from camera to camera.

use glam::{DQuat, DVec3};
use relievo::scene::Camera;

/// Smallest angle between the view direction and `up`, radians.
const POLE: f64 = 0.02;
/// Smallest and largest distance between eye and target, world units.
const DISTANCES: [f64; 2] = [1e-6, 1e9];

/// Rotates the eye around the target by `yaw` about the camera's up axis and by
/// `pitch` towards it, radians. Stops before the poles.
pub fn orbit(camera: &Camera, yaw: f64, pitch: f64) -> Camera {
    let (target, back) = parts(camera);
    let up = DVec3::from(camera.up).normalize();
    let right = up.cross(back).normalize();
    let above = back.angle_between(up);
    let pitch = pitch.clamp(above - std::f64::consts::PI + POLE, above - POLE);
    let turned = DQuat::from_axis_angle(up, yaw) * DQuat::from_axis_angle(right, -pitch) * back;
    Camera {
        eye: (target + turned).to_array(),
        ..*camera
    }
}

/// Moves eye and target right and up, in picture heights at the target's
/// distance. `field_of_view` is vertical, degrees.
pub fn pan(camera: &Camera, right: f64, up: f64, field_of_view: f64) -> Camera {
    let (target, back) = parts(camera);
    let height = 2.0 * back.length() * (0.5 * field_of_view.to_radians()).tan();
    let forward = -back.normalize();
    let sideways = forward.cross(DVec3::from(camera.up)).normalize();
    let upwards = sideways.cross(forward);
    let shift = (sideways * right + upwards * up) * height;
    Camera {
        eye: (target + back + shift).to_array(),
        target: (target + shift).to_array(),
        ..*camera
    }
}

/// Divides the distance from eye to target by `factor`.
pub fn zoom(camera: &Camera, factor: f64) -> Camera {
    let (target, back) = parts(camera);
    let [least, largest] = DISTANCES;
    let distance = (back.length() / factor).clamp(least, largest);
    Camera {
        eye: (target + back.normalize() * distance).to_array(),
        ..*camera
    }
}

/// Returns the target and the vector from there to the eye.
fn parts(camera: &Camera) -> (DVec3, DVec3) {
    let target = DVec3::from(camera.target);
    (target, DVec3::from(camera.eye) - target)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const FRONT: Camera = Camera {
        eye: [1.0, 2.0, 13.0],
        target: [1.0, 2.0, 3.0],
        up: [0.0, 1.0, 0.0],
    };

    fn near(a: [f64; 3], b: [f64; 3]) {
        assert!(
            DVec3::from(a).distance(DVec3::from(b)) < 1e-9,
            "{a:?} {b:?}"
        );
    }

    #[test]
    fn a_quarter_turn_is_a_quarter_turn() {
        let quarter = std::f64::consts::FRAC_PI_2;
        near(orbit(&FRONT, quarter, 0.0).eye, [11.0, 2.0, 3.0]);
        near(orbit(&FRONT, 0.0, 0.5 * quarter).eye, {
            let side = 50f64.sqrt();
            [1.0, 2.0 + side, 3.0 + side]
        });
    }

    #[test]
    fn a_pan_by_one_height_moves_by_what_is_seen() {
        let moved = pan(&FRONT, 0.0, 1.0, 90.0);
        near(moved.target, [1.0, 22.0, 3.0]);
        near(moved.eye, [1.0, 22.0, 13.0]);
        near(pan(&FRONT, 0.5, 0.0, 90.0).target, [11.0, 2.0, 3.0]);
    }

    proptest! {
        #[test]
        fn a_camera_stays_one(
            turns in prop::collection::vec((-9.0..9.0, -9.0..9.0, 0.01..100.0f64), 1..20),
        ) {
            let mut camera = FRONT;
            for (yaw, pitch, factor) in turns {
                camera = zoom(&orbit(&camera, yaw, pitch), factor);
                let (_, back) = parts(&camera);
                let angle = back.angle_between(DVec3::Y);
                prop_assert!(back.is_finite() && back.length() > 0.9 * DISTANCES[0]);
                prop_assert!(angle > 0.9 * POLE && angle < std::f64::consts::PI - 0.9 * POLE);
            }
        }
    }
}
