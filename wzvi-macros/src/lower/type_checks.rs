//! Ordinary Rust that repeats the user's closures, so that `rustc` type-checks them at the user's own tokens.
//! Tests: `tests/accepted`, `tests/compiler/ui/fail`.

use std::collections::HashSet;

use proc_macro2::{Ident, Span, TokenStream, TokenTree};
use quote::{ToTokens, quote};
use syn::{Expr, ExprClosure, ExprRepeat, GenericParam, Generics, Member};

use super::scope::context;
use crate::input::{Container, Declaration, DeclaredValue, Field, FieldKind, Hamiltonian, Shape, peeled};
use crate::key::Key;
use crate::symbolic::NAMES;
use crate::tokens::{self, words};

/// Dead code with every closure, its parameters typed by the phase space, and with every scheme as it was
/// written: it must name the type as which it was read, and its import counts as used.
pub(super) fn type_checks(
    system: &Container,
    declaration: &Declaration,
    shape: &Shape,
    untyped: &Untyped,
) -> TokenStream {
    let name = &system.item.ident;
    let (parameters, _, condition) = system.item.generics.split_for_impl();
    let arguments = arguments(&system.item.generics);
    let root = &declaration.crate_path;
    let (path, checks) = (quote!(#root::__private::checks), unused_name(system, declaration));
    let vector = if matches!(shape, Shape::Real) { quote!(#checks::f64) } else { shape.tokens() };
    let takers = ClosureChecks { checks: &checks, vector: &vector, untyped };
    let entries = match shape {
        Shape::Real => quote!(#checks::entry),
        Shape::Array(point, _) => {
            let entry = point.tokens();
            quote!(#checks::entries::<#entry, _>)
        }
    };
    let closures = declaration.in_order().map(|closure| {
        let rewritten = match closure.key.is_covector() {
            true => with_entries(&closure.closure, &entries),
            // Token for token.
            false => closure.tokens.clone(),
        };
        takers.check(system, closure, untyped.as_reals(rewritten, &checks))
    });
    let friction = declaration.friction.iter().map(|friction| takers.check_given(system, &friction.given));
    let temperature = declaration.temperature.iter().map(|given| takers.check_temperature(system, given));
    let frequency = declaration.frequency().map(|given| takers.check_given(system, given));
    let given = friction.chain(temperature).chain(frequency);
    let written = declaration.written_schemes().into_iter();
    let schemes =
        written.map(|(meant, written)| quote!(#checks::is_same::<#meant>(#checks::PhantomData::<#written>);));
    let special = special_methods(declaration);
    // Lints would fire a second time at the user's tokens. `rustc` and clippy see the closures only here, but
    // style messages about generated code are useless.
    quote! {
        #[allow(warnings, clippy::all, clippy::pedantic, clippy::nursery, clippy::restriction)]
        const _: () = {
            #[automatically_derived]
            impl #parameters #name #arguments #condition {
                fn __closures(&self) {
                    use #path as #checks;
                    #special
                    #(#schemes)*
                    #(#closures)*
                    #(#given)*
                }
            }
        };
    }
}

/// The traits of methods that `f64` does not have, where a closure may call one.
fn special_methods(declaration: &Declaration) -> Option<TokenStream> {
    let closures = declaration.in_order().map(|closure| &closure.tokens);
    let mut written = closures.chain(declaration.given().map(|given| &given.tokens));
    let calls_one = written.any(|tokens| NAMES.iter().any(|(name, ..)| tokens::mentions(tokens, name)));
    let root = &declaration.crate_path;
    calls_one.then(|| quote!(use #root::__private::{ErrorFunctions as _, SpecialFunctions as _};))
}

/// `checks`, with underscores if the user has that name.
fn unused_name(system: &Container, declaration: &Declaration) -> TokenStream {
    let given = declaration.given().map(|given| &given.tokens);
    let written = declaration.in_order().map(|closure| &closure.tokens).chain(given);
    let schemes = declaration.written_schemes().into_iter().map(|(_, written)| written);
    let (item, crate_path) = (&system.item, &declaration.crate_path);
    let used = words(quote!(#(#written)* #(#schemes)* #item #crate_path));
    let mut name = String::from("checks");
    while used.iter().any(|used| *used == name) {
        name.push('_');
    }
    Ident::new(&name, Span::call_site()).into_token_stream()
}

/// The generics of the struct as arguments. Numbers are in braces, as a type in scope may have their name.
fn arguments(generics: &Generics) -> TokenStream {
    let arguments = generics.params.iter().map(|parameter| match parameter {
        GenericParam::Lifetime(lifetime) => lifetime.lifetime.to_token_stream(),
        GenericParam::Type(ty) => ty.ident.to_token_stream(),
        GenericParam::Const(number) => {
            let number = &number.ident;
            quote!({ #number })
        }
    });
    quote!(<#( #arguments ),*>)
}

/// `sum()` and `product()` of real numbers, by their places: `rustc` cannot infer their type in
/// `0.5 * x.iter().sum()`, and the compiler knows it.
#[derive(Default)]
pub(super) struct Untyped(HashSet<String>);

impl Untyped {
    pub(super) fn insert(&mut self, method: &Ident) {
        self.0.insert(place(method));
    }

    /// The tokens with `sum::<f64>()` in their places.
    fn as_reals(&self, tokens: TokenStream, checks: &TokenStream) -> TokenStream {
        if self.0.is_empty() {
            return tokens;
        }
        tokens::replaced(tokens, &|token| match &token {
            TokenTree::Ident(name)
                if (name == "sum" || name == "product") && self.0.contains(&place(name)) =>
            {
                quote!(#name::<#checks::f64>)
            }
            _ => token.into(),
        })
    }
}

fn place(name: &Ident) -> String {
    format!("{:?}", name.span())
}

/// The functions of the run time that take closures, by the arguments of these.
struct ClosureChecks<'t> {
    checks: &'t TokenStream,
    vector: &'t TokenStream,
    untyped: &'t Untyped,
}

impl ClosureChecks<'_> {
    /// One closure as `rewritten`, with the fields it names in scope.
    fn check(&self, system: &Container, hamiltonian: &Hamiltonian, rewritten: TokenStream) -> TokenStream {
        let fields = fields_in(system, &hamiltonian.tokens);
        let closure = with_our_self(rewritten);
        let is_constraint = hamiltonian.key == Key::Constraint;
        let function = match (hamiltonian.closure.inputs.len(), &hamiltonian.family) {
            (1, None) if is_constraint => quote!(of_coordinates),
            (_, None) if is_constraint => quote!(of_coordinates_and_time),
            (2, Some(_)) if is_constraint => quote!(constraint_family),
            _ if is_constraint => quote!(constraint_family_of_time),
            (2, None) => quote!(of_state),
            (_, None) => quote!(of_time),
            (3, Some(_)) => quote!(family),
            _ => quote!(family_of_time),
        };
        let Self { checks, vector, .. } = self;
        let check = quote!(#checks::#function::<#vector, _>(#closure););
        if fields.is_empty() { check } else { quote!({ #(#fields)* #check }) }
    }

    /// An expression of fields, or a closure of the coordinates.
    fn check_given(&self, system: &Container, given: &DeclaredValue) -> TokenStream {
        let fields = fields_in(system, &given.tokens);
        let Self { checks, vector, untyped } = self;
        let expression = with_our_self(untyped.as_reals(given.tokens.clone(), checks));
        match given.value {
            syn::Expr::Closure(_) => quote!({ #(#fields)* #checks::of_place::<#vector, _, _>(#expression); }),
            _ => quote!({ #(#fields)* let _ = #expression; }),
        }
    }

    /// A temperature, whose closures are of the time, or of the index of a site and the time.
    fn check_temperature(&self, system: &Container, given: &DeclaredValue) -> TokenStream {
        let (fields, checks) = (fields_in(system, &given.tokens), self.checks);
        let own = |tokens: TokenStream| with_our_self(self.untyped.as_reals(tokens, checks));
        let of_time = |closure: &ExprClosure| {
            let closure = own(closure.to_token_stream());
            quote!(#checks::of_instant(#closure))
        };
        let is_closure = |expression: &Expr| matches!(peeled(expression), Expr::Closure(_));
        let check = match peeled(&given.value) {
            Expr::Closure(closure) => of_time(closure),
            Expr::Repeat(ExprRepeat { expr, len, .. }) if is_closure(expr) => {
                let (number, closure) = (own(len.to_token_stream()), own(expr.to_token_stream()));
                let is_timed = matches!(peeled(expr), Expr::Closure(closure) if closure.inputs.len() > 1);
                let taker = if is_timed { quote!(of_site_and_instant) } else { quote!(of_site) };
                quote!(#checks::#taker(#closure); let _ = #number)
            }
            Expr::Array(array) if array.elems.iter().any(is_closure) => {
                let elements = array.elems.iter().map(|element| match peeled(element) {
                    Expr::Closure(closure) => of_time(closure),
                    other => {
                        let number = own(other.to_token_stream());
                        quote!(let _: #checks::f64 = #number)
                    }
                });
                quote!(#(#elements);*)
            }
            _ => {
                let expression = own(given.tokens.clone());
                quote!(let _ = #expression)
            }
        };
        quote!({ #(#fields)* #check; })
    }
}

/// The fields that `tokens` name, as variables.
fn fields_in(system: &Container, tokens: &TokenStream) -> Vec<TokenStream> {
    let used = words(tokens.clone());
    system.fields.iter().flat_map(|field| bindings(field, &used)).collect()
}

/// A closure whose entries are consumed by an inner function, so that iterators may borrow its parameters.
fn with_entries(closure: &ExprClosure, entries: &TokenStream) -> TokenStream {
    let ExprClosure { lifetimes, capture, inputs_begin, inputs, inputs_end, body, .. } = closure;
    quote! { #lifetimes #capture #inputs_begin #inputs #inputs_end { #entries(#body) } }
}

/// `let a = self.a;`, with the span of a use: if the closure comes out of a macro, its names are from there.
/// Names from several macros get a variable each.
fn bindings(field: &Field, used: &[Ident]) -> Vec<TokenStream> {
    let Member::Named(member) = &field.member else { return Vec::new() };
    let mut contexts = HashSet::new();
    let names = used.iter().filter(|used| *used == member).filter(|used| contexts.insert(context(used)));
    let conditions = &field.conditions;
    let reference = (!is_scalar(field)).then(|| quote! { & });
    names.map(|name| quote! { #( #conditions )* let #name = #reference self.#member; }).collect()
}

/// Whether the field is copied into scope: then `a > 0.0` and `f64::sin(a)` are valid without `*`.
fn is_scalar(field: &Field) -> bool {
    matches!(field.kind, FieldKind::Real | FieldKind::Integer(_))
}

/// The tokens with every `self` referring to the surrounding method, whichever macro wrote it.
fn with_our_self(tokens: TokenStream) -> TokenStream {
    tokens::replaced(tokens, &|mut token| {
        if let TokenTree::Ident(name) = &mut token
            && *name == "self"
        {
            name.set_span(name.span().resolved_at(Span::call_site()));
        }
        token.into()
    })
}
