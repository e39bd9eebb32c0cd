//! `impl Damped`: friction and temperature as parts with numbers of their own.

use proc_macro2::TokenStream;
use quote::quote;

use super::parts::Numbers;
use crate::discretise::facts::kinetic::Kinetic;
use crate::emit::{count, f64_type};
use crate::model::System;

/// For a thermostat, if there is friction for one.
pub(super) fn emit(model: &mut System) -> TokenStream {
    let kinetic = Kinetic::of(model);
    let (Some(friction), Some(Kinetic { is_diagonal })) = (&model.friction, kinetic) else {
        return TokenStream::new();
    };
    let numbers = Numbers::of(model);
    let (number, is_matrix) = (count(numbers.friction), friction.is_matrix);
    let is_per_state = friction.is_per_place();
    let damping = match is_matrix {
        true => quote!(__wzvi::elements::damping(self, #number, __q, __into)),
        false => quote!(__wzvi::elements::rates(self, #number, __q, __into)),
    };
    let temperature = match &model.temperature {
        None => quote!(__wzvi::None),
        Some(_) => {
            let number = count(numbers.temperature);
            quote!(__wzvi::Some(__wzvi::elements::value_of_part(self, #number, 0.0, &[], &[])))
        }
    };
    let name = &model.item.ident;
    let (generics, arguments, filter) = model.item.generics.split_for_impl();
    let (f64, bool, option) = (f64_type(), quote!(__wzvi::bool), quote!(__wzvi::Option));
    quote! {
        #[automatically_derived]
        impl #generics __wzvi::bath::Damped for #name #arguments #filter {
            const IS_MATRIX: #bool = #is_matrix;
            const PER_STATE: #bool = #is_per_state;
            const HAS_DIAGONAL_MASSES: #bool = #is_diagonal;

            fn damping<__S: __wzvi::Scalar>(&self, __q: &[__S], __into: &mut [__S]) {
                #damping
            }

            fn temperature(&self) -> #option<#f64> {
                #temperature
            }
        }
    }
}
