//! Increments that the caller gives.

use super::{Interval, Noise, NoiseError};

/// Given increments, a row for each step, an entry for each noise. They are used as they are: never scaled, never truncated.
///
/// ```
/// use wzvi_runtime::noise::Increments;
///
/// let one_noise = Increments::from(vec![0.1, -0.2, 0.05]); // three steps
/// let two_noises = Increments::from([[0.1, -0.2], [0.3, 0.0]]); // two steps
/// assert_eq!((one_noise.steps(), two_noises.steps()), (3, 2));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Increments {
    values: Vec<f64>,
    /// End of each row in `values`.
    ends: Vec<usize>,
}

impl Increments {
    /// Number of steps that have increments.
    pub fn steps(&self) -> usize {
        self.ends.len()
    }

    /// The increments of a step.
    pub fn row(&self, step: usize) -> Option<&[f64]> {
        let end = *self.ends.get(step)?;
        let start = step.checked_sub(1).map_or(0, |previous| self.ends[previous]);
        self.values.get(start..end)
    }

    fn from_rows<'a>(rows: impl Iterator<Item = &'a [f64]>) -> Self {
        let (mut values, mut ends) = (vec![], vec![]);
        for row in rows {
            values.extend_from_slice(row);
            ends.push(values.len());
        }
        Self { values, ends }
    }
}

impl Noise for Increments {
    fn increments(&mut self, interval: &Interval, dw: &mut [f64]) -> Result<(), NoiseError> {
        let step = interval.step;
        let row = usize::try_from(step).ok().and_then(|step| self.row(step));
        let row = row.ok_or(NoiseError::Exhausted { step, given: self.steps() })?;
        if row.len() != dw.len() {
            return Err(NoiseError::Width { step, expected: dw.len(), got: row.len() });
        }
        if let Some(process) = row.iter().position(|value| !value.is_finite()) {
            return Err(NoiseError::NonFinite { step, process, value: row[process] });
        }
        dw.copy_from_slice(row);
        Ok(())
    }
}

impl From<Vec<f64>> for Increments {
    /// One noise, an increment for each step.
    fn from(values: Vec<f64>) -> Self {
        let ends = (1..=values.len()).collect();
        Self { values, ends }
    }
}

impl From<&[f64]> for Increments {
    /// One noise, an increment for each step.
    fn from(values: &[f64]) -> Self {
        values.to_vec().into()
    }
}

impl<const N: usize> From<[f64; N]> for Increments {
    /// One noise, an increment for each step.
    fn from(values: [f64; N]) -> Self {
        values.to_vec().into()
    }
}

impl<const K: usize, const N: usize> From<[[f64; K]; N]> for Increments {
    /// `K` noises, `N` steps.
    fn from(rows: [[f64; K]; N]) -> Self {
        rows.as_slice().into()
    }
}

impl<const K: usize> From<Vec<[f64; K]>> for Increments {
    /// `K` noises, a row for each step.
    fn from(rows: Vec<[f64; K]>) -> Self {
        rows.as_slice().into()
    }
}

impl<const K: usize> From<&[[f64; K]]> for Increments {
    /// `K` noises, a row for each step.
    fn from(rows: &[[f64; K]]) -> Self {
        Self::from_rows(rows.iter().map(<[f64; K]>::as_slice))
    }
}

impl From<Vec<Vec<f64>>> for Increments {
    /// A row for each step. Rows that do not fit the number of noises are an error of the step that meets them.
    fn from(rows: Vec<Vec<f64>>) -> Self {
        Self::from_rows(rows.iter().map(Vec::as_slice))
    }
}

#[cfg(test)]
mod tests {
    use super::{Increments, Interval, Noise, NoiseError};

    #[test]
    fn rows_come_back_and_errors_say_where() {
        let step = |step| Interval { start: 0.0, h: 0.1, step };
        let mut noise = Increments::from(vec![vec![1.0, 2.0], vec![3.0], vec![4.0, f64::NAN], vec![]]);
        let mut dw = [0.0; 2];
        assert_eq!((noise.increments(&step(0), &mut dw), dw), (Ok(()), [1.0, 2.0]));
        assert_eq!(
            noise.increments(&step(1), &mut dw),
            Err(NoiseError::Width { step: 1, expected: 2, got: 1 })
        );
        assert!(matches!(
            noise.increments(&step(2), &mut dw),
            Err(NoiseError::NonFinite { step: 2, process: 1, .. })
        ));
        assert_eq!(noise.increments(&step(3), &mut []), Ok(()));
        for n in [4, u64::MAX] {
            let error = noise.increments(&step(n), &mut dw);
            assert_eq!(error, Err(NoiseError::Exhausted { step: n, given: 4 }));
        }
    }

    #[test]
    fn all_forms_agree() {
        let rows = Increments::from([[1.0], [2.0]]);
        assert_eq!(rows, Increments::from([1.0, 2.0]));
        assert_eq!(rows, Increments::from(vec![1.0, 2.0]));
        assert_eq!(rows, Increments::from(vec![[1.0], [2.0]]));
        assert_eq!(rows, Increments::from(vec![vec![1.0], vec![2.0]]));
        assert_eq!(rows, Increments::from([1.0, 2.0].as_slice()));
    }
}
