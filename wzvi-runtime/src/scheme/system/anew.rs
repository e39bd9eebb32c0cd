//! A bare step: by the fast solver, and from zero with care if that fails.

use super::{Hamiltonian, Scheme, StepArguments};
use crate::algebra::scalar::{ComputesWith, Constant};
use crate::algebra::solve::Effort;
use crate::algebra::state_sum::{PlainSum, StateSum};
use crate::error::StepFailure;
use crate::scheme::plan::Solver;

/// [`Scheme::advance`] with plain sums, and with care if the fast solver fails.
///
/// # Errors
/// The errors of [`Scheme::advance`]; the state and `memory` are then unchanged.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn advance<H: Hamiltonian, T: Scheme<H> + ?Sized, K: Constant, S: ComputesWith<K>>(
    system: &H,
    prepared: &T::Prepared<K>,
    at: StepArguments<'_, S, K>,
    memory: &mut T::Memory<S>,
) -> Result<Effort, StepFailure> {
    advance_carrying::<H, T, K, S, PlainSum>(system, prepared, at, memory, &mut PlainSum)
}

/// [`advance`], with the rounding errors of the state.
///
/// # Errors
/// The errors of [`Scheme::advance`]; the state, `memory` and `carry` are then unchanged.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn advance_carrying<
    H: Hamiltonian,
    T: Scheme<H> + ?Sized,
    K: Constant,
    S: ComputesWith<K>,
    C: StateSum<S>,
>(
    system: &H,
    prepared: &T::Prepared<K>,
    at: StepArguments<'_, S, K>,
    memory: &mut T::Memory<S>,
    carry: &mut C,
) -> Result<Effort, StepFailure> {
    let StepArguments { t, h, q, p, dw } = at;
    // Either all paths in lanes take the step, or none.
    let before = S::MAY_FAIL_BY_LANE.then(|| (q.to_vec(), p.to_vec(), memory.clone()));
    let short = StepArguments { t, h, q: &mut *q, p: &mut *p, dw };
    match T::advance::<K, S, C, false>(system, prepared, short, memory, carry) {
        Ok(effort) => Ok(effort),
        // Without iteration, care does not help.
        Err(cause) if !matches!(T::PLAN.solver, Solver::Newton) => Err(cause),
        Err(_) => {
            if let Some((start_q, start_p, known)) = before {
                q.copy_from_slice(&start_q);
                p.copy_from_slice(&start_p);
                *memory = known;
            }
            // Copies: state and increments stay in registers only where no function is given their address.
            let (mut end_q, mut end_p, dw) = (q.to_vec(), p.to_vec(), dw.to_vec());
            let at = StepArguments { t, h, q: &mut end_q[..], p: &mut end_p[..], dw: &dw };
            let (effort, fresh) = careful::<H, T, K, S, C>(system, prepared.clone(), at, carry)?;
            q.copy_from_slice(&end_q);
            p.copy_from_slice(&end_p);
            *memory = fresh;
            Ok(effort)
        }
    }
}

/// Starts from an empty memory: rare, and out of line.
#[cold]
#[inline(never)]
fn careful<H: Hamiltonian, T: Scheme<H> + ?Sized, K: Constant, S: ComputesWith<K>, C: StateSum<S>>(
    system: &H,
    prepared: T::Prepared<K>,
    at: StepArguments<'_, S, K>,
    carry: &mut C,
) -> Result<(Effort, T::Memory<S>), StepFailure> {
    let mut fresh = Default::default();
    let effort = T::advance::<K, S, C, true>(system, &prepared, at, &mut fresh, carry)?;
    Ok((effort, fresh))
}
