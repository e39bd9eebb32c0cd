//! What the front end hands on for a system of elements.

use proc_macro2::TokenStream;

use super::index::{Index, Loop};
use crate::discretise::embedding::Embedding;
use crate::input::Shape;
use crate::model::{Extent, Located, Parameter};
use crate::symbolic::{Expr, Graph, Symbol};

/// A list or an integer that the struct or a constant holds.
#[derive(Clone)]
pub(crate) struct Table {
    /// As it is displayed.
    pub(crate) name: String,
    /// As it is read in a method of the struct.
    pub(crate) tokens: TokenStream,
    /// What follows the indices: the part of a tuple, or the length of a list inside.
    pub(crate) suffix: TokenStream,
    /// Whether its entries are known not to be negative.
    pub(crate) is_unsigned: bool,
}

/// Where the value of a local variable is.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(crate) enum Slot {
    /// Component of the coordinates, counted as in the state vector.
    Coordinate(Index),
    /// Component of the momenta.
    Momentum(Index),
    /// Entry of a list of real numbers.
    Entry(u32, Vec<Index>),
    /// An integer as a real number.
    Number(Index),
}

/// A local variable.
#[derive(Clone)]
pub(crate) struct Local {
    pub(crate) symbol: Symbol,
    pub(crate) slot: Slot,
}

/// A scalar function and the loops that place it, outermost first.
#[derive(Clone)]
pub(crate) struct Element {
    pub(crate) loops: Vec<Loop>,
    pub(crate) value: Expr,
    /// The variables that `value` reads, in order of creation.
    pub(crate) locals: Vec<Local>,
}

/// What of the state an element reads.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Reads {
    Nothing,
    Coordinates,
    Momenta,
    Both,
}

impl Element {
    pub(crate) fn coordinates(&self) -> impl Iterator<Item = (Symbol, &Index)> {
        self.locals.iter().filter_map(|local| match &local.slot {
            Slot::Coordinate(index) => Some((local.symbol, index)),
            _ => None,
        })
    }

    pub(crate) fn momenta(&self) -> impl Iterator<Item = (Symbol, &Index)> {
        self.locals.iter().filter_map(|local| match &local.slot {
            Slot::Momentum(index) => Some((local.symbol, index)),
            _ => None,
        })
    }

    pub(crate) fn reads(&self) -> Reads {
        match (self.coordinates().next().is_some(), self.momenta().next().is_some()) {
            (false, false) => Reads::Nothing,
            (true, false) => Reads::Coordinates,
            (false, true) => Reads::Momenta,
            (true, true) => Reads::Both,
        }
    }
}

/// A Hamiltonian as elements.
#[derive(Clone)]
pub(crate) struct Term {
    /// Each reads only coordinates, only momenta, or what cannot be parted: for derivatives.
    pub(crate) elements: Vec<Element>,
    /// The same sum as the user wrote it: for values, which keep its digits.
    pub(crate) values: Vec<Element>,
    pub(crate) extent: Extent,
}

/// The noises of a system.
pub(crate) enum Noises {
    List(Vec<Term>),
    /// One closure for `count` noises; `variable` is the loop variable that counts them.
    Family {
        term: Term,
        variable: u32,
        count: Index,
    },
}

impl Noises {
    pub(crate) fn terms(&self) -> &[Term] {
        match self {
            Self::List(terms) => terms,
            Self::Family { term, .. } => std::slice::from_ref(term),
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        matches!(self, Self::List(terms) if terms.is_empty())
    }
}

/// A declared first integral.
pub(crate) struct Invariant {
    pub(crate) term: Term,
}

/// Everything that was declared about a system of elements, lowered.
pub(crate) struct Model {
    pub(crate) graph: Graph,
    pub(crate) shape: Shape,
    /// The outermost size: the number of points.
    pub(crate) size: Index,
    /// Components of a point.
    pub(crate) components: i128,
    /// Names of coordinates and momenta.
    pub(crate) names: [String; 2],
    pub(crate) t: Symbol,
    pub(crate) parameters: Vec<Parameter>,
    pub(crate) tables: Vec<Table>,
    pub(crate) drift: Term,
    pub(crate) noises: Noises,
    pub(crate) invariants: Vec<Invariant>,
    pub(crate) embeddings: Vec<Located<Embedding>>,
    pub(crate) item: syn::ItemStruct,
    pub(crate) crate_path: syn::Path,
    pub(crate) type_checks: TokenStream,
}

impl Model {
    /// Whether any sum is left to be a loop.
    pub(crate) fn has_loops(&self) -> bool {
        let mut elements =
            self.drift.elements.iter().chain(self.noises.terms().iter().flat_map(|t| &t.elements));
        elements.any(|element| !element.loops.is_empty())
    }
}
