//! Compiles in processes of their own, since Mesa reads the generation of GPUs from the
//! environment.

use relievo_compiled::{Driver, Executable, Generation, Shader, Stage, Texts};
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

/// Environment variable with the file that says what to compile.
const REQUEST: &str = "RELIEVO_COMPILE";

/// Files that are compiled together.
pub struct Job {
    /// A name, for messages.
    pub name: String,
    /// The modules: a compute shader, or a vertex and a fragment shader.
    pub files: Vec<PathBuf>,
    /// Whether the assembly is wanted.
    pub texts: Texts,
}

/// What a driver made of every job.
pub struct Answer {
    /// The driver's version.
    pub driver: String,
    /// The stages of each job.
    pub made: Vec<Vec<Executable>>,
}

/// A process that compiles.
pub struct Process {
    child: Child,
    folder: tempfile::TempDir,
}

impl Process {
    /// Starts to compile `jobs` for a generation, with the driver of `manifest`.
    pub fn start(generation: &Generation, manifest: &Path, jobs: &[&Job]) -> Process {
        let folder = tempfile::tempdir().unwrap();
        let jobs = jobs.iter().map(|job| {
            json!({
                "name": job.name,
                "files": job.files,
                "texts": job.texts == Texts::All,
            })
        });
        let request = folder.path().join("request.json");
        fs::write(&request, Value::from_iter(jobs).to_string()).unwrap();
        let child = Command::new(std::env::current_exe().unwrap())
            .args(["registers::process::compiles", "--exact", "--ignored"])
            .envs(generation.environment(manifest))
            .env(REQUEST, &request)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        Process { child, folder }
    }

    /// Waits for the answer.
    pub fn finish(self) -> Answer {
        let output = self.child.wait_with_output().unwrap();
        let said = String::from_utf8_lossy(&output.stdout);
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{said}\n{error}");
        let text = fs::read_to_string(self.folder.path().join("answer.json")).unwrap();
        let answer: Value = serde_json::from_str(&text).unwrap();
        let stages = |job: &Value| job.as_array().unwrap().iter().map(executable).collect();
        Answer {
            driver: answer["driver"].as_str().unwrap().to_string(),
            made: answer["made"]
                .as_array()
                .unwrap()
                .iter()
                .map(stages)
                .collect(),
        }
    }
}

/// Reads what [`written`] wrote.
fn executable(value: &Value) -> Executable {
    let statistics = value["statistics"].as_object().unwrap();
    let assembly = value["assembly"].as_str();
    Executable {
        stage: match value["stage"].as_str().unwrap() {
            "Vertex" => Stage::Vertex,
            "Fragment" => Stage::Fragment,
            _ => Stage::Compute,
        },
        statistics: statistics
            .iter()
            .map(|(name, value)| (name.clone(), value.as_u64().unwrap()))
            .collect(),
        texts: assembly
            .map(|text| ("Assembly".to_string(), text.to_string()))
            .into_iter()
            .collect(),
    }
}

fn written(executable: &Executable) -> Value {
    json!({
        "stage": format!("{:?}", executable.stage),
        "statistics": executable.statistics,
        "assembly": executable.assembly(),
    })
}

#[test]
#[ignore = "the other tests run it in processes of its own"]
fn compiles() {
    let Some(request) = std::env::var_os(REQUEST).map(PathBuf::from) else {
        return;
    };
    let jobs: Value = serde_json::from_str(&fs::read_to_string(&request).unwrap()).unwrap();
    let driver = Driver::open().unwrap();
    let compile = |job: &Value| -> Vec<Value> {
        let files = job["files"].as_array().unwrap().iter();
        let shaders: Vec<Shader> = files
            .map(|file| Shader::read(&fs::read(file.as_str().unwrap()).unwrap()).unwrap())
            .collect();
        let shaders: Vec<&Shader> = shaders.iter().collect();
        let texts = match job["texts"].as_bool() {
            Some(true) => Texts::All,
            _ => Texts::None,
        };
        // SAFETY: committed modules, which the builder has validated, or such without
        // decorations.
        let made = unsafe { driver.compile(&shaders, texts) };
        let made = made.unwrap_or_else(|error| panic!("{}: {error}", job["name"]));
        made.iter().map(written).collect()
    };
    let made: Vec<Vec<Value>> = jobs.as_array().unwrap().iter().map(compile).collect();
    let answer = json!({ "driver": driver.name(), "made": made });
    fs::write(request.with_file_name("answer.json"), answer.to_string()).unwrap();
}
