//! Functions on T_λ: the quadrature points of the λ-antiderivative.
//!
//! Tested by `wzvi-runtime/src/calculus/tests.rs`.

use super::{DomainError, TimeScale};

/// A function on T_λ, the points `t_{i,λ} = (1 - λ) t_i + λ t_{i+1}`, `i = 0 … N-1`.
///
/// `λ = 0` is the left rule of [`DeltaPlus`](crate::scheme::embedding::DeltaPlus), `1/2` the mid-point rule,
/// `1` (which the paper leaves out) the right rule of the adjoint.
#[derive(Clone, Debug, PartialEq)]
pub struct Lambda<V> {
    scale: TimeScale,
    lambda: f64,
    values: Vec<V>,
}

impl<V> Lambda<V> {
    /// The function with these values, one per step.
    ///
    /// # Errors
    /// [`DomainError::Lambda`] unless `0 <= lambda <= 1`, [`DomainError::Length`] unless there are `N`
    /// values.
    pub fn new(scale: TimeScale, lambda: f64, values: Vec<V>) -> Result<Self, DomainError> {
        if !(0.0..=1.0).contains(&lambda) {
            return Err(DomainError::Lambda(lambda));
        }
        let (expected, got) = (scale.steps(), values.len());
        if expected == got {
            Ok(Self { scale, lambda, values })
        } else {
            Err(DomainError::Length { expected, got })
        }
    }

    /// The restriction of a function of time to T_λ.
    ///
    /// # Errors
    /// [`DomainError::Lambda`] unless `0 <= lambda <= 1`.
    pub fn sample(scale: TimeScale, lambda: f64, mut f: impl FnMut(f64) -> V) -> Result<Self, DomainError> {
        let h = scale.step_size();
        let values = (0..scale.steps()).map(|i| f(scale.start() + (i as f64 + lambda) * h));
        Self::new(scale, lambda, values.collect())
    }

    /// `λ`
    pub fn lambda(&self) -> f64 {
        self.lambda
    }

    /// Interval and steps.
    pub fn scale(&self) -> TimeScale {
        self.scale
    }

    /// The values in the order of the points.
    pub fn values(&self) -> &[V] {
        &self.values
    }

    /// `ι_{0,λ}[f](t)`: the function as one that is constant on each `[t_i, t_{i+1}[`; `None` outside
    /// `[a, b[`.
    pub fn step_function(&self, t: f64) -> Option<&V> {
        let position = (t - self.scale.start()) / self.scale.step_size();
        // NaN is outside, too.
        if position >= 0.0 { self.values.get(position as usize) } else { None }
    }
}
