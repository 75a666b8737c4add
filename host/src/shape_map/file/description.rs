//! The description of a baked map, as JSON.

use super::super::map::ShapeMap;
use super::super::storage::{Coding, Storage};
use serde::{Deserialize, Serialize};

/// Name of the description in the file.
pub(super) const KEYWORD: &str = "relievo-shape-map";
/// Version of the description.
const VERSION: u32 = 1;

/// The description, as JSON.
#[derive(Serialize, Deserialize)]
struct Description {
    version: u32,
    storage: Storage,
    #[serde(flatten)]
    coding: Coding,
}

/// Returns the description of a map.
pub(super) fn description(map: &ShapeMap) -> String {
    let description = Description {
        version: VERSION,
        storage: map.storage(),
        coding: map.coding(),
    };
    serde_json::to_string(&description).expect("numbers and names can be written as JSON")
}

/// Parses and checks a description.
pub(super) fn parse(text: &str) -> Result<(Storage, Coding), String> {
    // Checks the version first: a later one may have other keys.
    #[derive(Deserialize)]
    struct Version {
        version: u32,
    }
    let unreadable = |error: serde_json::Error| format!("unreadable description: {error}");
    let Version { version } = serde_json::from_str(text).map_err(unreadable)?;
    if version != VERSION {
        return Err(format!(
            "version {version}, but only {VERSION} is supported"
        ));
    }
    let Description {
        storage, coding, ..
    } = serde_json::from_str(text).map_err(unreadable)?;
    storage.check(&coding)?;
    Ok((storage, coding))
}
