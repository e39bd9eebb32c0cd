//! Sums over pairs of bodies in vector instructions: their bits are those of one number after the other, and their forces those that
//! mathematics asks for.
//!
//! The reference for bits is the same generated step on [`Lanes<1>`], which takes no vector registers.

use fixtures::own::RungeKutta4;
use wzvi::embedding::{Own, TakahashiImada4};
use wzvi::lanes::Lanes;
use wzvi::nalgebra::DVector;
use wzvi::prelude::*;

use crate::one_by_one::{H, check, check_others, check_scheme, later_allocations, numbers};

/// Gravity of bodies in space, each pair once, with masses and a field that holds them.
#[hamiltonian(
    drift = |q: &[[f64; 3]], p: &[[f64; 3]]| {
        let n = q.len();
        (0..n).map(|i| 0.5 * (p[i][0] * p[i][0] + p[i][1] * p[i][1] + p[i][2] * p[i][2]) / self.mass[i]).sum::<f64>()
            + q.iter().map(|q| 0.5 * k * (q[0] * q[0] + q[2].powi(4))).sum::<f64>()
            - (0..n)
                .map(|i| {
                    (0..i)
                        .map(|j| {
                            let [x, y, z] = [q[i][0] - q[j][0], q[i][1] - q[j][1], q[i][2] - q[j][2]];
                            self.mass[i] * self.mass[j] / (x * x + y * y + z * z + softening).sqrt()
                        })
                        .sum::<f64>()
                })
                .sum::<f64>()
    },
    invariant = [|q, p| p.iter().map(|p| p[1]).sum::<f64>()],
    embedding = [DeltaPlus, DeltaMinus, Verlet, Midpoint, Gauss<2>],
)]
struct Cluster {
    k: f64,
    softening: f64,
    mass: Vec<f64>,
}

/// Rotors of which each turns all others, all pairs twice: sines and cosines.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let n = q.len();
        p.iter().map(|p| 0.5 * p * p).sum::<f64>()
            + (0..n).map(|i| (0..n).map(|j| k * (1.0 - (q[i] - q[j]).cos())).sum::<f64>()).sum::<f64>()
    },
    embedding = [DeltaPlus, DeltaMinus, Verlet, Midpoint],
)]
struct Rotors {
    k: f64,
}

/// Vortices in a plane that repel, the later ones first, in time, and a kick by a noise that they share.
#[hamiltonian(
    drift = |q: &[[f64; 2]], p: &[[f64; 2]], t| {
        let n = q.len();
        p.iter().map(|p| 0.5 * (p[0] * p[0] + p[1] * p[1])).sum::<f64>()
            - (0..n)
                .map(|i| {
                    (i + 1..n)
                        .map(|j| {
                            let (x, y) = (q[i][0] - q[j][0], q[i][1] - q[j][1]);
                            (1.0 + 0.1 * t) * (x * x + y * y + 0.1).ln()
                        })
                        .sum::<f64>()
                })
                .sum::<f64>()
    },
    noise = [|q, p| (0..q.len()).map(|i| (0..i).map(|j| sigma * q[i][0] * q[j][1]).sum::<f64>()).sum::<f64>()],
    embedding = [Uncorrected<DeltaPlus>, Midpoint],
)]
struct Vortices {
    sigma: f64,
}

fn cluster(n: usize) -> Cluster {
    Cluster { k: 0.3, softening: 0.01, mass: (0..n).map(|i| 1.0 / (1.0 + i as f64)).collect() }
}

/// Below and above the numbers of lanes, of blocks, and of bodies from which there are columns.
fn sizes() -> impl Iterator<Item = usize> {
    (2..20).chain([31, 32, 33, 63, 64, 65, 79, 80, 81, 129])
}

#[test]
fn pairs_have_the_bits_of_one_number_after_the_other() {
    for n in sizes() {
        check(&cluster(n), 3 * n, "cluster");
        let rotors = Rotors { k: 0.1 / n as f64 };
        check(&rotors, n, "rotors");
        check_others(&rotors, n, "rotors");
        let start = [numbers(2 * n, 0.2), numbers(2 * n, 1.1)];
        check_scheme::<Uncorrected<DeltaPlus>, _>(&Vortices { sigma: 0.001 }, &start, H, "vortices");
    }
}

#[test]
fn rare_arguments_of_functions_have_the_bits_of_one_number_after_the_other() {
    for place in [0, 17, 64, 70] {
        let mut start = [numbers(71, 0.2), numbers(71, 1.1)];
        // Beyond what the reduction by π/2 in lanes takes.
        start[0][place.min(70)] = 1e9;
        check_scheme::<DeltaPlus, _>(&Rotors { k: 0.01 }, &start, H, "far away");
    }
}

/// The forces of a state: the change of momenta in a step of size one from rest.
fn forces<H: Discretized<DeltaPlus, Vector = DVector<f64>>>(system: &H, q: &[f64]) -> Vec<f64> {
    let (mut q, mut p) = (q.to_vec(), vec![0.0; q.len()]);
    let prepared = system.prepare(1.0).unwrap();
    system.advance(&prepared, 0.0, 1.0, &mut q, &mut p, &[], &mut system.memory()).unwrap();
    p
}

/// Each sum of `n` forces is rounded `n` times, and so is each of its terms about ten times.
#[test]
fn forces_are_those_by_hand_to_rounding() {
    for n in [17, 64, 100, 301] {
        let (cluster, q) = (Cluster { k: 0.0, ..cluster(n) }, numbers(3 * n, 0.2));
        let found = forces(&cluster, &q);
        for i in 0..n {
            let (mut force, mut size) = ([0.0; 3], 0.0);
            for j in (0..n).filter(|&j| j != i) {
                let d: [f64; 3] = std::array::from_fn(|k| q[3 * j + k] - q[3 * i + k]);
                let square = d.iter().map(|d| d * d).sum::<f64>() + cluster.softening;
                let pull = cluster.mass[i] * cluster.mass[j] / (square * square.sqrt());
                (0..3).for_each(|k| force[k] += pull * d[k]);
                size += pull * d.iter().map(|d| d.abs()).fold(0.0, f64::max);
            }
            for k in 0..3 {
                let apart = (force[k] - found[3 * i + k]).abs();
                assert!(apart <= 2.0 * (n + 10) as f64 * f64::EPSILON * size, "body {i} of {n}: {apart:e}");
            }
        }
    }
}

/// The derivative of the energy along a direction is the forces along it.
#[test]
fn forces_are_derivatives_of_the_energy() {
    for n in [16, 33, 64, 100] {
        let (cluster, q) = (cluster(n), numbers(3 * n, 0.2));
        let (rest, direction) = (vec![0.0; 3 * n], numbers(3 * n, 2.2));
        let energy = |s: f64| {
            let moved: Vec<f64> = q.iter().zip(&direction).map(|(q, d)| q + s * d).collect();
            cluster.energy(&State::new(moved, rest.clone()))
        };
        let found: f64 = forces(&cluster, &q).iter().zip(&direction).map(|(force, d)| -force * d).sum();
        // Richardson's extrapolation of central differences: truncation s⁴, rounding ε / s.
        let s = 1e-3;
        let central = |s: f64| (energy(s) - energy(-s)) / (2.0 * s);
        let slope = (4.0 * central(s) - central(2.0 * s)) / 3.0;
        assert!((found - slope).abs() < 1e-7 * (1.0 + slope.abs()), "{n} bodies: {found} by {slope}");
    }
}

/// Rotors of which each turns all others, and a force that a stepper accounts for.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        p.iter().map(|p| 0.5 * p * p).sum::<f64>()
            + (0..q.len()).map(|i| (0..i).map(|j| k * (1.0 - (q[i] - q[j]).cos())).sum::<f64>()).sum::<f64>()
    },
    force = |q: &[f64], p: &[f64], t| (0..q.len()).map(|i| -0.1 * q[i] * t),
    embedding = Verlet,
)]
struct Pushed {
    k: f64,
}

/// The columns belong to the stepper: they are there after the first step, in any thread.
#[test]
fn steps_allocate_nothing() {
    let (system, mut state) = (cluster(100), State::new(numbers(300, 0.2), numbers(300, 1.1)));
    let (pushed, mut angles) = (Pushed { k: 0.01 }, State::new(numbers(70, 0.2), numbers(70, 1.1)));
    assert_eq!(later_allocations::<Composed<Verlet, KahanLi8>, _>(&pushed, &mut angles, H, 10), 0);
    let run = |steps| {
        let run = pushed.simulate::<Verlet>(H).start(angles.clone()).steps(steps).record_every(0);
        allocation_counter::measure(|| assert!(run.run().is_ok())).count_total
    };
    assert_eq!(run(1000), run(100));
    let mut later = [
        later_allocations::<DeltaPlus, _>,
        later_allocations::<Verlet, _>,
        later_allocations::<Midpoint, _>,
        later_allocations::<Gauss<2>, _>,
        later_allocations::<Composed<Verlet, KahanLi8>, _>,
        later_allocations::<Composed<Verlet, TakahashiImada4>, _>,
        later_allocations::<Own<RungeKutta4>, _>,
    ]
    .map(|allocations| allocations(&system, &mut state, 0.01 * H, 10));
    let mut stepper = system.stepper::<Verlet>(H).unwrap();
    stepper.step(&mut state, &[]).unwrap();
    let counted = std::thread::scope(|scope| {
        let steps = || allocation_counter::measure(|| assert!(stepper.step(&mut state, &[]).is_ok()));
        scope.spawn(steps).join().unwrap()
    });
    later[1] += counted.count_total;
    assert_eq!(later, [0; 7]);
}

/// The mid-point's equations are solved to rounding whatever computes them: by vectors, or number by number.
#[test]
fn implicit_steps_are_those_of_one_number_after_the_other() {
    for n in [5, 17, 40, 64, 100] {
        check_implicit(&cluster(n), 3 * n, n);
        check_implicit(&Rotors { k: 0.1 / n as f64 }, n, n);
    }
}

fn check_implicit<E: Discretized<Midpoint, Vector = DVector<f64>>>(
    system: &E,
    degrees: usize,
    bodies: usize,
) {
    let alone = |list: &DVector<f64>| -> Vec<Lanes<1>> { list.iter().map(|&x| Lanes::new([x])).collect() };
    let mut state = State::new(numbers(degrees, 0.2), numbers(degrees, 1.1));
    let (mut q, mut p) = (alone(&state.q), alone(&state.p));
    system.stepper(H).unwrap().step(&mut state, &[]).unwrap();
    let prepared = system.prepare(H).unwrap();
    system.advance(&prepared, 0.0, H, &mut q, &mut p, &[], &mut Default::default()).unwrap();
    for (a, b) in state.q.iter().chain(&state.p).zip(q.iter().chain(&p)) {
        // Iterations end where a correction is a quarter of a rounding; sums of as many forces as bodies are rounded as often.
        let bound = (bodies + 10) as f64 * f64::EPSILON * (1.0 + a.abs());
        assert!((a - b[0]).abs() <= bound, "{bodies} bodies: {a} {}", b[0]);
    }
}
