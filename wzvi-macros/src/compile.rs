//! The whole compiler on one page.

use proc_macro2::TokenStream;

use crate::backend::{back_end, elements_back_end};
use crate::diagnostics::Diagnostics;
use crate::emit::stubs::Stubs;
use crate::input::{self, Treatment};
use crate::lower::{lower, lower_elements};

/// The expansion of `#[hamiltonian(attribute)] item`: the struct with its integrators, or errors at the user's tokens
/// with the struct and stubs, so that `rustc` adds nothing to them.
pub(crate) fn expand(attribute: TokenStream, item: TokenStream) -> TokenStream {
    let mut diagnostics = Diagnostics::new();
    let mut stubs = Stubs::unrecognised(item.clone());
    let expansion = compile(attribute, item, &mut stubs, &mut diagnostics);
    match diagnostics.finish() {
        Ok(()) => expansion.unwrap_or_default(),
        Err(errors) => stubs.with_errors(&errors),
    }
}

/// Every pass, in order. `None` only after an error was reported.
fn compile(
    attribute: TokenStream,
    item: TokenStream,
    stubs: &mut Stubs,
    diagnostics: &mut Diagnostics,
) -> Option<TokenStream> {
    let system = input::read_struct(item, diagnostics);
    let mut declaration = input::read_attribute(attribute, diagnostics)?;
    let system = system?;
    stubs.recognise(&system.item, &declaration);

    let phase_space = input::read_phase_space(&mut declaration, diagnostics)?;
    stubs.set_degrees(phase_space.degrees());

    match phase_space.treatment {
        Treatment::Unrolled => {}
        Treatment::Either => {
            // What elements cannot express is unrolled; only then its mistakes are the user's.
            let mut trial = Diagnostics::new();
            let elements = lower_elements(&system, &declaration, &phase_space, &mut trial)
                .filter(|_| !trial.has_errors())
                .filter(|model| model.has_loops())
                .and_then(|model| {
                    let expansion = elements_back_end(model, &mut trial);
                    (!trial.has_errors()).then_some(expansion)
                });
            drop(trial.finish());
            if elements.is_some() {
                return elements;
            }
        }
        Treatment::Sized => {
            let model = lower_elements(&system, &declaration, &phase_space, diagnostics)?;
            return (!diagnostics.has_errors()).then(|| elements_back_end(model, diagnostics));
        }
    }
    let model = lower(system, declaration, &phase_space, diagnostics)?;
    if diagnostics.has_errors() {
        return None;
    }
    Some(back_end(model, diagnostics))
}

#[cfg(test)]
mod golden;
#[cfg(test)]
mod timing;
