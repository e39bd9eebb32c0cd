//! Heat through harmonic chains whose ends are in baths at two temperatures.

use wzvi::prelude::*;

/// A chain with fixed ends and friction 1 at the first and the last site, at the temperatures 2 and 1/2.
#[hamiltonian(
    drift = |q: [f64; N], p: [f64; N]| {
        p.iter().map(|p| 0.5 * p * p).sum::<f64>()
            + 0.5 * q[0] * q[0]
            + 0.5 * q[N - 1] * q[N - 1]
            + (1..N).map(|i| 0.5 * (q[i] - q[i - 1]).powi(2)).sum::<f64>()
    },
    friction = (0..N).map(|i| if i == 0 || i == N - 1 { 1.0 } else { 0.0 }),
    temperature = [|i| if i == 0 { 2.0 } else { 0.5 }; N],
    embedding = Baoab,
)]
struct BetweenBaths<const N: usize>;

/// Compares the flux from left to right and the kinetic temperatures with those of Lyapunov's equation of the covariances, `A C + C Aᵀ + D = 0`.
fn check<const N: usize>(flux: f64, temperatures: [f64; N]) {
    assert!(<BetweenBaths<N> as Discretized<Baoab>>::PLAN.is_out_of_equilibrium);
    let run = BetweenBaths::<N>.ensemble::<Baoab>(0.05).start(State::new([0.0; N], [0.0; N]));
    let mut run = run
        .paths(20_000)
        .seed(1)
        .observe("flux", |state| -0.5 * (state.q[1] - state.q[0]) * (state.p[0] + state.p[1]));
    for i in 0..N {
        run = run.observe(format!("temperature {i}"), move |state| state.p[i] * state.p[i]);
    }
    // The slowest covariance has forgotten the start: its rate is 1 for two sites and 0.19 for four, and e^(-11) of it is left.
    let statistics = run.until(60.0).quiet().run().unwrap();
    // The step moves stationary covariances by about h²/12 = 2e-4, a twentieth of the errors here.
    let check = |name: &str, exact: f64| {
        let (mean, error) = (statistics.mean(name).unwrap(), statistics.standard_error(name).unwrap());
        assert!((mean - exact).abs() < 4.0 * error, "{name}: {mean} ± {error}, exactly {exact}");
    };
    check("flux", flux);
    for (i, temperature) in temperatures.into_iter().enumerate() {
        check(&format!("temperature {i}"), temperature);
    }
    heat_of_baths::<N>(flux);
}

/// The heat of both baths between two times when the start is forgotten, in units of time: the flux, and minus
/// that.
fn heat_of_baths<const N: usize>(flux: f64) {
    let run = BetweenBaths::<N>.ensemble::<Baoab>(0.05).start(State::new([0.0; N], [0.0; N]));
    let run = run.paths(600).seed(2).until(460.0).record_at([60.0]).observe_work().quiet();
    let statistics = run.run().unwrap();
    let [_, early, late] = statistics.nodes() else { panic!("the start, and two times") };
    let heat = |i: usize| {
        let place = statistics.index(&format!("heat {i}")).unwrap();
        // Heats of separate times are hardly correlated, so that the error of the later one is that of the
        // difference, or more.
        ((late.mean(place) - early.mean(place)) / 400.0, late.standard_error(place) / 400.0)
    };
    for ((heat, error), exact) in [(heat(0), flux), (heat(N - 1), -flux)] {
        assert!(
            (heat - exact).abs() < 4.0 * error && error < 0.05 * flux,
            "{heat} ± {error}, exactly {exact}"
        );
    }
    for i in 1..N - 1 {
        assert_eq!(heat(i).0, 0.0);
    }
}

#[test]
fn heat_flows_through_two_sites() {
    check(0.25, [1.75, 0.75]);
}

#[test]
fn heat_flows_through_four_sites() {
    check(2.0 / 7.0, [12.0 / 7.0, 17.0 / 14.0, 9.0 / 7.0, 11.0 / 14.0]);
}
