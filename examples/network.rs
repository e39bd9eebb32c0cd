//! Oscillators coupled along a random graph that is given as a list of edges.
//!
//! `H = Σ p_i²/2 + Σ_e s_e (1 - cos(q_a - q_b))` over the edges `e = (a, b)`: rotors with aligning couplings. The
//! graph is that of P. Erdős and A. Rényi: every pair of 500 sites is joined with probability 3/500, so that degrees differ
//! and no order of the sites makes the matrix narrow.
//!
//! What is checked:
//! * Small deflections oscillate with the frequencies `√λ` of the Laplacian of the graph, `L = Σ_e s_e (e_a - e_b)(e_a -
//!   e_b)ᵀ`; a step of `Midpoint` turns each by `2 atan(√λ h/2)`: the network after 2000 steps beside 500 exact rotations.
//! * Independent Wiener processes at the sites heat by `σ²/2` each; with `Midpoint` by the fraction `1/(1 + λ h²/4)` of that.
//! * The total momentum is kept to rounding: angles enter as differences.
//! * A matrix of the network's pattern solves a step that is too large for the fixed point.
//!
//! Run with `cargo run --release --features svg --example network`.

#[path = "support/plot.rs"]
mod plot;
#[path = "support/table.rs"]
mod table;

use std::error::Error;

use table::Mean;
use wzvi::nalgebra::{DMatrix, DVector, SymmetricEigen};
use wzvi::plot::{Colour, Figure, Look};
use wzvi::prelude::*;

#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let kinetic: f64 = p.iter().map(|p| 0.5 * p * p).sum();
        let edges: f64 = (0..self.edges.len())
            .map(|e| self.strength[e] * (1.0 - (q[self.edges[e][0]] - q[self.edges[e][1]]).cos()))
            .sum();
        kinetic + edges
    },
    noise = [|q, p, k| sigma * q[k]; self.sites],
    embedding = Midpoint,
)]
struct Network {
    sites: usize,
    edges: Vec<[usize; 2]>,
    strength: Vec<f64>,
    /// Strength of the pushes.
    sigma: f64,
}

type Angles = State<DVector<f64>>;

const SITES: usize = 500;

fn main() -> Result<(), Box<dyn Error>> {
    let network = Network::random(SITES, 3.0, 20);
    let degrees = network.degrees();
    println!(
        "A random graph: {SITES} sites, {} edges, degrees {} to {}\n",
        network.edges.len(),
        degrees.iter().min().unwrap_or(&0),
        degrees.iter().max().unwrap_or(&0)
    );
    let modes = SymmetricEigen::new(network.laplacian());
    small(&network, &modes)?;
    let panels = [hot(&network)?, pushed(&network, &modes)?];
    stiff(&network)?;
    println!();
    plot::save("network", "network", 2, (1000, 640), &panels)
}

/// Numbers in [0, 1) by SplitMix64 (G. L. Steele, D. Lea, C. H. Flood, OOPSLA 2014).
struct Uniform(u64);

impl Uniform {
    fn draw(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

type Modes = SymmetricEigen<f64, wzvi::nalgebra::Dyn>;

impl Network {
    /// Every pair with probability `degree / sites`, strengths between 1/2 and 3/2.
    fn random(sites: usize, degree: f64, seed: u64) -> Self {
        let mut random = Uniform(seed);
        let (mut edges, mut strength) = (Vec::new(), Vec::new());
        for a in 0..sites {
            for b in 0..a {
                if random.draw() < degree / sites as f64 {
                    edges.push([a, b]);
                    strength.push(0.5 + random.draw());
                }
            }
        }
        Self { sites, edges, strength, sigma: 0.0 }
    }

    /// Angles and momenta at random, both up to `size`.
    fn start(&self, size: f64, seed: u64) -> Angles {
        let mut random = Uniform(seed);
        let mut draw = || (0..self.sites).map(|_| size * (2.0 * random.draw() - 1.0)).collect::<Vec<_>>();
        State::new(draw(), draw())
    }

    fn quiet(&self, steps: usize) -> Increments {
        Increments::from(vec![vec![0.0; self.sites]; steps])
    }

    fn degrees(&self) -> Vec<usize> {
        let mut degrees = vec![0; self.sites];
        self.edges.iter().flatten().for_each(|&site| degrees[site] += 1);
        degrees
    }

    fn laplacian(&self) -> DMatrix<f64> {
        let mut matrix = DMatrix::zeros(self.sites, self.sites);
        for (&[a, b], s) in self.edges.iter().zip(&self.strength) {
            matrix[(a, a)] += s;
            matrix[(b, b)] += s;
            matrix[(a, b)] -= s;
            matrix[(b, a)] -= s;
        }
        matrix
    }
}

/// Small deflections beside the exact rotations of the modes.
fn small(network: &Network, modes: &Modes) -> Result<(), Box<dyn Error>> {
    const STEPS: usize = 2000;
    println!("1. Small deflections after {STEPS} steps, beside rotations of the modes\n");
    let mut rows = Vec::new();
    for (size, h) in [(1e-3, 0.1), (1e-4, 0.1), (1e-4, 0.05)] {
        // From rest, so that disconnected parts of the graph do not move.
        let start = Angles { p: DVector::zeros(SITES), ..network.start(size, 1) };
        let path = network
            .simulate::<Midpoint>(h)
            .start(start.clone())
            .noise(network.quiet(STEPS))
            .steps(STEPS as u64)
            .record_every(0)
            .run()?;
        // In modes: x'' = -λ x, by angle `turn(√λ)` in every step.
        let exact = |turn: &dyn Fn(f64) -> f64| {
            let q = modes.eigenvectors.tr_mul(&start.q);
            let turned = |i: usize| q[i] * (STEPS as f64 * turn(modes.eigenvalues[i].max(0.0).sqrt())).cos();
            let end = DVector::from_fn(SITES, |i, _| turned(i));
            &modes.eigenvectors * end
        };
        let off =
            |expected: DVector<f64>| format!("{:.1e}", (&path.last().q - &expected).norm() / expected.norm());
        rows.push([
            format!("{size:e}"),
            h.to_string(),
            off(exact(&|omega| omega * h)),
            off(exact(&|omega| 2.0 * (0.5 * omega * h).atan())),
            format!("{:.1}", path.iterations().total as f64 / STEPS as f64),
        ]);
    }
    table::print(["deflection", "h", "off the network's rotations", "off the step's", "iterations"], &rows);
    println!("\n  What is left is the cosine's: the square of the deflections, times the angle turned.\n");
    Ok(())
}

/// Rotors that turn over.
fn hot(network: &Network) -> Result<Figure, Box<dyn Error>> {
    const END: f64 = 200.0;
    println!("2. Momenta up to 3, t ≤ {END}\n");
    let start = network.start(3.0, 2);
    let total = start.p.sum();
    let energy = network.energy(&start);
    let (mut rows, mut curves) = (Vec::new(), Vec::new());
    let mut drifts = Vec::new();
    for h in [0.1_f64, 0.05, 0.025] {
        let (mut momentum, mut drift, mut curve) = (0.0_f64, 0.0_f64, Vec::new());
        let each = (1.0 / h).round() as u64;
        let path = network
            .simulate::<Midpoint>(h)
            .start(start.clone())
            .noise(network.quiet((END / h).round() as usize))
            .until(END)
            .record_every(0)
            .inspect(|state, node| {
                let error = network.energy(state) / energy - 1.0;
                momentum = momentum.max((state.p.sum() - total).abs());
                drift = drift.max(error.abs());
                if node.step % each == 0 {
                    curve.push((state.t, error));
                }
            })
            .run()?;
        rows.push([
            h.to_string(),
            format!("{drift:.1e}"),
            format!("{momentum:.1e}"),
            format!("{:.1}", path.iterations().total as f64 / path.steps() as f64),
        ]);
        drifts.push(drift);
        curves.push((h, curve));
    }
    table::print(["h", "drift of H", "of Σ p", "iterations"], &rows);
    println!(
        "\n  The energy is kept up to h²: order {:.2} from the last two. Σ p = {total:.3} to rounding.\n",
        (drifts[1] / drifts[2]).log2()
    );
    let mut panel = Figure::panel("Turning rotors: energy", "t", "H/H(0) - 1");
    for ((h, curve), color) in curves.into_iter().zip([Colour::GREY, Colour::VERMILION, Colour::BLUE]) {
        panel = panel.line(format!("h = {h}"), color, curve);
    }
    Ok(panel)
}

/// Every site has its own Wiener process.
fn pushed(network: &Network, modes: &Modes) -> Result<Figure, Box<dyn Error>> {
    const H: f64 = 0.2;
    const PATHS: u64 = 60;
    const SIGMA: f64 = 0.05;
    let network = Network {
        sigma: SIGMA,
        edges: network.edges.clone(),
        strength: network.strength.clone(),
        ..*network
    };
    let start: Angles = State::new(vec![0.0; SITES], vec![0.0; SITES]);
    let mut energies = vec![Mean::default(); 51];
    for path in 0..PATHS {
        network
            .simulate::<Midpoint>(H)
            .start(start.clone())
            .noise(Wiener::seed(4).unit(H).path(path))
            .until(10.0)
            .inspect(|state, node| energies[node.step as usize].add(network.energy(state)))
            .run()?;
    }
    let exact = |t: f64| 0.5 * SIGMA * SIGMA * SITES as f64 * t;
    let taken: f64 =
        modes.eigenvalues.iter().map(|l| 1.0 / (1.0 + 0.25 * H * H * l)).sum::<f64>() / SITES as f64;
    println!("3. From rest, pushed at every site with σ = {SIGMA}, h = {H}, {PATHS} paths\n");
    let rows = [10, 25, 50].map(|i| {
        let t = H * i as f64;
        let (value, error) = (energies[i].value(), energies[i].standard_error());
        let expected = taken * exact(t);
        [
            format!("t = {t}"),
            format!("{value:.4} ± {error:.4}"),
            format!("{:.4}", exact(t)),
            format!("{expected:.4}"),
            format!("{:+.1}", (value - expected) / error),
        ]
    });
    table::print(["", "<H>", "σ² N t/2", "with this step", "standard errors apart"], &rows);
    println!();
    let times = || (0..51).map(|i| H * f64::from(i));
    Ok(Figure::panel("Pushed at every site: energy", "t", "<H>")
        .points(Look::Dashed, "σ² N t/2, continuous time", Colour::GREY, times().map(|t| (t, exact(t))))
        .line("with this step", Colour::VERMILION, times().map(|t| (t, taken * exact(t))))
        .points(Look::Dots, "mean of 60 paths", Colour::BLUE, times().zip(energies.iter().map(Mean::value))))
}

/// Steps too large for the fixed point.
fn stiff(network: &Network) -> Result<(), Box<dyn Error>> {
    const H: f64 = 2.0;
    println!("4. Ten steps of h = {H} from deflections up to 0.1\n");
    let run = |way: Iteration| -> Result<(Angles, u32), wzvi::Error> {
        let mut stepper = network.stepper::<Midpoint>(H)?.iteration(way);
        let mut state = network.start(0.1, 3);
        let mut iterations = 0;
        for _ in 0..10 {
            iterations += stepper.step(&mut state, &[0.0; SITES])?.iterations;
        }
        Ok((state, iterations))
    };
    let ((first, some), (second, few)) = (run(Iteration::Automatic)?, run(Iteration::Newton)?);
    println!(
        "  {some} iterations left to themselves, {few} by Newton's method alone; the ends are {:.1e} apart.",
        (&first.q - &second.q).amax()
    );
    Ok(())
}
