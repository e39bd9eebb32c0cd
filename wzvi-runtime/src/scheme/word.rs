//! Words: the parts that move the state one after the other in a step.
//!
//! With the step Hamiltonian `F = h H_0 + Σ_k ΔW_k H_k = T(p) + V(q, t)`, frozen over the step, a [`Part`] is
//!
//! ```text
//! A           q <- q + a ∂T/∂p                  drift
//! B           p <- p - b ∂V/∂q                  kick
//! GradientB   p <- p - b V' + 2 c V'' T'' V'    kick by the potential b V - c |V'|²
//! O           p <- E p + R ξ                    friction and noise of the bath
//! AOA         A, O, A over equal fractions of the step, site by site
//! ```
//!
//! A [`Word`] lists them with their weights `a`, `b`. It holds fractions of a step and not its size, so that
//! one word serves steps of any size. [`Composes::word`](super::compose::Composes) makes the words of weights
//! and tables, [`Word::spelled`] those of the letters of a user.
//!
//! Three executors take words: that of [lists](super::compose) takes part after part for the whole state,
//! that of [tiles](super::elements) all parts for a tile while it is in the cache, and that of
//! [constraints](super::constraints) part after part on a manifold.

use std::fmt::Debug;

/// A part of a step: the letters of the words of splittings.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Part {
    /// Drift: the flow of `T(p)`.
    A,
    /// Kick: the flow of `V(q, t)`.
    B,
    /// Kick by `b V - c |V'|²`, in the metric of the inverse masses, with this `c` in units of `h³`.
    GradientB(f64),
    /// Friction and noise of the bath.
    O,
    /// Drift, friction and noise, and a drift of the same weight, which is that of each of the two.
    AOA,
}

impl Part {
    /// Whether it changes the momenta by a force.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) const fn is_kick(self) -> bool {
        matches!(self, Self::B | Self::GradientB(_))
    }

    /// Whether it changes the coordinates.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) const fn drifts(self) -> bool {
        matches!(self, Self::A | Self::AOA)
    }

    /// The weight with the sign of the derivatives that it adds to the state.
    const fn signed(self, weight: f64) -> f64 {
        if self.is_kick() { -weight } else { weight }
    }
}

/// The kinds of parts that words can have: flows of a splitting, or steps of schemes that are composed.
pub trait PartKind: Copy + PartialEq + Debug + 'static {
    /// Text for users: how the drifts and kicks of a table are taken.
    const NOTE: &'static str = "";
    /// Whether parts are flows: two of one kind in a row are one, over the sum of their fractions.
    const IS_FLOW: bool;

    /// Whether it moves the time at which a part `other` acts.
    fn moves_time_of(self, other: Self) -> bool;

    /// The fraction of the derivatives of `F` that a part of this weight adds to the state.
    fn share(self, weight: f64) -> f64 {
        weight
    }

    /// Marks the kicks whose force serves two steps.
    fn mark_kicks(_: &mut [Substep<Self>]) {}

    /// The word for the drifts and kicks of a table, which alternate.
    fn of_table(table: &[Weighted<Part>]) -> Word<Self>;
}

impl PartKind for Part {
    const IS_FLOW: bool = true;

    /// Time is a coordinate that the drift moves.
    fn moves_time_of(self, _: Self) -> bool {
        self == Self::A
    }

    fn share(self, weight: f64) -> f64 {
        self.signed(weight)
    }

    /// O parts before the first and after the last flow change momenta alone, so that the force stays.
    fn mark_kicks(substeps: &mut [Substep]) {
        let mut flows = substeps.iter_mut().filter(|substep| substep.part != Self::O);
        let ends = [flows.next(), flows.next_back()];
        if let [Some(Substep { part: first, .. }), Some(Substep { part: last, .. })] = &ends
            && first.is_kick()
            && last.is_kick()
        {
            for (end, force) in
                ends.into_iter().flatten().zip([ForceUse::FromStepBefore, ForceUse::ForNextStep])
            {
                end.force = force;
            }
            return;
        }
        for end in ends.into_iter().flatten().filter(|end| end.part.is_kick()) {
            end.force = ForceUse::AtOneEnd;
        }
    }

    fn of_table(table: &[Weighted<Self>]) -> Word {
        Word::of(table.iter().copied())
    }
}

/// A part, and its weight in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weighted<P = Part> {
    /// The part.
    pub part: P,
    /// The fraction of the step over which it acts.
    pub weight: f64,
}

/// The parts of a step, in their order.
#[derive(Clone, Debug, PartialEq)]
pub struct Word<P = Part> {
    pub(crate) substeps: Vec<Substep<P>>,
}

/// A part of a word, and its place there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Substep<P = Part> {
    /// The part.
    pub part: P,
    /// The fraction of the step over which it acts.
    pub weight: f64,
    /// The fraction of step size and increments for the derivatives that it adds to the state: the weight,
    /// with a minus sign for a kick, which subtracts them.
    pub share: f64,
    /// The fraction of the step after which it acts: the time that the parts before it have reached. A kick
    /// is at this node, a drift begins there.
    pub node: f64,
    /// The number of parts of its kind before it.
    pub number: usize,
    /// How often its force is used, if it is a kick.
    pub force: ForceUse,
}

/// How often the force of a kick is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ForceUse {
    /// Once, between drifts.
    Once,
    /// Once, at the one end of a step which is a kick.
    AtOneEnd,
    /// At the beginning of a step that ends with a kick: it may be the last force of the step before.
    FromStepBefore,
    /// At the end of a step that begins with a kick: it may be the first force of the next step.
    ForNextStep,
}

impl ForceUse {
    /// Whether the kick is the first or the last flow of a step.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn is_at_end(self) -> bool {
        self != Self::Once
    }
}

impl<P> Substep<P> {
    /// This substep of another part.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn with<Q>(&self, part: Q) -> Substep<Q> {
        let Self { weight, share, node, number, force, .. } = *self;
        Substep { part, weight, share, node, number, force }
    }
}

impl Substep {
    /// A part with its place in a word; its force is used once.
    pub(crate) const fn new(part: Part, weight: f64, node: f64, number: usize) -> Self {
        Self { part, weight, share: part.signed(weight), node, number, force: ForceUse::Once }
    }
}

impl<P: PartKind> Word<P> {
    /// These parts, with neighbours merged that are flows of one kind.
    pub(crate) fn of(parts: impl IntoIterator<Item = Weighted<P>>) -> Self {
        let mut word = Self { substeps: Vec::new() };
        parts.into_iter().for_each(|part| word.push(part));
        // The weights of each kind sum to 1 up to rounding.
        if let Some(last) = word.substeps.last_mut()
            && !last.part.moves_time_of(last.part)
        {
            last.node = 1.0;
        }
        P::mark_kicks(&mut word.substeps);
        word
    }

    /// Steps of these parts, over the fractions `weights` of a step.
    pub(crate) fn composed(step: &[Weighted<P>], weights: &[f64]) -> Self {
        let over = |fraction: f64| {
            step.iter().map(move |&Weighted { part, weight }| Weighted { part, weight: weight * fraction })
        };
        Self::of(weights.iter().flat_map(|&fraction| over(fraction)))
    }

    fn push(&mut self, Weighted { part, weight }: Weighted<P>) {
        if P::IS_FLOW && weight == 0.0 {
            return;
        }
        if P::IS_FLOW
            && let Some(last) = self.substeps.last_mut()
            && last.part == part
        {
            last.weight += weight;
            last.share = part.share(last.weight);
            return;
        }
        let alike = self.substeps.iter().rposition(|before| before.part == part);
        let (mut node, number) = match alike {
            Some(i) => (self.substeps[i].node, self.substeps[i].number + 1),
            None => (0.0, 0),
        };
        for before in &self.substeps[alike.unwrap_or(0)..] {
            if before.part.moves_time_of(part) {
                node += before.weight;
            }
        }
        let (share, force) = (part.share(weight), ForceUse::Once);
        self.substeps.push(Substep { part, weight, share, node, number, force });
    }
}

impl Word {
    /// The number of its drifts.
    pub(crate) fn drifts(&self) -> usize {
        self.substeps.iter().filter(|substep| substep.part == Part::A).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LEAPFROG: [Weighted; 3] = [
        Weighted { part: Part::B, weight: 0.5 },
        Weighted { part: Part::A, weight: 1.0 },
        Weighted { part: Part::B, weight: 0.5 },
    ];

    /// A kick acts at the time that the drifts before it have reached, and neighbours of one kind are one.
    #[test]
    fn a_composition_has_one_kick_between_drifts() {
        let word = Word::composed(&LEAPFROG, &[0.75, -0.5, 0.75]);
        let parts: Vec<Part> = word.substeps.iter().map(|substep| substep.part).collect();
        assert_eq!(parts, [Part::B, Part::A, Part::B, Part::A, Part::B, Part::A, Part::B]);
        let column = |of: fn(&Substep) -> f64| word.substeps.iter().map(of).collect::<Vec<_>>();
        assert_eq!(column(|substep| substep.weight), [0.375, 0.75, 0.125, -0.5, 0.125, 0.75, 0.375]);
        assert_eq!(column(|substep| substep.share), [-0.375, 0.75, -0.125, -0.5, -0.125, 0.75, -0.375]);
        assert_eq!(column(|substep| substep.node), [0.0, 0.0, 0.75, 0.75, 0.25, 0.25, 1.0]);
        let numbers: Vec<usize> = word.substeps.iter().map(|substep| substep.number).collect();
        assert_eq!(numbers, [0, 0, 1, 1, 2, 2, 3]);
        let forces: Vec<ForceUse> = word.substeps.iter().map(|substep| substep.force).collect();
        assert_eq!((forces[0], forces[6]), (ForceUse::FromStepBefore, ForceUse::ForNextStep));
        assert!(forces[1..6].iter().all(|force| *force == ForceUse::Once));
    }

    /// With a kick at one end only, no force serves two steps.
    #[test]
    fn a_force_is_kept_between_kicks_only() {
        let [kick, _, _] = LEAPFROG;
        let drift = Weighted { part: Part::A, weight: 0.5 };
        let word = Word::of([kick, drift, kick, drift]);
        let forces: Vec<ForceUse> = word.substeps.iter().map(|substep| substep.force).collect();
        assert_eq!(forces, [ForceUse::AtOneEnd, ForceUse::Once, ForceUse::Once, ForceUse::Once]);
        assert_eq!(word.substeps[2].node, 0.5);
    }

    /// A table is the same word of flows and of summands, and a word of steps of an adjoint pair: with the
    /// coefficients `x` of the drifts and kicks these are `x_1`, `x_2 - x_1`, ..., one after the other.
    #[test]
    fn a_table_is_a_word_of_every_kind() {
        use crate::scheme::compose::{BasicMethod, Summand};
        let turns = [(Part::A, 0.25), (Part::B, 0.5), (Part::A, 0.5), (Part::B, 0.5), (Part::A, 0.25)];
        let table = turns.map(|(part, weight)| Weighted { part, weight });
        let flows = Part::of_table(&table).substeps;
        let nodes: Vec<f64> = flows.iter().map(|substep| substep.node).collect();
        assert_eq!(nodes, [0.0, 0.25, 0.25, 0.75, 0.75]);
        let summands = Summand::of_table(&table).substeps;
        let of_other: Vec<f64> = summands.iter().map(|substep| substep.node).collect();
        assert_eq!(of_other, [0.0, 0.25, 0.5, 0.75, 1.0]);
        assert_eq!((summands[0].part, summands[1].part), (Summand::A, Summand::B));
        let steps = BasicMethod::of_table(&table).substeps;
        let of_steps: Vec<_> = steps.iter().map(|s| (s.part, s.weight, s.node, s.number)).collect();
        let [itself, adjoint] = [BasicMethod::Itself, BasicMethod::Adjoint];
        let expected = [
            (adjoint, 0.25, 0.0, 0),
            (itself, 0.25, 0.25, 0),
            (adjoint, 0.25, 0.5, 1),
            (itself, 0.25, 0.75, 1),
        ];
        assert_eq!(of_steps, expected);
    }
}
