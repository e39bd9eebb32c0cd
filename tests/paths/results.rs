//! Results that other programs read: tables of paths with the names of the closure, errors and facts as people see them.

use fixtures::small::Kepler;
use fixtures::{column, folder};
use std::fs;
use std::process::Command;

use wzvi::prelude::*;

#[hamiltonian(
    drift = |angle, momentum, time| 0.5 * momentum * momentum - time.cos() * angle.cos(),
    noise = [|angle, _, _| sigma * angle, |angle, _, _| 0.5 * sigma * angle],
    embedding = DeltaPlus,
)]
struct Shaken {
    sigma: f64,
}

#[hamiltonian(
    drift = |q: [[f64; 2]; N], p: [[f64; 2]; N]| (0..N).map(|i| {
        0.5 * (p[i][0] * p[i][0] + p[i][1] * p[i][1] + q[i][0] * q[i][0] + q[i][1] * q[i][1])
    }).sum::<f64>(),
    embedding = DeltaPlus,
)]
struct Points<const N: usize>;

#[hamiltonian(
    drift = |u: &[f64], v: &[f64]| v.iter().map(|v| 0.5 * v * v).sum::<f64>() + u.iter().map(|u| 0.5 * u * u).sum::<f64>(),
    embedding = DeltaPlus,
)]
struct Sites;

fn kepler() -> Trajectory<wzvi::nalgebra::SVector<f64, 2>, Verlet> {
    let start = State::new([0.5, 0.0], [0.0, 3.0_f64.sqrt()]);
    let run = Kepler.simulate::<Verlet>(0.01).start(start).until(1.0).record_every(10);
    run.observe("radius", |state| state.q.norm()).observe("x", |state| 2.0 * state.q[0]).run().unwrap()
}

fn shaken() -> Trajectory<wzvi::nalgebra::SVector<f64, 1>, DeltaPlus> {
    let run = Shaken { sigma: 0.3 }.simulate::<DeltaPlus>(0.1).start(State::new([0.5], [0.0]));
    run.noise(Wiener::seed(7)).until(1.0).run().unwrap()
}

fn names(table: wzvi::table::Table) -> Vec<String> {
    table.columns().iter().map(|(name, _)| name.clone()).collect()
}

#[test]
fn columns_have_the_names_of_the_closure() {
    let path = kepler();
    assert_eq!(names(path.table().into_table()), ["t", "x", "y", "px", "py", "radius", "x_"]);
    let table = path.table().energies(&Kepler).into_table();
    assert_eq!(names(table)[7..], ["energy", "invariant_0"]);
    let table = shaken().table().energies(&Shaken { sigma: 0.3 }).increments().into_table();
    assert_eq!(names(table), ["time", "angle", "momentum", "energy", "dw_0", "dw_1"]);

    let start = State::new(vec![0.0; 6], vec![0.0; 6]);
    let path = Points::<3>.simulate::<DeltaPlus>(0.1).start(start).steps(1).run().unwrap();
    let all = names(path.table().into_table());
    assert_eq!(all[..4], ["t", "q[0][0]", "q[0][1]", "q[1][0]"]);
    assert_eq!(all[7], "p[0][0]");
    let start = State::new(vec![0.0; 2], vec![0.0; 2]);
    let path = Sites.simulate::<DeltaPlus>(0.1).start(start).steps(1).run().unwrap();
    assert_eq!(names(path.table().into_table()), ["t", "u[0]", "u[1]", "v[0]", "v[1]"]);
}

#[test]
fn every_number_is_that_of_the_path() {
    let path = shaken();
    let system = Shaken { sigma: 0.3 };
    let table = path.table().energies(&system).increments().into_table();
    assert_eq!(table.rows(), path.len());
    let column = |name: &str| column(&table, name);
    assert!(column("time").iter().copied().eq(path.times()));
    assert!(column("angle").iter().eq(path.iter().map(|state| &state.q[0])));
    assert!(column("momentum").iter().eq(path.iter().map(|state| &state.p[0])));
    assert!(column("energy").iter().copied().eq(path.iter().map(|state| system.energy(state))));
    for (k, name) in ["dw_0", "dw_1"].into_iter().enumerate() {
        let increments = column(name);
        assert_eq!(increments[0], 0.0);
        assert!(increments[1..].iter().eq(path.increments().map(|row| &row[k])));
    }
}

#[test]
fn files_say_the_same_to_the_last_bit() {
    let (path, folder) = (kepler(), folder!("bits"));
    let table = path.table().energies(&Kepler);
    let [csv, json] = ["deep/path.csv", "path.json"].map(|name| folder.join(name));
    table.write_csv(&csv).unwrap();
    table.write_json(&json).unwrap();
    let text = fs::read_to_string(csv).unwrap();
    let mut lines = text.lines();
    assert_eq!(lines.next().unwrap(), "t,x,y,px,py,radius,x_,energy,invariant_0");
    let records: Vec<serde_json::Map<String, serde_json::Value>> =
        serde_json::from_str(&fs::read_to_string(json).unwrap()).unwrap();
    assert_eq!((lines.clone().count(), records.len()), (path.len(), path.len()));
    for ((line, record), state) in lines.zip(&records).zip(path.states()) {
        let numbers: Vec<f64> = line.split(',').map(|entry| entry.parse().unwrap()).collect();
        let expected =
            [state.t, state.q[0], state.q[1], state.p[0], state.p[1], state.q.norm(), 2.0 * state.q[0]];
        let proven = [Kepler.energy(state), Kepler.invariant(0, state)];
        assert_eq!(numbers, [&expected[..], &proven[..]].concat());
        assert_eq!(record["x"].as_f64().unwrap(), state.q[0]);
        assert_eq!(record["energy"].as_f64().unwrap(), Kepler.energy(state));
    }
}

/// What pandas makes of the files: plain columns of numbers, the same to the last bit. Where there is no pandas, nothing.
#[test]
fn pandas_reads_each_file_to_columns_of_numbers() {
    let python = std::env::var("WZVI_PYTHON").unwrap_or_else(|_| "python3".into());
    let script = "import sys\nimport pandas\n\
        csv = pandas.read_csv(sys.argv[1] + '/path.csv', float_precision='round_trip')\n\
        frames = [csv, pandas.read_json(sys.argv[1] + '/path.json', orient='records', precise_float=True)]\n\
        if len(sys.argv) > 2: frames.append(pandas.read_parquet(sys.argv[1] + '/path.parquet'))\n\
        for frame in frames:\n    \
            assert list(frame.columns) == ['time', 'angle', 'momentum', 'energy', 'dw_0', 'dw_1'], frame.columns\n    \
            assert all(kind in ('float64', 'int64') for kind in frame.dtypes.astype(str)), frame.dtypes\n    \
            assert len(frame) == 11 and abs(frame - csv).max().max() < 1e-15\n\
        print('sum', repr(csv['energy'].sum()))\n";
    let has_pandas = Command::new(&python).args(["-c", "import pandas"]).output();
    if !has_pandas.is_ok_and(|output| output.status.success()) {
        eprintln!("no pandas: set WZVI_PYTHON to a Python that has it");
        return;
    }
    let (path, folder) = (shaken(), folder!("pandas"));
    let table = path.table().energies(&Shaken { sigma: 0.3 }).increments();
    table.write_csv(folder.join("path.csv")).unwrap();
    table.write_json(folder.join("path.json")).unwrap();
    let mut command = Command::new(python);
    command.args(["-c", script]).arg(&folder);
    table.write_parquet(folder.join("path.parquet")).unwrap();
    command.arg("parquet");
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn a_main_that_fails_says_what_its_user_can_read() {
    let error = Kepler
        .simulate::<Verlet>(0.0)
        .start(State::new([1.0, 0.0], [0.0, 1.0]))
        .until(1.0)
        .run()
        .unwrap_err();
    assert_eq!(format!("{error:?}"), error.to_string());
    assert!(error.to_string().contains("the step size is 0"), "{error}");
}

/// Observables that are NaN or infinite come back from JSON as they were.
#[test]
fn observables_that_are_no_numbers_are_read_back() {
    let shaken = Shaken { sigma: 0.3 };
    let run =
        shaken.simulate::<DeltaPlus>(0.1).start(State::new([0.5], [0.0])).noise(Wiener::seed(7)).until(1.0);
    let run = run.observe("pole", |state| 1.0 / (state.t - state.t)).observe("minus", |_| f64::NEG_INFINITY);
    let path = run.run().unwrap();
    let json = serde_json::to_string(&path).unwrap();
    assert!(json.contains("\"inf\"") && json.contains("\"-inf\""), "{json}");
    let back: Trajectory<wzvi::nalgebra::SVector<f64, 1>, DeltaPlus> = serde_json::from_str(&json).unwrap();
    // `serde_json` reads numbers to the last place but one, unless it has its feature `float_roundtrip`.
    assert!(back.iter().zip(path.iter()).all(|(back, state)| (back.q[0] - state.q[0]).abs() < 1e-15));
    assert_eq!(back.iter().count(), path.iter().count());
    for name in ["pole", "minus"] {
        let bits = |path: &Trajectory<wzvi::nalgebra::SVector<f64, 1>, DeltaPlus>| {
            path.observed(name).unwrap().iter().map(|x| x.to_bits()).collect::<Vec<_>>()
        };
        assert_eq!(bits(&back), bits(&path), "{name}");
    }
    // Files of the version before have `null`.
    let old = json.replace("\"inf\"", "null");
    let old: Trajectory<wzvi::nalgebra::SVector<f64, 1>, DeltaPlus> = serde_json::from_str(&old).unwrap();
    assert!(old.observed("pole").unwrap().iter().all(|value| value.is_nan()));
    let wrong = json.replace("\"inf\"", "\"much\"");
    assert!(serde_json::from_str::<Trajectory<wzvi::nalgebra::SVector<f64, 1>, DeltaPlus>>(&wrong).is_err());
}

/// What `println!("{}", ...)` shows of averages and statistics.
#[test]
fn averages_and_statistics_are_shown() {
    let shaken = Shaken { sigma: 0.3 };
    let run =
        shaken.simulate::<DeltaPlus>(0.1).start(State::new([0.5], [0.0])).noise(Wiener::seed(7)).until(1.0);
    let averages =
        run.observe("angle", |state| state.q[0]).observe("one", |_| 1.0).time_averages().run().unwrap();
    let text = averages.to_string();
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines[0], format!("averages over {} steps", averages.steps));
    assert!(lines[1].starts_with("angle  ") && lines[2].starts_with("one    1"), "{text}");
    assert!(averages.of("angle").unwrap().to_string().starts_with("angle  "));

    let run = shaken.ensemble::<DeltaPlus>(0.1).start(State::new([0.5], [0.0])).paths(20).seed(7);
    let run = run.until(1.0).record_every(5).observe("angle", |state| state.q[0]);
    let run = run
        .first_passage("fall", |state| state.q[0] - 0.3)
        .first_passage("never", |state| state.q[0] + 100.0);
    let statistics = run.run().unwrap();
    let text = statistics.to_string();
    let fall = statistics.passage("fall").unwrap();
    assert!(text.contains("recorded at 3 times from t = 0 to 1"), "{text}");
    assert!(text.contains(&format!("fall: {} of 20 paths passed", fall.passed())), "{text}");
    assert!(text.contains("never: 0 of 20 paths passed; 20 had not at the end"), "{text}");
}

/// An infinite field is named where it makes a state infinite, and only there.
#[test]
fn an_infinite_field_is_named() {
    let start = State::new([0.5], [0.0]);
    let shaken = Shaken { sigma: f64::INFINITY };
    let error =
        shaken.simulate::<DeltaPlus>(0.1).start(start).noise(Wiener::seed(1)).steps(3).run().unwrap_err();
    assert!(error.to_string().contains("the parameter `sigma` of the system is infinite"), "{error}");
    // No path is left.
    let error = shaken.ensemble::<DeltaPlus>(0.1).start(start).paths(5).seed(1).steps(3).run().unwrap_err();
    assert!(error.to_string().contains("the parameter `sigma` of the system is infinite"), "{error}");
}

#[test]
fn a_plan_reads_as_a_sentence() {
    let plan = <Kepler as Discretized<Verlet>>::PLAN;
    assert_eq!(plan.to_string(), "explicit step of order 2; the system keeps its energy");
    let plan = <Shaken as Discretized<DeltaPlus>>::PLAN.to_string();
    assert!(
        plan.starts_with("explicit step of order 1; additive noise: strong order 1, weak order 1"),
        "{plan}"
    );
    assert!(plan.ends_with("the energy of the system changes"), "{plan}");
}

mod plots {
    use wzvi::plot::{Figure, PlotError, Sheet};
    use wzvi::section::Direction;

    use super::*;

    /// The numbers of a series.
    fn points(figure: &Figure, series: usize) -> &[(f64, f64)] {
        &figure.series[series].points
    }

    #[test]
    fn figures_show_the_numbers_of_the_path() {
        let path = kepler();
        let portrait = path.plot().phase_portrait();
        assert_eq!((portrait.x.label.as_str(), portrait.y.label.as_str()), ("x, y", "px, py"));
        assert!(points(&portrait, 1).iter().copied().eq(path.iter().map(|state| (state.q[1], state.p[1]))));
        let series = path.plot().degrees([1, 7]).time_series();
        let names: Vec<&str> = series.series.iter().map(|series| series.name.as_str()).collect();
        assert_eq!(names, ["y", "py"]);
        assert!(points(&series, 1).iter().copied().eq(path.iter().map(|state| (state.t, state.p[1]))));
        let drift = path.plot().energy_drift(&Kepler);
        let largest = |series| points(&drift, series).iter().map(|point| point.1.abs()).fold(0.0, f64::max);
        assert_eq!(largest(0), path.energy_drift(&Kepler));
        assert_eq!(largest(1), path.invariant_drift(&Kepler, 0).unwrap());
        assert_eq!(shaken().plot().time_series().x.label, "time");
    }

    #[test]
    fn any_two_variables_have_an_orbit() {
        let path = kepler();
        let orbit = path.plot().orbit("x", "y").unwrap();
        assert!(points(&orbit, 0).iter().copied().eq(path.iter().map(|state| (state.q[0], state.q[1]))));
        assert!(orbit.has_equal_axes && !path.plot().orbit("t", "py").unwrap().has_equal_axes);
        let error = path.plot().orbit("x", "z").unwrap_err();
        assert_eq!(error.to_string(), "no variable has the name `z`: there are `x`, `y`, `px`, `py`, `t`");
    }

    #[test]
    fn statistics_show_means_histograms_and_sweeps() {
        let amplitude = |path: u64| 0.1 * path as f64;
        let run = Shaken { sigma: 0.3 }
            .ensemble::<DeltaPlus>(0.1)
            .start(State::new([0.5], [0.0]))
            .paths(20)
            .seed(7);
        let run = run
            .until(1.0)
            .record_every(5)
            .observe("angle", |state| state.q[0])
            .histogram("angle", -3.0, 3.0, 8);
        let statistics = run.keep_paths(1 << 16).run().unwrap();
        let plot = statistics.plot();
        let means = plot.means();
        let of_nodes = |value: fn(&wzvi::ensemble::StatisticsNode) -> f64| {
            statistics.nodes().iter().map(|node| (node.time(), value(node))).collect::<Vec<_>>()
        };
        assert_eq!(points(&means, 0), of_nodes(|node| node.mean(0)));
        assert_eq!(points(&means, 2), of_nodes(|node| node.mean(0) + 2.0 * node.standard_error(0)));
        let histogram = plot.histogram("angle").unwrap();
        assert_eq!(
            histogram.series.iter().map(|series| series.name.as_str()).collect::<Vec<_>>(),
            ["t = 0.5", "t = 1"]
        );
        let kept = statistics.histogram("angle").unwrap();
        assert!(points(&histogram, 1).iter().enumerate().all(|(bin, point)| point.1 == kept.density(bin)));
        let sweep = plot.sweep("angle", 2, amplitude).unwrap();
        let paths = statistics.paths().unwrap();
        assert_eq!(points(&sweep, 0).len(), 40);
        assert_eq!(points(&sweep, 0)[39], (amplitude(19), paths.at(19, 2).unwrap()[0]));
        assert!(plot.histogram("energy").is_err() && plot.sweep("energy", 1, amplitude).is_err());
    }

    #[test]
    fn sections_show_the_crossings() {
        let start = State::new([0.5, 0.0], [0.0, 3.0_f64.sqrt()]);
        let run = Kepler.simulate::<Verlet>(0.01).start(start).until(20.0).record_every(0);
        let path = run.section_towards(Direction::Rising, |state| state.q[1]).run().unwrap();
        let section = path.plot().degrees([0]).section();
        assert!(points(&section, 0).len() >= 2);
        assert!(
            points(&section, 0)
                .iter()
                .copied()
                .eq(path.crossings().iter().map(|crossing| (crossing.state.q[0], crossing.state.p[0])))
        );
    }

    #[test]
    fn files_are_drawings_with_the_names_in_them() {
        let (path, folder) = (kepler(), folder!("plots"));
        let [svg, png, other] = ["a/portrait.svg", "drift.png", "drift.pdf"].map(|name| folder.join(name));
        path.plot().phase_portrait().equal_axes().write(&svg).unwrap();
        let text = fs::read_to_string(svg).unwrap();
        for word in ["Phase portrait", "px against x", "py against y"] {
            assert!(text.contains(word), "{word}");
        }
        path.plot().energy_drift(&Kepler).write(&png).unwrap();
        let mut reader =
            png::Decoder::new(std::io::BufReader::new(fs::File::open(png).unwrap())).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        assert_eq!((info.width, info.height), (1280, 880));
        // The colours of the curves, of text and of the ground.
        for colour in [[0, 114, 178], [213, 94, 0], [17, 17, 17], [255, 255, 255]] {
            assert!(pixels.chunks(3).any(|pixel| pixel == colour), "{colour:?}");
        }
        let error = path.plot().section().write(&other).unwrap_err();
        assert_eq!(error, PlotError::Ending { path: other.clone() });
        assert!(error.to_string().ends_with("ends in .svg or .png") && !other.exists(), "{error}");
    }

    /// Limits that are no range are an error, not a default.
    #[test]
    fn ranges_are_ranges() {
        let figure = || Figure::panel("Line", "x", "y").line("", 0, [(1.0, 1.0), (2.0, 2.0)]);
        assert!(Sheet::new(1, (400, 300)).with(figure().x_range(0.0..3.0)).svg().is_ok());
        let mistaken = [
            (figure().x_range(3.0..0.0), 'x', [3.0, 0.0]),
            (figure().y_range(1.0..1.0), 'y', [1.0, 1.0]),
            (figure().y_range(0.0..f64::INFINITY), 'y', [0.0, f64::INFINITY]),
            (figure().log_log().x_range(-1.0..10.0), 'x', [-1.0, 10.0]),
        ];
        for (figure, of_axis, limits) in mistaken {
            for error in [
                Sheet::new(1, (400, 300)).with(figure.clone()).svg().unwrap_err(),
                Sheet::new(1, (400, 300)).with(figure.clone()).png().unwrap_err(),
            ] {
                let PlotError::Range { axis, from, to, .. } = error else { panic!("{error}") };
                assert_eq!((axis, [from, to]), (of_axis, limits));
            }
        }
    }

    /// A line of many points has its extremes, wherever they are among the points; points that fill the plane are dots, not chords.
    #[test]
    fn long_lines_show_what_the_path_does() {
        let svg = |figure| Sheet::new(1, (1280, 880)).with(figure).svg().unwrap();
        let figure = |points: Vec<(f64, f64)>| Figure::panel("", "", "").line("", 0, points);
        let polylines = |svg: &str| -> Vec<(i32, i32)> {
            let lines = svg.lines().filter(|line| line.starts_with("<polyline") && line.contains("#0072B2"));
            let points = lines.flat_map(|line| {
                line.split_once("points=\"").unwrap().1.split('"').next().unwrap().split(' ')
            });
            let points = points.filter(|point| !point.is_empty()).map(|point| point.split_once(',').unwrap());
            points.map(|(x, y)| (x.parse().unwrap(), y.parse().unwrap())).collect()
        };

        let spike = |i: i32| if i == 77_777 { 1.0 } else { 0.0 };
        let line = polylines(&svg(figure((0..100_000).map(|i| (f64::from(i), spike(i))).collect())));
        let [top, bottom] = [line.iter().map(|at| at.1).min(), line.iter().map(|at| at.1).max()];
        assert!(
            bottom.unwrap() - top.unwrap() > 500 && line.len() < 6000,
            "{top:?} {bottom:?} {}",
            line.len()
        );

        // Random points, each far from the one before: pixels of a chord between them are none of the path.
        let mut word = 1_u64;
        let mut uniform = move || {
            word = word.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (word >> 11) as f64 / (1_u64 << 53) as f64
        };
        let cloud = svg(figure((0..100_000).map(|_| (uniform(), uniform())).collect()));
        assert!(polylines(&cloud).is_empty());
        assert!(cloud.matches("<circle").count() > 50_000);
    }

    /// A point of a sheet is where its figure is: right of the first, below the first row.
    #[test]
    fn sheets_place_figures_in_rows() {
        let figure = || Figure::panel("", "", "").line("", 0, [(0.0, 0.0), (1.0, 1.0)]);
        let sheet = (0..3).map(|_| figure()).fold(Sheet::new(2, (400, 300)), Sheet::with);
        let svg = sheet.svg().unwrap();
        assert!(svg.contains("width=\"800\" height=\"600\""), "{}", &svg[..200]);
        let curves = svg.lines().filter(|line| line.contains("#0072B2"));
        let starts: Vec<(i32, i32)> = curves
            .map(|line| {
                let (_, points) = line.split_once("points=\"").unwrap();
                let (x, y) = points.split_once(' ').unwrap().0.split_once(',').unwrap();
                (x.parse().unwrap(), y.parse().unwrap())
            })
            .collect();
        let [first, second, third] = starts[..] else { panic!("{starts:?}") };
        assert_eq!((second.0 - first.0, second.1 - first.1), (400, 0));
        assert_eq!((third.0 - first.0, third.1 - first.1), (0, 300));
        // Too small to see, but not to draw.
        for size in [(1, 1), (90, 400), (139, 20)] {
            assert!(Sheet::new(1, size).with(figure()).svg().is_ok(), "{size:?}");
        }
    }
}
