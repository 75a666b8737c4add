//! Quadratic polynomials over a triangle.

use glam::{DVec2, DVec3};

/// The two corners of each Bézier point of a quadratic: first the corners, then
/// the sides opposite to them.
pub(super) const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (1, 2), (2, 0), (0, 1)];

/// The corners of the whole triangle, in the weights w1 and w2.
pub(super) const WHOLE: [DVec2; 3] = [DVec2::ZERO, DVec2::X, DVec2::Y];

/// A polynomial of degree two in the weights w1 and w2 of a triangle's second
/// and third corner: the coefficients of 1, w1, w2, w1², w1 w2, w2².
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Quadratic(pub [DVec3; 6]);

impl Quadratic {
    /// Creates Σ w_i a_i + Σ w_j w_k e_i with w0 = 1 − w1 − w2, where j and k are
    /// the corners other than i.
    pub(super) fn new(a: [DVec3; 3], e: [DVec3; 3]) -> Self {
        Self([
            a[0],
            a[1] - a[0] + e[2],
            a[2] - a[0] + e[1],
            -e[2],
            e[0] - e[1] - e[2],
            -e[1],
        ])
    }

    /// Returns the blossom (polar form): symmetric, of degree one in `u` and `v`,
    /// and the polynomial where both are equal.
    fn blossom(&self, u: DVec2, v: DVec2) -> DVec3 {
        let [one, first, second, first_first, first_second, second_second] = self.0;
        one + 0.5 * ((u.x + v.x) * first + (u.y + v.y) * second)
            + u.x * v.x * first_first
            + 0.5 * (u.x * v.y + v.x * u.y) * first_second
            + u.y * v.y * second_second
    }

    /// Returns the Bézier points over the triangle between three points, in the
    /// order of [`PAIRS`]. Their convex hull contains the values there.
    pub(super) fn bezier_between(&self, corners: [DVec2; 3]) -> [DVec3; 6] {
        PAIRS.map(|(i, j)| self.blossom(corners[i], corners[j]))
    }

    /// Returns the Bézier points over the whole triangle.
    pub(crate) fn bezier(&self) -> [DVec3; 6] {
        self.bezier_between(WHOLE)
    }

    /// Returns the derivatives by w1 and w2.
    pub(super) fn slopes(&self, w: DVec2) -> [DVec3; 2] {
        let [_, first, second, first_first, first_second, second_second] = self.0;
        [
            first + 2.0 * w.x * first_first + w.y * first_second,
            second + w.x * first_second + 2.0 * w.y * second_second,
        ]
    }

    /// Returns the derivatives by w1 and w2, both of degree one, at three points.
    pub(super) fn slopes_between(&self, corners: [DVec2; 3]) -> [[DVec3; 3]; 2] {
        let [a, b, c] = corners.map(|w| self.slopes(w));
        [[a[0], b[0], c[0]], [a[1], b[1], c[1]]]
    }

    /// Returns the Bézier points of the cross product of both derivatives. Their
    /// convex cone contains the normals.
    pub(crate) fn normal_bezier(&self) -> [DVec3; 6] {
        let [first, second] = self.slopes_between(WHOLE);
        cross_products(first, second)
    }

    /// Returns the value at (w1, w2).
    #[cfg(test)]
    pub(crate) fn at(&self, w: DVec2) -> DVec3 {
        self.blossom(w, w)
    }
}

/// Returns the Bézier points of the cross product of two functions of degree one,
/// given at the corners.
pub(super) fn cross_products(a: [DVec3; 3], b: [DVec3; 3]) -> [DVec3; 6] {
    PAIRS.map(|(i, j)| 0.5 * (a[i].cross(b[j]) + a[j].cross(b[i])))
}
