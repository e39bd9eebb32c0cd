//! Times, counts of instructions, and their growth.

use std::fmt;
use std::process::Command;
use std::time::Instant;

use wzvi::nalgebra::DVector;
use wzvi::prelude::*;

/// Something that steps.
pub(crate) trait Runner {
    fn run(&mut self, steps: usize);
    /// Coordinates and momenta.
    fn state(&self) -> (Vec<f64>, Vec<f64>);
    /// Over all steps so far.
    fn iterations(&self) -> u64;
}

/// A problem of one size under one scheme.
#[derive(Clone, Copy)]
pub(crate) struct Case {
    pub(crate) problem: &'static str,
    pub(crate) scheme: &'static str,
    pub(crate) n: usize,
    /// As many as take a few milliseconds, or one.
    pub(crate) steps: usize,
    /// Whether it is run under valgrind, too, which takes fifty times as long.
    pub(crate) is_counted: bool,
    /// How far the two may end apart after 10 steps: rounding, and what one of them leaves of the equations.
    pub(crate) tolerance: f64,
    pub(crate) generated: fn(usize) -> Box<dyn Runner>,
    pub(crate) by_hand: fn(usize) -> Box<dyn Runner>,
}

/// Short runs, the two taking turns; the best counts, as everything else on the machine only adds.
pub(crate) const REPETITIONS: usize = 25;

impl Case {
    pub(crate) fn name(&self) -> String {
        format!("{}-{}-{}", self.problem, self.scheme, self.n)
    }

    pub(crate) fn measure(&self) -> Row {
        let makers = [self.generated, self.by_hand];
        let mut runners = makers.map(|make| make(self.n));
        // Both do the same.
        runners.iter_mut().for_each(|runner| runner.run(10));
        let [(q, p), (hand_q, hand_p)] = [runners[0].state(), runners[1].state()];
        let pairs = q.iter().zip(&hand_q).chain(p.iter().zip(&hand_p));
        let apart = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart < self.tolerance, "{} ends {apart:.1e} away from the one by hand", self.name());
        let before = [runners[0].iterations(), runners[1].iterations()];
        let mut best = [f64::INFINITY; 2];
        for _ in 0..REPETITIONS {
            for (runner, best) in runners.iter_mut().zip(&mut best) {
                let start = Instant::now();
                runner.run(self.steps);
                *best = best.min(start.elapsed().as_nanos() as f64 / (self.n * self.steps) as f64);
            }
        }
        let taken = (self.steps * REPETITIONS) as f64;
        let iterations = [0, 1].map(|i| (runners[i].iterations() - before[i]) as f64 / taken);
        let counts =
            if self.is_counted { ["generated", "by hand"].map(|who| self.count(who)) } else { [None; 2] };
        Row { case: *self, nanoseconds: best, iterations, counts }
    }

    /// Instructions per site and step.
    fn count(&self, who: &str) -> Option<f64> {
        let steps = self.steps.clamp(4, 200);
        let run = |steps: usize| callgrind(&["--run", &self.name(), who, &steps.to_string()]);
        Some((run(2 * steps)? - run(steps)?) / (self.n * steps) as f64)
    }
}

/// Instructions of this program with `arguments`.
fn callgrind(arguments: &[&str]) -> Option<f64> {
    // Without the string instructions of the C library, each byte of which counts as an instruction.
    const PLAIN: &str =
        "glibc.cpu.x86_rep_stosb_threshold=1000000000:glibc.cpu.x86_rep_movsb_threshold=1000000000";
    let output = Command::new("valgrind")
        .env("GLIBC_TUNABLES", PLAIN)
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(std::env::current_exe().ok()?)
        .args(arguments)
        .output()
        .ok()?;
    let report = String::from_utf8_lossy(&output.stderr);
    let (_, collected) = report.split_once("Collected :")?;
    collected.split_whitespace().next()?.parse().ok()
}

/// What was measured of a case, generated and by hand.
pub(crate) struct Row {
    case: Case,
    nanoseconds: [f64; 2],
    iterations: [f64; 2],
    counts: [Option<f64>; 2],
}

impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let time = |i: usize| match self.iterations[i] {
            0.0 => format!("{:.2}", self.nanoseconds[i]),
            iterations => format!("{:.2} ({iterations:.1})", self.nanoseconds[i]),
        };
        let count = |i: usize| self.counts[i].map_or("-".into(), |count| format!("{count:.1}"));
        let ratio =
            self.counts[0].zip(self.counts[1]).map_or("-".into(), |(own, hand)| format!("{:.2}", own / hand));
        write!(
            f,
            "{:10}{:>10}{:>10}{:>18}{:>16}{:>7.2}{:>10}{:>10}{ratio:>7}",
            self.case.problem,
            self.case.scheme,
            self.case.n,
            time(0),
            time(1),
            self.nanoseconds[0] / self.nanoseconds[1],
            count(0),
            count(1),
        )
    }
}

/// The power of N with which a step of each problem grows, by least squares on logarithms.
pub(crate) fn growth(rows: &[(&Case, Row)]) {
    let mut seen: Vec<(&str, &str)> = Vec::new();
    for (case, _) in rows {
        let key = (case.problem, case.scheme);
        if seen.contains(&key) {
            continue;
        }
        seen.push(key);
        let own = rows.iter().filter(|(other, _)| (other.problem, other.scheme) == key);
        let points = |i: usize| -> Vec<(f64, f64)> {
            own.clone()
                .map(|(case, row)| ((case.n as f64).ln(), (row.nanoseconds[i] * case.n as f64).ln()))
                .collect()
        };
        // Of one size nothing grows.
        if own.clone().count() < 2 {
            continue;
        }
        let [generated, by_hand] = [0, 1].map(|i| slope(&points(i)));
        println!("{:10}{:>10}: a step takes N^{generated:.2}, by hand N^{by_hand:.2}", key.0, key.1);
    }
}

fn slope(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let (x, y) = (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
    let [xy, xx] = points
        .iter()
        .fold([0.0, 0.0], |[xy, xx], p| [xy + (p.0 - x) * (p.1 - y), xx + (p.0 - x) * (p.0 - x)]);
    xy / xx
}

/// A generated step with its state.
struct Generated<H: Discretized<E> + 'static, E: 'static> {
    stepper: Stepper<'static, H, E>,
    state: State<H::Vector>,
    dw: Vec<f64>,
    iterations: u64,
}

/// The generated step of a system from a start, on one thread as those by hand.
pub(crate) fn generated<H, E: 'static>(
    system: &'static H,
    h: f64,
    q: Vec<f64>,
    p: Vec<f64>,
) -> Box<dyn Runner>
where
    H: Discretized<E, Vector = DVector<f64>>,
{
    generated_with(system, h, q, p, Vec::new())
}

/// The same on so many threads.
pub(crate) fn generated_on<H, E: 'static>(
    threads: usize,
    system: &'static H,
    h: f64,
    q: Vec<f64>,
    p: Vec<f64>,
) -> Box<dyn Runner>
where
    H: Discretized<E, Vector = DVector<f64>>,
{
    let stepper = system.stepper::<E>(h).unwrap().threads(threads).unwrap();
    Box::new(Generated { stepper, state: State::new(q, p), dw: Vec::new(), iterations: 0 })
}

/// The same on one thread, with the same increments in each step.
pub(crate) fn generated_with<H, E: 'static>(
    system: &'static H,
    h: f64,
    q: Vec<f64>,
    p: Vec<f64>,
    dw: Vec<f64>,
) -> Box<dyn Runner>
where
    H: Discretized<E, Vector = DVector<f64>>,
{
    let stepper = system.stepper::<E>(h).unwrap().threads(1).unwrap();
    Box::new(Generated { stepper, state: State::new(q, p), dw, iterations: 0 })
}

impl<H: Discretized<E, Vector = DVector<f64>>, E> Runner for Generated<H, E> {
    fn run(&mut self, steps: usize) {
        for _ in 0..steps {
            self.iterations += u64::from(self.stepper.step(&mut self.state, &self.dw).unwrap().iterations);
        }
    }
    fn state(&self) -> (Vec<f64>, Vec<f64>) {
        (self.state.q.as_slice().to_vec(), self.state.p.as_slice().to_vec())
    }
    fn iterations(&self) -> u64 {
        self.iterations
    }
}

/// What separates problems by hand: forces.
pub(crate) trait Forces {
    /// `force = -V'(q)`; nothing else is read or written.
    fn forces(&self, q: &[f64], force: &mut [f64]);
}

/// `P = p + h f(q)`, `q += h P`, `p = P`.
pub(crate) struct Explicit<F> {
    pub(crate) forces: F,
    pub(crate) q: Vec<f64>,
    pub(crate) p: Vec<f64>,
    pub(crate) force: Vec<f64>,
    pub(crate) h: f64,
}

impl<F: Forces> Explicit<F> {
    pub(crate) fn boxed(forces: F, h: f64, q: Vec<f64>, p: Vec<f64>) -> Box<dyn Runner>
    where
        F: 'static,
    {
        Box::new(Self { forces, force: vec![0.0; q.len()], q, p, h })
    }
}

impl<F: Forces> Runner for Explicit<F> {
    fn run(&mut self, steps: usize) {
        for _ in 0..steps {
            self.forces.forces(&self.q, &mut self.force);
            for ((q, p), force) in self.q.iter_mut().zip(&mut self.p).zip(&self.force) {
                *p += self.h * force;
                *q += self.h * *p;
            }
        }
    }
    fn state(&self) -> (Vec<f64>, Vec<f64>) {
        (self.q.clone(), self.p.clone())
    }
    fn iterations(&self) -> u64 {
        0
    }
}

/// `P = p + h/2 f(q)`, `q += h P`, `p = P + h/2 f(q)`, whose force is that of the next step, too.
pub(crate) struct KickDriftKick<F> {
    explicit: Explicit<F>,
}

impl<F: Forces> KickDriftKick<F> {
    pub(crate) fn boxed(forces: F, h: f64, q: Vec<f64>, p: Vec<f64>) -> Box<dyn Runner>
    where
        F: 'static,
    {
        let mut force = vec![0.0; q.len()];
        forces.forces(&q, &mut force);
        Box::new(Self { explicit: Explicit { forces, force, q, p, h } })
    }
}

impl<F: Forces> Runner for KickDriftKick<F> {
    fn run(&mut self, steps: usize) {
        let Explicit { forces, q, p, force, h } = &mut self.explicit;
        for _ in 0..steps {
            for ((q, p), force) in q.iter_mut().zip(&mut *p).zip(&*force) {
                *p += 0.5 * *h * force;
                *q += *h * *p;
            }
            forces.forces(q, force);
            for (p, force) in p.iter_mut().zip(&*force) {
                *p += 0.5 * *h * force;
            }
        }
    }
    fn state(&self) -> (Vec<f64>, Vec<f64>) {
        self.explicit.state()
    }
    fn iterations(&self) -> u64 {
        0
    }
}

/// The mid-point rule by fixed-point iteration on the mid-point, from the parabola through the last three, until a
/// correction is below 1e-15 or does not shrink.
pub(crate) struct FixedPoint<F> {
    forces: F,
    q: Vec<f64>,
    p: Vec<f64>,
    base: Vec<f64>,
    middle: Vec<f64>,
    force: Vec<f64>,
    /// Forces of the last three steps, the latest first.
    past: [Vec<f64>; 3],
    h: f64,
    steps: u64,
    iterations: u64,
}

impl<F: Forces> FixedPoint<F> {
    pub(crate) fn boxed(forces: F, h: f64, q: Vec<f64>, p: Vec<f64>) -> Box<dyn Runner>
    where
        F: 'static,
    {
        let zeros = || vec![0.0; q.len()];
        let past = [zeros(), zeros(), zeros()];
        let (base, middle, force) = (zeros(), zeros(), zeros());
        Box::new(Self { forces, base, middle, force, past, q, p, h, steps: 0, iterations: 0 })
    }

    fn step(&mut self) {
        let (h, a) = (self.h, 0.25 * self.h * self.h);
        let [first, second, third] = &self.past;
        for i in 0..self.q.len() {
            let guess = match self.steps {
                0 => 0.0,
                1 => first[i],
                2 => 2.0 * first[i] - second[i],
                _ => 3.0 * (first[i] - second[i]) + third[i],
            };
            self.base[i] = self.q[i] + 0.5 * h * self.p[i];
            self.middle[i] = self.base[i] + a * guess;
        }
        let mut last = f64::INFINITY;
        loop {
            self.iterations += 1;
            self.forces.forces(&self.middle, &mut self.force);
            let mut change = 0.0_f64;
            for ((middle, base), force) in self.middle.iter_mut().zip(&self.base).zip(&self.force) {
                let next = base + a * force;
                let own = (next - *middle).abs();
                change = if own > change { own } else { change };
                *middle = next;
            }
            if change <= 1e-15 || change >= last {
                break;
            }
            last = change;
        }
        for ((q, p), middle) in self.q.iter_mut().zip(&mut self.p).zip(&self.middle) {
            let end = 2.0 * middle - *q;
            *p = 2.0 * (end - *q) / h - *p;
            *q = end;
        }
        self.past.rotate_right(1);
        self.past[0].copy_from_slice(&self.force);
        self.steps += 1;
    }
}

impl<F: Forces> Runner for FixedPoint<F> {
    fn run(&mut self, steps: usize) {
        for _ in 0..steps {
            self.step();
        }
    }
    fn state(&self) -> (Vec<f64>, Vec<f64>) {
        (self.q.clone(), self.p.clone())
    }
    fn iterations(&self) -> u64 {
        self.iterations
    }
}
