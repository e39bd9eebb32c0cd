//! Figures 1 to 3: the Kubo oscillator by both orders, and its energies.

use wzvi::prelude::*;
use wzvi::report::{Axis, Document, Figure, Look, Report, Series, number};

use crate::agrees;

/// A rotation whose angle diffuses.
#[hamiltonian(
    drift = |q, p| 0.5 * a * (q * q + p * p),
    noise = [|q, p| 0.5 * sigma * (q * q + p * p)],
    embedding = [Uncorrected<DeltaPlus>, Corrected<DeltaPlus>, Midpoint],
    invariant = [|q, p| q * q + p * p],
)]
pub(crate) struct Kubo {
    pub(crate) a: f64,
    pub(crate) sigma: f64,
}

pub(crate) const KUBO: Kubo = Kubo { a: 1.5, sigma: 1.0 };
/// h = eps: then the increments are those of the Wiener path.
const H: f64 = 0.02;
const END: f64 = 20.0;
const SEED: u64 = 5;

type Vector = <Kubo as Hamiltonian>::Vector;
type One = Uncorrected<DeltaPlus>;

/// The state at angle `a t + sigma w` from q = 0, p = 1.
pub(crate) fn exact(t: f64, w: f64) -> State<Vector> {
    let (sin, cos) = (KUBO.a * t + KUBO.sigma * w).sin_cos();
    State::new([sin], [cos]).at(t)
}

fn start() -> State<Vector> {
    State::new([0.0], [1.0])
}

fn path<E>() -> Result<Trajectory<Vector, E>, wzvi::Error>
where
    Kubo: Discretized<E>,
{
    KUBO.simulate::<E>(H).start(start()).noise(WongZakai::averaged(H).seed(SEED)).until(END).run()
}

/// `H_WZ = H_0 + H_1 dW_eps/dt` along a path.
fn wong_zakai_energy<E>(path: &Trajectory<Vector, E>) -> Vec<(f64, f64)> {
    let with = |(state, dw): (&State<Vector>, &[f64])| {
        let velocity = dw.first().copied().unwrap_or(0.0) / H;
        (state.t, KUBO.energy(state) + velocity * KUBO.noise_energy(0, state))
    };
    path.iter().zip(path.increments()).map(with).collect()
}

fn over_time<E>(path: &Trajectory<Vector, E>, value: impl Fn(&State<Vector>) -> f64) -> Vec<(f64, f64)> {
    path.iter().map(|state| (state.t, value(state))).collect()
}

/// Largest distance from the exact path.
fn distance<E>(path: &Trajectory<Vector, E>, exact: &[State<Vector>]) -> f64 {
    let off = |(a, b): (&State<Vector>, &State<Vector>)| (a.q[0] - b.q[0]).hypot(a.p[0] - b.p[0]);
    path.iter().zip(exact).map(off).fold(0.0, f64::max)
}

pub(crate) fn append(document: Document) -> Result<Document, wzvi::Error> {
    let (one, two) = (path::<One>()?, path::<Midpoint>()?);
    let corrected = path::<Corrected<DeltaPlus>>()?;
    let mut wiener = Wiener::seed(SEED);
    let mut reference = vec![];
    for state in &two {
        reference.push(exact(state.t, wiener.value(0, state.t)?));
    }
    let exact_q: Vec<(f64, f64)> = reference.iter().map(|state| (state.t, state.q[0])).collect();
    let off = [distance(&one, &reference), distance(&two, &reference), distance(&corrected, &reference)];
    let q_axis = || (Axis::linear("t"), Axis::linear("q"));

    let (x, y) = q_axis();
    let first = Figure::new("figure-1", "Figure 1: Kubo, order one", x, y)
        .shows(format!(
            "The left-point embedding leaves the exact path: at most {} off, with growing amplitude, since it converges to the system \
             with drift H₀ - σ² q p / 2. {} the paper's conclusion that multiplicative noise needs order two.",
            number(off[0]),
            agrees(off[0] > 1.0)
        ))
        .with(Series::new("exact", Look::Broad, 6, exact_q.clone()))
        .with(Series::new("order one", Look::Line, 1, over_time(&one, |state| state.q[0])));
    let (x, y) = q_axis();
    let second = Figure::new("figure-2", "Figure 2: Kubo, order two", x, y)
        .shows(format!(
            "The mid-point embedding follows the exact path: at most {} off up to t = {END}. The counter-term repairs order one, too: \
             {} off. {} the paper's conclusion.",
            number(off[1]),
            number(off[2]),
            agrees(off[1] < 0.3)
        ))
        .with(Series::new("exact", Look::Broad, 6, exact_q))
        .with(Series::new("order two", Look::Line, 0, over_time(&two, |state| state.q[0])))
        .with(Series::new("order one with counter-term", Look::Dashed, 2, over_time(&corrected, |state| state.q[0])));
    let drift = two.energy_drift(&KUBO);
    let third = Figure::new("figure-3a", "Figure 3: the energy H", Axis::linear("t"), Axis::linear("H"))
        .shows(format!(
            "H is a first integral, {{H₁, H₀}} = 0. Order two keeps it to {}; order one moves it by {}, order one with counter-term \
             by {}. {} the paper's conclusion that order two keeps the energy.",
            number(drift),
            number(one.energy_drift(&KUBO)),
            number(corrected.energy_drift(&KUBO)),
            agrees(drift < 1e-13 && one.energy_drift(&KUBO) > 0.1)
        ))
        .with(Series::new("order one", Look::Line, 1, over_time(&one, |state| KUBO.energy(state))))
        .with(Series::new("order one with counter-term", Look::Line, 2, over_time(&corrected, |s| KUBO.energy(s))))
        .with(Series::new("order two", Look::Line, 0, over_time(&two, |state| KUBO.energy(state))));
    let energies = wong_zakai_energy(&two);
    let mean = energies.iter().map(|point| point.1).sum::<f64>() / energies.len() as f64;
    let deviation = crate::rms(energies.iter().map(|point| point.1 - mean));
    let expected = 0.5 * KUBO.sigma / H.sqrt();
    let fourth = Figure::new("figure-3b", "Figure 3: the energy H_WZ", Axis::linear("t"), Axis::linear("H_WZ"))
        .shows(format!(
            "H_WZ = H₀ + H₁ dW_ε/dt jumps with the noise: deviation {}, where σ |z|² / (2 √ε) = {} is expected of order \
             two; it grows without bound as ε goes to 0 and is no measure of a scheme. {} that law. (The paper prints this Hamiltonian without the dot on W.)",
            number(deviation),
            number(expected),
            agrees((deviation / expected - 1.0).abs() < 0.2)
        ))
        .with(Series::new("order one", Look::Line, 1, wong_zakai_energy(&one)))
        .with(Series::new("order two", Look::Line, 0, energies));
    let shift = |path: Vec<(f64, f64)>| -> Vec<(f64, f64)> {
        path.into_iter().map(|(t, value)| (t, (value - 1.0).abs())).collect()
    };
    let square = |state: &State<Vector>| KUBO.invariant(0, state);
    let invariant = Figure::new(
        "invariant",
        "The invariant q² + p²",
        Axis::linear("t"),
        Axis::logarithmic("deviation from 1"),
    )
    .shows(format!(
        "Proven at compile time: the mid-point embedding keeps every quadratic first integral, whatever the increments are. Measured: \
         {}. The others have no such law; the counter-term brings the error down to that of the scheme ({}).",
        number(two.invariant_drift(&KUBO, 0)?),
        number(corrected.invariant_drift(&KUBO, 0)?)
    ))
    .with(Series::new("order one", Look::Line, 1, shift(over_time(&one, square))))
    .with(Series::new("order one with counter-term", Look::Line, 2, shift(over_time(&corrected, square))))
    .with(Series::new("order two", Look::Line, 0, shift(over_time(&two, square))));
    Ok(document
        .heading("The Kubo oscillator")
        .text("H₀ = a (q² + p²)/2, H₁ = σ (q² + p²)/2 with a = 1.5, σ = 1, q(0) = 0, p(0) = 1, h = ε = 0.02. For h = ε the sampled \
               velocity of W_ε times h is the increment of W, so that both orders run on a Wiener path.")
        .figure(first)
        .figure(second)
        .figure(third)
        .figure(fourth)
        .figure(invariant))
}

pub(crate) fn work_precision() -> Result<Report, wzvi::Error> {
    KUBO.work_precision()
        .title("Kubo oscillator")
        .start(start())
        .until(1.0)
        .step_sizes((3..=9).map(|k| 2f64.powi(-k)))
        .paths(400)
        .seed(7)
        .exact(|t, wiener| exact(t, wiener[0]))
        .observe("q", |state| state.q[0])
        .scheme::<Midpoint>()
        .scheme::<Corrected<DeltaPlus>>()
        .scheme::<Uncorrected<DeltaPlus>>()
        .run()
}
