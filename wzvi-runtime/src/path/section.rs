//! Sections: where a path crosses a surface of phase space.
//!
//! A section is the set on which a function of the state is zero. [`Simulation::section`](crate::path::simulate::Simulation::section) finds
//! the crossings of a path at and between its nodes, on the dense output of its steps ([`crate::scheme::dense`]). They are accurate to a few
//! units in the last place of the fraction `θ` of a step, apart from the error of the step and of its dense output.
//!
//! **What counts.** A crossing is a change of sign. A path that touches the section and stays on its side does not cross it. Neither does
//! one that starts or ends on the section. Where the function is NaN, the path has no side, and crossings in between are unknown.
//!
//! **What is found.** In each step the function is evaluated at equidistant points, as many as the polynomial has coefficients (at least 4; 8 for
//! `Gauss<8>`). Two neighbouring values of different sign enclose a crossing, which is always found; if they enclose three or more, one is found.
//! Two values of the same sign may enclose an extremum towards zero. Where differences indicate one, it is located, and two crossings close to each
//! other are found, too. A pair closer than about `10^-8` of a step is a tangency up to rounding, and may be missed. So may crossings of functions
//! that oscillate within a step faster than its polynomial.

mod root;

pub use crate::algebra::crossing::{Crossing, Direction};
use crate::algebra::state::{State, Vector};
use crate::path::options::Functions;
use crate::scheme::dense::{DenseOutput, Samples};
use root::{lowest, root};

/// The fewest parts of a step at whose ends the function is evaluated.
const LEAST_PARTS: usize = 4;
/// The most.
const MOST_PARTS: usize = 17;

/// The requested sections: functions, with the direction of the crossings where only one is requested.
pub(crate) type Sections<'a, V> = Functions<'a, V, Option<Direction>>;

impl<V> Sections<'_, V> {
    /// What is wanted of each, in words.
    pub(crate) fn in_words(&self) -> String {
        let words = self.0.iter().map(|(direction, _)| match direction {
            Some(Direction::Rising) => "rising",
            Some(Direction::Falling) => "falling",
            None => "both",
        });
        words.collect::<Vec<_>>().join(", ")
    }

    /// Their values at a state.
    pub(crate) fn values(&self, state: &State<V>) -> Vec<f64> {
        self.0.iter().map(|(_, value)| value(state)).collect()
    }
}

/// Follows a path through its sections.
#[derive(Clone, Debug)]
pub(crate) struct Watch<V> {
    sides: Vec<Side<V>>,
    /// Where functions are evaluated.
    room: State<V>,
    samples: Samples,
}

/// On which side of a section a path is.
#[derive(Clone, Debug)]
struct Side<V> {
    /// The value at the last node.
    value: f64,
    /// The sign of the last value that was not zero; 0 before there is one, and after NaN.
    sign: f64,
    /// Where the value has been zero since.
    touched: Option<State<V>>,
}

impl<V> Side<V> {
    fn at(value: f64) -> Self {
        let sign = if value.is_nan() { 0.0 } else { sign(value) };
        Self { value, sign, touched: None }
    }
}

impl<V: Vector> Watch<V> {
    /// Of a path that starts at `start`.
    pub(crate) fn new(sections: &Sections<'_, V>, start: &State<V>) -> Self {
        let mut watch = Self { sides: Vec::new(), room: start.clone(), samples: Samples::default() };
        watch.begin(sections, start);
        watch
    }

    /// Begins another path.
    pub(crate) fn begin(&mut self, sections: &Sections<'_, V>, start: &State<V>) {
        self.sides.clear();
        let values = sections.0.iter().map(|(_, value)| value(start));
        self.sides.extend(values.map(Side::at));
    }

    /// The crossings of a step, section by section, each in the order of time.
    pub(crate) fn follow(
        &mut self,
        sections: &Sections<'_, V>,
        dense: &DenseOutput<V>,
        mut found: impl FnMut(Crossing<V>),
    ) {
        let parts = dense.rows().clamp(LEAST_PARTS, MOST_PARTS);
        self.samples.set(dense.rows(), parts);
        for (section, (side, (wanted, value))) in self.sides.iter_mut().zip(&sections.0).enumerate() {
            let mut step = Step { dense, value: &**value, room: &mut self.room };
            step.follow(side, &self.samples, parts, |direction, state| {
                if wanted.is_none_or(|wanted| wanted == direction) {
                    found(Crossing { section, direction, state });
                }
            });
        }
    }

    /// Everything that steps change.
    pub(crate) fn pass(&mut self, tape: &mut crate::ground::numbers::Tape) {
        for Side { value, sign, touched } in &mut self.sides {
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

/// When a function is first zero in a step or changes its sign there, if its `values` at both nodes say that it does.
pub(crate) fn first_zero<V: Vector>(
    dense: &DenseOutput<V>,
    value: &dyn Fn(&State<V>) -> f64,
    values: [f64; 2],
    room: &mut State<V>,
) -> Option<f64> {
    let is_crossed = values[0] < 0.0 && values[1] >= 0.0 || values[0] > 0.0 && values[1] <= 0.0;
    if !is_crossed {
        return None;
    }
    if values[1] == 0.0 {
        return Some(dense.end().t);
    }
    let mut step = Step { dense, value, room };
    Some(step.crossing([0.0, 1.0], values).t)
}

/// One step and one section.
struct Step<'s, V> {
    dense: &'s DenseOutput<V>,
    value: &'s dyn Fn(&State<V>) -> f64,
    room: &'s mut State<V>,
}

impl<V: Vector> Step<'_, V> {
    fn at(&mut self, theta: f64) -> f64 {
        self.dense.write(theta, self.room);
        (self.value)(self.room)
    }

    fn follow(
        &mut self,
        side: &mut Side<V>,
        samples: &Samples,
        parts: usize,
        mut found: impl FnMut(Direction, State<V>),
    ) {
        let theta = |i: usize| i as f64 / parts as f64;
        let mut values = [0.0; MOST_PARTS + 1];
        values[0] = side.value;
        for (i, value) in values.iter_mut().enumerate().take(parts).skip(1) {
            self.dense.write_sample(samples, i, self.room);
            *value = (self.value)(self.room);
        }
        values[parts] = (self.value)(self.dense.end());
        let values = &values[..=parts];
        side.value = values[parts];
        for i in 0..parts {
            let (bracket, ends) = ([theta(i), theta(i + 1)], [values[i], values[i + 1]]);
            let after = sign(ends[1]);
            if after.is_nan() {
                (side.sign, side.touched) = (0.0, None);
            } else if after == 0.0 {
                if side.sign != 0.0 && side.touched.is_none() {
                    side.touched = Some(self.dense.at(bracket[1]));
                }
            } else if side.sign == 0.0 || side.sign == after {
                // From a start on the section, from nowhere, or back from it.
                let was_touched = side.touched.take().is_some();
                let turns = |i: usize| after * slope(values, i);
                if sign(ends[0]) == after && !was_touched && turns(i) < 0.0 && turns(i + 1) > 0.0 {
                    let bottom = lowest(bracket, |theta| after * self.at(theta));
                    if let Some((middle, value)) = bottom {
                        let [first, second] = [direction(-after), direction(after)];
                        found(first, self.crossing([bracket[0], middle], [ends[0], after * value]));
                        found(second, self.crossing([middle, bracket[1]], [after * value, ends[1]]));
                    }
                }
                side.sign = after;
            } else {
                let state = side.touched.take().unwrap_or_else(|| self.crossing(bracket, ends));
                found(direction(after), state);
                side.sign = after;
            }
        }
    }

    fn crossing(&mut self, bracket: [f64; 2], values: [f64; 2]) -> State<V> {
        let theta = root(bracket, values, |theta| self.at(theta));
        self.dense.at(theta)
    }
}

/// -1, 0 or 1; NaN of NaN.
fn sign(value: f64) -> f64 {
    if value == 0.0 { 0.0 } else { value.signum() }
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
