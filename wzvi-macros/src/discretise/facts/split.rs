//! The parts of `drift = [H_A, H_B]`, and whether their flows are known.
//!
//! Forces and friction join the flow that remains exactly solvable with them (`f` the force, `γ` one rate of
//! friction, `T` quadratic):
//!
//! | part | flow |
//! |---|---|
//! | `V(q, t)`, forces `f(q, t)` | kick: `q` is constant, `p' = -∂V/∂q + f` |
//! | a quadratic form, friction | linear map of `q' = ∂H/∂p`, `p' = -∂H/∂q - γ p` |
//! | Kepler problems (`facts/kepler.rs`) | Kepler's, of each body by universal variables |
//!
//! The flow of a quadratic form multiplies `dq ∧ dp` by `e^{-γ s}`, so that steps are conformally
//! symplectic.
//!
//! Tests: `tests/forces/work.rs`.

use super::kepler::{NotKepler, coordinates_of_body};
use crate::diagnostics::Extent;
use crate::discretise::is_quadratic;
use crate::model::{Atom, Index, System, Term};
use crate::symbolic::{Graph, Symbol};

/// The form of a part of the drift, by which its flow is known.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum SummandForm {
    Coordinates,
    Momenta,
    Quadratic,
    /// Kepler problems of bodies with so many coordinates.
    Kepler(usize),
}

/// The parts of a drift, none if it is declared as a whole.
pub(crate) struct Summands {
    /// The form of each part, or the reason why its flow is not known.
    pub(crate) forms: Vec<Result<SummandForm, &'static str>>,
    /// The spans of forces or friction that can join none of the parts, and the reason. `Ok` if a form is not
    /// known.
    pub(crate) assignment: Result<(), (Extent, &'static str)>,
}

impl Summands {
    pub(super) fn of(system: &mut System) -> Self {
        let forms: Vec<_> = (0..system.summands.len()).map(|part| form(system, part)).collect();
        let known: Result<Vec<SummandForm>, _> = forms.iter().copied().collect();
        let assignment = known.map_or(Ok(()), |known| assign_forces(system, &known));
        Self { forms, assignment }
    }

    /// The forms of both parts; `None` if the drift has no parts, or one whose flow is not known.
    pub(crate) fn known(&self) -> Option<[SummandForm; 2]> {
        self.assignment.ok()?;
        match self.forms.as_slice() {
            &[Ok(first), Ok(second)] => Some([first, second]),
            _ => None,
        }
    }
}

/// Whether forces and friction can join parts of these forms; if not, their spans and the reason.
fn assign_forces(system: &System, forms: &[SummandForm]) -> Result<(), (Extent, &'static str)> {
    let System { graph, summands, t, force, friction, conformal, .. } = system;
    if forms.is_empty() {
        return Ok(());
    }
    if let (Some(_), Some(friction)) = (conformal, friction) {
        let moving: Vec<&SummandForm> =
            forms.iter().filter(|form| **form != SummandForm::Coordinates).collect();
        if moving != [&SummandForm::Quadratic] {
            return Err((
                friction.term.extent,
                "friction acts in the part that contains momenta, and both do",
            ));
        }
    }
    let Some(force) = force else { return Ok(()) };
    if force.elements.iter().any(|element| element.reads().p) {
        return Err((force.extent, "it depends on momenta, which change in the flow in which it acts"));
    }
    let Some(kicks) = forms.iter().position(|form| *form == SummandForm::Coordinates) else {
        return Err((force.extent, "forces act in a part that contains coordinates only, and there is none"));
    };
    if reads_time(graph, force, *t)
        && summands.iter().enumerate().any(|(part, term)| part != kicks && reads_time(graph, term, *t))
    {
        return Err((force.extent, "it and the other part depend on the time, so no flow advances it"));
    }
    Ok(())
}

/// The form of a part, or the reason why its flow is not known.
fn form(system: &mut System, part: usize) -> Result<SummandForm, &'static str> {
    let System { graph, summands, t, size, noise, conformal, .. } = system;
    let (term, others) = (&summands[part], &summands[..part]);
    if part > 0 && !noise.is_empty() {
        return Err("the noises of the system belong to neither part");
    }
    let is_timed = reads_time(graph, term, *t);
    if is_timed && others.iter().any(|other| reads_time(graph, other, *t)) {
        return Err("both parts depend on the time, so the flow of neither advances it");
    }
    if !term.elements.iter().any(|element| element.reads().p) {
        return Ok(SummandForm::Coordinates);
    }
    // With friction, momenta are not constant either.
    if !term.elements.iter().any(|element| element.reads().q) && conformal.is_none() {
        return Ok(SummandForm::Momenta);
    }
    let is_quadratic = term.elements.iter().all(|element| is_quadratic(graph, element));
    let (is_damped, has_size) = (conformal.is_some(), *size != Index::atom(Atom::Size));
    let kepler = if is_quadratic { Err(NotKepler::Other) } else { coordinates_of_body(system, part) };
    let form = match kepler {
        Ok(_) if is_damped => return Err("friction acts in it, and it is a Kepler problem"),
        Ok(_) if is_timed => {
            return Err("it is a Kepler problem whose masses or strengths depend on the time");
        }
        Ok(components) => SummandForm::Kepler(components),
        Err(NotKepler::Nearly(reason)) => return Err(reason),
        Err(NotKepler::Other) if is_quadratic && !is_timed => SummandForm::Quadratic,
        Err(NotKepler::Other) if is_damped => {
            return Err("friction acts in it, and it is not such a polynomial");
        }
        Err(NotKepler::Other) => {
            return Err("it contains coordinates and momenta, and is not such a polynomial");
        }
    };
    match (has_size, is_damped) {
        (true, _) => Ok(form),
        (false, true) => Err("friction acts in it, and only the state knows the size of the system"),
        (false, false) => {
            Err("it contains coordinates and momenta, and only the state knows the size of the system")
        }
    }
}

/// Whether a term reads the time.
pub(crate) fn reads_time(graph: &Graph, term: &Term, t: Symbol) -> bool {
    term.values.iter().chain(&term.elements).any(|element| element.reads_time(graph, t))
}
