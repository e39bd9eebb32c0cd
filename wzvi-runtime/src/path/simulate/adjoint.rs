//! The derivative of a function of the end of a run by its start, in one pass backwards.
//!
//! The step `Φ` from `z_i` to `z_{i+1}` is symplectic, `Mᵀ J M = J` with `M = Φ'(z_i)`, `J = [[0, 1], [-1, 0]]`. So
//!
//! ```text
//! λ_i = Mᵀ λ_{i+1} = -J M⁻¹ J λ_{i+1},   M⁻¹ = (Φ⁻¹)'(z_{i+1}),   Φ_h⁻¹ = Φ*_{-h}
//! ```
//!
//! with the adjoint scheme `Φ*` (E. Hairer, C. Lubich, G. Wanner, *Geometric Numerical Integration*, II.3 and VI.2): the transposed matrix takes one derivative
//! of the step backwards in one direction, for any number of degrees of freedom.

use super::tangent::ends_at;
use super::{Simulation, Unobserved};
use crate::algebra::scalar::Dual;
use crate::algebra::state::{State, Vector};
use crate::error::{ConfigError, StepError, StepFailure};
use crate::increments::{Noise, Whole};
use crate::path::Error;
use crate::path::steps::Step;
use crate::scheme::system::{
    At, Discretized, Gradient, MemoryOf, PreparedOf, Scheme, SchemeOf, anew, as_they_are,
};

/// The end of a run, and the gradient of a function of the end by the start.
#[derive(Clone, Debug, PartialEq)]
pub struct Adjoint<V> {
    /// The state at the end.
    pub end: State<V>,
    /// `∂g(end) / ∂(q, p)(start)`
    pub by_start: Gradient<V>,
}

/// A step that was taken.
struct Taken<V> {
    before: State<V>,
    dw: Vec<f64>,
}

impl<H, E, N> Simulation<'_, H, E, N, Unobserved, Whole>
where
    H: Discretized<E>,
    N: Noise,
{
    /// Runs the path, and returns the derivative of a function `g` of its end by its start, from the `gradient` of `g` at the end, with the same increments.
    /// The cost is one more step in dual numbers of one derivative for each step, whatever the number of degrees of freedom; the run keeps all of its states
    /// meanwhile. [`Simulation::tangent`] returns the whole matrix instead.
    ///
    /// `T` is the adjoint scheme, whose step over `-h` undoes that of `E` over `h`: `E` itself for symmetric schemes (`Midpoint`, `Verlet`, `Gauss<S>`, and symmetric
    /// compositions of them), `DeltaMinus` for `DeltaPlus` and the other way round. It must be listed for the system, too.
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
    /// Those of [`Simulation::tangent`]; [`ConfigError::Setting`] where steps are not symplectic: with forces, friction or a bath, and for schemes of the program.
    /// [`StepFailure::OtherSolution`] where the step of `T` backwards does not end where the step began.
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
            let wrong =
                "`adjoint` needs symplectic steps, without forces, friction and baths: take `tangent`";
            return Err(ConfigError::Setting(wrong.into()).into());
        }
        let bare = self.bare("adjoint")?;
        let (system, h) = (bare.system, bare.h);
        let mut taken: Vec<Taken<H::Vector>> = Vec::new();
        let end = bare.run(|whole, step| {
            let before = step.state.clone();
            let Step { state, interval, noise, dw } = step;
            whole.take_step(Step { state, interval, noise, dw: &mut *dw })?;
            taken.push(Taken { before, dw: dw.to_vec() });
            Ok(())
        })?;
        let mut by_start = gradient(&end);
        let mut back = Back::<H, T>::new(system, h, &end)?;
        let mut after = end.clone();
        for (step, Taken { before, dw }) in taken.into_iter().enumerate().rev() {
            let pulled = back.pull([&before, &after], &dw, &mut by_start);
            pulled.map_err(|cause| StepError { step: step as u64, t: before.t, h, cause })?;
            after = before;
        }
        Ok(Adjoint { end, by_start })
    }
}

/// Steps backwards, with one derivative.
struct Back<'a, H: Discretized<T>, T> {
    system: &'a H,
    h: f64,
    prepared: PreparedOf<H, T>,
    memory: MemoryOf<H, T, Dual<1>>,
    q: Vec<Dual<1>>,
    p: Vec<Dual<1>>,
    dw: Vec<Dual<1>>,
    end: H::Vector,
}

impl<'a, H: Discretized<T>, T> Back<'a, H, T> {
    fn new(system: &'a H, h: f64, state: &State<H::Vector>) -> Result<Self, ConfigError> {
        let prepared = SchemeOf::<H, T>::prepare(system, &as_they_are, -h)?;
        let list = || vec![Dual::default(); state.q.components().len()];
        let (memory, end) = (Default::default(), state.q.clone());
        Ok(Self { system, h, prepared, memory, q: list(), p: list(), dw: Vec::new(), end })
    }

    /// `λ_{i+1} → λ_i`
    ///
    /// # Errors
    /// If the step has no solution, or another one.
    fn pull(
        &mut self,
        [before, after]: [&State<H::Vector>; 2],
        dw: &[f64],
        gradient: &mut Gradient<H::Vector>,
    ) -> Result<(), StepFailure> {
        let Self { system, h, prepared, memory, q, p, dw: own, end } = self;
        let Gradient { q: by_q, p: by_p } = gradient;
        // `J λ`
        let set = |numbers: &mut [Dual<1>], values: &H::Vector, along: &H::Vector, sign: f64| {
            let along = along.components().iter().map(|along| sign * along);
            for ((number, value), along) in numbers.iter_mut().zip(values.components()).zip(along) {
                *number = Dual { value: *value, derivative: [along] };
            }
        };
        set(q, &after.q, by_p, 1.0);
        set(p, &after.p, by_q, -1.0);
        own.clear();
        own.extend(dw.iter().map(|dw| Dual::constant(-dw)));
        let at = At { t: after.t, h: -*h, q: &mut *q, p: &mut *p, dw: own };
        anew::advance::<H, SchemeOf<H, T>, f64, Dual<1>>(*system, prepared, at, memory)?;
        ends_at([q, p], [after, before], end)?;
        // `-J M⁻¹ J λ`
        for (into, numbers, sign) in [(by_q, &*p, -1.0), (by_p, &*q, 1.0)] {
            for (into, number) in into.components_mut().iter_mut().zip(numbers) {
                *into = sign * number.derivative[0];
            }
        }
        Ok(())
    }
}
