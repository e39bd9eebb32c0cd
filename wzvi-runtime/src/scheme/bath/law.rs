//! The exact law of the steps of a word in linear systems.

use super::letters::Letters;
use crate::algebra::scalar::Scalar;
use crate::scheme::word::{Part, Word};

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
        const { assert!(W::ORDER > 0 && W::O_PARTS > 0, "a word has one O at least") };
        let decay = W::DECAY.factor(gamma / W::O_PARTS as f64);
        let factor = if W::IS_SHORTENED { Scalar::tanh(0.5 * gamma) / (0.5 * gamma) } else { 1.0 }.sqrt();
        let linear = LinearStep { word: Word::spelled(W::LETTERS), decay, factor };
        let columns = [[1.0, 0.0], [0.0, 1.0]].map(|start| linear.step([omega, 0.0], start));
        let [[a, c], [b, d]] = columns;
        let [s_qq, s_qp, s_pp] = linear.covariance(omega);
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
        let all = Scalar::powi(decay, W::O_PARTS as i32);
        let diffusion = gamma * linear.diffusion();
        // Stationary momentum under a constant force: p = all p + gained.
        let [_, gained] = linear.step([0.0, 1.0], [0.0; 2]);
        let [moved, _] = linear.step([0.0, 1.0], [0.0, gained / (1.0 - all)]);
        Self { q, qp, p, diffusion, mobility: moved * gamma }
    }
}

/// The step of a linear system with `h = 1`.
struct LinearStep {
    word: Word,
    decay: f64,
    factor: f64,
}

impl LinearStep {
    /// Maps the mean `(√k q, p)` under a constant force, or `(q, p)` without a spring.
    fn step(&self, [omega, force]: [f64; 2], [mut q, mut p]: [f64; 2]) -> [f64; 2] {
        let unit = if omega == 0.0 { 1.0 } else { omega };
        for (part, weight) in self.parts() {
            match part {
                Part::A => q += weight * p * unit,
                Part::B => p += weight * (force - omega * q),
                _ => p *= self.decay,
            }
        }
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
        for (part, weight) in self.parts() {
            match part {
                Part::A => {
                    let w = weight * unit;
                    qq += w * (2.0 * qp + w * pp);
                    qp += w * pp;
                }
                Part::B => {
                    let w = weight * omega;
                    pp -= w * (2.0 * qp - w * qq);
                    qp -= w * qq;
                }
                _ => {
                    qp *= self.decay;
                    pp = self.decay * self.decay * pp + (1.0 - self.decay * self.decay);
                }
            }
        }
        [qq, qp, pp]
    }

    /// The parts of the step, `A`, `B` or `O`, with their durations.
    fn parts(&self) -> impl Iterator<Item = (Part, f64)> {
        self.word.substeps.iter().map(|substep| (substep.part, self.factor * substep.weight))
    }
}
