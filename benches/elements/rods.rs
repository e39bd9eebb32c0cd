//! A chain of rods in the plane that falls from a horizontal line, by RATTLE: constraints that form a tridiagonal matrix.

use wzvi::prelude::*;

use crate::measure::{Case, Runner, generated};

#[hamiltonian(
    drift = |q: &[[f64; 2]], p: &[[f64; 2]]| (0..q.len())
        .map(|i| 0.5 * (p[i][0] * p[i][0] + p[i][1] * p[i][1]) + q[i][1])
        .sum::<f64>(),
    constraint = [
        |q| 0.5 * (q[0][0] * q[0][0] + q[0][1] * q[0][1] - 1.0),
        [|q, k| {
            let (dx, dy) = (q[k + 1][0] - q[k][0], q[k + 1][1] - q[k][1]);
            0.5 * (dx * dx + dy * dy - 1.0)
        }; self.rods - 1],
    ],
    embedding = Rattle,
)]
struct Chain {
    rods: usize,
}

static CHAINS: [Chain; 2] = [Chain { rods: 100 }, Chain { rods: 1000 }];

const H: f64 = 0.002;

/// Joints at `(1, 0), (2, 0), ...`.
fn line(n: usize) -> Vec<f64> {
    (1..=n).flat_map(|i| [i as f64, 0.0]).collect()
}

/// `x += d` with the rounding error of the sum before, which is kept for the next.
fn add(x: &mut f64, d: f64, lost: &mut f64) {
    let y = d + *lost;
    let sum = *x + y;
    *lost = y - (sum - *x);
    *x = sum;
}

/// A matrix of three diagonals.
struct Tridiagonal {
    lower: Vec<f64>,
    diagonal: Vec<f64>,
    upper: Vec<f64>,
    scratch: Vec<f64>,
}

impl Tridiagonal {
    /// `G(at) Gᵀ(rods)` for the rods from joint to joint.
    fn fill(&mut self, at: &[[f64; 2]], rods: &[[f64; 2]]) {
        let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
        let n = at.len();
        for k in 0..n {
            self.diagonal[k] = dot(at[k], rods[k]) * if k > 0 { 2.0 } else { 1.0 };
            self.lower[k] = if k > 0 { -dot(at[k], rods[k - 1]) } else { 0.0 };
            self.upper[k] = if k + 1 < n { -dot(at[k], rods[k + 1]) } else { 0.0 };
        }
    }

    fn solve(&mut self, b: &mut [f64]) {
        let Self { lower, diagonal, upper, scratch } = self;
        let inverse = 1.0 / diagonal[0];
        scratch[0] = upper[0] * inverse;
        b[0] *= inverse;
        for k in 1..b.len() {
            let inverse = 1.0 / (diagonal[k] - lower[k] * scratch[k - 1]);
            scratch[k] = upper[k] * inverse;
            b[k] = (b[k] - lower[k] * b[k - 1]) * inverse;
        }
        for k in (0..b.len() - 1).rev() {
            b[k] -= scratch[k] * b[k + 1];
        }
    }
}

/// The step of `hand_rods.c`.
struct Rods {
    q: Vec<[f64; 2]>,
    p: Vec<[f64; 2]>,
    lost_q: Vec<[f64; 2]>,
    lost_p: Vec<[f64; 2]>,
    end: Vec<[f64; 2]>,
    lost_end: Vec<[f64; 2]>,
    impulse: Vec<[f64; 2]>,
    rod: Vec<[f64; 2]>,
    next: Vec<[f64; 2]>,
    nu: Vec<f64>,
    last: Vec<f64>,
    before: Vec<f64>,
    g: Vec<f64>,
    matrix: Tridiagonal,
    steps: u64,
    iterations: u64,
}

impl Rods {
    fn boxed(n: usize) -> Box<dyn Runner> {
        let (points, zeros) = (|| vec![[0.0; 2]; n], || vec![0.0; n]);
        let matrix = Tridiagonal { lower: zeros(), diagonal: zeros(), upper: zeros(), scratch: zeros() };
        Box::new(Self {
            q: (1..=n).map(|i| [i as f64, 0.0]).collect(),
            p: points(),
            lost_q: points(),
            lost_p: points(),
            end: points(),
            lost_end: points(),
            impulse: points(),
            rod: vec![[1.0, 0.0]; n],
            next: points(),
            nu: zeros(),
            last: zeros(),
            before: zeros(),
            g: zeros(),
            matrix,
            steps: 0,
            iterations: 0,
        })
    }

    /// Half a step of the weight.
    fn fall(&mut self) {
        for (p, lost) in self.p.iter_mut().zip(&mut self.lost_p) {
            add(&mut p[1], -H / 2.0, &mut lost[1]);
        }
    }

    /// The end of the drift with the impulses of `nu`, and the largest residual relative to its terms.
    fn drift(&mut self) -> f64 {
        let n = self.q.len();
        for i in 0..n {
            for x in 0..2 {
                let after = if i + 1 < n { self.rod[i + 1][x] * self.nu[i + 1] } else { 0.0 };
                self.impulse[i][x] = after - self.rod[i][x] * self.nu[i];
                let (mut end, mut lost) = (self.q[i][x], self.lost_q[i][x]);
                add(&mut end, H * (self.p[i][x] + self.impulse[i][x]), &mut lost);
                (self.end[i][x], self.lost_end[i][x]) = (end, lost);
            }
        }
        let mut worst = 0.0;
        for k in 0..n {
            let (mut square, mut size) = (0.0, 0.0);
            for x in 0..2 {
                let before = if k > 0 { [self.q[k - 1][x], self.end[k - 1][x]] } else { [0.0; 2] };
                let d = self.end[k][x] - before[1];
                self.next[k][x] = d;
                square += d * d;
                size +=
                    d.abs() * (self.q[k][x].abs() + self.end[k][x].abs() + before[0].abs() + before[1].abs());
            }
            self.g[k] = 0.5 * (square - 1.0);
            let relative = self.g[k].abs() / size;
            worst = if relative > worst { relative } else { worst };
        }
        worst
    }

    fn step(&mut self) {
        let n = self.q.len();
        self.fall();
        for k in 0..n {
            self.nu[k] = match self.steps {
                0 => 0.0,
                1 => self.last[k],
                _ => 2.0 * self.last[k] - self.before[k],
            };
        }
        while self.drift() > 4.0 * f64::EPSILON {
            self.iterations += 1;
            self.matrix.fill(&self.next, &self.rod);
            self.g.iter_mut().for_each(|g| *g /= H);
            self.matrix.solve(&mut self.g);
            for (nu, g) in self.nu.iter_mut().zip(&self.g) {
                *nu += g;
            }
        }
        self.steps += 1;
        std::mem::swap(&mut self.before, &mut self.last);
        std::mem::swap(&mut self.last, &mut self.nu);
        std::mem::swap(&mut self.q, &mut self.end);
        std::mem::swap(&mut self.lost_q, &mut self.lost_end);
        std::mem::swap(&mut self.rod, &mut self.next);
        for ((p, lost), impulse) in self.p.iter_mut().zip(&mut self.lost_p).zip(&self.impulse) {
            (0..2).for_each(|x| add(&mut p[x], impulse[x], &mut lost[x]));
        }
        self.fall();
        for k in 0..n {
            let before = if k > 0 { self.p[k - 1] } else { [0.0; 2] };
            self.g[k] = (0..2).map(|x| self.rod[k][x] * (self.p[k][x] - before[x])).sum();
        }
        self.matrix.fill(&self.rod, &self.rod);
        self.matrix.solve(&mut self.g);
        for i in 0..n {
            for x in 0..2 {
                let after = if i + 1 < n { self.rod[i + 1][x] * self.g[i + 1] } else { 0.0 };
                add(&mut self.p[i][x], after - self.rod[i][x] * self.g[i], &mut self.lost_p[i][x]);
            }
        }
    }
}

impl Runner for Rods {
    fn run(&mut self, steps: usize) {
        (0..steps).for_each(|_| self.step());
    }
    fn state(&self) -> (Vec<f64>, Vec<f64>) {
        (self.q.as_flattened().to_vec(), self.p.as_flattened().to_vec())
    }
    fn iterations(&self) -> u64 {
        self.iterations
    }
}

pub(crate) fn cases() -> Vec<Case> {
    let hundred = Case {
        problem: "rods",
        scheme: "Rattle",
        n: 100,
        steps: 20,
        is_counted: true,
        // Roundings of coordinates up to 100 in each of 10 steps, and momenta from differences of them over h.
        tolerance: 1e-9,
        generated: |n| generated::<_, Rattle>(&CHAINS[0], H, line(n), vec![0.0; 2 * n]),
        by_hand: Rods::boxed,
    };
    let thousand = Case {
        n: 1000,
        steps: 5,
        tolerance: 1e-8,
        generated: |n| generated::<_, Rattle>(&CHAINS[1], H, line(n), vec![0.0; 2 * n]),
        ..hundred
    };
    vec![hundred, thousand]
}
