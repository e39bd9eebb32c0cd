//! `impl Hamiltonian`: what the run time does for any sum of elements, by name.

use proc_macro2::TokenStream;
use quote::quote;

use super::{degrees, noise_count, vector_type};
use crate::discretise::facts::split;
use crate::emit::{
    f64_type, friction_rate, invariants, number_of, parameter, reads_time, validate, variables,
};
use crate::model::System;

/// `impl Hamiltonian`
pub(super) fn emit(model: &mut System) -> TokenStream {
    let friction = model.conformal.map(|rate| friction_rate(&mut model.graph, &model.parameters, rate));
    let model = &*model;
    let vector = vector_type(model);
    let reads_time = split::reads_time(&model.graph, &model.drift, model.t).then(reads_time);
    let degrees = degrees(model);
    let noises = (!model.noise.is_empty()).then(|| number_of("noises", &noise_count(model)));
    let (usize, f64) = (quote!(__wzvi::usize), f64_type());
    let invariants = invariants(&model.invariant_names);
    let invariant = invariants.is_some().then(|| {
        quote! {
            fn invariant(&self, __number: #usize, __state: &__wzvi::State<Self::Vector>) -> #f64 {
                __wzvi::elements::invariant(self, __number, __state)
            }
        }
    });
    let name = &model.item.ident;
    let (generics, arguments, filter) = model.item.generics.split_for_impl();
    let parameter = parameter(&model.graph, &model.parameters);
    let validate = validate(&model.embeddings, model.friction.is_some());
    let force = model.force.is_some().then(|| {
        quote! {
            const IS_FORCED: __wzvi::bool = true;

            fn force<__S: __wzvi::Scalar>(&self, __q: &[__S], __p: &[__S], __t: #f64, __into: &mut [__S]) {
                __wzvi::elements::force(self, __q, __p, __t, __into);
            }
        }
    });
    let of_noises = (!model.noise.is_empty()).then(|| {
        quote! {
            fn differentiate_noises(
                &self,
                __dw: &[#f64],
                __state: &__wzvi::State<Self::Vector>,
                __into: &mut __wzvi::Gradient<Self::Vector>,
            ) {
                __wzvi::elements::differentiate_noises(self, __dw, __state, __into);
            }
        }
    });
    let variables = variables(&model.labels, model.graph.symbol_name(model.t));
    quote! {
        #[automatically_derived]
        impl #generics __wzvi::Hamiltonian for #name #arguments #filter {
            type Vector = #vector;

            #reads_time

            #friction

            fn degrees(&self) -> #usize { #degrees }

            fn check(
                &self,
                __degrees: #usize,
            ) -> __wzvi::Result<(), __wzvi::StepFailure> {
                __wzvi::elements::check(self, __degrees)
            }

            #noises

            #invariants

            #variables

            #parameter

            fn evaluate<__S: __wzvi::Scalar>(&self, __term: #usize, __q: &[__S], __p: &[__S], __t: #f64) -> __S {
                __wzvi::elements::evaluate(self, __term, __q, __p, __t)
            }

            fn differentiate<__S: __wzvi::Scalar>(
                &self,
                __term: #usize,
                __q: &[__S],
                __p: &[__S],
                __t: #f64,
                __by_q: &mut [__S],
                __by_p: &mut [__S],
            ) {
                __wzvi::elements::differentiate(self, __term, __q, __p, __t, __by_q, __by_p);
            }

            #of_noises

            #force

            #validate

            #invariant
        }
    }
}
