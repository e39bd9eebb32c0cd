//! Series `Σ_n h^n Σ_τ c(τ) F(τ)` over trees `τ` of `n` vertices, with the Poisson bracket: what step maps, and the
//! Hamiltonians that generate them, are written in.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use super::tree::{Half, Tree, rooted};

/// The trees of a series have fewer vertices than this.
const SIZES: usize = 6;

/// `B_n / n!` for the Bernoulli numbers with `B_1 = 1/2`, as many as brackets of so few vertices can need.
const BERNOULLI: [f64; SIZES - 1] = [1.0, 0.5, 1.0 / 12.0, 0.0, -1.0 / 720.0];

/// The trees, and the brackets of each two of them.
pub(super) struct Basis {
    /// By size.
    pub(super) trees: Vec<(Tree, usize)>,
    /// `{τ_a, τ_b}` has `c` times the tree `n`: `(a, b, n, c)`.
    brackets: Vec<(usize, usize, usize, f64)>,
}

impl Basis {
    /// The one that all series are in.
    pub(super) fn get() -> &'static Self {
        static BASIS: OnceLock<Basis> = OnceLock::new();
        BASIS.get_or_init(Self::new)
    }

    fn new() -> Self {
        let mut trees = Vec::new();
        for (size, rooted) in rooted(SIZES, [1.0, 1.0]).into_iter().enumerate() {
            let mut free: Vec<Tree> = rooted.iter().map(|(tree, _)| tree.free()).collect();
            free.sort();
            free.dedup();
            trees.extend(free.into_iter().map(|tree| (tree, size)));
        }
        let mut brackets = Vec::new();
        for (a, (first, size)) in trees.iter().enumerate() {
            for (b, (second, other_size)) in trees.iter().enumerate() {
                if size + other_size < SIZES {
                    let sum = bracket(first, second);
                    brackets.extend(
                        sum.iter()
                            .filter(|(_, weight)| **weight != 0.0)
                            .filter_map(|(tree, &weight)| Some((a, b, position(&trees, tree)?, weight))),
                    );
                }
            }
        }
        Self { trees, brackets }
    }
}

fn position(trees: &[(Tree, usize)], free: &Tree) -> Option<usize> {
    trees.iter().position(|(tree, _)| tree == free)
}

/// `{f, g} = f_p · g_q - f_q · g_p` puts an edge between each vertex of one and each of the other.
fn bracket(first: &Tree, second: &Tree) -> BTreeMap<Tree, f64> {
    let mut sum = BTreeMap::new();
    for one in first.rootings() {
        for other in second.rootings() {
            for (half, sign) in [(Half::Momenta, 1.0), (Half::Coordinates, -1.0)] {
                *sum.entry(one.joined(half, &other).free()).or_insert(0.0) += sign;
            }
        }
    }
    sum
}

/// A coefficient for each tree of the [`Basis`].
#[derive(Clone, Debug)]
pub(super) struct Series(pub(super) Vec<f64>);

impl Series {
    fn zero() -> Self {
        Self(vec![0.0; Basis::get().trees.len()])
    }

    fn add(&mut self, other: &Self, factor: f64) {
        self.0.iter_mut().zip(&other.0).for_each(|(sum, c)| *sum += factor * c);
    }

    /// The part with `size` vertices.
    fn part(&self, size: usize) -> Self {
        let trees = Basis::get().trees.iter();
        Self(self.0.iter().zip(trees).map(|(&c, (_, own))| if *own == size { c } else { 0.0 }).collect())
    }

    /// The series at `w h` in the place of `h`.
    pub(super) fn dilated(&self, w: f64) -> Self {
        let powers: Vec<f64> =
            std::iter::successors(Some(1.0), |power| Some(power * w)).take(SIZES).collect();
        let trees = Basis::get().trees.iter();
        Self(self.0.iter().zip(trees).map(|(c, (_, size))| c * powers[*size]).collect())
    }

    fn bracket(&self, other: &Self) -> Self {
        let mut sum = Self::zero();
        for &(a, b, n, weight) in &Basis::get().brackets {
            sum.0[n] += weight * self.0[a] * other.0[b];
        }
        sum
    }

    /// `h d/dh` of a step with one quadrature point `l` is the flow of `h H(w)` with the inner stage `w`, as a function of where it
    /// leads to: `w = (q - (1 - l) h H_p(w), p + l h H_q(w))`.
    pub(super) fn generator(l: f64) -> Self {
        let mut sum = Self::zero();
        let basis = &Basis::get().trees;
        for (tree, weight) in rooted(SIZES, [l - 1.0, l]).iter().flatten() {
            if let Some(n) = position(basis, &tree.free()) {
                sum.0[n] += weight;
            }
        }
        sum
    }

    /// `Z(h)`, of whose flow for a unit of time `h d/dh` is that of `self`: `h` times the modified Hamiltonian (W. Magnus, "On the
    /// exponential solution of differential equations for a linear operator", Comm. Pure Appl. Math. 7, 1954).
    pub(super) fn logarithm(&self) -> Self {
        // n Z_n = Σ_m (-1)^m B_m/m! T_(m, n), where T_(m, n) is the part of size n of m brackets with Z around `self`;
        // brackets here apply flows from the left, which turns the sign of B_1.
        let mut z = Self::zero();
        let mut nested: Vec<Vec<Self>> = vec![vec![Self::zero()]; SIZES - 1];
        for n in 1..SIZES {
            let own = self.part(n);
            let mut sum = own.clone();
            nested[0].push(own);
            for m in 1..SIZES - 1 {
                let mut of_depth = Self::zero();
                for k in 1..n {
                    of_depth.add(&z.part(k).bracket(&nested[m - 1][n - k]), 1.0);
                }
                sum.add(&of_depth, BERNOULLI[m]);
                nested[m].push(of_depth);
            }
            z.add(&sum, 1.0 / n as f64);
        }
        z
    }

    /// What `self` becomes where the flow of `z` follows: `e^(-{z, ·}) self`.
    fn carried_by(&self, z: &Self) -> Self {
        let (mut sum, mut term) = (self.clone(), self.clone());
        for k in 1..SIZES - 1 {
            let mut next = Self::zero();
            next.add(&z.bracket(&term), -1.0 / k as f64);
            sum.add(&next, 1.0);
            term = next;
        }
        sum
    }
}

/// `h` times the modified Hamiltonian of steps with quadrature points `l` of fractions `w` of the step, one after the other.
pub(super) fn modified(steps: &[(f64, f64)]) -> Series {
    let mut known: Vec<(f64, Series, Series)> = Vec::new();
    let mut generator = Series::zero();
    for &(l, w) in steps {
        if !known.iter().any(|(point, ..)| *point == l) {
            let own = Series::generator(l);
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
