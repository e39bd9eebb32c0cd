//! A number that counts how often a sine is taken: the evaluations of the force of a pendulum.

use std::cell::Cell;
use std::ops::{Add, Div, Mul, Neg, Sub};

use wzvi::numbers::{Numbers, Tape};
use wzvi::scalar::{Scalar, Special};

thread_local! {
    static SINES: Cell<u32> = const { Cell::new(0) };
}

/// How many sines were taken since the last question.
pub(super) fn sines() -> u32 {
    SINES.take()
}

#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Counted(pub(super) f64);

impl Neg for Counted {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

macro_rules! operators {
    ($($name:ident $method:ident),*) => {$(
        impl $name for Counted {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                Self(self.0.$method(other.0))
            }
        }
        impl $name<f64> for Counted {
            type Output = Self;
            fn $method(self, other: f64) -> Self {
                Self(self.0.$method(other))
            }
        }
    )*};
}

operators!(Add add, Sub sub, Mul mul, Div div);

impl Numbers for Counted {
    fn pass(&mut self, tape: &mut Tape) {
        self.0.pass(tape);
    }
}

macro_rules! functions {
    ($($name:ident)*) => {$(
        fn $name(self) -> Self {
            Self(Scalar::$name(self.0))
        }
    )*};
}

macro_rules! functions_of_two {
    ($($name:ident)*) => {$(
        fn $name(self, other: Self) -> Self {
            Self(Scalar::$name(self.0, other.0))
        }
    )*};
}

impl Scalar for Counted {
    type Mask = bool;
    type Constant = f64;
    type Stages<const N: usize> = [Self; N];
    type OfElements<T: wzvi::scalar::Number<f64>> = Self;
    type Value = Self;

    fn value(self) -> Self {
        self
    }
    fn of_value(value: Self) -> Self {
        value
    }

    fn sin(self) -> Self {
        SINES.set(SINES.get() + 1);
        Self(self.0.sin())
    }
    fn sin_cos(self) -> (Self, Self) {
        (self.sin(), self.cos())
    }
    fn from_f64(value: f64) -> Self {
        Self(value)
    }
    fn of_constant(constant: f64) -> Self {
        Self(constant)
    }
    fn to_constant(self) -> f64 {
        self.0
    }
    fn magnitude(self) -> f64 {
        self.0.abs()
    }
    fn lane(self, _: usize) -> f64 {
        self.0
    }
    fn is_identical(self, other: Self) -> bool {
        self.0.is_identical(other.0)
    }
    fn is_finite(self) -> bool {
        self.0.is_finite()
    }
    fn less(self, other: Self) -> bool {
        self.0 < other.0
    }
    fn less_equal(self, other: Self) -> bool {
        self.0 <= other.0
    }
    fn equal(self, other: Self) -> bool {
        self.0 == other.0
    }
    fn select(mask: bool, then: Self, otherwise: Self) -> Self {
        if mask { then } else { otherwise }
    }
    fn special(self, function: Special) -> Self {
        Self(self.0.special(function))
    }
    fn powi(self, exponent: i32) -> Self {
        Self(self.0.powi(exponent))
    }
    functions! {
        recip sqrt cbrt exp exp2 exp_m1 ln ln_1p log2 log10 cos tan asin acos atan sinh cosh tanh asinh acosh atanh abs
        signum
    }
    functions_of_two!(powf hypot atan2 min max);
}
