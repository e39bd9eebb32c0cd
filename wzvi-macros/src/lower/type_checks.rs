//! Ordinary Rust that repeats the user's closures, so that `rustc` type-checks them at the user's own tokens.

use std::collections::HashSet;

use proc_macro2::{Group, Ident, Span, TokenStream, TokenTree};
use quote::{ToTokens, quote};
use syn::Member;
use syn::visit_mut::VisitMut;

use super::dereference::Dereference;
use super::scope::context;
use crate::emit::embedding_type;
use crate::input::{Container, Declaration, Field, Hamiltonian, Kind, Shape};

/// A block of dead code with every closure, its parameters typed by the phase space, and with every scheme as it was
/// written: it has to name the type that it was read as, and its import is in use.
pub(super) fn type_checks(system: &Container, declaration: &Declaration, shape: &Shape) -> TokenStream {
    let name = &system.item.ident;
    let (parameters, arguments, condition) = system.item.generics.split_for_impl();
    let checks = declaration.closures().map(|hamiltonian| check(system, hamiltonian));
    let schemes = declaration.embeddings.iter().zip(&declaration.embedding_types).map(|(embedding, written)| {
        let meant = embedding_type(&embedding.value, &declaration.crate_path);
        quote! { __wzvi_scheme(::core::marker::PhantomData::<#meant>, ::core::marker::PhantomData::<#written>); }
    });
    let vector = shape.tokens();
    // Functions inside of a method do not see the generics around it.
    let sizes: Vec<&syn::ConstParam> = system.item.generics.const_params().collect();
    let declared = sizes.iter().map(|size| {
        let (name, ty) = (&size.ident, &size.ty);
        quote! { const #name: #ty, }
    });
    let declared = quote! { #( #declared )* };
    let real = quote! { ::core::primitive::f64 };
    // Lints would fire at the user's tokens a second time; `rustc` and clippy see the closures nowhere else, but what
    // they would say about style in generated code helps nobody.
    let allow = quote! {
        #[allow(
            warnings, unused, clippy::all, clippy::pedantic, clippy::nursery, clippy::restriction, clippy::cargo
        )]
    };
    quote! {
        const _: () = {
            #allow
            trait __WzviTypeChecks {
                fn __wzvi_type_checks(&self);
            }
            #[automatically_derived]
            #allow
            impl #parameters __WzviTypeChecks for #name #arguments #condition {
                fn __wzvi_type_checks(&self) {
                    fn __wzvi_hamiltonian<#declared F: ::core::ops::Fn(#vector, #vector) -> #real>(_: F) {}
                    fn __wzvi_hamiltonian_of_time<
                        #declared F: ::core::ops::Fn(#vector, #vector, #real) -> #real
                    >(_: F) {}
                    fn __wzvi_family<
                        #declared F: ::core::ops::Fn(#vector, #vector, ::core::primitive::usize) -> #real
                    >(_: F) {}
                    fn __wzvi_family_of_time<
                        #declared F: ::core::ops::Fn(
                            #vector, #vector, #real, ::core::primitive::usize,
                        ) -> #real
                    >(_: F) {}
                    fn __wzvi_scheme<E>(_: ::core::marker::PhantomData<E>, _: ::core::marker::PhantomData<E>) {}
                    #( #schemes )*
                    #( #checks )*
                }
            }
        };
    }
}

/// One closure, with the fields it names in scope.
fn check(system: &Container, hamiltonian: &Hamiltonian) -> TokenStream {
    let mut used = Vec::new();
    identifiers(hamiltonian.tokens.clone(), &mut used);
    let fields = system.fields.iter().flat_map(|field| bindings(field, &used));
    let closure = with_our_self(with_plain_scalars(system, hamiltonian));
    let function = match (hamiltonian.closure.inputs.len(), &hamiltonian.family) {
        (2, None) => quote! { __wzvi_hamiltonian },
        (_, None) => quote! { __wzvi_hamiltonian_of_time },
        (3, Some(_)) => quote! { __wzvi_family },
        _ => quote! { __wzvi_family_of_time },
    };
    let sizes = system.item.generics.const_params().map(|size| &size.ident);
    let generics = if system.item.generics.const_params().next().is_some() {
        quote! { ::<#( #sizes, )* _> }
    } else {
        quote! {}
    };
    quote! { { #( #fields )* #function #generics (#closure); } }
}

/// `let a = self.a;`, with the span of a use: if the closure comes out of a macro, its names are from there. Names
/// from several macros get a variable each.
fn bindings(field: &Field, used: &[Ident]) -> Vec<TokenStream> {
    let Member::Named(member) = &field.member else { return Vec::new() };
    let mut contexts = HashSet::new();
    let names = used.iter().filter(|used| *used == member).filter(|used| contexts.insert(context(used)));
    let conditions = &field.conditions;
    let reference = if is_scalar(field) {
        quote! {}
    } else {
        quote! { & }
    };
    names.map(|name| quote! { #( #conditions )* let #name = #reference self.#member; }).collect()
}

/// Whether the field is copied into scope: then `a > 0.0` and `f64::sin(a)` are as good as `*a`.
fn is_scalar(field: &Field) -> bool {
    matches!(field.kind, Kind::Real | Kind::Integer)
}

/// The tokens with every `self` meaning that of the method around them, whichever macro wrote it.
fn with_our_self(tokens: TokenStream) -> TokenStream {
    let token = |mut token: TokenTree| {
        match &mut token {
            TokenTree::Ident(name) if *name == "self" => {
                name.set_span(name.span().resolved_at(Span::call_site()));
            }
            TokenTree::Group(group) => {
                let mut inner = Group::new(group.delimiter(), with_our_self(group.stream()));
                inner.set_span(group.span());
                *group = inner;
            }
            _ => {}
        }
        token
    };
    tokens.into_iter().map(token).collect()
}

fn identifiers(tokens: TokenStream, into: &mut Vec<Ident>) {
    for token in tokens {
        match token {
            TokenTree::Ident(ident) => into.push(ident),
            TokenTree::Group(group) => identifiers(group.stream(), into),
            _ => {}
        }
    }
}

/// The closure with `*a` written `a` for scalar fields. Untouched, token for token, if there is no such thing.
fn with_plain_scalars(system: &Container, hamiltonian: &Hamiltonian) -> TokenStream {
    let scalars: Vec<&Ident> = system
        .fields
        .iter()
        .filter(|field| is_scalar(field))
        .filter_map(|field| match &field.member {
            Member::Named(name) => Some(name),
            Member::Unnamed(_) => None,
        })
        .collect();
    if !has_dereference(hamiltonian.tokens.clone(), &scalars) {
        return hamiltonian.tokens.clone();
    }
    let mut closure = hamiltonian.closure.clone();
    Dereference::new(&scalars).visit_expr_closure_mut(&mut closure);
    closure.to_token_stream()
}

/// Whether some `*a` may be a dereference: nothing that ends an operand comes before it.
fn has_dereference(tokens: TokenStream, scalars: &[&Ident]) -> bool {
    let tokens: Vec<TokenTree> = tokens.into_iter().collect();
    let is_star = |token: &TokenTree| matches!(token, TokenTree::Punct(punct) if punct.as_char() == '*');
    let follows =
        |i: usize| matches!(tokens.get(i + 1), Some(TokenTree::Ident(name)) if scalars.contains(&name));
    tokens.iter().enumerate().any(|(i, token)| match token {
        TokenTree::Group(group) => has_dereference(group.stream(), scalars),
        token if is_star(token) && follows(i) => match i.checked_sub(1).map(|before| &tokens[before]) {
            None | Some(TokenTree::Punct(_)) => true,
            Some(TokenTree::Ident(keyword)) => syn::parse2::<Ident>(keyword.to_token_stream()).is_err(),
            Some(TokenTree::Group(group)) => group.delimiter() == proc_macro2::Delimiter::Brace,
            Some(TokenTree::Literal(_)) => false,
        },
        _ => false,
    })
}
