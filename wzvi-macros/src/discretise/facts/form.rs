//! Quadratic functions, which some schemes keep exactly.

use crate::discretise::Sum;
use crate::embedding::{Embedding, Points};
use crate::model::Element;
use crate::symbolic::{Graph, Rational};

/// The form of a function, which decides whether schemes keep it exactly.
#[derive(Clone, Copy)]
pub(crate) struct Form {
    /// Quadratic in (q, p): a first integral is kept exactly by `Midpoint`.
    quadratic: bool,
    /// `pᵀA q` plus linear terms: kept exactly by every embedding with one `P`, and by compositions of them.
    bilinear: bool,
}

impl Form {
    pub(super) fn of(graph: &mut Graph, value: &Sum) -> Self {
        let [quadratic, bilinear] = [Degree::Quadratic, Degree::Bilinear]
            .map(|degree| value.iter().all(|weighted| is_of_degree(graph, &weighted.element, degree)));
        Self { quadratic, bilinear }
    }

    /// Whether the step keeps a first integral of this form to rounding.
    pub(crate) fn is_kept(self, embedding: &Embedding, has_noise: bool) -> bool {
        let ([drift, noise], midpoint) = (embedding.points(), Points::one(Rational::HALF));
        let has_midpoint = drift == midpoint && *embedding != Embedding::Verlet;
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
    !graph.has_pieces(element.value, &state)
        && (0..state.len()).all(|a| {
            let slope = graph.derivative(element.value, state[a]);
            (a..state.len()).all(|b| {
                let curvature = graph.derivative(slope, state[b]);
                let is_allowed = degree == Degree::Quadratic || is_momentum(a) != is_momentum(b);
                !graph.depends_on(curvature, &state) && (is_allowed || graph.is_zero(curvature))
            })
        })
}
