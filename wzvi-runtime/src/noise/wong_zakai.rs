//! Wong-Zakai approximations of a Wiener path.
//!
//! The averaging kernel of the paper looks ahead, the centred one both ways:
//!
//! ```text
//! W_eps(t) = (1/eps) int_{t}^{t + eps} W(s) ds             dW_eps/dt = (W(t + eps) - W(t)) / eps
//! W_eps(t) = (1/eps) int_{t - eps/2}^{t + eps/2} W(s) ds    dW_eps/dt = (W(t + eps/2) - W(t - eps/2)) / eps
//! ```
//!
//! A step uses the velocity at one point, `delta_i = h dW_eps/dt`, or the increment of `W_eps`
//! ([`Sampling`]). The example `paper` measures the errors of both (J. Cresson, R. Safi, *Dynamics of
//! stochastic Hamiltonian systems I: Wong-Zakai variational integrators*).
//!
//! Tested by `wzvi-runtime/tests/runtime/noise_wong_zakai.rs`.

use super::grid::GridTime;
use super::truncation::truncation_setters;
use super::wiener::{NOWHERE, Wiener, check_step, times_within};
use super::{Interval, Noise, NoiseError, Paths, Truncation};
use crate::increments::Identity;
use crate::scheme::plan::Plan;

/// The choice of the increments for a step of length h from t_i. With rho = eps / h and f the fractional part
/// of rho, the sampled ones converge for h -> 0 at fixed rho to noises multiplied by `sqrt(v)`,
/// `v = 1 + f (1 - f) / rho^2`: right iff rho is an integer (and `v = 1 / rho` for rho < 1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Sampling {
    /// `(h/eps) (W(t_i + eps) - W(t_i))`. For h = eps these are the increments of the path.
    #[default]
    Left,
    /// The centred kernel at the middle of the step, `(h/eps) (W(m + eps/2) - W(m - eps/2))`,
    /// `m = t_i + h/2`. For h = eps these are the increments of the path.
    Centred,
    /// The paper's kernel taken literally at the quadrature point of the mid-point embedding,
    /// `(h/eps) (W(m + eps) - W(m))`. For h = eps that shifts the path by h/2 and lowers the strong order to
    /// 1/2.
    Literal,
    /// `W_eps(t_i + h) - W_eps(t_i)`, exactly.
    Exact,
    /// The exact average with the centred kernel.
    ExactCentred,
}

/// A smooth approximation `W_eps` of every process of a Wiener path: its average over a window of width eps.
#[derive(Clone, Debug)]
pub struct WongZakai {
    eps: f64,
    sampling: Sampling,
    /// The path, at the early end of the window.
    early: Wiener,
    /// A copy of the path for the late end of the window.
    late: Wiener,
    /// Times of the last step, for the next.
    reached: [(f64, GridTime); 2],
}

impl WongZakai {
    /// The average over a window of width `eps`, sampled at the left end of a step, of the paths of seed 0.
    pub fn averaged(eps: f64) -> Self {
        Self::of(Wiener::seed(0), eps)
    }

    /// The average over a window of width `eps` of a path that is given.
    pub fn of(wiener: Wiener, eps: f64) -> Self {
        Self { eps, sampling: Sampling::Left, late: wiener.twin(), early: wiener, reached: [NOWHERE; 2] }
    }

    fn on(self, wiener: impl FnOnce(Wiener) -> Wiener) -> Self {
        Self { sampling: self.sampling, ..Self::of(wiener(self.early), self.eps) }
    }

    /// The paths of a seed; everything else stays.
    pub fn seed(self, seed: u64) -> Self {
        self.on(|wiener| wiener.with_seed(seed))
    }

    /// Another member of an ensemble ([`Wiener::path`]).
    pub fn path(self, path: u64) -> Self {
        self.on(|wiener| wiener.path(path))
    }

    /// The unit of time of the tree ([`Wiener::unit`]).
    pub fn unit(self, unit: f64) -> Self {
        self.on(|wiener| wiener.unit(unit))
    }

    truncation_setters!(|noise: Self, truncation| noise.on(|wiener| wiener.with_truncation(truncation)));

    /// [`Sampling::Left`], the default.
    pub fn left(self) -> Self {
        self.sampling(Sampling::Left)
    }

    /// [`Sampling::Centred`].
    pub fn centred(self) -> Self {
        self.sampling(Sampling::Centred)
    }

    /// [`Sampling::Literal`].
    pub fn literal(self) -> Self {
        self.sampling(Sampling::Literal)
    }

    /// [`Sampling::Exact`].
    pub fn exact(self) -> Self {
        self.sampling(Sampling::Exact)
    }

    /// [`Sampling::ExactCentred`].
    pub fn exact_centred(self) -> Self {
        self.sampling(Sampling::ExactCentred)
    }

    /// Any sampling.
    pub fn sampling(mut self, sampling: Sampling) -> Self {
        self.sampling = sampling;
        self
    }

    /// The path that is averaged.
    pub fn into_wiener(self) -> Wiener {
        self.early
    }

    /// Width of the window.
    pub fn eps(&self) -> f64 {
        self.eps
    }

    /// The truncation that is set.
    pub fn truncation(&self) -> Truncation {
        self.early.truncation()
    }

    /// `W_eps(t)` of a process, with the centred kernel if the sampling is one of the two centred ones.
    ///
    /// # Errors
    /// [`NoiseError::Time`], [`NoiseError::Unit`], [`NoiseError::Window`].
    pub fn value(&mut self, process: usize, t: f64) -> Result<f64, NoiseError> {
        let [from, to] = self.window(t)?;
        let start = self.early.value(process, from)?;
        Ok(start + self.early.area(process, from, to)? / self.eps)
    }

    /// `dW_eps/dt (t)` of a process.
    ///
    /// # Errors
    /// [`NoiseError::Time`], [`NoiseError::Unit`], [`NoiseError::Window`].
    pub fn velocity(&mut self, process: usize, t: f64) -> Result<f64, NoiseError> {
        let [from, to] = self.window(t)?;
        Ok(self.early.increment(process, from, to)? / self.eps)
    }

    /// The window of `W_eps(t)`.
    fn window(&self, t: f64) -> Result<[f64; 2], NoiseError> {
        self.check_window()?;
        let shift = match self.sampling {
            Sampling::Centred | Sampling::ExactCentred => 0.5 * self.eps,
            Sampling::Left | Sampling::Literal | Sampling::Exact => 0.0,
        };
        Ok([t - shift, t - shift + self.eps])
    }

    fn check_window(&self) -> Result<(), NoiseError> {
        if self.eps.is_finite() && self.eps > 0.0 { Ok(()) } else { Err(NoiseError::Window(self.eps)) }
    }

    /// Standard deviation of the increments of steps of size h.
    ///
    /// The sampled ones have variance `h^2 / eps`; the exact ones `h^2 / eps (1 - h / (3 eps))` for h <= eps,
    /// else `h - eps / 3`.
    pub fn deviation(&self, h: f64) -> f64 {
        let (h, eps) = (h.abs(), self.eps);
        match self.sampling {
            Sampling::Left | Sampling::Centred | Sampling::Literal => (h * (h / eps)).sqrt(),
            Sampling::Exact | Sampling::ExactCentred if h <= eps => {
                (h * (h / eps) * (1.0 - h / (3.0 * eps))).sqrt()
            }
            Sampling::Exact | Sampling::ExactCentred => (h - eps / 3.0).sqrt(),
        }
    }

    /// The times `t_i + offset`, `t_i + offset + eps`, `t_i + h + offset`, `t_i + h + offset + eps` for t_i
    /// the earlier end of a step.
    ///
    /// If eps is a multiple of h they are computed as times of steps, so that they are the very times that
    /// other steps have.
    fn times(&self, interval: &Interval) -> [f64; 4] {
        let h = interval.h.abs();
        let forward = interval.h > 0.0;
        // In steps: the earlier end of this step, counted along the direction of time.
        let base = if forward { interval.step as f64 } else { -(interval.step as f64 + 1.0) };
        let ratio = self.eps / h;
        let whole = (ratio - ratio.round()).abs() <= 4.0 * f64::EPSILON * ratio;
        let (steps, rest) = if whole { (ratio.round(), 0.0) } else { (0.0, self.eps) };
        let (offset_steps, offset_rest) = match self.sampling {
            Sampling::Left | Sampling::Exact => (0.0, 0.0),
            Sampling::Literal => (0.5, 0.0),
            Sampling::Centred => (0.5 - 0.5 * steps, -0.5 * rest),
            Sampling::ExactCentred => (-0.5 * steps, -0.5 * rest),
        };
        let at =
            |steps: f64, rest: f64| interval.start + (base + offset_steps + steps) * h + (offset_rest + rest);
        [at(0.0, 0.0), at(steps, rest), at(1.0, 0.0), at(1.0 + steps, rest)]
    }

    /// The increment of one process between the points of [`WongZakai::times`], forwards in time.
    fn forward(&mut self, process: usize, points: &[GridTime; 4], exact: bool, h: f64) -> f64 {
        let [scale, cube] = self.early.scales();
        let (early, late) = (self.early.cursor(process), self.late.cursor(process));
        early.seek(&points[0]);
        late.seek(&points[1]);
        let across = scale * early.between(late).w;
        if !exact {
            return h / self.eps * across;
        }
        // eps (W_eps(t + h) - W_eps(t)) = int_{t + eps}^{t + eps + h} W ds - int_t^{t + h} W ds.
        let before = early.increment_to(&points[2]);
        let after = late.increment_to(&points[3]);
        (h * across + cube * (after.integral - before.integral)) / self.eps
    }
}

impl Noise for WongZakai {
    fn increments(&mut self, interval: &Interval, dw: &mut [f64]) -> Result<(), NoiseError> {
        self.check_window()?;
        self.early.check(interval.start)?;
        check_step(interval.h)?;
        let h = interval.h.abs();
        let sign = interval.h.signum();
        let bound = self.early.acting().bound(h, self.deviation(h));
        let exact = matches!(self.sampling, Sampling::Exact | Sampling::ExactCentred);
        let times = self.times(interval);
        let mut points = [GridTime::ZERO; 4];
        for (point, t) in points.iter_mut().zip(times).take(if exact { 4 } else { 2 }) {
            *point = match self.reached.iter().find(|reached| reached.0 == t) {
                Some(reached) => reached.1,
                None => self.early.point(t)?,
            };
        }
        // The next step starts at these points.
        self.reached =
            if exact { [(times[2], points[2]), (times[3], points[3])] } else { [(times[1], points[1]); 2] };
        for (process, dw) in dw.iter_mut().enumerate() {
            let increment = if !exact && times[1] == times[2] {
                // The windows of consecutive steps adjoin: one cursor serves both ends.
                h / self.eps * self.early.difference(process, &points[0], &points[1])
            } else {
                self.forward(process, &points, exact, h)
            };
            *dw = sign * increment.clamp(-bound, bound);
        }
        Ok(())
    }

    fn increments_of_part(&mut self, interval: &Interval, h: f64, dw: &mut [f64]) -> Result<(), NoiseError> {
        self.increments(&Interval { start: interval.begin(), h, step: 0 }, dw)
    }

    fn increments_within(
        &mut self,
        interval: &Interval,
        h: f64,
        part: [f64; 2],
        dw: &mut [f64],
    ) -> Result<(), NoiseError> {
        let [start, end] = times_within(interval, h, part);
        self.increments(&Interval { start, h: end - start, step: 0 }, dw)
    }

    fn prepare(&mut self, plan: &Plan, h: f64, _processes: usize, start: f64) -> Result<(), NoiseError> {
        self.early.serve(plan);
        check_step(h)?;
        self.check_window()?;
        self.early.check(start)
    }

    fn largest_increment(&self, h: f64) -> f64 {
        self.early.acting().bound(h.abs(), self.deviation(h.abs()))
    }

    /// Exact increments add up; sampled velocities are those of each part.
    fn is_divisible(&self) -> bool {
        true
    }

    fn skip_paths(&mut self, paths: u64) -> bool {
        self.early.skip_paths(paths) && self.late.skip_paths(paths)
    }

    fn identity(&self) -> Option<Identity> {
        let identity = self.early.identity()?.renamed("WongZakai");
        Some(identity.with("eps", self.eps).with("sampling", self.sampling))
    }
}

impl Paths for WongZakai {
    fn set_path(&mut self, path: u64) {
        self.early.set_path(path);
        self.late.set_path(path);
    }

    fn seed_number(&self) -> Option<u64> {
        self.early.seed_number()
    }
}
