//! What is wrong with an operation, in words, and what to write instead.

use spirv::{GlslStd450Op, Op};

/// What a refusal says about an operation.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub struct Advice {
    /// The operation: what Rust calls it, and its name in SPIR-V.
    pub what: String,
    /// Why it is refused.
    pub why: &'static str,
    /// What to write instead.
    pub instead: &'static str,
}

/// Why most operations are refused.
const ROUNDED: &str = "devices round it differently";

/// The words of an exact program.
const ALLOWED: &str = "+, -, *, comparisons, casts between f32 and i32 or u32, integer operations, and the functions of relievo_exact";

/// Returns the name of an operation in SPIR-V.
fn name(opcode: u32) -> String {
    match Op::from_u32(opcode) {
        Some(op) => format!("Op{op:?}"),
        None => format!("opcode {opcode}"),
    }
}

/// Returns what to say about an instruction that is not on the allow-list.
pub fn of_instruction(opcode: u32) -> Advice {
    let (what, why, instead) = match Op::from_u32(opcode) {
        Some(Op::FDiv) => (
            "`/` of floats",
            "a device may err by 2.5 ULP",
            "relievo_exact::div(a, b), for each component of a vector; a `const` for a quotient of literals",
        ),
        Some(Op::FRem | Op::FMod) => (
            "`%` of floats",
            ROUNDED,
            "x - y * relievo_exact::trunc(relievo_exact::div(x, y))",
        ),
        Some(Op::Dot) => (
            "a dot product of the driver",
            "devices add the products in different orders",
            "the sum of the products: a.x * b.x + a.y * b.y + a.z * b.z",
        ),
        Some(
            Op::MatrixTimesScalar
            | Op::VectorTimesMatrix
            | Op::MatrixTimesVector
            | Op::MatrixTimesMatrix
            | Op::OuterProduct,
        ) => (
            "a matrix product of the driver",
            "devices add the products in different orders",
            "the sums of the products, by components",
        ),
        Some(Op::ArrayLength) => (
            "the length of a buffer",
            "it is what the host happens to bind, and the CPU does not see it",
            "a length that the host writes into a buffer; read elements with spirv_std::arch::IndexUnchecked, since a checked index asks for the length",
        ),
        Some(Op::FConvert) => (
            "a conversion between widths of floats",
            "not every device has f64 or f16",
            "f32 throughout",
        ),
        Some(Op::UConvert | Op::SConvert) => (
            "a conversion between widths of integers",
            "not every device has other widths than 32",
            "u32 or i32 throughout",
        ),
        Some(
            Op::DPdx
            | Op::DPdy
            | Op::Fwidth
            | Op::DPdxFine
            | Op::DPdyFine
            | Op::FwidthFine
            | Op::DPdxCoarse
            | Op::DPdyCoarse
            | Op::FwidthCoarse,
        ) => (
            "a derivative",
            "a device chooses the pixels that it subtracts",
            "the derivative of the formula itself",
        ),
        Some(
            Op::ImageSampleImplicitLod
            | Op::ImageSampleExplicitLod
            | Op::ImageSampleDrefImplicitLod
            | Op::ImageSampleDrefExplicitLod
            | Op::ImageGather,
        ) => (
            "a filtered sample of a texture",
            "devices interpolate with few bits",
            "a fetch of the texels, interpolated with + and *",
        ),
        _ => (
            "an operation",
            "it is not on the list of exact ones",
            ALLOWED,
        ),
    };
    Advice {
        what: format!("{what} ({})", name(opcode)),
        why,
        instead,
    }
}

/// Returns what to say about an instruction of the extended set `GLSL.std.450`, which the
/// driver implements as it likes.
pub fn of_driver(number: u32) -> Advice {
    use GlslStd450Op as Gl;
    let op = Gl::from_u32(number);
    let (what, instead) = match op {
        Some(Gl::Sqrt) => (
            "the square root",
            "relievo_exact::sqrt(x); relievo_exact::length(v) or normalize_or(v, fallback) of a vector",
        ),
        Some(Gl::InverseSqrt) => ("the reciprocal square root", "relievo_exact::recip_sqrt(x)"),
        Some(Gl::Length | Gl::Distance) => ("the length", "relievo_exact::length(v)"),
        Some(Gl::Normalize) => ("`normalize`", "relievo_exact::normalize_or(v, fallback)"),
        Some(Gl::Cross) => ("the cross product", "its three components, with * and -"),
        Some(Gl::Sin) => ("`sin`", "relievo_exact::sin(x)"),
        Some(Gl::Cos) => ("`cos`", "relievo_exact::cos(x)"),
        Some(Gl::Tan) => ("`tan`", "relievo_exact::tan(x)"),
        Some(Gl::Asin) => ("`asin`", "relievo_exact::asin(x)"),
        Some(Gl::Acos) => ("`acos`", "relievo_exact::acos(x)"),
        Some(Gl::Atan) => ("`atan`", "relievo_exact::atan(x)"),
        Some(Gl::Atan2) => ("`atan2`", "relievo_exact::atan2(y, x)"),
        Some(Gl::Pow) => (
            "`powf`",
            "relievo_exact::pow(x, y), or products for a whole exponent",
        ),
        Some(Gl::Exp) => ("`exp`", "relievo_exact::exp(x)"),
        Some(Gl::Exp2) => ("`exp2`", "relievo_exact::exp2(x)"),
        Some(Gl::Log) => ("`ln`", "relievo_exact::log(x)"),
        Some(Gl::Log2) => ("`log2`", "relievo_exact::log2(x)"),
        Some(Gl::Round | Gl::RoundEven) => ("`round`", "relievo_exact::round(x)"),
        Some(Gl::Trunc) => ("`trunc`", "relievo_exact::trunc(x)"),
        Some(Gl::Floor) => ("`floor`", "relievo_exact::floor(x)"),
        Some(Gl::Ceil) => ("`ceil`", "relievo_exact::ceil(x)"),
        Some(Gl::Fract) => ("`fract`", "relievo_exact::fract(x)"),
        Some(Gl::FAbs) => ("`abs`", "relievo_exact::abs(x)"),
        Some(Gl::FSign) => ("`signum`", "comparisons with 0.0"),
        Some(Gl::FMin | Gl::NMin | Gl::UMin | Gl::SMin) => ("`min`", "relievo_exact::min(a, b)"),
        Some(Gl::FMax | Gl::NMax | Gl::UMax | Gl::SMax) => ("`max`", "relievo_exact::max(a, b)"),
        Some(Gl::FClamp | Gl::NClamp | Gl::UClamp | Gl::SClamp) => {
            ("`clamp`", "relievo_exact::clamp(x, low, high)")
        }
        Some(Gl::FMix) => ("`mix`", "a + (b - a) * t"),
        Some(Gl::Fma) => (
            "`mul_add`",
            "a * b + c, which is rounded twice on both sides",
        ),
        _ => ("a function", ALLOWED),
    };
    let name = op.map_or_else(|| format!("{number}"), |op| format!("{op:?}"));
    Advice {
        what: format!("{what} of the driver (GLSL.std.450 {name})"),
        why: match op {
            Some(Gl::Sqrt) => "a device may err by 3 ULP",
            Some(Gl::Fma) => "a device may round once or twice",
            Some(Gl::FAbs | Gl::FMin | Gl::NMin | Gl::FMax | Gl::NMax) => {
                "devices treat NaN, denormals and the sign of zero differently"
            }
            _ => ROUNDED,
        },
        instead,
    }
}

/// Returns what to say about a float type of a width that is not 32.
pub fn of_float(width: u32) -> Advice {
    Advice {
        what: format!("f{width} (OpTypeFloat {width})"),
        why: "not every device has it",
        instead: "f32; for more digits, a sum of two f32, or u32 in fixed point",
    }
}

/// Returns what to say about a panic with this message.
pub fn of_panic(message: &str) -> Advice {
    let (what, instead) = if message.starts_with("index out of bounds") {
        (
            "a checked index",
            "take an array apart: let [a, b, c] = x. Of a buffer, limit the index yourself and read with spirv_std::arch::IndexUnchecked: unsafe { *words.index_unchecked(i) }. A check that the optimiser can decide, such as that of a constant, is allowed",
        )
    } else if message.contains("hint::unreachable_unchecked") {
        (
            "a loop over a range of i32, whose steps the optimiser cannot prove",
            "count with u32, for i in 0..20_u32, or with while",
        )
    } else if message.starts_with("attempt to divide by zero")
        || message.starts_with("attempt to calculate the remainder with a divisor of zero")
    {
        (
            "a checked division of integers",
            "a.checked_div(b).unwrap_or(0), or checked_rem, or a constant divisor",
        )
    } else if message.starts_with("min > max") {
        (
            "`clamp`, which panics if low > high",
            "relievo_exact::clamp(x, low, high)",
        )
    } else if message.contains("::unwrap()") {
        (
            "`unwrap`",
            "unwrap_or with a value, or a flag beside the value",
        )
    } else {
        (
            "a panic",
            "a result with a flag, or code that gives a value for every input",
        )
    };
    Advice {
        what: format!(
            "{what} (“{}”)",
            message.replace("%u", "…").replace("%f", "…")
        ),
        why: "the CPU stops with an error, a shader returns and leaves the results unwritten",
        instead,
    }
}

/// Returns what to say about an error of rust-gpu, if it is one of those that exact
/// programs meet.
pub fn of_rust_gpu(message: &str) -> Option<&'static str> {
    const KNOWN: [(&str, &str); 5] = [
        (
            "module has recursion",
            "a shader cannot call itself: write a loop, with a stack in an array of fixed length if it needs one",
        ),
        (
            "`f64` type used without",
            "exact programs are in f32: for more digits, write a sum of two f32, or u32 in fixed point",
        ),
        (
            "`f16` type used without",
            "exact programs are in f32, and pack two halves into a u32",
        ),
        (
            "type used without `OpCapability Int",
            "exact programs are in u32 and i32: multiply by halves for wider products, and pack narrower numbers by shifts",
        ),
        (
            "indirect calls are not supported",
            "a shader has no trait objects and no function pointers: take a type parameter, or `match` on a number",
        ),
    ];
    KNOWN
        .iter()
        .find(|(start, _)| message.contains(start))
        .map(|&(_, advice)| advice)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn operations_are_named_in_words() {
        assert_eq!(of_instruction(140).what, "`%` of floats (OpFRem)");
        assert_eq!(of_instruction(60_000).what, "an operation (opcode 60000)");
        assert_eq!(of_driver(13).what, "`sin` of the driver (GLSL.std.450 Sin)");
        assert_eq!(of_float(64).what, "f64 (OpTypeFloat 64)");
    }

    #[test]
    fn only_known_errors_have_advice() {
        let error = "error: `u64` type used without `OpCapability Int64`";
        assert!(of_rust_gpu(error).unwrap().contains("u32"));
        assert_eq!(of_rust_gpu("error[E0308]: mismatched types"), None);
    }
}
