//! Steps in which something may happen: the end of a run by a clock, and events.
//!
//! A step goes from the node before it to the next one. What happens inside divides it into parts, each by a
//! [side step](crate::scheme::clock) of its own.

use crate::algebra::state::{State, Vector, copy_state};
use crate::algebra::state_sum::StateSum;
use crate::error::{ConfigError, StepError, StepFailure, wrong};
use crate::ground::digits::ShortestDecimal;
use crate::increments::{Interval, Noise};
use crate::scheme::clock::SideStepper;
use crate::scheme::dense::DenseOutput;
use crate::scheme::system::{Discretized, Scheme, SchemeOf};
use crate::trajectory::Error;
use crate::trajectory::between::{BetweenNodes, StepPart};
use crate::trajectory::events::{AfterEvent, Event, EventRules};
use crate::trajectory::options::Observable;
use crate::trajectory::recorded::Recorder;
use crate::trajectory::section::{Crossing, Direction, SectionWatch, SignSide, root, sign};
use crate::trajectory::span::{NodeGrid, NodeOrInside, projected};
use crate::trajectory::step::{Exchanged, StepInfo, Stepper, beside_scheme, zero_if_finite};
use crate::trajectory::steps::StepToTake;

/// The most events in one step.
const MOST_EVENTS: usize = 1000;
/// The most crossings that rounding does not tell apart, for each function: at a corner of walls each is
/// crossed once or twice, and a ball that comes to rest crosses for ever.
const MOST_IN_CROWD: usize = 4;
/// The most corrections of the length of a side step that ends at a crossing: the polynomial of the step is
/// near, and the secant method gains more digits each time.
const MOST_CORRECTIONS: u32 = 12;

/// The side steps of a scheme.
type SideStepsOf<H, E> = SideStepper<H, <SchemeOf<H, E> as Scheme<H>>::Unclocked>;

/// The noise of a step of any size, by fractions of the step.
pub(crate) struct StepNoise<'n, N> {
    pub(crate) noise: &'n mut Option<N>,
    pub(crate) interval: Interval,
    /// The size of the step.
    pub(crate) h: f64,
    /// Whether the size is its own, and not that of the run.
    pub(crate) is_own: bool,
}

impl<N: Noise> StepNoise<'_, N> {
    /// The increments over a part of the step.
    fn within(&mut self, part: [f64; 2], dw: &mut [f64]) -> Result<(), Error> {
        let Self { noise, interval, h, is_own } = self;
        if let Some(noise) = noise {
            if *is_own {
                noise.increments_of_own_size(interval, *h, part, dw)?;
            } else {
                noise.increments_within(interval, *h, part, dw)?;
            }
        }
        Ok(())
    }
}

/// A part of a step, between two states.
#[derive(Clone, Debug)]
pub(crate) struct StepPiece<V> {
    pub(crate) from: State<V>,
    pub(crate) to: State<V>,
    pub(crate) dw: Vec<f64>,
    /// Whether it is the whole step of the scheme.
    pub(crate) is_whole: bool,
}

/// A step that was taken, to look into.
pub(crate) struct StepLook<'l, N, V> {
    pub(crate) number: u64,
    pub(crate) noise: &'l mut Option<N>,
    pub(crate) dw: &'l [f64],
    /// The state at its end.
    pub(crate) end: &'l State<V>,
}

/// Follows a path through its steps.
pub(crate) struct Following<'a, H: Discretized<E>, E> {
    system: &'a H,
    rules: EventRules<'a, H::Vector>,
    /// The functions of crossings, with the number of the event and the direction that counts.
    functions: Vec<CrossingRule<'a, H::Vector>>,
    /// The sides of these functions.
    watch: SectionWatch<H::Vector>,
    /// Scratch: the sides at the start of a part of a step, and the crossings on the polynomial of the part.
    sides: Vec<SignSide<State<H::Vector>>>,
    found: Vec<FoundCrossing>,
    side: SideStepsOf<H, E>,
    /// The end of a run by a clock.
    end: Option<f64>,
    /// The direction of time.
    sign: f64,
    /// The events at given times in the order of the run, of which so many are past.
    times: Vec<TimedEvent>,
    past: usize,
    before: State<H::Vector>,
    /// Scratch: the start of a part of a step.
    from: Option<State<H::Vector>>,
    room: State<H::Vector>,
    dense: DenseOutput<H::Vector>,
    /// The last crossings.
    crowd: Crowd,
    /// The length of the last step, before the end of the run shortened it.
    whole: f64,
    /// The parts of the last step are the first `kept` of these.
    pieces: Vec<StepPiece<H::Vector>>,
    kept: usize,
    /// The events of the last step.
    pub(crate) happened: Vec<Event<H::Vector>>,
    /// Whether the run has ended, and whether an event has ended it.
    pub(crate) is_over: bool,
    has_ended_early: bool,
}

/// A function of the state whose zeros are events.
struct CrossingRule<'a, V> {
    number: usize,
    /// The direction that counts, if only one does.
    direction: Option<Direction>,
    value: Observable<'a, V>,
}

/// An event at a given time of the run.
#[derive(Clone, Copy)]
struct TimedEvent {
    number: usize,
    t: f64,
    /// A time that is a node up to rounding is that of the node.
    place: NodeOrInside,
}

/// A crossing in a part of a step.
#[derive(Clone, Copy)]
struct FoundCrossing {
    function: usize,
    direction: Direction,
    /// The time of the crossing on the polynomial.
    t: f64,
    /// The offset of the function there.
    offset: f64,
}

/// Crossings that rounding does not tell apart, one after the other: at one time, or of functions that had
/// not left the zeros of their last crossings.
#[derive(Clone, Copy)]
struct Crowd {
    /// The time of the last crossing.
    t: f64,
    events: usize,
}

/// An event to come.
struct NextEvent<V> {
    number: usize,
    /// The state where it happens.
    at: State<V>,
    /// The crossing that it is, if it is one.
    crossing: Option<FoundCrossing>,
}

/// The sign of a function before a time, in the direction `sign` of time, by its crossings; `None` if it has
/// none.
fn sign_before(found: &[FoundCrossing], function: usize, sign: f64, t: f64) -> Option<f64> {
    let crossings = || found.iter().filter(|crossing| crossing.function == function);
    let later = crossings().find(|crossing| sign * (crossing.t - t) >= 0.0);
    match (later, crossings().next_back()) {
        (Some(later), _) => Some(-later.direction.sign()),
        (None, last) => last.map(|last| last.direction.sign()),
    }
}

/// Takes `dw` from `later`.
pub(crate) fn subtract(dw: &[f64], later: &mut [f64]) {
    later.iter_mut().zip(dw).for_each(|(later, dw)| *later -= dw);
}

impl<'a, H: Discretized<E>, E> Following<'a, H, E> {
    pub(crate) fn new(
        system: &'a H,
        rules: EventRules<'a, H::Vector>,
        start: &State<H::Vector>,
        grid: &NodeGrid,
    ) -> Self {
        let (sign, end) = (grid.h.signum(), grid.end);
        let timed =
            rules.times().filter_map(|(number, t)| Some(TimedEvent { number, t, place: grid.place(t)? }));
        let mut times: Vec<TimedEvent> = timed.collect();
        times.sort_by(|a, b| (sign * a.t).total_cmp(&(sign * b.t)));
        let crossings = rules.crossings();
        let functions: Vec<_> = crossings
            .map(|(number, direction, value)| CrossingRule { number, direction, value: value.clone() })
            .collect();
        Self {
            system,
            watch: SectionWatch::new(functions.iter().map(|rule| &rule.value), start),
            functions,
            sides: Vec::new(),
            found: Vec::new(),
            rules,
            side: SideStepper::default(),
            end: end.filter(|_| H::PROPERTIES.is_clocked),
            sign,
            times,
            past: 0,
            before: start.clone(),
            from: None,
            room: start.clone(),
            dense: DenseOutput::of(start),
            crowd: Crowd { t: f64::NAN, events: 0 },
            whole: f64::NAN,
            pieces: Vec::new(),
            kept: 0,
            happened: Vec::new(),
            is_over: false,
            has_ended_early: false,
        }
    }

    /// The length of the last step, before an event or the end of the run shortened it.
    pub(crate) fn whole(&self) -> f64 {
        self.whole
    }

    /// The start of the last step.
    pub(crate) fn before(&self) -> &State<H::Vector> {
        &self.before
    }

    /// Whether a run that resumes at this node and time is before its end.
    ///
    /// # Errors
    /// [`ConfigError::Setting`] if it is not.
    pub(crate) fn check_resumed(&self, node: u64, t: f64) -> Result<(), ConfigError> {
        match self.end {
            Some(end) if node > 0 && self.is_past(t) => {
                let [t, end] = [t, end].map(ShortestDecimal);
                wrong(format!(
                    "the checkpoint of this run by a clock is at t = {t}, and its end is to be t = {end}: \
                     give a later end, or remove the file to start again"
                ))
            }
            _ => Ok(()),
        }
    }

    /// Acts at the start, at whose time there may be events.
    ///
    /// # Errors
    /// [`Error::Step`] where an action leads to no state of the system.
    pub(crate) fn begin(&mut self, state: &mut State<H::Vector>) -> Result<(), Error> {
        self.happened.clear();
        self.act_at_node(0, state).map_err(|cause| StepError { step: 0, t: state.t, h: 0.0, cause })?;
        Ok(())
    }

    /// Whether the path is on or past the end of a run by a clock.
    fn is_past(&self, t: f64) -> bool {
        self.end.is_some_and(|end| self.sign * (t - end) >= 0.0)
    }

    /// Takes a step of the stepper, and does what happens in it.
    ///
    /// # Errors
    /// [`Error::Step`] or [`Error::Noise`]; the state is then what it was.
    pub(crate) fn take<N: Noise, C: StateSum<f64>>(
        &mut self,
        stepper: &mut Stepper<'a, H, E, C>,
        step: StepToTake<'_, H::Vector, N>,
        size: f64,
    ) -> Result<StepInfo, Error> {
        let StepToTake { state, interval, noise, dw } = step;
        copy_state(&mut self.before, state);
        (self.kept, self.happened) = (0, Vec::new());
        let is_own = H::PROPERTIES.is_clocked;
        // The time at the end is that which the clock will have, to the last bit.
        let numbered = |error: StepError| StepError { step: interval.step, ..error };
        let h = match is_own && !dw.is_empty() {
            true => stepper.upcoming(state).map_err(numbered)? - state.t,
            false => size,
        };
        let interval = match is_own {
            // The number of the step, and its own time.
            true => Interval { start: state.t, h, step: interval.step },
            false => interval,
        };
        let mut noise = StepNoise { noise, interval, h, is_own };
        self.draw(&mut noise, size, dw)?;
        let exchanged = stepper.account().clone();
        let info = stepper.step(state, dw).map_err(numbered)?;
        if is_own {
            noise.h = state.t - self.before.t;
        }
        self.whole = noise.h;
        let outcome = self.divide(stepper, &exchanged, state, &mut noise, dw);
        if outcome.is_err() {
            copy_state(state, &self.before);
            stepper.set_exchanged(exchanged);
        }
        outcome.map(|()| info)
    }

    /// The increments of the whole step.
    fn draw<N: Noise>(
        &mut self,
        StepNoise { noise, interval, h, is_own }: &mut StepNoise<'_, N>,
        size: f64,
        dw: &mut [f64],
    ) -> Result<(), Error> {
        let Some(noise) = noise else { return Ok(()) };
        if *is_own {
            noise.increments_of_own_size(interval, *h, [0.0, 1.0], dw)?;
        } else if size == interval.h {
            noise.increments(interval, dw)?;
        } else {
            noise.increments_of_part(interval, size, dw)?;
        }
        Ok(())
    }

    /// Divides the step that led to `state` where something happens.
    fn divide<N: Noise, C: StateSum<f64>>(
        &mut self,
        stepper: &mut Stepper<'a, H, E, C>,
        exchanged: &Exchanged,
        state: &mut State<H::Vector>,
        noise: &mut StepNoise<'_, N>,
        dw: &mut [f64],
    ) -> Result<(), Error> {
        let mut from = self.from.take().unwrap_or_else(|| self.before.clone());
        copy_state(&mut from, &self.before);
        let mut is_whole = true;
        if let Some(end) = self.end.filter(|&end| self.is_past(state.t) && state.t != end) {
            self.part(noise, &from, end, dw, state)?;
            is_whole = false;
        }
        let last = state.t;
        while let Some(event) = self.event_in(stepper, noise, [&from, state], is_whole, dw)? {
            let NextEvent { number, at, crossing } = event;
            self.crowd = self.crowd_with(crossing, at.t);
            if self.happened.len() == MOST_EVENTS || self.crowd.events > MOST_IN_CROWD * self.functions.len()
            {
                return Err(self.too_many(&at, noise));
            }
            self.increments(noise, [from.t, at.t], dw)?;
            self.keep_piece([&from, &at], dw, false);
            from = self.act(number, at.clone()).map_err(|cause| self.failed(noise, cause))?;
            if self.is_over {
                break;
            }
            self.set_sides(crossing, [&at, &from]);
            is_whole = false;
            self.part(noise, &from, last, dw, state)?;
        }
        if self.is_over {
            copy_state(state, &from);
        } else {
            self.keep_piece([&from, state], dw, is_whole);
            self.is_over = self.is_past(last);
        }
        if !is_whole && Stepper::<H, E, C>::MAY_EXCHANGE {
            self.account_for_pieces(stepper, exchanged.clone())?;
        }
        // All that drove the step up to here.
        if !is_whole {
            self.increments(noise, [self.before.t, state.t], dw)?;
        }
        self.from = Some(from);
        self.act_at_node(noise.interval.step + 1, state).map_err(|cause| self.failed(noise, cause))?;
        // A clock begins anew at a state that it did not lead to.
        if !self.happened.is_empty() && !self.is_over && !H::PROPERTIES.is_clocked {
            stepper.go_on_from(state);
        }
        Ok(())
    }

    /// The first event in a part of a step.
    fn event_in<N: Noise, C: StateSum<f64>>(
        &mut self,
        stepper: &Stepper<'a, H, E, C>,
        noise: &mut StepNoise<'_, N>,
        [from, to]: [&State<H::Vector>; 2],
        is_whole: bool,
        dw: &[f64],
    ) -> Result<Option<NextEvent<H::Vector>>, Error> {
        if self.rules.is_empty() || from.t == to.t {
            return Ok(None);
        }
        if !self.functions.is_empty() && dw.is_empty() {
            if is_whole {
                stepper.fill([from, to], dw, &mut self.dense);
            } else {
                self.dense.fill_by_rates::<H, E>(self.system, [from, to], to.t - from.t, dw);
            }
        }
        self.next_event(noise, from, to)
    }

    /// Accounts for the energy that the parts of the step exchanged, in place of the step as a whole.
    #[cold]
    fn account_for_pieces<C: StateSum<f64>>(
        &mut self,
        stepper: &mut Stepper<'a, H, E, C>,
        mut exchanged: Exchanged,
    ) -> Result<(), Error> {
        let mut room = self.room.clone();
        for piece in self.pieces.iter().take(self.kept) {
            let StepPiece { from, to, dw, .. } = piece;
            let h = to.t - from.t;
            let step = self.side.step(self.system, from, h, dw, &mut room);
            step.map_err(|cause| StepError { step: stepper.steps(), t: from.t, h, cause })?;
            self.dense.fill_by_rates::<H, E>(self.system, [from, to], h, dw);
            let heats = self.side.exchanged(self.system, &mut exchanged.all);
            exchanged.add_heats_of(heats);
            exchanged.all += beside_scheme::<H, E>(self.system, [from, to], &self.dense, dw);
        }
        stepper.set_exchanged(exchanged);
        Ok(())
    }

    /// The last crossings with the next event.
    fn crowd_with(&self, crossing: Option<FoundCrossing>, t: f64) -> Crowd {
        let Some(crossing) = crossing else { return self.crowd };
        let is_apart = crossing.offset == 0.0 && t != self.crowd.t;
        Crowd { t, events: if is_apart { 0 } else { self.crowd.events + 1 } }
    }

    /// Keeps a part of the step.
    fn keep_piece(&mut self, [from, to]: [&State<H::Vector>; 2], dw: &[f64], is_whole: bool) {
        // An event at the start of a step, or at the same time as another one.
        if from.t == to.t && !is_whole {
            return;
        }
        match self.pieces.get_mut(self.kept) {
            Some(piece) => {
                copy_state(&mut piece.from, from);
                copy_state(&mut piece.to, to);
                piece.dw.copy_from_slice(dw);
                piece.is_whole = is_whole;
            }
            None => {
                let (from, to, dw) = (from.clone(), to.clone(), dw.to_vec());
                self.pieces.push(StepPiece { from, to, dw, is_whole });
            }
        }
        self.kept += 1;
    }

    fn too_many<N>(&self, at: &State<H::Vector>, noise: &StepNoise<'_, N>) -> Error {
        let cause = StepFailure::TooManyEvents { t: at.t, events: self.happened.len() };
        self.failed(noise, cause).into()
    }

    /// The error of the step.
    fn failed<N>(&self, noise: &StepNoise<'_, N>, cause: StepFailure) -> StepError {
        StepError { step: noise.interval.step, t: self.before.t, h: noise.h, cause }
    }

    /// A time as a fraction of the step.
    fn fraction<N>(&self, noise: &StepNoise<'_, N>, t: f64) -> f64 {
        ((t - self.before.t) / noise.h).clamp(0.0, 1.0)
    }

    /// The increments between two times of the step.
    fn increments<N: Noise>(
        &self,
        noise: &mut StepNoise<'_, N>,
        times: [f64; 2],
        dw: &mut [f64],
    ) -> Result<(), Error> {
        if dw.is_empty() {
            return Ok(());
        }
        let part = times.map(|t| self.fraction(noise, t));
        if part[0] == part[1] {
            dw.fill(0.0);
            return Ok(());
        }
        noise.within(part, dw)
    }

    /// A side step from a state to a time of the step, with the increments that it has there.
    fn part<N: Noise>(
        &mut self,
        noise: &mut StepNoise<'_, N>,
        from: &State<H::Vector>,
        to: f64,
        dw: &mut [f64],
        into: &mut State<H::Vector>,
    ) -> Result<(), Error> {
        self.increments(noise, [from.t, to], dw)?;
        let (system, h) = (self.system, to - from.t);
        if h == 0.0 {
            copy_state(into, from);
            return Ok(());
        }
        let step = self.side.step(system, from, h, dw, into);
        step.map_err(|cause| StepError { step: noise.interval.step, t: from.t, h, cause })?;
        into.t = to;
        Ok(())
    }

    /// The first event after `from` up to `to`, the end of the step. An event at a given time that is the end
    /// itself happens at the node.
    fn next_event<N: Noise>(
        &mut self,
        noise: &mut StepNoise<'_, N>,
        from: &State<H::Vector>,
        to: &State<H::Vector>,
    ) -> Result<Option<NextEvent<H::Vector>>, Error> {
        self.sides.clear();
        self.sides.extend_from_slice(self.watch.sides());
        self.found.clear();
        let crossing = match noise.noise {
            None => self.first_crossing(from, to),
            Some(_) => self.first_change(noise, from, to)?,
        };
        let inside = |event: &TimedEvent| {
            matches!(event.place, NodeOrInside::Inside(_)) && self.sign * (to.t - event.t) > 0.0
        };
        let timed = self.times.get(self.past).copied().filter(inside);
        match (crossing, timed) {
            (Some(crossing), Some(timed)) if self.sign * (crossing.at.t - timed.t) < 0.0 => {
                Ok(Some(crossing))
            }
            (_, Some(TimedEvent { number, t, .. })) => {
                let mut at = from.clone();
                let mut dw = vec![0.0; self.system.increments(from.q.components().len())];
                self.part(noise, from, t, &mut dw, &mut at)?;
                self.past += 1;
                Ok(Some(NextEvent { number, at, crossing: None }))
            }
            (crossing, None) => Ok(crossing),
        }
    }

    /// The first crossing on the polynomial of the step, put on the section by side steps.
    fn first_crossing(
        &mut self,
        from: &State<H::Vector>,
        to: &State<H::Vector>,
    ) -> Option<NextEvent<H::Vector>> {
        if self.functions.is_empty() {
            return None;
        }
        let sign = self.sign;
        let mut first: Option<(FoundCrossing, State<H::Vector>)> = None;
        let Self { functions, watch, dense, found, .. } = self;
        watch.follow(functions.iter().map(|rule| &rule.value), dense, &mut |crossing, offset| {
            let Crossing { section: function, direction, state } = crossing;
            let crossed = FoundCrossing { function, direction, t: state.t, offset };
            found.push(crossed);
            let counts = functions[function].direction.is_none_or(|wanted| wanted == direction);
            let is_first = first.as_ref().is_none_or(|(first, _)| sign * (crossed.t - first.t) < 0.0);
            if counts && is_first {
                first = Some((crossed, state));
            }
        });
        let (crossing, near) = first?;
        let CrossingRule { number, value, .. } = &self.functions[crossing.function];
        let (number, value) = (*number, value.clone());
        let at = match crossing.offset == 0.0 {
            true => self.put_on(&*value, from, to.t, near),
            // Nearer to the last crossing of the function than its rounding: at the time on the polynomial.
            false => {
                let mut at = near.clone();
                let step = self.side.step(self.system, from, near.t - from.t, &[], &mut at);
                at.t = near.t;
                if step.is_ok() { at } else { near }
            }
        };
        Some(NextEvent { number, at, crossing: Some(crossing) })
    }

    /// The state at which a function is zero, by secants in the length of a side step, from the crossing on
    /// the polynomial.
    fn put_on(
        &mut self,
        value: &dyn Fn(&State<H::Vector>) -> f64,
        from: &State<H::Vector>,
        end: f64,
        near: State<H::Vector>,
    ) -> State<H::Vector> {
        let (whole, mut best) = (end - from.t, near);
        let mut length = best.t - from.t;
        let at = |side: &mut SideStepsOf<H, E>, room: &mut State<H::Vector>, length: f64| {
            side.step(self.system, from, length, &[], room).ok().map(|()| value(room))
        };
        let Self { side, room, .. } = self;
        // A part of the step over which the function is a straight line to half of its digits.
        let apart = whole * 1e-7;
        let Some(mut here) = at(side, room, length) else { return best };
        copy_state(&mut best, room);
        let mut least = here.abs();
        let Some(beside) = at(side, room, length - apart) else { return best };
        let mut slope = (here - beside) / apart;
        for _ in 0..MOST_CORRECTIONS {
            let next = length - here / slope;
            // Also where it is no number.
            if !(next / whole > 0.0 && next / whole <= 1.0) || next == length {
                break;
            }
            let Some(there) = at(side, room, next) else { break };
            if there.abs() >= least {
                break;
            }
            copy_state(&mut best, room);
            (slope, least) = ((there - here) / (next - length), there.abs());
            (length, here) = (next, there);
        }
        best
    }

    /// With noise: a change of sign between the ends of a part of the step, put on the section along the
    /// bridge of its increments.
    fn first_change<N: Noise>(
        &mut self,
        noise: &mut StepNoise<'_, N>,
        from: &State<H::Vector>,
        to: &State<H::Vector>,
    ) -> Result<Option<NextEvent<H::Vector>>, Error> {
        let (mut first, processes): (Option<NextEvent<H::Vector>>, _) =
            (None, self.system.increments(from.q.components().len()));
        let mut sides = self.sides.clone();
        for (function, side) in sides.iter_mut().enumerate() {
            let CrossingRule { number, direction: wanted, value } = &self.functions[function];
            let (number, wanted, value) = (*number, *wanted, value.clone());
            let (sign, after) = (side.sign(), side.shifted(value(to)));
            let offset = side.offset();
            let before = SignSide::<State<H::Vector>>::on(sign, side.value()).value();
            let reached = if after == 0.0 { SignSide::on(sign, after) } else { SignSide::at(after) };
            // A crossing takes the offset with it.
            *side = if sign * after < 0.0 { reached } else { reached.with_offset(offset) };
            let direction = if after > 0.0 { Direction::Rising } else { Direction::Falling };
            let changes = sign * after < 0.0 && wanted.is_none_or(|wanted| wanted == direction);
            if !changes {
                continue;
            }
            let (mut at, mut failure, mut dw) = (from.clone(), None, vec![0.0; processes]);
            let fraction = root([0.0, 1.0], [before, after], |fraction| {
                let t = from.t + fraction * (to.t - from.t);
                match self.part(noise, from, t, &mut dw, &mut at) {
                    Ok(()) => value(&at) + offset,
                    Err(error) => {
                        failure = Some(error);
                        f64::NAN
                    }
                }
            });
            if let Some(error) = failure {
                return Err(error);
            }
            self.part(noise, from, from.t + fraction * (to.t - from.t), &mut dw, &mut at)?;
            let is_first = first.as_ref().is_none_or(|first| self.sign * (at.t - first.at.t) < 0.0);
            if is_first {
                let crossing = Some(FoundCrossing { function, direction, t: at.t, offset });
                first = Some(NextEvent { number, at, crossing });
            }
        }
        if first.is_none() {
            for (function, side) in sides.into_iter().enumerate() {
                self.watch.set_side(function, side);
            }
        }
        Ok(first)
    }

    /// Does what an event does to a state, and keeps both. An action changes no time, and leads to the
    /// manifold of the constraints, if there are any.
    ///
    /// # Errors
    /// [`StepFailure::Dimension`] and [`StepFailure::NonFiniteInput`] where the state has another length or
    /// is no number, and the errors of the projection.
    fn act(&mut self, number: usize, before: State<H::Vector>) -> Result<State<H::Vector>, StepFailure> {
        let mut after = before.clone();
        let outcome = (self.rules.0[number].action)(&mut after);
        after.t = before.t;
        let expected = before.q.components().len();
        for list in [&after.q, &after.p] {
            let got = list.components().len();
            if got != expected {
                return Err(StepFailure::Dimension { expected, got });
            }
        }
        if zero_if_finite(after.q.components()) != 0.0 || zero_if_finite(after.p.components()) != 0.0 {
            return Err(StepFailure::NonFiniteInput);
        }
        if after != before {
            after = projected(self.system, after, true)?;
        }
        if outcome == AfterEvent::End {
            (self.is_over, self.has_ended_early) = (true, true);
        }
        self.happened.push(Event { event: number, before, after: after.clone() });
        Ok(after)
    }

    /// Events whose time is that of a node. A clock comes to its end at a node whose number is not known
    /// before.
    fn act_at_node(&mut self, node: u64, state: &mut State<H::Vector>) -> Result<(), StepFailure> {
        while let Some(TimedEvent { number, t, place }) = self.times.get(self.past).copied()
            && (place == NodeOrInside::Node(node) || H::PROPERTIES.is_clocked && t == state.t)
            && !(self.is_over && self.has_ended_early)
        {
            self.past += 1;
            let before = state.clone();
            *state = self.act(number, before.clone())?;
            for (function, rule) in self.functions.iter().enumerate() {
                let before = (rule.value)(&before);
                let after = (rule.value)(state);
                if before != after {
                    self.watch.set_side(function, SignSide::at(after));
                }
            }
        }
        Ok(())
    }

    /// Puts the path on the side of each function on which it goes on after an event, between these states.
    ///
    /// * A function that is zero at the event because it is the crossing: on the side to which the path
    ///   moves, or on that behind the crossing if the event changed nothing.
    /// * Another one: on the side on which the path was, unless the event changed its value.
    fn set_sides(&mut self, event: Option<FoundCrossing>, states: [&State<H::Vector>; 2]) {
        for function in 0..self.functions.len() {
            let value = self.functions[function].value.clone();
            let values = [value(states[0]), value(states[1])];
            let side = match event {
                Some(event) if event.function == function => {
                    self.side_behind(event.direction, &*value, states, values)
                }
                _ if values[0] == values[1] => {
                    let sign = self.sign_at(function, event.map_or(states[0].t, |event| event.t));
                    let offset = self.sides[function].offset();
                    // A crossing takes the offset with it.
                    let offset = if sign * offset > 0.0 { offset } else { 0.0 };
                    SignSide::on(sign, values[1] + offset).with_offset(offset)
                }
                _ => SignSide::at(values[1]),
            };
            self.watch.set_side(function, side);
        }
    }

    /// The sign of a function at a time in the part of the step that was searched last, before a crossing at
    /// that time.
    fn sign_at(&self, function: usize, t: f64) -> f64 {
        let before = sign_before(&self.found, function, self.sign, t);
        before.unwrap_or(self.sides[function].sign())
    }

    /// The side of a function on which a path goes on from its crossing, between these states with these
    /// values.
    fn side_behind(
        &mut self,
        direction: Direction,
        value: &dyn Fn(&State<H::Vector>) -> f64,
        [before, state]: [&State<H::Vector>; 2],
        values: [f64; 2],
    ) -> SignSide<State<H::Vector>> {
        let here = values[1];
        let gradient = self.system.energy_gradient(state);
        let (q, p) = (state.q.components(), state.p.components());
        let mut force = H::Vector::zeros(q.len());
        self.system.force(q, p, state.t, force.components_mut());
        // So far ahead that what moves in the step moves by half of its digits, by the rates alone.
        let ahead = self.sign * f64::EPSILON.sqrt() * self.whole.abs();
        copy_state(&mut self.room, state);
        self.room.t += ahead;
        for i in 0..q.len() {
            self.room.q.components_mut()[i] += ahead * gradient.p.components()[i];
            self.room.p.components_mut()[i] += ahead * (force.components()[i] - gradient.q.components()[i]);
        }
        let there = value(&self.room);
        let moved = there - here;
        let is_changed = values[0] != values[1];
        let is_driven = self.system.increments(self.room.q.components().len()) > 0;
        if there.is_nan() || is_changed {
            return SignSide::at(if there.is_nan() { here } else { there });
        }
        // The function is zero here: neither the error of the crossing nor what the motion makes of the
        // function in this time is a crossing. Twice the second and 5/4 of the first, which grows little in a
        // crowd.
        let rounding = moved.abs().max(0.625 * here.abs());
        if before == state && (is_driven || moved != 0.0) {
            SignSide::from_zero(direction.sign(), here, rounding)
        } else if moved == 0.0 {
            // The path rests on the section, and would cross it again.
            SignSide::on(-direction.sign(), here)
        } else {
            SignSide::from_zero(sign(moved), here, rounding)
        }
    }

    /// Looks into the parts of the last step, for recorded times and sections.
    ///
    /// # Errors
    /// The errors of side steps and of their noise.
    pub(crate) fn look<N: Noise, C: StateSum<f64>>(
        &mut self,
        stepper: &Stepper<'a, H, E, C>,
        step: StepLook<'_, N, H::Vector>,
        looks: &mut BetweenNodes<'_, '_, H::Vector>,
        recorder: &mut Recorder<H::Vector>,
    ) -> Result<(), Error> {
        let StepLook { number, noise, dw, end } = step;
        let (pieces, number_of_pieces) = (std::mem::take(&mut self.pieces), self.kept);
        let (mut later, mut dense) = (dw.to_vec(), self.dense.clone());
        for (place, piece) in pieces.iter().take(number_of_pieces).enumerate() {
            let StepPiece { from, to, dw, is_whole } = piece;
            subtract(dw, &mut later);
            if *is_whole {
                stepper.fill([from, to], dw, &mut dense);
            } else {
                dense.fill_by_rates::<H, E>(self.system, [from, to], to.t - from.t, dw);
            }
            let is_last = place + 1 == number_of_pieces;
            let ended = Some(end).filter(|_| is_last && self.has_ended_early);
            let part = StepPart { step: number, dw, later: &later, is_last, end: ended };
            if H::PROPERTIES.is_clocked {
                self.record_times(noise, piece, &part, end, recorder)?;
            } else {
                looks.record_times(&dense, &part, recorder);
            }
            let sections = looks.sections();
            looks.watch.go_on_from(sections.functions(), from);
            looks.find_crossings(&dense, recorder, &mut |crossing| {
                // By a clock, of the full order of the scheme; with noise on the polynomial.
                if H::PROPERTIES.is_clocked
                    && dw.is_empty()
                    && let Some(value) = sections.functions().nth(crossing.section)
                {
                    crossing.state = self.put_on(&**value, from, to.t, crossing.state.clone());
                }
            });
        }
        self.pieces = pieces;
        Ok(())
    }

    /// Records the times in a part of a step by a clock, by side steps.
    fn record_times<N: Noise>(
        &mut self,
        noise: &mut Option<N>,
        StepPiece { from, to, dw, .. }: &StepPiece<H::Vector>,
        part: &StepPart<'_, H::Vector>,
        end: &State<H::Vector>,
        recorder: &mut Recorder<H::Vector>,
    ) -> Result<(), Error> {
        while let Some(moment) = recorder.next_inside().filter(|moment| self.sign * (moment.t - to.t) < 0.0) {
            let interval = Interval { start: self.before.t, h: self.whole, step: part.step };
            let mut noise = StepNoise { noise: &mut *noise, interval, h: self.whole, is_own: true };
            let (mut at, mut own) = (from.clone(), vec![0.0; dw.len()]);
            self.part(&mut noise, from, moment.t, &mut own, &mut at)?;
            recorder.keep_inside(&at, |process| dw[process] - own[process] + part.later[process]);
        }
        // A time at the end of the step is that of its node; at an event, of the state after it.
        while let Some(moment) = recorder.next_inside().filter(|moment| moment.t == to.t && part.is_last) {
            let mut at = end.clone();
            at.t = moment.t;
            recorder.keep_inside(&at, |process| part.later[process]);
        }
        Ok(())
    }

    /// Everything that steps change.
    pub(crate) fn pass(&mut self, state: &State<H::Vector>, tape: &mut crate::ground::numbers::Tape) {
        let mut past = self.past as u64;
        tape.word(&mut past);
        self.past = usize::try_from(past).unwrap_or(usize::MAX);
        self.watch.pass(tape);
        for function in 0..self.functions.len() {
            let side = self.watch.sides()[function].clone();
            let mut offset = side.offset();
            tape.number(&mut offset);
            self.watch.set_side(function, side.with_offset(offset));
        }
        copy_state(&mut self.before, state);
        tape.flag(&mut self.is_over);
        tape.number(&mut self.crowd.t);
        let mut events = self.crowd.events as u64;
        tape.word(&mut events);
        self.crowd.events = usize::try_from(events).unwrap_or(usize::MAX);
    }
}
