//! Prints what Mesa's compiler for AMD makes of shaders.
//!
//! ```sh
//! cargo run -p relievo-compiled -- RDNA3 VERTEX.spv FRAGMENT.spv [--texts]
//! ```

use relievo_compiled::{Driver, GENERATIONS, Shader, Texts, manifest};
use std::error::Error;
use std::process::ExitCode;

const USAGE: &str =
    "usage: relievo-compiled RDNA2|RDNA3 COMPUTE.spv|VERTEX.spv FRAGMENT.spv [--texts]";

fn run() -> Result<(), Box<dyn Error>> {
    let (options, arguments): (Vec<String>, Vec<String>) = std::env::args()
        .skip(1)
        .partition(|argument| argument.starts_with("--"));
    let texts = match options.as_slice() {
        [] => Texts::None,
        [only] if only == "--texts" => Texts::All,
        _ => return Err(USAGE.into()),
    };
    let (generation, files) = arguments.split_first().ok_or(USAGE)?;
    let mut all = GENERATIONS.iter();
    let generation = all.find(|known| known.name == generation).ok_or(USAGE)?;
    let manifest =
        manifest().ok_or("Mesa's driver for AMD is not here; install mesa-vulkan-drivers")?;
    for (name, value) in generation.environment(&manifest) {
        // SAFETY: no other thread is running yet.
        unsafe { std::env::set_var(name, value) };
    }
    let mut shaders = Vec::new();
    for file in files {
        let bytes = std::fs::read(file).map_err(|error| format!("{file}: {error}"))?;
        shaders.push(Shader::read(&bytes).map_err(|error| format!("{file}: {error}"))?);
    }
    let shaders: Vec<&Shader> = shaders.iter().collect();
    let driver = Driver::open()?;
    println!("{}, {}", driver.name(), generation.name);
    // SAFETY: who runs this answers for the files, which are not drawn with.
    for made in unsafe { driver.compile(&shaders, texts)? } {
        println!("{:?}", made.stage);
        for (name, value) in &made.statistics {
            println!("  {name}: {value}");
        }
        for (name, text) in &made.texts {
            println!("== {name}\n{text}");
        }
    }
    Ok(())
}

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}
