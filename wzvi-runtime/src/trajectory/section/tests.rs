use nalgebra::SVector;

use super::*;

type V1 = SVector<f64, 1>;

/// The crossings of a path with the value `f` at each time, in steps of one unit that are straight lines of
/// time.
fn crossings(f: impl Fn(f64) -> f64 + Send + Sync, steps: u32) -> Vec<(f64, Direction)> {
    let mut sections = Sections::default();
    sections.push(None, |state: &State<V1>| f(state.t));
    let state = |t: u32| State::new([0.0], [0.0]).at(f64::from(t));
    let mut watch = SectionWatch::new(sections.functions(), &state(0));
    let mut all = Vec::new();
    for step in 0..steps {
        let dense = DenseOutput::straight([state(step), state(step + 1)]);
        watch.follow(sections.functions(), &dense, &mut |crossing, _| {
            all.push((crossing.state.t, crossing.direction));
        });
    }
    all
}

#[test]
fn changes_of_sign_are_crossings() {
    use Direction::{Falling, Rising};
    let times = |f: fn(f64) -> f64| crossings(f, 4);
    assert_eq!(times(|t| t - 1.375), [(1.375, Rising)]);
    assert_eq!(times(|t| 1.25 - t), [(1.25, Falling)]);
    // At a node, once.
    assert_eq!(times(|t| t - 2.0), [(2.0, Rising)]);
    // At a start and an end on the section, not.
    assert_eq!(times(|t| t * (t - 4.0)), []);
    // Touched, at a node and inside.
    assert_eq!(times(|t| (t - 2.0) * (t - 2.0)), []);
    assert_eq!(times(|t| (t - 1.3) * (t - 1.3)), []);
    // Zero for a while: where it began.
    assert_eq!(
        times(|t| if t < 1.0 {
            -1.0
        } else if t < 2.0 {
            0.0
        } else {
            1.0
        }),
        [(1.0, Rising)]
    );
    assert_eq!(
        times(|t| if t < 1.0 {
            1.0
        } else if t < 2.0 {
            0.0
        } else {
            1.0
        }),
        []
    );
    // From nowhere there is no side.
    assert_eq!(times(|t| if (1.1..1.9).contains(&t) { f64::NAN } else { t - 1.5 }), []);
}

#[test]
fn several_crossings_in_a_step_are_found() {
    use Direction::{Falling, Rising};
    // Between two of four points of a step, at distances down to 1e-7.
    for distance in [0.2, 0.01, 1e-4, 1e-7] {
        for middle in [0.13, 0.3, 0.625, 0.93, 1.0, 1.02] {
            let found = crossings(move |t| (t - middle).powi(2) - (0.5 * distance) * (0.5 * distance), 3);
            assert_eq!(found.len(), 2, "{distance} around {middle}: {found:?}");
            assert_eq!([found[0].1, found[1].1], [Falling, Rising]);
            let gap = found[1].0 - found[0].0;
            // If the function is flat, rounding of its value moves its zero.
            assert!((gap - distance).abs() < 1e-14 / distance, "{distance} around {middle}: {gap}");
        }
    }
    // Three between the same two.
    let found = crossings(|t| (t - 0.55) * (t - 0.62) * (t - 0.7), 1);
    let [(first, Rising), (second, Falling), (third, Rising)] = found[..] else { panic!("{found:?}") };
    for (found, exact) in [(first, 0.55), (second, 0.62), (third, 0.7)] {
        assert!((found - exact).abs() < 1e-14, "{found} {exact}");
    }
    let found = crossings(|t| (std::f64::consts::TAU * t).sin() + 0.5, 2);
    assert_eq!(found.len(), 4, "{found:?}");
}
