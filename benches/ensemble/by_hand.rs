//! The same paths by loops of numbers, one path after the other, as one writes them.

use std::hint::black_box;

use wzvi::ensemble::Normals;
use wzvi::noise::clip_bound;

use crate::scenes::{SEED, STEPS};

/// The normals of one step after the other.
#[inline(always)]
fn drive<const K: usize>(path: u64, h: f64, mut step: impl FnMut([f64; K])) {
    let processes: [Normals; K] = std::array::from_fn(|k| Normals::new(SEED, k as u64, h));
    for block in 0..STEPS / 10 {
        let drawn = processes.each_ref().map(|process| process.of_path(path, block));
        (0..10).for_each(|i| step(std::array::from_fn(|k| drawn[k][i])));
    }
}

/// The rotation in closed form.
pub(crate) fn kubo(paths: u64) -> f64 {
    let (a, sigma, h) = (black_box(1.5), black_box(1.0), 0.02_f64);
    let (deviation, bound) = (h.sqrt(), clip_bound(h, 4.0));
    let mut sum = 0.0;
    for path in 0..paths {
        let (mut q, mut p) = (0.0, 1.0);
        drive(path, h, |[z]| {
            let half = 0.5 * (a * h + sigma * z.clamp(-bound, bound) * deviation);
            let inverse = 1.0 / (1.0 + half * half);
            let (cosine, sine) = ((1.0 - half * half) * inverse, 2.0 * half * inverse);
            (q, p) = (cosine * q + sine * p, cosine * p - sine * q);
        });
        sum += q;
    }
    sum / paths as f64
}

/// The two shifts, and a rotation with constant coefficients.
pub(crate) fn additive(paths: u64) -> f64 {
    let (sigma, gamma, h) = (black_box(0.5), black_box(1.0), 0.02_f64);
    let deviation = h.sqrt();
    let half = 0.5 * h;
    let inverse = 1.0 / (1.0 + half * half);
    let (cosine, sine) = ((1.0 - half * half) * inverse, 2.0 * half * inverse);
    let mut sum = 0.0;
    for path in 0..paths {
        let (mut q, mut p) = (0.0, 0.0);
        drive(path, h, |[z1, z2]| {
            let (u, v) = (sigma * z1 * deviation * inverse, gamma * z2 * deviation * inverse);
            (q, p) = (cosine * q + sine * p + u + half * v, cosine * p - sine * q + v - half * u);
        });
        sum += 0.5 * (q * q + p * p);
    }
    sum / paths as f64
}

/// Newton's method for one unknown, `Q`, with `P` eliminated.
pub(crate) fn double_well(paths: u64) -> f64 {
    let (s, h) = (black_box(0.3), 0.01_f64);
    let (deviation, bound) = (h.sqrt(), clip_bound(h, 4.0));
    let mut sum = 0.0;
    for path in 0..paths {
        let (mut q, mut p) = (0.5, 0.5);
        drive(path, h, |[z]| {
            let w = 0.5 * s * z.clamp(-bound, bound) * deviation;
            let half = 0.5 * h;
            let k = half / (1.0 + w);
            let mut mid = q;
            for _ in 0..50 {
                let force = mid * mid * mid - mid;
                let residual = mid * (1.0 - w) - q - k * (p - half * force);
                let correction = residual / (1.0 - w + k * half * (3.0 * mid * mid - 1.0));
                mid -= correction;
                // Quadratic: the next one is below 1e-18.
                if f64::abs(correction) <= 1e-10 {
                    break;
                }
            }
            let momentum = (p - half * (mid * mid * mid - mid)) / (1.0 + w);
            (q, p) = (2.0 * mid - q, 2.0 * momentum - p);
        });
        sum += q * q;
    }
    sum / paths as f64
}
