//! Quadratic functions, which some schemes keep exactly.

use crate::discretise::Sum;
use crate::embedding::{Embedding, Points};
use crate::model::{Element, Index, Slot, System};
use crate::symbolic::{Expr, Graph, Rational, Symbol};

/// The form of a function, which decides whether schemes keep it exactly.
#[derive(Clone, Copy)]
pub(crate) struct PreservedForm {
    /// Quadratic in (q, p): a first integral is kept exactly by `Midpoint`.
    quadratic: bool,
    /// `pᵀA q` plus linear terms: kept exactly by every embedding with one `P`, and by compositions of them.
    bilinear: bool,
}

impl PreservedForm {
    /// The form of a function that no step is known to keep exactly.
    pub(super) const NONE: Self = Self { quadratic: false, bilinear: false };
    /// The form of a constant.
    pub(super) const CONSTANT: Self = Self { quadratic: true, bilinear: true };

    /// The form of a function of two: a step that keeps both keeps it.
    pub(super) fn and(self, other: Self) -> Self {
        Self { quadratic: self.quadratic && other.quadratic, bilinear: self.bilinear && other.bilinear }
    }

    /// Whether some step keeps a first integral of this form exactly.
    pub(super) fn is_known(self) -> bool {
        self.quadratic || self.bilinear
    }

    pub(super) fn of(graph: &mut Graph, value: &Sum) -> Self {
        let [quadratic, bilinear] = [Degree::Quadratic, Degree::Bilinear]
            .map(|degree| value.iter().all(|weighted| is_of_degree(graph, &weighted.element, degree)));
        Self { quadratic, bilinear }
    }

    /// Whether the step keeps a first integral of this form to rounding.
    pub(crate) fn is_kept(self, embedding: &Embedding, has_noise: bool) -> bool {
        let ([drift, noise], midpoint) = (embedding.points(), Points::one(Rational::HALF));
        let has_midpoint = drift == midpoint && !embedding.takes_flows() && !embedding.keeps_constraints();
        self.quadratic && has_midpoint && (noise == midpoint || !has_noise)
            || self.bilinear && (drift == noise || !has_noise)
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Degree {
    Quadratic,
    /// Quadratic, without `q_i q_j` and `p_i p_j`.
    Bilinear,
}

/// Whether the second derivatives by the state are constant on phase space.
pub(crate) fn is_quadratic(graph: &mut Graph, element: &Element) -> bool {
    is_of_degree(graph, element, Degree::Quadratic)
}

fn is_of_degree(graph: &mut Graph, element: &Element, degree: Degree) -> bool {
    let state = element.state();
    let coordinates = element.coordinates().count();
    let is_momentum = |at: usize| at >= coordinates;
    !element.is_collective()
        && !graph.has_pieces(element.value, &state)
        && (0..state.len()).all(|a| {
            let slope = graph.derivative(element.value, state[a]);
            (a..state.len()).all(|b| {
                let curvature = graph.derivative(slope, state[b]);
                let is_allowed = degree == Degree::Quadratic || is_momentum(a) != is_momentum(b);
                !graph.depends_on(curvature, &state) && (is_allowed || graph.is_zero(curvature))
            })
        })
}

/// Whether the second derivatives of the step Hamiltonian read neither the state nor the time nor increments.
pub(super) fn has_constant_curvature(system: &mut System) -> bool {
    let System { graph, drift, noise, force, t, .. } = system;
    let mut curvature = |element: &Element, allowed: &dyn Fn(&Graph, Expr, &[Symbol]) -> bool| {
        let state = element.state();
        let moving = [state.as_slice(), &[*t]].concat();
        // The components of a covector are slopes already.
        let displacements: Vec<Symbol> = element.displacements().map(|(symbol, _)| symbol).collect();
        let slopes = if displacements.is_empty() { &state } else { &displacements };
        !element.is_collective()
            && !graph.has_pieces(element.value, &state)
            && slopes.iter().all(|&x| {
                let slope = graph.derivative(element.value, x);
                state.iter().all(|&y| {
                    let curvature = graph.derivative(slope, y);
                    allowed(graph, curvature, &moving)
                })
            })
    };
    let mut of_noise = noise.iter().flat_map(|noise| &noise.term.elements);
    let mut of_drift = drift.elements.iter().chain(force.iter().flat_map(|force| &force.elements));
    of_drift.all(|e| curvature(e, &|graph, value, moving| !graph.depends_on(value, moving)))
        && of_noise.all(|e| curvature(e, &|graph, value, _| graph.is_zero(value)))
}

/// The most degrees of freedom that depend on each other through elements of one point; `None` if an element
/// reads two points. Then the second derivatives of the step Hamiltonian have a block for each point.
pub(super) fn coupled_degrees(system: &System) -> Option<usize> {
    let components = usize::try_from(system.components).ok()?;
    // The set of each component, by one of its members.
    let mut sets: Vec<usize> = (0..components).collect();
    for element in system.acting() {
        if element.is_collective() {
            return None;
        }
        let places = element.locals.iter().filter_map(|local| match &local.slot {
            Slot::State(_, index) => Some(index.divided(system.components)),
            Slot::Entry(..) | Slot::Number(_) | Slot::Collective(_) => None,
        });
        let places: Vec<(Index, i128)> = places.collect::<Option<_>>()?;
        let Some(((point, component), others)) = places.split_first() else { continue };
        for (other, coupled) in others {
            if other != point {
                return None;
            }
            let [from, to] =
                [*coupled, *component].map(|c| usize::try_from(c).ok().and_then(|c| sets.get(c).copied()));
            let (from, to) = (from?, to?);
            sets.iter_mut().filter(|set| **set == from).for_each(|set| *set = to);
        }
    }
    (0..components).map(|set| sets.iter().filter(|other| **other == set).count()).max()
}

/// Whether the forces of an element do not depend on coordinates.
pub(crate) fn has_constant_forces(graph: &mut Graph, element: &Element) -> bool {
    let coordinates: Vec<Symbol> = element.coordinates().map(|(symbol, _)| symbol).collect();
    let acts = element.is_covector() || !coordinates.is_empty();
    if acts && element.collectives().any(|(_, slot)| slot.reads.q) {
        return false;
    }
    if element.is_covector() {
        return coordinates.is_empty();
    }
    coordinates.iter().all(|&x| {
        let slope = graph.derivative(element.value, x);
        !graph.depends_on(slope, &coordinates)
    })
}
