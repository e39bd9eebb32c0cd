//! The figures of a path.
//!
//! Tested by `tests/paths/results.rs`.

use super::figure::{Colour, Figure, Look};
use crate::algebra::state::{State, Vector};
use crate::error::UnknownName;
use crate::scheme::system::Hamiltonian;
use crate::trajectory::recorded::Trajectory;

/// Degrees of freedom that are shown by default: as many as there are colours.
pub(super) const SHOWN: usize = 6;

/// Figures of a path: [`Trajectory::plot`] begins them. Each method returns a [`Figure`]: [`Figure::write`]
/// draws it as SVG or PNG, and a [`Sheet`](super::Sheet) puts it beside others.
#[derive(Debug)]
#[must_use = "nothing is drawn before `write`"]
pub struct PathPlot<'a, V, E> {
    path: &'a Trajectory<V, E>,
    degrees: Vec<usize>,
}

/// The variable of an axis.
#[derive(Clone, Copy)]
enum Variable {
    Coordinate(usize),
    Momentum(usize),
    Time,
}

impl<V: Vector, E> Trajectory<V, E> {
    /// The path as figures, with the names of the closure: of the first six degrees of freedom, or of those
    /// that [`PathPlot::degrees`] names. They show the recorded nodes.
    ///
    /// `path.plot().phase_portrait().write("portrait.svg")?` draws one.
    pub fn plot(&self) -> PathPlot<'_, V, E> {
        let degrees = self.last().q.components().len();
        PathPlot { path: self, degrees: (0..degrees.min(SHOWN)).collect() }
    }
}

impl<V: Vector, E> PathPlot<'_, V, E> {
    /// These degrees of freedom, which count from 0; one that does not exist is not drawn.
    pub fn degrees(mut self, degrees: impl IntoIterator<Item = usize>) -> Self {
        let all = self.path.last().q.components().len();
        self.degrees = degrees.into_iter().filter(|&degree| degree < all).collect();
        self
    }

    /// Momenta against coordinates, a curve for each degree of freedom. A path that fills the plane, such as
    /// one with noise and many nodes, is drawn as dots.
    pub fn phase_portrait(&self) -> Figure {
        let all: Vec<(usize, [String; 2])> = self.named().collect();
        let labels =
            |which: usize| all.iter().map(|(_, names)| names[which].as_str()).collect::<Vec<_>>().join(", ");
        let mut figure = Figure::panel("Phase portrait", labels(0), labels(1));
        for (colour, (degree, [q, p])) in all.iter().enumerate() {
            let points = self.path.iter().map(|state| pair(state, *degree));
            let name = if all.len() > 1 { format!("{p} against {q}") } else { String::new() };
            figure = figure.line(name, colour, points);
        }
        figure
    }

    /// One variable against another, by their names in the closure: coordinates, momenta or time, of any
    /// degree of freedom. Two coordinates, or two momenta, have equal axes.
    ///
    /// `path.plot().orbit("x", "y")?.write("orbit.svg")?` draws the orbit of a particle in a plane.
    ///
    /// # Errors
    /// [`UnknownName`] for a name that does not exist.
    pub fn orbit(&self, x: &str, y: &str) -> Result<Figure, UnknownName> {
        let [across, along] = [self.variable(x)?, self.variable(y)?];
        let value = |state: &State<V>, variable: Variable| match variable {
            Variable::Time => state.t,
            Variable::Coordinate(degree) => pair(state, degree).0,
            Variable::Momentum(degree) => pair(state, degree).1,
        };
        let points = self.path.iter().map(|state| (value(state, across), value(state, along)));
        let mut figure = Figure::panel("Orbit", x, y).line("", Colour::BLUE, points);
        figure.has_equal_axes = std::mem::discriminant(&across) == std::mem::discriminant(&along);
        Ok(figure)
    }

    /// The variable of this name.
    fn variable(&self, name: &str) -> Result<Variable, UnknownName> {
        let names = self.path.variables();
        let degrees = 0..self.path.last().q.components().len();
        let coordinates = degrees.clone().map(|i| (names.q.name(i), Variable::Coordinate(i)));
        let momenta = degrees.map(|i| (names.p.name(i), Variable::Momentum(i)));
        let all = coordinates.chain(momenta).chain([(names.t.to_owned(), Variable::Time)]);
        UnknownName::find("variable", name, all)
    }

    /// Coordinates (lines) and momenta (dashed) against time.
    pub fn time_series(&self) -> Figure {
        let mut figure = Figure::panel("Time series", self.path.variables().t, "");
        for (colour, (degree, [q, p])) in self.named().enumerate() {
            let along = |which: usize| {
                let value = move |state: &State<V>| {
                    let (q, p) = pair(state, degree);
                    [q, p][which]
                };
                self.path.iter().map(move |state| (state.t, value(state)))
            };
            figure = figure.line(q, colour, along(0)).points(Look::Dashed, p, colour, along(1));
        }
        figure
    }

    /// The drift Hamiltonian of the system and its proven first integrals, each minus its value at the start,
    /// against time: absolute, in their own units.
    pub fn energy_drift<H: Hamiltonian<Vector = V>>(&self, system: &H) -> Figure {
        let mut figure =
            Figure::panel("What should be kept", self.path.variables().t, "change since the start");
        let energy = |state: &State<V>| system.energy(state);
        figure = figure.line("H₀", Colour::BLUE, self.since_start(energy));
        for index in 0..system.invariants() {
            let value = |state: &State<V>| system.invariant(index, state);
            figure = figure.line(system.variables().invariant(index), 1 + index, self.since_start(value));
        }
        figure
    }

    /// The observables that the system declares, `observe = [radius = |q, p| ..., ...]`, each under its name
    /// against time.
    pub fn observables<H: Hamiltonian<Vector = V>>(&self, system: &H) -> Figure {
        let names = system.variables();
        let mut figure = Figure::panel("Observables", self.path.variables().t, "");
        for index in 0..system.observables() {
            let points = self.path.iter().map(|state| (state.t, system.observable(index, state)));
            figure = figure.line(names.observable(index), index, points);
        }
        figure
    }

    /// The crossings of the sections of the run
    /// ([`Simulation::section`](crate::trajectory::simulate::Simulation::section)): momenta against
    /// coordinates of the first degree of freedom that is shown, with a colour for each section.
    pub fn section(&self) -> Figure {
        let Some((degree, [q, p])) = self.named().next() else { return Figure::panel("Section", "", "") };
        let mut figure = Figure::panel("Section", q, p);
        let crossings = self.path.crossings();
        let sections = crossings.iter().map(|crossing| crossing.section + 1).max().unwrap_or(0);
        for section in 0..sections {
            let of_section = crossings.iter().filter(|crossing| crossing.section == section);
            let points = of_section.map(|crossing| pair(&crossing.state, degree));
            let name = if sections > 1 { format!("section {section}") } else { String::new() };
            figure = figure.points(Look::FineDots, name, section, points);
        }
        figure
    }

    fn since_start(&self, value: impl Fn(&State<V>) -> f64) -> Vec<(f64, f64)> {
        let start = self.path.iter().next().map_or(f64::NAN, &value);
        self.path.iter().map(|state| (state.t, value(state) - start)).collect()
    }

    /// The degrees of freedom that are shown, with the names of coordinate and momentum.
    fn named(&self) -> impl Iterator<Item = (usize, [String; 2])> {
        let names = self.path.variables();
        self.degrees.iter().map(move |&degree| (degree, [names.q.name(degree), names.p.name(degree)]))
    }
}

/// Coordinate and momentum of a degree of freedom.
fn pair<V: Vector>(state: &State<V>, degree: usize) -> (f64, f64) {
    let component = |vector: &V| vector.components().get(degree).copied().unwrap_or(f64::NAN);
    (component(&state.q), component(&state.p))
}
