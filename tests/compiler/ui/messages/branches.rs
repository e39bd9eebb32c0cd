#[hamiltonian(
    drift = |q, p| {
        let mut s = 0.0;
        if q > 0.0 {
            s = 1.0;
        }
        let a = if q > 0.0 { p };
        let b = if q > 0.0 { p } else { (p, p) };
        let c = if q { 1.0 } else { 2.0 };
        let d = q > 0.0 && p;
        let e = !q;
        a + b + c + s
    },
    embedding = Midpoint,
)]
struct System;
