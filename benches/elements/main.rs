//! Systems whose sums stay loops, beside steps written by hand: nanoseconds, instructions, and growth with the size.
//!
//! `cargo bench --workspace --bench elements` steps every problem in this process for the time of a step, and again under
//! `valgrind --tool=callgrind` for the number of its instructions: two runs of different length, so that everything
//! outside of the steps cancels. Without valgrind, or without a C compiler, what needs them is left out with a word.
//! A name after `--` picks problems: `cargo bench --workspace --bench elements -- lattice`.
//!
//! * `chain`: FPUT-beta, ends fixed, first mode of amplitude 1, β = 1/4, h = 0.05; also in C (`hand_ode.c`).
//! * `bodies`: gravity between all pairs, softened, h = 0.01; also in C with `omp simd` (`hand_bodies.c`), and per pair.
//! * `lattice`: the field φ⁴ on a torus of N = n² sites, h = 0.05; also in C (`hand_field.c`).
//! * `ring`: coupled pendulums around a ring, h = 0.05; also in C; `Baoab` with increments that are there.
//! * `mean field`: rotors that feel their magnetisation, h = 0.05.
//! * `network`: oscillators on a random graph with a table of 3 bonds per site, N = 4096, h = 0.05; also in C (`hand_network.c`).
//! * `rods`: a chain of rods in the plane that falls from a horizontal line, h = 0.002; also in C (`hand_rods.c`).
//! * `polymer`: a chain of points in space, per point.
//! * `stiff`: `Midpoint` where the fixed point does not contract: FPUT-alpha-beta at h = 3, and the field φ⁴ on 256² sites with `k h²` from 1 to 10⁶.
//!
//! `sums`: `Verlet` with plain and with compensated sums, and runs whose energy is monitored or not.
//!
//! All of that on one thread. `memory`: steps of a million sites on one core and on all stand beside a triad, `a = b + s c`, of as many.

#![allow(clippy::unwrap_used, reason = "a benchmark stops at the first error")]

mod bodies;
mod c_program;
mod chain;
mod lattice;
mod mean_field;
mod measure;
mod memory;
mod network;
mod ring;
mod rods;
mod stiff;
mod sums;

use c_program::USUAL;
use measure::{Case, growth};

/// Everything that is measured: each case generated, then by hand.
fn cases() -> Vec<Case> {
    let mut cases = chain::cases();
    cases.extend(bodies::cases());
    cases.extend(lattice::cases());
    cases.extend(ring::cases());
    cases.extend(mean_field::cases());
    cases.extend(network::cases());
    cases.extend(rods::cases());
    cases.extend(stiff::cases());
    cases
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let cases = cases();
    if let [flag, case, who, steps] = arguments.as_slice()
        && flag == "--run"
    {
        let case = cases.iter().find(|known| known.name() == *case).unwrap();
        let make = if who == "generated" { case.generated } else { case.by_hand };
        make(case.n).run(steps.parse().unwrap());
        return;
    }
    let only = arguments.iter().find(|argument| !argument.starts_with("--"));
    let wanted = |name: &str| only.is_none_or(|only| name.contains(only.as_str()));
    println!("ns and instructions per site and step; iterations per step in parentheses\n");
    println!(
        "{:10}{:>10}{:>10}{:>18}{:>16}{:>7}{:>10}{:>10}{:>7}",
        "", "scheme", "N", "generated ns", "by hand ns", "ratio", "instr", "by hand", "ratio"
    );
    let mut times = Vec::new();
    for case in cases.iter().filter(|case| wanted(case.problem)) {
        let row = case.measure();
        println!("{row}");
        times.push((case, row));
    }
    println!();
    growth(&times);
    if wanted("bodies") {
        bodies::per_pair(&times);
        let sizes = [(8, 2_000), (64, 100), (512, 10)];
        c_program::report("Bodies", "hand_bodies.c", &sizes, c_program::VECTORS);
    }
    if wanted("chain") || wanted("memory") {
        memory::report();
    }
    if wanted("chain") {
        c_program::report("The chain", "hand_ode.c", &[(32, 4_000), (1024, 100), (1_000_000, 1)], USUAL);
    }
    if wanted("sums") {
        sums::report();
    }
    if wanted("network") {
        c_program::report("The network", "hand_network.c", &[(network::N, 40)], USUAL);
    }
    if wanted("rods") {
        c_program::report("The chain of rods", "hand_rods.c", &[(100, 200), (1000, 20)], USUAL);
    }
    if wanted("lattice") || wanted("ring") {
        c_program::report("Fields", "hand_field.c", &[(1024, 200), (65_536, 4)], USUAL);
    }
}
