//! Conversion of the fields of a scene from and to the values of a scene file.

use super::{Color, Shape, Technique, Tier};
use crate::mesh::{MeshSource, Projection};
use crate::shape_map::Storage;
use std::path::PathBuf;
use toml::Value;

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

/// A path. The table of a text is read and written by its own keys.
impl Field for Shape {
    fn kind() -> String {
        "a pattern: the path of a file, or { text = \"…\" }".into()
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

named!(Tier);
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
