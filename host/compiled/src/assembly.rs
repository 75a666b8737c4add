//! What is not exact in the assembly of AMD's GPUs, as LLVM writes it.
//!
//! Exact is what every device rounds alike: sums, products, comparisons and conversions of
//! f32. Whatever else works on floats is a fault, known or not: approximations, fused
//! operations, floats of 16 and 64 bits, filtered pictures, other ways of rounding. So is
//! an operation that a module's SPIR-V asks for, if there are more of it than in the SPIR-V.
//! A fused operation is none if one factor is a power of two, as a constant or in a scalar
//! register: its product does not round.
//!
//! ```
//! use relievo_compiled::assembly::{Allowed, faults};
//!
//! let assembly = "v_mul_f32_e32 v0, v1, v2 ; 10000501\n\
//!                 v_fma_f32 v0, 2.0, v1, v2\n\
//!                 v_fma_f32 v0, v3, v1, v2\n";
//! let found = faults(assembly, &Allowed::default());
//! assert_eq!(found, ["v_fma_f32 v0, v3, v1, v2: 1 of 0 fused products that round"]);
//! ```

mod constants;

use crate::Shader;
use constants::{Constants, constant, split};

/// How many of each inexact operation may be in an assembly.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Allowed {
    /// Approximate reciprocals: those of divisions that the module corrects.
    pub reciprocals: usize,
    /// Approximate square roots, likewise.
    pub roots: usize,
    /// Fused multiply-adds whose product rounds.
    pub fused: usize,
}

impl Allowed {
    /// Returns what the SPIR-V of `shader` asks for.
    pub fn asked_by(shader: &Shader) -> Allowed {
        Allowed {
            reciprocals: shader.divisions,
            roots: shader.roots,
            fused: shader.fused,
        }
    }
}

/// Operations on f32 that every device rounds alike, or that do not round.
const EXACT: [&str; 22] = [
    "v_add_f32",
    "v_sub_f32",
    "v_subrev_f32",
    "v_mul_f32",
    "v_min_f32",
    "v_max_f32",
    "v_min3_f32",
    "v_max3_f32",
    "v_med3_f32",
    "v_floor_f32",
    "v_ceil_f32",
    "v_trunc_f32",
    "v_rndne_f32",
    "v_cvt_f32_i32",
    "v_cvt_f32_u32",
    "v_cvt_i32_f32",
    "v_cvt_u32_f32",
    "v_cvt_f32_ubyte0",
    "v_cvt_f32_ubyte1",
    "v_cvt_f32_ubyte2",
    "v_cvt_f32_ubyte3",
    // Reads what a triangle has everywhere: there is nothing to interpolate.
    "v_interp_mov_f32",
];

/// Returns what in an assembly is not exact, but for what is `allowed`: the lines, and why.
pub fn faults(assembly: &str, allowed: &Allowed) -> Vec<String> {
    let mut found = Vec::new();
    let mut seen = Allowed::default();
    for (instruction, constants) in instructions(assembly) {
        let (name, operands) = split(&instruction);
        let (count, most, what) = match kind(name, &operands, &constants) {
            Kind::Exact => continue,
            Kind::Fault(why) => {
                found.push(format!("{instruction}: {why}"));
                continue;
            }
            Kind::Reciprocal => (
                &mut seen.reciprocals,
                allowed.reciprocals,
                "approximate reciprocals",
            ),
            Kind::Root => (&mut seen.roots, allowed.roots, "approximate roots"),
            Kind::Fused => (&mut seen.fused, allowed.fused, "fused products that round"),
        };
        *count += 1;
        if *count > most {
            found.push(format!("{instruction}: {count} of {most} {what}"));
        }
    }
    found
}

/// Returns the sums and products in ACO's form of a program (Mesa's compiler for AMD) that it
/// may rewrite: those that are not marked precise.
pub fn free(program: &str) -> Vec<String> {
    let names = [
        "v_add_f",
        "v_sub_f",
        "v_subrev_f",
        "v_mul_f",
        "v_fma",
        "v_mad_f",
    ];
    let lines = program.lines().filter(|line| {
        let Some((result, operation)) = line.split_once(" = ") else {
            return false;
        };
        let rounds = names.iter().any(|name| operation.starts_with(name));
        rounds && !result.contains("(precise)")
    });
    lines
        .map(|line| format!("{}: not marked precise", line.trim()))
        .collect()
}

/// The instructions of an assembly, without their codes and with both halves of dual ones,
/// and the constants before each.
fn instructions(assembly: &str) -> Vec<(String, Constants)> {
    let lines = assembly.lines().map(|line| {
        let code = line.split(';').next().unwrap_or_default();
        code.trim()
    });
    let lines: Vec<&str> = lines.filter(|line| !line.is_empty()).collect();
    let constants = constants::before(&lines);
    let known = lines.into_iter().zip(constants);
    known
        .filter(|(line, _)| !line.ends_with(':'))
        .flat_map(|(line, constants)| {
            let halves = line.split("::");
            let halves = halves.map(|half| half.trim().replacen("v_dual_", "v_", 1));
            halves
                .map(|half| (half, constants.clone()))
                .collect::<Vec<_>>()
        })
        .collect()
}

/// What an instruction is.
enum Kind {
    Exact,
    Reciprocal,
    Root,
    /// A multiply-add whose product rounds.
    Fused,
    Fault(&'static str),
}

fn kind(name: &str, operands: &[&str], constants: &Constants) -> Kind {
    let (base, is_across) = base(name);
    if base.starts_with("s_setreg") || ["s_round_mode", "s_denorm_mode"].contains(&base) {
        return Kind::Fault("sets how the device rounds");
    }
    if base.starts_with("image_sample") || base.starts_with("image_gather") {
        return Kind::Fault("filters a picture");
    }
    let is_float = |part: &str| ["f16", "f32", "f64", "bf16", "fadd"].contains(&part);
    if !base.split('_').any(is_float) {
        return Kind::Exact;
    }
    if is_across {
        return Kind::Fault("computes across pixels");
    }
    match base {
        "v_rcp_f32" => Kind::Reciprocal,
        "v_sqrt_f32" => Kind::Root,
        "v_fma_f32" | "v_fmac_f32" | "v_fmaak_f32" | "v_fmamk_f32" => {
            // After the result: the factors, and what is added.
            match operands {
                [_, a, b, ..] if is_power_of_two(a, constants) || is_power_of_two(b, constants) => {
                    Kind::Exact
                }
                _ => Kind::Fused,
            }
        }
        _ if EXACT.contains(&base) => Kind::Exact,
        _ if base.starts_with("v_cmp") && base.ends_with("_f32") => Kind::Exact,
        _ => Kind::Fault("rounds as it likes, or is not known"),
    }
}

/// The name without the suffixes of its encoding, and whether it reads other lanes.
fn base(name: &str) -> (&str, bool) {
    let (mut base, mut is_across) = (name, false);
    loop {
        let suffixes = ["_e32", "_e64", "_sdwa", "_dpp", "_dpp8"];
        let Some(suffix) = suffixes.into_iter().find(|end| base.ends_with(end)) else {
            return (base, is_across);
        };
        is_across |= suffix.starts_with("_dpp");
        base = &base[..base.len() - suffix.len()];
    }
}

/// Whether an operand is a constant whose products do not round: ±2ⁿ.
fn is_power_of_two(operand: &str, constants: &Constants) -> bool {
    let magnitude = operand.trim_start_matches('-').trim_matches('|');
    let value = constant(magnitude, constants).map(f32::from_bits);
    value.is_some_and(|value| value.is_normal() && value.to_bits().trailing_zeros() >= 23)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn none(line: &str) -> Vec<String> {
        faults(line, &Allowed::default())
    }

    #[test]
    fn exact_operations_are_no_faults() {
        for line in [
            "BB0:",
            "",
            "\tv_mul_f32_e32 v0, v1, v2          ; 10000501",
            "v_sub_f32_e64 v0, v1, |v2| mul:2",
            "v_cmp_lt_f32_e64 s[6:7], |v1|, s2",
            "v_cmpx_nlt_f32_e32 v1, v2",
            "v_cvt_f32_i32_sdwa v1, v2 dst_sel:DWORD src0_sel:WORD_1",
            "v_mov_b32_dpp v10, v14  quad_perm:[0,0,0,0] row_mask:0xf",
            "v_mad_u32_u24 v0, v1, v2, v3",
            "v_mad_i32_i24 v0, v1, -4, 16",
            "v_dot4_u32_u8 v0, v1, v2, v3",
            "s_mov_b32 s0, 0x3f800000",
            "image_load v[0:3], v[1:2], s[0:7] dmask:0xf",
            "exp mrt0 v0, v1, v2, v3 done vm",
            "v_fma_f32 v1, 2.0, v2, -v3",
            "v_fma_f32 v1, 4.0, -v2, v3",
            "v_fma_f32 v1, v2, -0.5, v3",
            "v_fmac_f32_e32 v1, 1.0, v2",
            "v_fmaak_f32 v1, 0.5, v2, 0x3fc00000",
            "v_fmamk_f32 v1, v2, 0x42000000, v3",
            "v_dual_mul_f32 v0, v1, v2 :: v_dual_add_f32 v3, v4, v5",
            "s_mov_b32 s4, 0x42000000\nv_fmac_f32_e32 v1, s4, v2",
        ] {
            assert_eq!(none(line), [""; 0], "{line}");
        }
    }

    #[test]
    fn whatever_else_works_on_floats_is_a_fault() {
        for line in [
            "v_fma_f32 v1, v4, v2, -v3",
            // The sum is a power of two, not a factor.
            "v_fma_f32 v1, v4, v2, 2.0",
            "v_fma_f32 v1, 3.0, v2, v3",
            // The integer 2, a tiny float; a constant that is none; infinity.
            "v_fma_f32 v1, 2, v2, v3",
            "v_fma_f32 v1, 0x40400000, v2, v3",
            "v_fma_f32 v1, 0x7f800000, v2, v3",
            "v_fmac_f32_e32 v1, s1, v2",
            "s_mov_b32 s4, 0x42000001\nv_fmac_f32_e32 v1, s4, v2",
            "v_fmaak_f32 v1, v3, v2, 0x40000000",
            "v_fmamk_f32 v1, v2, 0x3fc00000, v3",
            "v_dual_fmac_f32 v0, v1, v2 :: v_dual_mul_f32 v3, v4, v5",
            "v_mad_f32 v0, v1, v2, v3",
            "v_mul_legacy_f32 v0, v1, v2",
            "v_rcp_f32_e32 v0, v1",
            "v_rcp_iflag_f32_e32 v0, v1",
            "v_rsq_f32_e32 v0, v1",
            "v_sqrt_f32_e64 v0, |v1|",
            "v_exp_f32_e32 v0, v1",
            "v_log_f32_e32 v0, v1",
            "v_sin_f32_e32 v0, v1",
            "v_cos_f32_e32 v0, v1",
            "v_div_fmas_f32 v0, v1, v2, v3",
            "v_cvt_f16_f32_e32 v0, v1",
            "v_cvt_pkrtz_f16_f32_e32 v0, v1, v2",
            "v_pk_fma_f16 v0, v1, v2, v3",
            "v_dot2_f32_f16 v0, v1, v2, v3",
            "v_add_f64 v[0:1], v[2:3], v[4:5]",
            "v_add_f32_dpp v0, v1, v2 quad_perm:[1,0,3,2]",
            "v_interp_p2_f32_e32 v0, v1, attr0.x",
            "buffer_atomic_add_f32 v0, v1, s[0:3], 0",
            "image_sample v[0:3], v[1:2], s[0:7], s[8:11] dmask:0xf",
            "s_setreg_imm32_b32 hwreg(HW_REG_MODE, 0, 4), 3",
            "s_round_mode 0x3",
            "s_denorm_mode 0x0",
        ] {
            assert_eq!(none(line).len(), 1, "{line}");
        }
    }

    #[test]
    fn sums_and_products_must_be_precise() {
        let program = "BB0\n\t v1: (precise)%3 = v_mul_f32 %1, %2\n\t v1: %4 = v_add_f32 %3, %1\n\
                       \t v1: %5 = v_add_u32 %3, %1\n\t s1: %6:vcc = v_cmp_lt_f32 %3, %1\n";
        assert_eq!(
            free(program),
            ["v1: %4 = v_add_f32 %3, %1: not marked precise"]
        );
    }

    #[test]
    fn what_the_module_asks_for_is_counted() {
        let assembly = "v_rcp_f32_e32 v0, v1\nv_rcp_f32_e32 v0, v2\nv_sqrt_f32_e32 v0, v1\n\
                        v_fma_f32 v0, v1, v2, v3\n";
        let allowed = Allowed {
            reciprocals: 2,
            roots: 1,
            fused: 1,
        };
        assert_eq!(faults(assembly, &allowed), [""; 0]);
        let fewer = Allowed {
            reciprocals: 1,
            fused: 0,
            ..allowed
        };
        assert_eq!(
            faults(assembly, &fewer),
            [
                "v_rcp_f32_e32 v0, v2: 2 of 1 approximate reciprocals",
                "v_fma_f32 v0, v1, v2, v3: 1 of 0 fused products that round",
            ]
        );
    }
}
