//! Attributes inside of Hamiltonians and of the functions that they call. The compiler sees them before
//! `rustc` acts on them: it cannot evaluate `cfg`, and an attribute macro could replace what it has read.
//! Both are refused, wherever they are. Tests: `tests/accepted/attributes.rs`.

use proc_macro2::{Delimiter, Group, TokenStream, TokenTree};
use quote::ToTokens;
use syn::{Attribute, ItemStruct, Member};

use super::Field;
use crate::diagnostics::{Diagnostics, messages};
use crate::tokens::{is_punct, regrouped};

/// Attributes of `rustc` that change no value.
const HARMLESS: &str = "allow warn deny forbid expect doc inline cold must_use deprecated track_caller automatically_derived \
                        no_mangle export_name link_section target_feature instruction_set optimize coverage unsafe";

/// Attributes of tools, `#[rustfmt::skip]`.
const TOOLS: &str = "rustfmt clippy diagnostic miri rust_analyzer rustdoc";

/// The item that carries the attribute of this crate.
#[derive(Clone, Copy)]
pub(crate) enum MacroKind {
    Hamiltonian,
    Function,
}

/// Reports the attributes that are refused.
pub(crate) fn check(item: &impl ToTokens, carrier: MacroKind, diagnostics: &mut Diagnostics) {
    without_refused(item.to_token_stream(), carrier, diagnostics);
}

/// The tokens without attributes that are refused, which it reports.
pub(super) fn without_refused(
    tokens: TokenStream,
    carrier: MacroKind,
    diagnostics: &mut Diagnostics,
) -> TokenStream {
    let mut kept = TokenStream::new();
    let mut tokens = tokens.into_iter().peekable();
    while let Some(token) = tokens.next() {
        if let TokenTree::Group(group) = &token {
            kept.extend([regrouped(group, without_refused(group.stream(), carrier, diagnostics))]);
            continue;
        }
        let mut read = TokenStream::from(token.clone());
        if is_punct(&token, '#') {
            if let Some(inner) = tokens.next_if(|next| is_punct(next, '!')) {
                read.extend([inner]);
            }
            if let Some(TokenTree::Group(group)) = tokens.next_if(is_bracketed) {
                read.extend([TokenTree::from(group.clone())]);
                if let Some(error) = refusal(&group, &read, carrier) {
                    diagnostics.report(error);
                    continue;
                }
            }
        }
        kept.extend(read);
    }
    kept
}

/// `#[cfg]` on a struct is evaluated where it is above the attribute of this crate, and on a field where
/// `rustc` still sees it: not on the struct below that attribute, on its generics, and on fields whose place
/// or kind it decides.
pub(super) fn check_struct(item: &ItemStruct, fields: &[Field], diagnostics: &mut Diagnostics) {
    let generics = item.generics.params.iter().flat_map(|parameter| match parameter {
        syn::GenericParam::Lifetime(parameter) => &parameter.attrs,
        syn::GenericParam::Type(parameter) => &parameter.attrs,
        syn::GenericParam::Const(parameter) => &parameter.attrs,
    });
    let has_rival = |field: &Field| {
        let mut others = fields.iter().filter(|other| other.member == field.member && other.is_readable());
        field.is_readable() && others.any(|other| other.kind != field.kind)
    };
    let ambiguous = item.fields.iter().zip(fields);
    let ambiguous =
        ambiguous.filter(|(_, field)| matches!(field.member, Member::Unnamed(_)) || has_rival(field));
    let fields = ambiguous.flat_map(|(field, _)| &field.attrs);
    for attribute in item.attrs.iter().chain(generics).filter(|attribute| is_condition(attribute)) {
        diagnostics.report(messages::condition_of_struct(attribute));
    }
    for attribute in fields.filter(|attribute| is_condition(attribute)) {
        diagnostics.report(messages::condition_of_field(attribute));
    }
}

fn is_condition(attribute: &Attribute) -> bool {
    attribute.path().is_ident("cfg")
}

fn refusal(group: &Group, attribute: &TokenStream, carrier: MacroKind) -> Option<syn::Error> {
    let meta = opened(group.stream());
    let name = meta.first()?.to_string();
    let is_of_tool = meta.get(1).is_some_and(|token| is_punct(token, ':'));
    let known = if is_of_tool { TOOLS } else { HARMLESS };
    match (name.as_str(), carrier) {
        ("cfg" | "cfg_attr", MacroKind::Hamiltonian) => Some(messages::condition_of_build(attribute)),
        ("cfg" | "cfg_attr", MacroKind::Function) => Some(messages::condition_in_function(attribute)),
        (name, _) if known.split(' ').any(|known| known == name) => None,
        (_, MacroKind::Hamiltonian) => Some(messages::attribute_inside(attribute)),
        (_, MacroKind::Function) => Some(messages::attribute_of_function(attribute)),
    }
}

/// The tokens of an attribute, out of the invisible group in which `macro_rules!` passes `$attribute:meta`.
fn opened(meta: TokenStream) -> Vec<TokenTree> {
    let tokens: Vec<TokenTree> = meta.into_iter().collect();
    match tokens.as_slice() {
        [TokenTree::Group(group)] if group.delimiter() == Delimiter::None => opened(group.stream()),
        _ => tokens,
    }
}

fn is_bracketed(token: &TokenTree) -> bool {
    matches!(token, TokenTree::Group(group) if group.delimiter() == Delimiter::Bracket)
}
