//! The cases: systems, runs and measured errors.

use std::time::Instant;

use wzvi::Error;
use wzvi::error::{StepError, StepFailure};
use wzvi::increments::{NoNoise, Noise};
use wzvi::nalgebra::SVector;
use wzvi::prelude::*;
use wzvi::simulate::{Node, Simulation};

use crate::systems::{
    DoubleWell, HenonHeiles, Kepler, Kubo, LennardJones, MixedChain, Oscillator, Pendulum, PolarSpring,
    ScaledWell, Spring, Squeeze, TwoMasses, Well,
};
use crate::{Row, SIZE};

/// One degree of freedom.
type Point = State<SVector<f64, 1>>;
type Table = (&'static str, Vec<Row>);

pub(crate) fn all() -> Result<Vec<Table>, Error> {
    Ok(vec![
        ("1. Stiff spring pendulum, h = 0.01, t = 100: length 1, angle 1 rad", stiff_spring()?),
        (
            "2. Linear oscillator, 1000 steps (explicit and Gauss: 100 000): angle of a step, change of the radius",
            oscillator()?,
        ),
        ("3. Singular and chaotic motion", singular()?),
        ("4. Multiplicative noise", noise()?),
        ("5. Scales", scales()?),
        ("6. At rest, and nearly", rest()?),
        ("7. Long runs", long()?),
    ])
}

/// The error that ended a run, in two or three words.
fn word(error: &Error) -> &'static str {
    match error {
        Error::Step(StepError { cause, .. }) => match cause {
            StepFailure::Unresolved { .. } => "error: unresolved",
            StepFailure::NoSolution { .. } => "error: no solution",
            StepFailure::Singular { .. } => "error: singular",
            StepFailure::NonFinite => "error: not finite",
            StepFailure::NotConverged { .. } => "error: not converged",
            _ => "error: input",
        },
        _ => "error",
    }
}

/// Runs twice: once looking, once against the clock. `measure` gives the error of a node.
fn row<'a, H, E, N>(
    case: String,
    scheme: &'static str,
    unit: &'static str,
    run: impl Fn() -> Simulation<'a, H, E, N>,
    measure: impl Fn(&State<H::Vector>) -> f64,
) -> Result<Row, Error>
where
    H: Discretized<E> + 'a,
    E: 'a,
    N: Noise,
{
    let mut worst = 0.0_f64;
    let look = |state: &State<H::Vector>, node: &Node<'_>| {
        worst = if node.step == 0 { measure(state) } else { worst.max(measure(state)) };
    };
    run().record_every(0).inspect(look).run_partial()?;
    let clock = Instant::now();
    let (path, error) = run().record_every(0).run_partial()?;
    let time = clock.elapsed().as_nanos() as f64 / path.steps().max(1) as f64;
    let counts = path.iterations();
    let iterations = (counts.total > 0).then(|| (counts.total as f64 / path.steps() as f64, counts.largest));
    let error = error.map(|error| format!("{} at t = {:.3}", word(&error), path.last().t));
    let parts = 1 << counts.halvings;
    Ok(Row { case, scheme, error, parts, steps: path.steps(), iterations, drift: (unit, worst), time })
}

/// `row` with the drift of the energy relative to `scale`.
fn energy_row<'a, H, E>(
    case: String,
    scheme: &'static str,
    system: &'a H,
    start: &State<H::Vector>,
    scale: f64,
    run: impl Fn() -> Simulation<'a, H, E, NoNoise>,
) -> Result<Row, Error>
where
    H: Discretized<E> + 'a,
    E: 'a,
{
    let energy = system.energy(start);
    row(
        case,
        scheme,
        "dH",
        || run().start(start.clone()),
        |state| (system.energy(state) - energy).abs() / scale,
    )
}

fn stiff_spring() -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    let (x, y) = (1.0_f64.sin(), -1.0_f64.cos());
    for (name, radial) in [("slow", 0.0), ("fast", 0.1)] {
        let start = State::new([x, y], [radial * x, radial * y]);
        for exponent in [2, 4, 6, 8, 9, 10, 12, 14, 16] {
            let spring = Spring { stiffness: 10.0_f64.powi(exponent) };
            let case = |remedy: &str| format!("k = 1e{exponent} {name}{remedy}");
            let run = || spring.simulate::<Midpoint>(0.01).until(100.0);
            let plain = energy_row(case(""), "Midpoint", &spring, &start, 1.0, run)?;
            if exponent <= 8 {
                let run = || spring.simulate::<Verlet>(0.01).until(100.0);
                rows.push(energy_row(case(""), "Verlet", &spring, &start, 1.0, run)?);
                let run = || spring.simulate::<Gauss<4>>(0.01).until(100.0);
                rows.push(energy_row(case(""), "Gauss<4>", &spring, &start, 1.0, run)?);
            }
            let failed = plain.error.is_some();
            rows.push(plain);
            if failed {
                let run = || spring.simulate::<Midpoint>(0.01).until(100.0).retry(Retry::halving(10));
                rows.push(energy_row(case(", retry"), "Midpoint", &spring, &start, 1.0, run)?);
                let polar = PolarSpring { stiffness: spring.stiffness };
                let start = State::new([0.0, 1.0], [radial, 0.0]);
                let run = || polar.simulate::<Midpoint>(0.01).until(100.0);
                rows.push(energy_row(case(", polar"), "Midpoint", &polar, &start, 1.0, run)?);
            }
        }
    }
    Ok(rows)
}

fn oscillator() -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    let start = State::new([1.0], [0.0]);
    let growth = |state: &Point| (state.q[0].hypot(state.p[0]) - 1.0).abs();
    for exponent in [-8, -4, -2, 0, 2, 4, 8] {
        let omega = 10.0_f64.powi(exponent);
        let oscillator = Oscillator { omega };
        // From (1, 0) the motion is clockwise.
        let mut turned = start;
        oscillator.stepper::<Midpoint>(1.0)?.step(&mut turned, &[])?;
        let angle = (-turned.p[0]).atan2(turned.q[0]);
        let exact = 2.0 * (0.5 * omega).atan();
        let run = || oscillator.simulate::<Midpoint>(1.0).start(start).steps(1000);
        let case = format!("ω h = 1e{exponent}");
        let mut row = row(case, "Midpoint", "angle", run, growth)?;
        row.drift = ("angle, |r-1|", row.drift.1.max((angle / exact - 1.0).abs()));
        rows.push((omega, row));
    }
    for omega in [1.999_999, 2.0, 2.000_001] {
        let oscillator = Oscillator { omega };
        let run = || oscillator.simulate::<DeltaPlus>(1.0).start(start).steps(100_000);
        rows.push((omega, row(format!("ω h = {omega}"), "DeltaPlus", "|r-1|", run, growth)?));
    }
    // The limit of explicit steps is `ωh = 2`; above it the radius grows by the same factor in each step.
    for omega in [1.9, 1.999_999, 2.0, 2.000_001, 2.1] {
        let oscillator = Oscillator { omega };
        let run = || oscillator.simulate::<Verlet>(1.0).start(start).steps(100_000);
        rows.push((omega, row(format!("ω h = {omega}"), "Verlet", "|r-1|", run, growth)?));
    }
    for omega in [1.0, 5.0, 50.0, 1e4, 1e8] {
        let oscillator = Oscillator { omega };
        let run = || oscillator.simulate::<Gauss<8>>(1.0).start(start).steps(100_000);
        rows.push((omega, row(format!("ω h = {omega:e}"), "Gauss<8>", "|r-1|", run, growth)?));
    }
    rows.sort_by(|(one, _), (other, _)| one.total_cmp(other));
    Ok(rows.into_iter().map(|(_, row)| row).collect())
}

fn singular() -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    for e in [0.9, 0.99, 0.999] {
        let start = State::new([1.0 + e, 0.0], [0.0, ((1.0 - e) / (1.0_f64 + e)).sqrt()]);
        let run = || Kepler.simulate::<Midpoint>(1e-3).steps(100_000);
        let plain = energy_row(format!("Kepler e = {e}"), "Midpoint", &Kepler, &start, 0.5, run)?;
        let failed = plain.error.is_some();
        rows.push(plain);
        if failed {
            let run = || Kepler.simulate::<Midpoint>(1e-3).steps(100_000).retry(Retry::halving(12));
            rows.push(energy_row(format!("Kepler e = {e}, retry"), "Midpoint", &Kepler, &start, 0.5, run)?);
        }
    }
    for (name, push) in [("near collision", 1e-3), ("head-on", 0.0)] {
        let start = State::new([1.0, 0.0], [0.0, push]);
        for retry in [0, 12] {
            let run = || Kepler.simulate::<Midpoint>(1e-3).steps(10_000).retry(Retry::halving(retry));
            let remedy = if retry > 0 { ", retry" } else { "" };
            rows.push(energy_row(format!("Kepler {name}{remedy}"), "Midpoint", &Kepler, &start, 1.0, run)?);
        }
    }
    for speed in [1.0, 10.0, 100.0] {
        let start = State::new([3.0], [-speed]);
        let scale = LennardJones.energy(&start).abs();
        let case = format!("Lennard-Jones head-on, p = {speed}");
        let run = || LennardJones.simulate::<Midpoint>(1e-3).steps(10_000);
        rows.push(energy_row(case.clone(), "Midpoint", &LennardJones, &start, scale, run)?);
        let run = || LennardJones.simulate::<DeltaPlus>(1e-3).steps(10_000);
        rows.push(energy_row(case, "DeltaPlus", &LennardJones, &start, scale, run)?);
    }
    let start = State::new([0.0], [2.0]);
    let run = || Pendulum.simulate::<Midpoint>(0.1).steps(100_000);
    rows.push(energy_row("pendulum, separatrix".into(), "Midpoint", &Pendulum, &start, 1.0, run)?);
    for p in [0.0, 1e-8] {
        let start = State::new([0.0], [p]);
        let run = || DoubleWell.simulate::<Midpoint>(0.1).steps(100_000);
        rows.push(energy_row(
            format!("double well, barrier, p = {p:e}"),
            "Midpoint",
            &DoubleWell,
            &start,
            1.0,
            run,
        )?);
    }
    let start = State::new([0.0, 0.9], [0.5, 0.5]);
    let run = || HenonHeiles.simulate::<DeltaPlus>(0.05).steps(10_000);
    rows.push(energy_row("Hénon-Heiles, escape".into(), "DeltaPlus", &HenonHeiles, &start, 1.0, run)?);
    let run = || HenonHeiles.simulate::<Midpoint>(0.05).steps(10_000);
    rows.push(energy_row("Hénon-Heiles, escape".into(), "Midpoint", &HenonHeiles, &start, 1.0, run)?);
    Ok(rows)
}

fn noise() -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    let start = State::new([0.0], [1.0]);
    let radius = |state: &Point| (state.q[0] * state.q[0] + state.p[0] * state.p[0] - 1.0).abs();
    for exponent in [-3, 0, 3] {
        let kubo = Kubo { a: 1.5, sigma: 10.0_f64.powi(exponent) };
        let run = || kubo.simulate::<Midpoint>(0.01).start(start).noise(Wiener::seed(7)).steps(10_000);
        rows.push(row(format!("Kubo σ = 1e{exponent}"), "Midpoint", "r²-1", run, radius)?);
    }
    for (name, h) in [("h = 1e-9", 1e-9), ("h = 1e3", 1e3)] {
        let kubo = Kubo { a: 1.5, sigma: 1.0 };
        let run = || kubo.simulate::<Midpoint>(h).start(start).noise(Wiener::seed(7)).steps(10_000);
        rows.push(row(format!("Kubo {name}"), "Midpoint", "r²-1", run, radius)?);
    }
    let kubo = Kubo { a: 1.5, sigma: 1.0 };
    let thousands = || Increments::from(vec![1e3; 1000]);
    let run = || kubo.simulate::<Midpoint>(0.01).start(start).noise(thousands()).steps(1000);
    rows.push(row("Kubo, increments of 1e3".into(), "Midpoint", "r²-1", run, radius)?);
    let run = || kubo.simulate::<Midpoint>(0.01).start(start).noise(Wiener::seed(7)).steps(10_000);
    let forth = run().run()?;
    let end = *forth.last();
    let back = || kubo.simulate::<Midpoint>(-0.01).start(end).noise(Wiener::seed(7)).steps(10_000);
    let mut reversed = row("Kubo, there and back".into(), "Midpoint", "return", back, |_| 0.0)?;
    let last = *back().run()?.last();
    reversed.drift.1 = (last.q - start.q).norm().hypot((last.p - start.p).norm());
    rows.push(reversed);
    for sigma in [0.1, 1.0, 10.0] {
        let squeeze = Squeeze { sigma };
        let size = |state: &Point| state.q[0].hypot(state.p[0]).ln().abs();
        // A run whose truncated increments reach the pole is refused.
        if sigma < 10.0 {
            let run = || squeeze.simulate::<Midpoint>(0.1).start(start).noise(Wiener::seed(7)).steps(1000);
            rows.push(row(format!("σ q p, σ = {sigma}, truncated"), "Midpoint", SIZE, run, size)?);
        }
        let free = || Wiener::seed(7).untruncated();
        let run = || squeeze.simulate::<Midpoint>(0.1).start(start).noise(free()).steps(1000);
        rows.push(row(format!("σ q p, σ = {sigma}, untruncated"), "Midpoint", SIZE, run, size)?);
    }
    let squeeze = Squeeze { sigma: 1.0 };
    let pole = || Increments::from(vec![2.0]);
    let run = || squeeze.simulate::<Midpoint>(1e-200).start(start).noise(pole()).steps(1);
    rows.push(row("σ q p at its pole".into(), "Midpoint", SIZE, run, |_| 0.0)?);
    Ok(rows)
}

fn scales() -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    for (omega, size) in [(1e-150, 1.0), (1e150, 1.0), (1.0, 1e-310), (1.0, 1e150), (1.0, 1e200)] {
        let oscillator = Oscillator { omega };
        let start = State::new([0.6 * size], [0.8 * size]);
        let run = || oscillator.simulate::<Midpoint>(0.1 / omega).start(start).steps(10_000);
        let radius = |state: &Point| ((state.q[0] / size).hypot(state.p[0] / size) - 1.0).abs();
        rows.push(row(format!("ω = {omega:e}, state of {size:e}"), "Midpoint", "r-1", run, radius)?);
    }
    for heavy in [1.0, 1e12] {
        let masses = TwoMasses { light: 1.0, heavy };
        let start = State::new([1.0, 0.5], [0.0, 0.0]);
        let scale = masses.energy(&start);
        let run = || masses.simulate::<Midpoint>(0.05).steps(100_000);
        rows.push(energy_row(format!("masses 1 and {heavy:e}"), "Midpoint", &masses, &start, scale, run)?);
    }
    let start = State::new([1e-9], [0.0]);
    let scale = Pendulum.energy(&start);
    let run = || Pendulum.simulate::<Midpoint>(0.1).steps(100_000);
    rows.push(energy_row("pendulum of 1e-9 rad".into(), "Midpoint", &Pendulum, &start, scale, run)?);
    Ok(rows)
}

/// The drift is the largest move from the start, in units of the scale: rounding of the place where there is no motion.
fn rest() -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    for a in [0.5_f64, 2.0, 5.5] {
        let (well, bottom) = (Well { a }, a.sqrt());
        for amplitude in [0.0, 1e-10, 1e-8] {
            let start = State::new([bottom + amplitude], [0.0]);
            let run = || well.simulate::<Midpoint>(0.05).start(start).steps(200_000);
            let moved = |state: &Point| (state.q[0] - bottom).abs();
            rows.push(row(format!("well at √{a}, {amplitude:e} off"), "Midpoint", "|dq|", run, moved)?);
        }
    }
    for scale in [1e-6, 1e6, 1e100] {
        let well = ScaledWell { scale };
        for amplitude in [0.0, 1e-12] {
            let start = State::new([scale], [amplitude * scale]);
            let run = || well.simulate::<Midpoint>(0.1).start(start).steps(200_000);
            let moved = |state: &Point| (state.q[0] / scale - 1.0).abs();
            rows.push(row(format!("well at {scale:e}, p = {amplitude:e}"), "Midpoint", "|dq|", run, moved)?);
        }
    }
    let bottom = 2.0_f64.powf(1.0 / 6.0);
    for h in [1e-3, 1e-2] {
        let start = State::new([bottom], [0.0]);
        let run = || LennardJones.simulate::<Midpoint>(h).start(start).steps(200_000);
        let moved = |state: &Point| (state.q[0] - bottom).abs();
        rows.push(row(format!("Lennard-Jones minimum, h = {h}"), "Midpoint", "|dq|", run, moved)?);
    }
    let chain = MixedChain { mass: (0..7).map(|i| 10.0_f64.powi(5 * i - 15)).collect(), k: 1e-15 };
    for scale in [1e-280, 1.0, 1e280] {
        // Energies underflow, or overflow, at both ends: the largest coordinate will do.
        let start = State::new(vec![scale; 7], vec![0.0; 7]);
        let run = || chain.simulate::<Midpoint>(0.1).start(start.clone()).steps(10_000);
        let size = |state: &State<_>| largest(state) / scale;
        rows.push(row(format!("masses 1e-15 to 1e15 at {scale:e}"), "Midpoint", SIZE, run, size)?);
    }
    Ok(rows)
}

fn largest(state: &State<wzvi::nalgebra::DVector<f64>>) -> f64 {
    state.q.iter().fold(0.0, |most, q| q.abs().max(most))
}

/// Steps of the long runs.
const LONG: u64 = 100_000_000;

fn long() -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    let kubo = Kubo { a: 1.5, sigma: 1.0 };
    for compensated in [false, true] {
        let (mut state, mut words) = (State::new([0.0], [1.0]), 7_u64);
        let plain = kubo.stepper::<Midpoint>(0.02)?.plain();
        let mut carrying = kubo.stepper::<Midpoint>(0.02)?.compensated();
        let mut plain = plain;
        let mut worst = 0.0_f64;
        let clock = Instant::now();
        for n in 1..=LONG {
            // Uniform increments of variance h will do: any sequence has to keep the radius.
            words = words.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let dw = [((words >> 11) as f64 * 2.0_f64.powi(-53) - 0.5) * (12.0_f64 * 0.02).sqrt()];
            if compensated {
                carrying.step(&mut state, &dw)?;
            } else {
                plain.step(&mut state, &dw)?;
            }
            if n % 1000 == 0 {
                worst = worst.max((state.q[0] * state.q[0] + state.p[0] * state.p[0] - 1.0).abs());
            }
        }
        rows.push(Row {
            case: format!("Kubo, 1e8 steps, {}", if compensated { "compensated" } else { "plain" }),
            scheme: "Midpoint",
            error: None,
            parts: 1,
            steps: LONG,
            iterations: None,
            drift: ("r²-1", worst),
            time: clock.elapsed().as_nanos() as f64 / LONG as f64,
        });
    }
    Ok(rows)
}
