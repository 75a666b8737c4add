//! What is said of a function whose words differ.

use crate::tally;
use relievo_bitwise::{DeviceError, Difference, Runner, Tally, kinds, shrink};
use relievo_kernel::{Kernel, Kind};
use std::fmt::Write;

/// Returns the report of a tally, if it has differences: how many, a simple input, and a
/// test to paste.
pub(crate) fn of(
    runner: &mut Runner,
    kernel: &Kernel,
    tally: &Tally,
) -> Result<Option<String>, DeviceError> {
    let Some(first) = tally.first.first() else {
        return Ok(None);
    };
    let simple = shrink(kernel, &first.input, |inputs| {
        if inputs.is_empty() {
            return Ok(Vec::new());
        }
        let gpu = runner.run(kernel, inputs)?;
        let input_words = kernel.input_words as usize;
        let groups = inputs
            .chunks(input_words)
            .zip(gpu.chunks(kernel.output_words as usize));
        let differs = groups.map(|(input, gpu)| crate::tally(kernel, input, gpu).different > 0);
        Ok::<_, DeviceError>(differs.collect())
    })?;
    let gpu = runner.run(kernel, &simple)?;
    let simple = self::tally(kernel, &simple, &gpu);
    let shown = simple.first.first().unwrap_or(first);
    Ok(Some(text(runner.device().describe(), kernel, tally, shown)))
}

/// Returns the report as text.
fn text(adapter: &str, kernel: &Kernel, tally: &Tally, shown: &Difference) -> String {
    let name = kernel.name;
    let mut text = format!(
        "{name} differs on {adapter}: {} of {} words, by up to {} ULP\n\n",
        tally.different, tally.words, tally.largest
    );
    let values: Vec<String> = kinds(kernel)
        .iter()
        .zip(&shown.input)
        .map(|(kind, &word)| value(kind, word))
        .collect();
    let words: Vec<String> = shown
        .input
        .iter()
        .map(|word| format!("{word:#010x}"))
        .collect();
    let _ = write!(
        text,
        "  input     {}\n  word {}    GPU {:#010x} = {:?}\n            CPU {:#010x} = {:?}\n\nAs a test:\n\n",
        values.join(", "),
        shown.word,
        shown.gpu,
        f32::from_bits(shown.gpu),
        shown.cpu,
        f32::from_bits(shown.cpu),
    );
    let _ = write!(
        text,
        "    #[test]\n    fn {name}_of_one_input() {{\n        // {}\n        relievo_test::assert_equal_words(&{name}::KERNEL, &[{}]);\n    }}",
        values.join(", "),
        words.join(", ")
    );
    text
}

fn value(kind: &Kind, word: u32) -> String {
    match kind {
        Kind::Integer { .. } => word.to_string(),
        _ => format!("{:?}", f32::from_bits(word)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use relievo_kernel::{Domain, domain::NUMBER, table};

    const KERNELS: &[Kernel] = table! {
        scale(f32: NUMBER, u32: Domain::integer("times", 0, 9)) -> f32 = |x: f32, n: u32| x * n as f32;
    };

    #[test]
    fn a_report_shows_values_and_a_test_to_paste() {
        let input = [0.5_f32.to_bits(), 3];
        let mut tally = Tally::default();
        tally.add(0, &input, &[1.5_f32.to_bits() + 1], &[1.5_f32.to_bits()]);
        let text = text("a device", &KERNELS[0], &tally, &tally.first[0]);
        let expected = "\
scale differs on a device: 1 of 1 words, by up to 1 ULP

  input     0.5, 3
  word 0    GPU 0x3fc00001 = 1.5000001
            CPU 0x3fc00000 = 1.5

As a test:

    #[test]
    fn scale_of_one_input() {
        // 0.5, 3
        relievo_test::assert_equal_words(&scale::KERNEL, &[0x3f000000, 0x00000003]);
    }";
        assert_eq!(text, expected);
    }
}
