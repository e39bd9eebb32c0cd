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

/// The number behind those of the parts of the step Hamiltonian: those of the drift's parts, then first integrals.
pub(super) const END: usize = Part::CounterTerm as usize + 1;

/// The arms of values or slopes.
pub(super) fn arms(model: &mut System, wanted: Wanted) -> TokenStream {
    let number = wanted.number();
    let weight = quote!(#number::from_f64(__at.h));
    let terms = model.parts.clone();
    let arms = terms.iter().enumerate().map(|(k, term)| {
        let code: TokenStream = match wanted {
            Wanted::Value => values(model, &unweighted(&term.values), Some(&weight)),
            Wanted::Slopes | Wanted::Curvature => {
                let elements = unweighted(&term.elements);
                elements.iter().map(|weighted| derivatives(model, weighted, wanted, &weight)).collect()
            }
        };
        let number = count(END + k);
        quote!(#number => { #code })
    });
    arms.collect()
}

/// `impl Parts`, if the user has parted the drift.
pub(super) fn emit(model: &System, facts: &Facts, texts: &Texts) -> TokenStream {
    let Some(forms) = texts.parts else { return TokenStream::new() };
    let of_part = |code: &dyn Fn(TokenStream) -> TokenStream| -> Vec<TokenStream> {
        (END..END + 2)
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
