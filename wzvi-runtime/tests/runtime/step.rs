//! One step: what it computes, and what it leaves alone.

use super::systems::{Kubo, Pendulum, Rotors, V1, path};
use nalgebra::{DVector, SMatrix};
use wzvi_runtime::algebra::scalar::Dual;
use wzvi_runtime::algebra::state::State;
use wzvi_runtime::error::{ConfigError, StepFailure};
use wzvi_runtime::integrate::Integrate;
use wzvi_runtime::path::step::Stepper;
use wzvi_runtime::scheme::embedding::{DeltaPlus, Midpoint};
use wzvi_runtime::scheme::system::Discretized;

const KUBO: Kubo = Kubo { a: 1.5, sigma: 1.0 };
const PENDULUM: Pendulum = Pendulum { omega: 1.3 };

fn bits(state: &State<V1>) -> [u64; 3] {
    [state.q[0], state.p[0], state.t].map(f64::to_bits)
}

#[test]
fn kubo_is_the_cayley_map() {
    let h = 0.02;
    let mut stepper = KUBO.stepper::<Midpoint>(h).unwrap();
    let mut state: State<V1> = State::new([0.3], [1.0]);
    for dw in path(100, h) {
        let (q, p) = (state.q[0], state.p[0]);
        stepper.step(&mut state, &[dw]).unwrap();
        let theta = KUBO.theta(h, dw);
        let factor = 1.0 + theta * theta;
        let closed = [
            ((1.0 - theta * theta) * q + 2.0 * theta * p) / factor,
            ((1.0 - theta * theta) * p - 2.0 * theta * q) / factor,
        ];
        // A few roundings of numbers of size one.
        assert!((state.q[0] - closed[0]).abs() <= 4.0 * f64::EPSILON, "{state:?} {closed:?}");
        assert!((state.p[0] - closed[1]).abs() <= 4.0 * f64::EPSILON, "{state:?} {closed:?}");
    }
    assert_eq!(stepper.steps(), 100);
}

#[test]
fn the_pendulum_solves_the_midpoint_rule() {
    let h = 0.1;
    let mut stepper = PENDULUM.stepper::<Midpoint>(h).unwrap();
    let mut state: State<V1> = State::new([1.0], [0.5]);
    for _ in 0..1000 {
        let before = state;
        let info = stepper.step(&mut state, &[]).unwrap();
        assert!((1..=6).contains(&info.iterations), "{info:?}");
        let (q, p) = (0.5 * (before.q[0] + state.q[0]), 0.5 * (before.p[0] + state.p[0]));
        let force = PENDULUM.omega.powi(2) * q.sin();
        assert!((state.q[0] - before.q[0] - h * p).abs() <= 4.0 * f64::EPSILON);
        assert!((state.p[0] - before.p[0] + h * force).abs() <= 4.0 * f64::EPSILON);
    }
}

#[test]
fn time_is_start_plus_n_h() {
    let (t0, h) = (0.1, 0.1);
    let mut stepper = PENDULUM.stepper::<Midpoint>(h).unwrap();
    let mut state: State<V1> = State::new([1.0], [0.5]).at(t0);
    for n in 1..=1000_u32 {
        stepper.step(&mut state, &[]).unwrap();
        assert_eq!(state.t.to_bits(), (t0 + f64::from(n) * h).to_bits(), "step {n}");
    }
    // A state that the caller moves starts its own clock.
    state.t = 0.7;
    stepper.step(&mut state, &[]).unwrap();
    assert_eq!(state.t, 0.7 + h);
}

#[test]
fn moving_the_state_forgets_the_steps_before() {
    let mut used = PENDULUM.stepper::<Midpoint>(0.1).unwrap();
    let mut state: State<V1> = State::new([1.0], [0.5]);
    for _ in 0..10 {
        used.step(&mut state, &[]).unwrap();
    }
    let mut fresh = PENDULUM.stepper::<Midpoint>(0.1).unwrap();
    let (mut one, mut other) = (State::new([2.0], [-0.5]), State::new([2.0], [-0.5]));
    used.step(&mut one, &[]).unwrap();
    fresh.step(&mut other, &[]).unwrap();
    assert_eq!(bits(&one), bits(&other));
}

#[test]
fn a_failed_step_leaves_every_bit() {
    let mut kubo: Stepper<'_, Kubo, Midpoint> = KUBO.stepper(0.02).unwrap();
    let start = State::new([0.3], [1.0]).at(2.0);
    let (nan, inf, big) = (f64::NAN, f64::INFINITY, f64::MAX);
    let cases: [(State<V1>, &[f64], StepFailure); 8] = [
        (start, &[], StepFailure::Increments { expected: 1, got: 0 }),
        (start, &[0.1, 0.2], StepFailure::Increments { expected: 1, got: 2 }),
        (start, &[nan], StepFailure::NonFiniteInput),
        (State::new([nan], [1.0]), &[0.1], StepFailure::NonFiniteInput),
        (State::new([0.3], [-inf]), &[0.1], StepFailure::NonFiniteInput),
        (start.at(nan), &[0.1], StepFailure::NonFiniteInput),
        (start.at(inf), &[0.1], StepFailure::NonFiniteInput),
        (State::new([-big], [big]), &[1.0], StepFailure::NonFinite),
    ];
    for (mut state, dw, cause) in cases {
        let before = bits(&state);
        let error = kubo.step(&mut state, dw).unwrap_err();
        assert_eq!(error.cause, cause, "{state:?}");
        assert_eq!((error.step, error.h, error.t.to_bits()), (0, 0.02, before[2]));
        assert_eq!(bits(&state), before);
    }
    assert_eq!(kubo.steps(), 0);

    let mut pendulum = PENDULUM.stepper::<Midpoint>(0.1).unwrap();
    for (q, p) in [(nan, 1.0), (1.0, inf), (inf, 0.0)] {
        let mut state = State::new([q], [p]);
        let before = bits(&state);
        assert_eq!(pendulum.step(&mut state, &[]).unwrap_err().cause, StepFailure::NonFiniteInput);
        assert_eq!(bits(&state), before);
    }
}

#[test]
fn after_a_failure_the_run_goes_on_as_if_nothing_had_been() {
    let mut one = PENDULUM.stepper::<Midpoint>(0.1).unwrap();
    let mut other = PENDULUM.stepper::<Midpoint>(0.1).unwrap();
    let (mut a, mut b) = (State::new([1.0], [0.5]), State::new([1.0], [0.5]));
    for n in 0..50 {
        if n % 7 == 3 {
            one.step(&mut a, &[1.0]).unwrap_err();
        }
        one.step(&mut a, &[]).unwrap();
        other.step(&mut b, &[]).unwrap();
        assert_eq!(bits(&a), bits(&b), "step {n}");
    }
}

#[test]
fn wrong_dimensions_are_refused() {
    let rotors = Rotors { count: 3, sigma: 0.5 };
    let mut stepper = rotors.stepper::<DeltaPlus>(0.1).unwrap();
    for (q, p, got) in [(2, 3, 2), (3, 4, 4), (0, 0, 0)] {
        let mut state = State { q: DVector::from_element(q, 1.0), p: DVector::from_element(p, 1.0), t: 0.0 };
        let before = state.clone();
        let error = stepper.step(&mut state, &[0.0; 3]).unwrap_err();
        assert_eq!(error.cause, StepFailure::Dimension { expected: 3, got });
        assert_eq!(state, before);
    }
    // The last component overflows: the ones before it must not have moved.
    let mut state = State::new(vec![1.0; 3], vec![1.0, 1.0, f64::MAX]);
    let before = state.clone();
    let mut wide = rotors.stepper::<DeltaPlus>(10.0).unwrap();
    assert_eq!(wide.step(&mut state, &[0.1; 3]).unwrap_err().cause, StepFailure::NonFinite);
    assert_eq!(state, before);
}

#[test]
fn step_sizes_that_mean_nothing_are_refused() {
    for h in [0.0, -0.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(KUBO.stepper::<Midpoint>(h), Err(ConfigError::StepSize(_))), "{h}");
    }
    assert_eq!(
        Kubo { a: f64::NAN, sigma: 1.0 }.stepper::<Midpoint>(0.1).unwrap_err(),
        ConfigError::Parameter
    );
}

/// `JᵀΩJ - Ω` of one step, by dual numbers through `advance`.
fn defect<H: Discretized<Midpoint>>(system: &H, q: f64, p: f64, h: f64, dw: &[f64]) -> f64 {
    let [mut q, mut p] = Dual::variables([q, p]).map(|x| [x]);
    let dw: Vec<_> = dw.iter().map(|&dw| Dual::constant(dw)).collect();
    let prepared = system.prepare(h).unwrap();
    let mut memory = Default::default();
    system.advance(&prepared, 0.0, h, &mut q, &mut p, &dw, &mut memory).unwrap();
    let jacobian = SMatrix::<f64, 2, 2>::from_row_slice(&[q[0].derivative, p[0].derivative].concat());
    (jacobian.determinant() - 1.0).abs()
}

#[test]
fn the_jacobian_of_a_step_is_symplectic() {
    for (i, dw) in path(50, 1.0).into_iter().enumerate() {
        let (q, p, h) = (0.1 * i as f64 - 2.0, 0.07 * i as f64 - 1.0, 0.02 * (i + 1) as f64);
        let kubo = defect(&KUBO, q, p, h, &[dw]);
        assert!(kubo <= 1e-12, "{kubo:e}");
        let pendulum = defect(&PENDULUM, q, p, h.min(0.5), &[]);
        assert!(pendulum <= 1e-12, "{pendulum:e}");
    }
}
