//! The generations of GPUs to compile for.

use std::env::consts::ARCH;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// A generation of AMD's GPUs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Generation {
    /// Its name.
    pub name: &'static str,
    /// The GPU of this generation that Mesa pretends to have.
    pub family: &'static str,
    /// Mesa's RADV_PERFTEST.
    options: &'static str,
}

/// Every generation that is measured.
pub const GENERATIONS: [Generation; 2] = [
    Generation {
        name: "RDNA2",
        family: "navi21",
        options: "",
    },
    // Waves of 32 pixels: those of 64 have half the registers each.
    Generation {
        name: "RDNA3",
        family: "gfx1100",
        options: "pswave32",
    },
];

impl Generation {
    /// Returns the environment of a process in which the driver of `manifest` compiles for
    /// this generation.
    pub fn environment(&self, manifest: &Path) -> Vec<(&'static str, OsString)> {
        vec![
            ("RADV_FORCE_FAMILY", self.family.into()),
            ("RADV_PERFTEST", self.options.into()),
            // Without the driver's own code in vertex shaders, which culls triangles.
            ("RADV_DEBUG", "nonggc".into()),
            ("VK_DRIVER_FILES", manifest.into()),
            // The same for older loaders.
            ("VK_ICD_FILENAMES", manifest.into()),
            // Mesa's layer would look for a desktop.
            ("NODEVICE_SELECT", "1".into()),
        ]
    }
}

/// Returns the manifest of Mesa's driver for AMD on this machine; `None` if it is not
/// installed.
pub fn manifest() -> Option<PathBuf> {
    let folders = [
        "/usr/share/vulkan/icd.d",
        "/usr/local/share/vulkan/icd.d",
        "/etc/vulkan/icd.d",
    ];
    let names = [format!("radeon_icd.{ARCH}.json"), "radeon_icd.json".into()];
    let all = folders
        .iter()
        .flat_map(|folder| names.iter().map(|name| Path::new(folder).join(name)));
    all.into_iter().find(|path| path.is_file())
}
