//! Bounds the nesting of token streams before anything recursive reads them: `syn` parses and drops by recursion, and
//! a compiler must not overflow its stack on any input.

use proc_macro2::{TokenStream, TokenTree};

/// Bound of [`cost`]: chosen so that the deepest stream still fits a thread of 2 MiB in a debug build.
const LIMIT: usize = 2400;

/// The innermost token at which `tokens` nest too deeply, if they do.
pub(super) fn too_deep(tokens: &TokenStream) -> Option<TokenTree> {
    // An explicit stack: this function has to survive what the others are guarded from.
    let mut pending = vec![(tokens.clone(), 0)];
    while let Some((stream, outer)) = pending.pop() {
        let mut run = Run::default();
        let mut groups = Vec::new();
        for token in stream {
            run.read(&token);
            if outer + run.cost > LIMIT || run.prefixes > 64 {
                return Some(token);
            }
            if let TokenTree::Group(group) = token {
                groups.push((group.stream(), run.number));
            }
            run.close_if_ended();
        }
        let costs = run.costs();
        for (stream, number) in groups {
            let inner = outer + costs.get(number).copied().unwrap_or(0) + GROUP;
            pending.push((stream, inner));
        }
    }
    None
}

/// Cost of a delimited group: parsing it passes through every level of precedence.
const GROUP: usize = 24;

/// Tokens between two separators. Each operator may nest the expression by one level: a long sum is a deep tree.
#[derive(Default)]
struct Run {
    cost: usize,
    /// Consecutive tokens that end no operand: a chain of prefix operators.
    prefixes: usize,
    number: usize,
    finished: Vec<usize>,
    ended: bool,
}

impl Run {
    fn read(&mut self, token: &TokenTree) {
        match token {
            TokenTree::Punct(punct) => {
                self.ended = matches!(punct.as_char(), ',' | ';');
                self.cost += match punct.as_char() {
                    '=' | '|' => 8,
                    _ => 1,
                };
                self.prefixes += 1;
            }
            TokenTree::Ident(ident) if nests(&ident.to_string()) => {
                self.cost += GROUP;
                self.prefixes += 1;
            }
            TokenTree::Group(group) => {
                self.cost += usize::from(group.delimiter() != proc_macro2::Delimiter::Brace);
                self.prefixes = 0;
            }
            _ => self.prefixes = 0,
        }
    }

    fn close_if_ended(&mut self) {
        if std::mem::take(&mut self.ended) {
            self.finished.push(std::mem::take(&mut self.cost));
            self.number += 1;
            self.prefixes = 0;
        }
    }

    fn costs(mut self) -> Vec<usize> {
        self.finished.push(self.cost);
        self.finished
    }
}

/// Keywords after which an expression starts that belongs to the one before.
fn nests(keyword: &str) -> bool {
    matches!(
        keyword,
        "if" | "else"
            | "return"
            | "break"
            | "match"
            | "move"
            | "while"
            | "loop"
            | "for"
            | "unsafe"
            | "async"
            | "dyn"
    )
}
