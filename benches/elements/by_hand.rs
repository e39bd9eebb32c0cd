//! The same steps as a person would write them for this chain, after the C program of the same name.

fn force(d: f64, beta: f64) -> f64 {
    d * (1.0 + beta * d * d)
}

/// `P = p - h V'(q)`, `q += h P`, `p = P`.
pub(crate) fn delta_plus(q: &mut [f64], p: &mut [f64], beta: f64, h: f64, steps: usize) {
    let n = q.len();
    for _ in 0..steps {
        p[0] += h * (force(q[1] - q[0], beta) - force(q[0], beta));
        for (p, window) in p[1..n - 1].iter_mut().zip(q.windows(3)) {
            *p += h * (force(window[2] - window[1], beta) - force(window[1] - window[0], beta));
        }
        p[n - 1] += h * (force(-q[n - 1], beta) - force(q[n - 1] - q[n - 2], beta));
        for (q, p) in q.iter_mut().zip(&*p) {
            *q += h * p;
        }
    }
}

/// The mid-point rule by fixed-point iteration on the mid-point, to an absolute change of 1e-15.
pub(crate) struct Midpoint {
    q: Vec<f64>,
    p: Vec<f64>,
    base: Vec<f64>,
    /// With a wall at each end.
    middle: Vec<f64>,
    next: Vec<f64>,
    beta: f64,
    h: f64,
    pub(crate) iterations: u64,
    pub(crate) steps: u64,
}

impl Midpoint {
    pub(crate) fn new(q: Vec<f64>, p: Vec<f64>, beta: f64, h: f64) -> Self {
        let n = q.len();
        let walls = vec![0.0; n + 2];
        Self { base: q.clone(), q, p, middle: walls.clone(), next: walls, beta, h, iterations: 0, steps: 0 }
    }

    pub(crate) fn run(&mut self, steps: usize) {
        let (n, h, beta) = (self.q.len(), self.h, self.beta);
        let a = 0.25 * h * h;
        for _ in 0..steps {
            for (base, (q, p)) in self.base.iter_mut().zip(self.q.iter().zip(&self.p)) {
                *base = q + 0.5 * h * p;
            }
            self.middle[1..=n].copy_from_slice(&self.base);
            loop {
                self.iterations += 1;
                let mut change = 0.0_f64;
                for ((next, base), window) in
                    self.next[1..=n].iter_mut().zip(&self.base).zip(self.middle.windows(3))
                {
                    let pull = force(window[2] - window[1], beta) - force(window[1] - window[0], beta);
                    *next = base + a * pull;
                    let own = (*next - window[1]).abs();
                    change = if own > change { own } else { change };
                }
                std::mem::swap(&mut self.middle, &mut self.next);
                if change <= 1e-15 {
                    break;
                }
            }
            for ((q, p), middle) in self.q.iter_mut().zip(&mut self.p).zip(&self.middle[1..=n]) {
                let end = 2.0 * middle - *q;
                *p = 2.0 * (end - *q) / h - *p;
                *q = end;
            }
            self.steps += 1;
        }
    }
}
