//! Sets of values, as users write them.

use proc_macro2::TokenStream;
use quote::quote;
use syn::{Error, Expr, ExprLit, ExprRange, ExprUnary, Lit, RangeLimits, Result, UnOp};

/// Returns an expression of type `Domain`: of a range of literals, or the expression itself.
pub(crate) fn domain(name: &str, values: &Expr) -> Result<TokenStream> {
    let Expr::Range(range) = values else {
        return Ok(quote!(#values));
    };
    let (low, high) = match (&range.start, &range.limits, &range.end) {
        (Some(low), RangeLimits::Closed(_), Some(high)) => (&**low, &**high),
        _ => {
            return Err(Error::new_spanned(
                range,
                "give both ends of the range: 0.0..=1.0",
            ));
        }
    };
    match (literal(low), literal(high)) {
        (Some(Lit::Float(_)), Some(Lit::Float(_))) => {
            Ok(quote!(::relievo_kernel::Domain::range(#name, #low, #high)))
        }
        (Some(Lit::Int(_)), Some(Lit::Int(_))) => integers(name, range, low, high),
        _ => Err(Error::new_spanned(
            range,
            "write both ends as numbers of one kind, 0.0..=1.0 or 0..=9, or name a constant of type Domain",
        )),
    }
}

fn integers(name: &str, range: &ExprRange, low: &Expr, high: &Expr) -> Result<TokenStream> {
    if matches!(low, Expr::Unary(_)) || matches!(high, Expr::Unary(_)) {
        return Err(Error::new_spanned(
            range,
            "ranges of integers start at 0 or above; for f32, write a point: -1.0..=1.0",
        ));
    }
    Ok(quote!(::relievo_kernel::Domain::integer(#name, #low, #high)))
}

/// Returns a literal, or that of a negated one.
fn literal(expression: &Expr) -> Option<&Lit> {
    match expression {
        Expr::Lit(ExprLit { lit, .. }) => Some(lit),
        Expr::Unary(ExprUnary {
            op: UnOp::Neg(_),
            expr,
            ..
        }) => literal(expr),
        _ => None,
    }
}
