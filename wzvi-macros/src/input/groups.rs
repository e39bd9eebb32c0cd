//! Invisible groups, in which `macro_rules!` passes its fragments: a group of one token equals that token.
//! Tests: `tests/accepted/macros.rs`.

use proc_macro2::{Delimiter, TokenStream, TokenTree};
use syn::Expr;

use crate::tokens::regrouped;

/// The tokens with every such group of one token replaced by the token. Longer groups keep expressions
/// together.
pub(super) fn without_single(tokens: TokenStream) -> TokenStream {
    tokens.into_iter().map(open).collect()
}

fn open(token: TokenTree) -> TokenTree {
    let TokenTree::Group(group) = token else { return token };
    let content = without_single(group.stream());
    if group.delimiter() == Delimiter::None {
        let mut tokens = content.clone().into_iter();
        if let (Some(only), None) = (tokens.next(), tokens.next()) {
            return only;
        }
    }
    regrouped(&group, content)
}

/// The expression inside of parentheses and groups.
pub(crate) fn peeled(mut expr: &Expr) -> &Expr {
    loop {
        expr = match expr {
            Expr::Group(inner) => &inner.expr,
            Expr::Paren(inner) => &inner.expr,
            other => return other,
        };
    }
}
