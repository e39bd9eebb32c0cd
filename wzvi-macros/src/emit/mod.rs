//! From equations to Rust: the struct as written, its traits, and nothing that the scene does not use.

pub(crate) mod bath;
pub(crate) mod compose;
pub(crate) mod discretized;
mod gauss;
mod lagrangian;
pub(crate) mod names;
pub(crate) mod parts;
pub(crate) mod plan;
mod print;
mod program;
pub(crate) mod step;
pub(crate) mod stubs;
mod system;

use proc_macro2::TokenStream;
use quote::{ToTokens, quote};

use crate::describe::Texts;
use crate::discretise::Scheme;
use crate::discretise::facts::Facts;
use crate::discretise::facts::kinetic::Kinetic;
use crate::model::Model;

pub(crate) use names::{Names, Surroundings, readable};
pub(crate) use print::{Printer, f64_type};
pub(crate) use program::{Level, Lowering, Op};
pub(crate) use system::{
    count, friction_rate, invariants, number_of, parameter, parameter_names, reads_time, validate, variables,
};

/// Steps that are emitted another way, and what they read of the struct.
#[derive(Default)]
pub(crate) struct Beside {
    /// The kinetic energy, where a thermostat needs to know.
    pub(crate) kinetic: Option<Kinetic>,
    pub(crate) generated: TokenStream,
    pub(crate) user_tokens: Vec<TokenStream>,
}

/// Everything that `#[hamiltonian]` stands for: the schemes with their texts, and steps that are emitted another way.
pub(crate) fn emit(
    model: &mut Model,
    facts: &Facts,
    schemes: &[(&Scheme, &str)],
    beside: Beside,
    texts: &Texts,
) -> TokenStream {
    let mut generated = system::emit(model);
    for (scheme, text) in schemes {
        generated.extend(step::emit(model, facts, scheme, text));
    }
    generated.extend(beside.generated);
    generated.extend(gauss::emit(model, facts, texts));
    generated.extend(parts::emit(model, facts, texts));
    generated.extend(bath::emit(model, beside.kinetic));
    let surroundings = Surroundings {
        crate_path: &model.crate_path,
        tokens: with_header(
            &model.item,
            model.parameters.iter().map(|parameter| &parameter.tokens).chain(&beside.user_tokens),
        ),
        spelled: &model.type_checks,
        generics: &model.item.generics,
    };
    wrapped(&model.item, facts, generated, &surroundings, texts)
}

/// The struct as it was written, documented, and `generated` in a scope of its own.
pub(crate) fn wrapped(
    item: &syn::ItemStruct,
    facts: &Facts,
    mut generated: TokenStream,
    surroundings: &Surroundings<'_>,
    texts: &Texts,
) -> TokenStream {
    generated.extend(compose::emit(item, texts));
    generated.extend(facts.is_conservative.then(|| conservative(item)));
    let (doc, type_checks) = (documentation(texts), surroundings.spelled);
    let generated = readable(generated, surroundings);
    quote! {
        #doc
        #item
        #[allow(warnings, clippy::all, clippy::pedantic, clippy::nursery, clippy::restriction, clippy::cargo)]
        const _: () = {
            #generated
        };
        #type_checks
    }
}

/// `impl Conservative`, which says that there is a modified energy.
fn conservative(item: &syn::ItemStruct) -> TokenStream {
    let name = &item.ident;
    let (parameters, arguments, filter) = item.generics.split_for_impl();
    quote! {
        #[automatically_derived]
        impl #parameters __wzvi::Conservative for #name #arguments #filter {}
    }
}

/// What implementations name of the user's: the struct with its generics, and what `read` reads. The type of a constant
/// is left out: only primitive ones are allowed there.
pub(crate) fn with_header<'t>(
    item: &syn::ItemStruct,
    read: impl Iterator<Item = &'t TokenStream>,
) -> TokenStream {
    let parameters = item.generics.params.iter().map(|parameter| match parameter {
        syn::GenericParam::Const(constant) => constant.ident.to_token_stream(),
        other => other.to_token_stream(),
    });
    let (name, filter, read) = (&item.ident, &item.generics.where_clause, read.collect::<Vec<_>>());
    quote!(#name #(; #parameters)* #filter #(; #read)*)
}

/// The equations as rustdoc of the struct.
fn documentation(texts: &Texts) -> TokenStream {
    let blocks = texts.listed.iter().map(|(_, text)| format!("```text\n{text}\n```\n"));
    let text = format!("\n# Discrete equations\n\n{}", blocks.collect::<Vec<_>>().join("\n"));
    quote!(#[doc = #text])
}
