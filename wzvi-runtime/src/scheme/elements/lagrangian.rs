//! The discrete Lagrangian of a scheme, its gradient, and the momentum of a step: all from the stages and the
//! roles that are evaluated there.

use super::hamiltonian::fits;
use super::rounding::lift;
use super::step::{LoopStep, decay};
use super::{
    Elements, EvaluationPoint, LoopMemory, PairColumns, Partials, Quadrature, QuadraturePoint, Unknowns,
    WeightedRole, slopes,
};
use crate::algebra::scalar::{Rounded, Scalar, larger};
use crate::algebra::state::{State, Vector};
use crate::scheme::system::{Hamiltonian, LagrangianGradient, Segment};

/// `q_{i+1} - q_i`; `None` if sizes do not fit.
fn increment_of<H: Elements>(system: &H, segment: &Segment<H::Vector>, dw: &[f64]) -> Option<Vec<f64>> {
    let (q0, q1, p) = (segment.q0.components(), segment.q1.components(), segment.p.components());
    let fits = q1.len() == q0.len() && dw.len() == system.noises() && fits(system, q0, p);
    fits.then(|| differences(q0, q1))
}

/// Calls `take` with each stage, each weighted role there and their point, for a segment of this increment.
fn for_each_role<H: Elements>(
    system: &H,
    scheme: &Quadrature,
    segment: &Segment<H::Vector>,
    increment: &[f64],
    dw: &[f64],
    mut take: impl FnMut(&QuadraturePoint, WeightedRole, &EvaluationPoint<'_, f64>),
) {
    let &Segment { ref q0, ref p, t, h, .. } = segment;
    let (q, p) = (q0.components(), p.components());
    let step = LoopStep { system, scheme, t, h, parameters: &[], q, p, dw, increment: Some(increment) };
    for stage in scheme.stages {
        let places = along(q, increment, stage.point);
        let at = step.at(stage, &places[..], p);
        stage.roles.iter().for_each(|&weighted| take(stage, weighted, &at));
    }
}

/// `L_d = P · (q_{i+1} - q_i) - F`, NaN if sizes do not fit.
pub(crate) fn discrete_lagrangian<H: Elements>(
    system: &H,
    scheme: &Quadrature,
    segment: &Segment<H::Vector>,
    dw: &[f64],
) -> f64 {
    let Some(u) = increment_of(system, segment, dw) else { return f64::NAN };
    let mut value = dot(segment.p.components(), &u);
    for_each_role(system, scheme, segment, &u, dw, |_, WeightedRole { role, weight }, at| {
        value -= system.value(role, weight, at);
    });
    value
}

/// The gradient of [`discrete_lagrangian`], NaN if sizes do not fit.
pub(crate) fn discrete_lagrangian_gradient<H: Elements>(
    system: &H,
    scheme: &Quadrature,
    segment: &Segment<H::Vector>,
    dw: &[f64],
) -> LagrangianGradient<H::Vector> {
    let Some(u) = increment_of(system, segment, dw) else {
        return LagrangianGradient::nowhere(segment.q0.components().len());
    };
    let mut gradient =
        LagrangianGradient { q0: segment.p.clone(), q1: segment.p.clone(), p: segment.q1.clone() };
    let [by_start, by_end, by_momentum] =
        [&mut gradient.q0, &mut gradient.q1, &mut gradient.p].map(Vector::components_mut);
    for p in &mut *by_start {
        *p = -*p;
    }
    by_momentum.copy_from_slice(&u);
    let mut force = vec![0.0; by_start.len()];
    let (mut velocity, columns) = (force.clone(), &mut PairColumns::default());
    for_each_role(system, scheme, segment, &u, dw, |stage, weighted, at| {
        force.fill(0.0);
        velocity.fill(0.0);
        slopes(system, weighted, at, Partials::ALL, &mut force, &mut velocity, columns);
        for i in 0..force.len() {
            by_start[i] -= stage.start * force[i];
            by_end[i] -= stage.end * force[i];
            by_momentum[i] -= velocity[i];
        }
    });
    if H::KIND.is_conformal {
        let decay = decay(system, &[], segment.h);
        for end in by_end {
            *end += decay * *end;
        }
    }
    gradient
}

/// `P` of the step between two states, where their momenta do not determine it from
/// `p_i = -D_1 L_d(q_i, q_{i+1}, P)`; NaN if no solution satisfies `p_{i+1} = D_2 L_d(q_i, q_{i+1}, P)`. The
/// solver is compiled only there.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn step_momentum<H: Elements>(
    system: &H,
    scheme: &Quadrature,
    [before, after]: [&State<H::Vector>; 2],
    h: f64,
    dw: &[f64],
) -> H::Vector {
    if let Some(factor) = scheme.factor() {
        return momentum_between(system, factor, before, after, h);
    }
    let mut momentum = before.p.clone();
    match momentum_increment(system, scheme, before, after, h, dw) {
        Some(v) => add(momentum.components_mut(), &v),
        None => momentum.components_mut().fill(f64::NAN),
    }
    momentum
}

/// `P` if the change of the momenta is `factor` times `v = P - p_i`. NaN if sizes do not fit.
fn momentum_between<H: Elements>(
    system: &H,
    factor: f64,
    before: &State<H::Vector>,
    after: &State<H::Vector>,
    h: f64,
) -> H::Vector {
    let decay = if H::KIND.is_conformal { decay(system, &[], h) } else { 0.0 };
    let (mut momentum, end) = (before.p.clone(), after.p.components());
    if end.len() != momentum.components().len() {
        momentum.components_mut().fill(f64::NAN);
    }
    for (p, end) in momentum.components_mut().iter_mut().zip(end) {
        // Undoes the friction.
        *p += ((end - *p) - decay * *p) / (1.0 + decay) / factor;
    }
    momentum
}

/// `v = P - p_i`, if it is found. The equation may have several solutions: the one from the start at zero is
/// nearly always that of the step. If it is not, the equation is solved from `P = p_{i+1}`, and then from the
/// `P` of the step, recomputed with both unknowns.
fn momentum_increment<H: Elements>(
    system: &H,
    scheme: &Quadrature,
    before: &State<H::Vector>,
    after: &State<H::Vector>,
    h: f64,
    dw: &[f64],
) -> Option<Vec<f64>> {
    let [q, p, end_q] = [&before.q, &before.p, &after.q].map(Vector::components);
    if [p.len(), end_q.len(), after.p.components().len()] != [q.len(); 3] || dw.len() != system.noises() {
        return None;
    }
    let u = differences(q, end_q);
    let scheme = &Quadrature { unknowns: Unknowns::Momenta, remembers: false, ..*scheme };
    let mut memory = LoopMemory::default();
    memory.fit(system, scheme, q.len()).ok()?;
    let step = LoopStep { system, scheme, t: before.t, h, parameters: &[], q, p, dw, increment: Some(&u) };
    let ends = StepEnds::new(&step, after);
    let solved = |memory: &mut LoopMemory<f64>| {
        step.careful(memory).ok()?;
        let v = memory.work.lists(scheme, q.len()).x.to_vec();
        ends.are_joined_by(&v).then_some(v)
    };
    let from = |memory: &mut LoopMemory<f64>, v: Vec<f64>| {
        for past in &mut memory.solver.past.lists {
            past.clone_from(&v);
        }
        memory.solver.past.known = 1;
        solved(memory)
    };
    solved(&mut memory)
        .or_else(|| from(&mut memory, differences(p, after.p.components())))
        .or_else(|| from(&mut memory, step.momenta()?))
}

impl<H: Elements> LoopStep<'_, H, f64> {
    /// `v` of the step itself, solved for `u` and `v` from zero.
    fn momenta(&self) -> Option<Vec<f64>> {
        let (mut memory, scheme) =
            (LoopMemory::default(), &Quadrature { unknowns: Unknowns::Both, ..*self.scheme });
        memory.fit(self.system, scheme, self.degrees()).ok()?;
        let &Self { system, t, h, parameters, q, p, dw, .. } = self;
        let step = LoopStep { system, scheme, t, h, parameters, q, p, dw, increment: None };
        step.careful(&mut memory).ok()?;
        let x = memory.work.lists(scheme, self.degrees()).x;
        Some(second_of_each(x))
    }
}

/// Passes that bound the error of a momentum: each adds a term of the geometric series in `M = Σ a_s |F_qp|`.
/// If the terms have not shrunk after that many, there is no bound.
const PASSES: u32 = 8;
/// Ratio of successive terms at which the passes end: the rest of the series is then at most its last term.
const HALVES: f64 = 0.5;

/// Both ends of a step, as intervals of all states that round to them.
struct StepEnds<'a, H> {
    step: LoopStep<'a, H, f64>,
    q: Vec<Rounded>,
    u: Vec<Rounded>,
    p: Vec<Rounded>,
    end_p: Vec<Rounded>,
    dw: Vec<Rounded>,
}

impl<'a, H: Elements> StepEnds<'a, H> {
    fn new(step: &LoopStep<'a, H, f64>, after: &State<H::Vector>) -> Self {
        let (q, p) = (lifted(step.q, Rounded::nearest), lifted(step.p, Rounded::nearest));
        let end_q = lifted(after.q.components(), Rounded::nearest);
        let end_p = lifted(after.p.components(), Rounded::nearest);
        let dw = lifted(step.dw, Rounded::exact);
        Self { step: *step, u: differences(&q, &end_q), q, p, end_p, dw }
    }

    /// Whether `P = p_i + v` solves the equations of both momenta within the rounding of the ends and of each
    /// term.
    ///
    /// Let `d` be the residual and the rounding of `P = p_i - Σ a_s F_q`. The error of `P` is at most
    /// `e = d + M e`, the sum of `δ_0 = d`, `δ_k = M δ_{k-1}`. As `M` has no negative entry,
    /// `δ_k <= θ δ_{k-1}` in each component implies the same for all later terms, which then sum to at most
    /// `θ/(1 - θ) δ_k`.
    fn are_joined_by(&self, v: &[f64]) -> bool {
        let mut momentum = exact_sums(self.step.p, v);
        let (mut terms, mut shrinking) = (vec![0.0; momentum.len()], f64::INFINITY);
        for _ in 0..PASSES {
            let pull = self.pull(&momentum, |stage| stage.start);
            shrinking = add_term(&mut momentum, &mut terms, &self.p, &pull);
            if shrinking <= HALVES {
                break;
            }
        }
        if shrinking.is_nan() || shrinking >= 1.0 {
            return false;
        }
        for (p, term) in momentum.iter_mut().zip(&terms) {
            p.error += shrinking / (1.0 - shrinking) * term;
        }
        let pull = self.pull(&momentum, |stage| stage.end);
        let kept = if H::KIND.is_conformal { 1.0 + decay(self.step.system, &[], self.step.h) } else { 1.0 };
        are_joined(&momentum, &pull, kept, &self.end_p)
    }

    /// `Σ w_s F_q(q_i + c_s u, P)`
    fn pull(&self, momentum: &[Rounded], weight: impl Fn(&QuadraturePoint) -> f64) -> Vec<Rounded> {
        let LoopStep { system, scheme, t, h, .. } = self.step;
        let (q, p, dw) = (&*self.q, &*self.p, &*self.dw);
        let step = LoopStep { system, scheme, t, h, parameters: &[], q, p, dw, increment: None };
        let nothing = vec![Rounded::exact(0.0); self.q.len()];
        let (mut sum, mut unused, columns) = (nothing.clone(), nothing.clone(), &mut PairColumns::default());
        for stage in scheme.stages.iter().filter(|stage| weight(stage) != 0.0) {
            let (places, mut by_q) = (along(&self.q, &self.u, stage.point), nothing.clone());
            step.gradient(
                stage,
                [&places, momentum],
                Partials::BY_COORDINATES,
                &mut by_q,
                &mut unused,
                columns,
            );
            add_multiple(&mut sum, &by_q, weight(stage));
        }
        sum
    }
}

// Functions of lists alone, compiled once for all systems.

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn add(sum: &mut [f64], list: &[f64]) {
    sum.iter_mut().zip(list).for_each(|(sum, number)| *sum += number);
}

fn second_of_each(pairs: &[f64]) -> Vec<f64> {
    pairs.as_chunks().0.iter().map(|&[_, v]| v).collect()
}

fn lifted(list: &[f64], as_what: fn(f64) -> Rounded) -> Vec<Rounded> {
    let mut lifted = Vec::new();
    lift(list, &mut lifted, as_what);
    lifted
}

fn differences<S: Scalar>(from: &[S], to: &[S]) -> Vec<S> {
    to.iter().zip(from).map(|(&to, &from)| to - from).collect()
}

fn exact_sums(p: &[f64], v: &[f64]) -> Vec<Rounded> {
    p.iter().zip(v).map(|(p, v)| Rounded { value: p + v, error: 0.0 }).collect()
}

/// `q + c u`
fn along<S: Scalar>(q: &[S], u: &[S], c: f64) -> Vec<S> {
    q.iter().zip(u).map(|(&q, &u)| q + u * c).collect()
}

fn add_multiple(sum: &mut [Rounded], list: &[Rounded], weight: f64) {
    sum.iter_mut().zip(list).for_each(|(sum, &number)| *sum = *sum + number * weight);
}

/// The next errors of the momenta, from the intervals `starts - pull`, and the next terms of their series;
/// the largest ratio of a term to the one before.
fn add_term(momentum: &mut [Rounded], terms: &mut [f64], starts: &[Rounded], pull: &[Rounded]) -> f64 {
    let mut shrinking = 0.0;
    for (((p, term), &start), &pull) in momentum.iter_mut().zip(terms).zip(starts).zip(pull) {
        let next = start - pull;
        let error = (next.value - p.value).abs() + next.error;
        let grown = (error - p.error).max(0.0);
        shrinking = larger(shrinking, if grown > 0.0 { grown / *term } else { grown });
        (p.error, *term) = (error, grown);
    }
    shrinking
}

fn are_joined(momentum: &[Rounded], pull: &[Rounded], kept: f64, ends: &[Rounded]) -> bool {
    let ends = momentum.iter().zip(pull).zip(ends);
    ends.map(|((&p, &pull), &end)| (p - pull) * kept - end).all(|left| left.is_below(1.0))
}
