//! The values that the equations of a block read besides its unknowns.

use proc_macro2::{Ident, TokenStream};
use quote::{format_ident, quote};

use crate::emit::print::Rank;
use crate::emit::program::{Op, Program};
use crate::emit::system::count;
use crate::emit::{Printer, f64_type};

/// By type: numbers and truths of the state, and those of constants.
#[derive(Default)]
pub(super) struct Given {
    numbers: Vec<Ident>,
    masks: Vec<Ident>,
    constants: Vec<Ident>,
    truths: Vec<Ident>,
}

impl Given {
    pub(super) fn new(program: &Program, printer: &Printer<'_>, roots: &[Op], unknowns: &[Op]) -> Self {
        let mut read: Vec<Op> = program
            .needed(roots, &|op| printer.is_bound(op))
            .into_iter()
            .filter(|&op| !printer.is_bound(op))
            .flat_map(|op| program.operation(op).operands())
            .chain(roots.iter().copied())
            .filter(|op| !unknowns.contains(op))
            .collect();
        read.sort_unstable();
        read.dedup();
        let mut given = Self::default();
        for op in read {
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

    /// One argument for each list that is not empty; `of` makes it of a list and of what kind that is.
    fn arguments(&self, of: impl Fn(&[Ident], Kind) -> TokenStream) -> TokenStream {
        let Self { numbers, masks, constants, truths } = self;
        let lists = [
            (numbers, Kind::Number),
            (masks, Kind::Mask),
            (constants, Kind::Constant),
            (truths, Kind::Truth),
        ];
        let arguments =
            lists.iter().filter(|(names, _)| !names.is_empty()).map(|(names, kind)| of(names, *kind));
        quote!(#(#arguments,)*)
    }

    /// Whether there are constants.
    pub(super) fn has_constants(&self) -> bool {
        !(self.constants.is_empty() && self.truths.is_empty())
    }

    /// As parameters of a function of numbers `__S` and constants `__K`.
    pub(super) fn parameters(&self) -> TokenStream {
        self.arguments(|names, kind| {
            let ty = match kind {
                Kind::Number => quote!(__S),
                Kind::Mask => quote!(__S::Mask),
                Kind::Constant => quote!(__K),
                Kind::Truth => quote!(<__K as __wzvi::Scalar>::Mask),
            };
            let (list, length) = (kind.list(), count(names.len()));
            quote!(#list: [#ty; #length])
        })
    }

    /// As parameters of a function of one lane.
    pub(super) fn parameters_of_one(&self) -> TokenStream {
        let (f64, bool) = (f64_type(), quote!(__wzvi::bool));
        self.arguments(|names, kind| {
            let ty = match kind {
                Kind::Number | Kind::Constant => &f64,
                Kind::Mask | Kind::Truth => &bool,
            };
            let (list, length) = (kind.list(), count(names.len()));
            quote!(#list: [#ty; #length])
        })
    }

    /// `let` for all of them and `others`, at once: a name may be that of a list.
    pub(super) fn open(&self, others: &[Ident]) -> TokenStream {
        let lists = self.arguments(|_, kind| {
            let list = kind.list();
            quote!(#list)
        });
        let names = self.passed();
        match lists.is_empty() {
            true => quote!(let [#(#others),*] = __iterate;),
            false => quote!(let (#names [#(#others),*]) = (#lists __iterate);),
        }
    }

    pub(super) fn passed(&self) -> TokenStream {
        self.arguments(|names, _| quote!([#(#names),*]))
    }

    pub(super) fn of_lane(&self) -> TokenStream {
        self.arguments(|names, kind| match kind {
            Kind::Number | Kind::Constant => quote!([#(#names.lane(__lane)),*]),
            Kind::Mask | Kind::Truth => quote!([#(__wzvi::Mask::lane(#names, __lane)),*]),
        })
    }

    /// What is given has no error in the equations that it makes.
    pub(super) fn lifted(&self) -> TokenStream {
        self.arguments(|_, kind| {
            let list = kind.list();
            match kind {
                Kind::Number => quote!(#list.map(__wzvi::Rounded::exact)),
                _ => quote!(#list),
            }
        })
    }
}

#[derive(Clone, Copy)]
enum Kind {
    Number,
    Mask,
    Constant,
    Truth,
}

impl Kind {
    /// What a list of this kind is called.
    fn list(self) -> Ident {
        match self {
            Self::Number => format_ident!("__given"),
            Self::Mask => format_ident!("__masks"),
            Self::Constant => format_ident!("__constants"),
            Self::Truth => format_ident!("__truths"),
        }
    }
}
