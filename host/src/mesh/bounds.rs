//! Axis-aligned bounding boxes.

use glam::DVec3;

/// An axis-aligned bounding box.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "transfer", derive(serde::Deserialize, serde::Serialize))]
pub struct Bounds {
    /// Lowest coordinates, in object units.
    pub min: DVec3,
    /// Highest coordinates, in object units.
    pub max: DVec3,
}

impl Bounds {
    /// Returns the smallest box around the points, or the origin if there are none.
    pub fn of(points: impl Iterator<Item = DVec3>) -> Self {
        points
            .map(|point| Self {
                min: point,
                max: point,
            })
            .reduce(|a, b| Self {
                min: a.min.min(b.min),
                max: a.max.max(b.max),
            })
            .unwrap_or(Self {
                min: DVec3::ZERO,
                max: DVec3::ZERO,
            })
    }

    /// Returns the centre.
    pub fn centre(&self) -> DVec3 {
        0.5 * (self.min + self.max)
    }

    /// Returns the length of the diagonal, in object units.
    pub fn diagonal(&self) -> f64 {
        self.min.distance(self.max)
    }
}
