//! Reports the results of comparisons as text and JSON.
//!
//! ```
//! use relievo::render::gpu::Shaders;
//! use relievo::verify::ModuleReport;
//! use relievo_bitwise::Tally;
//!
//! let mut tally = Tally::default();
//! tally.add(0, &[7], &[1], &[2]);
//! let mut report = ModuleReport::new(Shaders::Exact);
//! report.add_kernel("root", &tally);
//! assert_eq!((report.words, report.different), (1, 1));
//! assert_eq!(report.kernels[0].found.first[0].place, "input 0, word 0");
//! ```

use super::agreement::{Agreement, COLOR_NAMES, GEOMETRY_NAMES};
use crate::render::gpu::{Adapter, Shaders, Signature};
use relievo_bitwise::Tally;
use serde::{Deserialize, Deserializer, Serialize};
use std::fmt;

/// Results of one run.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Report {
    /// One report per adapter.
    pub adapters: Vec<AdapterReport>,
}

/// Results on one adapter.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct AdapterReport {
    /// The adapter's name.
    pub name: String,
    /// The API.
    pub backend: String,
    /// The driver and its version.
    pub driver: String,
    /// Whether it is a software driver, which runs on the CPU.
    pub software: bool,
    /// Results of the canaries; empty if the adapter takes no SPIR-V.
    pub canaries: Vec<CanaryReport>,
    /// Whether it passes the required canaries, so that the exact shaders are used.
    pub exact: bool,
    /// One report per module.
    pub modules: Vec<ModuleReport>,
}

/// Result of a canary.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CanaryReport {
    /// Name of the canary.
    pub name: String,
    /// Whether an exact device must pass it.
    pub required: bool,
    /// Number of words compared.
    pub words: u64,
    /// Number of words that differ.
    pub different: u64,
    /// Meaning of a difference.
    pub tells: String,
}

/// Results with one module.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ModuleReport {
    /// Name: exact, fast or portable shaders.
    pub shaders: String,
    /// Whether it promises the CPU's words.
    pub promises: bool,
    /// Number of words compared, of kernels and pictures.
    pub words: u64,
    /// Number of words that differ.
    pub different: u64,
    /// Functions compared one by one.
    pub kernels: Vec<KernelReport>,
    /// Pictures compared.
    pub pictures: Vec<PictureReport>,
}

/// Result for one function.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct KernelReport {
    /// Name of the function.
    pub name: String,
    /// Differences.
    #[serde(flatten)]
    pub found: Counts,
}

/// Result for one picture.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct PictureReport {
    /// Scene and variant.
    pub scene: String,
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Number of pixels with different colours.
    pub color_pixels: u64,
    /// Number of pixels with different surface classes.
    pub class_pixels: u64,
    /// Largest difference of a linear colour channel.
    #[serde(deserialize_with = "number")]
    pub largest_color_difference: f32,
    /// Largest relative difference of the distance t.
    #[serde(deserialize_with = "number")]
    pub largest_distance_difference: f32,
    /// Colour words.
    pub color: Counts,
    /// Geometry words.
    pub geometry: Counts,
}

/// Counts of words and their differences.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Counts {
    /// Number of words compared.
    pub words: u64,
    /// Number of words that differ.
    pub different: u64,
    /// Histogram of distances: largest distance of each class in ULPs (0, 1, 2, 4,
    /// 8, …) and number of words.
    pub ulp: Vec<(u64, u64)>,
    /// Number of words with a NaN on one side.
    pub nan: u64,
    /// The first few differences.
    pub first: Vec<FirstDifference>,
}

/// A word that differs.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct FirstDifference {
    /// Place of the word: "(x, y) red" for a pixel, or "input 17, word 2".
    pub place: String,
    /// Arguments of the function as words; empty for a pixel.
    pub input: Vec<String>,
    /// The GPU's word.
    pub gpu: String,
    /// The CPU's word.
    pub cpu: String,
    /// Distance in ULPs; `None` if one is a NaN.
    pub ulp: Option<u64>,
}

/// Reads a number. JSON has null for infinity and NaN.
fn number<'de, D: Deserializer<'de>>(from: D) -> Result<f32, D::Error> {
    Ok(Option::deserialize(from)?.unwrap_or(f32::INFINITY))
}

/// Formats a word as bits and as a number.
fn show(word: u32) -> String {
    format!("{word:08x} = {:e}", f32::from_bits(word))
}

impl Counts {
    fn of(tally: &Tally, place: impl Fn(u64, usize) -> String) -> Counts {
        Counts {
            words: tally.words,
            different: tally.different,
            ulp: tally.histogram.classes().collect(),
            nan: tally.histogram.nan(),
            first: tally
                .first
                .iter()
                .map(|difference| FirstDifference {
                    place: place(difference.index, difference.word),
                    input: difference.input.iter().copied().map(show).collect(),
                    gpu: show(difference.gpu),
                    cpu: show(difference.cpu),
                    ulp: Some(difference.ulp).filter(|&ulp| ulp != u64::MAX),
                })
                .collect(),
        }
    }
}

impl AdapterReport {
    /// Makes a report without modules. `signature` is `None` for an adapter that takes
    /// no SPIR-V.
    pub fn new(adapter: &Adapter, signature: Option<&Signature>) -> AdapterReport {
        let info = adapter.info();
        let told = signature.map_or(&[][..], |signature| &signature.told);
        AdapterReport {
            name: info.name,
            backend: info.backend.to_string(),
            driver: format!("{} {}", info.driver, info.driver_info),
            software: adapter.is_software(),
            canaries: told
                .iter()
                .map(|told| CanaryReport {
                    name: told.name.to_string(),
                    required: told.required,
                    words: told.words,
                    different: told.different,
                    tells: told.tells.to_string(),
                })
                .collect(),
            exact: signature.is_some_and(Signature::is_exact),
            modules: Vec::new(),
        }
    }
}

impl ModuleReport {
    /// Makes a report without results.
    pub fn new(shaders: Shaders) -> ModuleReport {
        ModuleReport {
            shaders: shaders.describe().to_string(),
            promises: shaders.is_exact(),
            words: 0,
            different: 0,
            kernels: Vec::new(),
            pictures: Vec::new(),
        }
    }

    /// Adds the result for a function.
    pub fn add_kernel(&mut self, name: &str, tally: &Tally) {
        self.words += tally.words;
        self.different += tally.different;
        self.kernels.push(KernelReport {
            name: name.to_string(),
            found: Counts::of(tally, |index, word| format!("input {index}, word {word}")),
        });
    }

    /// Adds the result for a picture.
    pub fn add_picture(&mut self, scene: String, agreement: &Agreement) {
        self.words += agreement.words();
        self.different += agreement.different();
        let width = agreement.width.max(1) as u64;
        let place = |names: &'static [&'static str]| {
            move |index: u64, word: usize| {
                format!("({}, {}) {}", index % width, index / width, names[word])
            }
        };
        self.pictures.push(PictureReport {
            scene,
            size: [width as u32, (agreement.color.inputs / width) as u32],
            color_pixels: agreement.color.inputs_different,
            class_pixels: agreement.class_pixels as u64,
            largest_color_difference: agreement.largest_color_difference,
            largest_distance_difference: agreement.largest_distance_difference,
            color: Counts::of(&agreement.color, place(&COLOR_NAMES)),
            geometry: Counts::of(&agreement.geometry, place(&GEOMETRY_NAMES)),
        });
    }
}

impl Report {
    /// Adds the results of `other` on the same adapters.
    ///
    /// # Errors
    /// How the adapters differ.
    pub fn join(&mut self, other: Report) -> Result<(), String> {
        if self.adapters.is_empty() {
            *self = other;
            return Ok(());
        }
        let names = |report: &Report| {
            let names = report.adapters.iter();
            let names = names.map(|adapter| format!("{}, {}", adapter.name, adapter.driver));
            names.collect::<Vec<_>>().join("; ")
        };
        let (own, others) = (names(self), names(&other));
        if own != others {
            return Err(format!("ran on {others}, and those before on {own}"));
        }
        for (own, other) in self.adapters.iter_mut().zip(other.adapters) {
            if own.canaries != other.canaries || own.modules.len() != other.modules.len() {
                return Err(format!("found other canaries of {}", own.name));
            }
            for (own, other) in own.modules.iter_mut().zip(other.modules) {
                own.words += other.words;
                own.different += other.different;
                own.kernels.extend(other.kernels);
                own.pictures.extend(other.pictures);
            }
        }
        Ok(())
    }

    /// Returns the names of adapters whose exact shaders do not give the CPU's words.
    pub fn broken(&self) -> Vec<&str> {
        self.adapters
            .iter()
            .filter(|adapter| {
                let mut modules = adapter.modules.iter();
                modules.any(|module| module.promises && module.different > 0)
            })
            .map(|adapter| adapter.name.as_str())
            .collect()
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for adapter in &self.adapters {
            writeln!(
                f,
                "{} ({}, {})",
                adapter.name, adapter.backend, adapter.driver
            )?;
            let canaries: Vec<String> = adapter.canaries.iter().map(CanaryReport::show).collect();
            match (canaries.is_empty(), adapter.exact) {
                (true, _) => writeln!(f, "  takes no SPIR-V untouched: portable shaders are used")?,
                (_, true) => writeln!(
                    f,
                    "  canaries passed, exact shaders are used: {}",
                    canaries.join(", ")
                )?,
                (_, false) => writeln!(
                    f,
                    "  CANARIES FAILED, this device is not exact and fast shaders are used: {}",
                    canaries.join(", ")
                )?,
            }
            for module in &adapter.modules {
                writeln!(
                    f,
                    "  {}: {} of {} words differ",
                    module.shaders, module.different, module.words
                )?;
                for kernel in &module.kernels {
                    write!(f, "    {}: ", kernel.name)?;
                    kernel.found.write(f)?;
                }
                for picture in &module.pictures {
                    let [width, height] = picture.size;
                    writeln!(
                        f,
                        "    {}, {width} × {height}: {} pixels differ in colour, {} in class; largest difference: colour {:.2e}, distance {:.2e} of itself",
                        picture.scene,
                        picture.color_pixels,
                        picture.class_pixels,
                        picture.largest_color_difference,
                        picture.largest_distance_difference
                    )?;
                    write!(f, "      colour: ")?;
                    picture.color.write(f)?;
                    write!(f, "      geometry: ")?;
                    picture.geometry.write(f)?;
                }
            }
        }
        Ok(())
    }
}

impl CanaryReport {
    fn show(&self) -> String {
        if self.different == 0 {
            format!("{} exact", self.name)
        } else {
            format!("{} differs ({})", self.name, self.tells)
        }
    }
}

impl Counts {
    fn write(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} of {} words differ", self.different, self.words)?;
        if self.different > 0 {
            let classes = self.ulp.iter().filter(|(distance, _)| *distance > 0);
            let classes: Vec<String> = classes
                .map(|(distance, words)| format!("≤ {distance}: {words}"))
                .collect();
            write!(f, "; ULP {}", classes.join(", "))?;
            if self.nan > 0 {
                write!(f, "; NaN: {}", self.nan)?;
            }
        }
        writeln!(f)?;
        for first in &self.first {
            let ulp = first
                .ulp
                .map_or("NaN".to_string(), |ulp| format!("{ulp} ULP"));
            write!(
                f,
                "        {}: GPU {}, CPU {}, {ulp}",
                first.place, first.gpu, first.cpu
            )?;
            if !first.input.is_empty() {
                write!(f, "; input [{}]", first.input.join(", "))?;
            }
            writeln!(f)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::{ColorWords, GeometryWords};
    use crate::verify::compare;

    #[test]
    fn differences_are_shown_with_place_and_distance() {
        let one = 1f32.to_bits();
        let cpu = ColorWords {
            width: 2,
            height: 1,
            words: vec![[one; 4]; 2],
        };
        let mut gpu = cpu.clone();
        gpu.words[1][1] += 3;
        let geometry = GeometryWords {
            width: 2,
            height: 1,
            place: vec![[one; 4]; 2],
            surface: vec![[one; 4]; 2],
        };
        let mut module = ModuleReport::new(Shaders::Exact);
        let agreement = compare([&gpu, &cpu], [&geometry, &geometry]);
        module.add_picture("scene.toml".to_string(), &agreement);
        let mut kernel = Tally::default();
        kernel.add(17, &[one], &[one], &[one + 1]);
        module.add_kernel("root", &kernel);
        assert_eq!((module.words, module.different), (25, 2));
        let report = Report {
            adapters: vec![AdapterReport {
                name: "a device".to_string(),
                backend: "vulkan".to_string(),
                driver: "a driver".to_string(),
                software: true,
                canaries: Vec::new(),
                exact: true,
                modules: vec![module],
            }],
        };
        assert_eq!(report.broken(), ["a device"]);
        let text = report.to_string();
        for part in [
            "exact shaders: 2 of 25 words differ",
            "root: 1 of 1 words differ; ULP ≤ 1: 1",
            "input 17, word 0: GPU 3f800000 = 1e0, CPU 3f800001 = 1.0000001e0, 1 ULP; input [3f800000 = 1e0]",
            "scene.toml, 2 × 1: 1 pixels differ in colour, 0 in class",
            "(1, 0) green: GPU 3f800003",
            "3 ULP",
        ] {
            assert!(text.contains(part), "{part}\n{text}");
        }
    }
}
