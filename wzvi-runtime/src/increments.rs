//! Sources of the increments of a path.
//!
//! A [`Noise`] fills in `ΔW_1 … ΔW_K` of each step. [`Increments`] are given numbers. Everything random is in
//! another module, so that a program without noise compiles no generator.
//!
//! Tested by `tests/paths/runs.rs`.

mod identity;

pub use crate::error::NoiseError;
use crate::ground::checksum::Checksum;
use crate::ground::digits::{computed, number};
use crate::scheme::plan::Plan;
pub use identity::Identity;

/// One step of a run, `[start + n h, start + (n + 1) h]`. Times are computed from the number of the step,
/// never accumulated. Noise belongs to these times: a run that continues another has the time where that one
/// ended as its `start`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Time at the start of the run, in the units of the Hamiltonian.
    pub start: f64,
    /// Step size, same units; negative in a backward run.
    pub h: f64,
    /// Number `n` of the step, from 0 at the start of the run.
    pub step: u64,
}

impl Interval {
    /// Time after `n` steps, `start + n h`.
    #[inline]
    pub fn time(&self, n: f64) -> f64 {
        self.start + n * self.h
    }

    /// Time at the start of the step.
    #[inline]
    pub fn begin(&self) -> f64 {
        self.time(self.step as f64)
    }

    /// Time at the end of the step.
    #[inline]
    pub fn end(&self) -> f64 {
        self.time(self.step as f64 + 1.0)
    }
}

/// A source of increments.
pub trait Noise {
    /// Called before the first step of each run, with the plan of the scheme (see
    /// [`Plan::truncates_increments`]), the step size, the number of processes and the time of the start.
    /// Sources that need none of this keep the default.
    ///
    /// # Errors
    /// [`NoiseError`] if the source cannot serve such a run.
    fn prepare(&mut self, plan: &Plan, h: f64, processes: usize, start: f64) -> Result<(), NoiseError> {
        let _ = (plan, h, processes, start);
        Ok(())
    }

    /// Writes the increments of one step, one per process, with variance `|h|` each if they are Wiener
    /// increments.
    ///
    /// Not called for a system that has neither noise nor a bath.
    ///
    /// # Errors
    /// [`NoiseError`]; the run ends there and keeps what it has.
    fn increments(&mut self, interval: &Interval, dw: &mut [f64]) -> Result<(), NoiseError>;

    /// Writes the increments of a last step that is shorter than the others: of size `h`, from the start of
    /// the step `interval` on.
    ///
    /// # Errors
    /// [`NoiseError`]; a source that keeps this default has none.
    fn increments_of_part(&mut self, interval: &Interval, h: f64, dw: &mut [f64]) -> Result<(), NoiseError> {
        let _ = dw;
        Err(no_shorter_step(
            interval,
            h,
            "for which this noise has no increments: implement `Noise::increments_of_part`, or",
        ))
    }

    /// Writes the increments between two times inside a step: those over the part `from` to `to` of it, as
    /// fractions between 0 and 1. The step begins where `interval` does and has the size `h`, which is less
    /// than that of `interval` for a [last step that is shorter](Noise::increments_of_part). Parts that fill
    /// a step add up to its increments.
    ///
    /// A last step is halved by it ([`Retry`](crate::trajectory::retry::Retry)), and a recorded path asks for
    /// [states between its nodes](crate::trajectory::recorded::Trajectory::at).
    ///
    /// # Errors
    /// [`NoiseError`]; a source that keeps this default does not know its path there.
    fn increments_within(
        &mut self,
        interval: &Interval,
        h: f64,
        [from, to]: [f64; 2],
        dw: &mut [f64],
    ) -> Result<(), NoiseError> {
        let _ = (interval, h, from, to, dw);
        Err(NoiseError::Setting(
            "this noise has no increments inside of a step: implement `Noise::increments_within`, or take `Wiener`, `StepNormals` or \
             `WongZakai`; a run records the states of its dense output, `.record_at([t])`, with any noise"
                .into(),
        ))
    }

    /// Writes the increments over the part `from` to `to`, as fractions, of a step whose size `h` is its own:
    /// that of a run by a [clock](crate::scheme::clock). The step begins at `interval.start` and has the
    /// number `interval.step`.
    ///
    /// By default those of its times. A source that numbers its steps takes the number.
    ///
    /// # Errors
    /// The errors of [`Noise::increments_within`].
    fn increments_of_own_size(
        &mut self,
        interval: &Interval,
        h: f64,
        part: [f64; 2],
        dw: &mut [f64],
    ) -> Result<(), NoiseError> {
        self.increments_within(&Interval { start: interval.start, h, step: 0 }, h, part, dw)
    }

    /// Whether [`Noise::increments`] also serves the halves of a step, their halves, and so on: intervals of
    /// size `h / 2^m` from the start of the run, numbered as steps of that size are. A run with
    /// [`Retry`](crate::trajectory::retry::Retry) needs that, and refuses other sources before its first
    /// step.
    ///
    /// The increments of the parts add up to those of the step. (`WongZakai` samples a velocity in each part,
    /// unless its sampling is exact: these do not.)
    fn is_divisible(&self) -> bool {
        false
    }

    /// The largest absolute value that an increment of a step of size `h` can have, after [`Noise::prepare`];
    /// infinite without truncation. Runs refuse implicit steps in which such an increment reaches a pole.
    fn largest_increment(&self, h: f64) -> f64 {
        let _ = h;
        f64::INFINITY
    }

    /// Goes to another path, so many further on among those of an ensemble; false for a source that has one
    /// path only.
    #[doc(hidden)]
    fn skip_paths(&mut self, _paths: u64) -> bool {
        false
    }

    /// The identity of this source, after [`Noise::prepare`]. A source that returns one guarantees that the
    /// increments of a step depend on the identity and the [`Interval`] alone, to the last bit, whatever was
    /// drawn before. An interrupted run can then resume with another source of the same identity.
    ///
    /// A source without this guarantee keeps the default; its runs take no checkpoints.
    fn identity(&self) -> Option<Identity> {
        None
    }
}

/// A last step that is shorter than the others, in a run whose noise serves whole steps alone, because of
/// `why`.
fn no_shorter_step(interval: &Interval, h: f64, why: &str) -> NoiseError {
    let [before, beyond] = [interval.begin(), interval.end()].map(computed);
    let [size, step] = [number(h), number(interval.h)];
    NoiseError::Setting(format!(
        "the last step is shorter ({size}) than the others ({step}), {why} add `.whole_steps()` to end at t = {beyond}, or end at t = {before}"
    ))
}

impl<N: Noise + ?Sized> Noise for &mut N {
    fn prepare(&mut self, plan: &Plan, h: f64, processes: usize, start: f64) -> Result<(), NoiseError> {
        (**self).prepare(plan, h, processes, start)
    }

    fn increments(&mut self, interval: &Interval, dw: &mut [f64]) -> Result<(), NoiseError> {
        (**self).increments(interval, dw)
    }

    fn increments_of_part(&mut self, interval: &Interval, h: f64, dw: &mut [f64]) -> Result<(), NoiseError> {
        (**self).increments_of_part(interval, h, dw)
    }

    fn increments_within(
        &mut self,
        interval: &Interval,
        h: f64,
        part: [f64; 2],
        dw: &mut [f64],
    ) -> Result<(), NoiseError> {
        (**self).increments_within(interval, h, part, dw)
    }

    fn increments_of_own_size(
        &mut self,
        interval: &Interval,
        h: f64,
        part: [f64; 2],
        dw: &mut [f64],
    ) -> Result<(), NoiseError> {
        (**self).increments_of_own_size(interval, h, part, dw)
    }

    fn is_divisible(&self) -> bool {
        (**self).is_divisible()
    }

    fn largest_increment(&self, h: f64) -> f64 {
        (**self).largest_increment(h)
    }

    fn identity(&self) -> Option<Identity> {
        (**self).identity()
    }
}

/// No noise: the default of a run of a deterministic system.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NoNoise;

impl Noise for NoNoise {
    fn increments(&mut self, _interval: &Interval, dw: &mut [f64]) -> Result<(), NoiseError> {
        if dw.is_empty() { Ok(()) } else { Err(NoiseError::Processes { expected: dw.len(), got: 0 }) }
    }

    fn identity(&self) -> Option<Identity> {
        Some(Identity::of("none"))
    }
}

/// Given increments, one row per step; the run starts at the first row.
///
/// From one `Vec` or array of numbers for one process, or of rows for several:
/// `Increments::from(vec![0.1, -0.2])`, `Increments::from([[0.1, 0.3], [-0.2, 0.0]])`.
#[derive(Clone, Debug, PartialEq)]
pub struct Increments {
    values: Vec<f64>,
    processes: usize,
    steps: usize,
    ragged: Option<NoiseError>,
}

impl Increments {
    /// Number of steps.
    pub fn steps(&self) -> usize {
        self.steps
    }

    /// Number of processes: the length of the first row.
    pub fn processes(&self) -> usize {
        self.processes
    }

    fn from_rows<R: AsRef<[f64]>>(rows: &[R]) -> Self {
        let processes = rows.first().map_or(0, |row| row.as_ref().len());
        let ragged = rows.iter().map(|row| row.as_ref().len()).enumerate().find(|&(_, len)| len != processes);
        Self {
            values: rows.iter().flat_map(|row| row.as_ref()).copied().collect(),
            processes,
            steps: rows.len(),
            ragged: ragged.map(|(row, got)| NoiseError::Ragged { row, expected: processes, got }),
        }
    }

    fn check(&self, processes: usize) -> Result<(), NoiseError> {
        match &self.ragged {
            Some(error) => Err(error.clone()),
            // No rows at all fit any system, for no steps.
            None if self.processes == processes || self.steps == 0 => Ok(()),
            None => Err(NoiseError::Processes { expected: processes, got: self.processes }),
        }
    }
}

impl Noise for Increments {
    fn prepare(&mut self, _plan: &Plan, _h: f64, processes: usize, _start: f64) -> Result<(), NoiseError> {
        self.check(processes)
    }

    fn increments(&mut self, interval: &Interval, dw: &mut [f64]) -> Result<(), NoiseError> {
        self.check(dw.len())?;
        let first = usize::try_from(interval.step).ok().and_then(|step| step.checked_mul(self.processes));
        let row = first.and_then(|first| self.values.get(first..first.checked_add(self.processes)?));
        match row {
            Some(row) if row.len() == dw.len() => {
                if let Some(process) = row.iter().position(|value| !value.is_finite()) {
                    return Err(NoiseError::NonFinite { step: interval.step, process, value: row[process] });
                }
                dw.copy_from_slice(row);
                Ok(())
            }
            _ => Err(NoiseError::Exhausted { step: interval.step, available: self.steps }),
        }
    }

    /// A row belongs to a whole step: no law says what of it belongs to a shorter one.
    fn increments_of_part(&mut self, interval: &Interval, h: f64, _dw: &mut [f64]) -> Result<(), NoiseError> {
        Err(no_shorter_step(interval, h, "and given increments are those of whole steps:"))
    }

    /// By a checksum of the numbers.
    fn identity(&self) -> Option<Identity> {
        let mut checksum = Checksum::default();
        self.values.iter().for_each(|value| checksum.add(&value.to_bits().to_le_bytes()));
        let identity = Identity::of("Increments").with("steps", self.steps).with("processes", self.processes);
        Some(identity.with("checksum", checksum))
    }
}

impl From<Vec<f64>> for Increments {
    fn from(values: Vec<f64>) -> Self {
        Self { steps: values.len(), values, processes: 1, ragged: None }
    }
}

impl From<&[f64]> for Increments {
    fn from(values: &[f64]) -> Self {
        values.to_vec().into()
    }
}

impl<const STEPS: usize> From<[f64; STEPS]> for Increments {
    fn from(values: [f64; STEPS]) -> Self {
        values.to_vec().into()
    }
}

impl<const K: usize> From<Vec<[f64; K]>> for Increments {
    fn from(rows: Vec<[f64; K]>) -> Self {
        Self { processes: K, ..Self::from_rows(&rows) }
    }
}

impl<const K: usize> From<&[[f64; K]]> for Increments {
    fn from(rows: &[[f64; K]]) -> Self {
        Self { processes: K, ..Self::from_rows(rows) }
    }
}

impl<const K: usize, const STEPS: usize> From<[[f64; K]; STEPS]> for Increments {
    fn from(rows: [[f64; K]; STEPS]) -> Self {
        Self { processes: K, ..Self::from_rows(&rows) }
    }
}

impl From<Vec<Vec<f64>>> for Increments {
    fn from(rows: Vec<Vec<f64>>) -> Self {
        Self::from_rows(&rows)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(mut noise: impl Noise, processes: usize) -> Result<Vec<Vec<f64>>, NoiseError> {
        let mut dw = vec![0.0; processes];
        let row = |step| {
            noise.increments(&Interval { start: 0.0, h: 0.1, step }, &mut dw)?;
            Ok(dw.clone())
        };
        (0..2).map(row).collect()
    }

    #[test]
    fn every_form_of_the_same_numbers_is_the_same() {
        let expected = vec![vec![0.5, 1.0], vec![-0.5, 2.0]];
        let array = [[0.5, 1.0], [-0.5, 2.0]];
        for form in
            [Increments::from(array), array.to_vec().into(), array[..].into(), expected.clone().into()]
        {
            assert_eq!(rows(form, 2), Ok(expected.clone()));
        }
        assert_eq!(rows(Increments::from([0.5, -0.5]), 1), Ok(vec![vec![0.5], vec![-0.5]]));
        assert_eq!(Increments::from([0.5, -0.5]), Increments::from(vec![0.5, -0.5]));
    }

    #[test]
    fn what_does_not_fit_says_so() {
        assert_eq!(rows(Increments::from([0.5]), 1), Err(NoiseError::Exhausted { step: 1, available: 1 }));
        assert_eq!(rows(Increments::from([0.5, 0.5]), 2), Err(NoiseError::Processes { expected: 2, got: 1 }));
        let ragged = Increments::from(vec![vec![0.5], vec![0.5, 1.0]]);
        assert_eq!(rows(ragged, 1), Err(NoiseError::Ragged { row: 1, expected: 1, got: 2 }));
        let infinite = rows(Increments::from([0.5, f64::INFINITY]), 1);
        assert_eq!(infinite, Err(NoiseError::NonFinite { step: 1, process: 0, value: f64::INFINITY }));
        assert_eq!(rows(NoNoise, 0), Ok(vec![vec![], vec![]]));
        assert_eq!(rows(NoNoise, 1), Err(NoiseError::Processes { expected: 1, got: 0 }));
    }
}
