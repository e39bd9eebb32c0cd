//! Paths of large systems, which go one after the other and tile by tile: the same as beside each other in lanes, to the last bit.

use wzvi::bath::{A, B, O};
use wzvi::nalgebra::DVector;
use wzvi::noise::Truncation;
use wzvi::prelude::*;

use fixtures::bath::{FreeChain, Kicked};
use fixtures::stepped::every_split;

/// More than a tile, no multiple of a block, and enough for paths to go by themselves.
const SITES: usize = 523;
const PATHS: u64 = 13;

fn start(scale: f64) -> State<DVector<f64>> {
    let wave = |phase: f64| (0..SITES).map(|i| scale * (0.7 * i as f64 + phase).sin()).collect::<Vec<_>>();
    State::new(wave(0.0), wave(1.0))
}

/// A run that is the same in every split.
macro_rules! check {
    ($run:expr) => {{
        let run = || {
            $run.paths(PATHS)
                .seed(5)
                .observe("q", |state| state.q[3])
                .observe("p²", |state| state.p.norm_squared())
        };
        let lanes = every_split(run);
        assert!(lanes.variance("q").expect("a variance") > 0.0);
        lanes
    }};
}

#[test]
fn paths_by_themselves_are_those_in_lanes() {
    let bath = Kicked { sites: SITES, gamma: 0.7, kt: 0.4 };
    check!(bath.ensemble::<Baoab>(0.1).start(start(1.0)).steps(11).record_every(4));
    // A last step that is shorter, from a start of each path, with a truncation.
    check!(
        bath.ensemble::<Baoab>(0.1)
            .starts_from((0..PATHS).map(|path| start(path as f64)))
            .until(1.23)
            .truncation(Truncation::On(1.0))
    );
    // No friction at all: what is between the drifts has no tiles.
    let still = Kicked { gamma: 0.0, ..bath.clone() };
    check!(still.ensemble::<Baoab>(0.1).start(start(1.0)).steps(11));
    check!(
        FreeChain
            .ensemble::<Verlet>(0.1)
            .starts_from((0..PATHS).map(|path| start(0.1 * path as f64)))
            .steps(11)
    );
    // Systems of the paths.
    let systems = |path: u64| Kicked { gamma: 0.1 * path as f64, ..bath.clone() };
    check!(bath.ensemble::<Baoab>(0.1).systems_from((0..PATHS).map(systems)).start(start(1.0)).steps(11));
    // What is looked for inside of steps.
    let passed = check!(bath.ensemble::<Baoab>(0.1).start(start(1.0)).steps(40).section(|state| state.q[0]));
    assert!(passed.crossings().len() == 1);
}

/// Sites with friction, and a word of nine letters.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        p.iter().map(|p| 0.5 * p * p).sum::<f64>() + q.windows(2).map(|w| 0.5 * (w[1] - w[0]).powi(2)).sum::<f64>()
    },
    friction = gamma, temperature = kt,
    embedding = [Splitting<(B, A, O, A, B, A, O, A, B)>],
)]
#[derive(Clone)]
struct Spelled {
    gamma: f64,
    kt: f64,
}

/// Tile by tile and at once, for words of any length.
#[test]
fn long_words_go_tile_by_tile() {
    type Word = Splitting<(B, A, O, A, B, A, O, A, B)>;
    let bath = Spelled { gamma: 0.7, kt: 0.4 };
    check!(bath.ensemble::<Word>(0.1).start(start(1.0)).steps(11));
}

/// A path that fails does so alone, at the same step.
#[test]
fn paths_fail_alone() {
    let run = || {
        let run = FreeChain
            .ensemble::<Verlet>(0.5)
            .starts_from((0..9).map(|path| start(if path == 4 { 1e3 } else { 0.1 })));
        run.paths(9).steps(60).allow_losses(0.5).observe("q", |state| state.q[3])
    };
    let (by_themselves, lanes) = (run().run().expect("a run"), run().run_in::<4>().expect("a run"));
    assert!(by_themselves == lanes);
    assert_eq!(by_themselves.failures().iter().map(|failure| failure.path).collect::<Vec<_>>(), [4]);
}

/// A path of the ensemble is the same as a simulation, and antithetic pairs are what they are.
#[test]
fn paths_can_be_had_again() {
    let bath = Kicked { sites: SITES, gamma: 0.7, kt: 0.4 };
    let run = || bath.ensemble::<Baoab>(0.1).start(start(1.0)).paths(PATHS).seed(5).steps(23);
    let (path, _) = run().replay(7).expect("a path");
    let noise = StepNormals::seed(5).path(7);
    let alone = bath.simulate::<Baoab>(0.1).start(start(1.0)).noise(noise).steps(23).run().expect("a path");
    assert!(path.last() == alone.last());
    let pairs = || run().paths(PATHS + 1).antithetic().observe("q", |state| state.q[3]);
    assert!(pairs().run().expect("pairs") == pairs().run_in::<4>().expect("pairs"));
}
