//! Close encounters by steps that follow the motion: error against evaluations of the force and time.
//!
//! `cargo bench --workspace --bench clock` prints the tables of `docs/guide/clock.md`; a name after `--` picks, as in `-- burrau`. The ends of the orbits are solutions to 20 digits and more, by a Taylor method in 128 bits
//! (Kepler's by his equation). `python3 benches/clock/heyoka_clock.py` runs some by heyoka.

#![allow(clippy::print_stdout, reason = "a benchmark talks")]

use std::error::Error;
use std::f64::consts::PI;
use std::time::Instant;

use wzvi::prelude::*;
use wzvi::report::duration;
use wzvi::state::Vector;

#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) - 1.0 / (x * x + y * y).sqrt(),
    clock = curvature,
    embedding = [Gauss<8>, Clocked<Verlet>, Clocked<Gauss<8>>, Extended<Gauss<8>>, Extended<Verlet>, Logarithmic<1, 1>],
)]
struct Kepler;

/// The planar restricted problem of three bodies, in the rotating frame, with the small body to the left.
#[hamiltonian(
    drift = |[x, y], [px, py]| {
        let (large, small) = ((x - mu).hypot(y), (x + 1.0 - mu).hypot(y));
        0.5 * (px * px + py * py) + y * px - x * py - (1.0 - mu) / large - mu / small
    },
    clock = curvature,
    embedding = [Gauss<8>, Clocked<Gauss<8>>, Extended<Gauss<8>>],
)]
struct Restricted {
    mu: f64,
}

/// Three bodies in the plane.
#[hamiltonian(
    drift = |q: [[f64; 2]; 3], p: [[f64; 2]; 3]| {
        let mut h = 0.0;
        for i in 0..3 {
            h += 0.5 * (p[i][0].powi(2) + p[i][1].powi(2)) / m[i];
            for j in 0..i {
                h -= m[i] * m[j] / ((q[i][0] - q[j][0]).powi(2) + (q[i][1] - q[j][1]).powi(2)).sqrt();
            }
        }
        h
    },
    clock = pairs,
    embedding = [Gauss<8>, Clocked<Gauss<8>>, Extended<Gauss<8>>, Logarithmic<1, 1>],
)]
struct ThreeBodies {
    m: [f64; 3],
}

#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py + x * x + y * y) + x * x * y - y * y * y / 3.0,
    clock = curvature(0.1),
    embedding = [Gauss<8>, Clocked<Gauss<8>>],
)]
struct HenonHeiles;

/// Repetitions of a run, of which the fastest counts.
const REPETITIONS: usize = 3;

fn main() -> Result<(), Box<dyn Error>> {
    let only = std::env::args().skip(1).find(|argument| !argument.starts_with("--"));
    let wanted = |name: &str| only.as_ref().is_none_or(|only| name.contains(only.as_str()));
    for e in [0.9, 0.99, 0.999] {
        if wanted(&format!("kepler{e}")) {
            kepler(e)?;
        }
    }
    if wanted("restricted") {
        restricted()?;
    }
    if wanted("arenstorf") {
        arenstorf()?;
    }
    if wanted("burrau") {
        burrau()?;
    }
    if wanted("henon_heiles") {
        henon_heiles()?;
    }
    Ok(())
}

/// A problem: its start, its end and the solution there.
struct Problem<'p, H: Hamiltonian> {
    system: &'p H,
    start: State<H::Vector>,
    end: f64,
    solution: Vec<f64>,
}

impl<H: Hamiltonian<Vector: Copy>> Problem<'_, H> {
    /// Runs it, and prints a line.
    fn row<E>(&self, name: &str, size: f64, evaluations_of_a_step: u64) -> Result<(), wzvi::Error>
    where
        H: Discretized<E>,
    {
        let run = || {
            let run = wzvi::simulate::Simulation::<H, E>::new(self.system, size).start(self.start);
            run.until(self.end).record_every(0).unwatched().quiet().run()
        };
        let (mut fastest, mut last) = (f64::INFINITY, None);
        for _ in 0..REPETITIONS {
            let began = Instant::now();
            match run() {
                Ok(path) => last = Some(path),
                Err(error) => {
                    println!("  {name:42} {size:7} {error}");
                    return Ok(());
                }
            }
            fastest = fastest.min(began.elapsed().as_secs_f64());
        }
        let Some(path) = last else { return Ok(()) };
        let found = path.last().q.components().iter();
        let error =
            found.zip(&self.solution).map(|(found, exact)| (found - exact).powi(2)).sum::<f64>().sqrt();
        let stages = path.iterations().total * 8;
        let evaluations =
            if evaluations_of_a_step == 0 { stages } else { path.steps() * evaluations_of_a_step };
        let energy = self.system.energy(path.last()) - self.system.energy(&self.start);
        println!(
            "  {name:42} {size:7} {:7} steps {:6.1}k evaluations, position off by {error:.1e}, energy by {:.1e}, {}",
            path.steps(),
            evaluations as f64 / 1e3,
            energy.abs(),
            duration(fastest),
        );
        Ok(())
    }
}

fn kepler(e: f64) -> Result<(), wzvi::Error> {
    let end = 20.0 * PI + 1.0;
    println!("\nKepler, e = {e}: ten periods and 1");
    let mut anomaly = 1.0 + e;
    for _ in 0..80 {
        anomaly -= (anomaly - e * anomaly.sin() - 1.0) / (1.0 - e * anomaly.cos());
    }
    let solution = vec![anomaly.cos() - e, (1.0 - e * e).sqrt() * anomaly.sin()];
    let start = State::new([1.0 - e, 0.0], [0.0, ((1.0 + e) / (1.0 - e)).sqrt()]);
    let problem = Problem { system: &Kepler, start, end, solution };
    problem.row::<Gauss<8>>("Gauss<8>", 0.02, 0)?;
    for eps in [0.5, 0.25] {
        problem.row::<Clocked<Gauss<8>>>("Clocked<Gauss<8>>", eps, 0)?;
    }
    for eps in [0.7, 0.35] {
        problem.row::<Extended<Gauss<8>>>("Extended<Gauss<8>>", eps, 0)?;
    }
    for eps in [0.3, 0.15] {
        problem.row::<Composed<Clocked<Verlet>, KahanLi8>>("Composed<Clocked<Verlet>, KahanLi8>", eps, 17)?;
        problem.row::<Composed<Extended<Verlet>, KahanLi8>>(
            "Composed<Extended<Verlet>, KahanLi8>",
            eps,
            17,
        )?;
    }
    for eps in [0.5, 0.2, 0.1] {
        problem.row::<Composed<Logarithmic<1, 1>, KahanLi8>>(
            "Composed<Logarithmic<1, 1>, KahanLi8>",
            eps,
            17,
        )?;
    }
    Ok(())
}

fn restricted() -> Result<(), wzvi::Error> {
    println!("\nRestricted three bodies to t = 2000 (chaotic: no program keeps the position)");
    let system = Restricted { mu: 0.01 };
    let start = State::new([-0.8, 0.0], [0.0, -0.627_641_065_392_069_4]);
    let solution = vec![-0.615_529_787_646_633_9, 0.468_212_049_250_793_07];
    let problem = Problem { system: &system, start, end: 2000.0, solution };
    problem.row::<Gauss<8>>("Gauss<8>", 0.05, 0)?;
    for eps in [0.7, 0.5, 0.35] {
        problem.row::<Clocked<Gauss<8>>>("Clocked<Gauss<8>>", eps, 0)?;
        problem.row::<Extended<Gauss<8>>>("Extended<Gauss<8>>", eps, 0)?;
    }
    Ok(())
}

fn arenstorf() -> Result<(), wzvi::Error> {
    println!("\nArenstorf's orbit, one period");
    // The large body is to the left: a turn by half a revolution.
    let system = Restricted { mu: 0.012_277_471 };
    let (x, v) = (0.994, -2.001_585_106_379_082_4);
    let start = State::new([-x, 0.0], [0.0, -(v + x)]);
    let solution = vec![-0.993_999_999_999_908_8, 3.030_943_022_982_418e-13];
    let problem = Problem { system: &system, start, end: 17.065_216_560_157_964, solution };
    problem.row::<Gauss<8>>("Gauss<8>", 0.02, 0)?;
    for eps in [0.7, 0.5, 0.35] {
        problem.row::<Clocked<Gauss<8>>>("Clocked<Gauss<8>>", eps, 0)?;
        problem.row::<Extended<Gauss<8>>>("Extended<Gauss<8>>", eps, 0)?;
    }
    Ok(())
}

fn burrau() -> Result<(), wzvi::Error> {
    println!("\nBurrau's three bodies to t = 63");
    let system = ThreeBodies { m: [3.0, 4.0, 5.0] };
    let start = State::new([1.0, 3.0, -2.0, -1.0, 1.0, -1.0], [0.0; 6]);
    let solution = vec![
        2.839_433_972_491_500_3,
        8.112_854_442_046_96,
        -0.463_420_279_975_119_1,
        -2.852_228_362_934_024,
        -1.332_924_159_514_805,
        -2.585_929_964_470_377,
    ];
    let problem = Problem { system: &system, start, end: 63.0, solution };
    problem.row::<Gauss<8>>("Gauss<8>", 0.01, 0)?;
    for eps in [0.4, 0.3, 0.2] {
        problem.row::<Clocked<Gauss<8>>>("Clocked<Gauss<8>>", eps, 0)?;
        problem.row::<Extended<Gauss<8>>>("Extended<Gauss<8>>", eps, 0)?;
    }
    for eps in [0.1, 0.05, 0.02] {
        problem.row::<Composed<Logarithmic<1, 1>, KahanLi8>>(
            "Composed<Logarithmic<1, 1>, KahanLi8>",
            eps,
            17,
        )?;
    }
    Ok(())
}

fn henon_heiles() -> Result<(), wzvi::Error> {
    println!("\nHénon and Heiles to t = 200, where no clock is needed");
    let start = State::new([0.0, 0.1], [(2.0_f64 * (1.0 / 12.0 - 0.005 + 0.001 / 3.0)).sqrt(), 0.0]);
    let solution = vec![0.058_050_493_961_036_75, 0.268_685_327_162_372];
    let problem = Problem { system: &HenonHeiles, start, end: 200.0, solution };
    for h in [0.7, 0.4] {
        problem.row::<Gauss<8>>("Gauss<8>", h, 0)?;
    }
    for eps in [0.7, 0.4] {
        problem.row::<Clocked<Gauss<8>>>("Clocked<Gauss<8>>", eps, 0)?;
    }
    Ok(())
}
