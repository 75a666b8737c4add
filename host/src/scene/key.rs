//! What a key of scene files is: name, description, range, default, and the field that it sets.

use super::value::{Field, number};
use toml::Value;

/// A key of scene files that sets a field of `T`.
pub struct Key<T: 'static> {
    /// Name, without that of the table.
    pub name: &'static str,
    /// Description, Markdown.
    pub doc: &'static str,
    /// Unit of the numbers; may be empty.
    pub unit: &'static str,
    /// Lowest and highest number allowed.
    pub range: Option<(f64, f64)>,
    /// Slider in the viewer.
    pub slider: Option<Slider>,
    /// Whether a file has to have the key.
    pub(super) is_required: bool,
    /// Whether the key is written even where it has its default.
    pub(super) is_always_written: bool,
    /// Whether an error budget chooses the value.
    pub(super) is_planned: bool,
    default: &'static str,
    applies: fn(&T) -> Result<(), &'static str>,
    kind: fn() -> String,
    get: fn(&T) -> Option<Value>,
    set: fn(&mut T, Option<&Value>) -> bool,
}

/// The slider of a key in the viewer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slider {
    /// Label.
    pub label: &'static str,
    /// Lowest and highest value of the slider; more may be typed.
    pub range: (f64, f64),
    /// Whether the scale is logarithmic.
    pub is_logarithmic: bool,
}

/// Creates the entry of a field: the type that it belongs to, name of the key,
/// field, type of the field, description.
macro_rules! key {
    ($owner:ty, $name:literal, $($field:ident).+: $type:ty, $doc:literal) => {
        Key::<$owner>::new(
            $name,
            $doc,
            <$type>::kind,
            |owner| owner.$($field).+.to_toml(),
            |owner, value| match <$type>::from_toml(value) {
                Some(value) => {
                    owner.$($field).+ = value;
                    true
                }
                None => false,
            },
        )
    };
}
pub(super) use key;

/// Returns the key of this name.
pub fn find<T>(keys: &'static [Key<T>], name: &str) -> Option<&'static Key<T>> {
    keys.iter().find(|key| key.name == name)
}

impl<T> Key<T> {
    pub(super) const fn new(
        name: &'static str,
        doc: &'static str,
        kind: fn() -> String,
        get: fn(&T) -> Option<Value>,
        set: fn(&mut T, Option<&Value>) -> bool,
    ) -> Key<T> {
        Key {
            name,
            doc,
            unit: "",
            range: None,
            slider: None,
            is_required: false,
            is_always_written: false,
            is_planned: false,
            default: "",
            applies: |_| Ok(()),
            kind,
            get,
            set,
        }
    }

    /// Limits every number of the value.
    pub(super) const fn range(mut self, low: f64, high: f64) -> Self {
        self.range = Some((low, high));
        self
    }

    pub(super) const fn unit(mut self, unit: &'static str) -> Self {
        self.unit = unit;
        self
    }

    /// Describes a default that is not the field's.
    pub(super) const fn default(mut self, default: &'static str) -> Self {
        self.default = default;
        self
    }

    /// Makes the key an error where `applies` returns one.
    pub(super) const fn when(mut self, applies: fn(&T) -> Result<(), &'static str>) -> Self {
        self.applies = applies;
        self
    }

    /// Marks a value that an error budget chooses.
    pub(super) const fn planned(mut self) -> Self {
        self.is_planned = true;
        self
    }

    pub(super) const fn required(mut self) -> Self {
        self.is_required = true;
        self.always_written()
    }

    /// Writes the key even where it has its default.
    pub(super) const fn always_written(mut self) -> Self {
        self.is_always_written = true;
        self
    }

    pub(super) const fn slider(mut self, label: &'static str, low: f64, high: f64) -> Self {
        self.slider = Some(Slider {
            label,
            range: (low, high),
            is_logarithmic: false,
        });
        self
    }

    pub(super) const fn logarithmic_slider(
        mut self,
        label: &'static str,
        low: f64,
        high: f64,
    ) -> Self {
        self.slider = Some(Slider {
            label,
            range: (low, high),
            is_logarithmic: true,
        });
        self
    }

    /// Returns the default in words, Markdown.
    pub(super) fn default_text(&self, default: &T) -> String {
        if !self.default.is_empty() {
            return self.default.to_string();
        }
        (self.get)(default).map_or_else(String::new, |value| format!("`{value}`"))
    }

    /// Returns the type in words.
    pub(super) fn kind(&self) -> String {
        (self.kind)()
    }

    /// Returns the value of the field; `None` where a file leaves the key out.
    pub(super) fn get(&self, owner: &T) -> Option<Value> {
        (self.get)(owner)
    }

    /// Sets the field; returns `false` where the value has another type, and
    /// sets nothing.
    pub(super) fn set(&self, owner: &mut T, value: &Value) -> bool {
        (self.set)(owner, Some(value))
    }

    /// Copies the field of `from`.
    pub(super) fn copy(&self, owner: &mut T, from: &T) {
        (self.set)(owner, (self.get)(from).as_ref());
    }

    /// Returns an error where the key has no meaning for `owner`.
    pub(super) fn applies(&self, owner: &T) -> Result<(), &'static str> {
        (self.applies)(owner)
    }

    /// Returns whether numbers are whole.
    pub fn is_whole(&self) -> bool {
        self.kind() == u32::kind()
    }

    /// Returns the value, if it is a number.
    pub fn number(&self, owner: &T) -> Option<f64> {
        number(&self.get(owner)?)
    }

    /// Sets a number, rounded where whole numbers are expected; returns `false`
    /// where the key does not hold a number, or the number is out of range.
    pub fn set_number(&self, owner: &mut T, value: f64) -> bool {
        if self
            .range
            .is_some_and(|(low, high)| !(low..=high).contains(&value))
        {
            return false;
        }
        let value = match self.is_whole() {
            true => Value::Integer(value.round() as i64),
            false => Value::Float(value),
        };
        self.set(owner, &value)
    }

    /// Checks the numbers of a value.
    pub(super) fn check(&self, value: &Value) -> Result<(), String> {
        let Some((low, high)) = self.range else {
            return Ok(());
        };
        let is_in = |value: &Value| number(value).is_none_or(|x| (low..=high).contains(&x));
        let unit = match self.unit {
            "" => String::new(),
            unit => format!(" {unit}"),
        };
        let (low, high) = (bound(low), bound(high));
        match value {
            Value::Array(parts) if !parts.iter().all(is_in) => {
                let shown = shown(value);
                if low == format!("-{high}") {
                    Err(format!(
                        "is {shown}; its numbers are finite and at most {high}"
                    ))
                } else {
                    Err(format!(
                        "is {shown}; its numbers go from {low} to {high}{unit}"
                    ))
                }
            }
            Value::Array(_) => Ok(()),
            value if is_in(value) => Ok(()),
            value => Err(format!(
                "is {}; it goes from {low} to {high}{unit}",
                shown(value)
            )),
        }
    }

    /// Returns the problem with a value of the wrong type.
    pub(super) fn expected(&self, value: &Value) -> String {
        let range = match self.range {
            Some((low, high)) if self.is_number() => {
                format!(" from {} to {}", bound(low), bound(high))
            }
            _ => String::new(),
        };
        format!("is {}; expected {}{range}", shown(value), self.kind())
    }

    /// Returns whether the type is a single number.
    fn is_number(&self) -> bool {
        self.is_whole() || self.kind() == f64::kind()
    }
}

/// Formats a bound of a range.
pub(super) fn bound(x: f64) -> String {
    match x.abs() {
        y if y != 0.0 && !(1e-4..1e6).contains(&y) => format!("{x:e}"),
        _ => x.to_string(),
    }
}

/// Largest number of characters of a value in a message.
const SHOWN: usize = 80;

/// Formats a value for a message.
fn shown(value: &Value) -> String {
    match value {
        Value::Table(_) => "a table".to_string(),
        value => {
            let text = value.to_string();
            match text.char_indices().nth(SHOWN) {
                Some((end, _)) => format!("{}…", &text[..end]),
                None => text,
            }
        }
    }
}
