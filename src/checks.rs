//! Functions and types that generated code hands the user's closures and schemes to, so that `rustc` checks
//! their types where they were written. Nothing here is called.

pub use core::marker::PhantomData;
pub use core::primitive::f64;

use wzvi_runtime::algebra::scalar::{ComputesWith, Constant, Scalar};
use wzvi_runtime::algebra::solve::Effort;
use wzvi_runtime::algebra::state_sum::{PlainSum, StateSum};
use wzvi_runtime::error::{ConfigError, StepFailure};
use wzvi_runtime::scheme::plan::{Knowledge, NoiseClass, Plan, Solver};
use wzvi_runtime::scheme::system::{Hamiltonian, LiftParameter, Movable, Scheme, StepArguments};

/// A scheme as it was written is the type that it was read as.
pub fn is_same<E>(_: PhantomData<E>) {}

/// A Hamiltonian.
pub fn of_state<V, F: Fn(V, V) -> f64>(_: F) {}

/// A Hamiltonian that reads the time.
pub fn of_time<V, F: Fn(V, V, f64) -> f64>(_: F) {}

/// A constraint.
pub fn of_coordinates<V, F: Fn(V) -> f64>(_: F) {}

/// A constraint that reads the time.
pub fn of_coordinates_and_time<V, F: Fn(V, f64) -> f64>(_: F) {}

/// A family of constraints.
pub fn constraint_family<V, F: Fn(V, usize) -> f64>(_: F) {}

/// A family of constraints that reads the time.
pub fn constraint_family_of_time<V, F: Fn(V, f64, usize) -> f64>(_: F) {}

/// A family of noises.
pub fn family<V, F: Fn(V, V, usize) -> f64>(_: F) {}

/// A family of noises that reads the time.
pub fn family_of_time<V, F: Fn(V, V, f64, usize) -> f64>(_: F) {}

/// A friction that depends on the coordinates.
pub fn of_place<V, R, F: Fn(V) -> R>(_: F) {}

/// A temperature of the time.
pub fn of_instant<R, F: Fn(f64) -> R>(_: F) {}

/// A temperature of the index of a site.
pub fn of_site<R, F: Fn(usize) -> R>(_: F) {}

/// A temperature of the index of a site and of the time.
pub fn of_site_and_instant<R, F: Fn(usize, f64) -> R>(_: F) {}

/// The one entry of a covector.
pub fn entry(_: f64) -> f64 {
    0.0
}

/// The entries of a covector: taken inside of the closure, so that what it maps may borrow its parameters.
pub fn entries<T, I: IntoIterator<Item = T>>(_: I) -> f64 {
    0.0
}

/// The steps of a system with errors, which does not compile.
#[derive(Clone, Copy, Debug)]
pub struct NoSteps;

impl<H: Hamiltonian> Scheme<H> for NoSteps {
    const PLAN: Plan = Plan {
        solver: Solver::Explicit,
        unknowns: 0,
        order: 1,
        noise: NoiseClass::None,
        consistent: false,
        conserves_energy: Knowledge::Unknown,
        energy_jumps: false,
        commuting: Knowledge::Unknown,
        has_weak_order_two: false,
        is_out_of_equilibrium: false,
    };
    type Prepared<K: Constant> = ();
    type Memory<S: Scalar> = ();
    type Unclocked = Self;
    type CompensatedSum<S: Scalar> = PlainSum;
    type Sum<S: Scalar> = PlainSum;

    fn prepare<K: Constant>(_: &H, _: LiftParameter<'_, K>, _: K) -> Result<(), ConfigError> {
        Err(ConfigError::Parameter)
    }

    fn advance<K: Constant, S: ComputesWith<K>, C: StateSum<S>, const CAREFUL: bool>(
        _: &H,
        _: &(),
        _: StepArguments<'_, S, K, impl Movable<S> + ?Sized>,
        _: &mut (),
        _: &mut C,
    ) -> Result<Effort, StepFailure> {
        Err(StepFailure::NonFinite)
    }
}
