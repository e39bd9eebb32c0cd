//! Kicks, drifts and O parts in turn: [`Baoab`], [`Obabo`], [`Gjf`] and [`GjI`].
//!
//! Kicks and drifts are the flows of [`compose::flows`](crate::scheme::compose), with the increments of the
//! noises; the force at the end of a step is that at the start of the next.
//!
//! For a system with friction and [`Field`], of the form `T(p) + V(q, t)`.

use std::marker::PhantomData;

use super::letters::{A, B, Letter, Letters, O};
use super::modes::Decay;
use super::part::{self, BathLaw, OPartShares, OParts};
use super::{Baoab, Damped, GjI, Gjf, Obabo, with_bath};
use crate::algebra::lanes::Lanes;
use crate::algebra::scalar::{ComputesWith, Constant, ConstantsIn, Scalar};
use crate::algebra::solve::Effort;
use crate::algebra::state_sum::{self, PlainSum, StateSum};
use crate::error::{ConfigError, StepFailure, wrong};
use crate::scheme::compose::flows::KickDriftFlows;
use crate::scheme::compose::lists::{
    KeptForce, ListParts, PartScratch, SplittingLists, SplittingMemory, take_parts,
};
use crate::scheme::compose::tiled::{TiledInput, TiledMemory, least_scalar, takes_tiles};
use crate::scheme::elements::{Elements, NewState, check_new};
use crate::scheme::gauss::{Field, gather};
use crate::scheme::plan::{NoiseClass, Plan, Solver};
use crate::scheme::system::{
    Exchange, Hamiltonian as _, LiftParameter, Movable, Properties, Scheme, StepArguments, fits,
    varied_without_lists,
};
use crate::scheme::word::{Part, Substep, Weighted, Word};

impl Letters for Baoab {
    const LETTERS: &'static [Letter] = <(B, A, O, A, B)>::LETTERS;
}

impl Letters for Obabo {
    const LETTERS: &'static [Letter] = <(O, B, A, B, O)>::LETTERS;
}

impl Letters for Gjf {
    const LETTERS: &'static [Letter] = <(B, A, O, A, B)>::LETTERS;
    const DECAY: Decay = Decay::Cayley;
}

impl Letters for GjI {
    const LETTERS: &'static [Letter] = <(B, A, O, A, B)>::LETTERS;
    const IS_SHORTENED: bool = true;
}

/// The O parts of a word.
const fn shares<W: Letters>() -> OPartShares {
    const { assert!(W::O_PARTS > 0, "a word has one O at least") };
    OPartShares { parts: W::O_PARTS, decay: W::DECAY, is_shortened: W::IS_SHORTENED }
}

/// The steps of a word.
#[derive(Clone, Copy, Debug)]
pub struct Splitting<W>(PhantomData<W>);

/// The constants of steps.
#[derive(Clone, Debug)]
pub struct SplittingConstants<P, K> {
    parameters: P,
    /// The word as it is spelled.
    spelled: Word,
    /// The word with an O part between drifts [joined](Word::joined) to them: for lists of masses, unless a
    /// noise drifts too.
    joined: Word,
    /// Kicks and drifts alone, neighbours of one kind merged: for systems without friction.
    still: Word,
    relaxation: BathLaw<K>,
    /// The ratio of the time of kicks and drifts to that in the word.
    stretch: K,
}

impl<F, W> Scheme<F> for Splitting<W>
where
    F: Field,
    W: Letters,
{
    const PLAN: Plan = {
        let order = W::ORDER;
        // With multiplicative noise, consistency requires order two.
        let consistent = order == 2 || !matches!(F::FACTS.noise, NoiseClass::Multiplicative);
        with_bath(F::FACTS.plan(Solver::Explicit, 0, order, consistent))
    };
    const PROPERTIES: Properties = Properties {
        // Tiles are for lists of rates and masses.
        scalar_paths_from: match Damped::<F>::FRICTION.is_list() && !Damped::<F>::FRICTION.is_per_state {
            true => least_scalar::<F>(),
            false => usize::MAX,
        },
        exchanges: true,
        has_temperatures: Damped::<F>::FRICTION.has_temperatures,
        is_variational: false,
        ..Properties::of(&<Self as Scheme<F>>::PLAN, 0)
    };
    type Prepared<K: Constant> = SplittingConstants<ConstantsIn<F::Parameters, K>, K>;
    /// The memory of the O parts, then the memory of the flows: the other way round a step of three degrees
    /// of freedom takes 4 % longer.
    type Memory<S: Scalar> = (part::BathMemory<S>, SplittingMemory<S, F::Shape>);
    type Unclocked = Self;
    type CompensatedSum<S: Scalar> = state_sum::CompensatedSum<S, F::Shape>;
    type Sum<S: Scalar> = PlainSum;

    fn increments(system: &F, degrees: usize) -> usize {
        system.noises() + part::normals::<F>(degrees, W::O_PARTS)
    }

    fn exchanged(_: &F, (bath, _): &Self::Memory<f64>) -> Exchange {
        Exchange { work: 0.0, heat: bath.heat }
    }

    fn heats((bath, _): &Self::Memory<f64>) -> &[f64] {
        &bath.heats
    }

    fn temperature(system: &F) -> Option<f64> {
        part::temperature(system)
    }

    fn memory(system: &F) -> Self::Memory<f64> {
        (part::BathMemory::of_system(system), SplittingMemory::of_system(system))
    }

    fn prepare<K: Constant>(
        system: &F,
        lift: LiftParameter<'_, K>,
        h: K,
    ) -> Result<Self::Prepared<K>, ConfigError> {
        check_new(system)?;
        let relaxation = part::prepare(system, lift, h, shares::<W>())?;
        let spelled = Word::spelled(W::LETTERS);
        let flows = spelled.substeps.iter().filter(|substep| substep.part != Part::O);
        let still = Word::of(flows.map(|&Substep { part, weight, .. }| Weighted { part, weight }));
        let stretch = if W::IS_SHORTENED { shortened(system, lift, h)? } else { K::from_f64(1.0) };
        let (parameters, joined) = (system.parameters(lift), spelled.joined());
        Ok(SplittingConstants { parameters, spelled, joined, still, relaxation, stretch })
    }

    fn gather<const L: usize>(prepared: [&Self::Prepared<f64>; L]) -> Option<Self::Prepared<Lanes<L>>> {
        // Kicks and drifts have a different length in each system.
        if W::IS_SHORTENED {
            return None;
        }
        let parameters = gather::<F, L>(prepared.map(|prepared| &prepared.parameters))?;
        let relaxation = part::gather(prepared.map(|prepared| &prepared.relaxation))?;
        let SplittingConstants { spelled, joined, still, .. } = (*prepared.first()?).clone();
        let stretch = Lanes::from_f64(1.0);
        Some(SplittingConstants { parameters, spelled, joined, still, relaxation, stretch })
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn advance<K: Constant, S: ComputesWith<K>, C: StateSum<S>, const CAREFUL: bool>(
        system: &F,
        prepared: &Self::Prepared<K>,
        StepArguments { t, h, q, p, dw }: StepArguments<'_, S, K, impl Movable<S> + ?Sized>,
        (bath, memory): &mut Self::Memory<S>,
        carry: &mut C,
    ) -> Result<Effort, StepFailure> {
        let (degrees, noises) = (q.list().len(), system.noises());
        if !fits(system, degrees) {
            system.check(degrees)?;
        }
        if const { F::FACTS.has_tiles && S::MAY_BE_F64 }
            && takes_tiles::<F>(degrees)
            && let (Some(own_q), Some(own_p), Some(own)) =
                (S::as_f64s_mut(q.list()), S::as_f64s_mut(p.list()), S::as_f64s(dw))
        {
            let (t, h) = (t.lane(0), h.lane(0));
            let (stretch, of_noises) = (prepared.stretch.lane(0), &own[..noises.min(own.len())]);
            let lost = carry.lists(degrees).map(|lost| S::as_f64s(lost).unwrap_or_default());
            let givens = TiledInput { t, h, stretch, q: own_q, p: own_p, lost, dw: of_noises };
            if let Some(taken) =
                in_tiles::<F, K, S, C, W>(system, prepared, givens, dw, &mut memory.tiles, bath)
            {
                let (taken, heat) = taken?;
                taken.store(q, p, carry);
                bath.heat = S::from_f64(heat);
                bath.collect_heats();
                return Ok(Effort::fast(0));
            }
        }
        let parts =
            bath.parts(system, &prepared.relaxation, ([t, h], shares::<W>(), degrees), (dw, noises))?;
        let word = match parts.are_lists() && !C::CARRIES && noises == 0 {
            _ if parts.are_still() => &prepared.still,
            true => &prepared.joined,
            false => &prepared.spelled,
        };
        let SplittingConstants { parameters, stretch, .. } = prepared;
        let flows = KickDriftFlows { system, parameters, along: &None, t, h, stretch: *stretch };
        let mut parts = FlowsInBath { flows, parts, heat: S::from_f64(0.0) };
        let state = [q.list(), p.list()];
        let effort = take_parts(system, &mut parts, word, state, &dw[..noises], memory, carry)?;
        bath.heat = parts.heat;
        Ok(effort)
    }
}

/// The factor `s = √(tanh(γh/2)/(γh/2))` of the time in kicks and drifts of [`GjI`], with which
/// `s² (1 + c)/(1 - c) = 2/(γh)` for `c = e^{-γh}`: the diffusion of a free particle is right.
///
/// # Errors
/// [`BathError::Rates`] unless all degrees of freedom have one rate, [`ConfigError::Setting`] with noises,
/// whose increments would be shortened, too.
fn shortened<T: Elements, K: Constant>(
    system: &T,
    lift: LiftParameter<'_, K>,
    h: K,
) -> Result<K, ConfigError> {
    if system.noises() > 0 {
        return wrong("`GjI` takes kicks over a shorter time than the noises of the system have: take `Gjf`");
    }
    // If the size is unknown, one degree of freedom is enough to read the rate; the first step compares it
    // with the others.
    let parameters = varied_without_lists(system, lift)?;
    let rate = part::rate((system, &*parameters), system.degrees().max(1)).map_err(ConfigError::Bath)?;
    let x = h * 0.5 * rate;
    Ok(if x.lane(0) == 0.0 { K::from_f64(1.0) } else { (x.tanh() / x).sqrt() })
}

/// A step tile by tile; returns its heat, or `None` if friction and masses are not lists.
#[cfg_attr(not(debug_assertions), inline(always))]
fn in_tiles<'m, F: Field, K: Constant, S: ComputesWith<K>, C: StateSum<S>, W: Letters>(
    system: &F,
    prepared: &'m SplittingConstants<ConstantsIn<F::Parameters, K>, K>,
    givens: TiledInput<'_>,
    dw: &[S],
    tiles: &'m mut TiledMemory,
    bath: &mut part::BathMemory<S>,
) -> Option<Result<(NewState<'m>, f64), StepFailure>> {
    let degrees = givens.q.len();
    let size = ([givens.t, givens.h].map(K::from_f64), shares::<W>(), degrees);
    let driven = match bath.parts(system, &prepared.relaxation, size, (dw, system.noises())) {
        Ok(driven) => driven,
        Err(failure) => return Some(Err(failure)),
    };
    let relaxing = driven.by_place(W::O_PARTS, degrees)?;
    let word = if givens.dw.is_empty() && !C::CARRIES { &prepared.joined } else { &prepared.spelled };
    let taken = match C::CARRIES {
        true => tiles.take_parts_in_tiles::<F, true, true>(system, word, givens, Some(relaxing)),
        false => tiles.take_parts_in_tiles::<F, true, false>(system, word, givens, Some(relaxing)),
    };
    Some(taken.map(|taken| (taken, relaxing.heat())))
}

/// Kicks, drifts and O parts.
struct FlowsInBath<'m, F: Field, K: Constant, S> {
    flows: KickDriftFlows<'m, F, K>,
    parts: OParts<'m, F, K, S>,
    heat: S,
}

impl<F: Field, K: Constant, S: ComputesWith<K>> ListParts<S, F::Shape, Part> for FlowsInBath<'_, F, K, S> {
    const IS_PARTIAL: bool = <KickDriftFlows<'_, F, K> as ListParts<S, F::Shape, Part>>::IS_PARTIAL;

    fn begin_again(&mut self) {
        self.heat = S::from_f64(0.0);
        self.parts.begin_again();
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn take_part<C: StateSum<S>, const EXACT: bool>(
        &mut self,
        substep: &Substep,
        lists: &mut SplittingLists<'_, S, F::Shape>,
        kept: &mut KeptForce<S, F::Shape>,
        scratch: &mut PartScratch<S>,
    ) -> Result<(), StepFailure> {
        let drift = match substep.part {
            Part::A | Part::B | Part::GradientB(_) => {
                return self.flows.take_part::<C, EXACT>(substep, lists, kept, scratch);
            }
            Part::O => None,
            Part::AOA => Some(self.flows.h * (self.flows.stretch * substep.weight)),
        };
        let SplittingLists { q, p, rooms } = lists;
        self.heat =
            self.heat + self.parts.apply::<C>(substep.number, drift, [q, p, rooms.lost_p.as_mut()])?;
        Ok(())
    }
}
