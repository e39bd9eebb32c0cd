//! The choice between the fixed point and Newton's method: by what each costs to finish, with a way back.

use wzvi::memory::StepMemory;
use wzvi::nalgebra::DVector;
use wzvi::prelude::*;

/// A spin, as two oscillators, and modes that turn it: not separable, and each mode is coupled to the spin.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let spin = q[0] * q[0] + p[0] * p[0] - q[1] * q[1] - p[1] * p[1];
        0.5 * (q[0] * q[1] + p[0] * p[1])
            + (2..q.len()).map(|j| 0.5 * p[j] * p[j] + 0.5 * frequency[j] * frequency[j] * q[j] * q[j]).sum::<f64>()
            + (2..q.len()).map(|j| coupling * q[j] * spin).sum::<f64>()
    },
    embedding = [Midpoint, Gauss<4>],
)]
struct Spin {
    frequency: Vec<f64>,
    coupling: f64,
}

const MODES: usize = 20;

fn spin() -> (Spin, State<DVector<f64>>) {
    let n = MODES + 2;
    let frequency = (0..n).map(|j| 0.3 + 0.12 * j as f64).collect();
    let wave = |shift: usize| (0..n).map(|i| (1.3 * (i + shift) as f64).sin()).collect::<Vec<_>>();
    (Spin { frequency, coupling: 0.1 }, State::new(wave(0), wave(40)))
}

/// One factorisation of 44 unknowns takes as many operations as a hundred sweeps; contractions up to a third
/// need fewer.
#[test]
fn a_spin_with_twenty_modes_is_swept() {
    let (spin, mut state) = spin();
    let (h, mut memory) = (0.1, Discretized::<Midpoint>::memory(&spin));
    let prepared = Discretized::<Midpoint>::prepare(&spin, h).unwrap();
    for _ in 0..200 {
        let (q, p) = (state.q.as_mut_slice(), state.p.as_mut_slice());
        Discretized::<Midpoint>::advance(&spin, &prepared, 0.0, h, q, p, &[], &mut memory).unwrap();
    }
    assert_eq!(memory.linear_work().factorisations, 0);
}

/// Sweeps of longer steps contract less: 176 unknowns are still no case for Newton's method, which needs at
/// most five iterations. Both end at the same states, to the rounding of the equations.
#[test]
fn slow_sweeps_are_cheaper_than_large_matrices() {
    for h in [0.3, 0.5] {
        let run = |iteration: Iteration| {
            let (spin, mut state) = spin();
            let mut stepper = spin.stepper::<Gauss<4>>(h).unwrap().iteration(iteration);
            let taken: Vec<u32> = (0..4).map(|_| stepper.step(&mut state, &[]).unwrap().iterations).collect();
            (state, taken)
        };
        let ((swept, sweeps), (solved, _)) = (run(Iteration::Automatic), run(Iteration::Newton));
        assert!(sweeps[1..].iter().all(|&sweeps| sweeps > 10), "h = {h}: {sweeps:?}");
        // A hundred roundings of numbers of order one.
        let apart = (&swept.q - &solved.q).amax().max((&swept.p - &solved.p).amax());
        assert!(apart < 100.0 * f64::EPSILON, "h = {h}: {apart:e}");
    }
}

#[hamiltonian(
    drift = |q: [f64; 2], p: [f64; 2]| {
        0.5 * (p[0] * p[0] + p[1] * p[1] + q[0] * q[0] + q[1] * q[1]) + q[0] * q[0] * q[1] - q[1] * q[1] * q[1] / 3.0
    },
    embedding = [Gauss<4>, Gauss<16>],
)]
struct HenonHeiles;

/// How many of 300 steps are swept: Newton's method takes six iterations at most, sweeps at least eight.
fn swept<E>(h: f64) -> usize
where
    HenonHeiles: Discretized<E, Vector = wzvi::nalgebra::SVector<f64, 2>>,
{
    let mut state = State::new([0.1, 0.2], [0.3, 0.1]);
    let mut stepper = HenonHeiles.stepper::<E>(h).unwrap();
    (0..300).filter(|_| stepper.step(&mut state, &[]).unwrap().iterations > 6).count()
}

/// A few of these steps are too long for sweeps. The others are not, and do not pay for them.
#[test]
fn steps_after_one_by_newtons_method_are_swept_again() {
    assert!(swept::<Gauss<4>>(1.86) > 200);
    assert_eq!(swept::<Gauss<16>>(1.9), 300);
}
