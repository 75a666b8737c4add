//! GPU pictures against CPU pictures, for every scene, every adapter and every
//! kind of shaders. A missing adapter is a failure: see `tests/run`.

use relievo::prepare::prepare;
use relievo::render::gpu::{Adapter, Choice, Shaders, signature};
use relievo::render::{ColorWords, CpuRenderer, GeometryWords, GpuRenderer, Renderer};
use relievo::scene::Scene;
use relievo::verify::{Agreement, color_difference, compare};
use relievo_shared::layout::Frame;
use relievo_shared::march::{END_CAP, END_FLOOR, END_MISS, END_SIDE};
use relievo_shared::{Vec2, Vec3, kernels};
use relievo_tests::{Renderers, coarsen_shadows, every_adapter, scenes};

/// Required of the fast and the portable shaders; the exact ones must match
/// every word.
const LARGEST_SHARE: f64 = 0.05;
/// Of scenes with materials and lights: each pixel has more to round, and between two levels of a picture
/// all of them do.
const LARGEST_LIT_SHARE: f64 = 0.45;
const LARGEST_COLOR_DIFFERENCE: f32 = 1e-3;
/// Pixels of scenes with materials and lights that may differ by more: at the border of a shadow, or
/// between two cells of a pattern, the last bit decides.
const FAR_LIT_PIXELS: usize = 4;
const LARGEST_DISTANCE_DIFFERENCE: f32 = 1e-4;

/// Pictures of a scene.
struct Pictures {
    color: ColorWords,
    geometry: GeometryWords,
}

impl Pictures {
    fn of(renderer: &mut impl Renderer, frame: &Frame) -> Pictures {
        Pictures {
            color: renderer.color(frame).unwrap(),
            geometry: renderer.geometry(frame).unwrap(),
        }
    }

    /// Returns the agreement with others, and the number of pixels whose colours are far apart.
    fn agreement(&self, other: &Pictures) -> (Agreement, usize) {
        let is_far =
            |(a, b): &(&[u32; 4], &[u32; 4])| color_difference(**a, **b) > LARGEST_COLOR_DIFFERENCE;
        let pixels = self.color.words.iter().zip(&other.color.words);
        let agreement = compare(
            [&self.color, &other.color],
            [&self.geometry, &other.geometry],
        );
        (agreement, pixels.filter(is_far).count())
    }
}

#[test]
fn gpu_pictures_are_cpu_pictures() {
    let all: Vec<(Adapter, bool)> = every_adapter()
        .into_iter()
        .map(|found| {
            let fuses = found.takes_spirv()
                && Shaders::Fused.suit(&signature(&found.open().unwrap()).unwrap());
            (found, fuses)
        })
        .collect();
    let mut wrong = Vec::new();
    let mut renderers = Renderers::default();
    for path in scenes() {
        let mut scene = Scene::load(&path).unwrap();
        scene.size = [320, 240];
        coarsen_shadows(&mut scene);
        let (largest_share, far_pixels) = match scene.is_physical() {
            true => (LARGEST_LIT_SHARE, FAR_LIT_PIXELS),
            false => (LARGEST_SHARE, 0),
        };
        let scene = prepare(&scene, &|_| ()).unwrap();
        let on_cpu = Pictures::of(&mut CpuRenderer::new(&scene), &scene.frame);
        for (found, fuses) in &all {
            for shaders in Shaders::ALL {
                let is_taken = found.takes_spirv() || !shaders.is_untouched();
                if !is_taken || (shaders == Shaders::Fused && !fuses) {
                    continue;
                }
                let gpu = renderers.show(&scene, found, shaders);
                let (agreement, far) = Pictures::of(gpu, &scene.frame).agreement(&on_cpu);
                let close = agreement.color.inputs == 320 * 240
                    && agreement.class_pixels == 0
                    && agreement.color.inputs_different as f64
                        <= largest_share * agreement.color.inputs as f64
                    && far <= far_pixels
                    && agreement.largest_distance_difference <= LARGEST_DISTANCE_DIFFERENCE;
                if !close || (shaders.is_exact() && !agreement.is_exact()) {
                    wrong.push(format!(
                        "{}, {shaders:?}, {}: {far} pixels are far apart, {agreement:?}",
                        found.describe(),
                        path.display()
                    ));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The comparison detects a wrong picture: another depth, on one side only.
#[test]
fn gpu_picture_of_another_scene_is_caught() {
    let found = every_adapter().swap_remove(0);
    let mut scene = Scene::load(&scenes()[0]).unwrap();
    scene.size = [160, 120];
    let right = prepare(&scene, &|_| ()).unwrap();
    scene.objects[0].depth = Some(0.0600001);
    let wrong = prepare(&scene, &|_| ()).unwrap();
    let mut gpu = GpuRenderer::new(&wrong, &found, Choice::Trusted).unwrap();
    let mut cpu = CpuRenderer::new(&right);
    let frame = &right.frame;
    let agreement = compare(
        [&gpu.color(frame).unwrap(), &cpu.color(frame).unwrap()],
        [&gpu.geometry(frame).unwrap(), &cpu.geometry(frame).unwrap()],
    );
    assert!(
        agreement.geometry.different > agreement.geometry.words / 50,
        "{agreement:?}"
    );
}

/// Frames repeat, also with a frame of another size between.
#[test]
fn gpu_frames_repeat() {
    let found = every_adapter().swap_remove(0);
    let mut scene = Scene::load(&scenes()[0]).unwrap();
    scene.size = [97, 61];
    let scene = prepare(&scene, &|_| ()).unwrap();
    let mut gpu = GpuRenderer::new(&scene, &found, Choice::Trusted).unwrap();
    let first = gpu.color(&scene.frame).unwrap();
    let finer = gpu.color(&scene.frame_with_samples(2)).unwrap();
    assert_eq!((finer.width, finer.height), (194, 122));
    assert_eq!(gpu.color(&scene.frame).unwrap(), first);
}

/// The kernel's inputs reach every outcome, so that comparing words is
/// meaningful.
#[test]
fn the_kernel_of_the_walk_meets_everything() {
    let mut ends = [0; 4];
    for i in 0..1000u32 {
        let share = |step: u32| (i.wrapping_mul(step) % 997) as f32 / 997.0;
        let spread = |step: u32| 4.0 * (2.0 * share(step) - 1.0);
        let vector = |a, b, c| Vec3::new(spread(a), spread(b), spread(c));
        let (found, x) = kernels::search_prism(
            i.wrapping_mul(0x9e37_79b9),
            vector(3, 5, 7),
            vector(11, 13, 17),
            Vec3::new(share(19), share(23), share(29)),
            (vector(31, 37, 41) - 4.0 * Vec3::Z).normalize(),
            0.05 + share(43),
            Vec2::new(0.5 * share(47), 0.5 * share(53)),
        );
        ends[found.end as usize] += 1;
        assert!(x.is_finite() && found.s.is_finite(), "{found:?} {x}");
    }
    for end in [END_MISS, END_CAP, END_SIDE, END_FLOOR] {
        assert!(ends[end as usize] > 20, "{ends:?}");
    }
}
