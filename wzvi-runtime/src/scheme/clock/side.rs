//! Side steps: single steps over a given time from a node, which the path itself does not take.

use std::marker::PhantomData;

use crate::algebra::memory::{MemoryRequest, StepMemory};
use crate::algebra::state::{State, Vector, copy_state};
use crate::error::{ConfigError, StepFailure};
use crate::scheme::system::{Exchange, Hamiltonian, LiftParameter, Scheme, StepArguments, anew, as_they_are};

/// Takes side steps by the scheme `T`, and keeps their room. Each is of the full order of the scheme, and
/// knows nothing of the steps before.
#[derive(Clone, Debug)]
pub(crate) struct SideStepper<H: Hamiltonian, T: Scheme<H>> {
    prepared: Option<T::Prepared<f64>>,
    memory: Option<T::Memory<f64>>,
    system: PhantomData<fn(&H)>,
}

impl<H: Hamiltonian, T: Scheme<H>> Default for SideStepper<H, T> {
    fn default() -> Self {
        Self { prepared: None, memory: None, system: PhantomData }
    }
}

impl<H: Hamiltonian, T: Scheme<H>> SideStepper<H, T> {
    /// The state after the time `h` (negative runs backwards) from the state `from`, with these increments.
    ///
    /// # Errors
    /// The errors of the step; [`StepFailure::NonFinite`] if the system has no data for it.
    pub(crate) fn step(
        &mut self,
        system: &H,
        from: &State<H::Vector>,
        h: f64,
        dw: &[f64],
        into: &mut State<H::Vector>,
    ) -> Result<(), StepFailure> {
        copy_state(into, from);
        if h == 0.0 {
            return Ok(());
        }
        let mut memory = self.memory.take().unwrap_or_else(|| T::memory(system));
        memory.tell(&MemoryRequest::Forget);
        let prepared = self.prepared(system, h).map_err(|_| StepFailure::NonFinite)?;
        let (q, p) = (into.q.components_mut(), into.p.components_mut());
        let at = StepArguments { t: from.t, h, q, p, dw };
        let taken = anew::advance::<H, T, f64, f64>(system, prepared, at, &mut memory);
        self.memory = Some(memory);
        taken?;
        into.t = from.t + h;
        Ok(())
    }

    /// Adds the energy that the last step exchanged, as far as its scheme accounts for it; the heat of each
    /// degree of freedom where they have temperatures of their own.
    pub(crate) fn exchanged(&self, system: &H, sum: &mut Exchange) -> &[f64] {
        let Some(memory) = &self.memory else { return &[] };
        if T::PROPERTIES.exchanges {
            *sum += T::exchanged(system, memory);
        }
        if T::PROPERTIES.has_temperatures { T::heats(memory) } else { &[] }
    }

    fn prepared(&mut self, system: &H, h: f64) -> Result<&T::Prepared<f64>, ConfigError> {
        let lift: LiftParameter<'_, f64> = &as_they_are;
        let prepared = match self.prepared.take() {
            Some(mut prepared) => {
                T::resize(system, lift, &mut prepared, h)?;
                prepared
            }
            None => T::prepare(system, lift, h)?,
        };
        Ok(self.prepared.insert(prepared))
    }
}
