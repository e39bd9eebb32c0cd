//! `Baoab` beside what it cannot do without: its normals, and the steps of `Verlet`, which have its forces.
//!
//! `baoab_numba.py` has the same two systems as loops in numba.

use std::hint::black_box;

use wzvi::ensemble::{InstructionSet, Normals};
use wzvi::prelude::*;

use crate::scenes::{SEED, STEPS};
use crate::times;

#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.5 * q * q + 0.25 * q.powi(4),
    friction = gamma,
    temperature = kt,
    embedding = Baoab,
)]
#[derive(Clone)]
struct Quartic {
    gamma: f64,
    kt: f64,
}

#[hamiltonian(drift = |q, p| 0.5 * p * p + 0.5 * q * q + 0.25 * q.powi(4), embedding = Verlet)]
struct QuarticAlone;

const SITES: usize = 1024;

#[hamiltonian(
    drift = |q: [f64; SITES], p: [f64; SITES]| {
        (0..SITES).map(|i| 0.5 * p[i] * p[i] + 0.5 * (q[(i + 1) % SITES] - q[i]).powi(2) + 1.0 - q[i].cos()).sum::<f64>()
    },
    friction = gamma,
    temperature = kt,
    embedding = Baoab,
)]
struct SineGordon {
    gamma: f64,
    kt: f64,
}

#[hamiltonian(
    drift = |q: [f64; SITES], p: [f64; SITES]| {
        (0..SITES).map(|i| 0.5 * p[i] * p[i] + 0.5 * (q[(i + 1) % SITES] - q[i]).powi(2) + 1.0 - q[i].cos()).sum::<f64>()
    },
    embedding = Verlet,
)]
struct SineGordonAlone;

/// Runs paths, with an observable that costs nothing.
fn run<H, E>(system: &H, h: f64, start: State<H::Vector>, paths: u64, steps: u64)
where
    H: Discretized<E> + Sync,
    H::Vector: Send + Sync,
{
    let run = system.ensemble::<E>(h).start(start).paths(paths).seed(SEED).steps(steps).threads(1);
    black_box(run.observe("t", |state| state.t).run().unwrap());
}

/// The same with a bath for each path.
fn sweep(paths: u64, steps: u64) {
    let bath = |path: u64| Quartic {
        gamma: 0.5 + 0.1 * (path % 10) as f64,
        kt: 0.5 + 0.1 * (path / 10 % 10) as f64,
    };
    let first = bath(0);
    let run = first.ensemble::<Baoab>(0.1).systems(|draw| bath(draw.path())).start(State::new([0.5], [0.5]));
    let run = run.paths(paths).seed(SEED).steps(steps).threads(1);
    black_box(run.observe("t", |state| state.t).run().unwrap());
}

fn normals(processes: u64, paths: u64, steps: u64) {
    for process in 0..processes {
        Normals::new(SEED, process, 0.1).visit(0..paths, 0..steps / 10, InstructionSet::best(), |drawn| {
            black_box(drawn);
        });
    }
}

pub(crate) fn print(paths: u64, repetitions: usize, only: Option<&str>) {
    let is_wanted = |name: &str| only.is_none_or(|only| name.contains(only));
    let row = |name: &str, [bath, alone, normals]: [f64; 3], unit: &str| {
        println!("{name:26}{bath:>9.2}{normals:>9.2}{alone:>9.2}{:>9.2}    {unit}", bath / (normals + alone));
    };
    println!("\n{:26}{:>9}{:>9}{:>9}{:>9}", "", "ensemble", "normals", "Verlet", "/both");
    if is_wanted("quartic, Baoab") {
        let (quartic, start) =
            (Quartic { gamma: black_box(1.0), kt: black_box(1.0) }, State::new([0.5], [0.5]));
        let [one, own, alone, normals] = times(
            paths,
            repetitions,
            [
                &|| run::<_, Baoab>(&quartic, 0.1, start, paths, STEPS),
                &|| sweep(paths, STEPS),
                &|| run::<_, Verlet>(&QuarticAlone, 0.1, start, paths, STEPS),
                &|| normals(1, paths, STEPS),
            ],
        );
        row("quartic, Baoab", [one, alone, normals], "ns per path and step");
        row("the same, a bath by path", [own, alone, normals], "ns per path and step");
    }
    if is_wanted("sine-Gordon, Baoab") {
        let (chain, still) = (SineGordon { gamma: black_box(1.0), kt: black_box(1.0) }, [0.0; SITES]);
        let (paths, steps) = (16, 100);
        let start = || State::new(still, still);
        let found = times(
            paths,
            repetitions.div_ceil(4),
            [
                &|| run::<_, Baoab>(&chain, 0.05, start(), paths, steps),
                &|| run::<_, Verlet>(&SineGordonAlone, 0.05, start(), paths, steps),
                &|| normals(SITES as u64, paths, steps),
            ],
        );
        // `times` counts a thousand steps for each path.
        let scale = STEPS as f64 / (steps * SITES as u64) as f64;
        row("sine-Gordon, Baoab", found.map(|time| time * scale), "ns per site, path and step");
    }
}
