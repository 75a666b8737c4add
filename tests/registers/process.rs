//! Compiles in processes of their own, since Mesa reads the generation of GPUs from the
//! environment.

use super::allowed;
use relievo_compiled::{Driver, Error, Executable, Generation, Shader, Texts};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

/// Environment variable with the file that says what to compile.
const REQUEST: &str = "RELIEVO_COMPILE";
/// The file beside it with what was made.
const ANSWER: &str = "answer.json";

/// Modules that are compiled together.
pub struct Job {
    /// What `allowed` knows them by.
    pub folder: &'static str,
    /// Their files: a compute shader, or a vertex and a fragment shader.
    pub files: Vec<PathBuf>,
}

/// What the driver made of a module.
pub struct Made {
    /// As in the job.
    pub folder: String,
    /// The name of its entry point.
    pub entry_point: String,
    /// The driver's statistics.
    pub statistics: BTreeMap<String, u64>,
    /// What is not exact, if the module must be.
    pub faults: Option<Vec<String>>,
}

/// What a driver made of every job.
pub struct Answer {
    /// The driver's version.
    pub driver: String,
    /// The modules, in the order of the jobs.
    pub made: Vec<Made>,
}

/// A process that compiles.
pub struct Process {
    child: Child,
    folder: tempfile::TempDir,
}

impl Process {
    /// Starts to compile `jobs` for a generation, with the driver of `manifest`.
    pub fn start(generation: &Generation, manifest: &Path, jobs: &[Job]) -> Process {
        let folder = tempfile::tempdir().unwrap();
        let jobs = jobs
            .iter()
            .map(|job| json!({ "folder": job.folder, "files": job.files }));
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

    /// Waits for the answer, or why there is none: the driver does not open.
    pub fn finish(self) -> Result<Answer, String> {
        let output = self.child.wait_with_output().unwrap();
        let said = String::from_utf8_lossy(&output.stdout);
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{said}\n{error}");
        let text = fs::read_to_string(self.folder.path().join(ANSWER)).unwrap();
        let answer: Value = serde_json::from_str(&text).unwrap();
        match answer["error"].as_str() {
            Some(error) => Err(error.to_string()),
            None => Ok(Answer {
                driver: text_of(&answer["driver"]),
                made: answer["made"]
                    .as_array()
                    .unwrap()
                    .iter()
                    .map(made)
                    .collect(),
            }),
        }
    }
}

fn text_of(value: &Value) -> String {
    value.as_str().unwrap().to_string()
}

/// Reads what [`written`] wrote.
fn made(value: &Value) -> Made {
    let statistics = value["statistics"].as_object().unwrap().iter();
    let faults = value["faults"].as_array();
    Made {
        folder: text_of(&value["folder"]),
        entry_point: text_of(&value["entry_point"]),
        statistics: statistics
            .map(|(name, value)| (name.clone(), value.as_u64().unwrap()))
            .collect(),
        faults: faults.map(|faults| faults.iter().map(text_of).collect()),
    }
}

fn written(folder: &str, shader: &Shader, made: &Executable) -> Value {
    let faults = allowed(folder, shader).map(|allowed| {
        let faults = made.faults(&allowed);
        faults.expect("Mesa shows its assembly if it was built with LLVM")
    });
    json!({
        "folder": folder,
        "entry_point": shader.name(),
        "statistics": made.statistics,
        "faults": faults,
    })
}

/// Compiles a job; returns what is made of each of its modules.
fn compile(driver: &Driver, job: &Value) -> Vec<Value> {
    let folder = job["folder"].as_str().unwrap();
    let files = job["files"].as_array().unwrap().iter();
    let shaders: Vec<Shader> = files
        .map(|file| Shader::read(&fs::read(file.as_str().unwrap()).unwrap()).unwrap())
        .collect();
    let texts = match allowed(folder, &shaders[0]) {
        Some(_) => Texts::All,
        None => Texts::None,
    };
    let all: Vec<&Shader> = shaders.iter().collect();
    // SAFETY: committed modules, which the builder has validated, or such without
    // decorations.
    let executables = unsafe { driver.compile(&all, texts) };
    let executables = executables.unwrap_or_else(|error| panic!("{job}: {error}"));
    let of = |shader: &Shader| {
        let mut executables = executables.iter();
        let made = executables.find(|made| made.stage == shader.stage);
        written(folder, shader, made.expect("each stage is compiled"))
    };
    shaders.iter().map(of).collect()
}

#[test]
#[ignore = "the other tests run it in processes of its own"]
fn compiles() {
    let Some(request) = std::env::var_os(REQUEST).map(PathBuf::from) else {
        return;
    };
    let jobs: Value = serde_json::from_str(&fs::read_to_string(&request).unwrap()).unwrap();
    let jobs = jobs.as_array().unwrap();
    let answer = match Driver::open() {
        Ok(driver) => {
            let made: Vec<Value> = jobs.iter().flat_map(|job| compile(&driver, job)).collect();
            json!({ "driver": driver.name(), "made": made })
        }
        Err(error @ (Error::NoDevice | Error::Loader(_))) => {
            json!({ "error": error.to_string() })
        }
        Err(error) => panic!("{error}"),
    };
    fs::write(request.with_file_name(ANSWER), answer.to_string()).unwrap();
}
