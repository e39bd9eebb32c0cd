//! Lyapunov exponents by QR.
//!
//! `T_n ... T_1 Δ_0 = Q R`, kept as a product of such factors: `λ_j = ln R_jj / T`. Deviations are made
//! orthonormal before they become so parallel that their digits are lost.
//!
//! **Errors.** Exponents of a chaotic path over a finite time scatter from path to path, and correlations
//! along one path last so long that batches of it give errors that are 2 to 3 times too small. The error is
//! the standard deviation of the exponents of several paths, and at least the error by batches.
//!
//! * With noise the others are other paths of the noise. Copies under the same increments would come together
//!   where exponents are negative.
//! * Without noise they start beside the path, and are others once they have left it. The spread of what they
//!   then gain, over a part `T - τ` of the time, is that of a part of the run: it is taken times
//!   `√(T / (T - τ))`. Copies that leave it in the second half of the run, or not at all although deviations
//!   grow exponentially, say that the run is too short.
//! * Where deviations grow at most like the square of the time, as on regular paths, copies stay where they
//!   are. The error is then by batches: the first of them has most of `ln T`, so that it covers this bias.

use super::frame::Frame;
use super::{Deviations, chosen, start};
use crate::algebra::scalar::Scalar;
use crate::algebra::state::{State, Vector};
use crate::algebra::state_sum::StateSum;
use crate::error::wrong;
use crate::ground::digits::estimate;
use crate::increments::Noise;
use crate::saving::table::{Table, TableRows};
use crate::scheme::constraints::put_on;
use crate::scheme::system::Discretized;
use crate::trajectory::Error;
use crate::trajectory::series::BatchMeans;
use crate::trajectory::simulate::{Simulation, StepsOnly, Summation, Unobserved};
use crate::trajectory::steps::StepToTake;

/// Lengths of deviations between which they are made orthonormal: of the digits of `f64`, 12 remain in the
/// shortest.
const LONG: f64 = 64.0;
/// The logarithms of the diagonal of `R` that differ by more than this ask for QR more often; by less than a
/// half, less often.
const APART: f64 = 6.0;
/// Steps between two factorisations, at most: deviations that contract are not seen by their lengths.
const MOST: u64 = 256;
/// Batches of one run, at equal numbers of steps.
const BATCHES: usize = 64;
/// How far from the path copies start, in units of the largest coordinate and momentum on the path.
const NEAR: f64 = 1e-7;
/// How far from it they are others, likewise.
const FAR: f64 = 1e-2;
/// Between the paths of a noise that copies have: beyond all ensembles.
const PATHS: u64 = 1 << 40;

/// Lyapunov exponents of a path.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum {
    /// The exponents in 1/time, the largest first: of this path over this time.
    pub values: Vec<f64>,
    /// The standard deviation of each from path to path, over the same time. `None` without copies, for a run
    /// that is too short for one, and for a noise with one path alone, as given increments.
    pub errors: Option<Vec<f64>>,
    /// The largest `|λ_i + λ_{2d+1-i} - 2 Σλ/2d|`. It goes to zero like `ln T / T` for symplectic steps and
    /// with friction of one rate; `None` for fewer than all exponents, and for other systems.
    pub pair_defect: Option<f64>,
    /// `Σλ` minus what it is: 0 for symplectic steps, `-d γ` with friction of one rate `γ`. It is zero to
    /// rounding; `None` as for `pair_defect`, and with constraints, where the sum goes to that like `1/T`.
    pub sum_defect: Option<f64>,
    /// The length of the run, in units of time.
    pub time: f64,
    /// The exponents of each copy over the same time, the largest first.
    pub copies: Vec<Vec<f64>>,
    /// How the exponents of the path converge, at the nodes that `record_every` asks for.
    pub series: Option<SpectrumSeries>,
}

/// Exponents up to nodes of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SpectrumSeries {
    /// Times of the nodes.
    pub times: Vec<f64>,
    /// The exponents from the start to each of them, the largest first.
    pub values: Vec<Vec<f64>>,
}

impl SpectrumSeries {
    /// A row for each node: its time, and the exponents up to there.
    pub fn table(&self) -> Table {
        let number = self.values.first().map_or(0, Vec::len);
        let rows = TableRows::of(self.times.iter().zip(&self.values)).column("t", |(t, _)| **t);
        let rows = (0..number)
            .fold(rows, |rows, k| rows.column(format!("lambda_{}", k + 1), move |(_, values)| values[k]));
        rows.table("lyapunov")
    }
}

impl Spectrum {
    /// The sum of the exponents, in 1/time: the rate at which a volume of so many dimensions grows.
    pub fn sum(&self) -> f64 {
        self.values.iter().sum()
    }
}

/// The exponents with their errors, to the digits that these leave.
impl std::fmt::Display for Spectrum {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (k, value) in self.values.iter().enumerate() {
            let error = self.errors.as_ref().map_or(f64::NAN, |errors| errors[k]);
            write!(f, "{}{}", if k == 0 { "" } else { ", " }, estimate(*value, error))?;
        }
        if self.errors.is_none() {
            f.write_str(" (errors not known)")?;
        }
        Ok(())
    }
}

impl<H, E, N, S> Simulation<'_, H, E, N, Unobserved, S>
where
    H: Discretized<E>,
    N: Noise,
    S: Summation<H, E>,
{
    /// The Lyapunov exponents of the path, all of them ([`chaos`](crate::trajectory::chaos)). The run is
    /// repeated for 8 copies ([`Simulation::copies`]). With `record_every(n)` the result has the series of
    /// the exponents, too.
    ///
    /// ```ignore
    /// let run = henon_heiles.simulate::<Verlet>(0.1).start(start).until(1e4);
    /// println!("{}", run.lyapunov()?);        // 0.049 ± 0.009, ...
    /// ```
    ///
    /// # Errors
    /// The errors of [`Simulation::tangent`]; of copies, too; [`Error::Stopped`]. A run without steps, and
    /// deviations that are dependent, are refused.
    pub fn lyapunov(self) -> Result<Spectrum, Error> {
        self.generic().lyapunov()
    }

    /// The `largest` ones alone, at the cost of as many deviations.
    ///
    /// # Errors
    /// The errors of [`Simulation::lyapunov`]; [`ConfigError::Setting`](crate::error::ConfigError::Setting)
    /// for none, or for more than there are.
    pub fn lyapunov_of(self, largest: usize) -> Result<Spectrum, Error> {
        self.generic().lyapunov_of(largest)
    }
}

impl<H, E, N, S> Deviations<'_, H, E, N, S>
where
    H: Discretized<E>,
    N: Noise,
    S: Summation<H, E>,
{
    /// As [`Simulation::lyapunov`]; of given deviations as many exponents as there are.
    ///
    /// # Errors
    /// The errors of [`Simulation::lyapunov`].
    pub fn lyapunov(self) -> Result<Spectrum, Error> {
        let number = self.given.as_ref().map(Vec::len);
        self.exponents(number)
    }

    /// As [`Simulation::lyapunov_of`]; of more given deviations it takes the first.
    ///
    /// # Errors
    /// The errors of [`Simulation::lyapunov_of`].
    pub fn lyapunov_of(self, largest: usize) -> Result<Spectrum, Error> {
        self.exponents(Some(largest))
    }

    fn exponents(mut self, number: Option<usize>) -> Result<Spectrum, Error> {
        let stride = self.take_stride();
        let Self { run, given, copies } = self;
        let mut bare = run.bare("lyapunov", true)?;
        let degrees = bare.start.q.components().len();
        let number = number.unwrap_or(2 * bare.system.degrees_left(degrees));
        if number == 0 {
            return wrong("`lyapunov` of no deviations: ask for one exponent or more");
        }
        if bare.grid.steps == 0 {
            return wrong("`lyapunov` of a run without steps: run to a later end");
        }
        let deviations = chosen(bare.system, &bare.start, given, number)?;
        let (start, is_driven) = (bare.start.clone(), bare.is_driven());
        bare.runs = 1 + u64::from(copies);
        let path = Stretching::of(&mut bare, start.clone(), &deviations, stride, None)?;
        let mut others = Vec::new();
        for copy in 0..u64::from(copies) {
            let start = if !is_driven {
                let mut start = displaced(&start, copy, path.sizes);
                put_on(bare.system.manifold(), &mut start);
                start
            } else if bare.skip_paths(PATHS)? {
                start.clone()
            } else {
                break;
            };
            bare.begin_again()?;
            others.push(Stretching::of(&mut bare, start, &deviations, None, Some(&path))?);
        }
        Ok(spectrum(&bare, path, &others, is_driven))
    }
}

/// A start beside the one of a run.
fn displaced<V: Vector>(start: &State<V>, copy: u64, [q, p]: [f64; 2]) -> State<V> {
    let (mut copied, degrees) = (start.clone(), start.q.components().len());
    // The first directions are those of deviations.
    let direction = start::direction((1 << 16) + copy, 2 * degrees);
    let (along_q, along_p) = direction.split_at(degrees);
    for (vector, along, size) in [(&mut copied.q, along_q, q), (&mut copied.p, along_p, p)] {
        let size = NEAR * if size > 0.0 { size } else { q.max(p) };
        vector.components_mut().iter_mut().zip(along).for_each(|(x, along)| *x += size * along);
    }
    copied
}

/// How the deviations of one path grew.
struct Stretching {
    /// `ln R_jj` from the start to each of the ends of batches.
    logs: Vec<Vec<f64>>,
    /// The path there; of a copy nothing is kept.
    nodes: Vec<Vec<f64>>,
    /// The batches after which a copy has left the path.
    left: Option<usize>,
    /// The largest coordinate and the largest momentum on the path.
    sizes: [f64; 2],
    series: Option<SpectrumSeries>,
}

impl Stretching {
    fn of<H: Discretized<E>, E, N: Noise, C: StateSum<f64>>(
        bare: &mut StepsOnly<'_, H, E, N, C>,
        start: State<H::Vector>,
        deviations: &[Vec<f64>],
        stride: Option<u64>,
        beside: Option<&Self>,
    ) -> Result<Self, Error> {
        let grid = bare.grid;
        let mut frame = Frame::new(bare.system, bare.h, &start, deviations)?;
        let mut growth = Self {
            logs: Vec::new(),
            nodes: Vec::new(),
            left: None,
            sizes: [&start.q, &start.p].map(largest),
            series: stride.map(|_| SpectrumSeries::default()),
        };
        let mut logs = vec![0.0; deviations.len()];
        let (mut last, mut interval) = (0, 1);
        // Rounded up: the last batch ends at the last node.
        let batch_end =
            |batch: usize| (grid.steps as u128 * (batch as u128 + 1)).div_ceil(BATCHES as u128) as u64;
        bare.run_from(start, |whole, step| {
            let node = step.interval.step + 1;
            let StepToTake { state, interval: step_interval, noise, dw } = step;
            frame.take_step(whole, StepToTake { state: &mut *state, interval: step_interval, noise, dw })?;
            for (size, vector) in growth.sizes.iter_mut().zip([&state.q, &state.p]) {
                *size = size.max(largest(vector));
            }
            let is_batch = batch_end(growth.logs.len()) == node;
            let is_recorded =
                stride.is_some_and(|stride| node == grid.steps || (stride > 0 && node % stride == 0));
            if is_batch || is_recorded || node - last >= interval || frame.has_grown(LONG) {
                let apart = frame.orthonormalise(&mut logs, node - 1, grid.time(node - 1))?;
                if apart > APART {
                    interval = (interval / 2).max(1);
                } else if apart < 0.5 * APART && node - last >= interval {
                    interval = (2 * interval).min(MOST);
                }
                last = node;
            }
            while growth.logs.len() < BATCHES && batch_end(growth.logs.len()) == node {
                let batch = growth.logs.len();
                growth.logs.push(logs.clone());
                match beside {
                    None => growth.nodes.push([state.q.components(), state.p.components()].concat()),
                    Some(path) if growth.left.is_none() && path.is_far(batch, state) => {
                        growth.left = Some(batch + 1);
                    }
                    Some(_) => {}
                }
            }
            if is_recorded && let Some(series) = &mut growth.series {
                let time = (grid.time(node) - grid.start).abs();
                series.times.push(grid.time(node));
                series.values.push(sorted(logs.iter().map(|log| log / time)));
            }
            Ok(())
        })?;
        Ok(growth)
    }

    /// `ln R_jj` over the whole run.
    fn last(&self) -> &[f64] {
        self.logs.last().map_or(&[], Vec::as_slice)
    }

    /// The standard error of a sum of gains by batches: the largest of those by 8, 16, … batches.
    fn error_by_batches(&self, column: usize) -> f64 {
        let error = |batches: usize| {
            let ends = self.logs.iter().skip(BATCHES / batches - 1).step_by(BATCHES / batches);
            let mut before = 0.0;
            let gains = ends.map(|logs| logs[column] - std::mem::replace(&mut before, logs[column]));
            deviation(gains.collect::<Vec<_>>().into_iter()) * (batches as f64).sqrt()
        };
        [8, 16, 32, 64].into_iter().map(error).fold(0.0, f64::max)
    }

    /// Whether gains change within the run, so that batches of them differ: not while the run is a part of a
    /// period.
    fn is_settled(&self) -> bool {
        let (mut means, mut before) = (BatchMeans::new(), 0.0);
        for log in self.logs.iter().filter_map(|logs| logs.first()) {
            means.add(log - std::mem::replace(&mut before, *log));
        }
        !means.standard_error().is_nan()
    }

    /// Whether a deviation grows faster than the square of the time: twice the time brings more than `ln 4`,
    /// in the mean over both.
    fn is_exponential(&self) -> bool {
        let mean = |batches: std::ops::Range<usize>| {
            let number = batches.len() as f64;
            batches.filter_map(|batch| self.logs.get(batch)?.first()).sum::<f64>() / number
        };
        mean(BATCHES / 2..BATCHES) - mean(BATCHES / 4..BATCHES / 2) > 2.0 * std::f64::consts::LN_2
    }

    /// Whether a state at the end of a batch is far from that of this path.
    fn is_far<V: Vector>(&self, batch: usize, state: &State<V>) -> bool {
        let (Some(node), [q, p]) = (self.nodes.get(batch), self.sizes) else { return false };
        let (ours, theirs) = (node.split_at(node.len() / 2), [&state.q, &state.p].map(Vector::components));
        let far = |ours: &[f64], theirs: &[f64], size: f64| {
            ours.iter().zip(theirs).any(|(a, b)| (a - b).abs() > FAR * size)
        };
        far(ours.0, theirs[0], q) || far(ours.1, theirs[1], p)
    }
}

/// The largest component.
fn largest<V: Vector>(vector: &V) -> f64 {
    vector.components().iter().fold(0.0, |largest, x| largest.max(x.abs()))
}

/// The largest first.
fn sorted(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(|a, b| b.total_cmp(a));
    values
}

/// The standard deviation of a sample.
fn deviation(sample: impl Iterator<Item = f64> + Clone) -> f64 {
    let number = sample.clone().count() as f64;
    let mean = sample.clone().sum::<f64>() / number;
    (sample.map(|x| Scalar::powi(x - mean, 2)).sum::<f64>() / (number - 1.0)).sqrt()
}

/// The spectrum of a path, with the errors that others give it.
fn spectrum<H: Discretized<E>, E, N: Noise, C: StateSum<f64>>(
    bare: &StepsOnly<'_, H, E, N, C>,
    path: Stretching,
    others: &[Stretching],
    is_driven: bool,
) -> Spectrum {
    let (system, grid) = (bare.system, bare.grid);
    let degrees = system.degrees_left(bare.start.q.components().len());
    let time = (grid.time(grid.steps) - grid.start).abs();
    let mut columns: Vec<usize> = (0..path.last().len()).collect();
    columns.sort_by(|a, b| path.last()[*b].total_cmp(&path.last()[*a]));
    let values: Vec<f64> = columns.iter().map(|column| path.last()[*column] / time).collect();
    let copies: Vec<Vec<f64>> =
        others.iter().map(|other| sorted(other.last().iter().map(|log| log / time))).collect();
    let by_batches = || columns.iter().map(|column| path.error_by_batches(*column) / time);
    let by_copies = |rank: usize| deviation(copies.iter().chain([&values]).map(move |values| values[rank]));
    let widened = |factor: f64| {
        by_batches().enumerate().map(|(rank, error)| error.max(factor * by_copies(rank))).collect()
    };
    let left: Option<Vec<usize>> = others.iter().map(|other| other.left).collect();
    let errors = match left.map(|left| left.into_iter().max()) {
        _ if others.is_empty() || grid.steps < BATCHES as u64 || !path.is_settled() => None,
        _ if is_driven => Some(widened(1.0)),
        Some(Some(left)) if 2 * left <= BATCHES => {
            Some(widened((BATCHES as f64 / (BATCHES - left) as f64).sqrt()))
        }
        _ if path.is_exponential() => None,
        _ => Some(by_batches().collect()),
    };
    let kind = H::KIND;
    let has_pairs = H::PROPERTIES.is_variational && !kind.is_forced && !kind.has_noise_forces;
    // Lengths in the space around a manifold do not measure its volume: the sum is zero up to 1/T.
    let is_flat = system.manifold().is_none();
    let is_known = has_pairs && values.len() == 2 * degrees;
    let sum: f64 = values.iter().sum();
    let rate = if kind.is_conformal { system.friction_rate() * bare.h.signum() } else { 0.0 };
    let pairs = values.iter().zip(values.iter().rev());
    Spectrum {
        pair_defect: is_known
            .then(|| pairs.map(|(a, b)| (a + b - sum / degrees as f64).abs()).fold(0.0, f64::max)),
        sum_defect: (is_known && is_flat).then_some(sum + degrees as f64 * rate),
        values,
        errors,
        time,
        copies,
        series: path.series,
    }
}
