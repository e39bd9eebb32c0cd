//! Ensembles between their nodes: the same as single paths, bit for bit.

use std::f64::consts::{FRAC_PI_2, PI};

use wzvi::checkpoint::Checkpoint;
use wzvi::dense::DenseOutput;
use wzvi::ensemble::Ensemble;
use wzvi::prelude::*;
use wzvi::section::Direction;

use super::systems::{Oscillator, Shaken, V1, start};

const TIMES: [f64; 4] = [0.03, 0.05, 0.3, 1.99];

fn shaken<E>(paths: u64) -> Ensemble<'static, Shaken, E>
where
    Shaken: Discretized<E>,
{
    Shaken
        .ensemble::<E>(0.1)
        .start(start())
        .paths(paths)
        .seed(7)
        .until(4.25)
        .record_at(TIMES)
        .observe("q", |state| state.q[0])
        .observe("p", |state| state.p[0])
        .observe("t", |state| state.t)
        .section(|state| state.q[0])
        .section_towards(Direction::Rising, |state| state.p[0] - 0.1)
        .keep_crossings(3)
        .keep_paths(1 << 24)
}

/// A path by hand: plain sums, the increments of an ensemble, dense output. States at the recorded times and at the end.
fn by_hand<E>(path: u64) -> Vec<State<V1>>
where
    Shaken: Discretized<E, Vector = V1>,
{
    let mut noise = StepNormals::seed(7).path(path);
    let plan = &<Shaken as Discretized<E>>::PLAN;
    noise.prepare(plan, 0.1, 2, 0.0).unwrap();
    let mut stepper = Shaken.stepper::<E>(0.1).unwrap().plain();
    let (mut state, mut dw, mut found) = (start(), [0.0; 2], vec![start()]);
    let mut dense = DenseOutput::of(&state);
    for step in 0..42 {
        let interval = wzvi::increments::Interval { start: 0.0, h: 0.1, step };
        noise.increments(&interval, &mut dw).unwrap();
        let from = state.t;
        stepper.step_densely(&mut state, &dw, &mut dense).unwrap();
        for t in TIMES.into_iter().filter(|&t| t > from + 1e-9 && t < state.t + 1e-9) {
            if (t - state.t).abs() < 1e-9 {
                found.push(state);
            } else {
                let (low, high) = ((t - from) / 0.1, 1.0 + (t - state.t) / 0.1);
                found.push(dense.at(if low <= 0.5 { low } else { high }).at(t));
            }
        }
    }
    let interval = wzvi::increments::Interval { start: 0.0, h: 0.1, step: 42 };
    let rest = 4.25 - 42.0 * 0.1;
    noise.increments_of_part(&interval, rest, &mut dw).unwrap();
    Shaken.stepper::<E>(rest).unwrap().plain().step(&mut state, &dw).unwrap();
    found.push(state.at(4.25));
    found
}

fn agrees<E>()
where
    Shaken: Discretized<E, Vector = V1>,
{
    let run = shaken::<E>(21).run().unwrap();
    let times: Vec<f64> = run.nodes().iter().map(|node| node.time()).collect();
    let expected = [&[0.0], &TIMES[..], &[4.25]].concat();
    assert!(times.len() == 6 && times.iter().zip(expected).all(|(t, expected)| (t - expected).abs() < 1e-15));
    let paths = run.paths().unwrap();
    for path in 0..21 {
        for (node, state) in by_hand::<E>(path).into_iter().enumerate() {
            let expected = [state.q[0], state.p[0], state.t];
            assert_eq!(paths.at(path as usize, node), Some(&expected[..]), "{path} {node}");
        }
        // Alone it crosses the sections where it does beside the others.
        let (alone, error) = shaken::<E>(21).record_every(1).replay(path).unwrap();
        assert_eq!((error, alone.last().t), (None, 4.25));
        let mut total = 0;
        for (section, crossings) in run.crossings().iter().enumerate() {
            let of_path = alone.crossings().iter().filter(|crossing| crossing.section == section);
            total += of_path.clone().count() as u64;
            let kept: Vec<_> = crossings.iter().filter(|crossing| crossing.path == path).collect();
            assert_eq!(kept.len(), of_path.clone().count().min(3));
            for (kept, crossing) in kept.into_iter().zip(of_path) {
                assert_eq!((kept.direction, kept.t), (crossing.direction, crossing.state.t));
                assert_eq!((kept.q, kept.p), (&[crossing.state.q[0]][..], &[crossing.state.p[0]][..]));
            }
        }
        assert_eq!(total, alone.crossings().len() as u64);
    }
    assert!(run.crossings()[0].count() > 21 && run.crossings()[1].count_towards(Direction::Falling) == 0);
    let count = run.crossings()[0].count() as f64 / 21.0;
    assert!((run.crossings()[0].mean() - count).abs() < 1e-14 * count);
    assert!(run.crossings()[0].iter().map(|crossing| crossing.path).is_sorted());
}

#[test]
fn paths_of_ensembles_are_single_paths() {
    agrees::<Midpoint>();
    agrees::<Gauss<2>>();
}

/// A single path of the same normals crosses the same section at the same times, up to what compensated sums change.
#[test]
fn replayed_crossings_are_those_of_a_simulation() {
    for path in 0..5 {
        let (alone, _) = shaken::<Midpoint>(21).replay(path).unwrap();
        let run = Shaken.simulate::<Midpoint>(0.1).start(start()).noise(StepNormals::seed(7).path(path));
        let run = run.until(4.25).record_at(TIMES).section(|state| state.q[0]);
        let run = run.section_towards(Direction::Rising, |state| state.p[0] - 0.1).run().unwrap();
        assert_eq!(run.crossings().len(), alone.crossings().len());
        for (ours, theirs) in run.crossings().iter().zip(alone.crossings()) {
            assert!((ours.state.t - theirs.state.t).abs() < 1e-13 && ours.section == theirs.section);
        }
        let increments =
            |path: &Trajectory<V1, Midpoint>| path.increments().map(<[f64]>::to_vec).collect::<Vec<_>>();
        assert_eq!(increments(&run), increments(&alone));
    }
}

#[test]
fn every_split_gives_the_same_bits() {
    fixtures::stepped::every_split(|| shaken::<Midpoint>(700));
}

/// Without noise the first passage is on the dense output.
#[test]
fn first_passages_are_exact_where_paths_are_smooth() {
    fn first<E>(h: f64) -> (f64, f64)
    where
        Oscillator: Discretized<E, Vector = V1>,
    {
        let run = Oscillator.ensemble::<E>(h).start(start()).paths(3).until(10.0);
        let run = run.first_passage("q", |state| state.q[0]).first_passage("p", |state| state.p[0] - 0.5);
        let run = run.section(|state| state.q[0]).keep_crossings(9).run().unwrap();
        let crossings: Vec<f64> = run.crossings()[0].iter().take(3).map(|crossing| crossing.t).collect();
        assert_eq!(run.passage("q").unwrap().mean(), crossings[0]);
        (crossings[0] - FRAC_PI_2, run.passage("p").unwrap().mean() - 7.0 * PI / 6.0)
    }
    let (q, p) = first::<Gauss<8>>(0.25);
    assert!(q.abs() < 1e-12 && p.abs() < 1e-12, "{q:e} {p:e}");
    // h^4 of the cubic beside h^4 of the nodes.
    let (q, p) = first::<Composed<Verlet, Suzuki4>>(0.05);
    assert!(q.abs() < 1e-6 && p.abs() < 1e-6, "{q:e} {p:e}");
}

/// `q = (t + 6) (t - 2) (t + 2)` along the path from -120 at -8.
#[hamiltonian(drift = |q, p, t| p * (3.0 * t * t + 12.0 * t - 4.0), embedding = Gauss<3>)]
struct Cubic;

/// `q = (t - 1) (t - 2) (t - 3)`.
#[hamiltonian(drift = |q, p, t| p * (3.0 * t * t - 12.0 * t + 11.0), embedding = Gauss<3>)]
struct Near;

/// Three crossings in a step, or one and a pair in two: the passage is the first, in either direction of
/// time.
#[test]
fn the_first_of_several_crossings_in_a_step_is_the_passage() {
    for (q, t, h, steps, first) in [
        (-120.0, -8.0, 12.0, 1, -6.0),
        (-120.0, -8.0, 6.0, 2, -6.0),
        (21.0, -5.0, 8.0, 1, -2.0),
        (120.0, 4.0, -12.0, 1, 2.0),
        (-15.0, -1.0, -8.0, 1, -2.0),
    ] {
        let start = State::new([q], [0.0]).at(t);
        let run = Cubic.ensemble::<Gauss<3>>(h).start(start).paths(3).steps(steps);
        let run = run.first_passage("zero", |state| state.q[0]).section(|state| state.q[0]);
        let run = run.keep_crossings(1).run().unwrap();
        let passages = run.passage("zero").unwrap();
        assert_eq!(passages.passed(), 3);
        // Quadrature is exact to rounding of values of 120 with slopes of 12 and more.
        assert!((passages.mean() - first).abs() < 1e-12, "{} {first}", passages.mean());
        assert_eq!(Some(passages.mean()), run.crossings()[0].iter().next().map(|crossing| crossing.t));
    }
    // All three between two of the points at which a step is looked at.
    let start = State::new([-6.0], [0.0]).at(0.0);
    let run = Near.ensemble::<Gauss<3>>(14.0).start(start).paths(3).steps(1);
    let run = run.first_passage("zero", |state| state.q[0]).run().unwrap();
    assert!((run.passage("zero").unwrap().mean() - 1.0).abs() < 1e-12);
}

#[test]
fn statistics_between_nodes_are_those_of_the_solution() {
    let run = Oscillator.ensemble::<Gauss<8>>(0.25).start(start()).paths(2).until(2.0).record_at([0.6, 1.23]);
    let run = run.observe("q", |state| state.q[0]).run().unwrap();
    for node in run.nodes() {
        assert!((node.mean(0) - node.time().cos()).abs() < 1e-12, "{}", node.time());
    }
}

#[test]
fn ensembles_with_sections_go_on() {
    let folder = fixtures::folder!("resumed");
    let to = || Checkpoint::to(folder.join("run"));
    shaken::<Midpoint>(600).checkpoint(to()).run().unwrap();
    let resumed = shaken::<Midpoint>(1300).checkpoint(to()).run().unwrap();
    assert_eq!(format!("{resumed:?}"), format!("{:?}", shaken::<Midpoint>(1300).run().unwrap()));
    let other = shaken::<Midpoint>(1300).keep_crossings(4).checkpoint(to()).run().unwrap_err();
    assert!(other.to_string().contains("crossings that are kept"), "{other}");
}

/// A noise with a memory: each increment is the sum of those before and of one more number. The last, shorter step continues it, too.
#[derive(Clone)]
struct Growing {
    sum: f64,
}

impl Noise for Growing {
    fn increments(
        &mut self,
        interval: &wzvi::increments::Interval,
        dw: &mut [f64],
    ) -> Result<(), wzvi::error::NoiseError> {
        self.increments_of_part(interval, interval.h, dw)
    }

    fn increments_of_part(
        &mut self,
        _: &wzvi::increments::Interval,
        h: f64,
        dw: &mut [f64],
    ) -> Result<(), wzvi::error::NoiseError> {
        self.sum += h;
        dw.fill(0.1 * self.sum);
        Ok(())
    }
}

impl wzvi::noise::Paths for Growing {
    fn set_path(&mut self, path: u64) {
        self.sum = path as f64;
    }
}

#[test]
fn a_noise_with_a_memory_goes_on_in_the_last_step() {
    let run = Shaken.ensemble::<Midpoint>(0.1).start(start()).paths(5).noise(Growing { sum: 0.0 });
    let run = run.until(0.55).keep_paths(1 << 20).run().unwrap();
    for path in 0..5 {
        // Steps by hand: a run asks its noise before the first step whether it has increments for the last.
        let (mut state, mut noise, mut dw) = (start(), Growing { sum: path as f64 }, [0.0; 2]);
        for (step, h) in [0.1, 0.1, 0.1, 0.1, 0.1, 0.55 - 5.0 * 0.1].into_iter().enumerate() {
            let interval = wzvi::increments::Interval { start: 0.0, h: 0.1, step: step as u64 };
            noise.increments_of_part(&interval, h, &mut dw).unwrap();
            Shaken.stepper::<Midpoint>(h).unwrap().plain().step(&mut state, &dw).unwrap();
        }
        let end = run.paths().unwrap().at(path as usize, 1).unwrap();
        assert!((end[0] - state.q[0]).abs() < 1e-13 && (end[1] - state.p[0]).abs() < 1e-13, "{path}");
    }
}
