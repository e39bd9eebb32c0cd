//! Steps that do not begin where the last one ended, or that the fast method does not solve: out of line.
//!
//! Everything goes there and comes back by value, because state and stepper stay in registers only where no
//! function is given their address.

use crate::algebra::memory::StepMemory;
use crate::algebra::state_sum::StateSum;
use crate::error::StepFailure;
use crate::scheme::continuation::{Continued, ContinuedStep, HardStep, solve_by_continuation};
use crate::scheme::system::{Discretized, MemoryOf, Scheme, SchemeOf, StepArguments};

type RareResult<H, E, C> = Result<TakenRareStep<H, E, C>, RefusedStep<MemoryOf<H, E, f64>>>;

/// Why a step is none of the usual ones.
pub(super) enum RareCause<M> {
    /// The last step is no guide: the state was moved, and the memory has forgotten that step, or it was
    /// hard.
    Unguided(M),
    /// The fast method failed.
    Failed(StepFailure),
}

/// A step to take.
pub(super) struct RareStep<'a, H: Discretized<E>, E, C> {
    pub(super) hard: HardStep<'a, H, E, C>,
    /// Whether it may be taken with care.
    pub(super) is_iterated: bool,
}

/// A step that was taken.
pub(super) struct TakenRareStep<H: Discretized<E>, E, C> {
    pub(super) taken: ContinuedStep<H, E, C>,
    pub(super) is_hard: bool,
}

/// A step that was not taken.
pub(super) struct RefusedStep<M> {
    pub(super) cause: StepFailure,
    /// The memory that was given, for the lists that it has; their contents mean nothing.
    pub(super) memory: Option<M>,
}

impl<H: Discretized<E>, E, C: StateSum<f64>> RareStep<'_, H, E, C> {
    /// Takes the step: by the fast method unless that is known to fail, then with care.
    ///
    /// # Errors
    /// The cause, or those of [`solve_by_continuation`].
    #[cold]
    #[inline(never)]
    pub(super) fn take(self, cause: RareCause<MemoryOf<H, E, f64>>) -> RareResult<H, E, C> {
        let Self { hard, is_iterated } = self;
        let (failure, memory) = match cause {
            RareCause::Failed(failure) => (failure, None),
            RareCause::Unguided(mut memory) => {
                let (mut q, mut p, mut carry) = (hard.q.clone(), hard.p.clone(), hard.carry.clone());
                let HardStep { system, prepared, t, h, dw, .. } = &hard;
                let at = StepArguments { t: *t, h: *h, q: &mut q, p: &mut p, dw };
                let short = SchemeOf::<H, E>::advance::<f64, f64, C, false>(
                    system,
                    prepared,
                    at,
                    &mut memory,
                    &mut carry,
                );
                match short {
                    Ok(effort) => match if is_iterated {
                        hard.check([&q, &p], &mut Default::default())
                    } else {
                        Ok(None)
                    } {
                        Ok(None) => {
                            let taken = Continued { q, p, memory, carry, effort };
                            return Ok(TakenRareStep { taken, is_hard: false });
                        }
                        Ok(Some(mut taken)) => {
                            memory.adopt(taken.memory);
                            taken.memory = memory;
                            return Ok(TakenRareStep { taken, is_hard: true });
                        }
                        Err(cause) => return Err(RefusedStep { cause, memory: Some(memory) }),
                    },
                    Err(failure) => (failure, Some(memory)),
                }
            }
        };
        if !is_iterated {
            return Err(RefusedStep { cause: failure, memory });
        }
        let mut taken = match solve_by_continuation(hard, failure) {
            Ok(solved) => solved,
            Err(cause) => return Err(RefusedStep { cause, memory }),
        };
        if let Some(mut memory) = memory {
            memory.adopt(taken.memory);
            taken.memory = memory;
        }
        Ok(TakenRareStep { taken, is_hard: true })
    }
}
