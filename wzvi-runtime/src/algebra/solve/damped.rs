//! Newton's method for steps where the fast method fails: whole corrections first, then a line search, and a
//! report whether the result is in doubt. One driver for straight-line blocks and for sweeps, which implement
//! [`Problem`].
//!
//! Near a solution the next correction is a part of the last: with `c = J⁻¹r` at `x`, and the same matrix,
//! `|J⁻¹r(x - c)| <= Θ |c|`. If the Kantorovich number of the start is at most 1/2, there is one solution
//! around it, and `Θ <= 1/4` there (P. Deuflhard, *Newton Methods for Nonlinear Problems*, sections 2.1 and
//! 5.1: a solution that is followed in parts stays the same one). The first correction must satisfy half of
//! that bound, because it measures one point only, and later ones must halve. Otherwise the solution is
//! reported as doubtful.
//!
//! Whole corrections are tried first: they often converge anyway, and along the curved valley of a stiff
//! force faster than any others. Then each is shortened until the residual at its end is smaller,
//! `|J⁻¹r(x - λc)| <= (1 - λ/2) |c|`: the natural monotonicity test, which no scaling of equations or
//! unknowns changes (P. Deuflhard, *Newton Methods for Nonlinear Problems*, Springer 2011, section 3.3).
//!
//! Second derivatives of `H` may be infinite on one side, as those of `max(d, 0)^1.5` at `d = 0`. The slope
//! of the equations beyond such a contact is unlike that before it, so that no test on norms holds, and a
//! push along a chain of contacts reaches one unknown more in each correction. Entries of the Jacobian that
//! are not finite are left out: for these the correction is that of the fixed point, which needs none. A
//! third attempt goes along each correction as far as the next one does not point back: to about the zero of
//! `s(λ) = Σ_k c_k (J⁻¹r(x - λc))_k / (|x_k| + |c_k|)²`, which is `(1 - λ) s(0)` for linear equations and
//! needs no units. Equations that are the gradient of a convex function have one solution, and `s` has about
//! the sign of the slope of that function.

use super::convergence::{CONTRACTION, Convergence, FIRST, UNSEEN, Verdict, relative_to};
use super::dense::{Factor, is_definite};
use super::effort::{Doubt, Effort};
use super::newton::{Equations, astray};
use crate::algebra::scalar::{Scalar, larger};
use crate::error::StepFailure;

/// Whole corrections that are tried unconditionally.
const MOST_WHOLE: u32 = 12;
/// More shortened corrections than any convergent step needs.
const MOST_SHORTENED: u32 = 20;
/// More whole corrections than it takes to halve the first one to rounding level.
const MOST_HALVINGS: u32 = 64;
/// Corrections are shortened to this fraction at most.
const SHORTEST_LENGTH: f64 = 1.0 / 64.0;
/// Corrections along which the next one points back by more than this fraction of them went too far.
const OVERSHOT: f64 = 0.5;
/// Such a correction is shortened until the next one, along it, is at most this fraction of it.
const NEAR_ZERO: f64 = 0.3;
/// More points than it takes to find that length.
const MOST_POINTS: u32 = 40;
/// Directed corrections after the last one that reached an unknown which none had moved before. A push along
/// a chain reaches one more in each, and 20 to 25 more finish chains of 2 to 100 beads.
const MOST_WITHOUT_CONTACT: u32 = 32;
/// The most that may be left of the way back from the end of the iteration, with the Jacobian there:
/// `J_1⁻¹ r_0` for `d = x_0 - x_1`. From a start of the Kantorovich number `ω |c| = 1/4`, of which an eighth
/// is left, `ω |d| <= 1 - √(1/2)` and `|J_1⁻¹ r_0 - d| <= ω |d|² / (2 (1 - ω |d|))` (lemmas 2.1 and 2.2
/// there). The end of another branch, where one contraction was small by accident, has a Jacobian of its own.
const RETURN: f64 = 0.5 * (std::f64::consts::SQRT_2 - 1.0);
/// The Jacobian counts as close to the identity if a correction differs from that of the identity by at most
/// this fraction of the longer one: half of the difference that reverses it.
const ABOUT_IDENTITY: f64 = 0.5;

/// The equations `r(x) = 0` of one step.
pub(crate) trait Problem {
    type Number: Scalar;
    type Vector: AsRef<[Self::Number]> + AsMut<[Self::Number]> + Clone;
    /// The part of a rounding that the correction after the last one may be.
    const UNSEEN: f64 = UNSEEN;

    /// `r(x)`
    fn residual(&mut self, x: &Self::Vector, into: &mut Self::Vector);

    /// Makes the factors of the Jacobian where the residual was evaluated last, without its entries that are
    /// not finite; returns the number of these.
    ///
    /// # Errors
    /// [`StepFailure::Singular`] or [`StepFailure::NonFinite`]; there are no factors then.
    fn factor(&mut self) -> Result<usize, StepFailure>;

    /// `r` becomes `J⁻¹r`.
    ///
    /// # Errors
    /// [`StepFailure`] where the linear equations are not solved.
    fn correct(&mut self, r: &mut Self::Vector) -> Result<(), StepFailure>;

    /// Whether the residual of each equation at `x` is at most a rounding of its own terms.
    fn are_settled(&mut self, x: &Self::Vector) -> impl AsRef<[bool]>;

    /// Whether the determinant of the factored Jacobian is negative.
    fn is_reversed(&self) -> bool;

    /// Whether it is symmetric and not definite, as far as that is known.
    fn is_indefinite(&self) -> bool {
        false
    }
}

/// The work space of [`damped`]; the caller owns it, so that it is allocated once.
#[derive(Debug, Default)]
pub(crate) struct NewtonScratch<V> {
    x: V,
    /// `r` at the start.
    first: V,
    /// `c = J⁻¹r` at `x`.
    correction: V,
    /// `x - λc`
    trial: V,
    /// `r` at the trial.
    residual: V,
    /// `J⁻¹r` at the trial, with the matrix at `x`; then with its own.
    next: V,
}

impl<V: Clone> NewtonScratch<V> {
    /// Room for vectors such as this one.
    pub(crate) fn of(start: &V) -> Self {
        let [x, first, correction, trial, residual, next] = std::array::from_fn(|_| start.clone());
        Self { x, first, correction, trial, residual, next }
    }

    /// The solution that was found.
    pub(crate) fn solution(&self) -> &V {
        &self.trial
    }

    fn start(&mut self, start: &V) {
        let Self { x, first, correction, trial, residual, next } = self;
        [x, first, correction, trial, residual, next].into_iter().for_each(|vector| vector.clone_from(start));
    }
}

/// Solves `r(x) = 0` from `start`; the solution is that of the room.
///
/// # Errors
/// [`StepFailure::NotConverged`], [`StepFailure::Singular`] or [`StepFailure::NonFinite`].
pub(crate) fn damped<P: Problem>(
    problem: &mut P,
    room: &mut NewtonScratch<P::Vector>,
    start: &P::Vector,
) -> Result<Effort, StepFailure> {
    let mut has_contacts = false;
    let mut attempt = |lengths: Lengths| {
        room.start(start);
        let mut search = Search { problem, room, lengths, unmoved: usize::MAX, has_contacts: false };
        let found = search.run(start);
        has_contacts |= search.has_contacts;
        // Without contacts directed corrections are no better, and most of these steps have no solution.
        (found, has_contacts)
    };
    if let (Ok(effort), _) = attempt(Lengths::Whole) {
        return Ok(effort);
    }
    match attempt(Lengths::Monotone) {
        (Err(failure), true) => attempt(Lengths::Directed).0.map_err(|cause| match failure {
            // Nothing is finite, or nothing is left of the Jacobian.
            StepFailure::NonFinite | StepFailure::Singular { .. } => failure,
            _ => cause,
        }),
        (found, _) => found,
    }
}

/// How far an iteration goes along its corrections.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Lengths {
    /// All the way.
    Whole,
    /// Until the residual is smaller.
    Monotone,
    /// Until the next correction neither points back nor much ahead.
    Directed,
}

/// Where an iteration is.
struct Search<'a, P: Problem> {
    problem: &'a mut P,
    room: &'a mut NewtonScratch<P::Vector>,
    lengths: Lengths,
    /// The number of unknowns that no correction has moved.
    unmoved: usize,
    /// Whether a correction reached one of them after the first, or entries of a Jacobian were left out.
    has_contacts: bool,
}

impl<P: Problem> Search<'_, P> {
    /// Iterates from `start`.
    fn run(&mut self, start: &P::Vector) -> Result<Effort, StepFailure> {
        let mut convergence = Convergence::patient(P::UNSEEN);
        let (mut doubtful, mut shortened) = (self.lengths != Lengths::Whole, 0);
        let (mut contacts, mut since_contact) = (0_u32, 0);
        self.problem.residual(&self.room.x, &mut self.room.first);
        self.room.correction.clone_from(&self.room.first);
        self.factor()?;
        self.problem.correct(&mut self.room.correction)?;
        self.reaches();
        let is_far = !is_about(self.room.correction.as_ref(), self.room.first.as_ref());
        loop {
            self.set_trial(1.0);
            let NewtonScratch { x, correction, trial, .. } = &*self.room;
            let size = largest(correction.as_ref(), trial.as_ref(), NONE);
            let mut beyond = || {
                let are_settled = self.problem.are_settled(x);
                largest(correction.as_ref(), trial.as_ref(), are_settled.as_ref())
            };
            let mut verdict = convergence.judge(size, &mut beyond);
            // Near contacts rounding of the equations is far above that of the unknowns, and corrections stop
            // shrinking early.
            if self.lengths == Lengths::Directed && since_contact > 1 && beyond() == 0.0 {
                verdict = Verdict::Converged;
            }
            let is_lost = match (verdict, self.lengths) {
                (Verdict::Converged, _) => {
                    let (is_reversed, is_indefinite) =
                        (self.problem.is_reversed(), self.problem.is_indefinite());
                    let iterations = convergence.iterations;
                    let doubt = match doubtful {
                        true if contacts > 0 => Doubt::Unbounded,
                        true => Doubt::Straying,
                        false if self.returns(start) => Doubt::None,
                        false => Doubt::OneWay,
                    };
                    return Ok(Effort { iterations, doubt, is_far, is_reversed, is_indefinite });
                }
                (_, Lengths::Directed) => size.is_nan() || since_contact >= MOST_WITHOUT_CONTACT,
                (Verdict::Straying, Lengths::Whole) => size.is_nan() || convergence.iterations >= MOST_WHOLE,
                (Verdict::Straying, Lengths::Monotone) => {
                    size.is_nan() || convergence.iterations >= MOST_SHORTENED
                }
                (Verdict::Contracting, _) => convergence.iterations >= MOST_HALVINGS,
            };
            let lost = astray(convergence.iterations, size);
            if is_lost {
                return Err(lost);
            }
            if self.lengths == Lengths::Directed {
                let is_whole = self.direct(lost)?;
                let has_contact = self.reaches();
                contacts += u32::from(has_contact);
                since_contact = if has_contact { 0 } else { since_contact + 1 };
                if !is_whole {
                    convergence.forget();
                }
                continue;
            }
            // Corrections that shrink so far leave no doubt.
            let safe = if convergence.iterations == 1 { FIRST } else { CONTRACTION };
            let descent = self.descend(safe, lost)?;
            contacts += u32::from(self.reaches());
            doubtful |= !descent.contracts;
            if descent.length < 1.0 {
                shortened += 1;
                if shortened >= MOST_SHORTENED {
                    return Err(astray(convergence.iterations, size));
                }
                convergence.forget();
            }
        }
    }

    /// Makes factors.
    ///
    /// # Errors
    /// The errors of [`Problem::factor`]; [`StepFailure::NonFinite`] where entries are left out, which only
    /// directed corrections allow for.
    fn factor(&mut self) -> Result<(), StepFailure> {
        let left_out = self.problem.factor()?;
        self.has_contacts |= left_out > 0;
        if left_out == 0 || self.lengths == Lengths::Directed { Ok(()) } else { Err(StepFailure::NonFinite) }
    }

    /// Whether the next correction moves an unknown that none has moved before.
    fn reaches(&mut self) -> bool {
        let corrections = self.room.correction.as_ref();
        let unmoved = corrections.iter().filter(|correction| correction.magnitude() == 0.0).count();
        let has_reached = unmoved < self.unmoved;
        self.has_contacts |= has_reached && self.unmoved < usize::MAX;
        self.unmoved = unmoved.min(self.unmoved);
        has_reached
    }

    /// Moves `x` along its correction to where there are factors and, if corrections are shortened, the
    /// residual is smaller; an error if that is nowhere.
    fn descend(&mut self, safe: f64, lost: StepFailure) -> Result<Descent, StepFailure> {
        let shortens = self.lengths == Lengths::Monotone;
        let mut length = 1.0;
        let mut contracts = true;
        loop {
            self.try_length(length);
            let mut solved = self.problem.correct(&mut self.room.next);
            contracts &= length < 1.0 || solved.is_ok() && self.shrinks(safe);
            if !shortens || solved.is_ok() && self.shrinks(1.0 - 0.5 * length) {
                solved = self.accept_trial();
                if solved.is_ok() {
                    return Ok(Descent { length, contracts });
                }
                // The factors at `x` again.
                self.problem.residual(&self.room.x, &mut self.room.residual);
                self.factor()?;
            }
            length *= 0.5;
            if !shortens || length < SHORTEST_LENGTH {
                // The cause is a singular matrix at the end of every shortened correction.
                return Err(solved.err().unwrap_or(lost));
            }
        }
    }

    /// Moves `x` along its correction to where the next one does not point back; returns whether that is its
    /// end.
    ///
    /// # Errors
    /// `lost` where that is nowhere, and those of the linear equations.
    fn direct(&mut self, lost: StepFailure) -> Result<bool, StepFailure> {
        let whole = pull(&self.room.x, &self.room.correction, &self.room.correction);
        let (mut near, mut far) = ((0.0, whole), None);
        let mut length = 1.0;
        for point in 0..MOST_POINTS {
            self.try_length(length);
            self.problem.correct(&mut self.room.next)?;
            let left = pull(&self.room.x, &self.room.correction, &self.room.next);
            let allowed = if point == 0 { OVERSHOT } else { NEAR_ZERO };
            if left.abs() <= allowed * whole || point == 0 && left > 0.0 {
                self.accept_trial()?;
                return Ok(point == 0);
            }
            // Also where nothing is finite.
            if left > 0.0 {
                near = (length, left);
            } else {
                far = Some((length, left));
            }
            let Some((end, beyond)) = far else { break };
            let secant = near.0 + (end - near.0) * near.1 / (near.1 - beyond);
            let is_usable = point % 2 == 0 && secant > near.0 && secant < end;
            length = if is_usable { secant } else { 0.5 * (near.0 + end) };
        }
        // `s` is too steep at its zero for numbers to come nearer.
        if near.0 == 0.0 {
            return Err(lost);
        }
        self.try_length(near.0);
        self.accept_trial()?;
        Ok(false)
    }

    /// The trial at this length, with its residual, from which the next correction follows.
    fn try_length(&mut self, length: f64) {
        self.set_trial(length);
        self.problem.residual(&self.room.trial, &mut self.room.residual);
        self.room.next.clone_from(&self.room.residual);
    }

    /// Moves `x` to the trial, with factors and a correction from there.
    ///
    /// # Errors
    /// If there are none; `x` stays where it is, without factors.
    fn accept_trial(&mut self) -> Result<(), StepFailure> {
        self.room.next.clone_from(&self.room.residual);
        self.factor()?;
        self.problem.correct(&mut self.room.next)?;
        std::mem::swap(&mut self.room.x, &mut self.room.trial);
        std::mem::swap(&mut self.room.correction, &mut self.room.next);
        Ok(())
    }

    /// Whether the Jacobian at the end leads back to the start as far as one that hardly changes on the way
    /// does; unknowns whose equations are at rounding at the start do not count.
    fn returns(&mut self, start: &P::Vector) -> bool {
        self.room.next.clone_from(&self.room.first);
        if self.problem.correct(&mut self.room.next).is_err() {
            return false;
        }
        let (to, back) = (&self.room.trial, &self.room.next);
        leads_back(start.as_ref(), to.as_ref(), back.as_ref(), NONE) || {
            let are_settled = self.problem.are_settled(start);
            leads_back(start.as_ref(), to.as_ref(), back.as_ref(), are_settled.as_ref())
        }
    }

    /// `trial = x - length · correction`
    fn set_trial(&mut self, length: f64) {
        let NewtonScratch { x, correction, trial, .. } = &mut *self.room;
        go(x.as_ref(), correction.as_ref(), length, trial.as_mut());
    }

    /// Whether the next correction is at most the fraction `to` of this one, each in units of its unknown.
    /// Unknowns whose equations at the trial are at rounding, which no step makes smaller, do not count.
    /// False for NaN.
    fn shrinks(&mut self, to: f64) -> bool {
        let NewtonScratch { x, correction, next, .. } = &*self.room;
        shrinks(x.as_ref(), correction.as_ref(), next.as_ref(), to, NONE) || {
            let are_settled = self.problem.are_settled(&self.room.trial);
            shrinks(x.as_ref(), correction.as_ref(), next.as_ref(), to, are_settled.as_ref())
        }
    }
}

/// A correction that was taken.
struct Descent {
    /// The fraction of the correction that is taken.
    length: f64,
    /// Whether the whole correction, where it was tried, contracts enough to be safe.
    contracts: bool,
}

// The functions from here on know numbers and no system, and are compiled once. Unknowns whose equations are
// settled do not count.

/// No equation is settled: all unknowns count.
const NONE: &[bool] = &[];

/// The unknowns that count.
fn unsettled(len: usize, are_settled: &[bool]) -> impl Iterator<Item = usize> {
    (0..len).filter(|&k| are_settled.get(k) != Some(&true))
}

/// `to = x - length · correction`
fn go<S: Scalar>(x: &[S], correction: &[S], length: f64, to: &mut [S]) {
    for (to, (&x, &correction)) in to.iter_mut().zip(x.iter().zip(correction)) {
        *to = x - correction * length;
    }
}

/// Whether the correction `next` is at most the fraction `to` of `correction` at `x`. False for NaN.
fn shrinks<S: Scalar>(x: &[S], correction: &[S], next: &[S], to: f64, are_settled: &[bool]) -> bool {
    let (mut left, mut own) = (0.0, 0.0);
    for k in unsettled(x.len(), are_settled) {
        let taken = correction[k].magnitude();
        let size = x[k].magnitude() + taken;
        left = larger(left, relative_to(next[k].magnitude(), size));
        own = larger(own, relative_to(taken, size));
    }
    left <= to * own
}

/// Whether `back`, which the Jacobian at `to` takes for the way from there to `from`, is that way to the
/// fraction [`RETURN`] of it.
fn leads_back<S: Scalar>(from: &[S], to: &[S], back: &[S], are_settled: &[bool]) -> bool {
    let (mut left, mut way) = (0.0, 0.0);
    for k in unsettled(from.len(), are_settled) {
        let own = from[k] - to[k];
        let size = from[k].magnitude() + own.magnitude().max(back[k].magnitude());
        left = larger(left, relative_to((back[k] - own).magnitude(), size));
        way = larger(way, relative_to(own.magnitude(), size));
    }
    left <= RETURN * way
}

/// How far the correction `next` goes along `correction` at `x`, each in units of its unknown. NaN where one
/// is not finite.
fn pull<S: Scalar, V: AsRef<[S]>>(x: &V, correction: &V, next: &V) -> f64 {
    let mut sum = 0.0;
    for ((x, c), next) in x.as_ref().iter().zip(correction.as_ref()).zip(next.as_ref()) {
        let size = x.magnitude() + c.magnitude();
        if size > 0.0 {
            sum += (c.lane(0) / size) * (next.lane(0) / size);
        }
    }
    sum
}

/// Whether these corrections are close to the residuals from which they follow.
fn is_about<S: Scalar>(corrections: &[S], residuals: &[S]) -> bool {
    corrections.iter().zip(residuals).all(|(&correction, &residual)| {
        let longer = correction.magnitude().max(residual.magnitude());
        (correction - residual).magnitude() <= ABOUT_IDENTITY * longer
    })
}

/// The largest correction relative to its unknown; NaN if any is.
fn largest<S: Scalar>(correction: &[S], x: &[S], are_settled: &[bool]) -> f64 {
    let mut most = 0.0;
    for k in unsettled(x.len(), are_settled) {
        most = larger(most, relative_to(correction[k], x[k]));
    }
    most
}

/// Copies the lower triangle into the upper one.
fn mirror<S: Scalar, const N: usize>(matrix: &mut [[S; N]; N]) {
    for i in 1..N {
        let (above, below) = matrix.split_at_mut(i);
        for (row, &entry) in above.iter_mut().zip(&below[0]) {
            row[i] = entry;
        }
    }
}

/// Replaces the rows and columns of unknowns with entries that are not finite by those of the identity;
/// returns the number of these entries.
fn leave_out<S: Scalar, const N: usize>(matrix: &mut [[S; N]; N]) -> usize {
    let is_finite = |entry: &S| entry.magnitude().is_finite();
    let finite = matrix.map(|row| row.iter().all(is_finite));
    let left_out = matrix.iter().flatten().filter(|entry| !is_finite(entry)).count();
    if left_out > 0 {
        for (i, row) in matrix.iter_mut().enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                if !(finite[i] && finite[j]) {
                    *entry = S::from_f64(f64::from(i == j));
                }
            }
        }
    }
    left_out
}

/// The equations of a straight-line block; of a `SYMMETRIC` Jacobian only the lower triangle is read.
pub(super) struct Dense<E, S, const N: usize, const SYMMETRIC: bool> {
    equations: E,
    jacobian: [[S; N]; N],
    factor: Option<Factor<S, N>>,
}

impl<E, S: Scalar, const N: usize, const SYMMETRIC: bool> Dense<E, S, N, SYMMETRIC> {
    pub(super) fn new(equations: E) -> Self {
        Self { equations, jacobian: [[S::from_f64(0.0); N]; N], factor: None }
    }
}

impl<E: Equations<S, N>, S: Scalar, const N: usize, const SYMMETRIC: bool> Problem
    for Dense<E, S, N, SYMMETRIC>
{
    type Number = S;
    type Vector = [S; N];

    fn residual(&mut self, x: &[S; N], into: &mut [S; N]) {
        (*into, self.jacobian) = self.equations.evaluate(x);
    }

    fn factor(&mut self) -> Result<usize, StepFailure> {
        self.factor = None;
        let matrix = &mut self.jacobian;
        if SYMMETRIC {
            mirror(matrix);
        }
        let left_out = leave_out(matrix);
        self.factor = Some(Factor::new(*matrix)?);
        Ok(left_out)
    }

    fn correct(&mut self, r: &mut [S; N]) -> Result<(), StepFailure> {
        let factor = self.factor.as_ref().ok_or(StepFailure::NonFinite)?;
        *r = factor.solve(*r);
        Ok(())
    }

    fn are_settled(&mut self, x: &[S; N]) -> impl AsRef<[bool]> {
        let mut are_settled = [true; N];
        for lane in 0..S::LANES {
            let residual = self.equations.rounded(x, lane);
            for i in 0..N {
                are_settled[i] &= residual[i].is_below(1.0);
            }
        }
        are_settled
    }

    fn is_reversed(&self) -> bool {
        self.factor.as_ref().is_some_and(Factor::is_reversed)
    }

    fn is_indefinite(&self) -> bool {
        SYMMETRIC && !is_definite(&self.jacobian)
    }
}

#[cfg(test)]
mod tests {
    use super::super::closures::Closures;
    use super::*;
    use crate::algebra::scalar::Rounded;

    fn solve<E: Equations<f64, N>, const N: usize>(
        start: [f64; N],
        equations: E,
    ) -> Result<([f64; N], Effort), StepFailure> {
        let mut room = NewtonScratch::of(&start);
        let mut problem = Dense::<E, f64, N, false>::new(equations);
        damped(&mut problem, &mut room, &start).map(|effort| (*room.solution(), effort))
    }

    /// An equation and its slope, with the rounding of a value of the size of 1.
    fn scalar(start: f64, equation: impl Fn(f64) -> (f64, f64) + Copy) -> Result<(f64, Effort), StepFailure> {
        let evaluate = |&[x]: &[f64; 1]| {
            let (residual, slope) = equation(x);
            ([residual], [[slope]])
        };
        let rounded = |&[x]: &[f64; 1], _| [Rounded { value: equation(x).0, error: f64::EPSILON }];
        solve::<_, 1>([start], Closures { evaluate, rounded }).map(|([x], effort)| (x, effort))
    }

    #[test]
    fn full_corrections_that_diverge_are_shortened() {
        // atan(x - 3): from 0 Newton's method without damping runs away.
        let (x, effort) = scalar(0.0, |x| ((x - 3.0).atan(), 1.0 / (1.0 + (x - 3.0).powi(2)))).unwrap();
        assert_eq!(x, 3.0);
        assert!(effort.is_doubtful() && effort.iterations < 15, "{effort:?}");
    }

    #[test]
    fn a_step_of_ordinary_size_leaves_no_doubt() {
        let (x, effort) = scalar(0.0, |x| (x - 0.1 * (1.0 + x).sin(), 1.0 - 0.1 * (1.0 + x).cos())).unwrap();
        assert!((x - 0.1 * (1.0 + x).sin()).abs() <= f64::EPSILON * x);
        assert!(!effort.is_doubtful() && effort.iterations <= 5, "{effort:?}");
    }

    #[test]
    fn a_jacobian_that_is_not_about_the_identity_is_said() {
        let far = |slope: f64| scalar(0.0, |x| (slope * x - 1.0, slope)).unwrap().1.is_far;
        assert!(!far(0.6) && !far(1.9) && far(0.4) && far(2.1) && far(-1.0_f64.exp()));
    }

    #[test]
    fn badly_scaled_unknowns_are_no_obstacle() {
        // The same equation in units of 1e-200 and 1e200.
        let equations = |z: &[f64; 2]| {
            let [x, y] = [z[0] * 1e200, z[1] * 1e-200];
            let residual = [(x - 3.0 + 0.1 * y).atan() * 1e100, (y - 2.0) * 1e-100];
            let slope = 1.0 / (1.0 + (x - 3.0 + 0.1 * y).powi(2));
            (residual, [[slope * 1e200 * 1e100, slope * 0.1 * 1e-100], [0.0, 1e-300]])
        };
        let rounded = |z: &[f64; 2], _: usize| {
            let (residual, errors) = (equations(z).0, [1e100, 1e-100]);
            std::array::from_fn(|i| Rounded { value: residual[i], error: f64::EPSILON * errors[i] })
        };
        let ([x, y], _) = solve::<_, 2>([0.0; 2], Closures { evaluate: equations, rounded }).unwrap();
        assert!((x * 1e200 - 2.8).abs() < 1e-14 && y * 1e-200 == 2.0, "{x} {y}");
    }

    /// Twelve contacts of the force √d that just touch, of which the first is pushed:
    /// `x_i = push_i - a (s_i - s_{i-1})`, `s_i = √max(x_i - x_{i+1}, 0)`.
    #[test]
    fn a_push_reaches_all_contacts() {
        const N: usize = 12;
        let (push, a) = (1.0, 1.0);
        let equations = |x: &[f64; N]| {
            let d: [f64; N] = std::array::from_fn(|i| x[i] - x.get(i + 1).unwrap_or(&0.0));
            let s = |i: usize| a * d[i].max(0.0).sqrt();
            // Infinite at the touch, and zero before it.
            let k = |i: usize| if d[i] < 0.0 { 0.0 } else { 0.5 * a / d[i].sqrt() };
            let last = N - 1;
            let mut residual = *x;
            let mut slopes = [[0.0; N]; N];
            residual[0] -= push;
            for i in 0..N {
                slopes[i][i] += 1.0;
                if i < last {
                    (residual[i], residual[i + 1]) = (residual[i] + s(i), residual[i + 1] - s(i));
                    for (row, column, sign) in
                        [(i, i, 1.0), (i, i + 1, -1.0), (i + 1, i, -1.0), (i + 1, i + 1, 1.0)]
                    {
                        slopes[row][column] += sign * k(i);
                    }
                }
            }
            (residual, slopes)
        };
        let rounded = |x: &[f64; N], _: usize| {
            let error = 8.0 * f64::EPSILON * push;
            equations(x).0.map(|value| Rounded { value, error })
        };
        let (x, effort) = solve::<_, N>([0.0; N], Closures { evaluate: equations, rounded }).unwrap();
        assert!(equations(&x).0.iter().all(|residual| residual.abs() < 1e-14), "{x:?}");
        assert!(x.is_sorted_by(|a, b| a > b) && x[N - 1] > 0.0, "{x:?}");
        assert!(effort.is_unbounded() && !effort.is_reversed && effort.iterations < 60, "{effort:?}");
    }

    #[test]
    fn no_solution_is_an_error() {
        let outcome = scalar(0.5, |x| (1.0 + x * x, 2.0 * x));
        assert!(
            matches!(outcome, Err(StepFailure::NotConverged { .. } | StepFailure::Singular { .. })),
            "{outcome:?}"
        );
        assert_eq!(scalar(0.0, |_| (f64::NAN, 1.0)).map(|_| ()), Err(StepFailure::NonFinite));
    }
}
