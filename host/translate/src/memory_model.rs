//! Replaces the Vulkan memory model of a module by GLSL450 where that changes
//! nothing.
//!
//! rust-gpu declares the Vulkan memory model in every module for Vulkan. It needs
//! a device feature that wgpu enables only for cooperative matrices; without it
//! the module is invalid. A module that uses nothing of that model has the same
//! meaning in the GLSL450 model, which needs no feature.

use crate::spirv::{HEADER, instructions, literal, opcode};
use std::borrow::Cow;

const OP_EXTENSION: u32 = 10;
const OP_MEMORY_MODEL: u32 = 14;
const OP_CAPABILITY: u32 = 17;
const OP_LOAD: u32 = 61;
const OP_STORE: u32 = 62;
const OP_COPY_MEMORY: u32 = 63;
const OP_COPY_MEMORY_SIZED: u32 = 64;

const GLSL450: u32 = 1;
const VULKAN: u32 = 3;
const VULKAN_MEMORY_MODEL: u32 = 5345;
const EXTENSION: &str = "SPV_KHR_vulkan_memory_model";

/// Returns the words of a module, with the GLSL450 memory model in place of the
/// Vulkan one if nothing in the module needs the latter.
pub fn plain(words: &[u32]) -> Cow<'_, [u32]> {
    let declares = instructions(words).any(|instruction| {
        opcode(instruction) == OP_MEMORY_MODEL && matches!(instruction, [_, _, VULKAN])
    });
    if !declares || instructions(words).any(needs_vulkan) {
        return Cow::Borrowed(words);
    }
    let mut plain = words[..HEADER].to_vec();
    for instruction in instructions(words) {
        let operands = &instruction[1..];
        match opcode(instruction) {
            OP_CAPABILITY if operands == [VULKAN_MEMORY_MODEL] => {}
            OP_EXTENSION if literal(operands) == EXTENSION => {}
            OP_MEMORY_MODEL => plain.extend([instruction[0], operands[0], GLSL450]),
            _ => plain.extend(instruction),
        }
    }
    Cow::Owned(plain)
}

/// Returns whether an instruction may have another meaning in the GLSL450 model:
/// instructions with a scope or with availability and visibility operands, and
/// all image instructions, which may have them.
fn needs_vulkan(instruction: &[u32]) -> bool {
    // Volatile, Aligned and Nontemporal exist in both models.
    let has_others = |operands: Option<&[u32]>| {
        operands.is_some_and(|operands| operands.iter().any(|operand| operand & !7 != 0))
    };
    match opcode(instruction) {
        OP_LOAD => has_others(instruction.get(4..5)),
        OP_STORE => has_others(instruction.get(3..4)),
        OP_COPY_MEMORY => has_others(instruction.get(3..)),
        OP_COPY_MEMORY_SIZED => has_others(instruction.get(4..)),
        // Images; barriers and atomics; groups; extensions, some with a scope.
        86..=107 | 224..=242 | 259..=320 | 333..=366 | 4416.. => true,
        OP_CAPABILITY => instruction[1..] == [VULKAN_MEMORY_MODEL + 1],
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Builds a module from a header and instructions, given as opcode and operands.
    fn module(instructions: &[(u32, &[u32])]) -> Vec<u32> {
        let mut words = vec![7; 5];
        for (opcode, operands) in instructions {
            words.push((operands.len() as u32 + 1) << 16 | opcode);
            words.extend(*operands);
        }
        words
    }

    fn extension() -> Vec<u32> {
        let mut bytes = EXTENSION.as_bytes().to_vec();
        bytes.resize((bytes.len() + 1).next_multiple_of(4), 0);
        let (words, _) = bytes.as_chunks::<4>();
        words.iter().copied().map(u32::from_le_bytes).collect()
    }

    #[test]
    fn an_unneeded_memory_model_is_replaced() {
        let extension = extension();
        let declared = |with: &[(u32, &[u32])]| {
            let mut all: Vec<(u32, &[u32])> = vec![
                (OP_CAPABILITY, &[1]),
                (OP_CAPABILITY, &[VULKAN_MEMORY_MODEL]),
                (OP_EXTENSION, &extension),
                (OP_EXTENSION, &[0x0041_4141]),
                (OP_MEMORY_MODEL, &[0, VULKAN]),
            ];
            all.extend(with);
            module(&all)
        };
        let plain_load: (u32, &[u32]) = (OP_LOAD, &[1, 2, 3, 2, 4]);
        let expected = module(&[
            (OP_CAPABILITY, &[1]),
            (OP_EXTENSION, &[0x0041_4141]),
            (OP_MEMORY_MODEL, &[0, GLSL450]),
            plain_load,
        ]);
        assert_eq!(plain(&declared(&[plain_load])), expected);
        // A second pass changes nothing.
        assert_eq!(plain(&expected), expected);
        // A load with visibility, a store, a copy, a barrier, an atomic.
        let needs: [(u32, &[u32]); 5] = [
            (OP_LOAD, &[1, 2, 3, 0x20]),
            (OP_STORE, &[1, 2, 0x28, 9]),
            (OP_COPY_MEMORY, &[1, 2, 0, 0x20]),
            (224, &[1, 2, 3]),
            (234, &[1, 2, 3, 4, 5, 6]),
        ];
        for needed in needs {
            let words = declared(&[plain_load, needed]);
            assert_eq!(plain(&words), words, "{needed:?}");
        }
    }

    #[test]
    fn malformed_words_are_returned_as_they_are() {
        for words in [vec![], vec![0; 3], vec![7; 9], vec![0; 9]] {
            assert_eq!(plain(&words), words);
        }
    }
}
