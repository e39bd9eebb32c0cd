//! Continuity of piecewise Hamiltonians and of their slopes across branch boundaries.
//!
//! On `d = 0`, the boundary of a comparison `a < b` with `d = a - b`, the values of the Hamiltonian with this
//! comparison true and false are compared. If `d` is affine in a variable, the boundary gives that variable
//! as a function of the others, and continuity means that an expression is zero. Other boundaries are crossed
//! on random lines, which can find a jump and cannot exclude one ([`Sides`]).
//!
//! Functions whose value jumps or is infinite on a surface inside their domain have boundaries, too:
//! `signum`, the cut of `atan2`, the poles of `tan` and of powers with negative exponents. A pole matters
//! where another function hides it, as in `atan(1/q)`.

use std::collections::{HashMap, HashSet};

use crate::symbolic::sign::Sign;
use crate::symbolic::{
    Edge, Expr, Function, Graph, Node, Rational, Relation, Sides, Symbol, Witness, ZeroTest,
};

/// The surface where a branch ends.
#[derive(Clone, Debug)]
pub(crate) struct Boundary {
    /// As an equation: `q = 1`.
    pub(crate) place: String,
    /// A function that is constant on it.
    pub(crate) surface: Expr,
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
    /// The function jumps unless the fields make this expression zero.
    JumpUnless(String),
    Undecided,
}

/// A part of a Hamiltonian that decides between pieces.
struct Decision {
    /// The condition changes where these two are equal.
    compared: [Expr; 2],
    /// The expression that replaces the function on either side of the edge.
    sides: [Expr; 2],
    /// The condition changes only where this is negative.
    negative: Option<Expr>,
    /// Whether the sides may differ on the boundary.
    may_jump: bool,
}

/// The boundaries inside of `value` that the variables `state` can cross.
pub(crate) fn boundaries(graph: &mut Graph, value: Expr, state: &[Symbol]) -> Vec<Boundary> {
    let mut found: Vec<Boundary> = Vec::new();
    for part in graph.reachable(&[value]) {
        found.extend(boundary(graph, value, part, state));
    }
    for pole in poles(graph, value, state) {
        // A branch may end at a pole, which its values there do not show.
        match found.iter_mut().find(|known| known.place == pole.place) {
            None => found.push(pole),
            Some(known) if !matches!(known.crossing, Crossing::Jump(_)) => *known = pole,
            Some(_) => {}
        }
    }
    found
}

/// The two sides of `part`, if it decides between pieces.
fn decision(graph: &mut Graph, part: Expr) -> Option<Decision> {
    let (compared, sides) = match *graph.node(part) {
        Node::Compare(_, left, right) => {
            let (zero, one) = (graph.integer(0), graph.integer(1));
            let sides = [(zero, one), (one, zero)].map(|(a, b)| graph.compare(Relation::Less, a, b));
            ([left, right], sides)
        }
        Node::Apply(Function::Signum, ref arguments) => {
            let argument = arguments[0];
            ([argument, graph.integer(0)], [graph.integer(1), graph.integer(-1)])
        }
        Node::Apply(Function::Abs, ref arguments) => {
            let argument = arguments[0];
            ([argument, graph.integer(0)], [argument, graph.negate(argument)])
        }
        Node::Apply(Function::Min | Function::Max, ref arguments) => {
            let sides = [arguments[0], arguments[1]];
            (sides, sides)
        }
        Node::Apply(Function::Atan2, ref arguments) => {
            let (y, x) = (arguments[0], arguments[1]);
            if graph.sign(x) >= Sign::Nonnegative || exceeds_its_oscillations(graph, x) {
                return None;
            }
            let (zero, minus_one) = (graph.integer(0), graph.integer(-1));
            // With the rounding error of π, which a number would not have.
            let pi = graph.apply(Function::Acos, &[minus_one]);
            let sides = [pi, graph.negate(pi)];
            return Some(Decision { compared: [y, zero], sides, negative: Some(x), may_jump: true });
        }
        _ => return None,
    };
    // `abs`, `min` and `max` have equal sides on their boundary.
    let may_jump = matches!(graph.node(part), Node::Compare(..) | Node::Apply(Function::Signum, _));
    Some(Decision { compared, sides, negative: None, may_jump })
}

/// Whether an expression is a number plus functions between -1 and 1 whose sizes add up to less.
fn exceeds_its_oscillations(graph: &Graph, expr: Expr) -> bool {
    let Node::Sum { terms, constant } = graph.node(expr) else { return false };
    let rest = terms.iter().try_fold(*constant, |rest, &(term, factor)| match graph.node(term) {
        Node::Apply(function, _) if function.is_within_one() => {
            rest.add(if factor.is_negative() { factor } else { factor.negate() })
        }
        _ if !factor.is_negative() && graph.sign(term) >= Sign::Nonnegative => Some(rest),
        _ => None,
    });
    rest.is_some_and(|rest| !rest.is_negative() && !rest.is_zero())
}

/// The boundary of a part of `value`; `None` if it decides nothing, or nothing of the state, or has no
/// effect.
fn boundary(graph: &mut Graph, value: Expr, part: Expr, state: &[Symbol]) -> Option<Boundary> {
    let Decision { compared, sides, negative, may_jump } = decision(graph, part)?;
    let [left, right] = compared;
    if !graph.depends_on(left, state) && !graph.depends_on(right, state) {
        return None;
    }
    let turned =
        if negative.is_some() { of_whole_turns(graph, value, part, sides[0]) } else { HashMap::new() };
    let sides = sides.map(|side| {
        let parts = graph.reachable(&[value]);
        let image = |known: Expr| if known == part { Some(side) } else { turned.get(&known).copied() };
        graph.rewritten(&[value], parts, |_, known| image(known))[0]
    });
    let jump = graph.subtract(sides[0], sides[1]);
    if matches!(graph.test_zero(jump), ZeroTest::Zero) {
        return None;
    }
    let surface = graph.subtract(left, right);
    let crossing = match crossing(graph, surface, jump, negative, state) {
        Crossing::Undecided if !may_jump => Crossing::Kink,
        // The surface is curved, or the jump vanishes by no known identity.
        Crossing::Undecided => match graph.sides(value, Edge::Zero(surface), state) {
            Some(Sides::Jump(witness)) => jump_of(graph, jump, witness, state),
            _ => Crossing::Undecided,
        },
        crossing => crossing,
    };
    let (first, second) = if graph.depends_on(left, state) { (left, right) } else { (right, left) };
    let mut place = format!("{} = {}", graph.display(first), graph.display(second));
    if let Some(x) = negative {
        place.push_str(&format!(", {} < 0", graph.display(x)));
    }
    // The graph has the arguments of `atan2` already; their difference may be new.
    let surface = if negative.is_some() { left } else { surface };
    Some(Boundary { place, surface, crossing })
}

/// Sines, cosines and tangents of an integer multiple of `angle` plus something else, with `turn` for the
/// angle: a whole turn does not change them.
fn of_whole_turns(graph: &mut Graph, value: Expr, angle: Expr, turn: Expr) -> HashMap<Expr, Expr> {
    let mut images = HashMap::new();
    for part in graph.reachable(&[value]) {
        let (function, argument) = match graph.node(part) {
            Node::Apply(function @ (Function::Sin | Function::Cos | Function::Tan), arguments) => {
                (*function, arguments[0])
            }
            _ => continue,
        };
        let (terms, constant) = match graph.node(argument) {
            Node::Sum { terms, constant } => (terms.to_vec(), *constant),
            _ => (vec![(argument, Rational::ONE)], Rational::ZERO),
        };
        let is_turned = |&(term, factor): &(Expr, Rational)| {
            if term == angle { factor.is_integer() } else { !graph.reachable(&[term]).contains(&angle) }
        };
        if terms.iter().all(is_turned) && terms.iter().any(|(term, _)| *term == angle) {
            let one = graph.integer(1);
            let turned =
                terms.iter().map(|&(term, factor)| (if term == angle { turn } else { term }, factor));
            let turned: Vec<_> = turned.chain([(one, constant)]).collect();
            let argument = graph.linear_combination(&turned);
            images.insert(part, graph.apply(function, &[argument]));
        }
    }
    images
}

/// Whether the jump is continuous on `surface = 0`, where `negative` is negative.
fn crossing(
    graph: &mut Graph,
    surface: Expr,
    jump: Expr,
    negative: Option<Expr>,
    state: &[Symbol],
) -> Crossing {
    let Some(solution) = state.iter().find_map(|&symbol| solved(graph, surface, symbol, state)) else {
        return Crossing::Undecided;
    };
    let on_surface = graph.substitute(&[jump], &solution)[0];
    let zero = graph.integer(0);
    let within = negative.map_or(on_surface, |x| {
        let x = graph.substitute(&[x], &solution)[0];
        let is_there = graph.compare(Relation::Less, x, zero);
        graph.select(is_there, on_surface, zero)
    });
    match graph.test_zero(within) {
        ZeroTest::Nonzero(witness) => return jump_of(graph, on_surface, witness, state),
        ZeroTest::Unknown => return Crossing::Undecided,
        ZeroTest::Zero => {}
    }
    let is_smooth = state.iter().all(|&symbol| {
        let slope = graph.derivative(jump, symbol);
        let slope = graph.substitute(&[slope], &solution)[0];
        matches!(graph.test_zero(slope), ZeroTest::Zero)
    });
    if is_smooth { Crossing::Smooth } else { Crossing::Kink }
}

/// A jump that was found at some values of the fields: a sum of terms with fields may vanish at others, as
/// the shift of a potential at its cut-off does.
fn jump_of(graph: &Graph, jump: Expr, witness: Witness, state: &[Symbol]) -> Crossing {
    let reads_fields = graph.symbols_in(jump).iter().any(|symbol| !state.contains(symbol));
    match reads_fields && !is_monomial(graph, jump) {
        true => Crossing::JumpUnless(graph.display(jump)),
        false => Crossing::Jump(witness),
    }
}

/// Whether an expression vanishes only where one of its symbols does.
fn is_monomial(graph: &Graph, expr: Expr) -> bool {
    match graph.node(expr) {
        _ if graph.sign(expr) == Sign::Positive => true,
        Node::Number(_) | Node::Float(_) | Node::Symbol(_) => true,
        Node::Sum { terms, constant } => {
            constant.is_zero() && terms.len() == 1 && is_monomial(graph, terms[0].0)
        }
        Node::Product(factors) => factors.iter().all(|&(base, _)| is_monomial(graph, base)),
        Node::Apply(Function::Acos, _) => graph.symbols_in(expr).is_empty(),
        _ => false,
    }
}

/// The surfaces on which a part of `value` has a pole and `value` jumps, or may jump.
fn poles(graph: &Graph, value: Expr, state: &[Symbol]) -> Vec<Boundary> {
    let (mut found, mut seen) = (Vec::new(), HashSet::new());
    for part in graph.reachable(&[value]) {
        let edges: Vec<Edge> = match graph.node(part) {
            Node::Apply(Function::Tan, arguments) => vec![Edge::PoleOfTangent(arguments[0])],
            Node::Product(factors) => {
                let bases = factors.iter().filter(|(_, exponent)| exponent.is_negative());
                let bases = bases.map(|&(base, _)| base).filter(|&base| graph.sign(base) != Sign::Positive);
                bases.flat_map(|base| graph.surfaces_of_zero(base)).map(Edge::Zero).collect()
            }
            Node::Apply(Function::Powf, arguments) => {
                graph.surfaces_of_zero(arguments[0]).into_iter().map(Edge::Zero).collect()
            }
            _ => continue,
        };
        for edge in edges {
            let (Edge::Zero(surface) | Edge::PoleOfTangent(surface)) = edge;
            if !graph.depends_on(surface, state) || !seen.insert(edge) {
                continue;
            }
            let crossing = match graph.sides(value, edge, state) {
                Some(Sides::Jump(witness)) => Crossing::Jump(witness),
                Some(Sides::Alike) if !graph.is_meromorphic_in(value, part) => Crossing::Undecided,
                _ => continue,
            };
            let place = match edge {
                Edge::Zero(surface) => format!("{} = 0", graph.display(surface)),
                Edge::PoleOfTangent(angle) => format!("cos({}) = 0", graph.display(angle)),
            };
            found.push(Boundary { place, surface, crossing });
        }
    }
    found
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
                "runs do not compare H0 with its value at the start",
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
        // The second derivative jumps, and with it every modified energy.
        let smooth = "H0 is continuous, its slope, too: steps have at most order 2 across";
        let between = "between the boundaries of its branches";
        states(
            "|q, p| 0.5 * p * p + if q > a { (q - a).powi(2) } else { 0.0 }",
            &[KEPT, smooth, between],
            &["jumps"],
        );
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
        // Both sides are affine with the same slope, and so is neither the surface nor the step: at -1/2 and
        // 0, H0 jumps.
        let nested = "|q, p| 0.5 * p * p + if (if q > 0.0 { q } else { q + 1.0 }) > 0.5 { q } else { 0.5 }";
        states(nested, &["else 1 + q = 1/2, H0 jumps", "where q = 0, H0 jumps"], &polynomial);
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
    fn what_a_sum_decides_jumps() {
        for body in
            ["q.iter().sum::<f64>().signum()", "if q.iter().sum::<f64>() > 1.0 { q[0] } else { p[0] }"]
        {
            states(&format!("|q: &[f64], p: &[f64]| {body}"), &["it jumps"], &[KEPT]);
        }
    }

    const UNDECIDED: &str = "was not decided to be continuous";

    #[test]
    fn jumps_at_curved_boundaries_are_found_and_continuity_is_not() {
        let drift = "|q, p| 0.5 * p * p + if q * q + p * p < 1.0 { q } else { 0.0 }";
        states(drift, &["it jumps", "H0 jumps: energy is kept on each side only"], &[KEPT]);
        let drift = "|q, p| 0.5 * p * p + if q * q + p * p < 1.0 { 1.0 - q * q - p * p } else { 0.0 }";
        states(
            drift,
            &[UNDECIDED, "could not be decided", "runs compare H0 with its value at the start"],
            &[KEPT, "H0 jumps"],
        );
        let drift = "|q, p| 0.5 * p * p + if q * q > 1.0 { (q * q - 1.0).sqrt() } else { 0.0 }";
        states(drift, &[UNDECIDED], &[KEPT, "H0 jumps"]);
    }

    #[test]
    fn jumps_that_fields_can_cancel_are_not_known() {
        let cut_off =
            "|[x, y], [px, py]| { let r2 = x * x + y * y; 0.5 * (px * px + py * py) + if r2 < 6.25 {
            4.0 * (r2.powi(-6) - r2.powi(-3)) + a } else { 0.0 } }";
        states(cut_off, &["H0 jumps unless ", "could not be decided"], &[KEPT]);
        let cut_off = "|q, p| 0.5 * p * p + if q < 2.0 { q.powi(-6) - q.powi(-3) + a } else { 0.0 }";
        states(cut_off, &["where q = 2, H0 jumps unless a - 7/64 = 0"], &[KEPT]);
        // A step whose height is a field is one, unless it is none.
        states("|q, p| 0.5 * p * p + if q < 2.0 { a } else { 0.0 }", &["where q = 2, H0 jumps: "], &[KEPT]);
        states("|q, p| 0.5 * p * p + if q * p < 2.0 { -2.0 * a } else { 0.0 }", &["H0 jumps: "], &[KEPT]);
    }

    #[test]
    fn cuts_of_angles_are_boundaries() {
        let plane =
            |term: &str| format!("|[x, y], [px, py]| 0.5 * (px * px + py * py + x * x + y * y) + {term}");
        let between = "runs do not compare H0 with its value at the start";
        for jumps in
            ["a * y.atan2(x)", "(0.5 * y.atan2(x)).sin()", "x * y.atan2(x)", "y.atan2(x) * y.atan2(x).cos()"]
        {
            states(&plane(jumps), &["where y = 0, x < 0, H0 jumps", between], &[KEPT]);
        }
        for continuous in [
            "a * (3.0 * y.atan2(x)).cos()",
            "a * (2.0 * y.atan2(x) + 1.0).sin()",
            "y.atan2(x).powi(2)",
            "y * y.atan2(x)",
            "y.atan2(2.0 + x.cos())",
            "y.atan2((x * x + 1.0).sqrt())",
        ] {
            states(&plane(continuous), &[KEPT], &["H0 jumps", UNDECIDED]);
        }
        // No motion crosses the cut: the angle of the eccentricity vector is constant.
        let free = "drift = |[x, y], [px, py]| 0.5 * (px * px + py * py), invariant = |[x, y], [px, py]| py.atan2(px), embedding = Midpoint";
        assert!(!errors(free).contains("compile_error"), "{}", errors(free));
        let circle = "drift = |q, p| 0.5 * (q * q + p * p), invariant = |q, p| p.atan2(q) - p.atan2(q), embedding = Midpoint";
        assert!(!errors(circle).contains("compile_error"));
        let turned = "drift = |[x, y], [px, py]| 0.5 * (px * px + py * py + x * x + y * y),
            invariant = |[x, y], [px, py]| px.atan2(x) - py.atan2(y), embedding = Midpoint";
        assert!(
            errors(turned).contains("is not a first integral of motions across px = 0, x &lt; 0: it jumps")
                || errors(turned).contains("motions across"),
            "{}",
            errors(turned)
        );
    }

    #[test]
    fn hidden_poles_are_boundaries() {
        let line = |term: &str| format!("|q, p| 0.5 * p * p + {term}");
        for (term, place) in [
            ("q - q.tan().atan()", "where cos(q) = 0, H0 jumps"),
            ("(1.0 / q).atan()", "where q = 0, H0 jumps"),
            ("a * (1.0 / (q - 1.0)).tanh()", "H0 jumps"),
            ("q / (q * q).sqrt()", "where q = 0, H0 jumps"),
            ("q / q.abs()", "where q = 0, H0 jumps"),
            ("(p / q).atan()", "where q = 0, H0 jumps"),
            ("1.0 / (1.0 + (1.0 / q).exp())", "H0 jumps"),
            ("q.sin() / (q * q + q.powi(4)).sqrt()", "H0 jumps"),
        ] {
            states(&line(term), &[place], &[KEPT]);
        }
        // Infinite, or continuous, or never reached.
        states(&line("1.0 / q.abs()"), &[KEPT], &["H0 jumps", UNDECIDED]);
        for term in [
            "1.0 / q",
            "q.tan()",
            "1.0 / q.sin().powi(2)",
            "q.sin() / q",
            "1.0 / (2.0 + q.cos())",
            "q / (1.0 + q * q)",
        ] {
            states(&line(term), &[KEPT], &["where q = 0, H0", "cos(q) = 0", UNDECIDED]);
        }
        states(
            "|[x, y], [px, py]| 0.5 * (px * px + py * py) + x / (x * x + y * y).sqrt()",
            &[KEPT],
            &["where"],
        );
        states("|[x, y], [px, py]| 0.5 * (px * px + py * py) + x / x.hypot(y).powi(3)", &[KEPT], &["where"]);
        states(&line("(-1.0 / (q * q)).exp()"), &[UNDECIDED], &["H0 jumps"]);
    }

    #[test]
    fn noises_that_jump_are_not_known_to_commute() {
        let found = errors(
            "drift = |q, p| 0.5 * p * p, noise = [|q, _| if q > 0.0 { a } else { 0.0 }, |q, _| q], embedding = Midpoint",
        );
        assert!(found.contains("the noises do not commute"), "{found}");
        let found =
            errors("drift = |q, p| 0.5 * p * p, noise = [|q, _| q * q, |q, _| q], embedding = Midpoint");
        assert!(found.contains("the noises commute up to a constant"), "{found}");
    }

    #[test]
    fn selections_by_parameters_are_no_boundaries() {
        states("|q, p| 0.5 * p * p + if a > 0.0 { q } else { q * q }", &[KEPT], &["where"]);
        states("|q, p| 0.5 * p * p + match kind { 0 => q, _ => q * q }", &[KEPT], &["where"]);
    }

    /// A function of what the step keeps to rounding is kept to rounding.
    #[test]
    fn functions_of_kept_integrals_are_kept() {
        let integral = |function: &str| {
            let found = errors(&format!(
                "drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) - a / (x * x + y * y).sqrt(),
                 invariant = |[x, y], [px, py]| {function}, embedding = Midpoint"
            ));
            let line = found
                .split("first integral (")
                .nth(1)
                .or(found.split("  first integral ").nth(1))
                .unwrap_or(&found);
            line.split("\\n").next().unwrap_or_default().to_owned()
        };
        let exact = ": kept by the step to rounding";
        for kept in [
            "x * py - y * px",
            "(x * py - y * px).powi(2)",
            "(x * py - y * px).abs().sqrt() * a",
            "{ let l = x * py - y * px; (l * l + 2.0 * l + 3.0).sin() }",
        ] {
            assert!(integral(kept).contains(exact), "{kept}: {}", integral(kept));
        }
        let near = "0.5 * (px * px + py * py) - a / (x * x + y * y).sqrt() + (x * py - y * px).powi(2)";
        assert!(integral(near).contains(": kept by the step up to its order"), "{}", integral(near));
        states(
            "|q, p| 0.25 * (p * p + q * q).powi(2)",
            &["H0 is a first integral: kept by the step to rounding"],
            &[],
        );
        states("|q, p| (a * p * q).sin()", &["H0 is a first integral: kept by the step to rounding"], &[]);
        states("|q, p| 0.25 * (p * p + q * q).powi(2) + q", &["nearly, within O(h²)"], &[]);
    }

    /// Loops over different places of a literal size meet nowhere.
    #[test]
    fn sums_without_terms_are_not_printed() {
        let noise = "|q: [f64; 64], p: [f64; 64]| { let mut s = 0.0;
            for i in 0..24 { s += q[i] * q[i] * p[i]; }
            for i in 30..64 { s += q[i] * p[i]; }
            s }";
        let drift =
            "|q: [f64; 64], p: [f64; 64]| { let mut s = 0.0; for i in 0..64 { s += p[i] * p[i]; } s }";
        let found = errors(&format!("drift = {drift}, noise = {noise}, embedding = Uncorrected<DeltaPlus>"));
        let defect = found.split("D = ").nth(1).and_then(|text| text.split("\\n").next()).unwrap_or(&found);
        let sums: Vec<&str> =
            defect.split("Σ_(").skip(1).map(|sum| sum.split(')').next().unwrap_or_default()).collect();
        assert_eq!(sums, ["i=0..23", "i=30..63"], "{defect}");
    }

    #[test]
    fn what_the_step_keeps_is_said() {
        states("|q, p| 0.5 * (p * p + a * q * q)", &["kept by the step to rounding"], &[]);
        states("|q, p| 0.5 * p * p - q.cos()", &["kept by the step nearly, within O(h²)"], &[]);
    }

    /// A magnetic force has no power, but steps with a force are not symplectic: no modified energy holds H0.
    #[test]
    fn a_force_without_power_leaves_the_order_of_the_step() {
        let found = errors(
            "drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) + x.powi(4) + y * y,
             force = |[x, y], [px, py]| [py, -px], embedding = Midpoint",
        );
        assert!(found.contains("H0 is a first integral: kept by the step up to its order"), "{found}");
    }
}
