//! Sites that are not coupled go as a small system goes at each of them.

use fixtures::steps::{distance, numbers};
use fixtures::wave;
use wzvi::nalgebra::{DVector, SVector};
use wzvi::prelude::*;

fn start(n: usize) -> (Vec<f64>, Vec<f64>) {
    (wave(n, 1.0, 0.2), wave(n, 1.0, 1.1))
}

fn steps<E, H: Discretized<E>>(
    system: &H,
    state: &mut State<H::Vector>,
    h: f64,
    dw: &[f64],
    n: usize,
) -> Vec<f64> {
    let mut stepper = system.stepper::<E>(h).unwrap();
    for _ in 0..n {
        stepper.step(state, dw).unwrap();
    }
    numbers(state)
}

/// Twenty steps of order one, a few dozen roundings each.
const ROUNDING: f64 = 1e-13;

/// Points of two components, with parameters and noises of their own, in time.
#[hamiltonian(
    drift = |q: &[[f64; 2]], p: &[[f64; 2]], t| {
        (0..q.len()).map(|i| {
            let r2 = q[i][0] * q[i][0] + q[i][1] * q[i][1];
            (p[i][0] * p[i][0] + p[i][1] * p[i][1]) / (2.0 * mass[i]) * (1.0 + 0.1 * r2)
                + 0.25 * r2 * r2 * (1.0 + 0.2 * t.cos()) + 0.01 * i as f64 * q[i][0]
        }).sum::<f64>()
    },
    noise = [|q, p, k| s * charge[k] * q[k][1].sin(); self.charge.len()],
    embedding = [Midpoint, Uncorrected<DeltaPlus>],
)]
struct Points {
    mass: Vec<f64>,
    charge: Vec<f64>,
    s: f64,
}

/// One of them.
#[hamiltonian(
    drift = |[x, y], [px, py], t| {
        let r2 = x * x + y * y;
        (px * px + py * py) / (2.0 * mass) * (1.0 + 0.1 * r2) + 0.25 * r2 * r2 * (1.0 + 0.2 * t.cos())
            + 0.01 * number * x
    },
    noise = [|[x, y], [px, py]| s * charge * y.sin()],
    embedding = [Midpoint, Uncorrected<DeltaPlus>],
)]
struct Point {
    mass: f64,
    charge: f64,
    s: f64,
    number: f64,
}

#[test]
fn every_site_has_its_own_parameters_and_increments() {
    let sites = 5;
    // The last site has no noise.
    let mass: Vec<f64> = (0..sites).map(|i| 1.0 + 0.3 * i as f64).collect();
    let charge: Vec<f64> = (0..sites - 1).map(|i| 0.5 - 0.2 * i as f64).collect();
    let all = Points { mass: mass.clone(), charge: charge.clone(), s: 0.4 };
    let (q, p) = start(2 * sites);
    let dw = [0.1, -0.1, 0.2, 0.15];
    let mut together = State::<DVector<f64>>::new(q.clone(), p.clone());
    let found = steps::<Midpoint, _>(&all, &mut together, 0.05, &dw, 20);
    for i in 0..sites {
        let one = Point { mass: mass[i], charge: *charge.get(i).unwrap_or(&1.0), s: 0.4, number: i as f64 };
        let mut state = State::new([q[2 * i], q[2 * i + 1]], [p[2 * i], p[2 * i + 1]]);
        let alone = steps::<Midpoint, _>(&one, &mut state, 0.05, &[*dw.get(i).unwrap_or(&0.0)], 20);
        let n = 2 * sites;
        let of_all = [found[2 * i], found[2 * i + 1], found[n + 2 * i], found[n + 2 * i + 1]];
        assert!(distance(&alone, &of_all) < ROUNDING);
    }
}

/// Without noise: every site has a memory.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| (0..q.len()).map(|i| 0.5 * p[i] * p[i] + 0.25 * q[i].powi(4)).sum::<f64>(),
    embedding = [Midpoint],
)]
struct Quartic;

#[test]
fn sites_that_start_from_a_guess_end_at_the_same_solution() {
    let (q, p) = start(6);
    let mut state = State::<DVector<f64>>::new(q, p);
    let mut stepper = Quartic.stepper::<Midpoint>(0.1).unwrap();
    let mut go_on = |state: &mut State<_>, n| (0..n).for_each(|_| assert!(stepper.step(state, &[]).is_ok()));
    go_on(&mut state, 5);
    let from_zero = steps::<Midpoint, _>(&Quartic, &mut state.clone(), 0.1, &[], 5);
    go_on(&mut state, 5);
    assert!(distance(&numbers(&state), &from_zero) < ROUNDING);
    // Energies are kept to second order, for ever.
    let start = Quartic.energy(&state);
    go_on(&mut state, 1000);
    assert!((Quartic.energy(&state) / start - 1.0).abs() < 1e-2);
    let counted = allocation_counter::measure(|| go_on(&mut state, 1));
    assert_eq!(counted.count_total, 0);
}

/// One noise that acts at all sites.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| (0..q.len()).map(|i| 0.5 * p[i] * p[i] + 0.5 * q[i] * q[i]).sum::<f64>(),
    noise = [|q, p| s * q.iter().zip(p.iter()).map(|(q, p)| 0.5 * (q * q + p * p)).sum::<f64>()],
    embedding = [Midpoint],
)]
struct Shared {
    s: f64,
}

#[test]
fn one_increment_may_act_at_all_sites() {
    let (q, p) = start(4);
    let mut together = State::<DVector<f64>>::new(q.clone(), p.clone());
    let found = steps::<Midpoint, _>(&Shared { s: 0.3 }, &mut together, 0.1, &[0.2], 20);
    for i in 0..4 {
        let mut one = State::<DVector<f64>>::new(vec![q[i]], vec![p[i]]);
        let alone = steps::<Midpoint, _>(&Shared { s: 0.3 }, &mut one, 0.1, &[0.2], 20);
        assert!(distance(&alone, &[found[i], found[4 + i]]) < ROUNDING);
    }
}

/// Linear springs, driven: the Jacobian of a step never changes.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64], t| {
        (0..q.len()).map(|i| p[i] * p[i] / (2.0 * mass) - 0.3 * t.sin() * q[i]).sum::<f64>()
            + (1..q.len()).map(|i| 0.5 * k * (q[i] - q[i - 1]).powi(2)).sum::<f64>() + 0.5 * k * q[0] * q[0]
    },
    noise = [|q, p, j| 0.1 * q[j]; 4],
    embedding = [Midpoint],
)]
struct Springs {
    k: f64,
    mass: f64,
}

/// The same as one block.
#[hamiltonian(
    drift = |q: [f64; 4], p: [f64; 4], t| {
        (0..4).map(|i| p[i] * p[i] / (2.0 * mass) - 0.3 * t.sin() * q[i]).sum::<f64>()
            + (1..4).map(|i| 0.5 * k * (q[i] - q[i - 1]).powi(2)).sum::<f64>() + 0.5 * k * q[0] * q[0]
    },
    noise = [|q, p, j| 0.1 * q[j]; 4],
    embedding = [Midpoint],
)]
struct SpringsBlock {
    k: f64,
    mass: f64,
}

#[test]
fn linear_chains_are_factored_once() {
    assert_eq!(<Springs as Discretized<Midpoint>>::PLAN.solver, Solver::Linear);
    assert_eq!(<SpringsBlock as Discretized<Midpoint>>::PLAN.solver, Solver::Linear);
    let (q, p) = start(4);
    let dw = [0.1, -0.3, 0.2, 0.05];
    for (k, h) in [(1.0, 0.1), (100.0, 0.5)] {
        let (chain, block) = (Springs { k, mass: 1.5 }, SpringsBlock { k, mass: 1.5 });
        let mut list = State::<DVector<f64>>::new(q.clone(), p.clone());
        let mut fixed = State::<SVector<f64, 4>>::new([q[0], q[1], q[2], q[3]], [p[0], p[1], p[2], p[3]]);
        let by_chain = steps::<Midpoint, _>(&chain, &mut list, h, &dw, 20);
        let by_block = steps::<Midpoint, _>(&block, &mut fixed, h, &dw, 20);
        let size = by_block.iter().fold(1.0_f64, |most, x| most.max(x.abs()));
        assert!(distance(&by_chain, &by_block) < ROUNDING * size);
        // One solution, and one more for what rounding left.
        let mut stepper = chain.stepper::<Midpoint>(h).unwrap();
        for _ in 0..5 {
            assert!(stepper.step(&mut list, &dw).unwrap().iterations <= 3);
        }
    }
}
