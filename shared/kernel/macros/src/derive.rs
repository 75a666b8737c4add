//! Types as words.

use crate::domain::domain;
use proc_macro2::TokenStream;
use quote::quote;
use syn::{Data, DataEnum, DeriveInput, Error, Expr, Field, Fields, Result};

pub(crate) fn from_words(item: &DeriveInput) -> Result<TokenStream> {
    let name = &item.ident;
    let (words, argument, read) = match &item.data {
        Data::Struct(data) => {
            let types: Vec<_> = data.fields.iter().map(|field| &field.ty).collect();
            let parts: Vec<_> = data.fields.iter().map(part).collect::<Result<_>>()?;
            let values = quote!(#(<#types as ::relievo_kernel::FromWords>::read(source)),*);
            let read = match &data.fields {
                Fields::Named(fields) => {
                    let names = fields.named.iter().map(|field| &field.ident);
                    quote!(#name { #(#names: <#types as ::relievo_kernel::FromWords>::read(source)),* })
                }
                Fields::Unnamed(_) => quote!(#name(#values)),
                Fields::Unit => quote!(#name),
            };
            let words = quote!(0 #(+ <#types as ::relievo_kernel::FromWords>::WORDS)*);
            let argument = quote! {
                ::relievo_kernel::Argument {
                    words: <Self as ::relievo_kernel::FromWords>::WORDS,
                    domain: ::relievo_kernel::domain::NUMBER,
                    parts: &[#(#parts),*],
                }
            };
            (words, argument, read)
        }
        Data::Enum(data) => {
            let variants = variants(data)?;
            let (first, rest) = variants
                .split_first()
                .ok_or_else(|| Error::new_spanned(item, "it has no variants, so no values"))?;
            let last = rest.len() as u32;
            let numbers = 1..=last;
            let argument = quote! {
                ::relievo_kernel::Argument::new(
                    1,
                    ::relievo_kernel::Domain::integer(stringify!(#name), 0, #last),
                )
            };
            let read = quote! {
                match ::relievo_kernel::Source::next(source) {
                    #(#numbers => #name::#rest,)*
                    _ => #name::#first,
                }
            };
            (quote!(1), argument, read)
        }
        Data::Union(_) => return Err(unions(item)),
    };
    concrete(item)?;
    Ok(quote! {
        impl ::relievo_kernel::FromWords for #name {
            const WORDS: u32 = #words;
            const ARGUMENT: ::relievo_kernel::Argument = #argument;
            #[inline]
            fn read<S: ::relievo_kernel::Source>(source: &mut S) -> #name {
                #read
            }
        }
    })
}

pub(crate) fn to_words(item: &DeriveInput) -> Result<TokenStream> {
    let name = &item.ident;
    let (words, write) = match &item.data {
        Data::Struct(data) => {
            let types = data.fields.iter().map(|field| &field.ty);
            let members = data.fields.members();
            (
                quote!(0 #(+ <#types as ::relievo_kernel::ToWords>::WORDS)*),
                quote!(#(::relievo_kernel::ToWords::write(self.#members, sink);)*),
            )
        }
        Data::Enum(data) => {
            let variants = variants(data)?;
            let numbers = 0..variants.len() as u32;
            let write = quote! {
                ::relievo_kernel::Sink::put(sink, match self { #(#name::#variants => #numbers),* });
            };
            (quote!(1), write)
        }
        Data::Union(_) => return Err(unions(item)),
    };
    concrete(item)?;
    Ok(quote! {
        impl ::relievo_kernel::ToWords for #name {
            const WORDS: u32 = #words;
            #[inline]
            fn write<S: ::relievo_kernel::Sink>(self, sink: &mut S) {
                #write
            }
        }
    })
}

/// Returns the argument that a field is part of: as its attribute says, or its type.
fn part(field: &Field) -> Result<TokenStream> {
    let ty = &field.ty;
    let Some(attribute) = field.attrs.iter().find(|a| a.path().is_ident("domain")) else {
        return Ok(quote!(<#ty as ::relievo_kernel::FromWords>::ARGUMENT));
    };
    let name = match &field.ident {
        Some(name) => name.to_string(),
        None => "value".to_string(),
    };
    let domain = domain(&name, &attribute.parse_args::<Expr>()?)?;
    Ok(quote! {
        ::relievo_kernel::Argument::given(<#ty as ::relievo_kernel::FromWords>::ARGUMENT, #domain)
    })
}

fn variants(data: &DataEnum) -> Result<Vec<&syn::Ident>> {
    let name = |variant: &'_ syn::Variant| match variant.fields {
        Fields::Unit => Ok(()),
        _ => Err(Error::new_spanned(
            variant,
            "variants with fields have no fixed number of words; use a struct",
        )),
    };
    data.variants.iter().try_for_each(name)?;
    Ok(data.variants.iter().map(|variant| &variant.ident).collect())
}

fn concrete(item: &DeriveInput) -> Result<()> {
    if item.generics.params.is_empty() {
        return Ok(());
    }
    Err(Error::new_spanned(
        &item.generics,
        "types with parameters cannot be derived; implement the trait, or name a type",
    ))
}

fn unions(item: &DeriveInput) -> Error {
    Error::new_spanned(item, "unions have no words of one meaning; use a struct")
}
