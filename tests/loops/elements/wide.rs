//! Systems whose Jacobian is too wide for a band: lattices, random graphs, all pairs.

use wzvi::elements::Method;
use wzvi::nalgebra::DVector;
use wzvi::prelude::*;

use super::wave;
use crate::lattice::Torus;

#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        p.iter().map(|p| 0.5 * p * p).sum::<f64>()
            + self.edges.iter().map(|e| k * (1.0 - (q[e[0]] - q[e[1]]).cos())).sum::<f64>()
    },
    embedding = [Midpoint],
)]
struct Graph {
    edges: Vec<[usize; 2]>,
    k: f64,
}

/// All pairs, with a kinetic energy that couples to the place: coordinates and momenta are unknown.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let n = q.len();
        (0..n).map(|i| 0.5 * p[i] * p[i] * (1.0 + 0.1 * q[i].sin())).sum::<f64>()
            + (0..n).map(|i| (0..i).map(|j| stiffness / n as f64 * (q[i] - q[j]).powi(2)).sum::<f64>()).sum::<f64>()
    },
    embedding = [Midpoint],
)]
struct AllPairs {
    stiffness: f64,
}

fn network(sites: usize, edges: usize) -> Vec<[usize; 2]> {
    let mut random = fixtures::Uniform(7);
    (0..edges).map(|_| [random.below(sites), random.below(sites)]).filter(|[a, b]| a != b).collect()
}

/// Three stiff steps by products with the Jacobian solve the discrete Euler-Lagrange equations, which know nothing of how.
fn solves<H: Discretized<Midpoint, Vector = DVector<f64>>>(system: &H, sites: usize, size: f64, h: f64) {
    let start = State::new(wave(sites, size, 0.2), wave(sites, size, 1.1));
    let mut stepper = system.stepper::<Midpoint>(h).unwrap();
    let mut state = start.clone();
    let info = stepper.step(&mut state, &[]).unwrap();
    assert_eq!(stepper.method(), Some(Method::Krylov));
    assert!(!info.is_doubtful, "{info:?}");
    let path = system.simulate::<Midpoint>(h).start(start).steps(3).run().unwrap();
    let residual = path.euler_lagrange_residual(system).unwrap();
    // Rounding of forces h ω² q of order ten in sums of a few dozen terms.
    assert!(residual < 1e-12, "{residual:e}");
}

#[test]
fn lattices_and_graphs_are_solved_without_a_matrix() {
    // The fixed point contracts for (h ω / 2)² < 1 only: here ω² is 8 at least, then 80.
    solves(&Torus::square(40, 0.0), 1600, 0.8, 1.5);
    solves(&Graph { edges: network(1500, 3000), k: 10.0 }, 1500, 0.1, 0.7);
}

#[test]
fn all_pairs_are_solved_without_a_matrix() {
    solves(&AllPairs { stiffness: 30.0 }, 300, 0.8, 0.5);
}

#[test]
fn small_and_narrow_systems_have_a_band() {
    let method = |stepper: &wzvi::step::Stepper<'_, Torus, Midpoint>| stepper.method();
    let torus = Torus::square(10, 0.0);
    let mut stepper = torus.stepper::<Midpoint>(0.1).unwrap();
    assert_eq!(method(&stepper), Some(Method::Undecided));
    stepper.step(&mut State::new(wave(100, 0.1, 0.0), wave(100, 0.1, 0.0)), &[]).unwrap();
    assert!(
        matches!(method(&stepper), Some(Method::Band { half_width }) if half_width < 30),
        "{:?}",
        method(&stepper)
    );
}
