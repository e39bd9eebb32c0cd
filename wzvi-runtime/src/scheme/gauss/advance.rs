//! The step of a Gauss method.

use super::Field;
use super::memory::{GaussHistoryOf, GaussInput, GaussInputOf, GaussMemory, GaussMemoryOf, StageLists};
use super::stiff::{StiffModes, StiffSpectrum};
use super::sweep::StepOutcome;
use super::tableau::{NodePolynomials, Tableau};
use crate::algebra::lanes::Lanes;
use crate::algebra::lanes::instructions::{InstructionSet, Kernel};
use crate::algebra::scalar::{ComputesWith, Constant, Constants, ConstantsIn, Parameters, Scalar};
use crate::algebra::shape::Shape;
use crate::algebra::solve::Effort;
use crate::algebra::state_sum::StateSum;
use crate::error::{ConfigError, StepFailure};
use crate::scheme::system::{
    Hamiltonian as _, LiftParameter, StepArguments, check_lengths, no_nan, varied_without_lists,
};

/// The constants for one step size, with the parameters `P` of a system.
#[derive(Clone, Debug)]
pub struct GaussConstants<P, const N: usize, K = f64> {
    pub(super) parameters: P,
    pub(super) friction: FrictionScaling<N, K>,
    pub(super) common: SharedConstants<N>,
    /// The step size of the first lane.
    h: f64,
}

impl<P, const N: usize, K: Constant> GaussConstants<P, N, K> {
    /// The parameters of the system.
    pub(in crate::scheme) fn parameters_mut(&mut self) -> &mut P {
        &mut self.parameters
    }

    /// The weights `b_i` of the stages.
    pub(in crate::scheme) fn weights(&self) -> &[f64; N] {
        &self.common.table.b
    }

    /// Makes these constants those for steps of another size. The stages of the next step start from the
    /// derivatives of a step of the size before.
    ///
    /// # Errors
    /// The errors of a friction that is invalid.
    pub(super) fn resize<F: Field>(
        &mut self,
        system: &F,
        lift: LiftParameter<'_, K>,
        h: K,
    ) -> Result<(), ConfigError>
    where
        F::Parameters: Constants<In<K> = P>,
    {
        let size = h.lane(0);
        let SharedConstants { table, polynomials, .. } = &mut self.common;
        let known = polynomials.get_or_insert_with(|| Box::new(table.node_polynomials()));
        table.extrapolate(known, size / self.h);
        self.h = size;
        if F::FACTS.kind.is_conformal {
            let rate = system.friction_rate(&varied_without_lists(system, lift)?);
            self.friction = FrictionScaling::new(rate, &self.common.table, h);
        }
        let SharedConstants { table, spectrum, modes, .. } = &mut self.common;
        *modes = spectrum.as_ref().and_then(|spectrum| spectrum.modes(table, size));
        Ok(())
    }
}

/// The constants that systems in lanes have in common.
#[derive(Clone, Debug)]
pub(super) struct SharedConstants<const N: usize> {
    table: Tableau<N>,
    /// The linear part of a stiff force. It affects the convergence of sweeps, not their result, and so
    /// carries no derivatives.
    modes: Option<StiffModes<N>>,
    spectrum: Option<StiffSpectrum>,
    /// Made for the first step of another size.
    polynomials: Option<Box<NodePolynomials<N>>>,
    instructions: InstructionSet,
    /// The instructions for one path, whose lists have a number for each stage.
    of_stages: InstructionSet,
}

/// The constants of a system.
pub(super) type GaussConstantsOf<F, K, const N: usize> =
    GaussConstants<ConstantsIn<<F as Field>::Parameters, K>, N, K>;

/// Friction of a rate `γ` in the momentum `π = e^{γ τ} p`, `τ` after the start of the step, for which
/// `K = e^{γ τ} H(q, e^{-γ τ} π)` is a Hamiltonian.
#[derive(Clone, Copy, Debug)]
pub(super) struct FrictionScaling<const N: usize, K = f64> {
    /// `e^{γ c_i h}`
    pub(super) scale: [K; N],
    /// `e^{-γ c_i h}`
    pub(super) inverse: [K; N],
    /// `e^{-γ h} - 1`
    pub(super) decay: K,
}

impl<const N: usize, K: Constant> FrictionScaling<N, K> {
    fn new(rate: K, table: &Tableau<N>, h: K) -> Self {
        let exponents = table.c.map(|c| rate * c * h);
        Self {
            scale: exponents.map(K::exp),
            inverse: exponents.map(|x| (-x).exp()),
            decay: (-rate * h).exp_m1(),
        }
    }

    /// The factors of one lane.
    pub(super) fn lane(&self, lane: usize) -> FrictionScaling<N> {
        let [scale, inverse] = [self.scale, self.inverse].map(|list| list.map(|factor| factor.lane(lane)));
        FrictionScaling { scale, inverse, decay: self.decay.lane(lane) }
    }
}

/// Prepares a step of size `h` with `N` stages.
///
/// # Errors
/// [`ConfigError::Parameter`] if a parameter is not a number.
pub(super) fn prepare<F: Field, K: Constant, const N: usize>(
    system: &F,
    lift: LiftParameter<'_, K>,
    h: K,
) -> Result<GaussConstantsOf<F, K, N>, ConfigError> {
    no_nan(system)?;
    let table = Tableau::get();
    let parameters = system.parameters(lift);
    let spectrum = StiffSpectrum::new(system, &F::Parameters::lane(&parameters, 0), &table);
    let modes = spectrum.as_ref().and_then(|spectrum| spectrum.modes(&table, h.lane(0)));
    let rate = match F::FACTS.kind.is_conformal {
        true => system.friction_rate(&varied_without_lists(system, lift)?),
        false => K::from_f64(0.0),
    };
    let friction = FrictionScaling::new(rate, &table, h);
    let instructions = InstructionSet::best();
    let common = SharedConstants {
        table,
        modes,
        spectrum,
        polynomials: None,
        instructions,
        of_stages: instructions.for_list(N),
    };
    Ok(GaussConstants { parameters, friction, common, h: h.lane(0) })
}

/// The constants of systems in lanes; `None` if friction or a stiff force makes them differ between systems.
pub(super) fn gather<F: Field, const L: usize, const N: usize>(
    prepared: [&GaussConstantsOf<F, f64, N>; L],
) -> Option<GaussConstantsOf<F, Lanes<L>, N>> {
    if F::FACTS.kind.is_conformal || prepared.iter().any(|prepared| prepared.common.modes.is_some()) {
        return None;
    }
    let parameters = super::gather::<F, L>(prepared.map(|prepared| &prepared.parameters))?;
    let GaussConstants { common, h, .. } = prepared.first()?;
    let (common, h) = (common.clone(), *h);
    let none = FrictionScaling::new(Lanes::from_f64(0.0), common.table(), Lanes::from_f64(0.0));
    Some(GaussConstants { parameters, friction: none, common, h })
}

/// The memory of a new stepper, allocated in full if the system knows its size.
pub(super) fn memory<F: Field, const N: usize>(system: &F) -> GaussMemory<f64, F::Shape, F::Noises, N> {
    let mut memory = GaussMemory::default();
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
pub(super) fn advance<
    F: Field,
    K: Constant,
    S: ComputesWith<K>,
    C: StateSum<S>,
    const N: usize,
    const CAREFUL: bool,
>(
    system: &F,
    (parameters, friction, common): (
        &ConstantsIn<F::Parameters, K>,
        &FrictionScaling<N, K>,
        &SharedConstants<N>,
    ),
    StepArguments { t, h, q, p, dw }: StepArguments<'_, S, K>,
    memory: &mut GaussMemoryOf<F, S, N>,
    carry: &mut C,
) -> Result<Effort, StepFailure> {
    let degrees = q.len();
    let is_ready = memory.fits(degrees, dw.len());
    check_lengths(system, is_ready, [degrees, p.len(), dw.len()])?;
    if !is_ready {
        memory.fit(degrees, dw.len());
    }
    let step =
        GaussStep::<F, K, S, C, N, CAREFUL> { system, parameters, friction, common, t, h, q, p, dw, carry };
    let run = GaussStepWithMemory { step, memory };
    // Numbers other than `f64` are scalar or are vectors already; careful steps are not compiled for each
    // instruction set.
    if size_of::<S>() == size_of::<f64>() && !S::LANES_ARE_PATHS && !CAREFUL {
        common.of_stages.run(run)
    } else {
        run.run::<1, 1>()
    }
}

impl<const N: usize> SharedConstants<N> {
    pub(super) fn table(&self) -> &Tableau<N> {
        &self.table
    }

    pub(super) fn instructions(&self) -> InstructionSet {
        self.instructions
    }

    pub(super) fn modes(&self) -> Option<&StiffModes<N>> {
        self.modes.as_ref()
    }
}

/// A step to take.
struct GaussStep<'a, F: Field, K: Constant, S, C, const N: usize, const CAREFUL: bool> {
    system: &'a F,
    parameters: &'a ConstantsIn<F::Parameters, K>,
    friction: &'a FrictionScaling<N, K>,
    common: &'a SharedConstants<N>,
    t: K,
    h: K,
    q: &'a mut [S],
    p: &'a mut [S],
    dw: &'a [S],
    carry: &'a mut C,
}

/// A step to take, with its memory.
struct GaussStepWithMemory<'a, F: Field, K: Constant, S: Scalar, C, const N: usize, const CAREFUL: bool> {
    step: GaussStep<'a, F, K, S, C, N, CAREFUL>,
    memory: &'a mut GaussMemoryOf<F, S, N>,
}

impl<F: Field, K: Constant, S: ComputesWith<K>, C: StateSum<S>, const N: usize, const CAREFUL: bool> Kernel
    for GaussStepWithMemory<'_, F, K, S, C, N, CAREFUL>
{
    type Output = Result<Effort, StepFailure>;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn run<const L: usize, const HALF: usize>(self) -> Self::Output {
        let GaussMemory { left, given, lists } = self.memory;
        if S::LANES_ARE_PATHS {
            // They exceed the registers, and so remain in memory.
            return self.step.take(given, lists, left);
        }
        let mut own_given = F::Shape::lend(given, GaussInput::of_length(0, 0));
        let mut own_lists = F::Shape::lend(lists, StageLists::of_length(0));
        let taken = self.step.take(&mut own_given, &mut own_lists, left);
        F::Shape::give_back(lists, own_lists);
        F::Shape::give_back(given, own_given);
        taken
    }
}

impl<F: Field, K: Constant, S: ComputesWith<K>, C: StateSum<S>, const N: usize, const CAREFUL: bool>
    GaussStep<'_, F, K, S, C, N, CAREFUL>
{
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn take(
        self,
        given: &mut GaussInputOf<F, S, N>,
        lists: &mut StageLists<S, F::Shape, N>,
        left: &mut GaussHistoryOf<F, S, N>,
    ) -> Result<Effort, StepFailure> {
        let Self { system, parameters, friction, common, t, h, q, p, dw, carry } = self;
        given.read(common, q, p, dw, carry);
        let step = given.step(system, (parameters, friction, common), [t, h]);
        let solved = if S::LANES_ARE_PATHS && !C::CARRIES && !CAREFUL {
            step.solve_lanes([q, p], dw, lists, left)
        } else {
            step.solve_stages::<C, CAREFUL>([q, p], dw, lists, left, carry)
        };
        let StepOutcome { effort, waits } = solved?;
        left.waits = waits;
        // With noise the derivatives do not predict the next step, but the dense output of a single path
        // needs them.
        if !S::LANES_ARE_PATHS || dw.is_empty() {
            let [by_p, by_q] = &mut left.past;
            if !S::LANES_ARE_PATHS || !F::IS_NYSTROM {
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
