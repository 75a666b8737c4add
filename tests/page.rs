//! The page in a headless Chromium: user input and its results.

use crate::browser::{Page, built};

/// Without WebGPU, and with it on a software adapter.
const CPU: &str = "?cpu";
const GPU: &str = "";

/// A pattern of stripes instead of discs, with this number of pixels along each side.
fn stripes(pixels: u32) -> Vec<u8> {
    let pattern = image::GrayImage::from_fn(pixels, pixels, |x, _| {
        image::Luma([if 3 * x < pixels { 0 } else { 255 }])
    });
    let mut bytes = std::io::Cursor::new(Vec::new());
    pattern
        .write_to(&mut bytes, image::ImageFormat::Png)
        .unwrap();
    bytes.into_inner()
}

/// Fraction of the pixels that differ by more than `limit` of 255 in a channel.
fn difference(a: &image::RgbImage, b: &image::RgbImage, limit: u8) -> f64 {
    assert_eq!(a.dimensions(), b.dimensions());
    let differs = |(a, b): &(&image::Rgb<u8>, &image::Rgb<u8>)| {
        a.0.iter().zip(b.0).any(|(a, b)| a.abs_diff(b) > limit)
    };
    let pixels = f64::from(a.width() * a.height());
    a.pixels().zip(b.pixels()).filter(differs).count() as f64 / pixels
}

/// Renders a scene that the page has saved as an archive, optionally in another
/// size with one sample per pixel.
fn native(archive: &[u8], size: Option<(u32, u32)>) -> image::RgbImage {
    let folder = tempfile::tempdir().unwrap();
    let mut files = zip::ZipArchive::new(std::io::Cursor::new(archive)).unwrap();
    files.extract(folder.path()).unwrap();
    let scene = folder.path().join("torus-view/torus-view.toml");
    let output = folder.path().join("native.png");
    let mut command = std::process::Command::new(relievo_tests::program());
    command.args(["render", "--backend", "cpu", "-o"]);
    command.args([&output, &scene]);
    if let Some((width, height)) = size {
        let text = std::fs::read_to_string(&scene).unwrap();
        let text = text.replace("supersample = true", "supersample = false");
        std::fs::write(&scene, text).unwrap();
        command.args(["--size", &format!("{width}x{height}")]);
    }
    let done = command.output().unwrap();
    assert!(
        done.status.success(),
        "{}",
        String::from_utf8_lossy(&done.stderr)
    );
    image::open(output).unwrap().into_rgb8()
}

/// The canvas's picture, saved by the viewer: headless browsers omit WebGPU
/// from screenshots.
fn shown(page: &Page) -> image::RgbImage {
    page.click("Save what is shown (Ctrl Shift P)");
    let png = page.downloaded("torus-view-shown.png");
    image::load_from_memory(&png).unwrap().into_rgb8()
}

#[test]
fn gpu_the_viewer_in_a_browser() {
    let Some(folder) = built() else { return };
    let page = Page::open(&folder, GPU);
    let first = page.settle();
    println!(
        "{}: first picture after {:.0} ms, frame {:.1} ms",
        first["renderer"], first["first_picture_ms"], first["frame_ms"]
    );
    assert!(
        first["renderer"].as_str().unwrap().contains("portable"),
        "{first}"
    );
    let torus = shown(&page);
    page.drag("Bevel b", [5.0, 10.0], [30.0, 10.0]);
    let beveled = page.settle();
    assert_ne!(page.value("Bevel b"), "0");
    assert_ne!(beveled["scene"], first["scene"]);
    let screen = shown(&page);
    assert!(
        difference(&torus, &screen, 16) > 0.005,
        "the picture has not changed"
    );
    page.click("Save picture (Ctrl P)");
    let saved = page.downloaded("torus-view.png");
    let saved = image::load_from_memory(&saved).unwrap().into_rgb8();
    assert_eq!(saved.dimensions(), (800, 600));

    // The screen and the saved picture, beside the program's pictures of the
    // same scene.
    page.click("Save scene (Ctrl S)");
    let archive = page.downloaded("torus-view.zip");
    let size = screen.dimensions();
    assert!(size.0 > 400 && size.1 > 300, "{size:?}");
    for (what, ours, native) in [
        ("shown", &screen, native(&archive, Some(size))),
        ("saved", &saved, native(&archive, None)),
    ] {
        let [any, visible] = [0, 2].map(|limit| difference(ours, &native, limit));
        println!(
            "{what} picture, {:?}: {:.3} % of the pixels differ from the program's, {:.3} % by more than 2 of 255",
            ours.dimensions(),
            100.0 * any,
            100.0 * visible
        );
        assert!(visible < 0.002, "{what}: {visible}");
    }

    page.passed();
}

#[test]
fn gpu_a_dropped_pattern_and_the_shaders_of_a_browser() {
    let Some(folder) = built() else { return };
    let page = Page::open(&folder, GPU);
    page.settle();
    let torus = shown(&page);
    page.drop_file("stripes.png", &stripes(64));
    page.wait("the stripes", |told| {
        told["scene"].as_str().unwrap().contains("stripes.png")
    });
    page.settle();
    assert!(difference(&torus, &shown(&page), 16) > 0.05, "no stripes");

    page.click("Export shaders");
    let shaders = page.downloaded("torus-view-shaders.zip");
    let shaders = zip::ZipArchive::new(std::io::Cursor::new(shaders)).unwrap();
    for name in ["fragment.wgsl", "fragment.metal", "mesh.glb", "README.md"] {
        let name = format!("torus-view-shaders/{name}");
        assert!(shaders.index_for_name(&name).is_some(), "no {name}");
    }

    page.passed();
}

#[test]
fn gpu_the_page_goes_on_while_a_worker_prepares() {
    let Some(folder) = built() else { return };
    let page = Page::open(&folder, GPU);
    page.settle();
    let torus = shown(&page);
    // How often the page's thread is free meanwhile, every few milliseconds.
    page.run(
        "window.free = 0; setInterval(() => { if (relievo.probe().is_preparing) free += 1; }, 4)",
    );
    // The distances of 16 million pixels take seconds.
    page.drop_file("stripes.png", &stripes(4096));
    page.wait("the stripes", |told| {
        let is_shown = told["scene"].as_str().unwrap().contains("stripes.png");
        is_shown && told["is_preparing"] == false
    });
    let done = page.settle();
    let message = done["message"].as_str().unwrap();
    let free = page.run("free").as_f64().unwrap();
    println!("{message}; free {free} times");
    let took = message.split("prepared in ").nth(1);
    let took = took.and_then(|rest| rest.split(' ').next()).unwrap();
    let took: f64 = took.parse().unwrap();
    // A thread that prepares is free for a frame before and after.
    assert!(32.0 * free >= took, "free {free} times in {took} ms");
    assert!(message.contains("prepared in") && !message.contains("stands still"));
    assert!(difference(&torus, &shown(&page), 16) > 0.05, "no stripes");

    // It analyses as well.
    page.click("Analysis");
    page.pass();
    page.click("Analysis: reduced depth");
    page.wait("an analysis", |told| {
        let message = told["message"].as_str().unwrap();
        message.contains("reduced nowhere") || message.contains("reduced over")
    });
    page.passed();
}

/// Copies the page, but for the program of the worker, which becomes `program`.
fn with_worker(folder: &std::path::Path, program: Option<&str>) -> tempfile::TempDir {
    let copy = tempfile::tempdir().unwrap();
    for file in std::fs::read_dir(folder).unwrap() {
        let file = file.unwrap();
        std::fs::copy(file.path(), copy.path().join(file.file_name())).unwrap();
    }
    let path = copy.path().join("workshop.js");
    match program {
        Some(program) => std::fs::write(path, program).unwrap(),
        None => std::fs::remove_file(path).unwrap(),
    }
    copy
}

#[test]
fn gpu_the_page_goes_on_without_its_worker() {
    let Some(folder) = built() else { return };
    let without = with_worker(&folder, None);
    let page = Page::open(without.path(), GPU);
    page.wait("a message", |told| {
        let message = told["message"].as_str().unwrap_or_default();
        ["prepared in", "stands still", "cannot be loaded"]
            .iter()
            .all(|part| message.contains(part))
    });
    page.passed();

    // One whose second order is too much for it; the first message is its module.
    let program = std::fs::read_to_string(folder.join("workshop.js")).unwrap();
    let program = format!(
        "{program}
        const answers = onmessage;
        let messages = 0;
        onmessage = (event) => {{
            if (messages++ === 2) throw new Error('no memory left');
            answers(event);
        }};"
    );
    let short = with_worker(&folder, Some(&program));
    let page = Page::open(short.path(), GPU);
    page.settle();
    let torus = shown(&page);
    page.drop_file("stripes.png", &stripes(64));
    let told = page.wait("a message", |told| {
        told["message"].as_str().unwrap().contains("has stopped")
    });
    let message = told["message"].as_str().unwrap();
    for part in ["no memory left", "the next change starts another worker"] {
        assert!(message.contains(part), "{message}");
    }
    page.click("Perforated metal");
    page.wait("another worker", |told| {
        told["message"].as_str().unwrap().contains("prepared in")
    });
    page.settle();
    assert!(difference(&torus, &shown(&page), 16) > 0.05, "no metal");
    page.passed();
}

#[test]
fn gpu_a_link_shows_the_scene_again() {
    let Some(folder) = built() else { return };
    let page = Page::open(&folder, GPU);
    let torus = page.settle()["scene"].clone();
    page.click("Perforated metal");
    page.drop_file("stripes.png", &stripes(64));
    page.wait("the stripes", |told| {
        told["scene"].as_str().unwrap().contains("stripes.png")
    });
    let scene = page.settle()["scene"].clone();
    page.click("Copy link");
    page.wait("a link", |told| {
        told["message"].as_str().unwrap().contains("Copied a link")
    });
    let fragment = page.run("location.hash").as_str().unwrap().to_string();
    println!("a link of {} characters", fragment.len());
    page.passed();

    let page = Page::open(&folder, &fragment);
    assert_eq!(page.settle()["scene"], scene);
    page.passed();

    let page = Page::open(&folder, &fragment[..fragment.len() / 2]);
    assert_eq!(page.settle()["scene"], torus);
    let notice = page.text("notice");
    assert!(notice.contains("copy the whole link again"), "{notice}");
    page.passed();

    let page = Page::open(&folder, &format!("{CPU}{fragment}"));
    page.settle();
    assert_eq!(
        page.run("document.querySelector('[name=cut-out]').checked"),
        true
    );
    page.run("history.replaceState(null, '', '#')");
    page.run("document.getElementById('copy-link').click()");
    page.wait_for("a link", "location.hash.length > 1");
    assert_eq!(page.run("location.hash"), fragment);
    page.passed();
}

#[test]
fn without_webgpu_a_worker_draws() {
    let Some(folder) = built() else { return };
    let page = Page::open(&folder, CPU);
    let first = page.settle();
    println!(
        "first picture by the CPU after {:.0} ms",
        first["first_picture_ms"]
    );
    assert!(page.text("notice").contains("no WebGPU"));
    let torus = page.look();
    // Each control draws another picture: first coarse, then fine.
    let look_after = |what: &str, act: &dyn Fn()| {
        let frames = page.probe()["frames"].as_u64();
        act();
        page.wait(what, |told| {
            told["settled"] == true && told["frames"].as_u64() > frames
        });
        page.look()
    };
    let set = |id: &str, value: &str, event: &str| {
        page.run(&format!(
            "{{ const control = document.querySelector('{id}'); control.value = '{value}';
               control.dispatchEvent(new Event('{event}', {{ bubbles: true }})); }}"
        ));
    };
    let mut before = torus;
    let mut changed = |what: &str, least: f64, act: &dyn Fn()| {
        let after = look_after(what, act);
        let share = difference(&before, &after, 16);
        assert!(share > least, "{what}: {share}");
        before = after;
    };
    changed("a bevel", 0.005, &|| set("[name=bevel]", "0.15", "input"));
    changed("stripes", 0.05, &|| {
        page.drop_file("stripes.png", &stripes(64));
    });
    changed("letters", 0.05, &|| set("#letters", "Relievo", "input"));
    changed("classes", 0.05, &|| {
        set("#show", "Surface class", "change");
    });
    // An unreadable file is reported, and the next change works.
    page.drop_file("broken.png", b"no picture");
    page.wait("a complaint", |told| {
        told["message"].as_str().unwrap().contains("broken.png")
    });
    assert!(page.text("notice").contains("broken.png"));
    changed("letters again", 0.05, &|| {
        set("#letters", "ABC", "input");
    });
    page.run("document.getElementById('save-picture').click()");
    let png = page.downloaded("relievo.png");
    assert_eq!(
        image::load_from_memory(&png)
            .unwrap()
            .into_rgb8()
            .dimensions(),
        (640, 480)
    );
    page.passed();
}
