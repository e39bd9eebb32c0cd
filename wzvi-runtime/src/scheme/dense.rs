//! Dense output: the path between the nodes of a step.
//!
//! A step leads from `z_0 = (q, p)` at `t` to `z_1` at `t + h`. At `t + θh`, `0 ≤ θ ≤ 1`, the path is a
//! polynomial `u(θ)` with `u(0) = z_0` and `u(1) = z_1`, both to the last bit:
//!
//! * [`Gauss<S>`](crate::scheme::gauss::Gauss) with two stages or more: the collocation polynomial
//!   `u'(c_i) = J∇F(U_i)` of its stages, of degree `S` (E. Hairer, C. Lubich, G. Wanner, *Geometric Numerical
//!   Integration*, section II.1.2). It costs no evaluation.
//! * all other schemes: the cubic with the rates `u'(0) = J∇F(z_0)` and `u'(1) = J∇F(z_1)` (Hermite), one
//!   gradient per step. Where the order of the scheme is 4 or more, the rates at the inner Lobatto points are
//!   then evaluated on the current polynomial and interpolated by the next one, until the error of the
//!   polynomial is of higher order than that of the scheme (W. H. Enright, K. R. Jackson, S. P. Nørsett, P.
//!   G. Thomsen, "Interpolants for Runge-Kutta formulas", ACM Trans. Math. Softw. 12, 1986): 2, 9 and 20
//!   gradients more for order 4, 6 and 8.
//!
//! `F = h H_0 + Σ_k ΔW_k H_k` is the step Hamiltonian with the increments of the step, so that with noise the
//! polynomial follows the flow of the frozen step Hamiltonian: the interpolation of Wong and Zakai, in which
//! each `W_k` is a straight line from node to node. The path of the stochastic equation is not smooth there,
//! and no polynomial follows it. The effect of a [bath](crate::scheme::bath) appears at the nodes only.

mod hermite;
mod slopes;

use crate::algebra::state::{State, Vector, copy, copy_state};
use crate::scheme::plan::{NoiseClass, Plan};
use crate::scheme::system::{Discretized, MemoryOf, PreparedOf, Scheme, SchemeOf};
use hermite::Hermite;
pub use slopes::RateCoefficients;
use slopes::{NodeWeights, weights};

/// The highest [`DenseOutput::order`] of schemes without a polynomial of their own.
const MOST_HERMITE_ORDER: u32 = 9;

/// The order of the polynomial through both nodes and their rates for a scheme with this plan.
pub const fn hermite_order(plan: &Plan) -> u32 {
    // With noise the order of paths is at most 1, below that of the cubic.
    if plan.order < 4 || !matches!(plan.noise, NoiseClass::None) {
        4
    } else if plan.order < MOST_HERMITE_ORDER {
        plan.order + 1
    } else {
        MOST_HERMITE_ORDER
    }
}

/// The path between the two nodes of the last step.
///
/// [`Stepper::step_densely`](crate::trajectory::step::Stepper::step_densely) fills it in, and allocates
/// nothing:
///
/// ```ignore
/// let mut dense = DenseOutput::of(&state);
/// stepper.step_densely(&mut state, &[], &mut dense)?;
/// let middle = dense.at(0.5);
/// ```
#[derive(Clone, Debug)]
pub struct DenseOutput<V> {
    /// Both nodes.
    ends: [State<V>; 2],
    h: f64,
    order: u32,
    slopes: RateCoefficients,
    hermite: Hermite<V>,
    /// Scratch for a state during a step.
    room: Option<State<V>>,
}

impl<V: Vector> DenseOutput<V> {
    /// For steps of states of this shape; before the first step the path is constant.
    pub fn of(state: &State<V>) -> Self {
        Self {
            ends: [state.clone(), state.clone()],
            h: 0.0,
            order: 0,
            slopes: RateCoefficients::default(),
            hermite: Hermite::of(state),
            room: Some(state.clone()),
        }
    }

    /// The order in `h` of the largest error inside a step, apart from that of the nodes: `S + 1` for
    /// `Gauss<S>` with two stages or more, else 4, and one more than the order of the scheme from 4 on, up
    /// to 9. 0 before the first step. With noise it is the order in the size of the step Hamiltonian, `h` and
    /// the increments together.
    pub fn order(&self) -> u32 {
        self.order
    }

    /// The state at the start of the step.
    pub fn start(&self) -> &State<V> {
        &self.ends[0]
    }

    /// The state at the end of the step.
    pub fn end(&self) -> &State<V> {
        &self.ends[1]
    }

    /// The state at `t + θh`; outside of `0 ≤ θ ≤ 1` the polynomial extrapolates.
    pub fn at(&self, theta: f64) -> State<V> {
        let mut state = self.ends[0].clone();
        self.write(theta, &mut state);
        state
    }

    /// [`DenseOutput::at`] into an existing state.
    pub fn write(&self, theta: f64, into: &mut State<V>) {
        let [start, end] = &self.ends;
        // From the nearer node, so that both ends are exact.
        let (node, part) = if theta <= 0.5 { (start, theta) } else { (end, theta - 1.0) };
        self.write_from(node, &weights(theta, part, self.slopes.rows()), into);
    }

    /// [`DenseOutput::write`] from a node, at the point with these weights.
    #[inline]
    fn write_from(&self, node: &State<V>, weights: &NodeWeights, into: &mut State<V>) {
        into.t = node.t + weights[0] * self.h;
        copy(&mut into.q, &node.q);
        copy(&mut into.p, &node.p);
        self.slopes.add(weights, [into.q.components_mut(), into.p.components_mut()]);
    }

    /// The state at sample `i` of [`Samples`].
    #[inline]
    pub(crate) fn write_sample(&self, samples: &Samples, i: usize, into: &mut State<V>) {
        let [start, end] = &self.ends;
        let node = if 2 * i <= samples.parts { start } else { end };
        self.write_from(node, &samples.weights[i], into);
    }

    /// The next step may be one of another system.
    pub(crate) fn forget(&mut self) {
        self.order = 0;
    }

    /// A copy of a state, to give back.
    pub(crate) fn lend(&mut self, state: &State<V>) -> State<V> {
        match self.room.take() {
            Some(mut room) => {
                copy_state(&mut room, state);
                room
            }
            None => state.clone(),
        }
    }

    pub(crate) fn give_back(&mut self, room: State<V>) {
        self.room = Some(room);
    }

    /// `θ` at a time.
    pub(crate) fn fraction(&self, t: f64) -> f64 {
        let [start, end] = &self.ends;
        let (from_start, from_end) = ((t - start.t) / self.h, (t - end.t) / self.h);
        if from_start <= 0.5 { from_start } else { 1.0 + from_end }
    }

    /// A straight line between two states.
    #[cfg(test)]
    pub(crate) fn straight(ends: [State<V>; 2]) -> Self {
        let mut dense = Self::of(&ends[0]);
        let degrees = ends[0].q.components().len();
        dense.slopes.resize(1, degrees);
        for d in 0..degrees {
            dense.slopes.of_mut(d)[0] = ends[1].q.components()[d] - ends[0].q.components()[d];
            dense.slopes.of_mut(degrees + d)[0] = ends[1].p.components()[d] - ends[0].p.components()[d];
        }
        (dense.h, dense.ends) = (ends[1].t - ends[0].t, ends);
        dense
    }

    /// The number of coefficients of the slope of a component.
    pub(crate) fn rows(&self) -> usize {
        self.slopes.rows()
    }

    /// Fills in the step with these increments from `before` to `after`, the last one recorded in `memory`.
    pub(crate) fn fill<H: Discretized<E, Vector = V>, E>(
        &mut self,
        (system, prepared, memory): (&H, &PreparedOf<H, E>, &MemoryOf<H, E, f64>),
        [before, after]: [&State<V>; 2],
        h: f64,
        dw: &[f64],
    ) {
        if H::PROPERTIES.has_polynomial {
            self.move_to([before, after], h, H::PROPERTIES.dense_order);
            SchemeOf::<H, E>::slopes_between(system, (prepared, memory), before, h, dw, &mut self.slopes);
        } else {
            self.fill_by_rates::<H, E>(system, [before, after], h, dw);
        }
    }

    /// [`DenseOutput::fill`] for a scheme without a polynomial of its own.
    pub(crate) fn fill_by_rates<H: Discretized<E, Vector = V>, E>(
        &mut self,
        system: &H,
        nodes: [&State<V>; 2],
        h: f64,
        dw: &[f64],
    ) {
        // A bath acts on the momenta instantaneously, and affects the polynomial through the nodes only.
        let dw = dw.get(..system.noises()).unwrap_or(dw);
        let is_same = self.order == H::PROPERTIES.dense_order && h == self.h && dw.is_empty();
        let follows = is_same && nodes[0] == &self.ends[1];
        self.move_to(nodes, h, H::PROPERTIES.dense_order);
        self.hermite.fill(system, &self.ends, h, dw, follows, self.order, &mut self.slopes);
    }

    /// Moves on to another step.
    fn move_to(&mut self, nodes: [&State<V>; 2], h: f64, order: u32) {
        for (end, state) in self.ends.iter_mut().zip(nodes) {
            copy_state(end, state);
        }
        (self.h, self.order) = (h, order);
    }
}

/// Equidistant points of a step, both ends included.
#[derive(Clone, Debug, Default)]
pub(crate) struct Samples {
    rows: usize,
    parts: usize,
    weights: Vec<NodeWeights>,
}

impl Samples {
    /// The ends of `parts` equal parts of a step, for polynomials of `rows` coefficients. Computes only what
    /// is new.
    pub(crate) fn set(&mut self, rows: usize, parts: usize) {
        if (self.rows, self.parts) != (rows, parts) {
            (self.rows, self.parts) = (rows, parts);
            self.weights.clear();
            self.weights.extend((0..=parts).map(|i| {
                let theta = i as f64 / parts as f64;
                weights(theta, if 2 * i <= parts { theta } else { theta - 1.0 }, rows)
            }));
        }
    }
}
