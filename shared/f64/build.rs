//! Copies the sources of `relievo-shared`, wherever cargo has that package, without
//! the inner attributes and documentation of its `lib.rs`, which `include!` does not
//! allow.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::{env, fs, io};

fn main() -> Result<(), Box<dyn Error>> {
    let sources = PathBuf::from(env::var("DEP_RELIEVO_SHARED_SOURCES")?);
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed={}", sources.display());
    let target = PathBuf::from(env::var("OUT_DIR")?).join("src");
    // Files that were renamed since would be found beside the new ones.
    if target.exists() {
        fs::remove_dir_all(&target)?;
    }
    copy(&sources, &target)?;
    let lib = fs::read_to_string(sources.join("lib.rs"))?;
    let is_outer = |line: &&str| !line.starts_with("//!") && !line.starts_with("#![");
    let lines: Vec<&str> = lib.lines().filter(is_outer).collect();
    fs::write(target.join("lib.rs"), lines.join("\n"))?;
    Ok(())
}

/// Copies the files of a folder and of the folders in it.
fn copy(from: &Path, to: &Path) -> io::Result<()> {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from)? {
        let path = entry?.path();
        let target = to.join(path.file_name().expect("an entry has a name"));
        if path.is_dir() {
            copy(&path, &target)?;
        } else {
            fs::copy(&path, &target)?;
        }
    }
    Ok(())
}
