//! Forces and friction beside `drift = [H_A, H_B]`: each in the flow in which it changes nothing else.

use wzvi::prelude::*;

use fixtures::steps::{asymmetry, order_of_step, step_apart};

/// A force without potential, in the kick.
#[hamiltonian(
    drift = [|[_, _], [u, v]| 0.5 * (u * u + 2.0 * v * v), |[x, y], _| 0.25 * x.powi(4) + 0.5 * y * y + 0.3 * x * y],
    force = |[x, y], _, t| [0.4 * y + 0.3 * (1.7 * t).cos(), -0.2 * x],
    embedding = Verlet,
)]
struct Apart;

#[hamiltonian(
    drift = |[x, y], [u, v]| 0.5 * (u * u + 2.0 * v * v) + 0.25 * x.powi(4) + 0.5 * y * y + 0.3 * x * y,
    force = |[x, y], _, t| [0.4 * y + 0.3 * (1.7 * t).cos(), -0.2 * x],
    embedding = Verlet,
)]
struct Together;

macro_rules! pairs {
    ($name:ident, [$($generics:tt)*], $state:ty) => {
        /// Oscillators that are mapped with their friction, a weak coupling, and a force that is.
        #[hamiltonian(
            drift = [
                |q: $state, p: $state| (0..q.len()).map(|i| 0.5 * p[i] * p[i] + 0.5 * (1.0 + i as f64) * q[i] * q[i] + 0.1 * q[i]).sum::<f64>(),
                |q, _, t| (1..q.len()).map(|i| 0.2 * (q[i] - q[i - 1]).powi(4)).sum::<f64>() + 0.1 * q[0] * (1.3 * t).sin(),
            ],
            friction = gamma,
            force = |q, _, t| (0..q.len()).map(|i| match i {
                0 => 0.3 * q[1],
                1 => -0.2 * q[0],
                _ => 0.1 * (0.8 * t).cos(),
            }),
            embedding = [Verlet, Gauss<6>],
        )]
        struct $name$($generics)* {
            gamma: f64,
        }
    };
}

pairs!(Coupled, [], [f64; 3]);
pairs!(CoupledInLoops, [<const N: usize>], [f64; N]);

const AT: [&[f64]; 2] = [&[0.5, -0.3, 0.2], &[0.4, 0.1, -0.6]];

/// Where the parts are drift and kick, steps are those of the sum.
#[test]
fn a_separable_drift_is_forced_in_its_kicks() {
    let (at, times) = ([&[0.5, -0.3][..], &[0.4, 0.1]], [0.7, 0.3]);
    // Some twenty sums of numbers below 1.
    let bound = 20.0 * f64::EPSILON;
    assert!(step_apart::<Verlet, _, _>((&Apart, &Together), at, times) < bound);
    assert!(step_apart::<Composed<Verlet, Aba1064>, _, _>((&Apart, &Together), at, times) < bound);
    assert!(step_apart::<Composed<Verlet, Aba864>, _, _>((&Apart, &Together), at, times) < bound);
}

/// Half of the step leaves `2^-(order + 1)` of its error.
#[test]
fn forced_and_damped_parts_have_the_order_of_their_table() {
    let system = Coupled { gamma: 0.7 };
    let orders = [
        order_of_step::<Composed<Verlet, Aba1064>, Gauss<6>, _>(&system, AT, [0.3, 0.2], &[]),
        order_of_step::<Composed<Verlet, Aba864>, Gauss<6>, _>(&system, AT, [0.3, 0.2], &[]),
    ];
    // The terms of the next orders are not small yet.
    assert!(orders.iter().all(|&order| order > 4.0 - 0.3), "{orders:?}");
}

/// Loops are what they would be written out.
#[test]
fn loops_are_forced_and_damped_too() {
    let pair = (&Coupled { gamma: 0.7 }, &CoupledInLoops::<3> { gamma: 0.7 });
    // Maps of 6 numbers below 1, in 15 stages.
    assert!(step_apart::<Composed<Verlet, Aba864>, _, _>(pair, AT, [0.3, 0.4]) < 1e-14);
}

/// `Mᵀ J M = e^{-γ h} J` without the force that has no potential, by dual numbers: the weights of the maps sum up to 1.
#[test]
fn friction_of_a_part_is_conformally_symplectic() {
    let (start, at): ([&[f64]; 2], _) = ([&[0.4], &[0.3]], [0.2, 0.5]);
    let factor = f64::exp(-0.9 * 0.5);
    let gap = asymmetry::<Composed<Verlet, Aba1064>, _>(&Damped { gamma: 0.9 }, start, at, &[], factor);
    // Twenty maps, of which some go back.
    assert!(gap < 20.0 * f64::EPSILON, "{gap:e}");
}

#[hamiltonian(drift = [|_, p| 0.5 * p * p, |q, _| -q.cos()], friction = gamma, embedding = Verlet)]
struct Damped {
    gamma: f64,
}

/// What friction takes. It has no discrete Lagrangian, but the equations.
#[test]
fn friction_is_accounted_for() {
    type Aba = Composed<Verlet, Aba1064>;
    let system = Damped { gamma: 0.2 };
    let start = State::new([2.0], [0.0]);
    let path = system.simulate::<Aba>(0.1).start(start).until(20.0).run().unwrap();
    let gain = system.energy(path.last()) - system.energy(&start);
    // An error of the order h⁴.
    assert!((gain - path.heat()).abs() < 1e-6 && gain < -1.0, "{gain} {} {}", path.work(), path.heat());
    let residual = path.euler_lagrange_residual(&system).unwrap();
    assert!(residual < 1e-13, "{residual:e}");
    let segment =
        wzvi::system::Segment { q0: [0.1].into(), q1: [0.2].into(), p: [0.3].into(), t: 0.0, h: 0.1 };
    assert!(Discretized::<Aba>::discrete_lagrangian(&system, &segment, &[]).is_nan());
    assert!(system.stepper::<Aba>(0.1).is_ok() && Damped { gamma: -1.0 }.stepper::<Aba>(0.1).is_err());
}
