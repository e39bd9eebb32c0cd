//! The dependency graph of the unknowns: components and feedback vertices.

use crate::diagnostics::promised;
use crate::discretise::{Equations, StepSymbols, Unknown};
use crate::symbolic::{Expr, Graph, Node};

/// Up to this many candidates every subset is tried; above, only a few natural ones.
const EXHAUSTIVE: usize = 12;

/// The graph of which unknown reads which.
pub(crate) struct Dependencies {
    /// `reads[a]` lists the unknowns that `φ_a` depends on.
    reads: Vec<Vec<Unknown>>,
    /// Estimated cost of evaluating `φ_a`.
    cost: Vec<u32>,
}

impl Dependencies {
    pub(crate) fn new(graph: &Graph, symbols: &StepSymbols, equations: &Equations) -> Self {
        let mut reads = Vec::new();
        let mut cost = Vec::new();
        for &phi in &equations.phi {
            let present = graph.symbols_in(phi);
            let is_read = |&b: &Unknown| symbols.views(b).iter().any(|(view, _)| present.contains(view));
            reads.push((0..equations.phi.len()).filter(is_read).collect());
            cost.push(price(graph, phi));
        }
        Self { reads, cost }
    }

    /// The structure of equations that are not known yet: all cost the same.
    pub(crate) fn of(reads: Vec<Vec<Unknown>>) -> Self {
        let cost = vec![1; reads.len()];
        Self { reads, cost }
    }

    /// Strongly connected components, each after those that it reads: the search trees of the reversed graph,
    /// rooted in the reverse finishing order of a search of the graph (Kosaraju).
    pub(crate) fn components(&self) -> Vec<Vec<Unknown>> {
        let mut read_by = vec![Vec::new(); self.reads.len()];
        for (vertex, reads) in self.reads.iter().enumerate() {
            reads.iter().for_each(|&read| read_by[read].push(vertex));
        }
        let left = trees(&self.reads, 0..self.reads.len()).concat();
        let mut components = trees(&read_by, left.into_iter().rev());
        components.iter_mut().for_each(|component| component.sort_unstable());
        components.reverse();
        components
    }

    /// Splits a component into the unknowns to iterate on and those assigned from them, in order.
    pub(crate) fn split(&self, component: &[Unknown]) -> (Vec<Unknown>, Vec<Unknown>) {
        let (forced, free): (Vec<usize>, Vec<usize>) =
            component.iter().partition(|&&vertex| self.reads[vertex].contains(&vertex));
        let feedback = self.smallest_feedback(component, &forced, &free);
        let assigned = self.order_without(component, &feedback);
        let assigned = promised(assigned, "without its feedback a component has an order");
        (feedback, assigned)
    }

    fn smallest_feedback(&self, component: &[usize], forced: &[usize], free: &[usize]) -> Vec<usize> {
        let mut best: Option<(usize, u32, Vec<usize>)> = None;
        for candidate in candidates(free, self.reads.len() / 2) {
            let mut feedback: Vec<usize> = forced.iter().chain(&candidate).copied().collect();
            feedback.sort_unstable();
            if best.as_ref().is_some_and(|(size, ..)| *size < feedback.len()) {
                continue;
            }
            let assigned = component.iter().filter(|vertex| !feedback.contains(vertex));
            let assigned_cost = assigned.map(|&vertex| self.cost[vertex]).sum();
            let key = (feedback.len(), assigned_cost);
            if best.as_ref().is_some_and(|(size, cost, _)| (*size, *cost) <= key) {
                continue;
            }
            if self.order_without(component, &feedback).is_some() {
                best = Some((key.0, key.1, feedback));
            }
        }
        best.map_or_else(|| component.to_vec(), |(_, _, feedback)| feedback)
    }

    /// The vertices of `component` outside `feedback`, each after those that it reads; `None` if they have a
    /// cycle.
    fn order_without(&self, component: &[usize], feedback: &[usize]) -> Option<Vec<usize>> {
        let mut pending: Vec<usize> = component.iter().copied().filter(|v| !feedback.contains(v)).collect();
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

/// Subsets of `free` by increasing size, or the natural ones where there are too many.
fn candidates(free: &[usize], degrees: usize) -> Vec<Vec<usize>> {
    if free.len() <= EXHAUSTIVE {
        let mut subsets: Vec<Vec<usize>> = (0..1usize << free.len())
            .map(|bits| (0..free.len()).filter(|i| bits >> i & 1 == 1).map(|i| free[i]).collect())
            .collect();
        subsets.sort_by_key(Vec::len);
        return subsets;
    }
    let coordinates = free.iter().copied().filter(|&v| v < degrees).collect();
    let momenta = free.iter().copied().filter(|&v| v >= degrees).collect();
    vec![Vec::new(), momenta, coordinates, free.to_vec()]
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
fn trees(edges: &[Vec<usize>], roots: impl Iterator<Item = usize>) -> Vec<Vec<usize>> {
    let mut met = vec![false; edges.len()];
    let tree = |root| {
        let mut left = Vec::new();
        search(edges, root, &mut met, &mut left);
        left
    };
    roots.map(tree).filter(|tree| !tree.is_empty()).collect()
}

/// The recursion depth is at most twice the number of degrees of freedom, which is small.
fn search(edges: &[Vec<usize>], vertex: usize, met: &mut [bool], left: &mut Vec<usize>) {
    if !std::mem::replace(&mut met[vertex], true) {
        edges[vertex].iter().for_each(|&next| search(edges, next, met, left));
        left.push(vertex);
    }
}
