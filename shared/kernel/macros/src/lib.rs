//! The attribute and the derives of `relievo-kernel`, which has their documentation.

mod derive;
mod domain;
mod kernel;

use proc_macro::TokenStream;

/// Turns a function into a kernel: its words on GPU and CPU are compared.
///
/// Next to the function `f` it writes a module `f` with
///
/// - `f::KERNEL`, a `relievo_kernel::Kernel`, which runs it on the CPU,
/// - a compute shader, where the target is SPIR-V,
/// - a test, `f::gpu_equals_cpu`, which compares both on every adapter
///   (the crate has `relievo-test` as a dev-dependency).
///
/// The arguments are values or references of types that implement `FromWords`; the result
/// implements `ToWords`. The name is unique among the kernels of a crate.
///
/// The attribute says which values of an argument are tried: a range of numbers, or a
/// `Domain` such as those of `relievo_kernel::domain`. For an argument that it does not
/// name, these are numbers of any moderate magnitude, any integer, or what its type's
/// derive says.
///
/// ```ignore
/// #[kernel(normal in UNIT, strength in 0.0..=1.0, octaves in 1..=8)]
/// pub fn bump(position: Vec3, normal: Vec3, strength: f32, octaves: u32) -> Vec3 {
///     normal + noise(position, octaves) * strength
/// }
/// ```
#[proc_macro_attribute]
pub fn kernel(arguments: TokenStream, function: TokenStream) -> TokenStream {
    finish(kernel::expand(arguments.into(), function.into()))
}

/// Derives `FromWords`: each field in turn, or the number of a variant without fields.
///
/// `#[domain(0.0..=1.0)]` or `#[domain(UNIT)]` on a field says which values are tried.
#[proc_macro_derive(FromWords, attributes(domain))]
pub fn from_words(item: TokenStream) -> TokenStream {
    finish(syn::parse(item).and_then(|item| derive::from_words(&item)))
}

/// Derives `ToWords`: each field in turn, or the number of a variant without fields.
#[proc_macro_derive(ToWords)]
pub fn to_words(item: TokenStream) -> TokenStream {
    finish(syn::parse(item).and_then(|item| derive::to_words(&item)))
}

fn finish(result: syn::Result<proc_macro2::TokenStream>) -> TokenStream {
    result
        .unwrap_or_else(|error| error.into_compile_error())
        .into()
}

#[cfg(test)]
mod tests;
