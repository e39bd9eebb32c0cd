#[hamiltonian(
    drift = |q: [f64; N], p: [f64; N]| (0..N).map(|i| p[i] * q[i + 1]).sum::<f64>() + q[N],
    embedding = Midpoint,
)]
struct Beyond<const N: usize>;

#[hamiltonian(drift = |q: &[f64], p: &[f64]| (0..q.len()).map(|i| p.iter().map(|p| p * q[i]).sum::<f64>().cos()).sum::<f64>(), embedding = Midpoint)]
struct Nonlinear;

#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let mut total = 0.0;
        for i in 0..q.len() {
            total = total * p[i] + q[i];
        }
        total
    },
    embedding = Midpoint,
)]
struct Loop;

#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| p.iter().zip(q).map(|(p, q)| p * q).sum::<f64>(),
    invariant = [
        |q: &[f64], p: &[f64]| p.iter().sum::<f64>(),
        |q: &[f64], p: &[f64]| q[0] * p[0],
        |q, p, t| p.iter().map(|p| p * t).sum::<f64>(),
    ],
    embedding = Midpoint,
)]
struct Integral;

#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| p.iter().zip(q).map(|(p, q)| p * q).sum::<f64>(),
    noise = [|q, p, k| q[k] * p[(k + 1) % 3]; 3],
    embedding = [DeltaPlus, Corrected<DeltaPlus>],
)]
struct Inconsistent;
