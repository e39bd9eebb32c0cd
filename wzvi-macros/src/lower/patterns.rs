//! Patterns: binding of names to values. Tests: `tests/accepted/phase_spaces.rs`.

use proc_macro2::TokenStream;
use quote::ToTokens;
use syn::punctuated::Punctuated;
use syn::visit::{self, Visit};
use syn::{Ident, ItemConst, Pat, PatIdent, Token};

use super::interpreter::Interpreter;
use super::value::{Items, Value};
use crate::diagnostics::expressions;

impl<'a> Interpreter<'a, '_> {
    /// Brings the names of `pattern` into scope.
    pub(super) fn bind(&mut self, pattern: &'a Pat, value: Value) {
        match pattern {
            Pat::Wild(_) => {}
            Pat::Ident(ident) => {
                if let Some((_, inner)) = &ident.subpat {
                    self.bind(inner, value.clone());
                }
                self.declare(ident.ident.clone(), value);
            }
            Pat::Type(typed) => self.bind(&typed.pat, value),
            Pat::Paren(inner) => self.bind(&inner.pat, value),
            Pat::Reference(inner) => self.bind(&inner.pat, value),
            Pat::Tuple(tuple) => self.bind_elements(&tuple.elems, value, false, pattern),
            Pat::Slice(slice) => self.bind_elements(&slice.elems, value, true, pattern),
            _ => {
                if !value.is_poison() {
                    self.report(expressions::unsupported_pattern(pattern));
                }
                self.poison(pattern);
            }
        }
    }

    /// Declares the names of a reported pattern, to avoid further messages at their uses.
    pub(super) fn poison(&mut self, pattern: &Pat) {
        let mut names = BoundNames::default();
        names.visit_pat(pattern);
        for name in names.0 {
            self.declare(name, Value::Poison);
        }
    }

    fn bind_elements(
        &mut self,
        patterns: &'a Punctuated<Pat, Token![,]>,
        value: Value,
        is_list: bool,
        at: &Pat,
    ) {
        let Some(items) = self.elements_of(value, is_list, patterns, at.to_token_stream()) else {
            return self.poison(at);
        };
        let of_rest = (items.len() + 1).saturating_sub(patterns.len());
        let mut items = items.into_iter();
        for pattern in patterns {
            match pattern {
                Pat::Ident(ident) if is_rest(pattern) => {
                    let rest = items.by_ref().take(of_rest).collect();
                    self.declare(ident.ident.clone(), Value::list(rest));
                }
                pattern if is_rest(pattern) => items.by_ref().take(of_rest).for_each(drop),
                pattern => self.bind(pattern, items.next().unwrap_or_default()),
            }
        }
    }

    /// The elements of `value`, if it matches the pattern.
    fn elements_of(
        &mut self,
        value: Value,
        is_list: bool,
        patterns: &Punctuated<Pat, Token![,]>,
        at: TokenStream,
    ) -> Option<Vec<Value>> {
        let rests = patterns.iter().filter(|pattern| is_rest(pattern)).count();
        let items = match &value {
            Value::Poison => return None,
            Value::Tuple(Items { items, .. }) if !is_list => items.to_vec(),
            Value::Sequence(list) if is_list => self.items(list, &at)?,
            _ => {
                return self.refuse(expressions::pattern_mismatch(at, value.describe()));
            }
        };
        let named = patterns.len() - rests;
        let fits = if rests == 0 { items.len() == named } else { rests == 1 && items.len() >= named };
        if !fits {
            let len = items.len();
            return self.refuse(expressions::pattern_mismatch(
                at,
                &format!("{} of {len} elements", value.describe()),
            ));
        }
        Some(items)
    }
}

/// The names that a pattern or a `const` binds, or might.
#[derive(Default)]
pub(crate) struct BoundNames(pub(crate) Vec<Ident>);

impl Visit<'_> for BoundNames {
    fn visit_pat_ident(&mut self, pattern: &PatIdent) {
        self.0.push(pattern.ident.clone());
        visit::visit_pat_ident(self, pattern);
    }

    fn visit_item_const(&mut self, item: &ItemConst) {
        self.0.push(item.ident.clone());
        visit::visit_item_const(self, item);
    }
}

fn is_rest(pattern: &Pat) -> bool {
    match pattern {
        Pat::Rest(_) => true,
        Pat::Ident(ident) => ident.subpat.as_ref().is_some_and(|(_, inner)| matches!(**inner, Pat::Rest(_))),
        _ => false,
    }
}
