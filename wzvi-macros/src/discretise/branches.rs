//! Continuity of piecewise Hamiltonians and of their slopes across branch boundaries.
//!
//! On `d = 0`, the boundary of a comparison `a < b` with `d = a - b`, the values of the Hamiltonian with this comparison true
//! and false are compared. If `d` is affine in a variable, the boundary gives that variable as a function of the others, and
//! continuity means that an expression is zero.

use std::collections::HashMap;

use crate::symbolic::{Expr, Function, Graph, Node, Relation, Symbol, Witness, ZeroTest};

/// The surface where a branch ends.
#[derive(Clone, Debug)]
pub(crate) struct Boundary {
    /// As an equation: `q = 1`.
    pub(crate) place: String,
    pub(crate) crossing: Crossing,
}

/// The smoothness of a Hamiltonian at a boundary.
#[derive(Clone, Debug)]
pub(crate) enum Crossing {
    /// It and its first derivatives are continuous.
    Smooth,
    /// It is continuous; its first derivatives are not, or may not be.
    Kink,
    Jump(Witness),
    Undecided,
}

/// The boundaries inside of `value` that the variables `state` can cross.
pub(crate) fn boundaries(graph: &mut Graph, value: Expr, state: &[Symbol]) -> Vec<Boundary> {
    let mut found = Vec::new();
    for decision in graph.reachable(&[value]) {
        let (left, right, sides) = match *graph.node(decision) {
            Node::Compare(_, left, right) => {
                let (zero, one) = (graph.integer(0), graph.integer(1));
                let sides = [(zero, one), (one, zero)].map(|(a, b)| graph.compare(Relation::Less, a, b));
                (left, right, sides)
            }
            Node::Apply(Function::Signum, ref arguments) => {
                let argument = arguments[0];
                (argument, graph.integer(0), [graph.integer(1), graph.integer(-1)])
            }
            Node::Apply(Function::Abs, ref arguments) => {
                let argument = arguments[0];
                (argument, graph.integer(0), [argument, graph.negate(argument)])
            }
            Node::Apply(Function::Min | Function::Max, ref arguments) => {
                let sides = [arguments[0], arguments[1]];
                (sides[0], sides[1], sides)
            }
            _ => continue,
        };
        // `abs`, `min` and `max` have equal sides on their boundary.
        let may_jump = matches!(graph.node(decision), Node::Compare(..) | Node::Apply(Function::Signum, _));
        if !graph.depends_on(left, state) && !graph.depends_on(right, state) {
            continue;
        }
        let sides = sides.map(|side| {
            let parts = graph.reachable(&[value]);
            graph.rewritten(&[value], parts, |_, part| (part == decision).then_some(side))[0]
        });
        let jump = graph.subtract(sides[0], sides[1]);
        if matches!(graph.test_zero(jump), ZeroTest::Zero) {
            continue;
        }
        let crossing = match crossing(graph, (left, right), jump, state) {
            Crossing::Undecided if !may_jump => Crossing::Kink,
            crossing => crossing,
        };
        let (first, second) = if graph.depends_on(left, state) { (left, right) } else { (right, left) };
        let place = format!("{} = {}", graph.display(first), graph.display(second));
        found.push(Boundary { place, crossing });
    }
    found
}

fn crossing(graph: &mut Graph, (left, right): (Expr, Expr), jump: Expr, state: &[Symbol]) -> Crossing {
    let difference = graph.subtract(left, right);
    let Some(surface) = state.iter().find_map(|&symbol| solved(graph, difference, symbol, state)) else {
        return Crossing::Undecided;
    };
    let on_surface = graph.substitute(&[jump], &surface)[0];
    match graph.test_zero(on_surface) {
        ZeroTest::Nonzero(witness) => return Crossing::Jump(witness),
        ZeroTest::Unknown => return Crossing::Undecided,
        ZeroTest::Zero => {}
    }
    let is_smooth = state.iter().all(|&symbol| {
        let slope = graph.derivative(jump, symbol);
        let slope = graph.substitute(&[slope], &surface)[0];
        matches!(graph.test_zero(slope), ZeroTest::Zero)
    });
    if is_smooth { Crossing::Smooth } else { Crossing::Kink }
}

/// `difference = 0`, solved for `symbol`, if it is affine in it with a slope that the state does not change.
fn solved(
    graph: &mut Graph,
    difference: Expr,
    symbol: Symbol,
    state: &[Symbol],
) -> Option<HashMap<Symbol, Expr>> {
    let slope = graph.derivative(difference, symbol);
    if graph.is_zero(slope) || graph.depends_on(slope, state) || graph.has_pieces(difference, &[symbol]) {
        return None;
    }
    let zero = graph.integer(0);
    let rest = graph.substitute(&[difference], &HashMap::from([(symbol, zero)]))[0];
    let rest = graph.negate(rest);
    Some(HashMap::from([(symbol, graph.divide(rest, slope))]))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use crate::compile::expand;

    /// The facts that the scheme `Midpoint` of a drift states.
    fn facts(drift: &str) -> String {
        let attribute = format!("drift = {drift}, embedding = Midpoint");
        let item = "struct System { a: f64, kind: usize }";
        let text = expand(attribute.parse().unwrap(), item.parse().unwrap()).to_string();
        let facts = text.split("Facts").nth(1).unwrap_or(&text);
        facts.split("```").next().unwrap_or(facts).to_owned()
    }

    #[track_caller]
    fn states(drift: &str, expected: &[&str], refuted: &[&str]) {
        let found = facts(drift);
        assert!(expected.iter().all(|text| found.contains(text)), "{drift}: {found}");
        assert!(!refuted.iter().any(|text| found.contains(text)), "{drift}: {found}");
    }

    const KEPT: &str = "H0 is a first integral";

    #[test]
    fn energies_that_jump_are_no_first_integrals() {
        states(
            "|q, p| 0.5 * p * p + if q > 1.0 { q * q } else { 0.0 }",
            &[
                "H0 is not a first integral: it jumps",
                "where q = 1, H0 jumps: energy is kept on each side only",
            ],
            &[KEPT],
        );
        states("|q, p| 0.5 * p * p + a * q.signum()", &["where q = 0, H0 jumps"], &[KEPT]);
        states("|q, p, t| 0.5 * p * p + if t < a { q } else { 0.0 }", &["where t = a, H0 jumps"], &[KEPT]);
        // The jump of the branch is multiplied by a factor that vanishes there.
        states("|q, p| 0.5 * p * p + (q - 1.0) * if q > 1.0 { 2.0 } else { 1.0 }", &[KEPT], &["H0 jumps"]);
    }

    #[test]
    fn kinks_and_smooth_joints_are_told_apart() {
        let kink = "where q = a, H0 is continuous, its slope jumps";
        states("|q, p| 0.5 * p * p + if q > a { q - a } else { 0.0 }", &[KEPT, kink], &[]);
        let smooth = "H0 is continuous, its slope, too";
        states("|q, p| 0.5 * p * p + if q > a { (q - a).powi(2) } else { 0.0 }", &[KEPT, smooth], &["jumps"]);
        states("|q, p| 0.5 * p * p + if q > a { q * q } else { q * q }", &[KEPT], &["where"]);
    }

    #[test]
    fn functions_with_edges_are_branches() {
        let kink = "where q = a, H0 is continuous, its slope jumps";
        let polynomial = ["kept by the step to rounding", "modified energy"];
        states(
            "|q, p| 0.5 * p * p + (q - a).abs()",
            &[KEPT, "H0 is continuous, its slope jumps"],
            &polynomial,
        );
        states("|q, p| 0.5 * p * p + q.max(a)", &[KEPT, kink], &polynomial);
        states("|q, p| 0.5 * p * p + (q * q + p * p).min(a)", &[KEPT, "its slope jumps"], &polynomial);
        // Both sides are affine with the same slope, and so is neither the surface nor the step.
        let nested = "|q, p| 0.5 * p * p + if (if q > 0.0 { q } else { q + 1.0 }) > 0.5 { q } else { 0.5 }";
        states(nested, &["was not decided to be continuous"], &polynomial);
    }

    fn errors(attribute: &str) -> String {
        expand(attribute.parse().unwrap(), "struct System { a: f64 }".parse().unwrap()).to_string()
    }

    #[test]
    fn first_integrals_do_not_jump() {
        let found = errors(
            "drift = |q, p| 0.5 * p * p + q * q, invariant = |q, _| (q - 1.0).signum(), embedding = Midpoint",
        );
        assert!(found.contains("motions across q - 1 = 0: it jumps by 2"), "{found}");
        let found = errors("drift = |q, p| 0.5 * p * p, invariant = |_, p| p.abs(), embedding = Midpoint");
        assert!(!found.contains("compile_error"), "{found}");
    }

    #[test]
    fn what_a_sum_decides_is_not_linear_in_it() {
        for body in
            ["q.iter().sum::<f64>().signum()", "if q.iter().sum::<f64>() > 1.0 { q[0] } else { p[0] }"]
        {
            let found = errors(&format!("drift = |q: &[f64], p: &[f64]| {body}, embedding = DeltaPlus"));
            assert!(found.contains("compile_error"), "{body}: {found}");
        }
    }

    #[test]
    fn curved_boundaries_are_not_decided() {
        let drift = "|q, p| 0.5 * p * p + if q * q + p * p < 1.0 { q } else { 0.0 }";
        states(
            drift,
            &["was not decided to be continuous", "could not be shown"],
            &["H0 is a first integral:"],
        );
    }

    #[test]
    fn selections_by_parameters_are_no_boundaries() {
        states("|q, p| 0.5 * p * p + if a > 0.0 { q } else { q * q }", &[KEPT], &["where"]);
        states("|q, p| 0.5 * p * p + match kind { 0 => q, _ => q * q }", &[KEPT], &["where"]);
    }

    #[test]
    fn what_the_step_keeps_is_said() {
        states("|q, p| 0.5 * (p * p + a * q * q)", &["kept by the step to rounding"], &[]);
        states("|q, p| 0.5 * p * p - q.cos()", &["kept by the step nearly, within O(h²)"], &[]);
    }
}
