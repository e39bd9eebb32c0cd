//! Indicators of chaos of many starts: a map of phase space.

mod linearised;

use std::path::Path;

use linearised::{Linearised, NUMBER, WithDeviations, lifted, parts};

use super::checks::number_of_paths;
use super::made_settings::made_of;
use super::starts::{ByPath, DrawPurpose, OneSystem, check};
use super::{Ensemble, EnsembleSettings, EnsembleSetup};
use crate::algebra::state::{State, Vector};
use crate::error::{ConfigError, wrong};
use crate::ground::variables::Variables;
use crate::increments::Noise;
use crate::saving::FileError;
use crate::saving::file;
use crate::saving::table::{Table, TableRows};
use crate::scheme::constraints::ManifoldPoint;
use crate::scheme::system::{Discretized, Hamiltonian};
use crate::statistics::PathFailure;
use crate::trajectory::Error;
use crate::trajectory::chaos::{chosen, gali, sali};
use crate::trajectory::exclusive_setting::SOME;
use crate::trajectory::made_settings::MadeSetting;
use crate::trajectory::span::{ONE_START, projected, sized};

const MEGNO: &str = "megno";

/// An ensemble together with deviations from its paths: [`Ensemble::deviations`] begins it.
#[must_use = "nothing happens before `indicators`"]
pub struct MapDeviations<'a, H: Hamiltonian, E, N> {
    ensemble: Ensemble<'a, H, E, N, OneSystem>,
    given: Option<Vec<Vec<f64>>>,
}

/// Indicators of chaos at the end of each path of an ensemble, in the order of the starts: those of
/// [`Indicators`](crate::trajectory::chaos::Indicators). Paths that failed have NaN.
#[derive(Clone, Debug, PartialEq)]
pub struct ChaosMap<V> {
    /// The starts of the paths.
    pub starts: Vec<State<V>>,
    /// `Y_n`
    pub megno: Vec<f64>,
    /// `Ȳ_n`: near 2 on regular paths.
    pub megno_mean: Vec<f64>,
    /// The smaller length of sum and difference of the two deviations as unit vectors.
    pub sali: Vec<f64>,
    /// GALI_2, the area between them.
    pub gali: Vec<f64>,
    /// The largest `ln |δ_k|`.
    pub fli: Vec<f64>,
    /// The length of the run, in units of time.
    pub time: f64,
    /// The first thousand paths that failed, with their errors.
    pub failures: Vec<PathFailure>,
    /// Whether the run was stopped before its last path: lists are shorter then.
    pub is_partial: bool,
    pub(crate) variables: Variables,
}

impl<'a, H, E, N> Ensemble<'a, H, E, N, OneSystem>
where
    H: Discretized<E> + Sync,
    N: Noise,
{
    /// MEGNO, SALI, GALI_2 and FLI of each path ([`chaos`](crate::trajectory::chaos)), by two deviations.
    /// Steps are taken in dual numbers: in lanes where they are explicit or in straight-line code, else path
    /// by path.
    ///
    /// ```ignore
    /// let map = henon_heiles.ensemble::<Verlet>(0.1).starts_from(grid).until(1000.0).indicators()?;
    /// let chaotic = map.megno_mean.iter().filter(|megno| **megno > 4.0).count();
    /// ```
    ///
    /// Paths that fail, as those that escape, are no error unless all do: [`Ensemble::allow_losses`] sets
    /// another limit.
    ///
    /// # Errors
    /// The errors of [`Ensemble::run`]; [`ConfigError::Setting`] for settings without meaning here, as
    /// observables and statistics.
    pub fn indicators(self) -> Result<ChaosMap<H::Vector>, Error> {
        MapDeviations { ensemble: self, given: None }.indicators()
    }

    /// The same ensemble with these two deviations at each start, in place of generic ones. Each has one
    /// number for each coordinate and then one for each momentum; only its direction counts.
    pub fn deviations<D: Into<Vec<f64>>>(
        self,
        deviations: impl IntoIterator<Item = D>,
    ) -> MapDeviations<'a, H, E, N> {
        MapDeviations { ensemble: self, given: Some(deviations.into_iter().map(Into::into).collect()) }
    }
}

impl<H, E, N> MapDeviations<'_, H, E, N>
where
    H: Discretized<E> + Sync,
    N: Noise,
{
    /// As [`Ensemble::indicators`].
    ///
    /// # Errors
    /// The errors of [`Ensemble::indicators`], and [`ConfigError::Setting`] for deviations that are
    /// dependent, or not two.
    pub fn indicators(self) -> Result<ChaosMap<H::Vector>, Error> {
        let Self { ensemble: Ensemble { setup, .. }, given } = self;
        MadeSetting::refuse("indicators", made_of(&setup), USED)?;
        let EnsembleSetup { system, h, span, recorded, is_watched, execution, keeping, more, .. } = setup;
        let EnsembleSettings { starts, paths, source, settings, control, .. } = more;
        let seed = source.value().map_or(0, super::source::NoiseSource::seed);
        let starts = starts.checked(ONE_START)?;
        let first = match &starts {
            Some(_) if span.start.value().is_some() => {
                return wrong(
                    "`start(...)` and starts of the paths, `starts(...)` or `starts_from(...)`: leave one of them out",
                );
            }
            Some(starts) => starts.of(DrawPurpose::Start, seed, 0),
            None => span.start.value().cloned(),
        };
        let first = first.ok_or(ConfigError::Missing(STARTS))?;
        sized(system, &first)?;
        let degrees = first.q.components().len();
        if given.as_ref().is_some_and(|given| given.len() != NUMBER) {
            return wrong(format!("a map takes {NUMBER} deviations"));
        }
        let first = projected(system, first, span.is_projected).map_err(ConfigError::Start)?;
        let deviations = chosen(system, &first, given, NUMBER)?;
        let listed = starts.as_ref().and_then(ByPath::listed);
        let paths = number_of_paths(paths, [listed, None])?;
        let start_of = |path: u64| match &starts {
            Some(starts) => starts.of(DrawPurpose::Start, seed, path).ok_or(ConfigError::Missing(STARTS)),
            None => Ok(first.clone()),
        };
        let mut all = Vec::new();
        let number = usize::try_from(paths).ok();
        if number.is_none_or(|number| all.try_reserve_exact(number).is_err()) {
            return wrong(format!(
                "there is no memory for the starts of {paths} paths: ask for fewer `.paths(...)`"
            ));
        }
        for path in 0..paths {
            let start = start_of(path)?;
            check(system, &start, path, degrees, first.t)?;
            let start = projected(system, start, span.is_projected);
            all.push(start.map_err(|cause| ConfigError::PathStart { path, cause })?);
        }

        let system = Linearised { system, start: first.t, h };
        let mut ensemble = Ensemble::<_, WithDeviations<E>>::new(&system, h).marked::<N, OneSystem>();
        let EnsembleSetup { span: own_span, more: own, .. } = &mut ensemble.setup;
        (own_span.end, own_span.is_whole) = (span.end, span.is_whole);
        own.starts.set(
            "starts_from",
            SOME,
            ByPath::Drawn(Box::new(|draw| {
                let start = all.get(draw.path() as usize).unwrap_or(&first);
                lifted(start, &tangent(system.system, start, &deviations))
            })),
        );
        (own.paths, own.source, own.settings, own.control) = (Some(paths), source, settings, control);
        own.control.losses = own.control.losses.or(Some(1.0));
        (own.wanted.covariances, own.wanted.most_bytes) = (Some(false), Some(u64::MAX));
        (ensemble.setup.recorded, ensemble.setup.is_watched) = (recorded, is_watched);
        (ensemble.setup.execution, ensemble.setup.keeping) = (execution, keeping);
        // Steps so far; of the start, which has no indicators yet, one.
        let steps = |state: &State<_>| ((state.t - first.t) / h).max(1.0);
        let statistics = ensemble
            .observe(MEGNO, |state| parts(state).1.megno(steps(state)))
            .observe("megno_mean", |state| parts(state).1.megno_mean(steps(state)))
            .observe("sali", |state| {
                let ([u, v], _) = parts(state);
                sali(&u, &v)
            })
            .observe("gali_2", |state| gali(&parts(state).0).first().copied().unwrap_or(f64::NAN))
            .observe("fli", |state| {
                let (_, growth) = parts(state);
                if growth.fli == f64::MIN { 0.0 } else { growth.fli }
            })
            .run()?;
        let last = statistics.nodes().len().saturating_sub(1);
        let ends: Vec<&[f64]> = statistics.paths().map_or_else(Vec::new, |paths| {
            (0..paths.count()).filter_map(|path| paths.at(path, last)).collect()
        });
        let of = |observable: usize| ends.iter().map(|values| values[observable]).collect::<Vec<_>>();
        all.truncate(ends.len());
        Ok(ChaosMap {
            megno: of(0),
            megno_mean: of(1),
            sali: of(2),
            gali: of(3),
            fli: of(4),
            time: statistics.last().map_or(f64::NAN, |node| (node.time() - first.t).abs()),
            failures: statistics.failures().to_vec(),
            is_partial: statistics.is_partial(),
            variables: system.system.variables(),
            starts: all,
        })
    }
}

/// The deviations on the tangent space of the manifold of constraints at a start, if there is one.
fn tangent<H: Hamiltonian>(system: &H, start: &State<H::Vector>, deviations: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let mut deviations = deviations.to_vec();
    if let Some(manifold) = system.manifold() {
        let (q, p) = (start.q.components(), start.p.components());
        let point = ManifoldPoint { q, p, t: start.t };
        deviations.iter_mut().for_each(|deviation| manifold.make_tangent(point, deviation));
    }
    deviations
}

const STARTS: &str = "a start: add `.start(...)`, `.starts_from(...)` or `.starts(...)`";

/// The settings of an ensemble that a map of indicators takes. Whether each path has a system of its own is
/// part of its type.
const USED: &[MadeSetting] = &[
    MadeSetting::AllowLosses,
    MadeSetting::Antithetic,
    MadeSetting::Checkpoint,
    MadeSetting::Handle,
    MadeSetting::OtherNoise,
    MadeSetting::Starts,
    MadeSetting::StopWhen,
    MadeSetting::Unwatched,
];

impl<V: Vector> ChaosMap<V> {
    /// A row for each path: its start under the names of the closure, and its indicators.
    pub fn table(&self) -> Table {
        let Variables { q, p, .. } = self.variables;
        let degrees = self.starts.first().map_or(0, |start| start.q.components().len());
        let rows = TableRows::of(0..self.starts.len());
        let rows = (0..degrees)
            .fold(rows, |rows, i| rows.column(q.name(i), move |path| self.starts[*path].q.components()[i]));
        let rows = (0..degrees)
            .fold(rows, |rows, i| rows.column(p.name(i), move |path| self.starts[*path].p.components()[i]));
        let lists = [
            (MEGNO, &self.megno),
            ("megno_mean", &self.megno_mean),
            ("sali", &self.sali),
            ("gali_2", &self.gali),
            ("fli", &self.fli),
        ];
        let rows =
            lists.into_iter().fold(rows, |rows, (name, list)| rows.column(name, move |path| list[*path]));
        rows.table("map")
    }

    /// Comma-separated values with the names in the first line. The folder of the file is made if it is not
    /// there, and the file appears complete or not at all.
    ///
    /// # Errors
    /// [`FileError`] if it cannot be written.
    pub fn write_csv(&self, file: impl AsRef<Path>) -> Result<(), FileError> {
        file::replace_in_folder(file.as_ref(), |file| self.table().write_csv(file))
    }

    /// A Parquet file with a column of `DOUBLE`s each. The folder and the file as with
    /// [`ChaosMap::write_csv`].
    ///
    /// # Errors
    /// [`FileError`] if it cannot be written.
    #[cfg(feature = "columnar")]
    pub fn write_parquet(&self, file: impl AsRef<Path>) -> Result<(), FileError> {
        file::replace_in_folder(file.as_ref(), |file| self.table().write_parquet(file))
    }
}
