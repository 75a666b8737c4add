//! Loops that naga would translate wrongly, on every adapter.

use crate::{Module as Compiled, Runner, adapters, testing};
use naga::Module;
use relievo_kernel::{Domain, Kernel, Kind, table};
use relievo_translate::portable::{lower, read};

const WORD: Domain = Domain::new(
    "word",
    Kind::Range {
        low: 0.0,
        high: 1.0,
    },
);

/// A loop with a `break if` on variables that `continuing` changes, with a
/// `continue`, and with another such loop inside.
const LOOPS: &str = "
    @group(0) @binding(0) var<storage, read> inputs: array<u32>;
    @group(0) @binding(1) var<storage, read_write> outputs: array<u32>;

    @compute @workgroup_size(64)
    fn turns(@builtin(global_invocation_id) id: vec3<u32>) {
        let end = inputs[id.x];
        var i = 0u;
        var sum = 0u;
        loop {
            if i % 3u == 1u { continue; }
            if sum > 5000u { break; }
            var j = i;
            loop {
                sum += j;
                if j == 7u { continue; }
                sum += 1u;
                continuing {
                    let last = j;
                    j += 2u;
                    break if last >= end;
                }
            }
            continuing {
                let last = i;
                i += 1u;
                break if last == end;
            }
        }
        outputs[id.x] = sum;
    }
";

/// Computes what [`LOOPS`] does.
fn turns(end: u32) -> u32 {
    let mut sum = 0;
    for i in (0..=end).filter(|i| i % 3 != 1) {
        if sum > 5000 {
            break;
        }
        let mut j = i;
        loop {
            sum += j + u32::from(j != 7);
            j += 2;
            if j - 2 >= end {
                break;
            }
        }
    }
    sum
}

const TURNS: &[Kernel] = table! {
    turns(f32: WORD) -> f32 = |word: f32| f32::from_bits(turns(word.to_bits()));
};

#[test]
fn gpu_lowered_loops_have_the_same_iterations() {
    let words = testing::spirv(LOOPS);
    let mut module = read(&words).expect("a module");
    let tails = |module: &Module| format!("{module:?}").matches("break_if: Some").count();
    assert_eq!(tails(&module), 2);
    lower(&mut module).expect("no switch");
    assert_eq!(tails(&module), 0);

    let module = Compiled::portable(&[&testing::bytes(&words)]).expect("a module");
    let inputs: Vec<u32> = (0..64).collect();
    let right: Vec<u32> = inputs.iter().map(|&end| turns(end)).collect();
    for adapter in adapters() {
        let device = adapter.open().expect("a device");
        let mut runner = Runner::new(&device, &module).expect("a runner");
        let words = runner.run(&TURNS[0], &inputs).expect("a run");
        assert_eq!(words, right, "{}", adapter.describe());
    }
}

#[test]
fn unreadable_modules_are_rejected_with_a_reason() {
    let mut words = testing::spirv(LOOPS);
    // An unknown capability.
    words.splice(5..5, [2 << 16 | 17, 0xffff]);
    let module = Compiled::portable(&[&testing::bytes(&words)]).expect("a module");
    let error = module.translated("turns").unwrap_err().to_string();
    assert!(error.contains("65535"), "{error}");
}
