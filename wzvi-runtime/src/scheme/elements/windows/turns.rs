//! The turns of one thread.
//!
//! Each thread has a range of adjacent windows and the part of the new state that belongs to them. It takes
//! those turns that do not depend on the output of other threads. The rest, a few windows at the borders, is
//! taken when all threads have finished. Every number is the same as on one thread: the order of the turns
//! changes no term and no order of a sum.

use std::marker::PhantomData;
use std::ops::Range;

use super::check::Check;
use super::layout::{Strip, Windows};
use super::order::Turn;
use super::portions::{Part, Portion};
use super::sums::{Moved, Stretch, Window};
use super::{Elements, Kick, LINE, Move, Slopes, Word};
use crate::algebra::lanes::instructions::Kernel;
use crate::algebra::scalar::Number;

/// The data of a step that all threads share.
#[derive(Clone, Copy)]
pub(super) struct Taking<'a> {
    pub(super) windows: &'a Windows,
    pub(super) rounds: &'a [Range<usize>],
    pub(super) q: &'a [f64],
    pub(super) p: &'a [f64],
    /// Whether the first force of the step is the kept one.
    pub(super) reuses: bool,
}

/// The turns of a thread, and scratch for the sums of a window.
pub(super) type Share = Portion<Vec<Turn>>;

/// Turns of windows, with slopes in numbers `T`. `WHOLE`, for a part that covers the whole system, is a
/// compile-time constant because offsets into a smaller one take time.
pub(super) struct Job<'a, H, W, T, const WHOLE: bool> {
    step: Taking<'a>,
    system: &'a H,
    word: W,
    turns: &'a [Turn],
    sums: &'a mut [f64],
    /// The new state: coordinates after the rounds with even and with odd numbers, momenta, the coordinates
    /// at which the last force acts, and the force, and what rounding took from coordinates and from momenta.
    part: Part<'a, 7>,
    numbers: PhantomData<fn() -> T>,
}

impl<'a, H: Elements + Sync, W: Word, T: Number<f64>, const WHOLE: bool> Job<'a, H, W, T, WHOLE> {
    pub(super) fn new(
        step: Taking<'a>,
        system: &'a H,
        word: W,
        share: &'a mut Share,
        part: Part<'a, 7>,
    ) -> Self {
        let Portion { work: turns, sums, .. } = share;
        let first = sums[step.windows.margin()..].as_ptr().align_offset(LINE * size_of::<f64>()).min(LINE);
        Self { step, system, word, turns, sums: &mut sums[first..], part, numbers: PhantomData }
    }
}

/// The output is whether all new numbers are finite.
impl<H: Elements + Sync, W: Word, T: Number<f64>, const WHOLE: bool> Kernel for Job<'_, H, W, T, WHOLE> {
    type Output = bool;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn run<const L: usize, const HALF: usize>(self) -> bool {
        let mut part = self.part;
        let Self { step, system, word, turns, sums, .. } = self;
        let Taking { windows, rounds, q, p, reuses } = step;
        // The positions of lists are read again for each move; otherwise the compiler computes offsets for
        // moves that never come.
        let Part { first, lists: [even, odd, momenta, kept_q, kept_force, lost_q, lost_p] } = &mut part;
        let (first, last) = (if WHOLE { 0 } else { *first }, rounds.len() - 1);
        let keeps = W::ADDS_TERMS && !kept_q.is_empty() && last > 0;
        let mut check = Check::default();
        for &Turn { round, window } in turns {
            let strip = windows.strip(window);
            let places = strip.start..strip.end;
            let own = strip.start - first..strip.end - first;
            let (from, to): (&[f64], &mut &mut [f64]) = match round {
                0 => (q, &mut *even),
                round if round % 2 == 1 => (*even, &mut *odd),
                _ => (*odd, &mut *even),
            };
            if W::CARRIES && round == 0 {
                let [of_q, of_p] = word.lost();
                lost_q[own.clone()].copy_from_slice(&of_q[places.clone()]);
                lost_p[own.clone()].copy_from_slice(&of_p[places.clone()]);
            }
            let mut taken = OneTurn::<'_, H, W, WHOLE> {
                system,
                word: &word,
                check: &mut check,
                strip,
                first,
                from: Stretch {
                    numbers: from,
                    first: if WHOLE || round == 0 { 0 } else { first },
                    degrees: q.len(),
                },
                to,
                momenta,
                lost_q,
                lost_p,
                sums,
                base: (round == 0).then(|| &p[places.clone()]),
                has_drifted: false,
            };
            for number in rounds[round].clone() {
                let kind = taken.word.kind(number);
                if !matches!(kind, Move::Kick(_)) {
                    taken.store_base();
                }
                match kind {
                    Move::Kick(_) if W::ADDS_TERMS && reuses && round == 0 => {
                        taken.kick_again(&kept_force[own.clone()]);
                    }
                    Move::Kick(kick) => {
                        let force = taken.kick::<T>(number, kick);
                        if keeps && round == last {
                            kept_force[own.clone()].copy_from_slice(force);
                            kept_q[own.clone()].copy_from_slice(&taken.from[places.clone()]);
                        }
                    }
                    Move::Drift => taken.drift::<T>(number),
                    Move::Momenta if W::CHANGES => taken.change_momenta(number),
                    Move::State if W::CHANGES => taken.change_state(number),
                    Move::Momenta | Move::State => {}
                }
            }
        }
        check.is_finite()
    }
}

/// A window in a round.
struct OneTurn<'t, H, W, const WHOLE: bool> {
    system: &'t H,
    word: &'t W,
    check: &'t mut Check,
    strip: Strip<'t>,
    /// The first place of the part.
    first: usize,
    /// Coordinates before the turn (`from`) and after it (`to`).
    from: Stretch<'t>,
    to: &'t mut [f64],
    momenta: &'t mut [f64],
    /// What rounding took from coordinates and momenta, if sums are compensated.
    lost_q: &'t mut [f64],
    lost_p: &'t mut [f64],
    sums: &'t mut [f64],
    /// The momenta of the state, until new ones are stored.
    base: Option<&'t [f64]>,
    has_drifted: bool,
}

impl<H: Elements + Sync, W: Word, const WHOLE: bool> OneTurn<'_, H, W, WHOLE> {
    /// The range of its places in the part.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn own(&self) -> Range<usize> {
        self.strip.start - self.first..self.strip.end - self.first
    }

    /// Copies the momenta of the state, unless a kick has stored new ones.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn store_base(&mut self) {
        if let Some(base) = self.base.take() {
            let own = self.own();
            self.momenta[own].copy_from_slice(base);
        }
    }

    /// Adds the kept force of the previous step to the momenta.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn kick_again(&mut self, force: &[f64]) {
        let own = self.own();
        let (p, base) = (&mut self.momenta[own.clone()], self.base.take());
        if W::CARRIES {
            return self.check.store_compensated(p, base, force, &mut self.lost_p[own], |force| force);
        }
        self.check.store(p, base, force, |p, force| p + force);
    }

    /// Adds forces to momenta; returns the sums of the window.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn kick<T: Number<f64>>(&mut self, number: usize, kick: Kick) -> &[f64] {
        let own = self.own();
        let p = &mut self.momenta[own.clone()];
        let mut into = match kick {
            Kick::Terms if W::ADDS_TERMS && !W::CARRIES => {
                Window::onto(self.strip, self.sums, self.base.unwrap_or(p))
            }
            _ => Window::empty(self.strip, self.sums),
        };
        let (system, word, wanted) = (self.system, self.word, Slopes::BY_COORDINATES);
        match WHOLE {
            true => word.add_slopes::<H, T, _, _>(system, number, self.from.numbers, wanted, &mut into),
            false => word.add_slopes::<H, T, _, _>(system, number, &self.from, wanted, &mut into),
        }
        let (base, sums) = (self.base.take(), into.finish());
        if W::CARRIES {
            let lost = &mut self.lost_p[own];
            match kick {
                Kick::Plus | Kick::Terms => self.check.store_compensated(p, base, sums, lost, |sum| sum),
                _ => self.check.store_compensated(p, base, sums, lost, |sum| 0.0 - sum),
            }
            return sums;
        }
        match kick {
            Kick::Minus if !W::ADDS_TERMS => self.check.store(p, base, sums, |p, sum| p - sum),
            Kick::Plus if W::ADDS_TERMS => self.check.store(p, base, sums, |p, sum| p + sum),
            Kick::Terms if W::ADDS_TERMS => self.check.store(p, base, sums, |_, sum| sum),
            _ => self.check.store(p, base, sums, |p, sum| p + (0.0 - sum)),
        }
        sums
    }

    /// Adds velocities to coordinates.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn drift<T: Number<f64>>(&mut self, number: usize) {
        let own = self.own();
        let Self { system, word, strip, first, from, to, momenta, lost_q, has_drifted, .. } = self;
        let wanted = Slopes::BY_MOMENTA;
        let stretch = &Stretch { numbers: momenta, first: *first, degrees: from.degrees };
        if H::FACTS.has_one_velocity && !(W::CHANGES && *has_drifted) && !W::CARRIES {
            let mut moved = Moved { strip: *strip, base: *from, next: to, first: *first };
            match WHOLE {
                true => word.add_slopes::<H, T, _, _>(system, number, stretch.numbers, wanted, &mut moved),
                false => word.add_slopes::<H, T, _, _>(system, number, stretch, wanted, &mut moved),
            }
            self.check.look(&to[own]);
        } else {
            let base = (!*has_drifted).then(|| &from[strip.start..strip.end]);
            let q = &mut to[own.clone()];
            let mut into = match W::ADDS_TERMS && !W::CARRIES {
                true => Window::onto(*strip, self.sums, base.unwrap_or(q)),
                false => Window::empty(*strip, self.sums),
            };
            match WHOLE {
                true => word.add_slopes::<H, T, _, _>(system, number, stretch.numbers, wanted, &mut into),
                false => word.add_slopes::<H, T, _, _>(system, number, stretch, wanted, &mut into),
            }
            let sums = into.finish();
            match W::ADDS_TERMS {
                _ if W::CARRIES => {
                    self.check.store_compensated(q, base, sums, &mut lost_q[own], |sum| sum);
                }
                true => self.check.store(q, base, sums, |_, sum| sum),
                false => self.check.store(q, base, sums, |q, sum| q + sum),
            }
        }
        *has_drifted = true;
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn change_momenta(&mut self, number: usize) {
        let own = self.own();
        let lost = if W::CARRIES { &mut self.lost_p[own.clone()] } else { &mut [] };
        let p = &mut self.momenta[own];
        self.word.change_momenta(number, self.strip.start..self.strip.end, p, lost);
        self.check.look(p);
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn change_state(&mut self, number: usize) {
        let places = self.strip.start..self.strip.end;
        let own = self.own();
        let (q, p) = (&mut self.to[own.clone()], &mut self.momenta[own]);
        if !self.has_drifted {
            q.copy_from_slice(&self.from[places.clone()]);
        }
        self.word.change_state(number, places, q, p);
        self.check.look(q);
        self.check.look(p);
        self.has_drifted = true;
    }
}
