//! The operations of a fixed-point iteration on the numbers of a tile, one by one.

use std::ops::Range;

use crate::algebra::lanes::instructions::Kernel;
use crate::scheme::elements::Elements;
use crate::scheme::elements::change::{ComparedCoordinates, LargestChange};
use crate::scheme::elements::passes::{Largest, LoopBody, in_blocks, load, store, widened};
use crate::scheme::elements::step::LoopStep;

/// `q += u`, `p += factor v`, and a copy of `v` into `past` unless that is empty.
pub(super) struct StoreState<'a> {
    pub(super) q: &'a mut [f64],
    pub(super) p: &'a mut [f64],
    pub(super) u: &'a [f64],
    pub(super) x: &'a [f64],
    pub(super) past: &'a mut [f64],
    pub(super) factor: f64,
}

impl Kernel for StoreState<'_> {
    type Output = ();

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn run<const L: usize, const HALF: usize>(self) {
        let Self { q, p, u, x, past, factor } = self;
        // Equal lengths need no further checks.
        let length = x.len();
        let (q, p, u) = (&mut q[..length], &mut p[..length], &u[..length]);
        let past = past.get_mut(..length).unwrap_or_default();
        in_blocks::<HALF>(length, &mut Self { q, p, u, x, past, factor });
    }
}

impl LoopBody for StoreState<'_> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn apply<const N: usize>(&mut self, first: usize) {
        let (mut q, mut p) = (load::<_, N>(self.q, first), load::<_, N>(self.p, first));
        let (u, x) = (load::<_, N>(self.u, first), load::<_, N>(self.x, first));
        move_on([&mut q, &mut p], &u, &x, self.factor);
        store(self.q, first, q);
        store(self.p, first, p);
        if !self.past.is_empty() {
            store(self.past, first, x);
        }
    }
}

/// The state after a step.
#[cfg_attr(not(debug_assertions), inline(always))]
fn move_on<const N: usize>([q, p]: [&mut [f64; N]; 2], u: &[f64; N], v: &[f64; N], factor: f64) {
    for i in 0..N {
        q[i] += u[i];
    }
    for i in 0..N {
        p[i] += v[i] * factor;
    }
}

/// Adds zero for each part of the state after a step that is finite.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn add_zeros<const L: usize, const N: usize>(
    zeros: &mut [f64; L],
    [mut q, mut p]: [[f64; N]; 2],
    u: &[f64; N],
    v: &[f64; N],
    factor: f64,
) {
    move_on([&mut q, &mut p], u, v, factor);
    for i in 0..N {
        q[i] = q[i] * 0.0 + p[i] * 0.0;
    }
    let (terms, mut sums): ([f64; L], _) = (widened(q), *zeros);
    for i in 0..L {
        sums[i] += terms[i];
    }
    *zeros = sums;
}

/// The start extrapolated from past steps, and `P` there.
pub(super) struct ExtrapolatedStart<'a> {
    pub(super) past: [&'a [f64]; 3],
    pub(super) known: u8,
    pub(super) p: &'a [f64],
    pub(super) x: &'a mut [f64],
    pub(super) momentum: &'a mut [f64],
}

impl LoopBody for ExtrapolatedStart<'_> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn apply<const N: usize>(&mut self, first: usize) {
        let [a, b, c] = self.past;
        let mut x = [0.0; N];
        match self.known {
            0 => {}
            1 => x = load(a, first),
            2 => {
                let (a, b) = (load::<_, N>(a, first), load::<_, N>(b, first));
                for i in 0..N {
                    x[i] = a[i] * 2.0 - b[i];
                }
            }
            _ => {
                let (a, b, c) = (load::<_, N>(a, first), load::<_, N>(b, first), load::<_, N>(c, first));
                for i in 0..N {
                    x[i] = (a[i] - b[i]) * 3.0 + c[i];
                }
            }
        }
        let mut momentum = load::<_, N>(self.p, first);
        for i in 0..N {
            momentum[i] += x[i];
        }
        store(self.x, first, x);
        store(self.momentum, first, momentum);
    }
}

/// `v ← v - (v + start F)` and `P`
pub(super) struct VelocityUpdate<'a, const L: usize> {
    pub(super) forces: &'a [f64],
    pub(super) weight: f64,
    pub(super) p: &'a [f64],
    pub(super) x: &'a mut [f64],
    pub(super) correction: &'a mut [f64],
    pub(super) momentum: &'a mut [f64],
    pub(super) size: Largest<L>,
    pub(super) corrected: Largest<L>,
}

impl<const L: usize> LoopBody for VelocityUpdate<'_, L> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn apply<const N: usize>(&mut self, first: usize) {
        let (forces, mut x) = (load::<_, N>(self.forces, first), load::<_, N>(self.x, first));
        let mut momentum = load::<_, N>(self.p, first);
        let mut correction = [0.0; N];
        for i in 0..N {
            correction[i] = x[i] + forces[i] * self.weight;
        }
        for i in 0..N {
            x[i] -= correction[i];
        }
        for i in 0..N {
            momentum[i] += x[i];
        }
        self.size.take_finite(&x);
        self.corrected.include(&correction);
        store(self.correction, first, correction);
        store(self.x, first, x);
        store(self.momentum, first, momentum);
    }
}

/// `u` and `Q` from the sums of velocities.
pub(super) struct CoordinateUpdate<'a> {
    pub(super) velocities: &'a [f64],
    pub(super) q: &'a [f64],
    pub(super) point: f64,
    pub(super) u: &'a mut [f64],
    pub(super) next: &'a mut [f64],
}

impl<'a> CoordinateUpdate<'a> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn new<H: Elements + Sync>(
        step: &LoopStep<'a, H, f64>,
        places: &Range<usize>,
        velocities: &'a [f64],
        point: f64,
        u: &'a mut [f64],
        next: &'a mut [f64],
    ) -> Self {
        Self { velocities, q: &step.q[places.clone()], point, u, next }
    }
}

impl LoopBody for CoordinateUpdate<'_> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn apply<const N: usize>(&mut self, first: usize) {
        let (u, mut next) = (load::<_, N>(self.velocities, first), load::<_, N>(self.q, first));
        for i in 0..N {
            next[i] += u[i] * self.point;
        }
        store(self.u, first, u);
        store(self.next, first, next);
    }
}

/// [`CoordinateUpdate`], and the change that it makes.
pub(super) struct ComparedUpdate<'a, const L: usize> {
    pub(super) follow: CoordinateUpdate<'a>,
    pub(super) before: &'a [f64],
    pub(super) seen: &'a mut LargestChange<L>,
    pub(super) p: &'a [f64],
    pub(super) x: &'a [f64],
    pub(super) factor: f64,
    /// Zero while the state after the step is finite.
    pub(super) zeros: [f64; L],
}

impl<const L: usize> LoopBody for ComparedUpdate<'_, L> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn apply<const N: usize>(&mut self, first: usize) {
        let CoordinateUpdate { velocities: u, q, point, .. } = self.follow;
        ComparedCoordinates { q, u, before: self.before, point, seen: self.seen }.apply::<N>(first);
        let (q, u) = (load::<_, N>(q, first), load::<_, N>(u, first));
        let (p, x) = (load::<_, N>(self.p, first), load::<_, N>(self.x, first));
        add_zeros(&mut self.zeros, [q, p], &u, &x, self.factor);
        self.follow.apply::<N>(first);
    }
}
