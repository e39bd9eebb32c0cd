//! The equations of all sites at once: slopes of Hamiltonians and forces, each a sum over placements.

use crate::discretise::{
    Facts, Part, PartElements, Plans, SchemePlan, Stage, Strategy, Sum, Unknowns, Weighted,
};
use crate::model::{Half, System};
use crate::symbolic::{Expr, Graph, Rational, Symbol, signed};

/// The Hamiltonians or the forces of a part of the step.
struct Named {
    part: Part,
    is_force: bool,
    factor: &'static str,
    name: &'static str,
    definition: &'static str,
    sum: Sum,
}

impl Named {
    fn of(part: Part, is_force: bool, sum: Sum) -> Self {
        let (factor, name, definition) = match (part, is_force) {
            (Part::Drift, _) => ("h ", "H0", ""),
            (Part::Force, _) => ("h ", "F0", ""),
            (Part::Noise, false) => ("", "H_W", "Σ_k ΔW[k] H_k"),
            (Part::Noise, true) => ("", "F_W", "Σ_k ΔW[k] F_k"),
            (Part::CounterTerm, _) => ("", "C", "(Σ_j ΔW[j] ∂H_j/∂q) · (Σ_k ΔW[k] ∂H_k/∂p)"),
        };
        Self { part, is_force, factor, name, definition, sum }
    }

    /// The contribution to `∂L_d/∂P`.
    fn by_p(&self) -> Option<String> {
        let is_there = !self.is_force && self.sum.iter().any(|weighted| weighted.element.reads().p);
        is_there.then(|| format!("∂{}/∂p", self.name))
    }

    /// The contribution to the change of the momenta.
    fn by_q(&self) -> Option<String> {
        let is_there = self.sum.iter().any(|weighted| weighted.element.reads().q);
        match self.is_force {
            true => Some(self.name.to_owned()),
            false => is_there.then(|| format!("∂{}/∂q", self.name)),
        }
    }
}

/// The text of one scheme, from the discrete Lagrangian to the step.
pub(crate) fn derivation(
    system: &mut System,
    facts: &Facts,
    plans: &Plans,
    SchemePlan { quadrature, .. }: &SchemePlan,
    Strategy { unknowns, is_linear }: Strategy,
) -> String {
    let mut text = String::new();
    let mut parts = Vec::new();
    let is_taken = |part: &&PartElements| quadrature.weights_of(part.part).next().is_some();
    for PartElements { part, elements, .. } in plans.parts.iter().filter(is_taken) {
        let elements = elements.iter().cloned();
        let (forces, functions): (Sum, Sum) = elements.partition(|weighted| weighted.element.is_covector());
        let named =
            [(false, functions), (true, forces)].map(|(is_force, sum)| Named::of(*part, is_force, sum));
        parts.extend(named.into_iter().filter(|named| !named.sum.is_empty()));
    }
    equations(system, &quadrature.stages, &parts, &mut text);
    // In a copy: the order of products in the code is that in which their nodes were made.
    let graph = &mut system.graph.clone();
    for half in [Half::Momenta, Half::Coordinates, Half::Displacements] {
        parts.iter().for_each(|part| gradient(graph, facts, part, half, &mut text));
    }
    let iterated = "by x <- φ(x) while that contracts, else Newton's method with the Jacobian in a band, or with GMRES \
                     where the band is wide";
    let iteration =
        if is_linear { "linear; a band is factored once, a wide matrix is iterated" } else { iterated };
    let [q, _] = &system.names;
    let step = match unknowns {
        Unknowns::None => format!("assign v, Δ{q}"),
        Unknowns::Momenta => format!("solve for v (then Δ{q}): {iteration}"),
        Unknowns::Both => format!("solve for Δ{q}, v: {iteration}"),
    };
    say!(text, "\nStep\n  {step}");
    text
}

/// The discrete Lagrangian and its derivatives, by the slopes of the parts.
fn equations(system: &mut System, stages: &[Stage], parts: &[Named], text: &mut String) {
    let ([q, p], graph) = (system.names.clone(), &mut system.graph);
    // The parts at each quadrature point, subtracted if they are no forces.
    let mut weigh = |first: &str, weight: fn(&Stage) -> Rational, write: fn(&Named) -> Option<String>| {
        let mut terms: Vec<(bool, String)> =
            Vec::from_iter((!first.is_empty()).then(|| (false, first.into())));
        for (stage, (part, share)) in stages.iter().flat_map(|s| s.parts.iter().map(move |part| (s, part))) {
            let weight = weight(stage);
            let is_negative = share.is_negative() != weight.is_negative();
            for named in parts.iter().filter(|named| named.part == *part && !weight.is_zero()) {
                let size = size(graph, *share, weight);
                let at = point(&q, stage.l);
                let term = write(named).map(|name| format!("{size}{}{name}(P, {at})", named.factor));
                terms.extend(term.map(|term| (is_negative == named.is_force, term)));
            }
        }
        if terms.is_empty() { "0".to_owned() } else { signed(terms) }
    };
    say!(text, "\nDiscrete Lagrangian of the step from t to t + h, from {q}, {p} to {q}', {p}'");
    let of_function = |named: &Named| (!named.is_force).then(|| named.name.to_owned());
    say!(text, "  L_d = {}", weigh(&format!("P · Δ{q}"), |_| Rational::ONE, of_function));
    let end = weigh("P", Stage::end, Named::by_q);
    let (v, velocity) =
        (weigh("", Stage::start, Named::by_q), weigh("", |_| Rational::MINUS_ONE, Named::by_p));
    for Named { name, definition, .. } in parts.iter().filter(|named| !named.definition.is_empty()) {
        say!(text, "  {name} = {definition}");
    }
    say!(text, "  Δ{q} = {q}' - {q}");
    for stage in stages.iter().filter(|stage| !stage.l.is_zero()) {
        say!(text, "  {} = {q} + {} Δ{q}", point(&q, stage.l), stage.l);
    }
    say!(text, "\nDiscrete Euler-Lagrange equations");
    say!(text, "  ∂L_d/∂P = 0:  Δ{q} = {velocity}");
    say!(text, "  {p} = -D1 L_d:  P = {p} + v,  v = {v}");
    say!(text, "  {p}' = D2 L_d:  {p}' = {end}");
    say!(text, "  with these contributions to the slopes");
}

/// The size of a product as a factor.
fn size(graph: &mut Graph, a: Rational, b: Rational) -> String {
    let [a, b] = [a, b].map(|factor| if factor.is_negative() { factor.negate() } else { factor });
    let size = graph.number(a);
    let size = graph.scale(size, b);
    if graph.is_one(size) { String::new() } else { format!("{} ", graph.display(size)) }
}

/// `q` at a quadrature point.
fn point(q: &str, l: Rational) -> String {
    match l {
        _ if l.is_zero() => q.to_owned(),
        _ if l.is_one() => format!("{q}'"),
        _ => format!("{q}_{{{l}}}"),
    }
}

/// The contributions of a part to its slopes by one half, line by line.
fn gradient(graph: &mut Graph, facts: &Facts, part: &Named, half: Half, text: &mut String) {
    let Named { name, sum, .. } = part;
    for Weighted { element, increments } in
        sum.iter().filter(|_| part.is_force == (half == Half::Displacements))
    {
        let (space, loops) = (&facts.space, &element.loops);
        let slopes =
            element.of_half(half).map(|(variable, _)| (variable, graph.derivative(element.value, variable)));
        let slopes: Vec<(Symbol, Expr)> = slopes.collect();
        let spelled = space.spelled(graph, element);
        // In the order of the element, in which the nodes of sums are then written.
        let images = element.locals.iter().map(|local| (local.symbol, graph.symbol(spelled[&local.symbol])));
        let images = images.collect();
        let increments = increments.iter().map(|k| format!("ΔW[{}]", space.index(loops, k)));
        let increments: Vec<_> = increments.map(|name| graph.new_symbol(name)).collect();
        for (variable, slope) in slopes {
            let mut factors = graph.substitute(&[slope], &images);
            factors.extend(increments.iter().map(|&increment| graph.symbol(increment)));
            let slope = graph.product(&factors);
            let place = graph.symbol_name(spelled[&variable]);
            let place = match place.strip_prefix('δ').filter(|_| part.is_force) {
                Some(place) => format!("{name} along {place}"),
                None => format!("∂{name}/∂{place}"),
            };
            if !graph.is_zero(slope) {
                say!(text, "    {place} += {}{}", graph.display(slope), space.placements(loops));
            }
        }
    }
}
