//! What the debug information of a module says: files, lines and source text.
//!
//! rust-gpu writes `OpLine` for every instruction, whatever metadata is asked for;
//! spirv-opt strips it later. An `OpLine` names the innermost function: the lines of its
//! callers are lost where rust-gpu has inlined it.

use crate::words::{Instruction, text};
use std::collections::BTreeMap;

mod op {
    pub const SOURCE_CONTINUED: u32 = 2;
    pub const SOURCE: u32 = 3;
    pub const STRING: u32 = 7;
    pub const LINE: u32 = 8;
    pub const LABEL: u32 = 248;
    pub const NO_LINE: u32 = 317;
}

/// A line and a column of a file, as `OpLine` gives them.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub struct Position {
    /// The id of the file's `OpString`.
    pub file: u32,
    /// The line, from 1.
    pub line: u32,
    /// The column, from 0.
    pub column: u32,
}

/// The strings and source texts of a module.
pub struct DebugInfo {
    strings: BTreeMap<u32, String>,
    sources: BTreeMap<u32, String>,
}

impl DebugInfo {
    /// Reads the debug information of a module.
    pub fn read(all: &[Instruction<'_>]) -> DebugInfo {
        let mut info = DebugInfo {
            strings: BTreeMap::new(),
            sources: BTreeMap::new(),
        };
        let mut open = None;
        for instruction in all {
            let words = instruction.words;
            match instruction.opcode {
                op::STRING => {
                    info.strings.insert(words[1], text(&words[2..]));
                }
                op::SOURCE if words.len() > 4 => {
                    open = Some(words[3]);
                    info.sources.insert(words[3], text(&words[4..]));
                }
                op::SOURCE_CONTINUED => {
                    if let Some(source) = open.and_then(|file| info.sources.get_mut(&file)) {
                        source.push_str(&text(&words[1..]));
                    }
                }
                _ => {}
            }
        }
        info
    }

    /// Returns the string with an id: the path of a file, or a message.
    pub fn string(&self, id: u32) -> Option<&str> {
        self.strings.get(&id).map(String::as_str)
    }

    /// Returns the position of the start of a line of a file.
    pub fn position(&self, path: &str, line: u32) -> Option<Position> {
        let (&file, _) = self
            .strings
            .iter()
            .find(|(file, string)| *string == path && self.sources.contains_key(file))?;
        Some(Position {
            file,
            line,
            column: 0,
        })
    }

    /// Returns the source line at a position, without the space around it.
    pub fn line(&self, position: Position) -> Option<&str> {
        let source = self.sources.get(&position.file)?;
        let line = source.lines().nth(position.line.checked_sub(1)? as usize)?;
        Some(line.trim()).filter(|line| !line.is_empty())
    }

    /// Returns the name of the last function that starts at or above a position.
    pub fn function(&self, position: Position) -> Option<&str> {
        let source = self.sources.get(&position.file)?;
        let above: Vec<&str> = source.lines().take(position.line as usize).collect();
        above.iter().rev().find_map(|line| function_of(line))
    }
}

/// Returns the name of the function that a source line starts.
fn function_of(line: &str) -> Option<&str> {
    let line = line.trim_start();
    let start = if line.starts_with("fn ") {
        3
    } else {
        line.find(" fn ")? + 4
    };
    if line.starts_with("//") {
        return None;
    }
    let name = &line[start..];
    let end = name.find(|c: char| !c.is_alphanumeric() && c != '_')?;
    (end > 0).then(|| &name[..end])
}

/// Returns the position of each instruction: that of the `OpLine` in force. None is in
/// force at the start of a block.
pub fn positions(all: &[Instruction<'_>]) -> Vec<Option<Position>> {
    let mut position = None;
    all.iter()
        .map(|instruction| {
            match instruction.opcode {
                op::LINE => {
                    position = Some(Position {
                        file: instruction.words[1],
                        line: instruction.words[2],
                        column: instruction.words[3],
                    });
                }
                op::NO_LINE | op::LABEL => position = None,
                _ => {}
            }
            position
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::words::instructions;
    use crate::words::tests::{Words, literal};

    #[test]
    fn a_line_holds_until_the_next_or_the_end_of_its_block() {
        let mut words = Words::new();
        words.put(op::LABEL, &[9]);
        words.put(op::LINE, &[1, 8, 4]);
        words.put(136, &[2, 10, 3, 3]);
        words.put(136, &[2, 11, 3, 3]);
        words.put(op::NO_LINE, &[]);
        words.put(136, &[2, 12, 3, 3]);
        words.put(op::LINE, &[1, 8, 4]);
        words.put(op::LABEL, &[13]);
        words.put(136, &[2, 14, 3, 3]);
        let all = instructions(&words.0).unwrap();
        let lines: Vec<Option<u32>> = all
            .iter()
            .zip(positions(&all))
            .filter(|(instruction, _)| instruction.opcode == 136)
            .map(|(_, position)| position.map(|position| position.line))
            .collect();
        assert_eq!(lines, [Some(8), Some(8), None, None]);
    }

    #[test]
    fn source_texts_name_line_and_function() {
        let mut words = Words::new();
        let name = literal("src/lib.rs");
        words.put(op::STRING, &[&[1], &name[..]].concat());
        let text = literal("/// A fn in words.\npub fn half(x: f32) -> f32 {\n    x / 2.0");
        words.put(op::SOURCE, &[&[0, 0, 1], &text[..]].concat());
        words.put(op::SOURCE_CONTINUED, &literal("0 }\n"));
        let all = instructions(&words.0).unwrap();
        let info = DebugInfo::read(&all);
        let at = |line| Position {
            file: 1,
            line,
            column: 0,
        };
        assert_eq!(info.string(1), Some("src/lib.rs"));
        assert_eq!(info.line(at(3)), Some("x / 2.00 }"));
        assert_eq!(info.function(at(3)), Some("half"));
        assert_eq!(info.function(at(1)), None);
        assert_eq!(info.line(at(9)), None);
        assert_eq!(info.position("src/lib.rs", 3), Some(at(3)));
        assert_eq!(info.position("src/main.rs", 3), None);
    }
}
