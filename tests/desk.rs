//! A temporary folder, and runs of the program in it.

use crate::{left_out, program};
use assert_cmd::Command;
use image::{GrayImage, Luma};
use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;
use std::time::Duration;
use tempfile::TempDir;

/// Default arguments of rendering.
pub const RENDER: &str = "render scene.toml --backend cpu --size 64x48";

/// Output of a run of the program.
pub struct Outcome {
    /// Exit code; none if a signal ended it.
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

impl Outcome {
    /// Runs `command`; a hanging run is stopped and fails.
    pub fn of(command: &mut Command) -> Outcome {
        let output = command
            .timeout(Duration::from_secs(300))
            .env_remove("RUST_BACKTRACE")
            .output()
            .unwrap();
        let outcome = Outcome {
            code: output.status.code(),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        };
        assert!(!outcome.stderr.contains("panicked"), "{}", outcome.stderr);
        outcome
    }

    #[track_caller]
    pub fn done(self) -> Outcome {
        assert_eq!(self.code, Some(0), "{}", self.stderr);
        self
    }
}

/// Splits a command line. These scenes name this project's assets, which lie
/// outside their folders.
pub fn words(arguments: &str) -> Vec<&str> {
    let loads_scenes = [
        "render", "info", "explain", "verify", "accuracy", "bench", "tradeoff", "export",
    ];
    let mut words: Vec<&str> = arguments.split_whitespace().collect();
    if words
        .first()
        .is_some_and(|word| loads_scenes.contains(word))
    {
        words.push("--allow-outside");
    }
    words
}

/// A temporary folder.
pub struct Desk(pub TempDir);

impl Desk {
    pub fn new() -> Desk {
        Desk(tempfile::tempdir().unwrap())
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: &str, contents: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path(name);
        fs::write(&path, contents).unwrap();
        path
    }

    /// Writes a gray image.
    pub fn image(&self, name: &str, width: u32, height: u32, luma: impl Fn(u32, u32) -> u8) {
        GrayImage::from_fn(width, height, |x, y| Luma([luma(x, y)]))
            .save(self.path(name))
            .unwrap();
    }

    /// Lists everything in and below the folder.
    pub fn listing(&self) -> BTreeSet<PathBuf> {
        let mut found = BTreeSet::new();
        let mut folders = vec![self.0.path().to_path_buf()];
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(folder).unwrap() {
                let entry = entry.unwrap();
                if entry.file_type().unwrap().is_dir() {
                    folders.push(entry.path());
                }
                found.insert(entry.path());
            }
        }
        found
    }

    /// Returns the program, to run in this folder.
    pub fn command(&self) -> Command {
        let mut command = Command::new(program());
        command.current_dir(self.0.path());
        command
    }

    /// Runs the program with arguments separated by spaces.
    pub fn run(&self, arguments: &str) -> Outcome {
        Outcome::of(self.command().args(words(arguments)))
    }

    /// Asserts that a run fails with exit code `code`, prints each of `parts`
    /// (separated by `|`), and writes nothing.
    /// A command that this build leaves out must name the feature it needs.
    #[track_caller]
    pub fn fails(&self, arguments: &str, code: i32, parts: &str) {
        let (code, parts) = match left_out(arguments) {
            Some(feature) => (2, feature),
            None => (code, parts),
        };
        let before = self.listing();
        let Outcome {
            code: found,
            stdout,
            stderr,
        } = self.run(arguments);
        assert_eq!(found, Some(code), "{arguments}\n{stdout}\n{stderr}");
        assert!(stderr.starts_with("error: "), "{stderr}");
        for part in parts.split('|').map(str::trim) {
            assert!(stderr.contains(part), "{part:?} is missing in\n{stderr}");
        }
        // The system's reason is printed once.
        assert!(stderr.matches("(os error").count() <= 1, "{stderr}");
        assert_eq!(self.listing(), before, "{stderr}");
    }
}

/// Runs the program with an address space of `bytes`.
#[cfg(target_os = "linux")]
pub fn within_memory(desk: &Desk, bytes: u64, arguments: &str) -> Outcome {
    let mut command = Command::new("sh");
    command
        .args([
            "-c",
            &format!("ulimit -v {}; exec \"$0\" \"$@\"", bytes / 1024),
        ])
        .arg(program())
        .args(words(arguments))
        .env("RAYON_NUM_THREADS", "2")
        .current_dir(desk.0.path());
    Outcome::of(&mut command)
}
