//! The instructions of a SPIR-V module, and literals in them.

/// First word of every module (SPIR-V specification, "Physical Layout of a
/// SPIR-V Module").
pub const MAGIC: u32 = 0x0723_0203;
/// Number of words before the first instruction.
pub const HEADER: usize = 5;

/// Returns the instructions of a module, each with its opcode and length in the
/// first word. Words after a length of 0 or beyond the end come as one
/// instruction.
pub fn instructions(words: &[u32]) -> impl Iterator<Item = &[u32]> {
    let mut rest = words.get(HEADER..).unwrap_or_default();
    std::iter::from_fn(move || {
        let length = (rest.first()? >> 16) as usize;
        let length = if length == 0 { rest.len() } else { length };
        let (instruction, after) = rest.split_at(length.min(rest.len()));
        rest = after;
        Some(instruction)
    })
}

/// Returns the opcode of an instruction.
pub fn opcode(instruction: &[u32]) -> u32 {
    instruction[0] & 0xffff
}

/// Reads the literal string at the start of `words`: UTF-8 in little-endian
/// words, terminated by a 0 byte.
pub fn literal(words: &[u32]) -> String {
    let bytes: Vec<u8> = words
        .iter()
        .flat_map(|word| word.to_le_bytes())
        .take_while(|&byte| byte != 0)
        .collect();
    String::from_utf8_lossy(&bytes).into_owned()
}
