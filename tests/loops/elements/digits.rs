//! Energies and discrete Lagrangians keep the digits of the expression that the user wrote.

use wzvi::nalgebra::DVector;
use wzvi::prelude::*;
use wzvi::system::Segment;

/// Pendulums and bonds: small numbers as differences of large ones, in factors that read no state.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        (0..q.len()).map(|i| 0.5 * p[i] * p[i] + g * (1.0 - q[i].cos())).sum::<f64>()
            + k * (1..q.len()).map(|i| c[i] * (1.0 - (q[i] - q[i - 1]).cos())).sum::<f64>()
    },
    noise = [|q, p, j| s * (1.0 - q[j].cos()); 3],
    embedding = [DeltaPlus, Midpoint],
)]
struct Pendulums {
    g: f64,
    k: f64,
    s: f64,
    c: Vec<f64>,
}

/// `1 - cos x`
fn versine(x: f64) -> f64 {
    2.0 * (0.5 * x).sin().powi(2)
}

#[test]
fn energies_and_lagrangians_of_small_amplitudes_have_all_digits() {
    let system = Pendulums { g: 9.81, k: 3.7, s: 0.3, c: vec![0.0, 1.3, 0.7] };
    for amplitude in [1e-2, 1e-5, 1e-8, 1e-30] {
        let q = [amplitude, -2.0 * amplitude, 0.5 * amplitude];
        let state = State::<DVector<f64>>::new(q.to_vec(), vec![0.0; 3]);
        let bonds = 1.3 * versine(q[1] - q[0]) + 0.7 * versine(q[2] - q[1]);
        let energy = 9.81 * q.iter().map(|&q| versine(q)).sum::<f64>() + 3.7 * bonds;
        // Sums of positive terms, a few roundings each.
        let close = |a: f64, b: f64| (a - b).abs() <= 16.0 * f64::EPSILON * b.abs();
        assert!(close(system.energy(&state), energy), "{amplitude}: {} {energy}", system.energy(&state));
        for (j, &q) in q.iter().enumerate() {
            let (noise, exact) = (system.noise_energy(j, &state), 0.3 * versine(q));
            assert!(close(noise, exact), "{amplitude}: {noise} {exact}");
        }
        // At rest `L_d = -h H_0 - Σ ΔW_j H_j`.
        let (node, h, dw) = (state.q.clone(), 0.1, [0.2, 0.1, 0.3]);
        let segment = Segment { q0: node.clone(), q1: node, p: DVector::zeros(3), t: 0.0, h };
        let noise: f64 = q.iter().zip(dw).map(|(&q, dw)| dw * 0.3 * versine(q)).sum();
        let lagrangian = Discretized::<Midpoint>::discrete_lagrangian(&system, &segment, &dw);
        assert!(close(lagrangian, -h * energy - noise), "{amplitude}: {lagrangian} {}", -h * energy - noise);
    }
}
