//! Closures whose size has any spelling, for the tests of the seam and its bench: `kubo!(Name, [generics], state, count)`
//! is a struct `Name` whose coordinates and momenta are a `state` of `count` sites.

/// Oscillators whose frequencies diffuse: sites that are not coupled.
macro_rules! kubo {
    ($name:ident, [$($generics:tt)*], $state:ty, $count:expr) => {
        #[hamiltonian(
            drift = |q: $state, p: $state| (0..q.len()).map(|i| 0.5 * a * (q[i] * q[i] + p[i] * p[i])).sum::<f64>(),
            noise = [|q, p, k| 0.5 * s * (q[k] * q[k] + p[k] * p[k]); $count],
            embedding = [Midpoint],
            invariant = |q, p| q.iter().zip(p.iter()).map(|(q, p)| q * q + p * p).sum::<f64>(),
        )]
        pub(crate) struct $name$($generics)* {
            pub(crate) a: f64,
            pub(crate) s: f64,
            #[allow(dead_code, reason = "only slices ask for it")]
            pub(crate) sites: usize,
        }
    };
}

/// A Fermi-Pasta chain between walls.
macro_rules! chain {
    ($name:ident, [$($generics:tt)*], $state:ty, $count:expr) => {
        #[hamiltonian(
            drift = |q: $state, p: $state| {
                let v = |d: f64| 0.5 * d * d + 0.25 * a * d.powi(4);
                let n = q.len();
                p.iter().map(|p| 0.5 * p * p).sum::<f64>()
                    + (1..n).map(|i| v(q[i] - q[i - 1])).sum::<f64>()
                    + v(q[0]) + v(q[n - 1])
            },
            embedding = [DeltaPlus, Midpoint],
        )]
        pub(crate) struct $name$($generics)* {
            pub(crate) a: f64,
            #[allow(dead_code, reason = "others read it")]
            pub(crate) s: f64,
            #[allow(dead_code, reason = "others read it")]
            pub(crate) sites: usize,
        }
    };
}

/// Every site repels every other one.
macro_rules! pairs {
    ($name:ident, [$($generics:tt)*], $state:ty, $count:expr) => {
        #[hamiltonian(
            drift = |q: $state, p: $state| {
                let n = q.len();
                (0..n).map(|i| 0.5 * (p[i] * p[i] + q[i] * q[i])).sum::<f64>()
                    + (0..n).map(|i| (0..i).map(|j| a / (1.0 + (q[i] - q[j]).powi(2))).sum::<f64>()).sum::<f64>()
            },
            embedding = [DeltaPlus, Midpoint],
        )]
        pub(crate) struct $name$($generics)* {
            pub(crate) a: f64,
            #[allow(dead_code, reason = "others read it")]
            pub(crate) s: f64,
            #[allow(dead_code, reason = "others read it")]
            pub(crate) sites: usize,
        }
    };
}

/// A chain of which every site is pushed.
macro_rules! pushed {
    ($name:ident, [$($generics:tt)*], $state:ty, $count:expr) => {
        #[hamiltonian(
            drift = |q: $state, p: $state| {
                (0..q.len()).map(|i| 0.5 * p[i] * p[i] + 0.25 * q[i].powi(4)).sum::<f64>()
                    + (1..q.len()).map(|i| 0.5 * a * (q[i] - q[i - 1]).powi(2)).sum::<f64>()
            },
            noise = [|q, p, k| s * q[k]; $count],
            embedding = [DeltaPlus, Midpoint],
        )]
        pub(crate) struct $name$($generics)* {
            pub(crate) a: f64,
            pub(crate) s: f64,
            #[allow(dead_code, reason = "only slices ask for it")]
            pub(crate) sites: usize,
        }
    };
}
