//! Smooth motions through points where the chain rule multiplies zero by infinity: contacts, roots, and the
//! centre of a force.

use wzvi::prelude::*;
use wzvi::state::Vector as _;

/// Contacts of one body, roots, centres of forces, and chains of beads in contact.
macro_rules! systems {
    ($($name:ident = $drift:expr;)+) => {$(
        #[hamiltonian(drift = $drift, embedding = [Verlet, Midpoint, Gauss<4>])]
        struct $name;
    )+};
}

systems! {
    Contact = |q, p| 0.5 * p * p + (1.0 - q).max(0.0).powf(1.5) + 0.05 * q * q;
    RootOfMax = |q, p| 0.5 * p * p + (q - 1.0).max(0.0).sqrt().powi(3) + 0.05 * q * q;
    CubeRoot = |q, p| {
        let u = (q - 1.0).max(0.0);
        0.5 * p * p + u * u.cbrt() + 0.05 * q * q
    };
    Squares = |q, p| 0.5 * p * p + (q * q).powf(0.75);
    Absolute = |q, p| 0.5 * p * p + q.abs().powf(1.5);
    Radius = |[x, y], [u, v]| 0.5 * (u * u + v * v) + x.hypot(y).powi(2) / 2.0;
    Ripple = |[x, y], [u, v]| 0.5 * (u * u + v * v) - 0.1 * (6.0 * x.hypot(y)).cos();
    Wave = |[x, y], [u, v]| 0.5 * (u * u + v * v) - 0.1 * (2.0 * (x * x + y * y).sqrt()).cos();
    Space = |[x, y, z], [u, v, w]| 0.5 * (u * u + v * v + w * w) + x.hypot(y).hypot(z).cosh();
    Power = |[x, y], [u, v]| 0.5 * (u * u + v * v) + x.hypot(y).powf(1.5);
    Hertz = |q: &[f64], p: &[f64]| p.iter().map(|p| 0.5 * p * p).sum::<f64>()
        + q.windows(2).map(|w| (w[0] - w[1] + 1.0).max(0.0).powf(2.5)).sum::<f64>()
        + 0.5 * q[0] * q[0];
    Soft = |q: &[f64], p: &[f64]| p.iter().map(|p| 0.5 * p * p).sum::<f64>()
        + q.windows(2).map(|w| (w[0] - w[1] + 1.0).max(0.0).powf(1.5)).sum::<f64>()
        + 0.5 * q[0] * q[0];
    Twenty = |q: [f64; 20], p: [f64; 20]| p.iter().map(|p| 0.5 * p * p).sum::<f64>()
        + q.windows(2).map(|w| (w[0] - w[1] + 1.0).max(0.0).powf(1.5)).sum::<f64>();
}

/// A wall and a well with an exponent of the system.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p + (1.0 - q).max(0.0).powf(self.exponent) + 0.1 * (q - 1.0).abs().powf(self.exponent),
    embedding = [Verlet, Midpoint, Gauss<4>]
)]
struct Exponent {
    exponent: f64,
}

/// The energy stays within `h` of its start, the state is finite, and lanes take the same starts.
fn runs<E, H: Discretized<E> + Sync>(system: &H, h: f64, starts: &[State<H::Vector>])
where
    State<H::Vector>: Clone,
{
    const STEPS: u64 = 400;
    let what = std::any::type_name::<(E, H)>();
    for start in starts {
        let (mut state, energy) = (start.clone(), system.energy(start));
        let mut stepper = system.stepper::<E>(h).unwrap();
        for step in 0..STEPS {
            stepper.step(&mut state, &[]).unwrap_or_else(|error| panic!("{what}: {step}: {error}"));
            // Of order two in time; where the force has an infinite slope it loses half an order.
            let off = (system.energy(&state) - energy).abs();
            assert!(off <= h * (1.0 + energy.abs()), "{what}: {step}: {off}");
        }
        assert!(state.q.components().iter().all(|q| q.is_finite()), "{what}");
    }
    let ensemble = system.ensemble::<E>(h).starts_from(starts.to_vec()).steps(STEPS);
    assert_eq!(ensemble.run_in::<8>().unwrap_or_else(|error| panic!("{what}: {error}")).failed(), 0);
}

macro_rules! all_schemes {
    ($system:expr, $starts:expr) => {
        runs::<Verlet, _>(&$system, 0.01, &$starts);
        runs::<Midpoint, _>(&$system, 0.01, &$starts);
        runs::<Gauss<4>, _>(&$system, 0.01, &$starts);
    };
}

#[test]
fn contacts_and_roots_are_crossed() {
    let starts = [(1.0, 0.0), (1.0, 0.4), (1.0, -0.4), (0.0, 0.0), (0.0, 0.6), (0.3, 1.0), (2.0, 0.0)];
    let starts = starts.map(|(q, p)| State::new([q], [p]));
    all_schemes!(Contact, starts);
    all_schemes!(RootOfMax, starts);
    all_schemes!(CubeRoot, starts);
    all_schemes!(Squares, starts);
    all_schemes!(Absolute, starts);
    for exponent in [1.5, 2.0, 2.5] {
        all_schemes!(Exponent { exponent }, starts);
    }
}

#[test]
fn centres_of_smooth_forces_are_crossed() {
    let starts = [[0.0, 0.0], [0.3, 0.4], [-0.5, 0.0]].map(|p| State::new([0.0, 0.0], p));
    all_schemes!(Radius, starts);
    all_schemes!(Ripple, starts);
    all_schemes!(Wave, starts);
    all_schemes!(Power, starts);
    all_schemes!(Space, [[0.0; 3], [0.3, 0.4, 0.1]].map(|p| State::new([0.0; 3], p)));
    // At rest.
    let mut state = State::new([0.0, 0.0], [0.0, 0.0]);
    Ripple.stepper::<Midpoint>(0.1).unwrap().step(&mut state, &[]).unwrap();
    assert_eq!(state, State { t: 0.1, ..State::new([0.0, 0.0], [0.0, 0.0]) });
}

/// The motion near the centre is that of the oscillator with the second derivative of the force, 3.6.
#[test]
fn the_limit_of_the_force_is_its_slope() {
    let (mut state, h, p) = (State::new([0.0, 0.0], [1e-6, 0.0]), 1e-3, 1e-6);
    let mut stepper = Ripple.stepper::<Gauss<4>>(h).unwrap();
    (0..500).for_each(|_| stepper.step(&mut state, &[]).map(drop).unwrap());
    let omega = 3.6_f64.sqrt();
    // Anharmonic terms are (6 q)² / 6 = 6e-12 of it, the error of the scheme is below 1e-14.
    assert!((state.q[0] - p * (omega * 0.5).sin() / omega).abs() < 1e-10 * p, "{state:?}");
}

#[test]
fn chains_of_beads_are_stepped() {
    let starts = |beads: u32| {
        let touching: Vec<f64> = (0..beads).map(f64::from).collect();
        let mut push = vec![0.0; touching.len()];
        push[0] = 0.7;
        [State::new(touching.clone(), vec![0.0; touching.len()]), State::new(touching, push)]
    };
    all_schemes!(Hertz, starts(6));
    // With an infinite stiffness at the first touch a push reaches all beads at once.
    all_schemes!(Soft, starts(6));
    let touching: [f64; 20] = std::array::from_fn(|i| i as f64);
    let mut push = [0.0; 20];
    push[0] = 0.7;
    all_schemes!(Twenty, [State::new(touching, [0.0; 20]), State::new(touching, push)]);
}
