//! The viewer on a virtual display: mouse and keyboard input, and its results.

use crate::window::{Display, Window};
use relievo_tests::{asset, program};
use std::path::Path;
use std::process::Command;
use std::time::Duration;

/// Renders a saved scene.
fn rendered(scene: &Path) -> image::RgbImage {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("rendered.png");
    let done = Command::new(program())
        .args(["render", "--allow-outside", "--backend", "gpu", "-o"])
        .args([&output, scene])
        .output()
        .unwrap();
    assert!(
        done.status.success(),
        "{}",
        String::from_utf8_lossy(&done.stderr)
    );
    image::open(output).unwrap().into_rgb8()
}

#[test]
fn gpu_a_slider_moves_and_the_saved_picture_is_what_render_makes_of_the_saved_scene() {
    let Some(display) = Display::open() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let mut window = Window::open(&display, &asset("scenes/torus.toml"), folder.path());
    let first = window.settle();
    println!("first picture after {:?} ms", first.first_picture_ms);
    assert_eq!(first.value("Bevel b"), "0");
    let before = window.look("Picture");
    assert!(before.colors() > 100, "{} colours", before.colors());

    // A drag along the slider, then keys: it has the focus.
    window.drag("Bevel b", [5.0, 10.0], [30.0, 10.0]);
    let dragged = window.settle().number("Bevel b");
    assert!(dragged > 0.05, "{dragged}");
    window.key("Right");
    let nudged = window.settle().number("Bevel b");
    assert!(
        nudged > dragged && nudged < dragged + 0.05,
        "{dragged} {nudged}"
    );
    window.until("another picture", |window| {
        window.look("Picture").pixels != before.pixels
    });

    // The camera: a drag on the picture, and the wheel.
    let scene_before = window.probe().scene.clone();
    window.drag("Picture", [300.0, 200.0], [360.0, 170.0]);
    let probe = window.settle();
    assert_ne!(probe.scene, scene_before);

    window.key("Control+s");
    window.expect(|probe| probe.message.contains("torus-view.toml"));
    window.key("Control+p");
    window.expect(|probe| probe.message.contains("torus-view.png"));
    let saved = image::open(folder.path().join("torus-view.png"))
        .unwrap()
        .into_rgb8();
    let text = std::fs::read_to_string(folder.path().join("torus-view.toml")).unwrap();
    assert_eq!(text, window.probe().scene);
    assert!(text.contains("bevel"), "{text}");
    let again = rendered(&folder.path().join("torus-view.toml"));
    assert_eq!(saved.dimensions(), (800, 600));
    let differing = saved
        .pixels()
        .zip(again.pixels())
        .filter(|(a, b)| a != b)
        .count();
    assert_eq!(differing, 0, "pixels differ from what render makes");
    window.passed();
}

#[test]
fn gpu_presets_patterns_and_files_are_steps_that_can_be_undone() {
    let Some(display) = Display::open() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let mut window = Window::open(&display, &asset("scenes/torus.toml"), folder.path());
    let first = window.settle();
    assert_eq!(first.value("Undo (Ctrl Z)"), "disabled");
    let torus = window.look("Picture").pixels;
    window.click("Bricks");
    let bricks = window.settle().scene.clone();
    assert!(bricks.contains("svg = "), "{bricks}");
    window.until("bricks", |window| window.look("Picture").pixels != torus);
    // A drag is one step.
    window.drag("Depth", [30.0, 10.0], [60.0, 10.0]);
    let deep = window.settle().scene.clone();
    assert_ne!(deep, bricks);
    window.key("Control+z");
    window.expect(|probe| probe.scene == bricks);
    window.click("Undo (Ctrl Z)");
    window.expect(|probe| probe.scene == first.scene && probe.value("Undo (Ctrl Z)") == "disabled");
    window.settle();
    window.until("the torus", |window| window.look("Picture").pixels == torus);
    window.key("Control+Shift+z");
    window.expect(|probe| probe.scene == bricks);
    window.click("Redo (Ctrl Shift Z)");
    window.expect(|probe| probe.scene == deep && probe.value("Redo (Ctrl Shift Z)") == "disabled");

    // Without a file of the pattern, a saved scene draws the same.
    window.settle();
    window.key("Control+s");
    window.expect(|probe| probe.message.contains("torus-view.toml"));
    window.key("Control+p");
    window.expect(|probe| probe.message.contains("torus-view.png"));
    let saved = image::open(folder.path().join("torus-view.png")).unwrap();
    let again = rendered(&folder.path().join("torus-view.toml"));
    assert!(saved.into_rgb8() == again, "render draws something else");

    // A pattern beside the first one, by its picture.
    window.click("Patterns");
    let label = "Pattern: hexagons.png";
    window.expect(|probe| {
        let mut controls = probe.controls.iter();
        controls.any(|control| control.label == label && control.value.is_empty())
    });
    window.click(label);
    window.expect(|probe| probe.scene.contains("hexagons.png") && probe.value(label) == "chosen");
    window.settle();
    window.key("Control+z");
    window.expect(|probe| probe.scene == deep);

    // From the list of files: a pattern, and another scene.
    window.key("Control+o");
    for name in ["..", "patterns/", "panes.png"] {
        let label = format!("Open: {name}");
        window.expect(|probe| probe.controls.iter().any(|control| control.label == label));
        window.click(&label);
    }
    window.expect(|probe| probe.scene.contains("panes.png"));
    window.click("Open…");
    let label = "Open: blob.toml";
    window.expect(|probe| probe.controls.iter().any(|control| control.label == label));
    window.click(label);
    window.expect(|probe| probe.scene.contains("blob.obj"));
    window.settle();
    window.key("Control+z");
    window.expect(|probe| probe.scene.contains("panes.png"));
    window.passed();
}

#[test]
fn gpu_ten_frames_a_second_while_it_moves() {
    let Some(display) = Display::open() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let mut window = Window::open(&display, &asset("scenes/torus.toml"), folder.path());
    let rest = window.settle();
    let frames = rest.frames;
    // Small drags, one after the other, for as long as a user would.
    let took = window.turn("Picture", 40, Duration::from_millis(25));
    let drawn = window.probe().frames - frames;
    let rate = drawn as f64 / took.as_secs_f64();
    println!(
        "{drawn} frames in {:.2} s: {rate:.1} a second, {:?} pixels of {:?}",
        took.as_secs_f64(),
        window.probe().frame_size,
        rest.frame_size
    );
    // The rate depends on the machine; that pictures follow does not.
    assert!(drawn > 5, "{drawn}");
    let settled = window.settle();
    assert_eq!(
        settled.frame_size, rest.frame_size,
        "at rest all pixels are drawn"
    );
    window.passed();
}

#[test]
fn gpu_everything_can_be_reached_and_shown() {
    let Some(display) = Display::open() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let mut window = Window::open(&display, &asset("scenes/torus.toml"), folder.path());
    window.settle();
    let picture = window.look("Picture");
    for show in [
        "Surface class",
        "Normal",
        "Distance",
        "Texture coordinates",
        "Depth",
        "Steps",
    ] {
        window.choose("Show", show);
        window.expect(|probe| probe.value("Show") == show);
        window.settle();
        window.until(show, |window| {
            window.look("Picture").pixels != picture.pixels
        });
    }
    // The saved picture equals the screen, pixel by pixel.
    window.click("Wireframe");
    window.settle();
    window.key("Control+Shift+p");
    window.expect(|probe| probe.message.contains("torus-view-shown.png"));
    let shown = image::open(folder.path().join("torus-view-shown.png")).unwrap();
    let shown = shown.into_rgb8();
    window.until("the saved picture", |window| {
        window.look("Picture").pixels == shown
    });
    window.choose("Show", "Picture");
    window.settle();
    window.until("the wireframe", |window| {
        window.look("Picture").pixels != picture.pixels
    });
    window.click("Wireframe");

    window.choose("Compare with", "planar");
    window.expect(|probe| {
        probe
            .controls
            .iter()
            .any(|control| control.label == "Split")
    });
    window.settle();
    let half = window.probe().number("Split");
    window.drag("Split", [6.0, 100.0], [86.0, 100.0]);
    window.expect(|probe| probe.number("Split") > half + 0.05);
    window.choose("Compare with", "nothing");

    // The panels become light; the picture does not change.
    window.settle();
    let panel = |window: &Window| window.look("Shadows on itself").brightness();
    window.choose("Theme", "dark");
    window.until("dark panels", |window| panel(window) < 128.0);
    let dark = panel(&window);
    window.choose("Theme", "light");
    window.until("light panels", |window| panel(window) > dark + 60.0);

    window.settle();
    window.choose("Analysis", "error against the oracle");
    window.expect(|probe| probe.message.contains("interior holes"));
    window.choose("Analysis", "reduced depth");
    window.expect(|probe| probe.message.contains("reduced nowhere"));
    window.passed();
}
