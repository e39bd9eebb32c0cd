//! Large systems are stepped tile by tile, in vector instructions: their bits are those of one pass over all sites, number
//! by number, on any number of threads.
//!
//! The reference is the same generated step on [`Lanes<1>`], which takes no tiles and no vector registers. Nothing is
//! compared but for equality.

use wzvi::error::{ConfigError, Error};
use wzvi::lanes::Lanes;
use wzvi::nalgebra::DVector;
use wzvi::prelude::*;
use wzvi::simulate::Simulation;
use wzvi::system::{Scheme, SchemeOf, StepArguments};

use crate::lattice::Torus;
use crate::one_by_one::{H, check, check_others, check_scheme, numbers};

/// Springs to both walls, and between sites one to three apart.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let v = |d: f64| 0.5 * d * d + 0.25 * beta * d.powi(4);
        let n = q.len();
        p.iter().map(|p| 0.5 * p * p).sum::<f64>()
            + (1..n).map(|i| v(q[i] - q[i - 1])).sum::<f64>()
            + (2..n).map(|i| 0.1 * v(q[i] - q[i - 2])).sum::<f64>()
            + (0..n - 3).map(|i| 0.03 * v(q[i] - q[i + 3])).sum::<f64>()
            + (0..n - 2).map(|i| 0.2 * v(q[i] - 2.0 * q[i + 1] + q[i + 2] * q[i])).sum::<f64>()
            + v(q[0]) + v(q[n - 1])
    },
    embedding = [DeltaPlus, DeltaMinus, Verlet],
)]
struct Chain {
    beta: f64,
}

/// A ring of pendulums, which has functions, with neighbours up to three sites apart.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let n = q.len();
        p.iter().map(|p| 0.5 * p * p).sum::<f64>()
            + (0..n).map(|i| 0.5 * k * (q[(i + 1) % n] - q[i]).powi(2) - q[i].cos()).sum::<f64>()
            + (0..n).map(|i| 0.1 * (q[(i + 3) % n] - q[(i + 1) % n]).sin() * q[i]).sum::<f64>()
    },
    embedding = [DeltaPlus, DeltaMinus, Verlet],
)]
struct SineGordon {
    k: f64,
}

/// Masses and springs by site, and a kick by a noise of its own at each.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        (0..p.len()).map(|i| p[i] * p[i] / (2.0 * self.mass[i])).sum::<f64>()
            + (1..q.len()).map(|i| self.spring[i] * (q[i] - q[i - 1]).exp()).sum::<f64>()
    },
    noise = [|q, p, k| 0.3 * q[k] + 0.1 * q[k] * q[k]; self.mass.len()],
    embedding = [DeltaPlus, DeltaMinus, Verlet],
)]
struct Kicked {
    mass: Vec<f64>,
    spring: Vec<f64>,
}

/// Angles on a box with open faces, and momenta in the same loops.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        (0..nx)
            .map(|i| {
                (0..ny)
                    .map(|j| {
                        (0..nz)
                            .map(|k| {
                                let own = q[(i * ny + j) * nz + k];
                                0.5 * p[(i * ny + j) * nz + k] * p[(i * ny + j) * nz + k]
                                    + 0.25 * own * own * own * own
                            })
                            .sum::<f64>()
                    })
                    .sum::<f64>()
            })
            .sum::<f64>()
            - (0..nx - 1)
                .map(|i| (0..ny * nz).map(|k| (q[(i + 1) * ny * nz + k] - q[i * ny * nz + k]).cos()).sum::<f64>())
                .sum::<f64>()
    },
    embedding = [DeltaPlus, DeltaMinus, Verlet],
)]
struct Block {
    nx: usize,
    ny: usize,
    nz: usize,
}

/// A ring of points in the plane with springs and a substrate.
#[hamiltonian(
    drift = |q: &[[f64; 2]], p: &[[f64; 2]]| {
        let n = q.len();
        p.iter().map(|p| 0.5 * (p[0] * p[0] + p[1] * p[1])).sum::<f64>()
            + (0..n)
                .map(|i| {
                    let next = q[(i + 1) % n];
                    let [x, y] = [next[0] - q[i][0], next[1] - q[i][1]];
                    0.5 * k * ((x * x + y * y + 1.0).sqrt() - 1.0).powi(2) - q[i][0].cos()
                })
                .sum::<f64>()
    },
    embedding = [DeltaPlus, Verlet],
)]
struct Necklace {
    k: f64,
}

/// A chain of points in space, with bonds to the next and to the second next, and an end that is held.
#[hamiltonian(
    drift = |q: &[[f64; 3]], p: &[[f64; 3]]| {
        let n = q.len();
        let bond = |x: f64, y: f64, z: f64| {
            let square = x * x + y * y + z * z;
            0.5 * square + 0.25 * beta * square * square
        };
        (0..n).map(|i| 0.5 * (p[i][0] * p[i][0] + p[i][1] * p[i][1] + 2.0 * p[i][2] * p[i][2])).sum::<f64>()
            + (1..n).map(|i| bond(q[i][0] - q[i - 1][0], q[i][1] - q[i - 1][1], q[i][2] - q[i - 1][2])).sum::<f64>()
            + (0..n - 2)
                .map(|i| 0.1 * bond(q[i + 2][0] - q[i][0], q[i + 2][1] - q[i][1], 0.5 * (q[i + 2][2] - q[i][2])))
                .sum::<f64>()
            + bond(q[0][0], q[0][1], q[0][2])
    },
    embedding = [DeltaPlus, Verlet],
)]
struct Polymer {
    beta: f64,
}

/// A sheet of points in space.
#[hamiltonian(
    drift = |q: &[[f64; 3]], p: &[[f64; 3]]| {
        p.iter().map(|p| 0.5 * (p[0] * p[0] + p[1] * p[1])).sum::<f64>()
            + p.iter().map(|p| 0.25 * p[2] * p[2]).sum::<f64>()
            + (0..rows)
                .map(|i| {
                    (0..columns)
                        .map(|j| {
                            let [own, right] = [q[i * columns + j], q[i * columns + (j + 1) % columns]];
                            let down = q[(i + 1) % rows * columns + j];
                            let square = |a: f64| a * a;
                            0.5 * (square(right[0] - own[0]) + square(right[1] - own[1]) + square(right[2] - own[2]))
                                + 0.3 * (square(down[0] - own[0]) + square(down[1] - own[1]) * square(down[2] - own[2]))
                        })
                        .sum::<f64>()
                })
                .sum::<f64>()
    },
    embedding = [DeltaPlus, Verlet],
)]
struct Sheet {
    rows: usize,
    columns: usize,
}

/// A chain in a bath, of masses that are not the same.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let n = q.len();
        (0..n).map(|i| p[i] * p[i] / (2.0 * self.mass[i])).sum::<f64>()
            + (0..n).map(|i| 0.5 * k * (q[(i + 1) % n] - q[i]).powi(2) - k * q[i].cos()).sum::<f64>()
    },
    friction = gamma,
    temperature = kt,
    embedding = [Baoab, Obabo],
)]
struct Bathed {
    k: f64,
    gamma: f64,
    kt: f64,
    mass: Vec<f64>,
}

impl Bathed {
    fn of(n: usize, k: f64) -> Self {
        Self { k, gamma: 1.3, kt: 0.7, mass: (0..n).map(|i| 1.0 + 0.2 * (i % 7) as f64).collect() }
    }
}

/// The same with a noise that kicks, in the bath.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        p.iter().map(|p| 0.5 * p * p).sum::<f64>()
            + (1..q.len()).map(|i| 0.5 * (q[i] - q[i - 1]).powi(2)).sum::<f64>()
    },
    noise = [|q, p, k| 0.3 * q[k]; self.sites],
    friction = gamma,
    temperature = kt,
    embedding = [Baoab, Obabo],
)]
struct Shaken {
    sites: usize,
    gamma: f64,
    kt: f64,
}

/// Particles without forces.
#[hamiltonian(drift = |q: &[f64], p: &[f64]| p.iter().map(|p| 0.5 * p * p).sum::<f64>() + 0.0 * q[0], embedding = [DeltaPlus, DeltaMinus, Verlet])]
struct Free;

/// On how many threads besides one.
const THREADS: [usize; 2] = [2, 5];

/// To the last bit.
fn are_same(a: &State<DVector<f64>>, b: &State<DVector<f64>>) -> bool {
    let numbers = |state: &State<DVector<f64>>| {
        state.q.iter().chain(&state.p).map(|number| number.to_bits()).collect::<Vec<_>>()
    };
    numbers(a) == numbers(b)
}

/// Tables that begin with a kick, and with a drift.
fn check_tables<H>(system: &H, n: usize, what: &str)
where
    H: Hamiltonian<Vector = DVector<f64>>
        + Discretized<DeltaMinus>
        + Discretized<Composed<Verlet, Yoshida4>>
        + Discretized<Composed<Verlet, BlanesMoan4>>,
{
    check_others(system, n, what);
    let start = [numbers(n, 0.2), numbers(n, 1.1)];
    check_scheme::<Composed<Verlet, BlanesMoan4>, H>(system, &start, H, &format!("{what}, BlanesMoan4"));
}

/// Below and above the width of registers, the size from which tiles are taken, and that of tiles.
fn sizes() -> impl Iterator<Item = usize> {
    (3..20).chain(94..98).chain([128, 511, 512, 513, 1024, 1025, 1500])
}

#[test]
fn chains_have_the_bits_of_one_pass() {
    for n in sizes() {
        check(&Chain { beta: 0.25 }, n, "chain");
        check_tables(&Chain { beta: 0.25 }, n, "chain");
        check(&SineGordon { k: 0.7 }, n, "ring");
        check_others(&SineGordon { k: 0.7 }, n, "ring");
        let (mass, spring) = ((0..n).map(|i| 1.0 + 0.1 * i as f64).collect(), numbers(n, 2.0));
        let kicked = Kicked { mass, spring };
        check(&kicked, n, "kicked");
        check_others(&kicked, n, "kicked");
    }
}

#[test]
fn points_have_the_bits_of_one_pass() {
    for n in sizes() {
        check(&Necklace { k: 0.7 }, 2 * n, "necklace");
        check(&Polymer { beta: 0.25 }, 3 * n, "polymer");
    }
    for (rows, columns) in [(2, 3), (9, 11), (1, 300), (300, 1), (31, 33), (5, 400), (60, 13)] {
        check(&Sheet { rows, columns }, 3 * rows * columns, "sheet");
    }
}

#[test]
fn chains_in_baths_have_the_bits_of_one_pass() {
    for n in sizes() {
        let (bathed, shaken) = (Bathed::of(n, 0.7), Shaken { sites: n, gamma: 0.8, kt: 0.5 });
        let start = [numbers(n, 0.2), numbers(n, 1.1)];
        check_scheme::<Baoab, _>(&bathed, &start, H, "bathed, Baoab");
        check_scheme::<Obabo, _>(&bathed, &start, H, "bathed, Obabo");
        check_scheme::<Baoab, _>(&shaken, &start, H, "shaken, Baoab");
        check_scheme::<Obabo, _>(&shaken, &start, H, "shaken, Obabo");
    }
}

/// Steps with compensated sums on several threads, and number by number in one pass: equal bits, after a step that fails, too.
fn check_compensated<E, S: Discretized<E, Vector = DVector<f64>>>(system: &S, n: usize, what: &str) {
    type One = Lanes<1>;
    let alone = |list: &[f64]| -> Vec<One> { list.iter().map(|&x| One::new([x])).collect() };
    let (q, p) = (numbers(n, 0.2), numbers(n, 1.1));
    let (mut own_q, mut own_p, prepared) = (alone(&q), alone(&p), system.prepare(H).unwrap());
    let mut memory = <SchemeOf<S, E> as Scheme<S>>::Memory::<One>::default();
    let mut carry = <SchemeOf<S, E> as Scheme<S>>::CompensatedSum::<One>::default();
    let stepper = |threads| system.stepper::<E>(H).unwrap().compensated().threads(threads).unwrap();
    let mut runs = [1, 2, 5].map(|threads| (stepper(threads), State::new(q.clone(), p.clone())));
    for step in 0..6 {
        let dw: Vec<f64> =
            numbers(system.increments(n), 0.7 * f64::from(step)).iter().map(|x| 0.1 * x).collect();
        let (own_dw, t) = (alone(&dw), H * f64::from(step));
        let at = StepArguments { t, h: H, q: &mut own_q[..], p: &mut own_p[..], dw: &own_dw };
        SchemeOf::<S, E>::advance::<f64, One, _, false>(system, &prepared, at, &mut memory, &mut carry)
            .unwrap();
        for (stepper, state) in &mut runs {
            // Too much for the kicks; in a bath it is finite.
            if system.noises() == dw.len() && !dw.is_empty() {
                assert!(stepper.step(state, &vec![1e308; dw.len()]).is_err(), "{what}");
            }
            stepper.step(state, &dw).unwrap();
            for (i, (a, b)) in state.q.iter().chain(&state.p).zip(own_q.iter().chain(&own_p)).enumerate() {
                assert_eq!(a.to_bits(), b[0].to_bits(), "{what}: number {i} of {n} after step {step}");
            }
        }
        let exchanged: Vec<_> = runs.iter().map(|(stepper, _)| stepper.exchanged()).collect();
        assert!(exchanged.iter().all(|of| *of == exchanged[0]), "{what}: {exchanged:?}");
    }
}

#[test]
fn compensated_steps_have_the_bits_of_one_pass() {
    for n in [95, 96, 700, 1500] {
        check_compensated::<Verlet, _>(&Chain { beta: 0.25 }, n, "chain, Verlet");
        check_compensated::<Composed<Verlet, Yoshida4>, _>(&Chain { beta: 0.25 }, n, "chain, Yoshida4");
        check_compensated::<Verlet, _>(&SineGordon { k: 0.7 }, n, "ring, Verlet");
        let (mass, spring) = ((0..n).map(|i| 1.0 + 0.1 * i as f64).collect(), numbers(n, 2.0));
        check_compensated::<Verlet, _>(&Kicked { mass, spring }, n, "kicked, Verlet");
        let (bathed, shaken) = (Bathed::of(n, 0.7), Shaken { sites: n, gamma: 0.8, kt: 0.5 });
        check_compensated::<Baoab, _>(&bathed, n, "bathed, Baoab");
        check_compensated::<Obabo, _>(&bathed, n, "bathed, Obabo");
        check_compensated::<Baoab, _>(&shaken, n, "shaken, Baoab");
    }
}

/// Free particles lose a tenth of a rounding unit in each step: plain sums stay where they are.
#[test]
fn compensated_steps_add_what_rounding_takes() {
    fn check<E>()
    where
        Free: Discretized<E, Vector = DVector<f64>>,
    {
        for n in [2, 96, 1500] {
            let (mut state, p) = (State::new(vec![1.0; n], vec![0.1 * f64::EPSILON; n]), f64::EPSILON);
            let mut stepper = Free.stepper::<E>(1.0).unwrap().compensated();
            for _ in 0..1000 {
                stepper.step(&mut state, &[]).unwrap();
            }
            assert!(state.q.iter().all(|q| (q - 1.0 - 100.0 * p).abs() <= 0.5 * p), "{n}: {:e}", state.q[0]);
        }
    }
    check::<DeltaPlus>();
    check::<DeltaMinus>();
    check::<Verlet>();
}

/// Without a potential the heat is all that the energy gains.
fn check_heat<E>()
where
    Bathed: Discretized<E, Vector = DVector<f64>>,
{
    // Steps of sites far away, where vectorised cosines end, are taken twice.
    for (n, far) in [3, 100, 600, 1500].into_iter().flat_map(|n| [(n, 0.0), (n, 1e9)]) {
        let bathed = Bathed::of(n, 0.0);
        let mut state = State::new(numbers(n, 0.2), numbers(n, 1.1));
        state.q[n / 2] += far;
        let (before, mut stepper) = (bathed.energy(&state), bathed.stepper::<E>(H).unwrap());
        for step in 0..3 {
            let dw = numbers(bathed.increments(n), 0.7 * f64::from(step));
            stepper.step(&mut state, &dw).unwrap();
        }
        let (gain, heat) = (bathed.energy(&state) - before, stepper.exchanged().heat);
        // The rounding of sums of so many terms of order one.
        assert!((gain - heat).abs() < 1e-14 * n as f64, "{n} sites, {far} away: {gain} by {heat}");
    }
}

#[test]
fn heat_is_what_the_energy_gains() {
    check_heat::<Baoab>();
    check_heat::<Obabo>();
}

#[test]
fn lattices_have_the_bits_of_one_pass() {
    let sides = [(1, 1), (2, 3), (9, 11), (11, 9), (1, 700), (700, 1), (31, 33), (5, 300), (60, 13)];
    for (rows, columns) in sides {
        let n = rows * columns;
        check(&Torus { rows, columns, well: 1.0 }, n, "torus");
        check_tables(&Torus { rows, columns, well: 1.0 }, n, "torus");
    }
    for (nx, ny, nz) in [(2, 1, 1), (5, 5, 5), (3, 20, 30), (20, 3, 30), (20, 30, 3)] {
        let n = nx * ny * nz;
        check(&Block { nx, ny, nz }, n, "block");
        check_others(&Block { nx, ny, nz }, n, "block");
    }
}

#[test]
fn rare_arguments_of_functions_have_the_bits_of_one_pass() {
    for n in [24, 300, 600] {
        let mut q = numbers(n, 0.2);
        // Beyond what the reduction by π/2 in lanes takes.
        q[n / 2 + 1] = 1e9;
        let start = [q, numbers(n, 1.1)];
        check_scheme::<DeltaPlus, _>(&SineGordon { k: 0.7 }, &start, H, "far away");
        check_scheme::<Verlet, _>(&SineGordon { k: 0.7 }, &start, H, "far away");
        // Heats too.
        check_scheme::<Baoab, _>(&Bathed::of(n, 0.7), &start, H, "far away in a bath");
    }
}

fn check_failures<E>()
where
    Chain: Discretized<E, Vector = DVector<f64>>,
{
    for bad in [f64::NAN, f64::INFINITY, 1e200] {
        for (n, place) in [(24, 0), (24, 13), (300, 299), (600, 0), (600, 299), (600, 599), (1600, 1599)] {
            let mut errors = Vec::new();
            for threads in [1].into_iter().chain(THREADS) {
                let (q, p) = (numbers(n, 0.2), numbers(n, 1.1));
                let (mut state, chain) = (State::new(q, p), Chain { beta: 0.25 });
                let fresh_stepper = || chain.stepper::<E>(H).unwrap().threads(threads).unwrap();
                let mut stepper = fresh_stepper();
                stepper.step(&mut state, &[]).unwrap();
                let good = state.clone();
                state.q[place] = bad;
                let before = state.clone();
                errors.push(stepper.step(&mut state, &[]).unwrap_err());
                assert!(are_same(&state, &before), "{bad} at {place} on {threads} threads");
                // What it leaves to the next one is no other than what it was.
                let (mut after, mut fresh) = (good.clone(), good);
                stepper.step(&mut after, &[]).unwrap();
                fresh_stepper().step(&mut fresh, &[]).unwrap();
                assert!(are_same(&after, &fresh), "after {bad} at {place} on {threads} threads");
            }
            assert!(errors.iter().all(|error| *error == errors[0]), "{errors:?}");
        }
    }
}

#[test]
fn a_step_that_fails_changes_nothing() {
    check_failures::<DeltaPlus>();
    check_failures::<Verlet>();
    check_failures::<Composed<Verlet, Yoshida4>>();
}

#[test]
fn as_many_threads_as_pay_have_the_bits_of_one() {
    let n = 270_011;
    let start = || State::new(numbers(n, 0.2), numbers(n, 1.1)).at(0.5);
    let path =
        |run: Simulation<'_, Chain, Verlet>| run.start(start()).steps(2).record_every(0).run().unwrap();
    let chain = Chain { beta: 0.25 };
    let [all, one] = [chain.simulate::<Verlet>(H), chain.simulate::<Verlet>(H).threads(1)].map(path);
    assert!(are_same(all.last(), one.last()));
}

#[test]
fn no_threads_are_refused() {
    let chain = Chain { beta: 0.25 };
    let is_told = |error: &ConfigError| error.to_string().contains("at least 1");
    assert!(chain.stepper::<Verlet>(H).unwrap().threads(0).is_err_and(|error| is_told(&error)));
    let run = chain.simulate::<Verlet>(H).start(State::new(numbers(9, 0.2), numbers(9, 1.1))).steps(1);
    assert!(matches!(run.threads(0).run(), Err(Error::Config(error)) if is_told(&error)));
}
