//! Parameters that the Hamiltonian divides by: they cancel, and at zero there is still no energy and no step.

use wzvi::prelude::*;

#[hamiltonian(drift = |q, p| p * p / (2.0 * m) + m * m * q * q / m + k * m * q / m, embedding = Midpoint)]
struct Written {
    m: f64,
    k: f64,
}

#[hamiltonian(drift = |q, p| p * p / (2.0 * m) + m * q * q + k * q, embedding = Midpoint)]
struct Cancelled {
    m: f64,
    k: f64,
}

/// Nothing else divides by `m`: without the division there would be an energy at `m = 0`.
#[hamiltonian(drift = |q, p| 0.5 * p * p + m * m * q * q / m, embedding = Midpoint)]
struct Kept {
    m: f64,
}

#[test]
fn divisors_cancel_and_stay_divisors() {
    let start = State::new([0.7], [0.4]);
    let (written, cancelled) = (Written { m: 1.3, k: 0.9 }, Cancelled { m: 1.3, k: 0.9 });
    let (mut ours, mut plain) = (start, start);
    written.stepper::<Midpoint>(0.1).unwrap().step(&mut ours, &[]).unwrap();
    cancelled.stepper::<Midpoint>(0.1).unwrap().step(&mut plain, &[]).unwrap();
    // One formula, so the same bits.
    assert_eq!(ours, plain);
    assert_eq!(written.energy(&ours), cancelled.energy(&plain));
    // 0.4²/2 + 2 · 0.7², to two roundings.
    assert!((Kept { m: 2.0 }.energy(&start) - 1.06).abs() < 4.0 * f64::EPSILON);

    assert!(!Written { m: 0.0, k: 0.9 }.energy(&start).is_finite());
    assert!(Kept { m: 0.0 }.energy(&start).is_nan());
    let is_refused = match (Written { m: 0.0, k: 0.9 }).stepper::<Midpoint>(0.1) {
        Ok(mut stepper) => stepper.step(&mut start.clone(), &[]).is_err(),
        Err(_) => true,
    };
    assert!(is_refused);
}
