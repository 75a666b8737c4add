//! What a SPIR-V module says of its entry point: the resources that it reads, the
//! pictures that it writes, and how often it divides.

use crate::Error;
use std::collections::BTreeMap;
use std::ffi::CString;

/// Numbers of the SPIR-V specification.
const MAGIC: u32 = 0x0723_0203;
const HEADER: usize = 5;
const OP_EXT_INST: u32 = 12;
const OP_ENTRY_POINT: u32 = 15;
const OP_TYPE_INT: u32 = 21;
const OP_TYPE_FLOAT: u32 = 22;
const OP_TYPE_VECTOR: u32 = 23;
const OP_TYPE_IMAGE: u32 = 25;
const OP_TYPE_SAMPLER: u32 = 26;
const OP_TYPE_SAMPLED_IMAGE: u32 = 27;
const OP_TYPE_STRUCT: u32 = 30;
const OP_TYPE_POINTER: u32 = 32;
const OP_VARIABLE: u32 = 59;
const OP_DECORATE: u32 = 71;
const OP_F_DIV: u32 = 136;
const BUFFER_BLOCK: u32 = 3;
const LOCATION: u32 = 30;
const BINDING: u32 = 33;
const DESCRIPTOR_SET: u32 = 34;
const UNIFORM_CONSTANT: u32 = 0;
const INPUT: u32 = 1;
const UNIFORM: u32 = 2;
const OUTPUT: u32 = 3;
const PUSH_CONSTANT: u32 = 9;
const STORAGE_BUFFER: u32 = 12;
/// Instructions of `GLSL.std.450`, the only set of extended instructions in shaders.
const SQRT: u32 = 31;
const FMA: u32 = 50;

/// The stage of a pipeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Places vertices.
    Vertex,
    /// Draws pixels.
    Fragment,
    /// Runs by itself.
    Compute,
}

/// A kind of resource.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Binding {
    /// A buffer of any size.
    StorageBuffer,
    /// A buffer of constants.
    UniformBuffer,
    /// A picture that is read.
    SampledImage,
    /// A picture that is read and written.
    StorageImage,
    /// How a picture is read.
    Sampler,
    /// A picture and how it is read.
    SampledImageAndSampler,
}

/// The numbers in a picture that a fragment shader writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// Floats of 32 bits.
    Float,
    /// Signed integers of 32 bits.
    Signed,
    /// Unsigned integers of 32 bits.
    Unsigned,
}

/// A SPIR-V module with one entry point.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Shader {
    pub(crate) words: Vec<u32>,
    pub(crate) name: CString,
    /// Its stage.
    pub stage: Stage,
    /// Its resources by set and binding.
    pub bindings: BTreeMap<(u32, u32), Binding>,
    /// What it writes, by location.
    pub targets: BTreeMap<u32, Target>,
    /// How many divisions of floats it contains.
    pub divisions: usize,
    /// How many square roots it contains.
    pub roots: usize,
    /// How many fused multiply-adds it contains.
    pub fused: usize,
}

/// What a module declares, by ids.
#[derive(Default)]
struct Declared<'a> {
    entry_points: Vec<&'a [u32]>,
    /// The declarations of types: opcode and operands after the id.
    types: BTreeMap<u32, (u32, &'a [u32])>,
    decorations: BTreeMap<(u32, u32), Option<u32>>,
    /// Variables: id, type and storage class.
    variables: Vec<(u32, u32, u32)>,
}

impl Shader {
    /// Reads a module.
    ///
    /// # Errors
    /// [`Error::Module`] if the bytes are not SPIR-V with one entry point, or if the entry
    /// point needs more than buffers and pictures: vertex attributes, push constants,
    /// arrays of resources.
    pub fn read(bytes: &[u8]) -> Result<Shader, Error> {
        let refused = |message: &str| Error::Module(message.to_string());
        let (chunks, rest) = bytes.as_chunks::<4>();
        let words: Vec<u32> = chunks.iter().copied().map(u32::from_le_bytes).collect();
        if !rest.is_empty() || words.first() != Some(&MAGIC) || words.len() < HEADER {
            return Err(refused("it does not begin with SPIR-V's header"));
        }
        let mut declared = Declared::default();
        let (mut divisions, mut roots, mut fused) = (0, 0, 0);
        let mut rest = &words[HEADER..];
        while let Some(&first) = rest.first() {
            let length = (first >> 16) as usize;
            if length == 0 || length > rest.len() {
                return Err(refused("an instruction has a wrong length"));
            }
            let (instruction, after) = rest.split_at(length);
            match (first & 0xffff, &instruction[1..]) {
                (OP_F_DIV, _) => divisions += 1,
                (OP_EXT_INST, &[_, _, _, SQRT, ..]) => roots += 1,
                (OP_EXT_INST, &[_, _, _, FMA, ..]) => fused += 1,
                (opcode, operands) => declared.add(opcode, operands),
            }
            rest = after;
        }
        let &[entry_point] = declared.entry_points.as_slice() else {
            return Err(refused("it has not one entry point"));
        };
        let &[model, _, ref text @ ..] = entry_point else {
            return Err(refused("its entry point is cut off"));
        };
        let stage = match model {
            0 => Stage::Vertex,
            4 => Stage::Fragment,
            5 => Stage::Compute,
            _ => return Err(refused("it is no vertex, fragment or compute shader")),
        };
        let name: Vec<u8> = text.iter().flat_map(|word| word.to_le_bytes()).collect();
        let name = name.split(|&byte| byte == 0).next().unwrap_or_default();
        let name = CString::new(name).map_err(|_| refused("its entry point has no name"))?;
        let (bindings, targets) = declared.interface(stage)?;
        Ok(Shader {
            name,
            stage,
            bindings,
            targets,
            divisions,
            roots,
            fused,
            words,
        })
    }

    /// Returns the name of its entry point.
    pub fn name(&self) -> String {
        self.name.to_string_lossy().into_owned()
    }
}

/// The resources and the outputs of an entry point.
type Interface = (BTreeMap<(u32, u32), Binding>, BTreeMap<u32, Target>);

impl<'a> Declared<'a> {
    fn add(&mut self, opcode: u32, operands: &'a [u32]) {
        match (opcode, operands) {
            (OP_ENTRY_POINT, _) => self.entry_points.push(operands),
            (OP_DECORATE, &[id, decoration, ref value @ ..]) => {
                self.decorations
                    .insert((id, decoration), value.first().copied());
            }
            (OP_VARIABLE, &[of, id, class, ..]) => self.variables.push((id, of, class)),
            (OP_TYPE_INT..=OP_TYPE_POINTER, &[id, ref rest @ ..]) => {
                self.types.insert(id, (opcode, rest));
            }
            _ => {}
        }
    }

    fn decoration(&self, id: u32, decoration: u32) -> Option<u32> {
        self.decorations.get(&(id, decoration)).copied().flatten()
    }

    /// The type that a pointer leads to: its id, opcode and operands.
    fn pointee(&self, pointer: u32) -> Option<(u32, u32, &'a [u32])> {
        let (_, operands) = self.types.get(&pointer)?;
        let id = *operands.get(1)?;
        self.types
            .get(&id)
            .map(|&(opcode, operands)| (id, opcode, operands))
    }

    fn interface(&self, stage: Stage) -> Result<Interface, Error> {
        let (mut bindings, mut targets) = Interface::default();
        for &(id, of, class) in &self.variables {
            let refused = |what: &str| Err(Error::Module(format!("{what} (variable %{id})")));
            let location = self.decoration(id, LOCATION);
            match (class, location, stage) {
                (PUSH_CONSTANT, ..) => return refused("it has push constants"),
                (INPUT, Some(_), Stage::Vertex) => return refused("it reads vertex attributes"),
                (OUTPUT, Some(location), Stage::Fragment) => {
                    let Some(target) = self.target(of) else {
                        return refused("it writes neither a number nor a vector");
                    };
                    targets.insert(location, target);
                }
                (UNIFORM_CONSTANT | UNIFORM | STORAGE_BUFFER, ..) => {
                    let Some(binding) = self.binding(of, class) else {
                        return refused("it has a resource that is no single buffer or picture");
                    };
                    let number = |decoration| self.decoration(id, decoration).unwrap_or(0);
                    bindings.insert((number(DESCRIPTOR_SET), number(BINDING)), binding);
                }
                _ => {}
            }
        }
        Ok((bindings, targets))
    }

    fn binding(&self, pointer: u32, class: u32) -> Option<Binding> {
        let (id, opcode, operands) = self.pointee(pointer)?;
        Some(match (class, opcode) {
            (STORAGE_BUFFER, OP_TYPE_STRUCT) => Binding::StorageBuffer,
            (UNIFORM, OP_TYPE_STRUCT) if self.decorations.contains_key(&(id, BUFFER_BLOCK)) => {
                Binding::StorageBuffer
            }
            (UNIFORM, OP_TYPE_STRUCT) => Binding::UniformBuffer,
            // Whether it is sampled: 1, or only loaded and stored: 2.
            (UNIFORM_CONSTANT, OP_TYPE_IMAGE) if operands.get(5) == Some(&2) => {
                Binding::StorageImage
            }
            (UNIFORM_CONSTANT, OP_TYPE_IMAGE) => Binding::SampledImage,
            (UNIFORM_CONSTANT, OP_TYPE_SAMPLER) => Binding::Sampler,
            (UNIFORM_CONSTANT, OP_TYPE_SAMPLED_IMAGE) => Binding::SampledImageAndSampler,
            _ => return None,
        })
    }

    fn target(&self, pointer: u32) -> Option<Target> {
        let (_, mut opcode, mut operands) = self.pointee(pointer)?;
        if opcode == OP_TYPE_VECTOR {
            (opcode, operands) = *self.types.get(operands.first()?)?;
        }
        match (opcode, operands) {
            (OP_TYPE_FLOAT, _) => Some(Target::Float),
            (OP_TYPE_INT, [_, 0]) => Some(Target::Unsigned),
            (OP_TYPE_INT, _) => Some(Target::Signed),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests;
