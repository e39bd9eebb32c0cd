//! Newton's method for the steps where the short way fails, as [`crate::solve`] has it for few unknowns: with patience,
//! then with corrections that are shortened until the next one is smaller (the natural monotonicity test), and with a
//! doubt about its own result wherever a correction is not less than half of the one before.

use super::iterate::Step;
use super::jacobian::Linear;
use super::memory::Work;
use super::rounding::Rounding;
use super::{Elements, Memory, Unknowns};
use crate::error::StepFailure;
use crate::scalar::Scalar;
use crate::solve::{Effort, Progress, Verdict, astray, larger};

/// Whole corrections that are tried, whatever they do.
const PATIENCE: u32 = 12;
/// More shortened corrections than any step needs that converges at all.
const MOST_SHORTENED: u32 = 20;
/// More corrections than it takes to halve the first one to rounding level.
const MOST_HALVINGS: u32 = 64;
/// Corrections are shortened to this fraction at most.
const SHORTEST: f64 = 1.0 / 64.0;
/// Next corrections below this fraction of the one before leave no doubt.
const SAFE_CONTRACTION: f64 = 0.5;
/// Residual of linear equations that are solved by iteration: below what a convergence that is nearly quadratic shows.
const TOLERANCE: f64 = 1e-10;

impl<H: Elements, S: Scalar> Step<'_, H, S> {
    /// Solves for the unknowns with care.
    pub(super) fn careful(&self, memory: &mut Memory<S>) -> Result<Effort, StepFailure> {
        if self.scheme.unknowns == Unknowns::None {
            self.explicit(&mut memory.work);
            return Ok(Effort::fast(0));
        }
        let found = match self.search(memory, false) {
            Ok(found) => found,
            Err(_) => self.search(memory, true)?,
        };
        self.refresh(&mut memory.work);
        Ok(found)
    }

    /// With whole corrections, or shortened ones.
    fn search(&self, memory: &mut Memory<S>, shortens: bool) -> Result<Effort, StepFailure> {
        memory.guess(memory.known);
        let is_guess = memory.known > 0;
        memory.factored = None;
        let Memory { work, linear, rounding, .. } = memory;
        let Some(linear) = linear else { return Err(astray(0, f64::INFINITY)) };
        let most = if shortens { MOST_SHORTENED } else { PATIENCE };
        let mut progress = Progress::new(is_guess);
        let (mut doubtful, mut shortened) = (shortens, 0);
        let mut x = work.x.clone();
        let (mut correction, mut residual) = (work.correction.clone(), work.correction.clone());
        self.residual(work);
        self.linearise(work, linear)?;
        self.correct(work, linear, TOLERANCE)?;
        loop {
            // Here `work.x` is `x`, and `work.correction` the correction there.
            correction.copy_from_slice(&work.correction);
            move_by(&mut work.x, &x, &correction, 1.0);
            let relative = largest(&correction, &work.x, &|_| true);
            let verdict = progress.judge(relative, |roundings| {
                let rounding = self.round(&x, rounding);
                largest(&correction, &work.x, &|k| !rounding.is_settled(k, roundings))
            });
            let is_lost = match verdict {
                Verdict::Converged => return Ok(found(&progress, doubtful, linear)),
                Verdict::Straying => relative.is_nan() || progress.iterations >= most,
                Verdict::Contracting => progress.iterations >= MOST_HALVINGS,
            };
            if is_lost {
                return Err(astray(progress.iterations, relative));
            }
            // A guess that is off by more than the solution itself.
            doubtful |= matches!(verdict, Verdict::Straying) && is_guess && progress.iterations == 1;
            let mut length = 1.0;
            loop {
                move_by(&mut work.x, &x, &correction, length);
                self.residual(work);
                residual.copy_from_slice(&work.correction);
                let simplified = self.correct(work, linear, TOLERANCE);
                let shrinks = |work: &Work<S>, rounding: &mut Option<Box<Rounding>>, to: f64| {
                    simplified.is_ok() && self.shrinks(work, &x, &correction, to, rounding)
                };
                let contracts = length < 1.0 || shrinks(work, rounding, SAFE_CONTRACTION);
                doubtful |= !contracts;
                let is_lower = !shortens || shrinks(work, rounding, 1.0 - 0.5 * length);
                let mut next = simplified;
                if is_lower {
                    work.correction.copy_from_slice(&residual);
                    next = self.linearise(work, linear);
                    if next.is_ok() {
                        next = self.correct(work, linear, TOLERANCE);
                    }
                    if next.is_ok() {
                        break;
                    }
                    // The factors at `x` again.
                    move_by(&mut work.x, &x, &correction, 0.0);
                    self.residual(work);
                    self.linearise(work, linear)?;
                }
                length *= 0.5;
                if !shortens || length < SHORTEST {
                    // A singular matrix at the end of every way down is the cause.
                    next?;
                    return Err(astray(progress.iterations, relative));
                }
            }
            x.copy_from_slice(&work.x);
            if length < 1.0 {
                shortened += 1;
                if shortened >= MOST_SHORTENED {
                    return Err(astray(progress.iterations, relative));
                }
                progress.forget();
            }
        }
    }
}

impl<H: Elements, S: Scalar> Step<'_, H, S> {
    /// Whether the next correction is at most the fraction `to` of this one, each in units of its unknown. Unknowns whose
    /// equations are at rounding, which no step makes smaller, do not count. False for NaN.
    fn shrinks(
        &self,
        next: &Work<S>,
        x: &[S],
        correction: &[S],
        to: f64,
        rounding: &mut Option<Box<Rounding>>,
    ) -> bool {
        let level = |c: &[S], counts: &dyn Fn(usize) -> bool| {
            let unknowns = c.iter().zip(x.iter().zip(correction)).enumerate().filter(|&(k, _)| counts(k));
            unknowns.fold(0.0, |most, (_, (c, (x, correction)))| {
                larger(most, c.magnitude().relative_to(x.magnitude() + correction.magnitude()))
            })
        };
        if level(&next.correction, &|_| true) <= to * level(correction, &|_| true) {
            return true;
        }
        let rounding = self.round(&next.x, rounding);
        let counts = |k: usize| !rounding.is_settled(k, 1.0);
        level(&next.correction, &counts) <= to * level(correction, &counts)
    }
}

/// The largest correction, of those that count, relative to its unknown; NaN if any is.
fn largest<S: Scalar>(correction: &[S], x: &[S], counts: &dyn Fn(usize) -> bool) -> f64 {
    let unknowns = correction.iter().zip(x).enumerate().filter(|&(k, _)| counts(k));
    unknowns.fold(0.0, |most, (_, (c, &x))| larger(most, c.relative_to(x)))
}

/// `to = x - length · correction`
fn move_by<S: Scalar>(to: &mut [S], x: &[S], correction: &[S], length: f64) {
    for ((to, &x), &correction) in to.iter_mut().zip(x).zip(correction) {
        *to = x - correction * length;
    }
}

/// The orientation is not known where the matrix is not.
fn found<S: Scalar>(progress: &Progress, doubtful: bool, linear: &Linear<S>) -> Effort {
    let is_reversed = match linear {
        Linear::Band(band) => band.is_reversed(),
        Linear::Krylov(_) => false,
    };
    Effort { iterations: progress.iterations, doubtful, is_reversed }
}
