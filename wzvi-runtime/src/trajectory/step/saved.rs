//! The state of a stepper in a checkpoint.

use super::{StepTime, Stepper};
use crate::algebra::state::Vector;
use crate::algebra::state_sum::StateSum;
use crate::ground::numbers::{Numbers, Tape};
use crate::scheme::system::{Discretized, PreparedOf};

impl<H: Discretized<E>, E, C: StateSum<f64>> Stepper<'_, H, E, C> {
    /// Everything that steps change. What depends on system and step size only is computed anew.
    pub(crate) fn pass(&mut self, tape: &mut Tape) {
        let Self {
            system: _,
            h: _,
            prepared: _,
            memory,
            carry,
            before,
            time,
            reached,
            exchanged,
            ledger: _,
            is_unaccounted: _,
            scheme: _,
        } = self;
        let StepTime { start, ticks, now } = time;
        tape.word(before);
        tape.word(ticks);
        tape.numbers([start, now]);
        for vector in reached {
            // A system may not know its size before its first step.
            let length = vector.components().len();
            let kept = tape.length(length);
            if kept != length {
                *vector = H::Vector::zeros(kept);
            }
            tape.numbers(vector.components_mut());
        }
        memory.pass(tape);
        carry.pass(tape);
        if Self::MAY_EXCHANGE {
            tape.numbers([&mut exchanged.all.work, &mut exchanged.all.heat]);
        }
        if H::PROPERTIES.has_temperatures {
            let degrees = tape.length(exchanged.by_degree.len());
            exchanged.by_degree.resize(degrees, 0.0);
            tape.numbers(&mut exchanged.by_degree);
        }
    }

    /// The constants of all steps, which are computed once, for people and checksums.
    pub(crate) fn prepared(&self) -> &PreparedOf<H, E> {
        &self.prepared
    }
}
