//! The depth to which a prism does not fold.

use glam::DVec2;

use super::quadratic::{PAIRS, Quadratic, WHOLE, cross_products};
use super::{FOLDED, MeshPrism};

/// Relative tolerance of the largest depth, which may be too small by it.
const TOLERANCE: f64 = 5e-3;

/// Maximum number of subdivisions into four.
const LEVELS: usize = 7;

/// Maximum number of parts of a triangle to subdivide.
const MOST_PARTS: usize = 128;

/// 4! / (i! j! (4 − i − j)!), by i and j.
const MULTINOMIALS: [[f64; 5]; 5] = [
    [1.0, 4.0, 6.0, 4.0, 1.0],
    [4.0, 12.0, 12.0, 4.0, 0.0],
    [6.0, 12.0, 6.0, 0.0, 0.0],
    [4.0, 4.0, 0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0, 0.0, 0.0],
];

impl MeshPrism {
    /// Returns the largest depth, in object units, to which the prism does not
    /// fold: infinite if it never does, 0 if the surface itself is folded. It may
    /// be too small by half a percent, but never too large.
    ///
    /// To this depth the determinant of ∂(S − d N)/∂(w1, w2, d) keeps its sign
    /// and, for the precision of f32, a thousandth of its size in a flat prism.
    pub fn largest_depth(&self) -> f64 {
        let (mut proven, mut met) = (f64::INFINITY, f64::INFINITY);
        let mut parts = vec![Part::new(self, WHOLE)];
        for _ in 0..LEVELS {
            met = parts.iter().map(|part| part.met).fold(met, f64::min);
            parts.retain(|part| {
                let is_open = part.proven < (1.0 - TOLERANCE) * met;
                if !is_open {
                    proven = proven.min(part.proven);
                }
                is_open
            });
            if parts.is_empty() || parts.len() > MOST_PARTS {
                break;
            }
            parts = parts
                .iter()
                .flat_map(|part| quarters(part.corners))
                .map(|corners| Part::new(self, corners))
                .collect();
        }
        parts.iter().map(|part| part.proven).fold(proven, f64::min)
    }

    /// Returns a depth, in object units, to which the prism does not fold: at most
    /// [`Self::largest_depth`], and faster to compute.
    pub(crate) fn safe_depth(&self) -> f64 {
        Part::new(self, WHOLE).proven
    }
}

/// A part of a triangle.
struct Part {
    corners: [DVec2; 3],
    /// Depth to which it does not fold.
    proven: f64,
    /// Depth at which it folds at one of its corners.
    met: f64,
}

impl Part {
    fn new(prism: &MeshPrism, corners: [DVec2; 3]) -> Self {
        let least = FOLDED * prism.least_share() * prism.area_normal().length();
        let (mut proven, mut met) = (f64::INFINITY, f64::INFINITY);
        for (i, row) in determinant(&prism.surface(), &prism.normal(), corners)
            .iter()
            .enumerate()
        {
            for (j, [a, b, c]) in row.iter().take(5 - i).enumerate() {
                // A quartic is positive where its Bézier coefficients are.
                let depth = folding_depth([a - least, *b, *c]);
                proven = proven.min(depth);
                if i == 4 || j == 4 || (i, j) == (0, 0) {
                    met = met.min(depth);
                }
            }
        }
        Self {
            corners,
            proven,
            met,
        }
    }
}

/// Returns the four triangles between a triangle's corners and edge midpoints.
fn quarters([a, b, c]: [DVec2; 3]) -> [[DVec2; 3]; 4] {
    let (ab, bc, ca) = (a.midpoint(b), b.midpoint(c), c.midpoint(a));
    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
}

/// Returns the negative determinant of ∂(S − d N)/∂(w1, w2, d) over a part of the
/// triangle. At [i][j] is the Bézier coefficient of the i-th power of the part's
/// second weight and the j-th of its third, a quadratic in d as the coefficients
/// of 1, −d, d².
fn determinant(surface: &Quadratic, normal: &Quadratic, corners: [DVec2; 3]) -> [[[f64; 3]; 5]; 5] {
    let [s1, s2] = surface.slopes_between(corners);
    let [n1, n2] = normal.slopes_between(corners);
    let constant = cross_products(s1, s2);
    let (one, other) = (cross_products(s1, n2), cross_products(n1, s2));
    let square = cross_products(n1, n2);
    let mut sums = [[[0.0; 3]; 5]; 5];
    for (n, (p, q)) in normal.bezier_between(corners).into_iter().zip(PAIRS) {
        for (k, (r, s)) in PAIRS.into_iter().enumerate() {
            let power = |weight: usize| [p, q, r, s].iter().filter(|w| **w == weight).count();
            // A product of two different weights has two orders.
            let orders = |a, b| if a == b { 1.0 } else { 2.0 };
            let (i, j) = (power(1), power(2));
            let share = orders(p, q) * orders(r, s) / MULTINOMIALS[i][j];
            let crosses = [constant[k], one[k] + other[k], square[k]];
            for (sum, cross) in sums[i][j].iter_mut().zip(crosses) {
                *sum += share * cross.dot(n);
            }
        }
    }
    sums
}

/// Returns the least d ≥ 0 at which a − b d + c d² is not positive; infinite if
/// there is none.
fn folding_depth([a, b, c]: [f64; 3]) -> f64 {
    if a.is_nan() || a <= 0.0 {
        return 0.0;
    }
    let radicand = b * b - 4.0 * a * c;
    let divisor = b + radicand.max(0.0).sqrt();
    if radicand >= 0.0 && divisor > 0.0 {
        2.0 * a / divisor
    } else {
        f64::INFINITY
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn folding_depths_are_least_roots() {
        assert_eq!(folding_depth([2.0, 3.0, 1.0]), 1.0);
        assert_eq!(folding_depth([2.0, -3.0, 1.0]), f64::INFINITY);
        assert_eq!(folding_depth([2.0, 1.0, -1.0]), 1.0);
        assert_eq!(folding_depth([2.0, -1.0, -1.0]), 2.0);
        assert_eq!(folding_depth([2.0, 4.0, 0.0]), 0.5);
        assert_eq!(folding_depth([2.0, 0.0, 0.0]), f64::INFINITY);
        assert_eq!(folding_depth([2.0, 1.0, 1.0]), f64::INFINITY);
        assert_eq!(folding_depth([0.0, -1.0, 1.0]), 0.0);
        assert_eq!(folding_depth([f64::NAN, 1.0, 1.0]), 0.0);
    }

    /// Compares the Bézier form of a part with the determinant.
    #[test]
    fn coefficients_are_those_of_the_determinant() {
        let vector = |i: i32| {
            let at = |k: i32| f64::from((i * 37 + k * 11) % 17) / 17.0 - 0.4;
            DVec3::new(at(1), at(3), at(6))
        };
        let surface = Quadratic([1, 2, 3, 4, 5, 6].map(vector));
        let normal = Quadratic([7, 8, 9, 10, 11, 12].map(vector));
        let part = [[0.1, 0.2], [0.7, 0.1], [0.2, 0.5]].map(DVec2::from);
        let coefficients = determinant(&surface, &normal, part);
        let (u, v, d) = (0.3, 0.45, 0.6);
        let t: f64 = 1.0 - u - v;
        let mut value = 0.0;
        for i in 0..5 {
            for j in 0..5 - i {
                let [a, b, c] = coefficients[i][j];
                let weight = MULTINOMIALS[i][j]
                    * f64::powi(u, i as i32)
                    * f64::powi(v, j as i32)
                    * t.powi(4 - (i + j) as i32);
                value += weight * (a - b * d + c * d * d);
            }
        }
        let w = t * part[0] + u * part[1] + v * part[2];
        let ([s1, s2], [n1, n2]) = (surface.slopes(w), normal.slopes(w));
        let expected = (s1 - d * n1).cross(s2 - d * n2).dot(normal.at(w));
        assert!((value - expected).abs() < 1e-12, "{value} {expected}");
        let of_whole = determinant(&surface, &normal, WHOLE)[0][0][0];
        assert!((value - of_whole).abs() > 1e-3);
    }
}
