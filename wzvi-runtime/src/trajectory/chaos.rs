//! Indicators of chaos: how deviations from a path grow.
//!
//! A deviation is multiplied by the derivative of each step, `δ_k = T_k δ_{k-1}`, with the increments of the
//! path. With `l_k = ln(|δ_k| / |δ_{k-1}|)` after `n` steps of size `h`:
//!
//! | indicator | definition | regular | chaotic |
//! |---|---|---|---|
//! | exponents `λ_1 ≥ λ_2 ≥ …` | growth of lengths, areas, … per unit of time, by QR | `0 ± ln T / T` | `λ_1 > 0` |
//! | MEGNO `Y_n`, mean `Ȳ_n` | `(2/n) Σ k l_k`; its mean over `k` | `Ȳ → 2` | `Ȳ → λ_1 T / 2` |
//! | SALI | `min \|û ± v̂\|` of two unit deviations | stays, or falls like `1/T` | falls like `e^{-(λ_1 - λ_2) T}` |
//! | GALI_k | volume of `k` unit deviations | stays for `k ≤ d`, else falls like a power | falls exponentially |
//! | FLI | largest `ln \|δ\|` so far | grows like `ln T` | grows like `λ_1 T` |
//!
//! MEGNO is the one for maps (P. M. Cincotta, C. M. Giordano, C. Simó, "Phase space structure of
//! multi-dimensional systems by means of the mean exponential growth factor of nearby orbits", Physica D 182,
//! 2003), GALI that of Ch. Skokos, T. C. Bountis, Ch. Antonopoulos, Physica D 231, 2007.
//!
//! **Deviations at the start are generic**: unit vectors in directions without symmetry. From a start that a
//! symmetry fixes, as `x = 0, p_y = 0` of Hénon and Heiles, unit vectors along the axes are exceptions.
//! Regular paths then have `Ȳ → 0` there in place of 2.
//!
//! **Errors** are in [`Spectrum`].

mod frame;
mod indicators;
mod spectrum;
mod start;

use crate::algebra::state::{State, Vector};
use crate::error::{ConfigError, wrong};
use crate::increments::Noise;
use crate::scheme::constraints::ManifoldPoint;
use crate::scheme::system::{Discretized, Hamiltonian};
use crate::trajectory::simulate::{Simulation, Summation, Unobserved, UsualSums};

pub(crate) use indicators::{Growth, gali, sali};
pub use indicators::{IndicatorSeries, Indicators};
pub use spectrum::{Spectrum, SpectrumSeries};

/// Other paths beside the one of the run, if nothing else was said.
const COPIES: u32 = 8;

/// A run together with deviations from its path: [`Simulation::deviations`] or [`Simulation::copies`] begins
/// it.
#[derive(Clone, Debug)]
#[must_use = "nothing happens before `lyapunov` or `indicators`"]
pub struct Deviations<'a, H: Hamiltonian, E, N, S = UsualSums> {
    run: Simulation<'a, H, E, N, Unobserved, S>,
    given: Option<Vec<Vec<f64>>>,
    copies: u32,
}

impl<'a, H, E, N, S> Simulation<'a, H, E, N, Unobserved, S>
where
    H: Discretized<E>,
    N: Noise,
    S: Summation<H, E>,
{
    /// This run with the given deviations at its start, in place of generic ones. Each has one number for
    /// each coordinate and then one for each momentum; only its direction counts.
    pub fn deviations<D: Into<Vec<f64>>>(
        self,
        deviations: impl IntoIterator<Item = D>,
    ) -> Deviations<'a, H, E, N, S> {
        let given = deviations.into_iter().map(Into::into).collect();
        Deviations { given: Some(given), ..self.generic() }
    }

    /// This run with so many other paths for the errors of [`Simulation::lyapunov`]; the default is 8, and 0
    /// leaves errors out.
    pub fn copies(self, copies: u32) -> Deviations<'a, H, E, N, S> {
        Deviations { copies, ..self.generic() }
    }

    fn generic(self) -> Deviations<'a, H, E, N, S> {
        Deviations { run: self, given: None, copies: COPIES }
    }
}

impl<H, E, N, S> Deviations<'_, H, E, N, S>
where
    H: Discretized<E>,
    N: Noise,
    S: Summation<H, E>,
{
    /// As [`Simulation::deviations`].
    pub fn deviations<D: Into<Vec<f64>>>(mut self, deviations: impl IntoIterator<Item = D>) -> Self {
        self.given = Some(deviations.into_iter().map(Into::into).collect());
        self
    }

    /// As [`Simulation::copies`].
    pub fn copies(mut self, copies: u32) -> Self {
        self.copies = copies;
        self
    }

    /// The stride of the series that the run is asked for, by `record_every`.
    fn take_stride(&mut self) -> Option<u64> {
        self.run.take_stride()
    }
}

/// The deviations of a run from this start: `wanted` ones, of those that are given the first. With
/// constraints they are projected on the tangent space of the manifold.
///
/// # Errors
/// [`ConfigError::Setting`] for more than are independent, for fewer given ones, and for those that are none.
pub(crate) fn chosen<H: Hamiltonian>(
    system: &H,
    start: &State<H::Vector>,
    given: Option<Vec<Vec<f64>>>,
    wanted: usize,
) -> Result<Vec<Vec<f64>>, ConfigError> {
    let (q, p) = (start.q.components(), start.p.components());
    let (length, most) = (2 * q.len(), 2 * system.degrees_left(q.len()));
    let number = given.as_ref().map_or(wanted, |given| given.len().max(wanted));
    if number > most {
        return wrong(format!(
            "{number} deviations of a system with {} degrees of freedom: at most {most} are independent",
            system.degrees_left(q.len())
        ));
    }
    let tangent = |deviation: &mut Vec<f64>| {
        if let Some(manifold) = system.manifold()
            && deviation.len() == length
        {
            manifold.make_tangent(ManifoldPoint { q, p, t: start.t }, deviation);
        }
    };
    match given {
        None => start::generic(wanted, length, tangent),
        Some(given) if given.len() < wanted => wrong(format!(
            "{wanted} deviations are needed, and {} are given: give more, or leave `deviations` out",
            given.len()
        )),
        Some(mut given) => {
            given.truncate(wanted);
            given.iter_mut().for_each(tangent);
            start::checked(given, length)
        }
    }
}
