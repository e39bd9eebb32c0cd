//! Bounds the nesting of token streams before anything recursive reads them: `syn` parses and drops by
//! recursion, and a compiler must not overflow its stack on any input.
//!
//! The bound is on a cost, in units of the stack that one link of a chain `a + b + ...` takes (about 700
//! bytes in a debug build). Costs were measured by the largest depth that fits a thread of 2 MiB.
//!
//! Tests: `lower/tests/robustness.rs`.

use proc_macro2::{Delimiter, Spacing, TokenStream, TokenTree};

use crate::diagnostics::{Diagnostics, messages};

/// About 1.5 MiB.
const LIMIT: usize = 2200;

const PAREN: usize = 24;
const BRACE: usize = 34;
/// A generic argument list.
const ANGLE: usize = 50;
const PREFIX: usize = 6;

/// Reports tokens that nest too deeply; they must not be read then.
pub(crate) fn check(tokens: &TokenStream, diagnostics: &mut Diagnostics) -> Option<()> {
    let error = too_deep(tokens).map(messages::nested_too_deeply);
    diagnostics.accept(error.map_or(Ok(()), Err))
}

/// The innermost token at which `tokens` nest too deeply, if they do.
fn too_deep(tokens: &TokenStream) -> Option<TokenTree> {
    // An explicit stack: this function itself must not overflow.
    let mut pending = vec![(tokens.clone(), 0)];
    while let Some((stream, outer)) = pending.pop() {
        let mut runs = Runs::default();
        let mut groups = Vec::new();
        for token in stream {
            runs.read(&token);
            if outer + runs.cost() > LIMIT {
                return Some(token);
            }
            if let TokenTree::Group(group) = token {
                let cost = if group.delimiter() == Delimiter::Brace { BRACE } else { PAREN };
                groups.push((group.stream(), runs.finished.len(), cost));
            }
        }
        let costs = runs.costs();
        for (stream, run, cost) in groups {
            pending.push((stream, outer + cost + costs.get(run).copied().unwrap_or(0)));
        }
    }
    None
}

/// Tokens of one stream, in runs that `,` and `;` separate. Within a run each operator may nest the
/// expression by one level: a long sum is a deep tree.
#[derive(Default)]
struct Runs {
    /// Costs of the runs before.
    finished: Vec<usize>,
    nested: usize,
    /// The length of the current chain of prefix operators.
    prefixes: usize,
    longest: usize,
    /// A type may have begun, in which `<` nests.
    in_type: bool,
    previous: Option<char>,
    after_else: bool,
    after_dot: bool,
}

impl Runs {
    fn read(&mut self, token: &TokenTree) {
        let previous = self.previous.take();
        let after_else = std::mem::take(&mut self.after_else);
        let after_dot = std::mem::take(&mut self.after_dot);
        match token {
            TokenTree::Punct(punct) => {
                self.punct(punct.as_char(), previous);
                self.previous = Some(punct.as_char()).filter(|_| punct.spacing() == Spacing::Joint);
                self.after_dot = punct.as_char() == '.';
            }
            TokenTree::Ident(ident) => {
                let name = ident.to_string();
                self.in_type |= is_in(BEFORE_TYPES, &name);
                match name.as_str() {
                    "else" | "as" => self.nested += 1,
                    // A chain of `else if` is read by a loop.
                    "if" if after_else => self.nested += 1,
                    name if is_in(NESTING, name) => self.nest(PAREN),
                    _ => self.prefixes = 0,
                }
                self.after_else = name == "else";
            }
            TokenTree::Group(_) => {
                self.nested += 1;
                self.prefixes = 0;
            }
            TokenTree::Literal(literal) => {
                self.prefixes = 0;
                // `q.0.0` is one number after the first dot, and two fields.
                self.nested += usize::from(after_dot && literal.to_string().contains('.'));
            }
        }
    }

    fn punct(&mut self, punct: char, previous: Option<char>) {
        match punct {
            ',' | ';' => {
                let cost = self.cost();
                let finished = std::mem::take(&mut self.finished);
                *self = Self { finished, ..Self::default() };
                self.finished.push(cost);
                return;
            }
            '=' | '|' => self.nest(12),
            '.' if previous == Some('.') => self.nest(16),
            '<' if self.in_type || self.prefixes > 0 => self.nest(ANGLE),
            ':' => self.in_type = true,
            _ => self.nested += 1,
        }
        self.prefixes += 1;
        self.longest = self.longest.max(self.prefixes);
    }

    /// Nests the tokens that follow: prefix operators before and after add up.
    fn nest(&mut self, cost: usize) {
        self.nested += cost + PREFIX * std::mem::take(&mut self.longest);
    }

    fn cost(&self) -> usize {
        self.nested + PREFIX * self.longest
    }

    fn costs(mut self) -> Vec<usize> {
        let cost = self.cost();
        self.finished.push(cost);
        self.finished
    }
}

/// Keywords after which an expression or an item starts that belongs to what was before.
const NESTING: &str =
    "if return break match move while loop for unsafe async const dyn impl fn static let in yield box";

/// Words after which `<` may open generic arguments.
const BEFORE_TYPES: &str = "as fn impl struct enum union trait type where for use dyn";

fn is_in(words: &str, name: &str) -> bool {
    words.split(' ').any(|word| word == name)
}
