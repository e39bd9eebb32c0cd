//! A block of coupled paths: a fine and a coarse one on each Brownian path.

use std::f64::consts::FRAC_1_SQRT_2;

use super::super::group::Group;
use super::super::halt::Halt;
use super::super::job::Job;
use super::super::pace::Pace;
use super::super::starts::OneSystem;
use super::estimate::Samples;
use crate::algebra::lanes::Lanes;
use crate::algebra::lanes::instructions::Kernel;
use crate::algebra::scalar::Scalar;
use crate::error::{LevelError, LevelFailure};
use crate::path::Error;
use crate::path::options::Observable;
use crate::path::steps::{Advance, Monitor, take_steps};
use crate::scheme::system::Discretized;

/// Brownian paths in a block of a level: few on the finest, which need few; on the coarsest as many as make the steps of a block
/// about as many.
pub(super) fn block_size(level: u32) -> u64 {
    64 << 4u32.saturating_sub(level)
}

/// One block of a level, as many Brownian paths at a time as the instructions ask for, or `WIDTH` if that is not 0; level 0
/// has no coarse path.
pub(super) struct Pairs<'j, 'a, H: Discretized<E>, E, const WIDTH: usize> {
    pub(super) fine: &'j Job<'a, H, E>,
    pub(super) coarse: Option<&'j Job<'a, H, E>>,
    pub(super) level: u32,
    pub(super) observable: &'j Observable<'a, H::Vector>,
    pub(super) number: u64,
}

impl<H: Discretized<E>, E, const WIDTH: usize> Kernel for Pairs<'_, '_, H, E, WIDTH> {
    type Output = Result<Samples, Halt>;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn run<const L: usize, const HALF: usize>(self) -> Self::Output {
        if const { WIDTH != 0 } {
            self.of_width::<WIDTH>()
        } else if const { size_of::<H::Vector>() > size_of::<f64>() } {
            self.of_width::<HALF>()
        } else {
            self.of_width::<L>()
        }
    }
}

/// A path of a level, and the coarse one beside it: the two of `L` Brownian paths.
struct Coupled<'j, 'a, H: Discretized<E>, E, const L: usize> {
    fine: Group<'j, 'a, H, E, OneSystem, L>,
    /// With the normals of the first of two fine steps, by process.
    coarse: Option<(Group<'j, 'a, H, E, OneSystem, L>, Vec<Lanes<L>>)>,
}

impl<H: Discretized<E>, E, const L: usize> Advance for Coupled<'_, '_, H, E, L> {
    type Error = Error;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn advance(&mut self, step: u64) -> Result<(), Error> {
        let Self { fine, coarse } = self;
        fine.draw(step)?;
        if let Some((coarse, first)) = coarse {
            for (process, first) in first.iter_mut().enumerate() {
                let drawn = fine.increments.normals(process, step)?;
                if step % 2 == 1 {
                    coarse.increments.drive(process, step / 2, (*first + drawn) * FRAC_1_SQRT_2);
                } else {
                    *first = drawn;
                }
            }
            if step % 2 == 1 {
                coarse.step(step / 2)?;
            }
        }
        fine.step(step)
    }
}

/// Asks now and then whether to stop.
struct Patrol<'j> {
    pace: Pace<'j>,
    seen: u64,
}

impl<P: Advance<Error = Error>> Monitor<P> for Patrol<'_> {
    type Error = Halt;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn next(&self, _path: &P, node: u64) -> u64 {
        node.saturating_add(self.pace.left())
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn look(&mut self, _path: &mut P, node: u64) -> Result<(), Halt> {
        self.pace.done(node - self.seen)?;
        self.seen = node;
        Ok(())
    }
}

impl<H: Discretized<E>, E, const WIDTH: usize> Pairs<'_, '_, H, E, WIDTH> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn of_width<const L: usize>(self) -> Result<Samples, Halt> {
        let mut samples = Samples::default();
        let still = || vec![Lanes::from_f64(0.0); self.fine.processes()];
        let mut pair = Coupled {
            fine: Group::<H, E, OneSystem, L>::new(self.fine),
            coarse: self.coarse.map(|job| (Group::new(job), still())),
        };
        if pair.coarse.is_some() {
            pair.fine = pair.fine.keeping_normals();
        }
        let mut patrol = Patrol { pace: Pace::new(self.fine.stop), seen: 0 };
        let size = block_size(self.level);
        let (mut path, end) = (self.number * size, (self.number + 1) * size);
        while path < end {
            pair.fine.begin(path, end)?;
            if let Some((coarse, _)) = &mut pair.coarse {
                coarse.begin(path, end)?;
            }
            patrol.seen = 0;
            take_steps(&mut pair, 0..self.fine.steps, &mut patrol)?;
            self.collect(path, &mut pair, &mut samples).map_err(Error::Level)?;
            path += L as u64;
        }
        Ok(samples)
    }

    /// The values at the end, or the first path that has none.
    #[inline(never)]
    fn collect<const L: usize>(
        &self,
        first: u64,
        pair: &mut Coupled<'_, '_, H, E, L>,
        samples: &mut Samples,
    ) -> Result<(), LevelError> {
        let (level, Coupled { fine, coarse }) = (self.level, pair);
        let mut coarse = coarse.as_mut().map(|(group, _)| group);
        let mut failures = fine.take_failures();
        failures.extend(coarse.iter_mut().flat_map(|group| group.take_failures()));
        // Of a pair the coarse path, which is the reason in most cases: the last of those that are equal.
        if let Some(failure) = failures.into_iter().rev().min_by_key(|failure| failure.path) {
            let cause = LevelFailure::Step(failure.error);
            return Err(LevelError { level, path: failure.path, h: failure.error.h, cause });
        }
        for lane in 0..L {
            if !fine.is_path(lane) {
                continue;
            }
            let value = |group: &mut Group<'_, '_, H, E, OneSystem, L>,
                         Job { h, steps, .. }: &Job<'_, H, E>| {
                let value = (self.observable)(group.state_at(lane, *steps));
                let (h, path) = (*h, first + lane as u64);
                let cause = LevelFailure::NonFinite(value);
                if value.is_finite() { Ok(value) } else { Err(LevelError { level, path, h, cause }) }
            };
            let end = value(fine, self.fine)?;
            let difference = match (&mut coarse, self.coarse) {
                (Some(coarse), Some(job)) => end - value(coarse, job)?,
                _ => end,
            };
            samples.push(end, difference);
        }
        Ok(())
    }
}
