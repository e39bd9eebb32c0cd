//! The systems, and their forces as one writes them by hand.

use std::f64::consts::{PI, TAU};

use wzvi::prelude::*;

/// A system in both ways to write it.
pub(crate) trait System: Hamiltonian {
    const NAME: &'static str;
    /// What times are divided by, and how many of them there are for so many degrees of freedom.
    const UNIT: &'static str = "site";
    const H: f64;

    fn units(degrees: usize) -> usize {
        degrees
    }

    /// Coordinates and momenta at the start of a path; all paths of an ensemble start close to each other.
    fn start(degrees: usize, path: usize) -> [Vec<f64>; 2];
}

/// `force = -V'(q)` by hand.
pub(crate) trait Forces {
    fn pull(&self, q: &[f64], force: &mut [f64]);
}

/// A wave along the sites, at rest.
fn wave(sites: usize, path: usize) -> [Vec<f64>; 2] {
    let amplitude = 0.3 + 1e-4 * path as f64;
    let site = |i: usize| 1.0 + amplitude * (TAU * i as f64 / sites as f64).sin();
    [(0..sites).map(site).collect(), vec![0.0; sites]]
}

/// Coupled pendulums around a ring.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let n = q.len();
        p.iter().map(|p| 0.5 * p * p).sum::<f64>()
            + (0..n).map(|i| 0.5 * (q[(i + 1) % n] - q[i]).powi(2) + k * (1.0 - q[i].cos())).sum::<f64>()
    },
    embedding = [Verlet, Midpoint, Gauss<4>, Gauss<8>],
)]
pub(crate) struct Ring {
    pub(crate) k: f64,
}

impl System for Ring {
    const NAME: &'static str = "ring";
    const H: f64 = 0.05;

    fn start(degrees: usize, path: usize) -> [Vec<f64>; 2] {
        wave(degrees, path)
    }
}

impl Ring {
    #[inline(always)]
    fn force(&self, left: f64, own: f64, right: f64) -> f64 {
        (right - own) - (own - left) - self.k * own.sin()
    }
}

impl Forces for Ring {
    #[inline(always)]
    fn pull(&self, q: &[f64], force: &mut [f64]) {
        let last = q.len() - 1;
        force[0] = self.force(q[last], q[0], q[1]);
        for (force, window) in force[1..last].iter_mut().zip(q.windows(3)) {
            *force = self.force(window[0], window[1], window[2]);
        }
        force[last] = self.force(q[last - 1], q[last], q[0]);
    }
}

/// A Fermi-Pasta-Ulam-Tsingou chain between walls.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let v = |d: f64| 0.5 * d * d + 0.25 * beta * d.powi(4);
        let n = q.len();
        p.iter().map(|p| 0.5 * p * p).sum::<f64>()
            + (1..n).map(|i| v(q[i] - q[i - 1])).sum::<f64>()
            + v(q[0]) + v(q[n - 1])
    },
    embedding = [Verlet, Midpoint, Gauss<4>, Gauss<8>],
)]
pub(crate) struct Chain {
    pub(crate) beta: f64,
}

impl System for Chain {
    const NAME: &'static str = "chain";
    const H: f64 = 0.05;

    fn start(degrees: usize, path: usize) -> [Vec<f64>; 2] {
        let amplitude = 1.0 + 1e-4 * path as f64;
        let mode = |i: usize| amplitude * (PI * (i + 1) as f64 / (degrees + 1) as f64).sin();
        [(0..degrees).map(mode).collect(), vec![0.0; degrees]]
    }
}

impl Chain {
    #[inline(always)]
    fn bond(&self, d: f64) -> f64 {
        d * (1.0 + self.beta * d * d)
    }
}

impl Forces for Chain {
    #[inline(always)]
    fn pull(&self, q: &[f64], force: &mut [f64]) {
        let last = q.len() - 1;
        force[0] = self.bond(q[1] - q[0]) - self.bond(q[0]);
        for (force, window) in force[1..last].iter_mut().zip(q.windows(3)) {
            *force = self.bond(window[2] - window[1]) - self.bond(window[1] - window[0]);
        }
        force[last] = self.bond(-q[last]) - self.bond(q[last] - q[last - 1]);
    }
}

/// The field φ⁴ on a torus.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let kinetic: f64 = p.iter().map(|p| 0.5 * p * p).sum();
        let potential: f64 = (0..side)
            .map(|i| {
                (0..side)
                    .map(|j| {
                        let own = q[i * side + j];
                        let right = q[i * side + (j + 1) % side];
                        let down = q[(i + 1) % side * side + j];
                        let bonds = (right - own) * (right - own) + (down - own) * (down - own);
                        let well = own * own - 1.0;
                        0.5 * bonds + 0.25 * well * well
                    })
                    .sum::<f64>()
            })
            .sum();
        kinetic + potential
    },
    embedding = [Verlet, Midpoint, Gauss<4>, Gauss<8>],
)]
pub(crate) struct Lattice {
    pub(crate) side: usize,
}

impl System for Lattice {
    const NAME: &'static str = "lattice";
    const H: f64 = 0.05;

    fn start(degrees: usize, path: usize) -> [Vec<f64>; 2] {
        let side = degrees.isqrt();
        let (turn, amplitude) = (TAU / side as f64, 0.3 + 1e-4 * path as f64);
        let site = |k: usize| (turn * (k / side) as f64).sin() * (2.0 * turn * (k % side) as f64).cos();
        [(0..degrees).map(|k| 1.0 + amplitude * site(k)).collect(), vec![0.0; degrees]]
    }
}

impl Lattice {
    #[inline(always)]
    fn force(own: f64, [left, right, up, down]: [f64; 4]) -> f64 {
        (left - own) + (right - own) + (up - own) + (down - own) - own * (own * own - 1.0)
    }
}

impl Forces for Lattice {
    #[inline(always)]
    fn pull(&self, q: &[f64], force: &mut [f64]) {
        let (side, last) = (self.side, self.side - 1);
        for (i, force) in force.chunks_exact_mut(side).enumerate() {
            let before = if i == 0 { last } else { i - 1 };
            let after = if i == last { 0 } else { i + 1 };
            let (up, own, down) =
                (&q[before * side..][..side], &q[i * side..][..side], &q[after * side..][..side]);
            force[0] = Self::force(own[0], [own[last], own[1], up[0], down[0]]);
            let inner = force[1..last].iter_mut().zip(own.windows(3)).zip(up[1..].iter().zip(&down[1..]));
            for ((force, own), (up, down)) in inner {
                *force = Self::force(own[1], [own[0], own[2], *up, *down]);
            }
            force[last] = Self::force(own[last], [own[last - 1], own[0], up[last], down[last]]);
        }
    }
}

/// Gravity between all pairs, softened.
#[hamiltonian(
    drift = |q: &[[f64; 3]], p: &[[f64; 3]]| {
        let n = q.len();
        let kinetic: f64 = p.iter().map(|p| 0.5 * (p[0] * p[0] + p[1] * p[1] + p[2] * p[2])).sum();
        let pairs: f64 = (0..n)
            .map(|i| {
                (0..i)
                    .map(|j| {
                        let [x, y, z] = [q[i][0] - q[j][0], q[i][1] - q[j][1], q[i][2] - q[j][2]];
                        g / (x * x + y * y + z * z + softening).sqrt()
                    })
                    .sum::<f64>()
            })
            .sum();
        kinetic - pairs
    },
    embedding = [Verlet, Midpoint, Gauss<4>, Gauss<8>],
)]
pub(crate) struct Bodies {
    pub(crate) g: f64,
    /// Square of a length.
    pub(crate) softening: f64,
}

impl System for Bodies {
    const NAME: &'static str = "all pairs";
    const UNIT: &'static str = "pair";
    const H: f64 = 0.01;

    fn units(degrees: usize) -> usize {
        let bodies = degrees / 3;
        bodies * (bodies - 1) / 2
    }

    /// Points that fill a ball evenly, at rest: spirals of the golden angle on shells.
    fn start(degrees: usize, path: usize) -> [Vec<f64>; 2] {
        let bodies = degrees / 3;
        let body = |i: usize| {
            let part = (i as f64 + 0.5) / bodies as f64;
            let (height, angle) = (1.0 - 2.0 * part, 2.399_963 * i as f64 + 1e-4 * path as f64);
            let (radius, across) = (2.0 + (7.1 * i as f64).sin(), (1.0 - height * height).sqrt());
            [radius * across * angle.cos(), radius * across * angle.sin(), radius * height]
        };
        [(0..bodies).flat_map(body).collect(), vec![0.0; degrees]]
    }
}

impl Forces for Bodies {
    #[inline(always)]
    fn pull(&self, q: &[f64], force: &mut [f64]) {
        force.fill(0.0);
        let (points, _) = q.as_chunks::<3>();
        let (forces, _) = force.as_chunks_mut::<3>();
        for (i, &[x, y, z]) in points.iter().enumerate() {
            let (others, own) = forces.split_at_mut(i);
            let mut sum = [0.0; 3];
            for (&[a, b, c], other) in points.iter().zip(others) {
                let [dx, dy, dz] = [x - a, y - b, z - c];
                let square = dx * dx + dy * dy + dz * dz + self.softening;
                let pull = self.g / (square * square.sqrt());
                for (k, d) in [dx, dy, dz].into_iter().enumerate() {
                    sum[k] += pull * d;
                    other[k] += pull * d;
                }
            }
            for k in 0..3 {
                own[0][k] -= sum[k];
            }
        }
    }
}

/// Rotors that feel their magnetisation.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let n = q.len() as f64;
        let c = q.iter().map(|q| q.cos()).sum::<f64>();
        let s = q.iter().map(|q| q.sin()).sum::<f64>();
        p.iter().map(|p| 0.5 * p * p).sum::<f64>() - 0.5 * coupling / n * (c * c + s * s)
    },
    embedding = [Verlet, Midpoint, Gauss<4>, Gauss<8>],
)]
pub(crate) struct Rotors {
    pub(crate) coupling: f64,
}

impl System for Rotors {
    const NAME: &'static str = "mean field";
    const H: f64 = 0.05;

    fn start(degrees: usize, path: usize) -> [Vec<f64>; 2] {
        let angle = |i: usize| (1.7 * i as f64).sin() + 1e-4 * path as f64;
        [(0..degrees).map(angle).collect(), vec![0.0; degrees]]
    }
}

/// Sites whose sines and cosines are kept from the sums to the forces.
const MOST_ROTORS: usize = 1024;

impl Forces for Rotors {
    #[inline(always)]
    fn pull(&self, q: &[f64], force: &mut [f64]) {
        let mut functions = [(0.0, 0.0); MOST_ROTORS];
        let (mut c, mut s) = (0.0, 0.0);
        for (functions, q) in functions.iter_mut().zip(q) {
            *functions = q.sin_cos();
            (s, c) = (s + functions.0, c + functions.1);
        }
        let scale = self.coupling / q.len() as f64;
        let (s, c) = (scale * s, scale * c);
        for (force, (sin, cos)) in force.iter_mut().zip(&functions) {
            *force = s * cos - c * sin;
        }
    }
}

/// Degrees of freedom of the condensate.
pub(crate) const WELLS: usize = 22;

/// A Bose-Einstein condensate in a ring of wells, `ψ = (q + ip)/√2`: no sum of a kinetic and a potential
/// energy.
#[hamiltonian(
    drift = |q: [f64; 22], p: [f64; 22]| {
        (0..22)
            .map(|i| {
                let (next, density) = ((i + 1) % 22, 0.5 * (q[i] * q[i] + p[i] * p[i]));
                0.5 * u * density * density - j * (q[i] * q[next] + p[i] * p[next])
            })
            .sum::<f64>()
    },
    embedding = [Midpoint, Gauss<4>, Gauss<8>],
)]
pub(crate) struct Condensate {
    pub(crate) u: f64,
    pub(crate) j: f64,
}

impl Condensate {
    /// `dH/dx_i`, where `y` are the coordinates if `x` are the momenta, and the other way around.
    #[inline(always)]
    fn slope(&self, x: &[f64; WELLS], y: &[f64; WELLS], i: usize, [before, after]: [usize; 2]) -> f64 {
        0.5 * self.u * (x[i] * x[i] + y[i] * y[i]) * x[i] - self.j * (x[before] + x[after])
    }

    /// `(H_p, -H_q)` at coordinates and momenta.
    #[inline(always)]
    pub(crate) fn slopes(&self, [q, p]: &[[f64; WELLS]; 2], slopes: &mut [[f64; WELLS]; 2]) {
        for i in 1..WELLS - 1 {
            slopes[0][i] = self.slope(p, q, i, [i - 1, i + 1]);
            slopes[1][i] = -self.slope(q, p, i, [i - 1, i + 1]);
        }
        for (i, neighbours) in [(0, [WELLS - 1, 1]), (WELLS - 1, [WELLS - 2, 0])] {
            slopes[0][i] = self.slope(p, q, i, neighbours);
            slopes[1][i] = -self.slope(q, p, i, neighbours);
        }
    }
}

impl System for Condensate {
    const NAME: &'static str = "22 degrees, not separable";
    const UNIT: &'static str = "degree";
    const H: f64 = 0.02;

    fn start(degrees: usize, path: usize) -> [Vec<f64>; 2] {
        let [q, _] = wave(degrees, path);
        [q, (0..degrees).map(|i| 0.2 * (1.7 * i as f64 + 1e-4 * path as f64).sin()).collect()]
    }
}
