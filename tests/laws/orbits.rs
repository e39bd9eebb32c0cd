//! A step that is far too long for a close passage of three bodies: a run whose energy has changed, and stays changed, is no result.

use wzvi::error::StepFailure;
use wzvi::prelude::*;

/// The planar restricted problem of three bodies, in the rotating frame, with the small body to the left.
#[hamiltonian(
    drift = |[x, y], [px, py]| {
        let (large, small) = ((x - mu).hypot(y), (x + 1.0 - mu).hypot(y));
        0.5 * (px * px + py * py) + y * px - x * py - (1.0 - mu) / large - mu / small
    },
    embedding = Gauss<8>,
)]
struct ThreeBodies {
    mu: f64,
}

#[test]
fn a_close_passage_of_the_small_body_is_refused() {
    let system = ThreeBodies { mu: 0.01 };
    let start = State::new([-0.8, 0.0], [0.0, -0.627_641_065_392_069_4]);
    let energy = system.energy(&start);
    // The orbit is chaotic: it passes at 0.01 to 0.03 from time to time, where a step of 0.2 is short enough.
    for (h, is_refused) in [(0.2, false), (0.25, true), (0.35, true)] {
        let run = || system.simulate::<Gauss<8>>(h).start(start).steps(1000);
        let path = run().unwatched().run().unwrap();
        let off = (system.energy(path.last()) - energy).abs();
        let refused = match run().run() {
            Ok(_) => None,
            Err(wzvi::Error::Step(error)) if matches!(error.cause, StepFailure::Unresolved { .. }) => {
                Some(error)
            }
            Err(error) => panic!("{error}"),
        };
        println!("h = {h}: off by {off:.1e}; {refused:?}");
        // The mean of `p · dq/dt` is of the size of one.
        assert_eq!((off > 1.0, refused.is_some()), (is_refused, is_refused), "h = {h}");
    }
}
