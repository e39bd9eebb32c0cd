//! Many paths, for their statistics.

use wzvi::Error;
use wzvi::ensemble::{Ensemble, Passage, Passages, PathFailure, Statistics, StatisticsNode, Systems};
use wzvi::exported::Exported;
use wzvi::handle::Handle;
use wzvi::state::{State, Vector};
use wzvi::system::{Discretized, Quantity};

use crate::error::TaskError;
use crate::library::Outcome;
use crate::noise::NamedNoise;
use crate::path::{common, step_size};
use crate::quantities::{section, sign, starts, value_of};
use crate::results::Results;
use crate::settings::{RealArray, Row, Settings};

/// Settings of an ensemble beside the common ones.
pub const SETTINGS: &[&str] = &[
    "record_every",
    "record_at",
    "observe",
    "sections",
    "paths",
    "sweep",
    "quantiles",
    "covariances",
    "histograms",
    "ranges",
    "passages",
    "keep_paths",
    "keep_crossings",
    "until_error",
    "errors",
    "allow_losses",
    "antithetic",
    "retry",
    "observe_work",
    "observe_temperatures",
];

/// An ensemble with the settings that a map of indicators has, too, and its number of degrees of freedom.
///
/// # Errors
/// For a setting that is missing or invalid.
pub fn begin<'a, H, E>(
    settings: &Settings,
    system: &'a H,
    handle: &Handle,
) -> Result<(Ensemble<'a, H, E, NamedNoise>, usize), TaskError>
where
    H: Exported + Discretized<E> + Send + Sync,
{
    let starts = starts(settings, system)?;
    let degrees = starts.first().map_or(0, |start| start.q.components().len());
    let noise = NamedNoise::of(settings, system.increments(degrees))?;
    let run = Ensemble::<H, E>::new(system, step_size::<H, E>(settings)?);
    let mut run = run.noise(noise).quiet().handle(handle);
    common!(run, settings);
    run = match &starts[..] {
        [start] => run.start(start.clone()),
        _ => run.starts_from(starts),
    };
    if let Some(paths) = settings.natural("paths")? {
        run = run.paths(paths);
    }
    if let Some(fraction) = settings.real("allow_losses")? {
        run = run.allow_losses(fraction);
    }
    Ok((run, degrees))
}

/// Runs an ensemble.
///
/// # Errors
/// For a setting that is missing or invalid, and if all paths fail; a run that was stopped, or lost more paths
/// than it allows, has results and an error.
pub fn ensemble<H, E>(settings: &Settings, handle: &Handle) -> Result<Outcome, TaskError>
where
    H: Exported + Discretized<E> + Send + Sync,
{
    let sweep = settings.count("sweep")?;
    let system = match sweep {
        Some(_) => H::from_fields(&Row { settings, index: 0 })?,
        None => H::from_fields(settings)?,
    };
    let (mut run, degrees) = begin::<H, E>(settings, &system, handle)?;
    for name in settings.lines("observe")? {
        run = run.observe_quantity(name, Quantity::named(&system, degrees, name)?);
    }
    for name in settings.lines("sections")? {
        let section = section(&system, degrees, name)?;
        let value = crossed(&system, section.quantity, sweep, name)?;
        run = match section.direction {
            Some(direction) => run.section_towards(direction, value),
            None => run.section(value),
        };
    }
    for name in settings.lines("passages")? {
        run =
            run.first_passage(name, crossed(&system, Quantity::named(&system, degrees, name)?, sweep, name)?);
    }
    run = run.covariances(settings.flag("covariances")?);
    let levels = settings.reals("quantiles")?.map_or_else(Vec::new, |levels| levels.values);
    if !levels.is_empty() {
        run = run.quantiles();
    }
    for (name, range) in named_rows(settings, "histograms", "ranges", 3)? {
        let [lower, upper, bins] = range[..] else { continue };
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked to be a count")]
        match bins {
            count if (1.0..=1e9).contains(&count) && count.fract() == 0.0 => {
                run = run.histogram(name, lower, upper, count as usize);
            }
            _ => {
                return Err(TaskError::setting(format!(
                    "the histogram of `{name}` has {bins} bins: give a number of 1 or more"
                )));
            }
        }
    }
    for (name, target) in named_rows(settings, "until_error", "errors", 1)? {
        run = target.iter().fold(run, |run, target| run.until_error(name, *target));
    }
    if let Some(bytes) = settings.natural("keep_paths")? {
        run = run.keep_paths(bytes);
    }
    if let Some(most) = settings.natural("keep_crossings")? {
        run = run.keep_crossings(most);
    }
    if settings.flag("observe_work")? {
        run = run.observe_work();
    }
    if settings.flag("observe_temperatures")? {
        run = run.observe_temperatures();
    }
    match sweep {
        None => finish(run, settings, &levels, degrees),
        #[cfg(feature = "sweep")]
        Some(rows) => {
            let systems = (0..rows).map(|index| H::from_fields(&Row { settings, index }));
            let systems = systems.collect::<Result<Vec<_>, _>>()?;
            finish(run.systems_from(systems), settings, &levels, degrees)
        }
        #[cfg(not(feature = "sweep"))]
        Some(_) => Err(TaskError::setting("this library was not compiled for sweeps over parameters")),
    }
}

/// Runs the ensemble, and collects its arrays.
fn finish<H, E, P>(
    run: Ensemble<'_, H, E, NamedNoise, P>,
    settings: &Settings,
    levels: &[f64],
    degrees: usize,
) -> Result<Outcome, TaskError>
where
    H: Exported + Discretized<E> + Send + Sync,
    P: Systems,
{
    let (statistics, error) = match run.run() {
        Ok(statistics) => {
            let error = statistics.is_partial().then(TaskError::stopped);
            (statistics, error)
        }
        Err(Error::Losses(lost)) => ((*lost.statistics).clone(), Some(TaskError::from(Error::Losses(lost)))),
        Err(error) => return Err(error.into()),
    };
    Ok(Outcome { results: arrays(&statistics, settings, levels, degrees)?, error })
}

/// A quantity whose zeros are looked for. It is one of all systems of a sweep.
fn crossed<'a, H: Exported + Sync>(
    system: &'a H,
    quantity: Quantity,
    sweep: Option<usize>,
    name: &str,
) -> Result<impl Fn(&State<H::Vector>) -> f64 + Send + Sync + use<'a, H>, TaskError> {
    let is_of_all = matches!(quantity, Quantity::Time | Quantity::Coordinate(_) | Quantity::Momentum(_));
    if sweep.is_some() && !is_of_all {
        return Err(TaskError::setting(format!(
            "a section of a sweep is on a coordinate, a momentum or the time, which `{name}` is not: run an ensemble for each system"
        )));
    }
    Ok(value_of(system, quantity))
}

/// Names, one in a line of a text, each with a row of numbers of so many columns.
fn named_rows<'s>(
    settings: &'s Settings,
    names: &str,
    numbers: &str,
    columns: usize,
) -> Result<Vec<(&'s str, Vec<f64>)>, TaskError> {
    let lines = settings.lines(names)?;
    let rows = settings.reals(numbers)?.map_or_else(Vec::new, |RealArray { values, .. }| values);
    if rows.len() != lines.len() * columns {
        return Err(TaskError::setting(format!(
            "`{numbers}` has {} numbers: it needs {columns} for each of the {} names in `{names}`",
            rows.len(),
            lines.len()
        )));
    }
    Ok(lines.into_iter().zip(rows.chunks_exact(columns).map(<[f64]>::to_vec)).collect())
}

/// A number of an observable at a recorded time.
type OfObservable = fn(&StatisticsNode, usize) -> f64;

/// The arrays of the statistics.
fn arrays(
    statistics: &Statistics,
    settings: &Settings,
    levels: &[f64],
    degrees: usize,
) -> Result<Results, TaskError> {
    let (nodes, names) = (statistics.nodes(), statistics.observables());
    let (rows, columns) = (nodes.len(), names.len());
    let mut results = Results { columns: names.to_vec(), ..Results::default() };
    results.add_list("t", nodes.iter().map(StatisticsNode::time));
    results.add_list("count", nodes.iter().map(|node| node.count() as f64));
    results.add_list("lost", nodes.iter().map(|node| node.lost() as f64));
    let moments: [(&str, OfObservable); 4] = [
        ("mean", StatisticsNode::mean),
        ("error", StatisticsNode::standard_error),
        ("error_bound", StatisticsNode::error_bound),
        ("variance", StatisticsNode::variance),
    ];
    for (name, value) in moments {
        let values = nodes.iter().flat_map(|node| (0..columns).map(move |column| value(node, column)));
        results.add(name, values.collect(), &[rows, columns]);
    }
    if settings.flag("covariances")? {
        let pairs = (0..columns).flat_map(|a| (0..columns).map(move |b| (a, b))).collect::<Vec<_>>();
        let values = nodes.iter().flat_map(|node| pairs.iter().map(|&(a, b)| node.covariance(a, b)));
        results.add("covariance", values.collect(), &[rows, columns, columns]);
    }
    if !levels.is_empty() {
        let of = |node: &StatisticsNode, column: usize, level: f64| {
            node.quantiles(column).map_or(f64::NAN, |quantiles| quantiles.at(level))
        };
        let values = nodes.iter().flat_map(|node| {
            (0..columns).flat_map(move |column| levels.iter().map(move |&level| of(node, column, level)))
        });
        results.add("quantiles", values.collect(), &[rows, columns, levels.len()]);
        results.add_list("levels", levels.iter().copied());
    }
    for (position, name) in
        statistics.histogrammed().iter().filter_map(|&column| names.get(column)).enumerate()
    {
        let histograms: Vec<_> = nodes.iter().filter_map(|node| node.histograms().get(position)).collect();
        let Some(first) = histograms.first() else { continue };
        let bins = first.counts().len();
        let counts = histograms.iter().flat_map(|histogram| histogram.counts()).map(|&count| count as f64);
        results.add(format!("histogram.{name}"), counts.collect(), &[histograms.len(), bins]);
        results.add_list(format!("edges.{name}"), (0..=bins).map(|bin| first.edge(bin)));
    }
    statistics.passages().iter().for_each(|passages| add_passages(&mut results, passages));
    add_crossings(&mut results, statistics, degrees);
    if let Some(paths) = statistics.paths() {
        let all = (0..paths.count()).flat_map(|path| (0..rows).filter_map(move |node| paths.at(path, node)));
        results.add("paths", all.flatten().copied().collect(), &[paths.count(), rows, columns]);
    }
    results.add_number("failed", statistics.failed() as f64);
    add_failures(&mut results, statistics.failures());
    Ok(results)
}

/// Path, step and time of each failure.
pub(crate) fn add_failures(results: &mut Results, failures: &[PathFailure]) {
    let row = |failure: &PathFailure| [failure.path as f64, failure.error.step as f64, failure.error.t];
    results.add("failures", failures.iter().flat_map(row).collect(), &[failures.len(), 3]);
}

/// Passed, censored and lost paths, mean and standard error of the times, rate and its error; and the time of
/// each path, infinite for one that reached the end, NaN for one that failed.
fn add_passages(results: &mut Results, passages: &Passages) {
    let name = passages.name();
    let [passed, censored, lost] =
        [passages.passed(), passages.censored(), passages.lost()].map(|count| count as f64);
    let times = [passages.mean(), passages.standard_error(), passages.rate(), passages.rate_error()];
    results.add_list(format!("passage.{name}"), [passed, censored, lost].into_iter().chain(times));
    if let Some(all) = passages.by_path() {
        let time = |passage: &Passage| match passage {
            Passage::At(time) => *time,
            Passage::Censored => f64::INFINITY,
            Passage::Lost(_) => f64::NAN,
        };
        results.add_list(format!("passage_times.{name}"), all.iter().map(time));
    }
}

/// The number of crossings of each section by a path with its standard error, and the crossings that were kept.
fn add_crossings(results: &mut Results, statistics: &Statistics, degrees: usize) {
    let sections = statistics.crossings();
    if sections.is_empty() {
        return;
    }
    results.add_list("crossings.mean", sections.iter().map(|crossings| crossings.mean()));
    results.add_list("crossings.error", sections.iter().map(|crossings| crossings.standard_error()));
    let kept: Vec<_> = (0_u32..)
        .zip(sections)
        .flat_map(|(section, crossings)| crossings.iter().map(move |crossing| (section, crossing)))
        .collect();
    results.add_list("crossings.section", kept.iter().map(|(section, _)| f64::from(*section)));
    results.add_list("crossings.path", kept.iter().map(|(_, crossing)| crossing.path as f64));
    results.add_list("crossings.direction", kept.iter().map(|(_, crossing)| sign(crossing.direction)));
    results.add_list("crossings.t", kept.iter().map(|(_, crossing)| crossing.t));
    let q = kept.iter().flat_map(|(_, crossing)| crossing.q).copied().collect();
    results.add("crossings.q", q, &[kept.len(), degrees]);
    let p = kept.iter().flat_map(|(_, crossing)| crossing.p).copied().collect();
    results.add("crossings.p", p, &[kept.len(), degrees]);
}
