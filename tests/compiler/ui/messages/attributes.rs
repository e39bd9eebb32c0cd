#[hamiltonian(
    drift = |q, p| {
        let k = 1.0;
        #[cfg(any())]
        let k = 4.0;
        #[allow(unused)]
        #[rustfmt::skip]
        let unused = 1.0;
        /// The well.
        let v = match n {
            #[cfg(any())]
            0 => 1.0,
            #[cfg_attr(all(), cfg(any()))]
            1 => 2.0,
            _ => 3.0,
        };
        let list = [#[cfg(any())] q, p];
        let tuple = (#[cfg(any())] 4.0, 5.0);
        let f = |#[cfg(any())] x: f64, y: f64| y;
        let x = { #![cfg(any())] q };
        let s = self.energy(#[cfg(any())] q, p);
        let chosen = if q > 0.0 { #[cfg(any())] { 1.0 } } else { 2.0 };
        #[instrument]
        let z = vec![#[cfg(any())] 1.0];
        0.5 * (p * p + k * q * q)
    },
    noise = [#[cfg(any())] |q, p| q, |q, p| p],
    #[cfg(any())]
    force = |q, p| -p,
    embedding = [Midpoint, #[cfg(any())] Verlet],
)]
#[cfg(any())]
struct System<#[cfg(any())] const N: usize>;

#[hamiltonian(drift = |q, p| 0.5 * p * p + k[0] * q, embedding = Midpoint)]
#[cfg_attr(feature = "serde", derive(Serialize))]
struct Twice {
    #[cfg(any())]
    k: [f64; 3],
    #[cfg(not(any()))]
    k: [f64; 4],
    #[cfg(any())]
    label: String,
}

#[hamiltonian(drift = |q, p| 0.5 * p * p + self.0 * q, embedding = Midpoint)]
struct Unnamed(#[cfg(any())] [f64; 2], f64);

#[hamiltonian_fn]
#[inline]
#[must_use]
#[cfg(any())]
fn stiffness(q: f64) -> f64 {
    #[cfg(any())]
    let q = 4.0 * q;
    q
}

#[hamiltonian_fn]
#[instrument(level = "debug")]
fn traced(q: f64) -> f64 {
    q
}

#[hamiltonian_fn]
impl System {
    #[cfg(any())]
    const K: f64 = 1.0;

    #[cfg(any())]
    fn energy(&self, q: f64) -> f64 {
        q
    }

    #[inline]
    fn other(&self, #[cfg(any())] q: f64) -> f64 {
        Self::K
    }
}
