//! Replaces empty arms of selections by edges.
//!
//! rust-gpu gives every `if` two arms, one of which is mostly empty. SwiftShader finds the
//! back edges of a loop with a search that visits everything after such a diamond twice,
//! and so 2ⁿ times after n diamonds: 8 minutes and 19 GB for a shader that takes half a
//! second without the empty arms.

use crate::words::{HEADER, Instruction, instructions};
use anyhow::Result;
use std::collections::BTreeMap;

mod op {
    pub const PHI: u32 = 245;
    pub const LOOP_MERGE: u32 = 246;
    pub const SELECTION_MERGE: u32 = 247;
    pub const LABEL: u32 = 248;
    pub const BRANCH: u32 = 249;
    pub const BRANCH_CONDITIONAL: u32 = 250;
    pub const SWITCH: u32 = 251;
}

/// A selection with an arm to remove.
struct Selection {
    /// The block that selects.
    head: u32,
    merge: u32,
}

/// Returns the label of the block of each instruction; 0 outside functions.
fn blocks(all: &[Instruction<'_>]) -> Vec<u32> {
    let mut block = 0;
    all.iter()
        .map(|instruction| {
            if instruction.opcode == op::LABEL {
                block = instruction.words[1];
            }
            block
        })
        .collect()
}

/// Returns the targets of blocks that only branch. Leaves out blocks that instructions
/// other than branches refer to.
fn empty_blocks(all: &[Instruction<'_>]) -> BTreeMap<u32, u32> {
    let mut empty: BTreeMap<u32, u32> = all
        .windows(2)
        .filter(|pair| pair[0].opcode == op::LABEL && pair[1].opcode == op::BRANCH)
        .map(|pair| (pair[0].words[1], pair[1].words[1]))
        .collect();
    for instruction in all {
        let named = match instruction.opcode {
            op::SELECTION_MERGE => &instruction.words[1..2],
            op::LOOP_MERGE => &instruction.words[1..3],
            // The constants of cases, too: at worst one block less is removed.
            op::BRANCH | op::SWITCH => &instruction.words[1..],
            _ => &[],
        };
        for label in named {
            empty.remove(label);
        }
    }
    empty
}

/// Returns the arms to remove, with their selections.
fn spare_arms(all: &[Instruction<'_>], blocks: &[u32]) -> BTreeMap<u32, Selection> {
    let empty = empty_blocks(all);
    let mut spare = BTreeMap::new();
    for (pair, &head) in all.windows(2).zip(blocks) {
        let [merge, branch] = pair else { continue };
        if merge.opcode != op::SELECTION_MERGE || branch.opcode != op::BRANCH_CONDITIONAL {
            continue;
        }
        let merge = merge.words[1];
        let arms = [branch.words[2], branch.words[3]];
        // Two edges to the merge would be one in its φs.
        if arms[0] == arms[1] || arms.contains(&merge) {
            continue;
        }
        if let Some(arm) = arms.into_iter().find(|arm| empty.get(arm) == Some(&merge)) {
            spare.insert(arm, Selection { head, merge });
        }
    }
    spare
}

/// Returns `module` without the empty arms of selections.
pub fn remove_empty(module: &[u32]) -> Result<Vec<u32>> {
    let all = instructions(module)?;
    let blocks = blocks(&all);
    let spare = spare_arms(&all, &blocks);
    let mut slim = module[..HEADER].to_vec();
    for (instruction, block) in all.iter().zip(&blocks) {
        if spare.contains_key(block) {
            continue;
        }
        let start = slim.len();
        slim.extend(instruction.words);
        let words = &mut slim[start..];
        match instruction.opcode {
            op::BRANCH_CONDITIONAL => {
                for target in &mut words[2..4] {
                    if let Some(selection) = spare.get(target) {
                        *target = selection.merge;
                    }
                }
            }
            // Pairs of a value and its predecessor block.
            op::PHI => {
                for parent in words[3..].iter_mut().skip(1).step_by(2) {
                    if let Some(selection) = spare.get(parent) {
                        *parent = selection.head;
                    }
                }
            }
            _ => {}
        }
    }
    Ok(slim)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::words::tests::Words;
    use crate::words::validate;

    const VOID: u32 = 1;
    const FUNCTION: u32 = 2;
    const BOOL: u32 = 3;
    const TRUE: u32 = 4;
    const MAIN: u32 = 5;

    /// A compute shader of these blocks: opcodes and operands.
    fn shader(body: &[(u32, &[u32])]) -> Vec<u32> {
        let mut words = Words::new();
        words.put(17, &[1]);
        words.put(14, &[0, 1]);
        words.put(15, &[5, MAIN, u32::from_le_bytes(*b"main"), 0]);
        words.put(16, &[MAIN, 17, 1, 1, 1]);
        words.put(19, &[VOID]);
        words.put(33, &[FUNCTION, VOID]);
        words.put(20, &[BOOL]);
        words.put(41, &[BOOL, TRUE]);
        words.put(54, &[VOID, MAIN, 0, FUNCTION]);
        for (opcode, operands) in body {
            words.put(*opcode, operands);
        }
        words.put(253, &[]);
        words.put(56, &[]);
        words.0
    }

    #[test]
    fn an_empty_arm_goes_and_the_phi_keeps_its_value() {
        let diamond = shader(&[
            (op::LABEL, &[10]),
            (op::SELECTION_MERGE, &[13, 0]),
            (op::BRANCH_CONDITIONAL, &[TRUE, 11, 12]),
            (op::LABEL, &[11]),
            (168, &[BOOL, 20, TRUE]),
            (op::BRANCH, &[13]),
            (op::LABEL, &[12]),
            (op::BRANCH, &[13]),
            (op::LABEL, &[13]),
            (op::PHI, &[BOOL, 21, 20, 11, TRUE, 12]),
        ]);
        let triangle = shader(&[
            (op::LABEL, &[10]),
            (op::SELECTION_MERGE, &[13, 0]),
            (op::BRANCH_CONDITIONAL, &[TRUE, 11, 13]),
            (op::LABEL, &[11]),
            (168, &[BOOL, 20, TRUE]),
            (op::BRANCH, &[13]),
            (op::LABEL, &[13]),
            (op::PHI, &[BOOL, 21, 20, 11, TRUE, 10]),
        ]);
        validate(&diamond).unwrap();
        validate(&triangle).unwrap();
        let slim = remove_empty(&diamond).unwrap();
        assert_eq!(slim, triangle);
        // What is a triangle stays one.
        assert_eq!(remove_empty(&slim).unwrap(), triangle);
    }

    #[test]
    fn of_two_empty_arms_one_stays() {
        let empty = shader(&[
            (op::LABEL, &[10]),
            (op::SELECTION_MERGE, &[13, 0]),
            (op::BRANCH_CONDITIONAL, &[TRUE, 11, 12]),
            (op::LABEL, &[11]),
            (op::BRANCH, &[13]),
            (op::LABEL, &[12]),
            (op::BRANCH, &[13]),
            (op::LABEL, &[13]),
        ]);
        let slim = remove_empty(&empty).unwrap();
        validate(&slim).unwrap();
        assert_eq!(slim.len(), empty.len() - 4);
    }

    #[test]
    fn blocks_that_others_need_stay() {
        // 14 is the merge of the selection within the first arm.
        let nested = shader(&[
            (op::LABEL, &[10]),
            (op::SELECTION_MERGE, &[13, 0]),
            (op::BRANCH_CONDITIONAL, &[TRUE, 11, 13]),
            (op::LABEL, &[11]),
            (op::SELECTION_MERGE, &[14, 0]),
            (op::BRANCH_CONDITIONAL, &[TRUE, 15, 14]),
            (op::LABEL, &[15]),
            (op::BRANCH, &[14]),
            (op::LABEL, &[14]),
            (op::BRANCH, &[13]),
            (op::LABEL, &[13]),
        ]);
        validate(&nested).unwrap();
        assert_eq!(remove_empty(&nested).unwrap(), nested);
    }
}
