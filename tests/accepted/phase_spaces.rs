//! Every way to declare a phase space.

use wzvi::prelude::*;

#[hamiltonian(drift = |q, p| 0.5 * (q * q + p * p), embedding = Midpoint)]
struct One;

#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) + x * x * y,
    noise = [|[x, _], _| x, |q: [f64; 2], _: [f64; 2]| q[1], |q: [f64; 2], _| q[0] * q[1]],
    embedding = Midpoint,
)]
struct Named;

#[hamiltonian(
    drift = |q: [f64; 3], p: [f64; 3]|
        (0..3).map(|i| 0.5 * p[i] * p[i]).sum::<f64>() + (0..2).map(|i| (q[i + 1] - q[i]).powi(4)).sum::<f64>(),
    embedding = Midpoint,
)]
struct Indexed;

#[hamiltonian(
    drift = |q: [[f64; 3]; 2], p: [[f64; 3]; 2]| {
        let kinetic: f64 = p.iter().map(|p| p.iter().map(|x| 0.5 * x * x).sum::<f64>()).sum();
        let distance = (0..3).map(|k| (q[1][k] - q[0][k]).powi(2)).sum::<f64>().sqrt();
        kinetic + (distance - 1.0).powi(2)
    },
    embedding = Midpoint,
)]
struct Points;

#[hamiltonian(drift = |[[x, _], b]: [[f64; 2]; 2], p: [[f64; 2]; 2]| x * b[0] + p[1][1] * p[0][0], embedding = Midpoint)]
struct Nested;

#[hamiltonian(
    drift = |q, p, t| 0.5 * p * p + (1.0 + t.cos()) * q * q,
    noise = [|q, _, t: f64| t * q, |_, p| p, |q: f64, p: f64, _| q + p],
    embedding = Midpoint,
)]
struct Driven;

#[hamiltonian(drift = |(q), _: f64| -> f64 { q }, embedding = DeltaPlus)]
struct Constrained;

#[hamiltonian(drift = move |r#type: f64, ωρ: f64| r#type * ωρ, embedding = DeltaPlus)]
struct Unusual;

#[test]
fn compiles_and_runs() {
    let mut state = State::new([0.5, 0.25], [1.0, 0.0]);
    Named.stepper::<Midpoint>(0.01).unwrap().step(&mut state, &[0.0, 0.1, -0.1]).unwrap();
    let mut state = State::new([0.5], [1.0]);
    One.stepper::<Midpoint>(0.01).unwrap().step(&mut state, &[]).unwrap();
    Driven.stepper::<Midpoint>(0.01).unwrap().step(&mut state, &[0.1; 3]).unwrap();
    Unusual.stepper::<DeltaPlus>(0.01).unwrap().step(&mut state, &[]).unwrap();
    Constrained.stepper::<DeltaPlus>(0.01).unwrap().step(&mut state, &[]).unwrap();
    let mut state = State::new([0.0, 1.0, 2.5], [0.0, 1.0, 0.0]);
    Indexed.stepper::<Midpoint>(0.01).unwrap().step(&mut state, &[]).unwrap();
    let mut state = State::new([0.0, 1.0, 2.5, 3.0], [0.0, 1.0, 0.0, 1.0]);
    Nested.stepper::<Midpoint>(0.01).unwrap().step(&mut state, &[]).unwrap();
    let mut state = State::new([0.0, 0.0, 0.0, 1.5, 0.1, 0.2], [0.1; 6]);
    Points.stepper::<Midpoint>(0.01).unwrap().step(&mut state, &[]).unwrap();
    assert_eq!(Driven.noises(), 3);
    assert_eq!(Points.degrees(), 6);
}
