//! The parts of a step that are flows, and the scratch, sums and checks of all kinds of flows.

use super::gradient::Directional;
use super::lagrangian::SequenceEnd;
use super::substeps::{Half, Substep};
use super::tiled;
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

/// The parts of a step.
#[derive(Clone, Debug)]
pub(crate) struct StageList<A = Half>(pub(crate) Vec<Stage<A>>);

/// A part of a step: the fraction `weight` of the flow of a whole step, at the fraction `node` of its time,
/// which the flows of the other kind have reached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stage<A = Half> {
    /// The action of the part.
    pub(crate) act: A,
    pub(crate) weight: f64,
    /// The fraction of time and increments: `weight` for the flow of `T`, `-weight` for that of `V`.
    pub(crate) share: f64,
    pub(crate) node: f64,
    /// Whether it is a kick that a step begins or ends with.
    pub(crate) is_end: bool,
}

/// The action of a stage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Act {
    /// A drift, or a kick.
    Flow(Half),
    /// A kick with so much of the square of the force.
    Square(f64),
    /// Friction and noise of a bath: an O part, by its number.
    Relax(usize),
    /// An O part between two drifts of the same weight.
    RelaxBetween(usize),
}

impl Act {
    /// The flow, if it is a kick or a drift.
    pub(crate) fn half(&self) -> Option<Half> {
        match self {
            Self::Flow(half) => Some(*half),
            Self::Square(_) => Some(Half::Second),
            Self::Relax(_) | Self::RelaxBetween(_) => None,
        }
    }
}

impl Stage {
    pub(crate) const fn new(half: Half, weight: f64, node: f64) -> Self {
        let share = if matches!(half, Half::First) { weight } else { -weight };
        Self { act: half, weight, share, node, is_end: false }
    }
}

impl<A> Stage<A> {
    /// This stage with another action.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) const fn with<B>(&self, act: B) -> Stage<B> {
        let Self { weight, share, node, is_end, .. } = *self;
        Stage { act, weight, share, node, is_end }
    }
}

impl StageList {
    /// Merges adjacent parts of the same kind.
    pub(crate) fn of(substeps: &[Substep]) -> Self {
        let mut stages: Vec<Stage> = Vec::new();
        let [mut first, mut second] = [0.0; 2];
        for &(half, weight) in substeps.iter().filter(|(_, weight)| *weight != 0.0) {
            match stages.last_mut() {
                Some(last) if last.act == half => *last = Stage::new(half, last.weight + weight, last.node),
                _ => stages.push(Stage::new(half, weight, if half == Half::First { second } else { first })),
            }
            *if half == Half::First { &mut first } else { &mut second } += weight;
        }
        // Each kind sums to 1 up to rounding.
        if let Some(last) = stages.last_mut() {
            last.node = 1.0;
        }
        Self(stages)
    }

    /// Their flows; the gradient has a factor for the square of the force in each, if there is any.
    pub(crate) fn flows(self, gradient: &[f64]) -> StageList<Act> {
        let factors = gradient.iter().copied().chain(std::iter::repeat(0.0));
        let flows = self.0.iter().zip(factors).map(|(stage, factor)| {
            let squares = stage.act == Half::Second && factor != 0.0;
            stage.with(if squares { Act::Square(factor) } else { Act::Flow(stage.act) })
        });
        StageList(flows.collect()).with_ends()
    }
}

impl StageList<Act> {
    /// Marks the first and the last flow if they are kicks.
    pub(crate) fn with_ends(mut self) -> Self {
        let mut flows = self.0.iter_mut().filter(|stage| stage.act.half().is_some());
        for end in [flows.next(), flows.next_back()].into_iter().flatten() {
            end.is_end = end.act.half() == Some(Half::Second);
        }
        self
    }
}

/// Lists of one number per degree of freedom.
type DegreeList<S, H> = <H as Shape>::List<S>;

/// The last force and where it acted, and scratch for a step.
#[derive(Debug)]
pub struct SplittingMemory<S: Scalar, H: Shape> {
    kept: Option<ForceTime>,
    /// `kept` with the derivatives that numbers carry.
    kept_at: [S; 2],
    /// The coordinates at which the force was evaluated; `kept_force` is the increment of the momenta.
    kept_q: DegreeList<S, H>,
    pub(crate) kept_force: DegreeList<S, H>,
    rooms: SplittingLists<S, H>,
    /// The noise increments of a part.
    pub(crate) dw: Vec<S>,
    pub(super) columns: PairColumns,
    /// For derivatives of derivatives; empty unless a table asks for them.
    pub(super) directional: Directional<S>,
    /// For large systems of elements.
    pub(crate) tiles: tiled::TiledMemory,
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

/// The lists of a step: coordinates, momenta, their rounding errors, and the increments of momenta and of
/// coordinates.
#[derive(Debug)]
pub(crate) struct SplittingLists<S: Scalar, H: Shape>(pub(crate) [DegreeList<S, H>; 6]);

impl<S: Scalar, H: Shape> SplittingLists<S, H> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn of_length(length: usize) -> Self {
        Self(std::array::from_fn(|_| H::list(length, S::from_f64(0.0))))
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
            self.kept = None;
        }
    }
}

impl<S: Scalar, H: Shape> StepMemory for SplittingMemory<S, H> {
    fn tell(&mut self, request: &MemoryRequest) {
        match request {
            MemoryRequest::Forget => self.kept = None,
            MemoryRequest::Share(threads) => self.tiles.share(*threads),
            _ => {}
        }
    }

    fn adopt(&mut self, _: Self) {}
}

impl<S: Scalar, H: Shape> SplittingMemory<S, H> {
    pub(crate) fn of_length(length: usize) -> Self {
        let list = || H::list(length, S::from_f64(0.0));
        Self {
            kept: None,
            kept_at: [S::from_f64(0.0); 2],
            kept_q: list(),
            kept_force: list(),
            rooms: SplittingLists::of_length(length),
            dw: Vec::new(),
            columns: PairColumns::default(),
            directional: Directional::default(),
            tiles: tiled::TiledMemory::default(),
        }
    }

    /// Allocates for these numbers of degrees of freedom and noises.
    #[cold]
    fn fit(&mut self, length: usize, noises: usize) {
        if self.length() != length {
            *self = Self { tiles: self.tiles.alike(), ..Self::of_length(length) };
        }
        self.dw.resize(noises, S::from_f64(0.0));
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn length(&self) -> usize {
        self.kept_q.as_ref().len()
    }

    /// Whether the kept force is that of this kick.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn has_force<K: Constant>(&self, origin: ForceTime<K>, reads_time: bool, q: &[S]) -> bool
    where
        S: ComputesWith<K>,
    {
        let Some(kept) = self.kept else { return false };
        let (t, h) = (origin.t.lane(0), origin.h.lane(0));
        if kept.h.to_bits() != h.to_bits() || (reads_time && kept.t.to_bits() != t.to_bits()) {
            return false;
        }
        if const { carry_derivatives::<S>() } {
            let [kept, now] = [self.kept_at, origin.list()];
            if !kept[1].is_identical(now[1]) || (reads_time && !kept[0].is_identical(now[0])) {
                return false;
            }
        }
        let mut is_same = true;
        for (&a, &b) in self.kept_q.as_ref().iter().zip(q) {
            is_same &= a.is_identical(b);
        }
        is_same
    }

    /// Keeps a force for the next step.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn keep_force<K: Constant>(&mut self, origin: ForceTime<K>, q: &[S], force: &[S])
    where
        S: ComputesWith<K>,
    {
        self.kept = Some(ForceTime { t: origin.t.lane(0), h: origin.h.lane(0) });
        if const { carry_derivatives::<S>() } {
            self.kept_at = origin.list();
        }
        self.kept_q.as_mut().copy_from_slice(q);
        self.kept_force.as_mut().copy_from_slice(force);
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

/// The flows of the parts of a step, and the O parts if there are any.
///
/// Not a closure: one that is called in several places is compiled without the vector instructions of its
/// callers.
pub(crate) trait StepParts<S: Scalar, H: Shape, A> {
    /// Moves the state in the lists by a part of a step, with the noise increments of that part in the
    /// memory.
    ///
    /// # Errors
    /// [`StepFailure::Bath`] where friction is negative.
    fn take_part<C: StateSum<S>>(
        &mut self,
        stage: &Stage<A>,
        lists: &mut SplittingLists<S, H>,
        memory: &mut SplittingMemory<S, H>,
    ) -> Result<(), StepFailure>;
}

/// Takes all parts of a step. On `Err`, `q`, `p` and `carry` are as they were.
///
/// # Errors
/// [`StepFailure::NonFinite`], the failure of a part, or that of sizes that do not fit.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn take_parts<S: Scalar, C: StateSum<S>, H: Shape, A>(
    system: &impl Hamiltonian,
    flows: &mut impl StepParts<S, H, A>,
    stages: &[Stage<A>],
    [q, p]: [&mut [S]; 2],
    dw: &[S],
    memory: &mut SplittingMemory<S, H>,
    carry: &mut C,
) -> Result<Effort, StepFailure> {
    let degrees = q.len();
    let is_ready = memory.length() == degrees && memory.dw.len() == dw.len();
    check_lengths(system, is_ready, [degrees, p.len(), dw.len()])?;
    if !is_ready {
        memory.fit(degrees, dw.len());
    }
    let mut rooms = H::lend(&mut memory.rooms, SplittingLists::of_length(0));
    let [next_q, next_p, lost_q, lost_p, ..] = &mut rooms.0;
    next_q.as_mut().copy_from_slice(q);
    next_p.as_mut().copy_from_slice(p);
    if C::CARRIES {
        let lost = lost_q.as_mut().iter_mut().zip(lost_p.as_mut());
        for (i, (lost_q, lost_p)) in lost.enumerate() {
            (*lost_q, *lost_p) = (carry.of_coordinate(i), carry.of_momentum(i));
        }
    }
    let mut taken_all = Ok(());
    for stage in stages {
        for (scaled, dw) in memory.dw.iter_mut().zip(dw) {
            *scaled = *dw * stage.share;
        }
        taken_all = flows.take_part::<C>(stage, &mut rooms, memory);
        if taken_all.is_err() {
            break;
        }
    }
    let [next_q, next_p, lost_q, lost_p, ..] = &rooms.0;
    let is_good = taken_all.is_ok() && are_finite(next_q.as_ref()) && are_finite(next_p.as_ref());
    if is_good {
        q.copy_from_slice(next_q.as_ref());
        p.copy_from_slice(next_p.as_ref());
        if C::CARRIES {
            carry.keep(lost_q.as_ref(), lost_p.as_ref());
        }
    }
    H::give_back(&mut memory.rooms, rooms);
    taken_all?;
    if is_good { Ok(Effort::fast(0)) } else { Err(StepFailure::NonFinite) }
}

/// The state to which the parts lead from the start of a segment, and the sum of their discrete Lagrangians.
/// `action_of` gives that of one part from the states before and after it. `None` if a part fails.
pub(crate) fn follow<V: Vector, H: Shape, A>(
    flows: &mut impl StepParts<f64, H, A>,
    stages: &[Stage<A>],
    segment: &Segment<V>,
    dw: &[f64],
    action_of: impl Fn(&Stage<A>, [&[f64]; 2], [&[f64]; 2]) -> f64,
) -> Option<SequenceEnd<V>> {
    let (q0, p0) = (segment.q0.components(), segment.p.components());
    let mut rooms = SplittingLists::<f64, H>::of_length(q0.len());
    let mut memory = SplittingMemory::of_length(q0.len());
    let state = |rooms: &SplittingLists<f64, H>| [0, 1].map(|half| rooms.0[half].as_ref().to_vec());
    rooms.0[0].as_mut().copy_from_slice(q0);
    rooms.0[1].as_mut().copy_from_slice(p0);
    let mut action = 0.0;
    for stage in stages {
        memory.dw = dw.iter().map(|dw| stage.share * dw).collect();
        let before = state(&rooms);
        flows.take_part::<PlainSum>(stage, &mut rooms, &mut memory).ok()?;
        let after = state(&rooms);
        action +=
            action_of(stage, before.each_ref().map(|list| &list[..]), after.each_ref().map(|list| &list[..]));
    }
    let [q, p] = state(&rooms).map(|list| {
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
