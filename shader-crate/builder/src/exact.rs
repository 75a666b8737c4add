//! The exact module, which gives the CPU's words on every device with IEEE rounding.
//!
//! rust-gpu emits no `NoContraction`, and its own run of spirv-opt rewrites float
//! operations. So this compiles without spirv-opt, decorates every float operation,
//! optimises then, and checks that no undecorated or unknown operation is left.
//!
//! Division and square root are needed where they are corrected, and are wrong elsewhere.
//! Which is which is decided by the lines of the module that rust-gpu writes: see
//! [`sites`].

use anyhow::{Result, bail};
use spirv_tools::opt::{self, Optimizer};
use std::collections::BTreeSet;

use crate::allowed::{ARITHMETIC, DRIVER_SET, Operation};
use crate::packages::Packages;
use crate::refusal::Refusals;
use crate::words::{HEADER, Instruction, TARGET, instructions, text};
use crate::{panics, sites};

mod op {
    pub const EXT_INST_IMPORT: u32 = 11;
    pub const EXT_INST: u32 = 12;
    pub const TYPE_FLOAT: u32 = 22;
    pub const TYPE_VECTOR: u32 = 23;
    pub const DECORATE: u32 = 71;
}

/// `SpvDecorationNoContraction`.
const NO_CONTRACTION: u32 = 42;

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

/// Checks that every operation that rounds is decorated. Returns the operations that are
/// not allowed.
pub fn check(module: &[u32]) -> Result<BTreeSet<Operation>> {
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
    for set in all.iter().filter(|i| i.opcode == op::EXT_INST_IMPORT) {
        let name = text(&set.words[2..]);
        if name != DRIVER_SET {
            bail!("the set of instructions {name} is not on the list of the exact module");
        }
    }
    Ok(all
        .iter()
        .map(Operation::of)
        .filter(|operation| !operation.is_allowed())
        .collect())
}

/// Makes the exact module of an entry point from the output of rust-gpu without
/// spirv-opt, and adds what is not exact to `refusals`. The module is of no use if there
/// is anything.
pub fn make(
    entry_point: &str,
    unoptimized: &[u32],
    packages: &Packages,
    refusals: &mut Refusals,
) -> Result<Vec<u32>> {
    let mut found = Vec::new();
    if panics::are_in(unoptimized)? {
        let left = panics::of(&optimize(unoptimized)?)?;
        found.extend(sites::of_panics(unoptimized, &left, packages)?);
    }
    let silent = panics::remove(unoptimized)?;
    let module = optimize(&decorate(&silent)?)?;
    let wrong = check(&module)?;
    // Optimised modules have no debug information.
    found.extend(sites::of_operations(&silent, &wrong, packages)?);
    for (advice, site) in found {
        refusals.add(entry_point, advice, site);
    }
    Ok(module)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::words::tests::{Words, literal};

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
        let bare = module(&[129, 133]);
        let message = check(&bare).unwrap_err().to_string();
        assert!(message.contains("2 float operations"), "{message}");
        assert!(check(&decorate(&bare).unwrap()).unwrap().is_empty());
    }

    #[test]
    fn unknown_operations_are_found() {
        let mut unknown = decorate(&module(&[140])).unwrap();
        unknown.extend([3 << 16 | op::TYPE_FLOAT, 9, 64]);
        assert_eq!(
            check(&unknown).unwrap().into_iter().collect::<Vec<_>>(),
            [Operation::Instruction(140), Operation::Float(64)]
        );
    }

    #[test]
    fn other_sets_of_instructions_are_refused() {
        let mut words = Words(decorate(&module(&[])).unwrap());
        words.put(
            op::EXT_INST_IMPORT,
            &[&[60], &literal("OpenCL.std")[..]].concat(),
        );
        let message = check(&words.0).unwrap_err().to_string();
        assert!(message.contains("OpenCL.std"), "{message}");
    }
}
