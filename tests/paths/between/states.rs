//! States of a recorded path at any time, after the run.

use fixtures::bath;
use wzvi::error::PathError;
use wzvi::prelude::*;

use super::systems::{Oscillator, Shaken, V1, start};

/// `dp = dW`: the state at `t` has the path itself.
#[hamiltonian(drift = |q, p| 0.5 * p * p, noise = [|q, p| -q], embedding = Midpoint)]
struct Free;

fn refusal<T>(outcome: Result<T, wzvi::Error>) -> String {
    outcome.err().expect("an error").to_string()
}

/// Between nodes, at nodes, in a last step that is shorter, and backwards: to the accuracy of `Gauss<8>`, of some roundings.
#[test]
fn any_time_of_a_path_has_its_state() {
    for (h, end) in [(0.1, 2.0), (0.1, 2.05), (-0.1, -1.03), (0.7, 0.3)] {
        let path = Oscillator.simulate::<Gauss<8>>(h).start(start()).until(end).run().unwrap();
        for i in 0..=57 {
            let t = end * f64::from(i) / 57.0;
            let state = path.state_at(&Oscillator, t).unwrap();
            assert!((state.q[0] - t.cos()).abs() < 1e-14 && (state.p[0] + t.sin()).abs() < 1e-14, "{h} {t}");
        }
        for node in &path {
            assert_eq!(path.state_at(&Oscillator, node.t).unwrap(), *node);
        }
    }
}

/// The error inside of steps falls with the order of the scheme: by 4 and by 16 from one step size to half of it, up to a fifth.
#[test]
fn states_have_the_order_of_the_scheme() {
    fn error<E>(h: f64) -> f64
    where
        Oscillator: Discretized<E, Vector = V1>,
    {
        let path = Oscillator.simulate::<E>(h).start(start()).until(3.0).run().unwrap();
        let times = (0..100).map(|i| 0.03 * f64::from(i) + 0.003);
        times.map(|t| (path.state_at(&Oscillator, t).unwrap().q[0] - t.cos()).abs()).fold(0.0, f64::max)
    }
    let verlet = error::<Verlet>(0.1) / error::<Verlet>(0.05);
    let yoshida = error::<Composed<Verlet, Yoshida4>>(0.1) / error::<Composed<Verlet, Yoshida4>>(0.05);
    assert!((3.2..5.0).contains(&verlet) && (12.8..20.0).contains(&yoshida), "{verlet} {yoshida}");
}

#[test]
fn what_was_not_recorded_or_is_not_on_the_path_is_an_error() {
    let run = || Oscillator.simulate::<Gauss<8>>(0.1).start(start()).until(2.05);
    let path = run().record_every(5).run().unwrap();
    let Err(wzvi::Error::Path(error)) = path.state_at(&Oscillator, 0.33) else { panic!("an error") };
    assert_eq!(error, PathError::Unrecorded { t: 0.33, every: 5 });
    assert!(
        error.to_string().contains("`record_every(1)`") && error.to_string().contains("`record_at([0.33])`")
    );
    // Its remedies work, and after a recorded node there is a state.
    assert!((path.state_at(&Oscillator, 0.53).unwrap().q[0] - 0.53_f64.cos()).abs() < 1e-14);
    assert!(run().record_every(1).run().unwrap().state_at(&Oscillator, 0.33).is_ok());
    let chosen = run().record_at([0.33]).run().unwrap();
    assert!(chosen.states().iter().any(|state| state.t == 0.33));
    assert!(chosen.state_at(&Oscillator, 0.37).is_err());
    assert!(chosen.state_at(&Oscillator, 0.07).is_ok());
    // Beside all nodes, states between them are no nodes.
    let both = run().record_at([0.33, 0.36]).record_every(1).run().unwrap();
    assert!((both.state_at(&Oscillator, 0.35).unwrap().q[0] - 0.35_f64.cos()).abs() < 1e-14);
    for t in [-0.01, 2.06, f64::NAN, f64::INFINITY] {
        let outcome = both.state_at(&Oscillator, t);
        assert!(matches!(outcome, Err(wzvi::Error::Path(PathError::Outside { end: 2.05, .. }))), "{t}");
    }
    assert!(both.state_at(&Oscillator, 2.05).is_ok());
}

/// With the source of the run again, states are on its path.
#[test]
fn states_are_on_the_path_of_the_noise() {
    let at_rest = State::new([0.0], [0.0]);
    let run = || Free.simulate::<Midpoint>(0.1).start(at_rest).until(2.03);
    let path = run().noise(Wiener::seed(3)).run().unwrap();
    for i in 0..=57 {
        let t = 2.03 * f64::from(i) / 57.0;
        let state = path.at(&Free).noise(Wiener::seed(3)).state(t).unwrap();
        assert!((state.p[0] - Wiener::seed(3).value(0, t).unwrap()).abs() < 1e-13, "{t}");
    }
    // Normals of steps have the law of the bridge, in steps of both sizes: mean squares of 2000 are known to √(2/2000), products to √(1/2000); four
    // such deviations. Three times are on one path: what two of them add is not correlated.
    for (from, to, t) in [(0.1, 0.2, 0.137), (2.0, 2.03, 2.011)] {
        let (paths, theta) = (2000, (t - from) / (to - from));
        let (mut square, mut product) = (0.0, 0.0);
        for path in 0..paths {
            let noise = || StepNormals::seed(1).path(path);
            let recorded = run().noise(noise()).run().unwrap();
            let p = |t: f64| recorded.at(&Free).noise(noise()).state(t).unwrap().p[0];
            let (first, second) = (p(t) - p(from), p(to) - p(t));
            let off = first - theta * (first + second);
            square += off * off;
            product += first * second;
        }
        let (paths, variance) = (paths as f64, (to - from) * theta * (1.0 - theta));
        assert!((square / paths / variance - 1.0).abs() < 4.0 * (2.0 / paths).sqrt(), "{square}");
        assert!(
            (product / paths / variance.sqrt() / (to - from).sqrt()).abs() < 4.0 / paths.sqrt(),
            "{product}"
        );
    }
}

/// Next to a node, a state is next to that node, with a heat bath as well: increments inside a step end with those of the step. The distance over
/// `1e-12` of a step is that of a Wiener path, `1e-6`.
#[test]
fn states_go_over_into_nodes() {
    let bath = bath::Oscillator { m: 0.8, k: 1.3, b: 0.4, gamma: 0.6, kt: 0.7 };
    let noise = || StepNormals::seed(5);
    let path = bath.simulate::<Obabo>(0.1).start(start()).until(1.0).noise(noise()).run().unwrap();
    let before = path.at(&bath).noise(noise()).state(0.3 - 1e-13).unwrap();
    assert!((before.q - path.states()[3].q).norm() < 1e-5 && (before.p - path.states()[3].p).norm() < 1e-5);
    let averaged = || WongZakai::averaged(0.1).exact().seed(5);
    let path = Shaken.simulate::<Midpoint>(0.1).start(start()).until(1.0).noise(averaged()).run().unwrap();
    let before = path.at(&Shaken).noise(averaged()).state(0.3 - 1e-9).unwrap();
    assert!((before.q - path.states()[3].q).norm() < 1e-7);
    // Of a path of an ensemble, by its noise.
    let many = Shaken.ensemble::<Midpoint>(0.1).start(start()).paths(4).seed(7).until(1.0).record_every(1);
    let (path, _) = many.replay(2).unwrap();
    assert!(path.at(&Shaken).noise(StepNormals::seed(7).path(2)).state(0.55).is_ok());
    assert!(
        refusal(path.at(&Shaken).noise(StepNormals::seed(7).path(3)).state(0.55)).contains("did not drive")
    );
}

#[test]
fn noises_that_cannot_be_asked_are_errors() {
    let run = || Shaken.simulate::<Midpoint>(0.1).start(start()).steps(5);
    let given = || Increments::from(vec![[0.1, -0.2]; 5]);
    let path = run().noise(given()).run().unwrap();
    assert!(refusal(path.state_at(&Shaken, 0.33)).contains("`path.at(&system).noise(source).state(t)`"));
    let words = refusal(path.at(&Shaken).noise(given()).state(0.33));
    assert!(words.contains("no increments inside of a step") && words.contains("record_at"), "{words}");
    assert!(refusal(path.at(&Shaken).noise(Wiener::seed(1)).state(0.33)).contains("did not drive the path"));
    assert!(path.at(&Shaken).state(0.3).is_ok());
    // Free has one noise less.
    let error = path.at(&Free).noise(given()).state(0.33);
    assert!(matches!(error, Err(wzvi::Error::Path(PathError::System { .. }))));
}
