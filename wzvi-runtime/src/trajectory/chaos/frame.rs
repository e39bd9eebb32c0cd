//! Deviations from a path, which each step multiplies by its derivative.

use std::f64::consts::LN_2;

use crate::algebra::scalar::{Dual, Scalar};
use crate::algebra::state::{State, Vector, copy_state};
use crate::algebra::state_sum::StateSum;
use crate::error::{ConfigError, DerivativeError, StepError, StepFailure};
use crate::increments::Noise;
use crate::scheme::system::{Discretized, as_they_are};
use crate::trajectory::Error;
use crate::trajectory::retry::Subdivision;
use crate::trajectory::simulate::{COLUMNS, Past, SharedStep, TangentColumns};
use crate::trajectory::steps::StepToTake;

/// `x · y`
pub(super) fn dot(x: &[f64], y: &[f64]) -> f64 {
    x.iter().zip(y).map(|(x, y)| x * y).sum()
}

/// Subtracts from a vector its parts along orthonormal others, twice: after that it is orthogonal to rounding
/// (L. Giraud, J. Langou, M. Rozložník, "The loss of orthogonality in the Gram-Schmidt orthogonalization
/// process", Comput. Math. Appl. 50, 2005). Returns its length then.
pub(super) fn orthogonalise(frame: &[Vec<f64>], vector: &mut [f64]) -> f64 {
    for _ in 0..2 {
        for unit in frame {
            let part = dot(unit, vector);
            vector.iter_mut().zip(unit).for_each(|(x, unit)| *x -= part * unit);
        }
    }
    dot(vector, vector).sqrt()
}

/// Deviations from a path.
pub(super) struct Frame<'a, H: Discretized<E>, E> {
    system: &'a H,
    /// The size of the present steps.
    h: f64,
    blocks: Vec<TangentColumns<H, E, f64, COLUMNS>>,
    shared: SharedStep<H, E, COLUMNS>,
    /// The deviations as lists, for what is not done in blocks.
    lists: Vec<Vec<f64>>,
    dw: Vec<Dual<COLUMNS>>,
    /// The state before a step, and one whose coordinates are scratch.
    before: State<H::Vector>,
    end: H::Vector,
}

impl<'a, H: Discretized<E>, E> Frame<'a, H, E> {
    /// Deviations of a run in steps of size `h`.
    ///
    /// # Errors
    /// The errors of what is prepared of a system.
    pub(super) fn new(
        system: &'a H,
        h: f64,
        start: &State<H::Vector>,
        deviations: &[Vec<f64>],
    ) -> Result<Self, ConfigError> {
        let zeros = || vec![Dual::default(); start.q.components().len()];
        let block = |some: &[Vec<f64>]| {
            let mut columns = TangentColumns::new(system, &as_they_are, h, [zeros(), zeros()])?;
            some.iter().enumerate().for_each(|(column, deviation)| columns.put(column, deviation));
            Ok(columns)
        };
        Ok(Self {
            system,
            h,
            blocks: deviations.chunks(COLUMNS).map(block).collect::<Result<_, ConfigError>>()?,
            shared: SharedStep::new(deviations.len()),
            lists: deviations.to_vec(),
            dw: Vec::new(),
            before: start.clone(),
            end: start.q.clone(),
        })
    }

    /// The number of deviations.
    pub(super) fn count(&self) -> usize {
        self.lists.len()
    }

    /// Takes a step of the path, and multiplies the deviations by its derivative.
    ///
    /// # Errors
    /// If the step has no solution, another one in dual numbers, or no finite derivative.
    pub(super) fn take_step<N: Noise, C: StateSum<f64>>(
        &mut self,
        whole: &mut Subdivision<'_, H, E, C>,
        step: StepToTake<'_, H::Vector, N>,
    ) -> Result<(), Error> {
        let StepToTake { state, interval, noise, dw: step_dw } = step;
        if whole.size() != self.h {
            self.h = whole.size();
            for columns in &mut self.blocks {
                columns.resize(self.system, &as_they_are, self.h, interval.step)?;
            }
        }
        copy_state(&mut self.before, state);
        let taken = whole.take_step(StepToTake { state: &mut *state, interval, noise, dw: &mut *step_dw })?;
        self.shared.begin();
        self.dw.clear();
        self.dw.extend(step_dw.iter().map(|dw| Dual::constant(*dw)));
        let Self { system, h, blocks, shared, dw, before, end, .. } = self;
        let (step, t, h) = (interval.step, before.t, *h);
        let past = Past { step, ends: [before, state], dw: &*step_dw, memory: whole.memory(taken) };
        for (block, columns) in blocks.iter_mut().enumerate() {
            columns.multiply(shared, system, &past, dw, end).map_err(|cause| match cause {
                // The step itself has a finite end.
                StepFailure::NonFinite => lost(COLUMNS * block, f64::INFINITY, step, t),
                cause => StepError { step, t, h, cause }.into(),
            })?;
            columns.rescale();
        }
        Ok(())
    }

    /// Whether a deviation has become longer or shorter by more than this factor since it was last of length
    /// one.
    pub(super) fn has_grown(&self, factor: f64) -> bool {
        self.blocks.iter().enumerate().any(|(block, columns)| {
            (0..COLUMNS.min(self.count() - COLUMNS * block)).any(|column| {
                let size = columns.size(column);
                size > factor || size * factor < 1.0
            })
        })
    }

    /// The natural logarithm of the length of a deviation.
    pub(super) fn ln_length(&self, number: usize) -> f64 {
        let (columns, column) = (&self.blocks[number / COLUMNS], number % COLUMNS);
        let square: f64 =
            columns.q.iter().chain(&columns.p).map(|x| Scalar::powi(x.derivative[column], 2)).sum();
        0.5 * Scalar::ln(square) + columns.exponents[column] as f64 * LN_2
    }

    /// The deviations as unit vectors; NaN where one has no length.
    pub(super) fn units(&mut self) -> &[Vec<f64>] {
        for (number, list) in self.lists.iter_mut().enumerate() {
            let (columns, column) = (&self.blocks[number / COLUMNS], number % COLUMNS);
            for (x, number) in list.iter_mut().zip(columns.q.iter().chain(&columns.p)) {
                *x = number.derivative[column];
            }
            let length = dot(list, list).sqrt();
            list.iter_mut().for_each(|x| *x /= length);
        }
        &self.lists
    }

    /// Makes the deviations orthonormal, `Δ = Q R`, and adds the logarithms of the diagonal of `R` to `logs`.
    /// Returns the largest of these minus the smallest.
    ///
    /// # Errors
    /// [`DerivativeError`] where one is a sum of multiples of those before it.
    pub(super) fn orthonormalise(&mut self, logs: &mut [f64], step: u64, t: f64) -> Result<f64, Error> {
        let mut lengths: Vec<f64> = (0..self.count()).map(|number| self.ln_length(number)).collect();
        self.units();
        for (number, ln_length) in lengths.iter_mut().enumerate() {
            let (before, [list, ..]) = self.lists.split_at_mut(number) else { continue };
            let rest = orthogonalise(before, list);
            *ln_length += Scalar::ln(rest);
            if !ln_length.is_finite() {
                return Err(lost(number, *ln_length, step, t));
            }
            list.iter_mut().for_each(|x| *x /= rest);
            self.blocks[number / COLUMNS].put(number % COLUMNS, list);
        }
        logs.iter_mut().zip(&lengths).for_each(|(log, length)| *log += length);
        let (least, most) =
            lengths.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), length| {
                (length.min(least), length.max(most))
            });
        Ok(most - least)
    }
}

/// A deviation without a length or a direction.
fn lost(number: usize, ln_size: f64, step: u64, t: f64) -> Error {
    Box::new(DerivativeError { by: format!("deviation {number}"), ln_size, step, t }).into()
}
