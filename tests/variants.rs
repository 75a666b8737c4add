//! What breaks the pictures' bits, and what does not: the scenes of `assets/`
//! drawn with the shared mathematics' operations replaced, on purpose.

use relievo::prepare::{PreparedObject, PreparedScene, prepare};
use relievo::render::{CpuRenderer, Renderer};
use relievo::scene::Scene;
use relievo_shared::layout::{
    Object, SEARCH_EXTRUSION, SEARCH_PAPER, SEARCH_PRISMS, SEARCH_RELIEF, TIER_ACCURATE, TIER_FAST,
    TIER_PAPER, TIER_PLANAR,
};
use relievo_shared::outline::{Rectangle, bounding_rectangle, shell_outline};
use relievo_shared_variant::{Finding, Mode, audited, with_mode};
use relievo_tests::{asset, scenes};
use std::path::Path;
use std::sync::LazyLock;

const SIZE: [u32; 2] = [96, 72];

/// A scene, and which triangles or prisms each pixel's ray may meet.
struct Prepared {
    name: String,
    scene: PreparedScene,
    /// Objects and their triangles or prisms, in the order of drawing.
    candidates: Vec<Vec<[usize; 2]>>,
}

impl Prepared {
    fn new(path: &Path, scene: Scene) -> Prepared {
        Prepared::with(path, scene, &|_| ())
    }

    /// `change` is made to each object's parameters.
    fn with(path: &Path, mut scene: Scene, change: &dyn Fn(&mut Object)) -> Prepared {
        scene.size = SIZE;
        let mut scene = prepare(&scene, &|_| ()).unwrap();
        scene.make_all_shells();
        for object in &mut scene.objects {
            change(&mut object.parameters);
        }
        let mut candidates = vec![Vec::new(); (SIZE[0] * SIZE[1]) as usize];
        for (i, object) in scene.objects.iter().enumerate() {
            // A pixel wider than the triangle: more than any variant moves it.
            let rectangles: Vec<Rectangle> = if object.has_prisms() {
                let shells = object.shells.iter();
                let outline = |shell| shell_outline(&scene.frame, &object.parameters, shell);
                shells.map(|shell| outline(shell).rectangle).collect()
            } else {
                let triangles = object.triangles.iter();
                triangles
                    .map(|t| bounding_rectangle(&scene.frame, t))
                    .collect()
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

/// Every way through the shared mathematics: tier, search, and whether there are self-shadows.
const WAYS: [(u32, u32, u32); 5] = [
    (TIER_FAST, SEARCH_EXTRUSION, 1),
    (TIER_PLANAR, SEARCH_EXTRUSION, 0),
    (TIER_FAST, SEARCH_RELIEF, 0),
    (TIER_PAPER, SEARCH_PAPER, 0),
    (TIER_ACCURATE, SEARCH_PRISMS, 1),
];

/// The scenes of `assets/` as they are, and in every way.
static SCENES: LazyLock<Vec<Prepared>> = LazyLock::new(|| {
    let mut all = Vec::new();
    for path in scenes() {
        let load = || Scene::load(&path).unwrap();
        all.push(Prepared::new(&path, load()));
        for (tier, search, self_shadow) in WAYS {
            let mut other = Prepared::with(&path, load(), &|parameters| {
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
    }
    all
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

    /// As relievo-shared itself draws it.
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
            use relievo_shared_variant::$tree::fragment;
            use relievo_shared_variant::$tree::layout::{
                Frame, Object, SEARCH_EXTRUSION, SEARCH_PAPER, SEARCH_RELIEF, Shell, Triangle,
            };
            use relievo_shared_variant::$tree::normals::CLASS_MISS;
            use relievo_shared_variant::$tree::shell::{self, ShellHit};

            enum Found {
                Facet(fragment::Entry, fragment::Hit),
                Prism(ShellHit),
            }

            impl Found {
                fn hit(&self) -> &fragment::Hit {
                    match self {
                        Found::Facet(_, hit) => hit,
                        Found::Prism(found) => &found.hit,
                    }
                }
            }

            pub fn render(prepared: &Prepared) -> Picture {
                let frame: Frame = bytemuck::cast(prepared.scene.frame);
                let pixel = |(i, candidates): (usize, &Vec<[usize; 2]>)| {
                    let (x, y) = (i as u32 % SIZE[0], i as u32 / SIZE[0]);
                    draw(prepared, &frame, candidates, x, y)
                };
                let candidates = prepared.candidates.iter();
                Picture(candidates.enumerate().map(pixel).collect())
            }

            /// What the ray meets behind triangle `index`, or where it comes in
            /// through that prism, if that may be as near as the depth `best`.
            fn find(
                object: &PreparedObject,
                frame: &Frame,
                direction: Vec3,
                index: usize,
                best: f32,
            ) -> Option<Found> {
                let parameters: Object = bytemuck::cast(object.parameters);
                let texels = object.map.words();
                if object.has_prisms() {
                    let shells: &[Shell] = bytemuck::cast_slice(&object.shells);
                    return Some(Found::Prism(shell::trace(
                        frame,
                        &parameters,
                        shells,
                        texels,
                        direction,
                        index as u32,
                    )));
                }
                let triangle: Triangle = bytemuck::cast(object.triangles[index]);
                let facet = fragment::meet(frame, &parameters, &triangle, direction);
                if !facet.hit {
                    return None;
                }
                let entry = fragment::enter(&parameters, &triangle, direction, &facet);
                if !entry.path.enters || reversed_depth(frame, direction, entry.path.entry_t) < best
                {
                    return None;
                }
                let trace = match parameters.search {
                    SEARCH_PAPER => fragment::trace::<SEARCH_PAPER, [u32]>,
                    SEARCH_RELIEF => fragment::trace::<SEARCH_RELIEF, [u32]>,
                    _ => fragment::trace::<SEARCH_EXTRUSION, [u32]>,
                };
                let hit = trace(frame, &parameters, texels, direction, &entry);
                Some(Found::Facet(entry, hit))
            }

            /// As `relievo::render::CpuRenderer` draws a pixel.
            fn draw(
                prepared: &Prepared,
                frame: &Frame,
                candidates: &[[usize; 2]],
                x: u32,
                y: u32,
            ) -> [[u32; 4]; 3] {
                let direction = pixel_ray(frame, x, y);
                let mut nearest: Option<(usize, Found)> = None;
                for &[i, j] in candidates {
                    let best = nearest.as_ref().map_or(0.0, |(_, best)| best.hit().depth);
                    let object = &prepared.scene.objects[i];
                    if let Some(found) = find(object, frame, direction, j, best)
                        && found.hit().class != CLASS_MISS
                        && found.hit().depth > best
                    {
                        nearest = Some((i, found));
                    }
                }
                let Some((i, found)) = nearest else {
                    let [r, g, b] = prepared.scene.background.map(f32::to_bits);
                    return [[r, g, b, CLASS_MISS], [0; 4], [0; 4]];
                };
                let object = &prepared.scene.objects[i];
                let (parameters, texels) = (bytemuck::cast(object.parameters), object.map.words());
                let shadows = object.parameters.self_shadow != 0;
                let (rgb, normal) = match &found {
                    Found::Prism(found) => {
                        let shells: &[Shell] = bytemuck::cast_slice(&object.shells);
                        let color = if shadows {
                            shell::color::<true, [Shell], [u32]>
                        } else {
                            shell::color::<false, [Shell], [u32]>
                        };
                        (
                            color(frame, &parameters, shells, texels, direction, found),
                            shell::normals(&parameters, shells, texels, found),
                        )
                    }
                    Found::Facet(entry, hit) => {
                        let color = if shadows {
                            fragment::color::<true, [u32]>
                        } else {
                            fragment::color::<false, [u32]>
                        };
                        (
                            color(frame, &parameters, texels, direction, entry, hit),
                            fragment::normals(&parameters, texels, direction, entry, hit),
                        )
                    }
                };
                let (hit, normal) = (found.hit(), normal.carved);
                let [r, g, b] = rgb.to_array().map(fragment::word);
                let [nx, ny, nz] = normal.to_array().map(fragment::word);
                [
                    [r, g, b, hit.class],
                    [hit.t, hit.uv.x, hit.uv.y, hit.depth_fraction].map(fragment::word),
                    [fragment::class_and_steps(hit), nx, ny, nz],
                ]
            }
        }
    };
}

renderer!(native);
renderer!(corrected);

type Render = fn(&Prepared) -> Picture;

/// How many words of each scene are others than in [`Mode::Exact`].
fn different_words(render: Render, mode: Mode) -> Vec<usize> {
    let different = |prepared: &Prepared| {
        let changed = with_mode(mode, || render(prepared));
        let different = render(prepared).different_words(&changed);
        let (name, words) = (&prepared.name, changed.words());
        println!("{mode:?}, {name}: {different} of {words} words differ");
        different
    };
    SCENES.iter().map(different).collect()
}

/// The share of words that must differ where a variant is to be caught.
fn assert_caught(different: &[usize]) {
    let enough = (SIZE[0] * SIZE[1]) as usize / 10;
    assert!(different.iter().all(|&d| d > enough), "{different:?}");
}

/// The control: rewriting changes nothing, nor does correcting right results.
#[test]
fn exact_operations_draw_what_the_renderer_draws() {
    for prepared in SCENES.iter() {
        let expected = Picture::of_renderer(prepared);
        let covered = expected.0.iter().filter(|pixel| pixel[0][3] != 0).count();
        assert!(covered > 500, "{}: {covered} pixels", prepared.name);
        for render in [native::render, corrected::render] {
            let different = render(prepared).different_words(&expected);
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

/// The corrected operations do not depend on the device's; the native ones do.
#[test]
fn inaccurate_division_changes_native_pictures_only() {
    for ulps in [1, 3] {
        assert_caught(&different_words(native::render, Mode::DivisionOff(ulps)));
    }
    for ulps in [3, 8] {
        let different = different_words(corrected::render, Mode::DivisionOff(ulps));
        assert!(different.iter().all(|&d| d == 0), "{different:?}");
    }
}

#[test]
fn flushing_denormals_changes_nothing() {
    for render in [native::render as Render, corrected::render] {
        let different = different_words(render, Mode::FlushToZero);
        assert!(different.iter().all(|&d| d == 0), "{different:?}");
    }
}

/// A sphere so small that the squares of its edges are hardly above the denormals.
fn tiny() -> Prepared {
    let text = format!(
        "[camera]\neye = [0.0, 0.0, 4e-12]\ntarget = [0.0, 0.0, 0.0]\n[[object]]\nmesh = {:?}\nshape = {:?}\nrepeat = [8, 4]\ndepth = 0.05\n",
        asset("meshes/sphere.obj"),
        asset("patterns/letters.png"),
    );
    let path = Path::new("tiny.toml");
    let mut scene = Scene::parse(&text, path).unwrap();
    // Less than a scene file may say.
    scene.objects[0].scale = 1e-12;
    Prepared::new(path, scene)
}

#[test]
fn flushing_denormals_is_caught_where_the_value_contract_is_broken() {
    let tiny = tiny();
    let (exact, findings) = audited(|| native::render(&tiny));
    let flushed = with_mode(Mode::FlushToZero, || native::render(&tiny));
    let different = exact.different_words(&flushed);
    println!("{different} words differ");
    assert!(different > 1000, "{different} words");
    // And the audit says so.
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

#[test]
fn the_values_of_every_scene_keep_the_contract() {
    let trees: [(&str, Render); 2] = [("native", native::render), ("corrected", corrected::render)];
    let mut found = Vec::new();
    for prepared in SCENES.iter() {
        for (tree, render) in trees {
            let (_, findings) = audited(|| render(prepared));
            found.extend(findings.iter().map(|f| describe(tree, &prepared.name, f)));
        }
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}
