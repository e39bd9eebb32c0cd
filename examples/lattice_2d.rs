//! The field φ⁴ on a square lattice with periodic boundaries: waves in its vacuum, and a circular wall that collapses under
//! its tension.
//!
//! `H = Σ p²/2 + [(right - own)² + (down - own)²]/2a² + (φ² - 1)²/4` per site, energy `a² H`.
//!
//! What is checked:
//! * Small waves in the vacuum φ = 1 have the frequency `ω² = 2 + (4/a²)(sin²(k a/2) + sin²(l a/2))` of the lattice. That
//!   of the steps is `tan(ω' h/2) = ω h/2` (`Midpoint`) or `sin(ω' h/2) = ω h/2` (`DeltaPlus`).
//! * A wall, `φ = tanh(x/√2)` across, has the tension `2√2/3` (R. Rajaraman, *Solitons and Instantons*, section 2.3).
//! * A circular wall at rest collapses like a relativistic string, `R = R_0 cos(t/R_0)`, up to the square of width over
//!   radius; the lattice slows it by a² (A. Vilenkin, E. P. S. Shellard, *Cosmic Strings and Other Topological Defects*, chapter 6, for
//!   loops of strings: the same equation in the plane).
//!
//! Run with `cargo run --release --features svg --example lattice_2d`.

#[path = "support/plot.rs"]
mod plot;
#[path = "support/table.rs"]
mod table;

use std::error::Error;
use std::f64::consts::{PI, SQRT_2, TAU};

use wzvi::nalgebra::DVector;
use wzvi::plot::{Colour, Figure, Look};
use wzvi::prelude::*;

#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let kinetic: f64 = p.iter().map(|p| 0.5 * p * p).sum();
        let potential: f64 = (0..side)
            .map(|i| {
                (0..side)
                    .map(|j| {
                        let own = q[i * side + j];
                        let right = q[i * side + (j + 1) % side];
                        let down = q[(i + 1) % side * side + j];
                        let bonds = (right - own) * (right - own) + (down - own) * (down - own);
                        let well = own * own - 1.0;
                        0.5 * bonds / (spacing * spacing) + 0.25 * well * well
                    })
                    .sum::<f64>()
            })
            .sum();
        kinetic + potential
    },
    embedding = [DeltaPlus, Midpoint],
)]
struct Torus {
    /// Sites along each side.
    side: usize,
    /// Distance of neighbours.
    spacing: f64,
}

type Field = State<DVector<f64>>;

/// Of the wall at the start.
const RADIUS: f64 = 30.0;

fn main() -> Result<(), Box<dyn Error>> {
    waves()?;
    let panels = wall()?;
    println!();
    plot::save("lattice_2d", "wall", 2, (1000, 900), &panels)
}

/// A standing wave in the vacuum: its frequency from the zeros of its amplitude.
fn waves() -> Result<(), Box<dyn Error>> {
    const AMPLITUDE: f64 = 1e-4;
    const WAVE: [f64; 2] = [3.0, 5.0];
    let torus = Torus { side: 32, spacing: 0.5 };
    let length = torus.side as f64;
    let part = |n: f64| (2.0 / torus.spacing * (PI * n / length).sin()).powi(2);
    let omega = (2.0 + part(WAVE[0]) + part(WAVE[1])).sqrt();
    println!("1. A wave of 3 by 5 periods and amplitude {AMPLITUDE:e} on 32 x 32 sites, 200 periods\n");
    let shape = |n: usize| {
        let (i, j) = (n / torus.side, n % torus.side);
        (TAU * (WAVE[0] * i as f64 + WAVE[1] * j as f64) / length).cos()
    };
    let start: Field = State::new(
        (0..torus.side * torus.side).map(|n| 1.0 + AMPLITUDE * shape(n)).collect::<Vec<_>>(),
        vec![0.0; torus.side * torus.side],
    );
    let mut rows = Vec::new();
    for h in [0.1, 0.05] {
        let own = 2.0 / h * (0.5 * h * omega).asin();
        rows.push(frequency::<DeltaPlus>(&torus, &start, &shape, h, omega)?.row("DeltaPlus", h, own));
        let own = 2.0 / h * (0.5 * h * omega).atan();
        rows.push(frequency::<Midpoint>(&torus, &start, &shape, h, omega)?.row("Midpoint", h, own));
    }
    table::print(["scheme", "h", "frequency", "of the step", "off by"], &rows);
    println!("\n  The lattice itself: {omega:.8}.\n");
    Ok(())
}

struct Frequency(f64);

impl Frequency {
    fn row(&self, name: &str, h: f64, expected: f64) -> [String; 5] {
        let off = self.0 / expected - 1.0;
        [
            name.into(),
            h.to_string(),
            format!("{:.8}", self.0),
            format!("{expected:.8}"),
            format!("{off:+.1e}"),
        ]
    }
}

fn frequency<E>(
    torus: &Torus,
    start: &Field,
    shape: impl Fn(usize) -> f64,
    h: f64,
    omega: f64,
) -> Result<Frequency, wzvi::Error>
where
    Torus: Discretized<E, Vector = DVector<f64>>,
{
    let (mut before, mut zeros) = (0.0, Vec::new());
    let shape: Vec<f64> = (0..start.q.len()).map(shape).collect();
    torus
        .simulate::<E>(h)
        .start(start.clone())
        .until(200.0 * TAU / omega)
        .whole_steps()
        .record_every(0)
        .inspect(|state, _| {
            // The wave has zero mean, so that the vacuum drops out.
            let now: f64 = state.q.iter().zip(&shape).map(|(q, shape)| (q - 1.0) * shape).sum();
            if before * now < 0.0 {
                // The zero of a sine through both points, with the approximately known frequency.
                let phase = (before * (omega * h).sin()).atan2(before * (omega * h).cos() - now);
                let phase = phase.rem_euclid(PI);
                zeros.push(state.t - h + phase / omega);
            }
            before = now;
        })
        .run()?;
    let count = zeros.len() - 1;
    Ok(Frequency(PI * count as f64 / (zeros[count] - zeros[0])))
}

/// Radius, from where the field changes sign along bonds; the points for the picture.
fn contour(torus: &Torus, state: &Field) -> (f64, Vec<(f64, f64)>) {
    let middle = 0.5 * (torus.side - 1) as f64;
    let mut points = Vec::new();
    for i in 0..torus.side {
        for j in 0..torus.side {
            let own = state.q[i * torus.side + j];
            let mut cross = |di: usize, dj: usize| {
                if i + di < torus.side && j + dj < torus.side {
                    let other = state.q[(i + di) * torus.side + j + dj];
                    if own * other < 0.0 {
                        let part = own / (own - other);
                        let x = j as f64 + part * dj as f64 - middle;
                        let y = i as f64 + part * di as f64 - middle;
                        points.push((torus.spacing * x, torus.spacing * y));
                    }
                }
            };
            cross(0, 1);
            cross(1, 0);
        }
    }
    // Bonds are crossed more often along the diagonals: the mean by angle.
    let mut by_angle = [(0.0, 0.0); 64];
    for &(x, y) in &points {
        let sector = ((y.atan2(x) + PI) / TAU * 64.0) as usize;
        if let Some((sum, count)) = by_angle.get_mut(sector) {
            *sum += x.hypot(y);
            *count += 1.0;
        }
    }
    let known: Vec<f64> = by_angle.iter().filter(|(_, n)| *n > 0.0).map(|(sum, n)| sum / n).collect();
    (known.iter().sum::<f64>() / known.len() as f64, points)
}

/// The fall of a circular wall, on two lattices.
fn wall() -> Result<[Figure; 2], Box<dyn Error>> {
    println!("2. A circular wall of radius {RADIUS} on a torus of 80 by 80, Midpoint, h = a/5\n");
    let (coarse, fine) = (Fall::on(0.5)?, Fall::on(0.25)?);
    let mut rows = Vec::new();
    for ((t, coarse), (_, fine)) in coarse.radii.iter().zip(&fine.radii).step_by(6) {
        let expected = RADIUS * (t / RADIUS).cos();
        let limit = fine + (fine - coarse) / 3.0;
        rows.push([
            format!("{t:.0}"),
            format!("{coarse:.3}"),
            format!("{fine:.3}"),
            format!("{limit:.3}"),
            format!("{expected:.3}"),
            format!("{:+.2} %", 100.0 * (limit / expected - 1.0)),
        ]);
    }
    table::print(["t", "R, a = 1/2", "a = 1/4", "a → 0 by a²", "R_0 cos(t/R_0)", "off by"], &rows);
    let tension = 2.0 * SQRT_2 / 3.0;
    let limit = fine.tension + (fine.tension - coarse.tension) / 3.0;
    println!(
        "\n  Energy per length at the start, a → 0: {limit:.5}; tension of a wall 2√2/3 = {tension:.5}."
    );
    println!(
        "  a = 1/4: energy kept to {:.1e} of itself, {:.2} iterations per step.",
        fine.drift, fine.iterations
    );
    let exact = (0..=390).map(|i| 0.1 * f64::from(i)).map(|t| (t, RADIUS * (t / RADIUS).cos()));
    let mut picture =
        Figure::panel("Where the field vanishes, every 6 units of time (a = 1/4)", "x", "y").equal_axes();
    let colors = [
        Colour::INK,
        Colour::BLUE,
        Colour::VIOLET,
        Colour::GREEN,
        Colour::OCHRE,
        Colour::VERMILION,
        Colour::PURPLE,
    ];
    for ((t, points), color) in fine.contours.into_iter().zip(colors) {
        picture = picture.points(Look::FineDots, format!("t = {t:.0}"), color, points);
    }
    Ok([
        picture,
        Figure::panel("Radius of the wall", "t", "R")
            .points(Look::Broad, "R_0 cos(t/R_0)", Colour::GREY, exact)
            .line("a = 1/2", Colour::VERMILION, coarse.radii)
            .line("a = 1/4", Colour::BLUE, fine.radii),
    ])
}

/// The result of a run.
struct Fall {
    tension: f64,
    /// Once per unit of time.
    radii: Vec<(f64, f64)>,
    /// Every 6 units of time.
    contours: Vec<(f64, Vec<(f64, f64)>)>,
    drift: f64,
    iterations: f64,
}

impl Fall {
    fn on(spacing: f64) -> Result<Self, wzvi::Error> {
        let torus = Torus { side: (80.0 / spacing).round() as usize, spacing };
        let middle = 0.5 * (torus.side - 1) as f64;
        let radius = |n: usize| {
            let (i, j) = (n / torus.side, n % torus.side);
            torus.spacing * (i as f64 - middle).hypot(j as f64 - middle)
        };
        let sites = torus.side * torus.side;
        let q: Vec<f64> = (0..sites).map(|n| ((radius(n) - RADIUS) / SQRT_2).tanh()).collect();
        let start: Field = State::new(q, vec![0.0; sites]);
        let energy = torus.energy(&start);
        let tension = torus.spacing.powi(2) * energy / (TAU * RADIUS);
        let mut fall = Self { tension, radii: vec![], contours: vec![], drift: 0.0, iterations: 0.0 };
        let each = (5.0 / spacing).round() as u64;
        let path = torus
            .simulate::<Midpoint>(0.2 * spacing)
            .start(start)
            .until(39.0)
            .record_every(0)
            .inspect(|state, node| {
                if node.step % each != 0 {
                    return;
                }
                let (radius, points) = contour(&torus, state);
                fall.radii.push((state.t, radius));
                fall.drift = fall.drift.max((torus.energy(state) / energy - 1.0).abs());
                if node.step % (6 * each) == 0 {
                    fall.contours.push((state.t, points));
                }
            })
            .run()?;
        fall.iterations = path.iterations().total as f64 / path.steps() as f64;
        Ok(fall)
    }
}
