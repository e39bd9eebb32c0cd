//! The equations of all sites at once: slopes of Hamiltonians and forces, each a sum over placements.

use crate::discretise::{
    Facts, Linearity, Plans, Role, RoleElements, SchemePlan, Stage, Strategy, Sum, Unknowns, Weighted,
};
use crate::model::{Half, System};
use crate::symbolic::{Expr, Graph, Rational, Symbol, SymbolKind, signed};

/// The Hamiltonians or the forces with one role in the step.
struct Named {
    role: Role,
    is_force: bool,
    factor: &'static str,
    name: &'static str,
    definition: &'static str,
    sum: Sum,
}

impl Named {
    /// `None` for a role that no quadrature evaluates.
    fn of(role: Role, is_force: bool, sum: Sum) -> Option<Self> {
        let (factor, name, definition) = match (role, is_force) {
            (Role::Drift, _) => ("h ", "H0", ""),
            (Role::Force, _) => ("h ", "F0", ""),
            (Role::Noise, false) => ("", "H_W", "Σ_k ΔW[k] H_k"),
            (Role::Noise, true) => ("", "F_W", "Σ_k ΔW[k] F_k"),
            (Role::CounterTerm, _) => ("", "C", "(Σ_j ΔW[j] ∂H_j/∂q) · (Σ_k ΔW[k] ∂H_k/∂p)"),
            (
                Role::Summand(_)
                | Role::Friction
                | Role::Temperature
                | Role::Integral(_)
                | Role::Observable(_)
                | Role::Clock
                | Role::ClockRate,
                _,
            ) => return None,
        };
        Some(Self { role, is_force, factor, name, definition, sum })
    }

    /// The name of its contribution to the discrete Lagrangian, or to a derivative of that; `None` if that is
    /// zero.
    fn contribution(&self, derivative: LagrangianDerivative) -> Option<String> {
        let Self { name, is_force, .. } = self;
        let reads =
            |half: Half| self.sum.iter().any(|weighted| weighted.element.of_half(half).next().is_some());
        match derivative {
            LagrangianDerivative::Value => (!is_force).then(|| (*name).to_owned()),
            LagrangianDerivative::ByMomenta => {
                (!is_force && reads(Half::Momenta)).then(|| format!("∂{name}/∂p"))
            }
            LagrangianDerivative::ByCoordinates if *is_force => Some((*name).to_owned()),
            LagrangianDerivative::ByCoordinates => reads(Half::Coordinates).then(|| format!("∂{name}/∂q")),
        }
    }
}

/// The discrete Lagrangian, or its derivative by one half of the unknowns.
#[derive(Clone, Copy, PartialEq, Eq)]
enum LagrangianDerivative {
    Value,
    ByMomenta,
    ByCoordinates,
}

/// The text of one scheme, from the discrete Lagrangian to the step.
pub(crate) fn derivation(
    system: &mut System,
    facts: &Facts,
    plans: &Plans,
    SchemePlan { quadrature, .. }: &SchemePlan,
    Strategy { unknowns, linearity }: Strategy,
) -> String {
    let mut text = String::new();
    let mut all = Vec::new();
    let is_taken = |known: &&RoleElements| quadrature.weights_of(known.role).next().is_some();
    for RoleElements { role, elements, .. } in plans.roles.iter().filter(is_taken) {
        let elements = elements.iter().cloned();
        let (forces, functions): (Sum, Sum) = elements.partition(|weighted| weighted.element.is_covector());
        let named =
            [(false, functions), (true, forces)].map(|(is_force, sum)| Named::of(*role, is_force, sum));
        all.extend(named.into_iter().flatten().filter(|named| !named.sum.is_empty()));
    }
    equations(system, &quadrature.stages, &all, &mut text);
    for half in [Half::Momenta, Half::Coordinates, Half::Displacements] {
        all.iter().for_each(|named| gradient(&mut system.graph, facts, named, half, &mut text));
    }
    let iterated = "by x <- φ(x) while that contracts, else Newton's method with the Jacobian in a band, or with GMRES \
                     where the band is wide";
    let iteration = match linearity {
        Linearity::Constant => "linear; a band is factored once, a wide matrix is iterated",
        Linearity::Affine => &format!("linear; {iterated}"),
        Linearity::Nonlinear => iterated,
    };
    let [q, _] = &system.names;
    let step = match unknowns {
        Unknowns::None => format!("assign v, Δ{q}"),
        Unknowns::Momenta => format!("solve for v (then Δ{q}): {iteration}"),
        Unknowns::Both => format!("solve for Δ{q}, v: {iteration}"),
    };
    say!(text, "\nStep\n  {step}");
    text
}

/// The discrete Lagrangian and its derivatives, by the slopes of the roles. With friction that is part of the
/// step, a term `F` acts as `e^{γlh} F(P/e^{γlh}, q_l)` at the quadrature point `l`, and
/// `p' = e^{-γh} D2 L_d`.
fn equations(system: &mut System, stages: &[Stage], all: &[Named], text: &mut String) {
    let ([q, p], graph) = (system.names.clone(), &mut system.graph);
    let has_friction = system.conformal.is_some();
    // The terms at each quadrature point, subtracted if they are no forces.
    let mut weigh = |first: &str, weight: fn(&Stage) -> Rational, derivative: LagrangianDerivative| {
        let mut terms: Vec<(bool, String)> =
            Vec::from_iter((!first.is_empty()).then(|| (false, first.into())));
        for (stage, (role, share)) in stages.iter().flat_map(|s| s.roles.iter().map(move |role| (s, role))) {
            let weight = weight(stage);
            let is_negative = share.is_negative() != weight.is_negative();
            let (mut scale, mut momentum) = (String::new(), "P".to_owned());
            if has_friction && !stage.l.is_zero() {
                let growth = exponential(stage.l);
                momentum = format!("P/{growth}");
                // The derivative by `P` divides by the factor.
                if derivative != LagrangianDerivative::ByMomenta {
                    scale = growth + " ";
                }
            }
            for named in all.iter().filter(|named| named.role == *role && !weight.is_zero()) {
                let size = size(graph, *share, weight);
                let at = point(&q, stage.l);
                let term = named
                    .contribution(derivative)
                    .map(|name| format!("{size}{}{scale}{name}({momentum}, {at})", named.factor));
                terms.extend(term.map(|term| (is_negative == named.is_force, term)));
            }
        }
        if terms.is_empty() { "0".to_owned() } else { signed(terms) }
    };
    say!(text, "\nDiscrete Lagrangian of the step from t to t + h, from {q}, {p} to {q}', {p}'");
    say!(text, "  L_d = {}", weigh(&format!("P · Δ{q}"), |_| Rational::ONE, LagrangianDerivative::Value));
    let mut end = weigh("P", Stage::end, LagrangianDerivative::ByCoordinates);
    if has_friction {
        end = format!("exp(-γ h) ({end})");
    }
    let v = weigh("", Stage::start, LagrangianDerivative::ByCoordinates);
    let velocity = weigh("", |_| Rational::MINUS_ONE, LagrangianDerivative::ByMomenta);
    for Named { name, definition, .. } in all.iter().filter(|named| !named.definition.is_empty()) {
        say!(text, "  {name} = {definition}");
    }
    say!(text, "  Δ{q} = {q}' - {q}");
    for stage in stages.iter().filter(|stage| !stage.l.is_zero()) {
        say!(text, "  {} = {q} + {} Δ{q}", point(&q, stage.l), stage.l);
    }
    say!(text, "\nDiscrete Euler-Lagrange equations");
    say!(text, "  ∂L_d/∂P = 0:  Δ{q} = {velocity}");
    say!(text, "  {p} = -D1 L_d:  P = {p} + v,  v = {v}");
    say!(text, "  {p}' = {}:  {p}' = {end}", if has_friction { "exp(-γ h) D2 L_d" } else { "D2 L_d" });
    say!(text, "  with these contributions to the slopes");
}

/// The size of a product as a factor.
fn size(graph: &mut Graph, a: Rational, b: Rational) -> String {
    let [a, b] = [a, b].map(|factor| if factor.is_negative() { factor.negate() } else { factor });
    let size = graph.number(a);
    let size = graph.scale(size, b);
    if graph.is_one(size) { String::new() } else { format!("{} ", graph.display(size)) }
}

/// `e^{γlh}`
fn exponential(l: Rational) -> String {
    if l.is_one() { "exp(γ h)".to_owned() } else { format!("exp({l} γ h)") }
}

/// `q` at a quadrature point.
fn point(q: &str, l: Rational) -> String {
    match l {
        _ if l.is_zero() => q.to_owned(),
        _ if l.is_one() => format!("{q}'"),
        _ => format!("{q}_{{{l}}}"),
    }
}

/// The contributions of a role to its slopes by one half, line by line.
fn gradient(graph: &mut Graph, facts: &Facts, named: &Named, half: Half, text: &mut String) {
    let Named { name, sum, .. } = named;
    for Weighted { element, increments } in
        sum.iter().filter(|_| named.is_force == (half == Half::Displacements))
    {
        let (space, loops) = (&facts.space, &element.loops);
        let slopes =
            element.of_half(half).map(|(variable, _)| (variable, graph.derivative(element.value, variable)));
        let slopes: Vec<(Symbol, Expr)> = slopes.collect();
        let spelled = space.spelled(graph, element);
        let images = element.locals.iter().map(|local| (local.symbol, graph.symbol(spelled[&local.symbol])));
        let images = images.collect();
        let increments = increments.iter().map(|k| format!("ΔW[{}]", space.index(loops, k)));
        let increments: Vec<_> =
            increments.map(|name| graph.new_symbol(SymbolKind::Increment, name)).collect();
        for (variable, slope) in slopes {
            let mut factors = graph.substitute(&[slope], &images);
            factors.extend(increments.iter().map(|&increment| graph.symbol(increment)));
            let slope = graph.product(&factors);
            let place = graph.symbol_name(spelled[&variable]);
            let place = match place.strip_prefix('δ').filter(|_| named.is_force) {
                Some(place) => format!("{name} along {place}"),
                None => format!("∂{name}/∂{place}"),
            };
            if !graph.is_zero(slope) {
                say!(text, "    {place} += {}{}", graph.display(slope), space.placements(loops));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop")]

    use crate::compile::expand;

    /// Loops have the discrete Lagrangian of straight lines: `h e^{γlh} H(P/e^{γlh}, q_l)`, and a new
    /// momentum that is damped over the whole step.
    #[test]
    fn friction_of_steps_is_in_every_equation_of_loops() {
        let attribute = "drift = |q: &[f64], p: &[f64]| p.iter().map(|p| 0.5 * p * p).sum::<f64>() \
            + (1..q.len()).map(|i| (q[i] - q[i - 1]).powi(4)).sum::<f64>(), friction = gamma, embedding = [Midpoint, DeltaPlus]";
        let item = "struct Chain { gamma: f64 }";
        let code = expand(attribute.parse().unwrap(), item.parse().unwrap()).to_string();
        for equation in [
            "L_d = P · Δq - h exp(1/2 γ h) H0(P/exp(1/2 γ h), q_{1/2})",
            "Δq = h ∂H0/∂p(P/exp(1/2 γ h), q_{1/2})",
            "v = -1/2 h exp(1/2 γ h) ∂H0/∂q(P/exp(1/2 γ h), q_{1/2})",
            "p' = exp(-γ h) D2 L_d:  p' = exp(-γ h) (P - 1/2 h exp(1/2 γ h) ∂H0/∂q(P/exp(1/2 γ h), q_{1/2}))",
            "L_d = P · Δq - h H0(P, q)",
            "p' = exp(-γ h) D2 L_d:  p' = exp(-γ h) (P)",
        ] {
            assert!(code.contains(equation), "{equation}\n{}", code.replace("\\n", "\n"));
        }
    }
}
