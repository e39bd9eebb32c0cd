//! The whole compiler on one page.

use std::rc::Rc;

use proc_macro2::TokenStream;
use quote::quote;

use crate::check::check;
use crate::describe::{Texts, derived};
use crate::diagnostics::{Diagnostics, Located, internal};
use crate::discretise::{Facts, Step};
use crate::embedding::Embedding;
use crate::emit::stubs::Stubs;
use crate::emit::{Expansion, emit};
use crate::functions;
use crate::input::{self, Library};
use crate::lower::lower;
use crate::passes::collect::collect;
use crate::passes::friction::friction;
use crate::passes::ito::ito;
use crate::passes::unroll::{unroll, written_out};

/// The expansion of `#[hamiltonian(attribute)] item`: the struct with its integrators, or errors at the user's tokens
/// with the struct and stubs, so that `rustc` adds no errors of its own.
pub(crate) fn expand(attribute: TokenStream, item: TokenStream) -> TokenStream {
    if let Some(question) = functions::questions(&attribute, &item) {
        // Mistakes that do not depend on the shared functions are reported first.
        let library = Library { is_pending: true, ..Library::default() };
        let mut diagnostics = Diagnostics::new();
        let mut stubs = Stubs::unrecognised(TokenStream::new());
        compile(attribute.clone(), item.clone(), library, &mut stubs, &mut diagnostics);
        if diagnostics.finish().is_ok() {
            return question.beside_struct(stubs.with_errors(&TokenStream::new()));
        }
    }
    let stubs = Stubs::unrecognised(item.clone());
    let declared = |Expansion { doc, item, implementations }| quote! { #doc #item #implementations };
    expand_with(attribute, item, Library::default(), stubs, declared)
}

/// The same, once the functions that the Hamiltonians call are known, beside the struct.
pub(crate) fn expand_beside(attribute: TokenStream, item: TokenStream, library: Library) -> TokenStream {
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
    let mut system = lower(container, declaration, &phase_space, diagnostics)?;
    unroll(&mut system);
    collect(&mut system, diagnostics);
    ito(&mut system, diagnostics);
    friction(&mut system, diagnostics);
    if diagnostics.has_errors() {
        return None;
    }

    // analyse
    let facts = Facts::new(&mut system);
    check(&mut system, &facts, diagnostics);
    if diagnostics.has_errors() {
        return None;
    }

    // derive, describe, emit
    system.line = written_out(&mut system).map(Rc::new);
    let listed = values(&system.embeddings);
    let steps: Vec<Step> =
        derived(listed.iter()).iter().map(|embedding| Step::of(&mut system, &facts, embedding)).collect();
    let texts = Texts::new(&mut system, &facts, &listed, &steps);
    Some(emit(&mut system, &facts, &steps, &texts))
}

/// The schemes, and those inside of thermostats.
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
mod effort_tests;
#[cfg(test)]
mod golden_tests;
#[cfg(test)]
mod message_tests;
