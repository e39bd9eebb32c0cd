#[hamiltonian(
    drift = |q, p| q * p,
    embedding = [Lambda<3, 2>, Lambda<1, 0>, Lambda<-1, 2>, Lambda<N, 2>, Lambda<1>, Lambda, Midpoint<1>],
)]
struct System;
