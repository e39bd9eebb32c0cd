//! A multilevel run from what an ensemble was told.

use std::marker::PhantomData;

use super::{Multilevel, Observed, Setup};
use crate::ensemble::{self, Ensemble};
use crate::system::Discretized;

impl<'a, H: Discretized<E>, E> Ensemble<'a, H, E> {
    /// The mean of the one observable at the end, to a root mean square error of `target` (units of the observable), from
    /// coupled paths: [`Integrate::multilevel`](crate::integrate::Integrate::multilevel) with what was said of start, end, seed,
    /// observable, paths and threads.
    pub fn multilevel(self, target: f64) -> Multilevel<'a, H, E, Observed> {
        let ensemble::Setup {
            system,
            h,
            span,
            paths,
            source,
            settings,
            observables,
            events,
            sections,
            wanted,
            execution,
            starts,
            systems,
            ..
        } = self.setup;
        let refused = [
            (settings.is_antithetic, "antithetic paths"),
            (systems.is_some(), "paths that have systems of their own"),
            (starts.is_some() && span.start.is_none(), "paths that start at states of their own"),
            (!events.is_empty(), "first passages"),
            (!sections.is_empty(), "sections"),
            (span.is_exact, "an exact end"),
            (wanted.quantiles || !wanted.histograms.is_empty(), "quantiles and histograms"),
            (wanted.most_bytes.is_some(), "kept paths"),
        ];
        let refused = refused.into_iter().find_map(|(is_asked, what)| is_asked.then_some(what));
        let (seed, truncation) = (source.map(|source| source.seed()), settings.truncation);
        let begun = Multilevel::<H, E>::new(system, h).setup;
        let setup = Setup { span, observables, paths, execution, seed, truncation, refused, ..begun };
        Multilevel { setup, types: PhantomData }.target(target)
    }
}
