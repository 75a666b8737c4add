//! Shaders for the tests, and their functions for the CPU.

use crate::{Module, Runner, adapters};
use relievo_kernel::{Domain, Kernel, Kind, table};

/// A wide domain, in which no product of two is denormal or infinite.
const FACTOR: Domain = Domain::new(
    "factor",
    Kind::NonZero {
        low: 1e-6,
        high: 1e6,
    },
);
const SUMMAND: Domain = Domain::new(
    "summand",
    Kind::Range {
        low: -1e6,
        high: 1e6,
    },
);

const SOURCE: &str = "
    @group(0) @binding(0) var<storage, read> inputs: array<u32>;
    @group(0) @binding(1) var<storage, read_write> outputs: array<u32>;

    fn number(at: u32) -> f32 {
        return bitcast<f32>(inputs[at]);
    }

    @compute @workgroup_size(64)
    fn multiply_add(@builtin(global_invocation_id) id: vec3<u32>) {
        let at = 3u * id.x;
        outputs[id.x] = bitcast<u32>(number(at) * number(at + 1u) + number(at + 2u));
    }

    @compute @workgroup_size(64)
    fn product_and_sum(@builtin(global_invocation_id) id: vec3<u32>) {
        let at = 2u * id.x;
        outputs[at] = bitcast<u32>(number(at) * number(at + 1u));
        outputs[at + 1u] = bitcast<u32>(number(at) + number(at + 1u));
    }

    @compute @workgroup_size(64)
    fn scale(@builtin(global_invocation_id) id: vec3<u32>) {
        outputs[id.x] = bitcast<u32>(number(id.x) * 0.1f);
    }

    @compute @workgroup_size(64)
    fn silent(@builtin(global_invocation_id) id: vec3<u32>) {
        if id.x == 0xffffffffu {
            outputs[0] = inputs[0];
        }
    }

    @compute @workgroup_size(32)
    fn narrow(@builtin(global_invocation_id) id: vec3<u32>) {
        outputs[id.x] = inputs[id.x];
    }
";

fn multiply_add(a: f32, b: f32, c: f32) -> f32 {
    a * b + c
}

/// The functions of [`SOURCE`].
pub(crate) const TABLE: &[Kernel] = table! {
    multiply_add(f32: FACTOR, f32: FACTOR, f32: SUMMAND) -> f32 = multiply_add;
    product_and_sum(f32: FACTOR, f32: FACTOR) -> (f32, f32) = |a: f32, b: f32| (a * b, a + b);
    scale(f32: FACTOR) -> f32 = |x: f32| x * 0.1;
};

/// Rounds once where the shader rounds twice.
pub(crate) const FUSED: &[Kernel] = table! {
    multiply_add(f32: FACTOR, f32: FACTOR, f32: SUMMAND) -> f32 = f32::mul_add;
};

/// Has a constant that is 1 ULP larger than the shader's.
pub(crate) const OFF_BY_ONE: &[Kernel] = table! {
    scale(f32: FACTOR) -> f32 = |x: f32| x * 0.1_f32.next_up();
};

/// A kernel whose shader writes no result.
pub(crate) const SILENT: &[Kernel] = table! {
    silent(f32: FACTOR) -> f32 = |x: f32| x;
};

/// Compiles [`SOURCE`] to the bytes of a SPIR-V module with NoContraction.
pub(crate) fn shader() -> Vec<u8> {
    bytes(&without_contraction(&spirv(SOURCE)))
}

/// Compiles WGSL to SPIR-V.
pub(crate) fn spirv(source: &str) -> Vec<u32> {
    let module = naga::front::wgsl::parse_str(source).expect("WGSL");
    let mut validator = naga::valid::Validator::new(
        naga::valid::ValidationFlags::all(),
        naga::valid::Capabilities::empty(),
    );
    let info = validator.validate(&module).expect("a valid module");
    let options = naga::back::spv::Options::default();
    naga::back::spv::write_vec(&module, &info, &options, None).expect("a SPIR-V module")
}

/// Converts words to the bytes of a file.
pub(crate) fn bytes(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}

/// Decorates every sum and product of a module with NoContraction.
fn without_contraction(words: &[u32]) -> Vec<u32> {
    const OP_DECORATE: u32 = 71;
    const OP_FADD: u32 = 129;
    const OP_FMUL: u32 = 133;
    const NO_CONTRACTION: u32 = 42;
    let mut decorations = Vec::new();
    let mut place = None;
    let mut at = 5;
    while at < words.len() {
        match words[at] & 0xffff {
            OP_DECORATE if place.is_none() => place = Some(at),
            OP_FADD | OP_FMUL => {
                decorations.extend([3 << 16 | OP_DECORATE, words[at + 2], NO_CONTRACTION]);
            }
            _ => {}
        }
        at += (words[at] >> 16) as usize;
    }
    assert_eq!(decorations.len(), 3 * 5, "two, two and one");
    let place = place.expect("bindings have decorations");
    let mut decorated = words.to_vec();
    decorated.splice(place..place, decorations);
    decorated
}

fn all_runners(modules: &[Module]) -> Vec<Runner> {
    let all = adapters();
    assert!(!all.is_empty(), "no adapter on this machine");
    all.iter()
        .flat_map(|adapter| {
            let device = adapter.open().expect("a device");
            let modules = modules
                .iter()
                .filter(|module| module.route() == crate::Route::Portable || device.takes_spirv());
            modules
                .map(|module| Runner::new(&device, module).expect("a runner"))
                .collect::<Vec<_>>()
        })
        .collect()
}

fn untouched() -> Module {
    // SAFETY: naga has validated it, and its accesses are within Runner's buffers.
    unsafe { Module::untouched(&[&shader()]) }.expect("a module")
}

/// The shader on every adapter, by both routes.
pub(crate) fn runners() -> Vec<Runner> {
    let portable = Module::portable(&[&shader()]).expect("a module");
    all_runners(&[untouched(), portable])
}

/// The shader unchanged, on every adapter with passthrough.
pub(crate) fn untouched_runners() -> Vec<Runner> {
    all_runners(&[untouched()])
}
