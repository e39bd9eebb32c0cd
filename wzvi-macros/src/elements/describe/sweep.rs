//! The equations of all sites at once, in indices: what stands at site `i`, with its neighbours.

use std::fmt::Write;

use crate::discretise::embedding::Embedding;
use crate::discretise::facts::{Facts, drift_and_noise};
use crate::discretise::sums::{Half, Slope, Space, Sum};
use crate::elements::plan::Unknowns;
use crate::model::System;
use crate::symbolic::{Expr, Graph, Rational};

/// A part of the step Hamiltonian `F = Σ_m c_m H_m(P, Q_l)`: its quadrature point, and a factor.
struct Part {
    sum: Sum,
    l: Rational,
    factor: Rational,
    /// Whether it is weighted by the step size, not by increments.
    is_drift: bool,
}

/// From the discrete Lagrangian to the step.
pub(super) fn sweep(
    system: &mut System,
    facts: &Facts,
    embedding: &Embedding,
    (unknowns, is_linear): (Unknowns, bool),
    text: &mut String,
) {
    let [drift, noise] = drift_and_noise(system);
    let (drift_l, noise_l) = embedding.quadrature();
    let counter = facts.counter_of(embedding).to_vec();
    let defect = Rational::HALF.add(noise_l.negate()).unwrap_or(Rational::ZERO);
    let has_noise = !noise.is_empty();
    let parts = [
        Part { sum: drift, l: drift_l, factor: Rational::ONE, is_drift: true },
        Part { sum: noise, l: noise_l, factor: Rational::ONE, is_drift: false },
        Part { sum: counter.clone(), l: noise_l, factor: defect, is_drift: false },
    ];
    let [q, p] = system.names.clone();
    let _ = writeln!(text, "\nDiscrete Lagrangian of the step from t to t + h, from {q}, {p} to {q}', {p}'");
    let points = [Some(drift_l), has_noise.then_some(noise_l).filter(|l| *l != drift_l)];
    let noises =
        if has_noise { format!(" - Σ_k ΔW[k] H_k(P, {})", point(&q, noise_l)) } else { String::new() };
    let _ = writeln!(text, "  L_d = Σ_i P[i] Δ{q}[i] - h H0(P, {}){noises}", point(&q, drift_l));
    if !counter.is_empty() {
        let at = point(&q, noise_l);
        let _ = writeln!(
            text,
            "        - (1/2 - {noise_l}) (Σ_j ΔW[j] ∂H_j/∂{q}) · (Σ_k ΔW[k] ∂H_k/∂{p}) at (P, {at})"
        );
    }
    let _ = writeln!(text, "  Δ{q} = {q}' - {q}");
    for l in points.into_iter().flatten().filter(|l| !l.is_zero()) {
        let _ = writeln!(text, "  {} = {q} + {l} Δ{q}", point(&q, l));
    }

    let _ = writeln!(text, "\nDiscrete Euler-Lagrange equations");
    for component in 0..system.components {
        let at = if system.components == 1 { "[i]".to_owned() } else { format!("[i][{component}]") };
        let (space, graph) = (&facts.space, &mut system.graph);
        let mut equation = |half: Half, weight: &dyn Fn(Rational) -> Rational, text: &mut String| {
            for part in &parts {
                terms(space, graph, &q, part, (half, component), weight(part.l), text);
            }
        };
        let _ = writeln!(text, "  ∂L_d/∂P = 0:  Δ{q}{at} is the sum of");
        equation(Half::Momenta, &|_| Rational::ONE, text);
        let _ = writeln!(text, "  {p} = -D1 L_d:  P{at} = {p}{at} + v{at}, v{at} is the sum of");
        equation(Half::Coordinates, &|l| l.add(Rational::MINUS_ONE).unwrap_or(Rational::ZERO), text);
        if points.into_iter().flatten().all(|l| l.is_zero()) {
            let _ = writeln!(text, "  {p}' = D2 L_d:  {p}'{at} = P{at}");
        } else {
            let _ = writeln!(text, "  {p}' = D2 L_d:  {p}'{at} = P{at} + the sum of");
            equation(Half::Coordinates, &Rational::negate, text);
        }
    }
    let _ = writeln!(text, "\nStep");
    let iterated = "by x <- φ(x) while that contracts, else Newton's method with the Jacobian in a band, or with GMRES \
                     where the band is wide";
    let iteration =
        if is_linear { "linear; a band is factored once, a wide matrix is iterated" } else { iterated };
    let _ = match unknowns {
        Unknowns::None => writeln!(text, "  assign v, Δ{q}"),
        Unknowns::Momenta => writeln!(text, "  solve for v (then Δ{q}): {iteration}"),
        Unknowns::Both => writeln!(text, "  solve for Δ{q}, v: {iteration}"),
    };
}

/// `q` at a quadrature point.
fn point(q: &str, l: Rational) -> String {
    match l {
        _ if l.is_zero() => q.to_owned(),
        _ if l.is_one() => format!("{q}'"),
        _ => format!("{q}_{{{l}}}"),
    }
}

/// The slopes of one part, line by line.
fn terms(
    space: &Space,
    graph: &mut Graph,
    q: &str,
    part: &Part,
    (half, component): (Half, i128),
    weight: Rational,
    text: &mut String,
) {
    let Some(factor) = weight.multiply(part.factor).filter(|factor| !factor.is_zero()) else { return };
    let mut space = space.renamed([point(q, part.l), "P".to_owned()]);
    let Some(slopes) = space.slopes(graph, &part.sum, half, component) else {
        let _ = writeln!(text, "    slopes whose indices exceed 128 bits");
        return;
    };
    for Slope { part: mut weighted, at, is_by_point } in slopes {
        let mut factors: Vec<Expr> = vec![weighted.element.value];
        let names: Vec<String> = match part.is_drift {
            true => vec!["h".to_owned()],
            false => weighted.increments.iter().map(|k| format!("ΔW[{}]", space.index(k))).collect(),
        };
        for name in names {
            let symbol = graph.new_symbol(name);
            factors.push(graph.symbol(symbol));
        }
        let product = graph.product(&factors);
        weighted.element.value = graph.scale(product, factor);
        let slope = Slope { part: weighted, at, is_by_point };
        let _ = writeln!(text, "    {}", space.display_slope(graph, &slope));
    }
}
