//! `impl Damped`: friction and temperature, for thermostats.

use proc_macro2::TokenStream;
use quote::quote;
use syn::ItemStruct;

use super::names::Names;
use super::print::f64_type;
use super::program::Level;
use super::system::{Body, Inputs, Letters, body};
use crate::discretise::facts::kinetic::Kinetic;
use crate::model::{Bath, Model};
use crate::symbolic::Expr;

/// The implementation for any system.
pub(crate) struct Damped {
    pub(crate) is_matrix: bool,
    pub(crate) is_per_state: bool,
    pub(crate) has_diagonal_masses: bool,
    /// The bodies, by method.
    pub(crate) damping: TokenStream,
    pub(crate) temperature: TokenStream,
}

impl Damped {
    pub(crate) fn emit(&self, item: &ItemStruct) -> TokenStream {
        let Self { is_matrix, is_per_state, has_diagonal_masses, damping, temperature } = self;
        let name = &item.ident;
        let (generics, arguments, filter) = item.generics.split_for_impl();
        let (f64, bool, option) = (f64_type(), quote!(__wzvi::bool), quote!(__wzvi::Option));
        quote! {
            #[automatically_derived]
            impl #generics __wzvi::bath::Damped for #name #arguments #filter {
                const IS_MATRIX: #bool = #is_matrix;
                const PER_STATE: #bool = #is_per_state;
                const HAS_DIAGONAL_MASSES: #bool = #has_diagonal_masses;

                fn damping<__S: __wzvi::Scalar>(&self, __q: &[__S], __into: &mut [__S]) {
                    #damping
                }

                fn temperature(&self) -> #option<#f64> {
                    #temperature
                }
            }
        }
    }
}

/// For a thermostat, if there is friction for one.
pub(super) fn emit(model: &mut Model, kinetic: Option<Kinetic>) -> TokenStream {
    let (Some(bath), Some(Kinetic { is_diagonal })) = (model.bath.take(), kinetic) else {
        return TokenStream::new();
    };
    let Bath { damping, is_matrix, temperature } = bath;
    let is_per_state = damping.iter().any(|&entry| model.graph.depends_on(entry, &model.phase.q));
    let f64 = f64_type();
    let (Body { statements, values }, q) = evaluated(model, &damping, &quote!(__S));
    let damping = quote! {
        let &[#(#q),*] = __q else {
            return __into.fill(__S::from_f64(#f64::NAN));
        };
        #statements
        __wzvi::covector(__into, [#(#values),*])
    };
    let temperature = temperature.map(|temperature| {
        let (Body { statements, values }, _) = evaluated(model, &[temperature], &f64);
        quote! {
            #statements
            __wzvi::Some(#(#values)*)
        }
    });
    let temperature = temperature.unwrap_or(quote!(__wzvi::None));
    let has_diagonal_masses = is_diagonal;
    let damped = Damped { is_matrix, is_per_state, has_diagonal_masses, damping, temperature };
    damped.emit(&model.item)
}

/// The code of `roots`, which read parameters and coordinates, and the names of these.
fn evaluated(model: &mut Model, roots: &[Expr], scalar: &TokenStream) -> (Body, Vec<proc_macro2::Ident>) {
    let letters = Letters::of(model, Names::default());
    let names = model.phase.q.iter().zip(&letters.q).map(|(&q, name)| (q, name.clone(), Level::State));
    let inputs = Inputs { names: names.collect(), ..Inputs::default() };
    let body = body(model, &letters, &inputs, scalar, roots);
    (body, letters.q)
}
