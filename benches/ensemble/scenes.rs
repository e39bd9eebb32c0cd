//! The systems, as ensembles.

use std::hint::black_box;

use wzvi::ensemble::{InstructionSet, Normals};
use wzvi::prelude::*;

use crate::by_hand;

pub(crate) const STEPS: u64 = 1000;
pub(crate) const SEED: u64 = 7;

/// One system in every way to run it.
pub(crate) struct Scene {
    pub(crate) name: &'static str,
    /// So many paths on so many threads: the mean of an observable at the end, and its standard error.
    pub(crate) ensemble: fn(u64, usize) -> (f64, f64),
    /// As many normals, drawn and no more.
    pub(crate) normals: fn(u64),
    /// The same mean by a loop of numbers.
    pub(crate) by_hand: fn(u64) -> f64,
    /// The name of the problem in C.
    pub(crate) c: &'static str,
    /// The observable.
    pub(crate) mean: &'static str,
}

pub(crate) const ALL: [Scene; 3] = [
    Scene {
        name: "Kubo, Midpoint",
        ensemble: kubo,
        normals: |paths| normals(1, paths),
        by_hand: by_hand::kubo,
        c: "p1",
        mean: "E q",
    },
    Scene {
        name: "two additive, Midpoint",
        ensemble: additive,
        normals: |paths| normals(2, paths),
        by_hand: by_hand::additive,
        c: "p2",
        mean: "E H",
    },
    Scene {
        name: "double well, Newton",
        ensemble: double_well,
        normals: |paths| normals(1, paths),
        by_hand: by_hand::double_well,
        c: "p7",
        mean: "E q²",
    },
];

#[hamiltonian(
    drift = |q, p| 0.5 * a * (q * q + p * p),
    noise = [|q, p| 0.5 * sigma * (q * q + p * p)],
    embedding = Midpoint,
)]
struct Kubo {
    a: f64,
    sigma: f64,
}

fn kubo(paths: u64, threads: usize) -> (f64, f64) {
    let run = Kubo { a: black_box(1.5), sigma: black_box(1.0) }
        .ensemble::<Midpoint>(0.02)
        .start(State::new([0.0], [1.0]))
        .paths(paths)
        .seed(SEED)
        .steps(STEPS)
        .threads(threads)
        .observe("observable0", |state| state.q[0])
        .run()
        .unwrap();
    (run.mean("observable0").unwrap(), run.standard_error("observable0").unwrap())
}

#[hamiltonian(
    drift = |q, p| 0.5 * (q * q + p * p),
    noise = [|q, p| sigma * p, |q, p| -gamma * q],
    embedding = Midpoint,
)]
struct Additive {
    sigma: f64,
    gamma: f64,
}

fn additive(paths: u64, threads: usize) -> (f64, f64) {
    let system = Additive { sigma: black_box(0.5), gamma: black_box(1.0) };
    let run = system
        .ensemble::<Midpoint>(0.02)
        .start(State::new([0.0], [0.0]))
        .paths(paths)
        .seed(SEED)
        .steps(STEPS)
        .threads(threads)
        .observe("observable0", |state| system.energy(state))
        .run()
        .unwrap();
    (run.mean("observable0").unwrap(), run.standard_error("observable0").unwrap())
}

#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.25 * (q * q - 1.0).powi(2),
    noise = [|q, p| s * q * p],
    embedding = Midpoint,
)]
struct DoubleWell {
    s: f64,
}

fn double_well(paths: u64, threads: usize) -> (f64, f64) {
    let run = DoubleWell { s: black_box(0.3) }
        .ensemble::<Midpoint>(0.01)
        .start(State::new([0.5], [0.5]))
        .paths(paths)
        .seed(SEED)
        .steps(STEPS)
        .threads(threads)
        .observe("observable0", |state| state.q[0] * state.q[0])
        .run()
        .unwrap();
    (run.mean("observable0").unwrap(), run.standard_error("observable0").unwrap())
}

fn normals(processes: u64, paths: u64) {
    for process in 0..processes {
        Normals::new(SEED, process, 0.02).visit(0..paths, 0..STEPS / 10, InstructionSet::best(), |drawn| {
            black_box(drawn);
        });
    }
}
