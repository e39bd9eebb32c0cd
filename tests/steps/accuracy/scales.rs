//! Sizes: of parameters, states, steps and frequencies; exact zeros.

use fixtures::larger;
use wzvi::error::StepFailure;
use wzvi::prelude::*;
use wzvi::state::Vector;

use super::reference::{Case, Point, Terms, compare, state};
use super::systems::{Growth, Kepler, Kubo, Oscillator, Pendulum};

/// As the random steps: four times what rounded inputs leave open.
const CONDITIONED: f64 = 2.0;

fn case(h: f64, q: &[f64], p: &[f64], dw: &[f64]) -> Case {
    Case { h, q: q.to_vec(), p: p.to_vec(), dw: dw.to_vec() }
}

fn keeps_digits<E: Point, H: Discretized<E> + Terms>(system: &H, case: &Case) {
    let errors = compare::<E, H>(system, case).unwrap();
    assert!(errors.conditioned <= CONDITIONED, "{errors:?} {case:?}");
}

#[test]
fn frequencies_from_1e_minus_150_to_1e150() {
    for exponent in (-150..=150).step_by(30) {
        let omega = 10.0_f64.powi(exponent);
        let case = case(0.1 / omega, &[0.7], &[0.4 * omega], &[]);
        keeps_digits::<Midpoint, _>(&Oscillator { omega }, &case);
        keeps_digits::<DeltaPlus, _>(&Oscillator { omega }, &case);
    }
}

#[test]
fn masses_and_forces_from_1e_minus_150_to_1e150() {
    for (m, k) in [(1e-150_f64, 1e-150_f64), (1e150, 1e150), (1e-150, 1e150), (1e150, 1e-150), (1e-75, 1.0)] {
        let h = 0.1 * (m / k).sqrt();
        let case = case(h, &[0.7], &[0.4 * m.sqrt() * k.sqrt()], &[]);
        keeps_digits::<Midpoint, _>(&Pendulum { m, k }, &case);
        keeps_digits::<DeltaPlus, _>(&Pendulum { m, k }, &case);
    }
}

/// Subnormal numbers have 2^-1074 for their unit in the last place, and products of them with h are rounded to it.
#[test]
fn subnormal_states_are_right_to_their_last_place() {
    for size in [1e-305, 1e-308, 1e-310, 1e-320, 5e-324] {
        let case = case(0.1, &[0.7 * size], &[-0.4 * size], &[]);
        let errors = compare::<Midpoint, _>(&Oscillator { omega: 1.3 }, &case).unwrap();
        assert!(errors.state <= 3.0, "{size:e}: {errors:?}");
        let errors = compare::<Midpoint, _>(&Pendulum { m: 0.7, k: 1.9 }, &case).unwrap();
        assert!(errors.state <= 3.0, "{size:e}: {errors:?}");
    }
}

#[test]
fn states_of_1e200() {
    let large = case(0.1, &[0.7e200], &[-0.4e200], &[0.2]);
    keeps_digits::<Midpoint, _>(&Kubo { a: 1.5, sigma: 1.0 }, &large);
    keeps_digits::<Midpoint, _>(&Growth { a: 1.5, sigma: 1.0 }, &large);
    keeps_digits::<Midpoint, _>(&Oscillator { omega: 1.3 }, &case(0.1, &[0.7e200], &[-0.4e200], &[]));
}

/// Gravity is 1e-200 of the state there, and the flight free. The Jacobian squares the distance: at 1e200 that
/// overflows, and the fixed point, which needs no Jacobian, is found.
#[test]
fn gravity_far_away() {
    let mut stepper = Kepler.stepper::<Midpoint>(0.1).unwrap();
    let mut far = state::<<Kepler as Hamiltonian>::Vector>(&[1e100, -2e100], &[3.0, 4e100]);
    stepper.step(&mut far, &[]).unwrap();
    assert_eq!((far.q[0], far.p[0], far.p[1]), (1e100, 3.0, 4e100));
    assert!((far.q[1] / -1.6e100 - 1.0).abs() <= 4.0 * f64::EPSILON, "{far:?}");
    let mut farther = State::new([1e200, -2e200], [3.0, 4e200]);
    stepper.step(&mut farther, &[]).unwrap();
    assert_eq!((farther.q[0], farther.p[0], farther.p[1]), (1e200, 3.0, 4e200));
    assert!((farther.q[1] / -1.6e200 - 1.0).abs() <= 4.0 * f64::EPSILON, "{farther:?}");
}

/// `k (1 - cos q)` is `k q²/2` there, to the last place: the next term is 1e-19 of it.
#[test]
fn the_energy_of_a_small_angle() {
    let pendulum = Pendulum { m: 0.7, k: 1.9 };
    for q in [1e-9_f64, 3e-12, 7e-60] {
        let energy = pendulum.energy(&state(&[q], &[0.0]));
        let exact = 1.9 * (q * (q / 2.0));
        assert!((energy / exact - 1.0).abs() <= 3.0 * f64::EPSILON, "{q:e}: {energy:e}");
    }
}

/// One mid-point step turns (ω q, p) by `2 atan(ω h/2)`: to the rounding of four operations.
#[test]
fn the_rotation_angle_of_the_stiff_oscillator() {
    for exponent in -8..=8 {
        let product = 10.0_f64.powi(exponent);
        for omega in [1.0, 1e3, 1e-5] {
            let h = product / omega;
            let oscillator = Oscillator { omega };
            let mut stepper = oscillator.stepper::<Midpoint>(h).unwrap();
            let mut state = state::<<Oscillator as Hamiltonian>::Vector>(&[0.0], &[1.0]);
            stepper.step(&mut state, &[]).unwrap();
            let angle = (omega * state.q[0]).atan2(state.p[0]);
            let exact = 2.0 * (omega * h / 2.0).atan();
            let error = (angle / exact - 1.0).abs();
            println!("ω h = {product:5.0e}, ω = {omega:5.0e}: angle {angle:.3e}, relative error {error:.1e}");
            assert!(error <= 4.0 * f64::EPSILON, "ω h = {product:e}, ω = {omega:e}: {error:e}");
        }
    }
}

/// A thousand stiff steps stay on the circle: the radius wanders by the rounding of the state, ε √n to ε n. A step that adds
/// to the momentum what turns it back loses a thousand times that at ω h = 1e4.
#[test]
fn the_stiff_oscillator_stays_on_its_circle() {
    for exponent in 0..=8 {
        let omega = 10.0_f64.powi(exponent);
        let oscillator = Oscillator { omega };
        let mut stepper = oscillator.stepper::<Midpoint>(1.0).unwrap();
        let mut state = state::<<Oscillator as Hamiltonian>::Vector>(&[0.6], &[0.8 * omega]);
        for _ in 0..1000 {
            stepper.step(&mut state, &[]).unwrap();
            let error = (state.q[0].hypot(state.p[0] / omega) - 1.0).abs();
            assert!(error <= 1000.0 * f64::EPSILON, "ω h = {omega:e}: {error:e}");
        }
    }
}

/// Largest |q| of `steps` explicit steps with ω = 1.
fn amplitude(h: f64, steps: u32) -> f64 {
    let oscillator = Oscillator { omega: 1.0 };
    let mut stepper = oscillator.stepper::<DeltaPlus>(h).unwrap();
    let mut state = state::<<Oscillator as Hamiltonian>::Vector>(&[1.0], &[0.0]);
    let mut largest = 0.0_f64;
    for _ in 0..steps {
        stepper.step(&mut state, &[]).unwrap();
        largest = larger(largest, state.q[0].abs());
    }
    largest
}

/// The trace of the step is `2 - (ω h)²`: below ω h = 2 the orbit is an ellipse of elongation `1 / √(1 - (ω h/2)²)`, at 2
/// it grows by the same amount every step, above by a factor.
#[test]
fn the_explicit_scheme_is_unstable_from_two() {
    let steps = 100_000;
    for gap in [1.0, 1e-3, 1e-6] {
        let below = amplitude(2.0 - gap, steps);
        assert!(below <= 2.0 / (1.0 - (1.0 - gap / 2.0_f64).powi(2)).sqrt(), "2 - {gap:e}: {below:e}");
    }
    let at = amplitude(2.0, steps);
    assert!(at >= f64::from(steps) && at <= 5.0 * f64::from(steps), "{at:e}");
    let above = amplitude(2.0 + 1e-6, steps);
    assert!(above > 1e50, "{above:e}");
}

#[hamiltonian(drift = |q, p| 0.5 * p * p + q.sqrt(), embedding = DeltaPlus)]
struct Root;

#[hamiltonian(drift = |q, p| 0.5 * p * p + q.powf(1.5), embedding = DeltaPlus)]
struct Power;

#[hamiltonian(drift = |q, p| 0.5 * p * p + q.ln(), embedding = DeltaPlus)]
struct Logarithm;

#[hamiltonian(drift = |q, p| 0.5 * p * p + 1.0 / q, embedding = DeltaPlus)]
struct Inverse;

/// A step from `q = 0`, `p = 1` with h = 1/2.
fn from_zero<H: Discretized<DeltaPlus>>(system: &H) -> Result<[f64; 2], StepFailure> {
    let mut state = state::<H::Vector>(&[0.0], &[1.0]);
    let before = state.clone();
    match system.stepper::<DeltaPlus>(0.5).unwrap().step(&mut state, &[]) {
        Ok(_) => Ok([state.q.components()[0], state.p.components()[0]]),
        Err(error) => {
            assert_eq!(state, before);
            Err(error.cause)
        }
    }
}

/// The slope of `q^(3/2)` at zero is zero; those of the others are infinite.
#[test]
fn exact_zeros_give_the_value_or_an_error() {
    assert_eq!(from_zero(&Power), Ok([0.5, 1.0]));
    assert_eq!(from_zero(&Root), Err(StepFailure::NonFinite));
    assert_eq!(from_zero(&Logarithm), Err(StepFailure::NonFinite));
    assert_eq!(from_zero(&Inverse), Err(StepFailure::NonFinite));
}
