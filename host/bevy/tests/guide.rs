//! The program of docs/bevy.md: it is examples/minimal.rs letter for letter, has at most 15 lines,
//! and draws a carved object in its window.

use std::path::{Path, PathBuf};
use std::process::Command;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn program() -> String {
    std::fs::read_to_string(root().join("host/bevy/examples/minimal.rs")).expect("the example")
}

#[test]
fn the_guide_shows_the_example() {
    let guide = std::fs::read_to_string(root().join("docs/bevy.md")).expect("the guide");
    assert!(guide.contains(&format!("```rust\n{}```", program())));
    assert!(program().lines().count() <= 15);
}

/// The first line of a display that nobody uses, and the process that has it.
struct Display(std::process::Child, String);

impl Display {
    /// Opens a display without a screen; `None` where there is no Xvfb.
    fn open() -> Option<Display> {
        let mut process = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "1280x800x24"])
            .stdout(std::process::Stdio::piped())
            .stderr(std::process::Stdio::null())
            .spawn()
            .ok()?;
        let mut number = String::new();
        let output = process.stdout.take()?;
        std::io::BufRead::read_line(&mut std::io::BufReader::new(output), &mut number).ok()?;
        Some(Display(process, format!(":{}", number.trim())))
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        self.0.kill().ok();
        self.0.wait().ok();
    }
}

#[test]
fn the_program_of_the_guide_draws_a_carved_object() {
    let Some(display) = Display::open() else {
        let is_required =
            std::env::var_os("RELIEVO_TOOLS").is_some_and(|value| value == "required");
        assert!(!is_required, "Xvfb is not installed");
        eprintln!("SKIPPED: Xvfb is not installed");
        return;
    };
    let test = std::env::current_exe().expect("a path");
    let program = test
        .parent()
        .and_then(Path::parent)
        .expect("two folders")
        .join("examples/minimal");
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("guide");
    std::fs::remove_dir_all(&folder).ok();
    std::fs::create_dir_all(folder.join("assets")).expect("a folder");
    let pattern = root().join("assets/patterns/bricks.png");
    std::fs::copy(pattern, folder.join("assets/bricks.png")).expect("a file");
    let script = folder.join("script.ron");
    std::fs::write(
        &script,
        "(events: [(150, NamedScreenshot(\"guide\")), (160, AppExit)])",
    )
    .expect("a file");
    let output = Command::new(program)
        .current_dir(&folder)
        .env("BEVY_ASSET_ROOT", &folder)
        .env("CI_TESTING_CONFIG", &script)
        .env("DISPLAY", &display.1)
        // On lavapipe, windows of wgpu 29 have validation messages in every program.
        .env("WGPU_VALIDATION", "0")
        .env_remove("WAYLAND_DISPLAY")
        .output()
        .expect("the example is built");
    let messages =
        String::from_utf8_lossy(&output.stdout) + String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{messages}");
    assert!(!messages.contains("ERROR"), "{messages}");
    let picture = image::open(folder.join("screenshot-guide.png"))
        .expect(&messages)
        .into_rgb8();
    let background = *picture.get_pixel(2, 2);
    let object: Vec<_> = picture
        .pixels()
        .filter(|pixel| **pixel != background)
        .collect();
    let share = object.len() as f64 / (picture.width() * picture.height()) as f64;
    // A ring of bricks: a smooth one would have no dark joints.
    let dark = object
        .iter()
        .filter(|pixel| pixel.0.iter().all(|part| *part < 100))
        .count();
    eprintln!("{share:.2} of the window, {dark} dark pixels");
    let colored = object
        .iter()
        .filter(|pixel| pixel.0[0].abs_diff(pixel.0[2]) > 40)
        .count();
    assert_eq!(colored, 0, "it is white");
    assert!(share > 0.1 && dark > 1000, "{share}, {dark}");
}
