//! Figure 0: `dX = a X dt + b X ∘ dW` by four discretisations of its two integrals.

use wzvi::prelude::*;
use wzvi::report::{Axis, Document, Figure, Look, Series, number};

use crate::agrees;

type X1 = Uncorrected<DeltaPlus>;
type X21 = Uncorrected<Mixed<Midpoint, DeltaPlus>>;
type X12 = Mixed<DeltaPlus, Midpoint>;
type X2 = Midpoint;

/// X is the coordinate of this system.
#[hamiltonian(
    drift = |q, p| a * q * p,
    noise = [|q, p| b * q * p],
    embedding = [Uncorrected<DeltaPlus>, Uncorrected<Mixed<Midpoint, DeltaPlus>>, Mixed<DeltaPlus, Midpoint>, Midpoint],
)]
struct Linear {
    a: f64,
    b: f64,
}

const SYSTEM: Linear = Linear { a: 1.5, b: 1.0 };
const H: f64 = 0.01;
const STEPS: u64 = 100;
const SEED: u64 = 11;

fn path<E>() -> Result<Vec<(f64, f64)>, wzvi::Error>
where
    Linear: Discretized<E>,
{
    let start = State::new([1.0], [0.0]);
    let run = SYSTEM.simulate::<E>(H).start(start).noise(Wiener::seed(SEED)).steps(STEPS).run()?;
    Ok(run.iter().map(|state| (state.t, state.q[0])).collect())
}

pub(crate) fn append(document: Document) -> Result<Document, wzvi::Error> {
    let mut wiener = Wiener::seed(SEED);
    let (mut stratonovich, mut ito) = (vec![], vec![]);
    for n in 0..=STEPS {
        let t = n as f64 * H;
        let w = SYSTEM.b * wiener.value(0, t)?;
        stratonovich.push((t, (SYSTEM.a * t + w).exp()));
        ito.push((t, ((SYSTEM.a - 0.5 * SYSTEM.b * SYSTEM.b) * t + w).exp()));
    }
    let paths = [
        ("X₁: both of order one", path::<X1>()?),
        ("X₂₁: drift two, noise one", path::<X21>()?),
        ("X₁₂: drift one, noise two", path::<X12>()?),
        ("X₂: both of order two", path::<X2>()?),
    ];
    // Relative distance at the end.
    let end = |path: &[(f64, f64)]| path.last().map_or(f64::NAN, |point| point.1);
    let off = |path: &[(f64, f64)], exact: &[(f64, f64)]| (end(path) / end(exact) - 1.0).abs();
    let [x1, x21, x12, x2] = [0, 1, 2, 3].map(|i| off(&paths[i].1, &stratonovich));
    let holds = x1.min(x21) > 3.0 * x12.max(x2) && off(&paths[0].1, &ito).max(off(&paths[1].1, &ito)) < 0.1;
    let shows = format!(
        "The quadrature of the noise decides. With the mid-point for the noise the end is {} % (X₁₂) and {} % (X₂) off the \
         Stratonovich solution; with the left point it is {} % (X₁) and {} % (X₂₁) off, because those two converge to the Itô \
         solution, exp((a - b²/2) t + b W). The order of the drift hardly matters. {} the paper's conclusion that the noise needs the second order.",
        number(100.0 * x12),
        number(100.0 * x2),
        number(100.0 * x1),
        number(100.0 * x21),
        agrees(holds)
    );
    let axes = (Axis::linear("t"), Axis::linear("X"));
    let mut figure =
        Figure::new("figure-0", "Figure 0: the linear equation, four discretisations", axes.0, axes.1)
            .shows(shows)
            .with(Series::new("Stratonovich solution", Look::Broad, 6, stratonovich))
            .with(Series::new("Itô solution", Look::Broad, 4, ito));
    for (colour, (name, points)) in paths.into_iter().enumerate() {
        // Those of one noise nearly coincide: dashes on top of lines show both.
        let look = if colour % 2 == 0 { Look::Line } else { Look::Dashed };
        figure = figure.with(Series::new(name, look, colour, points));
    }
    Ok(document
        .heading("The linear equation")
        .text("dX = a X dt + b X ∘ dW with a = 1.5, b = 1, X(0) = 1, 100 steps of 0.01; X is the coordinate of H₀ = a q p, H₁ = b q p.")
        .figure(figure))
}
