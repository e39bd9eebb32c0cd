//! The polynomial through both nodes of a step with their rates, and, for schemes of high order, with rates
//! between them.
//!
//! With the rates `f_i` at the `n` Lobatto points `x_i` of the step, weights `w_i`, and
//! `δ = z_1 - z_0 - Σ w_i f_i`,
//!
//! ```text
//! u'(θ) = Σ_{k<n} a_k P_k(2θ - 1) + 6θ(1 - θ) δ,   a_k = (2k + 1) Σ w_i P_k(2x_i - 1) f_i,   a_{n-1} = (n - 1) Σ w_i P_{n-1}(2x_i - 1) f_i
//! ```
//!
//! interpolates the rates (at inner points up to the term with `δ`), connects the nodes, and has the rates of
//! the nodes at its ends. For `n = 2` it is Hermite's cubic, with an error of order 4; with `n` points and
//! rates evaluated on a polynomial of order `n` it has order `n + 1`.

use super::slopes::{NodeWeights, RateCoefficients, legendre, weights};
use crate::algebra::scalar::Scalar;
use crate::algebra::state::{State, Vector, copy_state};
use crate::scheme::constraints::ManifoldPoint;
use crate::scheme::system::{Gradient, Hamiltonian};

/// The Lobatto points of a step, and the projection of the rates there to coefficients.
#[derive(Clone, Debug)]
struct LobattoNodes {
    x: Vec<f64>,
    /// The weights at these points of the polynomial of the level before.
    weights: Vec<NodeWeights>,
    /// By `k` and point.
    projection: Vec<Vec<f64>>,
}

impl LobattoNodes {
    fn new(n: usize) -> Self {
        let top = (n - 1) as f64;
        let mut list = vec![0.0; n];
        let y: Vec<f64> = (0..n).map(|i| lobatto(n, i, &mut list)).collect();
        let mut at = |y: f64| {
            legendre(y, &mut list);
            list.clone()
        };
        let values: Vec<Vec<f64>> = y.iter().map(|&y| at(y)).collect();
        let weight = |values: &[f64]| 1.0 / (n as f64 * top * values[n - 1] * values[n - 1]);
        let norm = |k: usize| if k + 1 == n { top } else { 2.0 * k as f64 + 1.0 };
        let row =
            |k: usize| values.iter().map(|values| norm(k) * weight(values) * values[k]).collect::<Vec<_>>();
        let x: Vec<f64> = y.iter().map(|y| 0.5 * (y + 1.0)).collect();
        let weights = x.iter().map(|&x| weights(x, x, n.max(3))).collect();
        Self { x, weights, projection: (0..n).map(row).collect() }
    }
}

/// Root number `i` of `(1 - y²) P_{n-1}'(y)`, from the smallest, by Newton's method.
fn lobatto(n: usize, i: usize, list: &mut [f64]) -> f64 {
    if i == 0 || i + 1 == n {
        return if i == 0 { -1.0 } else { 1.0 };
    }
    let top = (n - 1) as f64;
    let mut y = -Scalar::cos(std::f64::consts::PI * i as f64 / top);
    for _ in 0..20 {
        legendre(y, list);
        // `(1 - y²) P'` and its slope, `-n(n + 1) P`.
        let value = top * (list[n - 2] - y * list[n - 1]);
        y += value / (top * (top + 1.0) * list[n - 1]);
    }
    y
}

/// The points of a run, and scratch.
#[derive(Clone, Debug)]
pub(super) struct Hermite<V> {
    /// The points of each level: both ends, then 4, 5, ... points up to the order.
    levels: Vec<LobattoNodes>,
    /// Rates at the points.
    rates: Vec<Vec<f64>>,
    /// One gradient.
    gradient: Gradient<V>,
    /// The state at which a rate is evaluated.
    inside: State<V>,
}

impl<V: Vector> Hermite<V> {
    pub(super) fn of(state: &State<V>) -> Self {
        Self {
            levels: Vec::new(),
            rates: Vec::new(),
            gradient: Gradient { q: state.q.clone(), p: state.p.clone() },
            inside: state.clone(),
        }
    }

    /// Prepares for a polynomial of this order. Allocates in the first step only.
    fn fit(&mut self, order: u32, degrees: usize) {
        let levels = 1 + (order as usize).saturating_sub(4);
        if self.levels.len() != levels {
            self.levels =
                (0..levels).map(|level| LobattoNodes::new(if level == 0 { 2 } else { level + 3 })).collect();
        }
        let most = self.levels.last().map_or(0, |points| points.x.len());
        self.rates.resize_with(most, Vec::new);
        self.rates.iter_mut().for_each(|rates| rates.resize(2 * degrees, 0.0));
    }

    /// The derivatives of a step. If it `follows` the last one, its initial rate is the final rate of the
    /// last one.
    #[expect(clippy::too_many_arguments, reason = "each is one thing that a step is of")]
    pub(super) fn fill<H: Hamiltonian<Vector = V>>(
        &mut self,
        system: &H,
        ends: &[State<V>; 2],
        h: f64,
        dw: &[f64],
        follows: bool,
        order: u32,
        slopes: &mut RateCoefficients,
    ) {
        let degrees = ends[0].q.components().len();
        self.fit(order, degrees);
        let Self { levels, rates, gradient, inside } = self;
        let most = rates.len();
        if follows {
            rates.swap(0, most - 1);
        } else {
            rate(system, &ends[0], h, dw, gradient, &mut rates[0]);
        }
        rate(system, &ends[1], h, dw, gradient, &mut rates[most - 1]);
        for (level, points) in levels.iter().enumerate() {
            let n = points.x.len();
            if level > 0 {
                let points = points.x.iter().zip(&points.weights).take(n - 1);
                for ((x, weights), rates) in points.zip(&mut *rates).skip(1) {
                    copy_state(inside, &ends[0]);
                    inside.t += x * h;
                    slopes.add(weights, [inside.q.components_mut(), inside.p.components_mut()]);
                    rate(system, inside, h, dw, gradient, rates);
                }
            }
            project(points, rates, ends, slopes);
        }
    }
}

/// The coefficients from the rates at the points, in order, with the rate at the end last in `rates`.
fn project<V: Vector>(
    points: &LobattoNodes,
    rates: &[Vec<f64>],
    ends: &[State<V>; 2],
    slopes: &mut RateCoefficients,
) {
    let (n, degrees) = (points.x.len(), ends[0].q.components().len());
    slopes.resize(n.max(3), degrees);
    let [start, end] = ends.each_ref().map(|state| state.q.components().iter().chain(state.p.components()));
    let last = &rates[rates.len() - 1];
    for (c, (start, end)) in start.zip(end).enumerate() {
        let of = slopes.of_mut(c);
        of.fill(0.0);
        for (a, factors) in of.iter_mut().zip(&points.projection) {
            let inner = factors.iter().zip(&rates[..n - 1]).map(|(factor, rates)| factor * rates[c]);
            *a = inner.sum::<f64>() + factors[n - 1] * last[c];
        }
        let rest = (end - start) - of[0];
        of[0] += rest;
        of[2] -= rest;
    }
}

/// `du/dθ = J∇F` at a state, plus forces, friction and constraints.
fn rate<H: Hamiltonian>(
    system: &H,
    at: &State<H::Vector>,
    h: f64,
    dw: &[f64],
    gradient: &mut Gradient<H::Vector>,
    into: &mut [f64],
) {
    into.fill(0.0);
    let (q, p) = (at.q.components(), at.p.components());
    let (of_q, of_p) = into.split_at_mut(q.len());
    let mut add = |factor: f64, Gradient { q: by_q, p: by_p }: &Gradient<H::Vector>| {
        of_q.iter_mut().zip(by_p.components()).for_each(|(rate, slope)| *rate += factor * slope);
        of_p.iter_mut().zip(by_q.components()).for_each(|(rate, slope)| *rate -= factor * slope);
    };
    let [by_q, by_p] = [&mut gradient.q, &mut gradient.p].map(Vector::components_mut);
    system.differentiate(0, q, p, at.t, by_q, by_p);
    add(h, gradient);
    if !dw.is_empty() {
        system.differentiate_noises(dw, at, gradient);
        add(1.0, gradient);
    }
    let force = gradient.q.components_mut();
    system.force(q, p, at.t, force);
    of_p.iter_mut().zip(&*force).for_each(|(rate, force)| *rate += h * force);
    if H::KIND.is_conformal {
        let gamma = system.friction_rate();
        of_p.iter_mut().zip(p).for_each(|(rate, p)| *rate -= h * gamma * p);
    }
    if let Some(manifold) = system.manifold() {
        manifold.constrain_rates(ManifoldPoint { q, p, t: at.t }, of_q, of_p, h);
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::SVector;

    use super::*;
    use crate::algebra::scalar::Scalar;

    type V1 = SVector<f64, 1>;

    /// `H = (q² + p²)²/4`: the angular velocity is the square of the radius.
    struct Whirl;

    impl Hamiltonian for Whirl {
        type Vector = V1;
        fn degrees(&self) -> usize {
            1
        }
        fn evaluate<S: Scalar>(&self, _: usize, q: &[S], p: &[S], _: f64) -> S {
            let square = q[0] * q[0] + p[0] * p[0];
            square * square * 0.25
        }
        fn differentiate<S: Scalar>(&self, _: usize, q: &[S], p: &[S], _: f64, dq: &mut [S], dp: &mut [S]) {
            let square = q[0] * q[0] + p[0] * p[0];
            (dq[0], dp[0]) = (square * q[0], square * p[0]);
        }
    }

    const RADIUS: f64 = 1.2;

    fn exact(t: f64) -> State<V1> {
        let (sin, cos) = (RADIUS * RADIUS * t + 0.3).sin_cos();
        State::new([RADIUS * sin], [RADIUS * cos]).at(t)
    }

    /// The largest error inside a step between exact nodes.
    fn error(order: u32, h: f64) -> f64 {
        let ends = [exact(0.0), exact(h)];
        let (mut hermite, mut slopes) = (Hermite::of(&ends[0]), RateCoefficients::default());
        hermite.fill(&Whirl, &ends, h, &[], false, order, &mut slopes);
        let at = |i: u32| {
            let theta = f64::from(i) / 64.0;
            let mut state = ends[0];
            slopes.add(
                &weights(theta, theta, slopes.rows()),
                [state.q.components_mut(), state.p.components_mut()],
            );
            let right = exact(theta * h);
            (state.q - right.q).norm().max((state.p - right.p).norm())
        };
        (0..=64).map(at).fold(0.0, f64::max)
    }

    #[test]
    fn polynomials_have_the_order_that_they_say() {
        for (order, h) in [(4, 0.05), (5, 0.1), (6, 0.1), (7, 0.15), (8, 0.2), (9, 0.2)] {
            let [coarse, fine] = [h, h / 2.0].map(|h| error(order, h));
            let measured = (coarse / fine).log2();

            assert!((measured - f64::from(order)).abs() < 0.35, "{order}: {measured}, {fine:e}");
        }
    }

    /// The polynomial has the rates of the field at both nodes.
    #[test]
    fn neighbouring_steps_join_smoothly() {
        let ends = [exact(0.0), exact(0.3)];
        for order in 4..=9 {
            let (mut hermite, mut slopes) = (Hermite::of(&ends[0]), RateCoefficients::default());
            hermite.fill(&Whirl, &ends, 0.3, &[], false, order, &mut slopes);
            for (end, state) in ends.iter().enumerate() {
                let [q, p] = [state.p[0], -state.q[0]].map(|x| x * RADIUS * RADIUS * 0.3);
                let sign = |k: usize| if end == 0 && k % 2 == 1 { -1.0 } else { 1.0 };
                let rate =
                    |i: usize| (0..slopes.rows()).map(|k| sign(k) * slopes.clone().of_mut(i)[k]).sum::<f64>();
                assert!((rate(0) - q).abs() < 1e-13 && (rate(1) - p).abs() < 1e-13, "{order} {end}");
            }
        }
    }
}
