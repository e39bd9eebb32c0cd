//! Steps that do not begin where the last one ended, or that the short way does not take: out of line.
//!
//! Everything goes there and comes back by value, because state and stepper stay in registers only where no function is given their
//! address.

use crate::carry::Carry;
use crate::continuation::{Continued, End, Hard, Taken, solve_by_continuation};
use crate::error::StepFailure;
use crate::memory::StepMemory;
use crate::state::Vector;
use crate::system::{Discretized, MemoryOf, Scheme, SchemeOf};

/// Why a step is none of the usual ones.
pub(super) enum Cause<M> {
    /// What the last step left is no guide from another state: the memory, which has forgotten it.
    Moved(M),
    /// The short way failed.
    Failed(StepFailure),
}

/// A step to take.
pub(super) struct Rare<'a, H: Discretized<E>, E, C> {
    pub(super) hard: Hard<'a, H, E, C>,
    /// Whether it may be taken with care.
    pub(super) is_iterated: bool,
}

/// A step that was taken.
pub(super) struct Arrived<H: Discretized<E>, E, C> {
    pub(super) taken: Taken<H, E, C>,
    pub(super) is_hard: bool,
}

/// A step that was not taken.
pub(super) struct Refused<M> {
    pub(super) cause: StepFailure,
    /// What was given: its room, and nothing that is remembered.
    pub(super) memory: Option<M>,
}

impl<H: Discretized<E>, E, C: Carry<f64>> Rare<'_, H, E, C> {
    /// Takes it: the short way if that is not known to fail, then with care.
    ///
    /// # Errors
    /// The cause, or those of [`solve_by_continuation`].
    #[cold]
    #[inline(never)]
    pub(super) fn take(
        self,
        cause: Cause<MemoryOf<H, E, f64>>,
    ) -> Result<Arrived<H, E, C>, Refused<MemoryOf<H, E, f64>>> {
        let Self { mut hard, is_iterated } = self;
        let (failure, memory) = match cause {
            Cause::Failed(failure) => (failure, None),
            Cause::Moved(mut memory) => {
                hard.carry = C::default();
                let (mut q, mut p, mut carry) = (hard.q.clone(), hard.p.clone(), hard.carry.clone());
                let Hard { system, prepared, t, h, dw, .. } = &hard;
                let (time, ends) = ([*t, *h], [&mut q, &mut p]);
                let short = SchemeOf::<H, E>::advance_vectors::<C, false>(
                    system,
                    prepared,
                    time,
                    ends,
                    dw,
                    &mut memory,
                    &mut carry,
                );
                match short {
                    Ok(effort) => match checked(&hard, is_iterated, &q, &p) {
                        Ok(None) => {
                            let taken = Continued { q, p, memory, carry, effort };
                            return Ok(Arrived { taken, is_hard: false });
                        }
                        Ok(Some(mut taken)) => {
                            memory.adopt(taken.memory);
                            taken.memory = memory;
                            return Ok(Arrived { taken, is_hard: true });
                        }
                        Err(cause) => return Err(Refused { cause, memory: Some(memory) }),
                    },
                    Err(failure) => (failure, Some(memory)),
                }
            }
        };
        if !is_iterated {
            return Err(Refused { cause: failure, memory });
        }
        let mut taken = match solve_by_continuation(hard, failure) {
            Ok(solved) => solved,
            Err(cause) => return Err(Refused { cause, memory }),
        };
        if let Some(mut memory) = memory {
            memory.adopt(taken.memory);
            taken.memory = memory;
        }
        Ok(Arrived { taken, is_hard: true })
    }
}

/// More numbers of a state than are followed along a first step that the short way has taken: a large system pays for it with matrices.
const MOST_CHECKED: usize = 64;

/// The solution that continues the state of a first step, where that is another than the short way has found: that one had nothing to go by.
///
/// # Errors
/// [`StepFailure::NoSolution`] where it ends.
fn checked<H: Discretized<E>, E, C: Carry<f64>>(
    hard: &Hard<'_, H, E, C>,
    is_iterated: bool,
    q: &H::Vector,
    p: &H::Vector,
) -> Result<Option<Taken<H, E, C>>, StepFailure> {
    // With noise every step starts from zero, the first as all others, and a path alone as in lanes.
    let is_none = 2 * hard.q.components().len() > MOST_CHECKED || !hard.dw.is_empty();
    if is_none || !is_iterated || hard.solve_whole().is_ok_and(|found| found.effort.is_certain()) {
        return Ok(None);
    }
    match hard.follow() {
        Ok(end) => {
            let is_same = is_near(&hard.q, [q, &end.q]) && is_near(&hard.p, [p, &end.p]);
            Ok(if is_same { None } else { Some(end) })
        }
        Err(End { reached, is_fold: true }) => Err(StepFailure::NoSolution { reached }),
        Err(End { is_fold: false, .. }) => Ok(None),
    }
}

/// Whether two ways from a place lead to the same one. What solves the same equations differs by their rounding, far below a millionth of the way; two
/// solutions come as near as the square root of that only where they meet.
fn is_near<V: Vector>(start: &V, [a, b]: [&V; 2]) -> bool {
    let ends = a.components().iter().zip(b.components());
    start.components().iter().zip(ends).all(|(start, (a, b))| {
        let (way, rounding) = (a - start, f64::EPSILON * (a.abs() + b.abs() + start.abs()));
        (a - b).abs() <= 1e-6 * way.abs() + 64.0 * rounding
    })
}
