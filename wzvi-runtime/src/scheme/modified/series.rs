//! Series `Σ_n h^n Σ_τ c(τ) F(τ)` over trees `τ` of `n` vertices, with the Poisson bracket: they represent
//! step maps and the Hamiltonians that generate them.

use std::collections::BTreeMap;
use std::iter::successors;
use std::sync::OnceLock;

use super::tree::{PhaseHalf, Tree, rooted};
use crate::algebra::scalar::Scalar;

/// `B_m / m!` for the Bernoulli numbers with `B_1 = 1/2`.
const BERNOULLI: [f64; 7] = [1.0, 0.5, 1.0 / 12.0, 0.0, -1.0 / 720.0, 0.0, 1.0 / 30240.0];

/// The highest order of a basis: the numbers of trees with 1 to 9 vertices are 1, 1, 3, 8, 27, 91, 350,
/// 1376, 5743.
pub(super) const HIGHEST_ORDER: u32 = 6;

/// The trees up to a number of vertices, and the brackets of each pair.
pub(super) struct Basis {
    /// Trees have fewer vertices than this.
    sizes: usize,
    /// Trees with their sizes, sorted by size.
    pub(super) trees: Vec<(Tree, usize)>,
    /// The rooted trees of the stage of a step with one quadrature point.
    stage: Vec<Rooted>,
    /// By the sizes of `τ_a` and `τ_b`.
    brackets: BTreeMap<[usize; 2], Vec<Bracket>>,
}

/// The number of the tree of a rooted tree, its [edges](Tree::edges), and the inverse of the number of its
/// symmetries.
struct Rooted {
    n: usize,
    edges: [i32; 2],
    weight: f64,
}

/// `{τ_a, τ_b}` contains `weight` times the tree `n`.
struct Bracket {
    a: usize,
    b: usize,
    n: usize,
    weight: f64,
}

impl Basis {
    /// The basis for the first terms of schemes of this order, computed once: up to `h^r` with the least even
    /// `r` not below the order.
    pub(super) fn of_order(order: u32) -> &'static Self {
        static BASES: [OnceLock<Basis>; 3] = [const { OnceLock::new() }; 3];
        let half = order.clamp(1, HIGHEST_ORDER).div_ceil(2) as usize;
        BASES[half - 1].get_or_init(|| Self::new(2 * half + 2))
    }

    fn new(sizes: usize) -> Self {
        let rooted = rooted(sizes).into_iter().enumerate();
        let rooted: Vec<(Tree, usize, [i32; 2], f64)> = rooted
            .flat_map(|(size, trees)| {
                trees.into_iter().map(move |(tree, weight)| (tree.free(), size, tree.edges(), weight))
            })
            .collect();
        let mut trees: Vec<(usize, Tree)> =
            rooted.iter().map(|(tree, size, ..)| (*size, tree.clone())).collect();
        trees.sort();
        trees.dedup();
        let trees = trees.into_iter().map(|(size, tree)| (tree, size)).collect();
        let mut basis = Self { sizes, trees, stage: Vec::new(), brackets: BTreeMap::new() };
        let positions = basis.positions();
        let stage = rooted.iter().filter_map(|(tree, _, edges, weight)| {
            Some(Rooted { n: *positions.get(tree)?, edges: *edges, weight: *weight })
        });
        basis.stage = stage.collect();
        basis.brackets = basis.bracket_all();
        basis
    }

    fn bracket_all(&self) -> BTreeMap<[usize; 2], Vec<Bracket>> {
        let positions = self.positions();
        let rootings: Vec<Vec<Tree>> = self.trees.iter().map(|(tree, _)| tree.rootings()).collect();
        let mut brackets: BTreeMap<[usize; 2], Vec<Bracket>> = BTreeMap::new();
        for (a, first) in rootings.iter().enumerate() {
            for (b, second) in rootings.iter().enumerate() {
                if first.len() + second.len() < self.sizes {
                    let sum = bracket(first, second);
                    let terms = sum.iter().filter(|(_, weight)| **weight != 0.0);
                    let terms = terms.filter_map(|(tree, &weight)| {
                        Some(Bracket { a, b, n: *positions.get(tree)?, weight })
                    });
                    brackets.entry([first.len(), second.len()]).or_default().extend(terms);
                }
            }
        }
        brackets
    }

    fn positions(&self) -> BTreeMap<&Tree, usize> {
        self.trees.iter().enumerate().map(|(n, (tree, _))| (tree, n)).collect()
    }
}

/// `{f, g} = f_p · g_q - f_q · g_p` adds an edge between each vertex of one and each of the other.
fn bracket(first: &[Tree], second: &[Tree]) -> BTreeMap<Tree, f64> {
    let mut sum = BTreeMap::new();
    for one in first {
        for other in second {
            for (half, sign) in [(PhaseHalf::Momenta, 1.0), (PhaseHalf::Coordinates, -1.0)] {
                *sum.entry(one.joined(half, other).free()).or_insert(0.0) += sign;
            }
        }
    }
    sum
}

/// A coefficient for each tree of a basis.
#[derive(Clone)]
pub(super) struct TreeSeries {
    pub(super) basis: &'static Basis,
    pub(super) coefficients: Vec<f64>,
}

impl TreeSeries {
    fn zero(basis: &'static Basis) -> Self {
        Self { basis, coefficients: vec![0.0; basis.trees.len()] }
    }

    /// The coefficients, with their trees and sizes.
    pub(super) fn terms(&self) -> impl Iterator<Item = (f64, &'static (Tree, usize))> {
        self.coefficients.iter().copied().zip(&self.basis.trees)
    }

    fn add(&mut self, other: &Self, factor: f64) {
        let both = self.coefficients.iter_mut().zip(&other.coefficients);
        both.for_each(|(sum, c)| *sum += factor * c);
    }

    /// Maps each coefficient, given with its size.
    fn map(&self, map: impl Fn(f64, usize) -> f64) -> Self {
        let coefficients = self.terms().map(|(c, &(_, size))| map(c, size)).collect();
        Self { basis: self.basis, coefficients }
    }

    /// The part with `size` vertices.
    fn part(&self, size: usize) -> Self {
        self.map(|c, own| if own == size { c } else { 0.0 })
    }

    /// The series with `w h` in place of `h`.
    fn dilated(&self, w: f64) -> Self {
        let powers: Vec<f64> =
            successors(Some(1.0), |power| Some(power * w)).take(self.basis.sizes).collect();
        self.map(|c, size| c * powers[size])
    }

    /// Adds the bracket of the parts of `first` and `second` with these sizes.
    fn add_bracket(&mut self, first: &Self, second: &Self, sizes: [usize; 2]) {
        for &Bracket { a, b, n, weight } in self.basis.brackets.get(&sizes).into_iter().flatten() {
            self.coefficients[n] += weight * first.coefficients[a] * second.coefficients[b];
        }
    }

    fn bracket(&self, other: &Self) -> Self {
        let mut sum = Self::zero(self.basis);
        self.basis.brackets.keys().for_each(|&sizes| sum.add_bracket(self, other, sizes));
        sum
    }

    /// `h` times the generator of the step with one quadrature point `l`, as a function of its end: `h H(w)`
    /// with the stage `w = (q - (1 - l) h H_p(w), p + l h H_q(w))`. It generates `h ∂/∂h` of the step.
    fn generator(basis: &'static Basis, l: f64) -> Self {
        let mut sum = Self::zero(basis);
        for &Rooted { n, edges: [q, p], weight } in &basis.stage {
            sum.coefficients[n] += weight * Scalar::powi(l - 1.0, q) * Scalar::powi(l, p);
        }
        sum
    }

    /// `Z`, whose flow over unit time is the map that `self` generates: `h` times the modified Hamiltonian
    /// (W. Magnus, "On the exponential solution of differential equations for a linear operator", Comm. Pure
    /// Appl. Math. 7, 1954).
    ///
    /// `n Z_n = Σ_m B_m/m! T_(m, n)`, where `T_(m, n)` is the part with `n` vertices of
    /// `{Z, {Z, ... {Z, G}}}` with `m` brackets.
    fn logarithm(&self) -> Self {
        let sizes = self.basis.sizes;
        let mut z = Self::zero(self.basis);
        let mut nested: Vec<Vec<Self>> = vec![vec![Self::zero(self.basis)]; sizes - 1];
        for n in 1..sizes {
            let own = self.part(n);
            let mut sum = own.clone();
            nested[0].push(own);
            for m in 1..sizes - 1 {
                let mut of_depth = Self::zero(self.basis);
                for k in 1..n {
                    of_depth.add_bracket(&z, &nested[m - 1][n - k], [k, n - k]);
                }
                sum.add(&of_depth, BERNOULLI[m]);
                nested[m].push(of_depth);
            }
            z.add(&sum, 1.0 / n as f64);
        }
        z
    }

    /// `self` carried by a subsequent flow of `z`: `e^(-{z, ·}) self`.
    fn carried_by(&self, z: &Self) -> Self {
        let (mut sum, mut term) = (self.clone(), self.clone());
        for k in 1..self.basis.sizes - 1 {
            term = z.bracket(&term).map(|c, _| -c / k as f64);
            sum.add(&term, 1.0);
        }
        sum
    }
}

/// `h` times the modified Hamiltonian of successive steps with quadrature points `l` over fractions `w` of
/// the step, to the order of [`Basis::of_order`].
pub(super) fn modified(steps: &[(f64, f64)], order: u32) -> TreeSeries {
    let basis = Basis::of_order(order);
    let mut known: Vec<(f64, TreeSeries, TreeSeries)> = Vec::new();
    let mut generator = TreeSeries::zero(basis);
    for &(l, w) in steps {
        if !known.iter().any(|(point, ..)| *point == l) {
            let own = TreeSeries::generator(basis, l);
            let flow = own.logarithm();
            known.push((l, own, flow));
        }
        for (_, own, flow) in known.iter().filter(|(point, ..)| *point == l) {
            generator = generator.carried_by(&flow.dilated(w));
            generator.add(&own.dilated(w), 1.0);
        }
    }
    generator.logarithm()
}
