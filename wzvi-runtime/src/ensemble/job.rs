//! A checked ensemble: everything that its chunks share.

use std::ops::Range;

use super::chunk;
use super::source::{NoiseSource, NormalSettings};
use super::starts::{self, ByPath, DrawPurpose, STARTS};
use crate::algebra::state::{State, Vector};
use crate::error::ConfigError;
use crate::increments::Interval;
use crate::noise::StepNormals;
use crate::scheme::system::{Discretized, PreparedOf};
use crate::statistics::Statistics;
use crate::trajectory::Error;
use crate::trajectory::options::{Observable, OwnObservable};
use crate::trajectory::recording::RecordedTime;
use crate::trajectory::retry::Retry;
use crate::trajectory::section::Sections;
use crate::trajectory::span::{MOST_STEPS, NodeGrid};

/// A run of paths that are known by their numbers.
pub(super) struct EnsembleJob<'a, H: Discretized<E>, E> {
    pub(super) system: &'a H,
    pub(super) prepared: PreparedOf<H, E>,
    /// What is prepared for a last step that is shorter.
    pub(super) shorter: Option<PreparedOf<H, E>>,
    pub(super) h: f64,
    /// The level of a multilevel run, 0 the coarsest.
    pub(super) level: u32,
    /// The start of all paths, or of path 0.
    pub(super) start: State<H::Vector>,
    /// The starts of all paths, if each has its own.
    pub(super) starts: Option<ByPath<'a, State<H::Vector>>>,
    /// The systems of all paths, if each has its own; else none.
    pub(super) systems: Vec<H>,
    /// Whether any of these go in lanes together: a path takes the same steps whatever is beside it.
    pub(super) all_gather: bool,
    /// The observables that read the system of a path, by number.
    pub(super) own: Vec<(usize, OwnObservable<'a, H, H::Vector>)>,
    /// The observables of the work of a path.
    pub(super) own_work: Option<OwnWork>,
    pub(super) seed: u64,
    pub(super) grid: NodeGrid,
    pub(super) paths: u64,
    pub(super) steps: u64,
    /// The start first, the end last.
    pub(super) recorded: Vec<RecordedTime>,
    pub(super) source: NoiseSource<'a>,
    pub(super) retry: Retry,
    /// Whether a path ends whose energy has changed.
    pub(super) is_watched: bool,
    pub(super) observables: Vec<Observable<'a, H::Vector>>,
    pub(super) events: Vec<Observable<'a, H::Vector>>,
    pub(super) sections: Sections<'a, H::Vector>,
    pub(super) inspector: Option<Inspector<'a, H::Vector>>,
    /// What is to be found out, of no path yet.
    pub(super) empty: Statistics,
    pub(super) stop: Stop<'a>,
}

/// What is observed of the work of each path.
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
    /// Whether [`EnsembleJob::takes_scalar_paths`] may be.
    pub(super) const MAY_TAKE_SCALAR_PATHS: bool = H::PROPERTIES.scalar_paths_from < usize::MAX;

    /// Whether paths go one after the other, because the steps of each are in vector instructions by
    /// themselves. Antithetic paths are drawn in pairs.
    pub(super) fn takes_scalar_paths(&self) -> bool {
        self.start.q.components().len() >= H::PROPERTIES.scalar_paths_from && !self.source.is_antithetic()
    }

    /// The functions whose zeros paths cross: sections, then events.
    pub(super) fn crossed(&self) -> impl Iterator<Item = &Observable<'a, H::Vector>> {
        self.sections.functions().chain(&self.events)
    }

    /// Whether crossings are looked for in each step.
    pub(super) fn looks_inside(&self) -> bool {
        !self.sections.is_empty() || !self.events.is_empty() && !self.has_passages_at_nodes()
    }

    /// Whether first passages are looked for at the nodes alone: those of paths with noise.
    pub(super) fn has_passages_at_nodes(&self) -> bool {
        !self.events.is_empty() && self.processes() > 0
    }

    /// Whether anything is looked for between nodes, in some steps or in each.
    pub(super) fn looks_between(&self) -> bool {
        self.looks_inside() || self.recorded.iter().any(|recorded| recorded.is_inside)
    }

    /// How many numbers drive a step.
    pub(super) fn processes(&self) -> usize {
        self.system.increments(self.start.q.components().len())
    }

    /// The system of a path.
    pub(super) fn system_of(&self, path: u64) -> &H {
        usize::try_from(path).ok().and_then(|path| self.systems.get(path)).unwrap_or(self.system)
    }

    /// The observables of a path in this state, but for its work.
    pub(super) fn observe(&self, path: u64, state: &State<H::Vector>, values: &mut [f64]) {
        for (value, observable) in values.iter_mut().zip(&self.observables) {
            *value = observable(state);
        }
        for (index, observable) in &self.own {
            values[*index] = observable(self.system_of(path), state);
        }
    }

    /// The start of a path.
    ///
    /// # Errors
    /// If it is none.
    pub(super) fn start_of(&self, path: u64) -> Result<State<H::Vector>, ConfigError> {
        let Some(starts) = &self.starts else { return Ok(self.start.clone()) };
        let start = starts.of(DrawPurpose::Start, self.seed, path).ok_or(ConfigError::Missing(STARTS))?;
        starts::check(self.system_of(path), &start, path, (self.start.q.components().len(), self.start.t))?;
        Ok(start)
    }

    /// The same paths on the next level of a multilevel run: in steps half as long, and with normals of their
    /// own.
    ///
    /// # Errors
    /// Where there are more steps than can be counted, and those of a system that cannot be prepared.
    pub(super) fn finer(&self) -> Result<Self, Error> {
        let Self { system, start, level, grid, source, .. } = self;
        let (level, h, steps) = (level + 1, 0.5 * grid.h, 2 * grid.steps);
        if steps > MOST_STEPS {
            return Err(ConfigError::End { start: start.t, end: grid.time(grid.steps), h }.into());
        }
        let first = Interval { start: start.t, h, step: 0 };
        let normals = source.normals.clone().unwrap_or_else(|| StepNormals::seed(0));
        let source = NoiseSource::new(normals.on_level(level));
        Ok(Self {
            system,
            prepared: crate::trajectory::step::prepared(*system, h)?,
            shorter: None,
            h,
            level,
            start: start.clone(),
            starts: None,
            systems: Vec::new(),
            all_gather: true,
            own: Vec::new(),
            own_work: None,
            seed: self.seed,
            grid: NodeGrid::of(start.t, h, steps),
            paths: self.paths,
            steps,
            recorded: self
                .recorded
                .iter()
                .map(|recorded| RecordedTime { node: 2 * recorded.node, ..*recorded })
                .collect(),
            source: source.prepared(NormalSettings::default(), &H::PLAN, first, (self.processes(), steps))?,
            retry: self.retry,
            is_watched: self.is_watched,
            observables: self.observables.clone(),
            events: Vec::new(),
            sections: Sections::default(),
            inspector: None,
            empty: self.empty.clone(),
            stop: self.stop,
        })
    }

    /// Paths in a chunk.
    pub(super) fn chunk(&self) -> u64 {
        if self.takes_scalar_paths() { chunk::SCALAR_PATHS } else { chunk::PATHS_IN_LANES }
    }

    /// The numbers of all chunks.
    pub(super) fn chunks(&self) -> Range<u64> {
        0..self.paths.div_ceil(self.chunk())
    }
}
