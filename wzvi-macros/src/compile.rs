//! The whole compiler on one page.

use std::rc::Rc;

use proc_macro2::TokenStream;
use quote::quote;

use crate::check::check;
use crate::choose::choose;
use crate::describe::Texts;
use crate::diagnostics::{Diagnostics, Located, internal};
use crate::discretise::{Facts, Plans};
use crate::embedding::Embedding;
use crate::emit::stubs::Stubs;
use crate::emit::{Expansion, emit, export};
use crate::functions;
use crate::input::{self, Library};
use crate::lower::lower;
use crate::model::{Form, System};
use crate::passes::clock::clock;
use crate::passes::collect::{collect, collect_observables};
use crate::passes::divisors::divisors;
use crate::passes::friction::friction;
use crate::passes::ito::ito;
use crate::passes::unroll::{may_be_written_out, unroll, written_out};

/// The expansion of `#[hamiltonian(attribute)] item`: the struct with its integrators, or errors at the
/// user's tokens with the struct and stubs, so that `rustc` adds no errors of its own.
pub(crate) fn expand(attribute: TokenStream, item: TokenStream) -> TokenStream {
    if let Some(pending) = functions::pending(&attribute, &item) {
        // Mistakes that do not depend on the shared functions are reported first.
        let library = Library { is_pending: true, ..Library::default() };
        let mut diagnostics = Diagnostics::new();
        let mut stubs = Stubs::unrecognised(TokenStream::new());
        compile(attribute.clone(), item.clone(), library, &mut stubs, &mut diagnostics);
        if diagnostics.finish().is_ok() {
            return pending.with_struct(stubs.with_errors(&TokenStream::new()));
        }
    }
    let stubs = Stubs::unrecognised(item.clone());
    let declared = |Expansion { doc, item, implementations }| quote! { #doc #item #implementations };
    expand_with(attribute, item, Library::default(), stubs, declared)
}

/// The expansion with the definitions of shared functions, beside the struct, which stands already.
pub(crate) fn expand_with_definitions(
    attribute: TokenStream,
    item: TokenStream,
    library: Library,
) -> TokenStream {
    let beside = |Expansion { doc, item, implementations }: Expansion| {
        let (name, (parameters, arguments, condition)) = (&item.ident, item.generics.split_for_impl());
        quote! { #doc impl #parameters #name #arguments #condition {} #implementations }
    };
    expand_with(attribute, item, library, Stubs::unrecognised(TokenStream::new()), beside)
}

fn expand_with(
    attribute: TokenStream,
    item: TokenStream,
    library: Library,
    mut stubs: Stubs,
    together: impl FnOnce(Expansion) -> TokenStream,
) -> TokenStream {
    let mut diagnostics = Diagnostics::new();
    let expansion = compile(attribute, item, library, &mut stubs, &mut diagnostics);
    if expansion.is_none() && !diagnostics.has_errors() {
        internal::broken("what is not expanded has an error");
    }
    internal::error().into_iter().for_each(|error| diagnostics.report(error));
    match diagnostics.finish() {
        Ok(()) => expansion.map(together).unwrap_or_default(),
        Err(errors) => stubs.with_errors(&errors),
    }
}

/// Every pass, in order. `None` only after an error was reported.
fn compile(
    attribute: TokenStream,
    item: TokenStream,
    library: Library,
    stubs: &mut Stubs,
    diagnostics: &mut Diagnostics,
) -> Option<Expansion> {
    // read
    let container = input::read_struct(item, diagnostics);
    let mut declaration = input::read_attribute(attribute, diagnostics)?;
    declaration.library = library;
    let container = container?;
    stubs.recognise(&container.item, &declaration);
    let phase_space = input::read_phase_space(&mut declaration, diagnostics)?;
    stubs.degrees = phase_space.degrees();

    // lower
    let exported = export::emit(&container.item, &declaration);
    let mut system = lower(container, declaration, &phase_space, diagnostics)?;
    divisors(&mut system);
    let mut expansion = expand_lowered(system, diagnostics)?;
    expansion.implementations.extend(exported);
    Some(expansion)
}

/// The passes after the user's program is read. `None` only after an error was reported.
fn expand_lowered(mut system: System, diagnostics: &mut Diagnostics) -> Option<Expansion> {
    // choose
    let listed = values(&system.embeddings);
    let choice = choose(&mut system, &listed);
    (system.form, system.slopes) = (choice.elements, choice.slopes);

    // analyse
    let (mut system, facts) = analyse(system, diagnostics)?;

    // derive, describe, emit
    if choice.has_straight_lines() {
        system.line = written_out(&mut system).map(Rc::new);
    }
    let plans = Plans::new(&mut system, &facts, listed, |embedding| choice.of(embedding));
    let texts = Texts::new(&mut system, &facts, &plans);
    Some(emit(&mut system, &facts, &plans, &texts))
}

/// The system as elements in its form, and its facts. A small system that is refused in loops is written out:
/// more is known of one size than of all. `None` after an error was reported.
fn analyse(mut system: System, diagnostics: &mut Diagnostics) -> Option<(System, Facts)> {
    if diagnostics.has_errors() {
        return None;
    }
    if system.form == Form::Loops && may_be_written_out(&system) {
        let mut in_loops = Diagnostics::new();
        let mut looped = system.clone();
        let facts = analyse_in_form(&mut looped, &mut in_loops);
        if in_loops.finish().is_ok() {
            return facts.map(|facts| (looped, facts));
        }
        system.form = Form::StraightLines;
    }
    let facts = analyse_in_form(&mut system, diagnostics)?;
    Some((system, facts))
}

fn analyse_in_form(system: &mut System, diagnostics: &mut Diagnostics) -> Option<Facts> {
    unroll(system);
    collect(system, diagnostics);
    ito(system, diagnostics);
    friction(system, diagnostics);
    if diagnostics.has_errors() {
        return None;
    }
    clock(system, diagnostics);
    if diagnostics.has_errors() {
        return None;
    }
    let facts = Facts::new(system);
    check(system, &facts, diagnostics);
    collect_observables(system, diagnostics);
    (!diagnostics.has_errors()).then_some(facts)
}

/// The schemes, and the schemes inside thermostats.
fn values(embeddings: &[Located<Embedding>]) -> Vec<Embedding> {
    let mut values = Vec::new();
    for Located { value, .. } in embeddings {
        if let Embedding::Thermostat(inner) = value {
            values.push(Embedding::Isolated(inner.clone()));
        }
        values.push(value.clone());
    }
    values
}

#[cfg(test)]
mod divisor_tests;
#[cfg(test)]
mod effort_tests;
#[cfg(test)]
mod golden_tests;
#[cfg(test)]
mod message_tests;
#[cfg(test)]
mod observable_tests;
#[cfg(test)]
mod order_tests;
