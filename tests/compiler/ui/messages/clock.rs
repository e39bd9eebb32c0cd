#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.5 * q * q,
    clock = hessian,
    embedding = Clocked<Verlet>,
)]
struct Unknown;

#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.5 * q * q,
    clock = curvature(),
    embedding = Clocked<Verlet>,
)]
struct NoFrequency;

#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.5 * q * q,
    clock = pairs(3.0),
    embedding = Clocked<Verlet>,
)]
struct PairsWithNumber;

#[hamiltonian(drift = |q, p| 0.5 * p * p + 0.5 * q * q, embedding = [Clocked<Verlet>, Extended<Gauss<8>>])]
struct WithoutClock;

#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.5 * q * q,
    clock = |q, _| 1.0 + q * q,
    embedding = [
        Clocked<DeltaPlus>,
        Clocked<Lambda<1, 3>>,
        Clocked<Mixed<Midpoint, DeltaPlus>>,
        Clocked<Baoab>,
        Clocked<Rattle>,
        Clocked<Composed<Verlet, Yoshida4>>,
        Composed<Clocked<Verlet>, KahanLi8>,
        Composed<Extended<Verlet>, KahanLi8>,
        Clocked<Extended<Verlet>>,
        Corrected<Clocked<Midpoint>>,
        Thermostat<Clocked<Midpoint>>,
        Extended<Midpoint>,
        Extended<Gauss<1>>,
        Logarithmic<0, 1>,
        Logarithmic,
        Clocked,
        Clocked<Verlet>,
        Clocked<Verlet>,
    ],
)]
struct Schemes;

#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.5 * q * q,
    noise = |q, p| sigma * p,
    clock = |q, _| 1.0 + q * q,
    embedding = [Clocked<Verlet>, Extended<Verlet>],
)]
struct MovingNoise {
    sigma: f64,
}

#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.5 * q * q,
    noise_force = |q, p| sigma * q,
    clock = |q, p| 1.0 + p * p,
    embedding = Clocked<Midpoint>,
)]
struct PushingNoise {
    sigma: f64,
}

#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.5 * q * q,
    noise = |q, p| sigma * q,
    clock = |q, _| 1.0 + q * q,
    embedding = [Clocked<Verlet>, Extended<Verlet>],
)]
struct NoiseOfExtended {
    sigma: f64,
}

#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.5 * q * q,
    friction = gamma,
    clock = |q, _| 1.0 + q * q,
    embedding = [Clocked<Verlet>, Extended<Gauss<2>>],
)]
struct FrictionOfExtended {
    gamma: f64,
}

#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.5 * q * q,
    force = |q, p, t| t.sin(),
    clock = |q, _| 1.0 + q * q,
    embedding = [Clocked<Verlet>, Extended<Gauss<2>>],
)]
struct ForceOfExtended;

#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.5 * q * q,
    clock = |q, p| 1.0 + p * p,
    embedding = [Extended<Gauss<2>>, Extended<Verlet>],
)]
struct MomentaOfExtended;

#[hamiltonian(
    drift = |q, p| 0.5 * p * p / (1.0 + q * q) + 0.5 * q * q,
    clock = |q, p| 1.0 + q * q,
    embedding = Extended<Verlet>,
)]
struct MassOfExtended;

#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.5 * q * q,
    friction = gamma,
    temperature = 1.0,
    clock = |q, p| 1.0 + p * p,
    embedding = Baoab,
)]
struct Warm {
    gamma: f64,
}

#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py),
    constraint = [|[x, y]| x * x + y * y - 1.0],
    clock = |[x, y], _| 1.0 + x * x,
    embedding = Rattle,
)]
struct Constrained;

#[hamiltonian(drift = |q, p| 0.5 * p * p + g * q, clock = curvature, embedding = Clocked<Verlet>)]
struct Linear {
    g: f64,
}

#[hamiltonian(drift = |q, p| 0.5 * p * p - omega * omega * q.cos(), clock = curvature, embedding = Clocked<Verlet>)]
struct Pendulum {
    omega: f64,
}

#[hamiltonian(drift = |q, p| 0.5 * p * p + 0.25 * q.powi(4), clock = curvature(w), embedding = Clocked<Verlet>)]
struct NoSuchField;

#[hamiltonian(drift = |q, p| 0.5 * p * p + 0.25 * q.powi(4), clock = curvature(q), embedding = Clocked<Verlet>)]
struct FrequencyOfState;

#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| (0..q.len()).map(|i| 0.5 * (p[i] * p[i] + q[i] * q[i])).sum::<f64>(),
    clock = curvature,
    embedding = Clocked<Verlet>,
)]
struct AnySize;

#[hamiltonian(
    drift = |q: [f64; 32], p: [f64; 32]| (0..32).map(|i| 0.5 * (p[i] * p[i] + q[i] * q[i])).sum::<f64>(),
    clock = curvature,
    embedding = Clocked<Verlet>,
)]
struct ManyCoordinates;

#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) - 1.0 / (x * x + y * y).sqrt(),
    clock = pairs,
    embedding = Clocked<Verlet>,
)]
struct OneBody;

#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| (0..q.len()).map(|i| 0.5 * (p[i] * p[i] + q[i] * q[i])).sum::<f64>(),
    clock = pairs,
    embedding = Clocked<Verlet>,
)]
struct Springs;

#[hamiltonian(
    drift = |q: [[f64; 2]; 2], p: [[f64; 2]; 2]| {
        (0..2).map(|i| p[i][0] * p[i][0] + 2.0 * p[i][1] * p[i][1]).sum::<f64>()
            - 1.0 / ((q[1][0] - q[0][0]).powi(2) + (q[1][1] - q[0][1]).powi(2)).sqrt()
    },
    clock = pairs,
    embedding = Clocked<Verlet>,
)]
struct MassesOfComponents;

#[hamiltonian(drift = |q, p| (1.0 + p * p).sqrt() + 0.5 * q * q, clock = pairs, embedding = Clocked<Verlet>)]
struct NoMasses;

#[hamiltonian(drift = |q, p| 0.5 * p * p + 0.5 * q * q, clock = |q, p| 0.0 * q, embedding = Clocked<Verlet>)]
struct Zero;

#[hamiltonian(drift = |q, p| 0.5 * p * p + 0.5 * q * q, embedding = Logarithmic<1, 1>)]
struct PositivePotential;

#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) - k / (x * x + y * y).sqrt() + 0.1,
    embedding = Logarithmic<1, 1>,
)]
struct ShiftedPotential {
    k: f64,
}

#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) + px * y - py * x - 1.0 / (x * x + y * y).sqrt(),
    embedding = Logarithmic<1, 1>,
)]
struct Rotating;

#[hamiltonian(
    drift = [|[x, y], _| -1.0 / (x * x + y * y).sqrt(), |_, [px, py]| 0.5 * (px * px + py * py)],
    embedding = Logarithmic<1, 1>,
)]
struct PartsInOtherOrder;
