//! Cost against error: multilevel Monte Carlo beside paths of one step size.
//!
//! Kubo's oscillator at t = 1, mean of q, exactly `e^{-σ²/2} sin a`. Both methods have the same target, a root mean square error `ε`,
//! and divide it in the same way: a quarter of its square for the bias, three quarters for the sampling error. Multilevel runs find
//! their levels by themselves. Plain runs take the step size with this bias, from the exact mean of the scheme, and stop when
//! their standard error is small enough. Theory: steps `~ ε^-2` against `~ ε^-3` (M. B. Giles, Oper. Res. 56 (2008) 607).
//!
//! `cargo run --release --features svg --example multilevel`, less than a minute

#[path = "support/plot.rs"]
mod plot;
#[path = "support/table.rs"]
mod table;

use std::error::Error;
use std::time::Instant;

use wzvi::plot::{Colour, Figure, Look};
use wzvi::prelude::*;

/// A rotation whose angle diffuses.
#[hamiltonian(
    drift = |q, p| 0.5 * a * (q * q + p * p),
    noise = [|q, p| 0.5 * sigma * (q * q + p * p)],
    embedding = [Midpoint],
)]
pub struct Kubo {
    /// Mean angular frequency.
    pub a: f64,
    /// Intensity of the noise.
    pub sigma: f64,
}

const KUBO: Kubo = Kubo { a: 1.5, sigma: 1.0 };
const COARSEST: f64 = 0.25;
/// Runs with other seeds, for the actual error.
const RUNS: u64 = 8;

/// What runs to one error found and took, in the mean of all seeds.
struct Cost {
    target: f64,
    steps: f64,
    seconds: f64,
    /// Root mean square of the actual error.
    error: f64,
    finest: f64,
}

/// `E q` after `1/h` steps: each turns `p + iq` by `(1 + iθ)/(1 - iθ)`, `θ = (a h + σ ΔW)/2`, in the mean by an integral
/// (Simpson's rule over ten standard deviations).
fn scheme_mean(h: f64) -> f64 {
    let intervals = 4000;
    let mut sum = [0.0; 3];
    for i in 0..=intervals {
        let x = 20.0 * f64::from(i) / f64::from(intervals) - 10.0;
        let weight = if i == 0 || i == intervals { 1.0 } else { f64::from(2 + 2 * (i % 2)) };
        let density = weight * (-0.5 * x * x).exp();
        let theta = 0.5 * (KUBO.a * h + KUBO.sigma * h.sqrt() * x);
        let square = 1.0 + theta * theta;
        for (sum, value) in sum.iter_mut().zip([(2.0 - square) / square, 2.0 * theta / square, 1.0]) {
            *sum += density * value;
        }
    }
    let (re, im) = (sum[0] / sum[2], sum[1] / sum[2]);
    re.hypot(im).powf(1.0 / h) * (im.atan2(re) / h).sin()
}

fn exact() -> f64 {
    (-0.5 * KUBO.sigma.powi(2)).exp() * KUBO.a.sin()
}

/// Runs with each seed: estimate, steps, finest step size.
fn measure(target: f64, run: impl Fn(u64) -> Result<[f64; 3], wzvi::Error>) -> Result<Cost, wzvi::Error> {
    let began = Instant::now();
    let [mut squares, mut steps, mut finest] = [0.0; 3];
    for seed in 0..RUNS {
        let [mean, cost, h] = run(seed)?;
        squares += (mean - exact()).powi(2) / RUNS as f64;
        steps += cost / RUNS as f64;
        finest = h.max(finest);
    }
    let seconds = began.elapsed().as_secs_f64() / RUNS as f64;
    Ok(Cost { target, steps, seconds, error: squares.sqrt(), finest })
}

fn multilevel(target: f64) -> Result<Cost, wzvi::Error> {
    measure(target, |seed| {
        let run = KUBO.multilevel::<Midpoint>(COARSEST).start(State::new([0.0], [1.0])).seed(seed).until(1.0);
        let estimate = run.observe("q", |state| state.q[0]).target(target).run()?;
        let finest = estimate.levels().last().map_or(f64::NAN, |level| level.h());
        Ok([estimate.mean(), estimate.cost() as f64, finest])
    })
}

fn plain(target: f64) -> Result<Cost, wzvi::Error> {
    let biased = |h: &f64| (scheme_mean(*h) - exact()).abs() > 0.5 * target;
    // As long as it may be.
    let steps = (2u64..).find(|&steps| !biased(&(1.0 / steps as f64))).unwrap_or(u64::MAX);
    measure(target, |seed| {
        let run = KUBO
            .ensemble::<Midpoint>(1.0 / steps as f64)
            .start(State::new([0.0], [1.0]))
            .seed(seed)
            .steps(steps);
        let run = run.paths(1 << 40).observe("q", |state| state.q[0]);
        let statistics = run.until_error("q", 0.75f64.sqrt() * target).run()?;
        let paths = statistics.last().map_or(0, |end| end.count());
        Ok([statistics.mean("q")?, (paths * steps) as f64, 1.0 / steps as f64])
    })
}

/// Of the logarithm of `y` against that of the target, by least squares over the three smallest.
fn slope(costs: &[Cost], y: impl Fn(&Cost) -> f64) -> f64 {
    let points: Vec<_> = costs.iter().rev().take(3).map(|cost| (cost.target.ln(), y(cost).ln())).collect();
    let n = points.len() as f64;
    let mean = points.iter().fold((0.0, 0.0), |sum, point| (sum.0 + point.0 / n, sum.1 + point.1 / n));
    let product: f64 = points.iter().map(|point| (point.0 - mean.0) * (point.1 - mean.1)).sum();
    product / points.iter().map(|point| (point.0 - mean.0).powi(2)).sum::<f64>()
}

fn main() -> Result<(), Box<dyn Error>> {
    let one = KUBO.multilevel::<Midpoint>(COARSEST).start(State::new([0.0], [1.0])).seed(7).until(1.0);
    let one = one.observe("q", |state| state.q[0]).target(1e-3).run()?;
    println!("One run to ε = 1e-3; exactly {:.6}\n\n{one}\n", exact());
    let variance = one.variance_slope().unwrap_or(f64::NAN);
    println!("V_l ~ h^{variance:.2}; twice the strong order is 2\n");

    let targets = |most: i32| (0..=most).map(|k| 0.016 / 2f64.powi(k));
    let levels = targets(7).map(multilevel).collect::<Result<Vec<_>, _>>()?;
    let single = targets(4).map(plain).collect::<Result<Vec<_>, _>>()?;
    let rows = |name: &str, costs: &[Cost]| -> Vec<[String; 6]> {
        let row = |cost: &Cost| {
            [
                name.into(),
                format!("{:.1e}", cost.target),
                format!("{:.1e}", cost.error),
                format!("{:.2e}", cost.finest),
                format!("{:.1e}", cost.steps),
                format!("{:.2e}", cost.seconds),
            ]
        };
        costs.iter().map(row).collect()
    };
    println!("Steps and time for an error, means of {RUNS} runs\n");
    let all = [rows("multilevel", &levels), rows("one step size", &single)].concat();
    table::print(["", "target ε", "actual error", "finest h", "steps", "seconds"], &all);
    let slopes = [&levels, &single].map(|costs| [slope(costs, |c| c.steps), slope(costs, |c| c.seconds)]);
    println!("\n  steps ~ ε^{:.2} multilevel, ε^{:.2} with one step size", slopes[0][0], slopes[1][0]);
    println!("  time  ~ ε^{:.2} multilevel, ε^{:.2} with one step size", slopes[0][1], slopes[1][1]);
    println!("  (the three smallest errors of each; theory -2 and -3)\n");

    let points = |costs: &[Cost], y: fn(&Cost) -> f64| -> Vec<(f64, f64)> {
        costs.iter().map(|cost| (cost.target, y(cost))).collect()
    };
    let [last_levels, last_single] = [&levels, &single].map(|costs| costs.last());
    let guide = |cost: Option<&Cost>, order: i32| {
        cost.map_or(f64::NAN, |cost| 1.6 * cost.steps * cost.target.powi(order))
    };
    let cost = Figure::panel(
        "Kubo oscillator, mean of q at t = 1",
        "target root mean square error",
        "steps of all paths",
    )
    .log_log()
    .points(Look::Joined, "multilevel", Colour::BLUE, points(&levels, |cost| cost.steps))
    .points(Look::Joined, "one step size", Colour::VERMILION, points(&single, |cost| cost.steps))
    .slope("ε⁻²", -2.0, guide(last_levels, 2), [1.3e-4, 1.6e-2])
    .slope("ε⁻³", -3.0, guide(last_single, 3), [1e-3, 1.6e-2]);
    let error = Figure::panel("Actual error against target", "target root mean square error", "actual error")
        .log_log()
        .points(Look::Joined, "multilevel", Colour::BLUE, points(&levels, |cost| cost.error))
        .points(Look::Joined, "one step size", Colour::VERMILION, points(&single, |cost| cost.error))
        .points(Look::Dashed, "target", Colour::INK, [1.25e-4, 1.6e-2].map(|x| (x, x)));
    let variances = one.levels().iter().skip(1).map(|level| (level.h(), level.variance()));
    let means = one.levels().iter().skip(1).map(|level| (level.h(), level.mean().abs()));
    let first = one.levels().get(1).map_or(f64::NAN, |level| level.variance() / level.h().powi(2));
    let rates = Figure::panel(
        "Differences between levels, ε = 1e-3",
        "step size h of the finer path",
        "mean, variance",
    )
    .log_log()
    .points(Look::Joined, "|mean|", Colour::BLUE, means)
    .points(Look::Joined, "variance", Colour::VERMILION, variances)
    .slope("h²", 2.0, 0.5 * first, [1e-3, 0.125]);
    plot::save("multilevel", "cost", 3, (900, 700), &[cost, error, rates])?;
    Ok(())
}
