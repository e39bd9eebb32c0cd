//! What the scenes of `examples/` rely on, at small sizes: chains, rings, points, lattices and networks whose sums stay
//! loops.

use std::f64::consts::PI;

use fixtures::steps::asymmetry;
use fixtures::stiff::Fput;
use fixtures::wave;
use wzvi::nalgebra::DVector;
use wzvi::prelude::*;

use crate::lattice::Torus;

type Field = State<DVector<f64>>;

/// A few dozen roundings of numbers of order one in each of some ten steps, 1e-14 or so, with room for what the
/// condition of the equations makes of it.
const ROUNDING: f64 = 1e-12;

#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let n = q.len();
        (0..n)
            .map(|i| 0.5 * p[i] * p[i] + 0.5 * k * (q[(i + 1) % n] - q[i]).powi(2) + 0.5 * q[i] * q[i])
            .sum::<f64>()
    },
    noise = [|q, p, k| sigma * q[k]; self.sites],
    embedding = [DeltaPlus, Midpoint],
)]
struct Ring {
    k: f64,
    sigma: f64,
    sites: usize,
}

#[hamiltonian(
    drift = |q: &[[f64; 3]], p: &[[f64; 3]]| {
        let n = q.len();
        let kinetic: f64 = (0..n).map(|i| (0..3).map(|k| p[i][k] * p[i][k]).sum::<f64>() / (2.0 * mass[i])).sum();
        let pairs: f64 = (0..n)
            .map(|i| {
                (0..i)
                    .map(|j| {
                        let square: f64 = (0..3).map(|k| (q[i][k] - q[j][k]).powi(2)).sum();
                        mass[i] * mass[j] / square.sqrt()
                    })
                    .sum::<f64>()
            })
            .sum();
        kinetic - pairs
    },
    embedding = [DeltaPlus, Midpoint],
)]
struct Bodies {
    mass: [f64; 4],
}

#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let kinetic: f64 = p.iter().map(|p| 0.5 * p * p).sum();
        let edges: f64 = (0..self.edges.len())
            .map(|e| self.strength[e] * (1.0 - (q[self.edges[e][0]] - q[self.edges[e][1]]).cos()))
            .sum();
        kinetic + edges
    },
    embedding = [DeltaPlus, Midpoint],
)]
struct Network {
    edges: Vec<[usize; 2]>,
    strength: Vec<f64>,
}

fn network() -> Network {
    let edges = vec![[0, 4], [4, 2], [2, 0], [5, 1], [1, 3], [3, 4]];
    Network { edges, strength: vec![1.0, 0.5, 2.0, 1.5, 0.7, 1.1] }
}

fn bodies() -> (Bodies, Field) {
    let q = vec![1.0, 0.0, 0.1, -1.0, 0.2, 0.0, 0.1, 1.2, -0.3, 0.0, -1.1, 0.4];
    let p = vec![0.0, 0.9, 0.1, 0.1, -1.0, 0.0, -0.4, 0.0, 0.3, 0.5, 0.1, 0.0];
    (Bodies { mass: [1.0, 1.3, 0.6, 0.8] }, State::new(q, p))
}

fn after<H, E>(system: &H, start: &Field, h: f64, steps: usize) -> Field
where
    H: Discretized<E, Vector = DVector<f64>>,
{
    let mut state = start.clone();
    let mut stepper = system.stepper::<E>(h).unwrap();
    let quiet = vec![0.0; system.noises()];
    for _ in 0..steps {
        stepper.step(&mut state, &quiet).unwrap();
    }
    assert!((&state.q - &start.q).amax() > 1e-3, "nothing moved");
    state
}

fn apart(a: &Field, b: &Field) -> f64 {
    (&a.q - &b.q).amax().max((&a.p - &b.p).amax())
}

/// The modes of a linear chain turn by `2 atan(ω h/2)` in a step of `Midpoint`, whatever `ω h`.
#[test]
fn modes_of_a_linear_chain_rotate() {
    const N: usize = 9;
    const STEPS: usize = 10;
    for h in [0.1, 1.0, 10.0] {
        for k in [1, 4, 9] {
            let omega = 2.0 * (0.5 * PI * k as f64 / (N + 1) as f64).sin();
            let shape = |i: usize| (PI * (k * (i + 1)) as f64 / (N + 1) as f64).sin();
            let start = Field::new((0..N).map(shape).collect::<Vec<_>>(), vec![0.0; N]);
            let end = after::<_, Midpoint>(&Fput { alpha: 0.0, beta: 0.0 }, &start, h, STEPS);
            let angle = STEPS as f64 * 2.0 * (0.5 * omega * h).atan();
            for i in 0..N {
                assert!((end.q[i] - shape(i) * angle.cos()).abs() < ROUNDING, "h = {h}, mode {k}");
                assert!((end.p[i] + omega * shape(i) * angle.sin()).abs() < ROUNDING, "h = {h}, mode {k}");
            }
        }
    }
}

/// From rest, the mean energy over all signs of the increments is `σ² h/2 Σ_k 1/(1 + ω_k² h²/4)`.
#[test]
fn pushes_heat_a_ring_as_much_as_the_step_takes_up() {
    const N: usize = 6;
    let ring = Ring { k: 1.7, sigma: 0.8, sites: N };
    for h in [0.1_f64, 0.5, 3.0] {
        let mut mean = 0.0;
        for signs in 0_u32..1 << N {
            let dw: Vec<f64> =
                (0..N).map(|k| if signs >> k & 1 == 0 { h.sqrt() } else { -h.sqrt() }).collect();
            let mut state = Field::new(vec![0.0; N], vec![0.0; N]);
            ring.stepper::<Midpoint>(h).unwrap().step(&mut state, &dw).unwrap();
            mean += ring.energy(&state) / f64::from(1_u32 << N);
        }
        let part = |k: usize| {
            let square = 1.0 + 4.0 * ring.k * (PI * k as f64 / N as f64).sin().powi(2);
            1.0 / (1.0 + 0.25 * h * h * square)
        };
        let expected = 0.5 * ring.sigma.powi(2) * h * (0..N).map(part).sum::<f64>();
        assert!((mean / expected - 1.0).abs() < ROUNDING, "h = {h}: {mean} {expected}");
    }
}

/// A torus has no beginning: shifted fields take shifted steps.
#[test]
fn a_torus_looks_the_same_from_every_site() {
    let torus = Torus::square(5, 1.0);
    let shifted =
        |x: &[f64]| -> Vec<f64> { (0..25).map(|n| x[(n / 5 + 2) % 5 * 5 + (n % 5 + 3) % 5]).collect() };
    let start = Field::new(wave(25, 0.9, 0.1), wave(25, 0.4, 2.0));
    let moved = Field::new(shifted(start.q.as_slice()), shifted(start.p.as_slice()));
    for h in [0.05, 1.0] {
        let there = after::<_, Midpoint>(&torus, &start, h, 5);
        let here = after::<_, Midpoint>(&torus, &moved, h, 5);
        let there = Field::new(shifted(there.q.as_slice()), shifted(there.p.as_slice())).at(there.t);
        assert!(apart(&there, &here) < ROUNDING, "h = {h}: {}", apart(&there, &here));
    }
}

#[test]
fn steps_of_points_lattices_and_networks_are_symplectic() {
    fn check<H: Discretized<Midpoint> + Discretized<DeltaPlus>>(system: &H, start: [&[f64]; 2], h: f64) {
        assert!(asymmetry::<Midpoint, _>(system, start, [0.0, h], &[], 1.0) < ROUNDING);
        assert!(asymmetry::<DeltaPlus, _>(system, start, [0.0, h], &[], 1.0) < ROUNDING);
    }
    let (system, start) = bodies();
    check(&system, [start.q.as_slice(), start.p.as_slice()], 0.05);
    for h in [0.1, 1.0] {
        check(&Torus::square(3, 1.0), [&wave(9, 0.9, 0.2), &wave(9, 0.5, 1.0)], h);
    }
    for h in [0.1, 1.5] {
        check(&network(), [&wave(6, 1.1, 0.2), &wave(6, 0.5, 1.0)], h);
    }
}

#[hamiltonian(
    drift = |q: &[[f64; 3]], p: &[[f64; 3]]| {
        let n = q.len();
        let kinetic: f64 = p.iter().map(|p| 0.5 * (p[0] * p[0] + p[1] * p[1] + p[2] * p[2])).sum();
        let pairs: f64 = (0..n)
            .map(|i| {
                (0..i)
                    .map(|j| {
                        let square: f64 = (0..3).map(|k| (q[i][k] - q[j][k]).powi(2)).sum();
                        let attraction = 1.0 / (square * square * square);
                        4.0 * attraction * (attraction - 1.0)
                    })
                    .sum::<f64>()
            })
            .sum();
        kinetic + pairs
    },
    embedding = Midpoint,
)]
struct LennardJones;

/// Energies of the Cambridge Cluster Database for 2, 3, 4 and 13 atoms.
#[test]
fn clusters_have_the_energies_of_the_literature() {
    let edge = 2.0_f64.powf(1.0 / 6.0);
    let tetrahedron = [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]];
    for (atoms, known) in [(2, -1.0), (3, -3.0), (4, -6.0)] {
        let q: Vec<f64> = tetrahedron[..atoms].iter().flatten().map(|x| x * edge / 2.0_f64.sqrt()).collect();
        let state = Field::new(q, vec![0.0; 3 * atoms]);
        assert!((LennardJones.energy(&state) - known).abs() < ROUNDING);
        assert!(LennardJones.energy_gradient(&state).q.amax() < ROUNDING);
    }
    let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
    let mut q = vec![0.0; 3];
    for a in [-1.0, 1.0] {
        for b in [-golden, golden] {
            q.extend([[0.0, a, b], [a, b, 0.0], [b, 0.0, a]].into_iter().flatten());
        }
    }
    let places: Vec<&[f64]> = q.chunks_exact(3).collect();
    let sum = |power: i32| -> f64 {
        let square =
            |i: usize, j: usize| -> f64 { (0..3).map(|k| (places[i][k] - places[j][k]).powi(2)).sum() };
        (0..13).flat_map(|i| (0..i).map(move |j| (i, j))).map(|(i, j)| square(i, j).powi(-power)).sum()
    };
    // E(s) = 4 (s^-12 Σ r^-12 - s^-6 Σ r^-6) is least at s⁶ = 2 Σ r^-12 / Σ r^-6.
    let scale = (2.0 * sum(6) / sum(3)).powf(1.0 / 6.0);
    let state = Field::new(q.iter().map(|x| scale * x).collect::<Vec<_>>(), vec![0.0; 39]);
    // As many digits as are printed.
    assert!((LennardJones.energy(&state) + 44.326801).abs() < 5e-7);
    // Slopes are sums of 78 terms up to 50.
    assert!(LennardJones.energy_gradient(&state).q.amax() < ROUNDING);
}
