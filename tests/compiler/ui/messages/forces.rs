//! Forces of the wrong shape, friction without masses, temperatures without friction, and schemes that have no place for them.

#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py),
    force = |[x, y], [px, py]| [-x, -y, 0.0],
    embedding = Midpoint,
)]
struct TooLong;

#[hamiltonian(drift = |q, p| 0.5 * p * p, force = |q, p| [-q], embedding = Midpoint)]
struct ListForNumber;

#[hamiltonian(drift = |[x, y], [px, py]| 0.5 * (px * px + py * py), force = |[x, y], [px, py]| -x, embedding = Midpoint)]
struct NumberForList;

#[hamiltonian(drift = |q, p| 0.5 * p * p, force = |q| -q, embedding = Midpoint)]
struct OneParameter;

#[hamiltonian(drift = |q, p| 0.5 * p * p, force = |q, p| -gama * p, embedding = Midpoint)]
struct Misspelt {
    gamma: f64,
}

#[hamiltonian(drift = |q, p| p.cosh() + q * q, friction = 0.1, embedding = Midpoint)]
struct NoMasses;

#[hamiltonian(drift = |q, p| 0.5 * p * p, temperature = 1.0, embedding = Midpoint)]
struct NoFriction;

#[hamiltonian(drift = |q, p| 0.5 * p * p, friction = 0.1, temperature = 1.0, embedding = [Baoab, Midpoint])]
struct NoThermostat;

#[hamiltonian(drift = |q, p| 0.5 * p * p, embedding = Baoab)]
struct NothingToHeat;

#[hamiltonian(drift = |q, p| 0.5 * p * p + 0.5 * q * q, force = |q, p| -q * p, friction = 0.1, embedding = [Baoab, Thermostat<Midpoint>])]
struct NotSeparable;

#[hamiltonian(drift = |[x, y], [px, py]| 0.5 * (px * px + py * py), damping = [[1.0, 0.2], [0.3, 1.0]], embedding = Midpoint)]
struct Asymmetric;

#[hamiltonian(drift = |[x, y], [px, py]| 0.5 * (px * px + py * py), damping = |[x, y]| [[1.0, a[0] * x], [b * x, 1.0]], embedding = Midpoint)]
struct DampingOfPlace {
    a: [f64; 1],
    b: f64,
}

#[hamiltonian(drift = |[x, y], [px, py]| 0.5 * (px * px + py * py), damping = |q, p| [[1.0, 0.0], [0.0, 1.0]], embedding = Midpoint)]
struct DampingOfMomenta;

#[hamiltonian(drift = |[x, y], [px, py]| 0.5 * (px * px + py * py + px * py), friction = [1.0, 0.2], embedding = Midpoint)]
struct Coupled;

#[hamiltonian(drift = |q, p| 0.5 * p * p, friction = 0.1, damping = [[1.0]], embedding = Midpoint)]
struct Twice;

#[hamiltonian(drift = |q, p| 0.5 * p * p, friction = |q, p| q, embedding = Midpoint)]
struct FrictionOfMomenta;

#[hamiltonian(drift = |q, p| 0.5 * p * p, noise_force = |q, p| sigma * p, embedding = DeltaPlus)]
struct Inconsistent {
    sigma: f64,
}

#[hamiltonian(drift = |q, p| 0.5 * p * p, noise_force = |q, p| p, embedding = Corrected<DeltaPlus>)]
struct NoCounterTerm;

#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py),
    force = |[x, y], [px, py]| [-px, -py],
    invariant = |[x, y], [px, py]| x * py - y * px,
    embedding = Midpoint,
)]
struct Drawn;

#[hamiltonian(drift = [|q, p| 0.5 * p * p, |q, p| q * q], force = |q, p| -p, embedding = Verlet)]
struct Parted;

#[hamiltonian(drift = |q, p| 0.5 * p * p, friction = 0.1, embedding = Thermostat<Baoab>)]
struct Nested;

/// Temperatures that differ need a friction that couples no momenta: not zero is what the text says, whatever
/// `c` will be.
#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py),
    damping = [[1.0, c], [c, 2.0]],
    temperature = [1.0, 2.0],
    embedding = Baoab,
)]
struct Coupled {
    c: f64,
}
