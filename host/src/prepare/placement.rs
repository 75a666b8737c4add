//! Where an object that shares its facets with others stands.

use super::camera::{narrow, wide};
use crate::mesh::Bounds;
use glam::{DQuat, DVec3};
use relievo_shared::layout::Frame;

/// A map from object space to world space: a uniform scale, then a rotation, then a
/// translation.
///
/// A renderer draws an object with a placement by a frame in object space, so that the
/// shaders need no matrix.
///
/// ```
/// use glam::{DQuat, DVec3};
/// use relievo::prepare::Placement;
///
/// let twice = Placement { scale: 2.0, ..Placement::default() };
/// let beside = Placement { translation: DVec3::X, ..Placement::default() };
/// assert_eq!(twice.then(&beside).point(DVec3::X), DVec3::new(3.0, 0.0, 0.0));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "transfer", derive(serde::Deserialize, serde::Serialize))]
pub struct Placement {
    /// World units per object unit, > 0.
    pub scale: f64,
    /// Unit quaternion.
    pub rotation: DQuat,
    /// World units.
    pub translation: DVec3,
}

impl Default for Placement {
    /// The identity.
    fn default() -> Placement {
        Placement {
            scale: 1.0,
            rotation: DQuat::IDENTITY,
            translation: DVec3::ZERO,
        }
    }
}

impl Placement {
    /// Returns the position in world space of a point in object space.
    pub fn point(&self, point: DVec3) -> DVec3 {
        self.translation + self.rotation * (self.scale * point)
    }

    /// Returns the point in object space of a point in world space.
    pub fn to_object(&self, world: DVec3) -> DVec3 {
        self.direction_to_object(world - self.translation) / self.scale
    }

    /// Turns a vector in world space to object space; its length stays.
    pub fn direction_to_object(&self, world: DVec3) -> DVec3 {
        self.rotation.inverse() * world
    }

    /// Returns the map that applies `self` first, and then `outer`.
    #[must_use]
    pub fn then(&self, outer: &Placement) -> Placement {
        Placement {
            scale: outer.scale * self.scale,
            rotation: outer.rotation * self.rotation,
            translation: outer.point(self.translation),
        }
    }

    /// Returns a box in world space around `bounds` in object space.
    pub fn bounds(&self, bounds: &Bounds) -> Bounds {
        let [low, high] = [bounds.min, bounds.max];
        let corners = (0..8).map(|corner| {
            let pick = |axis: usize| if corner >> axis & 1 == 0 { low } else { high }[axis];
            self.point(DVec3::new(pick(0), pick(1), pick(2)))
        });
        let first = self.point(low);
        let around = corners.fold((first, first), |(min, max), corner| {
            (min.min(corner), max.max(corner))
        });
        Bounds {
            min: around.0,
            max: around.1,
        }
    }

    /// Returns `frame`, which is in world space, in object space.
    pub fn frame(&self, frame: &Frame) -> Frame {
        let turned = |v: [f32; 3]| narrow(self.direction_to_object(wide(v)));
        Frame {
            eye: narrow(self.to_object(wide(frame.eye))),
            near: (f64::from(frame.near) / self.scale) as f32,
            right: turned(frame.right),
            up: turned(frame.up),
            forward: turned(frame.forward),
            ray_first: turned(frame.ray_first),
            ray_right: turned(frame.ray_right),
            ray_down: turned(frame.ray_down),
            light_direction: turned(frame.light_direction),
            unit: self.scale as f32,
            axes: DVec3::AXES.map(|axis| narrow(self.rotation * axis)),
            ..*frame
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prepare::unlit_frame;

    fn placement() -> Placement {
        Placement {
            scale: 3.0,
            rotation: DQuat::from_rotation_y(0.7) * DQuat::from_rotation_x(-0.4),
            translation: DVec3::new(5.0, -2.0, 1.0),
        }
    }

    #[test]
    fn a_frame_in_object_space_has_the_same_rays() {
        let eye = DVec3::new(9.0, 4.0, 7.0);
        let frame = Frame {
            near: 0.3,
            ..unlit_frame(eye, DVec3::new(-1.0, -0.5, -0.8), DVec3::Y, 40.0, [30, 20])
        };
        let placement = placement();
        let own = placement.frame(&frame);
        assert!(placement.point(wide(own.eye)).distance(eye) < 1e-5);
        let back = placement.rotation * wide(own.ray_first);
        assert!(back.distance(wide(frame.ray_first)) < 1e-6);
        assert!((own.near - 0.1).abs() < 1e-7 && own.unit == 3.0);
        let [x, y, z] = own.axes.map(wide);
        let normal = placement.rotation * DVec3::new(0.6, 0.0, 0.8);
        assert!((x * 0.6 + y * 0.0 + z * 0.8).distance(normal) < 1e-7);
    }

    #[test]
    fn a_frame_in_the_space_of_the_identity_is_the_same() {
        let frame = unlit_frame(DVec3::ONE, -DVec3::ONE, DVec3::Y, 40.0, [30, 20]);
        assert_eq!(Placement::default().frame(&frame), frame);
    }

    #[test]
    fn a_box_holds_what_is_placed_in_it() {
        let bounds = Bounds {
            min: DVec3::new(-1.0, 0.0, -2.0),
            max: DVec3::new(1.0, 0.5, 3.0),
        };
        let around = placement().bounds(&bounds);
        for corner in [bounds.min, bounds.max, DVec3::new(1.0, 0.0, -2.0)] {
            let at = placement().point(corner);
            assert!(at.cmpge(around.min - 1e-12).all() && at.cmple(around.max + 1e-12).all());
        }
    }
}
