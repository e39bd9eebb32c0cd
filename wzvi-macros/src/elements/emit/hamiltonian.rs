//! `impl Hamiltonian`: energies, their slopes, and first integrals, in loops.

use super::indices::{Indices, variable};
use super::{Wanted, degrees, element_code, noise_count, parameters, sizes, vector_type};
use crate::diagnostics::internal::Promised;
use crate::emit::step::mentions;
use crate::emit::{count, f64_type, number_of, parameter};
use crate::model::index::Index;
use crate::model::{Element, Family, Noise, System, Term};
use proc_macro2::TokenStream;
use quote::quote;

/// `impl Hamiltonian`
pub(super) fn emit(model: &mut System) -> TokenStream {
    let vector = vector_type(model);
    let degrees = degrees(model);
    let noises = (!model.noise.is_empty()).then(|| number_of("noises", &noise_count(model)));
    let (values, slopes) = (arms(model, Wanted::Value), arms(model, Wanted::Slopes));
    let [of_values, of_slopes] = [&values, &slopes].map(|code| {
        let read = parameters(model, code);
        let size = mentions(code, "__size").then(|| sizes(model, &quote!(__q.len())));
        quote!(#read #size)
    });
    let invariants = count(model.invariants.len());
    let invariants = (!model.invariants.is_empty()).then(|| number_of("invariants", &quote!(#invariants)));
    let invariant = invariant(model);
    let name = &model.item.ident;
    let (generics, arguments, filter) = model.item.generics.split_for_impl();
    let (usize, f64) = (quote!(__wzvi::usize), f64_type());
    let parameter = parameter(&model.graph, &model.parameters);
    let fits = quote! {
        __q.len() == __p.len() && __wzvi::elements::check(self, __q.len()).is_ok()
    };
    quote! {
        #[automatically_derived]
        impl #generics __wzvi::Hamiltonian for #name #arguments #filter {
            type Vector = #vector;

            fn degrees(&self) -> #usize { #degrees }

            fn check(
                &self,
                __degrees: #usize,
            ) -> __wzvi::Result<(), __wzvi::StepFailure> {
                __wzvi::elements::check(self, __degrees)
            }

            #noises

            #invariants

            #parameter

            fn evaluate<__S: __wzvi::Scalar>(&self, __term: #usize, __q: &[__S], __p: &[__S], __t: #f64) -> __S {
                let __nan = __S::from_f64(#f64::NAN);
                if !(#fits) {
                    return __nan;
                }
                #of_values
                let __at = __wzvi::elements::Point { q: __q, p: __p, t: __t, h: 1.0, dw: &[] };
                let mut __total = __S::from_f64(0.0);
                match __term {
                    #values
                    _ => return __nan,
                }
                __total
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
                let __nan = __S::from_f64(#f64::NAN);
                if !(#fits && __by_q.len() == __q.len() && __by_p.len() == __q.len()) {
                    __by_q.fill(__nan);
                    __by_p.fill(__nan);
                    return;
                }
                __by_q.fill(__S::from_f64(0.0));
                __by_p.fill(__S::from_f64(0.0));
                #of_slopes
                let __at = __wzvi::elements::Point { q: __q, p: __p, t: __t, h: 1.0, dw: &[] };
                match __term {
                    #slopes
                    _ => {
                        __by_q.fill(__nan);
                        __by_p.fill(__nan);
                    }
                }
            }

            #invariant
        }
    }
}

/// `Hamiltonian::invariant`
pub(super) fn invariant(model: &mut System) -> TokenStream {
    let (usize, f64) = (quote!(__wzvi::usize), f64_type());
    if model.invariants.is_empty() {
        return TokenStream::new();
    }
    let integrals: Vec<Vec<Element>> =
        model.invariants.iter().map(|invariant| invariant.values.clone()).collect();
    let mut arms = TokenStream::new();
    for (number, elements) in integrals.iter().enumerate() {
        let body = terms_code(model, elements, Wanted::Value);
        let number = count(number);
        arms.extend(quote!(#number => { #body }));
    }
    let (read, size) = (parameters(model, &arms), sizes(model, &quote!(__at.q.len())));
    quote! {
        fn invariant(&self, __number: #usize, __state: &__wzvi::State<Self::Vector>) -> #f64 {
            use __wzvi::Scalar as _;
            type __S = #f64;
            let (__q, __p) = (__wzvi::Vector::components(&__state.q), __wzvi::Vector::components(&__state.p));
            if __q.len() != __p.len() || __wzvi::elements::check(self, __q.len()).is_err() {
                return #f64::NAN;
            }
            let __at = __wzvi::elements::Point::<#f64> { q: __q, p: __p, t: __state.t, h: 1.0, dw: &[] };
            let __t = __at.t;
            #read
            #size
            let mut __total: #f64 = 0.0;
            match __number {
                #arms
                _ => return #f64::NAN,
            }
            __total
        }
    }
}

/// The code of several elements, one after the other.
fn terms_code(model: &mut System, elements: &[Element], wanted: Wanted) -> TokenStream {
    elements.iter().map(|element| element_code(model, element, wanted, None)).collect()
}

/// What values, or derivatives, are computed of.
fn elements_of(term: &Term, wanted: Wanted) -> Vec<Element> {
    match wanted {
        Wanted::Value => term.values.clone(),
        Wanted::Slopes | Wanted::Curvature => term.elements.clone(),
    }
}

/// One match arm per term, on its number.
pub(super) fn arms(model: &mut System, wanted: Wanted) -> TokenStream {
    let drift = elements_of(&model.drift, wanted);
    let drift = terms_code(model, &drift, wanted);
    let mut arms = quote!(0 => { #drift });
    let (noises, offsets) = (model.noise.clone(), model.noise_offsets());
    for (noise, offset) in noises.iter().zip(&offsets) {
        arms.extend(noise_arm(model, noise, offset, wanted));
    }
    arms
}

/// The arm of one noise, or of the members of a family, after `offset` others.
fn noise_arm(model: &mut System, noise: &Noise, offset: &Index, wanted: Wanted) -> TokenStream {
    let (isize, usize) = (quote!(__wzvi::isize), quote!(__wzvi::usize));
    let indices = Indices { tables: &model.tables, checked: false };
    let before = indices.value(offset);
    let Some(Family { variable: id, count }) = &noise.family else {
        let pattern = match offset.as_integer().and_then(|offset| usize::try_from(offset).ok()) {
            Some(offset) => {
                let number = count(offset + 1);
                quote!(#number)
            }
            None => quote!(__number if __number == #before as #usize + 1),
        };
        let body = terms_code(model, &elements_of(&noise.term, wanted), wanted);
        return quote!(#pattern => { #body });
    };
    let name = variable(*id);
    let last = indices.value(&offset.add(count).promised("numbers of noises are integers"));
    // The member is given: its loop goes once.
    let mut elements = elements_of(&noise.term, wanted);
    elements.iter_mut().for_each(|element| drop(element.loops.remove(0)));
    let body = terms_code(model, &elements, wanted);
    quote! {
        __member if __member as #isize > #before && __member as #isize <= #last => {
            let #name = __member as #isize - 1 - #before;
            #body
        }
    }
}
