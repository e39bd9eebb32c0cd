//! The paper's Kubo experiment: every embedding on one Wiener path, the energies, the limit of the uncorrected scheme,
//! and strong errors against step size and run time.
//!
//! `H0 = a (q² + p²)/2`, `H1 = σ (q² + p²)/2`: a rotation by the angle `a t + σ W(t)`, so the exact solution is known
//! and `q² + p²` is a first integral. With the noise at the left end of a step (`DeltaPlus`), a spurious drift remains that
//! does not vanish with h.
//!
//! Run with `cargo run --release --features svg --example kubo`.

#[path = "support/plot.rs"]
mod plot;
#[path = "support/table.rs"]
mod table;

use std::error::Error;
use std::hint::black_box;
use std::time::Instant;

use table::Mean;
use wzvi::nalgebra::SVector;
use wzvi::noise::{Interval, Paths};
use wzvi::plot::{Colour, Figure, Look};
use wzvi::prelude::*;

/// Kubo oscillator: a rotation whose angle diffuses.
#[hamiltonian(
    drift = |q, p| 0.5 * a * (q * q + p * p),
    noise = [|q, p| 0.5 * sigma * (q * q + p * p)],
    embedding = [Uncorrected<DeltaPlus>, Uncorrected<DeltaMinus>, Uncorrected<Lambda<1, 4>>,
                 Corrected<DeltaPlus>, Mixed<DeltaPlus, Midpoint>, Midpoint],
    invariant = [|q, p| q * q + p * p],
)]
struct Kubo {
    /// Mean angular frequency.
    a: f64,
    /// Intensity of the noise.
    sigma: f64,
}

type Point = SVector<f64, 1>;

const KUBO: Kubo = Kubo { a: 1.5, sigma: 1.0 };
const SEED: u64 = 7;

/// Does the same for every scheme: `each!(function(arguments))` gives the array of `function::<E>(scheme, arguments)`.
macro_rules! each {
    ($function:ident($($argument:expr),*)) => {
        [
            $function::<Uncorrected<DeltaPlus>>(("Uncorrected<DeltaPlus>", Colour::VERMILION), $($argument),*)?,
            $function::<Uncorrected<DeltaMinus>>(("Uncorrected<DeltaMinus>", Colour::OCHRE), $($argument),*)?,
            $function::<Uncorrected<Lambda<1, 4>>>(("Uncorrected<Lambda<1, 4>>", Colour::PURPLE), $($argument),*)?,
            $function::<Corrected<DeltaPlus>>(("Corrected<DeltaPlus>", Colour::VIOLET), $($argument),*)?,
            $function::<Mixed<DeltaPlus, Midpoint>>(("Mixed<DeltaPlus, Midpoint>", Colour::GREEN), $($argument),*)?,
            $function::<Midpoint>(("Midpoint", Colour::BLUE), $($argument),*)?,
        ]
    };
}

/// Name and colour of a scheme.
type Scheme = (&'static str, usize);

fn main() -> Result<(), Box<dyn Error>> {
    println!("Kubo oscillator, a = {}, σ = {}, from q = 0, p = 1", KUBO.a, KUBO.sigma);
    println!(
        "An oscillator whose frequency is noisy: it moves on a circle, at an angle that diffuses. A good step stays on\n\
         the circle at the right angle. A step that treats the noise wrongly settles on the motion of another system,\n\
         however short it is; below, \"consistent\" says what the compiler proved of each step, and the errors confirm it."
    );
    one_path()?;
    limit()?;
    strong_errors()
}

fn start() -> State<Point> {
    State::new([0.0], [1.0])
}

/// The rotation by `a t + σ W(t)` of the start.
fn exact(t: f64, w: f64) -> [f64; 2] {
    let (sin, cos) = (KUBO.a * t + KUBO.sigma * w).sin_cos();
    [sin, cos]
}

fn distance(state: &State<Point>, [q, p]: [f64; 2]) -> f64 {
    (state.q[0] - q).hypot(state.p[0] - p)
}

// One path, as in the paper: h = ε = 0.02.

const H: f64 = 0.02;
const T: f64 = 20.0;

/// A scheme along the path.
struct Run {
    scheme: Scheme,
    row: [String; 6],
    states: Vec<State<Point>>,
    wiener: Vec<f64>,
}

fn run<E>(scheme: Scheme, noise: &WongZakai) -> Result<Run, wzvi::Error>
where
    Kubo: Discretized<E, Vector = Point>,
{
    let path = KUBO.simulate::<E>(H).start(start()).noise(noise.clone()).until(T).run()?;
    let wiener = path.wiener(0);
    let errors = path.iter().zip(&wiener).map(|(state, &w)| distance(state, exact(state.t, w)));
    let plan = <Kubo as Discretized<E>>::PLAN;
    let row = [
        scheme.0.into(),
        format!("{:?}", plan.solver),
        if plan.consistent { "yes" } else { "no" }.into(),
        format!("{:.2e}", errors.fold(0.0, f64::max)),
        format!("{:.2e}", path.energy_drift(&KUBO)),
        format!("{:.1e}", path.euler_lagrange_residual(&KUBO)?),
    ];
    Ok(Run { scheme, row, states: path.into_iter().collect(), wiener })
}

fn one_path() -> Result<(), Box<dyn Error>> {
    let mut noise = WongZakai::averaged(H).seed(SEED);
    let runs = each!(run(&noise));
    println!("\n1. One Wiener path, h = ε = {H}, t ≤ {T}\n");
    table::print(
        ["scheme", "step", "consistent", "max |z - exact|", "max |H0 - H0(0)|", "Euler-Lagrange"],
        &runs.each_ref().map(|run| run.row.clone()),
    );
    println!("\n  The last column is the residual of the discrete Euler-Lagrange equations.\n");

    let [order_1, .., order_2] = &runs;
    let circle = || (0..=180).map(|i| (f64::from(i) * 2.0).to_radians().sin_cos());
    let phase = |run: &Run, title: &str| {
        let points = run.states.iter().map(|state| (state.q[0], state.p[0]));
        Figure::panel(title, "q", "p")
            .equal_axes()
            .points(Look::Broad, "exact", Colour::GREY, circle())
            .points(Look::Dots, run.scheme.0, run.scheme.1, points)
    };
    let panels = [phase(order_1, "Order 1"), phase(order_2, "Order 2")];
    plot::save("kubo", "phase", 2, (900, 900), &panels)?;

    let curve = || order_2.states.iter().zip(&order_2.wiener).map(|(z, &w)| (z.t, exact(z.t, w)[0]));
    let time = "time t";
    let mut panels = [
        Figure::panel("Not consistent: the limit is another system", time, "q").points(
            Look::Broad,
            "exact",
            Colour::GREY,
            curve(),
        ),
        Figure::panel("Consistent", time, "q").points(Look::Broad, "exact", Colour::GREY, curve()),
        Figure::panel("Distance from the exact solution", time, "|z - exact|").log_y().y_range(1e-3..1e1),
    ];
    for (n, run) in runs.iter().enumerate() {
        let [wrong, right, errors] = panels;
        let q = run.states.iter().map(|state| (state.t, state.q[0]));
        let (label, color) = run.scheme;
        let (wrong, right) =
            if n < 3 { (wrong.line(label, color, q), right) } else { (wrong, right.line(label, color, q)) };
        let error = run.states.iter().zip(&run.wiener).map(|(z, &w)| (z.t, distance(z, exact(z.t, w))));
        panels = [wrong, right, errors.line(label, color, error)];
    }
    plot::save("kubo", "paths", 1, (1700, 560), &panels)?;

    let mut panels = Vec::new();
    for (run, order) in [(order_1, 1), (order_2, 2)] {
        let mut wong_zakai = Vec::with_capacity(run.states.len());
        for z in &run.states {
            let velocity = noise.velocity(0, z.t)?;
            wong_zakai.push((z.t, KUBO.energy(z) + KUBO.noise_energy(0, z) * velocity));
        }
        let energy = run.states.iter().map(|z| (z.t, KUBO.energy(z)));
        let label = run.scheme.0;
        panels.push(Figure::panel(format!("Wong-Zakai energy, order {order}"), time, "H0 + H1 dWε/dt").line(
            label,
            run.scheme.1,
            wong_zakai,
        ));
        let panel = Figure::panel(format!("Unperturbed energy, order {order}"), time, "H0")
            .points(Look::Broad, "exact", Colour::GREY, [(0.0, 0.75), (T, 0.75)])
            .line(label, run.scheme.1, energy);
        panels.push(if order == 2 { panel.y_range(0.0..1.5) } else { panel });
    }
    plot::save("kubo", "energies", 2, (900, 560), &panels)
}

// What the order-one scheme converges to.

/// `E |z(1)|²` of the system with drift `H0 - σ² q p / 2`: the limit of the uncorrected `DeltaPlus`.
const LIMIT: f64 = 1.415_701_365_42;

fn limit() -> Result<(), Box<dyn Error>> {
    const PATHS: u64 = 100_000;
    println!(
        "\n2. E |z(1)|² over {PATHS} paths: 1 for the exact solution, {LIMIT:.6} predicted for order 1, h → 0\n"
    );
    let mut rows = Vec::new();
    for power in [2, 4, 6, 8] {
        let [uncorrected, corrected, midpoint] = second_moments(power, PATHS)?;
        let expected = expected_second_moment(power);
        let off = (uncorrected.value() - expected) / uncorrected.standard_error();
        let show = |mean: &Mean| format!("{:.4} ± {:.4}", mean.value(), mean.standard_error());
        rows.push([
            format!("2^-{power}"),
            format!("{expected:.4}"),
            show(&uncorrected),
            format!("{off:+.1}"),
            show(&corrected),
            format!("{:.1e}", (midpoint.value() - 1.0).abs()),
        ]);
    }
    let order_1 = "Uncorrected<DeltaPlus>";
    table::print(
        ["h", "expected at h", order_1, "off by (std. err.)", "Corrected<DeltaPlus>", "|Midpoint - 1|"],
        &rows,
    );
    println!("\n  Expected at h = 2^-24: {:.6}.", expected_second_moment(24));
    Ok(())
}

/// Of the uncorrected and the corrected `DeltaPlus` and of `Midpoint`, on the same paths.
fn second_moments(power: i32, paths: u64) -> Result<[Mean; 3], wzvi::Error> {
    let h = 0.5_f64.powi(power);
    // In the unit h a path costs the least. The rows of the table are to be independent: each has its own seed.
    let mut noise = Wiener::seed(SEED + power as u64).unit(h);
    let mut uncorrected = KUBO.stepper::<Uncorrected<DeltaPlus>>(h)?;
    let mut corrected = KUBO.stepper::<Corrected<DeltaPlus>>(h)?;
    let mut midpoint = KUBO.stepper::<Midpoint>(h)?;
    let mut means = [Mean::default(); 3];
    for path in 0..paths {
        noise.set_path(path);
        let mut states = [start(); 3];
        let [a, b, c] = &mut states;
        let mut dw = [0.0];
        for step in 0..1 << power {
            noise.increments(&Interval { start: 0.0, h, step }, &mut dw)?;
            uncorrected.step(a, &dw)?;
            corrected.step(b, &dw)?;
            midpoint.step(c, &dw)?;
        }
        for (mean, State { q, p, .. }) in means.iter_mut().zip(&states) {
            mean.add(q[0] * q[0] + p[0] * p[0]);
        }
    }
    Ok(means)
}

/// `E |z(1)|²` of the uncorrected `DeltaPlus`: with `θ = a h + σ ΔW` its step is `q' = (1 - θ²) q + θ p`,
/// `p' = p - θ q`, so the second moments of a step follow from those before.
fn expected_second_moment(power: i32) -> f64 {
    let h = 0.5_f64.powi(power);
    let (m, s) = (KUBO.a * h, KUBO.sigma * KUBO.sigma * h);
    let (m2, m3, m4) = (m * m + s, m * (m * m + 3.0 * s), m.powi(4) + 6.0 * m * m * s + 3.0 * s * s);
    let (mut qq, mut qp, mut pp) = (0.0, 0.0, 1.0);
    for _ in 0..1 << power {
        (qq, qp, pp) = (
            (1.0 - 2.0 * m2 + m4) * qq + 2.0 * (m - m3) * qp + m2 * pp,
            (m3 - m) * qq + (1.0 - 2.0 * m2) * qp + m * pp,
            m2 * qq - 2.0 * m * qp + pp,
        );
    }
    qq + pp
}

// Strong errors.

const POWERS: std::ops::RangeInclusive<i32> = 4..=10;

/// The same paths on one grid.
struct Grid {
    h: f64,
    steps: usize,
    /// Increments, path after path.
    increments: Vec<[f64; 1]>,
    /// `W(1)` of each path.
    ends: Vec<f64>,
}

impl Grid {
    fn new(power: i32, paths: u64) -> Result<Self, wzvi::Error> {
        let (h, steps) = (0.5_f64.powi(power), 1 << power);
        let mut noise = Wiener::seed(SEED);
        let (mut increments, mut ends) = (Vec::with_capacity(paths as usize * steps), Vec::new());
        for path in 0..paths {
            noise.set_path(path);
            for step in 0..steps as u64 {
                let mut dw = [0.0];
                noise.increments(&Interval { start: 0.0, h, step }, &mut dw)?;
                increments.push(dw);
            }
            ends.push(noise.value(0, 1.0)?);
        }
        Ok(Self { h, steps, increments, ends })
    }
}

/// Root mean square error at t = 1 and seconds per path.
fn strong_error<E>(_: Scheme, grid: &Grid) -> Result<(f64, f64), wzvi::Error>
where
    Kubo: Discretized<E, Vector = Point>,
{
    let mut stepper = KUBO.stepper::<E>(grid.h)?;
    let mut ends = vec![start(); grid.ends.len()];
    // The best of several runs excludes other work of the machine.
    let mut best = f64::INFINITY;
    for _ in 0..5 {
        let clock = Instant::now();
        for (path, end) in grid.increments.chunks_exact(grid.steps).zip(&mut ends) {
            *end = start();
            for dw in path {
                stepper.step(end, dw)?;
            }
        }
        black_box(&ends);
        best = best.min(clock.elapsed().as_secs_f64());
    }
    let seconds = best / ends.len() as f64;
    let mut mean = Mean::default();
    for (state, &w) in ends.iter().zip(&grid.ends) {
        mean.add(distance(state, exact(1.0, w)).powi(2));
    }
    Ok((mean.value().sqrt(), seconds))
}

fn strong_errors() -> Result<(), Box<dyn Error>> {
    const PATHS: u64 = 2000;
    println!("\n3. Root mean square error at t = 1 over {PATHS} shared paths\n");
    let grids = POWERS.map(|power| Grid::new(power, PATHS)).collect::<Result<Vec<_>, _>>()?;
    let results =
        grids.iter().map(|grid| Ok(each!(strong_error(grid)))).collect::<Result<Vec<_>, wzvi::Error>>()?;
    let schemes = each!(itself());
    let mut rows = Vec::new();
    for (n, (name, _)) in schemes.iter().enumerate() {
        let error = |level: usize| results[level][n].0;
        let order = (error(2) / error(6)).log2() / 4.0;
        let time = results[6][n].1 / grids[6].steps as f64;
        let mut row: [String; 10] = std::array::from_fn(|_| String::new());
        row[0] = (*name).into();
        for level in 0..7 {
            row[level + 1] = format!("{:.2e}", error(level));
        }
        row[8] = format!("{order:.2}");
        row[9] = format!("{:.1}", time * 1e9);
        rows.push(row);
    }
    table::print(
        ["scheme", "h = 2^-4", "2^-5", "2^-6", "2^-7", "2^-8", "2^-9", "2^-10", "order", "ns/step"],
        &rows,
    );
    let constant = (15.0 * KUBO.sigma.powi(6) / 144.0 + (KUBO.a * KUBO.sigma.powi(2) / 4.0).powi(2)).sqrt();
    let measured = results[6][5].0 / grids[6].h;
    println!(
        "\n  Midpoint: error / h = {measured:.4} at h = 2^-10, predicted sqrt(15 σ⁶/144 + (a σ²/4)²) = {constant:.4}"
    );
    println!("  Order: from 2^-6 to 2^-10. Times: steps with given increments.\n");

    let mut by_step =
        Figure::panel("Strong error against step size", "step size h", "rms |z(1) - exact|").log_log();
    let mut by_time = Figure::panel(
        "Strong error against run time",
        "time per path, steps only [μs]",
        "rms |z(1) - exact|",
    )
    .log_log();
    for (n, (name, color)) in schemes.into_iter().enumerate() {
        let levels = || grids.iter().zip(&results);
        by_step =
            by_step.points(Look::Joined, name, color, levels().map(|(grid, result)| (grid.h, result[n].0)));
        by_time = by_time.points(
            Look::Joined,
            name,
            color,
            levels().map(|(_, result)| (1e6 * result[n].1, result[n].0)),
        );
    }
    let ends = [grids[6].h, grids[0].h];
    let predicted = ends.map(|h| (h, constant * h));
    let by_step = by_step.slope("slope 1", 1.0, 3.0, ends).points(
        Look::Dashed,
        "Midpoint, predicted",
        Colour::INK,
        predicted,
    );
    plot::save("kubo", "strong_error", 2, (1100, 900), &[by_step, by_time])
}

fn itself<E>(scheme: Scheme) -> Result<Scheme, wzvi::Error>
where
    Kubo: Discretized<E>,
{
    Ok(scheme)
}
