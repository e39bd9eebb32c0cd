//! The pictures of the guide beside those of the README.

use std::error::Error;
use std::f64::consts::TAU;
use std::time::Instant;

use wzvi::bath::{A, B, HarmonicLaw, Letters, O};
use wzvi::constraints::RigidBody;
use wzvi::embedding::OneStep;
use wzvi::error::StepFailure;
use wzvi::nalgebra::{DVector, Rotation3, SVector, Vector3};
use wzvi::plot::{Colour, Figure, Look};
use wzvi::prelude::*;
use wzvi::scalar::Scalar;
use wzvi::system::{Scratch, StepField};

use crate::Drawn;
use crate::systems::{
    AngleRing, Chain, Driven, Encounter, Kepler, Kubo, Oscillator, Pendulum, Rotor, Simpson, SpinRing, Top,
    WarmWells,
};

pub(crate) fn figures() -> Result<Vec<(&'static str, Figure)>, Box<dyn Error>> {
    Ok(vec![
        ("embeddings", embeddings()),
        ("modified_energy", modified_energy()?),
        ("phase", phase()?),
        ("stability_limit", stability_limit()?),
        ("ito", ito()?),
        ("thermostat", thermostat()?),
        ("sweep", sweep()?),
        ("order_noise", order_noise()?),
        ("order_chain", order_chain()?),
        ("order_bath", order_bath()),
        ("diagram", diagram()?),
        ("standard_map", standard_map()?),
        ("paths", paths()?),
        ("unresolved", unresolved()?),
        ("branches", branches()),
        ("drift", drift()?),
        ("spins", spins()?),
        ("top", top()?),
        ("burrau", burrau()?),
    ])
}

/// Where within a step the Hamiltonians are evaluated.
fn embeddings() -> Figure {
    let gauss: [&[f64]; 2] = [
        &[0.211_324_865_405_187_1, 0.788_675_134_594_812_9],
        &[0.069_431_844_202_973_7, 0.330_009_478_207_571_9, 0.669_990_521_792_428_1, 0.930_568_155_797_026_3],
    ];
    let rows: [(&str, &[f64]); 8] = [
        ("DeltaPlus", &[0.0]),
        ("DeltaMinus", &[1.0]),
        ("Midpoint", &[0.5]),
        ("Lambda<1, 4>", &[0.25]),
        ("trapezoidal", &[0.0, 1.0]),
        ("Simpson", &[0.0, 0.5, 1.0]),
        ("Gauss<2>", gauss[0]),
        ("Gauss<4>", gauss[1]),
    ];
    let names = rows.iter().rev().map(|(name, _)| *name);
    let mut figure = Figure::panel("Quadrature points within a step", "fraction of the step l", "")
        .x_range(-0.05..1.05)
        .y_names(names);
    for (height, (_, points)) in rows.iter().rev().enumerate() {
        let height = height as f64;
        figure = figure.line("", Colour::GREY, [(0.0, height), (1.0, height)]);
        figure = figure.points(Look::Dots, "", Colour::BLUE, points.iter().map(|l| (*l, height)));
    }
    figure.y_range(-0.7..rows.len() as f64 - 0.3)
}

/// Verlet keeps another energy nearly.
fn modified_energy() -> Drawn {
    let h = 0.4;
    let path = Pendulum.simulate::<Verlet>(h).start(State::new([2.0], [0.0])).until(60.0).run()?;
    let change = |of: &dyn Fn(&State<SVector<f64, 1>>) -> f64| {
        let first = of(&path.states()[0]);
        path.iter().map(|state| (state.t, of(state) - first)).collect::<Vec<_>>()
    };
    Ok(Figure::panel(
        "Pendulum by Verlet, h = 0.4: change of the energies",
        "time t",
        "change since the start",
    )
    .line("energy", Colour::VERMILION, change(&|state| Pendulum.energy(state)))
    .line("modified energy", Colour::BLUE, change(&|state| Pendulum.shadow_energy::<Verlet>(state, h))))
}

/// What no energy shows: long steps run ahead on the right orbit.
fn phase() -> Drawn {
    let swing = |h: f64| {
        let path = Pendulum.simulate::<Verlet>(h).start(State::new([2.0], [0.0])).until(400.0).run()?;
        let last = path.iter().filter(|state| state.t >= 370.0).map(|state| (state.t, state.q[0]));
        Ok::<_, wzvi::Error>(last.collect::<Vec<_>>())
    };
    Ok(Figure::panel("Pendulum by Verlet, after 45 periods", "time t", "angle [rad]")
        .line("h = 0.01", Colour::GREY, swing(0.01)?)
        .line("h = 0.4", Colour::VERMILION, swing(0.4)?))
}

/// How far an oscillator gets in 40 steps.
fn stability_limit() -> Drawn {
    Ok(Figure::panel("Oscillator, 40 steps: largest radius over that at the start", "ω h", "growth factor")
        .log_y()
        .y_range(0.5..1e6)
        .points(Look::Broad, "Midpoint", Colour::GREY, growth::<Midpoint>()?)
        .line("Simpson", Colour::GREEN, growth::<Simpson>()?)
        .line("Verlet", Colour::VERMILION, growth::<Verlet>()?))
}

fn growth<E>() -> Result<Vec<(f64, f64)>, Box<dyn Error>>
where
    Oscillator: Discretized<E, Vector = SVector<f64, 1>>,
{
    let mut points = Vec::new();
    for k in 1..200 {
        let h = 0.02 * f64::from(k);
        let run = Oscillator.simulate::<E>(h).start(State::new([1.0], [0.0])).steps(40).unwatched();
        let (path, _) = run.run_partial()?;
        let radius = |state: &State<SVector<f64, 1>>| state.q[0].hypot(state.p[0]);
        let largest = path.iter().map(radius).fold(0.0, f64::max);
        points.push((h, largest.min(1e6)));
        if largest > 1e6 {
            break;
        }
    }
    Ok(points)
}

/// One Wiener path, two meanings of the same equation.
fn ito() -> Drawn {
    let (kubo, h) = (Kubo { a: 1.5, sigma: 0.5 }, 0.001);
    let run = kubo.simulate::<Midpoint>(h).start(State::new([0.0], [1.0])).noise(Wiener::seed(7));
    let path = run.until(6.0).run()?;
    let (mut q, mut p) = (0.0, 1.0);
    let ito = path.increments().map(|dw| {
        let turn = kubo.a * h + kubo.sigma * dw[0];
        (q, p) = (q + turn * p, p - turn * q);
        (q, p)
    });
    let ito = ito.collect::<Vec<_>>();
    Ok(Figure::panel("Kubo oscillator: one path of the noise, two equations", "q", "p")
        .equal_axes()
        .line("Ito, by Euler and Maruyama", Colour::VERMILION, ito)
        .line("Stratonovich, by Midpoint", Colour::BLUE, path.iter().map(|state| (state.q[0], state.p[0]))))
}

/// Wong-Zakai to t = 1 as h goes to 0: with a smooth driver and without.
fn diagram() -> Drawn {
    let title = "Kubo oscillator to t = 1: distance from the solution, 100 paths";
    Ok(Figure::panel(title, "step size h", "root mean square distance")
        .log_log()
        .points(
            Look::Joined,
            "left point, smooth noise (ε = 1/16)",
            0,
            approximated::<Uncorrected<DeltaPlus>>()?,
        )
        .points(Look::Joined, "mid-point, smooth noise", 1, approximated::<Midpoint>()?)
        .points(Look::Joined, "left point, Wiener noise", 2, strong::<Uncorrected<DeltaPlus>>()?)
        .points(Look::Joined, "mid-point, Wiener noise", 3, strong::<Midpoint>()?))
}

/// The distance from the solution of the Wong-Zakai equation, driven by the exact increments of its noise.
fn approximated<E>() -> Result<Vec<(f64, f64)>, wzvi::Error>
where
    Kubo: Discretized<E, Vector = SVector<f64, 1>>,
{
    distances::<E, _>(
        |path| WongZakai::averaged(0.0625).seed(7).path(path).exact(),
        |noise| Ok(noise.value(0, 1.0)? - noise.value(0, 0.0)?),
    )
}

/// Positions by Baoab beside the Boltzmann distribution.
fn thermostat() -> Drawn {
    let kt = 0.2;
    let statistics = WarmWells { gamma: 0.5, kt }
        .ensemble::<Baoab>(0.3)
        .starts(|draw| State::new([if draw.path() % 2 == 0 { -1.0 } else { 1.0 }], [0.0]))
        .paths(40_000)
        .seed(7)
        .until(60.0)
        .observe("q", |state| state.q[0])
        .histogram("q", -2.5, 2.5, 60)
        .quiet()
        .run()?;
    let weight = |q: f64| (-0.25 * (q * q - 1.0).powi(2) / kt).exp();
    let places = (0..=500).map(|k| -2.5 + 0.01 * f64::from(k));
    let total = places.clone().map(|q| 0.01 * weight(q)).sum::<f64>();
    let mut figure = statistics.plot().histogram("q")?;
    figure.title = "Two wells in a heat bath, kT = 0.2: density of the position".into();
    for series in &mut figure.series {
        (series.look, series.name) = (Look::Dots, "Baoab, h = 0.3".into());
    }
    Ok(figure.line("Boltzmann distribution", Colour::GREY, places.map(|q| (q, weight(q) / total))))
}

/// Period doublings and chaos of a driven pendulum.
fn sweep() -> Drawn {
    let amplitude = |k: u64| 1.3 + 0.25 * k as f64 / 599.0;
    let period = 1.5 * TAU;
    let sweep = Driven { amplitude: 0.0 }
        .ensemble::<Verlet>(period / 100.0)
        .systems(|draw| Driven { amplitude: amplitude(draw.path()) })
        .start(State::new([0.2], [0.0]))
        .paths(600)
        .until(300.0 * period)
        .record_every(100)
        .observe("velocity", |state| state.p[0])
        .keep_paths(1 << 26)
        .quiet()
        .run()?;
    let mut figure = sweep.plot().sweep("velocity", 100, amplitude)?;
    figure.title = "Driven pendulum: velocity once per period".into();
    figure.x.label = "amplitude of the drive".into();
    Ok(figure)
}

/// Strong error against the step.
fn order_noise() -> Drawn {
    let title = "Kubo oscillator to t = 1: root mean square error over 100 paths";
    Ok(Figure::panel(title, "step size h", "error of (q, p)")
        .log_log()
        .points(Look::Joined, "Uncorrected<DeltaPlus>", 0, strong::<Uncorrected<DeltaPlus>>()?)
        .points(Look::Joined, "Corrected<DeltaPlus>", 1, strong::<Corrected<DeltaPlus>>()?)
        .points(Look::Joined, "Mixed<DeltaPlus, Midpoint>", 2, strong::<Mixed<DeltaPlus, Midpoint>>()?)
        .points(Look::Joined, "Midpoint", 3, strong::<Midpoint>()?)
        .slope("order 1", 1.0, 0.3, [2f64.powi(-9), 0.25]))
}

/// The distance from the Stratonovich solution on a Wiener path.
fn strong<E>() -> Result<Vec<(f64, f64)>, wzvi::Error>
where
    Kubo: Discretized<E, Vector = SVector<f64, 1>>,
{
    distances::<E, _>(|path| Wiener::seed(7).path(path), |noise| noise.value(0, 1.0))
}

/// Root mean square distances at t = 1 from the rotation by `a + σ w`, over 100 paths, for each step size.
fn distances<E, N: wzvi::increments::Noise>(
    noise: impl Fn(u64) -> N,
    w: impl Fn(&mut N) -> Result<f64, wzvi::error::NoiseError>,
) -> Result<Vec<(f64, f64)>, wzvi::Error>
where
    Kubo: Discretized<E, Vector = SVector<f64, 1>>,
{
    let kubo = Kubo { a: 1.5, sigma: 1.0 };
    let mut points = Vec::new();
    for k in 2..=9 {
        let h = 2f64.powi(-k);
        let mut sum = 0.0;
        for path in 0..100 {
            let mut noise = noise(path);
            let angle = kubo.a + kubo.sigma * w(&mut noise)?;
            let run = kubo.simulate::<E>(h).start(State::new([0.0], [1.0])).noise(noise).until(1.0);
            let path = run.record_every(0).run()?;
            let (q, p) = (path.last().q[0] - angle.sin(), path.last().p[0] - angle.cos());
            sum += q * q + p * p;
        }
        points.push((h, (sum / 100.0).sqrt()));
    }
    Ok(points)
}

/// Kicks between steps of free flight: the standard map at K = 0.97.
fn standard_map() -> Drawn {
    let mut figure = Figure::panel("Standard map, K = 0.97: a kick after each step", "q", "p").equal_axes();
    for orbit in 0..60 {
        let mut stepper = Rotor.stepper::<Verlet>(1.0)?;
        let part = f64::from(orbit) / 60.0;
        let mut state: SystemState<Rotor> = State::new([TAU * (7.0 * part).fract()], [TAU * part]);
        let mut points = Vec::new();
        for _ in 0..800 {
            state.p[0] += 0.97 * state.q[0].sin();
            stepper.step(&mut state, &[])?;
            points.push((state.q[0].rem_euclid(TAU), state.p[0].rem_euclid(TAU)));
        }
        figure = figure.points(Look::FineDots, "", orbit as usize % 6, points);
    }
    Ok(figure.x_range(0.0..TAU).y_range(0.0..TAU))
}

/// What more paths buy: the standard error of a mean.
fn paths() -> Drawn {
    let kubo = Kubo { a: 1.5, sigma: 1.0 };
    let (mut found, mut off) = (Vec::new(), Vec::new());
    let exact = (-0.5f64).exp() * 1.5f64.sin();
    for k in 4..=16 {
        let run = kubo.ensemble::<Midpoint>(0.02).start(State::new([0.0], [1.0])).paths(1 << k).seed(7);
        let run = run.until(1.0).observe("q", |state| state.q[0]).quiet().run()?;
        let paths = f64::from(1u32 << k);
        found.push((paths, run.standard_error("q")?));
        off.push((paths, (run.mean("q")? - exact).abs()));
    }
    Ok(Figure::panel("Kubo oscillator: error of the mean of q at t = 1", "number of paths", "error")
        .log_log()
        .points(Look::Joined, "standard error", Colour::BLUE, found)
        .points(Look::Marks, "distance from the exact mean", Colour::VERMILION, off)
        .slope("1/√paths", -0.5, 0.7, [10.0, 1e5]))
}

/// A failed run: the energy for steps that are too long, up to the alarm.
fn unresolved() -> Drawn {
    let start = State::new([1.9, 0.0], [0.0, (0.1f64 / 1.9).sqrt()]);
    let mut figure = Figure::panel(
        "Kepler, e = 0.9, by Midpoint: relative change of the energy",
        "time t",
        "relative change of H",
    )
    .log_y()
    .y_range(1e-8..100.0);
    for (colour, h) in [0.001, 0.01, 0.1].into_iter().enumerate() {
        let (path, error) = Kepler.simulate::<Midpoint>(h).start(start).until(30.0).run_partial()?;
        let first = Kepler.energy(&start);
        let change = path.iter().skip(1).map(|state| (state.t, (Kepler.energy(state) / first - 1.0).abs()));
        let change = change.collect::<Vec<_>>();
        let ends = if error.is_some() { "refused" } else { "accepted" };
        figure = figure.line(format!("h = {h}, {ends}"), colour, change);
    }
    Ok(figure)
}

/// The mid-point of a step of H = p²/2 - q³/3 from q = p = 1 against its size: both solutions of a quadratic equation, up to where they meet.
fn branches() -> Figure {
    // m = q + h p/2 + h² m²/4
    let branch = |side: f64| {
        let places = (0..=400).filter_map(move |k| {
            let h = 0.01 + 0.002 * f64::from(k);
            let root = (1.0 - h * h * (1.0 + 0.5 * h)).sqrt();
            (root >= 0.0).then_some((h, 2.0 * (1.0 + side * root) / (h * h)))
        });
        places.collect::<Vec<_>>()
    };
    Figure::panel("Mid-point step of a cubic potential from q = p = 1", "step size h", "mid-point of q")
        .y_range(0.0..12.0)
        .x_range(0.0..1.0)
        .line("continues the state", Colour::BLUE, branch(-1.0))
        .line("another branch", Colour::VERMILION, branch(1.0))
}

/// Kutta's rule of order 4.
struct Kutta;

impl OneStep for Kutta {
    const ORDER: u32 = 4;
    const IS_CONSISTENT: bool = true;

    fn step<S: Scalar>(
        field: &impl StepField<S>,
        [q, p]: [&mut [S]; 2],
        scratch: &mut Scratch<S>,
    ) -> Result<(), StepFailure> {
        let [dq, dp, at_q, at_p, sum_q, sum_p] = scratch.lists(q.len());
        let stages =
            [(0.0, 0.0, 1.0 / 6.0), (0.5, 0.5, 1.0 / 3.0), (0.5, 0.5, 1.0 / 3.0), (1.0, 1.0, 1.0 / 6.0)];
        for (stage, (time, part, weight)) in stages.into_iter().enumerate() {
            for i in 0..q.len() {
                let [last_q, last_p] = if stage == 0 { [q[i] * 0.0, p[i] * 0.0] } else { [dq[i], dp[i]] };
                (at_q[i], at_p[i]) = (q[i] + last_q * part, p[i] + last_p * part);
            }
            field.at(time, [at_q, at_p], [dq, dp]);
            for i in 0..q.len() {
                let [before_q, before_p] = if stage == 0 { [q[i], p[i]] } else { [sum_q[i], sum_p[i]] };
                (sum_q[i], sum_p[i]) = (before_q + dq[i] * weight, before_p + dp[i] * weight);
            }
        }
        q.copy_from_slice(sum_q);
        p.copy_from_slice(sum_p);
        Ok(())
    }
}

/// Energies of a Kepler orbit at equal cost, 1000 forces per period.
fn drift() -> Drawn {
    Ok(Figure::panel(
        "Kepler, e = 0.5, 1000 forces per orbit: largest change of the energy",
        "orbits",
        "relative change",
    )
    .log_log()
    .line("Kutta's rule, order 4", Colour::VERMILION, energies::<Own<Kutta>>(250)?)
    .line("Verlet", Colour::GREEN, energies::<Verlet>(1000)?)
    .line("Verlet by KahanLi8", Colour::BLUE, energies::<Composed<Verlet, KahanLi8>>(59)?))
}

/// The axis of a heavy top that is pushed back, let go, and pushed on.
fn top() -> Drawn {
    let body = RigidBody::new([1.0, 1.0, 0.5])?;
    let attitude = Rotation3::from_axis_angle(&Vector3::x_axis(), 0.7);
    let edge = (0..=360).map(|k| (f64::from(k) * TAU / 360.0).sin_cos());
    let mut figure = Figure::panel("The axis of a top from above, Rattle, h = 0.01", "x", "y")
        .equal_axes()
        .points(Look::Dashed, "unit sphere", Colour::GREY, edge);
    for (name, colour, precession) in [
        ("pushed back", Colour::VERMILION, -0.4),
        ("let go", Colour::BLUE, 0.0),
        ("pushed on", Colour::GREEN, 0.12),
    ] {
        let velocity = attitude.inverse() * Vector3::new(0.0, 0.0, precession) + Vector3::new(0.0, 0.0, 8.0);
        let start = body.state(attitude, velocity);
        let path = Top { d: body.masses() }.simulate::<Rattle>(0.01).start(start).until(7.0).run()?;
        figure = figure.line(name, colour, path.iter().map(|state| (state.q[2], state.q[5])));
    }
    Ok(figure)
}

/// Burrau's problem: the steps follow the distance of the closest pair.
fn burrau() -> Drawn {
    let system = Encounter { m: [3.0, 4.0, 5.0] };
    let start = State::new([1.0, 3.0, -2.0, -1.0, 1.0, -1.0], [0.0; 6]);
    let path = system.simulate::<Clocked<Gauss<8>>>(Eps(0.2)).start(start).until(63.0).run()?;
    let nearest = |q: &SVector<f64, 6>| {
        let distance = |i: usize, j: usize| (q[2 * i] - q[2 * j]).hypot(q[2 * i + 1] - q[2 * j + 1]);
        distance(0, 1).min(distance(1, 2)).min(distance(2, 0))
    };
    let title = "Burrau's three bodies, Clocked<Gauss<8>>, Eps(0.2)";
    Ok(Figure::panel(title, "time t", "step h, distance of the closest pair")
        .log_y()
        .line("distance", Colour::GREY, path.iter().map(|state| (state.t, nearest(&state.q))))
        .line("step", Colour::BLUE, path.intervals().iter().map(|step| (step.t, step.h))))
}

/// A ring of spins in two kinds of canonical variables.
fn spins() -> Drawn {
    let angles: Vec<f64> = (0..8).map(|i| 0.8 * f64::from(i)).collect();
    let heights: Vec<f64> = (0..8).map(|i| 0.7 * (1.3 * f64::from(i) + 0.4).sin()).collect();
    let lifted = angles.iter().zip(&heights).map(|(angle, height)| {
        let [first, second] = [1.0 + height, 1.0 - height].map(|square| (2.0 * square).sqrt());
        ([first, second * angle.cos()], [0.0, second * angle.sin()])
    });
    let (q, p): (Vec<_>, Vec<_>) = lifted.unzip();
    let (h, end) = (0.05, 200.0);
    let oscillators = SpinRing.simulate::<Midpoint>(h).start(State::new(q, p)).until(end).run()?;
    // Until a step near a pole has no solution.
    let mut stepper = AngleRing.stepper::<Midpoint>(h)?;
    let mut state = State::new(angles, heights);
    let first = AngleRing.energy(&state);
    let mut by_angles = Vec::new();
    while state.t < end && stepper.step(&mut state, &[]).is_ok() {
        by_angles.push((state.t, AngleRing.energy(&state) - first));
    }
    let first = SpinRing.energy(&oscillators.states()[0]);
    let by_oscillators = oscillators.iter().skip(1).map(|state| (state.t, SpinRing.energy(state) - first));
    Ok(Figure::panel("Ring of eight spins, Midpoint, h = 0.05: angles end at a pole", "time t", "H - H(0)")
        .line("angle and height", Colour::VERMILION, by_angles)
        .line("two oscillators", Colour::BLUE, by_oscillators))
}

/// The largest relative change of the energy so far, over 1000 orbits in so many steps each.
fn energies<E>(steps: u32) -> Result<Vec<(f64, f64)>, wzvi::Error>
where
    Kepler: Discretized<E, Vector = SVector<f64, 2>>,
{
    let start = State::new([0.5, 0.0], [0.0, 3f64.sqrt()]);
    let run =
        Kepler.simulate::<E>(TAU / f64::from(steps)).start(start).steps(1000 * u64::from(steps)).unwatched();
    let path = run.record_every(7).run()?;
    let (first, mut largest) = (Kepler.energy(&start), 0.0f64);
    let mut points: Vec<(f64, f64)> = Vec::new();
    for state in path.iter().skip(1) {
        largest = largest.max((Kepler.energy(state) / first - 1.0).abs());
        let orbits = state.t / TAU;
        if points.last().is_none_or(|last| orbits > 1.02 * last.0) {
            points.push((orbits, largest));
        }
    }
    Ok(points)
}

/// Error against time of explicit schemes on a chain.
fn order_chain() -> Drawn {
    // All modes have energy: multiples of the golden section.
    let start = || {
        let momentum = |i: usize| (0.618_033_988_749_894_9 * i as f64).fract() - 0.5;
        State::new(vec![0.0; 128], (0..128).map(momentum).collect::<Vec<_>>())
    };
    let chain = Chain { alpha: 0.25 };
    let exact = chain
        .simulate::<Composed<Verlet, KahanLi8>>(0.0125)
        .start(start())
        .until(20.0)
        .record_every(0)
        .run()?;
    let exact = &exact.last().q;
    Ok(Figure::panel(
        "Chain of 128 sites to t = 20: error against time",
        "time of a run [µs]",
        "largest error of q",
    )
    .log_log()
    .points(Look::Joined, "Verlet, order 2", 0, chain_cost::<Verlet>(&chain, &start(), exact, 7)?)
    .points(Look::Joined, "Suzuki4", 1, chain_cost::<Composed<Verlet, Suzuki4>>(&chain, &start(), exact, 6)?)
    .points(
        Look::Joined,
        "BlanesMoan4",
        2,
        chain_cost::<Composed<Verlet, BlanesMoan4>>(&chain, &start(), exact, 6)?,
    )
    .points(
        Look::Joined,
        "BlanesMoan6",
        3,
        chain_cost::<Composed<Verlet, BlanesMoan6>>(&chain, &start(), exact, 5)?,
    )
    .points(
        Look::Joined,
        "KahanLi8",
        4,
        chain_cost::<Composed<Verlet, KahanLi8>>(&chain, &start(), exact, 5)?,
    ))
}

fn chain_cost<E>(
    chain: &Chain,
    start: &State<DVector<f64>>,
    exact: &DVector<f64>,
    halvings: i32,
) -> Result<Vec<(f64, f64)>, wzvi::Error>
where
    Chain: Discretized<E, Vector = DVector<f64>>,
{
    let mut points = Vec::new();
    for k in 0..halvings {
        let (mut best, mut error) = (f64::INFINITY, f64::NAN);
        for _ in 0..5 {
            let run =
                chain.simulate::<E>(0.5 * 2f64.powi(-k)).start(start.clone()).until(20.0).record_every(0);
            let began = Instant::now();
            let path = run.run()?;
            best = best.min(began.elapsed().as_secs_f64());
            error = (&path.last().q - exact).amax();
        }
        points.push((1e6 * best, error));
    }
    Ok(points)
}

/// The exact variances of thermostats in a harmonic well: of `q` as lines, of `p` dashed.
fn order_bath() -> Figure {
    fn variances<W: Letters>(figure: Figure, look: Look, name: &str, colour: usize) -> Figure {
        let laws = || (1..=180).map(|k| 0.01 * f64::from(k)).map(|h| (h, HarmonicLaw::of::<W>(h, h)));
        let dashed = if look == Look::Line { Look::Dashed } else { look };
        figure.points(look, name, colour, laws().map(|(h, law)| (h, law.q))).points(
            dashed,
            "",
            colour,
            laws().map(|(h, law)| (h, law.p)),
        )
    }
    let title = "Harmonic well, γ = ω: variances of q (solid) and p (dashed)";
    let figure = Figure::panel(title, "ω h", "variance over the exact one").y_range(0.0..3.0);
    let figure = variances::<(B, A, O, A)>(figure, Look::Broad, "(B, A, O, A)", Colour::GREY);
    let figure = variances::<(B, A, O, A, B)>(figure, Look::Line, "Baoab", Colour::BLUE);
    let figure = variances::<(O, B, A, B, O)>(figure, Look::Line, "Obabo", Colour::VERMILION);
    let figure = variances::<(A, O, B, O, A)>(figure, Look::Line, "(A, O, B, O, A)", Colour::GREEN);
    variances::<(B, O, A, O, B)>(figure, Look::Line, "(B, O, A, O, B)", Colour::PURPLE)
}
