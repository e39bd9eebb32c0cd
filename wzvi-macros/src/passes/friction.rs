//! Checks the declaration of friction, and without a thermostat makes it part of the steps.
//!
//! | declared | in a step |
//! |---|---|
//! | one rate for all degrees of freedom, no thermostat | exactly, in the momentum `π = e^{γ (t - t_i)} p`: conformally symplectic |
//! | other friction, no thermostat | the force `-Γ M⁻¹ p` |
//! | a thermostat | a flow of its own, beside the steps |
//!
//! Tests: `tests/forces/friction.rs`.

use crate::diagnostics::{Diagnostics, facts as messages};
use crate::discretise::{Calculus, Increments, Kinetic, Space, Weighted, unweighted};
use crate::embedding::Embedding;
use crate::model::{Element, Friction, Half, Local, Slot, System, Term};
use crate::symbolic::{Expr, Graph, Rational, Symbol};

/// Checks friction, temperature and the requirements of thermostats. Without a thermostat, friction then
/// becomes a force, or the rate of [`System::conformal`].
pub(crate) fn friction(system: &mut System, diagnostics: &mut Diagnostics) {
    let Some(friction) = system.friction.clone() else {
        for known in system.embeddings.iter().filter(|known| known.value.is_thermostat()) {
            diagnostics.report(messages::thermostat_without_friction(known.extent, &known.value));
        }
        if let Some(temperature) = &system.temperature {
            diagnostics.report(messages::temperature_without_friction(temperature.term.extent));
        }
        return;
    };
    check(system, &friction, diagnostics);
    if system.has_thermostat() || system.temperature.is_some() || diagnostics.has_errors() {
        return;
    }
    // An entry of a list is not a parameter of a system in loops.
    let is_parameter =
        |rate: &Expr| system.symbols.locals_among(system.graph.symbols_in(*rate).into_iter()).is_empty();
    match friction.uniform.filter(is_parameter) {
        Some(rate) => system.conformal = Some(rate),
        None => friction_as_force(system, &friction, diagnostics),
    }
}

fn check(system: &mut System, friction: &Friction, diagnostics: &mut Diagnostics) {
    if system.has_thermostat() || system.temperature.is_some() {
        let reason = match system.temperature {
            Some(_) => "this system has a temperature, so its scheme needs a heat bath",
            None => "friction is a part of its own in the thermostats that are listed",
        };
        for known in system.embeddings.iter().filter(|known| !known.value.is_thermostat()) {
            let keeps_constraints = known.value.keeps_constraints();
            diagnostics.report(messages::friction_needs_thermostat(
                known.extent,
                &known.value,
                reason,
                keeps_constraints,
            ));
        }
    }
    let has_list = system.temperature.as_ref().is_some_and(|known| known.is_list);
    if has_list || friction.is_matrix || !friction.is_one_rate || friction.is_per_place() {
        for known in system.embeddings.iter().filter(|known| known.value == Embedding::GBaoab) {
            diagnostics.report(messages::bath_on_manifold(known.extent));
        }
    }
    let extent = friction.term.extent;
    match Kinetic::of(system) {
        None => diagnostics.report(messages::friction_without_masses(extent)),
        Some(Kinetic { is_diagonal: false }) if !friction.is_matrix && !friction.is_one_rate => {
            diagnostics.report(messages::rates_of_coupled_momenta(extent));
        }
        Some(_) => {}
    }
    if let Some(extent) =
        system.temperature.as_ref().filter(|known| known.is_list).map(|known| known.term.extent)
        && (Kinetic::of(system).is_some_and(|kinetic| !kinetic.is_diagonal)
            || (friction.is_matrix && couples(system, &friction.term)))
    {
        diagnostics.report(messages::temperatures_of_coupled_momenta(extent));
    }
    if friction.is_matrix {
        if friction.is_per_place() {
            diagnostics.report(messages::damping_of_place(extent));
        } else if is_asymmetric(system, &friction.term) {
            diagnostics.report(messages::asymmetric_damping(extent));
        }
    }
}

/// Whether a matrix has an entry beside its diagonal that is not zero. Entries of lists are compared with
/// zero in steps.
fn couples(system: &mut System, matrix: &Term) -> bool {
    let graph = &mut system.graph;
    matrix.elements.iter().filter(|element| element.loops.is_empty()).any(|element| {
        let places =
            element.displacements().flat_map(|row| element.momenta().map(move |column| (row, column)));
        let beside: Vec<(Symbol, Symbol)> =
            places.filter(|((_, i), (_, j))| i != j).map(|((row, _), (column, _))| (row, column)).collect();
        beside.into_iter().any(|(row, column)| {
            let entry = graph.derivative(element.value, row);
            let entry = graph.derivative(entry, column);
            !graph.is_zero(entry) && !reads_lists(graph, element, entry)
        })
    })
}

/// Whether an entry reads fields that are lists.
fn reads_lists(graph: &Graph, element: &Element, entry: Expr) -> bool {
    let is_of_list = |local: &&Local| matches!(local.slot, Slot::Entry(..));
    element.locals.iter().filter(is_of_list).any(|local| graph.depends_on(entry, &[local.symbol]))
}

/// Whether `Γ_ij` and `Γ_ji` are known to differ: both are without loops, and neither reads a list. The run
/// time compares other entries when a stepper is made.
fn is_asymmetric(system: &mut System, matrix: &Term) -> bool {
    let graph = &mut system.graph;
    let mut entries = Vec::new();
    for element in matrix.elements.iter().filter(|element| element.loops.is_empty()) {
        for (displacement, i) in element.displacements() {
            let row = graph.derivative(element.value, displacement);
            for (momentum, j) in element.momenta() {
                let entry = graph.derivative(row, momentum);
                if !graph.is_zero(entry) {
                    let reads_fields = reads_lists(graph, element, entry);
                    entries.push((i.clone(), j.clone(), entry, reads_fields));
                }
            }
        }
    }
    entries.iter().any(|(i, j, entry, reads_fields)| {
        let across = entries.iter().find(|(row, column, ..)| row == j && column == i);
        let (is_same, others_read) = match across {
            Some((.., other, others_read)) => {
                let difference = graph.subtract(*entry, *other);
                (graph.is_zero(difference), *others_read)
            }
            None => (false, false),
        };
        !is_same && !reads_fields && !others_read
    })
}

/// Adds `-G p` or `-Γ M⁻¹ p` to the force.
fn friction_as_force(system: &mut System, friction: &Friction, diagnostics: &mut Diagnostics) {
    let term = &friction.term;
    let drawn = match friction.is_matrix {
        false => Some(unweighted(&term.values)),
        true => {
            let (matrix, kinetic) = (unweighted(&term.elements), unweighted(&system.drift.elements));
            let (space, graph) = (&mut Space::of(system), &mut system.graph);
            let momenta = Half::Momenta;
            Calculus { space, graph }.contract((&matrix, momenta), (&kinetic, momenta), Increments::Each)
        }
    };
    let Some(drawn) = drawn else {
        diagnostics.report(messages::damping_of_elements(term.extent));
        return;
    };
    let graph = &mut system.graph;
    let negative = drawn.into_iter().map(|Weighted { element, .. }| {
        let value = graph.scale(element.value, Rational::MINUS_ONE);
        Element { value, ..element }
    });
    let negative: Vec<Element> = negative.collect();
    let force = system.force.get_or_insert_with(|| Term {
        expression: graph.integer(0),
        elements: Vec::new(),
        values: Vec::new(),
        extent: term.extent,
    });
    force.values.extend(negative.iter().cloned());
    force.elements.extend(negative);
}
