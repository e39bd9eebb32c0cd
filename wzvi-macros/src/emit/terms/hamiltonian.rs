//! The description of a system: its sizes and names, parameters, friction. Tests: the golden expansions
//! (`compile/golden_tests.rs`).

use proc_macro2::TokenStream;
use quote::{ToTokens, format_ident, quote};

use super::{noise_count, vector_type};
use crate::discretise::split;
use crate::emit::overrides::{self, holds};
use crate::emit::{Body, count, evaluation, f64_type};
use crate::input::Labels;
use crate::model::{Parameter, System};
use crate::symbolic::{Expr, Graph};

/// The description of the system.
pub(super) fn emit(model: &mut System) -> TokenStream {
    let friction = model.conformal.map(|rate| friction_rate(&mut model.graph, &model.parameters, rate));
    let model = &*model;
    let vector = vector_type(model);
    let noises = (!model.noise.is_empty()).then(|| number_of("noises", &noise_count(model)));
    let [invariants, observables] =
        [("invariants", &model.invariant_names), ("observables", &model.observable_names)].map(
            |(name, known)| {
                let number = || number_of(name, &count(known.len()).into_token_stream());
                (!known.is_empty()).then(number)
            },
        );
    let manifold = (!model.constraints.is_empty()).then(|| {
        quote! {
            fn manifold(&self) -> __wzvi::Option<&dyn __wzvi::constraints::Manifold> {
                __wzvi::Some(self)
            }
        }
    });
    let parameter = parameter(&model.graph, model.listed());
    let validate = validate(model);
    let variables = variables(model);
    quote! {
        type Vector = #vector;
        #noises
        #manifold
        #invariants
        #observables
        #variables
        #parameter
        #friction
        #validate
    }
}

/// Friction, forces and explicit time of the system, if any.
pub(super) fn kind(model: &System) -> Option<TokenStream> {
    let reads_time = split::reads_time(&model.graph, &model.drift, model.t);
    let is_conformal = model.conformal.is_some();
    let is_forced = model.force.is_some();
    let has_noise_forces = model.noise.iter().any(|noise| noise.is_force);
    if !(is_conformal || is_forced || has_noise_forces || reads_time) {
        return None;
    }
    let acting = overrides::KindOverrides {
        is_conformal: holds(is_conformal),
        is_forced: holds(is_forced),
        has_noise_forces: holds(has_noise_forces),
        reads_time: holds(reads_time),
    };
    Some(acting.over(&quote!(__wzvi::Kind), quote!(__wzvi::Kind::AUTONOMOUS)))
}

/// `Hamiltonian::validate` of a system with friction but no bath; a bath is checked when its steps are
/// prepared.
fn validate(model: &System) -> Option<TokenStream> {
    (model.friction.is_some() && !model.has_thermostat()).then(|| {
        quote! {
            fn validate(&self) -> __wzvi::Result<(), __wzvi::ConfigError> {
                __wzvi::bath::validate(self)
            }
        }
    })
}

/// The description of friction that the steps include exactly.
fn friction_rate(graph: &mut Graph, parameters: &[Parameter], rate: Expr) -> TokenStream {
    let Body { statements, values, .. } = evaluation(graph, parameters, &[rate]);
    quote! {
        fn friction_rate<__K: __wzvi::Constant>(&self, __parameters: &[__K]) -> __K {
            #statements
            #(#values)*
        }
    }
}

/// A method that returns a count; the default of the trait is zero.
fn number_of(name: &str, number: &TokenStream) -> TokenStream {
    let name = format_ident!("{name}");
    quote! {
        fn #name(&self) -> __wzvi::usize {
            #number
        }
    }
}

/// Names and values of the parameters, and which are integers; the default of the trait if there are none.
fn parameter(graph: &Graph, parameters: &[Parameter]) -> Option<TokenStream> {
    let (f64, option) = (f64_type(), quote!(__wzvi::Option));
    let entries = parameters.iter().map(|Parameter { symbol, tokens, .. }| {
        let name = graph.symbol_name(*symbol);
        quote!((#name, #tokens))
    });
    let integers = (0..).zip(parameters).filter(|(_, parameter)| parameter.is_integer);
    let integers: Vec<_> = integers.map(|(number, _)| count(number)).collect();
    let integers = (!integers.is_empty()).then(|| {
        quote! {
            fn integers(&self) -> &'static [__wzvi::usize] {
                &[#(#integers),*]
            }
        }
    });
    (!parameters.is_empty()).then(|| {
        quote! {
            #integers
            fn parameter(&self, __index: __wzvi::usize) -> #option<(&'static __wzvi::str, #f64)> {
                [#(#entries),*].get(__index).copied()
            }
        }
    })
}

/// The displayed names of the variables; the default of the trait where they agree.
fn variables(model: &System) -> Option<TokenStream> {
    let System { labels, invariant_names: invariants, observable_names: observables, .. } = model;
    let t = model.graph.symbol_name(model.t);
    let is_default = |labels: &Labels, name: &str| match labels {
        Labels::Each(names) => *names == [name],
        Labels::Array(array, inner) => array == name && inner.is_empty(),
    };
    let [q, p] = labels;
    let has_names = invariants.iter().any(|name| !name.is_empty());
    if t == "t" && is_default(q, "q") && is_default(p, "p") && !has_names && observables.is_empty() {
        return None;
    }
    let [q, p] = labels.each_ref().map(|labels| match labels {
        Labels::Each(names) => quote!(__wzvi::Labels::Each(&[#(#names),*])),
        Labels::Array(name, inner) => {
            let inner = inner.iter().map(|&length| count(length));
            quote!(__wzvi::Labels::Array { name: #name, inner: &[#(#inner),*] })
        }
    });
    let invariants = invariants.iter().filter(|_| has_names);
    Some(quote! {
        fn variables(&self) -> __wzvi::Variables {
            __wzvi::Variables {
                q: #q,
                p: #p,
                t: #t,
                invariants: &[#(#invariants),*],
                observables: &[#(#observables),*],
            }
        }
    })
}
