//! One normal for every step: the noise of ensembles.
//!
//! The random words are those of ChaCha8. Its key holds the seed, the process and the step size, its stream number is the path, and the
//! block number is the step divided by [`STEPS`]: a block of 16 words makes [`STEPS`] normals, in pairs of three words, and leaves one
//! word over.
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
//! A step is halved by the Brownian bridge: of an increment `w` over an interval of length `l`, the halves have `w/2 ± √l/2 ξ`. Cut `k` of
//! halving `m` of step `n` has the normal at the block `2^{m-1} n + k` of its own key.

use super::random::{self, pair};
use super::truncation::{Truncation, truncation_setters};
use super::wiener::check_step;
use super::{Divisible, Interval, Noise, NoiseError, Paths};
use crate::increments::Identity;
use crate::scheme::plan::Plan;

/// Steps whose normals one block of random words makes.
pub(crate) const STEPS: usize = 10;
const VERSION: u32 = 0x8000_0002;
/// Halvings of a step, at most: as many as [`Retry`](crate::path::retry::Retry) allows.
const MOST_HALVINGS: u32 = 30;

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

/// The normals of a block of random words.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn normals(words: &[u32; 16]) -> [f64; STEPS] {
    let mut to = [0.0; STEPS];
    for k in 0..STEPS / 2 {
        [to[2 * k], to[2 * k + 1]] = pair([words[3 * k], words[3 * k + 1], words[3 * k + 2]]);
    }
    to
}

/// The normal of a cut: `key` is that of the uncut steps, `halving` counts from 1, and `cut < 2^{halving - 1}` within its step.
fn cut_normal(mut key: [u32; 8], path: u64, step: u64, halving: u32, cut: u64) -> f64 {
    // Below 2^82: step numbers are below 2^53.
    let number = (u128::from(step) << (halving - 1)) | u128::from(cut);
    key[4] |= (halving << 6) | (((number >> 64) as u32) << 11);
    let words = random::block(&key, path, number as u64);
    let [normal, _] = pair([words[0], words[1], words[2]]);
    normal
}

/// Increments that no two step sizes share: one standard normal for each step, drawn by its address `(seed, h, path, process, step)`, times
/// `√|h|`. [`Wiener`](super::Wiener) is the noise whose path is the same for every step size.
///
/// They are what [`Ensemble::seed`](crate::ensemble::Ensemble::seed) draws, and cost a small part of a Wiener path's increments: path `n` of an
/// ensemble of seed `s` is driven by `StepNormals::seed(s).path(n)`, bit for bit. A step that a [`Retry`](crate::path::retry::Retry) halves gets
/// the halves of its increment, by the Brownian bridge.
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
    /// The last block of each process.
    drawn: Vec<Drawn>,
}

#[derive(Clone, Copy, Debug)]
struct Drawn {
    block: u64,
    /// The bits of the step size.
    h: u64,
    normals: [f64; STEPS],
}

impl Drawn {
    /// Of a block that no step is in.
    const NOTHING: Self = Self { block: u64::MAX, h: 0, normals: [0.0; STEPS] };
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
            drawn: Vec::new(),
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

    truncation_setters!(|noise, truncation| Self { truncation, ..noise });

    /// The truncation that is set.
    pub fn truncation(&self) -> Truncation {
        self.truncation
    }

    /// With another truncation, if one is set.
    pub(crate) fn with_truncation(mut self, truncation: Truncation) -> Self {
        if truncation != Truncation::Unset {
            self.truncation = truncation;
        }
        self
    }

    /// Of a level of a multilevel run.
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

    /// The normal of a whole step of size `h`, before truncation.
    fn normal(&mut self, process: usize, h: f64, step: u64) -> f64 {
        if self.drawn.len() <= process {
            self.drawn.resize(process + 1, Drawn::NOTHING);
        }
        let block = step / STEPS as u64;
        let (key, stream, sign) = (self.key(process as u64, h), self.stream(), self.sign());
        let drawn = &mut self.drawn[process];
        if (drawn.block, drawn.h) != (block, h.to_bits()) {
            *drawn = Drawn { block, h: h.to_bits(), normals: normals(&random::block(&key, stream, block)) };
        }
        sign * drawn.normals[(step % STEPS as u64) as usize]
    }

    fn sign(&self) -> f64 {
        if self.is_antithetic && self.path % 2 == 1 { -1.0 } else { 1.0 }
    }

    /// The increment of part `part` of `2^halvings` of a step.
    fn part(&mut self, process: usize, h: f64, step: u64, halvings: u32, part: u64) -> f64 {
        let bound = self.clip(h);
        let mut dw = self.normal(process, h, step).clamp(-bound, bound) * h.abs().sqrt();
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
        for (process, dw) in dw.iter_mut().enumerate() {
            *dw = self.part(process, h, step, halvings, part);
        }
        Ok(())
    }

    /// Normals of their own, as for any other step size.
    fn increments_of_part(&mut self, interval: &Interval, h: f64, dw: &mut [f64]) -> Result<(), NoiseError> {
        check_step(h)?;
        self.truncation.check()?;
        let (block, place) = (interval.step / STEPS as u64, (interval.step % STEPS as u64) as usize);
        let (bound, scale) = (self.clip(h), self.sign() * h.abs().sqrt());
        for (process, dw) in dw.iter_mut().enumerate() {
            let drawn = normals(&random::block(&self.key(process as u64, h), self.stream(), block));
            *dw = scale * drawn[place].clamp(-bound, bound);
        }
        Ok(())
    }

    fn prepare(&mut self, plan: &Plan, h: f64, _processes: usize, _start: f64) -> Result<(), NoiseError> {
        self.truncates = plan.truncates_increments();
        self.truncation.check()?;
        check_step(h)?;
        self.h = Some(h);
        self.drawn.clear();
        Ok(())
    }

    fn largest_increment(&self, h: f64) -> f64 {
        self.acting().bound(h, h.abs().sqrt())
    }

    fn identity(&self) -> Option<Identity> {
        let identity = Identity::of("StepNormals").with("seed", self.seed).with("path", self.path);
        let identity =
            identity.with("antithetic", self.is_antithetic).with("step size", self.h.unwrap_or(f64::NAN));
        Some(identity.with("truncation", self.acting()))
    }
}

/// The halves of a step add up to the step.
impl Divisible for StepNormals {}

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

    /// The parts of a step add up to it: three roundings each.
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

    /// Parts have the variance of their length, and successive ones are not correlated, across the cuts too: 40 000 samples of each, whose
    /// mean squares and products are known to 1/√20 000 and 1/√40 000; five such deviations.
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

    /// Of one seed, the normals of steps of size `h` and `h/2` are not correlated: 10 000 products, five deviations of 1/100.
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

    #[test]
    fn what_is_no_half_of_a_step_is_refused() {
        let mut noise = prepared(StepNormals::seed(3), 0.1);
        for h in [0.03, 0.2, -0.1, 0.1 / f64::from(1_u32 << 31)] {
            let outcome = noise.increments(&Interval { start: 0.0, h, step: 0 }, &mut [0.0]);
            assert!(matches!(outcome, Err(NoiseError::Setting(_))), "{h}: {outcome:?}");
        }
        // Cuts of the last steps that can be counted have addresses of their own.
        let last = (1_u64 << 53) - 1;
        let cuts = [(last, 30, 0), (last, 30, 1), (last - 1, 30, 0), (last, 29, 0), (0, 30, 0), (0, 30, 1)];
        let normals = cuts.map(|(step, halving, cut)| cut_normal(key(1, 0, 0.1, 3), 0, step, halving, cut));
        for (i, x) in normals.iter().enumerate() {
            assert!(!normals[..i].contains(x));
        }
    }
}
