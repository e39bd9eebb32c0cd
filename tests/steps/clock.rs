//! Steps by a clock: against references of 34 digits, orders in `q`, `p` and `t`, and what they keep.

use fixtures::clock::{Kepler, exact, orbit, pericentre, the_energy_does_not_drift};
use fixtures::extremes::state;
use fixtures::reference::{data, list, number, numbers, text};
use fixtures::steps::{distance, numbers as components};
use serde_json::Value;
use wzvi::prelude::*;
use wzvi::scalar::Dual;
use wzvi_runtime::algebra::state_sum::PlainSum;
use wzvi_runtime::scheme::system::{MemoryOf, Scheme as _, SchemeOf, StepArguments};

/// With the clock `r`.
#[hamiltonian(
    drift = |[x, y], [u, v]| 0.5 * (u * u + v * v) - 1.0 / (x * x + y * y).sqrt(),
    clock = |[x, y], _| (x * x + y * y).sqrt(),
    embedding = [Extended<Verlet>, Extended<Gauss<2>>, Extended<Gauss<4>>, Extended<Gauss<8>>],
)]
struct ByRadius;

#[hamiltonian(
    drift = |q, p, t| 0.5 * p * p * (1.0 + q * q / 4.0) + q * q * q * q / 4.0 - 0.3 * q * t.cos(),
    clock = |q, p| 1.0 / (1.0 + q * q + 0.5 * p * p).sqrt(),
    embedding = Extended<Gauss<2>>,
)]
struct Driven;

/// The clock alone reads the time.
#[hamiltonian(
    drift = |q, p| 0.5 * (p * p + q * q),
    clock = |_, _, t| 1.0 / (1.0 + 0.5 * t.sin()),
    embedding = Extended<Gauss<4>>,
)]
struct Seasons;

/// One number or a list.
fn all(value: &Value) -> Vec<f64> {
    if value.is_array() { numbers(value) } else { vec![number(value)] }
}

/// Steps from node to node of a reference, each within 1e-13 of the largest component: some hundred roundings, which a
/// few sweeps or corrections have.
fn follow<E, H: Discretized<E>>(system: &H, case: &Value, nodes: &str, [q, p]: [&[f64]; 2], eps: f64) {
    let what = format!("{} by {}", case["scheme"], std::any::type_name::<E>());
    let (mut state, mut stepper) = (state::<H::Vector>(q, p), system.stepper::<E>(Eps(eps)).unwrap());
    for node in list(&case[nodes]) {
        stepper.step(&mut state, &[]).unwrap();
        let known = [all(&node["q"]), all(&node["p"])].concat();
        let size = known.iter().fold(0.0, |size: f64, x| size.max(x.abs()));
        assert!(
            distance(&components(&state), &known) < 1e-13 * size,
            "{what}: {state:?} instead of {known:?}"
        );
        let t = number(&node["t"]);
        assert!((state.t - t).abs() < 1e-13 * t, "{what}: {} instead of {t}", state.t);
    }
}

/// The case that this name is in.
macro_rules! schemes {
    ($name:expr, $system:expr, $case:expr, $nodes:literal, $start:expr, $eps:expr;
     $($part:literal: $scheme:ty),+ $(,)?) => {
        match $name {
            $(name if name.contains($part) => follow::<$scheme, _>(&$system, $case, $nodes, $start, $eps),)+
            name => panic!("{name} is not known"),
        }
    };
}

#[test]
fn steps_are_those_of_the_references() {
    for case in list(&data("clock/poincare_kepler")["cases"]) {
        let (eps, q, p) = (number(&case["h_tau"]), numbers(&case["q0"]), numbers(&case["p0"]));
        let name = text(&case["scheme"]);
        // `Gauss<1>` is the mid-point.
        if name.contains("s=1 ") {
            continue;
        }
        macro_rules! stages {
            ($system:expr) => {
                schemes!(name, $system, case, "trajectory", [&q, &p], eps;
                    "s=2 ": Extended<Gauss<2>>, "s=4 ": Extended<Gauss<4>>, "s=8 ": Extended<Gauss<8>>)
            };
        }
        if text(&case["g"]) == "r" { stages!(ByRadius) } else { stages!(Kepler) }
    }
    let of_time = data("clock/poincare_time_dependent");
    let case = &list(&of_time)[1];
    follow::<Extended<Gauss<2>>, _>(&Driven, case, "nodes", [&all(&case["q0"]), &all(&case["p0"])], 0.25);
    for file in ["poincare_explicit_pair", "separable_clock", "step_density"] {
        for case in list(&data(&format!("clock/{file}"))) {
            let (start, eps) = (pericentre(number(&case["e"])), number(&case["eps"]));
            let start = [start.q.as_slice(), start.p.as_slice()];
            let name = text(&case["scheme"]);
            match (file, name.contains("r^1(") || name.contains("x^-1,")) {
                ("poincare_explicit_pair", true) => schemes!(name, ByRadius, case, "nodes", start, eps;
                    "Yoshida4": Composed<Extended<Verlet>, Yoshida4>, "Verlet": Extended<Verlet>),
                ("poincare_explicit_pair", _) => schemes!(name, Kepler, case, "nodes", start, eps;
                    "Yoshida4": Composed<Extended<Verlet>, Yoshida4>, "Verlet": Extended<Verlet>),
                ("separable_clock", true) => schemes!(name, Kepler, case, "nodes", start, eps;
                    "Yoshida4": Composed<Logarithmic<1, 1>, Yoshida4>, "Verlet": Logarithmic<1, 1>),
                ("separable_clock", _) => schemes!(name, Kepler, case, "nodes", start, eps;
                    "Yoshida4": Composed<Logarithmic<3, 2>, Yoshida4>, "Verlet": Logarithmic<3, 2>),
                _ => schemes!(name, Kepler, case, "nodes", start, eps;
                    "Yoshida4": Clocked<Composed<Verlet, Yoshida4>>, "Verlet": Clocked<Verlet>,
                    "Gauss<2>": Clocked<Gauss<2>>, "Gauss<4>": Clocked<Gauss<4>>),
            }
        }
    }
}

/// The state after `τ` in so many steps, on an orbit with `e = 0.6`.
fn after<E>(tau: f64, steps: u32) -> State<<Kepler as Hamiltonian>::Vector>
where
    Kepler: Discretized<E>,
{
    let (mut state, mut stepper) =
        (pericentre(0.6), Kepler.stepper::<E>(Eps(tau / f64::from(steps))).unwrap());
    for _ in 0..steps {
        stepper.step(&mut state, &[]).unwrap();
    }
    state
}

/// The errors of `q`, `p` and `t` after `τ = 6` in so many steps. All schemes whose clock is
/// `r^{3/2}` have one time `τ`, since `D = 0` on the motion.
fn errors<E>(steps: u32) -> [f64; 3]
where
    Kepler: Discretized<E>,
{
    let (own, exact) = (after::<E>(6.0, steps), after::<Extended<Gauss<8>>>(6.0, 60));
    [(own.q - exact.q).norm(), (own.p - exact.p).norm(), (own.t - exact.t).abs()]
}

/// Errors fall by `2^order` where a step is halved, up to terms of the next order, a tenth of the order at most here.
fn has_order<E>(order: f64, steps: u32)
where
    Kepler: Discretized<E>,
{
    let [coarse, fine] = [steps, 2 * steps].map(errors::<E>);
    for (coarse, fine) in coarse.into_iter().zip(fine) {
        let measured = (coarse / fine).log2();
        let what = std::any::type_name::<E>();
        assert!((measured - order).abs() < 0.1 * order, "{what}: {measured} instead of {order} ({fine:e})");
    }
}

#[test]
fn coordinates_momenta_and_time_have_the_order_of_the_scheme() {
    has_order::<Extended<Verlet>>(2.0, 100);
    has_order::<Composed<Extended<Verlet>, Yoshida4>>(4.0, 100);
    has_order::<Composed<Extended<Verlet>, KahanLi6>>(6.0, 40);
    has_order::<Composed<Extended<Verlet>, KahanLi8>>(8.0, 30);
    has_order::<Extended<Gauss<2>>>(4.0, 40);
    has_order::<Extended<Gauss<4>>>(8.0, 10);
    has_order::<Logarithmic<3, 2>>(2.0, 100);
    has_order::<Composed<Logarithmic<3, 2>, Yoshida4>>(4.0, 100);
    has_order::<Composed<Logarithmic<3, 2>, KahanLi6>>(6.0, 40);
    has_order::<Composed<Logarithmic<3, 2>, KahanLi8>>(8.0, 30);
}

/// The distance from the orbit with `e = 0.6`, at the time where so many steps have led.
fn off_orbit<E>(steps: u32) -> f64
where
    Kepler: Discretized<E>,
{
    let state = after::<E>(6.0, steps);
    distance(&components(&state), &exact(0.6, state.t))
}

/// The density changes the sizes of steps, which the time knows, and not their order.
#[test]
fn steps_by_a_density_have_the_order_of_the_scheme() {
    fn check<E>(order: f64, steps: u32)
    where
        Kepler: Discretized<E>,
    {
        let measured = (off_orbit::<E>(steps) / off_orbit::<E>(2 * steps)).log2();
        let what = std::any::type_name::<E>();
        assert!((measured - order).abs() < 0.1 * order, "{what}: {measured} instead of {order}");
    }
    check::<Clocked<Verlet>>(2.0, 100);
    check::<Clocked<Composed<Verlet, Yoshida4>>>(4.0, 100);
    check::<Composed<Clocked<Verlet>, KahanLi6>>(6.0, 40);
    check::<Clocked<Gauss<2>>>(4.0, 40);
    check::<Clocked<Gauss<4>>>(8.0, 20);
}

/// The energy that a relative kick of 1e-9 at a pericentre adds, there and after the next apocentre: an error of the step,
/// since a state that its user moves begins anew.
fn kicked<E>() -> [f64; 2]
where
    Kepler: Discretized<E>,
{
    let eps = orbit(0.99) / 60.0;
    let (prepared, mut memory) = (Kepler.prepare(eps).unwrap(), MemoryOf::<Kepler, E, f64>::default());
    let State { mut q, mut p, mut t } = pericentre(0.99);
    let mut energy_after = |steps: u32, kick: f64| {
        p *= 1.0 + kick;
        for _ in 0..steps {
            Kepler.advance(&prepared, t, eps, q.as_mut_slice(), p.as_mut_slice(), &[], &mut memory).unwrap();
            t = SchemeOf::<Kepler, E>::reading(&memory).t;
        }
        Kepler.energy(&State::new(q, p))
    };
    let (start, apocentre) = (energy_after(60, 0.0), 30);
    let before = energy_after(0, 1e-9) - start;
    [before, energy_after(apocentre, 0.0) - start]
}

/// `K = Q (H + p_t)` is kept, so that an error of the energy falls with the ratio of `Q`: figures of 34 digits.
#[test]
fn the_extended_phase_space_restores_the_energy() {
    let [at_once, at_apocentre] = kicked::<Extended<Gauss<8>>>();
    assert!((at_once - 1.990e-7).abs() < 1e-10, "{at_once:e}");
    // The kinetic energy at the pericentre is 99.5, whose last place is 1.4e-14: 20 of these.
    assert!((at_apocentre - 7.09e-11).abs() < 3e-13, "{at_apocentre:e}");
    let [at_once, at_apocentre] = kicked::<Clocked<Gauss<8>>>();
    assert!((at_once - 1.990e-7).abs() < 1e-10, "{at_once:e}");
    assert!((at_apocentre / at_once - 1.0).abs() < 1e-3, "{at_apocentre:e}");
}

#[test]
fn the_energy_does_not_drift_over_close_passages() {
    the_energy_does_not_drift(10);
}

/// How far from the orbit a run ends after ten turns and a radian of time, by a step without a clock.
fn apart<E>(eccentricity: f64, eps: f64) -> f64
where
    Kepler: Discretized<E>,
{
    let end = 20.0 * std::f64::consts::PI + 1.0;
    let path = Kepler.simulate::<E>(Eps(eps)).start(pericentre(eccentricity)).until(end).run().unwrap();
    assert_eq!(path.last().t, end);
    let known = exact(eccentricity, end);
    distance(path.last().q.as_slice(), &known[..2])
}

/// The bounds are three times the errors of independent programs with as many evaluations.
#[test]
fn runs_end_on_the_orbit() {
    for (eccentricity, known) in [(0.9, "kepler0.9"), (0.99, "kepler0.99")] {
        let known = numbers(&data("clock/flow_ends")[known]["end"]);
        let end = exact(eccentricity, 20.0 * std::f64::consts::PI + 1.0);
        assert!(distance(&known, &end) < 1e-12, "{end:?}");
    }
    // The clock of these eps is `r^{3/2}/5^{1/4}`.
    let curvature = 5.0_f64.powf(-0.25);
    // At `e = 0.999` two energies of 1000 leave 1/2 at the start. What they lose by rounding, 1e-13, stays in `p_t`, and
    // changes the mean motion: 3 t 1e-13.
    for (eccentricity, bound) in [(0.9, 5e-13), (0.99, 3e-12), (0.999, 2e-11)] {
        let error = apart::<Extended<Gauss<8>>>(eccentricity, 0.7 * curvature);
        assert!(error < bound, "{eccentricity}: {error:e}");
    }
    for (eccentricity, bound) in [(0.9, 3e-9), (0.99, 9e-8), (0.999, 6e-7)] {
        // 12 000 forces.
        let eps = orbit(eccentricity) * 10.2 * 17.0 / 12e3;
        let error = apart::<Composed<Extended<Verlet>, KahanLi8>>(eccentricity, eps);
        assert!(error < bound, "{eccentricity}: {error:e}");
        // 4 400 forces.
        let eps = std::f64::consts::TAU * 10.2 * 17.0 / 4.4e3;
        let error = apart::<Composed<Logarithmic<1, 1>, KahanLi8>>(eccentricity, eps);
        assert!(error < 1e-9, "{eccentricity}: {error:e}");
    }
}

/// A clock may read the time where the Hamiltonian does not.
#[test]
fn a_clock_may_read_the_time() {
    let path = Seasons
        .simulate::<Extended<Gauss<4>>>(Eps(0.125))
        .start(State::new([1.0], [0.0]))
        .until(10.0)
        .run()
        .unwrap();
    let (q, p) = (path.last().q[0], path.last().p[0]);
    assert!((q - 10.0_f64.cos()).abs() < 1e-9 && (p + 10.0_f64.sin()).abs() < 1e-9, "{q} {p}");
}

/// A field of changing strength, which the explicit steps do not know.
#[hamiltonian(
    drift = |q, p, t| 0.5 * p * p - q.cos() * (1.0 + 0.1 * t.sin()),
    clock = |q, _| 1.0 / (1.0 + q * q),
    embedding = Extended<Verlet>,
)]
struct Shaken;

#[test]
fn explicit_steps_refuse_the_time() {
    let refused = Shaken.stepper::<Extended<Verlet>>(Eps(0.1)).map(drop).unwrap_err().to_string();
    assert!(refused.contains("write `Extended<Gauss<S>>`"), "{refused}");
}

/// Steps far too large for the orbit are errors, or right: the state is as it was, or on the orbit.
#[test]
fn steps_that_are_too_large_fail() {
    fn check<E>(eps: f64) -> bool
    where
        Kepler: Discretized<E>,
    {
        let (mut state, mut stepper) = (pericentre(0.9), Kepler.stepper::<E>(Eps(eps)).unwrap());
        let before = state;
        let failed = stepper.step(&mut state, &[]).is_err();
        assert!(!failed || state == before, "{state:?}");
        assert!(components(&state).iter().all(|x| x.is_finite()));
        failed
    }
    assert!(check::<Extended<Verlet>>(30.0));
    assert!(check::<Composed<Extended<Verlet>, KahanLi8>>(30.0));
}

/// With a mass and a strength.
#[hamiltonian(
    drift = |[x, y], [u, v]| (u * u + v * v) / (2.0 * m) - k / (x * x + y * y).sqrt(),
    clock = curvature,
    embedding = [Clocked<Verlet>, Extended<Verlet>, Extended<Gauss<2>>, Logarithmic<3, 2>],
)]
struct Attracted {
    m: f64,
    k: f64,
}

/// The derivative of the state after a step by a parameter, and a difference of states.
fn by_parameter<E>(number: usize) -> [Vec<f64>; 2]
where
    Attracted: Discretized<E>,
{
    let after = |values: [f64; 2], along: usize| {
        let system = Attracted { m: values[0], k: values[1] };
        let lift = |index: usize, value: f64| match index == along {
            true => Dual::<1>::variable(value, 0),
            false => Dual::constant(value),
        };
        let eps = Dual::constant(0.2);
        let prepared = SchemeOf::<Attracted, E>::prepare(&system, &lift, eps).unwrap();
        let (mut q, mut p) = ([0.5, 0.1].map(Dual::constant), [-0.3, 1.6].map(Dual::constant));
        let at = StepArguments { t: Dual::constant(0.0), h: eps, q: &mut q[..], p: &mut p[..], dw: &[] };
        let (mut memory, mut carry) = (MemoryOf::<Attracted, E, Dual<1>>::default(), PlainSum);
        SchemeOf::<Attracted, E>::advance::<_, _, PlainSum, false>(
            &system,
            &prepared,
            at,
            &mut memory,
            &mut carry,
        )
        .unwrap();
        [q, p].concat()
    };
    let derivative = after([1.3, 0.8], number).iter().map(|x| x.derivative[0]).collect();
    let end = |change: f64| {
        let mut values = [1.3, 0.8];
        values[number] += change;
        after(values, 2)
    };
    let differences = end(1e-5).iter().zip(end(-1e-5)).map(|(a, b)| (a.value - b.value) / 2e-5).collect();
    [derivative, differences]
}

/// Parameters change the clock and `p_t`, too. Central differences of 1e-5 are right to some 1e-10.
#[test]
fn steps_have_derivatives_by_parameters() {
    for number in [0, 1] {
        for [derivative, differences] in [
            by_parameter::<Clocked<Verlet>>(number),
            by_parameter::<Extended<Verlet>>(number),
            by_parameter::<Composed<Extended<Verlet>, Yoshida4>>(number),
            by_parameter::<Extended<Gauss<2>>>(number),
            by_parameter::<Logarithmic<3, 2>>(number),
        ] {
            assert!(derivative.iter().any(|x| x.abs() > 1e-3), "{derivative:?}");
            assert!(distance(&derivative, &differences) < 1e-8, "{derivative:?} instead of {differences:?}");
        }
    }
}
