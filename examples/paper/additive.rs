//! Figure 4: the oscillator with additive noise, beside the exact path on the same Wiener path.

use wzvi::prelude::*;
use wzvi::report::statistics::Estimate;
use wzvi::report::{Axis, Document, Figure, Look, Series, number};

use crate::{agrees, rms};

/// `dq = p dt`, `dp = -q dt + gamma dW`: the paper's second example with sigma = 0.
#[hamiltonian(
    drift = |q, p| 0.5 * (q * q + p * p),
    noise = [|q, _| -gamma * q],
    embedding = [DeltaPlus, Midpoint],
)]
struct Forced {
    gamma: f64,
}

const SYSTEM: Forced = Forced { gamma: 1.0 };
const H: f64 = 0.02;
const END: f64 = 200.0;
const STEPS: u64 = 10_000;
const SEED: u64 = 3;
/// Paths that the distances are averaged over.
const PATHS: u64 = 40;
/// Steps between two points of that average.
const EVERY: usize = 500;

/// Paths that the energy is averaged over.
const ENERGY_PATHS: u64 = 400;

type Point = [f64; 2];

fn turned([q, p]: Point, angle: f64) -> Point {
    let (sin, cos) = angle.sin_cos();
    [q * cos + p * sin, p * cos - q * sin]
}

/// The exact path at the nodes: `z(t + d) = R(d) z(t) + gamma ∫ (sin(d - s), cos(d - s)) dW_s`, twice per step.
///
/// With w the increment of W over d, A its area against the chord, both of them drawn from the path itself, the integrals are
/// `A + w d/2` and `w - w d²/6 - A d/2` up to parts of deviation `d^(7/2)`: 1e-7 for d = 0.01.
fn exact(wiener: &mut Wiener) -> Result<Vec<Point>, wzvi::Error> {
    let d = 0.5 * H;
    let mut z = [0.0, 1.0];
    let mut path = vec![z];
    for n in 0..2 * STEPS {
        let (from, to) = (n as f64 * d, (n + 1) as f64 * d);
        let w = wiener.increment(0, from, to)?;
        let area = wiener.area(0, from, to)? - 0.5 * d * w;
        z = turned(z, d);
        z[0] += SYSTEM.gamma * (area + 0.5 * d * w);
        z[1] += SYSTEM.gamma * (w - d * d * w / 6.0 - 0.5 * d * area);
        if n % 2 == 1 {
            path.push(z);
        }
    }
    Ok(path)
}

/// What the paper compares with: the mean of the exact path given the increments.
fn conditional(wiener: &mut Wiener) -> Result<Vec<Point>, wzvi::Error> {
    let mut z = [0.0, 1.0];
    let mut path = vec![z];
    for n in 0..STEPS {
        let w = SYSTEM.gamma * wiener.increment(0, n as f64 * H, (n + 1) as f64 * H)? / H;
        z = turned(z, H);
        z[0] += w * (1.0 - H.cos());
        z[1] += w * H.sin();
        path.push(z);
    }
    Ok(path)
}

fn discrete<E>(path: u64) -> Result<Vec<Point>, wzvi::Error>
where
    Forced: Discretized<E>,
{
    let (start, noise) = (State::new([0.0], [1.0]), Wiener::seed(SEED).path(path));
    let run = SYSTEM.simulate::<E>(H).start(start).noise(noise).until(END).run()?;
    Ok(run.iter().map(|state| [state.q[0], state.p[0]]).collect())
}

fn end_energy(path: u64) -> Result<f64, wzvi::Error> {
    let (start, noise) = (State::new([0.0], [1.0]), Wiener::seed(SEED).path(path));
    let run = SYSTEM.simulate::<Midpoint>(H).start(start).noise(noise).until(END).record_every(0).run()?;
    Ok(SYSTEM.energy(run.last()))
}

pub(crate) fn append(document: Document) -> Result<Document, wzvi::Error> {
    let reference = exact(&mut Wiener::seed(SEED))?;
    let (one, two) = (discrete::<DeltaPlus>(0)?, discrete::<Midpoint>(0)?);
    let time = |n: usize| n as f64 * H;
    let series = |path: &[Point], value: fn(&Point) -> f64| -> Vec<(f64, f64)> {
        path.iter().enumerate().map(|(n, z)| (time(n), value(z))).collect()
    };
    let energy = |z: &Point| 0.5 * (z[0] * z[0] + z[1] * z[1]);
    let apart = |path: &[Point], n: usize| match (path.get(n), reference.get(n)) {
        (Some(a), Some(b)) => (a[0] - b[0]).hypot(a[1] - b[1]),
        _ => f64::NAN,
    };
    let worst = |path: &[Point]| (0..path.len()).map(|n| apart(path, n)).fold(0.0, f64::max);
    let size = rms(reference.iter().map(|z| z[0].hypot(z[1])));
    let figure = Figure::new("figure-4a", "Figure 4: additive noise", Axis::linear("t"), Axis::linear("q"))
        .shows(format!(
            "All follow the exact path up to t = 200, of size {}: the left point at most {} off, the mid-point {}. With additive noise the \
             defect D is constant, so that both are consistent. {} the paper's conclusion that additive noise needs no more than order one.",
            number(size),
            number(worst(&one)),
            number(worst(&two)),
            agrees(worst(&one).max(worst(&two)) < 0.1 * size)
        ))
        .with(Series::new("exact, drawn jointly", Look::Line, 6, series(&reference, |z| z[0])))
        .with(Series::new("order one", Look::Line, 1, series(&one, |z| z[0])))
        .with(Series::new("order two", Look::Dashed, 0, series(&two, |z| z[0])));
    let ends: Result<Vec<f64>, wzvi::Error> = (0..ENERGY_PATHS).map(end_energy).collect();
    let (grown, expected) = (Estimate::mean(&ends?), 0.5 + 0.5 * SYSTEM.gamma * SYSTEM.gamma * END);
    let mean = (0..=10).map(|k| (20.0 * f64::from(k), 0.5 + 10.0 * f64::from(k)));
    let energies = Figure::new("figure-4b", "Figure 4: its energy", Axis::linear("t"), Axis::linear("H"))
        .shows(format!(
            "The noise feeds energy in: E H(t) = H(0) + γ² t / 2, the dashed line; one path wanders about it. At the end order one is {} \
             off the exact energy, order two {}. Over {ENERGY_PATHS} paths the mean of H(200) by order two is {} ± {}, where {} is expected. {} \
             that formula.",
            number(apart_energy(&one, &reference, energy)),
            number(apart_energy(&two, &reference, energy)),
            number(grown.value),
            number(grown.half_width()),
            number(expected),
            agrees((grown.value - expected).abs() < 3.0 * grown.standard_error)
        ))
        .with(Series::new("expectation", Look::Dashed, 6, mean.collect()))
        .with(Series::new("exact, drawn jointly", Look::Line, 6, series(&reference, energy)))
        .with(Series::new("order one", Look::Line, 1, series(&one, energy)))
        .with(Series::new("order two", Look::Line, 0, series(&two, energy)));
    Ok(document
        .heading("Additive noise")
        .text("dq = p dt, dp = -q dt + γ dW with γ = 1, q(0) = 0, p(0) = 1, h = 0.02, t up to 200. The exact path is drawn jointly with the \
               increments: the same Wiener path, its areas included.")
        .figure(figure)
        .figure(energies)
        .figure(distances()?))
}

fn apart_energy(path: &[Point], reference: &[Point], energy: impl Fn(&Point) -> f64) -> f64 {
    match (path.last(), reference.last()) {
        (Some(a), Some(b)) => (energy(a) - energy(b)).abs(),
        _ => f64::NAN,
    }
}

/// Root mean square distances from the exact path.
fn distances() -> Result<Figure, wzvi::Error> {
    let nodes = STEPS as usize / EVERY;
    let mut squares = vec![[0.0; 3]; nodes];
    for path in 0..PATHS {
        let mut wiener = Wiener::seed(SEED).path(path);
        let reference = exact(&mut wiener)?;
        let others = [conditional(&mut wiener)?, discrete::<DeltaPlus>(path)?, discrete::<Midpoint>(path)?];
        for (node, sums) in squares.iter_mut().enumerate() {
            let n = (node + 1) * EVERY;
            for (sum, other) in sums.iter_mut().zip(&others) {
                let (a, b) = (other[n], reference[n]);
                *sum += ((a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)) / PATHS as f64;
            }
        }
    }
    let time = |node: usize| ((node + 1) * EVERY) as f64 * H;
    let series = |which: usize| -> Vec<(f64, f64)> {
        squares.iter().enumerate().map(|(node, sums)| (time(node), sums[which].sqrt())).collect()
    };
    let last = squares.last().map_or(f64::NAN, |sums| sums[0].sqrt());
    let law = SYSTEM.gamma * H * (END / 12.0).sqrt();
    let prediction = (0..nodes).map(|node| (time(node), SYSTEM.gamma * H * (time(node) / 12.0).sqrt()));
    Ok(Figure::new("figure-4c", "Distance from the exact path", Axis::linear("t"), Axis::logarithmic("distance, root mean square"))
        .shows(format!(
            "Over {PATHS} paths. The paper's reference solution is the mean of the exact one given the increments, and so itself off: {} at \
             t = 200, where γ h √(t/12) = {} is expected. {} that law. A comparison with it cannot see errors below it; this one can.",
            number(last),
            number(law),
            if (last / law - 1.0).abs() < 0.25 { "This agrees with" } else { "This does not agree with" }
        ))
        .with(Series::new("predicted: γ h √(t/12)", Look::Dashed, 6, prediction.collect()))
        .with(Series::new("the paper's reference", Look::Marks, 6, series(0)))
        .with(Series::new("order one", Look::Joined, 1, series(1)))
        .with(Series::new("order two", Look::Joined, 0, series(2))))
}
