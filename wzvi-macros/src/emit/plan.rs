//! `FACTS` and `PLAN`: the results and decisions of the compiler, as constants.

use proc_macro2::{Literal, TokenStream};
use quote::{ToTokens, format_ident, quote};

use super::count;
use super::overrides::{self, holds};
use crate::discretise::{Facts, NoiseClass, Scheme, SchemePlan, Solution};
use crate::input::{Length, Shape};
use crate::model::System;
use crate::symbolic::Knowledge;

/// The facts independent of the scheme, those of elements among them, as far as they differ from those of an
/// autonomous system.
pub(crate) fn facts(system: &System, facts: &Facts, of_elements: overrides::FactOverrides) -> TokenStream {
    let class = format_ident!("{}", format!("{:?}", facts.noise));
    let noise = (facts.noise != NoiseClass::None).then(|| quote!(__wzvi::NoiseClass::#class));
    let is_damped = system.friction.is_some() || system.conformal.is_some();
    let of_collectives = system.collectives_of_terms().flat_map(|known| &known.elements);
    let has_collectives = system.collectives_of_terms().next().is_some();
    let has_pieces = system.acting().chain(of_collectives).any(|element| {
        let read = element.moving();
        // A force may read other places than it acts on, and collective variables read all.
        let may_couple = read.len() > 1 || element.is_covector() || has_collectives;
        may_couple && system.graph.has_pieces(element.value, &read)
    });
    let known = overrides::FactOverrides {
        noise,
        conserves_energy: knowledge(&facts.energy.is_conserved),
        energy_jumps: holds(facts.energy.only_jumps),
        commuting: knowledge(&facts.commuting),
        has_weak_order_two: (!facts.has_weak_order_two).then(|| quote!(false)),
        is_damped: holds(is_damped),
        has_pieces: holds(has_pieces),
        ..of_elements
    };
    let degrees = degrees(system).unwrap_or_else(|| quote!(__wzvi::usize::MAX));
    known.over(&quote!(__wzvi::Facts), quote!(__wzvi::Facts::autonomous(#degrees)))
}

/// The degrees of freedom as a constant expression; `None` if only the state knows them.
pub(crate) fn degrees(system: &System) -> Option<TokenStream> {
    let components = usize::try_from(system.components).unwrap_or(1);
    Some(match &system.shape {
        Shape::Real => quote!(1),
        Shape::Array(_, Length::Literal(len)) => count(len * components).into_token_stream(),
        Shape::Array(_, Length::Named(expr)) => {
            let components = count(components);
            quote!((#expr) * #components)
        }
        Shape::Array(_, Length::RunTime) => return None,
    })
}

/// The plan of a step that is solved block by block.
pub(crate) fn plan(plan: &SchemePlan, scheme: &Scheme) -> TokenStream {
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
    let SchemePlan { embedding, is_consistent, .. } = plan;
    let unknowns = count(scheme.structure.unknowns());
    let order = Literal::u32_unsuffixed(embedding.order());
    let facts = quote!(<Self as __wzvi::elements::Elements>::FACTS);
    let constant = quote!(#facts.plan(__wzvi::Solver::#solver, #unknowns, #order, #is_consistent));
    // The drift alone decides the order, and noise beside the middle of the step costs weak order two.
    let [drift, noise] = embedding.means();
    match drift == noise {
        true => constant,
        false => quote!(__wzvi::Plan { has_weak_order_two: false, ..#constant }),
    }
}

/// `None` for proven statements.
fn knowledge(known: &Knowledge) -> Option<TokenStream> {
    match known {
        Knowledge::Proven => None,
        Knowledge::Refuted(_) => Some(quote!(__wzvi::Knowledge::Refuted)),
        Knowledge::Unknown(_) => Some(quote!(__wzvi::Knowledge::Unknown)),
    }
}
