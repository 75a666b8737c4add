//! Compiled SPIR-V modules and how they reach the driver.
//!
//! ```
//! use relievo_bitwise::Module;
//!
//! let error = Module::portable(&[b"not SPIR-V"]).unwrap_err();
//! assert!(error.to_string().contains("10 bytes are not whole words"));
//! ```

use crate::{Device, DeviceError};
use relievo_translate::spirv::{HEADER, MAGIC, instructions, literal, opcode};
use relievo_translate::{constants, memory_model, portable};
use std::borrow::Cow;
use std::sync::Arc;

/// How a module reaches the driver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Route {
    /// Unchanged, except for a memory model that nothing in it needs and the values of
    /// specialization constants. Requires
    /// Vulkan with shader passthrough. The only route that keeps NoContraction and
    /// the float controls.
    Untouched,
    /// Translated by naga, after its loops are rewritten ([`portable`]). Works on
    /// every backend of wgpu.
    Portable,
}

/// An entry point of a module.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EntryPoint {
    /// Its name.
    pub name: String,
    /// Workgroup size in x, y and z, if this is a compute shader.
    pub workgroup: Option<[u32; 3]>,
    /// Result id of its function in the module.
    id: u32,
}

/// Compiled SPIR-V in one or more files, each with one or more entry points.
#[derive(Clone, Debug)]
pub struct Module {
    files: Arc<[File]>,
    route: Route,
    /// Values of specialization constants, by id.
    constants: Vec<(u32, u32)>,
}

#[derive(Clone, Debug)]
struct File {
    words: Vec<u32>,
    entry_points: Vec<EntryPoint>,
}

impl Module {
    /// Makes a module that the driver gets unchanged, from the bytes of its `.spv`
    /// files.
    ///
    /// # Safety
    /// The files must be valid by the Vulkan specification (as spirv-val checks),
    /// must terminate, and must not access memory outside their buffers. They are
    /// not validated before the driver gets them.
    ///
    /// # Errors
    /// [`DeviceError::Module`] if the bytes are not SPIR-V.
    pub unsafe fn untouched(files: &[&[u8]]) -> Result<Module, DeviceError> {
        Module::new(files, Route::Untouched)
    }

    /// Makes a module that naga translates, from the bytes of its `.spv` files.
    ///
    /// # Errors
    /// [`DeviceError::Module`] if the bytes are not SPIR-V.
    pub fn portable(files: &[&[u8]]) -> Result<Module, DeviceError> {
        Module::new(files, Route::Portable)
    }

    fn new(files: &[&[u8]], route: Route) -> Result<Module, DeviceError> {
        let files = files
            .iter()
            .map(|bytes| File::new(bytes))
            .collect::<Result<_, _>>()?;
        Ok(Module {
            files,
            route,
            constants: Vec::new(),
        })
    }

    /// Returns the module with this value of the specialization constant `id`, which is a u32
    /// or an i32. Others have the value that is in the files.
    #[must_use]
    pub fn with_constant(&self, id: u32, value: u32) -> Module {
        let mut module = self.clone();
        module.constants.retain(|(known, _)| *known != id);
        module.constants.push((id, value));
        module
    }

    /// Returns how the module reaches the driver.
    pub fn route(&self) -> Route {
        self.route
    }

    /// Returns the entry points of all files.
    pub fn entry_points(&self) -> impl Iterator<Item = &EntryPoint> {
        self.files.iter().flat_map(|file| &file.entry_points)
    }

    /// Returns the entry point of a name: of this name, or else the only one whose path
    /// ends in it, as `noise::hash` in `hash`.
    pub fn entry_point(&self, name: &str) -> Option<&EntryPoint> {
        if let Some(exact) = self.entry_points().find(|found| found.name == name) {
            return Some(exact);
        }
        let ends = |found: &&EntryPoint| {
            let path = found.name.strip_suffix(name);
            path.is_some_and(|path| path.ends_with("::"))
        };
        let mut found = self.entry_points().filter(ends);
        found.next().filter(|_| found.next().is_none())
    }

    /// Counts the instructions in the functions of the file with an entry point;
    /// `None` if there is no such entry point.
    pub fn instructions(&self, entry_point: &str) -> Option<usize> {
        let words = &self.file(entry_point)?.words;
        let before = |instruction: &&[u32]| opcode(instruction) != OP_FUNCTION;
        Some(instructions(words).skip_while(before).count())
    }

    /// Returns the naga module that [`Route::Portable`] gives to wgpu for an entry
    /// point.
    ///
    /// # Errors
    /// [`DeviceError::Module`] if there is no such entry point or naga cannot read
    /// it.
    pub fn translated(&self, entry_point: &str) -> Result<naga::Module, DeviceError> {
        let refused = |message| DeviceError::Module {
            message: format!("the file with {entry_point:?}: {message}"),
        };
        let words = constants::set(&self.wanted(entry_point)?.words, &self.constants);
        let mut module = portable::read(&words).map_err(refused)?;
        portable::lower(&mut module).map_err(refused)?;
        Ok(module)
    }

    /// Returns the SPIR-V with an entry point as the driver or naga gets it; `None`
    /// if there is no such entry point.
    pub fn spirv(&self, entry_point: &str) -> Option<Cow<'_, [u32]>> {
        let words = constants::set(&self.file(entry_point)?.words, &self.constants);
        Some(match self.route {
            Route::Untouched => match words {
                Cow::Borrowed(words) => memory_model::plain(words),
                Cow::Owned(words) => memory_model::plain(&words).into_owned().into(),
            },
            Route::Portable => words,
        })
    }

    fn file(&self, entry_point: &str) -> Option<&File> {
        let entry_point = self.entry_point(entry_point)?.name.as_str();
        let has = |file: &&File| file.entry_points.iter().any(|has| has.name == entry_point);
        self.files.iter().find(has)
    }

    fn wanted(&self, entry_point: &str) -> Result<&File, DeviceError> {
        self.file(entry_point).ok_or_else(|| DeviceError::Module {
            message: format!("it has no entry point {entry_point:?}"),
        })
    }

    /// Loads the file with an entry point on `device`.
    ///
    /// # Errors
    /// [`DeviceError::Untouched`] if the module needs shader passthrough and the
    /// device has none,
    /// [`DeviceError::Module`] if there is no such entry point or naga cannot read
    /// it,
    /// [`DeviceError::Device`] if the device or naga's validator rejects it.
    pub fn load(
        &self,
        device: &Device,
        entry_point: &str,
    ) -> Result<wgpu::ShaderModule, DeviceError> {
        if self.route == Route::Untouched && !device.takes_spirv() {
            return Err(DeviceError::Untouched {
                adapter: device.describe().to_string(),
            });
        }
        let file = self.wanted(entry_point)?;
        device.attempt(|| {
            Ok(match self.route {
                Route::Untouched => {
                    let entry_points = file
                        .entry_points
                        .iter()
                        .map(|entry_point| wgpu::PassthroughShaderEntryPoint {
                            name: Cow::Borrowed(entry_point.name.as_str()),
                            workgroup_size: entry_point.workgroup.unwrap_or([1; 3]).into(),
                        })
                        .collect();
                    // SAFETY: required of the caller of `Module::untouched`.
                    unsafe {
                        device.wgpu().create_shader_module_passthrough(
                            wgpu::ShaderModuleDescriptorPassthrough {
                                label: Some("bitwise"),
                                entry_points,
                                spirv: self.spirv(entry_point),
                                ..Default::default()
                            },
                        )
                    }
                }
                // Not as SPIR-V, for which wgpu would translate the loops unchanged.
                Route::Portable => {
                    let module = self.translated(entry_point)?;
                    device
                        .wgpu()
                        .create_shader_module(wgpu::ShaderModuleDescriptor {
                            label: Some("bitwise"),
                            source: wgpu::ShaderSource::Naga(Cow::Owned(module)),
                        })
                }
            })
        })
    }
}

impl File {
    fn new(bytes: &[u8]) -> Result<File, DeviceError> {
        let (chunks, rest) = bytes.as_chunks::<4>();
        if !rest.is_empty() {
            return Err(DeviceError::Module {
                message: format!("{} bytes are not whole words", bytes.len()),
            });
        }
        let words: Vec<u32> = chunks.iter().copied().map(u32::from_le_bytes).collect();
        Ok(File {
            entry_points: entry_points(&words)?,
            words,
        })
    }
}

const OP_ENTRY_POINT: u32 = 15;
const OP_EXECUTION_MODE: u32 = 16;
const OP_FUNCTION: u32 = 54;
const LOCAL_SIZE: u32 = 17;

/// Reads the entry points of a module, which are declared before its functions.
fn entry_points(words: &[u32]) -> Result<Vec<EntryPoint>, DeviceError> {
    let malformed = |message: String| DeviceError::Module { message };
    if words.first() != Some(&MAGIC) || words.len() < HEADER {
        return Err(malformed(
            "it does not begin with SPIR-V's header".to_string(),
        ));
    }
    let mut found: Vec<EntryPoint> = Vec::new();
    let mut at = HEADER;
    while at < words.len() {
        let length = (words[at] >> 16) as usize;
        let Some(instruction) = words.get(at..at + length).filter(|_| length > 0) else {
            return Err(malformed(format!(
                "the instruction at word {at} has a wrong length"
            )));
        };
        match (opcode(instruction), &instruction[1..]) {
            (OP_ENTRY_POINT, [_model, id, name @ ..]) => found.push(EntryPoint {
                name: literal(name),
                workgroup: None,
                id: *id,
            }),
            (OP_EXECUTION_MODE, &[id, LOCAL_SIZE, x, y, z]) => {
                for entry_point in found.iter_mut().filter(|found| found.id == id) {
                    entry_point.workgroup = Some([x, y, z]);
                }
            }
            (OP_FUNCTION, _) => break,
            _ => {}
        }
        at += length;
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;

    #[test]
    fn entry_points_and_their_workgroups_are_found() {
        let module = Module::portable(&[&testing::shader()]).expect("a module");
        let names: Vec<&str> = module
            .entry_points()
            .map(|entry_point| entry_point.name.as_str())
            .collect();
        assert_eq!(
            names,
            [
                "multiply_add",
                "product_and_sum",
                "scale",
                "silent",
                "narrow"
            ]
        );
        let workgroups: Vec<_> = module
            .entry_points()
            .map(|entry_point| entry_point.workgroup.map(|sides| sides[0]))
            .collect();
        assert_eq!(workgroups, [64, 64, 64, 64, 32].map(Some));
    }

    #[test]
    fn malformed_modules_are_rejected_with_a_reason() {
        let refused = |bytes: &[u8]| Module::portable(&[bytes]).unwrap_err().to_string();
        assert!(refused(&[1, 2, 3]).contains("3 bytes"));
        assert!(refused(&[]).contains("header"));
        assert!(refused(b"no SPIR-V here, sorry!!!").contains("header"));
        let whole = testing::shader();
        let mut zero_length = whole[..20].to_vec();
        zero_length.extend([0; 8]);
        assert!(refused(&zero_length).contains("word 5"));
        let mut cut = whole[..20].to_vec();
        cut.extend((9_u32 << 16 | 17).to_le_bytes());
        assert!(refused(&cut).contains("word 5"));
    }
}
