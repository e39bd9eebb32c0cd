//! How much error for how much time, for every scheme of high order.
//!
//! `cargo bench --bench order` first times `Gauss<S>` against steps written by hand for one system ([`by_hand`]), then measures all
//! schemes on five systems: a table each, and one page, `target/wzvi/order/index.html`, with error against time and against
//! evaluations of the force. `-- pendulum kepler` measures these only, `-- hand` the first part only, `-- brouwer` how
//! rounding grows over a million steps; `-- --overlay pendulum=points.csv` lays points of other programs (name, seconds, error) over a figure.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a benchmark talks, and stops at the first error"
)]

mod by_hand;
mod scenes;

use std::path::Path;
use std::time::Instant;

use by_hand::{Coefficients, Force};
use scenes::{Scene, distance};
use wzvi::nalgebra::SVector;
use wzvi::prelude::*;
use wzvi::report::{Axis, Document, Figure, Look, Machine, Overlay, Series, duration};

/// No run takes longer, in seconds.
const LONGEST: f64 = 0.5;
/// Repetitions of a run, of which the fastest counts.
const REPETITIONS: usize = 5;
/// Errors that tables ask for.
const WANTED: [f64; 4] = [1e-3, 1e-6, 1e-9, 1e-12];

/// One run of a scheme.
struct Point {
    steps: u32,
    error: f64,
    seconds: f64,
    evaluations: f64,
}

/// All runs of one scheme.
struct Curve {
    scheme: String,
    points: Vec<Point>,
}

/// Runs a scheme with more and more steps. Evaluations of the force per step: `explicit`, or `stages` for each iteration.
fn curve<E, H: Discretized<E>>(
    scene: &Scene<H>,
    scheme: impl Into<String>,
    [explicit, stages]: [usize; 2],
) -> Curve {
    let mut points: Vec<Point> = vec![];
    let mut steps = scene.fewest;
    loop {
        let point = run::<E, H>(scene, steps, [explicit, stages]);
        let seconds = point.as_ref().map_or(0.0, |point| point.seconds);
        // Rounding: more steps leave more of it.
        let is_floor = matches!((&point, points.last()), (Some(a), Some(b)) if b.error < 1e-9 && a.error > 0.7 * b.error);
        points.extend(point);
        if is_floor || 1.5 * seconds > LONGEST || steps > 1 << 27 {
            return Curve { scheme: scheme.into(), points };
        }
        steps += steps / 2;
    }
}

/// One run, `None` where a step fails.
fn run<E, H: Discretized<E>>(scene: &Scene<H>, steps: u32, [explicit, stages]: [usize; 2]) -> Option<Point> {
    let mut fastest = f64::INFINITY;
    let mut last = None;
    for repetition in 0..REPETITIONS {
        let mut stepper = scene.system.stepper::<E>(scene.end / f64::from(steps)).ok()?;
        let (mut state, mut evaluations) = (scene.start.clone(), 0);
        let clock = Instant::now();
        for _ in 0..steps {
            let iterations = stepper.step(&mut state, &[]).ok()?.iterations;
            evaluations += explicit + stages * iterations as usize;
        }
        fastest = fastest.min(clock.elapsed().as_secs_f64());
        last = Some((distance(&state, &scene.exact), evaluations as f64));
        if fastest > 0.1 * LONGEST && repetition > 0 {
            break;
        }
    }
    let (error, evaluations) = last?;
    Some(Point { steps, error, seconds: fastest, evaluations })
}

/// Every scheme on one system.
macro_rules! measure {
    ($scene:expr) => {{
        let scene = $scene;
        vec![
            curve::<Midpoint, _>(scene, "Midpoint", [0, 1]),
            curve::<Verlet, _>(scene, "Verlet", [1, 0]),
            curve::<Composed<Verlet, Suzuki4>, _>(scene, "Composed<Verlet, Suzuki4>", [5, 0]),
            curve::<Composed<Verlet, Yoshida4>, _>(scene, "Composed<Verlet, Yoshida4>", [3, 0]),
            curve::<Composed<Verlet, BlanesMoan4>, _>(scene, "Composed<Verlet, BlanesMoan4>", [6, 0]),
            curve::<Composed<Verlet, Yoshida6>, _>(scene, "Composed<Verlet, Yoshida6>", [7, 0]),
            curve::<Composed<Verlet, KahanLi6>, _>(scene, "Composed<Verlet, KahanLi6>", [9, 0]),
            curve::<Composed<Verlet, BlanesMoan6>, _>(scene, "Composed<Verlet, BlanesMoan6>", [10, 0]),
            curve::<Composed<Verlet, KahanLi8>, _>(scene, "Composed<Verlet, KahanLi8>", [17, 0]),
            curve::<Composed<Verlet, SuzukiUmeno8>, _>(scene, "Composed<Verlet, SuzukiUmeno8>", [15, 0]),
            curve::<Gauss<2>, _>(scene, "Gauss<2>", [0, 2]),
            curve::<Gauss<4>, _>(scene, "Gauss<4>", [0, 4]),
            curve::<Gauss<6>, _>(scene, "Gauss<6>", [0, 6]),
            curve::<Gauss<8>, _>(scene, "Gauss<8>", [0, 8]),
            curve::<Gauss<16>, _>(scene, "Gauss<16>", [0, 16]),
        ]
    }};
}

/// For each error that is wanted the fastest run that reaches it: time, steps, evaluations.
fn table(curves: &[Curve]) -> (Vec<String>, Vec<Vec<String>>) {
    let headings = ["scheme".to_owned()].into_iter().chain(WANTED.map(|wanted| format!("{wanted:.0e}")));
    let row = |curve: &Curve| {
        let cell = |wanted: f64| {
            let reached = curve.points.iter().filter(|point| point.error <= wanted);
            reached.min_by(|a, b| a.seconds.total_cmp(&b.seconds)).map_or("-".to_owned(), |point| {
                format!("{} ({}, {:.1e})", duration(point.seconds), point.steps, point.evaluations)
            })
        };
        [curve.scheme.clone()].into_iter().chain(WANTED.map(cell)).collect()
    };
    (headings.collect(), curves.iter().map(row).collect())
}

fn figure<H: Hamiltonian>(
    scene: &Scene<H>,
    curves: &[Curve],
    overlay: &[Overlay],
    by_evaluations: bool,
) -> Figure {
    let (id, what) =
        if by_evaluations { ("evaluations", "evaluations of the force") } else { ("time", "seconds") };
    let axes = (Axis::logarithmic(what), Axis::logarithmic("relative error at the end"));
    let mut figure = Figure::new(
        format!("{}-{id}", scene.name),
        format!("{}: error against {what}", scene.title),
        axes.0,
        axes.1,
    )
    .shows("Further left and lower is better.");
    for (colour, curve) in curves.iter().enumerate() {
        let at =
            |point: &Point| (if by_evaluations { point.evaluations } else { point.seconds }, point.error);
        let mut series =
            Series::new(&curve.scheme, Look::Joined, colour, curve.points.iter().map(at).collect());
        series.notes = curve.points.iter().map(|point| format!("{} steps", point.steps)).collect();
        figure = figure.with(series);
    }
    for (more, point) in overlay.iter().enumerate() {
        let colour = curves.len() + more;
        let at = vec![(point.seconds, point.error)];
        figure = figure.with(Series::new(format!("{} (elsewhere)", point.name), Look::Marks, colour, at));
    }
    figure
}

/// Measures a system, prints its table, and adds it to the page.
fn show<H: Hamiltonian>(page: Document, scene: &Scene<H>, curves: &[Curve], overlay: &[Overlay]) -> Document {
    let (headings, rows) = table(curves);
    println!(
        "\n{}\nfastest run with an error of at most: time (steps, evaluations of the force)\n",
        scene.title
    );
    for row in [&headings].into_iter().chain(&rows) {
        println!("{:32}{}", row[0], row[1..].iter().map(|cell| format!("{cell:>28}")).collect::<String>());
    }
    page.heading(scene.title)
        .table("Fastest run with an error of at most: time (steps, evaluations of the force)", headings, rows)
        .figure(figure(scene, curves, overlay, false))
        .figure(figure(scene, curves, &[], true))
}

/// `Gauss<S>` against the same by hand, in turns.
fn beside<E, F: Force<D>, H, const D: usize, const S: usize>(
    name: &str,
    scene: &Scene<H>,
    steps: u32,
    unit: f64,
) where
    H: Discretized<E, Vector = SVector<f64, D>>,
{
    let coefficients = Coefficients::<S>::new();
    let h = scene.end / f64::from(steps);
    let (q, p): ([f64; D], [f64; D]) = (scene.start.q.into(), scene.start.p.into());
    let (mut ours, mut by_hand) = ([f64::INFINITY, 0.0, 0.0], [f64::INFINITY, 0.0, 0.0]);
    let per_step = |sweeps: u64| sweeps as f64 / f64::from(steps);
    for _ in 0..60 {
        let mut stepper = scene.system.stepper::<E>(h).unwrap();
        let (mut state, mut sweeps) = (scene.start, 0);
        let clock = Instant::now();
        for _ in 0..steps {
            sweeps += u64::from(stepper.step(&mut state, &[]).unwrap().iterations);
        }
        let seconds = clock.elapsed().as_secs_f64();
        ours = [ours[0].min(seconds), per_step(sweeps), distance(&state, &scene.exact)];
        let clock = Instant::now();
        let (q, p, sweeps) = by_hand::run::<F, D, S>(&coefficients, std::hint::black_box([q, p]), h, steps);
        let seconds = clock.elapsed().as_secs_f64();
        by_hand = [by_hand[0].min(seconds), per_step(sweeps), distance(&State::new(q, p), &scene.exact)];
    }
    for (who, [seconds, sweeps, error]) in [("Gauss", ours), ("by hand", by_hand)] {
        let ratio = seconds / by_hand[0];
        println!(
            "{name:24}{who:10}{:>12.2}{:>10.1}{sweeps:>9.2}{error:>11.1e}{ratio:>8.2}",
            seconds * 1e9 * unit / scene.end,
            seconds * 1e9 / f64::from(steps),
        );
    }
}

fn hand() {
    let fused = if cfg!(target_feature = "fma") { "with" } else { "without" };
    println!(
        "Gauss<S> against the same loop written by hand, which is built {fused} fused products and sums\n"
    );
    println!("{:34}{:>12}{:>10}{:>9}{:>11}{:>8}", "", "ns/unit", "ns/step", "sweeps", "error", "ratio");
    let (pendulum, kepler) = (scenes::pendulum(), scenes::kepler());
    let orbit = 2.0 * std::f64::consts::PI;
    beside::<Gauss<8>, by_hand::Pendulum, _, 1, 8>("pendulum, S = 8, 0.1", &pendulum, 100, 0.1);
    beside::<Gauss<8>, by_hand::Pendulum, _, 1, 8>("pendulum, S = 8, 0.1", &pendulum, 180, 0.1);
    beside::<Gauss<16>, by_hand::Pendulum, _, 1, 16>("pendulum, S = 16, 0.1", &pendulum, 40, 0.1);
    beside::<Gauss<16>, by_hand::Pendulum, _, 1, 16>("pendulum, S = 16, 0.1", &pendulum, 50, 0.1);
    beside::<Gauss<8>, by_hand::Kepler, _, 2, 8>("Kepler, S = 8, orbit", &kepler, 5000, orbit);
    beside::<Gauss<16>, by_hand::Kepler, _, 2, 16>("Kepler, S = 16, orbit", &kepler, 1500, orbit);
}

/// Brouwer's law: a million steps of `Gauss<8>`, short enough that rounding is all of the error, from a hundred ellipses that are turned against
/// each other, in steps that are no part of the period. The error of the energy is that of a random walk if its mean is zero within
/// three standard errors, and its spread grows like the square root of the number of steps.
fn brouwer() {
    const STARTS: u32 = 100;
    let (h, e) = (0.0617, 0.5_f64);
    let nodes = [10_000, 100_000, 1_000_000];
    let mut drifts = [const { Vec::new() }; 3];
    for start in 0..STARTS {
        let (sin, cos) = (2.0 * std::f64::consts::PI * f64::from(start) / f64::from(STARTS)).sin_cos();
        let speed = ((1.0 + e) / (1.0 - e)).sqrt();
        let mut state = State::new([(1.0 - e) * cos, (1.0 - e) * sin], [-speed * sin, speed * cos]);
        let energy = scenes::Kepler.energy(&state);
        let mut stepper = scenes::Kepler.stepper::<Gauss<8>>(h).unwrap().compensated();
        let mut taken = 0;
        for (node, drifts) in nodes.into_iter().zip(&mut drifts) {
            while taken < node {
                stepper.step(&mut state, &[]).unwrap();
                taken += 1;
            }
            drifts.push((scenes::Kepler.energy(&state) - energy) / energy.abs());
        }
    }
    println!("\nBrouwer's law: relative error of the energy, Kepler e = 0.5, Gauss<8>, {STARTS} starts\n");
    println!("{:>10}{:>14}{:>18}{:>14}", "steps", "mean", "standard error", "spread");
    for (steps, drifts) in nodes.into_iter().zip(&drifts) {
        let number = f64::from(STARTS);
        let mean = drifts.iter().sum::<f64>() / number;
        let variance = drifts.iter().map(|drift| (drift - mean).powi(2)).sum::<f64>() / (number - 1.0);
        println!("{steps:>10}{mean:>14.2e}{:>18.2e}{:>14.2e}", (variance / number).sqrt(), variance.sqrt());
    }
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    let mut wanted: Vec<&str> = vec![];
    let mut overlays: Vec<(&str, &str)> = vec![];
    let mut rest = arguments.iter().map(String::as_str);
    while let Some(argument) = rest.next() {
        match argument {
            "--overlay" => overlays.extend(rest.next().and_then(|pair| pair.split_once('='))),
            scene => wanted.push(scene),
        }
    }
    let is_wanted = |name: &str| wanted.is_empty() || wanted.contains(&name);
    let overlay = |name: &str| -> Vec<Overlay> {
        let files = overlays.iter().filter(|(scene, _)| *scene == name);
        files.flat_map(|(_, path)| Overlay::read(Path::new(path)).unwrap()).collect()
    };
    if is_wanted("hand") {
        hand();
    }
    if wanted.contains(&"brouwer") {
        brouwer();
    }
    let mut page = Document::new("Error against time, by schemes of high order").text(Machine::here().line());
    let mut is_empty = true;
    macro_rules! scenes {
        ($($scene:ident),*) => {$(
            if is_wanted(stringify!($scene)) {
                let scene = scenes::$scene();
                page = show(page, &scene, &measure!(&scene), &overlay(stringify!($scene)));
                is_empty = false;
            }
        )*};
    }
    scenes!(pendulum, kepler, henon_heiles, solar_system, fput);
    if !is_empty {
        page.write("target/wzvi/order").unwrap();
        println!("\ntarget/wzvi/order/index.html");
    }
}
