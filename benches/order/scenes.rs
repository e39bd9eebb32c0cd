//! Systems, where they start, how long they run, and where they end.

use wzvi::prelude::*;
use wzvi::state::Vector;

#[path = "planets.rs"]
mod planets;

/// `H = p²/2 - cos q`
#[hamiltonian(
    drift = |q, p| 0.5 * p * p - q.cos(),
    embedding = [Midpoint, Verlet, Gauss<2>, Gauss<4>, Gauss<6>, Gauss<8>, Gauss<16>],
)]
pub(crate) struct Pendulum;

/// The Kepler problem in the plane.
#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) - 1.0 / (x * x + y * y).sqrt(),
    embedding = [Midpoint, Verlet, Gauss<2>, Gauss<4>, Gauss<6>, Gauss<8>, Gauss<16>],
)]
pub(crate) struct Kepler;

#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py + x * x + y * y) + x * x * y - y * y * y / 3.0,
    embedding = [Midpoint, Verlet, Gauss<2>, Gauss<4>, Gauss<6>, Gauss<8>, Gauss<16>],
)]
pub(crate) struct HenonHeiles;

/// The sun with the inner planets, Jupiter, Saturn, Uranus, Neptune and Pluto, in astronomical units, days and solar masses.
#[hamiltonian(
    drift = |q: [[f64; 3]; 6], p: [[f64; 3]; 6]| {
        (0..6).map(|i| (0..3).map(|k| p[i][k] * p[i][k]).sum::<f64>() / (2.0 * mass[i])).sum::<f64>()
            - (0..6).map(|i| (0..i).map(|j| {
                let square: f64 = (0..3).map(|k| (q[i][k] - q[j][k]).powi(2)).sum();
                g * mass[i] * mass[j] / square.sqrt()
            }).sum::<f64>()).sum::<f64>()
    },
    embedding = [Midpoint, Verlet, Gauss<2>, Gauss<4>, Gauss<6>, Gauss<8>, Gauss<16>],
)]
pub(crate) struct SolarSystem {
    g: f64,
    mass: [f64; 6],
}

/// A Fermi-Pasta-Ulam-Tsingou chain (β) with fixed ends.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let v = |d: f64| 0.5 * d * d + 0.25 * beta * d * d * d * d;
        let n = q.len();
        p.iter().map(|p| 0.5 * p * p).sum::<f64>() + v(q[0]) + (1..n).map(|i| v(q[i] - q[i - 1])).sum::<f64>() + v(-q[n - 1])
    },
    embedding = [Midpoint, Verlet, Gauss<2>, Gauss<4>, Gauss<6>, Gauss<8>, Gauss<16>],
)]
pub(crate) struct Fput {
    beta: f64,
}

/// One system to integrate.
pub(crate) struct Scene<H: Hamiltonian> {
    pub(crate) name: &'static str,
    pub(crate) title: &'static str,
    pub(crate) system: H,
    pub(crate) start: State<H::Vector>,
    /// Time at the end.
    pub(crate) end: f64,
    /// The state there.
    pub(crate) exact: State<H::Vector>,
    /// Steps of the coarsest run.
    pub(crate) fewest: u32,
}

/// The distance of two states, Euclidean in `(q, p)`, relative to the second.
pub(crate) fn distance<V: Vector>(a: &State<V>, b: &State<V>) -> f64 {
    let numbers = |state: &State<V>| -> Vec<f64> {
        state.q.components().iter().chain(state.p.components()).copied().collect()
    };
    let (a, b) = (numbers(a), numbers(b));
    let square = |numbers: &mut dyn Iterator<Item = f64>| numbers.map(|x| x * x).sum::<f64>();
    let apart = square(&mut a.iter().zip(&b).map(|(a, b)| a - b));
    (apart / square(&mut b.iter().copied())).sqrt()
}

/// Where `steps` steps of `Gauss<8>`, many more than any run takes, lead.
fn followed<H>(system: &H, start: &State<H::Vector>, end: f64, steps: u32) -> State<H::Vector>
where
    H: Discretized<Gauss<8>>,
{
    let mut state = start.clone();
    let mut stepper = system.stepper::<Gauss<8>>(end / f64::from(steps)).unwrap();
    for _ in 0..steps {
        stepper.step(&mut state, &[]).unwrap();
    }
    state
}

/// From (2, 0) to T = 100; the exact state is that of the elliptic functions.
pub(crate) fn pendulum() -> Scene<Pendulum> {
    let exact = State::new([1.982_325_653_157_030_5], [0.179_640_742_590_940_2]);
    let start = State::new([2.0], [0.0]);
    let title = "Pendulum from (2, 0) to T = 100";
    Scene { name: "pendulum", title, system: Pendulum, start, end: 100.0, exact, fewest: 25 }
}

/// A hundred orbits of eccentricity 0.6, which end where they begin.
pub(crate) fn kepler() -> Scene<Kepler> {
    let start = State::new([0.4, 0.0], [0.0, 2.0]);
    let (title, end) = ("Kepler problem, e = 0.6, 100 orbits", 200.0 * std::f64::consts::PI);
    Scene { name: "kepler", title, system: Kepler, start, end, exact: start, fewest: 800 }
}

pub(crate) fn henon_heiles() -> Scene<HenonHeiles> {
    let start = State::new([0.0, 0.3], [0.4, 0.0]);
    let end = 200.0;
    let exact = followed(&HenonHeiles, &start, end, 2000);
    let title = "Hénon-Heiles from (0, 0.3, 0.4, 0) to T = 200";
    Scene { name: "henon_heiles", title, system: HenonHeiles, start, end, exact, fewest: 50 }
}

pub(crate) fn solar_system() -> Scene<SolarSystem> {
    let (mass, q, p) = planets::outer();
    let (system, start, end) = (SolarSystem { g: 2.959_122_082_86e-4, mass }, State::new(q, p), 1e5);
    let exact = followed(&system, &start, end, 2000);
    let title = "Outer solar system over 1e5 days";
    Scene { name: "solar_system", title, system, start, end, exact, fewest: 100 }
}

/// 1024 particles with momenta between -1 and 1 (multiples of the golden section): all modes have energy.
pub(crate) fn fput() -> Scene<Fput> {
    let n = 1024;
    let momentum = |i: usize| 2.0 * (0.618_033_988_749_894_9 * i as f64).fract() - 1.0;
    let start = State::new(vec![0.0; n], (0..n).map(momentum).collect::<Vec<_>>());
    let (system, end) = (Fput { beta: 0.25 }, 10.0);
    let exact = followed(&system, &start, end, 400);
    let title = "FPUT-β chain, 1024 particles with momenta of all modes, to T = 10";
    Scene { name: "fput", title, system, start, end, exact, fewest: 25 }
}
