//! Steps at which the fixed point does not contract: a chain, and lattices from soft to stiff.
//!
//! By hand: Newton's method until a correction is rounding, with the tridiagonal matrix of the chain eliminated, and with conjugate
//! gradients on products with the matrix of the lattice.

use fixtures::stiff::{Fput, Torus, field, waves};
use wzvi::prelude::*;

use crate::measure::{Case, Runner, generated};

const SIDE: usize = 256;
/// The springs turn by more than two in a step, the wells by a twentieth.
const H: f64 = 3.0;
const H_OF_LATTICE: f64 = 0.05;
static FPUT: Fput = Fput { alpha: 0.25, beta: 0.25 };
static LATTICES: [Torus; 4] = {
    const fn of(k_h_squared: f64) -> Torus {
        Torus { side: SIDE, stiffness: k_h_squared / (H_OF_LATTICE * H_OF_LATTICE), depth: 1.0 }
    }
    [of(1.0), of(1e2), of(1e4), of(1e6)]
};

/// Forces at the mid-point, and the linear equations of their derivatives.
trait Stiff {
    /// `r = m - base - a f(m)`
    fn residual(&self, m: &[f64], base: &[f64], a: f64, r: &mut [f64]);

    /// `r` becomes `(1 - a f'(m))⁻¹ r`.
    fn solve(&mut self, m: &[f64], a: f64, r: &mut [f64]);
}

/// `m = q + h/2 (p + h/2 f(m))`
struct Newton<F> {
    forces: F,
    h: f64,
    q: Vec<f64>,
    p: Vec<f64>,
    base: Vec<f64>,
    middle: Vec<f64>,
    residual: Vec<f64>,
    iterations: u64,
}

impl<F: Stiff + 'static> Newton<F> {
    fn boxed(forces: F, h: f64, q: Vec<f64>) -> Box<dyn Runner> {
        let zeros = || vec![0.0; q.len()];
        let [p, base, middle, residual] = [zeros(), zeros(), zeros(), zeros()];
        Box::new(Self { forces, h, p, base, middle, residual, q, iterations: 0 })
    }
}

impl<F: Stiff> Runner for Newton<F> {
    fn run(&mut self, steps: usize) {
        let Self { forces, h, q, p, base, middle, residual, iterations } = self;
        for _ in 0..steps {
            for ((base, middle), (q, p)) in base.iter_mut().zip(&mut *middle).zip(q.iter().zip(&*p)) {
                *base = q + 0.5 * *h * p;
                *middle = *base;
            }
            let mut last = f64::INFINITY;
            loop {
                *iterations += 1;
                forces.residual(middle, base, 0.25 * *h * *h, residual);
                forces.solve(middle, 0.25 * *h * *h, residual);
                middle.iter_mut().zip(&*residual).for_each(|(middle, change)| *middle -= change);
                let change = residual.iter().fold(0.0_f64, |most, change| most.max(change.abs()));
                if change <= 1e-15 || change > 0.5 * last {
                    break;
                }
                last = change;
            }
            for ((q, p), middle) in q.iter_mut().zip(&mut *p).zip(&*middle) {
                let end = 2.0 * middle - *q;
                *p = 2.0 * (end - *q) / *h - *p;
                *q = end;
            }
        }
    }
    fn state(&self) -> (Vec<f64>, Vec<f64>) {
        (self.q.clone(), self.p.clone())
    }
    fn iterations(&self) -> u64 {
        self.iterations
    }
}

/// The elimination of a chain.
struct Chain {
    above: Vec<f64>,
}

fn pull(d: f64) -> f64 {
    d * (1.0 + d * (0.25 + 0.25 * d))
}

fn stiffness(d: f64) -> f64 {
    1.0 + d * (0.5 + 0.75 * d)
}

/// The stretch of each spring, from wall to wall.
fn stretches(m: &[f64]) -> impl Iterator<Item = f64> {
    (0..=m.len()).map(|i| {
        let (left, right) = (if i == 0 { 0.0 } else { m[i - 1] }, m.get(i).copied().unwrap_or(0.0));
        right - left
    })
}

impl Stiff for Chain {
    fn residual(&self, m: &[f64], base: &[f64], a: f64, r: &mut [f64]) {
        let mut pulls = stretches(m).map(pull);
        let mut left = pulls.next().unwrap_or(0.0);
        for ((r, right), (m, base)) in r.iter_mut().zip(pulls).zip(m.iter().zip(base)) {
            *r = m - base - a * (right - left);
            left = right;
        }
    }

    fn solve(&mut self, m: &[f64], a: f64, r: &mut [f64]) {
        let mut stiff = stretches(m).map(|d| a * stiffness(d));
        let mut left = stiff.next().unwrap_or(0.0);
        let (mut above, mut before) = (0.0, 0.0);
        for (i, right) in stiff.enumerate() {
            let pivot = 1.0 + left + right + left * above;
            above = -right / pivot;
            before = (r[i] + left * before) / pivot;
            (self.above[i], r[i]) = (above, before);
            left = right;
        }
        for i in (0..r.len() - 1).rev() {
            r[i] -= self.above[i] * r[i + 1];
        }
    }
}

/// Conjugate gradients on a lattice.
struct Lattice {
    stiffness: f64,
    vectors: [Vec<f64>; 3],
}

impl Lattice {
    /// `y = own(i) x_i - k Σ neighbours`
    fn apply(&self, x: &[f64], y: &mut [f64], own: impl Fn(usize) -> f64, k: f64) {
        for i in 0..SIDE {
            let row = |i: usize| &x[i % SIDE * SIDE..][..SIDE];
            let (up, mid, down) = (row(i + SIDE - 1), row(i), row(i + 1));
            for j in 0..SIDE {
                let sides = mid[(j + 1) % SIDE] + mid[(j + SIDE - 1) % SIDE] + up[j] + down[j];
                y[i * SIDE + j] = own(i * SIDE + j) * mid[j] - k * sides;
            }
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

impl Stiff for Lattice {
    fn residual(&self, m: &[f64], base: &[f64], a: f64, r: &mut [f64]) {
        let k = a * self.stiffness;
        self.apply(m, r, |i| 1.0 + 4.0 * k + a * (m[i] * m[i] - 1.0), k);
        r.iter_mut().zip(base).for_each(|(r, base)| *r -= base);
    }

    fn solve(&mut self, m: &[f64], a: f64, r: &mut [f64]) {
        let k = a * self.stiffness;
        let [mut x, mut way, mut image] = std::mem::take(&mut self.vectors);
        x.fill(0.0);
        way.copy_from_slice(r);
        let (mut size, start) = (dot(r, r), dot(r, r));
        while size > 1e-12 * start {
            self.apply(&way, &mut image, |i| 1.0 + 4.0 * k + a * (3.0 * m[i] * m[i] - 1.0), k);
            let length = size / dot(&way, &image);
            x.iter_mut().zip(&way).for_each(|(x, way)| *x += length * way);
            r.iter_mut().zip(&image).for_each(|(r, image)| *r -= length * image);
            let before = std::mem::replace(&mut size, dot(r, r));
            way.iter_mut().zip(&*r).for_each(|(way, r)| *way = r + size / before * *way);
        }
        r.copy_from_slice(&x);
        self.vectors = [x, way, image];
    }
}

/// One of the lattices, generated and by hand.
fn lattice<const WHICH: usize>(scheme: &'static str) -> Case {
    let stiffness = LATTICES[WHICH].stiffness;
    Case {
        problem: "stiff",
        scheme,
        n: SIDE * SIDE,
        steps: 1,
        is_counted: false,
        // Rounding of forces `k h² q`, and what conjugate gradients leave.
        tolerance: 1e-11 * (1.0 + stiffness.sqrt()),
        generated: |_| {
            generated::<_, Midpoint>(&LATTICES[WHICH], H_OF_LATTICE, field(SIDE), vec![0.0; SIDE * SIDE])
        },
        by_hand: |n| {
            let vectors = std::array::from_fn(|_| vec![0.0; n]);
            let forces = Lattice { stiffness: LATTICES[WHICH].stiffness, vectors };
            Newton::boxed(forces, H_OF_LATTICE, field(SIDE))
        },
    }
}

pub(crate) fn cases() -> Vec<Case> {
    let chain = Case {
        problem: "stiff",
        scheme: "chain",
        n: 1024,
        steps: 20,
        is_counted: true,
        tolerance: 1e-11,
        generated: |n| generated::<_, Midpoint>(&FPUT, H, waves(n), vec![0.0; n]),
        by_hand: |n| Newton::boxed(Chain { above: vec![0.0; n] }, H, waves(n)),
    };
    vec![
        chain,
        lattice::<0>("kh2=1"),
        lattice::<1>("kh2=1e2"),
        lattice::<2>("kh2=1e4"),
        lattice::<3>("kh2=1e6"),
    ]
}
