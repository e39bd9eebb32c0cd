//! The schemes as one writes them for a system of one's own: lists of numbers, fixed points from a good
//! start, sums of `Gauss` compensated, nothing allocated in a step and nothing checked. They stop by the
//! rules of the library.

use wzvi::lanes::instructions::{InstructionSet, Kernel};

use crate::stages::{Coefficients, UNSEEN, added, legendre};
use crate::systems::{Condensate, Forces, WELLS};

/// Steps of one path by hand.
pub(crate) trait Steps {
    fn new(path: &Start<'_>) -> Self;
    /// Takes steps; compiled for the instructions of its caller.
    fn take(&mut self, system: &Self::System, steps: usize);
    fn q(&self) -> &[f64];

    type System;
}

/// Where a path starts, and its step size.
pub(crate) struct Start<'a> {
    pub(crate) q: &'a [f64],
    pub(crate) p: &'a [f64],
    pub(crate) h: f64,
}

/// Steps with a set of instructions.
struct Taken<'a, M: Steps> {
    path: &'a mut M,
    system: &'a M::System,
    steps: usize,
}

impl<M: Steps> Kernel for Taken<'_, M> {
    type Output = ();

    #[inline(always)]
    fn run<const L: usize, const HALF: usize>(self) {
        self.path.take(self.system, self.steps);
    }
}

pub(crate) fn take_steps<M: Steps>(set: InstructionSet, path: &mut M, system: &M::System, steps: usize) {
    set.run(Taken { path, system, steps });
}

/// Sweeps after which a step would have failed.
const MOST_SWEEPS: usize = 100;

/// Whether the next sweep changes nothing, or sweeps no longer help: from a change and the one before it, of
/// numbers of order one. What one stage leaves is random; what several leave adds up.
#[inline(always)]
fn is_settled(stages: usize, change: f64, last: f64) -> bool {
    let unseen = if stages == 1 { 0.25 } else { UNSEEN };
    let is_small = change < 0.5 * last && change * change <= unseen * f64::EPSILON * last;
    is_small || change <= 0.0005 * f64::EPSILON || (change >= 0.5 * last && change < 8.0 * f64::EPSILON)
}

/// `P = p + h/2 f(q)`, `q += h P`, `p = P + h/2 f(q)`, whose force is that of the next step, too.
pub(crate) struct KickDriftKick<S> {
    h: f64,
    q: Vec<f64>,
    p: Vec<f64>,
    force: Vec<f64>,
    is_known: bool,
    of: std::marker::PhantomData<S>,
}

impl<S: Forces> Steps for KickDriftKick<S> {
    type System = S;

    fn new(path: &Start<'_>) -> Self {
        let force = vec![0.0; path.q.len()];
        let (q, p, of) = (path.q.to_vec(), path.p.to_vec(), std::marker::PhantomData);
        Self { h: path.h, q, p, force, is_known: false, of }
    }
    #[inline(always)]
    fn take(&mut self, system: &S, steps: usize) {
        let h = self.h;
        if !self.is_known {
            system.pull(&self.q, &mut self.force);
            self.is_known = true;
        }
        for _ in 0..steps {
            for ((q, p), force) in self.q.iter_mut().zip(&mut self.p).zip(&self.force) {
                *p += 0.5 * h * force;
                *q += h * *p;
            }
            system.pull(&self.q, &mut self.force);
            for (p, force) in self.p.iter_mut().zip(&self.force) {
                *p += 0.5 * h * force;
            }
        }
    }
    fn q(&self) -> &[f64] {
        &self.q
    }
}

/// Sites whose stages are summed at once, so that they stay in the first cache.
const BLOCK: usize = 64;

/// Gauss's stages in Nyström form, `Q_i = q + c_i h p + h² Σ_j (A²)_ij f(Q_j)`, from the polynomial of the
/// step before; with one stage, which is the mid-point rule, from the parabola through the last three forces.
pub(crate) struct Nystrom<S, const N: usize> {
    h: f64,
    /// By row: weights of the forces in the stages and in their prediction.
    matrix: [[f64; N]; N],
    prediction: [[f64; N]; N],
    /// `c_i h`, `h b_i` and `h² b_i (1 - c_i)`
    moved: [f64; N],
    kicks: [f64; N],
    shifts: [f64; N],
    q: Vec<f64>,
    p: Vec<f64>,
    lost_q: Vec<f64>,
    lost_p: Vec<f64>,
    stages: [Vec<f64>; N],
    forces: [Vec<f64>; N],
    /// With one stage: the forces of the two steps before the last.
    past: [Vec<f64>; 2],
    of: std::marker::PhantomData<S>,
}

impl<S: Forces, const N: usize> Nystrom<S, N> {
    /// Sums of a block of sites: `Σ_j row_j f_j`.
    #[inline(always)]
    fn sum(row: &[f64; N], forces: &[Vec<f64>; N], begin: usize, end: usize) -> [f64; BLOCK] {
        let mut sum = [0.0; BLOCK];
        for (weight, force) in row.iter().zip(forces) {
            for (sum, force) in sum.iter_mut().zip(&force[begin..end]) {
                *sum += weight * force;
            }
        }
        sum
    }
}

impl<S: Forces, const N: usize> Steps for Nystrom<S, N> {
    type System = S;

    fn new(path: &Start<'_>) -> Self {
        let (h, Coefficients { c, b, eta, kappa }) = (path.h, Coefficients::<N>::new());
        let weights = |columns: [[f64; N]; N]| match N {
            1 => [[0.25 * h * h; N]; N],
            _ => std::array::from_fn(|i| std::array::from_fn(|j| h * h * b[j] * columns[j][i])),
        };
        let zeros = vec![0.0; path.q.len()];
        Self {
            h,
            matrix: weights(eta),
            prediction: weights(kappa),
            moved: c.map(|c| c * h),
            kicks: b.map(|b| h * b),
            shifts: std::array::from_fn(|i| h * h * b[i] * (1.0 - c[i])),
            q: path.q.to_vec(),
            p: path.p.to_vec(),
            lost_q: zeros.clone(),
            lost_p: zeros.clone(),
            stages: std::array::from_fn(|_| zeros.clone()),
            forces: std::array::from_fn(|_| zeros.clone()),
            past: [zeros.clone(), zeros],
            of: std::marker::PhantomData,
        }
    }
    #[inline(always)]
    fn take(&mut self, system: &S, steps: usize) {
        let sites = self.q.len();
        for _ in 0..steps {
            if N == 1 {
                // The next force of the parabola takes the place of the last one.
                let [second, third] = &mut self.past;
                for ((first, second), third) in self.forces[0].iter_mut().zip(second).zip(third) {
                    let next = 3.0 * (*first - *second) + *third;
                    (*first, *second, *third) = (next, *first, *second);
                }
            }
            for begin in (0..sites).step_by(BLOCK) {
                let end = sites.min(begin + BLOCK);
                for i in 0..N {
                    let sum = Self::sum(&self.prediction[i], &self.forces, begin, end);
                    let starts = self.q[begin..end].iter().zip(&self.p[begin..end]);
                    for ((stage, sum), (q, p)) in self.stages[i][begin..end].iter_mut().zip(&sum).zip(starts)
                    {
                        *stage = q + (self.moved[i] * p + sum);
                    }
                }
            }
            let mut last = 0.0;
            for _ in 0..MOST_SWEEPS {
                for (stage, force) in self.stages.iter().zip(&mut self.forces) {
                    system.pull(stage, force);
                }
                let mut change = 0.0;
                for begin in (0..sites).step_by(BLOCK) {
                    let end = sites.min(begin + BLOCK);
                    for i in 0..N {
                        let sum = Self::sum(&self.matrix[i], &self.forces, begin, end);
                        let mut changes = [0.0; BLOCK];
                        let starts = self.q[begin..end].iter().zip(&self.p[begin..end]);
                        let starts = starts.zip(&self.lost_q[begin..end]);
                        let stages = self.stages[i][begin..end].iter_mut().zip(&sum).zip(&mut changes);
                        for (((stage, sum), change), ((q, p), lost)) in stages.zip(starts) {
                            let next = q + (self.moved[i] * p + sum + lost);
                            *change = (next - *stage).abs();
                            *stage = next;
                        }
                        for own in changes {
                            change = if own > change { own } else { change };
                        }
                    }
                }
                if is_settled(N, change, last) {
                    break;
                }
                last = change;
            }
            for begin in (0..sites).step_by(BLOCK) {
                let end = sites.min(begin + BLOCK);
                let moved = Self::sum(&self.shifts, &self.forces, begin, end);
                let kicked = Self::sum(&self.kicks, &self.forces, begin, end);
                let states = self.q[begin..end].iter_mut().zip(&mut self.p[begin..end]);
                let lost = self.lost_q[begin..end].iter_mut().zip(&mut self.lost_p[begin..end]);
                for (((q, p), (lost_q, lost_p)), (moved, kicked)) in
                    states.zip(lost).zip(moved.iter().zip(&kicked))
                {
                    if N == 1 {
                        *q += self.h * *p + moved;
                        *p += kicked;
                    } else {
                        (*q, *lost_q) = added(*q, self.h * *p + moved + self.h * *lost_p + *lost_q);
                        (*p, *lost_p) = added(*p, kicked + *lost_p);
                    }
                }
            }
        }
    }
    fn q(&self) -> &[f64] {
        &self.q
    }
}

/// Coordinates and momenta of the condensate.
type Lists = [[f64; WELLS]; 2];

/// Gauss's stages, `x_i = x + h Σ_j a_ij f(x_j)` of both lists, from the polynomial of the step before; with
/// one stage from the parabola through the last three slopes.
pub(crate) struct Stages<const N: usize> {
    x: Lists,
    lost: Lists,
    /// By row, times h: the weights of a step, of the stages, and of their prediction.
    weights: [f64; N],
    matrix: [[f64; N]; N],
    prediction: [[f64; N]; N],
    stages: [Lists; N],
    /// `(H_p, -H_q)` of each stage.
    slopes: [Lists; N],
    /// With one stage: the slopes of the two steps before the last.
    past: [Lists; 2],
}

impl<const N: usize> Stages<N> {
    /// `Σ_j row_j f_j`
    #[inline(always)]
    fn sum(&self, row: &[f64; N]) -> Lists {
        let mut sum = [[0.0; WELLS]; 2];
        for (weight, slopes) in row.iter().zip(&self.slopes) {
            for list in 0..2 {
                for i in 0..WELLS {
                    sum[list][i] += weight * slopes[list][i];
                }
            }
        }
        sum
    }

    /// `x` and increments
    #[inline(always)]
    fn moved(&self, sum: &Lists) -> Lists {
        let mut moved = self.x;
        for list in 0..2 {
            for i in 0..WELLS {
                moved[list][i] += sum[list][i] + self.lost[list][i];
            }
        }
        moved
    }
}

impl<const N: usize> Steps for Stages<N> {
    type System = Condensate;

    fn new(path: &Start<'_>) -> Self {
        let (h, Coefficients { c, b, .. }) = (path.h, Coefficients::<N>::new());
        let nodes = c.map(|c| 2.0 * c - 1.0);
        // (2k + 1) times the integral of the k-th polynomial from -1.
        let integral = |y: f64, k: usize| match k {
            0 => 0.5 * (y + 1.0),
            _ => 0.5 * (legendre(y, N)[k + 1] - legendre(y, N)[k - 1]),
        };
        let matrix = |begin: f64| {
            nodes.map(|y| {
                std::array::from_fn(|j| {
                    let values = legendre(nodes[j], N);
                    let terms =
                        (0..N).map(|k| values[k] * (integral(y + begin + 1.0, k) - integral(begin, k)));
                    h * b[j] * terms.sum::<f64>()
                })
            })
        };
        let list = |numbers: &[f64]| std::array::from_fn(|i| numbers[i]);
        let (x, zeros) = ([list(path.q), list(path.p)], [[0.0; WELLS]; 2]);
        Self {
            x,
            lost: zeros,
            weights: b.map(|b| h * b),
            matrix: matrix(-1.0),
            prediction: if N == 1 { matrix(-1.0) } else { matrix(1.0) },
            stages: [x; N],
            slopes: [zeros; N],
            past: [zeros; 2],
        }
    }
    #[inline(always)]
    fn take(&mut self, system: &Condensate, steps: usize) {
        for _ in 0..steps {
            if N == 1 {
                let latest = self.slopes[0];
                for list in 0..2 {
                    for i in 0..WELLS {
                        self.slopes[0][list][i] =
                            3.0 * (latest[list][i] - self.past[0][list][i]) + self.past[1][list][i];
                    }
                }
                self.past = [latest, self.past[0]];
            }
            for i in 0..N {
                self.stages[i] = self.moved(&self.sum(&self.prediction[i]));
            }
            let mut last = 0.0;
            for _ in 0..MOST_SWEEPS {
                for (slopes, stage) in self.slopes.iter_mut().zip(&self.stages) {
                    system.slopes(stage, slopes);
                }
                let mut changes = [0.0; WELLS];
                for i in 0..N {
                    let next = self.moved(&self.sum(&self.matrix[i]));
                    for list in 0..2 {
                        for (site, change) in changes.iter_mut().enumerate() {
                            let own = f64::abs(next[list][site] - self.stages[i][list][site]);
                            *change = if own > *change { own } else { *change };
                        }
                    }
                    self.stages[i] = next;
                }
                let mut change = 0.0;
                for own in changes {
                    change = if own > change { own } else { change };
                }
                if is_settled(N, change, last) {
                    break;
                }
                last = change;
            }
            let sum = self.sum(&self.weights);
            for list in 0..2 {
                for i in 0..WELLS {
                    let (x, lost) = (&mut self.x[list][i], &mut self.lost[list][i]);
                    if N == 1 {
                        *x += sum[list][i];
                    } else {
                        (*x, *lost) = added(*x, sum[list][i] + *lost);
                    }
                }
            }
        }
    }
    fn q(&self) -> &[f64] {
        &self.x[0]
    }
}
