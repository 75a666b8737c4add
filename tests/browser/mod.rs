//! A static server, a headless Chromium, and simulated user input.

mod chromium;

pub use chromium::base64;

use chromium::Chromium;
use serde_json::{Value, json};
use std::cell::RefCell;
use std::ffi::OsStr;
use std::io::{BufRead, BufReader, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

/// Timeout of any step: software drivers on two busy cores.
const PATIENCE: Duration = Duration::from_secs(300);

/// Largest WebAssembly as sent, bytes. Without link-time optimization it is larger than the page,
/// which must stay under 6 MB.
const LARGEST: u64 = 6_500_000;

/// Builds the page, once; none if its tools are missing and not required.
pub fn built() -> Option<PathBuf> {
    static BUILT: OnceLock<Result<PathBuf, String>> = OnceLock::new();
    let built = BUILT.get_or_init(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("page");
        if chromium().is_none() {
            return Err("Chromium is not installed".to_string());
        }
        let done = Command::new(relievo_tests::page_builder())
            .current_dir(relievo_tests::root())
            .arg("-o")
            .arg(&folder)
            // Link-time optimization takes minutes, and changes only the size.
            .env("CARGO_PROFILE_PAGE_LTO", "off")
            .env("CARGO_PROFILE_PAGE_CODEGEN_UNITS", "16")
            .output()
            .map_err(|error| error.to_string())?;
        if !done.status.success() {
            return Err(String::from_utf8_lossy(&done.stderr).into_owned());
        }
        let told = String::from_utf8_lossy(&done.stdout).into_owned();
        println!("{told}");
        // "…: N bytes of WebAssembly, N as a server sends them (gzip)"
        let packed = told
            .split(", ")
            .last()
            .and_then(|part| part.split(' ').next());
        let packed: u64 = packed.and_then(|bytes| bytes.parse().ok()).expect("a size");
        assert!(packed < LARGEST, "{told}");
        Ok(folder)
    });
    match built {
        Ok(folder) => Some(folder.clone()),
        Err(problem) => {
            assert!(
                std::env::var_os("RELIEVO_TOOLS").is_none(),
                "the page was not tested: {problem}"
            );
            eprintln!("WITHOUT A BROWSER: the page was not tested: {problem}");
            None
        }
    }
}

/// Debian's Chromium, or another by that name.
pub fn chromium() -> Option<PathBuf> {
    let folders = std::env::var_os("PATH")?;
    let mut names = std::env::split_paths(&folders).flat_map(|folder| {
        ["chromium", "chromium-browser", "google-chrome"].map(|name| folder.join(name))
    });
    names.find(|path| path.is_file())
}

/// Serves the files of a folder until the tests end.
fn serve(folder: &Path) -> SocketAddr {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port is free");
    let address = listener.local_addr().unwrap();
    let folder = folder.to_path_buf();
    std::thread::spawn(move || {
        for stream in listener.incoming().flatten() {
            let folder = folder.clone();
            std::thread::spawn(move || answer(stream, &folder));
        }
    });
    address
}

fn answer(mut stream: TcpStream, folder: &Path) -> std::io::Result<()> {
    let mut lines = BufReader::new(stream.try_clone()?).lines();
    let request = lines.next().transpose()?.unwrap_or_default();
    for line in lines {
        if line?.is_empty() {
            break;
        }
    }
    let path = request.split(' ').nth(1).unwrap_or("/");
    let name = match path.split('?').next().unwrap_or("").trim_start_matches('/') {
        "" => "index.html",
        name => name,
    };
    let kind = match Path::new(name).extension().and_then(OsStr::to_str) {
        Some("html") => "text/html",
        Some("js") => "text/javascript",
        Some("css") => "text/css",
        Some("wasm") => "application/wasm",
        _ => "application/octet-stream",
    };
    let (status, body) = match std::fs::read(folder.join(name)) {
        Ok(body) => ("200 OK", body),
        Err(_) => ("404 Not Found", Vec::new()),
    };
    write!(
        stream,
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nConnection: close\r\n\r\n",
        body.len()
    )?;
    stream.write_all(&body)
}

/// A browser uses the whole machine: one at a time.
static TURN: Mutex<()> = Mutex::new(());

/// The page in its own browser.
pub struct Page {
    browser: RefCell<Chromium>,
    downloads: tempfile::TempDir,
    has_passed: bool,
    // Last, so that the next may start.
    _turn: MutexGuard<'static, ()>,
}

impl Page {
    /// Opens the page in `folder`, with this query string.
    pub fn open(folder: &Path, query: &str) -> Page {
        // A failed test has left no lock.
        let turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
        let address = serve(folder);
        // A software adapter and compositor: without the last three flags
        // WebGPU output does not reach the page.
        let arguments = [
            "--window-size=1000,1000",
            // On a slow machine the watchdog may end the GPU process: the page then finds no WebGPU.
            "--disable-gpu-watchdog",
            "--enable-unsafe-webgpu",
            "--use-webgpu-adapter=swiftshader",
            "--enable-features=Vulkan",
            "--use-vulkan=swiftshader",
            "--use-angle=vulkan",
            "--disable-vulkan-surface",
        ];
        let program = chromium().expect("Chromium is installed");
        let browser = Chromium::start(&program, &arguments, PATIENCE);
        let page = Page {
            browser: RefCell::new(browser),
            downloads: tempfile::tempdir().unwrap(),
            has_passed: false,
            _turn: turn,
        };
        page.call(
            "Browser.setDownloadBehavior",
            json!({ "behavior": "allow", "downloadPath": page.downloads.path() }),
        );
        let url = format!("http://{address}/{query}");
        page.call("Page.navigate", json!({ "url": url }));
        let is_loaded = "location.href !== 'about:blank' && document.readyState === 'complete'";
        page.wait_for("the page", is_loaded);
        page
    }

    fn call(&self, method: &str, parameters: Value) {
        let done = self.browser.borrow_mut().call(method, parameters);
        done.expect("the browser does it");
    }

    /// Runs JavaScript and returns its value.
    pub fn run(&self, script: &str) -> Value {
        let done = self.browser.borrow_mut().evaluate(script, false);
        done.expect("the script runs")
    }

    /// Runs the body of an asynchronous function and returns its value.
    pub fn run_async(&self, body: &str) -> Value {
        let script = format!("(async () => {{ {body} }})()");
        let done = self.browser.borrow_mut().evaluate(&script, true);
        done.expect("the script runs")
    }

    /// Returns the page's probe.
    pub fn probe(&self) -> Value {
        let told = self
            .run("JSON.stringify({ ...window.relievo?.probe(), error: window.relievo?.error })");
        let told: Value = serde_json::from_str(told.as_str().unwrap_or("{}")).expect("it is JSON");
        assert!(told["error"].is_null(), "{told}");
        told
    }

    /// Waits until the probe is as expected.
    pub fn wait(&self, what: &str, is_so: impl Fn(&Value) -> bool) -> Value {
        let start = Instant::now();
        loop {
            let told = self.probe();
            if is_so(&told) {
                return told;
            }
            assert!(
                start.elapsed() < PATIENCE,
                "waited for {what} in vain: {told}"
            );
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    /// Waits until an expression of the page is true.
    pub fn wait_for(&self, what: &str, expression: &str) {
        let start = Instant::now();
        while self.run(expression) != true {
            assert!(start.elapsed() < PATIENCE, "waited for {what} in vain");
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    /// Waits until the picture is up to date.
    pub fn settle(&self) -> Value {
        // Earlier input must have arrived.
        std::thread::sleep(Duration::from_millis(400));
        self.wait("the picture", |told| {
            told["settled"] == true && told["first_picture_ms"].is_number()
        })
    }

    fn control(&self, label: &str) -> Value {
        let told = self.probe();
        let all = told["controls"].as_array().cloned().unwrap_or_default();
        let found = all.iter().find(|control| control["label"] == label);
        found
            .cloned()
            .unwrap_or_else(|| panic!("no control {label:?} in {told}"))
    }

    /// The value of a control.
    pub fn value(&self, label: &str) -> String {
        self.control(label)["value"]
            .as_str()
            .unwrap_or_default()
            .to_string()
    }

    /// The text of an element.
    pub fn text(&self, id: &str) -> String {
        let text = self.run(&format!("document.getElementById('{id}').textContent"));
        text.as_str().unwrap_or_default().to_string()
    }

    fn at(&self, label: &str, [x, y]: [f64; 2]) -> [f64; 2] {
        let rectangle = &self.control(label)["rectangle"];
        [0, 1].map(|axis| rectangle[axis].as_f64().expect("a number") + [x, y][axis])
    }

    fn mouse(&self, kind: &str, [x, y]: [f64; 2], is_down: bool) {
        self.call(
            "Input.dispatchMouseEvent",
            json!({
                "type": kind,
                "x": x,
                "y": y,
                "button": "left",
                "buttons": i32::from(is_down),
                "clickCount": 1,
            }),
        );
        self.pass();
    }

    /// Waits until the page has processed input: it draws once between two
    /// frames of the browser.
    pub fn pass(&self) {
        self.run_async(
            "await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));",
        );
    }

    /// Drags from one place in a control to another.
    pub fn drag(&self, label: &str, from: [f64; 2], to: [f64; 2]) {
        let (start, end) = (self.at(label, from), self.at(label, to));
        self.mouse("mouseMoved", start, false);
        self.mouse("mousePressed", start, true);
        for step in 1..=4 {
            let part = f64::from(step) / 4.0;
            let place = [0, 1].map(|axis| start[axis] + part * (end[axis] - start[axis]));
            self.mouse("mouseMoved", place, true);
        }
        self.mouse("mouseReleased", end, false);
    }

    /// Clicks on a control.
    pub fn click(&self, label: &str) {
        let place = self.at(label, [10.0, 10.0]);
        self.mouse("mouseMoved", place, false);
        self.mouse("mousePressed", place, true);
        self.mouse("mouseReleased", place, false);
    }

    /// Drops a file on the page.
    pub fn drop_file(&self, name: &str, bytes: &[u8]) {
        let list = bytes
            .iter()
            .map(u8::to_string)
            .collect::<Vec<_>>()
            .join(",");
        self.run(&format!(
            "{{ const transfer = new DataTransfer();
               transfer.items.add(new File([new Uint8Array([{list}])], '{name}'));
               const canvas = [...document.querySelectorAll('canvas')].find((each) => each.offsetParent !== null);
               for (const kind of ['dragover', 'drop'])
                 canvas.dispatchEvent(new DragEvent(kind, {{ dataTransfer: transfer, bubbles: true, cancelable: true }})); }}"
        ));
    }

    /// Returns a downloaded file once it is complete.
    pub fn downloaded(&self, name: &str) -> Vec<u8> {
        let path = self.downloads.path().join(name);
        let start = Instant::now();
        // Chromium reserves the name by an empty file.
        while std::fs::metadata(&path).map_or(0, |file| file.len()) == 0 {
            assert!(
                start.elapsed() < PATIENCE,
                "{name} is not downloaded: {}",
                self.probe()
            );
            std::thread::sleep(Duration::from_millis(50));
        }
        // It gets its name when complete. The next may have the same.
        let bytes = std::fs::read(&path).unwrap();
        std::fs::remove_file(path).unwrap();
        bytes
    }

    fn screen(&self) -> Vec<u8> {
        let taken = self.browser.borrow_mut().screenshot();
        taken.expect("a screenshot")
    }

    /// Screenshot of the left part of the page, where the picture is.
    pub fn look(&self) -> image::RgbImage {
        let screen = image::load_from_memory(&self.screen()).unwrap().into_rgb8();
        image::imageops::crop_imm(&screen, 0, 40, 600, screen.height() - 140).to_image()
    }

    /// Keeps no screenshot, because the test passed.
    pub fn passed(mut self) {
        self.has_passed = true;
    }
}

impl Drop for Page {
    fn drop(&mut self) {
        if !self.has_passed {
            let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
            let path = folder.join(format!("page-{}.png", std::process::id()));
            // Screenshots omit WebGPU, so the probe is kept as well.
            let script = "JSON.stringify(window.relievo?.probe(), null, 1)";
            let browser = self.browser.get_mut();
            if let Ok(Value::String(told)) = browser.evaluate(script, false)
                && std::fs::write(path.with_extension("json"), told).is_ok()
            {
                eprintln!(
                    "what it told is in {}",
                    path.with_extension("json").display()
                );
            }
            if let Ok(png) = browser.screenshot()
                && std::fs::write(&path, png).is_ok()
            {
                eprintln!("a screenshot is in {}", path.display());
            }
        }
    }
}
