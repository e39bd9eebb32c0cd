//! Thermostats: friction and thermal noise.
//!
//! A system with the quadratic kinetic energy `p · M⁻¹ p / 2` and the symmetric, positive semidefinite
//! friction matrix `Γ` (mass/time) obeys, at the temperature `kT` (energy units), the Langevin equation
//!
//! ```text
//! dq = M⁻¹ p dt,   dp = -∂H/∂q dt - Γ M⁻¹ p dt + σ dW,   σ σᵀ = 2 kT Γ
//! ```
//!
//! The noise follows from friction and temperature, so that the Gibbs measure `exp(-H / kT)` is stationary.
//! Friction and noise alone are an Ornstein-Uhlenbeck process with a known solution. Over the time `s`, with
//! standard normals `ξ`,
//!
//! ```text
//! O:   p <- E p + R ξ,   E = exp(-s Γ M⁻¹),   R Rᵀ = kT (M - E M Eᵀ),   R lower triangular
//! ```
//!
//! If `Γ` depends on `q`, it is taken at the current `q`, which is constant during O. The schemes place O
//! between symplectic parts of a step, each letter with an equal share of the step:
//!
//! | scheme | step | for |
//! |---|---|---|
//! | [`Baoab`] | kick, drift, O, drift, kick | `T(p) + V(q, t)` |
//! | [`Obabo`] | O, kick, drift, kick, O | `T(p) + V(q, t)` |
//! | [`Gjf`] | kick, drift, O with Cayley's map instead of the exponential, drift, kick | `T(p) + V(q, t)` |
//! | [`GjI`] | kick, drift, O, drift, kick, with kicks and drifts over a shorter time | `T(p) + V(q, t)`, one rate |
//! | [`Thermostat<E>`](Thermostat) | O, step of `E`, O | any `H` that `E` serves |
//!
//! (B. Leimkuhler, C. Matthews, *Molecular Dynamics*, Springer 2015, chapter 7; G. Bussi, M. Parrinello,
//! "Accurate sampling using Langevin dynamics", Phys. Rev. E 75, 2007). With a harmonic force `Baoab` has the
//! exact variance of `q`, `Obabo` that of `p`, and `Thermostat<Midpoint>` both, at any step size and
//! friction.
//!
//! Stationary distributions are correct to order `h²` at any friction; relaxation rates are not. A free
//! particle diffuses with `D = kT/(m γ)` in the equation, and with all of these but `Gjf` and `GjI` with
//!
//! ```text
//! D = kT/(m γ) · (γh/2) coth(γh/2) = kT/(m γ) · (1 + (γh)²/12 - (γh)⁴/720 + ...)
//! ```
//!
//! The cause is that the O part lasts `h` while the positions move by half-steps around it. At large
//! friction, barrier-crossing rates have the same factor, 8 % at `γh = 1`. `Gjf` and `GjI` have both the
//! exact diffusion and the exact variance of the positions in a harmonic well (N. Grønbech-Jensen, "Complete
//! set of stochastic Verlet-type thermostats for correct Langevin simulations", Mol. Phys. 118, 2020).
//!
//! A step is driven by the increments of the listed noises, then `√h` times the standard normals of its O
//! parts: one per O part (in the order of the step) and degree of freedom. A system without temperature has
//! friction only, and no normals.

mod diagonal;
mod law;
mod letters;
mod manifold;
mod matrix;
mod modes;
mod part;
mod relaxation;
mod splitting;
mod thermostat;

use std::marker::PhantomData;

use crate::algebra::scalar::{Mask as _, Scalar};
use crate::error::{BathError, ConfigError};
use crate::scheme::elements::{self, Elements, EvaluationPoint, PairColumns, Partials, Role, slopes};
use crate::scheme::plan::{Knowledge, NoiseClass, Plan};

pub use law::HarmonicLaw;
pub use letters::{A, B, Letter, Letters, O};
#[doc(hidden)]
pub use modes::Decay;
pub(crate) use part::OPartsByPlace;
use relaxation::Relaxation;
pub use splitting::Splitting;
#[doc(hidden)]
pub use thermostat::ThermostatSteps;

pub use crate::scheme::word::Part;

/// Half a kick, half a drift, friction and noise, half a drift, half a kick: explicit, with one force for
/// each step, for `T(p) + V(q, t)`.
///
/// The positions of a harmonic oscillator have the exact variance; that of its momenta is too small by the
/// factor `1 - h² ω² / 4`. In general the bias of averages is of order 2, and of order 4 at large friction
/// (B. Leimkuhler, C. Matthews, "Rational construction of stochastic numerical methods for molecular
/// sampling", Appl. Math. Res. Express 2013). Diffusion, and barrier crossing at large friction, are too fast
/// by the factor `(γh/2) coth(γh/2)`, 1.08 at `γh = 1`. If rates matter and `γh` is not small, use [`Gjf`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Baoab;

/// Friction and noise of half the step, half a kick, a drift, half a kick, friction and noise of the other
/// half: one force for each step, explicit, for `T(p) + V(q, t)`. The momenta of a harmonic oscillator have
/// the exact variance; that of the positions is too large by the factor `1 / (1 - h² ω² / 4)`. Its middle is
/// a step of [`Verlet`](crate::scheme::compose::Verlet), so that a Metropolis test of that step makes the
/// sampling exact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Obabo;

/// [`Baoab`] with the decay `c = (1 - γh/2)/(1 + γh/2)` of the momenta instead of `e^{-γh}`: a free particle
/// diffuses with `D = kT/(m γ)`, and the positions of a harmonic oscillator have the exact variance, at any
/// `h` and `γ` (N. Grønbech-Jensen, O. Farago, "A simple and effective Verlet-type algorithm for simulating
/// Langevin dynamics", Mol. Phys. 111, 2013). For `γh > 2` the momenta alternate in sign; the positions
/// remain correct. For several rates or a matrix, `c` is Cayley's map of `Γ M⁻¹`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Gjf;

/// [`Baoab`] with kicks and drifts over the time `s h`, `s = √(tanh(γh/2)/(γh/2))`, instead of `h`: exact
/// where [`Gjf`] is, with the decay `e^{-γh}` of the momenta (N. Grønbech-Jensen, Mol. Phys. 118, 2020). It
/// needs one friction rate for all degrees of freedom and no other noises: else [`ConfigError`]. Ensembles
/// with [`systems`](crate::ensemble::Ensemble::systems) use one stepper per path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct GjI;

/// [`Baoab`] on the manifold of [constraints](crate::scheme::constraints), with one rate of friction for all
/// degrees of freedom: half a kick, half a drift, friction and noise, half a drift, half a kick, where each
/// part ends on the manifold with momenta that are tangent (g-BAOAB: B. Leimkuhler, C. Matthews, Proc. R.
/// Soc. A 472, 2016). It samples `e^{-H/kT}` on the manifold with a bias of order 2. A step from a normal
/// that is larger than the radius of curvature allows has no end, and fails: its steps are shorter than those
/// of a system without constraints.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct GBaoab;

/// Friction and noise of half the step, a step of `E` without them, friction and noise of the other half. Its
/// sampling error is that of the energy in `E`: `Thermostat<Midpoint>` and `Thermostat<Gauss<S>>` have the
/// exact distribution of positions and momenta for every quadratic Hamiltonian and every `h`; otherwise the
/// bias of `Thermostat<Gauss<S>>` is of order `2S`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Thermostat<E>(PhantomData<E>);

/// `E` of the system without its bath, inside a [`Thermostat`]: not for use by itself.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Isolated<E>(PhantomData<E>);

/// Checks friction and masses of a system with friction but no bath.
///
/// # Errors
/// [`ConfigError::Bath`]
#[doc(hidden)]
pub fn validate<T: Elements>(system: &T) -> Result<(), ConfigError> {
    let degrees = system.degrees();
    if T::FACTS.kind.is_conformal {
        let rate: f64 = system.friction_rate(&[]);
        let is_rate = rate.is_finite() && rate >= 0.0;
        return if is_rate { Ok(()) } else { Err(ConfigError::Bath(BathError::Friction { rate })) };
    }
    if let Some(friction) = T::FACTS.bath
        && degrees != 0
    {
        // With a positive step: friction alone may also go backwards.
        let of_one = (1.0, Decay::Exponential);
        Relaxation::new((system, &[]), friction, degrees, 1.0, of_one).map_err(ConfigError::Bath)?;
    }
    Ok(())
}

/// Friction and temperature of a system `dp = -∂H/∂q dt - Γ M⁻¹ p dt + noise of covariance 2 kT Γ dt` with
/// the quadratic kinetic energy `p · M⁻¹ p / 2`, which the compiler has proven.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Friction {
    /// Whether there is a temperature: without, friction alone acts.
    pub is_heated: bool,
    /// Whether degrees of freedom have temperatures of their own: then the temperature is a covector of them.
    pub has_temperatures: bool,
    /// Whether the temperature depends on the time.
    pub is_timed: bool,
    /// Whether the friction is the matrix `Γ` (mass/time), and not rates (1/time).
    pub is_matrix: bool,
    /// Whether rates depend on the coordinates. A matrix does not.
    pub is_per_state: bool,
    /// Whether `M` is diagonal. If it is not, all rates are equal.
    pub has_diagonal_masses: bool,
}

/// The first lane that is no temperature.
fn wrong_lane<S: Scalar>(temperature: S) -> f64 {
    let mut lanes = (0..S::LANES).map(|lane| temperature.lane(lane));
    lanes.find(|lane| !(lane.is_finite() && *lane >= 0.0)).unwrap_or(f64::NAN)
}

impl Friction {
    /// Rates that do not depend on the coordinates, diagonal masses, and no temperature.
    pub const ALONE: Self = Self {
        is_heated: false,
        has_temperatures: false,
        is_timed: false,
        is_matrix: false,
        is_per_state: false,
        has_diagonal_masses: true,
    };

    /// Whether friction acts on each momentum separately: it and the masses are lists by degree of freedom.
    /// If degrees of freedom have temperatures of their own, a friction matrix is diagonal, which is checked.
    const fn is_list(self) -> bool {
        (!self.is_matrix || self.has_temperatures) && self.has_diagonal_masses
    }

    /// `Γ` by rows, or the rates `(Γ M⁻¹)_ii`, one per degree of freedom. NaN for lists that do not fit.
    pub fn damping<H: Elements, S: Scalar>(
        &self,
        system: (&H, &[S::Constant]),
        q: &[S],
        into: &mut [S],
        columns: &mut PairColumns,
    ) {
        match self.is_matrix {
            true => elements::damping(system, q, into),
            false => elements::rates(system, q, into, columns),
        }
    }

    /// Whether the bath has no equilibrium: `exp(-H / kT)` is stationary for one constant temperature only.
    pub const fn is_out_of_equilibrium(self) -> bool {
        self.has_temperatures || self.is_timed
    }

    /// `kT` at a time: of each degree of freedom, or the one of all in a list of one. Zeros if the system has
    /// no temperature.
    ///
    /// # Errors
    /// [`BathError::Temperature`]
    pub fn temperatures<H: Elements, S: Scalar>(
        &self,
        (system, parameters): (&H, &[S::Constant]),
        t: S::Constant,
        into: &mut [S],
    ) -> Result<(), BathError> {
        let zero = S::from_f64(0.0);
        if !self.is_heated {
            into.fill(zero);
        } else if self.has_temperatures {
            elements::temperatures(system, parameters, t, into);
        } else {
            let at = EvaluationPoint::new([&[][..]; 2], t, parameters, &[]);
            into.fill(system.value(Role::Temperature, 1.0, &at));
        }
        let is_valid = |temperature: &S| (temperature.is_finite() & zero.less_equal(*temperature)).all();
        match into.iter().position(|temperature| !is_valid(temperature)) {
            None => Ok(()),
            Some(i) => Err(BathError::Temperature {
                temperature: wrong_lane(into[i]),
                degree: self.has_temperatures.then_some(i),
                t: self.is_timed.then(|| t.lane(0)),
            }),
        }
    }

    /// `M⁻¹`: its diagonal, one number per degree of freedom, or its rows.
    pub fn inverse_mass<H: Elements, S: Scalar>(
        &self,
        (system, parameters): (&H, &[S::Constant]),
        into: &mut [S],
    ) {
        let degrees = if self.has_diagonal_masses { into.len() } else { into.len().isqrt() };
        let (zeros, one) = (vec![S::from_f64(0.0); degrees], S::from_f64(1.0));
        let (mut p, mut by_q, mut velocity) = (zeros.clone(), zeros.clone(), zeros.clone());
        // The velocities are linear in the momenta and read nothing else.
        let velocities = |p: &[S], by_q: &mut [S], into: &mut [S]| {
            into.fill(S::from_f64(0.0));
            let at = EvaluationPoint::new([&*zeros, p], Scalar::from_f64(0.0), parameters, &[]);
            slopes(
                system,
                Role::Drift.times(1.0),
                &at,
                Partials::BY_MOMENTA,
                by_q,
                into,
                &mut PairColumns::default(),
            );
        };
        if self.has_diagonal_masses {
            p.fill(one);
            velocities(&p, &mut by_q, into);
            return;
        }
        for column in 0..degrees {
            p.fill(S::from_f64(0.0));
            p[column] = one;
            velocities(&p, &mut by_q, &mut velocity);
            velocity.iter().enumerate().for_each(|(row, v)| into[row * degrees + column] = *v);
        }
    }
}

/// A system of which a thermostat takes the steps.
struct Damped<H>(PhantomData<H>);

impl<H: Elements> Damped<H> {
    /// Its friction and temperature.
    const FRICTION: Friction =
        H::FACTS.bath.expect("a bath acts through friction: add `friction = ...` or `damping = [[...]]`");
}

/// The plan of the same steps between O parts: symmetric, and so of order two at most.
const fn with_bath(plan: Plan) -> Plan {
    let order = if plan.order < 2 { plan.order } else { 2 };
    let noise = if matches!(plan.noise, NoiseClass::None) { NoiseClass::Thermal } else { plan.noise };
    Plan { order, noise, conserves_energy: Knowledge::Refuted, energy_jumps: false, ..plan }
}
