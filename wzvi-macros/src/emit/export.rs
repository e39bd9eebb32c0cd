//! `impl Exported`: what a program in another language has to know of a system to make and run one. It is
//! written only where the key `export` asks for it. Tests: `tests/paths/export.rs`.

mod one_line;

use proc_macro2::TokenStream;
use quote::{ToTokens, quote};
use syn::ext::IdentExt;
use syn::{Attribute, Expr, ExprLit, Lit, Member, Meta};

use crate::diagnostics::source;
use crate::input::{Declaration, DeclaredClock, Hamiltonian};
use crate::key::Key;

use one_line::one_line;

/// The implementation, in the scope of the user, whose types it names.
pub(crate) fn emit(item: &syn::ItemStruct, declaration: &Declaration) -> Option<TokenStream> {
    let further = declaration.export.as_ref()?;
    let wzvi = &declaration.crate_path;
    let exported = quote!(#wzvi::exported);
    let mut schemes: Vec<&syn::Type> = Vec::new();
    let mut scheme_names: Vec<String> = Vec::new();
    let written = declaration.written_schemes().into_iter().map(|(_, written)| written);
    for scheme in written.chain(further) {
        let name = source(scheme);
        if !scheme_names.contains(&name) {
            schemes.push(scheme);
            scheme_names.push(name);
        }
    }
    let list = schemes.iter().rev().fold(quote!(()), |rest, scheme| quote!((#scheme, #rest)));
    let (name, doc) = (item.ident.unraw().to_string(), documentation(&item.attrs));
    let closures = closures(declaration).into_iter().map(|(key, text)| quote!((#key, #text)));
    let members = item.fields.members().zip(&item.fields);
    let fields: Vec<FieldOfSystem> =
        members.map(|(member, field)| FieldOfSystem::new(member, field)).collect();
    let described = fields.iter().map(|FieldOfSystem { conditions, name, ty, doc, .. }| {
        quote!(#(#conditions)* #exported::FieldDescription { name: #name, ty: #ty, doc: #doc })
    });
    let types = item.fields.iter().map(|field| &field.ty);
    // With its type, at which `rustc` says that numbers make no such value.
    let given = fields.iter().zip(types).map(|(FieldOfSystem { conditions, member, name, .. }, ty)| {
        quote!(#(#conditions)* #member: #exported::field::<#ty>(__fields, #name)?)
    });
    let str = quote!(&'static ::core::primitive::str);
    let body = quote! {
        const NAME: #str = #name;
        const DOC: #str = #doc;
        const FIELDS: &'static [#exported::FieldDescription] = &[#(#described),*];
        const CLOSURES: &'static [(#str, #str)] = &[#(#closures),*];
        const SCHEMES: &'static [#str] = &[#(#scheme_names),*];
        type Schemes = #list;

        fn from_fields(
            __fields: &dyn #exported::GivenFields,
        ) -> ::core::result::Result<Self, #wzvi::error::ConfigError> {
            ::core::result::Result::Ok(Self { #(#given),* })
        }
    };
    let implementation = super::implementation(item, &quote!(#exported::Exported), &body);
    Some(quote! {
        #[allow(warnings, clippy::all, clippy::pedantic, clippy::nursery, clippy::restriction)]
        #implementation
    })
}

/// A field as it is described and made.
struct FieldOfSystem<'f> {
    /// `#[cfg]` attributes: the field may not be there.
    conditions: Vec<&'f Attribute>,
    member: Member,
    name: String,
    ty: String,
    doc: String,
}

impl<'f> FieldOfSystem<'f> {
    fn new(member: Member, field: &'f syn::Field) -> Self {
        let name = match &member {
            Member::Named(name) => name.unraw().to_string(),
            Member::Unnamed(number) => number.index.to_string(),
        };
        Self {
            conditions: field.attrs.iter().filter(|attribute| attribute.path().is_ident("cfg")).collect(),
            member,
            name,
            ty: source(&field.ty),
            doc: documentation(&field.attrs),
        }
    }
}

/// The closures and the expressions beside them, each with its key, as they were written.
fn closures(declaration: &Declaration) -> Vec<(&'static str, String)> {
    let closures = declaration.closures.iter().map(|closure| (closure.key.name(), written(closure)));
    let mut all: Vec<(&str, String)> = closures.collect();
    if let Some(friction) = &declaration.friction {
        let key = if friction.is_matrix { Key::Damping } else { Key::Friction };
        all.push((key.name(), one_line(&friction.given.tokens)));
    }
    if let Some(temperature) = &declaration.temperature {
        all.push((Key::Temperature.name(), one_line(&temperature.tokens)));
    }
    let clock = declaration.clock.as_ref().and_then(|clock| match &clock.value {
        // It is among the closures.
        DeclaredClock::Function => None,
        DeclaredClock::Curvature(None) => Some("curvature".to_owned()),
        DeclaredClock::Curvature(Some(frequency)) => {
            Some(format!("curvature({})", one_line(&frequency.tokens)))
        }
        DeclaredClock::Pairs => Some("pairs".to_owned()),
    });
    all.extend(clock.map(|text| (Key::Clock.name(), text)));
    all
}

/// A closure with its name, or a family of closures.
fn written(closure: &Hamiltonian) -> String {
    let text = one_line(&closure.tokens);
    match (&closure.name, &closure.family) {
        (Some(name), _) => format!("{name} = {text}"),
        (None, Some(count)) => format!("[{text}; {}]", one_line(&count.to_token_stream())),
        (None, None) => text,
    }
}

/// The documentation of an item, line by line.
fn documentation(attributes: &[Attribute]) -> String {
    let lines = attributes.iter().filter_map(|attribute| match &attribute.meta {
        Meta::NameValue(pair) if pair.path.is_ident("doc") => match &pair.value {
            Expr::Lit(ExprLit { lit: Lit::Str(text), .. }) => Some(text.value()),
            _ => None,
        },
        _ => None,
    });
    let lines = lines.map(|line| line.strip_prefix(' ').unwrap_or(&line).trim_end().to_owned());
    lines.collect::<Vec<_>>().join("\n")
}
