//! Drifts and kicks in turn: for `T(p) + V(q, t)`.
//!
//! With `F = h H_0 + Σ_k ΔW_k H_k = T(p) + V(q, t)` a drift of weight `a` is `q ← q + a ∂T/∂p`, a kick of weight `b` is
//! `p ← p - b ∂V/∂q`: the flows of the parts, both exact. A kick acts at the time that the drifts before it have reached,
//! `t + (a_1 + ... + a_j) h`, since time is a coordinate that the drift moves.
//!
//! What stands beside its like is one (an adjoint pair `DeltaPlus(b)`, `DeltaMinus(a)` is kick, drift, drift, kick), so that
//! every kick evaluates the force at a node of its own, once. Where a step ends with a kick the next one starts with the same force: it is
//! kept with the node, and taken if node, time and step size are the same to the last bit. Reuse is not to be seen in the
//! numbers, and checkpoints need not know of it.
//!
//! What a flow reads of the system is [`Field::slopes`]. Another kind of part (a kick by a modified potential, say) is a variant
//! of [`Half`], an arm of [`Turn::take`] and a method of [`Flows`].

use super::sequence::{Followed, Half, Sequence, Substep};
use crate::carry::{Carry, Plain};
use crate::elements::are_finite;
use crate::error::{ConfigError, StepFailure};
use crate::gauss::{Field, Shape};
use crate::memory::StepMemory;
use crate::numbers::{Numbers, Tape};
use crate::plan::Plan;
use crate::scalar::Scalar;
use crate::solve::Effort;
use crate::state::Vector;
use crate::system::Segment;

/// A system with `F = T(p) + V(q, t)`; generated.
pub trait Flows: Field {
    /// The plan of `Verlet`.
    const PLAN: Plan;
    /// Whether `V` reads the time.
    const FORCE_READS_TIME: bool;
    /// Whether [`Flows::add_force`] and [`Flows::add_velocity`] add without room of their own.
    const IN_PLACE: bool;
    /// `p ← p + ∂F/∂q`, only where it is [`Flows::IN_PLACE`].
    fn add_force<S: Scalar>(&self, t: f64, h: f64, q: &[S], dw: &[S], p: &mut [S]) {
        let _ = (t, h, q, dw, p);
    }

    /// `q ← q + ∂F/∂p`, only where it is [`Flows::IN_PLACE`].
    fn add_velocity<S: Scalar>(&self, t: f64, h: f64, p: &[S], dw: &[S], q: &mut [S]) {
        let _ = (t, h, p, dw, q);
    }
}

/// Drifts and kicks in turn.
#[derive(Clone, Copy, Debug)]
pub struct Splitting;

/// The parts of a step.
#[derive(Clone, Debug)]
pub struct Stages(Vec<Stage>);

/// A drift or a kick: the fraction `weight` of that of a whole step, at the fraction `node` of its time.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Stage {
    half: Half,
    weight: f64,
    node: f64,
}

impl Stage {
    /// Of time and increments, for the flow of `T` or of `-V`.
    #[inline(always)]
    fn share(&self) -> f64 {
        if self.half == Half::First { self.weight } else { -self.weight }
    }
}

impl Stages {
    /// With neighbours of one kind as one.
    fn of(substeps: &[Substep]) -> Self {
        let mut stages: Vec<Stage> = Vec::new();
        let mut node = 0.0;
        for &(half, weight) in substeps.iter().filter(|(_, weight)| *weight != 0.0) {
            match stages.last_mut() {
                Some(last) if last.half == half => last.weight += weight,
                _ => stages.push(Stage { half, weight, node }),
            }
            if half == Half::First {
                node += weight;
            }
        }
        // The drifts sum to 1, but for rounding.
        if let Some(last @ Stage { half: Half::Second, .. }) = stages.last_mut() {
            last.node = 1.0;
        }
        Self(stages)
    }
}

/// Lists of one number per degree of freedom.
type List<S, H> = <H as Shape>::Of<S>;

/// The last force and where it acted, and room for a step.
#[derive(Debug)]
pub struct Memory<S: Scalar, H: Shape> {
    kept: Option<Origin>,
    /// The coordinates that the force was evaluated at, and the increment of the momenta.
    kept_q: List<S, H>,
    kept_force: List<S, H>,
    rooms: Rooms<S, H>,
    /// The increments of a part.
    dw: Vec<S>,
}

/// Time and weighted step size of a force.
#[derive(Clone, Copy, Debug)]
struct Origin {
    t: f64,
    h: f64,
}

/// What a step computes.
#[derive(Debug)]
struct Rooms<S: Scalar, H: Shape> {
    q: List<S, H>,
    p: List<S, H>,
    /// What rounding took.
    lost_q: List<S, H>,
    lost_p: List<S, H>,
    force: List<S, H>,
    velocity: List<S, H>,
}

impl<S: Scalar, H: Shape> Rooms<S, H> {
    fn of_length(length: usize) -> Self {
        let list = || H::list(length, S::from_f64(0.0));
        Self { q: list(), p: list(), lost_q: list(), lost_p: list(), force: list(), velocity: list() }
    }

    /// The rooms, for the duration of a step.
    #[inline(always)]
    fn take(&mut self) -> Self {
        let zero = S::from_f64(0.0);
        let Self { q, p, lost_q, lost_p, force, velocity } = self;
        Self {
            q: H::take(q, zero),
            p: H::take(p, zero),
            lost_q: H::take(lost_q, zero),
            lost_p: H::take(lost_p, zero),
            force: H::take(force, zero),
            velocity: H::take(velocity, zero),
        }
    }

    /// Takes them back.
    #[inline(always)]
    fn give_back(&mut self, rooms: Self) {
        let Self { q, p, lost_q, lost_p, force, velocity } = rooms;
        H::give_back(&mut self.q, q);
        H::give_back(&mut self.p, p);
        H::give_back(&mut self.lost_q, lost_q);
        H::give_back(&mut self.lost_p, lost_p);
        H::give_back(&mut self.force, force);
        H::give_back(&mut self.velocity, velocity);
    }
}

impl<S: Scalar, H: Shape> Default for Memory<S, H> {
    fn default() -> Self {
        Self::of_length(0)
    }
}

/// The copy evaluates its first force itself, and allocates its own room.
impl<S: Scalar, H: Shape> Clone for Memory<S, H> {
    fn clone(&self) -> Self {
        Self::default()
    }
}

/// A force that is evaluated again is the same.
impl<S: Scalar, H: Shape> Numbers for Memory<S, H> {
    fn pass(&mut self, _: &mut Tape) {}
}

impl<S: Scalar, H: Shape> StepMemory for Memory<S, H> {
    fn forget(&mut self) {}
    fn adopt(&mut self, _: Self) {}
}

impl<S: Scalar, H: Shape> Memory<S, H> {
    fn of_length(length: usize) -> Self {
        let list = || H::list(length, S::from_f64(0.0));
        Self {
            kept: None,
            kept_q: list(),
            kept_force: list(),
            rooms: Rooms::of_length(length),
            dw: Vec::new(),
        }
    }

    /// Makes room for so many degrees of freedom and noises.
    #[cold]
    fn fit(&mut self, length: usize, noises: usize) {
        if self.length() != length {
            *self = Self::of_length(length);
        }
        self.dw.resize(noises, S::from_f64(0.0));
    }

    #[inline(always)]
    fn length(&self) -> usize {
        self.kept_q.as_ref().len()
    }

    /// Whether the force that is kept is that of a kick like this one.
    #[inline(always)]
    fn has_force<F: Flows>(&self, t: f64, h: f64, q: &[S]) -> bool {
        let Some(kept) = self.kept else { return false };
        if kept.h.to_bits() != h.to_bits() || (F::FORCE_READS_TIME && kept.t.to_bits() != t.to_bits()) {
            return false;
        }
        let mut is_same = true;
        for (&a, &b) in self.kept_q.as_ref().iter().zip(q) {
            is_same &= a.is_identical(b);
        }
        is_same
    }
}

impl<F: Flows> Sequence<F> for Splitting {
    const PLAN: Plan = F::PLAN;
    const REMEMBERS: bool = false;
    const IN_LANES: bool = !matches!(F::PLAN.noise, crate::plan::NoiseClass::None);
    type Prepared = Stages;
    type Memory<S: Scalar> = Memory<S, F::Shape>;
    type Compensated<S: Scalar> = <F::Shape as Shape>::Compensation<S>;
    type Carry<S: Scalar> = Plain;

    fn memory(system: &F, _: &[Substep]) -> Self::Memory<f64> {
        let mut memory = Memory::default();
        let degrees = system.degrees();
        if degrees != 0 && system.check(degrees).is_ok() {
            memory.fit(degrees, system.noises());
        }
        memory
    }

    fn prepare(system: &F, _: f64, substeps: &[Substep]) -> Result<Stages, ConfigError> {
        let mut parameters = (0..).map_while(|index| system.parameter(index));
        if parameters.any(|(_, value)| value.is_nan()) {
            return Err(ConfigError::Parameter);
        }
        match system.degrees() {
            0 => {}
            degrees => {
                if let Err(StepFailure::Index(error)) = system.check(degrees) {
                    return Err(ConfigError::Index(error));
                }
            }
        }
        Ok(Stages::of(substeps))
    }

    #[inline(always)]
    fn advance<S: Scalar, C: Carry<S>, const CAREFUL: bool>(
        system: &F,
        prepared: &Stages,
        t: f64,
        h: f64,
        q: &mut [S],
        p: &mut [S],
        dw: &[S],
        memory: &mut Self::Memory<S>,
        carry: &mut C,
    ) -> Result<Effort, StepFailure> {
        let degrees = q.len();
        if memory.length() != degrees || memory.dw.len() != dw.len() || !system.fits(degrees) {
            system.check(degrees)?;
            memory.fit(degrees, dw.len());
        }
        if p.len() != degrees {
            return Err(StepFailure::Dimension { expected: degrees, got: p.len() });
        }
        if dw.len() != system.noises() {
            return Err(StepFailure::Increments { expected: system.noises(), got: dw.len() });
        }
        let mut rooms = memory.rooms.take();
        rooms.q.as_mut().copy_from_slice(q);
        rooms.p.as_mut().copy_from_slice(p);
        if C::CARRIES {
            let lost = rooms.lost_q.as_mut().iter_mut().zip(rooms.lost_p.as_mut());
            for (i, (lost_q, lost_p)) in lost.enumerate() {
                (*lost_q, *lost_p) = (carry.of_coordinate(i), carry.of_momentum(i));
            }
        }
        let count = prepared.0.len();
        for (index, stage) in prepared.0.iter().enumerate() {
            let is_end = index == 0 || index + 1 == count;
            let turn = Turn { system, t: t + stage.node * h, h: stage.share() * h, is_end };
            for (scaled, dw) in memory.dw.iter_mut().zip(dw) {
                *scaled = *dw * stage.share();
            }
            turn.take::<S, C>(stage.half, &mut rooms, memory);
        }
        let Rooms { q: next_q, p: next_p, lost_q, lost_p, .. } = &rooms;
        let is_good = are_finite(next_q.as_ref()) && are_finite(next_p.as_ref());
        if is_good {
            q.copy_from_slice(next_q.as_ref());
            p.copy_from_slice(next_p.as_ref());
            if C::CARRIES {
                carry.keep(lost_q.as_ref(), lost_p.as_ref());
            }
        }
        memory.rooms.give_back(rooms);
        if is_good { Ok(Effort::fast(0)) } else { Err(StepFailure::NonFinite) }
    }

    /// A drift has the discrete Lagrangian `p · Δq - a T(p)`, a kick `-b V(q)`. Both sums of weights are 1, so that
    /// `T = F(q_0, ·) - V(q_0)` and `V = F(·, p_0) - T(p_0)` sum up to values of `F`, less `F(q_0, p_0)`.
    fn follow(
        system: &F,
        segment: &Segment<F::Vector>,
        dw: &[f64],
        substeps: &[Substep],
    ) -> Option<Followed<F::Vector>> {
        let (h, [q0, p0]) = (segment.h, [segment.q0.components(), segment.p.components()]);
        let value = |q: &[f64], p: &[f64], t: f64| {
            let noises = dw.iter().zip(1..).map(|(dw, term)| dw * system.evaluate(term, q, p, t));
            h * system.evaluate(0, q, p, t) + noises.sum::<f64>()
        };
        let mut rooms = Rooms::<f64, F::Shape>::of_length(q0.len());
        let mut memory = Memory::of_length(q0.len());
        rooms.q.as_mut().copy_from_slice(q0);
        rooms.p.as_mut().copy_from_slice(p0);
        system.check(q0.len()).ok()?;
        let mut action = value(q0, p0, segment.t);
        for stage in Stages::of(substeps).0 {
            let t = segment.t + stage.node * h;
            memory.dw = dw.iter().map(|dw| stage.share() * dw).collect();
            let before = rooms.q.as_ref().to_vec();
            let turn = Turn { system, t, h: stage.share() * h, is_end: false };
            turn.take::<f64, Plain>(stage.half, &mut rooms, &mut memory);
            let (q, p) = (rooms.q.as_ref(), rooms.p.as_ref());
            action -= stage.weight
                * if stage.half == Half::First { value(q0, p, segment.t) } else { value(q, p0, t) };
            action +=
                p.iter().zip(q.iter().zip(&before)).map(|(p, (q, before))| p * (q - before)).sum::<f64>();
        }
        let vector = |list: &[f64]| {
            let mut vector = F::Vector::zeros(list.len());
            vector.components_mut().copy_from_slice(list);
            vector
        };
        Some(Followed { q: vector(rooms.q.as_ref()), p: vector(rooms.p.as_ref()), action })
    }
}

/// A part of a step, with its [share](Stage::share) of time and increments.
struct Turn<'a, F> {
    system: &'a F,
    t: f64,
    h: f64,
    /// Whether it is the first part of a step, or the last one.
    is_end: bool,
}

impl<F: Flows> Turn<'_, F> {
    #[inline(always)]
    fn take<S: Scalar, C: Carry<S>>(
        &self,
        half: Half,
        rooms: &mut Rooms<S, F::Shape>,
        memory: &mut Memory<S, F::Shape>,
    ) {
        match half {
            Half::First => self.drift::<S, C>(rooms, &memory.dw),
            Half::Second => self.kick::<S, C>(rooms, memory),
        }
    }

    #[inline(always)]
    fn drift<S: Scalar, C: Carry<S>>(&self, rooms: &mut Rooms<S, F::Shape>, dw: &[S]) {
        let Rooms { q, p, lost_q, velocity, .. } = rooms;
        let (q, p, velocity) = (q.as_mut(), p.as_ref(), velocity.as_mut());
        if F::IN_PLACE && !C::CARRIES {
            return self.system.add_velocity(self.t, self.h, p, dw, q);
        }
        let (t, h) = (S::from_f64(self.t), S::from_f64(self.h));
        self.system.slopes::<S, false, true>(t, h, q, p, dw, &mut [], velocity);
        add::<S, C>(q, velocity, lost_q.as_mut());
    }

    #[inline(always)]
    fn kick<S: Scalar, C: Carry<S>>(&self, rooms: &mut Rooms<S, F::Shape>, memory: &mut Memory<S, F::Shape>) {
        let &Self { system, t, h, is_end } = self;
        let Rooms { q, p, lost_p, force, .. } = rooms;
        let (q, p) = (q.as_ref(), p.as_mut());
        if F::IN_PLACE && !C::CARRIES && !is_end {
            return system.add_force(t, h, q, &memory.dw, p);
        }
        let is_kept = is_end && memory.dw.is_empty();
        if is_kept && memory.has_force::<F>(t, h, q) {
            return add::<S, C>(p, memory.kept_force.as_ref(), lost_p.as_mut());
        }
        let by_q = force.as_mut();
        let (time, size) = (S::from_f64(t), S::from_f64(h));
        system.slopes::<S, true, false>(time, size, q, p, &memory.dw, by_q, &mut []);
        add::<S, C>(p, by_q, lost_p.as_mut());
        if is_kept {
            memory.kept = Some(Origin { t, h });
            memory.kept_q.as_mut().copy_from_slice(q);
            memory.kept_force.as_mut().copy_from_slice(by_q);
        }
    }
}

/// `into ← into + slopes`
#[inline(always)]
fn add<S: Scalar, C: Carry<S>>(into: &mut [S], slopes: &[S], lost: &mut [S]) {
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
