//! The forms in which a shape map may be stored.
//!
//! Source: algorithm.md, section 3.

use super::ShapeMapError;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::path::Path;

/// How a texel of a shape map is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Storage {
    /// 8-bit signed fixed-point codes: steps of 2⁻⁸ to 2⁻¹ texel, a range of at
    /// most 128 texels. The smallest.
    R8,
    /// 16-bit signed fixed-point codes: steps of 2⁻⁸ to 2⁻⁵ texel, a range of at
    /// most 2048 texels. The accurate one of ordinary size.
    R16,
    /// The signed distances as 32-bit floats; without steps or bounds. The
    /// reference to measure the others against.
    R32F,
    /// The paper's shape map, 4 × 8 bits: x and y of the normal, the distance to
    /// the pattern, the pattern. 255 steps up to the (scaled) largest distance;
    /// the inside of the pattern is flat. See [`Encoding::rgba8`].
    Rgba8,
}

impl Storage {
    /// All forms.
    pub const ALL: [Self; 4] = [Self::R8, Self::R16, Self::R32F, Self::Rgba8];

    /// The name in files and on the command line: `r8`, `r16`, `r32f`, `rgba8`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::R8 => "r8",
            Self::R16 => "r16",
            Self::R32F => "r32f",
            Self::Rgba8 => "rgba8",
        }
    }

    /// Bits of a texel.
    pub const fn bits(self) -> u32 {
        match self {
            Self::R8 => 8,
            Self::R16 => 16,
            Self::R32F | Self::Rgba8 => 32,
        }
    }

    /// Texels in a 32-bit word: 4, 2 or 1.
    pub const fn texels_per_word(self) -> u32 {
        32 / self.bits()
    }

    /// Extension of the files that hold this form, without the dot: `png`, or
    /// `exr` for [`Storage::R32F`].
    pub const fn extension(self) -> &'static str {
        match self {
            Self::R32F => "exr",
            Self::R8 | Self::R16 | Self::Rgba8 => "png",
        }
    }

    /// Checks that a map of this form may be saved under the name `path`.
    ///
    /// # Errors
    /// [`ShapeMapError::WrongExtension`], unless the name ends in
    /// [`extension`](Self::extension) (in small or capital letters).
    pub fn check_extension(self, path: &Path) -> Result<(), ShapeMapError> {
        match path.extension() {
            Some(extension) if extension.eq_ignore_ascii_case(self.extension()) => Ok(()),
            _ => Err(ShapeMapError::WrongExtension {
                path: path.to_path_buf(),
                storage: self,
            }),
        }
    }
}

impl fmt::Display for Storage {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.name())
    }
}

/// A form of storage and how to use it. A bare [`Storage`] is one with the
/// scale 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Encoding {
    pub(super) storage: Storage,
    /// f of equation (5), 0 < f ≤ 1; 1 where it does not apply.
    pub(super) scale: f32,
}

impl Encoding {
    /// [`Storage::Rgba8`] with the paper's scale f: distances up to
    /// τ · width = f · max(EDT) are told apart, in 255 steps; farther ones
    /// saturate (equations (4) and (5)). A small f spends the steps near the
    /// pattern; the pattern may then grow by less than τ only.
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

    /// The form.
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
    fn names_are_the_same_in_files_and_messages() {
        for storage in Storage::ALL {
            let json = serde_json::to_string(&storage).unwrap();
            assert_eq!(json, format!("\"{storage}\""));
            assert_eq!(serde_json::from_str::<Storage>(&json).unwrap(), storage);
        }
    }

    #[test]
    fn extensions() {
        for storage in Storage::ALL {
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
