#[hamiltonian]
struct Bare;

#[hamiltonian()]
struct Empty;

#[hamiltonian(|q, p| q * p)]
struct Positional;
