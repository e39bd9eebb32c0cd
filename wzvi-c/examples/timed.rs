//! Times a million paths of Kubo's oscillator over 200 steps, in seconds: `python/benches/costs.py` compares with
//! it. The number of threads is the argument.

#![forbid(unsafe_code)]

use std::time::Instant;

use wzvi::prelude::*;

#[path = "systems/definitions.rs"]
#[allow(dead_code, reason = "it has more systems")]
mod definitions;

use definitions::Kubo;

fn main() -> Result<(), wzvi::Error> {
    let threads = std::env::args().nth(1).and_then(|threads| threads.parse().ok()).unwrap_or(1);
    let kubo = Kubo { a: 1.5, sigma: 1.0 };
    let began = Instant::now();
    let run = kubo.ensemble::<Midpoint>(0.02).start(State::new([0.0], [1.0])).paths(1_000_000).seed(7);
    run.until(4.0).observe("q", |state| state.q[0]).covariances(false).threads(threads).run()?;
    println!("{}", began.elapsed().as_secs_f64());
    Ok(())
}
