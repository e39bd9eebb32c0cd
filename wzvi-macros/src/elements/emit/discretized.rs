//! `impl Discretized<E>` of a system of elements: what the run time needs to know of a scheme.

use proc_macro2::TokenStream;
use quote::quote;

use crate::discretise::embedding::Embedding;
use crate::discretise::facts::Facts;
use crate::discretise::quadrature::{Quadrature, Stage};
use crate::elements::plan::Unknowns;
use crate::emit::plan::Plan;
use crate::emit::{embedding_type, f64_type};
use crate::input::{Length, Shape};
use crate::model::System;

/// The way in which the steps of a scheme are solved, as code.
pub(super) struct Road {
    /// What stands beside the implementation.
    pub(super) items: TokenStream,
    pub(super) plan: TokenStream,
    pub(super) unknowns: Unknowns,
    pub(super) is_linear: bool,
    /// Whether the paths of an ensemble run beside each other.
    pub(super) in_lanes: bool,
    /// `Prepared`, `Memory` and what works on them.
    pub(super) step: TokenStream,
    /// The body of `step_momentum`.
    pub(super) momentum: TokenStream,
}

/// `impl Discretized<E>`
pub(super) fn emit(
    model: &System,
    facts: &Facts,
    embedding: &Embedding,
    road: &Road,
    text: &str,
) -> TokenStream {
    let Road { items, plan, unknowns, is_linear, in_lanes, step, momentum } = road;
    let scheme = embedding_type(embedding, &quote!(__wzvi));
    let quadrature = Quadrature::new(facts, embedding);
    let stages = quadrature.stages.iter().map(stage);
    let update = match quadrature.momentum_update() {
        Some(factor) => {
            let factor = factor.to_f64();
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
    let name = &model.item.ident;
    let (generics, arguments, filter) = model.item.generics.split_for_impl();
    let f64 = f64_type();
    let elements = quote!(__wzvi::elements);
    quote! {
        const _: () = {
            const __SCHEME: #elements::Scheme = #elements::Scheme {
                stages: &[#(#stages),*],
                update: #elements::MomentumUpdate::#update,
                unknowns: #elements::Unknowns::#unknowns,
                remembers: #remembers,
                is_linear: #is_linear,
            };

            #items

            #[automatically_derived]
            impl #generics __wzvi::Discretized<#scheme> for #name #arguments #filter {
                const PLAN: __wzvi::Plan = #plan;
                const EQUATIONS: &'static __wzvi::core::primitive::str = #text;
                // A start that is no guide costs iterations, not digits.
                const REMEMBERS: __wzvi::core::primitive::bool = false;
                const IN_LANES: __wzvi::core::primitive::bool = #in_lanes;
                type Compensated<__S: __wzvi::Scalar> = #elements::CompensationVec<__S>;
                type Carry<__S: __wzvi::Scalar> = __wzvi::Plain;

                #step

                fn discrete_lagrangian(
                    &self,
                    __segment: &__wzvi::Segment<Self::Vector>,
                    __dw: &[#f64],
                ) -> #f64 {
                    #elements::discrete_lagrangian(self, &__SCHEME, __segment, __dw)
                }

                fn discrete_lagrangian_gradient(
                    &self,
                    __segment: &__wzvi::Segment<Self::Vector>,
                    __dw: &[#f64],
                ) -> __wzvi::LagrangianGradient<Self::Vector> {
                    #elements::discrete_lagrangian_gradient(self, &__SCHEME, __segment, __dw)
                }

                fn step_momentum(
                    &self,
                    __before: &__wzvi::State<Self::Vector>,
                    __after: &__wzvi::State<Self::Vector>,
                    __h: #f64,
                    __dw: &[#f64],
                ) -> Self::Vector {
                    #momentum
                }
            }
        };
    }
}

/// A quadrature point, as the run time reads it.
fn stage(stage: &Stage) -> TokenStream {
    let (point, start, end) = (stage.l.to_f64(), stage.start().to_f64(), stage.end().to_f64());
    let parts = stage.parts.iter().map(|&(part, weight)| {
        let (number, weight) = (part as usize, weight.to_f64());
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
    let nan_checks = model.parameters.iter().map(|parameter| &parameter.tokens);
    let f64 = f64_type();
    let elements = quote!(__wzvi::elements);
    let step = quote! {
        type Prepared = ();
        type Memory<__S: __wzvi::Scalar> = #elements::Memory<__S>;

        fn memory(&self) -> #elements::Memory<#f64> {
            #elements::Memory::new(self, &__SCHEME)
        }

        fn prepare(&self, __h: #f64) -> __wzvi::core::result::Result<(), __wzvi::ConfigError> {
            #(
                if #f64::is_nan(#nan_checks) {
                    return __wzvi::core::result::Result::Err(__wzvi::ConfigError::Parameter);
                }
            )*
            #elements::prepare(self)
        }

        fn advance_carrying<
            __S: __wzvi::Scalar,
            __C: __wzvi::Carry<__S>,
            const __CAREFUL: __wzvi::core::primitive::bool,
        >(
            &self,
            __prepared: &(),
            __t: #f64,
            __h: #f64,
            __q: &mut [__S],
            __p: &mut [__S],
            __dw: &[__S],
            __memory: &mut #elements::Memory<__S>,
            __carry: &mut __C,
        ) -> __wzvi::core::result::Result<__wzvi::Effort, __wzvi::StepFailure> {
            #elements::advance::<_, __S, __C, __CAREFUL>(
                self, &__SCHEME, __t, __h, __q, __p, __dw, __memory, __carry,
            )
        }
    };
    Road {
        items: TokenStream::new(),
        plan: plan(model, facts, embedding, unknowns, is_linear),
        unknowns,
        is_linear,
        in_lanes: !model.noise.is_empty() && unknowns == Unknowns::None,
        step,
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
        (Shape::Real, _) => quote!(#per_degree),
        (Shape::Array(_, Length::Literal(len)), _) => {
            let unknowns = len * components * per_degree;
            quote!(#unknowns)
        }
        (Shape::Array(_, Length::Named(expr)), _) => quote!((#expr) * #components * #per_degree),
        _ => quote!(__wzvi::core::primitive::usize::MAX),
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
