//! Collects errors, so that independent mistakes are reported at once. The messages are in [`messages`].
//! Tests: `compile/message_tests.rs`, with the systems in `tests/compiler/ui/messages`.

/// Declares one function per message: its name, the place, its other arguments, values computed from these,
/// and the text, which may quote the tokens at the place.
macro_rules! messages {
    ($(
        $(#[$doc:meta])*
        $name:ident($found:ident $(, $argument:ident: $type:ty)*) $({ $($part:ident = $value:expr;)+ })? = $text:literal;
    )+) => {$(
        $(#[$doc])*
        pub(crate) fn $name($found: impl quote::ToTokens $(, $argument: $type)*) -> syn::Error {
            let $found = $found.into_token_stream();
            $($(let $part = $value;)+)?
            $crate::diagnostics::at(&$found, format_args!($text))
        }
    )+};
}

pub(crate) mod expressions;
pub(crate) mod facts;
pub(crate) mod internal;
pub(crate) mod ito;
pub(crate) mod messages;
mod spelling;

pub(crate) use self::internal::promised;

use std::collections::HashSet;
use std::fmt::Display;

use proc_macro2::{Ident, Span, TokenStream, TokenTree};
use quote::ToTokens;
use syn::Error;

pub(crate) use spelling::{closest, source};

pub(super) fn at(tokens: impl ToTokens, message: impl Display) -> Error {
    Error::new_spanned(tokens, message)
}

/// A suggestion at the end of a message.
pub(super) fn suggest(suggestion: Option<&str>) -> String {
    suggestion.map_or_else(String::new, |suggestion| format!("; did you mean `{suggestion}`?"))
}

/// Names as a list.
pub(crate) fn quoted(names: impl IntoIterator<Item = impl Display>) -> String {
    names.into_iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}

/// The errors so far. Call `finish` at the end: dropping the collector loses them.
#[must_use = "errors are lost unless `finish` turns them into tokens"]
pub(crate) struct Diagnostics {
    errors: Vec<syn::Error>,
    /// Places and texts of reported errors: an unrolled loop repeats its mistakes, and the user reads each
    /// once.
    seen: HashSet<(String, String)>,
    finished: bool,
}

impl Diagnostics {
    pub(crate) fn new() -> Self {
        Self { errors: Vec::new(), seen: HashSet::new(), finished: false }
    }

    /// Adds an error, unless the same was reported at the same place.
    pub(crate) fn report(&mut self, error: syn::Error) {
        for error in error {
            if self.seen.insert((format!("{:?}", error.span()), error.to_string())) {
                self.errors.push(error);
            }
        }
    }

    /// The value, or `None` and the error reported.
    pub(crate) fn accept<T>(&mut self, result: syn::Result<T>) -> Option<T> {
        result.map_err(|error| self.report(error)).ok()
    }

    pub(crate) fn has_errors(&self) -> bool {
        !self.errors.is_empty()
    }

    #[cfg(test)]
    pub(crate) fn errors(&self) -> &[syn::Error] {
        &self.errors
    }

    /// Number of errors so far.
    pub(crate) fn count(&self) -> usize {
        self.errors.len()
    }

    /// `Err` with a `compile_error!` per error, in the order of their report.
    pub(crate) fn finish(mut self) -> Result<(), TokenStream> {
        self.finished = true;
        match self.errors.is_empty() {
            true => Ok(()),
            false => Err(self.errors.iter().map(syn::Error::to_compile_error).collect()),
        }
    }
}

impl Drop for Diagnostics {
    fn drop(&mut self) {
        debug_assert!(self.finished || std::thread::panicking(), "diagnostics were dropped unread");
    }
}

/// A value that the user wrote, and its place.
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
