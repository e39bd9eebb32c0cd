//! What an ensemble finds out: against the paths themselves, against exact laws, and in files.

use fixtures::edge::{Cubes, EDGE, Edge};
use fixtures::small::Rotation;
use fixtures::stepped::every_split;
use fixtures::{are_refused, column, folder, table};
use wzvi::ensemble::{Column, Passage, Quantiles, StatisticsError};
use wzvi::prelude::*;

#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.25 * (q * q - 1.0).powi(2),
    noise = [|q, p| -s * q],
    embedding = [Midpoint],
)]
pub struct Kramers {
    pub s: f64,
}

/// A Brownian motion in `p`.
#[hamiltonian(drift = |q, p| 0.0 * q * p, noise = [|q, p| -s * q], embedding = [DeltaPlus])]
pub struct Brown {
    pub s: f64,
}

const BINS: usize = 24;

fn everything(paths: u64) -> wzvi::ensemble::Ensemble<'static, Edge, DeltaPlus> {
    const EDGE: Edge = Edge { a: 1.0, sigma: 1.0 };
    EDGE.ensemble::<DeltaPlus>(0.05)
        .start(State::new([1.0], [0.5]))
        .paths(paths)
        .seed(11)
        .allow_losses(1.0)
        .steps(40)
        .observe("q", |state| state.q[0])
        .observe("p", |state| state.p[0])
        .quantiles()
        .histogram("p", -2.0, 2.0, BINS)
        .first_passage("turns", |state| state.p[0])
        .first_passage("event1", |state| state.q[0] - 1.3)
}

/// Everything computed again from the paths themselves, in two passes: the same counts, and the same moments up to the
/// rounding of 600 additions of numbers of order one.
#[test]
fn statistics_are_those_of_the_paths() {
    let n = 600;
    let run = everything(n).record_every(1).keep_paths(1 << 20).run().unwrap();
    let paths = run.paths().unwrap();
    assert_eq!(paths.count(), 600);
    assert!(run.failed() > 20 && run.failed() < 500, "{}", run.failed());
    for (number, node) in run.nodes().iter().enumerate() {
        let alive: Vec<&[f64]> =
            (0..600).map(|path| paths.at(path, number).unwrap()).filter(|x| !x[0].is_nan()).collect();
        assert_eq!(node.count(), alive.len() as u64);
        let count = alive.len() as f64;
        let mean = [0, 1].map(|i| alive.iter().map(|x| x[i]).sum::<f64>() / count);
        for (i, j) in [(0, 0), (0, 1), (1, 1)] {
            let products = alive.iter().map(|x| (x[i] - mean[i]) * (x[j] - mean[j]));
            let covariance = products.sum::<f64>() / (count - 1.0);
            assert!((node.mean(i) - mean[i]).abs() < 1e-13);
            assert!((node.covariance(i, j) - covariance).abs() < 1e-13);
            assert_eq!(node.covariance(i, j), node.covariance(j, i));
        }
        let mut counts = [0; BINS];
        for x in alive.iter().filter(|x| (-2.0..2.0).contains(&x[1])) {
            counts[((x[1] + 2.0) / 4.0 * BINS as f64) as usize] += 1;
        }
        let histogram = &node.histograms()[0];
        assert_eq!(histogram.counts(), counts);
        assert_eq!(histogram.total(), node.count());
        let mut sorted: Vec<f64> = alive.iter().map(|x| x[0]).collect();
        sorted.sort_by(f64::total_cmp);
        for fraction in [0.0, 0.013, 0.5, 0.77, 1.0] {
            let rank = ((fraction * count).ceil() as usize).max(1);
            let (got, exact) = (node.quantiles(0).unwrap().at(fraction), sorted[rank - 1]);
            assert!((got - exact).abs() <= Quantiles::RELATIVE_ERROR * exact.abs(), "{got} {exact}");
        }
    }
    for (event, name) in ["turns", "event1"].iter().enumerate() {
        let function = |x: &[f64]| if event == 0 { x[1] } else { x[0] - 1.3 };
        let (mut times, mut censored, mut lost) = (Vec::new(), 0, 0);
        for path in 0..600 {
            let values: Vec<f64> =
                (0..run.nodes().len()).map(|node| function(paths.at(path, node).unwrap())).collect();
            let found = values.windows(2).zip(run.nodes().windows(2)).find_map(|(value, node)| {
                (value[0] * value[1] <= 0.0).then(|| {
                    let [a, b] = [node[0].time(), node[1].time()];
                    a + (b - a) * value[0] / (value[0] - value[1])
                })
            });
            match found {
                Some(time) => times.push(time),
                None if values.iter().any(|x| x.is_nan()) => lost += 1,
                None => censored += 1,
            }
        }
        let passages = run.passage(name).unwrap();
        assert_eq!(
            (passages.passed(), passages.lost(), passages.censored()),
            (times.len() as u64, lost, censored)
        );
        assert!(times.len() > 100, "{}", times.len());
        let mean = times.iter().sum::<f64>() / times.len() as f64;
        assert!((passages.mean() - mean).abs() < 1e-13, "{} {mean}", passages.mean());
        assert_eq!(passages.histogram().total(), passages.passed());
    }
    assert!(run.passages()[0].lost() > 0 || run.passages()[1].lost() > 0);
}

/// Few paths are few chunks, which threads share, and of many each takes several at once; a group of lanes that are not all needed is narrower.
#[test]
fn every_split_has_the_same_bits() {
    for paths in [5, 77, 512, 1100] {
        let run = || {
            let run = everything(paths).record_at([0.35, 1.0]).keep_paths(1 << 20);
            run.section(|state| state.p[0]).keep_crossings(2)
        };
        let reference = every_split(run);
        assert_eq!(reference.nodes().len(), 4);
        assert_eq!(format!("{:?}", run().threads(100).run().unwrap()), format!("{reference:?}"), "{paths}");
    }
}

/// A statistic that the run does not know: shown every path at every time, and a table among the others.
#[test]
fn a_statistic_of_ones_own_sees_every_path() {
    let run = || EDGE.run::<DeltaPlus>();
    let all = run().run().unwrap();
    let (cubes, paths) = (all.statistic::<Cubes>().unwrap(), all.paths().unwrap());
    assert_eq!((cubes.lost, cubes.sums.len()), (all.failed(), all.nodes().len()));
    for (node, sum) in cubes.sums.iter().enumerate() {
        let values = (0..paths.count()).map(|path| paths.at(path, node).unwrap()[0].powi(3));
        let exact: f64 = values.filter(|value| !value.is_nan()).sum();
        // 2148 additions of numbers of order one.
        assert!((sum - exact).abs() < 1e-12 * exact.abs(), "{sum} {exact}");
    }
    assert_eq!(column(table(&all.tables(), "cubes"), "sum"), cubes.sums);
    for threads in [1, 3] {
        assert_eq!(run().threads(threads).run_in::<4>().unwrap().statistic::<Cubes>().unwrap(), cubes);
    }
    let missing = everything(9).run().unwrap().statistic::<Cubes>().unwrap_err();
    assert!(missing.to_string().contains(".statistic(...)"), "{missing}");
}

/// What the passages and the crossings of each path were, beside what their sums say.
#[test]
fn results_by_path_are_columns() {
    let run =
        everything(300).keep_paths(1 << 20).section(|state| state.p[0]).keep_crossings(1).run().unwrap();
    let turns = run.passage("turns").unwrap();
    let by_path = turns.by_path().unwrap();
    let count = |of: fn(&Passage) -> bool| by_path.iter().filter(|passage| of(passage)).count() as u64;
    assert_eq!(count(|passage| matches!(passage, Passage::At(_))), turns.passed());
    assert_eq!(count(|passage| matches!(passage, Passage::Censored)), turns.censored());
    assert_eq!(count(|passage| matches!(passage, Passage::Lost(_))), turns.lost());
    let tables = run.tables();
    let (passages, states) = (table(&tables, "path_passages"), table(&tables, "crossing_states"));
    assert_eq!(passages.rows(), 600);
    for (time, passage) in column(passages, "time").iter().zip(by_path) {
        match passage {
            Passage::At(at) | Passage::Lost(at) => assert_eq!(time, at),
            Passage::Censored => assert!(time.is_nan()),
        }
    }
    // A path starts with p > 0: where it first turns, it crosses p = 0 downwards for the first time.
    let Some((_, Column::Count(paths))) = states.columns().iter().find(|(name, _)| name == "path") else {
        unreachable!()
    };
    assert_eq!(paths.len() as u64, turns.passed());
    assert!(paths.iter().all(|&path| matches!(by_path[path as usize], Passage::At(_))));
    // Of the cubic between the nodes, at its zero to rounding.
    assert!(column(states, "p0").iter().all(|p| p.abs() < 1e-14), "{states:?}");
    assert_eq!(table(&tables, "crossings").rows(), 1);
    assert!(everything(9).run().unwrap().passages()[0].by_path().is_none());
}

/// Nothing holds it.
#[hamiltonian(drift = |q, p| 0.5 * p * p - q.powi(4), noise = [|q, p| -s * q], embedding = [Midpoint])]
pub struct Falling {
    pub s: f64,
}

/// A path that fails in the middle of a divided step was looked at for the last time at the node before it.
#[test]
fn paths_are_lost_at_nodes() {
    let falling = Falling { s: 1.0 };
    let run = falling.ensemble::<Midpoint>(0.1).start(State::new([0.5], [0.0])).paths(40).seed(3).until(2.0);
    let run = run.retry(Retry::halving(3)).record_every(1).allow_losses(1.0).keep_paths(1 << 20);
    let run = run.first_passage("never", |_| 1.0).run().unwrap();
    let node = |step: u64| run.nodes()[step as usize].time();
    assert!(run.failures().iter().filter(|failure| failure.error.t > node(failure.error.step)).count() > 10);
    for failure in run.failures() {
        let passage = run.passages()[0].by_path().unwrap()[failure.path as usize];
        assert_eq!(passage, Passage::Lost(node(failure.error.step)));
    }
}

/// The first passage of Brownian motion through 1 before time 1: `2 Φ(-1) = 0.3173`. Watched at nodes only, the level is as
/// good as `0.5826 √h` farther away (M. Broadie, P. Glasserman, S. Kou, Math. Finance 7, 1997), up to `o(√h)`; the
/// correction is 16 standard errors of this run, and what it leaves has to be within five.
#[test]
fn brownian_passages_have_the_probability_of_the_reflection_principle() {
    let (h, n) = (0.01, 10_000);
    let run = Brown { s: 1.0 }
        .ensemble::<DeltaPlus>(h)
        .start(State::new([0.0], [0.0]))
        .paths(n)
        .seed(5)
        .until(1.0)
        .quantiles()
        .first_passage("event0", |state| state.p[0] - 1.0)
        .run()
        .unwrap();
    let passages = &run.passages()[0];
    assert_eq!(passages.passed() + passages.censored(), n);
    let fraction = passages.passed() as f64 / n as f64;
    let exact = 2.0 * below(-1.0 - 0.5826 * f64::sqrt(h));
    let error = (exact * (1.0 - exact) / n as f64).sqrt();
    assert!((fraction - exact).abs() < 5.0 * error, "{fraction}, expected {exact} ± {error}");
    assert!((2.0 * below(-1.0) - exact) / error > 6.0);
    // p(1) is a standard normal: a quantile has the standard error √(f (1 - f)/n) / φ, and the sketch its own.
    for (f, x) in
        [(0.05, -1.644_853_627), (0.25, -0.674_489_750), (0.75, 0.674_489_750), (0.99, 2.326_347_874)]
    {
        let density = (-0.5f64 * x * x).exp() / std::f64::consts::TAU.sqrt();
        let allowed = 5.0 * (f * (1.0 - f) / n as f64).sqrt() / density + Quantiles::RELATIVE_ERROR * x.abs();
        assert!(
            (run.quantile("p", f).unwrap() - x).abs() < allowed,
            "{f}: {} {x}",
            run.quantile("p", f).unwrap()
        );
    }
    for fraction in [1.1, -0.1, f64::NAN, f64::INFINITY] {
        let refused = run.quantile("p", fraction).unwrap_err();
        assert!(
            matches!(refused, StatisticsError::Fraction(_)) && refused.to_string().contains("from 0 to 1")
        );
    }
}

/// `Φ(x)` by Simpson's rule from 12 deviations below.
fn below(x: f64) -> f64 {
    let n = 20_000;
    let f = |i: i32| {
        let y: f64 = x - 12.0 * f64::from(i) / f64::from(n);
        (-0.5 * y * y).exp()
    };
    let inner: f64 = (1..n).map(|i| f(i) * if i % 2 == 1 { 4.0 } else { 2.0 }).sum();
    (f(0) + inner + f(n)) * 12.0 / f64::from(n) / 3.0 / std::f64::consts::TAU.sqrt()
}

/// `q = sin t` is back at zero at `π`; linear interpolation is off by `h² |q''/q'| / 8` at most, which is zero there, and the
/// scheme turns by `2 atan(h/2)` per step: slower by `h²/12`.
#[test]
fn a_known_passage_comes_at_its_time() {
    let h = 0.01;
    let run = Rotation { omega: 1.0 }
        .ensemble::<Midpoint>(h)
        .start(State::new([0.0], [1.0]))
        .paths(3)
        .until(4.0)
        .first_passage("back", |state| state.q[0])
        .first_passage("never", |state| state.q[0] - 2.0)
        .run()
        .unwrap();
    let [back, never] = run.passages() else { panic!("{run:?}") };
    let expected = std::f64::consts::PI * (h / 2.0) / (h / 2.0_f64).atan();
    // The chord between two nodes: third order, h³/9√3 of the sine.
    assert!((back.mean() - expected).abs() < 0.07 * h * h * h, "{} {expected}", back.mean());
    assert_eq!(back.variance(), 0.0);
    assert_eq!((never.passed(), never.censored(), never.rate()), (0, 3, 0.0));
    assert!(never.mean().is_nan());
}

/// A straight line, with a noise that can be 0.
#[hamiltonian(drift = |q, p| 0.5 * p * p, noise = [|q, p| -s * q], embedding = [Midpoint])]
pub struct Line {
    pub s: f64,
}

/// A straight line without.
#[hamiltonian(drift = |q, p| 0.5 * p * p, embedding = Midpoint)]
pub struct Smooth;

/// Of a line with a noise only the nodes are looked at. At an infinite value nothing but the sign is known: a
/// passage is at the node of the other value. The bins go from the start to the end, in either direction of
/// time, and each passage is in one.
#[test]
fn passages_at_either_end_are_in_a_bin() {
    for (h, is_last) in [(0.125, true), (-0.125, false), (0.125, false), (-0.125, true)] {
        let end = 8.0 * h;
        let is_at_end = f64::signum(h) > 0.0 && is_last || f64::signum(h) < 0.0 && !is_last;
        let event = move |t: f64| match is_at_end {
            true if t == end => 1.0,
            true => f64::NEG_INFINITY,
            false if t == 0.0 => -1.0,
            false => f64::INFINITY,
        };
        let run =
            Line { s: 0.0 }.ensemble::<Midpoint>(h).start(State::new([0.0], [1.0])).steps(8).paths(3).seed(1);
        let run = run.first_passage("one", move |state| event(state.t)).run().expect("an ensemble");
        let (passages, bins) = (&run.passages()[0], run.passages()[0].histogram());
        let time = if is_at_end { end } else { 0.0 };
        assert_eq!((passages.passed(), passages.censored(), passages.mean()), (3, 0, time), "{h}");
        assert_eq!((bins.below(), bins.above()), (0, 0), "{h}");
        assert_eq!(bins.counts()[if is_last { bins.counts().len() - 1 } else { 0 }], 3, "{h}");
    }
}

/// Steps of an eighth along `q = q_0 + t` are exact. With a noise, of strength 0, nodes are looked at,
/// without one, steps: one rule.
#[test]
fn passages_are_changes_of_sign() {
    let lines = |event: fn(f64) -> f64, q: f64| {
        let start = State::new([q], [1.0]);
        let nodes = Line { s: 0.0 }.ensemble::<Midpoint>(0.125).start(start).steps(16).paths(3).seed(1);
        let inside = Smooth.ensemble::<Midpoint>(0.125).start(start).steps(16).paths(3);
        let nodes = nodes.first_passage("zero", move |state| event(state.q[0])).run().expect("an ensemble");
        let inside = inside
            .first_passage("zero", move |state| event(state.q[0]))
            .section(move |state| event(state.q[0]));
        let inside = inside.keep_crossings(1).run().expect("an ensemble");
        let first = inside.crossings()[0].iter().next().map(|crossing| crossing.t);
        let passed = [&nodes, &inside].map(|run| {
            let passages = &run.passages()[0];
            (passages.passed() == 3).then(|| passages.mean())
        });
        assert_eq!(passed[1], first);
        passed
    };
    // A start and an end at the level are no passages; neither is a start beyond it.
    assert_eq!(lines(|q| q, 0.0), [None; 2]);
    assert_eq!(lines(|q| q - 2.0, 0.0), [None; 2]);
    assert_eq!(lines(|q| q + 1.0, 0.0), [None; 2]);
    // From a start at the level, out and back; and from beyond it.
    assert_eq!(lines(|q| q * (1.0 - q), 0.0), [Some(1.0); 2]);
    assert_eq!(lines(|q| 1.0 - q, 0.5), [Some(0.5); 2]);
    // Touched at a node; and at a node, where it is zero for a while, crossed.
    assert_eq!(lines(|q| (q - 1.0).powi(2), 0.0), [None; 2]);
    assert_eq!(lines(|q| (q - 1.0).min(0.0) + (q - 1.5).max(0.0), 0.0), [Some(1.0); 2]);
    // From nowhere there is no side.
    assert_eq!(lines(|q| if (0.9..1.1).contains(&q) { f64::NAN } else { q - 1.0 }, 0.0), [None; 2]);
    // A pair within a step shows inside alone.
    assert_eq!(
        lines(|q| (q - 1.0625).powi(2) - 0.03125_f64.powi(2), 0.0).map(|time| time.is_some()),
        [false, true]
    );
}

#[test]
fn times_are_chosen() {
    let run = everything(50).record_at([0.1, 1.0]).run().unwrap();
    let times: Vec<f64> = run.nodes().iter().map(|node| node.time()).collect();
    assert_eq!(times, [0.0, 2.0 * 0.05, 1.0, 2.0]);
    are_refused(everything(50).record_at([2.1]).run(), "t = 2.1");
    are_refused(everything(50).record_at([f64::NAN]).run(), "NaN");
    are_refused(everything(50).histogram("energy", 0.0, 1.0, 3).run(), "energy");
    are_refused(everything(50).histogram("q", 1.0, 0.0, 3).run(), "width");
    are_refused(everything(50).keep_paths(3199).run(), "3200");
    assert!(everything(50).keep_paths(3200).run().is_ok());
    are_refused(everything(50).observe("q", |_| 0.0).run(), "`q`");
}

/// Text comes back as the numbers that it was made of.
#[test]
fn files_are_read_back() {
    let folder = folder!("tables").join("new");
    let run = everything(64)
        .observe("a \"quoted\", name", |state| 1.0 / (state.t - 0.5))
        .record_at([0.5])
        .keep_paths(1 << 20)
        .run()
        .unwrap();
    run.write_csv(&folder).unwrap();
    let moments = std::fs::read_to_string(folder.join("moments.csv")).unwrap();
    let mut lines = moments.lines();
    assert_eq!(
        lines.next(),
        Some("time,observable,count,lost,not_finite,mean,standard_error,error_bound,largest_share,variance")
    );
    assert_eq!(lines.clone().count(), 3 * 3);
    let first: Vec<&str> = lines.next().unwrap().split(',').collect();
    assert_eq!(first[..6], ["0.0", "q", "64", "0", "0", "1.0"]);
    let last = run.last().unwrap();
    let q_at_end = moments.lines().find(|line| line.starts_with("2.0,q,")).unwrap();
    let mean: f64 = q_at_end.split(',').nth(5).unwrap().parse().unwrap();
    assert_eq!(mean.to_bits(), last.mean(0).to_bits());
    assert!(moments.contains("\n0.5,\"a \"\"quoted\"\", name\","), "{moments}");
    // As many lines as rows in every table.
    for table in run.tables() {
        let text = std::fs::read_to_string(folder.join(table.name()).with_extension("csv")).unwrap();
        assert_eq!(text.lines().count(), table.rows() + 1, "{}", table.name());
    }
    let names: Vec<String> = run.tables().iter().map(|table| table.name().to_owned()).collect();
    let all = "run moments covariances quantiles histograms passages passage_times path_passages crossings \
               crossing_states failures paths";
    assert_eq!(names.join(" "), all);

    run.write_json(folder.join("all.json")).unwrap();
    let json: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(folder.join("all.json")).unwrap()).unwrap();
    let means = json["moments"]["mean"].as_array().unwrap();
    assert_eq!(means.len(), 9);
    // The infinite mean is null.
    assert_eq!(json["moments"]["observable"][5], "a \"quoted\", name");
    assert!(means[5].is_null() && !means[3].is_null());
    assert_eq!(means[6].as_f64().unwrap().to_bits(), last.mean(0).to_bits());
    assert_eq!(json["paths"]["path"].as_array().unwrap().len(), 64 * 3);
    std::fs::remove_dir_all(&folder).unwrap();
    // A folder that is a file.
    std::fs::write(&folder, "").unwrap();
    let error = run.write_csv(&folder).unwrap_err();
    assert_eq!(error.path(), folder);
    assert!(error.to_string().contains("create the folder"), "{error}");
}

/// Where nothing is drawn, no table says that it was.
#[test]
fn a_run_without_noise_has_none() {
    let folder = folder!("quiet");
    let still = Rotation { omega: 1.0 };
    let run = still.ensemble::<Midpoint>(0.1).start(State::new([0.0], [1.0])).paths(2).steps(3);
    run.run().unwrap().write_csv(&folder).unwrap();
    let table = std::fs::read_to_string(folder.join("run.csv")).unwrap();
    let mut lines = table.lines().map(|line| line.split(','));
    let column = lines.next().unwrap().position(|name| name == "noise").unwrap();
    assert_eq!(lines.next().unwrap().nth(column), Some("none"));
}

/// What a folder had of another run goes, and the new set says what it is of.
#[test]
fn tables_of_two_runs_do_not_lie_beside_each_other() {
    let folder = folder!("set");
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap();
    everything(64).quantiles().keep_paths(1 << 20).run().unwrap().write_csv(&folder).unwrap();
    assert!(read("paths.csv").lines().count() > 64 && read("quantiles.csv").lines().count() > 1);
    std::fs::write(folder.join("moments.part"), "mine").unwrap();
    std::fs::write(folder.join("run.part"), "mine").unwrap();
    let kramers = Kramers { s: 0.6 };
    let plain = kramers.ensemble::<Midpoint>(0.1).start(State::new([0.0], [1.0])).seed(u64::MAX).until(1.0);
    let part = plain.paths(2000).until_error("q", 1e-9).run().unwrap();
    part.write_csv(&folder).unwrap();
    // Tables without rows have their first line.
    for name in ["paths.csv", "quantiles.csv", "histograms.csv", "passages.csv", "failures.csv"] {
        assert_eq!(read(name).lines().count(), 1, "{name}");
    }
    let run = read("run.csv");
    let columns: Vec<(&str, &str)> =
        run.lines().next().unwrap().split(',').zip(run.lines().nth(1).unwrap().split(',')).collect();
    let (noise, columns): (Vec<_>, Vec<_>) = columns.into_iter().partition(|(name, _)| *name == "noise");
    assert!(noise[0].1.starts_with("StepNormals (seed 18446744073709551615;"), "{noise:?}");
    let version = env!("CARGO_PKG_VERSION");
    let expected = [
        ("system", "Kramers"),
        ("scheme", "Midpoint"),
        ("version", version),
        ("step_size", "0.1"),
        ("start", "0.0"),
        ("steps", "10"),
        ("seed", "18446744073709551615"),
        ("paths_wanted", "2000"),
        ("paths", "2000"),
        ("failed", "0"),
        ("extent", "whole"),
        ("targets", "missed"),
        ("s", "0.6"),
    ];
    assert_eq!(columns, expected);
    assert_eq!((read("moments.part"), read("run.part")), ("mine".to_owned(), "mine".to_owned()));
    // A table that cannot be replaced: all others stay as they are.
    std::fs::remove_file(folder.join("paths.csv")).unwrap();
    std::fs::create_dir(folder.join("paths.csv")).unwrap();
    let names = || {
        let mut names: Vec<_> =
            std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        names.sort();
        names
    };
    let (before, moments) = (names(), read("moments.csv"));
    let error = everything(64).run().unwrap().write_csv(&folder).unwrap_err();
    assert!(error.to_string().contains("paths.csv") && error.to_string().contains("a folder"), "{error}");
    assert_eq!((names(), read("moments.csv"), read("run.csv")), (before, moments, run.clone()));
    std::fs::remove_dir_all(&folder).unwrap();
}

/// The rate of escape over a barrier does not depend on where the run is cut: censored paths count.
#[test]
fn rates_allow_for_censoring() {
    let run = |end: f64| {
        Kramers { s: 0.6 }
            .ensemble::<Midpoint>(0.05)
            .start(State::new([-1.0], [0.0]))
            .paths(2000)
            .seed(3)
            .until(end)
            .first_passage("event0", |state| state.q[0])
            .run()
            .unwrap()
    };
    let (short, long) = (run(4.0), run(12.0));
    let (short, long) = (&short.passages()[0], &long.passages()[0]);
    assert!(short.censored() > long.censored() && long.censored() > 0);
    assert_eq!(long.passed() + long.censored(), 2000);
    assert!(long.rate() > 0.0 && long.rate_error() < 0.05 * long.rate(), "{long:?}");
}

/// With a noise, sections beside the events of a run change none of its passages.
#[test]
fn passages_are_the_same_beside_sections() {
    let run = || {
        let run = Kramers { s: 0.6 }.ensemble::<Midpoint>(0.05).start(State::new([-1.0], [0.0])).paths(40);
        run.seed(3)
            .until(8.0)
            .first_passage("over", |state| state.q[0])
            .first_passage("up", |state| state.q[0] + 0.5)
    };
    let [alone, beside] = [run(), run().section(|state| state.p[0]).section(|state| state.q[0] + 0.8)]
        .map(|run| run.run().unwrap());
    assert!(alone.passages().iter().all(|passages| passages.passed() > 0));
    assert_eq!(format!("{:?}", beside.passages()), format!("{:?}", alone.passages()));
}

/// Two points in a plane, each in a well of its own.
#[hamiltonian(
    drift = |q: [[f64; 2]; 2], p: [[f64; 2]; 2]| (0..2)
        .map(|i| 0.5 * (p[i][0] * p[i][0] + p[i][1] * p[i][1]) + q[i][0] * q[i][0] + (2.0 - q[i][0]) * q[i][1] * q[i][1])
        .sum::<f64>(),
    embedding = Midpoint,
)]
struct Plane;

/// Observables and sections of points read `state.points` as the closure of the Hamiltonian reads its arguments, in single runs and in ensembles.
#[test]
fn points_are_read_as_in_the_hamiltonian() {
    type Points = State<wzvi::nalgebra::SVector<f64, 4>>;
    let energy = |state: &Points| {
        let [q, p] = state.points::<2>();
        let kinetic = |i: usize| 0.5 * (p[i][0] * p[i][0] + p[i][1] * p[i][1]);
        let potential = |i: usize| q[i][0] * q[i][0] + (2.0 - q[i][0]) * q[i][1] * q[i][1];
        (0..2).map(|i| kinetic(i) + potential(i)).sum::<f64>()
    };
    let side = |state: &Points| state.points::<2>()[0][1][0];
    let start: Points = State::new([[0.3, -0.2], [0.5, 0.1]], [[0.1, 0.4], [-0.3, 0.2]]);
    let path = Plane.simulate::<Midpoint>(0.1).start(start).steps(60);
    let path = path.observe("H", energy).section(side).run().unwrap();
    for (state, observed) in path.states().iter().zip(path.observed("H").unwrap()) {
        assert!((observed - Plane.energy(state)).abs() < 1e-15, "{state}");
    }
    assert!(path.crossings().len() > 1 && path.crossings().iter().all(|at| at.state.q[2].abs() < 1e-12));

    let all = Plane.ensemble::<Midpoint>(0.1).start(start).paths(3).steps(60).record_at([0.0, 3.0]);
    let all = all.observe("H", energy).observe("side", side).section(side).keep_crossings(9).run().unwrap();
    for (node, step) in all.nodes().iter().zip([0, 30]) {
        let state = &path.states()[step];
        assert!((node.mean(0) - Plane.energy(state)).abs() < 1e-15 && node.mean(1) == state.q[2], "{state}");
    }
    let crossed: Vec<f64> = all.crossings()[0].iter().map(|at| at.t).collect();
    assert_eq!(
        crossed[..path.crossings().len()],
        path.crossings().iter().map(|at| at.state.t).collect::<Vec<_>>()
    );
}
