//! The values of expressions during interpretation. Tests: `lower/tests/values.rs`.

use std::rc::Rc;

use proc_macro2::TokenStream;
use quote::{ToTokens, quote};
use syn::BinOp;

use super::sequences::Sequence;
use crate::input::FieldKind;
use crate::model::Index;
use crate::symbolic::Expr;

/// The longest name of arithmetic of constants: an expression of more is one of real numbers.
const LONGEST_NAME: usize = 256;

/// The value of an expression. Cheap to copy.
#[derive(Clone, Default)]
pub(super) enum Value {
    /// A real number, symbolically.
    Real(Expr),
    /// An integer, known or an expression of loop variables, sizes and integers of the struct, and whether
    /// its type is known to be unsigned.
    Index(Rc<Index>, bool),
    /// A constant, whose type only `rustc` knows.
    Constant(Rc<Place>),
    /// A condition that is known.
    Known(bool),
    /// A condition that depends on the state or on parameters.
    Condition(Expr),
    Tuple(Items),
    /// A list, a range, or an iterator.
    Sequence(Rc<Sequence>),
    /// Position in the interpreter's list of closures.
    Closure(usize),
    /// `f64::sin` and the like, as a value.
    Function(Rc<str>),
    /// A value with a reported mistake: values computed from it are not reported again.
    #[default]
    Poison,
}

/// Values in order.
#[derive(Clone)]
pub(super) struct Items {
    pub(super) items: Rc<[Value]>,
    /// Levels of sequences inside this one, itself included: bounded, because dropping recurses.
    pub(super) depth: u32,
}

impl Items {
    pub(super) fn new(items: Vec<Value>) -> Self {
        let depth = items.iter().map(Value::depth).max().unwrap_or(0) + 1;
        Self { items: items.into(), depth }
    }
}

/// A field, a constant, or arithmetic of both: the generated code reads it.
pub(super) struct Place {
    /// The displayed name: `masses[2]`.
    pub(super) name: String,
    /// The tokens that read it: `self.masses[2]`.
    pub(super) tokens: TokenStream,
    pub(super) kind: FieldKind,
    /// The operands of arithmetic of constants; a sign has no left one.
    pub(super) made_of: Option<(Option<Rc<Place>>, BinOp, Rc<Place>)>,
}

impl Place {
    pub(super) fn new(name: String, tokens: TokenStream, kind: FieldKind) -> Self {
        Self { name, tokens, kind, made_of: None }
    }

    /// The number as an `f64`.
    pub(super) fn as_real(&self) -> TokenStream {
        let tokens = &self.tokens;
        quote! { (#tokens as ::core::primitive::f64) }
    }
}

impl Value {
    pub(super) fn unit() -> Self {
        Self::tuple(Vec::new())
    }

    pub(super) fn list(items: Vec<Value>) -> Self {
        Self::sequence(Sequence::known(items))
    }

    pub(super) fn tuple(items: Vec<Value>) -> Self {
        Self::Tuple(Items::new(items))
    }

    pub(super) fn sequence(sequence: Sequence) -> Self {
        Self::Sequence(sequence.into())
    }

    pub(super) fn index(index: Index) -> Self {
        Self::Index(index.into(), false)
    }

    /// The value, with whether the type of an integer is unsigned.
    pub(super) fn unsigned(self, is_unsigned: bool) -> Self {
        match self {
            Self::Index(index, _) => Self::Index(index, is_unsigned),
            other => other,
        }
    }

    pub(super) fn integer(value: i128) -> Self {
        Self::index(Index::integer(value))
    }

    /// Arithmetic of constants: a constant, whose type only `rustc` knows either. `None` for other values.
    pub(super) fn operation(a: Option<&Self>, operator: &BinOp, b: &Self) -> Option<Self> {
        let (left, right) = match (a, b) {
            (None, Self::Constant(b)) => (None, b),
            (Some(Self::Constant(a)), Self::Constant(b)) => (Some(a.clone()), b),
            _ => return None,
        };
        let (name, tokens) = left.as_ref().map(|a| (format!("{} ", a.name), &a.tokens)).unzip();
        let name = format!("({}{} {})", name.unwrap_or_default(), operator.to_token_stream(), right.name);
        let read = &right.tokens;
        let is_short = name.len() <= LONGEST_NAME;
        let mut place = Place::new(name, quote! { (#tokens #operator #read) }, FieldKind::Constant);
        place.made_of = Some((left, *operator, right.clone()));
        is_short.then(|| Self::Constant(place.into()))
    }

    pub(super) fn is_poison(&self) -> bool {
        matches!(self, Self::Poison)
    }

    /// The value, unless it is poison.
    pub(super) fn known(self) -> Option<Self> {
        Some(self).filter(|value| !value.is_poison())
    }

    pub(super) fn as_real(&self) -> Option<Expr> {
        match self {
            Self::Real(value) => Some(*value),
            _ => None,
        }
    }

    pub(super) fn is_integer(&self) -> bool {
        matches!(self, Self::Index(..))
    }

    pub(super) fn depth(&self) -> u32 {
        match self {
            Self::Tuple(items) => items.depth,
            Self::Sequence(sequence) => sequence.depth.max(sequence.length.as_ref().map_or(0, Index::depth)),
            Self::Index(index, _) => index.depth(),
            _ => 0,
        }
    }

    /// The number of integers in the expression of an integer or a length.
    pub(super) fn atoms(&self) -> usize {
        match self {
            Self::Index(index, _) => index.atoms(),
            Self::Sequence(sequence) => sequence.length.as_ref().map_or(0, Index::atoms),
            _ => 0,
        }
    }

    /// The kind of the value with its article, for messages.
    pub(super) fn describe(&self) -> &'static str {
        match self {
            Self::Real(_) => "a real number",
            Self::Index(index, _) => match index.as_integer() {
                Some(_) => "an integer",
                None => "an integer that is known at run time",
            },
            Self::Constant(_) => "a constant",
            Self::Known(_) | Self::Condition(_) => "a condition",
            Self::Tuple(tuple) if tuple.items.is_empty() => "`()`",
            Self::Tuple(_) => "a tuple",
            Self::Sequence(sequence) => sequence.describe(),
            Self::Closure(_) | Self::Function(_) => "a function",
            Self::Poison => "an error",
        }
    }
}
