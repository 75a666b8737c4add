//! The example for three.js in a headless Chromium, beside our own rays.

mod rays;

use crate::browser::{Page, base64, chromium};
use glam::{DVec3, DVec4};
use rays::{Cuboid, Hit, Rays};
use relievo::export::{Options, Output, Target, export};
use relievo::prepare::{PreparedScene, prepare};
use relievo::render::{CpuRenderer, Renderer};
use relievo::scene::{Camera, Scene};
use relievo_tests::{asset, lacking, root};
use std::fs;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// Size of the pictures, pixels.
const SIZE: [u32; 2] = [400, 300];

/// Where the example is.
fn example() -> PathBuf {
    root().join("host/examples/three")
}

/// The script of the example's page.
fn script() -> String {
    let page = fs::read_to_string(example().join("index.html")).unwrap();
    let (_, script) = page.split_once("<script type=\"module\">\n").unwrap();
    script.split_once("</script>").unwrap().0.to_string()
}

/// The guide has exactly the script that the tests draw, and it is short.
#[test]
fn the_guide_has_the_script_of_the_example() {
    let guide = fs::read_to_string(root().join("docs/three.md")).unwrap();
    let (_, code) = guide.split_once("```js\n").expect("it has a script");
    let (code, _) = code.split_once("```").unwrap();
    assert_eq!(code, script());
    assert!(code.lines().count() <= 25, "{}", code.lines().count());
}

/// Writes what `relievo export --target wgsl --write hit` writes of a scene of `assets/scenes`.
fn export_to(folder: &Path, scene: &str) {
    let scene = Scene::load(&asset("scenes").join(scene)).unwrap();
    let options = Options {
        targets: vec![Target::Wgsl],
        output: Output::Hit,
        ..Options::default()
    };
    fs::create_dir(folder).unwrap();
    for file in export(&prepare(&scene, &|_| ()).unwrap(), &options).unwrap() {
        fs::write(folder.join(file.name), file.bytes).unwrap();
    }
}

/// Opens the example's page with exports of these scenes, and `probe.js` beside it, whose pictures
/// have normals in place of light or not; none if a tool is missing.
fn open(exports: &[(&str, &str)], wants_normals: bool) -> Option<(Page, TempDir)> {
    let three = example().join("node_modules/three");
    if !three.is_dir() {
        lacking("three.js (`npm ci` in host/examples/three)");
        return None;
    }
    if chromium().is_none() {
        lacking("Chromium");
        return None;
    }
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    // Software draws a frame for a second, but a page asks for 60: only two get one.
    const BEFORE: &str = "<script>
        window.problems = [];
        addEventListener('error', (event) => problems.push(event.message));
        addEventListener('unhandledrejection', (event) => problems.push(String(event.reason)));
        for (const kind of ['error', 'warn']) console[kind] = (...all) => problems.push(all.join(' '));
        window.frame = { left: 2, next: null, ask: requestAnimationFrame.bind(window) };
        window.requestAnimationFrame = (draw) => frame.left-- > 0 ? frame.ask(draw) : (frame.next = draw, 0);
        [innerWidth, innerHeight] = [400, 300];
    </script>\n<script type=\"importmap\">";
    const AFTER: &str =
        "window.example = { renderer, scene, camera, sun, carved, cube, ground };\n</script>\n";
    let page = fs::read_to_string(example().join("index.html")).unwrap();
    let (start, end) = page.rsplit_once("</script>").unwrap();
    let page = format!("{start}{AFTER}{end}").replacen("<script type=\"importmap\">", BEFORE, 1);
    fs::write(at("index.html"), page).unwrap();
    fs::copy(example().join("relievo.js"), at("relievo.js")).unwrap();
    fs::write(at("probe.js"), include_str!("probe.js")).unwrap();
    for name in [
        "build/three.webgpu.js",
        "build/three.core.js",
        "build/three.tsl.js",
        "examples/jsm/controls/OrbitControls.js",
    ] {
        let path = at("node_modules/three").join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::copy(three.join(name), path).unwrap();
    }
    for (name, scene) in exports {
        export_to(&at(name), scene);
    }
    let page = Page::open(folder.path(), "");
    page.wait_for(
        "the page",
        "window.example !== undefined && frame.next !== null || problems.length > 0",
    );
    assert_eq!(problems(&page), "");
    page.run(&format!("window.wantsNormals = {wants_normals}"));
    page.run_async("await import('./probe.js')");
    assert_eq!(problems(&page), "");
    Some((page, folder))
}

/// What the browser, WebGPU and three.js complain about.
fn problems(page: &Page) -> String {
    page.run("problems.join('\\n')")
        .as_str()
        .unwrap()
        .to_string()
}

/// A picture of the page.
struct Picture {
    width: usize,
    /// Light, linear RGB; or the normal in the world.
    first: Vec<[f32; 4]>,
    /// Position in the world, and 1 more than the class.
    surface: Vec<[f32; 4]>,
}

impl Picture {
    /// Draws from the camera that the body of a function returns. It knows the variables of the
    /// example and of the probe.
    fn draw(page: &Page, [width, height]: [u32; 2], body: &str) -> Picture {
        let answer = page.run_async(&format!(
            "const {{ THREE, load, draw }} = probe;
             const {{ scene, camera, sun, carved, cube, ground }} = example;
             const from = await (async () => {{ {body} }})();
             return await draw({width}, {height}, from);"
        ));
        assert_eq!(problems(page), "");
        let text = answer.as_str().expect("a picture");
        let pixels = |text: &str| {
            let pixels: Vec<[f32; 4]> = bytemuck::pod_collect_to_vec(&base64(text));
            assert_eq!(pixels.len() as u32, width * height);
            pixels
        };
        let (first, surface) = text.split_once(' ').unwrap();
        Picture {
            width: width as usize,
            first: pixels(first),
            surface: pixels(surface),
        }
    }

    fn pixels(&self) -> std::ops::Range<usize> {
        0..self.surface.len()
    }

    /// The class of a pixel: 0 where nothing is, 9 where another object is.
    fn class(&self, pixel: usize) -> u32 {
        (self.surface[pixel][3] - 1.0) as u32
    }

    fn is_carved(&self, pixel: usize) -> bool {
        (1..9).contains(&self.class(pixel))
    }

    fn position(&self, pixel: usize) -> DVec3 {
        DVec4::from(self.surface[pixel].map(f64::from)).truncate()
    }

    /// Returns whether all pixels at most `reach` away from one have the value that it has.
    fn is_inside<T: PartialEq>(&self, values: &[T], pixel: usize, reach: usize) -> bool {
        let (x, y) = (pixel % self.width, pixel / self.width);
        let height = values.len() / self.width;
        let columns = x.saturating_sub(reach)..(x + reach + 1).min(self.width);
        (y.saturating_sub(reach)..(y + reach + 1).min(height))
            .flat_map(|row| columns.clone().map(move |column| row * self.width + column))
            .all(|other| values[other] == values[pixel])
    }
}

/// A scene with the page's camera.
fn from_the_page(scene: &str) -> PreparedScene {
    let mut scene = Scene::load(&asset("scenes").join(scene)).unwrap();
    scene.size = SIZE;
    scene.camera = Some(Camera::new([0.0, 2.3, 3.4], [0.0; 3]));
    scene.field_of_view = 38.0;
    prepare(&scene, &|_| ()).unwrap()
}

/// Linear light as sRGB, 0…255.
fn srgb(linear: f32) -> u8 {
    let value = if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    };
    (255.0 * value).round() as u8
}

/// The page's cube and its ground.
const CUBE: Cuboid = Cuboid {
    centre: DVec3::new(0.75, 0.2, 0.75),
    size: DVec3::splat(0.6),
};
const GROUND: Cuboid = Cuboid {
    centre: DVec3::new(0.0, -0.45, 0.0),
    size: DVec3::new(5.0, 0.1, 5.0),
};

/// Returns the ray of each pixel for a camera where the page's is: from the eye, or parallel.
/// `across` is the width of a pixel at distance 1, or everywhere.
fn rays([width, height]: [u32; 2], across: f64, is_parallel: bool) -> Vec<(DVec3, DVec3)> {
    let eye = DVec3::new(0.0, 2.3, 3.4);
    let forward = -eye.normalize();
    let right = forward.cross(DVec3::Y).normalize();
    let down = forward.cross(right);
    let ray = |x: u32, y: u32| {
        let from_centre = |at: u32, size: u32| f64::from(at) + 0.5 - 0.5 * f64::from(size);
        let aside = across * (right * from_centre(x, width) + down * from_centre(y, height));
        if is_parallel {
            (eye + aside, forward)
        } else {
            (eye, (forward + aside).normalize())
        }
    };
    (0..height)
        .flat_map(|y| (0..width).map(move |x| ray(x, y)))
        .collect()
}

/// Rays of the page's camera.
fn page_rays() -> Vec<(DVec3, DVec3)> {
    let tan = (0.5 * 38.0_f64.to_radians()).tan();
    rays(SIZE, 2.0 * tan / f64::from(SIZE[1]), false)
}

/// What the CPU's picture has.
fn on_cpu(scene: &PreparedScene) -> Vec<Option<Hit>> {
    let words = CpuRenderer::new(scene).geometry(&scene.frame).unwrap();
    let hit = |pixel: usize| {
        (words.class(pixel) != 0).then(|| Hit {
            class: words.class(pixel),
            t: f64::from(words.t(pixel)),
            normal: DVec3::from(words.normal(pixel).map(f64::from)),
        })
    };
    (0..words.surface.len()).map(hit).collect()
}

/// How a picture differs from what rays find.
#[derive(Debug, Default)]
struct Differences {
    /// Carved pixels.
    carved: usize,
    /// Pixels with another class.
    classes: usize,
    /// Those that are not beside an edge.
    inside: usize,
    /// Carved pixels whose hit is more than 10⁻³ from the ray's, world units.
    positions: usize,
    /// Those whose normal differs by more than 10⁻³.
    normals: usize,
}

impl Differences {
    /// Fails unless they are about what was measured: 0 classes, 1 position and 7 normals at most; beside
    /// edges of other objects 3 classes.
    fn check(&self) {
        let is_small = self.classes <= 4 && self.positions <= 4 && self.normals <= 20;
        assert!(
            self.carved > 10_000 && self.inside == 0 && is_small,
            "{self:?}"
        );
    }
}

/// Compares a picture with normals with what `rays` hit, the carved object or one of `boxes`.
fn compare(
    picture: &Picture,
    rays: &[(DVec3, DVec3)],
    hits: &[Option<Hit>],
    boxes: &[Cuboid],
) -> Differences {
    let nearest = |(&(origin, direction), hit): (&(DVec3, DVec3), &Option<Hit>)| {
        let boxes = boxes.iter().filter_map(|all| all.cast(origin, direction));
        let boxes = boxes.map(|t| Hit {
            class: 9,
            t,
            normal: DVec3::ZERO,
        });
        hit.iter()
            .copied()
            .chain(boxes)
            .min_by(|a, b| a.t.total_cmp(&b.t))
    };
    let wanted: Vec<Option<Hit>> = rays.iter().zip(hits).map(nearest).collect();
    let class = |hit: &Option<Hit>| hit.map_or(0, |hit| hit.class);
    let classes: Vec<u32> = wanted.iter().map(class).collect();
    let mut found = Differences::default();
    for pixel in picture.pixels() {
        found.carved += usize::from(picture.is_carved(pixel));
        if picture.class(pixel) != classes[pixel] {
            found.classes += 1;
            found.inside += usize::from(picture.is_inside(&classes, pixel, 1));
        } else if let Some(hit) = wanted[pixel].filter(|hit| hit.class < 9) {
            let (origin, direction) = rays[pixel];
            let at = origin + hit.t * direction;
            found.positions += usize::from(at.distance(picture.position(pixel)) > 1e-3);
            let normal = DVec4::from(picture.first[pixel].map(f64::from)).truncate();
            found.normals += usize::from(normal.distance(hit.normal) > 1e-3);
        }
    }
    found
}

#[test]
fn gpu_three_draws_the_carved_object_among_others() {
    let Some((page, _folder)) = open(&[("torus", "torus.toml")], true) else {
        return;
    };
    let is_gpu = page.run("example.renderer.backend.isWebGPUBackend");
    assert_eq!(is_gpu, true, "it fell back to WebGL");
    let scene = from_the_page("torus.toml");
    let (rays_of_eye, hits) = (page_rays(), on_cpu(&scene));

    let alone = "cube.visible = ground.visible = false; return camera;";
    let alone = Picture::draw(&page, SIZE, alone);
    let found = compare(&alone, &rays_of_eye, &hits, &[]);
    println!("alone: {found:?}");
    found.check();

    // Whatever is nearest is seen, by the depths that are written.
    let among = "cube.visible = ground.visible = true; return camera;";
    let among = Picture::draw(&page, SIZE, among);
    let found = compare(&among, &rays_of_eye, &hits, &[CUBE, GROUND]);
    println!("among others: {found:?}");
    found.check();
    assert_ne!(
        among
            .pixels()
            .filter(|pixel| among.class(*pixel) == 9)
            .count(),
        0
    );

    let parallel = "cube.visible = ground.visible = false;
        const from = new THREE.OrthographicCamera(-1.6, 1.6, 1.2, -1.2, 0.1, 10);
        from.position.copy(camera.position);
        from.lookAt(0, 0, 0);
        return from;";
    let parallel = Picture::draw(&page, [200, 150], parallel);
    let all = rays([200, 150], 3.2 / 200.0, true);
    let found = compare(&parallel, &all, &Rays::new(&scene).cast(&all), &[]);
    println!("parallel: {found:?}");
    found.check();

    // Moved, turned and scaled, and the camera with it.
    let moved = "const motion = new THREE.Matrix4().compose(new THREE.Vector3(3, -1, 2),
            new THREE.Quaternion().setFromEuler(new THREE.Euler(0.3, 2, -0.7)), new THREE.Vector3(2, 2, 2));
        const from = camera.clone();
        for (const object of [carved, from]) object.applyMatrix4(motion);
        from.scale.setScalar(1);
        return from;";
    let moved = Picture::draw(&page, SIZE, moved);
    let differs = |pixel: &usize| moved.class(*pixel) != alone.class(*pixel);
    let others = alone.pixels().filter(differs).count();
    println!("moved: {others} other classes");
    assert!(others <= 4, "{others}");
    page.passed();
}

#[test]
fn gpu_three_draws_curved_prisms() {
    let exports = [("torus", "torus.toml"), ("accurate", "torus_accurate.toml")];
    let Some((page, _folder)) = open(&exports, true) else {
        return;
    };
    let scene = from_the_page("torus_accurate.toml");
    let picture = "cube.visible = ground.visible = false;
        scene.remove(carved);
        scene.add(await load('accurate/'));
        return camera;";
    let picture = Picture::draw(&page, SIZE, picture);
    let found = compare(&picture, &page_rays(), &on_cpu(&scene), &[]);
    println!("prisms: {found:?}");
    found.check();
    page.passed();
}

/// How far before a point a ray towards it ends, world units: more than the bias of the shadow map.
const BEFORE: f64 = 0.02;

/// Where pixels of a picture are lit, and where they should be.
#[derive(Debug, Default)]
struct Lit {
    /// Pixels.
    all: usize,
    /// Those in shadow.
    dark: usize,
    /// Those that differ.
    other: usize,
    /// Of these, those more than two pixels from where light and shadow, or objects, meet.
    inside: usize,
}

impl Lit {
    /// `found` and `wanted` are none for pixels that are not asked about.
    fn of(picture: &Picture, found: &[bool], wanted: &[Option<bool>]) -> Lit {
        let mut counts = Lit::default();
        for pixel in picture.pixels() {
            let Some(is_lit) = wanted[pixel] else {
                continue;
            };
            counts.all += 1;
            counts.dark += usize::from(!found[pixel]);
            if found[pixel] != is_lit {
                counts.other += 1;
                counts.inside += usize::from(picture.is_inside(wanted, pixel, 2));
            }
        }
        counts
    }
}

#[test]
fn gpu_three_casts_and_receives_carved_shadows() {
    let Some((page, _folder)) = open(&[("torus", "torus.toml")], false) else {
        return;
    };
    let scene = from_the_page("torus.toml");
    let (tracer, hits) = (Rays::new(&scene), on_cpu(&scene));
    for sun in [DVec3::new(2.0, 4.0, 1.0), DVec3::new(-1.5, 2.0, 2.0)] {
        let [x, y, z] = sun.to_array();
        let with = format!(
            "cube.visible = false; sun.intensity = 3; sun.position.set({x}, {y}, {z}); return camera;"
        );
        let with = Picture::draw(&page, SIZE, &with);
        let without = Picture::draw(&page, SIZE, "sun.intensity = 0; return camera;");
        let is_lit =
            |pixel: usize| (0..3).any(|i| with.first[pixel][i] - without.first[pixel][i] > 1e-3);
        let found: Vec<bool> = with.pixels().map(is_lit).collect();

        let towards = sun.normalize();
        let to_pixel = |pixel| (with.position(pixel) + 10.0 * towards, -towards);
        let rays: Vec<_> = with.pixels().map(to_pixel).collect();
        let blockers = tracer.cast(&rays);
        let is_free = |pixel: usize| blockers[pixel].is_none_or(|hit| hit.t > 10.0 - BEFORE);
        let on_ground = |is_free: &dyn Fn(usize) -> bool| -> Vec<Option<bool>> {
            let wanted = |pixel| (with.class(pixel) == 9).then(|| is_free(pixel));
            with.pixels().map(wanted).collect()
        };
        let ground = Lit::of(&with, &found, &on_ground(&is_free));
        // Twin: the shadow of the mesh without carving.
        let meets = tracer.meet_mesh(&rays);
        let plain = Lit::of(&with, &found, &on_ground(&|pixel| !meets[pixel]));
        let wanted = |pixel: usize| {
            let hit = hits[pixel].filter(|_| with.is_carved(pixel))?;
            Some(hit.normal.dot(towards) > 0.0 && is_free(pixel))
        };
        let wanted: Vec<_> = with.pixels().map(wanted).collect();
        let carved = Lit::of(&with, &found, &wanted);
        println!("sun from {sun}: ground {ground:?}, uncarved {plain:?}, carved {carved:?}");
        assert!(ground.dark > 2000 && carved.dark > 5000);
        assert!(
            ground.inside <= 3 && plain.inside > 10,
            "{ground:?} {plain:?}"
        );
        // Where the fast tier has holes as seen from the light.
        assert!(carved.inside <= 100, "{carved:?}");
    }

    // The page shows the same, in sRGB; where objects meet it has the colours of both.
    let with = "cube.visible = true; sun.intensity = 3; return camera;";
    let with = Picture::draw(&page, SIZE, with);
    let shown = page.run_async("return await probe.show()");
    assert_eq!(problems(&page), "");
    let shown = image::load_from_memory(&base64(shown.as_str().unwrap())).unwrap();
    let shown = shown.into_rgb8();
    assert_eq!([shown.width(), shown.height()], SIZE);
    let classes: Vec<u32> = with.pixels().map(|pixel| with.class(pixel)).collect();
    let (mut compared, mut others) = (0, 0);
    for (pixel, shown) in shown.pixels().enumerate() {
        if !with.is_carved(pixel) || !with.is_inside(&classes, pixel, 1) {
            continue;
        }
        compared += 1;
        others += usize::from((0..3).any(|i| shown.0[i].abs_diff(srgb(with.first[pixel][i])) > 3));
    }
    println!("shown: {others} of {compared} pixels differ by more than 3 of 255");
    assert!(compared > 20_000 && others <= 5, "{others} of {compared}");
    page.passed();
}
