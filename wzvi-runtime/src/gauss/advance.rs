//! The step of a Gauss method.

use super::Field;
use super::kept::{Lists, Memory};
use super::stages::{At, Stages};
use super::sweep::Solved;
use super::table::Table;
use crate::carry::Carry;
use crate::error::{ConfigError, StepFailure};
use crate::lanes::instructions::{InstructionSet, Kernel};
use crate::memory::Iteration;
use crate::scalar::Scalar;
use crate::solve::Effort;

/// The coefficients, and the instructions that this machine has.
#[derive(Clone, Debug)]
pub struct Prepared<const N: usize> {
    table: Table<N>,
    instructions: InstructionSet,
}

/// Prepares a step of `N` stages.
///
/// # Errors
/// [`ConfigError::Parameter`] if a parameter is not a number.
pub fn prepare<F: Field, const N: usize>(system: &F) -> Result<Prepared<N>, ConfigError> {
    let mut parameters = (0..).map_while(|index| system.parameter(index));
    if parameters.any(|(_, value)| value.is_nan()) {
        return Err(ConfigError::Parameter);
    }
    Ok(Prepared { table: Table::get(), instructions: InstructionSet::best() })
}

/// The memory of a new stepper: all that its steps will need, where the system knows its size.
pub fn memory<F: Field, const N: usize>(system: &F) -> Memory<f64, F::Shape, N> {
    let mut memory = Memory::default();
    let degrees = system.degrees();
    if degrees != 0 && system.check(degrees).is_ok() {
        memory.fit(degrees);
        memory.scratch.reserve(degrees, system.noises());
    }
    memory
}

/// One step from `(q, p)` at `t` in place. On `Err`, `q`, `p`, `memory` and `carry` are as they were.
///
/// # Errors
/// [`StepFailure::NotConverged`], [`StepFailure::NonFinite`], or where sizes do not fit.
#[expect(clippy::too_many_arguments, reason = "as `Discretized::advance_carrying`")]
#[inline(always)]
pub fn advance<F: Field, S: Scalar, C: Carry<S>, const N: usize, const CAREFUL: bool>(
    system: &F,
    prepared: &Prepared<N>,
    t: f64,
    h: f64,
    q: &mut [S],
    p: &mut [S],
    dw: &[S],
    memory: &mut Memory<S, F::Shape, N>,
    carry: &mut C,
) -> Result<Effort, StepFailure> {
    let degrees = q.len();
    if memory.lists.spare.as_ref().len() != degrees || !system.fits(degrees) {
        system.check(degrees)?;
        memory.fit(degrees);
    }
    if p.len() != degrees {
        return Err(StepFailure::Dimension { expected: degrees, got: p.len() });
    }
    if dw.len() != system.noises() {
        return Err(StepFailure::Increments { expected: system.noises(), got: dw.len() });
    }
    let run = Run::<F, S, C, N, CAREFUL> { system, table: &prepared.table, t, h, q, p, dw, memory, carry };
    // Other numbers than `f64` are not side by side.
    if size_of::<S>() == size_of::<f64>() { prepared.instructions.run(run) } else { run.run::<1>() }
}

/// The data of a step.
pub(super) struct Step<'a, F, S, const N: usize> {
    pub(super) system: &'a F,
    pub(super) table: &'a Table<N>,
    pub(super) at: At<'a, S, N>,
    pub(super) q: &'a [S],
    pub(super) p: &'a [S],
}

/// A step to take.
struct Run<'a, F: Field, S: Scalar, C, const N: usize, const CAREFUL: bool> {
    system: &'a F,
    table: &'a Table<N>,
    t: f64,
    h: f64,
    q: &'a mut [S],
    p: &'a mut [S],
    dw: &'a [S],
    memory: &'a mut Memory<S, F::Shape, N>,
    carry: &'a mut C,
}

impl<const N: usize> Prepared<N> {
    pub(super) fn table(&self) -> &Table<N> {
        &self.table
    }
}

impl<F: Field, S: Scalar, C: Carry<S>, const N: usize, const CAREFUL: bool> Kernel
    for Run<'_, F, S, C, N, CAREFUL>
{
    type Output = Result<Effort, StepFailure>;

    #[inline(always)]
    fn run<const L: usize>(self) -> Self::Output {
        let Self { system, table, t, h, q, p, dw, memory, carry } = self;
        let at = At { t, h, dw, c: &table.c };
        let step = Step { system, table, at, q, p };
        let mut lists = memory.lists.take();
        let solved = step.solve::<C, CAREFUL>(&mut lists, memory, carry);
        let finished = match solved {
            Ok(solved) => step.finish(&mut lists, carry).map(|()| solved),
            Err(failure) => Err(failure),
        };
        if let Ok(Solved { prefers_newton, .. }) = &finished {
            memory.prefers_newton = *prefers_newton;
            // With noise it is no guide to the next step, but it says what lies between the nodes.
            std::mem::swap(&mut memory.past, &mut lists.slopes);
            memory.is_known = step.remembers();
            q.copy_from_slice(lists.next[0].as_ref());
            p.copy_from_slice(lists.next[1].as_ref());
            if C::CARRIES {
                carry.keep(lists.lost[0].as_ref(), lists.lost[1].as_ref());
            }
        }
        memory.lists.give_back(lists);
        finished.map(|solved| solved.effort)
    }
}

impl<F: Field, S: Scalar, const N: usize> Step<'_, F, S, N> {
    /// Whether the steps before are a guide: without noise.
    #[inline(always)]
    pub(super) fn remembers(&self) -> bool {
        self.at.dw.is_empty()
    }

    /// The stages to start from: what the slopes of the last step extrapolate to, else the state itself.
    #[inline(always)]
    pub(super) fn guess<C: Carry<S>>(
        &self,
        lists: &mut Lists<S, F::Shape, N>,
        memory: &mut Memory<S, F::Shape, N>,
        from_past: bool,
        carry: &C,
    ) {
        let zero = S::Stages::<N>::splat(S::from_f64(0.0));
        let Table { nu, kappa, .. } = self.table;
        if F::IS_NYSTROM {
            let past = memory.past[1].as_ref();
            let momenta = lists.at[1].as_mut();
            for (d, momentum) in momenta.iter_mut().enumerate() {
                *momentum = zero.plus_scaled(&self.table.c, self.p[d] + carry.of_momentum(d));
                if from_past {
                    *momentum = momentum.plus_product(kappa, past[d]);
                }
            }
            self.drift(lists, memory, carry);
        } else {
            let Lists { at: [q, p], .. } = lists;
            let [by_p, by_q] = &memory.past;
            let starts = [(q, self.q, by_p), (p, self.p, by_q)];
            for (k, (stages, start, slopes)) in starts.into_iter().enumerate() {
                let (stages, slopes) = (stages.as_mut(), slopes.as_ref());
                for (d, stage) in stages.iter_mut().enumerate() {
                    let carried = if k == 0 { carry.of_coordinate(d) } else { carry.of_momentum(d) };
                    *stage = S::Stages::splat(start[d] + carried);
                    if from_past {
                        *stage = stage.plus_product(nu, slopes[d]);
                    }
                }
            }
        }
    }

    /// The coordinates of the stages from `at[1]`, the momenta that move them (Nyström form): `q + ∂F/∂p`.
    #[inline(always)]
    pub(super) fn drift<C: Carry<S>>(
        &self,
        lists: &mut Lists<S, F::Shape, N>,
        memory: &mut Memory<S, F::Shape, N>,
        carry: &C,
    ) {
        let Lists { at: [q, p], slopes: [velocity, _], spare, .. } = lists;
        let (q, velocity) = (q.as_mut(), velocity.as_mut());
        let scratch = &mut memory.scratch;
        S::Stages::slopes::<F, false, true>(
            self.system,
            &self.at,
            q,
            p.as_ref(),
            spare.as_mut(),
            velocity,
            scratch,
        );
        for (d, (q, velocity)) in q.iter_mut().zip(velocity).enumerate() {
            *q = S::Stages::splat(self.q[d] + carry.of_coordinate(d)).plus(*velocity);
        }
    }

    /// `b_i ∂F/∂p` and `-b_i ∂F/∂q` at the stages.
    #[inline(always)]
    pub(super) fn field(&self, lists: &mut Lists<S, F::Shape, N>, memory: &mut Memory<S, F::Shape, N>) {
        let Lists { at: [q, p], slopes: [by_p, by_q], spare, .. } = lists;
        let (q, p, by_q) = (q.as_ref(), p.as_ref(), by_q.as_mut());
        let (scratch, b) = (&mut memory.scratch, &self.table.b);
        if F::IS_NYSTROM {
            S::Stages::slopes::<F, true, false>(self.system, &self.at, q, p, by_q, spare.as_mut(), scratch);
        } else {
            let by_p = by_p.as_mut();
            S::Stages::slopes::<F, true, true>(self.system, &self.at, q, p, by_q, by_p, scratch);
            for slope in by_p {
                *slope = slope.times(b);
            }
        }
        let zero = S::Stages::<N>::splat(S::from_f64(0.0));
        for slope in by_q {
            *slope = zero.minus(slope.times(b));
        }
    }

    /// The new state from the slopes at the stages.
    #[inline(always)]
    pub(super) fn finish<C: Carry<S>>(
        &self,
        lists: &mut Lists<S, F::Shape, N>,
        carry: &C,
    ) -> Result<(), StepFailure> {
        let ones = [1.0; N];
        let Lists { slopes: [by_p, by_q], next: [next_q, next_p], lost: [lost_q, lost_p], .. } = lists;
        let (by_p, by_q) = (by_p.as_ref(), by_q.as_ref());
        let (next_q, next_p) = (next_q.as_mut(), next_p.as_mut());
        let (lost_q, lost_p) = (lost_q.as_mut(), lost_p.as_mut());
        if F::IS_NYSTROM {
            let mut rest = [0.0; N];
            for (rest, c) in rest.iter_mut().zip(&self.table.c) {
                *rest = 1.0 - c;
            }
            for (d, momentum) in next_p.iter_mut().enumerate() {
                *momentum = (self.p[d] + carry.of_momentum(d)) + by_q[d].total(&rest);
            }
            let t = S::from_f64(self.at.t);
            let (t, h, dw) = (t, self.at.h, self.at.dw);
            self.system.slopes::<S, false, true>(t, h, self.q, next_p, dw, lost_q, next_q);
        } else {
            for (increment, slopes) in next_q.iter_mut().zip(by_p) {
                *increment = slopes.total(&ones);
            }
        }
        let mut zeros = S::from_f64(0.0);
        for d in 0..self.q.len() {
            (next_q[d], lost_q[d]) = C::add(self.q[d], next_q[d], carry.of_coordinate(d));
            (next_p[d], lost_p[d]) = C::add(self.p[d], by_q[d].total(&ones), carry.of_momentum(d));
            zeros = zeros + next_q[d] * 0.0 + next_p[d] * 0.0;
        }
        if crate::scalar::Mask::all(zeros.is_finite()) { Ok(()) } else { Err(StepFailure::NonFinite) }
    }

    /// Solves for the stages.
    #[inline(always)]
    pub(super) fn solve<C: Carry<S>, const CAREFUL: bool>(
        &self,
        lists: &mut Lists<S, F::Shape, N>,
        memory: &mut Memory<S, F::Shape, N>,
        carry: &C,
    ) -> Result<Solved, StepFailure> {
        let from_past = self.remembers() && memory.is_known && !CAREFUL;
        let newton = match memory.iteration {
            Iteration::Automatic => memory.prefers_newton,
            Iteration::Newton => true,
            Iteration::FixedPoint => false,
        };
        self.guess(lists, memory, from_past, carry);
        if !newton {
            match self.sweeps(lists, memory, carry) {
                Err(failure) if memory.iteration == Iteration::FixedPoint => return Err(failure),
                Err(_) => self.guess(lists, memory, from_past, carry),
                solved => return solved,
            }
        }
        self.newton::<C, CAREFUL>(lists, memory, carry)
    }
}
