//! Deliberately wrong exact modules, which the comparison between GPU and CPU
//! must detect.

use relievo::prepare::{PreparedScene, prepare};
use relievo::render::gpu::{Adapter, Module, Signature, canaries};
use relievo::render::{CpuRenderer, GpuRenderer, Renderer};
use relievo::scene::Scene;
use relievo::verify::kernels::KERNELS;
use relievo::verify::{Agreement, compare};
use relievo_bitwise::{Plan, Recorded, Runner, compare_kernel};
use relievo_kernel::Kernel;
use relievo_tests::{asset, every_adapter, root};

/// Words before a module's instructions.
const HEADER: usize = 5;
const OP_CONSTANT: u32 = 43;
const OP_TYPE_FLOAT: u32 = 22;
const OP_DECORATE: u32 = 71;
const NO_CONTRACTION: u32 = 42;

/// The files of a committed module, as words.
fn words(folder: &str) -> Vec<Vec<u32>> {
    let files = std::fs::read_dir(root().join("assets/shaders").join(folder)).unwrap();
    let words: Vec<Vec<u32>> = files
        .map(|file| {
            let bytes = std::fs::read(file.unwrap().path()).unwrap();
            let (words, rest) = bytes.as_chunks::<4>();
            assert!(rest.is_empty());
            words.iter().copied().map(u32::from_le_bytes).collect()
        })
        .collect();
    assert!(words.len() > 5);
    words
}

/// The instructions of a module, opcode and words.
fn instructions(module: &[u32]) -> Vec<(u32, &[u32])> {
    let mut found = Vec::new();
    let mut at = HEADER;
    while at < module.len() {
        let count = (module[at] >> 16) as usize;
        found.push((module[at] & 0xffff, &module[at..at + count]));
        at += count;
    }
    found
}

/// Removes the NoContraction decorations; returns the files and how many there
/// were.
fn stripped(files: &[Vec<u32>]) -> (Vec<Vec<u32>>, usize) {
    let bare: Vec<_> = files.iter().map(|file| stripped_file(file)).collect();
    let count = bare.iter().map(|(_, count)| count).sum();
    (bare.into_iter().map(|(words, _)| words).collect(), count)
}

/// The words of a file without NoContraction decorations, and how many there were.
pub fn stripped_file(module: &[u32]) -> (Vec<u32>, usize) {
    let mut words = module[..HEADER].to_vec();
    let mut count = 0;
    for (opcode, instruction) in instructions(module) {
        if opcode == OP_DECORATE && instruction[2] == NO_CONTRACTION {
            count += 1;
        } else {
            words.extend(instruction);
        }
    }
    (words, count)
}

/// Files with the f32 constant `value` replaced by its neighbour.
fn nudged(files: &[Vec<u32>], value: f32) -> Vec<Vec<u32>> {
    let nudged: Vec<_> = files.iter().map(|file| nudged_file(file, value)).collect();
    assert_ne!(nudged, files, "no file has the constant {value}");
    nudged
}

fn nudged_file(module: &[u32], value: f32) -> Vec<u32> {
    let float = instructions(module)
        .into_iter()
        .find(|(opcode, words)| *opcode == OP_TYPE_FLOAT && words[2] == 32);
    let Some((_, float)) = float else {
        return module.to_vec();
    };
    let float = float[1];
    let mut words = module[..HEADER].to_vec();
    for (opcode, instruction) in instructions(module) {
        let is_it =
            opcode == OP_CONSTANT && instruction[1] == float && instruction[3] == value.to_bits();
        words.extend(instruction);
        if is_it {
            *words.last_mut().unwrap() += 1;
        }
    }
    words
}

fn module(files: &[Vec<u32>]) -> Module {
    let bytes = |words: &Vec<u32>| words.iter().flat_map(|word| word.to_le_bytes()).collect();
    let files: Vec<Vec<u8>> = files.iter().map(bytes).collect();
    let files: Vec<&[u8]> = files.iter().map(Vec::as_slice).collect();
    // SAFETY: a committed module, which the builder has validated, with fewer
    // decorations or another constant.
    unsafe { Module::untouched(&files) }.unwrap()
}

fn torus() -> PreparedScene {
    let mut scene = Scene::load(&asset("scenes/torus.toml")).unwrap();
    scene.size = [160, 120];
    prepare(&scene, &|_| ()).unwrap()
}

fn picture(scene: &PreparedScene, adapter: &Adapter, files: &[Vec<u32>]) -> Agreement {
    let mut gpu = GpuRenderer::with_module(scene, adapter, &module(files), "twin").unwrap();
    let mut cpu = CpuRenderer::new(scene);
    let frame = &scene.frame;
    compare(
        [&gpu.color(frame).unwrap(), &cpu.color(frame).unwrap()],
        [&gpu.geometry(frame).unwrap(), &cpu.geometry(frame).unwrap()],
    )
}

fn adapters_for_spirv() -> Vec<Adapter> {
    let all = every_adapter().into_iter();
    all.filter(Adapter::takes_spirv).collect()
}

/// SwiftShader never rewrites float operations, decorated or not.
fn never_rewrites_floats(adapter: &Adapter) -> bool {
    adapter.name().contains("SwiftShader")
}

fn kernels_that_differ(adapter: &Adapter, files: &[Vec<u32>]) -> Vec<&'static str> {
    let device = adapter.open().unwrap();
    let mut runner = Runner::new(&device, &module(files)).unwrap();
    let recorded = Recorded::new();
    let plan = Plan {
        inputs: 16_384,
        seed: 1,
        recorded: &recorded,
    };
    let differs = |kernel: &&Kernel| {
        let tally = compare_kernel(&mut runner, kernel, &plan, &|_| ()).unwrap();
        !tally.is_exact()
    };
    let differing = KERNELS.iter().filter(differs);
    differing.map(|kernel| kernel.name).collect()
}

/// Control: modules read and written again are exact.
#[test]
fn gpu_modules_read_and_written_again_are_exact() {
    let scene = torus();
    for adapter in adapters_for_spirv() {
        let agreement = picture(&scene, &adapter, &words("relievo_exact"));
        assert!(
            agreement.is_exact(),
            "{}: {agreement:?}",
            adapter.describe()
        );
        let differing = kernels_that_differ(&adapter, &words("kernels_exact"));
        assert!(
            differing.is_empty(),
            "{}: {differing:?}",
            adapter.describe()
        );
    }
}

#[test]
fn gpu_modules_without_decorations_are_caught() {
    let scene = torus();
    let (renderer, bare) = stripped(&words("relievo_exact"));
    assert!(bare > 1000);
    let (kernels, bare) = stripped(&words("kernels_exact"));
    assert!(bare > 1000);
    for adapter in adapters_for_spirv() {
        if never_rewrites_floats(&adapter) {
            continue;
        }
        let agreement = picture(&scene, &adapter, &renderer);
        assert!(agreement.color.different > 0 && agreement.geometry.different > 0);
        let differing = kernels_that_differ(&adapter, &kernels);
        assert!(differing.len() > 3, "{}: {differing:?}", adapter.describe());
        // The device is not trusted either.
        let device = adapter.open().unwrap();
        let mut runner = Runner::new(&device, &module(&kernels)).unwrap();
        let signature = Signature::take(&mut runner, canaries()).unwrap();
        assert!(!signature.is_exact(), "{}", signature.describe());
        assert!(
            signature
                .told
                .iter()
                .any(|told| told.required && told.different > 0)
        );
    }
}

#[test]
fn gpu_modules_with_one_constant_off_by_one_ulp_are_caught() {
    let scene = torus();
    let renderer = words("relievo_exact");
    let kernels = words("kernels_exact");
    for adapter in adapters_for_spirv() {
        for constant in [0.5, 2.0] {
            let agreement = picture(&scene, &adapter, &nudged(&renderer, constant));
            assert!(
                agreement.color.different > 100 && agreement.geometry.different > 100,
                "{}, {constant}: {agreement:?}",
                adapter.describe()
            );
        }
        let differing = kernels_that_differ(&adapter, &nudged(&kernels, 2.0));
        assert!(
            differing.contains(&"path"),
            "{}: {differing:?}",
            adapter.describe()
        );
    }
}
