//! The Wiener process as a function of time.
//!
//! Tested by `wzvi-runtime/tests/runtime/noise_path.rs` and `tests/laws/noise.rs`.

use std::collections::BTreeMap;

use super::cursor::Cursor;
use super::grid::{self, FARTHEST, GridTime};
use super::stream::ProcessId;
use super::truncation::truncation_setters;
use super::{Interval, Noise, NoiseError, Paths, Truncation};
use crate::increments::Identity;
use crate::scheme::plan::Plan;

/// Independent standard Wiener processes `W_k`, two-sided in time, `W_k(0) = 0`.
///
/// `W_k(t)` is a function of `(seed, path, k, t)`: a virtual Brownian tree (Gaines and Lyons 1997; with
/// space-time areas, Foster, Oberhauser and Lyons 2020). It is exact at every time and refined on demand. The
/// same arguments give the same bits in any order of queries, on any machine.
///
/// * Times that differ by less than `2^-50` of the larger of 1024 units and the time (`9e-13` in general) may
///   be taken for one; on a decimal or dyadic grid they always are, so that `3.0 * 0.02` and `0.06`, and the
///   times of a run and of the run back, agree. On other times that holds for the same `f64` only. Steps off
///   those grids should be large against it: the variance of an increment is right to `2e-12 / h`.
/// * Steps of `1/2, 1/5, 1/10, 0.02, 2^-k, 10^-k` and so on cost a few draws; others some fifty, unless they
///   are a simple part of the [`unit`](Wiener::unit).
/// * An increment is a sum over intervals inside it: its relative accuracy is that of `f64`, also for small
///   steps at large times.
///
/// Memory is allocated when a process, or a finer grid, is first met (4 to 13 kB for a process), and never
/// again.
#[derive(Clone, Debug)]
pub struct Wiener {
    seed: u64,
    path: u64,
    unit: f64,
    truncation: Truncation,
    /// Whether the current run truncates unless told otherwise.
    truncates: bool,
    cursors: Vec<Cursor>,
    /// Cursors of single processes far from all others.
    distant: BTreeMap<usize, Cursor>,
    /// The end of the last step: the next one starts there.
    reached: (f64, GridTime),
}

/// A query for a new process also creates the processes before it, up to so many.
const FEW: usize = 1024;

/// No time equals NaN.
pub(super) const NOWHERE: (f64, GridTime) = (f64::NAN, GridTime::ZERO);

impl Wiener {
    /// The paths of a seed.
    pub fn seed(seed: u64) -> Self {
        Self {
            seed,
            path: 0,
            unit: 1.0,
            truncation: Truncation::Unset,
            truncates: false,
            cursors: vec![],
            distant: BTreeMap::new(),
            reached: NOWHERE,
        }
    }

    /// Another member of an ensemble (the default is 0).
    pub fn path(mut self, path: u64) -> Self {
        self.set_path(path);
        self
    }

    pub(super) fn with_truncation(self, truncation: Truncation) -> Self {
        Self { truncation, ..self }
    }

    pub(super) fn with_seed(self, seed: u64) -> Self {
        Self { seed, ..self.twin() }
    }

    /// The unit of time of the tree (the default is 1): `W(t) = sqrt(unit) B(t / unit)`.
    ///
    /// Simple fractions and multiples of the unit take few draws. Use `unit(h)` for a step size that is not
    /// decimal, dyadic or a third. Runs share a path only if they have the same unit.
    pub fn unit(self, unit: f64) -> Self {
        Self { unit, reached: NOWHERE, ..self.twin() }
    }

    truncation_setters!(Self::with_truncation);

    /// The truncation that is set.
    pub fn truncation(&self) -> Truncation {
        self.truncation
    }

    /// `W(t)` of a process.
    ///
    /// # Errors
    /// [`NoiseError::Time`], [`NoiseError::Unit`].
    pub fn value(&mut self, process: usize, t: f64) -> Result<f64, NoiseError> {
        self.increment(process, 0.0, t)
    }

    /// `W(b) - W(a)` of a process; exactly minus that if a and b are exchanged.
    ///
    /// # Errors
    /// [`NoiseError::Time`], [`NoiseError::Unit`].
    pub fn increment(&mut self, process: usize, a: f64, b: f64) -> Result<f64, NoiseError> {
        let (a, b) = (self.point(a)?, self.point(b)?);
        Ok(self.difference(process, &a, &b))
    }

    /// `int_a^b W(s) ds` of a process.
    ///
    /// # Errors
    /// [`NoiseError::Time`], [`NoiseError::Unit`].
    pub fn integral(&mut self, process: usize, a: f64, b: f64) -> Result<f64, NoiseError> {
        // NaN has no order.
        self.point(a)?;
        self.point(b)?;
        let sign = if b < a { -1.0 } else { 1.0 };
        let (from, to) = (a.min(b), a.max(b));
        let start = self.value(process, from)?;
        let area = self.area(process, from, to)?;
        Ok(sign * ((to - from) * start + area))
    }

    /// `int_a^b (W(s) - W(a)) ds` of a process, `a <= b`: the integral over a step without that of its left
    /// end.
    ///
    /// # Errors
    /// [`NoiseError::Time`], [`NoiseError::Unit`].
    pub fn area(&mut self, process: usize, a: f64, b: f64) -> Result<f64, NoiseError> {
        let (from, to) = (self.point(a)?, self.point(b)?);
        let cursor = self.cursor(process);
        cursor.seek(&from);
        let span = cursor.increment_to(&to);
        let span = if from.after(&to) {
            // The span runs from b to a: int_a^b (W(s) - W(a)) ds = -(int_b^a (W(s) - W(b)) ds - (a - b)
            // (W(a) - W(b))).
            -(span.integral - span.length * span.w)
        } else {
            span.integral
        };
        Ok(span * self.unit * self.unit.sqrt())
    }

    /// The point of the tree at a time.
    #[inline]
    pub(super) fn point(&self, t: f64) -> Result<GridTime, NoiseError> {
        if !(self.unit.is_finite() && self.unit > 0.0) {
            return Err(NoiseError::Unit(self.unit));
        }
        GridTime::new(t / self.unit).ok_or(NoiseError::Time { t, limit: FARTHEST * self.unit })
    }

    /// `W(b) - W(a)`.
    #[inline]
    pub(super) fn difference(&mut self, process: usize, a: &GridTime, b: &GridTime) -> f64 {
        let scale = self.unit.sqrt();
        let cursor = self.cursor(process);
        cursor.seek(a);
        let w = cursor.increment_to(b).w;
        scale * if a.after(b) { -w } else { w }
    }

    /// The cursor of a process.
    #[inline]
    pub(super) fn cursor(&mut self, process: usize) -> &mut Cursor {
        if self.cursors.len() <= process {
            let source =
                |process: usize| ProcessId { seed: self.seed, path: self.path, process: process as u64 };
            if process - self.cursors.len() >= FEW {
                return self.distant.entry(process).or_insert_with(|| Cursor::new(source(process)));
            }
            self.cursors.extend((self.cursors.len()..=process).map(|process| Cursor::new(source(process))));
        }
        &mut self.cursors[process]
    }

    /// The factors from units of the tree to units of time, of `W` and of its integrals.
    pub(super) fn scales(&self) -> [f64; 2] {
        [self.unit.sqrt(), self.unit * self.unit.sqrt()]
    }

    /// The truncation of the current run.
    pub(super) fn acting(&self) -> Truncation {
        self.truncation.in_run(self.truncates)
    }

    /// A run with this plan begins.
    pub(super) fn serve(&mut self, plan: &Plan) {
        self.truncates = plan.truncates_increments();
    }

    /// A cursor on the same paths at another place, for the second end of a window.
    pub(super) fn twin(&self) -> Self {
        Self { cursors: vec![], distant: BTreeMap::new(), ..*self }
    }

    /// The error of a query for `W(t)`.
    pub(super) fn check(&self, t: f64) -> Result<(), NoiseError> {
        self.truncation.check()?;
        self.point(t).map(drop)
    }
}

/// The least step in units of the distance below which times may be taken for one: its variance is that of
/// its length to a part in 512.
const LEAST_STEP: f64 = 1024.0;

#[cold]
fn too_short(t: f64, h: f64) -> NoiseError {
    NoiseError::Setting(format!(
        "a step of {h:e} at t = {t:e} is too short for the times of a Wiener path: give it `.unit(h)`, start near t = 0, or take `StepNormals`"
    ))
}

/// Checks the step size.
pub(super) fn check_step(h: f64) -> Result<(), NoiseError> {
    if h.is_finite() && h != 0.0 { Ok(()) } else { Err(NoiseError::StepSize(h)) }
}

/// The times at fractions of a step of size `h` from the start of `interval` on: its ends are the times of
/// the run.
pub(super) fn times_within(interval: &Interval, h: f64, part: [f64; 2]) -> [f64; 2] {
    part.map(|fraction| {
        if fraction == 1.0 && h == interval.h { interval.end() } else { interval.begin() + fraction * h }
    })
}

impl Noise for Wiener {
    #[inline]
    fn increments(&mut self, interval: &Interval, dw: &mut [f64]) -> Result<(), NoiseError> {
        check_step(interval.h)?;
        self.truncation.check()?;
        let (begin, end) = (interval.begin(), interval.end());
        let from = if begin == self.reached.0 { self.reached.1 } else { self.point(begin)? };
        let to = self.point(end)?;
        if from == to {
            return Err(too_short(begin, interval.h));
        }
        self.reached = (end, to);
        let bound = self.acting().bound(interval.h, interval.h.abs().sqrt());
        for (process, dw) in dw.iter_mut().enumerate() {
            *dw = self.difference(process, &from, &to).clamp(-bound, bound);
        }
        Ok(())
    }

    /// Zero where the path has the same point at both ends, which are then one time.
    fn increments_of_part(&mut self, interval: &Interval, h: f64, dw: &mut [f64]) -> Result<(), NoiseError> {
        check_step(h)?;
        self.increments_within(interval, h, [0.0, 1.0], dw)
    }

    fn increments_within(
        &mut self,
        interval: &Interval,
        h: f64,
        part: [f64; 2],
        dw: &mut [f64],
    ) -> Result<(), NoiseError> {
        self.truncation.check()?;
        let [a, b] = times_within(interval, h, part);
        let (from, to) = (self.point(a)?, self.point(b)?);
        let bound = self.acting().bound(h, h.abs().sqrt());
        for (process, dw) in dw.iter_mut().enumerate() {
            *dw = self.difference(process, &from, &to).clamp(-bound, bound);
        }
        Ok(())
    }

    fn prepare(&mut self, plan: &Plan, h: f64, _processes: usize, start: f64) -> Result<(), NoiseError> {
        self.serve(plan);
        check_step(h)?;
        self.check(start)?;
        if h.abs() < LEAST_STEP * grid::resolution(start / self.unit) * self.unit {
            return Err(too_short(start, h));
        }
        Ok(())
    }

    fn largest_increment(&self, h: f64) -> f64 {
        self.acting().bound(h, h.abs().sqrt())
    }

    fn is_divisible(&self) -> bool {
        true
    }

    fn skip_paths(&mut self, paths: u64) -> bool {
        self.set_path(self.path.wrapping_add(paths));
        true
    }

    fn identity(&self) -> Option<Identity> {
        let identity = Identity::of("Wiener").with("seed", self.seed).with("path", self.path);
        Some(identity.with("unit", self.unit).with("truncation", self.acting()))
    }
}

impl Paths for Wiener {
    fn set_path(&mut self, path: u64) {
        self.path = path;
        self.cursors.iter_mut().chain(self.distant.values_mut()).for_each(|cursor| cursor.set_path(path));
    }

    fn seed_number(&self) -> Option<u64> {
        Some(self.seed)
    }
}
