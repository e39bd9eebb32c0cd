//! The entry points of all runs of a system.

use crate::algebra::state::State;
#[cfg(feature = "ensemble")]
use crate::ensemble::{Ensemble, Multilevel};
use crate::error::ConfigError;
#[cfg(feature = "report")]
use crate::report::WorkPrecision;
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
    fn stepper<Scheme>(&self, h: f64) -> Result<Stepper<'_, Self, Scheme>, ConfigError>
    where
        Self: Discretized<Scheme> + Sized,
    {
        Stepper::new(self, h)
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

    /// One path in steps of size `h` (time units of the Hamiltonian; negative runs backwards).
    /// [`Simulation::run`] reports invalid settings.
    fn simulate<Scheme>(&self, h: f64) -> Simulation<'_, Self, Scheme>
    where
        Self: Discretized<Scheme> + Sized,
    {
        Simulation::new(self, h)
    }

    /// Many paths in steps of size `h` (time units of the Hamiltonian; negative runs backwards), for their
    /// statistics. [`Ensemble::run`] reports invalid settings.
    #[cfg(feature = "ensemble")]
    fn ensemble<Scheme>(&self, h: f64) -> Ensemble<'_, Self, Scheme>
    where
        Self: Discretized<Scheme> + Sized,
    {
        Ensemble::new(self, h)
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
