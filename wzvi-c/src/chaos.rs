//! Indicators of chaos, Lyapunov exponents, and derivatives of the end of a path.

use wzvi::chaos::Deviations;
use wzvi::exported::Exported;
use wzvi::handle::Handle;
use wzvi::system::Discretized;

use crate::error::TaskError;
use crate::library::Outcome;
use crate::noise::NamedNoise;
use crate::path::{add_states, begin};
use crate::quantities::variable_names;
use crate::results::Results;
use crate::settings::Settings;

/// Settings of indicators along a path beside the common ones.
pub const INDICATORS: &[&str] = &["path", "record_every", "deviations"];

/// Settings of Lyapunov exponents beside the common ones.
pub const LYAPUNOV: &[&str] = &["path", "record_every", "deviations", "copies", "exponents"];

/// Settings of a map of indicators beside the common ones.
pub const MAP: &[&str] = &["paths", "deviations", "allow_losses"];

/// Settings of derivatives beside the common ones.
pub const TANGENT: &[&str] = &["path", "by"];

/// A run with its deviations. Copies have a use for exponents alone.
fn deviations<'a, H, E>(
    settings: &Settings,
    system: &'a H,
    handle: &Handle,
) -> Result<Deviations<'a, H, E, NamedNoise>, TaskError>
where
    H: Exported + Discretized<E>,
{
    let (run, _) = begin::<H, E>(settings, system, handle)?;
    let copies = settings.natural("copies")?.unwrap_or(8);
    let copies =
        u32::try_from(copies).map_err(|_| TaskError::setting(format!("`copies` is {copies}: take fewer")))?;
    let run = run.copies(copies);
    Ok(match settings.reals("deviations")? {
        Some(given) => run.deviations(given.rows()),
        None => run,
    })
}

/// Indicators of chaos along a path: `megno`, `megno_mean`, `sali`, `gali` from `GALI_2` on, `fli`, `time`;
/// with `record_every` the `series` of each.
///
/// # Errors
/// For a setting that is missing or invalid, and if a step fails.
pub fn indicators<H, E>(settings: &Settings, handle: &Handle) -> Result<Outcome, TaskError>
where
    H: Exported + Discretized<E>,
{
    let system = H::from_fields(settings)?;
    let found = deviations::<H, E>(settings, &system, handle)?.indicators()?;
    let mut results = Results::default();
    let numbers = [
        ("megno", found.megno),
        ("megno_mean", found.megno_mean),
        ("sali", found.sali),
        ("fli", found.fli),
        ("time", found.time),
    ];
    numbers.into_iter().for_each(|(name, value)| results.add_number(name, value));
    results.add_list("gali", found.gali);
    if let Some(series) = found.series {
        let (nodes, volumes) = (series.times.len(), series.gali.first().map_or(0, Vec::len));
        results.add_list("series.t", series.times);
        results.add_list("series.megno", series.megno);
        results.add_list("series.megno_mean", series.megno_mean);
        results.add_list("series.sali", series.sali);
        results.add_list("series.fli", series.fli);
        results.add("series.gali", series.gali.concat(), &[nodes, volumes]);
    }
    Ok(Outcome { results, error: None })
}

/// Lyapunov exponents: `exponents` and their `errors` in 1/time, NaN where these are not known, `copies`,
/// `pair_defect`, `sum_defect`, `time`; with `record_every` their `series`.
///
/// # Errors
/// For a setting that is missing or invalid, and if a step fails.
pub fn lyapunov<H, E>(settings: &Settings, handle: &Handle) -> Result<Outcome, TaskError>
where
    H: Exported + Discretized<E>,
{
    let system = H::from_fields(settings)?;
    let run = deviations::<H, E>(settings, &system, handle)?;
    let found = match settings.count("exponents")? {
        Some(largest) => run.lyapunov_of(largest)?,
        None => run.lyapunov()?,
    };
    let number = found.values.len();
    let mut results = Results::default();
    let unknown = vec![f64::NAN; number];
    results.add_list("exponents", found.values);
    results.add_list("errors", found.errors.unwrap_or(unknown));
    results.add_number("pair_defect", found.pair_defect.unwrap_or(f64::NAN));
    results.add_number("sum_defect", found.sum_defect.unwrap_or(f64::NAN));
    results.add_number("time", found.time);
    results.add("copies", found.copies.concat(), &[found.copies.len(), number]);
    if let Some(series) = found.series {
        let nodes = series.times.len();
        results.add_list("series.t", series.times);
        results.add("series.exponents", series.values.concat(), &[nodes, number]);
    }
    Ok(Outcome { results, error: None })
}

/// Indicators of chaos at the end of each path: `q`, `p` of its start, `megno`, `megno_mean`, `sali`, `gali_2`,
/// `fli`; NaN for paths that failed, which `failures` lists.
///
/// # Errors
/// For a setting that is missing or invalid, and if all paths fail; a run that was stopped has results and an
/// error.
#[cfg(feature = "ensemble")]
pub fn map<H, E>(settings: &Settings, handle: &Handle) -> Result<Outcome, TaskError>
where
    H: Exported + Discretized<E> + Send + Sync,
{
    let system = H::from_fields(settings)?;
    let (run, degrees) = crate::ensemble::begin::<H, E>(settings, &system, handle)?;
    let map = match settings.reals("deviations")? {
        Some(given) => run.deviations(given.rows()).indicators()?,
        None => run.indicators()?,
    };
    let mut results = Results { columns: variable_names(&system, degrees), ..Results::default() };
    add_states(&mut results, "", map.starts.iter());
    let lists = [
        ("megno", map.megno),
        ("megno_mean", map.megno_mean),
        ("sali", map.sali),
        ("gali_2", map.gali),
        ("fli", map.fli),
    ];
    lists.into_iter().for_each(|(name, list)| results.add_list(name, list));
    results.add_number("time", map.time);
    crate::ensemble::add_failures(&mut results, &map.failures);
    Ok(Outcome { results, error: map.is_partial.then(TaskError::stopped) })
}

/// The end of a path, `t`, `q`, `p`, and its derivatives: `by_start`, with a row for each coordinate and then
/// each momentum of the end, and a column for each of the start; with `by`, `by_parameters` and `by_step_size`.
///
/// # Errors
/// For a setting that is missing or invalid, and if a step fails.
pub fn tangent<H, E>(settings: &Settings, handle: &Handle) -> Result<Outcome, TaskError>
where
    H: Exported + Discretized<E>,
{
    let system = H::from_fields(settings)?;
    let (run, degrees) = begin::<H, E>(settings, &system, handle)?;
    let by = settings.lines("by")?;
    let found = if settings.has("by") { run.tangent_by(&by)? } else { run.tangent()? };
    let mut results = Results { columns: variable_names(&system, degrees), ..Results::default() };
    add_states(&mut results, "", [&found.end].into_iter());
    let rows = |matrix: &wzvi::nalgebra::DMatrix<f64>| matrix.transpose().as_slice().to_vec();
    let (lines, columns) = found.by_start.shape();
    results.add("by_start", rows(&found.by_start), &[lines, columns]);
    if let Some(by_step_size) = &found.by_step_size {
        results.add("by_parameters", rows(&found.by_parameters), &[lines, by.len()]);
        results.add_list("by_step_size", by_step_size.iter().copied());
    }
    Ok(Outcome { results, error: None })
}
