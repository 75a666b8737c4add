//! Compiles the programs of `tests/wrong`, and compares what the builder answers with the
//! files of `tests/wrong/messages`.
//!
//! `RELIEVO_UPDATE_GOLDEN=1` writes these files. Look at the difference before you commit it.

use relievo_shader_builder::compile::compile;
use relievo_shader_builder::shader_crate::{ShaderCrate, Variant};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/wrong");

/// The program that is right.
const RIGHT: &str = "right";

/// Programs that rust-gpu refuses itself, in both variants.
const NOT_COMPILED: [&str; 4] = ["double", "object", "recursion", "wide"];

fn program(name: &str) -> ShaderCrate {
    ShaderCrate {
        folder: PathBuf::from(FOLDER),
        features: vec![name.to_string()],
        target_folder: Path::new(env!("CARGO_TARGET_TMPDIR")).join("wrong"),
    }
}

/// Returns the names of the files of a folder, without extensions.
fn names(folder: &str) -> BTreeSet<String> {
    std::fs::read_dir(Path::new(FOLDER).join(folder))
        .unwrap()
        .map(|entry| {
            let path = entry.unwrap().path();
            path.file_stem().unwrap().to_string_lossy().into_owned()
        })
        .collect()
}

/// Returns the builder's answer, without the folder of the checkout.
fn answer(name: &str, variant: Variant) -> Result<(), String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let root = root.canonicalize().unwrap();
    match compile(&program(name), variant) {
        Ok(modules) => {
            let entry_point = format!("{name}::{name}");
            assert_eq!(modules.keys().collect::<Vec<_>>(), [&entry_point]);
            Ok(())
        }
        Err(error) => Err(format!("{error:#}\n").replace(&format!("{}/", root.display()), "")),
    }
}

/// One test: the programs share a target folder and the error stream.
#[test]
fn wrong_programs_are_refused_with_what_to_do() {
    let mut programs = names("src");
    assert!(programs.remove("lib") && programs.remove(RIGHT));
    assert!(programs.len() > 10);
    let update = std::env::var_os("RELIEVO_UPDATE_GOLDEN").is_some();
    let mut wrong = Vec::new();
    for name in &programs {
        let text = match answer(name, Variant::Exact) {
            Err(text) => text,
            Ok(()) => panic!("{name} is accepted"),
        };
        assert!(text.contains("instead: "), "{name} has no advice: {text}");
        let file = format!("{FOLDER}/messages/{name}.txt");
        if update {
            std::fs::write(&file, &text).unwrap();
        } else if std::fs::read_to_string(&file).ok().as_ref() != Some(&text) {
            wrong.push(format!("{name}:\n{text}"));
        }
    }
    assert!(wrong.is_empty(), "not as expected:\n{}", wrong.join("\n"));
    assert_eq!(names("messages"), programs);

    answer(RIGHT, Variant::Exact).unwrap();
    // The fast variant takes all that rust-gpu takes.
    for name in &programs {
        let is_compiled = answer(name, Variant::Fast).is_ok();
        assert_eq!(
            is_compiled,
            !NOT_COMPILED.contains(&name.as_str()),
            "{name}"
        );
    }
}
