//! Spins on spheres, without constraints: a Heisenberg ring whose spins are pairs of oscillators.
//!
//! `s = (q1 q2 + p1 p2, q1 p2 - q2 p1, (q1² + p1² - q2² - p2²)/2)/2` has the brackets of a spin, and the length
//! `(q1² + q2² + p1² + p2²)/4`. A function `H(s)` moves it by `s' = ∇H × s`. `Midpoint` conserves quadratic first
//! integrals, the lengths among them, with and without noise.
//!
//! Checked:
//! * A spin in a field B turns by `4 atan(h |B|/4)` in each step.
//! * A ring `H_0 = -J Σ s_i · s_{i+1}` over a million steps: lengths, total spin, energy.
//! * Every spin in a random field of its own, `H_ka = σ s_k^a` (Stratonovich): each bond decays by four double brackets
//!   `σ²/2 {H, {H, s_i · s_j}}`, so that `E H_0(t) = H_0(0) e^{-2σ²t}`. Then all spins are uniform on their spheres, and
//!   `E H_0² = N J²/3`: the lifted step conserves this law exactly, whatever its size.
//! * The same ring in the angle and the height of each spin: errors, times, and what happens at the poles.
//!
//! Run with `cargo run --release --features svg --example spins`.

#[path = "support/plot.rs"]
mod plot;
#[path = "support/table.rs"]
mod table;

use std::error::Error;
use std::time::Instant;

use wzvi::increments::Interval;
use wzvi::nalgebra::{DVector, Vector3};
use wzvi::plot::{Colour, Figure, Look};
use wzvi::prelude::*;

/// The spin of two oscillators.
#[hamiltonian_fn]
fn spin(q: [f64; 2], p: [f64; 2]) -> [f64; 3] {
    [
        0.5 * (q[0] * q[1] + p[0] * p[1]),
        0.5 * (q[0] * p[1] - q[1] * p[0]),
        0.25 * (q[0] * q[0] + p[0] * p[0] - q[1] * q[1] - p[1] * p[1]),
    ]
}

/// The spin at an angle and a height, which are a coordinate and its momentum.
#[hamiltonian_fn]
fn spin_at(angle: f64, height: f64) -> [f64; 3] {
    let radius = (1.0 - height * height).sqrt();
    [radius * angle.cos(), radius * angle.sin(), height]
}

#[hamiltonian_fn]
fn product(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// One spin in a field.
#[hamiltonian(drift = |q: [f64; 2], p: [f64; 2]| product(*field, spin(q, p)), embedding = Midpoint)]
struct Single {
    field: [f64; 3],
}

/// A ring of neighbours.
#[hamiltonian(
    drift = |q: &[[f64; 2]], p: &[[f64; 2]]| {
        let n = q.len();
        let bond = |i, j| -exchange * product(spin(q[i], p[i]), spin(q[j], p[j]));
        (0..n).map(|i| bond(i, (i + 1) % n)).sum::<f64>()
    },
    invariant = [
        x = |q, p| (0..q.len()).map(|i| spin(q[i], p[i])[0]).sum::<f64>(),
        y = |q, p| (0..q.len()).map(|i| spin(q[i], p[i])[1]).sum::<f64>(),
        z = |q, p| (0..q.len()).map(|i| spin(q[i], p[i])[2]).sum::<f64>(),
    ],
    embedding = [Midpoint, Gauss<8>],
)]
struct Ring {
    exchange: f64,
}

/// The ring in random fields.
#[hamiltonian(
    drift = |q: &[[f64; 2]], p: &[[f64; 2]]| {
        let n = q.len();
        let bond = |i, j| -exchange * product(spin(q[i], p[i]), spin(q[j], p[j]));
        (0..n).map(|i| bond(i, (i + 1) % n)).sum::<f64>()
    },
    noise = [
        [|q, p, k| sigma * spin(q[k], p[k])[0]; self.sites],
        [|q, p, k| sigma * spin(q[k], p[k])[1]; self.sites],
        [|q, p, k| sigma * spin(q[k], p[k])[2]; self.sites],
    ],
    embedding = Midpoint,
)]
struct Shaken {
    exchange: f64,
    sigma: f64,
    sites: usize,
}

/// The ring in angles and heights.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let n = q.len();
        let bond = |i, j| -exchange * product(spin_at(q[i], p[i]), spin_at(q[j], p[j]));
        (0..n).map(|i| bond(i, (i + 1) % n)).sum::<f64>()
    },
    embedding = Midpoint,
)]
struct Spherical {
    exchange: f64,
}

type Spins = State<DVector<f64>>;

const SITES: usize = 8;
const STEPS: u64 = 1_000_000;
const H: f64 = 0.1;
const SIGMA: f64 = 0.3;
const RING: Ring = Ring { exchange: 1.0 };
const SPHERICAL: Spherical = Spherical { exchange: 1.0 };
const SHAKEN: Shaken = Shaken { exchange: 1.0, sigma: SIGMA, sites: SITES };

fn main() -> Result<(), Box<dyn Error>> {
    single()?;
    let panels = [quiet()?, shaken()?, decaying()?, costs()?];
    println!();
    plot::save("spins", "ring", 2, (1000, 640), &panels)
}

/// The state of spins of length 1: `p1 = 0`. Spins near the south pole need another choice of this phase.
fn lift(spins: &[[f64; 3]]) -> Spins {
    let (mut q, mut p) = (Vec::new(), Vec::new());
    for &[x, y, z] in spins {
        let q1 = (2.0 * (1.0 + z)).sqrt();
        q.push([q1, 2.0 * x / q1]);
        p.push([0.0, 2.0 * y / q1]);
    }
    State::new(q, p)
}

/// The angles and heights of spins.
fn angles(spins: &[[f64; 3]]) -> Spins {
    let angles = spins.iter().map(|s| s[1].atan2(s[0])).collect::<Vec<_>>();
    State::new(angles, spins.iter().map(|s| s[2]).collect::<Vec<_>>())
}

fn from_angles(State { q, p, .. }: &Spins) -> Vec<[f64; 3]> {
    q.iter().zip(p.iter()).map(|(&angle, &height)| spin_at(angle, height)).collect()
}

fn spins(state: &Spins) -> Vec<[f64; 3]> {
    let [q, p] = state.points::<2>();
    q.iter().zip(p).map(|(&q, &p)| spin(q, p)).collect()
}

/// Spins of length 1 that turn around the axis, with waves of this size in their heights.
fn start(size: f64) -> Vec<[f64; 3]> {
    (0..SITES).map(|i| spin_at(0.8 * i as f64, size * (1.3 * i as f64 + 0.4).sin())).collect()
}

/// The largest error of a length along a path.
fn largest_length_error<E>(path: &Trajectory<DVector<f64>, E>) -> f64 {
    let lengths = path.iter().flat_map(spins).map(|s| product(s, s).sqrt());
    lengths.map(|length| (length - 1.0).abs()).fold(0.0, f64::max)
}

fn single() -> Result<(), Box<dyn Error>> {
    println!("1. One spin in a field: the angle of a step, beside 4 atan(h |B|/4) and the exact h |B|\n");
    let single = Single { field: [0.6, 0.0, 0.8] };
    let axis = Vector3::from(single.field);
    let mut rows = Vec::new();
    for h in [0.5, 1.0, 2.0, 4.0] {
        let path = single.simulate::<Midpoint>(h).start(State::new([2.0, 0.0], [0.0, 0.0])).steps(1).run()?;
        let across = |State { q, p, .. }: &SystemState<Single>| {
            let s: Vector3<f64> = spin((*q).into(), (*p).into()).into();
            s - axis * axis.dot(&s)
        };
        let (before, after) = (across(&path.states()[0]), across(path.last()));
        let angle =
            axis.dot(&before.cross(&after)).atan2(before.dot(&after)).rem_euclid(std::f64::consts::TAU);
        let expected = 4.0 * (h / 4.0_f64).atan();
        rows.push([format!("{h}"), format!("{angle:.12}"), format!("{expected:.12}"), format!("{h:.3}")]);
    }
    table::print(["h", "angle", "4 atan(h/4)", "exact"], &rows);
    Ok(())
}

/// The energy of the ring without noise.
fn quiet() -> Result<Figure, Box<dyn Error>> {
    println!("\n2. A ring of {SITES} spins, {STEPS} steps of {H}\n");
    let path = RING.simulate::<Midpoint>(H).start(lift(&start(0.7))).steps(STEPS).record_every(100).run()?;
    let total = (0..3).map(|axis| path.invariant_drift(&RING, axis)).collect::<Result<Vec<_>, _>>()?;
    let first = RING.energy(&path.states()[0]);
    table::print(
        ["without noise, largest error of", "", "of"],
        &[
            ["lengths".into(), format!("{:.1e}", largest_length_error(&path)), "1".into()],
            [
                "total spin".into(),
                format!("{:.1e}", total.into_iter().fold(0.0, f64::max)),
                format!("{SITES}"),
            ],
            ["energy".into(), format!("{:.1e}", path.energy_drift(&RING)), format!("{first:.3}")],
        ],
    );
    let energies = path.iter().step_by(5).map(|state| (state.t, RING.energy(state) - first));
    let figure = Figure::panel("Without noise: the energy does not drift", "time t", "H_0 - H_0(0)");
    Ok(figure.points(Look::Dots, "Midpoint, h = 0.1", Colour::BLUE, energies))
}

/// One spin of the ring in random fields.
fn shaken() -> Result<Figure, Box<dyn Error>> {
    let run = SHAKEN.simulate::<Midpoint>(H).start(lift(&start(0.7))).noise(Wiener::seed(1)).steps(STEPS);
    let path = run.record_every(100).run()?;
    // A bond decays in a time 1/2σ² = 6: what is left of the start, and the correlation of batches of a time 2000,
    // are below the errors.
    let (mut mean, mut square) = (table::Mean::default(), table::Mean::default());
    let energies: Vec<f64> = path.iter().skip(3).map(|state| SHAKEN.energy(state)).collect();
    for batch in energies.chunks_exact(200) {
        mean.add(batch.iter().sum::<f64>() / 200.0);
        square.add(batch.iter().map(|energy| energy * energy).sum::<f64>() / 200.0);
    }
    let show = |mean: &table::Mean| format!("{:.3} ± {:.3}", mean.value(), mean.standard_error());
    println!();
    table::print(
        ["in random fields", "", "uniform spins"],
        &[
            [
                "largest error of lengths".into(),
                format!("{:.1e}", largest_length_error(&path)),
                String::new(),
            ],
            ["mean of H_0".into(), show(&mean), "0".into()],
            ["mean of H_0²".into(), show(&square), format!("N J²/3 = {:.3}", SITES as f64 / 3.0)],
        ],
    );
    let first = path.iter().map(|state| spins(state)[0]).map(|[x, y, _]| (x, y));
    let figure = Figure::panel("In random fields: 10 000 states of one spin", "s_x", "s_y").equal_axes();
    Ok(figure.points(Look::Dots, "Midpoint, h = 0.1", Colour::BLUE, first))
}

/// The mean energy of many paths.
fn decaying() -> Result<Figure, Box<dyn Error>> {
    const PATHS: u64 = 4000;
    let (h, end) = (0.05, 10.0);
    let first = RING.energy(&lift(&start(0.7)));
    let run = SHAKEN.ensemble::<Midpoint>(h).start(lift(&start(0.7))).paths(PATHS).seed(3).until(end);
    let statistics = run.record_every(20).observe("energy", |state| SHAKEN.energy(state)).run()?;
    println!("\n3. Mean energy of {PATHS} paths with h = {h}, beside H_0(0) e^(-2σ²t), σ = {SIGMA}\n");
    let (mut rows, mut points) = (Vec::new(), Vec::new());
    for node in statistics.nodes() {
        let (t, energy, error) = (node.time(), node.mean(0), node.standard_error(0));
        let expected = first * (-2.0 * SIGMA * SIGMA * t).exp();
        points.push((t, energy));
        if [1.0, 2.0, 5.0, 10.0].contains(&t) {
            let off = (energy - expected) / error;
            rows.push([
                format!("{t}"),
                format!("{energy:.4} ± {error:.4}"),
                format!("{expected:.4}"),
                format!("{off:+.1}"),
            ]);
        }
    }
    table::print(["t", "mean energy", "expected", "off by (std. err.)"], &rows);
    let exact = (0..=100).map(|i| 0.1 * f64::from(i)).map(|t| (t, first * (-2.0 * SIGMA * SIGMA * t).exp()));
    Ok(Figure::panel("In random fields: mean energy of 4000 paths", "time t", "E H_0")
        .points(Look::Broad, "exact", Colour::GREY, exact)
        .points(Look::Dots, "Midpoint, h = 0.05", Colour::BLUE, points))
}

/// Errors and times of both kinds of variables.
fn costs() -> Result<Figure, Box<dyn Error>> {
    const END: f64 = 10.0;
    println!("\n4. Two oscillators for each spin, beside its angle and its height: the ring at t = {END}\n");
    let heights = start(0.4);
    let (lifted, angles) = (lift(&heights), angles(&heights));
    let exact = RING.simulate::<Gauss<8>>(0.02).start(lifted.clone()).until(END).record_every(0).run()?;
    let exact = spins(exact.last());
    let distance = |found: Vec<[f64; 3]>| {
        let each = found.into_iter().zip(&exact).map(|(a, b)| (Vector3::from(a) - Vector3::from(*b)).norm());
        each.fold(0.0, f64::max)
    };
    let (mut rows, mut lines) = (Vec::new(), [Vec::new(), Vec::new()]);
    for h in [0.2, 0.1, 0.05, 0.025] {
        let steps = (END / h).round() as usize;
        let (end, own) = timed(&RING, &lifted, h, steps)?;
        let (end_angles, other) = timed(&SPHERICAL, &angles, h, steps)?;
        let errors = [distance(spins(&end)), distance(from_angles(&end_angles))];
        for (line, point) in lines.iter_mut().zip([(own, errors[0]), (other, errors[1])]) {
            line.push((1e3 * point.0, point.1));
        }
        let ratio = |[own, other]: [f64; 2]| format!("{:.2}", own / other);
        let micro = |seconds: f64| format!("{:.2}", 1e6 * seconds / steps as f64);
        let [a, b] = errors.map(|error| format!("{error:.1e}"));
        rows.push([format!("{h}"), a, b, ratio(errors), micro(own), micro(other), ratio([own, other])]);
    }
    table::print(
        [
            "h",
            "error, oscillators",
            "error, angles",
            "ratio",
            "µs a step, oscillators",
            "µs, angles",
            "ratio",
        ],
        &rows,
    );
    poles()?;
    let [lifted, angles] = lines;
    Ok(Figure::panel("Error of a spin at t = 10 against time", "milliseconds", "largest error")
        .log_log()
        .line("two oscillators", Colour::BLUE, lifted)
        .line("angle and height", Colour::VERMILION, angles))
}

/// The state after so many steps, and the seconds that they take.
fn timed<H: Discretized<Midpoint, Vector = DVector<f64>>>(
    system: &H,
    start: &Spins,
    h: f64,
    steps: usize,
) -> Result<(Spins, f64), Box<dyn Error>> {
    let mut stepper = system.stepper::<Midpoint>(h)?;
    let (mut end, mut best) = (start.clone(), f64::INFINITY);
    // The best of several runs excludes other work of the machine.
    for _ in 0..20 {
        end.clone_from(start);
        let clock = Instant::now();
        for _ in 0..steps {
            stepper.step(&mut end, &[])?;
        }
        best = best.min(clock.elapsed().as_secs_f64());
    }
    Ok((end, best))
}

/// Runs from uniform spins. Near a pole the angle turns fast, and the slope by the height has a pole of its own.
fn poles() -> Result<(), Box<dyn Error>> {
    const STARTS: usize = 100;
    let (h, end) = (0.05, 100.0);
    let (mut failed, mut drifts) = (0, [0.0_f64; 2]);
    for directions in uniform(STARTS)? {
        let path = RING.simulate::<Midpoint>(h).start(lift(&directions)).until(end).run()?;
        drifts[0] = drifts[0].max(path.energy_drift(&RING));
        match SPHERICAL.simulate::<Midpoint>(h).start(angles(&directions)).until(end).run() {
            Ok(path) => drifts[1] = drifts[1].max(path.energy_drift(&SPHERICAL)),
            Err(_) => failed += 1,
        }
    }
    println!(
        "\n  {STARTS} uniform starts, h = {h}, t ≤ {end}. Oscillators: errors of the energy up to {:.1e}.\n  \
         Angles: {failed} runs end in an error near a pole; the others have errors of the energy up to {:.1e}.",
        drifts[0], drifts[1]
    );
    Ok(())
}

/// Rings of uniform directions.
fn uniform(count: usize) -> Result<Vec<Vec<[f64; 3]>>, Box<dyn Error>> {
    let mut wiener = Wiener::seed(11);
    let mut ring = |step: usize| -> Result<Vec<[f64; 3]>, Box<dyn Error>> {
        let mut normals = [0.0; 3 * SITES];
        wiener.increments(&Interval { start: 0.0, h: 1.0, step: step as u64 }, &mut normals)?;
        let vectors = normals.as_chunks::<3>().0.iter();
        Ok(vectors.map(|&vector| Vector3::from(vector).normalize().into()).collect())
    };
    (0..count).map(&mut ring).collect()
}
