//! Truncated increments keep implicit steps from their poles below a step size that has a closed form; longer steps are refused.

use wzvi::error::{ConfigError, Error};
use wzvi::noise::Truncation;
use wzvi::prelude::*;

#[hamiltonian(
    drift = |q, p| 0.5 * a * (q * q + p * p),
    noise = [|q, p| s * q * p],
    embedding = [Midpoint, Gauss<2>, Gauss<3>, Verlet],
)]
#[derive(Clone)]
struct Squeezed {
    a: f64,
    s: f64,
}

#[hamiltonian(drift = |q, p| 0.5 * q * q, noise = [|q, p| 0.5 * s * (q * q + p * p)], embedding = Midpoint)]
struct Turned {
    s: f64,
}

/// Noises of momenta times coordinates with any matrix between them.
#[hamiltonian(
    drift = |[_x, _y], [px, py]| 0.5 * a * (px * px + py * py),
    noise = [|[x, y], [px, py]| m[0] * x * px + m[1] * x * py + m[2] * y * px + m[3] * y * py],
    embedding = Midpoint,
)]
struct Mixing {
    a: f64,
    m: [f64; 4],
}

/// In loops: a noise at each site, each with an intensity of its own.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| p.iter().map(|p| 0.5 * p * p).sum::<f64>() + 0.0 * q[0],
    noise = [|q, p, k| s[k] * q[k] * p[k]; self.s.len()],
    embedding = Midpoint,
)]
struct Sites {
    s: Vec<f64>,
}

/// The largest step that the error names; `None` if the run is accepted.
fn largest<H: Discretized<E> + Sync, E>(system: &H, start: &State<H::Vector>, h: f64) -> Option<f64> {
    let run = |h: f64| {
        system.ensemble::<E>(h).start(start.clone()).paths(4).seed(3).steps(2).allow_losses(1.0).run()
    };
    match run(h) {
        Ok(_) => None,
        Err(Error::Config(ConfigError::Pole { h: asked, increment, bound, largest, .. })) => {
            assert!(asked == h && increment <= bound);
            // The message is obeyed, in the digits that it prints; a step a percent longer is refused.
            let words = run(h).unwrap_err().to_string();
            let named: f64 = words.rsplit(' ').next().unwrap().parse().unwrap();
            assert!(run(named).is_ok() && run(1.01 * named).is_err(), "{words}");
            assert_eq!(named, largest);
            Some(largest)
        }
        Err(error) => panic!("{error}"),
    }
}

fn named(found: Option<f64>, exact: f64) {
    // Three digits, rounded down.
    assert!(found.is_some_and(|found| found <= exact && found > 0.989 * exact), "{found:?} {exact}");
}

#[test]
fn steps_that_reach_a_pole_are_refused_by_its_closed_form() {
    let start = State::new([1.0], [0.0]);
    let free = |s| Squeezed { a: 0.0, s };
    // 6 √h s/2 = 1
    for s in [1.0, -1.0, 2.0, 0.3] {
        named(largest::<_, Midpoint>(&free(s), &start, 5.0 / (s * s)), 1.0 / (9.0 * s * s));
        named(largest::<_, Verlet>(&free(s), &start, 0.25 / (s * s)), 1.0 / (9.0 * s * s));
    }
    assert_eq!(largest::<_, Midpoint>(&free(1.0), &start, 0.11), None);
    named(largest::<_, Midpoint>(&free(1.0), &start, 0.112), 1.0 / 9.0);
    named(largest::<_, Midpoint>(&free(1.0), &State::new([0.0], [0.0]), 0.25), 1.0 / 9.0);
    // The middle step of Yoshida's composition is 1.7024 times as long, backwards.
    let longest = 2f64.cbrt() / (2.0 - 2f64.cbrt());
    named(
        largest::<_, Composed<Midpoint, Yoshida4>>(&free(1.0), &start, 0.2),
        1.0 / (9.0 * longest * longest),
    );
    named(largest::<_, Gauss<3>>(&free(1.0), &start, 0.9), (4.644_370_709_252_171_f64 / 6.0).powi(2));
    assert_eq!(largest::<_, Gauss<2>>(&free(1.0), &start, 1.0), None);
    // Rotations have no pole.
    assert_eq!(largest::<_, Midpoint>(&Turned { s: 5.0 }, &start, 1.0), None);
    // A stiff oscillator moves the pole to ±2 √(1 + x²)/s, x = a h/2.
    assert_eq!(largest::<_, Midpoint>(&Squeezed { a: 40.0, s: 1.0 }, &start, 0.25), None);
    assert!(largest::<_, Midpoint>(&Squeezed { a: 1.0, s: 1.0 }, &start, 0.25).is_some());
}

#[test]
fn poles_are_those_of_the_matrix_of_a_noise() {
    let start = State::new([1.0, 0.5], [0.0, 0.2]);
    let of = |m| largest::<_, Midpoint>(&Mixing { a: 0.0, m }, &start, 0.5);
    // Eigenvalues 2 and 1; 3 and -1; none that is real; zero twice.
    named(of([1.0, 0.0, 0.0, 2.0]), 1.0 / 36.0);
    named(of([1.0, 2.0, 2.0, 1.0]), 1.0 / 81.0);
    assert_eq!(of([0.0, 1.0, -1.0, 0.0]), None);
    assert_eq!(of([0.0, 1.0, 0.0, 0.0]), None);
    for sites in [3, 40] {
        let mut s = vec![0.1; sites];
        s[sites - 2] = 1.5;
        let start = State::new(vec![1.0; sites], vec![0.3; sites]);
        named(largest::<_, Midpoint>(&Sites { s }, &start, 0.2), 1.0 / (9.0 * 2.25));
    }
}

#[test]
fn every_noise_of_a_run_is_checked_unless_it_is_not_truncated() {
    let (system, start) = (Squeezed { a: 0.0, s: 1.0 }, State::new([1.0], [0.0]));
    fn refused<T>(found: Result<T, Error>) -> bool {
        matches!(found, Err(Error::Config(ConfigError::Pole { .. })))
    }
    let run = || system.simulate::<Midpoint>(0.25).start(start).until(1.0);
    assert!(refused(run().noise(StepNormals::seed(1)).run()) && refused(run().noise(Wiener::seed(1)).run()));
    assert!(refused(run().noise(WongZakai::averaged(0.25).seed(1)).run()));
    assert!(refused(run().noise(Wiener::seed(1)).tangent()));
    run().noise(Wiener::seed(1).untruncated()).run().unwrap();
    run().noise(Increments::from(vec![[0.3]; 4])).run().unwrap();
    let without_noise = || system.ensemble::<Midpoint>(0.25).start(start).paths(16).until(1.0);
    let many = || without_noise().seed(1);
    assert!(refused(many().run()) && refused(without_noise().noise(Wiener::seed(1)).run()));
    assert!(refused(many().truncation(Truncation::On(2.0)).run()));
    many().truncation(Truncation::Off).run().unwrap();
    let sweep = [0.1, 1.0].map(|s| Squeezed { a: 0.0, s });
    let error = many().systems_from(sweep).paths(2).run().unwrap_err().to_string();
    assert!(error.contains("path 1") && error.contains("at most"), "{error}");
    let levels = |h: f64| {
        system.multilevel::<Midpoint>(h).start(start).seed(1).until(1.0).observe("q", |state| state.q[0])
    };
    assert!(refused(levels(0.25).target(0.05).run()));
}
