#[hamiltonian(drift = |q, p| q.sine() + p.pow(2) + f64::coss(q) + [q, p].iter().summ(), embedding = Midpoint)]
struct System;
