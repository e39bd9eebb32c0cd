//! Fermi, Pasta, Ulam and Tsingou: a chain with nonlinear springs, started in its longest wave, does not come to
//! equilibrium but returns to its start; a hot chain does, as statistical mechanics says.
//!
//! `H = Σ p_i²/2 + Σ V(q_{i+1} - q_i)`, `V(d) = d²/2 + α d³/3 + β d⁴/4`, ends fixed.
//!
//! Four claims are checked:
//! * The experiment of E. Fermi, J. Pasta, S. Ulam, "Studies of nonlinear problems", Los Alamos LA-1940 (1955), figure 1
//!   (α = 1/4, 32 springs): the first mode gets its energy back after 157 of its periods (M. Toda, *Phys. Rep.* 18, 1975,
//!   for the same figure).
//! * Their figure 4 (β = 8): "the string will forever keep its symmetry", so that the even modes have no energy.
//! * For weak springs the first return is a beat of the modes 1 and 3, of period `2π/|3ω_1 - ω_3|`, that is
//!   `T_r = t_r/(N+1)³ → 2/π²`, and `T_r` depends on `S = E β (N+1)` alone (S. D. Pace, K. A. Reiss, D. K. Campbell,
//!   *Chaos* 29, 113107, 2019). A step has its own frequencies, `sin(ω' h/2) = ω h/2` for `DeltaPlus` and
//!   `tan(ω' h/2) = ω h/2` for `Midpoint`, and so its own return.
//! * A chain of 1024 particles in equilibrium has independent springs: `Σ p²/N = T`, and the moments of the lengths are
//!   those of `exp(-V(d)/T)`.
//!
//! Run with `cargo run --release --features svg --example fput`.

#[path = "support/plot.rs"]
mod plot;
#[path = "support/table.rs"]
mod table;

use std::error::Error;
use std::f64::consts::{PI, TAU};

use table::Mean;
use wzvi::nalgebra::DVector;
use wzvi::plot::{Colour, Figure, Look};
use wzvi::prelude::*;

#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let v = |d: f64| 0.5 * d * d + alpha * d * d * d / 3.0 + 0.25 * beta * d * d * d * d;
        let n = q.len();
        p.iter().map(|p| 0.5 * p * p).sum::<f64>()
            + v(q[0])
            + (1..n).map(|i| v(q[i] - q[i - 1])).sum::<f64>()
            + v(-q[n - 1])
    },
    embedding = [DeltaPlus, Midpoint],
)]
struct Fput {
    alpha: f64,
    beta: f64,
}

type Chain = State<DVector<f64>>;

fn main() -> Result<(), Box<dyn Error>> {
    let mut panels = vec![fermi_pasta_ulam()?, symmetric()?];
    weak_springs()?;
    scaling()?;
    panels.extend(equilibrium()?);
    println!();
    plot::save("fput", "energies", 2, (1000, 640), &panels)
}

/// The normal modes of the linear chain of `n` particles.
struct Modes {
    n: usize,
}

impl Modes {
    /// `ω_k = 2 sin(π k / 2(n+1))`
    fn frequency(&self, k: usize) -> f64 {
        2.0 * (0.5 * PI * k as f64 / (self.n + 1) as f64).sin()
    }

    fn shape(&self, k: usize) -> impl Iterator<Item = f64> {
        let angle = PI * k as f64 / (self.n + 1) as f64;
        (1..=self.n).map(move |i| (angle * i as f64).sin())
    }

    /// `(P_k² + ω_k² Q_k²)/2` with the orthonormal amplitudes.
    fn energy(&self, k: usize, state: &Chain) -> f64 {
        let amplitude = |x: &DVector<f64>| -> f64 { self.shape(k).zip(x).map(|(shape, x)| shape * x).sum() };
        let (q, p) = (amplitude(&state.q), amplitude(&state.p));
        (p * p + (self.frequency(k) * q).powi(2)) / (self.n + 1) as f64
    }

    fn start(&self, amplitude: f64) -> Chain {
        let q: Vec<f64> = self.shape(1).map(|shape| amplitude * shape).collect();
        State::new(q, vec![0.0; self.n])
    }
}

/// Energies of the odd, even or all modes over time.
struct History {
    times: Vec<f64>,
    /// By mode, from 1.
    energies: Vec<Vec<f64>>,
    drift: f64,
}

impl History {
    fn of<E>(fput: &Fput, n: usize, amplitude: f64, h: f64, end: f64) -> Result<Self, wzvi::Error>
    where
        Fput: Discretized<E, Vector = DVector<f64>>,
    {
        let modes = Modes { n };
        let start = modes.start(amplitude);
        let total = fput.energy(&start);
        let mut history = Self { times: Vec::new(), energies: vec![Vec::new(); 6], drift: 0.0 };
        let every = (2.0 / h).round() as u64;
        fput.simulate::<E>(h)
            .start(start)
            .until(end)
            .whole_steps()
            .record_every(0)
            .inspect(|state, node| {
                if node.step % every == 0 {
                    history.times.push(state.t);
                    for (k, energies) in (1..).zip(&mut history.energies) {
                        energies.push(modes.energy(k, state));
                    }
                    history.drift = history.drift.max((fput.energy(state) / total - 1.0).abs());
                }
            })
            .run()?;
        Ok(history)
    }

    /// The time of the first return of the energy of a mode, and the fraction of the largest change that it
    /// regains: the middle between the times at which its mean over `period` rises to three quarters of the change and
    /// goes down again.
    fn recurrence(&self, k: usize, period: f64) -> Option<(f64, f64)> {
        let means = self.means(k, period);
        let first = means.first()?.1;
        let away = |mean: f64| (mean - first).abs();
        let farthest = means.iter().map(|mean| away(mean.1)).fold(0.0, f64::max);
        let level = 0.25 * farthest;
        let crossing = |from: usize, is_far: bool| {
            let last = from + means[from..].iter().position(|mean| (away(mean.1) > level) == is_far)?;
            let [(t0, a), (t1, b)] = [*means.get(last.checked_sub(1)?)?, means[last]];
            Some((last, t0 + (t1 - t0) * (level - away(a)) / (away(b) - away(a))))
        };
        let (leaves, _) = crossing(1, true)?;
        let (returns, begin) = crossing(leaves, false)?;
        let (ends, end) = crossing(returns, true)?;
        let nearest = means[returns..ends].iter().map(|mean| away(mean.1)).fold(f64::INFINITY, f64::min);
        Some((0.5 * (begin + end), 1.0 - nearest / farthest))
    }

    /// Moving means of a mode's energy over one period of the first: the springs take and give within a period.
    fn means(&self, k: usize, period: f64) -> Vec<(f64, f64)> {
        let Some(step) = self.times.get(1) else { return Vec::new() };
        let energies = &self.energies[k - 1];
        let window = (period / step).round().max(1.0) as usize;
        let mut sum: f64 = energies.iter().take(window).sum();
        let mut means = Vec::new();
        for i in 0..energies.len().saturating_sub(window) {
            let middle = 0.5 * (self.times[i] + self.times[i + window]);
            means.push((middle, sum / window as f64));
            sum += energies[i + window] - energies[i];
        }
        means
    }

    fn curve(&self, k: usize, period: f64) -> Vec<(f64, f64)> {
        self.times.iter().map(|t| t / period).zip(self.energies[k - 1].iter().copied()).collect()
    }
}

/// The experiment of 1955.
fn fermi_pasta_ulam() -> Result<Figure, Box<dyn Error>> {
    let (modes, fput) = (Modes { n: 31 }, Fput { alpha: 0.25, beta: 0.0 });
    let period = TAU / modes.frequency(1);
    let end = 180.0 * period;
    let history = History::of::<Midpoint>(&fput, modes.n, 1.0, 0.05, end)?;
    let own_step = History::of::<DeltaPlus>(&fput, modes.n, 1.0, 0.125_f64.sqrt(), end)?;
    println!("1. Figure 1 of Fermi, Pasta and Ulam: 32 springs, α = 1/4, one sine wave of amplitude 1\n");
    let row = |name: &str, history: &History| -> Result<[String; 4], Box<dyn Error>> {
        let (t, fraction) = history.recurrence(1, period).ok_or("no recurrence")?;
        Ok([
            name.into(),
            format!("{:.1}", t / period),
            format!("{:.1} %", 100.0 * fraction),
            format!("{:.1e}", history.drift),
        ])
    };
    let rows = [row("Midpoint, h = 0.05", &history)?, row("DeltaPlus, h² = 1/8", &own_step)?];
    table::print(["scheme", "first return [periods]", "fraction regained", "drift of H"], &rows);
    let (fine, _) = history.recurrence(1, period).ok_or("no recurrence")?;
    let (coarse, _) = own_step.recurrence(1, period).ok_or("no recurrence")?;
    // A return takes as long as solitons need to meet, 1/√dispersion; the step leaves 1 - h² of the chain's.
    let expected = fine / (1.0_f64 - 0.125).sqrt();
    println!("\n  The figure shows the return after 157 periods: {:.1} by its own scheme.", coarse / period);
    println!(
        "  Its step is not small. It reduces the dispersion of the chain by the factor 1 - h², and delays the return by (1 - h²)^(-1/2):"
    );
    println!("  from {:.1} periods to {:.1}.\n", fine / period, expected / period);
    let mut panel = Figure::panel(
        "Fermi, Pasta, Ulam, figure 1: α = 1/4, 32 springs (Midpoint, h = 0.05)",
        "time [periods of mode 1]",
        "energy",
    );
    for (k, color) in [
        (1, Colour::BLUE),
        (2, Colour::VERMILION),
        (3, Colour::GREEN),
        (4, Colour::OCHRE),
        (5, Colour::PURPLE),
    ] {
        panel = panel.line(format!("mode {k}"), color, history.curve(k, period));
    }
    Ok(panel)
}

/// Springs that pull as they push.
fn symmetric() -> Result<Figure, Box<dyn Error>> {
    let (modes, fput) = (Modes { n: 31 }, Fput { alpha: 0.0, beta: 8.0 });
    let period = TAU / modes.frequency(1);
    let history = History::of::<Midpoint>(&fput, modes.n, 1.0, 0.05, 100.0 * period)?;
    let largest = |k: usize| history.energies[k - 1].iter().copied().fold(0.0, f64::max);
    println!("2. Their figure 4: β = 8. Largest energy of each mode in 100 periods, Midpoint, h = 0.05\n");
    let rows: Vec<[String; 2]> =
        (1..=6).map(|k| [format!("mode {k}"), format!("{:.1e}", largest(k))]).collect();
    table::print(["", "largest energy"], &rows);
    let even = [2, 4, 6].map(largest).into_iter().fold(0.0, f64::max);
    println!(
        "\n  The even modes have none by symmetry; measured at most {even:.1e} of {:.2}: rounding.\n",
        history.energies[0][0]
    );
    let mut panel = Figure::panel(
        "Fermi, Pasta, Ulam, figure 4: β = 8, 32 springs (Midpoint, h = 0.05)",
        "time [periods of mode 1]",
        "energy",
    );
    for (k, color) in [(1, Colour::BLUE), (3, Colour::GREEN), (5, Colour::PURPLE)] {
        panel = panel.line(format!("mode {k}"), color, history.curve(k, period));
    }
    Ok(panel)
}

/// The beat of modes 1 and 3, of the chain and of its steps.
fn weak_springs() -> Result<(), Box<dyn Error>> {
    const N: usize = 15;
    let modes = Modes { n: N };
    // S = E β (N+1) = 0.01: the shift of the return is of that order.
    let amplitude = (0.01 * 4.0_f64).sqrt() / (modes.frequency(1) * (N + 1) as f64);
    let fput = Fput { alpha: 0.0, beta: 1.0 };
    let period = TAU / modes.frequency(1);
    let beat =
        |own: &dyn Fn(f64) -> f64| TAU / (3.0 * own(modes.frequency(1)) - own(modes.frequency(3))).abs();
    println!("3. First return for weak springs, N = {N}, S = 0.01: the beat of modes 1 and 3\n");
    let mut rows = Vec::new();
    let mut row = |name: String, history: History, expected: f64| -> Result<(), Box<dyn Error>> {
        let (t, _) = history.recurrence(3, period).ok_or("no recurrence")?;
        let off = format!("{:+.1} %", 100.0 * (t / expected - 1.0));
        rows.push([name, format!("{t:.1}"), format!("{expected:.1}"), off]);
        Ok(())
    };
    for h in [0.125_f64.sqrt(), 0.125] {
        let end = 1.6 * beat(&|w| 2.0 / h * (0.5 * h * w).atan());
        let own = beat(&|w| 2.0 / h * (0.5 * h * w).asin());
        row(
            format!("DeltaPlus, h = {h:.3}"),
            History::of::<DeltaPlus>(&fput, N, amplitude, h, 1.6 * own)?,
            own,
        )?;
        let own = beat(&|w| 2.0 / h * (0.5 * h * w).atan());
        row(format!("Midpoint, h = {h:.3}"), History::of::<Midpoint>(&fput, N, amplitude, h, end)?, own)?;
    }
    table::print(["scheme", "first return", "2π/|3ω' - ω'|", "off by"], &rows);
    println!("\n  The chain itself: {:.1}.\n", beat(&|w| w));
    Ok(())
}

/// `T_r = t_r/(N+1)³` for several sizes at the same `S`.
fn scaling() -> Result<(), Box<dyn Error>> {
    println!("4. T_r = t_r/(N+1)³ by S = E β (N+1), DeltaPlus, h = 0.1\n");
    let mut rows = Vec::new();
    for s in [0.3_f64, 1.0, 3.0] {
        let mut row = vec![format!("{s}")];
        for n in [15_usize, 31, 63] {
            let modes = Modes { n };
            let fput = Fput { alpha: 0.0, beta: 1.0 };
            let period = TAU / modes.frequency(1);
            let amplitude = (4.0 * s).sqrt() / (modes.frequency(1) * (n + 1) as f64);
            let end = 0.4 * (n as f64 + 1.0).powi(3);
            let history = History::of::<DeltaPlus>(&fput, n, amplitude, 0.1, end)?;
            let (t, _) = history.recurrence(1, period).ok_or("no recurrence")?;
            row.push(format!("{:.4}", t / (n as f64 + 1.0).powi(3)));
        }
        rows.push(<[String; 4]>::try_from(row).map_err(|_| "four columns")?);
    }
    table::print(["S", "N = 15", "N = 31", "N = 63"], &rows);
    println!("\n  One value for each S, from 2/π² = {:.4} at S = 0.\n", 2.0 / (PI * PI));
    Ok(())
}

/// A hot chain of 1024 particles.
fn equilibrium() -> Result<[Figure; 2], Box<dyn Error>> {
    const N: usize = 1024;
    const H: f64 = 0.05;
    let fput = Fput { alpha: 0.0, beta: 1.0 };
    let mut wiener = Wiener::seed(1955);
    let p = (0..N).map(|i| Ok(1.5 * wiener.value(i, 1.0)?)).collect::<Result<Vec<f64>, wzvi::Error>>()?;
    let start: Chain = State::new(vec![0.0; N], p);
    let energy = fput.energy(&start);
    let lengths = |q: &DVector<f64>| -> Vec<f64> {
        let end = [0.0];
        let walls = end.iter().chain(q).chain(&end);
        walls.clone().zip(walls.skip(1)).map(|(left, right)| right - left).collect()
    };
    let mut means = [Mean::default(); 3];
    let (mut count, mut histogram, mut approach) = (0_u32, vec![0_u32; 80], Vec::new());
    let path = fput
        .simulate::<Midpoint>(H)
        .start(start)
        .until(1000.0)
        .record_every(0)
        .inspect(|state, node| {
            if node.step % 40 != 0 {
                return;
            }
            let temperature = state.p.norm_squared() / N as f64;
            approach.push((state.t, temperature));
            if state.t < 100.0 {
                return;
            }
            let lengths = lengths(&state.q);
            let moment = |power: i32| lengths.iter().map(|d| d.powi(power)).sum::<f64>() / (N + 1) as f64;
            for (mean, value) in means.iter_mut().zip([temperature, moment(2), moment(4)]) {
                mean.add(value);
            }
            for d in lengths {
                if let Some(bin) = histogram.get_mut(((d + 4.0) * 10.0).floor() as usize) {
                    *bin += 1;
                }
            }
            count += 1;
        })
        .run()?;
    // The temperature at which N momenta and N + 1 springs have this energy.
    let (mut low, mut high) = (0.0, 10.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        let [potential, ..] = spring(&fput, middle);
        let total = 0.5 * middle * N as f64 + potential * (N + 1) as f64;
        if total < energy { low = middle } else { high = middle }
    }
    let temperature = low;
    let [_, square, fourth] = spring(&fput, temperature);
    println!("5. N = {N}, β = 1, random momenta; means from t = 100 to 1000, Midpoint, h = {H}\n");
    let row = |name: &str, mean: &Mean, expected: f64| {
        let (value, error) = (mean.value(), mean.standard_error());
        let off = format!("{:+.1}", (value - expected) / error);
        [name.into(), format!("{value:.4} ± {error:.4}"), format!("{expected:.4}"), off]
    };
    let rows = [
        row("temperature <p²>", &means[0], temperature),
        row("springs <d²>", &means[1], square),
        row("springs <d⁴>", &means[2], fourth),
    ];
    table::print(["", "measured", "equilibrium", "standard errors apart"], &rows);
    println!(
        "\n  Energy from {energy:.3} to {:.3}; {:.1} iterations per step.",
        fput.energy(path.last()),
        path.iterations().total as f64 / path.steps() as f64
    );
    let samples = f64::from(count) * (N + 1) as f64;
    let density = histogram
        .iter()
        .enumerate()
        .map(|(bin, &hits)| (-4.0 + 0.1 * (bin as f64 + 0.5), f64::from(hits) / (0.1 * samples)));
    let partition = integral(|d| (-fput.spring(d) / temperature).exp());
    let curve = (0..=160)
        .map(|i| -4.0 + 0.05 * f64::from(i))
        .map(|d| (d, (-fput.spring(d) / temperature).exp() / partition));
    Ok([
        Figure::panel("N = 1024: kinetic temperature", "time", "Σ p²/N")
            .line("Midpoint, h = 0.05", Colour::BLUE, approach)
            .points(
                Look::Dashed,
                "equilibrium at this energy",
                Colour::GREY,
                [(0.0, temperature), (1000.0, temperature)],
            ),
        Figure::panel("N = 1024: lengths of the springs", "d", "density")
            .line("exp(-V(d)/T)/Z", Colour::GREY, curve)
            .points(Look::Dots, "measured", Colour::VERMILION, density),
    ])
}

impl Fput {
    fn spring(&self, d: f64) -> f64 {
        0.5 * d * d + self.alpha * d.powi(3) / 3.0 + 0.25 * self.beta * d.powi(4)
    }
}

/// Means of `V(d)`, `d²` and `d⁴` of a spring at a temperature.
fn spring(fput: &Fput, temperature: f64) -> [f64; 3] {
    let weight = |d: f64| (-fput.spring(d) / temperature).exp();
    let partition = integral(weight);
    let mean = |value: &dyn Fn(f64) -> f64| integral(|d| value(d) * weight(d)) / partition;
    [mean(&|d| fput.spring(d)), mean(&|d| d * d), mean(&|d| d.powi(4))]
}

/// The trapezoidal rule over [-10, 10], exponentially accurate for what has vanished there.
fn integral(f: impl Fn(f64) -> f64) -> f64 {
    (-2000..=2000).map(|i| 0.005 * f(0.005 * f64::from(i))).sum()
}
