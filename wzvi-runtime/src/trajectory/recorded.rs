//! The result of a run: states at the recorded nodes and the increments between them.

mod at;
mod error;
mod recorder;
#[cfg(feature = "serde")]
mod serial;
mod table;

use std::fmt;
use std::marker::PhantomData;

use crate::algebra::compensated::CompensatedNumber;
use crate::algebra::scalar::larger;
use crate::algebra::state::{State, Vector};
use crate::calculus::{Function, Interior, Nodes, TimeScale};
use crate::error::UnknownName;
use crate::ground::variables::Variables;
use crate::saving::FileError;
use crate::scheme::modified::{Conservative, ModifiedBy, ModifiedHamiltonian};
use crate::scheme::system::{Discretized, EulerLagrangeResidual, Exchange, Hamiltonian, Segment, fits};
use crate::trajectory::events::Event;
use crate::trajectory::options::Observable;
use crate::trajectory::section::Crossing;
use crate::trajectory::step::{Exchanged, StepInfo};
pub use at::States;
pub use error::PathError;
pub(crate) use recorder::Recorder;
pub use table::PathTable;

/// Newton iterations of a run, and other counts of its steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Iterations {
    /// Over all steps.
    pub total: u64,
    /// The largest number in one step.
    pub largest: u32,
    /// Steps that the previous ones did not predict ([`StepInfo::is_hard`]). Many such steps mean that the
    /// step is long for the fastest motion.
    pub hard: u64,
    /// Steps whose solution is the connected one by its orientation only ([`StepInfo::is_doubtful`]).
    pub doubtful: u64,
    /// Steps that were halved ([`Retry`](crate::trajectory::retry::Retry)).
    pub halved: u64,
    /// The most halvings of a step.
    pub halvings: u32,
    /// Monitored steps whose energy was off by more than a tenth of the mean of `p · dq/dt`: excursions that
    /// returned. 0 in a run that was [`unwatched`](crate::trajectory::simulate::Simulation::unwatched).
    #[cfg_attr(feature = "serde", serde(default))]
    pub suspected: u64,
}

impl Iterations {
    /// A step was taken.
    #[inline]
    pub(crate) fn count(&mut self, info: &StepInfo) {
        self.total += u64::from(info.iterations);
        self.largest = self.largest.max(info.iterations);
        self.hard += u64::from(info.is_hard);
        self.doubtful += u64::from(info.is_doubtful);
        self.halved += u64::from(info.halvings > 0);
        self.halvings = self.halvings.max(info.halvings);
    }
}

/// A path by the scheme `E`: never empty, its first state is the start.
///
/// It does not hold the system; methods that need it take it again, as in `path.energy_drift(&kubo)`.
pub struct Trajectory<V, E> {
    path: Path<V>,
    /// Not compared or saved: a path that is read from a file has none.
    variables: Option<Variables>,
    unsaved: Option<FileError>,
    scheme: PhantomData<fn() -> E>,
}

/// The part of a trajectory that does not depend on the scheme.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Path<V> {
    h: f64,
    every: u64,
    steps: u64,
    iterations: Iterations,
    processes: usize,
    /// Sums of the increments from each recorded node to the next, by rows.
    increments: Vec<f64>,
    states: Vec<State<V>>,
    last: State<V>,
    /// Nodes that are recorded besides the `every`-th.
    #[cfg_attr(feature = "serde", serde(default))]
    chosen: u64,
    /// The size of the last step, if it is shorter than the others.
    #[cfg_attr(feature = "serde", serde(default))]
    shorter: Option<f64>,
    /// The length that the last step had, if an event or the end of a run by a clock cut it: its noise is
    /// that of the whole step.
    #[cfg_attr(feature = "serde", serde(default))]
    uncut: Option<f64>,
    /// The observables at the recorded nodes, by name.
    #[cfg_attr(feature = "serde", serde(default = "Vec::new", with = "crate::ground::loose::lists"))]
    observed: Vec<(String, Vec<f64>)>,
    #[cfg_attr(feature = "serde", serde(default = "Vec::new"))]
    crossings: Vec<Crossing<V>>,
    #[cfg_attr(feature = "serde", serde(default = "Vec::new"))]
    events: Vec<Event<V>>,
    /// The steps of a clock that end at recorded nodes.
    #[cfg_attr(feature = "serde", serde(default))]
    intervals: Vec<ClockInterval>,
    /// Whether a clock had the lengths of the steps; `h` is then its `eps`.
    #[cfg_attr(feature = "serde", serde(default))]
    is_clocked: bool,
    #[cfg_attr(feature = "serde", serde(default))]
    exchanged: Exchange,
    /// The heat of each degree of freedom, where they have temperatures of their own.
    #[cfg_attr(feature = "serde", serde(default))]
    heats: Vec<f64>,
    /// Whether that is all that was exchanged, but for what the scheme does.
    #[cfg_attr(feature = "serde", serde(default))]
    is_accounted: bool,
    /// The change of the energy, if forces, friction or the time may change it.
    #[cfg_attr(feature = "serde", serde(default, with = "crate::ground::loose::option"))]
    gained: Option<f64>,
}

/// A step by a [clock](crate::scheme::clock).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ClockInterval {
    /// Its start, in the time units of the Hamiltonian.
    pub t: f64,
    /// Its length, in the same units; negative in a backward run.
    pub h: f64,
    /// The density `ρ` of the clock at its start, in 1/time; `None` for schemes without one.
    pub rho: Option<f64>,
}

impl ClockInterval {
    pub(crate) fn pass(&mut self, tape: &mut crate::ground::numbers::Tape) {
        let mut rho = self.rho.unwrap_or(f64::NAN);
        tape.numbers([&mut self.t, &mut self.h, &mut rho]);
        self.rho = Some(rho).filter(|rho| !rho.is_nan());
    }
}

impl<V: Clone, E> Clone for Trajectory<V, E> {
    fn clone(&self) -> Self {
        Self {
            path: self.path.clone(),
            variables: self.variables,
            unsaved: self.unsaved.clone(),
            scheme: PhantomData,
        }
    }
}

impl<V: fmt::Debug, E> fmt::Debug for Trajectory<V, E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Trajectory").field(&self.path).finish()
    }
}

impl<V: PartialEq, E> PartialEq for Trajectory<V, E> {
    fn eq(&self, other: &Self) -> bool {
        self.path == other.path
    }
}

/// The columns of functions of the recorded states.
fn observed<V>(
    states: &[State<V>],
    names: Vec<String>,
    functions: &[Observable<'_, V>],
) -> Vec<(String, Vec<f64>)> {
    let columns = names.into_iter().zip(functions);
    columns.map(|(name, f)| (name, states.iter().map(|state| f(state)).collect())).collect()
}

impl<V: Vector, E> Trajectory<V, E> {
    /// The state at the end of the run.
    pub fn last(&self) -> &State<V> {
        &self.path.last
    }

    /// The recorded states: the start, every `record_every`-th node, those of `record_at`, the end.
    pub fn states(&self) -> &[State<V>] {
        &self.path.states
    }

    /// The recorded states in order.
    pub fn iter(&self) -> std::slice::Iter<'_, State<V>> {
        self.path.states.iter()
    }

    /// The work done on the path, in units of energy: exactly `H(end) - H(start)` without the
    /// [heat](Trajectory::heat). Work done by the path is negative. Forces, listed noises and explicit time
    /// do work, and so does the scheme, whose part is the [shadow work](Trajectory::shadow_work).
    ///
    /// It is the `W` of Jarzynski's equality, `⟨e^{-W/kT}⟩ = e^{-ΔF/kT}`, which holds exactly at every step
    /// size with a [bath](crate::scheme::bath) at one constant temperature. It is 0 for a system without
    /// bath, force, friction and explicit time in the drift, unless an [event](Trajectory::events) changed
    /// the energy.
    pub fn work(&self) -> f64 {
        self.path.gained.map_or(0.0, |gained| gained - self.path.exchanged.heat)
    }

    /// The part of the [work](Trajectory::work) that the scheme does: the work minus a quadrature of forces,
    /// noises and explicit time along the steps. It falls with the order of the scheme. `None` without bath,
    /// force and friction, where no quadrature is made.
    pub fn shadow_work(&self) -> Option<f64> {
        self.path.is_accounted.then(|| self.work() - self.path.exchanged.work)
    }

    /// The energy that the path took from friction and bath, in units of energy: the gain of kinetic energy
    /// in their parts of the steps.
    pub fn heat(&self) -> f64 {
        self.path.exchanged.heat
    }

    /// The heat by degree of freedom, where their temperatures differ: what each took
    /// from its own bath, negative where it gave heat. They add up to [`heat`](Trajectory::heat) to rounding.
    /// Empty where all have one bath, at one temperature.
    pub fn heat_by_degree(&self) -> &[f64] {
        &self.path.heats
    }

    /// With the account of a run of this system.
    pub(crate) fn accounted<H: Discretized<E, Vector = V>>(
        mut self,
        system: &H,
        start: &State<V>,
        exchanged: &Exchanged,
    ) -> Self {
        let is_accounted = H::KIND.is_forced || H::KIND.is_conformal || H::PROPERTIES.exchanges;
        let gained = (is_accounted || H::KIND.reads_time || !self.path.events.is_empty())
            .then(|| system.energy(&self.path.last) - system.energy(start));
        let path = &mut self.path;
        (path.exchanged, path.is_accounted, path.gained) = (exchanged.all, is_accounted, gained);
        path.heats.clone_from(&exchanged.by_degree);
        self
    }

    /// How many steps were taken, and what they exchanged.
    pub(crate) fn taken(&self) -> (u64, Exchange) {
        (self.path.steps, self.path.exchanged)
    }

    pub(crate) fn suspecting(mut self, suspected: u64) -> Self {
        self.path.iterations.suspected = suspected;
        self
    }

    /// The crossings of the sections of the run, in the order of time: see [`crate::trajectory::section`].
    pub fn crossings(&self) -> &[Crossing<V>] {
        &self.path.crossings
    }

    /// The events of the run, in the order in which they happened; the state of the path at the time of an
    /// event is the one after it. See [`crate::trajectory::events`].
    pub fn events(&self) -> &[Event<V>] {
        &self.path.events
    }

    /// The steps by a [clock](crate::scheme::clock) that ended at recorded nodes, in order: all steps with
    /// `record_every(1)`, and otherwise those just before the recorded nodes. The last one ends the run at
    /// its time. Empty for constant steps.
    pub fn intervals(&self) -> &[ClockInterval] {
        &self.path.intervals
    }

    /// The values of the observable with this name
    /// ([`Simulation::observe`](crate::trajectory::simulate::Simulation::observe)) at the recorded nodes.
    ///
    /// # Errors
    /// [`UnknownName`] for a name that the run did not have.
    pub fn observed(&self, name: &str) -> Result<&[f64], UnknownName> {
        let observed = self.path.observed.iter();
        UnknownName::find("observable", name, observed.map(|(known, values)| (known, values.as_slice())))
    }

    /// Why the last [checkpoint](crate::trajectory::simulate::Simulation::checkpoint) of the run could not be
    /// written. Only this path then contains the steps since the previous one. `None` if it was written, and
    /// for a run without checkpoints.
    pub fn unsaved(&self) -> Option<&FileError> {
        self.unsaved.as_ref()
    }

    /// The names of the variables in the closure of the drift; `q`, `p` and `t` after a path was read from a
    /// file.
    pub fn variables(&self) -> Variables {
        self.variables.unwrap_or_else(|| Variables::unnamed(self.path.last.q.components().len()))
    }

    /// The trajectory of a run whose last checkpoint could not be written.
    pub(crate) fn saved_but_for(mut self, error: Option<FileError>) -> Self {
        self.unsaved = error;
        self
    }

    /// The trajectory with the names of its system.
    pub(crate) fn named(mut self, variables: Variables) -> Self {
        self.variables = Some(variables);
        self
    }

    /// Adds what functions of the state, by name, are at the recorded nodes.
    pub(crate) fn observing(mut self, names: Vec<String>, functions: &[Observable<'_, V>]) -> Self {
        self.path.observed = observed(&self.path.states, names, functions);
        self
    }

    /// Number of recorded nodes, at least 1.
    pub fn len(&self) -> usize {
        self.path.states.len()
    }

    /// Never: the start is always there.
    pub fn is_empty(&self) -> bool {
        false
    }

    /// Times of the recorded nodes, in the units of the Hamiltonian.
    pub fn times(&self) -> impl ExactSizeIterator<Item = f64> + '_ {
        self.iter().map(|state| state.t)
    }

    /// The step size `h`, same units; negative for a backward run. For a path by a clock, its `eps`.
    pub fn step_size(&self) -> f64 {
        self.path.h
    }

    /// Number of steps taken.
    pub fn steps(&self) -> u64 {
        self.path.steps
    }

    /// The value of `record_every`.
    pub fn stride(&self) -> u64 {
        self.path.every
    }

    /// Number of noises.
    pub fn processes(&self) -> usize {
        self.path.processes
    }

    /// Newton iterations, all zero for explicit and linear steps.
    pub fn iterations(&self) -> Iterations {
        self.path.iterations
    }

    /// The increments from each recorded node to the next, one row per interval and one number per noise.
    /// They are those of the steps if every step was recorded, and their sums otherwise.
    ///
    /// [`Increments`](crate::increments::Increments) made of them repeat a run of [whole
    /// steps](crate::trajectory::simulate::Simulation::whole_steps).
    pub fn increments(&self) -> impl ExactSizeIterator<Item = &[f64]> + '_ {
        (0..self.len().saturating_sub(1)).map(|interval| self.row(interval))
    }

    fn row(&self, interval: usize) -> &[f64] {
        let k = self.path.processes;
        self.path.increments.get(interval * k..(interval + 1) * k).unwrap_or(&[])
    }

    /// `W_k(t) - W_k(t_0)` at the recorded nodes; noises count from 0, and one that does not exist is zero.
    pub fn wiener(&self, k: usize) -> Vec<f64> {
        let mut sum = CompensatedNumber::default();
        let steps = self.increments().map(|row| {
            sum.add(row.get(k).copied().unwrap_or(0.0));
            sum.total()
        });
        std::iter::once(0.0).chain(steps).collect()
    }

    /// `max_i |H_0(z_i, t_i) - H_0(z_0, t_0)|` over the recorded nodes: absolute, in units of energy; NaN if
    /// a value is.
    ///
    /// It is small if the system conserves its energy (`PLAN.conserves_energy`); otherwise it measures the
    /// effect of the noise. [`Trajectory::shadow_energy_drift`] tests whether the theory of symplectic
    /// methods applies.
    pub fn energy_drift<H: Hamiltonian<Vector = V>>(&self, system: &H) -> f64 {
        self.drift(|state| system.energy(state))
    }

    /// `max_i |H~(z_i) - H~(z_0)|` over the recorded nodes for the modified Hamiltonian of the scheme with
    /// the step size of the run: absolute, in units of energy; NaN if a value is.
    ///
    /// If the theory of symplectic methods applies to the run, it is much less than
    /// [`Trajectory::energy_drift`], and falls with the step size by its own order. If the step is too long,
    /// it is as large. A shorter last step and halved steps count as well, although they follow another
    /// modified Hamiltonian.
    pub fn shadow_energy_drift<H>(&self, system: &H) -> f64
    where
        H: Discretized<E, Vector = V> + Conservative,
        E: ModifiedBy,
    {
        let modified = ModifiedHamiltonian::<E>::new(self.step_size());
        self.drift(|state| modified.energy(system, state))
    }

    /// `max_i |I(z_i) - I(z_0)|` over the recorded nodes for first integral `index` of the system, in the
    /// order of the attribute; NaN if a value is.
    ///
    /// # Errors
    /// [`PathError::Invariant`] for one that the system does not have.
    pub fn invariant_drift<H: Hamiltonian<Vector = V>>(
        &self,
        system: &H,
        index: usize,
    ) -> Result<f64, PathError> {
        let known = system.invariants();
        if index >= known {
            return Err(PathError::Invariant { index, known });
        }
        Ok(self.drift(|state| system.invariant(index, state)))
    }

    fn drift(&self, value: impl Fn(&State<V>) -> f64) -> f64 {
        let mut values = self.iter().map(value);
        let first = values.next().unwrap_or(f64::NAN);
        // The start counts too: NaN there must show.
        largest(std::iter::once(first).chain(values).map(|value| value - first))
    }

    /// The time scale T of the recorded nodes.
    ///
    /// # Errors
    /// [`PathError::Empty`] for a path without steps, [`PathError::Uneven`] if intervals differ, such as a
    /// last one that is shorter: a run of
    /// [`whole_steps`](crate::trajectory::simulate::Simulation::whole_steps) has none.
    pub fn time_scale(&self) -> Result<TimeScale, PathError> {
        let even = self.even()?;
        match even {
            [first, .., last] if even.len() == self.len() => {
                Ok(TimeScale::new(first.t, last.t, even.len() - 1)?)
            }
            _ => Err(self.uneven()),
        }
    }

    fn uneven(&self) -> PathError {
        PathError::Uneven { every: self.path.every, steps: self.path.steps }
    }

    /// The recorded nodes at equal distances in time: without the last one, where the interval before it is
    /// shorter than the others.
    ///
    /// # Errors
    /// [`PathError::Empty`] for a path without steps, [`PathError::Uneven`] if other intervals differ.
    pub(crate) fn even(&self) -> Result<&[State<V>], PathError> {
        let Path { every, steps, states, chosen, shorter, .. } = &self.path;
        if self.path.is_clocked {
            return Err(self.uneven());
        }
        let ends_short = shorter.is_some() || *every > 1 && steps % every != 0;
        match states.as_slice() {
            [] | [_] => Err(PathError::Empty),
            _ if *chosen > 0 => Err(self.uneven()),
            [_, _] => Ok(states),
            [even @ .., _] if ends_short => Ok(even),
            _ => Ok(states),
        }
    }

    /// An observable along the path, as a function on T: the discrete calculus starts here.
    ///
    /// # Errors
    /// As [`Trajectory::time_scale`].
    pub fn observable<T>(&self, value: impl FnMut(&State<V>) -> T) -> Result<Function<Nodes, T>, PathError> {
        Ok(Function::new(self.time_scale()?, self.iter().map(value).collect())?)
    }

    /// The residual of the discrete Euler-Lagrange equations at each interior node (T^±): of the equation of
    /// the node, and of the momentum of the step that starts there.
    ///
    /// # Errors
    /// [`PathError::Gaps`] unless every step was recorded, [`PathError::Empty`] for a path without steps,
    /// [`PathError::System`] if the path is not one of `system`.
    pub fn euler_lagrange<H>(
        &self,
        system: &H,
    ) -> Result<Function<Interior, EulerLagrangeResidual<V>>, PathError>
    where
        H: Discretized<E, Vector = V>,
    {
        self.check_every_step(system)?;
        let scale = self.time_scale()?;
        Ok(Function::new(scale, self.residuals(system))?)
    }

    /// The residuals at the interior nodes, of a path of which every step was recorded.
    fn residuals<H>(&self, system: &H) -> Vec<EulerLagrangeResidual<V>>
    where
        H: Discretized<E, Vector = V>,
    {
        let mut residuals = Vec::with_capacity(self.len().saturating_sub(2));
        let mut previous: Option<(Segment<V>, &[f64])> = None;
        for next in self.segments(system) {
            if let Some((segment, dw)) = &previous {
                residuals.push(system.euler_lagrange_residual(segment, &next.0, dw, next.1));
            }
            previous = Some(next);
        }
        residuals
    }

    /// The largest absolute residual of the discrete Euler-Lagrange equations:
    /// `|D_2 L_d(step i-1) + D_1 L_d(step i)|` over the interior nodes, and `|∂L_d/∂P|` over all steps. It is
    /// at rounding level on any path that the scheme computed without halved steps, which have two equations
    /// each. It is NaN if a residual is, and with a [bath](crate::scheme::bath), whose steps follow from no
    /// Lagrangian.
    ///
    /// # Errors
    /// As [`Trajectory::euler_lagrange`]; a last step that is shorter is one of the steps.
    pub fn euler_lagrange_residual<H>(&self, system: &H) -> Result<f64, PathError>
    where
        H: Discretized<E, Vector = V>,
    {
        self.check_every_step(system)?;
        self.even()?;
        let interior = self.residuals(system);
        let first = self.segments(system).next();
        let first = first.map(|(segment, dw)| system.discrete_lagrangian_gradient(&segment, dw).p);
        let both = interior.iter().flat_map(|residual| [&residual.node, &residual.momentum]);
        Ok(largest(both.chain(&first).flat_map(|vector| vector.components()).copied()))
    }

    fn check_every_step<H: Discretized<E, Vector = V>>(&self, system: &H) -> Result<(), PathError> {
        if self.path.every != 1 && self.path.steps > 1 {
            return Err(PathError::Gaps { every: self.path.every });
        }
        let path = (self.last().q.components().len(), self.processes());
        let asked = (system.degrees(), system.increments(path.0));
        if fits(system, path.0) && path.1 == asked.1 {
            Ok(())
        } else {
            Err(PathError::System { path, system: asked })
        }
    }

    /// The steps with their increments.
    fn segments<H>(&self, system: &H) -> impl Iterator<Item = (Segment<V>, &[f64])>
    where
        H: Discretized<E, Vector = V>,
    {
        let (h, shorter, steps) = (self.step_size(), self.path.shorter, self.len() - 1);
        let ends = self.states().iter().zip(self.states().iter().skip(1));
        (1..).zip(ends).zip(self.increments()).map(move |((step, (before, after)), dw)| {
            let h = shorter.filter(|_| step == steps).unwrap_or(h);
            let p = system.step_momentum(before, after, h, dw);
            (Segment { q0: before.q.clone(), q1: after.q.clone(), p, t: before.t, h }, dw)
        })
    }
}

/// The largest absolute value, 0 of none, NaN if one is.
fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.map(f64::abs).fold(0.0, larger)
}

impl<V, E> IntoIterator for Trajectory<V, E> {
    type Item = State<V>;
    type IntoIter = std::vec::IntoIter<State<V>>;

    fn into_iter(self) -> Self::IntoIter {
        self.path.states.into_iter()
    }
}

impl<'a, V, E> IntoIterator for &'a Trajectory<V, E> {
    type Item = &'a State<V>;
    type IntoIter = std::slice::Iter<'a, State<V>>;

    fn into_iter(self) -> Self::IntoIter {
        self.path.states.iter()
    }
}
