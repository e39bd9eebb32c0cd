//! Lists and integers of the struct or of constants. Tests: `tests/accepted/fields.rs`.

use proc_macro2::TokenStream;
use quote::{ToTokens, quote};

use crate::diagnostics::source;
use crate::distinct::Distinct;
use crate::model::{Atom, Index, Table};

/// One table per distinct expression.
#[derive(Default)]
pub(super) struct Tables(Distinct<String, Table>);

impl Tables {
    pub(super) fn as_list(&self) -> &[Table] {
        &self.0.values
    }

    pub(super) fn into_list(self) -> Vec<Table> {
        self.0.values
    }

    /// The number of the table that `tokens` read.
    pub(super) fn add(
        &mut self,
        name: &str,
        tokens: &TokenStream,
        is_unsigned: bool,
        lengths: Vec<Option<usize>>,
    ) -> u32 {
        let (name, suffix) = (name.to_owned(), TokenStream::new());
        let table =
            || Table { name, tokens: tokens.clone(), suffix, is_unsigned, is_nonzero: false, lengths };
        self.0.place(tokens.to_string(), table) as u32
    }

    /// A size of the phase space or of a family, as it was written.
    pub(super) fn size(&mut self, expr: &syn::Expr) -> Index {
        let name = source(expr).replace(" . ", ".");
        // The tokens are cast, and a cast binds more tightly than an operator.
        let tokens = match expr {
            syn::Expr::Binary(_) | syn::Expr::Unary(_) => quote!((#expr)),
            _ => expr.to_token_stream(),
        };
        let name = name.strip_prefix("self.").unwrap_or(&name);
        Index::atom(Atom::Given(self.add(name, &tokens, true, Vec::new()), Vec::new()))
    }

    /// The number of the table of integers that `suffix` reads from the entries of a list.
    pub(super) fn suffixed(&mut self, id: u32, suffix: TokenStream, is_unsigned: bool) -> u32 {
        let Some(list) = self.0.values.get(id as usize).cloned() else { return id };
        let name = format!("{}{suffix}", list.name).replace(' ', "");
        let key = format!("{} [..] {suffix}", list.tokens);
        self.0.place(key, || Table { name, suffix, is_unsigned, ..list }) as u32
    }

    pub(super) fn name(&self, id: u32) -> String {
        self.0.values.get(id as usize).map_or_else(String::new, |table| table.name.clone())
    }

    /// The name of an integer, and how it is read as an `f64`.
    pub(super) fn integer(&self, id: u32) -> Option<(String, TokenStream)> {
        let Table { name, tokens, .. } = self.0.values.get(id as usize)?;
        Some((name.clone(), quote! { (#tokens as ::core::primitive::f64) }))
    }
}
