//! Systems of elements: the code that `#[hamiltonian]` generates for a phase space of unknown dimension, and
//! the step that uses it.
//!
//! The compiler gives the discrete Lagrangian as a table of [`QuadraturePoint`]s, and the derivatives of the
//! terms of the step Hamiltonian by their [`Role`]s. Each stage has the weights of `q_i` and `q_{i+1}` in its
//! coordinates and the roles that are evaluated there. The unknowns are the increments `u = q_{i+1} - q_i`
//! and `v = P - p_i` of the discrete Euler-Lagrange equations
//!
//! ```text
//! L_d = P · u - Σ_s F_s(P, Q_s, T_s),  Q_s = q_i + c_s u,  T_s = t_i + c_s h,  P = p_i + v
//! ∂L_d/∂P = 0:        u = Σ_s ∂F_s/∂p
//! p_i = -D_1 L_d:     v = -Σ_s start_s ∂F_s/∂q
//! p_{i+1} = D_2 L_d:  p_{i+1} - p_i = v - Σ_s end_s ∂F_s/∂q
//! ```
//!
//! An implicit step iterates `x ← φ(x)` while its measured contraction says that this finishes with fewer
//! operations than Newton's method. For steps that are not stiff this is several times cheaper. Otherwise the
//! step uses Newton's method with the factors of an earlier iteration or step, as long as these finish with
//! fewer operations than new ones. Both end when what each correction leaves is below the rounding of its
//! unknown plus the state that it changes, or when none changes the points of evaluation by more than a
//! quarter of their rounding, or when each equation is at the rounding of its own terms: the choice affects
//! the cost, but no significant digit. If neither converges, the stepper takes a careful step.
//!
//! The linear equations of Newton's method are solved by elimination in a band, after a renumbering of the
//! unknowns, if the band is narrow or small ([`Method::Band`]: chains, rings, networks, anything of a hundred
//! unknowns), otherwise by GMRES with products with the Jacobian, which is not stored ([`Method::Krylov`]:
//! lattices, random graphs, all pairs). Its preconditioner is a factorisation of the Jacobian of an earlier
//! step: first an incomplete one, with the pattern of the Jacobian; if that takes too many products, a
//! complete one in the order of a nested dissection, with which one product is enough at any stiffness.

mod bath;
mod careful;
mod change;
mod collective;
mod costs;
mod differentiate;
mod explicit;
mod factor_cache;
mod gather;
mod hamiltonian;
mod in_loops;
mod iterate;
mod jacobian;
mod lagrangian;
mod lanes;
mod linear;
mod low_rank;
mod memory;
mod pairs;
mod passes;
mod past;
#[doc(hidden)]
pub mod places;
mod preference;
mod quadrature;
mod role;
mod rounding;
mod step;
mod sums;
mod tiles;

pub(crate) use bath::{damping, rates, temperatures};
pub use collective::{CollectiveHessian, CollectiveVariables};
pub use gather::Placements;
pub(crate) use hamiltonian::forces;
pub use in_loops::{InLoops, Loops};
pub(crate) use lagrangian::{discrete_lagrangian, discrete_lagrangian_gradient, step_momentum};
pub use memory::LoopMemory;
pub use pairs::{Pair, PairColumns, Row};
pub(crate) use passes::are_finite;
pub use quadrature::{Linearity, MomentumUpdate, Quadrature, QuadraturePoint, Unknowns};
pub use role::{Role, WeightedRole};
pub(crate) use step::nothing;
pub use sums::{AdjacentSums, ElementInput, Sums, disjoint_placements, stretch};
pub(crate) use tiles::{BLOCK, MOST_IN_ONE_TILE};
pub use tiles::{Flow, ForceArguments, LEAST_IN_TILES, NewState, TileParts, TilePlan, take_tiles};

use std::ops::Range;

pub use crate::algebra::lanes::common_range::CommonRange;
pub use crate::algebra::memory::{Iteration, Method};

use crate::algebra::scalar::{Constant, Number, Scalar};
use crate::algebra::shape::Shape;
use crate::algebra::state::Vector;
use crate::error::{ConfigError, StepFailure};
use crate::ground::variables::Variables;
use crate::scheme::constraints::Manifold;
use crate::scheme::plan::Facts;
use crate::scheme::system::no_nan;

/// The derivatives that are wanted. A variable that an element does not read costs nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Partials {
    /// By coordinates.
    pub by_q: bool,
    /// By momenta.
    pub by_p: bool,
}

impl Partials {
    /// By all.
    pub const ALL: Self = Self { by_q: true, by_p: true };
    /// By coordinates. Elements that read both halves of the phase space add those by momenta, too.
    pub const BY_COORDINATES: Self = Self { by_q: true, by_p: false };
    /// By momenta. Elements that read both halves of the phase space add those by coordinates, too.
    pub const BY_MOMENTA: Self = Self { by_q: false, by_p: true };
}

/// The point at which elements are evaluated, and their weights.
#[derive(Clone, Debug)]
pub struct EvaluationPoint<'a, S: Scalar, V: ?Sized = [S]> {
    /// Coordinates.
    pub q: &'a V,
    /// Momenta.
    pub p: &'a V,
    /// Time.
    pub t: S::Constant,
    /// The increment of the drift.
    pub h: S::Constant,
    /// All parameters, where they have derivatives: [`EvaluationPoint::parameter`].
    pub parameters: &'a [S::Constant],
    /// The increments of the noises that act.
    pub dw: &'a [S],
    /// The numbers of the noises that act: all in a step, one for a single noise Hamiltonian.
    pub acting: Range<usize>,
    /// `e^{γ (t - t_i)}`, the ratio of these momenta to those of the state, with the rate `γ` of the friction
    /// that steps include.
    pub scale: S::Constant,
}

impl<S: Scalar, V: ElementInput<S> + ?Sized> EvaluationPoint<'_, S, V> {
    /// The degrees of freedom of the system.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn degrees(&self) -> usize {
        self.q.degrees()
    }

    /// The parameter `number` of the system, which has this value.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn parameter(&self, number: usize, value: f64) -> S::Constant {
        S::Constant::parameter(self.parameters, number, value)
    }

    /// The increment of a noise that acts.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn increment(&self, noise: usize) -> S {
        self.dw[noise - self.acting.start]
    }
}

/// The variables of a second derivative.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HessianBlock {
    /// `∂²/∂q_i ∂q_j`, or `-∂f_i/∂q_j` of a force.
    QQ,
    /// `∂²/∂q_i ∂p_j`, or `-∂f_i/∂p_j` of a force.
    QP,
    /// `∂²/∂p_i ∂p_j`
    PP,
}

/// The generated code of a system whose Hamiltonians are sums of elements. Such a system is a
/// [`Hamiltonian`](crate::scheme::system::Hamiltonian).
///
/// Each element belongs to a term with a [`Role`]. Elements with one role are evaluated together, weighted by
/// `weight` and by their increments.
pub trait Elements: Sized {
    /// As `Hamiltonian::Vector`.
    type Vector: Vector;

    /// The facts that the compiler derived about the system.
    const FACTS: Facts;

    /// Lists of one entry per degree of freedom in steps of flows and stages.
    type Shape: Shape;

    /// The structure that compositions exploit, such as [`General`](crate::scheme::compose::General).
    type Structure;

    /// Reads of the elements that the compiler has not proven to be in range.
    #[doc(hidden)]
    const PLACES: places::Places = places::Places { components: 1, tables: &[], nests: &[] };

    /// A range of the list `table` of [`Elements::PLACES`], or of the list nested in it at the indices
    /// `outer`.
    #[doc(hidden)]
    fn entries(&self, table: usize, outer: &[usize], range: Range<usize>) -> places::Entries {
        let _ = (table, outer, range);
        places::Entries::of_length(0)
    }

    /// As `Hamiltonian::degrees`.
    fn degrees(&self) -> usize {
        if Self::FACTS.degrees == usize::MAX { 0 } else { Self::FACTS.degrees }
    }

    /// As `Hamiltonian::noises`.
    fn noises(&self) -> usize {
        0
    }

    /// As `Hamiltonian::invariants`.
    fn invariants(&self) -> usize {
        0
    }

    /// As `Hamiltonian::observables`.
    fn observables(&self) -> usize {
        0
    }

    /// As `Hamiltonian::manifold`.
    fn manifold(&self) -> Option<&dyn Manifold> {
        None
    }

    /// As `Hamiltonian::friction_rate`, with `parameters` as in [`EvaluationPoint`].
    fn friction_rate<K: Constant>(&self, parameters: &[K]) -> K {
        let _ = parameters;
        K::from_f64(0.0)
    }

    /// As `Hamiltonian::validate`.
    ///
    /// # Errors
    /// As there.
    fn validate(&self) -> Result<(), ConfigError> {
        Ok(())
    }

    /// As `Hamiltonian::variables`.
    fn variables(&self) -> Variables {
        Variables::unnamed(self.degrees())
    }

    /// As `Hamiltonian::parameter`.
    fn parameter(&self, index: usize) -> Option<(&'static str, f64)> {
        let _ = index;
        None
    }

    /// As `Hamiltonian::integers`.
    fn integers(&self) -> &'static [usize] {
        &[]
    }

    /// The weighted value of the terms with a role; 0 if there are none. All slices have the checked number
    /// of degrees of freedom.
    fn value<S: Scalar>(&self, role: Role, weight: f64, at: &EvaluationPoint<'_, S>) -> S;

    /// The number type of derivatives in vectorised loops: NaN where vector code cannot give the result of
    /// `f64`.
    type CommonRange: Number<f64>;

    /// Adds the weighted derivatives of the terms with a role to `by_q` and `by_p`, computed in numbers `T`.
    fn gradient<S: Scalar, T: Number<S>>(
        &self,
        role: Role,
        weight: f64,
        at: &EvaluationPoint<'_, S, impl ElementInput<S> + ?Sized>,
        wanted: Partials,
        by_q: &mut (impl Sums<S> + ?Sized),
        by_p: &mut (impl Sums<S> + ?Sized),
    );

    /// Gives the weighted second derivatives of a role to `into`, entry by entry, with their variables. Each
    /// pair of different variables comes once, and its derivative is alone unless its mirror image is another
    /// entry: on the diagonal and in a force. Only those that steps need are generated. All noises act.
    fn hessian<S: Scalar>(
        &self,
        role: Role,
        weight: f64,
        at: &EvaluationPoint<'_, S>,
        wanted: Partials,
        into: &mut impl FnMut(HessianBlock, [usize; 2], bool, S),
    ) {
        let _ = (role, weight, at, wanted, into);
    }

    /// The weighted terms of rank one of the second derivatives of a role, which
    /// [`hessian`](Elements::hessian) leaves out: those of [`Facts::collective_variables`], cleared.
    fn collective_hessian<S: Scalar>(
        &self,
        role: Role,
        weight: f64,
        at: &EvaluationPoint<'_, S>,
        into: &mut CollectiveHessian<S>,
    ) {
        let _ = (role, weight, at, into);
    }
}

impl<'a, S: Scalar, V: ?Sized> EvaluationPoint<'a, S, V> {
    /// A point at which no noise acts, with weight 1.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn new(
        [q, p]: [&'a V; 2],
        t: S::Constant,
        parameters: &'a [S::Constant],
        dw: &'a [S],
    ) -> Self {
        let one = Scalar::from_f64(1.0);
        Self { q, p, t, h: one, parameters, dw, acting: 0..0, scale: one }
    }
}

impl<S: Scalar> EvaluationPoint<'_, S> {
    /// The point in numbers `f64`, if its numbers are `f64`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn plain(&self) -> Option<EvaluationPoint<'_, f64>> {
        let Self { q, p, t, h, dw, acting, scale, .. } = self;
        let [q, p, dw] = [S::as_f64s(q)?, S::as_f64s(p)?, S::as_f64s(dw)?];
        let [t, h, scale] = [t, h, scale].map(|constant| constant.lane(0));
        Some(EvaluationPoint { q, p, t, h, parameters: &[], dw, acting: acting.clone(), scale })
    }
}

/// Adds the derivatives of a weighted role at all places; rows of pairs in vector instructions use the exact
/// numbers.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn slopes<H: Elements, S: Scalar>(
    system: &H,
    weighted: WeightedRole,
    at: &EvaluationPoint<'_, S>,
    wanted: Partials,
    by_q: &mut [S],
    by_p: &mut [S],
    columns: &mut PairColumns,
) {
    if const { pairs::may_take_vectors::<H>() && S::MAY_BE_F64 }
        && pairs::takes_vectors::<H>(wanted, at.q.len())
        && let Some(at) = at.plain()
        && let (Some(by_q), Some(by_p)) = (S::as_f64s_mut(&mut *by_q), S::as_f64s_mut(&mut *by_p))
    {
        pairs::gradient_in_columns(system, weighted, &at, wanted, by_q, by_p, columns);
    } else {
        system.gradient::<S, S>(weighted.role, weighted.weight, at, wanted, by_q, by_p);
    }
}

/// The place at which derivatives are evaluated: `[t, h]`, `[q, p]` and the increments of the noises.
pub type FieldAt<'a, S> = ([S; 2], [&'a [S]; 2], &'a [S]);

/// The wanted derivatives of the step Hamiltonian `h H_0 + Σ_k ΔW_k H_k`; `t` is the same in all lanes, or is
/// not read.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn field<H: Elements, S: Scalar, const BY_Q: bool, const BY_P: bool>(
    (system, parameters): (&H, &[S::Constant]),
    ([t, h], [q, p], dw): FieldAt<'_, S>,
    [by_q, by_p]: [&mut [S]; 2],
    columns: &mut PairColumns,
) {
    let at = EvaluationPoint {
        acting: 0..dw.len(),
        ..EvaluationPoint::new([q, p], t.to_constant(), parameters, dw)
    };
    let wanted = Partials { by_q: BY_Q, by_p: BY_P };
    if BY_Q {
        by_q.fill(S::from_f64(0.0));
    }
    if BY_P {
        by_p.fill(S::from_f64(0.0));
    }
    slopes(system, Role::Drift.times(1.0), &at, wanted, by_q, by_p, columns);
    if H::FACTS.kind.is_forced {
        slopes(system, Role::Force.times(1.0), &at, wanted, by_q, by_p, columns);
    }
    // Weights of stages differ from lane to lane.
    if BY_Q {
        by_q.iter_mut().for_each(|slope| *slope = *slope * h);
    }
    if BY_P {
        by_p.iter_mut().for_each(|slope| *slope = *slope * h);
    }
    if !dw.is_empty() {
        slopes(system, Role::Noise.times(1.0), &at, wanted, by_q, by_p, columns);
    }
}

/// Adds the derivatives of a step Hamiltonian `T(p) + V(q)` by `state`, the coordinates or the momenta.
/// Unless `EXACT`, numbers `f64` are those that vectorised functions cover, and NaN beyond.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn add_gradient<H: Elements, S: Scalar, const EXACT: bool>(
    system: &H,
    flow: Flow<'_, S>,
    state: &[S],
    wanted: Partials,
    into: &mut [S],
    columns: &mut PairColumns,
) {
    let (at, none) = (flow.at(state), &mut [][..]);
    // A single call, so that it is inlined.
    for (role, is_there) in flow.roles::<H>() {
        if const { !EXACT && takes_common_range::<H, S>() }
            && is_there
            && let (Some(at), Some(into)) = (at.plain(), S::as_f64s_mut(&mut *into))
        {
            let none = &mut [][..];
            match wanted.by_q {
                true => system.gradient::<f64, H::CommonRange>(role, 1.0, &at, wanted, into, none),
                false => system.gradient::<f64, H::CommonRange>(role, 1.0, &at, wanted, none, into),
            }
            continue;
        }
        match wanted.by_q {
            _ if !is_there => {}
            true => slopes(system, role.times(1.0), &at, wanted, into, none, columns),
            false => slopes(system, role.times(1.0), &at, wanted, none, into, columns),
        }
    }
}

/// Whether the functions of a system are vectorised in numbers that do not cover all arguments. Rows of pairs
/// look after theirs.
pub(crate) const fn takes_common_range<H: Elements, S: Scalar>() -> bool {
    H::CommonRange::IS_PARTIAL && S::MAY_BE_F64 && !pairs::may_take_vectors::<H>()
}

impl<'a, S: Scalar> Flow<'a, S> {
    /// All roles in a flow, and whether they act.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn roles<H: Elements>(&self) -> [(Role, bool); 3] {
        [(Role::Drift, true), (Role::Force, H::FACTS.kind.is_forced), (Role::Noise, !self.dw.is_empty())]
    }

    /// The point of evaluation of elements that read only one half of the phase space.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn at<V: ?Sized>(&self, state: &'a V) -> EvaluationPoint<'a, S, V> {
        let Self { t, h, parameters, dw } = *self;
        EvaluationPoint { h, acting: 0..dw.len(), ..EvaluationPoint::new([state, state], t, parameters, dw) }
    }
}

/// [`add_gradient`] for any sums.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn add_flow<H, S, T, V, A>(
    system: &H,
    flow: Flow<'_, S>,
    state: &V,
    wanted: Partials,
    into: &mut A,
) where
    H: Elements,
    S: Scalar,
    T: Number<S>,
    V: ElementInput<S> + ?Sized,
    A: Sums<S> + ?Sized,
{
    let at = flow.at(state);
    // A single call, so that it is inlined.
    for (role, is_there) in flow.roles::<H>() {
        let none = &mut [][..];
        if !is_there {
            continue;
        }
        if wanted.by_q {
            system.gradient::<S, T>(role, 1.0, &at, wanted, into, none);
        } else {
            system.gradient::<S, T>(role, 1.0, &at, wanted, none, into);
        }
    }
}

/// Whether scratch for `ready` degrees of freedom fits a state of `got`; the system was checked when the
/// scratch was made.
#[cfg_attr(not(debug_assertions), inline(always))]
fn is_sized<H: Elements>(system: &H, ready: usize, got: usize) -> bool {
    let known = system.degrees();
    ready == got && got != 0 && (known == 0 || known == got)
}

/// Coordinates, which must fit the system, and momenta, cut to its size so that loops over both need no
/// bounds checks.
///
/// # Errors
/// [`StepFailure::Dimension`] if the number of momenta differs.
#[cfg_attr(not(debug_assertions), inline(always))]
fn sized_mut<'a, H: Elements, S>(
    system: &H,
    [q, p]: [&'a mut [S]; 2],
) -> Result<[&'a mut [S]; 2], StepFailure> {
    let degrees = match system.degrees() {
        0 => q.len(),
        known => known,
    };
    if p.len() != degrees {
        return Err(StepFailure::Dimension { expected: degrees, got: p.len() });
    }
    Ok([&mut q[..degrees], &mut p[..degrees]])
}

/// The increments of a step, one for each noise.
///
/// # Errors
/// [`StepFailure::Increments`] if their number differs.
#[cfg_attr(not(debug_assertions), inline(always))]
fn increments<'a, H: Elements, S>(system: &H, dw: &'a [S]) -> Result<&'a [S], StepFailure> {
    let expected = system.noises();
    if dw.len() != expected {
        return Err(StepFailure::Increments { expected, got: dw.len() });
    }
    Ok(&dw[..expected])
}

/// Whether a state of `got` degrees of freedom fits the system and can be stepped; an empty one cannot.
///
/// # Errors
/// [`StepFailure::Dimension`] if it does not, [`StepFailure::Index`] if an integer of the system is out of
/// range.
pub fn check<H: Elements>(system: &H, got: usize) -> Result<(), StepFailure> {
    let expected = system.degrees();
    if expected != 0 && expected != got || got == 0 {
        return Err(StepFailure::Dimension { expected: expected.max(H::PLACES.components), got });
    }
    places::check(system, got)
}

/// Checks the system of a new stepper.
///
/// # Errors
/// [`ConfigError::Parameter`] if a parameter is NaN, [`ConfigError::Index`] if an index is out of range.
pub(crate) fn check_new<H: Elements>(system: &H) -> Result<(), ConfigError> {
    no_nan(system)?;
    check_places(system)
}

/// Checks the integers of the system of a new stepper, as far as they do not depend on the size of the state.
///
/// # Errors
/// [`ConfigError::Index`] if an index is out of range.
pub(crate) fn check_places<H: Elements>(system: &H) -> Result<(), ConfigError> {
    match system.degrees() {
        0 => Ok(()),
        degrees => {
            places::index_error(system, degrees).map_or(Ok(()), |error| Err(ConfigError::Index(error)))
        }
    }
}
