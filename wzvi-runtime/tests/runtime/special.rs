//! Functions that `f64` does not have: values and derivatives against power series of many digits, bits in lanes.

use crate::real::{Real, with_precision};
use wzvi_runtime::algebra::lanes::Lanes;
use wzvi_runtime::algebra::scalar::{Dual, Rounded, Scalar, Special};

/// Digits for the series: of `erf` at 26 the largest term is `exp(26²) = 2^975`, and `erfc` is as small; of the families the
/// largest at 57 is `exp(57) = 2^82`.
fn bits(function: Special) -> usize {
    if matches!(function, Special::Erf | Special::Erfc) { 2400 } else { 400 }
}

fn all() -> Vec<Special> {
    let families = [0, 1, 2, 3, 5, 8].into_iter().flat_map(|n| [Special::Sinc(n), Special::Bessel(n)]);
    [Special::Erf, Special::Erfc].into_iter().chain(families).collect()
}

/// `Σ_k x (-x²)^k/(k! (2k + 1)) 2/√π` and `Σ_k f_n(0) Π_(j<=k) -x²/(2j (2j + 2ν))` (DLMF 7.6.1, 10.2.2).
fn exact(function: Special, x: &Real) -> Real {
    let one = Real::from(1.0);
    let square = x * x;
    let least = bits(function) as i32;
    let (n, half, is_error_function) = match function {
        Special::Erf => (0, 0.0, true),
        Special::Erfc => return one - exact(Special::Erf, x),
        Special::Sinc(n) => (n, 1.0, false),
        Special::Bessel(n) => (n, 0.0, false),
    };
    let twice = |k: u32| 2.0 * f64::from(k) + half;
    let mut term =
        if is_error_function { x.clone() } else { (1..=n).fold(one, |all, k| all / Real::from(twice(k))) };
    let (mut sum, mut k) = (Real::from(0.0), 0);
    loop {
        let divisor = if is_error_function { 2.0 * f64::from(k) + 1.0 } else { 1.0 };
        let added = &term / &Real::from(divisor);
        let is_below =
            added.exponent().is_none_or(|size| sum.exponent().is_some_and(|sum| size < sum - least));
        if is_below {
            break;
        }
        sum = sum + added;
        k += 1;
        let divisor = if is_error_function { f64::from(k) } else { 2.0 * f64::from(k) * twice(n + k) };
        term = term * &square * -1.0 / Real::from(divisor);
    }
    if is_error_function { sum * 2.0 / Real::from(-1.0).acos().sqrt() } else { sum }
}

/// Zero, tiny and ordinary arguments, zeros of the functions, and both sides of each change of method: at `|x| = n`, at
/// 1.5 (normalisation), at 1e-8 (limit), and those of `libm`.
fn arguments() -> Vec<f64> {
    let mut list = vec![
        0.0,
        1e-300,
        1e-9,
        1e-3,
        0.3,
        0.84375,
        1.25,
        2.0,
        2.404825557695773,
        2.857143,
        3.8317059702075125,
    ];
    list.extend([std::f64::consts::PI, 4.493409457909064, 5.5, 8.0, 14.930917708487785, 26.0, 31.4, 57.0]);
    for edge in [1e-8_f64, 1.5].into_iter().chain([1.0, 2.0, 3.0, 5.0, 8.0]) {
        list.extend([edge.next_down(), edge, edge.next_up(), 1.01 * edge]);
    }
    let negative: Vec<f64> = list.iter().map(|x| -x).collect();
    list.extend(negative);
    list
}

/// Those at which the series has its digits.
fn within(function: Special) -> Vec<f64> {
    let is_error_function = matches!(function, Special::Erf | Special::Erfc);
    arguments().into_iter().filter(|x| !is_error_function || x.abs() <= 26.0).collect()
}

#[test]
fn values_are_right_within_their_bounds() {
    let mut worst = 0.0_f64;
    for function in all() {
        for x in within(function) {
            let exact = with_precision(bits(function), || exact(function, &Real::from(x)));
            let error =
                with_precision(bits(function), || (Real::from(function.value(x)) - &exact).to_f64().abs());
            // Where `erfc` underflows, by the smallest number.
            let bound = function.rounding(x) + 5e-324;
            worst = worst.max(error / bound);
            assert!(error <= bound, "{function:?}({x:e}) = {:e}: {error:e} > {bound:e}", function.value(x));
            // The bound is no more than a few units of the largest of value and amplitude.
            let size = exact.to_f64().abs().max(with_precision(bits(function), || amplitude(function, x)));
            assert!(bound <= 40.0 * f64::EPSILON * size + 1e-323, "{function:?}({x:e}): {bound:e} {size:e}");
        }
    }
    println!("largest error: {worst:.2} of its bound");
}

/// The size of the function near `x`: its largest value within a quarter of a period on either side.
fn amplitude(function: Special, x: f64) -> f64 {
    match function {
        Special::Erf | Special::Erfc => 0.0,
        _ => [-1.6, -0.8, 0.8, 1.6]
            .iter()
            .map(|shift| exact(function, &Real::from(x + shift)).to_f64().abs())
            .fold(0.0, f64::max),
    }
}

/// Where it is not smooth in its formula, and everywhere else: `-x f_(n+1)` and the bell against differences of the series.
#[test]
fn derivatives_are_right_at_zero_and_at_changes_of_method() {
    for function in all() {
        for x in within(function) {
            let found = Dual::<1>::variable(x, 0).special(function);
            assert_eq!(found.value.to_bits(), function.value(x).to_bits());
            // Central differences: their error is 2^-240 of the third derivative.
            let exact = with_precision(bits(function), || {
                let width = Real::from(2.0_f64.powi(-120));
                let at = |sign: f64| exact(function, &(Real::from(x) + &width * sign));
                ((at(1.0) - at(-1.0)) / (width * 2.0)).to_f64()
            });
            let next = match function {
                Special::Sinc(n) => (x * Special::Sinc(n + 1).rounding(x)).abs(),
                Special::Bessel(n) => (x * Special::Bessel(n + 1).rounding(x)).abs(),
                _ => 0.0,
            };
            // The argument of the bell has an error of x² units.
            let bound = next + (2.0 + x * x) * f64::EPSILON * exact.abs() + 1e-300;
            let error = (found.derivative[0] - exact).abs();
            assert!(error <= bound, "{function:?}'({x:e}) = {:e}, not {exact:e}", found.derivative[0]);
        }
        if !matches!(function, Special::Erf | Special::Erfc) {
            assert_eq!(Dual::<1>::variable(0.0, 0).special(function).derivative[0], 0.0, "{function:?}");
        }
    }
    let second = Dual { value: Dual::<1>::variable(0.0, 0), derivative: [Dual::constant(1.0)] };
    assert_eq!(second.special(Special::Sinc(0)).derivative[0].derivative[0], -1.0 / 3.0);
    assert_eq!(second.special(Special::Bessel(0)).derivative[0].derivative[0], -0.5);
    let j1 = second * second.special(Special::Bessel(1));
    assert_eq!((j1.derivative[0].value, j1.derivative[0].derivative[0]), (0.5, 0.0));
}

/// A lane, a number alone, and one that carries its rounding: the same bits; and the bound holds for a shifted argument.
#[test]
fn lanes_and_single_numbers_have_the_same_bits() {
    let special = [f64::INFINITY, f64::NEG_INFINITY, f64::NAN, 5e-324, -1e-310, 1e200, f64::MAX, 1e9];
    let list: Vec<f64> = arguments().into_iter().chain(special).collect();
    for function in all() {
        for group in list.windows(8) {
            let beside = Lanes::<8>::new(std::array::from_fn(|i| group[i])).special(function);
            for (lane, &x) in group.iter().enumerate() {
                let alone = function.value(x);
                assert_eq!(beside[lane].to_bits(), alone.to_bits(), "{function:?}({x:e})");
                assert_eq!(Lanes::<1>::new([x]).special(function)[0].to_bits(), alone.to_bits());
                assert_eq!(x.special(function).to_bits(), alone.to_bits());
                assert_eq!(x.is_nan(), alone.is_nan(), "{function:?}({x:e})");
                let width = 1e-3 * x.abs();
                let near = Rounded { value: x, error: width }.special(function);
                for shifted in [x - width, x + width].map(|x| function.value(x)) {
                    let excess = (shifted - near.value).abs();
                    // Infinities and no numbers have no excess.
                    assert!(
                        excess <= near.error || excess.is_nan(),
                        "{function:?}({x:e} ± {width:e}): {excess:e} {:e}",
                        near.error
                    );
                }
            }
        }
        assert_eq!(
            function.value(-0.3).abs().to_bits() == function.value(0.3).abs().to_bits(),
            function != Special::Erfc
        );
    }
    let ends = [Special::Erf, Special::Erfc, Special::Sinc(3), Special::Bessel(0)];
    assert_eq!(ends.map(|function| function.value(f64::INFINITY)), [1.0, 0.0, 0.0, 0.0]);
    assert_eq!(ends.map(|function| function.value(f64::NEG_INFINITY)), [-1.0, 2.0, 0.0, 0.0]);
}
