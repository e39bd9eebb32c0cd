//! A cloud of starts without noise: what a path and step costs in an ensemble, beside loops written by hand.

use std::hint::black_box;

use wzvi::ensemble::Draw;
use wzvi::nalgebra::SVector;
use wzvi::prelude::*;
use wzvi::system::Discretized;

use crate::scenes::STEPS;

/// Hénon and Heiles.
#[hamiltonian(
    drift = |[x, y], [u, v]| 0.5 * (u * u + v * v + x * x + y * y) + x * x * y - y * y * y / 3.0,
    embedding = [Verlet, Midpoint, Gauss<8>],
)]
struct HenonHeiles;

const H: f64 = 0.1;

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

fn by_hand(paths: u64, mut step: impl FnMut(&mut [f64; 4])) -> f64 {
    let mut sum = 0.0;
    for path in 0..paths {
        let mut state = black_box(start(path));
        (0..STEPS).for_each(|_| step(&mut state));
        sum += state[0] * state[0];
    }
    sum / paths as f64
}

fn force(x: f64, y: f64) -> [f64; 2] {
    [-x - 2.0 * x * y, -y - x * x + y * y]
}

/// With the force of the end kept for the next start.
fn verlet(paths: u64) -> f64 {
    let mut kept = [f64::NAN; 4];
    by_hand(paths, |state| {
        let [x, y, mut u, mut v] = *state;
        let [a, b] = if kept[..2] == [x, y] { [kept[2], kept[3]] } else { force(x, y) };
        (u, v) = (u + 0.5 * H * a, v + 0.5 * H * b);
        let (x, y) = (x + H * u, y + H * v);
        let [a, b] = force(x, y);
        *state = [x, y, u + 0.5 * H * a, v + 0.5 * H * b];
        kept = [x, y, a, b];
    })
}

/// Newton's method for the middle of the coordinates, from where the velocity leads.
fn midpoint(paths: u64) -> f64 {
    by_hand(paths, |state| {
        let [x, y, u, v] = *state;
        let quarter = 0.25 * H * H;
        let (mut mx, mut my) = (x + 0.5 * H * u, y + 0.5 * H * v);
        for _ in 0..50 {
            let [a, b] = force(mx, my);
            let residual = [mx - x - 0.5 * H * u - quarter * a, my - y - 0.5 * H * v - quarter * b];
            let [[j, k], [_, l]] = [
                [1.0 + quarter * (1.0 + 2.0 * my), quarter * 2.0 * mx],
                [quarter * 2.0 * mx, 1.0 + quarter * (1.0 - 2.0 * my)],
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
    })
}

/// A scheme: its name, an ensemble, and a loop by hand if there is one.
type Row = (&'static str, fn(u64) -> f64, Option<fn(u64) -> f64>);

/// Prints nanoseconds per path and step.
pub(crate) fn print(paths: u64, repetitions: usize, only: Option<&str>) {
    let rows: [Row; 3] = [
        ("Hénon-Heiles, Verlet", ensemble::<Verlet>, Some(verlet)),
        ("Hénon-Heiles, Midpoint", ensemble::<Midpoint>, Some(midpoint)),
        ("Hénon-Heiles, Gauss<8>", ensemble::<Gauss<8>>, None),
    ];
    println!("\n{:26}{:>9}{:>9}{:>9}    {paths} starts, no noise", "", "ensemble", "by hand", "by hand/");
    for (name, ours, hand) in rows {
        if only.is_some_and(|only| !name.contains(only)) {
            continue;
        }
        let Some(hand) = hand else {
            let [ours] = crate::times(paths, repetitions / 8, [&|| _ = black_box(ours(paths))]);
            println!("{name:26}{ours:>9.2}{:>9}{:>9}", "-", "-");
            continue;
        };
        let (mean, other) = (ours(paths), hand(paths));
        assert!((mean - other).abs() < 1e-9, "{name}: {mean}, by hand {other}: not the same paths");
        let [ours, hand] = crate::times(
            paths,
            repetitions,
            [&|| _ = black_box(ours(paths)), &|| _ = black_box(hand(paths))],
        );
        println!("{name:26}{ours:>9.2}{hand:>9.2}{:>9.2}", hand / ours);
    }
}
