//! What an entry point reads and writes, as its module declares it.

use relievo_translate::spirv::{instructions, literal, opcode};
use std::collections::BTreeMap;

const OP_ENTRY_POINT: u32 = 15;
const OP_TYPE_FLOAT: u32 = 22;
const OP_TYPE_VECTOR: u32 = 23;
const OP_TYPE_POINTER: u32 = 32;
const OP_VARIABLE: u32 = 59;
const OP_DECORATE: u32 = 71;

const LOCATION: u32 = 30;
const BINDING: u32 = 33;
const OUTPUT: u32 = 3;

/// The number of vertex shaders in SPIR-V.
pub(crate) const VERTEX: u32 = 0;
/// The number of fragment shaders in SPIR-V.
pub(crate) const FRAGMENT: u32 = 4;

/// The interface of an entry point.
#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct Interface {
    /// Which kind of shader it is.
    pub(crate) model: Option<u32>,
    /// Number of bindings that the module needs: one more than the largest.
    pub(crate) bindings: u32,
    /// Whether the output at location 0 is of floats.
    pub(crate) writes_floats: Option<bool>,
}

/// Returns the interface of an entry point of a module.
pub(crate) fn of(words: &[u32], name: &str) -> Interface {
    let mut found = Interface::default();
    // Types by their ids: the id that a pointer or a vector leads to.
    let mut inner = BTreeMap::new();
    let mut floats = Vec::new();
    let mut first = Vec::new();
    let mut outputs = Vec::new();
    // Its own: a module may have several entry points.
    let mut variables: &[u32] = &[];
    for instruction in instructions(words) {
        match (opcode(instruction), &instruction[1..]) {
            (OP_ENTRY_POINT, [model, _, text @ ..]) if literal(text) == name => {
                found.model = Some(*model);
                variables = &text[name.len() / 4 + 1..];
            }
            (OP_DECORATE, &[_, BINDING, number]) => found.bindings = found.bindings.max(number + 1),
            (OP_DECORATE, &[id, LOCATION, 0]) => first.push(id),
            (OP_TYPE_FLOAT, &[id, ..]) => floats.push(id),
            (OP_TYPE_VECTOR, &[id, component, _]) => {
                inner.insert(id, component);
            }
            (OP_TYPE_POINTER, &[id, _, pointee]) => {
                inner.insert(id, pointee);
            }
            (OP_VARIABLE, &[pointer, id, OUTPUT, ..]) => outputs.push((id, pointer)),
            _ => {}
        }
    }
    let is_first = |id: &u32| first.contains(id) && variables.contains(id);
    let output = outputs.into_iter().find(|(id, _)| is_first(id));
    found.writes_floats = output.map(|(_, mut of)| {
        while let Some(&within) = inner.get(&of) {
            of = within;
        }
        floats.contains(&of)
    });
    found
}
