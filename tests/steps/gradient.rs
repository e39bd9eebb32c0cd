//! Kicks by potentials with the square of the force: their order, what they keep, and that loops take the steps of straight-line code.

use fixtures::larger;
use fixtures::steps::{apart, asymmetry, has_order, lagrangian_gradient_off, lanes_are_steppers, way_back};
use wzvi::nalgebra::SVector;
use wzvi::prelude::*;
use wzvi::scalar::{Dual, Scalar};

/// Two masses that differ, and a coupling: `|V'|²` is taken in the metric of the inverse masses.
#[hamiltonian(
    drift = |[x, y], [px, py]|
        px * px / (2.0 * m) + py * py / (2.0 * k) + 0.3 * px * py + 0.5 * x * x + 0.7 * y.cosh() + x * x * y,
    embedding = Verlet,
)]
struct Masses {
    m: f64,
    k: f64,
}

/// The potential moves.
#[hamiltonian(drift = |q, p, t| 0.5 * p * p - (1.0 + 0.3 * t.sin()) * q.cos(), embedding = Verlet)]
struct Driven;

/// The same chain in loops and written out.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]|
        (0..q.len()).map(|i| 0.5 * p[i] * p[i] + 0.25 * q[i].powi(4)).sum::<f64>()
            + (0..q.len() - 1).map(|i| 1.0 - (q[i + 1] - q[i]).cos()).sum::<f64>(),
    embedding = Verlet,
)]
struct Loops;

#[hamiltonian(
    drift = |q: [f64; 3], p: [f64; 3]|
        (0..3).map(|i| 0.5 * p[i] * p[i] + 0.25 * q[i].powi(4)).sum::<f64>()
            + (0..2).map(|i| 1.0 - (q[i + 1] - q[i]).cos()).sum::<f64>(),
    embedding = Verlet,
)]
struct Written;

/// Noise in the potential.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p - q.cos(),
    noise = [|q, p| sigma * q * q],
    embedding = Verlet,
)]
struct Shaken {
    sigma: f64,
}

const MASSES: Masses = Masses { m: 1.3, k: 0.8 };

/// At these step sizes an order of `n` shows as `n` to within 0.2.
#[test]
fn chin_is_of_order_4() {
    type Chin = Composed<Verlet, Chin4>;
    has_order::<Chin, _>(&MASSES, [&[0.4, -0.2], &[0.3, 0.5]], (3.2, 30), 4, 0.2);
    has_order::<Chin, _>(&Driven, [&[1.4], &[0.3]], (3.2, 30), 4, 0.2);
    assert_eq!(<Masses as Discretized<Chin>>::PLAN.solver, Solver::Explicit);
    let text = <Masses as Discretized<Chin>>::EQUATIONS;
    assert!(text.contains("V - h²/48 V'·M⁻¹V'"), "{text}");
}

/// Of order 2, and conjugate to order 4: with `K = H_p · V'` the step keeps `H - h²/24 {H, K}` to order 4, for that is what
/// the map near the identity makes of `H`.
#[test]
fn takahashi_and_imada_is_of_effective_order_4() {
    let start = State::new([0.4, -0.2], [0.3, 0.5]);
    type Takahashi = Composed<Verlet, TakahashiImada4>;
    has_order::<Takahashi, _>(&MASSES, [&[0.4, -0.2], &[0.3, 0.5]], (3.2, 40), 2, 0.2);
    let drift = |steps: u64| {
        let h = 3.0 / steps as f64;
        let path = MASSES.simulate::<Takahashi>(h).start(start).steps(steps).run().unwrap();
        let energies: Vec<f64> =
            path.iter().map(|state| MASSES.energy(state) - h * h / 24.0 * rate(state)).collect();
        energies.iter().map(|energy| (energy - energies[0]).abs()).fold(0.0, larger)
    };
    let slope = (drift(60) / drift(120)).log2();
    assert!((slope - 4.0).abs() < 0.2, "{slope}");
}

/// `{H, K} = V''(H_p, H_p) - |V'|²` of [`MASSES`], by dual numbers along the motion of `K`'s coordinates and momenta.
fn rate(state: &State<SVector<f64, 2>>) -> f64 {
    let gradient = MASSES.energy_gradient(state);
    let lift = |value: f64, slope: f64| Dual { value, derivative: [slope] };
    let q: [Dual<1>; 2] = std::array::from_fn(|i| lift(state.q[i], gradient.p[i]));
    let p: [Dual<1>; 2] = std::array::from_fn(|i| lift(state.p[i], -gradient.q[i]));
    let (mut by_q, mut by_p) = ([Dual::from_f64(0.0); 2], [Dual::from_f64(0.0); 2]);
    MASSES.differentiate(0, &q, &p, state.t, &mut by_q, &mut by_p);
    let product = (by_q[0] * by_p[0]) + (by_q[1] * by_p[1]);
    product.derivative[0]
}

/// One step against the formula: drift, kick with the square of the force, drift.
#[test]
fn the_kick_is_that_of_the_formula() {
    let h = 0.3;
    let start = State::new([1.1], [0.4]);
    let mut state = start;
    Shaken { sigma: 0.0 }
        .stepper::<Composed<Verlet, TakahashiImada4>>(h)
        .unwrap()
        .step(&mut state, &[0.0])
        .unwrap();
    let middle = 1.1 + 0.5 * h * 0.4;
    let p = 0.4 - h * f64::sin(middle) + h.powi(3) / 12.0 * f64::cos(middle) * f64::sin(middle);
    let q = middle + 0.5 * h * p;
    // A few roundings.
    assert!((state.p[0] - p).abs() < 1e-15 && (state.q[0] - q).abs() < 1e-15, "{state:?} {q} {p}");
    // With an increment the potential of the step is h V + ΔW V_1.
    let (sigma, dw) = (0.7, 0.2);
    let mut state = start;
    Shaken { sigma }
        .stepper::<Composed<Verlet, TakahashiImada4>>(h)
        .unwrap()
        .step(&mut state, &[dw])
        .unwrap();
    let force = h * f64::sin(middle) + 2.0 * dw * sigma * middle;
    let curvature = h * f64::cos(middle) + 2.0 * dw * sigma;
    let p = 0.4 - force + h / 12.0 * curvature * force;
    assert!((state.p[0] - p).abs() < 1e-15, "{state:?} {p}");
}

#[test]
fn loops_take_the_steps_of_straight_lines() {
    let start: [&[f64]; 2] = [&[0.3, -0.7, 0.5], &[0.2, 0.1, -0.4]];
    // Some roundings for each of twenty steps.
    assert!(apart::<Composed<Verlet, Chin4>, _, _>((&Loops, &Written), start, (0.05, 20), &[]) < 2e-14);
    assert!(
        apart::<Composed<Verlet, TakahashiImada4>, _, _>((&Loops, &Written), start, (0.05, 20), &[]) < 2e-14
    );
}

#[test]
fn steps_are_symplectic_and_symmetric() {
    fn check<E>()
    where
        Masses: Discretized<E>,
    {
        let start: [&[f64]; 2] = [&[0.4, -0.2], &[0.3, 0.5]];
        assert!(asymmetry::<E, _>(&MASSES, start, [0.0, 0.1], &[], 1.0) < 1e-15);
        assert!(way_back::<E, _>(&MASSES, start, [0.0, 0.1], &[]) < 1e-15);
    }
    check::<Composed<Verlet, Chin4>>();
    check::<Composed<Verlet, TakahashiImada4>>();
}

/// The gradient of the discrete Lagrangian of a segment, and the residual of the discrete Euler-Lagrange equations along a path.
#[test]
fn the_discrete_lagrangian_is_that_of_the_step() {
    fn check<E>()
    where
        Masses: Discretized<E, Vector = SVector<f64, 2>>,
    {
        let segment: [&[f64]; 3] = [&[0.4, 0.2], &[0.5, 0.1], &[0.6, -0.3]];
        let off = lagrangian_gradient_off::<E, _>(&MASSES, segment, [0.0, 0.2]);
        assert!(off < 1e-9, "{off:e}");
        let path =
            MASSES.simulate::<E>(0.2).start(State::new([0.4, -0.2], [0.3, 0.5])).steps(20).run().unwrap();
        assert!(path.euler_lagrange_residual(&MASSES).unwrap() < 1e-13);
    }
    check::<Composed<Verlet, Chin4>>();
    check::<Composed<Verlet, TakahashiImada4>>();
}

/// Paths of an ensemble lie in lanes, and their dual numbers with them.
#[test]
fn ensembles_take_the_same_steps_in_lanes() {
    let shaken = Shaken { sigma: 0.3 };
    // Elementary functions of lanes differ by roundings.
    lanes_are_steppers::<Composed<Verlet, Chin4>, _>(&shaken, [&[0.3], &[0.5]], 0.05);
}
