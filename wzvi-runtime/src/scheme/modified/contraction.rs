//! The value of a tree at a state: derivatives of `H` in directions, by dual numbers through the gradient
//! that the compiler has derived.

use std::collections::BTreeMap;

use super::tree::{Branch, PhaseHalf, Tree};
use crate::algebra::scalar::{Dual, Scalar};
use crate::algebra::state::{State, Vector};
use crate::scheme::system::Hamiltonian;

/// Two functions: one makes the number `value + Σ_k slopes_k ε_k` with infinitesimals `ε_k² = 0`, one reads
/// the coefficient of the product of all `ε_k`. They have one infinitesimal more than the given ones.
#[expect(clippy::type_complexity, reason = "closures have no names")]
fn one_more<S: Scalar>(
    (lift, product): (impl Fn(f64, &[f64]) -> S, impl Fn(S) -> f64),
) -> (impl Fn(f64, &[f64]) -> Dual<1, S>, impl Fn(Dual<1, S>) -> f64) {
    let lift = move |value: f64, slopes: &[f64]| {
        let (own, rest) = slopes.split_first().map_or((0.0, slopes), |(own, rest)| (*own, rest));
        Dual { value: lift(value, rest), derivative: [S::from_f64(own)] }
    };
    (lift, move |number: Dual<1, S>| product(number.derivative[0]))
}

/// `∂_q` and `∂_p` of a function.
type PhaseGradient = [Vec<f64>; 2];

/// Contractions at one state; each subtree is evaluated once. Derivatives of the gradient are compiled up to
/// order `DEPTH`: trees of three, five and seven vertices need orders 1, 3 and 5.
pub(super) struct Contractions<'s, H: Hamiltonian, const DEPTH: usize> {
    system: &'s H,
    state: &'s State<H::Vector>,
    known: BTreeMap<Tree, PhaseGradient>,
}

impl<'s, H: Hamiltonian, const DEPTH: usize> Contractions<'s, H, DEPTH> {
    pub(super) fn at(system: &'s H, state: &'s State<H::Vector>) -> Self {
        Self { system, state, known: BTreeMap::new() }
    }

    /// The value of a tree.
    pub(super) fn value(&mut self, tree: &Tree) -> f64 {
        let Some((last, rest)) = tree.branches.split_last() else {
            return self.system.energy(self.state);
        };
        let [by_q, by_p] = self.slopes(&Tree { branches: rest.to_vec() });
        let (half, direction) = self.direction(last);
        let slopes = match half {
            PhaseHalf::Coordinates => by_q,
            PhaseHalf::Momenta => by_p,
        };
        slopes.iter().zip(&direction).map(|(slope, along)| slope * along).sum()
    }

    /// The direction along which a branch differentiates its vertex.
    fn direction(&mut self, (half, beyond): &Branch) -> (PhaseHalf, Vec<f64>) {
        let [by_q, by_p] = self.slopes(beyond);
        let direction = match half {
            PhaseHalf::Coordinates => by_p,
            PhaseHalf::Momenta => by_q,
        };
        (*half, direction)
    }

    /// The gradient of `H` at the root, differentiated along all branches.
    fn slopes(&mut self, tree: &Tree) -> PhaseGradient {
        if let Some(known) = self.known.get(tree) {
            return known.clone();
        }
        let directions: Vec<(PhaseHalf, Vec<f64>)> =
            tree.branches.iter().map(|branch| self.direction(branch)).collect();
        let none = (|value: f64, _: &[f64]| value, |number: f64| number);
        let two = one_more(one_more(none));
        let slopes = match directions.len() {
            0 => self.along(&directions, none),
            1 => self.along(&directions, one_more(none)),
            // Never reached: no tree of this order has that many branches.
            _ if const { DEPTH < 2 } => [(); 2].map(|()| vec![f64::NAN; self.state.q.components().len()]),
            2 => self.along(&directions, two),
            3 => self.along(&directions, one_more(two)),
            _ if const { DEPTH < 4 } => [(); 2].map(|()| vec![f64::NAN; self.state.q.components().len()]),
            4 => self.along(&directions, one_more(one_more(two))),
            _ => self.along(&directions, one_more(one_more(one_more(two)))),
        };
        self.known.insert(tree.clone(), slopes.clone());
        slopes
    }

    /// The derivative along directions, with numbers made and read by these functions: [`one_more`].
    fn along<S: Scalar>(
        &self,
        directions: &[(PhaseHalf, Vec<f64>)],
        (of, product): (impl Fn(f64, &[f64]) -> S, impl Fn(S) -> f64),
    ) -> PhaseGradient {
        let lift = |half: PhaseHalf, values: &[f64]| -> Vec<S> {
            let component = |(i, &value): (usize, &f64)| {
                let slopes: Vec<f64> = directions
                    .iter()
                    .map(|(own, direction)| if *own == half { direction[i] } else { 0.0 })
                    .collect();
                of(value, &slopes)
            };
            values.iter().enumerate().map(component).collect()
        };
        let q = lift(PhaseHalf::Coordinates, self.state.q.components());
        let p = lift(PhaseHalf::Momenta, self.state.p.components());
        let zero = S::from_f64(0.0);
        let (mut by_q, mut by_p) = (vec![zero; q.len()], vec![zero; p.len()]);
        self.system.differentiate(0, &q, &p, self.state.t, &mut by_q, &mut by_p);
        [by_q, by_p].map(|slopes| slopes.into_iter().map(&product).collect())
    }
}
