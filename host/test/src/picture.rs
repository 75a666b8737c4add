//! Compares whole pictures.

use crate::session::session;
use rayon::prelude::*;
use relievo_bitwise::{Batch, Picture, Pixels, Tally};
use relievo_kernel::glam::UVec2;
use relievo_kernel::{ToWords, Writer};

/// Number of words of a pixel.
const CHANNELS: usize = 4;

/// Draws a picture on every adapter, and compares each pixel with what `color` returns for
/// it: four words, such as a `Vec4`. Pixels are counted from the top left.
///
/// # Panics
/// If a word differs, with the first pixel and the rectangle of all; if the shaders are
/// missing or older than their sources; if a device fails.
#[track_caller]
pub fn assert_picture<R: ToWords>(picture: &Picture, color: impl Fn(UVec2) -> R + Sync) {
    assert_eq!(
        R::WORDS as usize,
        CHANNELS,
        "a pixel has four words; return a Vec4 or UVec4"
    );
    let cpu = on_cpu(picture.size, &color);
    let mut reports = Vec::new();
    for device in &session().devices {
        let runner = device.lock();
        match picture.draw(runner.device(), runner.module()) {
            Ok(mut gpu) => {
                if picture.pixels == Pixels::Floats {
                    gpu.iter_mut().for_each(without_sign_of_zero);
                }
                let adapter = runner.device().describe();
                reports.extend(report(adapter, picture, &gpu, &cpu));
            }
            Err(error) => reports.push(error.to_string()),
        }
    }
    assert!(reports.is_empty(), "{}", reports.join("\n\n"));
}

/// The sign of zero has no meaning, and the CPU's words have none.
fn without_sign_of_zero(word: &mut u32) {
    if *word == (-0.0_f32).to_bits() {
        *word = 0;
    }
}

/// Returns the words of all pixels.
fn on_cpu<R: ToWords>(size: [u32; 2], color: &(impl Fn(UVec2) -> R + Sync)) -> Vec<u32> {
    let mut words = vec![0; CHANNELS * size[0] as usize * size[1] as usize];
    let rows = words.par_chunks_mut((CHANNELS * size[0] as usize).max(1));
    (0..size[1]).into_par_iter().zip(rows).for_each(|(y, row)| {
        for (x, pixel) in (0..).zip(row.chunks_exact_mut(CHANNELS)) {
            color(UVec2::new(x, y)).write(&mut Writer(pixel.iter_mut()));
        }
    });
    words
}

/// Returns what is said of pictures that differ.
fn report(adapter: &str, picture: &Picture, gpu: &[u32], cpu: &[u32]) -> Option<String> {
    let tally = Tally::of(&Batch {
        first: 0,
        inputs: &[],
        input_words: 0,
        gpu,
        cpu,
        output_words: CHANNELS,
    });
    let first = tally.first.first()?;
    let width = u64::from(picture.size[0]);
    let (mut low, mut high) = (UVec2::MAX, UVec2::ZERO);
    for (index, (gpu, cpu)) in (0..).zip(gpu.chunks(CHANNELS).zip(cpu.chunks(CHANNELS))) {
        if gpu != cpu {
            let at = UVec2::new((index % width) as u32, (index / width) as u32);
            (low, high) = (low.min(at), high.max(at));
        }
    }
    Some(format!(
        "{} differs on {adapter}: {} of {} pixels, by up to {} ULP, between {low} and {high}\n\n  pixel ({}, {}), channel {}: GPU {:#010x} = {:?}, CPU {:#010x} = {:?}",
        picture.fragment,
        tally.inputs_different,
        tally.inputs,
        tally.largest,
        first.index % width,
        first.index / width,
        first.word,
        first.gpu,
        f32::from_bits(first.gpu),
        first.cpu,
        f32::from_bits(first.cpu),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use relievo_kernel::glam::Vec4;

    #[test]
    fn pixels_that_differ_are_reported_with_their_rectangle() {
        let picture = Picture {
            vertex: "cover",
            fragment: "color",
            pixels: Pixels::Floats,
            size: [3, 2],
            vertices: 3,
            buffers: &[],
        };
        let color = |pixel: UVec2| Vec4::new(pixel.x as f32, pixel.y as f32, -0.0, 1.0);
        let cpu = on_cpu(picture.size, &color);
        assert_eq!(
            cpu[4 * 5..],
            [2.0_f32.to_bits(), 1.0_f32.to_bits(), 0, 1.0_f32.to_bits()]
        );
        assert_eq!(report("a device", &picture, &cpu, &cpu), None);
        let mut gpu = cpu.clone();
        gpu[4 * 2 + 1] += 1;
        gpu[4 * 4 + 3] -= 1;
        let text = report("a device", &picture, &gpu, &cpu).unwrap();
        assert_eq!(
            text,
            "color differs on a device: 2 of 6 pixels, by up to 1 ULP, between [1, 0] and [2, 1]\n\n  pixel (2, 0), channel 1: GPU 0x00000001 = 1e-45, CPU 0x00000000 = 0.0"
        );
    }
}
