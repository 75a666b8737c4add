//! `cargo relievo new`: a project with a shader and its test.

use crate::place::checkout;
use anyhow::{Context, Result, bail};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// The files of a new project.
const TEMPLATE: [(&str, &str); 4] = [
    ("Cargo.toml", include_str!("../template/Cargo.toml.txt")),
    ("src/lib.rs", include_str!("../template/lib.rs.txt")),
    (".gitignore", include_str!("../template/gitignore.txt")),
    ("README.md", include_str!("../template/README.md.txt")),
];

/// Words that Rust reserves.
const KEYWORDS: [&str; 53] = [
    "Self", "abstract", "as", "async", "await", "become", "box", "break", "const", "continue",
    "crate", "do", "dyn", "else", "enum", "extern", "false", "final", "fn", "for", "gen", "if",
    "impl", "in", "let", "loop", "macro", "match", "mod", "move", "mut", "override", "priv", "pub",
    "ref", "return", "self", "static", "struct", "super", "trait", "true", "try", "type", "typeof",
    "union", "unsafe", "unsized", "use", "virtual", "where", "while", "yield",
];

/// Crates that the project uses itself, and folders of cargo.
const TAKEN: [&str; 15] = [
    "alloc",
    "build",
    "core",
    "deps",
    "examples",
    "incremental",
    "proc_macro",
    "relievo_bitwise",
    "relievo_exact",
    "relievo_kernel",
    "relievo_test",
    "spirv_std",
    "std",
    "test",
    "glam",
];

/// Names of devices, which Windows reserves.
const DEVICES: [&str; 4] = ["aux", "con", "nul", "prn"];

#[derive(clap::Args)]
pub struct Arguments {
    /// The name of the package.
    name: String,
    /// The project's folder; by default NAME, here.
    #[arg(long, value_name = "FOLDER")]
    path: Option<PathBuf>,
}

pub fn run(arguments: &Arguments) -> Result<ExitCode> {
    let name = &arguments.name;
    let folder = arguments
        .path
        .clone()
        .unwrap_or_else(|| PathBuf::from(name));
    make(name, &folder, &checkout()?)?;
    println!("{}: README.md says what to run", folder.display());
    Ok(ExitCode::SUCCESS)
}

/// Writes the project `name` to `folder`.
fn make(name: &str, folder: &Path, checkout: &Path) -> Result<()> {
    check_name(name)?;
    let at = || folder.display().to_string();
    if folder.exists() && std::fs::read_dir(folder).with_context(at)?.next().is_some() {
        bail!(
            "{}: the folder is not empty; name another one with --path",
            at()
        );
    }
    std::fs::create_dir_all(folder).with_context(at)?;
    let checkout = toml_path(&relative(
        &folder.canonicalize().with_context(at)?,
        checkout,
    ));
    for (file, text) in TEMPLATE {
        let path = folder.join(file);
        let text = text
            .replace("{{name}}", name)
            .replace("{{relievo}}", &checkout);
        std::fs::create_dir_all(path.parent().unwrap_or(folder))
            .and_then(|()| std::fs::write(&path, text))
            .with_context(|| path.display().to_string())?;
    }
    Ok(())
}

/// Returns the path from a folder to another, or that one if they have no folder in common.
fn relative(from: &Path, to: &Path) -> PathBuf {
    let common = from.iter().zip(to).take_while(|(a, b)| a == b).count();
    if common == 0 {
        return to.to_path_buf();
    }
    let up = from.iter().skip(common).map(|_| "..");
    up.map(OsStr::new).chain(to.iter().skip(common)).collect()
}

/// Returns a path as cargo reads it in a `Cargo.toml`, on every system.
fn toml_path(path: &Path) -> String {
    let path = path.display().to_string();
    // A backslash would escape characters, and cargo does not join to Windows' long form.
    path.trim_start_matches(r"\\?\").replace('\\', "/")
}

/// Checks that `name` can be the name of a package and of its library, by cargo's rules.
fn check_name(name: &str) -> Result<()> {
    let crate_name = name.replace('-', "_");
    let is_plain = |letter: char| letter.is_ascii_alphanumeric() || "_-".contains(letter);
    let first = name.chars().next();
    let reason = if !name.chars().all(is_plain) {
        "it may have only letters from a to z, digits, '_' and '-'"
    } else if !first.is_some_and(|first| first.is_ascii_alphabetic() || first == '_') {
        "it must begin with a letter or '_'"
    } else if crate_name.chars().all(|letter| letter == '_') {
        "it has no letter"
    } else if KEYWORDS.contains(&crate_name.as_str()) {
        "it is a word that Rust reserves"
    } else if TAKEN.contains(&crate_name.as_str()) {
        "a crate that the project uses, or a folder of cargo, has this name"
    } else if is_device(name) {
        "Windows reserves it"
    } else {
        return Ok(());
    };
    bail!("{name:?} cannot be the name of a package: {reason}")
}

/// Returns whether Windows reserves a name.
fn is_device(name: &str) -> bool {
    let name = name.to_ascii_lowercase();
    let numbered = name
        .strip_prefix("com")
        .or_else(|| name.strip_prefix("lpt"));
    let is_numbered = numbered.is_some_and(|rest| matches!(rest.as_bytes(), [b'1'..=b'9']));
    DEVICES.contains(&name.as_str()) || is_numbered
}

#[cfg(test)]
mod tests {
    use super::*;
    use relievo_shader_manifest::Project;

    #[test]
    fn names_are_those_that_cargo_takes() {
        for name in [
            "noise",
            "my-shaders",
            "my_shaders2",
            "_private",
            "compute",
            "Light",
        ] {
            check_name(name).unwrap();
        }
        for name in [
            "",
            "2d",
            "-a",
            "_",
            "__",
            "a b",
            "a.b",
            "a/b",
            "..",
            "é",
            "fn",
            "type",
            "Self",
            "gen",
            "test",
            "std",
            "relievo-exact",
            "spirv-std",
            "con",
            "COM1",
            "lpt9",
        ] {
            let error = check_name(name).unwrap_err().to_string();
            assert!(error.contains(&format!("{name:?} cannot")), "{error}");
        }
    }

    #[test]
    fn paths_have_no_backslashes() {
        assert_eq!(toml_path(Path::new(r"\\?\C:\a\b")), "C:/a/b");
        assert_eq!(toml_path(Path::new("/a/b")), "/a/b");
    }

    #[test]
    fn a_project_is_written_once() {
        let folder = tempfile::tempdir().unwrap();
        let project = folder.path().join("my-shaders");
        let checkout = checkout().unwrap();
        make("my-shaders", &project, &checkout).unwrap();
        for (file, _) in TEMPLATE {
            let text = std::fs::read_to_string(project.join(file)).unwrap();
            assert!(!text.contains("{{") && !text.is_empty(), "{file}: {text}");
        }
        let read = Project::load(&project.join("Cargo.toml")).unwrap();
        assert_eq!((read.shaders.as_str(), read.crates.len()), ("shaders", 1));
        assert_eq!(read.crates[0].name, "my_shaders");

        let error = make("other", &project, &checkout).unwrap_err().to_string();
        assert!(error.contains("not empty"), "{error}");
        // An empty folder will do.
        let empty = folder.path().join("empty");
        std::fs::create_dir(&empty).unwrap();
        make("other", &empty, &checkout).unwrap();
        assert!(make("2d", &folder.path().join("2d"), &checkout).is_err());
        assert!(!folder.path().join("2d").exists());
    }

    #[test]
    fn the_checkout_is_named_from_the_project() {
        let path = |text: &str| PathBuf::from(text);
        let of = |from: &str, to: &str| relative(&path(from), &path(to));
        assert_eq!(of("/a/waves", "/a/relievo"), path("../relievo"));
        assert_eq!(of("/a/b/waves", "/c/relievo"), path("../../../c/relievo"));
        assert_eq!(of("/a", "/a/relievo"), path("relievo"));
        assert_eq!(of("a", "b"), path("b"));
    }
}
