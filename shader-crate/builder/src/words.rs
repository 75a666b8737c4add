//! SPIR-V as words, for the passes over modules.

use anyhow::{Context, Result};
use spirv_tools::TargetEnv;
use spirv_tools::val::{self, Validator};

/// The environment that modules are optimised and validated for.
pub const TARGET: TargetEnv = TargetEnv::Vulkan_1_1;

/// Words before the first instruction of a module.
pub const HEADER: usize = 5;

/// An instruction of a module.
pub struct Instruction<'a> {
    /// The number of the operation.
    pub opcode: u32,
    /// Its words, the first included.
    pub words: &'a [u32],
}

/// Returns the instructions of `module`, in order.
pub fn instructions(module: &[u32]) -> Result<Vec<Instruction<'_>>> {
    let mut found = Vec::new();
    let mut at = HEADER;
    while at < module.len() {
        let count = (module[at] >> 16) as usize;
        let words = module
            .get(at..at + count.max(1))
            .context("the module ends within an instruction")?;
        found.push(Instruction {
            opcode: module[at] & 0xffff,
            words,
        });
        at += count.max(1);
    }
    Ok(found)
}

/// Returns the string in the words of a literal.
pub fn text(words: &[u32]) -> String {
    let bytes: Vec<u8> = words
        .iter()
        .flat_map(|word| word.to_le_bytes())
        .take_while(|&byte| byte != 0)
        .collect();
    String::from_utf8_lossy(&bytes).into_owned()
}

/// Checks that the module is valid SPIR-V for the target.
pub fn validate(module: &[u32]) -> Result<()> {
    val::create(Some(TARGET))
        .validate(module, None)
        .map_err(|error| anyhow::anyhow!("spirv-val: {error}"))
}

#[cfg(test)]
pub(crate) mod tests {
    /// Returns the words of a literal string.
    pub fn literal(text: &str) -> Vec<u32> {
        let mut bytes = text.as_bytes().to_vec();
        bytes.resize((bytes.len() / 4 + 1) * 4, 0);
        bytes
            .chunks_exact(4)
            .map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]]))
            .collect()
    }

    /// A module under construction.
    pub struct Words(pub Vec<u32>);

    impl Words {
        /// The header.
        pub fn new() -> Words {
            Words(vec![0x0723_0203, 0x0001_0300, 0, 100, 0])
        }

        /// Puts an instruction.
        pub fn put(&mut self, opcode: u32, operands: &[u32]) {
            self.0.push((operands.len() as u32 + 1) << 16 | opcode);
            self.0.extend(operands);
        }
    }
}
