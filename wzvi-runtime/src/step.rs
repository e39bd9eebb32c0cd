//! One step at a time.

use std::marker::PhantomData;

use crate::error::{ConfigError, StepError, StepFailure};
use crate::state::{State, Vector};
use crate::system::Discretized;

/// What one step took.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StepInfo {
    /// Newton iterations, over all blocks; 0 for explicit and linear steps.
    pub iterations: u32,
}

/// A prepared integrator: everything that depends on the system and the step size only is computed once.
///
/// Its steps allocate nothing. Time is `t_0 + n h` for `n` consecutive steps of one state, never accumulated.
#[derive(Debug)]
pub struct Stepper<'a, H: Discretized<E>, E> {
    system: &'a H,
    h: f64,
    prepared: H::Prepared,
    memory: H::Memory<f64>,
    steps: u64,
    clock: Clock,
    reached: State<H::Vector>,
    scheme: PhantomData<E>,
}

/// Time as `t_0 + n h`, restarted whenever the caller's state is at another time.
#[derive(Clone, Copy, Debug)]
struct Clock {
    start: f64,
    ticks: u64,
}

impl Clock {
    #[inline]
    fn now(self, h: f64) -> f64 {
        self.start + self.ticks as f64 * h
    }
}

impl<'a, H: Discretized<E>, E> Stepper<'a, H, E> {
    /// Prepares steps of size `h` (time units of the Hamiltonian; negative runs backwards).
    ///
    /// # Errors
    /// [`ConfigError::StepSize`] unless `h` is finite and not zero; [`ConfigError::Parameter`] and
    /// [`ConfigError::Singular`] if what is computed once for all steps is not finite or not invertible.
    pub fn new(system: &'a H, h: f64) -> Result<Self, ConfigError> {
        if !h.is_finite() || h == 0.0 {
            return Err(ConfigError::StepSize(h));
        }
        let d = system.degrees();
        Ok(Self {
            system,
            h,
            prepared: system.prepare(h)?,
            memory: Default::default(),
            steps: 0,
            clock: Clock { start: f64::NAN, ticks: 0 },
            reached: State { q: H::Vector::zeros(d), p: H::Vector::zeros(d), t: f64::NAN },
            scheme: PhantomData,
        })
    }

    /// The step size.
    pub fn step_size(&self) -> f64 {
        self.h
    }

    /// The system that it steps.
    pub fn system(&self) -> &'a H {
        self.system
    }

    /// Number of successful steps so far.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// One step of `state` with the given increments, one per noise (`&[]` without noise).
    ///
    /// # Errors
    /// [`StepError`] with time, step number and cause. The state is then bit for bit what it was, and so is the
    /// stepper.
    #[inline]
    pub fn step(&mut self, state: &mut State<H::Vector>, dw: &[f64]) -> Result<StepInfo, StepError> {
        let jumped = state.t != self.clock.now(self.h) || self.jumped(state);
        // A step that fails leaves the stepper as it was, too.
        let mut forgotten = Default::default();
        let clock = if jumped { Clock { start: state.t, ticks: 0 } } else { self.clock };
        let memory = if jumped { &mut forgotten } else { &mut self.memory };
        let next = Clock { ticks: clock.ticks + 1, ..clock };
        let (q, p) = (state.q.components_mut(), state.p.components_mut());
        let outcome = if next.now(self.h).is_finite() {
            self.system.advance(&self.prepared, state.t, self.h, q, p, dw, memory)
        } else {
            Err(StepFailure::NonFinite)
        };
        match outcome {
            Ok(solved) => {
                if jumped {
                    self.memory = forgotten;
                }
                self.clock = next;
                state.t = next.now(self.h);
                self.steps += 1;
                if Self::REMEMBERS {
                    self.reached.clone_from(state);
                }
                Ok(StepInfo { iterations: solved.iterations })
            }
            Err(cause) => Err(self.error(state, dw, cause)),
        }
    }

    /// Whether steps start from what the ones before left; otherwise nothing of them is kept.
    const REMEMBERS: bool = size_of::<H::Memory<f64>>() != 0;

    /// Whether the caller moved the state since the last step: then what that step left is no guide.
    #[inline]
    fn jumped(&self, state: &State<H::Vector>) -> bool {
        Self::REMEMBERS && *state != self.reached
    }

    /// Bad input shows in the result of a step, so that a good step does not pay for the check.
    #[cold]
    fn error(&self, state: &State<H::Vector>, dw: &[f64], cause: StepFailure) -> StepError {
        let inputs = || state.q.components().iter().chain(state.p.components()).chain(dw).chain([&state.t]);
        let cause = match cause {
            StepFailure::Increments { .. } | StepFailure::Dimension { .. } => cause,
            _ if inputs().all(|x| x.is_finite()) => cause,
            _ => StepFailure::NonFiniteInput,
        };
        StepError { step: self.steps, t: state.t, h: self.h, cause }
    }
}
