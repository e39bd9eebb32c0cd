//! A failed step leaves the stepper, all of it, bit for bit as it was.

use fixtures::stiff::SpringPendulum;
use wzvi::nalgebra::DVector;
use wzvi::prelude::*;
use wzvi::state::Vector as _;

/// `H = p²/2 - q³/3`: far out a step has no solution.
#[hamiltonian(drift = |q, p| 0.5 * p * p - q * q * q / 3.0, embedding = Midpoint)]
#[derive(Debug)]
struct Cubic;

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

fn random(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*seed >> 11) as f64 / (1_u64 << 53) as f64
}

/// What becomes of the next steps, up to one that is refused, and their last state; with or without a call that fails before each.
fn run<H: Discretized<Midpoint>>(
    system: &H,
    h: f64,
    start: &State<H::Vector>,
    interrupts: bool,
) -> (u64, String, State<H::Vector>) {
    let mut stepper = system.stepper::<Midpoint>(h).unwrap();
    let (mut state, mut infos) = (start.clone(), String::new());
    for n in 0..1000 {
        if interrupts {
            let mut elsewhere = start.clone();
            (elsewhere.q.components_mut()[0], elsewhere.t) = (f64::NAN, 1e3);
            assert!(stepper.step(&mut elsewhere, &[]).is_err());
        }
        match stepper.step(&mut state, &[]) {
            Ok(info) => infos += &format!("{info:?}"),
            Err(error) => return (n, infos + &error.to_string(), state),
        }
    }
    (u64::MAX, infos, state)
}

/// A step that is refused is refused again, and one that is hard stays so, whatever fails in between.
#[test]
fn a_failed_call_changes_no_verdict() {
    let escaping = State::new([0.5], [0.0]);
    let alone = run(&Cubic, 0.1, &escaping, false);
    assert!((10..1000).contains(&alone.0), "{alone:?}");
    assert_eq!(run(&Cubic, 0.1, &escaping, true), alone);
    let (spring, start) =
        (SpringPendulum { stiffness: 1e10 }, State::new([1.0_f64.sin(), -1.0_f64.cos()], [0.0, 0.0]));
    let alone = run(&spring, 0.01, &start, false);
    assert!(alone.1.contains("is_hard: true"));
    assert_eq!(run(&spring, 0.01, &start, true), alone);
}

/// Random calls, good and bad: after each bad one the stepper prints as before (its numbers do so to the last bit), and the
/// steps that follow are those of a stepper that never saw a bad call.
fn exercise<H: Discretized<Midpoint> + std::fmt::Debug>(
    system: &H,
    h: f64,
    start: &State<H::Vector>,
    bad: impl Fn(&mut u64, &State<H::Vector>) -> (State<H::Vector>, Vec<f64>),
) {
    for seed in 1..=8 {
        let mut seed = seed;
        let mut plain = system.stepper::<Midpoint>(h).unwrap();
        let mut tried = system.stepper::<Midpoint>(h).unwrap();
        let (mut expected, mut state) = (start.clone(), start.clone());
        let mut failures = 0;
        for _ in 0..30 {
            while random(&mut seed) < 0.5 {
                let before = format!("{tried:?}");
                let (mut other, dw) = bad(&mut seed, &state);
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
    exercise(&Cubic, 0.1, &State::new([-1.0], [0.3]), |seed, state| {
        let t = if random(seed) < 0.5 { state.t } else { 1e3 * random(seed) };
        let (q, p, dw) = match (4.0 * random(seed)) as u32 {
            0 => ([f64::NAN], [0.0], vec![]),
            // No solution: h² (q + h p / 2) > 1.
            1 => ([1e3 * (1.0 + random(seed))], [0.0], vec![]),
            2 => ([0.1], [f64::INFINITY], vec![]),
            _ => ([state.q[0]], [state.p[0]], vec![1.0]),
        };
        let mut state = State::new(q, p);
        state.t = t;
        (state, dw)
    });
    let start = State::new(vec![-1.0, -0.8, -0.9], vec![0.1, 0.0, -0.1]);
    exercise(&Chain { k: 2.0 }, 0.1, &start, |seed, state| {
        let t = if random(seed) < 0.5 { state.t } else { 1e3 * random(seed) };
        let n = 1 + (6.0 * random(seed)) as usize;
        let (q, p, dw) = match (4.0 * random(seed)) as u32 {
            0 => (vec![f64::NAN; n], vec![0.0; n], vec![]),
            1 => (vec![1e3 * (1.0 + random(seed)); n], vec![0.0; n], vec![]),
            2 => (vec![0.0; n], vec![0.0; n + 1], vec![]),
            _ => (vec![0.0; n], vec![0.0; n], vec![1.0]),
        };
        (State { q: DVector::from(q), p: DVector::from(p), t }, dw)
    });
}
