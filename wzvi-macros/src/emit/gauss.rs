//! The slopes of the step Hamiltonian, once for all numbers of stages, for `Gauss<S>` and for the flows of
//! `Verlet` and its compositions. Tests: `tests/steps/gauss.rs`.

use proc_macro2::{Literal, TokenStream};
use quote::{format_ident, quote};

use super::names::Namer;
use super::step::increment_names;
use super::system::{
    Body, Environment, Read, count, evaluation, evaluation_over, parameter_names, state_names,
};
use super::terms;
use super::{discretized, implementation};
use crate::describe::Texts;
use crate::discretise::{Facts, Plans, StepGradient};
use crate::model::{Element, StraightLine, System};
use crate::symbolic::{Expr, Graph};

/// Every listed `Gauss<S>`, and the flows.
pub(super) fn emit(system: &mut System, facts: &Facts, plans: &Plans, texts: &Texts) -> TokenStream {
    if plans.staged().next().is_none() && plans.flows.is_none() {
        return TokenStream::new();
    }
    let mut generated = field(system, facts.is_nystrom, plans);
    for (embedding, stages) in plans.staged() {
        let stages = Literal::u32_unsuffixed(stages);
        let gauss = quote!(__wzvi::embedding::Gauss<#stages>);
        generated.extend(discretized(&system.item, embedding, &gauss, texts.of(embedding), None));
    }
    generated
}

/// The type of a length: fixed at compile time, or not.
pub(crate) fn length_type(number: Option<usize>) -> TokenStream {
    match number.map(count) {
        Some(number) => quote!(__wzvi::gauss::Fixed<#number>),
        None => quote!(__wzvi::gauss::Dynamic),
    }
}

/// `impl Field`
fn field(system: &mut System, is_nystrom: bool, plans: &Plans) -> TokenStream {
    let Plans { flows, gradient, .. } = plans;
    let slopes = gradient.as_ref().map(|gradient| self::gradient(&mut system.graph, gradient));
    let line = gradient.as_ref().map(|gradient| &*gradient.line);
    let reads_time = |element: &Element| element.reads_time(&system.graph, system.t);
    let in_lanes = line.is_some() || !system.acting().any(reads_time);
    let noises = length_type(line.map(StraightLine::noises));
    let reads_time = flows.is_some_and(|flows| flows.force_reads_time);
    let reads_time = reads_time.then(|| {
        quote!(
            const FORCE_READS_TIME: __wzvi::bool = true;
        )
    });
    let in_windows = (flows.is_some() && line.is_none()).then(terms::in_tiles);
    let (reads, functions) = slopes.unwrap_or_default();
    let (number, numbers) = (count(reads.len()), reads.iter().map(|read| count(read.number)));
    let (bool, tokens) = (quote!(__wzvi::bool), reads.iter().map(|read| &read.tokens));
    let (parameters, lifted) = match line {
        Some(_) => (quote!(__wzvi::Reals<#number>), quote!([#(__lift(#numbers, #tokens)),*])),
        None => (quote!(__wzvi::Varied), quote!(__wzvi::varied(self, __lift))),
    };
    let body = quote! {
            const IS_NYSTROM: #bool = #is_nystrom;
            const IN_LANES: #bool = #in_lanes;
            #reads_time
            type Noises = #noises;
            type Parameters = #parameters;

            fn parameters<__K: __wzvi::Constant>(
                &self,
                __lift: __wzvi::LiftParameter<'_, __K>,
            ) -> __wzvi::ConstantsIn<Self::Parameters, __K> {
                #lifted
            }

            #in_windows

            #functions
    };
    implementation(&system.item, &quote!(__wzvi::gauss::Field), &body)
}

/// For a system in straight-line code: its parameters, the matrix of the linear force, and the slopes of
/// `F = h H_0 + Σ_k ΔW_k H_k`.
fn gradient(graph: &mut Graph, slopes: &StepGradient) -> (Vec<Read>, TokenStream) {
    let line = &*slopes.line;
    let phase = &line.phase;
    let mut names = Namer::default();
    let [q, p] = state_names(&mut names, graph, phase);
    let own = parameter_names(&mut names, graph, &line.parameters);
    let dw = increment_names(&mut names, slopes.dw.len());
    let symbols = phase.q.iter().chain(&phase.p).chain(&slopes.dw).copied();
    let mut state: Vec<_> = symbols.zip(q.iter().chain(&p).chain(&dw).cloned()).collect();
    // Times and weights differ between stages.
    state.extend([(phase.t, format_ident!("__t")), (slopes.h, format_ident!("__h"))]);
    let roots = [slopes.by_q.as_slice(), slopes.by_p.as_slice()].concat();
    let (scalar, constant) = (quote!(__S), quote!(__K));
    let environment =
        Environment { names, parameters: own, state, scalar: Some(&scalar), constant: &constant };
    let Body { statements, values, reads } = evaluation_over(graph, &line.parameters, environment, &roots);
    let parameters: Vec<_> = reads.iter().map(|read| &read.name).collect();
    let open = (!parameters.is_empty()).then(|| quote!(let [#(#parameters),*] = *__parameters;));
    let (by_q, by_p) = values.split_at(phase.q.len());
    let (stiffness, bool) = (stiffness(graph, slopes), quote!(__wzvi::bool));
    let functions = quote! {
            #stiffness

            #[cfg_attr(not(debug_assertions), inline(always))]
            fn step_gradient<__K: __wzvi::Constant, __S: __wzvi::ComputesWith<__K>, const __BY_Q: #bool, const __BY_P: #bool>(
                &self,
                __parameters: &__wzvi::ConstantsIn<Self::Parameters, __K>,
                ([__t, __h], [__coordinates, __momenta], __increments): __wzvi::elements::FieldAt<'_, __S>,
                [__by_q, __by_p]: [&mut [__S]; 2],
                _: &mut __wzvi::elements::PairColumns,
            ) {
                #open
                let (&[#(#q),*], &[#(#p),*], &[#(#dw),*]) = (__coordinates, __momenta, __increments) else {
                    return __wzvi::gauss::unfit(__by_q, __by_p);
                };
                #statements
                if __BY_Q {
                    __by_q.copy_from_slice(&[#(#by_q),*]);
                }
                if __BY_P {
                    __by_p.copy_from_slice(&[#(#by_p),*]);
                }
            }
    };
    (reads, functions)
}

/// The matrix of the linear part of the force, where there is one.
fn stiffness(graph: &mut Graph, slopes: &StepGradient) -> TokenStream {
    let line = &*slopes.line;
    if slopes.stiffness.is_empty() {
        return TokenStream::new();
    }
    let roots: Vec<Expr> = slopes.stiffness.iter().map(|&(.., value)| value).collect();
    let Body { statements, values, .. } = evaluation(graph, &line.parameters, &roots);
    let degrees = line.phase.q.len();
    let places =
        slopes.stiffness.iter().map(|(row, column, _)| Literal::usize_unsuffixed(row * degrees + column));
    quote! {
        const IS_STIFF: __wzvi::bool = true;

        fn stiffness<__K: __wzvi::Constant>(&self, __parameters: &[__K], __k: &mut [__K]) {
            #statements
            #(__k[#places] = #values;)*
        }
    }
}
