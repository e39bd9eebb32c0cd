//! The dependency graph of the unknowns: components and feedback vertices.

use crate::diagnostics::promised;
use crate::discretise::{ByUnknown, Equations, StepSymbols, Unknown};
use crate::symbolic::{Expr, Graph, Node};

/// Up to this many candidates every subset is tried; above, only a few natural ones.
const EXHAUSTIVE: usize = 12;

/// The graph of which unknown reads which.
pub(crate) struct Dependencies {
    /// `reads[a]` lists the unknowns that `φ_a` depends on.
    reads: ByUnknown<Vec<Unknown>>,
    /// Estimated cost of evaluating `φ_a`.
    cost: ByUnknown<u32>,
}

impl Dependencies {
    pub(crate) fn new(graph: &Graph, symbols: &StepSymbols, equations: &Equations) -> Self {
        let phi = &equations.phi;
        let reads = |a: Unknown| {
            let present = graph.symbols_in(phi[a]);
            let is_read = |&b: &Unknown| symbols.views(b).iter().any(|(view, _)| present.contains(view));
            phi.unknowns().filter(is_read).collect()
        };
        let cost = |a: Unknown| price(graph, phi[a]);
        Self { reads: ByUnknown::of(symbols.degrees(), reads), cost: ByUnknown::of(symbols.degrees(), cost) }
    }

    /// The structure of equations that are not known yet: all cost the same.
    pub(crate) fn of(reads: ByUnknown<Vec<Unknown>>) -> Self {
        let cost = ByUnknown::of(reads.q.len(), |_| 1);
        Self { reads, cost }
    }

    /// Strongly connected components, each after those that it reads: the search trees of the reversed graph,
    /// rooted in the reverse finishing order of a search of the graph (Kosaraju).
    pub(crate) fn components(&self) -> Vec<Vec<Unknown>> {
        let mut read_by = ByUnknown::of(self.reads.q.len(), |_| Vec::new());
        for vertex in self.reads.unknowns() {
            self.reads[vertex].iter().for_each(|&read| read_by[read].push(vertex));
        }
        let left = trees(&self.reads, self.reads.unknowns()).concat();
        let mut components = trees(&read_by, left.into_iter().rev());
        components.iter_mut().for_each(|component| component.sort_unstable());
        components.reverse();
        components
    }

    /// Splits a component into the unknowns to iterate on and those assigned from them, in order.
    pub(crate) fn split(&self, component: &[Unknown]) -> (Vec<Unknown>, Vec<Unknown>) {
        let (forced, free): (Vec<Unknown>, Vec<Unknown>) =
            component.iter().partition(|&&vertex| self.reads[vertex].contains(&vertex));
        let feedback = self.smallest_feedback(component, &forced, &free);
        let assigned = self.order_without(component, &feedback);
        let assigned = promised(assigned, "without its feedback a component has an order");
        (feedback, assigned)
    }

    /// The fewest unknowns without which a component has no cycle; of several such sets, the one that leaves
    /// the cheapest equations to be assigned. `forced` read themselves, and belong to each set.
    fn smallest_feedback(&self, component: &[Unknown], forced: &[Unknown], free: &[Unknown]) -> Vec<Unknown> {
        let chosen = match free.len() <= EXHAUSTIVE {
            true => self.smallest_subset(free),
            false => self.natural_subset(component, forced, free),
        };
        let mut feedback = [forced, &chosen].concat();
        feedback.sort_unstable();
        feedback
    }

    /// The smallest subset of `free` that breaks every cycle among these, by trying all: subset `bits` has
    /// `free[i]` if bit `i` is set.
    fn smallest_subset(&self, free: &[Unknown]) -> Vec<Unknown> {
        let masks = free.iter().map(|&vertex| {
            let is_read = |&at: &usize| self.reads[vertex].contains(&free[at]);
            (0..free.len()).filter(is_read).fold(0, |mask, at| mask | 1 << at)
        });
        let masks: Vec<usize> = masks.collect();
        let members = |bits: usize| (0..free.len()).filter(move |at| bits >> at & 1 == 1);
        let all = (1 << free.len()) - 1;
        let assigned_cost = |bits: &usize| members(all & !bits).map(|at| self.cost[free[at]]).sum::<u32>();
        let of_size = |size: u32| {
            let sets = (0..=all).filter(move |bits: &usize| bits.count_ones() == size);
            sets.filter(|bits| is_acyclic(&masks, all & !bits)).min_by_key(assigned_cost)
        };
        let smallest = (0..=free.len() as u32).find_map(of_size);
        members(smallest.unwrap_or(all)).map(|at| free[at]).collect()
    }

    /// The smallest of the halves of `free`, none and all, that breaks every cycle.
    fn natural_subset(&self, component: &[Unknown], forced: &[Unknown], free: &[Unknown]) -> Vec<Unknown> {
        let (coordinates, momenta): (Vec<_>, Vec<_>) = free.iter().partition(|v| matches!(v, Unknown::Q(_)));
        let natural = [Vec::new(), momenta, coordinates, free.to_vec()].into_iter();
        let sets = natural.filter(|set| self.order_without(component, &[forced, set].concat()).is_some());
        let smallest = sets.min_by_key(|set| {
            let assigned = free.iter().filter(|vertex| !set.contains(vertex));
            (set.len(), assigned.map(|&vertex| self.cost[vertex]).sum::<u32>())
        });
        smallest.unwrap_or_else(|| free.to_vec())
    }

    /// The vertices of `component` outside `feedback`, each after those that it reads; `None` if they have a
    /// cycle.
    fn order_without(&self, component: &[Unknown], feedback: &[Unknown]) -> Option<Vec<Unknown>> {
        let mut pending: Vec<Unknown> = component.iter().copied().filter(|v| !feedback.contains(v)).collect();
        pending.sort_unstable();
        let mut ordered = Vec::new();
        while !pending.is_empty() {
            let ready =
                pending.iter().position(|&v| self.reads[v].iter().all(|read| !pending.contains(read)))?;
            ordered.push(pending.remove(ready));
        }
        Some(ordered)
    }
}

/// Whether the vertices in the set `left` have no cycle, where `masks[i]` is the set of those that `i` reads.
fn is_acyclic(masks: &[usize], mut left: usize) -> bool {
    while left != 0 {
        // An unknown that reads nothing that is left is on no cycle.
        let mut ready = 0;
        for (at, mask) in masks.iter().enumerate() {
            if left >> at & 1 == 1 && mask & left == 0 {
                ready |= 1 << at;
            }
        }
        if ready == 0 {
            return false;
        }
        left &= !ready;
    }
    true
}

/// The number of nodes, with transcendental functions and roots weighted higher.
fn price(graph: &Graph, expr: Expr) -> u32 {
    let weight = |&e: &Expr| match graph.node(e) {
        Node::Apply(..) => 20,
        Node::Product(factors) if factors.iter().any(|(_, exponent)| !exponent.is_integer()) => 20,
        Node::Product(factors) if factors.iter().any(|(_, exponent)| exponent.is_negative()) => 5,
        _ => 1,
    };
    graph.reachable(&[expr]).iter().map(weight).sum()
}

/// The depth-first search trees from each of `roots`, with their vertices in finishing order.
fn trees(edges: &ByUnknown<Vec<Unknown>>, roots: impl Iterator<Item = Unknown>) -> Vec<Vec<Unknown>> {
    let mut met = ByUnknown::of(edges.q.len(), |_| false);
    let tree = |root| {
        let mut left = Vec::new();
        search(edges, root, &mut met, &mut left);
        left
    };
    roots.map(tree).filter(|tree| !tree.is_empty()).collect()
}

/// The recursion depth is at most twice the number of degrees of freedom, which is small.
fn search(
    edges: &ByUnknown<Vec<Unknown>>,
    vertex: Unknown,
    met: &mut ByUnknown<bool>,
    left: &mut Vec<Unknown>,
) {
    if !std::mem::replace(&mut met[vertex], true) {
        edges[vertex].iter().for_each(|&next| search(edges, next, met, left));
        left.push(vertex);
    }
}
