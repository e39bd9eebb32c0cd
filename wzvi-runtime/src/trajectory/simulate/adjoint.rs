//! The derivative of a function of the end of a run by its start, in one pass backwards.
//!
//! The step `Φ` from `z_i` to `z_{i+1}` is symplectic, `Mᵀ J M = J` with `M = Φ'(z_i)`,
//! `J = [[0, 1], [-1, 0]]`. So
//!
//! ```text
//! λ_i = Mᵀ λ_{i+1} = -J M⁻¹ J λ_{i+1},   M⁻¹ = (Φ⁻¹)'(z_{i+1}),   Φ_h⁻¹ = Φ*_{-h}
//! ```
//!
//! with the adjoint scheme `Φ*` (E. Hairer, C. Lubich, G. Wanner, *Geometric Numerical Integration*, II.3 and
//! VI.2): the transposed matrix takes one derivative of the step backwards in one direction, for any number
//! of degrees of freedom.

use super::tangent::{TangentColumns, is_held, ln_scaled, scaled};
use super::{Simulation, Summation, Unobserved};
use crate::algebra::scalar::Dual;
use crate::algebra::state::{State, Vector};
use crate::error::{DerivativeError, StepError, StepFailure, wrong};
use crate::ground::names::short_name;
use crate::increments::Noise;
use crate::scheme::elements::{QuadraturePoint, Role, WeightedRole};
use crate::scheme::system::{Discretized, Gradient, Scheme, SchemeOf, as_they_are};
use crate::trajectory::Error;
use crate::trajectory::steps::StepToTake;

/// The end of a run, and the gradient of a function of the end by the start.
#[derive(Clone, Debug, PartialEq)]
pub struct Adjoint<V> {
    /// The state at the end.
    pub end: State<V>,
    /// `∂g(end) / ∂(q, p)(start)`
    pub by_start: Gradient<V>,
}

/// A step that was taken.
struct AdjointStep<V> {
    before: State<V>,
    dw: Vec<f64>,
    /// Its size.
    h: f64,
}

impl<H, E, N, S> Simulation<'_, H, E, N, Unobserved, S>
where
    H: Discretized<E>,
    N: Noise,
    S: Summation<H, E>,
{
    /// Runs the path, and returns the derivative of a function `g` of its end by its start, from the
    /// `gradient` of `g` at the end, with the same increments. The cost is one more step in dual numbers of
    /// one derivative for each step, whatever the number of degrees of freedom; the run keeps all of its
    /// states meanwhile. [`Simulation::tangent`] returns the whole matrix instead.
    ///
    /// `T` is the adjoint scheme, whose step over `-h` undoes that of `E` over `h`: `E` itself for symmetric
    /// schemes (`Midpoint`, `Verlet`, `Gauss<S>`, and compositions of them), `DeltaMinus` for `DeltaPlus` and
    /// the other way round, `Lambda<D - N, D>` for `Lambda<N, D>`. It must be listed for the system, too.
    ///
    /// ```ignore
    /// use wzvi::prelude::*;
    /// use wzvi::system::Gradient;
    ///
    /// #[hamiltonian(drift = |q, p| 0.5 * p * p - q.cos(), embedding = Midpoint)]
    /// struct Pendulum;
    ///
    /// // g = q² of the end.
    /// let run = Pendulum.simulate::<Midpoint>(0.05).start(State::new([3.0], [0.0])).until(5.0);
    /// let adjoint = run.adjoint::<Midpoint>(|end| Gradient { q: 2.0 * end.q, p: 0.0 * end.p })?;
    /// let by_momentum = adjoint.by_start.p[0];
    /// # let _ = by_momentum;
    /// # Ok::<(), wzvi::Error>(())
    /// ```
    ///
    /// # Errors
    /// The errors of [`Simulation::tangent`]; [`ConfigError::Setting`](crate::error::ConfigError::Setting)
    /// where steps are not symplectic: with forces, friction or a bath, for schemes of the program, and where
    /// `T` is not the adjoint of `E`. [`StepFailure::OtherSolution`] where the step of `T` backwards does not
    /// end where the step began, [`DerivativeError`] where the gradient is out of the range of `f64`.
    pub fn adjoint<T>(
        self,
        gradient: impl FnOnce(&State<H::Vector>) -> Gradient<H::Vector>,
    ) -> Result<Adjoint<H::Vector>, Error>
    where
        H: Discretized<T>,
    {
        let kind = H::KIND;
        let is_symplectic = <H as Discretized<E>>::PROPERTIES.is_variational
            && !(kind.is_conformal || kind.is_forced || kind.has_noise_forces);
        if !is_symplectic {
            return wrong(
                "`adjoint` needs symplectic steps, without forces, friction and baths: take `tangent`",
            );
        }
        if !are_adjoint::<H, E, T>() {
            let [of_run, other] = [short_name::<E>(), short_name::<T>()];
            return wrong(format!(
                "`adjoint::<{other}>` of a run by `{of_run}`: a step of `{other}` backwards does not undo one of `{of_run}`. \
                 Symmetric schemes are their own adjoint (`Midpoint`, `Verlet`, `Gauss<S>`, compositions of these); a point l has \
                 the adjoint 1 - l (`DeltaPlus` and `DeltaMinus`, `Lambda<N, D>` and `Lambda<D - N, D>`)"
            ));
        }
        let bare = self.bare("adjoint", false)?;
        let (system, h) = (bare.system, bare.h);
        let mut taken: Vec<AdjointStep<H::Vector>> = Vec::new();
        let end = bare.run(|whole, step| {
            let before = step.state.clone();
            let StepToTake { state, interval, noise, dw } = step;
            whole.take_step(StepToTake { state, interval, noise, dw: &mut *dw })?;
            taken.push(AdjointStep { before, dw: dw.to_vec(), h: whole.size() });
            Ok(())
        })?;
        let mut by_start = gradient(&end);
        let zeros = || vec![Dual::default(); end.q.components().len()];
        let mut size = taken.last().map_or(h, |step| step.h);
        let mut back = TangentColumns::<H, T, f64, 1>::new(system, &as_they_are, -size, [zeros(), zeros()])?;
        let (mut after, mut reversed, mut room) = (end.clone(), Vec::new(), end.q.clone());
        for (step, AdjointStep { before, dw, h }) in taken.into_iter().enumerate().rev() {
            if h != size {
                back.resize(system, &as_they_are, -h, 0)?;
                size = h;
            }
            let ends = [&before, &after];
            let pulled = pull(&mut back, system, ends, &dw, &mut by_start, (&mut reversed, &mut room));
            let (step, t) = (step as u64, before.t);
            pulled.map_err(|cause| match cause {
                // The step itself has a finite end.
                StepFailure::NonFinite => derivative(f64::INFINITY, step, t),
                cause => StepError { step, t, h, cause }.into(),
            })?;
            after = before;
        }
        let (size, [exponent]) = (back.size(0), back.exponents);
        if !is_held(size, exponent) {
            return Err(derivative(ln_scaled(size, exponent), 0, after.t));
        }
        for vector in [&mut by_start.q, &mut by_start.p] {
            vector.components_mut().iter_mut().for_each(|x| *x = scaled(*x, exponent));
        }
        Ok(Adjoint { end, by_start })
    }
}

/// A gradient that numbers do not hold.
fn derivative(ln_size: f64, step: u64, t: f64) -> Error {
    Box::new(DerivativeError { by: "the state".into(), ln_size, step, t }).into()
}

/// Whether a step of `T` over `-h` undoes a step of `E` over `h` for every state.
fn are_adjoint<H: Discretized<E> + Discretized<T>, E, T>() -> bool {
    match (SchemeOf::<H, E>::POINTS, SchemeOf::<H, T>::POINTS) {
        (Some(ours), Some(theirs)) => are_mirrored(ours, theirs) && are_mirrored(theirs, ours),
        // A scheme without points is symmetric, and its text is its own.
        (None, None) => <H as Discretized<E>>::EQUATIONS == <H as Discretized<T>>::EQUATIONS,
        _ => false,
    }
}

/// Whether each role at a point `l` is at `1 - l` among `theirs`, with the same
/// weight. Counter-terms are of second order in the increments, which change their signs: their weight
/// `1/2 - l` does, too.
fn are_mirrored(ours: &[QuadraturePoint], theirs: &[QuadraturePoint]) -> bool {
    // Points and weights are fractions of small numbers, rounded.
    let is_same = |a: f64, b: f64| (a - b).abs() < 4.0 * f64::EPSILON;
    let is_there = |point: f64, role: Role, weight: f64| {
        let at_point = theirs.iter().filter(|stage| is_same(stage.point, point));
        at_point
            .flat_map(|stage| stage.roles)
            .any(|other| other.role == role && is_same(other.weight, weight))
    };
    let is_mirrored = |&QuadraturePoint { point, roles, .. }: &QuadraturePoint| {
        roles.iter().all(|&WeightedRole { role, weight }| {
            is_there(1.0 - point, role, if role == Role::CounterTerm { -weight } else { weight })
        })
    };
    ours.iter().all(is_mirrored)
}

/// `λ_{i+1} → λ_i`, by a step backwards with one derivative; the last lists are scratch for its increments
/// and its end.
///
/// # Errors
/// If the step has no solution, or another one.
fn pull<H: Discretized<T>, T>(
    back: &mut TangentColumns<H, T, f64, 1>,
    system: &H,
    [before, after]: [&State<H::Vector>; 2],
    dw: &[f64],
    gradient: &mut Gradient<H::Vector>,
    (reversed, end): (&mut Vec<Dual<1>>, &mut H::Vector),
) -> Result<(), StepFailure> {
    let Gradient { q: by_q, p: by_p } = gradient;
    // `J λ`
    for (numbers, along, sign) in [(&mut back.q, &*by_p, 1.0), (&mut back.p, &*by_q, -1.0)] {
        numbers.iter_mut().zip(along.components()).for_each(|(x, along)| x.derivative = [sign * along]);
    }
    reversed.clear();
    reversed.extend(dw.iter().map(|dw| Dual::constant(-dw)));
    back.vary(system, 0, [after, before], reversed, end)?;
    back.rescale();
    // `-J M⁻¹ J λ`
    for (into, numbers, sign) in [(by_q, &back.p, -1.0), (by_p, &back.q, 1.0)] {
        into.components_mut().iter_mut().zip(numbers).for_each(|(into, x)| *into = sign * x.derivative[0]);
    }
    Ok(())
}
