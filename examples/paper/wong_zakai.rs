//! A question that the paper leaves open: the error of the approximation of the noise, over (eps, h), for each sampling.

use wzvi::noise::{Noise as _, Sampling};
use wzvi::prelude::*;
use wzvi::report::{Axis, Document, Figure, Look, Series, number};

use crate::kubo::{KUBO, exact};
use crate::{agrees, rms};

const END: f64 = 1.0;
const SEED: u64 = 23;
const PATHS: u64 = 100;
/// The sampling, its name, and the limit of the error as h goes to 0: `sqrt(c eps)` times sigma.
const SAMPLINGS: [(Sampling, &str, f64); 4] = [
    (Sampling::Left, "left", 2.0 / 3.0),
    (Sampling::Centred, "centred", 1.0 / 6.0),
    (Sampling::Literal, "literal", 2.0 / 3.0),
    (Sampling::Exact, "exact increments", 2.0 / 3.0),
];

fn widths() -> impl Iterator<Item = f64> {
    (2..=7).map(|k| 2f64.powi(-k))
}

fn steps() -> impl Iterator<Item = f64> {
    (3..=9).map(|k| 2f64.powi(-k))
}

/// Root mean square errors of one run: against the Stratonovich solution and against the Wong-Zakai equation.
struct Point {
    sampling: Sampling,
    eps: f64,
    h: f64,
    errors: [f64; 2],
}

fn measure(sampling: Sampling, eps: f64, h: f64) -> Result<Point, wzvi::Error> {
    let mut noise = WongZakai::averaged(eps).seed(SEED).sampling(sampling);
    let mut errors = [vec![], vec![]];
    for path in 0..PATHS {
        noise = noise.path(path);
        let start = State::new([0.0], [1.0]);
        let run =
            KUBO.simulate::<Midpoint>(h).start(start).noise(&mut noise).until(END).record_every(0).run()?;
        let smooth = noise.value(0, END)? - noise.value(0, 0.0)?;
        let w = Wiener::seed(SEED).path(path).value(0, END)?;
        for (errors, w) in errors.iter_mut().zip([w, smooth]) {
            let (a, b) = (run.last(), exact(END, w));
            errors.push((a.q[0] - b.q[0]).hypot(a.p[0] - b.p[0]));
        }
    }
    Ok(Point { sampling, eps, h, errors: errors.map(rms) })
}

pub(crate) fn append(document: Document) -> Result<Document, wzvi::Error> {
    let mut map = vec![];
    for (sampling, _, _) in SAMPLINGS {
        for eps in widths() {
            for h in steps() {
                map.push(measure(sampling, eps, h)?);
            }
        }
    }
    let mut document = document
        .heading("What the approximation of the noise costs")
        .text("The Kubo oscillator again, by the mid-point embedding, up to t = 1. A step gets h dW_ε/dt at one point (left end, centred, or, taken \
               literally, the quadrature point t + h/2 of the looking-ahead kernel) or the exact increment of W_ε. Root mean square errors over \
               100 paths, against the Stratonovich solution and against the Wong-Zakai equation, whose solution is known: the angle is \
               a t + σ (W_ε(t) - W_ε(0)).")
        .figure(limits(&map))
        .figure(diagonal(&map))
        .figure(ratios()?);
    for (sampling, name, factor) in SAMPLINGS {
        for against in [0, 1] {
            document = document.figure(section(&map, sampling, name, factor, against));
        }
    }
    Ok(document)
}

/// h to 0 first: the remaining error is that of W_eps.
fn limits(map: &[Point]) -> Figure {
    let (x, y) = (Axis::logarithmic("ε"), Axis::logarithmic("error against Stratonovich"));
    let mut figure =
        Figure::new("wong-zakai-limit", "h to 0 first: the error of the Wong-Zakai equation", x, y);
    let least = steps().fold(f64::INFINITY, f64::min);
    let mut worst: f64 = 0.0;
    for (colour, (sampling, name, factor)) in SAMPLINGS.into_iter().enumerate() {
        let chosen = map.iter().filter(|point| point.sampling == sampling && point.h == least);
        let points: Vec<(f64, f64)> = chosen.map(|point| (point.eps, point.errors[0])).collect();
        for (eps, error) in points.iter().filter(|point| point.0 >= 8.0 * least && point.0 <= 0.1) {
            worst = worst.max((error / (KUBO.sigma * (factor * eps).sqrt()) - 1.0).abs());
        }
        figure = figure.with(Series::new(name, Look::Marks, colour, points));
    }
    for (name, factor, colour) in [("σ √(2ε/3)", 2.0 / 3.0, 0), ("centred: σ √(ε/6)", 1.0 / 6.0, 1)] {
        let points = widths().map(|eps| (eps, KUBO.sigma * (factor * eps).sqrt())).collect();
        figure = figure.with(Series::new(name, Look::Dashed, colour, points));
    }
    figure.shows(format!(
        "With h = {} the steps cost little, and the error is that of W_ε: of order 1/2 in ε, half as large for the centred kernel. The \
         measurements are within {} % of the limits where h is small against ε and ε against 1. {} the predictions.",
        number(least),
        number(100.0 * worst),
        agrees(worst < 0.25)
    ))
}

/// h = eps, the paper's choice.
fn diagonal(map: &[Point]) -> Figure {
    let (x, y) = (Axis::logarithmic("h = ε"), Axis::logarithmic("error against Stratonovich"));
    let mut figure = Figure::new("wong-zakai-diagonal", "h = ε, the paper's choice", x, y);
    let mut literal_off: f64 = 0.0;
    for (colour, (sampling, name, _)) in SAMPLINGS.into_iter().enumerate() {
        let points = map.iter().filter(|point| point.sampling == sampling && point.h == point.eps);
        let points: Vec<(f64, f64)> = points.map(|point| (point.h, point.errors[0])).collect();
        if sampling == Sampling::Literal {
            for (h, error) in points.iter().filter(|point| point.0 < 0.1) {
                literal_off = literal_off.max((error / (KUBO.sigma * h.sqrt()) - 1.0).abs());
            }
        }
        figure = figure.with(Series::new(name, Look::Joined, colour, points));
    }
    let (a, s) = (KUBO.a, KUBO.sigma);
    let first = (15.0 * s.powi(6) / 144.0 + (a * s * s / 4.0).powi(2)).sqrt();
    let own = |f: fn(f64, f64) -> f64, c: f64| steps().skip(1).map(|h| (h, f(c, h))).collect();
    figure
        .with(Series::new("literal: σ √h", Look::Dashed, 2, own(|c, h| c * h.sqrt(), s)))
        .with(Series::new("the mid-point itself: order one", Look::Dashed, 0, own(|c, h| c * h, first)))
        .shows(format!(
            "Sampled at the left end, or centred, the increments are those of the Wiener path and the strong order is one. Taken literally, the \
             kernel looks half a step too far ahead: the order falls to 1/2, within {} % of σ √h. {} the predictions.",
            number(100.0 * literal_off),
            agrees(literal_off < 0.3)
        ))
}

/// eps = rho h, h to 0: a wrong intensity of the noise, unless rho is an integer.
fn ratios() -> Result<Figure, wzvi::Error> {
    let h = 2f64.powi(-9);
    let excess = |rho: f64| rho.fract() * (1.0 - rho.fract()) / (rho * rho);
    let mut points = vec![];
    for rho in (4..=32).step_by(2).map(|eighth| f64::from(eighth) / 8.0) {
        let mut noise = WongZakai::averaged(rho * h).seed(SEED);
        let mut off = vec![];
        for path in 0..2 * PATHS {
            noise = noise.path(path);
            let mut dw = [0.0];
            let mut sum = -Wiener::seed(SEED).path(path).value(0, END)?;
            for step in 0..512 {
                noise.increments(&wzvi::increments::Interval { start: 0.0, h, step }, &mut dw)?;
                sum += dw[0];
            }
            off.push(sum);
        }
        points.push((rho, 1.0 + rms(off).powi(2) / END));
    }
    let worst = points.iter().map(|(rho, v)| (v - 1.0 - excess(*rho)).abs()).fold(0.0, f64::max);
    let law = (25..=200).map(|n| f64::from(n) / 50.0).map(|rho| (rho, 1.0 + excess(rho))).collect();
    Ok(Figure::new("wong-zakai-ratio", "ε = ρ h: the intensity of the noise", Axis::linear("ρ = ε / h"), Axis::linear("v"))
        .shows(format!(
            "At a fixed ratio ρ = ε / h the sampled increments have the variance v h in the limit, v = 1 + f (1 - f) / ρ² with f the fractional \
             part of ρ: right only where ρ is an integer, and twice too large at ρ = 1/2. Measured as 1 + E (Σ δ_i - W(1))², h = 2⁻⁹: within {} of \
             the law. {} the prediction; the paper takes ρ = 1, where nothing is wrong.",
            number(worst),
            agrees(worst < 0.15)
        ))
        .with(Series::new("v = 1 + f (1 - f) / ρ²", Look::Dashed, 6, law))
        .with(Series::new("measured", Look::Marks, 0, points)))
}

/// One sampling: error against h for each eps.
fn section(map: &[Point], sampling: Sampling, name: &str, factor: f64, against: usize) -> Figure {
    let label = ["the Stratonovich solution", "the Wong-Zakai equation"][against];
    let id = format!("map-{}-{}", name.replace(' ', "-"), ["stratonovich", "wong-zakai"][against]);
    let title = format!("The map, {name}: against {label}");
    let mut figure = Figure::new(id, title, Axis::logarithmic("h"), Axis::logarithmic("error"));
    let mut orders = vec![];
    for (colour, eps) in widths().enumerate() {
        let points = map.iter().filter(|point| point.sampling == sampling && point.eps == eps);
        let points: Vec<(f64, f64)> = points.map(|point| (point.h, point.errors[against])).collect();
        if let [.., before, last] = points.as_slice() {
            orders.push((before.1 / last.1).log2() / (before.0 / last.0).log2());
        }
        figure = figure.with(Series::new(format!("ε = {}", number(eps)), Look::Joined, colour, points));
    }
    if against == 0 {
        for (colour, eps) in widths().enumerate() {
            let limit = KUBO.sigma * (factor * eps).sqrt();
            let points = steps().map(|h| (h, limit)).collect();
            figure = figure.with(Series::new("limit as h goes to 0", Look::Dashed, colour, points));
        }
        return figure.shows(
            "As h goes to 0 at fixed ε the error does not go to 0 but to that of W_ε, the dashed lines: smaller steps are wasted. To converge, both have \
             to go to 0, with h a divisor of ε.",
        );
    }
    let first = orders.first().copied().unwrap_or(f64::NAN);
    let exact = sampling == Sampling::Exact;
    figure.shows(match exact {
        true => format!(
            "Exact increments of W_ε solve the Wong-Zakai equation with order two in h: {} between the two smallest steps for the widest kernel. \
             {} the prediction, for this is a smooth equation.",
            number(first),
            agrees((first - 2.0).abs() < 0.3)
        ),
        false => format!(
            "The velocity at one point per step is a quadrature of dW_ε/dt, which is no smoother than a Wiener path: the order in h is {} between the two \
             smallest steps for the widest kernel, not two. Exact increments do better.",
            number(first)
        ),
    })
}
