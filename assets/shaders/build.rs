//! Lists the modules in the folders beside this file.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::{env, fs, io};

fn main() -> Result<(), Box<dyn Error>> {
    let package = PathBuf::from(env::var("CARGO_MANIFEST_DIR")?);
    let mut list = String::from("&[\n");
    for folder in entries(&package)?.iter().filter(|path| path.is_dir()) {
        for file in entries(folder)? {
            let name = file.strip_prefix(&package)?.with_extension("");
            let name: Vec<_> = name.iter().map(|part| part.to_string_lossy()).collect();
            let name = name.join("/");
            list += &format!("    ({name:?}, include_bytes!({file:?})),\n");
        }
    }
    list += "]\n";
    fs::write(PathBuf::from(env::var("OUT_DIR")?).join("modules.rs"), list)?;
    println!("cargo::rerun-if-changed={}", package.display());
    Ok(())
}

/// Returns the entries of a folder in order.
fn entries(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let entries = fs::read_dir(folder)?.map(|entry| entry.map(|entry| entry.path()));
    let mut entries = entries.collect::<io::Result<Vec<PathBuf>>>()?;
    entries.sort();
    Ok(entries)
}
