//! The pictures of the README and of the guide, into `docs/pictures` or the folder that is given.
//!
//! Run with `cargo run --release --features plot --example gallery`; `-- target/pictures` draws them somewhere else.

mod guide;
mod systems;

use std::error::Error;
use std::f64::consts::PI;
use std::path::{Path, PathBuf};
use std::time::Instant;

use systems::{Bodies, Chain, DoubleWell, HenonHeiles, Kepler, Kubo, Pendulum};
use wzvi::nalgebra::SVector;
use wzvi::plot::{Colour, Figure, Look, Sheet};
use wzvi::prelude::*;

type Drawn = Result<Figure, Box<dyn Error>>;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).map_or_else(|| PathBuf::from("docs/pictures"), PathBuf::from);
    save(&folder, "kubo", kubo()?)?;
    save(&folder, "pendulum", pendulum()?)?;
    save(&folder, "henon_heiles", henon_heiles()?)?;
    save(&folder, "chaos_map", chaos_map()?)?;
    save(&folder, "kepler", kepler()?)?;
    save(&folder, "eight", eight()?)?;
    save(&folder, "chain", chain()?)?;
    save(&folder, "wells", wells()?)?;
    save(&folder, "order", order()?)?;
    for (name, figure) in guide::figures()? {
        save(&folder, name, figure)?;
    }
    Ok(())
}

fn save(folder: &Path, name: &str, figure: Figure) -> Result<(), Box<dyn Error>> {
    let file = folder.join(format!("{name}.png"));
    Sheet::new(1, (960, 720)).with(figure).write(&file)?;
    println!("{}", file.display());
    Ok(())
}

/// One Wiener path, three answers: the step without correction follows another system.
fn kubo() -> Drawn {
    let kubo = Kubo { a: 1.5, sigma: 1.0 };
    let (h, noise) = (0.02, Wiener::seed(7));
    let start = State::new([0.0], [1.0]);
    let right = kubo.simulate::<Midpoint>(h).start(start).noise(noise.clone()).until(20.0).run()?;
    let wrong = kubo.simulate::<Uncorrected<DeltaPlus>>(h).start(start).noise(noise).until(20.0).run()?;
    let times = right.times().zip(right.wiener(0));
    let exact = times.map(|(t, w)| (t, (kubo.a * t + kubo.sigma * w).sin()));
    let curve =
        |path: &[State<SVector<f64, 1>>]| path.iter().map(|state| (state.t, state.q[0])).collect::<Vec<_>>();
    Ok(Figure::panel("Kubo oscillator: one path of the noise", "time t", "q")
        .points(Look::Broad, "exact", Colour::GREY, exact)
        .line("Midpoint", Colour::BLUE, curve(right.states()))
        .line("Uncorrected<DeltaPlus>", Colour::VERMILION, curve(wrong.states())))
}

/// Swings and rotations, a run each.
fn pendulum() -> Drawn {
    let mut figure = Figure::panel("Pendulum: phase portrait", "angle [rad]", "momentum").x_range(-PI..PI);
    let swings = (1..=6).map(|k| State::new([0.5 * f64::from(k)], [0.0]));
    let rotations = [2.1, 2.4, -2.1, -2.4].map(|p: f64| State::new([-PI.copysign(p)], [p]));
    for (start, colour) in swings.map(|s| (s, Colour::BLUE)).chain(rotations.map(|s| (s, Colour::VERMILION)))
    {
        let path = Pendulum.simulate::<Midpoint>(0.02).start(start).until(20.0).run()?;
        figure = figure.line("", colour, path.iter().map(|state| (state.q[0], state.p[0])));
    }
    Ok(figure)
}

/// Order beside chaos at one energy: crossings of x = 0.
fn henon_heiles() -> Drawn {
    const ENERGY: f64 = 0.125;
    let mut figure = Figure::panel("Hénon-Heiles: section x = 0, px > 0, at E = 1/8", "y", "py");
    for (colour, y) in [-0.25, -0.1, 0.0, 0.15, 0.3, 0.45].into_iter().enumerate() {
        let start = State::new([0.0, y], [(2.0 * ENERGY - y * y + 2.0 * y * y * y / 3.0).sqrt(), 0.0]);
        let run = HenonHeiles.simulate::<Gauss<8>>(0.25).start(start).until(6000.0).record_every(0);
        let path = run.section_towards(wzvi::section::Direction::Rising, |state| state.q[0]).run()?;
        let section = path.crossings().iter().map(|crossing| (crossing.state.q[1], crossing.state.p[1]));
        figure = figure.points(Look::FineDots, "", colour, section);
    }
    Ok(figure)
}

/// The same section as a map of starts: islands of regular motion, where the mean of MEGNO is 2, in the chaotic sea.
fn chaos_map() -> Drawn {
    const ENERGY: f64 = 0.125;
    const SIDE: usize = 400;
    let place = |k: usize, from: f64, to: f64| from + (to - from) * (k as f64 + 0.5) / SIDE as f64;
    let starts = (0..SIDE * SIDE).filter_map(|k| {
        let (y, py) = (place(k / SIDE, -0.45, 0.7), place(k % SIDE, -0.5, 0.5));
        let square = 2.0 * ENERGY - y * y - py * py + 2.0 * y * y * y / 3.0;
        (square >= 0.0).then(|| State::new([0.0, y], [square.sqrt(), py]))
    });
    let map = HenonHeiles.ensemble::<Verlet>(0.1).starts_from(starts).until(1000.0).indicators()?;
    let mut figure = map.plot().megno("y", "py")?;
    figure.title = "Hénon-Heiles at E = 1/8: mean of MEGNO to t = 1000".into();
    Ok(figure)
}

const ECCENTRICITY: f64 = 0.6;

fn perihelion() -> State<SVector<f64, 2>> {
    State::new([1.0 - ECCENTRICITY, 0.0], [0.0, ((1.0 + ECCENTRICITY) / (1.0 - ECCENTRICITY)).sqrt()])
}

/// The energy of a planet oscillates and comes back.
fn kepler() -> Drawn {
    let path = Kepler.simulate::<Midpoint>(0.02).start(perihelion()).until(60.0).run()?;
    let mut figure = path.plot().energy_drift(&Kepler);
    figure.title = "Kepler, e = 0.6: energy and angular momentum by Midpoint".into();
    Ok(figure)
}

/// Three bodies on one curve (C. Moore, 1993; A. Chenciner, R. Montgomery, 2000).
fn eight() -> Drawn {
    let q = [0.97000436, -0.24308753, -0.97000436, 0.24308753, 0.0, 0.0];
    let v = [0.466203685, 0.43236573, 0.466203685, 0.43236573, -0.93240737, -0.86473146];
    let start = State::new(q.to_vec(), v.to_vec());
    let path = Bodies::<3>.simulate::<Composed<Verlet, KahanLi8>>(0.02).start(start).until(6.4).run()?;
    let mut figure =
        Figure::panel("Three equal masses on a figure eight, a third of a period", "x", "y").equal_axes();
    for body in 0..3 {
        let place = |state: &State<_>| {
            let q: &wzvi::nalgebra::DVector<f64> = &state.q;
            (q[2 * body], q[2 * body + 1])
        };
        // A third of the way each, so that all three colours show.
        let third = path.len() / 3;
        figure = figure.line("", body, path.iter().take(third + 1).map(place));
        figure = figure.points(Look::Dots, "", body, path.iter().skip(third).take(1).map(place));
    }
    Ok(figure)
}

/// The energy of the first mode goes to others and comes back.
fn chain() -> Drawn {
    const SPRINGS: usize = 32;
    let sites = SPRINGS - 1;
    let mode = |k: usize, i: usize| (PI * (k * (i + 1)) as f64 / SPRINGS as f64).sin();
    let start = State::new((0..sites).map(|i| mode(1, i)).collect::<Vec<_>>(), vec![0.0; sites]);
    let run = Chain { alpha: 0.25 }.simulate::<Verlet>(0.1).start(start).until(11_000.0).record_every(100);
    let path = run.run()?;
    let mut figure = Figure::panel("Fermi, Pasta, Ulam, Tsingou: energies of modes", "time t", "energy");
    for k in 1..=4 {
        let omega = 2.0 * (PI * k as f64 / (2.0 * SPRINGS as f64)).sin();
        let energy = path.iter().map(|state| {
            let amplitude = |v: &[f64]| v.iter().enumerate().map(|(i, x)| x * mode(k, i)).sum::<f64>();
            let [a, b] = [amplitude(state.q.as_slice()), amplitude(state.p.as_slice())];
            (state.t, (omega * omega * a * a + b * b) / SPRINGS as f64)
        });
        figure = figure.line(format!("mode {k}"), k - 1, energy.collect::<Vec<_>>());
    }
    Ok(figure)
}

/// Where a hundred thousand particles are, at three times.
fn wells() -> Drawn {
    let statistics = DoubleWell { s: 0.2 }
        .ensemble::<Midpoint>(0.05)
        .start(State::new([-1.0], [0.0]))
        .paths(100_000)
        .seed(7)
        .until(40.0)
        .record_at([2.0, 10.0])
        .observe("q", |state| state.q[0])
        .histogram("q", -2.5, 2.5, 100)
        .quiet()
        .run()?;
    let mut figure = statistics.plot().histogram("q")?;
    figure.title = "Two wells, 100 000 paths: density of the position".into();
    Ok(figure)
}

/// What an error costs by schemes of order 2 to 16.
fn order() -> Drawn {
    let mut figure =
        Figure::panel("Kepler, e = 0.6, ten periods: error against time", "time of a run [µs]", "error of q")
            .log_log()
            .y_range(1e-13..10.0);
    let low = [100, 200, 400, 800, 1600, 3200, 6400];
    figure = figure.points(Look::Joined, "Midpoint, order 2", 0, cost::<Midpoint>(&low)?);
    figure = figure.points(Look::Joined, "Verlet, order 2", 1, cost::<Verlet>(&low)?);
    let eight = cost::<Composed<Verlet, KahanLi8>>(&[25, 50, 100, 200, 400])?;
    figure = figure.points(Look::Joined, "Verlet by KahanLi8, order 8", 2, eight);
    figure = figure.points(Look::Joined, "Gauss<8>, order 16", 3, cost::<Gauss<8>>(&[6, 8, 12, 16, 24, 32])?);
    Ok(figure)
}

/// Time and error of ten periods in so many steps each: the best time of five.
fn cost<E>(steps: &[u32]) -> Result<Vec<(f64, f64)>, wzvi::Error>
where
    Kepler: Discretized<E, Vector = SVector<f64, 2>>,
{
    let start = perihelion();
    let mut points = Vec::new();
    for &each in steps {
        let h = 2.0 * PI / f64::from(each);
        let (mut best, mut error) = (f64::INFINITY, f64::NAN);
        for _ in 0..5 {
            let run = Kepler.simulate::<E>(h).start(start).steps(10 * u64::from(each)).record_every(0);
            let began = Instant::now();
            let path = run.run()?;
            best = best.min(began.elapsed().as_secs_f64());
            error = (path.last().q - start.q).norm();
        }
        points.push((1e6 * best, error));
    }
    Ok(points)
}
