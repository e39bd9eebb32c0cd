//! A checkpoint of another run is refused, by the name of what differs.

use std::path::Path;

use wzvi::checkpoint::Checkpoint;
use wzvi::increments::NoNoise;
use wzvi::prelude::*;
use wzvi::simulate::Simulation;

use super::systems::{KEPLER, Kepler, PENDULUM, Pendulum};
use fixtures::files::{differences, refused};
use fixtures::folder;

/// The fields that differ.
fn fields<H: Discretized<E>, E, N: Noise>(file: &Path, run: Simulation<'_, H, E, N>) -> Vec<String> {
    differences(file, |to| run.checkpoint(to).run())
}

#[test]
fn a_deterministic_run() {
    let file = folder!("other").join("run");
    KEPLER.run(10, 0).checkpoint(Checkpoint::to(&file)).run().unwrap();
    let base = || KEPLER.run(20, 0);
    let start = Kepler::start;

    assert_eq!(fields(&file, base().record_every(2)), ["record_every"]);
    assert_eq!(fields(&file, base().start(start().at(0.5))), ["t of the start"]);
    let mut moved = start();
    moved.q[1] = -0.0;
    moved.p[0] = 1e-300;
    assert_eq!(fields(&file, base().start(moved)), ["q[1] of the start", "p[0] of the start"]);

    let stepped = KEPLER.simulate::<Midpoint>(0.01_f64.next_up()).start(start()).steps(20).record_every(0);
    assert_eq!(fields(&file, stepped), ["the step size"]);
    let scheme = KEPLER.simulate::<DeltaPlus>(0.01).start(start()).steps(20).record_every(0);
    assert!(fields(&file, scheme).contains(&"the scheme".to_owned()));
    let heavy = Kepler { mass: 1.0_f64.next_up() };
    assert_eq!(fields(&file, heavy.run(20, 0)), ["the parameter mass"]);
    let system = PENDULUM.run(Wiener::seed(1), 20, 0);
    assert!(fields(&file, system).contains(&"the system".to_owned()));

    // It says both values.
    let error = refused(heavy.run(20, 0).checkpoint(Checkpoint::to(&file)).run()).to_string();
    assert!(error.contains("the parameter mass is 1.0 there and 1.0000000000000002 here"), "{error}");
}

#[test]
fn a_noise() {
    let folder = folder!("other-noise");
    let file = folder.join("wiener");
    let base = || Wiener::seed(7).path(2);
    PENDULUM.run(base(), 10, 0).checkpoint(Checkpoint::to(&file)).run().unwrap();
    let run = |noise: Wiener| fields(&file, PENDULUM.run(noise, 20, 0));
    assert_eq!(run(Wiener::seed(8).path(2)), ["noise seed"]);
    assert_eq!(run(base().path(3)), ["noise path"]);
    assert_eq!(run(base().unit(0.02)), ["noise unit"]);
    assert_eq!(run(base().untruncated()), ["noise truncation"]);
    assert_eq!(run(base().truncated(2)), ["noise truncation"]);
    let averaged = WongZakai::of(base(), 0.02);
    assert_eq!(
        fields(&file, PENDULUM.run(averaged.clone(), 20, 0)),
        ["noise", "noise eps", "noise sampling"]
    );
    let other = Pendulum { sigma: 0.31, ..PENDULUM };
    assert_eq!(fields(&file, other.run(base(), 20, 0)), ["the parameter sigma"]);
    // What the run would choose itself is the same run.
    assert!(PENDULUM.run(base().truncated(4), 20, 0).checkpoint(Checkpoint::to(&file)).run().is_ok());

    let file = folder.join("averaged");
    PENDULUM.run(averaged.clone(), 10, 0).checkpoint(Checkpoint::to(&file)).run().unwrap();
    let run = |noise: WongZakai| fields(&file, PENDULUM.run(noise, 20, 0));
    assert_eq!(run(WongZakai::of(base(), 0.04)), ["noise eps"]);
    assert_eq!(run(averaged.clone().centred()), ["noise sampling"]);
    assert_eq!(run(averaged.seed(1)), ["noise seed"]);

    let file = folder.join("given");
    let rows = |last: f64| Increments::from(vec![[0.1, 0.2], [0.3, last]]);
    PENDULUM.run(rows(0.0), 1, 0).checkpoint(Checkpoint::to(&file)).run().unwrap();
    assert_eq!(fields(&file, PENDULUM.run(rows(-0.0), 2, 0)), ["noise checksum"]);
    let silent = KEPLER.run(2, 0).noise(NoNoise);
    assert!(fields(&file, silent).contains(&"the number of noises".to_owned()));
}

mod other {
    use super::*;

    /// The name of another system, with other equations.
    #[hamiltonian(
        drift = |[x, y], [px, py]| (px * px + py * py) / (2.0 * mass) - 1.0 / x.hypot(y).powi(2),
        embedding = Midpoint,
    )]
    pub(super) struct Kepler {
        pub(super) mass: f64,
    }
}

/// Same name, same parameters, same start: the equations tell them apart.
#[test]
fn another_hamiltonian_of_the_same_name() {
    let file = folder!("other-hamiltonian").join("run");
    KEPLER.run(10, 0).checkpoint(Checkpoint::to(&file)).run().unwrap();
    let other = other::Kepler { mass: 1.0 };
    let run = other.simulate::<Midpoint>(0.01).start(Kepler::start()).steps(20).record_every(0);
    let fields = fields(&file, run);
    assert!(fields.contains(&"the derivation (checksum)".to_owned()), "{fields:?}");
    assert!(fields.iter().all(|field| field.ends_with("(checksum)")), "{fields:?}");
}
