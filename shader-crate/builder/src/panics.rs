//! Panics: found where rust-gpu would report them, and removed.
//!
//! A panic ends a shader without a word, and rust-gpu leaves no trace of it in the module.
//! So exact modules are compiled with its reports (`debugPrintf`), whose texts name the
//! message and all callers. Reports that the optimiser cannot prove dead are refused. The
//! others are removed before the module is made.

use crate::words::{HEADER, Instruction, instructions, text};
use anyhow::Result;
use rspirv::binary::Assemble;
use rspirv::dr::Loader;
use std::collections::{BTreeSet, HashMap};

mod op {
    pub const STRING: u32 = 7;
    pub const EXTENSION: u32 = 10;
    pub const EXT_INST_IMPORT: u32 = 11;
    pub const EXT_INST: u32 = 12;
}

const SET: &str = "NonSemantic.DebugPrintf";
const EXTENSION: &str = "SPV_KHR_non_semantic_info";

/// A panic that a shader may reach.
#[derive(PartialEq, Eq, Debug)]
pub struct Panic {
    /// Its message, with `%u` and the like for values.
    pub message: String,
    /// Where it is, then where the functions around it are called, innermost first.
    pub frames: Vec<Frame>,
}

/// A place within a function.
#[derive(PartialEq, Eq, Debug)]
pub struct Frame {
    /// The function's path.
    pub function: String,
    /// The file, as rustc names it.
    pub file: String,
    /// The line, from 1.
    pub line: u32,
    /// The column, from 1.
    pub column: u32,
}

/// Splits `file:line:column`.
fn split(place: &str) -> Option<(&str, u32, u32)> {
    let (rest, column) = place.rsplit_once(':')?;
    let (file, line) = rest.rsplit_once(':')?;
    Some((file, line.parse().ok()?, column.parse().ok()?))
}

/// Reads a report as rust-gpu writes it with the option for backtraces.
fn parse(report: &str) -> Option<Panic> {
    let mut lines = report.trim().lines();
    let first = lines.next()?.strip_prefix("[Rust panicked at ")?;
    let mut place = split(first.strip_suffix(']')?);
    let mut message = Vec::new();
    let mut frames = Vec::new();
    for line in lines {
        // Lines of the message are indented less.
        let caller = ["      in ", "      by ", "      called by "]
            .iter()
            .find_map(|start| line.strip_prefix(start));
        if let Some(called) = line.strip_prefix("        called at ") {
            place = split(called);
        } else if let (Some(function), Some((file, line, column))) = (caller, place) {
            frames.push(Frame {
                function: function.to_string(),
                file: file.to_string(),
                line,
                column,
            });
        } else {
            message.push(line.trim());
        }
    }
    // The last is the entry point, whose "call" has no place of its own.
    frames.pop();
    Some(Panic {
        message: message.join(" "),
        frames,
    })
}

/// Returns the id of the set of reports, if the module has it.
fn set(all: &[Instruction<'_>]) -> Option<u32> {
    all.iter()
        .find(|i| i.opcode == op::EXT_INST_IMPORT && text(&i.words[2..]) == SET)
        .map(|i| i.words[1])
}

fn is_report(instruction: &Instruction<'_>, set: Option<u32>) -> bool {
    instruction.opcode == op::EXT_INST && Some(instruction.words[3]) == set
}

/// Returns the ids of the strings of reports.
fn texts(all: &[Instruction<'_>], set: Option<u32>) -> BTreeSet<u32> {
    all.iter()
        .filter(|instruction| is_report(instruction, set))
        .map(|instruction| instruction.words[5])
        .collect()
}

/// Returns whether a module reports panics.
pub fn are_in(module: &[u32]) -> Result<bool> {
    let all = instructions(module)?;
    let set = set(&all);
    Ok(all.iter().any(|instruction| is_report(instruction, set)))
}

/// Returns the panics of a module.
pub fn of(module: &[u32]) -> Result<Vec<Panic>> {
    let all = instructions(module)?;
    let set = set(&all);
    let texts = texts(&all, set);
    Ok(all
        .iter()
        .filter(|i| i.opcode == op::STRING && texts.contains(&i.words[1]))
        .map(|i| {
            let report = text(&i.words[2..]);
            parse(&report).unwrap_or(Panic {
                message: report,
                frames: Vec::new(),
            })
        })
        .collect())
}

/// Returns the module without reports, their texts and their extension. Ids are numbered
/// anew, so that the module is the one that rust-gpu gives without reports.
pub fn remove(module: &[u32]) -> Result<Vec<u32>> {
    let all = instructions(module)?;
    let set = set(&all);
    let texts = texts(&all, set);
    let mut silent = module[..HEADER].to_vec();
    for instruction in &all {
        let goes = match instruction.opcode {
            op::EXTENSION => text(&instruction.words[1..]) == EXTENSION,
            op::EXT_INST_IMPORT => Some(instruction.words[1]) == set,
            op::STRING => texts.contains(&instruction.words[1]),
            _ => is_report(instruction, set),
        };
        if !goes {
            silent.extend(instruction.words);
        }
    }
    if set.is_some() {
        silent = numbered_anew(&silent)?;
    }
    Ok(silent)
}

/// Returns the module with ids numbered by their first use, as rust-gpu numbers them.
fn numbered_anew(module: &[u32]) -> Result<Vec<u32>> {
    let mut loader = Loader::new();
    rspirv::binary::parse_words(module, &mut loader)
        .map_err(|error| anyhow::anyhow!("a module without panics: {error}"))?;
    let mut module = loader.module();
    let mut numbers = HashMap::new();
    let mut renumber = |id: &mut u32| {
        let next = numbers.len() as u32 + 1;
        *id = *numbers.entry(*id).or_insert(next);
    };
    for instruction in module.all_inst_iter_mut() {
        instruction.result_id.iter_mut().for_each(&mut renumber);
        instruction.result_type.iter_mut().for_each(&mut renumber);
        for operand in &mut instruction.operands {
            operand.id_ref_any_mut().into_iter().for_each(&mut renumber);
        }
    }
    let bound = numbers.len() as u32 + 1;
    if let Some(header) = &mut module.header {
        header.bound = bound;
    }
    Ok(module.assemble())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::words::tests::{Words, literal};

    const REPORT: &str = "
[Rust panicked at /rust/library/core/src/option.rs:2248:5]
 called `Option::unwrap()` on a `None` value
      in core::option::unwrap_failed
        called at /rust/library/core/src/option.rs:1014:21
      by <core::option::Option<f32>>::unwrap
        called at src/lib.rs:133:25
      by wrong::unwrap
        called at src/lib.rs:131:8
      by unwrap()
";

    fn frame(function: &str, file: &str, line: u32, column: u32) -> Frame {
        Frame {
            function: function.into(),
            file: file.into(),
            line,
            column,
        }
    }

    #[test]
    fn reports_name_message_and_callers() {
        let core = "/rust/library/core/src/option.rs";
        assert_eq!(
            parse(REPORT),
            Some(Panic {
                message: "called `Option::unwrap()` on a `None` value".into(),
                frames: vec![
                    frame("core::option::unwrap_failed", core, 2248, 5),
                    frame("<core::option::Option<f32>>::unwrap", core, 1014, 21),
                    frame("wrong::unwrap", "src/lib.rs", 133, 25),
                ],
            })
        );
        assert_eq!(parse("something else"), None);
    }

    #[test]
    fn reports_are_found_and_removed() {
        let mut words = Words::new();
        words.put(op::EXTENSION, &literal(EXTENSION));
        words.put(op::EXT_INST_IMPORT, &[&[1], &literal(SET)[..]].concat());
        words.put(
            op::EXT_INST_IMPORT,
            &[&[2], &literal("GLSL.std.450")[..]].concat(),
        );
        words.put(op::STRING, &[&[3], &literal(REPORT)[..]].concat());
        words.put(op::STRING, &[&[4], &literal("src/lib.rs")[..]].concat());
        words.put(19, &[8]);
        words.put(33, &[10, 8]);
        words.put(22, &[11, 32]);
        words.put(43, &[11, 12, 0x4000_0000]);
        words.put(54, &[8, 13, 0, 10]);
        words.put(248, &[14]);
        words.put(op::EXT_INST, &[11, 15, 2, 31, 12]);
        words.put(op::EXT_INST, &[8, 16, 1, 1, 3]);
        words.put(253, &[]);
        words.put(56, &[]);
        let before = instructions(&words.0).unwrap().len();
        assert!(are_in(&words.0).unwrap());
        let found = of(&words.0).unwrap();
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].frames.len(), 3);
        let silent = remove(&words.0).unwrap();
        assert!(!are_in(&silent).unwrap() && of(&silent).unwrap().is_empty());
        // The extension, the set, the text and the report go.
        let left = instructions(&silent).unwrap();
        assert_eq!(left.len(), before - 4);
        // The driver's set is the first id now.
        let root = left.iter().find(|i| i.opcode == op::EXT_INST).unwrap();
        assert_eq!(root.words[3..5], [1, 31]);
        assert!(silent[3] < 16, "{}", silent[3]);
    }
}
