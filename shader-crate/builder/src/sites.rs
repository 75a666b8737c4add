//! Where operations come from: finds what is refused in the module before it is optimised,
//! since that has lines, and divisions and roots outside the files that correct them.

use crate::advice::{self, Advice};
use crate::allowed::Operation;
use crate::debug::{DebugInfo, Position, positions};
use crate::packages::Packages;
use crate::panics::{Frame, Panic};
use crate::refusal::Site;
use crate::words::{Instruction, instructions};
use anyhow::Result;
use std::collections::{BTreeMap, BTreeSet};

/// `OpFunction`.
const FUNCTION: u32 = 54;
/// `OpTypeFloat`.
const TYPE_FLOAT: u32 = 22;

/// A module and what its lines say.
struct Lines<'a> {
    all: Vec<Instruction<'a>>,
    positions: Vec<Option<Position>>,
    info: DebugInfo,
    /// The files of `positions`, and whether they are the user's.
    local: BTreeMap<u32, bool>,
    packages: &'a Packages,
}

impl<'a> Lines<'a> {
    fn read(module: &'a [u32], packages: &'a Packages) -> Result<Lines<'a>> {
        let all = instructions(module)?;
        let positions = positions(&all);
        let info = DebugInfo::read(&all);
        let files: BTreeSet<u32> = positions.iter().flatten().map(|p| p.file).collect();
        let local = files
            .into_iter()
            .map(|file| {
                (
                    file,
                    info.string(file).is_some_and(|f| packages.is_local(f)),
                )
            })
            .collect();
        Ok(Lines {
            all,
            positions,
            info,
            local,
            packages,
        })
    }

    fn is_local(&self, position: Position) -> bool {
        self.local.get(&position.file).copied().unwrap_or(false)
    }

    /// Returns the ids of the files that may divide.
    fn native(&self) -> BTreeSet<u32> {
        self.local
            .keys()
            .copied()
            .filter(|&file| {
                let path = self.info.string(file);
                path.is_some_and(|path| self.packages.may_divide(path))
            })
            .collect()
    }

    fn shown_file(&self, position: Position) -> String {
        match self.info.string(position.file) {
            Some(file) => self.packages.describe(file),
            None => "an unnamed file".to_string(),
        }
    }

    fn shown_line(&self, position: Position) -> String {
        format!("{}:{}", self.shown_file(position), position.line)
    }

    fn code(&self, position: Position) -> Option<String> {
        self.info.line(position).map(str::to_string)
    }

    /// Returns what to show of the instruction at `index`.
    fn site(&self, index: usize) -> Site {
        let position = self.positions[index];
        if let Some(position) = position.filter(|&position| self.is_local(position)) {
            return Site {
                at: Some(format!(
                    "{}:{}",
                    self.shown_line(position),
                    position.column + 1
                )),
                function: self.info.function(position).map(str::to_string),
                code: self.code(position).into_iter().collect(),
                through: None,
            };
        }
        let own = self.callers(index);
        let lines: Vec<String> = own.iter().map(|&p| self.shown_line(p)).collect();
        Site {
            at: Some(lines.join(" or ")).filter(|at| !at.is_empty()),
            function: own
                .first()
                .and_then(|&p| self.info.function(p))
                .map(str::to_string),
            code: own.iter().filter_map(|&p| self.code(p)).collect(),
            through: position.map(|p| format!("{}:{}", self.shown_line(p), p.column + 1)),
        }
    }

    /// Returns the user's own lines before and after the instruction at `index`: one of
    /// them called the library.
    fn callers(&self, index: usize) -> Vec<Position> {
        let own = |i: usize| self.positions[i].filter(|&position| self.is_local(position));
        let is_within = |i: &usize| self.all[*i].opcode != FUNCTION;
        let before = (0..index).rev().take_while(is_within).find_map(own);
        let after = (index..self.all.len()).take_while(is_within).find_map(own);
        let mut found: Vec<Position> = before.into_iter().chain(after).collect();
        found.dedup_by_key(|position| (position.file, position.line));
        found
    }
}

/// Returns what to say about an operation.
fn advice(operation: Operation) -> Advice {
    match operation {
        Operation::Instruction(opcode) => advice::of_instruction(opcode),
        Operation::Driver(number) => advice::of_driver(number),
        Operation::Float(width) => advice::of_float(width),
    }
}

/// Returns the places in `module`, which still has lines, of the operations in `wrong`,
/// and of divisions and roots outside the files that may contain them.
pub fn of_operations(
    module: &[u32],
    wrong: &BTreeSet<Operation>,
    packages: &Packages,
) -> Result<Vec<(Advice, Site)>> {
    let lines = Lines::read(module, packages)?;
    let native = lines.native();
    let mut found = Vec::new();
    let mut seen = BTreeSet::new();
    for (index, instruction) in lines.all.iter().enumerate() {
        let operation = Operation::of(instruction);
        let outside = || lines.positions[index].is_none_or(|p| !native.contains(&p.file));
        let is_stray = || operation.is_corrected() && outside();
        if wrong.contains(&operation) || is_stray() {
            seen.insert(operation);
            // A type has no line; its first use has.
            let index = if instruction.opcode == TYPE_FLOAT {
                first_use(&lines, instruction.words[1]).unwrap_or(index)
            } else {
                index
            };
            found.push((advice(operation), lines.site(index)));
        }
    }
    // What only the optimiser has made has no place.
    for &operation in wrong.difference(&seen) {
        found.push((advice(operation), Site::default()));
    }
    Ok(found)
}

/// Returns the first instruction with a line whose result has this type.
fn first_use(lines: &Lines<'_>, type_id: u32) -> Option<usize> {
    (0..lines.all.len())
        .find(|&i| lines.positions[i].is_some() && lines.all[i].words.get(1) == Some(&type_id))
}

/// Returns what to say about the panics of a module, and the user's own lines that lead to
/// them. `module` has lines, and `panics` those that its optimiser has left.
pub fn of_panics(
    module: &[u32],
    panics: &[Panic],
    packages: &Packages,
) -> Result<Vec<(Advice, Site)>> {
    let info = DebugInfo::read(&instructions(module)?);
    Ok(panics
        .iter()
        .map(|panic| {
            (
                advice::of_panic(&panic.message),
                panic_site(panic, &info, packages),
            )
        })
        .collect())
}

fn panic_site(panic: &Panic, info: &DebugInfo, packages: &Packages) -> Site {
    let show = |frame: &Frame| {
        let file = packages.describe(&frame.file);
        format!("{file}:{}:{}", frame.line, frame.column)
    };
    let own = panic
        .frames
        .iter()
        .position(|frame| packages.is_local(&frame.file));
    let Some(frame) = panic.frames.get(own.unwrap_or(0)) else {
        return Site::default();
    };
    Site {
        at: Some(show(frame)),
        function: Some(frame.function.clone()),
        code: info
            .position(&frame.file, frame.line)
            .and_then(|position| info.line(position))
            .map(str::to_string)
            .into_iter()
            .collect(),
        through: panic.frames.first().filter(|_| own > Some(0)).map(show),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::words::tests::{Words, literal};

    const DRIVER: u32 = 12;
    const F_DIV: u32 = 136;

    /// A module of divisions and roots, each with the file of its line; 0 is none.
    fn module(operations: &[(u32, u32)]) -> Vec<u32> {
        let mut words = Words::new();
        words.put(
            7,
            &[&[1], &literal("shared/exact/src/native.rs")[..]].concat(),
        );
        words.put(7, &[&[2], &literal("src/native.rs")[..]].concat());
        words.put(TYPE_FLOAT, &[3, 32]);
        words.put(FUNCTION, &[4, 5, 0, 6]);
        words.put(248, &[7]);
        for &(opcode, file) in operations {
            if file == 0 {
                words.put(317, &[]);
            } else {
                words.put(8, &[file, opcode, 4]);
            }
            match opcode {
                DRIVER => words.put(DRIVER, &[3, 8, 9, 31, 8]),
                _ => words.put(opcode, &[3, 8, 8, 8]),
            }
        }
        words.0
    }

    fn refused(operations: &[(u32, u32)]) -> Vec<Option<String>> {
        let packages = Packages::with_native("shared/exact/src/native.rs");
        of_operations(&module(operations), &BTreeSet::new(), &packages)
            .unwrap()
            .into_iter()
            .map(|(_, site)| site.at)
            .collect()
    }

    #[test]
    fn divisions_and_roots_are_allowed_in_one_file() {
        assert_eq!(refused(&[(F_DIV, 1), (DRIVER, 1), (129, 2)]), []);
    }

    #[test]
    fn elsewhere_and_without_a_line_they_are_refused() {
        assert_eq!(
            refused(&[(F_DIV, 2), (F_DIV, 1), (DRIVER, 2), (DRIVER, 0)]),
            [
                Some("src/native.rs:136:5".to_string()),
                Some("src/native.rs:12:5".to_string()),
                // The line before it.
                Some("src/native.rs:12".to_string()),
            ]
        );
    }

    #[test]
    fn what_the_optimiser_made_is_refused_without_a_place() {
        let packages = Packages::with_native("shared/exact/src/native.rs");
        let wrong = BTreeSet::from([Operation::Instruction(148)]);
        let found = of_operations(&module(&[]), &wrong, &packages).unwrap();
        assert_eq!(found.len(), 1);
        assert!(found[0].0.what.contains("OpDot"));
        assert_eq!(found[0].1, Site::default());
    }
}
