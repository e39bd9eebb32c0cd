//! Settings that several builders share: each is written once, and its value is checked in one place.
//!
//! `options!(start, end, ...)` inside an `impl` of a builder gives it the methods; the builder has a field
//! `setup` with those that they set.

use std::collections::HashSet;
use std::fmt;
use std::sync::Arc;

use crate::algebra::lanes::instructions::InstructionSet;
use crate::algebra::memory::Threads;
use crate::algebra::state::State;
use crate::error::{ConfigError, wrong};
use crate::ground::handle::Handle;
use crate::ground::progress::ProgressLine;
use crate::scheme::system::Hamiltonian;
use crate::trajectory::checkpoint::CheckpointSetting;
use crate::trajectory::events::EventRules;
use crate::trajectory::recording::RecordingRequest;
use crate::trajectory::retry::Retry;
use crate::trajectory::section::Sections;
use crate::trajectory::span::RunSpan;

/// A function of the state.
pub(crate) type Observable<'a, V> = Arc<dyn Fn(&State<V>) -> f64 + Send + Sync + 'a>;

/// A function of the system of a path and its state.
pub(crate) type OwnObservable<'a, H, V> = Arc<dyn Fn(&H, &State<V>) -> f64 + Send + Sync + 'a>;

/// Functions of the state, with the settings of each.
pub(crate) struct Functions<'a, V, K>(pub(crate) Vec<(K, Observable<'a, V>)>);

/// Functions of the state, by name.
pub(crate) type Observables<'a, V> = Functions<'a, V, String>;

impl<V, K: Clone> Clone for Functions<'_, V, K> {
    fn clone(&self) -> Self {
        Self(self.0.clone())
    }
}

impl<V, K> Default for Functions<'_, V, K> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<V, K: fmt::Debug> fmt::Debug for Functions<'_, V, K> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.0.iter().map(|(said, _)| said)).finish()
    }
}

impl<'a, V, K> Functions<'a, V, K> {
    pub(crate) fn push(&mut self, said: K, f: impl Fn(&State<V>) -> f64 + Send + Sync + 'a) {
        self.0.push((said, Arc::new(f)));
    }

    /// The functions alone.
    pub(crate) fn functions(&self) -> impl Iterator<Item = &Observable<'a, V>> {
        self.0.iter().map(|(_, function)| function)
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub(crate) fn len(&self) -> usize {
        self.0.len()
    }
}

/// In the place of an observable that is no function of the state alone: whoever looks at a path puts its
/// value there.
pub(crate) fn elsewhere<V>(_: &State<V>) -> f64 {
    f64::NAN
}

impl<'a, V> Observables<'a, V> {
    /// Names and functions. `what` they are, in the plural, is for errors.
    ///
    /// # Errors
    /// [`ConfigError::Setting`] if two have the same name.
    pub(crate) fn checked(self, what: &str) -> Result<(Vec<String>, Vec<Observable<'a, V>>), ConfigError> {
        let (names, functions): (Vec<String>, _) = self.0.into_iter().unzip();
        let mut known = HashSet::new();
        match names.iter().find(|name| !known.insert(*name)) {
            Some(twice) => wrong(format!("two {what} have the name `{twice}`")),
            None => Ok((names, functions)),
        }
    }
}

/// The settings of a run so far: those of all runs of paths, and those of one kind of run.
#[derive(Clone, Debug)]
pub(crate) struct RunSetup<'a, H: Hamiltonian, M = ()> {
    pub(crate) system: &'a H,
    pub(crate) h: f64,
    pub(crate) span: RunSpan<H::Vector>,
    pub(crate) recorded: RecordingRequest,
    pub(crate) observables: Observables<'a, H::Vector>,
    pub(crate) sections: Sections<'a, H::Vector>,
    pub(crate) events: EventRules<'a, H::Vector>,
    pub(crate) retry: Retry,
    pub(crate) is_watched: bool,
    pub(crate) execution: Execution<'a>,
    pub(crate) keeping: CheckpointSetting,
    pub(crate) more: M,
}

impl<'a, H: Hamiltonian, M: Default> RunSetup<'a, H, M> {
    pub(crate) fn new(system: &'a H, h: f64) -> Self {
        Self {
            system,
            h,
            span: RunSpan::default(),
            recorded: RecordingRequest::default(),
            observables: Observables::default(),
            sections: Sections::default(),
            events: EventRules::default(),
            retry: Retry::never(),
            is_watched: true,
            execution: Execution::default(),
            keeping: CheckpointSetting::default(),
            more: M::default(),
        }
    }
}

/// How a run is carried out: none of it changes the result.
#[derive(Clone, Default)]
pub(crate) struct Execution<'a> {
    pub(crate) threads: Option<usize>,
    pub(crate) stop: Option<Arc<dyn Fn() -> bool + Send + Sync + 'a>>,
    pub(crate) is_quiet: bool,
    pub(crate) handle: Option<Handle>,
    /// The best of the machine by default.
    pub(crate) instructions: Option<InstructionSet>,
}

impl fmt::Debug for Execution<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut fields = f.debug_struct("Execution");
        fields.field("threads", &self.threads).field("is_quiet", &self.is_quiet).finish_non_exhaustive()
    }
}

impl Execution<'_> {
    /// The requested number, or all cores.
    ///
    /// # Errors
    /// [`ConfigError::Setting`] for none.
    pub(crate) fn threads(&self) -> Result<usize, ConfigError> {
        Ok(Threads::asked(self.threads)?.number(usize::MAX))
    }

    pub(crate) fn instructions(&self) -> InstructionSet {
        self.instructions.unwrap_or_else(InstructionSet::best)
    }

    /// Whether the run is to end, because its handle or a function says so.
    pub(crate) fn is_stopped(&self) -> bool {
        self.handle.as_ref().is_some_and(Handle::is_stopped) || self.stop.as_ref().is_some_and(|stop| stop())
    }

    /// The line that shows how many of these are done.
    pub(crate) fn progress(&self, unit: &'static str) -> ProgressLine {
        ProgressLine::new(unit, self.is_quiet, self.handle.clone())
    }
}

/// Methods that builders have in common.
macro_rules! options {
    ($($option:ident),*) => { $(crate::trajectory::options::options!(@ $option);)* };
    (@ start) => {
        /// The first state, at its own time. A run that continues another starts at its last state:
        /// `.start(run.last().clone())`. Its noise is then that of later times, also with the same seed. From
        /// a state whose time is set back, as by `.at(0.0)`, the same seed repeats the noise.
        pub fn start(mut self, start: crate::algebra::state::State<H::Vector>) -> Self {
            self.setup.span.start.set("start", crate::trajectory::exclusive_setting::SOME, start);
            self
        }

        /// Projects starts on the manifold of the [constraints](crate::scheme::constraints), however far they
        /// are from it. Without it, a start is projected if it is on the manifold up to `1e-6` of the terms
        /// of each constraint, and refused otherwise.
        pub fn project_start(mut self) -> Self {
            self.setup.span.is_projected = true;
            self
        }
    };
    (@ end) => {
        /// Runs to time `end` (time units of the Hamiltonian). Where `end` is no multiple of the step from
        /// the start, the last step is shorter.
        ///
        /// A multiple up to the rounding of these times counts as one: `until(20.0)` with `h = 0.02` takes
        /// 1000 steps, all of the size `h`. It is an error together with `steps`.
        pub fn until(mut self, end: f64) -> Self {
            self.setup.span.end.set("until", crate::ground::digits::ShortestDecimal(end), crate::trajectory::span::RunEnd::Time(end));
            self
        }

        /// Runs `steps` steps.
        pub fn steps(mut self, steps: u64) -> Self {
            self.setup.span.end.set("steps", steps, crate::trajectory::span::RunEnd::Steps(steps));
            self
        }
    };
    (@ whole) => {
        /// Takes whole steps only: the run ends at the first node at or beyond the time of `until`.
        ///
        /// Without it, a last step that is shorter is prepared once, like the others. Its increments belong
        /// to its own interval: `Wiener` and `WongZakai` give those of the path, and `StepNormals` and seeds
        /// of ensembles draw separate normals. `Increments` have none for a shorter step. Another noise must
        /// implement [`Noise::increments_of_part`](crate::increments::Noise::increments_of_part), or the run
        /// does not start.
        pub fn whole_steps(mut self) -> Self {
            self.setup.span.is_whole = true;
            self
        }
    };
    (@ section) => {
        /// Finds the crossings, in both directions, of the section on which `value`, a function of the state,
        /// is zero ([`crate::trajectory::section`]). May be called more than once; sections are numbered
        /// from 0.
        pub fn section(mut self, value: impl Fn(&crate::algebra::state::State<H::Vector>) -> f64 + Send + Sync + 'a) -> Self {
            self.setup.sections.push(None, value);
            self
        }

        /// Finds crossings in one direction only.
        pub fn section_towards(
            mut self,
            direction: crate::trajectory::section::Direction,
            value: impl Fn(&crate::algebra::state::State<H::Vector>) -> f64 + Send + Sync + 'a,
        ) -> Self {
            self.setup.sections.push(Some(direction), value);
            self
        }
    };
    (@ events) => {
        /// Acts on the path where `value`, a function of the state, is zero, in both directions
        /// ([`crate::trajectory::events`]): `action` changes the state there, and the run goes on from it; an
        /// action that returns [`Terminal`](crate::trajectory::events::Terminal) ends the run. May be called
        /// more than once; events are numbered from 0, together with those of `on_towards` and `on_time`.
        pub fn on<R: Into<crate::trajectory::events::AfterEvent>>(
            mut self,
            value: impl Fn(&crate::algebra::state::State<H::Vector>) -> f64 + Send + Sync + 'a,
            action: impl Fn(&mut crate::algebra::state::State<H::Vector>) -> R + Send + Sync + 'a,
        ) -> Self {
            let place = crate::trajectory::events::EventPlace::Crossing(None, std::sync::Arc::new(value));
            self.setup.events.push(place, action);
            self
        }

        /// As `on`, for crossings in one direction.
        pub fn on_towards<R: Into<crate::trajectory::events::AfterEvent>>(
            mut self,
            direction: crate::trajectory::section::Direction,
            value: impl Fn(&crate::algebra::state::State<H::Vector>) -> f64 + Send + Sync + 'a,
            action: impl Fn(&mut crate::algebra::state::State<H::Vector>) -> R + Send + Sync + 'a,
        ) -> Self {
            let place = crate::trajectory::events::EventPlace::Crossing(Some(direction), std::sync::Arc::new(value));
            self.setup.events.push(place, action);
            self
        }

        /// Acts on the path at the time `t` (time units of the Hamiltonian). A time before the start or after
        /// the end has no event.
        pub fn on_time<R: Into<crate::trajectory::events::AfterEvent>>(
            mut self,
            t: f64,
            action: impl Fn(&mut crate::algebra::state::State<H::Vector>) -> R + Send + Sync + 'a,
        ) -> Self {
            self.setup.events.push(crate::trajectory::events::EventPlace::Time(t), action);
            self
        }
    };
    (@ record) => {
        /// Records every `stride`-th node, the start and the last node; 0 records only these two. Without
        /// this and `record_at`, a single path records all nodes, and an ensemble the start and the last one.
        pub fn record_every(mut self, stride: u64) -> Self {
            self.setup.recorded.every = Some(stride);
            self
        }

        /// Records the states at these times as well. A time equal to a node up to rounding is that node;
        /// others are on the dense output of their step ([`crate::scheme::dense`]). The states come in the
        /// order of the run. Two times at the same node are an error. Without `record_every`, the run records
        /// only these, the start and the end.
        pub fn record_at(mut self, times: impl IntoIterator<Item = f64>) -> Self {
            self.setup.recorded.times.extend(times);
            self
        }
    };
    (@ observe) => {
        /// Adds an observable, a function of the state. The result has its values at the recorded nodes under
        /// this name.
        pub fn observe(
            mut self,
            name: impl Into<String>,
            observable: impl Fn(&crate::algebra::state::State<H::Vector>) -> f64 + Send + Sync + 'a,
        ) -> Self {
            self.setup.observables.push(name.into(), observable);
            self
        }

        /// Observes a quantity of the system of the path under this name. [`Quantity::named`] finds one by
        /// its own name, such as that of an observable in `observe = [...]`.
        ///
        /// [`Quantity::named`]: crate::scheme::system::Quantity::named
        pub fn observe_quantity(self, name: impl Into<String>, quantity: crate::scheme::system::Quantity) -> Self
        where
            H: Sync,
        {
            self.observe_own(name, move |system, state| quantity.value(system, state))
        }
    };
    (@ temperatures) => {
        /// Observes `kinetic temperature`, `p · ∂H/∂p / d`, and `configurational temperature`,
        /// `q · ∂H/∂q / d`, in units of energy, with the Hamiltonian of the path. Under the Gibbs measure
        /// their averages are the temperature, the second one if the system is confined. Where the
        /// temperatures of the degrees of freedom differ, the run is an error: there is no one temperature.
        /// With constraints `d` is the number of degrees of freedom that are left, and there is the kinetic
        /// temperature alone.
        pub fn observe_temperatures(mut self) -> Self
        where
            H: Sync,
        {
            self.setup.span.asks_one_temperature = true;
            let is_free = self.setup.system.manifold().is_none();
            let observing = self.observe_own("kinetic temperature", crate::trajectory::series::kinetic);
            if !is_free {
                return observing;
            }
            observing.observe_own("configurational temperature", crate::trajectory::series::configurational)
        }

        /// Observes the temperatures of each degree of freedom, numbered from 0: `kinetic temperature 0`,
        /// ..., `configurational temperature 0`, ... Their number is that of a system that knows its size, or
        /// of the start, which is then given before. With constraints the run is an error: momenta in a
        /// tangent plane do not share the energy one by one.
        pub fn observe_equipartition(mut self) -> Self
        where
            H: Sync,
        {
            let system = self.setup.system;
            let of_start = |start: &crate::algebra::state::State<H::Vector>| crate::algebra::state::Vector::components(&start.q).len();
            let degrees = self.setup.span.start.value().map_or(system.degrees(), of_start);
            self.setup.span.was_asked_early |= degrees == 0;
            self.setup.span.asks_shares = true;
            for i in 0..degrees {
                self = self.observe_own(format!("kinetic temperature {i}"), move |system, state| {
                    crate::trajectory::series::kinetic_of(system, state, i)
                });
                self = self.observe_own(format!("configurational temperature {i}"), move |system, state| {
                    crate::trajectory::series::configurational_of(system, state, i)
                });
            }
            self
        }
    };
    (@ watch) => {
        /// Does not monitor the energy, and continues where it has changed permanently; without it, a run of
        /// a system that conserves its energy ends there with
        /// [`StepFailure::Unresolved`](crate::error::StepFailure::Unresolved). Use it if you check the energy
        /// yourself.
        pub fn unwatched(mut self) -> Self {
            self.setup.is_watched = false;
            self
        }
    };
    (@ execution) => {
        crate::trajectory::options::options!(@ progress);

        /// Sets the number of threads; the default is all cores. The result is the same.
        pub fn threads(mut self, threads: usize) -> Self {
            self.setup.execution.threads = Some(threads);
            self
        }

        /// Lets this handle stop the run and report its progress ([`crate::ground::handle`]). A stopped run
        /// returns its results so far, marked as partial.
        pub fn handle(mut self, handle: &crate::ground::handle::Handle) -> Self {
            self.setup.execution.handle = Some(handle.clone());
            self
        }
    };
    (@ progress) => {
        /// Ends the run early when `stop` returns true, at a deadline for example. The result then covers the
        /// work so far, and is marked as partial.
        ///
        /// All threads call it about every 10 ms, and after each step or observed path that takes longer; a
        /// single path calls it ten times a second, and ends with `Error::Stopped`. A [handle](Self::handle)
        /// also stops a run.
        pub fn stop_when(mut self, stop: impl Fn() -> bool + Send + Sync + 'a) -> Self {
            self.setup.execution.stop = Some(std::sync::Arc::new(stop));
            self
        }

        /// Shows no progress. By default progress appears after a second if standard error is a terminal.
        pub fn quiet(mut self) -> Self {
            self.setup.execution.is_quiet = true;
            self
        }
    };
    (@ instructions) => {
        /// Uses these vector instructions, or the baseline's where the machine does not have them. The
        /// default is the best that the machine has. The result is the same.
        pub fn instructions(mut self, set: crate::algebra::lanes::instructions::InstructionSet) -> Self {
            self.setup.execution.instructions = Some(set);
            self
        }
    };
}
pub(crate) use options;
