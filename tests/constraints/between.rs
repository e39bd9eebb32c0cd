//! States between the nodes, and what is measured along paths: on the manifold, too.

use wzvi::prelude::*;
use wzvi::state::Vector;

use super::systems::{DoublePendulum, Sphere, WarmSphere};

fn double() -> State<<DoublePendulum as Hamiltonian>::Vector> {
    State::new([1.0, 0.0, 1.0, -1.0], [0.0, 1.0 / 6.0, 0.5, 1.0 / 3.0])
}

fn apart<V: Vector>(a: &State<V>, b: &State<V>) -> f64 {
    let halves = [(&a.q, &b.q), (&a.p, &b.p)];
    let all = halves.into_iter().flat_map(|(a, b)| a.components().iter().zip(b.components()));
    all.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Both constraints and their derivatives by the time.
fn off_manifold(state: &State<<DoublePendulum as Hamiltonian>::Vector>) -> f64 {
    let [x, y, u, v] = [0, 1, 2, 3].map(|i| state.q[i]);
    let [px, py, pu, pv] = [state.p[0], state.p[1], 0.5 * state.p[2], 0.5 * state.p[3]];
    let (r, s) = (u - x, v - y);
    let all = [x * x + y * y - 1.0, r * r + s * s - 1.0, x * px + y * py, r * (pu - px) + s * (pv - py)];
    all.into_iter().map(f64::abs).fold(0.0, f64::max)
}

/// The recorded states are those of the polynomial, whose error falls with the fourth power of the step, and
/// with the fifth for steps of order four: without the forces of the constraints it would fall with the
/// second.
#[test]
fn states_between_nodes_have_the_order_of_the_dense_output() {
    let fine = DoublePendulum.simulate::<Composed<Rattle, KahanLi6>>(1.0 / 256.0).start(double());
    let exact = fine.record_at([0.3]).until(1.0).run().unwrap();
    let error = |steps: u32| {
        // 0.3 is at the same fraction of a step, 0.2, for all of these.
        let h = 1.0 / f64::from(steps);
        let path = DoublePendulum
            .simulate::<Composed<Rattle, KahanLi6>>(h)
            .start(double())
            .record_at([0.3])
            .until(1.0)
            .run()
            .unwrap();
        let state = &path.states()[1];
        assert!((state.t - 0.3).abs() < 1e-15 && off_manifold(state) < 1e-14, "{}", off_manifold(state));
        let own = path.state_at(&DoublePendulum, path.last().t).unwrap();
        assert_eq!(apart(&own, path.last()), 0.0);
        apart(state, &exact.states()[1])
    };
    let [coarse, fine] = [14, 24].map(error);
    let order = (coarse / fine).ln() / (24.0_f64 / 14.0).ln();
    assert!(order > 6.0, "{order} {coarse:e} {fine:e}");
}

#[test]
fn states_at_any_time_are_on_the_manifold() {
    let path = DoublePendulum.simulate::<Rattle>(0.01).start(double()).until(2.0).run().unwrap();
    for t in [0.0033, 0.5, 1.2345, 1.999] {
        let state = path.state_at(&DoublePendulum, t).unwrap();
        assert!(off_manifold(&state) < 1e-14);
    }
}

#[test]
fn crossings_of_sections_are_on_the_manifold() {
    let run = DoublePendulum.simulate::<Rattle>(0.05).start(double()).section(|state| state.q[0] - 0.2);
    let path = run.until(30.0).run().unwrap();
    assert!(path.crossings().len() > 3, "{}", path.crossings().len());
    for crossing in path.crossings() {
        assert!(off_manifold(&crossing.state) < 1e-14);
        // The polynomial is of order four, and the state is moved to the manifold by no more.
        assert!((crossing.state.q[0] - 0.2).abs() < 1e-5, "{}", crossing.state.q[0] - 0.2);
    }
}

/// Deviations in the tangent plane: four of the double pendulum, whose exponents come in pairs.
#[test]
fn spectra_have_an_exponent_for_each_degree_that_is_left() {
    let run = DoublePendulum.simulate::<Rattle>(0.02).start(double()).until(100.0).copies(0);
    let spectrum = run.lyapunov().unwrap();
    assert_eq!(spectrum.values.len(), 4);
    // Volume in the tangent bundle is kept; lengths in the space around it change the logarithm of its measure by
    // a number of order one, over a time of 100.
    assert!(spectrum.sum().abs() < 0.02, "{}", spectrum.sum());
    assert!((spectrum.values[0] + spectrum.values[3]).abs() < 0.05, "{spectrum}");
    assert!(spectrum.pair_defect.unwrap() < 0.1 && spectrum.sum_defect.is_none());
    let sphere = Sphere { g: 1.0 };
    let start = State::new([0.6, 0.0, -0.8], [0.4, 0.7, 0.3]);
    let indicators = sphere.simulate::<Rattle>(0.05).start(start).until(400.0).indicators().unwrap();
    // The spherical pendulum is integrable: MEGNO goes to 2, and would grow by 0.5 λ t with an exponent λ.
    assert!((indicators.megno_mean - 2.0).abs() < 0.5, "{}", indicators.megno_mean);
}

/// Two degrees of freedom are left of three coordinates: the kinetic temperature is that of the bath, up to the
/// bias of order two of the steps (2 % at `h = 0.4`) and the error of the average.
#[test]
fn temperatures_count_the_degrees_of_freedom_that_are_left() {
    let system = WarmSphere { gamma: 1.0, kt: 0.5 };
    let path = system
        .simulate::<GBaoab>(0.2)
        .start(State::new([0.6, 0.0, -0.8], [0.4, 0.7, 0.3]))
        .noise(StepNormals::seed(5))
        .until(4000.0)
        .run()
        .unwrap();
    let shares = path.equipartition(&system);
    let found = shares.kinetic_temperature;
    assert!((found.temperature - 0.5).abs() < 0.01 + 4.0 * found.standard_error, "{shares}");
    assert!(shares.kinetic.is_empty());
}
