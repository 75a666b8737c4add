//! Limits of what a scene may use: memory, and the files it may read.
//!
//! A scene of a few lines can ask for more than the machine has. Sizes are
//! estimated and compared with [`Limits`] before memory is allocated.
//!
//! ```
//! use relievo::Limits;
//! use relievo::limits::Account;
//! use std::path::Path;
//!
//! let limits = Limits { memory: 1000, ..Limits::default() };
//! let mut account = Account::new(Path::new("scene.toml"), &limits);
//! account.take("a mesh", 9, 100)?;
//! assert_eq!(account.left(8), 12);
//! assert!(account.take("a map", 13, 8).is_err());
//! # Ok::<(), relievo::limits::LimitError>(())
//! ```

use std::fmt;
use std::path::{Path, PathBuf};

/// Error of a scene that asks for more memory than it may have.
#[derive(Debug, thiserror::Error)]
#[error(
    "{scene}: {what} would take {needed} bytes beside {taken} for the rest, more than the limit of {limit}; make it smaller, or raise the limit (--max-memory)"
)]
pub struct LimitError {
    /// The scene file.
    pub scene: PathBuf,
    /// What does not fit.
    pub what: String,
    /// Memory that it needs, bytes.
    pub needed: u64,
    /// Memory of the rest of the scene, bytes.
    pub taken: u64,
    /// Limit of all memory, bytes.
    pub limit: u64,
}

/// Limits of one scene. The defaults are generous: a scene that exceeds them is
/// more likely a mistake or malicious than a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "transfer", derive(serde::Deserialize, serde::Serialize))]
pub struct Limits {
    /// Number of objects (default 4,096).
    pub objects: usize,
    /// Number of triangles of all objects together, each counted as often as it
    /// is drawn (default 2²⁶; a mesh alone never has more than 2²⁸).
    pub triangles: usize,
    /// Pixels of a pattern, or texels of a baked shape map (default 2²⁸, a
    /// square of 16,384; never more than 2³⁰).
    pub pixels: u64,
    /// Estimated memory of meshes, shape maps and the picture together, bytes
    /// (default 8 GiB).
    pub memory: u64,
    /// Whether a scene may read files outside its folder (default `false`). If
    /// its folder is called `scenes`, the parent folder counts as well, which
    /// holds meshes and patterns.
    pub outside: bool,
}

impl Default for Limits {
    fn default() -> Limits {
        Limits {
            objects: 4096,
            triangles: 1 << 26,
            pixels: crate::shape_map::DEFAULT_MAX_PIXELS,
            memory: 8 << 30,
            outside: false,
        }
    }
}

impl Limits {
    /// Returns the default limits, for a scene that may read any file.
    pub fn trusting() -> Limits {
        Limits {
            outside: true,
            ..Limits::default()
        }
    }
}

/// Counts the memory that one scene uses.
#[derive(Clone, Debug)]
pub struct Account<'a> {
    scene: &'a Path,
    limit: u64,
    taken: u64,
}

impl<'a> Account<'a> {
    /// Creates an empty account of `scene` with the memory that `limits` allows.
    pub fn new(scene: &'a Path, limits: &Limits) -> Account<'a> {
        Account {
            scene,
            limit: limits.memory,
            taken: 0,
        }
    }

    /// Returns the number of items of `bytes` each that still fit.
    pub fn left(&self, bytes: u64) -> u64 {
        (self.limit - self.taken) / bytes
    }

    /// Returns the error for `what`, which would take `needed` bytes more than can be counted.
    pub(crate) fn refused(&self, what: impl fmt::Display, needed: u64) -> LimitError {
        LimitError {
            scene: self.scene.to_path_buf(),
            what: what.to_string(),
            needed,
            taken: self.taken,
            limit: self.limit,
        }
    }

    /// Takes `count` times `bytes` for `what`, before they are allocated.
    ///
    /// # Errors
    /// [`LimitError`] if that is more than is left.
    pub fn take(
        &mut self,
        what: impl fmt::Display,
        count: u64,
        bytes: u64,
    ) -> Result<(), LimitError> {
        let needed = count.saturating_mul(bytes);
        if needed > self.limit - self.taken {
            return Err(self.refused(what, needed));
        }
        self.taken += needed;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_is_counted_to_the_last_byte() {
        let limits = Limits {
            memory: 100,
            ..Limits::default()
        };
        let mut account = Account::new(Path::new("a.toml"), &limits);
        account.take("a mesh", 9, 10).unwrap();
        assert_eq!(account.left(3), 3);
        let error = account.take("a map", 11, 1).unwrap_err();
        let message = error.to_string();
        for part in ["a.toml", "a map", "11 bytes", "90", "100", "--max-memory"] {
            assert!(message.contains(part), "{message}");
        }
        account.take("a map", 10, 1).unwrap();
        assert!(account.take("the picture", u64::MAX, u64::MAX).is_err());
    }
}
