#[hamiltonian(drift = |q, p| a * q + label * p + pair.0 * q + t * p, embedding = Midpoint)]
struct System<T> {
    a: std::rc::Rc<f64>,
    label: String,
    pair: (f64, f64),
    t: T,
}
