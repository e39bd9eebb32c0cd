//! The starting value of the iteration of a step, extrapolated from previous steps.

use crate::algebra::memory::{MemoryRequest, StepMemory};
use crate::algebra::scalar::{Mask, Scalar};
use crate::ground::numbers::{Numbers, Tape};

/// Unknowns of past steps, extrapolated to start the next one: `3x_n - 3x_{n-1} + x_{n-2}`.
#[derive(Clone, Copy, Debug)]
pub struct Extrapolation<S: Scalar, const N: usize> {
    past: [[S; N]; 3],
    /// Where a step is known, and where two are.
    known: [S::Mask; 2],
    /// Whether two are everywhere.
    is_full: bool,
}

impl<S: Scalar, const N: usize> Default for Extrapolation<S, N> {
    fn default() -> Self {
        let none = S::Mask::from_bool(false);
        Self { past: [[S::from_f64(0.0); N]; 3], known: [none; 2], is_full: false }
    }
}

impl<S: Scalar, const N: usize> Extrapolation<S, N> {
    /// The starting value: zero, constant, linear or quadratic, by the number of known steps; zero unless
    /// `USED`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn guess<const USED: bool>(&self) -> [S; N] {
        if !USED {
            return [S::from_f64(0.0); N];
        }
        let [a, b, c] = &self.past;
        // A plain loop: a closure would be compiled without the vector instructions of the caller.
        let mut guess = *a;
        for i in 0..N {
            guess[i] = (a[i] - b[i]) * 3.0 + c[i];
        }
        guess
    }

    /// Takes the solution of a step that succeeded; nothing unless `USED`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn record<const USED: bool>(&mut self, solution: [S; N]) {
        if !USED {
            return;
        }
        // Number by number: moved as a whole, lanes would leave their registers in parts.
        let [a, b, c] = &mut self.past;
        for i in 0..N {
            (c[i], b[i], a[i]) = (b[i], a[i], solution[i]);
        }
        if !self.is_full {
            self.pretend();
        }
    }

    /// [`Extrapolation::record`] in the lanes that have taken a step; the other lanes keep their past.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn record_where<const USED: bool>(&mut self, taken: S::Mask, solution: [S; N]) {
        if taken.all() {
            self.record::<USED>(solution);
        } else if S::MAY_FAIL_BY_LANE {
            *self = self.recorded_in_part::<USED>(taken, solution);
        }
    }

    /// By value, so that the caller's copy stays in registers.
    #[cold]
    #[inline(never)]
    fn recorded_in_part<const USED: bool>(mut self, taken: S::Mask, solution: [S; N]) -> Self {
        let mut next = self;
        next.record::<USED>(solution);
        for (old, new) in self.past.iter_mut().flatten().zip(next.past.iter().flatten()) {
            *old = S::select(taken, *new, *old);
        }
        for (old, new) in self.known.iter_mut().zip(next.known) {
            *old = (*old & !taken) | (new & taken);
        }
        self.is_full = self.known[1].all();
        self
    }

    /// Continues the one or two points that are known to the past, as a constant or as a line.
    #[cold]
    fn pretend(&mut self) {
        let ([a, b, c], [one, two]) = (&mut self.past, &mut self.known);
        for i in 0..N {
            b[i] = S::select(*one, b[i], a[i]);
            c[i] = S::select(*two, c[i], b[i] * 2.0 - a[i]);
        }
        (*one, *two) = (S::Mask::from_bool(true), *one);
        self.is_full = two.all();
    }
}

impl<S: Scalar, const N: usize> StepMemory for Extrapolation<S, N> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn tell(&mut self, request: &MemoryRequest) {
        match request {
            MemoryRequest::Forget => *self = Self::default(),
            MemoryRequest::Hold => {
                self.past = [self.past[0]; 3];
                (self.known[1], self.is_full) = (S::Mask::from_bool(false), false);
            }
            _ => {}
        }
    }
}

impl<S: Scalar, const N: usize> Numbers for Extrapolation<S, N> {
    fn pass(&mut self, tape: &mut Tape) {
        self.past.pass(tape);
        let count = |lane: usize| self.known.iter().map(|known| u8::from(known.lane(lane))).sum();
        let mut counts: Vec<u8> = (0..S::LANES).map(count).collect();
        tape.counts(&mut counts);
        if !tape.is_reading() {
            return;
        }
        self.known = [0, 1].map(|steps| S::Mask::of_lanes(|lane| counts[lane] > steps));
        self.is_full = self.known[1].all();
    }
}

#[cfg(test)]
mod tests {
    use super::Extrapolation;
    use crate::algebra::lanes::{LaneMask, Lanes};
    use crate::algebra::scalar::Mask as _;
    use crate::ground::numbers::{Numbers as _, Tape};

    #[test]
    fn extrapolation_is_exact_for_a_parabola() {
        let mut memory = Extrapolation::<f64, 1>::default();
        for n in 0..3 {
            memory.record::<true>([f64::from(n * n)]);
        }
        assert_eq!(memory.guess::<true>(), [9.0]);
        assert_eq!(memory.guess::<false>(), [0.0]);
    }

    /// The words of a memory after any number of steps give the same start of the next steps, in lanes that
    /// remember different numbers of steps as well.
    #[test]
    fn words_have_all_steps_that_are_known() {
        let words = |memory: &mut Extrapolation<f64, 1>| Tape::write(|tape| memory.pass(tape));
        let solution = |step: u32| [(0.7 * f64::from(step)).exp()];
        let mut of_lanes = Vec::new();
        for steps in 0..5 {
            let mut memory = Extrapolation::<f64, 1>::default();
            (0..steps).for_each(|step| memory.record::<true>(solution(step)));
            let mut read = Extrapolation::<f64, 1>::default();
            Tape::read(words(&mut memory), |tape| read.pass(tape)).unwrap();
            of_lanes.push(words(&mut memory));
            for step in steps..8 {
                assert_eq!(read.guess::<true>(), memory.guess::<true>(), "after {steps} steps, at {step}");
                read.record::<true>(solution(step));
                memory.record::<true>(solution(step));
            }
        }
        let mut together = Extrapolation::<Lanes<5>, 1>::default();
        Tape::join(of_lanes.clone(), |tape| together.pass(tape)).unwrap();
        for (lane, words) in of_lanes.into_iter().enumerate() {
            assert_eq!(Tape::split(lane, |tape| together.pass(tape)), words, "lane {lane}");
        }
    }

    /// A path that takes only some of the steps of those beside it remembers those, to the last bit.
    #[test]
    fn a_lane_remembers_the_steps_that_it_took() {
        let solution = |step: u32, lane: usize| f64::from(step * step) + 0.3 * lane as f64;
        // The lanes that take each of six steps.
        let steps = [
            [true, true, false],
            [true, false, false],
            [true, true, false],
            [true, false, true],
            [true, true, false],
            [true, true, true],
        ];
        let mut together = Extrapolation::<Lanes<3>, 1>::default();
        let mut alone = [Extrapolation::<f64, 1>::default(); 3];
        for (step, took) in (0..).zip(steps) {
            let numbers =
                std::array::from_fn(|lane| if took[lane] { solution(step, lane) } else { f64::NAN });
            let taken = LaneMask::<3>::of_lanes(|lane| took[lane]);
            if taken.all() {
                together.record::<true>([Lanes::new(numbers)]);
            } else {
                together.record_where::<true>(taken, [Lanes::new(numbers)]);
            }
            for lane in 0..3 {
                if took[lane] {
                    alone[lane].record::<true>([numbers[lane]]);
                }
                assert_eq!(
                    together.guess::<true>()[0][lane].to_bits(),
                    alone[lane].guess::<true>()[0].to_bits()
                );
            }
        }
    }
}
