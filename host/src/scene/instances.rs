//! Copies of an object, each in a place of its own.

use super::value::{Field, number};
use glam::{DQuat, DVec3, EulerRot};
use std::path::PathBuf;
use toml::{Table, Value};

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
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Number along x, y and z.
    pub count: [u32; 3],
    /// Distances along x, y and z, world units.
    pub spacing: [f64; 3],
}

/// The copies of an object. They share its mesh, its map and its preparation.
///
/// ```
/// use relievo::scene::{Grid, Instances};
///
/// let grid = Instances::Grid(Grid { count: [3, 1, 1], spacing: [2.0, 0.0, 0.0] });
/// let places: Vec<_> = grid.listed().unwrap().iter().map(|copy| copy.translate[0]).collect();
/// assert_eq!(places, [-2.0, 0.0, 2.0]);
/// ```
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
    /// Returns the copies; `None` if a file has to be read.
    pub fn listed(&self) -> Option<Vec<Instance>> {
        match self {
            Instances::List(list) => Some(list.clone()),
            Instances::Grid(grid) => Some(grid.instances().collect()),
            Instances::File(_) => None,
        }
    }

    /// Returns the number of copies; `None` if a file has to be read.
    pub(crate) fn count(&self) -> Option<u64> {
        match self {
            Instances::List(list) => Some(list.len() as u64),
            Instances::Grid(grid) => {
                let [x, y, z] = grid.count.map(u64::from);
                Some(x.saturating_mul(y).saturating_mul(z))
            }
            Instances::File(_) => None,
        }
    }

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
const FAR: f64 = 1e9;
/// Smallest and largest scale.
const SCALES: (f64, f64) = (1e-9, 1e9);

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

/// The keys of a table whose values `read` knows; `None` if it has others, or a value is
/// wrong.
fn each(table: &Table, mut read: impl FnMut(&str, &Value) -> bool) -> Option<()> {
    table
        .iter()
        .all(|(name, value)| read(name, value))
        .then_some(())
}

fn put<F: Field>(field: &mut F, value: &Value) -> bool {
    F::from_toml(Some(value)).is_some_and(|value| {
        *field = value;
        true
    })
}

fn instance(value: &Value) -> Option<Instance> {
    let mut copy = Instance::default();
    each(value.as_table()?, |name, value| match name {
        "scale" => number(value).is_some_and(|scale| {
            copy.scale = scale;
            true
        }),
        "rotate" => put(&mut copy.rotate, value),
        "translate" => put(&mut copy.translate, value),
        _ => false,
    })?;
    Some(copy)
}

fn grid(table: &Table) -> Option<Grid> {
    let mut grid = Grid {
        count: [0; 3],
        spacing: [0.0; 3],
    };
    each(table, |name, value| match name {
        "count" => put(&mut grid.count, value),
        "spacing" => put(&mut grid.spacing, value),
        _ => false,
    })?;
    Some(grid)
}

impl Field for Instances {
    fn kind() -> String {
        "a list of { translate = [x, y, z], rotate = [x, y, z], scale = 1 }, a grid { count = [x, y, z], spacing = [x, y, z] }, or the path of a CSV file".into()
    }

    fn to_toml(&self) -> Option<Value> {
        match self {
            Instances::List(list) => {
                let default = Instance::default();
                let copies = list.iter().map(|copy| {
                    let mut table = Table::new();
                    if copy.translate != default.translate {
                        table.insert("translate".into(), copy.translate.to_toml()?);
                    }
                    if copy.rotate != default.rotate {
                        table.insert("rotate".into(), copy.rotate.to_toml()?);
                    }
                    if copy.scale != default.scale {
                        table.insert("scale".into(), copy.scale.to_toml()?);
                    }
                    Some(Value::Table(table))
                });
                Some(Value::Array(copies.collect::<Option<_>>()?))
            }
            Instances::Grid(grid) => {
                let mut table = Table::new();
                table.insert("count".into(), grid.count.to_toml()?);
                table.insert("spacing".into(), grid.spacing.to_toml()?);
                Some(Value::Table(table))
            }
            Instances::File(path) => path.to_toml(),
        }
    }

    fn from_toml(value: Option<&Value>) -> Option<Self> {
        match value? {
            Value::Array(copies) => copies
                .iter()
                .map(instance)
                .collect::<Option<_>>()
                .map(Instances::List),
            Value::Table(table) => grid(table).map(Instances::Grid),
            value => PathBuf::from_toml(Some(value)).map(Instances::File),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn instances_are_read_as_they_are_written() {
        let list = Instances::List(vec![
            Instance::default(),
            Instance {
                scale: 0.5,
                rotate: [0.0, 90.0, 0.0],
                translate: [1.0, -2.0, 3.5],
            },
        ]);
        let grid = Instances::Grid(Grid {
            count: [20, 1, 20],
            spacing: [2.5, 0.0, 2.5],
        });
        for instances in [list, grid, Instances::File("trees.csv".into())] {
            let value = instances.to_toml().unwrap();
            assert_eq!(Instances::from_toml(Some(&value)), Some(instances));
        }
    }

    #[test]
    fn other_keys_and_numbers_are_refused() {
        let read = |text: &str| {
            let table: Table = format!("a = {text}").parse().unwrap();
            Instances::from_toml(table.get("a"))
        };
        for text in [
            "[{ move = [1, 2, 3] }]",
            "[{ translate = [1, 2] }]",
            "[1, 2, 3]",
            "{ count = [1, 2, -3] }",
            "{ counts = [1, 2, 3] }",
            "true",
        ] {
            assert_eq!(read(text), None, "{text}");
        }
        let check = |text: &str| read(text).unwrap().check();
        let error = check("[{}, { scale = 0 }]").unwrap_err();
        assert!(error.contains("copy 2 whose scale is 0"), "{error}");
        let error = check("[{ translate = [nan, 0, 0] }]").unwrap_err();
        assert!(error.contains("translate"), "{error}");
        for wrong in [
            "[]",
            "{ spacing = [1, 1, 1] }",
            "{ count = [1, 1, 1], spacing = [inf, 0, 0] }",
        ] {
            assert!(check(wrong).is_err(), "{wrong}");
        }
        assert!(check("[{ rotate = [0, 45, 0] }]").is_ok());
    }
}
