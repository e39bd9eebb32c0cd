use wzvi::prelude::*;

#[hamiltonian(drif = |q: [f64; N], p: [f64; N]| 0.5 * p[0] * p[0] + 0.5 * q[0] * q[0], embedding = Midpoint)]
struct Chain<const N: usize>;

#[hamiltonian(
    drift = |q: [[f64; 2]; N], p: [[f64; 2]; N]| 0.5 * p[0][0] * p[0][0] + strength * q[0][0],
    embedding = Midpoint,
)]
struct Points<const N: usize> {
    strengths: f64,
}

fn main() -> Result<(), wzvi::Error> {
    let chain = Chain::<3>;
    let mut state = State::new([0.1, 0.2, 0.3], [0.0; 3]);
    chain.stepper::<Midpoint>(0.1)?.step(&mut state, &[])?;
    let points = Points::<2> { strengths: 1.0 };
    let path = points.simulate::<Midpoint>(0.1).start(State::new([0.1; 4], [0.0; 4])).until(1.0).run()?;
    println!("{} {}", state.q[0], path.last().q[3]);
    Ok(())
}
