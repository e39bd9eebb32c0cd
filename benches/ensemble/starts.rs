//! A cloud of starts and a sweep over parameters, without noise: what a path and step costs in an ensemble, beside loops written by hand.

use std::hint::black_box;

use wzvi::ensemble::{Draw, InstructionSet};
use wzvi::nalgebra::SVector;
use wzvi::prelude::*;
use wzvi::system::Discretized;

use crate::gauss_by_hand::{self, Coefficients, Force};
use crate::scenes::STEPS;

/// Hénon and Heiles.
#[hamiltonian(
    drift = |[x, y], [u, v]| 0.5 * (u * u + v * v + x * x + y * y) + x * x * y - y * y * y / 3.0,
    embedding = [Verlet, Midpoint, Gauss<8>],
)]
struct HenonHeiles;

/// The same with parameters.
#[hamiltonian(
    drift = |[x, y], [u, v]| 0.5 * (u * u + v * v) + 0.5 * (a * x * x + b * y * y) + c * x * x * y - d * y * y * y / 3.0,
    embedding = [Verlet, Midpoint],
)]
#[derive(Clone, Copy)]
struct Galaxy {
    a: f64,
    b: f64,
    c: f64,
    d: f64,
}

const H: f64 = 0.1;

/// A grid of four parameters.
fn galaxy(path: u64) -> Galaxy {
    let digit = |place: u32| 0.05 * (path / 5_u64.pow(place) % 5) as f64;
    Galaxy { a: 0.9 + digit(0), b: 0.9 + digit(1), c: 0.9 + digit(2), d: 0.9 + digit(3) }
}

/// The mean of `x²` at the end of a sweep.
fn sweep<E>(paths: u64) -> f64
where
    Galaxy: Discretized<E, Vector = SVector<f64, 2>>,
{
    let first = galaxy(0);
    let run =
        first.ensemble::<E>(H).systems(|draw| galaxy(draw.path())).start(State::new([0.1, 0.0], [0.05, 0.1]));
    let run = run.paths(paths).steps(STEPS).threads(1);
    let run = run.observe("x²", |state| state.q[0] * state.q[0]).run().unwrap();
    run.mean("x²").unwrap()
}

/// Starts that a loop by hand makes, too.
fn start(path: u64) -> [f64; 4] {
    let angle = path as f64 * 0.618;
    [0.1 * angle.sin(), 0.1 * angle.cos(), 0.1 * (2.0 * angle).sin(), 0.05]
}

/// The mean of `x²` at the end.
fn ensemble<E>(paths: u64) -> f64
where
    HenonHeiles: Discretized<E, Vector = SVector<f64, 2>>,
{
    let starts = |draw: &mut Draw| {
        let [x, y, u, v] = start(draw.path());
        State::new([x, y], [u, v])
    };
    let run = HenonHeiles.ensemble::<E>(H).starts(starts).paths(paths).steps(STEPS).threads(1);
    let run = run.observe("x²", |state| state.q[0] * state.q[0]).run().unwrap();
    run.mean("x²").unwrap()
}

#[inline(always)]
fn by_hand(
    paths: u64,
    start: impl Fn(u64) -> [f64; 4],
    system: impl Fn(u64) -> Galaxy,
    step: impl Fn(&Galaxy, &mut [f64; 4], &mut [f64; 4]),
) -> f64 {
    let mut sum = 0.0;
    for path in 0..paths {
        let (mut state, system, mut kept) = (black_box(start(path)), system(path), [f64::NAN; 4]);
        (0..STEPS).for_each(|_| step(&system, &mut state, &mut kept));
        sum += state[0] * state[0];
    }
    sum / paths as f64
}

/// `a x²/2 + b y²/2 + c x² y - d y³/3`
fn force(Galaxy { a, b, c, d }: &Galaxy, x: f64, y: f64) -> [f64; 2] {
    [-a * x - 2.0 * c * x * y, -b * y - c * x * x + d * y * y]
}

/// The force of Hénon and Heiles: all four are 1.
const ONE: Galaxy = Galaxy { a: 1.0, b: 1.0, c: 1.0, d: 1.0 };

fn verlet(paths: u64) -> f64 {
    by_hand(paths, start, |_| ONE, verlet_step)
}

fn midpoint(paths: u64) -> f64 {
    by_hand(paths, start, |_| ONE, midpoint_step)
}

fn sweep_verlet(paths: u64) -> f64 {
    by_hand(paths, |_| [0.1, 0.0, 0.05, 0.1], galaxy, verlet_step)
}

fn sweep_midpoint(paths: u64) -> f64 {
    by_hand(paths, |_| [0.1, 0.0, 0.05, 0.1], galaxy, midpoint_step)
}

struct Unit;

impl Force<2> for Unit {
    #[inline(always)]
    fn of<const S: usize>([x, y]: &[[f64; S]; 2], force: &mut [[f64; S]; 2]) {
        for i in 0..S {
            (force[0][i], force[1][i]) = (-x[i] - 2.0 * x[i] * y[i], -y[i] - x[i] * x[i] + y[i] * y[i]);
        }
    }
}

/// Path by path, with the instructions that every processor of the target has.
fn gauss(paths: u64) -> f64 {
    let table = Coefficients::<8>::new();
    let square = |path: u64| {
        let [x, y, u, v] = black_box(start(path));
        let (q, ..) = gauss_by_hand::run_with::<Unit, 2, 8, { cfg!(target_feature = "fma") }>(
            InstructionSet::Baseline,
            &table,
            [[x, y], [u, v]],
            H,
            STEPS as u32,
        );
        q[0] * q[0]
    };
    (0..paths).map(square).sum::<f64>() / paths as f64
}

/// With the force of the end kept for the next start.
#[inline(always)]
fn verlet_step(system: &Galaxy, state: &mut [f64; 4], kept: &mut [f64; 4]) {
    let [x, y, mut u, mut v] = *state;
    let [a, b] = if kept[..2] == [x, y] { [kept[2], kept[3]] } else { force(system, x, y) };
    (u, v) = (u + 0.5 * H * a, v + 0.5 * H * b);
    let (x, y) = (x + H * u, y + H * v);
    let [a, b] = force(system, x, y);
    *state = [x, y, u + 0.5 * H * a, v + 0.5 * H * b];
    *kept = [x, y, a, b];
}

/// Newton's method for the middle of the coordinates, from where the velocity leads.
#[inline(always)]
fn midpoint_step(system: &Galaxy, state: &mut [f64; 4], _: &mut [f64; 4]) {
    let [x, y, u, v] = *state;
    let Galaxy { a, b, c, d } = *system;
    let quarter = 0.25 * H * H;
    let (mut mx, mut my) = (x + 0.5 * H * u, y + 0.5 * H * v);
    for _ in 0..50 {
        let [fx, fy] = force(system, mx, my);
        let residual = [mx - x - 0.5 * H * u - quarter * fx, my - y - 0.5 * H * v - quarter * fy];
        let [[j, k], [_, l]] = [
            [1.0 + quarter * (a + 2.0 * c * my), quarter * 2.0 * c * mx],
            [quarter * 2.0 * c * mx, 1.0 + quarter * (b - 2.0 * d * my)],
        ];
        let inverse = 1.0 / (j * l - k * k);
        let dx = (l * residual[0] - k * residual[1]) * inverse;
        let dy = (j * residual[1] - k * residual[0]) * inverse;
        (mx, my) = (mx - dx, my - dy);
        // Quadratic: the next one is below 1e-18.
        if dx.abs() + dy.abs() <= 1e-10 {
            break;
        }
    }
    let (x1, y1) = (2.0 * mx - x, 2.0 * my - y);
    *state = [x1, y1, 2.0 * (x1 - x) / H - u, 2.0 * (y1 - y) / H - v];
}

/// Where the paths are at the end.
fn ends<E>(paths: u64) -> Vec<f64>
where
    HenonHeiles: Discretized<E, Vector = SVector<f64, 2>>,
{
    let starts = |draw: &mut Draw| {
        let [x, y, u, v] = start(draw.path());
        State::new([x, y], [u, v])
    };
    let run = HenonHeiles.ensemble::<E>(H).starts(starts).paths(paths).steps(STEPS).keep_paths(1 << 24);
    let run = run.observe("x", |state| state.q[0]).observe("y", |state| state.q[1]).run().unwrap();
    let kept = run.paths().unwrap();
    (0..kept.count()).flat_map(|path| kept.at(path, 1).unwrap().to_vec()).collect()
}

/// Prints what a unit of time costs at equal errors of the coordinates at the end, whose root mean square over the paths falls with the square of
/// the step, from the time and the error of a step of size `H`. `Gauss<8>` is exact there to rounding.
fn print_equal_errors(paths: u64, of_step: [f64; 2]) {
    let exact = ends::<Gauss<8>>(paths);
    println!("\n{:26}{:>11}{:>11}{:>11}    ns per path and unit of time", "", "error", "at 1e-3", "at 1e-6");
    for (name, ends, ns) in [
        ("Hénon-Heiles, Verlet", ends::<Verlet>(paths), of_step[0]),
        ("Hénon-Heiles, Midpoint", ends::<Midpoint>(paths), of_step[1]),
    ] {
        let squares = ends.iter().zip(&exact).map(|(x, exact)| (x - exact) * (x - exact));
        let error = (squares.sum::<f64>() / paths as f64).sqrt();
        let at = |target: f64| ns / (H * (target / error).sqrt());
        println!("{name:26}{error:>11.1e}{:>11.0}{:>11.0}", at(1e-3), at(1e-6));
    }
}

/// The same on so many threads.
fn on_threads<E>(paths: u64, threads: usize)
where
    HenonHeiles: Discretized<E, Vector = SVector<f64, 2>>,
{
    let run =
        HenonHeiles.ensemble::<E>(H).start(State::new([0.1, 0.0], [0.05, 0.1])).paths(paths).steps(STEPS);
    black_box(run.observe("x²", |state| state.q[0] * state.q[0]).threads(threads).run().unwrap());
}

/// A single path, as a loop over a stepper.
fn stepper<E>(steps: u64)
where
    HenonHeiles: Discretized<E, Vector = SVector<f64, 2>>,
{
    let mut stepper = HenonHeiles.stepper::<E>(H).unwrap().plain();
    let mut state = black_box(State::new([0.1, 0.0], [0.05, 0.1]));
    (0..steps).for_each(|_| _ = stepper.step(&mut state, &[]).unwrap());
    black_box(state);
}

/// Prints what few paths cost.
fn print_few(repetitions: usize) {
    println!("\n{:26}{:>9}{:>9}{:>9}    Hénon-Heiles, Verlet", "", "1 thread", "2 threads", "stepper");
    for paths in [1, 4, 64, 512] {
        let [one, two, alone] = crate::times(
            paths,
            repetitions,
            [&|| on_threads::<Verlet>(paths, 1), &|| on_threads::<Verlet>(paths, 2), &|| {
                stepper::<Verlet>(paths * STEPS)
            }],
        );
        println!("{:26}{one:>9.2}{two:>9.2}{alone:>9.2}", format!("{paths} paths"));
    }
}

/// A scheme: its name, an ensemble, and a loop by hand.
type Row = (&'static str, fn(u64) -> f64, fn(u64) -> f64);

/// Prints nanoseconds per path and step.
pub(crate) fn print(paths: u64, repetitions: usize, only: Option<&str>) {
    let rows: [Row; 5] = [
        ("Hénon-Heiles, Verlet", ensemble::<Verlet>, verlet),
        ("Hénon-Heiles, Midpoint", ensemble::<Midpoint>, midpoint),
        ("Hénon-Heiles, Gauss<8>", ensemble::<Gauss<8>>, gauss),
        ("four parameters, Verlet", sweep::<Verlet>, sweep_verlet),
        ("four parameters, Midpoint", sweep::<Midpoint>, sweep_midpoint),
    ];
    println!("\n{:26}{:>9}{:>9}{:>9}    {paths} starts, no noise", "", "ensemble", "by hand", "by hand/");
    let mut found = Vec::new();
    for (name, ours, hand) in rows {
        if only.is_some_and(|only| !name.contains(only)) {
            continue;
        }
        let (mean, other) = (ours(paths), hand(paths));
        assert!((mean - other).abs() < 1e-9, "{name}: {mean}, by hand {other}: not the same paths");
        let [ours, hand] = crate::times(
            paths,
            repetitions,
            [&|| _ = black_box(ours(paths)), &|| _ = black_box(hand(paths))],
        );
        println!("{name:26}{ours:>9.2}{hand:>9.2}{:>9.2}", hand / ours);
        found.push(ours);
    }
    if let [verlet, midpoint, gauss, ..] = found[..]
        && only.is_none_or(|only| "Hénon-Heiles".contains(only))
    {
        print_equal_errors(paths, [verlet, midpoint]);
        println!("{:26}{:>11}{:>11.0}{:>11.0}", "Hénon-Heiles, Gauss<8>", "< 1e-12", gauss / H, gauss / H);
    }
    if only.is_none_or(|only| "few".contains(only)) {
        print_few(repetitions);
    }
}
