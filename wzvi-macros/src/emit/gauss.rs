//! The slopes of the step Hamiltonian, once for all numbers of stages, and what reads them: `Gauss<S>`, and the
//! flows that `Verlet` and its compositions are made of.

use std::collections::HashMap;

use proc_macro2::{Literal, TokenStream};
use quote::{format_ident, quote};

use super::compose;
use super::listed::{implementation, listed};
use super::names::Names;
use super::print::f64_type;
use super::program::Level;
use super::step::increment_names;
use super::system::{Body, Inputs, Letters, count, evaluation, evaluation_over};
use super::terms;
use crate::describe::Texts;
use crate::discretise::{Facts, StepSlopes, is_nystrom};
use crate::model::{StraightLine, System};
use crate::symbolic::{Expr, Graph};

/// Every `Gauss<S>` that was listed, and the flows.
pub(super) fn emit(
    system: &mut System,
    line: Option<&StraightLine>,
    facts: &Facts,
    texts: &Texts,
) -> TokenStream {
    if texts.staged().next().is_none() && texts.flows.is_none() {
        return TokenStream::new();
    }
    let is_nystrom = is_nystrom(system, facts);
    let (mut generated, in_windows) = match line {
        Some(line) => (field(&system.item, (&mut system.graph, line), is_nystrom), TokenStream::new()),
        None => (terms::field(system, is_nystrom), terms::in_windows()),
    };
    if let Some(flows) = texts.flows {
        generated.extend(compose::flows(&system.item, flows, &in_windows));
    }
    for (embedding, stages, text) in texts.staged() {
        let (scheme, stages) = (embedding.path(&quote!(__wzvi)), Literal::u32_unsuffixed(stages));
        let gauss = quote!(__wzvi::embedding::Gauss<#stages>);
        generated.extend(listed(&system.item, &scheme, &gauss, text));
    }
    generated
}

/// The slopes of `F = h H_0 + Σ_k ΔW_k H_k`.
fn field(
    item: &syn::ItemStruct,
    (graph, line): (&mut Graph, &StraightLine),
    is_nystrom: bool,
) -> TokenStream {
    let slopes = StepSlopes::new(graph, line, is_nystrom);
    let phase = &line.phase;
    let degrees = phase.q.len();
    let mut letters = Letters::of(graph, line, Names::default());
    let dw = increment_names(&mut letters.names, slopes.dw.len());
    let (q, p) = (&letters.q, &letters.p);
    let of_state = phase.q.iter().zip(q).chain(phase.p.iter().zip(p)).chain(slopes.dw.iter().zip(&dw));
    let mut names: Vec<_> = of_state.map(|(&symbol, name)| (symbol, name.clone(), Level::State)).collect();
    // Stages have times and weights of their own.
    names.push((phase.t, format_ident!("__t"), Level::State));
    names.push((slopes.h, format_ident!("__h"), Level::State));
    let inputs = Inputs { names, definitions: HashMap::new() };
    let roots = [slopes.by_q.as_slice(), slopes.by_p.as_slice()].concat();
    let numbers = (&quote!(__S), Some(quote!(__K)));
    let system = (&mut *graph, line.parameters.as_slice());
    let (Body { statements, values }, reads) = evaluation_over(system, &letters, &inputs, numbers, &roots);
    let (number, numbers) = (count(reads.len()), reads.iter().map(|read| count(read.number)));
    let (parameters, tokens): (Vec<_>, Vec<_>) = reads.iter().map(|read| (&read.name, &read.tokens)).unzip();
    let open = (!parameters.is_empty()).then(|| quote!(let [#(#parameters),*] = *__parameters;));
    let (by_q, by_p) = values.split_at(degrees);
    let (degrees, noises) = (count(degrees), count(dw.len()));
    let stiffness = stiffness(graph, line, &slopes);
    let bool = quote!(__wzvi::bool);
    let body = quote! {
            const IS_NYSTROM: #bool = #is_nystrom;
            const IN_LANES: #bool = true;
            type Shape = __wzvi::gauss::Fixed<#degrees>;
            type Noises = __wzvi::gauss::Fixed<#noises>;

            #stiffness

            type Parameters = __wzvi::Reals<#number>;

            fn parameters<__K: __wzvi::Constant>(
                &self,
                __lift: __wzvi::Lift<'_, __K>,
            ) -> __wzvi::Of<Self::Parameters, __K> {
                [#(__lift(#numbers, #tokens)),*]
            }

            #[cfg_attr(not(debug_assertions), inline(always))]
            fn step_slopes<__K: __wzvi::Constant, __S: __wzvi::Over<__K>, const __BY_Q: #bool, const __BY_P: #bool>(
                &self,
                __parameters: &__wzvi::Of<Self::Parameters, __K>,
                __t: __S,
                __h: __S,
                __coordinates: &[__S],
                __momenta: &[__S],
                __increments: &[__S],
                __by_q: &mut [__S],
                __by_p: &mut [__S],
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
    implementation(item, &quote!(__wzvi::gauss::Field), &body)
}

/// The matrix of the linear part of the force, where there is one.
fn stiffness(graph: &mut Graph, line: &StraightLine, slopes: &StepSlopes) -> TokenStream {
    if slopes.stiffness.is_empty() {
        return TokenStream::new();
    }
    let letters = Letters::of(graph, line, Names::default());
    let inputs = Inputs { names: Vec::new(), definitions: HashMap::new() };
    let roots: Vec<Expr> = slopes.stiffness.iter().map(|&(.., value)| value).collect();
    let f64 = f64_type();
    let Body { statements, values } = evaluation((graph, &line.parameters), &letters, &inputs, &f64, &roots);
    let degrees = line.phase.q.len();
    let places =
        slopes.stiffness.iter().map(|(row, column, _)| Literal::usize_unsuffixed(row * degrees + column));
    quote! {
        const IS_STIFF: __wzvi::bool = true;

        fn stiffness(&self, __k: &mut [#f64]) {
            #statements
            #(__k[#places] = #values;)*
        }
    }
}
