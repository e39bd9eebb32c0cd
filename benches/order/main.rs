//! How much error for how much time, for every scheme of high order.
//!
//! `cargo bench --workspace --bench order` measures all schemes on five systems: a table each, and one page, `target/wzvi/order/index.html`, with error
//! against time and against evaluations of the force. `-- pendulum kepler` measures these only; `-- --overlay pendulum=points.csv` lays
//! points of other programs (name, seconds, error) over a figure.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a benchmark talks, and stops at the first error"
)]

mod scenes;

use std::path::Path;
use std::time::Instant;

use scenes::{Scene, distance};
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
            curve::<Composed<Verlet, Srkn6>, _>(scene, "Composed<Verlet, Srkn6>", [14, 0]),
            // The kernel takes the slope of |V'|², about one more force.
            curve::<Composed<Verlet, Chin4>, _>(scene, "Composed<Verlet, Chin4>", [3, 0]),
            curve::<Composed<Midpoint, Yoshida4>, _>(scene, "Composed<Midpoint, Yoshida4>", [0, 1]),
            curve::<Composed<Midpoint, KahanLi8>, _>(scene, "Composed<Midpoint, KahanLi8>", [0, 1]),
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
        page.write(concat!(env!("CARGO_MANIFEST_DIR"), "/../target/wzvi/order")).unwrap();
        println!("\ntarget/wzvi/order/index.html");
    }
}
