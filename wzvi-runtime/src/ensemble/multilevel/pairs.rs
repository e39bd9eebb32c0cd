//! A block of coupled paths: a fine and a coarse one on each Brownian path.

use std::f64::consts::FRAC_1_SQRT_2;

use super::super::dispatch::Kernel;
use super::super::group::Group;
use super::super::job::{Job, Observable};
use super::super::pace::Pace;
use super::estimate::{LevelError, LevelFailure, Samples};
use crate::lanes::Lanes;
use crate::scalar::Scalar;
use crate::system::Discretized;

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
    pub(super) observable: &'j Observable<'a, H::Vector>,
    pub(super) number: u64,
}

impl<H: Discretized<E>, E, const WIDTH: usize> Kernel for Pairs<'_, '_, H, E, WIDTH> {
    /// `None` if the run was stopped on the way.
    type Output = Result<Option<Samples>, LevelError>;

    #[inline(always)]
    fn run<const L: usize>(self) -> Self::Output {
        if WIDTH == 0 { self.of_width::<L>() } else { self.of_width::<WIDTH>() }
    }
}

impl<H: Discretized<E>, E, const WIDTH: usize> Pairs<'_, '_, H, E, WIDTH> {
    #[inline(always)]
    fn of_width<const L: usize>(self) -> Result<Option<Samples>, LevelError> {
        let mut samples = Samples::default();
        let mut fine = Group::<H, E, L>::new(self.fine);
        let mut coarse = self.coarse.map(Group::<H, E, L>::new);
        let mut sums = vec![Lanes::from_f64(0.0); self.fine.system.noises()];
        let mut pace = Pace::new(self.fine.stop);
        let size = block_size(self.fine.level);
        let (mut path, end) = (self.number * size, (self.number + 1) * size);
        while path < end {
            fine.begin(path, end);
            if let Some(coarse) = &mut coarse {
                coarse.begin(path, end);
            }
            for step in 0..self.fine.steps {
                if pace.is_stopped() {
                    return Ok(None);
                }
                for (process, sum) in sums.iter_mut().enumerate() {
                    let drawn = fine.drawn(process, step);
                    fine.drive(process, step, drawn);
                    match &mut coarse {
                        Some(coarse) if step % 2 == 1 => {
                            coarse.drive(process, step / 2, (*sum + drawn) * FRAC_1_SQRT_2);
                        }
                        _ => *sum = drawn,
                    }
                }
                if let Some(coarse) = &mut coarse
                    && step % 2 == 1
                {
                    coarse.advance(step / 2);
                }
                fine.advance(step);
            }
            self.collect(path, &mut fine, coarse.as_mut(), &mut samples)?;
            path += L as u64;
        }
        Ok(Some(samples))
    }

    /// The values at the end, or the first path that has none.
    #[inline(never)]
    fn collect<const L: usize>(
        &self,
        first: u64,
        fine: &mut Group<'_, '_, H, E, L>,
        mut coarse: Option<&mut Group<'_, '_, H, E, L>>,
        samples: &mut Samples,
    ) -> Result<(), LevelError> {
        let level = self.fine.level;
        let failures =
            [fine.take_first_failure(), coarse.as_mut().and_then(|group| group.take_first_failure())];
        // Of a pair the coarse path, which is the reason in most cases: the last of those that are equal.
        if let Some(failure) = failures.into_iter().flatten().rev().min_by_key(|failure| failure.path) {
            let cause = LevelFailure::Step(failure.error);
            return Err(LevelError { level, path: failure.path, h: failure.error.h, cause });
        }
        for lane in 0..L {
            if !fine.is_path(lane) {
                continue;
            }
            let value = |group: &mut Group<'_, '_, H, E, L>, Job { h, steps, .. }: &Job<'_, H, E>| {
                let value = (self.observable)(group.state_after(lane, *steps));
                let h = *h;
                let cause = LevelFailure::NonFinite(value);
                let path = first + lane as u64;
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
