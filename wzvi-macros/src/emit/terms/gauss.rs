//! The slopes of the step Hamiltonian of a system in loops, and its flows.

use proc_macro2::TokenStream;
use quote::quote;

use crate::emit::implementation;
use crate::model::System;

/// `impl Field`
pub(crate) fn field(model: &System, is_nystrom: bool) -> TokenStream {
    let in_lanes = !model.acting().any(|element| model.graph.depends_on(element.value, &[model.t]));
    let bool = quote!(__wzvi::bool);
    let body = quote! {
        const IS_NYSTROM: #bool = #is_nystrom;
        const IN_LANES: #bool = #in_lanes;
        type Shape = __wzvi::gauss::Dynamic;
        type Noises = __wzvi::gauss::Dynamic;
        type Parameters = __wzvi::Reals<0>;

        fn parameters<__K: __wzvi::Constant>(&self, _: __wzvi::Lift<'_, __K>) -> [__K; 0] {
            []
        }
    };
    implementation(&model.item, &quote!(__wzvi::gauss::Field), &body)
}

/// Flows of large systems, window by window.
pub(crate) fn in_windows() -> TokenStream {
    let f64 = quote!(__wzvi::f64);
    quote! {
        fn take_windows<'p, __W: __wzvi::elements::Word>(
            &self,
            __word: &mut __W,
            __q: &[#f64],
            __p: &[#f64],
            __plan: &'p mut __wzvi::elements::WindowPlan,
        ) -> __wzvi::Option<__wzvi::Result<__wzvi::elements::Taken<'p>, __wzvi::StepFailure>> {
            __wzvi::elements::take_windows(self, __word, __q, __p, __plan)
        }
    }
}
