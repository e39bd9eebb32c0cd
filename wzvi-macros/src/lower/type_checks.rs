//! Ordinary Rust that repeats the user's closures, so that `rustc` type-checks them at the user's own tokens.

use proc_macro2::{Ident, TokenStream, TokenTree};
use quote::{ToTokens, quote};
use syn::Member;
use syn::visit_mut::VisitMut;

use super::dereference::Dereference;
use crate::emit::stubs::embedding_type;
use crate::input::{Declaration, Field, Hamiltonian, Kind, Shape, System};

/// A block of dead code with every closure, its parameters typed by the phase space, and with every scheme as it was
/// written: it has to name the type that it was read as, and its import is in use.
pub(super) fn type_checks(system: &System, declaration: &Declaration, shape: &Shape) -> TokenStream {
    let name = &system.item.ident;
    let (parameters, arguments, condition) = system.item.generics.split_for_impl();
    let checks = declaration.closures().map(|hamiltonian| check(system, hamiltonian));
    let schemes = declaration.embeddings.iter().zip(&declaration.embedding_types).map(|(embedding, written)| {
        let meant = embedding_type(&embedding.value, &declaration.crate_path);
        quote! { __wzvi_scheme(::core::marker::PhantomData::<#meant>, ::core::marker::PhantomData::<#written>); }
    });
    let vector = shape.tokens();
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
                    fn __wzvi_hamiltonian<F: ::core::ops::Fn(#vector, #vector) -> #real>(_: F) {}
                    fn __wzvi_hamiltonian_of_time<F: ::core::ops::Fn(#vector, #vector, #real) -> #real>(_: F) {}
                    fn __wzvi_scheme<E>(_: ::core::marker::PhantomData<E>, _: ::core::marker::PhantomData<E>) {}
                    #( #schemes )*
                    #( #checks )*
                }
            }
        };
    }
}

/// One closure, with the fields it names in scope.
fn check(system: &System, hamiltonian: &Hamiltonian) -> TokenStream {
    let mut used = Vec::new();
    identifiers(hamiltonian.tokens.clone(), &mut used);
    let fields = system.fields.iter().filter_map(|field| binding(field, &used));
    let closure = with_plain_scalars(system, hamiltonian);
    let function = match hamiltonian.closure.inputs.len() {
        2 => quote! { __wzvi_hamiltonian },
        _ => quote! { __wzvi_hamiltonian_of_time },
    };
    quote! { { #( #fields )* #function(#closure); } }
}

/// `let a = self.a;`, with the span of a use: if the closure comes out of a macro, its names are from there.
fn binding(field: &Field, used: &[Ident]) -> Option<TokenStream> {
    let Member::Named(name) = &field.member else { return None };
    let name = used.iter().find(|used| *used == name)?;
    let conditions = &field.conditions;
    Some(match is_scalar(field) {
        true => quote! { #( #conditions )* let #name = self.#name; },
        false => quote! { #( #conditions )* let #name = &self.#name; },
    })
}

/// Whether the field is copied into scope: then `a > 0.0` and `f64::sin(a)` are as good as `*a`.
fn is_scalar(field: &Field) -> bool {
    matches!(field.kind, Kind::Real | Kind::Integer)
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
fn with_plain_scalars(system: &System, hamiltonian: &Hamiltonian) -> TokenStream {
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
