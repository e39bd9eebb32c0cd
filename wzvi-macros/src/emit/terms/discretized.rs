//! `impl Discretized<E>` of a system of elements: what the run time needs to know of a scheme.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use crate::discretise::facts::Facts;
use crate::discretise::quadrature::{Quadrature, Stage};
use crate::elements::plan::{Strategy, Unknowns};
use crate::embedding::Embedding;
use crate::emit::discretized::Discretized;
use crate::emit::plan::Plan;
use crate::emit::{count, f64_type};
use crate::input::{Length, Shape};
use crate::model::{Parameter, System};

/// `impl Discretized<E>`
pub(crate) fn emit(
    model: &System,
    facts: &Facts,
    embedding: &Embedding,
    strategy: Strategy,
    text: &str,
) -> TokenStream {
    let f64 = f64_type();
    let nan_checks: Vec<TokenStream> =
        model.parameters.iter().map(|Parameter { tokens, .. }| quote!(#f64::is_nan(#tokens))).collect();
    let nan_check = (!nan_checks.is_empty()).then(|| {
        quote! {
            if #(#nan_checks)||* {
                return __wzvi::Err(__wzvi::ConfigError::Parameter);
            }
        }
    });
    let elements = quote!(__wzvi::elements);
    let is_explicit = strategy.unknowns == Unknowns::None;
    let advance = match is_explicit {
        true => quote!(#elements::advance_explicit::<_, __S, __C>),
        false => quote!(#elements::advance::<_, __S, __C, __CAREFUL>),
    };
    Discretized {
        item: &model.item,
        embedding,
        text,
        items: scheme(facts, embedding, strategy, model.noise.is_empty() && !is_explicit),
        // A start that is no guide costs iterations, not digits.
        constants: quote! {
            const REMEMBERS: __wzvi::bool = false;
            const IN_LANES: __wzvi::bool = #is_explicit;
        },
        plan: plan(model, facts, embedding, strategy),
        prepared: quote!(()),
        beside: None,
        memory: quote!(#elements::Memory<__S>),
        compensated: quote!(#elements::CompensationVec<__S>),
        carry: quote!(__wzvi::Plain),
        new_memory: Some(quote!(#elements::Memory::new(self, &__SCHEME))),
        prepare: quote! {
            #nan_check
            #elements::prepare(self)
        },
        inline: if is_explicit { quote!(#[inline(always)]) } else { TokenStream::new() },
        advance: quote! {
            #advance(self, &__SCHEME, __t, __h, __q, __p, __dw, __memory, __carry)
        },
        advance_vectors: is_explicit.then(|| {
            let vectors = quote!(#elements::advance_explicit_vectors);
            quote!(#vectors(self, &__SCHEME, __t, __h, __q, __p, __dw, __memory, __carry))
        }),
    }
    .emit()
}

/// What the run time needs to know of the scheme, and whether past steps start its iteration.
pub(crate) fn scheme(
    facts: &Facts,
    embedding: &Embedding,
    strategy: Strategy,
    remembers: bool,
) -> TokenStream {
    let Strategy { unknowns, is_linear } = strategy;
    let quadrature = Quadrature::new(facts, embedding);
    let stages = quadrature.stages.iter().map(stage);
    let update = match quadrature.momentum_update() {
        Some(factor) => {
            let factor = Literal::f64_unsuffixed(factor.to_f64());
            quote!(Multiple(#factor))
        }
        None => quote!(Slopes),
    };
    let unknowns = match unknowns {
        Unknowns::None => quote!(None),
        Unknowns::Momenta => quote!(Momenta),
        Unknowns::Both => quote!(Both),
    };
    quote! {
        const __SCHEME: __wzvi::elements::Scheme = __wzvi::elements::Scheme {
            stages: &[#(#stages),*],
            update: __wzvi::elements::MomentumUpdate::#update,
            unknowns: __wzvi::elements::Unknowns::#unknowns,
            remembers: #remembers,
            is_linear: #is_linear,
        };
    }
}

/// A quadrature point, as the run time reads it.
fn stage(stage: &Stage) -> TokenStream {
    let [point, start, end] =
        [stage.l, stage.start(), stage.end()].map(|weight| Literal::f64_unsuffixed(weight.to_f64()));
    let parts = stage.parts.iter().map(|&(part, weight)| {
        let (number, weight) = (count(part as usize), Literal::f64_unsuffixed(weight.to_f64()));
        quote!((#number, #weight))
    });
    quote! {
        __wzvi::elements::Stage { point: #point, start: #start, end: #end, parts: &[#(#parts),*] }
    }
}

pub(crate) fn plan(
    model: &System,
    facts: &Facts,
    embedding: &Embedding,
    Strategy { unknowns, is_linear }: Strategy,
) -> TokenStream {
    let solver = match unknowns {
        Unknowns::None => quote!(Explicit),
        _ if is_linear => quote!(Linear),
        _ => quote!(Newton),
    };
    let per_degree: usize = match unknowns {
        Unknowns::None => 0,
        Unknowns::Momenta => 1,
        Unknowns::Both => 2,
    };
    let components = usize::try_from(model.components).unwrap_or(1);
    let unknowns = match (&model.shape, per_degree) {
        (_, 0) => quote!(0),
        (Shape::Real, _) => {
            let unknowns = count(per_degree);
            quote!(#unknowns)
        }
        (Shape::Array(_, Length::Literal(len)), _) => {
            let unknowns = count(len * components * per_degree);
            quote!(#unknowns)
        }
        (Shape::Array(_, Length::Named(expr)), _) => quote!((#expr) * #components * #per_degree),
        _ => quote!(__wzvi::usize::MAX),
    };
    Plan {
        solver,
        unknowns,
        order: embedding.order(),
        noise: facts.noise,
        consistent: facts.converges(embedding),
        conserves_energy: &facts.conserves_energy,
        commuting: &facts.commuting,
    }
    .emit()
}
