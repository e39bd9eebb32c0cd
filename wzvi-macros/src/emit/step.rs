//! The step of one scheme as straight-line code. Tests: `tests/steps`, and the golden expansions
//! (`compile/golden_tests.rs`).

use proc_macro2::{Ident, TokenStream};
use quote::quote;

use super::names::Namer;
use super::plan::plan;
use super::system::{count, state_names};
use super::terms;
use super::{discretized, implementation};
use crate::discretise::{Facts, Linearity, NoiseClass, Scheme, SchemePlan, Strategy, Unknowns};
use crate::symbolic::Graph;

mod block_inputs;
mod memory;
mod prepare;
mod solve;
mod step_program;

use prepare::Prepared;
use step_program::StepProgram;

/// `dw`, or `dw1`, `dw2`, ... as in the equations.
pub(crate) fn increment_names(names: &mut Namer, noises: usize) -> Vec<Ident> {
    match noises {
        1 => vec![names.take("dw")],
        _ => names.take_all((1..=noises).map(|k| format!("dw{k}"))),
    }
}

/// The implementation of one scheme. `is_alone`: no other scheme has straight-line code.
pub(crate) fn emit(
    item: &syn::ItemStruct,
    graph: &mut Graph,
    facts: &Facts,
    plan: &SchemePlan,
    scheme: &Scheme,
    text: &str,
    is_alone: bool,
) -> TokenStream {
    let line = &*scheme.line;
    let step_program = StepProgram::new(graph, &line.parameters, scheme, facts.noise == NoiseClass::None);
    let noises = scheme.lagrangian.symbols.dw.len();
    let mut names = Namer::default();
    let [q, p] = state_names(&mut names, graph, &line.phase);
    let (d, n) = (count(q.len()), count(noises));
    let dw = increment_names(&mut names, noises);
    let prepared = Prepared::new(&step_program, graph, &line.parameters, &mut names);
    let [functions, solve] = solve::solution(&step_program, &prepared, [q, p, dw], names);
    let (prepared_type, prepare) = (prepared.ty(), &prepared.method);
    let memory = memory::memory_type(&step_program.newton_sizes());
    let carry = match step_program.affords_compensation() {
        true => quote!(__wzvi::FixedCompensatedSum<__S, #d>),
        false => quote!(__wzvi::PlainSum),
    };
    // For a step in loops, at most the momentum between two ends.
    let strategy = Strategy { unknowns: Unknowns::Momenta, linearity: Linearity::Nonlinear };
    let quadrature = terms::quadrature(&plan.quadrature, strategy, false);
    let constant = self::plan(plan, scheme);
    let embedding = plan.embedding.path(&quote!(__wzvi));
    let body = quote! {
            const PLAN: __wzvi::Plan = #constant;
            const QUADRATURE: __wzvi::elements::Quadrature = #quadrature;
            type Prepared = #prepared_type;
            type Memory<__S: __wzvi::Scalar> = #memory;
            type Sum<__S: __wzvi::Scalar> = #carry;
            #prepare
            #solve
    };
    let step = implementation(item, &quote!(__wzvi::StraightLine<#embedding, #d, #n>), &body);
    let step = quote!(#functions #step);
    // The names of the equations differ between schemes.
    let step = match is_alone || functions.is_empty() {
        true => step,
        false => quote!(const _: () = { #step };),
    };
    let straight = quote!(__wzvi::Straight<#embedding, #d, #n>);
    let listed = discretized(item, &plan.embedding, &straight, text, None);
    quote!(#step #listed)
}
