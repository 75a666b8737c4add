//! What a compiler for GPUs made of the modules: the rows of `registers.csv`.
//!
//! A test of the repository measures them anew.

use core::fmt;

/// The table: the name of the compiler after `# `, the names of the columns, and a row for
/// each generation of GPUs and module.
pub const REGISTERS: &str = include_str!("registers.csv");

/// A row of [`REGISTERS`]. Registers are those of 32 bits that a wave of 32 or 64 pixels has
/// for itself; vector registers hold a number for each pixel, scalar ones one for all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Compiled<'a> {
    /// The generation of GPUs, such as `"RDNA3"`.
    pub generation: &'a str,
    /// The module's folder.
    pub folder: &'a str,
    /// Its entry point.
    pub entry_point: &'a str,
    /// Vector registers.
    pub vgprs: u32,
    /// Scalar registers that are needed at once.
    pub sgprs: u32,
    /// Vector registers that do not fit, and go to memory.
    pub spilled_vgprs: u32,
    /// Scalar registers that do not fit, and go to vector registers.
    pub spilled_sgprs: u32,
    /// Bytes of memory for a wave.
    pub scratch: u32,
    /// Waves of 32 pixels that a unit of execution (SIMD) holds at once; one of 64 counts as
    /// two. The more, the better it hides the time that memory takes.
    pub waves: u32,
    /// Instructions.
    pub instructions: u32,
    /// Clock cycles from begin to end, estimated with each loop turning a few times.
    pub latency: u32,
    /// Clock cycles that a wave takes from others, estimated likewise.
    pub throughput: u32,
    /// Bytes of code.
    pub bytes: u32,
}

impl Compiled<'static> {
    /// Returns the rows of [`REGISTERS`] for a module, a row for each generation.
    pub fn of(folder: &str, entry_point: &str) -> impl Iterator<Item = Compiled<'static>> {
        Compiled::rows(REGISTERS)
            .filter(move |row| (row.folder, row.entry_point) == (folder, entry_point))
    }
}

impl<'a> Compiled<'a> {
    /// The names of the columns.
    pub const COLUMNS: &'static str = "generation,folder,entry_point,vgprs,sgprs,spilled_vgprs,\
         spilled_sgprs,scratch,waves,instructions,latency,throughput,bytes";

    /// Returns the rows of a table; lines that are none are left out.
    pub fn rows(table: &'a str) -> impl Iterator<Item = Compiled<'a>> {
        table.lines().filter_map(Compiled::row)
    }

    fn row(line: &'a str) -> Option<Compiled<'a>> {
        let mut cells = line.split(',');
        let mut text = || cells.next();
        let (generation, folder, entry_point) = (text()?, text()?, text()?);
        let mut number = || cells.next()?.parse().ok();
        Some(Compiled {
            generation,
            folder,
            entry_point,
            vgprs: number()?,
            sgprs: number()?,
            spilled_vgprs: number()?,
            spilled_sgprs: number()?,
            scratch: number()?,
            waves: number()?,
            instructions: number()?,
            latency: number()?,
            throughput: number()?,
            bytes: number()?,
        })
    }

    /// Whether registers do not fit.
    pub fn spills(&self) -> bool {
        self.spilled_vgprs + self.spilled_sgprs + self.scratch > 0
    }
}

/// The row.
impl fmt::Display for Compiled<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (generation, folder, entry_point) = (self.generation, self.folder, self.entry_point);
        write!(formatter, "{generation},{folder},{entry_point}")?;
        for number in [
            self.vgprs,
            self.sgprs,
            self.spilled_vgprs,
            self.spilled_sgprs,
            self.scratch,
            self.waves,
            self.instructions,
            self.latency,
            self.throughput,
            self.bytes,
        ] {
            write!(formatter, ",{number}")?;
        }
        Ok(())
    }
}
