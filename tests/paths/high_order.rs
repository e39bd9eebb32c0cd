//! What schemes of high order promise, for one of each kind of step: what is kept, what is at rest, steps in halves.

use fixtures::larger;
use wzvi::nalgebra::SVector;
use wzvi::prelude::*;

/// A star in a galaxy: separable, so that all compositions take it, and symmetric.
#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) + 0.5 * (x * x + y * y + core).ln(),
    invariant = [|[x, y], [px, py]| x * py - y * px],
    embedding = [Midpoint, Verlet, Gauss<8>],
)]
struct Galaxy {
    core: f64,
}

/// A particle in a well before a wall: beyond it there is no force.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.5 * q * q + 0.1 / (1.0 - q).sqrt(),
    embedding = [Midpoint, Verlet, Gauss<8>],
)]
struct Walled;

/// Calls a generic function for one scheme of each kind of step.
macro_rules! every_kind {
    ($check:ident) => {
        $check::<Gauss<8>>("Gauss<8>");
        $check::<Composed<Midpoint, Yoshida4>>("Composed<Midpoint, Yoshida4>");
        $check::<Composed<Verlet, KahanLi8>>("Composed<Verlet, KahanLi8>");
        $check::<Composed<Verlet, Aba864>>("Composed<Verlet, Aba864>");
        $check::<Composed<Verlet, Chin4>>("Composed<Verlet, Chin4>");
    };
}

const GALAXY: Galaxy = Galaxy { core: 0.1 };

/// Angular momentum is quadratic, and the potential symmetric: only rounding moves it. A step rounds at most 40 times terms below 2, a walk.
#[test]
fn angular_momentum_is_kept_to_rounding() {
    fn check<E>(scheme: &str)
    where
        Galaxy: Discretized<E, Vector = SVector<f64, 2>>,
    {
        let momentum = |state: &State<SVector<f64, 2>>| state.q[0] * state.p[1] - state.q[1] * state.p[0];
        let mut state = State::new([1.0, 0.0], [0.1, 0.6]);
        let start = momentum(&state);
        let mut stepper = GALAXY.stepper::<E>(0.1).unwrap();
        let (mut worst, steps) = (0.0_f64, 2000);
        for _ in 0..steps {
            stepper.step(&mut state, &[]).unwrap();
            worst = larger(worst, (momentum(&state) - start).abs());
        }
        let walk = 2.0 * f64::EPSILON * (40.0 * f64::from(steps)).sqrt();
        assert!(worst < walk, "{scheme}: {worst:.1e}, {walk:.1e}");
    }
    every_kind!(check);
}

/// Where force and momentum are zero, no scheme moves a bit.
#[test]
fn what_is_at_rest_stays_there() {
    fn check<E>(scheme: &str)
    where
        Galaxy: Discretized<E, Vector = SVector<f64, 2>>,
    {
        let rest = State::new([0.0, 0.0], [0.0, 0.0]);
        let mut state = rest;
        let mut stepper = GALAXY.stepper::<E>(0.1).unwrap();
        for _ in 0..1000 {
            stepper.step(&mut state, &[]).unwrap();
        }
        assert_eq!((state.q, state.p), (rest.q, rest.p), "{scheme}");
    }
    every_kind!(check);
}

/// A step that ends behind the wall is halved until none does and the halves agree, and those parts are steps of that size.
#[test]
fn steps_are_halved_where_they_fail() {
    fn check<E>(scheme: &str)
    where
        Walled: Discretized<E, Vector = SVector<f64, 1>>,
    {
        let start = State::new([0.5], [1.0]);
        // Steps of any size that have a solution are good.
        let fails = |h: &f64| Walled.simulate::<E>(*h).start(start).steps(1).run().is_err();
        let Some(h) = [1.0, 1.5, 2.0, 3.0, 5.0].into_iter().find(fails) else {
            // Implicit steps of any of these sizes have one before the wall.
            assert!(scheme.starts_with("Composed<Midpoint") || scheme.contains("Gauss"), "{scheme}");
            return;
        };
        let halved =
            || Walled.simulate::<E>(h).start(start).steps(1).retry(Retry::halving(12)).run().unwrap();
        let solvable = (1..=12)
            .find(|&halvings| {
                let h = h / f64::from(1 << halvings);
                Walled.simulate::<E>(h).start(start).steps(1 << halvings).run().is_ok()
            })
            .unwrap();
        let whole = halved();
        let halvings = whole.iterations().halvings;
        assert!(halvings > solvable, "{scheme}: {halvings} {solvable}");
        let parts = Walled.simulate::<E>(h / f64::from(1 << halvings)).start(start).steps(1 << halvings);
        let parts = parts.run().unwrap();
        assert_eq!(
            (whole.last().q, whole.last().p),
            (parts.last().q, parts.last().p),
            "{scheme}, {halvings}"
        );
        assert_eq!(whole.iterations().halved, 1, "{scheme}");
    }
    every_kind!(check);
}
