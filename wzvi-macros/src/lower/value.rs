//! What an expression can stand for while it is interpreted.

use std::rc::Rc;

use proc_macro2::TokenStream;
use quote::quote;

use super::streams::{Array, Stream};
use crate::input::Kind;
use crate::model::index::Index;
use crate::symbolic::Expr;

/// The value of an expression. Cheap to copy.
#[derive(Clone)]
pub(super) enum Value {
    /// A real number, symbolically.
    Real(Expr),
    /// An integer that is known.
    Integer(i128),
    /// Part of the struct, or a constant, that is no real number (yet).
    Place(Rc<Place>),
    /// A condition that is known.
    Known(bool),
    /// A condition that depends on the state or on parameters.
    Condition(Expr),
    /// An array, slice or `Vec`.
    List(Sequence),
    Tuple(Sequence),
    /// What is left of an iterator.
    Iterator(Sequence),
    /// `start..end`; without an end it only bounds others.
    Range(i128, Option<i128>),
    /// An integer of loop variables and sizes: only in systems of elements, like the next two.
    Index(Rc<Index>),
    /// Part of the phase space, or of a list of the struct, whose elements are known to the running program only.
    Array(Rc<Array>),
    /// What is left of an iterator whose length is known to the running program only.
    Stream(Rc<Stream>),
    /// Position in the interpreter's list of closures.
    Closure(usize),
    /// `f64::sin` and the like, as a value.
    Function(Rc<str>),
    /// The value of something that was reported: whatever is made of it is not reported again.
    Poison,
}

/// Values in order.
#[derive(Clone)]
pub(super) struct Sequence {
    pub(super) items: Rc<[Value]>,
    /// Levels of sequences inside this one, itself included: bounded, because dropping recurses.
    pub(super) depth: u32,
}

impl Sequence {
    pub(super) fn new(items: Vec<Value>) -> Self {
        let depth = items.iter().map(Value::depth).max().unwrap_or(0) + 1;
        Self { items: items.into(), depth }
    }
}

/// Something that the generated code reads from the struct or its surroundings.
pub(super) struct Place {
    /// As it is displayed: `masses[2]`.
    pub(super) name: String,
    /// As it is read: `self.masses[2]`.
    pub(super) tokens: TokenStream,
    pub(super) kind: Kind,
    /// Whether it is an element of a list whose length only the running program knows: the tokens are then a reference
    /// in a chain of `?`.
    pub(super) is_checked: bool,
}

impl Place {
    pub(super) fn new(name: String, tokens: TokenStream, kind: Kind) -> Self {
        Self { name, tokens, kind, is_checked: false }
    }

    /// The number as it is read.
    pub(super) fn value(&self) -> TokenStream {
        let tokens = &self.tokens;
        if self.is_checked { or_nan(&quote! { *#tokens }) } else { tokens.clone() }
    }

    /// The number as an `f64`.
    pub(super) fn as_real(&self) -> TokenStream {
        let tokens = &self.tokens;
        if self.is_checked {
            or_nan(&quote! { *#tokens as ::core::primitive::f64 })
        } else {
            quote! { (#tokens as ::core::primitive::f64) }
        }
    }
}

/// An element that is not there is not a number, which the making of a stepper reports.
fn or_nan(tokens: &TokenStream) -> TokenStream {
    quote! { (|| ::core::option::Option::Some(#tokens))().unwrap_or(::core::primitive::f64::NAN) }
}

impl Value {
    pub(super) fn unit() -> Self {
        Self::Tuple(Sequence::new(Vec::new()))
    }

    pub(super) fn list(items: Vec<Value>) -> Self {
        Self::List(Sequence::new(items))
    }

    pub(super) fn tuple(items: Vec<Value>) -> Self {
        Self::Tuple(Sequence::new(items))
    }

    pub(super) fn iterator(items: Vec<Value>) -> Self {
        Self::Iterator(Sequence::new(items))
    }

    pub(super) fn is_poison(&self) -> bool {
        matches!(self, Self::Poison)
    }

    pub(super) fn is_integer(&self) -> bool {
        match self {
            Self::Integer(_) | Self::Index(_) => true,
            Self::Place(place) => place.kind == Kind::Integer,
            _ => false,
        }
    }

    fn depth(&self) -> u32 {
        match self {
            Self::List(sequence) | Self::Tuple(sequence) | Self::Iterator(sequence) => sequence.depth,
            _ => 0,
        }
    }

    /// With its article, for messages.
    pub(super) fn describe(&self) -> &'static str {
        match self {
            Self::Real(_) => "a real number",
            Self::Integer(_) => "an integer",
            Self::Place(place) => match place.kind {
                Kind::Integer => "an integer that is not known at compile time",
                Kind::List(..) => "a list",
                _ => "a constant",
            },
            Self::Known(_) | Self::Condition(_) => "a condition",
            Self::List(_) => "a list",
            Self::Tuple(sequence) if sequence.items.is_empty() => "`()`",
            Self::Tuple(_) => "a tuple",
            Self::Iterator(_) => "an iterator",
            Self::Range(..) => "a range",
            Self::Index(_) => "an integer that is known at run time",
            Self::Array(_) => "a list",
            Self::Stream(_) => "an iterator whose length is known at run time",
            Self::Closure(_) | Self::Function(_) => "a function",
            Self::Poison => "an error",
        }
    }
}
