use crate::{derive, kernel};
use proc_macro2::TokenStream;
use quote::quote;

/// Returns why the attribute refuses a function.
fn refused(attribute: TokenStream, function: TokenStream) -> String {
    kernel::expand(attribute, function).unwrap_err().to_string()
}

#[test]
fn wrong_functions_are_refused_with_the_way_out() {
    let none = || quote!();
    let private = quote!(
        fn f(x: f32) -> f32 {
            x
        }
    );
    let messages = [
        refused(none(), private),
        refused(
            none(),
            quote!(
                pub fn f(x: f32) {}
            ),
        ),
        refused(
            none(),
            quote!(
                pub fn f() -> f32 {
                    0.0
                }
            ),
        ),
        refused(
            none(),
            quote!(
                pub fn f<T>(x: T) -> f32 {
                    0.0
                }
            ),
        ),
        refused(
            none(),
            quote!(
                pub unsafe fn f(x: f32) -> f32 {
                    x
                }
            ),
        ),
        refused(
            none(),
            quote!(
                pub fn f(&self, x: f32) -> f32 {
                    x
                }
            ),
        ),
        refused(
            none(),
            quote!(
                pub fn f((x, y): (f32, f32)) -> f32 {
                    x
                }
            ),
        ),
        refused(
            none(),
            quote!(
                pub fn f(x: &mut f32) -> f32 {
                    *x
                }
            ),
        ),
        refused(
            none(),
            quote!(
                pub fn f(x: &[f32]) -> f32 {
                    x[0]
                }
            ),
        ),
        refused(
            quote!(y in 0.0..=1.0),
            quote!(
                pub fn f(x: f32) -> f32 {
                    x
                }
            ),
        ),
        refused(
            quote!(x in 0.0..=1.0, x in 0.0..=2.0),
            quote!(
                pub fn f(x: f32) -> f32 {
                    x
                }
            ),
        ),
        refused(
            quote!(x in 0.0..1.0),
            quote!(
                pub fn f(x: f32) -> f32 {
                    x
                }
            ),
        ),
        refused(
            quote!(x in 0..=1.0),
            quote!(
                pub fn f(x: f32) -> f32 {
                    x
                }
            ),
        ),
        refused(
            quote!(x in -3..=3),
            quote!(
                pub fn f(x: i32) -> i32 {
                    x
                }
            ),
        ),
    ];
    let expected = [
        "make a kernel `pub`, and the modules around it: rust-gpu leaves out what is private",
        "a kernel returns what is compared; give it a result",
        "a kernel without arguments has one result; test it on the CPU",
        "a kernel is a safe function of values without parameters of types or lifetimes",
        "a kernel is a safe function of values without parameters of types or lifetimes",
        "a kernel is a function of its own; call the method in one",
        "name this argument",
        "return what the kernel changes: arguments are only read",
        "a slice has no fixed number of words; use an array, [f32; 4]",
        "the function has no argument `y`",
        "its values are given twice",
        "give both ends of the range: 0.0..=1.0",
        "write both ends as numbers of one kind, 0.0..=1.0 or 0..=9, or name a constant of type Domain",
        "ranges of integers start at 0 or above; for f32, write a point: -1.0..=1.0",
    ];
    assert_eq!(messages, expected);
}

#[test]
fn wrong_types_are_refused_with_the_way_out() {
    let refused = |item: TokenStream| {
        let item = syn::parse2(item).unwrap();
        let errors = [derive::from_words(&item), derive::to_words(&item)];
        errors.map(|result| result.unwrap_err().to_string())
    };
    let both = |message: &str| [message.to_string(), message.to_string()];
    assert_eq!(
        refused(quote!(
            struct Pair<T> {
                a: T,
                b: T,
            }
        )),
        both("types with parameters cannot be derived; implement the trait, or name a type")
    );
    assert_eq!(
        refused(quote!(union Bits { a: f32, b: u32 })),
        both("unions have no words of one meaning; use a struct")
    );
    assert_eq!(
        refused(quote!(
            enum Shape {
                Ball(f32),
                Box,
            }
        )),
        both("variants with fields have no fixed number of words; use a struct")
    );
}
