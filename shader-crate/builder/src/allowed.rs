//! The allow-list: which operations the exact module may contain.

use crate::words::Instruction;

mod op {
    pub const EXT_INST: u32 = 12;
    pub const TYPE_FLOAT: u32 = 22;
    pub const F_NEGATE: u32 = 127;
    pub const F_ADD: u32 = 129;
    pub const F_SUB: u32 = 131;
    pub const F_MUL: u32 = 133;
    pub const F_DIV: u32 = 136;
    pub const VECTOR_TIMES_SCALAR: u32 = 142;
}

/// Float operations allowed in the exact module. Rounding of others (FRem, Dot, matrix
/// products) differs between devices.
pub const ARITHMETIC: [u32; 6] = [
    op::F_NEGATE,
    op::F_ADD,
    op::F_SUB,
    op::F_MUL,
    op::F_DIV,
    op::VECTOR_TIMES_SCALAR,
];

/// The driver's functions, of which the exact module may contain the square root and the
/// fused sum.
pub const DRIVER_SET: &str = "GLSL.std.450";
const SQRT: u32 = 31;
const FMA: u32 = 50;

/// Opcodes allowed in the exact module beside [`ARITHMETIC`], [`SQRT`] and [`FMA`]:
/// structure, integers, comparisons, control flow, and conversions between i32 or u32
/// and f32.
const OTHER: &[u32] = &[
    1, // Undef
    3, 5, 6, // Source, Name, MemberName
    10, 11, // Extension, ExtInstImport
    14, 15, 16, 17, // MemoryModel, EntryPoint, ExecutionMode, Capability
    19, 20, 21, 23, 25, 28, 29, 30, 32, 33, // types
    41, 42, 43, 44, 46, 50, // constants
    54, 55, 56, 57, 59, // functions and variables
    61, 62, 65, 66, // Load, Store, AccessChain, InBoundsAccessChain
    71, 72, // Decorate, MemberDecorate
    79, 80, 81, 82,
    83, // VectorShuffle, CompositeConstruct, CompositeExtract, CompositeInsert, CopyObject
    95, // ImageFetch, of words
    109, 110, 111, 112, // ConvertFToU, ConvertFToS, ConvertSToF, ConvertUToF
    124, // Bitcast
    126, 128, 130, 132, 134, 135, 137, 138, 139, // integer arithmetic
    164, 165, 166, 167, 168, 169, // logic, Select
    170, 171, 172, 173, 174, 175, 176, 177, 178, 179, // integer comparisons
    180, 181, 182, 183, 184, 185, 186, 187, 188, 189, 190, 191, // float comparisons
    194, 195, 196, 197, 198, 199, 200, // shifts and bits
    245, 246, 247, 248, 249, 250, 251, 252, 253, 254, 255, // control flow
];

/// What an operation is, as far as the allow-list asks.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Operation {
    /// An instruction, by its opcode.
    Instruction(u32),
    /// An instruction of the driver's set `GLSL.std.450`, by its number.
    Driver(u32),
    /// A float type, by its width.
    Float(u32),
}

impl Operation {
    /// Returns the operation of an instruction.
    pub fn of(instruction: &Instruction<'_>) -> Operation {
        match instruction.opcode {
            op::EXT_INST => Operation::Driver(instruction.words[4]),
            op::TYPE_FLOAT => Operation::Float(instruction.words[2]),
            opcode => Operation::Instruction(opcode),
        }
    }

    /// Returns whether the exact module may contain it.
    pub fn is_allowed(self) -> bool {
        match self {
            Operation::Instruction(opcode) => {
                ARITHMETIC.contains(&opcode) || OTHER.contains(&opcode)
            }
            Operation::Driver(number) => matches!(number, SQRT | FMA),
            Operation::Float(width) => width == 32,
        }
    }

    /// Returns whether it is allowed only where results are corrected.
    pub fn is_corrected(self) -> bool {
        matches!(
            self,
            Operation::Instruction(op::F_DIV) | Operation::Driver(SQRT | FMA)
        )
    }
}
