//! Symbolic expressions: pure mathematics, no `syn`, no `quote`.
//!
//! Everything is a handle ([`Expr`]) into a hash-consing [`Graph`]. Two handles are equal exactly when their
//! canonical forms are. Constructors (`build`) keep the canonical form, so that a pass never has to simplify.

pub(crate) mod build;
mod condition;
pub(crate) mod differentiate;
mod display;
pub(crate) mod evaluate;
pub(crate) mod function;
pub(crate) mod graph;
mod order;
mod radial;
pub(crate) mod rational;
mod residue;
mod sides;
pub(crate) mod sign;
mod special;
pub(crate) mod stabilise;
pub(crate) mod substitute;
#[cfg(test)]
pub(crate) mod tests;
pub(crate) mod zero;

pub(crate) use display::signed;
pub(crate) use function::Function;
pub(crate) use graph::{Expr, Graph, Junction, Node, Relation, Symbol};
pub(crate) use order::SymbolKind;
pub(crate) use rational::Rational;
pub(crate) use sides::{Edge, Sides};
pub(crate) use special::{NAMES, Special};
pub(crate) use zero::{Knowledge, Witness, ZeroTest};
