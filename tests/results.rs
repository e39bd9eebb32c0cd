//! Results that other programs read: tables of paths with the names of the closure, errors and facts as people see them.

#![allow(clippy::unwrap_used, reason = "a test stops at the first error")]

use std::fs;
use std::path::PathBuf;
use std::process::Command;

use wzvi::prelude::*;
use wzvi::table::Column;

#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) - 1.0 / (x * x + y * y).sqrt(),
    embedding = Verlet,
    invariant = [|[x, y], [px, py]| x * py - y * px],
)]
struct Kepler;

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

fn folder(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("results-{name}"));
    let _ = fs::remove_dir_all(&folder);
    folder
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
    let column = |name: &str| {
        let (_, column) = table.columns().iter().find(|(known, _)| known == name).unwrap();
        let Column::Number(entries) = column else { panic!("{name} has no numbers") };
        entries.clone()
    };
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
    let (path, folder) = (kepler(), folder("bits"));
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
    let (path, folder) = (shaken(), folder("pandas"));
    let table = path.table().energies(&Shaken { sigma: 0.3 }).increments();
    table.write_csv(folder.join("path.csv")).unwrap();
    table.write_json(folder.join("path.json")).unwrap();
    let mut command = Command::new(python);
    command.args(["-c", script]).arg(&folder);
    #[cfg(feature = "columnar")]
    {
        table.write_parquet(folder.join("path.parquet")).unwrap();
        command.arg("parquet");
    }
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
