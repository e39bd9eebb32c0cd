//! What a step reads of its system: of one, or of several beside each other.

use super::Field;
use super::advance::Prepared;
use super::stages::{One, Part, slopes};
use crate::algebra::lanes::Lanes;
use crate::algebra::scalar::Scalar;

/// Where the slopes of a step in numbers `S` come from.
pub(super) trait Source<S: Scalar> {
    /// The type of its systems.
    type Field: Field;

    /// The system of all lanes, if they have the same.
    fn system(&self) -> Option<&Self::Field>;

    /// As [`Field::step_slopes`].
    #[expect(clippy::too_many_arguments, reason = "as there")]
    fn slopes<const BY_Q: bool, const BY_P: bool>(
        &self,
        t: S,
        h: S,
        q: &[S],
        p: &[S],
        dw: &[S],
        by_q: &mut [S],
        by_p: &mut [S],
    );

    /// The same at the stages of a part.
    #[expect(clippy::too_many_arguments, reason = "as there")]
    fn slopes_of_part<const N: usize, const BY_Q: bool, const BY_P: bool>(
        &self,
        t: Part<S, N>,
        h: Part<S, N>,
        q: &[Part<S, N>],
        p: &[Part<S, N>],
        dw: &[Part<S, N>],
        by_q: &mut [Part<S, N>],
        by_p: &mut [Part<S, N>],
        one: &mut One<S>,
    );
}

impl<F: Field, S: Scalar> Source<S> for F {
    type Field = F;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn system(&self) -> Option<&F> {
        Some(self)
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn slopes<const BY_Q: bool, const BY_P: bool>(
        &self,
        t: S,
        h: S,
        q: &[S],
        p: &[S],
        dw: &[S],
        by_q: &mut [S],
        by_p: &mut [S],
    ) {
        Field::step_slopes::<S, BY_Q, BY_P>(self, t, h, q, p, dw, by_q, by_p);
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn slopes_of_part<const N: usize, const BY_Q: bool, const BY_P: bool>(
        &self,
        t: Part<S, N>,
        h: Part<S, N>,
        q: &[Part<S, N>],
        p: &[Part<S, N>],
        dw: &[Part<S, N>],
        by_q: &mut [Part<S, N>],
        by_p: &mut [Part<S, N>],
        one: &mut One<S>,
    ) {
        slopes::<F, S, N, BY_Q, BY_P>(self, t, h, q, p, dw, by_q, by_p, one);
    }
}

/// What a step of `L` systems beside each other reads of them.
#[derive(Debug)]
pub struct Systems<F: Field, const L: usize, const N: usize> {
    /// What is the same for all of them.
    pub(super) prepared: Prepared<N>,
    parameters: F::Parameters<Lanes<L>>,
    pub(super) degrees: usize,
    pub(super) noises: usize,
}

/// `L` systems beside each other; `None` where a step has a part of its own for each of them, of friction or of a stiff force.
pub(super) fn beside<F: Field, const L: usize, const N: usize>(
    systems: [&F; L],
    prepared: [&Prepared<N>; L],
) -> Option<Systems<F, L, N>> {
    if F::KIND.is_conformal || prepared.iter().any(|prepared| prepared.modes().is_some()) {
        return None;
    }
    let (system, prepared) = (systems.first()?, (*prepared.first()?).clone());
    let (degrees, noises) = (system.degrees(), system.noises());
    Some(Systems { prepared, parameters: F::parameters_beside(systems)?, degrees, noises })
}

impl<F: Field, const L: usize, const M: usize> Source<Lanes<L>> for Systems<F, L, M> {
    type Field = F;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn system(&self) -> Option<&F> {
        None
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn slopes<const BY_Q: bool, const BY_P: bool>(
        &self,
        t: Lanes<L>,
        h: Lanes<L>,
        q: &[Lanes<L>],
        p: &[Lanes<L>],
        dw: &[Lanes<L>],
        by_q: &mut [Lanes<L>],
        by_p: &mut [Lanes<L>],
    ) {
        F::slopes_over::<Lanes<L>, Lanes<L>, BY_Q, BY_P>(&self.parameters, t, h, q, p, dw, by_q, by_p);
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn slopes_of_part<const N: usize, const BY_Q: bool, const BY_P: bool>(
        &self,
        t: Lanes<L>,
        h: Lanes<L>,
        q: &[Lanes<L>],
        p: &[Lanes<L>],
        dw: &[Lanes<L>],
        by_q: &mut [Lanes<L>],
        by_p: &mut [Lanes<L>],
        _one: &mut One<Lanes<L>>,
    ) {
        Source::slopes::<BY_Q, BY_P>(self, t, h, q, p, dw, by_q, by_p);
    }
}
