//! The choice between sweeps and Newton's method, by what each costs to finish a step.
//!
//! Costs are numbers of operations that follow from the number of stages and of unknowns, and never measured
//! times: the same steps are taken on every machine, in lanes, and after a restart. With `u = N K d` unknowns
//! (`N` stages, `K` halves of the phase space, `d` degrees of freedom), and `s = 10 d` operations for the
//! derivatives at one stage,
//!
//! ```text
//! sweep:      N (s + K N d), of which four at a time go in vector instructions
//! iteration:  N K d (8 s) for the second derivatives, K² N² d² to add them up, u³/3 + 2 u² to solve
//! ```
//!
//! The derivatives cancel from the ratio where they cost most. A step of Newton's method takes three
//! iterations.
//!
//! A step starts with sweeps. Newton's method replaces them as soon as their measured contraction says that
//! it finishes with fewer operations. If these sweeps were a considerable part of the step, the next steps
//! start with Newton's method, more of them after each failure.

use crate::algebra::scalar::Scalar;
use crate::ground::numbers::numbers;

/// Operations for the derivatives at one stage, per degree of freedom.
const SLOPES: f64 = 10.0;
/// Operations for a slope and its derivatives, without vector instructions, in operations for the slope.
const SECOND_DERIVATIVES: f64 = 8.0;
/// Operations of a sweep that go in one vector instruction.
const VECTOR: f64 = 4.0;
/// Sweeps of a step of ordinary size.
const SWEEPS: f64 = 12.0;
/// Iterations of Newton's method in a step.
const ITERATIONS: f64 = 3.0;

/// The slowest contraction with which sweeps go on, whatever Newton's method costs. Slower ones would leave
/// more rounding in the stages: the errors of single sweeps add up to `1 / √(1 - 0.8²) = 1.7` of one.
const SLOWEST: f64 = 0.8;
/// Sweeps from which a contraction is measured. Complex eigenvalues make that of a single sweep vary.
pub(super) const WINDOW: usize = 4;
/// Sweeps that were given up may take one part in so many of the time of all steps.
const SMALL_PART: f64 = 16.0;
/// The most steps that start with Newton's method after sweeps were given up.
const LONGEST: f64 = 64.0;

/// A step of Newton's method in sweeps.
pub(super) fn newton_in_sweeps(stages: usize, kinds: usize, degrees: usize) -> f64 {
    let [n, k, d] = [stages, kinds, degrees].map(|number| number as f64);
    let (slopes, unknowns) = (SLOPES * d, n * k * d);
    let sweep = n * (slopes + k * n * d) / VECTOR;
    let derivatives = unknowns * SECOND_DERIVATIVES * slopes + unknowns * unknowns;
    let elimination = unknowns * unknowns * (unknowns / 3.0 + 2.0);
    ITERATIONS * (derivatives + elimination) / sweep
}

/// Whether so many derivatives cost less by one factorisation than by sweeps in numbers that carry `carried`
/// of them, none of which is in vector instructions. Derivatives take twice as many sweeps as their values.
/// Sizes are the numbers of stages, kinds of unknowns and degrees of freedom.
pub(super) fn is_factored_once(size: [usize; 3], derivatives: usize, carried: usize) -> bool {
    let [n, k, d] = size.map(|number| number as f64);
    let (slopes, unknowns) = (SLOPES * d, n * k * d);
    let numbers = derivatives.div_ceil(carried.max(1)) as f64 * (1.0 + carried as f64);
    let sweep = numbers * n * (slopes + k * n * d);
    // One sweep makes the right-hand sides, and one takes the derivatives at the stages.
    let hessian = unknowns * 2.0 * slopes + unknowns * unknowns;
    let by_factors =
        2.0 * sweep + hessian + unknowns * unknowns * (unknowns / 3.0 + 2.0 * derivatives as f64);
    by_factors <= 2.0 * SWEEPS * sweep
}

/// Whether so many further sweeps finish whose relative change was `before` and is `change` after a
/// [`WINDOW`] of sweeps. `goal`: the change that is small enough. False for NaN.
pub(super) fn finish(most: f64, [before, change]: [f64; 2], goal: f64) -> bool {
    let ratio = change / before;
    if ratio > SLOWEST * SLOWEST * SLOWEST * SLOWEST || ratio.is_nan() {
        return false;
    }
    let (mut left, mut sweeps) = (change, 0.0);
    while left > goal && sweeps <= most {
        left *= ratio;
        sweeps += WINDOW as f64;
    }
    sweeps <= most
}

/// How many further steps start with Newton's method: of each path.
#[derive(Clone, Copy, Debug)]
pub(super) struct NewtonBackoff<S> {
    /// Further steps.
    pub(super) steps: S,
    /// Steps that followed the last sweeps that were given up.
    pub(super) last: S,
}

impl<S: Scalar> NewtonBackoff<S> {
    /// Sweeps come first.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn none() -> Self {
        Self { steps: S::from_f64(0.0), last: S::from_f64(0.0) }
    }

    /// The paths whose next step starts with Newton's method.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn prefer_newton(self) -> S::Mask {
        S::from_f64(0.0).less(self.steps)
    }

    /// The steps of one path.
    pub(super) fn lane(self, lane: usize) -> NewtonBackoff<f64> {
        NewtonBackoff { steps: self.steps.lane(lane), last: self.last.lane(lane) }
    }

    /// With those of one path in its lanes.
    pub(super) fn with(self, lanes: S::Mask, own: NewtonBackoff<f64>) -> Self {
        let [steps, last] = [own.steps, own.last].map(S::from_f64);
        Self { steps: S::select(lanes, steps, self.steps), last: S::select(lanes, last, self.last) }
    }
}

impl<S: Scalar> NewtonBackoff<S> {
    /// After a step that started with Newton's method, of one path.
    pub(super) fn after_newton(self) -> Self {
        Self { steps: S::from_f64((self.steps.lane(0) - 1.0).max(0.0)), ..self }
    }

    /// After so many sweeps that were given up, where Newton's method costs `newton` of them, of one path.
    pub(super) fn after_giving_up(self, sweeps: u32, newton: f64) -> Self {
        let most = (SMALL_PART * f64::from(sweeps) / newton).floor().min(LONGEST);
        let steps = S::from_f64((2.0 * self.last.lane(0) + 1.0).min(most));
        Self { steps, last: steps }
    }
}

numbers! { impl[S: Scalar] Numbers for NewtonBackoff<S> { kept: steps, last } }

#[cfg(test)]
mod tests {
    use super::*;

    /// From 1e-2 to 1e-14 at a tenth per window: twelve windows.
    #[test]
    fn sweeps_are_counted_from_their_contraction() {
        let finish_in = |most| finish(most, [1e-1, 1e-2], 1.5e-14);
        assert!(finish_in(48.0) && !finish_in(47.0));
        assert!(!finish(1e9, [1.0, 0.5], 0.1), "too slow whatever the cost");
        assert!(!finish(1e9, [f64::NAN, 0.5], 0.1) && !finish(1e9, [1.0, f64::NAN], 0.1));
    }

    /// One factorisation serves the four derivatives of two degrees of freedom, and all of a chain; not one
    /// derivative of many.
    #[test]
    fn columns_are_worth_a_factorisation() {
        assert!(is_factored_once([8, 1, 2], 4, 4) && is_factored_once([2, 1, 66], 132, 4));
        assert!(!is_factored_once([4, 1, 66], 1, 1));
    }

    /// Newton's method pays less and less against sweeps as systems grow, and never as little as ten sweeps.
    #[test]
    fn newtons_method_is_dear() {
        for (stages, kinds) in [(2, 1), (2, 2), (4, 2), (8, 1), (16, 2)] {
            let costs: Vec<f64> = [1, 2, 6, 22, 64, 200].map(|d| newton_in_sweeps(stages, kinds, d)).into();
            assert!(costs[0] > 50.0 && costs.is_sorted(), "{costs:?}");
        }
    }

    /// Sweeps that cost little are tried in every step; dear ones soon in one of many.
    #[test]
    fn waits_follow_the_cost_of_sweeps_in_vain() {
        assert!(!NewtonBackoff::<f64>::none().after_giving_up(6, 100.0).prefer_newton());
        let mut waits = NewtonBackoff::<f64>::none();
        let mut lengths = Vec::new();
        for _ in 0..6 {
            waits = waits.after_giving_up(80, 100.0);
            let mut steps = 0;
            while waits.prefer_newton() {
                waits = waits.after_newton();
                steps += 1;
            }
            lengths.push(steps);
        }
        assert_eq!(lengths, [1, 3, 7, 12, 12, 12]);
    }
}
