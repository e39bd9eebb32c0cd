//! Derivatives of the end of a run by its start.

use fixtures::small::{DoubleWell, Kepler, Kubo};
use wzvi::error::{ConfigError, Error, StepError, StepFailure};
use wzvi::nalgebra::{self, DMatrix};
use wzvi::prelude::*;

/// A linear chain of any size.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        p.iter().map(|p| 0.5 * p * p).sum::<f64>() + q.windows(2).map(|w| 0.5 * (w[1] - w[0]).powi(2)).sum::<f64>()
    },
    embedding = [Midpoint, Verlet, Gauss<3>],
)]
#[derive(Clone, Debug)]
struct Chain;

/// A well of arithmetic only.
#[hamiltonian(drift = |q, p| 0.5 * p * p + 2.0 * q.powi(4) - 3.0 * q * q, embedding = [Midpoint, Gauss<2>])]
struct Well;

/// The largest entry of `Mᵀ J M - J`.
fn defect(matrix: &DMatrix<f64>) -> f64 {
    let d = matrix.nrows() / 2;
    let form = DMatrix::from_fn(2 * d, 2 * d, |row, column| match (row + d == column, column + d == row) {
        (true, _) => 1.0,
        (_, true) => -1.0,
        _ => 0.0,
    });
    (matrix.transpose() * &form * matrix - form).amax()
}

fn check<E>(h: f64)
where
    Kepler: Discretized<E, Vector = nalgebra::SVector<f64, 2>>,
{
    let start = [0.6, 0.1, -0.2, 1.4];
    let run =
        |[x, y, px, py]: [f64; 4]| Kepler.simulate::<E>(h).start(State::new([x, y], [px, py])).until(3.0);
    let tangent = run(start).tangent().unwrap();
    let end = *run(start).run().unwrap().last();
    // Compensated sums of the run and plain ones of the tangent differ by the rounding of a few hundred steps.
    assert!((end.q - tangent.end.q).norm() + (end.p - tangent.end.p).norm() < 1e-12);
    // Roundings of products of some 300 matrices of norm ten.
    assert!(defect(&tangent.by_start) < 1e-11, "{}", defect(&tangent.by_start));
    for (column, _) in start.iter().enumerate() {
        let (mut plus, mut minus) = (start, start);
        (plus[column], minus[column]) = (plus[column] + 1e-5, minus[column] - 1e-5);
        let [plus, minus] = [plus, minus].map(|start| *run(start).run().unwrap().last());
        let ends = |state: State<nalgebra::SVector<f64, 2>>| [state.q[0], state.q[1], state.p[0], state.p[1]];
        for (row, (plus, minus)) in ends(plus).into_iter().zip(ends(minus)).enumerate() {
            let (ours, difference) = (tangent.by_start[(row, column)], (plus - minus) / 2e-5);
            // The square of the difference times third derivatives, below a thousand.
            assert!((ours - difference).abs() < 1e-6 * ours.abs().max(1.0), "{ours} {difference}");
        }
    }
}

#[test]
fn orbits_have_symplectic_derivatives() {
    check::<Midpoint>(0.01);
    check::<Verlet>(0.01);
    check::<Gauss<8>>(0.05);
    check::<Composed<Verlet, KahanLi8>>(0.02);
}

/// The end of a linear system is its derivative times the start.
#[test]
fn linear_systems_are_their_derivatives() {
    let kubo = Kubo { a: 0.8, sigma: 0.6 };
    let run =
        || kubo.simulate::<Midpoint>(0.05).start(State::new([0.3], [0.8])).noise(Wiener::seed(3)).until(4.0);
    let tangent = run().tangent().unwrap();
    let end = &tangent.by_start * nalgebra::DVector::from_vec(vec![0.3, 0.8]);
    assert!((end[0] - tangent.end.q[0]).abs() + (end[1] - tangent.end.p[0]).abs() < 1e-13);
    assert!((tangent.end.q[0] - run().run().unwrap().last().q[0]).abs() < 1e-13);

    fn chain<E>()
    where
        Chain: Discretized<E, Vector = nalgebra::DVector<f64>>,
    {
        let start = vec![0.3, -0.2, 0.5, 0.1, 0.0, 0.7, -0.4, 0.2, 0.1, 0.6];
        let state = State::new(start[..5].to_vec(), start[5..].to_vec());
        let tangent = Chain.simulate::<E>(0.1).start(state).until(5.0).tangent().unwrap();
        let end = &tangent.by_start * nalgebra::DVector::from_vec(start);
        let of_run = tangent.end.q.iter().chain(tangent.end.p.iter());
        assert!(end.iter().zip(of_run).all(|(a, b)| (a - b).abs() < 1e-12));
        assert!(defect(&tangent.by_start) < 1e-12);
    }
    chain::<Midpoint>();
    chain::<Verlet>();
    chain::<Gauss<3>>();
}

#[test]
fn noise_is_taken_as_given() {
    let well = DoubleWell { sigma: 0.4 };
    let run = |q: f64| {
        well.simulate::<Midpoint>(0.02).start(State::new([q], [0.1])).noise(Wiener::seed(9)).until(2.0)
    };
    let tangent = run(0.9).tangent().unwrap();
    let difference =
        (run(0.9 + 1e-6).run().unwrap().last().q[0] - run(0.9 - 1e-6).run().unwrap().last().q[0]) / 2e-6;
    assert!((tangent.by_start[(0, 0)] - difference).abs() < 1e-7, "{difference}");
    assert!((tangent.by_start.determinant() - 1.0).abs() < 1e-12);
}

#[test]
fn what_it_has_no_use_for_is_refused() {
    let run = || Kepler.simulate::<Midpoint>(0.01).start(State::new([0.6, 0.0], [0.0, 1.4])).until(0.995);
    let refused = [
        run().observe("x", |state| state.q[0]).tangent().unwrap_err(),
        run().record_every(5).tangent().unwrap_err(),
        run().exactly().tangent().unwrap_err(),
    ];
    for error in refused {
        assert!(
            matches!(&error, Error::Config(ConfigError::Setting(what)) if what.contains("no use")),
            "{error}"
        );
    }
}

/// Steps that are long for the force are found by following them. Dual numbers solve them anew: they end where the step does, or the error says that they
/// do not, and by how much.
#[test]
fn another_solution_is_named() {
    fn check<E>() -> usize
    where
        Well: Discretized<E, Vector = nalgebra::SVector<f64, 1>>,
    {
        let mut others = 0;
        for case in 0..4000 {
            let at = |k: i32| f64::from(case * k % 4001) / 4001.0;
            let (h, q, p) = (0.3 + 1.7 * at(7), 4.0 * at(131) - 2.0, 6.0 * at(1009) - 3.0);
            let run = || Well.simulate::<E>(h).start(State::new([q], [p])).steps(1);
            let Ok(path) = run().run() else { continue };
            let end = path.last();
            match run().tangent() {
                Ok(tangent) => {
                    // What solves the same equations differs by their rounding.
                    assert!((tangent.end.q[0] - end.q[0]).abs() < 1e-9, "{case}");
                }
                Err(Error::Step(StepError {
                    cause: StepFailure::OtherSolution { apart }, h: of, ..
                })) => {
                    assert!(apart > 1e-6 && of == h, "{case}: {apart}");
                    others += 1;
                }
                // With care, too, Newton's method may fail where following does not.
                Err(Error::Step(StepError { cause, .. })) => assert!(
                    !matches!(cause, StepFailure::NotConverged { iterations: 0, .. }),
                    "{case}: {cause}"
                ),
                Err(error) => panic!("{error}"),
            }
        }
        others
    }
    let others = [check::<Midpoint>(), check::<Gauss<2>>()];
    println!("{others:?} of 4000");
    assert!(others.iter().sum::<usize>() > 10, "{others:?}");
}
