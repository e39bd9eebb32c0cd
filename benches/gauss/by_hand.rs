//! Gauss steps as an expert writes them for one system: all stages in the lanes of one register, in Nyström form, started from the
//! slopes of the step before, with compensated sums. No errors, no events, no other systems.
//!
//! Products and sums are fused where the target of the build has such an instruction (`RUSTFLAGS="-C target-cpu=native"`); the
//! library never fuses them, so that its bits are the same everywhere.

use wzvi::lanes::instructions::{InstructionSet, Kernel};

/// A system with unit masses.
pub(crate) trait Force<const D: usize> {
    fn of<const S: usize>(q: &[[f64; S]; D], force: &mut [[f64; S]; D]);
}

pub(crate) struct Pendulum;
pub(crate) struct HenonHeiles;
pub(crate) struct Kepler;

impl Force<1> for Pendulum {
    #[inline(always)]
    fn of<const S: usize>(q: &[[f64; S]; 1], force: &mut [[f64; S]; 1]) {
        for (force, q) in force[0].iter_mut().zip(&q[0]) {
            *force = -sine(*q);
        }
    }
}

impl Force<2> for HenonHeiles {
    #[inline(always)]
    fn of<const S: usize>(q: &[[f64; S]; 2], force: &mut [[f64; S]; 2]) {
        for i in 0..S {
            let (x, y) = (q[0][i], q[1][i]);
            (force[0][i], force[1][i]) = (-fused(2.0 * x, y, x), fused(y, y, -fused(x, x, y)));
        }
    }
}

impl Force<2> for Kepler {
    #[inline(always)]
    fn of<const S: usize>(q: &[[f64; S]; 2], force: &mut [[f64; S]; 2]) {
        for i in 0..S {
            let square = fused(q[0][i], q[0][i], q[1][i] * q[1][i]);
            let factor = -1.0 / (square * square.sqrt());
            (force[0][i], force[1][i]) = (q[0][i] * factor, q[1][i] * factor);
        }
    }
}

#[inline(always)]
fn fused(a: f64, b: f64, c: f64) -> f64 {
    if cfg!(target_feature = "fma") { a.mul_add(b, c) } else { a * b + c }
}

/// Reduced by a multiple of π in two parts, then an odd polynomial of degree 19: right to two units in the last place for small
/// arguments.
#[inline(always)]
fn sine(x: f64) -> f64 {
    const ROUNDER: f64 = 6_755_399_441_055_744.0;
    const HIGH: f64 = 3.141_592_653_468_251_2;
    const LOW: f64 = 1.215_420_125_655_342e-10;
    const C: [f64; 9] = [
        -0.166_666_666_666_666_66,
        0.008_333_333_333_333_33,
        -0.000_198_412_698_412_696_16,
        2.755_731_921_987_376e-6,
        -2.505_210_837_635_020_5e-8,
        1.605_904_306_056_645e-10,
        -7.647_122_191_181_588e-13,
        2.810_099_727_108_632e-15,
        -7.972_559_550_090_379e-18,
    ];
    let shifted = fused(x, std::f64::consts::FRAC_1_PI, ROUNDER);
    let n = shifted - ROUNDER;
    let r = fused(-n, LOW, fused(-n, HIGH, x));
    let y = r * r;
    let y2 = y * y;
    let y4 = y2 * y2;
    let low = fused(fused(C[3], y, C[2]), y2, fused(C[1], y, C[0]));
    let high = fused(C[8], y4, fused(fused(C[7], y, C[6]), y2, fused(C[5], y, C[4])));
    f64::from_bits(fused(fused(high, y4, low), r * y, r).to_bits() ^ (shifted.to_bits() << 63))
}

/// Nodes, weights, `(A²)_ij / b_j` and the matrix of the prediction, both by columns.
pub(crate) struct Coefficients<const S: usize> {
    pub(crate) c: [f64; S],
    pub(crate) b: [f64; S],
    pub(crate) eta: [[f64; S]; S],
    pub(crate) kappa: [[f64; S]; S],
}

/// `P_0(y) ... P_{s+1}(y)`
pub(crate) fn legendre(y: f64, s: usize) -> Vec<f64> {
    let mut p = vec![1.0, y];
    for k in 1..=s {
        let n = k as f64;
        p.push(((2.0 * n + 1.0) * y * p[k] - n * p[k - 1]) / (n + 1.0));
    }
    p
}

/// `(2k+1) ∫∫ P_k` from `end` to `y` in the variable of the step; the inner one is taken for its interpolant if `sampled`.
fn twice(y: f64, end: f64, s: usize, sampled: bool) -> Vec<f64> {
    let p = legendre(y, s);
    let once = |k: usize| match k {
        0 => 0.5 * (y - end),
        _ => 0.5 * (p[k + 1] - p[k - 1]) / (2.0 * k as f64 + 1.0),
    };
    let term = |k: usize| match k {
        0 => 0.5 * once(0) * once(0),
        _ if sampled && k + 1 == s => -0.5 * once(k - 1),
        _ => 0.5 * (once(k + 1) - once(k - 1)),
    };
    (0..s).map(term).collect()
}

impl<const S: usize> Coefficients<S> {
    pub(crate) fn new() -> Self {
        let root = |i: usize| {
            let angle = std::f64::consts::PI * (4.0 * (S - i) as f64 - 1.0) / (4.0 * S as f64 + 2.0);
            (0..8).fold(angle.cos(), |y, _| {
                let p = legendre(y, S);
                y - p[S] * (1.0 - y * y) / (S as f64 * (p[S - 1] - y * p[S]))
            })
        };
        let y: [f64; S] = std::array::from_fn(root);
        let weight = |y: f64| {
            let slope = S as f64 * legendre(y, S)[S - 1] / (1.0 - y * y);
            1.0 / ((1.0 - y * y) * slope * slope)
        };
        let matrix = |shift: f64, end: f64, sampled: bool| {
            y.map(|of| {
                let p = legendre(of, S);
                y.map(|at| {
                    twice(at + shift, end, S, sampled).iter().zip(&p).map(|(integral, p)| integral * p).sum()
                })
            })
        };
        Self {
            c: y.map(|y| 0.5 * (y + 1.0)),
            b: y.map(weight),
            eta: matrix(0.0, -1.0, true),
            kappa: matrix(2.0, 1.0, false),
        }
    }
}

/// `Σ_j matrix_j list_j` in two sums, with products and sums fused if `IS_FUSED`.
#[inline(always)]
fn product<const S: usize, const IS_FUSED: bool>(matrix: &[[f64; S]; S], list: &[f64; S]) -> [f64; S] {
    let term = |a: f64, b: f64, c: f64| if IS_FUSED { a.mul_add(b, c) } else { a * b + c };
    let (mut even, mut odd) = ([0.0; S], [0.0; S]);
    for (columns, factors) in matrix.chunks_exact(2).zip(list.chunks_exact(2)) {
        for i in 0..S {
            even[i] = term(columns[0][i], factors[0], even[i]);
            odd[i] = term(columns[1][i], factors[1], odd[i]);
        }
    }
    for i in 0..S {
        even[i] += odd[i];
    }
    even
}

/// The next sweep changes no more than this fraction of a rounding, as in the library: with a fiftieth the energy drifts.
pub(crate) const UNSEEN: f64 = 1e-6;

/// What a run ends with: coordinates, momenta, sweeps.
pub(crate) type End<const D: usize> = ([f64; D], [f64; D], u64);

struct Run<'a, F, const D: usize, const S: usize, const IS_FUSED: bool> {
    force: std::marker::PhantomData<F>,
    start: [[f64; D]; 2],
    h: f64,
    steps: u32,
    table: &'a Coefficients<S>,
}

/// Steps of even `S`, with the instructions that the machine has.
pub(crate) fn run<F: Force<D>, const D: usize, const S: usize>(
    table: &Coefficients<S>,
    start: [[f64; D]; 2],
    h: f64,
    steps: u32,
) -> End<D> {
    run_with::<F, D, S, { cfg!(target_feature = "fma") }>(InstructionSet::best(), table, start, h, steps)
}

/// The same with other instructions, and with fused sums over the stages if `IS_FUSED`.
pub(crate) fn run_with<F: Force<D>, const D: usize, const S: usize, const IS_FUSED: bool>(
    instructions: InstructionSet,
    table: &Coefficients<S>,
    start: [[f64; D]; 2],
    h: f64,
    steps: u32,
) -> End<D> {
    let force = std::marker::PhantomData::<F>;
    instructions.run(Run::<_, D, S, IS_FUSED> { force, start, h, steps, table })
}

impl<F: Force<D>, const D: usize, const S: usize, const IS_FUSED: bool> Kernel
    for Run<'_, F, D, S, IS_FUSED>
{
    type Output = End<D>;

    #[inline(always)]
    fn run<const L: usize, const HALF: usize>(self) -> End<D> {
        let Self {
            start: [mut q, mut p], h, steps, table: &Coefficients { c, b, ref eta, ref kappa }, ..
        } = self;
        let (mut lost_q, mut lost_p) = ([0.0; D], [0.0; D]);
        let mut slopes = [[0.0; S]; D];
        let mut weights = b;
        for weight in &mut weights {
            *weight *= h;
        }
        let mut sweeps = 0;
        for _ in 0..steps {
            let (mut unforced, mut stages) = ([[0.0; S]; D], [[0.0; S]; D]);
            let mut inverse = [0.0; D];
            for d in 0..D {
                let (moved, predicted) = (h * p[d], product::<S, IS_FUSED>(kappa, &slopes[d]));
                for i in 0..S {
                    unforced[d][i] = fused(c[i], moved, lost_q[d]);
                    stages[d][i] = q[d] + fused(h, predicted[i], unforced[d][i]);
                }
                inverse[d] = 1.0 / (q[d].abs() + moved.abs());
            }
            let mut last = 0.0;
            for sweep in 1..=60 {
                let mut force = [[0.0; S]; D];
                F::of(&stages, &mut force);
                let mut changes = [0.0; S];
                for d in 0..D {
                    for i in 0..S {
                        slopes[d][i] = weights[i] * force[d][i];
                    }
                    let forced = product::<S, IS_FUSED>(eta, &slopes[d]);
                    for i in 0..S {
                        let next = q[d] + fused(h, forced[i], unforced[d][i]);
                        let change = (next - stages[d][i]).abs() * inverse[d];
                        changes[i] = if change > changes[i] { change } else { changes[i] };
                        stages[d][i] = next;
                    }
                }
                let change = changes.into_iter().fold(0.0, f64::max);
                let is_small = change < 0.5 * last && change * change <= UNSEEN * f64::EPSILON * last;
                if is_small || change <= 0.0005 * f64::EPSILON || sweep == 60 {
                    sweeps += sweep;
                    break;
                }
                if sweep > 2 && change >= 0.5 * last && change < 4.0 * f64::EPSILON {
                    sweeps += sweep;
                    break;
                }
                last = change;
            }
            for d in 0..D {
                let (mut sum, mut moment) = (0.0, 0.0);
                for i in 0..S {
                    sum += slopes[d][i];
                    moment = fused(c[i], slopes[d][i], moment);
                }
                (q[d], lost_q[d]) = added(q[d], h * (p[d] + (sum - moment)) + h * lost_p[d] + lost_q[d]);
                (p[d], lost_p[d]) = added(p[d], sum + lost_p[d]);
            }
        }
        (q, p, sweeps)
    }
}

/// The sum, and what rounding takes from it.
#[inline(always)]
pub(crate) fn added(base: f64, increment: f64) -> (f64, f64) {
    let sum = base + increment;
    (sum, increment - (sum - base))
}
