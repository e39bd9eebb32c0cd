//! Steps with plain and with compensated sums, and runs beside them: the energy of a run is monitored, that of a stepper is not.

use std::time::Instant;

use wzvi::nalgebra::DVector;
use wzvi::prelude::*;

use crate::measure::REPETITIONS;
use crate::ring::{H, RING, wave};

/// A small system, whose step takes a few tens of nanoseconds.
#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) - 1.0 / (x * x + y * y).sqrt(),
    embedding = Verlet,
)]
struct Kepler;

/// The best times of so many steps in each of five ways, in turns: a stepper with plain and with compensated sums; a run, unwatched, and with
/// plain sums.
fn times<S: Discretized<Verlet>>(system: &S, start: &State<S::Vector>, steps: u64) -> [f64; 5] {
    let mut plain = system.stepper::<Verlet>(H).unwrap().plain();
    let mut compensated = system.stepper::<Verlet>(H).unwrap().compensated();
    let mut states = [start.clone(), start.clone()];
    let run = || system.simulate::<Verlet>(H).start(start.clone()).record_every(0).steps(steps).quiet();
    let mut best = [f64::INFINITY; 5];
    for _ in 0..REPETITIONS {
        for (way, best) in best.iter_mut().enumerate() {
            let begin = Instant::now();
            match way {
                0 => (0..steps).for_each(|_| _ = plain.step(&mut states[0], &[]).unwrap()),
                1 => (0..steps).for_each(|_| _ = compensated.step(&mut states[1], &[]).unwrap()),
                2 => drop(run().run().unwrap()),
                3 => drop(run().unwatched().run().unwrap()),
                _ => drop(run().plain_sums().run().unwrap()),
            }
            *best = best.min(begin.elapsed().as_nanos() as f64 / steps as f64);
        }
    }
    best
}

/// A row for each system.
pub(crate) fn report() {
    println!(
        "\nPlain and compensated sums of `Verlet`: ns of a plain stepper, other ways as multiples of it\n"
    );
    println!(
        "{:16}{:>12}{:>14}{:>10}{:>12}{:>13}",
        "", "stepper", "compensated", "run", "unwatched", "plain sums"
    );
    let of_ring = |n: usize, steps| times(&RING, &State::new(wave(n), DVector::zeros(n)), steps);
    let rows = [
        ("Kepler", times(&Kepler, &State::new([1.0, 0.0], [0.0, 1.0]), 40_000)),
        ("ring of 32", of_ring(32, 4_000)),
        ("ring of 1000", of_ring(1000, 400)),
        ("ring of 100000", of_ring(100_000, 200)),
    ];
    for (name, [plain, others @ ..]) in rows {
        let [compensated, run, unwatched, plain_sums] = others.map(|time| time / plain);
        println!("{name:16}{plain:12.1}{compensated:14.2}{run:10.2}{unwatched:12.2}{plain_sums:13.2}");
    }
}
