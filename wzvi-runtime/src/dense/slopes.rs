//! The slope of a path inside a step, by Legendre polynomials.
//!
//! `u'(θ) = Σ_k a_k P_k(2θ - 1)`, and the path is its integral: `∫_0^θ P_k(2x - 1) dx = -2θ(1 - θ) P_k'(2θ - 1) / (k(k + 1))` for `k ≥ 1`, which
//! vanishes at both ends.

/// The most coefficients of a component: those of `Gauss<16>` in its Nyström form.
const MOST_ROWS: usize = 17;

/// The coefficients `a_k` of `du/dθ` for every coordinate and momentum.
#[derive(Clone, Debug, Default)]
pub struct Slopes {
    degrees: usize,
    rows: usize,
    /// By `k`: those of the coordinates, then those of the momenta.
    coefficients: Vec<f64>,
    /// Room for two lists of one number per degree of freedom.
    room: [Vec<f64>; 2],
}

impl Slopes {
    /// Makes room for `rows` coefficients, 17 at most, of so many degrees of freedom. Allocates only if there are more than before.
    pub(crate) fn resize(&mut self, rows: usize, degrees: usize) {
        debug_assert!(rows <= MOST_ROWS, "a polynomial has as many coefficients as there is room for");
        (self.rows, self.degrees) = (rows.min(MOST_ROWS), degrees);
        self.coefficients.resize(self.rows * 2 * degrees, 0.0);
        self.room.iter_mut().for_each(|room| room.resize(degrees, 0.0));
    }

    pub(crate) fn rows(&self) -> usize {
        self.rows
    }

    /// `a_k` of all coordinates and momenta.
    pub(crate) fn row_mut(&mut self, k: usize) -> &mut [f64] {
        let width = 2 * self.degrees;
        &mut self.coefficients[k * width..(k + 1) * width]
    }

    /// Room for two lists of one number per degree of freedom, to give back.
    pub(crate) fn take_room(&mut self) -> [Vec<f64>; 2] {
        std::mem::take(&mut self.room)
    }

    pub(crate) fn give_back(&mut self, room: [Vec<f64>; 2]) {
        self.room = room;
    }

    /// Adds `u(θ) - u(0)` to coordinates and momenta where `part` is `θ`, and `u(θ) - u(1)` where it is `θ - 1`.
    pub(crate) fn add(&self, theta: f64, part: f64, [q, p]: [&mut [f64]; 2]) {
        let weights = weights(theta, part);
        for (row, weight) in self.coefficients.chunks_exact((2 * self.degrees).max(1)).zip(weights) {
            let (by_q, by_p) = row.split_at(self.degrees);
            for (x, slope) in q.iter_mut().chain(&mut *p).zip(by_q.iter().chain(by_p)) {
                *x += weight * slope;
            }
        }
    }
}

/// `part`, then `∫_0^θ P_k(2x - 1) dx` for `k ≥ 1`.
fn weights(theta: f64, part: f64) -> [f64; MOST_ROWS] {
    let y = 2.0 * theta - 1.0;
    let mut weights = [0.0; MOST_ROWS];
    weights[0] = part;
    // `P_k` and `P_k'`, and those before.
    let (mut before, mut now) = ([1.0, 0.0], [y, 1.0]);
    for (k, weight) in weights.iter_mut().enumerate().skip(1) {
        let n = k as f64;
        *weight = -2.0 * theta * (1.0 - theta) * now[1] / (n * (n + 1.0));
        let next = ((2.0 * n + 1.0) * y * now[0] - n * before[0]) / (n + 1.0);
        (before, now) = (now, [next, before[1] + (2.0 * n + 1.0) * now[0]]);
    }
    weights
}

/// `P_0(y) ... P_{N-1}(y)`
pub(crate) fn legendre(y: f64, into: &mut [f64]) {
    let (mut before, mut now) = (0.0, 1.0);
    for (k, p) in into.iter_mut().enumerate() {
        *p = now;
        let n = k as f64;
        (before, now) = (now, ((2.0 * n + 1.0) * y * now - n * before) / (n + 1.0));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `d/dθ` of the integrals are the polynomials, and both ends are exact.
    #[test]
    fn integrals_are_those_of_the_polynomials() {
        for theta in [0.0, 0.03, 0.31, 0.5, 0.77, 1.0] {
            let mut polynomials = [0.0; MOST_ROWS];
            legendre(2.0 * theta - 1.0, &mut polynomials);
            let step = 1e-5;
            let [low, high] = [theta - step, theta + step].map(|theta| weights(theta, theta));
            for k in 0..MOST_ROWS {
                let slope = (high[k] - low[k]) / (2.0 * step);
                // Central differences: h²/6 P_k'', below k^4 h² / 6.
                assert!((slope - polynomials[k]).abs() < 4e-6 * polynomials[k].abs().max(1.0), "{theta} {k}");
            }
        }
        assert_eq!(weights(0.0, 0.0), [0.0; MOST_ROWS]);
        assert_eq!(weights(1.0, 0.0), [0.0; MOST_ROWS]);
    }
}
