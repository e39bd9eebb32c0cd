//! The kinetic energy: whether it is `p · M⁻¹ p / 2` with constant masses.

use crate::model::{Element, Reads, System};
use crate::symbolic::{Graph, Rational, Symbol};

/// Properties of a quadratic kinetic energy.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Kinetic {
    /// Whether it couples no two momenta.
    pub(crate) is_diagonal: bool,
}

impl Kinetic {
    /// `None` unless the drift is a constant quadratic form of the momenta plus a function of coordinates and
    /// time.
    pub(crate) fn of(system: &mut System) -> Option<Self> {
        let System { graph, drift, t, .. } = system;
        let (mut is_diagonal, mut is_quadratic) = (true, true);
        for element in &drift.elements {
            let Reads { q, p } = element.reads();
            if p {
                is_quadratic &= !q && is_form(graph, element, *t);
                is_diagonal &= q || self::is_diagonal(graph, element);
            }
        }
        is_quadratic.then_some(Self { is_diagonal })
    }
}

/// Whether an element is a quadratic form with constant coefficients.
fn is_form(graph: &mut Graph, element: &Element, t: Symbol) -> bool {
    if element.is_collective() {
        return false;
    }
    let momenta: Vec<Symbol> = element.momenta().map(|(symbol, _)| symbol).collect();
    let moving = [momenta.as_slice(), &[t]].concat();
    momenta.iter().all(|&p| {
        let velocity = graph.derivative(element.value, p);
        let mut rest = vec![(velocity, Rational::ONE)];
        for &other in &momenta {
            let mass = graph.derivative(velocity, other);
            if graph.depends_on(mass, &moving) {
                return false;
            }
            let other = graph.symbol(other);
            rest.push((graph.multiply(mass, other), Rational::MINUS_ONE));
        }
        let rest = graph.linear_combination(&rest);
        graph.is_zero(rest)
    })
}

/// Whether an element couples no two momenta.
pub(crate) fn is_diagonal(graph: &mut Graph, element: &Element) -> bool {
    let momenta: Vec<Symbol> = element.momenta().map(|(symbol, _)| symbol).collect();
    !element.collectives().any(|(_, slot)| slot.reads.p)
        && momenta.iter().all(|&p| {
            let slope = graph.derivative(element.value, p);
            let others: Vec<Symbol> = momenta.iter().copied().filter(|&other| other != p).collect();
            !graph.depends_on(slope, &others)
        })
}
