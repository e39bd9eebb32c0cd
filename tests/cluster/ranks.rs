//! The program that runs on every rank, and how tests start it.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread::sleep;
use std::time::{Duration, Instant};

use wzvi::checkpoint::Checkpoint;
use wzvi::ensemble::Ensemble;
use wzvi::mpi::{self, Threading, traits::Communicator};
use wzvi::prelude::*;

use fixtures::edge::{EDGE, Edge, bits};

/// What ranks are to do: the plan, the folder, the number of paths.
const ORDERS: &str = "WZVI_TEST_CLUSTER";
/// A run that takes longer than this hangs. On an idle machine it takes a second.
const LONGEST: Duration = Duration::from_secs(180);

/// How long a rank sleeps that stalls.
pub(crate) const STALL: Duration = Duration::from_secs(15);

/// A standard error, which some hundred blocks reach.
pub(crate) const TARGET: f64 = 1e-3;

/// Something to go wrong, or nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Plan {
    Plain,
    /// So many threads on each rank.
    Threads,
    /// With a checkpoint.
    Kept,
    /// Until an error is small enough.
    Target,
    /// The last rank says that the run is to be stopped.
    Stops,
    /// As soon as the checkpoint has some blocks, the last rank dies.
    Dies,
    /// The same run, in which nobody dies.
    Survives,
    /// The last rank panics.
    Panics,
    /// Rank 0 panics.
    RootPanics,
    /// The last rank has another seed.
    OtherSeed,
    /// The last rank has no paths to run.
    Mistaken,
    /// A checkpoint that cannot be written.
    Unwritable,
    /// A checkpoint that someone else takes.
    Taken,
    /// MPI is told that there are no threads.
    Single,
    /// The last rank sleeps in the middle of a block.
    Stalls,
    /// It does, and rank 0 stops the run.
    StallsAndStops,
}

const PLANS: [Plan; 16] = [
    Plan::Plain,
    Plan::Threads,
    Plan::Kept,
    Plan::Target,
    Plan::Stops,
    Plan::Dies,
    Plan::Survives,
    Plan::Panics,
    Plan::RootPanics,
    Plan::OtherSeed,
    Plan::Mistaken,
    Plan::Unwritable,
    Plan::Taken,
    Plan::Single,
    Plan::Stalls,
    Plan::StallsAndStops,
];

/// The run of all plans.
pub(crate) fn run<'a>(paths: u64) -> Ensemble<'a, Edge, DeltaPlus> {
    EDGE.summed().paths(paths).threads(1)
}

/// With the paths themselves.
pub(crate) fn run_with_paths<'a>(paths: u64) -> Ensemble<'a, Edge, DeltaPlus> {
    run(paths).keep_paths(1 << 24)
}

/// Paths that a checkpoint has: its first line counts the chunks.
pub(crate) fn saved(checkpoint: &Path) -> u64 {
    let bytes = fs::read(checkpoint).unwrap_or_default();
    let line =
        String::from_utf8_lossy(bytes.split(|&byte| byte == b'\n').next().unwrap_or_default()).into_owned();
    64 * line.split(' ').nth(2).and_then(|chunks| chunks.parse::<u64>().ok()).unwrap_or(0)
}

#[test]
#[ignore = "what the other tests run on every rank"]
fn rank() {
    let Ok(orders) = std::env::var(ORDERS) else { return };
    let [plan, paths, folder] = orders.splitn(3, ' ').collect::<Vec<_>>()[..] else { panic!("{orders}") };
    let plan = *PLANS.iter().find(|known| format!("{known:?}") == plan).unwrap();
    let (paths, folder) = (paths.parse().unwrap(), Path::new(folder));
    let level = if plan == Plan::Single { Threading::Single } else { Threading::Funneled };
    let (universe, _) = mpi::initialize_with_threading(level).unwrap();
    let world = universe.world();
    let (rank, last) = (world.rank(), world.rank() + 1 == world.size());
    let file = folder.join("checkpoint");
    let kept = || run(paths).checkpoint(Checkpoint::to(&file).every_paths(10 * 512));
    let calls = AtomicU64::new(0);
    // Once or so per block: five nodes of 512 paths each.
    let at_each_block = |what: &dyn Fn()| {
        if calls.fetch_add(1, Ordering::Relaxed) % 2560 == 2559 {
            what();
        }
    };
    // From then on the last rank acts, and the others wait until it has: nobody finishes before.
    let begun = || saved(&file) >= 10 * 512;
    let ensemble = match plan {
        Plan::Plain | Plan::Single => run_with_paths(paths),
        Plan::Threads => run_with_paths(paths).threads(2),
        Plan::Kept => kept(),
        Plan::Target => run(paths).until_error("q", TARGET),
        Plan::Stops => kept().stop_when(|| {
            let stops = last && begun();
            if stops {
                fs::write(folder.join("stopped"), "").unwrap();
            }
            // Shortly each time: the last rank gets more to do, and is asked again, only when this one's block is merged.
            if begun() && !folder.join("stopped").exists() {
                sleep(Duration::from_millis(20));
            }
            stops
        }),
        Plan::Dies => kept().first_passage("event0", |state| {
            if last && state.t > 0.0 {
                at_each_block(&|| {
                    if saved(&file) >= 10 * 512 {
                        std::process::abort()
                    }
                });
            }
            1.0
        }),
        Plan::Survives => kept().first_passage("event0", |_| 1.0),
        Plan::Stalls | Plan::StallsAndStops => {
            let began = Instant::now();
            let stops = move || rank == 0 && began.elapsed() > Duration::from_secs(2);
            let ensemble = run(paths).first_passage("event0", move |state| {
                // In some block of its own, and once.
                if last && state.t > 0.0 && calls.fetch_add(1, Ordering::Relaxed) == 20 * 2560 {
                    sleep(STALL);
                }
                1.0
            });
            if plan == Plan::StallsAndStops { ensemble.stop_when(stops) } else { ensemble }
        }
        Plan::Panics | Plan::RootPanics => run(paths).observe("observable0", move |state| {
            assert!(state.t == 0.0 || (plan == Plan::RootPanics) != (rank == 0), "an observable that fails");
            0.0
        }),
        Plan::OtherSeed => run(paths).seed(if last { 8 } else { 7 }),
        Plan::Mistaken => run(if last { 0 } else { paths }),
        Plan::Unwritable => run(paths).checkpoint(Checkpoint::to(folder.join("missing").join("file"))),
        Plan::Taken => kept().first_passage("event0", |state| {
            if last && state.t > 0.0 {
                at_each_block(&|| {
                    if saved(&file) >= 10 * 512 {
                        fs::write(&file, "another").unwrap()
                    }
                });
            }
            1.0
        }),
    };
    let began = Instant::now();
    let text = match ensemble.run_on(&world) {
        Ok(Some(statistics)) => bits(&statistics),
        Ok(None) => "nothing".to_owned(),
        Err(error) => error.to_string(),
    };
    fs::write(folder.join(format!("took-{rank}")), began.elapsed().as_millis().to_string()).unwrap();
    fs::write(said(folder, rank), text).unwrap();
}

/// How long a rank was in its run.
pub(crate) fn took(folder: &Path, rank: i32) -> Duration {
    let text = fs::read_to_string(folder.join(format!("took-{rank}"))).unwrap();
    Duration::from_millis(text.parse().unwrap())
}

/// Where a rank writes what it got.
fn said(folder: &Path, rank: i32) -> PathBuf {
    folder.join(format!("rank-{rank}"))
}

/// What became of all ranks.
pub(crate) struct Ended {
    pub(crate) output: Output,
    /// What each rank got; `None` if it did not get that far.
    pub(crate) said: Vec<Option<String>>,
}

/// Starts so many ranks with a plan, in a folder.
pub(crate) fn on_ranks(ranks: i32, plan: Plan, paths: u64, folder: &Path) -> Ended {
    (0..ranks).for_each(|rank| drop(fs::remove_file(said(folder, rank))));
    let mut child = Command::new("mpirun")
        .args(["--allow-run-as-root", "--oversubscribe", "-n", &ranks.to_string()])
        .arg(std::env::current_exe().unwrap())
        .args(["cluster::ranks::rank", "--exact", "--ignored", "--quiet", "--nocapture"])
        .env(ORDERS, format!("{plan:?} {paths} {}", folder.display()))
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap_or_else(|error| panic!("mpirun of Open MPI is needed: {error}"));
    let began = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if began.elapsed() > LONGEST {
            // Unlike a kill, this lets it end the ranks.
            Command::new("kill").arg(child.id().to_string()).status().unwrap();
            panic!("{plan:?} on {ranks} ranks hangs");
        }
        sleep(Duration::from_millis(5));
    }
    let output = child.wait_with_output().unwrap();
    Ended { output, said: (0..ranks).map(|rank| fs::read_to_string(said(folder, rank)).ok()).collect() }
}

impl Ended {
    /// What rank 0 got, if the others ended well.
    pub(crate) fn well(self) -> String {
        let error = String::from_utf8_lossy(&self.output.stderr);
        assert!(self.output.status.success(), "{error}");
        let mut said = self.said.into_iter().map(Option::unwrap);
        let root = said.next().unwrap();
        assert!(said.all(|text| text == "nothing"));
        root
    }

    /// What the processes wrote to their standard errors, if they failed.
    pub(crate) fn badly(&self) -> String {
        assert!(!self.output.status.success());
        String::from_utf8_lossy(&self.output.stderr).into_owned()
    }
}
