//! Integer expressions as Rust: `isize` arithmetic, checked in advance by `emit::terms::places` or during
//! evaluation.

use proc_macro2::{Ident, Literal, TokenStream};
use quote::{format_ident, quote};

use crate::model::{Atom, Index, IndexOperation, Table};

/// The variable of a loop.
pub(crate) fn variable(id: u32) -> Ident {
    format_ident!("__i{id}")
}

/// A part of a list bound to a name, with the expression of the list and the index of the first entry.
pub(crate) struct OpenList {
    pub(crate) tokens: TokenStream,
    pub(crate) first: Index,
    pub(crate) name: Ident,
}

/// Prints indices. `checked` ones occur in a function that returns an `Option`.
#[derive(Clone, Copy)]
pub(crate) struct Indices<'a> {
    pub(crate) tables: &'a [Table],
    pub(crate) checked: bool,
    /// Parts of lists whose entry at `__lane` is read.
    pub(crate) lists: &'a [OpenList],
}

impl<'a> Indices<'a> {
    pub(crate) fn unchecked(tables: &'a [Table]) -> Self {
        Self { tables, checked: false, lists: &[] }
    }
}

impl Indices<'_> {
    /// The index as an `isize`, for any place in an expression.
    pub(crate) fn value(&self, index: &Index) -> TokenStream {
        let sum = self.sum(index);
        let is_atom = match (index.terms.as_slice(), index.constant) {
            ([], constant) => constant >= 0,
            ([(atom, coefficient)], 0) => *coefficient == 1 && !matches!(atom, Atom::Given(..)),
            _ => false,
        };
        if is_atom { sum } else { quote!((#sum)) }
    }

    /// The index as an `isize`, as a complete expression.
    pub(crate) fn sum(&self, index: &Index) -> TokenStream {
        if let Some(entry) = self.given(index) {
            return quote!(#entry as __wzvi::isize);
        }
        let mut sum: Option<TokenStream> = None;
        for (atom, coefficient) in &index.terms {
            let atom = self.atom(atom);
            let size = Literal::i128_unsuffixed(coefficient.unsigned_abs().cast_signed());
            let product = if coefficient.unsigned_abs() == 1 { atom } else { quote!(#size * #atom) };
            sum = Some(match (sum, *coefficient < 0) {
                (None, false) => product,
                (None, true) => quote!(-(#product)),
                (Some(sum), false) => quote!(#sum + #product),
                (Some(sum), true) => quote!(#sum - #product),
            });
        }
        let size = Literal::i128_unsuffixed(index.constant.unsigned_abs().cast_signed());
        match (sum, index.constant) {
            (None, constant) if constant < 0 => quote!(-#size),
            (None, _) => quote!(#size),
            (Some(sum), 0) => sum,
            (Some(sum), constant) if constant < 0 => quote!(#sum - #size),
            (Some(sum), _) => quote!(#sum + #size),
        }
    }

    /// The index as an entry of a table.
    fn given(&self, index: &Index) -> Option<TokenStream> {
        match (index.terms.as_slice(), index.constant) {
            ([(Atom::Given(table, indices), 1)], 0) => Some(self.entry(*table, indices)),
            _ => None,
        }
    }

    /// The index as a `usize`: an operand of sums and ranges.
    pub(crate) fn position(&self, index: &Index) -> TokenStream {
        if let Some(known) = index.as_integer().and_then(|known| usize::try_from(known).ok()) {
            let known = match self.checked {
                true => Literal::usize_suffixed(known),
                false => Literal::usize_unsuffixed(known),
            };
            return quote!(#known);
        }
        if let (Some(entry), false) = (self.given(index), self.checked) {
            return quote!(#entry as __wzvi::usize);
        }
        let value = self.value(index);
        // Literals alone have no type.
        let typed = if index.terms.is_empty() { quote!(#value as __wzvi::isize) } else { value };
        if self.checked {
            quote!(__wzvi::TryInto::<__wzvi::usize>::try_into(#typed).ok()?)
        } else {
            quote!(#typed as __wzvi::usize)
        }
    }

    /// The expression of the list `table` at `indices`.
    pub(crate) fn entry(&self, table: u32, indices: &[Index]) -> TokenStream {
        let tokens = self.list(table, indices);
        if let Some(table) = self.tables.get(table as usize).filter(|table| !table.suffix.is_empty()) {
            let suffix = &table.suffix;
            return quote!(#tokens #suffix);
        }
        if self.checked && !indices.is_empty() { quote!((*#tokens)) } else { tokens }
    }

    /// The expression of the list `table` at `indices`, without the suffix of the table.
    pub(crate) fn list(&self, table: u32, indices: &[Index]) -> TokenStream {
        let known = self.tables.get(table as usize);
        let mut tokens = known.map_or_else(TokenStream::new, |table| table.tokens.clone());
        for index in indices {
            if let Some(name) = self.open_list(&tokens, index) {
                tokens = quote!(#name[__lane]);
                continue;
            }
            let position = self.position(index);
            tokens = if self.checked { quote!(#tokens.get(#position)?) } else { quote!(#tokens[#position]) };
        }
        tokens
    }

    fn open_list(&self, tokens: &TokenStream, index: &Index) -> Option<&Ident> {
        let mut same = self.lists.iter().filter(|list| list.first == *index);
        same.find(|list| list.tokens.to_string() == tokens.to_string()).map(|list| &list.name)
    }

    /// An entry at known indices as an `f64`; NaN if it does not exist, which is reported when a stepper is
    /// made.
    pub(crate) fn constant_entry(&self, table: u32, indices: &[Index]) -> TokenStream {
        let lengths = self.tables.get(table as usize).map_or(&[][..], |table| &table.lengths);
        let is_there = |(dimension, index): (usize, &Index)| {
            let length = lengths.get(dimension).copied().flatten()?;
            index.as_integer().filter(|index| (0..length as i128).contains(index))
        };
        let unchecked = Indices::unchecked(self.tables);
        match indices.iter().enumerate().all(|both| is_there(both).is_some()) {
            true => unchecked.entry(table, indices),
            false => self.or_nan(&self.entry(table, indices)),
        }
    }

    /// A checked value, or NaN.
    pub(crate) fn or_nan(&self, checked: &TokenStream) -> TokenStream {
        quote!((|| __wzvi::Some(#checked))().unwrap_or(__wzvi::f64::NAN))
    }

    /// Whether the entries of a table are the elements of a list.
    pub(crate) fn is_plain(&self, table: u32) -> bool {
        self.tables.get(table as usize).is_some_and(|table| table.suffix.is_empty())
    }

    fn atom(&self, atom: &Atom) -> TokenStream {
        let isize = quote!(__wzvi::isize);
        match atom {
            Atom::Loop(id) => {
                let variable = variable(*id);
                quote!(#variable)
            }
            Atom::Size => quote!(__size),
            Atom::Given(table, indices) => {
                let entry = self.entry(*table, indices);
                quote!((#entry as #isize))
            }
            Atom::Of(operation, both) => {
                let (a, b) = (self.value(&both.0), self.value(&both.1));
                match (operation, self.checked) {
                    (IndexOperation::Product, _) => quote!((#a * #b)),
                    (IndexOperation::Quotient, true) => quote!(#isize::checked_div(#a, #b)?),
                    (IndexOperation::Quotient, false) => quote!((#a / #b)),
                    (IndexOperation::Remainder, true) => quote!(#isize::checked_rem(#a, #b)?),
                    (IndexOperation::Remainder, false) => quote!((#a % #b)),
                    (IndexOperation::Minimum, _) => quote!(__wzvi::Ord::min(#a, #b)),
                    (IndexOperation::Maximum, _) => quote!(__wzvi::Ord::max(#a, #b)),
                }
            }
        }
    }
}
