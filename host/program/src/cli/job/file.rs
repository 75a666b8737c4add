//! Files that must not change.

use anyhow::Context;
use relievo::file::read_regular;
use serde::{Deserialize, Serialize};
use siphasher::sip128::{Hasher128, SipHasher24};
use std::hash::Hasher;
use std::path::{Path, PathBuf};

/// A file and a digest of its contents.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct DigestedFile {
    /// Its path.
    pub path: PathBuf,
    /// [`digest`] of its bytes.
    digest: String,
}

impl DigestedFile {
    /// Reads the file at `path`.
    pub fn new(path: PathBuf) -> anyhow::Result<DigestedFile> {
        let digest = digest_of_file(&path)?;
        Ok(DigestedFile { path, digest })
    }

    /// Returns whether the file has the same contents. Fails if it cannot be read.
    pub fn is_same(&self) -> anyhow::Result<bool> {
        Ok(digest_of_file(&self.path)? == self.digest)
    }
}

/// Returns a digest of `bytes`: SipHash-2-4 with 128 bits. It finds accidental changes, and does
/// not resist forgery.
pub fn digest(bytes: &[u8]) -> String {
    let mut hasher = SipHasher24::new();
    hasher.write(bytes);
    format!("{:032x}", hasher.finish128().as_u128())
}

/// Returns the digest of this program.
pub fn own_digest() -> anyhow::Result<String> {
    digest_of_file(&std::env::current_exe().context("this program has no file")?)
}

fn digest_of_file(path: &Path) -> anyhow::Result<String> {
    let bytes = read_regular(path, u64::MAX);
    let bytes = bytes.with_context(|| format!("cannot read {}", path.display()))?;
    Ok(digest(&bytes))
}
