//! `cargo relievo export`: the fast modules in other shading languages.

use crate::place::ProjectArgument;
use anyhow::{Context, Result, anyhow, bail};
use clap::ValueEnum;
use relievo_shader_manifest::{Manifest, Project, changes};
use relievo_translate::{Target, translate};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// What the files need of the program that uses them.
const ABOUT: &str = "\
Each module becomes one file in each language: the name of its entry point, with `.` in the
place of `::`, and the language's extension. Where several crates are exported, each has a
folder.

Bindings of group 0 keep their numbers. GLSL and Metal have no groups: binding b of group g
has the number 16·g + b. Metal's buffer 30 has the lengths of the buffers, where a shader asks
for them.";

#[derive(clap::Args)]
#[command(after_help = ABOUT)]
pub struct Arguments {
    #[command(flatten)]
    project: ProjectArgument,
    /// The languages; by default all.
    #[arg(long, value_enum, value_delimiter = ',', value_name = "LANGUAGES")]
    target: Vec<Language>,
    /// The folder for the files.
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
    /// Export only the modules of this shader crate.
    #[arg(long = "crate", value_name = "NAME")]
    shader_crate: Option<String>,
}

#[derive(Clone, Copy, ValueEnum)]
enum Language {
    Spirv,
    Wgsl,
    Glsl,
    Hlsl,
    Msl,
}

/// A file in memory: its path in the output's folder, and its contents.
type File = (String, Vec<u8>);

pub fn run(arguments: &Arguments) -> Result<ExitCode> {
    let project = arguments.project.load()?;
    let changes = changes(&project)?;
    if !changes.is_empty() {
        bail!(
            "the compiled shaders are out of date; build them with `cargo relievo build`\n{}",
            changes.join("\n")
        );
    }
    let targets = targets(&arguments.target);
    let files = files(&project, arguments.shader_crate.as_deref(), &targets)?;
    write(&arguments.output, &files)?;
    let bytes: usize = files.iter().map(|(_, bytes)| bytes.len()).sum();
    println!(
        "{}: {} files, {bytes} bytes",
        arguments.output.display(),
        files.len()
    );
    Ok(ExitCode::SUCCESS)
}

/// Returns the requested languages, each once.
fn targets(asked: &[Language]) -> Vec<Target> {
    let mut targets: Vec<Target> = asked
        .iter()
        .map(|language| match language {
            Language::Spirv => Target::Spirv,
            Language::Wgsl => Target::Wgsl,
            Language::Glsl => Target::Glsl,
            Language::Hlsl => Target::Hlsl,
            Language::Msl => Target::Msl,
        })
        .collect();
    if targets.is_empty() {
        targets = Target::ALL.to_vec();
    }
    targets.sort();
    targets.dedup();
    targets
}

/// Translates the modules of a project, or of one of its shader crates.
fn files(project: &Project, only: Option<&str>, targets: &[Target]) -> Result<Vec<File>> {
    let crates: Vec<&str> = project
        .crates
        .iter()
        .map(|shaders| shaders.name.as_str())
        .filter(|name| only.is_none_or(|only| only == *name))
        .collect();
    if crates.is_empty() {
        let known = project.crates.iter().map(|shaders| shaders.name.as_str());
        bail!(
            "there is no shader crate {:?}; --crate takes {}",
            only.unwrap_or_default(),
            known.collect::<Vec<_>>().join(", ")
        );
    }
    let manifest = Manifest::load(project)?;
    let mut files = Vec::new();
    for name in &crates {
        let within = format!("{name}_fast/");
        let folder = if crates.len() > 1 {
            format!("{name}/")
        } else {
            String::new()
        };
        for module in manifest.modules.keys() {
            let stem = module
                .strip_prefix(&within)
                .and_then(|file| file.strip_suffix(".spv"));
            // Canaries serve tests.
            let Some(stem) = stem.filter(|stem| !stem.starts_with("canaries.")) else {
                continue;
            };
            let path = project.shader_folder().join(module);
            let bytes = std::fs::read(&path).with_context(|| {
                format!(
                    "{}: build the shaders with `cargo relievo build`",
                    path.display()
                )
            })?;
            for (file, bytes) in of_module(stem, &bytes, targets)? {
                files.push((format!("{folder}{file}"), bytes));
            }
        }
    }
    if files.is_empty() {
        bail!(
            "the project has no modules of {}; build them with `cargo relievo build`",
            crates.join(", ")
        );
    }
    Ok(files)
}

/// Translates the module of one entry point.
fn of_module(stem: &str, bytes: &[u8], targets: &[Target]) -> Result<Vec<File>> {
    let entry_point = stem.replace('.', "::");
    let (words, rest) = bytes.as_chunks::<4>();
    if !rest.is_empty() {
        bail!(
            "the entry point {entry_point}: its module has {} bytes, which are not whole words",
            bytes.len()
        );
    }
    let words: Vec<u32> = words.iter().copied().map(u32::from_le_bytes).collect();
    targets
        .iter()
        .map(|&target| {
            let written = translate(&words, target).map_err(|message| {
                anyhow!("the entry point {entry_point} cannot be written as {target}: {message}; change the shader, or leave {target} out with --target")
            })?;
            Ok((format!("{stem}.{}", target.extension(written.stage)), written.bytes))
        })
        .collect()
}

/// Writes all files, or none: they are written to a temporary folder in `folder`, and moved
/// when it is complete. Other files in `folder` stay.
fn write(folder: &Path, files: &[File]) -> Result<()> {
    let at = |path: &Path| path.display().to_string();
    let is_new = !folder.exists();
    std::fs::create_dir_all(folder).with_context(|| at(folder))?;
    let written = (|| {
        for (name, _) in files {
            let path = folder.join(name);
            if path.exists() && !path.is_file() {
                bail!("{}: it is not a file; choose another folder", at(&path));
            }
        }
        let part = tempfile::Builder::new()
            .prefix(".relievo-")
            .tempdir_in(folder)
            .with_context(|| at(folder))?;
        for (root, action) in [(part.path(), "write"), (folder, "move")] {
            for (name, bytes) in files {
                let path = root.join(name);
                let parent = path.parent().unwrap_or(root);
                std::fs::create_dir_all(parent)
                    .and_then(|()| match action {
                        "write" => std::fs::write(&path, bytes),
                        _ => std::fs::rename(part.path().join(name), &path),
                    })
                    .with_context(|| at(&folder.join(name)))?;
            }
        }
        Ok(())
    })();
    if written.is_err() && is_new {
        // Only an empty folder is removed.
        let _ = std::fs::remove_dir(folder);
    }
    written
}

#[cfg(test)]
mod tests {
    use super::*;
    use relievo_translate::portable;
    use std::collections::BTreeSet;

    fn relievo() -> Project {
        let folder = crate::place::checkout().unwrap();
        Project::load(&folder.join("Cargo.toml")).unwrap()
    }

    fn module(name: &str) -> Vec<u8> {
        std::fs::read(relievo().shader_folder().join(name)).unwrap()
    }

    #[test]
    fn modules_are_written_in_every_language() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["multiply_add", "third", "depth"] {
            let bytes = module(&format!("kernels_fast/{name}.spv"));
            let files = of_module(name, &bytes, &Target::ALL).unwrap();
            write(folder.path(), &files).unwrap();
            let read = |extension: &str| {
                std::fs::read(folder.path().join(format!("{name}.{extension}"))).unwrap()
            };
            let text = |extension: &str| String::from_utf8(read(extension)).unwrap();

            let wgsl = naga::front::wgsl::parse_str(&text("wgsl")).unwrap();
            let spirv = read("spv");
            let (words, _) = spirv.as_chunks::<4>();
            let words: Vec<u32> = words.iter().copied().map(u32::from_le_bytes).collect();
            for again in [wgsl, portable::read(&words).unwrap()] {
                let [entry_point] = again.entry_points.as_slice() else {
                    panic!("{name}")
                };
                assert_eq!(entry_point.stage, naga::ShaderStage::Compute);
                assert_eq!(entry_point.workgroup_size, [64, 1, 1]);
                assert_eq!(entry_point.name, name);
            }
            let glsl = text("comp");
            assert!(
                glsl.contains("local_size_x = 64") && glsl.contains("void main()"),
                "{glsl}"
            );
            assert!(
                glsl.contains("binding = 0") && glsl.contains("binding = 1"),
                "{glsl}"
            );
            let hlsl = text("hlsl");
            assert!(hlsl.contains("[numthreads(64, 1, 1)]"), "{hlsl}");
            assert!(hlsl.contains(&format!("void {name}(")), "{hlsl}");
            let metal = text("metal");
            assert!(metal.contains(&format!("kernel void {name}(")), "{metal}");
        }
        let names: BTreeSet<String> = std::fs::read_dir(folder.path())
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        assert_eq!(names.len(), 15, "{names:?}");
    }

    #[test]
    fn vertex_and_fragment_shaders_are_written() {
        for (name, extension) in [("vertex", "vert"), ("color_relief", "frag")] {
            let bytes = module(&format!("relievo_fast/{name}.spv"));
            let files = of_module(name, &bytes, &[Target::Glsl]).unwrap();
            assert_eq!(files[0].0, format!("{name}.{extension}"));
            assert!(!files[0].1.is_empty());
        }
    }

    #[test]
    fn what_naga_cannot_read_is_named() {
        let mut bytes = module("kernels_fast/third.spv");
        // An unknown capability.
        bytes.splice(20..20, [17, 0, 2, 0, 0xff, 0xff, 0, 0]);
        let error = of_module("light.third", &bytes, &Target::ALL)
            .unwrap_err()
            .to_string();
        for part in ["light::third", "spirv", "65535"] {
            assert!(error.contains(part), "{error}");
        }
        assert!(of_module("third", &bytes[..9], &Target::ALL).is_err());
        let error = files(&relievo(), Some("other"), &Target::ALL)
            .unwrap_err()
            .to_string();
        assert!(error.contains("relievo, kernels"), "{error}");
    }

    #[test]
    fn all_files_are_written_or_none() {
        let folder = tempfile::tempdir().unwrap();
        let files = [
            ("a.txt".to_string(), b"a".to_vec()),
            ("b/c.txt".to_string(), b"c".to_vec()),
        ];
        let new = folder.path().join("new/folder");
        write(&new, &files).unwrap();
        assert_eq!(std::fs::read(new.join("b/c.txt")).unwrap(), b"c");
        assert_eq!(std::fs::read_dir(&new).unwrap().count(), 2);

        let taken = folder.path().join("taken");
        std::fs::create_dir_all(taken.join("b/c.txt")).unwrap();
        assert!(write(&taken, &files).is_err());
        assert_eq!(std::fs::read_dir(&taken).unwrap().count(), 1);

        let file = folder.path().join("file");
        std::fs::write(&file, "").unwrap();
        assert!(write(&file, &files).is_err());
    }
}
