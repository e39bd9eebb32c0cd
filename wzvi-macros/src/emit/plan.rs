//! `FACTS` and `PLAN`: what the compiler found out and decided, as constants.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::count;
use crate::discretise::Scheme;
use crate::discretise::facts::{Facts, NoiseClass};
use crate::discretise::structure::Solution;
use crate::input::{Length, Shape};
use crate::model::System;
use crate::symbolic::zero::Knowledge;

/// What is known of the system, whatever its scheme.
pub(crate) fn facts(system: &System, facts: &Facts) -> TokenStream {
    let noise = match facts.noise {
        NoiseClass::None => quote!(None),
        NoiseClass::Additive => quote!(Additive),
        NoiseClass::Position => quote!(Position),
        NoiseClass::Momentum => quote!(Momentum),
        NoiseClass::Multiplicative => quote!(Multiplicative),
    };
    let (energy, commuting) = (knowledge(&facts.conserves_energy), knowledge(&facts.commuting));
    let degrees = degrees(system);
    let is_damped = system.friction.is_some() || system.conformal.is_some();
    let terms =
        [&system.drift].into_iter().chain(&system.force).chain(system.noise.iter().map(|noise| &noise.term));
    let has_pieces = terms.flat_map(|term| &term.elements).any(|element| {
        let read: Vec<_> = element.coordinates().chain(element.momenta()).map(|(symbol, _)| symbol).collect();
        // A force pushes another place than it reads.
        let may_couple = read.len() > 1 || element.displacements().next().is_some();
        may_couple && system.graph.has_pieces(element.value, &read)
    });
    quote! {
        __wzvi::Facts {
            degrees: #degrees,
            noise: __wzvi::NoiseClass::#noise,
            conserves_energy: __wzvi::Knowledge::#energy,
            commuting: __wzvi::Knowledge::#commuting,
            is_damped: #is_damped,
            has_pieces: #has_pieces,
        }
    }
}

/// As a constant expression.
fn degrees(system: &System) -> TokenStream {
    let components = usize::try_from(system.components).unwrap_or(1);
    match &system.shape {
        Shape::Real => quote!(1),
        Shape::Array(_, Length::Literal(len)) => {
            let degrees = count(len * components);
            quote!(#degrees)
        }
        Shape::Array(_, Length::Named(expr)) => quote!((#expr) * #components),
        Shape::Array(_, Length::RunTime) => quote!(__wzvi::usize::MAX),
    }
}

/// Of a step that is solved block by block.
pub(crate) fn plan(scheme: &Scheme) -> TokenStream {
    let hardest = scheme.structure.blocks.iter().map(|block| match block.solution {
        Solution::Assigned | Solution::Isolated(_) => 0,
        Solution::Linear { .. } => 1,
        Solution::Newton { .. } => 2,
    });
    let solver = match hardest.max() {
        Some(2) => quote!(Newton),
        Some(1) => quote!(Linear),
        _ => quote!(Explicit),
    };
    let (unknowns, consistent) = (count(scheme.structure.unknowns()), scheme.consistent);
    let order = Literal::u32_unsuffixed(scheme.embedding.order());
    quote!(<Self as __wzvi::elements::Elements>::FACTS.plan(__wzvi::Solver::#solver, #unknowns, #order, #consistent))
}

fn knowledge(known: &Knowledge) -> TokenStream {
    match known {
        Knowledge::Proven => quote!(Proven),
        Knowledge::Refuted(_) => quote!(Refuted),
        Knowledge::Unknown(_) => quote!(Unknown),
    }
}
