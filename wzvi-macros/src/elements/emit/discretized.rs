//! `impl Discretized<E>` of a system of elements: what the run time needs to know of a scheme.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use crate::discretise::facts::Facts;
use crate::discretise::quadrature::{Quadrature, Stage};
use crate::elements::plan::Unknowns;
use crate::embedding::Embedding;
use crate::emit::discretized::Discretized;
use crate::emit::plan::Plan;
use crate::emit::{count, f64_type};
use crate::input::{Length, Shape};
use crate::model::{Parameter, System};

/// The way in which the steps of a scheme are solved, as code.
pub(super) struct Road {
    /// What stands beside the implementation.
    pub(super) items: TokenStream,
    pub(super) plan: TokenStream,
    pub(super) unknowns: Unknowns,
    pub(super) is_linear: bool,
    /// Whether the paths of an ensemble run beside each other.
    pub(super) in_lanes: bool,
    /// The types, the last for numbers `__S`.
    pub(super) prepared: TokenStream,
    pub(super) memory: TokenStream,
    /// The bodies, by method.
    pub(super) new_memory: TokenStream,
    pub(super) prepare: TokenStream,
    pub(super) inline: TokenStream,
    pub(super) advance: TokenStream,
    pub(super) advance_vectors: Option<TokenStream>,
    pub(super) momentum: TokenStream,
}

/// `impl Discretized<E>`
pub(super) fn emit(
    model: &System,
    facts: &Facts,
    embedding: &Embedding,
    road: Road,
    text: &str,
) -> TokenStream {
    let (scheme, items) = (scheme(model, facts, embedding, &road), road.items);
    let (elements, in_lanes) = (quote!(__wzvi::elements), road.in_lanes);
    Discretized {
        item: &model.item,
        embedding,
        text,
        items: quote!(#scheme #items),
        // A start that is no guide costs iterations, not digits.
        constants: quote! {
            const REMEMBERS: __wzvi::bool = false;
            const IN_LANES: __wzvi::bool = #in_lanes;
        },
        plan: road.plan,
        prepared: road.prepared,
        beside: None,
        memory: road.memory,
        compensated: quote!(#elements::CompensationVec<__S>),
        carry: quote!(__wzvi::Plain),
        new_memory: Some(road.new_memory),
        prepare: road.prepare,
        inline: road.inline,
        advance: road.advance,
        advance_vectors: road.advance_vectors,
        lagrangian: quote!(#elements::discrete_lagrangian(self, &__SCHEME, __segment, __dw)),
        gradient: quote!(#elements::discrete_lagrangian_gradient(self, &__SCHEME, __segment, __dw)),
        momentum: road.momentum,
    }
    .emit()
}

/// What the run time needs to know of the scheme.
fn scheme(model: &System, facts: &Facts, embedding: &Embedding, road: &Road) -> TokenStream {
    let Road { unknowns, is_linear, .. } = road;
    let quadrature = Quadrature::new(facts, embedding);
    let stages = quadrature.stages.iter().map(stage);
    let update = match quadrature.momentum_update() {
        Some(factor) => {
            let factor = Literal::f64_unsuffixed(factor.to_f64());
            quote!(Multiple(#factor))
        }
        None => quote!(Slopes),
    };
    let remembers = model.noise.is_empty() && *unknowns != Unknowns::None;
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

/// All sites at once, in loops.
pub(super) fn sweep(
    model: &System,
    facts: &Facts,
    embedding: &Embedding,
    unknowns: Unknowns,
    is_linear: bool,
) -> Road {
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
    let advance = match unknowns {
        Unknowns::None => quote!(#elements::advance_explicit::<_, __S, __C>),
        Unknowns::Momenta | Unknowns::Both => quote!(#elements::advance::<_, __S, __C, __CAREFUL>),
    };
    Road {
        items: TokenStream::new(),
        plan: plan(model, facts, embedding, unknowns, is_linear),
        unknowns,
        is_linear,
        in_lanes: unknowns == Unknowns::None,
        prepared: quote!(()),
        memory: quote!(#elements::Memory<__S>),
        new_memory: quote!(#elements::Memory::new(self, &__SCHEME)),
        prepare: quote! {
            #nan_check
            #elements::prepare(self)
        },
        inline: if unknowns == Unknowns::None { quote!(#[inline(always)]) } else { TokenStream::new() },
        advance: quote! {
            #advance(self, &__SCHEME, __t, __h, __q, __p, __dw, __memory, __carry)
        },
        advance_vectors: (unknowns == Unknowns::None).then(|| {
            let vectors = quote!(#elements::advance_explicit_vectors);
            quote!(#vectors(self, &__SCHEME, __t, __h, __q, __p, __dw, __memory, __carry))
        }),
        momentum: quote!(#elements::step_momentum(self, &__SCHEME, __before, __after, __h, __dw)),
    }
}

pub(super) fn plan(
    model: &System,
    facts: &Facts,
    embedding: &Embedding,
    chosen: Unknowns,
    is_linear: bool,
) -> TokenStream {
    let solver = match chosen {
        Unknowns::None => quote!(Explicit),
        _ if is_linear => quote!(Linear),
        _ => quote!(Newton),
    };
    let per_degree: usize = match chosen {
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
