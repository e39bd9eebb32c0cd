//! The equations of all sites at once, written for site `i` and its neighbours.

use std::fmt::Write;

use super::{hamiltonians, properties};
use crate::discretise::{
    Facts, Part, Quadrature, Slope, Space, Stage, Strategy, Sum, Unknowns, Weighted, parts_of,
};
use crate::embedding::Embedding;
use crate::model::{Half, System};
use crate::symbolic::{Expr, Graph, Rational};

/// The text of one scheme.
pub(crate) fn describe(
    system: &mut System,
    facts: &Facts,
    embedding: &Embedding,
    strategy: Strategy,
) -> String {
    let mut text = format!("{embedding}\n{}", hamiltonians(system, facts));
    sweep(system, facts, embedding, strategy, &mut text);
    properties(&mut system.graph, facts, embedding, &mut text);
    text
}

/// From the discrete Lagrangian to the step.
fn sweep(
    system: &mut System,
    facts: &Facts,
    embedding: &Embedding,
    Strategy { unknowns, is_linear }: Strategy,
    text: &mut String,
) {
    let Quadrature { stages } = Quadrature::new(facts, embedding);
    let parts = parts_of(system, facts);
    let is_covector = |weighted: &Weighted| weighted.element.is_covector();
    let sum_of = |part: Part, of_covectors: bool| -> Sum {
        let known = parts.iter().find(|known| known.part == part).into_iter();
        let elements = known.flat_map(|known| &known.values);
        elements.filter(|weighted| is_covector(weighted) == of_covectors).cloned().collect()
    };
    let [q, p] = system.names.clone();
    say!(text, "\nDiscrete Lagrangian of the step from t to t + h, from {q}, {p} to {q}', {p}'");
    let _ = write!(text, "  L_d = Σ_i P[i] Δ{q}[i]");
    for stage in &stages {
        let at = point(&q, stage.l);
        for (part, weight) in &stage.parts {
            let (sign, size) = match weight.is_negative() {
                true => ("+", weight.negate()),
                false => ("-", *weight),
            };
            let share = if size.is_one() { String::new() } else { format!("{size} ") };
            let _ = match part {
                Part::Drift => write!(text, " {sign} {share}h H0(P, {at})"),
                Part::Noise if sum_of(Part::Noise, false).is_empty() => Ok(()),
                Part::Noise => write!(text, " {sign} {share}Σ_k ΔW[k] H_k(P, {at})"),
                // Forces do virtual work and do not enter `L_d`.
                Part::Force => Ok(()),
                Part::CounterTerm => {
                    let product = format!("(Σ_j ΔW[j] ∂H_j/∂{q}) · (Σ_k ΔW[k] ∂H_k/∂{p})");
                    write!(text, "\n        {sign} {size} {product} at (P, {at})")
                }
            };
        }
    }
    say!(text, "\n  Δ{q} = {q}' - {q}");
    for stage in stages.iter().filter(|stage| !stage.l.is_zero()) {
        say!(text, "  {} = {q} + {} Δ{q}", point(&q, stage.l), stage.l);
    }

    say!(text, "\nDiscrete Euler-Lagrange equations");
    for component in 0..system.components {
        let at = if system.components == 1 { "[i]".to_owned() } else { format!("[i][{component}]") };
        let (space, graph) = (&facts.space, &mut system.graph);
        let mut equation = |half: Half, slope_weight: &dyn Fn(&Stage) -> Rational, text: &mut String| {
            for stage in &stages {
                for &(part, weight) in &stage.parts {
                    let mut write = |half: Half, weights: [Rational; 2], text: &mut String| {
                        let mut space = space.renamed([point(&q, stage.l), "P".to_owned()]);
                        let sum = (part, sum_of(part, half == Half::Displacements));
                        write_slopes(&mut space, graph, (half, component), sum, weights, text);
                    };
                    let slope = slope_weight(stage);
                    write(half, [weight, slope], text);
                    if half == Half::Coordinates {
                        write(Half::Displacements, [weight, slope.negate()], text);
                    }
                }
            }
        };
        say!(text, "  ∂L_d/∂P = 0:  Δ{q}{at} is the sum of");
        equation(Half::Momenta, &|_| Rational::ONE, text);
        say!(text, "  {p} = -D1 L_d:  P{at} = {p}{at} + v{at}, v{at} is the sum of");
        equation(Half::Coordinates, &|stage| stage.start().negate(), text);
        if stages.iter().all(|stage| stage.end().is_zero()) {
            say!(text, "  {p}' = D2 L_d:  {p}'{at} = P{at}");
        } else {
            say!(text, "  {p}' = D2 L_d:  {p}'{at} = P{at} + the sum of");
            equation(Half::Coordinates, &|stage| stage.end().negate(), text);
        }
    }
    say!(text, "\nStep");
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

/// The slopes of one part, weighted, line by line.
fn write_slopes(
    space: &mut Space,
    graph: &mut Graph,
    (half, component): (Half, i128),
    (part, sum): (Part, Sum),
    weights: [Rational; 2],
    text: &mut String,
) {
    if sum.is_empty() || weights.iter().any(|weight| weight.is_zero()) {
        return;
    }
    let Some(slopes) = space.slopes(graph, &sum, half, component) else {
        say!(text, "    slopes whose indices exceed 128 bits");
        return;
    };
    for Slope { part: mut weighted, at, is_by_point } in slopes {
        let mut factors: Vec<Expr> = vec![weighted.element.value];
        let names: Vec<String> = match part {
            Part::Drift | Part::Force => vec!["h".to_owned()],
            _ => weighted
                .increments
                .iter()
                .map(|k| format!("ΔW[{}]", space.index(&weighted.element.loops, k)))
                .collect(),
        };
        for name in names {
            let symbol = graph.new_symbol(name);
            factors.push(graph.symbol(symbol));
        }
        let product = graph.product(&factors);
        weighted.element.value =
            weights.iter().fold(product, |product, &weight| graph.scale(product, weight));
        let slope = Slope { part: weighted, at, is_by_point };
        say!(text, "    {}", space.display_slope(graph, &slope));
    }
}
