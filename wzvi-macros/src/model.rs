//! What the front end hands to the discretisation: the user's Hamiltonians as symbolic expressions.

use proc_macro2::{Ident, Span, TokenStream, TokenTree};
use quote::ToTokens;

use crate::discretise::embedding::Embedding;
use crate::symbolic::{Expr, Graph, Symbol};

/// The phase space: one symbol per coordinate and momentum, in the order of the state vector, and time.
pub(crate) struct Phase {
    pub(crate) q: Vec<Symbol>,
    pub(crate) p: Vec<Symbol>,
    pub(crate) t: Symbol,
}

/// A real number that a step reads from the struct or its surroundings.
pub(crate) struct Parameter {
    pub(crate) symbol: Symbol,
    /// An `f64` expression in which `self` is a reference to the struct.
    pub(crate) tokens: TokenStream,
}

/// A symbolic expression with the place where the user wrote it.
#[derive(Clone, Copy)]
pub(crate) struct Located<T> {
    pub(crate) value: T,
    pub(crate) extent: Extent,
}

/// From the first to the last token: stable `rustc` joins no spans.
#[derive(Clone, Copy)]
pub(crate) struct Extent {
    first: Span,
    last: Span,
}

impl Extent {
    pub(crate) fn of(tokens: &impl ToTokens) -> Self {
        let mut tokens = tokens.to_token_stream().into_iter();
        let first = tokens.next().map_or_else(Span::call_site, |token| token.span());
        Self { first, last: tokens.last().map_or(first, |token| token.span()) }
    }
}

/// Two tokens that an error message can span.
impl ToTokens for Extent {
    fn to_tokens(&self, tokens: &mut TokenStream) {
        tokens.extend([self.first, self.last].map(|span| TokenTree::from(Ident::new("_", span))));
    }
}

/// Everything that was declared, lowered.
pub(crate) struct Model {
    pub(crate) graph: Graph,
    pub(crate) phase: Phase,
    pub(crate) parameters: Vec<Parameter>,
    pub(crate) drift: Located<Expr>,
    pub(crate) noise: Vec<Located<Expr>>,
    pub(crate) invariants: Vec<Located<Expr>>,
    pub(crate) embeddings: Vec<Located<Embedding>>,
    /// The struct: attributes, visibility, name, generics and fields, to be emitted unchanged.
    pub(crate) item: syn::ItemStruct,
    /// Path of the facade crate as the user's crate knows it, `::wzvi` by default.
    pub(crate) crate_path: syn::Path,
    /// Functions that repeat the user's closures for `rustc` to type-check at the user's spans; never called.
    pub(crate) type_checks: TokenStream,
}
