//! The edge that a hit knows: where its surface ends on the picture, for smooth edges.
//!
//! A cap ends at its outline, a floor at the foot of the sides, and a side at the cap. The
//! distance map tells how far that is, and the tangent plane how many pixels that are. A side that is wider than a
//! pixel tells near its foot how far that is, from which its depth tells how far the cap is.

use crate::arithmetic::{abs, clamp, div, kept, kept3, max, min, normalize_or, sqrt};
use crate::camera::on_plane;
use crate::model::{Hit, Normals, Ray};
use crate::normals::{CLASS_CAP, CLASS_FLOOR};
use crate::profile::Profile;
use crate::{Real, Vec2, Vec3};

/// Largest code of a distance: the edge is not near, or not known.
pub const FAR_AWAY: u32 = 127;
/// Largest code of a direction.
const LAST_TURN: u32 = 63;
/// Steps of a pixel.
const STEPS: Real = 126.0;
/// Least cosine between a surface and the direction to the eye.
const LEAST_COSINE: Real = 1e-3;
/// Steps of a quarter turn.
const TURNS: Real = 16.0;

/// The edge of a surface on the picture, taken for straight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// Whether it, or the foot of a side, is at most a pixel away; the rest is meaningless if not.
    pub is_near: bool,
    /// Distance from the pixel's centre, pixels.
    pub distance: Real,
    /// Unit direction towards it, on the picture: right and down.
    pub direction: Vec2,
}

/// Returns the codes of the distance and of the direction of the edge of a hit with these
/// `normals`, and whether the distance is that to the foot of a side instead, which is nearer.
/// `distance` and `gradient` are those of the map there, and `slopes` are ∇u and ∇v.
#[inline]
pub fn codes(
    ray: &Ray<'_>,
    hit: &Hit,
    normals: &Normals,
    distance: Real,
    gradient: Vec2,
    slopes: [Vec3; 2],
) -> (u32, u32, bool) {
    let Ray {
        frame,
        object,
        direction,
    } = *ray;
    let mut normal = normals.carved;
    // How far the edge and the foot are, in any unit, and how that changes in space.
    let is_cap = hit.class == CLASS_CAP;
    let (distance, to_foot, gradient) = if is_cap || hit.class == CLASS_FLOOR {
        let profile = Profile::new(object);
        let (to_edge, sign) = if is_cap {
            (-profile.upright_gap(distance), -1.0)
        } else {
            (distance - profile.largest_radius(), 1.0)
        };
        // In the middle of a groove the differences are too small, but the distance is right.
        let away = normalize_or(Vec2::new(kept(gradient.x), kept(gradient.y)), Vec2::X);
        let [width, height] = object.map_size;
        let slope = away * Vec2::new(width, height) * sign;
        let along = slopes[0] * slope.x + slopes[1] * slope.y;
        (to_edge, to_edge, along)
    } else {
        let smooth = normals.smooth;
        // Where the map's differences reach over the middle of a groove they are too small, and tilt the normal.
        let missing = 1.0 - min(sqrt(kept(gradient.dot(gradient))), 1.0);
        normal = kept3(normal - smooth * (kept(smooth.dot(normal)) * missing));
        let below = 1.0 - hit.depth_fraction;
        (
            hit.depth_fraction * object.depth,
            below * object.depth,
            -smooth,
        )
    };
    let gradient = kept3(gradient);
    // How it changes from pixel to pixel on the tangent plane.
    let [right, down] = on_plane(frame, direction, hit.t, normal, LEAST_COSINE);
    let change = |side: Vec3| kept(gradient.dot(kept3(side)));
    let towards = -Vec2::new(change(right), change(down));
    let rate = sqrt(kept(towards.dot(towards)));
    let inverse = div(1.0, max(rate, 1e-12));
    let mut pixels = kept(distance) * inverse;
    let is_to_foot = pixels > 1.0;
    if is_to_foot {
        pixels = kept(to_foot) * inverse;
    }
    let steps = (clamp(pixels, 0.0, 2.0) * STEPS + 0.5) as u32;
    let steps = if steps < FAR_AWAY { steps } else { FAR_AWAY };
    let is_to_foot = is_to_foot && steps < FAR_AWAY;
    (steps, turn_of(towards), is_to_foot)
}

/// Returns the code of a direction: its place on the square |x| + |y| = 1.
#[inline]
pub(crate) fn turn_of(v: Vec2) -> u32 {
    let x = div(v.x, max(abs(v.x) + abs(v.y), 1e-12));
    let turn = if v.y < 0.0 { 3.0 + x } else { 1.0 - x };
    (clamp(turn, 0.0, 4.0) * TURNS + 0.5) as u32 & LAST_TURN
}

/// Returns the unit vector of a code of [`turn_of`].
#[inline]
pub(crate) fn from_turn(code: u32) -> Vec2 {
    const TURN: Real = 1.0 / 16.0;
    let turn = code as i32 as Real * TURN;
    let is_up = turn > 2.0;
    let x = if is_up { turn - 3.0 } else { 1.0 - turn };
    let y = 1.0 - abs(x);
    let v = Vec2::new(x, if is_up { -y } else { y });
    v * div(1.0, sqrt(v.dot(v)))
}

impl Edge {
    /// Returns the edge of [`codes`] of a distance and a direction.
    #[inline]
    pub fn from_codes(distance: u32, direction: u32) -> Edge {
        const STEP: Real = 1.0 / 126.0;
        Edge {
            is_near: distance != FAR_AWAY,
            distance: distance as i32 as Real * STEP,
            direction: from_turn(direction),
        }
    }

    /// Returns the edge of a side at `depth_fraction`, whose distance is that to its foot. The rest of the depth
    /// is at least `least`.
    #[inline]
    pub fn from_foot(&self, depth_fraction: Real, least: Real) -> Edge {
        const LEAST: Real = 0.5 / 126.0;
        let inverse = div(1.0, max(1.0 - depth_fraction, least));
        Edge {
            distance: max(self.distance, LEAST) * depth_fraction * inverse,
            ..*self
        }
    }
}

#[cfg(test)]
#[allow(clippy::disallowed_methods)] // Never compiled for a device.
mod tests {
    use super::*;
    use crate::camera::tests::frame;
    use crate::layout::Object;
    use crate::normals::CLASS_BEVEL;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn directions_survive_their_code(angle in -3.2f32..3.2, length in 1e-3f32..1e3) {
            let v = Vec2::new(angle.cos(), angle.sin());
            let found = from_turn(turn_of(v * length));
            // Half a step is 3.6 degrees on the diagonals.
            prop_assert!(found.dot(v) > 0.998, "{v} {found}");
        }
    }

    /// Normal of a side that falls by 4 units for 3 to the right.
    const SIDE: Vec3 = Vec3::new(0.8, 0.0, 0.6);

    fn found(class: u32, depth_fraction: f32, x: f32) -> Edge {
        let (distance, direction, _) = codes_at(class, 0.1, depth_fraction, x, 0.3);
        Edge::from_codes(distance, direction)
    }

    /// Returns the codes of the edge at `x` of a plane z = −2 with 4 texels a unit, seen from 0, whose pattern
    /// ends at 0.5 and whose map changes by `steepness` a texel.
    fn codes_at(
        class: u32,
        depth: f32,
        depth_fraction: f32,
        x: f32,
        steepness: f32,
    ) -> (u32, u32, bool) {
        let object = Object {
            map_size: [4.0, 4.0],
            depth,
            ..Object::default()
        }
        .complete();
        // A pixel is 0.25 units wide on the plane.
        let frame = frame(Vec3::ZERO, Vec3::NEG_Z, 8, 8, 0.5);
        let towards = Vec3::new(x - 0.5, 0.0, -2.0);
        let ray = Ray {
            frame: &frame,
            object: &object,
            direction: towards.normalize(),
        };
        let hit = Hit {
            class,
            depth: 0.0,
            t: towards.length(),
            uv: Vec2::new(x, 0.5),
            repeat: Vec2::ZERO,
            depth_fraction,
            steps: 0,
            layer: 0,
        };
        let carved = match class {
            // As the map has it.
            CLASS_BEVEL => Vec3::new(SIDE.x * steepness, 0.0, SIDE.z).normalize(),
            _ => Vec3::Z,
        };
        let normals = Normals {
            carved,
            smooth: Vec3::Z,
        };
        let gradient = Vec2::new(steepness, 0.0);
        let distance = 4.0 * (x - 0.5);
        let slopes = [Vec3::X, Vec3::Y];
        codes(&ray, &hit, &normals, distance, gradient, slopes)
    }

    #[test]
    fn a_cap_ends_at_its_outline_and_a_floor_at_the_foot() {
        // 0.1 units are 0.4 pixels.
        let cap = found(CLASS_CAP, 0.0, 0.4);
        assert!(cap.is_near && (cap.distance - 0.4).abs() < 0.01, "{cap:?}");
        assert_eq!(cap.direction, Vec2::X);
        let floor = found(CLASS_FLOOR, 1.0, 0.6);
        assert!(floor.is_near && (floor.distance - 0.4).abs() < 0.01);
        assert_eq!(floor.direction, Vec2::NEG_X);
        assert!(!found(CLASS_CAP, 0.0, 0.15).is_near);
    }

    #[test]
    fn a_side_ends_at_the_cap() {
        // The ray is straight: 0.06 units down are 0.045 to the right, 0.18 pixels, where the cap is to the
        // left. In the middle of a groove, where the map changes less, too.
        for steepness in [1.0, 0.3] {
            let (distance, direction, is_to_foot) = codes_at(CLASS_BEVEL, 0.1, 0.6, 0.5, steepness);
            let side = Edge::from_codes(distance, direction);
            assert!(!is_to_foot && side.is_near);
            assert!((side.distance - 0.18).abs() < 0.01, "{side:?}");
            assert_eq!(side.direction, Vec2::NEG_X);
        }
    }

    #[test]
    fn a_side_whose_foot_is_nearer_knows_how_far_that_is() {
        // A tenth of 0.5 units down is 0.15 pixels, the rest 1.35.
        let (distance, direction, is_to_foot) = codes_at(CLASS_BEVEL, 0.5, 0.9, 0.5, 1.0);
        let foot = Edge::from_codes(distance, direction);
        assert!(is_to_foot && foot.is_near);
        assert!((foot.distance - 0.15).abs() < 0.01, "{foot:?}");
        let side = foot.from_foot(0.9, 5e-4);
        assert!(
            side.is_near && (side.distance - 1.35).abs() < 0.05,
            "{side:?}"
        );
        // Both are far away.
        let (distance, _, is_to_foot) = codes_at(CLASS_BEVEL, 2.0, 0.5, 0.5, 1.0);
        assert_eq!((distance, is_to_foot), (FAR_AWAY, false));
        // At the foot something is left.
        assert!(
            Edge {
                distance: 0.0,
                ..foot
            }
            .from_foot(1.0, 5e-4)
            .distance
                > 1.0
        );
    }
}
