//! A checked ensemble: everything that its chunks share.

use std::ops::Range;

use super::chunk;
use super::source::{NoiseSource, NormalSettings};
use super::starts::{self, ByPath, DrawPurpose, STARTS, Systems};
use crate::algebra::state::{State, Vector};
use crate::algebra::state_sum::PlainSum;
use crate::error::{ConfigError, InternalError};
use crate::increments::Interval;
use crate::noise::StepNormals;
use crate::scheme::system::{Discretized, Hamiltonian, PreparedOf};
use crate::statistics::Statistics;
use crate::trajectory::Error;
use crate::trajectory::events::EventRules;
use crate::trajectory::options::{Observable, OwnObservable};
use crate::trajectory::recording::RecordedTime;
use crate::trajectory::retry::Retry;
use crate::trajectory::section::Sections;
use crate::trajectory::span::{MOST_STEPS, NodeGrid, projected};
use crate::trajectory::step::{Stepper, prepared};

/// A run of paths that are known by their numbers.
pub(super) struct EnsembleJob<'a, H: Discretized<E>, E> {
    pub(super) systems: PathSystems<'a, H>,
    pub(super) starts: PathStarts<'a, H::Vector>,
    pub(super) prepared: PreparedSteps<PreparedOf<H, E>>,
    pub(super) grid: NodeGrid,
    pub(super) source: NoiseSource<'a>,
    pub(super) paths: u64,
    /// Paths in a chunk.
    pub(super) chunk: u64,
    /// The level of a multilevel run, 0 the coarsest.
    pub(super) level: u32,
    pub(super) retry: Retry,
    /// Whether a path ends whose energy has changed.
    pub(super) is_watched: bool,
    pub(super) observed: ObservedNodes<'a, H>,
    pub(super) crossed: CrossedFunctions<'a, H::Vector>,
    /// The events that act on paths.
    pub(super) acting: EventRules<'a, H::Vector>,
    pub(super) stop: Stop<'a>,
}

/// The systems of paths.
pub(super) struct PathSystems<'a, H> {
    /// The system of all paths, or the one in the place of which each path has its own.
    pub(super) common: &'a H,
    /// The systems of all paths, if each has its own; else none.
    pub(super) own: Vec<H>,
    /// Whether all of them go in lanes together.
    pub(super) go_in_lanes: bool,
}

impl<H> PathSystems<'_, H> {
    /// Whether each path has its own.
    pub(super) fn are_own(&self) -> bool {
        !self.own.is_empty()
    }

    /// The system of a path.
    pub(super) fn of(&self, path: u64) -> &H {
        usize::try_from(path).ok().and_then(|path| self.own.get(path)).unwrap_or(self.common)
    }

    /// An error of the system of a path.
    pub(super) fn error_of(&self, path: u64, cause: ConfigError) -> ConfigError {
        if self.are_own() { ConfigError::PathSystem { path, cause: Box::new(cause) } } else { cause }
    }
}

/// The starts of paths.
pub(super) struct PathStarts<'a, V> {
    /// The start of all paths, or of path 0.
    pub(super) first: State<V>,
    /// The starts of all paths, if each has its own.
    pub(super) own: Option<ByPath<'a, State<V>>>,
    /// The seed of those that are drawn.
    pub(super) seed: u64,
    /// Whether they are projected on the manifold of the constraints from any distance.
    pub(super) is_projected: bool,
}

/// The constants of the steps of a system.
pub(super) struct PreparedSteps<P> {
    pub(super) whole: P,
    /// The constants of a last step that is shorter.
    pub(super) last: Option<P>,
}

/// The observables and statistics of paths at recorded nodes.
pub(super) struct ObservedNodes<'a, H: Hamiltonian> {
    /// The start first, the end last.
    pub(super) recorded: Vec<RecordedTime>,
    pub(super) observables: Vec<Observable<'a, H::Vector>>,
    /// The observables among them that read the system of a path, by number.
    pub(super) own: Vec<(usize, OwnObservable<'a, H, H::Vector>)>,
    /// The observables of the work of a path.
    pub(super) work: Option<OwnWork>,
    pub(super) inspector: Option<Inspector<'a, H::Vector>>,
    /// The statistics of no path yet.
    pub(super) empty: Statistics,
}

/// The functions of the state whose zeros paths cross.
pub(super) struct CrossedFunctions<'a, V> {
    /// All crossings of these are looked for.
    pub(super) sections: Sections<'a, V>,
    /// The first crossing of each of these is looked for.
    pub(super) events: Vec<Observable<'a, V>>,
}

impl<'a, V> CrossedFunctions<'a, V> {
    /// Whether there are any.
    pub(super) fn has_any(&self) -> bool {
        !self.sections.is_empty() || !self.events.is_empty()
    }

    /// Sections, then events.
    pub(super) fn functions(&self) -> impl Iterator<Item = &Observable<'a, V>> {
        self.sections.functions().chain(&self.events)
    }
}

/// Why the paths of a job do not go in lanes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum NotInLanes {
    /// The steps of a path are in vector instructions by themselves.
    LargeSystem,
    /// The scheme has no steps in lanes ([`Properties::in_lanes`](crate::scheme::system::Properties)).
    Scheme,
    /// The systems of paths differ in more than numbers.
    Systems,
    /// Steps are looked into, and lanes do not keep the polynomial of the scheme.
    DenseOutput,
    /// Work and heat are observed, which a stepper accounts for.
    Work,
}

/// The observed parts of the work of each path.
#[derive(Clone, Debug)]
pub(super) struct OwnWork {
    /// Among the observables.
    pub(super) places: Range<usize>,
    /// Whether `exp(-work/kT)` is the last of them.
    pub(super) has_weight: bool,
}

impl OwnWork {
    /// The names: work, shadow work and heat; the heats of so many degrees of freedom; the weight.
    pub(super) fn names(heats: usize, has_weight: bool) -> Vec<String> {
        let all = ["work", "shadow work", "heat"].map(String::from).into_iter();
        let weight = has_weight.then(|| "exp(-work/kT)".into());
        all.chain((0..heats).map(|i| format!("heat {i}"))).chain(weight).collect()
    }
}

/// Sees paths, by their numbers, at recorded nodes.
pub(super) type Inspector<'a, V> = Box<dyn Fn(u64, &State<V>) + Send + Sync + 'a>;

/// Says when to stop.
pub(super) type Stop<'a> = &'a (dyn Fn() -> bool + Sync);

impl<'a, H: Discretized<E>, E> EnsembleJob<'a, H, E> {
    /// Whether the steps of a system may be in vector instructions by themselves.
    pub(super) const MAY_BE_LARGE: bool = H::PROPERTIES.scalar_paths_from < usize::MAX;

    /// Whether [`EnsembleJob::not_in_lanes`] may have a reason.
    pub(super) const fn may_not_be_in_lanes<P: Systems>() -> bool {
        !H::PROPERTIES.in_lanes
            || Self::MAY_BE_LARGE
            || P::ARE_OWN
            || H::PROPERTIES.has_polynomial
            || Stepper::<H, E, PlainSum>::MAY_EXCHANGE
    }

    /// Why paths do not go in lanes, but each by a stepper; `None` if they go in lanes. All paths of a job go
    /// alike, and so does each of them alone: its bits do not depend on what is beside it.
    pub(super) fn not_in_lanes(&self) -> Option<NotInLanes> {
        let is_large = self.degrees() >= H::PROPERTIES.scalar_paths_from;
        let reasons = [
            // Antithetic paths are drawn in pairs.
            (NotInLanes::LargeSystem, is_large && !self.source.is_antithetic()),
            (NotInLanes::Scheme, !H::PROPERTIES.in_lanes),
            (NotInLanes::Systems, !self.systems.go_in_lanes),
            (NotInLanes::DenseOutput, H::PROPERTIES.has_polynomial && self.looks_between()),
            (NotInLanes::Work, self.observed.work.is_some()),
        ];
        reasons.into_iter().find_map(|(reason, holds)| holds.then_some(reason))
    }

    /// This job, in chunks that suit the size of its system.
    pub(super) fn chunked(self) -> Self {
        let is_large = self.not_in_lanes() == Some(NotInLanes::LargeSystem);
        Self { chunk: if is_large { chunk::PATHS_OF_LARGE_SYSTEMS } else { chunk::PATHS }, ..self }
    }

    /// Whether crossings are looked for in each step.
    pub(super) fn looks_inside(&self) -> bool {
        let CrossedFunctions { sections, events } = &self.crossed;
        !sections.is_empty() || !events.is_empty() && !self.has_passages_at_nodes()
    }

    /// Whether first passages are looked for at the nodes alone: those of paths with noise.
    pub(super) fn has_passages_at_nodes(&self) -> bool {
        !self.crossed.events.is_empty() && self.processes() > 0
    }

    /// Whether anything is looked for between nodes, in some steps or in each.
    pub(super) fn looks_between(&self) -> bool {
        self.looks_inside() || self.observed.recorded.iter().any(|recorded| recorded.is_inside)
    }

    /// The degrees of freedom of a path.
    pub(super) fn degrees(&self) -> usize {
        self.starts.first.q.components().len()
    }

    /// How many numbers drive a step.
    pub(super) fn processes(&self) -> usize {
        self.systems.common.increments(self.degrees())
    }

    /// The constants of steps of this size.
    ///
    /// # Errors
    /// [`InternalError`] for a size that the run does not have.
    pub(super) fn prepared_for(&self, size: f64) -> Result<&PreparedOf<H, E>, InternalError> {
        let PreparedSteps { whole, last } = &self.prepared;
        let of_size = if size == self.grid.h { Some(whole) } else { last.as_ref() };
        of_size.ok_or_else(|| InternalError::new("the steps of a run are prepared", size))
    }

    /// The observables of a path in this state, but for its work.
    pub(super) fn observe(&self, path: u64, state: &State<H::Vector>, values: &mut [f64]) {
        for (value, observable) in values.iter_mut().zip(&self.observed.observables) {
            *value = observable(state);
        }
        for (index, observable) in &self.observed.own {
            values[*index] = observable(self.systems.of(path), state);
        }
    }

    /// The start of a path.
    ///
    /// # Errors
    /// If it is none.
    pub(super) fn start_of(&self, path: u64) -> Result<State<H::Vector>, ConfigError> {
        let PathStarts { first, own, seed, is_projected } = &self.starts;
        let start = match own {
            // The common system has projected it.
            None if self.systems.own.is_empty() => return Ok(first.clone()),
            None => first.clone(),
            Some(own) => own.of(DrawPurpose::Start, *seed, path).ok_or(ConfigError::Missing(STARTS))?,
        };
        let system = self.systems.of(path);
        starts::check(system, &start, path, self.degrees(), first.t)?;
        let projected = projected(system, start, *is_projected);
        projected.map_err(|cause| ConfigError::PathStart { path, cause })
    }

    /// The same paths on the next level of a multilevel run: in steps half as long, and with normals of their
    /// own.
    ///
    /// # Errors
    /// Where there are more steps than can be counted, and those of a system that cannot be prepared.
    pub(super) fn finer(&self) -> Result<Self, Error> {
        let PathStarts { first: start, seed, is_projected, .. } = &self.starts;
        let (level, h, steps) = (self.level + 1, 0.5 * self.grid.h, 2 * self.grid.steps);
        if steps > MOST_STEPS {
            return Err(ConfigError::End { start: start.t, end: self.grid.time(self.grid.steps), h }.into());
        }
        let first = Interval { start: start.t, h, step: 0 };
        let normals = self.source.normals.clone().unwrap_or_else(|| StepNormals::seed(0));
        let source = NoiseSource::new(normals.on_level(level));
        let finer = |recorded: &RecordedTime| RecordedTime { node: 2 * recorded.node, ..*recorded };
        let system = self.systems.common;
        Ok(Self {
            systems: PathSystems { common: system, own: Vec::new(), go_in_lanes: true },
            starts: PathStarts { first: start.clone(), own: None, seed: *seed, is_projected: *is_projected },
            prepared: PreparedSteps { whole: prepared(system, h)?, last: None },
            grid: NodeGrid::of(start.t, h, steps),
            source: source.prepared(NormalSettings::default(), &H::PLAN, first, (self.processes(), steps))?,
            paths: self.paths,
            chunk: self.chunk,
            level,
            retry: self.retry,
            is_watched: self.is_watched,
            observed: ObservedNodes {
                recorded: self.observed.recorded.iter().map(finer).collect(),
                observables: self.observed.observables.clone(),
                own: Vec::new(),
                work: None,
                inspector: None,
                empty: self.observed.empty.clone(),
            },
            crossed: CrossedFunctions { sections: Sections::default(), events: Vec::new() },
            acting: EventRules::default(),
            stop: self.stop,
        })
    }

    /// The numbers of all chunks.
    pub(super) fn chunks(&self) -> Range<u64> {
        0..self.paths.div_ceil(self.chunk)
    }
}
