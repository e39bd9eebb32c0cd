//! What a step costs where the size of a system is a literal, a const generic or that of a slice, from one site to many.
//!
//! `cargo bench --bench seam` counts the instructions per site and step of every closure under
//! `valgrind --tool=callgrind`: two runs of different length, so that everything outside of the steps cancels. Behind them
//! stands the largest ratio of neighbours in the table. Then it times ensembles beside steppers, in nanoseconds per path,
//! site and step. A name after `--` picks closures: `cargo bench --bench seam -- chain`.
//!
//! Literal sizes from 5 to 7 are forced to straight lines: beside const generics, which are always loops, they show where the choice between the two lies.
//!
//! * `kubo`: oscillators with one multiplicative noise each, which are not coupled.
//! * `chain`: Fermi-Pasta between walls.
//! * `pairs`: every site repels every other one; work per site grows with N.
//! * `pushed`: a chain with one additive noise for each site.

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
    /// Takes so many paths of so many steps, if there is noise.
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
    black_box(run.observe("q", |state| state.q.components()[0]).run().unwrap());
}

macro_rules! spellings {
    ($($system:ident: $($scheme:ident $(in $lanes:ident)?),*;)*) => {
        $(
            mod $system {
                use wzvi::prelude::*;
                fixtures::$system!(Slices, [], &[f64], sites);
                fixtures::$system!(Generic, [<const N: usize>], [f64; N], N);
                fixtures::$system!(Sites1, [], [f64; 1], 1);
                fixtures::$system!(Sites2, [], [f64; 2], 2);
                fixtures::$system!(Sites3, [], [f64; 3], 3);
                fixtures::$system!(Sites5, [], [f64; 5], 5, inline);
                fixtures::$system!(Sites6, [], [f64; 6], 6, inline);
                fixtures::$system!(Sites7, [], [f64; 7], 7, inline);
                fixtures::$system!(Sites8, [], [f64; 8], 8);
                fixtures::$system!(Sites15, [], [f64; 15], 15);
                fixtures::$system!(Sites16, [], [f64; 16], 16);
                fixtures::$system!(Sites17, [], [f64; 17], 17);
                fixtures::$system!(Sites18, [], [f64; 18], 18);
                fixtures::$system!(Sites64, [], [f64; 64], 64);
            }
        )*

        fn cases() -> Vec<Case> {
            let mut cases = Vec::new();
            $($(
                spellings!(@sizes cases, $system, $scheme, ($($lanes)?), Sites1 1 alone, Sites2 2 alone, Sites3 3 alone,
                    Sites5 5 lanes, Sites6 6 lanes, Sites7 7 lanes, Sites8 8 alone, Sites15 15 alone, Sites16 16 lanes, Sites17 17 lanes, Sites18 18 alone, Sites64 64 alone);
            )*)*
            cases
        }
    };
    (@sizes $cases:ident, $system:ident, $scheme:ident, $lanes:tt, $($literal:ident $sites:literal $literals:ident),*) => {$(
        spellings!(@case $cases, $system, $scheme, ($lanes $literals), "literal", $sites, [$system::$literal]);
        spellings!(@case $cases, $system, $scheme, ($lanes $literals), "generic", $sites, [$system::Generic::<$sites>]);
        spellings!(@case $cases, $system, $scheme, ($lanes lanes), "slice", $sites, [$system::Slices]);
    )*};
    (@case $cases:ident, $system:ident, $scheme:ident, $lanes:tt, $spelling:literal, $sites:literal, [$($type:tt)*]) => {{
        $cases.push(Case {
            problem: concat!(stringify!($system), " ", stringify!($scheme)),
            spelling: $spelling,
            sites: $sites,
            steps: |sites, steps| {
                let (a, s) = (black_box(0.7), black_box(0.4));
                run::<$scheme, _>(&$($type)* { a, s, sites }, sites, steps)
            },
            ensemble: spellings!(@ensemble $scheme, [$($type)*], $lanes),
        });
    }};
    (@ensemble $scheme:ident, [$($type:tt)*], ($lanes:tt alone)) => { None };
    (@ensemble $scheme:ident, [$($type:tt)*], (() lanes)) => { None };
    (@ensemble $scheme:ident, [$($type:tt)*], ((lanes) lanes)) => {
        Some(|sites, paths, steps| {
            let (a, s) = (black_box(0.7), black_box(0.4));
            ensemble::<$scheme, _>(&$($type)* { a, s, sites }, sites, paths, steps)
        })
    };
}

spellings! {
    kubo: Midpoint in lanes;
    chain: DeltaPlus, Midpoint in lanes;
    pairs: DeltaPlus, Midpoint in lanes;
    pushed: DeltaPlus in lanes, Midpoint in lanes;
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let cases = cases();
    if let [flag, number, steps] = arguments.as_slice()
        && flag == "--run"
    {
        let case: &Case = &cases[number.parse::<usize>().unwrap()];
        (case.steps)(case.sites, steps.parse().unwrap());
        return;
    }
    let only = arguments.iter().find(|argument| !argument.starts_with("--"));
    let mut problems: Vec<&str> = cases.iter().map(|case| case.problem).collect();
    problems.dedup();
    problems.retain(|problem| only.is_none_or(|only| problem.contains(only.as_str())));
    let mut sizes: Vec<usize> = cases.iter().map(|case| case.sites).collect();
    sizes.sort_unstable();
    sizes.dedup();
    counts::report(&cases, &problems, &sizes);
    println!("\nns per path, site and step: alone, and in an ensemble");
    for problem in problems {
        for spelling in SPELLINGS {
            let row = cases.iter().filter(|case| case.problem == problem && case.spelling == spelling);
            let row: Vec<String> = row.filter_map(times).collect();
            if !row.is_empty() {
                println!("{problem:18}{spelling:9}{}", row.concat());
            }
        }
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

fn times(case: &Case) -> Option<String> {
    const STEPS: u64 = 200;
    const PATHS: u64 = 64;
    let (sites, ensemble) = (case.sites, case.ensemble?);
    let per = |time: f64, paths: u64| time / (paths * STEPS * sites as u64) as f64;
    let alone = per(shortest(|| (case.steps)(sites, STEPS)), 1);
    let together = per(shortest(|| ensemble(sites, PATHS, STEPS)), PATHS);
    Some(format!("{:>16}", format!("{alone:.1} {together:.1}")))
}
