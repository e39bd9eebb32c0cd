//! The slope of a path inside a step, by Legendre polynomials.
//!
//! `u'(θ) = Σ_k a_k P_k(2θ - 1)`, and the path is its integral:
//! `∫_0^θ P_k(2x - 1) dx = -2θ(1 - θ) P_k'(2θ - 1) / (k(k + 1))` for `k ≥ 1`, which vanishes at both ends.

/// The most coefficients of a component: those of `Gauss<16>` in its Nyström form.
const MOST_ROWS: usize = 17;

/// The factors of the coefficients of a component in its change from a node.
pub(crate) type NodeWeights = [f64; MOST_ROWS];

/// The coefficients `a_k` of `du/dθ` for every coordinate and momentum.
#[derive(Clone, Debug, Default)]
pub struct RateCoefficients {
    degrees: usize,
    rows: usize,
    /// The coefficients of the coordinates, then of the momenta; those of one component are contiguous.
    coefficients: Vec<f64>,
    /// Three scratch lists of one number per degree of freedom.
    room: [Vec<f64>; 3],
    /// The projection of derivatives at the nodes of the scheme to coefficients.
    projection: Vec<f64>,
}

impl RateCoefficients {
    /// Resizes to `rows` coefficients, at most 17, and this number of degrees of freedom. Allocates only to
    /// grow.
    pub(crate) fn resize(&mut self, rows: usize, degrees: usize) {
        debug_assert!(rows <= MOST_ROWS, "a polynomial has as many coefficients as there is room for");
        (self.rows, self.degrees) = (rows.min(MOST_ROWS), degrees);
        self.coefficients.resize(self.rows * 2 * degrees, 0.0);
        self.room.iter_mut().for_each(|room| room.resize(degrees, 0.0));
    }

    pub(crate) fn rows(&self) -> usize {
        self.rows
    }

    /// The coefficients of a component: a coordinate, or a momentum from the number of degrees of freedom on.
    #[inline]
    pub(crate) fn of_mut(&mut self, component: usize) -> &mut [f64] {
        &mut self.coefficients[component * self.rows..(component + 1) * self.rows]
    }

    /// Lends the three scratch lists, to be given back.
    pub(crate) fn take_room(&mut self) -> [Vec<f64>; 3] {
        std::mem::take(&mut self.room)
    }

    pub(crate) fn give_back(&mut self, room: [Vec<f64>; 3]) {
        self.room = room;
    }

    /// Adds `u(θ) - u(0)` to coordinates and momenta if `weights` are from the start of the step, or
    /// `u(θ) - u(1)` if they are from its end.
    #[inline]
    pub(crate) fn add(&self, weights: &NodeWeights, [q, p]: [&mut [f64]; 2]) {
        let slopes = self.coefficients.chunks_exact(self.rows.max(1));
        for (x, slopes) in q.iter_mut().chain(p).zip(slopes) {
            *x += slopes.iter().zip(weights).map(|(slope, weight)| slope * weight).sum::<f64>();
        }
    }

    /// `(2k + 1) P_k(2c_i - 1)` by `k` and node, row by row: computed once for the nodes of a scheme.
    pub(crate) fn projection(&mut self, nodes: &[f64]) -> Vec<f64> {
        let n = nodes.len();
        if self.projection.len() != n * n {
            self.projection.resize(n * n, 0.0);
            let mut values = vec![0.0; n];
            for (i, c) in nodes.iter().enumerate() {
                legendre(2.0 * c - 1.0, &mut values);
                for (k, value) in values.iter().enumerate() {
                    self.projection[k * n + i] = (2.0 * k as f64 + 1.0) * value;
                }
            }
        }
        std::mem::take(&mut self.projection)
    }

    /// Takes the projection back.
    pub(crate) fn keep_projection(&mut self, projection: Vec<f64>) {
        self.projection = projection;
    }
}

/// `part`, then `∫_0^θ P_k(2x - 1) dx` for `1 ≤ k < rows`: `part` is `θ` from the start of a step, and
/// `θ - 1` from its end.
pub(crate) fn weights(theta: f64, part: f64, rows: usize) -> NodeWeights {
    let y = 2.0 * theta - 1.0;
    let mut weights = [0.0; MOST_ROWS];
    weights[0] = part;
    // `P_k` and `P_k'`, and those for `k - 1`.
    let (mut before, mut now) = ([1.0, 0.0], [y, 1.0]);
    for (k, weight) in weights.iter_mut().enumerate().take(rows).skip(1) {
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

    /// The integrals have the polynomials as derivatives, and are exact at both ends.
    #[test]
    fn integrals_are_those_of_the_polynomials() {
        for theta in [0.0, 0.03, 0.31, 0.5, 0.77, 1.0] {
            let mut polynomials = [0.0; MOST_ROWS];
            legendre(2.0 * theta - 1.0, &mut polynomials);
            let step = 1e-5;
            let [low, high] = [theta - step, theta + step].map(|theta| weights(theta, theta, MOST_ROWS));
            for k in 0..MOST_ROWS {
                let slope = (high[k] - low[k]) / (2.0 * step);
                // Central differences: h²/6 P_k'', below k^4 h² / 6.
                assert!((slope - polynomials[k]).abs() < 4e-6 * polynomials[k].abs().max(1.0), "{theta} {k}");
            }
        }
        assert_eq!(weights(0.0, 0.0, MOST_ROWS), [0.0; MOST_ROWS]);
        assert_eq!(weights(1.0, 0.0, MOST_ROWS), [0.0; MOST_ROWS]);
    }
}
