//! Lists and integers of the struct or of constants.

use std::collections::HashMap;

use proc_macro2::TokenStream;
use quote::{ToTokens, quote};

use crate::diagnostics::source;
use crate::model::{Atom, Index, Table};

/// One table per distinct expression.
#[derive(Default)]
pub(super) struct Tables {
    list: Vec<Table>,
    known: HashMap<String, u32>,
}

impl Tables {
    pub(super) fn as_list(&self) -> &[Table] {
        &self.list
    }

    pub(super) fn into_list(self) -> Vec<Table> {
        self.list
    }

    /// The value read by `tokens`.
    pub(super) fn add(
        &mut self,
        name: &str,
        tokens: &TokenStream,
        is_unsigned: bool,
        lengths: Vec<Option<usize>>,
    ) -> u32 {
        let (name, suffix) = (name.to_owned(), TokenStream::new());
        self.once(tokens.to_string(), Table { name, tokens: tokens.clone(), suffix, is_unsigned, lengths })
    }

    /// The number of the table with this key.
    fn once(&mut self, key: String, table: Table) -> u32 {
        let list = &mut self.list;
        *self.known.entry(key).or_insert_with(|| {
            list.push(table);
            (list.len() - 1) as u32
        })
    }

    /// A size of the phase space or of a family, as it was written.
    pub(super) fn size(&mut self, expr: &syn::Expr) -> Index {
        let name = source(expr).replace(" . ", ".");
        self.named_size(name.strip_prefix("self.").unwrap_or(&name), &expr.to_token_stream())
    }

    /// A nonnegative integer displayed as `name`.
    pub(super) fn named_size(&mut self, name: &str, tokens: &TokenStream) -> Index {
        Index::atom(Atom::Given(self.add(name, tokens, true, Vec::new()), Vec::new()))
    }

    /// The integer that `suffix` reads of the entries of a list.
    pub(super) fn part(&mut self, id: u32, suffix: TokenStream, is_unsigned: bool) -> u32 {
        let Some(list) = self.list.get(id as usize).cloned() else { return id };
        let name = format!("{}{suffix}", list.name).replace(' ', "");
        let key = format!("{} [..] {suffix}", list.tokens);
        self.once(key, Table { name, suffix, is_unsigned, ..list })
    }

    pub(super) fn name(&self, id: u32) -> String {
        self.list.get(id as usize).map_or_else(String::new, |table| table.name.clone())
    }

    /// The name of an integer, and how it is read as an `f64`.
    pub(super) fn integer(&self, id: u32) -> Option<(String, TokenStream)> {
        let Table { name, tokens, .. } = self.list.get(id as usize)?;
        Some((name.clone(), quote! { (#tokens as ::core::primitive::f64) }))
    }
}
