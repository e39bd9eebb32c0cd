//! Implicit steps of large systems: the fixed point goes tile by tile in vector instructions, with the bits of one pass over
//! all sites, number by number, and ends where the equations are at the rounding of their own terms, whatever the scale of a site.
//!
//! The reference is the same generated step in `one_by_one`, which takes no tiles and no vector registers.

use fixtures::rounding::{self, Chain};
use wzvi::error::StepError;
use wzvi::nalgebra::DVector;
use wzvi::prelude::*;

use crate::lattice::Torus;
use crate::one_by_one::{check_scheme, numbers};

/// A ring of relativistic pendulums, which has functions of coordinates and of momenta.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let n = q.len();
        p.iter().map(|p| p.cosh()).sum::<f64>()
            + (0..n).map(|i| 0.5 * k * (q[(i + 1) % n] - q[i]).powi(2) - q[i].cos()).sum::<f64>()
    },
    embedding = Midpoint,
)]
struct SineGordon {
    k: f64,
}

/// Masses and springs by site, and a kick by a noise of its own at each.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        (0..p.len()).map(|i| p[i] * p[i] / (2.0 * self.mass[i])).sum::<f64>()
            + (1..q.len()).map(|i| 0.5 * self.spring[i] * (q[i] - q[i - 1]) * (q[i] - q[i - 1])).sum::<f64>()
    },
    noise = [|q, p, k| 0.3 * q[k] + 0.1 * q[k] * q[k]; self.mass.len()],
    embedding = Midpoint,
)]
struct Kicked {
    mass: Vec<f64>,
    spring: Vec<f64>,
}

/// Springs that are not linear, between neighbours.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let v = |d: f64| 0.5 * d * d + 0.25 * d.powi(4);
        p.iter().map(|p| 0.5 * p * p).sum::<f64>()
            + (1..q.len()).map(|i| self.spring[i] * v(q[i] - q[i - 1])).sum::<f64>()
    },
    embedding = Midpoint,
)]
struct Bonds {
    spring: Vec<f64>,
}

/// Sites with no springs between them, kicked by a noise each: linear equations with a diagonal Jacobian.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        (0..p.len()).map(|i| p[i] * p[i] / (2.0 * self.mass[i]) + 0.5 * self.spring[i] * q[i] * q[i]).sum::<f64>()
    },
    noise = [|q, p, k| 0.3 * q[k]; self.mass.len()],
    embedding = [Midpoint, Lambda<1, 4>],
)]
struct Apart {
    mass: Vec<f64>,
    spring: Vec<f64>,
}

/// The same with forces that pairs of neighbours exert, each with its own strength.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        (0..p.len()).map(|i| p[i] * p[i] / (2.0 * self.mass[i]) + 0.5 * self.spring[i] * q[i] * q[i]).sum::<f64>()
            + (1..q.len()).map(|i| self.spring[i] * (q[i] - q[i - 1])).sum::<f64>()
    },
    embedding = Midpoint,
)]
struct Tilted {
    mass: Vec<f64>,
    spring: Vec<f64>,
}

const H: f64 = 0.05;

/// Steps both ways.
fn check<E, H: Discretized<E, Vector = DVector<f64>>>(system: &H, n: usize, what: &str) {
    check_scheme::<E, H>(system, &[numbers(n, 0.2), numbers(n, 1.1)], self::H, what);
}

/// Below and above the width of registers, the size from which tiles are taken, and that of tiles.
fn sizes() -> impl Iterator<Item = usize> {
    (3..12).chain(94..98).chain([128, 255, 256, 257, 513, 1025])
}

#[test]
fn implicit_steps_of_chains_have_the_bits_of_one_pass() {
    for n in sizes() {
        check::<Midpoint, _>(&Chain { beta: 0.25 }, n, "chain");
        check::<Lambda<1, 4>, _>(&Chain { beta: 0.25 }, n, "asymmetric");
        check::<Midpoint, _>(&SineGordon { k: 0.7 }, n, "ring");
        let [mass, spring] = masses_and_springs(n);
        check::<Midpoint, _>(&Kicked { mass, spring }, n, "kicked");
    }
}

fn masses_and_springs(n: usize) -> [Vec<f64>; 2] {
    [(0..n).map(|i| 1.0 + 0.1 * i as f64).collect(), numbers(n, 2.0)]
}

/// Each step is one correction, and each tile takes all of it at once, unless it adds to the forces of others.
#[test]
fn linear_steps_of_single_sites_have_the_bits_of_one_pass() {
    for n in sizes() {
        let [mass, spring] = masses_and_springs(n);
        let apart = Apart { mass, spring };
        check::<Midpoint, _>(&apart, n, "apart");
        check::<Lambda<1, 4>, _>(&apart, n, "apart, asymmetric");
        let [mass, spring] = masses_and_springs(n);
        check::<Midpoint, _>(&Tilted { mass, spring }, n, "tilted");
    }
    let [mass, spring] = masses_and_springs(1025);
    let apart = Apart { mass, spring };
    let start = [numbers(1025, 0.2), numbers(1025, 1.1)];
    let (_, iterations) = on_threads(&apart, 1, start.clone());
    assert_eq!(iterations, Ok(vec![1; 3]));
    for (place, bad) in [(0, f64::NEG_INFINITY), (1024, f64::NAN), (600, f64::INFINITY)] {
        let [q, mut p] = start.clone();
        p[place] = bad;
        check_threads(&apart, &[q.clone(), p.clone()], "not finite");
        let (bits, taken) = on_threads(&apart, 1, [q.clone(), p.clone()]);
        assert!(taken.is_err_and(|error| error.step == 0), "{bad} at {place}");
        assert!(q.iter().chain(&p).map(|number| number.to_bits()).eq(bits));
    }
}

#[test]
fn implicit_steps_of_lattices_have_the_bits_of_one_pass() {
    for (rows, columns) in [(2, 3), (9, 11), (1, 700), (700, 1), (31, 33), (60, 13)] {
        let n = rows * columns;
        let torus = Torus { rows, columns, well: 1.0 };
        check::<Midpoint, _>(&torus, n, "torus");
    }
}

/// Beyond what the functions of vector registers take: the reduction by π/2, and velocities that overflow.
#[test]
fn rare_arguments_have_the_bits_of_one_pass() {
    let far = numbers(600, 0.2).iter().map(|q| q + 1e9).collect();
    check_scheme::<Midpoint, _>(&SineGordon { k: 0.7 }, &[far, numbers(600, 1.1)], H, "far away");
    for (place, bad) in [(0, 800.0), (599, f64::NAN), (300, f64::INFINITY)] {
        let (q, mut p) = (numbers(600, 0.2), numbers(600, 1.1));
        p[place] = bad;
        let before = (q.clone(), p.clone());
        let (mut state, ring) = (State::new(q, p), SineGordon { k: 0.7 });
        assert!(ring.stepper::<Midpoint>(H).unwrap().step(&mut state, &[]).is_err(), "{bad} at {place}");
        let after = state.q.iter().chain(state.p.iter());
        assert!(after.zip(before.0.iter().chain(&before.1)).all(|(a, b)| a.to_bits() == b.to_bits()));
    }
}

/// What some steps by the mid-point rule on so many threads lead to: bits, and iterations or the error of the step that fails.
fn on_threads<H>(system: &H, threads: usize, [q, p]: [Vec<f64>; 2]) -> (Vec<u64>, Result<Vec<u32>, StepError>)
where
    H: Discretized<Midpoint, Vector = DVector<f64>>,
{
    let mut state = State::new(q, p);
    let mut stepper = system.stepper::<Midpoint>(self::H).unwrap().threads(threads).unwrap();
    let step = |step: i32| {
        let dw: Vec<f64> =
            numbers(system.noises(), 0.7 * f64::from(step)).iter().map(|dw| 0.1 * dw).collect();
        stepper.step(&mut state, &dw).map(|info| info.iterations)
    };
    let taken = (0..3).map(step).collect();
    (state.q.iter().chain(&state.p).map(|number| number.to_bits()).collect(), taken)
}

/// The error of the run, if it has one.
fn check_threads<H: Discretized<Midpoint, Vector = DVector<f64>>>(
    system: &H,
    start: &[Vec<f64>; 2],
    what: &str,
) -> Option<StepError> {
    let [one, several] = [1, 3].map(|threads| on_threads(system, threads, start.clone()));
    assert!(several == one, "{what}: {} sites", start[0].len());
    several.1.err()
}

#[test]
fn rare_arguments_and_failures_are_the_same_on_threads() {
    let mut far = numbers(900, 0.2);
    far[800] = 1e9;
    check_threads(&SineGordon { k: 0.7 }, &[far, numbers(900, 1.1)], "far away");
    for (place, bad) in [(0, 800.0), (899, f64::NAN), (450, f64::INFINITY)] {
        let mut p = numbers(900, 1.1);
        p[place] = bad;
        let start = [numbers(900, 0.2), p];
        assert!(check_threads(&SineGordon { k: 0.7 }, &start, "not finite").is_some());
    }
}

/// On all cores, as large systems go unless it is asked for another number.
#[test]
fn as_many_threads_as_pay_have_the_bits_of_one() {
    let n = 140_011;
    let chain = Chain { beta: 0.25 };
    let run = || {
        let run = chain.simulate::<Midpoint>(H).start(State::new(numbers(n, 0.2), numbers(n, 1.1)));
        run.steps(1).record_every(0)
    };
    let [all, one] = [run().run().unwrap(), run().threads(1).run().unwrap()];
    assert!(all.last() == one.last());
}

/// Two halves of a chain that no spring joins, one a power of two of the other: a step takes both alike, to the last bit. What
/// compares sites with each other does not.
#[test]
fn sites_of_other_scales_are_solved_alike() {
    let half = 300;
    let mass = vec![1.0; 2 * half];
    let mut spring = vec![1.0; 2 * half];
    spring[half] = 0.0;
    for exponent in [-40, 40, -300] {
        let scale = 2.0_f64.powi(exponent);
        let (q, p) = (numbers(half, 0.2), numbers(half, 1.1));
        let both = |list: &[f64]| -> Vec<f64> {
            list.iter().copied().chain(list.iter().map(|x| scale * x)).collect()
        };
        let kicked = Kicked { mass: mass.clone(), spring: spring.clone() };
        let mut state = State::new(both(&q), both(&p));
        let mut stepper = kicked.stepper::<Midpoint>(H).unwrap();
        for _ in 0..20 {
            stepper.step(&mut state, &vec![0.0; 2 * half]).unwrap();
        }
        for list in [state.q.as_slice(), state.p.as_slice()] {
            let (own, other) = list.split_at(half);
            for (a, b) in own.iter().zip(other) {
                assert_eq!((a * scale).to_bits(), b.to_bits(), "2^{exponent}");
            }
        }
    }
}

/// Pairs of sites that nothing else joins, of one energy and phase each: the same numbers at every pair, and the same whether there are
/// so few of them that they go one after the other, or so many that they go in tiles.
#[test]
fn small_and_large_systems_are_judged_alike() {
    let solve = |n: usize, scale: f64| {
        let spring: Vec<f64> = (0..n).map(|i| if i % 2 == 1 { 1.0 } else { 0.0 }).collect();
        let bonds = Bonds { spring };
        let [q, p] = [[0.4, -0.9], [1.1, 0.3]].map(|list| list.map(|x| scale * x));
        let mut state = State::new(q.repeat(n / 2), p.repeat(n / 2));
        let mut stepper = bonds.stepper::<Midpoint>(H).unwrap();
        let taken: Vec<u32> = (0..200).map(|_| stepper.step(&mut state, &[]).unwrap().iterations).collect();
        (state, taken)
    };
    for scale in [1.0, 1e-3] {
        let (least, expected) = solve(2, scale);
        let bits = |x: &f64| x.to_bits();
        for n in [94, 96] {
            let (state, taken) = solve(n, scale);
            assert_eq!(taken, expected, "{n} sites of {scale}");
            for (own, first) in [(&state.q, &least.q), (&state.p, &least.p)] {
                let alike =
                    own.as_slice().chunks(2).all(|pair| pair.iter().map(bits).eq(first.iter().map(bits)));
                assert!(alike, "{n} sites of {scale}");
            }
        }
    }
}

/// A part of what `tests/laws` runs.
#[test]
fn energies_do_not_drift() {
    rounding::energies_of_chains_do_not_drift(500);
}
