//! `impl Damped`: friction, inverse masses and temperature, for thermostats.

use proc_macro2::TokenStream;
use quote::{format_ident, quote};
use syn::ItemStruct;

use super::names::Names;
use super::print::f64_type;
use super::program::Level;
use super::system::{Body, Inputs, Letters, body, count};
use crate::model::{Bath, Model};
use crate::symbolic::{Expr, Symbol};

/// The implementation for any system.
pub(crate) struct Damped {
    pub(crate) shape: TokenStream,
    pub(crate) is_per_state: bool,
    pub(crate) is_diagonal: bool,
    /// The bodies, by method.
    pub(crate) damping: TokenStream,
    pub(crate) inverse_mass: TokenStream,
    pub(crate) temperature: TokenStream,
}

impl Damped {
    pub(crate) fn emit(&self, item: &ItemStruct) -> TokenStream {
        let Self { shape, is_per_state, is_diagonal, damping, inverse_mass, temperature } = self;
        let name = &item.ident;
        let (generics, arguments, filter) = item.generics.split_for_impl();
        let (f64, bool, option) = (f64_type(), quote!(__wzvi::bool), quote!(__wzvi::Option));
        quote! {
            #[automatically_derived]
            impl #generics __wzvi::bath::Damped for #name #arguments #filter {
                type Shape = #shape;
                const PER_STATE: #bool = #is_per_state;
                const DIAGONAL: #bool = #is_diagonal;

                fn damping<__S: __wzvi::Scalar>(&self, __q: &[__S], __gamma: &mut [__S]) {
                    #damping
                }

                fn inverse_mass(&self, __inverse: &mut [#f64]) {
                    #inverse_mass
                }

                fn temperature(&self) -> #option<#f64> {
                    #temperature
                }
            }
        }
    }
}

/// For a thermostat, if there is friction for one.
pub(super) fn emit(model: &mut Model) -> TokenStream {
    let Some(Bath { damping, is_matrix, temperature }) = model.bath.take() else { return TokenStream::new() };
    let degrees = model.phase.q.len();
    let inverse = inverse_masses(model);
    let has_diagonal_masses =
        (0..degrees).all(|i| (0..degrees).all(|j| i == j || model.graph.is_zero(inverse[i * degrees + j])));
    let is_diagonal = has_diagonal_masses && !is_matrix;
    let diagonal: Vec<Expr> = (0..degrees).map(|i| inverse[i * (degrees + 1)]).collect();
    let is_per_state = damping.iter().any(|&entry| model.graph.depends_on(entry, &model.phase.q));
    let f64 = f64_type();
    let damping = match (is_matrix, has_diagonal_masses) {
        (true, _) => filled(model, "gamma", &damping, &quote!(__S)),
        // `Γ = γ M`
        (false, true) => {
            let rates = damping.iter().zip(&diagonal);
            let graph = &mut model.graph;
            let damping: Vec<Expr> = rates.map(|(&rate, &inverse)| graph.divide(rate, inverse)).collect();
            filled(model, "gamma", &damping, &quote!(__S))
        }
        (false, false) => {
            let Body { statements, values } = evaluated(model, &damping[..1], &quote!(__S));
            quote! {
                #statements
                __wzvi::elements::rate_times_masses(self, #(#values)*, __gamma)
            }
        }
    };
    let inverse = if is_diagonal { diagonal } else { inverse };
    let inverse_mass = filled(model, "inverse", &inverse, &f64);
    let temperature = match temperature {
        None => quote!(__wzvi::None),
        Some(temperature) => {
            let Body { statements, values } = evaluated(model, &[temperature], &f64);
            quote! {
                #statements
                __wzvi::Some(#(#values)*)
            }
        }
    };
    let degrees = count(degrees);
    let shape = quote!(__wzvi::gauss::Fixed<#degrees>);
    let damped = Damped { shape, is_per_state, is_diagonal, damping, inverse_mass, temperature };
    damped.emit(&model.item)
}

/// `∂²H_0/∂p_i ∂p_j` by rows.
fn inverse_masses(model: &mut Model) -> Vec<Expr> {
    let Model { graph, phase, drift, .. } = model;
    let velocities: Vec<Expr> = phase.p.iter().map(|&p| graph.derivative(drift.value, p)).collect();
    let rows = velocities.iter().flat_map(|&velocity| phase.p.iter().map(move |&p| (velocity, p)));
    rows.map(|(velocity, p)| graph.derivative(velocity, p)).collect()
}

/// The list `__name` becomes `entries`.
fn filled(model: &mut Model, name: &str, entries: &[Expr], scalar: &TokenStream) -> TokenStream {
    let Body { statements, values } = evaluated(model, entries, scalar);
    let list = format_ident!("__{name}");
    let length = count(entries.len());
    quote! {
        #statements
        let __filled: [#scalar; #length] = [#(#values),*];
        match __wzvi::array_mut::<#scalar, #length>(#list) {
            __wzvi::Ok(__list) => *__list = __filled,
            __wzvi::Err(_) => #list.fill(<#scalar as __wzvi::Scalar>::from_f64(__wzvi::f64::NAN)),
        }
    }
}

/// The code of `roots`, which read parameters and coordinates.
fn evaluated(model: &mut Model, roots: &[Expr], scalar: &TokenStream) -> Body {
    let letters = Letters::of(model, Names::beside(&["gamma", "inverse", "filled", "list"]));
    let read: Vec<(usize, Symbol)> = model.phase.q.iter().copied().enumerate().collect();
    let read =
        read.into_iter().filter(|(_, q)| roots.iter().any(|&root| model.graph.depends_on(root, &[*q])));
    let read: Vec<_> = read.collect();
    let names = read.iter().map(|&(i, q)| (q, letters.q[i].clone(), Level::State)).collect();
    let inputs = Inputs { names, ..Inputs::default() };
    let opened = read.iter().map(|&(i, _)| {
        let (name, place) = (&letters.q[i], count(i));
        quote!(let #name = __q.get(#place).copied().unwrap_or(__S::from_f64(__wzvi::f64::NAN));)
    });
    let opened: TokenStream = opened.collect();
    let Body { statements, values } = body(model, &letters, &inputs, scalar, roots);
    Body { statements: quote!(#opened #statements), values }
}
