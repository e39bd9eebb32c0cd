//! The step of a composition.

use super::kept::Memory;
use super::{Half, Substep};
use crate::carry::Carry;
use crate::error::{ConfigError, StepFailure};
use crate::scalar::Scalar;
use crate::solve::Effort;
use crate::system::Discretized;

/// What is prepared for each part of a step.
#[derive(Clone, Debug)]
pub struct Prepared<A, B> {
    parts: Vec<Part<A, B>>,
    /// How many parts are of which kind.
    counts: [usize; 2],
}

/// A part of a step: it starts after the fraction `start` of the step, and is the fraction `weight` of it.
#[derive(Clone, Debug)]
struct Part<A, B> {
    start: f64,
    weight: f64,
    scheme: Scheme<A, B>,
}

#[derive(Clone, Debug)]
enum Scheme<A, B> {
    First(A),
    Second(B),
}

/// What is prepared for the parts of a system by two schemes.
type PreparedOf<H, A, B> = Prepared<<H as Discretized<A>>::Prepared, <H as Discretized<B>>::Prepared>;
/// What the parts of a system by two schemes leave.
type MemoryOf<H, A, B, S> = Memory<S, <H as Discretized<A>>::Memory<S>, <H as Discretized<B>>::Memory<S>>;

/// How many parts are of which kind.
fn counts(substeps: &[Substep]) -> [usize; 2] {
    let first = substeps.iter().filter(|(half, _)| *half == Half::First).count();
    [first, substeps.len() - first]
}

/// The memory of a new stepper.
pub fn memory<H, A, B>(system: &H, substeps: &[Substep]) -> MemoryOf<H, A, B, f64>
where
    H: Discretized<A> + Discretized<B>,
{
    let [first, second] = counts(substeps);
    Memory::of(
        (0..first).map(|_| Discretized::<A>::memory(system)).collect(),
        (0..second).map(|_| Discretized::<B>::memory(system)).collect(),
    )
    .with_room(system.degrees(), system.noises())
}

/// Prepares every part of a step of size `h`.
///
/// # Errors
/// That of the first part that has one.
pub fn prepare<H, A, B>(
    system: &H,
    h: f64,
    substeps: Vec<Substep>,
) -> Result<PreparedOf<H, A, B>, ConfigError>
where
    H: Discretized<A> + Discretized<B>,
{
    let counts = counts(&substeps);
    let mut start = 0.0;
    let parts = substeps.into_iter().map(|(half, weight)| {
        let scheme = match half {
            Half::First => Scheme::First(Discretized::<A>::prepare(system, weight * h)?),
            Half::Second => Scheme::Second(Discretized::<B>::prepare(system, weight * h)?),
        };
        let part = Part { start, weight, scheme };
        start += weight;
        Ok(part)
    });
    Ok(Prepared { parts: parts.collect::<Result<_, _>>()?, counts })
}

/// All parts of a step, one after the other. On `Err`, `q`, `p`, `memory` and `carry` are as they were.
///
/// # Errors
/// That of the first part that has one.
#[expect(clippy::too_many_arguments, reason = "as `Discretized::advance_carrying`")]
#[inline(always)]
pub fn advance<H, A, B, S, C, const CAREFUL: bool>(
    system: &H,
    prepared: &PreparedOf<H, A, B>,
    t: f64,
    h: f64,
    q: &mut [S],
    p: &mut [S],
    dw: &[S],
    memory: &mut MemoryOf<H, A, B, S>,
    carry: &mut C,
) -> Result<Effort, StepFailure>
where
    H: Discretized<A> + Discretized<B>,
    S: Scalar,
    C: Carry<S>,
{
    let [expected, got] = [q.len(), p.len()];
    if !system.fits(expected) || got != expected {
        return Err(StepFailure::Dimension { expected: system.degrees().max(expected), got });
    }
    memory.save(prepared.counts, q, p, dw, carry);
    let mut effort = Effort::fast(0);
    let (mut first, mut second) = (0, 0);
    for part in &prepared.parts {
        let Memory { first: firsts, second: seconds, dw: scaled, .. } = &mut *memory;
        for (scaled, dw) in scaled.iter_mut().zip(dw) {
            *scaled = *dw * part.weight;
        }
        let (t, h) = (t + part.start * h, part.weight * h);
        let taken = match &part.scheme {
            Scheme::First(prepared) => {
                first += 1;
                let memory = &mut firsts[first - 1];
                Discretized::<A>::advance_carrying::<S, C, CAREFUL>(
                    system, prepared, t, h, q, p, scaled, memory, carry,
                )
            }
            Scheme::Second(prepared) => {
                second += 1;
                let memory = &mut seconds[second - 1];
                Discretized::<B>::advance_carrying::<S, C, CAREFUL>(
                    system, prepared, t, h, q, p, scaled, memory, carry,
                )
            }
        };
        match taken {
            Ok(taken) => effort = effort + taken,
            Err(failure) => {
                memory.restore(q, p, carry);
                return Err(failure);
            }
        }
    }
    Ok(effort)
}
