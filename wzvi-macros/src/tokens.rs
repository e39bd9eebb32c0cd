//! Token streams: the words in them, streams like others, and syntax that is compared by its text.

use std::fmt;

use proc_macro2::{Group, Ident, TokenStream, TokenTree};
use quote::ToTokens;

/// Syntax of the user that equals other syntax of the same text. The feature of syn that compares its types
/// would take longer to compile.
#[derive(Clone)]
pub(crate) struct Written<T>(pub(crate) T);

impl<T: ToTokens> PartialEq for Written<T> {
    fn eq(&self, other: &Self) -> bool {
        self.0.to_token_stream().to_string() == other.0.to_token_stream().to_string()
    }
}

impl<T: ToTokens> Eq for Written<T> {}

impl<T: ToTokens> fmt::Debug for Written<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.0.to_token_stream())
    }
}

impl<T: ToTokens> ToTokens for Written<T> {
    fn to_tokens(&self, tokens: &mut TokenStream) {
        self.0.to_tokens(tokens);
    }
}

/// Whether any identifier, in groups or not, is one of the given ones.
pub(crate) fn any_word(tokens: TokenStream, is_wanted: &mut dyn FnMut(&Ident) -> bool) -> bool {
    tokens.into_iter().any(|token| match token {
        TokenTree::Ident(word) => is_wanted(&word),
        TokenTree::Group(group) => any_word(group.stream(), is_wanted),
        _ => false,
    })
}

/// Whether `name` occurs.
pub(crate) fn mentions(tokens: &TokenStream, name: &str) -> bool {
    any_word(tokens.clone(), &mut |word| word == name)
}

/// All identifiers, in their order.
pub(crate) fn words(tokens: TokenStream) -> Vec<Ident> {
    let mut words = Vec::new();
    any_word(tokens, &mut |word| {
        words.push(word.clone());
        false
    });
    words
}

/// The tokens, with each token that is not a group replaced by others.
pub(crate) fn replaced(tokens: TokenStream, by: &dyn Fn(TokenTree) -> TokenStream) -> TokenStream {
    let token = |token| match token {
        TokenTree::Group(group) => regrouped(&group, replaced(group.stream(), by)).into(),
        other => by(other),
    };
    tokens.into_iter().map(token).collect()
}

/// A group like another, with other contents.
pub(crate) fn regrouped(like: &Group, content: TokenStream) -> TokenTree {
    let mut group = Group::new(like.delimiter(), content);
    group.set_span(like.span());
    group.into()
}

pub(crate) fn is_punct(token: &TokenTree, expected: char) -> bool {
    matches!(token, TokenTree::Punct(punct) if punct.as_char() == expected)
}
