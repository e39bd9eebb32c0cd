//! Steps in which something may happen: the end of a run by a clock, and events.
//!
//! A step goes from the node before it to the next one. What happens inside divides it into parts, each by a
//! [side step](crate::scheme::clock) of its own.

use crate::algebra::state::{State, Vector, copy_state};
use crate::algebra::state_sum::StateSum;
use crate::error::{StepError, StepFailure};
use crate::increments::{Interval, Noise};
use crate::scheme::clock::SideStepper;
use crate::scheme::dense::DenseOutput;
use crate::scheme::system::{Discretized, Scheme, SchemeOf};
use crate::trajectory::Error;
use crate::trajectory::between::{BetweenNodes, StepPart};
use crate::trajectory::events::{AfterEvent, Event, EventRules};
use crate::trajectory::options::Observable;
use crate::trajectory::recorded::Recorder;
use crate::trajectory::section::{Crossing, Direction, SectionWatch, root};
use crate::trajectory::span::{NodeGrid, NodeOrInside};
use crate::trajectory::step::{Exchanged, StepInfo, Stepper, beside_scheme};
use crate::trajectory::steps::StepToTake;

/// The most events in one step.
const MOST_EVENTS: usize = 1000;
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
pub(crate) struct StepLook<'l, N> {
    pub(crate) number: u64,
    pub(crate) noise: &'l mut Option<N>,
    pub(crate) dw: &'l [f64],
}

/// Follows a path through its steps.
pub(crate) struct Following<'a, H: Discretized<E>, E> {
    system: &'a H,
    rules: EventRules<'a, H::Vector>,
    /// The functions of crossings, with the number of the event and the direction that counts.
    functions: Vec<CrossingRule<'a, H::Vector>>,
    /// Follows the signs of these functions, without noise.
    watch: SectionWatch<H::Vector>,
    /// The signs at the last node, with noise.
    signs: Vec<f64>,
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
    /// The number and the time of the last crossing or event.
    last: Option<(usize, f64)>,
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

/// An event to come.
struct NextEvent<V> {
    number: usize,
    /// The state where it happens.
    at: State<V>,
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
        let signs = functions.iter().map(|rule| (rule.value)(start)).collect();
        let mut following = Self {
            system,
            watch: SectionWatch::new(functions.iter().map(|rule| &rule.value), start),
            functions,
            signs,
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
            last: None,
            whole: f64::NAN,
            pieces: Vec::new(),
            kept: 0,
            happened: Vec::new(),
            is_over: false,
            has_ended_early: false,
        };
        following.face(start);
        following
    }

    /// The start of the last step.
    pub(crate) fn before(&self) -> &State<H::Vector> {
        &self.before
    }

    /// Acts at the start, at whose time there may be events.
    pub(crate) fn begin(&mut self, state: &mut State<H::Vector>) {
        self.happened.clear();
        self.act_at_node(0, state);
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
        let h = if is_own && !dw.is_empty() { stepper.upcoming(state)? - state.t } else { size };
        let interval = match is_own {
            // The number of the step, and its own time.
            true => Interval { start: state.t, h, step: interval.step },
            false => interval,
        };
        let mut noise = StepNoise { noise, interval, h, is_own };
        self.draw(&mut noise, size, dw)?;
        let exchanged = stepper.account().clone();
        let info = stepper.step(state, dw)?;
        if is_own {
            noise.h = state.t - self.before.t;
        }
        self.whole = noise.h;
        let outcome = self.divide(stepper, exchanged, state, &mut noise, dw);
        if outcome.is_err() {
            copy_state(state, &self.before);
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
        exchanged: Exchanged,
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
            let NextEvent { number, at } = event;
            // An event again without any time in between would happen for ever.
            if self.last == Some((number, at.t)) || self.happened.len() == MOST_EVENTS {
                return Err(self.too_many(&from, noise));
            }
            self.last = Some((number, at.t));
            self.increments(noise, [from.t, at.t], dw)?;
            self.keep_piece([&from, &at], dw, false);
            from = self.act(number, at);
            if self.is_over {
                break;
            }
            self.face(&from);
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
            self.account_for_pieces(stepper, exchanged)?;
        }
        // All that drove the step up to here.
        if !is_whole {
            self.increments(noise, [self.before.t, state.t], dw)?;
        }
        self.from = Some(from);
        self.act_at_node(noise.interval.step + 1, state);
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
        if self.rules.is_empty() {
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

    /// Keeps a part of the step.
    fn keep_piece(&mut self, [from, to]: [&State<H::Vector>; 2], dw: &[f64], is_whole: bool) {
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
        StepError { step: noise.interval.step, t: self.before.t, h: noise.h, cause }.into()
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
        let crossing = match noise.noise {
            None => self.first_crossing(from, to)?,
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
                Ok(Some(NextEvent { number, at }))
            }
            (crossing, None) => Ok(crossing),
        }
    }

    /// The first crossing on the polynomial of the step, put on the section by side steps.
    fn first_crossing(
        &mut self,
        from: &State<H::Vector>,
        to: &State<H::Vector>,
    ) -> Result<Option<NextEvent<H::Vector>>, Error> {
        if self.functions.is_empty() {
            return Ok(None);
        }
        let (sign, mut first): (f64, Option<Crossing<H::Vector>>) = (self.sign, None);
        let Self { functions, watch, dense, .. } = self;
        watch.follow(functions.iter().map(|rule| &rule.value), dense, &mut |crossing| {
            let wanted = functions[crossing.section].direction;
            let counts = wanted.is_none_or(|direction| direction == crossing.direction);
            let is_first = first.as_ref().is_none_or(|first| sign * (crossing.state.t - first.state.t) < 0.0);
            if counts && is_first {
                first = Some(crossing);
            }
        });
        let Some(Crossing { section, state, .. }) = first else { return Ok(None) };
        let CrossingRule { number, value, .. } = &self.functions[section];
        let (number, value) = (*number, value.clone());
        Ok(Some(NextEvent { number, at: self.put_on(&*value, from, to.t, state) }))
    }

    /// The state at which a function is zero, by Newton's method on the length of a side step: by secants,
    /// from the crossing on the polynomial.
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
        let mut signs = self.signs.clone();
        for (place, sign) in signs.iter_mut().enumerate() {
            let CrossingRule { number, direction: wanted, value } = &self.functions[place];
            let (number, wanted, value) = (*number, *wanted, value.clone());
            let (before, after) = (*sign, value(to));
            if after != 0.0 {
                *sign = after;
            }
            let direction = if after > 0.0 { Direction::Rising } else { Direction::Falling };
            let changes = before * after < 0.0 && wanted.is_none_or(|wanted| wanted == direction);
            if !changes {
                continue;
            }
            let (mut at, mut failure, mut dw) = (from.clone(), None, vec![0.0; processes]);
            let fraction = root([0.0, 1.0], [before, after], |fraction| {
                let t = from.t + fraction * (to.t - from.t);
                match self.part(noise, from, t, &mut dw, &mut at) {
                    Ok(()) => value(&at),
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
                first = Some(NextEvent { number, at });
            }
        }
        if first.is_none() {
            self.signs = signs;
        }
        Ok(first)
    }

    /// Does what an event does to a state, and keeps both.
    fn act(&mut self, number: usize, before: State<H::Vector>) -> State<H::Vector> {
        let mut after = before.clone();
        let outcome = (self.rules.0[number].action)(&mut after);
        // An action changes no time.
        after.t = before.t;
        if outcome == AfterEvent::End {
            (self.is_over, self.has_ended_early) = (true, true);
        }
        self.happened.push(Event { event: number, before, after: after.clone() });
        after
    }

    /// Events whose time is that of a node. A clock comes to its end at a node whose number is not known
    /// before.
    fn act_at_node(&mut self, node: u64, state: &mut State<H::Vector>) {
        let mut has_acted = false;
        while let Some(TimedEvent { number, t, place }) = self.times.get(self.past).copied()
            && (place == NodeOrInside::Node(node) || H::PROPERTIES.is_clocked && t == state.t)
            && !(self.is_over && self.has_ended_early)
        {
            self.past += 1;
            *state = self.act(number, state.clone());
            has_acted = true;
        }
        if has_acted {
            self.face(state);
        }
    }

    /// The side of each crossing on which a path is that goes on from a state: that of the sign of the
    /// function, or that to which the path moves where the function vanishes up to its rounding.
    fn face(&mut self, state: &State<H::Vector>) {
        let values: Vec<f64> = (0..self.functions.len())
            .map(|place| {
                let value = self.functions[place].value.clone();
                self.side_of(&*value, state)
            })
            .collect();
        self.watch.set_sides(&values);
        self.signs = values;
    }

    fn side_of(&mut self, value: &dyn Fn(&State<H::Vector>) -> f64, state: &State<H::Vector>) -> f64 {
        let here = value(state);
        let gradient = self.system.energy_gradient(state);
        let (q, p) = (state.q.components(), state.p.components());
        let mut force = H::Vector::zeros(q.len());
        self.system.force(q, p, state.t, force.components_mut());
        // As far ahead as half of the digits of the state allow, by the rates alone.
        let rate = |i: usize| gradient.p.components()[i];
        let pull = |i: usize| force.components()[i] - gradient.q.components()[i];
        let slowest = (0..q.len()).map(|i| size_ratio(rate(i), q[i]).max(size_ratio(pull(i), p[i])));
        let fastest = slowest.fold(0.0, f64::max);
        let ahead = f64::EPSILON.sqrt() / fastest;
        if !ahead.is_finite() {
            return here;
        }
        copy_state(&mut self.room, state);
        self.room.t += self.sign * ahead;
        for i in 0..q.len() {
            self.room.q.components_mut()[i] += self.sign * ahead * rate(i);
            self.room.p.components_mut()[i] += self.sign * ahead * pull(i);
        }
        let there = value(&self.room);
        // A function that changes its sign there is zero up to the error of its crossing.
        if here * there <= 0.0 { there } else { here }
    }

    /// Looks into the parts of the last step, for recorded times and sections.
    ///
    /// # Errors
    /// The errors of side steps and of their noise.
    pub(crate) fn look<N: Noise, C: StateSum<f64>>(
        &mut self,
        stepper: &Stepper<'a, H, E, C>,
        step: StepLook<'_, N>,
        looks: &mut BetweenNodes<'_, '_, H::Vector>,
        recorder: &mut Recorder<H::Vector>,
    ) -> Result<(), Error> {
        let StepLook { number, noise, dw } = step;
        let (pieces, number_of_pieces) = (std::mem::take(&mut self.pieces), self.kept);
        let (mut later, mut dense) = (dw.to_vec(), self.dense.clone());
        for (place, piece) in pieces.iter().take(number_of_pieces).enumerate() {
            let StepPiece { from, to, dw, is_whole } = piece;
            later.iter_mut().zip(dw).for_each(|(later, dw)| *later -= dw);
            if *is_whole {
                stepper.fill([from, to], dw, &mut dense);
            } else {
                dense.fill_by_rates::<H, E>(self.system, [from, to], to.t - from.t, dw);
            }
            let part = StepPart { step: number, dw, later: &later, is_last: place + 1 == number_of_pieces };
            if H::PROPERTIES.is_clocked {
                self.record_times(noise, piece, &part, recorder)?;
            } else {
                looks.record_times(&dense, &part, recorder);
            }
            let sections = looks.sections();
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
        part: &StepPart<'_>,
        recorder: &mut Recorder<H::Vector>,
    ) -> Result<(), Error> {
        while let Some(moment) = recorder.next_inside().filter(|moment| self.sign * (moment.t - to.t) < 0.0) {
            let interval = Interval { start: self.before.t, h: self.whole, step: part.step };
            let mut noise = StepNoise { noise: &mut *noise, interval, h: self.whole, is_own: true };
            let (mut at, mut own) = (from.clone(), vec![0.0; dw.len()]);
            self.part(&mut noise, from, moment.t, &mut own, &mut at)?;
            recorder.keep_inside(&at, |process| dw[process] - own[process] + part.later[process]);
        }
        // A time at the end of a part is that of its node.
        while let Some(moment) = recorder.next_inside().filter(|moment| moment.t == to.t) {
            let mut at = to.clone();
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
        tape.numbers(&mut self.signs);
        self.watch.pass(tape);
        copy_state(&mut self.before, state);
        tape.flag(&mut self.is_over);
        let (number, t) = self.last.unwrap_or((usize::MAX, f64::NAN));
        let (mut number, mut t) = (number as u64, t);
        tape.word(&mut number);
        tape.number(&mut t);
        self.last = usize::try_from(number).ok().filter(|_| !t.is_nan()).map(|number| (number, t));
    }
}

/// How fast a number of this rate changes in its own size; its rate alone where it is zero.
fn size_ratio(rate: f64, size: f64) -> f64 {
    if size == 0.0 { 0.0 } else { (rate / size).abs() }
}
