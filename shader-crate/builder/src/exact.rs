//! The exact module, which gives the CPU's words on every device with IEEE rounding.
//!
//! rust-gpu emits no `NoContraction`, and its own run of spirv-opt rewrites float
//! operations. So this compiles without spirv-opt, decorates every float operation,
//! optimises then, and checks that no undecorated or unknown operation is left.

use anyhow::{Result, bail};
use spirv_tools::opt::{self, Optimizer};
use std::collections::{BTreeMap, BTreeSet};

use crate::words::{HEADER, Instruction, TARGET, instructions};

mod op {
    pub const EXT_INST: u32 = 12;
    pub const TYPE_FLOAT: u32 = 22;
    pub const TYPE_VECTOR: u32 = 23;
    pub const DECORATE: u32 = 71;
    pub const F_NEGATE: u32 = 127;
    pub const F_ADD: u32 = 129;
    pub const F_SUB: u32 = 131;
    pub const F_MUL: u32 = 133;
    pub const F_DIV: u32 = 136;
    pub const VECTOR_TIMES_SCALAR: u32 = 142;
}

/// `SpvDecorationNoContraction`.
const NO_CONTRACTION: u32 = 42;

/// Float operations allowed in the exact module. Rounding of others (FRem, Dot, matrix
/// products) differs between devices.
const ARITHMETIC: [u32; 6] = [
    op::F_NEGATE,
    op::F_ADD,
    op::F_SUB,
    op::F_MUL,
    op::F_DIV,
    op::VECTOR_TIMES_SCALAR,
];

/// Extended instructions allowed in the exact module: Sqrt.
const EXTENDED: [u32; 1] = [31];

/// Opcodes allowed in the exact module beside [`ARITHMETIC`] and [`op::EXT_INST`]:
/// structure, integers, comparisons, control flow, and conversions between i32 or u32
/// and f32.
const OTHER: &[u32] = &[
    1, // Undef
    3, 5, 6, // Source, Name, MemberName
    10, 11, // Extension, ExtInstImport
    14, 15, 16, 17, // MemoryModel, EntryPoint, ExecutionMode, Capability
    19, 20, 21, 22, 23, 25, 28, 29, 30, 32, 33, // types
    41, 42, 43, 44, 46, // constants
    54, 55, 56, 57, 59, // functions and variables
    61, 62, 65, 66, // Load, Store, AccessChain, InBoundsAccessChain
    71, 72, // Decorate, MemberDecorate
    79, 80, 81, 82,
    83, // VectorShuffle, CompositeConstruct, CompositeExtract, CompositeInsert, CopyObject
    95, // ImageFetch, of words
    109, 110, 111, 112, // ConvertFToU, ConvertFToS, ConvertSToF, ConvertUToF
    124, // Bitcast
    126, 128, 130, 132, 134, 135, 137, 138, 139, // integer arithmetic
    164, 165, 166, 167, 168, 169, // logic, Select
    170, 171, 172, 173, 174, 175, 176, 177, 178, 179, // integer comparisons
    180, 181, 182, 183, 184, 185, 186, 187, 188, 189, 190, 191, // float comparisons
    194, 195, 196, 197, 198, 199, 200, // shifts and bits
    245, 246, 247, 248, 249, 250, 251, 252, 253, 254, 255, // control flow
];

/// Returns the ids of the types whose components are floats.
fn float_types(instructions: &[Instruction<'_>]) -> BTreeSet<u32> {
    let mut floats = BTreeSet::new();
    for instruction in instructions {
        match instruction.opcode {
            op::TYPE_FLOAT => {
                floats.insert(instruction.words[1]);
            }
            op::TYPE_VECTOR if floats.contains(&instruction.words[2]) => {
                floats.insert(instruction.words[1]);
            }
            _ => {}
        }
    }
    floats
}

/// Returns the result ids of all operations that round.
fn rounding_results(instructions: &[Instruction<'_>]) -> Vec<u32> {
    let floats = float_types(instructions);
    instructions
        .iter()
        .filter(|instruction| {
            ARITHMETIC.contains(&instruction.opcode)
                || (instruction.opcode == op::EXT_INST && floats.contains(&instruction.words[1]))
        })
        .map(|instruction| instruction.words[2])
        .collect()
}

/// Returns `module` with `NoContraction` on every operation that rounds.
pub fn decorate(module: &[u32]) -> Result<Vec<u32>> {
    let all = instructions(module)?;
    let decorations: Vec<u32> = rounding_results(&all)
        .into_iter()
        .flat_map(|id| [3 << 16 | op::DECORATE, id, NO_CONTRACTION])
        .collect();
    let mut decorated = module[..HEADER].to_vec();
    let mut inserted = false;
    for instruction in &all {
        if !inserted && instruction.opcode == op::DECORATE {
            decorated.extend(&decorations);
            inserted = true;
        }
        decorated.extend(instruction.words);
    }
    if !inserted {
        bail!("a module without any decoration has no entry point to make exact");
    }
    Ok(decorated)
}

/// Runs spirv-opt's performance passes, as rust-gpu does.
pub fn optimize(module: &[u32]) -> Result<Vec<u32>> {
    let mut optimizer = opt::create(Some(TARGET));
    optimizer
        .register_performance_passes()
        .register_pass(opt::Passes::EliminateDeadConstant)
        .register_pass(opt::Passes::StripDebugInfo);
    let binary = optimizer.optimize(
        module,
        &mut |message: spirv_tools::error::Message| eprintln!("spirv-opt: {}", message.message),
        None,
    )?;
    Ok(binary.as_words().to_vec())
}

/// Checks that every operation that rounds is decorated, and that every opcode is allowed.
pub fn check(module: &[u32]) -> Result<()> {
    let all = instructions(module)?;
    let decorated: BTreeSet<u32> = all
        .iter()
        .filter(|i| i.opcode == op::DECORATE && i.words[2] == NO_CONTRACTION)
        .map(|i| i.words[1])
        .collect();
    let bare = rounding_results(&all)
        .into_iter()
        .filter(|id| !decorated.contains(id))
        .count();
    if bare > 0 {
        bail!("{bare} float operations are not decorated NoContraction");
    }
    let mut unknown: BTreeMap<String, usize> = BTreeMap::new();
    for instruction in &all {
        let opcode = instruction.opcode;
        let name = match opcode {
            op::EXT_INST if EXTENDED.contains(&instruction.words[4]) => continue,
            op::EXT_INST => format!("extended instruction {}", instruction.words[4]),
            _ if ARITHMETIC.contains(&opcode) || OTHER.contains(&opcode) => continue,
            _ => format!("opcode {opcode}"),
        };
        *unknown.entry(name).or_default() += 1;
    }
    if !unknown.is_empty() {
        bail!("not on the allow-list of the exact module: {unknown:?}");
    }
    Ok(())
}

/// Makes the exact module from the output of rust-gpu without spirv-opt.
pub fn make(unoptimized: &[u32]) -> Result<Vec<u32>> {
    let module = optimize(&decorate(unoptimized)?)?;
    check(&module)?;
    Ok(module)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::words::tests::Words;

    /// A module as words: `%f = OpFAdd`, `%m = OpFRem` as asked.
    fn module(operations: &[u32]) -> Vec<u32> {
        let mut words = Words::new();
        words.put(17, &[1]);
        words.put(op::DECORATE, &[50, 0]);
        words.put(op::TYPE_FLOAT, &[1, 32]);
        for (i, &opcode) in operations.iter().enumerate() {
            words.put(opcode, &[1, 10 + i as u32, 2, 3]);
        }
        words.0
    }

    #[test]
    fn bare_arithmetic_is_refused_and_decorated_passes() {
        let bare = module(&[op::F_ADD, op::F_MUL]);
        let message = check(&bare).unwrap_err().to_string();
        assert!(message.contains("2 float operations"), "{message}");
        check(&decorate(&bare).unwrap()).unwrap();
    }

    #[test]
    fn unknown_opcodes_are_refused() {
        let message = check(&decorate(&module(&[140])).unwrap())
            .unwrap_err()
            .to_string();
        assert!(message.contains("opcode 140"), "{message}");
    }
}
