//! Loops without `continuing` blocks.
//!
//! Where a loop ends in one, naga writes it to the start of the next turn in
//! GLSL, HLSL and Metal, and there computes the condition that ends the loop
//! anew, of variables that have changed since (gfx-rs/wgpu, issue 4558): loops
//! of ours ended a turn early. Here what comes at the end of a turn is put to
//! its end, where all these languages have it right.

use naga::{Block, Module, Span, Statement};

/// Rewrites every loop of `module`.
///
/// # Errors
/// A loop that goes on from within a switch, out of which it would have to end.
pub(super) fn lower(module: &mut Module) -> Result<(), String> {
    for (_, function) in module.functions.iter_mut() {
        lower_block(&mut function.body)?;
    }
    for entry_point in &mut module.entry_points {
        lower_block(&mut entry_point.function.body)?;
    }
    Ok(())
}

fn lower_block(block: &mut Block) -> Result<(), String> {
    for statement in block.iter_mut() {
        match statement {
            Statement::Block(inner) => lower_block(inner)?,
            Statement::If { accept, reject, .. } => {
                lower_block(accept)?;
                lower_block(reject)?;
            }
            Statement::Switch { cases, .. } => {
                for case in cases {
                    lower_block(&mut case.body)?;
                }
            }
            Statement::Loop {
                body,
                continuing,
                break_if,
            } => {
                lower_block(body)?;
                lower_block(continuing)?;
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
                    end_turns(body, &end, false)?;
                    if !body.last().is_some_and(leaves) {
                        body.extend_block(end);
                    }
                }
            }
            _ => {}
        }
    }
    Ok(())
}

/// Whether nothing after this is reached.
fn leaves(statement: &Statement) -> bool {
    match statement {
        Statement::Break | Statement::Continue | Statement::Return { .. } | Statement::Kill => true,
        Statement::Block(inner) => inner.last().is_some_and(leaves),
        _ => false,
    }
}

/// Puts `end` before every `continue` of the loop that `block` lies in.
fn end_turns(block: &mut Block, end: &Block, in_switch: bool) -> Result<(), String> {
    for statement in block.iter_mut() {
        match statement {
            Statement::Continue if in_switch => {
                return Err("a loop goes on from within a switch".to_string());
            }
            Statement::Continue => {
                let mut turn = end.clone();
                turn.push(Statement::Continue, Span::UNDEFINED);
                *statement = Statement::Block(turn);
            }
            Statement::Block(inner) => end_turns(inner, end, in_switch)?,
            Statement::If { accept, reject, .. } => {
                end_turns(accept, end, in_switch)?;
                end_turns(reject, end, in_switch)?;
            }
            Statement::Switch { cases, .. } => {
                for case in cases {
                    end_turns(&mut case.body, end, true)?;
                }
            }
            // The `continue` of an inner loop is its own.
            _ => {}
        }
    }
    Ok(())
}
