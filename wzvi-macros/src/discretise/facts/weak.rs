//! The weak order of steps whose increments are frozen.
//!
//! With `L_k` the derivative along the flow of `H_k`, and noises that commute,
//!
//! ```text
//! E exp(h L_0 + Σ_k ΔW_k L_k) = exp(h (L_0 + ½ Σ_k L_k²)) - (h²/12) Σ_k [L_k, [L_k, L_0]] + O(h³)
//! ```
//!
//! The exact flow of the step Hamiltonian `F = h H_0 + Σ_k ΔW_k H_k` has weak order two if
//! `D = Σ_k {H_k, {H_k, H_0}}` is constant. A centred step of order two is the flow of `F` and a combination
//! of elementary Hamiltonians of third order in `F`, such as `F_qq(F_p, F_p)`. Terms with an odd number of
//! increments have no mean before `h³`, and three increments make no term if all noises read one half of the
//! phase space, or are affine. Those with two are `h Σ_k` of
//!
//! ```text
//! H_k(q):      H_0,pp(H_k,q, H_k,q) = D
//! H_k(p):      H_0,qq(H_k,p, H_k,p) = D
//! affine H_k:  H_0,pp(H_k,q, H_k,q),  H_0,pq(H_k,q, H_k,p)  and  H_0,qq(H_k,p, H_k,p)
//! ```
//!
//! The last three occur with other factors than in `D`. If `H_0` is a sum `T(p) + V(q)`, the second vanishes,
//! and the others are a function of `p` and one of `q`: both are constant if `D` is.
//!
//! Tests: `tests/laws/noise.rs`, `discretise/sums/tests.rs`.

use super::{Hamiltonians, NoiseClass};
use crate::discretise::{Calculus, Increments, Sum};
use crate::model::Half;
use crate::symbolic::Knowledge;

/// Whether the order is two, where noises commute. For [`NoiseClass::Multiplicative`] it is that of steps of
/// order four.
pub(super) fn has_order_two(
    sums: &mut Calculus<'_>,
    of: &Hamiltonians,
    class: NoiseClass,
    is_energy_kept: &Knowledge,
) -> bool {
    let Hamiltonians { t, drift, noise, forces, numbers: _, constraints: _ } = of;
    let reads = |sum: &Sum, momenta: bool| {
        sum.iter().any(|one| if momenta { one.element.reads().p } else { one.element.reads().q })
    };
    let noises: Sum = noise.concat();
    let reads_p = reads(&noises, true);
    let is_closed = forces.force.is_empty() && forces.friction.is_empty() && forces.noise.is_empty();
    match class {
        NoiseClass::None => return true,
        NoiseClass::Multiplicative => {
            // Every {H_k, H_0} vanishes if the energy is kept.
            let is_steady = !noises.iter().any(|one| one.element.reads_time(sums.graph, *t));
            return is_closed && is_energy_kept.is_proven() && is_steady;
        }
        NoiseClass::Additive | NoiseClass::Position | NoiseClass::Momentum => {}
    }
    // Along noises that read no momenta, `[L_k, [L_k, f · ∂/∂p]]` of a force `f` has the second derivatives
    // of `f` by `p`.
    if !is_closed && (reads_p || !is_affine_in_momenta(sums, &forces.force)) {
        return false;
    }
    // Noise forces that are not constant are no gradients.
    if !forces.noise.is_empty() && class != NoiseClass::Additive {
        return false;
    }
    if reads_p && reads(&noises, false) && !is_separable(sums, drift) {
        return false;
    }
    let each = Increments::Diagonal;
    let rates = sums.bracket(&noises, drift);
    let of_noises = rates.and_then(|rates| {
        let one = sums.contract((&noises, Half::Momenta), (&rates, Half::Coordinates), each);
        let other = sums.contract((&noises, Half::Coordinates), (&rates, Half::Momenta), each);
        sums.difference(one, other)
    });
    let pushes: Sum = forces.noise.concat();
    let powers = sums.contract((&pushes, Half::Displacements), (drift, Half::Momenta), Increments::Each);
    let of_forces = powers
        .and_then(|powers| sums.contract((&pushes, Half::Displacements), (&powers, Half::Momenta), each));
    [of_noises, of_forces].into_iter().all(|sum| sums.is_constant(sum, each).known.is_proven())
}

/// Whether a function is `T(p) + V(q)`.
fn is_separable(sums: &mut Calculus<'_>, function: &Sum) -> bool {
    let Calculus { graph, .. } = sums;
    function.iter().all(|one| {
        if one.element.is_collective() {
            return false;
        }
        let coordinates: Vec<_> = one.element.coordinates().map(|(symbol, _)| symbol).collect();
        one.element.momenta().all(|(p, _)| {
            let slope = graph.derivative(one.element.value, p);
            coordinates.iter().all(|&q| {
                let mixed = graph.derivative(slope, q);
                graph.is_zero(mixed)
            })
        })
    })
}

fn is_affine_in_momenta(sums: &mut Calculus<'_>, force: &Sum) -> bool {
    let Calculus { graph, .. } = sums;
    force.iter().all(|one| {
        if one.element.collectives().any(|(_, slot)| slot.reads.p) {
            return false;
        }
        let momenta: Vec<_> = one.element.momenta().map(|(symbol, _)| symbol).collect();
        !graph.has_pieces(one.element.value, &momenta)
            && momenta.iter().all(|&a| {
                let slope = graph.derivative(one.element.value, a);
                momenta.iter().all(|&b| {
                    let curvature = graph.derivative(slope, b);
                    graph.is_zero(curvature)
                })
            })
    })
}
