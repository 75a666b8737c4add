//! Texture coordinates from positions.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};
use serde::Deserialize;

use super::bounds::Bounds;

/// Corners closer to the axis, as a fraction of the bounding box's diagonal, have
/// no azimuth.
const AXIS_TOLERANCE: f64 = 1e-9;

/// A projection of positions to texture coordinates, relative to the bounding box
/// of the transformed mesh. y points up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Projection {
    /// Along x: u increases towards −z, v towards +y. The longer side of the box
    /// spans one repeat; the other has the same scale.
    PlanarX,
    /// Along y: u increases towards +x, v towards −z; scaled as `PlanarX`.
    PlanarY,
    /// Along z: u increases towards +x, v towards +y; scaled as `PlanarX`.
    PlanarZ,
    /// Around the y axis through the centre of the box: u is the azimuth, one
    /// repeat per turn; v is the height, one repeat over the box.
    Cylindrical,
    /// Around the centre of the box: u is the azimuth about y, one repeat per
    /// turn; v is the elevation, 0 at the lower pole and 1 at the upper.
    Spherical,
}

impl Projection {
    /// All projections.
    pub const ALL: [Self; 5] = [
        Self::PlanarX,
        Self::PlanarY,
        Self::PlanarZ,
        Self::Cylindrical,
        Self::Spherical,
    ];

    /// Returns the name in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::PlanarX => "planar-x",
            Self::PlanarY => "planar-y",
            Self::PlanarZ => "planar-z",
            Self::Cylindrical => "cylindrical",
            Self::Spherical => "spherical",
        }
    }

    /// Returns the texture coordinates of a triangle of a mesh with the given
    /// bounds.
    ///
    /// Where u is an azimuth, whole repeats are added at the seam, and a corner
    /// on the axis takes the mean u of the others. Only in a triangle around the
    /// axis can values of u be more than half a repeat apart.
    pub(super) fn project(self, triangle: [DVec3; 3], bounds: &Bounds) -> [DVec2; 3] {
        let size = bounds.max - bounds.min;
        let centre = 0.5 * (bounds.min + bounds.max);
        let planar = |u: fn(DVec3) -> f64, v: fn(DVec3) -> f64, side: f64| {
            // A box without extent has only degenerate triangles.
            let scale = if side > 0.0 { 1.0 / side } else { 0.0 };
            let low = DVec2::new(
                u(bounds.min).min(u(bounds.max)),
                v(bounds.min).min(v(bounds.max)),
            );
            triangle.map(|position| scale * (DVec2::new(u(position), v(position)) - low))
        };
        match self {
            Self::PlanarX => planar(|p| -p.z, |p| p.y, size.y.max(size.z)),
            Self::PlanarY => planar(|p| p.x, |p| -p.z, size.x.max(size.z)),
            Self::PlanarZ => planar(|p| p.x, |p| p.y, size.x.max(size.y)),
            Self::Cylindrical => {
                let scale = if size.y > 0.0 { 1.0 / size.y } else { 0.0 };
                around_axis(triangle, centre, size.length(), |p| {
                    scale * (p.y - bounds.min.y)
                })
            }
            Self::Spherical => around_axis(triangle, centre, size.length(), |p| {
                let offset = p - centre;
                0.5 + offset.y.atan2(offset.x.hypot(offset.z)) / PI
            }),
        }
    }
}

/// Returns u from the azimuth about y, without a seam inside the triangle, and v
/// from the position.
fn around_axis(
    triangle: [DVec3; 3],
    centre: DVec3,
    diagonal: f64,
    v: impl Fn(DVec3) -> f64,
) -> [DVec2; 3] {
    let azimuths = triangle.map(|position| {
        let offset = position - centre;
        let off_axis = offset.x.hypot(offset.z) > AXIS_TOLERANCE * diagonal;
        off_axis.then(|| 0.5 + offset.x.atan2(offset.z) / TAU)
    });
    let us = unwrap_repeats(azimuths);
    std::array::from_fn(|corner| DVec2::new(us[corner], v(triangle[corner])))
}

/// Moves the values by whole repeats to the smallest spread; a missing value
/// becomes the mean of the others.
fn unwrap_repeats(values: [Option<f64>; 3]) -> [f64; 3] {
    let spread = |us: &[Option<f64>; 3]| {
        let known = || us.iter().flatten().copied();
        known().fold(f64::NEG_INFINITY, f64::max) - known().fold(f64::INFINITY, f64::min)
    };
    // The tightest arrangement is centred on one of the values.
    let tightest = values
        .iter()
        .flatten()
        .map(|reference| values.map(|value| value.map(|u| u - (u - reference).round())))
        .min_by(|a, b| spread(a).total_cmp(&spread(b)))
        .unwrap_or(values);
    let known: Vec<f64> = tightest.iter().flatten().copied().collect();
    let mean = if known.is_empty() {
        0.0
    } else {
        known.iter().sum::<f64>() / known.len() as f64
    };
    tightest.map(|value| value.unwrap_or(mean))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const BOX: Bounds = Bounds {
        min: DVec3::new(-1.0, -2.0, -4.0),
        max: DVec3::new(1.0, 2.0, 4.0),
    };

    /// Returns the point at an azimuth (in turns) and height.
    fn at(azimuth: f64, height: f64) -> DVec3 {
        let (sin, cos) = (TAU * azimuth).sin_cos();
        DVec3::new(sin, height, cos)
    }

    #[test]
    fn names_are_those_of_scene_files() {
        for projection in Projection::ALL {
            let read: Projection =
                serde_json::from_str(&format!("\"{}\"", projection.name())).unwrap();
            assert_eq!(read, projection);
        }
    }

    #[test]
    fn planar_projections_fill_one_repeat_without_distortion() {
        for (projection, far, expected) in [
            (Projection::PlanarX, DVec3::new(0.0, 2.0, -4.0), [1.0, 0.5]),
            (Projection::PlanarY, DVec3::new(1.0, 0.0, -4.0), [0.25, 1.0]),
            (Projection::PlanarZ, DVec3::new(1.0, 2.0, 0.0), [0.5, 1.0]),
        ] {
            let near = -far;
            let uvs = projection.project([near, far, near], &BOX);
            assert_eq!(uvs[0], DVec2::ZERO);
            assert_eq!(uvs[1].to_array(), expected);
        }
    }

    #[test]
    fn elevation_and_height_span_one_repeat() {
        let triangle = [
            DVec3::new(0.0, -2.0, 0.0),
            DVec3::new(0.0, 2.0, 0.0),
            at(0.1, 0.0),
        ];
        for projection in [Projection::Cylindrical, Projection::Spherical] {
            let uvs = projection.project(triangle, &BOX);
            assert_eq!(uvs.map(|uv| uv.y), [0.0, 1.0, 0.5]);
            assert!(
                uvs.iter().all(|uv| (uv.x - 0.6).abs() < 1e-12),
                "the poles take the u of the other corner"
            );
        }
    }

    #[test]
    fn a_flat_box_has_finite_coordinates() {
        let flat = Bounds {
            min: DVec3::ZERO,
            max: DVec3::ZERO,
        };
        for projection in Projection::ALL {
            assert!(
                projection
                    .project([DVec3::ZERO; 3], &flat)
                    .iter()
                    .all(|uv| uv.is_finite())
            );
        }
    }

    proptest! {
        /// Wherever the seam lies, u runs on through the triangle.
        #[test]
        fn triangles_do_not_cross_the_seam(start in -1.0..2.0_f64, a in 0.0..0.49_f64, b in 0.0..0.49_f64) {
            let triangle = [at(start, 0.0), at(start + a, 1.0), at(start + b, -1.0)];
            for projection in [Projection::Cylindrical, Projection::Spherical] {
                let uvs = projection.project(triangle, &BOX);
                prop_assert!((uvs[1].x - uvs[0].x - a).abs() < 1e-9);
                prop_assert!((uvs[2].x - uvs[0].x - b).abs() < 1e-9);
            }
        }
    }
}
