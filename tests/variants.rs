//! Which replaced operations change the pictures' bits: the scenes of `assets/`
//! drawn with modified operations of the shared mathematics.

use crate::real;
use rayon::prelude::*;
use relievo::prepare::{Assets, PreparedObject, PreparedScene, prepare_with};
use relievo::render::{CpuRenderer, Renderer};
use relievo::scene::{Finish, Scene, Tier};
use relievo_shared::layout::{
    Object, SEARCH_EXTRUSION, SEARCH_PAPER, SEARCH_PRISMS, SEARCH_RELIEF, TIER_ACCURATE, TIER_FAST,
    TIER_PAPER, TIER_PLANAR,
};
use relievo_shared::outline::{Rectangle, bounding_rectangle, prism_outline};
use relievo_shared::profile::LAYERED;
use relievo_shared_variant::{Finding, Mode, audited, with_mode};
use relievo_tests::{asset, is_long, scenes};
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

const SIZE: [u32; 2] = [96, 72];

/// A scene, and the triangles or prisms that each pixel's ray may hit.
struct Prepared {
    name: String,
    scene: PreparedScene,
    /// Objects and their triangles or prisms, in the order of drawing.
    candidates: Vec<Vec<[usize; 2]>>,
}

/// A scene, and its picture as the renderer draws it.
struct Drawn {
    prepared: Prepared,
    picture: Picture,
}

impl Prepared {
    fn new(path: &Path, scene: Scene, assets: &mut Assets) -> Prepared {
        Prepared::with(path, scene, assets, &|_| ())
    }

    /// `change` is made to each object's parameters.
    fn with(
        path: &Path,
        mut scene: Scene,
        assets: &mut Assets,
        change: &dyn Fn(&mut Object),
    ) -> Prepared {
        scene.size = SIZE;
        let mut scene = prepare_with(&scene, assets, &|_| ()).unwrap();
        scene.make_all_prisms();
        for object in &mut scene.objects {
            change(&mut object.parameters);
            // Exits are found by a pass of their own, which is not rewritten.
            object.parameters.number = 0;
        }
        let mut candidates = vec![Vec::new(); (SIZE[0] * SIZE[1]) as usize];
        for (i, object) in scene.objects.iter().enumerate() {
            let frame = object.frame(&scene.frame);
            // Their margin is more than any variant moves the triangle.
            let rectangles: Vec<Rectangle> = if object.has_prisms() {
                let prisms = object.prisms.iter();
                let outline = |prism| prism_outline(&frame, &object.parameters, prism);
                prisms.map(|prism| outline(prism).rectangle).collect()
            } else {
                let triangles = object.triangles.iter();
                triangles.map(|t| bounding_rectangle(&frame, t)).collect()
            };
            for (j, rectangle) in rectangles.into_iter().enumerate() {
                let pixel = |x: f32, side: u32| (0.5 + 0.5 * f64::from(x)) * f64::from(side);
                let columns = pixel(rectangle.low.x, SIZE[0])..=pixel(rectangle.high.x, SIZE[0]);
                let rows = pixel(-rectangle.high.y, SIZE[1])..=pixel(-rectangle.low.y, SIZE[1]);
                if rectangle.low.x >= rectangle.high.x {
                    continue;
                }
                for y in (0..SIZE[1]).filter(|&y| rows.contains(&(f64::from(y) + 0.5))) {
                    for x in (0..SIZE[0]).filter(|&x| columns.contains(&(f64::from(x) + 0.5))) {
                        candidates[(y * SIZE[0] + x) as usize].push([i, j]);
                    }
                }
            }
        }
        Prepared {
            name: path.file_stem().unwrap().display().to_string(),
            scene,
            candidates,
        }
    }
}

/// Every path through the shared mathematics: tier, search, and self-shadows.
const WAYS: [(u32, u32, u32); 5] = [
    (TIER_FAST, SEARCH_EXTRUSION, 1),
    (TIER_PLANAR, SEARCH_EXTRUSION, 0),
    (TIER_FAST, SEARCH_RELIEF, 0),
    (TIER_PAPER, SEARCH_PAPER, 0),
    (TIER_ACCURATE, SEARCH_PRISMS, 1),
];

/// Returns `scene` without materials, lights and smooth edges: pictures are of the words that the
/// shared tracing gives.
fn unlit(mut scene: Scene) -> Scene {
    scene.lights.clear();
    scene.environment = None;
    scene.materials.clear();
    scene.smooth_edges = false;
    for object in &mut scene.objects {
        object.finish = Finish::default();
        for layer in &mut object.layers {
            layer.finish = Finish::default();
        }
    }
    scene
}

/// The scenes of `assets/`, without materials and lights. Each is drawn as it is and in two of
/// [`WAYS`], which follow each other from scene to scene; in all of them if long tests are requested.
static SCENES: LazyLock<Vec<Drawn>> = LazyLock::new(|| {
    let drawn = |(number, path): (usize, PathBuf)| {
        let mut all = Vec::new();
        let mut assets = Assets::default();
        let load = || unlit(Scene::load(&path).unwrap());
        all.push(Prepared::new(&path, load(), &mut assets));
        let ways = WAYS.into_iter().cycle().skip(2 * number);
        let count = if is_long() { WAYS.len() } else { 2 };
        for (tier, search, self_shadow) in ways.take(count) {
            let mut other = Prepared::with(&path, load(), &mut assets, &|parameters| {
                // Neither draws layers.
                let has_layers = search == SEARCH_EXTRUSION || search == SEARCH_PRISMS;
                if parameters.profile == LAYERED && !has_layers {
                    return;
                }
                *parameters = Object {
                    tier,
                    search,
                    self_shadow,
                    tolerance: 0.1,
                    ..*parameters
                };
            });
            other.name += &format!(", tier {tier}, search {search}, self-shadow {self_shadow}");
            all.push(other);
        }
        all.into_iter().map(|prepared| Drawn {
            picture: Picture::of_renderer(&prepared),
            prepared,
        })
    };
    let paths = scenes().into_par_iter().enumerate();
    paths.flat_map_iter(drawn).collect()
});

/// A picture's words: colours and classes, places, surfaces, as of `relievo::render`.
#[derive(PartialEq)]
struct Picture(Vec<[[u32; 4]; 3]>);

impl Picture {
    fn words(&self) -> usize {
        12 * self.0.len()
    }

    fn different_words(&self, other: &Picture) -> usize {
        let words = |picture: &Picture| picture.0.as_flattened().as_flattened().to_vec();
        let pairs = words(self).into_iter().zip(words(other));
        pairs.filter(|(a, b)| a != b).count()
    }

    /// Drawn by relievo-shared itself.
    fn of_renderer(prepared: &Prepared) -> Picture {
        let frame = &prepared.scene.frame;
        let mut renderer = CpuRenderer::new(&prepared.scene);
        let color = renderer.color(frame).unwrap().words;
        let geometry = renderer.geometry(frame).unwrap();
        let places = geometry.place.into_iter().zip(geometry.surface);
        let pixels = color.into_iter().zip(places);
        Picture(pixels.map(|(c, (p, s))| [c, p, s]).collect())
    }
}

/// The renderer with the functions of one tree of relievo-shared-variant.
macro_rules! renderer {
    ($tree:ident) => {
        mod $tree {
            use super::{Picture, Prepared, PreparedObject, SIZE};
            use relievo_shared_variant::$tree::Vec3;
            use relievo_shared_variant::$tree::camera::{pixel_ray, reversed_depth};
            use relievo_shared_variant::$tree::exit::KnownExit;
            use relievo_shared_variant::$tree::layout::{
                Frame, Object, PrismData, SEARCH_PAPER, SEARCH_PRISMS, SEARCH_RELIEF, Triangle,
            };
            use relievo_shared_variant::$tree::model::prisms::Home;
            use relievo_shared_variant::$tree::model::{
                Hit, Model, Normals, Paper, Prisms, Quadric, Ray, Relief,
            };
            use relievo_shared_variant::$tree::normals::CLASS_MISS;
            use relievo_shared_variant::$tree::profile::LAYERED;
            use relievo_shared_variant::$tree::shape_map::Texels;
            use relievo_shared_variant::$tree::stack::Stacked;
            use relievo_shared_variant::$tree::trace;

            /// A hit, its colour and its normals.
            type Found = (Hit, Vec3, Normals);

            pub fn render(prepared: &Prepared) -> Picture {
                // The frame in the space of each object.
                let objects = prepared.scene.objects.iter();
                let own = |object: &PreparedObject| *object.frame(&prepared.scene.frame);
                let frames: Vec<Frame> =
                    objects.map(|object| bytemuck::cast(own(object))).collect();
                let pixel = |(i, candidates): (usize, &Vec<[usize; 2]>)| {
                    let (x, y) = (i as u32 % SIZE[0], i as u32 / SIZE[0]);
                    draw(prepared, &frames, candidates, x, y)
                };
                let candidates = prepared.candidates.iter();
                Picture(candidates.enumerate().map(pixel).collect())
            }

            /// Traces the ray over one facet, if a hit may be as near as the depth `best`.
            fn find<M: Model<Over>, Over, T: Texels + ?Sized>(
                ray: &Ray<'_>,
                over: &Over,
                texels: &T,
                best: f32,
            ) -> Option<Found> {
                let (meets, meeting) = M::meet(ray, over);
                if !meets {
                    return None;
                }
                let (enters, entry) = M::enter(ray, over, &meeting, &KnownExit::default());
                if !enters || reversed_depth(ray.frame, ray.direction, M::entry_t(&entry)) < best {
                    return None;
                }
                let traced = trace::trace::<M, _, _>(ray, over, texels, &entry);
                if traced.hit.class == CLASS_MISS || traced.hit.depth <= best {
                    return None;
                }
                let color = if ray.object.self_shadow != 0 {
                    trace::color::<true, M, _, _>
                } else {
                    trace::color::<false, M, _, _>
                };
                let rgb = color(ray, over, texels, &entry, &traced);
                let normals = trace::normals::<M, _, _>(ray, over, texels, &entry, &traced);
                Some((traced.hit, rgb, normals))
            }

            /// Traces the ray over facet `index`, by the model of the object.
            fn find_on(
                object: &PreparedObject,
                frame: &Frame,
                direction: Vec3,
                index: usize,
                best: f32,
            ) -> Option<Found> {
                let parameters: Object = bytemuck::cast(object.parameters);
                let texels = object.map.words();
                let ray = Ray {
                    frame,
                    object: &parameters,
                    direction,
                };
                let is_stack = parameters.profile == LAYERED;
                let stacked = &Stacked(texels);
                if parameters.search == SEARCH_PRISMS {
                    let prisms: &[PrismData] = bytemuck::cast_slice(&object.prisms);
                    let home = &Home {
                        prisms,
                        index: index as u32,
                    };
                    return match is_stack {
                        true => find::<Prisms, _, _>(&ray, home, stacked, best),
                        false => find::<Prisms, _, _>(&ray, home, texels, best),
                    };
                }
                let triangle: Triangle = bytemuck::cast(object.triangles[index]);
                match parameters.search {
                    _ if is_stack => find::<Quadric, _, _>(&ray, &triangle, stacked, best),
                    SEARCH_PAPER => find::<Paper, _, _>(&ray, &triangle, texels, best),
                    SEARCH_RELIEF => find::<Relief, _, _>(&ray, &triangle, texels, best),
                    _ => find::<Quadric, _, _>(&ray, &triangle, texels, best),
                }
            }

            /// Draws a pixel like `relievo::render::CpuRenderer`.
            fn draw(
                prepared: &Prepared,
                frames: &[Frame],
                candidates: &[[usize; 2]],
                x: u32,
                y: u32,
            ) -> [[u32; 4]; 3] {
                let mut nearest: Option<(usize, Found)> = None;
                for &[i, j] in candidates {
                    let best = nearest.as_ref().map_or(0.0, |(_, (best, ..))| best.depth);
                    let (object, frame) = (&prepared.scene.objects[i], &frames[i]);
                    let direction = pixel_ray(frame, x, y);
                    if let Some(found) = find_on(object, frame, direction, j, best) {
                        nearest = Some((i, found));
                    }
                }
                let Some((object, (hit, rgb, normals))) = nearest else {
                    let [r, g, b] = prepared.scene.background.map(f32::to_bits);
                    return [[r, g, b, CLASS_MISS], [0; 4], [0; 4]];
                };
                let (place, surface) = trace::geometry_words(&frames[object], &hit, normals.carved);
                let color = trace::color_words(rgb, &hit);
                [color, place, surface].map(|words| words.to_array())
            }
        }
    };
}

renderer!(native);
renderer!(corrected);
renderer!(fused);

type Render = fn(&Prepared) -> Picture;

/// Number of words of each scene that differ from the renderer's, which are those of [`Mode::Exact`]
/// (`exact_operations_draw_what_the_renderer_draws`).
fn different_words(render: Render, mode: Mode) -> Vec<usize> {
    let different = |drawn: &Drawn| {
        let changed = with_mode(mode, || render(&drawn.prepared));
        let different = drawn.picture.different_words(&changed);
        let (name, words) = (&drawn.prepared.name, changed.words());
        println!("{mode:?}, {name}: {different} of {words} words differ");
        different
    };
    SCENES.iter().map(different).collect()
}

/// Asserts that enough words differ to detect a variant.
fn assert_caught(different: &[usize]) {
    let enough = (SIZE[0] * SIZE[1]) as usize / 10;
    assert!(different.iter().all(|&d| d > enough), "{different:?}");
}

/// Control: rewriting changes nothing, nor does correcting right results.
#[test]
fn exact_operations_draw_what_the_renderer_draws() {
    for Drawn { prepared, picture } in SCENES.iter() {
        let covered = picture.0.iter().filter(|pixel| pixel[0][3] != 0).count();
        assert!(covered > 500, "{}: {covered} pixels", prepared.name);
        for render in [native::render, corrected::render, fused::render] {
            let different = render(prepared).different_words(picture);
            assert_eq!(different, 0, "{}", prepared.name);
        }
    }
}

#[test]
fn contraction_and_other_rounding_are_caught() {
    for render in [native::render as Render, corrected::render] {
        assert_caught(&different_words(render, Mode::Fused));
    }
    assert_caught(&different_words(corrected::render, Mode::TowardZero));
}

/// Corrected operations do not depend on the device's; native ones do.
#[test]
fn inaccurate_division_changes_native_pictures_only() {
    for ulps in [1, 3] {
        assert_caught(&different_words(native::render, Mode::DivisionOff(ulps)));
    }
    for render in [corrected::render as Render, fused::render] {
        for ulps in [3, 8] {
            let different = different_words(render, Mode::DivisionOff(ulps));
            assert!(different.iter().all(|&d| d == 0), "{different:?}");
        }
    }
}

#[test]
fn flushing_denormals_changes_nothing() {
    for render in [native::render as Render, corrected::render, fused::render] {
        let different = different_words(render, Mode::FlushToZero);
        assert!(different.iter().all(|&d| d == 0), "{different:?}");
    }
}

/// A sphere so small that the squares of its edges are nearly subnormal.
fn tiny() -> Prepared {
    // Smaller than the scale of a scene makes it: the mesh itself is small.
    let sphere = std::fs::read_to_string(asset("meshes/sphere.obj")).unwrap();
    let small = |line: &str| match line.strip_prefix("v ") {
        Some(position) => {
            let numbers = position.split_whitespace();
            let numbers = numbers.map(|x| format!(" {:e}", 1e-3 * x.parse::<f64>().unwrap()));
            format!("v{}\n", numbers.collect::<String>())
        }
        None => format!("{line}\n"),
    };
    let folder = tempfile::tempdir().unwrap();
    let mesh = folder.path().join("small.obj");
    std::fs::write(&mesh, sphere.lines().map(small).collect::<String>()).unwrap();
    let text = format!(
        "[camera]\neye = [0.0, 0.0, 4e-12]\ntarget = [0.0, 0.0, 0.0]\n[[object]]\nmesh = {mesh:?}\nshape = {:?}\nrepeat = [8, 4]\ndepth = 0.05\nscale = 1e-9\n",
        asset("patterns/letters.png"),
    );
    let path = Path::new("tiny.toml");
    let scene = Scene::parse(&text, path).unwrap();
    Prepared::new(path, scene, &mut Assets::default())
}

#[test]
fn flushing_denormals_is_caught_where_the_value_contract_is_broken() {
    let tiny = tiny();
    let (exact, findings) = audited(|| native::render(&tiny));
    let flushed = with_mode(Mode::FlushToZero, || native::render(&tiny));
    let different = exact.different_words(&flushed);
    println!("{different} words differ");
    assert!(different > 1000, "{different} words");
    // The audit reports it.
    assert!(!findings.is_empty());
}

/// "native, torus: path.rs:97: Denormal 3 times, first …".
fn describe(tree: &str, scene: &str, finding: &Finding) -> String {
    let Finding {
        site,
        caller,
        problem,
        count,
        example,
    } = finding;
    let caller = caller.map_or(String::new(), |caller| format!(" called by {caller}"));
    format!("{tree}, {scene}: {site}{caller}: {problem:?} {count} times, first {example}")
}

/// Panics with the operations of `scenes` that leave the range of the value contract.
fn assert_contract<'a>(scenes: impl ParallelIterator<Item = &'a Prepared>) {
    let trees: [(&str, Render); 2] = [("native", native::render), ("corrected", corrected::render)];
    // Each picture is drawn by one thread, which is audited.
    let found = scenes.flat_map_iter(|prepared| {
        trees.into_iter().flat_map(|(tree, render)| {
            let (_, findings) = audited(|| render(prepared));
            let described = findings.iter().map(|f| describe(tree, &prepared.name, f));
            described.collect::<Vec<_>>()
        })
    });
    let found: Vec<String> = found.collect();
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn the_values_of_every_scene_keep_the_contract() {
    assert_contract(SCENES.par_iter().map(|drawn| &drawn.prepared));
}

#[test]
fn the_values_of_real_meshes_keep_the_contract() {
    for (_, path) in real::named_meshes() {
        let mut assets = Assets::default();
        let mut scenes = Vec::new();
        for tier in [Tier::Planar, Tier::Fast, Tier::Accurate] {
            for view in 0..real::VIEWS.len() {
                let scene = real::scene(&path, tier, view, SIZE);
                scenes.push(Prepared::new(&path, scene, &mut assets));
            }
        }
        assert_contract(scenes.par_iter());
    }
}
