#[hamiltonian(
    drift = |q, p| q * p,
    embedding = [
        Corrected<Uncorrected<DeltaPlus>>,
        Mixed<Corrected<DeltaPlus>, Midpoint>,
        Mixed<Mixed<DeltaPlus, Midpoint>, Midpoint>,
        Corrected<3>,
        Corrected,
        Mixed<DeltaPlus>,
        &Midpoint,
        fn(),
        Corrected<Verlet>,
        Mixed<Gauss<2>, Midpoint>,
        Uncorrected<Thermostat<Midpoint>>,
    ],
)]
struct System;
