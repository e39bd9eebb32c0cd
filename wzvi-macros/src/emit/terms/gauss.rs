//! The flows of systems in loops.

use proc_macro2::TokenStream;
use quote::quote;

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
