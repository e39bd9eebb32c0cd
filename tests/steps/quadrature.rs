//! Quadratures of the program's own: their facts, their order, and the same steps in straight lines, in loops and in lanes. That they are symplectic, and what their
//! equations say, is in `symplectic`.

use fixtures::{larger, wave};
use wzvi::plan::{Plan, Solver};
use wzvi::prelude::*;

struct Trapezoidal;
struct Simpson;
/// Of order two without being symmetric.
struct Radau;
/// Of order one: the mean is 1/4.
struct Third;

/// Neither separable nor autonomous, with noise that multiplies.
#[hamiltonian(
    drift = |q, p, t| 0.5 * p * p * (1.0 + 0.1 * q * q) + 0.25 * q.powi(4) - 0.3 * q * (2.0 * t).cos(),
    noise = [|q, p| 0.3 * q * p],
    force = |q, p| 0.1 * q - 0.2 * p,
    embedding = [
        Trapezoidal = [(0, 1/2), (1, 1/2)], Simpson = [(0, 1/6), (1/2, 2/3), (1, 1/6)],
        Radau = [(1/3, 3/4), (1, 1/4)], Corrected<Third> = [(0, 0.25), (1/3, 0.75)],
    ],
)]
struct One;

/// The same at each site.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64], t| (0..q.len())
        .map(|i| 0.5 * p[i] * p[i] * (1.0 + 0.1 * q[i] * q[i]) + 0.25 * q[i].powi(4) - 0.3 * q[i] * (2.0 * t).cos())
        .sum::<f64>(),
    noise = [|q, p, k| 0.3 * q[k] * p[k]; sites],
    force = |q, p| (0..q.len()).map(|i| 0.1 * q[i] - 0.2 * p[i]),
    embedding = [
        Trapezoidal = [(0, 1/2), (1, 1/2)], Simpson = [(0, 1/6), (1/2, 2/3), (1, 1/6)],
        Radau = [(1/3, 3/4), (1, 1/4)], Corrected<Third> = [(0, 0.25), (1/3, 0.75)],
    ],
)]
struct Many {
    sites: usize,
}

/// Kinetic and potential energy apart, alone and in a chain.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p - q.cos(),
    embedding = [Verlet, Trapezoidal = [(0, 1/2), (1, 1/2)], Simpson = [(0, 1/6), (1/2, 2/3), (1, 1/6)], Third = [(0, 1/4), (1/3, 3/4)]],
)]
struct Pendulum;

#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| p.iter().map(|p| 0.5 * p * p).sum::<f64>()
        + (1..q.len()).map(|i| 1.0 - (q[i] - q[i - 1]).cos()).sum::<f64>(),
    embedding = [Verlet, Trapezoidal = [(0, 1/2), (1, 1/2)]],
)]
struct Chain;

/// `q = q_0 exp(a t + s W)`
#[hamiltonian(
    drift = |q, p| a * q * p,
    noise = [|q, p| s * q * p],
    embedding = [
        Uncorrected<Third> = [(0, 1/4), (1/3, 3/4)], Corrected<Third>, Trapezoidal = [(0, 1/2), (1, 1/2)],
        Uncorrected<Lambda<1, 4>>,
    ],
)]
struct Growth {
    a: f64,
    s: f64,
}

/// The end of so many steps of a unit of time, with increments that alternate.
fn end<E, H: Discretized<E>>(system: &H, start: State<H::Vector>, steps: u32, size: f64) -> State<H::Vector> {
    let h = 1.0 / f64::from(steps);
    let (mut state, mut stepper) = (start, system.stepper::<E>(h).unwrap());
    for step in 0..steps {
        let dw = vec![if step % 2 == 0 { size } else { -size }; system.noises()];
        stepper.step(&mut state, &dw).unwrap();
    }
    state
}

#[test]
fn the_order_is_two_where_the_mean_of_the_points_is_a_half() {
    fn check<E>(expected: u32)
    where
        One: Discretized<E>,
        Many: Discretized<E>,
    {
        assert_eq!(<Many as Discretized<E>>::PLAN.order, expected);
        fixtures::steps::has_order::<E, _>(&One, [&[0.7], &[0.4]], (1.0, 256), expected, 0.1);
    }
    check::<Trapezoidal>(2);
    check::<Simpson>(2);
    check::<Radau>(2);
    check::<Corrected<Third>>(1);
}

#[test]
fn loops_take_the_steps_of_straight_lines() {
    fn check<E>()
    where
        One: Discretized<E>,
        Many: Discretized<E>,
    {
        let alone = end::<E, _>(&One, State::new([0.7], [0.4]), 40, 0.1);
        let among = end::<E, _>(&Many { sites: 3 }, State::new(vec![0.7; 3], vec![0.4; 3]), 40, 0.1);
        for site in 0..3 {
            // Forty steps, each solved to a few roundings.
            assert!((among.q[site] - alone.q[0]).abs() < 1e-13, "{among} {alone}");
            assert!((among.p[site] - alone.p[0]).abs() < 1e-13, "{among} {alone}");
        }
    }
    check::<Trapezoidal>();
    check::<Simpson>();
    check::<Radau>();
    check::<Corrected<Third>>();
}

/// With `T(p) + V(q)` the trapezoidal rule is kick, drift, kick, and nothing is solved.
#[test]
fn the_trapezoidal_rule_of_parts_is_verlet() {
    let plan: Plan = <Pendulum as Discretized<Trapezoidal>>::PLAN;
    assert_eq!((plan.solver, plan.unknowns, plan.order), (Solver::Explicit, 0, 2));
    assert_eq!(<Chain as Discretized<Trapezoidal>>::PLAN.solver, Solver::Explicit);
    assert_eq!(<Pendulum as Discretized<Simpson>>::PLAN.solver, Solver::Newton);
    let start = State::new([1.0], [0.3]);
    let ends =
        [end::<Trapezoidal, _>(&Pendulum, start, 30, 0.0), end::<Verlet, _>(&Pendulum, start, 30, 0.0)];
    assert!((ends[0].q[0] - ends[1].q[0]).abs() < 1e-14 && (ends[0].p[0] - ends[1].p[0]).abs() < 1e-14);
    // Small and large: a system of 100 sites would go tile by tile if it had one point.
    for sites in [5, 100] {
        let start = State::new(wave(sites, 1.0, 0.2), wave(sites, 1.0, 1.1));
        let [own, verlet] =
            [end::<Trapezoidal, _>(&Chain, start.clone(), 30, 0.0), end::<Verlet, _>(&Chain, start, 30, 0.0)];
        assert!((own.q - verlet.q).amax() < 1e-13 && (own.p - verlet.p).amax() < 1e-13);
    }
}

/// With increments of ±√h in turn the quadratic variation is the time: the limit grows by `exp(a - (1/2 - m) s²)`.
#[test]
fn the_limit_reads_the_mean_of_the_points() {
    let growth = Growth { a: 0.3, s: 0.8 };
    let steps = 40_000;
    let size = (1.0 / f64::from(steps)).sqrt();
    let start = State::new([1.0], [1.0]);
    let third = end::<Uncorrected<Third>, _>(&growth, start, steps, size).q[0].ln();
    let quarter = end::<Uncorrected<Lambda<1, 4>>, _>(&growth, start, steps, size).q[0].ln();
    let corrected = end::<Corrected<Third>, _>(&growth, start, steps, size).q[0].ln();
    let trapezoidal = end::<Trapezoidal, _>(&growth, start, steps, size).q[0].ln();
    // To the order of the step, 2.5e-5.
    assert!((third - (0.3 - 0.25 * 0.64)).abs() < 1e-4, "{third}");
    assert!((third - quarter).abs() < 1e-4, "{third} {quarter}");
    assert!((corrected - 0.3).abs() < 1e-4 && (trapezoidal - 0.3).abs() < 1e-4, "{corrected} {trapezoidal}");
    let consistent = [
        <Growth as Discretized<Uncorrected<Third>>>::PLAN.consistent,
        <Growth as Discretized<Corrected<Third>>>::PLAN.consistent,
        <Growth as Discretized<Trapezoidal>>::PLAN.consistent,
    ];
    assert_eq!(consistent, [false, true, true]);
}

/// Every path of an ensemble, in lanes, is that of a single run.
#[test]
fn lanes_take_the_steps_of_a_stepper() {
    fixtures::steps::lanes_are_steppers::<Simpson, _>(&One, [&[0.7], &[0.4]], 0.05);
}

/// The modified energy that is printed: of the motion without time, noise and force, its drift falls with the fourth power of the step.
#[test]
fn the_printed_modified_energy_is_kept() {
    let text = <Pendulum as Discretized<Simpson>>::EQUATIONS;
    assert!(text.contains("H0 + h² (-H_pp(H_q,H_q)/24)\n"), "{text}");
    let drift = |h: f64| {
        let energy = |state: &SystemState<Pendulum>| {
            let (q, p): (f64, f64) = (state.q[0], state.p[0]);
            0.5 * p * p - q.cos() - h * h / 24.0 * q.sin().powi(2)
        };
        let (mut state, mut stepper) = (State::new([1.0], [0.3]), Pendulum.stepper::<Simpson>(h).unwrap());
        let first = energy(&state);
        let mut most = 0.0_f64;
        for _ in 0..(10.0 / h) as usize {
            stepper.step(&mut state, &[]).unwrap();
            most = larger(most, (energy(&state) - first).abs());
        }
        most
    };
    let order = (drift(0.1) / drift(0.05)).log2();
    assert!((order - 4.0).abs() < 0.25, "{order}");
}

#[test]
fn equations_and_facts_name_the_points() {
    let text = <One as Discretized<Simpson>>::EQUATIONS;
    assert!(text.starts_with("Simpson\n"));
    for line in [
        "quadrature points and weights: (0, 1/6), (1/2, 2/3), (1, 1/6); Σ w l = 1/2, symmetric",
        "order 2, as Σ w l of the drift is 1/2",
        "q_{i+1/2} = q_i + Δq/2",
    ] {
        assert!(text.contains(line), "{line} is not in\n{text}");
    }
    let text = <Many as Discretized<Corrected<Third>>>::EQUATIONS;
    for line in [
        "L_d = P · Δq - 1/4 h H0(P, q) - 1/4 H_W(P, q)",
        "- 3/4 h H0(P, q_{1/3}) - 3/4 H_W(P, q_{1/3})",
        "H_W = Σ_k ΔW[k] H_k\n",
        "p' = D2 L_d:  p' = P - 1/4 h ∂H0/∂q(P, q_{1/3}) + 1/4 h F0(P, q_{1/3}) - 1/4 ∂H_W/∂q(P, q_{1/3})",
        "quadrature points and weights: (0, 1/4), (1/3, 3/4); Σ w l = 1/4\n",
        "order 1, as Σ w l of the drift is not 1/2",
        "converges to the Stratonovich system",
    ] {
        assert!(text.contains(line), "{line} is not in\n{text}");
    }
}
