//! The traits that `#[hamiltonian]` implements.

pub(crate) mod anew;
pub(crate) mod by_dual_numbers;
mod own;
mod quantity;
mod scheme;
mod straight;

use std::fmt::Debug;
use std::ops::AddAssign;

use crate::algebra::scalar::Scalar;
use crate::algebra::solve::Effort;
use crate::algebra::state::{State, Vector, dot};
use crate::error::{ConfigError, StepFailure};
use crate::ground::variables::Variables;
use crate::scheme::constraints::Manifold;
use crate::scheme::elements::InLoops;
use crate::scheme::plan::Plan;

pub use own::{OneStep, Own, Scratch, StepField};
pub use quantity::Quantity;
pub use scheme::varied;
pub use scheme::{
    DEVIATIONS, LiftParameter, MemoryOf, Movable, PreparedOf, Properties, Scheme, SchemeOf, StepArguments,
    SumOf, TakenStep, as_they_are,
};
pub(crate) use scheme::{disequilibrium, varied_without_lists};
pub use straight::{Solution, Straight, StraightLine, array_mut, covector, gradient, increments};

/// A partial derivative with respect to the coordinates and one with respect to the momenta.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gradient<V> {
    /// `∂/∂q`
    pub q: V,
    /// `∂/∂p`
    pub p: V,
}

impl<V: Vector> Gradient<V> {
    /// The Poisson bracket `{f, g} = f_p · g_q - f_q · g_p`.
    pub(crate) fn bracket(&self, other: &Self) -> f64 {
        dot(&self.p, &other.q) - dot(&self.q, &other.p)
    }
}

/// A state of the system `H`, as in `fn energies(states: &[SystemState<Kubo>])`.
pub type SystemState<H> = State<<H as Hamiltonian>::Vector>;

/// Friction, forces and explicit time of a system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Kind {
    /// Whether friction with one rate, `dp = ... - γ p dt`, is part of every step, which is then conformally
    /// symplectic.
    pub is_conformal: bool,
    /// Whether there is a force beside the drift: [`Hamiltonian::force`].
    pub is_forced: bool,
    /// Whether noises drive forces that follow from no Hamiltonian.
    pub has_noise_forces: bool,
    /// Whether the drift reads the time.
    pub reads_time: bool,
}

impl Kind {
    /// None of these.
    pub const AUTONOMOUS: Self =
        Self { is_conformal: false, is_forced: false, has_noise_forces: false, reads_time: false };
}

/// Whether states of the system may have this many degrees of freedom.
#[must_use]
pub fn fits<H: Hamiltonian + ?Sized>(system: &H, degrees: usize) -> bool {
    degrees > 0 && matches!(system.degrees(), known if known == 0 || known == degrees)
}

/// A stochastic Hamiltonian system `dq = Σ_m ∂H_m/∂p ∘ dX_m`, `dp = Σ_m (f_m - ∂H_m/∂q) ∘ dX_m` with
/// `X_0 = t`, `X_k = W_k` and forces `f_m`: the noises with a Hamiltonian come first, then those with a
/// force.
pub trait Hamiltonian {
    /// The type of `q` and of `p`.
    type Vector: Vector;

    /// Number of degrees of freedom; 0 where only the state knows it (`q: &[f64]`).
    fn degrees(&self) -> usize;

    /// Whether a state with this many degrees of freedom can be evaluated, or why not.
    ///
    /// # Errors
    /// [`StepFailure::Dimension`] for a wrong number of degrees of freedom; [`StepFailure::Index`] if an
    /// integer of the system is out of range.
    fn check(&self, degrees: usize) -> Result<(), StepFailure> {
        let (expected, got) = (self.degrees().max(1), degrees);
        if fits(self, got) { Ok(()) } else { Err(StepFailure::Dimension { expected, got }) }
    }

    /// Friction, forces and explicit time of the system.
    const KIND: Kind = Kind::AUTONOMOUS;

    /// The rate of the friction of a [conformal](Kind::is_conformal) system, in 1/time.
    fn friction_rate(&self) -> f64 {
        0.0
    }

    /// Checks the friction, if there is any.
    ///
    /// # Errors
    /// [`ConfigError::Bath`] if a rate is negative or not finite, a damping matrix not symmetric, or a mass
    /// with friction not positive.
    fn validate(&self) -> Result<(), ConfigError> {
        Ok(())
    }

    /// Writes the force beside the drift into `into`, one component per degree of freedom; NaN where
    /// [`Hamiltonian::evaluate`] would be. It includes friction other than that of
    /// [`Hamiltonian::friction_rate`] and of thermostats.
    fn force<S: Scalar>(&self, q: &[S], p: &[S], t: f64, into: &mut [S]) {
        let _ = (p, t);
        let fits = fits(self, q.len()) && into.len() == q.len();
        into.fill(S::from_f64(if fits { 0.0 } else { f64::NAN }));
    }

    /// Number of noises: of noise Hamiltonians and of noise forces.
    fn noises(&self) -> usize {
        0
    }

    /// The manifold of the constraints, where there are any.
    fn manifold(&self) -> Option<&dyn Manifold> {
        None
    }

    /// The number of degrees of freedom that constraints leave of `degrees`: one less for each constraint. It
    /// is the number that temperatures and other shares of energy count.
    fn degrees_left(&self, degrees: usize) -> usize {
        degrees.saturating_sub(self.manifold().map_or(0, |manifold| manifold.constraints()))
    }

    /// The multipliers `λ` of the constraints in the motion through a state, one for each:
    /// `dp/dt = -∂H_0/∂q + f - Gᵀ λ` with `G = ∂g/∂q`, so that `d²g/dt² = 0`. For `g = (|q|² - l²)/2` of a
    /// rod, `λ l` is its tension. They are a function of the state, as exact as it; noise and a bath add
    /// impulses that have no rate. Empty without constraints; `None` where constraints depend on each other,
    /// or the state does not fit.
    fn multipliers(&self, state: &State<Self::Vector>) -> Option<Vec<f64>> {
        let Some(manifold) = self.manifold() else { return Some(Vec::new()) };
        let (q, p) = (state.q.components(), state.p.components());
        self.check(q.len()).ok()?;
        (q.len() == p.len()).then(|| manifold.multipliers(q, p, state.t))?
    }

    /// Number of first integrals that the compiler has proven.
    fn invariants(&self) -> usize {
        0
    }

    /// Number of observables that the system declares: `observe = [radius = |q, p| ..., ...]`.
    fn observables(&self) -> usize {
        0
    }

    /// The names of coordinates, momenta and time in the closure of the drift, of first integrals and of
    /// observables: for tables and plots.
    fn variables(&self) -> Variables {
        Variables::unnamed(self.degrees())
    }

    /// Name and value of parameter number `index` of the Hamiltonians; `None` beyond the last. Messages use
    /// it to name a parameter that differs between runs.
    fn parameter(&self, index: usize) -> Option<(&'static str, f64)> {
        let _ = index;
        None
    }

    /// The numbers of those parameters that are integers, which have no derivatives.
    fn integers(&self) -> &'static [usize] {
        &[]
    }

    /// `H_term(q, p, t)`: the drift for `term = 0`, noise `term - 1` otherwise, zero for a noise force; NaN
    /// for a term that does not exist.
    ///
    /// NaN unless `q` and `p` have [`Hamiltonian::degrees`] elements.
    fn evaluate<S: Scalar>(&self, term: usize, q: &[S], p: &[S], t: f64) -> S;

    /// The gradient of `H_term` into `dq`, `dp`, for a noise force `f` the pair `-f`, 0; NaN where
    /// [`Hamiltonian::evaluate`] would be.
    fn differentiate<S: Scalar>(&self, term: usize, q: &[S], p: &[S], t: f64, dq: &mut [S], dp: &mut [S]);

    /// The value of first integral `index`, in the order of the attribute; NaN for one that does not exist.
    fn invariant(&self, index: usize, state: &State<Self::Vector>) -> f64 {
        let _ = (index, state);
        f64::NAN
    }

    /// The value of observable `index`, in the order of the attribute; NaN for one that does not exist.
    ///
    /// Its name is in [`Variables::observables`], and [`Quantity`] finds it by that.
    fn observable(&self, index: usize, state: &State<Self::Vector>) -> f64 {
        let _ = (index, state);
        f64::NAN
    }

    /// `{H_k, H_0}` with `{f, g} = f_p · g_q - f_q · g_p`: the energy gained per unit of noise `k`,
    /// `dH_0 = Σ_k {H_k, H_0} ∘ dW_k`, for a noise force the power `f_k · ∂H_0/∂p`. Noises count from 0.
    fn energy_rate(&self, k: usize, state: &State<Self::Vector>) -> f64 {
        if k >= self.noises() || state.q.components().len() != state.p.components().len() {
            return f64::NAN;
        }
        let (noise, drift) = (self.noise_gradient(k, state), self.energy_gradient(state));
        noise.bracket(&drift)
    }

    /// The drift Hamiltonian `H_0`.
    fn energy(&self, state: &State<Self::Vector>) -> f64 {
        self.evaluate(0, state.q.components(), state.p.components(), state.t)
    }

    /// The noise Hamiltonian `H_k`; noises count from 0.
    fn noise_energy(&self, k: usize, state: &State<Self::Vector>) -> f64 {
        self.evaluate(k.saturating_add(1), state.q.components(), state.p.components(), state.t)
    }

    /// The gradient of the drift Hamiltonian.
    fn energy_gradient(&self, state: &State<Self::Vector>) -> Gradient<Self::Vector> {
        term_gradient(self, 0, state)
    }

    /// The gradient of noise Hamiltonian `k`, or `-f_k`, 0 for a noise force; noises count from 0.
    fn noise_gradient(&self, k: usize, state: &State<Self::Vector>) -> Gradient<Self::Vector> {
        term_gradient(self, k.saturating_add(1), state)
    }

    /// The gradient of `Σ_k ΔW_k H_k`, with `-ΔW_k f_k` for noise forces, of a state of the system; NaN
    /// unless `dw` has one increment per noise. Loops run over their noises once, whereas calling
    /// [`Hamiltonian::noise_gradient`] for each costs noises times degrees of freedom.
    fn differentiate_noises(
        &self,
        dw: &[f64],
        state: &State<Self::Vector>,
        into: &mut Gradient<Self::Vector>,
    ) {
        let Gradient { q, p } = into;
        let start = if dw.len() == self.noises() { 0.0 } else { f64::NAN };
        [&mut *q, &mut *p].into_iter().for_each(|list| list.components_mut().fill(start));
        for (k, dw) in dw.iter().enumerate() {
            let of_one = self.noise_gradient(k, state);
            for (sum, slope) in [(&mut *q, of_one.q), (&mut *p, of_one.p)] {
                let pairs = sum.components_mut().iter_mut().zip(slope.components());
                pairs.for_each(|(sum, slope)| *sum += dw * slope);
            }
        }
    }
}

fn term_gradient<H: Hamiltonian + ?Sized>(
    system: &H,
    term: usize,
    state: &State<H::Vector>,
) -> Gradient<H::Vector> {
    let d = state.q.components().len();
    let mut gradient = Gradient { q: H::Vector::zeros(d), p: H::Vector::zeros(d) };
    system.differentiate(
        term,
        state.q.components(),
        state.p.components(),
        state.t,
        gradient.q.components_mut(),
        gradient.p.components_mut(),
    );
    gradient
}

/// One step of a discrete path: its two nodes, its momentum `P` and its interval `[t, t + h]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment<V> {
    /// `q_i`
    pub q0: V,
    /// `q_{i+1}`
    pub q1: V,
    /// `P`, the momentum of the step.
    pub p: V,
    /// `t_i`
    pub t: f64,
    /// Step size.
    pub h: f64,
}

/// The partial derivatives of the discrete Lagrangian of one [`Segment`]; with forces, including their shares
/// of the virtual work `f⁻ · δq_i + f⁺ · δq_{i+1}` (J. E. Marsden, M. West, "Discrete mechanics and
/// variational integrators", Acta Numerica 2001, section 3.2); with friction of a rate `γ`, with the factor
/// `e^{-γ h}` in `q1`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LagrangianGradient<V> {
    /// `D_1 L_d + f⁻ = -p_i`, `D_1 L_d = ∂L_d/∂q_i`
    pub q0: V,
    /// `e^{-γ h} (D_2 L_d + f⁺) = p_{i+1}`, `D_2 L_d = ∂L_d/∂q_{i+1}`
    pub q1: V,
    /// `∂L_d/∂P`, zero on a solution.
    pub p: V,
}

impl<V: Vector> LagrangianGradient<V> {
    /// NaN everywhere, if the derivatives do not exist.
    pub(crate) fn nowhere(degrees: usize) -> Self {
        let mut nan = V::zeros(degrees);
        nan.components_mut().fill(f64::NAN);
        Self { q0: nan.clone(), q1: nan.clone(), p: nan }
    }
}

/// The residual of the discrete Euler-Lagrange equations at a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EulerLagrangeResidual<V> {
    /// `D_2 L_d(previous) + D_1 L_d(next)`, with the forces of both: the difference of the two momenta of the
    /// node.
    pub node: V,
    /// `∂L_d(next)/∂P`
    pub momentum: V,
}

/// Energy that a system received from outside, in units of energy; negative if it lost energy.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Exchange {
    /// By forces; in systems with forces, friction or a bath also by noises and explicit time: a quadrature
    /// along the steps.
    #[cfg_attr(feature = "serde", serde(with = "crate::ground::loose::number"))]
    pub work: f64,
    /// By friction and bath.
    #[cfg_attr(feature = "serde", serde(with = "crate::ground::loose::number"))]
    pub heat: f64,
}

impl AddAssign for Exchange {
    fn add_assign(&mut self, other: Self) {
        self.work += other.work;
        self.heat += other.heat;
    }
}

/// Checks that there are as many momenta as coordinates and, in full unless a state with as many
/// `was_checked`, that the system has as many.
///
/// # Errors
/// The errors of [`Hamiltonian::check`]
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn check_state(
    system: &impl Hamiltonian,
    was_checked: bool,
    [degrees, momenta]: [usize; 2],
) -> Result<(), StepFailure> {
    if !was_checked || !fits(system, degrees) {
        system.check(degrees)?;
    }
    let (expected, got) = (degrees, momenta);
    if got == expected { Ok(()) } else { Err(StepFailure::Dimension { expected, got }) }
}

/// Checks a state as [`check_state`] does, and that there is one increment per noise.
///
/// # Errors
/// The errors of [`check_state`], [`StepFailure::Increments`]
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn check_lengths(
    system: &impl Hamiltonian,
    was_checked: bool,
    [degrees, momenta, increments]: [usize; 3],
) -> Result<(), StepFailure> {
    check_state(system, was_checked, [degrees, momenta])?;
    let expected = system.noises();
    if increments == expected { Ok(()) } else { Err(StepFailure::Increments { expected, got: increments }) }
}

/// The first parameter that is not a number.
pub(crate) fn mistaken_parameter(system: &impl Hamiltonian) -> Option<&'static str> {
    let mut parameters = (0..).map_while(|index| system.parameter(index));
    parameters.find(|(_, value)| value.is_nan()).map(|(name, _)| name)
}

/// The cause with the name of a parameter that is infinite, if that may be why a state is not finite.
#[cold]
#[inline(never)]
pub(crate) fn explained(system: &impl Hamiltonian, cause: StepFailure) -> StepFailure {
    let mut parameters = (0..).map_while(|index| system.parameter(index));
    match (cause, parameters.find(|(_, value)| value.is_infinite())) {
        (StepFailure::NonFinite, Some((parameter, _))) => StepFailure::Infinite { parameter },
        (cause, _) => cause,
    }
}

/// # Errors
/// [`ConfigError::Parameter`] if a parameter is not a number.
pub(crate) fn no_nan(system: &impl Hamiltonian) -> Result<(), ConfigError> {
    mistaken_parameter(system).map_or(Ok(()), |_| Err(ConfigError::Parameter))
}

/// A system together with one embedding `E`: its discrete Lagrangian and the step derived from it. The bound
/// for generic user code; generated for every `E` that the system lists in its `embedding`.
#[diagnostic::on_unimplemented(
    message = "`{Self}` has no discretisation by `{E}`",
    label = "this scheme was not generated for `{Self}`",
    note = "only listed schemes are compiled: add `{E}` to `embedding = [...]` in the `#[hamiltonian(...)]` of `{Self}`; of a composition \
            `Composed<Verlet, ...>` add the scheme that it composes",
    note = "the weights of a composition (`Yoshida4`, `KahanLi8`, ...) are no scheme by themselves: list `Verlet`, and write \
            `Composed<Verlet, {E}>` here"
)]
pub trait Discretized<E>: Hamiltonian + Sized {
    /// The scheme of the steps.
    type Scheme: Scheme<Self, Prepared<f64> = Self::Prepared>;

    /// The data that depend on the system and the step size only.
    type Prepared: Clone + Debug + Send + Sync;

    /// The discrete Lagrangian, the discrete Euler-Lagrange equations and the step, as readable text.
    const EQUATIONS: &'static str;

    /// The scheme, if its steps are solved in loops.
    #[doc(hidden)]
    const IN_LOOPS: Option<InLoops> = None;

    /// The compile-time facts.
    const PLAN: Plan = <Self::Scheme as Scheme<Self>>::PLAN;

    /// As [`Scheme::PROPERTIES`].
    const PROPERTIES: Properties = <Self::Scheme as Scheme<Self>>::PROPERTIES;

    /// The number of increments that drive a step of a state with this many degrees of freedom: those of the
    /// noises, and after them `√h` times the standard normals of a bath.
    fn increments(&self, degrees: usize) -> usize {
        Self::Scheme::increments(self, degrees)
    }

    /// The memory of a new stepper, allocated in full if the system knows its size.
    fn memory(&self) -> MemoryOf<Self, E, f64> {
        Self::Scheme::memory(self)
    }

    /// Computes the data common to all steps.
    ///
    /// # Errors
    /// If a parameter is invalid, or a matrix that is factored here is singular.
    fn prepare(&self, h: f64) -> Result<Self::Prepared, ConfigError> {
        Self::Scheme::prepare(self, &as_they_are, h)
    }

    /// One step from `(q, p)` at `t` in place, in any numbers, with plain sums: by the fast solver, and from
    /// zero with a line search if that fails. Slices have [`Hamiltonian::degrees`] and
    /// [`Discretized::increments`] elements.
    ///
    /// # Errors
    /// If no solution was found, or sizes do not fit; `q`, `p` and `memory` are then unchanged.
    #[expect(clippy::too_many_arguments, reason = "each is one thing that a step reads")]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn advance<S: Scalar>(
        &self,
        prepared: &Self::Prepared,
        t: f64,
        h: f64,
        q: &mut [S],
        p: &mut [S],
        dw: &[S],
        memory: &mut MemoryOf<Self, E, S>,
    ) -> Result<Effort, StepFailure> {
        anew::advance::<Self, Self::Scheme, f64, S>(self, prepared, StepArguments { t, h, q, p, dw }, memory)
    }

    /// `L_d(q_i, q_{i+1}, P; t, h, ΔW)`; NaN unless `dw` has one increment per noise. A constant
    /// counter-term, which affects no equation, is left out.
    fn discrete_lagrangian(&self, segment: &Segment<Self::Vector>, dw: &[f64]) -> f64 {
        Self::Scheme::discrete_lagrangian(self, segment, dw)
    }

    /// The gradient of [`Discretized::discrete_lagrangian`].
    fn discrete_lagrangian_gradient(
        &self,
        segment: &Segment<Self::Vector>,
        dw: &[f64],
    ) -> LagrangianGradient<Self::Vector> {
        Self::Scheme::discrete_lagrangian_gradient(self, segment, dw)
    }

    /// The residual of the discrete Euler-Lagrange equations at the node between two steps with increments
    /// `previous_dw` and `next_dw`.
    fn euler_lagrange_residual(
        &self,
        previous: &Segment<Self::Vector>,
        next: &Segment<Self::Vector>,
        previous_dw: &[f64],
        next_dw: &[f64],
    ) -> EulerLagrangeResidual<Self::Vector> {
        let before = self.discrete_lagrangian_gradient(previous, previous_dw);
        let after = self.discrete_lagrangian_gradient(next, next_dw);
        let mut node = before.q1;
        for (sum, other) in node.components_mut().iter_mut().zip(after.q0.components()) {
            *sum += other;
        }
        EulerLagrangeResidual { node, momentum: after.p }
    }

    /// The momentum `P` of the step from `before` to `after`. The generated step does not store it: it
    /// follows from the equations of the node momenta, given both ends. NaN if no momentum satisfies both
    /// equations, as between states that no step joins, and where the rounding of `P` has no bound: in long
    /// steps, where the forces depend on `P` so strongly that `Σ_s a_s |∂²F/∂q∂P|` does not contract.
    fn step_momentum(
        &self,
        before: &State<Self::Vector>,
        after: &State<Self::Vector>,
        h: f64,
        dw: &[f64],
    ) -> Self::Vector {
        Self::Scheme::step_momentum(self, before, after, h, dw)
    }
}
