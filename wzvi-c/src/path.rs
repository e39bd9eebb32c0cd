//! One path, and the settings that all runs of a path have.

use wzvi::events::Terminal;
use wzvi::exported::Exported;
use wzvi::handle::Handle;
use wzvi::simulate::Simulation;
use wzvi::state::{State, Vector};
use wzvi::system::{Discretized, Quantity};
use wzvi::trajectory::Trajectory;

use crate::error::TaskError;
use crate::library::Outcome;
use crate::noise::NamedNoise;
use crate::quantities::{section, sign, starts, value_of, variable_names};
use crate::results::Results;
use crate::settings::Settings;

/// Settings of a path beside the common ones.
pub const SETTINGS: &[&str] =
    &["path", "record_every", "record_at", "observe", "sections", "end_at", "retry", "multipliers"];

/// The settings that builders of paths and of ensembles have in common.
macro_rules! common {
    ($run:ident, $settings:ident) => {
        if let Some(end) = $settings.real("until")? {
            $run = $run.until(end);
        }
        if let Some(steps) = $settings.natural("steps")? {
            $run = $run.steps(steps);
        }
        if $settings.flag("whole_steps")? {
            $run = $run.whole_steps();
        }
        if $settings.flag("project_start")? {
            $run = $run.project_start();
        }
        if let Some(threads) = $settings.count("threads")? {
            $run = $run.threads(threads);
        }
        if let Some(stride) = $settings.natural("record_every")? {
            $run = $run.record_every(stride);
        }
        if let Some(times) = $settings.reals("record_at")? {
            $run = $run.record_at(times.values);
        }
        if let Some(halvings) = $settings.count("retry")? {
            $run = $run.retry(wzvi::retry::Retry::halving(u32::try_from(halvings).unwrap_or(u32::MAX)));
        }
        if $settings.flag("unwatched")? {
            $run = $run.unwatched();
        }
    };
}
pub(crate) use common;

/// The size of the steps: `h`, a time, or `eps` of a scheme with a clock, a fraction.
///
/// # Errors
/// If it is missing, or the other one is given.
pub fn step_size<H: Discretized<E>, E>(settings: &Settings) -> Result<f64, TaskError> {
    let (name, other) = if H::PROPERTIES.is_clocked { ("eps", "h") } else { ("h", "eps") };
    if settings.has(other) {
        return Err(TaskError::setting(if H::PROPERTIES.is_clocked {
            "the scheme has a clock: set `eps`, a fraction such as 0.3, in place of `h`"
        } else {
            "the scheme has no clock: set `h`, a time, in place of `eps`"
        }));
    }
    let size = settings.real(name)?;
    size.ok_or_else(|| TaskError::setting(format!("the size of the steps is missing: set `{name}`")))
}

/// The start of a run of one path.
///
/// # Errors
/// If there are none or several.
pub fn start<H: Exported>(settings: &Settings, system: &H) -> Result<State<H::Vector>, TaskError> {
    let mut starts = starts(settings, system)?;
    match (starts.len(), starts.pop()) {
        (1, Some(start)) => Ok(start),
        (count, _) => Err(TaskError::setting(format!("a path has one start, and `q` and `p` have {count}"))),
    }
}

/// A run of one path with the settings that all of them have, and its number of degrees of freedom.
///
/// # Errors
/// For a setting that is missing or invalid.
pub fn begin<'a, H, E>(
    settings: &Settings,
    system: &'a H,
    handle: &Handle,
) -> Result<(Simulation<'a, H, E, NamedNoise>, usize), TaskError>
where
    H: Exported + Discretized<E>,
{
    let start = start(settings, system)?;
    let degrees = start.q.components().len();
    let noise = NamedNoise::of(settings, system.increments(degrees))?;
    let run = Simulation::<H, E>::new(system, step_size::<H, E>(settings)?);
    let mut run = run.start(start).noise(noise).quiet().handle(handle);
    common!(run, settings);
    Ok((run, degrees))
}

/// Runs a path.
///
/// # Errors
/// For a setting that is missing or invalid; a path that ends early has results and an error.
pub fn path<H, E>(settings: &Settings, handle: &Handle) -> Result<Outcome, TaskError>
where
    H: Exported + Discretized<E> + Sync,
{
    let system = H::from_fields(settings)?;
    let (mut run, degrees) = begin::<H, E>(settings, &system, handle)?;
    let observed = settings.lines("observe")?;
    for name in &observed {
        run = run.observe_quantity(*name, Quantity::named(&system, degrees, name)?);
    }
    for name in settings.lines("sections")? {
        let section = section(&system, degrees, name)?;
        let value = value_of(&system, section.quantity);
        run = match section.direction {
            Some(direction) => run.section_towards(direction, value),
            None => run.section(value),
        };
    }
    for name in settings.lines("end_at")? {
        let section = section(&system, degrees, name)?;
        let value = value_of(&system, section.quantity);
        run = match section.direction {
            Some(direction) => run.on_towards(direction, value, |_| Terminal),
            None => run.on(value, |_| Terminal),
        };
    }
    let (path, error) = run.run_partial()?;
    let results = arrays(&path, &system, &observed, settings)?;
    Ok(Outcome { results, error: error.map(TaskError::from) })
}

/// The arrays of a path.
fn arrays<H, E>(
    path: &Trajectory<H::Vector, E>,
    system: &H,
    observed: &[&str],
    settings: &Settings,
) -> Result<Results, TaskError>
where
    H: Exported + Discretized<E>,
{
    let (states, processes) = (path.states(), path.processes());
    let nodes = states.len();
    let degrees = path.last().q.components().len();
    let mut results = Results { columns: variable_names(system, degrees), ..Results::default() };
    add_states(&mut results, "", states.iter());
    results.add_list("energy", states.iter().map(|state| system.energy(state)));
    let variables = system.variables();
    for index in 0..system.invariants() {
        let name = format!("invariant.{}", variables.invariant(index));
        results.add_list(name, states.iter().map(|state| system.invariant(index, state)));
    }
    for name in observed {
        results.add_list(format!("observed.{name}"), path.observed(name)?.iter().copied());
    }
    if processes > 0 {
        let increments = path.increments().flatten().copied().collect();
        results.add("dw", increments, &[nodes.saturating_sub(1), processes]);
    }
    if settings.flag("multipliers")? {
        let rows: Vec<_> = states.iter().map(|state| system.multipliers(state).unwrap_or_default()).collect();
        let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
        let filled =
            rows.iter().flat_map(|row| (0..columns).map(|k| row.get(k).copied().unwrap_or(f64::NAN)));
        results.add("multipliers", filled.collect(), &[nodes, columns]);
    }
    if settings.has("sections") {
        let crossings = path.crossings();
        results.add_list("crossings.section", crossings.iter().map(|crossing| crossing.section as f64));
        results.add_list("crossings.direction", crossings.iter().map(|crossing| sign(crossing.direction)));
        add_states(&mut results, "crossings.", crossings.iter().map(|crossing| &crossing.state));
    }
    if settings.has("end_at") {
        let events = path.events();
        results.add_list("events.event", events.iter().map(|event| event.event as f64));
        add_states(&mut results, "events.", events.iter().map(|event| &event.after));
    }
    if H::PROPERTIES.is_clocked {
        let intervals = path.intervals();
        results.add_list("intervals.t", intervals.iter().map(|interval| interval.t));
        results.add_list("intervals.h", intervals.iter().map(|interval| interval.h));
        results.add_list("intervals.rho", intervals.iter().map(|interval| interval.rho.unwrap_or(f64::NAN)));
    }
    let iterations = path.iterations();
    results.add_number("steps", path.steps() as f64);
    results.add_number("iterations", iterations.total as f64);
    results.add_number("work", path.work());
    results.add_number("heat", path.heat());
    Ok(results)
}

/// Adds times, coordinates and momenta of states, under names with this prefix.
pub(crate) fn add_states<'s, V: Vector + 's>(
    results: &mut Results,
    prefix: &str,
    states: impl Iterator<Item = &'s State<V>> + Clone,
) {
    let count = states.clone().count();
    let degrees = states.clone().next().map_or(0, |state| state.q.components().len());
    results.add_list(format!("{prefix}t"), states.clone().map(|state| state.t));
    let of =
        |part: fn(&State<V>) -> &V| states.clone().flat_map(move |state| part(state).components()).copied();
    results.add(format!("{prefix}q"), of(|state| &state.q).collect(), &[count, degrees]);
    results.add(format!("{prefix}p"), of(|state| &state.p).collect(), &[count, degrees]);
}
