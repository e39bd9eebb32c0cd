//! The values of collective variables, before the loops of the elements that read them: sums over all sites,
//! and slopes by these. Sums in the same loops are computed in one pass. Tests: `tests/loops/collective.rs`.

use std::collections::BTreeMap;

use proc_macro2::{Ident, Literal, TokenStream};
use quote::{format_ident, quote};

use super::kernel::Target;
use super::weighted::{ElementEmitter, Outputs};
use super::{Derivative, arm, opened, role_path};
use crate::discretise::{RoleElements, Weighted, unweighted};
use crate::emit::{count, f64_type};
use crate::model::{Collective, CollectiveSlot, Collectives, Element, Half, Loop, Reads, System};
use crate::symbolic::Expr;

/// The name of the value of a collective variable.
pub(super) fn name(slot: CollectiveSlot) -> Ident {
    format_ident!("__collective{}", slot.number)
}

/// The collective variables that elements need, with the halves of the state by which these are
/// differentiated; variables that others read come first.
fn needed(all: &Collectives, group: &[Weighted]) -> Vec<(CollectiveSlot, Reads)> {
    let mut needed: BTreeMap<u32, (CollectiveSlot, Reads)> = BTreeMap::new();
    let mut pending: Vec<(CollectiveSlot, Reads)> = Vec::new();
    for Weighted { element, .. } in group {
        let reads = match element.is_covector() {
            true => Reads { q: true, p: false },
            false => element.reads(),
        };
        pending.extend(element.collectives().map(|(_, slot)| (slot, reads)));
    }
    while let Some((slot, reads)) = pending.pop() {
        let known = needed.entry(slot.number).or_insert((slot, Reads { q: false, p: false }));
        let joined = known.1.or(reads);
        let of_variable = &all.of(slot).elements;
        if joined != known.1 {
            known.1 = joined;
            pending.extend(of_variable.iter().flat_map(Element::collectives).map(|(_, slot)| (slot, joined)));
        }
    }
    needed.into_values().collect()
}

/// Elements of collective variables in the same loops, with the variables that they are terms of.
type Pass = (Vec<Loop>, Vec<(Ident, Element)>);

impl ElementEmitter<'_> {
    /// The values of the collective variables that the elements of a group read.
    pub(super) fn collectives(&mut self, group: &[Weighted]) -> TokenStream {
        let mut left = needed(&self.model.collectives, group);
        let mut code = TokenStream::new();
        while let Some(&(_, wanted)) = left.first() {
            // A pass takes the variables that read none of the others and are wanted where the first one is.
            let numbers: Vec<u32> = left.iter().map(|(slot, _)| slot.number).collect();
            let all = &self.model.collectives;
            let is_ready = |(slot, reads): &(CollectiveSlot, Reads)| {
                let mut read = all.of(*slot).elements.iter().flat_map(Element::collectives);
                *reads == wanted && !read.any(|(_, other)| numbers.contains(&other.number))
            };
            let (ready, others): (Vec<_>, Vec<_>) = left.into_iter().partition(is_ready);
            left = others;
            let ready: Vec<Collective> =
                ready.iter().map(|(slot, _)| self.model.collectives.of(*slot).clone()).collect();
            code.extend(self.values_of(&ready, wanted));
        }
        code
    }

    /// The values of variables that do not read each other.
    fn values_of(&mut self, variables: &[Collective], wanted: Reads) -> TokenStream {
        let names: Vec<Ident> = variables.iter().map(|known| name(known.slot)).collect();
        let mut passes: Vec<Pass> = Vec::new();
        for (known, name) in variables.iter().zip(&names) {
            for element in &known.elements {
                let term = (name.clone(), element.clone());
                match passes.iter_mut().find(|(loops, _)| *loops == element.loops) {
                    Some((_, terms)) => terms.push(term),
                    None => passes.push((element.loops.clone(), vec![term])),
                }
            }
        }
        let passes: TokenStream = passes.into_iter().map(|(loops, terms)| self.pass(loops, &terms)).collect();
        let zero = self.derivative.constant(&quote!(0.0));
        let passes = match (self.derivative, wanted) {
            (Derivative::Value | Derivative::Hessian | Derivative::Rows, _) => passes,
            (_, Reads { q: true, p: true }) => quote!(if __partials.by_q || __partials.by_p { #passes }),
            (_, Reads { p: true, .. }) => quote!(if __partials.by_p { #passes }),
            _ => quote!(if __partials.by_q { #passes }),
        };
        quote! {
            #(let mut #names = #zero;)*
            #passes
            #(let #names = #names;)*
        }
    }

    /// One pass over the sites.
    fn pass(&mut self, loops: Vec<Loop>, terms: &[(Ident, Element)]) -> TokenStream {
        let mut locals = Vec::new();
        for local in terms.iter().flat_map(|(_, element)| &element.locals) {
            if !locals.iter().any(|known: &crate::model::Local| known.symbol == local.symbol) {
                locals.push(local.clone());
            }
        }
        let values: Vec<(Expr, Target)> = terms
            .iter()
            .map(|(name, element)| (element.value, Target::Total { sum: name.clone() }))
            .collect();
        let Some((value, _)) = values.first() else { return TokenStream::new() };
        let element = Element { loops, value: *value, locals };
        let weighted = unweighted(&[element]);
        let code = weighted.iter().map(|weighted| {
            self.computed(weighted, None, Outputs { values: values.clone(), ..Outputs::default() })
        });
        let code: TokenStream = code.collect();
        quote!({ #code })
    }
}

/// The collective variables of a role that follow the state.
struct RoleVariables {
    /// The variables on which its first derivatives depend, by number.
    all: Vec<CollectiveSlot>,
    /// The variables that its first derivatives read themselves.
    read: Vec<CollectiveSlot>,
}

impl RoleVariables {
    /// `None` if its first derivatives depend on none.
    fn of(model: &System, known: &RoleElements) -> Option<Self> {
        let follows_state = |slot: &CollectiveSlot| slot.reads.q || slot.reads.p;
        let needed = needed(&model.collectives, &known.elements).into_iter().map(|(slot, _)| slot);
        let all: Vec<CollectiveSlot> = needed.filter(follows_state).collect();
        let is_read = |slot: &CollectiveSlot| {
            let mut read = known.elements.iter().flat_map(|weighted| weighted.element.collectives());
            read.any(|(_, known)| known == *slot)
        };
        let read: Vec<CollectiveSlot> = all.iter().copied().filter(is_read).collect();
        (!read.is_empty()).then_some(Self { all, read })
    }
}

/// The place of a variable in a list.
fn place(list: &[CollectiveSlot], slot: CollectiveSlot) -> Option<Literal> {
    list.iter().position(|known| *known == slot).map(count)
}

/// `Facts::collective_variables` of roles that steps solve with; `None` if no role has any.
pub(super) fn variables(model: &System, roles: &[RoleElements]) -> Option<TokenStream> {
    let of_role = |known: &RoleElements| {
        let RoleVariables { all, read } = RoleVariables::of(model, known)?;
        let (role, count) = (role_path(known.role), count(all.len()));
        let read = read.iter().map(|slot| place(&all, *slot));
        Some(
            quote!(__wzvi::elements::CollectiveVariables { role: #role, count: #count, read: &[#(#read),*] }),
        )
    };
    let all: Vec<TokenStream> = roles.iter().filter_map(of_role).collect();
    (!all.is_empty()).then(|| quote!(&[#(#all),*]))
}

/// `Elements::collective_hessian`: the terms of rank one of the second derivatives; `None` if no role has
/// any.
pub(super) fn hessian_method(model: &mut System, roles: &[RoleElements]) -> Option<TokenStream> {
    let mut emitter = ElementEmitter { model, derivative: Derivative::Hessian };
    let arms = roles.iter().map(|known| {
        let code = emitter.rank_one_terms(known);
        arm(known.role, None, &code)
    });
    let code: TokenStream = arms.collect();
    let opened = opened(model, &code);
    let (f64, elements) = (f64_type(), quote!(__wzvi::elements));
    (!code.is_empty()).then(|| {
        quote! {
            fn collective_hessian<__S: __wzvi::Scalar>(
                &self,
                __role: #elements::Role,
                __weight: #f64,
                __at: &#elements::EvaluationPoint<'_, __S>,
                __into: &mut #elements::CollectiveHessian<__S>,
            ) {
                use #elements::{AdjacentSums as _, Sums as _};
                #opened
                match __role {
                    #code
                    _ => {}
                }
            }
        }
    })
}

impl ElementEmitter<'_> {
    /// The slopes of the collective variables by the state, and those of the first derivatives of a role by
    /// the variables that they read.
    fn rank_one_terms(&mut self, known: &RoleElements) -> TokenStream {
        let Some(RoleVariables { all, read }) = RoleVariables::of(self.model, known) else {
            return TokenStream::new();
        };
        let mut code = self.collectives(&known.elements);
        for (own, &slot) in all.iter().enumerate() {
            let own = count(own);
            for weighted in unweighted(&self.model.collectives.of(slot).elements.clone()) {
                let element = &weighted.element;
                let outputs = self.slopes_of(element, element.value);
                let gradient = self.computed(&weighted, None, outputs);
                code.extend(quote!({ let [__by_q, __by_p] = __into.gradient(#own); #gradient }));
                for (symbol, inner) in element.collectives() {
                    let Some(inner) = place(&all, inner) else { continue };
                    let slope = self.model.graph.derivative(element.value, symbol);
                    let values = vec![(slope, Target::total())];
                    let slope = self.computed(&weighted, None, Outputs { values, ..Outputs::default() });
                    code.extend(quote! {{
                        let mut __total = __S::from_f64(0.0);
                        #slope
                        __into.chain(#own, #inner, __total);
                    }});
                }
            }
        }
        for weighted in &known.elements {
            let weight = self.weight(known, weighted);
            for (symbol, slot) in weighted.element.collectives() {
                let Some(term) = place(&read, slot) else { continue };
                let (value, weight) = self.weighed(&weighted.element, Some(&weight));
                let slope = self.model.graph.derivative(value, symbol);
                let outputs = self.slopes_of(&weighted.element, slope);
                let slopes = self.computed(weighted, weight, outputs);
                code.extend(quote!({ let [__by_q, __by_p] = __into.slopes(#term); #slopes }));
            }
        }
        code
    }

    /// The slopes of a value by the variables of an element; for a covector `f`, components of `-f`.
    fn slopes_of(&mut self, element: &Element, value: Expr) -> Outputs {
        let graph = &mut self.model.graph;
        let values: Vec<(Expr, Target)> = match element.is_covector() {
            true => element
                .displacements()
                .map(|(symbol, index)| {
                    let component = graph.derivative(value, symbol);
                    (graph.negate(component), Target::gradient(Half::Coordinates, index.clone()))
                })
                .collect(),
            false => [Half::Coordinates, Half::Momenta]
                .into_iter()
                .flat_map(|half| element.of_half(half).map(move |(symbol, index)| (half, symbol, index)))
                .map(|(half, symbol, index)| {
                    (graph.derivative(value, symbol), Target::gradient(half, index.clone()))
                })
                .collect(),
        };
        Outputs { values, ..Outputs::default() }
    }
}
