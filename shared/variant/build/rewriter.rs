//! Replaces the operations of one file by calls of `crate::operations`.
//!
//! Types are not known here: the functions are generic, and those for integers
//! do what the operator does. Only where an operand is visibly an integer does
//! the operator stay, since a generic function could not tell which integer.

use proc_macro2::{Group, Span, TokenStream, TokenTree};
use quote::{format_ident, quote};
use syn::spanned::Spanned;
use syn::visit_mut::{self, VisitMut};
use syn::{BinOp, Expr, Lit, Meta, UnOp, parse_quote};

/// Methods of glam's vectors that are made of replaced operations here.
const METHODS: [&str; 3] = ["dot", "cross", "perp_dot"];

/// The file of the operations that all others call, and the names of functions, in it
/// and in relievo-exact, that compute: their operations are reported with the caller.
const ARITHMETIC: &str = "arithmetic.rs";
const CALLED: [&str; 5] = ["div", "native_div", "sqrt", "normalize_or", "power"];

/// The package that a file belongs to.
#[derive(Clone, Copy, PartialEq)]
pub enum Package {
    Shared,
    Exact,
}

/// Rewrites files for one tree of modules.
#[derive(Clone)]
pub struct Rewriter<'a> {
    package: Package,
    file: &'a str,
    tree: &'a str,
    features: &'a [&'a str],
    /// Inside what the compiler computes.
    is_constant: bool,
    /// What could not be rewritten.
    pub error: Option<String>,
}

impl<'a> Rewriter<'a> {
    /// For files of `package`, whose modules are in `crate::tree`, with these features.
    pub fn new(package: Package, tree: &'a str, features: &'a [&'a str]) -> Rewriter<'a> {
        Rewriter {
            package,
            file: "",
            tree,
            features,
            is_constant: false,
            error: None,
        }
    }

    /// The same for `file`.
    pub fn of_file<'b>(&'b self, file: &'b str) -> Rewriter<'b> {
        Rewriter {
            file,
            ..self.clone()
        }
    }

    /// Returns where the modules of a package are, without the leading `crate`, if `name` is
    /// how the file calls it.
    fn place(&self, name: &syn::Ident) -> Option<TokenStream> {
        let tree = format_ident!("{}", self.tree);
        if name == "relievo_exact" || (name == "crate" && self.package == Package::Exact) {
            Some(quote! { #tree::exact })
        } else if name == "crate" {
            Some(quote! { #tree })
        } else {
            None
        }
    }

    /// "path.rs:97".
    fn site(&self, span: Span) -> String {
        format!("{}:{}", self.file, span.start().line)
    }

    /// Remembers the first thing that cannot be rewritten.
    fn fail(&mut self, span: Span, what: &str) {
        let site = self.site(span);
        self.error.get_or_insert(format!("{site}: {what}"));
    }

    /// `operation(operands…, site)`, the operands rewritten.
    fn call<const N: usize>(
        &mut self,
        operation: &str,
        span: Span,
        mut operands: [Expr; N],
    ) -> Expr {
        for operand in &mut operands {
            self.visit_expr_mut(operand);
        }
        let site = self.site(span);
        let operation = format_ident!("{operation}");
        parse_quote! { crate::operations::#operation(#(#operands,)* #site) }
    }

    /// The call for `left op right`, or nothing where the operator may stay.
    fn binary(&mut self, left: &Expr, op: &BinOp, right: &Expr) -> Option<Expr> {
        if is_integer(left) || is_integer(right) || (is_literal(left) && is_literal(right)) {
            return None;
        }
        let span = op.span();
        let (left, right) = (left.clone(), right.clone());
        Some(match op {
            BinOp::Add(_) | BinOp::AddAssign(_) => {
                if let Some([a, b]) = product(&left) {
                    self.call("multiply_add", span, [a, b, right])
                } else if let Some([a, b]) = product(&right) {
                    self.call("multiply_add", span, [a, b, left])
                } else {
                    self.call("add", span, [left, right])
                }
            }
            BinOp::Sub(_) | BinOp::SubAssign(_) => {
                if let Some([a, b]) = product(&left) {
                    self.call("multiply_subtract", span, [a, b, right])
                } else if let Some([a, b]) = product(&right) {
                    self.call("subtract_product", span, [a, b, left])
                } else {
                    self.call("subtract", span, [left, right])
                }
            }
            BinOp::Mul(_) | BinOp::MulAssign(_) => self.call("multiply", span, [left, right]),
            BinOp::Div(_) | BinOp::DivAssign(_) => self.call("divide", span, [left, right]),
            _ => return None,
        })
    }

    /// Visits what the compiler computes: only its paths change.
    fn constant(&mut self, visit: impl FnOnce(&mut Self)) {
        let before = std::mem::replace(&mut self.is_constant, true);
        visit(self);
        self.is_constant = before;
    }

    /// What stands in place of `expression`, or nothing where only its parts change.
    fn replacement(&mut self, expression: &Expr) -> Option<Expr> {
        if self.is_constant {
            return None;
        }
        match expression {
            Expr::Binary(binary) => {
                let value = self.binary(&binary.left, &binary.op, &binary.right)?;
                if is_assignment(&binary.op) {
                    let place = &binary.left;
                    Some(parse_quote! { #place = #value })
                } else {
                    Some(value)
                }
            }
            Expr::MethodCall(method) if METHODS.iter().any(|name| method.method == name) => {
                let operands = [(*method.receiver).clone(), method.args.first()?.clone()];
                Some(self.call(&method.method.to_string(), method.method.span(), operands))
            }
            Expr::Call(call) => self.function_call(call),
            _ => None,
        }
    }

    fn function_call(&mut self, call: &syn::ExprCall) -> Option<Expr> {
        let Expr::Path(function) = &*call.func else {
            return None;
        };
        let segments = &function.path.segments;
        let name = segments.last()?.ident.to_string();
        if segments[0].ident == "libm" && name == "sqrtf" {
            return Some(self.call("sqrt", call.span(), [call.args.first()?.clone()]));
        }
        if segments[0].ident == "libm" && name == "fmaf" {
            let [a, b, c] = [0, 1, 2].map(|i| call.args.get(i).cloned());
            return Some(self.call("fused", call.span(), [a?, b?, c?]));
        }
        let computes = self.file == ARITHMETIC || self.package == Package::Exact;
        if computes || !CALLED.contains(&name.as_str()) {
            return None;
        }
        let site = self.site(call.func.span());
        let mut call = call.clone();
        visit_mut::visit_expr_call_mut(self, &mut call);
        let (function, values) = (&call.func, call.args.iter());
        let names: Vec<_> = (0..values.len())
            .map(|i| format_ident!("argument_{i}"))
            .collect();
        Some(parse_quote! {
            crate::operations::called_at(#site, (#(#values,)*), |(#(#names,)*)| #function(#(#names),*))
        })
    }

    /// The condition of a `cfg` with this tree's features in place of the crate's.
    fn resolved(&self, condition: TokenStream) -> TokenStream {
        let (yes, no) = (quote!(all()), quote!(any()));
        let mut tokens = condition.into_iter().peekable();
        let mut resolved = TokenStream::new();
        while let Some(token) = tokens.next() {
            match token {
                TokenTree::Ident(ident) if ident == "feature" => {
                    // `= "name"`.
                    tokens.next();
                    let name = tokens.next().map(|name| name.to_string());
                    let name = name.as_deref().unwrap_or_default().trim_matches('"');
                    let is_on = self.features.contains(&name);
                    resolved.extend(if is_on { yes.clone() } else { no.clone() });
                }
                // Fused sums are compiled for devices only.
                TokenTree::Ident(ident) if ident == "target_arch" => {
                    tokens.nth(1);
                    let is_on = self.features.contains(&"fused");
                    resolved.extend(if is_on { yes.clone() } else { no.clone() });
                }
                TokenTree::Ident(ident) if ident == "test" => resolved.extend(no.clone()),
                TokenTree::Group(group) => {
                    let inner = self.resolved(group.stream());
                    resolved.extend([TokenTree::Group(Group::new(group.delimiter(), inner))]);
                }
                token => resolved.extend([token]),
            }
        }
        resolved
    }
}

impl VisitMut for Rewriter<'_> {
    fn visit_expr_mut(&mut self, expression: &mut Expr) {
        match self.replacement(expression) {
            Some(replacement) => {
                if has_attributes(expression) {
                    self.fail(
                        expression.span(),
                        "an attribute of an operation; put a block around it",
                    );
                }
                *expression = replacement;
            }
            None => visit_mut::visit_expr_mut(self, expression),
        }
    }

    fn visit_file_mut(&mut self, file: &mut syn::File) {
        file.items.retain(|item| !is_test(item));
        visit_mut::visit_file_mut(self, file);
    }

    fn visit_item_const_mut(&mut self, item: &mut syn::ItemConst) {
        self.constant(|this| visit_mut::visit_item_const_mut(this, item));
    }

    fn visit_impl_item_const_mut(&mut self, item: &mut syn::ImplItemConst) {
        self.constant(|this| visit_mut::visit_impl_item_const_mut(this, item));
    }

    fn visit_trait_item_const_mut(&mut self, item: &mut syn::TraitItemConst) {
        self.constant(|this| visit_mut::visit_trait_item_const_mut(this, item));
    }

    /// The length of an array.
    fn visit_type_mut(&mut self, item: &mut syn::Type) {
        self.constant(|this| visit_mut::visit_type_mut(this, item));
    }

    fn visit_generic_argument_mut(&mut self, argument: &mut syn::GenericArgument) {
        self.constant(|this| visit_mut::visit_generic_argument_mut(this, argument));
    }

    fn visit_attributes_mut(&mut self, attributes: &mut Vec<syn::Attribute>) {
        attributes.retain(|attribute| !is_doc(attribute));
        for attribute in attributes {
            self.visit_attribute_mut(attribute);
        }
    }

    fn visit_attribute_mut(&mut self, attribute: &mut syn::Attribute) {
        if let Meta::List(list) = &mut attribute.meta
            && (list.path.is_ident("cfg") || list.path.is_ident("cfg_attr"))
        {
            list.tokens = self.resolved(list.tokens.clone());
        }
    }

    fn visit_path_mut(&mut self, path: &mut syn::Path) {
        visit_mut::visit_path_mut(self, path);
        if let Some(place) = self.place(&path.segments[0].ident) {
            let rest = path.segments.iter().skip(1);
            *path = parse_quote! { crate::#place #(::#rest)* };
        }
    }

    fn visit_use_path_mut(&mut self, path: &mut syn::UsePath) {
        if let Some(place) = self.place(&path.ident) {
            let rest = &path.tree;
            path.tree = parse_quote! { #place::#rest };
            path.ident = format_ident!("crate");
        }
    }

    /// `pub(crate)` stays.
    fn visit_visibility_mut(&mut self, _: &mut syn::Visibility) {}

    /// The arguments of a macro are no expressions that could be rewritten.
    fn visit_macro_mut(&mut self, call: &mut syn::Macro) {
        // What a panic says is no operation.
        if !self.is_constant && !call.path.is_ident("panic") {
            self.fail(
                call.span(),
                "a macro may hide operations; write the expression out",
            );
        }
    }
}

/// The factors of a product that may be fused with a sum.
fn product(expression: &Expr) -> Option<[Expr; 2]> {
    match expression {
        Expr::Paren(paren) => product(&paren.expr),
        Expr::Binary(binary)
            if matches!(binary.op, BinOp::Mul(_))
                && !is_integer(&binary.left)
                && !is_integer(&binary.right) =>
        {
            Some([(*binary.left).clone(), (*binary.right).clone()])
        }
        _ => None,
    }
}

/// Whether an expression is an integer for all to see.
fn is_integer(expression: &Expr) -> bool {
    match expression {
        Expr::Lit(literal) => matches!(literal.lit, Lit::Int(_)),
        Expr::Paren(paren) => is_integer(&paren.expr),
        Expr::Unary(unary) => is_integer(&unary.expr),
        Expr::Binary(binary) => match binary.op {
            BinOp::Shl(_) | BinOp::Shr(_) => true,
            BinOp::BitAnd(_) | BinOp::BitOr(_) | BinOp::BitXor(_) => true,
            BinOp::Add(_) | BinOp::Sub(_) | BinOp::Mul(_) | BinOp::Div(_) => {
                is_integer(&binary.left) || is_integer(&binary.right)
            }
            _ => false,
        },
        _ => false,
    }
}

/// Whether an expression is made of literals only, so that the compiler computes it.
fn is_literal(expression: &Expr) -> bool {
    match expression {
        Expr::Lit(_) => true,
        Expr::Paren(paren) => is_literal(&paren.expr),
        Expr::Unary(unary) => matches!(unary.op, UnOp::Neg(_)) && is_literal(&unary.expr),
        Expr::Binary(binary) => is_literal(&binary.left) && is_literal(&binary.right),
        _ => false,
    }
}

fn is_assignment(op: &BinOp) -> bool {
    matches!(
        op,
        BinOp::AddAssign(_) | BinOp::SubAssign(_) | BinOp::MulAssign(_) | BinOp::DivAssign(_)
    )
}

fn has_attributes(expression: &Expr) -> bool {
    match expression {
        Expr::Binary(binary) => !binary.attrs.is_empty(),
        Expr::Call(call) => !call.attrs.is_empty(),
        Expr::MethodCall(call) => !call.attrs.is_empty(),
        _ => false,
    }
}

fn is_doc(attribute: &syn::Attribute) -> bool {
    attribute.path().is_ident("doc")
}

/// Whether an item is compiled for tests only.
fn is_test(item: &syn::Item) -> bool {
    let attributes = match item {
        syn::Item::Const(item) => &item.attrs,
        syn::Item::Fn(item) => &item.attrs,
        syn::Item::Impl(item) => &item.attrs,
        syn::Item::Mod(item) => &item.attrs,
        syn::Item::Use(item) => &item.attrs,
        _ => return false,
    };
    attributes.iter().any(|attribute| match &attribute.meta {
        Meta::List(list) => list.path.is_ident("cfg") && list.tokens.to_string() == "test",
        _ => false,
    })
}
