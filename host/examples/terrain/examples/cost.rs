//! Measures what exactness costs: times of the exact module and of the fast one, in turn.
//!
//! `cargo run --release -p terrain --example cost`, in the folder of this package.

use glam::UVec2;
use relievo_bitwise::{
    Device, DeviceError, Generator, Module, Picture, Pixels, Recorded, Runner, adapters,
};
use relievo_test::words;
use std::time::Instant;
use terrain::view::View;
use terrain::{noise, terrain as ground};

const SIZE: UVec2 = UVec2::new(320, 200);
const INPUTS: usize = 1 << 18;
const TURNS: usize = 9;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let modules = [load("exact")?, load("fast")?];
    for adapter in adapters()
        .into_iter()
        .filter(|adapter| adapter.takes_spirv())
    {
        let device = adapter.open()?;
        println!("{}", device.describe());
        print(
            "landscape",
            compare(&modules, |module| draw(&device, module))?,
        );
        for kernel in [
            noise::fbm::KERNEL,
            ground::height::KERNEL,
            ground::normal::KERNEL,
        ] {
            let mut inputs = vec![0; INPUTS * kernel.input_words as usize];
            Generator::new(&kernel, &Recorded::new(), 1)?.fill(0, &mut inputs);
            let mut runners = [
                Runner::new(&device, &modules[0])?,
                Runner::new(&device, &modules[1])?,
            ];
            let mut number = 0;
            let times = compare(&modules, |_| {
                number += 1;
                runners[(number + 1) % 2].run(&kernel, &inputs).map(|_| ())
            })?;
            print(kernel.name, times);
        }
    }
    Ok(())
}

/// Loads the modules of a variant.
fn load(variant: &str) -> Result<Module, Box<dyn std::error::Error>> {
    let folder = format!("{}/shaders/terrain_{variant}", env!("CARGO_MANIFEST_DIR"));
    let files: Vec<Vec<u8>> = std::fs::read_dir(folder)?
        .map(|entry| std::fs::read(entry?.path()))
        .collect::<Result<_, _>>()?;
    let files: Vec<&[u8]> = files.iter().map(Vec::as_slice).collect();
    // SAFETY: the builder has validated them, and they are committed with their digests.
    Ok(unsafe { Module::untouched(&files)? })
}

fn draw(device: &Device, module: &Module) -> Result<(), DeviceError> {
    let picture = Picture {
        vertex: "cover",
        fragment: "landscape",
        pixels: Pixels::Floats,
        size: SIZE.to_array(),
        vertices: 3,
        buffers: &[&words((View::overlook(10.0), SIZE))],
    };
    picture.draw(device, module).map(|_| ())
}

/// Returns the median time of each, seconds, and of their ratio.
fn compare(
    modules: &[Module; 2],
    mut run: impl FnMut(&Module) -> Result<(), DeviceError>,
) -> Result<[f64; 3], DeviceError> {
    let mut all = Vec::new();
    for turn in 0..=TURNS {
        let mut times = [0.0; 2];
        for (module, time) in modules.iter().zip(&mut times) {
            let start = Instant::now();
            run(module)?;
            *time = start.elapsed().as_secs_f64();
        }
        // The first compiles the shaders.
        if turn > 0 {
            all.push([times[0], times[1], times[0] / times[1]]);
        }
    }
    Ok([0, 1, 2].map(|what| {
        let mut column: Vec<f64> = all.iter().map(|times| times[what]).collect();
        column.sort_by(f64::total_cmp);
        column[TURNS / 2]
    }))
}

fn print(name: &str, [exact, fast, ratio]: [f64; 3]) {
    println!(
        "  {name}: {:.1} / {:.1} ms = {ratio:.2}",
        1e3 * exact,
        1e3 * fast
    );
}
