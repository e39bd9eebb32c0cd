//! Conditions for computing slopes window by window, and the number types used. Tests:
//! `tests/loops/tiles.rs`.

use proc_macro2::TokenStream;
use quote::quote;

use super::chunk::{InnerLoop, gathers, partners};
use crate::discretise::{RoleElements, unweighted};
use crate::emit::plan::degrees;
use crate::indices::Indices;
use crate::input::Shape;
use crate::model::{Atom, Element, Index, Loop, Reads, System};
use crate::symbolic::{Expr, Function, Node, Symbol};

/// All elements that slopes are taken of.
fn elements<'a>(model: &'a System, roles: &'a [RoleElements]) -> impl Iterator<Item = &'a Element> {
    let of_roles = roles.iter().flat_map(|known| &known.elements).map(|weighted| &weighted.element);
    of_roles.chain(model.summands.iter().flat_map(|term| &term.elements))
}

/// Whether the system can be stepped window by window, and is large enough if its size is known at compile
/// time; `None` if not.
pub(super) fn allows_tiles(model: &mut System, roles: &[RoleElements]) -> Option<TokenStream> {
    let has_loops = model.degrees_in_straight_lines().is_none();
    let are_local = has_loops && is_contiguous(model, roles) && acts_on_all_it_reads(model, roles);
    match (&model.shape, degrees(model)) {
        (Shape::Array(..), degrees) if are_local => Some(match degrees {
            Some(degrees) => quote!(#degrees >= __wzvi::elements::LEAST_IN_TILES),
            None => quote!(true),
        }),
        _ => None,
    }
}

/// Whether elements that read coordinates add to adjacent places or points, and those that read momenta read
/// one place or point each and add to it.
fn is_contiguous(model: &System, roles: &[RoleElements]) -> bool {
    let inner_loop = |inner: &Loop| InnerLoop { variable: inner.variable, components: model.components };
    // The places of placements, if they are adjacent.
    let stretch_of = |element: &Element, index: &Index| match element.loops.last() {
        None => Some((0, index.clone())),
        Some(inner) => inner_loop(inner).range(index),
    };
    if model.conformal.is_some() {
        return false;
    }
    elements(model, roles).all(|element| match element.reads() {
        // A covector may read anything, and collective variables are those of the whole state.
        _ if element.is_covector() || element.collectives().next().is_some() => false,
        Reads { q: false, p: false } => true,
        Reads { q: true, p: false } => {
            let mut strides =
                element.coordinates().map(|(_, index)| stretch_of(element, index).map(|(stride, _)| stride));
            let first = strides.next().flatten();
            first.is_some() && strides.all(|stride| stride == first)
        }
        Reads { q: false, p: true } => {
            let mut read = element.momenta().map(|(_, index)| stretch_of(element, index));
            let first = read.next().flatten();
            first.is_some() && read.all(|other| other == first)
        }
        Reads { q: true, p: true } => false,
    })
}

/// Whether no element reads a coordinate without acting on it. Then an element reads only windows to which it
/// contributes.
fn acts_on_all_it_reads(model: &mut System, roles: &[RoleElements]) -> bool {
    let read = |element: &Element| -> Vec<(Expr, Symbol)> {
        element.coordinates().map(|(symbol, _)| (element.value, symbol)).collect()
    };
    let read: Vec<(Expr, Symbol)> = elements(model, roles).flat_map(read).collect();
    read.into_iter().all(|(value, symbol)| {
        let slope = model.graph.derivative(value, symbol);
        !model.graph.is_zero(slope)
    })
}

/// Whether slopes of some elements are computed in rows of pairs.
pub(super) fn has_pairs(model: &System, roles: &[RoleElements]) -> bool {
    let indices = Indices::unchecked(&model.tables);
    let of_roles = roles.iter().flat_map(|known| known.elements.iter().cloned());
    let of_drift = model.summands.iter().flat_map(|term| unweighted(&term.elements));
    of_roles.chain(of_drift).any(|weighted| partners(&weighted, &indices, model.components).is_some())
}

/// The halves of the phase space with slopes of gathered elements, if any.
pub(super) fn gathered(model: &System, roles: &[RoleElements]) -> Option<TokenStream> {
    let gathered =
        elements(model, roles).filter(|element| gathers(&model.graph, element, &[], model.components));
    let (mut by_q, mut by_p) = (false, false);
    for element in gathered {
        let is_force = element.is_covector();
        by_q |= is_force || element.coordinates().next().is_some();
        by_p |= !is_force && element.momenta().next().is_some();
    }
    (by_q || by_p).then(|| quote!(__wzvi::elements::Partials { by_q: #by_q, by_p: #by_p }))
}

/// Whether the velocity of every degree of freedom is the slope of one element, in a loop over all places or
/// points, and nothing else.
pub(super) fn has_uniform_velocity(model: &System, roles: &[RoleElements]) -> bool {
    let mut read = elements(model, roles).filter(|element| element.reads().p);
    let (Some(element), None) = (read.next(), read.next()) else { return false };
    let [only] = element.loops.as_slice() else { return false };
    let is_all = only.start == Index::default() && only.end == model.size;
    let inner_loop = InnerLoop { variable: only.variable, components: model.components };
    let point = |index: &Index| inner_loop.range(index).map(|(_, base)| base);
    let first = Index::atom(Atom::Loop(only.variable)).multiply(&Index::integer(model.components));
    let read: Vec<&Index> = element.momenta().map(|(_, index)| index).collect();
    let is_each = i128::try_from(read.len()) == Ok(model.components);
    !element.reads().q
        && is_all
        && is_each
        && first.is_some()
        && read.into_iter().all(|index| point(index) == first)
}

/// The type for slopes in loops over neighbours: `f64` itself if only correctly rounded functions are called.
pub(super) fn common_range(model: &System, roles: &[RoleElements]) -> TokenStream {
    let of_collectives = model.collectives_of_terms().flat_map(|known| &known.elements);
    let values: Vec<Expr> =
        elements(model, roles).chain(of_collectives).map(|element| element.value).collect();
    let reached = model.graph.reachable(&values);
    match reached.into_iter().all(|expr| is_correctly_rounded(model.graph.node(expr))) {
        true => quote!(__wzvi::f64),
        false => quote!(__wzvi::elements::CommonRange),
    }
}

/// The largest exponent that is computed by multiplications and square roots, also after derivatives have
/// raised it.
const SPELLED_OUT: i64 = 12;

/// Whether the operation and its derivatives consist of correctly rounded ones.
pub(super) fn is_correctly_rounded(node: &Node) -> bool {
    match node {
        Node::Apply(function, _) => matches!(
            function,
            Function::Sqrt | Function::Abs | Function::Signum | Function::Min | Function::Max
        ),
        Node::Product(factors) => factors.iter().all(|(_, exponent)| {
            exponent.denominator() <= 2 && exponent.numerator().abs() <= SPELLED_OUT * exponent.denominator()
        }),
        _ => true,
    }
}
