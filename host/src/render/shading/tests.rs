//! Pictures of scenes that are lit physically, against what is known of them.

use crate::mesh::{MeshData, Projection};
use crate::prepare::{PreparedScene, prepare};
use crate::render::{CpuRenderer, Hits, Renderer};
use crate::scene::{
    Camera, Color, Environment, Finish, LightKind, LightSource, PhysicalMaterial, Scene,
    SceneObject, Shape, Technique, Tier,
};
use crate::shape_map::Pattern;
use crate::{Files, Limits};
use glam::DVec3;
use relievo_shared::model::Hit;
use relievo_shared::normals::{CLASS_CAP, CLASS_FLOOR, CLASS_MISS, CLASS_SKY, CLASS_WALL};
use relievo_shared::openness::openness;
use relievo_shared::shape_map::ShapeMap;
use std::path::Path;

/// A pattern that covers everything: caps alone.
fn covered() -> Pattern {
    Pattern::from_pixels(2, 2, [true; 4]).unwrap()
}

/// A rectangle of the plane y = `height`, seen from above, with the texture coordinates x and z.
fn plate(size: f64, height: f64) -> MeshData {
    let half = 0.5 * size;
    let corners = [[-half, half], [half, half], [half, -half], [-half, -half]];
    MeshData::new(
        "plate",
        corners.map(|[x, z]| [x, height, z]),
        [[0, 1, 2], [0, 2, 3]],
    )
    .with_uvs([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
}

fn material(name: &str, base: f64, metallic: f64, roughness: f64) -> PhysicalMaterial {
    PhysicalMaterial {
        name: name.to_string(),
        base_color: Color([base; 3]),
        metallic,
        roughness,
        ..PhysicalMaterial::default()
    }
}

fn all(name: &str) -> Finish {
    let name = Some(name.to_string());
    Finish {
        cap: name.clone(),
        wall: name.clone(),
        bevel: name.clone(),
        floor: name,
    }
}

fn colors(scene: &Scene) -> (PreparedScene, crate::render::ColorWords) {
    let prepared = prepare(scene, &|_| ()).unwrap();
    let words = CpuRenderer::new(&prepared).color(&prepared.frame).unwrap();
    (prepared, words)
}

/// White surfaces in even light cannot be told from it.
#[test]
fn a_furnace_hides_what_is_white() {
    let sphere = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets/meshes/sphere.obj");
    for tier in [Tier::Fast, Tier::Accurate] {
        for (metallic, roughness) in [(1.0, 0.0), (1.0, 0.4), (1.0, 1.0), (0.0, 0.1), (0.0, 1.0)] {
            let object = SceneObject::new(
                crate::mesh::MeshSource::File(sphere.clone()),
                Shape::text("A8"),
            )
            .tier(tier)
            .repeat(8.0, 4.0)
            .depth(0.05)
            .finish(all("white"));
            let scene = Scene::default()
                .size(60, 60)
                .environment(Environment {
                    occlusion: 0.0,
                    ..Environment::default()
                })
                .with_light(LightSource {
                    intensity: 0.0,
                    ..LightSource::default()
                })
                .with_material(material("white", 1.0, metallic, roughness))
                .object(object);
            let (prepared, words) = colors(&scene);
            // The light is dark.
            assert!(prepared.lighting.unwrap().shadow_maps.is_empty());
            let mut hits = 0;
            for pixel in &words.words {
                if pixel[3] != 0 {
                    hits += 1;
                    for channel in &pixel[..3] {
                        let light = f32::from_bits(*channel);
                        assert!(
                            (light - 1.0).abs() < 0.01,
                            "{metallic} {roughness}: {light}"
                        );
                    }
                }
            }
            assert!(hits > 500, "{hits}");
        }
    }
}

/// A plate above the ground, in light from a side: what it shades is known.
fn shaded(light: LightSource, towards: impl Fn(DVec3) -> DVec3) {
    let plain = |mesh| {
        SceneObject::new(mesh, covered())
            .depth(0.01)
            .finish(all("white"))
    };
    let scene = Scene::default()
        .size(160, 120)
        .camera(Camera::new([3.0, 6.0, 5.0], [0.0, 0.0, 0.0]))
        .with_light(light)
        .with_material(material("white", 1.0, 0.0, 1.0))
        .object(plain(plate(6.0, 0.0)))
        .object(plain(plate(1.0, 1.0)));
    let (prepared, words) = colors(&scene);
    let geometry = CpuRenderer::new(&prepared)
        .geometry(&prepared.frame)
        .unwrap();
    let hits = Hits::new(&prepared, &prepared.frame, &geometry);
    let mut counts = [0; 2];
    for hit in hits.pixels().flatten() {
        if hit.object() != Some(0) {
            continue;
        }
        let [x, y] = hit.pixel();
        let lit = words.rgb(x, y)[1];
        // Where the way to the light meets the plane of the upper plate.
        let position = hit.position();
        let to_light = towards(position);
        let above = position + to_light * ((1.0 - position.y) / to_light.y);
        let beyond = above.x.abs().max(above.z.abs()) - 0.5;
        if beyond.abs() < 0.02 {
            continue;
        }
        counts[usize::from(beyond < 0.0)] += 1;
        assert_eq!(lit > 0.0, beyond > 0.0, "{position} {lit} {beyond}");
    }
    assert!(counts.iter().all(|count| *count > 100), "{counts:?}");
}

#[test]
fn shadows_of_a_directional_light_are_where_the_light_does_not_reach() {
    let direction = DVec3::new(0.5, 1.0, 0.3);
    let light = LightSource {
        direction: direction.to_array(),
        ..LightSource::default()
    };
    shaded(light, |_| direction);
}

#[test]
fn shadows_of_lights_at_a_place_are_where_the_light_does_not_reach() {
    let position = DVec3::new(0.4, 3.0, 0.5);
    for kind in [LightKind::Point, LightKind::Spot] {
        let light = LightSource {
            kind,
            position: position.to_array(),
            outer_angle: 70.0,
            ..LightSource::default()
        };
        shaded(light, |at| position - at);
    }
}

/// A picture on a plane, against the same picture filtered in f64.
#[test]
fn a_picture_lies_on_a_plane_as_an_independent_lookup_has_it() {
    let (width, height) = (8, 4);
    let value = |x: u32, y: u32| ((x * 37 + y * 91) % 256) as u8;
    let picture = image::RgbImage::from_fn(width, height, |x, y| {
        image::Rgb([value(x, y), value(y, x), value(x + y, 7)])
    });
    let mut bytes = std::io::Cursor::new(Vec::new());
    picture
        .write_to(&mut bytes, image::ImageFormat::Png)
        .unwrap();
    let files = Files::memory([
        ("picture.png".into(), bytes.into_inner().into()),
        // Replaced below.
        ("a.obj".into(), b"".as_slice().into()),
        ("b.png".into(), b"".as_slice().into()),
    ]);
    for (repeat, mesh_tiles) in [(1.0, false), (3.0, true)] {
        let text = format!(
            "image.size = [120, 90]\n[camera]\neye = [0.3, 1.5, 0.4]\nfov = 50\n[[light]]\nintensity = 0\n[[material]]\nname = 'm'\nbase_color = '#000000'\nemission = '#ffffff'\nemission_image = 'picture.png'\ncoordinates = '{}'\n[[object]]\nmesh = 'a.obj'\nshape = 'b.png'\nrepeat = [{repeat}, {repeat}]\ndepth = 0.01\nmaterial = {{ cap = 'm' }}\n",
            if mesh_tiles { "mesh" } else { "pattern" }
        );
        let mut scene =
            Scene::parse_with(&text, Path::new(""), &Limits::default(), files.clone()).unwrap();
        scene.objects[0].mesh = plate(2.0, 0.0).into();
        scene.objects[0].shape = covered().into();
        let (prepared, words) = colors(&scene);
        let geometry = CpuRenderer::new(&prepared)
            .geometry(&prepared.frame)
            .unwrap();
        let hits = Hits::new(&prepared, &prepared.frame, &geometry);
        let mut compared = 0;
        for hit in hits.pixels().flatten() {
            let position = hit.position();
            // v of the picture runs down, and v of the mesh up.
            let (u, v) = (0.5 + 0.5 * position.x, 0.5 + 0.5 * position.z);
            let at = [u * f64::from(width) - 0.5, v * f64::from(height) - 0.5];
            let [x, y] = at.map(f64::floor);
            let pixel = |dx: f64, dy: f64| {
                let x = (x + dx).rem_euclid(f64::from(width)) as u32;
                let y = (y + dy).rem_euclid(f64::from(height)) as u32;
                let color = picture.get_pixel(x, y).0.map(|s| f64::from(s) / 255.0);
                DVec3::from(Color(color).linear().map(f64::from))
            };
            let [across, down] = [at[0] - x, at[1] - y];
            let row = |dy: f64| pixel(0.0, dy).lerp(pixel(1.0, dy), across);
            let expected = row(0.0).lerp(row(1.0), down);
            let [x, y] = hit.pixel();
            let found = DVec3::from(words.rgb(x, y).map(f64::from));
            assert!(
                (found - expected).length() < 2e-3,
                "{u} {v}: {found} {expected}"
            );
            compared += 1;
        }
        assert!(compared > 5000, "{compared}");
    }
}

#[test]
fn scenes_without_materials_and_lights_are_not_lit_physically() {
    let object = SceneObject::new(plate(2.0, 0.0), covered()).projection(Projection::PlanarY);
    let scene = Scene::default().size(8, 8).object(object);
    let prepared = prepare(&scene, &|_| ()).unwrap();
    assert!(prepared.lighting.is_none());
    let physical = scene.with_material(material("m", 0.5, 0.0, 0.5));
    assert!(prepare(&physical, &|_| ()).unwrap().lighting.is_some());
}

/// Between two long walls the share of the sky is a form factor that is known.
#[test]
fn grounds_and_walls_of_a_groove_see_a_strip_of_sky() {
    let stripes = Pattern::from_fn(64, 64, |x, _| x < 32).unwrap();
    // A repeat is 2 units: the groove is 1 wide and 0.5 deep.
    let object = SceneObject::new(plate(2.0, 0.0), stripes).depth(0.5);
    let prepared = prepare(&Scene::default().size(8, 8).object(object), &|_| ()).unwrap();
    let object = &prepared.objects[0];
    let depth = f64::from(object.parameters.depth);
    let open = |class: u32, u: f64, depth_fraction: f64| {
        let uv = relievo_shared::Vec2::new(u as f32, 0.3);
        let words = object.map.words();
        let map = ShapeMap::new(&object.parameters);
        let hit = Hit {
            class,
            depth: 0.5,
            t: 1.0,
            uv,
            repeat: relievo_shared::Vec2::ZERO,
            depth_fraction: depth_fraction as f32,
            steps: 1,
            layer: 0,
        };
        let (distance, gradient) = (map.distance(words, uv), map.gradient(words, uv));
        f64::from(openness(
            &object.parameters,
            &map,
            words,
            &hit,
            distance,
            gradient,
            0.5,
        ))
    };
    let hidden = |distance: f64, height: f64| 0.5 - 0.5 * distance / distance.hypot(height);
    for u in [0.52, 0.6, 0.7, 0.75, 0.85, 0.95] {
        let [left, right] = [2.0 * (u - 0.5), 2.0 * (1.0 - u)];
        let expected = 1.0 - hidden(left, depth) - hidden(right, depth);
        let found = open(CLASS_FLOOR, u, 1.0);
        assert!((found - expected).abs() < 0.03, "{u}: {found} {expected}");
    }
    for fraction in [0.1, 0.5, 1.0] {
        let found = open(CLASS_WALL, 0.5, fraction);
        // Half of what a wall sees is the ground, as bright as the sky is open there.
        let expected = 0.25 + 0.5 * (0.5 - 0.5 * fraction * depth / (fraction * depth).hypot(1.0));
        assert!(
            (found - expected).abs() < 0.03,
            "{fraction}: {found} {expected}"
        );
    }
    assert_eq!(open(CLASS_CAP, 0.2, 0.0), 1.0);
}

/// What is seen where no object is: the environment, black where it is dark, or the background.
#[test]
fn the_environment_is_seen_where_no_object_is() {
    let shown = |environment: Environment| {
        let object = SceneObject::new(plate(0.1, 0.0), covered()).depth(0.001);
        let scene = Scene::default()
            .size(8, 8)
            .camera(Camera::new([0.0, 2.0, 2.0], [0.0, 0.0, 0.0]))
            .background(Color([1.0; 3]))
            .environment(environment)
            .object(object);
        let (_, words) = colors(&scene);
        (words.rgb(0, 0), words.pixel(0, 0)[3])
    };
    let with = |is_visible, intensity| Environment {
        is_visible,
        intensity,
        ..Environment::default()
    };
    assert_eq!(shown(with(false, 0.5)), ([1.0; 3], CLASS_MISS));
    assert_eq!(shown(with(true, 0.5)), ([0.5; 3], CLASS_SKY));
    assert_eq!(shown(with(true, 0.0)), ([0.0; 3], CLASS_MISS));
}

#[test]
fn objects_with_an_error_budget_keep_their_materials() {
    let object = |name: &str, x: f64| {
        SceneObject::new(plate(1.0, 0.0), covered())
            .depth(0.01)
            .translate([x, 0.0, 0.0])
            .finish(all(name))
    };
    let scene = Scene::default()
        .size(40, 30)
        .environment(Environment::default())
        .with_material(material("white", 1.0, 0.0, 1.0))
        .with_material(material("black", 0.0, 1.0, 1.0))
        .object(object("white", -1.0))
        .object(object("black", 1.0).budget(0.5));
    let planned = crate::budget::plan(&scene, &|_| ()).unwrap().scene;
    let finishes = planned.objects.iter();
    let finishes: Vec<u32> = finishes.map(|object| object.parameters.finish).collect();
    assert_eq!(finishes, [0, 1]);
}

/// A picture of 2 × 2 texels, as the bytes of a PNG.
fn four_colors(texels: [[u8; 3]; 4]) -> Vec<u8> {
    let picture = image::RgbImage::from_raw(2, 2, texels.concat()).unwrap();
    let mut bytes = std::io::Cursor::new(Vec::new());
    let format = image::ImageFormat::Png;
    picture.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

/// Two squares side by side in the plane z = 0, with materials of their own.
const TWO_SQUARES: &str = "mtllib two.mtl
v -2 -1 0\nv 0 -1 0\nv 0 1 0\nv -2 1 0\nv 2 -1 0\nv 2 1 0
vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1
usemtl four\nf 1/1 2/2 3/3 4/4
usemtl red\nf 2/1 5/2 6/3 3/4
";

fn two_squares(change: impl Fn(SceneObject) -> SceneObject) -> Scene {
    let (red, green, blue, white) = ([255, 0, 0], [0, 255, 0], [0, 0, 255], [255; 3]);
    let files = [
        ("two.obj", TWO_SQUARES.as_bytes().to_vec()),
        (
            "two.mtl",
            b"newmtl red\nKd 1 0 0\nnewmtl four\nKd 1 1 1\nmap_Kd four.png\n".to_vec(),
        ),
        // Its first row is the upper one.
        ("four.png", four_colors([red, green, blue, white])),
    ];
    let files = files.map(|(name, bytes)| (name.into(), bytes.into()));
    let object = SceneObject::new("two.obj", covered()).depth(0.01);
    let scene = Scene {
        files: Files::memory(files),
        ..Scene::default()
    };
    scene
        .size(80, 40)
        .camera(Camera::new([0.0, 0.0, 5.0], [0.0; 3]))
        .environment(Environment {
            occlusion: 0.0,
            ..Environment::default()
        })
        .object(change(object.finish(Finish::of_mesh())))
}

/// Returns which channels of the pixel at (`x`, `y`) of the plane are bright.
fn bright(words: &crate::render::ColorWords, [x, y]: [f64; 2]) -> Option<[bool; 3]> {
    // Half the height of the picture at distance 5.
    let half = 5.0 * (0.5 * 45_f64.to_radians()).tan();
    let column = 40.0 + 20.0 * x / half;
    let row = 20.0 - 20.0 * y / half;
    let [red, green, blue, class] = words.words[row as usize * 80 + column as usize];
    let channels = [red, green, blue].map(|channel| f32::from_bits(channel) > 0.3);
    (class == CLASS_CAP).then_some(channels)
}

#[test]
fn triangles_show_the_materials_and_pictures_of_their_mesh() {
    let (_, words) = colors(&two_squares(|object| object));
    // In the middle of the texels.
    assert_eq!(bright(&words, [-1.5, 0.5]), Some([true, false, false]));
    assert_eq!(bright(&words, [-0.5, 0.5]), Some([false, true, false]));
    assert_eq!(bright(&words, [-1.5, -0.5]), Some([false, false, true]));
    assert_eq!(bright(&words, [-0.5, -0.5]), Some([true; 3]));
    for place in [[0.5, 0.5], [1.5, -0.5]] {
        assert_eq!(bright(&words, place), Some([true, false, false]));
    }
    // The pattern's repeats do not matter.
    let (_, repeated) = colors(&two_squares(|object| object.repeat(3.0, 5.0)));
    assert_eq!(bright(&repeated, [-0.5, 0.5]), Some([false, true, false]));
}

#[test]
fn parts_are_drawn_alone() {
    let parts = |name: &str| {
        let scene = two_squares(|object| SceneObject {
            parts: vec![name.to_string()],
            ..object
        });
        prepare(&scene, &|_| ())
    };
    let prepared = parts("red").unwrap();
    let words = CpuRenderer::new(&prepared).color(&prepared.frame).unwrap();
    assert_eq!(bright(&words, [0.5, 0.5]), Some([true, false, false]));
    assert_eq!(bright(&words, [-0.5, 0.5]), None);
    let message = parts("tin").err().unwrap().to_string();
    assert!(
        message.contains(r#"its parts are "four", "red""#),
        "{message}"
    );
}

#[test]
fn a_mesh_without_materials_is_told() {
    let scene = Scene::default().object(
        SceneObject::new(plate(1.0, 0.0), covered())
            .depth(0.01)
            .finish(Finish::of_mesh()),
    );
    let message = prepare(&scene, &|_| ()).err().unwrap().to_string();
    assert!(message.contains("@mesh"), "{message}");
}

/// As on a GPU, which has their parameters once.
#[test]
fn objects_that_differ_by_their_place_share_their_materials() {
    let at = |x: f64| {
        SceneObject::new(plate(1.0, 0.0), covered())
            .depth(0.01)
            .finish(all("white"))
            .translate([x, 0.0, 0.0])
    };
    let scene = Scene::default()
        .with_material(material("white", 1.0, 0.0, 1.0))
        .object(at(0.0))
        .object(at(2.0))
        .object(at(4.0).depth(0.02));
    let prepared = prepare(&scene, &|_| ()).unwrap();
    let finishes: Vec<u32> = prepared
        .objects
        .iter()
        .map(|object| object.parameters.finish)
        .collect();
    assert_eq!(finishes, [0, 0, 1]);
}

/// An azimuth that is not along the pattern's axes.
const ASIDE: f64 = 0.59;

/// Returns a plate with `pattern`, 64 times along each side, whose grooves are half as deep as the pattern is wide
/// and grow by `bevel` of its width, seen from `elevation` degrees above it, at a quarter of a turn for an
/// `azimuth` of 1, in `side` × `side` pixels: of 8 × 8, each is wider than the pattern.
fn far_plate(
    pattern: &Pattern,
    bevel: f64,
    [elevation, azimuth]: [f64; 2],
    light: &LightSource,
    (side, is_smooth): (u32, bool),
) -> Scene {
    let (sine, cosine) = elevation.to_radians().sin_cos();
    let (across, along) = (azimuth * std::f64::consts::FRAC_PI_2).sin_cos();
    let eye = DVec3::new(along * cosine, sine, across * cosine) * 20.0;
    let plain = |color| Color(color);
    let object = SceneObject::new(plate(1.0, 0.0), pattern.clone())
        .repeat(64.0, 64.0)
        .depth(0.5 / 64.0)
        .steps(512)
        .bisections(12)
        .material(crate::scene::Material {
            cap: plain([1.0, 0.0, 0.0]),
            wall: plain([0.0, 1.0, 0.0]),
            bevel: plain([0.0, 1.0, 0.0]),
            floor: plain([0.0, 0.0, 1.0]),
            ..crate::scene::Material::default()
        });
    let object = match bevel > 0.0 {
        true => object.with_technique(Technique::Beveled).bevel(bevel),
        false => object,
    };
    let mut scene = Scene::default()
        .size(side, side)
        .camera(Camera::new(eye.to_array(), [0.0; 3]))
        .environment(Environment {
            intensity: if light.intensity > 0.0 { 0.0 } else { 1.0 },
            occlusion: 0.0,
            ..Environment::default()
        })
        .with_light(light.clone())
        .object(object);
    scene.field_of_view = 1.0;
    scene.smooth_edges = is_smooth;
    scene
}

/// Returns the mean linear RGB of [`far_plate`]: from one sample with smooth edges in each of 8 × 8 pixels,
/// and from 64 times as many along each side.
fn far_colors(
    pattern: &Pattern,
    bevel: f64,
    place: [f64; 2],
    light: &LightSource,
) -> [[f64; 3]; 2] {
    [(8, true), (512, false)].map(|drawn| {
        let (_, words) = colors(&far_plate(pattern, bevel, place, light, drawn));
        let mut sum = [0.0; 3];
        for pixel in &words.words {
            assert_ne!(pixel[3] & 0xff, CLASS_MISS);
            for (sum, word) in sum.iter_mut().zip(pixel) {
                *sum += f64::from(f32::from_bits(*word));
            }
        }
        sum.map(|sum| sum / words.words.len() as f64)
    })
}

/// Patterns of stripes, bricks, dots and square holes.
fn small_patterns() -> [Pattern; 4] {
    let of = |is_solid: fn(f64, f64) -> bool| {
        let at = |i: u32| (f64::from(i) + 0.5) / 64.0;
        let solid = (0..64 * 64).map(|i| is_solid(at(i % 64), at(i / 64)));
        Pattern::from_pixels(64, 64, solid.collect::<Vec<_>>()).unwrap()
    };
    [
        of(|u, _| u < 0.5),
        of(|u, v| {
            let shifted = if v < 0.5 { u } else { u + 0.5 };
            shifted.fract() < 0.875 && (v * 2.0).fract() < 0.75
        }),
        of(|u, v| (u - 0.5).hypot(v - 0.5) < 0.35),
        of(|u, v| (u - 0.5).abs() > 0.3 || (v - 0.5).abs() > 0.3),
    ]
}

/// Asserts that the two colours of [`far_colors`] differ by less than `most` of the light of the second.
fn assert_alike([found, expected]: [[f64; 3]; 2], most: f64, what: &str) {
    println!("{what}: {found:.3?} {expected:.3?}");
    let whole: f64 = expected.iter().sum();
    for (found, expected) in found.into_iter().zip(expected) {
        let error = (found - expected) / whole;
        assert!(error.abs() < most, "{what}: {error}");
    }
}

/// Asserts it for a plate in the light of a sun from three directions.
fn assert_lit_alike(pattern: &Pattern, bevel: f64, most: f64, what: &str) {
    for direction in [[0.3, 1.0, 0.2], [1.0, 0.8, -0.4], [-0.7, 0.6, -0.9]] {
        let light = LightSource {
            direction,
            ..LightSource::default()
        };
        let colors = far_colors(pattern, bevel, [50.0, ASIDE], &light);
        assert_alike(colors, most, &format!("{what} {direction:?}"));
    }
}

/// Returns a light of intensity 0, for scenes that only an environment lights.
fn dark() -> LightSource {
    LightSource {
        intensity: 0.0,
        casts_shadows: false,
        ..LightSource::default()
    }
}

/// What a pixel sees of cap, sides and floor of a pattern that is smaller, against what many samples see.
#[test]
fn the_mean_of_a_small_pattern_has_the_shares_of_its_surfaces() {
    for (index, pattern) in small_patterns().iter().enumerate() {
        for elevation in [80.0, 50.0, 25.0] {
            let colors = far_colors(pattern, 0.0, [elevation, ASIDE], &dark());
            assert_alike(colors, 0.035, &format!("{index} {elevation}"));
        }
    }
}

/// Of bricks, the joints that run along the direction of the eye hide nothing.
#[test]
fn the_mean_of_bricks_has_the_shares_that_are_seen_along_their_joints() {
    let bricks = &small_patterns()[1];
    // Across the long joints, some rays meet a joint between bricks, and go farther than most.
    for (azimuth, most) in [(0.0, 0.035), (0.05, 0.035), (1.0, 0.045)] {
        for elevation in [50.0, 25.0] {
            let colors = far_colors(bricks, 0.0, [elevation, azimuth], &dark());
            assert_alike(colors, most, &format!("{elevation} {azimuth}"));
        }
    }
}

/// Shadows that are looked up above the grooves leave leaning sides in the light.
#[test]
fn the_mean_of_a_small_pattern_is_lit_where_shadow_maps_are_coarse() {
    let light = LightSource {
        direction: [0.3, 1.0, 0.2],
        shadow_size: 64,
        ..LightSource::default()
    };
    let patterns = small_patterns();
    for (index, most) in [(0, 0.06), (1, 0.06), (2, 0.14), (3, 0.06)] {
        let colors = far_colors(&patterns[index], 0.1, [50.0, ASIDE], &light);
        assert_alike(colors, most, &format!("{index}"));
    }
}

/// The light that arrives in the grooves of a small pattern, against what many samples see.
#[test]
fn the_mean_of_a_small_pattern_is_lit_as_its_surfaces_are() {
    for (index, pattern) in small_patterns().iter().enumerate() {
        assert_lit_alike(pattern, 0.0, 0.06, &format!("{index}"));
    }
}

/// Sides that lean, and sides that lean so much that they meet.
#[test]
fn the_mean_of_a_small_pattern_is_lit_on_sides_that_lean() {
    let patterns = small_patterns();
    // The feet of the discs nearly touch, so that their grooves have no one width.
    for (index, bevel, most) in [
        (0, 0.1, 0.06),
        (0, 0.3, 0.06),
        (2, 0.1, 0.14),
        (3, 0.1, 0.06),
        (3, 0.35, 0.06),
    ] {
        assert_lit_alike(&patterns[index], bevel, most, &format!("{index} {bevel}"));
    }
}

/// Pixels that show nothing but the mean are the same if their rays are marched.
#[test]
fn a_mean_is_the_same_without_a_march() {
    let light = LightSource::default();
    for (index, pattern) in small_patterns().iter().enumerate() {
        let scene = far_plate(pattern, 0.1, [50.0, ASIDE], &light, (8, true));
        let found = prepare(&scene, &|_| ()).unwrap();
        let mut marched = prepare(&scene, &|_| ()).unwrap();
        assert!(found.objects[0].parameters.mean_from > 0.0, "{index}");
        marched.objects[0].parameters.mean_from = 0.0;
        let [found, marched] =
            [&found, &marched].map(|scene| CpuRenderer::new(scene).color(&scene.frame).unwrap());
        // Otherwise rays are marched in both.
        assert!(found.words.iter().all(|pixel| pixel[3] == CLASS_CAP));
        assert!(marched.words.iter().any(|pixel| pixel[3] & 7 != CLASS_CAP));
        for (found, marched) in found.words.iter().zip(&marched.words) {
            for (found, marched) in found.iter().zip(marched).take(3) {
                let [found, marched] = [found, marched].map(|word| f32::from_bits(*word));
                assert!(
                    (found - marched).abs() < 2e-3 * marched.max(0.1),
                    "{index}: {found} {marched}"
                );
            }
        }
    }
}
