#[hamiltonian(drift = |q, p| q * p, noise = [], invariant = [], embedding = [])]
struct Empty;

#[hamiltonian(drift = |q, p| q * p, noise = , embedding = Midpoint, crate = "wzvi")]
struct Missing;

#[hamiltonian(drift = |q, p| q * p, drift = |q, p| q, embedding = Midpoint, embedding = DeltaPlus)]
struct Twice;

#[hamiltonian(drift = |q, p| q * p embedding = Midpoint)]
struct Comma;

#[hamiltonian(drift = |q, p| q *, embedding = Midpoint)]
struct Unfinished;
