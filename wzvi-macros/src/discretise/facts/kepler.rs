//! Whether a part of the drift is a sum of Kepler problems, one for each body `b`:
//!
//! ```text
//! H = Σ_b (w_b |p_b|²/2 - k_b/|q_b|)
//! ```
//!
//! with `w`, `k` that read neither the state nor the time, and bodies of equally many coordinates that follow
//! each other. This is shown of `T(p)` and of the potential `V` of a body with the coordinates `x`, `y`, ...:
//!
//! | identity | conclusion |
//! |---|---|
//! | `∂²V/∂x∂z = 0` for each coordinate `z` of other bodies | the potential is a sum over bodies |
//! | `y ∂V/∂x = x ∂V/∂y` | `V` is a function of the distance `r` |
//! | `Σ_y y ∂²V/∂x∂y = -2 ∂V/∂x` | its slope is homogeneous of degree -2: `V = -k/r` up to a constant |
//! | `∂T/∂p_x = w p_x`, with one `w` for all components of a body | `T = Σ_b w_b \|p_b\|²/2` |
//!
//! Tests: `tests/steps/composition/kepler.rs`, `tests/compiler/ui/messages/parts.rs`.

use crate::model::{Element, Index, System};
use crate::symbolic::{Expr, Graph, Rational, Symbol, ZeroTest};

/// Why a part is no sum of Kepler problems.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum NotKepler {
    /// The part is a sum of Kepler problems but for this.
    Nearly(&'static str),
    /// The part has another form.
    Other,
}

/// A variable of an element, and its place in the state.
type PlacedVariable<'e> = (Symbol, &'e Index);

/// The number of coordinates of a body, if a part of the drift is a sum of Kepler problems.
pub(super) fn coordinates_of_body(system: &mut System, part: usize) -> Result<usize, NotKepler> {
    let System { graph, summands, .. } = system;
    let elements = &summands[part].elements;
    for element in elements {
        let reads = element.reads();
        if element.is_collective()
            || (reads.q && reads.p)
            || graph.has_pieces(element.value, &element.state())
            || !element.momenta().all(|(momentum, _)| has_mass(graph, element, momentum))
        {
            return Err(NotKepler::Other);
        }
    }
    let mut components = None;
    for element in elements {
        for body in coupled(graph, element) {
            check_potential(graph, element, &body)?;
            if *components.get_or_insert(body.len()) != body.len() {
                return Err(NotKepler::Nearly(
                    "it is nearly a Kepler problem, but its bodies have different numbers of coordinates",
                ));
            }
            if by_body(&body, body.len()).is_none_or(|bodies| bodies.len() > 1) {
                return Err(NotKepler::Nearly(
                    "it is nearly a Kepler problem, but the coordinates of a body do not follow each other, as in \
                     `q: [[f64; 3]; N]`",
                ));
            }
        }
    }
    let components = components.ok_or(NotKepler::Other)?;
    for element in elements {
        let momenta: Vec<PlacedVariable<'_>> = element.momenta().collect();
        let has_one_mass = |graph: &mut Graph, body: &Vec<Symbol>| {
            let inverses: Vec<Expr> =
                body.iter().map(|&momentum| inverse_mass(graph, element, momentum)).collect();
            inverses.windows(2).all(|pair| are_equal(graph, pair[0], pair[1]))
        };
        let is_isotropic = by_body(&momenta, components)
            .is_some_and(|bodies| bodies.iter().all(|body| has_one_mass(graph, body)));
        if !is_isotropic {
            return Err(NotKepler::Nearly(
                "it is nearly a Kepler problem, but the components of a body have different masses",
            ));
        }
    }
    Ok(components)
}

/// `w`, the second derivative by a momentum.
fn inverse_mass(graph: &mut Graph, element: &Element, momentum: Symbol) -> Expr {
    let velocity = graph.derivative(element.value, momentum);
    graph.derivative(velocity, momentum)
}

/// Whether `∂T/∂p = w p` with a constant `w`.
fn has_mass(graph: &mut Graph, element: &Element, momentum: Symbol) -> bool {
    let inverse = inverse_mass(graph, element, momentum);
    let own = graph.symbol(momentum);
    let velocity = graph.derivative(element.value, momentum);
    let of_mass = graph.multiply(inverse, own);
    !graph.depends_on(inverse, &element.state()) && are_equal(graph, velocity, of_mass)
}

/// The coordinates of an element in groups that second derivatives couple.
fn coupled<'e>(graph: &mut Graph, element: &'e Element) -> Vec<Vec<PlacedVariable<'e>>> {
    let mut groups: Vec<Vec<PlacedVariable<'e>>> = Vec::new();
    for place in element.coordinates() {
        let slope = graph.derivative(element.value, place.0);
        let is_coupled = |graph: &mut Graph, other: Symbol| {
            graph.depends_on(slope, &[other]) && {
                let second = graph.derivative(slope, other);
                graph.test_zero(second) != ZeroTest::Zero
            }
        };
        let mut joined = vec![place];
        groups.retain_mut(|group| {
            let joins = group.iter().any(|&(other, _)| is_coupled(graph, other));
            if joins {
                joined.append(group);
            }
            !joins
        });
        groups.push(joined);
    }
    groups
}

/// Whether the potential of a body is `-k/|q|`.
fn check_potential(
    graph: &mut Graph,
    element: &Element,
    body: &[PlacedVariable<'_>],
) -> Result<(), NotKepler> {
    let slopes: Vec<(Symbol, Expr)> =
        body.iter().map(|&(x, _)| (x, graph.derivative(element.value, x))).collect();
    let is_central = slopes.len() > 1
        && slopes.windows(2).all(|pair| {
            let [(x, along_x), (y, along_y)] = [pair[0], pair[1]];
            let [x, y] = [x, y].map(|coordinate| graph.symbol(coordinate));
            let (one, other) = (graph.multiply(y, along_x), graph.multiply(x, along_y));
            are_equal(graph, one, other)
        });
    let is_of_newton = slopes.iter().all(|&(_, slope)| {
        let mut sum = vec![(slope, Rational::integer(2))];
        for &(y, _) in &slopes {
            let (second, y) = (graph.derivative(slope, y), graph.symbol(y));
            sum.push((graph.multiply(y, second), Rational::ONE));
        }
        let sum = graph.linear_combination(&sum);
        graph.test_zero(sum) == ZeroTest::Zero
    });
    match (is_central, is_of_newton) {
        (true, true) => Ok(()),
        (true, false) => Err(NotKepler::Nearly(
            "it is nearly a Kepler problem, but its potential is another function of the distance than -k/|q| with a \
             constant k",
        )),
        (false, true) if slopes.len() > 1 => Err(NotKepler::Nearly(
            "it is nearly a Kepler problem, but its potential is not a sum over bodies of -k/|q| with constants k and \
             |q| = √(x² + y² + ...); write the potential of several bodies in the other part",
        )),
        (false, _) => Err(NotKepler::Other),
    }
}

/// The variables of each body in the order of its components; `None` if a body is not complete.
fn by_body(places: &[PlacedVariable<'_>], components: usize) -> Option<Vec<Vec<Symbol>>> {
    let length = i128::try_from(components).ok()?;
    let mut bodies: Vec<(Index, Vec<(i128, Symbol)>)> = Vec::new();
    for (symbol, place) in places {
        let (body, component) = place.divided(length)?;
        match bodies.iter_mut().find(|(known, _)| *known == body) {
            Some((_, of_body)) => of_body.push((component, *symbol)),
            None => bodies.push((body, vec![(component, *symbol)])),
        }
    }
    let complete = bodies.into_iter().map(|(_, mut of_body)| {
        of_body.sort_unstable();
        let is_complete = of_body.iter().map(|(component, _)| *component).eq(0..length);
        is_complete.then(|| of_body.into_iter().map(|(_, symbol)| symbol).collect())
    });
    complete.collect()
}

fn are_equal(graph: &mut Graph, a: Expr, b: Expr) -> bool {
    let difference = graph.linear_combination(&[(a, Rational::ONE), (b, Rational::MINUS_ONE)]);
    graph.test_zero(difference) == ZeroTest::Zero
}
