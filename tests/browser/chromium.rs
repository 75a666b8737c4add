//! A headless Chromium, told what to do by the Chrome DevTools Protocol
//! (<https://chromedevtools.github.io/devtools-protocol>).

use data_url::forgiving_base64::decode_to_vec;
use serde_json::{Value, json};
use std::io::{BufRead, BufReader};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;
use tungstenite::{Message, WebSocket};

/// Arguments of every browser: nothing but the page, without delays and questions.
const ARGUMENTS: [&str; 14] = [
    "--headless",
    "--no-sandbox",
    "--remote-debugging-port=0",
    "--disable-background-networking",
    "--disable-background-timer-throttling",
    "--disable-backgrounding-occluded-windows",
    "--disable-component-extensions-with-background-pages",
    "--disable-dev-shm-usage",
    "--disable-extensions",
    "--disable-hang-monitor",
    "--disable-ipc-flooding-protection",
    "--disable-renderer-backgrounding",
    "--force-color-profile=srgb",
    "--no-first-run",
];

/// A browser with one tab. It is closed when this is dropped.
pub struct Chromium {
    process: Child,
    socket: WebSocket<TcpStream>,
    session: Value,
    calls: u64,
    // Removed after the process has ended.
    _profile: tempfile::TempDir,
}

impl Chromium {
    /// Starts `program` with further `arguments`. A call that is not answered within `patience`
    /// fails.
    pub fn start(program: &Path, arguments: &[&str], patience: Duration) -> Chromium {
        let profile = tempfile::tempdir().unwrap();
        let mut process = Command::new(program)
            .args(ARGUMENTS)
            .arg(format!("--user-data-dir={}", profile.path().display()))
            .args(arguments)
            .arg("about:blank")
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("Chromium starts");
        let mut lines = BufReader::new(process.stderr.take().unwrap()).lines();
        let address = lines.by_ref().map_while(Result::ok).find_map(|line| {
            let address = line.strip_prefix("DevTools listening on ")?;
            Some(address.to_string())
        });
        // It must be able to go on writing.
        std::thread::spawn(move || lines.for_each(drop));
        let address = address.expect("Chromium says where it listens");
        let host = address.trim_start_matches("ws://").split('/').next();
        let stream = TcpStream::connect(host.unwrap()).expect("Chromium listens");
        stream.set_read_timeout(Some(patience)).unwrap();
        let config = tungstenite::protocol::WebSocketConfig::default()
            .max_message_size(None)
            .max_frame_size(None);
        let (socket, _) = tungstenite::client::client_with_config(&address, stream, Some(config))
            .expect("Chromium answers");
        let mut browser = Chromium {
            process,
            socket,
            session: Value::Null,
            calls: 0,
            _profile: profile,
        };
        // Answered once the process for the GPU runs: a page that is faster finds no WebGPU.
        browser.call("SystemInfo.getInfo", json!({})).unwrap();
        let targets = browser.call("Target.getTargets", json!({})).unwrap();
        let targets = targets["targetInfos"].as_array().unwrap();
        let tab = targets.iter().find(|target| target["type"] == "page");
        let tab = &tab.expect("it has a tab")["targetId"];
        let attached = browser
            .call(
                "Target.attachToTarget",
                json!({ "targetId": tab, "flatten": true }),
            )
            .unwrap();
        browser.session = attached["sessionId"].clone();
        browser
    }

    /// Calls a method, for the tab, and returns its result.
    ///
    /// # Errors
    /// The browser reports an error, or does not answer.
    pub fn call(&mut self, method: &str, parameters: Value) -> Result<Value, String> {
        self.calls += 1;
        let mut call = json!({ "id": self.calls, "method": method, "params": parameters });
        if !self.session.is_null() {
            call["sessionId"] = self.session.clone();
        }
        let failed = |error: tungstenite::Error| format!("{method}: {error}");
        let message = Message::text(call.to_string());
        self.socket.send(message).map_err(failed)?;
        loop {
            let Message::Text(text) = self.socket.read().map_err(failed)? else {
                continue;
            };
            let mut answer: Value = serde_json::from_str(&text).unwrap();
            // Others are events.
            if answer["id"] == self.calls {
                return match answer["error"].is_null() {
                    true => Ok(answer["result"].take()),
                    false => Err(format!("{method}: {}", answer["error"])),
                };
            }
        }
    }

    /// Runs JavaScript and returns its value, that of the promise if it `waits` for one.
    ///
    /// # Errors
    /// As [`Chromium::call`]; or the script throws.
    pub fn evaluate(&mut self, script: &str, waits: bool) -> Result<Value, String> {
        let mut done = self.call(
            "Runtime.evaluate",
            json!({ "expression": script, "awaitPromise": waits, "returnByValue": true }),
        )?;
        match done["exceptionDetails"].is_null() {
            true => Ok(done["result"]["value"].take()),
            false => Err(done["exceptionDetails"].to_string()),
        }
    }

    /// Returns a picture of the tab, PNG.
    ///
    /// # Errors
    /// As [`Chromium::call`].
    pub fn screenshot(&mut self) -> Result<Vec<u8>, String> {
        let taken = self.call("Page.captureScreenshot", json!({ "format": "png" }))?;
        Ok(base64(taken["data"].as_str().unwrap_or_default()))
    }
}

/// Decodes base64.
pub fn base64(text: &str) -> Vec<u8> {
    decode_to_vec(text.as_bytes()).expect("it is base64")
}

impl Drop for Chromium {
    fn drop(&mut self) {
        // Its other processes end with it, and no longer write to the folder.
        self.session = Value::Null;
        let stream = self.socket.get_ref();
        let _ = stream.set_read_timeout(Some(Duration::from_secs(10)));
        if self.call("Browser.close", json!({})).is_err() {
            let _ = self.process.kill();
        }
        let _ = self.process.wait();
    }
}
