//! `PLAN`: what the compiler found out and decided about a scheme, as a constant.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use crate::discretise::facts::NoiseClass;
use crate::symbolic::zero::Knowledge;

/// The fields of the constant; `solver` is the variant's name, `unknowns` a constant expression.
pub(crate) struct Plan<'f> {
    pub(crate) solver: TokenStream,
    pub(crate) unknowns: TokenStream,
    pub(crate) order: u32,
    pub(crate) noise: NoiseClass,
    pub(crate) consistent: bool,
    pub(crate) conserves_energy: &'f Knowledge,
    pub(crate) commuting: &'f Knowledge,
}

impl Plan<'_> {
    pub(crate) fn emit(&self) -> TokenStream {
        let Self { solver, unknowns, order, noise, consistent, .. } = self;
        let noise = match noise {
            NoiseClass::None => quote!(None),
            NoiseClass::Additive => quote!(Additive),
            NoiseClass::Position => quote!(Position),
            NoiseClass::Momentum => quote!(Momentum),
            NoiseClass::Multiplicative => quote!(Multiplicative),
        };
        let order = Literal::u32_unsuffixed(*order);
        let (energy, commuting) = (knowledge(self.conserves_energy), knowledge(self.commuting));
        quote! {
            __wzvi::Plan {
                solver: __wzvi::Solver::#solver,
                unknowns: #unknowns,
                order: #order,
                noise: __wzvi::NoiseClass::#noise,
                consistent: #consistent,
                conserves_energy: __wzvi::Knowledge::#energy,
                commuting: __wzvi::Knowledge::#commuting,
            }
        }
    }
}

fn knowledge(known: &Knowledge) -> TokenStream {
    match known {
        Knowledge::Proven => quote!(Proven),
        Knowledge::Refuted(_) => quote!(Refuted),
        Knowledge::Unknown(_) => quote!(Unknown),
    }
}
