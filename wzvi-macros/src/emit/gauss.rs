//! `impl Discretized<Gauss<S>>`: the slopes of the step Hamiltonian, once for all numbers of stages.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::plan::Plan;
use super::print::f64_type;
use super::program::Level;
use super::system::{Body, body, indexed, phase_inputs};
use crate::describe::Texts;
use crate::discretise::facts::Facts;
use crate::discretise::gauss::StepSlopes;
use crate::model::Model;

/// Every `Gauss<S>` that was listed.
pub(super) fn emit(model: &mut Model, facts: &Facts, texts: &Texts) -> TokenStream {
    let staged: Vec<(u32, &String)> = texts.staged().collect();
    if staged.is_empty() {
        return TokenStream::new();
    }
    let mut generated = field(model);
    let name = &model.item.ident;
    let (generics, arguments, filter) = model.item.generics.split_for_impl();
    let degrees = model.phase.q.len();
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
    for (stages, text) in staged {
        let stages = Literal::u32_unsuffixed(stages);
        generated.extend(quote! {
            __wzvi::gauss! {
                [impl #generics __wzvi::Discretized<__wzvi::embedding::Gauss<#stages>> for #name #arguments #filter]
                #stages, #midpoint, #degrees, #text
            }
        });
    }
    generated
}

/// The slopes of `F = h H_0 + Σ_k ΔW_k H_k`.
fn field(model: &mut Model) -> TokenStream {
    let slopes = StepSlopes::new(model);
    let (degrees, noises) = (model.phase.q.len(), slopes.dw.len());
    let mut inputs = phase_inputs(&model.phase);
    for (symbol, _, level) in &mut inputs.names {
        // Stages have times of their own.
        if *symbol == model.phase.t {
            *level = Level::State;
        }
    }
    inputs.names.push((slopes.h, quote::format_ident!("__h"), Level::Prepared));
    let dw = indexed("dw", noises);
    inputs
        .names
        .extend(slopes.dw.iter().zip(&dw).map(|(&symbol, name)| (symbol, name.clone(), Level::State)));
    let scalar = quote!(__S);
    let roots = [slopes.by_q.as_slice(), slopes.by_p.as_slice()].concat();
    let Body { statements, values } = body(&mut model.graph, &model.parameters, &inputs, &scalar, &roots);
    let (by_q, by_p) = values.split_at(degrees);
    let (q, p) = (indexed("q", degrees), indexed("p", degrees));
    let name = &model.item.ident;
    let (generics, arguments, filter) = model.item.generics.split_for_impl();
    let (f64, bool) = (f64_type(), quote!(__wzvi::core::primitive::bool));
    let is_nystrom = slopes.is_nystrom;
    quote! {
        #[automatically_derived]
        impl #generics __wzvi::gauss::Field for #name #arguments #filter {
            const IS_NYSTROM: #bool = #is_nystrom;
            const IN_LANES: #bool = true;
            type Shape = __wzvi::gauss::Fixed<#degrees>;

            #[inline(always)]
            fn slopes<__S: __wzvi::Scalar, const __BY_Q: #bool, const __BY_P: #bool>(
                &self,
                __t: __S,
                __h: #f64,
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
