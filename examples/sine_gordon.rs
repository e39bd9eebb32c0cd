//! Sine-Gordon: a kink on a lattice, shaken at every site.
//!
//! The field equation `φ_tt = φ_xx - sin φ` on sites `x_i = i a` of a ring, around which the field increases by 2π:
//! `H = Σ p_i²/2 + (q_{i+1} - q_i)²/2a² + 1 - cos q_i`, energy `E = a H`. Each site has its own Wiener process, which
//! pushes the field (`σ q_k`) or shakes the potential (`τ (1 - cos q_k)`).
//!
//! What is checked, with `M = 8` the mass of the kink `φ = 4 atan exp(γ (x - v t))`, `γ = (1 - v²)^(-1/2)`:
//! * Without noise the kink has energy `8 γ` and velocity `v` (A. C. Scott, *Nonlinear Science*, section 3.3), up to a².
//! * Pushes of strength `σ = s/√a` heat by `σ²/2` per site and time, exactly, whatever the field does. A step of `Midpoint`
//!   gives a mode of frequency ω the fraction `1/(1 + ω²h²/4)` of that. The pushes make the kink diffuse like a Brownian particle without friction, `<X²> = s² t³/3M` for small s (P. J. Pascual, L. Vázquez,
//!   *Phys. Rev. B* 32, 8305, 1985, treat this equation).
//! * Shaking the potential heats by `τ²/2 Σ sin² q_i`: at first only where the kink is, by `4 τ²/3`.
//!
//! Run with `cargo run --release --features svg --example sine_gordon`.

#[path = "support/plot.rs"]
mod plot;
#[path = "support/table.rs"]
mod table;

use std::error::Error;
use table::Mean;
use wzvi::nalgebra::DVector;
use wzvi::plot::{Colour, Figure, Look};
use wzvi::prelude::*;

#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let n = q.len();
        let bond = |d: f64| 0.5 * d * d / (spacing * spacing);
        (0..n).map(|i| 0.5 * p[i] * p[i] + 1.0 - q[i].cos()).sum::<f64>()
            + (1..n).map(|i| bond(q[i] - q[i - 1])).sum::<f64>()
            + bond(q[0] + std::f64::consts::TAU - q[n - 1])
    },
    noise = [|q, p, k| sigma * q[k] + tau * (1.0 - q[k].cos()); self.sites],
    embedding = Midpoint,
)]
struct SineGordon {
    /// Distance of neighbours.
    spacing: f64,
    sites: usize,
    /// Strength of the pushes.
    sigma: f64,
    /// Strength with which the potential shakes.
    tau: f64,
}

type Field = State<DVector<f64>>;

const LENGTH: f64 = 24.0;
/// Rest energy of the kink.
const MASS: f64 = 8.0;
const H: f64 = 0.05;

fn main() -> Result<(), Box<dyn Error>> {
    let mut panels = vec![moving()?];
    panels.extend(pushed()?);
    panels.push(shaken()?);
    println!();
    plot::save("sine_gordon", "kinks", 2, (1000, 640), &panels)
}

impl SineGordon {
    fn new(spacing: f64, sigma: f64, tau: f64) -> Self {
        Self { spacing, sites: (LENGTH / spacing).round() as usize, sigma, tau }
    }

    fn x(&self, i: usize) -> f64 {
        self.spacing * i as f64
    }

    fn field_energy(&self, state: &Field) -> f64 {
        self.spacing * self.energy(state)
    }

    /// The fraction of the heat of independent pushes that a step of `Midpoint` has: the mean of `1/(1 + ω²h²/4)` over the modes
    /// of the lattice, `ω_k² = 1 + (4/a²) sin²(π k/N)`.
    fn taken(&self) -> f64 {
        let part = |k: usize| {
            let wave = 2.0 / self.spacing * (std::f64::consts::PI * k as f64 / self.sites as f64).sin();
            1.0 / (1.0 + 0.25 * H * H * (1.0 + wave * wave))
        };
        (0..self.sites).map(part).sum::<f64>() / self.sites as f64
    }

    /// The kink of the continuum, at `middle` with velocity `v`.
    fn kink(&self, middle: f64, v: f64) -> Field {
        let gamma = (1.0 - v * v).powf(-0.5);
        let at = |i: usize| gamma * (self.x(i) - middle);
        let q: Vec<f64> = (0..self.sites).map(|i| 4.0 * at(i).exp().atan()).collect();
        let p: Vec<f64> = (0..self.sites).map(|i| -2.0 * gamma * v / at(i).cosh()).collect();
        State::new(q, p)
    }

    /// Where the kink is: the X for which the rest of the field is orthogonal to the kink's shift,
    /// `∫ (φ - φ_X) φ_X' dx = 0`, by iteration from `guess`.
    fn position(&self, state: &Field, guess: f64) -> f64 {
        let mut middle = guess;
        for _ in 0..20 {
            let overlap: f64 = state
                .q
                .iter()
                .enumerate()
                .map(|(i, q)| {
                    let z = self.x(i) - middle;
                    (q - 4.0 * z.exp().atan()) * 2.0 / z.cosh()
                })
                .sum();
            middle -= overlap * self.spacing / MASS;
        }
        middle
    }
}

/// The kink without noise, on finer and finer lattices.
fn moving() -> Result<Figure, Box<dyn Error>> {
    const V: f64 = 0.3;
    const END: f64 = 20.0;
    let expected = MASS / (1.0 - V * V).sqrt();
    println!("1. A kink of velocity {V} without noise, Midpoint, h = {H}, t ≤ {END}\n");
    let (mut rows, mut errors, mut panel) = (Vec::new(), Vec::new(), None);
    for spacing in [0.4, 0.2, 0.1] {
        let system = SineGordon::new(spacing, 0.0, 0.0);
        let start = system.kink(0.35 * LENGTH, V);
        let (begin, quiet) = (system.position(&start, 0.35 * LENGTH), vec![vec![0.0; system.sites]; 400]);
        let path = system
            .simulate::<Midpoint>(H)
            .start(start.clone())
            .noise(Increments::from(quiet))
            .until(END)
            .run()?;
        let end = path.last();
        let velocity = (system.position(end, 0.35 * LENGTH + V * END) - begin) / END;
        let energy = system.field_energy(&start);
        errors.push(((energy - expected).abs(), (velocity - V).abs()));
        rows.push([
            format!("{spacing}"),
            format!("{energy:.5}"),
            format!("{velocity:.5}"),
            format!("{:.1e}", spacing * path.energy_drift(&system)),
        ]);
        let shape =
            |state: &Field| state.q.iter().enumerate().map(|(i, &q)| (system.x(i), q)).collect::<Vec<_>>();
        let sharp = system.kink(0.35 * LENGTH + V * END, V);
        panel = Some(
            Figure::panel("A kink of velocity 0.3, without noise (a = 0.1)", "x", "φ")
                .points(Look::Dashed, "t = 0", Colour::BLUE, shape(&start))
                .points(Look::Broad, "continuum, t = 20", Colour::GREY, shape(&sharp))
                .line("Midpoint, t = 20", Colour::BLUE, shape(end)),
        );
    }
    rows.push(["continuum".into(), format!("{expected:.5}"), format!("{V:.5}"), String::new()]);
    table::print(["a", "energy", "velocity", "drift of E"], &rows);
    let order = |of: fn(&(f64, f64)) -> f64| (of(&errors[1]) / of(&errors[2])).log2();
    println!(
        "\n  The lattice is off by a²: orders {:.2} (energy) and {:.2} (velocity) from the last two.\n",
        order(|error| error.0),
        order(|error| error.1)
    );
    Ok(panel.ok_or("no lattice")?)
}

/// Energies and positions of an ensemble of kinks at rest.
struct Ensemble {
    times: Vec<f64>,
    energies: Vec<Mean>,
    /// `Σ sin² q_i`, integrated over time by the trapezoidal rule.
    shaking: Vec<Mean>,
    /// Squares of the displacements.
    squares: Vec<Mean>,
    /// Where the first members are.
    tracks: Vec<Vec<(f64, f64)>>,
}

fn ensemble(system: &SineGordon, paths: u64, end: f64) -> Result<Ensemble, Box<dyn Error>> {
    const EVERY: u64 = 10;
    let nodes = ((end / H).round() as u64 / EVERY + 1) as usize;
    let means = || vec![Mean::default(); nodes];
    let mut all = Ensemble {
        times: vec![0.0; nodes],
        energies: means(),
        shaking: means(),
        squares: means(),
        tracks: vec![],
    };
    let start = system.kink(0.5 * LENGTH, 0.0);
    let begin = system.field_energy(&start);
    for path in 0..paths {
        let (mut last, mut sum, mut integral) = (0.5 * LENGTH, 0.0, 0.0);
        let mut track = Vec::new();
        system
            .simulate::<Midpoint>(H)
            .start(start.clone())
            .noise(Wiener::seed(8305).unit(H).path(path))
            .until(end)
            .record_every(0)
            .inspect(|state, node| {
                let now: f64 = state.q.iter().map(|q| q.sin().powi(2)).sum();
                integral += if node.step == 0 { 0.0 } else { 0.5 * H * (sum + now) };
                sum = now;
                if node.step % EVERY != 0 {
                    return;
                }
                let i = (node.step / EVERY) as usize;
                last = system.position(state, last);
                all.times[i] = state.t;
                all.energies[i].add(system.field_energy(state) - begin);
                all.shaking[i].add(integral);
                all.squares[i].add((last - 0.5 * LENGTH).powi(2));
                track.push((state.t, last - 0.5 * LENGTH));
            })
            .run()?;
        if all.tracks.len() < 20 {
            all.tracks.push(track);
        }
    }
    Ok(all)
}

/// A mean beside its values in continuous time and for the step.
fn row(name: String, mean: &Mean, exact: f64, taken: f64) -> [String; 5] {
    let (value, error) = (mean.value(), mean.standard_error());
    let expected = taken * exact;
    let off = format!("{:+.1}", (value - expected) / error);
    [name, format!("{value:.4} ± {error:.4}"), format!("{exact:.4}"), format!("{expected:.4}"), off]
}

/// Every site is pushed.
fn pushed() -> Result<[Figure; 2], Box<dyn Error>> {
    const STRENGTH: f64 = 0.03;
    const PATHS: u64 = 400;
    const END: f64 = 12.0;
    let system = SineGordon::new(0.2, STRENGTH / 0.2_f64.sqrt(), 0.0);
    let all = ensemble(&system, PATHS, END)?;
    let heat = |t: f64| 0.5 * system.spacing * system.sigma.powi(2) * system.sites as f64 * t;
    let diffusion = |t: f64| STRENGTH.powi(2) * t.powi(3) / (3.0 * MASS);
    println!(
        "2. {PATHS} kinks at rest, pushed at {} sites, s = {STRENGTH}, Midpoint, h = {H}\n",
        system.sites
    );
    let mut rows = Vec::new();
    for (i, &t) in all.times.iter().enumerate().skip(1).filter(|(i, _)| i % 8 == 0) {
        rows.push(row(format!("<E> - E(0), t = {t}"), &all.energies[i], heat(t), system.taken()));
        rows.push(row(format!("<X²>, t = {t}"), &all.squares[i], diffusion(t), 1.0));
    }
    table::print(["", "measured", "s² L t/2, s² t³/24", "with this step", "standard errors apart"], &rows);
    println!();
    let curve = |means: &[Mean]| -> Vec<(f64, f64)> {
        all.times.iter().copied().zip(means.iter().map(Mean::value)).collect()
    };
    let mut tracks =
        Figure::panel("Pushed kinks: 20 of 400, and ±<X²>^(1/2) of a Brownian particle", "t", "X");
    for track in &all.tracks {
        tracks = tracks.line("", Colour::GREY, track.iter().copied());
    }
    let bound = |sign: f64| all.times.iter().map(|&t| (t, sign * diffusion(t).sqrt())).collect::<Vec<_>>();
    Ok([
        Figure::panel("Pushed at every site: energy", "t", "<E> - E(0)")
            .points(
                Look::Dashed,
                "s² L t/2, continuous time",
                Colour::VERMILION,
                all.times.iter().map(|&t| (t, heat(t))),
            )
            .line(
                "with this step",
                Colour::VERMILION,
                all.times.iter().map(|&t| (t, system.taken() * heat(t))),
            )
            .points(Look::Dots, "mean of 400 paths", Colour::BLUE, curve(&all.energies)),
        tracks.line("s (t³/24)^(1/2)", Colour::VERMILION, bound(1.0)).line(
            "",
            Colour::VERMILION,
            bound(-1.0),
        ),
    ])
}

/// The potential of every site shakes.
fn shaken() -> Result<Figure, Box<dyn Error>> {
    const PATHS: u64 = 400;
    const END: f64 = 12.0;
    let system = SineGordon::new(0.2, 0.0, 0.3);
    let all = ensemble(&system, PATHS, END)?;
    let rate = 0.5 * system.spacing * system.tau.powi(2);
    println!("3. {PATHS} kinks at rest, the potential shaken with τ = {}, Midpoint, h = {H}\n", system.tau);
    let mut rows = Vec::new();
    for (i, &t) in all.times.iter().enumerate().skip(1).filter(|(i, _)| i % 8 == 0) {
        let exact = rate * all.shaking[i].value();
        rows.push(row(format!("<E> - E(0), t = {t}"), &all.energies[i], exact, system.taken()));
    }
    table::print(["", "measured", "a τ²/2 ∫<Σ sin² q>dt", "with this step", "standard errors apart"], &rows);
    let first = rate * all.shaking[1].value() / all.times[1];
    let kink = 4.0 / 3.0 * system.tau.powi(2);
    println!("\n  The rate at the start, {first:.4}, is that of a kink alone, 4 τ²/3 = {kink:.4}.\n");
    let curve = |means: &[Mean], by: f64| -> Vec<(f64, f64)> {
        all.times.iter().copied().zip(means.iter().map(move |mean| by * mean.value())).collect()
    };
    Ok(Figure::panel("Shaken potential: energy", "t", "<E> - E(0)")
        .line(
            "a τ²/2 ∫ <Σ sin² q> dt, with this step",
            Colour::VERMILION,
            curve(&all.shaking, rate * system.taken()),
        )
        .points(
            Look::Dashed,
            "4 τ² t/3, a kink that stays as it is",
            Colour::GREY,
            all.times.iter().map(|&t| (t, kink * t)),
        )
        .points(Look::Dots, "mean of 400 paths", Colour::BLUE, curve(&all.energies, 1.0)))
}
