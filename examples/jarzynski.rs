//! Work on a trap that moves, or stiffens, in a heat bath: Jarzynski's equality at every step size.
//!
//! A particle in a harmonic trap, in equilibrium at first, is pulled or squeezed within two units of time. `W = ΔH - Q` is the work done on it, including the
//! shadow work of the scheme. Checks, for `Baoab` with a step of a half and of a thirty-second:
//!
//! * **Moving trap** (k = 2, v = 1): the work is normally distributed. Its mean is 2.3637 for short steps, and the variance is `2 kT` times the mean for every
//!   step, which is Jarzynski's equality `⟨e^{-W/kT}⟩ = 1` of a normal distribution.
//! * **Stiffening trap** (k from 1 to 3): `⟨e^{-W/kT}⟩ = √(1/3)`, the ratio of the partition functions, for every step.
//! * The last column is the same average without the shadow work.
//!
//! (C. Jarzynski, Phys. Rev. Lett. 78, 1997, 2690; D. A. Sivak, J. D. Chodera, G. E. Crooks, "Using nonequilibrium fluctuation theorems to understand and correct
//! errors in equilibrium and nonequilibrium simulations of discrete Langevin dynamics", Phys. Rev. X 3, 2013, define the shadow work.)
//!
//! `cargo run --release --example jarzynski`, a few seconds

use std::error::Error;

use wzvi::prelude::*;

const GAMMA: f64 = 0.7;
const KT: f64 = 0.5;
const PATHS: u64 = 100_000;

/// A harmonic trap at `v t`.
#[hamiltonian(
    drift = |q, p, t| 0.5 * p * p + 0.5 * (k + rate * t) * (q - v * t) * (q - v * t),
    friction = GAMMA,
    temperature = KT,
    embedding = Baoab,
)]
#[derive(Clone, Debug)]
pub struct Trap {
    /// Stiffness at the start.
    pub k: f64,
    /// How fast that grows.
    pub rate: f64,
    /// Velocity of the centre.
    pub v: f64,
}

/// Mean and variance of the work, and `⟨e^{-W/kT}⟩` with and without its shadow part.
struct Account {
    mean: f64,
    variance: f64,
    weights: [f64; 2],
}

fn account(trap: &Trap, h: f64) -> Result<Account, Box<dyn Error>> {
    let deviation = (KT / trap.k).sqrt();
    let run = trap
        .ensemble::<Baoab>(h)
        .starts(move |draw| State::new([deviation * draw.normal()], [KT.sqrt() * draw.normal()]))
        .observe_work();
    let statistics = run.paths(PATHS).seed(1).until(2.0).keep_paths(1 << 28).run()?;
    let column = |name: &str| -> Result<Vec<f64>, Box<dyn Error>> {
        let index =
            statistics.observables().iter().position(|known| known == name).ok_or("no such observable")?;
        let (paths, last) = (statistics.paths().ok_or("no paths")?, statistics.nodes().len() - 1);
        let values = (0..paths.count()).map(|path| paths.at(path, last).map(|values| values[index]));
        values.collect::<Option<_>>().ok_or_else(|| "no such path".into())
    };
    let (work, shadow) = (column("work")?, column("shadow work")?);
    let mean = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>() / work.len() as f64;
    let average = mean(&mut work.iter().copied());
    let weights = [
        mean(&mut work.iter().map(|w| (-w / KT).exp())),
        mean(&mut work.iter().zip(&shadow).map(|(w, shadow)| (-(w - shadow) / KT).exp())),
    ];
    let variance = mean(&mut work.iter().map(|w| (w - average) * (w - average)));
    Ok(Account { mean: average, variance, weights })
}

fn main() -> Result<(), Box<dyn Error>> {
    let n = PATHS as f64;
    println!("trap         h        mean W   var W / 2kT   <exp(-W/kT)>   without shadow work");
    for h in [0.5, 1.0 / 32.0] {
        let Account { mean, variance, .. } = account(&Trap { k: 2.0, rate: 0.0, v: 1.0 }, h)?;
        println!("moving       {h:<7}  {mean:.4}   {:<11.4}   -              -", variance / (2.0 * KT));
        // Four combined standard errors of the mean and the variance of normal numbers; the exponential is dominated by paths too rare to be sampled.
        let error = (variance / n + variance * variance / (2.0 * n * KT * KT)).sqrt();
        assert!((mean - variance / (2.0 * KT)).abs() < 4.0 * error, "{mean} {variance}");

        let Account { mean, variance, weights } = account(&Trap { k: 1.0, rate: 1.0, v: 0.0 }, h)?;
        let [weight, without] = weights;
        println!(
            "stiffening   {h:<7}  {mean:.4}   {:<11.4}   {weight:.4}         {without:.4}",
            variance / (2.0 * KT)
        );
        // The variance of the exponential is below its mean, which is below one.
        assert!((weight - 3.0_f64.sqrt().recip()).abs() < 4.0 / n.sqrt(), "{weight}");
    }
    Ok(())
}
