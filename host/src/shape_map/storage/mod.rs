//! The forms in which a shape map may be stored (section 3 of
//! docs/algorithm.md).
//!
//! [`Storage`] is the list of forms; names, files, scene values and decoders
//! follow from it. A new form is one file with a `Form` and one line of the
//! list.
//!
//! ```
//! use relievo::shape_map::Storage;
//!
//! assert_eq!(Storage::from_name("r32f"), Some(Storage::R32F));
//! assert_eq!((Storage::R8.bits(), Storage::R8.texels_per_word()), (8, 4));
//! assert_eq!(Storage::R32F.extension(), "exr");
//! ```

mod codes;
mod float;
mod form;
mod paper;

use super::error::ShapeMapError;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;
use std::path::Path;

use form::Form;
pub(super) use form::{Coding, File, largest_code, pack};

/// Defines [`Storage`] from its list of forms.
macro_rules! storages {
    ($($(#[$doc:meta])* $variant:ident: $form:path,)*) => {
        /// How a texel of a shape map is stored.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Storage {
            $($(#[$doc])* $variant,)*
        }

        impl Storage {
            /// All forms.
            pub const ALL: &[Self] = &[$(Self::$variant),*];

            pub(super) const fn form(self) -> &'static Form {
                match self {
                    $(Self::$variant => const { &$form },)*
                }
            }
        }
    };
}

storages! {
    /// 8-bit signed fixed-point codes: steps of 2⁻⁸ to 2⁻¹ texel, a range of at
    /// most 128 texels. The smallest.
    R8: codes::R8,
    /// 16-bit signed fixed-point codes: steps of 2⁻⁸ to 2⁻⁵ texel, a range of at
    /// most 2048 texels. The accurate form of ordinary size.
    R16: codes::R16,
    /// Signed distances as 32-bit floats, without steps or bounds. The reference
    /// for the other forms.
    R32F: float::R32F,
    /// The paper's shape map, 4 × 8 bits: x and y of the normal, the distance to
    /// the pattern, the pattern. 255 steps up to the (scaled) largest distance;
    /// the inside of the pattern is flat. See [`Encoding::rgba8`].
    Rgba8: paper::RGBA8,
}

impl Storage {
    /// Returns the form of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|form| form.name() == name)
    }

    /// Returns the form for a value of a scene's `map_bits`.
    pub fn from_map_bits(bits: u32) -> Option<Self> {
        let mut forms = Self::ALL.iter().copied();
        forms.find(|form| form.map_bits() == Some(bits))
    }

    /// Name in files and on the command line: `r8`, `r16`, `r32f`, `rgba8`.
    pub const fn name(self) -> &'static str {
        self.form().name
    }

    /// One line for the help of the command line.
    pub const fn summary(self) -> &'static str {
        self.form().summary
    }

    /// Value of a scene's `map_bits` that selects the form; `None` if only
    /// baking makes it.
    pub const fn map_bits(self) -> Option<u32> {
        self.form().map_bits
    }

    /// Bits of a texel.
    pub const fn bits(self) -> u32 {
        self.form().bits
    }

    /// Texels in a 32-bit word: 4, 2 or 1.
    pub const fn texels_per_word(self) -> u32 {
        32 / self.bits()
    }

    /// Number of the decoder in the shared layouts: a `FORMAT_` constant.
    pub const fn shader_format(self) -> u32 {
        self.form().shader_format
    }

    /// Form to use where this one holds too few distances.
    pub const fn larger(self) -> &'static str {
        self.form().larger
    }

    /// Extension of the files that hold this form, without the dot: `png` or
    /// `exr`.
    pub const fn extension(self) -> &'static str {
        match self.form().file {
            File::Png(..) => "png",
            File::Exr => "exr",
        }
    }

    /// Checks that a map of this form may be saved under the name `path`.
    ///
    /// # Errors
    /// [`ShapeMapError::WrongExtension`], unless the name ends in
    /// [`extension`](Self::extension), in lower or upper case.
    pub fn check_extension(self, path: &Path) -> Result<(), ShapeMapError> {
        match path.extension() {
            Some(extension) if extension.eq_ignore_ascii_case(self.extension()) => Ok(()),
            _ => Err(ShapeMapError::WrongExtension {
                path: path.to_path_buf(),
                storage: self.name(),
                extension: self.extension(),
            }),
        }
    }

    /// Checks the parameters of a file.
    pub(super) fn check(self, coding: &Coding) -> Result<(), String> {
        let Coding {
            bias,
            step,
            scale,
            saturated,
        } = coding;
        let valid = (self.form().check)(coding);
        let wrong = if !valid.step {
            format!("step {step}")
        } else if !valid.bias {
            format!("bias {bias}")
        } else if !valid.scale {
            format!("scale {scale}")
        } else if !valid.saturated {
            format!("saturated = {saturated}")
        } else {
            return Ok(());
        };
        Err(format!("{wrong} does not fit {self}"))
    }
}

impl fmt::Display for Storage {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.name())
    }
}

/// As its name.
impl Serialize for Storage {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

/// From its name.
impl<'de> Deserialize<'de> for Storage {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        use serde::de::Error;
        let name = String::deserialize(deserializer)?;
        Self::from_name(&name)
            .ok_or_else(|| D::Error::custom(format!("{name:?} is not a storage form")))
    }
}

/// A storage form with its scale. A [`Storage`] converts to one with the scale 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Encoding {
    pub(super) storage: Storage,
    /// f of equation (5), 0 < f ≤ 1; 1 where it does not apply.
    pub(super) scale: f32,
}

impl Encoding {
    /// Creates [`Storage::Rgba8`] with the paper's scale f: its 255 steps cover
    /// distances up to τ · width = f · max(EDT); farther ones saturate (equations
    /// (4) and (5)). A small f puts the steps near the pattern, which may then
    /// grow by less than τ only.
    ///
    /// # Errors
    /// [`ShapeMapError::InvalidScale`] unless 0 < f ≤ 1.
    pub fn rgba8(scale: f32) -> Result<Self, ShapeMapError> {
        if scale > 0.0 && scale <= 1.0 {
            Ok(Self {
                storage: Storage::Rgba8,
                scale,
            })
        } else {
            Err(ShapeMapError::InvalidScale { scale })
        }
    }

    /// Returns the form.
    pub fn storage(self) -> Storage {
        self.storage
    }
}

impl From<Storage> for Encoding {
    fn from(storage: Storage) -> Self {
        Self {
            storage,
            scale: 1.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_values_select_their_form() {
        for &storage in Storage::ALL {
            let json = serde_json::to_string(&storage).unwrap();
            assert_eq!(json, format!("\"{storage}\""));
            assert_eq!(serde_json::from_str::<Storage>(&json).unwrap(), storage);
            assert_eq!(Storage::from_name(storage.name()), Some(storage));
            assert!(Storage::from_name(storage.larger()).is_some());
            if let Some(bits) = storage.map_bits() {
                assert_eq!(Storage::from_map_bits(bits), Some(storage));
            }
        }
    }

    #[test]
    fn extensions() {
        for &storage in Storage::ALL {
            for (name, extension) in [
                ("a/map.png", "png"),
                ("MAP.PNG", "png"),
                ("map.png.exr", "exr"),
                ("map.jpg", ""),
                ("map", ""),
                (".png", ""),
            ] {
                let result = storage.check_extension(Path::new(name));
                if extension == storage.extension() {
                    assert!(result.is_ok(), "{storage} {name}");
                } else {
                    let message = result.unwrap_err().to_string();
                    let wanted = format!("the extension .{}", storage.extension());
                    assert!(message.contains(name), "{message}");
                    assert!(message.contains(&wanted), "{message}");
                }
            }
        }
    }

    #[test]
    fn scales_go_from_above_zero_to_one() {
        for good in [f32::MIN_POSITIVE, 0.5, 1.0] {
            assert_eq!(Encoding::rgba8(good).unwrap().scale, good);
        }
        for bad in [0.0, -0.5, 1.001, f32::INFINITY, f32::NAN] {
            let message = Encoding::rgba8(bad).unwrap_err().to_string();
            assert!(message.contains(&bad.to_string()), "{message}");
        }
    }
}
