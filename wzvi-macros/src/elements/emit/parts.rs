//! The parts of `drift = [H_A, H_B]` of a system of elements: parts with numbers of their own.

use proc_macro2::TokenStream;
use quote::quote;

use super::{Wanted, derivatives, values};
use crate::describe::Texts;
use crate::discretise::facts::Facts;
use crate::discretise::quadrature::Part;
use crate::elements::parts::unweighted;
use crate::emit::count;
use crate::emit::parts::Parts;
use crate::model::System;

/// The numbers of what stands behind the parts of the step Hamiltonian: the parts of the drift, friction, temperature, first integrals.
pub(super) struct Numbers {
    pub(super) parts: usize,
    pub(super) friction: usize,
    pub(super) temperature: usize,
    pub(super) integrals: usize,
}

impl Numbers {
    pub(super) fn of(model: &System) -> Self {
        let last = if model.force.is_some() { Part::Force } else { Part::CounterTerm };
        let parts = last as usize + 1;
        let friction = parts + model.parts.len();
        let temperature = friction + usize::from(model.friction.is_some());
        let integrals = temperature + usize::from(model.temperature.is_some());
        Self { parts, friction, temperature, integrals }
    }
}

/// The arms of values or slopes.
pub(super) fn arms(model: &mut System, wanted: Wanted) -> TokenStream {
    let number = wanted.number();
    let weight = quote!(#number::from_f64(__at.h));
    let numbers = Numbers::of(model);
    let parts = model.parts.iter().cloned().zip(numbers.parts..);
    let friction = model.friction.clone().map(|mut friction| {
        if !friction.is_matrix {
            // Rates alone, without the momenta that they act on.
            let one = model.graph.integer(1);
            for element in &mut friction.term.elements {
                let momenta = element.momenta().map(|(momentum, _)| (momentum, one)).collect();
                element.value = model.graph.substitute(&[element.value], &momenta)[0];
            }
        }
        (friction.term, numbers.friction)
    });
    let temperature = model.temperature.iter().map(|term| (term.clone(), numbers.temperature));
    let of_bath: Vec<_> = match wanted {
        Wanted::Value => temperature.collect(),
        Wanted::Slopes | Wanted::Curvature => friction.into_iter().collect(),
    };
    let terms: Vec<_> = parts.chain(of_bath).collect();
    let arms = terms.into_iter().map(|(term, number)| {
        let code: TokenStream = match wanted {
            Wanted::Value => values(model, &unweighted(&term.values), Some(&weight)),
            Wanted::Slopes | Wanted::Curvature => {
                let elements = unweighted(&term.elements);
                elements.iter().map(|weighted| derivatives(model, weighted, wanted, &weight)).collect()
            }
        };
        let number = count(number);
        quote!(#number => { #code })
    });
    arms.collect()
}

/// `impl Parts`, if the user has parted the drift.
pub(super) fn emit(model: &System, facts: &Facts, texts: &Texts) -> TokenStream {
    let Some(forms) = texts.parts else { return TokenStream::new() };
    let first = Numbers::of(model).parts;
    let of_part = |code: &dyn Fn(TokenStream) -> TokenStream| -> Vec<TokenStream> {
        (first..first + 2)
            .map(|number| {
                let number = count(number);
                let code = code(quote!(#number));
                quote!(_ => #code,)
            })
            .collect()
    };
    let slopes = of_part(&|number| {
        quote! {
            __wzvi::elements::slopes_of_part::<_, __S, __BY_Q, __BY_P>(
                self, #number, __t, __h, __q, __p, __by_q, __by_p,
            )
        }
    });
    let values = of_part(&|number| quote!(__wzvi::elements::value_of_part(self, #number, __t, __q, __p)));
    let parts = Parts { forms, shape: quote!(__wzvi::gauss::Dynamic), slopes, values };
    parts.emit(&model.item, facts)
}
