//! Steps in loops: the description of a scheme for the run time. Tests: `tests/loops/sweeps.rs`.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::role_path;
use crate::discretise::{Linearity, Quadrature, SchemePlan, Stage, Strategy, Unknowns};
use crate::emit::discretized;
use crate::emit::overrides::{self, holds};
use crate::model::System;

/// `impl Discretized<E>` of steps in loops.
pub(crate) fn emit(model: &System, plan: &SchemePlan, strategy: Strategy, text: &str) -> TokenStream {
    let SchemePlan { embedding, quadrature, is_consistent, .. } = plan;
    let is_explicit = strategy.unknowns == Unknowns::None;
    let quadrature = self::quadrature(quadrature, strategy, model.noise.is_empty() && !is_explicit);
    let order = Literal::u32_unsuffixed(embedding.order());
    let (path, in_loops) = (embedding.path(&quote!(__wzvi)), quote!(__wzvi::elements::InLoops));
    let in_loops = quote! {
        const IN_LOOPS: __wzvi::Option<#in_loops> = __wzvi::Some(#in_loops {
            order: #order,
            is_consistent: #is_consistent,
            quadrature: #quadrature,
        });
    };
    let steps = quote!(__wzvi::elements::Loops<#path>);
    discretized(&model.item, embedding, &steps, text, Some(in_loops))
}

/// The parameters of the scheme for the run time, and whether past steps predict the
/// iteration's start.
pub(crate) fn quadrature(quadrature: &Quadrature, strategy: Strategy, remembers: bool) -> TokenStream {
    let Strategy { unknowns, linearity } = strategy;
    let stages = quadrature.stages.iter().map(stage);
    let update = match quadrature.momentum_update() {
        Some(factor) => {
            let factor = Literal::f64_unsuffixed(factor.to_f64());
            quote!(Multiple(#factor))
        }
        None => quote!(Slopes),
    };
    let quadrature = quote!(__wzvi::elements::Quadrature);
    let straight = quote!(#quadrature::new(&[#(#stages),*], __wzvi::elements::MomentumUpdate::#update));
    let unknowns = match unknowns {
        Unknowns::None => Some(quote!(__wzvi::elements::Unknowns::None)),
        Unknowns::Momenta => None,
        Unknowns::Both => Some(quote!(__wzvi::elements::Unknowns::Both)),
    };
    let linearity = match linearity {
        Linearity::Nonlinear => None,
        Linearity::Affine => Some(quote!(__wzvi::elements::Linearity::Affine)),
        Linearity::Constant => Some(quote!(__wzvi::elements::Linearity::Constant)),
    };
    let known = overrides::QuadratureOverrides { unknowns, remembers: holds(remembers), linearity };
    known.over(&quadrature, straight)
}

/// A quadrature point for the run time.
fn stage(stage: &Stage) -> TokenStream {
    let [point, start, end] =
        [stage.l, stage.start(), stage.end()].map(|weight| Literal::f64_unsuffixed(weight.to_f64()));
    let roles = stage.roles.iter().map(|&(role, weight)| {
        let (role, weight) = (role_path(role), Literal::f64_unsuffixed(weight.to_f64()));
        quote!(#role.times(#weight))
    });
    quote! {
        __wzvi::elements::QuadraturePoint::new([#point, #start, #end], &[#(#roles),*])
    }
}

/// Flows of large systems, tile by tile.
pub(crate) fn in_tiles() -> TokenStream {
    let f64 = quote!(__wzvi::f64);
    quote! {
        fn take_tiles<'p, __W: __wzvi::elements::TileParts>(
            &self,
            __word: &mut __W,
            __q: &[#f64],
            __p: &[#f64],
            __plan: &'p mut __wzvi::elements::TilePlan,
        ) -> __wzvi::Option<__wzvi::Result<__wzvi::elements::NewState<'p>, __wzvi::StepFailure>> {
            __wzvi::elements::take_tiles(self, __word, __q, __p, __plan)
        }
    }
}
