//! The whole paper.
use wzvi::prelude::*;

/// Kubo oscillator.
#[hamiltonian(
    drift = |q, p| 0.5 * a * (q * q + p * p),
    noise = [|q, p| 0.5 * sigma * (q * q + p * p)],
    embedding = [Uncorrected<DeltaPlus>, Corrected<DeltaPlus>, Midpoint],
    invariant = [|q, p| q * q + p * p],
)]
pub struct Kubo {
    /// Mean angular frequency.
    pub a: f64,
    /// Intensity of the noise.
    pub sigma: f64,
}

fn main() -> Result<(), wzvi::Error> {
    let kubo = Kubo { a: 1.5, sigma: 1.0 };
    let report = WorkPrecision::new(&kubo)
        .start(State::new([0.0], [1.0]))
        .until(1.0)
        .steps((3..=10).map(|k| 2f64.powi(-k)))
        .paths(400)
        .seed(7)
        .exact(|t, wiener| {
            let (sin, cos) = (kubo.a * t + kubo.sigma * wiener[0]).sin_cos();
            State::new([sin], [cos])
        })
        .observable("q", |state| state.q[0])
        .scheme::<Midpoint>()
        .scheme::<Corrected<DeltaPlus>>()
        .scheme::<Uncorrected<DeltaPlus>>()
        .run()?;
    report.print();
    report.write("target/wzvi/paper")?;
    Ok(())
}
