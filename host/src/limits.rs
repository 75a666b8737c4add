//! What a scene may take of the machine that draws it: memory, and which files
//! it may read.
//!
//! A scene is a few lines of text that can ask for more than there is. What it
//! asks for is estimated and compared with [`Limits`] before memory is set
//! aside for it.

use crate::Error;
use std::fmt;
use std::path::Path;

/// Limits of one scene. The defaults are generous: what exceeds them is more
/// often a mistake or malice than a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Objects (default 4,096).
    pub objects: usize,
    /// Triangles of all objects together, each counted as often as it is drawn
    /// (default 2²⁶; a mesh alone never has more than 2²⁸).
    pub triangles: usize,
    /// Pixels of a pattern, or texels of a baked shape map (default 2²⁸, a
    /// square of 16,384; never more than 2³⁰).
    pub pixels: u64,
    /// Bytes that meshes, shape maps and the picture are estimated to take
    /// together (default 8 GiB).
    pub memory: u64,
    /// Whether a scene may read files outside of its folder. Where it may not
    /// (the default), the folder around counts as well if the scene's is called
    /// `scenes`: there meshes and patterns lie beside it.
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
    /// The default limits, for a scene that may read any file.
    pub fn trusting() -> Limits {
        Limits {
            outside: true,
            ..Limits::default()
        }
    }
}

/// Keeps count of the memory that one scene takes.
#[derive(Clone, Debug)]
pub struct Account<'a> {
    scene: &'a Path,
    limit: u64,
    taken: u64,
}

impl<'a> Account<'a> {
    /// Nothing is taken yet of the memory that `limits` allows `scene`.
    pub fn new(scene: &'a Path, limits: &Limits) -> Account<'a> {
        Account {
            scene,
            limit: limits.memory,
            taken: 0,
        }
    }

    /// How much there still may be, in items of `bytes` each.
    pub fn left(&self, bytes: u64) -> u64 {
        (self.limit - self.taken) / bytes
    }

    /// Takes `count` times `bytes` for `what`, before they are set aside.
    ///
    /// # Errors
    /// [`Error::Limit`], if that is more than is left.
    pub fn take(&mut self, what: impl fmt::Display, count: u64, bytes: u64) -> Result<(), Error> {
        let needed = count.saturating_mul(bytes);
        if needed > self.limit - self.taken {
            return Err(Error::Limit {
                scene: self.scene.to_path_buf(),
                what: what.to_string(),
                needed,
                taken: self.taken,
                limit: self.limit,
            });
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
        assert!(!error.is_machine());
        let message = error.to_string();
        for part in ["a.toml", "a map", "11 bytes", "90", "100", "--max-memory"] {
            assert!(message.contains(part), "{message}");
        }
        account.take("a map", 10, 1).unwrap();
        assert!(account.take("the picture", u64::MAX, u64::MAX).is_err());
    }
}
