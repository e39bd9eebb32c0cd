//! The slopes of the step Hamiltonian, once for all numbers of stages, and what reads them: `impl Discretized<Gauss<S>>`, and the
//! flows that `Verlet` and its compositions are made of.

use std::collections::HashMap;

use proc_macro2::{Literal, TokenStream};
use quote::{format_ident, quote};

use super::names::Names;
use super::plan::Plan;
use super::print::f64_type;
use super::program::Level;
use super::step::increment_names;
use super::system::{Body, Inputs, Letters, body, count};
use super::{compose, embedding_type};
use crate::describe::Texts;
use crate::discretise::embedding::Embedding;
use crate::discretise::facts::Facts;
use crate::discretise::gauss::StepSlopes;
use crate::model::Model;
use crate::symbolic::Expr;

/// Every `Gauss<S>` that was listed, and the flows.
pub(super) fn emit(model: &mut Model, facts: &Facts, texts: &Texts) -> TokenStream {
    let staged: Vec<(&Embedding, u32, &String)> = texts.staged().collect();
    if staged.is_empty() && texts.flows.is_none() {
        return TokenStream::new();
    }
    let mut generated = field(model);
    if let Some(flows) = texts.flows {
        generated.extend(compose::flows(&model.item, flows, facts, &TokenStream::new()));
    }
    let name = &model.item.ident;
    let (generics, arguments, filter) = model.item.generics.split_for_impl();
    let degrees = count(model.phase.q.len());
    let midpoint = Plan {
        solver: quote!(Newton),
        unknowns: quote!(0),
        order: 2,
        noise: facts.noise,
        consistent: true,
        conserves_energy: &facts.conserves_energy,
        commuting: &facts.commuting,
    }
    .emit();
    for (embedding, stages, text) in staged {
        let (scheme, stages) = (embedding_type(embedding, &quote!(__wzvi)), Literal::u32_unsuffixed(stages));
        generated.extend(quote! {
            __wzvi::gauss! {
                [impl #generics __wzvi::Discretized<#scheme> for #name #arguments #filter]
                #scheme, #stages, #midpoint, #degrees, #text
            }
        });
    }
    generated
}

/// The slopes of `F = h H_0 + Σ_k ΔW_k H_k`.
fn field(model: &mut Model) -> TokenStream {
    let slopes = StepSlopes::new(model);
    let degrees = model.phase.q.len();
    let mut letters = Letters::of(model, Names::beside(&["t", "h", "by_q", "by_p"]));
    let dw = increment_names(&mut letters.names, slopes.dw.len());
    let (q, p) = (&letters.q, &letters.p);
    let of_state =
        model.phase.q.iter().zip(q).chain(model.phase.p.iter().zip(p)).chain(slopes.dw.iter().zip(&dw));
    let mut names: Vec<_> = of_state.map(|(&symbol, name)| (symbol, name.clone(), Level::State)).collect();
    // Stages have times and weights of their own.
    names.push((model.phase.t, format_ident!("__t"), Level::State));
    names.push((slopes.h, format_ident!("__h"), Level::State));
    let inputs = Inputs { names, definitions: HashMap::new() };
    let roots = [slopes.by_q.as_slice(), slopes.by_p.as_slice()].concat();
    let Body { statements, values } = body(model, &letters, &inputs, &quote!(__S), &roots);
    let (by_q, by_p) = values.split_at(degrees);
    let (degrees, noises) = (count(degrees), count(dw.len()));
    let stiffness = stiffness(model, &slopes);
    let name = &model.item.ident;
    let (generics, arguments, filter) = model.item.generics.split_for_impl();
    let bool = quote!(__wzvi::bool);
    let is_nystrom = slopes.is_nystrom;
    quote! {
        #[automatically_derived]
        impl #generics __wzvi::gauss::Field for #name #arguments #filter {
            const IS_NYSTROM: #bool = #is_nystrom;
            const IN_LANES: #bool = true;
            type Shape = __wzvi::gauss::Fixed<#degrees>;
            type Noises = __wzvi::gauss::Fixed<#noises>;

            #stiffness

            #[inline(always)]
            fn slopes<__S: __wzvi::Scalar, const __BY_Q: #bool, const __BY_P: #bool>(
                &self,
                __t: __S,
                __h: __S,
                __q: &[__S],
                __p: &[__S],
                __dw: &[__S],
                __by_q: &mut [__S],
                __by_p: &mut [__S],
            ) {
                let (&[#(#q),*], &[#(#p),*], &[#(#dw),*]) = (__q, __p, __dw) else {
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
        }
    }
}

/// The matrix of the linear part of the force, where there is one.
fn stiffness(model: &mut Model, slopes: &StepSlopes) -> TokenStream {
    if slopes.stiffness.is_empty() {
        return TokenStream::new();
    }
    let letters = Letters::of(model, Names::beside(&["k"]));
    let inputs = Inputs { names: Vec::new(), definitions: HashMap::new() };
    let roots: Vec<Expr> = slopes.stiffness.iter().map(|&(.., value)| value).collect();
    let f64 = f64_type();
    let Body { statements, values } = body(model, &letters, &inputs, &f64, &roots);
    let degrees = model.phase.q.len();
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
