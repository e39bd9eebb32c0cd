//! Checks the settings of an ensemble and turns them into a run.

use std::sync::Arc;

use super::chunk::PATHS;
use super::job::{
    CrossedFunctions, EnsembleJob, ObservedNodes, OwnWork, PathStarts, PathSystems, PreparedSteps, Stop,
};
use super::source::NoiseSource;
use super::starts::{self, ByPath, DrawPurpose, STARTS, SYSTEMS};
use super::{Ensemble, ExtraStatistics};
use crate::algebra::state::{State, Vector};
use crate::error::{ConfigError, UnknownName, wrong};
use crate::ground::names::free;
use crate::ground::variables::Variables;
use crate::increments::Interval;
use crate::noise::StepNormals;
use crate::scheme::poles;
use crate::scheme::system::{Discretized, Quantity, Scheme as _, SchemeOf, disequilibrium};
use crate::statistics::{
    Crossings, Histogram, Passage, Passages, PathValues, RecordedNodes, Statistics, StatisticsNode,
};
use crate::trajectory::Error;
use crate::trajectory::exclusive_setting::SOME;
use crate::trajectory::options::{Observables, elsewhere};
use crate::trajectory::recording::RecordedTime;
use crate::trajectory::span::{NodeGrid, ONE_START};

/// More recorded nodes than anyone looks at.
const MOST_NODES: u64 = 1 << 20;
/// Statistics of a chunk of paths that take more bytes are refused: some chunks wait for others, on each
/// thread.
const MOST_BYTES: u128 = 1 << 30;
/// Bins of passage times.
const PASSAGE_BINS: usize = 100;

const NO_PATHS: &str = "a number of paths: add `.paths(number)`";
const SEED: &str = "a seed for its noise: add `.seed(number)` or `.noise(...)`";

/// The number of paths: the requested number, or that of listed starts and systems.
///
/// # Errors
/// [`ConfigError::Missing`] and [`ConfigError::Setting`].
pub(super) fn number_of_paths(asked: Option<u64>, listed: [Option<u64>; 2]) -> Result<u64, ConfigError> {
    if let (None, [Some(starts), Some(systems)]) = (asked, listed)
        && starts != systems
    {
        let both = format!("{starts} starts and {systems} systems");
        return wrong(format!(
            "{both}: list as many of both, or say how many paths there are, `.paths(number)`"
        ));
    }
    let paths = asked.or(listed[0]).or(listed[1]).ok_or(ConfigError::Missing(NO_PATHS))?;
    if paths == 0 {
        return wrong("0 paths: take at least 1");
    }
    match listed.map(|number| number.is_some_and(|number| number < paths)) {
        [true, _] => Err(ConfigError::Missing(STARTS)),
        [_, true] => Err(ConfigError::Missing(SYSTEMS)),
        _ => Ok(paths),
    }
}

impl<'a, H: Discretized<E> + Sync, E, N, P> Ensemble<'a, H, E, N, P> {
    /// The run, checked.
    ///
    /// # Errors
    /// [`Error::Config`] or [`Error::Noise`].
    pub(super) fn job<'s>(self, stop: Stop<'s>) -> Result<EnsembleJob<'s, H, E>, Error>
    where
        'a: 's,
    {
        let mut setup = self.setup;
        let (system, h, more) = (setup.system, setup.h, setup.more);
        if !h.is_finite() || h == 0.0 {
            return Err(ConfigError::StepSize(h).into());
        }
        let own_source = more.source.checked("an ensemble has one noise")?;
        let seed = own_source.as_ref().map_or(0, NoiseSource::seed);
        let starts = more.starts.checked(ONE_START)?;
        if let Some(starts) = &starts {
            if setup.span.start.value().is_some() {
                return wrong(
                    "`start(...)` and starts of the paths, `starts(...)` or `starts_from(...)`: leave one of them out",
                );
            }
            let first = starts.of(DrawPurpose::Start, seed, 0).ok_or(ConfigError::Missing(STARTS))?;
            setup.span.start.set("start", SOME, first);
        }
        let own_systems = more.systems.checked("a path has one system")?;
        let is_projected = setup.span.is_projected;
        let (start, grid) = setup.span.checked::<H, E>(system, h)?;
        let steps = grid.steps;
        let listed =
            [starts.as_ref().and_then(ByPath::listed), own_systems.as_ref().and_then(ByPath::listed)];
        let paths = number_of_paths(more.paths, listed)?;
        let systems = match own_systems {
            Some(systems) => systems.into_list(DrawPurpose::System, seed, paths)?,
            None => Vec::new(),
        };
        starts::check_systems::<H, E>(&systems, system, start.q.components().len())?;
        let end = grid.time(steps);
        if !end.is_finite() {
            return Err(ConfigError::End { start: start.t, end, h }.into());
        }
        let processes = system.increments(start.q.components().len());
        let source = match own_source {
            None if processes > 0 => return Err(ConfigError::Missing(SEED).into()),
            Some(source) if processes > 0 => source,
            _ => NoiseSource::new(StepNormals::seed(0)),
        };
        let first = Interval { start: start.t, h, step: 0 };
        let source = source.prepared(more.settings, &H::PLAN, first, (processes, grid.whole()))?;
        if processes > 0 {
            let bound = |h| source.largest_increment(h);
            if systems.is_empty() {
                poles::check::<H, E>(system, &start, h, &bound)?;
            }
            for (path, own) in (0..).zip(&systems) {
                poles::check::<H, E>(own, &start, h, &bound)
                    .map_err(|cause| ConfigError::PathSystem { path, cause: Box::new(cause) })?;
            }
        }
        let has_pairs = source.is_antithetic();
        if has_pairs && paths % 2 == 1 {
            return wrong(format!("{paths} antithetic paths: they come in pairs"));
        }
        let is_by_runs = H::PROPERTIES.is_clocked || !setup.events.is_empty();
        if is_by_runs {
            let refused = [
                (setup.retry.most() > 0, "`retry`"),
                (!more.events.is_empty(), "`first_passage`"),
                (more.wanted.has_work, "`observe_work`"),
                (has_pairs, "antithetic paths"),
            ];
            if let Some(what) = first_of(&refused) {
                return wrong(format!(
                    "{what} of paths by a clock, or with events: leave it out; `on(value, |_| Terminal)` ends a path at its first passage"
                ));
            }
        }
        if H::PROPERTIES.is_clocked && grid.end.is_none() {
            return wrong(
                "`steps` of paths by clocks, which have no common times then: give them an end, `.until(time)`",
            );
        }
        if H::PROPERTIES.is_clocked && setup.recorded.every.is_some() {
            return wrong(
                "`record_every` of paths by clocks, which have no common nodes: record them at times, `.record_at(times)`",
            );
        }
        let recorded = setup.recorded.checked(0, &grid)?;
        let recorded = recorded.all(&grid, MOST_NODES)?;
        let (mut observables, mut own) = (setup.observables, more.own);
        if observables.is_empty() {
            observables = coordinates(start.q.components().len(), &system.variables());
            let mut known = Vec::new();
            for (name, _) in &observables.0 {
                known.push(name.as_str());
            }
            let mut named = vec![(free("energy", known.into_iter()), Quantity::Energy)];
            for i in 0..system.observables() {
                named.push((system.variables().observable(i), Quantity::Observable(i)));
            }
            for (name, quantity) in named {
                let value = move |system: &H, state: &State<H::Vector>| quantity.value(system, state);
                own.push((observables.len(), Arc::new(value)));
                observables.push(name, elsewhere);
            }
        }
        let mut work = None;
        if more.wanted.has_work {
            let (has_weight, first) = (more.wanted.has_weight, observables.len());
            let is_between = has_inside(&recorded);
            check_work::<H, E>(setup.retry.most() > 0 || is_between)?;
            if has_weight {
                let common = systems.is_empty().then_some(system);
                systems.iter().chain(common).try_for_each(check_weight::<H, E>)?;
            }
            let heats = if H::PROPERTIES.has_temperatures { start.q.components().len() } else { 0 };
            for name in OwnWork::names(heats, has_weight) {
                observables.push(name, elsewhere);
            }
            work = Some(OwnWork { places: first..observables.len(), has_weight });
        }
        let (names, observables) = observables.checked("observables")?;
        let (event_names, events) = more.events.checked("events")?;
        let of_pairs = [(!events.is_empty(), "first passages"), (!setup.sections.is_empty(), "sections")];
        if has_pairs && let Some(what) = first_of(&of_pairs) {
            return wrong(format!(
                "{what} of antithetic paths: their errors would be those of independent ones; leave out one of the two"
            ));
        }
        if more.wanted.most_crossings > 0 && setup.sections.is_empty() {
            return Err(
                ConfigError::Missing("a section for `keep_crossings`: add `.section(function)`").into()
            );
        }
        let times = times(&recorded);
        let passages = passages(event_names, &grid, more.wanted.most_bytes.is_some())?;
        let crossings = Crossings::new(start.q.components().len(), more.wanted.most_crossings);
        let crossings = vec![crossings; setup.sections.len()];
        let empty = more.wanted.checked(names, &times, (passages, crossings), has_pairs, paths)?;
        grid.check_parts(&mut *source.path(0), processes, setup.retry)?;
        let job = EnsembleJob {
            prepared: PreparedSteps {
                whole: crate::trajectory::step::prepared(system, h)?,
                last: match grid.shorter {
                    Some(h) => Some(crate::trajectory::step::prepared(system, h)?),
                    None => None,
                },
            },
            systems: PathSystems {
                common: system,
                go_in_lanes: go_in_lanes::<H, E>(&systems, &grid),
                own: systems,
            },
            starts: PathStarts { first: start, own: starts, seed, is_projected },
            grid,
            source,
            paths,
            chunk: PATHS,
            level: 0,
            retry: setup.retry,
            is_watched: setup.is_watched,
            observed: ObservedNodes { recorded, observables, own, work, inspector: more.inspector, empty },
            crossed: CrossedFunctions { sections: setup.sections, events },
            acting: setup.events,
            stop,
        };
        Ok(job.chunked())
    }
}

/// Whether each system goes in lanes with the first one, in steps of every size of the run. A system that
/// cannot be prepared is an error of its path.
fn go_in_lanes<H: Discretized<E>, E>(systems: &[H], grid: &NodeGrid) -> bool {
    for (_, size) in grid.from(0) {
        let mut first = None;
        for system in systems {
            let Ok(other) = crate::trajectory::step::prepared(system, size) else { continue };
            // The first with itself, too: some go in no lanes at all.
            if SchemeOf::<H, E>::gather([first.as_ref().unwrap_or(&other), &other]).is_none() {
                return false;
            }
            if first.is_none() {
                first = Some(other);
            }
        }
    }
    true
}

/// The name of the first of these properties that is there.
fn first_of<'w>(properties: &[(bool, &'w str)]) -> Option<&'w str> {
    properties.iter().find_map(|(is_there, what)| is_there.then_some(*what))
}

fn times(recorded: &[RecordedTime]) -> Vec<f64> {
    recorded.iter().map(|recorded| recorded.t).collect()
}

fn has_inside(recorded: &[RecordedTime]) -> bool {
    recorded.iter().any(|recorded| recorded.is_inside)
}

/// Whether there is work to observe, in a run that may halve its steps or look between its nodes.
fn check_work<H: Discretized<E>, E>(is_uneven: bool) -> Result<(), ConfigError> {
    wrong(if !(H::KIND.is_forced || H::KIND.is_conformal || H::PROPERTIES.exchanges) {
        "work of paths that have no bath, force or friction: observe the energy"
    } else if is_uneven {
        "work of paths whose steps are halved, or that are recorded between nodes: leave `retry` and such times out, or run single paths"
    } else {
        return Ok(());
    })
}

/// Whether Jarzynski's equality holds for the work on paths of this system.
fn check_weight<H: Discretized<E>, E>(system: &H) -> Result<(), ConfigError> {
    let refused = |why, instead| Err(ConfigError::NoEquilibrium { asked: "observe_jarzynski", why, instead });
    match (SchemeOf::<H, E>::temperature(system), disequilibrium(&H::PLAN, &H::PROPERTIES)) {
        (Some(kt), _) if kt > 0.0 => Ok(()),
        (Some(_), _) => refused("its temperature is 0", "`observe_work` has the work and the heat"),
        (None, Some(why)) => refused(why, "`observe_work` has the work and the heat of each bath"),
        (None, None) => {
            refused("the system has no temperature", "add `friction = ...` and `temperature = ...`")
        }
    }
}

impl ExtraStatistics {
    fn checked(
        self,
        names: Vec<String>,
        times: &[f64],
        (passages, crossings): (Vec<Passages>, Vec<Crossings>),
        has_pairs: bool,
        paths: u64,
    ) -> Result<Statistics, ConfigError> {
        let histogram = |(name, [lower, upper], bins): (String, [f64; 2], usize)| {
            Ok((observable(&name, &names)?, Histogram::new(lower, upper, bins)?))
        };
        let histograms =
            self.histograms.into_iter().map(histogram).collect::<Result<Vec<_>, ConfigError>>()?;
        let (histogrammed, histograms): (Vec<usize>, Vec<Histogram>) = histograms.into_iter().unzip();
        let bytes = PathValues::bytes(paths, times.len(), names.len())
            + u128::from(paths) * (passages.len() * size_of::<Passage>()) as u128;
        if let Some(most) = self.most_bytes
            && bytes > u128::from(most)
        {
            return wrong(format!(
                "the paths take {bytes} bytes to keep, more than the {most} that are allowed: record fewer times, or fewer paths"
            ));
        }
        let (observables, has_covariances) = (names.len(), self.covariances.unwrap_or(true));
        let bytes =
            StatisticsNode::bytes(observables, has_covariances, (has_pairs, self.quantiles), &histograms);
        let bytes = times.len() as u128 * bytes;
        if bytes > MOST_BYTES {
            return wrong(format!(
                "the statistics take {bytes} bytes for each chunk of paths, and {MOST_BYTES} are the most: leave covariances out with \
                 `.covariances(false)`, or record fewer times, observables or bins"
            ));
        }
        let node = StatisticsNode::new(observables, has_covariances, (has_pairs, self.quantiles), histograms);
        let kept = self.most_bytes.map(|_| PathValues::new(times.len(), observables));
        let nodes = RecordedNodes::new(times, &node, histogrammed);
        Ok(Statistics::new(names, nodes).with(passages, crossings, kept, self.added))
    }
}

/// The passages of events, each with a histogram over the whole time.
fn passages(names: Vec<String>, grid: &NodeGrid, are_kept: bool) -> Result<Vec<Passages>, ConfigError> {
    if names.is_empty() {
        return Ok(Vec::new());
    }
    let (NodeGrid { start, h, steps, .. }, end) = (*grid, grid.time(grid.steps));
    // Without a step there is no time to count.
    let [lower, upper] = if steps == 0 { [start, start + h.abs()] } else { [start.min(end), start.max(end)] };
    let bins = Histogram::new(lower, upper, PASSAGE_BINS)?;
    Ok(names.into_iter().map(|name| Passages::new(name, [start, end], bins.clone(), are_kept)).collect())
}

/// The number of the observable with this name.
pub(super) fn observable(name: &str, names: &[String]) -> Result<usize, ConfigError> {
    UnknownName::find("observable", name, names.iter().zip(0..)).or_else(|unknown| wrong(unknown.to_string()))
}

/// Coordinates and momenta by the names of the drift's closure. If nothing is asked for, they are observed
/// beside the energy and the declared observables.
fn coordinates<'a, V: Vector>(degrees: usize, variables: &Variables) -> Observables<'a, V> {
    let component = |i: usize| move |vector: &V| vector.components().get(i).copied().unwrap_or(f64::NAN);
    let mut all = Observables::default();
    for i in 0..degrees {
        let q = component(i);
        all.push(variables.q.name(i), move |state| q(&state.q));
    }
    for i in 0..degrees {
        let p = component(i);
        all.push(variables.p.name(i), move |state| p(&state.p));
    }
    all
}
