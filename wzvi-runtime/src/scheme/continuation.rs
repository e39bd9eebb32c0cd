//! Steps on which the fast solver fails: solved from zero with a line search, then by continuation along the
//! step.
//!
//! The equations of a step may have several solutions, and Newton's method from far away finds any of them.
//! The right one is connected with the state: it starts from zero change at `λ = 0` as the Hamiltonian of the
//! step, `λ (h H_0 + Σ_k ΔW_k H_k)`, grows to `λ = 1`, which means solving the steps of size `λh` with
//! increments `λΔW`. Where a solution is doubtful ([`Effort::doubt`], [`Effort::is_far`]) it is followed
//! along `λ`. Each part starts where the one before ended, and is accepted if Newton's method leaves no doubt
//! that it is still the same solution; else it is halved. After an accepted part the length is doubled, up to
//! an eighth of the step: the force may change between the starts of two parts, and nothing else checks that.
//!
//! The Jacobian at the end of a part must lead back to its start, too (`RETURN` in `damped.rs`). Where parts
//! that do so cannot reach the end of the step although no fold is found, parts are accepted without this
//! test, and the step is reported as doubtful.
//!
//! At a fold the parts shrink without limit, and the step has no solution. At a kink of `H` the curve goes
//! on: the corrections do not contract as they should, however short the part, but the displacement shrinks
//! with the part, whereas a jump to another solution keeps its length.
//!
//! If the equations jump, at a condition on an unknown, the curve ends with a finite slope ([`STEEPEST`]).
//! No step size avoids such an end: the part of a step that crosses the edge has it. The solution from zero
//! lies beyond the edge, then. It is taken if it has a Jacobian as below, and the step is reported as
//! doubtful.
//!
//! If second derivatives are infinite on the way, as at contacts that just touch, corrections contract on no
//! part of the step, however short, and following proves nothing. The solution from zero is taken by the same
//! criterion as that of a stiff force, next.
//! A stiff force far from equilibrium oscillates many times along `λ`, and no reasonable number of parts
//! resolves that. Then the solution from zero is taken if its Jacobian has a positive determinant (and is
//! definite, if it is symmetric), as the connected one has and the next one has not, and the step is reported
//! as doubtful.

use crate::algebra::memory::{MemoryRequest, StepMemory};
use crate::algebra::short_list::{ShortList, ShortOrLong};
use crate::algebra::solve::{Doubt, Effort};
use crate::algebra::state::Vector;
use crate::algebra::state_sum::StateSum;
use crate::error::StepFailure;
use crate::scheme::system::{
    Discretized, Hamiltonian, MemoryOf, PreparedOf, Scheme, SchemeOf, StepArguments, as_they_are,
};

/// The longest and the shortest part along which a solution is followed, as fractions of the step.
const LONGEST: f64 = 1.0 / 8.0;
const SHORTEST: f64 = 1.0 / 1048576.0;
/// The most parts tried at the start of the step and at its end; between them the limit is linear in the
/// fraction reached. A smooth curve takes ten, and one that passes a fold three per halving; where hundreds
/// do not suffice, the force oscillates along the step.
const MOST_TRIED: [f64; 2] = [64.0, 512.0];
/// An end of the curve before this fraction of the step is no fold but a lack of resolution: nothing ends so
/// small a step.
const EARLIEST_END: f64 = 1.0 / 16.0;
/// The largest ratio of the displacements of a part and of one twice as long: 1/2 for a straight curve, with
/// a margin for its curvature.
const SHRINKING: f64 = 0.6;
/// Such parts in a row by which a kink of the curve is recognised.
const KINK: u32 = 4;
/// The largest slope of the curve where it ends at a jump of the equations, in units of its mean slope so
/// far. Before a fold at `λ*` the curve is `x* - K √(λ* - λ)`, and no part is longer than what is left after
/// it. The last one is within 16 [`SHORTEST`] of the fold, with a slope of at least
/// `K / (2 √(16 SHORTEST)) = 128 K`. The mean is `K / √λ*`, at most `4 K` after [`EARLIEST_END`]: folds are
/// 32 times as steep, jumps about once.
const STEEPEST: f64 = 16.0;

/// The most coordinates and momenta for which a first step is checked: in large systems its matrices cost too
/// much.
const MOST_CHECKED: usize = 64;

/// A step to take.
///
/// Passed and returned by value, so that the caller's own data stay in registers.
pub(crate) struct HardStep<'a, H: Discretized<E>, E, C> {
    pub(crate) system: &'a H,
    pub(crate) prepared: PreparedOf<H, E>,
    pub(crate) t: f64,
    pub(crate) h: f64,
    pub(crate) q: H::Vector,
    pub(crate) p: H::Vector,
    pub(crate) dw: ShortOrLong<'a, f64>,
    pub(crate) carry: C,
}

/// A step taken with care.
pub(crate) struct Continued<V, M, C> {
    pub(crate) q: V,
    pub(crate) p: V,
    pub(crate) memory: M,
    pub(crate) carry: C,
    pub(crate) effort: Effort,
}

impl<V, C> Continued<V, (), C> {
    /// Adds the memory for the next step.
    fn leaving<M>(self, memory: M) -> Continued<V, M, C> {
        let Self { q, p, memory: (), carry, effort } = self;
        Continued { q, p, memory, carry, effort }
    }
}

pub(crate) type ContinuedStep<H, E, C> = Continued<<H as Hamiltonian>::Vector, MemoryOf<H, E, f64>, C>;
type ContinuationResult<H, E, C> = Result<ContinuedStep<H, E, C>, StepFailure>;
type SolvedState<H, C> = Result<Continued<<H as Hamiltonian>::Vector, (), C>, StepFailure>;

/// Takes a step that failed for `cause`.
///
/// # Errors
/// `cause` if the arguments are invalid or not finite, [`StepFailure::NoSolution`] where the solution ends,
/// else the failure of the careful solution.
#[cold]
#[inline(never)]
pub(crate) fn solve_by_continuation<H: Discretized<E>, E, C: StateSum<f64>>(
    hard: HardStep<'_, H, E, C>,
    cause: StepFailure,
) -> ContinuationResult<H, E, C> {
    let lists = [hard.q.components(), hard.p.components(), &hard.dw, &[hard.t]];
    if cause.is_of_arguments() || !are_finite(lists) {
        return Err(cause);
    }
    hard.solve_or_follow().map_err(|failure| hard.explained(failure))
}

fn are_finite(lists: [&[f64]; 4]) -> bool {
    lists.iter().all(|list| list.iter().all(|x| x.is_finite()))
}

/// The point beyond which the curve of solutions could not be followed.
pub(crate) struct ContinuationLimit {
    pub(crate) reached: f64,
    pub(crate) end: EndOfCurve,
}

/// Why a curve could not be followed, as far as the shortest parts resolve it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum EndOfCurve {
    /// It ends at a fold.
    Fold,
    /// It ends at a jump of the equations.
    Jump,
    /// It may go on.
    Unknown,
}

impl<H: Discretized<E>, E, C: StateSum<f64>> HardStep<'_, H, E, C> {
    /// The failure, or that the step is longer than a manifold curves, if that may be why.
    fn explained(&self, failure: StepFailure) -> StepFailure {
        let (q, p) = (self.q.components(), self.p.components());
        let manifold = self.system.manifold();
        manifold.and_then(|manifold| manifold.too_long(q, p, self.t, self.h)).unwrap_or(failure)
    }

    /// Solves the step at once; if a doubt remains, along the step.
    fn solve_or_follow(&self) -> ContinuationResult<H, E, C> {
        let mut memory = MemoryOf::<H, E, f64>::default();
        let found = self.solve(&self.prepared, self.h, &self.dw, &mut memory);
        match found {
            Ok(found) if found.effort.is_certain() => Ok(found.leaving(memory)),
            Ok(found) if found.effort.is_unbounded() && !found.effort.is_elsewhere() => {
                Ok(found.leaving(memory))
            }
            found => match self.follow() {
                Ok(end) => Ok(end),
                Err(ContinuationLimit { reached, end: EndOfCurve::Fold }) => {
                    Err(StepFailure::NoSolution { reached })
                }
                Err(ContinuationLimit { reached, end }) => match found {
                    Ok(found) if !found.effort.is_elsewhere() => {
                        let effort = Effort { doubt: Doubt::Straying, ..found.effort };
                        Ok(Continued { effort, ..found }.leaving(memory))
                    }
                    Err(failure) if end == EndOfCurve::Unknown => Err(failure),
                    Ok(_) | Err(_) => Err(StepFailure::NoSolution { reached }),
                },
            },
        }
    }

    /// Checks the end `[q, p]` that the fast solver found for a first step, or for one after a hard step,
    /// without a prediction. Returns the solution that continues the state if that is another one. `room` is
    /// the memory for the steps of the check.
    ///
    /// # Errors
    /// [`StepFailure::NoSolution`] where it ends.
    pub(crate) fn check(
        &self,
        [q, p]: [&H::Vector; 2],
        room: &mut MemoryOf<H, E, f64>,
    ) -> Result<Option<ContinuedStep<H, E, C>>, StepFailure> {
        // With noise every step starts from zero.
        if 2 * self.q.components().len() > MOST_CHECKED || !self.dw.is_empty() {
            return Ok(None);
        }
        room.tell(&MemoryRequest::Forget);
        let is_same = |end: [&H::Vector; 2]| is_near(&self.q, [q, end[0]]) && is_near(&self.p, [p, end[1]]);
        let found = self.solve(&self.prepared, self.h, &self.dw, room);
        let is_taken =
            |effort: Effort| effort.is_certain() || effort.is_unbounded() && !effort.is_elsewhere();
        if found.is_ok_and(|found| is_taken(found.effort) && is_same([&found.q, &found.p])) {
            return Ok(None);
        }
        match self.follow() {
            Ok(end) => {
                Ok(if end.effort.is_doubtful() || is_same([&end.q, &end.p]) { None } else { Some(end) })
            }
            Err(ContinuationLimit { reached, end: EndOfCurve::Fold }) => {
                Err(StepFailure::NoSolution { reached })
            }
            Err(ContinuationLimit { end: EndOfCurve::Jump | EndOfCurve::Unknown, .. }) => Ok(None),
        }
    }

    /// The step of size `h` with care, started from `memory`.
    fn solve(
        &self,
        prepared: &PreparedOf<H, E>,
        h: f64,
        dw: &[f64],
        memory: &mut MemoryOf<H, E, f64>,
    ) -> SolvedState<H, C> {
        let (mut q, mut p, mut carry) = (self.q.clone(), self.p.clone(), self.carry.clone());
        let at = StepArguments { t: self.t, h, q: q.components_mut(), p: p.components_mut(), dw };
        let effort =
            SchemeOf::<H, E>::advance::<f64, f64, C, true>(self.system, prepared, at, memory, &mut carry)?;
        Ok(Continued { q, p, memory: (), carry, effort })
    }

    /// The solution that continues the state, or where it ends.
    pub(crate) fn follow(&self) -> Result<ContinuedStep<H, E, C>, ContinuationLimit> {
        match self.follow_parts(true) {
            Err(ContinuationLimit { end: EndOfCurve::Unknown, .. }) => {
                let mut end = self.follow_parts(false)?;
                end.effort.doubt = Doubt::Straying;
                Ok(end)
            }
            outcome => outcome,
        }
    }

    /// Follows the solution in parts; `are_returned` requires that each leads back to its start.
    fn follow_parts(&self, are_returned: bool) -> Result<ContinuedStep<H, E, C>, ContinuationLimit> {
        let mut many = Vec::new();
        let mut few = ShortList::of(&self.dw);
        let dw: &mut [f64] = match &mut few {
            Some(few) => few,
            None => {
                many.resize(self.dw.len(), 0.0);
                &mut many
            }
        };
        let mut at = [self.q.clone(), self.p.clone()];
        let mut memory = MemoryOf::<H, E, f64>::default();
        let (mut kink, mut is_steep) = (Kink::of(&at), true);
        let (mut reached, mut part, mut iterations, mut tried_so_far) = (0.0, LONGEST, 0, 0.0);
        while tried_so_far < MOST_TRIED[0] + reached * (MOST_TRIED[1] - MOST_TRIED[0]) {
            tried_so_far += 1.0;
            // Parts are powers of two, so that their sums are exact.
            let fraction = f64::min(reached + part, 1.0);
            for (scaled, dw) in dw.iter_mut().zip(&*self.dw) {
                *scaled = fraction * dw;
            }
            let h = fraction * self.h;
            let Ok(prepared) = SchemeOf::<H, E>::prepare(self.system, &as_they_are, h) else { break };
            let mut left = memory.clone();
            let tried = self.solve(&prepared, h, dw, &mut left);
            let tried = tried.ok().filter(|step| !step.effort.is_elsewhere());
            iterations += tried.as_ref().map_or(0, |step| step.effort.iterations);
            let is_same = tried.as_ref().is_some_and(|step| {
                let allowed = if are_returned { Doubt::None } else { Doubt::OneWay };
                step.effort.doubt <= allowed || kink.is_passed(&at, step)
            });
            match tried {
                Some(mut step) if is_same => {
                    if fraction == 1.0 {
                        // The result is certain. Parts of a step do not predict the next step; the step
                        // itself may.
                        step.effort = Effort { doubt: Doubt::None, is_far: false, iterations, ..step.effort };
                        left.tell(&MemoryRequest::Hold);
                        return Ok(step.leaving(left));
                    }
                    let to = [step.q, step.p];
                    is_steep = is_steeper([&self.q, &self.p], [&at, &to], (fraction - reached) / fraction);
                    (at, memory) = (to, left);
                    memory.tell(&MemoryRequest::Hold);
                    (reached, part) = (fraction, f64::min(2.0 * part, LONGEST));
                    kink.forget();
                }
                tried => {
                    if tried.is_none() {
                        kink.forget();
                    }
                    part *= 0.5;
                    if part < SHORTEST {
                        // If the corrections contract without doubt, the curve goes on, hidden by rounding or
                        // by an oscillating force.
                        let contracts = tried.is_some_and(|step| step.effort.doubt != Doubt::Straying);
                        let end = match is_steep {
                            _ if contracts || reached < EARLIEST_END => EndOfCurve::Unknown,
                            true => EndOfCurve::Fold,
                            false => EndOfCurve::Jump,
                        };
                        return Err(ContinuationLimit { reached, end });
                    }
                }
            }
        }
        Err(ContinuationLimit { reached, end: EndOfCurve::Unknown })
    }
}

/// Whether the last part of a curve from `start`, with this share of its length, is steeper than [`STEEPEST`]
/// in any unknown.
fn is_steeper<V: Vector>(start: [&V; 2], [from, to]: [&[V; 2]; 2], share: f64) -> bool {
    start.iter().zip(from).zip(to).any(|((start, from), to)| {
        let mut components = start.components().iter().zip(from.components()).zip(to.components());
        components.any(|((start, from), to)| {
            let rounding = f64::EPSILON * (to.abs() + from.abs());
            (to - from).abs() > STEEPEST * share * (to - start).abs() + rounding
        })
    })
}

/// Whether two steps from `start` end in the same state. Results for one solution differ by rounding, far
/// below a millionth of the displacement; two solutions come as close as the square root of rounding only
/// where they merge.
pub(crate) fn is_near<V: Vector>(start: &V, [a, b]: [&V; 2]) -> bool {
    let ends = a.components().iter().zip(b.components());
    start.components().iter().zip(ends).all(|(start, (a, b))| {
        // Subnormal numbers have a rounding of their own.
        let size = (a.abs() + b.abs() + start.abs()).max(f64::MIN_POSITIVE);
        let (way, rounding) = (a - start, f64::EPSILON * size);
        (a - b).abs() <= 1e-6 * way.abs() + 64.0 * rounding
    })
}

/// Displacements by doubtful parts from one state, each part half as long as the one before.
struct Kink<V> {
    moves: [V; 2],
    shrunk: u32,
    is_known: bool,
}

impl<V: Vector> Kink<V> {
    fn of(at: &[V; 2]) -> Self {
        Self { moves: at.clone(), shrunk: 0, is_known: false }
    }

    fn forget(&mut self) {
        (self.shrunk, self.is_known) = (0, false);
    }

    /// Records such a part; whether enough displacements in a row have shrunk that the curve has no gap.
    fn is_passed<M, C>(&mut self, from: &[V; 2], to: &Continued<V, M, C>) -> bool {
        let (mut shrinks, is_known) = (true, std::mem::replace(&mut self.is_known, true));
        for ((before, from), to) in self.moves.iter_mut().zip(from).zip([&to.q, &to.p]) {
            let components = from.components().iter().zip(to.components());
            for (before, (from, to)) in before.components_mut().iter_mut().zip(components) {
                // The difference of two states has their rounding.
                let (way, rounding) = ((to - from).abs(), f64::EPSILON * (to.abs() + from.abs()));
                shrinks &= way <= SHRINKING * *before + rounding;
                *before = way;
            }
        }
        self.shrunk = if is_known && shrinks { self.shrunk + 1 } else { 0 };
        self.shrunk >= KINK
    }
}
