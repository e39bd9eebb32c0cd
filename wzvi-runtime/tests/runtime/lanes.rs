//! Lanes: special arguments, and that a lane depends on nothing but itself.

use wzvi_runtime::algebra::lanes::Lanes;
use wzvi_runtime::algebra::scalar::{Mask, Scalar};
use wzvi_runtime::algebra::solve::{nearly_over, relative_to};

/// Every function of one number with the one of `std`.
macro_rules! unary {
    ($width:literal: $($name:ident)*) => {
        [$((stringify!($name), <Lanes<$width> as Scalar>::$name as fn(Lanes<$width>) -> Lanes<$width>, f64::$name as fn(f64) -> f64)),*]
    };
}

macro_rules! all_unary {
    ($width:literal) => {
        unary!($width: recip sqrt cbrt exp exp2 exp_m1 ln ln_1p log2 log10 sin cos tan asin acos atan sinh cosh tanh
               asinh acosh atanh abs signum)
    };
}

const INF: f64 = f64::INFINITY;
const SPECIAL: [f64; 26] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.5,
    -0.5,
    2.0,
    1e-20,
    -1e-20,
    5e-324,
    -5e-324,
    1e-310,
    -1e-310,
    f64::MIN_POSITIVE,
    1e300,
    -1e300,
    f64::MAX,
    f64::MIN,
    709.9,
    -745.2,
    -746.0,
    1e9,
    INF,
    -INF,
    f64::NAN,
    -3.7,
];

/// The same within a few units of rounding; zeros, infinities and NaN exactly, with their signs.
fn agrees(a: f64, b: f64) -> bool {
    if a == 0.0 || b == 0.0 || !a.is_finite() || !b.is_finite() {
        return (a.is_nan() && b.is_nan()) || a.to_bits() == b.to_bits();
    }
    (a - b).abs() <= (4.0 * f64::EPSILON * b.abs()).max(5e-324)
}

#[test]
fn special_arguments_do_what_std_does() {
    for (name, ours, theirs) in all_unary!(2) {
        for x in SPECIAL {
            // Neither alone nor beside a usual number.
            let y = ours(Lanes::new([x, 0.75]));
            // Where `std` overflows.
            let is_huge_inverse = ["asinh", "acosh"].contains(&name) && x.is_finite() && x.abs() > 1e200;
            let expected = theirs(x);
            let expected = if is_huge_inverse && !expected.is_nan() {
                (x.abs().ln() + std::f64::consts::LN_2).copysign(x)
            } else {
                expected
            };
            assert!(agrees(y[0], expected), "{name}({x:e}) = {:e}, not {expected:e}", y[0]);
            assert!(agrees(y[1], theirs(0.75)), "{name} of the lane beside {x:e}");
        }
    }
}

#[test]
fn special_pairs_do_what_std_does() {
    type Pair = (&'static str, fn(Lanes<1>, Lanes<1>) -> Lanes<1>, fn(f64, f64) -> f64);
    let functions: [Pair; 5] = [
        ("powf", Scalar::powf, f64::powf),
        ("hypot", Scalar::hypot, f64::hypot),
        ("atan2", Scalar::atan2, f64::atan2),
        ("min", Scalar::min, f64::min),
        ("max", Scalar::max, f64::max),
    ];
    for (name, ours, theirs) in functions {
        for a in SPECIAL {
            for b in SPECIAL {
                let (y, expected) = (ours(Lanes::new([a]), Lanes::new([b]))[0], theirs(a, b));
                // `min` and `max` of two zeros may be either.
                let is_zero = a == 0.0 && b == 0.0 && name.starts_with('m') && y == 0.0;
                assert!(is_zero || agrees(y, expected), "{name}({a:e}, {b:e}) = {y:e}, not {expected:e}");
            }
        }
    }
}

#[test]
fn integer_powers() {
    for x in [0.0, -0.0, 1.5, -2.5, INF, -INF, 1e200, 1e-200, f64::NAN] {
        for n in [0, 1, 2, 3, 7, -1, -2, -5, i32::MAX, i32::MIN] {
            let (y, expected) = (Lanes::new([x]).powi(n)[0], x.powi(n));
            assert!(
                agrees(y, expected) || (y - expected).abs() <= 1e-15 * expected.abs(),
                "{x}^{n}: {y} {expected}"
            );
        }
    }
    assert_eq!(Lanes::new([3.0, -2.0]).powi(5), Lanes::new([243.0, -32.0]));
}

/// Arguments of every kind: usual ones, and rare ones between them.
fn mixed(n: usize) -> f64 {
    let unit = (n as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) as f64 / 2f64.powi(64);
    if n % 7 == 3 { SPECIAL[n % SPECIAL.len()] } else { 4.0 * unit - 1.0 }
}

/// One lane, two, eight, and eight in another order: the same bits.
#[test]
fn a_lane_depends_on_itself_alone() {
    let (one, two, eight) = (all_unary!(1), all_unary!(2), all_unary!(8));
    for start in 0..400 {
        let x: [f64; 8] = std::array::from_fn(|i| mixed(8 * start + i));
        for f in 0..one.len() {
            let alone = x.map(|x| one[f].1(Lanes::new([x]))[0].to_bits());
            let together = eight[f].1(Lanes::new(x)).to_array().map(f64::to_bits);
            let mut backwards = x;
            backwards.reverse();
            let mut turned = eight[f].1(Lanes::new(backwards)).to_array().map(f64::to_bits);
            turned.reverse();
            for i in 0..8 {
                let pair = two[f].1(Lanes::new([x[i], x[7 - i]]))[0].to_bits();
                for bits in [together[i], turned[i], pair] {
                    let same = bits == alone[i]
                        || (f64::from_bits(bits).is_nan() && f64::from_bits(alone[i]).is_nan());
                    assert!(same, "{} of {:e}", one[f].0, x[i]);
                }
            }
        }
    }
}

/// A number alone branches past what it does not need, and has the bits of a lane.
#[test]
fn a_number_alone_is_a_lane() {
    let are_same = |a: f64, b: f64| a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan());
    macro_rules! unary {
        ($x:ident: $($name:ident)*) => {$(
            let (alone, lane) = (<f64 as Scalar>::$name($x), Lanes::new([$x, 0.5]).$name()[0]);
            assert!(are_same(alone, lane), "{}({:e}): {alone:e} {lane:e}", stringify!($name), $x);
        )*};
    }
    macro_rules! binary {
        ($x:ident $y:ident: $($name:ident)*) => {$(
            let (alone, lane) = (<f64 as Scalar>::$name($x, $y), Lanes::new([$x]).$name(Lanes::new([$y]))[0]);
            assert!(are_same(alone, lane), "{}({:e}, {:e}): {alone:e} {lane:e}", stringify!($name), $x, $y);
        )*};
    }
    for n in 0..3000 {
        for scale in [1e-3, 0.3, 1.0, 40.0, 1e5] {
            let (x, y) = (scale * mixed(n), mixed(n + 1000));
            unary!(x: recip sqrt cbrt exp exp2 exp_m1 ln ln_1p log2 log10 sin cos tan asin acos atan sinh cosh tanh
                asinh acosh atanh abs signum);
            binary!(x y: powf hypot atan2 min max);
            let ((sin, cos), lanes) = (Scalar::sin_cos(x), Lanes::new([x]).sin_cos());
            assert!(are_same(sin, lanes.0[0]) && are_same(cos, lanes.1[0]), "sin_cos({x:e})");
            for power in [-3, 0, 2, 7, 14] {
                assert!(are_same(Scalar::powi(x, power), Lanes::new([x]).powi(power)[0]), "{x:e}^{power}");
            }
        }
    }
    // Of two zeros the first.
    for [a, b] in [[0.0, -0.0], [-0.0, 0.0_f64]] {
        for of_zeros in [Scalar::min(a, b), Scalar::max(a, b), Lanes::new([a]).min(Lanes::new([b]))[0]] {
            assert_eq!(of_zeros.to_bits(), a.to_bits());
        }
    }
}

/// Arithmetic is that of `f64`, comparisons and choices go by lane.
#[test]
fn arithmetic_and_masks() {
    let a = Lanes::new([1.5, -0.0, INF, f64::NAN]);
    let b = Lanes::new([0.1, 0.0, -INF, 2.0]);
    let bits = |x: Lanes<4>| x.to_array().map(f64::to_bits);
    let by_hand = |f: fn(f64, f64) -> f64| std::array::from_fn::<u64, 4, _>(|i| f(a[i], b[i]).to_bits());
    assert_eq!(bits(a + b)[..2], by_hand(|x, y| x + y)[..2]);
    assert_eq!(bits(a * b)[..2], by_hand(|x, y| x * y)[..2]);
    assert_eq!(bits(a - b)[..3], by_hand(|x, y| x - y)[..3]);
    assert_eq!(bits(b / a)[0], (0.1f64 / 1.5).to_bits());
    assert_eq!(bits(-a)[..3], [(-1.5f64).to_bits(), 0.0f64.to_bits(), (-INF).to_bits()]);
    let less = b.less(a);
    assert_eq!([0, 1, 2, 3].map(|i| less.lane(i)), [true, false, true, false]);
    assert_eq!([0, 1, 2, 3].map(|i| a.less_equal(b).lane(i)), [false, true, false, false]);
    assert_eq!([0, 1, 2, 3].map(|i| a.equal(b).lane(i)), [false, true, false, false]);
    assert_eq!([0, 1, 2, 3].map(|i| a.is_finite().lane(i)), [true, true, false, false]);
    assert!(!less.all() && less.any() && (less | !less).all() && !(less & !less).any());
    let chosen = Scalar::select(less, a, b);
    assert_eq!([chosen[0], chosen[1], chosen[2], chosen[3]], [1.5, 0.0, INF, 2.0]);
    assert_eq!(Lanes::new([1.0, -3.0]).magnitude(), 3.0);
    assert!(a.magnitude().is_nan() && relative_to(a, b).is_nan());
    let zero = Lanes::new([0.0, 0.0]);
    assert!(
        !<Lanes<2> as Scalar>::are_finite([
            [(Lanes::new([1.0, 2.0]), zero)],
            [(Lanes::new([1.0, INF]), zero)]
        ])
        .all()
    );
    let (s, c) = Lanes::new([0.3, 2.0]).sin_cos();
    assert_eq!((s, c), (Lanes::new([0.3, 2.0]).sin(), Lanes::new([0.3, 2.0]).cos()));
}

/// A list times its weights, in few lanes and in many.
#[test]
fn weights_are_those_of_the_numbers() {
    fn holds<const L: usize>() {
        let number = |i: usize, lane: usize| mixed(40 * i + lane);
        let numbers: [Lanes<L>; 5] =
            std::array::from_fn(|i| Lanes::new(std::array::from_fn(|lane| number(i, lane))));
        let weights: [f64; 5] = std::array::from_fn(|i| 0.1 + i as f64 / 3.0);
        for (i, products) in Scalar::weighted(numbers, &weights).into_iter().enumerate() {
            for lane in 0..L {
                assert!(agrees(products[lane], number(i, lane) * weights[i]), "{L}: {i}, {lane}");
            }
        }
    }
    holds::<1>();
    holds::<4>();
    holds::<8>();
    holds::<16>();
    holds::<32>();
}

/// What is no number is as far as it can be, and so it stays whatever it is compared with.
#[test]
fn quotients_that_are_near_end_at_the_largest_number() {
    let near = |x: f64, size: f64| {
        let alone = nearly_over(x, size);
        assert!(agrees(nearly_over(Lanes::<16>::new([x; 16]), Lanes::new([size; 16]))[3], alone));
        alone
    };
    for (x, size) in [(1.0, 3.0), (-2.5, 7e10), (1e-300, 2.0), (3e8, 1e-9)] {
        assert!((near(x, size) / (x / size).abs() - 1.0).abs() <= 0.125, "{x} / {size}");
    }
    for (x, size) in [(f64::NAN, 1.0), (INF, 1.0), (1e300, 1e-300), (-1e300, 1e-300)] {
        assert_eq!(near(x, size), f64::MAX, "{x} / {size}");
    }
    assert_eq!(near(0.0, 1.0), 0.0);
}
