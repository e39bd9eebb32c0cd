//! Steps of a million sites, on one core and on all of them, beside a triad of as many numbers on as many.

use std::num::NonZero;
use std::sync::Barrier;
use std::thread;
use std::time::Instant;

use crate::chain;
use crate::measure::{REPETITIONS, Runner};

/// Of memory that an explicit step of many sites reads and writes, per site: `q` and `p`, and the new ones, which are read before they are
/// written.
const BYTES: f64 = 48.0;

/// Sites of the chain, and numbers of each list of the triad.
const MANY: usize = 1_000_000;

/// Gigabytes per second of `a = b + s c`: 32 bytes each, of which 8 are those of `a`, read before they are written. Threads begin and end a
/// pass together.
fn triad(threads: usize) -> f64 {
    let [b, c] = [1.0, 2.0].map(|value| vec![value; MANY]);
    let mut a = vec![0.0; MANY];
    let (barrier, size) = (&Barrier::new(threads), MANY.div_ceil(threads));
    let parts = a.chunks_mut(size).zip(b.chunks(size).zip(c.chunks(size)));
    let best = thread::scope(|scope| {
        let running: Vec<_> =
            parts.map(|(a, (b, c))| scope.spawn(move || passes(barrier, a, b, c))).collect();
        running.into_iter().map(|thread| thread.join().unwrap()).fold(f64::INFINITY, f64::min)
    });
    32.0 * MANY as f64 / best
}

/// The best time of a pass, in nanoseconds.
fn passes(barrier: &Barrier, a: &mut [f64], b: &[f64], c: &[f64]) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..REPETITIONS {
        barrier.wait();
        let start = Instant::now();
        for (a, (b, c)) in a.iter_mut().zip(b.iter().zip(c)) {
            *a = b + 3.0 * c;
        }
        std::hint::black_box(&mut *a);
        barrier.wait();
        best = best.min(start.elapsed().as_nanos() as f64);
    }
    best
}

/// The best time of a step of `n` sites, in nanoseconds, from runs of several million sites.
fn step(runner: &mut dyn Runner, n: usize) -> f64 {
    let steps = 4 * MANY.div_ceil(n);
    let mut best = f64::INFINITY;
    runner.run(3);
    for _ in 0..REPETITIONS {
        let start = Instant::now();
        runner.run(steps);
        best = best.min(start.elapsed().as_nanos() as f64 / steps as f64);
    }
    best
}

/// The rates of both, on as many threads, and from which size on threads pay.
pub(crate) fn report() {
    let cores = thread::available_parallelism().map_or(1, NonZero::get);
    println!("\nA million sites beside a triad, at {BYTES} bytes per site and step\n");
    for threads in [1, cores] {
        // How much a fixed point reads and writes depends on its iterations.
        let explicit =
            chain::on_threads(threads, MANY).into_iter().filter(|(scheme, _)| *scheme != "Midpoint");
        for (scheme, mut runner) in explicit {
            let (own, triad) = (step(&mut *runner, MANY) / MANY as f64, triad(threads));
            println!(
                "  {scheme:10}{threads:>3} threads {own:>7.2} ns {:>7.1} GB/s, {:.2} of the triad's {triad:.1}",
                BYTES / own,
                BYTES / own / triad
            );
        }
    }
    println!("\nMicroseconds of a step on 1 thread / on {cores}\n");
    for n in (16..=20).map(|power| 1 << power) {
        let [one, all] = [1, cores].map(|threads| {
            chain::on_threads(threads, n).map(|(scheme, mut runner)| (scheme, step(&mut *runner, n) / 1e3))
        });
        let row = one
            .iter()
            .zip(all)
            .map(|((scheme, one), (_, all))| format!("  {scheme:10}{one:>8.1} /{all:>7.1}"));
        println!("{n:>10}{}", row.collect::<String>());
    }
}
