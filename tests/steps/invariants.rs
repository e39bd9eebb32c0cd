//! What each scheme keeps exactly, to rounding, and how rounding adds up.
//!
//! A step rounds a few times, so that a kept quantity moves by about one unit `2^-53` of itself per step. If these
//! moves are unbiased they add up like a random walk, `sqrt(n)` of them after `n` steps: 1e-13 after a million. If they
//! are biased they add up to `n`: 1e-10. The bounds below lie between: they are some times the random walk.

use fixtures::small::{KUBO, Pendulum};
use fixtures::{Uniform, larger};
use wzvi::prelude::*;
use wzvi::system::Segment;

const UNIT: f64 = f64::EPSILON / 2.0;

/// Ten standard deviations of a random walk of `steps` roundings of a few units each, relative to the quantity.
fn random_walk(steps: u64) -> f64 {
    10.0 * 4.0 * UNIT * (steps as f64).sqrt()
}

/// An increment over `h` of a uniform law.
fn increment(random: &mut Uniform, h: f64) -> f64 {
    (3.0 * h.abs()).sqrt() * random.draw()
}

/// The largest relative drift of each quantity on the way, seen every 1000 steps, and the last.
fn drifts<E, H: Discretized<E>, const Q: usize>(
    system: &H,
    start: State<H::Vector>,
    h: f64,
    steps: u64,
    quantities: impl Fn(&State<H::Vector>) -> [f64; Q],
) -> [[f64; 2]; Q] {
    let mut stepper = system.stepper::<E>(h).unwrap();
    let mut random = Uniform(7);
    let mut state = start;
    let first = quantities(&state);
    let mut dw = vec![0.0; system.noises()];
    let mut drifts = [[0.0_f64; 2]; Q];
    for n in 1..=steps {
        dw.iter_mut().for_each(|dw| *dw = increment(&mut random, h));
        stepper.step(&mut state, &dw).unwrap();
        if n % 1000 == 0 {
            for ((drift, now), first) in drifts.iter_mut().zip(quantities(&state)).zip(first) {
                let relative = (now - first) / first;
                *drift = [larger(drift[0], relative.abs()), relative];
            }
        }
    }
    drifts
}

/// An isotropic oscillator whose frequency is noisy, and a noise that turns it.
#[hamiltonian(
    drift = |[x, y, z], [u, v, w]| 0.5 * (u * u + v * v + w * w) + 0.5 * k * (x * x + y * y + z * z),
    noise = [
        |[x, y, z], [u, v, w]| sigma * (u * u + v * v + w * w + k * (x * x + y * y + z * z)),
        |[x, y, _], [u, v, _]| sigma * (x * v - y * u),
    ],
    embedding = [Midpoint],
    invariant = [|[x, y, _], [u, v, _]| x * v - y * u],
)]
struct Oscillator {
    k: f64,
    sigma: f64,
}

#[hamiltonian(
    drift = |[x, y, z], [u, v, w]| 0.5 * (u * u + v * v + w * w) + 0.5 * k * (x * x + y * y + z * z),
    embedding = [Midpoint],
)]
struct Deterministic {
    k: f64,
}

const MILLION: u64 = 1_000_000;

#[test]
fn midpoint_keeps_the_radius_of_kubo() {
    let [radius] = drifts::<Midpoint, _, 1>(&KUBO, State::new([0.0], [1.0]), 0.02, MILLION, |state| {
        [KUBO.invariant(0, state)]
    });
    println!("Kubo, q² + p² after 10⁶ steps: {:.1e}, last {:.1e}", radius[0], radius[1]);
    assert!(radius[0] <= random_walk(MILLION), "{radius:?}");
}

fn angular_momentum(q: [f64; 3], p: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        q[j] * p[k] - q[k] * p[j]
    })
}

#[test]
fn midpoint_keeps_energy_and_angular_momentum_of_an_oscillator() {
    let start = State::new([1.0, 0.2, -0.3], [0.1, 0.9, 0.4]);
    let oscillator = Oscillator { k: 1.7, sigma: 0.3 };
    let drift = drifts::<Midpoint, _, 2>(&oscillator, start, 0.05, MILLION, |state| {
        [oscillator.energy(state), oscillator.invariant(0, state)]
    });
    println!("noisy oscillator, energy and L_z after 10⁶ steps: {drift:?}");
    assert!(drift.iter().all(|[largest, _]| *largest <= random_walk(MILLION)), "{drift:?}");

    let oscillator = Deterministic { k: 1.7 };
    let drift = drifts::<Midpoint, _, 4>(&oscillator, start, 0.05, MILLION, |state| {
        let [x, y, z] = angular_momentum(state.q.into(), state.p.into());
        [oscillator.energy(state), x, y, z]
    });
    println!("oscillator, energy and L after 10⁶ steps: {drift:?}");
    assert!(drift.iter().all(|[largest, _]| *largest <= random_walk(MILLION)), "{drift:?}");
}

/// Rotations keep the angular momentum, which is bilinear: not quadratic in q or in p alone.
#[hamiltonian(
    drift = |[x, y], [u, v]| 0.5 * (u * u + v * v) + 0.5 * (x * x + y * y) - (x * x + y * y + 0.25).sqrt().recip(),
    noise = [|[x, y], _| 0.1 * (0.1 * (x * x + y * y)).cos(), |[x, y], [u, v]| 0.1 * (0.2 * (x * u + y * v)).sin()],
    embedding = [
        Uncorrected<DeltaPlus>, Uncorrected<DeltaMinus>, Uncorrected<Lambda<1, 4>>, Uncorrected<Lambda<2, 3>>, Midpoint,
        Corrected<DeltaPlus>,
    ],
    invariant = [|[x, y], [u, v]| x * v - y * u],
)]
struct Central;

fn check_angular_momentum<E>(name: &str)
where
    Central: Discretized<E>,
{
    let start: State<<Central as Hamiltonian>::Vector> = State::new([1.0, 0.2], [0.1, 0.9]);
    let size = |state: &State<_>| {
        let State { q, p, .. }: &State<<Central as Hamiltonian>::Vector> = state;
        q.norm() * p.norm()
    };
    let steps = 20_000;
    let [momentum, growth] =
        drifts::<E, _, 2>(&Central, start, 0.01, steps, |state| [Central.invariant(0, state), size(state)]);
    // Roundings of x v - y u are those of |q| |p|, which is larger.
    let size = size(&start) * (1.0 + growth[0]) / Central.invariant(0, &start);
    println!("{name}: angular momentum after {steps} steps: {momentum:?} at size {size:.1}");
    assert!(momentum[0] <= random_walk(steps) * size, "{name}: {momentum:?} at size {size}");
}

#[test]
fn every_single_quadrature_point_keeps_bilinear_invariants() {
    check_angular_momentum::<Uncorrected<DeltaPlus>>("DeltaPlus");
    check_angular_momentum::<Uncorrected<DeltaMinus>>("DeltaMinus");
    check_angular_momentum::<Uncorrected<Lambda<1, 4>>>("Lambda<1, 4>");
    check_angular_momentum::<Uncorrected<Lambda<2, 3>>>("Lambda<2, 3>");
    check_angular_momentum::<Midpoint>("Midpoint");
    check_angular_momentum::<Corrected<DeltaPlus>>("Corrected<DeltaPlus>");
}

#[test]
fn other_points_do_not_keep_what_is_quadratic_in_q() {
    // The control: the bounds above would see it.
    let start = State::new([0.0], [1.0]);
    let [radius] =
        drifts::<Uncorrected<DeltaPlus>, _, 1>(&KUBO, start, 0.02, 1000, |state| [KUBO.invariant(0, state)]);
    assert!(radius[0] > 1e-3, "{radius:?}");
}

/// Not separable, with noises of two kinds, in explicit time.
#[hamiltonian(
    drift = |q, p, t| (1.0 + q * q) * p * p / 2.0 + (1.0 + 0.2 * t.sin()) * q.cosh(),
    noise = [|q, p| 0.3 * q * p, |q, p| 0.2 * (q + p).sin()],
    embedding = [
        Midpoint, Uncorrected<DeltaPlus>, Uncorrected<DeltaMinus>, Uncorrected<Mixed<Midpoint, DeltaMinus>>,
        Corrected<Mixed<DeltaMinus, Lambda<1, 4>>>,
    ],
)]
struct Metric;

fn check_residual<E, H: Discretized<E>>(system: &H, start: State<H::Vector>, name: &str) {
    use wzvi::state::Vector;
    let (h, mut random) = (0.01, Uniform(3));
    let (mut state, mut stepper) = (start, system.stepper::<E>(h).unwrap());
    let (mut residual, mut size) = (0.0_f64, 1.0_f64);
    let mut previous: Option<(Segment<H::Vector>, Vec<f64>)> = None;
    for _ in 0..2000 {
        let dw: Vec<f64> = (0..system.noises()).map(|_| increment(&mut random, h)).collect();
        let before = state.clone();
        stepper.step(&mut state, &dw).unwrap();
        let p = system.step_momentum(&before, &state, h, &dw);
        let segment = Segment { q0: before.q, q1: state.q.clone(), p, t: before.t, h };
        if let Some((previous, previous_dw)) = &previous {
            let left = system.euler_lagrange_residual(previous, &segment, previous_dw, &dw);
            let left = left.node.components().iter().chain(left.momentum.components());
            residual = left.fold(residual, |most, x| larger(most, x.abs()));
        }
        let numbers = state.q.components().iter().chain(state.p.components());
        size = numbers.fold(size, |size, x| larger(size, x.abs()));
        previous = Some((segment, dw));
    }
    println!("{name}: discrete Euler-Lagrange residual {residual:.1e} at size {size:.1}");
    // The node momenta and increments are rounded in the state: a few units of it, in each of the two equations.
    assert!(residual <= 16.0 * f64::EPSILON * size, "{name}: {residual:e} at size {size}");
}

#[test]
fn produced_paths_solve_the_discrete_euler_lagrange_equations() {
    check_residual::<Midpoint, _>(&Pendulum, State::new([1.0], [0.5]), "pendulum, Midpoint");
    check_residual::<DeltaPlus, _>(&Pendulum, State::new([1.0], [0.5]), "pendulum, DeltaPlus");
    check_residual::<DeltaMinus, _>(&Pendulum, State::new([1.0], [0.5]), "pendulum, DeltaMinus");
    check_residual::<Lambda<1, 4>, _>(&Pendulum, State::new([1.0], [0.5]), "pendulum, Lambda<1, 4>");
    check_residual::<Midpoint, _>(&KUBO, State::new([0.0], [1.0]), "Kubo, Midpoint");
    check_residual::<Uncorrected<DeltaPlus>, _>(&KUBO, State::new([0.0], [1.0]), "Kubo, DeltaPlus");
    check_residual::<Corrected<DeltaPlus>, _>(
        &Central,
        State::new([1.0, 0.2], [0.1, 0.9]),
        "central, Corrected",
    );
    macro_rules! metric {
        ($($scheme:ty),*) => {
            $(check_residual::<$scheme, _>(&Metric, State::new([0.4], [0.2]), stringify!($scheme));)*
        };
    }
    metric!(
        Midpoint,
        Uncorrected<DeltaPlus>,
        Uncorrected<DeltaMinus>,
        Uncorrected<Mixed<Midpoint, DeltaMinus>>,
        Corrected<Mixed<DeltaMinus, Lambda<1, 4>>>
    );
}

#[test]
fn the_energy_error_of_the_pendulum_is_bounded() {
    let h = 0.1;
    let mut stepper = Pendulum.stepper::<Midpoint>(h).unwrap();
    let mut state = State::new([2.0], [0.0]);
    let first = Pendulum.energy(&state);
    let mut windows = [0.0_f64; 10];
    for n in 0..100_000 {
        stepper.step(&mut state, &[]).unwrap();
        let window = &mut windows[n / 10_000];
        *window = larger(*window, (Pendulum.energy(&state) - first).abs());
    }
    println!("pendulum, h = {h}, energy error per 10⁴ steps: {windows:?}");
    // H - H_h = (h²/24) H''(X, X) + O(h⁴) with X the field: at most (p² + sin² q)/24 h² ≈ 0.16 h² on this orbit, twice
    // that between two points.
    assert!(windows[0] <= 0.3 * h * h, "{windows:?}");
    // No trend: the same orbit is sampled at other phases, and rounding adds 1e-13.
    assert!(windows.iter().all(|window| (window - windows[0]).abs() <= 1e-3 * windows[0]), "{windows:?}");
}
