//! Constraints: their values, and their derivatives by coordinates and by the time. Tests:
//! `tests/constraints`.

use proc_macro2::TokenStream;
use quote::{format_ident, quote};

use super::kernel::Target;
use super::weighted::{ElementEmitter, Outputs};
use super::{Derivative, opened};
use crate::diagnostics::promised;
use crate::discretise::{Facts, unweighted};
use crate::emit::{count, implementation};
use crate::indices::Indices;
use crate::model::{Atom, Element, Index, System};

/// `impl Constrained`, for a system with constraints.
pub(crate) fn emit(system: &mut System, facts: &Facts) -> TokenStream {
    if system.constraints.is_empty() {
        return TokenStream::new();
    }
    let offsets = system.constraint_offsets();
    let all = promised(offsets.last().cloned(), "the last offset is the number of constraints");
    let known = all.as_integer().and_then(|known| usize::try_from(known).ok());
    let number = match known {
        Some(known) => {
            let known = count(known);
            quote!(#known)
        }
        None => {
            let all = Indices::unchecked(&system.tables).value(&all);
            quote!(#all as __wzvi::usize)
        }
    };
    let most = if known.is_some() { number.clone() } else { quote!(__wzvi::usize::MAX) };
    let layout = match (&system.line, known.map(count)) {
        (Some(line), Some(known)) => {
            let degrees = count(line.phase.q.len());
            quote!(__wzvi::constraints::DenseConstraints<#degrees, #known>)
        }
        _ => quote!(__wzvi::constraints::SparseConstraints),
    };
    let has_squares = facts.has_squares;
    let mut reads_time = false;
    let mut code = TokenStream::new();
    for (number, offset) in offsets.iter().take(system.constraints.len()).enumerate() {
        let constraint = &system.constraints[number];
        let own = match &constraint.family {
            Some(family) => {
                let member = Index::atom(Atom::Loop(family.variable));
                promised(offset.add(&member), "numbers of constraints are integers")
            }
            None => offset.clone(),
        };
        for element in constraint.term.values.clone() {
            reads_time |= element.reads_time(&system.graph, system.t);
            code.extend(rows(system, &element, &own));
        }
    }
    let opened = opened(system, &code);
    let body = quote! {
        type Layout = #layout;
        const READ_TIME: __wzvi::bool = #reads_time;
        const HAS_SQUARES: __wzvi::bool = #has_squares;
        const CONSTRAINTS: __wzvi::usize = #most;

        fn constraints(&self) -> __wzvi::usize {
            #number
        }

        #[cfg_attr(not(debug_assertions), inline(always))]
        fn constrain<__S: __wzvi::Scalar>(
            &self,
            __at: &__wzvi::elements::EvaluationPoint<'_, __S>,
            __into: &mut impl __wzvi::constraints::ConstraintRows<__S>,
        ) {
            #opened
            #code
        }
    };
    implementation(&system.item, &quote!(__wzvi::constraints::Constrained), &body)
}

/// The code of an element of a constraint with this number.
fn rows(system: &mut System, element: &Element, constraint: &Index) -> TokenStream {
    let graph = &mut system.graph;
    let of_constraint = |method: &str| Target::Constraint {
        method: format_ident!("{method}"),
        constraint: constraint.clone(),
    };
    let rate = graph.derivative(element.value, system.t);
    let mut values = vec![(element.value, of_constraint("value")), (rate, of_constraint("rate"))];
    for (symbol, coordinate) in element.coordinates() {
        let slope = graph.derivative(element.value, symbol);
        let (constraint, coordinate) = (constraint.clone(), coordinate.clone());
        values.push((slope, Target::Slope { constraint, coordinate }));
    }
    let mut emitter = ElementEmitter { model: system, derivative: Derivative::Rows };
    let weighted = unweighted(std::slice::from_ref(element));
    let outputs = Outputs { values, ..Outputs::default() };
    weighted.iter().map(|weighted| emitter.computed(weighted, None, outputs.clone())).collect()
}
