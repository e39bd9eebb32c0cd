#[hamiltonian(
    drift = |q, p| {
        let b = match n { k => q * k as f64 };
        let c = match n { 0.5 => q, _ => p };
        let d = match n { 0 => (q, p), _ => p };
        let e = match n { 0 if q => q, _ => p };
        let mut s = q;
        s /= 0.0;
        match n { 0 => s = p, _ => {} };
        mass = 1.0;
        let (x, y) = q;
        let f = |x| x;
        b + c + f(q, p) + q.powi(1, 2) + q / (1.0 - 1.0) + (q - q) / (p - p)
            + if q > p { (q, p).0 } else { 1 } + [q, p].iter().filter(|x| **x > 0.0).product::<f64>()
    },
    embedding = Midpoint,
)]
struct Branches {
    n: i32,
    mass: f64,
}

#[hamiltonian(drift = |q, p| { return q; }, embedding = Midpoint)]
struct Returned;

#[hamiltonian(drift = |q, p| 1, embedding = Midpoint)]
struct Integer;

#[hamiltonian(drift = |q, p| (p, -q), embedding = Midpoint)]
struct Field;
