//! A multilevel run from what an ensemble was told.

use std::marker::PhantomData;

use super::{Multilevel, Observed, Setup};
use crate::ensemble::control::Control;
use crate::ensemble::source::{Settings, Source};
use crate::ensemble::{self, Ensemble, Extras};
use crate::path::recording::Request;
use crate::scheme::system::Discretized;

impl<'a, H: Discretized<E>, E> Ensemble<'a, H, E> {
    /// The mean of the one observable at the end, to a root mean square error of `target` (units of the observable), from
    /// coupled paths: [`Integrate::multilevel`](crate::integrate::Integrate::multilevel) with what was said of start, end, seed,
    /// observable, paths and threads. Whatever else was said has no meaning there, and is an error of the run.
    pub fn multilevel(self, target: f64) -> Multilevel<'a, H, E, Observed> {
        let ensemble::Setup {
            system,
            h,
            span,
            paths,
            source,
            settings,
            observables,
            own,
            events,
            sections,
            wanted,
            execution,
            starts,
            systems,
            recorded,
            inspector,
            keeping,
            retry,
            is_watched,
            control,
        } = self.setup;
        let Extras { quantiles, covariances, histograms, most_bytes, most_crossings, has_work, added } =
            wanted;
        let (Settings { truncation, is_antithetic }, Control { targets, losses }) = (settings, control);
        let Request { every, times } = recorded;
        let normals = source.as_ref().and_then(Source::normals);
        let refused = [
            (is_antithetic || source.as_ref().is_some_and(Source::is_antithetic), "antithetic paths"),
            (source.is_some() && normals.is_none(), "a noise that is not `StepNormals`"),
            (systems.is_some(), "paths that have systems of their own"),
            (starts.is_some() && span.start.is_none(), "paths that start at states of their own"),
            (!own.is_empty(), "observables of each path's own system"),
            (!events.is_empty(), "first passages"),
            (!sections.is_empty(), "sections"),
            (span.is_exact, "an exact end"),
            (quantiles || !histograms.is_empty(), "quantiles and histograms"),
            (covariances.is_some(), "covariances"),
            (most_bytes.is_some() || most_crossings > 0, "kept paths and crossings"),
            (every.is_some() || !times.is_empty(), "recorded times"),
            (inspector.is_some(), "`inspect`"),
            (keeping.is_set(), "`checkpoint`"),
            (has_work, "work and heat"),
            (!added.is_empty(), "statistics of its own"),
            (retry.most() > 0, "`retry`"),
            (!is_watched, "`unwatched`"),
            (!targets.is_empty(), "`until_error`"),
            (losses.is_some(), "`allow_losses`"),
        ];
        let refused = refused.into_iter().find_map(|(is_asked, what)| is_asked.then_some(what));
        let seed = source.as_ref().map(Source::seed);
        let truncation =
            normals.map_or(truncation, |normals| normals.clone().with_truncation(truncation).truncation());
        let begun = Multilevel::<H, E>::new(system, h).setup;
        let setup = Setup { span, observables, paths, execution, seed, truncation, refused, ..begun };
        Multilevel { setup, types: PhantomData }.target(target)
    }
}
