//! Several numbers at once: one trajectory per lane of a vector register.
//!
//! [`Lanes`] is a [`Scalar`]: the generated step of one trajectory, run on it, is the step of `L`
//! trajectories. A lane depends on its own operands only, and every function gives the same bits on every
//! machine and for every `L`. The table has their errors.
//!
//! | function | largest error in units in the last place |
//! |---|---|
//! | `+ - * / sqrt recip abs min max` | 0.5 (correctly rounded) |
//! | `exp exp2 exp_m1` | 0.8 |
//! | `ln ln_1p log2 log10 sin cos tan asin acos atan cbrt powf` | 0.9 |
//! | `hypot` | 1.1 |
//! | `atan2 sinh cosh asinh acosh atanh` | 2 |
//! | `tanh` | 2.2 |
//! | `powi` | half a unit per multiplication |
//! | `special` | [`Special::rounding`] |
//!
//! `f64` has the same functions as a [`Scalar`], bit for bit, and so does a single path.
//!
//! Measured at 1.5e5 arguments per range against arithmetic of 256 bits: `tests/runtime/lanes_accuracy.rs`.
//! Infinities, NaN, zeros with their signs, subnormal and huge arguments give the results of `std`.
#![expect(clippy::needless_range_loop, reason = "plain loops over arrays are what becomes vector code")]

pub(crate) mod common_range;
pub(crate) mod elementary;
pub mod instructions;

use std::ops::{Add, BitAnd, BitOr, Div, Index, Mul, Neg, Not, Sub};

use crate::algebra::scalar::{Mask, Number, Scalar, Special, larger, powi, without_derivatives};
use crate::ground::numbers::{Numbers, Tape};

/// `L` numbers, in registers where they fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lanes<const L: usize>([f64; L]);

/// One truth per lane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LaneMask<const L: usize>([u64; L]);

impl<const L: usize> Lanes<L> {
    /// One number per lane.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub const fn new(numbers: [f64; L]) -> Self {
        Self(numbers)
    }

    /// The number of every lane.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub const fn to_array(self) -> [f64; L] {
        self.0
    }

    /// Replaces the number of one lane.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub const fn set(&mut self, lane: usize, number: f64) {
        self.0[lane] = number;
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn map(self, f: impl Fn(f64) -> f64) -> Self {
        Self(each(|i| f(self.0[i])))
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Self(each(|i| f(self.0[i], other.0[i])))
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn compare(self, other: Self, f: impl Fn(f64, f64) -> bool) -> LaneMask<L> {
        LaneMask(each(|i| spread(f(self.0[i], other.0[i]))))
    }
}

/// The values of a function for each lane. Few lanes are written out. As loops, one for each operation of a
/// step, they would take a compile time that grows with the square of their number.
#[cfg_attr(not(debug_assertions), inline(always))]
fn each<T: Copy + Default, const L: usize>(mut of: impl FnMut(usize) -> T) -> [T; L] {
    let mut list = [T::default(); L];
    macro_rules! written_out {
        ($($i:literal)*) => {{ $(list[$i] = of($i);)* }};
    }
    match L {
        1 => written_out!(0),
        2 => written_out!(0 1),
        4 => written_out!(0 1 2 3),
        8 => written_out!(0 1 2 3 4 5 6 7),
        _ => {
            for i in 0..L {
                list[i] = of(i);
            }
        }
    }
    list
}

/// All bits or none.
#[cfg_attr(not(debug_assertions), inline(always))]
const fn spread(truth: bool) -> u64 {
    if truth { u64::MAX } else { 0 }
}

/// Zeros.
impl<const L: usize> Default for Lanes<L> {
    fn default() -> Self {
        Self([0.0; L])
    }
}

impl<const L: usize> Index<usize> for Lanes<L> {
    type Output = f64;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn index(&self, lane: usize) -> &f64 {
        &self.0[lane]
    }
}

impl<const L: usize> LaneMask<L> {
    /// Replaces the truth of one lane.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub const fn set(&mut self, lane: usize, truth: bool) {
        self.0[lane] = spread(truth);
    }
}

impl<const L: usize> Mask for LaneMask<L> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn of_lanes(mut holds: impl FnMut(usize) -> bool) -> Self {
        Self(each(|lane| spread(holds(lane))))
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn any(self) -> bool {
        let mut any = false;
        for &bits in &self.0 {
            any |= bits != 0;
        }
        any
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn all(self) -> bool {
        let mut all = true;
        for &bits in &self.0 {
            all &= bits != 0;
        }
        all
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn lane(self, lane: usize) -> bool {
        self.0[lane] != 0
    }
    type ByLane<T> = [T; L];
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn by_lane<T>(of: impl FnMut(usize) -> T) -> [T; L] {
        std::array::from_fn(of)
    }
}

macro_rules! bitwise {
    ($($trait:ident $method:ident)*) => {$(
        impl<const L: usize> $trait for LaneMask<L> {
            type Output = Self;

            #[cfg_attr(not(debug_assertions), inline(always))]
            fn $method(self, other: Self) -> Self {
                Self(each(|i| self.0[i].$method(other.0[i])))
            }
        }
    )*};
}

bitwise!(BitAnd bitand BitOr bitor);

impl<const L: usize> Not for LaneMask<L> {
    type Output = Self;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn not(self) -> Self {
        Self(each(|i| !self.0[i]))
    }
}

macro_rules! arithmetic {
    ($($trait:ident $method:ident)*) => {$(
        impl<const L: usize> $trait for Lanes<L> {
            type Output = Self;

            #[cfg_attr(not(debug_assertions), inline(always))]
            fn $method(self, other: Self) -> Self {
                self.zip(other, f64::$method)
            }
        }

        impl<const L: usize> $trait<f64> for Lanes<L> {
            type Output = Self;

            #[cfg_attr(not(debug_assertions), inline(always))]
            fn $method(self, other: f64) -> Self {
                self.map(|x| x.$method(other))
            }
        }
    )*};
}

arithmetic!(Add add Sub sub Mul mul Div div);

impl<const L: usize> Neg for Lanes<L> {
    type Output = Self;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn neg(self) -> Self {
        self.map(f64::neg)
    }
}

macro_rules! by_lane {
    ($($method:ident: $function:ident),*) => {$(
        #[cfg_attr(not(debug_assertions), inline(always))]
        fn $method(self) -> Self {
            Self(elementary::$function::of(self.0))
        }
    )*};
}

impl<const L: usize> Numbers for Lanes<L> {
    fn pass(&mut self, tape: &mut Tape) {
        tape.lanes(&mut self.0);
    }
}

impl<const L: usize> Numbers for LaneMask<L> {
    fn pass(&mut self, tape: &mut Tape) {
        let mut truths = self.0.map(|bits| bits != 0);
        tape.flags(&mut truths);
        self.0 = truths.map(spread);
    }
}

impl<const L: usize> Scalar for Lanes<L> {
    type Stages<const N: usize> = [Self; N];
    type Mask = LaneMask<L>;
    type Constant = f64;
    type OfElements<T: Number<f64>> = Self;

    without_derivatives!();
    const LANES: usize = L;
    const LANES_ARE_PATHS: bool = true;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn from_f64(value: f64) -> Self {
        Self([value; L])
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn of_constant(constant: f64) -> Self {
        Self::from_f64(constant)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn to_constant(self) -> f64 {
        self[0]
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn magnitude(self) -> f64 {
        self.0[1..].iter().fold(self.0[0].abs(), |largest, x| larger(largest, x.abs()))
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn nearly_recip(self) -> Self {
        self.map(f64::nearly_recip)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn lane(self, lane: usize) -> f64 {
        self.0[lane]
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn is_identical(self, other: Self) -> bool {
        let mut is_same = true;
        for i in 0..L {
            is_same &= self.0[i].to_bits() == other.0[i].to_bits();
        }
        is_same
    }
    /// Zero times a finite number is zero, and NaN otherwise.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn is_finite(self) -> LaneMask<L> {
        let zeros = self * 0.0;
        zeros.equal(zeros)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn are_finite<const N: usize>(pairs: [[(Self, Self); N]; 2]) -> LaneMask<L> {
        let mut zero = Self([0.0; L]);
        for pairs in &pairs {
            for (x, _) in pairs {
                zero = zero * *x;
            }
        }
        zero.equal(zero)
    }
    /// Lane by lane: the compiler would turn a loop over the numbers into one over vectors of numbers,
    /// gathered from one lane and scattered.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn weighted<const N: usize>(mut numbers: [Self; N], weights: &[f64; N]) -> [Self; N] {
        for lane in 0..L {
            for i in 0..N {
                numbers[i].0[lane] *= weights[i];
            }
        }
        numbers
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn less(self, other: Self) -> LaneMask<L> {
        self.compare(other, |a, b| a < b)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn less_equal(self, other: Self) -> LaneMask<L> {
        self.compare(other, |a, b| a <= b)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn equal(self, other: Self) -> LaneMask<L> {
        self.compare(other, |a, b| a == b)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn select(mask: LaneMask<L>, then: Self, otherwise: Self) -> Self {
        Self(each(|i| if mask.0[i] != 0 { then.0[i] } else { otherwise.0[i] }))
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn recip(self) -> Self {
        self.map(|x| 1.0 / x)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn powi(self, exponent: i32) -> Self {
        powi(self, exponent)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn powf(self, exponent: Self) -> Self {
        Self(elementary::Pow::of(self.0, exponent.0))
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn sqrt(self) -> Self {
        self.map(f64::sqrt)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn hypot(self, other: Self) -> Self {
        Self(elementary::Hypot::of(self.0, other.0))
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn atan2(self, other: Self) -> Self {
        Self(elementary::Atan2::of(self.0, other.0))
    }

    /// Lane by lane.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn special(self, function: Special) -> Self {
        let mut values = [0.0; L];
        for lane in 0..L {
            values[lane] = function.value(self.0[lane]);
        }
        Self(values)
    }

    by_lane!(cbrt: Cbrt, exp: Exp, exp2: Exp2, exp_m1: ExpM1, ln: Ln, ln_1p: Ln1p, log2: Log2, log10: Log10);
    by_lane!(sin: Sin, cos: Cos, tan: Tan, asin: Asin, acos: Acos, atan: Atan);
    by_lane!(sinh: Sinh, cosh: Cosh, tanh: Tanh, asinh: Asinh, acosh: Acosh, atanh: Atanh);

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn abs(self) -> Self {
        self.map(f64::abs)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn signum(self) -> Self {
        self.map(f64::signum)
    }
}
