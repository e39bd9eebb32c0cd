#[hamiltonian(
    drift = |q, p| {
        let f = |x: f64, y: f64| x * y;
        let v = q.sin(p) + f(q) + f64::atan2(q) + q.clamp(0.0) + q(p) + f + potential(q) + wzvi_user::potential(p);
        let (a, b, c) = (q, p);
        let [d, e] = [q, p, q];
        v + a + b + c + d + e + (q, p) + [q] + (q > p)
    },
    embedding = Midpoint,
)]
struct System;
