//! The turns of one thread.
//!
//! Threads have windows next to each other, and of the new state the part that belongs to them: each goes over its own as far as that
//! can be without what others write. The rest, a few windows at the borders, is taken when all are done. Every number is that of one thread:
//! which turns a window waits for changes no term and no order of a sum.

use std::marker::PhantomData;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use super::check::Check;
use super::layout::{Strip, Windows};
use super::order::Turn;
use super::sums::{Moved, Stretch, Window};
use super::{Kick, LINE, Move, Moves, Share};
use crate::lanes::instructions::{InstructionSet, Kernel};
use crate::scalar::Number;
use crate::threads::each;

/// The part of the new state that is written, from the place `first` on. Lists that are not needed are empty.
pub(super) struct Room<'a> {
    pub(super) first: usize,
    /// Coordinates after the rounds with even and with odd numbers.
    pub(super) even: &'a mut [f64],
    pub(super) odd: &'a mut [f64],
    pub(super) momenta: &'a mut [f64],
    /// Where the last force acts, and the force.
    pub(super) kept: [&'a mut [f64]; 2],
}

impl<'a> Room<'a> {
    #[inline(always)]
    pub(super) fn lend(&mut self) -> Room<'_> {
        let Self { first, even, odd, momenta, kept: [q, force] } = self;
        Room { first: *first, even, odd, momenta, kept: [q, force] }
    }

    /// What is before a place, and what is from it on.
    fn divide(self, place: usize) -> [Self; 2] {
        let Self { first, even, odd, momenta, kept: [q, force] } = self;
        let halves = |list: &'a mut [f64]| list.split_at_mut((place - first).min(list.len()));
        let ((even, even_behind), (odd, odd_behind)) = (halves(even), halves(odd));
        let ((momenta, momenta_behind), (q, q_behind)) = (halves(momenta), halves(q));
        let (force, force_behind) = halves(force);
        let kept = [q_behind, force_behind];
        [
            Self { first, even, odd, momenta, kept: [q, force] },
            Self { first: place, even: even_behind, odd: odd_behind, momenta: momenta_behind, kept },
        ]
    }
}

/// A step as all threads see it.
#[derive(Clone, Copy)]
pub(super) struct Taking<'a> {
    pub(super) windows: &'a Windows,
    pub(super) rounds: &'a [Range<usize>],
    pub(super) q: &'a [f64],
    pub(super) p: &'a [f64],
    /// Whether the first force is the one that is kept.
    pub(super) reuses: bool,
}

impl Taking<'_> {
    /// New numbers from the place `first` on.
    #[inline(always)]
    fn stretch<'n>(&self, first: usize, numbers: &'n [f64]) -> Stretch<'n> {
        Stretch { numbers, first, degrees: self.q.len() }
    }

    /// The turns of all shares, each on a thread; whether all numbers are finite.
    pub(super) fn on_threads<M: Moves, T: Number<f64>, const EXACTLY: bool>(
        self,
        moves: &mut M,
        shares: &mut [Share],
        room: Room<'_>,
        instructions: InstructionSet,
    ) -> bool {
        let (is_finite, mut behind) = (AtomicBool::new(true), (moves.share(), room));
        let mut jobs = Vec::with_capacity(shares.len());
        for share in shares {
            let (moves, room) = behind;
            let [moves, moves_behind] = moves.divide(share.end);
            let [room, room_behind] = room.divide(share.end);
            behind = (moves_behind, room_behind);
            jobs.push(Job::<_, T, EXACTLY>::new(self, moves, share, room));
        }
        each(jobs, |job| {
            if !job.run_by(instructions) {
                is_finite.store(false, Ordering::Relaxed);
            }
        });
        is_finite.into_inner()
    }
}

/// Turns of windows, with slopes in numbers `T`, which are for vector instructions unless `EXACTLY` is asked for.
pub(super) struct Job<'a, M, T, const EXACTLY: bool> {
    step: Taking<'a>,
    moves: M,
    turns: &'a [Turn],
    sums: &'a mut [f64],
    room: Room<'a>,
    numbers: PhantomData<fn() -> T>,
}

impl<'a, M: Moves, T: Number<f64>, const EXACTLY: bool> Job<'a, M, T, EXACTLY> {
    pub(super) fn new(step: Taking<'a>, moves: M, share: &'a mut Share, room: Room<'a>) -> Self {
        let Share { turns, sums, .. } = share;
        let first = sums[step.windows.margin()..].as_ptr().align_offset(LINE * size_of::<f64>()).min(LINE);
        Self { step, moves, turns, sums: &mut sums[first..], room, numbers: PhantomData }
    }

    /// Compiled once, and called from wherever jobs are done. Whether all new numbers are finite.
    #[inline(never)]
    pub(super) fn run_by(self, instructions: InstructionSet) -> bool {
        if EXACTLY { self.run::<1, 1>() } else { instructions.run(self) }
    }
}

/// The output is whether all new numbers are finite.
impl<M: Moves, T: Number<f64>, const EXACTLY: bool> Kernel for Job<'_, M, T, EXACTLY> {
    type Output = bool;

    #[inline(always)]
    fn run<const L: usize, const HALF: usize>(self) -> bool {
        let Self { step, mut moves, turns, sums, room, .. } = self;
        let Taking { windows, rounds, q, p, reuses } = step;
        let Room { first, even, odd, momenta, kept: [kept_q, kept_force] } = room;
        let last = rounds.len() - 1;
        let keeps = M::IS_WORD && !kept_q.is_empty() && last > 0;
        let mut check = Check::default();
        for &Turn { round, window } in turns {
            let strip = windows.strip(window);
            let (from, to) = match round {
                0 => (Stretch::all(q), &mut *even),
                round if round % 2 == 1 => (step.stretch(first, even), &mut *odd),
                _ => (step.stretch(first, odd), &mut *even),
            };
            let own = strip.start - first..strip.end - first;
            // Until something is stored, momenta are those of the state.
            let base = (round == 0).then(|| &p[strip.start..strip.end]);
            let (kept, sums) = ([&mut *kept_q, &mut *kept_force], &mut *sums);
            let place = Place { step, strip, from, first, own };
            let mut turn = InTurn { place, to, momenta, kept, sums, base, has_drifted: false };
            for number in rounds[round].clone() {
                match moves.kind(number) {
                    Move::Kick(_) if M::IS_WORD && reuses && round == 0 => turn.kick_again(&mut check),
                    Move::Kick(kick) => {
                        turn.kick::<M, T>(&moves, number, kick, &mut check);
                        if keeps && round == last {
                            turn.keep();
                        }
                    }
                    Move::Drift => turn.drift::<M, T>(&moves, number, &mut check),
                    change if M::CHANGES => turn.change(&mut moves, number, change, &mut check),
                    _ => {}
                }
            }
        }
        check.is_finite()
    }
}

/// Where a window is, and what it reads.
struct Place<'a> {
    step: Taking<'a>,
    strip: Strip<'a>,
    /// The coordinates after the round before.
    from: Stretch<'a>,
    /// The place that the lists of the [`Room`] begin with.
    first: usize,
    /// Where the window is there.
    own: Range<usize>,
}

/// A round of a window.
struct InTurn<'a> {
    place: Place<'a>,
    /// The coordinates after the round.
    to: &'a mut [f64],
    momenta: &'a mut [f64],
    kept: [&'a mut [f64]; 2],
    sums: &'a mut [f64],
    /// The momenta of the state, until there are others.
    base: Option<&'a [f64]>,
    has_drifted: bool,
}

impl InTurn<'_> {
    /// A kick with the force that is kept.
    #[inline(always)]
    fn kick_again(&mut self, check: &mut Check) {
        let own = self.place.own.clone();
        let (p, force) = (&mut self.momenta[own.clone()], &self.kept[1][own]);
        check.store(p, self.base.take(), force, |p, force| p + force);
    }

    #[inline(always)]
    fn kick<M: Moves, T: Number<f64>>(&mut self, moves: &M, number: usize, kick: Kick, check: &mut Check) {
        let Place { strip, from, own, .. } = &self.place;
        let p = &mut self.momenta[own.clone()];
        let mut into = match kick {
            Kick::Terms if M::IS_WORD => Window::onto(*strip, self.sums, self.base.unwrap_or(p)),
            _ => Window::empty(*strip, self.sums),
        };
        moves.add_forces::<T, _>(number, *from, &mut into);
        let (base, sums) = (self.base.take(), into.finish());
        match kick {
            Kick::Minus if !M::IS_WORD => check.store(p, base, sums, |p, sum| p - sum),
            Kick::Plus if M::IS_WORD => check.store(p, base, sums, |p, sum| p + sum),
            Kick::Terms if M::IS_WORD => check.store(p, base, sums, |_, sum| sum),
            _ => check.store(p, base, sums, |p, sum| p + (0.0 - sum)),
        }
    }

    /// The sums of the last kick are the force where it acted.
    #[inline(always)]
    fn keep(&mut self) {
        let Place { strip, from, own, .. } = &self.place;
        let [q, force] = &mut self.kept;
        force[own.clone()].copy_from_slice(&self.sums[strip.own()]);
        q[own.clone()].copy_from_slice(&from[strip.start..strip.end]);
    }

    /// Stores momenta of the state, which something else than a kick reads.
    #[inline(always)]
    fn settle(&mut self) {
        if let Some(base) = self.base.take() {
            self.momenta[self.place.own.clone()].copy_from_slice(base);
        }
    }

    #[inline(always)]
    fn drift<M: Moves, T: Number<f64>>(&mut self, moves: &M, number: usize, check: &mut Check) {
        self.settle();
        let Place { step, strip, from, first, own } = &self.place;
        let momenta = step.stretch(*first, self.momenta);
        if M::HAVE_ONE_VELOCITY && !(M::CHANGES && self.has_drifted) {
            let mut moved = Moved { strip: *strip, base: *from, next: self.to, first: *first };
            moves.add_velocities::<T, _>(number, momenta, &mut moved);
            check.look(&self.to[own.clone()]);
        } else {
            let base = (!self.has_drifted).then(|| &from[strip.start..strip.end]);
            let q = &mut self.to[own.clone()];
            let mut into = match M::IS_WORD {
                true => Window::onto(*strip, self.sums, base.unwrap_or(q)),
                false => Window::empty(*strip, self.sums),
            };
            moves.add_velocities::<T, _>(number, momenta, &mut into);
            let sums = into.finish();
            match M::IS_WORD {
                true => check.store(q, base, sums, |_, sum| sum),
                false => check.store(q, base, sums, |q, sum| q + sum),
            }
        }
        self.has_drifted = true;
    }

    /// What changes places one by one.
    #[inline(always)]
    fn change<M: Moves>(&mut self, moves: &mut M, number: usize, change: Move, check: &mut Check) {
        self.settle();
        let Place { strip, from, own, .. } = &self.place;
        let places = strip.start..strip.end;
        let p = &mut self.momenta[own.clone()];
        if change == Move::State {
            let q = &mut self.to[own.clone()];
            if !self.has_drifted {
                q.copy_from_slice(&from[places.clone()]);
            }
            moves.change_state(number, places, q, p);
            check.look(q);
            self.has_drifted = true;
        } else {
            moves.change_momenta(number, places, p);
        }
        check.look(p);
    }
}
