//! The schemes of `embedding = ...`.

use quote::ToTokens;
use syn::{GenericArgument, PathArguments, Type};

use crate::diagnostics::{Diagnostics, messages};
use crate::discretise::embedding::Embedding;
use crate::model::{Extent, Located};

/// The schemes, each once; mistakes are reported.
pub(super) fn read_embeddings(
    types: &[Type],
    diagnostics: &mut Diagnostics,
) -> Vec<(Located<Embedding>, Type)> {
    let mut embeddings: Vec<(Located<Embedding>, Type)> = Vec::new();
    for ty in types {
        let Some(value) = diagnostics.accept(embedding(ty)) else { continue };
        if embeddings.iter().any(|(known, _)| known.value == value) {
            diagnostics.report(messages::duplicate_embedding(ty, &value));
        } else {
            embeddings.push((Located { value, extent: Extent::of(ty) }, ty.clone()));
        }
    }
    embeddings
}

/// A scheme, wrapped or not.
fn embedding(ty: &Type) -> syn::Result<Embedding> {
    let (name, arguments) = parts(ty)?;
    match (name.to_string().as_str(), arguments.as_deref()) {
        ("Gauss", Some([stages])) => gauss(ty, stages),
        ("Gauss", _) => Err(messages::scheme_arguments(ty, "Gauss<4>")),
        ("Thermostat", Some([GenericArgument::Type(inner)])) => thermostat(inner),
        ("Thermostat", _) => Err(messages::scheme_arguments(ty, "Thermostat<Midpoint>")),
        ("Baoab", None) => Ok(Embedding::Baoab),
        ("Obabo", None) => Ok(Embedding::Obabo),
        ("Gjf", None) => Ok(Embedding::Gjf),
        ("GjI", None) => Ok(Embedding::GjI),
        (plain @ ("Baoab" | "Obabo" | "Gjf" | "GjI"), Some(_)) => Err(messages::scheme_arguments(ty, plain)),
        ("Verlet", None) => Ok(Embedding::Verlet),
        ("Verlet", Some(_)) => Err(messages::scheme_arguments(ty, "Verlet")),
        ("Composed", Some([GenericArgument::Type(base), _])) => Err(messages::composed(ty, base)),
        ("Corrected", Some([inner])) => Ok(Embedding::Corrected(Box::new(unwrapped(inner)?))),
        ("Uncorrected", Some([inner])) => Ok(Embedding::Uncorrected(Box::new(unwrapped(inner)?))),
        ("Corrected" | "Uncorrected", _) => Err(messages::scheme_arguments(ty, "Corrected<Midpoint>")),
        (_, arguments) => bare(ty, name, arguments),
    }
}

/// `Thermostat<E>`
fn thermostat(inner: &Type) -> syn::Result<Embedding> {
    match embedding(inner)? {
        inside if inside.is_thermostat() => Err(messages::thermostat_inside(inner)),
        inside => Ok(Embedding::Thermostat(Box::new(inside))),
    }
}

/// `Gauss<S>`
fn gauss(ty: &Type, stages: &GenericArgument) -> syn::Result<Embedding> {
    match lambda_argument(stages)? {
        stages @ 1..=16 => Ok(Embedding::Gauss(stages)),
        _ => Err(messages::gauss_stages(ty)),
    }
}

/// A scheme inside `Corrected` or `Uncorrected`.
fn unwrapped(argument: &GenericArgument) -> syn::Result<Embedding> {
    let GenericArgument::Type(ty) = argument else { return Err(messages::not_a_scheme(argument)) };
    let (name, arguments) = parts(ty)?;
    if name == "Corrected" || name == "Uncorrected" {
        return Err(messages::wrapper_inside(ty));
    }
    bare(ty, name, arguments.as_deref())
}

/// A scheme that is not wrapped.
fn bare(ty: &Type, name: &syn::Ident, arguments: Option<&[&GenericArgument]>) -> syn::Result<Embedding> {
    match (name.to_string().as_str(), arguments) {
        ("Mixed", Some([drift, noise])) => {
            Ok(Embedding::Mixed(Box::new(simple(drift)?), Box::new(simple(noise)?)))
        }
        ("Mixed", _) => Err(messages::scheme_arguments(ty, "Mixed<Midpoint, DeltaPlus>")),
        _ => point(ty, name, arguments),
    }
}

/// A scheme inside `Mixed`.
fn simple(argument: &GenericArgument) -> syn::Result<Embedding> {
    let GenericArgument::Type(ty) = argument else { return Err(messages::not_a_scheme(argument)) };
    let (name, arguments) = parts(ty)?;
    if name == "Corrected" || name == "Uncorrected" {
        return Err(messages::wrapper_inside(ty));
    }
    if name == "Mixed" {
        return Err(messages::mixed_inside_mixed(ty));
    }
    point(ty, name, arguments.as_deref())
}

/// A scheme with one quadrature point.
fn point(ty: &Type, name: &syn::Ident, arguments: Option<&[&GenericArgument]>) -> syn::Result<Embedding> {
    match (name.to_string().as_str(), arguments) {
        ("DeltaPlus", None) => Ok(Embedding::DeltaPlus),
        ("Midpoint", None) => Ok(Embedding::Midpoint),
        ("DeltaMinus", None) => Ok(Embedding::DeltaMinus),
        (plain @ ("DeltaPlus" | "Midpoint" | "DeltaMinus"), Some(_)) => {
            Err(messages::scheme_arguments(ty, plain))
        }
        ("Lambda", Some([n, d])) => {
            let (n, d) = (lambda_argument(n)?, lambda_argument(d)?);
            if d == 0 || n > d { Err(messages::lambda_range(ty)) } else { Ok(Embedding::Lambda(n, d)) }
        }
        ("Lambda", _) => Err(messages::scheme_arguments(ty, "Lambda<1, 3>")),
        _ => Err(messages::unknown_embedding(name)),
    }
}

fn lambda_argument(argument: &GenericArgument) -> syn::Result<u32> {
    syn::parse2::<syn::LitInt>(argument.to_token_stream())
        .ok()
        .and_then(|literal| literal.base10_parse().ok())
        .ok_or_else(|| messages::lambda_literal(argument))
}

/// The last segment's name and generic arguments.
fn parts(ty: &Type) -> syn::Result<(&syn::Ident, Option<Vec<&GenericArgument>>)> {
    let segment = match ty {
        Type::Path(path) if path.qself.is_none() => path.path.segments.last(),
        Type::Group(group) => return parts(&group.elem),
        _ => None,
    };
    let segment = segment.ok_or_else(|| messages::not_a_scheme(ty))?;
    match &segment.arguments {
        PathArguments::None => Ok((&segment.ident, None)),
        PathArguments::AngleBracketed(arguments) => {
            Ok((&segment.ident, Some(arguments.args.iter().collect())))
        }
        PathArguments::Parenthesized(_) => Err(messages::not_a_scheme(ty)),
    }
}
