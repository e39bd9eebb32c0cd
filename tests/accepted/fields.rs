//! Fields as exponents and as numbers of noises, and literals that come out of `macro_rules!`.

use wzvi::prelude::*;

/// At q = 0 the force of `q^0` and `q` is smooth: 0 and -1.
#[hamiltonian(drift = |q, p| 0.5 * p * p + q.powi(n) + q.powf(b), embedding = [Midpoint, DeltaPlus])]
struct Powers {
    n: i32,
    b: f64,
}

/// One noise for each of the first `m` sites.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| (0..q.len()).map(|i| 0.5 * (p[i] * p[i] + q[i] * q[i])).sum::<f64>(),
    noise = [|q, p, k| sigma * q[k]; m],
    embedding = Midpoint,
)]
struct Sites {
    m: usize,
    sigma: f64,
}

macro_rules! chain {
    ($name:ident, $n:literal) => {
        #[hamiltonian(
            drift = |q: [f64; $n], p: [f64; $n]| (0..$n).map(|i| 0.5 * (p[i] * p[i] + q[i] * q[i])).sum::<f64>(),
            noise = [|q, p, k| 0.1 * q[k]; $n],
            embedding = Midpoint,
        )]
        struct $name;
    };
}

chain!(Short, 3);
chain!(Long, 40);

#[test]
fn compiles_and_runs() -> Result<(), wzvi::Error> {
    // The force at rest, h times it after one explicit step from q = 0, p = 0.
    for (n, b, force) in
        [(0, 0.0, 0.0), (1, 2.0, -1.0), (0, 1.0, -1.0), (1, 1.0, -2.0), (2, 3.0, 0.0), (2, 2.0, 0.0)]
    {
        let system = Powers { n, b };
        let h = 0.125;
        let mut state = State::new([0.0], [0.0]);
        system.stepper::<DeltaPlus>(h)?.step(&mut state, &[])?;
        assert_eq!(state.p[0], h * force, "n = {n}, b = {b}");
        let mut state = State::new([0.0], [0.0]);
        system.stepper::<Midpoint>(h)?.step(&mut state, &[])?;
        assert!(state.p[0].is_finite());
    }

    let sites = Sites { m: 2, sigma: 0.5 };
    assert_eq!(sites.noises(), 2);
    let mut state = State::new(vec![1.0, 2.0, 3.0], vec![0.0; 3]);
    sites.stepper::<Midpoint>(0.1)?.step(&mut state, &[0.1, -0.1])?;
    let mut short = State::new([1.0, 2.0, 3.0], [0.0; 3]);
    Short.stepper::<Midpoint>(0.1)?.step(&mut short, &[0.1, -0.1, 0.0])?;
    assert_eq!((Short.noises(), Long.noises()), (3, 40));
    Ok(())
}
