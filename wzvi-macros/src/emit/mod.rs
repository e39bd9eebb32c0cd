//! From equations to Rust: the struct as written, and its traits.

pub(crate) mod compose;
pub(crate) mod export;
mod gauss;
pub(crate) mod names;
mod overrides;
pub(crate) mod plan;
mod print;
mod program;
pub(crate) mod step;
pub(crate) mod stubs;
mod system;
pub(crate) mod terms;

use proc_macro2::TokenStream;
use quote::{ToTokens, quote};

use crate::describe::Texts;
use crate::discretise::{Facts, Plans, Step};
use crate::embedding::Embedding;
use crate::model::{Clock, System};

pub(crate) use names::Namer;
use names::readable;
pub(crate) use print::{Printer, Rank, f64_type};
pub(crate) use program::{Level, Lowering, Op};
pub(crate) use system::{Body, count, evaluation, parameter_names};

/// The expansion of a struct.
pub(crate) struct Expansion {
    pub(crate) doc: TokenStream,
    pub(crate) item: syn::ItemStruct,
    pub(crate) implementations: TokenStream,
}

/// The struct as written, with documentation; and, in a scope of its own, the implementations: terms,
/// elements and steps.
pub(crate) fn emit(system: &mut System, facts: &Facts, plans: &Plans, texts: &Texts) -> Expansion {
    let mut generated = terms::elements(system, facts, plans);
    generated.extend(terms::constraints(system, facts));
    generated.extend(clock(system));
    let stepped = plans.stepped();
    let is_alone = stepped.len() == 1;
    for plan in stepped {
        let text = texts.of(&plan.embedding);
        generated.extend(match &plan.step {
            Step::StraightLine(scheme) => {
                step::emit(&system.item, &mut system.graph, facts, plan, scheme, text, is_alone)
            }
            Step::InLoops(strategy) => terms::step(system, plan, *strategy, text),
        });
    }
    generated.extend(gauss::emit(system, facts, plans, texts));
    generated.extend(compose::emit(&system.item, plans, texts));
    let conservative = || implementation(&system.item, &quote!(__wzvi::Conservative), &TokenStream::new());
    generated.extend(facts.energy.is_conservative.then(conservative));
    let read = terms::user_tokens(system);
    let listed = system.listed().iter().map(|parameter| &parameter.tokens);
    let (item, type_checks) = (&system.item, &system.type_checks);
    let tokens = with_header(item, read.iter().chain(listed));
    let generated = readable(generated, &system.crate_path, tokens, type_checks, &item.generics);
    let implementations = quote! {
        #[allow(warnings, clippy::all, clippy::pedantic, clippy::nursery, clippy::restriction)]
        const _: () = {
            #generated
        };
        #type_checks
    };
    Expansion { doc: documentation(system, plans, texts), item: system.item.clone(), implementations }
}

/// The user's tokens in the implementations: the struct with its generics, and the tokens in `read`. Types of
/// const generics are left out, as they are primitive.
fn with_header<'t>(item: &syn::ItemStruct, read: impl Iterator<Item = &'t TokenStream>) -> TokenStream {
    let parameters = item.generics.params.iter().map(|parameter| match parameter {
        syn::GenericParam::Const(constant) => constant.ident.to_token_stream(),
        other => other.to_token_stream(),
    });
    let (name, filter, read) = (&item.ident, &item.generics.where_clause, read.collect::<Vec<_>>());
    quote!(#name #(; #parameters)* #filter #(; #read)*)
}

/// The equations as rustdoc of the struct.
fn documentation(system: &System, plans: &Plans, texts: &Texts) -> TokenStream {
    let clock = system.clock.iter().map(|clock| format!("```text\n{}```\n", clock.text));
    let blocks = plans.listed.iter().map(|listed| format!("```text\n{}\n```\n", texts.of(listed)));
    let text = format!("\n# Discrete equations\n\n{}", clock.chain(blocks).collect::<Vec<_>>().join("\n"));
    quote!(#[doc = #text])
}

/// `impl Clock`, and what schemes with steps of other lengths take for granted.
fn clock(system: &System) -> TokenStream {
    let mut generated = TokenStream::new();
    if let Some(Clock { text, .. }) = &system.clock {
        let body = quote! {
            const CLOCK: &'static __wzvi::str = #text;
        };
        generated.extend(implementation(&system.item, &quote!(__wzvi::clock::Clock), &body));
    }
    if system.is_extended() {
        let values = system.clock.iter().flat_map(|clock| &clock.term.values);
        let reads_time = values.into_iter().any(|element| element.reads_time(&system.graph, system.t));
        // The time in the drift is a fact of the system.
        let reads_time = reads_time.then(|| {
            quote!(
                const READS_TIME: __wzvi::bool = true;
            )
        });
        generated.extend(implementation(&system.item, &quote!(__wzvi::clock::Extends), &quote!(#reads_time)));
    }
    if system.is_logarithmic() {
        let attractive = quote!(__wzvi::clock::Attractive);
        generated.extend(implementation(&system.item, &attractive, &TokenStream::new()));
    }
    generated
}

/// `impl Trait for` the struct.
pub(crate) fn implementation(item: &syn::ItemStruct, of: &TokenStream, body: &TokenStream) -> TokenStream {
    let name = &item.ident;
    let (parameters, arguments, filter) = item.generics.split_for_impl();
    quote! {
        #[automatically_derived]
        impl #parameters #of for #name #arguments #filter {
            #body
        }
    }
}

/// `impl Discretized<E>`: the scheme type and its equations; of steps in loops, their data, too.
pub(crate) fn discretized(
    item: &syn::ItemStruct,
    embedding: &Embedding,
    scheme: &TokenStream,
    text: &str,
    in_loops: Option<TokenStream>,
) -> TokenStream {
    let embedding = embedding.path(&quote!(__wzvi));
    let body = quote! {
        type Scheme = #scheme;
        type Prepared = <Self::Scheme as __wzvi::Scheme<Self>>::Prepared<__wzvi::f64>;
        const EQUATIONS: &'static __wzvi::str = #text;
        #in_loops
    };
    implementation(item, &quote!(__wzvi::Discretized<#embedding>), &body)
}
