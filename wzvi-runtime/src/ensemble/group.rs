//! Paths that run beside each other in the lanes of vector registers: their noise, their steps, and what becomes of each.

use super::draws::{STEPS, normals, normals_at};
use super::job::Job;
use super::pace::Pace;
use super::passage::{Passage, crossing};
use super::statistics::{PathFailure, Statistics};
use crate::carry::Plain;
use crate::error::{Error, StepError, StepFailure};
use crate::increments::Interval;
use crate::lanes::Lanes;
use crate::noise::Paths;
use crate::plan::Solver;
use crate::rescue::{Hard, rescue};
use crate::retry::{Walker, is_curable};
use crate::scalar::Scalar;
use crate::state::{State, Vector};
use crate::step::Stepper;
use crate::system::Discretized;

/// The place of a step among those that are drawn together.
#[inline(always)]
fn slot(step: u64) -> usize {
    (step % STEPS as u64) as usize
}

/// `L` paths that run beside each other.
pub(super) struct Group<'j, 'a, H: Discretized<E>, E, const L: usize> {
    job: &'j Job<'a, H, E>,
    path: u64,
    q: Vec<Lanes<L>>,
    p: Vec<Lanes<L>>,
    /// What steps in lanes allocate once. With noise none reads what the ones before left.
    memory: H::Memory<Lanes<L>>,
    processes: usize,
    keys: Vec<[u32; 8]>,
    /// Normals by process and step, where more is made of them than increments.
    normals: Vec<[[f64; L]; STEPS]>,
    /// Increments of `STEPS` steps: those of the first, then those of the second, ...
    increments: Vec<Lanes<L>>,
    deviation: f64,
    /// Lanes that are paths of this run; others only keep the vector full.
    counts: [bool; L],
    /// Lanes whose path has failed: they follow a neighbour.
    failed: [bool; L],
    any_failed: bool,
    failures: Vec<PathFailure>,
    /// What each event's function was at the last node.
    before: Vec<[f64; L]>,
    /// When each event happened; NaN before.
    passed: Vec<[f64; L]>,
    /// Number of each lane among the paths that are kept.
    kept: [usize; L],
    values: Vec<f64>,
    /// The values of the other path of an antithetic pair.
    first_of_pair: Vec<f64>,
    scratch: Vec<f64>,
    state: State<H::Vector>,
    /// Increments of one lane.
    alone: Vec<f64>,
    /// Where steps are no matter of lanes ([`Discretized::IN_LANES`]): one stepper for each.
    steppers: Vec<Stepper<'a, H, E, Plain>>,
    /// The noise of each lane, where lanes do not draw it themselves.
    noises: Vec<Box<dyn Paths + 'j>>,
    /// Halves steps, once one has to be.
    walker: Option<Walker<'a, H, E, Plain>>,
}

impl<'j, 'a, H: Discretized<E>, E, const L: usize> Group<'j, 'a, H, E, L> {
    pub(super) fn new(job: &'j Job<'a, H, E>) -> Self {
        // That of the system, which may not know it.
        let (d, processes) = (job.start.q.components().len(), job.system.noises());
        let zero = Lanes::from_f64(0.0);
        let normals = job.source.normals();
        let keys = normals.map(|normals| (0..processes).map(|k| normals.key(k as u64, job.h)).collect());
        let noises = if normals.is_some() { 0 } else { L };
        Self {
            job,
            path: 0,
            q: vec![zero; d],
            p: vec![zero; d],
            memory: Default::default(),
            processes,
            keys: keys.unwrap_or_default(),
            normals: vec![[[0.0; L]; STEPS]; processes],
            increments: vec![zero; STEPS * processes],
            deviation: job.h.abs().sqrt(),
            counts: [false; L],
            failed: [false; L],
            any_failed: false,
            failures: Vec::new(),
            before: vec![[0.0; L]; job.events.len()],
            passed: vec![[0.0; L]; job.events.len()],
            kept: [0; L],
            values: vec![0.0; job.observables.len()],
            first_of_pair: vec![0.0; job.observables.len()],
            scratch: vec![0.0; job.observables.len()],
            state: job.start.clone(),
            alone: vec![0.0; processes],
            steppers: Vec::new(),
            noises: (0..noises).map(|_| job.source.path(0)).collect(),
            walker: None,
        }
    }

    /// Starts paths `path ..`, as many as there are before `end`.
    pub(super) fn begin(&mut self, path: u64, end: u64) {
        self.path = path;
        let start = &self.job.start;
        for (to, from) in self.q.iter_mut().zip(start.q.components()) {
            *to = Lanes::from_f64(*from);
        }
        for (to, from) in self.p.iter_mut().zip(start.p.components()) {
            *to = Lanes::from_f64(*from);
        }
        self.counts = std::array::from_fn(|lane| path + (lane as u64) < end);
        (self.failed, self.any_failed) = ([false; L], false);
        for (noise, lane) in self.noises.iter_mut().zip(path..) {
            noise.set_path(lane);
        }
        if !H::IN_LANES {
            // It cannot fail: the same has been prepared for the job.
            let stepper = |_| Stepper::new(self.job.system, self.job.h).ok().map(Stepper::plain);
            self.steppers = (0..L).filter_map(stepper).collect();
        }
    }

    /// What is known of events and kept paths at the start.
    pub(super) fn watch_from(&mut self, statistics: &mut Statistics) {
        let start = &self.job.start;
        if let Some(paths) = &mut statistics.paths {
            for lane in 0..L {
                if self.counts[lane] {
                    self.kept[lane] = paths.begin();
                }
            }
        }
        for ((before, passed), event) in self.before.iter_mut().zip(&mut self.passed).zip(&self.job.events) {
            let value = event(start);
            *before = [value; L];
            *passed = [if value == 0.0 { start.t } else { f64::NAN }; L];
        }
    }

    fn time(&self, step: u64) -> f64 {
        self.job.start.t + step as f64 * self.job.h
    }

    /// The increments of a step; steps are drawn in order.
    #[inline(always)]
    pub(super) fn draw(&mut self, step: u64) {
        if self.job.is_antithetic {
            return self.draw_pairs(step);
        }
        if !self.noises.is_empty() {
            return self.ask(step);
        }
        if slot(step) > 0 {
            return;
        }
        let processes = self.processes;
        let mut drawn = [[0.0; L]; STEPS];
        for (process, key) in self.keys.iter().enumerate() {
            normals(key, self.path, step / STEPS as u64, &mut drawn);
            for (step, drawn) in drawn.iter().enumerate() {
                if let Some(to) = self.increments.get_mut(step * processes + process) {
                    *to = self.job.increment(Lanes::new(*drawn), self.deviation);
                }
            }
        }
    }

    /// [`Group::draw`] where each path has a noise of its own.
    #[inline(never)]
    fn ask(&mut self, step: u64) {
        let interval = Interval { start: self.job.start.t, h: self.job.h, step };
        let (_, to) = self.increments.split_at_mut(slot(step) * self.processes);
        for (lane, noise) in self.noises.iter_mut().enumerate() {
            if !self.counts[lane] || self.failed[lane] {
                continue;
            }
            if let Err(error) = noise.increments(&interval, &mut self.alone) {
                self.job.fail_noise(error);
            }
            for (to, from) in to.iter_mut().zip(&self.alone) {
                to.set(lane, *from);
            }
        }
    }

    /// [`Group::draw`] for paths `2k` and `2k + 1` with the normals of path `k`, as they are and negated: of the lanes that
    /// are drawn at once, half are for the steps after the next [`STEPS`].
    #[inline(always)]
    fn draw_pairs(&mut self, step: u64) {
        let within = step % (2 * STEPS as u64);
        if within == 0 {
            let (first, block, half) = (self.path / 2, step / STEPS as u64, L as u64 / 2);
            for (key, to) in self.keys.iter().zip(&mut self.normals) {
                normals_at(key, |lane| (first.wrapping_add(lane % half), block + lane / half), to);
            }
        }
        let (half, within) = (within as usize / STEPS, within as usize % STEPS);
        for process in 0..self.keys.len() {
            let drawn = &self.normals[process][within];
            let signed = |lane: usize| {
                let normal = drawn[half * (L / 2) + lane / 2];
                if lane.is_multiple_of(2) { normal } else { -normal }
            };
            self.drive(process, step, Lanes::new(std::array::from_fn(signed)));
        }
    }

    /// The normals of a step, before truncation, in the place of [`Group::draw`]; steps are drawn in order.
    #[inline(always)]
    pub(super) fn drawn(&mut self, process: usize, step: u64) -> Lanes<L> {
        if slot(step) == 0
            && let (Some(key), Some(to)) = (self.keys.get(process), self.normals.get_mut(process))
        {
            normals(key, self.path, step / STEPS as u64, to);
        }
        Lanes::new(self.normals[process][slot(step)])
    }

    /// Sets the increments of a step from normals.
    #[inline(always)]
    pub(super) fn drive(&mut self, process: usize, step: u64, normals: Lanes<L>) {
        let place = slot(step) * self.processes + process;
        if let Some(to) = self.increments.get_mut(place) {
            *to = self.job.increment(normals, self.deviation);
        }
    }

    /// Takes a step with the increments that were drawn.
    #[inline(always)]
    pub(super) fn advance(&mut self, step: u64) {
        let (job, within) = (self.job, slot(step));
        if !H::IN_LANES {
            return self.by_steppers(step, within);
        }
        if self.any_failed && !self.mirror(within) {
            return;
        }
        let t = self.time(step);
        let (q, p, memory) = (&mut self.q, &mut self.p, &mut self.memory);
        let processes = self.processes;
        let Some(dw) = self.increments.get(within * processes..(within + 1) * processes) else { return };
        let outcome = job.system.advance_carrying::<Lanes<L>, Plain, false>(
            &job.prepared,
            t,
            job.h,
            q,
            p,
            dw,
            memory,
            &mut Plain,
        );
        if outcome.is_err() {
            self.one_by_one(step, t, within);
        }
    }

    #[inline(never)]
    fn by_steppers(&mut self, step: u64, within: usize) {
        let t = self.time(step);
        let first = within * self.processes;
        let mut steppers = std::mem::take(&mut self.steppers);
        for (lane, stepper) in steppers.iter_mut().enumerate() {
            if !self.failed[lane] {
                self.look(lane);
                self.state.t = t;
                for (to, from) in self.alone.iter_mut().zip(self.increments.iter().skip(first)) {
                    *to = from[lane];
                }
                match stepper.step(&mut self.state, &self.alone) {
                    Ok(_) => self.keep(lane),
                    Err(error) => self.halve_or_fail(lane, step, StepError { step, ..error }),
                }
            }
        }
        self.steppers = steppers;
    }

    /// Lanes without a path follow the first that has one; `false` if none has.
    #[cold]
    #[inline(never)]
    fn mirror(&mut self, within: usize) -> bool {
        let Some(living) = (0..L).find(|&lane| !self.failed[lane]) else { return false };
        let processes = self.processes;
        let dw = self.increments.iter_mut().skip(within * processes).take(processes);
        for x in self.q.iter_mut().chain(&mut self.p).chain(dw) {
            let old = x.to_array();
            *x = Lanes::new(std::array::from_fn(|lane| old[if self.failed[lane] { living } else { lane }]));
        }
        true
    }

    /// The step that not all lanes can take the short way.
    #[cold]
    #[inline(never)]
    fn one_by_one(&mut self, step: u64, t: f64, within: usize) {
        for lane in 0..L {
            if self.failed[lane] {
                continue;
            }
            if let Err(cause) = self.single(lane, t, within) {
                self.halve_or_fail(lane, step, StepError { step, t, h: self.job.h, cause });
            }
        }
    }

    /// The step of one path again, in halves, if that is allowed.
    fn halve_or_fail(&mut self, lane: usize, step: u64, error: StepError) {
        let is_tried = self.job.retry.most() > 0 && is_curable(error.cause) && self.counts[lane];
        match if is_tried { self.halve(lane, step, error) } else { Err(error.into()) } {
            Ok(state) => self.put(lane, &state.q, &state.p),
            Err(Error::Step(error)) => self.fail(lane, error),
            Err(Error::Noise(why)) => {
                self.job.fail_noise(why);
                self.fail(lane, error);
            }
            // A finer step that cannot be prepared.
            Err(_) => self.fail(lane, error),
        }
    }

    fn halve(&mut self, lane: usize, step: u64, error: StepError) -> Result<State<H::Vector>, Error> {
        let job = self.job;
        let mut state = self.state_of(lane, error.t);
        let walker = match &mut self.walker {
            Some(walker) => walker,
            none => none.insert(Walker::new(job.system, job.h, job.retry, !H::IN_LANES)?),
        };
        let mut noise = (self.processes > 0).then(|| job.source.path(self.path + lane as u64));
        let interval = Interval { start: job.start.t, h: job.h, step };
        walker.subdivide(
            &mut state,
            &interval,
            &mut noise.as_deref_mut(),
            &mut vec![0.0; self.processes],
            1,
        )?;
        Ok(state)
    }

    fn fail(&mut self, lane: usize, error: StepError) {
        (self.failed[lane], self.any_failed) = (true, true);
        if self.counts[lane] {
            self.failures.push(PathFailure { path: self.path + lane as u64, error });
        }
    }

    fn state_of(&self, lane: usize, t: f64) -> State<H::Vector> {
        let vector = |lanes: &[Lanes<L>]| {
            let mut vector = H::Vector::zeros(lanes.len());
            for (to, from) in vector.components_mut().iter_mut().zip(lanes) {
                *to = from[lane];
            }
            vector
        };
        State { q: vector(&self.q), p: vector(&self.p), t }
    }

    fn put(&mut self, lane: usize, q: &H::Vector, p: &H::Vector) {
        let components = q.components().iter().chain(p.components());
        for (to, from) in self.q.iter_mut().chain(&mut self.p).zip(components) {
            to.set(lane, *from);
        }
    }

    /// Moves what observables see to a lane.
    fn keep(&mut self, lane: usize) {
        let components = self.state.q.components().iter().chain(self.state.p.components());
        for (to, from) in self.q.iter_mut().chain(&mut self.p).zip(components) {
            to.set(lane, *from);
        }
    }

    /// One lane, as it goes alone: the short way, then the careful one of a [`Stepper`].
    fn single(&mut self, lane: usize, t: f64, within: usize) -> Result<(), StepFailure> {
        let job = self.job;
        let alone = |lanes: &[Lanes<L>]| -> Vec<_> { lanes.iter().map(|x| Lanes::new([x[lane]])).collect() };
        let processes = self.processes;
        let dw = self.increments.get(within * processes..(within + 1) * processes).unwrap_or_default();
        let (mut q, mut p, dw) = (alone(&self.q), alone(&self.p), alone(dw));
        let outcome = job.system.advance_carrying::<Lanes<1>, Plain, false>(
            &job.prepared,
            t,
            job.h,
            &mut q,
            &mut p,
            &dw,
            &mut Default::default(),
            &mut Plain,
        );
        match outcome {
            Ok(_) => {
                for (to, from) in self.q.iter_mut().chain(&mut self.p).zip(q.iter().chain(&p)) {
                    to.set(lane, from[0]);
                }
            }
            Err(cause) if !matches!(H::PLAN.solver, Solver::Newton) => return Err(cause),
            Err(cause) => {
                let State { q, p, t } = self.state_of(lane, t);
                let dw: Vec<f64> = dw.iter().map(|dw| dw[0]).collect();
                let (system, h, prepared) = (job.system, job.h, job.prepared.clone());
                let rescued = rescue(Hard { system, prepared, t, h, q, p, dw: &dw, carry: Plain }, cause)?;
                self.put(lane, &rescued.q, &rescued.p);
            }
        }
        Ok(())
    }

    /// The state of a lane after so many steps.
    pub(super) fn state_after(&mut self, lane: usize, steps: u64) -> &State<H::Vector> {
        self.state.t = self.time(steps);
        self.look(lane)
    }

    /// The increments of a lane in a step that has been drawn.
    pub(super) fn increments_of(&mut self, lane: usize, step: u64) -> &[f64] {
        let first = slot(step) * self.processes;
        for (to, from) in self.alone.iter_mut().zip(self.increments.iter().skip(first)) {
            *to = from[lane];
        }
        &self.alone
    }

    /// Moves a lane to where observables see it.
    fn look(&mut self, lane: usize) -> &State<H::Vector> {
        for (to, from) in self.state.q.components_mut().iter_mut().zip(&self.q) {
            *to = from[lane];
        }
        for (to, from) in self.state.p.components_mut().iter_mut().zip(&self.p) {
            *to = from[lane];
        }
        &self.state
    }

    /// Whether a lane is a path of this run.
    pub(super) fn is_path(&self, lane: usize) -> bool {
        self.counts[lane]
    }

    /// The first of the paths, by number, that failed since this was asked last.
    pub(super) fn take_first_failure(&mut self) -> Option<PathFailure> {
        self.sort_failures();
        self.failures.drain(..).next()
    }

    /// Why this path failed, if it has.
    pub(super) fn failure_of(&self, path: u64) -> Option<PathFailure> {
        self.failures.iter().find(|failure| failure.path == path).copied()
    }

    /// They came in the order of time, which depends on who ran beside whom.
    fn sort_failures(&mut self) {
        self.failures.sort_unstable_by_key(|failure| failure.path);
    }

    /// Looks for the events of a step that has been taken.
    #[inline(never)]
    pub(super) fn watch(&mut self, step: u64) {
        let times = [self.time(step), self.time(step + 1)];
        self.state.t = times[1];
        for lane in 0..L {
            let is_over = !self.counts[lane] || self.failed[lane];
            if is_over || self.passed.iter().all(|passed| !passed[lane].is_nan()) {
                continue;
            }
            self.look(lane);
            let memory = self.before.iter_mut().zip(&mut self.passed);
            for ((before, passed), event) in memory.zip(&self.job.events) {
                if passed[lane].is_nan() {
                    let after = event(&self.state);
                    if let Some(time) = crossing(times, [before[lane], after]) {
                        passed[lane] = time;
                    }
                    before[lane] = after;
                }
            }
        }
    }

    /// Adds the paths that are still there to the statistics of a node; `None` if the run was stopped on the way.
    #[inline(never)]
    pub(super) fn record(
        &mut self,
        node: usize,
        statistics: &mut Statistics,
        pace: &mut Pace<'_>,
    ) -> Option<()> {
        let moments = statistics.nodes.get_mut(node)?;
        self.state.t = moments.time();
        for lane in 0..L {
            if pace.is_stopped() {
                return None;
            }
            if self.counts[lane] && self.failed[lane] {
                moments.lose();
            }
            if !self.counts[lane] || self.failed[lane] {
                continue;
            }
            self.look(lane);
            for (value, observable) in self.values.iter_mut().zip(&self.job.observables) {
                *value = observable(&self.state);
            }
            moments.push(&self.values, &mut self.scratch, &self.job.wanted);
            if let Some(paths) = &mut statistics.paths {
                paths.put(self.kept[lane], node, &self.values);
            }
            if self.job.is_antithetic {
                if lane.is_multiple_of(2) {
                    self.first_of_pair.copy_from_slice(&self.values);
                } else if !self.failed[lane - 1] {
                    moments.push_pair(&mut self.first_of_pair, &self.values, &mut self.scratch);
                }
            }
        }
        Some(())
    }

    /// What became of the paths, in the order of their numbers.
    pub(super) fn finish(&mut self, statistics: &mut Statistics) {
        self.sort_failures();
        let watched = statistics.passages.iter_mut().zip(&self.passed).zip(&self.job.wanted.watches);
        for ((passages, passed), watch) in watched {
            let mut failures = self.failures.iter();
            for lane in (0..L).filter(|&lane| self.counts[lane]) {
                let failure = if self.failed[lane] { failures.next() } else { None };
                let passage = match failure {
                    _ if !passed[lane].is_nan() => Passage::At(passed[lane]),
                    Some(failure) => Passage::Lost(failure.error.t),
                    None => Passage::Censored,
                };
                passages.push(passage, watch);
            }
        }
        for failure in self.failures.drain(..) {
            statistics.fail(failure);
        }
    }
}
