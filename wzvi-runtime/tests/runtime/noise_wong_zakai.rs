//! Wong-Zakai increments against the path that they approximate.

use wzvi_runtime::increments::Identity;
use wzvi_runtime::noise::{Interval, Noise, Sampling, Truncation, Wiener, WongZakai};
use wzvi_runtime::scheme::plan::{Knowledge, NoiseClass, Plan, Solver};

const KINDS: [Sampling; 5] =
    [Sampling::Left, Sampling::Centred, Sampling::Literal, Sampling::Exact, Sampling::ExactCentred];

fn increment(noise: &mut impl Noise, start: f64, h: f64, step: u64) -> [f64; 2] {
    let mut dw = [0.0; 2];
    noise.increments(&Interval { start, h, step }, &mut dw).unwrap();
    dw
}

/// For h = eps the left and the centred increments are those of the path, bit by bit, also truncated and at odd step sizes.
#[test]
fn window_of_one_step_is_the_path() {
    for h in [0.02, 1.0 / 128.0, 1.0 / 3.0, 0.031_415_926_535] {
        let mut wiener = Wiener::seed(7).truncated(1);
        let mut left = WongZakai::averaged(h).seed(7).truncated(1);
        let mut centred = WongZakai::averaged(h).seed(7).centred().truncated(1);
        for start in [0.0, -2.0] {
            for step in 0..1000 {
                let expected = increment(&mut wiener, start, h, step);
                assert_eq!(expected, increment(&mut left, start, h, step));
                assert_eq!(expected, increment(&mut centred, start, h, step));
            }
        }
    }
}

/// Against the definitions, evaluated directly on the path.
#[test]
fn increments_follow_their_definitions() {
    let h = 0.02;
    for eps in [0.005, 0.02, 0.03, 0.1, 1.0] {
        for kind in KINDS {
            let mut noise = WongZakai::averaged(eps).seed(7).sampling(kind);
            let mut path = Wiener::seed(7);
            let mut smooth = noise.clone();
            for step in 0..200 {
                let t = step as f64 * h - 1.0;
                let got = increment(&mut noise, -1.0, h, step);
                for (process, got) in got.into_iter().enumerate() {
                    let mut window = |a: f64| h / eps * path.increment(process, a, a + eps).unwrap();
                    let expected = match kind {
                        Sampling::Left => window(t),
                        Sampling::Centred => window(t + h / 2.0 - eps / 2.0),
                        Sampling::Literal => window(t + h / 2.0),
                        Sampling::Exact | Sampling::ExactCentred => {
                            smooth.value(process, t + h).unwrap() - smooth.value(process, t).unwrap()
                        }
                    };
                    assert!((got - expected).abs() < 1e-13, "{kind:?} {eps} {step}: {got} {expected}");
                }
            }
        }
    }
}

/// Exact increments telescope, whatever the step, and velocities integrate to them.
#[test]
fn exact_increments_telescope() {
    for kind in [Sampling::Exact, Sampling::ExactCentred] {
        let mut noise = WongZakai::averaged(0.05).seed(3).sampling(kind);
        let whole = noise.value(0, 2.0).unwrap() - noise.value(0, 0.0).unwrap();
        for h in [0.02, 0.1, 0.0625, 0.5] {
            let sum: f64 = (0..(2.0 / h) as u64).map(|step| increment(&mut noise, 0.0, h, step)[0]).sum();
            assert!((sum - whole).abs() < 1e-12, "{kind:?} {h}: {sum} {whole}");
        }
        // The velocity is a Brownian increment over eps: the mid-point rule with width d has error ~ sqrt(d^2 / 6 eps^2 * n) d ... small.
        let n = 4000;
        let d = 2.0 / f64::from(n);
        let sum: f64 = (0..n).map(|i| d * noise.velocity(0, (f64::from(i) + 0.5) * d).unwrap()).sum();
        assert!((sum - whole).abs() < 2e-2, "{kind:?}: {sum} {whole}");
    }
}

/// What a compiler would say of an implicit scheme with multiplicative noise.
pub(crate) const IMPLICIT: Plan = Plan {
    solver: Solver::Newton,
    order: 2,
    unknowns: 1,
    noise: NoiseClass::Multiplicative,
    consistent: true,
    conserves_energy: Knowledge::Unknown,
    energy_jumps: false,
    commuting: Knowledge::Proven,
    has_weak_order_two: false,
    is_out_of_equilibrium: false,
};

/// What acts in a run is in the identity of the source; what the user has set stays.
#[test]
fn a_run_may_truncate_unless_told_otherwise() {
    fn acting<N: Noise>(mut noise: N) -> Option<Identity> {
        noise.prepare(&IMPLICIT, 0.02, 1, 0.0).unwrap();
        noise.identity()
    }
    let averaged = || WongZakai::averaged(0.02);
    assert_eq!(acting(averaged()), acting(averaged().truncated(4)));
    assert_eq!(acting(averaged().untruncated()), averaged().untruncated().identity());
    assert_eq!(acting(averaged().truncated(2)), averaged().truncated(2).identity());
    assert_ne!(acting(averaged()), acting(averaged().untruncated()));
    let wiener = || Wiener::seed(1);
    assert_eq!(acting(wiener()), acting(wiener().truncated(4)));
    assert_eq!(acting(wiener().untruncated()), wiener().untruncated().identity());
    assert_eq!(acting(wiener().truncated(2.5)), wiener().truncated(2.5).identity());
    let mut noise = wiener();
    noise.prepare(&IMPLICIT, 0.02, 1, 0.0).unwrap();
    assert_eq!(noise.truncation(), Truncation::Unset);
}

/// Settings in any order give the same noise.
#[test]
fn the_order_of_settings_does_not_matter() {
    let mut noises = [
        WongZakai::averaged(0.05).seed(7).path(3).centred().truncated(2).unit(0.1),
        WongZakai::averaged(0.05).unit(0.1).truncated(2).centred().path(3).seed(7),
        WongZakai::of(Wiener::seed(7).path(3).truncated(2).unit(0.1), 0.05).centred(),
    ];
    let values = noises.each_mut().map(|noise| increment(noise, 0.3, 0.02, 5));
    assert_eq!(values[0], values[1]);
    assert_eq!(values[0], values[2]);
}
