const DEPTH: f64 = 1.0;

#[hamiltonian_fn]
fn relative(r: f64) -> f64 {
    DEPTH * r
}

#[hamiltonian_fn]
#[allow(unconditional_recursion)]
fn endless(n: f64) -> f64 {
    endless(n - 1.0)
}

#[hamiltonian_fn]
fn generic<const N: usize>(x: [f64; N]) -> f64 {
    x[0]
}

#[hamiltonian_fn]
struct Nothing;
