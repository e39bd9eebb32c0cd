//! The scenes, generated and by hand, each as a loop of steps.

use std::hint::black_box;

use wzvi::prelude::*;
use wzvi::state::{Components, Vector};
use wzvi::system::MemoryOf;

use crate::by_hand;

/// A loop of steps under a name.
pub(crate) struct Case {
    pub(crate) name: &'static str,
    pub(crate) run: fn(u64) -> Outcome,
}

/// Where a loop ended and how many iterations it took.
pub(crate) struct Outcome {
    pub(crate) state: Vec<f64>,
    pub(crate) iterations: u64,
}

impl Outcome {
    /// The largest difference of a component.
    pub(crate) fn distance(&self, other: &Self) -> f64 {
        self.state.iter().zip(&other.state).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }
}

#[hamiltonian(
    drift = |q, p| 0.5 * a * (q * q + p * p),
    noise = [|q, p| 0.5 * sigma * (q * q + p * p)],
    embedding = Midpoint,
)]
struct Kubo {
    a: f64,
    sigma: f64,
}

#[hamiltonian(
    drift = |q, p| 0.5 * (q * q + p * p),
    noise = [|_, p| sigma * p, |q, _| -gamma * q],
    embedding = Midpoint,
)]
struct TwoAdditive {
    sigma: f64,
    gamma: f64,
}

#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.25 * (q * q - 1.0).powi(2),
    noise = [|q, p| sigma * q * p],
    embedding = Midpoint,
)]
struct DoubleWell {
    sigma: f64,
}

#[hamiltonian(
    drift = |q, p| 0.5 * p * p - q.cos(),
    embedding = [Midpoint, DeltaPlus],
)]
struct Pendulum;

#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) - mu / (x * x + y * y).sqrt(),
    embedding = Midpoint,
)]
struct Kepler {
    mu: f64,
}

#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py + x * x + y * y) + x * x * y - y.powi(3) / 3.0,
    embedding = Midpoint,
)]
struct HenonHeiles;

const KUBO: (Kubo, f64) = (Kubo { a: 1.5, sigma: 1.0 }, 0.02);
const ADDITIVE: (TwoAdditive, f64) = (TwoAdditive { sigma: 0.5, gamma: 1.0 }, 0.02);
const WELL: (DoubleWell, f64) = (DoubleWell { sigma: 0.3 }, 0.01);
const PENDULUM: (Pendulum, f64) = (Pendulum, 0.1);
const KEPLER: (Kepler, f64) = (Kepler { mu: 1.0 }, std::f64::consts::TAU / 500.0);
const HENON: (HenonHeiles, f64) = (HenonHeiles, 0.1);

/// Increments of variance `h`, near enough: sums of uniforms. Every run starts anew after these 512 steps: noise that
/// repeats heats a system without end.
fn table(h: f64) -> [f64; 512] {
    let mut seed = 7_u64;
    let mut uniform = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    std::array::from_fn(|_| h.sqrt() * (0..12).map(|_| uniform()).sum::<f64>())
}

/// The numbers of `n` steps, run by run.
fn runs(n: u64) -> impl Iterator<Item = std::ops::Range<usize>> {
    (0..n as usize).step_by(512).map(move |first| first..(first + 512).min(n as usize))
}

/// Of a state that is moved here, as that by hand is: nobody keeps its address.
fn outcome<V: Vector>(state: State<V>, iterations: u64) -> Outcome {
    black_box(state.t);
    let state = state.q.components().iter().chain(state.p.components()).copied().collect();
    Outcome { state, iterations }
}

/// Steps with `K` increments each through the stepper.
fn stepped<E, H: Discretized<E>, const K: usize>(
    (system, h): (H, f64),
    start: State<H::Vector>,
    n: u64,
) -> Outcome {
    let (system, h, dw) = (black_box(system), black_box(h), table(h));
    let mut stepper = system.stepper::<E>(h).unwrap();
    // On the stack of this function, as the state by hand is.
    let mut state = start.clone();
    let mut iterations = 0;
    for run in runs(n) {
        state.clone_from(&start);
        for i in run {
            let dw: [f64; K] = std::array::from_fn(|k| dw[(i + 100 * k) % 512]);
            iterations += u64::from(stepper.step(&mut state, &dw).unwrap().iterations);
        }
    }
    outcome(state, iterations)
}

/// The same through the bare map.
fn advanced<E, H: Discretized<E>, const K: usize>(
    (system, h): (H, f64),
    start: State<H::Vector>,
    n: u64,
) -> Outcome {
    let (system, h, dw) = (black_box(system), black_box(h), table(h));
    let prepared = system.prepare(h).unwrap();
    let mut memory = MemoryOf::<H, E, f64>::default();
    // On the stack of this function, as the state by hand is.
    let mut state = start.clone();
    let mut iterations = 0;
    for run in runs(n) {
        state.clone_from(&start);
        for i in run {
            let dw: [f64; K] = std::array::from_fn(|k| dw[(i + 100 * k) % 512]);
            let (q, p) = (state.q.components_mut(), state.p.components_mut());
            let solved = system.advance::<f64>(&prepared, i as f64 * h, h, q, p, &dw, &mut memory).unwrap();
            iterations += u64::from(solved.iterations);
        }
    }
    outcome(state, iterations)
}

/// The same through what is written by hand.
fn by_hand<S: by_hand::Step<D, K>, const D: usize, const K: usize>(
    prepare: impl Fn(f64) -> S,
    h: f64,
    start: [[f64; D]; 2],
    n: u64,
) -> Outcome {
    let h = black_box(h);
    let (mut stepper, dw) = (prepare(h), table(h));
    let mut state = by_hand::State { q: start[0], p: start[1], t: 0.0 };
    let mut iterations = 0;
    for run in runs(n) {
        (state.q, state.p) = (start[0], start[1]);
        for i in run {
            let dw: [f64; K] = std::array::from_fn(|k| dw[(i + 100 * k) % 512]);
            iterations += u64::from(stepper.step(&mut state, dw).unwrap());
        }
    }
    black_box(state.t);
    Outcome { state: state.q.into_iter().chain(state.p).collect(), iterations }
}

const KUBO_START: [[f64; 1]; 2] = [[0.0], [1.0]];
const WELL_START: [[f64; 1]; 2] = [[0.5], [0.5]];
const PENDULUM_START: [[f64; 1]; 2] = [[2.0], [0.0]];
const KEPLER_START: [[f64; 2]; 2] = [[0.4, 0.0], [0.0, 2.0]];
const HENON_START: [[f64; 2]; 2] = [[0.1, -0.2], [0.3, 0.15]];

fn state<const D: usize, V: Vector>([q, p]: [[f64; D]; 2]) -> State<V>
where
    [f64; D]: Components<V>,
{
    State::new(q, p)
}

pub(crate) const CASES: &[Case] = &[
    Case { name: "kubo-midpoint-step", run: |n| stepped::<Midpoint, _, 1>(KUBO, state(KUBO_START), n) },
    Case { name: "kubo-midpoint-advance", run: |n| advanced::<Midpoint, _, 1>(KUBO, state(KUBO_START), n) },
    Case {
        name: "kubo-midpoint-by-hand",
        run: |n| by_hand(|h| by_hand::Kubo::new(1.5, 1.0, h), KUBO.1, KUBO_START, n),
    },
    Case {
        name: "additive-midpoint-step",
        run: |n| stepped::<Midpoint, _, 2>(ADDITIVE, state(KUBO_START), n),
    },
    Case {
        name: "additive-midpoint-advance",
        run: |n| advanced::<Midpoint, _, 2>(ADDITIVE, state(KUBO_START), n),
    },
    Case {
        name: "additive-midpoint-by-hand",
        run: |n| by_hand(|h| by_hand::TwoAdditive::new(0.5, 1.0, h), ADDITIVE.1, KUBO_START, n),
    },
    Case { name: "well-midpoint-step", run: |n| stepped::<Midpoint, _, 1>(WELL, state(WELL_START), n) },
    Case { name: "well-midpoint-advance", run: |n| advanced::<Midpoint, _, 1>(WELL, state(WELL_START), n) },
    Case {
        name: "well-midpoint-by-hand",
        run: |n| by_hand(|h| by_hand::DoubleWell::new(0.3, h), WELL.1, WELL_START, n),
    },
    Case {
        name: "pendulum-midpoint-step",
        run: |n| stepped::<Midpoint, _, 0>(PENDULUM, state(PENDULUM_START), n),
    },
    Case {
        name: "pendulum-midpoint-advance",
        run: |n| advanced::<Midpoint, _, 0>(PENDULUM, state(PENDULUM_START), n),
    },
    Case {
        name: "pendulum-midpoint-by-hand",
        run: |n| by_hand(by_hand::Pendulum::new, PENDULUM.1, PENDULUM_START, n),
    },
    Case {
        name: "pendulum-deltaplus-step",
        run: |n| stepped::<DeltaPlus, _, 0>(PENDULUM, state(PENDULUM_START), n),
    },
    Case {
        name: "pendulum-deltaplus-advance",
        run: |n| advanced::<DeltaPlus, _, 0>(PENDULUM, state(PENDULUM_START), n),
    },
    Case {
        name: "pendulum-deltaplus-by-hand",
        run: |n| by_hand(by_hand::PendulumEuler::new, PENDULUM.1, PENDULUM_START, n),
    },
    Case { name: "kepler-midpoint-step", run: |n| stepped::<Midpoint, _, 0>(KEPLER, state(KEPLER_START), n) },
    Case {
        name: "kepler-midpoint-advance",
        run: |n| advanced::<Midpoint, _, 0>(KEPLER, state(KEPLER_START), n),
    },
    Case {
        name: "kepler-midpoint-by-hand",
        run: |n| by_hand(by_hand::Kepler::new, KEPLER.1, KEPLER_START, n),
    },
    Case {
        name: "henon-heiles-midpoint-step",
        run: |n| stepped::<Midpoint, _, 0>(HENON, state(HENON_START), n),
    },
    Case {
        name: "henon-heiles-midpoint-advance",
        run: |n| advanced::<Midpoint, _, 0>(HENON, state(HENON_START), n),
    },
    Case {
        name: "henon-heiles-midpoint-by-hand",
        run: |n| by_hand(by_hand::HenonHeiles::new, HENON.1, HENON_START, n),
    },
];

pub(crate) const PAIRS: &[[&str; 3]] = &[
    ["kubo-midpoint-step", "kubo-midpoint-advance", "kubo-midpoint-by-hand"],
    ["additive-midpoint-step", "additive-midpoint-advance", "additive-midpoint-by-hand"],
    ["well-midpoint-step", "well-midpoint-advance", "well-midpoint-by-hand"],
    ["pendulum-midpoint-step", "pendulum-midpoint-advance", "pendulum-midpoint-by-hand"],
    ["pendulum-deltaplus-step", "pendulum-deltaplus-advance", "pendulum-deltaplus-by-hand"],
    ["kepler-midpoint-step", "kepler-midpoint-advance", "kepler-midpoint-by-hand"],
    ["henon-heiles-midpoint-step", "henon-heiles-midpoint-advance", "henon-heiles-midpoint-by-hand"],
];
