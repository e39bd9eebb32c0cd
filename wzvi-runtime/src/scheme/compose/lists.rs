//! The executor of words that moves lists: part after part, each for the whole state.
//!
//! [`ListParts`] says how a part moves lists, [`take_parts`] takes all parts of a step, with their sums and
//! checks.

use super::gradient::Directional;
use super::lagrangian::SequenceEnd;
use super::tiled;
use crate::algebra::lanes::instructions::{InstructionSet, Kernel};
use crate::algebra::memory::{MemoryRequest, StepMemory};
use crate::algebra::scalar::{ComputesWith, Constant, Scalar};
use crate::algebra::shape::Shape;
use crate::algebra::solve::Effort;
use crate::algebra::state::Vector;
use crate::algebra::state_sum::{PlainSum, StateSum};
use crate::error::StepFailure;
use crate::ground::numbers::{Numbers, Tape};
use crate::scheme::elements::{PairColumns, are_finite};
use crate::scheme::system::{Hamiltonian, Segment, check_lengths};
use crate::scheme::word::{Substep, Word};

/// Lists of one number per degree of freedom.
type DegreeList<S, H> = <H as Shape>::List<S>;

/// The last force and where it acted, and scratch for a step.
#[derive(Debug)]
pub struct SplittingMemory<S: Scalar, H: Shape> {
    kept: KeptForce<S, H>,
    /// The first momenta of a step of vectors.
    first_p: DegreeList<S, H>,
    rooms: SplittingRooms<S, H>,
    pub(super) scratch: PartScratch<S>,
    /// For large systems of elements.
    pub(crate) tiles: tiled::TiledMemory,
    /// The instructions for loops over all degrees of freedom.
    instructions: InstructionSet,
}

/// The last force of a step, with which the next one may begin.
#[derive(Debug)]
pub(crate) struct KeptForce<S: Scalar, H: Shape> {
    /// Its time and step size.
    origin: Option<ForceTime>,
    /// Time and step size with the derivatives that numbers carry.
    carried: [S; 2],
    /// `origin` in a step that begins at the coordinates where the force acted.
    usable: Option<ForceTime>,
    /// The coordinates at which it acted. During a step of vectors, the first coordinates.
    q: DegreeList<S, H>,
    /// The increment of the momenta.
    force: DegreeList<S, H>,
}

/// Scratch for a part of a step.
#[derive(Debug)]
pub(crate) struct PartScratch<S: Scalar> {
    /// The noise increments of the part.
    pub(crate) dw: Vec<S>,
    pub(super) columns: PairColumns,
    /// For derivatives of derivatives; empty unless a table asks for them.
    pub(super) directional: Directional<S>,
}

/// Time and weighted step size of a force.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ForceTime<K = f64> {
    pub(crate) t: K,
    pub(crate) h: K,
}

impl<K: Constant> ForceTime<K> {
    /// With the derivatives that numbers carry.
    fn list<S: ComputesWith<K>>(&self) -> [S; 2] {
        [self.t, self.h].map(S::constant)
    }
}

/// Whether numbers carry derivatives.
const fn carry_derivatives<S: Scalar>() -> bool {
    !S::LANES_ARE_PATHS && size_of::<S>() != size_of::<f64>()
}

/// The lists of a step.
#[derive(Debug)]
pub(crate) struct SplittingLists<'a, S: Scalar, H: Shape> {
    pub(crate) q: &'a mut [S],
    pub(crate) p: &'a mut [S],
    pub(crate) rooms: &'a mut SplittingRooms<S, H>,
}

/// The lists of a step other than the state.
#[derive(Debug)]
pub(crate) struct SplittingRooms<S: Scalar, H: Shape> {
    /// The rounding errors of the coordinates and of the momenta.
    pub(crate) lost_q: DegreeList<S, H>,
    pub(crate) lost_p: DegreeList<S, H>,
    /// The increments of the momenta.
    pub(crate) force: DegreeList<S, H>,
    /// The increments of the coordinates.
    pub(crate) velocity: DegreeList<S, H>,
}

impl<S: Scalar, H: Shape> SplittingRooms<S, H> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn of_length(length: usize) -> Self {
        let list = || H::list(length, S::from_f64(0.0));
        Self { lost_q: list(), lost_p: list(), force: list(), velocity: list() }
    }
}

impl<S: Scalar, H: Shape> Default for SplittingMemory<S, H> {
    fn default() -> Self {
        Self::of_length(0)
    }
}

/// The copy evaluates its first force itself, and allocates its own scratch.
impl<S: Scalar, H: Shape> Clone for SplittingMemory<S, H> {
    fn clone(&self) -> Self {
        Self { tiles: self.tiles.alike(), ..Self::default() }
    }
}

/// Stores nothing: a force that is evaluated again is the same. What is read belongs to another run, whose
/// system may have other parameters.
impl<S: Scalar, H: Shape> Numbers for SplittingMemory<S, H> {
    fn pass(&mut self, tape: &mut Tape) {
        if tape.is_reading() {
            self.kept.origin = None;
        }
    }
}

impl<S: Scalar, H: Shape> StepMemory for SplittingMemory<S, H> {
    fn tell(&mut self, request: &MemoryRequest) {
        match request {
            MemoryRequest::Forget => self.kept.origin = None,
            MemoryRequest::Share(threads) => self.tiles.share(*threads),
            _ => {}
        }
    }

    fn adopt(&mut self, _: Self) {}
}

impl<S: Scalar, H: Shape> SplittingMemory<S, H> {
    pub(crate) fn of_length(length: usize) -> Self {
        let list = || H::list(length, S::from_f64(0.0));
        let carried = [S::from_f64(0.0); 2];
        Self {
            kept: KeptForce { origin: None, carried, usable: None, q: list(), force: list() },
            first_p: list(),
            rooms: SplittingRooms::of_length(length),
            scratch: PartScratch {
                dw: Vec::new(),
                columns: PairColumns::default(),
                directional: Directional::default(),
            },
            tiles: tiled::TiledMemory::default(),
            instructions: InstructionSet::best().for_loop(length),
        }
    }

    /// Allocates for these numbers of degrees of freedom and noises.
    #[cold]
    fn fit(&mut self, length: usize, noises: usize) {
        if self.length() != length {
            *self = Self { tiles: self.tiles.alike(), ..Self::of_length(length) };
        }
        self.scratch.dw.resize(noises, S::from_f64(0.0));
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn length(&self) -> usize {
        self.first_p.as_ref().len()
    }

    /// The memory of a new stepper, allocated at once if the system knows its size.
    pub(crate) fn of_system<F: Hamiltonian>(system: &F) -> Self {
        let (mut memory, degrees) = (Self::default(), system.degrees());
        if degrees != 0 && system.check(degrees).is_ok() {
            memory.fit(degrees, system.noises());
        }
        memory
    }
}

impl<S: Scalar, H: Shape> KeptForce<S, H> {
    /// Begins a step; returns whether the force acted at its coordinates.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn begin(&mut self, q: &[S]) -> bool {
        self.usable = self.origin.take();
        let mut is_here = self.usable.is_some();
        if is_here {
            for (&a, &b) in self.q.as_ref().iter().zip(q) {
                is_here &= a.is_identical(b);
            }
        }
        if !is_here {
            self.usable = None;
        }
        is_here
    }

    /// The force, if it is that of a kick at the beginning of this step.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn for_kick<K: Constant>(&self, origin: ForceTime<K>, reads_time: bool) -> Option<&[S]>
    where
        S: ComputesWith<K>,
    {
        let kept = self.usable?;
        let (t, h) = (origin.t.lane(0), origin.h.lane(0));
        if kept.h.to_bits() != h.to_bits() || (reads_time && kept.t.to_bits() != t.to_bits()) {
            return None;
        }
        if const { carry_derivatives::<S>() } {
            let [kept, now] = [self.carried, origin.list()];
            if !kept[1].is_identical(now[1]) || (reads_time && !kept[0].is_identical(now[0])) {
                return None;
            }
        }
        Some(self.force.as_ref())
    }

    /// Keeps a force for the next step, where it acts at the coordinates with which this step ends.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn keep<K: Constant>(&mut self, origin: ForceTime<K>, force: &mut DegreeList<S, H>)
    where
        S: ComputesWith<K>,
    {
        self.origin = Some(ForceTime { t: origin.t.lane(0), h: origin.h.lane(0) });
        if const { carry_derivatives::<S>() } {
            self.carried = origin.list();
        }
        H::keep(&mut self.force, force);
    }
}

/// How the parts `P` of a word move lists.
///
/// Not a closure: one that is called in several places is compiled without the vector instructions of its
/// callers.
pub(crate) trait ListParts<S: Scalar, H: Shape, P> {
    /// Whether parts that are not `EXACT` may be NaN where the step exists.
    const IS_PARTIAL: bool = false;

    /// Prepares for the first part of a step that is taken again.
    fn begin_again(&mut self) {}

    /// Moves the state in the lists by a part of a step, with the noise increments of that part in the
    /// scratch.
    ///
    /// # Errors
    /// [`StepFailure::Bath`] where friction is negative.
    fn take_part<C: StateSum<S>, const EXACT: bool>(
        &mut self,
        substep: &Substep<P>,
        lists: &mut SplittingLists<'_, S, H>,
        kept: &mut KeptForce<S, H>,
        scratch: &mut PartScratch<S>,
    ) -> Result<(), StepFailure>;
}

/// Takes all parts of a step. On `Err`, `q`, `p` and `carry` are as they were.
///
/// # Errors
/// [`StepFailure::NonFinite`], the failure of a part, or that of sizes that do not fit.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn take_parts<S: Scalar, C: StateSum<S>, H: Shape, P>(
    system: &impl Hamiltonian,
    parts: &mut impl ListParts<S, H, P>,
    word: &Word<P>,
    [q, p]: [&mut [S]; 2],
    dw: &[S],
    memory: &mut SplittingMemory<S, H>,
    carry: &mut C,
) -> Result<Effort, StepFailure> {
    let degrees = q.len();
    let is_ready = memory.length() == degrees && memory.scratch.dw.len() == dw.len();
    check_lengths(system, is_ready, [degrees, p.len(), dw.len()])?;
    if !is_ready {
        memory.fit(degrees, dw.len());
    }
    let instructions = memory.instructions;
    let mut step = PartsInTurn { parts, word, q, p, dw, memory, carry };
    // Numbers side by side are in such a loop already, and arrays stay in registers.
    if const { H::IS_FIXED || !S::MAY_BE_F64 } || S::as_f64s(step.q).is_none() {
        return step.take::<true>();
    }
    instructions.run(&mut step).or_else(|failure| step.take_exactly(failure))
}

/// The parts of a step, and what they read and change.
struct PartsInTurn<'a, S: Scalar, C, H: Shape, P, M> {
    parts: &'a mut M,
    word: &'a Word<P>,
    q: &'a mut [S],
    p: &'a mut [S],
    dw: &'a [S],
    memory: &'a mut SplittingMemory<S, H>,
    carry: &'a mut C,
}

/// The step in the vector instructions of the machine, and in numbers that vectorised functions cover.
impl<S: Scalar, C: StateSum<S>, H: Shape, P, M: ListParts<S, H, P>> Kernel
    for &mut PartsInTurn<'_, S, C, H, P, M>
{
    type Output = Result<Effort, StepFailure>;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn run<const L: usize, const HALF: usize>(self) -> Self::Output {
        self.take::<false>()
    }
}

impl<S: Scalar, C: StateSum<S>, H: Shape, P, M: ListParts<S, H, P>> PartsInTurn<'_, S, C, H, P, M> {
    /// The step in exact numbers, if `failure` may be of numbers that vectorised functions do not cover.
    #[cold]
    #[inline(never)]
    fn take_exactly(&mut self, failure: StepFailure) -> Result<Effort, StepFailure> {
        if const { !M::IS_PARTIAL } || failure != StepFailure::NonFinite {
            return Err(failure);
        }
        self.parts.begin_again();
        self.take::<true>()
    }

    /// Vectors are changed in place, with a copy that undoes a step that fails; arrays are copied first, and
    /// stay in registers. All lists have the length of the state, which [`take_parts`] has checked.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn take<const EXACT: bool>(&mut self) -> Result<Effort, StepFailure> {
        let Self { parts, word, q, p, dw, memory, carry } = self;
        let SplittingMemory { kept, first_p, rooms, scratch, .. } = &mut **memory;
        let is_at_kept = kept.begin(q);
        let (mut arrays, mut array_rooms) =
            ([0, 1].map(|_| H::list(0, S::from_f64(0.0))), SplittingRooms::of_length(0));
        let [own_q, own_p] = arrays.each_mut().map(AsMut::as_mut);
        let mut lists = if H::IS_FIXED {
            own_q.copy_from_slice(q);
            own_p.copy_from_slice(p);
            SplittingLists { q: own_q, p: own_p, rooms: &mut array_rooms }
        } else {
            if !is_at_kept {
                kept.q.as_mut().copy_from_slice(q);
            }
            first_p.as_mut().copy_from_slice(p);
            SplittingLists { q, p, rooms }
        };
        if C::CARRIES {
            let SplittingRooms { lost_q, lost_p, .. } = &mut *lists.rooms;
            let lost = lost_q.as_mut().iter_mut().zip(lost_p.as_mut());
            for (i, (lost_q, lost_p)) in lost.enumerate() {
                (*lost_q, *lost_p) = (carry.of_coordinate(i), carry.of_momentum(i));
            }
        }
        let mut taken_all = Ok(());
        for substep in &word.substeps {
            for (scaled, dw) in scratch.dw.iter_mut().zip(*dw) {
                *scaled = *dw * substep.share;
            }
            taken_all = parts.take_part::<C, EXACT>(substep, &mut lists, kept, scratch);
            if taken_all.is_err() {
                break;
            }
        }
        if taken_all.is_ok() && are_finite(lists.q) && are_finite(lists.p) {
            if C::CARRIES {
                carry.keep(lists.rooms.lost_q.as_ref(), lists.rooms.lost_p.as_ref());
            }
            if H::IS_FIXED {
                let [own_q, own_p] = arrays.each_ref().map(AsRef::as_ref);
                q.copy_from_slice(own_q);
                p.copy_from_slice(own_p);
            }
            if kept.origin.is_some() {
                kept.q.as_mut().copy_from_slice(q);
            }
            return Ok(Effort::fast(0));
        }
        kept.origin = None;
        if !H::IS_FIXED {
            q.copy_from_slice(kept.q.as_ref());
            p.copy_from_slice(first_p.as_ref());
        }
        Err(taken_all.err().unwrap_or(StepFailure::NonFinite))
    }
}

/// The state to which the parts lead from the start of a segment, and the sum of their discrete Lagrangians.
/// `action_of` gives that of one part from the states before and after it. `None` if a part fails.
pub(crate) fn follow<V: Vector, H: Shape, P>(
    parts: &mut impl ListParts<f64, H, P>,
    word: &Word<P>,
    segment: &Segment<V>,
    dw: &[f64],
    action_of: impl Fn(&Substep<P>, [&[f64]; 2], [&[f64]; 2]) -> f64,
) -> Option<SequenceEnd<V>> {
    let (q0, p0) = (segment.q0.components(), segment.p.components());
    let (mut q, mut p) = (q0.to_vec(), p0.to_vec());
    let SplittingMemory { mut kept, mut rooms, mut scratch, .. } =
        SplittingMemory::<f64, H>::of_length(q0.len());
    let mut lists = SplittingLists { q: &mut q, p: &mut p, rooms: &mut rooms };
    let state = |lists: &SplittingLists<'_, f64, H>| [lists.q.to_vec(), lists.p.to_vec()];
    let mut action = 0.0;
    for substep in &word.substeps {
        scratch.dw = dw.iter().map(|dw| substep.share * dw).collect();
        let before = state(&lists);
        parts.take_part::<PlainSum, true>(substep, &mut lists, &mut kept, &mut scratch).ok()?;
        let after = state(&lists);
        action += action_of(
            substep,
            before.each_ref().map(|list| &list[..]),
            after.each_ref().map(|list| &list[..]),
        );
    }
    let [q, p] = state(&lists).map(|list| {
        let mut vector = V::zeros(list.len());
        vector.components_mut().copy_from_slice(&list);
        vector
    });
    Some(SequenceEnd { q, p, action })
}

/// `into ← into + slopes`
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn add<S: Scalar, C: StateSum<S>>(into: &mut [S], slopes: &[S], lost: &mut [S]) {
    if C::CARRIES {
        for ((into, &slope), lost) in into.iter_mut().zip(slopes).zip(lost) {
            (*into, *lost) = C::add(*into, slope, *lost);
        }
    } else {
        for (into, &slope) in into.iter_mut().zip(slopes) {
            *into = *into + slope;
        }
    }
}
