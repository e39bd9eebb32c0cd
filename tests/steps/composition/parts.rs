//! `drift = [H_A, H_B]`: the flows of the parts take turns.

use wzvi::nalgebra::SVector;
use wzvi::prelude::*;

use super::{check_gradient, check_symplectic_and_symmetric};
use fixtures::extremes::state;
use fixtures::steps::{advance, order_of_step, step_apart};

/// Oscillators of three frequencies, and a weak coupling.
#[hamiltonian(
    drift = [
        |[x, y, z], [px, py, pz]| 0.5 * (px * px + x * x) + 0.5 * 1.7 * (py * py + y * y) + 0.5 * (pz * pz + 7.3 * z * z),
        |[x, y, z], _| epsilon * (x * x * y - y.powi(3) / 3.0 + (x * z).cos()),
    ],
    embedding = [Verlet, Midpoint, Gauss<8>],
)]
struct Oscillators {
    epsilon: f64,
}

/// A quadratic form that does not split, with a linear term, and a kick that reads the time.
#[hamiltonian(
    drift = [
        |q, p| 0.5 * p * p + 0.3 * q * p + 2.0 * q * q + 0.7 * q,
        |q, _, t| 0.1 * q.powi(4) + 0.2 * q * (1.3 * t).sin(),
    ],
    embedding = [Verlet, Gauss<6>],
)]
struct Rotating;

/// A drift first, and the sum does not read as it is parted.
#[hamiltonian(
    drift = [|_, p| p.cosh(), |q, _| -q.cos()],
    embedding = Verlet,
)]
struct Relativistic;

#[hamiltonian(drift = |q, p| p.cosh() - q.cos(), embedding = Verlet)]
struct Together;

macro_rules! chain {
    ($name:ident, [$($generics:tt)*], $state:ty) => {
        /// Springs from site to site, and weak anharmonic ones.
        #[hamiltonian(
            drift = [
                |q: $state, p: $state| p.iter().map(|p| 0.5 * p * p).sum::<f64>()
                    + (1..q.len()).map(|i| 0.5 * (q[i] - q[i - 1]).powi(2)).sum::<f64>(),
                |q, _| (1..q.len()).map(|i| 0.01 * (q[i] - q[i - 1]).powi(4)).sum::<f64>(),
            ],
            embedding = Verlet,
        )]
        struct $name$($generics)*;
    };
}

chain!(Chain, [], [f64; 6]);
chain!(ChainInLoops, [<const N: usize>], [f64; N]);

/// The distance from the exact end at `T = 4` after so many steps.
fn error<E>(epsilon: f64, steps: u32) -> f64
where
    Oscillators: Discretized<E, Vector = SVector<f64, 3>>,
{
    let system = Oscillators { epsilon };
    let start = State::new([0.4, 0.3, 0.2], [0.1, -0.3, 0.5]);
    let h = 4.0 / f64::from(steps);
    let ours = *system.simulate::<E>(h).start(start).steps(steps.into()).run().unwrap().last();
    let exact = *system.simulate::<Gauss<8>>(0.1).start(start).steps(40).run().unwrap().last();
    ((ours.q - exact.q).norm_squared() + (ours.p - exact.p).norm_squared()).sqrt()
}

/// `ε h^8 + ε² h^6 + ε³ h^4`: where `ε` is small the order is 8, or 10, and the error is of the size of `ε`; then it is 6 and `ε²`, and
/// 4 where no power of `ε` is small. Other terms are not yet, or no longer, small: an order shows to within 0.4, that of 10 to
/// within 0.7.
#[test]
fn errors_of_near_integrable_systems_are_small_by_their_parameter() {
    type Eight = Composed<Verlet, Aba864>;
    type Ten = Composed<Verlet, Aba1064>;
    let shows = |[coarse, fine]: [f64; 2], order: f64, within: f64| {
        let measured = (coarse / fine).log2();
        assert!((measured - order).abs() < within, "{order}: {measured} of {coarse:e}, {fine:e}");
    };
    shows([8, 16].map(|n| error::<Eight>(1e-3, n)), 8.0, 0.4);
    shows([12, 24].map(|n| error::<Eight>(1e-2, n)), 6.0, 0.4);
    shows([64, 128].map(|n| error::<Eight>(3.0, n)), 4.0, 0.4);
    shows([4, 8].map(|n| error::<Ten>(1e-4, n)), 10.0, 0.7);
    shows([8, 16].map(|n| error::<Ten>(1e-2, n)), 6.0, 0.4);
    // Powers of the parameter show by halving it.
    shows([1e-5, 5e-6].map(|epsilon| error::<Eight>(epsilon, 4)), 1.0, 0.1);
    shows([1e-2, 5e-3].map(|epsilon| error::<Eight>(epsilon, 16)), 2.0, 0.4);
    let small = [4, 8].map(|n| error::<Eight>(1e-5, n));
    // The sum by kicks and drifts knows nothing of that.
    assert!(error::<Composed<Verlet, BlanesMoan4>>(1e-5, 8) > 1e3 * small[1]);
}

/// Half of the step leaves `2^-(4 + 1)` of its error, whatever the parts read.
#[test]
fn parts_may_be_mixed_read_the_time_and_have_linear_terms() {
    let start: [&[f64]; 2] = [&[0.5], &[0.4]];
    let order = order_of_step::<Composed<Verlet, Aba864>, Gauss<6>, _>(&Rotating, start, [0.3, 0.4], &[]);
    assert!(order > 3.7, "{order}");
}

/// The parts of `T(p) + V(q)` are drift and kick, whether the user parts them or the compiler does.
#[test]
fn a_separable_drift_has_its_parts() {
    let [ours, theirs] = [
        advance::<Composed<Verlet, Aba1064>, f64, _>(&Relativistic, [&[0.5], &[0.4]], [0.0, 0.3], &[]),
        advance::<Composed<Verlet, Aba1064>, f64, _>(&Together, [&[0.5], &[0.4]], [0.0, 0.3], &[]),
    ];
    assert_eq!(ours, theirs);
    let state = State::new([0.5], [0.4]);
    assert_eq!(Relativistic.energy(&state), Together.energy(&state));
}

/// Other schemes are those of the sum.
#[test]
fn loops_are_what_they_would_be_written_out() {
    let start: [&[f64]; 2] = [&[0.1, 0.3, -0.2, 0.4, 0.0, 0.2], &[0.2, -0.1, 0.3, 0.1, -0.4, 0.0]];
    let (a, b) = (Chain, ChainInLoops::<6>);
    type Aba = Composed<Verlet, Aba864>;
    // Maps of 12 numbers below 1, in 15 stages.
    assert!(step_apart::<Aba, _, _>((&a, &b), start, [0.0, 0.5]) < 1e-14);
    assert!(step_apart::<Verlet, _, _>((&a, &b), start, [0.0, 0.5]) < 1e-14);
    let path = b.simulate::<Aba>(0.2).start(state(start[0], start[1])).steps(20).run().unwrap();
    assert!(path.euler_lagrange_residual(&b).unwrap() < 1e-14);
}

#[test]
fn steps_are_symplectic_symmetric_and_variational() {
    check_symplectic_and_symmetric::<Composed<Verlet, Aba864>, _>(&Rotating, 0.4);
    check_gradient::<Composed<Verlet, Aba864>, _>(&Rotating);
}

#[test]
fn parameters_of_linear_maps_are_checked() {
    assert!(Oscillators { epsilon: f64::NAN }.stepper::<Composed<Verlet, Aba864>>(0.1).is_err());
    assert_eq!(<Oscillators as Discretized<Composed<Verlet, Aba864>>>::PLAN.order, 4);
    // Its sum does not split: its tables take the flows of the parts all the same.
    let rotating = <Rotating as Discretized<Composed<Verlet, Aba864>>>::EQUATIONS;
    assert!(rotating.contains("flow of H_A") && !rotating.contains("by steps of DeltaMinus"), "{rotating}");
    let text = <Oscillators as Discretized<Composed<Verlet, Aba864>>>::EQUATIONS;
    assert!(text.contains("  flow of H_A over 0.0711334264982231 h\n  flow of H_B over"), "{text}");
}
