//! Conversion of the fields of a scene from and to the values of a scene file.

use super::{
    Color, Coordinates, Grid, Instance, Instances, Interpolation, LightKind, Shape, Technique,
    Tier, Tone,
};
use crate::mesh::{MeshSource, Projection};
use crate::shape_map::Storage;
use std::path::PathBuf;
use toml::{Table, Value};

/// A type of fields that keys of a scene file set.
pub(super) trait Field: Sized {
    /// Returns the type in words, as in "expected a number".
    fn kind() -> String;

    /// Returns the value of a key; `None` where the key is left out.
    fn to_toml(&self) -> Option<Value>;

    /// Converts the value of a key, which may be left out; `None` if that is not
    /// possible.
    fn from_toml(value: Option<&Value>) -> Option<Self>;
}

impl Field for bool {
    fn kind() -> String {
        "true or false".into()
    }
    fn to_toml(&self) -> Option<Value> {
        Some(Value::Boolean(*self))
    }
    fn from_toml(value: Option<&Value>) -> Option<Self> {
        value?.as_bool()
    }
}

impl Field for f64 {
    fn kind() -> String {
        "a number".into()
    }
    fn to_toml(&self) -> Option<Value> {
        Some(Value::Float(*self))
    }
    fn from_toml(value: Option<&Value>) -> Option<Self> {
        number(value?)
    }
}

impl Field for u32 {
    fn kind() -> String {
        "a whole number".into()
    }
    fn to_toml(&self) -> Option<Value> {
        Some(Value::Integer(i64::from(*self)))
    }
    fn from_toml(value: Option<&Value>) -> Option<Self> {
        value?.as_integer()?.try_into().ok()
    }
}

impl Field for u8 {
    fn kind() -> String {
        u32::kind()
    }
    fn to_toml(&self) -> Option<Value> {
        u32::from(*self).to_toml()
    }
    fn from_toml(value: Option<&Value>) -> Option<Self> {
        value?.as_integer()?.try_into().ok()
    }
}

impl Field for String {
    fn kind() -> String {
        "a text".into()
    }
    fn to_toml(&self) -> Option<Value> {
        Some(Value::String(self.clone()))
    }
    fn from_toml(value: Option<&Value>) -> Option<Self> {
        value?.as_str().map(str::to_string)
    }
}

impl Field for PathBuf {
    fn kind() -> String {
        "the path of a file".into()
    }
    fn to_toml(&self) -> Option<Value> {
        self.to_string_lossy().into_owned().to_toml()
    }
    fn from_toml(value: Option<&Value>) -> Option<Self> {
        value?.as_str().map(PathBuf::from)
    }
}

/// A field that a scene file may leave without a value.
impl<F: Field> Field for Option<F> {
    fn kind() -> String {
        F::kind()
    }
    fn to_toml(&self) -> Option<Value> {
        self.as_ref()?.to_toml()
    }
    fn from_toml(value: Option<&Value>) -> Option<Self> {
        match value {
            None => Some(None),
            value => F::from_toml(value).map(Some),
        }
    }
}

impl<F: Field, const N: usize> Field for [F; N] {
    fn kind() -> String {
        let all = F::kind();
        format!("{N} {}s", all.strip_prefix("a ").unwrap_or(&all))
    }
    fn to_toml(&self) -> Option<Value> {
        let parts: Option<Vec<Value>> = self.iter().map(F::to_toml).collect();
        Some(Value::Array(parts?))
    }
    fn from_toml(value: Option<&Value>) -> Option<Self> {
        let parts = value?.as_array()?.iter();
        let parts: Option<Vec<F>> = parts.map(|part| F::from_toml(Some(part))).collect();
        parts?.try_into().ok()
    }
}

impl Field for Vec<String> {
    fn kind() -> String {
        "a list of one or more texts".into()
    }
    /// Left out where it is empty.
    fn to_toml(&self) -> Option<Value> {
        let texts = self.iter().map(|text| Value::String(text.clone()));
        (!self.is_empty()).then(|| Value::Array(texts.collect()))
    }
    fn from_toml(value: Option<&Value>) -> Option<Self> {
        match value {
            None => Some(Vec::new()),
            Some(value) => {
                let texts = value.as_array().filter(|texts| !texts.is_empty())?.iter();
                texts.map(|text| String::from_toml(Some(text))).collect()
            }
        }
    }
}

impl Field for Color {
    fn kind() -> String {
        "a colour: \"#rrggbb\", such as \"#c0a060\", or three numbers from 0 to 1".into()
    }
    fn to_toml(&self) -> Option<Value> {
        self.hex()
            .map_or_else(|| self.0.to_toml(), |hex| hex.to_toml())
    }
    fn from_toml(value: Option<&Value>) -> Option<Self> {
        match value?.as_str() {
            Some(text) => Color::parse(text),
            None => <[f64; 3]>::from_toml(value).map(Color),
        }
    }
}

impl Field for Vec<f64> {
    fn kind() -> String {
        "numbers, such as [0, 1.5, 3]".into()
    }
    fn to_toml(&self) -> Option<Value> {
        Some(Value::Array(
            self.iter().copied().map(Value::Float).collect(),
        ))
    }
    fn from_toml(value: Option<&Value>) -> Option<Self> {
        value?.as_array()?.iter().map(number).collect()
    }
}

/// Numbers, or several numbers each; colours become three numbers.
impl Field for Vec<Vec<f64>> {
    fn kind() -> String {
        "a list: [0, 0.5] of numbers, [[0, 0, 5], [0, 1, 5]] of vectors, [\"#000000\", \"#ffffff\"] of colours".into()
    }
    fn to_toml(&self) -> Option<Value> {
        let one = |value: &Vec<f64>| match value[..] {
            [x] => x.to_toml(),
            _ => value.to_toml(),
        };
        Some(Value::Array(self.iter().map(one).collect::<Option<_>>()?))
    }
    fn from_toml(value: Option<&Value>) -> Option<Self> {
        let one = |value: &Value| match value {
            Value::String(text) => Some(Color::parse(text)?.0.to_vec()),
            Value::Array(_) => Vec::<f64>::from_toml(Some(value)),
            value => Some(vec![number(value)?]),
        };
        value?.as_array()?.iter().map(one).collect()
    }
}

/// A path; a mesh that was made in code has none.
impl Field for MeshSource {
    fn kind() -> String {
        PathBuf::kind()
    }
    fn to_toml(&self) -> Option<Value> {
        self.to_string().to_toml()
    }
    fn from_toml(value: Option<&Value>) -> Option<Self> {
        PathBuf::from_toml(value).map(MeshSource::File)
    }
}

/// A path. The tables of a text and of a drawing are read and written by their own keys.
impl Field for Shape {
    fn kind() -> String {
        "a pattern: the path of a file, { text = \"…\" } or { svg = \"…\" }".into()
    }
    fn to_toml(&self) -> Option<Value> {
        self.to_string().to_toml()
    }
    fn from_toml(value: Option<&Value>) -> Option<Self> {
        PathBuf::from_toml(value).map(Shape::File)
    }
}

/// Bits of a texel. The paper's form is made by baking only.
impl Field for Storage {
    fn kind() -> String {
        let bits = Storage::ALL.iter().filter_map(|storage| storage.map_bits());
        one_of(bits.map(|bits| bits.to_string()))
    }
    fn to_toml(&self) -> Option<Value> {
        self.map_bits()?.to_toml()
    }
    fn from_toml(value: Option<&Value>) -> Option<Self> {
        Storage::from_map_bits(u32::from_toml(value)?)
    }
}

/// Makes an enum whose variants have names a field.
macro_rules! named {
    ($type:ty) => {
        impl Field for $type {
            fn kind() -> String {
                one_of(<$type>::ALL.map(|choice| format!("{:?}", choice.name())))
            }
            fn to_toml(&self) -> Option<Value> {
                self.name().to_string().to_toml()
            }
            fn from_toml(value: Option<&Value>) -> Option<Self> {
                let name = value?.as_str()?;
                let mut all = <$type>::ALL.into_iter();
                all.find(|choice| choice.name() == name)
            }
        }
    };
}

named!(Coordinates);
named!(Interpolation);
named!(LightKind);
named!(Tier);
named!(Tone);
named!(Technique);
named!(Projection);

/// Lists choices, as in `8, 16 or 32`.
pub(super) fn one_of(choices: impl IntoIterator<Item = String>) -> String {
    let mut names: Vec<String> = choices.into_iter().collect();
    let last = names.pop().unwrap_or_default();
    if names.is_empty() {
        return last;
    }
    format!("{} or {last}", names.join(", "))
}

/// Returns a number that may be written without a decimal point.
pub(super) fn number(value: &Value) -> Option<f64> {
    value
        .as_float()
        .or(value.as_integer().map(|whole| whole as f64))
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
        "scale" => put(&mut copy.scale, value),
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
