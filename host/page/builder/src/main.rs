//! Builds the page: compiles `host/page` to WebAssembly, generates its
//! JavaScript bindings, and copies the static files.

use anyhow::{Context, ensure};
use clap::Parser;
use flate2::Compression;
use flate2::write::GzEncoder;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use wasm_bindgen_cli_support::Bindgen;

const TARGET: &str = "wasm32-unknown-unknown";
const PROFILE: &str = "page";
const STATIC: [(&str, &str); 5] = [
    ("index.html", include_str!("../../static/index.html")),
    ("page.css", include_str!("../../static/page.css")),
    ("page.js", include_str!("../../static/page.js")),
    ("worker.js", include_str!("../../static/worker.js")),
    ("workshop.js", include_str!("../../static/workshop.js")),
];

/// Build the page into a folder for any static server
#[derive(Parser)]
struct Arguments {
    /// Output folder
    #[arg(short, long, value_name = "DIR", default_value = "out/page")]
    output: PathBuf,
}

fn main() -> anyhow::Result<()> {
    let arguments = Arguments::parse();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../..");
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let target =
        std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), PathBuf::from);
    let status = Command::new(cargo)
        .current_dir(&root)
        .args(["build", "--package", "relievo-page", "--lib"])
        .args(["--target", TARGET, "--profile", PROFILE, "--target-dir"])
        .arg(&target)
        .status()
        .context("cargo cannot be started")?;
    ensure!(
        status.success(),
        "the page does not compile; if its target is missing: rustup target add {TARGET}"
    );
    let module = target.join(TARGET).join(PROFILE).join("relievo_page.wasm");
    std::fs::create_dir_all(&arguments.output)
        .with_context(|| arguments.output.display().to_string())?;
    Bindgen::new()
        .input_path(&module)
        .web(true)?
        .omit_default_module_path(false)
        .typescript(false)
        .remove_name_section(true)
        .remove_producers_section(true)
        .generate(&arguments.output)
        .with_context(|| module.display().to_string())?;
    for (name, text) in STATIC {
        let path = arguments.output.join(name);
        std::fs::write(&path, text).with_context(|| path.display().to_string())?;
    }
    let path = arguments.output.join("relievo_page_bg.wasm");
    let bytes = std::fs::read(&path).with_context(|| path.display().to_string())?;
    let mut packed = GzEncoder::new(Vec::new(), Compression::best());
    packed.write_all(&bytes)?;
    println!(
        "{}: {} bytes of WebAssembly, {} as a server sends them (gzip)",
        arguments.output.display(),
        bytes.len(),
        packed.finish()?.len()
    );
    Ok(())
}
