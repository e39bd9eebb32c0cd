//! The functions that the page calls: paths of the Kubo oscillator, and the mean of many. The page reads the numbers from the memory of the module.

use std::cell::RefCell;

use wzvi::prelude::*;

#[hamiltonian(
    drift = |q, p| 0.5 * a * (q * q + p * p),
    noise = [|q, p| 0.5 * sigma * (q * q + p * p)],
    embedding = [Uncorrected<DeltaPlus>, Corrected<DeltaPlus>, Midpoint],
)]
struct Kubo {
    a: f64,
    sigma: f64,
}

const A: f64 = 1.5;
const END: f64 = 20.0;

thread_local! {
    static NUMBERS: RefCell<Vec<f64>> = const { RefCell::new(Vec::new()) };
}

/// Where the numbers of the last answer are.
#[unsafe(no_mangle)]
pub extern "C" fn numbers() -> *const f64 {
    NUMBERS.with_borrow(|numbers| numbers.as_ptr())
}

/// A path up to t = 20 by embedding 0, 1 or 2: the number of nodes, each with t, q, p, H and the exact q. As far as it goes.
#[unsafe(no_mangle)]
pub extern "C" fn path(h: f64, sigma: f64, embedding: u32, seed: u32) -> usize {
    let kubo = Kubo { a: A, sigma };
    let rows = match embedding {
        0 => rows::<Uncorrected<DeltaPlus>>(&kubo, h, seed),
        1 => rows::<Corrected<DeltaPlus>>(&kubo, h, seed),
        _ => rows::<Midpoint>(&kubo, h, seed),
    };
    let rows = rows.unwrap_or_default();
    let nodes = rows.len() / 5;
    NUMBERS.set(rows);
    nodes
}

fn rows<E>(kubo: &Kubo, h: f64, seed: u32) -> Result<Vec<f64>, wzvi::Error>
where
    Kubo: Discretized<E, Vector = wzvi::nalgebra::SVector<f64, 1>>,
{
    let noise = Wiener::seed(u64::from(seed));
    let run = kubo.simulate::<E>(h).start(State::new([0.0], [1.0])).noise(noise).until(END);
    let (path, _) = run.run_partial()?;
    let nodes = path.iter().zip(path.wiener(0));
    Ok(nodes
        .flat_map(|(state, w)| {
            [state.t, state.q[0], state.p[0], kubo.energy(state), (kubo.a * state.t + kubo.sigma * w).sin()]
        })
        .collect())
}

/// The mean of q at t = 1 over so many paths of the mid-point embedding, its standard error, and the exact mean.
#[unsafe(no_mangle)]
pub extern "C" fn mean(h: f64, sigma: f64, paths: u32, seed: u32) -> usize {
    let kubo = Kubo { a: A, sigma };
    let run = kubo.ensemble::<Midpoint>(h).start(State::new([0.0], [1.0])).paths(u64::from(paths));
    let statistics = run.seed(u64::from(seed)).until(1.0).observe("q", |state| state.q[0]).run();
    let exact = (-0.5 * sigma * sigma).exp() * A.sin();
    let answer = statistics.and_then(|s| Ok(vec![s.mean("q")?, s.standard_error("q")?, exact]));
    let numbers = answer.unwrap_or_default();
    let count = numbers.len();
    NUMBERS.set(numbers);
    count
}
