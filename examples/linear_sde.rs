//! The quadrature point of the noise decides the limit of a scheme: `dX = a X dt + b X ∘ dW` by the four discretisations
//! of the paper's first figure.
//!
//! The equation is the q-part of `H0 = a q p`, `H1 = b q p`. With the quadrature points `l0` of the drift and `l1` of the noise,
//! `X_{i+1} - X_i = a h X_{l0} + b ΔW X_{l1}` with `X_l = (1 - l) X_i + l X_{i+1}`:
//!
//! | paper | drift    | noise    | embedding                                   |
//! |-------|----------|----------|---------------------------------------------|
//! | X1    | l0 = 0   | l1 = 0   | `Uncorrected<DeltaPlus>`                    |
//! | X21   | l0 = 1/2 | l1 = 0   | `Uncorrected<Mixed<Midpoint, DeltaPlus>>`   |
//! | X12   | l0 = 0   | l1 = 1/2 | `Mixed<DeltaPlus, Midpoint>`                |
//! | X2    | l0 = 1/2 | l1 = 1/2 | `Midpoint`                                  |
//!
//! Run with `cargo run --release --features svg --example linear_sde`.

#[path = "support/plot.rs"]
mod plot;
#[path = "support/table.rs"]
mod table;

use std::error::Error;

use table::Mean;
use wzvi::nalgebra::SVector;
use wzvi::noise::Paths;
use wzvi::plot::{Colour, Figure, Look};
use wzvi::prelude::*;

#[hamiltonian(
    drift = |q, p| a * q * p,
    noise = [|q, p| b * q * p],
    embedding = [Uncorrected<DeltaPlus>, Uncorrected<Mixed<Midpoint, DeltaPlus>>, Mixed<DeltaPlus, Midpoint>, Midpoint],
)]
struct Linear {
    a: f64,
    b: f64,
}

type Point = SVector<f64, 1>;
type X1 = Uncorrected<DeltaPlus>;
type X21 = Uncorrected<Mixed<Midpoint, DeltaPlus>>;
type X12 = Mixed<DeltaPlus, Midpoint>;
type X2 = Midpoint;

const LINEAR: Linear = Linear { a: 1.5, b: 1.0 };
const N: u64 = 100;
const H: f64 = 0.01;
const PATHS: u64 = 10_000;

fn main() -> Result<(), Box<dyn Error>> {
    println!(
        "dX = {} X dt + {} X ∘ dW, X(0) = 1, N = {N} steps of h = {H}, {PATHS} paths\n",
        LINEAR.a, LINEAR.b
    );
    let rows = [
        row::<X1>("X1", "DeltaPlus", [0.0, 0.0])?,
        row::<X21>("X21", "Mixed<Midpoint, DeltaPlus>", [0.5, 0.0])?,
        row::<X12>("X12", "Mixed<DeltaPlus, Midpoint>", [0.0, 0.5])?,
        row::<X2>("X2", "Midpoint", [0.5, 0.5])?,
    ];
    table::print(
        ["", "embedding", "consistent", "q-equation", "rms error", "rms error to Ito", "mean of X(1)/exact"],
        &rows,
    );
    println!(
        "\n  q-equation: largest |ΔX - a h X_l0 - b ΔW X_l1| on a path. Errors at t = 1 are relative:\n  \
         to the exact solution exp(a t + b W), and to that of the equation in the sense of Ito, exp((a - b²/2) t + b W).\n  \
         With the noise at the left end the limit is the latter: mean of X(1)/exact → exp(-b²/2) = {:.4}.\n",
        (-0.5 * LINEAR.b * LINEAR.b).exp()
    );

    let exact = path::<X2>()?.1;
    let mut paths = Figure::panel("One path", "time t", "X").points(
        Look::Broad,
        "exact",
        Colour::GREY,
        exact.iter().copied(),
    );
    let mut ratios = Figure::panel("Divided by the exact solution", "time t", "X / exact")
        .y_range(0.5..1.1)
        .points(Look::Broad, "exact", Colour::GREY, [(0.0, 1.0), (1.0, 1.0)])
        .points(
            Look::Dashed,
            "exp(-b² t/2)",
            Colour::GREY,
            exact.iter().map(|&(t, _)| (t, (-0.5 * LINEAR.b * LINEAR.b * t).exp())),
        );
    let curves: [(&str, usize, Curve); 4] = [
        ("X1", Colour::VERMILION, path::<X1>()?.0),
        ("X21", Colour::OCHRE, path::<X21>()?.0),
        ("X12", Colour::GREEN, path::<X12>()?.0),
        ("X2", Colour::BLUE, path::<X2>()?.0),
    ];
    for (label, color, curve) in curves {
        let ratio = curve.iter().zip(&exact).map(|(&(t, x), &(_, exact))| (t, x / exact)).collect::<Curve>();
        paths = paths.line(label, color, curve);
        ratios = ratios.line(label, color, ratio);
    }
    plot::save("linear_sde", "discretisations", 1, (1400, 700), &[paths, ratios])
}

type Curve = Vec<(f64, f64)>;

/// The momentum has no part in the q-equation: zero will do.
fn start() -> State<Point> {
    State::new([1.0], [0.0])
}

fn exact(t: f64, w: f64) -> f64 {
    (LINEAR.a * t + LINEAR.b * w).exp()
}

/// A scheme and the exact solution on one path.
fn path<E>() -> Result<(Curve, Curve), wzvi::Error>
where
    Linear: Discretized<E, Vector = Point>,
{
    let path = LINEAR.simulate::<E>(H).start(start()).noise(Wiener::seed(5)).steps(N).run()?;
    let w = path.wiener(0);
    let solution = path.times().zip(w).map(|(t, w)| (t, exact(t, w))).collect();
    Ok((path.iter().map(|state| (state.t, state.q[0])).collect(), solution))
}

fn row<E>(name: &str, embedding: &str, [l0, l1]: [f64; 2]) -> Result<[String; 7], wzvi::Error>
where
    Linear: Discretized<E, Vector = Point>,
{
    let Linear { a, b } = LINEAR;
    let path = LINEAR.simulate::<E>(H).start(start()).noise(Wiener::seed(5)).steps(N).run()?;
    let residual = path.states().windows(2).zip(path.increments()).map(|(ends, dw)| {
        let [from, to] = [ends[0].q[0], ends[1].q[0]];
        let at = |l: f64| (1.0 - l) * from + l * to;
        (to - from - a * H * at(l0) - b * dw[0] * at(l1)).abs()
    });
    let residual = residual.fold(0.0, f64::max);

    let mut noise = Wiener::seed(5);
    let (mut stratonovich, mut ito, mut ratio) = (Mean::default(), Mean::default(), Mean::default());
    for path in 0..PATHS {
        noise.set_path(path);
        let path = LINEAR.simulate::<E>(H).start(start()).noise(&mut noise).steps(N).record_every(0).run()?;
        let quotient = path.last().q[0] / exact(1.0, path.wiener(0)[1]);
        stratonovich.add((quotient - 1.0).powi(2));
        ito.add((quotient * (0.5 * b * b).exp() - 1.0).powi(2));
        ratio.add(quotient);
    }
    Ok([
        name.into(),
        embedding.into(),
        if <Linear as Discretized<E>>::PLAN.consistent { "yes" } else { "no" }.into(),
        format!("{residual:.0e}"),
        format!("{:.4}", stratonovich.value().sqrt()),
        format!("{:.4}", ito.value().sqrt()),
        format!("{:.4} ± {:.4}", ratio.value(), ratio.standard_error()),
    ])
}
