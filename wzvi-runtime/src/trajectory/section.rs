//! Sections: where a path crosses a surface of phase space.
//!
//! A section is the set on which a function of the state is zero.
//! [`Simulation::section`](crate::trajectory::simulate::Simulation::section) finds the crossings of a path at
//! and between its nodes, on the dense output of its steps ([`crate::scheme::dense`]). They are accurate to a
//! few units in the last place of the fraction `θ` of a step, apart from the error of the step and of its
//! dense output.
//!
//! **What counts.** A crossing is a change of sign. A path that touches the section and stays on its side
//! does not cross it. Neither does one that starts or ends on the section. Where the function is NaN, the
//! path has no side, and crossings in between are unknown.
//!
//! **What is found.** In each step the function is evaluated at equidistant points, as many as the polynomial
//! has coefficients (at least 4; 8 for `Gauss<8>`). Two neighbouring values of different sign enclose a
//! crossing, which is always found. The function is then evaluated at the ends of four equal parts between
//! them; if two of these enclose three or more, one is found. Two values of the same sign may enclose an
//! extremum towards zero. Where differences indicate one, it is located, and two crossings close to each
//! other are found, too. A pair closer than about `10^-8` of a step is a tangency up to rounding, and may be
//! missed. So may crossings of functions that oscillate within a step faster than its polynomial.

mod root;
mod side;

pub use crate::algebra::crossing::{Crossing, Direction};
use crate::algebra::state::{State, Vector};
use crate::scheme::dense::{DenseOutput, Samples};
use crate::trajectory::options::{Functions, Observable};
use root::lowest;
pub(crate) use root::root;
use side::{SignChange, crossing_of_chord};
pub(crate) use side::{SignSide, sign};

/// The fewest parts of a step at whose ends the function is evaluated.
const LEAST_PARTS: usize = 4;
/// The most.
const MOST_PARTS: usize = 17;

/// The requested sections: functions, with the direction of the crossings where only one is requested.
pub(crate) type Sections<'a, V> = Functions<'a, V, Option<Direction>>;

impl<V> Sections<'_, V> {
    /// The directions that count for each section, in words.
    pub(crate) fn in_words(&self) -> String {
        let words = self.0.iter().map(|(direction, _)| match direction {
            Some(Direction::Rising) => "rising",
            Some(Direction::Falling) => "falling",
            None => "both",
        });
        words.collect::<Vec<_>>().join(", ")
    }

    /// Whether a crossing has the direction that is wanted of its section.
    pub(crate) fn want(&self, crossing: &Crossing<V>) -> bool {
        let wanted = self.0.get(crossing.section).and_then(|(wanted, _)| *wanted);
        wanted.is_none_or(|wanted| wanted == crossing.direction)
    }

    /// Their values at a state.
    pub(crate) fn values(&self, state: &State<V>) -> Vec<f64> {
        self.0.iter().map(|(_, value)| value(state)).collect()
    }
}

/// Follows a path past the zeros of functions of its state: of sections, or of first passages.
#[derive(Clone, Debug)]
pub(crate) struct SectionWatch<V> {
    sides: Vec<SignSide<State<V>>>,
    /// Scratch: the state at which functions are evaluated.
    room: State<V>,
    samples: Samples,
}

impl<V: Vector> SectionWatch<V> {
    /// Follows a path that starts at `start`.
    pub(crate) fn new<'f, 'a: 'f>(
        functions: impl Iterator<Item = &'f Observable<'a, V>>,
        start: &State<V>,
    ) -> Self
    where
        V: 'f,
    {
        let mut watch = Self { sides: Vec::new(), room: start.clone(), samples: Samples::default() };
        watch.begin(functions, start);
        watch
    }

    /// Begins another path.
    pub(crate) fn begin<'f, 'a: 'f>(
        &mut self,
        functions: impl Iterator<Item = &'f Observable<'a, V>>,
        start: &State<V>,
    ) where
        V: 'f,
    {
        self.sides.clear();
        self.sides.extend(functions.map(|value| SignSide::at(value(start))));
    }

    /// The side of each function on which the path is.
    pub(crate) fn sides(&self) -> &[SignSide<State<V>>] {
        &self.sides
    }

    /// Puts the path on a side of the function with this number.
    pub(crate) fn set_side(&mut self, number: usize, side: SignSide<State<V>>) {
        self.sides[number] = side;
    }

    /// Goes on from a state to which something else than a step may have moved the path: it crosses nothing
    /// on the way there.
    pub(crate) fn go_on_from<'f, 'a: 'f>(
        &mut self,
        functions: impl Iterator<Item = &'f Observable<'a, V>>,
        state: &State<V>,
    ) where
        V: 'f,
    {
        for (side, value) in self.sides.iter_mut().zip(functions) {
            let value = value(state);
            if value != side.value {
                *side = SignSide::at(value);
            }
        }
    }

    /// The crossings of a step, function by function, each in the order of time, and the offset of the
    /// function there ([`SignSide::offset`]); the number of the function is that of the section.
    pub(crate) fn follow<'f, 'a: 'f>(
        &mut self,
        functions: impl Iterator<Item = &'f Observable<'a, V>>,
        dense: &DenseOutput<V>,
        found: &mut dyn FnMut(Crossing<V>, f64),
    ) where
        V: 'f,
    {
        let parts = dense.rows().clamp(LEAST_PARTS, MOST_PARTS);
        self.samples.set(dense.rows(), parts);
        for (section, (side, value)) in self.sides.iter_mut().zip(functions).enumerate() {
            let mut step = SectionSearch { dense, value: &**value, offset: 0.0, room: &mut self.room };
            step.follow(side, &self.samples, parts, &mut |direction, state, offset| {
                found(Crossing { section, direction, state }, offset);
            });
        }
    }

    /// The time at which a function crosses zero in the step between these times that ended in this state, as
    /// far as its nodes tell: on the chord, unless a node is on the section.
    pub(crate) fn arrive(
        &mut self,
        number: usize,
        function: &Observable<'_, V>,
        times: [f64; 2],
        state: &State<V>,
    ) -> Option<f64> {
        let (side, value) = (&mut self.sides[number], function(state));
        let values = [side.value(), value];
        match side.advance_to(value, || state.clone().at(times[1]))? {
            SignChange::At(state) => Some(state.t),
            SignChange::Between => Some(crossing_of_chord(times, values)),
        }
    }

    /// Everything that steps change.
    pub(crate) fn pass(&mut self, tape: &mut crate::ground::numbers::Tape) {
        for SignSide { value, sign, touched, .. } in &mut self.sides {
            tape.numbers([value, sign]);
            let mut is_touched = touched.is_some();
            tape.flag(&mut is_touched);
            if is_touched {
                touched.get_or_insert_with(|| self.room.clone()).pass(tape);
            }
        }
    }
}

impl<V: Vector> Crossing<V> {
    /// To be replaced by what a tape says.
    pub(crate) fn like(state: &State<V>) -> Self {
        Self { section: 0, direction: Direction::Rising, state: state.clone() }
    }

    pub(crate) fn pass(&mut self, tape: &mut crate::ground::numbers::Tape) {
        let mut section = self.section as u64;
        tape.word(&mut section);
        let mut is_rising = self.direction == Direction::Rising;
        tape.flag(&mut is_rising);
        self.section = usize::try_from(section).unwrap_or(usize::MAX);
        self.direction = if is_rising { Direction::Rising } else { Direction::Falling };
        self.state.pass(tape);
    }
}

/// One step and one section.
struct SectionSearch<'s, V> {
    dense: &'s DenseOutput<V>,
    value: &'s dyn Fn(&State<V>) -> f64,
    /// The offset of the function in the part of the step that is searched.
    offset: f64,
    room: &'s mut State<V>,
}

impl<V: Vector> SectionSearch<'_, V> {
    fn at(&mut self, theta: f64) -> f64 {
        self.dense.write(theta, self.room);
        (self.value)(self.room) + self.offset
    }

    fn follow(
        &mut self,
        side: &mut SignSide<State<V>>,
        samples: &Samples,
        parts: usize,
        found: &mut dyn FnMut(Direction, State<V>, f64),
    ) {
        let theta = |i: usize| i as f64 / parts as f64;
        let mut values = [0.0; MOST_PARTS + 1];
        let mut offsets = [0.0; MOST_PARTS + 1];
        values[0] = side.value;
        for i in 1..=parts {
            let value = if i < parts {
                self.dense.write_sample(samples, i, self.room);
                (self.value)(self.room)
            } else {
                (self.value)(self.dense.end())
            };
            values[i] = side.shifted(value);
            offsets[i] = side.offset();
        }
        let values = &values[..=parts];
        for i in 0..parts {
            let offset = offsets[i + 1];
            self.offset = offset;
            let found = &mut |direction, state| found(direction, state, offset);
            let (bracket, ends) = ([theta(i), theta(i + 1)], [values[i], values[i + 1]]);
            let after = sign(ends[1]);
            let turns = |i: usize| after * slope(values, i);
            match side.advance_to(ends[1], || self.dense.at(bracket[1])) {
                Some(SignChange::At(state)) => found(direction(after), state),
                Some(SignChange::Between) => self.crossings(bracket, ends, found),
                // An extremum towards zero, between two values of one sign.
                None if after != 0.0 && sign(ends[0]) == after && turns(i) < 0.0 && turns(i + 1) > 0.0 => {
                    let bottom = lowest(bracket, |theta| after * self.at(theta));
                    if let Some((middle, value)) = bottom {
                        let [first, second] = [direction(-after), direction(after)];
                        found(first, self.crossing([bracket[0], middle], [ends[0], after * value]));
                        found(second, self.crossing([middle, bracket[1]], [after * value, ends[1]]));
                    }
                }
                None => {}
            }
        }
    }

    /// The crossings between two points at which the function has different signs: of several, those that
    /// more points between them tell apart.
    fn crossings(
        &mut self,
        [start, end]: [f64; 2],
        [before, after]: [f64; 2],
        found: &mut dyn FnMut(Direction, State<V>),
    ) {
        let (mut side, mut last, length) = (SignSide::at(before), start, end - start);
        for i in 1..=LEAST_PARTS {
            let is_last = i == LEAST_PARTS;
            let theta = if is_last { end } else { start + length * i as f64 / LEAST_PARTS as f64 };
            let value = if is_last { after } else { self.at(theta) };
            let values = [side.value(), value];
            match side.advance_to(value, || self.dense.at(theta)) {
                Some(SignChange::At(state)) => found(direction(value), state),
                Some(SignChange::Between) => found(direction(value), self.crossing([last, theta], values)),
                None => {}
            }
            last = theta;
        }
    }

    fn crossing(&mut self, bracket: [f64; 2], values: [f64; 2]) -> State<V> {
        let theta = root(bracket, values, |theta| self.at(theta));
        self.dense.at(theta)
    }
}

fn direction(sign: f64) -> Direction {
    if sign > 0.0 { Direction::Rising } else { Direction::Falling }
}

/// A multiple of the slope at one of equidistant points: of the parabola through it and its neighbours.
fn slope(values: &[f64], i: usize) -> f64 {
    let last = values.len() - 1;
    if i == 0 {
        4.0 * (values[1] - values[0]) - (values[2] - values[0])
    } else if i == last {
        4.0 * (values[last] - values[last - 1]) - (values[last] - values[last - 2])
    } else {
        values[i + 1] - values[i - 1]
    }
}

#[cfg(test)]
mod tests;
