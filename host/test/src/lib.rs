//! Tests of shader functions and pictures: the GPU's words against the CPU's.
//!
//! For projects whose shaders are built by `cargo relievo build`. The attribute
//! `relievo_kernel::kernel` writes a test of each function, which calls [`assert_equal`].
//! A picture of a fragment shader is compared by [`assert_picture`]:
//!
//! ```no_run
//! use relievo_kernel::glam::{UVec2, Vec4};
//! use relievo_test::{Picture, Pixels, assert_picture};
//!
//! fn gradient(pixel: UVec2) -> Vec4 {
//!     Vec4::new(0.01 * pixel.x as f32, 0.01 * pixel.y as f32, 0.5, 1.0)
//! }
//!
//! let picture = Picture {
//!     vertex: "cover",
//!     fragment: "gradient",
//!     pixels: Pixels::Floats,
//!     size: [320, 200],
//!     vertices: 3,
//!     buffers: &[],
//! };
//! assert_picture(&picture, gradient);
//! ```
//!
//! # Where they run
//!
//! On every adapter that takes SPIR-V unchanged (Vulkan) and that passes the canaries:
//! small functions that show whether it computes f32 arithmetic exactly. Others are left
//! out, and the tests say so; so they do where there is no adapter at all. These lines are
//! shown even if the test passes.
//!
//! | environment variable | |
//! |---|---|
//! | `RELIEVO_ADAPTER=required` | no adapter to compare on is an error |
//! | `RELIEVO_INPUTS=N` | number of inputs of each function, 65,536 by default; 4294967296 gives a function of one `f32` in the domain `ANY` every number |
//!
//! A project sets them for good in `.cargo/config.toml`, in the section `[env]`.
//!
//! # Which shaders
//!
//! Those of the folder that the project names in its `Cargo.toml`. If a source has changed
//! since they were built, the tests fail and name it.

mod input;
mod names;
mod picture;
mod report;
mod session;

pub use picture::assert_picture;
pub use relievo_bitwise::{Picture, Pixels};

use relievo_bitwise::{
    Batch, DeviceError, Plan, Recorded, Runner, Tally, compare_kernel, evaluate,
};
use relievo_kernel::{Kernel, ToWords, Writer};
use session::session;
use std::panic::Location;

/// Returns the words of a value, such as those of a buffer that a shader reads by
/// `relievo_kernel::buffers::load`.
///
/// ```
/// assert_eq!(relievo_test::words((1.0_f32, 7_u32)), [0x3f80_0000, 7]);
/// ```
pub fn words<T: ToWords>(value: T) -> Vec<u32> {
    let mut words = vec![0; T::WORDS as usize];
    value.write(&mut Writer(words.iter_mut()));
    words
}

/// Seed of the inputs, the same in each run.
const SEED: u64 = 1;

/// Compares a function on every adapter with the CPU, on inputs of its domains.
///
/// # Panics
/// If a word differs, with a simple input that shows it and a test to paste; if the
/// shaders are missing or older than their sources; if a device fails; if another kernel
/// of the crate has the same name.
#[track_caller]
pub fn assert_equal(kernel: &Kernel) {
    names::check(kernel.name, Location::caller());
    let plan = Plan {
        inputs: session().inputs,
        seed: SEED,
        recorded: &Recorded::new(),
    };
    compare(kernel, |runner| {
        compare_kernel(runner, kernel, &plan, &|_| ())
    });
}

/// Compares a function on given inputs, a tuple of its arguments each. `proptest` may make
/// them.
///
/// ```no_run
/// # use relievo_kernel::{domain::NUMBER, table, Kernel};
/// # const SUM: Kernel = (table! { sum(f32: NUMBER, f32: NUMBER) -> f32 = |a: f32, b: f32| a + b; })[0];
/// relievo_test::assert_equal_for(&SUM, &[(0.1_f32, 0.2_f32), (1e8, 1.0)]);
/// ```
///
/// # Panics
/// Like [`assert_equal`], and if the arguments have another number of words.
#[track_caller]
pub fn assert_equal_for<T: ToWords + Copy>(kernel: &Kernel, inputs: &[T]) {
    assert_eq!(
        T::WORDS,
        kernel.input_words,
        "{}: an input has another number of words than the arguments; give a tuple of all of them",
        kernel.name
    );
    assert_equal_words(
        kernel,
        &inputs
            .iter()
            .flat_map(|&input| words(input))
            .collect::<Vec<_>>(),
    );
}

/// Compares a function on given inputs, as the words of all arguments one after another.
///
/// # Panics
/// Like [`assert_equal`], and if the last input is incomplete.
#[track_caller]
pub fn assert_equal_words(kernel: &Kernel, inputs: &[u32]) {
    input::check(kernel, inputs);
    compare(kernel, |runner| {
        let gpu = runner.run(kernel, inputs)?;
        Ok(tally(kernel, inputs, &gpu))
    });
}

/// Checks that the comparison would see a function that is wrong: the CPU runs `twin`, and
/// some words must differ from the GPU's on every adapter; from the CPU's, where there is
/// none.
///
/// # Panics
/// If no word differs.
#[track_caller]
pub fn assert_differs(kernel: &Kernel, twin: &Kernel) {
    assert_eq!(
        (twin.input_words, twin.output_words),
        (kernel.input_words, kernel.output_words),
        "{} has other arguments or results than {}",
        twin.name,
        kernel.name
    );
    let inputs = input::generated(kernel, SEED, 1 << 14);
    let of = |runner: Option<&mut Runner>| match runner {
        Some(runner) => runner.run(kernel, &inputs),
        None => Ok(on_cpu(kernel, &inputs)),
    };
    let mut devices = session().devices.iter();
    let mut device = devices.next();
    loop {
        let (name, words) = match device {
            Some(device) => {
                let mut runner = device.lock();
                let name = runner.device().describe().to_string();
                (name, of(Some(&mut runner)))
            }
            None => ("the CPU".to_string(), of(None)),
        };
        let words = words.unwrap_or_else(|error| panic!("{error}"));
        assert!(
            tally(twin, &inputs, &words).different > 0,
            "{} is the same as {} on {name}: the comparison would not see it",
            twin.name,
            kernel.name
        );
        device = devices.next();
        if device.is_none() {
            return;
        }
    }
}

/// Compares on each device, and panics with the reports of all.
#[track_caller]
fn compare(kernel: &Kernel, mut run: impl FnMut(&mut Runner) -> Result<Tally, DeviceError>) {
    let mut reports = Vec::new();
    for device in &session().devices {
        let mut runner = device.lock();
        let report = run(&mut runner).and_then(|tally| report::of(&mut runner, kernel, &tally));
        match report {
            Ok(report) => reports.extend(report),
            Err(error) => reports.push(error.to_string()),
        }
    }
    assert!(reports.is_empty(), "{}", reports.join("\n\n"));
}

/// Runs a function on the CPU.
fn on_cpu(kernel: &Kernel, inputs: &[u32]) -> Vec<u32> {
    let count = inputs.len() / kernel.input_words.max(1) as usize;
    let mut outputs = vec![0; count * kernel.output_words as usize];
    evaluate(kernel, inputs, &mut outputs);
    outputs
}

/// Compares the GPU's words with the CPU's.
fn tally(kernel: &Kernel, inputs: &[u32], gpu: &[u32]) -> Tally {
    Tally::of(&Batch {
        first: 0,
        inputs,
        input_words: kernel.input_words as usize,
        gpu,
        cpu: &on_cpu(kernel, inputs),
        output_words: kernel.output_words as usize,
    })
}
