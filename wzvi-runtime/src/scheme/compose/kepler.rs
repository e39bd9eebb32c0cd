//! The flow of Kepler's problem, by universal variables.
//!
//! Each body has the Hamiltonian `w |p|²/2 - k/|q|`, with any signs of the inverse mass `w` and the strength
//! `k`. With `v = w p` and `μ = w k` its orbit obeys `q'' = -μ q/r³`, `r = |q|`. The universal variable `s`
//! with `s' = 1/r` makes the equation linear, for ellipses, parabolas and hyperbolas alike:
//!
//! ```text
//! β = 2μ/r_0 - v_0²,   η = q_0 · v_0,   ζ = μ - β r_0
//! G_n(s) = s^n c_n(β s²),   c_n(x) = Σ_j (-x)^j / (n + 2j)!
//! h = r_0 s + η G_2 + ζ G_3                     (Kepler's equation for s)
//! r = r_0 + η G_1 + ζ G_2
//! q - q_0 = -(μ/r_0) G_2 q_0 + g v_0,           g = r_0 G_1 + η G_2 = h - μ G_3
//! v - v_0 = -(μ/(r r_0)) G_1 q_0 - (μ/r) G_2 v_0
//! ```
//!
//! (J. M. A. Danby, *Fundamentals of Celestial Mechanics*, 2nd ed., Willmann-Bell 1988, section 6.9; J.
//! Wisdom, D. M. Hernandez, "Fast and accurate symplectic integration of Kepler's problem", MNRAS 453, 2015.)
//! All differences are computed as such, so that compensated sums keep their digits. `G_1² = G_2 (1 + G_0)`
//! makes the map symplectic for any value of `s`; an error of `s` is one of the time alone.
//!
//! The right side of Kepler's equation grows with `s`: its slope is `r`. A bracket therefore holds the
//! solution, iterations of Laguerre and Conway (B. A. Conway, *Celest. Mech.* 39, 1986) approach it with any
//! start, and bisection replaces those that leave the bracket. Whole periods are taken out of `h` first. A
//! last step of Newton's method in the numbers of the caller gives them their derivatives.

use crate::algebra::scalar::{ComputesWith, Constant, Mask as _, Scalar};
use crate::error::{ConfigError, StepFailure};

/// The flow of bodies that do not act on each other.
#[derive(Clone, Debug)]
pub(super) struct KeplerFlow<K = f64> {
    /// Coordinates of a body.
    components: usize,
    bodies: Vec<KeplerBody<K>>,
}

/// The constants of a body.
#[derive(Clone, Copy, Debug)]
struct KeplerBody<K> {
    /// `w`
    inverse_mass: K,
    /// `k`
    strength: K,
}

impl<K: Constant> KeplerFlow<K> {
    /// `slopes(x, y)` writes `∂H/∂q`, `∂H/∂p` at `x` into `y`; both have the coordinates first. At distance 1
    /// and with a momentum of 1 these are `k` and `w`.
    ///
    /// # Errors
    /// [`ConfigError::Parameter`] if a constant is not finite.
    pub(super) fn new(
        degrees: usize,
        components: usize,
        slopes: &mut dyn FnMut(&[K], &mut [K]),
    ) -> Result<Self, ConfigError> {
        let unit = (0..2 * degrees).map(|i| (i % degrees).is_multiple_of(components));
        let at: Vec<K> = unit.map(|is_first| K::from_f64(f64::from(is_first))).collect();
        let mut constants = vec![K::from_f64(0.0); 2 * degrees];
        slopes(&at, &mut constants);
        let (by_q, by_p) = constants.split_at(degrees);
        let bodies = by_q.iter().zip(by_p).step_by(components);
        let bodies: Vec<KeplerBody<K>> =
            bodies.map(|(&strength, &inverse_mass)| KeplerBody { inverse_mass, strength }).collect();
        let is_finite =
            |body: &KeplerBody<K>| (body.strength.is_finite() & body.inverse_mass.is_finite()).all();
        if bodies.iter().all(is_finite) {
            Ok(Self { components, bodies })
        } else {
            Err(ConfigError::Parameter)
        }
    }

    /// The increments of the state over the time `h` into `dq`, `dp`.
    ///
    /// # Errors
    /// [`StepFailure::Collision`] where a body meets its centre.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn increments<S: ComputesWith<K>>(
        &self,
        h: S,
        [q, p]: [&[S]; 2],
        [dq, dp]: [&mut [S]; 2],
    ) -> Result<(), StepFailure> {
        let n = self.components;
        let states = q.chunks(n).zip(p.chunks(n));
        let increments = dq.chunks_mut(n).zip(dp.chunks_mut(n));
        for (number, ((body, (q, p)), (dq, dp))) in self.bodies.iter().zip(states).zip(increments).enumerate()
        {
            let orbit = Orbit::new(body, h, q, p);
            let Some(OrbitMap { q_by_q, q_by_p, p_by_q, p_by_p, .. }) = orbit.map() else {
                return Err(StepFailure::Collision { body: number });
            };
            for ((q, p), (dq, dp)) in q.iter().zip(p).zip(dq.iter_mut().zip(dp)) {
                *dq = q_by_q * *q + q_by_p * *p;
                *dp = p_by_q * *q + p_by_p * *p;
            }
        }
        Ok(())
    }
}

impl KeplerFlow {
    /// `∫ p · q' - H` over the flow from a state: `h H + 2 k ∫ dt/r`, and the integral is `s`.
    pub(super) fn action(&self, h: f64, [q, p]: [&[f64]; 2]) -> f64 {
        let n = self.components;
        let states = q.chunks(n).zip(p.chunks(n));
        let of_bodies = self.bodies.iter().zip(states).map(|(body, (q, p))| {
            let orbit = Orbit::new(body, h, q, p);
            let kinetic = 0.5 * body.inverse_mass * p.iter().map(|p| p * p).sum::<f64>();
            if body.strength == 0.0 {
                return h * kinetic;
            }
            let energy = kinetic - body.strength / orbit.r0;
            orbit.map().map_or(f64::NAN, |map| h * energy + 2.0 * body.strength * map.s)
        });
        of_bodies.sum()
    }
}

/// The orbit of a body from its state at the start, and the time of the flow.
#[derive(Clone, Copy, Debug)]
struct Orbit<S> {
    inverse_mass: S,
    strength: S,
    h: S,
    /// `r_0`
    r0: S,
    /// `1/r_0`
    inverse_r0: S,
    /// `η`
    eta: S,
    /// `μ`
    mu: S,
    /// `β`
    beta: S,
    /// The sum of the sizes of the components of the angular momentum `q_0 × p_0`.
    spin: S,
    /// `|q_0 × v_0|²`
    spin_squared: S,
    /// `r_0` times the sum of the sizes of the momenta, which bounds it within a factor.
    most_spin: S,
}

/// The linear map from the state at the start to the increments, and the universal variable.
#[derive(Clone, Copy, Debug)]
struct OrbitMap<S> {
    q_by_q: S,
    q_by_p: S,
    p_by_q: S,
    p_by_p: S,
    s: S,
}

impl<S: Scalar> Orbit<S> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn new<K: Constant>(
        &KeplerBody { inverse_mass, strength }: &KeplerBody<K>,
        h: S,
        q: &[S],
        p: &[S],
    ) -> Self
    where
        S: ComputesWith<K>,
    {
        let zero = S::from_f64(0.0);
        let (w, k) = (S::constant(inverse_mass), S::constant(strength));
        let (mut qq, mut qp, mut pp, mut speed) = (zero, zero, zero, zero);
        let (mut spin, mut spin_squared) = (zero, zero);
        for (i, (&x, &p_x)) in q.iter().zip(p).enumerate() {
            (qq, qp, pp) = (qq + x * x, qp + x * p_x, pp + p_x * p_x);
            speed = speed + p_x.abs();
            for (&y, &p_y) in q.iter().zip(p).take(i) {
                let component = x * p_y - y * p_x;
                (spin, spin_squared) = (spin + component.abs(), spin_squared + component * component);
            }
        }
        let (r0, mu, v_squared) = (qq.sqrt(), w * k, w * w * pp);
        let inverse_r0 = r0.recip();
        Self {
            inverse_mass: w,
            strength: k,
            h,
            r0,
            inverse_r0,
            eta: w * qp,
            mu,
            beta: mu * inverse_r0 * 2.0 - v_squared,
            spin,
            spin_squared: w * w * spin_squared,
            most_spin: r0 * speed,
        }
    }

    /// `None` where the body meets the centre, or does so to rounding.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn map(&self) -> Option<OrbitMap<S>> {
        let zero = S::from_f64(0.0);
        if self.strength.vanishes().all() {
            let q_by_p = self.inverse_mass * self.h;
            return Some(OrbitMap { q_by_q: zero, q_by_p, p_by_q: zero, p_by_p: zero, s: zero });
        }
        if const { S::DERIVATIVES > 0 } {
            return Some(self.end(&self.solve_by_lane()?));
        }
        let (is_short, mut solution) = self.short();
        if !is_short.all() {
            let mut any = self.solve_by_lane()?;
            for (short, any) in solution.numbers().into_iter().zip(any.numbers()) {
                *short = S::select(is_short, *short, *any);
            }
        }
        Some(self.end(&solution))
    }

    /// The increments by the functions at the end.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn end(&self, &OrbitSolution { s, g1, g2, r, g }: &OrbitSolution<S>) -> OrbitMap<S> {
        let &Self { inverse_mass, strength, inverse_r0, mu, .. } = self;
        let inverse_r = r.recip();
        OrbitMap {
            q_by_q: -(mu * inverse_r0 * g2),
            q_by_p: g * inverse_mass,
            p_by_q: -(strength * inverse_r0 * inverse_r * g1),
            p_by_p: -(mu * inverse_r * g2),
            s,
        }
    }

    /// The solution of a short step, and the lanes where it is one to rounding: from the series for `s`, by
    /// one step of Halley's method.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn short(&self) -> (S::Mask, OrbitSolution<S>) {
        let &Self { h, r0, inverse_r0, eta, mu, beta, spin, most_spin, .. } = self;
        let zeta = mu - beta * r0;
        // h = r_0 s (1 + a s/s_1 + b (s/s_1)² + ...)
        let s1 = h * inverse_r0;
        let (a, b) = (eta * s1 * inverse_r0 * 0.5, zeta * s1 * s1 * inverse_r0 * (1.0 / 6.0));
        let s = s1 * (a * (a * 2.0 + b * 5.0) - a - b + 1.0);
        let (is_near, [g0, g1, g2, g3]) = stumpff_near(beta, s);
        let left = r0 * s + eta * g2 + zeta * g3 - h;
        let (r, slope) = (r0 + eta * g1 + zeta * g2, eta * g0 + zeta * g1);
        let d = -(left * r) / (r * r - left * slope * 0.5);
        // The relative change of `r` and of the functions: its square is what remains, relative to `d`.
        let change = (d * slope).abs() + d * d * ((mu - beta * r).abs() + beta.abs() * r);
        let is_solved = change.less_equal(r * 1e-7);
        let is_radial = spin.less_equal(most_spin * RADIAL);
        let (bent, half) = (beta * g1, d * 0.5);
        let third = d * (1.0 / 3.0);
        let (g1, g2) =
            (g1 + d * (g0 - half * (bent + third * beta * g0)), g2 + d * (g1 + half * (g0 - third * bent)));
        let solution =
            OrbitSolution { s: s + d, g1, g2, r: r0 + eta * g1 + zeta * g2, g: r0 * g1 + eta * g2 };
        (is_near & is_solved & !is_radial, solution)
    }

    /// The solution of any step, which is found lane by lane, with the derivatives of its numbers.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn solve_by_lane(&self) -> Option<OrbitSolution<S>> {
        let &Self { h, mu, beta, .. } = self;
        let zero = S::from_f64(0.0);
        let (mut s, mut periods) = (zero, zero);
        for lane in 0..S::LANES {
            let solution = self.lane(lane).solve()?;
            let is_here = S::Mask::of_lanes(|other| other == lane);
            s = S::select(is_here, S::from_f64(solution.s), s);
            periods = S::select(is_here, S::from_f64(solution.periods), periods);
        }
        let (mut rest, mut revolved) = (h, zero);
        if !periods.vanishes().all() {
            // Lanes without periods may have no root.
            let square = S::select(periods.vanishes(), S::from_f64(1.0), beta);
            revolved = periods * std::f64::consts::TAU / square.sqrt();
            rest = h - revolved * mu / square;
        }
        let mut solution = self.newton(s, rest);
        // One step finds first derivatives, another one their derivatives.
        if const { <S::Value as Scalar>::DERIVATIVES > 0 } {
            solution = self.newton(solution.s, rest);
        }
        solution.s = solution.s + revolved;
        Some(solution)
    }

    /// A step of Newton's method for Kepler's equation with the time `h`, to first order in the correction,
    /// which is rounding, or infinitesimal.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn newton(&self, s: S, h: S) -> OrbitSolution<S> {
        let &Self { r0, eta, mu, beta, .. } = self;
        let functions = stumpff(beta, s);
        let sums = self.sums(s, &functions);
        let [g0, g1, g2, g3] = functions;
        let r = r0 + sums.of_r;
        let d = (h - (r0 * s + sums.of_h)) / r;
        let (g1, g2, g3) = (g1 + g0 * d, g2 + g1 * d, g3 + g2 * d);
        let g = S::select(sums.is_inward, h - mu * g3, r0 * g1 + eta * g2);
        OrbitSolution { s: s + d, g1, g2, r: r + sums.slope * d, g }
    }

    /// The sums of Kepler's equation and of its derivatives.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn sums(&self, s: S, &[g0, g1, g2, g3]: &[S; 4]) -> KeplerSums<S> {
        let &Self { r0, eta, mu, beta, .. } = self;
        let (zero, zeta) = (S::from_f64(0.0), mu - beta * r0);
        let is_inward = (beta * s * s).less(S::from_f64(-1.0)) & (eta * s).less(zero);
        let mut sums = KeplerSums {
            slope: eta * g0 + zeta * g1,
            of_r: eta * g1 + zeta * g2,
            of_h: eta * g2 + zeta * g3,
            is_inward,
        };
        if is_inward.any() {
            self.sums_inward(s, &[g0, g1, g2], &mut sums);
        }
        sums
    }

    /// The sums on a hyperbola from far away towards the pericentre, in the lanes where that is so. With
    /// `X = ρ s`, `ρ² = -β`, growing exponentials nearly cancel in them:
    ///
    /// ```text
    /// η G_n + ζ G_(n+1) = (ζ + η ρ) G_n/ρ + ζ (G_(n+1) - G_n/ρ),   (ζ + η ρ) (ζ - η ρ) = μ² - β L²
    /// G_1 - G_0/ρ = -e^(-X)/ρ,   G_2 - G_1/ρ = (e^(-X) - 1)/ρ²,   G_3 - G_2/ρ = (1 - X - e^(-X))/ρ³
    /// ```
    #[inline(never)]
    fn sums_inward(&self, s: S, &[g0, g1, g2]: &[S; 3], sums: &mut KeplerSums<S>) {
        let &Self { r0, eta, mu, beta, spin_squared, .. } = self;
        let (zero, zeta) = (S::from_f64(0.0), mu - beta * r0);
        let square = S::select(sums.is_inward, -beta, S::from_f64(1.0));
        let root = square.sqrt();
        let rho = S::select(s.less(zero), -root, root);
        let decay = (-(rho * s)).exp_m1();
        let growing = (mu * mu + square * spin_squared) / (zeta - eta * rho) / rho;
        let inward = [
            growing * g0 - zeta * (decay + 1.0) / rho,
            growing * g1 + zeta * decay / square,
            growing * g2 - zeta * (rho * s + decay) / (square * rho),
        ];
        let KeplerSums { slope, of_r, of_h, is_inward } = sums;
        for (known, inward) in [slope, of_r, of_h].into_iter().zip(inward) {
            *known = S::select(*is_inward, inward, *known);
        }
    }

    /// The numbers of a lane.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn lane(&self, lane: usize) -> Orbit<f64> {
        let Self { inverse_mass, strength, h, r0, inverse_r0, eta, mu, beta, spin, spin_squared, most_spin } =
            self;
        let [inverse_mass, strength, h, r0, inverse_r0, eta, mu, beta] =
            [inverse_mass, strength, h, r0, inverse_r0, eta, mu, beta].map(|number| number.lane(lane));
        let [spin, spin_squared, most_spin] = [spin, spin_squared, most_spin].map(|number| number.lane(lane));
        Orbit { inverse_mass, strength, h, r0, inverse_r0, eta, mu, beta, spin, spin_squared, most_spin }
    }
}

/// A solution of Kepler's equation, with the functions and the distance there.
#[derive(Clone, Copy, Debug)]
struct OrbitSolution<S> {
    s: S,
    g1: S,
    g2: S,
    r: S,
    /// `r_0 G_1 + η G_2`
    g: S,
}

impl<S> OrbitSolution<S> {
    fn numbers(&mut self) -> [&mut S; 5] {
        let Self { s, g1, g2, r, g } = self;
        [s, g1, g2, r, g]
    }
}

/// The sums of Kepler's equation, `r_0 s + of_h = h`, and of its derivatives by `s`.
#[derive(Clone, Copy, Debug)]
struct KeplerSums<S: Scalar> {
    /// `dr/ds = η G_0 + ζ G_1`
    slope: S,
    /// `r - r_0 = η G_1 + ζ G_2`
    of_r: S,
    /// `η G_2 + ζ G_3`
    of_h: S,
    /// Whether a body comes from far away on a hyperbola.
    is_inward: S::Mask,
}

/// The universal variable at the end of a step.
#[derive(Clone, Copy, Debug)]
struct Anomaly {
    /// The universal variable without whole periods.
    s: f64,
    /// Whole periods in `h`.
    periods: f64,
}

/// Iterations for a solution: from a finite bracket, bisection alone needs no more.
const MOST: u32 = 200;

/// Laguerre's method takes the equation for a polynomial of this degree.
const DEGREE: f64 = 5.0;
const LESS: f64 = DEGREE - 1.0;

/// An angular momentum that is zero to rounding, relative to a bound of it.
const RADIAL: f64 = 4.0 * f64::EPSILON;

impl Orbit<f64> {
    /// `None` where the body meets the centre. Compiled once, for all lanes and systems.
    #[inline(never)]
    fn solve(&self) -> Option<Anomaly> {
        let &Self { h, r0, eta, mu, beta, .. } = self;
        if r0 == 0.0 {
            return None;
        }
        let root = beta.abs().sqrt();
        let mean_motion = beta * root / mu;
        let (mut periods, mut rest) = (0.0, h);
        if beta > 0.0 && (h * mean_motion).abs() > std::f64::consts::PI {
            periods = (h * mean_motion / std::f64::consts::TAU).round();
            rest = h - periods * std::f64::consts::TAU / root * mu / beta;
        }
        // Backwards is forwards with the velocity turned round.
        let sign = if rest < 0.0 { -1.0 } else { 1.0 };
        let s = sign * Orbit { h: sign * rest, eta: sign * eta, ..*self }.universal_variable(root);
        let is_radial = self.spin <= RADIAL * self.most_spin;
        if is_radial && mu > 0.0 && self.meets_centre(s, periods) {
            return None;
        }
        Some(Anomaly { s, periods })
    }

    /// Whether a body without angular momentum is at the centre between the start and `s`.
    #[cold]
    fn meets_centre(&self, s: f64, periods: f64) -> bool {
        let &Self { h, r0, eta, mu, beta, .. } = self;
        let sign = if h < 0.0 { -1.0 } else { 1.0 };
        let zeta = mu - beta * r0;
        let [g0, g1, ..] = stumpff(beta, s);
        let (before, after) = (sign * eta, sign * (eta * g0 + zeta * g1));
        if beta <= 0.0 {
            return before < 0.0 && after >= 0.0;
        }
        // The eccentric anomaly, which is a multiple of 2π at the centre.
        let root = beta.sqrt();
        let start = Scalar::atan2(before * root, zeta).rem_euclid(std::f64::consts::TAU);
        start + sign * s * root + std::f64::consts::TAU * periods.abs() >= std::f64::consts::TAU
    }
}

impl Orbit<f64> {
    /// The universal variable for a time `h >= 0` of at most half a period, to a part in 10^10 at least: a
    /// step of Newton's method makes that rounding. `root` is `√|β|`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn universal_variable(&self, root: f64) -> f64 {
        let &Self { h, r0, mu, beta, .. } = self;
        let mut s = self.guess(root);
        let (mut low, mut high) = (0.0, f64::INFINITY);
        for _ in 0..MOST {
            let KeplerSums { slope, of_r, of_h, .. } = self.sums(s, &stumpff(beta, s));
            let (left, r) = (r0 * s + of_h - h, r0 + of_r);
            let curvature = mu - beta * r;
            let square = LESS * LESS * r * r - DEGREE * LESS * left * slope;
            let correction = -DEGREE * left / (r + square.abs().sqrt());
            // The relative change of `r` by a correction, and of the functions.
            let change =
                (correction * slope).abs() + correction * correction * (curvature.abs() + beta.abs() * r);
            if change <= 1e-5 * r {
                return s + correction;
            }
            // Overflow is beyond the solution, too.
            if left < 0.0 {
                low = s;
            } else {
                high = s;
            }
            let next = s + correction;
            let bisected = if high < f64::INFINITY { 0.5 * (low + high) } else { 2.0 * s };
            s = if low < next && next < high { next } else { bisected };
            if s <= low || s >= high {
                return s;
            }
        }
        s
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn guess(&self, root: f64) -> f64 {
        let &Self { h, r0, eta, mu, beta, .. } = self;
        let zeta = mu - beta * r0;
        // h = r_0 s (1 + a s/s_1 + b (s/s_1)² + ...)
        let s1 = h / r0;
        let (a, b) = (eta * s1 / (2.0 * r0), zeta * s1 * s1 / (6.0 * r0));
        if a.abs() + b.abs() < 0.1 {
            return s1 * (1.0 - a - b + a * (2.0 * a + 5.0 * b));
        }
        self.guess_far(zeta, root)
    }

    /// For steps that are not short: of a parabola, of a hyperbola far out, or of an ellipse.
    fn guess_far(&self, zeta: f64, root: f64) -> f64 {
        let &Self { h, r0, eta, mu, beta, spin_squared, .. } = self;
        if zeta > 0.0 {
            // The cubic r_0 s + η s²/2 + ζ s³/6 = h by Cardano's formula, with u = s + η/ζ.
            let shift = eta / zeta;
            let third = (2.0 * r0 / zeta - shift * shift).max(0.0);
            let half = (3.0 * h / zeta) + shift * (3.0 * r0 / zeta - shift * shift);
            let w = Scalar::cbrt(half.abs() + (half * half + third * third * third).sqrt());
            let u = if w > 0.0 { (w - third / w).copysign(half) } else { 0.0 };
            let s = u - shift;
            if s > 0.0 && root * s < 1.5 {
                return s;
            }
        }
        if beta > 0.0 {
            // M = X - e_c sin X + e_s (1 - cos X) for X = √β s; Danby's guess.
            let (e_s, e_c) = (eta * root / mu, zeta / mu);
            let mean = h * beta * root / mu - e_s;
            let (sin, cos) = Scalar::sin_cos(mean);
            let e = Scalar::hypot(e_s, e_c);
            return (mean + (0.85 * e).copysign(e_s * cos + e_c * sin)) / root;
        }
        // The growing exponential alone.
        let growing =
            if eta < 0.0 { (mu * mu - beta * spin_squared) / (zeta - eta * root) } else { zeta + eta * root };
        let size = 2.0 * h * root * root * root / growing;
        if size > 1.0 { Scalar::ln(size) / root } else { h / r0 }
    }
}

/// `G_n = s^n c_n(β s²)` for n = 0 to 3.
#[cfg_attr(not(debug_assertions), inline(always))]
fn stumpff<S: Scalar>(beta: S, s: S) -> [S; 4] {
    let (is_near, mut g) = stumpff_near(beta, s);
    if !is_near.all() {
        stumpff_far(beta, s, !is_near, &mut g);
    }
    g
}

/// The functions by their series, and the lanes where it is short enough.
#[cfg_attr(not(debug_assertions), inline(always))]
fn stumpff_near<S: Scalar>(beta: S, s: S) -> (S::Mask, [S; 4]) {
    let square = s * s;
    let x = beta * square;
    let (g2, g3) = (square * series(x, &C2), square * s * series(x, &C3));
    (x.abs().less_equal(S::from_f64(1.0)), [-(beta * g2) + 1.0, s - beta * g3, g2, g3])
}

/// The functions of the lanes in `is_far`, where the series would be long.
#[inline(never)]
fn stumpff_far<S: Scalar>(beta: S, s: S, is_far: S::Mask, g: &mut [S; 4]) {
    let (zero, x) = (S::from_f64(0.0), beta * s * s);
    for is_ellipse in [true, false] {
        let is_of_kind = if is_ellipse { zero.less(x) } else { x.less(zero) };
        let is_here = is_of_kind & is_far;
        if !is_here.any() {
            continue;
        }
        let square = S::select(is_here, if is_ellipse { beta } else { -beta }, S::from_f64(1.0));
        let root = square.sqrt();
        let half = root * s * 0.5;
        let (sin, cos) = if is_ellipse { half.sin_cos() } else { (half.sinh(), half.cosh()) };
        let g1 = sin * cos * 2.0 / root;
        let twice = sin * sin * 2.0;
        let (g0, g3) =
            if is_ellipse { (-twice + 1.0, (s - g1) / square) } else { (twice + 1.0, (g1 - s) / square) };
        for (known, far) in g.iter_mut().zip([g0, g1, twice / square, g3]) {
            *known = S::select(is_here, far, *known);
        }
    }
}

/// `c_n(x)` for `|x| <= 1` from its coefficients.
#[cfg_attr(not(debug_assertions), inline(always))]
fn series<S: Scalar>(x: S, coefficients: &[f64; TERMS]) -> S {
    let mut sum = S::from_f64(coefficients[TERMS - 1]);
    for coefficient in coefficients[..TERMS - 1].iter().rev() {
        sum = sum * x + *coefficient;
    }
    sum
}

/// The first term that is left out is below a hundredth of rounding.
const TERMS: usize = 9;

const C2: [f64; TERMS] = stumpff_coefficients(2);
const C3: [f64; TERMS] = stumpff_coefficients(3);

/// `(-1)^j / (n + 2j)!`
const fn stumpff_coefficients(n: usize) -> [f64; TERMS] {
    let mut coefficients = [0.0; TERMS];
    let (mut factorial, mut k) = (1.0, 1);
    let mut j = 0;
    while j < TERMS {
        while k <= n + 2 * j {
            factorial *= k as f64;
            k += 1;
        }
        coefficients[j] = if j % 2 == 0 { 1.0 / factorial } else { -1.0 / factorial };
        j += 1;
    }
    coefficients
}

#[cfg(test)]
mod tests {
    use serde_json::Value;

    use super::*;

    /// The end of the flow of one body.
    fn end([w, k]: [f64; 2], h: f64, [q, p]: [&[f64]; 2]) -> Result<[Vec<f64>; 2], StepFailure> {
        let bodies = vec![KeplerBody { inverse_mass: w, strength: k }];
        let flow = KeplerFlow { components: q.len(), bodies };
        let mut increments = [q, p].map(|list| vec![0.0; list.len()]);
        let [dq, dp] = &mut increments;
        flow.increments(h, [q, p], [dq, dp])?;
        let sum = |start: &[f64], by: &[f64]| start.iter().zip(by).map(|(start, by)| start + by).collect();
        Ok([sum(q, &increments[0]), sum(p, &increments[1])])
    }

    fn size(list: &[f64]) -> f64 {
        list.iter().map(|x| x * x).sum::<f64>().sqrt()
    }

    /// Ellipses, a parabola and hyperbolas over 1e-6 to 1e3 periods, forwards and backwards, from the
    /// pericentre and from elsewhere, and hyperbolas from far away to far away. `tests/data/kepler_flow.py`
    /// computes the ends to 80 digits, and their conditions `Σ_x |∂end/∂x| |x|` for all numbers `x` of the
    /// input.
    #[test]
    fn flows_are_those_of_the_reference() {
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/kepler_flow.json");
        let cases: Value = serde_json::from_str(&std::fs::read_to_string(file).unwrap()).unwrap();
        let cases = cases.as_array().unwrap();
        assert_eq!(cases.len(), 156);
        let mut worst = 0.0_f64;
        for case in cases {
            let number = |value: &Value| value.as_f64().or_else(|| value.as_str()?.parse().ok()).unwrap();
            let numbers =
                |name: &str| -> Vec<f64> { case[name].as_array().unwrap().iter().map(number).collect() };
            let (q, p, exact, condition) = (numbers("q"), numbers("p"), numbers("end"), numbers("condition"));
            let end = end([number(&case["w"]), number(&case["k"])], number(&case["h"]), [&q, &p]).unwrap();
            for ((end, exact), condition) in end.iter().zip(exact.chunks(3)).zip(condition) {
                let off: Vec<f64> = end.iter().zip(exact).map(|(end, exact)| end - exact).collect();
                let ratio = size(&off) / (f64::EPSILON * (condition + size(exact)));
                worst = worst.max(ratio);
            }
        }
        // A few roundings of the input.
        assert!(worst < 4.0, "{worst}");
    }
}
