//! Derivatives of the end of a run by its start, by parameters and by the step size.

use fixtures::are_refused;
use fixtures::small::{DoubleWell, Kepler, Kubo};
use fixtures::steps::form_apart;
use fixtures::stiff::another_solution_is_named_or_there_is_none;
use wzvi::error::Error;
use wzvi::nalgebra::{self, DMatrix};
use wzvi::prelude::*;
use wzvi::system::Gradient;

use crate::constants::check_schemes;

/// A linear chain of any size.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        p.iter().map(|p| 0.5 * p * p).sum::<f64>() + q.windows(2).map(|w| 0.5 * (w[1] - w[0]).powi(2)).sum::<f64>()
    },
    embedding = [Midpoint, Verlet, Gauss<3>],
)]
#[derive(Clone, Debug)]
struct Chain;

/// Parameters in both energies, beside the time, and in a comparison.
#[hamiltonian(
    drift = |q, p, t| 0.5 * p * p / m - k * q.cos() + f * (w * t).cos() * q + if k < m { 0.1 * k * q * q } else { 0.2 * q * q },
    embedding = [DeltaPlus, Midpoint, Verlet, Gauss<3>],
)]
struct Driven {
    m: f64,
    k: f64,
    f: f64,
    w: f64,
}

/// Mid-point steps of it have a matrix of four equations that is factored once.
#[hamiltonian(
    drift = |[x, y], [u, v]| 0.5 * (u * u + v * v) + 0.5 * (a * x * x + b * y * y) + c * x * y + c * x * v,
    noise = |[_, y], _| -s * y,
    embedding = [Midpoint, DeltaMinus],
)]
struct Linear {
    a: f64,
    b: f64,
    c: f64,
    s: f64,
}

/// A Hamiltonian times a number.
#[hamiltonian(drift = |q, p| scale * (0.5 * p * p * (1.0 + 0.1 * q * q) + q.powi(4)), embedding = [Midpoint, Gauss<4>])]
struct Scaled {
    scale: f64,
}

/// The largest entry of `Mᵀ J M - J`.
fn defect(matrix: &DMatrix<f64>) -> f64 {
    let columns: Vec<Vec<f64>> =
        matrix.column_iter().map(|column| column.iter().copied().collect()).collect();
    form_apart(&columns, 1.0)
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

/// By four parameters and the step size, of which the time of each step is a multiple.
#[test]
fn parameters_and_the_step_size_have_columns() {
    let driven = |[k, f, w, m]: [f64; 4]| Driven { m, k, f, w };
    let start = State { t: 0.3, ..State::new([0.4], [0.7]) };
    check_schemes!(driven, ["k", "f", "w", "m"], [0.8, 0.5, 2.0, 1.3], &start, None, [
        DeltaPlus, Midpoint, Verlet, Gauss<3>, Composed<Verlet, KahanLi8>, Composed<Midpoint, Yoshida4>
    ]);
}

/// Factored matrices have derivatives, too, and so have the effects of noise.
#[test]
fn matrices_and_noises_have_derivatives_by_parameters() {
    let linear = |[a, b, c, s]: [f64; 4]| Linear { a, b, c, s };
    let start = State::new([0.4, -0.1], [0.2, 0.3]);
    check_schemes!(
        linear,
        ["a", "b", "c", "s"],
        [1.4, 0.9, 0.6, 0.5],
        &start,
        Some(11),
        [Midpoint, DeltaMinus]
    );
}

/// A step of `λ H` over `h` is one of `H` over `λ h`: derivatives agree to rounding.
#[test]
fn scaling_the_energy_scales_the_time() {
    fn check<E>()
    where
        Scaled: Discretized<E, Vector = nalgebra::SVector<f64, 1>>,
    {
        let scaled = Scaled { scale: 1.0 };
        let run = scaled.simulate::<E>(0.03).start(State::new([0.8], [0.3])).steps(100);
        let tangent = run.tangent_by(&["scale"]).unwrap();
        let by_step_size = tangent.by_step_size.unwrap();
        for row in 0..2 {
            let (ours, other) = (tangent.by_parameters[(row, 0)], 0.03 * by_step_size[row]);
            // A hundred steps that each have a few roundings.
            assert!((ours - other).abs() < 1e-12 * other.abs().max(1.0), "{ours} {other}");
        }
    }
    check::<Midpoint>();
    check::<Gauss<4>>();
    check::<Composed<Midpoint, Yoshida4>>();
}

mod outside {
    pub const G: f64 = 0.77;
}

#[hamiltonian_fn]
fn quartic(x: f64) -> f64 {
    crate::tangent::outside::G * x.powi(4)
}

/// A field and a constant with one name, and two spellings of one entry.
#[hamiltonian(drift = |q, p| 0.5 * p * p + quartic(q) + self.G * q * q + v[0] * q + v[n - 1] * q.cos(), embedding = Midpoint)]
#[allow(non_snake_case, reason = "the name of a constant")]
struct Twins {
    G: f64,
    v: [f64; 2],
    n: usize,
}

#[test]
fn names_of_two_numbers_are_refused() {
    let twins = Twins { G: 0.4, v: [0.1, 0.2], n: 2 };
    for name in ["G", "v[0]", "v[n - 1]"] {
        let run = twins.simulate::<Midpoint>(0.1).start(State::new([0.4], [0.7])).steps(10);
        are_refused(run.tangent_by(&[name]), "may be the same");
    }
}

#[test]
fn constants_without_derivatives_are_refused() {
    let driven = Driven { m: 1.0, k: 1.0, f: 1.0, w: 1.0 };
    let run = || driven.simulate::<Midpoint>(0.1).start(State::new([0.4], [0.7])).steps(10);
    are_refused(run().tangent_by(&["m", "count"]), "`count`");
    are_refused(run().tangent_by(&["m", "count"]), "`m`, `k`, `f`, `w`");
    // Nothing named: the step size alone.
    let tangent = run().tangent_by(&[]).unwrap();
    assert!(tangent.by_parameters.ncols() == 0 && tangent.by_step_size.is_some());
    assert!(run().tangent().unwrap().by_step_size.is_none());
}

/// A part of what `tests/laws` runs.
#[test]
fn another_solution_is_named() {
    assert!(another_solution_is_named_or_there_is_none(500) > 1);
}

/// Integers, read as real numbers in a sum, as an exponent, and in loops.
#[hamiltonian(drift = |q, p| 0.5 * p * p + k * n as f64 * q * q + 0.1 * (q * q + 1.0).powi(m), embedding = Midpoint)]
struct Counted {
    k: f64,
    n: u32,
    m: i32,
}

#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| (0..q.len()).map(|i| 0.5 * p[i] * p[i] + k * n as f64 * q[i] * q[i]).sum::<f64>(),
    embedding = Midpoint,
)]
struct CountedSites {
    k: f64,
    n: usize,
}

#[test]
fn integers_have_no_derivatives() {
    let counted = Counted { k: 1.5, n: 2, m: 3 };
    let run = || counted.simulate::<Midpoint>(0.1).start(State::new([0.4], [0.7])).steps(10);
    are_refused(run().tangent_by(&["n"]), "`n`, an integer");
    are_refused(run().tangent_by(&["k", "m"]), "`m`, an integer");
    are_refused(run().tangent_by(&["x"]), "read are `k`");
    assert!(run().tangent_by(&["k"]).is_ok());
    let sites = CountedSites { k: 1.5, n: 2 };
    let run = || sites.simulate::<Midpoint>(0.1).start(State::new(vec![0.4; 9], vec![0.7; 9])).steps(2);
    are_refused(run().tangent_by(&["n"]), "`n`, an integer");
    assert!(run().tangent_by(&["k"]).is_ok());
}

#[hamiltonian(drift = |q, p| 0.5 * p * p + q * q, friction = 1.0, embedding = [Midpoint, Verlet, Gauss<2>])]
struct Damped;

#[hamiltonian(drift = |q, p| 0.5 * p * p - 0.5 * q * q, embedding = [Midpoint, Verlet])]
struct Saddle;

/// The area of phase space shrinks by `e^{-t}`, and each column by its root times a bounded factor.
#[test]
fn derivatives_out_of_range_are_named_with_their_size() {
    fn damped<E>()
    where
        Damped: Discretized<E, Vector = nalgebra::SVector<f64, 1>>,
    {
        // At rest, and where the state itself becomes subnormal.
        let run = |q, t| Damped.simulate::<E>(0.1).start(State::new([q], [0.0])).until(t).tangent();
        for q in [0.0, 0.3] {
            let error = run(q, 1480.0).unwrap_err();
            let Error::Derivative(error) = error else { panic!("{q}: {error}") };
            assert!((error.ln_size + 740.0).abs() < 3.0, "{error}");
        }
        let Err(Error::Derivative(error)) = run(0.0, 1600.0) else { panic!("it has a size") };
        assert!((error.ln_size + 800.0).abs() < 3.0 && error.by == "`q` of the start", "{error}");
        assert_eq!((error.step, error.t), (16_000, 1600.0));
        // Scaled on the way, and held at the end: the determinant is that of friction alone.
        let held = run(0.3, 700.0).unwrap().by_start;
        let scale = held.amax();
        let logarithm = (held / scale).determinant().ln() + 2.0 * scale.ln();
        // Seven thousand matrices, each with a few roundings.
        assert!((logarithm + 700.0).abs() < 1e-9, "{logarithm}");
    }
    damped::<Midpoint>();
    damped::<Verlet>();
    damped::<Gauss<2>>();
    let run = |t| Saddle.simulate::<Verlet>(0.1).start(State::new([0.0], [0.0])).until(t).tangent();
    let Err(Error::Derivative(error)) = run(800.0) else { panic!("it has a size") };
    assert!((error.ln_size - 800.0).abs() < 1.5, "{error}");
    // A power of the matrix of one step, whose larger eigenvalue is e^x with cosh x = 1 + h²/2.
    let (held, rate) = (run(600.0).unwrap().by_start[(0, 0)], 1.005_f64.acosh());
    assert!((held.ln() - (6000.0 * rate + 0.5_f64.ln())).abs() < 1e-9, "{held:e}");
}

/// Sites with a quartic well, in a square lattice of `n * n`.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| p.iter().map(|p| 0.5 * p * p).sum::<f64>()
        + q.iter().map(|q| 0.5 * q * q + 0.25 * q.powi(4)).sum::<f64>()
        + (0..self.n * self.n).map(|i| {
            0.5 * self.k * (q[(i + self.n) % (self.n * self.n)] - q[i]).powi(2)
                + 0.5 * self.k * (q[(i + 1) % (self.n * self.n)] - q[i]).powi(2)
        }).sum::<f64>(),
    embedding = [Midpoint, Gauss<2>, Gauss<4>],
)]
struct Lattice {
    n: usize,
    k: f64,
}

fn lattice(n: usize) -> State<nalgebra::DVector<f64>> {
    let list = |of: fn(f64) -> f64| (0..n * n).map(|i| 0.7 * of(i as f64)).collect::<Vec<_>>();
    State::new(list(f64::sin), list(f64::cos))
}

/// All columns of sites that are not linear, by sweeps, by a band and by a whole matrix: symplectic, and the slopes of the end.
#[test]
fn one_factorisation_serves_all_columns() {
    fn check<E>(n: usize, k: f64, h: f64)
    where
        Lattice: Discretized<E, Vector = nalgebra::DVector<f64>>,
    {
        let system = Lattice { n, k };
        let run = |start| system.simulate::<E>(h).start(start).steps(8);
        let tangent = run(lattice(n)).tangent().unwrap();
        // Eight matrices, each with the rounding of a solution of condition `k h²` at most, here 100.
        assert!(defect(&tangent.by_start) < 1e-12, "{}", defect(&tangent.by_start));
        for column in [0, n * n + 1] {
            let end = |distance: f64| {
                let mut start = lattice(n);
                match column < n * n {
                    true => start.q[column] += distance,
                    false => start.p[column - n * n] += distance,
                }
                let path = run(start).run().unwrap();
                path.last().q.iter().chain(path.last().p.iter()).copied().collect::<Vec<f64>>()
            };
            for (row, (plus, minus)) in end(1e-5).into_iter().zip(end(-1e-5)).enumerate() {
                let (ours, slope) = (tangent.by_start[(row, column)], (plus - minus) / 2e-5);
                // The square of the distance times third derivatives, and a rounding over it.
                assert!((ours - slope).abs() < 1e-7, "{row} {column}: {ours} {slope}");
            }
        }
    }
    check::<Midpoint>(3, 1.0, 0.1);
    check::<Midpoint>(3, 100.0, 1.0);
    check::<Gauss<2>>(3, 1.0, 0.1);
    check::<Gauss<2>>(3, 100.0, 1.0);
    check::<Gauss<4>>(2, 1.0, 0.2);
    check::<Gauss<4>>(2, 100.0, 1.0);
}

/// Neither energy of it is alone in its variables; it reads the time.
#[hamiltonian(
    drift = |[x, y], [u, v], t| 0.5 * (u * u + v * v) * (1.0 + 0.3 * x * x) + 0.2 * u * y + 0.5 * (x * x + 2.0 * y * y)
        + x * x * y + 0.3 * x * t.cos(),
    noise = [|[x, y], [u, _]| 0.2 * x * y + 0.1 * u],
    embedding = [Midpoint, Gauss<1>, Gauss<2>, Gauss<3>],
)]
struct Mixed;

#[hamiltonian(
    drift = |[x, y], [u, v], t| 0.5 * (u * u + 2.0 * v * v - u * v) + 0.5 * (x * x + 2.0 * y * y) + x * x * y + 0.3 * x * t.cos(),
    noise = [|[x, y], [u, _]| 0.2 * x * y + 0.1 * u],
    friction = 0.4,
    embedding = [Midpoint, Gauss<1>, Gauss<2>, Gauss<3>],
)]
struct Slowed;

#[hamiltonian(
    drift = |[x, y], [u, v]| 0.5 * (u * u + 2.0 * v * v - u * v) + 0.5 * (x * x + y * y) + x * x * y,
    embedding = [Midpoint, Gauss<1>, Gauss<2>, Gauss<8>],
)]
struct Heavy;

/// The step of one stage is the mid-point step, and its derivative by formulas of its own is that of the
/// generated equations. With more stages they are symplectic, with friction up to its factor, and the slopes
/// of the end.
#[test]
fn formulas_for_derivatives_of_stages_are_those_of_the_step() {
    fn check<H, E>(system: &H, rate: f64, h: f64) -> DMatrix<f64>
    where
        H: Discretized<E, Vector = nalgebra::SVector<f64, 2>>,
    {
        let start = [0.3, -0.2, 0.4, 0.1];
        let run = |[x, y, u, v]: [f64; 4]| {
            system.simulate::<E>(h).start(State::new([x, y], [u, v])).noise(StepNormals::seed(1)).until(2.45)
        };
        let tangent = run(start).tangent().unwrap().by_start;
        // Each step is conformal; `det = e^{-2 γ t}`.
        let columns: Vec<Vec<f64>> =
            tangent.column_iter().map(|column| column.iter().copied().collect()).collect();
        let kept = (-rate * 2.45).exp();
        assert!(form_apart(&columns, kept) < 1e-13, "{}", form_apart(&columns, kept));
        for column in 0..4 {
            let end = |distance: f64| {
                let mut start = start;
                start[column] += distance;
                let end = *run(start).run().unwrap().last();
                [end.q[0], end.q[1], end.p[0], end.p[1]]
            };
            for (row, (plus, minus)) in end(1e-5).into_iter().zip(end(-1e-5)).enumerate() {
                let (ours, slope) = (tangent[(row, column)], (plus - minus) / 2e-5);
                // The square of the distance times third derivatives, and a rounding over it.
                assert!((ours - slope).abs() < 1e-8, "{row} {column}: {ours} {slope}");
            }
        }
        tangent
    }
    // Roundings of 25 steps.
    let one = check::<_, Gauss<1>>(&Mixed, 0.0, 0.1) - check::<_, Midpoint>(&Mixed, 0.0, 0.1);
    assert!(one.abs().max() < 1e-13, "{one}");
    let one = check::<_, Gauss<1>>(&Slowed, 0.4, 0.1) - check::<_, Midpoint>(&Slowed, 0.4, 0.1);
    assert!(one.abs().max() < 1e-13, "{one}");
    check::<_, Gauss<2>>(&Mixed, 0.0, 0.1);
    check::<_, Gauss<3>>(&Mixed, 0.0, 0.2);
    check::<_, Gauss<2>>(&Slowed, 0.4, 0.1);
    check::<_, Gauss<3>>(&Slowed, 0.4, 0.2);
    fn heavy<E>(h: f64) -> DMatrix<f64>
    where
        Heavy: Discretized<E, Vector = nalgebra::SVector<f64, 2>>,
    {
        let run = Heavy.simulate::<E>(h).start(State::new([0.3, 0.1], [-0.2, 0.3]));
        let tangent = run.until(6.0).tangent().unwrap().by_start;
        assert!(defect(&tangent) < 1e-13, "{}", defect(&tangent));
        tangent
    }
    assert!((heavy::<Gauss<1>>(0.1) - heavy::<Midpoint>(0.1)).abs().max() < 1e-13);
    // Both are the derivative of the flow to 11 digits; in the longer steps the matrix is not dominated by
    // its diagonal.
    let fine = heavy::<Gauss<8>>(0.25);
    assert!((heavy::<Gauss<8>>(0.5) - &fine).abs().max() < 1e-11);
    assert!((heavy::<Gauss<8>>(2.0) - fine).abs().max() < 1e-4);
}

/// A lattice whose matrix is not factored: the gradient of `q_0²` of the end along one direction of the start.
#[test]
fn columns_of_large_lattices_need_no_matrix() {
    let system = Lattice { n: 48, k: 4.0 };
    let run = |start| system.simulate::<Midpoint>(0.8).start(start).steps(1);
    let gradient = |end: &State<nalgebra::DVector<f64>>| {
        let mut gradient = Gradient { q: 0.0 * &end.q, p: 0.0 * &end.p };
        gradient.q[0] = 2.0 * end.q[0];
        gradient
    };
    let adjoint = run(lattice(48)).adjoint::<Midpoint>(gradient).unwrap();
    let along = |distance: f64| {
        let mut start = lattice(48);
        start.q.iter_mut().enumerate().for_each(|(i, q)| *q += distance * (0.3 * i as f64).sin());
        run(start).run().unwrap().last().q[0].powi(2)
    };
    let ours: f64 =
        adjoint.by_start.q.iter().enumerate().map(|(i, slope)| slope * (0.3 * i as f64).sin()).sum();
    let slope = (along(1e-5) - along(-1e-5)) / 2e-5;
    // As above.
    assert!((ours - slope).abs() < 1e-7 * slope.abs().max(1.0), "{ours} {slope}");
}

#[hamiltonian(drift = |q, p| 0.5 * p * p + q.abs().powf(1.5), embedding = [Midpoint, Gauss<2>, Verlet])]
struct Cusp;

/// At rest where the second derivative of the potential energy is infinite, the end is finite, and its derivative is not.
#[test]
fn infinite_second_derivatives_are_named() {
    fn check<E>()
    where
        Cusp: Discretized<E, Vector = nalgebra::SVector<f64, 1>>,
    {
        let run = |q: f64, p: f64| Cusp.simulate::<E>(0.1).start(State::new([q], [p])).steps(20).tangent();
        let Err(Error::Derivative(error)) = run(0.0, 0.0) else { panic!("it has a derivative") };
        assert_eq!((error.step, error.t, error.ln_size), (0, 0.0, f64::INFINITY), "{error}");
        assert_eq!(error.by, "`q` of the start");
        // Through it at speed, and never at it.
        let tangent = run(-0.5321, 1.0).unwrap();
        assert!((tangent.by_start.determinant() - 1.0).abs() < 1e-12, "{}", tangent.by_start);
    }
    check::<Midpoint>();
    check::<Gauss<2>>();
    check::<Verlet>();
}
