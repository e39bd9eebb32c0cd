//! The turns of one thread.
//!
//! Threads have windows next to each other, and of the new state the part that belongs to them: each goes over its own as far as that
//! can be without what others write. The rest, a few windows at the borders, is taken when all are done. Every number is that of one thread:
//! which turns a window waits for changes no term and no order of a sum.

use std::marker::PhantomData;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use super::check::Check;
use super::layout::Windows;
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
        let keeps = !kept_q.is_empty() && last > 0;
        let mut check = Check::default();
        for &Turn { round, window } in turns {
            let strip = windows.strip(window);
            let places = strip.start..strip.end;
            // Where they are in the room.
            let own = strip.start - first..strip.end - first;
            let (from, to) = match round {
                0 => (Stretch::all(q), &mut *even),
                round if round % 2 == 1 => (step.stretch(first, even), &mut *odd),
                _ => (step.stretch(first, odd), &mut *even),
            };
            // Until something is stored, momenta are those of the state.
            let mut base = (round == 0).then(|| &p[places.clone()]);
            let mut has_drifted = false;
            for number in rounds[round].clone() {
                let kind = moves.kind(number);
                if !matches!(kind, Move::Kick(_))
                    && let Some(base) = base.take()
                {
                    momenta[own.clone()].copy_from_slice(base);
                }
                match kind {
                    Move::Kick(_) if reuses && round == 0 => {
                        let (p, force) = (&mut momenta[own.clone()], &kept_force[own.clone()]);
                        check.store(p, base.take(), force, |p, force| p + force);
                    }
                    Move::Kick(kick) => {
                        let p = &mut momenta[own.clone()];
                        let mut into = match kick {
                            Kick::Terms => Window::onto(strip, sums, base.unwrap_or(p)),
                            _ => Window::empty(strip, sums),
                        };
                        moves.add_forces::<T, _>(number, from, &mut into);
                        let (base, sums) = (base.take(), into.finish());
                        match kick {
                            Kick::Minus => check.store(p, base, sums, |p, sum| p - sum),
                            Kick::MinusFromZero => check.store(p, base, sums, |p, sum| p + (0.0 - sum)),
                            Kick::Plus => check.store(p, base, sums, |p, sum| p + sum),
                            Kick::Terms => check.store(p, base, sums, |_, sum| sum),
                        }
                        if keeps && round == last {
                            kept_force[own.clone()].copy_from_slice(sums);
                            kept_q[own.clone()].copy_from_slice(&from[places.clone()]);
                        }
                    }
                    Move::Drift { .. } if M::HAVE_ONE_VELOCITY && !(M::DRIFT_TWICE && has_drifted) => {
                        let mut moved = Moved { strip, base: from, next: &mut *to, first };
                        moves.add_velocities::<T, _>(number, step.stretch(first, momenta), &mut moved);
                        check.look(&to[own.clone()]);
                        has_drifted = true;
                    }
                    Move::Drift { by_terms } => {
                        let base = (!has_drifted).then(|| &from[places.clone()]);
                        let q = &mut to[own.clone()];
                        let mut into = match by_terms {
                            true => Window::onto(strip, sums, base.unwrap_or(q)),
                            false => Window::empty(strip, sums),
                        };
                        moves.add_velocities::<T, _>(number, step.stretch(first, momenta), &mut into);
                        let sums = into.finish();
                        match by_terms {
                            true => check.store(q, base, sums, |_, sum| sum),
                            false => check.store(q, base, sums, |q, sum| q + sum),
                        }
                        has_drifted = true;
                    }
                    Move::Momenta => {
                        moves.change_momenta(number, places.clone(), &mut momenta[own.clone()]);
                        check.look(&momenta[own.clone()]);
                    }
                    Move::State => {
                        let (q, p) = (&mut to[own.clone()], &mut momenta[own.clone()]);
                        if !has_drifted {
                            q.copy_from_slice(&from[places.clone()]);
                        }
                        moves.change_state(number, places.clone(), q, p);
                        check.look(q);
                        check.look(p);
                        has_drifted = true;
                    }
                }
            }
        }
        check.is_finite()
    }
}
