//! The same steps as an expert writes them: solved to the last digit, a typed error instead of a result that is not
//! finite, the state untouched on an error, time as `t_0 + n h`.

use std::hint::black_box;

/// Coordinates, momenta and time.
#[derive(Clone, Copy)]
pub(crate) struct State<const D: usize> {
    pub(crate) q: [f64; D],
    pub(crate) p: [f64; D],
    pub(crate) t: f64,
}

/// Why a step failed.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Failure {
    NonFinite,
    NotConverged,
}

/// One step in place; the answer is the number of iterations.
pub(crate) trait Step<const D: usize, const K: usize> {
    fn step(&mut self, state: &mut State<D>, dw: [f64; K]) -> Result<u32, Failure>;
}

const MOST_ITERATIONS: u32 = 50;

/// Time as `start + n h`.
struct Clock {
    start: f64,
    ticks: u64,
    h: f64,
}

impl Clock {
    fn new(h: f64) -> Self {
        Self { start: black_box(0.0), ticks: 0, h }
    }

    /// Commits what is finite.
    #[inline(always)]
    fn commit<const D: usize>(
        &mut self,
        state: &mut State<D>,
        q: [f64; D],
        p: [f64; D],
    ) -> Result<(), Failure> {
        let ticks = self.ticks + 1;
        let t = self.start + ticks.cast_signed() as f64 * self.h;
        // Zero times a finite number is zero, and NaN otherwise.
        if q.iter().chain(&p).fold(t * 0.0, |sum, x| sum + x * 0.0).is_nan() {
            return Err(Failure::NonFinite);
        }
        self.ticks = ticks;
        *state = State { q, p, t };
        Ok(())
    }
}

pub(crate) struct Kubo {
    half_turn: f64,
    half_sigma: f64,
    clock: Clock,
}

impl Kubo {
    pub(crate) fn new(a: f64, sigma: f64, h: f64) -> Self {
        Self { half_turn: 0.5 * a * h, half_sigma: 0.5 * sigma, clock: Clock::new(h) }
    }
}

/// The Cayley map of the rotation.
impl Step<1, 1> for Kubo {
    #[inline]
    fn step(&mut self, state: &mut State<1>, [dw]: [f64; 1]) -> Result<u32, Failure> {
        let ([q], [p]) = (state.q, state.p);
        let c = self.half_turn + self.half_sigma * dw;
        let d = 1.0 / (1.0 + c * c);
        let (cos, sin) = ((1.0 - c * c) * d, 2.0 * c * d);
        self.clock.commit(state, [sin * p + cos * q], [cos * p - sin * q])?;
        Ok(0)
    }
}

pub(crate) struct TwoAdditive {
    cos: f64,
    sin: f64,
    /// What an increment of the first and of the second noise adds to `q` and to `p`.
    by_first: [f64; 2],
    by_second: [f64; 2],
    clock: Clock,
}

impl TwoAdditive {
    pub(crate) fn new(sigma: f64, gamma: f64, h: f64) -> Self {
        let c = 0.5 * h;
        let d = 1.0 / (1.0 + c * c);
        Self {
            cos: (1.0 - c * c) * d,
            sin: 2.0 * c * d,
            by_first: [sigma * d, -sigma * c * d],
            by_second: [gamma * c * d, gamma * d],
            clock: Clock::new(h),
        }
    }
}

impl Step<1, 2> for TwoAdditive {
    #[inline]
    fn step(&mut self, state: &mut State<1>, [a, b]: [f64; 2]) -> Result<u32, Failure> {
        let ([q], [p]) = (state.q, state.p);
        let next_q = self.cos * q + self.sin * p + self.by_first[0] * a + self.by_second[0] * b;
        let next_p = self.cos * p - self.sin * q + self.by_first[1] * a + self.by_second[1] * b;
        self.clock.commit(state, [next_q], [next_p])?;
        Ok(0)
    }
}

pub(crate) struct DoubleWell {
    half_h: f64,
    half_sigma: f64,
    clock: Clock,
}

impl DoubleWell {
    pub(crate) fn new(sigma: f64, h: f64) -> Self {
        Self { half_h: 0.5 * h, half_sigma: 0.5 * sigma, clock: Clock::new(h) }
    }
}

/// `P` is eliminated: `P = (p - h/2 (Q³ - Q)) / (1 + w)`, `(1 - w) Q = q + h/2 P`.
impl Step<1, 1> for DoubleWell {
    #[inline]
    fn step(&mut self, state: &mut State<1>, [dw]: [f64; 1]) -> Result<u32, Failure> {
        let ([q], [p], w) = (state.q, state.p, self.half_sigma * dw);
        let inverse = 1.0 / (1.0 + w);
        let (k, less) = (self.half_h * inverse, 1.0 - w);
        let mut mid = q;
        let mut iterations = 0;
        loop {
            let square = mid * mid;
            let residual = mid * less - q - k * (p - self.half_h * (square - 1.0) * mid);
            let slope = less + k * self.half_h * (3.0 * square - 1.0);
            let correction = residual / slope;
            mid -= correction;
            iterations += 1;
            // Quadratic convergence: the next correction is below 1e-18.
            if correction.abs() <= 1e-8 {
                break;
            }
            if iterations == MOST_ITERATIONS {
                return Err(Failure::NotConverged);
            }
        }
        let momentum = (p - self.half_h * (mid * mid - 1.0) * mid) * inverse;
        self.clock.commit(state, [2.0 * mid - q], [2.0 * momentum - p])?;
        Ok(iterations)
    }
}

pub(crate) struct Pendulum {
    h: f64,
    half_h: f64,
    quarter: f64,
    /// The sines of the two steps before.
    past: [f64; 2],
    clock: Clock,
}

impl Pendulum {
    pub(crate) fn new(h: f64) -> Self {
        let start = 2.0_f64.sin();
        Self { h, half_h: 0.5 * h, quarter: 0.25 * h * h, past: [start; 2], clock: Clock::new(h) }
    }
}

/// `pend_warm` of the baselines, with the checks.
impl Step<1, 0> for Pendulum {
    #[inline]
    fn step(&mut self, state: &mut State<1>, _: [f64; 0]) -> Result<u32, Failure> {
        let ([q], [p]) = (state.q, state.p);
        let base = q + self.half_h * p;
        let mut mid = base - self.quarter * (2.0 * self.past[0] - self.past[1]);
        let mut iterations = 0;
        let force = loop {
            let (sin, cos) = mid.sin_cos();
            let correction = (mid - base + self.quarter * sin) / (1.0 + self.quarter * cos);
            mid -= correction;
            iterations += 1;
            // What remains is below h² d² / 8 < 2e-17.
            if correction.abs() <= 1e-7 {
                break sin - correction * cos;
            }
            if iterations == MOST_ITERATIONS {
                return Err(Failure::NotConverged);
            }
        };
        self.clock.commit(state, [2.0 * mid - q], [p - self.h * force])?;
        self.past = [force, self.past[0]];
        Ok(iterations)
    }
}

pub(crate) struct PendulumEuler {
    h: f64,
    clock: Clock,
}

impl PendulumEuler {
    pub(crate) fn new(h: f64) -> Self {
        Self { h, clock: Clock::new(h) }
    }
}

impl Step<1, 0> for PendulumEuler {
    #[inline]
    fn step(&mut self, state: &mut State<1>, _: [f64; 0]) -> Result<u32, Failure> {
        let ([q], [p]) = (state.q, state.p);
        let next_p = p - self.h * q.sin();
        self.clock.commit(state, [q + self.h * next_p], [next_p])?;
        Ok(0)
    }
}

/// Two unknowns from the extrapolated accelerations of the steps before.
struct Plane {
    h: f64,
    half_h: f64,
    quarter: f64,
    past: [[f64; 2]; 2],
    known: bool,
    clock: Clock,
}

impl Plane {
    fn new(h: f64) -> Self {
        Self {
            h,
            half_h: 0.5 * h,
            quarter: 0.25 * h * h,
            past: [[0.0; 2]; 2],
            known: false,
            clock: Clock::new(h),
        }
    }

    /// `acceleration` answers with `a` and the derivatives `a_xx`, `a_xy`, `a_yy`.
    #[inline(always)]
    fn step(
        &mut self,
        state: &mut State<2>,
        tolerance: f64,
        acceleration: impl Fn(f64, f64) -> ([f64; 2], [f64; 3]),
    ) -> Result<u32, Failure> {
        let ([x, y], [u, v]) = (state.q, state.p);
        let (base_x, base_y) = (x + self.half_h * u, y + self.half_h * v);
        let [last, before] = self.past;
        let mut mid_x = base_x + self.quarter * (2.0 * last[0] - before[0]);
        let mut mid_y = base_y + self.quarter * (2.0 * last[1] - before[1]);
        let mut iterations = 0;
        let force = loop {
            let ([a, b], [axx, axy, ayy]) = acceleration(mid_x, mid_y);
            let (f, g) = (mid_x - base_x - self.quarter * a, mid_y - base_y - self.quarter * b);
            let (jxx, jxy, jyy) = (1.0 - self.quarter * axx, -self.quarter * axy, 1.0 - self.quarter * ayy);
            let inverse = 1.0 / (jxx * jyy - jxy * jxy);
            let (dx, dy) = ((jyy * f - jxy * g) * inverse, (jxx * g - jxy * f) * inverse);
            mid_x -= dx;
            mid_y -= dy;
            iterations += 1;
            if dx.abs() + dy.abs() <= tolerance {
                break [a - axx * dx - axy * dy, b - axy * dx - ayy * dy];
            }
            if iterations == MOST_ITERATIONS {
                return Err(Failure::NotConverged);
            }
        };
        let p = [u + self.h * force[0], v + self.h * force[1]];
        self.clock.commit(state, [2.0 * mid_x - x, 2.0 * mid_y - y], p)?;
        self.past = [force, if self.known { last } else { force }];
        self.known = true;
        Ok(iterations)
    }
}

pub(crate) struct Kepler(Plane);

impl Kepler {
    pub(crate) fn new(h: f64) -> Self {
        Self(Plane::new(h))
    }
}

impl Step<2, 0> for Kepler {
    #[inline]
    fn step(&mut self, state: &mut State<2>, _: [f64; 0]) -> Result<u32, Failure> {
        self.0.step(state, 1e-9, |x, y| {
            let inverse = 1.0 / (x * x + y * y);
            let w = inverse * inverse.sqrt();
            let t = 3.0 * w * inverse;
            ([-w * x, -w * y], [t * x * x - w, t * x * y, t * y * y - w])
        })
    }
}

pub(crate) struct HenonHeiles(Plane);

impl HenonHeiles {
    pub(crate) fn new(h: f64) -> Self {
        Self(Plane::new(h))
    }
}

impl Step<2, 0> for HenonHeiles {
    #[inline]
    fn step(&mut self, state: &mut State<2>, _: [f64; 0]) -> Result<u32, Failure> {
        self.0.step(state, 1e-8, |x, y| {
            ([-x - 2.0 * x * y, -y - x * x + y * y], [-1.0 - 2.0 * y, -2.0 * x, -1.0 + 2.0 * y])
        })
    }
}
