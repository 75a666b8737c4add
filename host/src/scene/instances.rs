//! Copies of an object, each in a place of its own.

use glam::{DQuat, DVec3, EulerRot};
use std::path::PathBuf;

/// Largest number along one side of a grid.
pub const LARGEST_GRID: u32 = 1_000_000;

/// A copy of an object: the object, with its own transform, is scaled, rotated and
/// translated again.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instance {
    /// Uniform scale; the depth is scaled, too.
    pub scale: f64,
    /// Rotation about x, then y, then z, degrees.
    pub rotate: [f64; 3],
    /// Translation, last, world units.
    pub translate: [f64; 3],
}

impl Default for Instance {
    /// The object as it is.
    fn default() -> Instance {
        Instance {
            scale: 1.0,
            rotate: [0.0; 3],
            translate: [0.0; 3],
        }
    }
}

/// Copies side by side.
///
/// ```
/// use relievo::scene::Grid;
///
/// let grid = Grid { count: [3, 1, 1], spacing: [2.0, 0.0, 0.0] };
/// let places: Vec<_> = grid.instances().map(|copy| copy.translate[0]).collect();
/// assert_eq!(places, [-2.0, 0.0, 2.0]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Number along x, y and z.
    pub count: [u32; 3],
    /// Distances along x, y and z, world units.
    pub spacing: [f64; 3],
}

/// The copies of an object. They share its mesh, its map and its preparation.
#[derive(Clone, Debug, PartialEq)]
pub enum Instances {
    /// One by one.
    List(Vec<Instance>),
    /// Side by side, centred on the object.
    Grid(Grid),
    /// A file of comma-separated values: a line with names of columns, and a line for each
    /// copy. The columns are `x`, `y`, `z` (translation), `rx`, `ry`, `rz` (rotation) and
    /// `scale`; those that are left out have their default.
    File(PathBuf),
}

impl Instances {
    /// Checks the numbers.
    pub(super) fn check(&self) -> Result<(), String> {
        match self {
            Instances::List(list) if list.is_empty() => {
                Err("is empty; add { translate = [0, 0, 0] }".to_string())
            }
            Instances::List(list) => {
                list.iter()
                    .enumerate()
                    .try_for_each(|(index, copy)| match copy.check() {
                        Ok(()) => Ok(()),
                        Err(problem) => Err(format!("has a copy {} whose {problem}", index + 1)),
                    })
            }
            Instances::Grid(grid) => {
                if !grid.count.iter().all(|n| (1..=LARGEST_GRID).contains(n)) {
                    return Err(format!(
                        "has the count {:?}; its numbers go from 1 to {LARGEST_GRID}",
                        grid.count
                    ));
                }
                if !grid.spacing.iter().all(|x| x.abs() <= FAR) {
                    return Err(format!(
                        "has the spacing {:?}; its numbers are finite and at most {FAR:e}",
                        grid.spacing
                    ));
                }
                Ok(())
            }
            Instances::File(_) => Ok(()),
        }
    }
}

/// Largest absolute value of a coordinate.
pub(super) const FAR: f64 = 1e9;
/// Smallest and largest scale.
pub(super) const SCALES: (f64, f64) = (1e-9, 1e9);

impl Instance {
    /// Checks the numbers; a problem begins with the name of one.
    pub(crate) fn check(&self) -> Result<(), String> {
        let (low, high) = SCALES;
        if !(low..=high).contains(&self.scale) {
            return Err(format!(
                "scale is {}; it goes from {low:e} to {high:e}",
                self.scale
            ));
        }
        for (name, numbers) in [("rotate", self.rotate), ("translate", self.translate)] {
            if !numbers.iter().all(|x| x.abs() <= FAR) {
                return Err(format!(
                    "{name} is {numbers:?}; its numbers are finite and at most {FAR:e}"
                ));
            }
        }
        Ok(())
    }
}

/// Returns the rotation of a scene's `rotate`: degrees about x, y and z in turn.
pub(crate) fn rotation(degrees: [f64; 3]) -> DQuat {
    let [x, y, z] = degrees.map(f64::to_radians);
    DQuat::from_euler(EulerRot::ZYX, z, y, x)
}

impl Grid {
    /// Returns the number of copies.
    pub(crate) fn size(&self) -> u64 {
        let [x, y, z] = self.count.map(u64::from);
        x.saturating_mul(y).saturating_mul(z)
    }

    /// Returns the copies, x first.
    pub fn instances(&self) -> impl Iterator<Item = Instance> {
        let Grid { count, spacing } = *self;
        let [x, y, z] = count;
        let indices =
            (0..z).flat_map(move |k| (0..y).flat_map(move |j| (0..x).map(move |i| [i, j, k])));
        indices.map(move |index| {
            let at = |axis: usize| {
                let middle = 0.5 * f64::from(count[axis] - 1);
                (f64::from(index[axis]) - middle) * spacing[axis]
            };
            Instance {
                translate: DVec3::new(at(0), at(1), at(2)).to_array(),
                ..Instance::default()
            }
        })
    }
}
