//! How the energy of a weakly driven oscillator spreads: first passages of the averaged equation.
//!
//! `H0 = p²/2 + V(q)` with additive noise in the momentum, `H1 = -s q`, has `dH = s²/2 dt + s p dW`. If the noise is weak, many
//! oscillations pass before the energy changes, and `p²` acts through its mean over one of them, `J/J'` with the action
//! `J(E) = ∮ p dq` and the period `J'(E)`. The probability `S` not to have reached the energy `B` by the time `t`, from energy
//! `E`, then follows
//!
//! ```text
//! ∂S/∂t = (s²/2) (1/J') ∂/∂E ( J ∂S/∂E ),    S = 0 at E = B,    S = 1 at t = 0,
//! ```
//!
//! (R. L. Stratonovich, "Topics in the Theory of Random Noise" I, 1963; H. A. Kramers, Physica 7 (1940) 284, for weak friction). In
//! units of `2B/s²`, which is the mean time from the bottom, no parameter is left.

/// One well of a potential, up to its barrier.
pub(crate) struct Well<V> {
    pub(crate) potential: V,
    /// Where the potential is least; it is zero there.
    pub(crate) bottom: f64,
    /// Where it is no longer below the barrier, on both sides.
    pub(crate) ends: [f64; 2],
    /// The energy of the barrier.
    pub(crate) barrier: f64,
}

impl<V: Fn(f64) -> f64> Well<V> {
    /// Where the potential has an energy on the way from the bottom to one of the ends.
    fn turning_point(&self, energy: f64, end: f64) -> f64 {
        let (mut low, mut high) = (self.bottom, end);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if (self.potential)(middle) < energy { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    }

    /// `∮ |p|^n dq` at an energy: the middle rule in the angle `φ` of `q = m + r sin φ`, which makes the turning points smooth.
    pub(crate) fn integral(&self, n: i32, energy: f64) -> f64 {
        let [left, right] = self.ends.map(|end| self.turning_point(energy, end));
        let (middle, radius, points) = (0.5 * (left + right), 0.5 * (right - left), 2000);
        let width = std::f64::consts::PI / f64::from(points);
        let value = |i: i32| {
            let angle = (f64::from(i) + 0.5) * width - std::f64::consts::FRAC_PI_2;
            let kinetic = energy - (self.potential)(middle + radius * angle.sin());
            (2.0 * kinetic.max(0.0)).sqrt().powi(n) * radius * angle.cos()
        };
        2.0 * width * (0..points).map(value).sum::<f64>()
    }

    /// The probability not to have reached the barrier from the bottom, at `times` (each `2B/s²`), in steps of a
    /// thousandth: finite volumes in the energy, Euler's implicit rule in time.
    pub(crate) fn survival(&self, times: f64) -> Vec<(f64, f64)> {
        const CELLS: usize = 400;
        const STEPS_PER_UNIT: f64 = 1000.0;
        let width = 1.0 / CELLS as f64;
        let edge = |i: usize| self.barrier * i as f64 * width;
        let action: Vec<f64> =
            (0..=CELLS).map(|i| if i == 0 { 0.0 } else { self.integral(1, edge(i)) }).collect();
        // With E in units of B and t in units of 2B/s²: ∂S/∂t = (1/J') ∂/∂E ( J ∂S/∂E ).
        let step = 1.0 / STEPS_PER_UNIT;
        let mut survival = vec![1.0; CELLS];
        let mut curve = vec![(0.0, 1.0)];
        for n in 1..=(times * STEPS_PER_UNIT).round() as usize {
            solve(&action, step / width, &mut survival);
            curve.push((n as f64 * step, survival[0]));
        }
        curve
    }
}

/// One implicit step: elimination from the bottom up, then back.
fn solve(action: &[f64], ratio: f64, survival: &mut [f64]) {
    let cells = survival.len();
    let mut factors = vec![0.0; cells];
    for i in 0..cells {
        let below = action[i] * ratio;
        // Half a cell from the last middle to the barrier, where nobody survives.
        let above = action[i + 1] * ratio * if i + 1 == cells { 2.0 } else { 1.0 };
        let weight = action[i + 1] - action[i];
        let (factor, value) = if i == 0 { (0.0, 0.0) } else { (factors[i - 1], survival[i - 1]) };
        let pivot = weight + above + below * (1.0 - factor);
        survival[i] = (weight * survival[i] + below * value) / pivot;
        factors[i] = if i + 1 == cells { 0.0 } else { above / pivot };
    }
    for i in (0..cells - 1).rev() {
        survival[i] += factors[i] * survival[i + 1];
    }
}
