//! Kicks, drifts, and what acts on single sites, in turn.

use std::ops::Range;

use super::layout::Recorder;
use super::{Kick, Move, Moves, Taken, WindowPlan, advance};
use crate::algebra::scalar::Number;
use crate::error::StepFailure;
use crate::scheme::elements::{Given, Shared, Slopes, Sums, add_flow};

/// A flow of the step Hamiltonian `h H_0 + Σ_k ΔW_k H_k`, or of a part of it, as the force or the velocity that it adds.
#[derive(Clone, Copy, Debug)]
pub struct Flow<'a, S> {
    /// The time at which it is evaluated.
    pub t: f64,
    /// The increment of the drift, negative for a kick.
    pub h: f64,
    /// The increments of the noises, negative for a kick.
    pub dw: &'a [S],
}

/// What a force depends on besides the coordinates.
#[derive(Clone, Copy, Debug)]
pub struct Origin {
    /// The time, if the force reads it.
    pub t: Option<f64>,
    /// The increment of the drift.
    pub h: f64,
}

/// To the last bit.
impl PartialEq for Origin {
    fn eq(&self, other: &Self) -> bool {
        self.h.to_bits() == other.h.to_bits() && self.t.map(f64::to_bits) == other.t.map(f64::to_bits)
    }
}

/// A part of a step.
#[derive(Clone, Copy, Debug)]
pub enum Letter<'a> {
    /// `p ← p - ∂V/∂q`, by terms.
    Kick(Flow<'a, f64>),
    /// The same at an end of the step, by sums, which may be kept for the next step if they are those of an origin.
    KickAtEnd(Flow<'a, f64>, Option<Origin>),
    /// `q ← q + ∂T/∂p`
    Drift(Flow<'a, f64>),
    /// [`Word::change_momenta`]
    Momenta,
    /// [`Word::change_state`]
    State,
}

/// The parts of a step, each of which moves the state that those before it have left.
pub trait Word {
    /// The same parts for the time of a step, which threads may have.
    type Share<'s>: Word + Send
    where
        Self: 's;

    /// Whether there are other parts than kicks and drifts, and several drifts may be between two kicks.
    const CHANGES: bool = false;

    /// All places.
    fn share(&mut self) -> Self::Share<'_>;

    /// Those before a place, and those from it on, each for one thread.
    #[must_use]
    fn divide(self, place: usize) -> [Self; 2]
    where
        Self: Sized;

    /// How many parts there are.
    fn count(&self) -> usize;

    /// A part by its number.
    fn letter(&self, number: usize) -> Letter<'_>;

    /// Changes the momenta of some places one by one, and may be called again.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn change_momenta(&mut self, number: usize, places: Range<usize>, p: &mut [f64]) {
        let _ = (number, places, p);
    }

    /// Changes coordinates and momenta of some places one by one, and may be called again.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn change_state(&mut self, number: usize, places: Range<usize>, q: &mut [f64], p: &mut [f64]) {
        let _ = (number, places, q, p);
    }
}

/// A word of a system.
struct Spoken<'a, H, W> {
    system: &'a H,
    word: W,
    degrees: usize,
}

/// All parts of a step from `q` and `p`, if the system [has windows](crate::scheme::plan::Facts::has_windows).
///
/// # Errors
/// [`StepFailure::NonFinite`] if the new state is not finite.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn take_windows<'p, H: Shared, W: Word>(
    system: &H,
    word: &mut W,
    q: &[f64],
    p: &[f64],
    plan: &'p mut WindowPlan,
) -> Option<Result<Taken<'p>, StepFailure>> {
    if H::FACTS.has_windows {
        Some(advance(&mut Spoken { system, word: word.share(), degrees: q.len() }, q, p, plan))
    } else {
        None
    }
}

impl<'a, H: Shared, W: Word> Moves for Spoken<'a, H, W> {
    type Share<'s>
        = Spoken<'a, H, W::Share<'s>>
    where
        Self: 's;
    type Exact = H::Exact;
    type Usual = H::Usual;
    const HAVE_ONE_VELOCITY: bool = H::FACTS.has_one_velocity;
    const IS_WORD: bool = true;
    const CHANGES: bool = W::CHANGES;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn share(&mut self) -> Self::Share<'_> {
        Spoken { system: self.system, word: self.word.share(), degrees: self.degrees }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn divide(self, place: usize) -> [Self; 2] {
        let Self { system, word, degrees } = self;
        word.divide(place).map(|word| Self { system, word, degrees })
    }

    fn degrees(&self) -> usize {
        self.degrees
    }

    fn record(&self, mut recorder: &Recorder) {
        let somewhere = vec![0.0; self.degrees];
        let (mut has_kicked, mut has_drifted) = (false, false);
        for number in 0..self.word.count() {
            match self.word.letter(number) {
                Letter::Kick(_) | Letter::KickAtEnd(..) if !has_kicked => {
                    self.add_forces::<f64, _, _>(number, &somewhere[..], &mut recorder);
                    has_kicked = true;
                }
                Letter::Drift(_) if !has_drifted => {
                    self.add_velocities::<f64, _, _>(number, &somewhere[..], &mut recorder);
                    has_drifted = true;
                }
                _ => {}
            }
        }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn count(&self) -> usize {
        self.word.count()
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn kind(&self, number: usize) -> Move {
        match self.word.letter(number) {
            Letter::Kick(_) => Move::Kick(Kick::Terms),
            Letter::KickAtEnd(..) => Move::Kick(Kick::Plus),
            Letter::Drift(_) => Move::Drift,
            Letter::Momenta => Move::Momenta,
            Letter::State => Move::State,
        }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn origin(&self, number: usize) -> Option<Origin> {
        match self.word.letter(number) {
            Letter::KickAtEnd(_, origin) => origin,
            _ => None,
        }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn add_forces<T, V, A>(&self, number: usize, q: &V, into: &mut A)
    where
        T: Number<f64>,
        V: Given<f64> + ?Sized,
        A: Sums<f64>,
    {
        if let Letter::Kick(flow) | Letter::KickAtEnd(flow, _) = self.word.letter(number) {
            add_flow::<H, f64, T, _, A>(self.system, flow, q, Slopes::BY_COORDINATES, into);
        }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn add_velocities<T, V, A>(&self, number: usize, p: &V, into: &mut A)
    where
        T: Number<f64>,
        V: Given<f64> + ?Sized,
        A: Sums<f64>,
    {
        if let Letter::Drift(flow) = self.word.letter(number) {
            add_flow::<H, f64, T, _, A>(self.system, flow, p, Slopes::BY_MOMENTA, into);
        }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn change_momenta(&mut self, number: usize, places: Range<usize>, p: &mut [f64]) {
        self.word.change_momenta(number, places, p);
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn change_state(&mut self, number: usize, places: Range<usize>, q: &mut [f64], p: &mut [f64]) {
        self.word.change_state(number, places, q, p);
    }
}
