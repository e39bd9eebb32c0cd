//! Gradients of functions of the end of a run, in one pass backwards.

use fixtures::are_refused;
use fixtures::small::{DoubleWell, Kepler, Pendulum};
use wzvi::error::Error;
use wzvi::nalgebra::DVector;
use wzvi::prelude::*;
use wzvi::state::Vector;
use wzvi::system::Gradient;

/// A chain of any size with noise at all sites.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64], t| {
        p.iter().map(|p| 0.5 * p * p).sum::<f64>() + q.windows(2).map(|w| 0.5 * (w[1] - w[0]).powi(2) + 0.25 * (w[1] - w[0]).powi(4)).sum::<f64>()
            + t.sin() * q[0]
    },
    noise = |q: &[f64], _| 0.3 * q.iter().map(|q| q.sin()).sum::<f64>(),
    embedding = [DeltaPlus, DeltaMinus, Midpoint, Verlet, Gauss<3>],
)]
struct Chain;

/// A force beside the drift, driven by noise.
#[hamiltonian(drift = |q, p| 0.5 * p * p + q * q, noise_force = |q, p| -0.1 * p * q, embedding = Midpoint)]
struct Pushed;

#[hamiltonian(drift = |q, p| 0.5 * p * p + q * q, force = |q, p| -0.1 * p * q, embedding = Midpoint)]
struct Forced;

#[hamiltonian(drift = |q, p| 0.5 * p * p + q * q, friction = 0.1, embedding = Midpoint)]
struct Damped;

struct Trapezoidal;

/// A mass that depends on the place, and a noise with a counter-term.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p * (1.0 + 0.1 * q * q) + q.powi(4),
    noise = [|q, p| 0.2 * q * p],
    embedding = [
        Corrected<Lambda<1, 3>>, Corrected<Lambda<2, 3>>, Uncorrected<Mixed<DeltaPlus, Lambda<1, 3>>>,
        Uncorrected<Mixed<DeltaMinus, Lambda<2, 3>>>, Trapezoidal = [(0, 1/2), (1, 1/2)],
    ],
)]
struct Metric;

#[hamiltonian(drift = |q, p| 0.5 * p * p - 0.5 * q * q, embedding = Verlet)]
struct Saddle;

fn numbers<V: Vector>(Gradient { q, p }: &Gradient<V>) -> Vec<f64> {
    [q.components(), p.components()].concat()
}

/// The gradient of `q·q/2 + Σ p` at the end is the transposed matrix of derivatives times that at the end.
fn check<H, E, T>(system: &H, start: &State<H::Vector>, h: f64)
where
    H: Discretized<E> + Discretized<T>,
{
    let run = || system.simulate::<E>(h).start(start.clone()).noise(Wiener::seed(4)).steps(60);
    let gradient = |end: &State<H::Vector>| {
        let mut gradient = Gradient { q: end.q.clone(), p: end.p.clone() };
        gradient.p.components_mut().fill(1.0);
        gradient
    };
    let (adjoint, tangent) = (run().adjoint::<T>(gradient).unwrap(), run().tangent().unwrap());
    assert_eq!(adjoint.end, tangent.end);
    let at_end = DVector::from_vec(numbers(&gradient(&adjoint.end)));
    let expected = tangent.by_start.transpose() * at_end;
    for (ours, expected) in numbers(&adjoint.by_start).into_iter().zip(&expected) {
        // The matrices are taken at states that differ by the rounding of a step, sixty times, and have norms up to ten.
        assert!((ours - expected).abs() < 1e-12 * expected.abs().max(10.0), "{ours} {expected}");
    }
}

#[test]
fn gradients_are_the_transposed_matrix_of_derivatives() {
    let of_chain = |i: usize| 0.4 * (1.7 * i as f64).sin();
    let [q, p] = [0, 9].map(|first| (first..first + 7).map(of_chain).collect::<Vec<f64>>());
    let start = State { t: 0.3, ..State::new(q, p) };
    check::<_, Midpoint, Midpoint>(&Chain, &start, 0.05);
    check::<_, Verlet, Verlet>(&Chain, &start, 0.05);
    check::<_, Gauss<3>, Gauss<3>>(&Chain, &start, 0.1);
    check::<_, DeltaPlus, DeltaMinus>(&Chain, &start, 0.05);
    check::<_, DeltaMinus, DeltaPlus>(&Chain, &start, 0.05);
    check::<_, Composed<Verlet, KahanLi8>, Composed<Verlet, KahanLi8>>(&Chain, &start, 0.1);
    check::<_, Midpoint, Midpoint>(&DoubleWell { sigma: 0.4 }, &State::new([0.9], [0.1]), 0.02);
    check::<_, Gauss<8>, Gauss<8>>(&Kepler, &State::new([0.6, 0.1], [-0.2, 1.4]), 0.05);
}

#[test]
fn what_has_no_adjoint_is_refused() {
    let gradient = |end: &State<wzvi::nalgebra::SVector<f64, 1>>| Gradient { q: end.q, p: end.p };
    let start = State::new([0.4], [0.7]);
    let pushed = Pushed.simulate::<Midpoint>(0.1).start(start).noise(Wiener::seed(1)).steps(5);
    let forced = Forced.simulate::<Midpoint>(0.1).start(start).steps(5);
    let damped = Damped.simulate::<Midpoint>(0.1).start(start).steps(5);
    are_refused(pushed.adjoint::<Midpoint>(gradient), "symplectic");
    are_refused(forced.adjoint::<Midpoint>(gradient), "symplectic");
    are_refused(damped.adjoint::<Midpoint>(gradient), "symplectic");
    let [q, p] = [vec![0.4, -0.2], vec![0.1, 0.3]];
    let run = Chain.simulate::<DeltaPlus>(0.1).start(State::new(q, p)).noise(Wiener::seed(1)).steps(5);
    are_refused(
        run.adjoint::<DeltaPlus>(|end| Gradient { q: end.q.clone(), p: end.p.clone() }),
        "`adjoint::<DeltaPlus>` of a run by `DeltaPlus`",
    );
}

/// At rest every scheme leads back, but with another derivative.
#[test]
fn the_adjoint_of_a_scheme_does_not_depend_on_the_state() {
    fn refused<E, T>()
    where
        Pendulum: Discretized<E> + Discretized<T, Vector = wzvi::nalgebra::SVector<f64, 1>>,
    {
        let run = Pendulum.simulate::<E>(0.1).start(State::new([0.0], [0.0])).steps(9);
        are_refused(run.adjoint::<T>(|end| Gradient { q: end.q, p: end.p }), "backwards does not undo");
    }
    refused::<DeltaPlus, Midpoint>();
    refused::<DeltaPlus, DeltaPlus>();
    refused::<Midpoint, DeltaMinus>();
    refused::<Lambda<1, 4>, Lambda<1, 4>>();
    refused::<Gauss<2>, Gauss<3>>();
    refused::<Verlet, Midpoint>();
    refused::<Verlet, Composed<Verlet, Yoshida4>>();
    refused::<Composed<Verlet, Suzuki4>, Composed<Verlet, Yoshida4>>();
    let rest = State::new([0.0], [0.0]);
    check::<_, DeltaPlus, DeltaMinus>(&Pendulum, &rest, 0.1);
    check::<_, Verlet, Verlet>(&Pendulum, &rest, 0.1);
}

/// Counter-terms of a point and of its mirror image have opposite signs.
#[test]
fn mirrored_points_are_adjoint() {
    let start = State::new([0.4], [0.7]);
    check::<_, Corrected<Lambda<1, 3>>, Corrected<Lambda<2, 3>>>(&Metric, &start, 0.02);
    check::<_, Uncorrected<Mixed<DeltaPlus, Lambda<1, 3>>>, Uncorrected<Mixed<DeltaMinus, Lambda<2, 3>>>>(
        &Metric, &start, 0.02,
    );
    check::<_, Trapezoidal, Trapezoidal>(&Metric, &start, 0.02);
    let run = Metric.simulate::<Corrected<Lambda<1, 3>>>(0.1).start(start).noise(Wiener::seed(1)).steps(5);
    let gradient = |end: &State<wzvi::nalgebra::SVector<f64, 1>>| Gradient { q: end.q, p: end.p };
    are_refused(run.adjoint::<Corrected<Lambda<1, 3>>>(gradient), "`Lambda<D - N, D>`");
}

/// A gradient beyond the range of numbers says so.
#[test]
fn gradients_out_of_range_are_named() {
    let run = Saddle.simulate::<Verlet>(0.1).start(State::new([0.0], [0.0])).until(800.0);
    let error = run.adjoint::<Verlet>(|_| Gradient { q: [1.0].into(), p: [0.0].into() }).unwrap_err();
    let Error::Derivative(error) = error else { panic!("{error}") };
    // Verlet steps of 0.1 grow by e^(0.1 + 0.1³/24).
    assert!((error.ln_size - 800.0).abs() < 1.5 && error.by == "the state", "{error}");
}
