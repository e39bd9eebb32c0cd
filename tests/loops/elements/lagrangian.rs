//! Sweeps and the discrete Lagrangian that they are derived from: what its gradient is, that a step solves its equations,
//! and that the step is symplectic; with one and two quadrature points, explicit and implicit, with the counter-term, with
//! one noise and with a family.

use fixtures::schemes::Scheme;
use wzvi::nalgebra::DVector;
use wzvi::prelude::*;
use wzvi::scalar::{Dual, Scalar};
use wzvi::system::Segment;

const N: usize = 5;
const H: f64 = 0.05;
const SIGMA: [f64; N] = [0.3, 0.5, 0.2, 0.4, 0.1];

#[hamiltonian(
    drift = |q: &[f64], p: &[f64], t| {
        let n = q.len();
        (0..n).map(|i| 0.5 * p[i] * p[i] * (1.0 + a * q[i] * q[i]) + 0.25 * q[i].powi(4)).sum::<f64>()
            + (1..n).map(|i| 0.5 * (q[i] - q[i - 1]).powi(2)).sum::<f64>()
            + q[0] * (3.0 * t).sin()
    },
    noise = [|q, p, k| sigma[k] * (0.5 * q[k] * q[k] + 0.3 * q[k] * p[(k + 1) % 5] + p[k].cos()); 5],
    embedding = [
        Uncorrected<Mixed<Midpoint, DeltaPlus>>, Mixed<DeltaPlus, Midpoint>, Corrected<DeltaMinus>, Corrected<Lambda<1, 4>>,
        Corrected<Mixed<Midpoint, DeltaPlus>>, Corrected<Mixed<Lambda<1, 3>, DeltaMinus>>,
    ],
)]
struct Family {
    a: f64,
    sigma: [f64; N],
}

#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let v = |d: f64| 0.5 * d * d + 0.25 * beta * d.powi(4);
        p.iter().map(|p| 0.5 * p * p).sum::<f64>() + (1..q.len()).map(|i| v(q[i] - q[i - 1])).sum::<f64>() + v(q[0])
    },
    noise = [|q, p| (0..q.len()).map(|i| q[i].sin() * (i as f64 + 1.0)).sum::<f64>()],
    embedding = [
        Mixed<DeltaPlus, DeltaMinus>, Mixed<Midpoint, DeltaPlus>, Mixed<DeltaMinus, Midpoint>, DeltaPlus, DeltaMinus, Midpoint,
    ],
)]
struct Chain {
    beta: f64,
}

/// Two noises that do not commute, in sums of different form: their counter-term couples three sites.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let n = q.len();
        (0..n).map(|i| 0.5 * p[i] * p[i] + 0.25 * q[i].powi(4)).sum::<f64>()
            + (1..n).map(|i| 0.5 * (q[i] - q[i - 1]).powi(2)).sum::<f64>()
    },
    noise = [
        |q, p| (1..q.len()).map(|i| sigma[i] * q[i] * p[i - 1]).sum::<f64>() + q[0] * q[0] * p[0],
        |q, p| q.iter().skip(1).zip(p.iter().skip(1)).map(|(q, p)| 0.2 * (q * q + p * p)).sum::<f64>(),
    ],
    embedding = [
        Corrected<DeltaPlus>, Corrected<DeltaMinus>, Corrected<Lambda<1, 4>>, Corrected<Mixed<Midpoint, DeltaPlus>>,
    ],
)]
struct Bonds {
    sigma: [f64; N],
}

/// `L_d` of docs/guide/theory.md, section 2, from Hamiltonians and slopes in any numbers.
fn definition<E: Scheme, S: Scalar>(
    system: &impl Hamiltonian,
    [q0, q1, p]: [&[S]; 3],
    t: f64,
    dw: &[f64],
) -> S {
    let at = |l: f64| q0.iter().zip(q1).map(|(&a, &b)| a * (1.0 - l) + b * l).collect::<Vec<S>>();
    let mut value = S::from_f64(0.0);
    for i in 0..q0.len() {
        value = value + p[i] * (q1[i] - q0[i]);
    }
    let [drift, noise] = E::L;
    value = value - system.evaluate(0, &at(drift), p, t + drift * H) * H;
    let (q, t) = (at(noise), t + noise * H);
    let zeros = vec![S::from_f64(0.0); q.len()];
    let (mut force, mut velocity) = (zeros.clone(), zeros.clone());
    for (k, &dw) in dw.iter().enumerate() {
        value = value - system.evaluate(k + 1, &q, p, t) * dw;
        let (mut by_q, mut by_p) = (zeros.clone(), zeros.clone());
        system.differentiate(k + 1, &q, p, t, &mut by_q, &mut by_p);
        for i in 0..q.len() {
            (force[i], velocity[i]) = (force[i] + by_q[i] * dw, velocity[i] + by_p[i] * dw);
        }
    }
    if E::IS_CORRECTED {
        for i in 0..q.len() {
            value = value - force[i] * velocity[i] * (0.5 - noise);
        }
    }
    value
}

fn wave(phase: f64) -> [f64; N] {
    std::array::from_fn(|i| 0.7 * (1.3 * i as f64 + phase).sin())
}

/// The gradient against the derivative of the definition in dual numbers, away from any solution.
fn gradient_is_that_of_the_definition<E: Scheme, M>(system: &M, dw: &[f64])
where
    M: Discretized<E, Vector = DVector<f64>>,
{
    let t = 0.4;
    let [q0, q1, p] = [wave(0.2), wave(0.5), wave(1.1)];
    let all: [f64; 3 * N] = std::array::from_fn(|k| [q0, q1, p][k / N][k % N]);
    let dual: [Dual<{ 3 * N }>; 3 * N] = Dual::variables(all);
    let expected = definition::<E, _>(system, [&dual[..N], &dual[N..2 * N], &dual[2 * N..]], t, dw);
    let [q0, q1, p] = [q0, q1, p].map(|part| DVector::from_row_slice(&part));
    let segment = Segment { q0, q1, p, t, h: H };
    let value = system.discrete_lagrangian(&segment, dw);
    let gradient = system.discrete_lagrangian_gradient(&segment, dw);
    // Some fifty terms of order one and below, each rounded a few times.
    let tolerance = 50.0 * 4.0 * f64::EPSILON;
    assert!((value - expected.value).abs() < tolerance, "{value} {}", expected.value);
    for (k, slope) in gradient.q0.iter().chain(&gradient.q1).chain(&gradient.p).enumerate() {
        let wanted = expected.derivative[k];
        assert!((slope - wanted).abs() < tolerance, "{k}: {slope} {wanted}");
    }
}

/// `∂L_d/∂P = 0`, `p_i = -D_1 L_d`, `p_{i+1} = D_2 L_d` for the `P` of a step.
fn step_solves_its_equations<E, M>(system: &M, dw: &[f64])
where
    M: Discretized<E, Vector = DVector<f64>>,
{
    let before = State { t: 0.4, ..State::new(wave(0.2).to_vec(), wave(1.1).to_vec()) };
    let mut after = before.clone();
    system.stepper::<E>(H).unwrap().step(&mut after, dw).unwrap();
    let p = system.step_momentum(&before, &after, H, dw);
    let segment = Segment { q0: before.q.clone(), q1: after.q.clone(), p, t: before.t, h: H };
    let gradient = system.discrete_lagrangian_gradient(&segment, dw);
    // Sums of a dozen terms below 1, at states that are rounded themselves.
    let tolerance = 12.0 * f64::EPSILON;
    let equations = [
        ("∂L_d/∂P", gradient.p),
        ("p_i + D_1 L_d", gradient.q0 + &before.p),
        ("p_{i+1} - D_2 L_d", gradient.q1 - &after.p),
    ];
    for (name, left) in equations {
        assert!(left.amax() < tolerance, "{name}: {left}");
    }
}

macro_rules! check {
    ($system:expr, $dw:expr, [$($scheme:ty),*]) => {$(
        gradient_is_that_of_the_definition::<$scheme, _>($system, $dw);
        step_solves_its_equations::<$scheme, _>($system, $dw);
        let start: [&[f64]; 2] = [&wave(0.2), &wave(1.1)];
        // Ten products of slopes of order one, each solved to a few roundings.
        assert!(fixtures::steps::asymmetry::<$scheme, _>($system, start, [0.4, H], $dw, 1.0) < 100.0 * f64::EPSILON);
    )*};
}

#[test]
fn sweeps_are_derived_from_the_discrete_lagrangian() {
    let family = Family { a: 0.4, sigma: SIGMA };
    check!(&family, &[0.1, -0.07, 0.02, 0.05, -0.11], [
        Uncorrected<Mixed<Midpoint, DeltaPlus>>, Mixed<DeltaPlus, Midpoint>, Corrected<DeltaMinus>, Corrected<Lambda<1, 4>>,
        Corrected<Mixed<Midpoint, DeltaPlus>>, Corrected<Mixed<Lambda<1, 3>, DeltaMinus>>
    ]);
    check!(&Bonds { sigma: SIGMA }, &[0.08, -0.05], [
        Corrected<DeltaPlus>, Corrected<DeltaMinus>, Corrected<Lambda<1, 4>>, Corrected<Mixed<Midpoint, DeltaPlus>>
    ]);
    check!(&Chain { beta: 0.7 }, &[0.1], [
        Mixed<DeltaPlus, DeltaMinus>, Mixed<Midpoint, DeltaPlus>, Mixed<DeltaMinus, Midpoint>, DeltaPlus, DeltaMinus, Midpoint
    ]);
}

/// The slopes of all noises at once are those of each, weighted.
#[test]
fn noises_are_differentiated_at_once() {
    let family = Family { a: 0.4, sigma: SIGMA };
    let dw = [0.1, -0.07, 0.02, 0.05, -0.11];
    let state = State::new([0.3, -0.8, 0.5, 1.1, -0.2], [0.7, 0.1, -0.4, 0.2, 0.9]);
    let mut all = family.energy_gradient(&state);
    family.differentiate_noises(&dw, &state, &mut all);
    let (mut q, mut p) = (0.0 * state.q.clone(), 0.0 * state.p.clone());
    for (k, dw) in dw.into_iter().enumerate() {
        let of_one = family.noise_gradient(k, &state);
        q += dw * of_one.q;
        p += dw * of_one.p;
    }
    // Sums of five terms below one, in two orders.
    assert!((&all.q - q).amax() < 5.0 * f64::EPSILON && (&all.p - p).amax() < 5.0 * f64::EPSILON);
    family.differentiate_noises(&dw[1..], &state, &mut all);
    assert!(all.q.iter().chain(all.p.iter()).all(|slope| slope.is_nan()), "an increment is missing");
}

#[hamiltonian(drift = |q, p| 0.5 * p * p, noise = [|q, p| q * q, |q, p| 0.5 * q * p], embedding = Midpoint)]
struct Twice;

/// The same of a system that is written out.
#[test]
fn noises_of_a_small_system_are_differentiated_at_once() {
    let (state, mut all) = (State::new([0.5], [2.0]), Twice.energy_gradient(&State::new([0.0], [0.0])));
    Twice.differentiate_noises(&[2.0, -1.0], &state, &mut all);
    assert_eq!((all.q[0], all.p[0]), (2.0 * 2.0 * 0.5 - 0.5 * 2.0, -0.5 * 0.5));
    Twice.differentiate_noises(&[2.0], &state, &mut all);
    assert!(all.q[0].is_nan() && all.p[0].is_nan(), "an increment is missing");
}
