//! What a step costs where the size of a system is a literal, a const generic or that of a slice, from one site to many.
//!
//! Each closure is compiled with a literal size (`literal`), for which the compiler chooses straight lines or loops, and in loops, with a const
//! generic (`generic`) and for slices (`slice`). A choice of straight lines is right where `literal` is not slower than `generic`.
//!
//! `cargo bench --workspace --bench seam` times paths alone and in ensembles of eight lanes, in nanoseconds per path, site and step; the last line of each closure has
//! the largest ratio of `literal` to `generic`. `-- --counts` counts the instructions per site and step of a path alone under
//! `valgrind --tool=callgrind`: two runs of different length, so that everything outside of the steps cancels.
//!
//! All closures take twenty minutes to compile, one takes a few: `cargo bench --workspace --bench seam --no-default-features --features chain`.
//!
//! * `kubo`: oscillators with one multiplicative noise each, which are not coupled.
//! * `chain`: Fermi-Pasta between walls.
//! * `torus`: a chain whose sites are bound to the next and to the third one.
//! * `pairs`: every site repels every other one; work per site grows with N.
//! * `curved`: a chain of masses that depend on the place.

#![allow(clippy::unwrap_used, reason = "a benchmark stops at the first error")]

mod counts;

use std::hint::black_box;
use std::time::Instant;

use wzvi::prelude::*;
use wzvi::state::Vector;

const H: f64 = 0.05;
const SPELLINGS: [&str; 3] = ["literal", "generic", "slice"];

/// One system of one size in one spelling.
struct Case {
    problem: &'static str,
    spelling: &'static str,
    sites: usize,
    /// Takes so many steps.
    steps: fn(usize, u64),
    /// Takes so many paths of so many steps.
    ensemble: Option<fn(usize, u64, u64)>,
}

fn start<V: Vector>(sites: usize) -> State<V> {
    let mut state = State { q: V::zeros(sites), p: V::zeros(sites), t: 0.0 };
    let both = state.q.components_mut().iter_mut().zip(state.p.components_mut());
    for (i, (q, p)) in both.enumerate() {
        (*q, *p) = ((1.3 * i as f64 + 0.2).sin(), (1.3 * i as f64 + 1.1).sin());
    }
    state
}

fn run<E, H: Discretized<E>>(system: &H, sites: usize, steps: u64) {
    let mut stepper = system.stepper::<E>(self::H).unwrap();
    let mut state = start::<H::Vector>(sites);
    // Increments that repeat themselves after so many steps.
    const PERIOD: usize = 64;
    let noises = system.noises();
    let dw: Vec<f64> = (0..PERIOD * noises).map(|i| 0.2 * (0.7 * i as f64).sin()).collect();
    for step in 0..steps as usize {
        let first = step % PERIOD * noises;
        black_box(stepper.step(&mut state, &dw[first..first + noises]).unwrap());
    }
    black_box(state);
}

fn ensemble<E, H>(system: &H, sites: usize, paths: u64, steps: u64)
where
    H: Discretized<E> + Sync,
{
    let run = system.ensemble::<E>(self::H).start(start(sites)).paths(paths).steps(steps).threads(1).seed(7);
    black_box(run.observe("q", |state| state.q.components()[0]).run_in::<8>().unwrap());
}

/// The systems of a closure, by spelling and size.
macro_rules! systems {
    ($system:ident) => {
        mod $system {
            use wzvi::prelude::*;
            fixtures::$system!(Slices, [], &[f64], sites);
            fixtures::$system!(Generic, [<const N: usize>], [f64; N], N);
            fixtures::$system!(Sites2, [], [f64; 2], 2);
            fixtures::$system!(Sites4, [], [f64; 4], 4);
            fixtures::$system!(Sites5, [], [f64; 5], 5);
            fixtures::$system!(Sites6, [], [f64; 6], 6);
            fixtures::$system!(Sites8, [], [f64; 8], 8);
            fixtures::$system!(Sites12, [], [f64; 12], 12);
            fixtures::$system!(Sites16, [], [f64; 16], 16);
        }
    };
}

#[cfg(feature = "kubo")]
systems!(kubo);
#[cfg(feature = "chain")]
systems!(chain);
#[cfg(feature = "torus")]
systems!(torus);
#[cfg(feature = "pairs")]
systems!(pairs);
#[cfg(feature = "curved")]
systems!(curved);

macro_rules! cases {
    ($cases:ident, $system:ident) => {
        cases!(@sizes $cases, $system, Sites2 2, Sites4 4, Sites5 5, Sites6 6, Sites8 8, Sites12 12, Sites16 16);
    };
    (@sizes $cases:ident, $system:ident, $($name:ident $sites:literal),*) => {
        $(
            cases!(@case $cases, $system, "literal", $sites, Some, [$system::$name]);
            cases!(@case $cases, $system, "generic", $sites, Some, [$system::Generic::<$sites>]);
            cases!(@case $cases, $system, "slice", $sites, none, [$system::Slices]);
        )*
    };
    (@case $cases:ident, $system:ident, $spelling:literal, $sites:literal, $ensemble:ident, [$($type:tt)*]) => {
        $cases.push(Case {
            problem: stringify!($system),
            spelling: $spelling,
            sites: $sites,
            steps: |sites, steps| {
                let (a, s) = (black_box(0.7), black_box(0.4));
                run::<Midpoint, _>(&$($type)* { a, s, sites }, sites, steps)
            },
            ensemble: cases!(@$ensemble [$($type)*]),
        });
    };
    (@none [$($type:tt)*]) => { None };
    (@Some [$($type:tt)*]) => {
        Some(|sites, paths, steps| {
            let (a, s) = (black_box(0.7), black_box(0.4));
            ensemble::<Midpoint, _>(&$($type)* { a, s, sites }, sites, paths, steps)
        })
    };
}

fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    #[cfg(feature = "kubo")]
    cases!(cases, kubo);
    #[cfg(feature = "chain")]
    cases!(cases, chain);
    #[cfg(feature = "torus")]
    cases!(cases, torus);
    #[cfg(feature = "pairs")]
    cases!(cases, pairs);
    #[cfg(feature = "curved")]
    cases!(cases, curved);
    cases
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let cases = cases();
    if let [flag, number, steps] = arguments.as_slice()
        && flag == "--run"
    {
        let case = &cases[number.parse::<usize>().unwrap()];
        (case.steps)(case.sites, steps.parse().unwrap());
        return;
    }
    let mut problems: Vec<&str> = cases.iter().map(|case| case.problem).collect();
    problems.dedup();
    let mut sizes: Vec<usize> = cases.iter().map(|case| case.sites).collect();
    sizes.sort_unstable();
    sizes.dedup();
    if arguments.iter().any(|argument| argument == "--counts") {
        return counts::report(&cases, &problems, &sizes);
    }
    println!("ns per path, site and step: alone, and in an ensemble");
    let sizes: String = sizes.iter().map(|sites| format!("{:>16}", format!("N = {sites}"))).collect();
    println!("{:18}{sizes}", "");
    for problem in problems {
        let mut largest = [0.0f64; 2];
        let rows = SPELLINGS.map(|spelling| {
            let row = cases.iter().filter(|case| case.problem == problem && case.spelling == spelling);
            row.map(times).collect::<Vec<_>>()
        });
        for (spelling, row) in SPELLINGS.iter().zip(&rows) {
            let row =
                row.iter().map(|[alone, together]| format!("{:>16}", format!("{alone:.1} {together:.1}")));
            println!("{problem:9}{spelling:9}{}", row.collect::<String>());
        }
        let [literal, generic, ..] = &rows;
        for (literal, generic) in literal.iter().zip(generic) {
            for (way, largest) in largest.iter_mut().enumerate() {
                *largest = largest.max(literal[way] / generic[way]);
            }
        }
        println!(
            "{problem:9}literal by generic: at most {:.2} alone, {:.2} in ensembles\n",
            largest[0], largest[1]
        );
    }
}

/// The shortest of some repetitions.
fn shortest(mut run: impl FnMut()) -> f64 {
    let once = |run: &mut dyn FnMut()| {
        let began = Instant::now();
        run();
        began.elapsed().as_secs_f64() * 1e9
    };
    (0..9).map(|_| once(&mut run)).fold(f64::INFINITY, f64::min)
}

/// Alone and in an ensemble, NaN if there is none.
fn times(case: &Case) -> [f64; 2] {
    const STEPS: u64 = 200;
    const PATHS: u64 = 64;
    let sites = case.sites;
    let per = |time: f64, paths: u64| time / (paths * STEPS * sites as u64) as f64;
    let alone = per(shortest(|| (case.steps)(sites, STEPS)), 1);
    let together =
        case.ensemble.map_or(f64::NAN, |ensemble| per(shortest(|| ensemble(sites, PATHS, STEPS)), PATHS));
    [alone, together]
}
