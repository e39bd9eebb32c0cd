//! The modified energy: its terms against known ones, and how its drift falls with the step size.

use fixtures::larger;
use fixtures::small::{HenonHeiles, Pendulum};
use fixtures::stiff::Fput;
use wzvi::modified::{Conservative, ModifiedBy, ModifiedHamiltonian};
use wzvi::prelude::*;
use wzvi::state::Vector;

#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.5 * omega * omega * q * q,
    embedding = [Verlet, Midpoint, DeltaPlus, DeltaMinus, Lambda<1, 4>],
)]
struct Oscillator {
    omega: f64,
}

/// Neither separable nor even in the momenta.
#[hamiltonian(
    drift = |[x, y], [px, py]|
        0.5 * (1.0 + 0.3 * x * x) * px * px + 0.5 * (1.2 + (x - y).sin()) * py * py + 0.2 * px * py * y
            + 0.25 * x.powi(4) + 0.5 * y * y + 0.3 * px * y,
    embedding = [Verlet, Midpoint, DeltaPlus, DeltaMinus, Lambda<1, 4>],
)]
struct Entangled;

/// Sites that are coupled through coordinates and momenta together, in loops.
#[hamiltonian(
    drift = |q: [f64; N], p: [f64; N]|
        (0..N).map(|i| 0.5 * p[i] * p[i] * (1.0 + 0.2 * q[i] * q[(i + 1) % N]) + 0.25 * q[i].powi(4)).sum::<f64>(),
    embedding = [Verlet, Midpoint, DeltaPlus],
)]
struct Ring<const N: usize>;

/// The drifts of the energy and of the modified energy over a run to `end`.
fn drifts<E: ModifiedBy, H>(system: &H, start: &State<H::Vector>, end: f64, steps: u64) -> [f64; 2]
where
    H: Discretized<E> + Conservative,
{
    let h = end / steps as f64;
    let modified = ModifiedHamiltonian::<E>::new(h);
    let (mut state, mut stepper) = (start.clone(), system.stepper::<E>(h).unwrap());
    let energies = |state: &State<H::Vector>| [system.energy(state), modified.energy(system, state)];
    let (first, mut drifts) = (energies(start), [0.0_f64; 2]);
    for _ in 0..steps {
        stepper.step(&mut state, &[]).unwrap();
        let now = energies(&state);
        drifts = [0, 1].map(|i| larger(drifts[i], (now[i] - first[i]).abs()));
    }
    drifts
}

/// The drift of the modified energy falls by two to the power `order` where the step is halved. A quarter of a power is
/// what terms of the next orders make at these step sizes.
fn check<E: ModifiedBy, H>(name: &str, system: &H, start: &State<H::Vector>, steps: u64, order: f64)
where
    H: Discretized<E> + Conservative,
{
    let [coarse, fine] = [steps, 2 * steps].map(|steps| drifts::<E, H>(system, start, 6.0, steps));
    let slope = (coarse[1] / fine[1]).log2();
    assert!(slope > order - 0.25, "{name}: {slope} instead of {order}, from {coarse:?} to {fine:?}");
    assert!(fine[1] < 0.5 * fine[0], "{name}: {fine:?}");
}

macro_rules! check {
    ($system:expr, $start:expr; $($scheme:ty, $steps:literal, $order:literal);+ $(;)?) => {$(
        check::<$scheme, _>(stringify!($scheme of $system), &$system, &$start, $steps, f64::from($order));
    )+};
}

/// The first term takes what falls with the order of the scheme: what is left falls with the next order, `h³` for schemes of
/// order 1, whose two first terms are known, `h⁴` for symmetric schemes of order 2, `h⁶` and `h⁸` for compositions of order 4 and 6.
#[test]
fn the_drift_falls_with_the_next_order() {
    check!(Pendulum, State::new([1.5], [0.3]);
        DeltaPlus, 200, 3; Midpoint, 100, 4; Verlet, 100, 4;
        Composed<Midpoint, Yoshida4>, 60, 6; Composed<Verlet, Yoshida4>, 80, 6;
        Composed<Midpoint, KahanLi6>, 15, 8; Composed<Verlet, BlanesMoan6>, 22, 8;
    );
    check!(HenonHeiles, State::new([0.12, 0.1], [0.3, -0.25]);
        DeltaMinus, 200, 3; Verlet, 100, 4; Composed<Verlet, Suzuki4>, 30, 6;
    );
    check!(Entangled, State::new([0.5, 0.2], [0.3, -0.4]);
        Composed<Verlet, KahanLi6>, 30, 8;
        DeltaPlus, 400, 3; DeltaMinus, 400, 3; Lambda<1, 4>, 400, 3; Midpoint, 100, 4; Verlet, 100, 4;
        Composed<Midpoint, Suzuki4>, 40, 6; Composed<Verlet, Suzuki4>, 40, 6; Composed<Verlet, BlanesMoan4>, 40, 6;
    );
}

#[test]
fn the_drift_falls_with_the_next_order_in_loops() {
    let chain = Fput { alpha: 0.25, beta: 0.0 };
    let start = |n: usize| {
        let q: Vec<f64> = (1..=n).map(|i| (i as f64 * 0.3).sin()).collect();
        State::new(q, vec![0.1; n])
    };
    check!(chain, start(32);
        DeltaPlus, 200, 3; Midpoint, 80, 4; Verlet, 80, 4; Composed<Verlet, Suzuki4>, 30, 6;
    );
    let q = std::array::from_fn(|i| 0.5 * (i as f64).cos());
    let p = std::array::from_fn(|i| 0.5 * (2.0 * i as f64).sin());
    check!(Ring::<24>, State::new(q, p);
        DeltaPlus, 200, 3; Midpoint, 60, 4; Verlet, 60, 4; Composed<Verlet, Suzuki4>, 30, 6;
    );
}

/// For the harmonic oscillator the modified Hamiltonian is known to all orders: that of `Midpoint` turns by `2 atan(ω h / 2)`
/// in each step, so that it is `2 atan(ω h / 2) / (ω h)` times the energy.
#[test]
fn the_terms_of_the_oscillator_are_exact() {
    let omega = 1.3;
    let (system, state, h) = (Oscillator { omega }, State::new([0.7], [-0.4]), 0.05);
    let energy = system.energy(&state);
    let ([q], [p]) = ([state.q[0]], [state.p[0]]);
    let s = omega * omega * h * h;
    // A few roundings of the energy, 0.5.
    let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-15, "{a} instead of {b}");
    close(system.shadow_energy::<Midpoint>(&state, h), energy * (1.0 - s / 12.0));
    let kinetic = 0.5 * p * p;
    let potential = energy - kinetic;
    close(system.shadow_energy::<Verlet>(&state, h), energy + s * (kinetic / 6.0 - potential / 12.0));
    let product = omega * omega * q * p;
    close(system.shadow_energy::<DeltaPlus>(&state, h), energy * (1.0 + s / 6.0) - 0.5 * h * product);
    close(system.shadow_energy::<DeltaMinus>(&state, h), energy * (1.0 + s / 6.0) + 0.5 * h * product);
    // 2 Σ atan(γ ω h / 2) / (ω h) = Σ γ - Σ γ³ s / 12 + Σ γ⁵ s² / 80, where the weights make the second sum vanish.
    let gamma = [1.0 / (2.0 - 2f64.cbrt()), -2f64.cbrt() / (2.0 - 2f64.cbrt())];
    let fifth = 2.0 * gamma[0].powi(5) + gamma[1].powi(5);
    let composed = system.shadow_energy::<Composed<Midpoint, Yoshida4>>(&state, h);
    close(composed, energy * (1.0 + fifth * s * s / 80.0));
}

/// One formula: loops and straight-line code give the same, for a system of both sizes.
#[test]
fn loops_and_straight_lines_agree() {
    let at = |n: usize, i: usize| ((i + n) as f64 * 0.7).sin();
    let few: State<wzvi::nalgebra::SVector<f64, 2>> = State::new([at(0, 0), at(0, 1)], [at(5, 0), at(5, 1)]);
    let ring = Ring::<2>;
    let by_hand = |h: f64| {
        // Two sites that are each other's neighbours, written out.
        let (q, p) = (few.q, few.p);
        let rate = |i: usize| p[i] * (1.0 + 0.2 * q[0] * q[1]);
        let force = |i: usize| 0.1 * q[1 - i] * (p[0] * p[0] + p[1] * p[1]) + q[i].powi(3);
        ring.energy(&few) - 0.5 * h * (rate(0) * force(0) + rate(1) * force(1))
    };
    // The term of h² is what is left.
    let left = |h: f64| ring.shadow_energy::<DeltaPlus>(&few, h) - by_hand(h);
    assert!((left(1e-2) / left(5e-3) - 4.0).abs() < 1e-9, "{}", left(1e-2) / left(5e-3));
}

/// A longer run does not drift further, which is the point: and where the step is too long for the motion, the modified
/// energy says so.
#[test]
fn it_tells_whether_a_run_is_in_its_regime() {
    let start = State::new([2.0], [0.0]);
    let [energy, shadow] = drifts::<Verlet, _>(&Pendulum, &start, 1000.0, 10_000);
    assert!(shadow < 1e-2 * energy, "{energy} {shadow}");
    // A path says the same of itself.
    let path = Pendulum.simulate::<Verlet>(0.1).start(start).steps(10_000).unwatched().run().unwrap();
    let of_path = [path.energy_drift(&Pendulum), path.shadow_energy_drift(&Pendulum)];
    assert!(
        (of_path[0] / energy - 1.0).abs() < 1e-9 && (of_path[1] / shadow - 1.0).abs() < 1e-3,
        "{of_path:?}"
    );
    let [energy, shadow] = drifts::<Verlet, _>(&Pendulum, &start, 1000.0, 600);
    assert!(shadow > 0.2 * energy, "{energy} {shadow}");
}

#[test]
fn one_modified_hamiltonian_serves_many_states() {
    let modified = ModifiedHamiltonian::<Verlet>::new(0.1);
    for q in [0.0, 0.4, 1.1] {
        let state = State::new([q], [0.5]);
        assert_eq!(modified.energy(&Pendulum, &state), Pendulum.shadow_energy::<Verlet>(&state, 0.1));
    }
    assert!(modified.energy(&Pendulum, &State::new([f64::NAN], [0.0])).is_nan());
    let chain = Fput { alpha: 0.25, beta: 0.0 };
    assert!(
        chain
            .shadow_energy::<Verlet>(&State { q: Vector::zeros(3), p: Vector::zeros(2), t: 0.0 }, 0.1)
            .is_nan()
    );
    assert!(format!("{modified:?}").contains("ModifiedHamiltonian"));
}
