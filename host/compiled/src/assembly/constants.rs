//! Constants in scalar registers: which of them a register holds before a line, whichever
//! way the program came there.
//!
//! Vector registers are left out: a move writes only those lanes that are active.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;

/// Known constants by the numbers of scalar registers.
pub(super) type Constants = BTreeMap<u32, u32>;

/// Returns the constants before each of the lines of an assembly, which are trimmed and
/// have no comments. A line that nothing leads to has none.
pub(super) fn before(lines: &[&str]) -> Vec<Constants> {
    let labels: BTreeMap<&str, usize> = lines
        .iter()
        .enumerate()
        .filter_map(|(index, line)| Some((line.strip_suffix(':')?, index)))
        .collect();
    let mut before: Vec<Option<Constants>> = vec![None; lines.len()];
    let mut waiting = vec![(0, Constants::new())];
    while let Some((index, state)) = waiting.pop() {
        let Some(slot) = before.get_mut(index) else {
            continue;
        };
        // What every way agrees on.
        let met = match slot {
            None => state,
            Some(old) => {
                let mut both = old.clone();
                both.retain(|register, value| state.get(register) == Some(value));
                if both == *old {
                    continue;
                }
                both
            }
        };
        *slot = Some(met.clone());
        let (name, operands) = split(lines[index]);
        let after = after(lines[index], met);
        if let Some(&target) = operands.first().and_then(|label| labels.get(label)) {
            waiting.push((target, after.clone()));
        }
        if !["s_branch", "s_endpgm"].contains(&name) {
            waiting.push((index + 1, after));
        }
    }
    before.into_iter().map(Option::unwrap_or_default).collect()
}

/// Returns the name and the operands of an instruction.
pub(super) fn split(instruction: &str) -> (&str, Vec<&str>) {
    let (name, rest) = instruction
        .split_once(char::is_whitespace)
        .unwrap_or((instruction, ""));
    (name, rest.split(',').map(str::trim).collect())
}

/// The constants after a line.
fn after(line: &str, before: Constants) -> Constants {
    let mut constants = before.clone();
    for half in line.split("::") {
        let (name, operands) = split(half.trim());
        // These write two results.
        let pairs = ["_co_", "swap", "div_scale", "_u64_u32", "_i64_i32"];
        let is_pair = pairs.iter().any(|part| name.contains(part));
        for result in &operands[..operands.len().min(if is_pair { 2 } else { 1 })] {
            let registers = registers(result);
            constants.retain(|register, _| !registers.contains(register));
        }
        if let ("s_mov_b32", [result, value]) = (name, operands.as_slice())
            && let Some(value) = constant(value, &before)
        {
            let registers = registers(result);
            constants.extend(registers.map(|register| (register, value)));
        }
    }
    constants
}

/// Returns the bits of an operand: a constant, or a register that holds one.
pub(super) fn constant(operand: &str, constants: &Constants) -> Option<u32> {
    if let Some(digits) = operand.strip_prefix("0x") {
        return u32::from_str_radix(digits, 16).ok();
    }
    // A number without a point is an integer.
    if operand.contains('.') {
        return operand.parse().ok().map(f32::to_bits);
    }
    let registers = registers(operand);
    let is_one = registers.start() == registers.end();
    constants.get(registers.start()).copied().filter(|_| is_one)
}

/// The scalar registers of an operand, such as `s4` or `s[4:7]`; an empty range for others.
fn registers(operand: &str) -> RangeInclusive<u32> {
    let numbers = operand.strip_prefix('s').and_then(|rest| {
        let inner = rest
            .strip_prefix('[')
            .and_then(|rest| rest.strip_suffix(']'));
        let (first, last) = match inner {
            Some(inner) => inner.split_once(':')?,
            None => (rest, rest),
        };
        Some(first.parse().ok()?..=last.parse().ok()?)
    });
    #[allow(clippy::reversed_empty_ranges)]
    numbers.unwrap_or(1..=0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn known(assembly: &str, register: u32) -> Option<u32> {
        let lines: Vec<&str> = assembly.lines().collect();
        before(&lines).last().unwrap().get(&register).copied()
    }

    #[test]
    fn constants_are_known_until_they_are_written() {
        assert_eq!(known("s_mov_b32 s4, 0x42000000\nend", 4), Some(0x4200_0000));
        assert_eq!(known("s_mov_b32 s4, 2.0\nend", 4), Some(2.0_f32.to_bits()));
        assert_eq!(known("s_mov_b32 s4, 2\nend", 4), None);
        let copied = "s_mov_b32 s4, 0.5\ns_mov_b32 s20, s4\ns_mov_b32 s4, s5\nend";
        assert_eq!(known(copied, 20), Some(0.5_f32.to_bits()));
        assert_eq!(known(copied, 4), None);
        for write in [
            "s_add_u32 s4, s4, s5",
            "s_load_b128 s[4:7], s[0:1], null",
            "s_load_b128 s[0:7], s[0:1], null",
            "v_readlane_b32 s4, v0, 1",
            "v_add_co_u32 v0, s4, v1, v2",
            "v_cmp_lt_f32_e64 s[4:5], v0, v1",
        ] {
            let text = format!("s_mov_b32 s4, 2.0\n{write}\nend");
            assert_eq!(known(&text, 4), None, "{write}");
        }
        let text = "s_mov_b32 s4, 2.0\nv_mul_f32_e32 v0, s4, v1\nend";
        assert!(known(text, 4).is_some());
    }

    #[test]
    fn every_way_to_a_line_counts() {
        let branch = |other: &str| {
            format!("s_mov_b32 s4, 2.0\ns_cbranch_execz BB1\ns_mov_b32 s4, {other}\nBB1:\nend")
        };
        assert!(known(&branch("2.0"), 4).is_some());
        assert!(known(&branch("0.5"), 4).is_none());
        // Around a loop.
        let looped = |write: &str| {
            format!(
                "s_mov_b32 s4, 2.0\nBB1:\nv_fma_f32 v0, s4, v1, v2\n{write}\ns_cbranch_scc0 BB1\nend"
            )
        };
        let in_loop = |write: &str| {
            let text = looped(write);
            let lines: Vec<&str> = text.lines().collect();
            before(&lines)[2].get(&4).copied()
        };
        assert!(in_loop("s_mov_b32 s5, 1.0").is_some());
        assert!(in_loop("s_mov_b32 s4, 1.0").is_none());
        // Past a jump.
        let past = "s_branch BB2\nBB1:\ns_mov_b32 s4, 2.0\nBB2:\nend";
        assert_eq!(known(past, 4), None);
    }
}
