//! Elements with the weight of their role and the increments of their noises. Tests: `tests/loops`.

use std::collections::HashMap;

use proc_macro2::TokenStream;
use quote::{format_ident, quote};

use super::Derivative;
use super::combine::{Combined, hessian_of};
use super::kernel::Target;
use crate::discretise::{RoleElements, Weighted, family_of};
use crate::indices::Indices;
use crate::model::{Element, Half, Index, Reads, System};
use crate::symbolic::{Expr, Symbol, SymbolKind};

/// Values to compute, with their targets.
#[derive(Clone, Default)]
pub(super) struct Outputs {
    pub(super) values: Vec<(Expr, Target)>,
    /// The definitions of the symbols in the values.
    pub(super) definitions: HashMap<Symbol, Expr>,
}

/// The code that computes one quantity of the elements of a system.
pub(super) struct ElementEmitter<'m> {
    pub(super) model: &'m mut System,
    pub(super) derivative: Derivative,
}

impl ElementEmitter<'_> {
    /// The condition of a role, if there is a single one, and the code of its elements: their value, or
    /// statements that add their derivatives.
    pub(super) fn role(&mut self, known: &RoleElements) -> (Option<TokenStream>, TokenStream) {
        let is_value = self.derivative == Derivative::Value;
        let sum = if is_value { &known.values } else { &known.elements };
        let mut code = Vec::new();
        // Elements with the same increments are grouped.
        for group in sum.chunk_by(|a, b| a.increments == b.increments) {
            let Some(first) = group.first() else { continue };
            let weight = self.weight(known, first);
            let body = self.group(group, Some(&weight));
            if !body.is_empty() {
                code.push((self.condition(first), body));
            }
        }
        if code.len() == 1 {
            return code.remove(0);
        }
        let groups = code.into_iter().map(|(condition, body)| {
            let body = if is_value { quote!(__value = __value + { #body };) } else { body };
            match condition {
                Some(condition) => quote!(if #condition { #body }),
                None => body,
            }
        });
        let groups: TokenStream = groups.collect();
        (None, if is_value { quote!(let mut __value = __S::from_f64(0.0); #groups __value) } else { groups })
    }

    /// Elements with one common weight, or none.
    pub(super) fn group(&mut self, group: &[Weighted], weight: Option<&TokenStream>) -> TokenStream {
        let collectives = self.collectives(group);
        let code = match self.derivative {
            Derivative::Value => self.values(group, weight),
            _ => group.iter().map(|weighted| self.derivatives(weighted, weight)).collect(),
        };
        if code.is_empty() { code } else { quote!(#collectives #code) }
    }

    /// The sum of elements, with the weight taken out unless it changes in their loops.
    fn values(&mut self, group: &[Weighted], weight: Option<&TokenStream>) -> TokenStream {
        let is_fixed = group.iter().flat_map(|weighted| &weighted.increments).all(|k| k.loops().is_empty());
        let (inside, outside) = if is_fixed { (None, weight) } else { (weight, None) };
        if let [only] = group
            && only.element.loops.len() < 2
        {
            let code = self.value(only, inside, Target::Value { factor: outside.cloned() });
            return if code.is_empty() { quote!(__S::from_f64(0.0)) } else { code };
        }
        let added: Vec<TokenStream> =
            group.iter().map(|weighted| self.value(weighted, inside, Target::total())).collect();
        let factor = outside.map(|weight| quote!(* #weight));
        quote! {
            let mut __total = __S::from_f64(0.0);
            #({ #added })*
            __total #factor
        }
    }

    /// The value of one element, with the weight `inside` its loops, and its target. A covector has no value.
    fn value(&mut self, weighted: &Weighted, inside: Option<&TokenStream>, to: Target) -> TokenStream {
        let (value, weight) = self.weighed(&weighted.element, inside);
        let values = if weighted.element.is_covector() { Vec::new() } else { vec![(value, to)] };
        self.computed(weighted, weight, Outputs { values, ..Outputs::default() })
    }

    /// `c H_e` with a symbol for the weight `c`, if there is one.
    pub(super) fn weighed<'w>(
        &mut self,
        element: &Element,
        weight: Option<&'w TokenStream>,
    ) -> (Expr, Weight<'w>) {
        let Some(weight) = weight else { return (element.value, None) };
        let graph = &mut self.model.graph;
        let symbol = graph.new_symbol(SymbolKind::Parameter, "c");
        let c = graph.symbol(symbol);
        (graph.multiply(c, element.value), Some((symbol, weight)))
    }

    /// The first or second derivatives of one element, if derivatives by its variables are wanted.
    fn derivatives(&mut self, weighted: &Weighted, weight: Option<&TokenStream>) -> TokenStream {
        let element = &weighted.element;
        let condition = match element.reads() {
            _ if element.is_covector() => quote!(__partials.by_q),
            Reads { q: false, p: false } => return TokenStream::new(),
            Reads { q: true, p: false } => quote!(__partials.by_q),
            Reads { q: false, p: true } => quote!(__partials.by_p),
            Reads { q: true, p: true } => quote!((__partials.by_q || __partials.by_p)),
        };
        let (value, weight) = self.weighed(element, weight);
        let outputs = match (element.is_covector(), self.derivative) {
            (true, _) => Outputs { values: self.of_covector(element, value), ..Outputs::default() },
            (false, Derivative::Hessian) => self.hessian(element, value),
            (false, _) => self.gradient(element, value),
        };
        let body = self.computed(weighted, weight, outputs);
        if body.is_empty() { body } else { quote!(if #condition { #body }) }
    }

    fn gradient(&mut self, element: &Element, value: Expr) -> Outputs {
        let (graph, symbols) = (&mut self.model.graph, element.state());
        let mut combined = Combined::new(graph, value, &symbols);
        let slopes = match &mut combined {
            Some(combined) => combined.gradient(graph, &symbols),
            None => symbols.iter().map(|symbol| graph.derivative(value, *symbol)).collect(),
        };
        let places = places(element).into_iter();
        let values = slopes.into_iter().zip(places.map(|(half, index)| Target::gradient(half, index)));
        let definitions = combined.map(|combined| combined.definitions).unwrap_or_default();
        Outputs { values: values.collect(), definitions }
    }

    fn hessian(&mut self, element: &Element, value: Expr) -> Outputs {
        let (graph, symbols, all) = (&mut self.model.graph, element.state(), places(element));
        let mut combined = Combined::new(graph, value, &symbols);
        let found = combined.as_mut().and_then(|combined| combined.hessian(graph, &symbols));
        let found = found.unwrap_or_else(|| hessian_of(graph, value, &symbols));
        let pairs = all.iter().enumerate().flat_map(|(a, first)| all[a..].iter().map(move |b| (first, b)));
        let targets = pairs.map(|(first @ (half, row), second @ (other, column))| {
            let by = match (half, other) {
                (Half::Coordinates, Half::Coordinates) => format_ident!("QQ"),
                (Half::Momenta, Half::Momenta) => format_ident!("PP"),
                _ => format_ident!("QP"),
            };
            let (row, column) = (row.clone(), column.clone());
            Target::Hessian { by, row, column, is_alone: first == second }
        });
        let values = found.into_iter().zip(targets).collect();
        Outputs { values, definitions: combined.map(|combined| combined.definitions).unwrap_or_default() }
    }

    /// For a covector `f`, which replaces `-∂H/∂q`: components of `-f`, or their derivatives.
    fn of_covector(&mut self, element: &Element, value: Expr) -> Vec<(Expr, Target)> {
        let graph = &mut self.model.graph;
        let mut outputs: Vec<(Expr, Target)> = Vec::new();
        for (displacement, row) in element.displacements() {
            let component = graph.derivative(value, displacement);
            let slope = graph.negate(component);
            if self.derivative == Derivative::Gradient {
                outputs.push((slope, Target::gradient(Half::Coordinates, row.clone())));
                continue;
            }
            for (symbol, (half, column)) in element.state().into_iter().zip(places(element)) {
                let by = if half == Half::Momenta { "QP" } else { "QQ" };
                let (by, row) = (format_ident!("{by}"), row.clone());
                let target = Target::Hessian { by, row, column, is_alone: true };
                outputs.push((graph.hessian_entry(slope, symbol), target));
            }
        }
        outputs
    }

    /// The product of the increments of an element, and the weight of its role.
    pub(super) fn weight(&self, known: &RoleElements, Weighted { increments, .. }: &Weighted) -> TokenStream {
        let indices = Indices::unchecked(&self.model.tables);
        let factor = known.is_weighted.then(|| quote!(*__weight));
        let increments = increments.iter().map(|number| {
            let position = indices.position(number);
            self.derivative.lifted(quote!(__at.increment(#position)))
        });
        match increments.reduce(|product, increment| quote!(#product * #increment)) {
            Some(product) => quote!(#product #factor),
            None => self.derivative.step_size(factor),
        }
    }

    /// Whether a noise is active, if it is not a member of a family, whose loop checks it.
    fn condition(&self, weighted: &Weighted) -> Option<TokenStream> {
        let [number] = weighted.increments.as_slice() else { return None };
        if self.derivative == Derivative::Hessian || family_of(weighted).is_some() {
            return None;
        }
        let position = Indices::unchecked(&self.model.tables).position(number);
        let position = if number.terms.is_empty() { position } else { quote!((#position)) };
        Some(quote!(__at.acting.contains(&#position)))
    }
}

/// The symbol of a weight, with its definition: a value of the scalar type, in scope of the loops.
pub(super) type Weight<'w> = Option<(Symbol, &'w TokenStream)>;

/// The places of the variables of the state, in the order of [`Element::state`].
fn places(element: &Element) -> Vec<(Half, Index)> {
    let of = |half| element.of_half(half).map(move |(_, index)| (half, index.clone()));
    of(Half::Coordinates).chain(of(Half::Momenta)).collect()
}
