//! Calls rust-gpu, and explains its errors.

use crate::advice;
use crate::shader_crate::{ShaderCrate, Variant};
use anyhow::{Context, Result, bail};
use relievo_shader_manifest::{INSTALL, NIGHTLY};
use spirv_builder::{ShaderPanicStrategy, SpirvBuilder, SpirvMetadata};
use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

/// The version of rust-gpu.
pub const RUST_GPU: &str = "0.11.0";
/// What modules are compiled for.
pub const TARGET: &str = "spirv-unknown-vulkan1.1";

/// The words of one module for each entry point, since drivers read the whole module for
/// every pipeline.
pub type Modules = BTreeMap<String, Vec<u32>>;

/// Compiles a shader crate with rust-gpu. The modules of the exact variants are not optimised.
pub fn run(shaders: &ShaderCrate, variant: Variant) -> Result<Modules> {
    let mut features = shaders.features.clone();
    features.extend(variant.features().iter().map(|name| name.to_string()));
    // What does not depend on features is compiled once.
    let target_folder = if variant == Variant::Fast {
        "fast"
    } else {
        "exact"
    };
    let mut spirv = SpirvBuilder::new(&shaders.folder, TARGET)
        .multimodule(true)
        .spirv_metadata(SpirvMetadata::None)
        .target_dir_path(shaders.target_folder.join(target_folder));
    spirv.toolchain_overwrite = Some(NIGHTLY.to_string());
    if variant != Variant::Fast {
        // The exact module is optimised after it is decorated. Without spirv-opt nothing
        // strips debug information, which tells where operations come from.
        spirv.extra_args = vec!["--no-spirv-opt".to_string()];
        // Removed again: see `panics`.
        spirv.shader_panic_strategy = ShaderPanicStrategy::DebugPrintfThenExit {
            print_inputs: false,
            print_backtrace: true,
        };
    }
    let spirv = spirv.shader_crate_features(features);
    let (result, errors) = with_stderr(|| spirv.build())?;
    let result = result.with_context(|| {
        let mut message = explain(&errors);
        message.push_str("rust-gpu did not compile ");
        message.push_str(&shaders.folder.display().to_string());
        message
    })?;
    let mut modules = BTreeMap::new();
    for (entry_point, path) in result.module.unwrap_multi() {
        let words = std::fs::read(path)?
            .chunks_exact(4)
            .map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]]))
            .collect();
        modules.insert(entry_point.clone(), words);
    }
    Ok(modules)
}

/// Returns what to write instead of what rust-gpu has refused, and its own words.
pub fn explain(errors: &str) -> String {
    let mut advised = BTreeSet::new();
    let mut text = String::new();
    let errors: Vec<&str> = errors.lines().collect();
    for (i, line) in errors.iter().enumerate() {
        let Some(message) = line.strip_prefix("error: ") else {
            continue;
        };
        let Some(advice) = advice::of_rust_gpu(message) else {
            continue;
        };
        // The first place of each: others mostly follow from it.
        if advised.insert(advice) {
            let place = errors[i + 1..]
                .iter()
                .take_while(|line| !line.starts_with("error"))
                .filter_map(|line| line.trim_start().strip_prefix("--> "))
                .map(|place| place.replace(['<', '>'], ""))
                .find(|place| !place.starts_with('/'));
            text.push_str(message);
            if let Some(place) = place {
                text.push_str("\n  at ");
                text.push_str(&place);
            }
            text.push_str("\n  instead: ");
            text.push_str(advice);
            text.push_str("\n\n");
        }
    }
    text
}

/// Calls `action`; returns its result, and what it and its children wrote to the standard
/// error stream, which they write all the same.
#[cfg(unix)]
fn with_stderr<T>(action: impl FnOnce() -> T) -> Result<(T, String)> {
    use std::io::{Read, Write};
    use std::os::fd::AsFd;

    let (mut reader, writer) = std::io::pipe()?;
    let original = std::io::stderr().as_fd().try_clone_to_owned()?;
    let mut screen = std::fs::File::from(original.try_clone()?);
    let copier = std::thread::spawn(move || {
        let mut all = Vec::new();
        let mut part = [0; 4096];
        while let Ok(count @ 1..) = reader.read(&mut part) {
            all.extend(&part[..count]);
            // A closed screen is no reason to stop the compiler.
            let _ = screen.write_all(&part[..count]);
        }
        String::from_utf8_lossy(&all).into_owned()
    });
    rustix::stdio::dup2_stderr(&writer)?;
    drop(writer);
    let result = action();
    // The last writer closes, and the copier ends.
    rustix::stdio::dup2_stderr(&original)?;
    match copier.join() {
        Ok(errors) => Ok((result, errors)),
        Err(_) => bail!("cannot read the compiler's messages"),
    }
}

/// Calls `action`. Elsewhere its messages are not read, and so not explained.
#[cfg(not(unix))]
fn with_stderr<T>(action: impl FnOnce() -> T) -> Result<(T, String)> {
    Ok((action(), String::new()))
}

/// Returns the version of the nightly compiler, in its own words.
pub fn rustc_version() -> Result<String> {
    let output = Command::new("rustc")
        .arg(format!("+{NIGHTLY}"))
        .arg("--version")
        .output()
        .context("cannot run rustc through rustup")?;
    if !output.status.success() {
        bail!("{NIGHTLY} is not installed: {INSTALL}");
    }
    Ok(String::from_utf8(output.stdout)?.trim().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_explained_once_with_the_users_line() {
        let errors = "\
warning: unused
error: `f64` type used without `OpCapability Float64`
    |
note: used from within `<f64 as core::convert::From<f32>>::from`
   --> </rust/library/core/src/convert/num.rs>:176:1
note: called by `wrong::double`
   --> <src/lib.rs>:54:17
error: `f64` type used without `OpCapability Float64`
error: could not compile `wrong` (lib) due to 2 previous errors
";
        let text = explain(errors);
        assert!(
            text.starts_with(
                "`f64` type used without `OpCapability Float64`\n  at src/lib.rs:54:17\n  instead: "
            ),
            "{text}"
        );
        assert_eq!(text.matches("instead").count(), 1, "{text}");
        assert_eq!(explain("error[E0308]: mismatched types"), "");
    }

    #[cfg(unix)]
    #[test]
    fn messages_of_children_are_read() {
        let (status, errors) = with_stderr(|| {
            Command::new("sh")
                .args(["-c", "echo from a child >&2"])
                .status()
        })
        .unwrap();
        assert!(status.unwrap().success());
        assert!(errors.contains("from a child"), "{errors}");
    }
}
