//! The table as a program in C sees it, and its runs beside those of Rust.

#![allow(unsafe_code, clippy::unwrap_used, reason = "the functions for C, in tests")]

use std::collections::BTreeMap;
use std::ffi::{CStr, CString, c_char};
use std::mem::MaybeUninit;
use std::thread;
use std::time::{Duration, Instant};

use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};
use wzvi::exported::{Exported, Given, GivenNumbers};
use wzvi::prelude::*;
use wzvi_c::chaos::{INDICATORS, LYAPUNOV, MAP, TANGENT};
use wzvi_c::settings::COMMON;
use wzvi_c::table::{AXES, DONE, FAILED, PARTIAL, Table, Task};

#[path = "../examples/systems/definitions.rs"]
mod definitions;

use definitions::{Kubo, Network, Pendulum};

wzvi_c::export!(Kubo, Pendulum, Network);

/// A task that is given back at its end.
struct Owned(Option<Box<Task>>);

impl Drop for Owned {
    fn drop(&mut self) {
        (wzvi_table().end)(self.0.take());
    }
}

/// Arrays with their shapes.
type Arrays = BTreeMap<String, (Vec<f64>, Vec<usize>)>;

impl Owned {
    fn begin(system: &str, kind: &str) -> Self {
        let [system, kind] = [system, kind].map(|text| CString::new(text).unwrap());
        // SAFETY: both end with a zero.
        Self(unsafe { (wzvi_table().begin)(Some(wzvi_table()), system.as_ptr(), kind.as_ptr()) })
    }

    fn real(self, name: &str, value: f64) -> Self {
        let name = CString::new(name).unwrap();
        // SAFETY: it ends with a zero.
        assert_eq!(unsafe { (wzvi_table().set_real)(self.0.as_deref(), name.as_ptr(), value) }, DONE);
        self
    }

    fn integer(self, name: &str, value: i64) -> Self {
        let name = CString::new(name).unwrap();
        // SAFETY: it ends with a zero.
        assert_eq!(unsafe { (wzvi_table().set_integer)(self.0.as_deref(), name.as_ptr(), value) }, DONE);
        self
    }

    fn text(self, name: &str, value: &str) -> Self {
        let [name, value] = [name, value].map(|text| CString::new(text).unwrap());
        // SAFETY: both end with a zero.
        assert_eq!(
            unsafe { (wzvi_table().set_text)(self.0.as_deref(), name.as_ptr(), value.as_ptr()) },
            DONE
        );
        self
    }

    fn reals(self, name: &str, values: &[f64], shape: &[usize]) -> Self {
        assert_eq!(values.len(), shape.iter().product::<usize>());
        let name = CString::new(name).unwrap();
        let set = wzvi_table().set_reals;
        // SAFETY: as many numbers as the shape says.
        let status =
            unsafe { set(self.0.as_deref(), name.as_ptr(), values.as_ptr(), shape.len(), shape.as_ptr()) };
        assert_eq!(status, DONE);
        self
    }

    fn integers(self, name: &str, values: &[i64], shape: &[usize]) -> Self {
        assert_eq!(values.len(), shape.iter().product::<usize>());
        let name = CString::new(name).unwrap();
        let set = wzvi_table().set_integers;
        // SAFETY: as many numbers as the shape says.
        let status =
            unsafe { set(self.0.as_deref(), name.as_ptr(), values.as_ptr(), shape.len(), shape.as_ptr()) };
        assert_eq!(status, DONE);
        self
    }

    fn run(&self) -> i32 {
        (wzvi_table().run)(self.0.as_deref())
    }

    fn error(&self) -> (String, String) {
        let [code, text] = [wzvi_table().code, wzvi_table().error].map(|of| words(of(self.0.as_deref())));
        (code, text)
    }

    fn arrays(&self) -> Arrays {
        let count = (wzvi_table().results)(self.0.as_deref());
        (0..count).map(|index| self.array(index)).collect()
    }

    fn array(&self, index: usize) -> (String, (Vec<f64>, Vec<usize>)) {
        let (mut name, mut values) = (MaybeUninit::uninit(), MaybeUninit::uninit());
        let mut shape = [MaybeUninit::new(0); AXES];
        let of = wzvi_table().result;
        let axes = of(self.0.as_deref(), index, Some(&mut name), Some(&mut values), Some(&mut shape));
        // SAFETY: the array exists, so that all three were written.
        let (name, values, shape) = unsafe {
            (name.assume_init(), values.assume_init(), shape.map(|length| MaybeUninit::assume_init(length)))
        };
        let shape = shape[..axes].to_vec();
        // SAFETY: the table says so.
        let values = unsafe { std::slice::from_raw_parts(values, shape.iter().product()) };
        (words(name), (values.to_vec(), shape))
    }

    /// The arrays of a run without an error.
    fn finished(self) -> Arrays {
        let status = self.run();
        assert_eq!(status, DONE, "{:?}", self.error());
        self.arrays()
    }

    /// Kind and text of the error of a run that fails.
    fn refused(self) -> (String, String) {
        assert_eq!(self.run(), FAILED, "{:?}", self.arrays());
        assert!(self.arrays().is_empty());
        self.error()
    }
}

fn words(text: *const c_char) -> String {
    // SAFETY: the table's texts end with a zero.
    unsafe { CStr::from_ptr(text) }.to_str().unwrap().to_owned()
}

fn kubo(kind: &str) -> Owned {
    let task = Owned::begin("Kubo", kind).real("parameter.a", 1.5).real("parameter.sigma", 1.0);
    task.real("h", 0.02).reals("q", &[0.0], &[1]).reals("p", &[1.0], &[1])
}

fn pendulum(kind: &str, scheme: &str) -> Owned {
    let task = Owned::begin("Pendulum", kind).real("parameter.g", 9.81).text("scheme", scheme);
    task.reals("q", &[2.0], &[1]).reals("p", &[0.0], &[1])
}

const PENDULUM: Pendulum = Pendulum { g: 9.81 };

fn start() -> SystemState<Pendulum> {
    State::new([2.0], [0.0])
}

#[test]
fn a_path_has_its_crossings_observables_and_increments() {
    let system = Kubo { a: 1.5, sigma: 1.0 };
    let run = system.simulate::<Midpoint>(0.02).start(State::new([0.0], [1.0])).noise(Wiener::seed(3));
    let path = run.section_towards(Direction::Rising, |s| s.q[0]).until(20.0).run().unwrap();
    let task = kubo("path").text("noise", "wiener").integer("seed", 3).real("until", 20.0);
    let arrays = task.text("sections", "+q").text("observe", "radius\naction").finished();
    let of = |name: &str| arrays[name].0.clone();
    assert_eq!(arrays["q"].1, [1001, 1]);
    assert_eq!(of("t"), path.times().collect::<Vec<_>>());
    assert_eq!(of("q"), path.iter().map(|s| s.q[0]).collect::<Vec<_>>());
    assert_eq!(of("p"), path.iter().map(|s| s.p[0]).collect::<Vec<_>>());
    assert_eq!(of("energy"), path.iter().map(|s| system.energy(s)).collect::<Vec<_>>());
    assert_eq!(of("invariant.action"), path.iter().map(|s| system.invariant(0, s)).collect::<Vec<_>>());
    assert_eq!(of("observed.action"), of("invariant.action"));
    let radius = |s: &SystemState<Kubo>| (s.q[0] * s.q[0] + s.p[0] * s.p[0]).sqrt();
    assert_eq!(of("observed.radius"), path.iter().map(radius).collect::<Vec<_>>());
    assert_eq!(of("dw"), path.increments().flatten().copied().collect::<Vec<_>>());
    assert!(!path.crossings().is_empty());
    assert_eq!(
        of("crossings.t"),
        path.crossings().iter().map(|crossing| crossing.state.t).collect::<Vec<_>>()
    );
    assert!(of("crossings.direction").iter().all(|direction| *direction == 1.0));
    let task = pendulum("path", "Midpoint").real("h", 0.01).integer("steps", 1);
    assert_eq!(
        (task.run(), words((wzvi_table().columns)(task.0.as_deref()))),
        (DONE, "t\nangle\nmomentum".into())
    );
    // The increments that came out, as given ones, give the same path.
    let given = kubo("path").reals("increments", &of("dw"), &[1000]).real("until", 20.0).finished();
    assert_eq!(given["q"], arrays["q"]);
}

#[test]
fn a_run_ends_where_it_is_told() {
    let run = PENDULUM.simulate::<Midpoint>(0.01).start(start()).until(10.0);
    let path = run.on_towards(Direction::Falling, |s| s.q[0], |_| wzvi::events::Terminal).run().unwrap();
    let task = pendulum("path", "Midpoint").real("h", 0.01).real("until", 10.0);
    let arrays = task.text("end_at", "-angle").finished();
    let last = |name: &str| *arrays[name].0.last().unwrap();
    assert_eq!([last("t"), last("q"), last("p")], [path.last().t, path.last().q[0], path.last().p[0]]);
    assert!(path.last().t < 1.0 && last("q").abs() < 1e-12);
    assert_eq!(arrays["events.t"].0, [path.last().t]);
}

#[test]
fn schemes_with_a_clock_take_a_fraction() {
    let path = PENDULUM.simulate::<Clocked<Verlet>>(Eps(0.05)).start(start()).until(5.0).run().unwrap();
    let task = || pendulum("path", "Clocked<Verlet>").real("until", 5.0);
    let arrays = task().real("eps", 0.05).finished();
    assert_eq!(arrays["q"].0, path.iter().map(|s| s.q[0]).collect::<Vec<_>>());
    assert_eq!(
        arrays["intervals.h"].0,
        path.intervals().iter().map(|interval| interval.h).collect::<Vec<_>>()
    );
    let (code, text) = task().real("h", 0.05).refused();
    assert!(code == "setting" && text.contains("`eps`"), "{text}");
    let (_, text) = pendulum("path", "Midpoint").real("eps", 0.05).real("until", 5.0).refused();
    assert!(text.contains("`h`, a time"), "{text}");
}

#[test]
fn a_scheme_beside_the_embeddings_is_exported() {
    let scheme = "Composed<Verlet, KahanLi8>";
    let arrays = pendulum("path", scheme).real("h", 0.05).real("until", 5.0).finished();
    let run = PENDULUM.simulate::<Composed<Verlet, KahanLi8>>(0.05).start(start());
    let path = run.until(5.0).run().unwrap();
    assert_eq!(arrays["q"].0, path.iter().map(|s| s.q[0]).collect::<Vec<_>>());
}

#[test]
fn an_ensemble_has_the_statistics_of_rust() {
    let system = Kubo { a: 1.5, sigma: 1.0 };
    let run = system.ensemble::<Midpoint>(0.02).start(State::new([0.0], [1.0])).paths(700).seed(7).until(2.0);
    let run =
        run.observe("q", |s| s.q[0]).observe("energy", |s| system.energy(s)).record_every(50).quantiles();
    let run = run.histogram("q", -1.5, 1.5, 30).first_passage("p", |s| s.p[0]).keep_paths(1 << 20);
    let statistics = run.run().unwrap();
    let task = kubo("ensemble").integer("paths", 700).integer("seed", 7).real("until", 2.0);
    let task = task.text("observe", "q\nenergy").integer("record_every", 50).integer("covariances", 1);
    let task = task.reals("quantiles", &[0.1, 0.5], &[2]).text("histograms", "q");
    let task = task.reals("ranges", &[-1.5, 1.5, 30.0], &[1, 3]).text("passages", "p");
    let arrays = task.integer("keep_paths", 1 << 20).finished();
    let of = |name: &str| arrays[name].0.clone();
    let nodes = statistics.nodes();
    let each = |value: &dyn Fn(&wzvi::ensemble::StatisticsNode, usize) -> f64| {
        nodes.iter().flat_map(|node| [value(node, 0), value(node, 1)]).collect::<Vec<_>>()
    };
    assert_eq!(arrays["mean"].1, [3, 2]);
    assert_eq!(of("mean"), each(&|node, index| node.mean(index)));
    assert_eq!(of("error"), each(&|node, index| node.standard_error(index)));
    assert_eq!(arrays["covariance"].1, [3, 2, 2]);
    assert_eq!(
        of("covariance")[8..12],
        [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(a, b)| nodes[2].covariance(a, b))
    );
    assert_eq!(of("quantiles")[9], nodes[2].quantiles(0).unwrap().at(0.5));
    let counts = nodes[2].histograms()[0].counts().iter().map(|count| *count as f64).collect::<Vec<_>>();
    assert_eq!(of("histogram.q")[60..90], counts[..]);
    assert_eq!(of("passage.p")[3], statistics.passages()[0].mean());
    assert_eq!(arrays["paths"].1, [700, 3, 2]);
    let of_path = |path: usize| statistics.paths().unwrap().at(path, 2).unwrap().to_vec();
    assert_eq!(of("paths")[699 * 6 + 4..], of_path(699));
}

#[test]
fn noises_of_ensembles_have_names() {
    let system = Kubo { a: 1.5, sigma: 1.0 };
    let run = system.ensemble::<Midpoint>(0.02).start(State::new([0.0], [1.0])).paths(40).until(1.0);
    let statistics = run.noise(Wiener::seed(5)).observe("q", |s| s.q[0]).run().unwrap();
    let task = kubo("ensemble").integer("paths", 40).integer("seed", 5).text("noise", "wiener");
    let arrays = task.real("until", 1.0).text("observe", "q").finished();
    assert_eq!(arrays["mean"].0.last(), Some(&statistics.mean("q").unwrap()));
    let task = kubo("ensemble").integer("paths", 40).integer("seed", 5).text("noise", "white");
    let (code, text) = task.real("until", 1.0).refused();
    assert!(code == "setting" && text.contains("`steps`, `wiener` and `wong-zakai`"), "{text}");
}

#[test]
fn antithetic_pairs_are_those_of_rust() {
    let system = Kubo { a: 1.5, sigma: 1.0 };
    let run = system.ensemble::<Midpoint>(0.02).start(State::new([0.0], [1.0])).paths(40).until(1.0);
    let statistics = run.seed(5).antithetic().observe("q", |s| s.q[0]).run().unwrap();
    let task = || kubo("ensemble").integer("paths", 40).integer("seed", 5).integer("antithetic", 1);
    let arrays = task().real("until", 1.0).text("observe", "q").finished();
    assert_eq!(arrays["mean"].0.last(), Some(&statistics.mean("q").unwrap()));
    assert!(task().real("until", 1.0).text("noise", "wiener").refused().1.contains("`steps`"));
}

#[test]
fn a_sweep_is_its_systems() {
    let sweep = Owned::begin("Pendulum", "ensemble").integer("sweep", 3).text("scheme", "Midpoint");
    let sweep = sweep.reals("parameter.g", &[5.0, 7.0, 9.0], &[3]).real("h", 0.02).real("until", 3.0);
    let sweep = sweep.reals("q", &[2.0], &[1]).reals("p", &[0.0], &[1]).integer("keep_paths", 1 << 20);
    let arrays = sweep.text("observe", "angle\nenergy").finished();
    for (row, g) in [5.0, 7.0, 9.0].into_iter().enumerate() {
        let system = Pendulum { g };
        let path = system.simulate::<Midpoint>(0.02).start(start()).plain_sums().until(3.0).run().unwrap();
        let end = &arrays["paths"].0[row * 4 + 2..row * 4 + 4];
        assert_eq!(end, [path.last().q[0], system.energy(path.last())], "{g}");
    }
}

#[test]
fn starts_have_a_row_each() {
    let task = Owned::begin("Pendulum", "map").real("parameter.g", 1.0).text("scheme", "Midpoint");
    let task = task.reals("q", &[0.5, 3.1, 1.0], &[3, 1]).reals("p", &[0.0, 0.0, 0.5], &[3, 1]);
    let arrays = task.real("h", 0.1).real("until", 50.0).finished();
    assert_eq!(arrays["q"], (vec![0.5, 3.1, 1.0], vec![3, 1]));
    let starts = [[0.5, 0.0], [3.1, 0.0], [1.0, 0.5]].map(|[q, p]| State::new([q], [p]));
    let system = Pendulum { g: 1.0 };
    let map = system.ensemble::<Midpoint>(0.1).starts_from(starts).until(50.0).indicators().unwrap();
    assert_eq!(arrays["megno_mean"].0, map.megno_mean);
    assert_eq!(arrays["sali"].0, map.sali);
    let wrong = Owned::begin("Pendulum", "path").real("parameter.g", 1.0).text("scheme", "Midpoint");
    let wrong = wrong.reals("q", &[0.5, 3.1], &[2, 1]).reals("p", &[0.0, 0.0], &[2, 1]).real("h", 0.1);
    assert!(wrong.real("until", 1.0).refused().1.contains("one start"));
}

#[test]
fn exponents_indicators_and_derivatives_are_those_of_rust() {
    let task = |kind| pendulum(kind, "Midpoint").real("h", 0.05).real("until", 20.0);
    let run = || PENDULUM.simulate::<Midpoint>(0.05).start(start()).until(20.0);
    let spectrum = run().lyapunov().unwrap();
    assert_eq!(task("lyapunov").finished()["exponents"].0, spectrum.values);
    let indicators = run().record_every(100).indicators().unwrap();
    let arrays = task("indicators").integer("record_every", 100).finished();
    assert_eq!(arrays["megno_mean"].0, [indicators.megno_mean]);
    assert_eq!(arrays["gali"].0, indicators.gali);
    assert_eq!(arrays["series.sali"].0, indicators.series.unwrap().sali);
    let tangent = run().tangent_by(&["g"]).unwrap();
    let arrays = task("tangent").text("by", "g").finished();
    assert_eq!(arrays["by_start"].1, [2, 2]);
    let rows = [(0, 0), (0, 1), (1, 0), (1, 1)].map(|at| tangent.by_start[at]);
    assert_eq!(arrays["by_start"].0, rows);
    assert_eq!(arrays["by_parameters"].0, tangent.by_parameters.as_slice());
}

#[test]
fn errors_say_what_there_is() {
    let of = |task: Owned| task.refused();
    let (code, text) = of(Owned::begin("Cubo", "path"));
    assert!(code == "setting" && text.contains("`Kubo`, `Pendulum`, `Network`"), "{text}");
    let (_, text) = of(Owned::begin("Kubo", "walk"));
    assert!(text.contains("`walk`") && text.contains("`ensemble`"), "{text}");
    let (_, text) = of(pendulum("path", "Gauss<4>"));
    assert!(text.contains("`Midpoint`, `Clocked<Verlet>`, `Composed<Verlet, KahanLi8>`"), "{text}");
    let (_, text) = of(Owned::begin("Pendulum", "path"));
    assert!(text.contains("set `scheme`"), "{text}");
    let (_, text) = of(kubo("path").real("untill", 1.0));
    assert!(text.contains("`untill`") && text.contains("`until`") && text.contains("`sigma`"), "{text}");
    let (_, text) = of(kubo("path").real("until", 1.0));
    assert!(text.contains("set a `seed`"), "{text}");
    let (_, text) = of(kubo("ensemble").real("until", 1.0).integer("seed", 1).integer("path", 2));
    assert!(text.contains("no setting `path` of `ensemble`"), "{text}");
    let (_, text) = of(kubo("path").real("until", 1.0).integer("seed", -1));
    assert!(text.contains("`seed` is -1"), "{text}");
    let (code, text) = of(kubo("path").real("until", 1.0).integer("seed", 1).text("observe", "z"));
    assert!(code == "name" && text.contains("radius"), "{text}");
    let (_, text) = of(kubo("path").real("until", 1.0).integer("seed", 1).reals("q", &[0.0, 1.0], &[2]));
    assert!(text.contains("1 numbers") || text.contains("one for each degree"), "{text}");
    let (_, text) = of(Owned::begin("Kubo", "path").real("parameter.a", 1.0));
    assert!(text.contains("`sigma` is missing"), "{text}");
    let network = Owned::begin("Network", "path").real("parameter.k", 1.0).real("h", 0.1).real("until", 1.0);
    let network = network.integers("parameter.springs", &[0, 9], &[1, 2]);
    let (code, text) = of(network.reals("q", &[0.0, 1.0], &[2]).reals("p", &[0.0, 0.0], &[2]));
    assert!(code == "setting" && text.contains('9'), "{text}");
}

#[test]
fn a_path_that_fails_has_its_part() {
    let task = kubo("path").reals("increments", &[0.1, f64::NAN, 0.1], &[3]).integer("steps", 3);
    assert_eq!(task.run(), PARTIAL);
    let (code, text) = task.error();
    assert!(matches!(code.as_str(), "noise" | "step"), "{code}: {text}");
    assert_eq!(task.arrays()["t"].0.len(), 2);
}

#[test]
fn fields_are_made_of_what_fits() {
    struct Only(&'static str, GivenNumbers<'static>, &'static [usize]);
    impl wzvi::exported::GivenFields for Only {
        fn given(&self, name: &str) -> Option<Given<'_>> {
            let springs = Given { values: self.1, shape: self.2 };
            let k = Given { values: GivenNumbers::Integers(&[3]), shape: &[] };
            if name == self.0 { Some(springs) } else { (name == "k").then_some(k) }
        }
    }
    let network =
        Network::from_fields(&Only("springs", GivenNumbers::Integers(&[0, 1, 1, 2]), &[2, 2])).unwrap();
    assert_eq!((network.k, network.springs), (3.0, vec![[0, 1], [1, 2]]));
    let of = |values, shape| Network::from_fields(&Only("springs", values, shape)).unwrap_err().to_string();
    assert!(of(GivenNumbers::Integers(&[0, -1]), &[1, 2]).contains("`springs`"));
    assert!(of(GivenNumbers::Reals(&[0.0, 1.0]), &[1, 2]).contains("an integer"));
    assert!(of(GivenNumbers::Integers(&[0, 1, 2]), &[1, 3]).contains("length 2, not 3"));
    assert!(of(GivenNumbers::Integers(&[0]), &[]).contains("an array, not 0"));
}

#[test]
fn no_task_is_an_error() {
    let table: &Table = wzvi_table();
    assert_eq!((table.run)(None), FAILED);
    assert_eq!((table.results)(None), 0);
    assert!(!words((table.error)(None)).is_empty());
    (table.stop)(None);
    (table.progress)(None, None, None);
    (table.end)(None);
    // SAFETY: null pointers are refused.
    let none = unsafe { (table.set_real)(None, std::ptr::null(), 1.0) };
    assert_eq!(none, FAILED);
    let task = kubo("path");
    // SAFETY: as above.
    let statuses = unsafe {
        [
            (table.set_real)(task.0.as_deref(), std::ptr::null(), 1.0),
            (table.set_text)(task.0.as_deref(), c"noise".as_ptr(), std::ptr::null()),
            (table.set_reals)(task.0.as_deref(), c"q".as_ptr(), std::ptr::null(), 1, [1].as_ptr()),
            (table.set_reals)(task.0.as_deref(), c"q".as_ptr(), [1.0].as_ptr(), 9, [1].as_ptr()),
            (table.set_reals)(task.0.as_deref(), c"q".as_ptr(), [1.0].as_ptr(), 2, [usize::MAX, 2].as_ptr()),
            (table.set_real)(task.0.as_deref(), c"\xff".as_ptr(), 1.0),
        ]
    };
    assert_eq!(statuses, [FAILED; 6]);
    // More rows than memory has room for, without numbers.
    let none = |name| {
        let task = Owned::begin("Network", "path").real("parameter.k", 1.0).real("h", 0.1).real("until", 1.0);
        let task = task.integers("parameter.springs", &[0, 1], &[1, 2]).reals("q", &[0.0, 1.0], &[2]);
        task.reals("p", &[0.0, 0.0], &[2]).integers(name, &[], &[1 << 60, 0]).refused()
    };
    assert!(none("parameter.springs").1.contains("1152921504606846976 rows"));
    assert!(none("q").1.contains("`q` has the shape"));
    let (_, text) = kubo("map").integer("seed", 1).real("until", 1.0).integer("paths", 1 << 60).refused();
    assert!(text.contains("no memory for the starts"), "{text}");
    // SAFETY: as above.
    let nameless = Owned(unsafe { (table.begin)(Some(table), std::ptr::null(), std::ptr::null()) });
    assert_eq!(nameless.run(), FAILED);
}

/// A run of ten billion steps, or of a billion paths, ends soon after `stop`, and has what is done.
#[test]
fn any_thread_stops_a_run_and_sees_how_far_it_is() {
    let path =
        kubo("path").integer("seed", 1).integer("steps", 10_000_000_000).integer("record_every", 1 << 20);
    let ensemble = kubo("ensemble").integer("seed", 1).integer("steps", 20).integer("paths", 1_000_000_000);
    for task in [path, ensemble] {
        let status = thread::scope(|scope| {
            let running = scope.spawn(|| task.run());
            thread::sleep(Duration::from_millis(500));
            // Another thread has no other use of the task.
            let (count, error) = ((wzvi_table().results)(task.0.as_deref()), task.error().1);
            let (mut done, mut all) = (MaybeUninit::uninit(), MaybeUninit::uninit());
            (wzvi_table().progress)(task.0.as_deref(), Some(&mut done), Some(&mut all));
            let asked = Instant::now();
            (wzvi_table().stop)(task.0.as_deref());
            let status = running.join().unwrap();
            // A tenth of a second on idle cores; compilers may be at work beside.
            assert!(asked.elapsed() < Duration::from_secs(2), "{:?}", asked.elapsed());
            assert!(count == 0 && error.contains("another thread"), "{count}: {error}");
            // SAFETY: both were written.
            let (done, all) = unsafe { (done.assume_init(), all.assume_init()) };
            assert!(done > 0 && done < all, "{done} of {all}");
            status
        });
        assert_eq!((status, task.error().0.as_str()), (PARTIAL, "stopped"));
        assert!(!task.arrays()["t"].0.is_empty());
    }
}

#[test]
fn the_description_is_json_with_everything() {
    let text = words((wzvi_table().describe)(Some(wzvi_table())));
    let all: serde_json::Value = serde_json::from_str(&text).unwrap();
    let kubo = &all["systems"][0];
    assert_eq!(kubo["name"], "Kubo");
    assert_eq!(kubo["fields"][0]["doc"], "Mean angular frequency.");
    assert_eq!(kubo["schemes"][0]["order"], 2);
    assert!(kubo["schemes"][0]["equations"].as_str().unwrap().contains("Lagrangian"));
    assert_eq!(all["systems"][1]["schemes"][1]["has_clock"], true);
    assert_eq!(all["systems"][2]["fields"][1]["type"], "Vec<[usize; 2]>");
}

/// Settings at random: names of every kind, values of every type and shape. Nothing crashes, and what fails has
/// an error. Optimised builds try 10^5.
#[test]
fn no_setting_crashes() {
    let lists =
        [COMMON, wzvi_c::path::SETTINGS, wzvi_c::ensemble::SETTINGS, INDICATORS, LYAPUNOV, MAP, TANGENT];
    let parameters =
        ["parameter.a", "parameter.sigma", "parameter.k", "parameter.springs", "parameter.g", "nonsense", ""];
    let names: Vec<&str> = lists.concat().into_iter().chain(parameters).collect();
    const TEXTS: &[&str] =
        &["", "q", "+q\n-p", "energy", "steps", "wiener", "wong-zakai", "Midpoint", "t", "\n\n", "ä"];
    const REALS: &[f64] =
        &[0.0, 1.0, -1.0, 0.1, 1e-300, 1e300, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.5, 2.0, 7.0];
    const INTEGERS: &[i64] = &[0, 1, 2, 3, -1, 7, 100, i64::MAX, i64::MIN];
    let cases = if cfg!(miri) {
        10
    } else if cfg!(debug_assertions) {
        2_000
    } else {
        100_000
    };
    let mut random = ChaCha8Rng::seed_from_u64(20_261_129);
    let mut below = move |end: usize| (random.next_u64() % end as u64) as usize;
    let mut statuses = [0; 3];
    for _ in 0..cases {
        let system = ["Kubo", "Pendulum", "Network"][below(3)];
        let kind = ["path", "ensemble", "indicators", "lyapunov", "map", "tangent"][below(6)];
        // Half of the tasks would run, but for what follows.
        let mut task = match below(2) {
            0 => Owned::begin(system, kind),
            _ => {
                let task = Owned::begin("Kubo", kind).real("parameter.a", 1.5).real("parameter.sigma", 1.0);
                let task = task.reals("q", &[0.0], &[1]).reals("p", &[1.0], &[1]).real("h", 0.1);
                task.integer("seed", 1).integer("steps", 3)
            }
        };
        for _ in 0..below(4) {
            let name = names[below(names.len())];
            let shape: Vec<usize> = (0..below(4)).map(|_| below(4)).collect();
            let count: usize = shape.iter().product();
            task = match below(5) {
                0 => task.real(name, REALS[below(REALS.len())]),
                1 => task.integer(name, INTEGERS[below(INTEGERS.len())]),
                2 => task.text(name, TEXTS[below(TEXTS.len())]),
                3 => {
                    let values: Vec<_> = (0..count).map(|_| REALS[below(REALS.len())]).collect();
                    task.reals(name, &values, &shape)
                }
                _ => {
                    let values: Vec<_> = (0..count).map(|_| INTEGERS[below(INTEGERS.len())]).collect();
                    task.integers(name, &values, &shape)
                }
            };
        }
        // What would run for long ends at once: a run that is stopped before it begins.
        (wzvi_table().stop)(task.0.as_deref());
        let status = task.run();
        statuses[usize::try_from(status).unwrap()] += 1;
        let (code, text) = task.error();
        assert_eq!(status == DONE, text.is_empty(), "{code}: {text}");
        assert_ne!(code, "panic", "{text}");
        task.arrays();
    }
    assert!(statuses[0] > 0 && statuses[2] > 0 || cfg!(miri), "{statuses:?}");
}
