//! What an ensemble costs per path and step, beside a loop written by hand with the same normals, the normals alone, and C.
//!
//! `cargo bench --workspace --bench ensemble` measures everything in one run, on one core, and once on two. The C programs
//! (`hand_sde.c`, 8 lanes and a cheaper generator) are compiled with `gcc -O3 -march=native`, and left out where there is no
//! gcc. Times are the shortest of many short repetitions, which alternate: what else the machine does, shows least in them.
//! `-- Heiles 100000` takes so many starts of Hénon and Heiles, three times. With `RUSTFLAGS="-C target-cpu=native"` on an Intel processor with AVX-512 the compiler
//! prefers registers of 256 bits, also where these loops ask for 512: run it both ways.

#![allow(clippy::unwrap_used, reason = "a benchmark stops at the first error")]

mod bath;
mod by_hand;
mod c;
#[allow(dead_code, reason = "what another benchmark needs of it")]
#[path = "../gauss/by_hand.rs"]
mod gauss_by_hand;
mod scenes;
mod starts;

use std::hint::black_box;
use std::time::Instant;

use scenes::{STEPS, Scene};

/// One block: no more than a few milliseconds.
const PATHS: u64 = 512;
const REPETITIONS: usize = 101;
/// For two threads, which take time to begin.
const MANY_PATHS: u64 = 1 << 14;
const FEW_REPETITIONS: usize = 9;

/// Nanoseconds per path and step: the shortest of several, in turn with the others.
fn times<const N: usize>(paths: u64, repetitions: usize, runs: [&dyn Fn(); N]) -> [f64; N] {
    let mut shortest = [f64::INFINITY; N];
    for _ in 0..repetitions {
        for (shortest, run) in shortest.iter_mut().zip(runs) {
            let began = Instant::now();
            run();
            let nanoseconds = began.elapsed().as_secs_f64() * 1e9 / (paths * STEPS) as f64;
            *shortest = shortest.min(nanoseconds);
        }
    }
    shortest
}

fn main() {
    // `cargo bench` adds a flag of its own.
    let mut words = std::env::args().skip(1).filter(|argument| !argument.starts_with("--"));
    let (only, starts) = (words.next(), words.next().map(|number| number.parse().unwrap()));
    let c = c::measure();
    println!(
        "ns per path and step; {:?}; {PATHS} paths of {STEPS} steps; compiled for {}",
        wzvi::ensemble::InstructionSet::best(),
        // Those of AMD with AVX-512 have it, too, and do not prefer half of it.
        if cfg!(all(target_feature = "avx512f", not(target_feature = "sse4a"))) {
            "a processor with AVX-512 that prefers 256 bits (-C target-cpu)"
        } else {
            "any processor of the target, or one that prefers the widest registers"
        }
    );
    println!(
        "{:26}{:>9}{:>9}{:>9}{:>9}{:>10}{:>9}{:>9}{:>9}{:>9}",
        "",
        "ensemble",
        "normals",
        "by hand",
        "C lanes",
        "C scalar",
        "/normals",
        "by hand/",
        "/C lanes",
        "2 threads"
    );
    for Scene { name, ensemble, normals, by_hand, c: problem, mean } in scenes::ALL {
        if only.as_ref().is_some_and(|only| !name.contains(only.as_str())) {
            continue;
        }
        let [one, alone, hand] = times(
            PATHS,
            REPETITIONS,
            [&|| _ = black_box(ensemble(PATHS, 1)), &|| normals(PATHS), &|| _ = black_box(by_hand(PATHS))],
        );
        let [single, double] = times(
            MANY_PATHS,
            FEW_REPETITIONS,
            [&|| _ = black_box(ensemble(MANY_PATHS, 1)), &|| _ = black_box(ensemble(MANY_PATHS, 2))],
        );
        let ((ours, error), theirs) = (ensemble(PATHS, 2), by_hand(PATHS));
        assert!(
            (ours - theirs).abs() < 1e-9,
            "{name}: {ours} ± {error}, by hand {theirs}: not the same paths"
        );
        let c = c.iter().find(|(known, ..)| *known == problem);
        let show = |number: Option<f64>| number.map_or("-".into(), |number| format!("{number:.2}"));
        println!(
            "{name:26}{one:>9.2}{alone:>9.2}{hand:>9.2}{:>9}{:>10}{:>9.2}{:>9.2}{:>9}{:>9.2}    {mean} = {ours:.5} ± {error:.5}",
            show(c.map(|c| c.1)),
            show(c.map(|c| c.2)),
            one / alone,
            hand / one,
            show(c.map(|c| one / c.1)),
            single / double,
        );
    }
    match starts {
        Some(paths) => starts::print(paths, 3, only.as_deref()),
        None => starts::print(PATHS, REPETITIONS, only.as_deref()),
    }
    bath::print(PATHS, REPETITIONS, only.as_deref());
}
