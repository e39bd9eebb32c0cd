//! Why a step failed, as words: for checkpoints and messages.

use super::{BathError, FailedLanes, IndexError, IndexLimit, Name, StepError, StepFailure, StepPromise};
use crate::ground::numbers::{Numbers, Tape, numbers};

/// The first word for errors of a bath.
const BATH: u64 = 9;

/// Words after all of them: failed lanes, another solution, too many unknowns, internal errors, infinite
/// parameters, energies, constraints, and clocks.
const LANES: u64 = u64::MAX;
const OTHER: u64 = LANES - 1;
const TOO_MANY: u64 = LANES - 2;
const INTERNAL: u64 = LANES - 3;
const INFINITE: u64 = LANES - 4;
const UNDECIDED: u64 = LANES - 5;
const UNDEFINED: u64 = LANES - 6;
const OFF_MANIFOLD: u64 = LANES - 7;
const DEPENDENT: u64 = LANES - 8;
const NO_PROJECTION: u64 = LANES - 9;
const CLOCK: u64 = LANES - 10;
const COARSE: u64 = LANES - 11;
const EVENTS: u64 = LANES - 12;
const COLLISION: u64 = LANES - 13;
/// Words before these, for the radius of curvature of each constraint.
const BEYOND: u64 = LANES - (1 << 32);

numbers! { impl[] Numbers for StepError { kept: step, t, h, cause } }

impl Numbers for StepFailure {
    fn pass(&mut self, tape: &mut Tape) {
        let mut words = self.words();
        tape.words(&mut words);
        match Self::from_words(words) {
            Some(failure) => *self = failure,
            None => tape.refuse(),
        }
    }
}

impl StepFailure {
    /// The failure as three words: its kind, and two values.
    fn words(self) -> [u64; 3] {
        match self {
            Self::NotConverged { iterations, correction } => [0, u64::from(iterations), correction.to_bits()],
            Self::Singular { pivot, scale } => [1, pivot.to_bits(), scale.to_bits()],
            Self::NoSolution { reached } => [2, reached.to_bits(), 0],
            Self::Unresolved { energy_error, scale, may_jump } => {
                let which = if may_jump { UNDECIDED } else { 3 };
                [which, energy_error.to_bits(), scale.to_bits()]
            }
            Self::UndefinedEnergy => [UNDEFINED, 0, 0],
            Self::BeyondCurvature { constraint, length, radius } => {
                [BEYOND - constraint as u64, length.to_bits(), radius.to_bits()]
            }
            Self::NoProjection { iterations, residual } => {
                [NO_PROJECTION, u64::from(iterations), residual.to_bits()]
            }
            Self::Dependent { constraint } => [DEPENDENT, constraint as u64, 0],
            Self::OffManifold { coordinates, momenta } => {
                [OFF_MANIFOLD, coordinates.to_bits(), momenta.to_bits()]
            }
            Self::ClockNotPositive { value } => [CLOCK, value.to_bits(), 0],
            Self::ClockTooCoarse { density } => [COARSE, density.to_bits(), 0],
            Self::TooManyEvents { t, events } => [EVENTS, t.to_bits(), events as u64],
            Self::Collision { body } => [COLLISION, body as u64, 0],
            Self::NonFinite => [4, 0, 0],
            // Here the name is lost.
            Self::Infinite { .. } => [INFINITE, 0, 0],
            Self::Increments { expected, got } => [5, expected as u64, got as u64],
            Self::Dimension { expected, got } => [6, expected as u64, got as u64],
            Self::NonFiniteInput => [7, 0, 0],
            Self::Lanes(FailedLanes(lanes)) => [LANES, lanes, 0],
            // Runs find it before their first step; here the name is lost.
            Self::Index(error) => [8, error.value() as u64, 0],
            Self::OtherSolution { apart } => [OTHER, apart.to_bits(), 0],
            Self::TooManyUnknowns { unknowns, most } => [TOO_MANY, unknowns as u64, most as u64],
            Self::Internal(promise) => [INTERNAL, promise as u64, 0],
            Self::Bath(error) => {
                let [which, a, b] = error.words();
                [BATH + which, a, b]
            }
        }
    }

    fn from_words([which, a, b]: [u64; 3]) -> Option<Self> {
        let (x, y) = (f64::from_bits(a), f64::from_bits(b));
        Some(match which {
            0 => Self::NotConverged { iterations: u32::try_from(a).ok()?, correction: y },
            1 => Self::Singular { pivot: x, scale: y },
            2 => Self::NoSolution { reached: x },
            3 => Self::Unresolved { energy_error: x, scale: y, may_jump: false },
            UNDECIDED => Self::Unresolved { energy_error: x, scale: y, may_jump: true },
            UNDEFINED => Self::UndefinedEnergy,
            OFF_MANIFOLD => Self::OffManifold { coordinates: x, momenta: y },
            NO_PROJECTION => Self::NoProjection { iterations: u32::try_from(a).ok()?, residual: y },
            COLLISION => Self::Collision { body: usize::try_from(a).ok()? },
            DEPENDENT => Self::Dependent { constraint: usize::try_from(a).ok()? },
            which if which <= BEYOND && which > BEYOND - (1 << 32) => {
                Self::BeyondCurvature { constraint: (BEYOND - which) as usize, length: x, radius: y }
            }
            CLOCK => Self::ClockNotPositive { value: x },
            COARSE => Self::ClockTooCoarse { density: x },
            EVENTS => Self::TooManyEvents { t: x, events: usize::try_from(b).ok()? },
            4 => Self::NonFinite,
            LANES if a != 0 => Self::Lanes(FailedLanes(a)),
            5 => Self::Increments { expected: usize::try_from(a).ok()?, got: usize::try_from(b).ok()? },
            6 => Self::Dimension { expected: usize::try_from(a).ok()?, got: usize::try_from(b).ok()? },
            7 => Self::NonFiniteInput,
            8 => Self::Index(IndexError::new(
                &Name { name: "an integer", suffix: "" },
                (a as i64).into(),
                IndexLimit::Integers,
            )),
            OTHER => Self::OtherSolution { apart: x },
            TOO_MANY => {
                Self::TooManyUnknowns { unknowns: usize::try_from(a).ok()?, most: usize::try_from(b).ok()? }
            }
            INFINITE => Self::Infinite { parameter: "a parameter" },
            INTERNAL => Self::Internal(StepPromise::ALL.into_iter().find(|&promise| promise as u64 == a)?),
            _ => Self::Bath(BathError::from_words([which.checked_sub(BATH)?, a, b])?),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_failure_comes_back() {
        let all = [
            StepFailure::NotConverged { iterations: u32::MAX, correction: 0.1 },
            StepFailure::Singular { pivot: -0.0, scale: f64::INFINITY },
            StepFailure::NoSolution { reached: 0.3 },
            StepFailure::Unresolved { energy_error: 1e-300, scale: 7.0, may_jump: false },
            StepFailure::Unresolved { energy_error: 1e-300, scale: 7.0, may_jump: true },
            StepFailure::UndefinedEnergy,
            StepFailure::OffManifold { coordinates: 0.1, momenta: 0.2 },
            StepFailure::Dependent { constraint: 7 },
            StepFailure::ClockNotPositive { value: -0.5 },
            StepFailure::TooManyEvents { t: 0.5, events: 1000 },
            StepFailure::ClockTooCoarse { density: f64::NEG_INFINITY },
            StepFailure::Collision { body: 3 },
            StepFailure::NoProjection { iterations: 50, residual: 0.5 },
            StepFailure::BeyondCurvature { constraint: 0, length: 2.0, radius: 1.0 },
            StepFailure::BeyondCurvature { constraint: 10_000, length: 2.0, radius: 1.0 },
            StepFailure::OtherSolution { apart: 0.4 },
            StepFailure::TooManyUnknowns { unknowns: 2000, most: 1500 },
            StepFailure::Internal(StepPromise::ListedRates),
            StepFailure::Internal(StepPromise::PlainConstants),
            StepFailure::Internal(StepPromise::Bath),
            StepFailure::NonFinite,
            StepFailure::Infinite { parameter: "a parameter" },
            StepFailure::Increments { expected: 3, got: usize::MAX },
            StepFailure::Dimension { expected: 0, got: 2 },
            StepFailure::NonFiniteInput,
            StepFailure::Lanes(FailedLanes(1 << 63 | 5)),
            StepFailure::Bath(BathError::Temperature { temperature: -1.0, degree: None, t: None }),
            StepFailure::Bath(BathError::Temperature { temperature: -1.0, degree: None, t: Some(0.3) }),
            StepFailure::Bath(BathError::Temperature { temperature: -1.0, degree: Some(7), t: Some(0.3) }),
            StepFailure::Bath(BathError::Friction { rate: f64::INFINITY }),
            StepFailure::Bath(BathError::Asymmetric { entry: [1, usize::MAX] }),
            StepFailure::Bath(BathError::Coupled { entry: [0, 2] }),
            StepFailure::Bath(BathError::Mass { degree: 3, inverse: -0.5 }),
            StepFailure::Bath(BathError::Masses),
            StepFailure::Bath(BathError::Backwards { h: -0.1 }),
            StepFailure::Index(IndexError::new(
                &Name { name: "an integer", suffix: "" },
                -1,
                IndexLimit::Integers,
            )),
        ];
        for failure in all {
            assert_eq!(StepFailure::from_words(failure.words()), Some(failure));
            for other in all {
                let words = Tape::write(|tape| { failure }.pass(tape));
                let mut read = other;
                assert_eq!(Tape::read(words, |tape| read.pass(tape)), Some(()));
                assert_eq!(read.words(), failure.words());
            }
        }
        for nonsense in [
            // A degree of freedom that no state has.
            [BATH + (1 << 50), 0, 0],
            [u64::MAX, 0, 0],
            [INTERNAL, StepPromise::ALL.len() as u64, 0],
            [0, 1 << 32, 0],
        ] {
            assert_eq!(StepFailure::from_words(nonsense), None);
            let mut untouched = all[0];
            assert_eq!(Tape::read(nonsense.to_vec(), |tape| untouched.pass(tape)), None);
            assert_eq!(untouched, all[0]);
        }
    }
}
