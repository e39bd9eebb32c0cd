//! `impl Damped` of a system of elements: friction and temperature as parts with numbers of their own.

use proc_macro2::TokenStream;
use quote::quote;

use super::parts::Numbers;
use crate::discretise::facts::kinetic::Kinetic;
use crate::emit::bath::Damped;
use crate::emit::count;
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
    let has_diagonal_masses = is_diagonal;
    let damped = Damped { is_matrix, is_per_state, has_diagonal_masses, damping, temperature };
    damped.emit(&model.item)
}
