//! The step of one scheme as straight-line code.

use proc_macro2::{Ident, TokenStream};
use quote::quote;

use super::names::Names;
use super::plan::plan;
use super::system::{count, state_names};
use super::terms;
use super::{implementation, listed};
use crate::discretise::{Facts, NoiseClass, Scheme, Strategy, Unknowns};
use crate::model::StraightLine;
use crate::symbolic::Graph;

mod flow;
mod given;
mod memory;
mod prepare;
mod solve;

use flow::Flow;
use prepare::Prepared;
use solve::Arguments;

/// `dw`, or `dw1`, `dw2`, ... as in the equations.
pub(crate) fn increment_names(names: &mut Names, noises: usize) -> Vec<Ident> {
    match noises {
        1 => vec![names.take("dw")],
        _ => names.take_all((1..=noises).map(|k| format!("dw{k}"))),
    }
}

/// The implementation of one scheme.
pub(crate) fn emit(
    item: &syn::ItemStruct,
    (graph, line): (&mut Graph, &StraightLine),
    facts: &Facts,
    scheme: &Scheme,
    (text, is_alone): (&str, bool),
) -> TokenStream {
    let flow = Flow::new(graph, &line.parameters, scheme, facts.noise == NoiseClass::None);
    let noises = scheme.lagrangian.symbols.dw.len();
    let mut names = Names::default();
    let [q, p] = state_names(&mut names, graph, &line.phase);
    let arguments = Arguments { q, p, dw: increment_names(&mut names, noises) };
    let prepared = Prepared::new(&flow, graph, &line.parameters, &mut names);
    let solve::Solution { functions, statements } = solve::solution(&flow, &prepared, &arguments, names);
    let Arguments { q, p, dw } = arguments;
    let state = match dw.is_empty() {
        true => quote!(let ([#(#q),*], [#(#p),*]) = (__coordinates, __momenta);),
        false => quote!(let ([#(#q),*], [#(#p),*], [#(#dw),*]) = (__coordinates, __momenta, __increments);),
    };
    let (open, prepared_type) = (prepared.open(), prepared.ty());
    let (prepare, memory) = (&prepared.body, memory::memory_type(&flow.newton_sizes()));
    let (d, n) = (count(q.len()), count(noises));
    let carry = match flow.affords_compensation() {
        true => quote!(__wzvi::Compensation<__S, #d>),
        false => quote!(__wzvi::Plain),
    };
    // For a step in loops, at most the momentum between two ends.
    let strategy = Strategy { unknowns: Unknowns::Momenta, is_linear: false };
    let quadrature = terms::quadrature(facts, &scheme.embedding, strategy, false);
    let plan = plan(scheme);
    let embedding = scheme.embedding.path(&quote!(__wzvi));
    let body = quote! {
            const PLAN: __wzvi::Plan = #plan;
            const QUADRATURE: __wzvi::elements::Quadrature = #quadrature;
            type Prepared = #prepared_type;
            type Memory<__S: __wzvi::Scalar> = #memory;
            type Carry<__S: __wzvi::Scalar> = #carry;

            fn prepare<__K: __wzvi::Constant>(
                &self,
                __lift: __wzvi::Lift<'_, __K>,
                __h: __K,
            ) -> __wzvi::Result<__wzvi::Of<Self::Prepared, __K>, __wzvi::ConfigError> {
                #prepare
            }

            #[cfg_attr(not(debug_assertions), inline(always))]
            fn solve<
                __S: __wzvi::Over<__K>,
                __K: __wzvi::Constant,
                __C: __wzvi::Carry<__S>,
                const __CAREFUL: __wzvi::bool,
            >(
                __prepared: &__wzvi::Of<Self::Prepared, __K>,
                __t: __K,
                __h: __K,
                __coordinates: [__S; #d],
                __momenta: [__S; #d],
                __increments: [__S; #n],
                __memory: &mut Self::Memory<__S>,
                __carry: &__C,
                __next: &mut __wzvi::Solution<__S, #d>,
            ) -> __wzvi::Result<(), __wzvi::StepFailure> {
                #state
                #open
                #statements
            }
    };
    let step = implementation(item, &quote!(__wzvi::StraightLine<#embedding, #d, #n>), &body);
    let step = quote!(#functions #step);
    // The names of the equations differ between schemes.
    let step = match is_alone || functions.is_empty() {
        true => step,
        false => quote!(const _: () = { #step };),
    };
    let straight = quote!(__wzvi::Straight<#embedding, #d, #n>);
    let listed = listed(item, &embedding, &straight, text);
    quote!(#step #listed)
}
