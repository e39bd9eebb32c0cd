//! Elementary functions whose bits are the same on every machine.
//!
//! The functions of `std` are those of the platform and differ in the last bit between targets. These do not:
//! they use IEEE additions, multiplications, divisions and square roots in a fixed order, without fused
//! operations, so that SSE2, AVX2, AVX-512 and NEON agree. They do not branch for usual arguments, so a loop
//! over an array becomes vector code. One number alone branches past operations whose results are not
//! selected, and takes the others in the same order: its bits are those of a lane. Rare arguments (huge,
//! subnormal, infinite, NaN, out of the domain) take the functions of the crate `libm`, one number at a time,
//! which are as portable. So every result is a function of its argument alone.
//!
//! The formulas and polynomials are those of fdlibm, but for the exponentials and the order of sums:
//!
//! > Copyright (C) 1993, 2004 by Sun Microsystems, Inc. All rights reserved. Permission to use, copy, modify,
//! > and distribute this software is freely granted, provided that this notice is preserved.

mod exponential;
mod hyperbolic;
mod inverse;
mod logarithm;
mod power;
mod trigonometric;

pub(in crate::algebra) use exponential::{Exp, Exp2, ExpM1};
pub(in crate::algebra) use hyperbolic::{Acosh, Asinh, Atanh, Cosh, Sinh, Tanh};
pub(in crate::algebra) use inverse::{Acos, Asin, Atan, Atan2};
#[cfg(feature = "noise")]
pub(crate) use logarithm::ln_shifted;
pub(in crate::algebra) use logarithm::{Ln, Ln1p, Log2, Log10};
pub(in crate::algebra) use power::{Cbrt, Hypot, Pow};
#[cfg(feature = "noise")]
pub(crate) use trigonometric::{COSINE, SINE};
pub(in crate::algebra) use trigonometric::{Cos, Sin, Tan, sin_cos_alone};

/// `name(arguments): fast where condition, else rare`: `fast` is right where the condition holds and has no
/// branches unless it is `ALONE`, `rare` is right elsewhere.
///
/// Not a trait over arrays of arguments: with one, `Gauss<2>` takes 4 % more instructions for a pendulum.
macro_rules! functions {
    ($($(#[$doc:meta])* $name:ident($($x:ident),*): $fast:expr, where $usual:expr, else $rare:path;)*) => {$(
        $(#[$doc])*
        pub(in crate::algebra) struct $name;

        impl $name {
            #[cfg_attr(not(debug_assertions), inline(always))]
            fn is_usual($($x: f64),*) -> bool {
                $usual
            }

            /// The function of usual numbers; `ALONE` if it branches past what its argument does not need.
            #[cfg_attr(not(debug_assertions), inline(always))]
            fn fast<const ALONE: bool>($($x: f64),*) -> f64 {
                $fast
            }

            /// The function of usual numbers, NaN for any other, without branches.
            #[cfg_attr(not(debug_assertions), inline(always))]
            pub(in crate::algebra::lanes) fn usual($($x: f64),*) -> f64 {
                select(Self::is_usual($($x),*), Self::fast::<false>($($x),*), f64::NAN)
            }

            /// The function of any numbers, as a call.
            #[inline(never)]
            pub(in crate::algebra) fn alone($($x: f64),*) -> f64 {
                if Self::is_usual($($x),*) { Self::fast::<true>($($x),*) } else { Self::rare($($x),*) }
            }

            #[cold]
            #[inline(never)]
            fn rare($($x: f64),*) -> f64 {
                $rare($($x),*)
            }

            /// The function of all lanes.
            #[cfg_attr(not(debug_assertions), inline(always))]
            pub(in crate::algebra::lanes) fn of<const L: usize>($($x: [f64; L]),*) -> [f64; L] {
                let (mut y, mut all) = ([0.0; L], true);
                for i in 0..L {
                    y[i] = Self::fast::<false>($($x[i]),*);
                }
                for i in 0..L {
                    all &= Self::is_usual($($x[i]),*);
                }
                if !all {
                    // Copies: what a function that is not inlined gets is in memory.
                    let mut repaired = y;
                    Self::repair($(&{ $x },)* &mut repaired);
                    y = repaired;
                }
                y
            }

            /// Puts in what `fast` cannot do.
            #[cold]
            #[inline(never)]
            fn repair($($x: &[f64],)* y: &mut [f64]) {
                for (i, y) in y.iter_mut().enumerate() {
                    if !Self::is_usual($($x[i]),*) {
                        *y = Self::rare($($x[i]),*);
                    }
                }
            }
        }
    )*};
}
use functions;

/// `choice!(ALONE: condition => a, else b)`: both are computed and one is selected, or only that one if
/// `ALONE`.
macro_rules! choice {
    ($alone:ident: $condition:expr => $a:expr, else $b:expr) => {
        if $alone { if $condition { $a } else { $b } } else { select($condition, $a, $b) }
    };
}
use choice;

/// `ln 2` in two parts: products of the first with integers below 2^20 are exact.
const LN2_HIGH: f64 = 6.931_471_803_691_238e-1;
const LN2_LOW: f64 = 1.908_214_929_270_587_7e-10;

/// Added to a number below 2^51, it puts the nearest integer into the last bits.
const ROUNDER: f64 = 6_755_399_441_055_744.0;

/// The nearest integer, and bits that end in it (two's complement).
#[cfg_attr(not(debug_assertions), inline(always))]
fn nearest(x: f64) -> (f64, u64) {
    let shifted = x + ROUNDER;
    (shifted - ROUNDER, shifted.to_bits())
}

/// `2^-k` for the bits of [`nearest`] and `-1023 <= k <= 1022`.
#[cfg_attr(not(debug_assertions), inline(always))]
fn inverse_power_of_two(bits: u64) -> f64 {
    f64::from_bits(1023_u64.wrapping_sub(bits) << 52)
}

/// A positive normal number as `2^k m` with `m` between `√½` and `√2`: `k` and `m`.
#[cfg_attr(not(debug_assertions), inline(always))]
fn exponent_and_mantissa(x: f64) -> (f64, f64) {
    const ONE: u64 = 0x3ff0_0000_0000_0000;
    const ROOT_HALF: u64 = 0x3fe6_a09e_0000_0000;
    let bits = x.to_bits().wrapping_add(ONE - ROOT_HALF);
    let mantissa = f64::from_bits((bits & 0x000f_ffff_ffff_ffff).wrapping_add(ROOT_HALF));
    (small_integer(bits >> 52) - 1023.0, mantissa)
}

/// An integer below 2^52 as a number; the conversion instruction has no vector form before AVX-512.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn small_integer(n: u64) -> f64 {
    const TWO_52: f64 = 4_503_599_627_370_496.0;
    f64::from_bits(n | TWO_52.to_bits()) - TWO_52
}

/// The number without its last 32 bits: products of two such are exact.
#[cfg_attr(not(debug_assertions), inline(always))]
fn high(x: f64) -> f64 {
    f64::from_bits(x.to_bits() & 0xffff_ffff_0000_0000)
}

/// `a` or `b`; a name for the branchless choice.
#[cfg_attr(not(debug_assertions), inline(always))]
fn select(condition: bool, a: f64, b: f64) -> f64 {
    if condition { a } else { b }
}
