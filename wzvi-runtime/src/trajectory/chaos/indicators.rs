//! MEGNO, SALI, GALI and FLI of a path.

use super::frame::{Frame, orthogonalise};
use super::{Deviations, chosen};
use crate::algebra::scalar::Scalar;
use crate::algebra::state::Vector;
use crate::error::wrong;
use crate::increments::Noise;
use crate::saving::table::{Table, TableRows};
use crate::scheme::system::Discretized;
use crate::trajectory::Error;
use crate::trajectory::simulate::{COLUMNS, Simulation, Summation, Unobserved};
use crate::trajectory::steps::StepToTake;

/// Indicators of chaos of a path.
#[derive(Clone, Debug, PartialEq)]
pub struct Indicators {
    /// `Y_n = (2/n) Σ k l_k` at the end, by the first deviation.
    pub megno: f64,
    /// `Ȳ_n`, the mean of `Y_k` over the steps: near 2 on regular paths, near half the exponent times the
    /// time on chaotic ones. With noise it has no such value.
    pub megno_mean: f64,
    /// The smaller length of sum and difference of the first two deviations as unit vectors: at most `√2`,
    /// and zero to rounding on chaotic paths.
    pub sali: f64,
    /// GALI_2, GALI_3, …: the volume of so many deviations as unit vectors.
    pub gali: Vec<f64>,
    /// The largest `ln |δ_k|` of the first deviation, `k ≥ 1`.
    pub fli: f64,
    /// The length of the run, in units of time.
    pub time: f64,
    /// The indicators at the nodes that `record_every` asks for.
    pub series: Option<IndicatorSeries>,
}

/// Indicators from the start to nodes of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct IndicatorSeries {
    /// Times of the nodes.
    pub times: Vec<f64>,
    /// [`Indicators::megno`]
    pub megno: Vec<f64>,
    /// [`Indicators::megno_mean`]
    pub megno_mean: Vec<f64>,
    /// [`Indicators::sali`]
    pub sali: Vec<f64>,
    /// [`Indicators::gali`]
    pub gali: Vec<Vec<f64>>,
    /// [`Indicators::fli`]
    pub fli: Vec<f64>,
}

impl IndicatorSeries {
    /// A row for each node.
    pub fn table(&self) -> Table {
        let lists = [
            ("t", &self.times),
            ("megno", &self.megno),
            ("megno_mean", &self.megno_mean),
            ("sali", &self.sali),
            ("fli", &self.fli),
        ];
        let rows = lists.into_iter().fold(TableRows::of(0..self.times.len()), |rows, (name, list)| {
            rows.column(name, move |row| list[*row])
        });
        let volumes = self.gali.first().map_or(0, Vec::len);
        let rows = (0..volumes)
            .fold(rows, |rows, k| rows.column(format!("gali_{}", k + 2), move |row| self.gali[*row][k]));
        rows.table("indicators")
    }
}

/// Sums over the growth of a deviation, in the numbers `S` of one path or of several in lanes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Growth<S> {
    /// `ln |δ_k|`
    pub(crate) ln_length: S,
    /// `Σ k l_k`
    pub(crate) weighted: S,
    /// `Σ Y_k`
    pub(crate) means: S,
    /// The largest `ln |δ_k|`, the least of all numbers before the first step.
    pub(crate) fli: S,
}

impl<S: Scalar> Growth<S> {
    /// The growth of a deviation of length one.
    pub(crate) fn new() -> Self {
        let [zero, least] = [0.0, f64::MIN].map(S::from_f64);
        Self { ln_length: zero, weighted: zero, means: zero, fli: least }
    }

    /// After a step from `before` steps to `now` steps; a last one that is shorter counts as its part of a
    /// step.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn add(&mut self, ln_length: S, [before, now]: [f64; 2]) {
        self.weighted = self.weighted + (ln_length - self.ln_length) * now;
        self.means = self.means + self.weighted * (2.0 / now * (now - before));
        self.fli = self.fli.max(ln_length);
        self.ln_length = ln_length;
    }

    /// `Y_n` after `n` steps.
    pub(crate) fn megno(&self, n: f64) -> S {
        self.weighted * (2.0 / n)
    }

    /// `Ȳ_n`
    pub(crate) fn megno_mean(&self, n: f64) -> S {
        self.means * (1.0 / n)
    }
}

/// The smaller length of sum and difference of two unit vectors.
pub(crate) fn sali(u: &[f64], v: &[f64]) -> f64 {
    let length = |sign: f64| u.iter().zip(v).map(|(u, v)| Scalar::powi(u + sign * v, 2)).sum::<f64>().sqrt();
    length(1.0).min(length(-1.0))
}

/// The volumes of the first two, three, … unit vectors.
pub(crate) fn gali(units: &[Vec<f64>]) -> Vec<f64> {
    let mut frame: Vec<Vec<f64>> = Vec::new();
    let mut volume = 1.0;
    let volumes = units.iter().map(|unit| {
        let mut own = unit.clone();
        let rest = orthogonalise(&frame, &mut own);
        volume *= rest;
        if rest > 0.0 {
            own.iter_mut().for_each(|x| *x /= rest);
        }
        frame.push(own);
        volume
    });
    volumes.skip(1).collect()
}

impl<H, E, N, S> Simulation<'_, H, E, N, Unobserved, S>
where
    H: Discretized<E>,
    N: Noise,
    S: Summation<H, E>,
{
    /// MEGNO, SALI, GALI and FLI of the path ([`chaos`](crate::trajectory::chaos)), by four deviations, or
    /// two of one degree of freedom. With `record_every(n)` the result has their series, too.
    ///
    /// ```ignore
    /// let run = henon_heiles.simulate::<Verlet>(0.1).start(start).until(1e4);
    /// let is_chaotic = run.indicators()?.megno_mean > 4.0;
    /// ```
    ///
    /// # Errors
    /// The errors of [`Simulation::tangent`]; [`Error::Stopped`]. A run without steps is refused.
    pub fn indicators(self) -> Result<Indicators, Error> {
        self.generic().indicators()
    }
}

impl<H, E, N, S> Deviations<'_, H, E, N, S>
where
    H: Discretized<E>,
    N: Noise,
    S: Summation<H, E>,
{
    /// As [`Simulation::indicators`]; of given deviations it takes all, and needs two.
    ///
    /// # Errors
    /// The errors of [`Simulation::indicators`].
    pub fn indicators(mut self) -> Result<Indicators, Error> {
        let stride = self.take_stride();
        let Self { run, given, .. } = self;
        let mut bare = run.bare("indicators", true)?;
        let (start, grid) = (bare.start.clone(), bare.grid);
        let degrees = start.q.components().len();
        let number = given.as_ref().map_or(COLUMNS.min(2 * bare.system.degrees_left(degrees)), Vec::len);
        if number < 2 {
            return wrong("`indicators` of one deviation: SALI compares two, so give two or more");
        }
        if grid.steps == 0 {
            return wrong("`indicators` of a run without steps: run to a later end");
        }
        let mut frame =
            Frame::new(bare.system, bare.h, &start, &chosen(bare.system, &bare.start, given, number)?)?;
        let mut growth = Growth::<f64>::new();
        let mut series = stride.map(|_| IndicatorSeries::default());
        let mut last = (f64::NAN, Vec::new());
        bare.run_from(start, |whole, step| {
            let node = step.interval.step + 1;
            let StepToTake { state, interval, noise, dw } = step;
            frame.take_step(whole, StepToTake { state, interval, noise, dw })?;
            growth.add(frame.ln_length(0), [node - 1, node].map(|node| grid.steps_to(node)));
            let is_recorded = stride.is_some_and(|stride| stride > 0 && node % stride == 0);
            if is_recorded || node == grid.steps {
                let (units, n) = (frame.units(), grid.steps_to(node));
                last = (sali(&units[0], &units[1]), gali(units));
                if let Some(series) = &mut series {
                    series.times.push(grid.time(node));
                    series.megno.push(growth.megno(n));
                    series.megno_mean.push(growth.megno_mean(n));
                    series.sali.push(last.0);
                    series.gali.push(last.1.clone());
                    series.fli.push(growth.fli);
                }
            }
            Ok(())
        })?;
        let (sali, gali) = last;
        let n = grid.steps_to(grid.steps);
        Ok(Indicators {
            megno: growth.megno(n),
            megno_mean: growth.megno_mean(n),
            sali,
            gali,
            fli: growth.fli,
            time: (grid.time(grid.steps) - grid.start).abs(),
            series,
        })
    }
}
