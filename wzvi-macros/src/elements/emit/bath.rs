//! `impl Damped` of a system of elements: friction and temperature as parts with numbers of their own.

use proc_macro2::TokenStream;
use quote::quote;

use super::parts::Numbers;
use crate::elements::kinetic::Kinetic;
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
    let is_per_state = friction.term.elements.iter().any(|element| element.coordinates().next().is_some());
    let is_diagonal = is_diagonal && !is_matrix;
    let elements = quote!(__wzvi::elements);
    let damping = match (is_matrix, is_diagonal) {
        (true, _) => quote!(#elements::damping_matrix(self, #number, __gamma)),
        (false, true) => quote!(#elements::damping(self, #number, __q, __gamma)),
        (false, false) => quote!(#elements::damping_by_masses(self, #number, __gamma)),
    };
    let temperature = match &model.temperature {
        None => quote!(__wzvi::None),
        Some(_) => {
            let number = count(numbers.temperature);
            quote!(__wzvi::Some(#elements::value_of_part(self, #number, 0.0, &[], &[])))
        }
    };
    Damped {
        shape: quote!(__wzvi::gauss::Dynamic),
        is_per_state,
        is_diagonal,
        damping,
        inverse_mass: quote!(#elements::inverse_mass::<_, #is_diagonal>(self, __inverse)),
        temperature,
    }
    .emit(&model.item)
}
