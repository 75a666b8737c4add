//! Signed distances to 2D shapes, negative inside, in the unit of the arguments.
//! Uses correctly rounded operations only (no trigonometry), so that every machine
//! draws the same pixels.

use glam::DVec2;

/// Returns the distance to the segment from `a` to `b`.
pub fn segment(point: DVec2, a: DVec2, b: DVec2) -> f64 {
    let along = b - a;
    let t = ((point - a).dot(along) / along.length_squared()).clamp(0.0, 1.0);
    point.distance(a + along * t)
}

/// Returns the distance to the half of the circle to the right of its centre.
pub fn right_half_circle(point: DVec2, centre: DVec2, radius: f64) -> f64 {
    let offset = point - centre;
    if offset.x >= 0.0 {
        (offset.length() - radius).abs()
    } else {
        // To the left of the centre the nearest point is one of the ends.
        DVec2::new(offset.x, offset.y.abs() - radius).length()
    }
}

/// Returns the signed distance to a rectangle around the origin with rounded
/// corners. `half_size` includes the corners; `radius` is at most its smaller
/// component.
pub fn rounded_rectangle(point: DVec2, half_size: DVec2, radius: f64) -> f64 {
    let corner = point.abs() - (half_size - radius);
    corner.max(DVec2::ZERO).length() + corner.max_element().min(0.0) - radius
}

/// Returns the signed distance to the nearest side line of a regular hexagon around
/// the origin with corners on the x axis. `apothem` is the distance from the centre
/// to a side.
pub fn hexagon(point: DVec2, apothem: f64) -> f64 {
    let point = point.abs();
    let slanted = DVec2::new(3.0_f64.sqrt() / 2.0, 0.5);
    point.y.max(point.dot(slanted)) - apothem
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: f64, b: f64) {
        assert!((a - b).abs() < 1e-12, "{a} is not {b}");
    }

    #[test]
    fn segment_measures_to_the_side_and_to_the_ends() {
        let (a, b) = (DVec2::new(1.0, 1.0), DVec2::new(5.0, 1.0));
        close(segment(DVec2::new(3.0, 3.0), a, b), 2.0);
        close(segment(DVec2::new(-2.0, 5.0), a, b), 5.0);
        close(segment(DVec2::new(8.0, -3.0), a, b), 5.0);
    }

    #[test]
    fn half_circle_has_no_left_half() {
        let centre = DVec2::new(1.0, 2.0);
        close(
            right_half_circle(centre + DVec2::new(5.0, 0.0), centre, 2.0),
            3.0,
        );
        close(right_half_circle(centre, centre, 2.0), 2.0);
        close(
            right_half_circle(centre + DVec2::new(-3.0, 6.0), centre, 2.0),
            5.0,
        );
    }

    #[test]
    fn rounded_rectangle_measures_sides_corners_and_inside() {
        let half_size = DVec2::new(4.0, 3.0);
        close(rounded_rectangle(DVec2::new(6.0, 0.0), half_size, 1.0), 2.0);
        close(
            rounded_rectangle(DVec2::new(-6.0, -6.0), half_size, 1.0),
            4.0,
        );
        close(rounded_rectangle(DVec2::ZERO, half_size, 1.0), -3.0);
        // The sharp corner is cut off.
        assert!(rounded_rectangle(half_size, half_size, 1.0) > 0.4);
    }

    #[test]
    fn hexagon_has_six_equal_sides() {
        for (x, y) in [(0.0, 1.0), (0.75_f64.sqrt(), 0.5)] {
            for sign in [DVec2::ONE, DVec2::new(-1.0, 1.0), -DVec2::ONE] {
                close(hexagon(DVec2::new(x, y) * 3.0 * sign, 2.0), 1.0);
            }
        }
        close(hexagon(DVec2::ZERO, 2.0), -2.0);
    }
}
