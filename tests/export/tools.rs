//! Tools that check the shading languages. Where one is not installed, its tests say
//! so and do nothing; with RELIEVO_TOOLS=required that is a failure.

use super::cases::{cases, file};
use naga::valid::{Capabilities, ValidationFlags, Validator};
use relievo::export::{ExportedFile, Options, Output, export};
use relievo_tests::lacking;
use std::collections::BTreeSet;
use std::io::ErrorKind;
use std::path::Path;
use std::process::Command;

/// Arguments of a program, and the contents of the files that they name.
type Run = (&'static [&'static str], Vec<Vec<u8>>);

/// A program, and its arguments for the files of a folder.
struct Tool {
    program: &'static str,
    /// One run each.
    runs: &'static [&'static [&'static str]],
    /// Whether continuous integration has it.
    is_packaged: bool,
}

const TOOLS: [Tool; 3] = [
    Tool {
        program: "spirv-val",
        runs: &[
            &["--target-env", "vulkan1.1", "vertex.spv"],
            &["--target-env", "vulkan1.1", "fragment.spv"],
        ],
        is_packaged: true,
    },
    // Links both GLSL stages, and compiles HLSL, which it supports well enough.
    Tool {
        program: "glslangValidator",
        runs: &[
            &["-l", "vertex.vert", "fragment.frag"],
            &[
                "-D",
                "-V",
                "-S",
                "vert",
                "-e",
                "vs_main",
                "-o",
                "hlsl.spv",
                "vertex.hlsl",
            ],
            &[
                "-D",
                "-V",
                "-S",
                "frag",
                "-e",
                "fs_main",
                "-o",
                "hlsl.spv",
                "fragment.hlsl",
            ],
        ],
        is_packaged: true,
    },
    // Chromium's, which no distribution packages.
    Tool {
        program: "tint",
        runs: &[
            &["--format", "wgsl", "vertex.wgsl"],
            &["--format", "wgsl", "fragment.wgsl"],
        ],
        is_packaged: false,
    },
];

impl Tool {
    /// Returns whether it is installed; fails if it rejects the `files` of `folder`. Runs that are
    /// in `done` are left out, others are added.
    fn accepts(
        &self,
        folder: &Path,
        files: &[ExportedFile],
        name: &str,
        done: &mut BTreeSet<Run>,
    ) -> bool {
        for arguments in self.runs {
            let named = files
                .iter()
                .filter(|file| arguments.contains(&file.name.as_str()));
            let contents = named.map(|file| file.bytes.clone()).collect();
            if !done.insert((*arguments, contents)) {
                continue;
            }
            let run = Command::new(self.program)
                .args(*arguments)
                .current_dir(folder)
                .output();
            match run {
                Ok(output) => assert!(
                    output.status.success(),
                    "{name}: {} {}\n{}{}",
                    self.program,
                    arguments.join(" "),
                    String::from_utf8_lossy(&output.stdout),
                    String::from_utf8_lossy(&output.stderr)
                ),
                Err(error) if error.kind() == ErrorKind::NotFound => return false,
                Err(error) => panic!("{}: {error}", self.program),
            }
        }
        true
    }
}

/// naga accepts its own WGSL with WebGPU's required features only; what it has `read` before is
/// not read again.
fn reads_wgsl(files: &[ExportedFile], name: &str, read: &mut BTreeSet<Vec<u8>>) {
    for stage in ["vertex.wgsl", "fragment.wgsl"] {
        let bytes = file(files, stage);
        if !read.insert(bytes.to_vec()) {
            continue;
        }
        let text = std::str::from_utf8(bytes).unwrap();
        let module = naga::front::wgsl::parse_str(text)
            .unwrap_or_else(|error| panic!("{name}: {}", error.emit_to_string(text)));
        Validator::new(ValidationFlags::all(), Capabilities::empty())
            .validate(&module)
            .unwrap_or_else(|error| panic!("{name}: {}", error.emit_to_string(text)));
    }
}

/// Each shader in each language, with every output.
#[test]
fn the_tools_of_each_language_accept_every_shader() {
    let mut missing: Vec<&Tool> = Vec::new();
    let mut done = BTreeSet::new();
    let mut read = BTreeSet::new();
    for case in cases().iter().filter(|case| case.scene.objects.len() == 1) {
        for output in [Output::Color, Output::Words, Output::Hit] {
            let options = Options {
                output,
                ..Options::default()
            };
            let files = export(&case.scene, &options).unwrap();
            reads_wgsl(&files, &case.name, &mut read);
            let folder = tempfile::tempdir().unwrap();
            for file in &files {
                std::fs::write(folder.path().join(&file.name), &file.bytes).unwrap();
            }
            for tool in &TOOLS {
                let is_known = missing.iter().any(|known| known.program == tool.program);
                if !is_known && !tool.accepts(folder.path(), &files, &case.name, &mut done) {
                    missing.push(tool);
                }
            }
        }
    }
    for tool in missing {
        if tool.is_packaged {
            lacking(tool.program);
        } else {
            eprintln!("NOT TESTED: {} is not here", tool.program);
        }
    }
}

/// The tools reject a wrong shader.
#[test]
fn the_tools_refuse_what_is_wrong() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["vertex", "fragment"] {
        for extension in ["spv", "wgsl", "hlsl", "vert", "frag"] {
            let path = folder.path().join(format!("{name}.{extension}"));
            std::fs::write(path, "this is no shader").unwrap();
        }
    }
    for tool in &TOOLS {
        for arguments in tool.runs {
            let run = Command::new(tool.program)
                .args(*arguments)
                .current_dir(folder.path())
                .output();
            if let Ok(output) = run {
                assert!(!output.status.success(), "{}", tool.program);
            }
        }
    }
}
