#[hamiltonian(drift = |q| q, embedding = Midpoint)]
struct One;

#[hamiltonian(drift = |q, p, t, s| q, embedding = Midpoint)]
struct Four;

#[hamiltonian(drift = |(x, y), (px, py)| x, embedding = Midpoint)]
struct Tuples;

#[hamiltonian(drift = |mut q, p| q, embedding = Midpoint)]
struct Mutable;

#[hamiltonian(drift = |q: f32, p: i32| q, embedding = Midpoint)]
struct Types;

#[hamiltonian(drift = |[], []| 0.0, embedding = Midpoint)]
struct Nothing;

#[hamiltonian(drift = |q, p, [t]| 0.0, embedding = Midpoint)]
struct Times;

#[hamiltonian(drift = |[x, ..], p: [f64; 3]| x, embedding = Midpoint)]
struct Rest;

#[hamiltonian(drift = |q: Vec<f64>, p: Vec<f64>| q[0] * p[0], embedding = Midpoint)]
struct Vectors;

#[hamiltonian(drift = |q: [[f64; N]; 2], p: [[f64; N]; 2]| 0.0, embedding = Midpoint)]
struct Inner;

#[hamiltonian(
    drift = |q: [f64; 2], p: [f64; 2]| 0.0,
    noise = [|_, p: f64| 1.0, |q: f64, _| 1.0],
    embedding = Midpoint,
)]
struct Smaller;

#[hamiltonian(drift = |p, q| p, noise = [|p, q| p, |q, p| q], embedding = Midpoint)]
struct Swapped;

#[hamiltonian(drift = |p: f64, q: f64, t| p * t, embedding = Midpoint)]
struct SwappedTypes;

#[hamiltonian(drift = |[px, py], [x, y]| x, embedding = Midpoint)]
struct SwappedNames;

#[hamiltonian(drift = |[p1, p2], [q1, q2]| q1, embedding = Midpoint)]
struct SwappedNumbers;

#[hamiltonian(
    drift = |[a, b]: [Rotation; 2], [pa, pb]| 0.5 * pa[0][0] * pa[0][0],
    constraint = [|[a, b]| a[0][0] - b[0][0]],
    embedding = Rattle,
)]
struct RotationsApart;

#[hamiltonian(drift = |q: Rotation, p: Rotation| 0.5 * p[0][0] * p[0][0], embedding = Rattle)]
struct MomentaOfRotation;

#[hamiltonian(drift = |q: [[Rotation; 2]; 2], p| 0.5 * p[0][0][0][0] * p[0][0][0][0], embedding = Rattle)]
struct RotationsOnGrid;
