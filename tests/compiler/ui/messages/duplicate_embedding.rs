#[hamiltonian(drift = |q, p| q * p, embedding = [Midpoint, DeltaPlus, Midpoint, Lambda<1, 3>, Lambda<1, 3>])]
struct System;
