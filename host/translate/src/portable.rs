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
//! relievo_translate::portable::lower(&mut module)?;
//! assert!(!format!("{module:?}").contains("break_if: Some"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use crate::constants;
use naga::{Arena, Block, Expression, Handle, Module, Range, Span, Statement};
use std::collections::BTreeMap;

/// Reads SPIR-V without changing loops or vertex positions: y points up, as in
/// WebGPU, Direct3D and Metal. Specialization constants get their own values. By default naga would flip y, since it points down
/// in Vulkan.
///
/// # Errors
/// naga's reason why it cannot read the module.
pub fn read(words: &[u32]) -> Result<Module, String> {
    let options = naga::front::spv::Options {
        adjust_coordinate_space: false,
        ..Default::default()
    };
    let words = constants::set(words, &[]);
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
}
