//! The bits of some two hundred and fifty short runs: every scheme on small systems and on systems of any size, with noise and without, alone, in the lanes of
//! ensembles, on threads, stopped and resumed.
//!
//! `data/bits.txt` has a checksum of each. A change that alters one says why in its message: `BITS=overwrite cargo test --workspace --test bits` renews the
//! table. The bits are the same on every machine. Paths of systems with all elementary functions are in `fixtures/portable.rs`; `tests/wasm/test` compares
//! those in WebAssembly.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test stops at the first error")]
#![allow(missing_docs, reason = "test systems")]

#[allow(unreachable_pub, reason = "a module of several crates")]
#[path = "fixtures/portable.rs"]
mod portable;

use fixtures::bath;
use fixtures::small::{DoubleWell, HenonHeiles, Kubo};
use wzvi::checkpoint::Checkpoint;
use wzvi::noise::Interval;
use wzvi::prelude::*;
use wzvi::state::Vector;

/// A mass that depends on the place: nothing is separable.
#[hamiltonian(
    drift = |q, p| 0.5 * (1.0 + q * q) * p * p + 0.25 * q.powi(4),
    noise = [|q, p| 0.2 * q * p],
    embedding = [Midpoint, Corrected<DeltaPlus>, Corrected<Lambda<1, 4>>, Uncorrected<Mixed<Midpoint, DeltaMinus>>, Gauss<2>, Gauss<4>],
)]
struct Metric;

/// Two particles with coupled fourth powers: separable, with a quadratic kinetic energy.
#[hamiltonian(
    drift = [
        |[x, y], [px, py]| 0.5 * (px * px + py * py + x * x + 2.0 * y * y),
        |[x, y], _| 0.1 * (x * x * y * y + (x - y).powi(4)),
    ],
    embedding = [DeltaPlus, DeltaMinus, Lambda<1, 4>, Midpoint, Verlet, Gauss<2>, Gauss<3>, Gauss<4>, Gauss<8>, Gauss<16>],
)]
struct Pair;

/// Wells on stiff springs, whose linear force the stages of Gauss split off.
#[hamiltonian(
    drift = |q: [f64; 6], p: [f64; 6]| {
        (0..6).map(|i| 0.5 * p[i] * p[i] + 0.25 * q[i].powi(4)).sum::<f64>() + (1..6).map(|i| 0.5 * k * (q[i] - q[i - 1]).powi(2)).sum::<f64>()
    },
    embedding = [Gauss<2>, Gauss<4>],
)]
struct Springs {
    k: f64,
}

/// A chain between walls, each site kicked by a noise of its own where `s` is not zero.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let v = |d: f64| 0.5 * d * d + 0.25 * d.powi(4);
        let n = q.len();
        p.iter().map(|p| 0.5 * p * p).sum::<f64>() + (1..n).map(|i| v(q[i] - q[i - 1])).sum::<f64>() + v(q[0]) + v(q[n - 1])
    },
    embedding = [DeltaPlus, DeltaMinus, Lambda<1, 4>, Midpoint, Verlet, Gauss<2>, Gauss<4>],
)]
struct Chain;

#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        p.iter().map(|p| 0.5 * p * p).sum::<f64>() + (1..q.len()).map(|i| 0.25 * (q[i] - q[i - 1]).powi(4)).sum::<f64>()
    },
    noise = [|q, p, k| 0.3 * q[k]; self.sites],
    embedding = [DeltaPlus, Midpoint, Verlet],
)]
struct Kicked {
    sites: usize,
}

/// Wells on a torus, each coupled to four neighbours.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        p.iter().map(|p| 0.5 * p * p).sum::<f64>()
            + (0..side).map(|i| (0..side).map(|j| {
                let own = q[i * side + j];
                let (right, down) = (q[i * side + (j + 1) % side], q[(i + 1) % side * side + j]);
                0.5 * ((right - own) * (right - own) + (down - own) * (down - own)) + 0.25 * (own * own - 1.0) * (own * own - 1.0)
            }).sum::<f64>()).sum::<f64>()
    },
    embedding = [DeltaPlus, Midpoint, Verlet],
)]
struct Torus {
    side: usize,
}

/// Bodies that attract each other.
#[hamiltonian(
    drift = |q: &[[f64; 3]], p: &[[f64; 3]]| {
        let kinetic: f64 = p.iter().map(|p| 0.5 * (p[0] * p[0] + p[1] * p[1] + p[2] * p[2])).sum();
        let pairs: f64 = (0..q.len()).map(|i| (0..i).map(|j| {
            let [x, y, z] = [q[i][0] - q[j][0], q[i][1] - q[j][1], q[i][2] - q[j][2]];
            1.0 / (x * x + y * y + z * z + 0.1).sqrt()
        }).sum::<f64>()).sum();
        kinetic - 0.1 * pairs
    },
    embedding = [DeltaPlus, Midpoint, Verlet],
)]
struct Bodies;

/// Springs between the sites of a table.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        p.iter().map(|p| 0.5 * p * p).sum::<f64>()
            + bonds.iter().map(|&[a, b]| 0.5 * (q[a] - q[b]).powi(2) + 0.25 * (q[a] - q[b]).powi(4)).sum::<f64>()
    },
    embedding = [DeltaPlus, Midpoint, Verlet],
)]
struct Network {
    bonds: Vec<[usize; 2]>,
}

impl Network {
    fn of(sites: usize) -> Self {
        let bonds = (0..3 * sites).map(|k| [k % sites, (k * k + k + 1) % sites]);
        Self { bonds: bonds.filter(|[a, b]| a != b).collect() }
    }
}

/// One line per run: its name, and a checksum of the bits of its numbers.
#[derive(Default)]
struct Table(Vec<String>);

impl Table {
    /// FNV-1a.
    fn row<'a>(&mut self, name: &str, numbers: impl IntoIterator<Item = &'a f64>) {
        let mut sum = 0xcbf2_9ce4_8422_2325_u64;
        for byte in numbers.into_iter().flat_map(|number| number.to_bits().to_le_bytes()) {
            sum = (sum ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
        self.0.push(format!("{sum:016x} {name}"));
    }

    /// A path of `system` in steps of `h`, and one in longer steps, from a start that is near `(q, p) = (0.4, 0.1)` at every site.
    fn steps<E, H: Discretized<E>>(&mut self, name: &str, system: &H, degrees: usize, h: f64) {
        let name = named::<E>(name, degrees);
        for h in [h, 1.5 * h] {
            let mut stepper = system.stepper::<E>(h).unwrap();
            let (mut state, mut noise) = (start::<H::Vector>(degrees), noise());
            let mut dw = vec![0.0; system.increments(degrees)];
            noise.prepare(&H::PLAN, h, dw.len(), 0.0).unwrap();
            for step in 0..STEPS {
                noise.increments(&Interval { start: 0.0, h, step }, &mut dw).unwrap();
                stepper.step(&mut state, &dw).unwrap();
            }
            self.row(&format!("{name}, h = {h}"), &numbers(&state));
        }
    }

    /// A run that is stopped and resumed, and an ensemble on one and three threads.
    fn runs<E, H>(&mut self, name: &str, system: &H, degrees: usize, h: f64)
    where
        H: Discretized<E> + Sync,
        H::Vector: Send + Sync,
    {
        let name = named::<E>(name, degrees);
        self.path::<E, H>(&name, system, degrees, h);
        self.ensemble::<E, H>(&name, system, degrees, h);
        self.ends_inside_a_step::<E, H>(&name, system, degrees, h);
    }

    /// A path that ends at a third of a step, stopped at half of one and resumed, and an ensemble.
    fn ends_inside_a_step<E, H>(&mut self, name: &str, system: &H, degrees: usize, h: f64)
    where
        H: Discretized<E> + Sync,
        H::Vector: Send + Sync,
    {
        let file = fixtures::folder!(name.replace(|c: char| !c.is_alphanumeric(), "_")).join("end");
        let [stop, end] = [STEPS as f64 / 3.0 + 0.5, STEPS as f64 + 1.0 / 3.0].map(|steps| steps * h);
        let run = |end: f64, to: &str| {
            let run = system.simulate::<E>(h).start(start::<H::Vector>(degrees)).until(end).record_every(0);
            let run = run.checkpoint(Checkpoint::to(file.with_extension(to)));
            let path = if system.increments(degrees) > 0 { run.noise(noise()).run() } else { run.run() };
            numbers(path.unwrap().last())
        };
        let whole = run(end, "whole");
        run(stop, "part");
        assert_eq!(run(end, "part"), whole, "{name}, stopped inside a step and resumed");
        self.row(&format!("{name}, ends inside a step"), &whole);
        let run = system.ensemble::<E>(h).start(start::<H::Vector>(degrees)).paths(PATHS).until(end);
        let run = if system.increments(degrees) > 0 { run.seed(7) } else { run };
        let run = run.keep_paths(1 << 24).run().unwrap();
        let kept = run.paths().unwrap();
        let ends: Vec<f64> = (0..kept.count()).flat_map(|path| kept.at(path, 1).unwrap().to_vec()).collect();
        self.row(&format!("{name}, ensemble that ends inside a step"), &ends);
    }

    fn path<E, H: Discretized<E>>(&mut self, name: &str, system: &H, degrees: usize, h: f64) {
        let file = fixtures::folder!(name.replace(|c: char| !c.is_alphanumeric(), "_")).join("run");
        let run = |steps, to: &str| {
            let run = system.simulate::<E>(h).start(start::<H::Vector>(degrees)).steps(steps).record_every(0);
            let run = run.checkpoint(Checkpoint::to(file.with_extension(to)));
            let path = if system.increments(degrees) > 0 { run.noise(noise()).run() } else { run.run() };
            numbers(path.unwrap().last())
        };
        let whole = run(STEPS, "whole");
        for stop in [0, 1, STEPS / 3] {
            let part = format!("part{stop}");
            run(stop, &part);
            assert_eq!(run(STEPS, &part), whole, "{name}, stopped after {stop} and resumed");
        }
        self.row(&format!("{name}, run"), &whole);
    }

    fn ensemble<E, H>(&mut self, name: &str, system: &H, degrees: usize, h: f64)
    where
        H: Discretized<E> + Sync,
        H::Vector: Send + Sync,
    {
        let run = |threads| {
            let starts = |draw: &mut wzvi::ensemble::Draw| {
                let mut state = start::<H::Vector>(degrees);
                state.q.components_mut()[0] += 0.01 * draw.path() as f64;
                state
            };
            let run = system
                .ensemble::<E>(h)
                .starts(starts)
                .paths(PATHS)
                .steps(STEPS)
                .keep_paths(1 << 24)
                .threads(threads);
            let run = if system.increments(degrees) > 0 { run.seed(7) } else { run };
            let run = run.run().unwrap();
            let kept = run.paths().unwrap();
            (0..kept.count()).flat_map(|path| kept.at(path, 1).unwrap().to_vec()).collect::<Vec<_>>()
        };
        let one = run(1);
        assert_eq!(run(3), one, "{name}, on three threads");
        self.row(&format!("{name}, ensemble"), &one);
    }
}

const STEPS: u64 = 12;
/// Two registers of lanes, and a part of a third.
const PATHS: u64 = 19;

fn named<E>(name: &str, degrees: usize) -> String {
    let scheme = std::any::type_name::<E>();
    let rooms = ["wzvi_runtime::", "scheme::", "embedding::", "compose::", "gauss::", "bath::"];
    format!(
        "{name} {degrees} {}",
        rooms.iter().fold(scheme.to_owned(), |scheme, room| scheme.replace(room, ""))
    )
}

fn numbers<V: Vector>(state: &State<V>) -> Vec<f64> {
    state.q.components().iter().chain(state.p.components()).chain([&state.t]).copied().collect()
}

fn noise() -> StepNormals {
    StepNormals::seed(7).path(3)
}

fn start<V: Vector>(degrees: usize) -> State<V> {
    let mut state = State { q: V::zeros(degrees), p: V::zeros(degrees), t: 0.0 };
    // Quarters of a polynomial: no function of `std`.
    let wave = |i: usize, shift: f64| {
        let x = ((i * 37 % 101) as f64 + shift) / 101.0;
        4.0 * x * (1.0 - x)
    };
    state.q.components_mut().iter_mut().enumerate().for_each(|(i, q)| *q = 0.8 * wave(i, 11.0));
    state.p.components_mut().iter_mut().enumerate().for_each(|(i, p)| *p = 0.3 - 0.5 * wave(i, 29.0));
    state
}

/// Calls a method of the table for a system of each of these sizes and each of these schemes.
macro_rules! with {
    ($table:ident.$method:ident, $name:literal, $system:expr, $degrees:expr, $h:literal: $($scheme:ty),* $(,)?) => {{
        let system = &$system;
        $( for degrees in $degrees { $table.$method::<$scheme, _>($name, system, degrees, $h); } )*
    }};
}

const BATH: bath::Oscillator = bath::Oscillator { m: 0.8, k: 1.3, b: 0.4, gamma: 0.6, kt: 0.7 };

fn small_steps(table: &mut Table) {
    with!(table.steps, "pair", Pair, [2], 0.1:
        DeltaPlus, DeltaMinus, Lambda<1, 4>, Midpoint, Verlet, Gauss<2>, Gauss<3>, Gauss<4>, Gauss<8>, Gauss<16>,
        Composed<Midpoint, Yoshida4>, Composed<Midpoint, Suzuki4>, Composed<Midpoint, Yoshida6>,
        Composed<Midpoint, KahanLi6>, Composed<Midpoint, SuzukiUmeno8>, Composed<Midpoint, KahanLi8>, Composed<Gauss<2>, Yoshida4>,
        Composed<Verlet, Yoshida4>, Composed<Verlet, Suzuki4>, Composed<Verlet, Yoshida6>, Composed<Verlet, KahanLi6>,
        Composed<Verlet, SuzukiUmeno8>, Composed<Verlet, KahanLi8>, Composed<Verlet, BlanesMoan4>, Composed<Verlet, BlanesMoan6>,
        Composed<Verlet, Srkn6>, Composed<Verlet, Aba864>, Composed<Verlet, Aba1064>, Composed<Verlet, Chin4>,
        Composed<Verlet, TakahashiImada4>,
    );
    with!(table.steps, "Henon-Heiles", HenonHeiles, [2], 0.1: DeltaPlus, Midpoint, Verlet, Gauss<2>);
    with!(table.steps, "metric", Metric, [1], 0.1:
        Midpoint, Corrected<DeltaPlus>, Corrected<Lambda<1, 4>>, Uncorrected<Mixed<Midpoint, DeltaMinus>>, Gauss<2>, Gauss<4>,
        Composed<Midpoint, Yoshida4>,
    );
    with!(table.steps, "Kubo", Kubo { a: 1.5, sigma: 1.0 }, [1], 0.05:
        Uncorrected<DeltaPlus>, Uncorrected<DeltaMinus>, Uncorrected<Lambda<1, 4>>, Corrected<DeltaPlus>, Mixed<DeltaPlus, Midpoint>, Midpoint,
    );
    with!(table.steps, "double well", DoubleWell { sigma: 0.3 }, [1], 0.1:
        Uncorrected<DeltaPlus>, Uncorrected<DeltaMinus>, Corrected<DeltaPlus>, Corrected<Lambda<1, 4>>, Midpoint,
    );
    with!(table.steps, "bath", BATH, [1], 0.1:
        Baoab, Obabo, Thermostat<Verlet>, Thermostat<Midpoint>, Thermostat<Gauss<2>>, Thermostat<Gauss<3>>);
    with!(table.steps, "springs", Springs { k: 400.0 }, [6], 0.1: Gauss<2>, Gauss<4>);
    let damping = [[0.6, 0.1], [0.1, 0.4]];
    with!(table.steps, "damping", bath::Coupled { m: 0.8, n: 1.3, k: 1.0, damping, kt: 0.7 }, [2], 0.1: Baoab, Obabo, Thermostat<Midpoint>);
    with!(table.steps, "driven bath", bath::Driven { sigma: 0.3, gamma: 0.6, kt: 0.7 }, [1], 0.1: Baoab, Obabo, Thermostat<Midpoint>);
}

fn steps_of_any_size(table: &mut Table) {
    with!(table.steps, "chain", Chain, [3, 17, 200, 1100], 0.1:
        DeltaPlus, DeltaMinus, Lambda<1, 4>, Midpoint, Verlet, Gauss<2>, Gauss<4>, Composed<Verlet, BlanesMoan6>, Composed<Verlet, Chin4>,
        Composed<Midpoint, Yoshida4>,
    );
    for sites in [3, 200] {
        with!(table.steps, "kicked", Kicked { sites }, [sites], 0.1: DeltaPlus, Midpoint, Verlet);
    }
    for side in [4, 20] {
        with!(table.steps, "torus", Torus { side }, [side * side], 0.1: DeltaPlus, Midpoint, Verlet);
    }
    with!(table.steps, "bodies", Bodies, [9, 60, 201], 0.05: DeltaPlus, Midpoint, Verlet);
    for sites in [5, 150] {
        with!(table.steps, "network", Network::of(sites), [sites], 0.05: DeltaPlus, Midpoint, Verlet);
    }
    with!(table.steps, "bath", bath::Chain { gamma: 0.6, kt: 0.7 }, [3, 200], 0.1: Baoab, Obabo, Thermostat<Midpoint>);
}

fn whole_runs(table: &mut Table) {
    with!(table.runs, "pair", Pair, [2], 0.1:
        Midpoint, Verlet, Gauss<4>, Gauss<8>, Composed<Midpoint, Yoshida4>, Composed<Verlet, BlanesMoan6>, Composed<Verlet, KahanLi8>,
        Composed<Verlet, Aba864>, Composed<Verlet, Chin4>,
    );
    with!(table.runs, "Kubo", Kubo { a: 1.5, sigma: 1.0 }, [1], 0.05: Corrected<DeltaPlus>, Midpoint);
    with!(table.runs, "double well", DoubleWell { sigma: 0.3 }, [1], 0.1: Midpoint);
    with!(table.runs, "bath", BATH, [1], 0.1: Baoab, Thermostat<Midpoint>);
    with!(table.runs, "chain", Chain, [3, 200], 0.1: DeltaPlus, Midpoint, Verlet);
    with!(table.runs, "kicked", Kicked { sites: 40 }, [40], 0.1: Midpoint, Verlet);
    with!(table.runs, "torus", Torus { side: 20 }, [400], 0.1: Midpoint);
    with!(table.runs, "bodies", Bodies, [60], 0.05: Verlet);
    with!(table.runs, "network", Network::of(150), [150], 0.05: DeltaPlus);
    with!(table.runs, "bath", bath::Chain { gamma: 0.6, kt: 0.7 }, [3, 200], 0.1: Baoab);
}

#[test]
fn every_run_has_the_bits_of_the_table() {
    let mut table = Table::default();
    small_steps(&mut table);
    steps_of_any_size(&mut table);
    whole_runs(&mut table);
    table.0.extend(portable::rows());
    let (file, text) = (concat!(env!("CARGO_MANIFEST_DIR"), "/data/bits.txt"), table.0.join("\n") + "\n");
    if std::env::var_os("BITS").is_some_and(|value| value == "overwrite") {
        std::fs::write(file, &text).unwrap();
    }
    let expected = std::fs::read_to_string(file).unwrap();
    let known: std::collections::HashSet<&str> = expected.lines().collect();
    let changed: Vec<&str> = text.lines().filter(|row| !known.contains(row)).collect();
    assert!(
        changed.is_empty() && known.len() == table.0.len(),
        "{} rows changed: {changed:#?}",
        changed.len()
    );
}
