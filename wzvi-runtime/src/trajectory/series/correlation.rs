//! Autocorrelation functions, correlation times and errors.

use super::SeriesError;
use super::transform::{lagged_products, spectrum};
use crate::algebra::scalar::Scalar;
use crate::algebra::state::{State, Vector};
use crate::calculus::TimeScale;
use crate::scheme::system::Hamiltonian;
use crate::trajectory::recorded::PathError;
use crate::trajectory::recorded::Trajectory;

/// Correlations have ended where the mean of `ρ²` over the second half of the window is this many times what
/// it is without correlations, or less. One is noise alone. A shorter part of the window, or more noise,
/// would end it where `ρ` changes its sign.
const NOISE: f64 = 1.2;

/// The shortest window: half of it has two lags, so that waves that are zero at every second value do not
/// seem to have ended.
const SHORTEST: usize = 4;

/// Values that belong to times between two nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct ByLag {
    /// Time from one value to the next.
    pub spacing: f64,
    /// From lag 0 on.
    pub values: Vec<f64>,
}

impl ByLag {
    /// Pairs of time and value.
    pub fn points(&self) -> impl Iterator<Item = (f64, f64)> {
        self.values.iter().enumerate().map(|(i, &value)| (i as f64 * self.spacing, value))
    }
}

/// The autocorrelation of a stationary series, and the error of the mean that follows from it.
#[derive(Clone, Debug, PartialEq)]
pub struct Autocorrelation {
    /// The mean of all values.
    pub mean: f64,
    /// Their variance.
    pub variance: f64,
    /// `ρ(t)`, from `ρ(0) = 1` on.
    pub function: ByLag,
    /// The integrated autocorrelation time, in time units: `τ = Δ (1/2 + Σ ρ)` up to
    /// [`Autocorrelation::window`], the last term by half. Where correlations cancel, as those of the
    /// velocity of a bound particle, it is zero up to its error, and may come out negative.
    pub time: f64,
    /// Its standard error, by the spectrum of the series: that of correlations that oscillate, too
    /// ([`Autocorrelation::integral`]).
    pub time_error: f64,
    /// Number of lags in the sum: in its second half, the correlations are not larger than their errors.
    pub window: usize,
    /// The standard error of the mean: `√(2 τ σ² / N Δ)`, with the error of `τ` where that is larger.
    pub standard_error: f64,
    spectrum: PowerSpectrum,
}

impl Autocorrelation {
    /// The autocorrelation of values at equal distances `spacing` in time.
    ///
    /// # Errors
    /// [`SeriesError`] where the series is too short, constant, or not finite.
    pub fn of(values: &[f64], spacing: f64) -> Result<Self, SeriesError> {
        Self::of_many(&[values], spacing)
    }

    /// The autocorrelation of several independent series of the same length and law, such as the paths of an
    /// ensemble.
    ///
    /// # Errors
    /// As [`Autocorrelation::of`], and for series of different lengths.
    pub fn of_many<T: AsRef<[f64]>>(series: &[T], spacing: f64) -> Result<Self, SeriesError> {
        let (length, spacing) = (series.first().map_or(0, |values| values.as_ref().len()), spacing.abs());
        for values in series {
            let values = values.as_ref();
            if values.len() != length {
                return Err(SeriesError::Lengths { expected: length, got: values.len() });
            }
            if let Some(index) = values.iter().position(|value| !value.is_finite()) {
                return Err(SeriesError::NonFinite { index });
            }
        }
        let count = length * series.len();
        if length < 2 {
            return Err(SeriesError::Short { length });
        }
        let all = || series.iter().flat_map(|values| values.as_ref());
        if all().zip(all().skip(1)).all(|(value, next)| value == next) {
            return Err(SeriesError::Constant);
        }
        // In units of powers of two, of the values and of their deviations: neither sums nor squares overflow
        // or vanish.
        let of_values = unit(all().copied());
        let mean = all().map(|x| x / of_values).sum::<f64>() / count as f64;
        let deviation = |x: &f64| x / of_values - mean;
        let of_deviations = unit(all().map(deviation));
        let centred: Vec<Vec<f64>> = series
            .iter()
            .map(|values| values.as_ref().iter().map(|x| deviation(x) / of_deviations).collect())
            .collect();
        let power = spectrum(centred.iter().map(Vec::as_slice), length);
        let products = lagged_products(&power, length);
        let at = |lag: usize| products[lag] / (series.len() * (length - lag)) as f64;
        let variance = at(0);
        let rho: Vec<f64> = (0..length).map(|lag| at(lag) / variance).collect();
        let window = window(&rho, count).ok_or(SeriesError::Short { length })?;
        // The factor corrects the bias from the estimated mean (equation 49 of Wolff).
        let time = to_lag(&rho, window) * (1.0 + (2 * window) as f64 / count as f64);
        let spectrum = PowerSpectrum::new(&power, variance, series.len(), length);
        let time_error = spectrum.error(window, time);
        Ok(Self {
            mean: mean * of_values,
            variance: variance * Scalar::powi(of_deviations * of_values, 2),
            function: ByLag { spacing, values: rho },
            time: time * spacing,
            time_error: time_error * spacing,
            window,
            standard_error: (2.0 * time.max(time_error) * variance / count as f64).sqrt()
                * of_deviations
                * of_values,
            spectrum,
        })
    }

    /// The integral of the autocorrelation function up to a lag (time units, to the nearest multiple of the
    /// spacing), by the trapezoidal rule, with its error. Times the variance it is the Green-Kubo integral up
    /// to there: of a velocity, the diffusion coefficient once it has stopped to change with the lag.
    ///
    /// # Errors
    /// [`SeriesError::Lag`] for a lag that is negative, or longer than the series.
    pub fn integral(&self, lag: f64) -> Result<LagIntegral, SeriesError> {
        let ByLag { spacing, values } = &self.function;
        let longest = (values.len() - 1) as f64 * spacing;
        if !(0.0..=longest).contains(&lag) {
            return Err(SeriesError::Lag { lag, longest });
        }
        let lag = (lag / spacing).round() as usize;
        let count = self.spectrum.count as f64;
        let value = to_lag(values, lag) + self.time / spacing * (2 * lag) as f64 / count;
        Ok(LagIntegral { value: value * spacing, error: self.spectrum.error(lag, value) * spacing })
    }
}

/// The integral of an autocorrelation function up to a lag.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LagIntegral {
    /// In time units.
    pub value: f64,
    /// Its standard error.
    pub error: f64,
}

/// `1/2 + Σ ρ` up to a lag, the last term by half: the integral by the trapezoidal rule, in samples.
fn to_lag(rho: &[f64], lag: usize) -> f64 {
    rho[..=lag].iter().sum::<f64>() - 0.5 * (rho[0] + rho[lag])
}

/// The power spectrum of a series, from which errors of sums over its autocorrelation function follow.
///
/// An autocovariance is a cosine transform of the spectrum, and powers at different frequencies are
/// independent, of exponential laws about their means `S`. With `K(ω) = 1/2 + Σ cos ωt` up to the lag, the
/// last term by half, the integral `τ` of the autocorrelation function has the variance `(2/N) ∫ S² (K - τ)²
/// dω/2π` in units of the variance of the series (M. S. Bartlett, J. R. Stat. Soc. Suppl. 8, 1946). `S²` is
/// estimated by half of the square of the power; by `m` powers added up, in `m` series, by their square over
/// `m (m + 1)`.
#[derive(Clone, Debug, PartialEq)]
struct PowerSpectrum {
    /// Powers from 0 to the highest frequency, over the number of values and their variance.
    powers: Vec<f64>,
    /// Number of series, and of values in all of them.
    series: usize,
    count: usize,
}

impl PowerSpectrum {
    fn new(power: &[f64], variance: f64, series: usize, length: usize) -> Self {
        let count = series * length;
        let powers = power.iter().take(power.len() / 2 + 1);
        Self { powers: powers.map(|power| power / (count as f64 * variance)).collect(), series, count }
    }

    /// The standard error of the sum up to a lag, which is `time`, in samples.
    fn error(&self, lag: usize, time: f64) -> f64 {
        let half = self.powers.len() - 1;
        let squares = self.powers.iter().enumerate().map(|(k, power)| {
            let omega = std::f64::consts::PI * k as f64 / half as f64;
            let kernel = if k == 0 {
                lag as f64
            } else {
                0.5 * Scalar::sin(lag as f64 * omega) / Scalar::tan(0.5 * omega)
            };
            // Other frequencies have a negative one of the same power.
            let times = if k == 0 || k == half { 1.0 } else { 2.0 };
            times * Scalar::powi(power * (kernel - time), 2)
        });
        let series = self.series as f64;
        let per_series = (self.count / self.series) as f64;
        (2.0 * squares.sum::<f64>() / ((series + 1.0) * per_series * (2 * half) as f64)).sqrt()
    }
}

/// The power of two below the largest of some numbers.
fn unit(values: impl Iterator<Item = f64>) -> f64 {
    let largest = values.map(f64::abs).fold(0.0, f64::max);
    f64::from_bits(largest.to_bits() & f64::INFINITY.to_bits()).max(f64::MIN_POSITIVE)
}

/// The number of lags after which correlations have ended; `None` unless it is within a tenth of all values,
/// and a quarter of a series.
/// Far from zero, `ρ` of `count` values has the variance `(1 + 2 Σ ρ²) / N` (Bartlett's): squares, so that
/// nothing cancels in waves, as it does in `Σ ρ`, which would end the window in the first of them.
fn window(rho: &[f64], count: usize) -> Option<usize> {
    let (longest, count) = ((rho.len() / 4).min(count / 10), count as f64);
    // Up to each lag.
    let (mut sums, mut sum) = (Vec::new(), 0.0);
    for (lag, rho) in rho.iter().enumerate().take(longest) {
        sum += rho * rho;
        sums.push(sum);
        if lag >= SHORTEST {
            let half = lag / 2;
            let mean = (sum - sums[half - 1]) / (lag - half + 1) as f64;
            if mean * count <= NOISE * (2.0 * sum - 1.0) {
                return Some(lag);
            }
        }
    }
    None
}

impl<V: Vector, E> Trajectory<V, E> {
    /// The autocorrelation of a function of the state along the recorded nodes. Where the interval before the
    /// last node is shorter than the others, that node is left out.
    ///
    /// # Errors
    /// [`PathError::Empty`] for a path without steps, [`PathError::Uneven`] where `record_at` added nodes;
    /// [`PathError::Series`] where the path is too short for it.
    pub fn autocorrelation(
        &self,
        observable: impl FnMut(&State<V>) -> f64,
    ) -> Result<Autocorrelation, PathError> {
        let (nodes, spacing) = self.spaced()?;
        let values: Vec<f64> = nodes.iter().map(observable).collect();
        Autocorrelation::of(&values, spacing).map_err(PathError::Series)
    }

    /// `⟨v(0) · v(t)⟩ / d` with the velocities `v = ∂H/∂p`: the average over all pairs of recorded nodes and
    /// over the degrees of freedom. Its integral over time is the diffusion coefficient.
    ///
    /// # Errors
    /// As [`Trajectory::autocorrelation`].
    pub fn velocity_autocorrelation<H: Hamiltonian<Vector = V>>(
        &self,
        system: &H,
    ) -> Result<ByLag, PathError> {
        let (nodes, spacing) = self.spaced()?;
        let velocities: Vec<V> = nodes.iter().map(|state| system.energy_gradient(state).p).collect();
        let series = by_degree(&velocities);
        let power = spectrum(series.iter().map(Vec::as_slice), velocities.len());
        let mut values = lagged_products(&power, velocities.len());
        for (lag, value) in values.iter_mut().enumerate() {
            *value /= ((velocities.len() - lag) * series.len()) as f64;
        }
        Ok(ByLag { spacing, values })
    }

    /// `⟨|q(t) - q(0)|²⟩`: the average over all pairs of recorded nodes, summed over the degrees of freedom.
    /// By Fourier transforms, of the order `N log N` (G. R. Kneller, V. Keiner, M. Kneller, M. Schiller,
    /// "nMOLDYN: a program package for a neutron scattering oriented analysis of molecular dynamics
    /// simulations", Comput. Phys. Commun. 91, 1995).
    ///
    /// # Errors
    /// As [`Trajectory::autocorrelation`].
    pub fn mean_square_displacement(&self) -> Result<ByLag, PathError> {
        let (nodes, spacing) = self.spaced()?;
        let coordinates: Vec<V> = nodes.iter().map(|state| state.q.clone()).collect();
        let (mut series, length) = (by_degree(&coordinates), coordinates.len());
        // Displacements do not see the origin; squares are the smaller for one in the middle.
        for values in &mut series {
            let mean = values.iter().sum::<f64>() / length as f64;
            values.iter_mut().for_each(|x| *x -= mean);
        }
        let products = lagged_products(&spectrum(series.iter().map(Vec::as_slice), length), length);
        let square = |i: usize| series.iter().map(|values| values[i] * values[i]).sum::<f64>();
        let mut squares = 2.0 * (0..length).map(square).sum::<f64>();
        let mut values = Vec::with_capacity(length);
        for (lag, product) in products.iter().enumerate() {
            if lag > 0 {
                squares -= square(lag - 1) + square(length - lag);
            }
            values.push((squares - 2.0 * product) / (length - lag) as f64);
        }
        // Exactly, where the rest is rounding.
        values[0] = 0.0;
        Ok(ByLag { spacing, values })
    }

    /// The recorded nodes at equal distances in time, and that distance.
    fn spaced(&self) -> Result<(&[State<V>], f64), PathError> {
        let nodes = self.even()?;
        let [first, .., last] = nodes else { return Err(PathError::Empty) };
        Ok((nodes, TimeScale::new(first.t, last.t, nodes.len() - 1)?.step_size()))
    }
}

/// The series of each degree of freedom.
fn by_degree<V: Vector>(vectors: &[V]) -> Vec<Vec<f64>> {
    let degrees = vectors.first().map_or(0, |vector| vector.components().len());
    (0..degrees).map(|i| vectors.iter().map(|vector| vector.components()[i]).collect()).collect()
}
