//! The three ways to solve the linear equations of an implicit step in loops, `(1 + a K) x = b`, beside each other: elimination
//! in a band, complete sparse factors in the order of a nested dissection, and GMRES with incomplete factors.
//!
//! `cargo bench --workspace --bench linear`; a name after `--` picks matrices, `-- 32`, and `all` includes those that take minutes.
//!
//! `K` is the stiffness of a chain, of lattices in two and three dimensions with periodic ends, and of bodies that springs
//! between all pairs hold. `a` times its largest eigenvalue is the square of the fastest `ω h / 2`. A solution has a
//! residual below `10^-12`. A step is one solution and a tenth of a factorisation: factors serve many steps.

#![allow(clippy::unwrap_used, reason = "a benchmark stops at the first error")]

use std::hint::black_box;
use std::time::Instant;

use wzvi_runtime::algebra::solve::{Banded, Krylov, Operator, Sparse, reverse_cuthill_mckee};

/// Residual of a solution, relative to the right-hand side.
const TOLERANCE: f64 = 1e-12;
/// Multiplications of a factorisation that takes minutes.
const MOST: f64 = 2e10;
/// The most numbers of a band: 2 GiB.
const MOST_NUMBERS: usize = 1 << 28;

/// Springs between unknowns, each pair once.
struct Springs {
    name: String,
    unknowns: usize,
    pairs: Vec<(usize, usize)>,
    strength: fn(usize, usize) -> f64,
    /// The largest eigenvalue of the stiffness, about.
    largest: f64,
}

fn equal(_: usize, _: usize) -> f64 {
    1.0
}

/// Decreases with the distance.
fn distant(i: usize, j: usize) -> f64 {
    1.0 / (1.0 + i.abs_diff(j) as f64)
}

impl Springs {
    fn chain(n: usize) -> Self {
        let pairs = (1..n).map(|i| (i - 1, i)).collect();
        Self { name: format!("chain of {n}"), unknowns: n, pairs, strength: equal, largest: 4.0 }
    }

    fn lattice<const D: usize>(side: usize) -> Self {
        let n = side.pow(D as u32);
        let mut pairs = Vec::new();
        for site in 0..n {
            for stride in (0..D as u32).map(|axis| side.pow(axis)) {
                let at = site / stride % side;
                let next = site + stride * ((at + 1) % side) - stride * at;
                pairs.push((site.min(next), site.max(next)));
            }
        }
        pairs.sort_unstable();
        pairs.dedup();
        let name = format!("lattice {side}^{D}");
        Self { name, unknowns: n, pairs, strength: equal, largest: 4.0 * D as f64 }
    }

    fn all_pairs(n: usize) -> Self {
        let pairs = (0..n).flat_map(|i| (0..i).map(move |j| (j, i))).collect();
        let largest = 4.0 * (n as f64).ln();
        Self { name: format!("all pairs of {n}"), unknowns: n, pairs, strength: distant, largest }
    }

    /// Gives the entries of `1 + a K`, but for the 1, to `add`.
    fn entries(&self, a: f64, mut add: impl FnMut(usize, usize, f64)) {
        for &(i, j) in &self.pairs {
            let k = a * (self.strength)(i, j);
            add(i, i, k);
            add(j, j, k);
            add(i, j, -k);
            add(j, i, -k);
        }
    }

    /// `y = (1 + a K) x`
    fn product(&self, a: f64, x: &[f64], y: &mut [f64]) {
        y.copy_from_slice(x);
        for &(i, j) in &self.pairs {
            let pull = a * (self.strength)(i, j) * (x[i] - x[j]);
            y[i] += pull;
            y[j] -= pull;
        }
    }

    fn is_dense(&self) -> bool {
        self.pairs.len() > 64 * self.unknowns
    }

    fn right_side(&self) -> Vec<f64> {
        (0..self.unknowns).map(|i| (1.3 * i as f64).sin() + (0.01 * i as f64).cos()).collect()
    }

    fn band(&self, a: f64, is_patient: bool) -> Option<Cost> {
        let natural = self.pairs.iter().map(|&(i, j)| j - i).max().unwrap_or(0);
        let (half, position) = if natural <= 4 || self.is_dense() {
            (natural, Vec::new())
        } else {
            let position = reverse_cuthill_mckee(self.unknowns, &self.pairs);
            let half = self.pairs.iter().map(|&(i, j)| position[i].abs_diff(position[j])).max();
            (half.unwrap_or(0), position)
        };
        let operations = 2.0 * self.unknowns as f64 * (half * half) as f64;
        if operations > MOST && !is_patient {
            return None;
        }
        let mut band = Banded::new(self.unknowns, half, position, MOST_NUMBERS)?.parted(self.is_dense());
        let (b, mut x) = (self.right_side(), vec![0.0; self.unknowns]);
        let factor = best(|| {
            band.reset();
            self.entries(a, |i, j, value| band.add(i, j, value));
            band.factor().unwrap();
        });
        let solution = best(|| {
            x.copy_from_slice(&b);
            band.solve(black_box(&mut x));
        });
        Some(Cost { factor, solution, products: 0 })
    }

    fn complete(&self, a: f64, is_patient: bool) -> Option<Cost> {
        let most = if is_patient { u64::MAX } else { MOST as u64 };
        let mut factors = Sparse::complete(self.unknowns, &self.pairs, most)?;
        let factor = self.factored(a, &mut factors);
        let (b, mut x) = (self.right_side(), vec![0.0; self.unknowns]);
        let solution = best(|| {
            x.copy_from_slice(&b);
            factors.solve(black_box(&mut x));
        });
        Some(Cost { factor, solution, products: 0 })
    }

    fn krylov(&self, a: f64) -> Option<Cost> {
        let mut factors = match self.is_dense() {
            true => Sparse::diagonal(self.unknowns),
            false => Sparse::incomplete(self.unknowns, &self.pairs)?,
        };
        let factor = self.factored(a, &mut factors);
        let mut krylov = Krylov::new(self.unknowns);
        let (mut products, b, mut x) = (0, self.right_side(), vec![0.0; self.unknowns]);
        let solution = best(|| {
            let operator = &mut Operator {
                product: &mut |x: &[f64], y: &mut [f64]| self.product(a, x, y),
                precondition: &mut |x: &mut [f64]| factors.solve(x),
                most_cycles: Krylov::<f64>::MOST_CYCLES,
            };
            x.copy_from_slice(&b);
            products = krylov.solve(&mut x, TOLERANCE, operator).unwrap_or(0);
        });
        (products > 0).then_some(Cost { factor, solution, products })
    }

    /// Seconds to factor.
    fn factored(&self, a: f64, factors: &mut Sparse<f64>) -> f64 {
        best(|| {
            factors.reset();
            self.entries(a, |i, j, value| factors.add(i, j, value));
            factors.factor();
        })
    }
}

/// Seconds, and the products of a solution.
struct Cost {
    factor: f64,
    solution: f64,
    products: u32,
}

impl Cost {
    /// A step.
    fn step(&self) -> f64 {
        self.solution + 0.1 * self.factor
    }
}

/// The shortest of three runs, or the only one if it takes long.
fn best(mut run: impl FnMut()) -> f64 {
    let mut shortest = f64::INFINITY;
    for _ in 0..3 {
        let start = Instant::now();
        run();
        shortest = shortest.min(start.elapsed().as_secs_f64());
        if shortest > 1.0 {
            break;
        }
    }
    shortest
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with("--")).collect();
    let is_patient = arguments.iter().any(|word| word == "all");
    let only = arguments.iter().find(|word| *word != "all");
    println!("ms: factorisation + solution (products) = step; - takes too long, or does not converge\n");
    println!("{:<18} {:>7} | {:>30} | {:>30} | {:>34}", "matrix", "ωh/2", "band", "complete", "GMRES");
    let matrices = [
        Springs::chain(100_000),
        Springs::lattice::<2>(64),
        Springs::lattice::<2>(256),
        Springs::lattice::<3>(16),
        Springs::lattice::<3>(32),
        Springs::all_pairs(1000),
    ];
    for springs in matrices.iter().filter(|known| only.is_none_or(|only| known.name.contains(only.as_str())))
    {
        for fastest in [2.0_f64, 20.0, 200.0, 2000.0] {
            let a = fastest * fastest / springs.largest;
            let costs = [springs.band(a, is_patient), springs.complete(a, is_patient), springs.krylov(a)];
            let words = costs.map(|cost| {
                cost.map_or("-".to_owned(), |cost| {
                    let [factor, solution, step] =
                        [cost.factor, cost.solution, cost.step()].map(|seconds| 1e3 * seconds);
                    let products =
                        if cost.products > 0 { format!(" ({})", cost.products) } else { String::new() };
                    format!("{factor:.3} + {solution:.3}{products} = {step:.3}")
                })
            });
            let [band, complete, krylov] = words;
            println!("{:<18} {fastest:>7} | {band:>30} | {complete:>30} | {krylov:>34}", springs.name);
        }
    }
}
