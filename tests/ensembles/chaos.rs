//! Maps of chaos: the indicators of single paths, in lanes, on threads, and after a stop.

use std::sync::atomic::{AtomicU64, Ordering};

use fixtures::are_refused;
use fixtures::column;
use fixtures::files::empty_folder;
use fixtures::small::{HenonHeiles, Kubo};
use wzvi::chaos::Indicators;
use wzvi::ensemble::{Ensemble, InstructionSet};
use wzvi::nalgebra::SVector;
use wzvi::prelude::*;

/// Starts at energy 1/8 with `x = 0`, in rows of a grid.
fn grid(side: usize) -> Vec<State<SVector<f64, 2>>> {
    let places = (0..side * side).map(|k| [k / side, k % side].map(|i| (i as f64 + 0.5) / side as f64));
    let starts = places.filter_map(|[a, b]| {
        let (y, py) = (-0.4 + a, -0.5 + b);
        let square: f64 = 0.25 - y * y - py * py + 2.0 / 3.0 * y.powi(3);
        (square >= 0.0).then(|| State::new([0.0, y], [square.sqrt(), py]))
    });
    starts.collect()
}

fn map(side: usize) -> Ensemble<'static, HenonHeiles, Verlet> {
    HenonHeiles.ensemble(0.1).starts_from(grid(side)).until(30.0).quiet()
}

/// Roundings of `steps` steps, times the growth of a deviation.
fn agree(single: &Indicators, map: [f64; 5], bound: f64) {
    let Indicators { megno, megno_mean, sali, gali, fli, .. } = single;
    for (single, of_map) in [*megno, *megno_mean, *sali, gali[0], *fli].into_iter().zip(map) {
        assert!((single - of_map).abs() < bound, "{single} {of_map}");
    }
}

#[test]
fn each_start_has_the_indicators_of_its_path() {
    let all = map(6).indicators().unwrap();
    assert_eq!((all.starts.clone(), all.time, all.is_partial), (grid(6), 30.0, false));
    for (k, start) in grid(6).into_iter().enumerate().step_by(5) {
        let single = HenonHeiles.simulate::<Verlet>(0.1).start(start).until(30.0).indicators().unwrap();
        agree(&single, [all.megno[k], all.megno_mean[k], all.sali[k], all.gali[k], all.fli[k]], 1e-11);
    }
    // Implicit steps of stages, path by path.
    let implicit =
        HenonHeiles.ensemble::<Gauss<2>>(0.5).starts_from(grid(2)).until(20.0).indicators().unwrap();
    for (k, start) in grid(2).into_iter().enumerate() {
        let single = HenonHeiles.simulate::<Gauss<2>>(0.5).start(start).until(20.0).indicators().unwrap();
        let own = [&implicit.megno, &implicit.megno_mean, &implicit.sali, &implicit.gali, &implicit.fli];
        agree(&single, own.map(|list| list[k]), 1e-10);
    }
    // A shorter last step, in lanes.
    let shorter = map(2).until(3.04).indicators().unwrap();
    assert_eq!(shorter.time, 3.04);
    for (k, start) in grid(2).into_iter().enumerate() {
        let single = HenonHeiles.simulate::<Verlet>(0.1).start(start).until(3.04).indicators().unwrap();
        let own = [&shorter.megno, &shorter.megno_mean, &shorter.sali, &shorter.gali, &shorter.fli];
        agree(&single, own.map(|list| list[k]), 1e-13);
    }
    // Given deviations, and noise of its own for each path.
    let kubo = Kubo { a: 1.0, sigma: 0.5 };
    let given = [[1.0, 2.0], [-3.0, 1.0]];
    let many = kubo.ensemble::<Midpoint>(0.1).start(State::new([1.0], [0.0])).paths(3).seed(5).until(5.0);
    let many = many.deviations(given).indicators().unwrap();
    for k in 0..3 {
        let noise = StepNormals::seed(5).path(k as u64);
        let single = kubo.simulate::<Midpoint>(0.1).start(State::new([1.0], [0.0])).noise(noise).until(5.0);
        let single = single.deviations(given).indicators().unwrap();
        let own = [many.megno[k], many.megno_mean[k], many.sali[k], many.gali[k], many.fli[k]];
        agree(&single, own, 1e-12);
    }
}

#[test]
fn maps_have_the_same_bits_in_any_lanes_and_threads_and_after_a_stop() {
    let all = map(12).indicators().unwrap();
    assert_eq!(map(12).threads(1).indicators().unwrap(), all);
    assert_eq!(map(12).instructions(InstructionSet::Baseline).indicators().unwrap(), all);
    let file = empty_folder(env!("CARGO_TARGET_TMPDIR"), "chaos", "stop").join("map.checkpoint");
    let kept = || map(40).until(5.0).threads(1).checkpoint(Checkpoint::to(&file));
    let asked = AtomicU64::new(0);
    let stopped = kept().stop_when(|| asked.fetch_add(1, Ordering::Relaxed) > 2).indicators().unwrap();
    assert!(stopped.is_partial && stopped.starts.len() < grid(40).len(), "{}", stopped.starts.len());
    assert_eq!(kept().indicators().unwrap(), map(40).until(5.0).indicators().unwrap());
    let handle = Handle::new();
    handle.stop();
    assert!(map(6).handle(&handle).indicators().unwrap().is_partial);
}

/// In a bath, and with noise and friction that are part of the step.
#[hamiltonian(
    drift = |[x, y], [u, v]| 0.5 * (u * u + v * v) - x.cos() - y.cos() + 0.5 * (x - y).powi(2),
    friction = 0.2,
    temperature = 0.1,
    embedding = [Baoab, Gjf],
)]
struct Warm;

#[hamiltonian(
    drift = |[x, y], [u, v]| 0.5 * (u * u + v * v) - x.cos() - y.cos() + 0.5 * (x - y).powi(2),
    noise = [|[x, _], [_, v]| 0.2 * x + 0.1 * x * v],
    friction = 0.2,
    embedding = [Midpoint, Gauss<2>, DeltaPlus],
)]
struct Shaken;

/// Every scheme with a tangent has maps: of each path the numbers of its single run, and the same bits in any
/// lanes and on any threads.
#[test]
fn implicit_steps_noise_friction_and_baths_have_maps() {
    fn check<H, E>(system: &H, y: f64)
    where
        H: Discretized<E, Vector = SVector<f64, 2>> + Sync,
    {
        let starts = |k: usize| State::new([0.01 * k as f64, y], [0.3, -0.005 * k as f64]);
        let map = || {
            let starts = (0..37).map(starts);
            system.ensemble::<E>(0.1).starts_from(starts).seed(8).until(4.96).quiet()
        };
        let all = map().threads(2).indicators().unwrap();
        assert_eq!(map().threads(1).instructions(InstructionSet::Baseline).indicators().unwrap(), all);
        for k in [0, 17, 36] {
            let single =
                system.simulate::<E>(0.1).start(starts(k)).noise(StepNormals::seed(8).path(k as u64));
            let single = single.until(4.96).indicators().unwrap();
            let own = [all.megno[k], all.megno_mean[k], all.sali[k], all.gali[k], all.fli[k]];
            agree(&single, own, 1e-11);
        }
    }
    check::<_, Baoab>(&Warm, 2.9);
    check::<_, Gjf>(&Warm, 2.9);
    check::<_, Midpoint>(&Shaken, 2.9);
    check::<_, Gauss<2>>(&Shaken, 2.9);
    check::<_, Midpoint>(&HenonHeiles, 0.1);
    check::<_, Gauss<8>>(&HenonHeiles, 0.1);
    check::<_, DeltaPlus>(&HenonHeiles, 0.1);
}

#[test]
fn paths_that_escape_have_no_indicators_and_the_others_have() {
    let starts = [State::new([0.0, 1.5], [0.0, 0.9]), State::new([0.0, 0.1], [0.3, 0.0])];
    let run = || HenonHeiles.ensemble::<Verlet>(0.1).starts_from(starts).until(100.0);
    let map = run().indicators().unwrap();
    assert!(map.megno[0].is_nan() && map.sali[0].is_nan() && map.megno[1].is_finite());
    assert_eq!(map.failures.iter().map(|failure| failure.path).collect::<Vec<_>>(), [0]);
    assert!(matches!(run().allow_losses(0.1).indicators(), Err(wzvi::Error::Losses(_))));
    // In lanes of implicit steps, too: the neighbours of a path without a solution have the bits that they
    // have alone.
    let beside = HenonHeiles.ensemble::<Midpoint>(0.1).starts_from(starts).until(30.0).indicators().unwrap();
    let alone =
        HenonHeiles.ensemble::<Midpoint>(0.1).starts_from([starts[1]]).until(30.0).indicators().unwrap();
    assert!(beside.megno[0].is_nan() && beside.megno[1] == alone.megno[0], "{beside:?} {alone:?}");
}

#[test]
fn maps_are_tables_and_pictures() {
    let map = map(6).indicators().unwrap();
    let table = map.table();
    let names: Vec<&str> = table.columns().iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["q1", "q2", "p1", "p2", "megno", "megno_mean", "sali", "gali_2", "fli"]);
    assert_eq!((table.rows(), column(&table, "sali")), (map.starts.len(), &map.sali[..]));
    let folder = empty_folder(env!("CARGO_TARGET_TMPDIR"), "chaos", "map");
    map.write_csv(folder.join("map.csv")).unwrap();
    map.write_parquet(folder.join("map.parquet")).unwrap();
    assert_eq!(
        std::fs::read_to_string(folder.join("map.csv")).unwrap().lines().count(),
        1 + map.starts.len()
    );

    let figure = map.plot().megno("q2", "p2").unwrap();
    let shades = figure.shades.as_ref().unwrap();
    // The spacing of the grid, a sixth.
    assert!((shades.cell.0 - 1.0 / 6.0).abs() < 1e-12 && (shades.cell.1 - 1.0 / 6.0).abs() < 1e-12);
    assert_eq!(shades.points.len(), map.starts.len());
    assert_eq!(figure.table().1.len(), map.starts.len());
    figure.write(folder.join("megno.svg")).unwrap();
    map.plot().sali("q2", "p2").unwrap().write(folder.join("sali.png")).unwrap();
    let svg = std::fs::read_to_string(folder.join("megno.svg")).unwrap();
    assert!(svg.contains("mean MEGNO") && svg.matches("<rect").count() > 64);
    assert!(
        map.plot().megno("y", "p2").unwrap_err().to_string().contains("there are `q1`, `q2`, `p1`, `p2`")
    );
}

#[test]
fn settings_without_meaning_are_refused() {
    are_refused(
        map(4).observe("x", |state| state.q[0]).indicators(),
        "`indicators` has no use for `observe`",
    );
    are_refused(map(4).record_every(2).indicators(), "has no use for `record_every`");
    are_refused(map(4).quantiles().indicators(), "has no use for `quantiles`");
    are_refused(map(4).until_error("q", 0.1).indicators(), "has no use for `until_error`");
    are_refused(map(4).inspect(|_, _| ()).indicators(), "has no use for `inspect`");
    are_refused(map(4).keep_paths(1 << 20).indicators(), "has no use for `keep_paths`");
    are_refused(map(4).retry(Retry::halving(2)).indicators(), "has no use for `retry`");
    are_refused(map(4).deviations([[1.0, 0.0, 0.0, 0.0]]).indicators(), "a map takes 2 deviations");
    are_refused(map(4).deviations([[1.0, 0.0, 0.0, 0.0]; 2]).indicators(), "deviation 1 is a sum");
    are_refused(map(4).start(State::new([0.0; 2], [0.0; 2])).indicators(), "leave one of them out");
    are_refused(HenonHeiles.ensemble::<Verlet>(0.1).until(1.0).indicators(), "a start: add");
    are_refused(map(4).paths(0).indicators(), "0 paths");
    let nan = [State::new([0.0, 0.1], [0.3, 0.0]), State::new([f64::NAN, 0.1], [0.3, 0.0])];
    are_refused(
        HenonHeiles.ensemble::<Verlet>(0.1).starts_from(nan).until(1.0).indicators(),
        "start of path 1",
    );
}
