//! Autocorrelation functions, correlation times and errors.

use super::SeriesError;
use super::transform::lagged_products;
use crate::algebra::state::{State, Vector};
use crate::error::PathError;
use crate::path::trajectory::Trajectory;
use crate::scheme::system::Hamiltonian;

/// How many correlation times the sum over the autocorrelation function goes (A. Sokal, "Monte Carlo methods in statistical mechanics: foundations and new
/// algorithms", in *Functional Integration*, 1997, section 3): the rest of the sum is about `e^{-5}` of it, and the noise of the tail is excluded.
const WINDOW: f64 = 5.0;

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
    /// The integrated autocorrelation time, in time units: `τ = Δ (1/2 + Σ ρ)` up to [`Autocorrelation::window`].
    pub time: f64,
    /// Its standard error (U. Wolff, "Monte Carlo errors with less errors", Comput. Phys. Commun. 156, 2004, equation 42).
    pub time_error: f64,
    /// Number of lags in the sum: the least that covers five correlation times ([`time`](Autocorrelation::time)).
    pub window: usize,
    /// The standard error of the mean: `√(2 τ σ² / N Δ)`.
    pub standard_error: f64,
}

impl Autocorrelation {
    /// The autocorrelation of values at equal distances `spacing` in time.
    ///
    /// # Errors
    /// [`SeriesError`] where the series is too short, constant, or not finite.
    pub fn of(values: &[f64], spacing: f64) -> Result<Self, SeriesError> {
        Self::of_many(&[values], spacing)
    }

    /// The autocorrelation of several independent series of the same length and law, such as the paths of an ensemble.
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
        // In units of powers of two, of the values and of their deviations: neither sums nor squares overflow or vanish.
        let of_values = unit(all().copied());
        let mean = all().map(|x| x / of_values).sum::<f64>() / count as f64;
        let deviation = |x: &f64| x / of_values - mean;
        let of_deviations = unit(all().map(deviation));
        let centred: Vec<Vec<f64>> = series
            .iter()
            .map(|values| values.as_ref().iter().map(|x| deviation(x) / of_deviations).collect())
            .collect();
        let products = lagged_products(centred.iter().map(Vec::as_slice), length);
        let at = |lag: usize| products[lag] / (series.len() * (length - lag)) as f64;
        let variance = at(0);
        let rho: Vec<f64> = (0..length).map(|lag| at(lag) / variance).collect();
        let (window, time) = window(&rho).ok_or(SeriesError::Short { length })?;
        // What the mean takes from the correlations (equation 49 of Wolff).
        let time = time * (1.0 + (2 * window + 1) as f64 / count as f64);
        let time_error = time * (4.0 / count as f64 * (window as f64 + 0.5 - time).max(0.5)).sqrt();
        Ok(Self {
            mean: mean * of_values,
            variance: variance * (of_deviations * of_values).powi(2),
            function: ByLag { spacing, values: rho },
            time: time * spacing,
            time_error: time_error * spacing,
            window,
            standard_error: (2.0 * time * variance / count as f64).sqrt() * of_deviations * of_values,
        })
    }
}

/// The power of two below the largest of some numbers.
fn unit(values: impl Iterator<Item = f64>) -> f64 {
    let largest = values.map(f64::abs).fold(0.0, f64::max);
    f64::from_bits(largest.to_bits() & f64::INFINITY.to_bits()).max(f64::MIN_POSITIVE)
}

/// The first lag that is [`WINDOW`] correlation times, and that time in samples; `None` unless it is within a tenth of the series.
fn window(rho: &[f64]) -> Option<(usize, f64)> {
    let mut time = 0.5;
    for (lag, rho) in rho.iter().enumerate().take(rho.len() / 10).skip(1) {
        time += rho;
        // Values that alternate have a time below that of independent ones.
        if lag as f64 >= WINDOW * time.max(0.5) {
            return Some((lag, time.max(0.0)));
        }
    }
    None
}

impl<V: Vector, E> Trajectory<V, E> {
    /// The autocorrelation of a function of the state along the recorded nodes.
    ///
    /// # Errors
    /// As [`Trajectory::time_scale`]; [`PathError::Series`] where the path is too short for it.
    pub fn autocorrelation(
        &self,
        observable: impl FnMut(&State<V>) -> f64,
    ) -> Result<Autocorrelation, PathError> {
        let spacing = self.spacing()?;
        let values: Vec<f64> = self.iter().map(observable).collect();
        Autocorrelation::of(&values, spacing).map_err(PathError::Series)
    }

    /// `⟨v(0) · v(t)⟩ / d` with the velocities `v = ∂H/∂p`: the average over all pairs of recorded nodes and over the degrees of freedom. Its integral over
    /// time is the diffusion coefficient.
    ///
    /// # Errors
    /// As [`Trajectory::time_scale`].
    pub fn velocity_autocorrelation<H: Hamiltonian<Vector = V>>(
        &self,
        system: &H,
    ) -> Result<ByLag, PathError> {
        let spacing = self.spacing()?;
        let velocities: Vec<V> = self.iter().map(|state| system.energy_gradient(state).p).collect();
        let series = by_degree(&velocities);
        let mut values = lagged_products(series.iter().map(Vec::as_slice), velocities.len());
        for (lag, value) in values.iter_mut().enumerate() {
            *value /= ((velocities.len() - lag) * series.len()) as f64;
        }
        Ok(ByLag { spacing, values })
    }

    /// `⟨|q(t) - q(0)|²⟩`: the average over all pairs of recorded nodes, summed over the degrees of freedom. By Fourier transforms, of the order
    /// `N log N` (G. R. Kneller, V. Keiner, M. Kneller, M. Schiller, "nMOLDYN: a program package for a neutron scattering oriented analysis of molecular dynamics
    /// simulations", Comput. Phys. Commun. 91, 1995).
    ///
    /// # Errors
    /// As [`Trajectory::time_scale`].
    pub fn mean_square_displacement(&self) -> Result<ByLag, PathError> {
        let spacing = self.spacing()?;
        let coordinates: Vec<V> = self.iter().map(|state| state.q.clone()).collect();
        let (mut series, length) = (by_degree(&coordinates), coordinates.len());
        // Displacements do not see the origin; squares are the smaller for one in the middle.
        for values in &mut series {
            let mean = values.iter().sum::<f64>() / length as f64;
            values.iter_mut().for_each(|x| *x -= mean);
        }
        let products = lagged_products(series.iter().map(Vec::as_slice), length);
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

    /// Time between recorded nodes.
    fn spacing(&self) -> Result<f64, PathError> {
        self.time_scale().map(|scale| scale.step_size())
    }
}

/// The series of each degree of freedom.
fn by_degree<V: Vector>(vectors: &[V]) -> Vec<Vec<f64>> {
    let degrees = vectors.first().map_or(0, |vector| vector.components().len());
    (0..degrees).map(|i| vectors.iter().map(|vector| vector.components()[i]).collect()).collect()
}
