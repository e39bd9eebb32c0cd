//! The choice of a scheme and a step size for a wanted error.
//!
//! Tested by `tests/paths/report/estimators.rs`.

use super::fit::Slope;
use super::{Cell, Report, duration, number};

/// The cheapest way to an error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice<'a> {
    /// The error wanted.
    pub error: f64,
    /// The measurement that reaches it in the least time, noise included.
    pub cell: &'a Cell,
    /// That time, seconds.
    pub seconds: f64,
}

impl Choice<'_> {
    /// "for an error of 1e-3, use Midpoint with h = 0.0078: 1.2 ms".
    pub fn words(&self) -> String {
        let Self { error, cell, seconds } = self;
        let noise = match cell.noise_time {
            Some(noise) => format!(" a path, {} of it noise", duration(noise.median)),
            None => " a path".to_owned(),
        };
        format!(
            "for an error of {}, use {} with h = {}: {}{noise}",
            if *error < 1.0 { format!("{error:.0e}") } else { number(*error) },
            cell.scheme,
            number(cell.h),
            duration(*seconds)
        )
    }
}

impl Report {
    /// The measurements that no other beats in both error and time, the fastest first. Only schemes and step
    /// sizes that never failed, of schemes that converge, count.
    pub fn pareto(&self) -> Vec<&Cell> {
        let mut cells: Vec<(f64, &Cell)> = self.candidates().collect();
        cells.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.strong.value.total_cmp(&b.1.strong.value)));
        let mut best = f64::INFINITY;
        cells.retain(|(_, cell)| {
            let better = cell.strong.value < best;
            best = best.min(cell.strong.value);
            better
        });
        cells.into_iter().map(|(_, cell)| cell).collect()
    }

    /// The cheapest way to an error: the upper end of its 95 % interval is to be below.
    pub fn cheapest(&self, error: f64) -> Option<Choice<'_>> {
        let reached = |cell: &Cell| cell.strong.value + cell.strong.half_width() <= error;
        let cheapest = self.candidates().filter(|(_, cell)| reached(cell)).min_by(|a, b| a.0.total_cmp(&b.0));
        cheapest.map(|(seconds, cell)| Choice { error, cell, seconds })
    }

    /// The cheapest ways to errors `10^-k`, as far as they were reached, the largest error first.
    pub fn choices(&self) -> Vec<Choice<'_>> {
        let errors = || self.candidates().map(|(_, cell)| cell.strong.value).filter(|error| *error > 0.0);
        let (largest, smallest) = (errors().fold(0.0, f64::max), errors().fold(f64::INFINITY, f64::min));
        if largest <= 0.0 {
            return vec![];
        }
        let (first, last) = (largest.log10().ceil() as i32, smallest.log10().floor() as i32);
        // From the exponent as text: powi is off by an ulp now and then.
        let power = |k: i32| format!("1e{k}").parse().unwrap_or(f64::NAN);
        let mut choices: Vec<Choice<'_>> = (last..=first).filter_map(|k| self.cheapest(power(k))).collect();
        // A measurement that also reaches a smaller error is listed once.
        choices.dedup_by(|larger, smaller| std::ptr::eq(larger.cell, smaller.cell));
        choices.reverse();
        choices
    }

    fn candidates(&self) -> impl Iterator<Item = (f64, &Cell)> {
        // A scheme that does not converge is no way to an error, however near it happens to be.
        let schemes =
            self.schemes().into_iter().filter(|scheme| !matches!(self.slope(scheme), Slope::Flat { .. }));
        let schemes: Vec<&str> = schemes.collect();
        let timed = self.cells.iter().filter(move |cell| {
            cell.failures == 0 && cell.strong.value.is_finite() && schemes.contains(&cell.scheme.as_str())
        });
        timed.filter_map(|cell| Some((cell.seconds()?, cell)))
    }
}
