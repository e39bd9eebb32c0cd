//! The entry points of all runs of a system.

use crate::algebra::state::State;
#[cfg(feature = "ensemble")]
use crate::ensemble::{Ensemble, Multilevel};
use crate::error::ConfigError;
#[cfg(feature = "report")]
use crate::report::WorkPrecision;
use crate::scheme::clock::Eps;
use crate::scheme::modified::{Conservative, ModifiedBy, ModifiedHamiltonian};
use crate::scheme::system::{Discretized, Hamiltonian};
use crate::trajectory::simulate::Simulation;
use crate::trajectory::step::Stepper;

/// Runs a system by one of its schemes, `Scheme`: the only parameter to name, as in
/// `kubo.simulate::<Midpoint>(0.02)`.
pub trait Integrate: Hamiltonian {
    /// Single steps of size `h` (time units of the Hamiltonian; negative runs backwards) with given
    /// increments.
    ///
    /// # Errors
    /// See [`Stepper::new`].
    fn stepper<Scheme>(&self, h: impl StepSize) -> Result<Stepper<'_, Self, Scheme>, ConfigError>
    where
        Self: Discretized<Scheme> + Sized,
    {
        Stepper::new(self, size_for::<Self, Scheme, _>(h))
    }

    /// The modified energy of a state for steps of size `h`, in units of energy. Steps of the scheme conserve
    /// it nearly exactly; these are its first terms in `h`. [`ModifiedHamiltonian`] evaluates it for many
    /// states. It is NaN where the energy is.
    ///
    /// If the modified energy drifts much less than the energy, the theory of symplectic methods applies to
    /// the run. If both drift alike, the step is too long.
    fn shadow_energy<Scheme>(&self, state: &State<Self::Vector>, h: f64) -> f64
    where
        Self: Discretized<Scheme> + Conservative + Sized,
        Scheme: ModifiedBy,
    {
        ModifiedHamiltonian::<Scheme>::new(h).energy(self, state)
    }

    /// One path in steps of size `h` (time units of the Hamiltonian; negative runs backwards), or by a clock
    /// in steps of [`Eps`]. [`Simulation::run`] reports invalid settings.
    fn simulate<Scheme>(&self, h: impl StepSize) -> Simulation<'_, Self, Scheme>
    where
        Self: Discretized<Scheme> + Sized,
    {
        Simulation::new(self, size_for::<Self, Scheme, _>(h))
    }

    /// Many paths in steps of size `h` (time units of the Hamiltonian; negative runs backwards), for their
    /// statistics. [`Ensemble::run`] reports invalid settings.
    #[cfg(feature = "ensemble")]
    fn ensemble<Scheme>(&self, h: impl StepSize) -> Ensemble<'_, Self, Scheme>
    where
        Self: Discretized<Scheme> + Sized,
    {
        Ensemble::new(self, size_for::<Self, Scheme, _>(h))
    }

    /// The mean of one observable at the end, from coupled paths in steps of `h, h/2, h/4, ...` (time units
    /// of the Hamiltonian). It is cheaper than an ensemble where the error must be small. [`Multilevel::run`]
    /// reports invalid settings.
    #[cfg(feature = "ensemble")]
    fn multilevel<Scheme>(&self, h: f64) -> Multilevel<'_, Self, Scheme>
    where
        Self: Discretized<Scheme> + Sized,
    {
        Multilevel::new(self, h)
    }

    /// Error against run time for several schemes and step sizes. [`WorkPrecision::run`] reports invalid
    /// settings.
    #[cfg(feature = "report")]
    fn work_precision(&self) -> WorkPrecision<'_, Self>
    where
        Self: Sized,
    {
        WorkPrecision::new(self)
    }
}

impl<H: Hamiltonian + ?Sized> Integrate for H {}

/// The size of the steps of a scheme: an `f64`, a time, for constant steps; [`Eps`] for schemes with a
/// [clock](crate::scheme::clock). The build refuses one for the other.
pub trait StepSize: Copy {
    /// Whether it is that of a clock.
    const IS_OF_CLOCK: bool;
    /// The number.
    fn size(self) -> f64;
}

impl StepSize for f64 {
    const IS_OF_CLOCK: bool = false;

    fn size(self) -> f64 {
        self
    }
}

impl StepSize for Eps {
    const IS_OF_CLOCK: bool = true;

    fn size(self) -> f64 {
        self.0
    }
}

/// The number, if it is of the kind that the scheme takes.
fn size_for<H: Discretized<E>, E, T: StepSize>(h: T) -> f64 {
    const {
        assert!(
            T::IS_OF_CLOCK || !H::PROPERTIES.is_clocked,
            "a scheme with a clock takes `Eps(0.3)`, a fraction: a number alone would be a time"
        );
        assert!(
            !T::IS_OF_CLOCK || H::PROPERTIES.is_clocked,
            "`Eps` is for schemes with a clock, `Clocked<E>` for example: this one takes a step size, a time"
        );
    }
    h.size()
}
