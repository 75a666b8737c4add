//! The project's shaders on the adapters of this machine, opened once.

use relievo_bitwise::{Adapter, Canary, DeviceError, Module, Runner, Signature, adapters};
use relievo_kernel::canary::MEANINGS;
use relievo_kernel::{Kernel, for_each_canary, table};
use relievo_shader_manifest::{Manifest, ManifestError, Project, changes, module_files};
use std::collections::BTreeSet;
use std::io::Write;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

/// Whether an adapter is required, or not.
const ADAPTER: &str = "RELIEVO_ADAPTER";
/// Number of inputs of a function.
const INPUTS: &str = "RELIEVO_INPUTS";

/// Adapters that are exact, with the project's exact shaders.
pub(crate) struct Session {
    pub(crate) devices: Vec<Opened>,
    /// Number of inputs of a function.
    pub(crate) inputs: u64,
}

/// An opened adapter.
pub(crate) struct Opened(Mutex<Runner>);

impl Opened {
    /// Waits until no other test uses it.
    pub(crate) fn lock(&self) -> MutexGuard<'_, Runner> {
        // A test that failed has left nothing half done: runs are complete or lost.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Why nothing can be compared.
#[derive(Debug, thiserror::Error)]
enum SessionError {
    #[error(transparent)]
    Manifest(#[from] ManifestError),
    #[error(transparent)]
    Device(#[from] DeviceError),
    #[error("two shader crates have an entry point {0}; rename one")]
    Twice(String),
    #[error(
        "the shaders are not those of the sources; build them with `cargo relievo build`\n  {}", .0.join("\n  ")
    )]
    Stale(Vec<String>),
    #[error(
        "{0} has no canaries, which show whether a device is exact; write `relievo_kernel::canaries!();` in the shader crate and build it with `cargo relievo build`"
    )]
    NoCanaries(String),
    #[error(
        "no adapter to compare on, and {ADAPTER}=required; install a Vulkan driver, such as Mesa's (mesa-vulkan-drivers)"
    )]
    NoAdapter,
    #[error("the environment variable {name} is {value:?}; {remedy}")]
    Variable {
        name: &'static str,
        value: String,
        remedy: &'static str,
    },
}

/// Returns the session, opened at the first call.
///
/// # Panics
/// If it could not be opened, at each call.
#[track_caller]
pub(crate) fn session() -> &'static Session {
    static SESSION: OnceLock<Result<Session, SessionError>> = OnceLock::new();
    match SESSION.get_or_init(open) {
        Ok(session) => session,
        Err(error) => panic!("{error}"),
    }
}

fn open() -> Result<Session, SessionError> {
    let required = adapter_is_required(std::env::var(ADAPTER).ok())?;
    let inputs = number_of_inputs(std::env::var(INPUTS).ok())?;
    let module = exact_module()?;
    let mut devices = Vec::new();
    for adapter in adapters() {
        let name = adapter.describe();
        if !adapter.takes_spirv() {
            say(&format!("left out: {name} does not take SPIR-V unchanged"));
            continue;
        }
        match exact_runner(&adapter, &module) {
            Ok(Ok(runner)) => {
                say(&format!("comparing on {name}"));
                devices.push(Opened(Mutex::new(runner)));
            }
            Ok(Err(tells)) => say(&format!("left out: {name} is not exact: {tells}")),
            Err(error) => say(&format!("left out: {error}")),
        }
    }
    if devices.is_empty() {
        if required {
            return Err(SessionError::NoAdapter);
        }
        say("NO ADAPTER TO COMPARE ON: the GPU's words are not compared");
    }
    Ok(Session { devices, inputs })
}

/// Opens an adapter; or says in which ways it is not exact.
fn exact_runner(adapter: &Adapter, module: &Module) -> Result<Result<Runner, String>, DeviceError> {
    let mut runner = Runner::new(&adapter.open()?, module)?;
    let signature = Signature::take(&mut runner, &canaries())?;
    if signature.is_exact() {
        return Ok(Ok(runner));
    }
    let told = signature.told.iter();
    let wrong = told.filter(|told| told.required && told.different > 0);
    let tells: Vec<_> = wrong.map(|told| told.tells).collect();
    Ok(Err(tells.join(", ")))
}

/// Loads the project's exact modules.
fn exact_module() -> Result<Module, SessionError> {
    // Cargo and nextest set it for tests, and run them there, too.
    let folder = std::env::var_os("CARGO_MANIFEST_DIR").map_or(PathBuf::from("."), PathBuf::from);
    let project = Project::find(&folder)?;
    let changes = changes(&project)?;
    if !changes.is_empty() {
        return Err(SessionError::Stale(changes));
    }
    let files = module_files(&project, &Manifest::load(&project)?)?;
    let is_exact = |name: &str| {
        name.split_once('/')
            .is_some_and(|(folder, _)| folder.ends_with("_exact"))
    };
    let exact: Vec<&[u8]> = files
        .iter()
        .filter(|(name, _)| is_exact(name))
        .map(|(_, bytes)| bytes.as_slice())
        .collect();
    // SAFETY: the builder has validated the modules, and `changes` has found none changed.
    let module = unsafe { Module::untouched(&exact)? };
    let mut names = BTreeSet::new();
    for entry_point in module.entry_points() {
        // Each shader crate has canaries of its own, which are the same.
        if !entry_point.name.starts_with("canaries::") && !names.insert(&entry_point.name) {
            return Err(SessionError::Twice(entry_point.name.clone()));
        }
    }
    let has = |kernel: &Kernel| module.entry_point(kernel.name).is_some();
    if !canaries().iter().all(|canary| has(&canary.kernel)) {
        return Err(SessionError::NoCanaries(project.shaders));
    }
    Ok(module)
}

/// Paths of the canaries' entry points. A kernel of the project may have the same name.
macro_rules! paths {
    ($($name:ident($($value:ty: $domain:expr),*) -> $result:ty = $function:expr;)*) => {
        [$(concat!("canaries::", stringify!($name))),*]
    };
}
const PATHS: [&str; MEANINGS.len()] = for_each_canary!(paths);

fn canaries() -> Vec<Canary> {
    const LIST: &[Kernel] = for_each_canary!(table);
    let all = LIST.iter().zip(PATHS).zip(MEANINGS);
    all.map(|((&kernel, name), meaning)| Canary {
        kernel: Kernel { name, ..kernel },
        required: meaning.required,
        tells: meaning.tells,
    })
    .collect()
}

fn adapter_is_required(value: Option<String>) -> Result<bool, SessionError> {
    match value.as_deref() {
        None | Some("") => Ok(false),
        Some("required") => Ok(true),
        Some(value) => Err(SessionError::Variable {
            name: ADAPTER,
            value: value.to_string(),
            remedy: "the only value is \"required\"",
        }),
    }
}

fn number_of_inputs(value: Option<String>) -> Result<u64, SessionError> {
    let Some(value) = value else {
        return Ok(1 << 16);
    };
    let number = value.parse().ok().filter(|&number| number > 0);
    number.ok_or(SessionError::Variable {
        name: INPUTS,
        value,
        remedy: "make it a whole number above 0, such as 1000000",
    })
}

/// Shows a line even if the test passes, whose output cargo hides.
fn say(line: &str) {
    // A closed stream is no reason to fail.
    let _ = writeln!(std::io::stderr(), "relievo-test: {line}");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variables_are_read_or_explained() {
        let of = |value: &str| Some(value.to_string());
        assert!(!adapter_is_required(None).unwrap());
        assert!(adapter_is_required(of("required")).unwrap());
        let error = adapter_is_required(of("yes")).unwrap_err().to_string();
        assert_eq!(
            error,
            "the environment variable RELIEVO_ADAPTER is \"yes\"; the only value is \"required\""
        );
        assert_eq!(number_of_inputs(None).unwrap(), 65_536);
        assert_eq!(number_of_inputs(of("4294967296")).unwrap(), 1 << 32);
        for wrong in ["0", "-1", "many", "1e6"] {
            assert!(number_of_inputs(of(wrong)).is_err(), "{wrong}");
        }
    }

    #[test]
    fn canaries_are_named_by_their_meanings() {
        assert_eq!(canaries().len(), MEANINGS.len());
        for (canary, meaning) in canaries().iter().zip(MEANINGS) {
            assert_eq!(canary.kernel.name, format!("canaries::{}", meaning.name));
        }
    }
}
