//! Sets the specialization constants of a SPIR-V module.

use crate::spirv::{HEADER, instructions, opcode};
use std::borrow::Cow;

const OP_CONSTANT: u32 = 43;
const OP_SPEC_CONSTANT: u32 = 50;
const OP_DECORATE: u32 = 71;
const SPEC_ID: u32 = 1;

/// Returns the words of a module with ordinary constants in place of its specialization
/// constants of 32 bits: of the value in `values`, pairs of an id (`SpecId`) and a value, or else of
/// the module's own. So drivers and naga get a module of the same kind, whether
/// they know specialization constants or not.
pub fn set<'w>(words: &'w [u32], values: &[(u32, u32)]) -> Cow<'w, [u32]> {
    let decorated = |instruction: &[u32]| match *instruction {
        [first, target, SPEC_ID, id] if opcode(&[first]) == OP_DECORATE => Some((target, id)),
        _ => None,
    };
    let ids: Vec<(u32, u32)> = instructions(words).filter_map(decorated).collect();
    if ids.is_empty() {
        return Cow::Borrowed(words);
    }
    let mut set = words[..HEADER].to_vec();
    for instruction in instructions(words) {
        match *instruction {
            [first, ty, result, own] if opcode(&[first]) == OP_SPEC_CONSTANT => {
                let id = ids.iter().find(|(target, _)| *target == result);
                let given = id.and_then(|(_, id)| values.iter().find(|(known, _)| known == id));
                let value = given.map_or(own, |(_, value)| *value);
                set.extend([4 << 16 | OP_CONSTANT, ty, result, value]);
            }
            _ if decorated(instruction).is_some() => {}
            _ => set.extend(instruction),
        }
    }
    Cow::Owned(set)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_get_the_given_value_or_their_own() {
        let header = [7; HEADER];
        let decoration = [4 << 16 | OP_DECORATE, 9, SPEC_ID, 3];
        let constant = |opcode: u32, value: u32| [4 << 16 | opcode, 1, 9, value];
        let words = [&header[..], &decoration, &constant(OP_SPEC_CONSTANT, 5)].concat();
        let expected = |value| [&header[..], &constant(OP_CONSTANT, value)].concat();
        assert_eq!(*set(&words, &[]), expected(5));
        assert_eq!(*set(&words, &[(3, 8)]), expected(8));
        assert_eq!(*set(&words, &[(4, 8)]), expected(5));
        let plain = [&header[..], &constant(OP_CONSTANT, 5)].concat();
        assert!(matches!(set(&plain, &[(3, 8)]), Cow::Borrowed(_)));
    }
}
