//! The shell normal at a position where faces meet.

use glam::{DMat3, DVec3};

/// Normals closer together are treated as equal.
const SAME: f64 = 1e-6;

/// Maximum length of a mitre. A longer one would move the floor sideways by more
/// than 1.7 depths, past the neighbours' floors, and the triangles beside a sharp
/// edge would fold at small depths.
const LONGEST: f64 = 2.0;

/// Ridge of the least squares, as a fraction of the matrix's trace: ignores
/// directions in which the normals differ by less than about 10 mrad.
const RIDGE: f64 = 1e-4;

/// Iterations that remove the ridge's effect in all other directions.
const REFINEMENTS: usize = 8;

/// Target of the dot product with every normal, for a mitre that has to be turned
/// because it points against one.
const LEAST_RISE: f64 = 0.1;

/// Maximum number of turns.
const TURNS: usize = 100;

/// Sums of normals shorter than this fraction of their weights have cancelled out.
const CANCELLED: f64 = 1e-6;

/// Returns the vector m with m·n = 1 for all given unit normals n, so that a point
/// at d m is d below each of their faces; otherwise the least squares with the
/// given weights > 0. Its length is at most 2. `None` where the normals cancel
/// out.
///
/// The mitre of equal normals is that normal, to the bit.
pub(super) fn mitre(normals: &[(DVec3, f64)]) -> Option<DVec3> {
    let &(first, _) = normals.first()?;
    if normals.iter().all(|(n, _)| n.distance(first) <= SAME) {
        return Some(first);
    }
    let total: f64 = normals.iter().map(|(_, weight)| weight).sum();
    let rises = |m: DVec3| normals.iter().all(|(n, _)| m.dot(*n) > 0.0);
    let fitted = fit(normals, total);
    if rises(fitted) {
        return Some(fitted.clamp_length_max(LONGEST));
    }
    let turned = turn(fitted, normals);
    if rises(turned) {
        return Some(turned.clamp_length_max(LONGEST));
    }
    let sum: DVec3 = normals.iter().map(|(n, weight)| *weight * *n).sum();
    (sum.length() > CANCELLED * total).then(|| sum.normalize())
}

/// Returns the shortest m with the least weighted sum of (m·n − 1)², by ridge
/// regression with iterative refinement.
fn fit(normals: &[(DVec3, f64)], total: f64) -> DVec3 {
    // The trace of the matrix is the sum of the weights, here 1.
    let mut matrix = DMat3::ZERO;
    let mut right_side = DVec3::ZERO;
    for &(n, weight) in normals {
        let share = weight / total;
        matrix += DMat3::from_cols(n * n.x, n * n.y, n * n.z) * share;
        right_side += share * n;
    }
    let inverse = (matrix + DMat3::from_diagonal(DVec3::splat(RIDGE))).inverse();
    (0..REFINEMENTS).fold(DVec3::ZERO, |m, _| m + inverse * (right_side - matrix * m))
}

/// Moves `m` along the normal with the least dot product until all are positive.
fn turn(m: DVec3, normals: &[(DVec3, f64)]) -> DVec3 {
    let mut m = m;
    for _ in 0..TURNS {
        let rises = normals.iter().map(|(n, _)| (m.dot(*n), *n));
        let Some((rise, n)) = rises.min_by(|a, b| a.0.total_cmp(&b.0)) else {
            break;
        };
        if rise >= 0.5 * LEAST_RISE {
            break;
        }
        m += (LEAST_RISE - rise) * n;
    }
    m
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(normals: &[DVec3]) -> Option<DVec3> {
        let weighted: Vec<_> = normals
            .iter()
            .zip(1..)
            .map(|(n, weight)| (n.normalize(), 0.3 * f64::from(weight)))
            .collect();
        mitre(&weighted)
    }

    #[test]
    fn it_is_one_deep_below_every_face() {
        let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
        for faces in [
            vec![x],
            vec![x, y],
            vec![x, y, z],
            vec![x, y, z, x, y, z],
            vec![x, x + 0.2 * y, x + 0.2 * z],
            vec![z, z + x, z - x, z + y, z - y],
        ] {
            let m = of(&faces).unwrap();
            let error = |m: DVec3| {
                faces
                    .iter()
                    .map(|n| (m.dot(n.normalize()) - 1.0).abs())
                    .fold(0.0, f64::max)
            };
            // The last one, an edge of 45° around a flat top, has no solution.
            let bound = if faces.len() == 5 { 0.4 } else { 1e-9 };
            assert!(error(m) < bound, "{faces:?} {m}");
            if faces.len() > 1 {
                assert!(error(m.normalize()) > 5e-3, "the length matters");
            }
        }
        assert!((of(&[x, y, z]).unwrap() - DVec3::ONE).length() < 1e-12);
        // The same normal to the bit, and two that differ by rounding only.
        let n = DVec3::new(0.3, -0.5, 0.8).normalize();
        assert_eq!(of(&[n, n]), Some(n.normalize()));
        assert_eq!(of(&[y, y + 1e-7 * x]), Some(y));
    }

    #[test]
    fn noise_does_not_turn_it() {
        // Three tips on a line, but for 1e-4: the plane through them is oblique.
        let noisy = [0.0, 1e-4, 2.1e-4].map(|x| DVec3::new(x, x * (2e-4 - x), 1.0));
        assert!((of(&noisy).unwrap() - DVec3::Z).length() < 1e-3);
    }

    #[test]
    fn it_is_bounded_and_points_against_nothing_if_it_can() {
        // The blade of a knife, and a needle.
        let blade = of(&[DVec3::new(1.0, 0.05, 0.0), DVec3::new(-1.0, 0.05, 0.0)]).unwrap();
        assert!((blade - 2.0 * DVec3::Y).length() < 1e-3, "{blade}");
        // Large faces against a small one: the least squares point against it.
        let faces = [(0.0, 1.0), (40.0, 1.0), (130.0, 0.01)].map(|(angle, weight)| {
            let (sin, cos) = f64::to_radians(angle).sin_cos();
            (DVec3::new(cos, sin, 0.0), weight)
        });
        let rise = |m: DVec3| {
            let rises = faces.iter().map(|(n, _)| m.dot(*n));
            rises.fold(f64::INFINITY, f64::min)
        };
        assert!(rise(fit(&faces, 2.01)) < 0.0);
        let m = mitre(&faces).unwrap();
        assert!(rise(m) > 0.0 && m.length() <= LONGEST + 1e-12, "{m}");
    }

    #[test]
    fn what_cancels_has_none() {
        assert_eq!(mitre(&[(DVec3::X, 1.0), (-DVec3::X, 1.0)]), None);
        assert_eq!(mitre(&[]), None);
        // It cannot be avoided here: the heavier side decides.
        let m = mitre(&[(DVec3::X, 1.0), (-DVec3::X, 2.0)]).unwrap();
        assert!((m + DVec3::X).length() < 1e-12);
        assert_eq!(mitre(&[(DVec3::X, 0.0), (DVec3::Y, 0.0)]), None);
    }
}
