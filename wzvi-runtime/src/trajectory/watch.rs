//! Monitors the energy of runs of constant step.
//!
//! A step that is far too long for the orbit can be solved to the last digit, and still lead to a wrong
//! state. The energy reveals it. In a deterministic run of constant step, both ends of one step in eight are
//! tested; in a path of an ensemble few steps are, until one is off ([`EnergyMonitor::among_others`]):
//!
//! ```text
//! E_h = H                                   Midpoint, Gauss and their compositions (`KeptEnergy::Hamiltonian`)
//! E_h = H - h²/8 H_q · H_pp H_q             kick, drift, kick (`KeptEnergy::KickDriftKick`)
//! E_h = H + h (l - 1/2) H_q · H_p           one quadrature point l (`KeptEnergy::Point`)
//! A   = mean of |(p_i + p_{i+1})/2 · Δq/h| over the time so far
//! W   = min over the nodes of the last eight looks of |E_h - E_h(0)| / A
//! ```
//!
//! `W` is compared with a tenth. Each `E_h` is the modified energy to the order of the scheme, and an exact
//! first integral of every linear system `T(p) + V(q)`: with `V = ω² q²/2` a step of kick, drift, kick
//! conserves `p² + ω² (1 - h² ω²/4) q²`, one of the point `l` conserves `p² + ω² q² + (2l - 1) h ω² q p`, and
//! a mid-point conserves every quadratic form that the flow conserves. A stable linear motion therefore
//! changes `E_h` by rounding only, at any `ω h`. In others `E_h` changes in one step by one order in `h` more
//! than the order of the scheme, and oscillates over a run.
//!
//! Compositions of kicks and drifts conserve an energy near `H`, whose distance from `H` grows towards the
//! limit of stability. Their `E_h(0)` is the range of `H` over the first eight tests (`KeptEnergy::Nearly`),
//! so errors before that are not detected. The minimum ignores excursions that return, at a pericentre or on
//! the chord of a mid-point, and a stiff direction that is excited at every other node. `A` is the size of
//! the motion in units of energy, twice the kinetic energy of a mechanical system. Its mean does not grow
//! with the error, unlike its largest value. It depends on the origin of `p`.
//!
//! The conserved quantity of a step across a jump of `H` is that of the piece on either side, so `H` changes
//! by the jump. Where no proof says that `H` is continuous ([`EnergyWatch`]), the change that brings the
//! energy off is looked for on the chord in phase space between the states of both tests: if at least half of
//! it is a jump ([`Jumps`]), the reference becomes the energy behind it. Where the text of `H` shows a jump,
//! nothing is monitored.
//!
//! An energy that is not a number ends a run at once, in a test or at its end: the state has left the domain
//! of `H`.
//!
//! As long as the last test found nothing, `H` itself is compared with the reference first, and `E_h` is
//! computed only where `H` is off by more than `A/10`: a run that keeps `H` is no wrong one. A test evaluates
//! the energy site by site, which costs several steps that go tile by tile. In a system of 96 degrees of
//! freedom or more, one step in 64 is tested after the first 64 steps and the one 64 steps before the end,
//! until one is off, unless its steps may be halved or its energy may jump. A run that is not monitored
//! computes no energy; if its steps may be halved, it adds up `A`, which decides whether halves agree.
//!
//! The tested step is not always the same one of eight: a motion whose period is a multiple of eight steps
//! would have the same phase in each test.

use crate::algebra::scalar::{Dual, Rounded};
use crate::algebra::state::{State, Vector, copy_state, dot};
use crate::error::{StepError, StepFailure};
use crate::scheme::elements::LEAST_IN_TILES;
use crate::scheme::plan::{EnergyWatch, KeptEnergy};
use crate::scheme::system::{Discretized, Hamiltonian};

/// One step of so many is tested.
const STRIDE: u64 = 8;
/// Consecutive tests in which the energy must be off: 64 steps.
const SPAN: usize = 8;
/// The steps that they span.
const TAIL: u64 = STRIDE * SPAN as u64;
/// One step of so many is tested in a large system whose energy is right.
const LONG_STRIDE: u64 = 64;
/// How far the energy may be off, in units of the mean of `p · dq/dt`. Resolved motions of all kinds stay
/// below 0.031, and those that are wrong leave the constant energy by a multiple of their kinetic energy.
const HARMFUL: f64 = 0.1;
/// The largest disagreement of the halves of one divided step, in the same units: 64 divided steps in a row,
/// all off to the same side, then stay below `HARMFUL`.
pub(crate) const AGREEMENT: f64 = HARMFUL / TAIL as f64;

/// How the energy of a run of this scheme is monitored.
const fn energy_watch<H: Discretized<E>, E>() -> EnergyWatch {
    match H::PLAN.energy_watch() {
        // Not every jump between two tests is seen on the chord between them.
        EnergyWatch::Discontinuous => EnergyWatch::Never,
        watch if H::PROPERTIES.is_variational => watch,
        watch if H::PROPERTIES.is_clocked => watch,
        _ => EnergyWatch::Never,
    }
}

/// Whether the energy of a run of this scheme is monitored.
pub(crate) const fn keeps_energy<H: Discretized<E>, E>() -> bool {
    !matches!(energy_watch::<H, E>(), EnergyWatch::Never)
}

/// Whether no proof says that the monitored energy is continuous.
const fn may_jump<H: Discretized<E>, E>() -> bool {
    matches!(energy_watch::<H, E>(), EnergyWatch::Undecided)
}

/// The size of the motion so far: the mean of `|(p_i + p_{i+1})/2 · Δq/h|` over some steps, each with the
/// weight `h` of its length.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct MotionSize {
    steps: u64,
    /// `Σ |(p_i + p_{i+1})/2 · Δq|`
    action: f64,
    /// `Σ |h|`
    time: f64,
}

impl MotionSize {
    /// Adds the step of size `h` between these states.
    pub(crate) fn add<V: Vector>(&mut self, h: f64, [before, after]: [&State<V>; 2]) {
        let ends = before.q.components().iter().zip(after.q.components());
        let momenta = before.p.components().iter().zip(after.p.components());
        let moved: f64 = momenta.zip(ends).map(|((p0, p1), (q0, q1))| (q1 - q0) * (p1 + p0)).sum();
        self.steps += 1;
        self.action += 0.5 * moved.abs();
        self.time += h.abs();
    }

    /// Its mean, if there is one.
    pub(crate) fn mean(self) -> Option<f64> {
        (self.steps > 0).then(|| self.action / self.time)
    }
}

/// The step that a single path looks at after this one.
pub(crate) fn next_look(step: u64) -> u64 {
    let group = step / STRIDE + 1;
    STRIDE * group + 5 * group % STRIDE
}

/// The step that a large system, whose energy is right, looks at after this one: each phase of 64 steps in
/// turn, far from the one before.
fn next_rare_look(step: u64) -> u64 {
    let group = step / LONG_STRIDE + 1;
    LONG_STRIDE * group + 39 * group % LONG_STRIDE
}

/// The energy of a run so far.
#[derive(Clone, Debug)]
pub(crate) struct EnergyMonitor<V> {
    /// The next step to test; the largest number if nothing is monitored.
    next: u64,
    /// The steps of a path of an ensemble, which is tested rarely as long as its energy is right.
    steps: Option<u64>,
    /// Whether it is the energy that is monitored, or `A` alone.
    is_of_energy: bool,
    /// Whether a large system is tested rarely as long as its energy is right.
    is_sparing: bool,
    /// The steps of the run, if they are known.
    end: u64,
    suspected: u64,
    /// `E_h` at the start: the least and the largest of the first looks where a scheme keeps it nearly.
    band: [f64; 2],
    /// The size of the motion over all tests.
    motion: MotionSize,
    /// The deviation of the energy before the tested step; and at the last tests, the smaller one of both
    /// ends.
    off: f64,
    recent: [f64; SPAN],
    /// Whether jumps are looked for: from the end of the last tested step and its energy.
    follows_jumps: bool,
    last: Option<Box<(State<V>, f64)>>,
    /// Made by the first look, and away in each.
    room: Option<Box<MonitorScratch<V>>>,
}

/// The work space of a test, and the start of its step.
#[derive(Clone, Debug)]
pub(crate) struct MonitorScratch<V> {
    before: State<V>,
    /// Its `E_h`.
    energy_before: f64,
    /// Whether the `H` that was computed last is not a number.
    is_undefined: bool,
    slopes: [V; 2],
    dual: [Vec<Dual<1>>; 4],
}

impl<V> Default for EnergyMonitor<V> {
    /// A monitor of nothing.
    fn default() -> Self {
        let recent = [0.0; SPAN];
        let (band, motion, room) = ([0.0; 2], MotionSize::default(), None);
        let (next, steps, is_of_energy, suspected, off) = (u64::MAX, None, false, 0, 0.0);
        let (is_sparing, end, follows_jumps, last) = (false, u64::MAX, false, None);
        Self {
            next,
            steps,
            is_of_energy,
            is_sparing,
            end,
            suspected,
            band,
            motion,
            off,
            recent,
            follows_jumps,
            last,
            room,
        }
    }
}

impl<V: Vector> EnergyMonitor<V> {
    /// For a run by this scheme from step 0, if the system conserves its energy. Deviations are refused if it
    /// is monitored. Halved steps need `A` in any case, at the steps at which a path of an ensemble adds to
    /// it.
    pub(crate) fn of<H: Discretized<E, Vector = V>, E>(is_of_energy: bool, may_halve: bool) -> Self {
        let is_wanted = keeps_energy::<H, E>() && (is_of_energy || may_halve);
        let next = if is_wanted { 0 } else { u64::MAX };
        let (follows_jumps, is_sparing) =
            (is_of_energy && may_jump::<H, E>(), !may_halve && !may_jump::<H, E>());
        Self { next, is_of_energy, is_sparing, follows_jumps, ..Self::default() }
    }

    /// The number of steps of the run: 64 steps before it ends, a large system is tested too, as a path of an
    /// ensemble is.
    pub(crate) fn ends_after(&mut self, steps: u64) {
        self.end = steps;
    }

    /// For a path of an ensemble, of so many steps; deviations are refused. It is tested at the start, then
    /// at eight times the step of the last test, and 64 steps before the end. After a deviation it is tested
    /// like a single run, until the deviation ends. A path thus pays for four tests in its first thousand
    /// steps and one more for eight times as many, and deviations up to 64 steps before its end are found.
    /// If `H` may jump it is always tested like a single run, because jumps between rare tests are not seen.
    pub(crate) fn among_others<H: Discretized<E, Vector = V>, E>(steps: u64) -> Self {
        let next = if keeps_energy::<H, E>() && steps > TAIL { 0 } else { u64::MAX };
        let is_rare = const { !may_jump::<H, E>() };
        let steps = is_rare.then_some(steps);
        Self { next, steps, is_of_energy: true, follows_jumps: may_jump::<H, E>(), ..Self::default() }
    }

    /// Begins with the next path.
    pub(crate) fn restart<H: Discretized<E, Vector = V>, E>(&mut self, steps: u64) {
        *self = Self { room: self.room.take(), ..Self::among_others::<H, E>(steps) };
    }

    /// The step to look at.
    pub(crate) fn next_tested(&self) -> u64 {
        self.next
    }

    /// Whether this step is tested.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn looks_at(&self, step: u64) -> bool {
        step == self.next
    }

    /// How many looks found an energy that was off by more than a tenth of the mean of `p · dq/dt`.
    pub(crate) fn suspected(&self) -> u64 {
        self.suspected
    }

    /// The mean of `|p · Δq/h|`, if there is one.
    pub(crate) fn mean_motion(&self) -> Option<f64> {
        self.motion.mean()
    }

    /// Before a tested step of size `h`: prepares [`EnergyMonitor::end`].
    #[inline(never)]
    pub(crate) fn begin<H: Discretized<E, Vector = V>, E>(
        &mut self,
        system: &H,
        h: f64,
        state: &State<V>,
    ) -> Box<MonitorScratch<V>> {
        let mut room = self.room.take().unwrap_or_else(|| Box::new(MonitorScratch::of(state)));
        copy_state(&mut room.before, state);
        if !self.is_of_energy {
            return room;
        }
        let energy = self.test::<H, E>(&mut room, system, state, h);
        if self.motion.steps == 0 {
            self.band = [energy; 2];
        }
        if const { may_jump::<H, E>() }
            && let (Some(scale), Some(last)) = (self.motion.mean(), self.last.take())
        {
            self.follow::<H, E>(system, [(&last.0, last.1), (state, energy)], scale);
            self.last = Some(last);
        }
        room.energy_before = energy;
        self.off = self.distance::<H, E>(energy);
        room
    }

    /// `E_h`; or the reference, if nothing was off at the last test and `H` is right.
    fn test<H: Discretized<E, Vector = V>, E>(
        &self,
        room: &mut MonitorScratch<V>,
        system: &H,
        state: &State<V>,
        h: f64,
    ) -> f64 {
        let energy = system.energy(state);
        room.is_undefined = energy.is_nan();
        let is_compared = const {
            let keeps_itself =
                matches!(H::PROPERTIES.kept_energy, KeptEnergy::Hamiltonian | KeptEnergy::Nearly);
            !keeps_itself && !may_jump::<H, E>()
        };
        if is_compared && let Some(scale) = self.motion.mean() {
            let (harmful, [least, largest]) = (HARMFUL * scale, self.band);
            let last = self.recent[((self.motion.steps - 1) % SPAN as u64) as usize];
            if last <= harmful && energy >= least - harmful && energy <= largest + harmful {
                return energy.max(least).min(largest);
            }
        }
        room.kept_energy::<H, E>(system, state, h, energy)
    }

    /// After a change of the energy between two states: moves the reference to the second energy if the
    /// change is a jump.
    #[cold]
    fn follow<H: Discretized<E, Vector = V>, E>(
        &mut self,
        system: &H,
        [(before, earlier), (after, later)]: [(&State<V>, f64); 2],
        scale: f64,
    ) {
        let change = later - earlier;
        // No deviation comes from so little.
        if change.abs() <= AGREEMENT * scale {
            return;
        }
        let [least, largest] = self.band;
        // The least shift of the reference after which the energy is right.
        let shift = if later < least { later - least } else { (later - largest).max(0.0) };
        if shift.abs() > HARMFUL * scale
            && (change - Jumps::between(system, [before, after]).sum(change)).abs() <= 0.5 * change.abs()
        {
            self.band = [least + shift, largest + shift];
            self.recent = [0.0; SPAN];
        }
    }

    /// After an event in this step: the energy has another reference from the next step on.
    pub(crate) fn begin_anew(&mut self, step: u64) {
        if self.next != u64::MAX {
            let (room, suspected, end) = (self.room.take(), self.suspected, self.end);
            let Self { is_of_energy, is_sparing, follows_jumps, steps, .. } = *self;
            *self = Self {
                next: step + 1,
                steps,
                is_of_energy,
                is_sparing,
                end,
                suspected,
                follows_jumps,
                room,
                ..Self::default()
            };
        }
    }

    /// At the end of a run.
    ///
    /// # Errors
    /// [`StepFailure::UndefinedEnergy`]
    pub(crate) fn arrive<H: Discretized<E, Vector = V>, E>(
        &self,
        system: &H,
        state: &State<V>,
    ) -> Result<(), StepFailure> {
        let is_left = const { keeps_energy::<H, E>() } && self.is_of_energy && system.energy(state).is_nan();
        if is_left { Err(StepFailure::UndefinedEnergy) } else { Ok(()) }
    }

    /// After that step, which led to this state.
    ///
    /// # Errors
    /// [`StepFailure::Unresolved`] or [`StepFailure::UndefinedEnergy`]; the state is then what it was before
    /// the step.
    #[inline(never)]
    pub(crate) fn end<H: Discretized<E, Vector = V>, E>(
        &mut self,
        mut room: Box<MonitorScratch<V>>,
        system: &H,
        h: f64,
        state: &mut State<V>,
        step: u64,
    ) -> Result<(), StepError> {
        if !self.is_of_energy {
            self.motion.add(h, [&room.before, state]);
            (self.next, self.room) = (next_look(self.next), Some(room));
            return Ok(());
        }
        // A stiff direction that alternates may excite every other node only.
        let energy = self.test::<H, E>(&mut room, system, state, h);
        if const { may_jump::<H, E>() } {
            let mut motion = self.motion;
            motion.add(h, [&room.before, state]);
            let scale = motion.mean().unwrap_or(f64::NAN);
            self.follow::<H, E>(system, [(&room.before, room.energy_before), (state, energy)], scale);
            match &mut self.last {
                Some(last) => {
                    copy_state(&mut last.0, state);
                    last.1 = energy;
                }
                last => *last = Some(Box::new((state.clone(), energy))),
            }
        }
        let off = self.off.min(self.distance::<H, E>(energy));
        let judged = match room.is_undefined {
            true => Err(StepFailure::UndefinedEnergy),
            false => self.judge::<H, E>(system, [&room.before, state], h, step, off),
        };
        if judged.is_err() {
            copy_state(state, &room.before);
        }
        self.room = Some(room);
        judged.map_err(|cause| StepError { step, t: state.t, h, cause })
    }

    /// By how much this energy is off.
    fn distance<H: Discretized<E>, E>(&mut self, energy: f64) -> f64 {
        let [least, largest] = &mut self.band;
        if matches!(H::PROPERTIES.kept_energy, KeptEnergy::Nearly) && self.motion.steps < SPAN as u64 {
            (*least, *largest) = (least.min(energy), largest.max(energy));
        }
        // NaN stays.
        if energy < *least {
            *least - energy
        } else if energy > *largest {
            energy - *largest
        } else {
            0.0 * energy
        }
    }

    fn judge<H: Discretized<E, Vector = V>, E>(
        &mut self,
        system: &H,
        ends: [&State<V>; 2],
        h: f64,
        step: u64,
        error: f64,
    ) -> Result<(), StepFailure> {
        if let Some(place) = self.recent.get_mut((self.motion.steps % SPAN as u64) as usize) {
            *place = error;
        }
        self.motion.add(h, ends);
        let (looks, scale) = (self.motion.steps, self.motion.mean().unwrap_or(f64::NAN));
        let harmful = HARMFUL * scale;
        let is_off = error > harmful && error > harmful + rounding::<H, E>(system, ends[1], step, scale);
        let is_learning = matches!(H::PROPERTIES.kept_energy, KeptEnergy::Nearly) && looks < SPAN as u64;
        let is_large = ends[1].q.components().len() >= LEAST_IN_TILES;
        self.next = self.after(self.next, is_off || is_learning, is_large);
        if !is_off {
            return Ok(());
        }
        self.suspected += 1;
        let least = self.recent.iter().fold(f64::INFINITY, |least, error| least.min(*error));
        if looks >= SPAN as u64 && least > harmful {
            let may_jump = const { may_jump::<H, E>() };
            return Err(StepFailure::Unresolved { energy_error: least, scale, may_jump });
        }
        Ok(())
    }

    /// The step to look at after this one.
    fn after(&self, step: u64, is_soon: bool, is_large: bool) -> u64 {
        match self.steps.map(|steps| steps.saturating_sub(TAIL)) {
            Some(last) if !is_soon && step < last => last.min(TAIL.max(step.saturating_mul(8))),
            Some(_) if !is_soon => u64::MAX,
            None if !is_soon && self.is_sparing && is_large && step >= TAIL => {
                let last = self.end.saturating_sub(TAIL);
                if step < last { next_rare_look(step).min(last) } else { next_rare_look(step) }
            }
            _ => next_look(step),
        }
    }

    /// Passes the memory of the monitor to the tape of a checkpoint; `state` has the size of the system.
    pub(crate) fn pass(&mut self, state: &State<V>, tape: &mut crate::ground::numbers::Tape) {
        let Self { next, suspected, band, motion, recent, follows_jumps, last, .. } = self;
        [next, &mut motion.steps, suspected].into_iter().for_each(|word| tape.word(word));
        tape.numbers([&mut motion.action, &mut motion.time]);
        tape.numbers(band);
        tape.numbers(recent);
        if *follows_jumps {
            let mut has_last = last.is_some();
            tape.flag(&mut has_last);
            if has_last {
                let last = last.get_or_insert_with(|| Box::new((state.clone(), 0.0)));
                last.0.pass(tape);
                tape.number(&mut last.1);
            }
        }
    }
}

impl<V: Vector> MonitorScratch<V> {
    fn of(state: &State<V>) -> Self {
        let slopes = [&state.q, &state.p].map(|vector| V::zeros(vector.components().len()));
        let (energy_before, is_undefined) = (0.0, false);
        Self { before: state.clone(), energy_before, is_undefined, slopes, dual: Default::default() }
    }

    /// `E_h` where `H` is this `energy`.
    fn kept_energy<H: Discretized<E, Vector = V>, E>(
        &mut self,
        system: &H,
        state: &State<V>,
        h: f64,
        energy: f64,
    ) -> f64 {
        if const { matches!(H::PROPERTIES.kept_energy, KeptEnergy::Hamiltonian | KeptEnergy::Nearly) } {
            return energy;
        }
        let [by_q, by_p] = &mut self.slopes;
        let (q, p) = (state.q.components(), state.p.components());
        system.differentiate(0, q, p, state.t, by_q.components_mut(), by_p.components_mut());
        if let KeptEnergy::Point(l) = H::PROPERTIES.kept_energy {
            return energy + h * (l - 0.5) * dot(by_q, by_p);
        }
        if const { matches!(H::PROPERTIES.kept_energy, KeptEnergy::KickDriftKick) } {
            // `H_p(q, p + ε H_q)`
            let [along_q, along_p, out_q, out_p] = &mut self.dual;
            let along = |into: &mut Vec<Dual<1>>, from: &[f64], slope: &dyn Fn(usize) -> f64| {
                let numbers = from.iter().enumerate();
                into.clear();
                into.extend(numbers.map(|(i, &value)| Dual { value, derivative: [slope(i)] }));
            };
            let by_q = by_q.components();
            along(along_q, q, &|_| 0.0);
            along(along_p, p, &|i| by_q.get(i).copied().unwrap_or(0.0));
            for out in [&mut *out_q, &mut *out_p] {
                out.resize(q.len(), Dual::constant(0.0));
            }
            system.differentiate(0, along_q, along_p, state.t, out_q, out_p);
            let bent: f64 = by_q.iter().zip(&*out_p).map(|(force, slope)| force * slope.derivative[0]).sum();
            return energy - 0.125 * h * h * bent;
        }
        energy
    }
}

/// Halvings of a chord after which the change of the energy is noted, and after which the search ends.
const COARSE: u32 = 20;
const FINE: u32 = 36;
/// The most energies that are computed in one search.
const EFFORT: usize = 256;
/// Jumps below this share of the whole change are not looked for.
const LEAST_SHARE: f64 = 1.0 / 16.0;

/// The jumps of `H` on the chord between two states.
///
/// The part of the chord with the largest change of the energy is halved again and again, until no change is
/// above a sixteenth of the whole one. A change that is left on the `2⁻³⁶`th part of the chord is a jump if
/// it is the same there as on the `2⁻²⁰`th part around it. What is continuous like `|x|^a` falls by
/// `2^(-16a)` between the two, to nine tenths for `a = 0.01`; at a pole the change grows.
struct Jumps<'s, H: Hamiltonian> {
    system: &'s H,
    ends: [&'s State<H::Vector>; 2],
    /// A point of the chord.
    point: State<H::Vector>,
}

/// A part of a chord: its ends as shares of the chord, their energies, how often the chord was halved, and
/// the change on the part of `2^-COARSE` around it.
#[derive(Clone, Copy)]
struct ChordPart {
    ends: [f64; 2],
    energies: [f64; 2],
    depth: u32,
    coarse: f64,
}

impl ChordPart {
    fn change(&self) -> f64 {
        self.energies[1] - self.energies[0]
    }

    fn is_steady(&self) -> bool {
        (self.change() - self.coarse).abs() <= 0.1 * self.change().abs()
    }
}

impl<'s, H: Hamiltonian> Jumps<'s, H> {
    fn between(system: &'s H, ends: [&'s State<H::Vector>; 2]) -> Self {
        Self { system, ends, point: ends[0].clone() }
    }

    /// The sum of the jumps, of those that are not much less than this change.
    fn sum(mut self, change: f64) -> f64 {
        let energies = self.ends.map(|state| self.system.energy(state));
        let mut pieces = vec![ChordPart { ends: [0.0, 1.0], energies, depth: 0, coarse: f64::INFINITY }];
        let mut sum = 0.0;
        for _ in 0..EFFORT {
            let sizes = pieces.iter().map(|piece| piece.change().abs()).enumerate();
            // The comparison leaves NaN out: what is no number is no jump.
            let largest = sizes.fold((0, 0.0), |most, piece| if piece.1 > most.1 { piece } else { most });
            if largest.1 <= LEAST_SHARE * change.abs() {
                break;
            }
            let piece = pieces.swap_remove(largest.0);
            if piece.depth == FINE {
                sum += if piece.is_steady() { piece.change() } else { 0.0 };
                continue;
            }
            let ChordPart { ends: [start, end], energies: [first, last], depth, coarse } = piece;
            let middle = 0.5 * (start + end);
            let (energy, depth) = (self.energy(middle), depth + 1);
            for (ends, energies) in [([start, middle], [first, energy]), ([middle, end], [energy, last])] {
                let half = ChordPart { ends, energies, depth, coarse };
                pieces.push(if depth == COARSE { ChordPart { coarse: half.change(), ..half } } else { half });
            }
        }
        sum
    }

    /// At this share of the chord.
    fn energy(&mut self, share: f64) -> f64 {
        let ([from, to], point) = (self.ends, &mut self.point);
        let lists = [(&mut point.q, &from.q, &to.q), (&mut point.p, &from.p, &to.p)];
        for (into, from, to) in lists {
            let ends = from.components().iter().zip(to.components());
            for (into, (from, to)) in into.components_mut().iter_mut().zip(ends) {
                *into = from + share * (to - from);
            }
        }
        point.t = from.t + share * (to.t - from.t);
        self.system.energy(point)
    }
}

/// The rounding error of the energy up to this state, `n r max(1, s (s + 1) √(R/A))`. `r` is the difference
/// of the energies of all states that round to this one, in each of `n` steps and at the start; stiff steps
/// err to one side. A step that is long for a linear motion has larger roundings, because its increments are
/// differences of stages that are `ωh` times as large. `R = r/ε` is the size of the terms of the energy. For
/// `s` stages, of order `2s`, `A = O(R) (s (s + 1) / ωh)²`, from the Padé approximation at infinity. A
/// composition has the `s` of its parts, whose weights are of the size of one; its higher order does not
/// matter for rounding. Explicit steps and their compositions have no stages, `s = 0`: each part adds its
/// values to the state, and is stable only where these are at most as large as the state.
#[cold]
fn rounding<H: Discretized<E>, E>(system: &H, state: &State<H::Vector>, step: u64, motion: f64) -> f64 {
    let lift =
        |of: &H::Vector| -> Vec<Rounded> { of.components().iter().copied().map(Rounded::nearest).collect() };
    let error = system.evaluate(0, &lift(&state.q), &lift(&state.p), state.t).error;
    let stages = f64::from(H::PROPERTIES.stages);
    let longer = (stages * (stages + 1.0) * (error / f64::EPSILON / motion).sqrt()).max(1.0);
    (step + 2) as f64 * error * longer
}

/// How much energy depends on which of two ends of the same step is right, `Σ_i |H_q δq| + |H_p δp|`, and the
/// energy that moves in the step, `Σ_i |p H_p| + |Δq H_q|`, from its start to the second of them: terms of
/// one degree of freedom each, so that no unit counts.
#[cold]
pub(crate) fn disagreement<H: Hamiltonian>(
    system: &H,
    start: &State<H::Vector>,
    ends: [&State<H::Vector>; 2],
) -> (f64, f64) {
    let [coarse, fine] = ends;
    let slopes = system.energy_gradient(fine);
    let weighed = |slopes: &H::Vector, to: &H::Vector, from: Option<&H::Vector>| -> f64 {
        let from = |i: usize| from.and_then(|from| from.components().get(i).copied()).unwrap_or(0.0);
        let terms = slopes.components().iter().zip(to.components()).enumerate();
        terms.map(|(i, (slope, to))| (slope * (to - from(i))).abs()).sum()
    };
    let apart = weighed(&slopes.q, &fine.q, Some(&coarse.q)) + weighed(&slopes.p, &fine.p, Some(&coarse.p));
    (apart, weighed(&slopes.p, &fine.p, None) + weighed(&slopes.q, &fine.q, Some(&start.q)))
}
