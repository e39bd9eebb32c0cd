#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) + y,
    constraint = [|[x, y], [px, py]| x * px + y * py],
    embedding = Rattle,
)]
struct Nonholonomic;

#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) + y,
    constraint = [|[x, y]| l - 1.0, |[x, y]| x * x + y * y - l * l],
    embedding = Rattle,
)]
struct OfNothing {
    l: f64,
}

#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py),
    constraint = [|[x, y]| x * x + y * y + 1.0, |[x, y]| y - 2.0 * x - 1.0],
    embedding = Rattle,
)]
struct NoPoints;

#[hamiltonian(
    drift = |[x, y, z], [px, py, pz]| 0.5 * (px * px + py * py + pz * pz),
    constraint = [
        |[x, y, z]| x * x + y * y + z * z - l * l,
        |[x, y, z]| a * x * x + a * y * y - a * l * l + a * z * z,
        |[x, y, z]| x * y - z,
        |[x, y, z]| 3.0 * z - 3.0 * x * y,
    ],
    embedding = Rattle,
)]
struct Multiples {
    l: f64,
    a: f64,
}

#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py),
    constraint = [|[x, y]| x * x + y * y - 1.0],
    embedding = [Verlet, Midpoint, Gauss<2>],
)]
struct OtherSchemes;

#[hamiltonian(drift = |q, p| 0.5 * p * p + q * q, embedding = [Rattle, Verlet])]
struct NoConstraint;

#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py),
    constraint = [|[x, y]| x * x + y * y - 1.0],
    embedding = GBaoab,
)]
struct NoTemperature;

#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py),
    constraint = [|[x, y]| x * x + y * y - 1.0],
    friction = [1.0, 2.0],
    temperature = 0.5,
    embedding = GBaoab,
)]
struct Rates;

#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py),
    constraint = [|[x, y]| x * x + y * y - 1.0],
    damping = [[1.0, 0.1], [0.1, 1.0]],
    temperature = 0.5,
    embedding = GBaoab,
)]
struct Matrix;

#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py),
    constraint = [|[x, y]| x * x + y * y - 1.0],
    friction = [1.0, 2.0],
    embedding = Rattle,
)]
struct RatesOfRattle;

#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py),
    noise = |[x, y], [px, py]| sigma * px,
    constraint = [|[x, y]| x * x + y * y - 1.0],
    embedding = Rattle,
)]
struct Leaves {
    sigma: f64,
}

#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py),
    constraint = [|[x, y]| x * x + 2.0 * y * y - 1.0],
    invariant = |[x, y], [px, py]| x * py - y * px,
    embedding = Rattle,
)]
struct NotOfTheEllipse;

#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py + px * py),
    constraint = [|[x, y]| x * x + y * y - 1.0],
    embedding = Rattle,
)]
struct Coupled;

#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py),
    constraint = [|[x, y], k| x * x + y * y - 1.0],
    embedding = Rattle,
)]
struct Family;

#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py),
    constraint = [|[x, y]| x * x + y * y - 1.0],
    embedding = Modified<Rattle>,
)]
struct ModifiedEnergy;
