//! The bare step from zero and with care, where the short way fails: seldom, and out of line.

use super::Discretized;
use crate::carry::Plain;
use crate::error::StepFailure;
use crate::few::Few;
use crate::scalar::Scalar;
use crate::solve::Effort;

/// [`Discretized::advance_carrying`] with care, from a memory that knows nothing.
///
/// # Errors
/// Those of [`Discretized::advance_carrying`]; `q`, `p` and `memory` are then as they were.
#[expect(clippy::too_many_arguments, reason = "those of a step")]
#[inline(always)]
pub(super) fn advance<H: Discretized<E> + ?Sized, E, S: Scalar>(
    system: &H,
    prepared: &H::Prepared,
    t: f64,
    h: f64,
    q: &mut [S],
    p: &mut [S],
    dw: &[S],
    memory: &mut H::Memory<S>,
) -> Result<Effort, StepFailure> {
    let (effort, fresh) = match (Few::of(q), Few::of(p), Few::of(dw)) {
        (Some(few_q), Some(few_p), Some(dw)) => {
            let (effort, fresh, few_q, few_p) =
                of_few::<H, E, S>(system, prepared.clone(), t, h, few_q, few_p, dw)?;
            q.copy_from_slice(&few_q);
            p.copy_from_slice(&few_p);
            (effort, fresh)
        }
        _ => careful::<H, E, S>(system, prepared, t, h, q, p, dw)?,
    };
    *memory = fresh;
    Ok(effort)
}

type Taken<S, M> = (Effort, M, Few<S>, Few<S>);

/// By value.
#[cold]
#[inline(never)]
fn of_few<H: Discretized<E> + ?Sized, E, S: Scalar>(
    system: &H,
    prepared: H::Prepared,
    t: f64,
    h: f64,
    mut q: Few<S>,
    mut p: Few<S>,
    dw: Few<S>,
) -> Result<Taken<S, H::Memory<S>>, StepFailure> {
    let (effort, fresh) = careful::<H, E, S>(system, &prepared, t, h, &mut q, &mut p, &dw)?;
    Ok((effort, fresh, q, p))
}

#[cold]
#[inline(never)]
fn careful<H: Discretized<E> + ?Sized, E, S: Scalar>(
    system: &H,
    prepared: &H::Prepared,
    t: f64,
    h: f64,
    q: &mut [S],
    p: &mut [S],
    dw: &[S],
) -> Result<(Effort, H::Memory<S>), StepFailure> {
    let (mut fresh, plain) = (Default::default(), &mut Plain);
    let effort = system.advance_carrying::<S, Plain, true>(prepared, t, h, q, p, dw, &mut fresh, plain)?;
    Ok((effort, fresh))
}
