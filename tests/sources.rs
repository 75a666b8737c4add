//! Properties of the sources that the compiler cannot check: the shared
//! mathematics uses no operation that devices round differently, and the
//! committed shaders are built from the current sources.

use proc_macro2::{Span, TokenStream, TokenTree};
use relievo_shader_manifest::{Project, changes};
use relievo_tests::root;
use std::collections::BTreeMap;
use std::path::Path;
use syn::visit::{self, Visit};

/// Methods, and functions of number and vector types, whose results differ
/// between devices (see the docs of `shared/src/lib.rs`).
const FORBIDDEN_FUNCTIONS: [&str; 51] = [
    "acos",
    "acosh",
    "asin",
    "asinh",
    "atan",
    "atan2",
    "atanh",
    "cbrt",
    "clamp",
    "copysign",
    "cos",
    "cosh",
    "distance_squared",
    "div_euclid",
    "exp",
    "exp2",
    "exp_m1",
    "fract",
    "hypot",
    "is_nan",
    "length",
    "length_recip",
    "length_squared",
    "lerp",
    "ln",
    "ln_1p",
    "log",
    "log10",
    "log2",
    "max",
    "min",
    "mul_add",
    "normalize",
    "normalize_or",
    "normalize_or_zero",
    "powf",
    "powi",
    "recip",
    "reflect",
    "refract",
    "rem_euclid",
    "round",
    "round_ties_even",
    "sin",
    "sin_cos",
    "sinh",
    "sqrt",
    "tan",
    "tanh",
    "try_normalize",
    "checked_div",
];
/// Types whose functions are checked when called by path.
const NUMBER_TYPES: [&str; 9] = [
    "f32", "f64", "Real", "Vec2", "Vec3", "DVec2", "DVec3", "glam", "core",
];
/// The files that may call libm, and the function in each that may divide: the device's
/// own, and that of the f64 twin.
const NATIVE: [(&str, &str); 2] = [
    ("shared/exact/src/native.rs", "native_div"),
    ("shared/src/double.rs", "div"),
];

/// Scans one file; finds each forbidden thing as "file:line: what".
struct Scanner<'a> {
    file: &'a str,
    may_divide: bool,
    /// Inside what the compiler computes.
    is_constant: bool,
    findings: Vec<String>,
}

impl Scanner<'_> {
    fn scan(file: &str, text: &str) -> Vec<String> {
        let parsed = match syn::parse_file(text) {
            Ok(parsed) => parsed,
            Err(error) => {
                let line = error.span().start().line;
                return vec![format!("{file}:{line}: cannot be parsed: {error}")];
            }
        };
        let mut scanner = Scanner {
            file,
            may_divide: false,
            is_constant: false,
            findings: Vec::new(),
        };
        scanner.visit_file(&parsed);
        scanner.findings
    }

    /// The function that may divide, in a file that may call libm.
    fn dividing_function(&self) -> Option<&str> {
        let mut files = NATIVE.iter();
        let found = files.find(|(file, _)| *file == self.file);
        found.map(|(_, function)| *function)
    }

    fn is_native(&self) -> bool {
        self.dividing_function().is_some()
    }

    fn find(&mut self, span: Span, what: &str) {
        let line = span.start().line;
        self.findings.push(format!("{}:{line}: {what}", self.file));
    }

    fn forbid_operator(&mut self, span: Span, operator: &str) {
        if !self.may_divide {
            self.find(
                span,
                &format!("`{operator}`; divide by crate::arithmetic::div"),
            );
        }
    }

    /// Macro arguments are tokens, not expressions: any forbidden one counts, but for the
    /// functions of relievo-exact: `exact::sin`.
    fn scan_tokens(&mut self, tokens: &TokenStream) {
        let mut before = [String::new(), String::new(), String::new()];
        for token in tokens.clone() {
            let is_exact = before == ["exact", ":", ":"];
            before.rotate_left(1);
            before[2] = token.to_string();
            match token {
                TokenTree::Group(group) => self.scan_tokens(&group.stream()),
                TokenTree::Punct(punct) if "/%".contains(punct.as_char()) => {
                    self.forbid_operator(punct.span(), &punct.as_char().to_string());
                }
                TokenTree::Ident(ident) => {
                    let name = ident.to_string();
                    let is_forbidden = FORBIDDEN_FUNCTIONS.contains(&name.as_str());
                    if name == "libm" || (is_forbidden && !is_exact) {
                        self.find(ident.span(), &format!("`{name}` in a macro"));
                    }
                }
                _ => {}
            }
        }
    }
}

/// Whether an expression consists of literals only, which the compiler evaluates in a
/// constant.
fn is_literal(expression: &syn::Expr) -> bool {
    match expression {
        syn::Expr::Lit(_) => true,
        syn::Expr::Paren(paren) => is_literal(&paren.expr),
        syn::Expr::Unary(unary) => is_literal(&unary.expr),
        syn::Expr::Binary(binary) => is_literal(&binary.left) && is_literal(&binary.right),
        _ => false,
    }
}

/// Whether an item is compiled for tests only.
fn is_test(attributes: &[syn::Attribute]) -> bool {
    attributes.iter().any(|attribute| match &attribute.meta {
        syn::Meta::List(list) => {
            list.path.is_ident("cfg") && list.tokens.to_string().trim() == "test"
        }
        _ => false,
    })
}

fn attributes(item: &syn::Item) -> &[syn::Attribute] {
    match item {
        syn::Item::Const(item) => &item.attrs,
        syn::Item::Fn(item) => &item.attrs,
        syn::Item::Impl(item) => &item.attrs,
        syn::Item::Mod(item) => &item.attrs,
        syn::Item::Use(item) => &item.attrs,
        _ => &[],
    }
}

impl<'ast> Visit<'ast> for Scanner<'_> {
    fn visit_item(&mut self, item: &'ast syn::Item) {
        if !is_test(attributes(item)) {
            visit::visit_item(self, item);
        }
    }

    fn visit_item_fn(&mut self, function: &'ast syn::ItemFn) {
        let dividing = self.dividing_function();
        self.may_divide = dividing.is_some_and(|name| function.sig.ident == name);
        visit::visit_item_fn(self, function);
        self.may_divide = false;
    }

    fn visit_item_const(&mut self, item: &'ast syn::ItemConst) {
        let before = std::mem::replace(&mut self.is_constant, true);
        visit::visit_item_const(self, item);
        self.is_constant = before;
    }

    fn visit_expr_binary(&mut self, binary: &'ast syn::ExprBinary) {
        let (span, operator) = match &binary.op {
            syn::BinOp::Div(token) => (token.spans[0], "/"),
            syn::BinOp::Rem(token) => (token.spans[0], "%"),
            syn::BinOp::DivAssign(token) => (token.spans[0], "/="),
            syn::BinOp::RemAssign(token) => (token.spans[0], "%="),
            _ => return visit::visit_expr_binary(self, binary),
        };
        // Elsewhere quotients of literals are left to the device.
        if !(self.is_constant && is_literal(&binary.left) && is_literal(&binary.right)) {
            self.forbid_operator(span, operator);
        }
        visit::visit_expr_binary(self, binary);
    }

    fn visit_expr_method_call(&mut self, call: &'ast syn::ExprMethodCall) {
        let name = call.method.to_string();
        if FORBIDDEN_FUNCTIONS.contains(&name.as_str()) {
            self.find(call.method.span(), &format!("method `{name}`"));
        }
        visit::visit_expr_method_call(self, call);
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let names: Vec<String> = path.segments.iter().map(|s| s.ident.to_string()).collect();
        let span = path.segments[0].ident.span();
        if names[0] == "libm" && !self.is_native() {
            self.find(span, &format!("path `{}`", names.join("::")));
        }
        let last = &names[names.len() - 1];
        let of_number = names[..names.len() - 1]
            .iter()
            .any(|name| NUMBER_TYPES.contains(&name.as_str()));
        if of_number && FORBIDDEN_FUNCTIONS.contains(&last.as_str()) {
            self.find(span, &format!("path `{}`", names.join("::")));
        }
        visit::visit_path(self, path);
    }

    fn visit_use_path(&mut self, path: &'ast syn::UsePath) {
        if path.ident == "libm" && !self.is_native() {
            self.find(path.ident.span(), "use of `libm`");
        }
        visit::visit_use_path(self, path);
    }

    fn visit_use_name(&mut self, name: &'ast syn::UseName) {
        if name.ident == "libm" && !self.is_native() {
            self.find(name.ident.span(), "use of `libm`");
        }
    }

    fn visit_use_rename(&mut self, rename: &'ast syn::UseRename) {
        if rename.ident == "libm" && !self.is_native() {
            self.find(rename.ident.span(), "use of `libm`");
        }
    }

    fn visit_macro(&mut self, call: &'ast syn::Macro) {
        self.scan_tokens(&call.tokens);
        visit::visit_macro(self, call);
    }
}

/// The `.rs` files below `folder`, unit tests aside, with their names from there.
fn sources(folder: &Path) -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    let mut waiting = vec![folder.to_path_buf()];
    while let Some(path) = waiting.pop() {
        for entry in std::fs::read_dir(&path).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                waiting.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs")
                && path.file_name().is_some_and(|name| name != "tests.rs")
            {
                let name = path.strip_prefix(folder).unwrap().display().to_string();
                found.insert(name, std::fs::read_to_string(&path).unwrap());
            }
        }
    }
    found
}

#[test]
fn the_shared_mathematics_calls_only_what_all_devices_round_alike() {
    let mut files = BTreeMap::new();
    for folder in ["shared/src", "shared/exact/src"] {
        let below = sources(&root().join(folder)).into_iter();
        files.extend(below.map(|(name, text)| (format!("{folder}/{name}"), text)));
    }
    assert!(NATIVE.iter().all(|(file, _)| files.contains_key(*file)));
    assert!(files.contains_key("shared/src/march.rs"));
    let findings: Vec<String> = files
        .iter()
        .flat_map(|(name, text)| Scanner::scan(name, text))
        .collect();
    assert!(
        findings.is_empty(),
        "not allowed in the shared mathematics (see the docs of shared/src/lib.rs):\n{}",
        findings.join("\n")
    );
}

#[test]
fn the_scanner_reports_each_forbidden_thing_with_its_line() {
    // Each line must be found.
    let forbidden = [
        ("a / b", "`/`"),
        ("1.0 / b", "`/`"),
        ("a % b", "`%`"),
        ("i / 2", "`/`"),
        ("i % 3", "`%`"),
        ("{ a /= b; }", "`/=`"),
        ("{ a %= b; }", "`%=`"),
        ("(a + (b / 2.0)) * 3.0", "`/`"),
        ("f(a, |x| x / a)", "`/`"),
        ("a * (1.0 / 3.0)", "`/`"),
        ("a.sqrt()", "method `sqrt`"),
        ("(a * b).mul_add(a, b)", "method `mul_add`"),
        ("a.powi(2)", "method `powi`"),
        ("a.sin()", "method `sin`"),
        ("v.normalize()", "method `normalize`"),
        ("v.cross(v).length()", "method `length`"),
        ("Real::sqrt(a)", "path `Real::sqrt`"),
        ("core::f32::math::sqrt(a)", "path `core::f32::math::sqrt`"),
        ("glam::Vec3::length(v)", "path `glam::Vec3::length`"),
        ("libm::sqrtf(a)", "path `libm::sqrtf`"),
        ("{ use libm::sqrtf; }", "use of `libm`"),
        ("{ use libm as m; }", "use of `libm`"),
        ("dbg!(a / b)", "`/`"),
        ("dbg!(f(a.sqrt()))", "`sqrt` in a macro"),
    ];
    for (expression, expected) in forbidden {
        let text = format!("// A comment: a / b.\nfn any(a: Real) {{\n    {expression};\n}}\n");
        let findings = Scanner::scan("shared/src/any.rs", &text);
        assert_eq!(findings.len(), 1, "{expression}: {findings:?}");
        assert!(
            findings[0].starts_with(&format!("shared/src/any.rs:3: {expected}")),
            "{expression}: {findings:?}"
        );
    }

    // In functions of impl blocks and traits, in nested modules and constants, too.
    for text in [
        "impl A { fn f(a: f32) -> f32 { a / a } }",
        "trait A { fn f(a: f32) -> f32 { a / a } }",
        "mod inner { fn f(a: f32) -> f32 { a / a } }",
        "const A: f32 = 1.0 / B;",
        "#[cfg(not(test))] fn f(a: f32) -> f32 { a / a }",
        // Only the function in native.rs may, not any of that name.
        "fn native_div(a: f32, b: f32) -> f32 { a / b }",
    ] {
        assert_eq!(Scanner::scan("any.rs", text).len(), 1, "{text}");
    }
    // Invalid Rust is an error.
    assert_eq!(Scanner::scan("any.rs", "fn f( {").len(), 1);
    // Only native_div may divide, also in native.rs.
    let text = "fn native_div(a: f32, b: f32) -> f32 { a / b }\nfn half(a: f32) -> f32 { a / 2.0 }";
    let findings = Scanner::scan("shared/exact/src/native.rs", text);
    assert_eq!(findings.len(), 1, "{findings:?}");
    assert!(findings[0].contains("native.rs:2"), "{findings:?}");
}

#[test]
fn the_scanner_leaves_the_rest_alone() {
    for text in [
        "const A: f32 = 1.0 / 128.0; const B: f32 = -(2.0 / 3.0) / 4.0;",
        "fn f(a: f32) -> f32 { const THIRD: f32 = 1.0 / 3.0; a * THIRD }",
        "list! { sine(f32) -> f32 = kernels::exact::sin; }",
        "#[cfg(test)] mod tests { fn f(a: f32) -> f32 { a / a.sqrt() } }",
        "#[cfg(test)] #[allow(unused)] mod tests { use libm::sqrtf; }",
        "/// a / b\nfn f(a: f32) -> f32 { /* a / b */ min(a, sqrt(a)) }",
        "fn f(m: &ShapeMap) { m.distance(t, uv); crate::arithmetic::sqrt(a); v.dot(v); }",
    ] {
        let findings = Scanner::scan("shared/src/any.rs", text);
        assert!(findings.is_empty(), "{text}: {findings:?}");
    }
    let text = "fn sqrt(x: f32) -> f32 { libm::sqrtf(x) }";
    assert!(Scanner::scan("shared/exact/src/native.rs", text).is_empty());
}

#[test]
fn the_shaders_are_made_of_these_sources() {
    let project = Project::load(&root().join("Cargo.toml")).unwrap();
    let changes = changes(&project).unwrap();
    assert!(
        changes.is_empty(),
        "the compiled shaders are out of date:\n{}\nrebuild them: see docs/contributing.md",
        changes.join("\n")
    );
}
