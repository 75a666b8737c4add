//! Reads SPIR-V into naga's IR and rewrites loops that naga would translate wrongly.
//!
//! In GLSL, HLSL and Metal, naga writes a loop's `continuing` block to the start of
//! the next iteration and evaluates `break if` there, with variables that have
//! changed since (gfx-rs/wgpu, issue 4558), so that loops end an iteration early.
//! [`lower`] moves the `continuing` block to the end of the loop's body, which all
//! these languages get right.
//!
//! ```
//! let mut module = naga::front::wgsl::parse_str(
//!     "@compute @workgroup_size(1) fn main() {
//!         var i = 0u;
//!         loop { continuing { i += 1u; break if i > 9u; } }
//!     }",
//! )?;
//! relievo_bitwise::portable::lower(&mut module)?;
//! assert!(!format!("{module:?}").contains("break_if: Some"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use naga::{Arena, Block, Expression, Handle, Module, Range, Span, Statement};
use std::collections::BTreeMap;

/// Reads SPIR-V without changing loops or vertex positions: y points up, as in
/// WebGPU, Direct3D and Metal. By default naga would flip y, since it points down
/// in Vulkan.
///
/// # Errors
/// naga's reason why it cannot read the module.
pub fn read(words: &[u32]) -> Result<Module, String> {
    let options = naga::front::spv::Options {
        adjust_coordinate_space: false,
        ..Default::default()
    };
    naga::front::spv::Frontend::new(words.iter().copied(), &options)
        .parse()
        .map_err(|error| error.to_string())
}

/// Rewrites every loop of `module` without `continuing` and `break if`.
///
/// # Errors
/// A loop has a `continue` inside a switch, or several of them and a `continuing`
/// block that cannot be copied.
pub fn lower(module: &mut Module) -> Result<(), String> {
    let functions = module.functions.iter_mut().map(|(_, function)| function);
    let entry_points = module.entry_points.iter_mut();
    for function in functions.chain(entry_points.map(|entry_point| &mut entry_point.function)) {
        lower_block(&mut function.body, &mut function.expressions)?;
    }
    Ok(())
}

fn lower_block(block: &mut Block, expressions: &mut Arena<Expression>) -> Result<(), String> {
    for statement in block.iter_mut() {
        match statement {
            Statement::Block(inner) => lower_block(inner, expressions)?,
            Statement::If { accept, reject, .. } => {
                lower_block(accept, expressions)?;
                lower_block(reject, expressions)?;
            }
            Statement::Switch { cases, .. } => {
                for case in cases {
                    lower_block(&mut case.body, expressions)?;
                }
            }
            Statement::Loop {
                body,
                continuing,
                break_if,
            } => {
                lower_block(body, expressions)?;
                lower_block(continuing, expressions)?;
                let mut end = std::mem::take(continuing);
                if let Some(condition) = break_if.take() {
                    let accept = Block::from_vec(vec![Statement::Break]);
                    let statement = Statement::If {
                        condition,
                        accept,
                        reject: Block::new(),
                    };
                    end.push(statement, Span::UNDEFINED);
                }
                if !end.is_empty() {
                    let mut end = End {
                        block: end,
                        is_placed: false,
                        expressions,
                    };
                    end.place_before_continues(body, false)?;
                    if !body.last().is_some_and(leaves) {
                        body.extend_block(end.place()?);
                    }
                }
            }
            _ => {}
        }
    }
    Ok(())
}

/// Returns whether the statement after this one is unreachable.
fn leaves(statement: &Statement) -> bool {
    match statement {
        Statement::Break | Statement::Continue | Statement::Return { .. } | Statement::Kill => true,
        Statement::Block(inner) => inner.last().is_some_and(leaves),
        _ => false,
    }
}

/// The statements at the end of a loop's iteration.
struct End<'a> {
    block: Block,
    /// Whether they were placed once.
    is_placed: bool,
    expressions: &'a mut Arena<Expression>,
}

impl End<'_> {
    /// Places the statements before every `continue` in `block` that belongs to the
    /// loop.
    fn place_before_continues(&mut self, block: &mut Block, in_switch: bool) -> Result<(), String> {
        for statement in block.iter_mut() {
            match statement {
                Statement::Continue if in_switch => {
                    return Err("a loop has a continue inside a switch".to_string());
                }
                Statement::Continue => {
                    let mut turn = self.place()?;
                    turn.push(Statement::Continue, Span::UNDEFINED);
                    *statement = Statement::Block(turn);
                }
                Statement::Block(inner) => self.place_before_continues(inner, in_switch)?,
                Statement::If { accept, reject, .. } => {
                    self.place_before_continues(accept, in_switch)?;
                    self.place_before_continues(reject, in_switch)?;
                }
                Statement::Switch { cases, .. } => {
                    for case in cases {
                        self.place_before_continues(&mut case.body, true)?;
                    }
                }
                // The `continue` of an inner loop belongs to that loop.
                _ => {}
            }
        }
        Ok(())
    }

    /// Returns the statements the first time, and a copy with expressions of its
    /// own afterwards: naga's SPIR-V writer evaluates an expression in one place
    /// only.
    fn place(&mut self) -> Result<Block, String> {
        let block = self.block.clone();
        if !std::mem::replace(&mut self.is_placed, true) {
            return Ok(block);
        }
        let mut copier = Copier {
            expressions: self.expressions,
            copies: BTreeMap::new(),
        };
        copier.block(&block).ok_or_else(|| {
            "a loop has several continues and a continuing block that cannot be copied".to_string()
        })
    }
}

/// Copies statements with the expressions that they evaluate. Returns `None` for
/// statements that graphics and compute shaders do not have in loops.
struct Copier<'a> {
    expressions: &'a mut Arena<Expression>,
    copies: BTreeMap<Handle<Expression>, Handle<Expression>>,
}

impl Copier<'_> {
    fn block(&mut self, block: &Block) -> Option<Block> {
        let mut copy = Block::with_capacity(block.len());
        for (statement, &span) in block.span_iter() {
            copy.push(self.statement(statement)?, span);
        }
        Some(copy)
    }

    /// Returns the copy of an expression, or the expression itself if it is
    /// evaluated outside the copied statements.
    fn of(&self, expression: Handle<Expression>) -> Handle<Expression> {
        *self.copies.get(&expression).unwrap_or(&expression)
    }

    fn copy(&mut self, expression: Handle<Expression>) -> Option<Handle<Expression>> {
        let copied = self.expression(expression)?;
        let span = self.expressions.get_span(expression);
        let copy = self.expressions.append(copied, span);
        self.copies.insert(expression, copy);
        Some(copy)
    }

    fn statement(&mut self, statement: &Statement) -> Option<Statement> {
        let mut copy = statement.clone();
        match &mut copy {
            Statement::Emit(range) => {
                let copies: Option<Vec<_>> =
                    range.clone().map(|computed| self.copy(computed)).collect();
                let copies = copies?;
                *range = Range::new_from_bounds(*copies.first()?, *copies.last()?);
            }
            Statement::Block(inner) => *inner = self.block(inner)?,
            Statement::If {
                condition,
                accept,
                reject,
            } => {
                *condition = self.of(*condition);
                *accept = self.block(accept)?;
                *reject = self.block(reject)?;
            }
            Statement::Switch { selector, cases } => {
                *selector = self.of(*selector);
                for case in cases {
                    case.body = self.block(&case.body)?;
                }
            }
            // Inner loops are already rewritten.
            Statement::Loop { body, .. } => *body = self.block(body)?,
            Statement::Store { pointer, value } => {
                (*pointer, *value) = (self.of(*pointer), self.of(*value));
            }
            Statement::Call {
                arguments, result, ..
            } => {
                for argument in arguments {
                    *argument = self.of(*argument);
                }
                if let Some(result) = result {
                    *result = self.copy(*result)?;
                }
            }
            Statement::Break | Statement::Continue | Statement::Kill => {}
            _ => return None,
        }
        Some(copy)
    }

    fn expression(&self, expression: Handle<Expression>) -> Option<Expression> {
        let mut copy = self.expressions[expression].clone();
        let parts: Vec<&mut Handle<Expression>> = match &mut copy {
            Expression::Literal(_)
            | Expression::Constant(_)
            | Expression::Override(_)
            | Expression::ZeroValue(_)
            | Expression::FunctionArgument(_)
            | Expression::GlobalVariable(_)
            | Expression::LocalVariable(_)
            | Expression::CallResult(_) => vec![],
            Expression::Compose { components, .. } => components.iter_mut().collect(),
            Expression::Access { base, index } => vec![base, index],
            Expression::AccessIndex { base: part, .. }
            | Expression::Splat { value: part, .. }
            | Expression::Swizzle { vector: part, .. }
            | Expression::Load { pointer: part }
            | Expression::Unary { expr: part, .. }
            | Expression::Derivative { expr: part, .. }
            | Expression::Relational { argument: part, .. }
            | Expression::As { expr: part, .. }
            | Expression::ArrayLength(part) => vec![part],
            Expression::Binary { left, right, .. } => vec![left, right],
            Expression::Select {
                condition,
                accept,
                reject,
            } => vec![condition, accept, reject],
            Expression::Math {
                arg,
                arg1,
                arg2,
                arg3,
                ..
            } => [arg]
                .into_iter()
                .chain([arg1, arg2, arg3].into_iter().flatten())
                .collect(),
            _ => return None,
        };
        for part in parts {
            *part = self.of(*part);
        }
        Some(copy)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Module as Compiled, Runner, adapters, testing};
    use relievo_kernel::{Domain, Kernel, Kind, table};

    const WORD: Domain = Domain::new(
        "word",
        Kind::Range {
            low: 0.0,
            high: 1.0,
        },
    );

    /// A loop with a `break if` on variables that `continuing` changes, with a
    /// `continue`, and with another such loop inside.
    const LOOPS: &str = "
        @group(0) @binding(0) var<storage, read> inputs: array<u32>;
        @group(0) @binding(1) var<storage, read_write> outputs: array<u32>;

        @compute @workgroup_size(64)
        fn turns(@builtin(global_invocation_id) id: vec3<u32>) {
            let end = inputs[id.x];
            var i = 0u;
            var sum = 0u;
            loop {
                if i % 3u == 1u { continue; }
                if sum > 5000u { break; }
                var j = i;
                loop {
                    sum += j;
                    if j == 7u { continue; }
                    sum += 1u;
                    continuing {
                        let last = j;
                        j += 2u;
                        break if last >= end;
                    }
                }
                continuing {
                    let last = i;
                    i += 1u;
                    break if last == end;
                }
            }
            outputs[id.x] = sum;
        }
    ";

    /// Computes what [`LOOPS`] does.
    fn turns(end: u32) -> u32 {
        let mut sum = 0;
        for i in (0..=end).filter(|i| i % 3 != 1) {
            if sum > 5000 {
                break;
            }
            let mut j = i;
            loop {
                sum += j + u32::from(j != 7);
                j += 2;
                if j - 2 >= end {
                    break;
                }
            }
        }
        sum
    }

    const TURNS: &[Kernel] = table! {
        turns(f32: WORD) -> f32 = |word: f32| f32::from_bits(turns(word.to_bits()));
    };

    #[test]
    fn gpu_lowered_loops_have_the_same_iterations() {
        let words = testing::spirv(LOOPS);
        let mut module = read(&words).expect("a module");
        let tails = |module: &Module| format!("{module:?}").matches("break_if: Some").count();
        assert_eq!(tails(&module), 2);
        lower(&mut module).expect("no switch");
        assert_eq!(tails(&module), 0);

        let module = Compiled::portable(&[&testing::bytes(&words)]).expect("a module");
        let inputs: Vec<u32> = (0..64).collect();
        let right: Vec<u32> = inputs.iter().map(|&end| turns(end)).collect();
        for adapter in adapters() {
            let device = adapter.open().expect("a device");
            let mut runner = Runner::new(&device, &module).expect("a runner");
            let words = runner.run(&TURNS[0], &inputs).expect("a run");
            assert_eq!(words, right, "{}", adapter.describe());
        }
    }

    #[test]
    fn a_continue_inside_a_switch_is_rejected() {
        let source = "@compute @workgroup_size(1) fn main() {
            var i = 0u;
            loop {
                switch i { case 3u: { continue; } default: {} }
                continuing { i += 1u; break if i > 9u; }
            }
        }";
        let mut module = naga::front::wgsl::parse_str(source).expect("WGSL");
        let error = lower(&mut module).unwrap_err();
        assert!(error.contains("switch"), "{error}");
    }

    #[test]
    fn unreadable_modules_are_rejected_with_a_reason() {
        let mut words = testing::spirv(LOOPS);
        // An unknown capability.
        words.splice(5..5, [2 << 16 | 17, 0xffff]);
        let module = Compiled::portable(&[&testing::bytes(&words)]).expect("a module");
        let error = module.translated("turns").unwrap_err().to_string();
        assert!(error.contains("65535"), "{error}");
    }
}
