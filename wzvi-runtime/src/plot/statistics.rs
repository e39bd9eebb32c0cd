//! The figures of an ensemble.
//!
//! Tested by `tests/paths/results.rs`.

use super::figure::{Figure, Look};
use super::path::SHOWN;
use crate::statistics::StatisticsError;
use crate::statistics::{Statistics, StatisticsNode};

/// Figures of an ensemble: [`Statistics::plot`] begins them. Each method returns a [`Figure`]:
/// [`Figure::write`] draws it as SVG or PNG, and a [`Sheet`](super::Sheet) puts it beside others.
#[derive(Clone, Copy, Debug)]
#[must_use = "nothing is drawn before `write`"]
pub struct StatisticsPlot<'a> {
    statistics: &'a Statistics,
}

impl Statistics {
    /// The ensemble as figures, with the names of the observables.
    ///
    /// `statistics.plot().means().write("means.svg")?` draws one.
    pub fn plot(&self) -> StatisticsPlot<'_> {
        StatisticsPlot { statistics: self }
    }
}

impl StatisticsPlot<'_> {
    /// The mean of each of the first six observables against time, between dashed lines two standard errors
    /// away.
    pub fn means(&self) -> Figure {
        let mut figure = Figure::panel("Means, ± 2 standard errors", "t", "");
        for (observable, name) in self.statistics.observables().iter().take(SHOWN).enumerate() {
            let curve = |errors: f64| {
                let at = move |node: &StatisticsNode| {
                    (node.time(), node.mean(observable) + errors * node.standard_error(observable))
                };
                self.statistics.nodes().iter().map(at)
            };
            figure = figure
                .line(name, observable, curve(0.0))
                .points(Look::Dashed, "", observable, curve(-2.0))
                .points(Look::Dashed, "", observable, curve(2.0));
        }
        figure
    }

    /// The density of an observable by its first histogram, at the last six recorded times after the start.
    ///
    /// # Errors
    /// The errors of [`Statistics::histogram`].
    pub fn histogram(&self, name: &str) -> Result<Figure, StatisticsError> {
        let position = self.statistics.histogram_position(name)?;
        let nodes = self.statistics.nodes();
        let first = nodes.len().saturating_sub(SHOWN).max(1);
        let mut figure = Figure::panel("Histogram", name, "density");
        for (colour, node) in nodes.iter().skip(first).enumerate() {
            let Some(histogram) = node.histograms().get(position) else { continue };
            let middle = |bin| 0.5 * (histogram.edge(bin) + histogram.edge(bin + 1));
            let bins = 0..histogram.counts().len();
            let density = bins.map(|bin| (middle(bin), histogram.density(bin)));
            figure = figure.line(format!("t = {}", super::number(node.time())), colour, density);
        }
        Ok(figure)
    }

    /// An observable of each kept path, at this many of the last recorded times, against a parameter that
    /// depends on the number of the path: a sweep, or a bifurcation diagram.
    ///
    /// # Errors
    /// [`StatisticsError::Unknown`] for a name that does not exist, [`StatisticsError::NotComputed`] if the
    /// run did not keep its paths.
    pub fn sweep(
        &self,
        name: &str,
        times: usize,
        parameter: impl Fn(u64) -> f64,
    ) -> Result<Figure, StatisticsError> {
        let observable = self.statistics.known(name)?;
        let missing = StatisticsError::NotComputed { what: "paths", remedy: ".keep_paths(bytes)" };
        let paths = self.statistics.paths().ok_or(missing)?;
        let nodes = self.statistics.nodes().len();
        let points = (0..paths.count()).flat_map(|path| {
            let x = parameter(path as u64);
            let values = (nodes.saturating_sub(times)..nodes).filter_map(move |node| paths.at(path, node));
            values.filter_map(move |values| Some((x, *values.get(observable)?)))
        });
        Ok(Figure::panel("Sweep", "parameter", name).points(Look::FineDots, "", 0, points))
    }
}
