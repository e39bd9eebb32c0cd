//! Gauss methods: against steps to 36 digits, their orders, and what a step promises.

use fixtures::reference;
use fixtures::small::{Driven, Pendulum, Rotation};
use fixtures::steps::{
    apart, asymmetry, distance, end, lanes_are_steppers, order_of_step, refused, way_back,
};
use wzvi::error::StepFailure;
use wzvi::memory::Iteration;
use wzvi::nalgebra::SVector;
use wzvi::prelude::*;

type Point = SVector<f64, 1>;

#[hamiltonian(
    drift = |q, p, t| 0.5 * p * p + 0.5 * q * q + 0.25 * q.powi(4) - 0.3 * q * (1.3 * t).cos(),
    embedding = [Gauss<2>, Gauss<3>, Gauss<4>, Gauss<6>, Gauss<8>],
)]
struct Duffing;

#[test]
fn steps_are_those_of_the_reference() {
    let file = reference::data("gauss_steps");
    for case in reference::list(&file["cases"]) {
        // Ten roundings per step, of numbers below 2.
        let bound = 5e-15;
        match (reference::text(&case["system"]), case["s"].as_u64().unwrap()) {
            ("pendulum", 2) => reference::follow::<Gauss<2>, _>(&Pendulum, case, bound),
            ("pendulum", 4) => reference::follow::<Gauss<4>, _>(&Pendulum, case, bound),
            ("pendulum", 8) => reference::follow::<Gauss<8>, _>(&Pendulum, case, bound),
            ("duffing_forced", 2) => reference::follow::<Gauss<2>, _>(&Duffing, case, bound),
            ("duffing_forced", 4) => reference::follow::<Gauss<4>, _>(&Duffing, case, bound),
            ("duffing_forced", 8) => reference::follow::<Gauss<8>, _>(&Duffing, case, bound),
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn one_stage_is_the_mid_point_to_the_last_digit() {
    let start = State::new([2.0], [0.0]);
    let gauss = Pendulum.simulate::<Gauss<1>>(0.1).start(start).steps(1000).run();
    let midpoint = Pendulum.simulate::<Midpoint>(0.1).start(start).steps(1000).run();
    let states = |path: &[State<Point>]| path.iter().map(|state| (state.q, state.p)).collect::<Vec<_>>();
    assert_eq!(states(gauss.unwrap().states()), states(midpoint.unwrap().states()));
}

/// `log(error ratio) / log(step ratio)` of runs of `few` and `many` steps against one at rounding.
fn measured_order<E, H>(system: &H, [q, p]: [f64; 2], span: f64, [few, many]: [u32; 2]) -> f64
where
    H: Discretized<E> + Discretized<Gauss<8>>,
{
    let start: [&[f64]; 2] = [&[q], &[p]];
    let fine = end::<Gauss<8>, H>(system, start, span, 60);
    let [coarse, better] = [few, many].map(|steps| distance(&end::<E, H>(system, start, span, steps), &fine));
    (coarse / better).ln() / (f64::from(many) / f64::from(few)).ln()
}

/// On a separable system, one that depends on the time, and one that does both and is not separable. Of orders 12 and 16 few step sizes are left
/// between large ones and rounding.
#[test]
fn orders_are_twice_the_stages() {
    macro_rules! check {
        ($name:ident, $start:expr, $span:expr; $($stages:literal, $steps:expr, $tolerance:literal);+ $(;)?) => {$(
            let order = measured_order::<Gauss<$stages>, _>(&$name, $start, $span, $steps);
            let off = (order - 2.0 * f64::from($stages)).abs();
            assert_eq!(<$name as Discretized<Gauss<$stages>>>::PLAN.order, 2 * $stages);
            assert!(off < $tolerance, "{} {}: {order}", stringify!($name), $stages);
        )+};
    }
    check!(Pendulum, [2.0, 0.0], 6.0;
        2, [16, 32], 0.1; 3, [16, 32], 0.1; 4, [16, 32], 0.1; 6, [6, 12], 0.5; 8, [4, 8], 0.5);
    check!(Duffing, [0.6, 0.4], 5.0;
        2, [16, 32], 0.1; 3, [16, 32], 0.1; 4, [16, 32], 0.1; 6, [4, 16], 0.5; 8, [4, 8], 1.5);
    check!(Driven, [0.6, 0.4], 5.0;
        2, [16, 32], 0.1; 3, [16, 32], 0.1; 4, [16, 32], 0.1; 6, [3, 6], 0.5; 8, [3, 6], 0.5);
}

/// A part of what `tests/laws` runs.
#[test]
fn rounding_does_not_add_up() {
    fixtures::rounding::gauss_methods_do_not_add_rounding_up(4000);
}

/// A first sweep that is not finite is an error at once: Newton's method would begin where it ends.
#[test]
fn stages_that_are_not_finite_are_an_error_at_once() {
    #[hamiltonian(drift = |q, p| 0.5 * p * p - q.sqrt(), embedding = Gauss<4>)]
    struct Wall;
    let mut state = State::new([-1.0], [0.0]);
    let error = Wall.stepper::<Gauss<4>>(0.1).unwrap().step(&mut state, &[]).unwrap_err();
    assert!(matches!(error.cause, wzvi::error::StepFailure::NonFinite), "{error:?}");
}

/// From (2, 0) to T = 100 against the exact elliptic solution.
#[test]
fn a_hundred_time_units_are_right_to_thirteen_digits() {
    let exact = [1.982_325_653_157_030_5, 0.179_640_742_590_940_2];
    macro_rules! check {
        ($($scheme:ty, $steps:literal, $error:literal);+ $(;)?) => {$(
            let path = Pendulum.simulate::<$scheme>(100.0 / f64::from($steps)).start(State::new([2.0], [0.0]));
            let last = *path.steps($steps).record_every(0).run().unwrap().last();
            let error = (last.q[0] - exact[0]).hypot(last.p[0] - exact[1]);
            assert!(error < $error, "{}: {error:e}", stringify!($scheme));
        )+};
    }
    check! {
        Gauss<4>, 600, 5e-10;
        Gauss<8>, 100, 1e-10;
        Gauss<8>, 200, 1.5e-13;
        Gauss<16>, 40, 2e-10;
        Gauss<16>, 60, 1.5e-13;
    }
}

/// A Fermi-Pasta-Ulam chain: the same in straight-line code and in loops.
macro_rules! chain {
    ($name:ident, $($size:tt)*) => {
        #[hamiltonian(
            drift = |q: $($size)*, p: $($size)*| p.iter().map(|p| 0.5 * p * p).sum::<f64>()
                + (0..q.len() - 1).map(|i| 0.5 * (q[i + 1] - q[i]).powi(2) + 0.25 * (q[i + 1] - q[i]).powi(4)).sum::<f64>()
                + 0.5 * q[0] * q[0],
            embedding = [Midpoint, Gauss<1>, Gauss<2>, Gauss<4>, Gauss<8>],
        )]
        struct $name;
    };
}
chain!(Chain, &[f64]);
chain!(Four, [f64; 4]);

/// The same with a coordinate in the kinetic energy, the time, and a noise at each site.
macro_rules! noisy {
    ($name:ident, $($size:tt)*) => {
        #[hamiltonian(
            drift = |q: $($size)*, p: $($size)*, t| (0..q.len()).map(|i| 0.5 * (1.0 + 0.1 * q[i] * q[i]) * p[i] * p[i]
                + 0.25 * q[i].powi(4) + 0.1 * (1.0 + t).ln() * q[i]).sum::<f64>()
                + (0..q.len() - 1).map(|i| 0.5 * (q[i + 1] - q[i]).powi(2)).sum::<f64>(),
            noise = [|q, p, k| 0.2 * q[k] * p[k]; 4],
            embedding = [Gauss<3>],
        )]
        struct $name;
    };
}
noisy!(NoisyLoop, &[f64]);
noisy!(NoisyFour, [f64; 4]);

#[test]
fn loops_and_straight_lines_take_the_same_steps() {
    let start: [&[f64]; 2] = [&[0.3, -0.2, 0.5, 0.1], &[0.0, 0.4, -0.1, 0.2]];
    macro_rules! same {
        ($scheme:ty, $a:expr, $b:expr, $dw:expr) => {
            // Roundings of twenty steps.
            assert!(apart::<$scheme, _, _>((&$a, &$b), start, (0.1, 20), $dw) < 2e-15, stringify!($scheme));
        };
    }
    same!(Gauss<1>, Chain, Four, &[]);
    same!(Gauss<2>, Chain, Four, &[]);
    same!(Gauss<4>, Chain, Four, &[]);
    same!(Gauss<8>, Chain, Four, &[]);
    same!(Gauss<3>, NoisyLoop, NoisyFour, &[0.1, -0.2, 0.05, 0.3]);
}

/// The tangent map of a step is symplectic, and the step of `-h` undoes it.
fn check_symplectic<E, H: Discretized<E>>(system: &H, dw: &[f64], name: &str) {
    for (q, p, t, h) in [(0.6, 0.4, 0.0, 0.3), (-0.2, 0.9, 1.0, 0.5), (0.01, -0.3, 2.0, -0.2)] {
        let start: [&[f64]; 2] = [&[q], &[p]];
        // A hundred roundings of products of a few units.
        assert!(asymmetry::<E, _>(system, start, [t, h], dw, 1.0) < 2e-14, "{name}");
        assert!(way_back::<E, _>(system, start, [t, h], dw) < 4e-15, "{name}");
    }
}

#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.25 * q.powi(4) + 0.3 * q * p * p,
    noise = [|q, p| 0.3 * q * p + 0.1 * q * q, |q, _| 0.2 * q.sin()],
    embedding = [Verlet, Midpoint, Gauss<2>, Gauss<5>],
)]
struct Noisy;

#[test]
fn steps_are_symplectic_and_symmetric() {
    check_symplectic::<Gauss<2>, _>(&Driven, &[], "Gauss<2>");
    check_symplectic::<Gauss<8>, _>(&Driven, &[], "Gauss<8>");
    check_symplectic::<Gauss<3>, _>(&Pendulum, &[], "Gauss<3>, Nyström form");
    check_symplectic::<Gauss<16>, _>(&Pendulum, &[], "Gauss<16>, Nyström form");
    check_symplectic::<Composed<Gauss<2>, KahanLi8>, _>(&Pendulum, &[], "composed");
    let dw = [0.2, -0.3];
    check_symplectic::<Verlet, _>(&Noisy, &dw, "Verlet");
    check_symplectic::<Composed<Midpoint, Suzuki4>, _>(&Noisy, &dw, "Suzuki4");
    check_symplectic::<Composed<Verlet, BlanesMoan4>, _>(&Noisy, &dw, "BlanesMoan4");
    check_symplectic::<Gauss<5>, _>(&Noisy, &dw, "Gauss<5>");
}

/// With frozen increments every scheme approximates the same flow, that of the step Hamiltonian: half of `h` and `ΔW` leave
/// `2^-(order + 1)` of the error.
#[test]
fn all_schemes_approach_the_flow_of_the_step_hamiltonian() {
    fn check<E>()
    where
        Noisy: Discretized<E>,
    {
        let (start, dw): ([&[f64]; 2], _) = ([&[0.4], &[0.3]], [0.11, -0.07]);
        let order = order_of_step::<E, Gauss<5>, _>(&Noisy, start, [0.0, 0.1], &dw);
        assert!((order - f64::from(<Noisy as Discretized<E>>::PLAN.order)).abs() < 0.2, "{order}");
    }
    check::<Midpoint>();
    check::<Verlet>();
    check::<Gauss<2>>();
    check::<Composed<Midpoint, Suzuki4>>();
    check::<Composed<Verlet, BlanesMoan4>>();
}

#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.5 * omega * omega * q * q + 1.0 - q.cos(),
    embedding = [Midpoint, Gauss<2>, Gauss<8>],
)]
struct Stiff {
    omega: f64,
}

/// Sweeps with the linear part of the force solved for: `S = 8` takes `h ω = 50` as it takes `h ω = 5`.
#[test]
fn stiff_linear_forces_cost_few_sweeps() {
    fn sweeps<E, H: Discretized<E, Vector = Point>>(system: &H, start: [f64; 2], h: f64) -> f64 {
        let mut stepper = system.stepper::<E>(h).unwrap();
        let mut state = State::new([start[0]], [start[1]]);
        let total: u32 = (0..200).map(|_| stepper.step(&mut state, &[]).unwrap().iterations).sum();
        f64::from(total) / 200.0
    }
    for omega in [10.0, 50.0, 100.0, 1000.0] {
        let mean = sweeps::<Gauss<8>, _>(&Stiff { omega }, [1e-2, 0.5], 0.5);
        // Seven and six to ten roundings, and two more to a millionth of one: this iteration gains four digits in a sweep or more.
        assert!(mean < 9.0, "{omega}: {mean}");
    }
}

/// A linear oscillator keeps its radius at any `h ω` but for the rounding of its forces, which are as large as `h ω`: less than one of
/// them in a step. The tangent map is symplectic to the same.
#[test]
fn stiff_linear_forces_keep_the_radius() {
    for omega in [1.0, 5.0, 50.0, 1e4] {
        let oscillator = Rotation { omega };
        let mut stepper = oscillator.stepper::<Gauss<8>>(1.0).unwrap();
        let mut state = State::new([1.0], [0.0]);
        (0..10_000).for_each(|_| assert!(stepper.step(&mut state, &[]).is_ok()));
        let radius = state.q[0].hypot(state.p[0]);
        let rounding = f64::EPSILON * (1.0 + omega);
        assert!((radius - 1.0).abs() < 5000.0 * rounding, "{omega}: {:e}", radius - 1.0);
        let asymmetry = asymmetry::<Gauss<8>, _>(&oscillator, [&[1.0], &[0.0]], [0.0, 1.0], &[], 1.0);
        assert!(asymmetry < 10.0 * rounding, "{omega}: {asymmetry:e}");
    }
}

/// Two pendulums of different masses, coupled by a stiff spring: the eigenvectors of `M⁻¹K`.
#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * px * px + 0.5 * py * py / mass + 0.5 * k * (x - y).powi(2) + 2.0 - x.cos() - y.cos(),
    embedding = [Gauss<4>, Gauss<8>],
)]
struct Coupled {
    mass: f64,
    k: f64,
}

/// Against steps so short that plain sweeps are taken.
#[test]
fn coupled_stiff_forces_are_solved_in_their_eigenvectors() {
    let coupled = Coupled { mass: 3.0, k: 40.0 };
    let start = State::new([0.7, 0.65], [0.0, 0.3]);
    let end = |steps: u32| {
        let mut stepper = coupled.stepper::<Gauss<8>>(4.0 / f64::from(steps)).unwrap();
        let (mut state, mut total) = (start, 0);
        (0..steps).for_each(|_| total += stepper.step(&mut state, &[]).unwrap().iterations);
        (state, f64::from(total) / f64::from(steps))
    };
    let ((coarse, sweeps), (fine, _)) = (end(8), end(64));
    // The error of eight steps of order 16 with `h ω = 3.7`.
    assert!((coarse.q - fine.q).norm() < 1e-9 && (coarse.p - fine.p).norm() < 1e-8, "{coarse:?} {fine:?}");
    assert!(sweeps < 10.0, "{sweeps}");
}

/// Sweeps do not contract where `h ω` is large: the energy, which a symplectic step keeps within its order, stays where the start
/// is of the size of the thermal motion of the stiff direction.
#[test]
fn stiff_directions_keep_their_energy() {
    for omega in [10.0, 50.0, 100.0] {
        let stiff = Stiff { omega };
        let start = State::new([1e-2], [0.5]);
        let (h, steps) = (0.5, 2000);
        let path = stiff.simulate::<Gauss<8>>(h).start(start).steps(steps).run().unwrap();
        let energies = path.states().iter().map(|state| stiff.energy(state));
        let (least, most) = energies.fold((f64::INFINITY, 0.0_f64), |(a, b), e| (a.min(e), b.max(e)));
        // The force of the pendulum is smaller than the spring's by `1/ω²`, and so is what the step makes of it.
        assert!((most - least) / least < 10.0 / (omega * omega), "{omega}: {least} {most}");
    }
}

#[test]
fn a_step_that_fails_changes_nothing() {
    let stiff = Stiff { omega: f64::MAX.sqrt() };
    let mut stepper = stiff.stepper::<Gauss<8>>(0.1).unwrap();
    let error = refused(&State::new([1e200], [1.0]), |state| stepper.step(state, &[]));
    assert_eq!((error.step, error.h), (0, 0.1));
    let nan = Stiff { omega: f64::NAN };
    assert!(nan.stepper::<Gauss<2>>(0.1).is_err());
}

/// Paths of an ensemble are those that its noise drives alone.
#[test]
fn ensembles_run_gauss_methods_and_compositions() {
    macro_rules! check {
        ($($scheme:ty),*) => {$(
            // Sums of single paths are compensated.
            lanes_are_steppers::<$scheme, _>(&Noisy, [&[0.4], &[0.3]], 0.05);
        )*};
    }
    check!(Gauss<2>, Verlet, Composed<Midpoint, Suzuki4>);
}

/// Elements of any number of sites with masses that depend on the place, and a force.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| (0..q.len())
        .map(|i| 0.5 * p[i] * p[i] * (1.0 + 0.3 * q[i] * q[i]) + 10.0 * (0.5 * q[i] * q[i] + 0.25 * q[i].powi(4)))
        .sum::<f64>(),
    force = |q: &[f64], p: &[f64]| (0..q.len()).map(|i| -0.2 * p[i]),
    embedding = [Midpoint, Gauss<2>],
)]
struct Sites;

/// A stepper that has seen a state of another size takes the steps of a new one, and accounts for the same work.
#[test]
fn steps_of_states_of_several_sizes_are_those_of_new_steppers() {
    const H: f64 = 0.6;
    fn check<E>()
    where
        Sites: Discretized<E, Vector = wzvi::nalgebra::DVector<f64>>,
    {
        let mut used = Sites.stepper::<E>(H).unwrap();
        for sites in [1, 3, 1, 5, 2] {
            let mut fresh = Sites.stepper::<E>(H).unwrap();
            let start = State::new(vec![0.7; sites], vec![0.5; sites]);
            // The fixed point alone does not reach the solution.
            let mut sweeps = Sites.stepper::<E>(H).unwrap().iteration(Iteration::FixedPoint);
            let cause = refused(&start, |state| sweeps.step(state, &[])).cause;
            assert!(matches!(cause, StepFailure::NotConverged { .. }), "{sites} sites: {cause}");
            let (mut state, mut other) = (start.clone(), start);
            let before = used.exchanged().work;
            for _ in 0..3 {
                used.step(&mut state, &[]).unwrap();
                fresh.step(&mut other, &[]).unwrap();
            }
            assert_eq!((&state.q, &state.p), (&other.q, &other.p), "{sites} sites");
            let work = used.exchanged().work - before;
            // Sums of works below one, of fifteen steps, less those of the steps before.
            assert!((work - fresh.exchanged().work).abs() <= 1e-14, "{sites} sites: {work}");
        }
    }
    check::<Midpoint>();
    check::<Gauss<2>>();
}
