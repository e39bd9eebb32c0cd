#[hamiltonian(
    drift = |[x, y], [px, py], time| 0.5 * (px * px + py * py) + x * x + y * y,
    invariant = [momentum = |[x, y], [px, py]| x * py - y * px],
    observe = [
        radius = |[x, y], _| x.hypot(y),
        |[x, y], _| x - y,
        radius = |[x, y], _| x + y,
        x = |[x, _], _| x,
        py = |_, [_, py]| py,
        time = |_, _, time| time,
        energy = |[x, y], _| x * y,
        momentum = |[x, y], [px, py]| x * py + y * px,
    ],
    embedding = Midpoint,
)]
struct Taken;

#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| p.iter().map(|p| 0.5 * p * p).sum::<f64>(),
    invariant = |_, p: &[f64]| p.iter().sum::<f64>(),
    observe = [
        [site = |q, _, k| q[k]; 3],
        q = |q, _| q[0],
        invariant_0 = |q, _| q[0],
    ],
    embedding = Midpoint,
)]
struct Sites;

#[hamiltonian(drift = |q, p| 0.5 * p * p, observe = |q, _| q.abs(), embedding = Midpoint)]
struct Single;

#[hamiltonian(drift = |q, p| 0.5 * p * p, observe = [], embedding = Midpoint)]
struct Empty;

#[hamiltonian(drift = |q, p| 0.5 * p * p, observables = [size = |q, _| q.abs()], embedding = Midpoint)]
struct Misspelt;

#[hamiltonian(
    drift = |q: [f64; 2], p: [f64; 2]| p[0] * p[0] + p[1] * p[1],
    observe = [outside = |q, _| q[2], size = |q, _, w| q[0] + w, wrong = |q| q[0]],
    embedding = Midpoint,
)]
struct Outside;

#[hamiltonian(drift = |q, p| 0.5 * p * p + k[0] * q, embedding = Verlet, export = [])]
struct Borrowed<'k> {
    k: &'k [f64],
}

#[hamiltonian(drift = |q, p| 0.5 * p * p, embedding = Verlet, export = ["Composed"])]
struct Quoted;

#[hamiltonian(drift = |q, p| 0.5 * p * p, embedding = Verlet, export)]
struct Flag;
