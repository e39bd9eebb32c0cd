//! A failed step leaves the stepper, all of it, bit for bit as it was.

use fixtures::Uniform;
use fixtures::small::Cubic;
use fixtures::stiff::SpringPendulum;
use wzvi::nalgebra::DVector;
use wzvi::prelude::*;

#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        p.iter().map(|p| 0.5 * p * p).sum::<f64>()
            + (1..q.len()).map(|i| 0.5 * k * (q[i] - q[i - 1]).powi(2)).sum::<f64>()
            - q.iter().map(|q| q.powi(3) / 3.0).sum::<f64>()
    },
    embedding = [Midpoint, DeltaPlus],
)]
#[derive(Debug)]
struct Chain {
    k: f64,
}

/// Sites that are not coupled, each with a memory.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| (0..q.len()).map(|i| 0.5 * p[i] * p[i] + 0.25 * q[i].powi(4)).sum::<f64>(),
    embedding = Midpoint,
)]
#[derive(Debug)]
struct Sites;

/// The watch that refused the step refuses it again, whatever fails in between.
#[test]
fn a_failed_call_does_not_reset_the_watch() {
    let spring = SpringPendulum { stiffness: 1e10 };
    let refused = |interrupts: bool| {
        let mut stepper = spring.stepper::<Midpoint>(0.01).unwrap();
        let mut state = State::new([1.0_f64.sin(), -1.0_f64.cos()], [0.0, 0.0]);
        (0..20_000).find(|step| {
            if interrupts && step % 50 == 0 {
                let mut elsewhere = State::new([f64::NAN, 0.0], [0.0, 0.0]);
                elsewhere.t = 1e3;
                assert!(stepper.step(&mut elsewhere, &[]).is_err());
            }
            stepper.step(&mut state, &[]).is_err()
        })
    };
    let alone = refused(false);
    assert!(alone.is_some());
    assert_eq!(refused(true), alone);
}

/// Random calls, good and bad: after each bad one the stepper prints as before (its numbers do so to the last bit), and the
/// steps that follow are those of a stepper that never saw a bad call.
fn exercise<H: Discretized<Midpoint> + std::fmt::Debug>(
    system: &H,
    h: f64,
    start: &State<H::Vector>,
    bad: impl Fn(&mut Uniform, &State<H::Vector>) -> (State<H::Vector>, Vec<f64>),
) {
    for seed in 1..=8 {
        let mut random = Uniform(seed);
        let mut plain = system.stepper::<Midpoint>(h).unwrap();
        let mut tried = system.stepper::<Midpoint>(h).unwrap();
        let (mut expected, mut state) = (start.clone(), start.clone());
        let mut failures = 0;
        for _ in 0..30 {
            while random.draw() < 0.0 {
                let before = format!("{tried:?}");
                let (mut other, dw) = bad(&mut random, &state);
                assert!(tried.step(&mut other, &dw).is_err());
                failures += 1;
                assert_eq!(format!("{tried:?}"), before);
            }
            plain.step(&mut expected, &[]).unwrap();
            tried.step(&mut state, &[]).unwrap();
            assert_eq!((&state.q, &state.p, state.t), (&expected.q, &expected.p, expected.t));
        }
        assert_eq!(format!("{tried:?}"), format!("{plain:?}"));
        assert!(failures > 5);
    }
}

#[test]
fn a_failed_step_leaves_the_stepper() {
    exercise(&Cubic, 0.1, &State::new([-1.0], [0.3]), |random, state| {
        let t = if random.draw() < 0.0 { state.t } else { 1e3 * random.draw() };
        let (q, p, dw) = match random.below(4) {
            0 => ([f64::NAN], [0.0], vec![]),
            // No solution: h² (q + h p / 2) > 1.
            1 => ([1e3 * (2.0 + random.draw())], [0.0], vec![]),
            2 => ([0.1], [f64::INFINITY], vec![]),
            _ => ([state.q[0]], [state.p[0]], vec![1.0]),
        };
        let mut state = State::new(q, p);
        state.t = t;
        (state, dw)
    });
    let start = State::new(vec![-1.0, -0.8, -0.9], vec![0.1, 0.0, -0.1]);
    exercise(&Chain { k: 2.0 }, 0.1, &start, |random, state| {
        let t = if random.draw() < 0.0 { state.t } else { 1e3 * random.draw() };
        let n = 1 + random.below(6);
        let (q, p, dw) = match random.below(4) {
            0 => (vec![f64::NAN; n], vec![0.0; n], vec![]),
            1 => (vec![1e3 * (2.0 + random.draw()); n], vec![0.0; n], vec![]),
            2 => (vec![0.0; n], vec![0.0; n + 1], vec![]),
            _ => (vec![0.0; n], vec![0.0; n], vec![1.0]),
        };
        (State { q: DVector::from(q), p: DVector::from(p), t }, dw)
    });
    // One site of many.
    let infinite = |random: &mut Uniform, state: &State<DVector<f64>>| {
        let mut bad = state.clone();
        bad.q[random.below(state.q.len())] = f64::INFINITY;
        (bad, vec![])
    };
    exercise(&Sites, 0.1, &State::new(vec![0.5, -0.8, 0.1, 0.9, 0.3, -0.2], vec![0.1; 6]), infinite);
    exercise(&Chain { k: 2.0 }, 0.1, &State::new(vec![-0.9; 40], vec![0.1; 40]), infinite);
}
