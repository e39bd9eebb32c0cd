//! What the tests run, and how they compare.

use wzvi::nalgebra::SVector;
use wzvi::prelude::*;
use wzvi::simulate::Simulation;

/// Newton's method with a memory of past steps.
#[hamiltonian(
    drift = |[x, y], [px, py]| (px * px + py * py) / (2.0 * mass) - 1.0 / x.hypot(y),
    embedding = [Midpoint, DeltaPlus],
)]
#[derive(Clone, Debug)]
pub(crate) struct Kepler {
    pub(crate) mass: f64,
}

pub(crate) const KEPLER: Kepler = Kepler { mass: 1.0 };

impl Kepler {
    pub(crate) fn start() -> State<SVector<f64, 2>> {
        State::new([0.5, 0.0], [0.0, 3.0_f64.sqrt()]).at(0.25)
    }

    pub(crate) fn run(&self, steps: u64, every: u64) -> Simulation<'_, Self, Midpoint> {
        self.simulate(0.01).start(Self::start()).steps(steps).record_every(every)
    }
}

/// A step that is dear enough for compensated sums: two rods of length 1 and mass 1, angles from hanging in rad.
#[hamiltonian(
    drift = |[a, b], [pa, pb]| {
        let (sin, cos) = (a - b).sin_cos();
        let kinetic = (pa * pa + 2.0 * pb * pb - 2.0 * pa * pb * cos) / (2.0 * (1.0 + sin * sin));
        kinetic - 2.0 * a.cos() - b.cos()
    },
    embedding = Midpoint,
)]
#[derive(Clone, Debug)]
pub(crate) struct DoublePendulum;

impl DoublePendulum {
    pub(crate) fn run(&self, steps: u64, every: u64) -> Simulation<'_, Self, Midpoint> {
        self.simulate(0.01).start(State::new([2.0, 2.5], [0.0, 0.0])).steps(steps).record_every(every)
    }
}

/// Two noises, one of which multiplies: Newton's method without a memory.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p - a * q.cos(),
    noise = [|q, p| sigma * q.sin() * p.cos(), |q, p| 0.1 * q],
    embedding = Midpoint,
)]
#[derive(Clone, Debug)]
pub(crate) struct Pendulum {
    pub(crate) a: f64,
    pub(crate) sigma: f64,
}

pub(crate) const PENDULUM: Pendulum = Pendulum { a: 1.5, sigma: 0.3 };

impl Pendulum {
    pub(crate) fn run<N: Noise>(
        &self,
        noise: N,
        steps: u64,
        every: u64,
    ) -> Simulation<'_, Self, Midpoint, N> {
        let start = State::new([0.5], [0.0]);
        self.simulate(0.02).start(start).noise(noise).steps(steps).record_every(every)
    }
}

/// The solution of a step with `h > 2` may end at a fold, that of a shorter one cannot: in a run of long steps some have
/// to be halved.
#[hamiltonian(drift = |q, p| 0.5 * p * p - q.cos(), noise = [|q, p| 0.5 * q], embedding = Midpoint)]
#[derive(Clone, Debug)]
pub(crate) struct Folding;

impl Folding {
    pub(crate) fn run(&self, steps: u64, every: u64) -> Simulation<'_, Self, Midpoint, Wiener> {
        let run = self.simulate(2.5).start(State::new([2.2], [0.8])).noise(Wiener::seed(14));
        run.steps(steps).record_every(every).retry(Retry::halving(10))
    }
}

/// Every step of this run is hard. The extrapolation of the first three is near another branch than that of the fourth.
#[hamiltonian(drift = |q, p| 0.5 * p * p + 2.0 * q.powi(4) - 3.0 * q * q, embedding = Midpoint)]
#[derive(Clone, Debug)]
pub(crate) struct Wells;

impl Wells {
    pub(crate) fn run(&self, steps: u64, every: u64) -> Simulation<'_, Self, Midpoint> {
        let start = State::new([-0.7713954891219279], [1.2232998105796071]);
        self.simulate(1.1788991315147956).start(start).steps(steps).record_every(every).unwatched()
    }
}

/// A trajectory as bits: `==` on numbers takes zeros of both signs for one.
pub(crate) fn bits<const D: usize, E>(path: &Trajectory<SVector<f64, D>, E>) -> Vec<u64> {
    let states = path.iter().chain([path.last()]);
    let numbers = states.flat_map(|state| state.q.iter().chain(state.p.iter()).chain([&state.t]));
    let numbers = numbers.chain(path.increments().flatten()).map(|number| number.to_bits());
    let iterations = path.iterations();
    let counts = [path.steps(), path.stride(), iterations.total, u64::from(iterations.largest)];
    numbers.chain(counts).chain([path.len() as u64, path.step_size().to_bits()]).collect()
}
