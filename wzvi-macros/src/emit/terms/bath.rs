//! `impl Damped`: friction and temperature as parts with numbers of their own.

use proc_macro2::TokenStream;
use quote::quote;

use super::parts::Numbers;
use crate::discretise::Kinetic;
use crate::emit::{count, implementation};
use crate::model::System;

/// For a thermostat, if there is friction for one.
pub(super) fn emit(model: &mut System) -> TokenStream {
    let kinetic = Kinetic::of(model);
    let (Some(friction), Some(Kinetic { is_diagonal })) = (&model.friction, kinetic) else {
        return TokenStream::new();
    };
    let numbers = Numbers::of(model);
    let (number, is_matrix, is_per_state) =
        (count(numbers.friction), friction.is_matrix, friction.is_per_place());
    let temperature = model.temperature.as_ref().map(|_| {
        let number = count(numbers.temperature);
        quote!(const TEMPERATURE: __wzvi::Option<__wzvi::usize> = __wzvi::Some(#number);)
    });
    let bool = quote!(__wzvi::bool);
    let body = quote! {
        const IS_MATRIX: #bool = #is_matrix;
        const PER_STATE: #bool = #is_per_state;
        const HAS_DIAGONAL_MASSES: #bool = #is_diagonal;
        const FRICTION: __wzvi::usize = #number;
        #temperature
    };
    implementation(&model.item, &quote!(__wzvi::bath::Damped), &body)
}
