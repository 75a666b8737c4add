//! The memory model of a module for Vulkan.
//!
//! rust-gpu declares the Vulkan memory model in every module for Vulkan. A
//! device must enable a feature for that, and wgpu enables it only for
//! cooperative matrices: without, the module is invalid. One that uses nothing
//! of that model means the same in the older one, which needs no feature.

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

/// The words of a module, with the GLSL450 memory model in place of the Vulkan
/// one where it uses nothing of that. `header` words come before its
/// instructions.
pub(crate) fn plain(words: &[u32], header: usize) -> Cow<'_, [u32]> {
    let instructions = || Instructions {
        rest: words.get(header..).unwrap_or_default(),
    };
    let declares = instructions()
        .any(|words| matches!(words, [first, _, VULKAN] if first & 0xffff == OP_MEMORY_MODEL));
    if !declares || instructions().any(needs_vulkan) {
        return Cow::Borrowed(words);
    }
    let mut plain = words[..header].to_vec();
    for instruction in instructions() {
        let operands = &instruction[1..];
        match instruction[0] & 0xffff {
            OP_CAPABILITY if operands == [VULKAN_MEMORY_MODEL] => {}
            OP_EXTENSION if super::module::literal(operands) == EXTENSION => {}
            OP_MEMORY_MODEL => plain.extend([instruction[0], operands[0], GLSL450]),
            _ => plain.extend(instruction),
        }
    }
    Cow::Owned(plain)
}

/// Whether an instruction may mean something else in the other model: what has
/// a scope or says who sees a write, and everything with images, whose operands
/// may.
fn needs_vulkan(instruction: &[u32]) -> bool {
    // Volatile, Aligned and Nontemporal are in both models.
    let says = |operands: Option<&[u32]>| {
        operands.is_some_and(|operands| operands.iter().any(|operand| operand & !7 != 0))
    };
    match instruction[0] & 0xffff {
        OP_LOAD => says(instruction.get(4..5)),
        OP_STORE => says(instruction.get(3..4)),
        OP_COPY_MEMORY => says(instruction.get(3..)),
        OP_COPY_MEMORY_SIZED => says(instruction.get(4..)),
        // Images; barriers and atomics; groups; capabilities and types of
        // extensions that come with a scope.
        86..=107 | 224..=242 | 259..=320 | 333..=366 | 4416.. => true,
        OP_CAPABILITY => instruction[1..] == [VULKAN_MEMORY_MODEL + 1],
        _ => false,
    }
}

/// The instructions of words whose lengths are right; those after a wrong one
/// come as one.
struct Instructions<'a> {
    rest: &'a [u32],
}

impl<'a> Iterator for Instructions<'a> {
    type Item = &'a [u32];

    fn next(&mut self) -> Option<&'a [u32]> {
        let length = (self.rest.first()? >> 16) as usize;
        let length = if length == 0 { self.rest.len() } else { length };
        let (instruction, rest) = self.rest.split_at(length.min(self.rest.len()));
        self.rest = rest;
        Some(instruction)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A header of five words and these instructions, of opcode and operands.
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
    fn what_nothing_needs_is_not_declared() {
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
        assert_eq!(plain(&declared(&[plain_load]), 5), expected);
        // Once more, there is nothing left to do.
        assert_eq!(plain(&expected, 5), expected);
        // A load that others see, a store, a copy, a barrier, an atomic.
        let needs: [(u32, &[u32]); 5] = [
            (OP_LOAD, &[1, 2, 3, 0x20]),
            (OP_STORE, &[1, 2, 0x28, 9]),
            (OP_COPY_MEMORY, &[1, 2, 0, 0x20]),
            (224, &[1, 2, 3]),
            (234, &[1, 2, 3, 4, 5, 6]),
        ];
        for needed in needs {
            let words = declared(&[plain_load, needed]);
            assert_eq!(plain(&words, 5), words, "{needed:?}");
        }
    }

    #[test]
    fn any_words_end() {
        for words in [vec![], vec![0; 3], vec![7; 9], vec![0; 9]] {
            assert_eq!(plain(&words, 5), words);
        }
    }
}
