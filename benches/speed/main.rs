//! One table: what a step costs beside a loop by hand, for six systems and four schemes, of one path and in
//! ensembles.
//!
//! `cargo bench --workspace --bench speed` prints the table of `docs/guide/speed.md`. Arguments pick rows:
//! `-- ring`, or `-- Gauss<4> lattice`. All is on one thread and in one process, and takes turns in short
//! windows, of which the shortest counts: what else runs on the machine only adds.
//!
//! The loops by hand ([`by_hand`]) are measured twice: as the build compiles them, and for the instructions
//! of the machine, which the library finds in every build. Both do what the library does: the same method,
//! stopped by the same rules, with compensated sums in `Gauss`. `error` is the largest error of a coordinate
//! after twenty steps, beside `Gauss<8>` by hand in steps of a quarter; in an ensemble that of the mean of
//! the first coordinate.
//!
//! Left out, since they take most of the compile time and say nothing new: implicit steps of systems of any
//! size in ensembles, which take one path after the other, and ensembles of further systems with `Verlet`.
//!
//! Ensembles by hand are path after path.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a benchmark talks, and stops at the first error"
)]
#![allow(clippy::needless_range_loop, reason = "formulas with indices")]

mod by_hand;
mod systems;

#[allow(dead_code, reason = "the coefficients of another benchmark")]
#[path = "../gauss/by_hand.rs"]
mod stages;

use std::time::Instant;

use by_hand::{KickDriftKick, Nystrom, Stages, Start, Steps, take_steps};
use systems::{Bodies, Chain, Condensate, Forces, Lattice, Ring, Rotors, System};
use wzvi::embedding::{Gauss, Midpoint};
use wzvi::lanes::instructions::InstructionSet;
use wzvi::prelude::*;
use wzvi::state::Vector;

/// Turns, of which the best counts, and seconds of the window of one path.
const TURNS: usize = 100;
const WINDOW: f64 = 5e-4;
/// The same of many paths, whose window is so many steps: a run of few has other costs than its steps.
const TURNS_OF_MANY: usize = 20;
const STEPS_OF_MANY: usize = 200;
/// Steps before errors are compared.
const COMPARED: usize = 20;

/// So many paths of a system with so many degrees of freedom.
#[derive(Clone, Copy)]
struct Size {
    degrees: usize,
    paths: usize,
}

fn state<S: System>(size: Size, path: usize) -> State<S::Vector>
where
    S::Vector: Vector,
{
    let [q, p] = S::start(size.degrees, path).map(|list| {
        let mut vector = S::Vector::zeros(list.len());
        vector.components_mut().copy_from_slice(&list);
        vector
    });
    State { q, p, t: 0.0 }
}

/// The coordinates at the end, and the seconds that the steps took.
type Run = (Vec<f64>, f64);

/// One path by the library, after a step that is not timed.
fn one_path<E, S>(system: &S, size: Size, steps: usize) -> Run
where
    S: System + Discretized<E>,
    S::Vector: Vector,
{
    let mut stepper = system.stepper::<E>(S::H).unwrap().threads(1).unwrap();
    let mut state = state::<S>(size, 0);
    stepper.step(&mut state, &[]).unwrap();
    let began = Instant::now();
    for _ in 1..steps {
        stepper.step(&mut state, &[]).unwrap();
    }
    (state.q.components().to_vec(), began.elapsed().as_secs_f64())
}

/// Many paths by the library.
fn ensemble<E, S>(system: &S, size: Size, steps: usize) -> Run
where
    S: System + Discretized<E> + Sync,
    S::Vector: Vector + Send + Sync,
{
    let ensemble = system
        .ensemble::<E>(S::H)
        .starts(|draw| state::<S>(size, draw.path() as usize))
        .paths(size.paths as u64)
        .steps(steps as u64)
        .threads(1)
        .observe("q", |state| state.q.components()[0]);
    let began = Instant::now();
    let statistics = ensemble.run().unwrap();
    (vec![statistics.mean("q").unwrap()], began.elapsed().as_secs_f64())
}

/// Steps by hand, one path after the other.
fn by_hand<M: Steps>(set: InstructionSet, system: &M::System, size: Size, steps: usize, h: f64) -> Run
where
    M::System: System,
{
    let mut seconds = 0.0;
    let mut ends = Vec::new();
    for path in 0..size.paths {
        let [q, p] = <M::System>::start(size.degrees, path);
        let mut path = M::new(&Start { q: &q, p: &p, h });
        take_steps(set, &mut path, system, 1);
        let began = Instant::now();
        take_steps(set, &mut path, system, steps - 1);
        seconds += began.elapsed().as_secs_f64();
        ends.push(path.q().to_vec());
    }
    match ends.as_slice() {
        [end] => (end.clone(), seconds),
        ends => (vec![ends.iter().map(|end| end[0]).sum::<f64>() / ends.len() as f64], seconds),
    }
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Whether an argument picks the row, or there is none.
fn is_wanted(names: [&str; 2]) -> bool {
    let mut picked = std::env::args().skip(1).filter(|argument| !argument.starts_with("--")).peekable();
    picked.peek().is_none() || picked.all(|picked| names.iter().any(|name| name.contains(picked.as_str())))
}

/// Prints a row: a scheme of a system by the library, and by hand as `M`; `R` is `Gauss<8>` by hand.
fn row<M, R>(system: &M::System, scheme: &str, size: Size, ours: &dyn Fn(Size, usize) -> Run)
where
    M: Steps,
    R: Steps<System = M::System>,
    M::System: System,
{
    let name = <M::System>::NAME;
    if !is_wanted([name, scheme]) {
        return;
    }
    let (h, plain, best) = (<M::System>::H, InstructionSet::Baseline, InstructionSet::best());
    let (exact, _) = by_hand::<R>(plain, system, size, 4 * COMPARED, h / 4.0);
    let (own, _) = ours(size, COMPARED);
    let (hand, once) = by_hand::<M>(plain, system, size, COMPARED, h);
    // Sums of up to a thousand terms of order one, in each of twenty steps.
    assert!(distance(&own, &hand) < 1e-11, "{name}, {scheme}: {:.1e} apart", distance(&own, &hand));

    let in_window = 1 + ((WINDOW / once * (COMPARED - 1) as f64) as usize).max(1);
    let (steps, turns) = if size.paths == 1 { (in_window, TURNS) } else { (STEPS_OF_MANY, TURNS_OF_MANY) };
    let mut shortest = [f64::INFINITY; 3];
    for _ in 0..turns {
        let turns = [
            ours(size, steps).1,
            by_hand::<M>(plain, system, size, steps, h).1,
            by_hand::<M>(best, system, size, steps, h).1,
        ];
        for (shortest, seconds) in shortest.iter_mut().zip(turns) {
            *shortest = shortest.min(seconds);
        }
    }
    // An ensemble has no step before its time is taken.
    let taken = [if size.paths == 1 { steps - 1 } else { steps }, steps - 1, steps - 1];
    let units = (<M::System>::units(size.degrees) * size.paths) as f64;
    let [own_time, hand_time, machine_time] =
        std::array::from_fn(|i| shortest[i] * 1e9 / (units * taken[i] as f64));
    println!(
        "| {name}, {} | {} | `{scheme}` | {} | {own_time:.2} | {hand_time:.2} | {:.2} | {machine_time:.2} | {:.2} | {:.1e} | {:.1e} |",
        size.degrees,
        <M::System>::UNIT,
        size.paths,
        own_time / hand_time,
        own_time / machine_time,
        distance(&own, &exact),
        distance(&hand, &exact),
    );
}

/// All schemes of one path of a system whose kinetic energy is `p²/2`.
fn separable<S>(system: &S, degrees: usize)
where
    S: System
        + Forces
        + Discretized<Verlet>
        + Discretized<Midpoint>
        + Discretized<Gauss<4>>
        + Discretized<Gauss<8>>,
    S::Vector: Vector,
{
    let size = Size { degrees, paths: 1 };
    type Exact<S> = Nystrom<S, 8>;
    row::<KickDriftKick<S>, Exact<S>>(system, "Verlet", size, &|size, steps| {
        one_path::<Verlet, S>(system, size, steps)
    });
    row::<Nystrom<S, 1>, Exact<S>>(system, "Midpoint", size, &|size, steps| {
        one_path::<Midpoint, S>(system, size, steps)
    });
    row::<Nystrom<S, 4>, Exact<S>>(system, "Gauss<4>", size, &|size, steps| {
        one_path::<Gauss<4>, S>(system, size, steps)
    });
    row::<Nystrom<S, 8>, Exact<S>>(system, "Gauss<8>", size, &|size, steps| {
        one_path::<Gauss<8>, S>(system, size, steps)
    });
}

/// A scheme of the condensate, alone and in an ensemble.
fn not_separable<E, M: Steps<System = Condensate>>(scheme: &str)
where
    Condensate: Discretized<E>,
{
    let system = &Condensate { u: 1.0, j: 0.7 };
    let [one, many] = [1, 128].map(|paths| Size { degrees: systems::WELLS, paths });
    row::<M, Stages<8>>(system, scheme, one, &|size, steps| one_path::<E, _>(system, size, steps));
    row::<M, Stages<8>>(system, scheme, many, &|size, steps| ensemble::<E, _>(system, size, steps));
}

fn main() {
    println!(
        "| system, degrees | ns per | scheme | paths | wzvi | by hand | ratio | by hand, instructions of the machine | ratio | error | by hand |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|");
    let ring = Ring { k: 1.0 };
    separable(&ring, 1000);
    let size = Size { degrees: 100, paths: 128 };
    row::<KickDriftKick<Ring>, Nystrom<Ring, 8>>(&ring, "Verlet", size, &|size, steps| {
        ensemble::<Verlet, _>(&ring, size, steps)
    });
    let chain = Chain { beta: 0.25 };
    for degrees in [24, 48, 96, 256] {
        let size = Size { degrees, paths: 1 };
        row::<KickDriftKick<Chain>, Nystrom<Chain, 8>>(&chain, "Verlet", size, &|size, steps| {
            one_path::<Verlet, _>(&chain, size, steps)
        });
        row::<Nystrom<Chain, 1>, Nystrom<Chain, 8>>(&chain, "Midpoint", size, &|size, steps| {
            one_path::<Midpoint, _>(&chain, size, steps)
        });
    }
    separable(&chain, 1000);
    separable(&Lattice { side: 32 }, 1024);
    separable(&Bodies { g: 0.1, softening: 0.01 }, 192);
    separable(&Rotors { coupling: 1.0 }, 1000);
    not_separable::<Midpoint, Stages<1>>("Midpoint");
    not_separable::<Gauss<4>, Stages<4>>("Gauss<4>");
    not_separable::<Gauss<8>, Stages<8>>("Gauss<8>");
}
