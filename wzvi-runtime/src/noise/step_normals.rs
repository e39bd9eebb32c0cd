//! One normal for every step: the noise of ensembles.
//!
//! The random words are those of ChaCha8. Its key holds the seed, the process and the step size, its stream
//! number is the path, and the block number is the number of the step divided by [`STEPS`]: a block of 16
//! words makes [`STEPS`] normals, in pairs of three words, and leaves one word over.
//!
//! A step of size `h` that starts at time `t` has the number `⌊t/h⌋` ([`number`]), wherever its run starts:
//! noise belongs to the time at which it acts, and a run that continues another from its last time has other
//! noise. Numbers of steps before `t = 0` (after it, if `h` is negative) are negative. Blocks and cuts are
//! numbered in two's complement, so that each of these has an address of its own.
//!
//! | bytes of the key | content |
//! |---|---|
//! | 0..8 | seed |
//! | 8..16 | process |
//! | 16..20 | six bits: level of a multilevel run; five: how often a step is halved; the rest: high bits of the number of the cut |
//! | 20..24, 28..32 | the step size, low and high half of its bits |
//! | 24..28 | version of this layout (a change changes every path) |
//!
//! Integers are little-endian. Keys of a Wiener path (`noise::stream`) have another version.
//!
//! A step is halved by the Brownian bridge: of an increment `w` over an interval of length `l`, the halves
//! have `w/2 ± √l/2 ξ`. Cut `k` of halving `m` of the step number `n` has the normal at the block
//! `2^{m-1} n + k` of its own key. A last step that is shorter than the others is a step of its own size.
//!
//! Tested by `wzvi-runtime/tests/runtime/ensemble_law.rs` and `tests/ensembles/continued.rs`.

use super::blocks::{PathBlocks, PathSource};
use super::random::{self, pair};
use super::truncation::{Truncation, truncation_setters};
use super::wiener::check_step;
use super::{Interval, Noise, NoiseError, Paths};
use crate::increments::Identity;
use crate::scheme::plan::Plan;

/// Steps whose normals one block of random words makes.
pub(crate) const STEPS: usize = 10;
const VERSION: u32 = 0x8000_0002;
/// Halvings of a step, at most: as many as [`Retry`](crate::trajectory::retry::Retry) allows.
const MOST_HALVINGS: u32 = 30;

/// Step numbers are exact as `f64` up to here.
const FARTHEST: f64 = (1_u64 << 53) as f64;
/// A start so close before a node, in steps, is at the node. It has to be large against the rounding of start
/// times, `ε t/h` for each run that continues another; and as the boundary between two numbers it is not
/// where runs start: at nodes, their halves, thirds and tenths.
const SLACK: f64 = 1.0 / 1024.0;

/// The number of the step of size `h` that starts at `t`: `⌊t/h⌋`, where times within rounding of a node are
/// the node.
///
/// It grows by 1 from step to step, so that successive steps of one size never have the same one, whether one
/// run takes them or several. (`⌊t/h + s⌋` has that property for any constant `s`; only where rounding
/// exceeds [`SLACK`] it has to depend on `t`.)
///
/// # Errors
/// [`NoiseError::Time`] where times are too far apart to tell steps of this size from each other.
fn number(t: f64, h: f64) -> Result<i64, NoiseError> {
    let steps = t / h;
    if steps.is_nan() || steps.abs() > FARTHEST {
        return Err(NoiseError::Time { t, limit: FARTHEST * h.abs() });
    }
    let slack = (4.0 * f64::EPSILON * steps.abs()).clamp(SLACK, 0.5);
    Ok((steps + slack).floor() as i64)
}

/// The number of a step among all of its size, and that of the first step of its run.
#[derive(Clone, Copy, Debug)]
struct StepNumber {
    start: f64,
    h: f64,
    first: i64,
}

impl StepNumber {
    /// A number without a run: no time equals NaN.
    const NOTHING: Self = Self { start: f64::NAN, h: f64::NAN, first: 0 };
}

/// The block of a step, and the place of the step in the block.
pub(crate) fn place(step: i64) -> (u64, usize) {
    let steps = STEPS as i64;
    (step.div_euclid(steps).cast_unsigned(), step.rem_euclid(steps) as usize)
}

/// The block and the place of a step of size `h` that starts at `t`.
///
/// # Errors
/// [`NoiseError::Time`]
pub(crate) fn place_of(t: f64, h: f64) -> Result<(u64, usize), NoiseError> {
    number(t, h).map(place)
}

/// The key of the normals of one process in steps of size `h`, on one level of a multilevel run.
pub(crate) fn key(seed: u64, process: u64, h: f64, level: u32) -> [u32; 8] {
    let words = |x: u64| [x as u32, (x >> 32) as u32];
    let ([a, b], [e, f]) = (words(seed), words(h.to_bits()));
    of_process(&[a, b, 0, 0, level, e, VERSION, f], process)
}

/// The key of another process.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn of_process(key: &[u32; 8], process: u64) -> [u32; 8] {
    let [a, b, _, _, e, f, g, h] = *key;
    [a, b, process as u32, (process >> 32) as u32, e, f, g, h]
}

/// The normal of a cut: `key` is that of the uncut steps, `halving` counts from 1, and
/// `cut < 2^{halving - 1}` within its step.
fn cut_normal(mut key: [u32; 8], path: u64, step: i64, halving: u32, cut: u64) -> f64 {
    // In absolute value at most 2^83, so that 85 bits in two's complement have it: step numbers are at most
    // 2^54.
    let number = (i128::from(step) << (halving - 1)) | i128::from(cut);
    key[4] |= (halving << 6) | (((number >> 64) as u32) << 11);
    let words = random::block(&key, path, number as u64);
    let [normal, _] = pair([words[0], words[1], words[2]]);
    normal
}

/// Increments that no two step sizes share: one standard normal for each step, drawn by its address
/// `(seed, h, path, process, ⌊t/h⌋)` with the time `t` at which the step starts, times `√|h|`.
/// [`Wiener`](super::Wiener) is the noise whose path is the same for every step size.
///
/// A run that continues another, `.start(run.last().clone())`, has other noise than that one, since its time
/// goes on. One that starts at `t = 0` again with the same seed repeats the noise: give it another seed.
///
/// They are what [`Ensemble::seed`](crate::ensemble::Ensemble::seed) draws, and cost a small part of a Wiener
/// path's increments: path `n` of an ensemble of seed `s` is driven by `StepNormals::seed(s).path(n)`, bit
/// for bit. A step that a [`Retry`](crate::trajectory::retry::Retry) halves gets the halves of its increment,
/// by the Brownian bridge.
///
/// ```
/// use wzvi_runtime::noise::{Interval, Noise, StepNormals};
///
/// let mut noise = StepNormals::seed(7).path(12_345);
/// let mut dw = [0.0];
/// noise.increments(&Interval { start: 0.0, h: 0.02, step: 3 }, &mut dw)?;
/// # Ok::<(), wzvi_runtime::noise::NoiseError>(())
/// ```
#[derive(Clone, Debug)]
pub struct StepNormals {
    seed: u64,
    path: u64,
    level: u32,
    is_antithetic: bool,
    truncation: Truncation,
    /// Whether the current run truncates unless told otherwise.
    truncates: bool,
    /// The step size of the run, once it is known: shorter steps are its halves.
    h: Option<f64>,
    /// The run of the last request.
    numbered: StepNumber,
    /// The increments of the last blocks.
    drawn: PathBlocks,
}

impl StepNormals {
    /// The paths of a seed.
    pub fn seed(seed: u64) -> Self {
        Self {
            seed,
            path: 0,
            level: 0,
            is_antithetic: false,
            truncation: Truncation::Unset,
            truncates: false,
            h: None,
            numbered: StepNumber::NOTHING,
            drawn: PathBlocks::default(),
        }
    }

    /// Another member of an ensemble (the default is 0).
    pub fn path(mut self, path: u64) -> Self {
        self.set_path(path);
        self
    }

    /// Paths in pairs: `2k` has the normals that path `k` has otherwise, and `2k + 1` has them negated.
    pub fn antithetic(mut self) -> Self {
        self.is_antithetic = true;
        self.drawn.clear();
        self
    }

    truncation_setters!(|noise: Self, truncation| noise.with_truncation(truncation));

    /// The truncation that is set.
    pub fn truncation(&self) -> Truncation {
        self.truncation
    }

    /// With another truncation, if one is set.
    pub(crate) fn with_truncation(mut self, truncation: Truncation) -> Self {
        if truncation != Truncation::Unset {
            self.truncation = truncation;
            self.drawn.clear();
        }
        self
    }

    /// The normals of one level of a multilevel run.
    pub(crate) fn on_level(mut self, level: u32) -> Self {
        self.level = level;
        self.drawn.clear();
        self
    }

    pub(crate) fn is_antithetic(&self) -> bool {
        self.is_antithetic
    }

    /// The key of a process in steps of size `h`.
    pub(crate) fn key(&self, process: u64, h: f64) -> [u32; 8] {
        key(self.seed, process, h, self.level)
    }

    /// The truncation of the current run.
    fn acting(&self) -> Truncation {
        self.truncation.in_run(self.truncates)
    }

    /// The largest normal, in absolute value, for steps of size `h`.
    pub(crate) fn clip(&self, h: f64) -> f64 {
        self.acting().bound(h, 1.0)
    }

    /// The stream of this path.
    fn stream(&self) -> u64 {
        if self.is_antithetic { self.path / 2 } else { self.path }
    }

    /// The number of the first step of size `h` of a run from this start.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn first_of(&mut self, start: f64, h: f64) -> Result<i64, NoiseError> {
        if (self.numbered.start, self.numbered.h) != (start, h) {
            self.numbered = StepNumber { start, h, first: number(start, h)? };
        }
        Ok(self.numbered.first)
    }

    /// The number of the first step of the prepared run.
    pub(crate) fn first(&self) -> i64 {
        self.numbered.first
    }

    /// Sets the increments of a whole step of size `h`, which is at this place of a block.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn whole(&mut self, h: f64, (block, place): (u64, usize), dw: &mut [f64]) {
        if !self.drawn.has(dw.len(), h, block) {
            self.draw(dw.len(), h, block);
        }
        dw.iter_mut().zip(self.drawn.row(block, place)).for_each(|(to, from)| *to = *from);
    }

    #[inline(never)]
    fn draw(&mut self, processes: usize, h: f64, block: u64) {
        let (key, stream, clip) = (self.key(0, h), self.stream(), self.clip(h));
        let source = PathSource { key, stream, clip, deviation: self.sign() * h.abs().sqrt() };
        self.drawn.draw(processes, h, block, &source);
    }

    fn sign(&self) -> f64 {
        if self.is_antithetic && self.path % 2 == 1 { -1.0 } else { 1.0 }
    }

    /// The increment over the first part of a step with the increment `whole`, a fraction between 0 and 1 of
    /// it: by the halves that [`StepNormals::part`] has, to `2^-30` of the step, and linear in between.
    fn until(&self, whole: f64, process: usize, h: f64, step: i64, fraction: f64) -> f64 {
        let mut dw = whole;
        let (key, stream, sign) = (self.key(process as u64, h), self.stream(), self.sign());
        let (mut before, mut cut, mut fraction) = (0.0, 0, fraction);
        for halving in 1..=RESOLVED {
            if fraction == 0.0 || fraction == 1.0 {
                break;
            }
            let length = h.abs() / (1_u64 << (halving - 1)) as f64;
            let height = sign * 0.5 * length.sqrt() * cut_normal(key, stream, step, halving, cut);
            let halves = [0.5 * dw + height, 0.5 * dw - height];
            // Doubling a fraction is exact, and so is taking 1 from what is between 1 and 2.
            fraction *= 2.0;
            let is_second = fraction > 1.0;
            if is_second {
                before += halves[0];
                fraction -= 1.0;
            }
            (dw, cut) = (halves[usize::from(is_second)], 2 * cut + u64::from(is_second));
        }
        before + fraction * dw
    }

    /// The number of a step that begins where `interval` does and has the size `h`.
    fn number_of(&mut self, interval: &Interval, h: f64) -> Result<i64, NoiseError> {
        if h == interval.h {
            Ok(self.first_of(interval.start, h)?.wrapping_add_unsigned(interval.step))
        } else {
            number(interval.begin(), h)
        }
    }

    /// The increment of part `part` of `2^halvings` of a step with the increment `whole`.
    fn part(&self, whole: f64, process: usize, h: f64, step: i64, halvings: u32, part: u64) -> f64 {
        let mut dw = whole;
        let (key, stream, sign) = (self.key(process as u64, h), self.stream(), self.sign());
        for halving in 1..=halvings {
            let cut = part >> (halvings - halving + 1);
            let length = h.abs() / (1_u64 << (halving - 1)) as f64;
            let height = sign * 0.5 * length.sqrt() * cut_normal(key, stream, step, halving, cut);
            let is_second = (part >> (halvings - halving)) & 1 == 1;
            dw = 0.5 * dw + if is_second { -height } else { height };
        }
        dw
    }
}

/// The halvings of a step after which its path is a straight line.
const RESOLVED: u32 = MOST_HALVINGS;

/// How often `h` was halved to become `part`; `None` if it was not.
fn halvings(h: f64, part: f64) -> Option<u32> {
    (0..=MOST_HALVINGS).find(|&halvings| h / (1_u64 << halvings) as f64 == part)
}

impl Noise for StepNormals {
    #[inline]
    fn increments(&mut self, interval: &Interval, dw: &mut [f64]) -> Result<(), NoiseError> {
        check_step(interval.h)?;
        self.truncation.check()?;
        let h = self.h.unwrap_or(interval.h);
        let Some(halvings) = halvings(h, interval.h) else {
            return Err(NoiseError::Setting(format!(
                "increments for steps of {h} and their halves, but asked for a step of {}: use `Wiener` where step sizes share a path",
                interval.h
            )));
        };
        let (step, part) = (interval.step >> halvings, interval.step & ((1 << halvings) - 1));
        let step = self.first_of(interval.start, h)?.wrapping_add_unsigned(step);
        self.whole(h, place(step), dw);
        if halvings > 0 {
            for (process, dw) in dw.iter_mut().enumerate() {
                *dw = self.part(*dw, process, h, step, halvings, part);
            }
        }
        Ok(())
    }

    /// A part has the increments of a step of its size, as for any other step size.
    fn increments_of_part(&mut self, interval: &Interval, h: f64, dw: &mut [f64]) -> Result<(), NoiseError> {
        check_step(h)?;
        self.truncation.check()?;
        self.whole(h, place_of(interval.begin(), h)?, dw);
        Ok(())
    }

    /// By the Brownian bridge: the halves of the step, their halves, and so on.
    fn increments_within(
        &mut self,
        interval: &Interval,
        h: f64,
        [from, to]: [f64; 2],
        dw: &mut [f64],
    ) -> Result<(), NoiseError> {
        check_step(h)?;
        self.truncation.check()?;
        let step = self.number_of(interval, h)?;
        self.whole(h, place(step), dw);
        for (process, dw) in dw.iter_mut().enumerate() {
            *dw = self.until(*dw, process, h, step, to) - self.until(*dw, process, h, step, from);
        }
        Ok(())
    }

    /// By the number of the step alone, with the normals of steps of size one: `W(h θ) = √h W(θ)` in law.
    fn increments_of_own_size(
        &mut self,
        interval: &Interval,
        h: f64,
        [from, to]: [f64; 2],
        dw: &mut [f64],
    ) -> Result<(), NoiseError> {
        check_step(h)?;
        self.truncation.check()?;
        let step = interval.step.cast_signed();
        self.whole(1.0, place(step), dw);
        for (process, dw) in dw.iter_mut().enumerate() {
            let part = self.until(*dw, process, 1.0, step, to) - self.until(*dw, process, 1.0, step, from);
            *dw = h.abs().sqrt() * part;
        }
        Ok(())
    }

    fn prepare(&mut self, plan: &Plan, h: f64, _processes: usize, start: f64) -> Result<(), NoiseError> {
        self.truncates = plan.truncates_increments();
        self.truncation.check()?;
        check_step(h)?;
        self.h = Some(h);
        self.first_of(start, h)?;
        self.drawn.clear();
        Ok(())
    }

    fn largest_increment(&self, h: f64) -> f64 {
        self.acting().bound(h, h.abs().sqrt())
    }

    fn is_divisible(&self) -> bool {
        true
    }

    fn skip_paths(&mut self, paths: u64) -> bool {
        self.set_path(self.path.wrapping_add(paths));
        true
    }

    fn identity(&self) -> Option<Identity> {
        let identity = Identity::of("StepNormals").with("seed", self.seed).with("path", self.path);
        let identity =
            identity.with("antithetic", self.is_antithetic).with("step size", self.h.unwrap_or(f64::NAN));
        Some(identity.with("truncation", self.acting()))
    }
}

impl Paths for StepNormals {
    fn set_path(&mut self, path: u64) {
        self.path = path;
        self.drawn.clear();
    }

    fn step_normals(&self) -> Option<StepNormals> {
        Some(self.clone())
    }

    fn seed_number(&self) -> Option<u64> {
        Some(self.seed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ask(noise: &mut StepNormals, h: f64, step: u64) -> [f64; 2] {
        let mut dw = [0.0; 2];
        noise.increments(&Interval { start: 0.0, h, step }, &mut dw).unwrap();
        dw
    }

    fn prepared(noise: StepNormals, h: f64) -> StepNormals {
        StepNormals { h: Some(h), ..noise }
    }

    /// No two step sizes share normals, whatever was asked for before.
    #[test]
    fn each_step_size_has_its_normals() {
        let mut noise = StepNormals::seed(7);
        ask(&mut noise, 0.02, 3);
        assert_eq!(ask(&mut noise, 0.01, 3), ask(&mut StepNormals::seed(7), 0.01, 3));
    }

    /// The parts of a step add up to the step, to three roundings each.
    #[test]
    fn halves_add_up() {
        for (h, step) in [(0.1, 3), (-0.25, 17), (7.0, (1 << 53) - 1)] {
            for noise in [StepNormals::seed(5).path(8), StepNormals::seed(5).antithetic().path(9)] {
                let mut noise = prepared(noise, h);
                let whole = ask(&mut noise, h, step);
                for halvings in [1_u32, 2, 5] {
                    let parts = 1_u64 << halvings;
                    let mut sum = [0.0; 2];
                    for part in 0..parts {
                        let dw = ask(&mut noise, h / parts as f64, step * parts + part);
                        sum = [sum[0] + dw[0], sum[1] + dw[1]];
                    }
                    for (sum, whole) in sum.iter().zip(whole) {
                        assert!(
                            (sum - whole).abs() < 1e-14 * h.abs().sqrt() * parts as f64,
                            "{h} {halvings}"
                        );
                    }
                }
            }
        }
    }

    /// Parts have the variance of their length, and successive ones are not correlated, across the cuts too:
    /// 40 000 samples of each, whose mean squares and products are known to 1/√20 000 and 1/√40 000; five
    /// such deviations.
    #[test]
    fn parts_are_wiener_increments() {
        let (h, halvings, n) = (0.5, 3_u32, 5000_u64);
        let mut noise = prepared(StepNormals::seed(11), h);
        let part = h / f64::from(1 << halvings);
        let parts: Vec<f64> = (0..n << halvings).map(|step| ask(&mut noise, part, step)[1]).collect();
        let n = parts.len() as f64;
        let square = parts.iter().map(|x| x * x).sum::<f64>() / (n * part);
        assert!((square - 1.0).abs() < 5.0 * (2.0 / n).sqrt(), "{square}");
        for lag in 1..9 {
            let product = parts.windows(lag + 1).map(|x| x[0] * x[lag]).sum::<f64>() / (n * part);
            assert!(product.abs() < 5.0 / n.sqrt(), "{lag}: {product}");
        }
    }

    /// The normals of steps of size `h` and `h/2` from one seed are not correlated: 10 000 products, five
    /// deviations of 1/100.
    #[test]
    fn step_sizes_share_nothing() {
        let of = |h: f64| {
            let mut noise = prepared(StepNormals::seed(3), h);
            (0..10_000).map(|step| ask(&mut noise, h, step)[0] / h.abs().sqrt()).collect::<Vec<f64>>()
        };
        let reference = of(0.1);
        for h in [0.05, 0.2, -0.1, 0.1 + 1e-17 + f64::EPSILON] {
            let product: f64 = reference.iter().zip(of(h)).map(|(x, y)| x * y).sum::<f64>() / 1e4;
            assert!(product.abs() < 0.05, "{h}: {product}");
        }
    }

    /// Also where the start is known to some roundings, at nodes and elsewhere, and where rounding exceeds
    /// the slack.
    #[test]
    fn steps_are_numbered_by_their_times() {
        for h in [0.1, 1.0 / 3.0, 0.02, 7.0, 1e-9, -0.1, -0.7] {
            for n in [-1_000_000_007_i64, -100, -3, -1, 0, 1, 2, 99, 1 << 40] {
                let t = n as f64 * h;
                for t in [t, t.next_up(), t.next_down(), t + h - h, t + 0.001 * h, t + 0.5 * h, t + 0.998 * h]
                {
                    assert_eq!(number(t, h), Ok(n), "{t} {h}");
                }
            }
        }
        assert_eq!([number(0.0, 0.1), number(-0.05, 0.1), number(-0.1, 0.1)], [Ok(0), Ok(-1), Ok(-1)]);
        let far = (1_u64 << 53) as f64;
        assert_eq!([number(far, 1.0), number(-far, 1.0)], [Ok(1 << 53), Ok(-(1 << 53))]);
        assert!(number(3.0 * far, 1.0).is_err() && number(f64::NAN, 1.0).is_err());
    }

    #[test]
    fn what_is_no_half_of_a_step_is_refused() {
        let mut noise = prepared(StepNormals::seed(3), 0.1);
        for h in [0.03, 0.2, -0.1, 0.1 / f64::from(1_u32 << 31)] {
            let outcome = noise.increments(&Interval { start: 0.0, h, step: 0 }, &mut [0.0]);
            assert!(matches!(outcome, Err(NoiseError::Setting(_))), "{h}: {outcome:?}");
        }
        // Cuts of the last steps that can be counted have addresses of their own.
        let last = (1_i64 << 53) - 1;
        let late = [(last, 30, 0), (last, 30, 1), (last - 1, 30, 0), (last, 29, 0), (0, 30, 0), (0, 30, 1)];
        let early = late.map(|(step, halving, cut)| (-1 - step, halving, cut));
        let cuts = [late, early].concat();
        let normal = |(step, halving, cut)| cut_normal(key(1, 0, 0.1, 3), 0, step, halving, cut);
        let normals: Vec<f64> = cuts.into_iter().map(normal).collect();
        for (i, x) in normals.iter().enumerate() {
            assert!(!normals[..i].contains(x));
        }
    }
}
