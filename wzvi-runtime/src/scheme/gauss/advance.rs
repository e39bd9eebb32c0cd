//! The step of a Gauss method.

use super::Field;
use super::kept::{Given, GivenOf, LeftOf, Lists, Memory, MemoryOf};
use super::stiff::Modes;
use super::sweep::Solved;
use super::table::Table;
use crate::algebra::carry::Carry;
use crate::algebra::lanes::Lanes;
use crate::algebra::lanes::instructions::{InstructionSet, Kernel};
use crate::algebra::scalar::{Constant, Of, Over, Parameters, Scalar};
use crate::algebra::shape::Shape;
use crate::algebra::solve::Effort;
use crate::error::{ConfigError, StepFailure};
use crate::scheme::system::{At, Hamiltonian as _, Lift, check_lengths, no_nan, varied_without_lists};

/// The constants for one step size, with the parameters `P` of a system.
#[derive(Clone, Debug)]
pub struct Prepared<P, const N: usize, K = f64> {
    pub(super) parameters: P,
    pub(super) friction: Friction<N, K>,
    pub(super) common: Common<N>,
}

/// The constants that systems in lanes have in common.
#[derive(Clone, Debug)]
pub(super) struct Common<const N: usize> {
    table: Table<N>,
    /// The linear part of a stiff force. It affects the convergence of sweeps, not their result, and so
    /// carries no derivatives.
    modes: Option<Modes<N>>,
    /// Friction that is part of the step.
    instructions: InstructionSet,
}

/// The constants of a system.
pub(super) type PreparedOf<F, K, const N: usize> = Prepared<Of<<F as Field>::Parameters, K>, N, K>;

/// Friction of a rate `γ` in the momentum `π = e^{γ τ} p`, `τ` after the start of the step, for which
/// `K = e^{γ τ} H(q, e^{-γ τ} π)` is a Hamiltonian.
#[derive(Clone, Copy, Debug)]
pub(super) struct Friction<const N: usize, K = f64> {
    /// `e^{γ c_i h}`
    pub(super) scale: [K; N],
    /// `e^{-γ c_i h}`
    pub(super) inverse: [K; N],
    /// `e^{-γ h} - 1`
    pub(super) decay: K,
}

impl<const N: usize, K: Constant> Friction<N, K> {
    fn new(rate: K, table: &Table<N>, h: K) -> Self {
        let exponents = table.c.map(|c| rate * c * h);
        Self {
            scale: exponents.map(K::exp),
            inverse: exponents.map(|x| (-x).exp()),
            decay: (-rate * h).exp_m1(),
        }
    }

    /// The factors of one lane.
    pub(super) fn lane(&self, lane: usize) -> Friction<N> {
        let [scale, inverse] = [self.scale, self.inverse].map(|list| list.map(|factor| factor.lane(lane)));
        Friction { scale, inverse, decay: self.decay.lane(lane) }
    }
}

/// Prepares a step of size `h` with `N` stages.
///
/// # Errors
/// [`ConfigError::Parameter`] if a parameter is not a number.
pub(super) fn prepare<F: Field, K: Constant, const N: usize>(
    system: &F,
    lift: Lift<'_, K>,
    h: K,
) -> Result<PreparedOf<F, K, N>, ConfigError> {
    no_nan(system)?;
    let table = Table::get();
    let parameters = system.parameters(lift);
    let modes = Modes::new(system, &F::Parameters::lane(&parameters, 0), &table, h.lane(0));
    let rate = match F::FACTS.kind.is_conformal {
        true => system.friction_rate(&varied_without_lists(system, lift)?),
        false => K::from_f64(0.0),
    };
    let friction = Friction::new(rate, &table, h);
    let common = Common { table, modes, instructions: InstructionSet::best() };
    Ok(Prepared { parameters, friction, common })
}

/// The constants of systems in lanes; `None` if friction or a stiff force makes them differ between systems.
pub(super) fn gather<F: Field, const L: usize, const N: usize>(
    prepared: [&PreparedOf<F, f64, N>; L],
) -> Option<PreparedOf<F, Lanes<L>, N>> {
    if F::FACTS.kind.is_conformal || prepared.iter().any(|prepared| prepared.common.modes.is_some()) {
        return None;
    }
    let parameters = super::gather::<F, L>(prepared.map(|prepared| &prepared.parameters))?;
    let common = prepared.first()?.common.clone();
    let none = Friction::new(Lanes::from_f64(0.0), common.table(), Lanes::from_f64(0.0));
    Some(Prepared { parameters, friction: none, common })
}

/// The memory of a new stepper, allocated in full if the system knows its size.
pub(super) fn memory<F: Field, const N: usize>(system: &F) -> Memory<f64, F::Shape, F::Noises, N> {
    let mut memory = Memory::default();
    let degrees = system.degrees();
    if degrees != 0 && system.check(degrees).is_ok() {
        memory.fit(degrees, system.noises());
        if !F::IN_LANES {
            memory.left.scratch.reserve(degrees, system.noises());
        }
        memory.left.modal.reserve(degrees);
        if F::Shape::IS_FIXED {
            memory.left.exact.lists(degrees, system.noises());
        }
    }
    memory
}

/// One step from `(q, p)` at `t` in place. On `Err`, `q`, `p`, `memory` and `carry` are as they were.
///
/// # Errors
/// [`StepFailure::NotConverged`], [`StepFailure::NonFinite`], or where sizes do not fit.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn advance<F: Field, K: Constant, S: Over<K>, C: Carry<S>, const N: usize, const CAREFUL: bool>(
    system: &F,
    (parameters, friction, common): (&Of<F::Parameters, K>, &Friction<N, K>, &Common<N>),
    At { t, h, q, p, dw }: At<'_, S, K>,
    memory: &mut MemoryOf<F, S, N>,
    carry: &mut C,
) -> Result<Effort, StepFailure> {
    let degrees = q.len();
    let is_ready = memory.fits(degrees, dw.len());
    check_lengths(system, is_ready, [degrees, p.len(), dw.len()])?;
    if !is_ready {
        memory.fit(degrees, dw.len());
    }
    let step =
        ToTake::<F, K, S, C, N, CAREFUL> { system, parameters, friction, common, t, h, q, p, dw, carry };
    let run = Run { step, memory };
    // Numbers other than `f64` are scalar or are vectors already; careful steps are not compiled for each
    // instruction set.
    if size_of::<S>() == size_of::<f64>() && !S::IS_BESIDE && !CAREFUL {
        common.instructions.run(run)
    } else {
        run.run::<1, 1>()
    }
}

impl<const N: usize> Common<N> {
    pub(super) fn table(&self) -> &Table<N> {
        &self.table
    }

    pub(super) fn instructions(&self) -> InstructionSet {
        self.instructions
    }

    pub(super) fn modes(&self) -> Option<&Modes<N>> {
        self.modes.as_ref()
    }
}

/// A step to take.
struct ToTake<'a, F: Field, K: Constant, S, C, const N: usize, const CAREFUL: bool> {
    system: &'a F,
    parameters: &'a Of<F::Parameters, K>,
    friction: &'a Friction<N, K>,
    common: &'a Common<N>,
    t: K,
    h: K,
    q: &'a mut [S],
    p: &'a mut [S],
    dw: &'a [S],
    carry: &'a mut C,
}

/// A step to take, with its memory.
struct Run<'a, F: Field, K: Constant, S: Scalar, C, const N: usize, const CAREFUL: bool> {
    step: ToTake<'a, F, K, S, C, N, CAREFUL>,
    memory: &'a mut MemoryOf<F, S, N>,
}

impl<F: Field, K: Constant, S: Over<K>, C: Carry<S>, const N: usize, const CAREFUL: bool> Kernel
    for Run<'_, F, K, S, C, N, CAREFUL>
{
    type Output = Result<Effort, StepFailure>;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn run<const L: usize, const HALF: usize>(self) -> Self::Output {
        let Memory { left, given, lists } = self.memory;
        if S::IS_BESIDE {
            // They exceed the registers, and so remain in memory.
            return self.step.take(given, lists, left);
        }
        let mut own_given = F::Shape::lend(given, Given::of_length(0, 0));
        let mut own_lists = F::Shape::lend(lists, Lists::of_length(0));
        let taken = self.step.take(&mut own_given, &mut own_lists, left);
        F::Shape::give_back(lists, own_lists);
        F::Shape::give_back(given, own_given);
        taken
    }
}

impl<F: Field, K: Constant, S: Over<K>, C: Carry<S>, const N: usize, const CAREFUL: bool>
    ToTake<'_, F, K, S, C, N, CAREFUL>
{
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn take(
        self,
        given: &mut GivenOf<F, S, N>,
        lists: &mut Lists<S, F::Shape, N>,
        left: &mut LeftOf<F, S, N>,
    ) -> Result<Effort, StepFailure> {
        let Self { system, parameters, friction, common, t, h, q, p, dw, carry } = self;
        given.read(common, q, p, dw, carry);
        let step = given.step(system, (parameters, friction, common), [t, h]);
        let solved = if S::IS_BESIDE && !C::CARRIES && !CAREFUL {
            step.solve_beside([q, p], dw, lists, left)
        } else {
            step.solve_together::<C, CAREFUL>([q, p], dw, lists, left, carry)
        };
        let Solved { effort, waits } = solved?;
        left.waits = waits;
        // With noise the slopes do not predict the next step, but the dense output of a single path needs
        // them.
        if !S::IS_BESIDE || dw.is_empty() {
            let [by_p, by_q] = &mut left.past;
            if !S::IS_BESIDE || !F::IS_NYSTROM {
                std::mem::swap(by_p, &mut lists.slopes[0]);
            }
            std::mem::swap(by_q, &mut lists.slopes[1]);
        }
        (left.is_known, left.is_held) = (dw.is_empty(), false);
        q.copy_from_slice(lists.next[0].as_ref());
        p.copy_from_slice(lists.next[1].as_ref());
        if C::CARRIES {
            carry.keep(lists.lost[0].as_ref(), lists.lost[1].as_ref());
        }
        Ok(effort)
    }
}
