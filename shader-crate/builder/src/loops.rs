//! Leaves loops at their head.
//!
//! rust-gpu writes `while c { body }` as a loop whose head selects the body or nothing, and
//! whose tail decides whether to go on. What the loop leaves behind is the head's, so that
//! a device keeps it in registers beside the values that the body makes of it: twice as
//! many registers for everything that changes in a loop. Here the head leaves the loop
//! itself, as compilers of other languages write it.

use anyhow::{Result, anyhow};
use rspirv::binary::Assemble;
use rspirv::dr::{Block, Function, Instruction, Module, Operand};
use spirv::Op;
use std::collections::{BTreeMap, BTreeSet};

/// A loop to leave at its head.
struct Loop {
    /// The block that selects the body.
    head: u32,
    /// The block after the body.
    join: u32,
    /// The block that goes back.
    tail: u32,
    header: u32,
    /// The block after the loop.
    merge: u32,
    /// All blocks.
    blocks: BTreeSet<u32>,
    /// Results of the join's φs, and their values if the body is not selected.
    outside: BTreeMap<u32, u32>,
    /// Whether the tail may leave the loop, too.
    may_end: bool,
}

/// Returns the operands that are ids.
fn ids(instruction: &Instruction) -> Vec<u32> {
    let operands = instruction.operands.iter();
    operands.filter_map(Operand::id_ref_any).collect()
}

/// Returns the values of a φ and the blocks that they come from.
fn pairs(phi: &Instruction) -> Vec<(u32, u32)> {
    let ids = ids(phi);
    ids.chunks_exact(2).map(|pair| (pair[0], pair[1])).collect()
}

/// The blocks of a function by their labels.
struct Blocks<'a> {
    all: BTreeMap<u32, &'a Block>,
    /// The instruction of each result, constants included.
    definitions: BTreeMap<u32, &'a Instruction>,
}

impl<'a> Blocks<'a> {
    fn of(function: &'a Function, constants: &'a [Instruction]) -> Blocks<'a> {
        let label = |block: &'a Block| Some((block.label_id()?, block));
        let all: BTreeMap<u32, &Block> = function.blocks.iter().filter_map(label).collect();
        let instructions = all.values().flat_map(|block| &block.instructions);
        let definitions = instructions
            .chain(constants)
            .filter_map(|instruction| Some((instruction.result_id?, instruction)))
            .collect();
        Blocks { all, definitions }
    }

    /// Returns the labels that a block may branch to.
    fn targets(&self, label: u32) -> Vec<u32> {
        let last = self.all.get(&label).and_then(|b| b.instructions.last());
        last.map_or(Vec::new(), |last| match last.class.opcode {
            Op::Branch => ids(last),
            // After the condition, or the selector.
            Op::BranchConditional | Op::Switch => ids(last)[1..].to_vec(),
            _ => Vec::new(),
        })
    }

    /// Returns the blocks that branch to `label`.
    fn sources(&self, label: u32) -> Vec<u32> {
        let labels = self.all.keys().copied();
        let branches = |&block: &u32| self.targets(block).contains(&label);
        labels.filter(branches).collect()
    }

    /// Returns the value of a boolean where `condition` has the given one, if that
    /// decides it.
    fn decided(&self, value: u32, condition: (u32, bool)) -> Option<bool> {
        if value == condition.0 {
            return Some(condition.1);
        }
        let definition = self.definitions.get(&value)?;
        match definition.class.opcode {
            Op::ConstantTrue => Some(true),
            Op::ConstantFalse => Some(false),
            Op::LogicalNot => Some(!self.decided(ids(definition)[0], condition)?),
            Op::Select => {
                let [chooses, yes, no] = ids(definition)[..] else {
                    return None;
                };
                let chosen = if self.decided(chooses, condition)? {
                    yes
                } else {
                    no
                };
                self.decided(chosen, condition)
            }
            _ => None,
        }
    }

    /// Returns the loop of `header`, if it can be left at its head.
    fn find(&self, header: u32) -> Option<Loop> {
        let [.., merges, to_head] = &self.all[&header].instructions[..] else {
            return None;
        };
        if merges.class.opcode != Op::LoopMerge || to_head.class.opcode != Op::Branch {
            return None;
        }
        let (merge, tail, head) = (ids(merges)[0], ids(merges)[1], ids(to_head)[0]);
        let [.., selection, select] = &self.all.get(&head)?.instructions[..] else {
            return None;
        };
        if selection.class.opcode != Op::SelectionMerge
            || select.class.opcode != Op::BranchConditional
        {
            return None;
        }
        let join = ids(selection)[0];
        let [condition, yes, no] = ids(select)[..] else {
            return None;
        };
        let [joins, goes_back] = [join, tail].map(|label| self.all[&label].instructions.last());
        let (joins, goes_back) = (joins?, goes_back?);
        // The condition's value where the body is not selected.
        let skips = yes == join;
        if (yes == join) == (no == join)
            || joins.class.opcode != Op::Branch
            || ids(joins) != [tail]
            || goes_back.class.opcode != Op::BranchConditional
            || self.sources(tail) != [join]
        {
            return None;
        }
        let sources = self.sources(join);
        if sources.len() != 2 || !sources.contains(&head) {
            return None;
        }

        let (mut outside, mut inside) = (BTreeMap::new(), BTreeMap::new());
        let is_phi = |instruction: &&Instruction| instruction.class.opcode == Op::Phi;
        for phi in self.all[&join].instructions.iter().filter(is_phi) {
            for (value, source) in pairs(phi) {
                let values = if source == head {
                    &mut outside
                } else {
                    &mut inside
                };
                values.insert(phi.result_id?, value);
            }
        }
        // The tail goes on after the body, and leaves without it.
        let goes_on = |values: &BTreeMap<u32, u32>, condition: (u32, bool)| {
            let [value, first, second] = ids(goes_back)[..] else {
                return None;
            };
            let value = *values.get(&value).unwrap_or(&value);
            let target = if self.decided(value, condition)? {
                first
            } else {
                second
            };
            Some(target == header)
        };
        if goes_on(&outside, (condition, skips))? {
            return None;
        }
        let may_end = goes_on(&inside, (condition, !skips)) != Some(true);
        // Values that leave the loop by both ways meet in φs.
        if may_end && self.sources(merge) != [tail] {
            return None;
        }

        let mut blocks = BTreeSet::from([header]);
        let mut rest = vec![header];
        while let Some(block) = rest.pop() {
            for target in self.targets(block) {
                if target != merge && blocks.insert(target) {
                    rest.push(target);
                }
            }
        }
        let found = Loop {
            head,
            join,
            tail,
            header,
            merge,
            blocks,
            outside,
            may_end,
        };
        (!self.escapes(&found)).then_some(found)
    }

    /// Returns whether a result of join or tail that is not a φ of the join is used
    /// elsewhere.
    fn escapes(&self, of: &Loop) -> bool {
        let own = [of.join, of.tail];
        let results: BTreeSet<u32> = own
            .iter()
            .flat_map(|label| &self.all[label].instructions)
            .filter_map(|instruction| instruction.result_id)
            .filter(|result| !of.outside.contains_key(result))
            .collect();
        let others = self.all.iter().filter(|(label, _)| !own.contains(label));
        let mut used = others.flat_map(|(_, block)| block.instructions.iter().flat_map(ids));
        used.any(|id| results.contains(&id))
    }
}

/// Replaces an id by its value in `values`.
fn replace(operand: &mut Operand, values: &BTreeMap<u32, u32>) {
    if let Operand::IdRef(id) = operand {
        *id = *values.get(id).unwrap_or(id);
    }
}

/// Returns the φs in which the values of a loop meet that may end at its tail, too, by the
/// results that they stand for outside of it.
fn meeting(function: &Function, of: &Loop, next_id: &mut u32) -> BTreeMap<u32, Instruction> {
    let outside = function.blocks.iter().filter(|block| {
        let label = block.label_id();
        label.is_some_and(|label| !of.blocks.contains(&label))
    });
    let used: BTreeSet<u32> = outside
        .flat_map(|block| &block.instructions)
        .flat_map(ids)
        .collect();
    let join = function
        .blocks
        .iter()
        .find(|b| b.label_id() == Some(of.join));
    let phis = join.into_iter().flat_map(|block| &block.instructions);
    phis.filter_map(|phi| Some((phi.result_id?, phi.result_type)))
        .filter(|(result, _)| used.contains(result))
        .filter_map(|(result, result_type)| {
            let operands = [*of.outside.get(&result)?, of.head, result, of.tail];
            let operands = operands.map(Operand::IdRef).to_vec();
            *next_id += 1;
            let phi = Instruction::new(Op::Phi, result_type, Some(*next_id - 1), operands);
            Some((result, phi))
        })
        .collect()
}

/// Leaves a loop of `function` at its head.
fn leave(function: &mut Function, of: &Loop, next_id: &mut u32) {
    let meeting = if of.may_end {
        meeting(function, of, next_id)
    } else {
        BTreeMap::new()
    };
    let after: BTreeMap<u32, u32> = if of.may_end {
        let results = meeting
            .iter()
            .filter_map(|(&old, phi)| Some((old, phi.result_id?)));
        results.collect()
    } else {
        of.outside.clone()
    };
    for block in &mut function.blocks {
        let Some(label) = block.label_id() else {
            continue;
        };
        let instructions = &mut block.instructions;
        if label == of.head {
            instructions.retain(|instruction| instruction.class.opcode != Op::SelectionMerge);
            let to_merge = BTreeMap::from([(of.join, of.merge)]);
            let last = instructions.last_mut().into_iter();
            last.flat_map(|last| &mut last.operands)
                .for_each(|operand| replace(operand, &to_merge));
        } else if label == of.join {
            let is_phi = |instruction: &&mut Instruction| instruction.class.opcode == Op::Phi;
            for phi in instructions.iter_mut().filter(is_phi) {
                let kept = pairs(phi)
                    .into_iter()
                    .filter(|&(_, source)| source != of.head);
                phi.operands = kept
                    .flat_map(|(value, source)| [value, source].map(Operand::IdRef))
                    .collect();
            }
        } else if label == of.tail && !of.may_end {
            instructions.pop();
            let back = vec![Operand::IdRef(of.header)];
            instructions.push(Instruction::new(Op::Branch, None, None, back));
        } else if !of.blocks.contains(&label) {
            for instruction in instructions.iter_mut() {
                if label == of.merge && instruction.class.opcode == Op::Phi {
                    let values = pairs(instruction).into_iter().flat_map(|(value, source)| {
                        let outside = *of.outside.get(&value).unwrap_or(&value);
                        match (source == of.tail, of.may_end) {
                            (false, _) => vec![value, source],
                            (true, false) => vec![outside, of.head],
                            (true, true) => vec![outside, of.head, value, source],
                        }
                    });
                    instruction.operands = values.map(Operand::IdRef).collect();
                } else {
                    let operands = &mut instruction.operands;
                    operands
                        .iter_mut()
                        .for_each(|operand| replace(operand, &after));
                }
            }
            if label == of.merge {
                instructions.splice(0..0, meeting.values().cloned());
            }
        }
    }
}

/// Returns `module` with its loops left at their heads.
pub fn leave_at_head(module: &[u32]) -> Result<Vec<u32>> {
    let mut module: Module =
        rspirv::dr::load_words(module).map_err(|error| anyhow!("rspirv: {error}"))?;
    let constants = std::mem::take(&mut module.types_global_values);
    let mut next_id = module.header.as_ref().map_or(0, |header| header.bound);
    for function in &mut module.functions {
        loop {
            let blocks = Blocks::of(function, &constants);
            let found = blocks.all.keys().find_map(|&header| blocks.find(header));
            let Some(found) = found else { break };
            leave(function, &found, &mut next_id);
        }
    }
    module.types_global_values = constants;
    if let Some(header) = &mut module.header {
        header.bound = next_id;
    }
    Ok(module.assemble())
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
    const FALSE: u32 = 5;
    const MAIN: u32 = 6;
    const HEADER: u32 = 10;
    const HEAD: u32 = 11;
    const BODY: u32 = 12;
    const JOIN: u32 = 13;
    const TAIL: u32 = 14;
    const MERGE: u32 = 15;
    /// What the loop knows at its head.
    const GOES_ON: u32 = 20;
    /// What the body makes of it.
    const NEXT: u32 = 21;
    const JOINED: u32 = 22;
    const BACK: u32 = 23;
    /// What is used after the loop.
    const AFTER: u32 = 24;

    /// `while goes_on { goes_on = !goes_on }`, as rust-gpu writes it. The tail asks `back`:
    /// a φ of whether to go on after the body, and without it.
    fn written_by_rust_gpu(back: [u32; 2]) -> Vec<u32> {
        let mut words = Words::new();
        words.put(17, &[1]);
        words.put(14, &[0, 1]);
        words.put(15, &[5, MAIN, u32::from_le_bytes(*b"main"), 0]);
        words.put(16, &[MAIN, 17, 1, 1, 1]);
        words.put(19, &[VOID]);
        words.put(33, &[FUNCTION, VOID]);
        words.put(20, &[BOOL]);
        words.put(41, &[BOOL, TRUE]);
        words.put(42, &[BOOL, FALSE]);
        words.put(54, &[VOID, MAIN, 0, FUNCTION]);
        words.put(248, &[9]);
        words.put(249, &[HEADER]);
        words.put(248, &[HEADER]);
        words.put(245, &[BOOL, GOES_ON, TRUE, 9, JOINED, TAIL]);
        words.put(246, &[MERGE, TAIL, 0]);
        words.put(249, &[HEAD]);
        words.put(248, &[HEAD]);
        words.put(247, &[JOIN, 0]);
        words.put(250, &[GOES_ON, BODY, JOIN]);
        words.put(248, &[BODY]);
        words.put(168, &[BOOL, NEXT, GOES_ON]);
        words.put(249, &[JOIN]);
        words.put(248, &[JOIN]);
        words.put(245, &[BOOL, JOINED, NEXT, BODY, FALSE, HEAD]);
        words.put(245, &[BOOL, BACK, back[0], BODY, back[1], HEAD]);
        words.put(249, &[TAIL]);
        words.put(248, &[TAIL]);
        words.put(250, &[BACK, HEADER, MERGE]);
        words.put(248, &[MERGE]);
        words.put(168, &[BOOL, AFTER, JOINED]);
        words.put(253, &[]);
        words.put(56, &[]);
        words.0
    }

    /// The blocks of the function, and the ids that their instructions name.
    fn blocks(words: &[u32]) -> BTreeMap<u32, Vec<(Op, Vec<u32>)>> {
        let module: Module = rspirv::dr::load_words(words).unwrap();
        let block = |block: &Block| {
            let instructions = block.instructions.iter();
            let named = instructions.map(|i| (i.class.opcode, ids(i))).collect();
            (block.label_id().unwrap(), named)
        };
        module.functions[0].blocks.iter().map(block).collect()
    }

    #[test]
    fn a_loop_is_left_where_its_condition_is_asked() {
        let module = written_by_rust_gpu([TRUE, FALSE]);
        validate(&module).unwrap();
        let left = leave_at_head(&module).unwrap();
        validate(&left).unwrap();
        let blocks = blocks(&left);
        assert_eq!(
            blocks[&HEAD],
            [(Op::BranchConditional, vec![GOES_ON, BODY, MERGE])]
        );
        assert_eq!(blocks[&JOIN][0], (Op::Phi, vec![NEXT, BODY]));
        assert_eq!(blocks[&TAIL], [(Op::Branch, vec![HEADER])]);
        // The value without the body.
        assert_eq!(blocks[&MERGE][0], (Op::LogicalNot, vec![FALSE]));
    }

    #[test]
    fn values_meet_where_the_tail_may_leave_too() {
        let module = written_by_rust_gpu([NEXT, FALSE]);
        validate(&module).unwrap();
        let left = leave_at_head(&module).unwrap();
        validate(&left).unwrap();
        let blocks = blocks(&left);
        assert_eq!(
            blocks[&HEAD],
            [(Op::BranchConditional, vec![GOES_ON, BODY, MERGE])]
        );
        assert_eq!(
            blocks[&TAIL],
            [(Op::BranchConditional, vec![BACK, HEADER, MERGE])]
        );
        assert_eq!(
            blocks[&MERGE][0],
            (Op::Phi, vec![FALSE, HEAD, JOINED, TAIL])
        );
        // A second time changes nothing.
        assert_eq!(leave_at_head(&left).unwrap(), left);
    }

    #[test]
    fn a_loop_that_goes_on_without_its_body_stays() {
        let module = written_by_rust_gpu([TRUE, TRUE]);
        assert_eq!(blocks(&leave_at_head(&module).unwrap()), blocks(&module));
    }
}
