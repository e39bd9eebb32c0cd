//! The struct, with its fields by their use in Hamiltonians. Tests: `tests/accepted/parameters.rs`.

use std::rc::Rc;

use proc_macro2::TokenStream;
use quote::ToTokens;
use syn::{GenericArgument, GenericParam, Item, ItemStruct, Member, PathArguments, Type};

use super::{attributes, nesting};
use crate::diagnostics::{Diagnostics, messages, source};

/// A struct that can carry a Hamiltonian system.
pub(crate) struct Container {
    pub(crate) item: ItemStruct,
    pub(crate) fields: Vec<Field>,
    /// Const generics of an unsigned type.
    pub(crate) sizes: Vec<syn::Ident>,
}

pub(crate) struct Field {
    pub(crate) member: Member,
    pub(crate) kind: FieldKind,
    /// `#[cfg]` attributes: the field may not be there.
    pub(crate) conditions: Vec<syn::Attribute>,
}

impl Field {
    /// Whether a Hamiltonian can read it.
    pub(crate) fn is_readable(&self) -> bool {
        !matches!(self.kind, FieldKind::Other(_) | FieldKind::Tuple(..))
    }
}

/// The kind of a field, or of an element of one.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) enum FieldKind {
    Real,
    /// Whether its type is unsigned.
    Integer(bool),
    /// An array, slice or `Vec`; its length where it is a literal.
    List(Rc<FieldKind>, Option<usize>),
    /// A tuple of numbers as an element of a list, with its type as written.
    Tuple(Rc<[FieldKind]>, String),
    /// A path to a constant, whose type only `rustc` knows.
    Constant,
    /// A type that no Hamiltonian can use, as written.
    Other(String),
}

/// Reads the struct that carries the attribute.
pub(crate) fn read_struct(item: TokenStream, diagnostics: &mut Diagnostics) -> Option<Container> {
    nesting::check(&item, diagnostics)?;
    let item = match diagnostics.accept(syn::parse2::<Item>(item))? {
        Item::Struct(item) => item,
        other => {
            diagnostics.report(messages::not_a_struct(&other));
            return None;
        }
    };
    let fields = item.fields.members().zip(&item.fields).map(|(member, field)| {
        let conditions = field.attrs.iter().filter(|attribute| attribute.path().is_ident("cfg"));
        Field { member, kind: kind(&field.ty), conditions: conditions.cloned().collect() }
    });
    let fields: Vec<Field> = fields.collect();
    attributes::check_struct(&item, &fields, diagnostics);
    let sizes = item.generics.params.iter().filter_map(|parameter| match parameter {
        GenericParam::Const(parameter) if kind(&parameter.ty) == FieldKind::Integer(true) => {
            Some(parameter.ident.clone())
        }
        _ => None,
    });
    Some(Container { fields, sizes: sizes.collect(), item })
}

fn kind(ty: &Type) -> FieldKind {
    match ty {
        Type::Paren(inner) => kind(&inner.elem),
        Type::Group(inner) => kind(&inner.elem),
        Type::Array(array) => FieldKind::List(Rc::new(kind(&array.elem)), literal(&array.len)),
        Type::Slice(slice) => FieldKind::List(Rc::new(kind(&slice.elem)), None),
        Type::Tuple(tuple) => {
            let kinds: Vec<FieldKind> = tuple.elems.iter().map(kind).collect();
            match kinds.iter().all(|kind| matches!(kind, FieldKind::Real | FieldKind::Integer(_))) {
                true => FieldKind::Tuple(kinds.into(), source(ty)),
                false => other(ty),
            }
        }
        Type::Reference(reference) => list_or_other(kind(&reference.elem), ty),
        Type::Path(path) if path.qself.is_none() => match path.path.segments.last() {
            Some(segment) => named_kind(segment, ty),
            None => other(ty),
        },
        _ => other(ty),
    }
}

fn named_kind(segment: &syn::PathSegment, ty: &Type) -> FieldKind {
    let argument = match &segment.arguments {
        PathArguments::AngleBracketed(arguments) => arguments.args.first(),
        _ => None,
    };
    match (segment.ident.to_string().as_str(), argument) {
        ("f64", None) => FieldKind::Real,
        (name, None) if is_integer_type(name) => FieldKind::Integer(name.starts_with('u')),
        ("Vec", Some(GenericArgument::Type(element))) => FieldKind::List(Rc::new(kind(element)), None),
        ("Box" | "Rc" | "Arc", Some(GenericArgument::Type(inner))) => list_or_other(kind(inner), ty),
        _ => other(ty),
    }
}

/// Lists behind pointers index like lists; numbers behind pointers do not read like numbers.
fn list_or_other(kind: FieldKind, ty: &Type) -> FieldKind {
    match kind {
        FieldKind::List(..) => kind,
        _ => other(ty),
    }
}

fn other(ty: &Type) -> FieldKind {
    FieldKind::Other(source(ty))
}

pub(crate) fn is_integer_type(name: &str) -> bool {
    let digits = name.strip_prefix(['i', 'u']);
    digits.is_some_and(|digits| ["8", "16", "32", "64", "128", "size"].contains(&digits))
}

/// The value of an integer literal.
pub(super) fn literal(tokens: &impl ToTokens) -> Option<usize> {
    syn::parse2::<syn::LitInt>(tokens.to_token_stream()).ok()?.base10_parse().ok()
}
