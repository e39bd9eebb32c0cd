//! Temperatures by the equipartition of energy.
//!
//! Under the Gibbs measure `⟨p_i ∂H/∂p_i⟩ = ⟨q_i ∂H/∂q_i⟩ = kT` for every degree of freedom, the second where
//! `q_i` is confined (R. C. Tolman, *The Principles of Statistical Mechanics*, 1938, section 42): a kinetic
//! temperature and a configurational one, which a scheme need not both have.

use std::fmt;

use super::BatchMeans;
use crate::algebra::state::{State, Vector};
use crate::ground::digits::estimate;
use crate::scheme::system::{Discretized, Hamiltonian};
use crate::trajectory::recorded::Trajectory;

/// The temperature of a degree of freedom, by averages along a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Share {
    /// `kT`, in units of energy.
    pub temperature: f64,
    /// Its standard error, correlations included ([`BatchMeans::standard_error`]); NaN while the path is too
    /// short to know it.
    pub standard_error: f64,
    /// `temperature ± 1.96 error_bound` covers it in 95 % ([`BatchMeans::error_bound`]).
    pub error_bound: f64,
}

/// `1.002 ± 0.003`, with the standard error.
impl fmt::Display for Share {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&estimate(self.temperature, self.standard_error))
    }
}

impl Share {
    /// The value for degrees of freedom that have no common temperature.
    const NONE: Self = Self { temperature: f64::NAN, standard_error: f64::NAN, error_bound: f64::NAN };

    fn of(batches: &BatchMeans) -> Self {
        let (standard_error, error_bound) = (batches.standard_error(), batches.error_bound());
        Self { temperature: batches.mean(), standard_error, error_bound }
    }
}

/// How the energy is shared among the degrees of freedom, and in all.
#[derive(Clone, Debug, PartialEq)]
pub struct Equipartition {
    /// `⟨p_i ∂H/∂p_i⟩`; empty with constraints.
    pub kinetic: Vec<Share>,
    /// `⟨q_i ∂H/∂q_i⟩`
    pub configurational: Vec<Share>,
    /// `⟨p · ∂H/∂p⟩ / d`; NaN where the temperatures of the degrees of freedom differ, and there is no one
    /// temperature.
    pub kinetic_temperature: Share,
    /// `⟨q · ∂H/∂q⟩ / d`, likewise.
    pub configurational_temperature: Share,
}

/// Both temperatures of the system, if it has one, and a line for each degree of freedom.
impl fmt::Display for Equipartition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { kinetic_temperature, configurational_temperature, .. } = self;
        match kinetic_temperature.temperature.is_nan() {
            true => f.write_str("no one temperature; kinetic and configurational by degree of freedom:")?,
            false => write!(
                f,
                "kinetic temperature {kinetic_temperature}, configurational {configurational_temperature}"
            )?,
        }
        for (i, (kinetic, configurational)) in self.kinetic.iter().zip(&self.configurational).enumerate() {
            write!(f, "\n{i}: {kinetic}, {configurational}")?;
        }
        Ok(())
    }
}

/// `x · y / d`
fn shared(x: &[f64], y: &[f64], degrees: usize) -> f64 {
    x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>() / degrees as f64
}

/// `p · ∂H/∂p / d`, whose average is the kinetic temperature (energy units): an observable. `d` is the number
/// of degrees of freedom that constraints leave.
pub(crate) fn kinetic<H: Hamiltonian>(system: &H, state: &State<H::Vector>) -> f64 {
    let degrees = system.degrees_left(state.p.components().len());
    shared(state.p.components(), system.energy_gradient(state).p.components(), degrees)
}

/// `q · ∂H/∂q / d`, whose average is the configurational temperature where the system is confined: an
/// observable. NaN with constraints, where it is not.
pub(crate) fn configurational<H: Hamiltonian>(system: &H, state: &State<H::Vector>) -> f64 {
    if system.manifold().is_some() {
        return f64::NAN;
    }
    let degrees = state.q.components().len();
    shared(state.q.components(), system.energy_gradient(state).q.components(), degrees)
}

/// `p_i ∂H/∂p_i`
pub(crate) fn kinetic_of<H: Hamiltonian>(system: &H, state: &State<H::Vector>, i: usize) -> f64 {
    product_at(&state.p, &system.energy_gradient(state).p, i)
}

/// `q_i ∂H/∂q_i`
pub(crate) fn configurational_of<H: Hamiltonian>(system: &H, state: &State<H::Vector>, i: usize) -> f64 {
    product_at(&state.q, &system.energy_gradient(state).q, i)
}

fn product_at<V: Vector>(x: &V, slope: &V, i: usize) -> f64 {
    let pair = x.components().get(i).zip(slope.components().get(i));
    pair.map_or(f64::NAN, |(x, slope)| x * slope)
}

impl<V: Vector, E> Trajectory<V, E> {
    /// The temperatures of all degrees of freedom, by averages over the recorded nodes. With constraints only
    /// the kinetic temperature of all together, over the degrees of freedom that are left: momenta in a
    /// tangent plane do not share the energy one by one.
    pub fn equipartition<H: Discretized<E, Vector = V>>(&self, system: &H) -> Equipartition {
        let degrees = self.last().q.components().len();
        let lists = || vec![BatchMeans::new(); degrees];
        let (mut kinetic_by_degree, mut configurational_by_degree) = (lists(), lists());
        let [mut of_momenta, mut of_coordinates] = [BatchMeans::new(), BatchMeans::new()];
        for state in self.iter() {
            let gradient = system.energy_gradient(state);
            let halves = [
                (&mut kinetic_by_degree, &state.p, &gradient.p),
                (&mut configurational_by_degree, &state.q, &gradient.q),
            ];
            for (batches, x, slope) in halves {
                for ((batches, x), slope) in batches.iter_mut().zip(x.components()).zip(slope.components()) {
                    batches.add(x * slope);
                }
            }
            of_momenta.add(kinetic(system, state));
            of_coordinates.add(configurational(system, state));
        }
        let shares = |batches: &[BatchMeans]| batches.iter().map(Share::of).collect();
        let (mut kinetic_temperature, mut configurational_temperature) =
            (Share::of(&of_momenta), Share::of(&of_coordinates));
        if H::PROPERTIES.has_temperatures {
            (kinetic_temperature, configurational_temperature) = (Share::NONE, Share::NONE);
        }
        if system.manifold().is_some() {
            return Equipartition {
                kinetic: Vec::new(),
                configurational: Vec::new(),
                kinetic_temperature,
                configurational_temperature: Share::NONE,
            };
        }
        Equipartition {
            kinetic: shares(&kinetic_by_degree),
            configurational: shares(&configurational_by_degree),
            kinetic_temperature,
            configurational_temperature,
        }
    }
}
