//! First integrals of sums that stay loops: proven at compile time, kept at run time.

use wzvi::nalgebra::DVector;
use wzvi::prelude::*;

use super::wave;

#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let n = q.len();
        p.iter().map(|p| 0.5 * p * p).sum::<f64>() + (0..n).map(|i| (q[i] - q[(i + 1) % n]).exp()).sum::<f64>()
    },
    embedding = [DeltaPlus, Midpoint],
    invariant = [|q, p| p.iter().sum::<f64>()],
)]
struct Toda;

#[hamiltonian(
    drift = |q: &[[f64; 2]], p: &[[f64; 2]]| {
        let n = q.len();
        let kinetic: f64 = (0..n).map(|i| (p[i][0] * p[i][0] + p[i][1] * p[i][1]) / (2.0 * mass[i])).sum();
        let mut potential = 0.0;
        for i in 0..n {
            for j in 0..i {
                let r2: f64 = (0..2).map(|c| (q[i][c] - q[j][c]).powi(2)).sum();
                potential -= mass[i] * mass[j] / (r2 + 0.01).sqrt();
            }
        }
        kinetic + potential
    },
    embedding = [DeltaPlus, Midpoint],
    invariant = [
        |q, p| p.iter().map(|p| p[0]).sum::<f64>(),
        |q, p| p.iter().map(|p| p[1]).sum::<f64>(),
        |q, p| q.iter().zip(p).map(|(q, p)| q[0] * p[1] - q[1] * p[0]).sum::<f64>(),
    ],
)]
struct Planets {
    mass: Vec<f64>,
}

/// The discrete nonlinear Schrödinger equation with a noise that turns all phases: both parts of each bond together
/// keep the norm.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let n = q.len();
        (0..n).map(|i| 0.25 * (q[i] * q[i] + p[i] * p[i]).powi(2)).sum::<f64>()
            - (1..n).map(|i| q[i] * q[i - 1] + p[i] * p[i - 1]).sum::<f64>()
    },
    noise = [|q, p, k| 0.1 * (q[k] * q[k] + p[k] * p[k]); self.sites],
    embedding = [Midpoint],
    invariant = [|q, p| q.iter().zip(p).map(|(q, p)| 0.5 * (q * q + p * p)).sum::<f64>()],
)]
struct Schroedinger {
    sites: usize,
}

fn drift<H, E>(system: &H, start: State<DVector<f64>>, h: f64, dw: &[f64], steps: usize) -> Vec<f64>
where
    H: Discretized<E, Vector = DVector<f64>>,
{
    let values = |state: &State<DVector<f64>>| -> Vec<f64> {
        (0..system.invariants()).map(|k| system.invariant(k, state)).collect()
    };
    let mut state = start;
    let before = values(&state);
    let mut stepper = wzvi::step::Stepper::<H, E>::new(system, h).unwrap();
    for _ in 0..steps {
        stepper.step(&mut state, dw).unwrap();
    }
    values(&state).iter().zip(before).map(|(after, before)| (after - before).abs()).collect()
}

#[test]
fn values_are_those_of_the_formula() {
    let planets = Planets { mass: vec![1.0, 0.5, 2.0] };
    let state: State<DVector<f64>> = State::new(wave(6, 1.0, 0.2), wave(6, 0.7, 1.0));
    let (q, p) = (&state.q, &state.p);
    let angular: f64 = (0..3).map(|i| q[2 * i] * p[2 * i + 1] - q[2 * i + 1] * p[2 * i]).sum();
    assert_eq!(planets.invariants(), 3);
    for (k, expected) in [p[0] + p[2] + p[4], p[1] + p[3] + p[5], angular].into_iter().enumerate() {
        // Six products of order one.
        assert!((planets.invariant(k, &state) - expected).abs() < 1e-15);
    }
    assert!(planets.invariant(3, &state).is_nan());
    assert!(planets.invariant(0, &State::new(vec![0.0; 8], vec![0.0; 8])).is_nan(), "there are three masses");
}

#[test]
fn proven_integrals_are_kept_by_the_schemes_that_keep_them() {
    // Every one is bilinear or linear, the norm quadratic: 200 steps of a few dozen roundings of numbers of order one.
    let bound = 2e-13;
    let wave_of = |n: usize| State::new(wave(n, 0.8, 0.2), wave(n, 0.5, 1.1));
    let planets = Planets { mass: vec![1.0, 0.5, 2.0] };
    for drift in [
        drift::<Toda, DeltaPlus>(&Toda, wave_of(20), 0.05, &[], 200),
        drift::<Toda, Midpoint>(&Toda, wave_of(20), 0.05, &[], 200),
        drift::<Planets, DeltaPlus>(&planets, wave_of(6), 0.01, &[], 200),
        drift::<Planets, Midpoint>(&planets, wave_of(6), 0.01, &[], 200),
        drift::<Schroedinger, Midpoint>(&Schroedinger { sites: 8 }, wave_of(8), 0.05, &[0.2; 8], 200),
    ] {
        assert!(!drift.is_empty() && drift.iter().all(|&drift| drift < bound), "{drift:?}");
    }
}
