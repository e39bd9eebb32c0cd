//! The values in the equations of a block other than its unknowns.

use proc_macro2::{Ident, Literal, TokenStream};
use quote::quote;

use crate::emit::Printer;
use crate::emit::print::Rank;
use crate::emit::program::{Op, Program};
use crate::emit::system::count;

/// By type: numbers and truths of the state, and those of constants.
#[derive(Default)]
pub(super) struct BlockInputs {
    numbers: Vec<Ident>,
    masks: Vec<Ident>,
    constants: Vec<Ident>,
    truths: Vec<Ident>,
}

impl BlockInputs {
    pub(super) fn new(program: &Program, printer: &Printer<'_>, roots: &[Op], unknowns: &[Op]) -> Self {
        let read = program.frontier(roots, &|op| printer.is_bound(op));
        let mut given = Self::default();
        for op in read.into_iter().filter(|op| !unknowns.contains(op)) {
            let Some(name) = printer.bound(op) else { continue };
            let list = match (printer.rank(op), program.operation(op).is_truth()) {
                (Rank::Scalar, false) => &mut given.numbers,
                (Rank::Scalar, true) => &mut given.masks,
                (_, false) => &mut given.constants,
                (_, true) => &mut given.truths,
            };
            list.push(name.clone());
        }
        given
    }

    fn lists(&self) -> [&[Ident]; 4] {
        [&self.numbers, &self.masks, &self.constants, &self.truths]
    }

    /// As a value, and as a pattern.
    pub(super) fn tokens(&self) -> TokenStream {
        let lists = self.lists().map(|names| quote!([#(#names),*]));
        quote!((#(#lists),*))
    }

    /// The number of each.
    pub(super) fn lengths(&self) -> [Literal; 4] {
        self.lists().map(|names| count(names.len()))
    }
}
