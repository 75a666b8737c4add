//! The attribute `kernel`.

use crate::domain::domain;
use proc_macro2::TokenStream;
use quote::{ToTokens, quote};
use syn::parse::{Parse, ParseStream, Parser};
use syn::punctuated::Punctuated;
use syn::{Error, Expr, FnArg, Ident, ItemFn, Pat, Result, ReturnType, Token, Type, Visibility};

/// `name in values`.
struct Given {
    name: Ident,
    values: Expr,
}

impl Parse for Given {
    fn parse(input: ParseStream) -> Result<Given> {
        let name = input.parse()?;
        input.parse::<Token![in]>()?;
        Ok(Given {
            name,
            values: input.parse()?,
        })
    }
}

/// An argument of the function.
struct Argument {
    name: Ident,
    /// Its type, without the reference.
    ty: Type,
    is_reference: bool,
}

pub(crate) fn expand(attribute: TokenStream, function: TokenStream) -> Result<TokenStream> {
    let given = Punctuated::<Given, Token![,]>::parse_terminated.parse2(attribute)?;
    let function: ItemFn = syn::parse2(function)?;
    let arguments = arguments(&function)?;
    if matches!(function.vis, Visibility::Inherited) {
        return Err(Error::new_spanned(
            function.sig.fn_token,
            "make a kernel `pub`, and the modules around it: rust-gpu leaves out what is private",
        ));
    }
    let ReturnType::Type(_, result) = &function.sig.output else {
        return Err(Error::new_spanned(
            &function.sig,
            "a kernel returns what is compared; give it a result",
        ));
    };
    if let Some(unknown) = given
        .iter()
        .find(|given| arguments.iter().all(|argument| argument.name != given.name))
    {
        let message = format!("the function has no argument `{}`", unknown.name);
        return Err(Error::new_spanned(&unknown.name, message));
    }
    let (name, visibility) = (&function.sig.ident, &function.vis);
    let text = name.to_string();
    let about = format!("The kernel of [`{text}`](fn@{text}).");
    let values = arguments
        .iter()
        .map(|argument| described(argument, &given))
        .collect::<Result<Vec<_>>>()?;
    let types: Vec<_> = arguments.iter().map(|argument| &argument.ty).collect();
    let names: Vec<_> = arguments.iter().map(|argument| &argument.name).collect();
    let passed = arguments.iter().map(|argument| {
        let name = &argument.name;
        if argument.is_reference {
            quote!(&#name)
        } else {
            quote!(#name)
        }
    });
    let place = proc_macro2::Span::mixed_site();
    let (source, read) = (Ident::new("source", place), Ident::new("read", place));
    Ok(quote! {
        #function

        #[doc = #about]
        #visibility mod #name {
            #[allow(unused_imports)]
            use super::*;

            const __INPUT_WORDS: u32 = 0 #(+ <#types as ::relievo_kernel::FromWords>::WORDS)*;

            /// The function, and its arguments.
            pub const KERNEL: ::relievo_kernel::Kernel = ::relievo_kernel::Kernel {
                name: #text,
                arguments: &[#(#values),*],
                input_words: __INPUT_WORDS,
                output_words: <#result as ::relievo_kernel::ToWords>::WORDS,
                run: |inputs, outputs| {
                    ::relievo_kernel::for_each_input(__INPUT_WORDS, inputs, outputs, |source| #read(source))
                },
            };

            #[inline]
            fn #read<S: ::relievo_kernel::Source>(#source: &mut S) -> #result {
                #(let #names = <#types as ::relievo_kernel::FromWords>::read(#source);)*
                super::#name(#(#passed),*)
            }

            /// Runs the function on input number x.
            #[cfg(target_arch = "spirv")]
            #[::spirv_std::spirv(compute(threads(64), entry_point_name = #text))]
            pub fn entry_point(
                #[spirv(global_invocation_id)] id: ::relievo_kernel::glam::UVec3,
                #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] inputs: &[u32],
                #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] outputs: &mut [u32],
            ) {
                // SAFETY: the runner binds the words of all invocations.
                unsafe {
                    ::relievo_kernel::buffers::run(id.x, __INPUT_WORDS, inputs, outputs, |source| {
                        #read(source)
                    });
                }
            }

            #[cfg(test)]
            #[test]
            fn gpu_equals_cpu() {
                ::relievo_test::assert_equal(&KERNEL);
            }
        }
    })
}

/// Returns the function's arguments.
fn arguments(function: &ItemFn) -> Result<Vec<Argument>> {
    let signature = &function.sig;
    let refused = if !signature.generics.params.is_empty() {
        Some(signature.generics.to_token_stream())
    } else {
        let (a, b) = (signature.asyncness, signature.unsafety);
        a.map(|a| a.to_token_stream())
            .or(b.map(|b| b.to_token_stream()))
    };
    if let Some(tokens) = refused {
        return Err(Error::new_spanned(
            tokens,
            "a kernel is a safe function of values without parameters of types or lifetimes",
        ));
    }
    if signature.inputs.is_empty() {
        return Err(Error::new_spanned(
            signature,
            "a kernel without arguments has one result; test it on the CPU",
        ));
    }
    signature.inputs.iter().map(argument).collect()
}

fn argument(input: &FnArg) -> Result<Argument> {
    let FnArg::Typed(typed) = input else {
        return Err(Error::new_spanned(
            input,
            "a kernel is a function of its own; call the method in one",
        ));
    };
    let Pat::Ident(pattern) = &*typed.pat else {
        return Err(Error::new_spanned(&typed.pat, "name this argument"));
    };
    let (ty, is_reference) = match &*typed.ty {
        Type::Reference(reference) if reference.mutability.is_some() => {
            return Err(Error::new_spanned(
                reference,
                "return what the kernel changes: arguments are only read",
            ));
        }
        Type::Reference(reference) => ((*reference.elem).clone(), true),
        other => (other.clone(), false),
    };
    if let Type::Slice(slice) = &ty {
        return Err(Error::new_spanned(
            slice,
            "a slice has no fixed number of words; use an array, [f32; 4]",
        ));
    }
    Ok(Argument {
        name: pattern.ident.clone(),
        ty,
        is_reference,
    })
}

/// Returns the expression of an argument with its values.
fn described(argument: &Argument, given: &Punctuated<Given, Token![,]>) -> Result<TokenStream> {
    let (name, ty) = (argument.name.to_string(), &argument.ty);
    let mut given = given.iter().filter(|given| given.name == argument.name);
    let Some(values) = given.next() else {
        return Ok(quote!(<#ty as ::relievo_kernel::FromWords>::ARGUMENT));
    };
    if let Some(again) = given.next() {
        return Err(Error::new_spanned(
            &again.name,
            "its values are given twice",
        ));
    }
    let domain = domain(&name, &values.values)?;
    Ok(quote! {
        ::relievo_kernel::Argument::given(<#ty as ::relievo_kernel::FromWords>::ARGUMENT, #domain)
    })
}
