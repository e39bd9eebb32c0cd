//! A chain of rods: constraints in place of stiff springs.
//!
//! Twenty rods of length 1 with a mass at each joint hang on the origin. `g_k = (|r_k|² - 1)/2 = 0` for the rod
//! `r_k` between two joints; `Rattle` and its compositions keep the lengths at every node to rounding.
//!
//! What is checked:
//! * A chain that falls from a horizontal line keeps its energy, without drift, while its end cracks like a whip.
//! * With friction it comes to rest between two fixed ends, as a catenary of rods: the horizontal force is the same
//!   in every rod, and the vertical forces of neighbours differ by the weight of a joint. The forces are the
//!   multipliers.
//! * Stiff springs in place of rods: the error and the number of forces that they take for it.
//!
//! Run with `cargo run --release --features svg --example chain_of_rods`.

#[path = "support/plot.rs"]
mod plot;
#[path = "support/table.rs"]
mod table;

use std::error::Error;

use wzvi::nalgebra::DVector;
use wzvi::plot::{Colour, Figure, Look};
use wzvi::prelude::*;

/// A chain that hangs on the origin, and whose last joint may be held at a distance.
#[hamiltonian(
    drift = |q: &[[f64; 2]], p: &[[f64; 2]]| (0..q.len())
        .map(|i| 0.5 * (p[i][0] * p[i][0] + p[i][1] * p[i][1]) + q[i][1])
        .sum::<f64>(),
    constraint = [
        |q| 0.5 * (q[0][0] * q[0][0] + q[0][1] * q[0][1] - 1.0),
        [|q, k| {
            let (dx, dy) = (q[k + 1][0] - q[k][0], q[k + 1][1] - q[k][1]);
            0.5 * (dx * dx + dy * dy - 1.0)
        }; self.joints - 1],
        [|q, _| {
            let (dx, dy) = (q[self.joints - 1][0] - span, q[self.joints - 1][1]);
            0.5 * (dx * dx + dy * dy - 1.0)
        }; self.held],
    ],
    friction = gamma,
    embedding = Rattle,
)]
struct Chain {
    joints: usize,
    /// 1 if another rod goes from the last joint to `(span, 0)`, else 0.
    held: usize,
    span: f64,
    gamma: f64,
}

/// Springs in place of the rods.
#[hamiltonian(
    drift = |q: &[[f64; 2]], p: &[[f64; 2]]| {
        let spring = |dx: f64, dy: f64| 0.5 * stiffness * ((dx * dx + dy * dy).sqrt() - 1.0).powi(2);
        (0..q.len()).map(|i| 0.5 * (p[i][0] * p[i][0] + p[i][1] * p[i][1]) + q[i][1]).sum::<f64>()
            + spring(q[0][0], q[0][1])
            + (1..q.len()).map(|i| spring(q[i][0] - q[i - 1][0], q[i][1] - q[i - 1][1])).sum::<f64>()
    },
    embedding = Verlet,
)]
struct Springs {
    stiffness: f64,
}

type Joints = State<DVector<f64>>;

const JOINTS: usize = 20;

fn main() -> Result<(), Box<dyn Error>> {
    let panels = [falling()?, catenary()?];
    springs()?;
    println!();
    plot::save("chain_of_rods", "chain", 2, (1000, 420), &panels)
}

/// Joints on a horizontal line, at rest.
fn horizontal(joints: usize) -> Joints {
    let q: Vec<f64> = (1..=joints).flat_map(|i| [i as f64, 0.0]).collect();
    State::new(q, vec![0.0; 2 * joints])
}

/// The places of the joints, from the origin.
fn places(state: &Joints) -> Vec<(f64, f64)> {
    let joints = state.q.as_slice().chunks(2).map(|joint| (joint[0], joint[1]));
    std::iter::once((0.0, 0.0)).chain(joints).collect()
}

fn largest_error_of_lengths(state: &Joints) -> f64 {
    let places = places(state);
    let lengths = places.windows(2).map(|ends| (ends[1].0 - ends[0].0).hypot(ends[1].1 - ends[0].1));
    lengths.map(|length| (length - 1.0).abs()).fold(0.0, f64::max)
}

fn falling() -> Result<Figure, Box<dyn Error>> {
    let chain = Chain { joints: JOINTS, held: 0, span: 0.0, gamma: 0.0 };
    let start = horizontal(JOINTS);
    let path = chain.simulate::<Rattle>(0.002).start(start.clone()).until(8.0).run()?;
    let energy = chain.energy(&start);
    let errors = |of: &dyn Fn(&Joints) -> f64| path.states().iter().map(of).fold(0.0, f64::max);
    println!("A chain of {JOINTS} rods falls from a horizontal line, 4000 steps of 0.002\n");
    println!("  largest error of a length: {:.1e}", errors(&largest_error_of_lengths));
    println!(
        "  largest error of the energy: {:.1e}, of some 200 that turn into motion",
        errors(&|state| { (chain.energy(state) - energy).abs() })
    );
    let mut panel = Figure::panel("A chain of rods falls", "x", "y").equal_axes();
    for (number, step) in [0, 1000, 1750, 2250, 2750, 3250].into_iter().enumerate() {
        if let Some(state) = path.states().get(step) {
            panel = panel.line(format!("t = {}", state.t), number, places(state));
        }
    }
    Ok(panel)
}

/// The chain between two points comes to rest.
fn catenary() -> Result<Figure, Box<dyn Error>> {
    let chain = Chain { joints: JOINTS, held: 1, span: 15.0, gamma: 0.5 };
    // A start near the ends: a triangle, projected.
    let half = 0.5 * (JOINTS + 1) as f64;
    let depth = (half * half - 7.5 * 7.5).sqrt();
    let q: Vec<f64> = (1..=JOINTS)
        .flat_map(|i| {
            let way = i as f64 / half;
            [7.5 * way, -depth * if way < 1.0 { way } else { 2.0 - way }]
        })
        .collect();
    let start = State::new(q, vec![0.0; 2 * JOINTS]);
    let path =
        chain.simulate::<Rattle>(0.02).start(start).project_start().until(120.0).record_every(0).run()?;
    let rest = path.last();
    let multipliers = chain.multipliers(rest).ok_or("a singular chain")?;
    let mut joints = places(rest);
    joints.push((15.0, 0.0));
    let forces: Vec<(f64, f64)> = joints
        .windows(2)
        .zip(&multipliers)
        .map(|(ends, lambda)| (lambda * (ends[1].0 - ends[0].0), lambda * (ends[1].1 - ends[0].1)))
        .collect();
    let mean = forces.iter().map(|force| force.0).sum::<f64>() / forces.len() as f64;
    let horizontal = forces.iter().map(|force| (force.0 - mean).abs()).fold(0.0, f64::max);
    let vertical = forces.windows(2).map(|two| (two[1].1 - two[0].1 - 1.0).abs()).fold(0.0, f64::max);
    println!("\nThe same chain at rest between two points 15 apart\n");
    println!("  horizontal force in all rods {mean:.6}, up to {horizontal:.1e}");
    println!("  vertical forces of neighbours differ by the weight 1 of a joint, up to {vertical:.1e}");
    let forces = multipliers.iter().enumerate().map(|(k, lambda)| (k as f64, *lambda)).collect::<Vec<_>>();
    Ok(Figure::panel(
        "Pull of the rods of a chain at rest between two points",
        "rod",
        "force / weight of a joint",
    )
    .points(Look::Dots, "", Colour::INK, forces))
}

/// The error of the free end of a short chain, by springs and by rods.
fn springs() -> Result<(), Box<dyn Error>> {
    const SHORT: usize = 5;
    let chain = Chain { joints: SHORT, held: 0, span: 0.0, gamma: 0.0 };
    let end = 2.0;
    let exact = chain
        .simulate::<Composed<Rattle, KahanLi6>>(0.002)
        .start(horizontal(SHORT))
        .until(end)
        .record_every(0)
        .run()?;
    let error = |last: &Joints| (&last.q - &exact.last().q).amax();
    let mut rows = Vec::new();
    for stiffness in [1e3_f64, 1e4, 1e5] {
        let h = 0.5 / stiffness.sqrt();
        let springs = Springs { stiffness };
        let run = springs.simulate::<Verlet>(h).start(horizontal(SHORT)).until(end);
        let soft = error(run.record_every(0).run()?.last());
        // Rods with about the same error.
        let mut h_rods = 0.2;
        let mut rigid = f64::INFINITY;
        while rigid > soft {
            h_rods *= 0.8;
            let run = chain.simulate::<Rattle>(h_rods).start(horizontal(SHORT)).until(end);
            rigid = error(run.record_every(0).run()?.last());
        }
        let row = [
            format!("{stiffness:.0e}"),
            format!("{soft:.1e}"),
            format!("{:.0}", end / h),
            format!("{rigid:.1e}"),
            format!("{:.0}", end / h_rods),
            format!("{:.1}", h_rods / h),
        ];
        rows.push(row);
    }
    println!("\nFive rods to t = {end}, and springs in their place\n");
    let headings = ["stiffness", "error, springs", "steps", "error, rods", "steps", "ratio of steps"];
    table::print(headings, &rows);
    Ok(())
}
