//! The step of a Gauss method.

use super::Field;
use super::kept::{Given, Lists, Memory};
use super::shape::Shape;
use super::stages::{At, Observer, Scratch, Stages};
use super::stiff::Modes;
use super::sweep::Solved;
use super::table::Table;
use crate::carry::Carry;
use crate::error::{ConfigError, StepFailure};
use crate::lanes::instructions::{InstructionSet, Kernel};
use crate::memory::Iteration;
use crate::scalar::{Mask, Scalar};
use crate::solve::Effort;

/// What is made once for a step size.
#[derive(Clone, Debug)]
pub struct Prepared<const N: usize> {
    table: Table<N>,
    /// The linear part of a stiff force.
    modes: Option<Modes<N>>,
    /// Friction that the step takes in.
    friction: Friction<N>,
    instructions: InstructionSet,
}

/// Friction of a rate `γ` in the momentum `π = e^{γ τ} p`, `τ` after the start of the step, for which `K = e^{γ τ} H(q, e^{-γ τ} π)` is a Hamiltonian.
#[derive(Clone, Copy, Debug)]
pub(super) struct Friction<const N: usize> {
    /// `e^{γ c_i h}`
    pub(super) scale: [f64; N],
    /// `e^{-γ c_i h}`
    pub(super) inverse: [f64; N],
    /// `e^{-γ h} - 1`
    pub(super) decay: f64,
}

impl<const N: usize> Friction<N> {
    fn new(rate: f64, table: &Table<N>, h: f64) -> Self {
        let exponents = table.c.map(|c| rate * c * h);
        Self {
            scale: exponents.map(f64::exp),
            inverse: exponents.map(|x| (-x).exp()),
            decay: (-rate * h).exp_m1(),
        }
    }
}

/// Prepares a step of size `h` with `N` stages.
///
/// # Errors
/// [`ConfigError::Parameter`] if a parameter is not a number.
pub fn prepare<F: Field, const N: usize>(system: &F, h: f64) -> Result<Prepared<N>, ConfigError> {
    let mut parameters = (0..).map_while(|index| system.parameter(index));
    if parameters.any(|(_, value)| value.is_nan()) {
        return Err(ConfigError::Parameter);
    }
    let table = Table::get();
    let modes = Modes::new(system, &table, h);
    let friction = Friction::new(system.friction_rate(), &table, h);
    Ok(Prepared { table, modes, friction, instructions: InstructionSet::best() })
}

/// The memory of a new stepper: all that its steps will need, where the system knows its size.
pub fn memory<F: Field, const N: usize>(system: &F) -> Memory<f64, F::Shape, F::Noises, N> {
    let mut memory = Memory::default();
    let degrees = system.degrees();
    if degrees != 0 && system.check(degrees).is_ok() {
        memory.fit(degrees, system.noises());
        memory.scratch.reserve(degrees, system.noises());
        memory.modal.reserve(degrees);
        if F::Shape::IS_FIXED {
            memory.exact.lists(degrees, system.noises());
        }
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
    memory: &mut Memory<S, F::Shape, F::Noises, N>,
    carry: &mut C,
) -> Result<Effort, StepFailure> {
    let degrees = q.len();
    if !memory.fits(degrees, dw.len()) || !system.fits(degrees) {
        system.check(degrees)?;
        if dw.len() == system.noises() {
            memory.fit(degrees, dw.len());
        }
    }
    if p.len() != degrees {
        return Err(StepFailure::Dimension { expected: degrees, got: p.len() });
    }
    if dw.len() != system.noises() {
        return Err(StepFailure::Increments { expected: system.noises(), got: dw.len() });
    }
    let run = Run::<F, S, C, N, CAREFUL> { system, prepared, t, h, q, p, dw, memory, carry };
    // Other numbers than `f64` are not side by side, and care is not compiled for each set of instructions.
    if size_of::<S>() == size_of::<f64>() && !CAREFUL {
        prepared.instructions.run(run)
    } else {
        run.run::<1, 1>()
    }
}

impl<const N: usize> Prepared<N> {
    pub(super) fn table(&self) -> &Table<N> {
        &self.table
    }

    pub(super) fn friction(&self) -> &Friction<N> {
        &self.friction
    }

    pub(super) fn modes(&self) -> Option<&Modes<N>> {
        self.modes.as_ref()
    }
}

/// The equations of a step, `Y = φ(Y)`.
pub(super) struct Step<'a, F, S: Scalar, const N: usize> {
    pub(super) system: &'a F,
    pub(super) prepared: &'a Prepared<N>,
    pub(super) t: f64,
    pub(super) h: f64,
    /// The stages, each weighted by its `b_i`: `h b_i` and `b_i ΔW_k`.
    pub(super) at: At<'a, S::Stages<N>>,
    /// `q` and `p` with what is carried.
    pub(super) start: [&'a [S]; 2],
}

/// A step to take.
struct Run<'a, F: Field, S: Scalar, C, const N: usize, const CAREFUL: bool> {
    system: &'a F,
    prepared: &'a Prepared<N>,
    t: f64,
    h: f64,
    q: &'a mut [S],
    p: &'a mut [S],
    dw: &'a [S],
    memory: &'a mut Memory<S, F::Shape, F::Noises, N>,
    carry: &'a mut C,
}

impl<F: Field, S: Scalar, C: Carry<S>, const N: usize, const CAREFUL: bool> Kernel
    for Run<'_, F, S, C, N, CAREFUL>
{
    type Output = Result<Effort, StepFailure>;

    #[inline(always)]
    fn run<const L: usize, const HALF: usize>(self) -> Self::Output {
        let Self { system, prepared, t, h, q, p, dw, memory, carry } = self;
        let mut given = memory.given.take();
        given.read(&prepared.table, q, p, dw, carry);
        let step = given.step(system, prepared, t, h);
        let mut lists = memory.lists.take();
        let finished = match step.solve::<CAREFUL>(&mut lists, memory) {
            Ok(solved) => step.finish([q, p], dw, &mut lists, carry).map(|()| solved),
            Err(failure) => Err(failure),
        };
        if let Ok(Solved { prefers_newton, .. }) = &finished {
            memory.prefers_newton = *prefers_newton;
            // With noise it is no guide to the next step, but it says what lies between the nodes.
            std::mem::swap(&mut memory.past, &mut lists.slopes);
            if F::IS_CONFORMAL {
                // In the momentum of the step that follows.
                let left = [1.0 + prepared.friction.decay; N];
                memory.past[1].as_mut().iter_mut().for_each(|slopes| *slopes = slopes.times(&left));
            }
            memory.is_known = dw.is_empty();
            q.copy_from_slice(lists.next[0].as_ref());
            p.copy_from_slice(lists.next[1].as_ref());
            if C::CARRIES {
                carry.keep(lists.lost[0].as_ref(), lists.lost[1].as_ref());
            }
        }
        memory.lists.give_back(lists);
        memory.given.give_back(given);
        finished.map(|solved| solved.effort)
    }
}

impl<S: Scalar, H: Shape, W: Shape, const N: usize> Given<S, H, W, N> {
    /// What is given of a step.
    #[inline(always)]
    pub(super) fn read<C: Carry<S>>(&mut self, table: &Table<N>, q: &[S], p: &[S], dw: &[S], carry: &C) {
        let Self { start: [start_q, start_p], dw: weighted } = self;
        for (d, (start, q)) in start_q.as_mut().iter_mut().zip(q).enumerate() {
            *start = *q + carry.of_coordinate(d);
        }
        for (d, (start, p)) in start_p.as_mut().iter_mut().zip(p).enumerate() {
            *start = *p + carry.of_momentum(d);
        }
        for (weighted, dw) in weighted.as_mut().iter_mut().zip(dw) {
            *weighted = S::Stages::splat(*dw).times(&table.b);
        }
    }

    /// Its equations.
    #[inline(always)]
    pub(super) fn step<'a, F>(
        &'a self,
        system: &'a F,
        prepared: &'a Prepared<N>,
        t: f64,
        h: f64,
    ) -> Step<'a, F, S, N> {
        let table = &prepared.table;
        let all = |number: f64| S::Stages::<N>::splat(S::from_f64(number));
        let at =
            At { t: all(h).times(&table.c).plus(all(t)), h: all(h).times(&table.b), dw: self.dw.as_ref() };
        Step { system, prepared, t, h, at, start: [self.start[0].as_ref(), self.start[1].as_ref()] }
    }
}

/// Where the momenta or coordinates of all stages are, and the slopes that they come from.
pub(super) struct Placement<'a, T> {
    /// `q` and `p` of the stages.
    pub(super) at: [&'a mut [T]; 2],
    /// `b_i ∂F/∂p`; in Nyström form `∂F/∂p` of the stages that are placed.
    pub(super) by_p: &'a mut [T],
    /// `b_i ∂F/∂q`; none for stages that keep the momentum of the start.
    pub(super) by_q: Option<&'a [T]>,
    /// Slopes that nobody reads.
    pub(super) spare: &'a mut [T],
}

impl<F: Field, S: Scalar, const N: usize> Step<'_, F, S, N> {
    /// The stages that follow from slopes at the same or other ones, by the columns of `once` (of integrals of the slopes) or, in
    /// Nyström form, `twice` (of the integrals of these). The observer learns of all that is replaced.
    #[inline(always)]
    pub(super) fn place(
        &self,
        into: Placement<'_, S::Stages<N>>,
        [once, twice]: [&[[f64; N]; N]; 2],
        scratch: &mut Scratch<S>,
        observer: &mut impl Observer<S::Stages<N>>,
    ) {
        let Placement { at: [q, p], by_p, by_q, spare } = into;
        if F::IS_NYSTROM {
            for (d, momenta) in p.iter_mut().enumerate() {
                let unforced = S::Stages::splat(self.start[1][d]).times(&self.prepared.table.c);
                *momenta = match by_q {
                    Some(by_q) => unforced.minus(by_q[d].product(twice)),
                    None => unforced,
                };
            }
            let at = At { h: S::Stages::splat(S::from_f64(self.h)), ..self.at };
            S::Stages::slopes::<F, false, true>(self.system, &at, q, p, spare, by_p, scratch);
            for (d, stages) in q.iter_mut().enumerate() {
                let next = S::Stages::splat(self.start[0][d]).plus(by_p[d]);
                observer.see(0, d, *stages, next);
                *stages = next;
            }
        } else {
            for d in 0..q.len() {
                let (start_q, start_p) =
                    (S::Stages::splat(self.start[0][d]), S::Stages::splat(self.start[1][d]));
                let [next_q, next_p] = match by_q {
                    Some(by_q) => [start_q.plus(by_p[d].product(once)), start_p.minus(by_q[d].product(once))],
                    None => [start_q, start_p],
                };
                observer.see(0, d, q[d], next_q);
                observer.see(1, d, p[d], next_p);
                (q[d], p[d]) = (next_q, next_p);
            }
        }
    }

    /// The stages to start from: what the slopes of the last step extrapolate to, else those of the state itself.
    #[inline(always)]
    pub(super) fn guess<W: Shape>(
        &self,
        lists: &mut Lists<S, F::Shape, N>,
        memory: &mut Memory<S, F::Shape, W, N>,
        from_past: bool,
    ) {
        let Lists { at: [q, p], slopes: [velocity, _], spare, .. } = lists;
        let [by_p, by_q] = &mut memory.past;
        let by_p = if F::IS_NYSTROM { velocity } else { by_p };
        let into = Placement {
            at: [q.as_mut(), p.as_mut()],
            by_p: by_p.as_mut(),
            by_q: if from_past { Some(by_q.as_ref()) } else { None },
            spare: spare.as_mut(),
        };
        self.place(into, [&self.prepared.table.nu, &self.prepared.table.kappa], &mut memory.scratch, &mut ());
    }

    /// `b_i ∂F/∂p` and `b_i ∂F/∂q` at the stages.
    #[inline(always)]
    pub(super) fn field(&self, lists: &mut Lists<S, F::Shape, N>, scratch: &mut Scratch<S>) {
        let Lists { at: [q, p], slopes: [by_p, by_q], spare, .. } = lists;
        let (q, p, by_q) = (q.as_ref(), p.as_ref(), by_q.as_mut());
        if F::IS_NYSTROM {
            S::Stages::slopes::<F, true, false>(self.system, &self.at, q, p, by_q, spare.as_mut(), scratch);
        } else if F::IS_CONFORMAL {
            let Friction { scale, inverse, .. } = self.prepared.friction();
            let own = spare.as_mut();
            own.iter_mut().zip(p).for_each(|(own, p)| *own = p.times(inverse));
            S::Stages::slopes::<F, true, true>(self.system, &self.at, q, own, by_q, by_p.as_mut(), scratch);
            by_q.iter_mut().for_each(|slopes| *slopes = slopes.times(scale));
        } else {
            S::Stages::slopes::<F, true, true>(self.system, &self.at, q, p, by_q, by_p.as_mut(), scratch);
        }
    }

    /// The new state from the slopes at the stages.
    #[inline(always)]
    pub(super) fn finish<C: Carry<S>>(
        &self,
        [q, p]: [&[S]; 2],
        dw: &[S],
        lists: &mut Lists<S, F::Shape, N>,
        carry: &C,
    ) -> Result<(), StepFailure> {
        let Lists { slopes: [by_p, by_q], next: [next_q, next_p], lost: [lost_q, lost_p], .. } = lists;
        let (by_p, by_q) = (by_p.as_ref(), by_q.as_ref());
        let (next_q, next_p) = (next_q.as_mut(), next_p.as_mut());
        let (lost_q, lost_p) = (lost_q.as_mut(), lost_p.as_mut());
        if F::IS_NYSTROM {
            let mut rest = [0.0; N];
            for (rest, c) in rest.iter_mut().zip(&self.prepared.table.c) {
                *rest = 1.0 - c;
            }
            for (d, momentum) in next_p.iter_mut().enumerate() {
                *momentum = self.start[1][d] - by_q[d].times(&rest).total();
            }
            let (t, h) = (S::from_f64(self.t), S::from_f64(self.h));
            self.system.slopes::<S, false, true>(t, h, q, next_p, dw, lost_q, next_q);
        } else {
            for (increment, slopes) in next_q.iter_mut().zip(by_p) {
                *increment = slopes.total();
            }
        }
        let zero = S::from_f64(0.0);
        let mut zeros = zero;
        for d in 0..q.len() {
            (next_q[d], lost_q[d]) = C::add(q[d], next_q[d], carry.of_coordinate(d));
            let mut change = zero - by_q[d].total();
            if F::IS_CONFORMAL {
                change = change + (self.start[1][d] + change) * self.prepared.friction.decay;
            }
            (next_p[d], lost_p[d]) = C::add(p[d], change, carry.of_momentum(d));
            zeros = zeros + next_q[d] * 0.0 + next_p[d] * 0.0;
        }
        if zeros.is_finite().all() { Ok(()) } else { Err(StepFailure::NonFinite) }
    }

    /// Solves for the stages.
    #[inline(always)]
    pub(super) fn solve<const CAREFUL: bool>(
        &self,
        lists: &mut Lists<S, F::Shape, N>,
        memory: &mut Memory<S, F::Shape, F::Noises, N>,
    ) -> Result<Solved, StepFailure> {
        // The steps before are a guide without noise only.
        let from_past = self.at.dw.is_empty() && memory.is_known && !CAREFUL;
        let newton = match memory.iteration {
            Iteration::Automatic => memory.prefers_newton,
            Iteration::Newton => true,
            Iteration::FixedPoint => false,
        };
        self.guess(lists, memory, from_past);
        if !newton {
            let Memory { scratch, modal, exact, .. } = memory;
            match self.sweeps(lists, scratch, modal, exact) {
                Err(StepFailure::NonFinite) => return Err(StepFailure::NonFinite),
                Err(failure) if memory.iteration == Iteration::FixedPoint => return Err(failure),
                Err(_) => self.guess(lists, memory, from_past),
                solved => return solved,
            }
        }
        self.newton::<CAREFUL>(lists, memory)
    }
}
