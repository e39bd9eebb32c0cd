//! Splittings as words of letters: `Splitting<(B, A, O, A, B)>`.
//!
//! A drift [`A`] is the flow of `T(p)`, a kick [`B`] that of `V(q, t)`, and an [`O`] part friction and noise
//! of the bath. Letters of one kind have equal shares of the step unless shares are given: `A<1, 4>` is a
//! drift over a quarter of it. O parts always have equal shares.
//!
//! A word is of order one because its shares add to one, and of order two if for each pair of different
//! letters `X`, `Y` the products of shares of an `X` before a `Y` add to one half, as they do in a palindrome
//! (E. Hairer, C. Lubich, G. Wanner, *Geometric Numerical Integration*, section III.5). With O parts order
//! two is the highest.

use super::splitting::Letters;
use crate::algebra::scalar::Scalar;
use crate::scheme::compose::stages::{Act, Stage};
use crate::scheme::compose::substeps::Half;

/// The most letters of a word.
const MOST: usize = 24;

/// A drift, the flow of `T(p)`, over the fraction `N / D` of the step, or an equal share if none is given.
#[derive(Clone, Copy, Debug)]
pub enum A<const N: u32 = 0, const D: u32 = 1> {}

/// A kick, the flow of `V(q, t)`, likewise.
#[derive(Clone, Copy, Debug)]
pub enum B<const N: u32 = 0, const D: u32 = 1> {}

/// Friction and noise of the bath, over an equal share of the step.
#[derive(Clone, Copy, Debug)]
pub enum O {}

/// The meaning of a letter; the numerator is zero if no share is given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Drift
    A(u32, u32),
    /// Kick
    B(u32, u32),
    /// Friction and noise
    O,
}

impl<const N: u32, const D: u32> Letters for A<N, D> {
    const LETTERS: &'static [Part] = &[Part::A(N, D)];
}
impl<const N: u32, const D: u32> Letters for B<N, D> {
    const LETTERS: &'static [Part] = &[Part::B(N, D)];
}
impl Letters for O {
    const LETTERS: &'static [Part] = &[Part::O];
}

/// The letter of a word of one.
const fn only(letters: &[Part]) -> Part {
    assert!(letters.len() == 1, "words are made of letters, not of words");
    letters[0]
}

macro_rules! words {
    ($first:ident $($letter:ident)*) => {
        impl<$first: Letters, $($letter: Letters),*> Letters for ($first, $($letter,)*) {
            const LETTERS: &'static [Part] = &[only($first::LETTERS), $(only($letter::LETTERS)),*];
        }
        words!($($letter)*);
    };
    () => {};
}

words!(L1 L2 L3 L4 L5 L6 L7 L8 L9 L10 L11 L12 L13 L14 L15 L16 L17 L18 L19 L20 L21 L22 L23 L24);

/// A word, prepared for steps.
#[derive(Clone, Copy, Debug)]
pub struct Spelling {
    stages: [Stage<Act>; MOST],
    count: usize,
    /// The number of O parts.
    pub(super) parts: usize,
    /// One or two.
    pub(super) order: u32,
}

impl Spelling {
    /// The letters.
    pub(super) const fn stages(&self) -> &[Stage<Act>] {
        self.stages.split_at(self.count).0
    }

    /// Prepares a word with at least one O part, whose drifts and whose kicks each add to one step.
    pub(super) const fn of(letters: &[Part]) -> Self {
        let unit = common_denominator(letters);
        let nothing = Stage::new(Half::First, 0.0, 0.0).with(Act::Flow(Half::First));
        let (order, count) = (order(letters, unit), letters.len());
        let mut spelling = Self { stages: [nothing; MOST], count, parts: 0, order };
        let (mut drifted, mut i) = (0, 0);
        while i < count {
            let share = share(letters, i, unit);
            let (weight, node) = (share as f64 / unit as f64, drifted as f64 / unit as f64);
            let (half, act) = match letters[i] {
                Part::O => {
                    spelling.parts += 1;
                    (Half::First, Act::Relax(spelling.parts - 1))
                }
                Part::A(..) => {
                    drifted += share;
                    (Half::First, Act::Flow(Half::First))
                }
                Part::B(..) => (Half::Second, Act::Flow(Half::Second)),
            };
            spelling.stages[i] = Stage::new(half, weight, node).with(act);
            i += 1;
        }
        assert!(spelling.parts > 0, "a word has one O at least");
        spelling
    }
}

/// Merges an O part with the drifts of equal weight on both sides of it, if there is exactly one such place.
pub(super) fn joined(stages: &[Stage<Act>]) -> Vec<Stage<Act>> {
    let between = |around: &[Stage<Act>]| match around {
        [before, Stage { act: Act::Relax(part), .. }, after] => {
            let are_drifts = [before, after].iter().all(|stage| stage.act == Act::Flow(Half::First));
            (are_drifts && before.weight == after.weight).then(|| before.with(Act::RelaxBetween(*part)))
        }
        _ => None,
    };
    let mut places =
        stages.windows(3).enumerate().filter_map(|(first, around)| Some((first, between(around)?)));
    match (places.next(), places.next()) {
        (Some((first, joined)), None) => [&stages[..first], &[joined], &stages[first + 3..]].concat(),
        _ => stages.to_vec(),
    }
}

/// The kind of a letter, 0 to 2.
const fn kind(part: Part) -> usize {
    match part {
        Part::A(..) => 0,
        Part::B(..) => 1,
        Part::O => 2,
    }
}

const fn count(letters: &[Part], of: usize) -> u64 {
    let (mut count, mut i) = (0, 0);
    while i < letters.len() {
        count += (kind(letters[i]) == of) as u64;
        i += 1;
    }
    count
}

/// Numerator and denominator of the share of letter `i`.
const fn fraction(letters: &[Part], i: usize) -> (u64, u64) {
    match letters[i] {
        Part::A(n, d) | Part::B(n, d) if n != 0 => (n as u64, d as u64),
        part => (1, count(letters, kind(part))),
    }
}

const fn gcd(mut a: u64, mut b: u64) -> u64 {
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}

/// The common denominator of all shares.
const fn common_denominator(letters: &[Part]) -> u64 {
    let (mut unit, mut i) = (1_u64, 0);
    while i < letters.len() {
        let (_, denominator) = fraction(letters, i);
        assert!(denominator != 0, "a share is a fraction");
        let factor = denominator / gcd(unit, denominator);
        assert!(
            unit <= u32::MAX as u64 / factor,
            "the shares of a word have a common denominator below 2^32"
        );
        unit *= factor;
        i += 1;
    }
    unit
}

const fn share(letters: &[Part], i: usize, unit: u64) -> u64 {
    let (numerator, denominator) = fraction(letters, i);
    numerator * (unit / denominator)
}

/// Two if, for each pair of different letters, the products of their shares add to one half; else one.
const fn order(letters: &[Part], unit: u64) -> u32 {
    let (mut sums, mut products, mut j) = ([0_u128; 3], [[0_u128; 3]; 3], 0);
    while j < letters.len() {
        let (of, share) = (kind(letters[j]), share(letters, j, unit) as u128);
        let mut before = 0;
        while before < 3 {
            products[before][of] += sums[before] * share;
            before += 1;
        }
        sums[of] += share;
        j += 1;
    }
    let whole = unit as u128;
    assert!(sums[0] == whole, "the shares of the drifts add to one");
    assert!(sums[1] == whole, "the shares of the kicks add to one");
    let (mut order, mut pair) = (2, 0);
    while pair < 9 {
        let (x, y) = (pair / 3, pair % 3);
        if x != y && 2 * products[x][y] != sums[x] * sums[y] {
            order = 1;
        }
        pair += 1;
    }
    order
}

/// The exact law of the steps of a word in a linear system with one rate of friction, in units of mass,
/// temperature and time in which `m = kT = 1`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HarmonicLaw {
    /// `k <q²>`, one in the Gibbs measure.
    pub q: f64,
    /// `√k <q p>`, zero there.
    pub qp: f64,
    /// `<p²>`, one there.
    pub p: f64,
    /// Diffusion of a free particle, relative to the exact `kT/(m γ)`.
    pub diffusion: f64,
    /// Mean velocity under a constant force, relative to the exact one.
    pub mobility: f64,
}

impl HarmonicLaw {
    /// The law of steps with `√(k/m) h = omega` and `γ h = gamma`; NaN where the word is not stable or there
    /// is no friction.
    ///
    /// ```ignore
    /// use wzvi::bath::HarmonicLaw;
    /// use wzvi::embedding::Baoab;
    ///
    /// let law = HarmonicLaw::of::<Baoab>(0.5, 0.1);
    /// assert!((law.q - 1.0).abs() < 1e-14 && (law.p - (1.0 - 0.25 * 0.5 * 0.5)).abs() < 1e-14);
    /// ```
    pub fn of<W: Letters>(omega: f64, gamma: f64) -> Self {
        let spelling = W::SPELLING;
        let decay = W::DECAY.factor(gamma / spelling.parts as f64);
        let factor = if W::IS_SHORTENED { Scalar::tanh(0.5 * gamma) / (0.5 * gamma) } else { 1.0 }.sqrt();
        let letters = LinearStep { spelling, decay, factor };
        let columns = [[1.0, 0.0], [0.0, 1.0]].map(|start| letters.step([omega, 0.0], start));
        let [[a, c], [b, d]] = columns;
        let [s_qq, s_qp, s_pp] = letters.covariance(omega);
        // X = M X Mᵀ + S.
        let matrix = nalgebra::Matrix3::new(
            1.0 - a * a,
            -2.0 * a * b,
            -b * b,
            -a * c,
            1.0 - a * d - b * c,
            -b * d,
            -c * c,
            -2.0 * c * d,
            1.0 - d * d,
        );
        let law = matrix.lu().solve(&nalgebra::Vector3::new(s_qq, s_qp, s_pp));
        let is_stable = (a + d).abs() < 1.0 + (a * d - b * c) && (a * d - b * c).abs() < 1.0;
        let [q, qp, p] = law.filter(|_| is_stable).map_or([f64::NAN; 3], Into::into);
        let all = Scalar::powi(decay, spelling.parts as i32);
        let diffusion = gamma * letters.diffusion();
        // Stationary momentum under a constant force: p = all p + gained.
        let [_, gained] = letters.step([0.0, 1.0], [0.0; 2]);
        let [moved, _] = letters.step([0.0, 1.0], [0.0, gained / (1.0 - all)]);
        Self { q, qp, p, diffusion, mobility: moved * gamma }
    }
}

/// The step of a linear system with `h = 1`.
struct LinearStep<'s> {
    spelling: &'s Spelling,
    decay: f64,
    factor: f64,
}

impl LinearStep<'_> {
    /// Maps the mean `(√k q, p)` under a constant force, or `(q, p)` without a spring.
    fn step(&self, [omega, force]: [f64; 2], [mut q, mut p]: [f64; 2]) -> [f64; 2] {
        let unit = if omega == 0.0 { 1.0 } else { omega };
        self.each(|weight| match weight {
            Some((Half::First, weight)) => q += weight * p * unit,
            Some((Half::Second, weight)) => p += weight * (force - omega * q),
            None => p *= self.decay,
        });
        [q, p]
    }

    /// `D` of a free particle: half of `<Δq²> + 2 Σ_k <Δq Δq_k>` over all later steps, where `<Δq p_k>`
    /// decays as `p` does.
    fn diffusion(&self) -> f64 {
        let [way, decay] = self.step([0.0; 2], [0.0, 1.0]);
        let [s_qq, s_qp, _] = self.covariance(0.0);
        0.5 * (way * way + s_qq) + way * (way * decay + s_qp) / (1.0 - decay)
    }

    /// The contribution of the noise of the O parts to `<q²>`, `<q p>`, `<p²>` in the units of
    /// [`LinearStep::step`].
    fn covariance(&self, omega: f64) -> [f64; 3] {
        let unit = if omega == 0.0 { 1.0 } else { omega };
        let [mut qq, mut qp, mut pp] = [0.0; 3];
        self.each(|weight| match weight {
            Some((Half::First, weight)) => {
                let w = weight * unit;
                qq += w * (2.0 * qp + w * pp);
                qp += w * pp;
            }
            Some((Half::Second, weight)) => {
                let w = weight * omega;
                pp -= w * (2.0 * qp - w * qq);
                qp -= w * qq;
            }
            None => {
                qp *= self.decay;
                pp = self.decay * self.decay * pp + (1.0 - self.decay * self.decay);
            }
        });
        [qq, qp, pp]
    }

    /// Visits all letters: flows with their durations, and O parts (`None`).
    fn each(&self, mut take: impl FnMut(Option<(Half, f64)>)) {
        for stage in self.spelling.stages() {
            take(stage.act.half().map(|half| (half, self.factor * stage.weight)));
        }
    }
}
