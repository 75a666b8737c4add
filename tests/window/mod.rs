//! A virtual display (Xvfb), the viewer, and simulated user input.

use image::RgbImage;
use relievo_viewer::probe::Probe as Told;
use std::io::{BufRead, BufReader};
use std::ops::Deref;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use x11rb::connection::Connection;
use x11rb::protocol::xproto::{self, ConnectionExt as _, ImageFormat};
use x11rb::protocol::xtest::ConnectionExt as _;
use x11rb::rust_connection::RustConnection;

/// Timeout of any step: debug builds on two busy cores.
const PATIENCE: Duration = Duration::from_secs(90);

/// A running Xvfb.
pub struct Display {
    server: Child,
    name: String,
}

impl Display {
    /// Starts one; none if it is not installed and not required.
    pub fn open() -> Option<Display> {
        let started = Command::new("Xvfb")
            .args([
                "-displayfd",
                "1",
                "-screen",
                "0",
                "1280x800x24",
                "-nolisten",
                "tcp",
            ])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn();
        let mut server = match started {
            Ok(server) => server,
            Err(error) => {
                assert!(
                    std::env::var_os("RELIEVO_TOOLS").is_none(),
                    "Xvfb cannot be started: {error}"
                );
                eprintln!("WITHOUT XVFB: the viewer was not tested ({error})");
                return None;
            }
        };
        let mut number = String::new();
        let output = server.stdout.take().expect("it is piped");
        BufReader::new(output).read_line(&mut number).unwrap();
        Some(Display {
            server,
            name: format!(":{}", number.trim()),
        })
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

/// The viewer's probe.
pub struct Probe(Told);

impl Deref for Probe {
    type Target = Told;

    fn deref(&self) -> &Told {
        &self.0
    }
}

impl Probe {
    fn rectangle(&self, label: &str) -> [f32; 4] {
        let control = self.controls.iter().find(|control| control.label == label);
        let labels = || self.controls.iter().map(|control| control.label.as_str());
        match control {
            Some(control) => control.rectangle,
            None => panic!(
                "no control {label:?} among {:?}",
                labels().collect::<Vec<_>>()
            ),
        }
    }

    /// The value of a control.
    pub fn value(&self, label: &str) -> &str {
        let control = self.controls.iter().find(|control| control.label == label);
        control.map_or("", |control| control.value.as_str())
    }

    /// The value of a control that has a number.
    pub fn number(&self, label: &str) -> f64 {
        self.value(label).parse().unwrap_or(f64::NAN)
    }
}

/// Pixels of a part of the screen.
pub struct Look {
    /// Red, green and blue, rows from the top.
    pub pixels: RgbImage,
}

impl Look {
    /// The mean of all channels, 0…255.
    pub fn brightness(&self) -> f64 {
        let bytes = self.pixels.as_raw();
        bytes.iter().map(|&byte| f64::from(byte)).sum::<f64>() / bytes.len() as f64
    }

    /// Number of distinct colours.
    pub fn colors(&self) -> usize {
        let all: std::collections::BTreeSet<_> =
            self.pixels.pixels().map(|pixel| pixel.0).collect();
        all.len()
    }
}

/// The viewer's window.
pub struct Window {
    program: Child,
    connection: RustConnection,
    root: xproto::Window,
    /// The window's upper left corner on the screen.
    origin: [f32; 2],
    probe: PathBuf,
    has_passed: bool,
}

impl Window {
    /// Opens the viewer on a scene, and waits until its window is there.
    pub fn open(display: &Display, scene: &Path, folder: &Path) -> Window {
        let probe = folder.join("probe.json");
        let program = Command::new(relievo_tests::program())
            .arg("view")
            .arg(scene)
            .args(["--window", "1000x700", "-o"])
            .arg(folder)
            .arg("--probe")
            .arg(&probe)
            .env("DISPLAY", &display.name)
            .env_remove("WAYLAND_DISPLAY")
            .env("WGPU_VALIDATION", "0")
            .spawn()
            .expect("the viewer starts");
        let (connection, screen) =
            x11rb::connect(Some(&display.name)).expect("the display answers");
        let root = connection.setup().roots[screen].root;
        let mut window = Window {
            program,
            connection,
            root,
            origin: [0.0; 2],
            probe,
            has_passed: false,
        };
        let found = window.wait("a window", |window| window.find());
        let place = window
            .connection
            .translate_coordinates(found, root, 0, 0)
            .unwrap()
            .reply()
            .unwrap();
        window.origin = [f32::from(place.dst_x), f32::from(place.dst_y)];
        // There is no window manager to focus windows.
        window
            .connection
            .set_input_focus(xproto::InputFocus::PARENT, found, x11rb::CURRENT_TIME)
            .unwrap();
        window.connection.flush().unwrap();
        window
    }

    /// Returns the window once it is mapped with a visible size.
    fn find(&self) -> Option<xproto::Window> {
        let tree = self.connection.query_tree(self.root).ok()?.reply().ok()?;
        tree.children.into_iter().find(|&child| {
            let mapped = self
                .connection
                .get_window_attributes(child)
                .ok()
                .and_then(|cookie| cookie.reply().ok())
                .is_some_and(|attributes| attributes.map_state == xproto::MapState::VIEWABLE);
            let wide = self
                .connection
                .get_geometry(child)
                .ok()
                .and_then(|cookie| cookie.reply().ok())
                .is_some_and(|geometry| geometry.width > 400);
            mapped && wide
        })
    }

    /// Waits until `ask` returns a value.
    fn wait<T>(&mut self, what: &str, mut ask: impl FnMut(&mut Window) -> Option<T>) -> T {
        let start = Instant::now();
        loop {
            if let Some(answer) = ask(self) {
                return answer;
            }
            if let Some(status) = self.program.try_wait().unwrap() {
                panic!("the viewer has ended ({status}) before {what}");
            }
            assert!(start.elapsed() < PATIENCE, "waited for {what} in vain");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    fn read(&self) -> Option<Probe> {
        let bytes = std::fs::read(&self.probe).ok()?;
        Some(Probe(
            serde_json::from_slice(&bytes).expect("it is written whole"),
        ))
    }

    /// Returns the viewer's last probe.
    pub fn probe(&self) -> Probe {
        self.read().expect("it has told something")
    }

    /// Waits until the probe is as expected.
    pub fn expect(&mut self, is_so: impl Fn(&Probe) -> bool) -> Probe {
        self.wait("what was expected", |window| window.read().filter(&is_so))
    }

    /// Waits until the screen is as expected. The probe tells of a frame before the
    /// screen shows it.
    pub fn until(&mut self, what: &str, is_so: impl Fn(&Window) -> bool) {
        self.wait(what, |window| is_so(window).then_some(()));
    }

    /// Waits until the picture is up to date.
    pub fn settle(&mut self) -> Probe {
        // Earlier input must have arrived.
        std::thread::sleep(Duration::from_millis(400));
        self.expect(|probe| probe.settled && probe.frame_ms > 0.0)
    }

    fn at(&self, label: &str, [x, y]: [f32; 2]) -> [i16; 2] {
        let [left, top, ..] = self.probe().rectangle(label);
        let [origin_x, origin_y] = self.origin;
        [(origin_x + left + x) as i16, (origin_y + top + y) as i16]
    }

    fn input(&self, kind: u8, detail: u8, [x, y]: [i16; 2]) {
        self.connection
            .xtest_fake_input(kind, detail, 0, self.root, x, y, 0)
            .unwrap();
        self.connection.flush().unwrap();
        std::thread::sleep(Duration::from_millis(40));
    }

    /// Moves the pointer, and waits until the viewer has drawn it there.
    ///
    /// Press, motion and release that fall into one frame are not a drag.
    fn move_to(&mut self, place: [i16; 2]) {
        self.input(xproto::MOTION_NOTIFY_EVENT, 0, place);
        let [x, y] = self.origin;
        let told = Some([f32::from(place[0]) - x, f32::from(place[1]) - y]);
        self.expect(|probe| probe.pointer == told);
    }

    /// Presses or releases the button, and waits until the viewer has seen it.
    fn button(&mut self, is_down: bool) {
        let kind = if is_down {
            xproto::BUTTON_PRESS_EVENT
        } else {
            xproto::BUTTON_RELEASE_EVENT
        };
        self.input(kind, 1, [0; 2]);
        self.expect(|probe| probe.is_pressed == is_down);
    }

    /// Drags from one place in a control to another.
    pub fn drag(&mut self, label: &str, from: [f32; 2], to: [f32; 2]) {
        let (start, end) = (self.at(label, from), self.at(label, to));
        self.move_to(start);
        self.button(true);
        for step in 1..=4 {
            let part = |a: i16, b: i16| a + (b - a) * step / 4;
            self.move_to([part(start[0], end[0]), part(start[1], end[1])]);
        }
        self.button(false);
    }

    /// Orbits the picture by many small drags; returns how long they took.
    pub fn turn(&mut self, label: &str, pulls: i16, pause: Duration) -> Duration {
        let [x, y] = self.at(label, [200.0, 200.0]);
        self.move_to([x, y]);
        self.button(true);
        let start = Instant::now();
        for pull in 1..=pulls {
            self.input(xproto::MOTION_NOTIFY_EVENT, 0, [x + 3 * pull, y]);
            std::thread::sleep(pause);
        }
        let took = start.elapsed();
        self.button(false);
        took
    }

    /// Clicks on a control.
    pub fn click(&mut self, label: &str) {
        let place = self.at(label, [10.0, 10.0]);
        self.move_to(place);
        self.button(true);
        self.button(false);
        std::thread::sleep(Duration::from_millis(200));
    }

    /// Chooses an item of a list.
    pub fn choose(&mut self, label: &str, value: &str) {
        self.click(label);
        let item = format!("{label}: {value}");
        self.expect(|probe| probe.controls.iter().any(|control| control.label == item));
        // The list opens on pointer motion.
        std::thread::sleep(Duration::from_millis(300));
        self.click(&item);
    }

    /// Presses a key, such as `Right` or `Control+s`.
    pub fn key(&self, keys: &str) {
        let codes: Vec<u8> = keys.split('+').map(|key| self.code(key)).collect();
        for &code in &codes {
            self.input(xproto::KEY_PRESS_EVENT, code, [0; 2]);
        }
        for &code in codes.iter().rev() {
            self.input(xproto::KEY_RELEASE_EVENT, code, [0; 2]);
        }
    }

    /// Returns the code of a key on this display's keyboard.
    fn code(&self, key: &str) -> u8 {
        let symbol: u32 = match key {
            "Right" => 0xff53,
            "Left" => 0xff51,
            "Control" => 0xffe3,
            "Shift" => 0xffe1,
            "Tab" => 0xff09,
            letter => letter.bytes().next().map(u32::from).expect("a letter"),
        };
        let setup = self.connection.setup();
        let (first, last) = (setup.min_keycode, setup.max_keycode);
        let map = self
            .connection
            .get_keyboard_mapping(first, last - first + 1)
            .unwrap()
            .reply()
            .unwrap();
        let columns = usize::from(map.keysyms_per_keycode);
        let rows = map
            .keysyms
            .chunks(columns)
            .position(|row| row.contains(&symbol));
        first + rows.expect("the keyboard has that key") as u8
    }

    /// Captures the screen where a control is.
    pub fn look(&self, label: &str) -> Look {
        let [left, top, right, bottom] = self.probe().rectangle(label);
        let [x, y] = self.at(label, [0.0; 2]);
        let size = [(right - left) as u16, (bottom - top) as u16];
        Look {
            pixels: self.screen([x, y], size),
        }
    }

    fn screen(&self, [x, y]: [i16; 2], [width, height]: [u16; 2]) -> RgbImage {
        let image = self
            .connection
            .get_image(ImageFormat::Z_PIXMAP, self.root, x, y, width, height, !0)
            .unwrap()
            .reply()
            .unwrap();
        // Blue, green, red, and an unused byte.
        let bytes = image
            .data
            .chunks_exact(4)
            .flat_map(|pixel| [pixel[2], pixel[1], pixel[0]]);
        RgbImage::from_raw(width.into(), height.into(), bytes.collect()).expect("24 bits a pixel")
    }

    /// Keeps no screenshot, because the test passed.
    pub fn passed(mut self) {
        self.has_passed = true;
    }
}

impl Drop for Window {
    fn drop(&mut self) {
        if !self.has_passed {
            let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
            let path = folder.join(format!("viewer-{}.png", self.program.id()));
            if self.screen([0; 2], [1280, 800]).save(&path).is_ok() {
                eprintln!("a screenshot is in {}", path.display());
            }
        }
        let _ = self.program.kill();
        let _ = self.program.wait();
    }
}
